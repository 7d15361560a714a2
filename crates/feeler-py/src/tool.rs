//! `feeler._core.Tool`: the arrays of a tool, checked and prepared once for all scenes.

use std::sync::Arc;

use feeler_core as core;
use numpy::{PyArray2, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::{rows, view_rows};
use crate::errors::to_py;
use crate::mockup::{bounds, defects};
use crate::pools::on_pool;

/// A moving tool. `feeler.Tool` adds its name and report.
#[pyclass(subclass, frozen, module = "feeler._core")]
pub struct Tool {
    pub(crate) core: Arc<core::Tool>,
}

#[pymethods]
impl Tool {
    #[new]
    fn new(py: Python<'_>, vertices: PyReadonlyArray2<'_, f64>, faces: PyReadonlyArray2<'_, u32>) -> PyResult<Tool> {
        let vertices = rows("vertices", &vertices)?;
        let faces = rows("faces", &faces)?;
        let tool = py.detach(|| on_pool(None, || core::Tool::new(vertices, faces)))?.map_err(to_py)?;
        Ok(Tool { core: Arc::new(tool) })
    }

    #[getter]
    fn vertices<'py>(slf: &Bound<'py, Self>) -> Bound<'py, PyArray2<f64>> {
        // SAFETY: the tool is frozen and owns its vertices; the array keeps it alive.
        unsafe { view_rows(slf.as_any(), slf.get().core.mesh().vertices()) }
    }

    #[getter]
    fn faces<'py>(slf: &Bound<'py, Self>) -> Bound<'py, PyArray2<u32>> {
        // SAFETY: as for the vertices.
        unsafe { view_rows(slf.as_any(), slf.get().core.mesh().faces()) }
    }

    #[getter]
    fn bounds<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        bounds(py, self.core.mesh())
    }

    #[getter]
    fn triangle_count(&self) -> usize {
        self.core.mesh().faces().len()
    }

    /// Kind of defect -> (count, first ids).
    #[getter]
    fn defects<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        defects(py, self.core.mesh())
    }
}
