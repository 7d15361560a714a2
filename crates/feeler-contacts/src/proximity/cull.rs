//! Culls the candidate pairs of one part before distances are measured: pairs that planes separate as whole triangles,
//! that collide, that are farther than the margin, or behind the other surface. Usually few are left.
//!
//! Each triangle is compared with each plane once, and the results are bits of a word: testing whether a plane
//! separates a pair then costs one operation.

use crate::constants::BEHIND_SHARE;
use crate::contact_plane::ContactPlane;
use crate::containers::bounded_interner::BoundedInterner;
use crate::context::QueryContext;
use crate::surface::Surface;
use feeler_core::distance::wanted::Candidate;
use feeler_core::geometry::bounds::{Point, Triangle};
use feeler_core::geometry::distance_lanes::held_apart;
use feeler_core::geometry::vectors::{dot, normal, scaled, sub};
use feeler_core::index::interner::Interner;
use feeler_core::Gap;
use feeler_lanes::{prefetch, Checked, Kernel, Simd, WIDE_LANES};

/// Planes that have a bit: as many full registers as fit below [`INSIDE_BITS`]. Others are compared pair by pair.
const MOST_PLANE_BITS: usize = 56;

/// Meeting pairs of a triangle up to which a scan is faster than a binary search.
const FEW_MEETING: usize = 16;

/// By surface the bit of triangles that are wholly inside the other surface. Every triangle of the other has it, so that all pairs of
/// such a triangle share it.
const INSIDE_BITS: [u64; 2] = [1 << 62, 1 << 63];

/// A candidate pair.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Near {
    /// Lower bound on the distance, metres.
    pub bound: f64,
    /// Tool triangle and mock-up triangle.
    pub pair: [u32; 2],
    /// Their numbers in [`Cull`].
    pub numbers: [u32; 2],
}

/// The triangles of one surface that are in candidate pairs, by number.
#[derive(Debug, Default)]
struct Triangles {
    ids: Vec<u32>,
    corners: Vec<Triangle>,
    /// The planes on whose own side a triangle is wholly, one bit each; and [`INSIDE_BITS`]. A pair that shares a bit is dropped.
    plane_bits: Vec<u64>,
    /// Outward normals, zero where the surface is open, and the triangles' heights along them; computed when first needed.
    outward: Vec<Option<(Point, f64)>>,
    /// As `plane_bits`, of the planes passed to [`Cull::separate`].
    separated: Vec<u64>,
}

impl Triangles {
    /// Adds a triangle that is new, and gives its number.
    fn add(&mut self, id: u32, (number, is_new): (u32, bool)) -> u32 {
        if is_new {
            self.ids.push(id);
        }
        number
    }

    fn outward(&mut self, context: &QueryContext<'_>, surface: Surface, number: u32) -> (Point, f64) {
        let i = number as usize;
        *self.outward[i].get_or_insert_with(|| {
            let n = match context.adjacency[surface].outward[self.ids[i] as usize] {
                0 => [0.0; 3],
                side => normal(&self.corners[i]).map_or([0.0; 3], |n| scaled(&n, f64::from(side))),
            };
            (n, dot(&self.corners[i][0], &n))
        })
    }
}

/// The tests of each pair, besides planes.
pub(crate) struct NearQuery<'a> {
    /// Colliding pairs, sorted.
    pub meeting: &'a [[u32; 2]],
    /// Triangles of tool and mock-up that are wholly inside the other, sorted.
    pub inside: &'a [Vec<u32>; 2],
    /// Metres.
    pub margin: f64,
    /// Length by which a pair may violate a plane, metres.
    pub tolerance: f64,
}

/// Culls pairs; its working memory, and the triangles of the pairs left.
#[derive(Debug, Default)]
pub(crate) struct Cull {
    triangles: [Triangles; 2],
    /// Numbers of triangles of the tool, and of the mock-up.
    tool_numbers: BoundedInterner,
    mockup_numbers: Interner,
    /// The numbers of each candidate's triangles.
    numbers: Vec<[u32; 2]>,
    /// For each triangle of the tool the range of its pairs that meet.
    meeting: Vec<Meeting>,
    /// Pairs that may meet.
    maybe_meeting: Vec<Near>,
    /// How many planes were passed to [`Cull::separate`].
    separators: u32,
}

/// The pairs of a triangle of the tool that meet.
#[derive(Debug, Clone, Copy, Default)]
struct Meeting {
    from: u32,
    to: u32,
    /// The set of their mock-up triangles as a Bloom filter of one word, see [`Meeting::bit`].
    bits: u64,
}

