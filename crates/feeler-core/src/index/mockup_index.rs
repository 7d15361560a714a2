//! A mock-up with its index: the target of every query.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use feeler_lanes::{Checked, Level};

use crate::constants::MOCKUP_CUT_ALLOWANCE;
use crate::error::{Error, Result};
use crate::geometry::bounds::Aabb;
use crate::index::blocks::Blocks;
use crate::index::selection::{IgnoredPairs, Selection};
use crate::index::store::{Storage, Store};
use crate::mesh::mockup::Mockup;
use crate::mesh::pieces::default_piece_size;
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
    /// Where the mock-up has parts moved.
    moved: Option<Moved>,
    lanes: Checked,
}

/// Parts that are not where the store of the others has them. The store is of the mock-up with all parts where they are modelled.
#[derive(Debug, Clone)]
struct Moved {
    /// Of the parts that moved, where they are now; `None` where they have no triangles.
    store: Option<Arc<Store>>,
    /// The selection of the store of the others, with all parts in it.
    whole: Selection,
    /// The same without the parts that moved.
    others: Selection,
}

/// Moved triangles whose places are looked for together.
const TOGETHER: usize = 32;

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
        Ok(Index { mockup, voxel_size, storage, memory_limit, store, selection, moved: None, lanes })
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
        Ok((Index { mockup, voxel_size, storage, memory_limit, store, selection, moved: None, lanes }, absent))
    }

    /// The same of a mock-up that is made of this one's with parts moved. The store is shared, and one is built of the triangles that
    /// moved. Errors: memory.
    pub(crate) fn moved(&self, mockup: Arc<Mockup>) -> Result<Index> {
        let whole = self.moved.as_ref().map_or(&self.selection, |moved| &moved.whole).clone();
        let Some(rest) = mockup.rest() else {
            return Ok(Index { mockup, selection: whole, moved: None, ..self.clone() });
        };
        let mesh = mockup.mesh();
        let store = if rest.triangles.is_empty() {
            None
        } else {
            let ids = &rest.triangles;
            let size = match self.storage {
                Storage::Blocks => self.voxel_size,
                _ => default_piece_size(ids.len(), |i| mesh.triangle(ids[i]), MOCKUP_CUT_ALLOWANCE),
            };
            let boxes = mockup.part_bounds().iter().zip(&rest.is_moved).filter(|(_, is_moved)| **is_moved);
            let bounds = boxes.fold(Aabb::EMPTY, |all, (b, _)| all.union(b));
            let of = (mesh, ids.clone(), &bounds);
            Some(Arc::new(Store::Blocks(Blocks::build_of(of, size, self.memory_limit, Control::default())?)))
        };
        Ok(Index {
            mockup,
            moved: Some(Moved { store, others: Selection::default(), whole: whole.clone() }),
            ..self.clone()
        }
        .of_whole(whole))
    }

    /// With the selection of the store of all parts, where they are modelled.
    fn of_whole(self, whole: Selection) -> Index {
        let Some((moved, rest)) = self.moved.clone().zip(self.mockup.rest()) else {
            return Index { selection: whole, ..self };
        };
        // Triangles of a part that follow each other are mostly near each other.
        let around = |few: &[u32]| {
            let mesh = rest.mockup.mesh();
            few.iter().fold(Aabb::EMPTY, |all, t| all.union(&Aabb::of_triangle(&mesh.triangle(*t))))
        };
        let is_of_one_part = |a: &u32, b: &u32| self.mockup.part_of_face(*a) == self.mockup.part_of_face(*b);
        let of_parts = rest.asked.chunk_by(is_of_one_part);
        let boxes: Vec<Aabb> = of_parts.flat_map(|own| own.chunks(TOGETHER)).map(around).collect();
        let out = (&rest.is_moved[..], &rest.asked[..]);
        let others = whole.masked(&self.mockup, out, |words, there| self.store.children_left(words, there, &boxes));
        Index { selection: whole.of_any_store(), moved: Some(Moved { whole, others, ..moved }), ..self }
    }

    /// With only those parts that are there and for which `stays` says so.
    pub(crate) fn narrowed(&self, stays: impl Fn(u32) -> bool) -> Index {
        let whole = self.moved.as_ref().map_or(&self.selection, |moved| &moved.whole);
        let whole = whole.narrowed(&self.mockup, stays, |there| self.store.children_there(there));
        self.clone().of_whole(whole)
    }

    /// With all parts there, and no pairs ignored.
    pub(crate) fn with_all_parts(&self) -> Index {
        self.clone().of_whole(Selection::default())
    }

    /// With other pairs ignored.
    pub(crate) fn ignoring(&self, ignored: Option<&Arc<IgnoredPairs>>) -> Index {
        self.each_selection(|selection| selection.ignoring(ignored.cloned()))
    }

    /// With one part alone of those that are there, and no pairs ignored.
    pub(crate) fn of_one_part(&self, part: u32) -> Index {
        self.each_selection(|selection| selection.of_one_part(&self.mockup, part))
    }

    fn each_selection(&self, change: impl Fn(&Selection) -> Selection) -> Index {
        let moved = self.moved.as_ref().map(|moved| Moved {
            store: moved.store.clone(),
            whole: change(&moved.whole),
            others: change(&moved.others),
        });
        Index { selection: change(&self.selection), moved, ..self.clone() }
    }

    /// With one store of all parts where they are, as an index built of the mock-up. Errors: memory.
    pub(crate) fn in_one_store(&self, control: Control<'_>) -> Result<Index> {
        let Index { storage, voxel_size, memory_limit, lanes, .. } = *self;
        let built = Index::build(self.mockup.clone(), storage, voxel_size, memory_limit, control)?;
        let narrowed =
            if self.selection.has_all_parts() { built } else { built.narrowed(|part| self.selection.has_part(part)) };
        Ok(Index { lanes, ..narrowed })
    }

    /// Whether parts are moved, so that there is more than one store.
    pub(crate) fn has_moved(&self) -> bool {
        self.moved.is_some()
    }

    /// The stores, each with the selection of its triangles: a query asks one after the other.
    #[inline]
    pub(crate) fn stores(&self) -> impl Iterator<Item = (&Store, &Selection)> {
        let others = self.moved.as_ref().map_or(&self.selection, |moved| &moved.others);
        let moved = self.moved.as_ref().and_then(|moved| moved.store.as_deref());
        std::iter::once((&*self.store, others)).chain(moved.map(|store| (store, &self.selection)))
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

    /// The source of candidate pairs; where parts are [moved](Self::has_moved), of all parts where they are modelled.
    pub(crate) fn store(&self) -> &Store {
        &self.store
    }

    /// Bytes by structure.
    pub(crate) fn memory(&self) -> Vec<(&'static str, usize)> {
        let mut all = self.store.memory();
        let moved = self.moved.as_ref().and_then(|moved| moved.store.as_ref());
        for (name, bytes) in moved.map_or_else(Vec::new, |store| store.memory()) {
            match all.iter_mut().find(|(other, _)| *other == name) {
                Some((_, sum)) => *sum += bytes,
                None => all.push((name, bytes)),
            }
        }
        all
    }

    /// Checks every invariant the queries rely on; for tests.
    pub(crate) fn validate(&self) -> std::result::Result<(), String> {
        let Some((moved, rest)) = self.moved.as_ref().zip(self.mockup.rest()) else {
            return self.store.validate(self.mockup.mesh());
        };
        self.store.validate(rest.mockup.mesh())?;
        match moved.store.as_deref() {
            Some(Store::Blocks(blocks)) => blocks.validate_of(self.mockup.mesh(), &rest.triangles),
            _ => Ok(()),
        }
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
