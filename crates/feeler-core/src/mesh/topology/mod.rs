//! How the triangles of a mesh hang together: found once for a mesh, when a query first needs it.

pub mod adjacency;
mod convex_bodies;
mod crack_stitching;
pub mod disjoint_sets;
mod edges;
pub mod smooth_regions;
