//! The distance of a tool triangle and a mock-up triangle.

use crate::geometry::bounds::Point;

/// How far a triangle of the tool is from one of the mock-up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gap {
    /// The tool's triangle.
    pub tool_triangle: u32,
    /// The mock-up's triangle.
    pub mockup_triangle: u32,
    /// The part the mock-up's triangle belongs to.
    pub part: u32,
    /// The tool's part that its triangle belongs to.
    pub tool_part: u32,
    /// Metres; 0 if and only if the triangles collide.
    pub distance: f64,
    /// The point of the tool's triangle that is closest to the other, world, metres.
    pub on_tool: Point,
    /// The point of the mock-up's triangle that is closest to the other, world, metres.
    pub on_mockup: Point,
}

impl Gap {
    /// The order of results: by distance, then by ids.
    pub(crate) fn order(&self, other: &Gap) -> std::cmp::Ordering {
        let ids = |gap: &Gap| (gap.tool_triangle, gap.mockup_triangle);
        self.distance.total_cmp(&other.distance).then_with(|| ids(self).cmp(&ids(other)))
    }
}