impl Meeting {
    /// The bit that a mock-up triangle is hashed to: a pair whose bit is not set does not meet, one whose bit is mostly does.
    #[inline(always)]
    fn bit(mockup_triangle: u32) -> u64 {
        1 << (mockup_triangle.wrapping_mul(0x9e37_79b9) >> (u32::BITS - 6))
    }
}

impl Cull {
    fn corners(&self, surface: Surface, number: u32) -> &Triangle {
        &self.triangles[surface].corners[number as usize]
    }

    /// The triangles of a pair, the tool's first.
    pub fn corners_of(&self, near: &Near) -> (&Triangle, &Triangle) {
        (self.corners(Surface::Tool, near.numbers[0]), self.corners(Surface::Mockup, near.numbers[1]))
    }

    /// Puts into `out` the candidates (of one part) that no plane separates, that are not surely farther than the
    /// margin, that do not collide, and of which no triangle is wholly behind or inside the other.
    pub fn cull(
        &mut self,
        context: &QueryContext<'_>,
        candidates: &[Candidate],
        planes: &[ContactPlane],
        query: &NearQuery<'_>,
        out: &mut Vec<Near>,
    ) {
        self.gather(context, candidates, query);
        let (first, more) = planes.split_at(planes.len().min(MOST_PLANE_BITS));
        for (surface, of) in Surface::BOTH.into_iter().zip(&mut self.triangles) {
            for (i, eight) in first.chunks(WIDE_LANES).enumerate() {
                set_plane_bits(context.lanes, eight, surface, query.tolerance, &of.corners, &mut of.plane_bits, 8 * i);
            }
        }
        self.drop_separated_and_meeting(candidates, query, out);
        self.drop_far(context.lanes, query.margin, out);
        out.retain(|near| !self.is_behind(context, near.numbers, query));
        for plane in more {
            let offset = dot(&plane.point, &plane.normal);
            let heights = |t: &Triangle| t.map(|p| dot(&p, &plane.normal) - offset);
            out.retain(|near| {
                let (p, q) = self.corners_of(near);
                !(heights(q).iter().all(|h| *h <= query.tolerance)
                    && heights(p).iter().all(|h| *h >= plane.gap - query.tolerance))
            });
        }
    }

    /// Puts into `out` the candidates that share no bit and do not meet.
    fn drop_separated_and_meeting(&mut self, candidates: &[Candidate], query: &NearQuery<'_>, out: &mut Vec<Near>) {
        let [tool, mockup] = &self.triangles;
        let none = Near { bound: 0.0, pair: [0; 2], numbers: [0; 2] };
        for list in [&mut *out, &mut self.maybe_meeting] {
            list.clear();
            list.resize(candidates.len() + 1, none);
        }
        let mut counts = [0; 2];
        for (c, numbers) in candidates.iter().zip(&self.numbers) {
            let [t, m] = numbers.map(|number| number as usize);
            let near = Near { bound: c.bound, pair: [c.tool_triangle, c.mockup_triangle], numbers: *numbers };
            // No branch, which would be mispredicted: both lists are written, and the one that it belongs to grows.
            let is_kept = tool.plane_bits[t] & mockup.plane_bits[m] == 0;
            let may_meet = self.meeting[t].bits & Meeting::bit(c.mockup_triangle) != 0;
            (out[counts[0]], self.maybe_meeting[counts[1]]) = (near, near);
            counts[0] += usize::from(is_kept & !may_meet);
            counts[1] += usize::from(is_kept & may_meet);
        }
        out.truncate(counts[0]);
        self.maybe_meeting.truncate(counts[1]);
        for near in &self.maybe_meeting {
            let Meeting { from, to, .. } = self.meeting[near.numbers[0] as usize];
            let meeting = &query.meeting[from as usize..to as usize];
            let is_meeting = if meeting.len() <= FEW_MEETING {
                meeting.iter().fold(false, |found, pair| found | (pair[1] == near.pair[1]))
            } else {
                meeting.binary_search(&near.pair).is_ok()
            };
            if !is_meeting {
                out.push(*near);
            }
        }
    }

    /// Drops pairs that are surely farther than the margin: mostly more than half.
    fn drop_far(&self, lanes: Checked, margin: f64, list: &mut Vec<Near>) {
        let mut kept = 0;
        for from in (0..list.len()).step_by(WIDE_LANES) {
            let count = WIDE_LANES.min(list.len() - from);
            let far = held_apart(lanes, count, |i| self.corners_of(&list[from + i]), margin);
            for i in 0..count {
                // No branch, which would be mispredicted.
                list[kept] = list[from + i];
                kept += usize::from(far >> i & 1 == 0);
            }
        }
        list.truncate(kept);
    }

