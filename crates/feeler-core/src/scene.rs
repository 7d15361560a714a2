//! A mock-up with its index, and the queries on it: a facade; each query has its own room.

use std::sync::Arc;

use feeler_lanes::Level;

use crate::cast::impact::{check_tolerance, Cast};
use crate::cast::options::{CastOptions, PathOptions};
use crate::cast::path::PathCheck;
use crate::cast::query::{CastScratch, How};
use crate::collide::batch::Batch;
use crate::collide::narrow::Filters;
use crate::collide::query::{CollideScratch, Collision};
use crate::distance::along::LeastGap;
use crate::distance::batch::GapBatch;
use crate::distance::gap::Gap;
use crate::distance::query::{check_distance, DistanceScratch};
use crate::distance::wanted::Goal;
use crate::error::{Error, Result};
use crate::geometry::bounds::Point;
use crate::geometry::pose::Pose;
use crate::index::mockup_index::Index;
use crate::index::ray_search::RayScratch;
use crate::index::selection::IgnoredPairs;
use crate::index::store::Storage;
use crate::mesh::mockup::Mockup;
use crate::progress::{BatchOptions, Control, GoOn, Progress};
use crate::rays::ray::{HalfSpace, Ray, RayHit};
use crate::saved::{Reader, SavedSections, Sections};
use crate::scratch_pool::ScratchPool;
use crate::section::outline::SectionOutline;
use crate::sizing::choice::default_voxel_size;
use crate::tool::leg::Leg;
use crate::tool::motion::Motion;
use crate::tool::moving_tool::Tool;
use crate::{cast, collide, distance, rays, section};

/// Options of [`Scene::build`]:
///
/// ```
/// use feeler_core::{SceneOptions, Storage};
///
/// let options = SceneOptions::default().with_storage(Storage::Dense).with_voxel_size(0.02);
/// # let _ = options;
/// ```
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct SceneOptions<'a> {
    /// Voxel edge (blocks: piece size), metres; `None` chooses, see [`default_voxel_size`].
    pub voxel_size: Option<f64>,
    /// The store; [`Storage::Blocks`] by default.
    pub storage: Storage,
    /// The tool the voxel size is chosen for; any tool can be used with the scene.
    pub tool: Option<&'a Tool>,
    /// The most bytes for building the index, and for a query's result; by default there is no limit.
    pub memory_limit: u64,
    /// Reports the progress of building, and may stop it.
    pub progress: Progress<'a>,
    /// Asked every few milliseconds on each thread, and may stop building.
    pub go_on: GoOn<'a>,
}

impl Default for SceneOptions<'_> {
    fn default() -> Self {
        SceneOptions {
            voxel_size: None,
            storage: Storage::Blocks,
            tool: None,
            memory_limit: u64::MAX,
            progress: Progress::default(),
            go_on: GoOn::default(),
        }
    }
}

impl<'a> SceneOptions<'a> {
    /// Sets the voxel edge (blocks: piece size), metres; `None` chooses.
    #[must_use]
    pub fn with_voxel_size(mut self, voxel_size: impl Into<Option<f64>>) -> Self {
        self.voxel_size = voxel_size.into();
        self
    }

    /// Sets the store.
    #[must_use]
    pub fn with_storage(mut self, storage: Storage) -> Self {
        self.storage = storage;
        self
    }

    /// Chooses the voxel size for this tool.
    #[must_use]
    pub fn with_tool(mut self, tool: impl Into<Option<&'a Tool>>) -> Self {
        self.tool = tool.into();
        self
    }

    /// Sets the most bytes that building the index, or a query's result, may take.
    #[must_use]
    pub fn with_memory_limit(mut self, bytes: u64) -> Self {
        self.memory_limit = bytes;
        self
    }

    /// Calls a function with the share done (0 to 1) and the stage. Building stops with [`Error::Cancelled`] where it returns false.
    #[must_use]
    pub fn with_progress(mut self, progress: &'a (dyn Fn(f64, &str) -> bool + Sync)) -> Self {
        self.progress = Progress::new(progress);
        self
    }

    /// Asks a function every few milliseconds on each thread. Building stops with [`Error::Cancelled`] where it returns false.
    #[must_use]
    pub fn with_go_on(mut self, go_on: &'a (dyn Fn() -> bool + Sync)) -> Self {
        self.go_on = GoOn::new(go_on);
        self
    }
}

/// A mock-up with its index, and the queries on it. Immutable: any number of threads may query it at once.
///
/// One scene serves any number of tools. It keeps the working memory of its queries for the next ones. A copy shares all of it,
/// and so do the scenes [without](Self::without) some parts.
#[derive(Debug, Clone)]
pub struct Scene {
    index: Index,
    pools: Arc<Pools>,
}

/// Working memory of queries.
#[derive(Debug, Default)]
struct Pools {
    collide: ScratchPool<CollideScratch>,
    distance: ScratchPool<DistanceScratch>,
    cast: ScratchPool<CastScratch>,
    rays: ScratchPool<RayScratch>,
}

