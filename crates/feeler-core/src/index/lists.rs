//! Lists of triangles by slot, where a slot is a voxel (dense) or a hash of voxels (hashed).

use std::sync::atomic::{AtomicU32, AtomicU64, Ordering::Relaxed};

use rayon::prelude::*;

use super::limits::{check_entries, check_memory, filled};
use super::occupancy::Occupancy;
use super::sink::CandidateSink;
use crate::error::{Error, Result};
use crate::geometry::bounds::Aabb;
use crate::index::grid::VoxelGrid;
use crate::mesh::triangle_mesh::Mesh;
use crate::progress::{Control, GoOn, Pace};
use crate::tool::moving_tool::Tool;

/// Triangles between two questions whether building goes on.
const TRIANGLES_BETWEEN: u32 = 1024;

/// Slots between two such questions, where lists are put together.
const SLOTS_BETWEEN: u32 = 1 << 16;

/// For each slot the triangles of its voxels, ascending, each once.
#[derive(Debug)]
pub struct VoxelLists {
    grid: VoxelGrid,
    bounds: Aabb,
    slots: u64,
    /// Slot `s` has entries `starts[s]..starts[s + 1]`.
    starts: Vec<u32>,
    entries: Vec<u32>,
    occupancy: Occupancy,
}

/// Voxel lists with the mesh whose triangles they name.
pub struct ListedMesh<'a> {
    pub lists: &'a VoxelLists,
    pub mesh: &'a Mesh,
}

impl VoxelLists {
    /// Puts every triangle into the slot `key % slots` of every voxel that it overlaps.
    ///
    /// Two parallel passes over the triangles: count, then fill. The order in which threads fill a slot does not matter, as
    /// each list is sorted afterwards.
    pub fn build(mesh: &Mesh, grid: VoxelGrid, slots: u64, limit: u64, control: Control<'_>) -> Result<VoxelLists> {
        let fixed = 4.0 * (slots as f64 + 1.0) + Occupancy::bytes(&grid);
        check_memory("the voxel array", fixed, limit)?;
        // Before anything is allocated: the lists need at least this much.
        let least: f64 = mesh.par_queried().map(|id| grid.least_voxels(&mesh.triangle(id))).sum();
        check_memory("the voxel array and its lists", fixed + 4.0 * least, limit)?;
        check_entries(grid.size(), least)?;
        // Counting stops where the lists would outgrow the limit, or the 32 bits of a position.
        let most = u64::from(u32::MAX).min((limit - fixed as u64) / 4);

        control.progress.report(0.0, "counting voxels")?;
        let starts: Vec<AtomicU32> = filled("the voxel array", slots + 1, limit)?;
        let occupancy = Occupancy::new(&grid, limit)?;
        let total = AtomicU64::new(0);
        let Control { go_on, .. } = control;
        let goes_on = |id: u32| if id.is_multiple_of(TRIANGLES_BETWEEN) { go_on.check() } else { Ok(()) };
        mesh.par_queried().try_for_each(|id| {
            goes_on(id)?;
            if total.load(Relaxed) > most {
                return Ok(());
            }
            let mut count = 0;
            grid.for_each_voxel(&mesh.triangle(id), |voxel| {
                starts[(grid.key(voxel) % slots) as usize].fetch_add(1, Relaxed);
                occupancy.mark(voxel);
                count += 1;
            });
            total.fetch_add(count, Relaxed);
            Ok(())
        })?;
        let total = total.into_inner();
        check_memory("the voxel array and its lists", fixed + 4.0 * total as f64, limit)?;
        check_entries(grid.size(), total as f64)?;

        // Each slot's end; filling from the end moves it to the slot's start.
        let mut sum = 0;
        for slot in &starts {
            sum += slot.load(Relaxed);
            slot.store(sum, Relaxed);
        }
        control.progress.report(0.4, "filling voxels")?;
        let entries: Vec<AtomicU32> = filled("the voxel lists", total, limit)?;
        mesh.par_queried().try_for_each(|id| {
            goes_on(id)?;
            grid.for_each_voxel(&mesh.triangle(id), |voxel| {
                let at = starts[(grid.key(voxel) % slots) as usize].fetch_sub(1, Relaxed) - 1;
                entries[at as usize].store(id, Relaxed);
            });
            Ok(())
        })?;
        // Same layout: these reuse the allocations.
        let starts: Vec<u32> = starts.into_iter().map(AtomicU32::into_inner).collect();
        let entries: Vec<u32> = entries.into_iter().map(AtomicU32::into_inner).collect();
        control.progress.report(0.8, "sorting lists")?;
        let mut lists = VoxelLists { grid, bounds: mesh.bounds(), slots, starts, entries, occupancy };
        lists.sort(go_on)?;
        if lists.grid.voxel_count() > slots {
            lists.remove_repeats(go_on)?;
        }
        control.progress.report(1.0, "done")?;
        Ok(lists)
    }

