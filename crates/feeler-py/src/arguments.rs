//! Python arguments: a tool, poses, switches. Invalid ones raise an exception of `feeler.errors` with the reason.

use feeler_core as core;
use numpy::ndarray::{ArrayView2, Ix2, Ix3};
use numpy::{PyArray, PyArrayMethods, PyReadonlyArray, PyUntypedArray, PyUntypedArrayMethods};
use pyo3::call::PyCallArgs;
use pyo3::exceptions::{PyRuntimeError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyList, PyTuple};

use crate::errors::{message, raise, shape_text, to_py};
use crate::tool::Tool;

/// A `feeler.Tool`.
pub struct ToolArgument<'a, 'py>(Borrowed<'a, 'py, Tool>);

impl<'py> ToolArgument<'_, 'py> {
    pub fn object(&self) -> &Bound<'py, PyAny> {
        self.0.as_any()
    }

    pub fn core(&self) -> &std::sync::Arc<core::Tool> {
        &self.0.get().core
    }
}

impl<'a, 'py> FromPyObject<'a, 'py> for ToolArgument<'a, 'py> {
    type Error = PyErr;

    fn extract(object: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        match object.cast::<Tool>() {
            Ok(tool) => Ok(ToolArgument(tool)),
            Err(_) => Err(raise("MeshError", format!("a feeler.Tool is needed, not {}", object.get_type().name()?))),
        }
    }
}

/// A pose, rigid: anything that NumPy reads as `(4, 4)` real numbers, a pair of rotation and translation, what has `as_matrix()`.
pub struct PoseArgument(pub core::Pose);

impl<'a, 'py> FromPyObject<'a, 'py> for PoseArgument {
    type Error = PyErr;

    fn extract(object: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        // The common case, without a book of who borrows which array: its numbers are copied at once.
        if let Ok(array) = object.cast::<PyArray<f64, Ix2>>() {
            if array.shape() == [4, 4] && is_plain(&object) {
                if array.is_c_contiguous() {
                    // SAFETY: nobody else runs while the array is looked at: this thread holds the interpreter, and calls nothing.
                    // Its sixteen numbers lie one after the other.
                    let matrix = unsafe { array.data().cast::<[[f64; 4]; 4]>().read_unaligned() };
                    return core::Pose::new(&matrix).map(PoseArgument).map_err(to_py);
                }
                // SAFETY: likewise.
                return pose_of(&unsafe { array.as_array() }).map(PoseArgument).map_err(to_py);
            }
        }
        let plain = plain_pose(&object)?;
        let array = real_numbers::<Ix2>(plain.as_borrowed(), "(4, 4)")?;
        if array.shape() != [4, 4] {
            return Err(raise(
                "PoseError",
                format!("a pose has shape {}: (4, 4) is needed", shape_text(array.shape())),
            ));
        }
        pose_of(&array.as_array()).map(PoseArgument).map_err(to_py)
    }
}

/// A pose of a call with several; its errors begin with the name of the argument.
macro_rules! named_poses {
    ($($function:ident $name:literal),*) => {$(
        pub fn $function(object: &Bound<'_, PyAny>) -> PyResult<PoseArgument> {
            object.extract::<PoseArgument>().map_err(|error| named($name, object.py(), error))
        }
    )*};
}
named_poses!(start_pose "start", end_pose "end", reference_pose "reference");

pub fn end_pose_or_none(object: &Bound<'_, PyAny>) -> PyResult<Option<PoseArgument>> {
    if object.is_none() {
        Ok(None)
    } else {
        end_pose(object).map(Some)
    }
}

pub fn reference_pose_or_none(object: &Bound<'_, PyAny>) -> PyResult<Option<PoseArgument>> {
    if object.is_none() {
        Ok(None)
    } else {
        reference_pose(object).map(Some)
    }
}

/// An error about poses, with the name of the argument in front.
fn named(name: &str, py: Python<'_>, error: PyErr) -> PyErr {
    let is_ours = error.get_type(py).name().is_ok_and(|kind| kind == "PoseError");
    if is_ours {
        raise("PoseError", format!("{name}: {}", error.value(py)))
    } else {
        error
    }
}

/// Poses, each rigid: anything that NumPy reads as `(n, 4, 4)` real numbers, what has `as_matrix()`, a list of what a pose can be.
pub struct PosesArgument(pub Vec<core::Pose>);

impl<'a, 'py> FromPyObject<'a, 'py> for PosesArgument {
    type Error = PyErr;

    fn extract(object: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        let plain = plain_poses(&object)?;
        let array = real_numbers::<Ix3>(plain.as_borrowed(), "(n, 4, 4)")?;
        if array.shape()[1..] != [4, 4] {
            return Err(raise(
                "PoseError",
                format!("poses have shape {}: (n, 4, 4) is needed", shape_text(array.shape())),
            ));
        }
        let named =
            |p, pose: core::Result<_>| pose.map_err(|e| raise("PoseError", format!("poses[{p}]: {}", message(&e))));
        let array = array.as_array();
        // Room for all at once: a list that grows is copied over and over, on one thread.
        let mut poses = Vec::with_capacity(array.shape()[0]);
        match array.as_slice() {
            Some(numbers) => {
                for (p, m) in numbers.as_chunks::<4>().0.as_chunks::<4>().0.iter().enumerate() {
                    poses.push(named(p, core::Pose::new(m))?);
                }
            }
            None => {
                for (p, m) in array.outer_iter().enumerate() {
                    poses.push(named(p, pose_of(&m))?);
                }
            }
        }
        Ok(PosesArgument(poses))
    }
}

