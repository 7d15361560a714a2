//! Planes for what is near and does not meet.
//!
//! The nearest pair of triangles gives a plane; every other pair that this plane holds apart as well is explained by it and
//! dropped; the nearest of the rest gives the next. Between two bulging surfaces one plane explains all, however many
//! triangles they have.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use crate::constants::{MOST_PLANES, SAME_DIRECTION};
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
use feeler_core::Gap;
use feeler_lanes::WIDE_LANES;

/// Share of the margin by which a pair may miss a plane and still count as explained.
const TOLERANCE: f64 = 0.01;

/// Sine of the same.
const SAME_TURN: f64 = 0.208;

/// A step down to a neighbouring pair counts from this slope on: along a hollow surface around the tool the distance changes
/// slowly, and each direction is to have its plane.
const SLOPE: f64 = 0.2;

/// Share of the margin within which pairs are as near as each other.
const LEVEL: f64 = 1e-6;

/// Most pairs looked at around a corner.
const MOST_BESIDE: usize = 256;

/// A plane that a triangle's own differs from by less (1 - cosine) is that triangle's: normals then do not depend on rounding.
const SNAP: f64 = 1e-10;

/// The pairs of one part that may be near, as they are found out about.
pub(crate) struct NearPairs<'a> {
    context: &'a QueryContext<'a>,
    margin: f64,
    lists: &'a mut NearScratch,
}

/// Working memory.
#[derive(Debug, Default)]
pub(crate) struct NearScratch {
    sift: Cull,
    near: Vec<Near>,
    entries: Vec<Entry>,
    /// What was measured, and `None` where that is farther than the margin.
    measured: Interner,
    gaps: Vec<Option<Gap>>,
}

/// A pair that was measured.
#[derive(Debug, Clone, Copy)]
struct Entry {
    distance: f64,
    near: Near,
}

