//! The query of a cast: the tool's tree of boxes, swept through a window of time, is descended together with the blocks.

use super::collide::{Children, Expand, Place, Reach};
use super::pieces::HalfBlock;
use super::swept_bounds::{SweptPieces, SweptPlacement};
use super::tree::Blocks;
use crate::index::interner::KeySet;
use crate::index::sink::{Offer, Sweep};
use feeler_lanes::{load3, Box4, Kernel, LaneBoxes, Simd, SpreadBoxes, LANES};

/// Working memory of a query.
pub struct SweepScratch {
    /// For stores that offer pairs more than once.
    pub(in crate::index) seen: KeySet,
    nodes: Vec<u32>,
    masks: Vec<u16>,
    children: Vec<LaneBoxes>,
    spread: Box<SpreadBoxes>,
    pieces: Box<[SweptPieces; LANES]>,
    halves: Box<[HalfBlock; 2]>,
}

impl std::fmt::Debug for SweepScratch {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("SweepScratch")
    }
}

impl Default for SweepScratch {
    fn default() -> SweepScratch {
        SweepScratch {
            seen: KeySet::default(),
            nodes: Vec::new(),
            masks: Vec::new(),
            children: Vec::new(),
            spread: Box::new(SpreadBoxes::ZERO),
            pieces: Box::new([SweptPieces::ZERO; LANES]),
            halves: Box::new([HalfBlock::ZERO; 2]),
        }
    }
}

impl Blocks {
    /// Offers the pairs of pieces that swept boxes and planes do not hold apart. See
    /// [`Store::offer_swept`](crate::index::store::Store::offer_swept).
    pub fn offer_swept(&self, sweep: &Sweep<'_>, scratch: &mut SweepScratch, offer: Offer<'_>) -> bool {
        let Sweep { mesh, tool, window, .. } = sweep;
        // In float64 first: a tool far away is done with.
        let whole = window.bounds_of_box(&tool.mesh().bounds());
        if !whole.is_overlapping(&mesh.bounds()) {
            return true;
        }
        scratch.nodes.clear();
        scratch.nodes.push(0);
        scratch.masks.clear();
        scratch.children.resize(tool.height() + 1, LaneBoxes::ZERO);
        let root = self.frame.to_box4(&whole);
        let placement = SweptPlacement::new(tool, window, &self.frame);
        let mut descent = Descent { blocks: self, sweep, placement, scratch, offer };
        descent.descend(tool.height(), 0, &root, self.levels.len() - 1, 0);
        true
    }
}

/// As the descent of `collide`, on swept boxes.
struct Descent<'a, 'o> {
    blocks: &'a Blocks,
    sweep: &'a Sweep<'a>,
    placement: SweptPlacement,
    scratch: &'a mut SweepScratch,
    offer: Offer<'o>,
}

impl Descent<'_, '_> {
    /// Tests tool entry `entry` of `tool_level` (1: a group of clusters), inside `bounds`, against the nodes `nodes[from..]`
    /// of `level`. True when the query is over.
    fn descend(&mut self, tool_level: usize, entry: usize, bounds: &Box4, level: usize, from: usize) -> bool {
        let to = self.scratch.nodes.len();
        let (mut level, mut from) = (level, from);
        let Descent { blocks, sweep, placement, scratch, .. } = &mut *self;
        let SweepScratch { nodes, children, spread, .. } = &mut **scratch;
        while level > tool_level {
            let [below, own] = [level - 1, level].map(|l| &blocks.levels[l]);
            let there = sweep.selection.children(level);
            from = sweep.lanes.run(Expand { level: own, below, there, bounds, nodes, from });
            level -= 1;
        }
        let (boxes, placed) = (&sweep.tool.children(tool_level)[entry], &mut children[tool_level]);
        let placement = &*placement;
        if level == tool_level {
            let [below, own] = [level - 1, level].map(|l| &blocks.levels[l]);
            let there = sweep.selection.children(level);
            let reach = Reach { placement, boxes, level: own, below, there, bounds, nodes, from, placed, spread };
            from = sweep.lanes.run(reach);
            level -= 1;
        } else {
            sweep.lanes.run(Place { placement, boxes, placed });
        }
        let over = self.scratch.nodes.len() > from && self.descend_children(tool_level, entry, level, from);
        self.scratch.nodes.truncate(to);
        over
    }

