//! The distance of two triangles, with the points where they are closest.
//!
//! Two triangles that do not meet are closest at an edge of each, or at a corner of one and a point inside the other: nine pairs
//! of edges and six of corner and face. Formulas after C. Ericson, *Real-Time Collision Detection* (2005), section 5.1, with
//! these deviations. Every candidate is a pair of points made on the triangles, so none can claim less than the distance. Corners
//! are tried against edges on their own, so nothing hangs on edges that are nearly parallel; for the inside of two edges, parameters
//! come from cross products, whose error grows with the inverse of the angle only as fast as its effect shrinks; and the foot on
//! a face is corrected until slivers have it too. Whether the triangles meet is left to exact signs.

use crate::constants::{
    CLOSE_ENOUGH, DISTANCE_ROUNDOFFS, LEAST_GAP, LEAST_SQUARE, MEASURABLE, NARROW, OUTSIDE, ROOT_ROUNDING, SMALLEST,
    UNIT_ROUNDOFF,
};
use crate::geometry::bounds::{Aabb, Point, Triangle};
use crate::geometry::intersect_triangle_triangle::intersect_triangle_triangle;
use crate::geometry::vectors::{along, cross, dot, sub};

/// Where two triangles are closest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Closest {
    /// Metres; 0 if and only if the triangles collide.
    pub distance: f64,
    /// The point on the first triangle, metres.
    pub on_p: Point,
    /// The point on the second; the same point if they collide.
    pub on_q: Point,
}

/// The closest points of two triangles. Corners must be finite, and at most 1e100 in size (a few times that at a pose).
///
/// With L the largest difference of two of the corners' coordinates along one axis, the error of the distance is at
/// most 1.4e-14 L, and so is each point's distance from its triangle, beside rounding its coordinates to float64; if
/// they collide, the common point is within 1e-9 L of both. The distance is 0 if and only if the triangles collide,
/// which is decided exactly. One of the two may be degenerate (a segment, a point), as a tool's triangle can be at a
/// pose.
///
/// ```
/// use feeler_core::closest_triangle_triangle;
///
/// let p = [[0.0, 0.0, 0.5], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]];
/// let q = [[-1.0, -1.0, 0.0], [2.0, -1.0, 0.0], [-1.0, 2.0, 0.0]];
/// let closest = closest_triangle_triangle(&p, &q);
/// assert_eq!((closest.distance, closest.on_q), (0.5, [0.0, 0.0, 0.0]));
/// ```
pub fn closest_triangle_triangle(p: &Triangle, q: &Triangle) -> Closest {
    closest_within(p, q, f64::INFINITY).unwrap_or(Closest { distance: f64::INFINITY, on_p: p[0], on_q: q[0] })
}

/// The same where the distance is at most `within` (metres), else `None`; much quicker for triangles that are farther apart.
pub fn closest_within(p: &Triangle, q: &Triangle, within: f64) -> Option<Closest> {
    // Most pairs end here, before anything is divided.
    let placed = Placed::new(p, q);
    let limit = within * placed.per_metre + DISTANCE_ROUNDOFFS * UNIT_ROUNDOFF;
    let (b, c) = (Aabb::of_triangle(&placed.p), Aabb::of_triangle(&placed.q));
    if distance_bound(&b, &c) > limit {
        return None;
    }
    let pair = Pair {
        p: Side::new(placed.p),
        q: Side::new(placed.q),
        origin: p[0],
        per_metre: placed.per_metre,
        size: placed.size,
    };
    if pair.is_beyond(limit) {
        return None;
    }
    let mut best = Best { squared: f64::INFINITY, on_p: pair.p.corners[0], on_q: pair.q.corners[0] };
    pair.try_corners_and_edges(&mut best);
    pair.try_edges(&mut best);
    pair.try_faces(&mut best);
    if !pair.is_held_apart_along(&sub(&best.on_q, &best.on_p)) && intersect_triangle_triangle(p, q).is_some() {
        pair.try_piercing(&mut best);
        let at = std::array::from_fn(|a| 0.5 * (best.on_p[a] + best.on_q[a]));
        let at = pair.to_metres(&at);
        return Some(Closest { distance: 0.0, on_p: at, on_q: at });
    }
    // Apart, however little of it float64 can tell.
    let distance = (best.squared.sqrt() / pair.per_metre).max(SMALLEST);
    if distance > within {
        return None;
    }
    Some(Closest { distance, on_p: pair.to_metres(&best.on_p), on_q: pair.to_metres(&best.on_q) })
}

