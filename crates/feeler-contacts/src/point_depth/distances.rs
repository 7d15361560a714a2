//! The distances of a piece's corners to triangles of the other body, and the bounds that follow.

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

    /// The bounds of both parts after a cut, from these triangles; `None` if nothing is cut.
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
                // A corner in the plane belongs to both.
                let sense = [1.0, -1.0][side];
                let on_side = heights.iter().zip(row).filter(|(h, _)| sense * **h >= 0.0);
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

#[cfg(test)]
mod tests {
    use super::super::brute::{body, distance, point_of, triangle};
    use super::super::outline::Outline;
    use super::*;
    use feeler_core::Triangle;
    use feeler_shapes::random::Random;
    use feeler_shapes::soups::arrays_of;

    fn soup(r: &mut Random, count: u64) -> Body {
        let triangles: Vec<Triangle> = (0..1 + r.below(count)).map(|_| triangle(r, 0.5)).collect();
        body(arrays_of(triangles))
    }

    fn outline_near(r: &mut Random, body: &Body, size: f64) -> Outline {
        let t = triangle(r, size).map(|p| std::array::from_fn(|a| p[a] - body.origin()[a]));
        let outline = Outline::clipped(&t, 1, None).unwrap();
        let plane = Plane::through(&outline.middle(), &r.point(-1.0, 1.0)).unwrap();
        let half = outline.cut(&plane).next();
        half.unwrap()
    }

    fn corners_of(points: &[Point], body: &Body) -> Vec<Corner> {
        let corner = |at: &Point| {
            let closest = body.closest(at, f64::INFINITY).unwrap();
            Corner { at: *at, distance: closest.distance, nearest: closest.triangle, point: closest.point }
        };
        points.iter().map(corner).collect()
    }

    fn sampled(r: &mut Random, points: &[Point], body: &Body) -> f64 {
        (0..60).map(|_| distance(body, &point_of(r, points))).fold(0.0, f64::max)
    }

    #[test]
    fn no_bound_is_below_a_distance() {
        let mut r = Random::new(1);
        let mut mixed_is_less = 0;
        for n in 0..1500 {
            let size = [0.05, 0.3, 1.0][n % 3];
            let body = soup(&mut r, 12);
            let outline = outline_near(&mut r, &body, size);
            let corners = corners_of(&outline.points, &body);
            let most = sampled(&mut r, &outline.points, &body);
            let (bound, witness) = least_bound(&corners, &body);
            assert!(bound >= most - 1e-12, "{bound} {most}");
            // The bound is the least over the triangles nearest to the corners, and the triangle is the one with that bound.
            let says = |i: u32| corners.iter().map(|c| distance_to(&c.at, body.triangle(i))).fold(0.0, f64::max);
            let least = corners.iter().map(|corner| says(corner.nearest)).fold(f64::INFINITY, f64::min);
            assert!((bound - least).abs() < 1e-12 && (says(witness) - least).abs() < 1e-12, "{bound} {least}");
            let distances = Distances::new(&corners, Some(0), &body);
            let mixed = distances.mixed();
            assert!(mixed >= most - 1e-12, "{mixed} {most}");
            mixed_is_less += usize::from(mixed < bound - 1e-9);
            let farthest = distances.farthest_from(witness);
            assert!((distance_to(&farthest.at, body.triangle(witness)) - bound).abs() < 1e-12);
            let plane = match n % 4 {
                // Through a corner, which belongs to both parts.
                0 => Plane::through(&outline.points[0], &r.point(-1.0, 1.0)).unwrap(),
                _ => Plane::through(&point_of(&mut r, &outline.points), &r.point(-1.0, 1.0)).unwrap(),
            };
            let parts: Vec<Outline> = outline.cut(&plane).collect();
            if let Some(bounds) = distances.bounds_after(&plane, 1.0) {
                for (part, bound) in parts.iter().zip(bounds) {
                    let most = sampled(&mut r, &part.points, &body);
                    let at_corners = part.points.iter().map(|p| distance(&body, p)).fold(0.0, f64::max);
                    assert!(
                        parts.len() == 2 && bound >= most.max(at_corners) - 1e-12,
                        "{n}: {bound} {most} {at_corners}"
                    );
                }
            }
        }
        assert!(mixed_is_less > 300, "{mixed_is_less}");
    }

    /// Two large walls, at x of 0 and of `gap`.
    fn walls(gap: f64) -> Body {
        let wall = |x: f64| [[x, -100.0, -100.0], [x, 100.0, -100.0], [x, 0.0, 200.0]];
        body(arrays_of([wall(0.0), wall(gap)]))
    }

    #[test]
    fn between_walls_the_mixture_is_half_their_distance_and_halves_are_bounded_by_their_own() {
        let body = walls(2.0);
        // Its corners are in the frame of the body, with the walls at -1 and 1.
        let points = [[-0.9, -1.0, 0.0], [-0.9, 1.0, 0.0], [0.9, 1.0, 0.0], [0.8, -1.0, 0.0]];
        let corners = corners_of(&points, &body);
        let (bound, _) = least_bound(&corners, &body);
        assert!((bound - 1.9).abs() < 1e-12, "{bound}");
        let distances = Distances::new(&corners, None, &body);
        assert_eq!(distances.count(), 2);
        assert!((distances.mixed() - 1.0).abs() < 1e-9, "{}", distances.mixed());
        let [p, q] = distances.bounds_after(&Plane::at([1.0, 0.0, 0.0], 0.0), 1.0).unwrap();
        assert!((p - 1.0).abs() < 1e-9 && (q - 1.0).abs() < 1e-9, "{p} {q}");
        let [above, below] = distances.bounds_after(&Plane::at([1.0, 0.0, 0.0], -0.5), 1.0).unwrap();
        assert!((below - 0.5).abs() < 1e-9 && (above - 1.0).abs() < 1e-9, "{above} {below}");
        assert!(distances.bounds_after(&Plane::at([1.0, 0.0, 0.0], 0.95), 1.0).is_none());
        assert!(distances.bounds_after(&Plane::at([1.0, 0.0, 0.0], 0.9 - 1e-10), 1.0).is_none());
    }

    #[test]
    fn mixtures_are_no_less_than_the_least_and_close_to_it() {
        let mut r = Random::new(2);
        let mut close = 0;
        for _ in 0..2000 {
            let count = 2 + r.below(6) as usize;
            let [p, q]: [Vec<f64>; 2] = std::array::from_fn(|_| (0..count).map(|_| r.real(0.0, 1.0)).collect());
            let at = |w: f64| p.iter().zip(&q).map(|(p, q)| w * p + (1.0 - w) * q).fold(0.0, f64::max);
            let least = (0..=20_000).map(|i| at(f64::from(i) / 20_000.0)).fold(f64::INFINITY, f64::min);
            let found = least_of_mixtures(&p, &q);
            assert!(found >= least - 1e-4 && found <= at(0.0).min(at(1.0)), "{p:?} {q:?}");
            close += usize::from(found <= least + 1e-9);
        }
        assert!(close > 1900, "{close}");
        assert_eq!(least_of_mixtures(&[1.0, 0.0], &[0.0, 1.0]), 0.5);
        assert_eq!(least_of_mixtures(&[1.0, 1.0], &[0.25, 0.5]), 0.5);
    }
}
