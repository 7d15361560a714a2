//! The last steps of the descent: the clusters of a tool's group against the blocks the group reached.
//!
//! Separating axes in lanes: the boxes' three, then the normals of either piece. In stages, each a loop that appends
//! the remaining entries to a list without a branch, because which entries remain is unpredictable.

use std::ops::Range;

use super::collide::{BlocksScratch, Reach};
use super::node::{Node, FANOUT};
use super::piece_scan::{are_small, offer_rows, Rows, MANY_BLOCKS};
use super::pieces::{most_slack, HalfBlock};
use super::plane_cull::Beside;
use super::tree::Blocks;
use crate::index::selection::Selection;
use crate::index::sink::CandidateSink;
use crate::tool::moving_tool::{Tool, LEAST_LANES};
use crate::tool::placement::{PlaceBoxes, PlacedPieces, Placement};
use feeler_lanes::{
    along, few_lanes, load3, load_few3, prefetch, prefetch_at, Arithmetic, Box4, Checked, Kernel, Lane32, LaneBoxes,
    Simd, LANES, TINY,
};

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

/// A block, from where on the list its clusters stand, and which of its pieces any of these reaches.
#[derive(Debug, Clone, Copy)]
pub struct Run {
    block: u32,
    from: usize,
    reached: u32,
}

/// Lets a group wait while its blocks come from memory, and offers the pairs of pieces of the clusters and blocks of the group
/// that waited before. True when the query is over.
pub struct Scan<'a, N> {
    pub blocks: &'a Blocks,
    pub tool: &'a Tool,
    pub lanes: Checked,
    pub placement: &'a Placement,
    pub selection: &'a Selection,
    pub scratch: &'a mut BlocksScratch,
    /// `None` after the last one.
    pub arrival: Option<Arrival<'a>>,
    pub narrow: &'a mut N,
}