/// A bound from below on the distance of two triangles (metres), from their boxes: no more than a dozen operations, and never
/// above what [`closest_triangle_triangle`] gives.
#[inline]
pub(crate) fn distance_bound(p: &Aabb, q: &Aabb) -> f64 {
    let mut squared = 0.0;
    for a in 0..3 {
        // Each difference is rounded once, and so are its operands: leave a little.
        let gap = (q.lower[a] - p.upper[a]).max(p.lower[a] - q.upper[a]).max(0.0);
        squared += gap * gap;
    }
    // Squares of the smallest and largest gaps leave the range; then the largest of the three is a bound.
    if MEASURABLE.contains(&squared) {
        return squared.sqrt() * (1.0 - ROOT_ROUNDING);
    }
    (0..3).map(|a| (q.lower[a] - p.upper[a]).max(p.lower[a] - q.upper[a])).fold(0.0, f64::max) * (1.0 - ROOT_ROUNDING)
}

struct Best {
    squared: f64,
    on_p: Point,
    on_q: Point,
}

impl Best {
    #[inline(always)]
    fn offer(&mut self, on_p: &Point, on_q: &Point) {
        let d = sub(on_q, on_p);
        let squared = dot(&d, &d);
        if squared < self.squared {
            *self = Best { squared, on_p: *on_p, on_q: *on_q };
        }
    }
}

/// A triangle in units of the pair.
struct Side {
    corners: Triangle,
    /// Edge `i` from corner `i` to the next.
    edges: Triangle,
    /// One over the squared length of each edge; 0 where that is 0.
    inverse: [f64; 3],
    normal: Point,
}

impl Side {
    #[inline(always)]
    fn new(corners: Triangle) -> Side {
        let edges = [sub(&corners[1], &corners[0]), sub(&corners[2], &corners[1]), sub(&corners[0], &corners[2])];
        let inverse = [
            inverse_of(dot(&edges[0], &edges[0])),
            inverse_of(dot(&edges[1], &edges[1])),
            inverse_of(dot(&edges[2], &edges[2])),
        ];
        let normal = cross(&edges[0], &edges[1]);
        Side { corners, edges, inverse, normal }
    }

    /// The point of edge `i` closest to a point.
    #[inline(always)]
    fn on_edge(&self, i: usize, point: &Point) -> Point {
        let t = dot(&sub(point, &self.corners[i]), &self.edges[i]) * self.inverse[i];
        along(&self.corners[i], t.clamp(0.0, 1.0), &self.edges[i])
    }

    /// The foot of a point on the face, where it lies inside.
    #[inline(always)]
    fn on_face(&self, point: &Point) -> Option<Point> {
        let n = &self.normal;
        let nn = dot(n, n);
        let inverse = inverse_of(nn);
        if inverse == 0.0 {
            return None;
        }
        let [a, _, _] = &self.corners;
        let (u, v) = (self.edges[0], [-self.edges[2][0], -self.edges[2][1], -self.edges[2][2]]);
        let is_sliver = nn * self.inverse[0] * self.inverse[2] < NARROW;
        // Weights of u and v, corrected by the rest between point and foot until the slimmest slivers have it right.
        let (mut s, mut t) = (0.0, 0.0);
        let mut foot = *a;
        for step in 0..4 {
            let left = sub(point, &foot);
            s += dot(&cross(&left, &v), n) * inverse;
            t += dot(&cross(&u, &left), n) * inverse;
            if !is_sliver {
                if step == 0 && (s < -OUTSIDE || t < -OUTSIDE || s + t > 1.0 + OUTSIDE) {
                    return None;
                }
                if step == 1 {
                    break;
                }
            }
            foot = along(&along(a, s, &u), t, &v);
        }
        (s >= 0.0 && t >= 0.0 && s + t <= 1.0).then(|| along(&along(a, s, &u), t, &v))
    }
}

