//! Meshes as given, their defects, the cutting and ordering of their triangles, and their connectivity.

pub(crate) mod defects;
pub(crate) mod median;
pub mod mockup;
pub(crate) mod moved;
pub(crate) mod part_numbers;
pub(crate) mod pieces;
pub mod topology;
pub(crate) mod triangle_mesh;
pub(crate) mod weld;
