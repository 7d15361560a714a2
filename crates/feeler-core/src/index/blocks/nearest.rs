//! The distance search in lanes: branch and bound as in [`plain_search`](crate::index::plain_search); pairs of a tool
//! entry and a node are descended together, nearest first.
//!
//! Bounds are squared distances in frame units, between float32 boxes that cover their content; they are compared with
//! [`Search::limit`], which is rounded up, so nothing relevant is dropped.

use super::nearest_leaf::Candidate;
use super::node::Node;
use super::node::FANOUT;
use super::pieces::HalfBlock;
use super::separating_planes::{Above, Dividers};
use super::tree::Blocks;
use crate::constants::{BOUND_ROUNDING, FAR_MARGIN, LARGEST_BOUND, VANISHING_SQUARE};
use crate::index::interner::KeySet;
use crate::index::plain_search::{search, SearchScratch};
use crate::index::selection::there as selected;
use crate::index::sink::{NearSink, NearTool};
use crate::tool::placement::{PlaceBoxes, PlacedPieces, Placement};
use feeler_lanes::{prefetch, prefetch_at, Box4, Checked, Kernel, LaneBoxes, Simd, Sorter, LANES};

/// Working memory of a search.
#[derive(Debug, Default)]
pub struct NearScratch {
    stack: Vec<Pair>,
    waiting: Waiting,
    pub(super) clusters: PlacedClusters,
    pub(super) block: UnpackedBlock,
    pub(super) seen: KeySet,
    pub(super) candidates: Vec<Candidate>,
}

/// A tool entry and a node, not yet looked into.
#[derive(Debug, Clone, Copy)]
struct Pair {
    bound: f32,
    /// 0 for clusters and blocks.
    tool_level: u8,
    level: u8,
    entry: u32,
    node: u32,
    /// The entry's box.
    bounds: Box4,
}

/// Clusters that arrived at blocks: the block in the upper half of a number, the cluster in the lower.
#[derive(Debug, Default)]
struct Waiting(Sorter);

/// This many wait where the order is of no use: they are looked into block by block, so that each block is unpacked once. Few in
/// tests, so that there are more of them.
const MOST_WAITING: usize = if cfg!(test) { 16 } else { 4096 };

/// Arrivals by which the pieces of a block are prefetched ahead.
const ARRIVALS_AHEAD: usize = 12;

impl Waiting {
    fn push(&mut self, cluster: u32, block: u32) {
        self.0.keys.push(u64::from(block) << 32 | u64::from(cluster));
    }

    fn clear(&mut self) {
        self.0.clear();
    }

    fn len(&self) -> usize {
        self.0.keys.len()
    }

    /// Puts them in the order of the blocks and forgets them; returns how many they are.
    fn put_in_order(&mut self, lanes: Checked) -> usize {
        self.0.sort(lanes);
        self.0.keys.clear();
        self.0.sorted().len()
    }

    /// Cluster and block.
    #[inline(always)]
    fn get(&self, at: usize) -> (usize, u32) {
        let key = self.0.sorted()[at];
        (key as u32 as usize, (key >> 32) as u32)
    }
}

impl Pair {
    /// Whether it is the tool's entry that is looked into next, and not the node.
    #[inline(always)]
    fn opens_tool(&self, node: &Node) -> bool {
        self.level == 0 || self.tool_level > 0 && size(&self.bounds) >= size(&node.bounds())
    }
}

/// The clusters a search has placed so far.
#[derive(Debug, Default)]
pub struct PlacedClusters {
    /// For each cluster the search that placed it, and where.
    places: Vec<(u32, u32)>,
    placed: Vec<PlacedPieces>,
    /// For each of those and each part with dividers, one after the other, what is on their far side.
    above: Vec<Above>,
    count: usize,
    search: u32,
}

/// The block looked into last.
#[derive(Debug)]
pub struct UnpackedBlock {
    pub halves: Box<[HalfBlock; 2]>,
    pub block: u32,
    pub has_corners: bool,
    /// Of the pieces that `is_judged` has: their dividers' place among those of all parts, and which they are behind.
    pub is_judged: u32,
    pub behind: [(u8, u16); FANOUT],
}

impl Default for UnpackedBlock {
    fn default() -> UnpackedBlock {
        UnpackedBlock {
            halves: Box::new([HalfBlock::ZERO; 2]),
            block: u32::MAX,
            has_corners: false,
            is_judged: 0,
            behind: [(0, 0); FANOUT],
        }
    }
}

