//! `feeler._core.Containment`.

use feeler_contacts as contacts;
use numpy::ndarray::Array2;
use numpy::{PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyTuple;

use crate::arrays::IntoReadOnly;
use crate::travel::{list, reduced, rows_of};

/// Bodies inside other bodies, without colliding; true if there is any.
#[pyclass(frozen, module = "feeler._core")]
#[derive(Clone)]
pub struct Containment {
    containing: Vec<[u32; 2]>,
    contained: Vec<[u32; 2]>,
    unknown: Vec<u32>,
}

fn parts<'py>(py: Python<'py>, pairs: &[[u32; 2]]) -> Bound<'py, PyArray1<u32>> {
    let mut parts: Vec<u32> = pairs.iter().map(|[_, part]| *part).collect();
    parts.sort_unstable();
    parts.dedup();
    parts.into_read_only(py)
}

fn rows<'py>(py: Python<'py>, pairs: &[[u32; 2]]) -> Bound<'py, PyArray2<u32>> {
    Array2::from_shape_fn((pairs.len(), 2), |(n, i)| pairs[n][i]).into_read_only(py)
}

impl Containment {
    pub fn new(found: contacts::Containment) -> Containment {
        Containment { containing: found.containing, contained: found.contained, unknown: found.unknown }
    }

    pub fn is_any(&self) -> bool {
        !self.containing.is_empty() || !self.contained.is_empty()
    }

    pub fn restore(state: &Bound<'_, PyTuple>) -> PyResult<Containment> {
        type State<'py> = (PyReadonlyArray2<'py, u32>, PyReadonlyArray2<'py, u32>, PyReadonlyArray1<'py, u32>);
        let (containing, contained, unknown): State<'_> = state.extract()?;
        Ok(Containment { containing: rows_of(&containing)?, contained: rows_of(&contained)?, unknown: list(&unknown) })
    }
}

#[pymethods]
impl Containment {
    /// Indices into `mockup.parts` of closed parts that contain the tool, or one of its connected surfaces;
    /// sorted.
    #[getter]
    fn containing<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        parts(py, &self.containing)
    }

    /// Indices into `mockup.parts` of parts with a connected surface inside the tool; sorted.
    #[getter]
    fn contained<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        parts(py, &self.contained)
    }

    /// `(k, 2)`: tool part inside, and the mock-up part that contains it; sorted.
    #[getter]
    fn containing_pairs<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<u32>> {
        rows(py, &self.containing)
    }

    /// `(k, 2)`: tool part that contains, and the mock-up part inside it; sorted.
    #[getter]
    fn contained_pairs<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<u32>> {
        rows(py, &self.contained)
    }

    /// Parts that cannot be decided, sorted: open parts with a corner of the tool in their box and, if the tool is
    /// open, parts with a corner in its box.
    #[getter]
    fn unknown<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        self.unknown.clone().into_read_only(py)
    }

    fn __bool__(&self) -> bool {
        self.is_any()
    }

    fn __repr__(&self) -> String {
        let Containment { containing, contained, unknown } = self;
        format!(
            "Containment({} containing, {} contained, {} unknown)",
            containing.len(),
            contained.len(),
            unknown.len()
        )
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        reduced(py, "Containment", (rows(py, &self.containing), rows(py, &self.contained), self.unknown(py)))
    }
}
