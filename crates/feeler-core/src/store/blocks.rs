//! The default store: blocks of 32 boxes in Morton order under a shallow tree.
//!
//! Triangles are cut into pieces (for the index only), pieces are ordered along a Morton curve, and 32 consecutive ones make
//! a block. A block keeps its pieces' boxes as bytes relative to its own box. Blocks of blocks make the tree: the children of
//! node `i` are the entries `32 i` to `32 i + 31` of the level below, so there are no lists and no pointers.
//!
//! All box comparisons happen after rounding to float32 and then to bytes. Both steps are monotone functions applied to both
//! sides alike, and `x <= y` implies `f(x) <= f(y)`: boxes that meet are never found apart, whatever the rounding.

use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use rayon::prelude::*;

use super::{check_memory, report, Progress};
use crate::bounds::Aabb;
use crate::error::{Error, Result};
use crate::mesh::Mesh;
use crate::morton;
use crate::narrow::Narrow;
use crate::pieces::{cut_margin, cut_triangle, grown_box, longest_edge, twice_area, Piece};
use crate::tool::{Tool, TOOL_FANOUT};

/// Children of a node.
const FANOUT: usize = 32;

/// Triangles a build task handles at a time.
const CHUNK: usize = 4096;

/// Bytes per piece at the height of building: the piece, its Morton key, its place in a block and that block's box.
const BUILD_BYTES_PER_PIECE: f64 = (size_of::<BuildPiece>()
    + size_of::<(u64, u32)>()
    + size_of::<u32>()
    + (size_of::<Node>() + size_of::<Box32>()).div_ceil(FANOUT)) as f64;

/// See the module.
#[derive(Debug)]
pub struct Blocks {
    frame: Frame,
    /// `levels[0]` are blocks of pieces; the last level has one node.
    levels: Vec<Vec<Node>>,
    /// The triangle of each piece, 32 to a block; the last block may be short.
    triangles: Vec<u32>,
}

/// World to float32: the box of the mock-up scaled by a power of two to lengths of at most 1.
#[derive(Debug, Clone, Copy)]
struct Frame {
    origin: [f64; 3],
    scale: f64,
}

/// A box in the frame.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Box32 {
    lower: [f32; 3],
    upper: [f32; 3],
}

/// A box in the bytes of one node: lower sides, and 255 minus upper sides.
type ByteBox = [[u8; 2]; 3];

/// 32 boxes as bytes relative to the node's own box.
#[derive(Debug, Clone)]
#[repr(C, align(64))]
struct Node {
    /// For each axis 32 lower sides, then 32 times 255 minus the upper side: "meets" is then "less or equal" throughout.
    sides: [[u8; 2 * FANOUT]; 3],
    lower: [f32; 3],
    /// Bytes per unit of length.
    per_unit: [f32; 3],
    /// Which children exist.
    valid: u32,
    /// In a block: which pieces belong to triangles with several.
    cut: u32,
}

#[derive(Debug, Clone, Copy)]
struct BuildPiece {
    bounds: Box32,
    triangle: u32,
    is_cut: bool,
}

impl Frame {
    fn new(bounds: &Aabb) -> Frame {
        let longest = bounds.extent().iter().fold(0.0f64, |m, x| m.max(*x));
        // The power of two at or above the longest side; scaling by it does not round.
        let exponent = if longest > 0.0 { longest.log2().ceil().clamp(-900.0, 900.0) } else { 0.0 };
        Frame { origin: bounds.lower, scale: (-exponent).exp2() }
    }

    #[inline]
    fn to_box32(self, b: &Aabb) -> Box32 {
        let f = |x: f64, a: usize| ((x - self.origin[a]) * self.scale) as f32;
        Box32 { lower: std::array::from_fn(|a| f(b.lower[a], a)), upper: std::array::from_fn(|a| f(b.upper[a], a)) }
    }
}

impl Box32 {
    const EMPTY: Box32 = Box32 { lower: [f32::INFINITY; 3], upper: [f32::NEG_INFINITY; 3] };

    fn union(&self, other: &Box32) -> Box32 {
        Box32 {
            lower: std::array::from_fn(|a| self.lower[a].min(other.lower[a])),
            upper: std::array::from_fn(|a| self.upper[a].max(other.upper[a])),
        }
    }
}

