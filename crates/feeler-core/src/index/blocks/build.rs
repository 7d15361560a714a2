//! Building the blocks, bottom up: cut triangles, order the pieces by medians, pack each 32, then their boxes by 32 upwards.

use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use rayon::prelude::*;

use super::node::{Children, Frame, Node, FANOUT};
use super::pieces::{HalfBlock, PackedPieces};
use super::tree::Blocks;
use crate::error::{Error, Result};
use crate::geometry::bounds::Aabb;
use crate::index::limits::{check_entries, check_memory};
use crate::mesh::median::{self, Cells};
use crate::mesh::pieces::{cut_margin, cut_triangle, least_pieces};
use crate::mesh::triangle_mesh::{prefetch_corners, Mesh};
use crate::progress::Control;
use feeler_lanes::{greatest, least, prefetch_at, Box4, Column, Kernel, Level, Simd, LANES};

/// Triangles a build task handles at a time.
const CHUNK: usize = 4096;

/// A piece's corners in the frame.
type Corners = [[f32; 3]; 4];

/// A piece on its way to a block, in the order of blocks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct BuildPiece {
    middle: u64,
    triangle: u32,
    /// Where its corners are kept; `WHOLE` for a triangle that was not cut.
    cut: u32,
}

impl median::Entry for BuildPiece {
    #[inline]
    fn middle(&self) -> u64 {
        self.middle
    }
}

const WHOLE: u32 = u32::MAX;

/// How many pieces, and how many of them are of triangles that were cut.
#[derive(Debug, Clone, Copy, Default)]
struct Count {
    pieces: u64,
    cut: u64,
}

impl Blocks {
    /// Bytes per piece at the height of building: the piece, its corners while it is cut, and its share of a block.
    pub const BUILD_BYTES_PER_PIECE: f64 = (size_of::<BuildPiece>()
        + size_of::<Corners>()
        + (size_of::<Node>() + size_of::<PackedPieces>() + size_of::<Box4>()).div_ceil(FANOUT))
        as f64;

    /// Cuts triangles to pieces of `size` metres and builds the blocks.
    pub fn build(mesh: &Mesh, size: f64, limit: u64, control: Control<'_>) -> Result<Blocks> {
        Blocks::build_of((mesh, mesh.queried().collect(), &mesh.bounds()), size, limit, control)
    }

    /// The same of some triangles that are queried, at least one, with the box around them.
    pub fn build_of(
        (mesh, ids, bounds): (&Mesh, Vec<u32>, &Aabb),
        size: f64,
        limit: u64,
        control: Control<'_>,
    ) -> Result<Blocks> {
        if !(size.is_finite() && size > 0.0) {
            return Err(Error::VoxelSize { value: size });
        }
        control.progress.report(0.0, "cutting triangles")?;
        let counts = count_pieces(mesh, &ids, size, limit)?;
        let frame = Frame::new(bounds);
        let (mut pieces, cuts) = cut_all(mesh, &ids, size, &counts, &frame);
        drop((ids, counts));

        control.progress.report(0.3, "sorting pieces")?;
        median::order(&mut pieces, FANOUT);

        control.progress.report(0.7, "building blocks")?;
        // Cutting rounds, and so does growing by what cutting rounds: coordinates are at most 1.
        let slack = (1.01 * cut_margin(bounds.largest_coordinate()) * frame.scale) as f32;
        let margin = slack + 2.0 * f32::EPSILON;
        let lanes = Level::best().checked();
        let mut packed = vec![PackedPieces::ZERO; pieces.len().div_ceil(FANOUT)];
        let mut blocks = Vec::new();
        packed
            .par_iter_mut()
            .enumerate()
            .map(|(block, packed)| lanes.run(Pack { mesh, pieces: &pieces, cuts: &cuts, frame, margin, block, packed }))
            .collect_into_vec(&mut blocks);
        drop((pieces, cuts));
        let mut levels: Vec<Vec<Node>> = vec![blocks];
        while levels[levels.len() - 1].len() > 1 {
            let below = &levels[levels.len() - 1];
            let above = below
                .par_chunks(FANOUT)
                .map(|nodes| Node::new(&Children::of(nodes.iter().map(Node::bounds)), nodes.len(), 0))
                .collect();
            levels.push(above);
        }
        levels.iter_mut().for_each(Vec::shrink_to_fit);
        control.progress.report(1.0, "done")?;
        let levels = levels.into_iter().map(Column::from).collect();
        Ok(Blocks { frame, levels, pieces: packed.into(), slack })
    }
}

/// Makes a block of its pieces.
struct Pack<'a> {
    mesh: &'a Mesh,
    pieces: &'a [BuildPiece],
    cuts: &'a [Corners],
    frame: Frame,
    /// How much boxes of triangles that were cut must grow.
    margin: f32,
    block: usize,
    packed: &'a mut PackedPieces,
}

