//! Containment without colliding triangles.

pub(crate) mod find;
pub mod tool_solid;
