//! Which pairs of parts meet, and whether they cross or only touch: the index held against itself once.

use super::asked::{merged, PairLimits};
use super::narrow::{MeetingNarrow, NarrowScratch};
use super::search::{Found, SelfIndex};
use crate::index::blocks::{MeetingBlocks, MeetingScratch};
use crate::progress::Progress;
use crate::scratch_pool::ScratchPool;

/// How two parts meet.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Meets {
    /// Triangles touch or lie in one plane, and none cross.
    Touching,
    /// Some cross.
    Crossing,
}

/// Two parts that meet.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MeetingParts {
    /// The lesser first.
    pub parts: [u32; 2],
    /// How.
    pub meets: Meets,
}

/// Every pair of parts that is asked and meets, in order, without those `decided` beforehand (sorted, the lesser part first). Exact:
/// parts meet where two of their triangles do, and cross where two of them cross. In parallel on the current rayon pool.
pub fn meeting_parts(
    index: &SelfIndex<'_>,
    limits: &PairLimits,
    decided: &[[u32; 2]],
    progress: Progress<'_>,
) -> Found<MeetingParts> {
    let (mockup, lanes) = (index.index().mockup(), index.index().lanes());
    let pool: ScratchPool<(NarrowScratch, MeetingScratch)> = ScratchPool::default();
    let found = index.search(0.0, (progress, "finding parts that meet"), |search, task| {
        pool.with(|(scratch, of_blocks)| {
            let mut narrow = MeetingNarrow { mockup, limits, decided, lanes, scratch, found: Vec::new() };
            let (blocks, parts) = (index.blocks(), index.parts());
            search.run(task, &mut MeetingBlocks { blocks, parts, narrow: &mut narrow, scratch: of_blocks });
            narrow.finish();
            narrow.found
        })
    });
    let all = merged(found.all.into_iter(), Meets::max).into_iter().map(|(parts, meets)| MeetingParts { parts, meets });
    Found { all: all.collect(), is_complete: found.is_complete }
}
