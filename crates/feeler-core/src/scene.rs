//! A mock-up with its index, and the queries on it.

use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::sync::{Arc, OnceLock};

use rayon::prelude::*;

use crate::cast::CastScratch;
use crate::constants::MOCKUP_CUT_ALLOWANCE;
use crate::contacts::{Adjacency, ContactScratch};
use crate::cost::{mean_longest_edge, static_means, CostFunction, Estimator};
use crate::error::{Error, Result};
use crate::hits::{Hit, Hits};
use crate::intersect_triangle_triangle::PairKind;
use crate::mesh::{Mesh, Mockup};
use crate::narrow::{Filters, Narrow, PairSet, Pending, PlacedBounds, Stats};
use crate::pieces::default_piece_size;
use crate::pose::Pose;
use crate::predict::{PiecePredictor, Predictor};
use crate::proximity::ProximityScratch;
use crate::simd::{Checked, Level};
use crate::spare::Spare;
use crate::store::{report, BlocksScratch, Progress, Storage, Store};
use crate::tool::Tool;

/// How to build a scene.
#[derive(Debug, Clone, Copy)]
pub struct SceneOptions<'a> {
    /// Voxel edge (blocks: piece size), metres; `None` chooses, see [`default_voxel_size`].
    pub voxel_size: Option<f64>,
    /// The store.
    pub storage: Storage,
    /// The tool the voxel size is chosen for; any tool can be used with the scene.
    pub tool: Option<&'a Tool>,
    /// Most bytes that building the index, or a batch's result, may take.
    pub memory_limit: u64,
}

impl Default for SceneOptions<'_> {
    fn default() -> Self {
        SceneOptions { voxel_size: None, storage: Storage::Blocks, tool: None, memory_limit: u64::MAX }
    }
}

/// The pairs of triangles that meet at one pose.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Collision {
    /// `[tool triangle, mock-up triangle]`, unique, sorted.
    pub pairs: Vec<[u32; 2]>,
    /// How each pair meets.
    pub kinds: Vec<PairKind>,
    /// What the query did.
    pub stats: Stats,
}

/// The pairs of many poses, one after the other.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Batch {
    /// Pose `i` has pairs `offsets[i]..offsets[i + 1]`.
    pub offsets: Vec<u64>,
    /// As in [`Collision`].
    pub pairs: Vec<[u32; 2]>,
    /// As in [`Collision`].
    pub kinds: Vec<PairKind>,
}

/// The working memory of one query at a time; queries allocate nothing once it has grown to their needs.
#[derive(Debug, Default)]
#[repr(align(128))] // two threads never write to one line, nor to the pair of lines that is fetched together
pub struct Scratch {
    placed: PlacedBounds,
    seen: PairSet,
    pending: Pending,
    blocks: BlocksScratch,
    pub(crate) cast: CastScratch,
    hits: Hits,
    stats: Stats,
    pub(crate) proximity: ProximityScratch,
    pub(crate) contacts: ContactScratch,
}

impl Batch {
    /// What the tasks of so many poses found, put together in parallel. New pages are first touched by the threads that fill them:
    /// to make one takes the system longer than all that is written to it takes.
    fn of_tasks(tasks: Vec<Task>, poses: usize) -> Batch {
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
        parts.into_par_iter().for_each(|(hits, pairs, kinds)| {
            for ((hit, pair), kind) in hits.iter().zip(pairs).zip(kinds) {
                (*pair, *kind) = (hit.pair(), hit.kind());
            }
        });
        batch
    }
}

/// Poses of a batch that one thread works on at a time.
const TASK: usize = 16;

/// What they found.
struct Task {
    hits: Vec<Hit>,
    /// Of each pose; the last task of a batch may have fewer poses.
    counts: [usize; TASK],
}

/// A mock-up with its index. Immutable: any number of threads may query it at once.
#[derive(Debug)]
pub struct Scene {
    mockup: Arc<Mockup>,
    voxel_size: f64,
    storage: Storage,
    memory_limit: u64,
    store: Store,
    lanes: Checked,
    spare: Spare,
    /// Made when contacts are first asked for.
    adjacency: OnceLock<Adjacency>,
}

impl Scene {
    /// Builds the index, in parallel on the current rayon pool.
    ///
    /// Errors: a voxel size or hashing level out of range, or one that needs more memory than allowed; the latter before
    /// anything is allocated.
    pub fn build(mockup: Arc<Mockup>, options: &SceneOptions<'_>, progress: Progress<'_>) -> Result<Scene> {
        let mesh = mockup.mesh();
        let voxel_size = match options.voxel_size {
            Some(size) if size.is_finite() && size > 0.0 => size,
            Some(value) => return Err(Error::VoxelSize { value }),
            None => default_voxel_size(mesh, options.tool, options.storage, options.memory_limit),
        };
        let store = Store::build(mesh, options.storage, voxel_size, options.memory_limit, progress)?;
        Ok(Scene {
            voxel_size,
            storage: options.storage,
            memory_limit: options.memory_limit,
            store,
            lanes: Level::best().checked(),
            spare: Spare::default(),
            adjacency: OnceLock::new(),
            mockup,
        })
    }

