//! The parts of each block's pieces, and the nodes of a single part: checked before the tree is compared with itself,
//! so that no part is compared with itself.

use rayon::prelude::*;

use super::node::FANOUT;
use super::tree::Blocks;
use crate::mesh::mockup::Mockup;
use feeler_lanes::{prefetch, LANES};

/// A node with pieces of several parts.
pub(super) const MANY: u32 = u32::MAX;
/// A node with no wanted part below it.
pub(super) const NOTHING: u32 = u32::MAX - 1;

/// Blocks that a task looks at.
const BLOCKS_A_TASK: usize = 1024;
/// Blocks that are prefetched before they are looked at.
const TASK_BLOCKS_AHEAD: usize = 8;

/// The pieces of one part in a block.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PartPieces {
    pub part: u32,
    /// One bit a piece.
    pub pieces: u32,
}

/// See the module.
#[derive(Debug)]
pub struct BlockParts {
    /// For each level and node its only part, [`MANY`] or [`NOTHING`].
    nodes: Vec<Vec<u32>>,
    /// Where the entries of each block begin.
    starts: Vec<u32>,
    entries: Vec<PartPieces>,
}

impl BlockParts {
    /// For the parts with `is_asked`.
    pub fn new(blocks: &Blocks, mockup: &Mockup, is_asked: impl Fn(u32) -> bool + Sync) -> BlockParts {
        let chunks: Vec<(Vec<u32>, Vec<PartPieces>)> = (0..blocks.pieces.len())
            .step_by(BLOCKS_A_TASK)
            .collect::<Vec<_>>()
            .into_par_iter()
            .map(|from| of_chunk(blocks, mockup, &is_asked, from..(from + BLOCKS_A_TASK).min(blocks.pieces.len())))
            .collect();
        let mut starts = vec![0];
        let mut entries: Vec<PartPieces> = Vec::new();
        for (counts, found) in chunks {
            for count in counts {
                starts.push(starts[starts.len() - 1] + count);
            }
            entries.extend(found);
        }
        let own = |i: usize| match &entries[starts[i] as usize..starts[i + 1] as usize] {
            [] => NOTHING,
            [one] => one.part,
            _ => MANY,
        };
        let mut nodes = vec![(0..blocks.pieces.len()).map(own).collect::<Vec<u32>>()];
        for _ in 1..blocks.levels.len() {
            let below = &nodes[nodes.len() - 1];
            let merged = below.chunks(FANOUT).map(|own| own.iter().copied().reduce(merged).unwrap_or(NOTHING));
            nodes.push(merged.collect());
        }
        BlockParts { nodes, starts, entries }
    }

    /// The only part of a node, [`MANY`] or [`NOTHING`].
    #[inline(always)]
    pub(super) fn of_node(&self, level: usize, node: u32) -> u32 {
        self.nodes[level][node as usize]
    }

    /// The parts of a block, and their pieces.
    #[inline(always)]
    pub fn of_block(&self, block: u32) -> &[PartPieces] {
        &self.entries[self.starts[block as usize] as usize..self.starts[block as usize + 1] as usize]
    }
}

fn merged(a: u32, b: u32) -> u32 {
    match (a, b) {
        (NOTHING, other) | (other, NOTHING) => other,
        (a, b) if a == b => a,
        _ => MANY,
    }
}

/// How many entries each of some blocks has, and these, sorted by part.
fn of_chunk(
    blocks: &Blocks,
    mockup: &Mockup,
    is_asked: &(impl Fn(u32) -> bool + Sync),
    range: std::ops::Range<usize>,
) -> (Vec<u32>, Vec<PartPieces>) {
    let (mut counts, mut entries) = (Vec::with_capacity(range.len()), Vec::with_capacity(2 * range.len()));
    for block in range {
        if let Some(later) = blocks.pieces.get(block + TASK_BLOCKS_AHEAD) {
            prefetch(&later.triangles[0]);
            prefetch(&later.triangles[LANES]);
        }
        let first = entries.len();
        let count = blocks.levels[0][block].valid.count_ones() as usize;
        for (i, triangle) in blocks.pieces[block].triangles[..count].iter().enumerate() {
            let part = mockup.part_of_face(*triangle);
            // Mostly the part of the piece before.
            match entries[first..].iter_mut().rev().find(|entry: &&mut PartPieces| entry.part == part) {
                Some(entry) => entry.pieces |= 1 << i,
                None if is_asked(part) => entries.push(PartPieces { part, pieces: 1 << i }),
                None => {}
            }
        }
        entries[first..].sort_unstable_by_key(|entry| entry.part);
        counts.push((entries.len() - first) as u32);
    }
    (counts, entries)
}
