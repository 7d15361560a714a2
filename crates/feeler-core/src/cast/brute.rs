//! The plain twin of the cast: conservative advancement of every pair, over the whole way, no index.

use super::impact::{check_tolerance, contact, Cast, Impact};
use super::pair::Moving;
use crate::error::Result;
use crate::mesh::triangle_mesh::Mesh;
use crate::tool::motion::Motion;
use crate::tool::moving_tool::Tool;

/// As [`Scene::cast_along`](crate::Scene::cast_along), by looking at every pair of triangles.
pub fn cast_all_pairs(mesh: &Mesh, tool: &Tool, motion: &Motion, tolerance: f64) -> Result<Option<Cast>> {
    check_tolerance(tolerance)?;
    let start = motion.at(0.0);
    let during = motion.during(0.0, 1.0);
    let mut best: Option<Impact> = None;
    for tool_triangle in tool.mesh().queried() {
        let moving = Moving::new(motion, tool.mesh().triangle(tool_triangle), &during);
        for mockup_triangle in mesh.queried() {
            let q = mesh.triangle(mockup_triangle);
            let until = best.map_or(1.0, |b| b.time);
            if let Some(time) = moving.first_impact(&q, 0.0, until, &start, tolerance) {
                best = Some(Impact { time, tool_triangle, mockup_triangle });
            }
        }
    }
    Ok(best.map(|impact| contact(tool, mesh, motion, &impact)))
}
