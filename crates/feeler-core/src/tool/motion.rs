//! The motion of a tool from one pose to another, with proven bounds.
//!
//! The tool's *pivot* moves along a straight line at constant speed, and the tool turns about it at constant speed
//! about a fixed axis. Between poses the pivot is usually the middle of the tool's box, and the rotation the shorter
//! way round (slerp: K. Shoemake 1985): the tool's own origin has no effect, so a tool modelled far from its origin
//! does not swing. On a screw the pivot is the point of the axis nearest to that middle, and the rotation has any
//! angle. Along a chain of joints the motion is that of [`Linked`] instead.
//!
//! Given poses are rigid only within 1e-6, and are used as given: the deviation of their matrices from a rotation is
//! added, and fades out within the first and the last `FADE` of the motion. So the motion begins and ends exactly at
//! the given poses, and every pose on it is as rigid as they are.

use std::f64::consts::FRAC_PI_2;

use crate::constants::{ARC_ROUNDING, FADE, MOTION_ROUNDOFFS, UNIT_ROUNDOFF};
use crate::error::Result;
use crate::geometry::bounds::{Aabb, Point, Triangle};
use crate::geometry::pose::Pose;
use crate::geometry::twist::{product, times, transposed, turn, Matrix};
use crate::geometry::vectors::{add, any_length, cross, dot, largest, length, scaled, sub, unit};
use crate::tool::chain::{Chain, Joint, Linked, Rates, Spin, Turned};
use crate::tool::leg::Leg;
use crate::tool::moving_tool::Tool;
use crate::tool::screw::Screw;

/// A rigid motion of one tool; time runs from 0 to 1.
///
/// A point of it, the pivot, moves along a straight line at constant speed, and the tool turns about it at constant speed about a fixed
/// axis.
#[derive(Debug, Clone)]
pub struct Motion {
    ends: [Pose; 2],
    /// In the tool's frame.
    pivot: Point,
    /// The pivot in the world at time 0, and its velocity (metres for the whole way).
    from: Point,
    velocity: Point,
    /// The rotation at time 0: orthonormal, or on a screw as given.
    start: Matrix,
    /// Unit axis in the world, and the angle turned about it (radians, not negative; to a pose at most pi).
    axis: Point,
    angle: f64,
    axis_in_tool: Point,
    /// How much longer a vector may be across the axis than `axis_in_tool` says, as a share of its length: a given pose is rigid only
    /// within 1e-6.
    slack: f64,
    /// Along which it is; `None` from pose to pose.
    screw: Option<Screw>,
    /// The joints that move it, instead of all this; boxed, as few motions have any.
    linked: Option<Box<Linked>>,
    /// Deviation of the given matrices from a rotation.
    beyond: [Matrix; 2],
    /// Bounds for the whole tool, metres: distance from the axis, displacement by `beyond`, rounding per axis.
    reach: f64,
    bend: f64,
    rounding: f64,
}

/// Where the tool is during a span of time: everything the tool sweeps lies within `margin` (metres, per axis) of the straight
/// lines between its places at the two poses.
#[derive(Debug, Clone)]
pub(crate) struct Window {
    /// The poses at both ends.
    pub poses: [Pose; 2],
    /// See above. It covers rounding, too.
    pub margin: f64,
}

impl Window {
    /// A box around all places of a triangle of the tool.
    pub(crate) fn bounds_of(&self, triangle: &Triangle) -> Aabb {
        let [a, b] = self.poses.each_ref().map(|pose| Aabb::of_triangle(&pose.apply_triangle(triangle)));
        grown(&a.union(&b), self.margin)
    }

    /// A box around all places of the whole tool.
    pub(crate) fn bounds_of_box(&self, bounds: &Aabb) -> Aabb {
        let [a, b] = self.poses.each_ref().map(|pose| pose.apply_box(bounds, self.margin));
        a.union(&b)
    }
}

fn grown(b: &Aabb, margin: f64) -> Aabb {
    Aabb { lower: b.lower.map(|x| x - margin), upper: b.upper.map(|x| x + margin) }
}

