//! `feeler._core.swept`: the volume that a tool sweeps, as arrays.

use std::sync::Arc;

use feeler_plan as plan;
use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray2};
use pyo3::prelude::*;

use crate::arguments::{PosesArgument, ToolArgument};
use crate::errors::{raise, to_py};
use crate::pools::Pool;
use crate::reporter::Reporter;

/// Vertices `(n, 3) float64`, faces `(m, 3) uint32`.
type Arrays<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<u32>>);

/// The closed mesh around the swept volume of a tool: vertices `(n, 3)`, metres, world, faces `(m, 3)`, wound
/// outwards.
///
/// Raises `PoseError`, `OptionError` for an error that is not a positive length, `LimitError` for one that is too
/// small.
#[pyfunction]
#[pyo3(signature = (tool, poses, error, *, threads = None, memory_limit = u64::MAX, progress = None))]
pub fn swept<'py>(
    py: Python<'py>,
    tool: ToolArgument<'_, 'py>,
    poses: PosesArgument,
    error: f64,
    threads: Option<usize>,
    memory_limit: u64,
    progress: Option<Py<PyAny>>,
) -> PyResult<Arrays<'py>> {
    let core = Arc::clone(tool.core());
    let pool = threads.map(Pool::new);
    let reporter = Reporter::new(progress);
    let found = py.detach(|| {
        reporter.watch(pool.as_ref(), || {
            let tell = |done: f64, stage: &str| reporter.tell(done, stage);
            let options = plan::SweptOptions::default().with_memory_limit(memory_limit).with_progress(&tell);
            plan::swept(&core, &poses.0, error, &options)
        })
    });
    reporter.finish()?;
    let plan::Swept { vertices, faces, .. } = found?.map_err(to_py)?;
    Ok((array(py, vertices)?, array(py, faces)?))
}

fn array<T: numpy::Element>(py: Python<'_>, rows: Vec<[T; 3]>) -> PyResult<Bound<'_, PyArray2<T>>> {
    let array = Array2::from_shape_vec((rows.len(), 3), rows.into_flattened());
    Ok(array.map_err(|error| raise("FeelerError", error.to_string()))?.into_pyarray(py))
}