/// Two triangles, moved and scaled (by a power of two) so that all coordinates are at most 2 in size.
struct Pair {
    p: Side,
    q: Side,
    origin: Point,
    per_metre: f64,
    size: f64,
}

impl Side {
    /// The closest point of the triangle.
    fn closest_to(&self, point: &Point) -> Point {
        self.on_face(point).unwrap_or_else(|| {
            let feet = [self.on_edge(0, point), self.on_edge(1, point), self.on_edge(2, point)];
            let squared = feet.map(|foot| dot(&sub(point, &foot), &sub(point, &foot)));
            let nearer = usize::from(squared[1] < squared[0]);
            feet[if squared[2] < squared[nearer] { 2 } else { nearer }]
        })
    }
}

/// Corners in units of the pair.
struct Placed {
    p: Triangle,
    q: Triangle,
    per_metre: f64,
    /// The largest coordinate: from 1 to 2, or less for numbers next to 0.
    size: f64,
}

impl Placed {
    #[inline(always)]
    fn new(p: &Triangle, q: &Triangle) -> Placed {
        let origin = p[0];
        let mut largest = 0.0f64;
        for corner in [&p[1], &p[2], &q[0], &q[1], &q[2]] {
            for a in 0..3 {
                largest = largest.max((corner[a] - origin[a]).abs());
            }
        }
        let per_metre = power_of_two_below_inverse(largest);
        let moved = |corner: &Point| -> Point { std::array::from_fn(|a| (corner[a] - origin[a]) * per_metre) };
        let [a, b, c] = p;
        let [d, e, f] = q;
        Placed {
            p: [moved(a), moved(b), moved(c)],
            q: [moved(d), moved(e), moved(f)],
            per_metre,
            size: largest * per_metre,
        }
    }
}

impl Pair {
    fn to_metres(&self, point: &Point) -> Point {
        std::array::from_fn(|a| point[a] / self.per_metre + self.origin[a])
    }

    /// Whether the plane of either certainly holds the triangles farther apart than a limit.
    #[inline(always)]
    fn is_beyond(&self, limit: f64) -> bool {
        for n in [&self.p.normal, &self.q.normal] {
            let (gap, error) = self.gap_along(n);
            let nn = dot(n, n);
            // The square of a triangle that is a speck beside the pair vanishes.
            if nn > LEAST_SQUARE && gap - error > limit * nn.sqrt() * (1.0 + ROOT_ROUNDING) {
                return true;
            }
        }
        false
    }

    /// The gap between the triangles' intervals along an axis of any length, and its error.
    #[inline(always)]
    fn gap_along(&self, axis: &Point) -> (f64, f64) {
        let of = |t: &Triangle| {
            let d = [dot(axis, &t[0]), dot(axis, &t[1]), dot(axis, &t[2])];
            (d[0].min(d[1]).min(d[2]), d[0].max(d[1]).max(d[2]))
        };
        let ((p0, p1), (q0, q1)) = (of(&self.p.corners), of(&self.q.corners));
        // Coordinates are at most 2 and off by one rounding; a product and two sums for each end.
        let error = 32.0 * UNIT_ROUNDOFF * (axis[0].abs() + axis[1].abs() + axis[2].abs());
        ((q0 - p1).max(p0 - q1), error)
    }

    fn is_held_apart_along(&self, axis: &Point) -> bool {
        let (gap, error) = self.gap_along(axis);
        // Products that underflow are no proof.
        gap > error + LEAST_GAP
    }

