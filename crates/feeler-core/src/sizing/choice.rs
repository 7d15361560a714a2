//! The default voxel size, and the best one for a tool.

use super::cost::{mean_longest_edge, static_means, CostFunction, Estimator};
use super::piece_predictor::PiecePredictor;
use super::predictor::Predictor;
use crate::constants::MOCKUP_CUT_ALLOWANCE;
use crate::index::store::Storage;
use crate::mesh::pieces::default_piece_size;
use crate::mesh::triangle_mesh::Mesh;
use crate::tool::moving_tool::Tool;

/// The voxel size a scene uses when none is given, metres.
///
/// For `dense` and `hashed` the minimum of the paper's cost function with the area estimator; without a tool, for one
/// whose triangles are as long as the mock-up's own (mean longest edge). For `blocks` the piece size with which boxes
/// of the tool overlap the fewest of the mock-up's ([`PiecePredictor`]), as far as building stays below `limit` bytes;
/// without a tool the one that spends a fixed share of extra pieces on the longest triangles.
pub fn default_voxel_size(mesh: &Mesh, tool: Option<&Tool>, storage: Storage, limit: u64) -> f64 {
    if storage == Storage::Blocks {
        if let Some(predictor) = tool.and_then(|tool| PiecePredictor::new(mesh, tool)) {
            return predictor.optimal_size(limit);
        }
        let excluded = mesh.excluded().is_empty();
        let ids: Vec<u32> = if excluded { Vec::new() } else { mesh.queried().collect() };
        let triangle = |i: usize| mesh.triangle(if excluded { i as u32 } else { ids[i] });
        return default_piece_size(mesh.queried_count(), triangle, MOCKUP_CUT_ALLOWANCE);
    }
    let size = match tool {
        Some(tool) => optimal_voxel_size(mesh, tool, Estimator::Area),
        None => CostFunction::new(static_means(mesh), mean_longest_edge(mesh), Estimator::Area).optimal_size(),
    };
    // Areas of a mesh near the smallest float64 underflow; any coarse grid is right, so take one.
    if size.is_normal() && size > f64::MIN_POSITIVE * 4.0 {
        size
    } else {
        mesh.bounds().extent().iter().fold(1e-300, |m, x| f64::max(m, 0.125 * x))
    }
}

/// The voxel size (metres) that is best for a mock-up and a tool, by the paper's cost function or by prediction (for the store
/// `dense` without a memory limit; a [`Predictor`] knows more).
pub fn optimal_voxel_size(mesh: &Mesh, tool: &Tool, estimator: Estimator) -> f64 {
    if let Estimator::Calibrated(constants) = estimator {
        if let Some(predictor) = Predictor::new(mesh, tool.mesh(), Storage::Dense) {
            return predictor.optimal_size(&constants, u64::MAX);
        }
    }
    CostFunction::new(static_means(mesh), mean_longest_edge(tool.mesh()), estimator).optimal_size()
}
