//! The voxel array of Borro et al. (2004): 4 bytes a voxel.

use super::lists::{ListedMesh, VoxelLists};
use super::sink::CandidateSink;
use crate::error::Result;
use crate::index::grid::VoxelGrid;
use crate::mesh::triangle_mesh::Mesh;
use crate::progress::Control;
use crate::tool::moving_tool::Tool;

/// One slot per voxel.
#[derive(Debug)]
pub struct Dense(VoxelLists);

impl Dense {
    /// Voxels of `size` metres over the mock-up's box.
    pub fn build(mesh: &Mesh, size: f64, limit: u64, control: Control<'_>) -> Result<Dense> {
        let grid = VoxelGrid::new(&mesh.bounds(), size)?;
        let slots = grid.voxel_count();
        Ok(Dense(VoxelLists::build(mesh, grid, slots, limit, control)?))
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
