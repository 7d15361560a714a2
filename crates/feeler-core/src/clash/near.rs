//! Distances of parts that do not collide: the smallest distance of each pair nearer than its limit.

use super::asked::{in_order, merged, PairLimits};
use super::pair_table::PairTable;
use super::search::{Found, SelfIndex};
use crate::constants::{DISTANCE_ROUNDOFFS, UNIT_ROUNDOFF};
use crate::geometry::bounds::{Point, Triangle};
use crate::geometry::distance_lanes::closest_apart;
use crate::index::blocks::{Blocks, NearBlocks, SelfNearScratch};
use crate::index::sink::SelfNearSink;
use crate::mesh::mockup::Mockup;
use crate::progress::Progress;
use crate::scratch_pool::ScratchPool;
use feeler_lanes::{Checked, WIDE_LANES};

/// The closest two triangles of two parts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PartGap {
    /// The lesser first.
    pub parts: [u32; 2],
    /// A triangle of each.
    pub triangles: [u32; 2],
    /// Metres, above 0.
    pub distance: f64,
    /// Where they are closest, on each, metres.
    pub points: [Point; 2],
}

/// The least distance of every pair of parts to check that is no farther apart than its [reach](PairLimits::reach), in
/// order, without those `decided` (sorted, the lesser part first), which must include all colliding pairs. Of several
/// pairs of triangles at the same distance the one with the least ids. In parallel on the current rayon pool.
pub fn near_parts(
    index: &SelfIndex<'_>,
    limits: &PairLimits,
    decided: &[[u32; 2]],
    progress: Progress<'_>,
) -> Found<PartGap> {
    let (mockup, lanes) = (index.index().mockup(), index.index().lanes());
    let blocks = index.blocks();
    let margin = 4.0 * DISTANCE_ROUNDOFFS * UNIT_ROUNDOFF * mockup.mesh().bounds().largest_coordinate();
    let pool: ScratchPool<(Nearest, SelfNearScratch)> = ScratchPool::default();
    let reach = blocks.reach_of(limits.largest_reach() + margin);
    let found = index.search(reach, (progress, "measuring clearances"), |search, task| {
        pool.with(|(nearest, scratch)| {
            nearest.share += 1;
            nearest.known.begin_share();
            let mut wanted = NearParts { mockup, blocks, limits, decided, lanes, margin, nearest, found: Vec::new() };
            search.run(task, &mut NearBlocks { blocks, parts: index.parts(), wanted: &mut wanted, scratch });
            wanted.found.into_iter().map(|gap| (gap.parts, gap)).collect()
        })
    });
    let nearer = |p: PartGap, q: PartGap| if q.order(&p).is_lt() { q } else { p };
    let all = merged(found.all.into_iter(), nearer).into_iter().map(|(_, gap)| gap).collect();
    Found { all, is_complete: found.is_complete }
}

impl PartGap {
    pub(super) fn order(&self, other: &PartGap) -> std::cmp::Ordering {
        self.distance.total_cmp(&other.distance).then(self.triangles.cmp(&other.triangles))
    }
}

/// The findings on a pair of parts.
#[derive(Debug, Clone, Copy)]
struct Known {
    /// Farther triangles are of no interest, metres; negative: the pair is not wanted.
    within: f64,
    /// The same as the index compares with it.
    limit: f32,
    /// Where the best of this share stands, and which share that is.
    place: u32,
    share: u32,
}

const NOT_ASKED: Known = Known { within: -1.0, limit: -1.0, place: 0, share: 0 };

/// Working memory of one search at a time.
#[derive(Debug)]
struct Nearest {
    known: PairTable<Known>,
    share: u32,
    candidates: Vec<Candidate>,
}

#[derive(Debug, Clone, Copy)]
struct Candidate {
    bound: f32,
    /// Of the lesser part first.
    triangles: [u32; 2],
    parts: [u32; 2],
}

