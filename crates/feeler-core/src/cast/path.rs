//! A whole path: each segment separately, in parallel.

use rayon::prelude::*;

use super::impact::{check_tolerance, Cast};
use super::options::PathOptions;
use super::query::{cast, CastScratch, How};
use crate::error::Result;
use crate::index::mockup_index::Index;
use crate::scratch_pool::ScratchPool;
use crate::tool::motion::Motion;
use crate::tool::moving_tool::Tool;

/// The impacts on a path; [`hits`](Self::hits) is empty if it is free.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct PathCheck {
    /// Segments: one less than poses; a path of one pose has one segment that stands still.
    pub segments: usize,
    /// The first impact of each segment that has one, with the segment's number; ascending.
    pub hits: Vec<(usize, Cast)>,
}

/// One cast for each motion, in parallel on the current rayon pool.
///
/// Every segment is looked at, also those after an impact. `progress` is called after each wave of segments. Errors: as
/// `cast`, and a request to stop.
pub(crate) fn check_path(
    index: &Index,
    pool: &ScratchPool<CastScratch>,
    tool: &Tool,
    (segments, motion): (usize, &(dyn Fn(usize) -> Motion + Sync)),
    options: &PathOptions<'_>,
) -> Result<PathCheck> {
    const PATH_WAVE: usize = 2048;
    const PATH_TASK: usize = 8;
    let PathOptions { tolerance, touching, progress, go_on } = *options;
    check_tolerance(tolerance)?;
    let mut hits = Vec::new();
    let numbers: Vec<usize> = (0..segments.min(PATH_WAVE)).collect();
    for start in (0..segments).step_by(PATH_WAVE) {
        progress.report(start as f64 / segments as f64, "casting")?;
        let wave = &numbers[..PATH_WAVE.min(segments - start)];
        let found: Vec<Vec<(usize, Cast)>> = wave
            .par_chunks(PATH_TASK)
            .map(|task| {
                let mut scratch = pool.take();
                let how = How { tolerance, touching, directions: &[], goes_on: go_on.function() };
                let hits = task
                    .iter()
                    .filter_map(|i| {
                        let segment = start + i;
                        let found = cast(index, tool, &motion(segment), how, &mut scratch).transpose()?;
                        Some(found.map(|found| (segment, found)))
                    })
                    .collect();
                pool.put(scratch);
                hits
            })
            .collect::<Result<_>>()?;
        hits.extend(found.into_iter().flatten());
    }
    progress.report(1.0, "done")?;
    Ok(PathCheck { segments, hits })
}
