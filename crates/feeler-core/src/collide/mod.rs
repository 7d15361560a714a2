//! Which triangles meet: candidate pairs of the index through the exact triangle test.

pub mod batch;
pub mod brute;
mod hits;
pub mod narrow;
pub mod query;
