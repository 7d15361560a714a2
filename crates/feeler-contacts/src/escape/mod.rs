//! Escape: the shortest translation that frees the tool, and what lies wholly inside a solid.

pub(crate) mod escape_probe;
pub(crate) mod min_norm;
pub(crate) mod penetration;
