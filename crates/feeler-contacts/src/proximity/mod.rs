//! Proximity: planes for what is near and does not meet.

mod cull;
pub(crate) mod separating_planes;
