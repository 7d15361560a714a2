//! The topology of a mesh: adjacency, closed surfaces and smooth regions. Computed once for a mesh, when a query first
//! needs it.

pub mod adjacency;
pub mod body_outlines;
pub(crate) mod closed_shells;
mod convex_bodies;
mod crack_stitching;
pub mod disjoint_sets;
pub(crate) mod edges;
pub mod smooth_regions;
