//! A convex polygon in a triangle of the one surface, and where the other surface parts it.

use feeler_core::geometry::vectors::{add, cross, dot, length, normal, scaled, sub, unit};
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
    /// 1 where that leads out of its body, -1 where it leads in; 0 where the surface is open.
    pub sense: i8,
}

impl Outline {
    /// The triangle as far as it is in a box; `None` where nothing is left.
    pub fn clipped(t: &Triangle, sense: i8, bounds: Option<&Aabb>) -> Option<Outline> {
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
        Some(Outline { points, normal: normal(t).unwrap_or_default(), sense })
    }

    /// The middle of its corners.
    pub fn middle(&self) -> Point {
        let sum = self.points.iter().fold([0.0; 3], |sum, p| add(&sum, p));
        scaled(&sum, 1.0 / self.points.len() as f64)
    }

    /// How far its corners are from a point, at most.
    pub fn radius(&self, from: &Point) -> f64 {
        self.points.iter().map(|p| length(&sub(p, from))).fold(0.0, f64::max)
    }

    /// The parts on each side of a plane. A part that is nothing but a line is left out.
    pub fn cut(&self, plane: &Plane) -> impl Iterator<Item = Outline> + '_ {
        let plane = *plane;
        [1.0, -1.0].into_iter().filter_map(move |sense| {
            let points = half_of(&self.points, |p| sense * plane.height(p));
            (points.len() >= 3).then_some(Outline { points, ..*self })
        })
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
        body.find_overlapping(&around, |i| {
            let [x, y, z, offset] = *body.plane(i);
            let on_side =
                |sense: f64| self.points.iter().all(|p| sense * (x * p[0] + y * p[1] + z * p[2] - offset) > least);
            // Mostly it is on one side of the triangle's plane.
            if on_side(1.0) || on_side(-1.0) {
                return None;
            }
            self.parting_by(body.triangle(i), least).map(|plane| plane.near(i))
        })
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
        let on: Vec<usize> = (0..3).filter(|i| sides[*i] == 0).collect();
        if on.len() == 3 || self.is_in_plane(t, 2.0 * least) {
            return (0..3).find_map(|i| self.across(&t[i], &t[(i + 1) % 3], least));
        }
        match on.len() {
            2 => self.across(&t[on[0]], &t[on[1]], least),
            _ => {
                let mut ends: Vec<Point> = on.iter().map(|i| t[*i]).collect();
                // At a grazing angle rounding moves the line by more.
                let mut margin = least;
                for i in 0..3 {
                    let j = (i + 1) % 3;
                    if sides[i] * sides[j] < 0 {
                        let rise = heights[i] - heights[j];
                        margin = margin.max(least * length(&sub(&t[j], &t[i])) / rise.abs());
                        ends.push(between(&t[i], &t[j], heights[i] / rise));
                    }
                }
                if ends.len() < 2 {
                    return None;
                }
                self.across(&ends[0], &ends[1], 4.0 * margin)
            }
        }
    }

    /// Whether all of it is in the plane of a triangle: of a large one beside a small piece corners may be aside by more.
    fn is_in_plane(&self, t: &Triangle, least: f64) -> bool {
        normal(t).is_some_and(|n| self.points.iter().all(|p| dot(&n, &sub(p, &t[0])).abs() <= least))
    }

    /// The plane across it along a segment in it, if parts on both sides of that are wider than `least`. If the segment is but a small part
    /// of the line through it, the plane across its length: what is cut along the line beyond the segment's ends is cut for nothing.
    fn across(&self, p: &Point, q: &Point, least: f64) -> Option<Plane> {
        let along = sub(q, p);
        let plane = Plane::through(p, &cross(&self.normal, &along))?;
        if !self.is_split(&plane, least) {
            return None;
        }
        let [from, to] = self.chord(p, &along);
        let covered = to.min(1.0) - from.max(0.0);
        if covered * length(&along) <= least {
            return None;
        }
        if covered < LONG_SEGMENT * (to - from) {
            return self.lengthwise();
        }
        Some(plane)
    }

    /// Between which shares of a segment in its plane its line is in the polygon.
    fn chord(&self, from: &Point, along: &Point) -> [f64; 2] {
        let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
        let count = self.points.len();
        for i in 0..count {
            let (p, q) = (&self.points[i], &self.points[(i + 1) % count]);
            let inward = cross(&self.normal, &sub(q, p));
            let (start, slope) = (dot(&inward, &sub(from, p)), dot(&inward, along));
            if slope == 0.0 {
                if start < 0.0 {
                    return [0.0; 2];
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
        [low, high.max(low)]
    }

    /// Across the longest line between two of its corners, in the middle of it.
    pub fn lengthwise(&self) -> Option<Plane> {
        let (mut most, mut ends) = (0.0, None);
        for (i, p) in self.points.iter().enumerate() {
            for q in &self.points[i + 1..] {
                let apart = sub(q, p);
                let square = dot(&apart, &apart);
                if square > most {
                    (most, ends) = (square, Some((*p, apart)));
                }
            }
        }
        let (p, apart) = ends?;
        let middle = std::array::from_fn(|a| p[a] + 0.5 * apart[a]);
        Plane::through(&middle, &apart)
    }
}

/// Share of a line through a piece from which on a segment is long.
const LONG_SEGMENT: f64 = 0.3;

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