impl Motion {
    /// The way of a tool between two poses `world_from_tool`: its [pivot](Tool::pivot) moves straight, and the tool turns the shorter
    /// way round.
    pub fn new(tool: &Tool, pose0: &Pose, pose1: &Pose) -> Motion {
        let pivot = *tool.pivot();
        let (from, to) = (pose0.apply(&pivot), pose1.apply(&pivot));
        let [start, end] = [pose0, pose1].map(|pose| orthonormal(pose.rotation()));
        let (axis, angle) = axis_and_angle(&product(&end, &transposed(&start)));
        let beyond = [difference(pose0.rotation(), &start), difference(pose1.rotation(), &end)];
        let translation = pose0.largest_translation().max(pose1.largest_translation());
        let motion = Motion {
            ends: [*pose0, *pose1],
            pivot,
            from,
            velocity: sub(&to, &from),
            start,
            axis,
            angle,
            axis_in_tool: times(&transposed(&start), &axis),
            slack: 0.0,
            screw: None,
            linked: None,
            beyond,
            reach: 0.0,
            bend: 0.0,
            rounding: 0.0,
        };
        motion.bounded(tool, translation)
    }

    /// The way of a tool from a pose along a screw. The pivot is on its axis.
    ///
    /// Errors where the tool would get beyond the coordinate limit.
    pub fn screw(tool: &Tool, pose: &Pose, screw: &Screw) -> Result<Motion> {
        // The matrix is turned as given: it stays as rigid as it is.
        let start = *pose.rotation();
        let back = transposed(&orthonormal(&start));
        let foot = screw.foot(&pose.apply(tool.pivot()));
        // The pose is rigid only within 1e-6: each round brings the rest down by as much.
        let mut pivot = times(&back, &sub(&foot, pose.translation()));
        for _ in 0..2 {
            pivot = add(&pivot, &times(&back, &sub(&foot, &pose.apply(&pivot))));
        }
        let from = pose.apply(&pivot);
        let sign = if screw.angle() < 0.0 { -1.0 } else { 1.0 };
        let (axis, angle) = (scaled(screw.axis(), sign), screw.angle().abs());
        let velocity = screw.way();
        let rotation = product(&turn(&axis, angle), &start);
        let place = sub(&add(&from, &velocity), &times(&rotation, &pivot));
        let motion = Motion {
            ends: [*pose, Pose::unchecked(rotation, place).translated(&[0.0; 3])?],
            pivot,
            from,
            velocity,
            start,
            axis,
            angle,
            axis_in_tool: times(&back, &axis),
            slack: size(&difference(&start, &transposed(&back))),
            screw: Some(*screw),
            linked: None,
            beyond: [[[0.0; 3]; 3]; 2],
            reach: 0.0,
            bend: 0.0,
            rounding: 0.0,
        };
        // Of the pose at any time.
        let mut motion = motion.bounded(tool, largest(&from) + largest(&velocity) + 2.0 * largest(&pivot));
        // The sine of a large angle is known to as many roundings less.
        motion.rounding += MOTION_ROUNDOFFS * UNIT_ROUNDOFF * angle * motion.reach;
        Ok(motion)
    }

    /// The way of a tool from a pose along a chain of joints.
    ///
    /// Errors where the tool would get beyond the coordinate limit.
    pub fn chain(tool: &Tool, pose: &Pose, chain: &Chain) -> Result<Motion> {
        let joints = chain.shortened()?;
        match &joints[..] {
            [] => return Ok(Motion::new(tool, pose, pose)),
            [Joint::Screw(screw)] => return Motion::screw(tool, pose, screw),
            [Joint::Slide(way)] => return Ok(Motion::new(tool, pose, &pose.translated(way)?)),
            _ => {}
        }
        let linked = Linked::new(chain, &joints, pose, tool.pivot(), &corners_of(&tool.mesh().bounds()));
        let end = linked.at(1.0).translated(&[0.0; 3])?;
        let mut motion = Motion::new(tool, pose, &end);
        motion.angle = linked.angle;
        motion.rounding = linked.rounding;
        motion.bend = 0.0;
        motion.linked = Some(Box::new(linked));
        Ok(motion)
    }

