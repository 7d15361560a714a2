//! The mock-up against itself: each pair of its parts that meets, is near, holds the other or is the same, told apart and measured.

mod obvious;
pub(crate) mod row;
pub(crate) mod search;
mod verdicts;
mod way_out;
