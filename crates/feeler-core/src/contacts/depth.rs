//! How deep two bulging surfaces are in each other, and along which direction least.
//!
//! Along a unit direction d the depth is the highest of the mock-up's points less the lowest of the tool's: the way the tool
//! has to go along d until a plane across d holds the two apart. The least of it over all d is at a normal of one of the two,
//! or at a direction across an edge of each, as for any two polytopes; for curved surfaces a short descent follows.

use crate::bounds::{Aabb, Point};
use crate::contacts::arcs::{Arcs, ARC_STEPS};
use crate::contacts::body::{edge_count, Body, MOST_EDGES};
use crate::contacts::heights::{highest_and_lowest, places_above, Reach};
use crate::contacts::zones::{Zones, MOCKUP, TOOL};
use crate::simd::{Checked, WIDE_LANES};
use crate::vectors::{add, along, cross, dot, length, scaled, sub, unit};

/// Most directions tried of each kind.
const MOST_NORMALS: usize = 24;

/// Most patches of a body, the largest, between whose normals directions are sought.
const MOST_TURNED: usize = 3;

/// Most ways between extreme places that are kept to reject directions by.
const MOST_WAYS: usize = 24;

/// Most steps of the descent, the share by which each that leads nowhere shortens the next, and the length (radians, about) of the
/// last.
const MOST_STEPS: usize = 24;
const SHORTER: f64 = 0.6;
const SHORTEST_STEP: f64 = 0.01;

/// Most places that are kept where a surface goes on.
const MOST_KNOWN: usize = 6;

/// Sine from which on a surface goes on along a direction.
const GOES_ON: f64 = 0.05;

/// A later direction must be shallower by this share to be preferred, so that ties fall to normals of the mock-up always.
const CLEARLY: f64 = 1e-6;

/// The least depth of a tool body in a mock-up body.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Depth {
    /// Unit, from the mock-up to the tool.
    pub normal: Point,
    /// Metres.
    pub depth: f64,
    /// On the mock-up's side of the overlap, above the tool's lowest place.
    pub point: Point,
    /// Whether no direction can be shallower: both surfaces flat, and all candidates tried.
    pub certain: bool,
}

impl Depth {
    /// Of its plane: negative, or nothing.
    pub fn gap(&self) -> f64 {
        -self.depth.max(0.0)
    }
}

/// Working memory.
#[derive(Debug, Default)]
pub(crate) struct Directions {
    list: Vec<Point>,
    /// From a low place of the tool to a high one of the mock-up, along directions tried: no direction is less deep than any
    /// of them along it.
    ways: Vec<Point>,
    next_way: usize,
    /// Points of the curve where a surface went on along directions tried: of which, where, and by which cut.
    goes_on: Vec<(usize, Point, u32)>,
    places: Vec<u32>,
}

/// See the module. `None` where no direction leads out.
pub(crate) fn least_depth(
    lanes: Checked,
    zones: &Zones,
    tool: &Body<'_>,
    mockup: &Body<'_>,
    directions: &mut Directions,
) -> Option<Depth> {
    let size = tool.size.max(mockup.size);
    let noise = 1e-12 * size.max(tool.largest);
    let is_flat = |body: &Body<'_>| body.facets.len() <= MOST_NORMALS && body.facets.iter().all(|p| p.flat);
    let mut certain = is_flat(tool) && is_flat(mockup);
    let mut list = std::mem::take(&mut directions.list);
    directions.ways.clear();
    directions.next_way = 0;
    directions.goes_on.clear();
    let mut best = Best { lanes, zones, tool, mockup, noise, found: None, directions };
    list.clear();
    let mut offer = |d: Point| {
        if best.leads_out(&d) {
            list.push(d);
        }
    };
    mockup.facets.iter().take(MOST_NORMALS).for_each(|p| offer(p.normal));
    tool.facets.iter().take(MOST_NORMALS).for_each(|p| offer(scaled(&p.normal, -1.0)));
    offer(mockup.mean);
    offer(scaled(&tool.mean, -1.0));
    if edge_count(mockup.facets.len()) * edge_count(tool.facets.len()) <= MOST_EDGES {
        for e in mockup.edges {
            for f in tool.edges {
                let Some(d) = unit(&cross(&e.along, &f.along)) else { continue };
                for d in [d, scaled(&d, -1.0)] {
                    // Where it is between the normals on both sides, the edges hold along it, wherever most of the faces look.
                    if e.is_between(&d) && f.is_between(&scaled(&d, -1.0)) || best.leads_out(&d) {
                        list.push(d);
                    }
                }
            }
        }
    } else {
        certain = false;
    }
    best.try_all(&list);
    if !certain {
        best.turn_around_edges(&mut list);
        best.descend(&mut list);
    }
    let found = best.found.map(|f| Depth { normal: f.direction, depth: f.depth(), point: best.place(&f), certain });
    directions.list = list;
    found
}