    /// The mock-up.
    pub fn mockup(&self) -> &Arc<Mockup> {
        &self.mockup
    }

    /// Voxel edge, or the piece size of blocks, metres.
    pub fn voxel_size(&self) -> f64 {
        self.voxel_size
    }

    /// The store.
    pub fn storage(&self) -> Storage {
        self.storage
    }

    /// The instruction set that queries use.
    pub fn lanes(&self) -> Level {
        self.lanes.level()
    }

    /// Has queries use another instruction set than the best; where the CPU lacks it, the best. The answers are the same.
    pub fn set_lanes(&mut self, lanes: Level) {
        self.lanes = lanes.checked();
    }

    /// Bytes by structure; "triangles" and "parts" are the mock-up's own arrays, which the index reads.
    pub fn memory(&self) -> Vec<(&'static str, usize)> {
        let mut structures = self.store.memory();
        structures.push(("triangles", self.mockup.mesh().memory()));
        structures.push(("parts", self.mockup.parts_memory()));
        // From the first call of contacts on.
        structures.extend(self.adjacency.get().map(|adjacency| ("adjacency", adjacency.memory())));
        structures
    }

    /// Which triangles of the mock-up share edges.
    pub(crate) fn adjacency(&self) -> &Adjacency {
        let (mockup, part) = (&self.mockup, |face| self.mockup.part_of_face(face));
        self.adjacency.get_or_init(|| Adjacency::new(mockup.mesh(), part, mockup.part_bounds()))
    }

    /// Checks every invariant that queries rely on; for tests.
    pub fn validate(&self) -> std::result::Result<(), String> {
        self.store.validate(self.mockup.mesh())
    }

    /// Every pair of triangles that meets, sorted by tool triangle, then mock-up triangle. Exact.
    pub fn collide(&self, tool: &Tool, pose: &Pose, filters: Filters) -> Collision {
        let mut collision = Collision::default();
        self.collide_into(tool, pose, filters, &mut collision);
        collision
    }

    /// As [`collide`](Self::collide), into an existing result whose memory is used again.
    pub fn collide_into(&self, tool: &Tool, pose: &Pose, filters: Filters, out: &mut Collision) {
        let mut scratch = self.take_scratch();
        self.run(tool, pose, filters, false, &mut scratch);
        out.pairs.clear();
        out.kinds.clear();
        scratch.hits.unpack(self.lanes, &mut out.pairs, &mut out.kinds);
        out.stats = scratch.stats;
        self.put_scratch(scratch);
    }

    /// Whether any two triangles meet; stops at the first pair.
    pub fn is_colliding(&self, tool: &Tool, pose: &Pose) -> bool {
        self.any_pair(tool, pose).is_some()
    }

    /// Any pair that meets, `[tool triangle, mock-up triangle]`.
    pub(crate) fn any_pair(&self, tool: &Tool, pose: &Pose) -> Option<[u32; 2]> {
        let mut scratch = self.take_scratch();
        self.run(tool, pose, Filters::default(), true, &mut scratch);
        let found = scratch.hits.sorted().next().map(Hit::pair);
        self.put_scratch(scratch);
        found
    }

    /// [`collide`](Self::collide) at many poses, in parallel on the current rayon pool.
    ///
    /// What is found is put together at the end, so that for a moment a pair is held twice. `progress` is told after each few
    /// thousand poses. Errors when the result would outgrow the memory limit of the scene.
    pub fn collide_batch(&self, tool: &Tool, poses: &[Pose], progress: Progress<'_>) -> Result<Batch> {
        const WAVE: usize = 4096;
        // A pair takes 9 bytes in the result and 8 in its task, which may have room for as many more.
        let needed = |pairs: u64| 26 * pairs + 24 * poses.len() as u64;
        let fits = |pairs: u64| needed(pairs) <= self.memory_limit;
        let (pairs, done) = (AtomicU64::new(0), AtomicU64::new(0));
        let mut tasks: Vec<Task> = Vec::with_capacity(poses.len().div_ceil(TASK));
        for (n, wave) in poses.chunks(WAVE).enumerate() {
            report(progress, (n * WAVE) as f64 / poses.len() as f64, "colliding")?;
            tasks.par_extend(wave.par_chunks(TASK).map(|task| {
                let mut scratch = self.take_scratch();
                // Room for a little more than tasks before found in the mean: an allocation or two a task, none a pose.
                let mean = pairs.load(Relaxed) / (done.load(Relaxed) + 1);
                let room = if fits(pairs.load(Relaxed)) { mean + mean / 4 } else { 0 };
                let mut found = Task { hits: Vec::with_capacity(room as usize), counts: [0; TASK] };
                for (pose, count) in task.iter().zip(&mut found.counts) {
                    if !fits(pairs.load(Relaxed) + found.hits.len() as u64) {
                        break;
                    }
                    self.run(tool, pose, Filters::default(), false, &mut scratch);
                    *count = scratch.hits.sorted().len();
                    found.hits.extend(scratch.hits.sorted());
                }
                // What poses before this task's found says little of these: no more room than that is kept.
                found.hits.shrink_to(2 * found.hits.len());
                pairs.fetch_add(found.hits.len() as u64, Relaxed);
                done.fetch_add(1, Relaxed);
                self.put_scratch(scratch);
                found
            }));
            if !fits(pairs.load(Relaxed)) {
                return Err(Error::Memory {
                    what: "the pairs of this batch",
                    needed: needed(pairs.into_inner()),
                    allowed: self.memory_limit,
                    advice: "pass fewer poses at a time, or allow more memory",
                });
            }
        }
        let batch = Batch::of_tasks(tasks, poses.len());
        report(progress, 1.0, "done")?;
        Ok(batch)
    }

