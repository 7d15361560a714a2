//! What moves, and what stands around it: a tool, the part that it grips, and the parts of a mock-up, some of which were put down
//! elsewhere. Everything is asked of all of them at once.
//!
//! Lengths are metres; poses are `world_from_tool`.

mod environment;
mod error;
mod world;

pub use environment::{Body, Environment, Impact, Pair, Plane};
pub use error::{Error, Result};
pub use world::{Grip, PutDown, Seat, World};

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
