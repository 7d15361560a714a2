//! Patches that belong together, seen as one bulging body.

use crate::bounds::Point;
use crate::contacts::adjacency::NONE;
use crate::contacts::clusters::Clusters;
use crate::contacts::heights::{push_eights, Eight};
use crate::contacts::patches::Patches;
use crate::contacts::sides::Sets;
use crate::vectors::{along, cross, dot, unit};

/// Most edges of a body whose directions are kept.
pub(crate) const MOST_EDGES: usize = 100;

/// What is asked of a patch of a body.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Facet {
    pub normal: Point,
    pub size: f64,
    pub flat: bool,
}

/// Where the planes of two facets meet.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Edge {
    /// Unit.
    pub along: Point,
    /// Square to the normals of the two and to the edge, each to the side where the other is.
    sides: [Point; 2],
}

impl Edge {
    fn new(p: &Facet, q: &Facet) -> Option<Edge> {
        let along = unit(&cross(&p.normal, &q.normal))?;
        Some(Edge { along, sides: [cross(&along, &p.normal), cross(&q.normal, &along)] })
    }

    /// Whether a direction across the edge is between the two normals.
    pub fn is_between(&self, d: &Point) -> bool {
        self.sides.iter().all(|side| dot(d, side) >= 0.0)
    }
}

/// A body, its lists among those of [`Bodies`].
#[derive(Debug)]
struct Entry {
    facets: (usize, usize),
    points: (usize, usize),
    point_eights: (usize, usize),
    curve: (usize, usize),
    curve_eights: (usize, usize),
    edges: (usize, usize),
    mean: Point,
    size: f64,
    largest: f64,
}

/// The bodies of one surface in a zone. Kept as working memory.
#[derive(Debug, Default)]
pub(crate) struct Bodies {
    list: Vec<Entry>,
    facets: Vec<Facet>,
    points: Vec<Point>,
    curve: Vec<(Point, u32)>,
    eights: Vec<Eight>,
    edges: Vec<Edge>,
    /// For each body the cuts it has a part in, by their places in the zone.
    pub cuts: Sets,
    seen: PointSet,
}

/// A body, to be read.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Body<'a> {
    pub facets: &'a [Facet],
    /// Each once.
    pub points: &'a [Point],
    pub point_eights: &'a [Eight],
    /// Points of the curve with their cuts; a point has several.
    pub curve: &'a [(Point, u32)],
    pub curve_eights: &'a [Eight],
    /// Of each two facets; empty where there are more than [`MOST_EDGES`].
    pub edges: &'a [Edge],
    /// Of the facets' normals, by area; zero where there is none.
    pub mean: Point,
    pub size: f64,
    /// The largest coordinate.
    pub largest: f64,
}

impl Bodies {
    pub fn len(&self) -> usize {
        self.list.len()
    }

    /// Whether a body has a part in any cut.
    pub fn is_cut(&self, i: usize) -> bool {
        self.cuts.get(i).iter().any(|word| *word != 0)
    }

