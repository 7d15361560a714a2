//! The narrow phase of a mock-up against itself: pairs of triangles in batches, in lanes first, then by exact signs for
//! the undecided ones; for two parts only until it is known whether they cross.

use super::asked::{in_order, PairLimits};
use super::meets::{Meets, Touch};
use super::pair_table::PairTable;
use crate::constants::LEAST_ENTRY;
use crate::geometry::intersect_lanes::{intersect, line_of, Pairs, Seen};
use crate::geometry::intersect_triangle_triangle::{intersect_triangle_triangle, PairKind};
use crate::geometry::pose::Pose;
use crate::index::sink::SelfSink;
use crate::mesh::mockup::Mockup;
use crate::mesh::triangle_mesh::{prefetch_corners, Mesh};
use feeler_lanes::{prefetch_at, Arithmetic, CacheLine, Checked, Kernel, Simd, LANES};

/// Pairs tested at a time, as for a tool.
const PAIRS_A_BATCH: usize = 128;
/// The most that one step adds.
const STEP: usize = 2 * LANES;
const PLACES: usize = PAIRS_A_BATCH + STEP;

/// The findings on a pair of parts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Known {
    /// The pair is not asked, or its answer is known.
    Done,
    /// Nothing that meets, so far.
    Apart,
    /// Triangles that touch or lie in one plane, none that cross.
    Touching,
}

/// Working memory of one search at a time.
#[derive(Debug)]
pub(crate) struct NarrowScratch {
    /// Of no more than one search: shares of it that run one after the other learn from each other, unless it grows large.
    known: PairTable<Known>,
    lines: Vec<CacheLine>,
    /// By piece of the block at work the place of its line.
    places: [u32; STEP],
    firsts: [u32; PLACES],
    seconds: [u32; PLACES],
    /// The triangle that the line is of.
    owners: [u32; PLACES],
    count: usize,
}

impl Default for NarrowScratch {
    fn default() -> NarrowScratch {
        NarrowScratch {
            known: PairTable::new(),
            lines: Vec::new(),
            places: [u32::MAX; STEP],
            firsts: [0; PLACES],
            seconds: [0; PLACES],
            owners: [0; PLACES],
            count: 0,
        }
    }
}

impl NarrowScratch {
    /// Called before each share of a search.
    pub(crate) fn begin_share(&mut self) {
        self.known.begin_share();
    }
}

/// A search for parts that meet.
pub(crate) struct MeetingNarrow<'a> {
    pub mockup: &'a Mockup,
    pub limits: &'a PairLimits,
    /// Pairs whose answer is known beforehand; sorted.
    pub decided: &'a [[u32; 2]],
    pub lanes: Checked,
    pub scratch: &'a mut NarrowScratch,
    /// Colliding parts found by this share of the search, and two of their colliding triangles, that of the lesser part
    /// first.
    pub found: Vec<([u32; 2], Meets, [u32; 2])>,
    /// Pairs of triangles that touch, of parts of which none was known to cross.
    pub touches: Vec<Touch>,
}

impl SelfSink for MeetingNarrow<'_> {
    #[inline]
    fn wants(&mut self, part: u32, other: u32) -> bool {
        *self.known(part, other) != Known::Done
    }

    #[inline(always)]
    fn begin_block(&mut self) {
        self.scratch.places = [u32::MAX; STEP];
    }

    #[inline(always)]
    fn offer<S: Simd>(&mut self, s: S, piece: u32, triangle: u32, chosen: u32, others: &[u32; 2 * LANES]) {
        let mesh = self.mockup.mesh();
        let NarrowScratch { lines, places, firsts, seconds, owners, count, .. } = &mut *self.scratch;
        let place = &mut places[piece as usize];
        if *place == u32::MAX {
            *place = lines.len() as u32;
            lines.push(line_of(&mesh.triangle(triangle)));
        }
        let from = *count;
        firsts[from..from + STEP].fill(*place);
        owners[from..from + STEP].fill(triangle);
        for half in 0..2 {
            let lanes = (chosen >> (LANES * half)) as u16;
            let of_half = others[LANES * half..].first_chunk().expect("a half of them");
            *count = s.append(lanes, of_half, seconds, *count);
        }
        for other in &seconds[from..*count] {
            prefetch_at(mesh.faces(), *other as usize);
        }
        if *count >= PAIRS_A_BATCH {
            self.finish();
        }
    }
}

