//! Exact collision detection of a moving tool against a large static mock-up.
//!
//! The flow: a [`Mockup`] and a [`Tool`] are checked meshes; a [`Scene`] is a mock-up with an index; a query takes a tool
//! and a [`Pose`] and finds every pair of triangles that meets, exactly. The core knows no files, clocks or Python.

#![deny(unsafe_code)]

pub mod bounds;
pub mod brute;
pub mod cast;
pub mod constants;
pub mod contacts;
pub mod cost;
pub mod defects;
mod distance_lanes;
pub mod distance_triangle_triangle;
pub mod error;
pub mod grid;
mod hits;
pub mod intersect_lanes;
pub mod intersect_triangle_triangle;
mod lanes;
mod median;
pub mod mesh;
mod narrow;
pub mod pieces;
pub mod pose;
pub mod predicates;
pub mod predict;
mod proximity;
pub mod scene;
mod simd;
mod spare;
mod store;
pub mod tool;
mod vectors;
pub mod weld;

pub use bounds::{Aabb, Point, Triangle};
pub use brute::collide_all_pairs;
pub use cast::{cast_all_pairs, Cast, Motion, PathCheck};
pub use contacts::{ContactPlane, ContactTracker, Contacts, Penetration, PenetrationKind};
pub use cost::Estimator;
pub use defects::{Defect, DefectKind, Defects};
pub use distance_triangle_triangle::{closest_triangle_triangle, Closest};
pub use error::{Error, Result};
pub use intersect_triangle_triangle::{intersect_triangle_triangle, PairKind};
pub use mesh::{Mesh, Mockup};
pub use narrow::{Filters, Stats};
pub use pose::Pose;
pub use predict::{CostConstants, PiecePredictor, Predictor};
pub use proximity::{gaps_of_all_pairs, Gap, GapBatch};
pub use scene::{default_voxel_size, optimal_voxel_size, Batch, Collision, Scene, SceneOptions, Scratch};
pub use simd::Level;
pub use store::{Progress, Storage};
pub use tool::Tool;
pub use weld::weld_vertices;
