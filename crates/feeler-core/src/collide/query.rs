//! Every pair of triangles that collides at a pose, or whether there is any.

use super::hits::{Hit, Hits};
use super::narrow::{Filters, Narrow, Pending, PlacedBounds, Until, BATCHES_BETWEEN};
use super::touching::Surfaces;
use crate::error::{Error, Result};
use crate::geometry::intersect_triangle_triangle::PairKind;
use crate::geometry::pose::Pose;
use crate::index::blocks::BlocksScratch;
use crate::index::interner::KeySet;
use crate::index::mockup_index::Index;
use crate::index::sink::{PlacedTool, Stats};
use crate::mesh::triangle_mesh::Corners;
use crate::progress::{GoOn, Pace};
use crate::tool::moving_tool::Tool;

/// The colliding pairs of triangles at one pose: `k` pairs and their kinds, sorted.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Collision {
    /// `(k, 2)`: `[tool triangle, mock-up triangle]`, unique, sorted.
    pub pairs: Vec<[u32; 2]>,
    /// `(k,)`: the kind of each pair.
    pub kinds: Vec<PairKind>,
    /// Counters of the query, for measurements; they may change from version to version.
    pub stats: Stats,
}

/// Working memory of one query at a time; queries allocate nothing once it has grown to their needs.
#[derive(Debug, Default)]
#[repr(align(128))] // two threads never write to one line, nor to the pair of lines that is fetched together
pub(crate) struct CollideScratch {
    placed: PlacedBounds,
    seen: KeySet,
    pending: Pending,
    blocks: BlocksScratch,
    hits: Hits,
    stats: Stats,
}

impl CollideScratch {
    /// The pairs that the last query found, in order, each once.
    pub(crate) fn sorted(&self) -> impl ExactSizeIterator<Item = Hit> + '_ {
        self.hits.sorted()
    }
}

/// Every pair that meets, sorted by tool triangle, then mock-up triangle, into a result whose memory is used again. Exact. An error
/// where it was stopped.
pub(crate) fn collide_into(
    index: &Index,
    tool: &Tool,
    pose: &Pose,
    filters: Filters,
    go_on: GoOn<'_>,
    scratch: &mut CollideScratch,
    out: &mut Collision,
) -> Result<()> {
    let how = How { filters, until: Until::End, go_on };
    run(index, tool, pose, how, scratch)?;
    out.pairs.clear();
    out.kinds.clear();
    scratch.hits.unpack(index.lanes(), &mut out.pairs, &mut out.kinds);
    out.stats = scratch.stats;
    Ok(())
}

/// Any pair that meets, `[tool triangle, mock-up triangle]`; stops at the first.
pub(crate) fn any_pair(index: &Index, tool: &Tool, pose: &Pose, scratch: &mut CollideScratch) -> Option<[u32; 2]> {
    run(index, tool, pose, How::until(Until::First), scratch).ok()?;
    scratch.hits.sorted().next().map(Hit::pair)
}

/// Any pair at which one body enters the other, `[tool triangle, mock-up triangle]`; `None` where they only touch.
pub(crate) fn entering_pair(index: &Index, tool: &Tool, pose: &Pose, scratch: &mut CollideScratch) -> Option<[u32; 2]> {
    run(index, tool, pose, How::until(Until::Crossing), scratch).ok()?;
    let mut hits = scratch.hits.sorted().peekable();
    hits.peek()?;
    let mockup = index.mockup();
    let surfaces = Surfaces {
        tool: &|t| pose.apply_triangle(&tool.mesh().triangle(t)),
        mockup: &|m| mockup.mesh().triangle(m),
        adjacency: [tool.adjacency(), mockup.adjacency()],
        is_turned: [false; 2],
    };
    surfaces.entering(hits)
}

/// How a query works.
#[derive(Clone, Copy)]
pub(super) struct How<'a> {
    pub filters: Filters,
    pub until: Until,
    pub go_on: GoOn<'a>,
}

impl How<'_> {
    /// With all filters, and without a request to stop.
    fn until(until: Until) -> How<'static> {
        How { filters: Filters::default(), until, go_on: GoOn::default() }
    }
}

/// One query: `scratch.hits` afterwards holds the sorted, unique pairs. An error where it was stopped.
pub(super) fn run(index: &Index, tool: &Tool, pose: &Pose, how: How<'_>, scratch: &mut CollideScratch) -> Result<()> {
    let mockup = index.mockup();
    let (mesh, lanes, selection) = (mockup.mesh(), index.lanes(), index.selection());
    let at = PlacedTool { mockup, mesh, tool, pose, lanes, selection, spread: 0.0 };
    run_at(index, &at, &at, mesh.corners(), how, scratch)
}

/// The same of a mock-up that is placed, too: the store is asked for the tool as the mock-up's frame has it, `offered`, and pairs are
/// tested where both are, the tool at `at` and the mock-up's triangles at `corners`.
fn run_at(
    index: &Index,
    offered: &PlacedTool<'_>,
    at: &PlacedTool<'_>,
    corners: Corners<'_>,
    how: How<'_>,
    scratch: &mut CollideScratch,
) -> Result<()> {
    let How { filters, until, go_on } = how;
    let CollideScratch { placed, seen, pending, blocks, hits, stats } = scratch;
    placed.begin();
    seen.clear();
    pending.clear();
    hits.clear();
    *stats = Stats::default();
    let pace = Pace::new(go_on, BATCHES_BETWEEN);
    let mut narrow = Narrow { at: *at, corners, filters, until, placed, seen, pending, hits, stats, pace };
    for (store, selection) in index.stores() {
        narrow.at.selection = selection;
        store.offer_candidates(&PlacedTool { selection, ..*offered }, blocks, &mut narrow);
        if narrow.pace.is_stopped() {
            return Err(Error::Cancelled);
        }
        narrow.finish();
        if narrow.is_over() {
            break;
        }
    }
    hits.sort(index.lanes());
    stats.pairs = hits.sorted().len() as u64;
    Ok(())
}

/// A tool at a pose, and an index whose mesh is placed, too.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BothPlaced<'a> {
    pub index: &'a Index,
    /// The mesh's corners in the world.
    pub corners: Corners<'a>,
    pub tool: &'a Tool,
    /// `world_from_tool`.
    pub pose: &'a Pose,
    /// `mesh_from_tool`, rounded.
    pub relative: &'a Pose,
    /// How far (metres, per axis of the mesh's frame) rounding may take a triangle of the tool at that from where it is to one of the
    /// mesh, beyond [`Tool::margin_at`].
    pub spread: f64,
}

/// Every pair of a tool and a mesh that are both placed: stops at the first where only one is asked for. `scratch.sorted` has them.
pub(crate) fn meet(
    both: &BothPlaced<'_>,
    is_first_enough: bool,
    go_on: GoOn<'_>,
    scratch: &mut CollideScratch,
) -> Result<()> {
    let BothPlaced { index, corners, tool, pose, relative, spread } = *both;
    let mockup = index.mockup();
    let (mesh, lanes, selection) = (mockup.mesh(), index.lanes(), index.selection());
    let at = PlacedTool { mockup, mesh, tool, pose, lanes, selection, spread };
    let until = if is_first_enough { Until::First } else { Until::End };
    let how = How { go_on, ..How::until(until) };
    run_at(index, &PlacedTool { pose: relative, ..at }, &at, corners, how, scratch)
}
