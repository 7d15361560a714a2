//! The traits between index and queries: queries stand above the index, which knows them only by these.

use feeler_lanes::{Checked, Simd, LANES};

use crate::geometry::bounds::{Aabb, Point};
use crate::geometry::pose::Pose;
use crate::index::selection::Selection;
use crate::mesh::mockup::Mockup;
use crate::mesh::triangle_mesh::Mesh;
use crate::tool::motion::Window;
use crate::tool::moving_tool::Tool;

/// A tool at a pose, and the mesh whose triangles it may meet.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PlacedTool<'a> {
    /// The mock-up.
    pub mockup: &'a Mockup,
    /// Its triangles.
    pub mesh: &'a Mesh,
    /// The tool.
    pub tool: &'a Tool,
    /// `world_from_tool`.
    pub pose: &'a Pose,
    /// The instruction set.
    pub lanes: Checked,
    /// The selection. A hint: others may be offered all the same.
    pub selection: &'a Selection,
    /// By how much farther than [`Tool::margin_at`] (metres, per axis) a triangle of either may be off: where `mesh` is placed, too.
    pub spread: f64,
}

/// Takes candidate pairs: those that the index cannot hold apart.
pub(crate) trait CandidateSink {
    /// Whether boxes are compared before a pair is offered.
    fn compares_boxes(&self) -> bool;

    /// The counters of the stages.
    fn stats(&mut self) -> &mut Stats;

    /// The box of a tool triangle (by slot) at the pose.
    fn placed_bounds(&mut self, slot: u32) -> Aabb;

    /// Takes a candidate pair; true when the query is over. `may_repeat` says whether the pair could be offered again.
    fn offer(&mut self, slot: u32, mockup_triangle: u32, may_repeat: bool) -> bool;

    /// Takes candidate pairs of one mock-up triangle with the tool triangles in the lanes chosen; true when the query is over.
    fn offer_lanes<S: Simd>(&mut self, s: S, chosen: u16, slots: &[u32; LANES], mockup_triangle: u32) -> bool;

    /// As [`offer_lanes`](Self::offer_lanes), of one tool triangle with the mock-up triangles in the lanes chosen. `ask` says for
    /// which lanes to ask: each mock-up triangle once, not with every row that it is in.
    fn offer_row<S: Simd>(&mut self, s: S, slot: u32, chosen: u16, ask: u16, triangles: &[u32; LANES]) -> bool;
}

/// Counts of a query, stage by stage.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Stats {
    /// Voxels looked up; with blocks, nodes tested: against one box their 32 children, against 16 their own box.
    pub voxels_visited: u64,
    /// With blocks: clusters of 16 tool pieces that were placed.
    pub clusters_placed: u64,
    /// With blocks: mock-up pieces whose boxes were compared with those of a cluster's 16 pieces.
    pub pieces_scanned: u64,
    /// Pairs of tool triangle and list entry; with blocks, pairs of pieces with overlapping boxes.
    pub entries_scanned: u64,
    /// Pairs that the boxes of their triangles do not hold apart; with blocks, pairs of pieces that neither boxes nor planes do.
    pub box_survivors: u64,
    /// Pairs skipped because they had been seen.
    pub repeats_skipped: u64,
    /// Triangle tests.
    pub triangle_tests: u64,
    /// Triangle tests in which float64 arithmetic could not decide and exact arithmetic did.
    pub exact_tests: u64,
    /// Distinct colliding pairs.
    pub pairs: u64,
}

impl Stats {
    /// Names and values, in order of the stages.
    pub fn entries(&self) -> impl Iterator<Item = (&'static str, u64)> {
        [
            ("voxels_visited", self.voxels_visited),
            ("clusters_placed", self.clusters_placed),
            ("pieces_scanned", self.pieces_scanned),
            ("entries_scanned", self.entries_scanned),
            ("box_survivors", self.box_survivors),
            ("repeats_skipped", self.repeats_skipped),
            ("triangle_tests", self.triangle_tests),
            ("exact_tests", self.exact_tests),
            ("pairs", self.pairs),
        ]
        .into_iter()
    }
}

/// A tool at a pose, the mock-up that it may be near, and planes that hold some of it apart.
#[derive(Debug, Clone, Copy)]
pub(crate) struct NearTool<'a> {
    /// The mock-up.
    pub mockup: &'a Mockup,
    /// The tool.
    pub tool: &'a Tool,
    /// `world_from_tool`.
    pub pose: &'a Pose,
    /// The instruction set.
    pub lanes: Checked,
    /// The selection. A hint: others may be offered all the same.
    pub selection: &'a Selection,
    /// Sorted by part. A hint: pairs they hold apart may be offered all the same.
    pub dividers: &'a [Divider],
}