    /// With the bounds of a tool; `translation`: the largest coordinate beside the tool's own, metres.
    fn bounded(self, tool: &Tool, translation: f64) -> Motion {
        let bounds = tool.mesh().bounds();
        let corners = corners_of(&bounds).map(|p| sub(&p, &self.pivot));
        let radius = corners.iter().map(any_length).fold(0.0, f64::max);
        let across = corners.iter().map(|p| any_length(&cross(&self.axis_in_tool, p))).fold(0.0, f64::max);
        let bend = self.beyond.iter().map(|m| size(m) * radius).fold(0.0, f64::max);
        let rounding = MOTION_ROUNDOFFS * UNIT_ROUNDOFF * (bounds.largest_coordinate() + translation);
        Motion {
            reach: (across + self.slack * radius) * (1.0 + ARC_ROUNDING),
            bend: bend * (1.0 + ARC_ROUNDING),
            rounding: rounding + f64::MIN_POSITIVE,
            ..self
        }
    }

    /// The motions of a way from a pose, one a leg. Errors as [`screw`](Self::screw).
    pub fn of_legs(tool: &Tool, start: &Pose, legs: &[Leg]) -> Result<Vec<Motion>> {
        let mut here = *start;
        let mut motions = Vec::with_capacity(legs.len());
        for leg in legs {
            let motion = match leg {
                Leg::To(pose) => Motion::new(tool, &here, pose),
                Leg::Screw(screw) => Motion::screw(tool, &here, screw)?,
                Leg::Chain(chain) => Motion::chain(tool, &here, chain)?,
            };
            here = motion.ends[1];
            motions.push(motion);
        }
        Ok(motions)
    }

    /// The same of another tool with the same [pivot](Tool::pivot). Errors as [`screw`](Self::screw).
    pub fn of_tool(&self, tool: &Tool) -> Result<Motion> {
        if let Some(linked) = &self.linked {
            return Motion::chain(tool, &self.ends[0], &linked.chain);
        }
        match &self.screw {
            Some(screw) => Motion::screw(tool, &self.ends[0], screw),
            None => Ok(Motion::new(tool, &self.ends[0], &self.ends[1])),
        }
    }

    /// It until a time. Errors as [`screw`](Self::screw).
    pub fn until(&self, tool: &Tool, time: f64) -> Result<Motion> {
        if let Some(linked) = &self.linked {
            return Motion::chain(tool, &self.ends[0], &linked.chain.share(time));
        }
        match &self.screw {
            Some(screw) => Motion::screw(tool, &self.ends[0], &screw.share(time)),
            None => Ok(Motion::new(tool, &self.ends[0], &self.at(time))),
        }
    }

    /// By how much it turns, radians, not negative; along a chain all its joints together.
    pub fn angle(&self) -> f64 {
        self.angle
    }

    /// Along which it moves where it does not turn, unit, world; `None` where it does.
    pub fn direction(&self) -> Option<Point> {
        unit(&self.velocity).filter(|_| self.linked.is_none() && self.angle * self.reach <= self.rounding)
    }

    /// The rest of the motion from a time on. Errors as [`screw`](Self::screw).
    pub fn rest(&self, tool: &Tool, time: f64) -> Result<Motion> {
        let here = self.at(time);
        if let Some(linked) = &self.linked {
            return Motion::chain(tool, &here, &linked.chain.rest(time)?);
        }
        match &self.screw {
            Some(screw) => Motion::screw(tool, &here, &screw.share(1.0 - time)),
            None => Ok(Motion::new(tool, &here, &self.ends[1])),
        }
    }

    /// The pose at a time from 0 to 1: the given ones at both ends.
    pub fn at(&self, time: f64) -> Pose {
        if time <= 0.0 {
            return self.ends[0];
        }
        if time >= 1.0 {
            return self.ends[1];
        }
        if let Some(linked) = &self.linked {
            return linked.at(time);
        }
        let mut rotation = product(&turn(&self.axis, self.angle * time), &self.start);
        for (m, share) in self.beyond.iter().zip([1.0 - time / FADE, 1.0 - (1.0 - time) / FADE]) {
            if share > 0.0 {
                rotation = std::array::from_fn(|i| std::array::from_fn(|j| rotation[i][j] + share * m[i][j]));
            }
        }
        Pose::unchecked(rotation, sub(&self.pivot_at(time), &times(&rotation, &self.pivot)))
    }

    /// Whether the tool does not move at all. After whole turns it is where it began, too.
    pub(crate) fn is_still(&self) -> bool {
        self.ends[0] == self.ends[1] && self.angle < FRAC_PI_2 && self.linked.is_none()
    }