impl Scene {
    /// Builds the index, in parallel on the current rayon pool.
    ///
    /// Errors: a request to stop, a voxel size or hashing level out of range, or one that needs more memory than allowed; the latter before
    /// anything is allocated.
    pub fn build(mockup: Arc<Mockup>, options: &SceneOptions<'_>) -> Result<Scene> {
        let SceneOptions { voxel_size, storage, tool, memory_limit, progress, go_on } = *options;
        let size = voxel_size.unwrap_or_else(|| default_voxel_size(mockup.mesh(), tool, storage, memory_limit));
        let index = Index::build(mockup, storage, size, memory_limit, Control { progress, go_on })?;
        Ok(Scene { index, pools: Arc::default() })
    }

    /// The scene, [in one index](Self::in_one_index), as sections, and with them the connectivity of the triangles, so that first queries of a scene made
    /// [of them](Self::of_sections) find it. Pairs that the scene ignores are not kept.
    #[doc(hidden)]
    pub fn sections(&self) -> Sections<'_> {
        let mut sections = Sections::default();
        self.index.save(&mut sections);
        sections
    }

    /// A scene of such sections, on the memory they are in; stores other than blocks are built again.
    ///
    /// Errors: sections that are missing or do not fit each other. With `is_checked` every index in them is checked, too. Without, a
    /// query panics where one is out of range.
    #[doc(hidden)]
    pub fn of_sections(
        saved: &dyn SavedSections,
        is_checked: bool,
        memory_limit: u64,
        progress: Progress<'_>,
    ) -> Result<Scene> {
        let control = Control { progress, ..Control::default() };
        let (index, absent) = Index::of_saved(Reader::new(saved, is_checked), memory_limit, control)?;
        let scene = Scene { index, pools: Arc::default() };
        if absent.is_empty() {
            Ok(scene)
        } else {
            scene.without(&absent)
        }
    }

    /// The scene without some parts, on the same index: each query answers as a scene built without them does, and triangles and
    /// parts keep their numbers. Parts that are out already stay out.
    ///
    /// Takes a bit of memory a triangle and a bit a block, and about as long as reading the triangles' parts. Errors: a part that
    /// the mock-up does not have.
    ///
    /// ```
    /// # use feeler_core::*;
    /// // A plate of two parts, and a spike through the first.
    /// # let plate = vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];
    /// let mockup = Mockup::new(plate, vec![[0, 1, 2], [0, 2, 3]], vec![0, 1], 2)?;
    /// # let scene = Scene::build(mockup.into(), &SceneOptions::default())?;
    /// # let spike = vec![[0.0, 0.0, 0.0], [0.1, 0.0, 0.2], [-0.1, 0.1, 0.2], [-0.1, -0.1, 0.2]];
    /// # let tool = Tool::new(spike, vec![[0, 2, 1], [0, 3, 2], [0, 1, 3], [1, 2, 3]])?;
    /// let pose = Pose::IDENTITY.translated(&[0.3, -0.3, -0.05])?;
    /// assert!(scene.is_colliding(&tool, &pose));
    /// assert!(!scene.without(&[0])?.is_colliding(&tool, &pose));
    /// assert!(scene.only(&[0])?.is_colliding(&tool, &pose));
    /// # Ok::<(), Error>(())
    /// ```
    pub fn without(&self, parts: &[u32]) -> Result<Scene> {
        let out = self.marked(parts)?;
        Ok(self.narrowed(|part| !out[part as usize]))
    }

    /// The scene with no parts but these, as [`without`](Self::without) all others.
    pub fn only(&self, parts: &[u32]) -> Result<Scene> {
        let stays = self.marked(parts)?;
        Ok(self.narrowed(|part| stays[part as usize]))
    }

    /// The scene with parts at other places, by part the number of its pose among `poses`: see [`Mockup::moved`]. Poses count from where
    /// the parts are modelled, also in a scene that has some moved; parts without a pose are where they are modelled. Parts that are out
    /// stay out, and ignored pairs ignored.
    ///
    /// The scene shares the index and has one of the moved triangles beside it, so making it takes as long as indexing these. Each query
    /// answers as one of a scene built of the new mock-up. Errors: as of [`Mockup::moved`], and memory.
    ///
    /// ```
    /// # use feeler_core::*;
    /// # let plate = vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];
    /// let mockup = Mockup::new(plate, vec![[0, 1, 2], [0, 2, 3]], vec![0, 1], 2)?;
    /// let scene = Scene::build(mockup.into(), &SceneOptions::default())?;
    /// # let spike = vec![[0.0, 0.0, 0.0], [0.1, 0.0, 0.2], [-0.1, 0.1, 0.2], [-0.1, -0.1, 0.2]];
    /// # let tool = Tool::new(spike, vec![[0, 2, 1], [0, 3, 2], [0, 1, 3], [1, 2, 3]])?;
    /// // The tip of the spike is 5 cm above the plate; its first half comes up.
    /// let at = |z: f64| Pose::IDENTITY.translated(&[0.3, -0.3, z]);
    /// let moved = scene.moved(&[Some(0), None], &[Pose::IDENTITY.translated(&[0.0, 0.0, 0.1])?])?;
    /// assert!(moved.is_colliding(&tool, &at(0.05)?) && !moved.is_colliding(&tool, &at(-0.15)?));
    /// assert!(!scene.is_colliding(&tool, &at(0.05)?));
    /// # Ok::<(), Error>(())
    /// ```
    pub fn moved(&self, pose_of_part: &[Option<u32>], poses: &[Pose]) -> Result<Scene> {
        let mockup = if pose_of_part.iter().any(Option::is_some) {
            Arc::new(Mockup::moved(self.mockup(), pose_of_part, poses)?)
        } else {
            self.mockup().modelled().clone()
        };
        Ok(self.with(self.index.moved(mockup)?))
    }

    /// The scene with one index, where parts are [moved](Self::moved), as a scene built of its mock-up.
    #[doc(hidden)]
    pub fn in_one_index(&self, progress: Progress<'_>) -> Result<Scene> {
        if !self.index.has_moved() {
            return Ok(self.clone());
        }
        Ok(self.with(self.index.in_one_store(Control { progress, ..Control::default() })?))
    }

    /// The scene with ignored pairs of tool parts and mock-up parts, in place of those ignored so far; with parts of a
    /// [tool](Tool::of_parts) by number.
    pub fn ignoring(&self, pairs: Arc<IgnoredPairs>) -> Scene {
        self.with(self.index.ignoring(Some(&pairs)))
    }

    /// The scene with one part alone of those that are there, and no pairs ignored: made in no time, and right for tools near that part.
    #[doc(hidden)]
    pub fn of_one_part(&self, part: u32) -> Scene {
        self.with(self.index.of_one_part(part))
    }

    /// The scene with all parts there, and no pairs ignored.
    #[doc(hidden)]
    pub fn with_all_parts(&self) -> Scene {
        self.with(self.index.with_all_parts())
    }

    /// The scene with no pairs ignored.
    #[doc(hidden)]
    pub fn asking_all_pairs(&self) -> Scene {
        self.with(self.index.ignoring(None))
    }

    fn narrowed(&self, stays: impl Fn(u32) -> bool) -> Scene {
        self.with(self.index.narrowed(stays))
    }

    fn with(&self, index: Index) -> Scene {
        Scene { index, pools: self.pools.clone() }
    }

    /// By part, whether it is in a list.
    fn marked(&self, list: &[u32]) -> Result<Vec<bool>> {
        let parts = self.mockup().part_bounds().len();
        let mut marked = vec![false; parts];
        for &part in list {
            *marked.get_mut(part as usize).ok_or(Error::NoSuchPart { part, parts })? = true;
        }
        Ok(marked)
    }

    /// Whether a part is there; false also where the mock-up has no such part.
    pub fn has_part(&self, part: u32) -> bool {
        (part as usize) < self.mockup().part_bounds().len() && self.index.selection().has_part(part)
    }

    /// The mock-up.
    pub fn mockup(&self) -> &Arc<Mockup> {
        self.index.mockup()
    }

    /// The index, for queries that stand above this crate.
    #[doc(hidden)]
    pub fn index(&self) -> &Index {
        &self.index
    }

    /// Every colliding pair of triangles, sorted by tool triangle, then mock-up triangle. Exact.
    ///
    /// ```
    /// # use feeler_core::*;
    /// # let plate = vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];
    /// # let mockup = Mockup::new(plate, vec![[0, 1, 2], [0, 2, 3]], vec![], 1)?;
    /// # let scene = Scene::build(mockup.into(), &SceneOptions::default())?;
    /// # let spike = vec![[0.0, 0.0, 0.0], [0.1, 0.0, 0.2], [-0.1, 0.1, 0.2], [-0.1, -0.1, 0.2]];
    /// # let tool = Tool::new(spike, vec![[0, 2, 1], [0, 3, 2], [0, 1, 3], [1, 2, 3]])?;
    /// // The tip of the spike is 5 cm below the plate.
    /// let hit = scene.collide(&tool, &Pose::IDENTITY.translated(&[0.3, -0.3, -0.05])?);
    /// for ([t, m], kind) in hit.pairs.iter().zip(&hit.kinds) {
    ///     println!("tool triangle {t}, mock-up triangle {m}: {kind:?}");
    /// }
    /// assert_eq!(hit.pairs.len(), 3);
    /// # Ok::<(), Error>(())
    /// ```
    pub fn collide(&self, tool: &Tool, pose: &Pose) -> Collision {
        self.collide_filtered(tool, pose, Filters::default())
    }

    /// Whether any two triangles collide; stops at the first pair.
    ///
    /// ```
    /// # use feeler_core::*;
    /// # let plate = vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];
    /// # let mockup = Mockup::new(plate, vec![[0, 1, 2], [0, 2, 3]], vec![], 1)?;
    /// # let scene = Scene::build(mockup.into(), &SceneOptions::default())?;
    /// # let spike = vec![[0.0, 0.0, 0.0], [0.1, 0.0, 0.2], [-0.1, 0.1, 0.2], [-0.1, -0.1, 0.2]];
    /// # let tool = Tool::new(spike, vec![[0, 2, 1], [0, 3, 2], [0, 1, 3], [1, 2, 3]])?;
    /// assert!(!scene.is_colliding(&tool, &Pose::IDENTITY.translated(&[0.3, -0.3, 0.001])?));
    /// // Touching is a collision.
    /// assert!(scene.is_colliding(&tool, &Pose::IDENTITY));
    /// # Ok::<(), Error>(())
    /// ```
    pub fn is_colliding(&self, tool: &Tool, pose: &Pose) -> bool {
        self.pools.collide.with(|scratch| collide::query::any_pair(&self.index, tool, pose, scratch)).is_some()
    }

    /// Whether one body enters the other instead of only touching it: surfaces may lie on each other, slide along each
    /// other and be seated without play. Stops at the first pair that crosses.
    ///
    /// The kinds of pairs decide; for coplanar pairs, and for triangles that touch from within, exact sides do, for
    /// which the [adjacency](Self::memory) of both meshes is computed once. Sheets have no inside: a tool that touches
    /// one from both sides goes through it. Bodies that share only corners of triangles of both count as touching.
    ///
    /// ```
    /// # use feeler_core::*;
    /// # let plate = vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];
    /// # let mockup = Mockup::new(plate, vec![[0, 1, 2], [0, 2, 3]], vec![], 1)?;
    /// # let scene = Scene::build(mockup.into(), &SceneOptions::default())?;
    /// # let spike = vec![[0.0, 0.0, 0.0], [0.1, 0.0, 0.2], [-0.1, 0.1, 0.2], [-0.1, -0.1, 0.2]];
    /// # let tool = Tool::new(spike, vec![[0, 2, 1], [0, 3, 2], [0, 1, 3], [1, 2, 3]])?;
    /// // The tip on the plate, and through it.
    /// assert!(!scene.is_entering(&tool, &Pose::IDENTITY));
    /// assert!(scene.is_entering(&tool, &Pose::IDENTITY.translated(&[0.3, -0.3, -0.05])?));
    /// # Ok::<(), Error>(())
    /// ```
    pub fn is_entering(&self, tool: &Tool, pose: &Pose) -> bool {
        self.pools.collide.with(|scratch| collide::query::entering_pair(&self.index, tool, pose, scratch)).is_some()
    }

    /// [`collide`](Self::collide) at many poses, in parallel on the current rayon pool.
    ///
    /// The results of all threads are joined at the end, so that each pair is briefly in memory twice. Errors when the result would outgrow the
    /// memory limit of the scene.
    ///
    /// ```
    /// # use feeler_core::*;
    /// # let plate = vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];
    /// # let mockup = Mockup::new(plate, vec![[0, 1, 2], [0, 2, 3]], vec![], 1)?;
    /// # let scene = Scene::build(mockup.into(), &SceneOptions::default())?;
    /// # let spike = vec![[0.0, 0.0, 0.0], [0.1, 0.0, 0.2], [-0.1, 0.1, 0.2], [-0.1, -0.1, 0.2]];
    /// # let tool = Tool::new(spike, vec![[0, 2, 1], [0, 3, 2], [0, 1, 3], [1, 2, 3]])?;
    /// let at = |z: f64| Pose::IDENTITY.translated(&[0.3, -0.3, z]);
    /// let batch = scene.collide_batch(&tool, &[at(0.1)?, at(-0.05)?, at(-0.1)?], &BatchOptions::default())?;
    /// assert_eq!(batch.offsets, [0, 0, 3, 6]);
    /// let second = &batch.pairs[batch.offsets[1] as usize..batch.offsets[2] as usize];
    /// assert_eq!(second, [[0, 0], [1, 0], [2, 0]]);
    /// # Ok::<(), Error>(())
    /// ```
    pub fn collide_batch(&self, tool: &Tool, poses: &[Pose], options: &BatchOptions<'_>) -> Result<Batch> {
        collide::batch::collide_batch(&self.index, &self.pools.collide, tool, poses, options)
    }

    /// Every pair of triangles with a distance of at most `within` (metres), sorted by distance, then tool triangle, then
    /// mock-up triangle. Colliding pairs have distance 0.
    ///
    /// Errors: `within` negative or NaN, and more pairs than the memory limit of the scene allows.
    pub fn near_pairs(&self, tool: &Tool, pose: &Pose, within: f64) -> Result<Vec<Gap>> {
        check_distance("within", within)?;
        self.gaps_while((tool, pose), Goal::Pairs, within, GoOn::default())
    }

    /// The closest pair of triangles of each part with a distance of at most `within` (metres), sorted as
    /// [`near_pairs`](Self::near_pairs).
    ///
    /// Of several pairs at the same distance, the one with the least ids; of several colliding ones, any. Errors:
    /// `within` negative or NaN.
    ///
    /// ```
    /// # use feeler_core::*;
    /// # let plate = vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];
    /// # let mockup = Mockup::new(plate, vec![[0, 1, 2], [0, 2, 3]], vec![], 1)?;
    /// # let scene = Scene::build(mockup.into(), &SceneOptions::default())?;
    /// # let spike = vec![[0.0, 0.0, 0.0], [0.1, 0.0, 0.2], [-0.1, 0.1, 0.2], [-0.1, -0.1, 0.2]];
    /// # let tool = Tool::new(spike, vec![[0, 2, 1], [0, 3, 2], [0, 1, 3], [1, 2, 3]])?;
    /// // The tip of the spike is 4 mm above the plate: is a clearance of 5 mm kept?
    /// let too_near = scene.clearance(&tool, &Pose::IDENTITY.translated(&[0.3, -0.3, 0.004])?, 0.005)?;
    /// assert_eq!(too_near.len(), 1);
    /// assert_eq!((too_near[0].part, too_near[0].distance), (0, 0.004));
    /// # Ok::<(), Error>(())
    /// ```
    pub fn clearance(&self, tool: &Tool, pose: &Pose, within: f64) -> Result<Vec<Gap>> {
        check_distance("within", within)?;
        self.gaps_while((tool, pose), Goal::Parts, within, GoOn::default())
    }

    /// The closest pair of triangles of each of the `k` closest parts, but none farther than `within` (metres); sorted as
    /// [`near_pairs`](Self::near_pairs). With `k` = 1 the first entry is the minimum distance; no entry: nothing within that.
    ///
    /// Of several pairs at the same distance, the one with the least ids; of several that meet, any, and of more than `k`
    /// parts that meet the tool, any `k`. Errors: `within` negative or NaN, and `k` zero.
    ///
    /// ```
    /// # use feeler_core::*;
    /// # let plate = vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];
    /// # let mockup = Mockup::new(plate, vec![[0, 1, 2], [0, 2, 3]], vec![], 1)?;
    /// # let scene = Scene::build(mockup.into(), &SceneOptions::default())?;
    /// # let spike = vec![[0.0, 0.0, 0.0], [0.1, 0.0, 0.2], [-0.1, 0.1, 0.2], [-0.1, -0.1, 0.2]];
    /// # let tool = Tool::new(spike, vec![[0, 2, 1], [0, 3, 2], [0, 1, 3], [1, 2, 3]])?;
    /// let nearest = scene.nearest(&tool, &Pose::IDENTITY.translated(&[0.3, -0.3, 0.25])?, 3, f64::INFINITY)?;
    /// let gap = &nearest[0];
    /// assert_eq!((gap.distance, gap.mockup_triangle), (0.25, 0));
    /// assert_eq!((gap.on_tool, gap.on_mockup), ([0.3, -0.3, 0.25], [0.3, -0.3, 0.0]));
    /// # Ok::<(), Error>(())
    /// ```
    pub fn nearest(&self, tool: &Tool, pose: &Pose, k: usize, within: f64) -> Result<Vec<Gap>> {
        check_distance("within", within)?;
        if k == 0 {
            return Err(Error::NoneAsked { what: "k" });
        }
        self.gaps_while((tool, pose), Goal::Nearest(k), within, GoOn::default())
    }

    /// The closest pair of triangles, `None` when all are farther than `within` (metres): [`nearest`](Self::nearest) with `k` = 1,
    /// allocating nothing.
    pub fn distance(&self, tool: &Tool, pose: &Pose, within: f64) -> Result<Option<Gap>> {
        check_distance("within", within)?;
        self.closest_while((tool, pose), within, GoOn::default())
    }

    pub(crate) fn closest_while(&self, at: (&Tool, &Pose), within: f64, go_on: GoOn<'_>) -> Result<Option<Gap>> {
        self.pools.distance.with(|scratch| distance::query::closest(&self.index, at.0, at.1, within, go_on, scratch))
    }

    pub(crate) fn gaps_while(
        &self,
        (tool, pose): (&Tool, &Pose),
        goal: Goal,
        within: f64,
        go_on: GoOn<'_>,
    ) -> Result<Vec<Gap>> {
        self.pools.distance.with(|scratch| distance::query::gaps(&self.index, tool, pose, goal, within, go_on, scratch))
    }

    /// [`distance`](Self::distance) at many poses, in parallel on the current rayon pool.
    pub fn distance_batch(
        &self,
        tool: &Tool,
        poses: &[Pose],
        within: f64,
        options: &BatchOptions<'_>,
    ) -> Result<Vec<Option<Gap>>> {
        distance::batch::distance_batch(&self.index, &self.pools.distance, tool, poses, within, options)
    }

    /// [`clearance`](Self::clearance) at many poses, in parallel on the current rayon pool. Errors when the result would outgrow the
    /// memory limit of the scene.
    pub fn clearance_batch(
        &self,
        tool: &Tool,
        poses: &[Pose],
        within: f64,
        options: &BatchOptions<'_>,
    ) -> Result<GapBatch> {
        distance::batch::clearance_batch(&self.index, &self.pools.distance, tool, poses, within, false, options)
    }

    /// [`near_pairs`](Self::near_pairs) at many poses, as [`clearance_batch`](Self::clearance_batch).
    pub fn near_pairs_batch(
        &self,
        tool: &Tool,
        poses: &[Pose],
        within: f64,
        options: &BatchOptions<'_>,
    ) -> Result<GapBatch> {
        distance::batch::clearance_batch(&self.index, &self.pools.distance, tool, poses, within, true, options)
    }

    /// The first impact of the tool on its [way](crate::Motion) between two poses; `None` if the way is free.
    ///
    /// Where the two poses are equal the answer is that of [`Scene::collide`], exact. With [`Touching::Free`](crate::Touching::Free) the
    /// cast ends where one body enters the other. Errors: a tolerance that is not positive and finite, and a request to stop.
    ///
    /// ```
    /// # use feeler_core::*;
    /// # let plate = vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];
    /// # let mockup = Mockup::new(plate, vec![[0, 1, 2], [0, 2, 3]], vec![], 1)?;
    /// # let scene = Scene::build(mockup.into(), &SceneOptions::default())?;
    /// # let spike = vec![[0.0, 0.0, 0.0], [0.1, 0.0, 0.2], [-0.1, 0.1, 0.2], [-0.1, -0.1, 0.2]];
    /// # let tool = Tool::new(spike, vec![[0, 2, 1], [0, 3, 2], [0, 1, 3], [1, 2, 3]])?;
    /// let at = |z: f64| Pose::IDENTITY.translated(&[0.3, -0.3, z]);
    /// // Half of the way from 1 m above the plate to 1 m below it is free.
    /// let hit = scene.cast(&tool, &at(1.0)?, &at(-1.0)?, &CastOptions::default())?.expect("the plate is in the way");
    /// assert!(hit.fraction <= 0.5 && hit.fraction > 0.499_999);
    /// assert_eq!(hit.normal, [0.0, 0.0, 1.0]);
    /// assert!(scene.cast(&tool, &at(1.0)?, &at(0.1)?, &CastOptions::default())?.is_none());
    /// # Ok::<(), Error>(())
    /// ```
    pub fn cast(&self, tool: &Tool, start: &Pose, end: &Pose, options: &CastOptions<'_>) -> Result<Option<Cast>> {
        self.cast_along(tool, &Motion::new(tool, start, end), options)
    }

    /// [`cast`](Self::cast) along any motion of the tool, as along a [screw](crate::Screw).
    ///
    /// ```
    /// # use feeler_core::*;
    /// # let plate = vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];
    /// # let mockup = Mockup::new(plate, vec![[0, 1, 2], [0, 2, 3]], vec![], 1)?;
    /// # let scene = Scene::build(mockup.into(), &SceneOptions::default())?;
    /// # let spike = vec![[0.0, 0.0, 0.0], [0.1, 0.0, 0.2], [-0.1, 0.1, 0.2], [-0.1, -0.1, 0.2]];
    /// # let tool = Tool::new(spike, vec![[0, 2, 1], [0, 3, 2], [0, 1, 3], [1, 2, 3]])?;
    /// // Three turns down a thread of 0.1 m a turn: it hits the plate, 0.25 m below, in the third.
    /// let screw = Screw::new(&[0.0, 0.0, 1.0], &[0.3, -0.3, 0.0], -3.0 * std::f64::consts::TAU, 0.1)?;
    /// let motion = Motion::screw(&tool, &Pose::IDENTITY.translated(&[0.3, -0.3, 0.25])?, &screw)?;
    /// let hit = scene.cast_along(&tool, &motion, &CastOptions::default())?.expect("the plate is in the way");
    /// assert!((hit.fraction * 0.3 - 0.25).abs() < 1e-5);
    /// # Ok::<(), Error>(())
    /// ```
    pub fn cast_along(&self, tool: &Tool, motion: &Motion, options: &CastOptions<'_>) -> Result<Option<Cast>> {
        let CastOptions { tolerance, touching, directions, go_on } = *options;
        check_tolerance(tolerance)?;
        let how = How { tolerance, touching, directions, goes_on: go_on.function() };
        self.pools.cast.with(|scratch| cast::query::cast(&self.index, tool, motion, how, scratch))
    }

    /// The least gap of the tool along a motion, between bounds that are at most `error` (metres) apart; gaps beyond `within` (metres) are
    /// not looked at.
    ///
    /// Where the tool moves around for long at an equal distance it takes many spans: after a million of them the bounds are what is
    /// known by then. Errors: a distance that is negative or NaN, and a request to stop.
    pub fn clearance_along(
        &self,
        tool: &Tool,
        motion: &Motion,
        (within, error): (f64, f64),
        go_on: GoOn<'_>,
    ) -> Result<LeastGap> {
        let asked = (within, error);
        self.pools
            .distance
            .with(|scratch| distance::along::least_gap(&self.index, (tool, motion), asked, go_on, scratch))
    }

    /// [`cast`](Self::cast) from each pose of a path to the next, in parallel on the current rayon pool.
    ///
    /// Every segment is looked at, also those after an impact. Errors: as
    /// `cast`, a path without a pose, and a request to stop.
    ///
    /// ```
    /// # use feeler_core::*;
    /// # let plate = vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];
    /// # let mockup = Mockup::new(plate, vec![[0, 1, 2], [0, 2, 3]], vec![], 1)?;
    /// # let scene = Scene::build(mockup.into(), &SceneOptions::default())?;
    /// # let spike = vec![[0.0, 0.0, 0.0], [0.1, 0.0, 0.2], [-0.1, 0.1, 0.2], [-0.1, -0.1, 0.2]];
    /// # let tool = Tool::new(spike, vec![[0, 2, 1], [0, 3, 2], [0, 1, 3], [1, 2, 3]])?;
    /// let at = |z: f64| Pose::IDENTITY.translated(&[0.3, -0.3, z]);
    /// let path = [at(1.0)?, at(0.5)?, at(-0.1)?, at(-1.0)?];
    /// let check = scene.check_path(&tool, &path, &PathOptions::default())?;
    /// assert_eq!(check.segments, 3);
    /// // The second segment runs into the plate; the third one begins in it.
    /// assert_eq!(check.hits.iter().map(|(segment, _)| *segment).collect::<Vec<_>>(), [1, 2]);
    /// # Ok::<(), Error>(())
    /// ```
    pub fn check_path(&self, tool: &Tool, poses: &[Pose], options: &PathOptions<'_>) -> Result<PathCheck> {
        let Some(first) = poses.first() else { return Err(Error::EmptyPath) };
        let motion = |i: usize| Motion::new(tool, &poses[i], poses.get(i + 1).unwrap_or(first));
        self.check_motions(tool, (poses.len().max(2) - 1, &motion), options)
    }

    /// [`check_path`](Self::check_path) of a way of legs from a pose. Errors where a leg leads beyond the coordinate limit, too.
    pub fn check_legs(&self, tool: &Tool, start: &Pose, legs: &[Leg], options: &PathOptions<'_>) -> Result<PathCheck> {
        let motions = match legs {
            [] => vec![Motion::new(tool, start, start)],
            legs => Motion::of_legs(tool, start, legs)?,
        };
        self.check_motions(tool, (motions.len(), &|i| motions[i].clone()), options)
    }

    fn check_motions(
        &self,
        tool: &Tool,
        motions: (usize, &(dyn Fn(usize) -> Motion + Sync)),
        options: &PathOptions<'_>,
    ) -> Result<PathCheck> {
        cast::path::check_path(&self.index, &self.pools.cast, tool, motions, options)
    }
}