impl PlacedClusters {
    fn begin(&mut self, clusters: usize) {
        if self.search == u32::MAX {
            self.places.fill((0, 0));
            self.search = 0;
        }
        self.search += 1;
        self.count = 0;
        self.above.clear();
        if self.places.len() < clusters {
            self.places.resize(clusters, (0, 0));
        }
    }

    /// A cluster at the pose.
    #[inline(always)]
    pub fn get<S: Simd, W>(&mut self, s: S, run: &Search<'_, W>, cluster: usize) -> (&mut PlacedPieces, &mut [Above]) {
        let (search, at) = self.places[cluster];
        let parts = run.dividers.len();
        if search == self.search {
            let at = at as usize;
            return (&mut self.placed[at], &mut self.above[at * parts..(at + 1) * parts]);
        }
        let at = self.count;
        self.count += 1;
        self.places[cluster] = (self.search, at as u32);
        if self.placed.len() <= at {
            self.placed.push(PlacedPieces::ZERO);
        }
        let placed = &mut self.placed[at];
        run.placement.place_pieces(s, &run.at.tool.clusters()[cluster].corners, placed);
        self.above.resize(self.above.len() + parts, Above::default());
        (placed, &mut self.above[at * parts..])
    }
}

impl Blocks {
    /// Hands `wanted` every pair of triangles that may be within its bound, nearest boxes first, until it says stop.
    pub fn search<W: NearSink>(
        &self,
        at: &NearTool<'_>,
        plain: &mut SearchScratch,
        scratch: &mut NearScratch,
        wanted: &mut W,
    ) {
        let margin = wanted.margin();
        let NearTool { tool, pose, lanes, .. } = *at;
        let placement = Placement::new(tool.unit(), pose, margin, &self.frame.origin, self.frame.scale);
        if placement.margin() > FAR_MARGIN {
            return search(self, at, plain, wanted);
        }
        scratch.clusters.begin(tool.clusters().len());
        scratch.block.block = u32::MAX;
        scratch.seen.clear();
        let bounds = self.frame.to_box4(&pose.apply_box(&tool.mesh().bounds(), margin));
        // The conversion rounds; the placement's margin is far more.
        let grown = |x: [f32; 4], by: f32| x.map(|x| x + by);
        let bounds =
            Box4 { lower: grown(bounds.lower, -placement.margin()), upper: grown(bounds.upper, placement.margin()) };
        let dividers = Dividers::new(at.dividers, &self.frame, placement.slack + self.slack);
        let mut run = Search { blocks: self, at: *at, placement, limit: 0.0, direction: [0.0; 3], dividers, wanted };
        run.update_limit();
        scratch.waiting.clear();
        scratch.stack.clear();
        scratch.stack.push(Pair {
            bound: 0.0,
            tool_level: tool.height() as u8,
            level: self.levels.len() as u8 - 1,
            entry: 0,
            node: 0,
            bounds,
        });
        let run = &mut run;
        if run.wanted.is_collecting() {
            lanes.run(Collect { run, scratch });
        } else {
            lanes.run(Descend { run, scratch });
        }
    }
}

/// The constants of a search, and its limit.
pub struct Search<'a, W> {
    pub blocks: &'a Blocks,
    pub at: NearTool<'a>,
    pub placement: Placement,
    /// The square of the largest distance of interest, frame units, rounded up.
    pub limit: f32,
    /// From tool to mock-up at the closest pair so far: along it, most pairs farther apart are separated.
    pub direction: [f32; 3],
    pub dividers: Vec<Dividers>,
    pub wanted: &'a mut W,
}

impl<W: NearSink> Search<'_, W> {
    /// After a pair was taken.
    #[inline(always)]
    pub fn update_limit(&mut self) {
        self.direction = self.wanted.direction();
        self.limit = self.limit_at(self.wanted.bound());
    }

    /// The limit for a largest distance, metres.
    #[inline(always)]
    pub fn limit_at(&self, bound: f64) -> f32 {
        let bound = bound * self.blocks.frame.scale;
        // Bounds have a few roundings of 2^-24 each; the last term covers squares that underflow.
        if bound < LARGEST_BOUND {
            (bound * bound * (1.0 + BOUND_ROUNDING) + VANISHING_SQUARE) as f32
        } else {
            f32::INFINITY
        }
    }
}

/// Goes down nearest first.
struct Descend<'a, 'b, W> {
    run: &'a mut Search<'b, W>,
    scratch: &'a mut NearScratch,
}

