//! One cast.

use super::impact::{contact, Cast, Touching};
use super::sweep::{first_impact, impact_at, SweepMemory};
use crate::collide::query::CollideScratch;
use crate::error::Result;
use crate::index::mockup_index::Index;
use crate::tool::motion::Motion;
use crate::tool::moving_tool::Tool;

pub use super::sweep::How;

/// Working memory of one query at a time.
#[derive(Debug, Default)]
#[repr(align(128))] // as of a collision query
pub struct CastScratch {
    sweep: SweepMemory,
    collide: CollideScratch,
}

/// The first impact of the tool on its way; `None` if the way is free. The tolerance is checked. An error: a request to stop.
pub fn cast(
    index: &Index,
    tool: &Tool,
    motion: &Motion,
    how: How<'_>,
    scratch: &mut CastScratch,
) -> Result<Option<Cast>> {
    let CastScratch { sweep, collide } = scratch;
    let is_exact_at_ends = how.touching == Touching::Free;
    let mut impact = None;
    if motion.is_still() || is_exact_at_ends {
        impact = impact_at(index, tool, motion, how.touching, 0.0, collide);
    }
    if !motion.is_still() && impact.is_none() {
        // Between the ends within the tolerance.
        impact = first_impact(index, tool, motion, how, sweep, collide)?;
        if is_exact_at_ends && impact.is_none() {
            impact = impact_at(index, tool, motion, how.touching, 1.0, collide);
        }
    }
    Ok(impact.map(|impact| contact(tool, index.mockup().mesh(), motion, &impact)))
}
