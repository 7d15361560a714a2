//! A moving triangle against a fixed one: when they first collide, never late.
//!
//! Conservative advancement, after B. Mirtich (1996) and X. Zhang, M. Lee and Y. Kim, *Interactive continuous collision
//! detection for non-convex polyhedra* (2006), with planes: at a time, a plane separates the two triangles. Each corner
//! of the moving one has a distance from it, a velocity along its normal and a bound on its acceleration. A quadratic
//! equation gives the time for which it stays on its side, and with all corners the whole triangle does. Then the next
//! plane follows. The bound holds for any plane: rounding can make a plane useless, never wrong.

use crate::constants::{
    HEIGHT_ROUNDOFFS, LEAST_LENGTH, MAX_STEPS, SHORTEST_STEP, STEPS_WHEN_NEAR, TIME_ROUNDING, UNIT_ROUNDOFF,
};
use crate::geometry::bounds::{Point, Triangle};
use crate::geometry::distance_triangle_triangle::closest_triangle_triangle;
use crate::geometry::pose::Pose;
use crate::geometry::vectors::{cross, dot, largest, length, scaled, sub, unit};
use crate::tool::chain::Spin;
use crate::tool::motion::{During, Limits, Motion};

/// A moving triangle, in its tool's frame, with bounds on its motion.
pub struct Moving<'a> {
    pub motion: &'a Motion,
    pub corners: Triangle,
    pub limits: Limits,
    /// Along a chain: how the tool moves at the beginning of the span, which most pairs do not get beyond.
    first_spin: Option<(f64, Spin)>,
}

impl<'a> Moving<'a> {
    /// A triangle of the tool that moves, to be followed within a span of time.
    #[inline]
    pub fn new(motion: &'a Motion, corners: Triangle, during: &During) -> Moving<'a> {
        Moving { motion, corners, limits: motion.limits(&corners, during), first_spin: during.first_spin() }
    }

    /// Velocities of three places at a time.
    #[inline]
    fn velocities(&self, time: f64, places: &Triangle) -> Triangle {
        match &self.first_spin {
            None => places.each_ref().map(|place| self.motion.velocity(time, place)),
            Some((at, spin)) => {
                let spin = if *at == time { *spin } else { self.motion.spin(time).unwrap_or(*spin) };
                places.each_ref().map(|place| spin.velocity(place))
            }
        }
    }

    /// A time from which on, until `until`, the pair may meet, and before which, from `from` on, it does not; `None` if it does
    /// not meet until `until`. `pose` is that at `from`.
    ///
    /// At the time given the triangles are at most `tolerance` (metres) apart, unless [`MAX_STEPS`] were not enough.
    pub fn first_impact(&self, q: &Triangle, from: f64, until: f64, pose: &Pose, tolerance: f64) -> Option<f64> {
        let mut view = View::new(self, q, from, pose);
        // Most pairs of a window: one of the two planes holds them apart all the way.
        let normals = view.normals();
        if normals.iter().any(|n| view.is_clear(n, until - from)) {
            return None;
        }
        let mut time = from;
        let mut near = 0;
        for _ in 0..MAX_STEPS {
            let closest = closest_triangle_triangle(&view.p, q);
            let free = view.free_time(&sub(&closest.on_p, &closest.on_q), until - time);
            // A product rounds, and so does the sum: always down.
            let next = (time + free * (1.0 - TIME_ROUNDING)) * (1.0 - 4.0 * UNIT_ROUNDOFF);
            if next >= until {
                return None;
            }
            near += u32::from(closest.distance <= tolerance);
            if next <= time || near > STEPS_WHEN_NEAR {
                return Some(time);
            }
            time = next;
            view = View::new(self, q, time, &self.motion.at(time));
        }
        Some(time)
    }

    /// The unit normal between the two at a time, from `q` to the moving triangle: the direction in which they are farthest
    /// apart, or overlap least.
    pub fn normal(&self, q: &Triangle, time: f64) -> Point {
        let view = View::new(self, q, time, &self.motion.at(time));
        let closest = closest_triangle_triangle(&view.p, q);
        let first = sub(&closest.on_p, &closest.on_q);
        let mut best = ([0.0, 0.0, 1.0], f64::NEG_INFINITY);
        for n in std::iter::once(first).chain(view.normals()).chain(view.edge_axes()) {
            let Some(n) = unit(&n) else { continue };
            // The way that closes, where the two sides are equal.
            let (one, other) = (view.gap(&n), view.gap(&scaled(&n, -1.0)));
            let closing = view.velocities.iter().map(|v| dot(&n, v)).sum::<f64>() < 0.0;
            let forward = one > other || (one == other && closing);
            let (n, gap) = if forward { (n, one) } else { (scaled(&n, -1.0), other) };
            if gap > best.1 {
                best = (n, gap);
            }
        }
        best.0
    }
}

/// A pair at a time: the corners relative to one of `q`'s, and the velocities.
pub struct View<'a> {
    moving: &'a Moving<'a>,
    /// The moving triangle.
    pub p: Triangle,
    /// Relative to `q`'s first corner.
    corners: Triangle,
    /// `q`'s other two, likewise.
    others: [Point; 2],
    velocities: Triangle,
    /// By how much a height above a plane may be off, for a normal of length 1, now.
    rounding: f64,
}