/// Queries without a tool.
impl Scene {
    /// The first triangle that a ray hits, `None` without a hit within `max` (metres) and all `sections`.
    ///
    /// Whether a closed triangle is hit is exact, and so is which comes first; of several at the same place, the one
    /// with the least id. A ray that begins on a triangle hits it there; a ray in a triangle's plane hits it at their
    /// first common point. The relative error of the distance is 1e-12. Only points kept by all sections count.
    ///
    /// Errors: `max` negative or NaN, a direction or normal of zero, and numbers that are not finite or beyond 1e100 in size.
    ///
    /// ```
    /// # use feeler_core::*;
    /// # let plate = vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];
    /// # let mockup = Mockup::new(plate, vec![[0, 1, 2], [0, 2, 3]], vec![], 1)?;
    /// # let scene = Scene::build(mockup.into(), &SceneOptions::default())?;
    /// // Down onto the plate.
    /// let ray = Ray { origin: [0.5, -0.25, 3.0], direction: [0.0, 0.0, -2.0] };
    /// let hit = scene.ray(&ray, f64::INFINITY, &[])?.expect("the plate is there");
    /// assert_eq!((hit.triangle, hit.distance, hit.point), (0, 3.0, [0.5, -0.25, 0.0]));
    /// assert_eq!(hit.normal, [0.0, 0.0, 1.0]);
    /// // The section cuts away everything to the right of a plane.
    /// let section = HalfSpace { normal: [-1.0, 0.0, 0.0], offset: -0.4 };
    /// assert!(scene.ray(&ray, f64::INFINITY, &[section])?.is_none());
    /// # Ok::<(), Error>(())
    /// ```
    pub fn ray(&self, ray: &Ray, max: f64, sections: &[HalfSpace]) -> Result<Option<RayHit>> {
        self.pools.rays.with(|scratch| rays::query::first(&self.index, ray, max, sections, scratch))
    }

