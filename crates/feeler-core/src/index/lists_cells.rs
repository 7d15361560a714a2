//! Voxel lists as a tree of boxes, for the plain search: occupied regions, their voxels, the voxels' triangles.

use super::lists::{ListedMesh, VoxelLists};
use super::occupancy::SIDE;
use crate::geometry::bounds::Aabb;
use crate::index::grid::VoxelRange;
use crate::index::plain_search::{Cells, Item};
use crate::index::selection::Selection;

/// A region of the grid.
#[derive(Debug, Clone, Copy)]
pub enum Region {
    /// A node of the occupancy tree.
    Node(usize, [u32; 3]),
    /// A block of voxels.
    Block([u32; 3]),
    /// A voxel.
    Voxel([u32; 3]),
}

impl Cells for ListedMesh<'_> {
    type Cell = Region;

    fn root(&self) -> Region {
        Region::Node(self.lists.occupancy().height() - 1, [0; 3])
    }

    fn open(&self, region: Region, selection: &Selection, visit: &mut dyn FnMut(Item<Region>, Aabb)) {
        let lists = self.lists;
        match region {
            Region::Node(level, node) => lists.occupancy().for_each_child(level, node, |child| {
                let below = if level == 0 { Region::Block(child) } else { Region::Node(level - 1, child) };
                // Voxels along a child: a block of four, or a node of blocks of four.
                visit(Item::Cell(below), lists.region(child, SIDE.pow(level as u32 + 1)));
            }),
            Region::Block(block) => {
                let counts = lists.grid().counts();
                let range = |a: usize| SIDE * block[a]..(SIDE * (block[a] + 1)).min(counts[a]);
                for i in range(0) {
                    for j in range(1) {
                        for k in range(2) {
                            if !lists.of_voxel([i, j, k]).is_empty() {
                                visit(Item::Cell(Region::Voxel([i, j, k])), lists.region([i, j, k], 1));
                            }
                        }
                    }
                }
            }
            Region::Voxel(voxel) => {
                for &triangle in lists.of_voxel(voxel).iter().filter(|triangle| selection.has(**triangle)) {
                    visit(Item::Triangle(triangle), Aabb::of_triangle(&self.mesh.triangle(triangle)));
                }
            }
        }
    }
}

impl VoxelLists {
    /// The box around voxels `side * at` to `side * at + side - 1` along each axis, within the mock-up's own box.
    fn region(&self, at: [u32; 3], side: u32) -> Aabb {
        let first = at.map(|x| x * side);
        let last = first.map(|x| x.saturating_add(side - 1));
        let b = self.grid().bounds_of(&VoxelRange { first, last });
        let whole = self.bounds();
        Aabb {
            lower: std::array::from_fn(|a| b.lower[a].clamp(whole.lower[a], whole.upper[a])),
            upper: std::array::from_fn(|a| b.upper[a].clamp(whole.lower[a], whole.upper[a])),
        }
    }
}
