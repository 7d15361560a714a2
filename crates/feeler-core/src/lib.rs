//! Exact collision detection of a moving tool against a large static mock-up of triangles.
//!
//! A [`Mockup`] and a [`Tool`] are checked meshes; a [`Scene`] is a mock-up with an index; each query takes a tool and a [`Pose`]:
//!
//! | question | query | for many poses |
//! |---|---|---|
//! | which pairs of triangles meet | [`Scene::collide`] | [`Scene::collide_batch`] |
//! | does anything meet | [`Scene::is_colliding`] | |
//! | how far is the nearest part, or the `k` nearest | [`Scene::distance`], [`Scene::nearest`] | [`Scene::distance_batch`] |
//! | which parts, or pairs of triangles, are nearer than a limit | [`Scene::clearance`], [`Scene::near_pairs`] | [`Scene::clearance_batch`], [`Scene::near_pairs_batch`] |
//! | where on the way between two poses is the first impact | [`Scene::cast`] | [`Scene::check_path`] |
//! | what does a ray meet first | [`Scene::ray`] | [`Scene::rays`] |
//! | what does a plane cut | [`Scene::section`] | |
//!
//! [`Mockup::pack`] makes pieces for drawing. Contact planes and penetration are in the crate `feeler-contacts`.
//!
//! ```
//! use std::sync::Arc;
//!
//! use feeler_core::{Mockup, PairKind, Pose, Scene, SceneOptions, Tool};
//!
//! # fn main() -> feeler_core::Result<()> {
//! // A square plate of 2 m, and a spike of 20 cm with its tip at the tool's origin.
//! let plate = vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];
//! let mockup = Mockup::new(plate, vec![[0, 1, 2], [0, 2, 3]], vec![], 1)?;
//! let spike = vec![[0.0, 0.0, 0.0], [0.1, 0.0, 0.2], [-0.1, 0.1, 0.2], [-0.1, -0.1, 0.2]];
//! let tool = Tool::new(spike, vec![[0, 2, 1], [0, 3, 2], [0, 1, 3], [1, 2, 3]])?;
//!
//! let scene = Scene::build(Arc::new(mockup), &SceneOptions::default())?;
//!
//! // The tip 5 cm below the plate: its three sides go through triangle 0.
//! let pose = Pose::IDENTITY.translated(&[0.3, -0.3, -0.05])?;
//! let hit = scene.collide(&tool, &pose);
//! assert_eq!(hit.pairs, [[0, 0], [1, 0], [2, 0]]);
//! assert!(hit.kinds.iter().all(|kind| *kind == PairKind::Crossing));
//! # Ok(())
//! # }
//! ```
//!
//! # Conventions
//!
//! - Lengths are metres, frames right-handed; a pose is `world_from_tool`, and the world is the mock-up's frame.
//! - A triangle's id is its place in the faces given; a part's id is its place among the parts.
//! - A pair is reported if and only if exact rational arithmetic says that the two closed triangles meet, on the mock-up's
//!   corners as given and the tool's corners as [`Pose::apply`] computes them. The order of results is part of each query's
//!   promise; neither depends on the store, the voxel size, the number of threads or the instruction set.
//! - Triangles that cannot be queried are listed in [`Mesh::defects`], never dropped in silence. Wrong input is an [`Error`] that
//!   says what, where and what to do.
//! - A scene is immutable: any number of threads may query it at once. Building and queries for many poses use the current rayon
//!   pool. This crate knows no clock, no files and no global state.

#![deny(unsafe_code)]

mod bodies;
mod cast;
mod chunks;
#[doc(hidden)]
pub mod clash;
mod collide;
#[doc(hidden)]
pub mod constants;
#[doc(hidden)]
pub mod distance;
mod error;
#[doc(hidden)]
pub mod geometry;
#[doc(hidden)]
pub mod index;
#[cfg(any(feature = "glam", feature = "nalgebra"))]
mod interop;
#[doc(hidden)]
pub mod mesh;
mod progress;
mod rays;
#[doc(hidden)]
pub mod saved;
mod scene;
#[doc(hidden)]
pub mod scratch_pool;
mod section;
mod setters;
mod sizing;
mod stoppable;
#[doc(hidden)]
pub mod tool;

pub use bodies::set::{Bodies, BodyContact, BodyGap, Who};
pub use bodies::shape::Shape;
#[doc(hidden)]
pub use bodies::two_bodies::ToolAndMockup;
pub use cast::impact::{Cast, Touching};
pub use cast::options::{CastOptions, PathOptions};
pub use cast::path::PathCheck;
pub use chunks::packed::{Packed, PackedPiece, PartNumbers};
pub use chunks::shared::{SharedPiece, Sharing};
pub use clash::asked::{PairLimitTables, PairLimits};
pub use collide::batch::Batch;
pub use collide::narrow::Filters;
pub use collide::query::Collision;
pub use distance::along::{GapSpan, LeastGap};
pub use distance::batch::GapBatch;
pub use distance::gap::Gap;
pub use error::{Error, Result};
#[doc(inline)]
pub use feeler_lanes::Level;
pub use geometry::bounds::{Aabb, Point, Triangle};
pub use geometry::distance_triangle_triangle::{closest_triangle_triangle, Closest};
pub use geometry::intersect_triangle_triangle::{intersect_triangle_triangle, PairKind};
pub use geometry::pose::Pose;
pub use geometry::twist::{Twist, Wrench};
pub use index::selection::{IgnoredPairs, SurfaceNumbers};
pub use index::sink::Stats;
pub use index::store::Storage;
pub use mesh::defects::{Defect, DefectKind, Defects};
pub use mesh::mockup::Mockup;
#[doc(hidden)]
pub use mesh::topology::edges::wedges;
pub use mesh::triangle_mesh::Mesh;
pub use mesh::weld::weld_vertices;
#[doc(hidden)]
pub use progress::Pace;
pub use progress::{BatchOptions, GoOn, Progress};
pub use rays::ray::{HalfSpace, Ray, RayHit};
pub use scene::{Scene, SceneOptions};
pub use section::outline::SectionOutline;
pub use sizing::choice::{default_voxel_size, optimal_voxel_size};
pub use sizing::cost::Estimator;
pub use sizing::cost_constants::CostConstants;
pub use sizing::piece_predictor::{PiecePredictor, PieceWork};
pub use sizing::predictor::Predictor;
pub use sizing::work::Work;
pub use stoppable::StoppableScene;
pub use tool::chain::{Chain, Joint};
pub use tool::leg::Leg;
pub use tool::motion::{Chord, Motion};
pub use tool::moving_tool::Tool;
pub use tool::screw::Screw;

// Plain twins of the queries, for tests and judges.
#[doc(hidden)]
pub use cast::brute::cast_all_pairs;
#[doc(hidden)]
pub use collide::brute::collide_all_pairs;
#[doc(hidden)]
pub use distance::brute::gaps_of_all_pairs;
#[doc(hidden)]
pub use rays::brute::first_of_all;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
