//! Separating planes of near surfaces that do not collide: a greedy cover of the near pairs, found by best-first
//! search.
//!
//! The nearest pair of triangles gives a plane; every other pair that this plane separates as well is covered by it and
//! dropped; the nearest of the rest gives the next. Between two convex surfaces one plane covers all pairs, however
//! many triangles they have. Pairs come in the order of their lower bounds, so that few are ever measured.

use std::cmp::Ordering;

use crate::constants::{
    AROUND_CORNER_SHARE, COORDINATE_NOISE, DIRECTION_NOISE, DISTANCE_NOISE, DOWNHILL_SLOPE, EQUALLY_NEAR_SHARE,
    FEW_FRESH, MOST_PAIRS_AROUND_CORNER, MOST_PLANES, SAME_DIRECTION, SAME_DIRECTION_SINE, SAME_NORMAL,
    SEPARATION_SLACK, SNAP_COSINE, SORTED_AT_ONCE,
};
use crate::contact_plane::ContactPlane;
use crate::context::QueryContext;
use crate::proximity::cull::{Cull, Near, NearQuery};
use crate::surface::Surface;
use feeler_core::distance::wanted::Candidate;
use feeler_core::geometry::bounds::{Aabb, Point};
use feeler_core::geometry::distance_lanes::{closest_apart, held_apart};
use feeler_core::geometry::distance_triangle_triangle::{closest_within, Closest};
use feeler_core::geometry::vectors::{add, along, dot, length, normal, scaled, square_to_segment, sub, unit};
use feeler_core::index::interner::{pair_key, Interner};
use feeler_core::index::sink::Divider;
use feeler_core::{Error, Gap, Pace, Result, Triangle};
use feeler_lanes::{Checked, Kernel, Simd, WIDE_LANES};

/// Searches the separating planes of one part after the other.
pub(crate) struct PlaneSearch<'a> {
    context: &'a QueryContext<'a>,
    /// Metres.
    margin: f64,
    scratch: &'a mut NearScratch,
}

/// Steps of a search between two questions whether it goes on: eight pairs measured, or one looked at.
const STEPS_BETWEEN: u32 = 1024;

/// Working memory.
#[derive(Debug, Default)]
pub(crate) struct NearScratch {
    cull: Cull,
    near: Vec<Near>,
    entries: Entries,
    /// The pairs measured, and their gaps: `None` where farther than the margin.
    measured: Interner,
    gaps: Vec<Option<Gap>>,
    /// The planes found.
    planes: PlaneLanes,
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

/// Planes, eight side by side.
#[derive(Debug, Default)]
struct PlaneLanes {
    batches: Vec<PlaneBatch>,
    len: usize,
}

#[derive(Debug)]
struct PlaneBatch {
    points: [[f64; WIDE_LANES]; 3],
    normals: [[f64; WIDE_LANES]; 3],
    gaps: [f64; WIDE_LANES],
}

impl PlaneLanes {
    fn set(&mut self, planes: &[ContactPlane]) {
        self.batches.clear();
        self.len = 0;
        planes.iter().for_each(|plane| self.push(plane));
    }

    fn push(&mut self, plane: &ContactPlane) {
        let lane = self.len % WIDE_LANES;
        if lane == 0 {
            // An infinite gap in unused lanes: they separate no pair.
            let (zero, gaps) = ([[0.0; WIDE_LANES]; 3], [f64::INFINITY; WIDE_LANES]);
            self.batches.push(PlaneBatch { points: zero, normals: zero, gaps });
        }
        if let Some(batch) = self.batches.last_mut() {
            (0..3).for_each(|a| (batch.points[a][lane], batch.normals[a][lane]) = (plane.point[a], plane.normal[a]));
            batch.gaps[lane] = plane.gap;
        }
        self.len += 1;
    }

