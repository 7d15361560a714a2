//! Continuous collision: when, on its way from one pose to another, a tool first meets the mock-up.
//!
//! The time given is never late: at no earlier time does any pair of triangles meet. It is early by at most a tolerance in
//! metres: at the pose given the pair named is at most that far apart.

mod brute;
mod motion;
mod pair;
mod path;
mod sweep;

pub use brute::cast_all_pairs;
pub use motion::Motion;
pub(crate) use motion::Window;
pub use path::PathCheck;
pub(crate) use sweep::CastScratch;

use crate::bounds::Point;
use crate::distance_triangle_triangle::closest_triangle_triangle;
use crate::error::{Error, Result};
use crate::mesh::Mesh;
use crate::pose::Pose;
use crate::scene::Scene;
use crate::tool::Tool;
use pair::Moving;

/// The first impact on a way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cast {
    /// The time, from 0 to 1.
    pub fraction: f64,
    /// The tool's pose then.
    pub pose: Pose,
    /// On the mock-up's triangle where the two are closest, or a point they share; metres, world.
    pub point: Point,
    /// Unit normal at the contact, from mock-up to tool.
    pub normal: Point,
    /// How far apart the two triangles are at the pose, metres: at most the tolerance; 0 where they meet.
    pub distance: f64,
    /// The tool's triangle.
    pub tool_triangle: u32,
    /// The mock-up's triangle.
    pub mockup_triangle: u32,
}

impl Scene {
    /// The first impact of the tool on its [way](Motion) between two poses; `None` if the way is free.
    ///
    /// `tolerance` (metres): how far before the impact the pose given may lie, as a distance of the two triangles. A tool that
    /// passes by nearer than that may count as one that hits. Where the two poses are equal the answer is that of
    /// [`Scene::collide`], exact. Errors: a tolerance that is not positive and finite.
    pub fn cast(&self, tool: &Tool, pose0: &Pose, pose1: &Pose, tolerance: f64) -> Result<Option<Cast>> {
        check_tolerance(tolerance)?;
        let mut scratch = self.take_scratch();
        let found = self.cast_with(tool, pose0, pose1, tolerance, &mut scratch.cast);
        self.put_scratch(scratch);
        Ok(found)
    }

    fn cast_with(
        &self,
        tool: &Tool,
        pose0: &Pose,
        pose1: &Pose,
        tolerance: f64,
        scratch: &mut CastScratch,
    ) -> Option<Cast> {
        let motion = Motion::new(tool, pose0, pose1);
        let mesh = self.mockup().mesh();
        let impact = if motion.is_still() {
            impact_at_start(self, tool, &motion)
        } else {
            sweep::first_impact(self, tool, &motion, tolerance, scratch)
        };
        Some(contact(tool, mesh, &motion, &impact?))
    }
}

/// When a pair meets first.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Impact {
    time: f64,
    tool_triangle: u32,
    mockup_triangle: u32,
}

/// A pair that meets at the beginning, exactly.
fn impact_at_start(scene: &Scene, tool: &Tool, motion: &Motion) -> Option<Impact> {
    let [tool_triangle, mockup_triangle] = scene.any_pair(tool, &motion.at(0.0))?;
    Some(Impact { time: 0.0, tool_triangle, mockup_triangle })
}

fn contact(tool: &Tool, mesh: &Mesh, motion: &Motion, impact: &Impact) -> Cast {
    let Impact { time, tool_triangle, mockup_triangle } = *impact;
    let (p, q) = (tool.mesh().triangle(tool_triangle), mesh.triangle(mockup_triangle));
    let pose = motion.at(time);
    let closest = closest_triangle_triangle(&pose.apply_triangle(&p), &q);
    Cast {
        fraction: time,
        pose,
        point: closest.on_q,
        // No negative zeros.
        normal: Moving::new(motion, p).normal(&q, time).map(|x| x + 0.0),
        distance: closest.distance,
        tool_triangle,
        mockup_triangle,
    }
}

fn check_tolerance(value: f64) -> Result<()> {
    if value.is_finite() && value > 0.0 {
        Ok(())
    } else {
        Err(Error::Tolerance { value })
    }
}
