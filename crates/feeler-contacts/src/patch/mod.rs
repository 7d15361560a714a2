//! Patches: the two surfaces of a contact region as a few planes and turns, and the convex bodies these make.

pub(crate) mod body;
mod connected_components;
pub(crate) mod convex_bodies;
mod extents;
mod half_space_filter;
mod half_spaces;
pub(crate) mod patches;
pub(crate) mod support;
mod surface_patch;
