//! The last steps of the descent where blocks are small beside clusters: each of the tool's pieces, one at a time,
//! against a block's 32, instead of each of these against a cluster's 16 as in [`scan`](super::scan). Few pieces of a
//! cluster then overlap a block, and many of the block's overlap the cluster.
//!
//! All blocks that a group reached go from list to list together.

use super::edge_planes::{Middles, Outlines};
use super::node::{Node, FANOUT};
use super::pieces::{most_slack, HalfBlock};
use super::tree::Blocks;
use crate::index::sink::CandidateSink;
use crate::tool::moving_tool::{Cluster, LEAST_LANES};
use crate::tool::placement::PlacedPieces;
use feeler_lanes::{
    along, few_lanes, greatest4, least4, load_few3, prefetch, Arithmetic, Box4, Checked, Kernel, LaneBoxes, Simd,
    SpreadBoxes, LANES,
};

/// Things at blocks: the places of the blocks, and the things.
#[derive(Debug, Default)]
struct AtBlocks {
    blocks: Vec<u32>,
    things: Vec<u32>,
    count: usize,
}

impl AtBlocks {
    /// Appends the chosen ones.
    #[inline(always)]
    fn append<S: Simd>(&mut self, s: S, block: u32, chosen: u16, things: &[u32; LANES]) {
        let from = self.count;
        if self.things.len() < from + LANES {
            self.blocks.resize(2 * (from + LANES), 0);
            self.things.resize(2 * (from + LANES), 0);
        }
        self.blocks[from..from + LANES].fill(block);
        self.count = s.append(chosen, things, &mut self.things, from);
    }

    #[inline(always)]
    fn iter(&self) -> impl Iterator<Item = (u32, u32)> + '_ {
        self.blocks[..self.count].iter().copied().zip(self.things[..self.count].iter().copied())
    }
}

/// A piece of the tool, and which pieces it meets of a part of a block: half, or where registers are short an eighth.
#[derive(Debug, Clone, Copy, Default)]
struct Row {
    block: u32,
    /// The lane, and 16 times the cluster.
    piece: u16,
    hit: u16,
}

/// Parts of a block where registers are shortest.
const MOST_PARTS: usize = FANOUT / LEAST_LANES;

/// Working memory.
#[derive(Debug)]
pub struct RowsScratch {
    /// Boxes of the clusters' pieces.
    boxes: [SpreadBoxes; LANES],
    outlines: [Outlines; LANES],
    middles: Middles,
    clusters: AtBlocks,
    pieces: AtBlocks,
    /// By part of the block; and as many as there is room for.
    rows: [Vec<Row>; MOST_PARTS],
    /// Blocks with rows, and from where, by part.
    runs: [Vec<(u32, u32)>; MOST_PARTS],
    /// Rows of a part that are left, and which triangles to ask for before.
    kept: Vec<(Row, u16)>,
}

impl Default for RowsScratch {
    fn default() -> RowsScratch {
        RowsScratch {
            boxes: [SpreadBoxes::ZERO; LANES],
            outlines: [const { Outlines::ZERO }; LANES],
            middles: Middles::ZERO,
            clusters: AtBlocks::default(),
            pieces: AtBlocks::default(),
            rows: [const { Vec::new() }; MOST_PARTS],
            runs: [const { Vec::new() }; MOST_PARTS],
            kept: Vec::new(),
        }
    }
}

/// The numbers of all lanes of a group's clusters.
const NUMBERS: [[u32; LANES]; LANES] = {
    let mut numbers = [[0; LANES]; LANES];
    let mut i = 0;
    while i < LANES * LANES {
        numbers[i / LANES][i % LANES] = i as u32;
        i += 1;
    }
    numbers
};

/// A group's clusters, of which those `needed` are placed, and blocks with their possible partners.
pub struct Rows<'a, N> {
    pub lanes: Checked,
    pub blocks: &'a Blocks,
    pub clusters: &'a [Cluster],
    pub needed: u16,
    pub nodes: &'a [u32],
    pub masks: &'a [u16],
    /// The boxes around the placed clusters.
    pub tight: &'a LaneBoxes,
    pub placed: &'a mut [PlacedPieces; LANES],
    pub half: &'a mut HalfBlock,
    pub scratch: &'a mut RowsScratch,
    /// How far coordinates may be off.
    pub slack: f32,
    pub narrow: &'a mut N,
}

/// Blocks at a group of clusters that make it worth asking how large they are.
pub const MANY_BLOCKS: usize = 8;
/// How wide blocks may be, in the mean, to be small: in widths of the clusters. Measured; between 1 and 1.5 all within 5 %.
const SMALL_WIDTHS: f32 = 1.33;

/// Whether blocks are small beside the clusters that were placed.
#[inline(never)]
pub fn are_small(level: &[Node], nodes: &[u32], placed: &[PlacedPieces; LANES], needed: u16) -> bool {
    let (mut of_blocks, mut of_clusters) = ([0.0; 4], [0.0; 4]);
    for node in nodes {
        add_extent(&mut of_blocks, &level[*node as usize].bounds());
    }
    let mut rest = needed;
    while rest != 0 {
        add_extent(&mut of_clusters, &placed[rest.trailing_zeros() as usize].bounds);
        rest &= rest - 1;
    }
    let [blocks, clusters] = [of_blocks, of_clusters].map(|[x, y, z, _]| x + y + z);
    blocks * needed.count_ones() as f32 <= SMALL_WIDTHS * clusters * nodes.len() as f32
}

