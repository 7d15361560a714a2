//! The default store: blocks of 32 boxes close together, under a shallow tree.
//!
//! Triangles are cut into pieces (for the index only), pieces are ordered by medians ([`crate::median`]), and 32 consecutive
//! ones make a block, in which they are in order along its longest side. A block keeps its pieces' boxes as bytes relative to its
//! own box, and their corners as steps within those. Blocks of blocks make the tree: the children of node `i` are the entries
//! `32 i` to `32 i + 31` of the level below, so there are no lists and no pointers.
//!
//! Boxes are compared after rounding to float32 and then to bytes. Both steps are monotone functions applied to both sides
//! alike, and `x <= y` implies `f(x) <= f(y)`: boxes that meet are never found apart, whatever the rounding. Where numbers are
//! unpacked instead, their uncertainty is added.

use crate::bounds::Aabb;
use crate::lanes::Box4;
use crate::mesh::Mesh;
use crate::simd::{Kernel, Level, Simd};

mod beside;
mod build;
mod cells;
mod descent;
mod dividers;
mod leaf;
mod near;
mod node;
mod outlines;
mod pieces;
mod rows;
mod scan;
mod sweep;
mod swept;

pub use descent::BlocksScratch;
pub use near::NearScratch;
use node::{Frame, Node, FANOUT};
use pieces::PackedPieces;
pub use sweep::SweepScratch;

/// See the module.
#[derive(Debug)]
pub struct Blocks {
    frame: Frame,
    /// `levels[0]` are blocks of pieces; the last level has one node.
    levels: Vec<Vec<Node>>,
    /// The rest of each block's pieces.
    pieces: Vec<PackedPieces>,
    /// How far (frame units, per axis) a piece may be off its exact place.
    slack: f32,
}

impl Blocks {
    /// Bytes by structure.
    pub fn memory(&self) -> Vec<(&'static str, usize)> {
        let nodes = |levels: &[Vec<Node>]| levels.iter().map(|l| l.capacity() * size_of::<Node>()).sum::<usize>();
        vec![
            ("blocks", nodes(&self.levels[..1])),
            ("tree", nodes(&self.levels[1..])),
            ("pieces", self.pieces.capacity() * size_of::<PackedPieces>()),
        ]
    }

    /// The triangle of a piece.
    fn triangle(&self, piece: usize) -> u32 {
        self.pieces[piece / FANOUT].triangles[piece % FANOUT]
    }

    /// Every triangle's box is covered by pieces, and every child lies in its node.
    pub fn validate(&self, mesh: &Mesh) -> std::result::Result<(), String> {
        let lanes = Level::best().checked();
        let mut seen = vec![0u32; mesh.faces().len()];
        let count = self.levels[0].iter().map(|node| node.valid.count_ones() as usize).sum();
        for i in 0..count {
            let (node, t) = (&self.levels[0][i / FANOUT], self.triangle(i));
            seen[t as usize] += 1;
            let b = self.frame.to_box4(&Aabb::of_triangle(&mesh.triangle(t)));
            if lanes.run(Overlapping(node, &b)) >> (i % FANOUT) & 1 == 0 {
                return Err(format!("piece {i} is away from its triangle {t}"));
            }
        }
        for t in 0..mesh.faces().len() as u32 {
            if (seen[t as usize] == 0) == mesh.is_queried(t) {
                return Err(format!("triangle {t} has {} pieces", seen[t as usize]));
            }
        }
        for i in 0..count {
            let t = self.triangle(i);
            let cut = self.levels[0][i / FANOUT].cut >> (i % FANOUT) & 1 == 1;
            if cut != (seen[t as usize] > 1) {
                return Err(format!("piece {i}: wrong mark"));
            }
        }
        let mut below = count;
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

struct Overlapping<'a>(&'a Node, &'a Box4);

impl Kernel for Overlapping<'_> {
    type Output = u32;

    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> u32 {
        self.0.overlapping(s, self.1)
    }
}
