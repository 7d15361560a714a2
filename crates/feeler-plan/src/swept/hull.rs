//! The distance of a point to the convex hull of six others: the algorithm of E. Gilbert, D. Johnson and S. Keerthi (1988).
//!
//! Each step has a point of the hull, which bounds the distance from above, and a plane before the hull, which bounds it from below.
//! Callers pass the required accuracy, so that a few steps are enough.

use feeler_core::geometry::vectors::{along, cross, dot, scaled, sub};
use feeler_core::{Aabb, Point};

/// Corners of a hull: of a triangle at two places.
pub type Corners = [Point; 6];

/// Steps after which the bounds are as good as rounding allows: most often there are three.
const SEARCH_STEPS: usize = 48;

/// A hull, and the box around it.
#[derive(Debug, Clone)]
pub struct Hull {
    /// By axis.
    corners: [[f64; 6]; 3],
    /// Metres.
    pub bounds: Aabb,
}

/// Bounds of a distance, metres.
#[derive(Debug, Clone, Copy)]
pub struct Bounds {
    /// Never above the distance.
    pub lower: f64,
    /// Never below it.
    pub upper: f64,
    /// A plane that shows that points are far from the hull.
    pub plane: Plane,
}

/// The hull is behind it.
#[derive(Debug, Clone, Copy, Default)]
pub struct Plane {
    /// Unit.
    normal: Point,
    offset: f64,
}

impl Plane {
    /// No point is nearer to the hull. Metres.
    #[inline(always)]
    pub fn least_distance(&self, p: &Point) -> f64 {
        self.offset - dot(p, &self.normal)
    }
}

/// When a search may end. Metres.
#[derive(Debug, Clone, Copy)]
pub struct Until {
    /// The lower bound is as large.
    pub enough: f64,
    /// The upper bound is as small.
    pub little: f64,
    /// The bounds are as near each other.
    pub tolerance: f64,
}

impl Hull {
    pub fn new(corners: &Corners) -> Hull {
        let mut bounds = Aabb::EMPTY;
        corners.iter().for_each(|p| bounds.grow(p));
        let mut by_axis = [[0.0; 6]; 3];
        for (i, p) in corners.iter().enumerate() {
            for a in 0..3 {
                by_axis[a][i] = p[a];
            }
        }
        Hull { corners: by_axis, bounds }
    }

    /// Whether a point is within some metres; false if it cannot be decided at just that distance.
    pub fn is_within(&self, p: &Point, within: f64) -> bool {
        self.distance(p, &Until { enough: within, little: within, tolerance: 0.0 }).upper <= within
    }

    /// The squared distance of a point to the box.
    #[inline]
    pub fn square_to_box(&self, p: &Point) -> f64 {
        let off = |a: usize| (self.bounds.lower[a] - p[a]).max(p[a] - self.bounds.upper[a]).max(0.0);
        let [x, y, z] = [off(0), off(1), off(2)];
        x * x + y * y + z * z
    }

    /// Bounds of the distance of a point.
    pub fn distance(&self, p: &Point, until: &Until) -> Bounds {
        let [x, y, z] = &self.corners;
        let place = |i: usize| [x[i] - p[0], y[i] - p[1], z[i] - p[2]];
        let mut nearest = place(0);
        let mut simplex = Simplex { points: [nearest; 4], count: 1 };
        let mut found = Bounds { lower: 0.0, upper: f64::INFINITY, plane: Plane::default() };
        for _ in 0..SEARCH_STEPS {
            let length = dot(&nearest, &nearest).sqrt();
            found.upper = found.upper.min(length);
            if found.upper < until.little || found.upper <= until.tolerance {
                break;
            }
            let mut heights = [0.0; 6];
            for i in 0..6 {
                heights[i] = x[i] * nearest[0] + y[i] * nearest[1] + z[i] * nearest[2];
            }
            let lowest = (1..6).fold(0, |best, i| if heights[i] < heights[best] { i } else { best });
            let support = place(lowest);
            let height = dot(&support, &nearest) / length;
            if height > found.lower {
                found.lower = height;
                let normal = scaled(&nearest, 1.0 / length);
                found.plane = Plane { normal, offset: height + dot(p, &normal) };
            }
            if found.lower >= until.enough || found.upper - found.lower <= until.tolerance || simplex.has(&support) {
                break;
            }
            simplex.points[simplex.count] = support;
            simplex.count += 1;
            match simplex.reduce() {
                Some(v) => nearest = v,
                None => return Bounds { lower: 0.0, upper: 0.0, plane: Plane::default() },
            }
        }
        found
    }
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
        let [a, b, c, d] = &self.points;
        let Nearest { kept, point } = match self.count {
            2 => nearest_on_segment(a, b, [0, 1]),
            3 => nearest_on_triangle(a, b, c, [0, 1, 2]),
            _ => {
                let mut best: Option<(f64, Nearest)> = None;
                for (numbers, apex) in [([0, 1, 2], d), ([0, 2, 3], b), ([0, 1, 3], c), ([1, 2, 3], a)] {
                    let [x, y, z] = numbers.map(|i: u8| &self.points[i as usize]);
                    let normal = cross(&sub(y, x), &sub(z, x));
                    // On the side of the face that the fourth corner is on.
                    if -dot(x, &normal) * dot(&sub(apex, x), &normal) > 0.0 {
                        continue;
                    }
                    let found = nearest_on_triangle(x, y, z, numbers);
                    let square = dot(&found.point, &found.point);
                    if best.as_ref().is_none_or(|(least, _)| square < *least) {
                        best = Some((square, found));
                    }
                }
                best?.1
            }
        };
        let mut count = 0;
        for i in 0..self.count {
            if kept >> i & 1 == 1 {
                self.points[count] = self.points[i];
                count += 1;
            }
        }
        self.count = count;
        Some(point)
    }
}

