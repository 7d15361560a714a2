//! Meshes as given, what is wrong with them, how their triangles are cut and ordered, and how they hang together.

pub(crate) mod defects;
pub(crate) mod median;
pub mod mockup;
pub(crate) mod part_numbers;
pub(crate) mod pieces;
pub mod topology;
pub(crate) mod triangle_mesh;
pub(crate) mod weld;