    #[inline(always)]
    fn try_corners_and_edges(&self, best: &mut Best) {
        for i in 0..3 {
            for j in 0..3 {
                best.offer(&self.p.corners[j], &self.q.on_edge(i, &self.p.corners[j]));
                best.offer(&self.p.on_edge(i, &self.q.corners[j]), &self.q.corners[j]);
            }
        }
    }

    /// The inside of edges; their ends are done by [`try_corners_and_edges`](Self::try_corners_and_edges).
    #[inline(always)]
    fn try_edges(&self, best: &mut Best) {
        for i in 0..3 {
            for j in 0..3 {
                let (a, u) = (&self.p.corners[i], &self.p.edges[i]);
                let (b, v) = (&self.q.corners[j], &self.q.edges[j]);
                let n = cross(u, v);
                let nn = dot(&n, &n);
                let inverse = inverse_of(nn);
                if inverse == 0.0 {
                    continue;
                }
                let r = sub(b, a);
                let rn = cross(&r, &n);
                // det(r, v, n) = -(r x n) . v
                let s = -dot(&rn, v) * inverse;
                let t = -dot(&rn, u) * inverse;
                let is_narrow = nn * self.p.inverse[i] * self.q.inverse[j] < NARROW;
                let inside = -OUTSIDE..=1.0 + OUTSIDE;
                if !(is_narrow || inside.contains(&s) && inside.contains(&t)) {
                    continue;
                }
                let on_p = along(a, s.clamp(0.0, 1.0), u);
                let on_q = self.q.on_edge(j, &on_p);
                best.offer(&self.p.on_edge(i, &on_q), &on_q);
            }
        }
    }

    #[inline(always)]
    fn try_faces(&self, best: &mut Best) {
        for corner in &self.p.corners {
            if let Some(foot) = self.q.on_face(corner) {
                best.offer(corner, &foot);
            }
        }
        for corner in &self.q.corners {
            if let Some(foot) = self.p.on_face(corner) {
                best.offer(&foot, corner);
            }
        }
    }

    /// Where edges of the one go through the other.
    fn try_piercing(&self, best: &mut Best) {
        for (line, face, is_p) in [(&self.p, &self.q, true), (&self.q, &self.p, false)] {
            let heights = line.corners.map(|c| dot(&face.normal, &sub(&c, &face.corners[0])));
            for i in 0..3 {
                let (from, to) = (heights[i], heights[(i + 1) % 3]);
                if (from > 0.0) == (to > 0.0) || from == to {
                    continue;
                }
                let slope = to - from;
                let mut t = -from / slope;
                // The plane of a sliver is not known well: go on from the point found on it.
                for _ in 0..16 {
                    let at = along(&line.corners[i], t.clamp(0.0, 1.0), &line.edges[i]);
                    let foot = face.closest_to(&at);
                    if is_p {
                        best.offer(&at, &foot);
                    } else {
                        best.offer(&foot, &at);
                    }
                    if best.squared <= CLOSE_ENOUGH * self.size * self.size {
                        return;
                    }
                    t = t.clamp(0.0, 1.0) + dot(&face.normal, &sub(&foot, &at)) / slope;
                }
            }
        }
    }
}

/// The largest power of two not above `1 / x` or a little less; 1 for 0.
fn power_of_two_below_inverse(x: f64) -> f64 {
    let exponent = ((x.to_bits() >> 52) & 0x7ff) as i64 - 1023;
    if x == 0.0 {
        return 1.0;
    }
    // Powers of two from 2^-1000 to 2^1000 are normal numbers, and so are their inverses.
    f64::from_bits(((1023 - exponent.clamp(-1000, 1000)) as u64) << 52)
}

#[inline(always)]
fn inverse_of(x: f64) -> f64 {
    if x > LEAST_SQUARE {
        1.0 / x
    } else {
        0.0
    }
}
