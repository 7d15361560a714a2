//! Restores pickled results.

use pyo3::prelude::*;
use pyo3::types::PyTuple;
use pyo3::BoundObject;

use crate::along::ClearanceAlong;
use crate::cast::{Cast, PathCheck};
use crate::collision::{Batch, Collision};
use crate::contacts::{ContactPlane, Contacts, Penetration};
use crate::containment::Containment;
use crate::errors::raise;
use crate::packed::{Packed, PackedPiece};
use crate::proximity::{Clearance, ClearanceBatch, Distance, DistanceBatch};
use crate::rays::{Rays, SectionOutline};
use crate::travel::damaged;

/// A result from its pickled state (`feeler.travel`). Raises `LoadError` for a state that does not fit.
#[pyfunction]
pub fn restore<'py>(py: Python<'py>, kind: &str, state: Bound<'py, PyTuple>) -> PyResult<Bound<'py, PyAny>> {
    fn made<'py, T>(py: Python<'py>, result: PyResult<T>) -> PyResult<Bound<'py, PyAny>>
    where
        T: IntoPyObject<'py>,
        PyErr: From<T::Error>,
    {
        Ok(result?.into_pyobject(py)?.into_bound().into_any())
    }
    let result = match kind {
        "Batch" => made(py, Batch::restore(&state)),
        "Cast" => made(py, Cast::restore(&state)),
        "Clearance" => made(py, Clearance::restore(&state)),
        "ClearanceBatch" => made(py, ClearanceBatch::restore(&state)),
        "ClearanceAlong" => made(py, ClearanceAlong::restore(&state)),
        "Collision" => made(py, Collision::restore(&state)),
        "Containment" => made(py, Containment::restore(&state)),
        "ContactPlane" => made(py, ContactPlane::restore(&state)),
        "Contacts" => made(py, Contacts::restore(&state)),
        "Distance" => made(py, Distance::restore(&state)),
        "DistanceBatch" => made(py, DistanceBatch::restore(&state)),
        "Packed" => made(py, Packed::restore(&state)),
        "PackedPiece" => made(py, PackedPiece::restore(&state)),
        "PathCheck" => made(py, PathCheck::restore(&state)),
        "Penetration" => made(py, Penetration::restore(&state)),
        "Rays" => made(py, Rays::restore(&state)),
        "SectionOutline" => made(py, SectionOutline::restore(&state)),
        other => Err(damaged(format!("nothing is called {other:?}"))),
    };
    result.map_err(|error| {
        let raised = raise("LoadError", format!("the pickle of a {kind} is damaged: {}", error.value(py)));
        raised.set_cause(py, Some(error));
        raised
    })
}
