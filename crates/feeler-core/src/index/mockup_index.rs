//! A mock-up with its index: the target of every query.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use feeler_lanes::{Checked, Level};

use crate::error::{Error, Result};
use crate::index::blocks::Blocks;
use crate::index::selection::Selection;
use crate::index::store::{Storage, Store};
use crate::mesh::mockup::Mockup;
use crate::progress::Control;
use crate::saved::{check, damaged, Reader, Sections};

/// A mock-up and its store, with a selection. Immutable while it is queried; a copy shares mock-up and store.
#[derive(Debug, Clone)]
pub struct Index {
    mockup: Arc<Mockup>,
    voxel_size: f64,
    storage: Storage,
    memory_limit: u64,
    store: Arc<Store>,
    selection: Selection,
    lanes: Checked,
}

/// What a saved scene says of an index beside its arrays.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct Facts {
    voxel_size: f64,
    hashing: f64,
    storage: u64,
}

// The numbers of the stores in it.
const BLOCKS: u64 = 0;
const DENSE: u64 = 1;
const HASHED: u64 = 2;

impl Index {
    /// Builds the store, in parallel on the current rayon pool. `memory_limit`: most bytes that this, or a query's result, may take.
    ///
    /// Errors: a voxel size or hashing level out of range, or one that needs more memory than allowed; the latter before
    /// anything is allocated.
    pub(crate) fn build(
        mockup: Arc<Mockup>,
        storage: Storage,
        voxel_size: f64,
        memory_limit: u64,
        control: Control<'_>,
    ) -> Result<Index> {
        if !(voxel_size.is_finite() && voxel_size > 0.0) {
            return Err(Error::VoxelSize { value: voxel_size });
        }
        let store = Arc::new(Store::build(mockup.mesh(), storage, voxel_size, memory_limit, control)?);
        let (selection, lanes) = (Selection::default(), Level::best().checked());
        Ok(Index { mockup, voxel_size, storage, memory_limit, store, selection, lanes })
    }

    /// Adds mock-up, store and the parts that are not there to the sections of a saved scene. Stores other than blocks are not among
    /// them: they are built again.
    pub(crate) fn save<'a>(&'a self, sections: &mut Sections<'a>) {
        self.mockup.save(sections);
        let (storage, hashing) = match self.storage {
            Storage::Blocks => (BLOCKS, 0.0),
            Storage::Dense => (DENSE, 0.0),
            Storage::Hashed { level } => (HASHED, level),
        };
        sections.add_made("index.facts", &[Facts { voxel_size: self.voxel_size, hashing, storage }]);
        if let Store::Blocks(blocks) = &*self.store {
            blocks.save(sections);
        }
        let parts = self.mockup.part_bounds().len() as u32;
        let absent: Vec<u32> = (0..parts).filter(|part| !self.selection.has_part(*part)).collect();
        sections.add_made("index.absent_parts", &absent);
    }

    /// From the sections of a saved scene; with the parts that are not there.
    pub(crate) fn of_saved(saved: Reader<'_>, memory_limit: u64, control: Control<'_>) -> Result<(Index, Vec<u32>)> {
        let mockup = Arc::new(Mockup::of_saved(saved)?);
        let absent = saved.column::<u32>("index.absent_parts")?.to_vec();
        let Facts { voxel_size, hashing, storage } = saved.one("index.facts")?;
        let storage = match storage {
            BLOCKS => Storage::Blocks,
            DENSE => Storage::Dense,
            HASHED => Storage::Hashed { level: hashing },
            _ => return Err(damaged("index.facts")),
        };
        if storage != Storage::Blocks {
            return Ok((Index::build(mockup, storage, voxel_size, memory_limit, control)?, absent));
        }
        check(voxel_size.is_finite() && voxel_size > 0.0, || "index.facts".into())?;
        let store = Arc::new(Store::Blocks(Blocks::of_saved(saved, mockup.mesh())?));
        let (selection, lanes) = (Selection::default(), Level::best().checked());
        Ok((Index { mockup, voxel_size, storage, memory_limit, store, selection, lanes }, absent))
    }

    /// The same with another selection.
    pub(crate) fn with_selection(&self, selection: Selection) -> Index {
        Index { selection, ..self.clone() }
    }

    /// The selection of queries.
    pub fn selection(&self) -> &Selection {
        &self.selection
    }

    /// The mock-up.
    pub fn mockup(&self) -> &Arc<Mockup> {
        &self.mockup
    }

    /// Voxel edge, or the piece size of blocks, metres.
    pub(crate) fn voxel_size(&self) -> f64 {
        self.voxel_size
    }

    /// How the triangles are stored.
    pub(crate) fn storage(&self) -> Storage {
        self.storage
    }

    /// Most bytes a result may take.
    pub(crate) fn memory_limit(&self) -> u64 {
        self.memory_limit
    }

    /// The source of candidate pairs.
    pub(crate) fn store(&self) -> &Store {
        &self.store
    }

    /// The instruction set of queries.
    pub fn lanes(&self) -> Checked {
        self.lanes
    }

    /// Sets the most bytes a result may take.
    pub(crate) fn set_memory_limit(&mut self, bytes: u64) {
        self.memory_limit = bytes;
    }

    /// Has queries use another instruction set than the best; where the CPU lacks it, the best.
    pub(crate) fn set_lanes(&mut self, lanes: Level) {
        self.lanes = lanes.checked();
    }
}
