//! The mock-up against itself: which pairs of its parts meet, which are near, and which are one and the same.

pub mod asked;
pub mod brute;
pub mod meeting;
mod narrow;
mod pair_table;
pub mod search;
