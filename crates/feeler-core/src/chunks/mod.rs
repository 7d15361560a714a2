//! Meshes for drawing: few large pieces with 16-bit indices, the part of each vertex, positions in float32.

pub mod pack;
pub mod packed;
mod runs;
pub mod shared;
mod weld;
