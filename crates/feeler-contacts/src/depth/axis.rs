//! Axes: directions along which two bodies may be moved apart.

use std::array::from_fn;

use feeler_core::geometry::vectors::{add, scaled};
use feeler_core::{Aabb, Point};
use feeler_lanes::{Checked, WIDE_LANES};

use crate::contour::contact_region::ContactRegions;
use crate::depth::gauss_arcs::is_against;
use crate::patch::body::{edge_count, Body};
use crate::patch::support::highest_of_eights;

/// A direction, and how high the mock-up and how low the tool is along it.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct TriedAxis {
    pub direction: Point,
    pub high: f64,
    pub low: f64,
}

impl TriedAxis {
    pub fn depth(&self) -> f64 {
        self.high - self.low
    }
}

/// Two bodies that cut each other.
#[derive(Clone, Copy)]
pub(crate) struct BodyPair<'a> {
    pub lanes: Checked,
    pub regions: &'a ContactRegions,
    pub tool: &'a Body<'a>,
    pub mockup: &'a Body<'a>,
}

impl BodyPair<'_> {
    pub fn high(&self, normal: &Point) -> f64 {
        highest_of_eights(self.lanes, self.mockup.point_eights, normal)
    }

    pub fn low(&self, normal: &Point) -> f64 {
        -highest_of_eights(self.lanes, self.tool.point_eights, &scaled(normal, -1.0))
    }

    /// Pairs of an edge of each.
    pub fn edge_pairs(&self) -> usize {
        edge_count(self.mockup.facets.len()) * edge_count(self.tool.facets.len())
    }

    /// The means of what the surfaces face: what is against one of them leads in.
    pub fn outward(&self) -> [Point; 2] {
        [self.mockup.mean, scaled(&self.tool.mean, -1.0)]
    }
}

/// Eight directions of a list, the last one several times where there are fewer.
pub(super) fn eight_of(list: &[Point]) -> [Point; WIDE_LANES] {
    from_fn(|i| list[i.min(list.len() - 1)])
}

pub(super) fn is_leading_out(d: &Point, outward: &[Point; 2]) -> bool {
    (*d != [0.0; 3]) & !is_against(d, &outward[0]) & !is_against(d, &outward[1])
}

pub(super) fn middle(b: &Aabb) -> Point {
    scaled(&add(&b.lower, &b.upper), 0.5)
}
