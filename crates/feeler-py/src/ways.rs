//! Ways as arguments: legs and paths.

use feeler_core as core;
use pyo3::prelude::*;
use pyo3::types::{PyList, PyTuple};

use crate::arguments::{PoseArgument, PosesArgument};
use crate::chain::{Chain, Slide};
use crate::errors::raise;
use crate::screw::Screw;

/// A leg that is no pose; `None` for anything else.
fn leg_of(object: &Bound<'_, PyAny>) -> PyResult<Option<core::Leg>> {
    if let Ok(screw) = object.cast::<Screw>() {
        return Ok(Some(core::Leg::Screw(screw.get().core)));
    }
    if let Ok(slide) = object.cast::<Slide>() {
        return Ok(Some(core::Leg::Chain(slide.get().chain()?)));
    }
    Ok(object.cast::<Chain>().ok().map(|chain| core::Leg::Chain(chain.get().core.clone())))
}

/// A `feeler.Screw`, `Slide` or `Chain`, or where `END` a pose.
pub struct WayArgument<const END: bool>(pub core::Leg);

impl<'a, 'py, const END: bool> FromPyObject<'a, 'py> for WayArgument<END> {
    type Error = PyErr;

    fn extract(object: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        if let Some(leg) = leg_of(&object)? {
            return Ok(WayArgument(leg));
        }
        if END {
            let pose = object.extract::<PoseArgument>().map_err(|error| {
                let said = error.value(object.py());
                raise("PoseError", format!("way is no feeler.Screw, Slide or Chain, and no pose: {said}"))
            })?;
            return Ok(WayArgument(core::Leg::To(pose.0)));
        }
        let name = object.get_type().name()?;
        Err(raise("OptionError", format!("screw is {name}: give a feeler.Screw, a feeler.Slide or a feeler.Chain")))
    }
}

/// A path: poses `(n, 4, 4)`, or a list that begins with a pose and goes on with poses, screws, slides and chains.
pub enum PathArgument {
    Poses(Vec<core::Pose>),
    Legs(core::Pose, Vec<core::Leg>),
}

impl PathArgument {
    /// The first pose, if there is one.
    pub fn start(&self) -> Option<&core::Pose> {
        match self {
            PathArgument::Poses(poses) => poses.first(),
            PathArgument::Legs(start, _) => Some(start),
        }
    }
}

impl<'a, 'py> FromPyObject<'a, 'py> for PathArgument {
    type Error = PyErr;

    fn extract(object: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        let is_list = object.is_instance_of::<PyList>() || object.is_instance_of::<PyTuple>();
        let entries: Vec<Bound<'_, PyAny>> = if is_list { object.extract()? } else { Vec::new() };
        let found = entries.iter().map(leg_of).collect::<PyResult<Vec<_>>>()?;
        if found.iter().all(Option::is_none) {
            return Ok(PathArgument::Poses(object.extract::<PosesArgument>()?.0));
        }
        let leg = |(entry, leg): (&Bound<'_, PyAny>, Option<core::Leg>)| match leg {
            Some(leg) => Ok(leg),
            None => entry.extract::<PoseArgument>().map(|pose| core::Leg::To(pose.0)),
        };
        let mut legs = entries.iter().zip(found).map(leg).collect::<PyResult<Vec<_>>>()?;
        match legs.remove(0) {
            core::Leg::To(start) => Ok(PathArgument::Legs(start, legs)),
            core::Leg::Screw(_) | core::Leg::Chain(_) => {
                Err(raise("PoseError", "a path begins with a pose: a screw says how to go on from one".into()))
            }
        }
    }
}
