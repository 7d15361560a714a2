//! Separating planes of what is near and does not meet: a greedy cover of the near pairs, found by best-first search.
//!
//! The nearest pair of triangles gives a plane; every other pair that this plane separates as well is explained by it and dropped;
//! the nearest of the rest gives the next. Between two convex surfaces one plane explains all, however many triangles they have.
//! Pairs come in the order of their lower bounds, so that few are ever measured.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use crate::constants::{
    AROUND_CORNER_SHARE, COORDINATE_NOISE, DIRECTION_NOISE, DISTANCE_NOISE, DOWNHILL_SLOPE, EQUALLY_NEAR_SHARE,
    MOST_PAIRS_AROUND_CORNER, MOST_PLANES, SAME_DIRECTION, SAME_DIRECTION_SINE, SAME_NORMAL, SEPARATION_SLACK,
    SNAP_COSINE,
};
use crate::contact_plane::ContactPlane;
use crate::containers::interner::{pair_key, Interner};
use crate::context::QueryContext;
use crate::proximity::cull::{Cull, Near, NearQuery};
use crate::surface::Surface;
use feeler_core::distance::wanted::Candidate;
use feeler_core::geometry::bounds::{Aabb, Point};
use feeler_core::geometry::distance_lanes::{closest_apart, held_apart};
use feeler_core::geometry::distance_triangle_triangle::{closest_within, Closest};
use feeler_core::geometry::vectors::{add, along, dot, length, normal, scaled, square_to_segment, sub, unit};
use feeler_core::index::sink::Divider;
use feeler_core::{Gap, Triangle};
use feeler_lanes::WIDE_LANES;

/// Searches the separating planes of one part after the other.
pub(crate) struct PlaneSearch<'a> {
    context: &'a QueryContext<'a>,
    /// Metres.
    margin: f64,
    scratch: &'a mut NearScratch,
}

/// Working memory.
#[derive(Debug, Default)]
pub(crate) struct NearScratch {
    cull: Cull,
    near: Vec<Near>,
    entries: Vec<Entry>,
    /// The pairs measured, and their gaps: `None` where farther than the margin.
    measured: Interner,
    gaps: Vec<Option<Gap>>,
    /// By surface and number of the triangle a bit for each plane that separates it.
    separated: [Vec<u64>; 2],
}

/// The triangles that one plane separates, of those near each other.
pub(crate) struct Separated<'a> {
    cull: &'a Cull,
    bits: &'a [Vec<u64>; 2],
    plane: usize,
}

impl Separated<'_> {
    /// World.
    pub fn of_tool(&self) -> impl Iterator<Item = &Triangle> {
        self.of(Surface::Tool)
    }

    /// World.
    pub fn of_mockup(&self) -> impl Iterator<Item = &Triangle> {
        self.of(Surface::Mockup)
    }

    fn of(&self, surface: Surface) -> impl Iterator<Item = &Triangle> {
        let all = self.cull.corners_of_all(surface).iter().zip(&self.bits[surface]);
        all.filter(|(_, bits)| *bits >> self.plane & 1 != 0).map(|(triangle, _)| triangle)
    }
}

/// A measured pair in the heap.
#[derive(Debug, Clone, Copy)]
struct Entry {
    distance: f64,
    near: Near,
}

impl Ord for Entry {
    /// The nearest is the greatest, which a heap gives first.
    fn cmp(&self, other: &Entry) -> Ordering {
        other.distance.total_cmp(&self.distance).then(other.near.pair.cmp(&self.near.pair))
    }
}

