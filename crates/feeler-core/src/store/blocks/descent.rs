//! The query: tool tree and block tree are descended together.

use super::node::Node;
use super::pieces::HalfBlock;
use super::{Blocks, FANOUT};
use crate::lanes::{greatest4, least4, load3, Box4, LaneBoxes, PlacedPieces, Placement, LANES, TINY};
use crate::narrow::Narrow;
use crate::simd::{prefetch, Kernel, Simd};
use crate::tool::Tool;

/// Working memory of a query.
#[derive(Debug)]
pub struct BlocksScratch {
    nodes: Vec<u32>,
    masks: Vec<u16>,
    children: Vec<LaneBoxes>,
    pieces: Box<[PlacedPieces; LANES]>,
    halves: Box<[HalfBlock; 2]>,
    /// Pairs of a cluster and a piece, and which of the cluster's lanes are left.
    codes: Box<[u32; CODES]>,
    chosen: Box<[u16; CODES]>,
}

impl Default for BlocksScratch {
    fn default() -> BlocksScratch {
        BlocksScratch {
            nodes: Vec::new(),
            masks: Vec::new(),
            children: Vec::new(),
            pieces: Box::new([PlacedPieces::ZERO; LANES]),
            halves: Box::new([HalfBlock::ZERO; 2]),
            codes: Box::new([0; CODES]),
            chosen: Box::new([0; CODES]),
        }
    }
}

impl Blocks {
    /// Offers every pair of pieces that boxes and planes do not hold apart to the narrow phase, until it says stop.
    pub fn offer_candidates(&self, tool: &Tool, scratch: &mut BlocksScratch, narrow: &mut Narrow<'_>) {
        let margin = tool.margin_at(narrow.pose);
        // In float64 first: a tool far away is done with.
        let whole = narrow.pose.apply_box(&tool.mesh().bounds(), margin);
        if !whole.is_overlapping(&narrow.mesh.bounds()) {
            return;
        }
        let placement = Placement::new(tool.unit(), narrow.pose, margin, &self.frame.origin, self.frame.scale);
        scratch.nodes.clear();
        scratch.nodes.push(0);
        scratch.children.resize(tool.height() + 1, LaneBoxes::ZERO);
        let root = self.frame.to_box4(&whole);
        let mut descent = Descent { blocks: self, tool, placement, scratch };
        descent.descend(tool.height(), 0, &root, self.levels.len() - 1, 0, narrow);
    }
}

struct Descent<'a> {
    blocks: &'a Blocks,
    tool: &'a Tool,
    placement: Placement,
    /// `nodes` is a stack of node lists; each step of the descent reads the top one and pushes its own. `masks` is the same
    /// for the children of tool entries: which of the 16 meet each node of the list.
    scratch: &'a mut BlocksScratch,
}

impl Descent<'_> {
    /// Tests tool entry `entry` of `tool_level` (1: a group of clusters), inside `bounds`, against the nodes `nodes[from..]`
    /// of `level`. True when the query is over.
    ///
    /// The tool entry's box goes down until the nodes are one level below it, so that groups arrive at blocks and their
    /// clusters test only the blocks the group reached.
    fn descend(
        &mut self,
        tool_level: usize,
        entry: usize,
        bounds: &Box4,
        level: usize,
        from: usize,
        narrow: &mut Narrow<'_>,
    ) -> bool {
        let to = self.scratch.nodes.len();
        let (mut level, mut from) = (level, from);
        while level >= tool_level {
            let nodes = &mut self.scratch.nodes;
            let [below, nodes_of_level] = [level - 1, level].map(|l| &self.blocks.levels[l]);
            narrow.stats.voxels_visited += (nodes.len() - from) as u64;
            from = narrow.lanes.run(Expand { level: nodes_of_level, below, bounds, nodes, from });
            level -= 1;
        }
        let over = if self.scratch.nodes.len() == from {
            false
        } else if tool_level == 1 {
            let Descent { blocks, tool, placement, scratch } = self;
            let lanes = narrow.lanes;
            // A mock-up of few blocks under a large tool: groups arrive above the blocks never, for `level` is 0 here.
            lanes.run(Scan { blocks, tool, placement, scratch, group: entry, from, narrow })
        } else {
            self.descend_children(tool_level, entry, level, from, narrow)
        };
        self.scratch.nodes.truncate(to);
        over
    }

    /// Goes on with each child of a tool entry, and the nodes of `nodes[from..]` whose own box meets the child's.
    fn descend_children(
        &mut self,
        tool_level: usize,
        entry: usize,
        level: usize,
        from: usize,
        narrow: &mut Narrow<'_>,
    ) -> bool {
        let boxes = &self.tool.children(tool_level)[entry];
        let (to, first_mask) = (self.scratch.nodes.len(), self.scratch.masks.len());
        narrow.stats.voxels_visited += (to - from) as u64;
        let BlocksScratch { nodes, masks, children, .. } = &mut *self.scratch;
        let any = narrow.lanes.run(Children {
            placement: &self.placement,
            boxes,
            level: &self.blocks.levels[level],
            nodes: &nodes[from..],
            masks,
            placed: &mut children[tool_level],
        });
        let over = (0..LANES).any(|i| {
            if any >> i & 1 == 0 {
                return false;
            }
            let BlocksScratch { nodes, masks, children, .. } = &mut *self.scratch;
            for at in from..to {
                if masks[first_mask + at - from] >> i & 1 == 1 {
                    let node = nodes[at];
                    nodes.push(node);
                }
            }
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
struct Expand<'a> {
    level: &'a [Node],
    below: &'a [Node],
    bounds: &'a Box4,
    nodes: &'a mut Vec<u32>,
    from: usize,
}

impl Kernel for Expand<'_> {
    type Output = usize;

    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> usize {
        let Expand { level, below, bounds, nodes, from } = self;
        let to = nodes.len();
        for at in from..to {
            let node = nodes[at];
            let mut hit = level[node as usize].overlapping(s, bounds);
            while hit != 0 {
                let child = FANOUT as u32 * node + hit.trailing_zeros();
                hit &= hit - 1;
                prefetch(&below[child as usize]);
                nodes.push(child);
            }
        }
        to
    }
}

/// Places the children of a tool entry, and appends which of them meet the own box of each node; returns which meet any.
struct Children<'a> {
    placement: &'a Placement,
    boxes: &'a crate::lanes::BoxLanes,
    level: &'a [Node],
    nodes: &'a [u32],
    masks: &'a mut Vec<u16>,
    placed: &'a mut LaneBoxes,
}

