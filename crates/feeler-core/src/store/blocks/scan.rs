//! The last steps of the descent: the clusters of a tool's group against the blocks the group reached.
//!
//! Stage by stage, each a loop that appends what passes to a list: which entries pass is not to be foreseen, so there is no
//! branch.

use super::descent::{BlocksScratch, Reach};
use super::pieces::HalfBlock;
use super::{Blocks, FANOUT};
use crate::lanes::{load3, Box4, LaneBoxes, PlaceBoxes, PlacedPieces, Placement, LANES};
use crate::narrow::Narrow;
use crate::simd::{prefetch, Kernel, Simd};
use crate::tool::Tool;

/// A group of clusters at the nodes `nodes[from..]`.
pub struct Arrival<'a> {
    pub group: usize,
    pub from: usize,
    /// Whether these are nodes above blocks, and not blocks.
    pub is_above: bool,
    /// The group's box.
    pub bounds: &'a Box4,
}

/// A group, its clusters' loose boxes, and the blocks that these reach.
#[derive(Debug)]
pub struct Reached {
    pub group: Option<usize>,
    loose: LaneBoxes,
    blocks: Vec<u32>,
}

impl Reached {
    pub fn new(room: usize) -> Reached {
        Reached { group: None, loose: LaneBoxes::ZERO, blocks: Vec::with_capacity(room) }
    }
}

/// Lets a group wait while its blocks come from memory, and offers the pairs of pieces of the clusters and blocks of the group
/// that waited before. True when the query is over.
pub struct Scan<'a, 'n> {
    pub blocks: &'a Blocks,
    pub tool: &'a Tool,
    pub placement: &'a Placement,
    pub scratch: &'a mut BlocksScratch,
    /// `None` after the last one.
    pub arrival: Option<Arrival<'a>>,
    pub narrow: &'a mut Narrow<'n>,
}