fn add_extent(sum: &mut [f32; 4], b: &Box4) {
    for a in 0..4 {
        sum[a] += b.upper[a] - b.lower[a];
    }
}

/// Offers the pairs of pieces. True when the query is over.
///
/// A function of its own, or the other way of scanning gets slower.
#[inline(never)]
pub fn offer_rows<N: CandidateSink>(rows: Rows<'_, N>) -> bool {
    rows.lanes.run(rows)
}

impl<N: CandidateSink> Kernel for Rows<'_, N> {
    type Output = bool;

    #[inline(always)]
    fn run<S: Simd>(mut self, s: S) -> bool {
        self.reach(s);
        self.offer(s)
    }
}

impl<N: CandidateSink> Rows<'_, N> {
    /// Finds which boxes meet, at the blocks, and prefetches the data of the remaining stages.
    #[inline(always)]
    fn reach<S: Simd>(&mut self, s: S) {
        let Rows { blocks, clusters: tool, needed, nodes, masks, tight, placed, scratch, slack, narrow, .. } = self;
        let RowsScratch { boxes, outlines, clusters, pieces, rows, runs, .. } = &mut **scratch;
        let level = &blocks.levels[0];
        let mut rest = *needed;
        while rest != 0 {
            let c = rest.trailing_zeros() as usize;
            rest &= rest - 1;
            placed[c].boxes.spread(s, &mut boxes[c]);
        }
        clusters.count = 0;
        for (&block, mask) in nodes.iter().zip(*masks) {
            let mask = mask & *needed & level[block as usize].overlapping_lanes(s, tight);
            clusters.append(s, block, mask, &NUMBERS[0]);
        }
        narrow.stats().voxels_visited += clusters.count as u64;
        pieces.count = 0;
        for (block, c) in clusters.iter() {
            let c = c as usize % LANES;
            let lanes = level[block as usize].overlapping_lanes(s, &placed[c].boxes) & tool[c].corners.used;
            pieces.append(s, block, lanes, &NUMBERS[c]);
        }
        narrow.stats().pieces_scanned += pieces.count as u64;
        let lanes = few_lanes::<S>();
        let parts = FANOUT / lanes;
        for list in &mut rows[..parts] {
            if list.len() < pieces.count {
                list.resize(2 * pieces.count, Row::default());
            }
        }
        let (mut entries, mut counts) = (0, [0; MOST_PARTS]);
        let mut used = 0u32;
        for (block, piece) in pieces.iter() {
            let b = boxes[piece as usize / LANES % LANES].lane(piece as usize % LANES);
            let hit = level[block as usize].overlapping_inside(s, &b);
            entries += hit.count_ones();
            used |= u32::from(hit != 0) << (piece as usize / LANES % LANES);
            // No branch: which are met is not to be foreseen.
            for part in 0..parts {
                let row = Row { block, piece: piece as u16, hit: (hit >> (lanes * part)) as u16 & of_part::<S>() };
                rows[part][counts[part]] = row;
                counts[part] += usize::from(row.hit != 0);
            }
        }
        narrow.stats().entries_scanned += u64::from(entries);
        let mut most = [0.0f32; 3];
        for part in 0..parts {
            let (list, runs) = (&rows[part][..counts[part]], &mut runs[part]);
            runs.resize(list.len() + 1, (0, 0));
            let (mut count, mut last) = (0, u32::MAX);
            for (i, row) in list.iter().enumerate() {
                runs[count] = (row.block, i as u32);
                count += usize::from(row.block != last);
                last = row.block;
            }
            runs[count] = (u32::MAX, list.len() as u32);
            runs.truncate(count + 1);
            for (block, _) in &runs[..count] {
                let slack = most_slack(&level[*block as usize], *slack);
                for a in 0..3 {
                    most[a] = most[a].max(slack[a]);
                }
            }
        }
        while used != 0 {
            let c = used.trailing_zeros() as usize;
            used &= used - 1;
            placed[c].need_normals(s);
            outlines[c].make(s, &placed[c], &most, *slack);
        }
    }

    /// Offers what planes do not hold apart either. True when the query is over.
    #[inline(always)]
    fn offer<S: Simd>(&mut self, s: S) -> bool {
        let Rows { blocks, clusters, placed, half: pieces, scratch, slack, narrow, .. } = self;
        let RowsScratch { rows, runs, outlines, middles, kept, .. } = &mut **scratch;
        for at in 0..RUNS_AHEAD {
            ask::<S>(blocks, runs, at);
        }
        let mut asked = RUNS_AHEAD;
        let lanes = few_lanes::<S>();
        for part in 0..FANOUT / lanes {
            let (half, first) = (lanes * part / LANES, lanes * part % LANES);
            let (rows, of_part) = (&rows[part], &runs[part]);
            if kept.len() < rows.len() + 1 {
                kept.resize(rows.len() + 1, (Row::default(), 0));
            }
            let mut count = 0;
            for i in 0..of_part.len() - 1 {
                let ((block, from), to) = (of_part[i], of_part[i + 1].1);
                ask::<S>(blocks, runs, asked);
                asked += 1;
                let (node, packed) = (&blocks.levels[0][block as usize], &blocks.pieces[block as usize]);
                let list = &rows[from as usize..to as usize];
                let (start, mut met) = (count, 0);
                if narrow.compares_boxes() {
                    pieces.unpack_boxes_few(s, node, (half, first));
                    pieces.unpack_corners_few(s, packed, (half, first), *slack);
                    middles.make_few(s, pieces, first);
                    (count, met) = left(s, (placed, outlines), (pieces, middles, first), list, kept, count);
                } else {
                    for row in list {
                        kept[count] = (*row, 0);
                        count += 1;
                        met |= row.hit;
                    }
                }
                kept[start].1 = met;
            }
            for &(row, ask) in &kept[..count] {
                let triangles = blocks.pieces[row.block as usize].triangles[LANES * half..].first_chunk();
                let triangles = triangles.expect("a multiple of 16 below 32");
                narrow.stats().box_survivors += u64::from(row.hit.count_ones());
                let slot = clusters[usize::from(row.piece) / LANES % LANES].slots[usize::from(row.piece) % LANES];
                if narrow.offer_row(s, slot, row.hit << first, ask << first, triangles) {
                    return true;
                }
            }
        }
        false
    }
}

