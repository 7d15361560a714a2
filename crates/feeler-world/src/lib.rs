//! The moving tool with the part that it grips, and its surroundings: the parts of a mock-up, some of them put down elsewhere. One
//! query asks all of them.
//!
//! A [`World`] is made of a [`Scene`](feeler_core::Scene) and a tool. The tool grips parts, moves as far as that is free, and releases
//! them:
//!
//! ```
//! use std::sync::Arc;
//!
//! use feeler_core::{Mockup, Pose, Scene, SceneOptions, Tool};
//! use feeler_world::{Release, WalkOptions, World};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! // Part 0: a square plate of 20 cm. Part 1: a tent with its floor 1 cm above the plate and its top at 3 cm.
//! let plate = [[-0.1, -0.1, 0.0], [0.1, -0.1, 0.0], [0.1, 0.1, 0.0], [-0.1, 0.1, 0.0]];
//! let tent = [[0.0, 0.0, 0.03], [0.02, 0.0, 0.01], [-0.01, 0.02, 0.01], [-0.01, -0.02, 0.01]];
//! let faces = vec![[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7], [4, 7, 5], [5, 7, 6]];
//! let mockup = Mockup::new([plate, tent].concat(), faces, vec![0, 0, 1, 1, 1, 1], 2)?;
//! let spike = vec![[0.0, 0.0, 0.0], [0.01, 0.0, 0.02], [-0.01, 0.01, 0.02], [-0.01, -0.01, 0.02]];
//! let tool = Tool::new(spike, vec![[0, 2, 1], [0, 3, 2], [0, 1, 3], [1, 2, 3]])?;
//! let scene = Scene::build(Arc::new(mockup), &SceneOptions::default())?;
//!
//! // The tip 1 cm above the tent's top.
//! let at = |z: f64| Pose::IDENTITY.translated(&[0.0, 0.0, z]);
//! let mut world = World::new(Arc::new(scene), Arc::new(tool), &[])?;
//! world.move_to(&at(0.04)?)?;
//! world.grip(&[1], &at(0.04)?)?;
//!
//! // With the tent it moves 1 cm down, to the plate.
//! let around = world.around();
//! let walk = around.walk(&around.seated_at_start(), (&at(0.04)?, &at(0.0)?), WalkOptions::default())?;
//! assert_eq!(walk.stop.map(|stop| stop.part), Some(0));
//! assert!((walk.pose.translation()[2] - 0.03).abs() < 1e-5);
//!
//! world.release(Release::Here, &walk.pose)?;
//! assert_eq!(world.moved().collect::<Vec<_>>(), [1]);
//! # Ok(())
//! # }
//! ```
//!
//! Lengths are metres; poses are `world_from_tool`.

mod ask;
mod constants;
mod deeper;
mod environment;
mod error;
mod seats;
mod solid;
mod stop;
mod sunk;
mod surfaces;
mod surroundings;
mod walk;
mod world;

pub use environment::{Environment, Plane, PutDown};
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
pub use environment::{Body, Pair};
#[doc(hidden)]
pub use sunk::SunkPlane;
#[doc(hidden)]
pub use walk::Span;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
