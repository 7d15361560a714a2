//! The distance of a point to the convex hull of six others: the algorithm of E. Gilbert, D. Johnson and S. Keerthi (1988).
//!
//! Each step has a point of the hull, which bounds the distance from above, and a plane before the hull, which bounds it from below.
//! Callers have a tolerance, so that a few steps are enough.

use feeler_core::geometry::vectors::{add, cross, dot, scaled, sub};
use feeler_core::Point;

/// Corners of a hull: of a triangle at two places.
pub type Corners = [Point; 6];

/// Steps after which the bounds are as good as rounding allows: most often there are three.
const MOST_STEPS: usize = 48;

/// A bound from below for the distance, metres: within the tolerance of it, or at least `enough`. Both metres.
pub fn distance_point_hull(p: &Point, corners: &Corners, enough: f64, tolerance: f64) -> f64 {
    search(p, corners, enough, tolerance, 0.0).lower
}

/// Whether a point is within some metres of the hull; where that cannot be told of one at just that distance: no.
pub fn is_near_hull(p: &Point, corners: &Corners, within: f64) -> bool {
    search(p, corners, within, 0.0, within).upper <= within
}

struct Bounds {
    lower: f64,
    upper: f64,
}

/// Until the lower bound is `enough`, the upper one `little`, or both are as near each other as the tolerance.
fn search(p: &Point, corners: &Corners, enough: f64, tolerance: f64, little: f64) -> Bounds {
    let points = corners.map(|q| sub(&q, p));
    let mut simplex = Simplex { points: [points[0]; 4], count: 1 };
    let mut nearest = points[0];
    let mut found = Bounds { lower: 0.0, upper: f64::INFINITY };
    for _ in 0..MOST_STEPS {
        let length = dot(&nearest, &nearest).sqrt();
        if length < found.upper {
            found.upper = length;
        }
        if found.upper <= little || found.upper <= tolerance {
            break;
        }
        let mut support = (dot(&points[0], &nearest), &points[0]);
        for q in &points[1..] {
            let height = dot(q, &nearest);
            if height < support.0 {
                support = (height, q);
            }
        }
        found.lower = found.lower.max(support.0 / length);
        if found.lower >= enough || found.upper - found.lower <= tolerance || simplex.has(support.1) {
            break;
        }
        simplex.points[simplex.count] = *support.1;
        simplex.count += 1;
        match simplex.reduce() {
            Some(v) => nearest = v,
            None => return Bounds { lower: 0.0, upper: 0.0 },
        }
    }
    found
}

/// Up to four corners of the hull.
struct Simplex {
    points: [Point; 4],
    count: usize,
}

impl Simplex {
    fn has(&self, q: &Point) -> bool {
        self.points[..self.count].contains(q)
    }

    /// Keeps those corners that the nearest point to the origin is between, and returns it; `None` where the origin is inside.
    fn reduce(&mut self) -> Option<Point> {
        let [a, b, c, d] = self.points;
        match self.count {
            2 => Some(self.keep(nearest_on_segment(&a, &b))),
            3 => Some(self.keep(nearest_on_triangle(&a, &b, &c))),
            4 => {
                let mut best: Option<Feature> = None;
                let mut is_outside = false;
                for [x, y, z, apex] in [[a, b, c, d], [a, c, d, b], [a, d, b, c], [b, d, c, a]] {
                    let normal = cross(&sub(&y, &x), &sub(&z, &x));
                    let (own, other) = (-dot(&x, &normal), dot(&sub(&apex, &x), &normal));
                    // On the other side of the face than the fourth corner, or a tetrahedron without volume.
                    if own * other > 0.0 {
                        continue;
                    }
                    is_outside = true;
                    let feature = nearest_on_triangle(&x, &y, &z);
                    if best.as_ref().is_none_or(|b| dot(&feature.nearest, &feature.nearest) < dot(&b.nearest, &b.nearest)) {
                        best = Some(feature);
                    }
                }
                best.filter(|_| is_outside).map(|feature| self.keep(feature))
            }
            _ => Some(a),
        }
    }

    fn keep(&mut self, feature: Feature) -> Point {
        self.points[..3].copy_from_slice(&feature.points);
        self.count = feature.count;
        feature.nearest
    }
}

/// The corners of a face that the nearest point is between.
struct Feature {
    points: [Point; 3],
    count: usize,
    nearest: Point,
}

fn corner(a: &Point) -> Feature {
    Feature { points: [*a; 3], count: 1, nearest: *a }
}

