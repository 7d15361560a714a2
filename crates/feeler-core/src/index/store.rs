//! The three stores of static triangles, behind one interface: build, look up candidates, report memory, check itself.

use super::blocks::{Blocks, BlocksScratch, NearScratch, SweepScratch};
use super::dense::Dense;
use super::hashed::Hashed;
use super::plain_search::{search, SearchScratch};
use super::ray_search::{search_ray, RayPath, RayScratch};
use super::selection::TrianglesThere;
use super::sink::{CandidateSink, NearSink, NearTool, Offer, PlacedTool, RaySink, Sweep};
use crate::error::Result;
use crate::geometry::bounds::Aabb;
use crate::mesh::triangle_mesh::Mesh;
use crate::progress::Control;

/// Which store a scene uses. All give the same answers; they differ in memory and time.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
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

impl Storage {
    /// Its name, in lower case.
    pub fn name(self) -> &'static str {
        match self {
            Storage::Dense => "dense",
            Storage::Hashed { .. } => "hashed",
            Storage::Blocks => "blocks",
        }
    }
}

/// A built store.
#[derive(Debug)]
pub(crate) enum Store {
    /// See [`Storage::Dense`].
    Dense(Dense),
    /// See [`Storage::Hashed`].
    Hashed(Hashed),
    /// See [`Storage::Blocks`].
    Blocks(Blocks),
}

impl Store {
    /// Builds the store with voxels (blocks: pieces) of `size` metres, within `limit` bytes.
    pub(crate) fn build(mesh: &Mesh, storage: Storage, size: f64, limit: u64, control: Control<'_>) -> Result<Store> {
        Ok(match storage {
            Storage::Dense => Store::Dense(Dense::build(mesh, size, limit, control)?),
            Storage::Hashed { level } => Store::Hashed(Hashed::build(mesh, size, level, limit, control)?),
            Storage::Blocks => Store::Blocks(Blocks::build(mesh, size, limit, control)?),
        })
    }

    /// Offers every pair that may meet to the narrow phase, until it says stop.
    pub(crate) fn offer_candidates<N: CandidateSink>(
        &self,
        at: &PlacedTool<'_>,
        scratch: &mut BlocksScratch,
        narrow: &mut N,
    ) {
        match self {
            Store::Dense(store) => store.offer_candidates(at.tool, narrow),
            Store::Hashed(store) => store.offer_candidates(at.tool, narrow),
            Store::Blocks(store) => store.offer_candidates(at, scratch, narrow),
        }
    }

    /// Offers pairs of triangles that may be within the bound, nearest boxes first, until that says stop.
    pub(crate) fn search<W: NearSink>(
        &self,
        at: &NearTool<'_>,
        scratch: &mut SearchScratch,
        near: &mut NearScratch,
        wanted: &mut W,
    ) {
        let mesh = at.mockup.mesh();
        match self {
            Store::Dense(store) => search(&store.with(mesh), at, scratch, wanted),
            Store::Hashed(store) => search(&store.with(mesh), at, scratch, wanted),
            Store::Blocks(store) => store.search(at, scratch, near, wanted),
        }
    }

    /// Hands `wanted` every triangle that the ray may meet within its limit, nearest boxes first.
    pub(crate) fn search_ray<W: RaySink>(
        &self,
        mesh: &Mesh,
        path: &RayPath<'_>,
        scratch: &mut RayScratch,
        wanted: &mut W,
    ) {
        match self {
            Store::Dense(store) => search_ray(&store.with(mesh), mesh, path, wanted),
            Store::Hashed(store) => search_ray(&store.with(mesh), mesh, path, wanted),
            Store::Blocks(store) => store.search_ray(mesh, path, scratch, wanted),
        }
    }

    /// Offers every pair that may meet while the tool is on its way through a window, by slot and triangle, some more than
    /// once, until `offer` says stop; false where it gave up.
    ///
    /// A pair that is not offered surely does not meet at any time in the window.
    pub(crate) fn offer_swept(&self, sweep: &Sweep<'_>, scratch: &mut SweepScratch, offer: Offer<'_>) -> bool {
        match self {
            Store::Dense(store) => store.with(sweep.mesh).offer_swept(sweep, &mut scratch.seen, offer),
            Store::Hashed(store) => store.with(sweep.mesh).offer_swept(sweep, &mut scratch.seen, offer),
            Store::Blocks(store) => store.offer_swept(sweep, scratch, offer),
        }
    }

    /// For each level of nodes a word a node: which children have a triangle below them that is there. Empty without nodes.
    pub(crate) fn children_there(&self, there: TrianglesThere<'_>) -> Vec<Vec<u32>> {
        match self {
            Store::Dense(_) | Store::Hashed(_) => Vec::new(),
            Store::Blocks(store) => store.children_there(there),
        }
    }

    /// The same after more triangles left, all of them in these boxes; `words` are those of before, empty where all were there.
    pub(crate) fn children_left(&self, words: &[Vec<u32>], there: TrianglesThere<'_>, boxes: &[Aabb]) -> Vec<Vec<u32>> {
        match self {
            Store::Dense(_) | Store::Hashed(_) => Vec::new(),
            Store::Blocks(store) => store.children_left(words, there, boxes),
        }
    }

    /// Bytes by structure.
    pub(crate) fn memory(&self) -> Vec<(&'static str, usize)> {
        match self {
            Store::Dense(store) => store.memory(),
            Store::Hashed(store) => store.memory(),
            Store::Blocks(store) => store.memory(),
        }
    }

    /// Checks every invariant the queries rely on; for tests.
    pub(crate) fn validate(&self, mesh: &Mesh) -> std::result::Result<(), String> {
        match self {
            Store::Dense(store) => store.validate(mesh),
            Store::Hashed(store) => store.validate(mesh),
            Store::Blocks(store) => store.validate(mesh),
        }
    }
}