impl Kernel for Scan<'_, '_> {
    type Output = bool;

    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> bool {
        let Scan { blocks, tool, placement, scratch, arrival, narrow } = self;
        let BlocksScratch { nodes, masks, reached, spread, pieces, halves, runs, codes, chosen, .. } = scratch;
        let level = &blocks.levels[0];
        let [now, waiting] = &mut **reached;
        now.group = None;
        if let Some(Arrival { group, from, is_above, bounds }) = arrival {
            let boxes = &tool.children(1)[group];
            let placed = &mut now.loose;
            let first = match blocks.levels.get(1) {
                Some(above) if is_above => {
                    narrow.stats.voxels_visited += (nodes.len() - from) as u64;
                    Reach { placement, boxes, level: above, below: level, bounds, nodes, from, placed, spread }.run(s)
                }
                _ => {
                    placement.place_boxes(s, boxes, placed);
                    from
                }
            };
            if nodes.len() == first {
                return false;
            }
            now.group = Some(group);
            now.blocks.clear();
            now.blocks.extend_from_slice(&nodes[first..]);
        }
        std::mem::swap(now, waiting);
        let Reached { group: Some(group), loose, blocks: nodes } = &*now else { return false };
        let group = *group;
        let boxes = &tool.children(1)[group];
        let first_mask = masks.len();
        narrow.stats.voxels_visited += nodes.len() as u64;
        // Which clusters may meet anything, by their loose boxes: only those are placed.
        let mut any = 0;
        for &node in nodes {
            let mask = level[node as usize].overlapping_lanes(s, loose) & boxes.used;
            any |= mask;
            masks.push(mask);
        }
        // Of those only the ones that meet a piece are worth placing.
        let mut needed = 0;
        if any != 0 {
            loose.spread(s, spread);
            for (&block, mask) in nodes.iter().zip(&masks[first_mask..]) {
                let mut mask = mask & !needed;
                while mask != 0 {
                    let c = mask.trailing_zeros() as usize;
                    mask &= mask - 1;
                    narrow.stats.voxels_visited += 1;
                    if level[block as usize].overlapping_inside(s, &spread.lane(c)) != 0 {
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
        // Pieces of each block that a cluster's box meets. What the next stages need of a block is asked for already.
        let mut count = 0;
        runs.clear();
        for (&block, mask) in nodes.iter().zip(group_masks) {
            let mut mask = mask & needed;
            if mask == 0 {
                continue;
            }
            let node = &level[block as usize];
            mask &= node.overlapping_lanes(s, &tight);
            let from = count;
            if codes.len() < from + CODES {
                codes.resize(from + 2 * CODES, 0);
            }
            let mut reached = 0;
            while mask != 0 {
                let c = mask.trailing_zeros() as usize;
                mask &= mask - 1;
                narrow.stats.voxels_visited += 1;
                let hit = node.overlapping_inside(s, &pieces[c].bounds);
                reached |= hit;
                count = s.append(hit as u16, &PAIR_CODES[c][0], codes, count);
                count = s.append((hit >> LANES) as u16, &PAIR_CODES[c][1], codes, count);
            }
            if count > from {
                let (first, last) = (FANOUT * block as usize, blocks.triangles.len() - 1);
                for half in 0..2 {
                    if reached >> (LANES * half) & 0xffff != 0 {
                        for c in 0..4 {
                            prefetch(&blocks.packed[block as usize].0[c][half]);
                        }
                        prefetch(&blocks.triangles[(first + LANES * half).min(last)]);
                        prefetch(&blocks.triangles[(first + LANES * half + LANES - 1).min(last)]);
                    }
                }
                runs.push((block, from as u32));
            }
        }
        narrow.stats.pieces_scanned += count as u64;
        let slack = placement.slack + blocks.slack;
        for run in 0..runs.len() {
            let (block, from) = runs[run];
            let to = runs.get(run + 1).map_or(count, |next| next.1 as usize);
            let codes = &mut codes[from as usize..to];
            let node = &level[block as usize];
            let triangles = &blocks.triangles[FANOUT * block as usize..];
            for half in 0..2 {
                halves[half].unpack_boxes(s, node, half);
            }
            let mut kept = 0;
            let mut kept_pieces = 0;
            for i in 0..codes.len() {
                let (c, piece) = parts_of(codes[i]);
                let lanes =
                    halves[piece / LANES].boxes_meeting(s, &pieces[c].boxes, piece % LANES) & clusters[c].corners.used;
                codes[kept] = codes[i];
                chosen[kept] = lanes;
                kept += usize::from(lanes != 0);
                kept_pieces |= u32::from(lanes != 0) << piece;
                narrow.stats.entries_scanned += u64::from(lanes.count_ones());
            }
            if narrow.filters.boxes {
                for half in 0..2 {
                    if kept_pieces >> (LANES * half) & 0xffff != 0 {
                        halves[half].unpack_corners(s, &blocks.packed[block as usize], half, slack);
                    }
                }
                let mut last = 0;
                for i in 0..kept {
                    let (c, piece) = parts_of(codes[i]);
                    pieces[c].need_normals(s);
                    let lanes = chosen[i] & planes_meeting(s, &pieces[c], &halves[piece / LANES], piece % LANES);
                    codes[last] = codes[i];
                    chosen[last] = lanes;
                    last += usize::from(lanes != 0);
                }
                kept = last;
            }
            for i in 0..kept {
                let (c, piece) = parts_of(codes[i]);
                narrow.stats.box_survivors += u64::from(chosen[i].count_ones());
                if narrow.offer_lanes(s, chosen[i], &clusters[c].slots, triangles[piece]) {
                    return true;
                }
            }
        }
        false
    }
}

/// A cluster of a group and a piece of a block.
#[inline(always)]
fn parts_of(code: u32) -> (usize, usize) {
    (code as usize / FANOUT % LANES, code as usize % FANOUT)
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
pub const CODES: usize = LANES * FANOUT + LANES;

/// Which of a cluster's pieces are not held apart from one piece of a block by the plane of either.
#[inline(always)]
fn planes_meeting<S: Simd>(s: S, placed: &PlacedPieces, half: &HalfBlock, piece: usize) -> u16 {
    // The plane of the block's piece; its own interval along its axis is known.
    let (near, far) = placed.along(s, &half.normal(s, piece));
    let apart = s.above(near, s.splat(half.far[piece])) | s.above(s.splat(half.near[piece]), far);
    // The planes of the tool's pieces.
    let (near, far) = half.along(s, piece, &load3(s, &placed.normals));
    !(apart | s.above(near, s.load(&placed.far)) | s.above(s.load(&placed.near), far))
}