fn nearest_on_segment(a: &Point, b: &Point) -> Feature {
    let along = sub(b, a);
    let (t, whole) = (-dot(a, &along), dot(&along, &along));
    if t <= 0.0 || whole == 0.0 {
        corner(a)
    } else if t >= whole {
        corner(b)
    } else {
        Feature { points: [*a, *b, *a], count: 2, nearest: add(a, &scaled(&along, t / whole)) }
    }
}

/// The nearest point to the origin, by the regions of C. Ericson (Real-Time Collision Detection, 2005, section 5.1.5).
fn nearest_on_triangle(a: &Point, b: &Point, c: &Point) -> Feature {
    let (ab, ac) = (sub(b, a), sub(c, a));
    let (d1, d2) = (-dot(&ab, a), -dot(&ac, a));
    if d1 <= 0.0 && d2 <= 0.0 {
        return corner(a);
    }
    let (d3, d4) = (-dot(&ab, b), -dot(&ac, b));
    if d3 >= 0.0 && d4 <= d3 {
        return corner(b);
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return nearest_on_segment(a, b);
    }
    let (d5, d6) = (-dot(&ab, c), -dot(&ac, c));
    if d6 >= 0.0 && d5 <= d6 {
        return corner(c);
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return nearest_on_segment(a, c);
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        return nearest_on_segment(b, c);
    }
    let sum = va + vb + vc;
    if sum <= 0.0 {
        return nearest_on_segment(a, b);
    }
    let nearest = add(a, &add(&scaled(&ab, vb / sum), &scaled(&ac, vc / sum)));
    Feature { points: [*a, *b, *c], count: 3, nearest }
}

#[cfg(test)]
mod tests {
    use super::*;
    use feeler_shapes::random::Random;

    /// By trial: the hull's points are weighted means of its corners, and the weights of the nearest are found by going to corners
    /// with ever smaller steps (M. Frank and P. Wolfe 1956).
    fn by_trial(p: &Point, corners: &Corners) -> f64 {
        let points = corners.map(|q| sub(&q, p));
        let mut x = points[0];
        for _ in 0..20_000 {
            let q = points.iter().min_by(|a, b| dot(a, &x).total_cmp(&dot(b, &x))).unwrap();
            x = nearest_on_segment(&x, q).nearest;
        }
        dot(&x, &x).sqrt()
    }

    #[test]
    fn bounds_hold_for_solid_flat_and_thin_hulls() {
        let mut random = Random::new(7);
        for case in 0..600 {
            let mut corners: Corners = std::array::from_fn(|_| random.point(-1.0, 1.0));
            match case % 6 {
                1 => corners = [corners[0], corners[1], corners[2], corners[0], corners[1], corners[2]],
                2 => corners.iter_mut().for_each(|q| q[2] = 0.25),
                3 => corners.iter_mut().for_each(|q| (q[1], q[2]) = (0.5 * q[0], 0.0)),
                4 => corners = [corners[0]; 6],
                5 => corners = std::array::from_fn(|i| if i < 3 { corners[i] } else { add(&corners[i - 3], &[30.0, 1.0, 0.0]) }),
                _ => {}
            }
            let p = random.point(-2.0, 2.0);
            let (truth, slack) = (by_trial(&p, &corners), 2e-3);
            let found = distance_point_hull(&p, &corners, f64::INFINITY, 1e-9);
            assert!((found - truth).abs() < slack, "case {case}: {found} {truth}");
            let coarse = distance_point_hull(&p, &corners, f64::INFINITY, 0.1);
            assert!(coarse <= found + 1e-9 && coarse >= found - 0.1 - 1e-9, "case {case}: {coarse} {found}");
            let stopped = distance_point_hull(&p, &corners, 0.3, 1e-9);
            assert!(stopped <= found + 1e-9 && stopped >= found.min(0.3) - 1e-9);
            assert!(!is_near_hull(&p, &corners, found - 0.01));
            assert!(is_near_hull(&p, &corners, found + 0.01));
        }
    }

    #[test]
    fn a_point_inside_is_at_no_distance() {
        let mut random = Random::new(3);
        for _ in 0..1000 {
            let corners: Corners = std::array::from_fn(|_| random.point(-1.0, 1.0));
            let mut weights: [f64; 6] = std::array::from_fn(|_| random.real(0.0, 1.0));
            let sum: f64 = weights.iter().sum();
            weights.iter_mut().for_each(|w| *w /= sum);
            let p = corners.iter().zip(weights).fold([0.0; 3], |p, (q, w)| add(&p, &scaled(q, w)));
            assert!(distance_point_hull(&p, &corners, f64::INFINITY, 1e-6) <= 1e-12);
            assert!(is_near_hull(&p, &corners, 1e-6));
        }
    }
}
