//! Distances and clearances.

use feeler_core as core;
use numpy::ndarray::Array2;
use numpy::{PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::{PyIterator, PyTuple};

use crate::arrays::{at, in_order, Index, IntoReadOnly};
use crate::travel::{check_lengths, check_offsets, damaged, list, reduced, rows_of};
use crate::words::counted;

/// Points as `(n, 3)`.
pub fn points<'py>(py: Python<'py>, rows: impl ExactSizeIterator<Item = core::Point>) -> Bound<'py, PyArray2<f64>> {
    let count = rows.len();
    let flat: Vec<f64> = rows.flatten().collect();
    Array2::from_shape_vec((count, 3), flat).expect("three numbers a row").into_read_only(py)
}

/// A row of ids and one of numbers for each gap.
type Rows<'py> = (Bound<'py, PyArray2<u32>>, Bound<'py, PyArray2<f64>>);

fn rows_for<'py>(py: Python<'py>, gaps: &[core::Gap]) -> Rows<'py> {
    let ids = |gap: &core::Gap| [gap.tool_triangle, gap.mockup_triangle, gap.tool_part, gap.part];
    let ids = Array2::from_shape_fn((gaps.len(), 4), |(n, i)| ids(&gaps[n])[i]);
    let numbers = Array2::from_shape_fn((gaps.len(), 7), |(n, i)| match i {
        0 => gaps[n].distance,
        1..4 => gaps[n].on_tool[i - 1],
        _ => gaps[n].on_mockup[i - 4],
    });
    (ids.into_read_only(py), numbers.into_read_only(py))
}

fn gaps_of(ids: &PyReadonlyArray2<'_, u32>, numbers: &PyReadonlyArray2<'_, f64>) -> PyResult<Vec<core::Gap>> {
    let (ids, numbers) = (rows_of::<u32, 4>(ids)?, rows_of::<f64, 7>(numbers)?);
    check_lengths("rows of ids", ids.len(), numbers.len())?;
    let gap = |(ids, numbers): (&[u32; 4], &[f64; 7])| core::Gap {
        tool_triangle: ids[0],
        mockup_triangle: ids[1],
        tool_part: ids[2],
        part: ids[3],
        distance: numbers[0],
        on_tool: std::array::from_fn(|a| numbers[1 + a]),
        on_mockup: std::array::from_fn(|a| numbers[4 + a]),
    };
    Ok(ids.iter().zip(&numbers).map(gap).collect())
}

/// The distance of tool and mock-up, or of the tool and one part; 0 if they collide.
///
/// If no part is within `within`, `value` is infinite and all else is None.
#[pyclass(frozen, module = "feeler._core")]
pub struct Distance {
    gap: Option<core::Gap>,
}

impl Distance {
    pub fn new(gap: Option<core::Gap>) -> Distance {
        Distance { gap }
    }

    pub fn gap(&self) -> Option<core::Gap> {
        self.gap
    }

    pub fn restore(state: &Bound<'_, PyTuple>) -> PyResult<Distance> {
        let (ids, numbers): (PyReadonlyArray2<'_, u32>, PyReadonlyArray2<'_, f64>) = state.extract()?;
        match gaps_of(&ids, &numbers)?[..] {
            [] => Ok(Distance { gap: None }),
            [gap] => Ok(Distance { gap: Some(gap) }),
            _ => Err(damaged("it is more than one distance")),
        }
    }
}

#[pymethods]
impl Distance {
    /// Metres; 0 if and only if triangles collide, infinite if no part is within `within`.
    #[getter]
    fn value(&self) -> f64 {
        self.gap.map_or(f64::INFINITY, |gap| gap.distance)
    }

    /// `(3,)`: the closest point of the tool, world, metres.
    #[getter]
    fn point_on_tool<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<f64>>> {
        self.gap.map(|gap| gap.on_tool.to_vec().into_read_only(py))
    }

    /// `(3,)`: the closest point of the mock-up, world, metres; the same point if they collide.
    #[getter]
    fn point_on_mockup<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<f64>>> {
        self.gap.map(|gap| gap.on_mockup.to_vec().into_read_only(py))
    }

    /// The tool's triangle that the point lies on.
    #[getter]
    fn tool_triangle(&self) -> Option<u32> {
        self.gap.map(|gap| gap.tool_triangle)
    }

    /// The mock-up's triangle that the point lies on.
    #[getter]
    fn mockup_triangle(&self) -> Option<u32> {
        self.gap.map(|gap| gap.mockup_triangle)
    }

    /// The index into `mockup.parts` of that triangle's part.
    #[getter]
    fn part(&self) -> Option<u32> {
        self.gap.map(|gap| gap.part)
    }

    /// The index into `tool.parts` of the tool's part that the point lies on.
    #[getter]
    fn tool_part(&self) -> Option<u32> {
        self.gap.map(|gap| gap.tool_part)
    }

    fn __repr__(&self) -> String {
        match self.gap {
            None => "Distance(inf)".into(),
            Some(gap) => format!("Distance({:?} m, part {})", gap.distance, gap.part),
        }
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        reduced(py, "Distance", rows_for(py, self.gap.as_slice()))
    }
}

