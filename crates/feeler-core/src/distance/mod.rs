//! Distances: pairs of triangles nearer than a limit, the gap to each part, the closest parts.
//!
//! One search serves all: tool tree and mock-up tree are descended together, nearest pairs of boxes first, and pairs of
//! boxes farther apart than the current limit are dropped.

pub(crate) mod along;
pub(crate) mod batch;
pub(crate) mod brute;
pub(crate) mod gap;
pub mod query;
pub mod wanted;