impl Kernel for Children<'_> {
    type Output = u16;

    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> u16 {
        let Children { placement, boxes, level, nodes, masks, placed } = self;
        *placed = placement.place_boxes(s, boxes);
        let mut any = 0;
        for &node in nodes {
            let mask = level[node as usize].overlapping_lanes(s, placed) & boxes.used;
            any |= mask;
            masks.push(mask);
        }
        any
    }
}

/// Offers the pairs of pieces of a group's clusters and of the blocks `nodes[from..]`. True when the query is over.
struct Scan<'a, 'n> {
    blocks: &'a Blocks,
    tool: &'a Tool,
    placement: &'a Placement,
    scratch: &'a mut BlocksScratch,
    group: usize,
    from: usize,
    narrow: &'a mut Narrow<'n>,
}

impl Kernel for Scan<'_, '_> {
    type Output = bool;

    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> bool {
        let Scan { blocks, tool, placement, scratch, group, from, narrow } = self;
        let BlocksScratch { nodes, masks, pieces, halves, codes, chosen, .. } = scratch;
        let nodes = &nodes[from..];
        let level = &blocks.levels[0];
        narrow.stats.voxels_visited += nodes.len() as u64;
        // Which clusters may meet anything, by their loose boxes: only those are placed.
        let boxes = &tool.children(1)[group];
        let loose = placement.place_boxes(s, boxes);
        let first_mask = masks.len();
        let mut any = 0;
        for &node in nodes {
            let mask = level[node as usize].overlapping_lanes(s, &loose) & boxes.used;
            any |= mask;
            masks.push(mask);
        }
        // Of those only the ones that meet a piece are worth placing.
        let mut needed = 0;
        if any != 0 {
            for (&block, mask) in nodes.iter().zip(&masks[first_mask..]) {
                let mut mask = mask & !needed;
                while mask != 0 {
                    let c = mask.trailing_zeros() as usize;
                    mask &= mask - 1;
                    narrow.stats.voxels_visited += 1;
                    if level[block as usize].overlapping_inside(s, &loose.lane(c)) != 0 {
                        needed |= 1 << c;
                        prefetch(&tool.clusters()[LANES * group + c]);
                    }
                }
            }
        }
        let group_masks = masks.drain(first_mask..);
        if needed == 0 {
            return false;
        }
        narrow.stats.clusters_placed += u64::from(needed.count_ones());
        let clusters = &tool.clusters()[LANES * group..];
        let mut tight = LaneBoxes::ZERO;
        let mut rest = needed;
        while rest != 0 {
            let c = rest.trailing_zeros() as usize;
            rest &= rest - 1;
            placement.place_pieces(s, &clusters[c].corners, &mut pieces[c]);
            tight.set(c, &pieces[c].bounds);
        }
        let slack = placement.slack + blocks.slack;
        for (&block, mask) in nodes.iter().zip(group_masks) {
            let node = &level[block as usize];
            let mut mask = mask & needed;
            if mask != 0 {
                mask &= node.overlapping_lanes(s, &tight);
            }
            // Stage by stage, each a loop that appends what passes: which ones do is not to be foreseen, so there is no branch.
            let mut count = 0;
            let mut either_half = 0;
            while mask != 0 {
                let c = mask.trailing_zeros() as usize;
                mask &= mask - 1;
                narrow.stats.voxels_visited += 1;
                let hit = node.overlapping_inside(s, &pieces[c].bounds);
                either_half |= hit;
                count = s.append(hit as u16, &PAIR_CODES[c][0], &mut codes[..], count);
                count = s.append((hit >> LANES) as u16, &PAIR_CODES[c][1], &mut codes[..], count);
            }
            if count == 0 {
                continue;
            }
            narrow.stats.pieces_scanned += count as u64;
            for half in 0..2 {
                if either_half >> (LANES * half) & 0xffff != 0 {
                    halves[half].unpack_boxes(s, node, half);
                }
            }
            let mut kept = 0;
            let mut either_half = 0;
            for i in 0..count {
                let code = codes[i] as usize;
                let (c, piece) = (code / FANOUT, code % FANOUT);
                let lanes =
                    boxes_meeting(s, &pieces[c], &halves[piece / LANES], piece % LANES) & clusters[c].corners.used;
                codes[kept] = code as u32;
                chosen[kept] = lanes;
                kept += usize::from(lanes != 0);
                either_half |= u32::from(lanes != 0) << piece;
                narrow.stats.entries_scanned += u64::from(lanes.count_ones());
            }
            if kept == 0 {
                continue;
            }
            if narrow.filters.boxes {
                for half in 0..2 {
                    if either_half >> (LANES * half) & 0xffff != 0 {
                        halves[half].unpack_corners(s, &blocks.packed[block as usize], half, slack);
                    }
                }
                let mut last = 0;
                for i in 0..kept {
                    let code = codes[i] as usize;
                    let (c, piece) = (code / FANOUT, code % FANOUT);
                    pieces[c].need_normals(s);
                    let lanes = chosen[i] & planes_meeting(s, &pieces[c], &halves[piece / LANES], piece % LANES);
                    codes[last] = code as u32;
                    chosen[last] = lanes;
                    last += usize::from(lanes != 0);
                }
                kept = last;
            }
            for i in 0..kept {
                let code = codes[i] as usize;
                let (c, piece) = (code / FANOUT, code % FANOUT);
                narrow.stats.box_survivors += u64::from(chosen[i].count_ones());
                let triangle = blocks.triangles[FANOUT * block as usize + piece];
                if narrow.offer_lanes(s, chosen[i], &clusters[c].slots, triangle) {
                    return true;
                }
            }
        }
        false
    }
}

