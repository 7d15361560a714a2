//! The contact planes of an answer.

use std::cmp::Ordering;

use feeler_core::{Point, Tool};
use feeler_lanes::{Checked, Sorter};

use crate::constants::MOST_PLANES;

/// A plane between the mock-up and the tool.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct ContactPlane {
    /// On the mock-up's surface, metres, world.
    pub point: Point,
    /// Unit, from the mock-up to the tool.
    pub normal: Point,
    /// Distance of the tool from the plane along the normal, metres; negative: its depth behind it or, where both
    /// surfaces are concave, their overlap along the normal.
    pub gap: f64,
    /// The part of the mock-up.
    pub part: u32,
    /// Triangles of the tool behind it, sorted.
    pub tool_triangles: Vec<u32>,
    /// Triangles of the mock-up behind it, sorted.
    pub mockup_triangles: Vec<u32>,
    /// The same for the same two surfaces from pose to pose: a hash of the part, the convex body of the mock-up and that of the tool,
    /// and, where these have several planes in one answer, of their order.
    pub id: u64,
    /// A triangle of the tool and one of the mock-up, of the surfaces that carry the contact.
    pub(crate) carriers: [u32; 2],
    /// Whether the side of the surface that it is on had to be assumed: a plane of a pierced surface.
    pub(crate) assumed: bool,
}

/// The contact planes at one pose.
#[derive(Debug, Clone, Default, PartialEq)]
#[non_exhaustive]
pub struct Contacts {
    /// Deepest first, at most [`MOST_PLANES`].
    pub planes: Vec<ContactPlane>,
    /// Number of planes left out beyond [`MOST_PLANES`], the least deep or farthest. Near surfaces are not searched if
    /// [`MANY_DEEP`](crate::MANY_DEEP) planes are deep, and not completely if more than [`FEW_DEEP`](crate::FEW_DEEP)
    /// are.
    pub omitted: usize,
    /// Whether any triangles collide.
    pub is_meeting: bool,
}

/// The order of points by their coordinates.
pub(crate) fn by_coordinates(p: &Point, q: &Point) -> Ordering {
    (0..3).map(|a| p[a].total_cmp(&q[a])).find(|o| o.is_ne()).unwrap_or(Ordering::Equal)
}

impl ContactPlane {
    /// The tool's part that it is of.
    pub fn tool_part(&self, tool: &Tool) -> u32 {
        tool.part_of_face(self.carriers[0])
    }

    pub(crate) fn order(&self, other: &ContactPlane) -> Ordering {
        (self.gap.total_cmp(&other.gap))
            .then(self.part.cmp(&other.part))
            .then_with(|| by_coordinates(&self.normal, &other.normal))
            .then_with(|| by_coordinates(&self.point, &other.point))
    }
}

impl Contacts {
    /// Leaves out the planes beyond the most, of those in order, and gives each its triangles once.
    pub(crate) fn finish(&mut self, lanes: Checked, sorter: &mut Sorter) {
        self.omitted = self.planes.len().saturating_sub(MOST_PLANES);
        self.planes.truncate(MOST_PLANES);
        for plane in &mut self.planes {
            for ids in [&mut plane.tool_triangles, &mut plane.mockup_triangles] {
                sorter.clear();
                // Those of one triangle mostly come one after the other.
                sorter.keys.extend(ids.chunk_by(|a, b| a == b).map(|same| u64::from(same[0])));
                sorter.sort(lanes);
                ids.clear();
                ids.extend(sorter.sorted().iter().map(|id| *id as u32));
            }
        }
    }

    /// The largest penetration, metres; 0 where nothing is deep.
    pub fn depth(&self) -> f64 {
        self.planes.first().map_or(0.0, |p| (-p.gap).max(0.0))
    }
}