    /// How a way goes on along it: see [`of_legs`](Self::of_legs).
    pub fn leg(&self) -> Leg {
        match (&self.linked, self.screw) {
            (Some(linked), _) => Leg::Chain(linked.chain.clone()),
            (None, Some(screw)) => Leg::Screw(screw),
            (None, None) => Leg::To(self.ends[1]),
        }
    }

    /// The rest of it from a time on, where that is a slide or a screw.
    pub(crate) fn steady(&self, from: f64) -> Option<Steady> {
        if self.linked.is_some() {
            return None;
        }
        let (rest, along) = (1.0 - from, dot(&self.velocity, &self.axis));
        if self.angle * self.reach <= self.rounding {
            return Some(Steady::Slide { way: scaled(&self.velocity, rest) });
        }
        let across = any_length(&sub(&self.velocity, &scaled(&self.axis, along)));
        let (point, angle) = (self.pivot_at(from), self.angle * rest);
        let is_screw = across <= self.rounding;
        is_screw.then_some(Steady::Screw { axis: self.axis, point, angle, advance: along * rest })
    }

    /// By how much a point of the tool may be off that, metres per axis.
    pub(crate) fn stray(&self) -> f64 {
        2.0 * self.bend + 4.0 * self.rounding
    }

    /// A box around all that the tool sweeps from a time on.
    pub(crate) fn swept_bounds(&self, tool: &Tool, from: f64) -> Aabb {
        let bounds = tool.mesh().bounds();
        // Pieces of half a radian, in which an arc is nearly its chord.
        let pieces = (2.0 * self.angle * (1.0 - from)).ceil().max(1.0);
        let at = |piece: f64| (from + (1.0 - from) * piece / pieces).min(1.0);
        let mut all = self.window(tool, from, at(1.0)).bounds_of_box(&bounds);
        let mut piece = 1.0;
        while piece < pieces {
            all = all.union(&self.window(tool, at(piece), at(piece + 1.0)).bounds_of_box(&bounds));
            piece += 1.0;
        }
        all
    }

    /// Where it ends.
    pub fn end(&self) -> &Pose {
        &self.ends[1]
    }

    /// How far any point of the tool moves at most, metres.
    pub fn longest_way(&self) -> f64 {
        if let Some(linked) = &self.linked {
            return linked.rates.speed;
        }
        length(&self.velocity) + self.angle * self.reach + 2.0 * self.bend
    }

    /// How far the tool's own [pivot](Tool::pivot) moves, metres: straight, along a helix, or by quadrature along a chain.
    pub fn way_of_pivot(&self, tool: &Tool) -> f64 {
        if let Some(linked) = &self.linked {
            return linked.way_of(tool.pivot());
        }
        let arm = cross(&self.axis_in_tool, &sub(tool.pivot(), &self.pivot));
        length(&self.velocity).hypot(self.screw.map_or(0.0, |_| self.angle * length(&arm)))
    }

    /// How well the convex hull of a triangle's places at the ends of a span of time stands for its places in between; `share` is
    /// the length of the span.
    ///
    /// A point of the hull is `l A q + (1 - l) B r` with points `q`, `r` of the triangle and the poses `A`, `B` at both ends. Off the
    /// place that `l q + (1 - l) r` has at the time `1 - l` it is by the arc's height, and by `l (1 - l) (A - B) (q - r)`, which is
    /// at most a quarter of the angle times the triangle's width across the axis.
    pub fn chord(&self, triangle: &Triangle, share: f64) -> Chord {
        let across = |p: &Point, q: &Point| self.across(&sub(p, q));
        let radius = triangle.iter().map(|p| across(p, &self.pivot)).fold(0.0, f64::max);
        let [a, b, c] = triangle;
        if let Some(linked) = &self.linked {
            let wide = length(&sub(a, b)).max(length(&sub(b, c))).max(length(&sub(c, a)));
            let arc = 0.125 * share * share * linked.rates.acceleration;
            let stray = 4.0 * self.rounding;
            let wide = arc + 0.25 * linked.angle * share * wide * (1.0 + 2e-6);
            return Chord { short: arc + stray, wide: wide * (1.0 + ARC_ROUNDING) + stray };
        }
        let width = across(a, b).max(across(b, c)).max(across(c, a));
        let angle = self.angle * share;
        // Per axis at a place; at two.
        let stray = 2.0 * self.bend + 4.0 * self.rounding;
        let arc = 0.125 * angle * angle * radius;
        Chord {
            short: arc * (1.0 + ARC_ROUNDING) + stray,
            wide: (arc + 0.25 * angle * width) * (1.0 + ARC_ROUNDING) + stray,
        }
    }

