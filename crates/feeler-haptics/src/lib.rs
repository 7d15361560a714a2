//! A hand that feels: a tool held by a haptic device, kept out of a large static triangle mock-up, and the force of that on the hand.
//!
//! Lengths are metres, angles radians, forces newtons; poses are `world_from_tool`. Time is passed in, in seconds: nothing here reads
//! a clock.

mod constants;
pub mod constraint_set;
pub mod device;
pub mod environment;
mod error;
pub mod least_distance;
pub mod metric;
pub mod proxy;
pub mod screw;

pub use error::{Error, Result};