/// A plane between the tool and one part: pairs that lie wholly on its two sides are not asked for.
#[derive(Debug, Clone, Copy)]
pub struct Divider {
    /// The part.
    pub part: u32,
    /// Unit, to the tool's side.
    pub normal: Point,
    /// Heights along it, metres: the mock-up's triangle is nowhere higher than the first, the tool's nowhere lower than the
    /// second.
    pub heights: [f64; 2],
}

/// Takes pairs that may be near.
pub(crate) trait NearSink {
    /// The largest distance (metres) still of interest; falls as the search goes on.
    fn bound(&self) -> f64;

    /// Whether [`bound_of`](Self::bound_of) may be less than the bound.
    fn has_bounds_of_parts(&self) -> bool;

    /// The same for pairs with one triangle of the mock-up; `None` where none of them is of interest. A hint: others may be offered
    /// all the same.
    fn bound_of(&self, mockup_triangle: u32) -> Option<f64>;

    /// By how much (metres, per axis) the tool's boxes must grow, so that no bound from boxes is above the distance that the
    /// triangle test computes.
    fn margin(&self) -> f64;

    /// From tool to mock-up at the closest pair found last, of length 1; zero where there is none, or they meet.
    fn direction(&self) -> [f32; 3];

    /// Whether pairs are to be offered to [`collect`](Self::collect), every time they come, and not to [`take`](Self::take).
    fn is_collecting(&self) -> bool;

    /// Notes a pair (the tool's triangle by slot) and a bound on the distance of the pieces found, metres; true when there are
    /// too many.
    fn collect(&mut self, slot: u32, mockup_triangle: u32, bound: f64) -> bool;

    /// Counts a step of the search: a pair of nodes, or a cluster and a block. Whether the search must stop.
    fn must_stop(&mut self) -> bool;

    /// Takes the pair of a tool triangle (by slot) and a mock-up triangle; true when the search is over.
    fn take(&mut self, slot: u32, mockup_triangle: u32) -> bool;
}

/// Takes triangles that a ray may meet.
pub(crate) trait RaySink {
    /// Where along the ray (shares of its direction) nothing is of interest any more; falls as the search goes on.
    fn limit(&self) -> f64;

    /// Takes triangles, the nearest boxes first; some come more than once, and some that are not asked for.
    fn take(&mut self, triangles: &[u32]);
}

/// Takes pairs of triangles of different parts of one mock-up that may meet.
pub(crate) trait SelfSink {
    /// Whether a pair of parts (any order) is still wanted.
    fn wants(&mut self, part: u32, other: u32) -> bool;

    /// Says that a block's pieces come next: their numbers mean others now.
    fn begin_block(&mut self);

    /// Takes a triangle (of the piece of this number of the block) and those chosen of others.
    fn offer<S: Simd>(&mut self, s: S, piece: u32, triangle: u32, chosen: u32, others: &[u32; 2 * LANES]);
}

/// Takes pairs of triangles of different parts of one mock-up that may be near.
pub(crate) trait SelfNearSink {
    /// How far a pair of parts (any order) may be apart to be of interest, still: the square, in frame units; negative: not at all.
    fn limit(&mut self, part: u32, other: u32) -> f32;

    /// Takes a pair of triangles, and the square of a bound on their distance, in frame units.
    fn offer(&mut self, bound: f32, triangle: u32, other: u32);

    /// Says that a block is done.
    fn end_block(&mut self);
}

/// A tool on its way through a window of time.
pub(crate) struct Sweep<'a> {
    /// The mock-up's triangles.
    pub mesh: &'a Mesh,
    /// The tool.
    pub tool: &'a Tool,
    /// Where the tool is meanwhile.
    pub window: Window,
    /// The instruction set.
    pub lanes: Checked,
    /// The selection. A hint: others may be offered all the same.
    pub selection: &'a Selection,
    /// Whether the store may give up where a shorter window would do better.
    pub may_give_up: bool,
}

/// Takes a slot of the tool and a triangle of the mock-up; true to stop.
pub(crate) type Offer<'a> = &'a mut dyn FnMut(u32, u32) -> bool;
