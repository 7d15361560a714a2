//! What is inside what, though no triangles meet.

pub(crate) mod find;
mod tool_solid;
