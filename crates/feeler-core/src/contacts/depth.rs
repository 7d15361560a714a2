//! How deep two bulging surfaces are in each other, and along which direction least.
//!
//! Along a unit direction d the depth is the highest of the mock-up's points less the lowest of the tool's: the way the tool
//! has to go along d until a plane across d holds the two apart. The least of it over all d is at a normal of one of the two,
//! or at a direction across an edge of each, as for any two polytopes; for curved surfaces a short [`descent`](super::descent)
//! follows.

use std::array::from_fn;

use crate::bounds::{Aabb, Point};
use crate::contacts::arcs::{is_against, Arcs};
use crate::contacts::body::{edge_count, Body, Facets, MOST_EDGES};
use crate::contacts::edge_pairs::EdgePairs;
use crate::contacts::first::{FirstDepth, Normals};
use crate::contacts::heights::{highest, highest_and_lowest, highest_of_eights, places_above, Reach};
use crate::contacts::onward::Known;
use crate::contacts::overlap::Overlap;
use crate::contacts::zones::Zones;
use crate::contacts::Ground;
use crate::simd::{Checked, WIDE_LANES};
use crate::vectors::{add, along, dot, length, scaled, sub};

/// A later direction must be shallower by this share to be preferred, so that ties fall to normals of the mock-up always.
pub(super) const CLEARLY: f64 = 1e-6;

/// Share of a depth that is all of it.
const ALL: f64 = 0.9;

/// Share of that by which overlaps are looked for first.
const MUCH: f64 = 0.75;

/// The least depth of a tool body in a mock-up body.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Depth {
    /// Unit, from the mock-up to the tool.
    pub normal: Point,
    /// Metres, until a plane across the normal holds the two apart.
    depth: f64,
    overlap: Overlapping,
    /// How high the mock-up's body is along the normal.
    high: f64,
    /// On the mock-up's side of the overlap, above the tool's lowest place.
    pub point: Point,
    /// Whether no direction can be shallower: both surfaces flat, and all candidates tried.
    pub certain: bool,
}

/// How much two bodies overlap along the direction for which they are so deep. Where that is clearly less, one reaches over a hollow
/// that the other fills, and no plane has to hold them apart.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Overlapping {
    NotAsked,
    All,
    /// By so many metres at most.
    AtMost(f64),
    Measured(f64),
}

impl Depth {
    /// Of its plane: negative, or nothing. As long as the overlap is not [measured](Pair::measure), as much as it may be.
    pub fn gap(&self) -> f64 {
        let most = match self.overlap {
            Overlapping::NotAsked | Overlapping::All => self.depth,
            Overlapping::AtMost(overlap) | Overlapping::Measured(overlap) => overlap,
        };
        -most.max(0.0)
    }

    /// Whether its gap is no bound only.
    pub fn is_known(&self) -> bool {
        matches!(self.overlap, Overlapping::All | Overlapping::Measured(_))
    }

    /// Whether it is an overlap, and no more than another.
    pub fn is_less_than(&self, other: &Depth) -> bool {
        !self.may_hold() && self.gap() >= other.gap()
    }

    /// Whether its plane may be needed to hold the two apart.
    fn may_hold(&self) -> bool {
        matches!(self.overlap, Overlapping::NotAsked | Overlapping::All)
    }
}

/// Working memory.
#[derive(Debug, Default)]
pub(crate) struct Directions {
    edge_pairs: EdgePairs,
    pub(super) normals: Normals,
    pub(super) arcs: Arcs,
    overlap: Overlap,
    /// Bodies of the tool with directions of planes and overlaps along them, for which it was asked whether others overlap by more; and
    /// whether nothing of the mock-up does.
    held: Vec<((usize, Point, f64), Option<bool>)>,
    /// By body of tool and mock-up where its surface went on along directions tried: there it mostly does along others.
    pub(super) known: [Vec<Known>; 2],
    pub(super) places: Vec<u32>,
}

impl Directions {
    /// For the bodies of another zone, so many of the tool and of the mock-up.
    pub fn clear(&mut self, bodies: [usize; 2]) {
        self.overlap.clear(bodies);
        self.held.clear();
        self.edge_pairs.clear();
        for (known, count) in self.known.iter_mut().zip(bodies) {
            known.resize_with(count.max(known.len()), Known::default);
            known[..count].iter_mut().for_each(Known::clear);
        }
    }
}

/// A direction, and how high the mock-up and how low the tool is along it.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Tried {
    pub direction: Point,
    pub high: f64,
    pub low: f64,
}

impl Tried {
    pub fn depth(&self) -> f64 {
        self.high - self.low
    }
}

