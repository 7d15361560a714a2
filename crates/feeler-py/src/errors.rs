//! Converts core errors to the exceptions of `feeler.errors`, here and nowhere else.

use feeler_core::Error;
use pyo3::prelude::*;
use pyo3::types::PyType;

/// The Python exception for a core error.
pub fn to_py(error: Error) -> PyErr {
    let class = match &error {
        Error::EmptyMesh { .. }
        | Error::NothingToQuery { .. }
        | Error::Length { .. }
        | Error::PartOutOfRange { .. } => "MeshError",
        Error::EmptyPath | Error::PoseNotFinite { .. } | Error::PoseNotRigid { .. } => "PoseError",
        Error::VoxelSize { .. }
        | Error::Hashing { .. }
        | Error::HashingUnused { .. }
        | Error::Tolerance { .. }
        | Error::Margin { .. }
        | Error::Distance { .. }
        | Error::SweptError { .. }
        | Error::NotSymmetric { .. }
        | Error::NoneAsked { .. }
        | Error::NoSuchPart { .. }
        | Error::NoSuchBody { .. }
        | Error::Plane { .. }
        | Error::Ray { .. }
        | Error::Section { .. }
        | Error::Screw { .. }
        | Error::VertexLimit { .. } => "OptionError",
        Error::TooMany { .. }
        | Error::GridTooFine { .. }
        | Error::Memory { .. }
        | Error::TooManyEntries { .. }
        | Error::SweptTooFine { .. } => "LimitError",
        // `Cancelled`: the progress function or a signal handler raised, and the caller gets that exception (`reporter.rs`, `signals.rs`).
        _ => "FeelerError",
    };
    raise(class, message(&error))
}

/// Below this, what is wrong with a pose looks like rounding. `feeler.nearest_rigid` repairs as much without being asked to.
pub const ROUNDING: f64 = 1e-2;

/// What a core error says, and which function of the Python package helps.
pub fn message(error: &Error) -> String {
    match error {
        Error::PoseNotRigid { deviation, .. } if *deviation < ROUNDING => {
            format!("{error}; feeler.nearest_rigid(pose) repairs rounding (on the command line --snap-pose)")
        }
        _ => error.to_string(),
    }
}

/// An exception of `feeler.errors` by its name.
pub fn raise(class: &str, message: String) -> PyErr {
    Python::attach(|py| {
        let found =
            py.import("feeler.errors").and_then(|m| m.getattr(class)).and_then(|c| Ok(c.cast_into::<PyType>()?));
        match found {
            Ok(class) => PyErr::from_type(class, message),
            Err(error) => error,
        }
    })
}

/// A shape as Python writes it: "(3, 4)", "(16,)".
pub fn shape_text(shape: &[usize]) -> String {
    let sizes: Vec<String> = shape.iter().map(ToString::to_string).collect();
    format!("({}{})", sizes.join(", "), if sizes.len() == 1 { "," } else { "" })
}
