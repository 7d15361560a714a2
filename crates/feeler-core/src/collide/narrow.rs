//! The narrow phase: candidate pairs go through the paper's two filters (Borro et al. 2004: repeated pairs, boxes) to
//! the triangle test, in batches: in lanes first, then one by one with exact signs for the undecided ones.

use crate::collide::hits::{Hit, Hits};
use crate::geometry::bounds::Aabb;
use crate::geometry::intersect_lanes::{intersect, least_of, Pairs, Seen};
use crate::geometry::intersect_triangle_triangle::{intersect_with, PairKind};
use crate::geometry::pose::Pose;
use crate::geometry::predicates::Signs;
use crate::index::interner::{pair_key, KeySet};
use crate::index::sink::{CandidateSink, PlacedTool, Stats};
use crate::mesh::triangle_mesh::{prefetch_corners, Corners};
use crate::progress::Pace;
use crate::tool::moving_tool::Tool;
use feeler_lanes::{prefetch_at, Arithmetic, Kernel, Simd, LANES, WIDE_LANES};

/// The filters before the triangle test. Neither changes the answer; they can be switched off to measure their effect.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Filters {
    /// Pairs met again (in another voxel, or by another piece) are skipped.
    pub repeats: bool,
    /// The boxes of the two triangles are compared first.
    pub boxes: bool,
}

impl Default for Filters {
    fn default() -> Filters {
        Filters { repeats: true, boxes: true }
    }
}

/// The boxes of a tool's triangles at a pose, each made when first needed.
#[derive(Debug, Default)]
pub(crate) struct PlacedBounds {
    bounds: Vec<Aabb>,
    /// `placed[t] == query` where triangle `t` is up to date.
    placed: Vec<u32>,
    query: u32,
}

impl PlacedBounds {
    /// Forgets the last query.
    pub(crate) fn begin(&mut self) {
        if self.query == u32::MAX {
            self.placed.fill(0);
            self.query = 0;
        }
        self.query += 1;
    }

    /// The box of a triangle at the pose.
    #[inline]
    pub(crate) fn of(&mut self, tool: &Tool, pose: &Pose, slot: u32) -> Aabb {
        let i = slot as usize;
        if self.placed.len() <= i {
            self.bounds.resize(tool.ids().len(), Aabb::EMPTY);
            self.placed.resize(tool.ids().len(), 0);
        }
        if self.placed[i] != self.query {
            self.placed[i] = self.query;
            self.bounds[i] = Aabb::of_triangle(&pose.apply_triangle(&tool.placeable()[i]));
        }
        self.bounds[i]
    }
}

/// Pairs tested at a time: enough for their cache misses to overlap, few enough for the corners to stay in the first cache.
const BATCH: usize = 128;

/// The same where the first pair found ends the query.
const FIRST_BATCH: usize = 16;

/// Places for candidate pairs: a batch, and the most that one more step adds.
const PENDING_PLACES: usize = BATCH + 2 * LANES;

/// Candidate pairs that wait for their test.
#[derive(Debug)]
pub(crate) struct Pending {
    slots: [u32; PENDING_PLACES],
    mockup_triangles: [u32; PENDING_PLACES],
    count: usize,
    /// The mock-up triangles of these, most of them once.
    asked: [u32; PENDING_PLACES],
    asked_count: usize,
    /// Pairs that were proven to cross, by slot and triangle.
    crossing: [u64; PENDING_PLACES],
    /// Pairs met lately, each at the place its hash gives; those of the last query until the first batch of this one.
    recent: [u64; RECENT],
    is_recent_old: bool,
    /// Whether it pays to look for repeats: whether the last batch had many.
    is_repeating: bool,
}

/// Repeats are looked for as long as at least one pair in this many is one: a look costs about a fifteenth of a test.
const MANY_REPEATS: usize = 16;

/// Few: they are forgotten before each query.
const RECENT_BITS: u32 = 8;
const RECENT: usize = 1 << RECENT_BITS;

