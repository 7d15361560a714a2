//! Many bodies that move, each against each: boxes first, then pairs of bodies by the queries of one tool in one scene,
//! with both placed.

pub(crate) mod body;
mod closest;
mod convexity;
mod near_boxes;
mod relative;
pub(crate) mod set;
pub(crate) mod shape;
mod solid;
pub(crate) mod two_bodies;
