//! The hashed voxel array of Borro et al. (2004, equation 1): `key = (i*Nj + j)*Nk + k`, `H = key mod table size`.
//!
//! If several voxels share a slot, the slot holds the triangles of all of them, each once. A query that visits one of
//! these voxels is offered the others' triangles too. They lie elsewhere, so the box filter or the triangle test
//! discards them: a hash collision costs time and never changes the answer.

use super::lists::{ListedMesh, VoxelLists};
use super::sink::CandidateSink;
use crate::error::{Error, Result};
use crate::index::grid::VoxelGrid;
use crate::mesh::triangle_mesh::Mesh;
use crate::progress::Control;
use crate::tool::moving_tool::Tool;

/// Fewer slots than voxels.
#[derive(Debug)]
pub struct Hashed(VoxelLists);

impl Hashed {
    /// Voxels of `size` metres; the table has `(1 - level)` times as many slots, at least one.
    pub fn build(mesh: &Mesh, size: f64, level: f64, limit: u64, control: Control<'_>) -> Result<Hashed> {
        if !(0.0..=0.99).contains(&level) {
            return Err(Error::Hashing { value: level });
        }
        let grid = VoxelGrid::new(&mesh.bounds(), size)?;
        let slots = ((grid.voxel_count() as f64 * (1.0 - level)).round() as u64).max(1);
        Ok(Hashed(VoxelLists::build(mesh, grid, slots, limit, control)?))
    }

    /// See [`VoxelLists::offer_candidates`].
    pub fn offer_candidates<N: CandidateSink>(&self, tool: &Tool, narrow: &mut N) {
        self.0.offer_candidates(tool, narrow);
    }

    /// The lists with their mesh.
    pub fn with<'a>(&'a self, mesh: &'a Mesh) -> ListedMesh<'a> {
        ListedMesh { lists: &self.0, mesh }
    }

    /// Bytes by structure.
    pub fn memory(&self) -> Vec<(&'static str, usize)> {
        self.0.memory()
    }

    /// Checks the lists.
    pub fn validate(&self, mesh: &Mesh) -> std::result::Result<(), String> {
        self.0.validate(mesh)
    }
}