impl Default for Nearest {
    fn default() -> Nearest {
        Nearest { known: PairTable::new(), share: 0, candidates: Vec::new() }
    }
}

/// Measures the pairs that one share of a search reaches.
struct NearParts<'a> {
    mockup: &'a Mockup,
    blocks: &'a Blocks,
    limits: &'a PairLimits,
    decided: &'a [[u32; 2]],
    lanes: Checked,
    /// Error of bounds from boxes and of the distance of triangles, metres.
    margin: f64,
    nearest: &'a mut Nearest,
    found: Vec<PartGap>,
}

impl SelfNearSink for NearParts<'_> {
    #[inline]
    fn limit(&mut self, part: u32, other: u32) -> f32 {
        self.known(in_order([part, other])).limit
    }

    #[inline]
    fn offer(&mut self, bound: f32, triangle: u32, other: u32) {
        let parts = [triangle, other].map(|t| self.mockup.part_of_face(t));
        let triangles = if parts[0] < parts[1] { [triangle, other] } else { [other, triangle] };
        self.nearest.candidates.push(Candidate { bound, triangles, parts: in_order(parts) });
    }

    fn end_block(&mut self) {
        let mut candidates = std::mem::take(&mut self.nearest.candidates);
        // Of each two parts the nearest first.
        candidates.sort_unstable_by(|p, q| {
            p.parts.cmp(&q.parts).then(p.bound.total_cmp(&q.bound)).then(p.triangles.cmp(&q.triangles))
        });
        candidates.dedup_by_key(|candidate| candidate.triangles);
        for same in candidates.chunk_by(|p, q| p.parts == q.parts) {
            for eight in same.chunks(WIDE_LANES) {
                let known = *self.known(same[0].parts);
                let count = eight.iter().take_while(|candidate| candidate.bound <= known.limit).count();
                if count == 0 {
                    break;
                }
                self.measure(&eight[..count], known.within);
            }
        }
        candidates.clear();
        self.nearest.candidates = candidates;
    }
}

impl NearParts<'_> {
    #[inline]
    fn known(&mut self, [a, b]: [u32; 2]) -> &mut Known {
        let NearParts { limits, decided, blocks, margin, .. } = *self;
        self.nearest.known.of(a, b, || match limits.reach(a, b) {
            Some(within) if decided.binary_search(&[a, b]).is_err() => {
                Known { within, limit: blocks.limit_of(within + margin), place: 0, share: 0 }
            }
            _ => NOT_ASKED,
        })
    }

    /// Measures up to eight pairs of triangles of two parts.
    fn measure(&mut self, eight: &[Candidate], within: f64) {
        let mesh = self.mockup.mesh();
        let triangles: [[Triangle; 2]; WIDE_LANES] =
            std::array::from_fn(|i| eight[i.min(eight.len() - 1)].triangles.map(|t| mesh.triangle(t)));
        let closest = closest_apart(self.lanes, eight.len(), |i| (&triangles[i][0], &triangles[i][1]), within);
        for (candidate, closest) in eight.iter().zip(closest) {
            let Some(closest) = closest else { continue };
            let gap = PartGap {
                parts: candidate.parts,
                triangles: candidate.triangles,
                distance: closest.distance,
                points: [closest.on_p, closest.on_q],
            };
            self.keep(gap);
        }
    }

    fn keep(&mut self, gap: PartGap) {
        let (share, next) = (self.nearest.share, self.found.len() as u32);
        let limit = self.blocks.limit_of(gap.distance + self.margin);
        let known = self.known(gap.parts);
        if gap.distance > known.within {
            return;
        }
        let place = (known.share == share).then_some(known.place as usize);
        *known = Known { within: gap.distance, limit, place: place.map_or(next, |place| place as u32), share };
        match place {
            None => self.found.push(gap),
            Some(place) if gap.order(&self.found[place]).is_lt() => self.found[place] = gap,
            Some(_) => {}
        }
    }
}
