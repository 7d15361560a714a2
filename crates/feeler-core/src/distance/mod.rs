//! How far: pairs of triangles nearer than a distance, the gap to each part, the closest parts.
//!
//! One search serves all: tool tree and mock-up tree are descended together, nearest pairs of boxes first, and a pair of
//! boxes farther apart than what is still of interest is dropped.

pub(crate) mod batch;
pub(crate) mod brute;
pub(crate) mod gap;
pub mod query;
pub mod wanted;