    /// [`ray`](Self::ray) of many rays, in parallel on the current rayon pool.
    pub fn rays(&self, rays: &[Ray], max: f64, sections: &[HalfSpace]) -> Result<Vec<Option<RayHit>>> {
        rays::query::firsts(&self.index, &self.pools.rays, rays, max, sections)
    }

    /// The cut of the plane through `point` across `normal`, one segment per triangle, sorted by triangle; in parallel
    /// on the current rayon pool.
    ///
    /// The side of each corner is exact. Corners on the plane count as behind it: the outline is that of the material
    /// in front of the plane, and outlines of closed surfaces are closed. A triangle in the plane yields nothing; its
    /// neighbours in front of the plane yield its border. Surfaces that touch the plane from behind yield nothing.
    /// Segments of triangles that share an edge share its point exactly. Seen from the side that the normal points to,
    /// they have the body on their left if triangles are wound outwards.
    ///
    /// Errors: a normal of zero, and numbers that are not finite or beyond 1e100 in size.
    ///
    /// ```
    /// # use feeler_core::*;
    /// # let plate = vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];
    /// # let mockup = Mockup::new(plate, vec![[0, 1, 2], [0, 2, 3]], vec![], 1)?;
    /// # let scene = Scene::build(mockup.into(), &SceneOptions::default())?;
    /// let outline = scene.section(&[0.5, 0.0, 0.0], &[1.0, 0.0, 0.0])?;
    /// assert_eq!(outline.triangles, [0, 1]);
    /// assert_eq!(outline.segments[0], [[0.5, 0.5, 0.0], [0.5, -1.0, 0.0]]);
    /// # Ok::<(), Error>(())
    /// ```
    pub fn section(&self, point: &Point, normal: &Point) -> Result<SectionOutline> {
        section::cut::section(self.index.mockup(), self.index.selection(), point, normal)
    }
}