impl Ord for Entry {
    /// The nearest is the greatest: a heap gives that first.
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

impl<'a> NearPairs<'a> {
    pub fn new(context: &'a QueryContext<'a>, margin: f64, lists: &'a mut NearScratch) -> NearPairs<'a> {
        NearPairs { context, margin, lists }
    }

    /// Adds planes for the candidates of one part, beside those that `out` has of it. The pairs in `meeting` (sorted) meet, the
    /// triangles in `inside` (of tool and mock-up, sorted) are wholly inside the other.
    ///
    /// Of a part that is only near few pairs are ever measured: most are far from where planes are, or held apart by one as whole
    /// triangles.
    pub fn push_planes(
        &mut self,
        candidates: &[Candidate],
        meeting: &[[u32; 2]],
        inside: &[Vec<u32>; 2],
        out: &mut Vec<ContactPlane>,
    ) {
        let part = candidates.first().map_or(0, |c| c.part);
        let tolerance = TOLERANCE * self.margin;
        let sought = NearQuery { meeting, inside, margin: self.margin, tolerance };
        let lists = &mut *self.lists;
        lists.measured.clear();
        lists.gaps.clear();
        lists.sift.sift(self.context, candidates, out, &sought, &mut lists.near);
        // Those not measured yet, the nearest last; and those that were, the nearest first.
        let mut near = std::mem::take(&mut lists.near);
        let mut entries = std::mem::take(&mut lists.entries);
        entries.clear();
        if meeting.is_empty() {
            near.sort_unstable_by(|a, b| b.bound.total_cmp(&a.bound));
        } else {
            // Around where the two meet nearly all are as near as that: no order is needed to leave some out.
            near.chunks(WIDE_LANES).for_each(|batch| self.measure_all(batch, part, out, |entry| entries.push(entry)));
            near.clear();
        }
        let mut heap = BinaryHeap::from(entries);
        let mut before = None;
        loop {
            let nearest = heap.peek().map_or(f64::INFINITY, |entry: &Entry| entry.distance);
            if near.last().is_some_and(|near| near.bound <= nearest + LEVEL * self.margin) {
                let from = near.len().saturating_sub(WIDE_LANES);
                self.measure_all(&near[from..], part, out, |entry| heap.push(entry));
                near.truncate(from);
                continue;
            }
            let Some(entry) = heap.pop() else { break };
            // A pair may have come several times.
            if before == Some(entry.near.pair) {
                continue;
            }
            before = Some(entry.near.pair);
            let Some(first) = self.known(entry.near.pair) else { continue };
            if first.distance == 0.0
                || out.iter().any(|plane| is_explained(plane, &first, tolerance))
                || !self.lists.sift.is_in_front(self.context, &entry.near, &first)
                || !out.is_empty() && self.leads_down(&first, part)
            {
                continue;
            }
            let plane = self.plane_at(&first, entry, part, &mut heap, out);
            let mut entries = heap.into_vec();
            self.lists.sift.drop_held_apart(&plane, tolerance, &mut entries, |entry| entry.near.places);
            self.lists.sift.drop_held_apart(&plane, tolerance, &mut near, |near| near.places);
            heap = BinaryHeap::from(entries);
            out.push(plane);
            if out.len() >= MOST_PLANES {
                break;
            }
        }
        self.lists.entries = heap.into_vec();
        self.lists.near = near;
    }

    /// What was measured of a pair, where that is within the margin.
    fn known(&self, pair: [u32; 2]) -> Option<Gap> {
        self.lists.measured.get(pair_key(pair)).and_then(|i| self.lists.gaps[i as usize])
    }

    /// Measures at most eight pairs that do not meet, and gives those within the margin that no plane explains.
    fn measure_all(&mut self, batch: &[Near], part: u32, planes: &[ContactPlane], mut give: impl FnMut(Entry)) {
        let tolerance = TOLERANCE * self.margin;
        let found =
            closest_apart(self.context.lanes, batch.len(), |i| self.lists.sift.corners_of(&batch[i]), self.margin);
        for (near, closest) in batch.iter().zip(found) {
            let gap = closest.map(|c| gap_of(near.pair, part, &c));
            self.note(near.pair, gap);
            if let Some(gap) = gap.filter(|gap| !planes.iter().any(|p| is_explained(p, gap, tolerance))) {
                give(Entry { distance: gap.distance, near: *near });
            }
        }
    }

    /// The gap of a pair, where it is within a distance of at most the margin.
    fn measure_within(&mut self, pair: [u32; 2], part: u32, limit: f64) -> Option<Gap> {
        if let Some(i) = self.lists.measured.get(pair_key(pair)) {
            return self.lists.gaps[i as usize];
        }
        let (p, q) = (self.context.tool_triangle(pair[0]), self.context.mockup_triangle(pair[1]));
        let gap = gap_of(pair, part, &closest_within(&p, &q, limit)?);
        self.note(pair, Some(gap));
        Some(gap)
    }

    fn note(&mut self, pair: [u32; 2], gap: Option<Gap>) {
        if self.lists.measured.number(pair_key(pair)).1 {
            self.lists.gaps.push(gap);
        }
    }

    /// The plane of the nearest pair, in the middle of all that are as near and that none of the planes before explains: of those
    /// some were left out when they were measured, and which ones depends on the order of that.
    fn plane_at(
        &mut self,
        first: &Gap,
        entry: Entry,
        part: u32,
        heap: &mut BinaryHeap<Entry>,
        before: &[ContactPlane],
    ) -> ContactPlane {
        let tolerance = TOLERANCE * self.margin;
        let mut plane = plane_of(self.context, first);
        let mut place = Aabb::EMPTY;
        let limit = first.distance + LEVEL * self.margin;
        let mut beside = vec![entry];
        while let Some(next) = heap.peek().filter(|e| e.distance <= limit).copied() {
            heap.pop();
            beside.push(next);
        }
        for next in beside {
            let Some(gap) = self.measure_within(next.near.pair, part, self.margin) else { continue };
            let way = sub(&gap.on_tool, &gap.on_mockup);
            let is_first = next.near.pair == entry.near.pair;
            let is_along = || gap.distance <= limit && dot(&way, &plane.normal) >= gap.distance * (1.0 - 1e-9);
            if is_first || is_along() && !before.iter().any(|plane| is_explained(plane, &gap, tolerance)) {
                place.grow(&gap.on_mockup);
                plane.tool_triangles.push(gap.tool_triangle);
                plane.mockup_triangles.push(gap.mockup_triangle);
            }
            if !is_first {
                heap.push(next);
            }
        }
        if !place.is_empty() {
            let middle = scaled(&add(&place.lower, &place.upper), 0.5);
            plane.point = along(&middle, dot(&sub(&plane.point, &middle), &plane.normal), &plane.normal);
        }
        plane
    }

    /// Whether a step to a neighbouring triangle, on either side, leads clearly down: then the pair is on the slope of another
    /// place, which has its plane or will.
    fn leads_down(&mut self, gap: &Gap, part: u32) -> bool {
        let start = [gap.tool_triangle, gap.mockup_triangle];
        let noise = (1e-9 * gap.distance).powi(2);
        let context = self.context;
        let passes = |surface: Surface, id: u32, p: &Point| {
            let t = context.triangle(surface, id);
            (0..3).any(|k| square_to_segment(p, &t[k], &t[(k + 1) % 3]) <= noise)
        };
        // What is farther does not lead down, and has not the same corner or edge.
        let limit = (gap.distance * (1.0 + 1e-6)).min(self.margin);
        let is_down = |other: &Gap| {
            let step = length(&sub(&other.on_tool, &gap.on_tool)).max(length(&sub(&other.on_mockup, &gap.on_mockup)));
            gap.distance - other.distance > SLOPE * step + 1e-9 * gap.distance
        };
        // Nearer pairs came first: mostly the one that tells is measured.
        if context.beside(start).any(|pair| self.known(pair).is_some_and(|other| is_down(&other))) {
            return true;
        }
        let mut seen = vec![start];
        let mut next = 0;
        while next < seen.len() && seen.len() <= MOST_BESIDE {
            let from = seen[next];
            next += 1;
            let (mut beside, mut count) = ([start; WIDE_LANES], 0);
            for pair in context.beside(from).filter(|pair| !seen.contains(pair)) {
                beside[count] = pair;
                count += 1;
            }
            // Most of them are too far: all at once that is known soon.
            let corners = beside.map(|[t, m]| (context.tool_triangle(t), context.mockup_triangle(m)));
            let far = held_apart(context.lanes, count, |i| (&corners[i].0, &corners[i].1), limit);
            for (i, pair) in beside.into_iter().enumerate().take(count) {
                if far >> i & 1 != 0 && self.lists.measured.get(pair_key(pair)).is_none() {
                    continue;
                }
                let Some(other) = self.measure_within(pair, part, limit) else { continue };
                if is_down(&other) {
                    return true;
                }
                if (pair[0] == from[0] || passes(Surface::Tool, pair[0], &gap.on_tool))
                    && (pair[1] == from[1] || passes(Surface::Mockup, pair[1], &gap.on_mockup))
                {
                    // It has the same corner or edge: look around that.
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
        distance: closest.distance,
        on_tool: closest.on_p,
        on_mockup: closest.on_q,
    }
}

/// A plane and what it holds apart.
pub(crate) fn divider(plane: &ContactPlane, margin: f64) -> Divider {
    let (offset, tolerance) = (dot(&plane.point, &plane.normal), TOLERANCE * margin);
    Divider { part: plane.part, normal: plane.normal, heights: [offset + tolerance, offset + plane.gap - tolerance] }
}

/// Whether the plane holds the pair apart by no less than it claims.
fn is_explained(plane: &ContactPlane, gap: &Gap, tolerance: f64) -> bool {
    let from = sub(&gap.on_mockup, &plane.point);
    let height = dot(&from, &plane.normal);
    let above = dot(&sub(&gap.on_tool, &plane.point), &plane.normal);
    if height <= tolerance && above >= plane.gap - tolerance {
        return true;
    }
    let way = sub(&gap.on_tool, &gap.on_mockup);
    dot(&way, &plane.normal) >= SAME_DIRECTION * gap.distance
        && gap.distance >= plane.gap
        && height.abs() <= SAME_TURN * length(&from) + tolerance
}

fn plane_of(context: &QueryContext<'_>, gap: &Gap) -> ContactPlane {
    let way = sub(&gap.on_tool, &gap.on_mockup);
    let own = |t| normal(&t).map(|n| if dot(&n, &way) < 0.0 { scaled(&n, -1.0) } else { n });
    let of_mockup: Option<Point> = own(context.mockup_triangle(gap.mockup_triangle));
    let of_tool: Option<Point> = own(context.tool_triangle(gap.tool_triangle));
    let direct = unit(&way).or(of_mockup).unwrap_or([0.0, 0.0, 1.0]);
    // The direction between points that are almost one says little; the planes then say it all.
    let noise = 1e-9 + 1e-13 * gap.on_mockup.iter().fold(0.0f64, |m, x| m.max(x.abs())) / gap.distance;
    let snapped = [of_mockup, of_tool].into_iter().flatten().find(|n| 1.0 - dot(n, &direct) <= SNAP.max(noise * noise));
    ContactPlane {
        point: gap.on_mockup,
        normal: snapped.unwrap_or(direct),
        gap: gap.distance,
        part: gap.part,
        tool_triangles: Vec::new(),
        mockup_triangles: Vec::new(),
        id: 0,
        carriers: [gap.tool_triangle, gap.mockup_triangle],
        certain: true,
        assumed: false,
    }
}
