//! The colliding pairs at many poses, in parallel.

use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use rayon::prelude::*;

use super::hits::Hit;
use super::narrow::{Filters, Until};
use super::query::{run, CollideScratch, How};
use crate::error::{Error, Result};
use crate::geometry::intersect_triangle_triangle::PairKind;
use crate::geometry::pose::Pose;
use crate::index::mockup_index::Index;
use crate::progress::{BatchOptions, GoOn};
use crate::scratch_pool::ScratchPool;
use crate::tool::moving_tool::Tool;

/// The pairs of `n` poses, one after the other: `K` in all.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Batch {
    /// `(n + 1,)`: pose `i` has the pairs from `offsets[i]` up to `offsets[i + 1]`.
    pub offsets: Vec<u64>,
    /// `(K, 2)`, each pose's as in [`Collision`](super::query::Collision).
    pub pairs: Vec<[u32; 2]>,
    /// `(K,)`, likewise.
    pub kinds: Vec<PairKind>,
}

impl Batch {
    /// The findings of the tasks of some poses, put together in parallel. New pages are first touched by the threads that fill them:
    /// to make one takes the system longer than all that is written to it takes.
    fn of_tasks(tasks: Vec<Task>, poses: usize, go_on: GoOn<'_>) -> Result<Batch> {
        let mut sum = 0;
        let mut offsets = Vec::with_capacity(poses + 1);
        offsets.push(0);
        offsets.extend(tasks.iter().flat_map(|task| task.counts).take(poses).map(|n| {
            sum += n as u64;
            sum
        }));
        // Pairs begin as zeros that the system gives untouched. Kinds are not numbers, so all threads write them.
        let mut batch = Batch { offsets, pairs: vec![[0; 2]; sum as usize], kinds: Vec::new() };
        rayon::iter::repeat_n(PairKind::Coplanar, sum as usize).collect_into_vec(&mut batch.kinds);
        let (mut pairs, mut kinds) = (&mut batch.pairs[..], &mut batch.kinds[..]);
        let mut parts = Vec::with_capacity(tasks.len());
        for Task { hits, .. } in tasks {
            let (own_pairs, own_kinds);
            (own_pairs, pairs) = pairs.split_at_mut(hits.len());
            (own_kinds, kinds) = kinds.split_at_mut(hits.len());
            parts.push((hits, own_pairs, own_kinds));
        }
        parts.into_par_iter().try_for_each(|(hits, pairs, kinds)| {
            for ((hit, pair), kind) in hits.iter().zip(pairs).zip(kinds) {
                (*pair, *kind) = (hit.pair(), hit.kind());
            }
            go_on.check()
        })?;
        Ok(batch)
    }
}

/// Poses of a batch that one thread works on at a time.
const COLLIDE_TASK: usize = 16;

/// The findings of one task.
struct Task {
    hits: Vec<Hit>,
    /// Of each pose; the last task of a batch may have fewer poses.
    counts: [usize; COLLIDE_TASK],
}

/// Every pair that meets at each of many poses, in parallel on the current rayon pool.
///
/// The results are put together at the end, so that for a moment a pair is held twice. `progress` is called after each few
/// thousand poses. Errors when the result would outgrow the memory limit of the scene.
pub(crate) fn collide_batch(
    index: &Index,
    pool: &ScratchPool<CollideScratch>,
    tool: &Tool,
    poses: &[Pose],
    options: &BatchOptions<'_>,
) -> Result<Batch> {
    let BatchOptions { progress, go_on } = *options;
    let how = How { filters: Filters::default(), until: Until::End, go_on };
    const COLLIDE_WAVE: usize = 4096;
    // A pair takes 9 bytes in the result and 8 in its task, which may have room for as many more.
    let needed = |pairs: u64| 26 * pairs + 24 * poses.len() as u64;
    let fits = |pairs: u64| needed(pairs) <= index.memory_limit();
    let (pairs, done) = (AtomicU64::new(0), AtomicU64::new(0));
    let mut tasks: Vec<Task> = Vec::with_capacity(poses.len().div_ceil(COLLIDE_TASK));
    for (n, wave) in poses.chunks(COLLIDE_WAVE).enumerate() {
        progress.report((n * COLLIDE_WAVE) as f64 / poses.len() as f64, "colliding")?;
        tasks.par_extend(wave.par_chunks(COLLIDE_TASK).map(|task| {
            let mut scratch = pool.take();
            // Room for a little more than tasks before found in the mean: an allocation or two a task, none a pose.
            let mean = pairs.load(Relaxed) / (done.load(Relaxed) + 1);
            let room = if fits(pairs.load(Relaxed)) { mean + mean / 4 } else { 0 };
            let mut found = Task { hits: Vec::with_capacity(room as usize), counts: [0; COLLIDE_TASK] };
            for (pose, count) in task.iter().zip(&mut found.counts) {
                if !fits(pairs.load(Relaxed) + found.hits.len() as u64) {
                    break;
                }
                if run(index, tool, pose, how, &mut scratch).is_err() || !go_on.goes_on() {
                    break;
                }
                *count = scratch.sorted().len();
                found.hits.extend(scratch.sorted());
            }
            // What poses before this task's found says little of these: no more room than that is kept.
            found.hits.shrink_to(2 * found.hits.len());
            pairs.fetch_add(found.hits.len() as u64, Relaxed);
            done.fetch_add(1, Relaxed);
            pool.put(scratch);
            found
        }));
        go_on.check()?;
        if !fits(pairs.load(Relaxed)) {
            return Err(Error::Memory {
                what: "the pairs of this batch",
                needed: needed(pairs.into_inner()),
                allowed: index.memory_limit(),
                advice: "pass fewer poses at a time, or allow more memory",
            });
        }
    }
    let batch = Batch::of_tasks(tasks, poses.len(), go_on)?;
    progress.report(1.0, "done")?;
    Ok(batch)
}
