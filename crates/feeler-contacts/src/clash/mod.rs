//! The mock-up against itself: each pair of its parts that collides, is too near, contains the other or duplicates it,
//! classified and measured.

mod copies;
mod held_solids;
mod obvious;
pub(crate) mod row;
pub(crate) mod search;
mod verdicts;
mod way_out;