/// Two bodies that cut each other.
#[derive(Clone, Copy)]
pub(crate) struct Pair<'a> {
    pub lanes: Checked,
    pub zones: &'a Zones,
    pub tool: &'a Body<'a>,
    pub mockup: &'a Body<'a>,
}

impl Pair<'_> {
    /// How deep two that are so deep along the best of their normals are along a plane's, if it holds them apart as well: where it
    /// is less deep than that, only if nothing goes on along it either.
    pub fn held_depth(&self, plane: &Depth, depth: f64, directions: &mut Directions) -> Option<f64> {
        let direction = plane.normal;
        let tried = Tried { direction, high: self.high(&direction), low: self.low(&direction) };
        let is_held = tried.depth() <= plane.depth * (1.0 + CLEARLY)
            && (plane.depth >= depth || {
                let mut best = Best::new(self, directions, None);
                best.leads_out(&direction) && !best.goes_on(&tried)
            });
        is_held.then(|| tried.depth())
    }

    /// Whether a plane found for the same tool body holds the mock-up's apart from it as well.
    pub fn is_under(&self, plane: &Depth) -> bool {
        plane.may_hold() && self.high(&plane.normal) <= plane.high + CLEARLY * plane.depth
    }

    /// Whether a plane found for the same mock-up body holds the tool's apart from it as well.
    pub fn is_over(&self, plane: &Depth) -> bool {
        plane.may_hold() && self.low(&plane.normal) >= plane.high - plane.depth * (1.0 + CLEARLY)
    }

    fn high(&self, normal: &Point) -> f64 {
        highest_of_eights(self.lanes, self.mockup.point_eights, normal)
    }

    fn low(&self, normal: &Point) -> f64 {
        -highest_of_eights(self.lanes, self.tool.point_eights, &scaled(normal, -1.0))
    }

    /// Pairs of an edge of each.
    pub fn edge_pairs(&self) -> usize {
        edge_count(self.mockup.facets.len()) * edge_count(self.tool.facets.len())
    }

    /// The least depth, from the first. `None` where no direction leads out.
    pub fn least_depth(&self, first: &FirstDepth, directions: &mut Directions) -> Option<Depth> {
        let mut best = Best::new(self, directions, first.found);
        if (1..=MOST_EDGES).contains(&self.edge_pairs()) {
            best.try_edges();
        }
        if !first.certain {
            best.turn_around_edges();
            best.descend();
        }
        let found = best.found?;
        let (point, certain) = (best.place(&found), first.certain);
        let (normal, depth) = (found.direction, found.depth());
        Some(Depth { normal, depth, overlap: Overlapping::NotAsked, high: found.high, point, certain })
    }

    /// Whether the two overlap as much as they are deep along a direction. Looks once.
    pub fn is_filled(&self, ground: &Ground<'_>, depth: &mut Depth, directions: &mut Directions) -> bool {
        if depth.overlap == Overlapping::NotAsked {
            let enough = ALL * depth.depth;
            depth.overlap = Overlapping::All;
            if depth.depth > 0.0 {
                // Mostly it is much of that, and few triangles overlap by as much: what there is is measured at once.
                self.find_overlap(ground, depth, MUCH * enough, enough, directions);
            }
        }
        depth.overlap == Overlapping::All
    }

    /// Makes a depth what the two overlap, where that is less. Where it is no more than `least` (metres), that is all that is said.
    pub fn measure(&self, ground: &Ground<'_>, depth: &mut Depth, least: f64, directions: &mut Directions) {
        self.is_filled(ground, depth, directions);
        match depth.overlap {
            Overlapping::AtMost(most) if most > least => {}
            _ => return,
        }
        let enough = ALL * depth.depth;
        // Where they only touch there is a point too.
        let more = if least > 0.0 { least } else { -CLEARLY * enough };
        self.find_overlap(ground, depth, more, enough, directions);
    }

    /// Looks for an overlap of more than `least`, which may be nothing or a little less: then no more means none.
    fn find_overlap(
        &self,
        ground: &Ground<'_>,
        depth: &mut Depth,
        least: f64,
        enough: f64,
        directions: &mut Directions,
    ) {
        let found = directions.overlap.most(ground, &self.sides(), &depth.normal, least, enough);
        let Some((most, at)) = found.filter(|(most, _)| *most < enough) else { return };
        depth.certain = false;
        if most > least {
            (depth.overlap, depth.point) = (Overlapping::Measured(most), at);
        } else {
            depth.overlap = if least > 0.0 { Overlapping::AtMost(least) } else { Overlapping::Measured(0.0) };
        }
    }

    /// Whether the two overlap along a direction by no more than others do for which it was found. Where that is asked once more for
    /// the tool's body, it is asked for all that the mock-up has there: mostly none of it overlaps by more.
    pub fn overlaps_no_more(
        &self,
        ground: &Ground<'_>,
        all: Facets<'_>,
        plane: &Depth,
        directions: &mut Directions,
    ) -> bool {
        let most = -plane.gap();
        let Directions { overlap, held, .. } = directions;
        let [tool, mockup] = self.sides();
        let mut is_more = |mockup| {
            let found = overlap.most(ground, &[tool, mockup], &plane.normal, most, most);
            found.is_none_or(|(more, _)| more > most)
        };
        let key = (tool.number, plane.normal, most);
        match held.iter_mut().find(|held| held.0 == key) {
            Some((_, no_more)) => *no_more.get_or_insert_with(|| !is_more(all)) || !is_more(mockup),
            None => {
                held.push((key, None));
                !is_more(mockup)
            }
        }
    }

    /// The means of what the surfaces face: what is against one of them leads in.
    pub fn outward(&self) -> [Point; 2] {
        [self.mockup.mean, scaled(&self.tool.mean, -1.0)]
    }

    fn sides(&self) -> [Facets<'_>; 2] {
        [self.tool.whole(), self.mockup.whole()]
    }
}

