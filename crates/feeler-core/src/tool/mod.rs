//! A moving tool: its triangles under a shallow tree of boxes, its places at a pose, its motion between two.

pub(crate) mod chain;
pub(crate) mod leg;
pub mod metric;
pub(crate) mod motion;
pub(crate) mod moving_tool;
pub(crate) mod placement;
pub(crate) mod screw;
pub mod surface_links;
