//! The query: tool tree and block tree are descended together (two trees: S. Gottschalk, M. Lin and D. Manocha,
//! *OBBTree*, 1996), the tool's depth first, each of its entries with the list of nodes that it overlaps, and one box
//! against all children of a node in lanes.

use super::node::Node;
use super::node::FANOUT;
use super::piece_scan::RowsScratch;
use super::pieces::HalfBlock;
use super::scan::{Arrival, PiecePair, Reached, Run, Scan, PIECE_PAIRS};
use super::tree::Blocks;
use crate::index::selection::{there as selected, Selection};
use crate::index::sink::{CandidateSink, PlacedTool};
use crate::tool::moving_tool::Tool;
use crate::tool::placement::{BoxLanes, PlaceBoxes, PlacedPieces, Placement};
use feeler_lanes::{prefetch_at, Box4, Checked, Kernel, LaneBoxes, Simd, SpreadBoxes, LANES};

/// Working memory of a query.
#[derive(Debug)]
pub struct BlocksScratch {
    pub(super) nodes: Vec<u32>,
    pub(super) masks: Vec<u16>,
    pub(super) children: Vec<LaneBoxes>,
    pub(super) spread: Box<SpreadBoxes>,
    /// The group at work, and the one that waits.
    pub(super) reached: Box<[Reached; 2]>,
    pub(super) pieces: Box<[PlacedPieces; LANES]>,
    pub(super) halves: Box<[HalfBlock; 2]>,
    /// Blocks with something in `found`, and from where.
    pub(super) runs: Vec<Run>,
    /// Clusters of the group that meet pieces of a block, and which.
    pub(super) found: Vec<(u32, u32)>,
    pub(super) pairs: Box<[PiecePair; PIECE_PAIRS]>,
    pub(super) rows: Box<RowsScratch>,
}

/// Entries that lists of a query have room for from the start.
const SCRATCH_ROOM: usize = 2048;

impl Default for BlocksScratch {
    fn default() -> BlocksScratch {
        BlocksScratch {
            // Small buffers of two threads' scratches could come to lie in one cache line, and would be fought for.
            nodes: Vec::with_capacity(SCRATCH_ROOM),
            masks: Vec::with_capacity(SCRATCH_ROOM),
            children: Vec::new(),
            spread: Box::new(SpreadBoxes::ZERO),
            reached: Box::new([Reached::new(SCRATCH_ROOM), Reached::new(SCRATCH_ROOM)]),
            pieces: Box::new([PlacedPieces::ZERO; LANES]),
            halves: Box::new([HalfBlock::ZERO; 2]),
            runs: Vec::with_capacity(SCRATCH_ROOM),
            found: vec![(0, 0); SCRATCH_ROOM],
            pairs: Box::new([PiecePair::ZERO; PIECE_PAIRS]),
            rows: Box::default(),
        }
    }
}

impl Blocks {
    /// Offers every pair of pieces that boxes and planes do not hold apart to the narrow phase, until it says stop.
    pub fn offer_candidates<N: CandidateSink>(&self, at: &PlacedTool<'_>, scratch: &mut BlocksScratch, narrow: &mut N) {
        let PlacedTool { mesh, tool, pose, lanes, selection, spread, .. } = *at;
        let margin = tool.margin_at(pose) + spread;
        // In float64 first: a tool far away is done with.
        let whole = pose.apply_box(&tool.mesh().bounds(), margin);
        if !whole.is_overlapping(&mesh.bounds()) {
            return;
        }
        let placement = Placement::new(tool.unit(), pose, margin, &self.frame.origin, self.frame.scale);
        scratch.nodes.clear();
        scratch.nodes.push(0);
        scratch.children.resize(tool.height() + 1, LaneBoxes::ZERO);
        let root = self.frame.to_box4(&whole);
        let mut descent = Descent { blocks: self, tool, lanes, placement, selection, scratch };
        descent.scratch.reached[1].group = None;
        if !descent.descend(tool.height(), 0, &root, self.levels.len() - 1, 0, narrow) {
            descent.scan(None, narrow);
        }
    }
}

struct Descent<'a> {
    blocks: &'a Blocks,
    tool: &'a Tool,
    lanes: Checked,
    placement: Placement,
    selection: &'a Selection,
    /// `nodes` is a stack of node lists; each step of the descent reads the top one and pushes its own. `masks` is the same
    /// for the children of tool entries: which of the 16 meet each node of the list.
    scratch: &'a mut BlocksScratch,
}

