//! A convex polygon in a triangle of the one surface, and where the other surface parts it.

use feeler_core::geometry::vectors::{cross, dot, length, normal, sub, unit};
use feeler_core::{Aabb, Point, Triangle};

use super::body::Body;

/// A plane to cut at: `dot(normal, p) = offset`.
#[derive(Debug, Clone, Copy)]
pub struct Plane {
    /// Of length 1.
    normal: Point,
    offset: f64,
    /// A triangle of the other body that is near where it cuts, if any is known.
    near: Option<u32>,
}

impl Plane {
    /// Through a point.
    pub fn through(p: &Point, normal: &Point) -> Option<Plane> {
        let normal = unit(normal)?;
        Some(Plane { normal, offset: dot(&normal, p), near: None })
    }

    /// Of a unit normal.
    pub fn at(normal: Point, offset: f64) -> Plane {
        Plane { normal, offset, near: None }
    }

    /// The same, near a triangle of the other body.
    pub fn near(self, triangle: u32) -> Plane {
        Plane { near: Some(triangle), ..self }
    }

    /// A triangle of the other body that is near where it cuts.
    pub fn nearest(&self) -> Option<u32> {
        self.near
    }

    /// How far a point is on the positive side.
    pub fn height(&self, p: &Point) -> f64 {
        dot(&self.normal, p) - self.offset
    }
}

/// See the module.
#[derive(Debug, Clone)]
pub struct Outline {
    pub points: Vec<Point>,
    /// The normal of its triangle; zero where it has none.
    pub normal: Point,
}

impl Outline {
    /// The triangle as far as it is in a box; `None` where nothing is left.
    pub fn clipped(t: &Triangle, bounds: Option<&Aabb>) -> Option<Outline> {
        let mut points: Vec<Point> = t.to_vec();
        if let Some(bounds) = bounds {
            for axis in 0..3 {
                for (sense, side) in [(1.0, bounds.lower[axis]), (-1.0, bounds.upper[axis])] {
                    if points.iter().any(|p| sense * (p[axis] - side) < 0.0) {
                        points = half_of(&points, |p| sense * (p[axis] - side));
                    }
                    if points.is_empty() {
                        return None;
                    }
                }
            }
        }
        Some(Outline { points, normal: normal(t).unwrap_or_default() })
    }

    /// Whether its corners are on both sides of a plane, farther than `least`.
    fn is_split(&self, plane: &Plane, least: f64) -> bool {
        let (mut below, mut above) = (false, false);
        for p in &self.points {
            let height = plane.height(p);
            below |= height < -least;
            above |= height > least;
        }
        below && above
    }

    /// Where the other surface parts it: a plane across it along the line where a triangle of the other body goes through it, or, of one
    /// that lies in it, along a side. Lines no longer than `least`, and those within that of its border, do not count.
    pub fn parting(&self, body: &Body, least: f64) -> Option<Plane> {
        let mut around = self.points.iter().fold(Aabb::EMPTY, |mut around, p| {
            around.grow(p);
            around
        });
        for a in 0..3 {
            around.lower[a] -= least;
            around.upper[a] += least;
        }
        body.find_overlapping(&around, |i| self.parting_by(body.triangle(i), least).map(|plane| plane.near(i)))
    }

    fn parting_by(&self, t: &Triangle, least: f64) -> Option<Plane> {
        let n = &self.normal;
        let origin = &self.points[0];
        let height = |p: &Point| dot(n, &sub(p, origin));
        let heights = [height(&t[0]), height(&t[1]), height(&t[2])];
        let is_on_one_side =
            |sense: f64| sense * heights[0] > least && sense * heights[1] > least && sense * heights[2] > least;
        if is_on_one_side(1.0) || is_on_one_side(-1.0) {
            return None;
        }
        let side = |h: f64| if h > least { 1 } else { i32::from(h >= -least) - 1 };
        let sides = [side(heights[0]), side(heights[1]), side(heights[2])];
        let across = |p: &Point, q: &Point| -> Option<Plane> {
            let along = sub(q, p);
            let plane = Plane::through(p, &cross(n, &along))?;
            (self.is_split(&plane, least) && self.covered(p, &along) > least).then_some(plane)
        };
        let on: Vec<usize> = (0..3).filter(|i| sides[*i] == 0).collect();
        match on.len() {
            3 => (0..3).find_map(|i| across(&t[i], &t[(i + 1) % 3])),
            2 => across(&t[on[0]], &t[on[1]]),
            _ => {
                let mut ends: Vec<Point> = on.iter().map(|i| t[*i]).collect();
                for i in 0..3 {
                    let j = (i + 1) % 3;
                    if sides[i] * sides[j] < 0 {
                        let s = heights[i] / (heights[i] - heights[j]);
                        ends.push(between(&t[i], &t[j], s));
                    }
                }
                if ends.len() < 2 {
                    return None;
                }
                across(&ends[0], &ends[1])
            }
        }
    }

    /// How much of a segment in its plane it covers, metres.
    fn covered(&self, from: &Point, along: &Point) -> f64 {
        let (mut low, mut high) = (0.0f64, 1.0f64);
        let count = self.points.len();
        for i in 0..count {
            let (p, q) = (&self.points[i], &self.points[(i + 1) % count]);
            let inward = cross(&self.normal, &sub(q, p));
            let (start, slope) = (dot(&inward, &sub(from, p)), dot(&inward, along));
            if slope == 0.0 {
                if start < 0.0 {
                    return 0.0;
                }
                continue;
            }
            let at = -start / slope;
            if slope > 0.0 {
                low = low.max(at);
            } else {
                high = high.min(at);
            }
        }
        (high - low).max(0.0) * length(along)
    }
}

/// The part of a convex polygon where a height is not negative.
fn half_of(polygon: &[Point], height: impl Fn(&Point) -> f64) -> Vec<Point> {
    let mut half = Vec::with_capacity(polygon.len() + 1);
    for (i, p) in polygon.iter().enumerate() {
        let q = &polygon[(i + 1) % polygon.len()];
        let (h, k) = (height(p), height(q));
        if h >= 0.0 {
            half.push(*p);
        }
        if h * k < 0.0 {
            let s = h / (h - k);
            half.push(between(p, q, s));
        }
    }
    half
}

/// The sides of a polygon that a plane crosses: from which corner to which, and at which share of it.
pub fn crossings(heights: &[f64]) -> impl Iterator<Item = (usize, usize, f64)> + '_ {
    let count = heights.len();
    (0..count).filter_map(move |i| {
        let j = (i + 1) % count;
        let (h, k) = (heights[i], heights[j]);
        (h * k < 0.0).then(|| (i, j, h / (h - k)))
    })
}

pub fn between(p: &Point, q: &Point, share: f64) -> Point {
    std::array::from_fn(|a| p[a] + share * (q[a] - p[a]))
}
