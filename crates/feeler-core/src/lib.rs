//! Exact collision detection of a moving tool against a large static mock-up.
//!
//! The flow: a [`Mockup`] and a [`Tool`] are checked meshes; a [`Scene`] is a mock-up with an index; a query takes a tool
//! and a [`Pose`] and finds every pair of triangles that meets, exactly. The core knows no files, clocks or Python.

#![deny(unsafe_code)]

#[doc(hidden)]
pub mod cast;
#[doc(hidden)]
pub mod collide;
#[doc(hidden)]
pub mod constants;
#[doc(hidden)]
pub mod distance;
mod error;
#[doc(hidden)]
pub mod geometry;
#[doc(hidden)]
pub mod index;
#[doc(hidden)]
pub mod mesh;
mod progress;
mod scene;
#[doc(hidden)]
pub mod scratch_pool;
#[doc(hidden)]
pub mod sizing;
#[doc(hidden)]
pub mod tool;

pub use cast::brute::cast_all_pairs;
pub use cast::impact::Cast;
pub use cast::path::PathCheck;
pub use collide::batch::Batch;
pub use collide::brute::collide_all_pairs;
pub use collide::narrow::Filters;
pub use collide::query::Collision;
pub use distance::batch::GapBatch;
pub use distance::brute::gaps_of_all_pairs;
pub use distance::gap::Gap;
pub use error::{Error, Result};
pub use feeler_lanes::Level;
pub use geometry::bounds::{Aabb, Point, Triangle};
pub use geometry::distance_triangle_triangle::{closest_triangle_triangle, Closest};
pub use geometry::intersect_triangle_triangle::{intersect_triangle_triangle, PairKind};
pub use geometry::pose::Pose;
pub use index::sink::Stats;
pub use index::store::Storage;
pub use mesh::defects::{Defect, DefectKind, Defects};
pub use mesh::mockup::Mockup;
pub use mesh::triangle_mesh::Mesh;
pub use mesh::weld::weld_vertices;
pub use progress::Progress;
pub use scene::{Scene, SceneOptions};
pub use sizing::choice::{default_voxel_size, optimal_voxel_size};
pub use sizing::cost::Estimator;
pub use sizing::cost_constants::CostConstants;
pub use sizing::piece_predictor::PiecePredictor;
pub use sizing::predictor::Predictor;
pub use tool::motion::Motion;
pub use tool::moving_tool::Tool;