impl Node {
    fn new(children: &[Box32], cut: u32) -> Node {
        let bounds = children.iter().fold(Box32::EMPTY, |b, c| b.union(c));
        let per_unit = std::array::from_fn(|a| {
            let scale = 255.0 / (bounds.upper[a] - bounds.lower[a]);
            // A node without extent has one byte value for everything.
            if scale.is_finite() {
                scale
            } else {
                0.0
            }
        });
        let valid = u32::MAX >> (FANOUT - children.len());
        let mut node = Node { sides: [[0; 2 * FANOUT]; 3], lower: bounds.lower, per_unit, valid, cut };
        for (i, child) in children.iter().enumerate() {
            let bytes = node.to_bytes(child);
            for a in 0..3 {
                node.sides[a][i] = bytes[a][0];
                node.sides[a][FANOUT + i] = bytes[a][1];
            }
        }
        node
    }

    /// Bytes of a box relative to this node. Casts saturate, so what sticks out gets 0 or 255.
    #[inline]
    fn to_bytes(&self, b: &Box32) -> ByteBox {
        std::array::from_fn(|a| {
            let byte = |x: f32| ((x - self.lower[a]) * self.per_unit[a]) as u8;
            [byte(b.lower[a]), 255 - byte(b.upper[a])]
        })
    }

    /// Which children's boxes meet a box.
    #[inline]
    fn overlapping(&self, b: &Box32) -> u32 {
        let q = self.to_bytes(b);
        let mut apart = [0u8; FANOUT];
        for a in 0..3 {
            // The child begins after the box ends, or ends before the box begins.
            let (before, after) = (255 - q[a][1], 255 - q[a][0]);
            for i in 0..FANOUT {
                apart[i] |= u8::from(self.sides[a][i] > before) | u8::from(self.sides[a][FANOUT + i] > after);
            }
        }
        !bits(&apart) & self.valid
    }

    /// The bytes of one child's box.
    #[inline]
    fn child(&self, i: usize) -> ByteBox {
        std::array::from_fn(|a| [self.sides[a][i], self.sides[a][FANOUT + i]])
    }
}

/// One bit per byte that is 1 (bytes are 0 or 1).
#[inline]
fn bits(flags: &[u8; FANOUT]) -> u32 {
    let mut mask = 0;
    for (i, eight) in flags.chunks_exact(8).enumerate() {
        let word = u64::from_le_bytes([eight[0], eight[1], eight[2], eight[3], eight[4], eight[5], eight[6], eight[7]]);
        // The product moves the lowest bit of byte n to bit 56 + n; no two terms meet.
        mask |= ((word.wrapping_mul(0x0102_0408_1020_4080) >> 56) as u32) << (8 * i);
    }
    mask
}

impl Blocks {
    /// Cuts triangles to pieces of `size` metres and builds the blocks.
    pub fn build(mesh: &Mesh, size: f64, limit: u64, progress: Progress<'_>) -> Result<Blocks> {
        if !(size.is_finite() && size > 0.0) {
            return Err(Error::VoxelSize { value: size });
        }
        report(progress, 0.0, "cutting triangles")?;
        let ids: Vec<u32> = mesh.queried().collect();
        let offsets = count_pieces(mesh, &ids, size, limit)?;
        let total = offsets[offsets.len() - 1] as usize;
        let frame = Frame::new(&mesh.bounds());
        let pieces = cut_all(mesh, &ids, size, &offsets, &frame);
        drop((ids, offsets));

        report(progress, 0.3, "sorting pieces")?;
        let morton = morton::Frame::new(&Aabb { lower: [0.0; 3], upper: [1.0; 3] });
        let mut order: Vec<(u64, u32)> = pieces
            .par_iter()
            .enumerate()
            .map(|(i, p)| {
                let wide = Aabb { lower: p.bounds.lower.map(f64::from), upper: p.bounds.upper.map(f64::from) };
                (morton.code_of_box(&wide), i as u32)
            })
            .collect();
        order.par_sort_unstable();

        report(progress, 0.7, "building blocks")?;
        let mut triangles = Vec::with_capacity(total);
        order.par_iter().map(|(_, i)| pieces[*i as usize].triangle).collect_into_vec(&mut triangles);
        let (mut blocks, mut boxes) = (Vec::new(), Vec::new());
        order
            .par_chunks(FANOUT)
            .map(|chunk| {
                let mut bounds = [Box32::EMPTY; FANOUT];
                let mut cut = 0;
                for (i, (_, piece)) in chunk.iter().enumerate() {
                    let p = &pieces[*piece as usize];
                    bounds[i] = p.bounds;
                    cut |= u32::from(p.is_cut) << i;
                }
                let own = bounds.iter().fold(Box32::EMPTY, |b, c| b.union(c));
                (Node::new(&bounds[..chunk.len()], cut), own)
            })
            .unzip_into_vecs(&mut blocks, &mut boxes);
        drop((order, pieces));
        let mut levels = vec![blocks];
        while boxes.len() > 1 {
            levels.push(boxes.par_chunks(FANOUT).map(|children| Node::new(children, 0)).collect());
            boxes = boxes.par_chunks(FANOUT).map(|c| c.iter().fold(Box32::EMPTY, |b, x| b.union(x))).collect();
        }
        for level in &mut levels {
            level.shrink_to_fit();
        }
        report(progress, 1.0, "done")?;
        Ok(Blocks { frame, levels, triangles })
    }

