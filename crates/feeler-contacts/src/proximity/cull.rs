//! The pairs of one part that may be near, without those that planes hold apart as whole triangles: mostly few are left, and
//! only those are measured.

use crate::contact_plane::ContactPlane;
use crate::containers::interner::{BoundedInterner, Interner};
use crate::context::QueryContext;
use crate::surface::Surface;
use feeler_core::distance::wanted::Candidate;
use feeler_core::geometry::bounds::{Point, Triangle};
use feeler_core::geometry::distance_lanes::held_apart;
use feeler_core::geometry::vectors::{dot, normal, scaled, sub};
use feeler_core::Gap;
use feeler_lanes::{prefetch, Checked, Kernel, Simd, WIDE_LANES};

/// Sine by which the way to the tool may point into the mock-up's side.
const BEHIND: f64 = 1e-3;

/// Most planes that are looked at before there are pairs.
const MOST_AT_ONCE: usize = 56;

/// Pairs that are looked through faster than they are searched.
const FEW: usize = 16;

/// By surface the bit of triangles that are wholly inside the other surface; every triangle of the other has it too.
const INSIDE: [u64; 2] = [1 << 62, 1 << 63];

/// A pair of triangles with a bound on its distance, metres.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Near {
    pub bound: f64,
    /// Tool triangle and mock-up triangle.
    pub pair: [u32; 2],
    /// Their places among [`Cull::corners`].
    pub places: [u32; 2],
}

/// Triangles of one surface, each once.
#[derive(Debug, Default)]
struct Side {
    ids: Vec<u32>,
    corners: Vec<Triangle>,
    /// The planes on whose side a triangle is, one bit each; and [`INSIDE`]. A pair that shares a bit is not sought.
    held: Vec<u64>,
    /// Outward normals, zero where not known, and how high the triangles are along them, once they are asked for.
    outward: Vec<Option<(Point, f64)>>,
}

impl Side {
    fn take(&mut self, id: u32, (number, is_new): (u32, bool)) -> u32 {
        if is_new {
            self.ids.push(id);
        }
        number
    }

    fn outward(&mut self, context: &QueryContext<'_>, surface: Surface, place: u32) -> (Point, f64) {
        let i = place as usize;
        *self.outward[i].get_or_insert_with(|| {
            let n = match context.adjacency[surface].outward[self.ids[i] as usize] {
                0 => [0.0; 3],
                side => normal(&self.corners[i]).map_or([0.0; 3], |n| scaled(&n, f64::from(side))),
            };
            (n, dot(&self.corners[i][0], &n))
        })
    }
}

/// What is asked of each pair, beside planes.
pub(crate) struct NearQuery<'a> {
    /// Pairs that meet, sorted.
    pub meeting: &'a [[u32; 2]],
    /// Triangles of tool and mock-up that are wholly inside the other, sorted.
    pub inside: &'a [Vec<u32>; 2],
    pub margin: f64,
    /// By which a pair may miss a plane, metres.
    pub tolerance: f64,
}

/// Working memory.
#[derive(Debug, Default)]
pub(crate) struct Cull {
    sides: [Side; 2],
    /// FaceNumbers of triangles of the tool, and of the mock-up.
    tool_places: BoundedInterner,
    mockup_places: Interner,
    places: Vec<[u32; 2]>,
    /// For each triangle of the tool where its pairs that meet are.
    meeting: Vec<Meeting>,
    /// Pairs that mostly meet.
    doubtful: Vec<Near>,
}

/// The pairs of a triangle of the tool that meet.
#[derive(Debug, Clone, Copy, Default)]
struct Meeting {
    from: u32,
    to: u32,
    /// A bit for each of their mock-up triangles, see [`Meeting::bit`].
    bits: u64,
}

impl Meeting {
    /// Few triangles share it, so that a pair without it surely does not meet and one with it mostly does.
    #[inline(always)]
    fn bit(mockup_triangle: u32) -> u64 {
        1 << (mockup_triangle.wrapping_mul(0x9e37_79b9) >> (u32::BITS - 6))
    }
}

impl Cull {
    fn corners(&self, surface: Surface, place: u32) -> &Triangle {
        &self.sides[surface].corners[place as usize]
    }

