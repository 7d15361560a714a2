//! A hand that feels: a tool held by a haptic device, kept out of a large static triangle mock-up, and the force of that on the hand.
//!
//! Lengths are metres, angles radians, forces newtons; poses are `world_from_tool`. Time is passed in, in seconds: nothing here reads
//! a clock.

mod constants;
pub mod device;
mod error;
pub mod screw;

pub use error::{Error, Result};