    /// Goes on with each child of a tool entry, and the nodes of `nodes[from..]` whose own box meets the child's.
    fn descend_children(&mut self, tool_level: usize, entry: usize, level: usize, from: usize) -> bool {
        let (to, first_mask) = (self.scratch.nodes.len(), self.scratch.masks.len());
        let SweepScratch { nodes, masks, children, .. } = &mut *self.scratch;
        let any = self.sweep.lanes.run(Children {
            placed: &children[tool_level],
            used: self.sweep.tool.children(tool_level)[entry].used,
            level: &self.blocks.levels[level],
            nodes: &nodes[from..],
            masks,
        });
        let over = if tool_level == 1 {
            any != 0 && self.scan(entry, from, first_mask, any)
        } else {
            (0..LANES).any(|i| {
                if any >> i & 1 == 0 {
                    return false;
                }
                let SweepScratch { nodes, masks, children, .. } = &mut *self.scratch;
                for at in from..to {
                    if masks[first_mask + at - from] >> i & 1 == 1 {
                        let node = nodes[at];
                        nodes.push(node);
                    }
                }
                let bounds = children[tool_level].lane(i);
                let over = self.descend(tool_level - 1, LANES * entry + i, &bounds, level, to);
                self.scratch.nodes.truncate(to);
                over
            })
        };
        self.scratch.masks.truncate(first_mask);
        over
    }

    fn scan(&mut self, group: usize, from: usize, first_mask: usize, needed: u16) -> bool {
        let Descent { blocks, sweep, placement, scratch, offer } = self;
        sweep.lanes.run(Scan { blocks, sweep, placement, scratch, offer: *offer, group, from, first_mask, needed })
    }
}

/// The clusters of a group against the blocks `nodes[from..]` that their loose boxes reach.
struct Scan<'a, 'o> {
    blocks: &'a Blocks,
    sweep: &'a Sweep<'a>,
    placement: &'a SweptPlacement,
    scratch: &'a mut SweepScratch,
    offer: &'a mut (dyn FnMut(u32, u32) -> bool + 'o),
    group: usize,
    from: usize,
    first_mask: usize,
    needed: u16,
}

impl Kernel for Scan<'_, '_> {
    type Output = bool;

    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> bool {
        let Scan { blocks, sweep, placement, scratch, offer, group, from, first_mask, needed } = self;
        let SweepScratch { nodes, masks, pieces, halves, .. } = scratch;
        let clusters = &sweep.tool.clusters()[LANES * group..];
        let mut rest = needed;
        while rest != 0 {
            let c = rest.trailing_zeros() as usize;
            rest &= rest - 1;
            placement.place_pieces(s, &clusters[c].corners, &mut pieces[c]);
        }
        let slack = placement.slack + blocks.slack;
        for (&block, mask) in nodes[from..].iter().zip(&masks[first_mask..]) {
            let node = &blocks.levels[0][block as usize];
            let mut mask = *mask;
            let mut unpacked = 0u32;
            while mask != 0 {
                let c = mask.trailing_zeros() as usize;
                mask &= mask - 1;
                let mut hit = node.overlapping(s, &pieces[c].bounds);
                let (lower, upper) = (load3(s, &pieces[c].boxes.lower), load3(s, &pieces[c].boxes.upper));
                while hit != 0 {
                    let at = hit.trailing_zeros() as usize;
                    hit &= hit - 1;
                    let (half, piece) = (at / LANES, at % LANES);
                    if unpacked >> half & 1 == 0 {
                        halves[half].unpack_boxes(s, node, half);
                        unpacked |= 1 << half;
                    }
                    let mut lanes = halves[half].boxes_meeting(s, &lower, &upper, piece) & clusters[c].corners.used;
                    if lanes == 0 {
                        continue;
                    }
                    if unpacked >> (2 + half) & 1 == 0 {
                        halves[half].unpack_corners(s, &blocks.pieces[block as usize], half, slack);
                        unpacked |= 1 << (2 + half);
                    }
                    lanes &= pieces[c].planes_meeting(s, &halves[half], piece);
                    let triangle = blocks.pieces[block as usize].triangles[at];
                    while lanes != 0 {
                        let lane = lanes.trailing_zeros() as usize;
                        lanes &= lanes - 1;
                        if offer(clusters[c].slots[lane], triangle) {
                            return true;
                        }
                    }
                }
            }
        }
        false
    }
}