    /// The triangles of a pair, the tool's first.
    pub fn corners_of(&self, near: &Near) -> (&Triangle, &Triangle) {
        (self.corners(Surface::Tool, near.places[0]), self.corners(Surface::Mockup, near.places[1]))
    }

    /// Puts into `out` the candidates (of one part) that no plane holds apart, that are not clearly farther apart than the margin,
    /// that do not meet, and that are not wholly behind each other or inside.
    pub fn sift(
        &mut self,
        context: &QueryContext<'_>,
        candidates: &[Candidate],
        planes: &[ContactPlane],
        sought: &NearQuery<'_>,
        out: &mut Vec<Near>,
    ) {
        self.gather(context, candidates, sought);
        let (first, more) = planes.split_at(planes.len().min(MOST_AT_ONCE));
        for (surface, side) in Surface::BOTH.into_iter().zip(&mut self.sides) {
            for (i, eight) in first.chunks(WIDE_LANES).enumerate() {
                hold(context.lanes, eight, surface, sought.tolerance, &side.corners, &mut side.held, 8 * i);
            }
        }
        self.drop_held_and_meeting(candidates, sought, out);
        self.drop_far(context.lanes, sought.margin, out);
        out.retain(|near| !self.is_behind(context, near.places, sought));
        for plane in more {
            self.drop_held_apart(plane, sought.tolerance, out, |near| near.places);
        }
    }

    /// Puts into `out` the candidates that no plane holds apart and that do not meet.
    fn drop_held_and_meeting(&mut self, candidates: &[Candidate], sought: &NearQuery<'_>, out: &mut Vec<Near>) {
        let [tool, mockup] = &self.sides;
        let none = Near { bound: 0.0, pair: [0; 2], places: [0; 2] };
        for list in [&mut *out, &mut self.doubtful] {
            list.clear();
            list.resize(candidates.len() + 1, none);
        }
        let mut counts = [0; 2];
        for (c, places) in candidates.iter().zip(&self.places) {
            let [t, m] = places.map(|p| p as usize);
            let near = Near { bound: c.bound, pair: [c.tool_triangle, c.mockup_triangle], places: *places };
            // No branch: which are held apart and which meet is not to be foreseen.
            let is_sought = tool.held[t] & mockup.held[m] == 0;
            let is_doubtful = self.meeting[t].bits & Meeting::bit(c.mockup_triangle) != 0;
            (out[counts[0]], self.doubtful[counts[1]]) = (near, near);
            counts[0] += usize::from(is_sought & !is_doubtful);
            counts[1] += usize::from(is_sought & is_doubtful);
        }
        out.truncate(counts[0]);
        self.doubtful.truncate(counts[1]);
        for near in &self.doubtful {
            let Meeting { from, to, .. } = self.meeting[near.places[0] as usize];
            let meeting = &sought.meeting[from as usize..to as usize];
            let is_meeting = if meeting.len() <= FEW {
                meeting.iter().fold(false, |found, pair| found | (pair[1] == near.pair[1]))
            } else {
                meeting.binary_search(&near.pair).is_ok()
            };
            if !is_meeting {
                out.push(*near);
            }
        }
    }

    /// Drops pairs that are surely farther apart than the margin: mostly more than half.
    fn drop_far(&self, lanes: Checked, margin: f64, list: &mut Vec<Near>) {
        let mut kept = 0;
        for from in (0..list.len()).step_by(WIDE_LANES) {
            let count = WIDE_LANES.min(list.len() - from);
            let far = held_apart(lanes, count, |i| self.corners_of(&list[from + i]), margin);
            for i in 0..count {
                // No branch: which are dropped is not to be foreseen.
                list[kept] = list[from + i];
                kept += usize::from(far >> i & 1 == 0);
            }
        }
        list.truncate(kept);
    }

    /// Drops the pairs that a plane holds apart whatever their nearest points.
    pub fn drop_held_apart<T>(
        &self,
        plane: &ContactPlane,
        tolerance: f64,
        list: &mut Vec<T>,
        places: impl Fn(&T) -> [u32; 2],
    ) {
        let offset = dot(&plane.point, &plane.normal);
        let heights = |t: &Triangle| t.map(|p| dot(&p, &plane.normal) - offset);
        list.retain(|near| {
            let [t, m] = places(near);
            !(heights(self.corners(Surface::Mockup, m)).iter().all(|h| *h <= tolerance)
                && heights(self.corners(Surface::Tool, t)).iter().all(|h| *h >= plane.gap - tolerance))
        });
    }

