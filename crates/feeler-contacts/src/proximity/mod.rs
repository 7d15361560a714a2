//! Proximity: planes between surfaces that are near and do not collide.

mod cull;
pub(crate) mod separating_planes;