    /// From now on pairs that a plane separates, as whole triangles, are [separated](Self::is_separated).
    pub fn separate(&mut self, lanes: Checked, plane: &ContactPlane, tolerance: f64) {
        let offset = dot(&plane.point, &plane.normal);
        for (surface, of) in Surface::BOTH.into_iter().zip(&mut self.triangles) {
            let Triangles { corners, separated, .. } = of;
            let (limit, is_below) =
                if surface == Surface::Tool { (plane.gap - tolerance, false) } else { (tolerance, true) };
            lanes.run(Beyond {
                normal: &plane.normal,
                offset,
                limit,
                is_below,
                corners,
                bit: self.separators,
                bits: separated,
            });
        }
        self.separators += 1;
    }

    /// Whether a pair, given by its numbers, is separated.
    pub fn is_separated(&self, [t, m]: [u32; 2]) -> bool {
        let [tool, mockup] = &self.triangles;
        tool.separated[t as usize] & mockup.separated[m as usize] != 0
    }

    /// For each triangle of the tool and of the mock-up a bit for each of the first [`MOST_PLANE_BITS`] planes that separate it, as a
    /// whole, from another that it was listed with.
    pub fn separated(&mut self, lanes: Checked, planes: &[ContactPlane], tolerance: f64, out: &mut [Vec<u64>; 2]) {
        for (surface, of) in Surface::BOTH.into_iter().zip(&mut self.triangles) {
            of.plane_bits.fill(0);
            for (i, eight) in planes[..planes.len().min(MOST_PLANE_BITS)].chunks(WIDE_LANES).enumerate() {
                set_plane_bits(lanes, eight, surface, tolerance, &of.corners, &mut of.plane_bits, 8 * i);
            }
            out[surface].clear();
            out[surface].resize(of.ids.len(), 0);
        }
        let [tool, mockup] = &self.triangles;
        for [t, m] in self.numbers.iter().map(|numbers| numbers.map(|number| number as usize)) {
            let shared = tool.plane_bits[t] & mockup.plane_bits[m];
            out[Surface::Tool][t] |= shared;
            out[Surface::Mockup][m] |= shared;
        }
    }

    /// All triangles of one surface that are in candidate pairs, by number.
    pub fn corners_of_all(&self, surface: Surface) -> &[Triangle] {
        &self.triangles[surface].corners
    }

    /// Numbers the triangles and collects their corners.
    fn gather(&mut self, context: &QueryContext<'_>, candidates: &[Candidate], query: &NearQuery<'_>) {
        self.triangles.iter_mut().for_each(|of| of.ids.clear());
        self.tool_numbers.clear(context.tool.mesh().faces().len());
        self.mockup_numbers.clear();
        self.numbers.clear();
        self.separators = 0;
        let mut last = None;
        for c in candidates {
            // Pairs of one mock-up triangle are consecutive.
            let m = match last {
                Some((id, number)) if id == c.mockup_triangle => number,
                _ => self.triangles[Surface::Mockup]
                    .add(c.mockup_triangle, self.mockup_numbers.number(u64::from(c.mockup_triangle))),
            };
            last = Some((c.mockup_triangle, m));
            let t = self.triangles[Surface::Tool].add(c.tool_triangle, self.tool_numbers.number(c.tool_triangle));
            self.numbers.push([t, m]);
        }
        self.find_meeting(query.meeting);
        // Independent loads first, so that their cache misses overlap.
        let mesh = context.mockup.mesh();
        self.triangles[Surface::Mockup].ids.iter().for_each(|m| prefetch(&mesh.faces()[*m as usize]));
        for m in &self.triangles[Surface::Mockup].ids {
            mesh.faces()[*m as usize].iter().for_each(|v| prefetch(&mesh.vertices()[*v as usize]));
        }
        for (surface, of) in Surface::BOTH.into_iter().zip(&mut self.triangles) {
            of.corners.clear();
            of.corners.extend(of.ids.iter().map(|id| context.triangle(surface, *id)));
            let is_inside = |id: &u32| query.inside[surface].binary_search(id).is_ok();
            let inside_bits =
                |id: &u32| INSIDE_BITS[surface.other()] | if is_inside(id) { INSIDE_BITS[surface] } else { 0 };
            of.plane_bits.clear();
            of.plane_bits.extend(of.ids.iter().map(inside_bits));
            of.separated.clear();
            of.separated.resize(of.ids.len(), 0);
            of.outward.clear();
            of.outward.resize(of.ids.len(), None);
        }
    }