    /// Finds the triangles, each once, and where they are.
    fn gather(&mut self, context: &QueryContext<'_>, candidates: &[Candidate], sought: &NearQuery<'_>) {
        self.sides.iter_mut().for_each(|side| side.ids.clear());
        self.tool_places.clear(context.tool.mesh().faces().len());
        self.mockup_places.clear();
        self.places.clear();
        let mut last = None;
        for c in candidates {
            // Those of one mock-up triangle come one after the other.
            let m = match last {
                Some((id, place)) if id == c.mockup_triangle => place,
                _ => self.sides[Surface::Mockup]
                    .take(c.mockup_triangle, self.mockup_places.number(u64::from(c.mockup_triangle))),
            };
            last = Some((c.mockup_triangle, m));
            let t = self.sides[Surface::Tool].take(c.tool_triangle, self.tool_places.number(c.tool_triangle));
            self.places.push([t, m]);
        }
        self.find_meeting(sought.meeting);
        // Loads that do not wait for each other: their cache misses overlap.
        let mesh = context.mockup.mesh();
        self.sides[Surface::Mockup].ids.iter().for_each(|m| prefetch(&mesh.faces()[*m as usize]));
        for m in &self.sides[Surface::Mockup].ids {
            mesh.faces()[*m as usize].iter().for_each(|v| prefetch(&mesh.vertices()[*v as usize]));
        }
        for (surface, side) in Surface::BOTH.into_iter().zip(&mut self.sides) {
            side.corners.clear();
            side.corners.extend(side.ids.iter().map(|id| context.triangle(surface, *id)));
            let is_inside = |id: &u32| sought.inside[surface].binary_search(id).is_ok();
            side.held.clear();
            side.held.extend(
                side.ids.iter().map(|id| INSIDE[surface.other()] | if is_inside(id) { INSIDE[surface] } else { 0 }),
            );
            side.outward.clear();
            side.outward.resize(side.ids.len(), None);
        }
    }

    /// Finds, for each triangle of the tool, which of these pairs (sorted) are its own.
    fn find_meeting(&mut self, meeting: &[[u32; 2]]) {
        self.meeting.clear();
        self.meeting.resize(self.sides[Surface::Tool].ids.len(), Meeting::default());
        let mut from = 0;
        for same in meeting.chunk_by(|p, q| p[0] == q[0]) {
            let to = from + same.len() as u32;
            if let Some(place) = self.tool_places.get(same[0][0]) {
                let bits = same.iter().fold(0, |bits, pair| bits | Meeting::bit(pair[1]));
                self.meeting[place as usize] = Meeting { from, to, bits };
            }
            from = to;
        }
    }

    /// Whether each of the two nearest points of a pair is on the outer side of the other's triangle, as far as that is known: what
    /// is inside the other solid is near its surface, but not held off by it.
    pub fn is_in_front(&mut self, context: &QueryContext<'_>, near: &Near, gap: &Gap) -> bool {
        let way = sub(&gap.on_tool, &gap.on_mockup);
        let [of_tool, of_mockup] =
            Surface::BOTH.map(|surface| self.sides[surface].outward(context, surface, near.places[surface]).0);
        dot(&of_mockup, &way) >= -BEHIND * gap.distance && dot(&of_tool, &way) <= BEHIND * gap.distance
    }

    /// Whether one of two triangles is wholly behind the other: then it is near a surface, but not held off by it.
    fn is_behind(&mut self, context: &QueryContext<'_>, places: [u32; 2], sought: &NearQuery<'_>) -> bool {
        let [of_tool, of_mockup] =
            Surface::BOTH.map(|surface| self.sides[surface].outward(context, surface, places[surface]));
        let [p, q] = Surface::BOTH.map(|surface| self.corners(surface, places[surface]));
        let highest = |t: &Triangle, n: &Point| dot(&t[0], n).max(dot(&t[1], n)).max(dot(&t[2], n));
        let is_behind = |t: &Triangle, (n, height): (Point, f64)| highest(t, &n) - height < -BEHIND * sought.margin;
        is_behind(p, of_mockup) | is_behind(q, of_tool)
    }
}

