//! Screws and legs of ways.

use feeler_core as core;
use numpy::{PyArray2, PyReadonlyArray1};
use pyo3::prelude::*;
use pyo3::types::PyTuple;

use crate::arguments::PoseArgument;
use crate::errors::{raise, to_py};
use crate::scene::pose_array;

/// A turn about an axis in the world with an advance along it.
#[pyclass(frozen, module = "feeler._core")]
pub struct Screw {
    pub core: core::Screw,
}

/// Three numbers, of anything that NumPy reads so.
fn vector(what: &str, object: &Bound<'_, PyAny>) -> PyResult<core::Point> {
    let wrong = || raise("OptionError", format!("{what} of the screw is {object}: give three numbers"));
    let py = object.py();
    let array = py.import("numpy")?.call_method1("asarray", (object, "float64")).map_err(|_| wrong())?;
    let array: PyReadonlyArray1<'_, f64> = array.extract().map_err(|_| wrong())?;
    match array.as_array().to_vec()[..] {
        [x, y, z] => Ok([x, y, z]),
        _ => Err(wrong()),
    }
}

fn number(what: &str, object: &Bound<'_, PyAny>) -> PyResult<f64> {
    object.extract().map_err(|_| raise("OptionError", format!("{what} of the screw is {object}: give a number")))
}

#[pymethods]
impl Screw {
    #[new]
    #[pyo3(signature = (axis, point, angle, pitch = None))]
    fn new(
        axis: &Bound<'_, PyAny>,
        point: &Bound<'_, PyAny>,
        angle: &Bound<'_, PyAny>,
        pitch: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Screw> {
        let (axis, point, angle) = (vector("axis", axis)?, vector("point", point)?, number("angle", angle)?);
        let pitch = pitch.map_or(Ok(0.0), |pitch| number("pitch", pitch))?;
        Ok(Screw { core: core::Screw::new(&axis, &point, angle, pitch).map_err(to_py)? })
    }

    #[getter]
    fn axis(&self) -> (f64, f64, f64) {
        (*self.core.axis()).into()
    }

    #[getter]
    fn point(&self) -> (f64, f64, f64) {
        (*self.core.point()).into()
    }

    #[getter]
    fn angle(&self) -> f64 {
        self.core.angle()
    }

    #[getter]
    fn pitch(&self) -> f64 {
        self.core.pitch()
    }

    #[getter]
    fn advance(&self) -> f64 {
        self.core.advance()
    }

    fn reversed(&self) -> Screw {
        Screw { core: self.core.reversed() }
    }

    #[pyo3(signature = (pose, fraction = 1.0))]
    fn at<'py>(&self, py: Python<'py>, pose: PoseArgument, fraction: f64) -> PyResult<Bound<'py, PyArray2<f64>>> {
        Ok(pose_array(py, &self.core.at(&pose.0, fraction).map_err(to_py)?))
    }

    fn __eq__(&self, other: &Bound<'_, PyAny>) -> bool {
        other.cast::<Screw>().is_ok_and(|other| other.get().core == self.core)
    }

    fn __hash__(&self, py: Python<'_>) -> PyResult<isize> {
        self.state().into_pyobject(py)?.hash()
    }

    fn __repr__(&self) -> String {
        let ([x, y, z], [a, b, c]) = (self.core.axis(), self.core.point());
        format!(
            "Screw(axis=({x:?}, {y:?}, {z:?}), point=({a:?}, {b:?}, {c:?}), angle={:?}, pitch={:?})",
            self.angle(),
            self.pitch()
        )
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyTuple>> {
        (slf.get_type(), slf.get().state()).into_pyobject(slf.py())
    }
}

type Three = (f64, f64, f64);

impl Screw {
    fn state(&self) -> (Three, Three, f64, f64) {
        (self.axis(), self.point(), self.angle(), self.pitch())
    }
}

/// A leg: a screw, or a pose to go to.
pub struct LegArgument(pub core::Leg);

impl<'a, 'py> FromPyObject<'a, 'py> for LegArgument {
    type Error = PyErr;

    fn extract(object: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        match object.cast::<Screw>() {
            Ok(screw) => Ok(LegArgument(core::Leg::Screw(screw.get().core))),
            Err(_) => Ok(LegArgument(core::Leg::To(object.extract::<PoseArgument>()?.0))),
        }
    }
}
