//! A hand that feels: a tool held by a haptic device, kept out of a large static triangle mock-up, and the force of that on the hand.
//!
//! Lengths are metres, angles radians, forces newtons; poses are `world_from_tool`. Time is passed in, in seconds: nothing here reads
//! a clock but the one that a [`Runner`] is given.

pub mod clock;
mod constants;
pub mod constraint_set;
mod coupling;
pub mod device;
pub mod environment;
mod error;
mod force;
pub mod least_distance;
pub mod metric;
mod passivity;
pub mod proxy;
pub mod runner;
mod saturation;
pub mod screw;
mod servo;
mod session;
mod stability;
pub mod statistics;
mod velocity;
pub mod world;

pub use clock::Clock;
pub use coupling::Coupling;
pub use error::{Error, Result};
pub use force::{ForceInput, ForceLoop};
pub use passivity::Passivity;
pub use runner::{Runner, RunnerOptions};
pub use saturation::{added_within, saturated};
pub use servo::{Mode, Servo, ServoInput, ServoOutput};
pub use session::{Session, SessionOptions, Start, Step};
pub use stability::{Bound, Limitation, Limitations};
pub use statistics::Statistics;
pub use velocity::VelocityEstimate;
