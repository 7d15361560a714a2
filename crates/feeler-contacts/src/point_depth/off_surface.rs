//! Whether a convex set of points is off a surface as a whole. If it is, and if it was on the other side before it was
//! moved, the motion crossed the surface, so none of its points was farther from the surface than the length of the
//! motion.

use feeler_core::geometry::vectors::{cross, dot, sub};
use feeler_core::{Aabb, Point, Triangle};

use super::body::Body;

/// The hull of some points: a polygon in a plane with a normal, or a body, whose normal is zero.
#[derive(Debug, Clone, Copy)]
pub struct Hull<'a> {
    pub points: &'a [Point],
    pub normal: Point,
}

impl Hull<'_> {
    /// Whether all of it is farther than `least` from all triangles of a body. False where that is not easily seen.
    pub fn is_off(&self, body: &Body, least: f64) -> bool {
        let around = self.bounds(least);
        let is_near = |i: u32| (!self.is_apart(body.triangle(i), body.plane(i), &around, least)).then_some(());
        body.find_overlapping(&around, is_near).is_none()
    }

    /// The same for one of its triangles.
    pub fn is_off_triangle(&self, body: &Body, i: u32, least: f64) -> bool {
        self.is_apart(body.triangle(i), body.plane(i), &self.bounds(least), least)
    }

    fn bounds(&self, margin: f64) -> Aabb {
        let mut around = Aabb::EMPTY;
        self.points.iter().for_each(|p| around.grow(p));
        for a in 0..3 {
            around.lower[a] -= margin;
            around.upper[a] += margin;
        }
        around
    }

    /// Whether an axis shows that a triangle is farther than `least`.
    fn is_apart(&self, t: &Triangle, [x, y, z, offset]: &[f64; 4], around: &Aabb, least: f64) -> bool {
        if (0..3).any(|a| {
            t[0][a].min(t[1][a]).min(t[2][a]) > around.upper[a] || t[0][a].max(t[1][a]).max(t[2][a]) < around.lower[a]
        }) {
            return true;
        }
        let n = [*x, *y, *z];
        if is_on_one_side(self.points, |p| dot(&n, p) - offset, least) {
            return true;
        }
        if is_beyond_a_side(t, &n, self.points, least) {
            return true;
        }
        if self.normal == [0.0; 3] {
            return false;
        }
        let origin = &self.points[0];
        is_on_one_side(t, |p| dot(&self.normal, &sub(p, origin)), least)
            || is_beyond_a_side(self.points, &self.normal, t, least)
    }
}

fn is_on_one_side(points: &[Point], height: impl Fn(&Point) -> f64, least: f64) -> bool {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for p in points {
        let h = height(p);
        (low, high) = (low.min(h), high.max(h));
    }
    low > least || high < -least
}

/// Whether all points are beyond one side of a polygon.
fn is_beyond_a_side(polygon: &[Point], normal: &Point, points: &[Point], least: f64) -> bool {
    (0..polygon.len()).any(|i| {
        let (p, q) = (&polygon[i], &polygon[(i + 1) % polygon.len()]);
        let outward = cross(&sub(q, p), normal);
        let (square, slack) = (dot(&outward, &outward), least * least);
        points.iter().all(|r| {
            let height = dot(&outward, &sub(r, p));
            height > 0.0 && height * height > slack * square
        })
    })
}

#[cfg(test)]
mod tests {
    use super::super::brute::{body, distance, point_of, triangle};
    use super::super::outline::{Outline, Plane};
    use super::*;
    use feeler_core::geometry::vectors::{add, along, normal, scaled};
    use feeler_shapes::random::Random;
    use feeler_shapes::soups::arrays_of;

    fn turn(m: &[[f64; 4]; 4], p: &Point) -> Point {
        std::array::from_fn(|a| m[a][0] * p[0] + m[a][1] * p[1] + m[a][2] * p[2])
    }

    #[test]
    fn what_is_said_to_be_off_is_farther() {
        let mut r = Random::new(1);
        let mut counts = [0; 2];
        for n in 0..3000 {
            let count = 1 + r.below(12) as usize;
            let body = body(arrays_of((0..count).map(|_| triangle(&mut r, 0.4)).collect::<Vec<_>>()));
            let (size, least) = (r.real(0.01, 0.6), [0.0, 1e-9, 0.05][n % 3]);
            let t = triangle(&mut r, size).map(|p| sub(&p, body.origin()));
            let mut outline = Outline::clipped(&t, 1, None).unwrap();
            if n % 2 == 0 {
                // A polygon of more corners.
                let cut = Plane::through(&outline.middle(), &r.point(-1.0, 1.0)).unwrap();
                let half = outline.cut(&cut).next();
                outline = half.unwrap();
            }
            let corners: Vec<Point> = match n % 4 {
                0 | 1 => outline.points,
                _ => (0..8)
                    .map(|i| std::array::from_fn(|a| t[0][a] + if i >> a & 1 == 1 { size } else { 0.0 }))
                    .collect(),
            };
            let normal = if n % 4 < 2 { outline.normal } else { [0.0; 3] };
            let hull = Hull { points: &corners, normal };
            let is_off = hull.is_off(&body, least);
            let all = (0..body.len() as u32).all(|i| hull.is_off_triangle(&body, i, least));
            assert_eq!(is_off, all);
            counts[usize::from(is_off)] += 1;
            if is_off {
                for _ in 0..40 {
                    let p = point_of(&mut r, &corners);
                    assert!(distance(&body, &p) > least - 1e-12, "{corners:?} {p:?}");
                }
            }
        }
        assert!(counts.iter().all(|n| *n > 500), "{counts:?}");
    }

