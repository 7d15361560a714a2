//! What is inside what, though no triangles meet.

pub(crate) mod find;
pub mod tool_solid;
