//! The segments of a cut.

use crate::geometry::bounds::Point;

/// The segments of all triangles that a plane cuts, sorted by triangle: see [`Scene::section`](crate::Scene::section).
#[derive(Debug, Clone, Default, PartialEq)]
#[non_exhaustive]
pub struct SectionOutline {
    /// Both ends of each, world, metres.
    pub segments: Vec<[Point; 2]>,
    /// The triangle that each is of.
    pub triangles: Vec<u32>,
    /// And its part.
    pub parts: Vec<u32>,
}