impl MeetingNarrow<'_> {
    #[inline]
    fn known(&mut self, part: u32, other: u32) -> &mut Known {
        let [a, b] = in_order([part, other]);
        let (limits, decided) = (self.limits, self.decided);
        self.scratch.known.of(a, b, || {
            let is_asked = limits.clearance(a, b).is_some() && decided.binary_search(&[a, b]).is_err();
            if is_asked {
                Known::Apart
            } else {
                Known::Done
            }
        })
    }

    /// Tests the pairs kept so far.
    #[inline(never)]
    pub fn finish(&mut self) {
        let NarrowScratch { lines, places, firsts, seconds, owners, count, .. } = &mut *self.scratch;
        let given = std::mem::take(count);
        if given == 0 {
            return;
        }
        let mesh = self.mockup.mesh();
        for i in given..given.next_multiple_of(LANES) {
            (firsts[i], seconds[i]) = (firsts[given - 1], seconds[given - 1]);
        }
        let mut crossing = [0u16; PLACES / LANES];
        let mut doubt = [0u16; PLACES / LANES];
        self.lanes.run(Test { mesh, lines, firsts, seconds, given, crossing: &mut crossing, doubt: &mut doubt });
        lines.clear();
        *places = [u32::MAX; STEP];
        let (owners, seconds) = (*owners, *seconds);
        for group in 0..given.div_ceil(LANES) {
            let mut rest = crossing[group];
            while rest != 0 {
                let i = LANES * group + rest.trailing_zeros() as usize;
                rest &= rest - 1;
                self.note(owners[i], seconds[i], Meets::Crossing);
            }
        }
        for group in 0..given.div_ceil(LANES) {
            let mut rest = doubt[group];
            while rest != 0 {
                let i = LANES * group + rest.trailing_zeros() as usize;
                rest &= rest - 1;
                let [a, b] = [owners[i], seconds[i]];
                let parts = [a, b].map(|t| self.mockup.part_of_face(t));
                if *self.known(parts[0], parts[1]) == Known::Done {
                    continue;
                }
                match intersect_triangle_triangle(&mesh.triangle(a), &mesh.triangle(b)) {
                    Some(PairKind::Crossing) => self.note(a, b, Meets::Crossing),
                    Some(kind) => {
                        self.note(a, b, Meets::Touching);
                        self.touches.push(Touch::new(self.mockup, [a, b], kind));
                    }
                    None => {}
                }
            }
        }
    }

    fn note(&mut self, a: u32, b: u32, meets: Meets) {
        let parts = in_order([a, b].map(|t| self.mockup.part_of_face(t)));
        let known = self.known(parts[0], parts[1]);
        let new = if meets == Meets::Crossing { Known::Done } else { Known::Touching };
        if *known != Known::Done && *known != new {
            *known = new;
            let triangles = if self.mockup.part_of_face(a) == parts[0] { [a, b] } else { [b, a] };
            self.found.push((parts, meets, triangles));
        }
    }
}

/// What can be proven of the first `given` pairs, a bit each. What follows them, up to a multiple of [`LANES`], are pairs too.
struct Test<'a> {
    mesh: &'a Mesh,
    lines: &'a [CacheLine],
    firsts: &'a [u32; PLACES],
    seconds: &'a [u32; PLACES],
    given: usize,
    crossing: &'a mut [u16; PLACES / LANES],
    doubt: &'a mut [u16; PLACES / LANES],
}

/// Triangles whose corners are prefetched ahead of their test.
const TRIANGLES_AHEAD: usize = 2 * LANES;

impl Kernel for Test<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, s: S) {
        let Test { mesh, lines, firsts, seconds, given, crossing, doubt } = self;
        let (faces, vertices) = (mesh.faces(), mesh.vertices());
        let part = s.part();
        // Nothing is moved, so no place is rounded, and the smallest entries count exactly.
        let (least, seen) = (part.splat(LEAST_ENTRY), Seen::at(&Pose::IDENTITY));
        let wide = 2 * S::Part::WIDE;
        for m in &seconds[..given.min(TRIANGLES_AHEAD)] {
            prefetch_corners(vertices, &faces[*m as usize]);
        }
        for from in (0..given).step_by(wide) {
            for m in seconds[..given].iter().skip(from + TRIANGLES_AHEAD).take(wide) {
                prefetch_corners(vertices, &faces[*m as usize]);
            }
            let pairs = Pairs::of(s, &seen, (lines, &firsts[from..]), (faces, vertices, &seconds[from..]));
            let verdict = intersect(part, &pairs, least);
            let is_given = ((1u32 << (given - from).min(wide)) - 1) as u16;
            crossing[from / LANES] |= (verdict.crossing & is_given) << (from % LANES);
            doubt[from / LANES] |= (is_given & !(verdict.crossing | verdict.apart)) << (from % LANES);
        }
    }
}