    /// Whether one of the planes, which `planes` has as well, explains a pair that none of the first `judged` does.
    fn is_explained(&self, lanes: Checked, planes: &[ContactPlane], judged: u32, gap: &Gap, tolerance: f64) -> bool {
        let first = judged as usize / WIDE_LANES;
        let (batches, planes) = (&self.batches[first..], &planes[WIDE_LANES * first..]);
        judged as usize != self.len && lanes.run(Explained { batches, planes, gap, tolerance })
    }
}

/// [`is_explained`] by any of some planes.
struct Explained<'a> {
    batches: &'a [PlaneBatch],
    planes: &'a [ContactPlane],
    gap: &'a Gap,
    tolerance: f64,
}

impl Kernel for Explained<'_> {
    type Output = bool;

    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> bool {
        let Explained { batches, planes, gap, tolerance } = self;
        let splat = |p: &Point| p.map(|x| s.wide_splat(x));
        let [mockup, tool] = [&gap.on_mockup, &gap.on_tool].map(splat);
        let to_tool = splat(&sub(&gap.on_tool, &gap.on_mockup));
        let limit = s.wide_splat(tolerance);
        let (distance, along) = (s.wide_splat(gap.distance), s.wide_splat(SAME_DIRECTION * gap.distance));
        for (i, batch) in batches.iter().enumerate() {
            let [point, n] = [&batch.points, &batch.normals].map(|p| p.each_ref().map(|x| s.wide_load(x)));
            let over = |p: &[S::F64; 3]| (p[0] - point[0]) * n[0] + (p[1] - point[1]) * n[1] + (p[2] - point[2]) * n[2];
            let gaps = s.wide_load(&batch.gaps);
            let is_between =
                !(s.bits(s.wide_above(over(&mockup), limit)) | s.bits(s.wide_above(gaps - limit, over(&tool))));
            if is_between != 0 {
                return true;
            }
            let slope = to_tool[0] * n[0] + to_tool[1] * n[1] + to_tool[2] * n[2];
            let mut is_along = !(s.bits(s.wide_above(along, slope)) | s.bits(s.wide_above(gaps, distance)));
            while is_along != 0 {
                let lane = is_along.trailing_zeros() as usize;
                is_along &= is_along - 1;
                if is_explained(&planes[WIDE_LANES * i + lane], gap, tolerance) {
                    return true;
                }
            }
        }
        false
    }
}

/// A measured pair.
#[derive(Debug, Clone, Copy)]
struct Entry {
    distance: f64,
    near: Near,
    /// As many of the planes do not explain it.
    judged: u32,
}

/// Measured pairs, the nearest first. Nearly all come before the first is taken.
#[derive(Debug, Default)]
struct Entries {
    /// The nearest last.
    sorted: Vec<Entry>,
    fresh: Vec<Entry>,
    /// Metres: of `fresh`.
    nearest: f64,
}

impl Entries {
    fn clear(&mut self) {
        self.sorted.clear();
        self.fresh.clear();
        self.nearest = f64::INFINITY;
    }

    fn push(&mut self, entry: Entry) {
        self.nearest = self.nearest.min(entry.distance);
        self.fresh.push(entry);
    }

    /// The least distance, metres; infinity where there is none.
    fn nearest(&self) -> f64 {
        self.sorted.last().map_or(f64::INFINITY, |entry| entry.distance).min(self.nearest)
    }

    fn pop(&mut self) -> Option<Entry> {
        self.nearest = f64::INFINITY;
        if self.fresh.len() > FEW_FRESH {
            self.sorted.append(&mut self.fresh);
            self.sorted.sort_unstable();
        }
        // They are about the nearest: hardly anything moves, and that once.
        self.fresh.sort_unstable();
        let (mut left, mut to) = (self.sorted.len(), self.sorted.len() + self.fresh.len());
        self.sorted.extend_from_slice(&self.fresh);
        while let Some(entry) = self.fresh.last() {
            to -= 1;
            if left > 0 && *entry < self.sorted[left - 1] {
                left -= 1;
                self.sorted[to] = self.sorted[left];
            } else {
                self.sorted[to] = *entry;
                self.fresh.pop();
            }
        }
        self.sorted.pop()
    }
}

