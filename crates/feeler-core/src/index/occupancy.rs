//! The occupied regions of a voxel grid: an octree of bits, two levels at a step, for distance queries.
//!
//! The lowest bit represents a block of 4 x 4 x 4 voxels, so all bits together take less than a 2000th of 4 bytes a
//! voxel.

use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use super::limits::filled;
use crate::error::Result;
use crate::index::grid::VoxelGrid;

/// Voxels, or children, along each axis of a block or node.
pub const SIDE: u32 = 4;

/// See the module.
#[derive(Debug)]
pub struct Occupancy {
    /// `levels[0]` has bits for blocks of voxels; the last level has one node.
    levels: Vec<Level>,
}

#[derive(Debug)]
struct Level {
    counts: [u32; 3],
    /// For each node 64 bits, one for each of its children: `(4 i + j) 4 + k`.
    masks: Vec<AtomicU64>,
}

impl Occupancy {
    /// Bytes it takes for a grid.
    pub fn bytes(grid: &VoxelGrid) -> f64 {
        shapes(grid).iter().map(|counts| 8.0 * counts.iter().map(|n| f64::from(*n)).product::<f64>()).sum()
    }

    /// Nothing is occupied yet.
    pub fn new(grid: &VoxelGrid, limit: u64) -> Result<Occupancy> {
        let level = |counts: [u32; 3]| {
            let nodes = counts.iter().map(|n| u64::from(*n)).product();
            Ok(Level { counts, masks: filled("the occupancy of the voxels", nodes, limit)? })
        };
        Ok(Occupancy { levels: shapes(grid).into_iter().map(level).collect::<Result<_>>()? })
    }

    /// Marks a voxel as holding something.
    pub fn mark(&self, voxel: [u32; 3]) {
        let mut at = voxel.map(|x| x / SIDE);
        for level in &self.levels {
            let node = at.map(|x| x / SIDE);
            let bit = 1 << child_bit(at.map(|x| x % SIDE));
            let mask = &level.masks[level.index(node)];
            // Most marks are there already, and then so are those above.
            if mask.load(Relaxed) & bit != 0 || mask.fetch_or(bit, Relaxed) & bit != 0 {
                return;
            }
            at = node;
        }
    }

    /// Levels of nodes; those of level 0 have blocks of voxels below them.
    pub fn height(&self) -> usize {
        self.levels.len()
    }

    /// Calls `visit` with each occupied child of a node: its address among the nodes of the level below (level 0: among the
    /// blocks of voxels).
    pub fn for_each_child(&self, level: usize, node: [u32; 3], mut visit: impl FnMut([u32; 3])) {
        let mut mask = self.levels[level].masks[self.levels[level].index(node)].load(Relaxed);
        while mask != 0 {
            let bit = mask.trailing_zeros();
            mask &= mask - 1;
            visit([SIDE * node[0] + bit / 16, SIDE * node[1] + bit / 4 % 4, SIDE * node[2] + bit % 4]);
        }
    }

    /// Bytes held.
    pub fn memory(&self) -> usize {
        self.levels.iter().map(|level| level.masks.capacity() * size_of::<u64>()).sum()
    }
}

impl Level {
    fn index(&self, [i, j, k]: [u32; 3]) -> usize {
        (i as usize * self.counts[1] as usize + j as usize) * self.counts[2] as usize + k as usize
    }
}

fn child_bit([i, j, k]: [u32; 3]) -> u32 {
    (SIDE * i + j) * SIDE + k
}

/// Nodes along each axis, level by level.
fn shapes(grid: &VoxelGrid) -> Vec<[u32; 3]> {
    let mut counts = grid.counts().map(|n| n.div_ceil(SIDE * SIDE));
    let mut shapes = vec![counts];
    while counts != [1; 3] {
        counts = counts.map(|n| n.div_ceil(SIDE));
        shapes.push(counts);
    }
    shapes
}
