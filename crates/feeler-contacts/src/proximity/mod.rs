//! Proximity: planes between surfaces that are near and do not meet.

mod cull;
pub(crate) mod separating_planes;
