//! Meshes as given, what is wrong with them, how their triangles are cut and ordered, and how they hang together.

pub mod defects;
pub mod median;
pub mod mockup;
pub mod pieces;
pub mod topology;
pub mod triangle_mesh;
pub mod weld;
