//! The moving tool with the part that it grips, and its surroundings: the parts of a mock-up, some of them put down elsewhere. One
//! query asks all of them.
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