/// The distance at many poses; `batch[i]` is the `Distance` of pose `i`.
///
/// Where no part is within `within`, the value is infinite, points are NaN and ids -1.
#[pyclass(frozen, module = "feeler._core")]
pub struct DistanceBatch {
    gaps: Vec<Option<core::Gap>>,
}

impl DistanceBatch {
    pub fn new(gaps: Vec<Option<core::Gap>>) -> DistanceBatch {
        DistanceBatch { gaps }
    }

    pub fn restore(state: &Bound<'_, PyTuple>) -> PyResult<DistanceBatch> {
        type State<'py> = (PyReadonlyArray1<'py, bool>, PyReadonlyArray2<'py, u32>, PyReadonlyArray2<'py, f64>);
        let (near, ids, numbers): State<'_> = state.extract()?;
        let (near, found) = (list(&near), gaps_of(&ids, &numbers)?);
        check_lengths("distances", found.len(), near.iter().filter(|near| **near).count())?;
        let mut found = found.into_iter();
        Ok(DistanceBatch { gaps: near.iter().map(|near| if *near { found.next() } else { None }).collect() })
    }

    fn ids<'py>(&self, py: Python<'py>, id: fn(&core::Gap) -> u32) -> Bound<'py, PyArray1<i64>> {
        let ids: Vec<i64> = self.gaps.iter().map(|gap| gap.as_ref().map_or(-1, |gap| id(gap).into())).collect();
        ids.into_read_only(py)
    }
}

#[pymethods]
impl DistanceBatch {
    /// `(n,)`: metres; 0 where they collide.
    #[getter]
    fn values<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let values: Vec<f64> = self.gaps.iter().map(|gap| gap.map_or(f64::INFINITY, |gap| gap.distance)).collect();
        values.into_read_only(py)
    }

    /// `(n, 3)`: world, metres.
    #[getter]
    fn points_on_tool<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        points(py, self.gaps.iter().map(|gap| gap.map_or([f64::NAN; 3], |gap| gap.on_tool)))
    }

    /// `(n, 3)`: world, metres.
    #[getter]
    fn points_on_mockup<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        points(py, self.gaps.iter().map(|gap| gap.map_or([f64::NAN; 3], |gap| gap.on_mockup)))
    }

    /// `(n,)`: the tool's triangle that the point lies on.
    #[getter]
    fn tool_triangles<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i64>> {
        self.ids(py, |gap| gap.tool_triangle)
    }

    /// `(n,)`: the mock-up's triangle that the point lies on.
    #[getter]
    fn mockup_triangles<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i64>> {
        self.ids(py, |gap| gap.mockup_triangle)
    }

    /// `(n,)`: indices into `mockup.parts`.
    #[getter]
    fn parts<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i64>> {
        self.ids(py, |gap| gap.part)
    }

    /// `(n,)`: indices into `tool.parts`.
    #[getter]
    fn tool_parts<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i64>> {
        self.ids(py, |gap| gap.tool_part)
    }

    fn __len__(&self) -> usize {
        self.gaps.len()
    }

    fn __iter__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyIterator>> {
        in_order(slf)
    }

    fn __getitem__<'py>(&self, py: Python<'py>, index: Index<'py>) -> PyResult<Bound<'py, PyAny>> {
        at(py, &index, (self.gaps.len(), "pose"), |i| Ok(Distance::new(self.gaps[i])))
    }

    fn __repr__(&self) -> String {
        format!("DistanceBatch({})", counted(self.gaps.len(), "pose"))
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let near = self.gaps.iter().map(Option::is_some).collect::<Vec<bool>>().into_read_only(py);
        let found: Vec<core::Gap> = self.gaps.iter().flatten().copied().collect();
        let (ids, numbers) = rows_for(py, &found);
        reduced(py, "DistanceBatch", (near, ids, numbers))
    }
}

/// Clearances at one pose: a row for each part, or for each pair of triangles; by distance, then by triangles.
///
/// `near[i]` is row `i`, a `Distance`.
#[pyclass(frozen, module = "feeler._core")]
pub struct Clearance {
    gaps: Vec<core::Gap>,
}

impl Clearance {
    pub fn new(gaps: Vec<core::Gap>) -> Clearance {
        Clearance { gaps }
    }

    pub fn restore(state: &Bound<'_, PyTuple>) -> PyResult<Clearance> {
        let (ids, numbers): (PyReadonlyArray2<'_, u32>, PyReadonlyArray2<'_, f64>) = state.extract()?;
        Ok(Clearance { gaps: gaps_of(&ids, &numbers)? })
    }

    fn ids<'py>(&self, py: Python<'py>, id: fn(&core::Gap) -> u32) -> Bound<'py, PyArray1<u32>> {
        self.gaps.iter().map(id).collect::<Vec<u32>>().into_read_only(py)
    }
}