impl Default for Pending {
    fn default() -> Pending {
        Pending {
            slots: [0; PENDING_PLACES],
            mockup_triangles: [0; PENDING_PLACES],
            count: 0,
            asked: [0; PENDING_PLACES],
            asked_count: 0,
            crossing: [0; PENDING_PLACES],
            recent: [u64::MAX; RECENT],
            is_recent_old: false,
            is_repeating: true,
        }
    }
}

impl Pending {
    /// Forgets the last query.
    pub(crate) fn clear(&mut self) {
        self.count = 0;
        self.asked_count = 0;
        self.is_recent_old = true;
        self.is_repeating = true;
    }

    #[inline(always)]
    fn ask(&mut self, mockup_triangle: u32) {
        self.asked[self.asked_count] = mockup_triangle;
        self.asked_count += 1;
    }

    /// Leaves out pairs met lately; returns how many.
    ///
    /// Some repeats slip through: those are found twice and counted once in the end.
    #[inline(never)]
    fn skip_repeats(&mut self) -> usize {
        let Pending { slots, mockup_triangles, count, recent, is_recent_old, .. } = self;
        if std::mem::take(is_recent_old) {
            recent.fill(u64::MAX);
        }
        let mut kept = 0;
        for i in 0..(*count).min(PENDING_PLACES) {
            let (t, m) = (slots[i], mockup_triangles[i]);
            let key = pair_key(t, m);
            let place = (key.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> (u64::BITS - RECENT_BITS)) as usize;
            // No branch: which pairs repeat is not to be foreseen.
            slots[kept] = t;
            mockup_triangles[kept] = m;
            kept += usize::from(recent[place] != key);
            recent[place] = key;
        }
        std::mem::replace(count, kept) - kept
    }
}

/// How far a query goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Until {
    /// Until all pairs are found.
    End,
    /// To the first pair.
    First,
    /// To the first pair that crosses.
    Crossing,
}

/// One query's narrow phase. Stores offer candidate pairs to it.
pub(crate) struct Narrow<'a> {
    pub at: PlacedTool<'a>,
    /// The mock-up's triangles, in the frame in which the tool is placed.
    pub corners: Corners<'a>,
    pub filters: Filters,
    pub until: Until,
    pub placed: &'a mut PlacedBounds,
    pub seen: &'a mut KeySet,
    pub pending: &'a mut Pending,
    pub hits: &'a mut Hits,
    pub stats: &'a mut Stats,
    pub pace: Pace<'a>,
}

/// Batches of pairs between two questions whether the query goes on.
pub(super) const BATCHES_BETWEEN: u32 = 64;

/// Entries of voxels' lists between two such questions. Nearly all of them may be dropped before they are in a batch.
const ENTRIES_BETWEEN: u64 = 1 << 16;

impl CandidateSink for Narrow<'_> {
    #[inline(always)]
    fn compares_boxes(&self) -> bool {
        self.filters.boxes
    }

    #[inline(always)]
    fn stats(&mut self) -> &mut Stats {
        self.stats
    }

    #[inline]
    fn placed_bounds(&mut self, slot: u32) -> Aabb {
        self.placed.of(self.at.tool, self.at.pose, slot)
    }

    /// Pairs are kept until there are enough for a batch; the last ones wait for [`finish`](Narrow::finish).
    #[inline(always)]
    fn offer_lanes<S: Simd>(&mut self, s: S, chosen: u16, slots: &[u32; LANES], mockup_triangle: u32) -> bool {
        let pending = &mut *self.pending;
        let from = pending.count;
        pending.mockup_triangles[from..from + LANES].fill(mockup_triangle);
        pending.count = s.append(chosen, slots, &mut pending.slots, from);
        prefetch_at(self.corners.faces, mockup_triangle as usize);
        pending.ask(mockup_triangle);
        self.is_batch_over()
    }

    #[inline(always)]
    fn offer_row<S: Simd>(&mut self, s: S, slot: u32, chosen: u16, ask: u16, triangles: &[u32; LANES]) -> bool {
        let Pending { asked, asked_count, .. } = &mut *self.pending;
        let first = *asked_count;
        *asked_count = s.append(ask, triangles, asked, first);
        for triangle in &asked[first..*asked_count] {
            prefetch_at(self.corners.faces, *triangle as usize);
        }
        let from = self.pending.count;
        self.pending.slots[from..from + LANES].fill(slot);
        self.pending.count = s.append(chosen, triangles, &mut self.pending.mockup_triangles, from);
        self.is_batch_over()
    }

    #[inline]
    fn offer(&mut self, slot: u32, mockup_triangle: u32, may_repeat: bool) -> bool {
        self.stats.entries_scanned += 1;
        if self.stats.entries_scanned.is_multiple_of(ENTRIES_BETWEEN) && self.pace.ask() {
            return true;
        }
        if may_repeat && self.filters.repeats && !self.seen.insert(pair_key(slot, mockup_triangle)) {
            self.stats.repeats_skipped += 1;
            return false;
        }
        if self.filters.boxes {
            let bounds = Aabb::of_triangle(&self.corners.triangle(mockup_triangle));
            if !self.placed_bounds(slot).is_overlapping(&bounds) {
                return false;
            }
        }
        self.stats.box_survivors += 1;
        let at = self.pending.count;
        self.pending.slots[at] = slot;
        self.pending.mockup_triangles[at] = mockup_triangle;
        self.pending.count += 1;
        self.pending.ask(mockup_triangle);
        self.is_batch_over()
    }
}

