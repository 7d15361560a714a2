//! Axes: the directions along which two bodies may be separated, and the supports of both along one.

use std::array::from_fn;

use feeler_core::geometry::vectors::{add, dot, scaled};
use feeler_core::{Aabb, Point};
use feeler_lanes::{Checked, WIDE_LANES};

use crate::constants::AGAINST_NORMAL;
use crate::contour::contact_region::ContactRegions;
use crate::patch::body::{edge_count, Body};
use crate::patch::support::highest_of_eights;

/// An axis that was tried: a unit direction from the mock-up to the tool, and the supports of both along it.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct TriedAxis {
    pub direction: Point,
    /// Height of the mock-up's highest point, metres.
    pub high: f64,
    /// Height of the tool's lowest point, metres.
    pub low: f64,
}

impl TriedAxis {
    /// How far the tool has to move along the axis until a plane across it separates the two, metres.
    pub fn depth(&self) -> f64 {
        self.high - self.low
    }
}

/// A body of the tool and one of the mock-up in the same contact region.
#[derive(Clone, Copy)]
pub(crate) struct BodyPair<'a> {
    pub lanes: Checked,
    pub regions: &'a ContactRegions,
    pub tool: &'a Body<'a>,
    pub mockup: &'a Body<'a>,
}

impl BodyPair<'_> {
    /// Height of the mock-up's highest point along a direction.
    pub fn high(&self, direction: &Point) -> f64 {
        highest_of_eights(self.lanes, self.mockup.point_eights, direction)
    }

    /// Height of the tool's lowest point along a direction.
    pub fn low(&self, direction: &Point) -> f64 {
        -highest_of_eights(self.lanes, self.tool.point_eights, &scaled(direction, -1.0))
    }

    /// Pairs of an edge of each.
    pub fn edge_pairs(&self) -> usize {
        edge_count(self.mockup.facets.len()) * edge_count(self.tool.facets.len())
    }

    /// The mean normals of both, from the mock-up to the tool: an axis against one of them leads in.
    pub fn outward(&self) -> [Point; 2] {
        [self.mockup.mean, scaled(&self.tool.mean, -1.0)]
    }
}

/// Eight directions of a list; the last is repeated where there are fewer.
pub(super) fn eight_of(list: &[Point]) -> [Point; WIDE_LANES] {
    from_fn(|i| list[i.min(list.len() - 1)])
}

/// Whether a direction clearly points against another.
pub(super) fn is_against(d: &Point, other: &Point) -> bool {
    dot(d, other) <= -AGAINST_NORMAL
}

/// Whether an axis leads out: it is against neither mean normal.
pub(super) fn is_leading_out(d: &Point, outward: &[Point; 2]) -> bool {
    (*d != [0.0; 3]) & !is_against(d, &outward[0]) & !is_against(d, &outward[1])
}

pub(super) fn centre(b: &Aabb) -> Point {
    scaled(&add(&b.lower, &b.upper), 0.5)
}
