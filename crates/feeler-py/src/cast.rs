//! Results of continuous queries.

use std::sync::Arc;

use feeler_core as core;
use numpy::ndarray::{Array2, Array3};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArray3};
use pyo3::prelude::*;

/// The first impact of a tool on its way.
#[pyclass(frozen, module = "feeler._core")]
pub struct Cast {
    core: core::Cast,
    part: u32,
}

impl Cast {
    pub fn new(core: core::Cast, mockup: &core::Mockup) -> Cast {
        Cast { part: mockup.part_of_face(core.mockup_triangle), core }
    }
}

#[pymethods]
impl Cast {
    #[getter]
    fn fraction(&self) -> f64 {
        self.core.fraction
    }

    #[getter]
    fn pose<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        let m = self.core.pose.matrix();
        Array2::from_shape_fn((4, 4), |(i, j)| m[i][j]).into_pyarray(py)
    }

    #[getter]
    fn point<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.core.point.to_vec().into_pyarray(py)
    }

    #[getter]
    fn normal<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.core.normal.to_vec().into_pyarray(py)
    }

    #[getter]
    fn distance(&self) -> f64 {
        self.core.distance
    }

    #[getter]
    fn tool_triangle(&self) -> u32 {
        self.core.tool_triangle
    }

    #[getter]
    fn mockup_triangle(&self) -> u32 {
        self.core.mockup_triangle
    }

    #[getter]
    fn part(&self) -> u32 {
        self.part
    }

    fn __repr__(&self) -> String {
        format!("Cast(fraction={:?}, part={})", self.core.fraction, self.part)
    }
}

/// What a path meets, segment by segment.
#[pyclass(frozen, module = "feeler._core")]
pub struct PathCheck {
    core: core::PathCheck,
    mockup: Arc<core::Mockup>,
}

impl PathCheck {
    pub fn new(core: core::PathCheck, mockup: Arc<core::Mockup>) -> PathCheck {
        PathCheck { core, mockup }
    }

    fn points_of<'py>(&self, py: Python<'py>, of: impl Fn(&core::Cast) -> core::Point) -> Bound<'py, PyArray2<f64>> {
        let hits = &self.core.hits;
        Array2::from_shape_fn((hits.len(), 3), |(i, a)| of(&hits[i].1)[a]).into_pyarray(py)
    }

    fn column<'py, T: numpy::Element>(
        &self,
        py: Python<'py>,
        of: impl Fn(&(usize, core::Cast)) -> T,
    ) -> Bound<'py, PyArray1<T>> {
        self.core.hits.iter().map(of).collect::<Vec<T>>().into_pyarray(py)
    }
}

#[pymethods]
impl PathCheck {
    #[getter]
    fn free(&self) -> bool {
        self.core.hits.is_empty()
    }

    #[getter]
    fn fraction<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let mut fraction = vec![f64::NAN; self.core.segments];
        self.core.hits.iter().for_each(|(segment, cast)| fraction[*segment] = cast.fraction);
        fraction.into_pyarray(py)
    }

    #[getter]
    fn segments<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u64>> {
        self.column(py, |(segment, _)| *segment as u64)
    }

    #[getter]
    fn poses<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray3<f64>> {
        let matrices: Vec<[[f64; 4]; 4]> = self.core.hits.iter().map(|(_, cast)| cast.pose.matrix()).collect();
        Array3::from_shape_fn((matrices.len(), 4, 4), |(n, i, j)| matrices[n][i][j]).into_pyarray(py)
    }

    #[getter]
    fn points<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        self.points_of(py, |cast| cast.point)
    }

    #[getter]
    fn normals<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        self.points_of(py, |cast| cast.normal)
    }

    #[getter]
    fn tool_triangles<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        self.column(py, |(_, cast)| cast.tool_triangle)
    }

    #[getter]
    fn mockup_triangles<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        self.column(py, |(_, cast)| cast.mockup_triangle)
    }

    #[getter]
    fn parts<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        self.column(py, |(_, cast)| self.mockup.part_of_face(cast.mockup_triangle))
    }

    #[getter]
    fn first(&self) -> Option<Cast> {
        self.core.hits.first().map(|(_, cast)| Cast::new(*cast, &self.mockup))
    }

    fn __len__(&self) -> usize {
        self.core.segments
    }

    fn __repr__(&self) -> String {
        format!("PathCheck({} segments, {} hit)", self.core.segments, self.core.hits.len())
    }
}