impl<N: CandidateSink> Kernel for Scan<'_, N> {
    type Output = bool;

    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> bool {
        let Scan { blocks, tool, lanes, placement, selection, scratch, arrival, narrow } = self;
        let BlocksScratch { nodes, masks, reached, spread, pieces, halves, runs, found, pairs, rows, .. } = scratch;
        let (pieces, halves, pairs) = (&mut **pieces, &mut **halves, &mut **pairs);
        let level = &blocks.levels[0];
        let [now, waiting] = &mut **reached;
        now.group = None;
        if let Some(Arrival { group, from, is_above, bounds }) = arrival {
            let boxes = &tool.children(1)[group];
            let placed = &mut now.loose;
            let first = match blocks.levels.get(1) {
                Some(above) if is_above => {
                    narrow.stats().voxels_visited += (nodes.len() - from) as u64;
                    let there = selection.children(1);
                    Reach { placement, boxes, level: above, below: level, there, bounds, nodes, from, placed, spread }
                        .run(s)
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
        narrow.stats().voxels_visited += nodes.len() as u64;
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
                let node = &level[block as usize];
                narrow.stats().voxels_visited += u64::from(mask.count_ones());
                let (mut met, mut hits, mut count) = (0, [0; LANES], 0);
                while mask != 0 {
                    let c = mask.trailing_zeros() as usize;
                    mask &= mask - 1;
                    hits[c] = node.overlapping_inside(s, &spread.lane(c));
                    met |= u16::from(hits[c] != 0) << c;
                    count += hits[c].count_ones();
                }
                let clusters = met.count_ones();
                if clusters >= MANY_CLUSTERS && count <= FEW_PIECES * clusters && narrow.compares_boxes() {
                    let packed = &blocks.pieces[block as usize];
                    let slack = placement.slack + blocks.slack;
                    met = not_beside(
                        Beside { node, packed, placement, boxes, hits: &hits, slack, half: &mut halves[0] },
                        lanes,
                    );
                }
                needed |= met;
                while met != 0 {
                    prefetch_at(tool.clusters(), LANES * group + met.trailing_zeros() as usize);
                    met &= met - 1;
                }
            }
        }
        if needed == 0 {
            masks.truncate(first_mask);
            return false;
        }
        narrow.stats().clusters_placed += u64::from(needed.count_ones());
        let clusters = &tool.clusters()[LANES * group..];
        let mut tight = LaneBoxes::ZERO;
        let mut rest = needed;
        while rest != 0 {
            let c = rest.trailing_zeros() as usize;
            rest &= rest - 1;
            placement.place_pieces(s, &clusters[c].corners, &mut pieces[c]);
            tight.set(c, &pieces[c].bounds);
        }
        let group_masks = masks.drain(first_mask..);
        let slack = placement.slack + blocks.slack;
        if nodes.len() >= MANY_BLOCKS && are_small(level, nodes, pieces, needed) {
            let half = &mut halves[0];
            return offer_rows(Rows {
                lanes,
                blocks,
                clusters,
                needed,
                nodes,
                masks: group_masks.as_slice(),
                tight: &tight,
                placed: pieces,
                half,
                scratch: rows,
                slack,
                narrow,
            });
        }
        // Pieces of each block that a cluster's box meets. The data that the next stages need of a block are prefetched here.
        runs.clear();
        let mut count = 0;
        for (&block, mask) in nodes.iter().zip(group_masks) {
            let mut mask = mask & needed;
            if mask == 0 {
                continue;
            }
            let node = &level[block as usize];
            mask &= node.overlapping_lanes(s, &tight);
            let from = count;
            if found.len() < from + LANES {
                found.resize(2 * (from + LANES), (0, 0));
            }
            narrow.stats().voxels_visited += u64::from(mask.count_ones());
            let list = &mut found[from..from + LANES];
            let (mut reached, mut met) = (0, 0);
            while mask != 0 {
                let c = mask.trailing_zeros();
                mask &= mask - 1;
                let hit = node.overlapping_inside(s, &pieces[c as usize].bounds);
                reached |= hit;
                list[met] = (c, hit);
                met += usize::from(hit != 0);
            }
            count += met;
            if reached != 0 {
                let packed = &blocks.pieces[block as usize];
                for half in 0..2 {
                    if reached >> (LANES * half) & HALF_MASK != 0 {
                        for c in 0..4 {
                            prefetch(&packed.corners[half][c]);
                        }
                        prefetch(&packed.triangles[LANES * half]);
                    }
                }
                runs.push(Run { block, from, reached });
            }
        }
        for run in 0..runs.len() {
            let Run { block, from, reached } = runs[run];
            let to = runs.get(run + 1).map_or(count, |next| next.from);
            let (node, packed) = (&level[block as usize], &blocks.pieces[block as usize]);
            for half in 0..2 {
                if !S::IN_BYTES && reached >> (LANES * half) & HALF_MASK != 0 {
                    halves[half].unpack_boxes(s, node, half);
                }
            }
            let most_slack = most_slack(node, slack);
            let mut unpacked = 0u32;
            let mut kept = 0;
            for &(c, hit) in &found[from..to] {
                let placed = &mut pieces[c as usize];
                let used = clusters[c as usize].corners.used;
                let (count, entries) = if S::IN_BYTES {
                    boxes_meeting_in_bytes(s, &placed.boxes, used, node, (c, hit), pairs, kept)
                } else {
                    boxes_meeting(s, &placed.boxes, used, halves, (c, hit), pairs, kept)
                };
                narrow.stats().pieces_scanned += u64::from(hit.count_ones());
                narrow.stats().entries_scanned += u64::from(entries);
                if !narrow.compares_boxes() {
                    kept = count;
                } else if count > kept {
                    // In order by piece: the first and the last say which halves they are of.
                    let of = [pairs[kept].piece as usize / LANES, pairs[count - 1].piece as usize / LANES];
                    for half in of[0]..=of[1] {
                        if unpacked >> half & 1 == 0 {
                            if S::IN_BYTES {
                                halves[half].unpack_boxes(s, node, half);
                            }
                            halves[half].unpack_corners(s, packed, half, slack);
                            unpacked |= 1 << half;
                        }
                    }
                    placed.need_normals(s);
                    kept = planes_meeting(s, placed, halves, &most_slack, pairs, kept..count);
                }
            }
            let survivors: u32 = pairs[..kept].iter().map(|pair| pair.lanes.count_ones()).sum();
            narrow.stats().box_survivors += u64::from(survivors);
            for pair in &pairs[..kept] {
                let slots = &clusters[pair.cluster as usize].slots;
                if narrow.offer_lanes(s, pair.lanes, slots, packed.triangles[pair.piece as usize]) {
                    return true;
                }
            }
        }
        false
    }
}