    #[test]
    fn each_way_of_being_off_is_seen_from_the_margin_on_and_not_before() {
        let mut r = Random::new(2);
        let flat = [[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [0.0, 2.0, 0.0]];
        let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let least = 0.25;
        for n in 0..300 {
            let m = r.motion(2.0);
            let place = |p: &Point| turn(&m, p);
            for share in [0.9, 1.1] {
                let off = share * least;
                // A triangle in a plane, a polygon upright above it, one upright beyond each of its sides, and triangles that point at
                // these with a corner, so that nothing of their own tells; and the two exchanged.
                let mut ways: Vec<Vec<Point>> = Vec::new();
                ways.push(square.iter().map(|[u, v]| [0.4 + 0.3 * u, 0.4, off + v]).collect());
                ways.push(square.iter().map(|[u, v]| [0.4 + 0.3 * u, 0.4, -off - v]).collect());
                for i in 0..3 {
                    let (p, q) = (flat[i], flat[(i + 1) % 3]);
                    let side = sub(&q, &p);
                    let out = cross(&side, &[0.0, 0.0, 1.0]);
                    let out = scaled(&out, 1.0 / dot(&out, &out).sqrt());
                    // Across the plane, so that no plane of the two tells.
                    let at = |[u, v]: &[f64; 2]| {
                        let p = along(&along(&p, 0.3 + 0.3 * u, &side), off, &out);
                        add(&p, &[0.0, 0.0, v - 0.4])
                    };
                    ways.push(square.iter().map(at).collect());
                    let tip = along(&along(&p, 0.45, &side), off, &out);
                    let end = |z: f64| add(&along(&tip, 1.0, &out), &[0.0, 0.0, z]);
                    ways.push(vec![tip, end(0.5), end(-0.4)]);
                }
                ways.push(vec![[0.7, 0.5, off], [0.2, 0.5, off + 1.0], [1.3, 0.5, off + 1.0]]);
                ways.push(vec![[0.7, 0.5, -off], [1.3, 0.5, -off - 1.0], [0.2, 0.5, -off - 1.0]]);
                for (way, points) in ways.iter().enumerate() {
                    let polygon: Vec<Point> = points.iter().map(place).collect();
                    let across = normal(&[polygon[0], polygon[1], polygon[2]]).unwrap();
                    let t = flat.map(|p| place(&p));
                    let said = |t: &Triangle, points: &[Point], normal: Point| {
                        let body = body(arrays_of([*t]));
                        let points: Vec<Point> = points.iter().map(|p| sub(p, body.origin())).collect();
                        Hull { points: &points, normal }.is_off(&body, least)
                    };
                    assert_eq!(said(&t, &polygon, across), share > 1.0, "{n} {way} {share}");
                    // The triangle's own normal and sides tell, so a body without a normal is seen too.
                    assert_eq!(said(&t, &polygon, [0.0; 3]), share > 1.0, "{n} {way} {share}");
                    // A triangle of the polygon against the other as a polygon.
                    let other = [polygon[0], polygon[1], polygon[2]];
                    assert_eq!(said(&other, &t, normal(&t).unwrap()), share > 1.0, "{n} {way} {share}");
                }
            }
        }
    }

    #[test]
    fn boxes_that_are_apart_along_an_axis_are_off() {
        // What has no area has no plane.
        let line = [[0.0, 0.0, 0.0], [1.0, 1.0, 1.0], [0.5, 0.5, 0.5]];
        for a in 0..3 {
            for (sense, share) in [(1.0, 1.1), (1.0, 0.9), (-1.0, 1.1), (-1.0, 0.9)] {
                let mut points = [[0.5; 3], [0.6, 0.5, 0.5], [0.5, 0.6, 0.5]];
                points.iter_mut().for_each(|p| p[a] = if sense > 0.0 { 1.0 + share * 0.25 } else { -share * 0.25 });
                let hull = Hull { points: &points, normal: [0.0; 3] };
                let is_apart = hull.is_apart(&line, &[0.0; 4], &hull.bounds(0.25), 0.25);
                assert_eq!(is_apart, share > 1.0, "{a} {sense} {share}");
            }
        }
    }
}
