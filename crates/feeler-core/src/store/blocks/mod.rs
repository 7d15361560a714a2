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

use super::{check_entries, check_memory, report, Progress};
use crate::bounds::Aabb;
use crate::error::{Error, Result};
use crate::mesh::Mesh;
use crate::morton;
use crate::pieces::{cut_margin, cut_triangle, grown_box, least_pieces, Piece};

mod descent;
mod node;

pub use descent::BlocksScratch;
use node::{Box32, Frame, Node, FANOUT};

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

#[derive(Debug, Clone, Copy)]
struct BuildPiece {
    bounds: Box32,
    triangle: u32,
    is_cut: bool,
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
}

/// Offsets of each chunk's pieces; the last entry is their number. Refuses what memory or 32-bit ids cannot hold.
fn count_pieces(mesh: &Mesh, ids: &[u32], size: f64, limit: u64) -> Result<Vec<u64>> {
    let least: f64 = ids.par_iter().map(|id| least_pieces(&mesh.triangle(*id), size)).sum();
    check_memory("the blocks", least * BUILD_BYTES_PER_PIECE, limit)?;
    check_entries(size, least)?;
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
    check_entries(size, total as f64)?;
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
