//! How deep two bulging surfaces are in each other, and along which direction least.
//!
//! Along a unit direction d the depth is the highest of the mock-up's points less the lowest of the tool's: the way the tool
//! has to go along d until a plane across d holds the two apart. The least of it over all d is at a normal of one of the two,
//! or at a direction across an edge of each, as for any two polytopes; for curved surfaces a short descent follows.

use crate::bounds::{Aabb, Point};
use crate::contacts::adjacency::NONE;
use crate::contacts::patches::{Cluster, Patch};
use crate::contacts::zones::{Zones, MOCKUP, TOOL};
use crate::vectors::{add, along, cross, dot, length, scaled, sub, unit};

/// Most directions tried of each kind.
const MOST_NORMALS: usize = 24;

/// Most pairs of edges whose common perpendiculars are tried.
const MOST_EDGE_PAIRS: usize = 100;

/// Most patches of a body, the largest, between whose normals directions are sought.
const MOST_TURNED: usize = 3;

/// Most ways between extreme places that are kept to reject directions by.
const MOST_WAYS: usize = 24;

/// Sine from which on a surface goes on along a direction.
const GOES_ON: f64 = 0.05;

/// A later direction must be shallower by this share to be preferred, so that ties fall to normals of the mock-up always.
const CLEARLY: f64 = 1e-6;

