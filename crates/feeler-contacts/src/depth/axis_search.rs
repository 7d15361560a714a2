//! The search for the axis of least depth of two bodies: the best one so far, and the comparison with new ones.

use std::array::from_fn;

use feeler_core::geometry::vectors::{along, dot, length, scaled, sub};
use feeler_core::{Aabb, Point};
use feeler_lanes::WIDE_LANES;

use crate::constants::{DEPTH_NOISE, FACING_NOISE, POINT_SHARE, SHALLOWER};
use crate::depth::axis::{centre, eight_of, is_leading_out, BodyPair, TriedAxis};
use crate::depth::axis_blocked::BlockedAxes;
use crate::patch::body::Body;
use crate::patch::support::{highest, highest_and_lowest, places_above, Reach};
use crate::surface::Surface;

/// One search, over the axes of one pair.
pub(super) struct AxisSearch<'a> {
    pub pair: &'a BodyPair<'a>,
    /// Metres below which two depths count as equal.
    pub noise: f64,
    /// The axis of least depth so far.
    pub best: Option<TriedAxis>,
    pub blocked: &'a mut BlockedAxes,
}

impl<'a> AxisSearch<'a> {
    pub fn new(pair: &'a BodyPair<'a>, blocked: &'a mut BlockedAxes, best: Option<TriedAxis>) -> AxisSearch<'a> {
        let BodyPair { tool, mockup, .. } = pair;
        let noise = DEPTH_NOISE * tool.size.max(mockup.size).max(tool.largest);
        AxisSearch { pair, noise, best, blocked }
    }

    /// The depth at and above which an axis cannot be the best; infinite where there is none yet.
    pub fn limit(&self) -> f64 {
        match self.best {
            // At least twice the noise: below it axes are ranked by the directions that the surfaces face.
            Some(best) => {
                let least = best.depth();
                (least - SHALLOWER * least.abs() - self.noise).max(2.0 * self.noise) + self.noise
            }
            None => f64::INFINITY,
        }
    }

    /// The support points along eight directions: the mock-up's highest and the tool's lowest.
    pub fn supports(&self, directions: &[Point; WIDE_LANES]) -> (Reach, Reach) {
        let BodyPair { lanes, tool, mockup, .. } = self.pair;
        highest_and_lowest(*lanes, mockup.points, tool.points, directions)
    }

    /// The depths along eight directions, without the points.
    pub fn measure(&self, directions: &[Point; WIDE_LANES]) -> [TriedAxis; WIDE_LANES] {
        let BodyPair { lanes, tool, mockup, .. } = self.pair;
        let high = highest(*lanes, mockup.points, directions);
        let low = highest(*lanes, tool.points, &directions.map(|d| scaled(&d, -1.0)));
        from_fn(|i| TriedAxis { direction: directions[i], high: high[i], low: -low[i] })
    }

    /// The support point of the Minkowski difference along the `i`-th direction: from the tool's lowest point to the mock-up's
    /// highest. Its dot product with any other direction bounds the depth along that one from below.
    pub fn difference(&self, (high, low): &(Reach, Reach), i: usize) -> Point {
        sub(&self.pair.mockup.points[high.at[i] as usize], &self.pair.tool.points[low.at[i] as usize])
    }

    pub fn is_leading_out(&self, d: &Point) -> bool {
        is_leading_out(d, &self.pair.outward())
    }

    /// How much the two surfaces face the plane across `d`, as the sum of cosines: ranks axes where the two only touch, and the
    /// depth is nothing along all of them.
    fn facing(&self, d: &Point) -> f64 {
        let under = |n: &Point, s: f64| (-s * dot(n, d)).max(0.0);
        let of = |body: &Body<'_>, s: f64| body.facets.iter().map(|p| under(&p.normal, s)).sum::<f64>();
        of(self.pair.mockup, 1.0) + of(self.pair.tool, -1.0)
    }

    /// Offers directions in their order.
    pub fn offer_all(&mut self, list: &[Point]) {
        for some in list.chunks(WIDE_LANES) {
            for tried in &self.measure(&eight_of(some))[..some.len()] {
                self.offer(tried);
            }
        }
    }

    /// Makes an axis the best one if it is. Whether it is blocked is tested last, because that costs most.
    pub fn offer(&mut self, tried: &TriedAxis) -> bool {
        if let Some(best) = &self.best {
            let (depth, least) = (tried.depth(), best.depth());
            let is_less = depth < least - SHALLOWER * least.abs() - self.noise;
            if !is_less {
                let is_deep = depth > self.noise || least > self.noise;
                if is_deep || self.facing(&tried.direction) >= self.facing(&best.direction) - FACING_NOISE {
                    return false;
                }
            }
        }
        let is_better = !self.is_blocked(tried);
        if is_better {
            self.best = Some(*tried);
        }
        is_better
    }

    /// See [`BlockedAxes::is_blocked_by`], asked of both surfaces.
    pub fn is_blocked(&mut self, tried: &TriedAxis) -> bool {
        self.is_blocked_by(&Surface::BOTH, tried)
    }

    /// The same, asked of some surfaces.
    pub fn is_blocked_by(&mut self, surfaces: &[Surface], tried: &TriedAxis) -> bool {
        self.blocked.is_blocked_by(surfaces, self.pair, self.noise, tried)
    }

    /// Boxes around the mock-up's highest points and the tool's lowest, within a share of the depth.
    pub fn extreme_boxes(&mut self, axis: &TriedAxis, share: f64) -> (Aabb, Aabb) {
        let (d, tolerance) = (&axis.direction, share * axis.depth().abs() + self.noise);
        let BodyPair { lanes, tool, mockup, .. } = self.pair;
        let mut around = |body: &Body<'_>, d: &Point, height: f64| {
            let extreme = places_above(*lanes, body.point_eights, d, height - tolerance, &mut self.blocked.extreme);
            let last = body.points.len().saturating_sub(1);
            let mut bounds = Aabb::EMPTY;
            extreme.iter().for_each(|i| bounds.grow(&body.points[last.min(*i as usize)]));
            bounds
        };
        (around(mockup, d, axis.high), around(tool, &scaled(d, -1.0), -axis.low))
    }

    /// The contact point of an axis: the centre of the mock-up's highest part or of the tool's lowest, whichever is smaller,
    /// raised to the height of the mock-up. The centre of a box, since that does not depend on how finely the part is cut.
    pub fn contact_point(&mut self, axis: &TriedAxis) -> Point {
        let (above, below) = self.extreme_boxes(axis, POINT_SHARE);
        let chosen = centre(if length(&below.extent()) <= length(&above.extent()) { &below } else { &above });
        along(&chosen, axis.high - dot(&chosen, &axis.direction), &axis.direction)
    }
}
