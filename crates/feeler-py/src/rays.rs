//! `feeler._core.Rays` and `SectionOutline`: queries without a tool.

use feeler_core as core;
use numpy::ndarray::Array2;
use numpy::{PyArray1, PyArray2, PyArray3, PyReadonlyArray1, PyReadonlyArray2, PyReadonlyArray3};
use pyo3::prelude::*;
use pyo3::types::{PyIterator, PyTuple};

use crate::arrays::{at, in_order, view, view_blocks, Index, IntoReadOnly};
use crate::proximity::points;
use crate::travel::{check_lengths, list, reduced, rows_of};
use crate::words::counted;

/// The first hit of each of many rays; `rays[i]` is the `RayHit` of ray `i`, None without a hit.
#[pyclass(frozen, module = "feeler._core")]
pub struct Rays {
    hits: Vec<Option<core::RayHit>>,
}

impl Rays {
    pub fn new(hits: Vec<Option<core::RayHit>>) -> Rays {
        Rays { hits }
    }

    pub fn restore(state: &Bound<'_, PyTuple>) -> PyResult<Rays> {
        type State<'py> = (PyReadonlyArray1<'py, bool>, PyReadonlyArray2<'py, u32>, PyReadonlyArray2<'py, f64>);
        let (met, ids, numbers): State<'_> = state.extract()?;
        let (met, ids, numbers) = (list(&met), rows_of::<u32, 2>(&ids)?, rows_of::<f64, 7>(&numbers)?);
        check_lengths("rows of ids", ids.len(), met.iter().filter(|met| **met).count())?;
        check_lengths("rows of numbers", numbers.len(), ids.len())?;
        let mut found = ids.iter().zip(&numbers).map(|([triangle, part], n)| core::RayHit {
            distance: n[0],
            point: [n[1], n[2], n[3]],
            normal: [n[4], n[5], n[6]],
            triangle: *triangle,
            part: *part,
        });
        Ok(Rays { hits: met.iter().map(|met| if *met { found.next() } else { None }).collect() })
    }

    fn ids<'py>(&self, py: Python<'py>, id: fn(&core::RayHit) -> u32) -> Bound<'py, PyArray1<i64>> {
        let ids: Vec<i64> = self.hits.iter().map(|hit| hit.as_ref().map_or(-1, |hit| id(hit).into())).collect();
        ids.into_read_only(py)
    }
}

#[pymethods]
impl Rays {
    /// `(n,)`: from the origin, metres; infinite without a hit.
    #[getter]
    fn distances<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let distances: Vec<f64> = self.hits.iter().map(|hit| hit.map_or(f64::INFINITY, |hit| hit.distance)).collect();
        distances.into_read_only(py)
    }

    /// `(n, 3)`: the hit, world, metres; NaN without a hit.
    #[getter]
    fn points<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        points(py, self.hits.iter().map(|hit| hit.map_or([f64::NAN; 3], |hit| hit.point)))
    }

    /// `(n, 3)`: of the triangle, unit, world, turned against the ray; if the ray lies in the triangle's plane, as
    /// the triangle is wound; NaN without a hit.
    #[getter]
    fn normals<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        points(py, self.hits.iter().map(|hit| hit.map_or([f64::NAN; 3], |hit| hit.normal)))
    }

    /// `(n,)`: -1 without a hit.
    #[getter]
    fn triangles<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i64>> {
        self.ids(py, |hit| hit.triangle)
    }

    /// `(n,)`: indices into `mockup.parts`; -1 without a hit.
    #[getter]
    fn parts<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<i64>> {
        self.ids(py, |hit| hit.part)
    }

    fn __len__(&self) -> usize {
        self.hits.len()
    }

    fn __iter__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyIterator>> {
        in_order(slf)
    }

    fn __getitem__<'py>(&self, py: Python<'py>, index: Index<'py>) -> PyResult<Bound<'py, PyAny>> {
        let class = py.import("feeler.rows")?.getattr("RayHit")?;
        at(py, &index, (self.hits.len(), "ray"), |i| {
            let row = |hit: core::RayHit| {
                let vector = |v: core::Point| v.to_vec().into_read_only(py);
                class.call1((hit.distance, vector(hit.point), vector(hit.normal), hit.triangle, hit.part))
            };
            self.hits[i].map(row).transpose()
        })
    }

    fn __repr__(&self) -> String {
        format!("Rays({}, {} hit)", counted(self.hits.len(), "ray"), self.hits.iter().flatten().count())
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let met = self.hits.iter().map(Option::is_some).collect::<Vec<bool>>().into_read_only(py);
        let found: Vec<&core::RayHit> = self.hits.iter().flatten().collect();
        let ids = Array2::from_shape_fn((found.len(), 2), |(n, i)| [found[n].triangle, found[n].part][i]);
        let numbers = Array2::from_shape_fn((found.len(), 7), |(n, i)| match i {
            0 => found[n].distance,
            1..4 => found[n].point[i - 1],
            _ => found[n].normal[i - 4],
        });
        reduced(py, "Rays", (met, ids.into_read_only(py), numbers.into_read_only(py)))
    }
}