/// Runs that are prefetched before their turn. Not all at once: a core waits for a dozen lines or so at a time.
const RUNS_AHEAD: usize = 8;

/// Prefetches the data of a run, counted over all parts.
#[inline(always)]
fn ask<S: Simd>(blocks: &Blocks, runs: &[Vec<(u32, u32)>; MOST_PARTS], at: usize) {
    let mut place = at;
    for part in 0..FANOUT / few_lanes::<S>() {
        let count = runs[part].len() - 1;
        if place < count {
            let half = part * few_lanes::<S>() / LANES;
            let packed = &blocks.pieces[runs[part][place].0 as usize];
            prefetch(&packed.corners[half]);
            prefetch(&packed.triangles[LANES * half]);
            return;
        }
        place -= count;
    }
}

/// All lanes of a part.
const fn of_part<S: Simd>() -> u16 {
    (u16::MAX as u32 >> (LANES - few_lanes::<S>())) as u16
}

/// Appends, of each row, what neither the planes of both sides nor the outline of the tool's piece hold apart. Returns where
/// the list ends, and what is left of any row.
///
/// The tool's planes go first, in a loop of their own: they leave nothing of a third of the rows.
#[inline(always)]
fn left<S: Simd>(
    s: S,
    (placed, outlines): (&[PlacedPieces; LANES], &[Outlines; LANES]),
    (pieces, middles, first): (&HalfBlock, &Middles, usize),
    rows: &[Row],
    kept: &mut [(Row, u16)],
    at: usize,
) -> (usize, u16) {
    let few = s.few();
    let mut q = [[few.splat(0.0); 3]; 4];
    for c in 0..4 {
        q[c] = load_few3(s, &pieces.corners[c], first);
    }
    let mut to = at;
    for row in rows {
        let (c, lane) = (usize::from(row.piece) / LANES % LANES, usize::from(row.piece) % LANES);
        let (normals, outlines) = (&placed[c].normals, &outlines[c]);
        let n = [few.splat(normals[0][lane]), few.splat(normals[1][lane]), few.splat(normals[2][lane])];
        let (near, far) = along(few, &q, &n);
        let apart = few.above(near, few.splat(outlines.far[lane])) | few.above(few.splat(outlines.near[lane]), far);
        let row = Row { hit: row.hit & !few.lanes(apart), ..*row };
        kept[to] = (row, 0);
        to += usize::from(row.hit != 0);
    }
    let m = load_few3(s, &pieces.normals, first);
    let (q_near, q_far) = (s.load_few(&pieces.near, first), s.load_few(&pieces.far, first));
    let (mut count, mut met) = (at, 0);
    for i in at..to {
        let row = kept[i].0;
        let (c, lane) = (usize::from(row.piece) / LANES % LANES, usize::from(row.piece) % LANES);
        let corners = &placed[c].corners;
        let mut d = [q_near; 4];
        for c in 0..4 {
            let at = &corners[c];
            let last = m[2] * few.splat(at[2][lane]);
            d[c] = few.mul_add(m[0], few.splat(at[0][lane]), few.mul_add(m[1], few.splat(at[1][lane]), last));
        }
        let apart = few.above(least4(few, &d), q_far) | few.above(q_near, greatest4(few, &d));
        let apart = apart | outlines[c].beyond(s, lane, (middles, first));
        let row = Row { hit: row.hit & !few.lanes(apart), ..row };
        kept[count] = (row, 0);
        count += usize::from(row.hit != 0);
        met |= row.hit;
    }
    (count, met)
}

const _: () = assert!(FANOUT == 2 * LANES);
