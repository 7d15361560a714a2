//! Patches: each of the two surfaces of a contact region as a few planar or nearly planar patches, grouped into convex
//! bodies.
//!
//! From the triangles of a contact region to the input of the depth search: fragments ([`surface_patch`]) are grown
//! into patches ([`patches`], [`connected_components`], [`extents`]), patches are grouped into convex bodies
//! ([`convex_bodies`] by [`half_space_filter`] and [`half_spaces`]), and bodies are laid out in lanes ([`body`],
//! [`support`]).

pub(crate) mod body;
mod connected_components;
pub(crate) mod convex_bodies;
mod extents;
mod half_space_filter;
mod half_spaces;
mod patch_lanes;
pub(crate) mod patches;
pub(crate) mod support;
mod surface_patch;