/// True or false.
pub struct Switch(pub bool);

impl<'a, 'py> FromPyObject<'a, 'py> for Switch {
    type Error = PyErr;

    fn extract(object: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        match object.cast::<PyBool>() {
            Ok(flag) => Ok(Switch(flag.is_true())),
            Err(_) => checked(object.py(), "check_flag", ("a filter (repeat_filter, box_filter)", object)).map(Switch),
        }
    }
}

/// What a touch is to a query: "counts" or "free".
pub struct Touching(pub core::Touching);

impl<'a, 'py> FromPyObject<'a, 'py> for Touching {
    type Error = PyErr;

    fn extract(object: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        match object.extract::<String>().as_deref() {
            Ok("counts") => Ok(Touching(core::Touching::Ends)),
            Ok("free") => Ok(Touching(core::Touching::Free)),
            _ => Err(raise("OptionError", format!("touching is {}: choose counts, free", object.repr()?))),
        }
    }
}

/// An argument that a function of `feeler.arguments` checks, and raises an error with its name for.
pub fn checked<'py, T>(py: Python<'py>, check: &str, arguments: impl PyCallArgs<'py>) -> PyResult<T>
where
    T: for<'a> FromPyObject<'a, 'py, Error = PyErr>,
{
    py.import("feeler.arguments")?.call_method1(check, arguments)?.extract()
}

/// A pose that is no array, as one: `feeler.poses` knows the kinds.
fn plain_pose<'py>(object: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    let is_list = object.is_instance_of::<PyTuple>() || object.is_instance_of::<PyList>();
    if is_list || object.hasattr("as_matrix")? {
        return object.py().import("feeler.poses")?.call_method1("plain", (object,));
    }
    Ok(object.clone())
}

fn plain_poses<'py>(object: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    let is_list = object.is_instance_of::<PyTuple>() || object.is_instance_of::<PyList>();
    if is_list || object.hasattr("as_matrix")? {
        return object.py().import("feeler.poses")?.call_method1("plain_each", (object,));
    }
    Ok(object.clone())
}

pub fn pose_of(matrix: &ArrayView2<'_, f64>) -> core::Result<core::Pose> {
    core::Pose::new(&std::array::from_fn(|i| std::array::from_fn(|j| matrix[[i, j]])))
}

/// Whether it is an array of NumPy's own class. Others may hide some of their entries, as masked arrays do.
fn is_plain(object: &Bound<'_, PyAny>) -> bool {
    object.get_type().is(object.py().get_type::<PyUntypedArray>())
}

/// An array of float64 as it is, anything else as NumPy converts it.
fn real_numbers<'py, D: numpy::ndarray::Dimension>(
    object: Borrowed<'_, 'py, PyAny>,
    shape: &str,
) -> PyResult<PyReadonlyArray<'py, f64, D>> {
    if let (Ok(array), true) = (object.cast::<PyArray<f64, D>>(), is_plain(&object)) {
        if let Ok(array) = array.try_readonly() {
            return Ok(array);
        }
    }
    let py = object.py();
    let are = if D::NDIM == Some(2) { "a pose is" } else { "poses are" };
    let unreadable = |error: PyErr| {
        let is_of_numpy = error.is_instance_of::<PyValueError>(py) || error.is_instance_of::<PyTypeError>(py);
        if is_of_numpy || error.is_instance_of::<PyRuntimeError>(py) {
            let message = format!("{are} not numbers {shape}: {}", error.value(py));
            let raised = raise("PoseError", message);
            raised.set_cause(py, Some(error));
            raised
        } else {
            error
        }
    };
    if object.hasattr("mask")? {
        let what = are.trim_end_matches(" is").trim_end_matches(" are");
        py.import("feeler.poses")?.call_method1("refuse_masked", (what, object))?;
    }
    let numpy = py.import("numpy")?;
    let array = numpy.call_method1("asarray", (object,)).map_err(unreadable)?;
    let dtype = array.getattr("dtype")?;
    if !["f", "i", "u"].contains(&dtype.getattr("kind")?.extract::<String>()?.as_str()) {
        let kind = object.get_type().name()?;
        let message = format!("{are} {kind} (dtype {dtype}): real numbers {shape} are needed");
        return Err(raise("PoseError", message));
    }
    let array = array.call_method1("astype", (numpy.getattr("float64")?,)).map_err(unreadable)?;
    match array.cast::<PyArray<f64, D>>() {
        Ok(array) => Ok(array.readonly()),
        Err(_) => {
            let other = match D::NDIM {
                Some(2) => "one pose; collide_batch, distance_batch and clearance_batch take many",
                _ => "many poses; [pose] is a list of one",
            };
            let (found, of) = (array.getattr("shape")?, are.replace(" is", " has").replace(" are", " have"));
            Err(raise("PoseError", format!("{of} shape {found}: {shape} is needed, {other}")))
        }
    }
}