    /// Bytes by structure.
    pub fn memory(&self) -> Vec<(&'static str, usize)> {
        let nodes = |levels: &[Vec<Node>]| levels.iter().map(|l| l.capacity() * size_of::<Node>()).sum::<usize>();
        vec![
            ("blocks", nodes(&self.levels[..1])),
            ("tree", nodes(&self.levels[1..])),
            ("piece_triangles", self.triangles.capacity() * size_of::<u32>()),
        ]
    }

    /// Every triangle's box is covered by pieces, and every child lies in its node.
    pub fn validate(&self, mesh: &Mesh) -> std::result::Result<(), String> {
        let mut seen = vec![0u32; mesh.faces().len()];
        for (i, &t) in self.triangles.iter().enumerate() {
            seen[t as usize] += 1;
            let node = &self.levels[0][i / FANOUT];
            let b = self.frame.to_box32(&Aabb::of_triangle(&mesh.triangle(t)));
            if node.overlapping(&b) >> (i % FANOUT) & 1 == 0 {
                return Err(format!("piece {i} is away from its triangle {t}"));
            }
        }
        for t in 0..mesh.faces().len() as u32 {
            if (seen[t as usize] == 0) == mesh.is_queried(t) {
                return Err(format!("triangle {t} has {} pieces", seen[t as usize]));
            }
        }
        for (i, &t) in self.triangles.iter().enumerate() {
            let cut = self.levels[0][i / FANOUT].cut >> (i % FANOUT) & 1 == 1;
            if cut != (seen[t as usize] > 1) {
                return Err(format!("piece {i}: wrong mark"));
            }
        }
        let mut below = self.triangles.len();
        for level in &self.levels {
            if level.len() != below.div_ceil(FANOUT) {
                return Err(format!("{} nodes over {below} entries", level.len()));
            }
            for (n, node) in level.iter().enumerate() {
                if node.valid.count_ones() as usize != (below - n * FANOUT).min(FANOUT) {
                    return Err(format!("node {n} has {:b}", node.valid));
                }
            }
            below = level.len();
        }
        if below == 1 {
            Ok(())
        } else {
            Err(format!("{below} roots"))
        }
    }

    /// Descends tool tree and block tree together, and offers pairs of pieces whose boxes meet.
    pub fn offer_candidates(&self, tool: &Tool, scratch: &mut BlocksScratch, narrow: &mut Narrow<'_>) {
        scratch.nodes.clear();
        scratch.nodes.push(0);
        let mut descent =
            Descent { blocks: self, tool, margin: tool.margin_at(narrow.pose), nodes: &mut scratch.nodes };
        descent.descend(tool.levels().len() - 1, 0, self.levels.len() - 1, 0, narrow);
    }
}

