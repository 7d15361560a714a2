//! `feeler._core.Tool`: the arrays of a tool, checked and prepared once for all scenes.

use std::sync::Arc;

use feeler_core as core;
use numpy::{PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::{rows, view_rows, IntoReadOnly};
use crate::errors::to_py;
use crate::mockup::{bounds, corners, defects};
use crate::packed::Packed;
use crate::signals::on_pool_or_left;

/// A moving tool. `feeler.Tool` adds its name and report.
#[pyclass(subclass, frozen, module = "feeler._core")]
pub struct Tool {
    pub(crate) core: Arc<core::Tool>,
}

#[pymethods]
impl Tool {
    #[new]
    #[pyo3(signature = (vertices, faces, part_of_face, part_count))]
    fn new(
        py: Python<'_>,
        vertices: PyReadonlyArray2<'_, f64>,
        faces: PyReadonlyArray2<'_, u32>,
        part_of_face: Option<PyReadonlyArray1<'_, u32>>,
        part_count: usize,
    ) -> PyResult<Tool> {
        let vertices = rows("vertices", &vertices)?;
        let faces = rows("faces", &faces)?;
        let part_of_face = part_of_face.map_or_else(Vec::new, |p| p.as_array().to_vec());
        let tool = py
            .detach(|| on_pool_or_left(move || core::Tool::of_parts(vertices, faces, part_of_face, part_count)))?
            .map_err(to_py)?;
        Ok(Tool { core: Arc::new(tool) })
    }

    /// `(n, 3)`, metres, read-only.
    #[getter]
    fn vertices<'py>(slf: &Bound<'py, Self>) -> Bound<'py, PyArray2<f64>> {
        // SAFETY: the tool is frozen and owns its vertices; the array keeps it alive.
        unsafe { view_rows(slf.as_any(), slf.get().core.mesh().vertices()) }
    }

    /// `(m, 3)`, read-only.
    #[getter]
    fn faces<'py>(slf: &Bound<'py, Self>) -> Bound<'py, PyArray2<u32>> {
        // SAFETY: as for the vertices.
        unsafe { view_rows(slf.as_any(), slf.get().core.mesh().faces()) }
    }

    /// `(m,)`: the part of each triangle.
    #[getter]
    fn part_of_face<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        let faces = self.core.mesh().faces().len() as u32;
        (0..faces).map(|f| self.core.part_of_face(f)).collect::<Vec<u32>>().into_read_only(py)
    }

    /// Parts, including those without triangles.
    #[getter]
    fn part_count(&self) -> usize {
        self.core.parts()
    }

    /// `(parts,)`: triangles of each part, defective ones included.
    #[getter]
    fn part_triangles<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        let mut counts = vec![0u32; self.core.parts()];
        let faces = self.core.mesh().faces().len() as u32;
        (0..faces).for_each(|f| counts[self.core.part_of_face(f) as usize] += 1);
        counts.into_read_only(py)
    }

    /// `(2 * parts, 3)`: lower and upper corner of each part's box, metres; crossed if the part is empty.
    #[getter]
    fn part_bounds<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let mut bounds = vec![core::Aabb::EMPTY; self.core.parts()];
        let mesh = self.core.mesh();
        for t in mesh.queried() {
            mesh.triangle(t).iter().for_each(|p| bounds[self.core.part_of_face(t) as usize].grow(p));
        }
        corners(py, &bounds)
    }

    /// `(2, 3)`: lower and upper corner of the box around all queried triangles, tool frame, metres.
    #[getter]
    fn bounds<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        bounds(py, self.core.mesh())
    }

    /// Triangles given, defective ones included.
    #[getter]
    fn triangle_count(&self) -> usize {
        self.core.mesh().faces().len()
    }

    fn pack(&self, py: Python<'_>, vertex_limit: usize, small: Option<Vec<bool>>) -> PyResult<Packed> {
        Packed::new(py, || self.core.pack(vertex_limit, small.as_deref()))
    }

    /// Kind of defect -> count and first ids.
    #[getter]
    fn defects<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        defects(py, self.core.mesh())
    }
}
