//! The queries at many poses, in parallel.

use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

use rayon::prelude::*;

use super::gap::Gap;
use super::query::{check_distance, closest, find_gaps, most_gaps, too_many_gaps, DistanceScratch};
use super::wanted::Goal;
use crate::error::Result;
use crate::geometry::pose::Pose;
use crate::index::mockup_index::Index;
use crate::progress::BatchOptions;
use crate::scratch_pool::ScratchPool;
use crate::tool::moving_tool::Tool;

/// Poses between two reports of progress.
const DISTANCE_WAVE: usize = 4096;
/// Poses a task handles at a time.
const DISTANCE_TASK: usize = 8;

/// The gaps of `n` poses, one after the other.
#[derive(Debug, Clone, Default, PartialEq)]
#[non_exhaustive]
pub struct GapBatch {
    /// `(n + 1,)`: pose `i` has the gaps from `offsets[i]` up to `offsets[i + 1]`.
    pub offsets: Vec<u64>,
    /// Each pose's as [`Scene::clearance`](crate::Scene::clearance) gives them.
    pub gaps: Vec<Gap>,
}

/// The closest pair at each of many poses, in parallel on the current rayon pool.
pub(crate) fn distance_batch(
    index: &Index,
    pool: &ScratchPool<DistanceScratch>,
    tool: &Tool,
    poses: &[Pose],
    max: f64,
    options: &BatchOptions<'_>,
) -> Result<Vec<Option<Gap>>> {
    let BatchOptions { progress, go_on } = *options;
    check_distance("max", max)?;
    let mut found = vec![None; poses.len()];
    for (n, (wave, out)) in poses.chunks(DISTANCE_WAVE).zip(found.chunks_mut(DISTANCE_WAVE)).enumerate() {
        progress.report((n * DISTANCE_WAVE) as f64 / poses.len() as f64, "measuring distances")?;
        wave.par_chunks(DISTANCE_TASK).zip(out.par_chunks_mut(DISTANCE_TASK)).try_for_each(|(task, out)| {
            let mut scratch = pool.take();
            for (pose, out) in task.iter().zip(out) {
                *out = closest(index, tool, pose, max, go_on, &mut scratch)?;
            }
            pool.put(scratch);
            go_on.check()
        })?;
    }
    progress.report(1.0, "done")?;
    Ok(found)
}

/// The closest pair of each part within a distance at each of many poses, or with `pairs` every pair, in parallel on the current
/// rayon pool. Errors when the result would outgrow the memory limit of the scene.
pub(crate) fn clearance_batch(
    index: &Index,
    pool: &ScratchPool<DistanceScratch>,
    tool: &Tool,
    poses: &[Pose],
    within: f64,
    pairs: bool,
    options: &BatchOptions<'_>,
) -> Result<GapBatch> {
    let BatchOptions { progress, go_on } = *options;
    check_distance("within", within)?;
    let goal = if pairs { Goal::Pairs } else { Goal::Parts };
    let mut batch = GapBatch { offsets: Vec::with_capacity(poses.len() + 1), gaps: Vec::new() };
    batch.offsets.push(0);
    let most = most_gaps(index);
    for (n, wave) in poses.chunks(DISTANCE_WAVE).enumerate() {
        progress.report((n * DISTANCE_WAVE) as f64 / poses.len() as f64, "measuring clearances")?;
        let count = AtomicUsize::new(batch.gaps.len());
        let found: Result<Vec<(Vec<Gap>, Vec<usize>)>> = wave
            .par_chunks(DISTANCE_TASK)
            .map(|task| {
                let mut scratch = pool.take();
                let (mut gaps, mut counts) = (Vec::new(), Vec::with_capacity(task.len()));
                for pose in task {
                    if count.load(Relaxed) > most {
                        break;
                    }
                    find_gaps(index, tool, pose, goal, within, go_on, &mut scratch)?;
                    gaps.extend_from_slice(scratch.gaps());
                    counts.push(scratch.gaps().len());
                    count.fetch_add(scratch.gaps().len(), Relaxed);
                }
                pool.put(scratch);
                go_on.check()?;
                Ok((gaps, counts))
            })
            .collect();
        let count = count.into_inner();
        if count > most {
            return Err(too_many_gaps(index, count));
        }
        for (gaps, counts) in found? {
            let mut sum = batch.gaps.len() as u64;
            batch.offsets.extend(counts.iter().map(|n| {
                sum += *n as u64;
                sum
            }));
            batch.gaps.extend(gaps);
        }
    }
    progress.report(1.0, "done")?;
    Ok(batch)
}
