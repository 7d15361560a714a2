//! A moving triangle against a fixed one where touching is free: when they first overlap by more than a tolerance.
//!
//! As in [`pair`](super::pair) planes separate the two; once they are within the tolerance, they may overlap a plane by
//! the tolerance. This separates two triangles that slide along each other during the whole motion. From one plane to
//! the next the normal turns by at most a right angle, and never to the inner side of a solid that lies in the plane: a
//! flat face does not pass through another, however thin.

use super::pair::{Moving, View};
use crate::constants::{MAX_STEPS, SAME_AXIS, SEARCHED_SHARE, TIME_ROUNDING, UNIT_ROUNDOFF};
use crate::geometry::bounds::{Point, Triangle};
use crate::geometry::distance_triangle_triangle::closest_triangle_triangle;
use crate::geometry::pose::Pose;
use crate::geometry::vectors::{dot, scaled, sub, unit};

/// The state of a pair until a time.
#[derive(Debug, Clone, Copy)]
pub enum Slide {
    /// Free; the normal that holds the two apart then, from the one that stands still, where they touch.
    Free(Option<Point>),
    /// From this time on no plane holds them apart.
    Blocked(f64),
}

/// The senses of the moving triangle and of the one that stands still: 1 or -1 where its surface bounds a solid, 0 of a sheet.
pub type Senses = [i8; 2];

impl Moving<'_> {
    /// Follows a pair from a time until another; `pose` is that at `from`, `held` the normal that held them apart until then.
    pub fn slide(
        &self,
        q: &Triangle,
        senses: Senses,
        (from, until): (f64, f64),
        pose: &Pose,
        held: Option<Point>,
        tolerance: f64,
    ) -> Slide {
        let mut view = View::new(self, q, from, pose);
        // Most pairs of a window: the plane of one of the two is not overlapped by more than the tolerance all the way.
        if let Some((axis, gap)) = view.face_hold(senses, held, until - from, tolerance) {
            return Slide::Free((gap <= tolerance + self.longest_way(until - from)).then_some(axis));
        }
        let (mut time, mut held) = (from, held);
        for _ in 0..MAX_STEPS {
            let closest = closest_triangle_triangle(&view.p, q);
            let first = sub(&closest.on_p, &closest.on_q);
            let slack = if closest.distance <= tolerance { SEARCHED_SHARE * tolerance } else { 0.0 };
            let Some((axis, free)) = view.longest_hold(&first, senses, held.filter(|_| slack > 0.0), slack) else {
                return Slide::Blocked(time);
            };
            let next = (time + free * (1.0 - TIME_ROUNDING)) * (1.0 - 4.0 * UNIT_ROUNDOFF);
            if next >= until {
                // Where they are apart by then, the next plane may be any.
                let is_near = slack > 0.0 || closest.distance <= tolerance + self.longest_way(until - time);
                return Slide::Free(is_near.then_some(axis));
            }
            if next <= time {
                return Slide::Blocked(time);
            }
            (time, held) = (next, Some(axis));
            view = View::new(self, q, time, &self.motion.at(time));
        }
        Slide::Blocked(time)
    }

    /// How far any of its points may come in a span of time, metres.
    fn longest_way(&self, span: f64) -> f64 {
        self.motion.longest_way() * span
    }
}

impl View<'_> {
    /// The unit normal of a triangle whose plane holds the two apart for a span of time, when it may be overlapped by `slack` (metres),
    /// and how far apart it holds them at its beginning; `None` where neither does. Turned as in [`longest_hold`](Self::longest_hold).
    fn face_hold(&self, senses: Senses, held: Option<Point>, span: f64, slack: f64) -> Option<(Point, f64)> {
        let normals = self.normals();
        // The moving triangle is on the outer side of the one that stands still, which is on that of the moving one. Of sheets it is on the
        // side where it was.
        let turned = |axis: Point, sense: i8| match held {
            _ if sense != 0 => scaled(&axis, f64::from(sense)),
            Some(held) if dot(&held, &axis) < 0.0 => scaled(&axis, -1.0),
            Some(_) => axis,
            None => self.facing(&axis),
        };
        [(normals[0], senses[1]), (normals[1], -senses[0])].into_iter().find_map(|(normal, sense)| {
            let axis = turned(unit(&normal)?, sense);
            let is_held = !is_turned(&axis, held)
                && self.free_time_above(&axis, slack) * (1.0 - TIME_ROUNDING) > span
                && !is_inward(&axis, &outward(&normals, senses));
            is_held.then(|| (axis, self.gap(&axis)))
        })
    }

    /// The unit normal of the plane that holds the two apart for longest, when it may be overlapped by `slack` (metres), and for how
    /// long; `None` where none does. With `held` none that leans away from that.
    fn longest_hold(&self, first: &Point, senses: Senses, held: Option<Point>, slack: f64) -> Option<(Point, f64)> {
        let [n, m] = self.normals();
        let outward = outward(&[n, m], senses);
        let mut best: Option<(Point, f64)> = None;
        let mut consider = |axis: &Point| {
            let Some(axis) = unit(axis) else { return };
            for axis in [axis, scaled(&axis, -1.0)] {
                if slack > 0.0 && (is_turned(&axis, held) || is_inward(&axis, &outward)) {
                    continue;
                }
                let free = self.free_time_above(&axis, slack);
                if free > best.map_or(0.0, |(_, free)| free) {
                    best = Some((axis, free));
                }
            }
        };
        [*first, n, m].iter().for_each(&mut consider);
        self.edge_axes().for_each(|axis| consider(&axis));
        best
    }
}

/// The unit normals, out of their solids, of the triangle that stands still and of the moving one, given any of theirs in this order;
/// `None` of a sheet.
fn outward(normals: &[Point; 2], [of_moving, of_still]: Senses) -> [Option<Point>; 2] {
    let [still, moving] = normals;
    [(still, of_still), (moving, of_moving)].map(|(normal, sense)| {
        let sense = f64::from(sense);
        unit(normal).filter(|_| sense != 0.0).map(|normal| scaled(&normal, sense))
    })
}

/// Whether an axis, from the triangle that stands still to the moving one, leads into the solid of the one, or out of that of the other.
fn is_inward(axis: &Point, [of_still, of_moving]: &[Option<Point>; 2]) -> bool {
    let is_against = |normal: &Option<Point>, sign: f64| normal.is_some_and(|n| sign * dot(axis, &n) < -SAME_AXIS);
    is_against(of_still, 1.0) || is_against(of_moving, -1.0)
}

/// Whether an axis leans away from the one that held before.
fn is_turned(axis: &Point, held: Option<Point>) -> bool {
    held.is_some_and(|held| dot(&held, axis) < -1e-9)
}
