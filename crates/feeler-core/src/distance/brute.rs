//! The plain twin of all searches for distances: every pair, no index.

use super::gap::Gap;
use crate::geometry::distance_triangle_triangle::closest_triangle_triangle;
use crate::geometry::pose::Pose;
use crate::mesh::mockup::Mockup;
use crate::tool::moving_tool::Tool;

/// Every pair of triangles with a distance of at most `within` (metres); sorted like
/// [`Scene::near_pairs`](crate::Scene::near_pairs).
pub fn gaps_of_all_pairs(mockup: &Mockup, tool: &Tool, pose: &Pose, within: f64) -> Vec<Gap> {
    let mut gaps = Vec::new();
    for t in tool.mesh().queried() {
        let p = pose.apply_triangle(&tool.mesh().triangle(t));
        for m in mockup.mesh().queried() {
            let closest = closest_triangle_triangle(&p, &mockup.mesh().triangle(m));
            if closest.distance <= within {
                gaps.push(Gap {
                    tool_triangle: t,
                    mockup_triangle: m,
                    part: mockup.part_of_face(m),
                    tool_part: tool.part_of_face(t),
                    distance: closest.distance,
                    on_tool: closest.on_p,
                    on_mockup: closest.on_q,
                });
            }
        }
    }
    gaps.sort_by(Gap::order);
    gaps
}
