//! The stored tree: nodes over blocks of pieces.

use super::node::{Frame, Node, FANOUT};
use super::pieces::PackedPieces;
use crate::geometry::bounds::Aabb;
use crate::index::selection::TrianglesThere;
use crate::mesh::triangle_mesh::Mesh;
use feeler_lanes::{prefetch, Box4, Kernel, Level, Simd, LANES};

/// Blocks that are prefetched before their triangles are looked at.
const BLOCKS_AHEAD: usize = 16;

/// See the module.
#[derive(Debug)]
pub struct Blocks {
    pub(super) frame: Frame,
    /// `levels[0]` are blocks of pieces; the last level has one node.
    pub(super) levels: Vec<Vec<Node>>,
    /// The rest of each block's pieces.
    pub(super) pieces: Vec<PackedPieces>,
    /// How far (frame units, per axis) a piece may be off its exact place.
    pub(super) slack: f32,
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

    /// For each level of nodes a word a node: which of its children have a triangle below them that is there. None of blocks.
    pub fn children_there(&self, there: TrianglesThere<'_>) -> Vec<Vec<u32>> {
        let is_any_there = |(block, node): (usize, &Node)| {
            // Of each block little is read, and the next ones are prefetched before their turn.
            if let Some(later) = self.pieces.get(block + BLOCKS_AHEAD) {
                prefetch(&later.triangles[0]);
                prefetch(&later.triangles[LANES]);
            }
            let count = node.valid.count_ones() as usize;
            self.pieces[block].triangles[..count].iter().any(|t| there.has(*t))
        };
        let mut below: Vec<bool> = self.levels[0].iter().enumerate().map(is_any_there).collect();
        let mut words = vec![Vec::new()];
        for _ in 1..self.levels.len() {
            let word = |chunk: &[bool]| chunk.iter().rev().fold(0, |bits, there| bits << 1 | u32::from(*there));
            let level: Vec<u32> = below.chunks(FANOUT).map(word).collect();
            below = level.iter().map(|word| *word != 0).collect();
            words.push(level);
        }
        words
    }

    /// The triangle of a piece.
    pub(super) fn triangle(&self, piece: usize) -> u32 {
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