/// BitSets a bit, from `shift` on, for each of at most eight planes on whose side a triangle is: of the tool's by no less than the
/// plane's gap, of the mock-up's behind it.
fn hold(
    lanes: Checked,
    planes: &[ContactPlane],
    surface: Surface,
    tolerance: f64,
    corners: &[Triangle],
    held: &mut [u64],
    shift: usize,
) {
    // The height along the normal for the mock-up, against it for the tool, is to be no more than a limit.
    let sense = if surface == Surface::Tool { -1.0 } else { 1.0 };
    let plane = |i: usize| &planes[i.min(planes.len() - 1)];
    let normals: [Point; WIDE_LANES] = std::array::from_fn(|i| scaled(&plane(i).normal, sense));
    let limits = std::array::from_fn(|i| {
        let offset = dot(&plane(i).point, &plane(i).normal);
        sense * offset + if surface == Surface::Tool { tolerance - plane(i).gap } else { tolerance }
    });
    let chosen = u64::from(u8::MAX >> (WIDE_LANES - planes.len())) << shift;
    lanes.run(Hold { normals: &normals, limits: &limits, corners, held, shift, chosen });
}

struct Hold<'a> {
    normals: &'a [Point; WIDE_LANES],
    limits: &'a [f64; WIDE_LANES],
    corners: &'a [Triangle],
    held: &'a mut [u64],
    shift: usize,
    chosen: u64,
}

impl Kernel for Hold<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, s: S) {
        let n = s.wide_points(self.normals.each_ref());
        let limit = s.wide_load(self.limits);
        for (t, held) in self.corners.iter().zip(self.held) {
            let mut highest = limit;
            for p in t {
                let h = s.wide_splat(p[0]) * n[0] + s.wide_splat(p[1]) * n[1] + s.wide_splat(p[2]) * n[2];
                highest = s.wide_max(highest, h);
            }
            *held |= !(u64::from(s.bits(s.wide_above(highest, limit))) << self.shift) & self.chosen;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_that_meet_are_dropped_and_those_that_share_their_bit_are_not() {
        // Tool triangles with few and with many pairs that meet, and one with none.
        let (tools, mockups) = (6u32, 300u32);
        let is_meeting = |t: u32, m: u32| t > 0 && (m * m + 7 * m * t) % 97 < [0, 1, 2, 5, 20, 60][t as usize];
        let all = || (0..tools).flat_map(|t| (0..mockups).map(move |m| (t, m)));
        let meeting: Vec<[u32; 2]> = all().filter(|(t, m)| is_meeting(*t, *m)).map(|(t, m)| [t, m]).collect();
        let is_held = |t: u32, m: u32| t == 3 && m.is_multiple_of(5);
        let mut sift = Cull::default();
        sift.sides[Surface::Tool].held = (0..tools).map(|t| u64::from(is_held(t, 0))).collect();
        sift.sides[Surface::Mockup].held = (0..mockups).map(|m| u64::from(is_held(3, m))).collect();
        sift.places = all().map(|(t, m)| [t, m]).collect();
        sift.tool_places.clear(tools as usize);
        sift.sides[Surface::Tool].ids = (0..tools).collect();
        (0..tools).for_each(|t| _ = sift.tool_places.number(t));
        sift.find_meeting(&meeting);
        let candidates: Vec<Candidate> =
            all().map(|(t, m)| Candidate { bound: 0.5, part: 0, tool_triangle: t, mockup_triangle: m }).collect();
        let sought = NearQuery { meeting: &meeting, inside: &[vec![], vec![]], margin: 1.0, tolerance: 0.0 };
        let mut out = Vec::new();
        sift.drop_held_and_meeting(&candidates, &sought, &mut out);
        let mut found: Vec<[u32; 2]> = out.iter().map(|near| near.pair).collect();
        found.sort_unstable();
        let is_left = |t: u32, m: u32| !is_meeting(t, m) && !is_held(t, m);
        let expected: Vec<[u32; 2]> = all().filter(|(t, m)| is_left(*t, *m)).map(|(t, m)| [t, m]).collect();
        assert_eq!(found, expected);
        // Some share a bit with one that meets, and so were in doubt.
        assert!(sift.doubtful.len() > meeting.len() + 20, "{} {}", sift.doubtful.len(), meeting.len());
    }
}