impl Kernel for Pack<'_> {
    type Output = Node;

    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> Node {
        let Pack { mesh, pieces, cuts, frame, margin, block, packed } = self;
        let from = FANOUT * block;
        let count = (pieces.len() - from).min(FANOUT);
        // What the next blocks need lies anywhere.
        for piece in pieces.iter().skip(from + FANOUT).take(FANOUT) {
            if piece.cut == WHOLE {
                prefetch_corners(mesh.vertices(), &mesh.faces()[piece.triangle as usize]);
            } else {
                prefetch_at(cuts, piece.cut as usize);
            }
        }
        for piece in pieces.iter().skip(from + 2 * FANOUT).take(FANOUT) {
            prefetch_at(mesh.faces(), piece.triangle as usize);
        }
        let mut corners = [[[[0.0; LANES]; 3]; 4]; 2];
        let mut margins = [0.0; FANOUT];
        let mut cut = 0;
        // Halves that are apart: a query reads one of them more often than both.
        let own = &pieces[from..from + count];
        let places: [i32; FANOUT] = median::places_in_leaf(own);
        for (piece, place) in own.iter().zip(places) {
            let i = place as usize;
            packed.triangles[i] = piece.triangle;
            let of_piece = if piece.cut == WHOLE {
                let [a, b, c] = mesh.triangle(piece.triangle).map(|p| frame.point(&p));
                [a, b, c, c]
            } else {
                margins[i] = margin;
                cut |= 1 << i;
                cuts[piece.cut as usize]
            };
            for c in 0..4 {
                for a in 0..3 {
                    corners[i / LANES][c][a][i % LANES] = of_piece[c][a];
                }
            }
        }
        let mut children = Children::NONE;
        for half in 0..2 {
            let (from, of_half) = (LANES * half, &corners[half]);
            for a in 0..3 {
                for lane in 0..LANES {
                    let margin = margins[from + lane];
                    let [mut lower, mut upper] = [of_half[0][a][lane] - margin, of_half[0][a][lane] + margin];
                    for c in 1..4 {
                        lower = least(lower, of_half[c][a][lane] - margin);
                        upper = greatest(upper, of_half[c][a][lane] + margin);
                    }
                    children.lower[a][from + lane] = lower;
                    children.upper[a][from + lane] = upper;
                }
            }
        }
        children.truncate(count);
        let node = Node::new(&children, count, cut);
        for half in 0..2 {
            let mut unpacked = HalfBlock::ZERO;
            unpacked.unpack_boxes(s, &node, half);
            packed.corners[half] = unpacked.pack(&corners[half]);
        }
        node
    }
}

/// Packs each chunk of triangles. Refuses meshes that memory or 32-bit ids cannot hold.
fn count_pieces(mesh: &Mesh, ids: &[u32], size: f64, limit: u64) -> Result<Vec<Count>> {
    let least: f64 = ids.par_iter().map(|id| least_pieces(&mesh.triangle(*id), size)).sum();
    check_memory("the blocks", least * Blocks::BUILD_BYTES_PER_PIECE, limit)?;
    check_entries(size, least)?;
    let most = (limit as f64 / Blocks::BUILD_BYTES_PER_PIECE).min(f64::from(u32::MAX)) as u64;
    let total = AtomicU64::new(0);
    let counts: Vec<Count> = ids
        .par_chunks(CHUNK)
        .map(|chunk| {
            let mut count = Count::default();
            for id in chunk {
                // Each chunk stops on its own, and all stop once the sum is too much.
                if count.pieces <= most && total.load(Relaxed) <= most {
                    let mut pieces = 0;
                    cut_triangle(&mesh.triangle(*id), size, &mut |_| pieces += 1);
                    count.pieces += pieces;
                    count.cut += if pieces > 1 { pieces } else { 0 };
                }
            }
            total.fetch_add(count.pieces, Relaxed);
            count
        })
        .collect();
    let total = total.into_inner();
    check_memory("the blocks", total as f64 * Blocks::BUILD_BYTES_PER_PIECE, limit)?;
    check_entries(size, total as f64)?;
    Ok(counts)
}

/// All pieces, and the corners of those that are not whole triangles.
fn cut_all(mesh: &Mesh, ids: &[u32], size: f64, counts: &[Count], frame: &Frame) -> (Vec<BuildPiece>, Vec<Corners>) {
    let sum = |f: fn(&Count) -> u64| counts.iter().map(f).sum::<u64>() as usize;
    let mut pieces = vec![BuildPiece { middle: 0, triangle: 0, cut: WHOLE }; sum(|c| c.pieces)];
    let mut cuts: Vec<Corners> = vec![[[0.0; 3]; 4]; sum(|c| c.cut)];
    let (mut rest, mut rest_of_cuts, mut first_cut) = (pieces.as_mut_slice(), cuts.as_mut_slice(), 0);
    let mut tasks = Vec::new();
    for (chunk, count) in ids.chunks(CHUNK).zip(counts) {
        let (head, tail) = rest.split_at_mut(count.pieces as usize);
        let (cut_head, cut_tail) = rest_of_cuts.split_at_mut(count.cut as usize);
        tasks.push((chunk, head, cut_head, first_cut));
        first_cut += count.cut as u32;
        (rest, rest_of_cuts) = (tail, cut_tail);
    }
    let cells = Cells::new(&Aabb { lower: [0.0; 3], upper: [1.0; 3] });
    tasks.into_par_iter().for_each(|(chunk, out, cut_out, first_cut)| {
        let (mut at, mut cut_at) = (0, 0);
        let mut cut: Vec<Corners> = Vec::new();
        for &triangle in chunk {
            cut.clear();
            cut_triangle(&mesh.triangle(triangle), size, &mut |piece| cut.push(piece.map(|p| frame.point(&p))));
            for corners in &cut {
                let place = if cut.len() > 1 { first_cut + cut_at as u32 } else { WHOLE };
                out[at] = BuildPiece { middle: middle_of(&cells, corners), triangle, cut: place };
                at += 1;
                if cut.len() > 1 {
                    cut_out[cut_at] = *corners;
                    cut_at += 1;
                }
            }
        }
    });
    (pieces, cuts)
}

/// The cell of the middle of a piece's box.
fn middle_of(cells: &Cells, [first, rest @ ..]: &Corners) -> u64 {
    let (mut lower, mut upper) = (*first, *first);
    for corner in rest {
        for a in 0..3 {
            lower[a] = least(lower[a], corner[a]);
            upper[a] = greatest(upper[a], corner[a]);
        }
    }
    cells.middle(&lower.map(f64::from), &upper.map(f64::from))
}
