//! The mock-up against itself: which pairs of its parts collide, are near, contain each other, or are duplicates.

pub mod asked;
mod boxes;
pub mod brute;
pub mod duplicates;
pub mod gap_filling;
pub mod holding;
pub mod location;
pub mod meeting;
pub mod meets;
mod narrow;
pub mod near;
mod pair_table;
pub mod search;
pub mod solids;
pub mod touch;
