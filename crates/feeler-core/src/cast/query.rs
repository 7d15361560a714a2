//! One cast.

use super::impact::{contact, Cast, Impact, Touching};
use super::sweep::{first_impact, impact_at, How, SweepMemory};
use crate::collide::query::CollideScratch;
use crate::geometry::bounds::Point;
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

/// The first impact of the tool on its way; `None` if the way is free. The tolerance is checked. `directions`: units,
/// world, along which the two are probably apart; they tell in the time alone.
pub fn cast(
    index: &Index,
    tool: &Tool,
    motion: &Motion,
    (tolerance, touching): (f64, Touching),
    directions: &[Point],
    scratch: &mut CastScratch,
) -> Option<Cast> {
    let CastScratch { sweep, collide } = scratch;
    let how = How { tolerance, touching, directions };
    let mut at = |time: f64| impact_at(index, tool, motion, touching, time, collide);
    let impact: Option<Impact> = if motion.is_still() {
        at(0.0)
    } else if touching != Touching::Free {
        first_impact(index, tool, motion, how, sweep, collide)
    } else {
        // Exact at both ends, and between them within the tolerance.
        at(0.0)
            .or_else(|| first_impact(index, tool, motion, how, sweep, collide))
            .or_else(|| impact_at(index, tool, motion, touching, 1.0, collide))
    };
    Some(contact(tool, index.mockup().mesh(), motion, &impact?))
}