/// Least number of clusters that meet a block's pieces by their loose boxes for which it pays to compare planes first.
const MANY_CLUSTERS: u32 = 4;
/// If they meet no more each, in the mean: pieces that are not much larger than clusters have few of these beside them.
const FEW_PIECES: u32 = 3;

/// A function of its own, or the rest gets slower.
#[inline(never)]
fn not_beside(clusters: Beside<'_>, lanes: Checked) -> u16 {
    lanes.run(clusters)
}

/// Half of a block's pieces.
const HALF_MASK: u32 = 0xffff;

/// A piece of a block, a cluster of a group, and which of the cluster's pieces are not held apart from it.
#[derive(Debug, Clone, Copy)]
pub struct PiecePair {
    piece: u32,
    cluster: u16,
    lanes: u16,
}

impl PiecePair {
    /// To be filled in.
    pub const ZERO: PiecePair = PiecePair { piece: 0, cluster: 0, lanes: 0 };
}

/// All pairs of a group's clusters and a block's pieces.
pub const PIECE_PAIRS: usize = LANES * FANOUT;

/// Fills in, from place `at` on, the pieces of `hit` that boxes do not hold apart from all of a cluster's. Returns which these
/// are, and where the list ends.
///
/// One cluster at a time: its boxes stay in registers.
#[inline(always)]
fn boxes_meeting<S: Simd>(
    s: S,
    boxes: &LaneBoxes,
    used: u16,
    halves: &[HalfBlock; 2],
    (cluster, hit): (u32, u32),
    pairs: &mut [PiecePair; PIECE_PAIRS],
    at: usize,
) -> (usize, u32) {
    let mut entries = 0;
    let (lower, upper) = (load3(s, &boxes.lower), load3(s, &boxes.upper));
    let (mut count, mut rest) = (at, hit);
    while rest != 0 {
        let piece = rest.trailing_zeros() as usize;
        rest &= rest - 1;
        let lanes = halves[piece / LANES].boxes_meeting(s, &lower, &upper, piece % LANES) & used;
        entries += lanes.count_ones();
        // No branch: which pieces are left is not to be foreseen.
        pairs[count] = PiecePair { piece: piece as u32, cluster: cluster as u16, lanes };
        count += usize::from(lanes != 0);
    }
    (count, entries)
}

/// The same in the node's bytes, in which sixteen boxes take one register of AVX2 an axis, and not four.
#[inline(always)]
fn boxes_meeting_in_bytes<S: Simd>(
    s: S,
    boxes: &LaneBoxes,
    used: u16,
    node: &Node,
    (cluster, hit): (u32, u32),
    pairs: &mut [PiecePair; PIECE_PAIRS],
    at: usize,
) -> (usize, u32) {
    let children = node.byte_boxes().0;
    let in_bytes = s.in_bytes(children, [&boxes.lower, &boxes.upper]);
    let used = used & !in_bytes.outside;
    let (mut count, mut entries, mut rest) = (at, 0, hit);
    while rest != 0 {
        let piece = rest.trailing_zeros();
        rest &= rest - 1;
        let lanes = s.lanes_meeting(&in_bytes, children, piece as usize) & used;
        entries += lanes.count_ones();
        pairs[count] = PiecePair { piece, cluster: cluster as u16, lanes };
        count += usize::from(lanes != 0);
    }
    (count, entries)
}