/// For each cluster of a group, and each half of a block: `32 cluster + piece`.
static PAIR_CODES: [[[u32; LANES]; 2]; LANES] = pair_codes();

const fn pair_codes() -> [[[u32; LANES]; 2]; LANES] {
    let mut codes = [[[0; LANES]; 2]; LANES];
    let mut code = 0;
    while code < LANES * FANOUT {
        codes[code / FANOUT][code % FANOUT / LANES][code % LANES] = code as u32;
        code += 1;
    }
    codes
}

/// Room for all pairs of a group's clusters and a block's pieces, and for what appending may write beyond.
const CODES: usize = LANES * FANOUT + LANES;

/// Which of a cluster's boxes meet the box of one piece of a block.
#[inline(always)]
fn boxes_meeting<S: Simd>(s: S, placed: &PlacedPieces, half: &HalfBlock, piece: usize) -> u16 {
    let mut apart = 0;
    for a in 0..3 {
        apart |= s.above(s.load(&placed.boxes.lower[a]), s.splat(half.upper[a][piece]));
        apart |= s.above(s.splat(half.lower[a][piece]), s.load(&placed.boxes.upper[a]));
    }
    !apart
}

/// Which of a cluster's pieces are not held apart from one piece of a block by the plane of either.
///
/// An axis that keeps two intervals apart by more than their uncertainty is proof whatever the axis is, so its own rounding
/// does not matter. A coordinate's error counts with the axis's entry in absolute value.
#[inline(always)]
fn planes_meeting<S: Simd>(s: S, placed: &PlacedPieces, half: &HalfBlock, piece: usize) -> u16 {
    let mut d = [s.splat(0.0); 4];
    // The plane of the block's piece.
    let m = [s.splat(half.normals[0][piece]), s.splat(half.normals[1][piece]), s.splat(half.normals[2][piece])];
    for c in 0..4 {
        let at = load3(s, &placed.corners[c]);
        d[c] = s.mul_add(m[0], at[0], s.mul_add(m[1], at[1], m[2] * at[2]));
    }
    let apart = s.above(least4(s, &d), s.splat(half.far[piece])) | s.above(s.splat(half.near[piece]), greatest4(s, &d));
    // The planes of the tool's pieces.
    let n = load3(s, &placed.normals);
    for c in 0..4 {
        let at = [&half.corners[c][0], &half.corners[c][1], &half.corners[c][2]];
        let last = n[2] * s.splat(at[2][piece]);
        d[c] = s.mul_add(n[0], s.splat(at[0][piece]), s.mul_add(n[1], s.splat(at[1][piece]), last));
    }
    let slack = s.mul_add(s.abs(n[2]), s.splat(half.slack[2][piece]), s.splat(TINY));
    let slack = s.mul_add(s.abs(n[1]), s.splat(half.slack[1][piece]), slack);
    let slack = s.mul_add(s.abs(n[0]), s.splat(half.slack[0][piece]), slack);
    let (near, far) = (least4(s, &d) - slack, greatest4(s, &d) + slack);
    !(apart | s.above(near, s.load(&placed.far)) | s.above(s.load(&placed.near), far))
}
