//! The query of a cast on lists of voxels: each tool triangle's way through a window, as a box.

use super::lists::ListedMesh;
use super::{Offer, Sweep};
use crate::bounds::Aabb;

impl ListedMesh<'_> {
    /// Offers, for each tool triangle, the entries of every voxel that the box around its way meets, where the boxes of the two
    /// meet. See [`Store::offer_swept`](super::Store::offer_swept).
    pub fn offer_swept(&self, sweep: &Sweep<'_>, offer: Offer<'_>) -> bool {
        let grid = self.lists.grid();
        let mut left = sweep.effort;
        for (slot, triangle) in sweep.tool.placeable().iter().enumerate() {
            let bounds = sweep.window.bounds_of(triangle);
            if !bounds.is_overlapping(self.lists.bounds()) {
                continue;
            }
            let range = grid.range(&bounds);
            for i in range.first[0]..=range.last[0] {
                for j in range.first[1]..=range.last[1] {
                    for k in range.first[2]..=range.last[2] {
                        if left == 0 {
                            return false;
                        }
                        left -= 1;
                        for &entry in self.lists.of_voxel([i, j, k]) {
                            let meets = bounds.is_overlapping(&Aabb::of_triangle(&self.mesh.triangle(entry)));
                            if meets && offer(slot as u32, entry) {
                                return true;
                            }
                        }
                    }
                }
            }
        }
        true
    }
}