    /// One query: `scratch.hits` afterwards holds the sorted, unique pairs.
    fn run(&self, tool: &Tool, pose: &Pose, filters: Filters, first_only: bool, scratch: &mut Scratch) {
        let Scratch { placed, seen, pending, blocks, hits, stats, .. } = scratch;
        placed.begin();
        seen.clear();
        pending.clear();
        hits.clear();
        *stats = Stats::default();
        let mesh = self.mockup.mesh();
        let mut narrow =
            Narrow { mesh, tool, pose, lanes: self.lanes, filters, first_only, placed, seen, pending, hits, stats };
        self.store.offer_candidates(tool, blocks, &mut narrow);
        narrow.finish();
        hits.sort(self.lanes);
        stats.pairs = hits.sorted().len() as u64;
    }

    /// The index.
    pub(crate) fn store(&self) -> &Store {
        &self.store
    }

    /// The instruction set, for kernels.
    pub(crate) fn checked_lanes(&self) -> Checked {
        self.lanes
    }

    /// Most bytes a result may take.
    pub(crate) fn memory_limit(&self) -> u64 {
        self.memory_limit
    }

    pub(crate) fn take_scratch(&self) -> Box<Scratch> {
        self.spare.take()
    }

    pub(crate) fn put_scratch(&self, scratch: Box<Scratch>) {
        self.spare.put(scratch);
    }
}

/// The voxel size a scene uses when none is given, metres.
///
/// For `dense` and `hashed` the minimum of the paper's cost function with the area estimator; without a tool, one whose
/// triangles are as long as the mock-up's own (mean longest edge) stands in. For `blocks` the piece size with which boxes of the
/// tool meet the fewest of the mock-up's ([`PiecePredictor`]), as far as building stays below `limit` bytes; without a tool the
/// one that spends a fixed share of extra pieces on the longest triangles ([`default_piece_size`]).
pub fn default_voxel_size(mesh: &Mesh, tool: Option<&Tool>, storage: Storage, limit: u64) -> f64 {
    if storage == Storage::Blocks {
        if let Some(predictor) = tool.and_then(|tool| PiecePredictor::new(mesh, tool)) {
            return predictor.optimal_size(limit);
        }
        let excluded = mesh.defects().excluded.is_empty();
        let ids: Vec<u32> = if excluded { Vec::new() } else { mesh.queried().collect() };
        let triangle = |i: usize| mesh.triangle(if excluded { i as u32 } else { ids[i] });
        return default_piece_size(mesh.queried_count(), triangle, MOCKUP_CUT_ALLOWANCE);
    }
    let size = match tool {
        Some(tool) => optimal_voxel_size(mesh, tool, Estimator::Area),
        None => CostFunction::new(static_means(mesh), mean_longest_edge(mesh), Estimator::Area).optimal_size(),
    };
    // Areas of a mesh near the smallest float64 underflow; any coarse grid is right, so take one.
    if size.is_normal() && size > f64::MIN_POSITIVE * 4.0 {
        size
    } else {
        mesh.bounds().extent().iter().fold(1e-300, |m, x| f64::max(m, 0.125 * x))
    }
}

/// The voxel size (metres) that is best for a mock-up and a tool, by the paper's cost function or by prediction (for the store
/// `dense` without a memory limit; a [`Predictor`] knows more).
pub fn optimal_voxel_size(mesh: &Mesh, tool: &Tool, estimator: Estimator) -> f64 {
    if let Estimator::Calibrated(constants) = estimator {
        if let Some(predictor) = Predictor::new(mesh, tool.mesh(), Storage::Dense) {
            return predictor.optimal_size(&constants, u64::MAX);
        }
    }
    CostFunction::new(static_means(mesh), mean_longest_edge(tool.mesh()), estimator).optimal_size()
}
