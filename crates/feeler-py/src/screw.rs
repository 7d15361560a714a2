//! Screws.

use feeler_core as core;
use numpy::{PyArray2, PyReadonlyArray1};
use pyo3::prelude::*;
use pyo3::types::PyTuple;

use crate::arguments::{checked, PoseArgument};
use crate::arrays::pose_array;
use crate::errors::{raise, to_py};

/// A rotation about an axis in the world with an advance along it: a door's swing, a bolt's thread, a bayonet.
///
/// `axis`: a direction, no number beyond 1e100; `point`: on the axis, metres; `angle`: radians, right-handed about
/// the axis, at most a thousand turns either way; `pitch`: metres along the axis for a whole turn, 0 for a hinge,
/// negative for a left-handed thread. Raises `OptionError` for an axis of zero and for numbers that are not finite or
/// too large.
#[pyclass(frozen, module = "feeler._core")]
pub struct Screw {
    pub core: core::Screw,
}

/// Three numbers, of anything that NumPy reads so.
pub fn vector(what: &str, object: &Bound<'_, PyAny>) -> PyResult<core::Point> {
    let wrong = || raise("OptionError", format!("{what} is {object}: give three numbers"));
    let py = object.py();
    py.import("feeler.arguments")?.call_method1("unmasked", (what, object))?;
    let array = py.import("numpy")?.call_method1("asarray", (object,)).map_err(|_| wrong())?;
    let kind: String = array.getattr("dtype")?.getattr("kind")?.extract()?;
    if !["f", "i", "u"].contains(&kind.as_str()) {
        return Err(wrong());
    }
    let array: PyReadonlyArray1<'_, f64> =
        array.call_method1("astype", ("float64",))?.extract().map_err(|_| wrong())?;
    match array.as_array().to_vec()[..] {
        [x, y, z] => Ok([x, y, z]),
        _ => Err(wrong()),
    }
}

fn number(what: &str, object: &Bound<'_, PyAny>) -> PyResult<f64> {
    checked(object.py(), "check_real", (format!("{what} of the screw"), object))
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
        let (given, axis) = (axis, vector("axis of the screw", axis)?);
        if axis == [0.0; 3] {
            return Err(raise(
                "OptionError",
                format!("axis of the screw is {given}: give a direction that is not zero"),
            ));
        }
        let (point, angle) = (vector("point of the screw", point)?, number("angle", angle)?);
        let pitch = pitch.map_or(Ok(0.0), |pitch| number("pitch", pitch))?;
        Ok(Screw { core: core::Screw::new(&axis, &point, angle, pitch).map_err(to_py)? })
    }

    /// Unit, world.
    #[getter]
    fn axis(&self) -> (f64, f64, f64) {
        (*self.core.axis()).into()
    }

    /// On the axis, metres, world.
    #[getter]
    fn point(&self) -> (f64, f64, f64) {
        (*self.core.point()).into()
    }

    /// Radians.
    #[getter]
    fn angle(&self) -> f64 {
        self.core.angle()
    }

    /// Metres along the axis for a whole turn.
    #[getter]
    fn pitch(&self) -> f64 {
        self.core.pitch()
    }

    /// Metres along the axis for the whole angle.
    #[getter]
    fn advance(&self) -> f64 {
        self.core.advance()
    }

    /// The reverse motion.
    fn reversed(&self) -> Screw {
        Screw { core: self.core.reversed() }
    }

    /// `(4, 4)`: a pose moved by a fraction of the screw, 0 to 1. Raises `PoseError`, `OptionError`.
    #[pyo3(signature = (pose, fraction = Fraction(1.0)), text_signature = "($self, pose, fraction=1.0)")]
    fn at<'py>(&self, py: Python<'py>, pose: PoseArgument, fraction: Fraction) -> PyResult<Bound<'py, PyArray2<f64>>> {
        Ok(pose_array(py, &self.core.at(&pose.0, fraction.0).map_err(to_py)?))
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

pub type Three = (f64, f64, f64);

impl Screw {
    fn state(&self) -> (Three, Three, f64, f64) {
        (self.axis(), self.point(), self.angle(), self.pitch())
    }
}

/// A share of a motion.
pub struct Fraction(pub f64);

impl<'a, 'py> FromPyObject<'a, 'py> for Fraction {
    type Error = PyErr;

    fn extract(object: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        checked(object.py(), "check_fraction", ("fraction", object)).map(Fraction)
    }
}
