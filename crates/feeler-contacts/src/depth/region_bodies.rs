//! The bodies of tool and mock-up in one contact region, and which of them collide.

use feeler_core::geometry::vectors::scaled;

use crate::containers::bit_set::{is_meeting, shared};
use crate::context::QueryContext;
use crate::contour::contact_region::ContactRegions;
use crate::depth::axis::BodyPair;
use crate::depth::least_depth::Depth;
use crate::patch::body::{Bodies, Body, Facets};
use crate::surface::Surface;

/// The bodies of one region. A pair of them is given by their numbers, the tool's first.
pub(crate) struct RegionBodies<'a> {
    pub context: &'a QueryContext<'a>,
    regions: &'a ContactRegions,
    bodies: &'a [Bodies; 2],
    each: [Vec<Body<'a>>; 2],
}

impl<'a> RegionBodies<'a> {
    pub fn new(
        context: &'a QueryContext<'a>,
        regions: &'a ContactRegions,
        bodies: &'a [Bodies; 2],
    ) -> RegionBodies<'a> {
        let each = bodies.each_ref().map(|of| (0..of.len()).map(|i| of.get(i)).collect());
        RegionBodies { context, regions, bodies, each }
    }

    /// How many there are of tool and mock-up.
    pub fn counts(&self) -> [usize; 2] {
        self.each.each_ref().map(Vec::len)
    }

    pub fn pair(&self, [t, m]: [usize; 2]) -> BodyPair<'_> {
        let (tool, mockup) = (&self.each[Surface::Tool][t], &self.each[Surface::Mockup][m]);
        BodyPair { lanes: self.context.lanes, regions: self.regions, tool, mockup }
    }

    /// The triangles of two bodies that face each other most along the normal of a plane between them.
    pub fn carriers(&self, depth: &Depth) -> Option<[u32; 2]> {
        let ([t, m], normal) = (depth.bodies, depth.normal());
        let (tool, mockup) = (&self.each[Surface::Tool][t], &self.each[Surface::Mockup][m]);
        Some([tool.triangle_facing(&scaled(&normal, -1.0))?, mockup.triangle_facing(&normal)?])
    }

    /// All that the mock-up has in the region.
    pub fn whole_mockup(&self) -> Facets<'_> {
        self.bodies[Surface::Mockup].all()
    }

    pub fn share_segments(&self, [t, m]: [usize; 2]) -> bool {
        is_meeting(self.bodies[Surface::Tool].segments.get(t), self.bodies[Surface::Mockup].segments.get(m))
    }

    /// The segments that both are on, by their places in the region.
    pub fn segments_of(&self, [t, m]: [usize; 2]) -> impl Iterator<Item = usize> + 'a {
        shared(self.bodies[Surface::Tool].segments.get(t), self.bodies[Surface::Mockup].segments.get(m))
    }

    /// Whether one of the two is off the contour, enclosed by others of its surface: it collides with the same bodies.
    pub fn is_walled_in(&self, [t, m]: [usize; 2]) -> bool {
        !(self.bodies[Surface::Tool].is_on_contour(t) && self.bodies[Surface::Mockup].is_on_contour(m))
    }
}
