//! Colliding triangles: candidate pairs of the index, decided by the exact triangle test.

pub(crate) mod batch;
pub(crate) mod brute;
pub(crate) mod hits;
pub mod narrow;
pub(crate) mod query;
pub(crate) mod touching;