impl Ord for Entry {
    /// The nearest is the greatest.
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

    /// Adds the planes of one part's candidates to those that `out` has of it; an error where the query is stopped. The pairs in `meeting` (sorted) collide,
    /// the triangles in `inside` (of tool and mock-up, sorted) are wholly inside the other.
    pub fn push_planes(
        &mut self,
        candidates: &[Candidate],
        meeting: &[[u32; 2]],
        inside: &[Vec<u32>; 2],
        out: &mut Vec<ContactPlane>,
    ) -> Result<()> {
        let mut pace = Pace::new(self.context.go_on, STEPS_BETWEEN);
        let part = candidates.first().map_or(0, |c| c.part);
        let tolerance = SEPARATION_SLACK * self.margin;
        let query = NearQuery { meeting, inside, margin: self.margin, tolerance };
        let scratch = &mut *self.scratch;
        scratch.measured.clear();
        scratch.gaps.clear();
        scratch.planes.set(out);
        scratch.cull.cull(self.context, candidates, out, &query, &mut scratch.near);
        // Pairs not measured yet, and those that are.
        let mut near = std::mem::take(&mut scratch.near);
        let mut entries = std::mem::take(&mut scratch.entries);
        entries.clear();
        // As many of the last pairs are in the order of their bounds, the nearest last, and none of the others is nearer.
        let mut in_order = 0;
        if !meeting.is_empty() {
            // Around a contour nearly all pairs are so near that they are measured anyway: sorting saves nothing.
            for batch in near.chunks(WIDE_LANES) {
                if pace.step() {
                    return Err(Error::Cancelled);
                }
                self.measure_all(batch, part, out, |entry| entries.push(entry));
            }
            near.clear();
        }
        let mut before = None;
        loop {
            if pace.step() {
                return Err(Error::Cancelled);
            }
            let limit = entries.nearest() + EQUALLY_NEAR_SHARE * self.margin;
            let (mut batch, mut count) = ([None; WIDE_LANES], 0);
            while count < WIDE_LANES {
                if in_order == 0 {
                    in_order = put_nearest_last(&mut near);
                }
                let Some(nearest) = near.last().filter(|near| count > 0 || near.bound <= limit) else { break };
                if !self.scratch.cull.is_separated(nearest.numbers) {
                    batch[count] = Some(*nearest);
                    count += 1;
                }
                near.pop();
                in_order -= 1;
            }
            if count > 0 {
                let batch: Vec<Near> = batch.into_iter().flatten().collect();
                self.measure_all(&batch, part, out, |entry| entries.push(entry));
                continue;
            }
            let Some(entry) = entries.pop() else { break };
            // Candidates may have a pair several times.
            if before == Some(entry.near.pair) || self.scratch.cull.is_separated(entry.near.numbers) {
                continue;
            }
            before = Some(entry.near.pair);
            let Some(first) = self.measured_gap(entry.near.pair) else { continue };
            if first.distance == 0.0
                || self.is_explained(out, entry.judged, &first)
                || !self.scratch.cull.is_in_front(self.context, &entry.near, &first)
                || !out.is_empty() && self.leads_down(&first, part)
            {
                continue;
            }
            let plane = self.plane_at(&first, entry, part, &entries.sorted, out);
            self.scratch.cull.separate(self.context.lanes, &plane, tolerance);
            self.scratch.planes.push(&plane);
            out.push(plane);
            if out.len() >= MOST_PLANES {
                break;
            }
        }
        self.scratch.entries = entries;
        self.scratch.near = near;
        Ok(())
    }