impl Descent<'_> {
    /// Lets a group wait, and works on the one that waited. True when the query is over.
    fn scan<N: CandidateSink>(&mut self, arrival: Option<Arrival<'_>>, narrow: &mut N) -> bool {
        let Descent { blocks, tool, lanes, placement, selection, scratch } = self;
        lanes.run(Scan { blocks, tool, lanes: *lanes, placement, selection, scratch, arrival, narrow })
    }

    /// Tests tool entry `entry` of `tool_level` (1: a group of clusters), inside `bounds`, against the nodes `nodes[from..]`
    /// of `level`. True when the query is over.
    ///
    /// The tool entry's box goes down to the level above its children's: these go on from there, so that groups arrive above
    /// blocks, and their clusters test only the blocks they reach.
    fn descend<N: CandidateSink>(
        &mut self,
        tool_level: usize,
        entry: usize,
        bounds: &Box4,
        level: usize,
        from: usize,
        narrow: &mut N,
    ) -> bool {
        let to = self.scratch.nodes.len();
        let (mut level, mut from) = (level, from);
        let Descent { blocks, tool, lanes, placement, selection, scratch } = &mut *self;
        while level > tool_level {
            narrow.stats().voxels_visited += (scratch.nodes.len() - from) as u64;
            let [below, own] = [level - 1, level].map(|l| &blocks.levels[l]);
            let there = selection.children(level);
            from = lanes.run(Expand { level: own, below, there, bounds, nodes: &mut scratch.nodes, from });
            level -= 1;
        }
        let is_above = level == tool_level;
        let over = if scratch.nodes.len() == from {
            false
        } else if tool_level == 1 {
            self.scan(Some(Arrival { group: entry, from, is_above, bounds }), narrow)
        } else {
            let BlocksScratch { nodes, children, spread, .. } = &mut **scratch;
            let (boxes, placed) = (&tool.children(tool_level)[entry], &mut children[tool_level]);
            if is_above {
                narrow.stats().voxels_visited += (nodes.len() - from) as u64;
                let [below, own] = [level - 1, level].map(|l| &blocks.levels[l]);
                let there = selection.children(level);
                let reach = Reach { placement, boxes, level: own, below, there, bounds, nodes, from, placed, spread };
                from = lanes.run(reach);
                level -= 1;
            } else {
                lanes.run(Place { placement, boxes, placed });
            }
            self.scratch.nodes.len() > from && self.descend_children(tool_level, entry, level, from, narrow)
        };
        self.scratch.nodes.truncate(to);
        over
    }

    /// Goes on with each child of a tool entry, and the nodes of `nodes[from..]` whose own box meets the child's.
    fn descend_children<N: CandidateSink>(
        &mut self,
        tool_level: usize,
        entry: usize,
        level: usize,
        from: usize,
        narrow: &mut N,
    ) -> bool {
        let boxes = &self.tool.children(tool_level)[entry];
        let (to, first_mask) = (self.scratch.nodes.len(), self.scratch.masks.len());
        narrow.stats().voxels_visited += (to - from) as u64;
        let BlocksScratch { nodes, masks, children, .. } = &mut *self.scratch;
        let any = self.lanes.run(Children {
            placed: &children[tool_level],
            used: boxes.used,
            level: &self.blocks.levels[level],
            nodes: &nodes[from..],
            masks,
        });
        let over = (0..LANES).any(|i| {
            if any >> i & 1 == 0 {
                return false;
            }
            let BlocksScratch { nodes, masks, children, .. } = &mut *self.scratch;
            // No branch: which nodes a child meets is not to be foreseen.
            nodes.resize(2 * to - from, 0);
            let (above, own) = nodes[from..].split_at_mut(to - from);
            let mut count = 0;
            for (node, mask) in above.iter().zip(&masks[first_mask..]) {
                own[count] = *node;
                count += usize::from(mask >> i & 1);
            }
            nodes.truncate(to + count);
            let bounds = children[tool_level].lane(i);
            let over = self.descend(tool_level - 1, LANES * entry + i, &bounds, level, to, narrow);
            self.scratch.nodes.truncate(to);
            over
        });
        self.scratch.masks.truncate(first_mask);
        over
    }
}