/// The best direction so far.
#[derive(Debug, Clone, Copy)]
struct Found {
    direction: Point,
    high: f64,
    low: f64,
    /// How far the two bodies lean over the plane between them.
    lean: f64,
}

impl Found {
    fn depth(&self) -> f64 {
        self.high - self.low
    }
}

struct Best<'a> {
    lanes: Checked,
    zones: &'a Zones,
    tool: &'a Body<'a>,
    mockup: &'a Body<'a>,
    /// Metres below which depths are the same.
    noise: f64,
    found: Option<Found>,
    directions: &'a mut Directions,
}

/// Eight directions of a list, the last one several times where there are fewer.
fn eight_of(list: &[Point]) -> [Point; WIDE_LANES] {
    std::array::from_fn(|i| list[i.min(list.len() - 1)])
}

impl Best<'_> {
    /// The depth from which on a direction is of no use; infinite where any is.
    fn limit(&self) -> f64 {
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
    fn support(&self, directions: &[Point; WIDE_LANES]) -> (Reach, Reach) {
        highest_and_lowest(self.lanes, self.mockup.points, self.tool.points, directions)
    }

    fn way(&self, (high, low): &(Reach, Reach), i: usize) -> Point {
        sub(&self.mockup.points[high.at[i] as usize], &self.tool.points[low.at[i] as usize])
    }

    fn keep_way(&mut self, way: Point) {
        let Directions { ways, next_way, .. } = &mut *self.directions;
        if ways.len() < MOST_WAYS {
            ways.push(way);
        } else {
            ways[*next_way] = way;
            *next_way = (*next_way + 1) % MOST_WAYS;
        }
    }

    /// Whether one of the surfaces goes on beyond the curve just where, along `d`, it would have to end: a rod in a plate is not
    /// freed sideways by its own width, for there is more plate.
    fn goes_on(&mut self, d: &Point, high: f64, low: f64) -> bool {
        let tolerance = self.noise + 1e-6 * (high - low).abs();
        let ends = [(scaled(d, -1.0), -low - tolerance), (*d, high - tolerance)];
        // Where it did along another direction it mostly does again.
        let is_known = self.directions.goes_on.iter().any(|(w, x, source)| {
            let (d, height) = &ends[*w];
            dot(x, d) >= *height && goes_on(self.zones, *w, *source, d, *height + 3.0 * tolerance)
        });
        if is_known {
            return true;
        }
        for (w, body) in [(MOCKUP, self.mockup), (TOOL, self.tool)] {
            let (d, height) = &ends[w];
            let Directions { places, goes_on: known, .. } = &mut *self.directions;
            places_above(self.lanes, body.curve_eights, d, *height, places);
            let last = body.curve.len().saturating_sub(1);
            let at = |i: &u32| &body.curve[last.min(*i as usize)];
            if let Some((x, source)) =
                places.iter().map(at).find(|(_, source)| goes_on(self.zones, w, *source, d, *height + 3.0 * tolerance))
            {
                known.truncate(MOST_KNOWN - 1);
                known.insert(0, (w, *x, *source));
                return true;
            }
        }
        false
    }

    /// Whether going along `d` leads out: not into what the surfaces face.
    fn leads_out(&self, d: &Point) -> bool {
        d != &[0.0; 3] && dot(d, &self.mockup.mean) > -0.01 && dot(d, &self.tool.mean) < 0.01
    }

    /// How far the two surfaces face into the plane across `d`, as the sum of cosines: tells directions apart where the two
    /// only touch, and every direction is as deep.
    fn lean(&self, d: &Point) -> f64 {
        let under = |n: &Point, s: f64| (-s * dot(n, d)).max(0.0);
        let of = |body: &Body<'_>, s: f64| body.facets.iter().map(|p| under(&p.normal, s)).sum::<f64>();
        of(self.mockup, 1.0) + of(self.tool, -1.0)
    }

    /// Tries directions that lead out, in their order.
    fn try_all(&mut self, list: &[Point]) {
        for some in list.chunks(WIDE_LANES) {
            let support = self.support(&eight_of(some));
            for (i, d) in some.iter().enumerate() {
                self.keep_way(self.way(&support, i));
                self.is_better(d, support.0.height[i], support.1.height[i]);
            }
        }
    }

    /// Whether a direction along which the mock-up is so high and the tool so low is the best now.
    fn is_better(&mut self, d: &Point, high: f64, low: f64) -> bool {
        let depth = high - low;
        let mut lean = f64::NAN;
        if let Some(found) = &self.found {
            let least = found.depth();
            let is_less = depth < least - CLEARLY * least.abs() - self.noise;
            if !is_less {
                if depth > self.noise || least > self.noise {
                    return false;
                }
                lean = self.lean(d);
                if lean >= found.lean - 1e-6 {
                    return false;
                }
            }
        }
        let is_better = !self.goes_on(d, high, low);
        if is_better {
            let lean = if lean.is_nan() { self.lean(d) } else { lean };
            self.found = Some(Found { direction: *d, high, low, lean });
        }
        is_better
    }

    /// The valleys between the normals of each two patches of a body: where an edge holds, the least depth lies on the arc
    /// around it, in a valley too narrow for the descent when the edge is long. All arcs at once.
    fn turn_around_edges(&mut self, list: &mut Vec<Point>) {
        let mut arcs = Arcs::default();
        for (body, sense) in [(self.mockup, 1.0), (self.tool, -1.0)] {
            for (i, p) in body.facets.iter().enumerate().take(MOST_TURNED) {
                for q in body.facets.iter().take(MOST_TURNED).skip(i + 1) {
                    // Opposite faces have no edge, and nearly equal ones no arc to speak of.
                    if (-0.5..0.95).contains(&dot(&p.normal, &q.normal)) {
                        arcs.push([scaled(&p.normal, sense), scaled(&q.normal, sense)]);
                    }
                }
            }
        }
        let limit = self.limit();
        for way in &self.directions.ways {
            arcs.drop_beyond(limit, |_| *way);
        }
        for step in 0..ARC_STEPS {
            if arcs.is_empty() {
                return;
            }
            let support = self.support(&arcs.next(step));
            arcs.take(|i| support.0.height[i] - support.1.height[i]);
            arcs.drop_beyond(limit, |i| self.way(&support, i));
        }
        list.clear();
        list.extend(arcs.lowest().filter(|d| self.leads_out(d)));
        self.try_all(list);
    }

    /// From the best direction down to the nearest valley: the gradient of the depth is the way between the two extreme places,
    /// across the direction. Places, not points: along an edge or a face many are extreme, and their middle counts.
    fn descend(&mut self, list: &mut Vec<Point>) {
        let (mut step, mut tries) = (1.0, 0);
        while let Some(found) = self.found.filter(|f| f.depth() > self.noise) {
            let d = found.direction;
            let (above, below) = self.extremes(&found, 0.02);
            let way = sub(&middle(&above), &middle(&below));
            let across = along(&way, -dot(&way, &d), &d);
            let size = length(&way).max(f64::MIN_POSITIVE);
            // Ever shorter steps, until one leads down.
            while self.found.is_some_and(|f| f.direction == d) {
                list.clear();
                let mut shorter = step;
                while list.len() < WIDE_LANES && tries + list.len() < MOST_STEPS && shorter >= SHORTEST_STEP {
                    let Some(next) = unit(&along(&d, -shorter / size, &across)) else { break };
                    list.push(next);
                    shorter *= SHORTER;
                }
                if list.is_empty() {
                    return;
                }
                let (high, low) = self.support(&eight_of(list));
                for (i, next) in list.iter().enumerate() {
                    tries += 1;
                    if self.leads_out(next) && self.is_better(next, high.height[i], low.height[i]) {
                        break;
                    }
                    step *= SHORTER;
                }
            }
        }
    }

    /// Boxes around the highest of the mock-up's points and the lowest of the tool's, within a share of the depth.
    fn extremes(&mut self, found: &Found, share: f64) -> (Aabb, Aabb) {
        let (d, tolerance) = (&found.direction, share * found.depth().abs() + self.noise);
        let mut reach = |body: &Body<'_>, d: &Point, height: f64| {
            places_above(self.lanes, body.point_eights, d, height - tolerance, &mut self.directions.places);
            let last = body.points.len().saturating_sub(1);
            let mut bounds = Aabb::EMPTY;
            self.directions.places.iter().for_each(|i| bounds.grow(&body.points[last.min(*i as usize)]));
            bounds
        };
        (reach(self.mockup, d, found.high), reach(self.tool, &scaled(d, -1.0), -found.low))
    }

    /// The middle of the highest part of the mock-up or of the lowest of the tool, whichever is smaller, raised to the height
    /// of the mock-up. The middle of a box around them, which does not know how many triangles make them up.
    fn place(&mut self, found: &Found) -> Point {
        let (above, below) = self.extremes(found, 1e-3);
        let chosen = middle(if length(&below.extent()) <= length(&above.extent()) { &below } else { &above });
        along(&chosen, found.high - dot(&chosen, &found.direction), &found.direction)
    }
}

/// Whether at a cut the surface `w` goes on along `d` to higher than `top`, in the sense in which the other advances over it. An
/// edge that lies across `d` goes on no higher.
fn goes_on(zones: &Zones, w: usize, source: u32, d: &Point, top: f64) -> bool {
    let cut = &zones.cuts[source as usize];
    let [n, other] = [w, 1 - w].map(|w| zones.faces[w][cut.faces[w] as usize].normal);
    let advances = dot(&other, d);
    let leaves = advances - dot(&other, &n) * dot(&n, d);
    let rises = || zones.faces[w][cut.faces[w] as usize].corners.iter().any(|x| dot(x, d) > top);
    !cut.flat && advances > GOES_ON && leaves > GOES_ON && rises()
}

fn middle(b: &Aabb) -> Point {
    scaled(&add(&b.lower, &b.upper), 0.5)
}