#[pymethods]
impl Clearance {
    /// `(k,)`: indices into `mockup.parts`.
    #[getter]
    fn parts<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        self.ids(py, |gap| gap.part)
    }

    /// `(k,)`: indices into `tool.parts`.
    #[getter]
    fn tool_parts<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        self.ids(py, |gap| gap.tool_part)
    }

    /// `(k,)`: metres, ascending; 0 where they collide.
    #[getter]
    fn distances<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.gaps.iter().map(|gap| gap.distance).collect::<Vec<f64>>().into_read_only(py)
    }

    /// `(k, 3)`: the closest point of the tool, world, metres.
    #[getter]
    fn points_on_tool<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        points(py, self.gaps.iter().map(|gap| gap.on_tool))
    }

    /// `(k, 3)`: the closest point of the part or triangle, world, metres.
    #[getter]
    fn points_on_mockup<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        points(py, self.gaps.iter().map(|gap| gap.on_mockup))
    }

    /// `(k,)`: the tool's triangle that the point lies on.
    #[getter]
    fn tool_triangles<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        self.ids(py, |gap| gap.tool_triangle)
    }

    /// `(k,)`: the mock-up's triangle that the point lies on.
    #[getter]
    fn mockup_triangles<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        self.ids(py, |gap| gap.mockup_triangle)
    }

    fn __len__(&self) -> usize {
        self.gaps.len()
    }

    fn __iter__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyIterator>> {
        in_order(slf)
    }

    fn __getitem__<'py>(&self, py: Python<'py>, index: Index<'py>) -> PyResult<Bound<'py, PyAny>> {
        at(py, &index, (self.gaps.len(), "row"), |i| Ok(Distance::new(Some(self.gaps[i]))))
    }

    fn __repr__(&self) -> String {
        match self.gaps.first() {
            None => "Clearance(nothing near)".into(),
            Some(gap) => format!("Clearance({}, least {:?} m)", counted(self.gaps.len(), "row"), gap.distance),
        }
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        reduced(py, "Clearance", rows_for(py, &self.gaps))
    }
}

/// Clearances at many poses; `batch[i]` is the `Clearance` of pose `i`, its rows `offsets[i]:offsets[i + 1]`.
#[pyclass(frozen, module = "feeler._core")]
pub struct ClearanceBatch {
    offsets: Vec<u64>,
    all: Clearance,
}

impl ClearanceBatch {
    pub fn new(batch: core::GapBatch) -> ClearanceBatch {
        ClearanceBatch { offsets: batch.offsets, all: Clearance::new(batch.gaps) }
    }

    pub fn restore(state: &Bound<'_, PyTuple>) -> PyResult<ClearanceBatch> {
        type State<'py> = (PyReadonlyArray1<'py, u64>, PyReadonlyArray2<'py, u32>, PyReadonlyArray2<'py, f64>);
        let (offsets, ids, numbers): State<'_> = state.extract()?;
        let (offsets, gaps) = (list(&offsets), gaps_of(&ids, &numbers)?);
        check_offsets(&offsets, gaps.len())?;
        Ok(ClearanceBatch { offsets, all: Clearance { gaps } })
    }
}

#[pymethods]
impl ClearanceBatch {
    /// `(n + 1,)`: where the rows of each pose begin.
    #[getter]
    fn offsets<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u64>> {
        self.offsets.clone().into_read_only(py)
    }

    /// `(K,)`: as in `Clearance`, and so are the others.
    #[getter]
    fn parts<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        self.all.parts(py)
    }

    /// `(K,)`: parts of the tool.
    #[getter]
    fn tool_parts<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        self.all.tool_parts(py)
    }

    /// `(K,)`: metres.
    #[getter]
    fn distances<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.all.distances(py)
    }

    /// `(K, 3)`: world, metres.
    #[getter]
    fn points_on_tool<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        self.all.points_on_tool(py)
    }

    /// `(K, 3)`: world, metres.
    #[getter]
    fn points_on_mockup<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        self.all.points_on_mockup(py)
    }

    /// `(K,)`: triangles of the tool.
    #[getter]
    fn tool_triangles<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        self.all.tool_triangles(py)
    }

    /// `(K,)`: triangles of the mock-up.
    #[getter]
    fn mockup_triangles<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        self.all.mockup_triangles(py)
    }

    fn __len__(&self) -> usize {
        self.offsets.len() - 1
    }

    fn __iter__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyIterator>> {
        in_order(slf)
    }

    fn __getitem__<'py>(&self, py: Python<'py>, index: Index<'py>) -> PyResult<Bound<'py, PyAny>> {
        let rows = |i: usize| self.offsets[i] as usize..self.offsets[i + 1] as usize;
        at(py, &index, (self.__len__(), "pose"), |i| Ok(Clearance::new(self.all.gaps[rows(i)].to_vec())))
    }

    fn __repr__(&self) -> String {
        format!("ClearanceBatch({}, {})", counted(self.__len__(), "pose"), counted(self.all.gaps.len(), "row"))
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let (ids, numbers) = rows_for(py, &self.all.gaps);
        reduced(py, "ClearanceBatch", (self.offsets(py), ids, numbers))
    }
}
