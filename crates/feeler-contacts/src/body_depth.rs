//! How deep two bodies of a set are in each other.

use std::sync::Arc;

use feeler_core::{Bodies, GoOn, Point, Result, ToolAndMockup, Who};

use crate::escape::penetration::PenetrationKind;
use crate::solver::ContactSolver;

/// The shortest translation found that parts two bodies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BodyDepth {
    /// Metres, world: it parts the second body from the first.
    pub translation: Point,
    /// Its length, metres; the bodies are at most so deep in each other.
    pub depth: f64,
    /// How it was found.
    pub kind: PenetrationKind,
}

/// The depth of two bodies that meet, by [`ContactSolver::penetration`]; 0 for others. Errors: no such body, and the request to stop.
pub fn body_depth(bodies: &Bodies, who: Who<'_>, pair: [u32; 2], go_on: GoOn<'_>) -> Result<BodyDepth> {
    let ToolAndMockup { scene, tool, pose, frame, is_turned } = bodies.as_tool_and_mockup(who, pair)?;
    let found = ContactSolver::new(Arc::clone(&scene)).stoppable(go_on).penetration(&tool, &pose, 0.0, None)?;
    let sense = if is_turned { 1.0 } else { -1.0 };
    let row = |i: usize| (0..3).map(|k| frame.rotation()[i][k] * found.translation[k]).sum::<f64>();
    let translation = std::array::from_fn(|i| sense * row(i));
    Ok(BodyDepth { translation, depth: found.depth, kind: found.kind })
}