/// The best direction so far.
pub(super) struct Best<'a> {
    pub pair: &'a Pair<'a>,
    /// Metres below which depths are the same.
    pub noise: f64,
    pub found: Option<Tried>,
    pub directions: &'a mut Directions,
}

/// Eight directions of a list, the last one several times where there are fewer.
pub(super) fn eight_of(list: &[Point]) -> [Point; WIDE_LANES] {
    from_fn(|i| list[i.min(list.len() - 1)])
}

impl<'a> Best<'a> {
    pub fn new(pair: &'a Pair<'a>, directions: &'a mut Directions, found: Option<Tried>) -> Best<'a> {
        let Pair { tool, mockup, .. } = pair;
        let noise = 1e-12 * tool.size.max(mockup.size).max(tool.largest);
        Best { pair, noise, found, directions }
    }

    /// The depth from which on a direction is of no use; infinite where any is.
    pub fn limit(&self) -> f64 {
        match self.found {
            // Above the noise, where a depth of nothing is judged by the lean.
            Some(found) => {
                let least = found.depth();
                (least - CLEARLY * least.abs() - self.noise).max(2.0 * self.noise) + self.noise
            }
            None => f64::INFINITY,
        }
    }

    /// The highest of the mock-up and the lowest of the tool.
    pub fn support(&self, directions: &[Point; WIDE_LANES]) -> (Reach, Reach) {
        let Pair { lanes, tool, mockup, .. } = self.pair;
        highest_and_lowest(*lanes, mockup.points, tool.points, directions)
    }

    /// The heights alone.
    pub fn tried(&self, directions: &[Point; WIDE_LANES]) -> [Tried; WIDE_LANES] {
        let Pair { lanes, tool, mockup, .. } = self.pair;
        let high = highest(*lanes, mockup.points, directions);
        let low = highest(*lanes, tool.points, &directions.map(|d| scaled(&d, -1.0)));
        from_fn(|i| Tried { direction: directions[i], high: high[i], low: -low[i] })
    }

    /// From the lowest place of the tool to the highest of the mock-up: no direction is less deep than that along it.
    pub fn way(&self, (high, low): &(Reach, Reach), i: usize) -> Point {
        sub(&self.pair.mockup.points[high.at[i] as usize], &self.pair.tool.points[low.at[i] as usize])
    }

    /// Whether going along `d` leads out.
    pub fn leads_out(&self, d: &Point) -> bool {
        is_leading_out(d, &self.pair.outward())
    }

    /// How far the two surfaces face into the plane across `d`, as the sum of cosines: tells directions apart where the two
    /// only touch, and every direction is as deep.
    fn lean(&self, d: &Point) -> f64 {
        let under = |n: &Point, s: f64| (-s * dot(n, d)).max(0.0);
        let of = |body: &Body<'_>, s: f64| body.facets.iter().map(|p| under(&p.normal, s)).sum::<f64>();
        of(self.pair.mockup, 1.0) + of(self.pair.tool, -1.0)
    }

    /// The directions across an edge of each.
    fn try_edges(&mut self) {
        let Pair { lanes, tool, mockup, .. } = self.pair;
        let mut edge_pairs = std::mem::take(&mut self.directions.edge_pairs);
        self.try_all(edge_pairs.directions(*lanes, tool, mockup, &self.pair.outward()));
        self.directions.edge_pairs = edge_pairs;
    }

    /// Tries directions in their order.
    fn try_all(&mut self, list: &[Point]) {
        for some in list.chunks(WIDE_LANES) {
            for tried in &self.tried(&eight_of(some))[..some.len()] {
                self.offer(tried);
            }
        }
    }

    /// Whether a direction is the best now.
    pub fn offer(&mut self, tried: &Tried) -> bool {
        if let Some(found) = &self.found {
            let (depth, least) = (tried.depth(), found.depth());
            let is_less = depth < least - CLEARLY * least.abs() - self.noise;
            if !is_less {
                let is_deep = depth > self.noise || least > self.noise;
                if is_deep || self.lean(&tried.direction) >= self.lean(&found.direction) - 1e-6 {
                    return false;
                }
            }
        }
        let is_better = !self.goes_on(tried);
        if is_better {
            self.found = Some(*tried);
        }
        is_better
    }

    /// Boxes around the highest of the mock-up's points and the lowest of the tool's, within a share of the depth.
    pub fn extremes(&mut self, found: &Tried, share: f64) -> (Aabb, Aabb) {
        let (d, tolerance) = (&found.direction, share * found.depth().abs() + self.noise);
        let Pair { lanes, tool, mockup, .. } = self.pair;
        let mut reach = |body: &Body<'_>, d: &Point, height: f64| {
            let places = places_above(*lanes, body.point_eights, d, height - tolerance, &mut self.directions.places);
            let last = body.points.len().saturating_sub(1);
            let mut bounds = Aabb::EMPTY;
            places.iter().for_each(|i| bounds.grow(&body.points[last.min(*i as usize)]));
            bounds
        };
        (reach(mockup, d, found.high), reach(tool, &scaled(d, -1.0), -found.low))
    }