/// Pushes the children, of the nodes `nodes[from..]`, that meet a box; returns where they begin.
pub(super) struct Expand<'a> {
    pub level: &'a [Node],
    pub below: &'a [Node],
    /// Which children are there; see [`Selection::children`].
    pub there: &'a [u32],
    pub bounds: &'a Box4,
    pub nodes: &'a mut Vec<u32>,
    pub from: usize,
}

impl Kernel for Expand<'_> {
    type Output = usize;

    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> usize {
        let Expand { level, below, there, bounds, nodes, from } = self;
        let to = nodes.len();
        for at in from..to {
            let node = nodes[at];
            let mut hit = selected(there, node, level[node as usize].overlapping(s, bounds));
            while hit != 0 {
                let child = FANOUT as u32 * node + hit.trailing_zeros();
                hit &= hit - 1;
                prefetch_at(below, child as usize);
                nodes.push(child);
            }
        }
        to
    }
}

/// Places the children of a tool entry.
pub(super) struct Place<'a, P> {
    pub placement: &'a P,
    pub boxes: &'a BoxLanes,
    pub placed: &'a mut LaneBoxes,
}

impl<P: PlaceBoxes> Kernel for Place<'_, P> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, s: S) {
        self.placement.place_boxes(s, self.boxes, self.placed);
    }
}

/// Pushes the children, of the nodes `nodes[from..]`, that meet the box of a tool entry, less most that none of the entry's own
/// children meets; returns where they begin. If there are any, the entry's children are placed.
pub(super) struct Reach<'a, P> {
    pub placement: &'a P,
    pub boxes: &'a BoxLanes,
    pub level: &'a [Node],
    pub below: &'a [Node],
    /// Which children are there; see [`Selection::children`].
    pub there: &'a [u32],
    pub bounds: &'a Box4,
    pub nodes: &'a mut Vec<u32>,
    pub from: usize,
    pub placed: &'a mut LaneBoxes,
    /// Working memory.
    pub spread: &'a mut SpreadBoxes,
}

/// Children of a node that are worth a closer look: to read one costs as much as comparing its place in the node with several
/// boxes.
const FEW_CHILDREN: u32 = 2;
/// How many boxes a child is worth.
const BOXES_A_CHILD: u32 = 2;

impl<P: PlaceBoxes> Kernel for Reach<'_, P> {
    type Output = usize;

    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> usize {
        let Reach { placement, boxes, level, below, there, bounds, nodes, from, placed, spread } = self;
        let to = nodes.len();
        let mut is_spread = false;
        for at in from..to {
            let node = nodes[at];
            let parent = &level[node as usize];
            let mut hit = selected(there, node, parent.overlapping(s, bounds));
            if hit == 0 {
                continue;
            }
            if nodes.len() == to {
                placement.place_boxes(s, boxes, placed);
            }
            let count = hit.count_ones();
            if count >= FEW_CHILDREN {
                let mut lanes = parent.overlapping_lanes(s, placed) & boxes.used;
                if lanes.count_ones() <= BOXES_A_CHILD * count {
                    if !is_spread {
                        placed.spread(s, spread);
                        is_spread = true;
                    }
                    let mut met = 0;
                    while lanes != 0 {
                        let i = lanes.trailing_zeros() as usize;
                        lanes &= lanes - 1;
                        met |= parent.overlapping_inside(s, &spread.lane(i));
                    }
                    hit &= met;
                }
            }
            while hit != 0 {
                let child = FANOUT as u32 * node + hit.trailing_zeros();
                hit &= hit - 1;
                prefetch_at(below, child as usize);
                nodes.push(child);
            }
        }
        to
    }
}

/// Appends the tool entry's children that overlap the own box of each node, at their places; returns the nodes with
/// any.
pub struct Children<'a> {
    pub placed: &'a LaneBoxes,
    pub used: u16,
    pub level: &'a [Node],
    pub nodes: &'a [u32],
    pub masks: &'a mut Vec<u16>,
}

impl Kernel for Children<'_> {
    type Output = u16;

    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> u16 {
        let Children { placed, used, level, nodes, masks } = self;
        let mut any = 0;
        for &node in nodes {
            let mask = level[node as usize].overlapping_lanes(s, placed) & used;
            any |= mask;
            masks.push(mask);
        }
        any
    }
}
