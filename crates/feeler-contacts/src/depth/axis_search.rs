//! The search for the axis of least depth: the best so far, and what is offered to it.

use std::array::from_fn;

use feeler_core::geometry::vectors::{along, dot, length, scaled, sub};
use feeler_core::{Aabb, Point};
use feeler_lanes::WIDE_LANES;

use crate::constants::SHALLOWER;
use crate::depth::axis::{eight_of, is_leading_out, middle, BodyPair, TriedAxis};
use crate::depth::axis_blocked::BlockedAxes;
use crate::patch::body::Body;
use crate::patch::support::{highest, highest_and_lowest, places_above, Reach};
use crate::surface::Surface;

/// The best direction so far.
pub(super) struct AxisSearch<'a> {
    pub pair: &'a BodyPair<'a>,
    /// Metres below which depths are the same.
    pub noise: f64,
    pub found: Option<TriedAxis>,
    pub blocked: &'a mut BlockedAxes,
}

impl<'a> AxisSearch<'a> {
    pub fn new(pair: &'a BodyPair<'a>, blocked: &'a mut BlockedAxes, found: Option<TriedAxis>) -> AxisSearch<'a> {
        let BodyPair { tool, mockup, .. } = pair;
        let noise = 1e-12 * tool.size.max(mockup.size).max(tool.largest);
        AxisSearch { pair, noise, found, blocked }
    }

    /// The depth from which on a direction is of no use; infinite where any is.
    pub fn limit(&self) -> f64 {
        match self.found {
            // Above the noise, where a depth of nothing is judged by the lean.
            Some(found) => {
                let least = found.depth();
                (least - SHALLOWER * least.abs() - self.noise).max(2.0 * self.noise) + self.noise
            }
            None => f64::INFINITY,
        }
    }

    /// The highest of the mock-up and the lowest of the tool.
    pub fn support(&self, directions: &[Point; WIDE_LANES]) -> (Reach, Reach) {
        let BodyPair { lanes, tool, mockup, .. } = self.pair;
        highest_and_lowest(*lanes, mockup.points, tool.points, directions)
    }

    /// The heights alone.
    pub fn tried(&self, directions: &[Point; WIDE_LANES]) -> [TriedAxis; WIDE_LANES] {
        let BodyPair { lanes, tool, mockup, .. } = self.pair;
        let high = highest(*lanes, mockup.points, directions);
        let low = highest(*lanes, tool.points, &directions.map(|d| scaled(&d, -1.0)));
        from_fn(|i| TriedAxis { direction: directions[i], high: high[i], low: -low[i] })
    }

    /// From the lowest place of the tool to the highest of the mock-up: no direction is less deep than that along it.
    pub fn way(&self, (high, low): &(Reach, Reach), i: usize) -> Point {
        sub(&self.pair.mockup.points[high.at[i] as usize], &self.pair.tool.points[low.at[i] as usize])
    }

    /// Whether going along `d` leads out.
    pub fn leads_out(&self, d: &Point) -> bool {
        is_leading_out(d, &self.pair.outward())
    }

    /// How far the two surfaces face into the plane across `d`, as the sum of cosines: tells directions apart where the two
    /// only touch, and every direction is as deep.
    fn lean(&self, d: &Point) -> f64 {
        let under = |n: &Point, s: f64| (-s * dot(n, d)).max(0.0);
        let of = |body: &Body<'_>, s: f64| body.facets.iter().map(|p| under(&p.normal, s)).sum::<f64>();
        of(self.pair.mockup, 1.0) + of(self.pair.tool, -1.0)
    }

    /// Tries directions in their order.
    pub fn try_all(&mut self, list: &[Point]) {
        for some in list.chunks(WIDE_LANES) {
            for tried in &self.tried(&eight_of(some))[..some.len()] {
                self.offer(tried);
            }
        }
    }

    /// Whether a direction is the best now.
    pub fn offer(&mut self, tried: &TriedAxis) -> bool {
        if let Some(found) = &self.found {
            let (depth, least) = (tried.depth(), found.depth());
            let is_less = depth < least - SHALLOWER * least.abs() - self.noise;
            if !is_less {
                let is_deep = depth > self.noise || least > self.noise;
                if is_deep || self.lean(&tried.direction) >= self.lean(&found.direction) - 1e-6 {
                    return false;
                }
            }
        }
        let is_better = !self.goes_on(tried);
        if is_better {
            self.found = Some(*tried);
        }
        is_better
    }

    /// Boxes around the highest of the mock-up's points and the lowest of the tool's, within a share of the depth.
    pub fn extremes(&mut self, found: &TriedAxis, share: f64) -> (Aabb, Aabb) {
        let (d, tolerance) = (&found.direction, share * found.depth().abs() + self.noise);
        let BodyPair { lanes, tool, mockup, .. } = self.pair;
        let mut reach = |body: &Body<'_>, d: &Point, height: f64| {
            let places = places_above(*lanes, body.point_eights, d, height - tolerance, &mut self.blocked.places);
            let last = body.points.len().saturating_sub(1);
            let mut bounds = Aabb::EMPTY;
            places.iter().for_each(|i| bounds.grow(&body.points[last.min(*i as usize)]));
            bounds
        };
        (reach(mockup, d, found.high), reach(tool, &scaled(d, -1.0), -found.low))
    }

    /// The middle of the highest part of the mock-up or of the lowest of the tool, whichever is smaller, raised to the height
    /// of the mock-up. The middle of a box around them, which does not know how many triangles make them up.
    pub fn place(&mut self, found: &TriedAxis) -> Point {
        let (above, below) = self.extremes(found, 1e-3);
        let chosen = middle(if length(&below.extent()) <= length(&above.extent()) { &below } else { &above });
        along(&chosen, found.high - dot(&chosen, &found.direction), &found.direction)
    }
}

impl AxisSearch<'_> {
    /// See [`BlockedAxes::goes_on_of`], asked of both surfaces.
    pub fn goes_on(&mut self, tried: &TriedAxis) -> bool {
        self.goes_on_of(&Surface::BOTH, tried)
    }

    /// The same, asked of the surface of the tool or of the mock-up alone.
    pub fn goes_on_of(&mut self, sides: &[Surface], tried: &TriedAxis) -> bool {
        self.blocked.goes_on_of(self.pair, self.noise, sides, tried)
    }
}
