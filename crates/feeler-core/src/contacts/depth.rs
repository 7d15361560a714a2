//! How deep two bulging surfaces are in each other, and along which direction least.
//!
//! Along a unit direction d the depth is the highest of the mock-up's points less the lowest of the tool's: the way the tool
//! has to go along d until a plane across d holds the two apart. The least of it over all d is at a normal of one of the two,
//! or at a direction across an edge of each, as for any two polytopes; for curved surfaces a short descent follows.

use crate::bounds::{Aabb, Point};
use crate::contacts::adjacency::NONE;
use crate::contacts::patches::{Cluster, Patch};
use crate::contacts::vector::{add, along, cross, dot, norm, scaled, sub, unit};
use crate::contacts::zones::{Zones, MOCKUP, TOOL};

/// Most directions tried of each kind.
const MOST_NORMALS: usize = 24;

/// Most pairs of edges whose common perpendiculars are tried.
const MOST_EDGE_PAIRS: usize = 100;

/// Sine from which on a surface goes on along a direction.
const GOES_ON: f64 = 0.05;

/// A later direction must be shallower by this share to be preferred, so that ties fall to normals of the mock-up always.
const CLEARLY: f64 = 1e-6;

/// Patches that belong together, seen as one body.
pub(crate) struct Body<'a> {
    pub patches: Vec<&'a Patch>,
    pub points: Vec<Point>,
    sources: Vec<u32>,
    mean: Point,
    size: f64,
}

impl<'a> Body<'a> {
    pub fn new(all: &'a [Patch], cluster: &Cluster) -> Body<'a> {
        let patches: Vec<&Patch> = cluster.patches.iter().map(|i| &all[*i]).collect();
        let (mut points, mut sources): (Vec<Point>, Vec<u32>) = Default::default();
        for patch in &patches {
            points.extend_from_slice(&patch.points);
            sources.extend_from_slice(&patch.sources);
        }
        for i in &cluster.lent {
            for (x, source) in all[*i].points.iter().zip(&all[*i].sources) {
                if !patches.iter().any(|p| p.is_below(x)) {
                    points.push(*x);
                    sources.push(*source);
                }
            }
        }
        let mut patches = patches;
        patches.extend(cluster.lent.iter().map(|i| &all[*i]));
        let sum = patches.iter().fold([0.0; 3], |s, p| along(&s, p.size * p.size, &p.normal));
        let size = patches.iter().fold(0.0f64, |m, p| m.max(p.size));
        Body { points, sources, mean: unit(&sum).unwrap_or([0.0; 3]), size, patches }
    }

    /// The cuts its patches have a part in, sorted.
    pub fn cuts(&self) -> Vec<u32> {
        let mut cuts: Vec<u32> = self.patches.iter().flat_map(|p| p.cuts.iter().copied()).collect();
        cuts.sort_unstable();
        cuts
    }

    fn is_flat(&self) -> bool {
        self.patches.iter().all(|p| p.flat)
    }
}

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

/// See the module. `None` where no direction leads out.
pub(crate) fn least_depth(zones: &Zones, tool: &Body<'_>, mockup: &Body<'_>) -> Option<Depth> {
    let size = tool.size.max(mockup.size);
    let noise = 1e-12 * tool.points.iter().flatten().fold(size, |m, x| m.max(x.abs()));
    let mut best = Best { zones, tool, mockup, noise, found: None };
    let mut certain = tool.is_flat() && mockup.is_flat();
    certain &= tool.patches.len() <= MOST_NORMALS && mockup.patches.len() <= MOST_NORMALS;
    for patch in mockup.patches.iter().take(MOST_NORMALS) {
        best.try_direction(&patch.normal);
    }
    for patch in tool.patches.iter().take(MOST_NORMALS) {
        best.try_direction(&scaled(&patch.normal, -1.0));
    }
    best.try_direction(&mockup.mean);
    best.try_direction(&scaled(&tool.mean, -1.0));
    let edges = |n: usize| n * n.saturating_sub(1) / 2;
    if edges(mockup.patches.len()) * edges(tool.patches.len()) <= MOST_EDGE_PAIRS {
        for e in edge_directions(mockup) {
            for f in edge_directions(tool) {
                if let Some(d) = unit(&cross(&e, &f)) {
                    best.try_direction(&d);
                    best.try_direction(&scaled(&d, -1.0));
                }
            }
        }
    } else {
        certain = false;
    }
    if !(tool.is_flat() && mockup.is_flat()) {
        best.descend();
    }
    let (normal, depth, _) = best.found?;
    Some(Depth { normal, depth, point: best.place(&normal), certain })
}

fn edge_directions(body: &Body<'_>) -> Vec<Point> {
    let mut found = Vec::new();
    for (i, p) in body.patches.iter().enumerate() {
        found.extend(body.patches[i + 1..].iter().filter_map(|q| unit(&cross(&p.normal, &q.normal))));
    }
    found
}

struct Best<'a> {
    zones: &'a Zones,
    tool: &'a Body<'a>,
    mockup: &'a Body<'a>,
    /// Metres below which depths are the same.
    noise: f64,
    /// Direction, depth, and how far the two bodies lean over the plane between them.
    found: Option<(Point, f64, f64)>,
}