    /// Finds the range of these pairs (sorted) for each triangle of the tool.
    fn find_meeting(&mut self, meeting: &[[u32; 2]]) {
        self.meeting.clear();
        self.meeting.resize(self.triangles[Surface::Tool].ids.len(), Meeting::default());
        let mut from = 0;
        for same in meeting.chunk_by(|p, q| p[0] == q[0]) {
            let to = from + same.len() as u32;
            if let Some(number) = self.tool_numbers.get(same[0][0]) {
                let bits = same.iter().fold(0, |bits, pair| bits | Meeting::bit(pair[1]));
                self.meeting[number as usize] = Meeting { from, to, bits };
            }
            from = to;
        }
    }

    /// Whether neither of the nearest points of a pair is behind the other's triangle, if that is of a closed surface:
    /// points inside a solid are near its surface, but not stopped by it.
    pub fn is_in_front(&mut self, context: &QueryContext<'_>, near: &Near, gap: &Gap) -> bool {
        let to_tool = sub(&gap.on_tool, &gap.on_mockup);
        let [of_tool, of_mockup] =
            Surface::BOTH.map(|surface| self.triangles[surface].outward(context, surface, near.numbers[surface]).0);
        let slack = BEHIND_SHARE * gap.distance;
        dot(&of_mockup, &to_tool) >= -slack && dot(&of_tool, &to_tool) <= slack
    }

    /// Whether one of two triangles is wholly behind the other.
    fn is_behind(&mut self, context: &QueryContext<'_>, numbers: [u32; 2], query: &NearQuery<'_>) -> bool {
        let [of_tool, of_mockup] =
            Surface::BOTH.map(|surface| self.triangles[surface].outward(context, surface, numbers[surface]));
        let [p, q] = Surface::BOTH.map(|surface| self.corners(surface, numbers[surface]));
        let highest = |t: &Triangle, n: &Point| dot(&t[0], n).max(dot(&t[1], n)).max(dot(&t[2], n));
        let is_behind =
            |t: &Triangle, (n, height): (Point, f64)| highest(t, &n) - height < -BEHIND_SHARE * query.margin;
        is_behind(p, of_mockup) | is_behind(q, of_tool)
    }
}

/// Sets a bit, from `shift` on, for each of at most eight planes on whose own side a triangle is wholly: a tool's triangle above it by no
/// less than the plane's gap, a mock-up's not above it.
fn set_plane_bits(
    lanes: Checked,
    planes: &[ContactPlane],
    surface: Surface,
    tolerance: f64,
    corners: &[Triangle],
    bits: &mut [u64],
    shift: usize,
) {
    // The test is an upper limit on the height, of the tool against the normal.
    let sense = if surface == Surface::Tool { -1.0 } else { 1.0 };
    let plane = |i: usize| &planes[i.min(planes.len() - 1)];
    let normals: [Point; WIDE_LANES] = std::array::from_fn(|i| scaled(&plane(i).normal, sense));
    let limits = std::array::from_fn(|i| {
        let offset = dot(&plane(i).point, &plane(i).normal);
        sense * offset + if surface == Surface::Tool { tolerance - plane(i).gap } else { tolerance }
    });
    let chosen = u64::from(u8::MAX >> (WIDE_LANES - planes.len())) << shift;
    lanes.run(SetPlaneBits { normals: &normals, limits: &limits, corners, bits, shift, chosen });
}

struct SetPlaneBits<'a> {
    normals: &'a [Point; WIDE_LANES],
    limits: &'a [f64; WIDE_LANES],
    corners: &'a [Triangle],
    bits: &'a mut [u64],
    shift: usize,
    /// The bits of the planes, since fewer than eight are repeated to eight.
    chosen: u64,
}

impl Kernel for SetPlaneBits<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, s: S) {
        let n = s.wide_points(self.normals.each_ref());
        let limit = s.wide_load(self.limits);
        for (t, bits) in self.corners.iter().zip(self.bits) {
            let mut highest = limit;
            for p in t {
                let h = s.wide_splat(p[0]) * n[0] + s.wide_splat(p[1]) * n[1] + s.wide_splat(p[2]) * n[2];
                highest = s.wide_max(highest, h);
            }
            *bits |= !(u64::from(s.bits(s.wide_above(highest, limit))) << self.shift) & self.chosen;
        }
    }
}

/// Sets a bit for each triangle of which all corners are below a limit (metres over the plane), or none is.
struct Beyond<'a> {
    normal: &'a Point,
    offset: f64,
    limit: f64,
    is_below: bool,
    corners: &'a [Triangle],
    bit: u32,
    bits: &'a mut [u64],
}