    /// The middle of the highest part of the mock-up or of the lowest of the tool, whichever is smaller, raised to the height
    /// of the mock-up. The middle of a box around them, which does not know how many triangles make them up.
    fn place(&mut self, found: &Tried) -> Point {
        let (above, below) = self.extremes(found, 1e-3);
        let chosen = middle(if length(&below.extent()) <= length(&above.extent()) { &below } else { &above });
        along(&chosen, found.high - dot(&chosen, &found.direction), &found.direction)
    }
}

pub(super) fn is_leading_out(d: &Point, outward: &[Point; 2]) -> bool {
    (*d != [0.0; 3]) & !is_against(d, &outward[0]) & !is_against(d, &outward[1])
}

pub(super) fn middle(b: &Aabb) -> Point {
    scaled(&add(&b.lower, &b.upper), 0.5)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contacts::body::Facet;
    use crate::contacts::heights::push_eights;
    use crate::contacts::onward::Onward;
    use crate::contacts::shapes::{box_mesh, joined};
    use crate::contacts::tests::{at, scene, tool};
    use crate::contacts::zones::{Cut, Face, MOCKUP};
    use crate::simd::Level;
    use crate::vectors::{across, unit};

    #[test]
    fn a_plane_holds_apart_what_it_is_deep_enough_for() {
        let wave = |i: usize| [(0.7 * i as f64).sin(), (1.9 * i as f64).cos(), (0.3 * i as f64).sin()];
        let (high, low): (Vec<Point>, Vec<Point>) = (0..30).map(|i| (wave(i), wave(41 + i))).unzip();
        let mean = [0.0; 3];
        let [low_eights, high_eights] = [&low, &high].map(|points| {
            let mut eights = Vec::new();
            push_eights(points, &mut eights);
            eights
        });
        let body = |points, point_eights| Body { points, point_eights, cuts_of: &[(0, 0); 30], ..Body::of_facets(&[]) };
        let zones = Zones::default();
        let lanes = Level::best().checked();
        let pair = Pair { lanes, zones: &zones, tool: &body(&low, &low_eights), mockup: &body(&high, &high_eights) };
        for d in (0..20).filter_map(|i| unit(&wave(100 + i))) {
            let depth = high.iter().flat_map(|p| low.iter().map(|q| dot(&sub(p, q), &d)).collect::<Vec<_>>());
            let depth = depth.fold(f64::NEG_INFINITY, f64::max);
            // Planes as others may have them, a little deeper and a little less deep than would do.
            let plane = |depth: f64, high: f64| Depth {
                normal: d,
                depth,
                overlap: Overlapping::All,
                high,
                point: mean,
                certain: false,
            };
            let of = |depth: f64| plane(depth, 0.0);
            // The last two less deep than along the best of their normals: only where the plane's direction leads out.
            let mut directions = Directions::default();
            directions.clear([1; 2]);
            let mut held =
                |pair: &Pair<'_>, plane: f64, first: f64| pair.held_depth(&of(plane), first, &mut directions);
            let inward = Pair { mockup: &Body { mean: scaled(&d, -1.0), ..*pair.mockup }, ..pair };
            let is_it = |found: Option<f64>| found.is_some_and(|found| (found - depth).abs() < 1e-12);
            assert!(is_it(held(&pair, depth + 1e-9, 0.0)) && held(&pair, depth - 1e-4, 0.0).is_none(), "{d:?}");
            assert!(is_it(held(&inward, depth + 1e-9, depth)) && is_it(held(&pair, depth + 1e-9, depth + 1e-4)));
            assert!(held(&inward, depth + 1e-9, depth + 1e-4).is_none(), "{d:?}");
            // And only where the mock-up does not go on along it, higher than all of its points.
            let side = across(&d)[0];
            let face = |normal, by: f64| Face { normal, ..Face::new(0, [along(&mean, by, &d); 3], true) };
            let mut zones = Zones::default();
            zones.faces = [vec![face(d, 0.0)], vec![face(side, 9.0)]];
            let cut = Cut { faces: [0; 2], points: (0, 1), flat: false };
            let onward = Onward::advancing(&zones, MOCKUP, &cut, along(&mean, pair.high(&d), &d), &d).unwrap();
            directions.known[MOCKUP][0].push(&onward);
            let pair = Pair { zones: &zones, ..pair };
            let mut held = |first: f64| pair.held_depth(&of(depth + 1e-9), first, &mut directions).is_some();
            assert!(held(depth) && !held(depth + 1e-4), "{d:?}");
            let (high, low) = (pair.high(&d), pair.low(&d));
            assert!((high - low - depth).abs() < 1e-12);
            let less = Depth { overlap: Overlapping::AtMost(0.5), ..plane(1.0, high + 1e-9) };
            assert!(!pair.is_under(&less), "{d:?}");
            assert!(pair.is_under(&plane(1.0, high + 1e-9)) && !pair.is_under(&plane(1.0, high - 1e-4)), "{d:?}");
            assert!(
                pair.is_over(&plane(1.0, low + 1.0 - 1e-9)) && !pair.is_over(&plane(1.0, low + 1.0 + 1e-4)),
                "{d:?}"
            );
        }
    }

    #[test]
    fn what_overlaps_by_more_than_others_is_told_from_what_does_not() {
        // Blocks of three heights under a plate, and of each its upper side.
        let block = |i: usize, high: f64| box_mesh([0.02 * i as f64, 0.0, high - 0.01], [0.01, 0.01, 0.02], 1);
        let blocks = scene(joined([block(0, 0.001), block(1, 0.002), block(2, 0.0002)]));
        let plate = tool(box_mesh([0.02, 0.0, 0.01], [0.1, 0.1, 0.02], 1));
        let pose = at(0.0, 0.0, 0.0);
        let ground = Ground::new(&blocks, &plate, &pose, None);
        let up = [0.0, 0.0, 1.0];
        let tops = [0, 1, 2].map(|i| Facet::over(up, 2 * i..2 * i + 2));
        let of_mockup = [8, 9, 20, 21, 32, 33];
        let of_tool = [Facet::over([0.0, 0.0, -1.0], 0..2)];
        let tool = Body { triangles: &[10, 11], ..Body::of_facets(&of_tool) };
        let zones = Zones::default();
        let lanes = ground.lanes;
        let mut directions = Directions::default();
        directions.clear([1, 3]);
        // Asked in an order in which what is said of all comes before it is known of each.
        for (most, asked) in [(0.0010001, [0, 2, 1, 2]), (0.0020001, [0, 2, 1, 0]), (0.0019999, [2, 1, 0, 1])] {
            let overlap = Overlapping::Measured(most);
            let plane = Depth { normal: up, depth: 0.01, overlap, high: 0.0, point: up, certain: false };
            for i in asked {
                let mockup = Body { number: i, triangles: &of_mockup, ..Body::of_facets(&tops[i..i + 1]) };
                let pair = Pair { lanes, zones: &zones, tool: &tool, mockup: &mockup };
                let found = pair.overlaps_no_more(&ground, Facets::new(3, &tops, &of_mockup), &plane, &mut directions);
                assert_eq!(found, [0.001, 0.002, 0.0002][i] < most, "{most} {i}");
            }
            let of_all = directions.held.iter().find(|held| held.0 .2 == most).unwrap().1;
            assert_eq!(of_all, Some(most > 0.002), "{most}");
        }
    }
}
