//! The three stores of static triangles, behind one interface: build, look up candidates, report memory, check itself.

mod blocks;
mod dense;
mod hashed;
mod lists;
mod lists_cells;
mod occupancy;

use crate::error::{Error, Result};
use crate::mesh::Mesh;
use crate::narrow::Narrow;
use crate::proximity::{search, SearchScratch, Wanted};
use crate::tool::Tool;

pub(crate) use blocks::{Blocks, BlocksScratch, NearScratch};
pub(crate) use dense::Dense;
pub(crate) use hashed::Hashed;

/// Which store a scene uses.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Storage {
    /// The paper's array: one 4-byte entry per voxel, to lists of triangles.
    Dense,
    /// The paper's hashed array (equation 1): `(1 - level)` times as many entries as voxels, level 0 to 0.99.
    Hashed {
        /// Share of the voxel array's memory saved.
        level: f64,
    },
    /// Blocks of 32 boxes close together, under a shallow tree.
    Blocks,
}

/// A built store.
#[derive(Debug)]
pub(crate) enum Store {
    Dense(Dense),
    Hashed(Hashed),
    Blocks(Blocks),
}

impl Store {
    /// Builds the store with voxels (blocks: pieces) of `size` metres, within `limit` bytes.
    pub fn build(mesh: &Mesh, storage: Storage, size: f64, limit: u64, progress: Progress<'_>) -> Result<Store> {
        Ok(match storage {
            Storage::Dense => Store::Dense(Dense::build(mesh, size, limit, progress)?),
            Storage::Hashed { level } => Store::Hashed(Hashed::build(mesh, size, level, limit, progress)?),
            Storage::Blocks => Store::Blocks(Blocks::build(mesh, size, limit, progress)?),
        })
    }

    /// Offers every pair that may meet to the narrow phase, until it says stop.
    pub fn offer_candidates(&self, tool: &Tool, scratch: &mut BlocksScratch, narrow: &mut Narrow<'_>) {
        match self {
            Store::Dense(store) => store.offer_candidates(narrow),
            Store::Hashed(store) => store.offer_candidates(narrow),
            Store::Blocks(store) => store.offer_candidates(tool, scratch, narrow),
        }
    }

    /// Offers pairs of triangles that may be within the bound, nearest boxes first, until that says stop.
    pub fn search(&self, scratch: &mut SearchScratch, near: &mut NearScratch, wanted: &mut Wanted<'_>) {
        let mesh = wanted.mockup.mesh();
        match self {
            Store::Dense(store) => search(&store.with(mesh), scratch, wanted),
            Store::Hashed(store) => search(&store.with(mesh), scratch, wanted),
            Store::Blocks(store) => store.search(scratch, near, wanted),
        }
    }

    /// Bytes by structure.
    pub fn memory(&self) -> Vec<(&'static str, usize)> {
        match self {
            Store::Dense(store) => store.memory(),
            Store::Hashed(store) => store.memory(),
            Store::Blocks(store) => store.memory(),
        }
    }

    /// Checks every invariant the queries rely on; for tests.
    pub fn validate(&self, mesh: &Mesh) -> std::result::Result<(), String> {
        match self {
            Store::Dense(store) => store.validate(mesh),
            Store::Hashed(store) => store.validate(mesh),
            Store::Blocks(store) => store.validate(mesh),
        }
    }
}

/// Told the share done (0 to 1) and the stage, now and then, from the calling thread; answers whether to go on.
pub type Progress<'a> = &'a (dyn Fn(f64, &str) -> bool + Sync);

/// Tells the progress function; an error when it asks to stop.
pub(crate) fn report(progress: Progress<'_>, done: f64, stage: &str) -> Result<()> {
    if progress(done, stage) {
        Ok(())
    } else {
        Err(Error::Cancelled)
    }
}

/// Refuses what would need more than `limit` bytes.
fn check_memory(what: &'static str, needed: f64, limit: u64) -> Result<()> {
    if needed <= limit as f64 {
        return Ok(());
    }
    Err(out_of_memory(what, needed, limit))
}

fn out_of_memory(what: &'static str, needed: f64, limit: u64) -> Error {
    let advice = "choose a larger voxel size, or allow more memory if the machine has it";
    Error::Memory { what, needed: needed.min(u64::MAX as f64) as u64, allowed: limit, advice }
}

/// Refuses more entries than 32-bit positions can address. `count` is a bound from below.
fn check_entries(voxel_size: f64, count: f64) -> Result<()> {
    if count <= f64::from(u32::MAX) {
        return Ok(());
    }
    Err(Error::TooManyEntries { voxel_size, entries: count.min(u64::MAX as f64) as u64 })
}

/// `length` default values, or an error where the system has no memory for them.
fn filled<T: Default + Send>(what: &'static str, length: u64, limit: u64) -> Result<Vec<T>> {
    let mut values = Vec::new();
    let bytes = length as f64 * size_of::<T>() as f64;
    let length = usize::try_from(length).map_err(|_| out_of_memory(what, bytes, limit))?;
    values.try_reserve_exact(length).map_err(|_| out_of_memory(what, bytes, limit))?;
    values.resize_with(length, T::default);
    Ok(values)
}
