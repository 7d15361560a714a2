//! The distances of a piece's corners to triangles of the other body, and what they bound.

use feeler_core::Point;

use super::body::{distance_to, Body};
use super::outline::{between, crossings, Plane};

/// A corner of a piece, and the closest point of the other body.
#[derive(Debug, Clone, Copy)]
pub struct Corner {
    pub at: Point,
    /// Metres.
    pub distance: f64,
    /// The other body's triangle that is closest.
    pub nearest: u32,
    /// The point of it.
    pub point: Point,
}

/// The distances of a piece's corners to the triangles that are closest to some of them.
pub struct Distances<'a> {
    corners: &'a [Corner],
    body: &'a Body,
    /// Each once.
    triangles: Vec<u32>,
    /// By triangle, then by corner.
    distances: Vec<f64>,
}

/// The least bound by the distances to one triangle, which are largest at a corner since they are convex; and the triangle.
pub fn least_bound(corners: &[Corner], body: &Body) -> (f64, u32) {
    let farthest = corners.iter().map(|corner| corner.distance).fold(0.0, f64::max);
    let mut least = (f64::INFINITY, corners[0].nearest);
    for (n, Corner { nearest, .. }) in corners.iter().enumerate() {
        if corners[..n].iter().any(|earlier| earlier.nearest == *nearest) {
            continue;
        }
        let triangle = body.triangle(*nearest);
        let mut most = farthest;
        for corner in corners.iter().filter(|corner| corner.nearest != *nearest) {
            most = most.max(distance_to(&corner.at, triangle));
            if most >= least.0 {
                break;
            }
        }
        if most < least.0 {
            least = (most, *nearest);
        }
        // None is less.
        if most <= farthest {
            break;
        }
    }
    least
}

impl<'a> Distances<'a> {
    pub fn new(corners: &'a [Corner], also: Option<u32>, body: &'a Body) -> Distances<'a> {
        let mut triangles: Vec<u32> = Vec::with_capacity(corners.len() + 1);
        for triangle in corners.iter().map(|corner| corner.nearest).chain(also) {
            if !triangles.contains(&triangle) {
                triangles.push(triangle);
            }
        }
        let mut distances = Vec::with_capacity(triangles.len() * corners.len());
        for triangle in &triangles {
            distances.extend(corners.iter().map(|corner| {
                if corner.nearest == *triangle {
                    corner.distance
                } else {
                    distance_to(&corner.at, body.triangle(*triangle))
                }
            }));
        }
        Distances { corners, body, triangles, distances }
    }

    /// How many triangles there are.
    pub fn count(&self) -> usize {
        self.triangles.len()
    }

    /// The distances to each triangle.
    fn rows(&self) -> impl Iterator<Item = (&[f64], u32)> {
        self.distances.chunks(self.corners.len()).zip(self.triangles.iter().copied())
    }

    /// The least bound by a mixture of the distances to two triangles, which the least distance of no point exceeds: between two walls that
    /// is half their distance, for a piece of any size.
    pub fn mixed(&self) -> f64 {
        let mut best = f64::INFINITY;
        for (i, (p, _)) in self.rows().enumerate() {
            for (q, _) in self.rows().skip(i + 1) {
                best = best.min(least_of_mixtures(p, q));
            }
        }
        best
    }

    /// The corner that is farthest from a triangle.
    pub fn farthest_from(&self, triangle: u32) -> &'a Corner {
        let corners = self.corners;
        let row = self.triangles.iter().position(|t| *t == triangle).unwrap_or(0) * corners.len();
        let mut farthest = 0;
        for i in 1..corners.len() {
            if self.distances[row + i] > self.distances[row + farthest] {
                farthest = i;
            }
        }
        &corners[farthest]
    }

    /// What bounds both parts after a cut, as far as these triangles say; `None` where nothing is cut.
    pub fn bounds_after(&self, plane: &Plane, size: f64) -> Option<[f64; 2]> {
        let corners = self.corners;
        let heights: Vec<f64> = corners.iter().map(|corner| plane.height(&corner.at)).collect();
        let least = LEAST_CUT * size;
        if !heights.iter().any(|h| *h > least) || !heights.iter().any(|h| *h < -least) {
            return None;
        }
        let new: Vec<Point> = crossings(&heights).map(|(i, j, s)| between(&corners[i].at, &corners[j].at, s)).collect();
        // Of each part the distances of its corners, by triangle.
        let mut parts: [Vec<Vec<f64>>; 2] = Default::default();
        for (row, triangle) in self.rows() {
            let triangle = self.body.triangle(triangle);
            let of_new: Vec<f64> = new.iter().map(|p| distance_to(p, triangle)).collect();
            for (side, part) in parts.iter_mut().enumerate() {
                let on_side = heights.iter().zip(row).filter(|(h, _)| (**h >= 0.0) == (side == 0));
                part.push(on_side.map(|(_, distance)| *distance).chain(of_new.iter().copied()).collect());
            }
        }
        Some(parts.map(|rows| {
            let mut best = f64::INFINITY;
            for (i, p) in rows.iter().enumerate() {
                best = best.min(p.iter().fold(0.0f64, |most, distance| most.max(*distance)));
                for q in &rows[i + 1..] {
                    best = best.min(least_of_mixtures(p, q));
                }
            }
            best
        }))
    }
}

/// The least over all shares `w` of the largest of `w p + (1 - w) q`.
fn least_of_mixtures(p: &[f64], q: &[f64]) -> f64 {
    // Convex and piecewise linear in the share: least where a falling line and a rising one cross, else at an end.
    let at = |w: f64| p.iter().zip(q).fold(0.0f64, |most, (p, q)| most.max(w * p + (1.0 - w) * q));
    let (mut low, mut high) = (0.0, 1.0);
    let mut best = at(low).min(at(high));
    for _ in 0..MOST_MIXTURES {
        // The largest line at each end bounds where the least can be.
        let line = |w: f64| {
            p.iter().zip(q).map(|(p, q)| (p - q, *q)).max_by(|a, b| (a.0 * w + a.1).total_cmp(&(b.0 * w + b.1)))
        };
        let (Some(falling), Some(rising)) = (line(low), line(high)) else { break };
        if falling.0 >= 0.0 || rising.0 <= 0.0 {
            break;
        }
        let w = (falling.1 - rising.1) / (rising.0 - falling.0);
        if !(w > low && w < high) {
            break;
        }
        let value = at(w);
        let is_least = value <= (falling.0 * w + falling.1) * (1.0 + 1e-9);
        best = best.min(value);
        if is_least {
            break;
        }
        let Some(top) = line(w) else { break };
        if top.0 < 0.0 {
            low = w;
        } else {
            high = w;
        }
    }
    best
}

/// How often the share of a mixture is bettered; each gives a bound.
const MOST_MIXTURES: usize = 4;

/// Share of a piece's size that a cut must leave on both sides.
const LEAST_CUT: f64 = 1e-9;