    /// The tool's sweep between two times.
    pub(crate) fn window(&self, tool: &Tool, from: f64, to: f64) -> Window {
        let poses = [self.at(from), self.at(to)];
        // A point on a circle, taken for one on the chord at the same time, is off by at most an eighth of its acceleration.
        let angle = self.angle * (to - from);
        let arc = match &self.linked {
            Some(linked) => 0.125 * linked.rates_between(from, to).acceleration * (to - from) * (to - from),
            None => 0.125 * angle * angle * self.reach,
        };
        let placing = tool.margin_at(&poses[0]).max(tool.margin_at(&poses[1]));
        Window { poses, margin: (arc + 2.0 * self.bend) * (1.0 + ARC_ROUNDING) + 2.0 * self.rounding + placing }
    }

    /// How fast the given point of the tool moves when it is at `place` in the world, metres for the whole way.
    #[inline]
    pub(crate) fn velocity(&self, time: f64, place: &Point) -> Point {
        debug_assert!(self.linked.is_none(), "see spin");
        let spin = cross(&self.axis, &sub(place, &self.pivot_at(time)));
        add(&self.velocity, &scaled(&spin, self.angle))
    }

    /// How the tool moves at a time, along a chain; else `velocity` says it.
    #[inline]
    pub(crate) fn spin(&self, time: f64) -> Option<Spin> {
        self.linked.as_ref().map(|linked| linked.spin(time))
    }

    /// What all triangles share in a span of time.
    pub(crate) fn during(&self, from: f64, until: f64) -> During {
        let Some(linked) = &self.linked else { return During { from, until, spin: None, turned: Vec::new() } };
        During { from, until, spin: Some(linked.spin(from)), turned: linked.turned(from) }
    }

    /// How far any point of the tool is at most, during a span of time, from where it is in the middle of it, metres.
    pub(crate) fn displacement(&self, from: f64, to: f64) -> f64 {
        let half = 0.5 * (to - from);
        let speed = match (&self.linked, self.screw) {
            (Some(linked), _) => linked.rates_between(from, to).speed,
            // Along the axis, and across it.
            (None, Some(_)) => length(&self.velocity).hypot(self.angle * self.reach),
            (None, None) => length(&self.velocity) + self.angle * self.reach,
        };
        speed * half * (1.0 + ARC_ROUNDING) + 2.0 * self.bend + 4.0 * self.rounding
    }

    /// Bounds that hold for all points of a triangle of the tool during a span of time.
    pub(crate) fn limits(&self, triangle: &Triangle, during: &During) -> Limits {
        if let Some(linked) = &self.linked {
            let During { from, until, turned, .. } = during;
            let Rates { acceleration, .. } = linked.rates_of_triangle(triangle, turned, *from, until - from);
            return Limits { acceleration, stray_velocity: linked.stray_velocity(), rounding: self.rounding };
        }
        let radius =
            triangle.iter().map(|p| self.across(&sub(p, &self.pivot))).fold(0.0f64, |m, r| if r > m { r } else { m });
        let place = self.from.iter().chain(&self.velocity).fold(0.0f64, |m, x| m.max(x.abs()));
        Limits {
            acceleration: self.angle * self.angle * radius * (1.0 + ARC_ROUNDING),
            // The bend, and the rounding of a computed velocity.
            stray_velocity: self.bend / FADE
                + 64.0 * UNIT_ROUNDOFF * (length(&self.velocity) + self.angle * (place + self.reach))
                + self.angle * self.rounding,
            rounding: self.rounding,
        }
    }

    /// At most the length of a vector of the tool across the axis.
    #[inline]
    fn across(&self, v: &Point) -> f64 {
        let across = any_length(&cross(&self.axis_in_tool, v));
        if self.slack > 0.0 {
            across + self.slack * any_length(v)
        } else {
            across
        }
    }

    /// The part of a direction that turning can act on: `n` without its component along the axis, as a length.
    #[inline]
    pub(crate) fn across_axis(&self, n: &Point) -> f64 {
        match &self.linked {
            Some(linked) => linked.across(n),
            None => length(&cross(n, &self.axis)),
        }
    }

