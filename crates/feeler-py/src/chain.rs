//! Slides and chains of joints.

use feeler_core as core;
use numpy::PyArray2;
use pyo3::prelude::*;
use pyo3::types::{PyIterator, PyList, PyTuple};

use crate::arguments::PoseArgument;
use crate::arrays::pose_array;
use crate::errors::{raise, to_py};
use crate::screw::{vector, Fraction, Screw, Three};

/// A straight motion: a drawer, a piston.
///
/// `way`: metres, world. Raises `OptionError` for numbers that are not finite or too large.
#[pyclass(frozen, module = "feeler._core")]
pub struct Slide {
    way: core::Point,
}

impl Slide {
    /// As a chain of one joint.
    pub fn chain(&self) -> PyResult<core::Chain> {
        core::Chain::new([core::Joint::Slide(self.way)]).map_err(to_py)
    }
}

#[pymethods]
impl Slide {
    #[new]
    fn new(way: &Bound<'_, PyAny>) -> PyResult<Slide> {
        let slide = Slide { way: vector("way of the slide", way)? };
        slide.chain()?;
        Ok(slide)
    }

    /// Metres, world.
    #[getter]
    fn way(&self) -> Three {
        self.way.into()
    }

    /// The reverse motion.
    fn reversed(&self) -> Slide {
        Slide { way: self.way.map(|x| -x) }
    }

    /// `(4, 4)`: a pose moved by a fraction of the slide, 0 to 1. Raises `PoseError`, `OptionError`.
    #[pyo3(signature = (pose, fraction = Fraction(1.0)), text_signature = "($self, pose, fraction=1.0)")]
    fn at<'py>(&self, py: Python<'py>, pose: PoseArgument, fraction: Fraction) -> PyResult<Bound<'py, PyArray2<f64>>> {
        Ok(pose_array(py, &self.chain()?.at(&pose.0, fraction.0).map_err(to_py)?))
    }

    fn __eq__(&self, other: &Bound<'_, PyAny>) -> bool {
        other.cast::<Slide>().is_ok_and(|other| other.get().way == self.way)
    }

    fn __hash__(&self, py: Python<'_>) -> PyResult<isize> {
        self.way().into_pyobject(py)?.hash()
    }

    fn __repr__(&self) -> String {
        let [x, y, z] = self.way;
        format!("Slide(({x:?}, {y:?}, {z:?}))")
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyTuple>> {
        (slf.get_type(), (slf.get().way(),)).into_pyobject(slf.py())
    }
}

/// Several joints that move at once, each at a constant rate: an arm, a lever on a slide.
///
/// `joints`: `Screw`s and `Slide`s, the one that carries all the others first; axes and directions are those in the
/// world at the start. Raises `OptionError` for anything else.
#[pyclass(frozen, module = "feeler._core")]
pub struct Chain {
    pub core: core::Chain,
}

#[pymethods]
impl Chain {
    #[new]
    fn new(joints: &Bound<'_, PyAny>) -> PyResult<Chain> {
        let wrong = |what: &Bound<'_, PyAny>| {
            raise("OptionError", format!("joints of the chain: {what} is not a feeler.Screw or a feeler.Slide"))
        };
        let mut all = Vec::new();
        for joint in joints.try_iter().map_err(|_| wrong(joints))? {
            let joint = joint?;
            all.push(match (joint.cast::<Screw>(), joint.cast::<Slide>()) {
                (Ok(screw), _) => core::Joint::Screw(screw.get().core),
                (_, Ok(slide)) => core::Joint::Slide(slide.get().way),
                _ => return Err(wrong(&joint)),
            });
        }
        Ok(Chain { core: core::Chain::new(all).map_err(to_py)? })
    }

    /// Its `Screw`s and `Slide`s.
    #[getter]
    fn joints<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let joints = self.core.joints().iter().map(|joint| match joint {
            core::Joint::Screw(screw) => Ok(Bound::new(py, Screw { core: *screw })?.into_any()),
            core::Joint::Slide(way) => Ok(Bound::new(py, Slide { way: *way })?.into_any()),
        });
        PyTuple::new(py, joints.collect::<PyResult<Vec<_>>>()?)
    }

    /// `(4, 4)`: a pose moved by a fraction of the chain, 0 to 1. Raises `PoseError`, `OptionError`.
    #[pyo3(signature = (pose, fraction = Fraction(1.0)), text_signature = "($self, pose, fraction=1.0)")]
    fn at<'py>(&self, py: Python<'py>, pose: PoseArgument, fraction: Fraction) -> PyResult<Bound<'py, PyArray2<f64>>> {
        Ok(pose_array(py, &self.core.at(&pose.0, fraction.0).map_err(to_py)?))
    }

    /// The reverse motion: its axes are where they are at the end.
    fn reversed(&self) -> PyResult<Chain> {
        Ok(Chain { core: self.core.reversed().map_err(to_py)? })
    }

    /// The motion as seen from a body that moves along another chain meanwhile: a scene of that body, where it is at
    /// the start, stands still. First joints that both have in common drop out.
    fn relative_to(&self, other: &Bound<'_, PyAny>) -> PyResult<Chain> {
        let other = other
            .cast::<Chain>()
            .map_err(|_| raise("OptionError", format!("other is {other}: give a feeler.Chain")))?;
        Ok(Chain { core: self.core.relative_to(&other.get().core) })
    }

    fn __len__(&self) -> usize {
        self.core.joints().len()
    }

    fn __iter__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyIterator>> {
        self.joints(py)?.try_iter()
    }

    fn __getitem__<'py>(&self, py: Python<'py>, index: Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
        self.joints(py)?.as_any().get_item(index)
    }

    fn __eq__(&self, other: &Bound<'_, PyAny>) -> bool {
        other.cast::<Chain>().is_ok_and(|other| other.get().core == self.core)
    }

    fn __hash__(&self, py: Python<'_>) -> PyResult<isize> {
        self.joints(py)?.hash()
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let joints = PyList::new(py, self.joints(py)?.iter())?;
        Ok(format!("Chain({})", joints.repr()?))
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyTuple>> {
        (slf.get_type(), (slf.get().joints(slf.py())?,)).into_pyobject(slf.py())
    }
}