impl Narrow<'_> {
    #[inline(always)]
    fn is_batch_over(&mut self) -> bool {
        let batch = if self.until == Until::First { FIRST_BATCH } else { BATCH };
        self.pending.count >= batch && (self.finish() || self.pace.step())
    }

    /// Whether what was found ends the query.
    pub(crate) fn is_over(&self) -> bool {
        self.until != Until::End && !self.hits.is_empty()
    }

    /// Leaves out pairs that are not asked for.
    #[inline(never)]
    fn keep_selected(&mut self) {
        let PlacedTool { mockup, tool, selection, .. } = self.at;
        let Pending { slots, mockup_triangles, count, .. } = &mut *self.pending;
        let mut kept = 0;
        for i in 0..(*count).min(PENDING_PLACES) {
            let (t, m) = (slots[i], mockup_triangles[i]);
            // No branch, as for repeats.
            slots[kept] = t;
            mockup_triangles[kept] = m;
            kept += usize::from(selection.wants(tool, mockup, t, m));
        }
        *count = kept;
    }

    /// Tests the pairs kept so far; true when the query is over.
    #[inline(never)]
    pub(crate) fn finish(&mut self) -> bool {
        if self.pending.count == 0 {
            return false;
        }
        if !self.at.selection.is_everything() {
            self.keep_selected();
        }
        if self.filters.repeats && self.pending.is_repeating {
            let offered = self.pending.count;
            let skipped = self.pending.skip_repeats();
            self.stats.repeats_skipped += skipped as u64;
            self.pending.is_repeating = MANY_REPEATS * skipped >= offered;
        }
        let Pending { slots, mockup_triangles, count, asked, asked_count, crossing, .. } = &mut *self.pending;
        let count = std::mem::take(count);
        self.stats.triangle_tests += count as u64;
        // Corners are prefetched before they are used, so that their cache misses overlap: the mock-up's as the test goes.
        let lines = self.at.tool.lines();
        let asked = &asked[..std::mem::take(asked_count).min(PENDING_PLACES)];
        slots[..count].iter().for_each(|slot| prefetch_at(lines, *slot as usize));
        if count == 0 {
            return false;
        }
        // The last register is filled up with the last pair.
        for i in count..count.next_multiple_of(LANES) {
            (slots[i], mockup_triangles[i]) = (slots[count - 1], mockup_triangles[count - 1]);
        }
        let PlacedTool { tool, pose, lanes, .. } = self.at;
        let corners = self.corners;
        let triangles = &mut *mockup_triangles;
        let (found, in_doubt) = lanes.run(Test { pose, tool, corners, slots, triangles, count, asked, crossing });
        let mut is_crossed = found > 0;
        let hit = |key: &u64| Hit::new(tool.ids()[(key >> 32) as usize], *key as u32, PairKind::Crossing);
        self.hits.extend(crossing[..found].iter().map(hit));
        for (slot, triangle) in slots[..in_doubt].iter().zip(&*mockup_triangles) {
            // Exact arithmetic is dear: never twice for one pair. The mark keeps these apart from the pairs offered.
            const DECIDED: u64 = 1 << 63;
            if self.filters.repeats && !self.seen.insert(DECIDED | pair_key(*slot, *triangle)) {
                continue;
            }
            let p = pose.apply_triangle(&tool.placeable()[*slot as usize]);
            let mut signs = Signs::default();
            let meeting = intersect_with(&mut signs, &p, &corners.triangle(*triangle));
            self.stats.exact_tests += u64::from(signs.exact > 0);
            if let Some(kind) = meeting {
                is_crossed |= kind == PairKind::Crossing;
                self.hits.push(Hit::new(tool.ids()[*slot as usize], *triangle, kind));
            }
        }
        match self.until {
            Until::End => false,
            Until::First => !self.hits.is_empty(),
            Until::Crossing => is_crossed,
        }
    }
}

