//! The index of static triangles: three stores behind one interface.

pub(crate) mod blocks;
mod dense;
pub(crate) mod grid;
mod hashed;
pub mod interner;
mod limits;
mod lists;
mod lists_cells;
mod lists_sweep;
pub(crate) mod mockup_index;
mod occupancy;
pub(crate) mod plain_search;
pub(crate) mod ray_search;
pub mod selection;
pub mod sink;
pub(crate) mod store;
