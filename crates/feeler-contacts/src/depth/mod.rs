//! Depth: the axis along which two bodies have to move least until a plane separates them.

pub(crate) mod axis;
mod axis_blocked;
mod axis_search;
mod descent;
mod directional_overlap;
mod dominated_by;
mod edge_axes;
pub(crate) mod face_axes;
mod gauss_arcs;
pub(crate) mod least_depth;
pub(crate) mod piercing;
pub(crate) mod region_bodies;
pub(crate) mod region_depths;
