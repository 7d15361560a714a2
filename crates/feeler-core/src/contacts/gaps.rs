//! Planes for what is near and does not meet.
//!
//! The nearest pair of triangles gives a plane; every other pair that this plane holds apart as well is explained by it and
//! dropped; the nearest of the rest gives the next. Between two bulging surfaces one plane explains all, however many
//! triangles they have.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use crate::bounds::{Aabb, Point, Triangle};
use crate::contacts::adjacency::NONE;
use crate::contacts::zones::{IdMap, MOCKUP, TOOL};
use crate::contacts::{ContactPlane, Ground, MOST_PLANES};
use crate::distance_triangle_triangle::closest_within;
use crate::proximity::{Candidate, Gap};
use crate::vectors::{add, along, dot, length, normal, scaled, square_to_segment, sub, unit};

/// Share of the margin by which a pair may miss a plane and still count as explained.
const TOLERANCE: f64 = 0.01;

/// Cosine of the angle within which planes of a hollow surface are one: 12 degrees.
pub(crate) const SAME_DIRECTION: f64 = 0.978;

/// Sine of the same.
const SAME_TURN: f64 = 0.208;

/// A step down to a neighbouring pair counts from this slope on: along a hollow surface around the tool the distance changes
/// slowly, and each direction is to have its plane.
const SLOPE: f64 = 0.2;

/// Sine by which the way to the tool may point into the mock-up's side.
const BEHIND: f64 = 1e-3;

/// Most pairs looked at around a corner.
const MOST_BESIDE: usize = 256;

/// A plane that a triangle's own differs from by less (1 - cosine) is that triangle's: normals then do not depend on rounding.
const SNAP: f64 = 1e-10;

/// The pairs of one part that may be near, as they are found out about.
pub(crate) struct NearPairs<'a> {
    ground: &'a Ground<'a>,
    margin: f64,
    lists: &'a mut NearLists,
}

/// Working memory.
#[derive(Debug, Default)]
pub(crate) struct NearLists {
    /// Placed corners; entries name them by their places here.
    corners: [Vec<Triangle>; 2],
    /// Their outward normals, zero where that is not known.
    outward: [Vec<Point>; 2],
    /// The place of each tool triangle in `corners`.
    places: Vec<u32>,
    entries: Vec<Entry>,
    /// For each of the corners its least (tool) or greatest (mock-up) height over a plane.
    heights: [Vec<f64>; 2],
    /// What was measured, and `None` where that is farther than the margin.
    measured: IdMap<(u32, u32)>,
    gaps: Vec<Option<Gap>>,
}

impl NearLists {
    /// Adds a triangle's corners and normal.
    fn push(&mut self, ground: &Ground<'_>, w: usize, id: u32) {
        let corners = ground.triangle(w, id);
        let outward = f64::from(ground.adjacency[w].outward[id as usize]);
        self.outward[w].push(normal(&corners).map_or([0.0; 3], |n| scaled(&n, outward)));
        self.corners[w].push(corners);
    }
}

/// A pair to be looked at: first by its bound, then, once measured, by its distance.
#[derive(Debug, Clone, Copy)]
struct Entry {
    distance: f64,
    /// Tool triangle and mock-up triangle.
    pair: (u32, u32),
    corners: [u32; 2],
    is_measured: bool,
}