/// Patches that belong together, seen as one body.
pub(crate) struct Body<'a> {
    pub patches: Vec<&'a Patch>,
    /// Each about once.
    points: Vec<Point>,
    /// The same in fours, by axis; the last four are filled up.
    fours: Vec<[[f64; 4]; 3]>,
    /// Points of the curve with their cuts; a point has several.
    curve: Vec<(Point, u32)>,
    mean: Point,
    size: f64,
    /// The largest coordinate.
    largest: f64,
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
        let curve = points.iter().copied().zip(sources).filter(|(_, s)| *s != NONE).collect();
        // By their heights along some direction: equal points come together, and few others with them.
        let height = |p: &Point| p[0] + 0.618_033_98 * p[1] + 0.414_213_56 * p[2];
        points.sort_unstable_by(|a, b| height(a).total_cmp(&height(b)));
        points.dedup();
        let four =
            |four: &[Point]| std::array::from_fn(|a| std::array::from_fn(|i| four.get(i).unwrap_or(&four[0])[a]));
        let largest = points.iter().flatten().fold(0.0, |m, x| if x.abs() > m { x.abs() } else { m });
        let fours = points.chunks(4).map(four).collect();
        let size = patches.iter().fold(0.0f64, |m, p| m.max(p.size));
        Body { points, fours, curve, mean: unit(&sum).unwrap_or([0.0; 3]), size, largest, patches }
    }

    /// The cuts its patches have a part in, sorted.
    pub fn cuts(&self) -> Vec<u32> {
        let mut cuts: Vec<u32> = self.patches.iter().flat_map(|p| p.cuts.iter().copied()).collect();
        cuts.sort_unstable();
        cuts
    }

    /// The greatest height of a point along `d`, as [`dot`] has it.
    fn highest(&self, d: &Point) -> f64 {
        let mut best = [f64::NEG_INFINITY; 4];
        for [x, y, z] in &self.fours {
            for i in 0..4 {
                let h = x[i] * d[0] + y[i] * d[1] + z[i] * d[2];
                best[i] = if h > best[i] { h } else { best[i] };
            }
        }
        best.into_iter().fold(f64::NEG_INFINITY, f64::max)
    }

    /// The least.
    fn lowest(&self, d: &Point) -> f64 {
        -self.highest(&scaled(d, -1.0))
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
    let noise = 1e-12 * size.max(tool.largest);
    let mut best = Best { zones, tool, mockup, noise, found: None, ways: Vec::with_capacity(MOST_WAYS) };
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
    if !certain {
        best.turn_around_edges(&mockup.patches, 1.0);
        best.turn_around_edges(&tool.patches, -1.0);
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
    /// From a low place of the tool to a high one of the mock-up, along directions tried: no direction is less deep than any
    /// of them along it.
    ways: Vec<Point>,
}

impl Best<'_> {
    /// The depth from which on a direction is of no use; infinite where any is.
    fn limit(&self) -> f64 {
        match self.found {
            // Above the noise, where a depth of nothing is judged by the lean.
            Some((_, least, _)) => (least - CLEARLY * least.abs() - self.noise).max(2.0 * self.noise) + self.noise,
            None => f64::INFINITY,
        }
    }

    fn keep_way(&mut self, d: &Point, high: f64, low: f64) {
        if self.ways.len() == MOST_WAYS {
            self.ways.remove(0);
        }
        let at = |body: &Body<'_>, height: f64| body.points.iter().find(|p| dot(p, d) == height).copied();
        if let (Some(p), Some(q)) = (at(self.mockup, high), at(self.tool, low)) {
            self.ways.push(sub(&p, &q));
        }
    }

    /// The highest of the mock-up and the lowest of the tool.
    fn support(&self, d: &Point) -> (f64, f64) {
        (self.mockup.highest(d), self.tool.lowest(d))
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
        let (top, bottom) = (high - tolerance, low + tolerance);
        self.mockup.curve.iter().any(|(x, source)| dot(x, d) >= top && goes_on(MOCKUP, *source))
            || self.tool.curve.iter().any(|(x, source)| dot(x, d) <= bottom && goes_on(TOOL, *source))
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
        let limit = self.limit();
        if self.ways.iter().any(|w| dot(w, d) >= limit) {
            return;
        }
        let (high, low) = self.support(d);
        self.keep_way(d, high, low);
        let depth = high - low;
        let lean = match self.found {
            None => self.lean(d),
            Some((_, least, _)) if depth < least - CLEARLY * least.abs() - self.noise => self.lean(d),
            Some((_, least, least_lean)) if depth <= self.noise && least <= self.noise => {
                let lean = self.lean(d);
                if lean >= least_lean - 1e-6 {
                    return;
                }
                lean
            }
            Some(_) => return,
        };
        if !self.goes_on(d, high, low) {
            self.found = Some((*d, depth, lean));
        }
    }

    /// The valley between the normals of two patches: where an edge holds, the least depth lies on the arc around it, in a
    /// valley too narrow for the descent when the edge is long.
    fn turn_around_edges(&mut self, patches: &[&Patch], sense: f64) {
        let between =
            |p: &Patch, q: &Patch, s: f64| unit(&along(&scaled(&p.normal, sense * (1.0 - s)), sense * s, &q.normal));
        for (i, p) in patches.iter().enumerate().take(MOST_TURNED) {
            for q in patches.iter().take(MOST_TURNED).skip(i + 1) {
                // Opposite faces have no edge, and nearly equal ones no arc to speak of.
                if !(-0.5..0.95).contains(&dot(&p.normal, &q.normal)) {
                    continue;
                }
                // No direction between is less deep than a way is along both ends.
                let (limit, ends) = (self.limit(), [scaled(&p.normal, sense), scaled(&q.normal, sense)]);
                if self.ways.iter().any(|w| ends.iter().all(|d| dot(w, d) >= limit)) {
                    continue;
                }
                // The golden section: each step needs one depth.
                const RATIO: f64 = 0.618_033_988_749_894_9;
                let at = |s: f64| between(p, q, s).map_or(f64::INFINITY, |d| self.depth(&d));
                let (mut from, mut to) = (0.0, 1.0);
                let (mut s, mut t) = (1.0 - RATIO, RATIO);
                let (mut a, mut b) = (at(s), at(t));
                for _ in 0..9 {
                    if a <= b {
                        (to, t, b) = (t, s, a);
                        s = to - RATIO * (to - from);
                        a = at(s);
                    } else {
                        (from, s, a) = (s, t, b);
                        t = from + RATIO * (to - from);
                        b = at(t);
                    }
                }
                if let Some(d) = between(p, q, 0.5 * (from + to)) {
                    self.try_direction(&d);
                }
            }
        }
    }

    fn depth(&self, d: &Point) -> f64 {
        let (high, low) = self.support(d);
        high - low
    }

    /// From the best direction down to the nearest valley: the gradient of the depth is the way between the two extreme places,
    /// across the direction. Places, not points: along an edge or a face many are extreme, and their middle counts.
    fn descend(&mut self) {
        let mut step = 1.0;
        let mut last: Option<(Point, Point)> = None;
        for _ in 0..24 {
            let Some((d, depth, _)) = self.found else { return };
            if depth <= self.noise || step < 0.01 {
                return;
            }
            let way = match last {
                Some((of, way)) if of == d => way,
                _ => {
                    let (above, below) = self.extremes(&d, 0.02);
                    sub(&middle(&above), &middle(&below))
                }
            };
            last = Some((d, way));
            let across = along(&way, -dot(&way, &d), &d);
            let Some(next) = unit(&along(&d, -step / length(&way).max(f64::MIN_POSITIVE), &across)) else { return };
            self.try_direction(&next);
            if self.found.is_some_and(|f| f.0 == d) {
                step *= 0.6;
            }
        }
    }

    /// Boxes around the highest of the mock-up's points and the lowest of the tool's, within a share of the depth.
    fn extremes(&self, d: &Point, share: f64) -> (Aabb, Aabb) {
        let (high, low) = self.support(d);
        let tolerance = share * (high - low).abs() + self.noise;
        let (top, bottom) = (high - tolerance, low + tolerance);
        let (mut above, mut below) = (Aabb::EMPTY, Aabb::EMPTY);
        self.mockup.points.iter().filter(|x| dot(x, d) >= top).for_each(|x| above.grow(x));
        self.tool.points.iter().filter(|x| dot(x, d) <= bottom).for_each(|x| below.grow(x));
        (above, below)
    }

    /// The middle of the highest part of the mock-up or of the lowest of the tool, whichever is smaller, raised to the height
    /// of the mock-up. The middle of a box around them, which does not know how many triangles make them up.
    fn place(&self, d: &Point) -> Point {
        let (above, below) = self.extremes(d, 1e-3);
        let chosen = middle(if length(&below.extent()) <= length(&above.extent()) { &below } else { &above });
        let high = self.mockup.highest(d);
        along(&chosen, high - dot(&chosen, d), d)
    }
}

fn middle(b: &Aabb) -> Point {
    scaled(&add(&b.lower, &b.upper), 0.5)
}
