//! Which triangles meet: candidate pairs of the index through the exact triangle test.

pub(crate) mod batch;
pub(crate) mod brute;
pub(crate) mod hits;
pub mod narrow;
pub(crate) mod query;
pub(crate) mod touching;