    fn sort(&mut self, go_on: GoOn<'_>) -> Result<()> {
        const SORT_RUN: usize = 1 << 14; // slots a task
        let mut rest = self.entries.as_mut_slice();
        let mut tasks = Vec::new();
        let mut from = 0;
        for run in self.starts.chunks(SORT_RUN) {
            // A run of slots ends where the next one starts.
            let next = self.starts[(from + run.len()).min(self.slots as usize)];
            let (head, tail) = rest.split_at_mut((next - run[0]) as usize);
            tasks.push((from, head));
            rest = tail;
            from += run.len();
        }
        tasks.into_par_iter().try_for_each(|(first, entries)| {
            go_on.check()?;
            let base = self.starts[first];
            let last = (first + SORT_RUN).min(self.slots as usize);
            for slot in first..last {
                entries[(self.starts[slot] - base) as usize..(self.starts[slot + 1] - base) as usize].sort_unstable();
            }
            Ok(())
        })
    }

    /// A triangle may meet several voxels of one slot; it is listed once.
    fn remove_repeats(&mut self, go_on: GoOn<'_>) -> Result<()> {
        let mut kept = 0u32;
        let mut pace = Pace::new(go_on, SLOTS_BETWEEN);
        for slot in 0..self.slots as usize {
            if pace.step() {
                return Err(Error::Cancelled);
            }
            let (from, to) = (self.starts[slot], self.starts[slot + 1]);
            self.starts[slot] = kept;
            let mut last = None;
            for i in from..to {
                let id = self.entries[i as usize];
                if last != Some(id) {
                    self.entries[kept as usize] = id;
                    kept += 1;
                    last = Some(id);
                }
            }
        }
        self.starts[self.slots as usize] = kept;
        self.entries.truncate(kept as usize);
        self.entries.shrink_to_fit();
        Ok(())
    }

    /// Offers, for each tool triangle, the entries of every voxel that its box overlaps.
    pub fn offer_candidates<N: CandidateSink>(&self, tool: &Tool, narrow: &mut N) {
        for slot in 0..tool.ids().len() as u32 {
            let bounds = narrow.placed_bounds(slot);
            if !bounds.is_overlapping(&self.bounds) {
                continue;
            }
            let range = self.grid.range(&bounds);
            let may_repeat = range.first != range.last;
            for i in range.first[0]..=range.last[0] {
                for j in range.first[1]..=range.last[1] {
                    let row = self.grid.key([i, j, 0]);
                    for k in range.first[2]..=range.last[2] {
                        narrow.stats().voxels_visited += 1;
                        for &entry in self.slot(((row + u64::from(k)) % self.slots) as usize) {
                            if narrow.offer(slot, entry, may_repeat) {
                                return;
                            }
                        }
                    }
                }
            }
        }
    }

    /// The grid.
    pub fn grid(&self) -> &VoxelGrid {
        &self.grid
    }

    /// The mock-up's box.
    pub fn bounds(&self) -> &Aabb {
        &self.bounds
    }

    /// Which regions hold triangles.
    pub fn occupancy(&self) -> &Occupancy {
        &self.occupancy
    }

    /// The triangles listed for a voxel: its own, and perhaps others.
    pub fn of_voxel(&self, voxel: [u32; 3]) -> &[u32] {
        self.slot((self.grid.key(voxel) % self.slots) as usize)
    }

    #[inline]
    fn slot(&self, slot: usize) -> &[u32] {
        &self.entries[self.starts[slot] as usize..self.starts[slot + 1] as usize]
    }

    /// Bytes by structure.
    pub fn memory(&self) -> Vec<(&'static str, usize)> {
        vec![
            ("voxels", self.starts.capacity() * 4),
            ("lists", self.entries.capacity() * 4),
            ("occupancy", self.occupancy.memory()),
        ]
    }

    /// Every triangle is in the slot of every voxel that it overlaps; lists ascend.
    pub fn validate(&self, mesh: &Mesh) -> std::result::Result<(), String> {
        for slot in 0..self.slots as usize {
            if !self.slot(slot).windows(2).all(|w| w[0] < w[1]) {
                return Err(format!("slot {slot} is not ascending"));
            }
        }
        for id in mesh.queried() {
            let mut missing = None;
            self.grid.for_each_voxel(&mesh.triangle(id), |voxel| {
                if self.slot((self.grid.key(voxel) % self.slots) as usize).binary_search(&id).is_err() {
                    missing = Some(voxel);
                }
            });
            if let Some(voxel) = missing {
                return Err(format!("triangle {id} is missing from voxel {voxel:?}"));
            }
        }
        Ok(())
    }
}
