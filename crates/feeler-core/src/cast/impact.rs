//! The first impact of a motion, with its details.

use super::pair::Moving;
use crate::error::{Error, Result};
use crate::geometry::bounds::Point;
use crate::geometry::distance_triangle_triangle::closest_triangle_triangle;
use crate::geometry::pose::Pose;
use crate::mesh::triangle_mesh::Mesh;
use crate::tool::motion::Motion;
use crate::tool::moving_tool::Tool;

/// The first impact on a way.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Cast {
    /// The free fraction of the motion, from 0 to 1: nothing collides before it.
    pub fraction: f64,
    /// The tool's pose then.
    pub pose: Pose,
    /// On the mock-up's triangle where the two are closest, or a point they share; metres, world.
    pub point: Point,
    /// Unit normal at the contact, from mock-up to tool.
    pub normal: Point,
    /// The remaining distance of the two triangles at the pose, metres: at most the tolerance; 0 if they collide.
    pub distance: f64,
    /// The tool's triangle.
    pub tool_triangle: u32,
    /// The mock-up's triangle.
    pub mockup_triangle: u32,
}

/// The condition that ends a motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Touching {
    /// The first pair of triangles that meets.
    #[default]
    Ends,
    /// The first pair at which one body enters the other: surfaces may lie on each other and slide along each other, within the
    /// tolerance. At the given poses it is decided exactly, as by [`Scene::is_entering`](crate::Scene::is_entering).
    Free,
    /// As [`Free`](Self::Free), and at the given poses, too, it is decided within the tolerance: for ways that begin or end where bodies
    /// are in each other by rounding, as those that lie on each other do at most poses. Such bodies part freely; a slide may end early,
    /// where it comes to another triangle.
    Within,
}

/// When a pair meets first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Impact {
    pub time: f64,
    pub tool_triangle: u32,
    pub mockup_triangle: u32,
}

/// The cast that ends with an impact.
pub(super) fn contact(tool: &Tool, mesh: &Mesh, motion: &Motion, impact: &Impact) -> Cast {
    let Impact { time, tool_triangle, mockup_triangle } = *impact;
    let (p, q) = (tool.mesh().triangle(tool_triangle), mesh.triangle(mockup_triangle));
    let pose = motion.at(time);
    let closest = closest_triangle_triangle(&pose.apply_triangle(&p), &q);
    Cast {
        fraction: time,
        pose,
        point: closest.on_q,
        // No negative zeros.
        normal: Moving::new(motion, p, &motion.during(time, time)).normal(&q, time).map(|x| x + 0.0),
        distance: closest.distance,
        tool_triangle,
        mockup_triangle,
    }
}

/// Refuses a tolerance that is not positive and finite.
pub(crate) fn check_tolerance(value: f64) -> Result<()> {
    if value.is_finite() && value > 0.0 {
        Ok(())
    } else {
        Err(Error::Tolerance { value })
    }
}
