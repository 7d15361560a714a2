//! Whether a convex set of points is off a surface as a whole. If it is, and on the other side of the surface than it was before it was
//! moved, none of its points was farther from the surface than it was moved: its way has met the surface.

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