/// What the scene is made of, and means to measure it.
impl Scene {
    /// Voxel edge, or the piece size of blocks, metres.
    pub fn voxel_size(&self) -> f64 {
        self.index.voxel_size()
    }

    /// The store.
    pub fn storage(&self) -> Storage {
        self.index.storage()
    }

    /// The instruction set that queries use.
    pub fn lanes(&self) -> Level {
        self.index.lanes().level()
    }

    /// Has queries use another instruction set than the best; where the CPU lacks it, the best. The answers are the same.
    pub fn set_lanes(&mut self, lanes: Level) {
        self.index.set_lanes(lanes);
    }

    /// Sets the most bytes of a query's result.
    #[doc(hidden)]
    pub fn set_memory_limit(&mut self, bytes: u64) {
        self.index.set_memory_limit(bytes);
    }

    /// Bytes by structure; "triangles" and "parts" are the mock-up's own arrays, which the index reads, "adjacency" the
    /// connectivity computed when a query first needed it.
    pub fn memory(&self) -> Vec<(&'static str, usize)> {
        let mockup = self.mockup();
        let mut structures = self.index.memory();
        structures.push(("triangles", mockup.mesh().memory()));
        structures.push(("parts", mockup.parts_memory()));
        structures.extend(mockup.topology_memory().map(|bytes| ("adjacency", bytes)));
        structures.extend(self.index.selection().memory().map(|bytes| ("selection", bytes)));
        structures
    }

