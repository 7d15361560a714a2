//! `feeler._core.Mockup`: the arrays of a mock-up, checked.

use std::sync::Arc;

use feeler_core as core;
use numpy::{PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::{read_only, rows, view_rows, IntoReadOnly};
use crate::errors::to_py;
use crate::packed::Packed;
use crate::saved::SavedScene;
use crate::signals::on_pool_or_left;
use crate::travel::stays;

/// A static mock-up. `feeler.Mockup` adds names and reports.
#[pyclass(subclass, frozen, module = "feeler._core")]
pub struct Mockup {
    pub(crate) core: Arc<core::Mockup>,
}

/// The core of a mock-up that another one's parts were moved for: an argument for `Mockup`.
#[pyclass(frozen, module = "feeler._core")]
pub struct MovedMockup {
    pub core: Arc<core::Mockup>,
}

#[pymethods]
impl MovedMockup {
    fn __reduce__(&self) -> PyResult<()> {
        Err(stays("MovedMockup", "pickle the mock-up that is made of it"))
    }
}

/// What a mock-up is made of.
#[derive(FromPyObject)]
enum MockupSource<'py> {
    /// A file.
    Saved(PyRef<'py, SavedScene>),
    /// Another mock-up, with parts moved.
    Moved(PyRef<'py, MovedMockup>),
    /// Arrays, with faces.
    Vertices(PyReadonlyArray2<'py, f64>),
}

#[pymethods]
impl Mockup {
    #[new]
    #[pyo3(signature = (vertices, faces = None, part_of_face = None, part_count = 1))]
    fn new(
        py: Python<'_>,
        vertices: MockupSource<'_>,
        faces: Option<PyReadonlyArray2<'_, u32>>,
        part_of_face: Option<PyReadonlyArray1<'_, u32>>,
        part_count: usize,
    ) -> PyResult<Mockup> {
        let (vertices, faces) = match (vertices, faces) {
            (MockupSource::Saved(saved), None) => return Ok(Mockup { core: saved.mockup() }),
            (MockupSource::Moved(moved), None) => return Ok(Mockup { core: Arc::clone(&moved.core) }),
            (MockupSource::Vertices(vertices), Some(faces)) => (vertices, faces),
            _ => return Err(PyTypeError::new_err("vertices and faces, or a saved scene alone")),
        };
        let vertices = rows("vertices", &vertices)?;
        let faces = rows("faces", &faces)?;
        let part_of_face = part_of_face.map_or_else(Vec::new, |p| p.as_array().to_vec());
        let made = py
            .detach(|| on_pool_or_left(move || core::Mockup::new(vertices, faces, part_of_face, part_count)))?
            .map_err(to_py)?;
        Ok(Mockup { core: Arc::new(made) })
    }

    /// `(n, 3)`, metres, read-only.
    #[getter]
    fn vertices<'py>(slf: &Bound<'py, Self>) -> Bound<'py, PyArray2<f64>> {
        // SAFETY: the mock-up is frozen and owns its vertices; the array keeps it alive.
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

    /// `(parts,)`: triangles of each part, defective ones included.
    #[getter]
    fn part_triangles<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        self.core.part_triangles().to_vec().into_read_only(py)
    }

    /// `(2 * parts, 3)`: lower and upper corner of each part's box, metres; crossed if the part is empty.
    #[getter]
    fn part_bounds<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        corners(py, self.core.part_bounds())
    }

    /// `(2, 3)`: lower and upper corner of the box around all queried triangles, metres.
    #[getter]
    fn bounds<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        bounds(py, self.core.mesh())
    }

    /// Triangles given, defective ones included.
    #[getter]
    fn triangle_count(&self) -> usize {
        self.core.mesh().faces().len()
    }

    /// Parts, including those without triangles.
    #[getter]
    fn part_count(&self) -> usize {
        self.core.part_bounds().len()
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

pub(crate) fn bounds<'py>(py: Python<'py>, mesh: &core::Mesh) -> PyResult<Bound<'py, PyArray2<f64>>> {
    corners(py, &[mesh.bounds()])
}

/// The lower and the upper corner of each box, `(2 * boxes, 3)`, read-only.
pub(crate) fn corners<'py>(py: Python<'py>, boxes: &[core::Aabb]) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let corners: Vec<Vec<f64>> = boxes.iter().flat_map(|b| [b.lower.to_vec(), b.upper.to_vec()]).collect();
    Ok(read_only(PyArray2::from_vec2(py, &corners)?))
}

pub(crate) fn defects<'py>(py: Python<'py>, mesh: &core::Mesh) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    for kind in core::DefectKind::ALL {
        let defect = mesh.defects().of(*kind);
        dict.set_item(kind.name(), (defect.count, defect.first.clone()))?;
    }
    Ok(dict)
}