/// The nearest point to the origin, and the numbers of the corners that it is between, as bits.
struct Nearest {
    kept: u8,
    point: Point,
}

#[inline(always)]
fn corner(a: &Point, number: u8) -> Nearest {
    Nearest { kept: 1 << number, point: *a }
}

#[inline(always)]
fn nearest_on_segment(a: &Point, b: &Point, [i, j]: [u8; 2]) -> Nearest {
    let side = sub(b, a);
    let (t, whole) = (-dot(a, &side), dot(&side, &side));
    if t <= 0.0 || whole == 0.0 {
        corner(a, i)
    } else if t >= whole {
        corner(b, j)
    } else {
        Nearest { kept: 1 << i | 1 << j, point: along(a, t / whole, &side) }
    }
}

/// By the regions of C. Ericson (Real-Time Collision Detection, 2005, section 5.1.5).
#[inline(always)]
fn nearest_on_triangle(a: &Point, b: &Point, c: &Point, [i, j, k]: [u8; 3]) -> Nearest {
    let (ab, ac) = (sub(b, a), sub(c, a));
    let (d1, d2) = (-dot(&ab, a), -dot(&ac, a));
    if d1 <= 0.0 && d2 <= 0.0 {
        return corner(a, i);
    }
    let (d3, d4) = (-dot(&ab, b), -dot(&ac, b));
    if d3 >= 0.0 && d4 <= d3 {
        return corner(b, j);
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return nearest_on_segment(a, b, [i, j]);
    }
    let (d5, d6) = (-dot(&ab, c), -dot(&ac, c));
    if d6 >= 0.0 && d5 <= d6 {
        return corner(c, k);
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return nearest_on_segment(a, c, [i, k]);
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        return nearest_on_segment(b, c, [j, k]);
    }
    let sum = va + vb + vc;
    if sum <= 0.0 {
        return nearest_on_segment(a, b, [i, j]);
    }
    Nearest { kept: 1 << i | 1 << j | 1 << k, point: along(&along(a, vb / sum, &ab), vc / sum, &ac) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use feeler_core::geometry::vectors::add;
    use feeler_shapes::random::Random;

    /// By trial: the hull's points are weighted means of its corners, and the weights of the nearest are found by going to corners
    /// with ever smaller steps (M. Frank and P. Wolfe 1956).
    fn by_trial(p: &Point, corners: &Corners) -> f64 {
        let points = corners.map(|q| sub(&q, p));
        let mut x = points[0];
        for _ in 0..20_000 {
            let q = points.iter().min_by(|a, b| dot(a, &x).total_cmp(&dot(b, &x))).unwrap();
            x = nearest_on_segment(&x, q, [0, 1]).point;
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
                5 => {
                    corners =
                        std::array::from_fn(
                            |i| if i < 3 { corners[i] } else { add(&corners[i - 3], &[30.0, 1.0, 0.0]) },
                        )
                }
                _ => {}
            }
            let p = random.point(-2.0, 2.0);
            let (truth, slack) = (by_trial(&p, &corners), 2e-3);
            let hull = Hull::new(&corners);
            let lower =
                |enough: f64, tolerance: f64| hull.distance(&p, &Until { enough, little: 0.0, tolerance }).lower;
            let found = lower(f64::INFINITY, 1e-9);
            assert!((found - truth).abs() < slack, "case {case}: {found} {truth}");
            let coarse = lower(f64::INFINITY, 0.1);
            assert!(coarse <= found + 1e-9 && coarse >= found - 0.1 - 1e-9, "case {case}: {coarse} {found}");
            let stopped = lower(0.3, 1e-9);
            assert!(stopped <= found + 1e-9 && stopped >= found.min(0.3) - 1e-9);
            assert!(!hull.is_within(&p, found - 0.01));
            assert!(hull.is_within(&p, found + 0.01));
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
            let hull = Hull::new(&corners);
            let until = Until { enough: f64::INFINITY, little: 0.0, tolerance: 1e-6 };
            assert!(hull.distance(&p, &until).lower <= 1e-12);
            assert!(hull.is_within(&p, 1e-6));
        }
    }
}