impl Kernel for Beyond<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, s: S) {
        let n = self.normal.map(|x| s.wide_splat(x));
        let (offset, limit) = (s.wide_splat(self.offset), s.wide_splat(self.limit));
        for (eight, bits) in self.corners.chunks(WIDE_LANES).zip(self.bits.chunks_mut(WIDE_LANES)) {
            let mut outside = 0;
            for k in 0..3 {
                let p = s.wide_points(std::array::from_fn(|i| &eight[i.min(eight.len() - 1)][k]));
                let height = p[0] * n[0] + p[1] * n[1] + p[2] * n[2] - offset;
                let (over, under) = if self.is_below { (height, limit) } else { (limit, height) };
                outside |= s.bits(s.wide_above(over, under));
            }
            for (i, bits) in bits.iter_mut().enumerate() {
                *bits |= u64::from(!outside >> i & 1) << self.bit;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::{scene, tool};
    use feeler_core::geometry::distance_triangle_triangle::closest_triangle_triangle;
    use feeler_core::Pose;
    use feeler_shapes::sheet;

    #[test]
    fn pairs_left_are_near_do_not_meet_and_no_plane_separates_them() {
        // A coarse sheet that leans through a fine one: its triangles meet none, a few, or very many of the other.
        let fine = scene(sheet(40, 40, |s, t| [s, t, 0.01 * (20.0 * s).sin()]));
        let coarse = tool(sheet(3, 4, |s, t| [0.9 * s, t, 0.35 * t - 0.1]));
        let (pose, margin, tolerance) = (Pose::IDENTITY, 0.06, 1e-4);
        let pairs = fine.collide(&coarse, &pose).pairs;
        let candidates = fine.near_candidates(&coarse, &pose, margin, &[], usize::MAX).unwrap();
        let inside = [vec![7, 11], (700..800).collect()];
        let plane = |i: usize| {
            let turn = 0.7 * i as f64;
            ContactPlane {
                point: [0.5, 0.1 * (i % 10) as f64, 0.012],
                normal: [0.28 * turn.sin(), 0.28 * turn.cos(), 0.96],
                gap: 0.004 * (i % 3) as f64,
                part: 0,
                tool_triangles: Vec::new(),
                mockup_triangles: Vec::new(),
                id: 0,
                carriers: [0; 2],
                assumed: false,
            }
        };
        let context = QueryContext::new(&fine, &coarse, &pose, None);
        let mut counts = [0; 5];
        for planes in [0, 3, 8, 60] {
            let planes: Vec<ContactPlane> = (0..planes).map(plane).collect();
            let query = NearQuery { meeting: &pairs, inside: &inside, margin, tolerance };
            let (mut cull, mut out) = (Cull::default(), Vec::new());
            cull.cull(&context, &candidates, &planes, &query, &mut out);
            let mut found: Vec<[u32; 2]> = out.iter().map(|near| near.pair).collect();
            found.sort_unstable();
            found.dedup();
            let mut expected: Vec<[u32; 2]> = Vec::new();
            for pair in candidates.iter().map(|c| [c.tool_triangle, c.mockup_triangle]) {
                let (p, q) = (context.tool_triangle(pair[0]), context.mockup_triangle(pair[1]));
                let separates = |plane: &ContactPlane| {
                    let height = |x: &Point| dot(&sub(x, &plane.point), &plane.normal);
                    q.iter().all(|x| height(x) <= tolerance) && p.iter().all(|x| height(x) >= plane.gap - tolerance)
                };
                let is_meeting = pairs.contains(&pair);
                let is_inside = inside[Surface::Tool].contains(&pair[0]) || inside[Surface::Mockup].contains(&pair[1]);
                let is_separated = planes.iter().any(separates);
                let is_far = !is_meeting && closest_triangle_triangle(&p, &q).distance > margin;
                for (count, is) in counts.iter_mut().zip([is_meeting, is_inside, is_separated, is_far]) {
                    *count += usize::from(is);
                }
                if is_meeting || is_inside || is_separated {
                    assert!(found.binary_search(&pair).is_err(), "{pair:?}");
                } else if !is_far {
                    expected.push(pair);
                }
            }
            expected.sort_unstable();
            expected.dedup();
            assert!(expected.iter().all(|pair| found.binary_search(pair).is_ok()), "{}", planes.len());
            counts[4] += expected.len();
        }
        assert!(counts.iter().all(|count| *count > 100), "{counts:?}");
    }
}
