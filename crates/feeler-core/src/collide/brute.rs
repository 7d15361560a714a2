//! The plain twin of every store: all pairs, no index.

use crate::geometry::intersect_triangle_triangle::{intersect_triangle_triangle, PairKind};
use crate::geometry::pose::Pose;
use crate::mesh::triangle_mesh::Mesh;
use crate::tool::moving_tool::Tool;

/// Tests every tool triangle against every mock-up triangle; sorted like [`Scene::collide`](crate::Scene::collide).
pub fn collide_all_pairs(mesh: &Mesh, tool: &Tool, pose: &Pose) -> Vec<([u32; 2], PairKind)> {
    let mut found = Vec::new();
    for t in tool.mesh().queried() {
        let p = pose.apply_triangle(&tool.mesh().triangle(t));
        for s in mesh.queried() {
            if let Some(kind) = intersect_triangle_triangle(&p, &mesh.triangle(s)) {
                found.push(([t, s], kind));
            }
        }
    }
    found
}
