//! A mock-up with its index: the target of every query.

use std::sync::Arc;

use feeler_lanes::{Checked, Level};

use crate::error::{Error, Result};
use crate::index::selection::Selection;
use crate::index::store::{Storage, Store};
use crate::mesh::mockup::Mockup;
use crate::progress::Control;

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

    /// Has queries use another instruction set than the best; where the CPU lacks it, the best.
    pub(crate) fn set_lanes(&mut self, lanes: Level) {
        self.lanes = lanes.checked();
    }
}
