//! Ways out: removal of a part from a large triangle mock-up, and the volume that a motion sweeps.
//!
//! Lengths are metres, angles radians; poses are `world_from_tool`, and the world is the mock-up's frame. Nothing here reads a clock:
//! a time limit is a function that is asked whether to go on.

mod blocked;
mod constants;
mod eigen;
mod error;
mod linear_program;
mod random;
mod removal;
mod swept;

pub use blocked::Blocker;
pub use error::{Error, Result};
pub use feeler_world::Allowed;
pub use removal::{removal, Held, Method, Removal, RemovalOptions, RemovalTask};
pub use swept::sweep::{swept, Swept, SweptOptions};

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