impl PartialOrd for Entry {
    fn partial_cmp(&self, other: &Entry) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Entry {
    fn eq(&self, other: &Entry) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Entry {}

impl<'a> PlaneSearch<'a> {
    pub fn new(context: &'a QueryContext<'a>, margin: f64, scratch: &'a mut NearScratch) -> PlaneSearch<'a> {
        PlaneSearch { context, margin, scratch }
    }

    /// Adds the planes of one part's candidates to those that `out` has of it. The pairs in `meeting` (sorted) meet, the triangles in
    /// `inside` (of tool and mock-up, sorted) are wholly inside the other.
    pub fn push_planes(
        &mut self,
        candidates: &[Candidate],
        meeting: &[[u32; 2]],
        inside: &[Vec<u32>; 2],
        out: &mut Vec<ContactPlane>,
    ) {
        let part = candidates.first().map_or(0, |c| c.part);
        let tolerance = SEPARATION_SLACK * self.margin;
        let query = NearQuery { meeting, inside, margin: self.margin, tolerance };
        let scratch = &mut *self.scratch;
        scratch.measured.clear();
        scratch.gaps.clear();
        scratch.cull.cull(self.context, candidates, out, &query, &mut scratch.near);
        // Pairs not measured yet, the nearest last, and a heap of those that are.
        let mut near = std::mem::take(&mut scratch.near);
        let mut entries = std::mem::take(&mut scratch.entries);
        entries.clear();
        if meeting.is_empty() {
            near.sort_unstable_by(|a, b| b.bound.total_cmp(&a.bound));
        } else {
            // Around a contour nearly all pairs are so near that they are measured anyway: sorting saves nothing.
            near.chunks(WIDE_LANES).for_each(|batch| self.measure_all(batch, part, out, |entry| entries.push(entry)));
            near.clear();
        }
        let mut heap = BinaryHeap::from(entries);
        let mut before = None;
        loop {
            let nearest = heap.peek().map_or(f64::INFINITY, |entry: &Entry| entry.distance);
            if near.last().is_some_and(|near| near.bound <= nearest + EQUALLY_NEAR_SHARE * self.margin) {
                let from = near.len().saturating_sub(WIDE_LANES);
                self.measure_all(&near[from..], part, out, |entry| heap.push(entry));
                near.truncate(from);
                continue;
            }
            let Some(entry) = heap.pop() else { break };
            // Candidates may have a pair several times.
            if before == Some(entry.near.pair) {
                continue;
            }
            before = Some(entry.near.pair);
            let Some(first) = self.measured_gap(entry.near.pair) else { continue };
            if first.distance == 0.0
                || out.iter().any(|plane| is_explained(plane, &first, tolerance))
                || !self.scratch.cull.is_in_front(self.context, &entry.near, &first)
                || !out.is_empty() && self.leads_down(&first, part)
            {
                continue;
            }
            let plane = self.plane_at(&first, entry, part, &mut heap, out);
            let mut entries = heap.into_vec();
            self.scratch.cull.drop_separated(&plane, tolerance, &mut entries, |entry| entry.near.numbers);
            self.scratch.cull.drop_separated(&plane, tolerance, &mut near, |near| near.numbers);
            heap = BinaryHeap::from(entries);
            out.push(plane);
            if out.len() >= MOST_PLANES {
                break;
            }
        }
        self.scratch.entries = heap.into_vec();
        self.scratch.near = near;
    }

    /// After [`push_planes`](Self::push_planes): what each of the planes it found separates.
    pub fn each_separated(&mut self, planes: &[ContactPlane], mut emit: impl FnMut(&ContactPlane, &Separated<'_>)) {
        let tolerance = SEPARATION_SLACK * self.margin;
        let NearScratch { cull, separated, .. } = &mut *self.scratch;
        cull.separated(self.context.lanes, planes, tolerance, separated);
        for (i, plane) in planes.iter().enumerate() {
            emit(plane, &Separated { cull, bits: separated, plane: i });
        }
    }

    /// The gap of a pair that was measured and is within the margin.
    fn measured_gap(&self, pair: [u32; 2]) -> Option<Gap> {
        self.scratch.measured.get(pair_key(pair)).and_then(|i| self.scratch.gaps[i as usize])
    }

    /// Measures at most eight pairs that do not meet, and emits those within the margin that no plane explains.
    fn measure_all(&mut self, batch: &[Near], part: u32, planes: &[ContactPlane], mut emit: impl FnMut(Entry)) {
        let tolerance = SEPARATION_SLACK * self.margin;
        let found =
            closest_apart(self.context.lanes, batch.len(), |i| self.scratch.cull.corners_of(&batch[i]), self.margin);
        for (near, closest) in batch.iter().zip(found) {
            let gap = closest.map(|c| gap_of(near.pair, part, &c));
            self.record(near.pair, gap);
            if let Some(gap) = gap.filter(|gap| !planes.iter().any(|p| is_explained(p, gap, tolerance))) {
                emit(Entry { distance: gap.distance, near: *near });
            }
        }
    }

    /// The gap of a pair, where it is within `limit` (metres, at most the margin).
    fn measure_within(&mut self, pair: [u32; 2], part: u32, limit: f64) -> Option<Gap> {
        if let Some(i) = self.scratch.measured.get(pair_key(pair)) {
            return self.scratch.gaps[i as usize];
        }
        let (p, q) = (self.context.tool_triangle(pair[0]), self.context.mockup_triangle(pair[1]));
        let gap = gap_of(pair, part, &closest_within(&p, &q, limit)?);
        self.record(pair, Some(gap));
        Some(gap)
    }

    fn record(&mut self, pair: [u32; 2], gap: Option<Gap>) {
        if self.scratch.measured.number(pair_key(pair)).1 {
            self.scratch.gaps.push(gap);
        }
    }

    /// The plane of the nearest pair, with its point in the middle of all pairs that are equally near and that no plane before explains.
    /// Pairs that one does explain are left out here as well as when they are measured, so that the order of measuring does not show.
    fn plane_at(
        &mut self,
        first: &Gap,
        entry: Entry,
        part: u32,
        heap: &mut BinaryHeap<Entry>,
        before: &[ContactPlane],
    ) -> ContactPlane {
        let tolerance = SEPARATION_SLACK * self.margin;
        let mut plane = plane_of(self.context, first);
        let mut bounds = Aabb::EMPTY;
        let limit = first.distance + EQUALLY_NEAR_SHARE * self.margin;
        let mut equally_near = vec![entry];
        while let Some(next) = heap.peek().filter(|e| e.distance <= limit).copied() {
            heap.pop();
            equally_near.push(next);
        }
        for next in equally_near {
            let Some(gap) = self.measure_within(next.near.pair, part, self.margin) else { continue };
            let to_tool = sub(&gap.on_tool, &gap.on_mockup);
            let is_first = next.near.pair == entry.near.pair;
            let is_along =
                || gap.distance <= limit && dot(&to_tool, &plane.normal) >= gap.distance * (1.0 - SAME_NORMAL);
            if is_first || is_along() && !before.iter().any(|plane| is_explained(plane, &gap, tolerance)) {
                bounds.grow(&gap.on_mockup);
                plane.tool_triangles.push(gap.tool_triangle);
                plane.mockup_triangles.push(gap.mockup_triangle);
            }
            if !is_first {
                heap.push(next);
            }
        }
        if !bounds.is_empty() {
            let middle = scaled(&add(&bounds.lower, &bounds.upper), 0.5);
            plane.point = along(&middle, dot(&sub(&plane.point, &middle), &plane.normal), &plane.normal);
        }
        plane
    }

    /// Whether a step to a neighbouring triangle, on either surface, leads clearly down: then the pair is on the slope of a local minimum
    /// of the distance, which has a plane or will. Where the nearest points are on edges or corners, all pairs around these are
    /// neighbours.
    fn leads_down(&mut self, gap: &Gap, part: u32) -> bool {
        let start = [gap.tool_triangle, gap.mockup_triangle];
        let noise = (DISTANCE_NOISE * gap.distance).powi(2);
        let context = self.context;
        let is_on_border = |surface: Surface, id: u32, p: &Point| {
            let t = context.triangle(surface, id);
            (0..3).any(|k| square_to_segment(p, &t[k], &t[(k + 1) % 3]) <= noise)
        };
        // A farther pair neither leads down nor shares the corner or edge.
        let limit = (gap.distance * (1.0 + AROUND_CORNER_SHARE)).min(self.margin);
        let is_down = |other: &Gap| {
            let step = length(&sub(&other.on_tool, &gap.on_tool)).max(length(&sub(&other.on_mockup, &gap.on_mockup)));
            gap.distance - other.distance > DOWNHILL_SLOPE * step + DISTANCE_NOISE * gap.distance
        };
        // Nearer pairs came first, so that the one that leads down is mostly measured.
        if context.neighbour_pairs(start).any(|pair| self.measured_gap(pair).is_some_and(|other| is_down(&other))) {
            return true;
        }
        let mut seen = vec![start];
        let mut next = 0;
        while next < seen.len() && seen.len() <= MOST_PAIRS_AROUND_CORNER {
            let from = seen[next];
            next += 1;
            let (mut unseen, mut count) = ([start; WIDE_LANES], 0);
            for pair in context.neighbour_pairs(from).filter(|pair| !seen.contains(pair)) {
                unseen[count] = pair;
                count += 1;
            }
            // Most are too far, which one test of all lanes finds.
            let corners = unseen.map(|[t, m]| (context.tool_triangle(t), context.mockup_triangle(m)));
            let far = held_apart(context.lanes, count, |i| (&corners[i].0, &corners[i].1), limit);
            for (i, pair) in unseen.into_iter().enumerate().take(count) {
                if far >> i & 1 != 0 && self.scratch.measured.get(pair_key(pair)).is_none() {
                    continue;
                }
                let Some(other) = self.measure_within(pair, part, limit) else { continue };
                if is_down(&other) {
                    return true;
                }
                if (pair[0] == from[0] || is_on_border(Surface::Tool, pair[0], &gap.on_tool))
                    && (pair[1] == from[1] || is_on_border(Surface::Mockup, pair[1], &gap.on_mockup))
                {
                    // Around the same corner or edge.
                    seen.push(pair);
                }
            }
        }
        false
    }
}

fn gap_of(pair: [u32; 2], part: u32, closest: &Closest) -> Gap {
    Gap {
        tool_triangle: pair[0],
        mockup_triangle: pair[1],
        part,
        // A plane has it of the triangle that carries it.
        tool_part: 0,
        distance: closest.distance,
        on_tool: closest.on_p,
        on_mockup: closest.on_q,
    }
}

/// The half-spaces that a plane separates, for the index: pairs across them are not listed as candidates.
pub(crate) fn divider(plane: &ContactPlane, margin: f64) -> Divider {
    let (offset, tolerance) = (dot(&plane.point, &plane.normal), SEPARATION_SLACK * margin);
    Divider { part: plane.part, normal: plane.normal, heights: [offset + tolerance, offset + plane.gap - tolerance] }
}

/// Whether a plane explains a pair: it separates the nearest points by no less than its gap; or the pair has about its normal, is no
/// nearer, and is on a surface that turns no more than that away from the plane.
fn is_explained(plane: &ContactPlane, gap: &Gap, tolerance: f64) -> bool {
    let from = sub(&gap.on_mockup, &plane.point);
    let height = dot(&from, &plane.normal);
    let above = dot(&sub(&gap.on_tool, &plane.point), &plane.normal);
    if height <= tolerance && above >= plane.gap - tolerance {
        return true;
    }
    let to_tool = sub(&gap.on_tool, &gap.on_mockup);
    dot(&to_tool, &plane.normal) >= SAME_DIRECTION * gap.distance
        && gap.distance >= plane.gap
        && height.abs() <= SAME_DIRECTION_SINE * length(&from) + tolerance
}

/// The plane through the nearest points of a pair: perpendicular to the line between them, or snapped to a triangle's plane.
fn plane_of(context: &QueryContext<'_>, gap: &Gap) -> ContactPlane {
    let to_tool = sub(&gap.on_tool, &gap.on_mockup);
    let own = |t| normal(&t).map(|n| if dot(&n, &to_tool) < 0.0 { scaled(&n, -1.0) } else { n });
    let of_mockup: Option<Point> = own(context.mockup_triangle(gap.mockup_triangle));
    let of_tool: Option<Point> = own(context.tool_triangle(gap.tool_triangle));
    let direct = unit(&to_tool).or(of_mockup).unwrap_or([0.0, 0.0, 1.0]);
    // The direction between nearly coincident points is noise; there the triangles' normals count.
    let largest = gap.on_mockup.iter().fold(0.0f64, |m, x| m.max(x.abs()));
    let noise = DIRECTION_NOISE + COORDINATE_NOISE * largest / gap.distance;
    let is_snapped = |n: &Point| 1.0 - dot(n, &direct) <= SNAP_COSINE.max(noise * noise);
    let snapped = [of_mockup, of_tool].into_iter().flatten().find(is_snapped);
    ContactPlane {
        point: gap.on_mockup,
        normal: snapped.unwrap_or(direct),
        gap: gap.distance,
        part: gap.part,
        tool_triangles: Vec::new(),
        mockup_triangles: Vec::new(),
        id: 0,
        carriers: [gap.tool_triangle, gap.mockup_triangle],
        assumed: false,
    }
}