/// Triangles whose corners are prefetched before the first pair is looked at; those of the rest as the pairs go: more than a
/// dozen lines at once do not come sooner.
const CORNERS_AHEAD: usize = 24;

/// What can be proven of the first `count` pairs: lists those that cross, and moves those in doubt to the front; returns how many
/// are of either. What follows the pairs, up to a multiple of [`LANES`], are pairs too.
struct Test<'a> {
    pose: &'a Pose,
    tool: &'a Tool,
    corners: Corners<'a>,
    slots: &'a mut [u32; PENDING_PLACES],
    triangles: &'a mut [u32; PENDING_PLACES],
    count: usize,
    /// Triangles whose corners are to be asked for, in about the order of the pairs.
    asked: &'a [u32],
    crossing: &'a mut [u64; PENDING_PLACES],
}

impl Kernel for Test<'_> {
    type Output = (usize, usize);

    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> (usize, usize) {
        let Test { pose, tool, corners, slots, triangles, count, asked, crossing } = self;
        let (mut found, mut left) = (0, 0);
        let Corners { faces, vertices } = corners;
        let lines = tool.lines();
        let part = s.part();
        let least = part.splat(least_of(pose, tool.mesh().bounds().largest_coordinate()));
        let seen = Seen::at(pose);
        let wide = 2 * S::Part::WIDE;
        let groups = count.div_ceil(wide);
        let each = asked.len().div_ceil(groups);
        let (first, rest) = asked.split_at(asked.len().min(CORNERS_AHEAD));
        let mut rest = rest.chunks(each.max(1));
        for m in first {
            prefetch_corners(vertices, &faces[*m as usize]);
        }
        for group in 0..groups {
            for m in rest.next().unwrap_or(&[]) {
                prefetch_corners(vertices, &faces[*m as usize]);
            }
            let from = wide * group;
            let (mut slot, mut triangle) = ([0; LANES], [0; LANES]);
            slot.copy_from_slice(&slots[from..from + LANES]);
            triangle.copy_from_slice(&triangles[from..from + LANES]);
            let pairs = Pairs::of(s, &seen, (lines, &slot), (faces, vertices, &triangle));
            let verdict = intersect(part, &pairs, least);
            let given = ((1u32 << (count - from).min(wide)) - 1) as u16;
            for eight in (0..wide).step_by(WIDE_LANES) {
                let mut keys = [0; WIDE_LANES];
                for lane in 0..wide.min(WIDE_LANES) {
                    keys[lane] = pair_key(slot[eight + lane], triangle[eight + lane]);
                }
                found = s.append_wide(((verdict.crossing & given) >> eight) as u8, &keys, crossing, found);
            }
            let mut doubt = given & !(verdict.crossing | verdict.apart);
            while doubt != 0 {
                let lane = doubt.trailing_zeros() as usize;
                doubt &= doubt - 1;
                (slots[left], triangles[left]) = (slot[lane], triangle[lane]);
                left += 1;
            }
        }
        (found, left)
    }
}
