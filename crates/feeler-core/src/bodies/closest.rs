//! The closest triangles of two bodies: the search of one tool in one mock-up, with pairs measured in the world.

use super::relative::inverse;
use crate::collide::query::BothPlaced;
use crate::constants::{DISTANCE_ROUNDOFFS, FRAME_STRETCH, UNIT_ROUNDOFF};
use crate::error::{Error, Result};
use crate::geometry::bounds::Point;
use crate::geometry::distance_triangle_triangle::{closest_within, Closest};
use crate::geometry::pose::Pose;
use crate::index::sink::NearSink;
use crate::progress::{GoOn, Pace};

/// Steps of the search between two questions whether it goes on.
const STEPS_BETWEEN_LOOKS: u32 = 64;

/// The state of a search.
pub(super) struct Nearest<'a> {
    both: &'a BothPlaced<'a>,
    /// The frame's axes in the world.
    to_frame: [[f64; 3]; 3],
    margin: f64,
    /// Whether the caller gave the other body first.
    is_turned: bool,
    within: f64,
    best: Option<([u32; 2], Closest)>,
    direction: [f32; 3],
    pace: Pace<'a>,
}

impl<'a> Nearest<'a> {
    /// `frame`: the pose of the body that has the index.
    pub fn new(both: &'a BothPlaced<'a>, frame: &Pose, is_turned: bool, within: f64, go_on: GoOn<'a>) -> Nearest<'a> {
        let mesh = both.index.mockup().mesh().bounds().largest_coordinate();
        let tool = both.tool.mesh().bounds().largest_coordinate();
        let largest = 2.0 * (mesh + tool) + both.pose.largest_translation() + frame.largest_translation();
        let rounding = 2.0 * DISTANCE_ROUNDOFFS * UNIT_ROUNDOFF * largest;
        Nearest {
            both,
            to_frame: inverse(frame.rotation()),
            margin: both.tool.margin_at(both.relative) + both.spread + rounding,
            is_turned,
            within,
            best: None,
            direction: [0.0; 3],
            pace: Pace::new(go_on, STEPS_BETWEEN_LOOKS),
        }
    }

    /// Tool's triangle and mesh's, and where they are closest. An error where the search was stopped.
    pub fn finish(self) -> Result<Option<([u32; 2], Closest)>> {
        if self.pace.is_stopped() {
            return Err(Error::Cancelled);
        }
        Ok(self.best)
    }

    /// As the caller orders pairs.
    fn order(&self, pair: [u32; 2]) -> [u32; 2] {
        if self.is_turned {
            [pair[1], pair[0]]
        } else {
            pair
        }
    }
}

impl NearSink for Nearest<'_> {
    #[inline(always)]
    fn bound(&self) -> f64 {
        self.within * (1.0 + FRAME_STRETCH)
    }

    #[inline(always)]
    fn has_bounds_of_parts(&self) -> bool {
        false
    }

    #[inline(always)]
    fn bound_of(&self, _: u32) -> Option<f64> {
        Some(self.bound())
    }

    fn margin(&self) -> f64 {
        self.margin
    }

    #[inline(always)]
    fn direction(&self) -> [f32; 3] {
        self.direction
    }

    #[inline(always)]
    fn is_collecting(&self) -> bool {
        false
    }

    fn collect(&mut self, _: u32, _: u32, _: f64) -> bool {
        false
    }

    #[inline(always)]
    fn must_stop(&mut self) -> bool {
        self.pace.step()
    }

    fn take(&mut self, slot: u32, mockup_triangle: u32) -> bool {
        let BothPlaced { tool, pose, corners, .. } = *self.both;
        let p = pose.apply_triangle(&tool.placeable()[slot as usize]);
        let q = corners.triangle(mockup_triangle);
        // The last bit of a distance depends on the order: the caller's.
        let closest = if self.is_turned {
            closest_within(&q, &p, self.within).map(|c| Closest { on_p: c.on_q, on_q: c.on_p, ..c })
        } else {
            closest_within(&p, &q, self.within)
        };
        let Some(closest) = closest else { return false };
        let pair = [tool.ids()[slot as usize], mockup_triangle];
        if let Some((old, of_old)) = &self.best {
            let order = closest.distance.total_cmp(&of_old.distance);
            if order.then_with(|| self.order(pair).cmp(&self.order(*old))).is_ge() {
                return false;
            }
        }
        self.within = closest.distance;
        if closest.distance > 0.0 {
            let between: Point = std::array::from_fn(|a| (closest.on_q[a] - closest.on_p[a]) / closest.distance);
            let along: Point = std::array::from_fn(|i| (0..3).map(|k| self.to_frame[i][k] * between[k]).sum());
            let length = along.iter().map(|x| x * x).sum::<f64>().sqrt();
            self.direction = along.map(|x| (x / length) as f32);
        }
        self.best = Some((pair, closest));
        closest.distance == 0.0
    }
}