    /// Checks every invariant that queries rely on; for tests.
    #[doc(hidden)]
    pub fn validate(&self) -> std::result::Result<(), String> {
        self.index.validate()
    }

    /// [`collide`](Self::collide) with filters switched off, to measure their effect. The answer is the same.
    pub fn collide_filtered(&self, tool: &Tool, pose: &Pose, filters: Filters) -> Collision {
        let mut collision = Collision::default();
        self.collide_into(tool, pose, filters, &mut collision);
        collision
    }

    /// As [`collide_filtered`](Self::collide_filtered), into an existing result whose memory is used again: allocates nothing once
    /// that and the working memory have grown to the need.
    pub fn collide_into(&self, tool: &Tool, pose: &Pose, filters: Filters, out: &mut Collision) {
        let done = self.collide_while((tool, pose), filters, GoOn::default(), out);
        debug_assert!(done.is_ok(), "nothing stops it");
    }

    pub(crate) fn collide_while(
        &self,
        (tool, pose): (&Tool, &Pose),
        filters: Filters,
        go_on: GoOn<'_>,
        out: &mut Collision,
    ) -> Result<()> {
        let (index, pool) = (&self.index, &self.pools.collide);
        pool.with(|scratch| collide::query::collide_into(index, tool, pose, filters, go_on, scratch, out))
    }
}