impl Ord for Entry {
    /// The nearest is the greatest: a heap gives that first.
    fn cmp(&self, other: &Entry) -> Ordering {
        other.distance.total_cmp(&self.distance).then(other.pair.cmp(&self.pair))
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
    pub fn new(ground: &'a Ground<'a>, margin: f64, lists: &'a mut NearLists) -> NearPairs<'a> {
        lists.corners[TOOL].clear();
        lists.outward[TOOL].clear();
        lists.places.clear();
        lists.places.resize(ground.tool.mesh().faces().len(), NONE);
        NearPairs { ground, margin, lists }
    }

    /// Adds planes for the candidates of one part, beside the planes the part has from `from` on in `out`. The pairs in
    /// `meeting` (sorted) meet, the triangles in `inside` (of tool and mock-up, sorted) are wholly
    /// inside the other.
    ///
    /// Few pairs are ever measured: most are far from where planes are, or held apart by one as whole triangles.
    pub fn push_planes(
        &mut self,
        candidates: &[Candidate],
        meeting: &[[u32; 2]],
        inside: &[Vec<u32>; 2],
        from: usize,
        out: &mut Vec<ContactPlane>,
    ) {
        let part = candidates.first().map_or(0, |c| c.part);
        let tolerance = TOLERANCE * self.margin;
        let lists = &mut *self.lists;
        lists.corners[MOCKUP].clear();
        lists.outward[MOCKUP].clear();
        lists.measured.clear();
        lists.gaps.clear();
        let mut entries = std::mem::take(&mut lists.entries);
        entries.clear();
        let mut last = NONE;
        for c in candidates {
            if c.mockup_triangle != last {
                last = c.mockup_triangle;
                lists.push(self.ground, MOCKUP, last);
            }
            let pair = [c.tool_triangle, c.mockup_triangle];
            let is_inside = (0..2).any(|w| inside[w].binary_search(&pair[w]).is_ok());
            if is_inside || c.bound == 0.0 && meeting.binary_search(&pair).is_ok() {
                continue;
            }
            if lists.places[c.tool_triangle as usize] == NONE {
                lists.places[c.tool_triangle as usize] = lists.corners[TOOL].len() as u32;
                lists.push(self.ground, TOOL, c.tool_triangle);
            }
            let corners = [lists.places[c.tool_triangle as usize], lists.corners[MOCKUP].len() as u32 - 1];
            let [p, q] = [TOOL, MOCKUP].map(|w| &lists.corners[w][corners[w] as usize]);
            let [n, m] = [TOOL, MOCKUP].map(|w| &lists.outward[w][corners[w] as usize]);
            let is_behind = |x: &Point, on: &Point, normal: &Point| dot(&sub(x, on), normal) < -BEHIND * self.margin;
            if p.iter().all(|x| is_behind(x, &q[0], m)) || q.iter().all(|x| is_behind(x, &p[0], n)) {
                // Whatever its nearest points: wholly behind, see `is_in_front`.
                continue;
            }
            entries.push(Entry { distance: c.bound, pair: (pair[0], pair[1]), corners, is_measured: false });
        }
        for plane in &out[from..] {
            self.drop_held_apart(&mut entries, plane, tolerance);
        }
        let mut heap = BinaryHeap::from(entries);
        let mut before = None;
        while let Some(entry) = heap.pop() {
            // A pair may have come several times.
            if entry.is_measured && before == Some(entry.pair) {
                continue;
            }
            let Some(first) = self.measure(entry.pair, part) else { continue };
            if out[from..].iter().any(|p| is_explained(p, &first, tolerance)) {
                continue;
            }
            if !entry.is_measured {
                heap.push(Entry { distance: first.distance, is_measured: true, ..entry });
                continue;
            }
            before = Some(entry.pair);
            if first.distance == 0.0
                || !is_in_front(self.ground, &first)
                || out.len() > from && self.leads_down(&first, part)
            {
                continue;
            }
            let plane = self.plane_at(&first, entry, part, &mut heap);
            let mut entries = heap.into_vec();
            self.drop_held_apart(&mut entries, &plane, tolerance);
            heap = BinaryHeap::from(entries);
            out.push(plane);
            if out.len() - from >= MOST_PLANES {
                break;
            }
        }
        self.lists.entries = heap.into_vec();
    }

    /// Drops the pairs that a plane holds apart whatever their nearest points.
    fn drop_held_apart(&mut self, entries: &mut Vec<Entry>, plane: &ContactPlane, tolerance: f64) {
        let offset = dot(&plane.point, &plane.normal);
        let NearLists { corners, heights, .. } = &mut *self.lists;
        let of = |t: &Triangle| t.map(|p| dot(&p, &plane.normal) - offset);
        heights.iter_mut().for_each(Vec::clear);
        heights[TOOL].extend(corners[TOOL].iter().map(of).map(|h| h[0].min(h[1]).min(h[2])));
        heights[MOCKUP].extend(corners[MOCKUP].iter().map(of).map(|h| h[0].max(h[1]).max(h[2])));
        let [low, high] = &*heights;
        entries.retain(|e| {
            !(high[e.corners[MOCKUP] as usize] <= tolerance && low[e.corners[TOOL] as usize] >= plane.gap - tolerance)
        });
    }

    /// The gap of a pair, where it is within the margin.
    fn measure(&mut self, pair: (u32, u32), part: u32) -> Option<Gap> {
        if let Some(i) = self.lists.measured.get(&pair) {
            return self.lists.gaps[*i as usize];
        }
        let gap = self.gap_within(pair, part, self.margin);
        self.note(pair, gap);
        gap
    }

    /// The gap of a pair, where it is within a distance of at most the margin; sooner said where it is not.
    fn measure_within(&mut self, pair: (u32, u32), part: u32, limit: f64) -> Option<Gap> {
        if let Some(i) = self.lists.measured.get(&pair) {
            return self.lists.gaps[*i as usize];
        }
        let gap = self.gap_within(pair, part, limit)?;
        self.note(pair, Some(gap));
        Some(gap)
    }

    fn gap_within(&self, pair: (u32, u32), part: u32, limit: f64) -> Option<Gap> {
        let (p, q) = (self.ground.tool_triangle(pair.0), self.ground.mockup_triangle(pair.1));
        let closest = closest_within(&p, &q, limit)?;
        Some(Gap {
            tool_triangle: pair.0,
            mockup_triangle: pair.1,
            part,
            distance: closest.distance,
            on_tool: closest.on_p,
            on_mockup: closest.on_q,
        })
    }

    fn note(&mut self, pair: (u32, u32), gap: Option<Gap>) {
        self.lists.measured.insert(pair, self.lists.gaps.len() as u32);
        self.lists.gaps.push(gap);
    }

    /// The plane of the nearest pair, in the middle of all that are as near.
    fn plane_at(&mut self, first: &Gap, entry: Entry, part: u32, heap: &mut BinaryHeap<Entry>) -> ContactPlane {
        let mut plane = plane_of(self.ground, first);
        let mut place = Aabb::EMPTY;
        let limit = first.distance + 1e-6 * self.margin;
        let mut beside = vec![entry];
        while let Some(next) = heap.peek().filter(|e| e.distance <= limit).copied() {
            heap.pop();
            beside.push(next);
        }
        for next in beside {
            let Some(gap) = self.measure(next.pair, part) else { continue };
            let way = sub(&gap.on_tool, &gap.on_mockup);
            if gap.distance <= limit && dot(&way, &plane.normal) >= gap.distance * (1.0 - 1e-9) {
                place.grow(&gap.on_mockup);
                plane.tool_triangles.push(gap.tool_triangle);
                plane.mockup_triangles.push(gap.mockup_triangle);
            }
            if next.pair != entry.pair {
                heap.push(Entry { distance: gap.distance, is_measured: true, ..next });
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
        let start = (gap.tool_triangle, gap.mockup_triangle);
        let noise = (1e-9 * gap.distance).powi(2);
        let ground = self.ground;
        let passes = |w: usize, id: u32, p: &Point| {
            let t = ground.triangle(w, id);
            (0..3).any(|k| square_to_segment(p, &t[k], &t[(k + 1) % 3]) <= noise)
        };
        // What is farther does not lead down, and has not the same corner or edge.
        let limit = (gap.distance * (1.0 + 1e-6)).min(self.margin);
        let is_down = |other: &Gap| {
            let step = length(&sub(&other.on_tool, &gap.on_tool)).max(length(&sub(&other.on_mockup, &gap.on_mockup)));
            gap.distance - other.distance > SLOPE * step + 1e-9 * gap.distance
        };
        // Nearer pairs came first: mostly the one that tells is measured.
        let known = |key: &(u32, u32)| self.lists.measured.get(key).and_then(|i| self.lists.gaps[*i as usize]);
        let beside_start = ground.adjacency[TOOL].neighbours[start.0 as usize].map(|n| (n, start.1));
        let and_these = ground.adjacency[MOCKUP].neighbours[start.1 as usize].map(|n| (start.0, n));
        if beside_start.iter().chain(&and_these).any(|key| known(key).is_some_and(|other| is_down(&other))) {
            return true;
        }
        let mut seen = vec![start];
        let mut next = 0;
        while next < seen.len() && seen.len() <= MOST_BESIDE {
            let (t, m) = seen[next];
            next += 1;
            let beside_t = ground.adjacency[TOOL].neighbours[t as usize].map(|n| (n, m));
            let beside_m = ground.adjacency[MOCKUP].neighbours[m as usize].map(|n| (t, n));
            for key in beside_t.into_iter().chain(beside_m) {
                if key.0 == NONE || key.1 == NONE || seen.contains(&key) {
                    continue;
                }
                let Some(other) = self.measure_within(key, part, limit) else { continue };
                if is_down(&other) {
                    return true;
                }
                if (key.0 == t || passes(TOOL, key.0, &gap.on_tool))
                    && (key.1 == m || passes(MOCKUP, key.1, &gap.on_mockup))
                {
                    // It has the same corner or edge: look around that.
                    seen.push(key);
                }
            }
        }
        false
    }
}

/// Whether each of the two nearest points is on the outer side of the other's triangle, as far as that is known: what is inside
/// the other solid is near its surface, but not held off by it.
fn is_in_front(ground: &Ground<'_>, gap: &Gap) -> bool {
    let way = sub(&gap.on_tool, &gap.on_mockup);
    let is_outside = |w: usize, id: u32, sense: f64| {
        let outward = sense * f64::from(ground.adjacency[w].outward[id as usize]);
        normal(&ground.triangle(w, id)).is_none_or(|n| outward * dot(&n, &way) >= -BEHIND * gap.distance)
    };
    is_outside(MOCKUP, gap.mockup_triangle, 1.0) && is_outside(TOOL, gap.tool_triangle, -1.0)
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

fn plane_of(ground: &Ground<'_>, gap: &Gap) -> ContactPlane {
    let way = sub(&gap.on_tool, &gap.on_mockup);
    let own = |t| normal(&t).map(|n| if dot(&n, &way) < 0.0 { scaled(&n, -1.0) } else { n });
    let of_mockup: Option<Point> = own(ground.mockup_triangle(gap.mockup_triangle));
    let of_tool: Option<Point> = own(ground.tool_triangle(gap.tool_triangle));
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
        certain: true,
    }
}