    /// After [`push_planes`](Self::push_planes): the pairs that each new plane separates.
    pub fn each_separated(&mut self, planes: &[ContactPlane], mut emit: impl FnMut(&ContactPlane, &Separated<'_>)) {
        let tolerance = SEPARATION_SLACK * self.margin;
        let NearScratch { cull, separated, .. } = &mut *self.scratch;
        cull.separated(self.context.lanes, planes, tolerance, separated);
        for (i, plane) in planes.iter().enumerate() {
            emit(plane, &Separated { cull, bits: separated, plane: i });
        }
    }

    /// Whether one of the planes found so far explains a pair that none of the first `judged` does.
    fn is_explained(&self, planes: &[ContactPlane], judged: u32, gap: &Gap) -> bool {
        let tolerance = SEPARATION_SLACK * self.margin;
        self.scratch.planes.is_explained(self.context.lanes, planes, judged, gap, tolerance)
    }

    /// The gap of a pair that was measured and is within the margin.
    fn measured_gap(&self, pair: [u32; 2]) -> Option<Gap> {
        self.scratch.measured.get(pair_key(pair[0], pair[1])).and_then(|i| self.scratch.gaps[i as usize])
    }

    /// Measures at most eight pairs that do not meet, and emits those within the margin that no plane explains.
    fn measure_all(&mut self, batch: &[Near], part: u32, planes: &[ContactPlane], mut emit: impl FnMut(Entry)) {
        let found =
            closest_apart(self.context.lanes, batch.len(), |i| self.scratch.cull.corners_of(&batch[i]), self.margin);
        for (near, closest) in batch.iter().zip(found) {
            let gap = closest.map(|c| gap_of(near.pair, part, &c));
            self.record(near.pair, gap);
            if let Some(gap) = gap.filter(|gap| !self.is_explained(planes, 0, gap)) {
                emit(Entry { distance: gap.distance, near: *near, judged: planes.len() as u32 });
            }
        }
    }

    /// The gap of a pair, where it is within `limit` (metres, at most the margin).
    fn measure_within(&mut self, pair: [u32; 2], part: u32, limit: f64) -> Option<Gap> {
        if let Some(i) = self.scratch.measured.get(pair_key(pair[0], pair[1])) {
            return self.scratch.gaps[i as usize];
        }
        let (p, q) = (self.context.tool_triangle(pair[0]), self.context.mockup_triangle(pair[1]));
        let gap = gap_of(pair, part, &closest_within(&p, &q, limit)?);
        self.record(pair, Some(gap));
        Some(gap)
    }

    fn record(&mut self, pair: [u32; 2], gap: Option<Gap>) {
        if self.scratch.measured.number(pair_key(pair[0], pair[1])).1 {
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
        nearest_last: &[Entry],
        before: &[ContactPlane],
    ) -> ContactPlane {
        let mut plane = plane_of(self.context, first);
        let mut bounds = Aabb::EMPTY;
        let limit = first.distance + EQUALLY_NEAR_SHARE * self.margin;
        let others = nearest_last.iter().rev().take_while(|e| e.distance <= limit);
        for next in std::iter::once(&entry).chain(others) {
            if self.scratch.cull.is_separated(next.near.numbers) {
                continue;
            }
            let Some(gap) = self.measure_within(next.near.pair, part, self.margin) else { continue };
            let to_tool = sub(&gap.on_tool, &gap.on_mockup);
            let is_first = next.near.pair == entry.near.pair;
            let is_along =
                || gap.distance <= limit && dot(&to_tool, &plane.normal) >= gap.distance * (1.0 - SAME_NORMAL);
            if is_first || is_along() && !self.is_explained(before, next.judged, &gap) {
                bounds.grow(&gap.on_mockup);
                plane.tool_triangles.push(gap.tool_triangle);
                plane.mockup_triangles.push(gap.mockup_triangle);
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
                if far >> i & 1 != 0 && self.scratch.measured.get(pair_key(pair[0], pair[1])).is_none() {
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

/// Moves the nearest pairs to the end, sorted by bound, the nearest last. Returns their number.
fn put_nearest_last(near: &mut [Near]) -> usize {
    let count = near.len().min(SORTED_AT_ONCE);
    let first = near.len() - count;
    let farther = |a: &Near, b: &Near| b.bound.total_cmp(&a.bound);
    if first > 0 {
        near.select_nth_unstable_by(first, farther);
    }
    near[first..].sort_unstable_by(farther);
    count
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
