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

pub use ask::least_distance;
pub use constants::SEAT_REST;
pub use environment::{Body, Environment, Pair, Plane, PutDown};
pub use error::{Error, Result};
pub use seats::{Allowed, Seat, SeatKind, Seated};
pub use stop::{GuardedMove, Impact, Moved};
pub use sunk::SunkPlane;
pub use surroundings::Surroundings;
pub use walk::{Care, Span, Stop, Walk};
pub use world::{Grip, World};

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
