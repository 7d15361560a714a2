//! The least gap along a motion.

use std::collections::HashMap;

use feeler_core as core;
use numpy::ndarray::Array2;
use numpy::{PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyTuple;

use crate::arrays::IntoReadOnly;
use crate::old_names::old_attribute;
use crate::proximity::Distance;
use crate::travel::{damaged, list, reduced, rows_of};

/// The least gap of a tool along a motion, between proven bounds.
#[pyclass(frozen, module = "feeler._core")]
pub struct ClearanceAlong {
    /// Lower, upper, share.
    bounds: [f64; 3],
    pose: [[f64; 4]; 4],
    gap: Option<core::Gap>,
    /// From, to, lower, upper.
    spans: Vec<[f64; 4]>,
}

impl ClearanceAlong {
    pub fn new(core: core::LeastGap) -> ClearanceAlong {
        let core::LeastGap { lower, upper, share, pose, gap, spans, .. } = core;
        let spans = spans.iter().map(|span| [span.from, span.to, span.lower, span.upper]).collect();
        ClearanceAlong { bounds: [lower, upper, share], pose: pose.matrix(), gap, spans }
    }

    pub fn restore(state: &Bound<'_, PyTuple>) -> PyResult<ClearanceAlong> {
        type State<'py> =
            (PyReadonlyArray1<'py, f64>, PyReadonlyArray2<'py, f64>, PyRef<'py, Distance>, PyReadonlyArray2<'py, f64>);
        let (bounds, pose, distance, spans): State<'_> = state.extract()?;
        let bounds = list(&bounds).try_into().map_err(|_| damaged("its bounds are not three numbers"))?;
        let pose = rows_of(&pose)?.try_into().map_err(|_| damaged("its pose has not four rows"))?;
        Ok(ClearanceAlong { bounds, pose, gap: distance.gap(), spans: rows_of(&spans)? })
    }

    fn column<'py>(&self, py: Python<'py>, of: impl Fn(&[f64; 4]) -> f64) -> Bound<'py, PyArray1<f64>> {
        self.spans.iter().map(of).collect::<Vec<f64>>().into_read_only(py)
    }
}

#[pymethods]
impl ClearanceAlong {
    /// Metres: nowhere on the motion is the gap less.
    #[getter]
    fn lower(&self) -> f64 {
        self.bounds[0]
    }

    /// Metres: the gap at `fraction`; 0 if they collide there, infinite if no part is within `within`.
    #[getter]
    fn upper(&self) -> f64 {
        self.bounds[1]
    }

    /// The place of `upper`, as a fraction of the motion, 0 to 1.
    #[getter]
    fn fraction(&self) -> f64 {
        self.bounds[2]
    }

    /// `(4, 4)`: world_from_tool at `fraction`.
    #[getter]
    fn pose<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        Array2::from_shape_fn((4, 4), |(i, j)| self.pose[i][j]).into_read_only(py)
    }

    /// The index into `mockup.parts` of the closest part at `fraction`; None if no part is within `within`.
    #[getter]
    fn part(&self) -> Option<u32> {
        self.gap.map(|gap| gap.part)
    }

    /// The index into `tool.parts` of the tool's part that is closest to it.
    #[getter]
    fn tool_part(&self) -> Option<u32> {
        self.gap.map(|gap| gap.tool_part)
    }

    /// `(2, 3)`: the closest points at `fraction`, of the tool and of the mock-up, world, metres.
    #[getter]
    fn points<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray2<f64>>> {
        let gap = self.gap?;
        Some(Array2::from_shape_fn((2, 3), |(i, a)| [gap.on_tool, gap.on_mockup][i][a]).into_read_only(py))
    }

    /// `(n + 1,)`: where the spans of the curve begin and end, as fractions of the motion.
    #[getter]
    fn edges<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let first = self.spans.first().map_or(0.0, |span| span[0]);
        std::iter::once(first).chain(self.spans.iter().map(|span| span[1])).collect::<Vec<f64>>().into_read_only(py)
    }

    /// `(n,)`: the middles of the spans of the curve, as fractions of the motion.
    #[getter]
    fn fractions<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.column(py, |span| 0.5 * (span[0] + span[1]))
    }

    /// `(n,)`: metres; nowhere in the span is the gap less.
    #[getter]
    fn lowers<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.column(py, |span| span[2])
    }

    /// `(n,)`: metres; in the middle of the span the gap is not more.
    #[getter]
    fn uppers<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.column(py, |span| span[3])
    }

    fn __repr__(&self) -> String {
        format!("ClearanceAlong({:?} to {:?} m at {:?})", self.bounds[0], self.bounds[1], self.bounds[2])
    }

    #[classattr]
    #[pyo3(name = "_RENAMED")]
    fn renamed() -> HashMap<&'static str, &'static str> {
        HashMap::from([("share", "fraction"), ("shares", "fractions")])
    }

    fn __getattr__<'py>(slf: &Bound<'py, Self>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        old_attribute(slf, name)
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let spans = Array2::from_shape_fn((self.spans.len(), 4), |(n, i)| self.spans[n][i]).into_read_only(py);
        let bounds = self.bounds.to_vec().into_read_only(py);
        reduced(py, "ClearanceAlong", (bounds, self.pose(py), Bound::new(py, Distance::new(self.gap))?, spans))
    }
}
