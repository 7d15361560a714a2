//! The moving tool with the part that it grips, and its surroundings: the parts of a mock-up, some of them put down elsewhere. One
//! query asks all of them.
//!
//! Lengths are metres; poses are `world_from_tool`.

mod ask;
mod constants;
mod environment;
mod error;
mod seats;
mod stop;
mod sunk;
mod surfaces;
mod surroundings;
mod walk;
mod world;

pub use environment::{Body, Environment, Plane, PutDown};
pub use error::{Error, Result};
pub use seats::{Allowed, Seat, SeatKind, Seated};
pub use stop::{GuardedMove, Impact, Moved};
pub use surroundings::Surroundings;
pub use walk::{Stop, Walk, WalkOptions};
pub use world::{Grip, Release, World};

// For the crates of feeler that stand above this one.
#[doc(hidden)]
pub use ask::least_distance;
#[doc(hidden)]
pub use constants::SEAT_REST;
#[doc(hidden)]
pub use environment::Pair;
#[doc(hidden)]
pub use sunk::SunkPlane;
#[doc(hidden)]
pub use walk::Span;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
