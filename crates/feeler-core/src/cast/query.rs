//! One cast.

use super::impact::{contact, Cast};
use super::sweep::{first_impact, impact_at_start, SweepMemory};
use crate::collide::query::CollideScratch;
use crate::geometry::pose::Pose;
use crate::index::mockup_index::Index;
use crate::tool::motion::Motion;
use crate::tool::moving_tool::Tool;

/// Working memory of one query at a time.
#[derive(Debug, Default)]
#[repr(align(128))] // as of a collision query
pub struct CastScratch {
    sweep: SweepMemory,
    collide: CollideScratch,
}

/// The first impact of the tool on its way between two poses; `None` if the way is free. The tolerance is checked.
pub fn cast(
    index: &Index,
    tool: &Tool,
    pose0: &Pose,
    pose1: &Pose,
    tolerance: f64,
    scratch: &mut CastScratch,
) -> Option<Cast> {
    let CastScratch { sweep, collide } = scratch;
    let motion = Motion::new(tool, pose0, pose1);
    let impact = if motion.is_still() {
        impact_at_start(index, tool, &motion, collide)
    } else {
        first_impact(index, tool, &motion, tolerance, sweep, collide)
    };
    Some(contact(tool, index.mockup().mesh(), &motion, &impact?))
}
