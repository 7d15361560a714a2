//! The index of static triangles: three stores behind one interface.

pub mod blocks;
mod dense;
pub mod grid;
mod hashed;
mod limits;
mod lists;
mod lists_cells;
mod lists_sweep;
pub mod mockup_index;
mod occupancy;
pub mod pair_set;
pub mod plain_search;
pub mod sink;
pub mod store;