impl<W: NearSink> Kernel for Descend<'_, '_, W> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, s: S) {
        let Descend { run, scratch } = self;
        let tool = run.at.tool;
        let levels = &run.blocks.levels;
        let mut near = Near::ZERO;
        while let Some(pair) = scratch.stack.pop() {
            if pair.bound > run.limit {
                continue;
            }
            let node = &levels[pair.level as usize][pair.node as usize];
            if pair.level == 0 && pair.tool_level == 0 {
                if run.wanted.must_stop() || super::nearest_leaf::scan(s, run, scratch, pair.entry as usize, pair.node)
                {
                    return;
                }
                continue;
            }
            if pair.opens_tool(node) {
                let boxes = &tool.children(pair.tool_level as usize)[pair.entry as usize];
                let mut placed = LaneBoxes::ZERO;
                run.placement.place_boxes(s, boxes, &mut placed);
                let mut found = near.of_lanes(s, &placed, &node.bounds(), run.limit) & u32::from(boxes.used);
                let count = near.list(&mut found);
                for at in (0..count).rev() {
                    let i = near.order[at] as u32 as usize;
                    let entry = LANES as u32 * pair.entry + i as u32;
                    if pair.tool_level == 1 {
                        prefetch(&tool.clusters()[entry as usize]);
                    }
                    scratch.stack.push(Pair {
                        bound: near.bounds[i],
                        tool_level: pair.tool_level - 1,
                        entry,
                        bounds: placed.lane(i),
                        ..pair
                    });
                }
            } else {
                let there = run.at.selection.children(pair.level as usize);
                let mut found = selected(there, pair.node, near.of_children(s, node, &pair.bounds, run.limit));
                let count = near.list(&mut found);
                for at in (0..count).rev() {
                    let i = near.order[at] as u32 as usize;
                    let child = FANOUT as u32 * pair.node + i as u32;
                    prefetch(&levels[pair.level as usize - 1][child as usize]);
                    scratch.stack.push(Pair { bound: near.bounds[i], level: pair.level - 1, node: child, ..pair });
                }
            }
        }
    }
}

/// Goes down where the order is of no use: block by block in the end, so that each is unpacked once.
struct Collect<'a, 'b, W> {
    run: &'a mut Search<'b, W>,
    scratch: &'a mut NearScratch,
}

impl<W: NearSink> Kernel for Collect<'_, '_, W> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, s: S) {
        let Collect { run, scratch } = self;
        loop {
            reach(s, run, scratch);
            let count = scratch.waiting.put_in_order(run.at.lanes);
            if count == 0 {
                return;
            }
            for at in 0..count {
                let (cluster, block) = scratch.waiting.get(at);
                if at + ARRIVALS_AHEAD < count {
                    let (_, later) = scratch.waiting.get(at + ARRIVALS_AHEAD);
                    if later != scratch.waiting.get(at + ARRIVALS_AHEAD - 1).1 {
                        prefetch_at(&run.blocks.pieces, later as usize);
                    }
                }
                if run.wanted.must_stop() || super::nearest_leaf::scan(s, run, scratch, cluster, block) {
                    return;
                }
            }
        }
    }
}

/// Goes down in any order, until all clusters arrived at blocks that do, or many.
#[inline(always)]
fn reach<S: Simd, W>(s: S, run: &Search<'_, W>, scratch: &mut NearScratch) {
    let NearScratch { stack, waiting, .. } = scratch;
    let (tool, levels) = (run.at.tool, &run.blocks.levels);
    let limit = s.splat(run.limit);
    while waiting.len() < MOST_WAITING {
        let Some(pair) = stack.pop() else { return };
        let node = &levels[pair.level as usize][pair.node as usize];
        match (pair.tool_level, pair.level) {
            (0, 0) => waiting.push(pair.entry, pair.node),
            _ if pair.opens_tool(node) => {
                let boxes = &tool.children(pair.tool_level as usize)[pair.entry as usize];
                let mut placed = LaneBoxes::ZERO;
                run.placement.place_boxes(s, boxes, &mut placed);
                let squared = gaps(s, &placed.lower, &placed.upper, &node.bounds());
                let mut found = !s.lanes(s.above(squared, limit)) & boxes.used;
                while found != 0 {
                    let i = found.trailing_zeros() as usize;
                    found &= found - 1;
                    let entry = LANES as u32 * pair.entry + i as u32;
                    if pair.tool_level == 1 {
                        prefetch_at(tool.clusters(), entry as usize);
                    }
                    if (pair.tool_level, pair.level) == (1, 0) {
                        waiting.push(entry, pair.node);
                    } else {
                        let (tool_level, bounds) = (pair.tool_level - 1, placed.lane(i));
                        stack.push(Pair { tool_level, entry, bounds, ..pair });
                    }
                }
            }
            _ => {
                let (mut half, mut found) = (LaneBoxes::ZERO, 0);
                for h in 0..2 {
                    node.unpack(s, h, &mut half.lower, &mut half.upper);
                    let squared = gaps(s, &half.lower, &half.upper, &pair.bounds);
                    found |= u32::from(!s.lanes(s.above(squared, limit))) << (LANES * h);
                }
                found = selected(run.at.selection.children(pair.level as usize), pair.node, found & node.valid);
                while found != 0 {
                    let child = FANOUT as u32 * pair.node + found.trailing_zeros();
                    found &= found - 1;
                    prefetch_at(&levels[pair.level as usize - 1], child as usize);
                    if (pair.tool_level, pair.level) == (0, 1) {
                        waiting.push(pair.entry, child);
                    } else {
                        stack.push(Pair { level: pair.level - 1, node: child, ..pair });
                    }
                }
            }
        }
    }
}

