//! A moving tool: its triangles under a shallow tree of boxes, its places at a pose, its way between two.

pub mod motion;
pub mod moving_tool;
pub mod placement;
pub mod surface_links;
