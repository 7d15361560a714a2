//! The depth of a tool in each part that it collides with, or that contains it.

use std::cmp::Ordering;
use std::collections::BTreeSet;

use feeler_core::{closest_triangle_triangle, Collision, GoOn, Mockup, Point, Pose, Scene, Tool};

use super::bodies::Bodies;
use super::body::Body;
use super::crossing::crossing_depth;
use super::depth::{point_depth_while, DepthKind};
use crate::containment::find::containment;

/// How deep a tool is in a part.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct PartDepth {
    /// Of the mock-up.
    pub part: u32,
    /// Of the tool: the one that is deepest in that.
    pub tool_part: u32,
    /// The farthest that a point of one surface is inside the other part, metres: a lower bound. 0 where they only touch.
    pub depth: f64,
    /// How much more it can be, metres: no more than a thousandth of it, or a nanometre; NaN of two open surfaces.
    pub error: f64,
    /// The kind of the depth.
    pub kind: DepthKind,
    /// The point of the tool and that of the part where that is, world, metres.
    pub points: [Point; 2],
}

/// See [`ContactSolver::depths`](crate::ContactSolver::depths). Where it is stopped, some of them.
pub(crate) fn depths(scene: &Scene, bodies: &Bodies, tool: &Tool, pose: &Pose, go_on: GoOn<'_>) -> Vec<PartDepth> {
    let mockup = scene.mockup();
    let Ok(Collision { pairs: hits, .. }) = scene.stoppable(go_on).collide(tool, pose) else { return Vec::new() };
    let parts_of = |[t, m]: [u32; 2]| [mockup.part_of_face(m), tool.part_of_face(t)];
    let mut pairs: BTreeSet<[u32; 2]> = hits.iter().map(|hit| parts_of(*hit)).collect();
    let inside = containment(scene, tool, pose, go_on);
    pairs.extend(inside.containing.iter().chain(&inside.contained).map(|[tool_part, part]| [*part, *tool_part]));
    let mut found: Vec<PartDepth> = Vec::new();
    let mut own: Vec<Option<Body>> = (0..tool.parts()).map(|_| None).collect();
    for pair in pairs {
        if !go_on.goes_on() {
            break;
        }
        let [part, tool_part] = pair;
        let body = bodies.of(part, || body_of_part(mockup, part));
        let tool_body = own[tool_part as usize].get_or_insert_with(|| body_of_tool(tool, pose, tool_part));
        let has_inside = tool_body.is_closed() || body.is_closed();
        let pair = [&*tool_body, &body];
        let measured = if has_inside { point_depth_while(pair, go_on) } else { crossing_depth(pair) };
        let points = measured.points.or_else(|| {
            // Where they only touch.
            let [t, m] = *hits.iter().find(|hit| parts_of(**hit) == [part, tool_part])?;
            let closest =
                closest_triangle_triangle(&pose.apply_triangle(&tool.mesh().triangle(t)), &mockup.mesh().triangle(m));
            Some([closest.on_p, closest.on_q])
        });
        let is_measured = !tool.adjacency().is_open(tool_part) && !mockup.adjacency().is_open(part);
        let new = PartDepth {
            part,
            tool_part,
            depth: measured.depth,
            error: measured.error,
            kind: if is_measured { DepthKind::Measured } else { DepthKind::Estimate },
            points: points.unwrap_or_default(),
        };
        match found.last_mut().filter(|last| last.part == part) {
            Some(last) if new.depth > last.depth => *last = new,
            Some(_) => {}
            None => found.push(new),
        }
    }
    found.sort_by(|p, q| match q.depth.total_cmp(&p.depth) {
        Ordering::Equal => p.part.cmp(&q.part),
        other => other,
    });
    found
}

fn body_of_part(mockup: &Mockup, part: u32) -> Body {
    let mesh = mockup.mesh();
    let faces: Vec<u32> = mesh.queried().filter(|face| mockup.part_of_face(*face) == part).collect();
    Body::new(faces.iter().map(|face| (*face, mesh.triangle(*face))), mockup.adjacency())
}

fn body_of_tool(tool: &Tool, pose: &Pose, part: u32) -> Body {
    let mesh = tool.mesh();
    let faces: Vec<u32> = mesh.queried().filter(|face| tool.part_of_face(*face) == part).collect();
    Body::new(faces.iter().map(|face| (*face, pose.apply_triangle(&mesh.triangle(*face)))), tool.adjacency())
}