#[inline(always)]
fn size(b: &Box4) -> f32 {
    let side = |a: usize| b.upper[a] - b.lower[a];
    side(0).max(side(1)).max(side(2))
}

/// The squares of the distances of sixteen boxes from one.
#[inline(always)]
pub fn gaps<S: Simd>(s: S, lower: &[[f32; LANES]; 3], upper: &[[f32; LANES]; 3], b: &Box4) -> S::F32 {
    let zero = s.splat(0.0);
    let mut squared = zero;
    for a in 0..3 {
        let (l, u) = (s.load(&lower[a]), s.load(&upper[a]));
        let gap = s.max(s.max(l - s.splat(b.upper[a]), s.splat(b.lower[a]) - u), zero);
        squared = s.mul_add(gap, gap, squared);
    }
    squared
}

/// Bounds of up to 32 boxes from one, and their order.
pub struct Near {
    pub bounds: [f32; FANOUT],
    /// Squares of distances between the middles.
    middles: [f32; FANOUT],
    /// Key in the upper half, place in the lower; see [`list`](Self::list).
    pub order: [u64; FANOUT],
}

impl Near {
    pub const ZERO: Near = Near { bounds: [0.0; FANOUT], middles: [0.0; FANOUT], order: [0; FANOUT] };

    /// The children of a node from a box; returns which are within the limit.
    #[inline(always)]
    pub fn of_children<S: Simd>(&mut self, s: S, node: &Node, b: &Box4, limit: f32) -> u32 {
        let mut half = LaneBoxes::ZERO;
        let mut found = 0;
        for h in 0..2 {
            node.unpack(s, h, &mut half.lower, &mut half.upper);
            found |= self.of(s, &half.lower, &half.upper, b, limit, LANES * h) << (LANES * h);
        }
        found & node.valid
    }

    /// Sixteen boxes from a box; returns which are within the limit.
    #[inline(always)]
    pub fn of_lanes<S: Simd>(&mut self, s: S, boxes: &LaneBoxes, b: &Box4, limit: f32) -> u32 {
        self.of(s, &boxes.lower, &boxes.upper, b, limit, 0)
    }

    #[inline(always)]
    pub fn of<S: Simd>(
        &mut self,
        s: S,
        lower: &[[f32; LANES]; 3],
        upper: &[[f32; LANES]; 3],
        b: &Box4,
        limit: f32,
        from: usize,
    ) -> u32 {
        let squared = gaps(s, lower, upper, b);
        let mut middles = s.splat(0.0);
        for a in 0..3 {
            let middle = s.load(&lower[a]) + s.load(&upper[a]) - s.splat(b.lower[a] + b.upper[a]);
            middles = s.mul_add(middle, middle, middles);
        }
        s.store(squared, (&mut self.bounds[from..from + LANES]).try_into().expect("16 of 32"));
        s.store(middles, (&mut self.middles[from..from + LANES]).try_into().expect("16 of 32"));
        u32::from(!s.lanes(s.above(squared, s.splat(limit))))
    }

    /// Puts the places chosen into `order`, nearest first; of boxes that overlap, those whose middles are closer. Returns how many.
    #[inline(always)]
    pub fn list(&mut self, chosen: &mut u32) -> usize {
        let mut count = 0;
        while *chosen != 0 {
            let i = chosen.trailing_zeros() as usize;
            *chosen &= *chosen - 1;
            // Positive numbers are ordered as their bits are.
            let key = self.bounds[i] + 1e-3 * self.middles[i];
            let key = u64::from(key.to_bits()) << 32 | i as u64;
            let mut at = count;
            while at > 0 && self.order[at - 1] > key {
                self.order[at] = self.order[at - 1];
                at -= 1;
            }
            self.order[at] = key;
            count += 1;
        }
        count
    }
}