    fn pivot_at(&self, time: f64) -> Point {
        add(&self.from, &scaled(&self.velocity, time))
    }
}

/// See [`Motion::during`].
#[derive(Debug, Clone)]
pub(crate) struct During {
    from: f64,
    until: f64,
    /// At its beginning, along a chain.
    spin: Option<Spin>,
    turned: Turned,
}

impl During {
    /// At its beginning, along a chain.
    #[inline]
    pub fn first_spin(&self) -> Option<(f64, Spin)> {
        self.spin.map(|spin| (self.from, spin))
    }
}

/// A motion on which each point keeps its distance from an axis, and moves along it as it turns about it.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Steady {
    /// Straight, metres.
    Slide {
        /// All of it, world.
        way: Point,
    },
    /// About an axis and along it.
    Screw {
        /// Unit, world.
        axis: Point,
        /// On the axis, world.
        point: Point,
        /// Radians, positive.
        angle: f64,
        /// Metres along the axis for all of the angle.
        advance: f64,
    },
}

/// See [`Motion::chord`]. Metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Chord {
    /// No place of the triangle is farther from the hull.
    pub short: f64,
    /// No point of the hull is farther from all places of the triangle.
    pub wide: f64,
}

/// See [`Motion::limits`].
#[derive(Debug, Clone, Copy)]
pub(crate) struct Limits {
    /// Largest acceleration, metres for the whole time squared, in a direction across the axis.
    pub acceleration: f64,
    /// The largest error of [`Motion::velocity`] at a point.
    pub stray_velocity: f64,
    /// By how much a computed corner may be off its place on the way, metres per axis.
    pub rounding: f64,
}

fn corners_of(b: &Aabb) -> [Point; 8] {
    std::array::from_fn(|i| std::array::from_fn(|a| if i >> a & 1 == 0 { b.lower[a] } else { b.upper[a] }))
}

fn difference(a: &Matrix, b: &Matrix) -> Matrix {
    std::array::from_fn(|i| std::array::from_fn(|j| a[i][j] - b[i][j]))
}

/// No vector grows by more than this factor.
fn size(m: &Matrix) -> f64 {
    m.iter().flatten().map(|x| x * x).sum::<f64>().sqrt()
}

/// The rotation nearest to a matrix that is one within 1e-6: Newton's iteration for the polar decomposition, which squares
/// the deviation at each step.
fn orthonormal(m: &Matrix) -> Matrix {
    let mut r = *m;
    for _ in 0..3 {
        // The inverse transposed of a matrix with determinant d: cross products of its rows, over d.
        let cofactors = [cross(&r[1], &r[2]), cross(&r[2], &r[0]), cross(&r[0], &r[1])];
        let determinant = dot(&r[0], &cofactors[0]);
        r = std::array::from_fn(|i| std::array::from_fn(|j| 0.5 * (r[i][j] + cofactors[i][j] / determinant)));
    }
    r
}

/// Unit axis and angle, 0 to pi, of a rotation, by its quaternion.
fn axis_and_angle(m: &Matrix) -> (Point, f64) {
    let trace = m[0][0] + m[1][1] + m[2][2];
    // The largest of the four components is at least a half: it is found first and divides the others.
    let largest = (0..3).fold(3, |best, a| {
        let value = |i: usize| if i == 3 { trace } else { m[i][i] };
        if value(a) > value(best) {
            a
        } else {
            best
        }
    });
    let skew = [m[2][1] - m[1][2], m[0][2] - m[2][0], m[1][0] - m[0][1]];
    let (mut w, mut v);
    if largest == 3 {
        (w, v) = (1.0 + trace, skew);
    } else {
        let (i, j, k) = (largest, (largest + 1) % 3, (largest + 2) % 3);
        w = skew[i];
        v = [0.0; 3];
        v[i] = 1.0 + m[i][i] - m[j][j] - m[k][k];
        v[j] = m[i][j] + m[j][i];
        v[k] = m[i][k] + m[k][i];
    }
    if w < 0.0 {
        w = -w;
        v = scaled(&v, -1.0);
    }
    let sine = length(&v);
    if sine == 0.0 {
        return ([0.0, 0.0, 1.0], 0.0);
    }
    (scaled(&v, 1.0 / sine), 2.0 * sine.atan2(w))
}