/// Offsets of each chunk's pieces; the last entry is their number. Refuses what memory or 32-bit ids cannot hold.
fn count_pieces(mesh: &Mesh, ids: &[u32], size: f64, limit: u64) -> Result<Vec<u64>> {
    // A piece has sides up to `size`, so its area is at most the square of that, and its length at most twice it.
    let least: f64 = ids
        .par_iter()
        .map(|id| {
            let t = mesh.triangle(*id);
            (0.5 * twice_area(&t) / (size * size)).max(0.5 * longest_edge(&t) / size).max(1.0)
        })
        .sum();
    check_memory("the blocks", least * BUILD_BYTES_PER_PIECE, limit)?;
    let most = (limit as f64 / BUILD_BYTES_PER_PIECE).min(f64::from(u32::MAX)) as u64;
    let total = AtomicU64::new(0);
    let counts: Vec<u64> = ids
        .par_chunks(CHUNK)
        .map(|chunk| {
            let mut count = 0;
            for id in chunk {
                // Each chunk stops on its own, and all stop once the sum is too much.
                if count <= most && total.load(Relaxed) <= most {
                    cut_triangle(&mesh.triangle(*id), size, &mut |_| count += 1);
                }
            }
            total.fetch_add(count, Relaxed);
            count
        })
        .collect();
    let total = total.into_inner();
    check_memory("the blocks", total as f64 * BUILD_BYTES_PER_PIECE, limit)?;
    if total > u64::from(u32::MAX) {
        return Err(Error::TooManyEntries { voxel_size: size, entries: total });
    }
    let mut sum = 0;
    let mut offsets = vec![0];
    offsets.extend(counts.iter().map(|n| {
        sum += n;
        sum
    }));
    Ok(offsets)
}

fn cut_all(mesh: &Mesh, ids: &[u32], size: f64, offsets: &[u64], frame: &Frame) -> Vec<BuildPiece> {
    let empty = BuildPiece { bounds: Box32::EMPTY, triangle: 0, is_cut: false };
    let mut pieces = vec![empty; offsets[offsets.len() - 1] as usize];
    let mut rest = pieces.as_mut_slice();
    let mut tasks = Vec::new();
    for (chunk, w) in ids.chunks(CHUNK).zip(offsets.windows(2)) {
        let (head, tail) = rest.split_at_mut((w[1] - w[0]) as usize);
        tasks.push((chunk, head));
        rest = tail;
    }
    let margin = cut_margin(mesh.bounds().largest_coordinate());
    tasks.into_par_iter().for_each(|(chunk, out)| {
        let mut at = 0;
        for &id in chunk {
            let from = at;
            cut_triangle(&mesh.triangle(id), size, &mut |piece: &Piece| {
                let bounds = frame.to_box32(&grown_box(piece, margin));
                out[at] = BuildPiece { bounds, triangle: id, is_cut: false };
                at += 1;
            });
            if at - from > 1 {
                out[from..at].iter_mut().for_each(|p| p.is_cut = true);
            }
        }
    });
    pieces
}

/// Working memory of a query.
#[derive(Debug, Default)]
pub struct BlocksScratch {
    nodes: Vec<u32>,
}

/// A cluster of the tool at the pose.
struct PlacedCluster {
    bounds: Box32,
    pieces: [Box32; TOOL_FANOUT],
    count: usize,
}

struct Descent<'a> {
    blocks: &'a Blocks,
    tool: &'a Tool,
    margin: f64,
    /// A stack of node lists; each step of the descent reads the top one and pushes its own.
    nodes: &'a mut Vec<u32>,
}

