//! `feeler._core.Predictor`: the predicted work and time of queries, by voxel size.

use feeler_core as core;
use pyo3::prelude::*;

use crate::arguments::ToolArgument;
use crate::errors::{raise, to_py};
use crate::mockup::Mockup;
use crate::pools::on_pool;
use crate::travel::stays;

/// The predicted work and time of queries, averaged over places of the tool on the mock-up's surface.
///
/// `constants`: seconds for a query, a tool triangle, a voxel, a list entry, a pair and a triangle test.
#[pyclass(frozen, module = "feeler._core")]
pub struct Predictor {
    core: core::Predictor,
}

/// Seconds: a query, a tool triangle, a voxel, a list entry, a pair, a triangle test.
type Constants = [f64; 6];

fn constants_of(c: Constants) -> core::CostConstants {
    core::CostConstants::default()
        .with_query(c[0])
        .with_tool_triangle(c[1])
        .with_voxel(c[2])
        .with_entry(c[3])
        .with_pair(c[4])
        .with_test(c[5])
}

#[pymethods]
impl Predictor {
    #[new]
    fn new(
        py: Python<'_>,
        mockup: &Bound<'_, Mockup>,
        tool: ToolArgument<'_, '_>,
        storage: &str,
        hashing: f64,
    ) -> PyResult<Predictor> {
        if !(0.0..=0.99).contains(&hashing) {
            return Err(to_py(core::Error::Hashing { value: hashing }));
        }
        let storage = match storage {
            "hashed" => core::Storage::Hashed { level: hashing },
            "dense" => core::Storage::Dense,
            other => return Err(raise("OptionError", format!("storage is {other:?}: choose 'dense' or 'hashed'"))),
        };
        let (mockup, tool) = (&mockup.get().core, tool.core());
        let made = py.detach(|| on_pool(None, || core::Predictor::new(mockup.mesh(), tool.mesh(), storage)))?;
        Ok(Predictor { core: made.ok_or_else(too_large_or_small)? })
    }

    /// Tool triangles placed, voxels visited, list entries read, distinct pairs, triangle tests of a query.
    fn work(&self, voxel_size: f64) -> PyResult<(f64, f64, f64, f64, f64)> {
        check(voxel_size)?;
        let work = self.core.work(voxel_size);
        Ok((work.tool_triangles, work.voxels, work.entries, work.pairs, work.tests))
    }

    /// The time of a query.
    fn seconds(&self, voxel_size: f64, constants: Constants) -> PyResult<f64> {
        check(voxel_size)?;
        Ok(self.core.work(voxel_size).seconds(&constants_of(constants)))
    }

    /// The memory of the store.
    fn bytes(&self, voxel_size: f64) -> PyResult<f64> {
        check(voxel_size)?;
        Ok(self.core.bytes(voxel_size))
    }

    /// The voxel size (metres) with the least time, among those whose store takes at most `memory_limit` bytes.
    fn optimal_size(&self, py: Python<'_>, constants: Constants, memory_limit: u64) -> PyResult<f64> {
        py.detach(|| on_pool(None, || self.core.optimal_size(&constants_of(constants), memory_limit)))
    }

    fn __reduce__(&self) -> PyResult<()> {
        Err(stays("Predictor", "make it anew from its mock-up and tool"))
    }
}

fn check(value: f64) -> PyResult<()> {
    if value.is_finite() && value > 0.0 {
        return Ok(());
    }
    Err(to_py(core::Error::VoxelSize { value }))
}

/// How the work of queries of a tool depends on the piece size of blocks.
#[pyclass(frozen, module = "feeler._core")]
pub struct PiecePredictor {
    core: core::PiecePredictor,
}

#[pymethods]
impl PiecePredictor {
    #[new]
    fn new(py: Python<'_>, mockup: &Bound<'_, Mockup>, tool: ToolArgument<'_, '_>) -> PyResult<PiecePredictor> {
        let (mockup, tool) = (&mockup.get().core, tool.core());
        let made = py.detach(|| on_pool(None, || core::PiecePredictor::new(mockup.mesh(), tool)))?;
        Ok(PiecePredictor { core: made.ok_or_else(too_large_or_small)? })
    }

    /// The work that depends on the piece size, in arbitrary units, and the number of pieces.
    fn work(&self, piece_size: f64) -> PyResult<(f64, f64)> {
        check(piece_size)?;
        let work = self.core.work(piece_size);
        Ok((work.cost(), work.pieces))
    }

    /// The piece size (metres) with the least work, within three pieces a triangle and the memory for building.
    fn optimal_size(&self, py: Python<'_>, memory_limit: u64) -> PyResult<f64> {
        py.detach(|| on_pool(None, || self.core.optimal_size(memory_limit)))
    }

    fn __reduce__(&self) -> PyResult<()> {
        Err(stays("PiecePredictor", "make it anew from its mock-up and tool"))
    }
}

fn too_large_or_small() -> PyErr {
    raise("LimitError", "the triangles are too large or too small to predict: give a voxel size".to_string())
}
