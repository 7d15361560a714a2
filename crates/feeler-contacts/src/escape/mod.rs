//! Escape: the shortest translation that frees the tool, also from the inside of a solid.

pub(crate) mod escape_probe;
pub(crate) mod min_norm;
pub(crate) mod penetration;