/// Leaves, of the pairs of one cluster, what the planes of neither side hold apart. Returns where the list
/// ends.
#[inline(always)]
fn planes_meeting<S: Simd>(
    s: S,
    placed: &PlacedPieces,
    halves: &[HalfBlock; 2],
    most_slack: &[f32; 3],
    pairs: &mut [PiecePair; PIECE_PAIRS],
    of_cluster: Range<usize>,
) -> usize {
    let n = load3(s, &placed.normals);
    // The intervals of the tool's pieces along their own axes, grown by all slack.
    let slack = s.mul_add(s.abs(n[2]), s.splat(most_slack[2]), s.splat(TINY));
    let slack = s.mul_add(s.abs(n[1]), s.splat(most_slack[1]), slack);
    let slack = s.mul_add(s.abs(n[0]), s.splat(most_slack[0]), slack);
    let (near, far) = (s.load(&placed.near) - slack, s.load(&placed.far) + slack);
    if few_lanes::<S>() < LANES {
        let mut ends = [[0.0; LANES]; 2];
        s.store(near, &mut ends[0]);
        s.store(far, &mut ends[1]);
        return planes_meeting_few(s, placed, &ends, halves, pairs, of_cluster);
    }
    let own = OwnPlanes { corners: placed.corners(s), normals: n, near, far };
    let (start, list) = (of_cluster.start, &mut pairs[of_cluster]);
    let mut kept = 0;
    for i in 0..list.len() {
        let pair = list[i];
        let lanes = pair.lanes & !s.lanes(planes_apart(s, &own, halves, pair.piece));
        list[kept] = PiecePair { lanes, ..pair };
        kept += usize::from(lanes != 0);
    }
    start + kept
}

/// The same, with the intervals of the tool's pieces, by few lanes at a time and without those in which there is nothing.
#[inline(always)]
fn planes_meeting_few<S: Simd>(
    s: S,
    placed: &PlacedPieces,
    [near, far]: &[Lane32; 2],
    halves: &[HalfBlock; 2],
    pairs: &mut [PiecePair; PIECE_PAIRS],
    of_cluster: Range<usize>,
) -> usize {
    let (few, lanes) = (s.few(), few_lanes::<S>());
    // Which pairs, and which of their lanes.
    let mut parts = [(0u16, 0u16); PARTS];
    let mut count = 0;
    for i in of_cluster.clone() {
        for from in (0..LANES).step_by(lanes) {
            parts[count % PARTS] = (i as u16, from as u16);
            count += usize::from(u32::from(pairs[i].lanes) >> from & ((1 << lanes) - 1) != 0);
        }
    }
    for &(i, from) in &parts[..count] {
        let (pair, from) = (&mut pairs[usize::from(i) % PIECE_PAIRS], usize::from(from));
        let normals = load_few3(s, &placed.normals, from);
        let mut corners = [normals; 4];
        for c in 0..4 {
            corners[c] = load_few3(s, &placed.corners[c], from);
        }
        let own = OwnPlanes { corners, normals, near: s.load_few(near, from), far: s.load_few(far, from) };
        pair.lanes &= !(few.lanes(planes_apart(few, &own, halves, pair.piece)) << from);
    }
    let mut kept = of_cluster.start;
    for i in of_cluster {
        pairs[kept] = pairs[i];
        kept += usize::from(pairs[kept].lanes != 0);
    }
    kept
}

/// Most that a cluster has: of each of a block's pieces, as many as there are where the fewest lanes make a part.
const PARTS: usize = FANOUT * LANES / LEAST_LANES;

/// Pieces of a cluster: their corners, axes across their planes, and their intervals along these, grown by all slack.
struct OwnPlanes<A: Arithmetic> {
    corners: [[A::F32; 3]; 4],
    normals: [A::F32; 3],
    near: A::F32,
    far: A::F32,
}

/// Which of a cluster's pieces a plane holds apart from one of a block's.
#[inline(always)]
fn planes_apart<A: Arithmetic>(s: A, own: &OwnPlanes<A>, halves: &[HalfBlock; 2], piece: u32) -> A::M32 {
    let (half, piece) = (&halves[piece as usize / LANES], piece as usize % LANES);
    // The plane of the block's piece; its own interval along its axis is known.
    let (near, far) = along(s, &own.corners, &half.normal(s, piece));
    let apart = s.above(near, s.splat(half.far[piece])) | s.above(s.splat(half.near[piece]), far);
    // The planes of the tool's pieces.
    let (near, far) = half.corners_along(s, piece, &own.normals);
    apart | s.above(near, own.far) | s.above(own.near, far)
}