/// The segments of all triangles that a plane cuts, sorted by triangle. Arrays are read-only.
///
/// `outline[i]` is segment `i`, `(2, 3)`.
#[pyclass(frozen, module = "feeler._core")]
pub struct SectionOutline {
    segments: Vec<[core::Point; 2]>,
    triangles: Vec<u32>,
    parts: Vec<u32>,
}

impl SectionOutline {
    pub fn new(outline: core::SectionOutline) -> SectionOutline {
        SectionOutline { segments: outline.segments, triangles: outline.triangles, parts: outline.parts }
    }

    pub fn restore(state: &Bound<'_, PyTuple>) -> PyResult<SectionOutline> {
        type State<'py> = (PyReadonlyArray3<'py, f64>, PyReadonlyArray1<'py, u32>, PyReadonlyArray1<'py, u32>);
        let (segments, triangles, parts): State<'_> = state.extract()?;
        let view = segments.as_array();
        check_lengths("ends a segment", view.shape()[1], 2)?;
        check_lengths("numbers an end", view.shape()[2], 3)?;
        let end = |n: usize, i: usize| std::array::from_fn(|a| view[[n, i, a]]);
        let segments: Vec<[core::Point; 2]> = (0..view.shape()[0]).map(|n| [end(n, 0), end(n, 1)]).collect();
        let (triangles, parts) = (list(&triangles), list(&parts));
        check_lengths("triangles", triangles.len(), segments.len())?;
        check_lengths("parts", parts.len(), segments.len())?;
        Ok(SectionOutline { segments, triangles, parts })
    }
}

#[pymethods]
impl SectionOutline {
    /// `(k, 2, 3)`: both ends, world, metres. Seen from the side that the plane's normal points to, the body is on
    /// the left if triangles are wound outwards. Segments of triangles that share an edge share its point exactly.
    #[getter]
    fn segments<'py>(slf: &Bound<'py, Self>) -> Bound<'py, PyArray3<f64>> {
        // SAFETY: the outline is frozen and owns its segments; the array keeps it alive.
        unsafe { view_blocks(slf.as_any(), &slf.get().segments) }
    }

    /// `(k,)`: the triangle of each segment; ascending.
    #[getter]
    fn triangles<'py>(slf: &Bound<'py, Self>) -> Bound<'py, PyArray1<u32>> {
        // SAFETY: as for the segments.
        unsafe { view(slf.as_any(), &slf.get().triangles) }
    }

    /// `(k,)`: indices into `mockup.parts`.
    #[getter]
    fn parts<'py>(slf: &Bound<'py, Self>) -> Bound<'py, PyArray1<u32>> {
        // SAFETY: as for the segments.
        unsafe { view(slf.as_any(), &slf.get().parts) }
    }

    fn __len__(&self) -> usize {
        self.segments.len()
    }

    fn __iter__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyIterator>> {
        in_order(slf)
    }

    fn __getitem__<'py>(slf: &Bound<'py, Self>, index: Index<'py>) -> PyResult<Bound<'py, PyAny>> {
        let segments = Self::segments(slf);
        at(slf.py(), &index, (slf.get().segments.len(), "segment"), |i| segments.get_item(i))
    }

    fn __repr__(&self) -> String {
        format!("SectionOutline({})", counted(self.segments.len(), "segment"))
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        reduced(slf.py(), "SectionOutline", (Self::segments(slf), Self::triangles(slf), Self::parts(slf)))
    }
}
