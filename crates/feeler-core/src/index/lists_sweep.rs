//! The query of a cast on lists of voxels: each tool triangle's motion through a window of time, as a swept box.

use super::interner::{pair_key, KeySet};
use super::lists::ListedMesh;
use super::sink::{Offer, Sweep};
use crate::geometry::bounds::{Aabb, Triangle};
use crate::index::grid::VoxelRange;

/// A window costs too much when it looks up more than this many times the voxels that the tool meets standing still.
const VOXELS_TOO_MANY: f64 = 8.0;

impl ListedMesh<'_> {
    /// Offers, for each tool triangle, the entries of every voxel that the box around its motion overlaps, if the boxes
    /// of the two overlap. See [`Store::offer_swept`](super::Store::offer_swept).
    pub fn offer_swept(&self, sweep: &Sweep<'_>, seen: &mut KeySet, offer: Offer<'_>) -> bool {
        if sweep.may_give_up && self.is_too_much(sweep) {
            return false;
        }
        seen.clear();
        for (slot, triangle) in (0..).zip(sweep.tool.placeable()) {
            let bounds = sweep.window.bounds_of(triangle);
            let Some(range) = self.range(&bounds) else { continue };
            for i in range.first[0]..=range.last[0] {
                for j in range.first[1]..=range.last[1] {
                    for k in range.first[2]..=range.last[2] {
                        for &entry in self.lists.of_voxel([i, j, k]) {
                            let meets = bounds.is_overlapping(&Aabb::of_triangle(&self.mesh.triangle(entry)));
                            if meets && seen.insert(pair_key(slot, entry)) && offer(slot, entry) {
                                return true;
                            }
                        }
                    }
                }
            }
        }
        true
    }

    /// Whether a shorter window would be worth its own cost.
    fn is_too_much(&self, sweep: &Sweep<'_>) -> bool {
        let voxels = |bounds: &Aabb| {
            let range = self.range(bounds)?;
            Some((0..3).map(|a| f64::from(range.last[a] - range.first[a] + 1)).product::<f64>())
        };
        let sum = |bounds: &dyn Fn(&Triangle) -> Aabb| -> f64 {
            sweep.tool.placeable().iter().filter_map(|triangle| voxels(&bounds(triangle))).sum()
        };
        let pose = &sweep.window.poses[0];
        let still = sum(&|triangle| Aabb::of_triangle(&pose.apply_triangle(triangle)));
        sum(&|triangle| sweep.window.bounds_of(triangle)) > VOXELS_TOO_MANY * (still + sweep.tool.ids().len() as f64)
    }

    fn range(&self, bounds: &Aabb) -> Option<VoxelRange> {
        bounds.is_overlapping(self.lists.bounds()).then(|| self.lists.grid().range(bounds))
    }
}
