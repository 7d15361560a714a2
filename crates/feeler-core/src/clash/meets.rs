//! How two parts collide, and where they touch.

use super::asked::in_order;
use crate::geometry::intersect_triangle_triangle::PairKind;
use crate::mesh::mockup::Mockup;

/// How two parts collide.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Meets {
    /// Triangles touch or lie in one plane, and none cross.
    Touching,
    /// Some cross.
    Crossing,
}

/// Two colliding parts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MeetingParts {
    /// The lesser first.
    pub parts: [u32; 2],
    /// How.
    pub meets: Meets,
}

/// Two triangles that touch or lie in one plane.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Touch {
    /// The lesser first.
    pub parts: [u32; 2],
    /// A triangle of each.
    pub triangles: [u32; 2],
    /// The kind of contact: not crossing.
    pub kind: PairKind,
}

impl Touch {
    pub(crate) fn new(mockup: &Mockup, triangles: [u32; 2], kind: PairKind) -> Touch {
        let [a, b] = triangles.map(|t| mockup.part_of_face(t));
        let [t, u] = triangles;
        Touch { parts: in_order([a, b]), triangles: if a < b { [t, u] } else { [u, t] }, kind }
    }
}