impl Descent<'_> {
    /// Tests tool entry `entry` of `tool_level` against the nodes `nodes[from..]` of `level`. True when the query is over.
    ///
    /// The tool entry's box goes down until the nodes are one level below it, so that groups arrive at blocks and their
    /// clusters test only the blocks the group reached.
    fn descend(&mut self, tool_level: usize, entry: usize, level: usize, from: usize, narrow: &mut Narrow<'_>) -> bool {
        let to = self.nodes.len();
        let bounds = self.placed_box(tool_level, entry, narrow);
        let (mut level, mut from) = (level, from);
        while level > tool_level.saturating_sub(1) {
            from = self.expand(&bounds, level, from, narrow);
            level -= 1;
        }
        let over = if self.nodes.len() == from {
            false
        } else if tool_level == 0 {
            self.offer_cluster(entry, &bounds, from, narrow)
        } else {
            let last = self.tool.levels()[tool_level - 1].len().min(TOOL_FANOUT * (entry + 1));
            (TOOL_FANOUT * entry..last).any(|child| self.descend(tool_level - 1, child, level, from, narrow))
        };
        self.nodes.truncate(to);
        over
    }

    /// A box around a tool entry at the pose: the rotated box's box, quick and loose.
    fn placed_box(&self, tool_level: usize, entry: usize, narrow: &Narrow<'_>) -> Box32 {
        let bounds = &self.tool.levels()[tool_level][entry];
        self.blocks.frame.to_box32(&narrow.pose.apply_box(bounds, self.margin))
    }

    /// Pushes the children, of the nodes `nodes[from..]` of `level`, that meet a box; returns where they begin.
    fn expand(&mut self, bounds: &Box32, level: usize, from: usize, narrow: &mut Narrow<'_>) -> usize {
        let to = self.nodes.len();
        narrow.stats.voxels_visited += (to - from) as u64;
        for at in from..to {
            let node = self.nodes[at];
            let mut hit = self.blocks.levels[level][node as usize].overlapping(bounds);
            while hit != 0 {
                self.nodes.push(FANOUT as u32 * node + hit.trailing_zeros());
                hit &= hit - 1;
            }
        }
        to
    }

    /// Offers the pairs of a cluster's pieces and the pieces of blocks `nodes[from..]`.
    fn offer_cluster(&mut self, cluster: usize, loose: &Box32, from: usize, narrow: &mut Narrow<'_>) -> bool {
        let mut placed = None;
        narrow.stats.voxels_visited += (self.nodes.len() - from) as u64;
        for at in from..self.nodes.len() {
            let block = self.nodes[at] as usize;
            let node = &self.blocks.levels[0][block];
            // The cluster's pieces are placed when the loose box first meets something.
            if placed.is_none() && node.overlapping(loose) == 0 {
                continue;
            }
            let placed = placed.get_or_insert_with(|| self.place(cluster, narrow));
            let mut hit = node.overlapping(&placed.bounds);
            if hit == 0 {
                continue;
            }
            let bytes = PieceBytes::new(node, placed);
            while hit != 0 {
                let i = hit.trailing_zeros() as usize;
                hit &= hit - 1;
                let mut lanes = bytes.overlapping(&node.child(i));
                while lanes != 0 {
                    let piece = &self.tool.pieces()[TOOL_FANOUT * cluster + lanes.trailing_zeros() as usize];
                    lanes &= lanes - 1;
                    // A pair comes again only if one of the two triangles has several pieces.
                    let may_repeat = piece.is_cut || node.cut >> i & 1 == 1;
                    if narrow.offer(piece.triangle, self.blocks.triangles[FANOUT * block + i], may_repeat) {
                        return true;
                    }
                }
            }
        }
        false
    }

    fn place(&self, cluster: usize, narrow: &Narrow<'_>) -> PlacedCluster {
        let pieces = self.tool.pieces();
        let range = TOOL_FANOUT * cluster..pieces.len().min(TOOL_FANOUT * (cluster + 1));
        let mut placed =
            PlacedCluster { bounds: Box32::EMPTY, pieces: [Box32::EMPTY; TOOL_FANOUT], count: range.len() };
        for (slot, piece) in placed.pieces.iter_mut().zip(&pieces[range]) {
            let corners = piece.corners.map(|c| narrow.pose.apply(&c));
            *slot = self.blocks.frame.to_box32(&grown_box(&corners, self.margin));
        }
        placed.bounds = placed.pieces[..placed.count].iter().fold(Box32::EMPTY, |b, p| b.union(p));
        placed
    }
}

/// The boxes of a cluster's pieces in the bytes of one block, side by side.
struct PieceBytes {
    lower: [[u8; TOOL_FANOUT]; 3],
    upper: [[u8; TOOL_FANOUT]; 3],
    valid: u32,
}

impl PieceBytes {
    #[inline]
    fn new(node: &Node, cluster: &PlacedCluster) -> PieceBytes {
        let mut bytes =
            PieceBytes { lower: [[0; TOOL_FANOUT]; 3], upper: [[0; TOOL_FANOUT]; 3], valid: (1 << cluster.count) - 1 };
        for (i, piece) in cluster.pieces.iter().enumerate() {
            let b = node.to_bytes(piece);
            for a in 0..3 {
                bytes.lower[a][i] = b[a][0];
                bytes.upper[a][i] = 255 - b[a][1];
            }
        }
        bytes
    }

    /// Which of the pieces meet a child's box.
    #[inline]
    fn overlapping(&self, child: &ByteBox) -> u32 {
        let mut apart = [0u8; FANOUT];
        for a in 0..3 {
            let (lower, upper) = (child[a][0], 255 - child[a][1]);
            for i in 0..TOOL_FANOUT {
                apart[i] |= u8::from(lower > self.upper[a][i]) | u8::from(self.lower[a][i] > upper);
            }
        }
        !bits(&apart) & self.valid
    }
}
