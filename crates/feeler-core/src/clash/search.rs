//! A search of the index against itself, in shares and in parallel; an interrupted search keeps its results.

use rayon::prelude::*;

use crate::constants::MOCKUP_CUT_ALLOWANCE;
use crate::error::Result;
use crate::index::blocks::{BlockParts, Blocks, SelfSearch, SelfTask};
use crate::index::mockup_index::Index;
use crate::index::store::Store;
use crate::mesh::pieces::default_piece_size;
use crate::progress::{Control, Progress};

/// Shares of a search, after each of which it reports progress and may be stopped.
const WAVE: usize = 128;

/// The blocks of an index and whose pieces they hold. Of other stores than blocks, and where parts are moved, they are built for
/// the occasion.
#[derive(Debug)]
pub struct SelfIndex<'a> {
    index: &'a Index,
    built: Option<Blocks>,
    parts: BlockParts,
}

/// The results of the shares of a search, and whether it was completed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Found<T> {
    /// In order.
    pub all: Vec<T>,
    /// False where it was stopped.
    pub is_complete: bool,
}

impl<'a> SelfIndex<'a> {
    /// Of the parts that are there. Errors: blocks that need more memory than the scene allows.
    pub fn new(index: &'a Index) -> Result<SelfIndex<'a>> {
        let (mockup, limit) = (index.mockup(), index.memory_limit());
        let built = match index.store() {
            Store::Blocks(_) if !index.has_moved() => None,
            Store::Blocks(_) => Some(Blocks::build(mockup.mesh(), index.voxel_size(), limit, Control::default())?),
            _ => {
                let (mesh, ids) = (mockup.mesh(), mockup.mesh().queried().collect::<Vec<u32>>());
                let size = default_piece_size(ids.len(), |i| mesh.triangle(ids[i]), MOCKUP_CUT_ALLOWANCE);
                Some(Blocks::build(mesh, size, limit, Control::default())?)
            }
        };
        let selection = index.selection();
        let parts = BlockParts::new(of(index, &built), mockup, |part| selection.has_part(part));
        Ok(SelfIndex { index, built, parts })
    }

    /// The index.
    pub fn index(&self) -> &'a Index {
        self.index
    }

    pub(crate) fn blocks(&self) -> &Blocks {
        of(self.index, &self.built)
    }

    pub(crate) fn parts(&self) -> &BlockParts {
        &self.parts
    }

    /// Works on all shares of a search in parallel on the current rayon pool; `work` returns the findings of one.
    pub(crate) fn search<T: Send>(
        &self,
        reach: f32,
        (progress, stage): (Progress<'_>, &str),
        work: impl Fn(&SelfSearch<'_>, &SelfTask) -> Vec<T> + Sync,
    ) -> Found<T> {
        let search = SelfSearch { blocks: self.blocks(), parts: &self.parts, lanes: self.index.lanes(), reach };
        let tasks = search.tasks();
        let mut all = Vec::new();
        for (n, wave) in tasks.chunks(WAVE).enumerate() {
            if !progress.tell((n * WAVE) as f64 / tasks.len() as f64, stage) {
                return Found { all, is_complete: false };
            }
            let found: Vec<Vec<T>> = wave.par_iter().map(|task| work(&search, task)).collect();
            all.extend(found.into_iter().flatten());
        }
        Found { all, is_complete: true }
    }
}

fn of<'a>(index: &'a Index, built: &'a Option<Blocks>) -> &'a Blocks {
    match (built, index.store()) {
        (Some(blocks), _) | (_, Store::Blocks(blocks)) => blocks,
        _ => unreachable!("blocks are built for other stores"),
    }
}
