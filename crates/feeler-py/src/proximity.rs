//! Distances and clearances.

use feeler_core as core;
use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray1, PyArray2};
use pyo3::prelude::*;

/// Points as `(n, 3)`.
fn points<'py>(py: Python<'py>, rows: impl ExactSizeIterator<Item = core::Point>) -> Bound<'py, PyArray2<f64>> {
    let count = rows.len();
    let flat: Vec<f64> = rows.flatten().collect();
    Array2::from_shape_vec((count, 3), flat).expect("three numbers a row").into_pyarray(py)
}

/// The minimum distance at one pose, or that of a part.
#[pyclass(frozen, module = "feeler._core")]
pub struct Distance {
    gap: Option<core::Gap>,
}

impl Distance {
    pub fn new(gap: Option<core::Gap>) -> Distance {
        Distance { gap }
    }
}

#[pymethods]
impl Distance {
    #[getter]
    fn value(&self) -> f64 {
        self.gap.map_or(f64::INFINITY, |gap| gap.distance)
    }

    #[getter]
    fn point_on_tool<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<f64>>> {
        self.gap.map(|gap| gap.on_tool.to_vec().into_pyarray(py))
    }

    #[getter]
    fn point_on_mockup<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<f64>>> {
        self.gap.map(|gap| gap.on_mockup.to_vec().into_pyarray(py))
    }

    #[getter]
    fn tool_triangle(&self) -> Option<u32> {
        self.gap.map(|gap| gap.tool_triangle)
    }

    #[getter]
    fn mockup_triangle(&self) -> Option<u32> {
        self.gap.map(|gap| gap.mockup_triangle)
    }

    #[getter]
    fn part(&self) -> Option<u32> {
        self.gap.map(|gap| gap.part)
    }

    fn __repr__(&self) -> String {
        match self.gap {
            None => "Distance(inf)".into(),
            Some(gap) => format!("Distance({:?} m, part {})", gap.distance, gap.part),
        }
    }
}

/// The minimum distance at each of many poses.
#[pyclass(frozen, module = "feeler._core")]
pub struct DistanceBatch {
    gaps: Vec<Option<core::Gap>>,
}

impl DistanceBatch {
    pub fn new(gaps: Vec<Option<core::Gap>>) -> DistanceBatch {
        DistanceBatch { gaps }
    }

    fn ids<'py>(&self, py: Python<'py>, id: fn(&core::Gap) -> u32) -> Bound<'py, PyArray1<i64>> {
        let ids: Vec<i64> = self.gaps.iter().map(|gap| gap.as_ref().map_or(-1, |gap| id(gap).into())).collect();
        ids.into_pyarray(py)
    }
}

#[pymethods]
impl DistanceBatch {
    #[getter]
    fn values<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let values: Vec<f64> = self.gaps.iter().map(|gap| gap.map_or(f64::INFINITY, |gap| gap.distance)).collect();
        values.into_pyarray(py)
    }

    #[getter]
    fn points_on_tool<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        points(py, self.gaps.iter().map(|gap| gap.map_or([f64::NAN; 3], |gap| gap.on_tool)))
    }

    #[getter]
    fn points_on_mockup<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        points(py, self.gaps.iter().map(|gap| gap.map_or([f64::NAN; 3], |gap| gap.on_mockup)))
    }

    #[getter]
    fn tool_triangles<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i64>> {
        self.ids(py, |gap| gap.tool_triangle)
    }

    #[getter]
    fn mockup_triangles<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i64>> {
        self.ids(py, |gap| gap.mockup_triangle)
    }

    #[getter]
    fn parts<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i64>> {
        self.ids(py, |gap| gap.part)
    }

    fn __len__(&self) -> usize {
        self.gaps.len()
    }

    fn __getitem__(&self, index: isize) -> PyResult<Distance> {
        Ok(Distance::new(self.gaps[place(index, self.gaps.len())?]))
    }

    fn __repr__(&self) -> String {
        format!("DistanceBatch({} poses)", self.gaps.len())
    }
}

/// What is near at one pose: a row a part, or a row a pair of triangles.
#[pyclass(frozen, module = "feeler._core")]
pub struct Clearance {
    gaps: Vec<core::Gap>,
}

impl Clearance {
    pub fn new(gaps: Vec<core::Gap>) -> Clearance {
        Clearance { gaps }
    }

    fn ids<'py>(&self, py: Python<'py>, id: fn(&core::Gap) -> u32) -> Bound<'py, PyArray1<u32>> {
        self.gaps.iter().map(id).collect::<Vec<u32>>().into_pyarray(py)
    }
}

#[pymethods]
impl Clearance {
    #[getter]
    fn parts<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        self.ids(py, |gap| gap.part)
    }

    #[getter]
    fn distances<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.gaps.iter().map(|gap| gap.distance).collect::<Vec<f64>>().into_pyarray(py)
    }

    #[getter]
    fn points_on_tool<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        points(py, self.gaps.iter().map(|gap| gap.on_tool))
    }

    #[getter]
    fn points_on_mockup<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        points(py, self.gaps.iter().map(|gap| gap.on_mockup))
    }

    #[getter]
    fn tool_triangles<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        self.ids(py, |gap| gap.tool_triangle)
    }

    #[getter]
    fn mockup_triangles<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        self.ids(py, |gap| gap.mockup_triangle)
    }

    fn __len__(&self) -> usize {
        self.gaps.len()
    }

    fn __repr__(&self) -> String {
        match self.gaps.first() {
            None => "Clearance(nothing near)".into(),
            Some(gap) => format!("Clearance({} rows, least {:?} m)", self.gaps.len(), gap.distance),
        }
    }
}

/// What is near at each of many poses.
#[pyclass(frozen, module = "feeler._core")]
pub struct ClearanceBatch {
    offsets: Vec<u64>,
    all: Clearance,
}

impl ClearanceBatch {
    pub fn new(batch: core::GapBatch) -> ClearanceBatch {
        ClearanceBatch { offsets: batch.offsets, all: Clearance::new(batch.gaps) }
    }
}

#[pymethods]
impl ClearanceBatch {
    #[getter]
    fn offsets<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u64>> {
        self.offsets.clone().into_pyarray(py)
    }

    #[getter]
    fn parts<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        self.all.parts(py)
    }

    #[getter]
    fn distances<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.all.distances(py)
    }

    #[getter]
    fn points_on_tool<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        self.all.points_on_tool(py)
    }

    #[getter]
    fn points_on_mockup<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        self.all.points_on_mockup(py)
    }

    #[getter]
    fn tool_triangles<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        self.all.tool_triangles(py)
    }

    #[getter]
    fn mockup_triangles<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        self.all.mockup_triangles(py)
    }

    fn __len__(&self) -> usize {
        self.offsets.len() - 1
    }

    fn __getitem__(&self, index: isize) -> PyResult<Clearance> {
        let i = place(index, self.__len__())?;
        Ok(Clearance::new(self.all.gaps[self.offsets[i] as usize..self.offsets[i + 1] as usize].to_vec()))
    }

    fn __repr__(&self) -> String {
        format!("ClearanceBatch({} poses, {} rows)", self.__len__(), self.all.gaps.len())
    }
}

/// A place in a sequence, counted from the end where negative.
fn place(index: isize, count: usize) -> PyResult<usize> {
    let i = if index < 0 { index + count as isize } else { index };
    if (0..count as isize).contains(&i) {
        return Ok(i as usize);
    }
    Err(pyo3::exceptions::PyIndexError::new_err(format!("pose {index} of {count}")))
}
