//! Which pairs of parts collide, and whether they cross or only touch: one descent of the index against itself.

use super::asked::{merged, PairLimits};
use super::meets::{MeetingParts, Meets, Touch};
use super::narrow::{MeetingNarrow, NarrowScratch};
use super::search::{Found, SelfIndex};
use crate::index::blocks::{MeetingBlocks, MeetingScratch};
use crate::progress::Progress;
use crate::scratch_pool::ScratchPool;

/// The result of [`meeting_parts`].
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Meeting {
    /// In order.
    pub pairs: Vec<MeetingParts>,
    /// For each of them two colliding triangles, that of the lesser part first. Which ones depends on the shares of the
    /// search.
    pub examples: Vec<[u32; 2]>,
    /// All pairs of triangles of the parts that only touch, in order, each once.
    pub touches: Vec<Touch>,
    /// False where the search was stopped.
    pub is_complete: bool,
}

impl Meeting {
    /// The touches of two parts.
    pub fn touches_of(&self, parts: [u32; 2]) -> &[Touch] {
        let from = self.touches.partition_point(|touch| touch.parts < parts);
        let count = self.touches[from..].partition_point(|touch| touch.parts == parts);
        &self.touches[from..from + count]
    }
}

/// Every pair of parts to check that collides, without those `decided` beforehand (sorted, the lesser part first).
/// Exact: parts collide if two of their triangles do, and cross if two of them cross. In parallel on the current rayon
/// pool.
pub fn meeting_parts(
    index: &SelfIndex<'_>,
    limits: &PairLimits,
    decided: &[[u32; 2]],
    progress: Progress<'_>,
) -> Meeting {
    let (mockup, lanes) = (index.index().mockup(), index.index().lanes());
    let pool: ScratchPool<(NarrowScratch, MeetingScratch)> = ScratchPool::default();
    let Found { all, is_complete } = index.search(0.0, (progress, "finding colliding parts"), |search, task| {
        pool.with(|(scratch, of_blocks)| {
            scratch.begin_share();
            let (found, touches) = (Vec::new(), Vec::new());
            let mut narrow = MeetingNarrow { mockup, limits, decided, lanes, scratch, found, touches };
            let (blocks, parts) = (index.blocks(), index.parts());
            search.run(task, &mut MeetingBlocks { blocks, parts, narrow: &mut narrow, scratch: of_blocks });
            narrow.finish();
            vec![(narrow.found, narrow.touches)]
        })
    });
    let found = all.iter().flat_map(|(found, _)| found).map(|(parts, meets, triangles)| (*parts, (*meets, *triangles)));
    let pairs = merged(found, |p, q| if q.0 > p.0 { q } else { p });
    let examples = pairs.iter().map(|(_, (_, triangles))| *triangles).collect();
    let pairs: Vec<MeetingParts> = pairs.into_iter().map(|(parts, (meets, _))| MeetingParts { parts, meets }).collect();
    let is_touching = |touch: &&Touch| {
        let at = pairs.binary_search_by_key(&touch.parts, |pair| pair.parts);
        at.is_ok_and(|at| pairs[at].meets == Meets::Touching)
    };
    let mut touches: Vec<Touch> = all.iter().flat_map(|(_, touches)| touches).filter(is_touching).copied().collect();
    touches.sort_unstable_by_key(|touch| (touch.parts, touch.triangles));
    touches.dedup();
    Meeting { pairs, examples, touches, is_complete }
}