impl Best<'_> {
    fn support(&self, d: &Point) -> (usize, usize) {
        let mut high = (0, f64::NEG_INFINITY);
        for (i, p) in self.mockup.points.iter().enumerate() {
            let h = dot(p, d);
            if h > high.1 {
                high = (i, h);
            }
        }
        let mut low = (0, f64::INFINITY);
        for (i, q) in self.tool.points.iter().enumerate() {
            let h = dot(q, d);
            if h < low.1 {
                low = (i, h);
            }
        }
        (high.0, low.0)
    }

    /// Whether one of the surfaces goes on beyond the curve just where, along `d`, it would have to end: a rod in a plate is not
    /// freed sideways by its own width, for there is more plate.
    fn goes_on(&self, d: &Point, high: f64, low: f64) -> bool {
        let tolerance = self.noise + 1e-6 * (high - low).abs();
        let goes_on = |w: usize, source: u32| {
            let cut = &self.zones.cuts[source as usize];
            let [t, m] = [TOOL, MOCKUP].map(|w| self.zones.faces[w][cut.faces[w] as usize].normal);
            // Own and other normal, and the way in the sense in which the other advances over this one.
            let (n, other, way) = if w == MOCKUP { (m, t, *d) } else { (t, m, scaled(d, -1.0)) };
            let advances = dot(&other, &way);
            let leaves = advances - dot(&other, &n) * dot(&n, &way);
            !cut.flat && advances > GOES_ON && leaves > GOES_ON
        };
        let any = |w: usize, body: &Body<'_>, is_last: &dyn Fn(f64) -> bool| {
            body.points.iter().zip(&body.sources).any(|(x, s)| *s != NONE && is_last(dot(x, d)) && goes_on(w, *s))
        };
        any(MOCKUP, self.mockup, &|h| h >= high - tolerance) || any(TOOL, self.tool, &|h| h <= low + tolerance)
    }

    /// Whether going along `d` leads out: not into what the surfaces face.
    fn leads_out(&self, d: &Point) -> bool {
        dot(d, &self.mockup.mean) > -0.01 && dot(d, &self.tool.mean) < 0.01
    }

    /// How far the two surfaces face into the plane across `d`, as the sum of cosines: tells directions apart where the two
    /// only touch, and every direction is as deep.
    fn lean(&self, d: &Point) -> f64 {
        let under = |n: &Point, s: f64| (-s * dot(n, d)).max(0.0);
        let of = |body: &Body<'_>, s: f64| body.patches.iter().map(|p| under(&p.normal, s)).sum::<f64>();
        of(self.mockup, 1.0) + of(self.tool, -1.0)
    }

    fn try_direction(&mut self, d: &Point) {
        if d == &[0.0; 3] || !self.leads_out(d) {
            return;
        }
        let (p, q) = self.support(d);
        let depth = dot(&sub(&self.mockup.points[p], &self.tool.points[q]), d);
        if self.goes_on(d, dot(&self.mockup.points[p], d), dot(&self.tool.points[q], d)) {
            return;
        }
        let Some((_, least, least_lean)) = self.found else {
            self.found = Some((*d, depth, self.lean(d)));
            return;
        };
        if depth < least - CLEARLY * least.abs() - self.noise {
            self.found = Some((*d, depth, self.lean(d)));
        } else if depth <= self.noise && least <= self.noise {
            let lean = self.lean(d);
            if lean < least_lean - 1e-6 {
                self.found = Some((*d, depth, lean));
            }
        }
    }

    /// From the best direction down to the nearest valley: the gradient of the depth is the difference of the two extreme
    /// points, across the direction.
    fn descend(&mut self) {
        let mut step = 0.5;
        for _ in 0..12 {
            let Some((d, depth, _)) = self.found else { return };
            if depth <= self.noise {
                return;
            }
            let (p, q) = self.support(&d);
            let way = sub(&self.mockup.points[p], &self.tool.points[q]);
            let across = along(&way, -dot(&way, &d), &d);
            let Some(next) = unit(&along(&d, -step / norm(&way).max(f64::MIN_POSITIVE), &across)) else { return };
            self.try_direction(&next);
            if self.found.is_some_and(|f| f.0 == d) {
                step *= 0.5;
            }
        }
    }

    /// The middle of the highest part of the mock-up or of the lowest of the tool, whichever is smaller, raised to the height
    /// of the mock-up. The middle of a box around them, which does not know how many triangles make them up.
    fn place(&self, d: &Point) -> Point {
        let (p, q) = self.support(d);
        let (high, low) = (dot(&self.mockup.points[p], d), dot(&self.tool.points[q], d));
        let tolerance = 1e-3 * (high - low).abs() + self.noise;
        let extent = |points: &[Point], keep: &dyn Fn(f64) -> bool| {
            let mut bounds = Aabb::EMPTY;
            points.iter().filter(|x| keep(dot(x, d))).for_each(|x| bounds.grow(x));
            bounds
        };
        let above = extent(&self.mockup.points, &|h| h >= high - tolerance);
        let below = extent(&self.tool.points, &|h| h <= low + tolerance);
        let chosen = if norm(&below.extent()) <= norm(&above.extent()) { below } else { above };
        let middle = scaled(&add(&chosen.lower, &chosen.upper), 0.5);
        along(&middle, high - dot(&middle, d), d)
    }
}