impl<'a> View<'a> {
    #[inline]
    pub fn new(moving: &'a Moving<'a>, q: &Triangle, time: f64, pose: &Pose) -> View<'a> {
        let p = pose.apply_triangle(&moving.corners);
        let corners = [sub(&p[0], &q[0]), sub(&p[1], &q[0]), sub(&p[2], &q[0])];
        let others = [sub(&q[1], &q[0]), sub(&q[2], &q[0])];
        let size = [&corners[0], &corners[1], &corners[2], &others[0], &others[1]]
            .iter()
            .fold(0.0, |m: f64, x| m.max(largest(x)));
        let velocities = moving.velocities(time, &p);
        View { moving, p, corners, others, velocities, rounding: HEIGHT_ROUNDOFFS * UNIT_ROUNDOFF * size }
    }

    /// The normals of the two triangles, of any length: of the one that stands still first.
    #[inline]
    pub fn normals(&self) -> [Point; 2] {
        let [a, b, c] = &self.corners;
        [cross(&self.others[0], &self.others[1]), cross(&sub(b, a), &sub(c, a))]
    }

    /// The other axes along which two triangles can be held apart: across an edge of each, and, for triangles in one plane,
    /// across an edge within it.
    pub fn edge_axes(&self) -> impl Iterator<Item = Point> {
        let [a, b, c] = &self.corners;
        let [d, e] = &self.others;
        let of_p = [sub(b, a), sub(c, b), sub(a, c)];
        let of_q = [*d, sub(e, d), scaled(e, -1.0)];
        let [n, m] = self.normals();
        let edges = of_p.into_iter().flat_map(move |u| of_q.map(|v| cross(&u, &v)));
        edges.chain(of_p.map(|u| cross(&u, &m))).chain(of_q.map(|v| cross(&v, &n)))
    }

    /// How far the moving triangle lies above the other along a direction; negative where they overlap.
    #[inline]
    pub fn gap(&self, n: &Point) -> f64 {
        let top = dot(n, &self.others[0]).max(dot(n, &self.others[1])).max(0.0);
        self.corners.iter().fold(f64::INFINITY, |m, p| m.min(dot(n, p))) - top
    }

    /// The same, with the direction turned to where the moving triangle lies.
    #[inline]
    pub fn facing(&self, n: &Point) -> Point {
        let [a, b, c] = &self.corners;
        let [d, e] = &self.others;
        if dot(n, a) + dot(n, b) + dot(n, c) < dot(n, d) + dot(n, e) {
            scaled(n, -1.0)
        } else {
            *n
        }
    }

    /// Heights of the corners above the plane along `n` that just holds `q` below it, with everything uncertain taken off; their
    /// velocities; and a bound on their acceleration.
    #[inline]
    fn heights(&self, n: &Point) -> ([f64; 3], [f64; 3], f64) {
        let limits = &self.moving.limits;
        let size = length(n);
        let top = dot(n, &self.others[0]).max(dot(n, &self.others[1])).max(0.0);
        // Per axis, at both times. A normal too short to have a length holds nothing apart.
        let rounding = if size > LEAST_LENGTH { self.rounding + 4.0 * limits.rounding } else { f64::INFINITY };
        let off = size * rounding + top.abs() * (4.0 * UNIT_ROUNDOFF);
        let height = |i: usize| dot(n, &self.corners[i]) - top - off;
        let stray = size * limits.stray_velocity;
        let rate = |i: usize| dot(n, &self.velocities[i]) - stray;
        let acceleration = limits.acceleration * self.moving.motion.across_axis(n);
        ([height(0), height(1), height(2)], [rate(0), rate(1), rate(2)], acceleration)
    }

    /// Whether a plane across `n` (of any length) holds the two apart for so long.
    #[inline]
    fn is_clear(&self, n: &Point, span: f64) -> bool {
        let (heights, rates, acceleration) = self.heights(&self.facing(n));
        let bend = 0.5 * acceleration * span * span;
        // The bound curves downwards, so a bound above zero at both ends is above it between them. Written so that NaN is not.
        (0..3).all(|i| heights[i] > 0.0 && heights[i] + rates[i] * span > bend * (1.0 + TIME_ROUNDING))
    }

    /// For how long some plane surely holds the two apart, beginning with the one across `first`; more than `span` is as good
    /// as endless. 0 where no plane does.
    fn free_time(&self, first: &Point, span: f64) -> f64 {
        let [n, m] = self.normals();
        let mut best = 0.0f64;
        for axis in [*first, n, m] {
            best = best.max(self.free_time_along(&axis));
            if best > span {
                return best;
            }
        }
        // Long triangles may leave just too little to go on with.
        if best <= SHORTEST_STEP {
            for axis in self.edge_axes() {
                best = best.max(self.free_time_along(&axis));
            }
        }
        best
    }

    fn free_time_along(&self, n: &Point) -> f64 {
        unit(n).map_or(0.0, |n| self.free_time_above(&self.facing(&n), 0.0))
    }

    /// For how long the plane along a unit normal surely holds the two apart, where it may be overlapped by `slack` (metres).
    pub fn free_time_above(&self, n: &Point, slack: f64) -> f64 {
        let (heights, rates, acceleration) = self.heights(n);
        (0..3).map(|i| time_to_reach_zero(heights[i] + slack, rates[i], acceleration)).fold(f64::INFINITY, f64::min)
    }
}

/// The least positive time at which `height + rate t - acceleration t^2 / 2` is zero, rounded anyhow; infinity if there is
/// none, 0 where the height is not positive.
fn time_to_reach_zero(height: f64, rate: f64, acceleration: f64) -> f64 {
    if height.is_nan() || height <= 0.0 {
        return 0.0;
    }
    let mut root = (rate * rate + 2.0 * acceleration * height).sqrt();
    if root < LEAST_LENGTH {
        let size = height.max(rate.abs()).max(acceleration);
        let [h, r, a] = [height, rate, acceleration].map(|x| x / size);
        root = size * (r * r + 2.0 * a * h).sqrt();
    }
    // Of the two forms the one in which nothing cancels.
    let time = if rate > 0.0 {
        if acceleration > 0.0 {
            (rate + root) / acceleration
        } else {
            f64::INFINITY
        }
    } else {
        2.0 * height / (root - rate)
    };
    if time.is_nan() {
        0.0
    } else {
        time
    }
}
