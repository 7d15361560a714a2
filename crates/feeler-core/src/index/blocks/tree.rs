//! The stored tree: nodes over blocks of pieces.

use bytemuck::{Pod, Zeroable};
use rayon::prelude::*;

use super::node::{Frame, Node, FANOUT};
use super::pieces::PackedPieces;
use crate::error::Result;
use crate::geometry::bounds::Aabb;
use crate::index::selection::TrianglesThere;
use crate::mesh::triangle_mesh::Mesh;
use crate::saved::{check, Reader, Sections};
use feeler_lanes::{prefetch, Box4, Column, Kernel, Level, Simd, LANES};

/// Blocks that are prefetched before their triangles are looked at.
const BLOCKS_AHEAD: usize = 16;

/// See the module.
#[derive(Debug)]
pub struct Blocks {
    pub(super) frame: Frame,
    /// `levels[0]` are blocks of pieces; the last level has one node.
    pub(super) levels: Vec<Column<Node>>,
    /// The rest of each block's pieces.
    pub(super) pieces: Column<PackedPieces>,
    /// How far (frame units, per axis) a piece may be off its exact place.
    pub(super) slack: f32,
}

/// What a saved scene says of the blocks beside their arrays.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct Facts {
    origin: [f64; 3],
    scale: f64,
    slack: f32,
    levels: u32,
}

/// 2^32 pieces have so many.
const MOST_LEVELS: u32 = 7;

fn level_name(level: usize) -> String {
    format!("blocks.level{level}")
}

impl Blocks {
    /// Adds them to the sections of a saved scene.
    pub fn save<'a>(&'a self, sections: &mut Sections<'a>) {
        let Frame { origin, scale } = self.frame;
        sections
            .add_made("blocks.facts", &[Facts { origin, scale, slack: self.slack, levels: self.levels.len() as u32 }]);
        for (level, nodes) in self.levels.iter().enumerate() {
            sections.add(level_name(level), nodes);
        }
        sections.add("blocks.pieces", &self.pieces);
    }

    /// From the sections of a saved scene of this mesh.
    pub fn of_saved(saved: Reader<'_>, mesh: &Mesh) -> Result<Blocks> {
        let Facts { origin, scale, slack, levels } = saved.one("blocks.facts")?;
        check((1..=MOST_LEVELS).contains(&levels), || "blocks.facts".into())?;
        let pieces: Column<PackedPieces> = saved.column("blocks.pieces")?;
        let mut below = pieces.len();
        let mut nodes = Vec::new();
        for level in 0..levels as usize {
            let expected = if level == 0 { below } else { below.div_ceil(FANOUT) };
            let own = saved.column_of::<Node>(&level_name(level), expected)?;
            below = own.len();
            nodes.push(own);
        }
        check(below == 1, || "blocks: there is not one root".into())?;
        let blocks = Blocks { frame: Frame { origin, scale }, levels: nodes, pieces, slack };
        if saved.is_checked {
            let is_frame = scale.is_finite() && slack.is_finite() && scale > 0.0 && slack >= 0.0;
            check(is_frame && origin.iter().all(|x| x.is_finite()), || "blocks.facts".into())?;
            blocks.check(mesh)?;
        }
        Ok(blocks)
    }

    /// Each node has the children that it must have, and each piece is of a triangle that is queried: others have corners that are
    /// not there.
    fn check(&self, mesh: &Mesh) -> Result<()> {
        let is_queried = |t: &u32| (*t as usize) < mesh.faces().len() && mesh.is_queried(*t);
        let is_right = |(packed, node): (&PackedPieces, &Node)| {
            let (last, count) = (u32::MAX.checked_shr(node.valid.leading_zeros()), node.valid.count_ones() as usize);
            last == Some(node.valid) && packed.triangles[..count].iter().all(is_queried)
        };
        let blocks = self.pieces.par_iter().zip(self.levels[0].par_iter());
        check(blocks.all(is_right), || "blocks.pieces".into())?;
        for level in 1..self.levels.len() {
            let below = self.levels[level - 1].len();
            for (n, node) in self.levels[level].iter().enumerate() {
                let count = (below - n * FANOUT).min(FANOUT);
                check(node.valid == u32::MAX >> (FANOUT - count), || level_name(level))?;
            }
        }
        Ok(())
    }

    /// Bytes by structure.
    pub fn memory(&self) -> Vec<(&'static str, usize)> {
        let nodes = |levels: &[Column<Node>]| levels.iter().map(Column::memory).sum::<usize>();
        vec![("blocks", nodes(&self.levels[..1])), ("tree", nodes(&self.levels[1..])), ("pieces", self.pieces.memory())]
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

    /// The same after more triangles left, all of them in these boxes (metres): only nodes that overlap one are looked at. `words` are
    /// those of before, empty where all were there.
    pub fn children_left(&self, words: &[Vec<u32>], there: TrianglesThere<'_>, boxes: &[Aabb]) -> Vec<Vec<u32>> {
        let words = if words.is_empty() {
            let all = |level: &Column<Node>| level.iter().map(|node| node.valid).collect();
            std::iter::once(Vec::new()).chain(self.levels.iter().skip(1).map(all)).collect()
        } else {
            words.to_vec()
        };
        let boxes: Vec<Box4> = boxes.iter().map(|b| self.frame.to_box4(b)).collect();
        let mut left = Left { blocks: self, there, words };
        left.has_any(self.levels.len() - 1, 0, &boxes);
        left.words
    }

    /// The triangle of a piece.
    pub(super) fn triangle(&self, piece: usize) -> u32 {
        self.pieces[piece / FANOUT].triangles[piece % FANOUT]
    }

    /// Every triangle's box is covered by pieces, and every child lies in its node.
    pub fn validate(&self, mesh: &Mesh) -> std::result::Result<(), String> {
        self.validate_of(mesh, &mesh.queried().collect::<Vec<u32>>())
    }

    /// The same of blocks of some triangles, ascending.
    pub fn validate_of(&self, mesh: &Mesh, ids: &[u32]) -> std::result::Result<(), String> {
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
            if (seen[t as usize] == 0) == ids.binary_search(&t).is_ok() {
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

/// Words of nodes that triangles leave.
struct Left<'a> {
    blocks: &'a Blocks,
    there: TrianglesThere<'a>,
    words: Vec<Vec<u32>>,
}

impl Left<'_> {
    /// Whether a node has anything below it that is there; its word, and those below it, are right then.
    fn has_any(&mut self, level: usize, node: usize, boxes: &[Box4]) -> bool {
        let own = &self.blocks.levels[level][node];
        let bounds = own.bounds();
        // Both are rounded alike, and a node is around all of its pieces.
        let meets = |b: &Box4| (0..3).all(|a| b.lower[a] <= bounds.upper[a] && bounds.lower[a] <= b.upper[a]);
        let near: Vec<Box4> = boxes.iter().copied().filter(meets).collect();
        if level == 0 {
            let count = own.valid.count_ones() as usize;
            return near.is_empty() || self.blocks.pieces[node].triangles[..count].iter().any(|t| self.there.has(*t));
        }
        let before = self.words[level][node];
        if !near.is_empty() {
            for child in (0..FANOUT).filter(|child| before >> child & 1 == 1) {
                if !self.has_any(level - 1, FANOUT * node + child, &near) {
                    self.words[level][node] &= !(1 << child);
                }
            }
        }
        self.words[level][node] != 0
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
