//! Escape: the shortest way out of what the tool meets, and what is wholly inside a solid.

pub(crate) mod containment;
pub(crate) mod escape_probe;
mod min_norm;
pub(crate) mod penetration;
