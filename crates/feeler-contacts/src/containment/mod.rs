//! What is inside what, though no triangles meet.

pub(crate) mod find;
mod ray_crossings;
mod tool_solid;