    pub fn get(&self, i: usize) -> Body<'_> {
        let e = &self.list[i];
        Body {
            facets: &self.facets[e.facets.0..e.facets.1],
            points: &self.points[e.points.0..e.points.1],
            point_eights: &self.eights[e.point_eights.0..e.point_eights.1],
            curve: &self.curve[e.curve.0..e.curve.1],
            curve_eights: &self.eights[e.curve_eights.0..e.curve_eights.1],
            edges: &self.edges[e.edges.0..e.edges.1],
            mean: e.mean,
            size: e.size,
            largest: e.largest,
        }
    }

    /// Makes the bodies of a zone with so many cuts. `place_of_cut` tells where a cut is among them.
    pub fn set(&mut self, patches: &Patches, clusters: &Clusters, cuts: usize, place_of_cut: impl Fn(u32) -> usize) {
        self.list.clear();
        self.facets.clear();
        self.points.clear();
        self.curve.clear();
        self.eights.clear();
        self.edges.clear();
        self.cuts.clear(clusters.count, cuts);
        for (i, (own, lent)) in clusters.patches.iter().zip(&clusters.lent).enumerate().take(clusters.count) {
            let from = (self.facets.len(), self.points.len(), self.curve.len(), self.edges.len());
            self.seen.clear();
            let own = || own.iter().map(|p| &patches.list[*p as usize]);
            let lent = || lent.iter().map(|p| &patches.list[*p as usize]);
            for (patch, is_own) in own().map(|p| (p, true)).chain(lent().map(|p| (p, false))) {
                self.facets.push(Facet { normal: patch.normal, size: patch.size, flat: patch.flat });
                let (points, sources) = patches.points(patch);
                for (x, source) in points.iter().zip(sources) {
                    if *source != NONE {
                        self.cuts.insert(i, place_of_cut(*source));
                    }
                    if !is_own && own().any(|p| p.is_below(x)) {
                        continue;
                    }
                    if *source != NONE {
                        self.curve.push((*x, *source));
                    }
                    if self.seen.insert(x, &self.points[from.1..]) {
                        self.points.push(*x);
                    }
                }
            }
            self.push_edges(from.0);
            let facets = &self.facets[from.0..];
            let sum = facets.iter().fold([0.0; 3], |s, p| along(&s, p.size * p.size, &p.normal));
            let points = &self.points[from.1..];
            let from_eights = self.eights.len();
            push_eights(points.iter(), &mut self.eights);
            let to_eights = self.eights.len();
            push_eights(self.curve[from.2..].iter().map(|c| &c.0), &mut self.eights);
            self.list.push(Entry {
                facets: (from.0, self.facets.len()),
                points: (from.1, self.points.len()),
                point_eights: (from_eights, to_eights),
                curve: (from.2, self.curve.len()),
                curve_eights: (to_eights, self.eights.len()),
                edges: (from.3, self.edges.len()),
                mean: unit(&sum).unwrap_or([0.0; 3]),
                size: facets.iter().fold(0.0f64, |m, p| m.max(p.size)),
                largest: points.iter().flatten().fold(0.0, |m, x| if x.abs() > m { x.abs() } else { m }),
            });
        }
    }

    fn push_edges(&mut self, from: usize) {
        let facets = &self.facets[from..];
        if edge_count(facets.len()) <= MOST_EDGES {
            for (i, p) in facets.iter().enumerate() {
                self.edges.extend(facets[i + 1..].iter().filter_map(|q| Edge::new(p, q)));
            }
        }
    }
}

/// Pairs of so many facets.
pub(crate) fn edge_count(facets: usize) -> usize {
    facets * facets.saturating_sub(1) / 2
}

/// The places of points in a list, found by their coordinates; empties in constant time.
#[derive(Debug, Default)]
struct PointSet {
    slots: Vec<(u32, u32)>,
    len: usize,
    round: u32,
}

impl PointSet {
    fn clear(&mut self) {
        if self.slots.is_empty() || self.round == u32::MAX {
            self.slots = vec![(0, 0); self.slots.len().max(256)];
            self.round = 0;
        }
        self.round += 1;
        self.len = 0;
    }

    /// Whether a point is not among the `known`, whose places are numbered as they were added; it is the next, then.
    fn insert(&mut self, x: &Point, known: &[Point]) -> bool {
        if 2 * self.len >= self.slots.len() {
            self.slots = vec![(0, 0); 2 * self.slots.len()];
            for (y, i) in known.iter().zip(0..) {
                let at = self.find(y, known);
                self.slots[at] = (self.round, i);
            }
        }
        let at = self.find(x, known);
        if self.slots[at].0 == self.round {
            return false;
        }
        self.slots[at] = (self.round, self.len as u32);
        self.len += 1;
        true
    }

    /// The slot of a point, or the free one where it belongs.
    fn find(&self, x: &Point, known: &[Point]) -> usize {
        let mask = self.slots.len() - 1;
        // Adding 0 makes one zero of the two.
        let hash =
            x.iter().fold(0u64, |h, c| (h.rotate_left(21) ^ (c + 0.0).to_bits()).wrapping_mul(0x9e37_79b9_7f4a_7c15));
        let mut at = (hash >> 32) as usize & mask;
        while self.slots[at].0 == self.round && known[self.slots[at].1 as usize] != *x {
            at = (at + 1) & mask;
        }
        at
    }
}
