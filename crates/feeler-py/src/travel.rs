//! Pickled results: the state of each, and how it is read back.
//!
//! `feeler.travel` adds the format's number to this state, and checks it before it calls `restore.rs`. Restored data is
//! not trusted: views are made over it, so lengths and places are checked like those of a file.

use feeler_core as core;
use numpy::{Element, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyTuple;

/// What `__reduce__` answers for a result that consists of `state`.
pub fn reduced<'py>(
    py: Python<'py>,
    kind: &str,
    state: impl IntoPyObject<'py, Target = PyTuple, Output = Bound<'py, PyTuple>, Error = PyErr>,
) -> PyResult<Bound<'py, PyAny>> {
    py.import("feeler.travel")?.call_method1("reduced", (kind, state.into_pyobject(py)?))
}

/// What `__reduce__` answers for what does not travel.
pub fn stays(kind: &str, instead: &str) -> PyErr {
    pyo3::exceptions::PyTypeError::new_err(format!("a {kind} cannot be pickled or copied: {instead}"))
}

/// An error of a state; `restore` says of what.
pub fn damaged(why: impl Into<String>) -> PyErr {
    pyo3::exceptions::PyValueError::new_err(why.into())
}

/// An error unless two lists that belong together are as long.
pub fn check_lengths(what: &str, got: usize, expected: usize) -> PyResult<()> {
    if got == expected {
        return Ok(());
    }
    Err(damaged(format!("it has {got} {what}, not {expected}")))
}

/// An error unless these are offsets into a list of `length`.
pub fn check_offsets(offsets: &[u64], length: usize) -> PyResult<()> {
    if offsets.first() == Some(&0) && offsets.last() == Some(&(length as u64)) && offsets.is_sorted() {
        return Ok(());
    }
    Err(damaged(format!("its offsets do not rise from 0 to {length}")))
}

/// The numbers of a list.
pub fn list<T: Element + Copy>(array: &PyReadonlyArray1<'_, T>) -> Vec<T> {
    array.as_array().iter().copied().collect()
}

/// Rows of `N`.
pub fn rows_of<T: Element + Copy, const N: usize>(array: &PyReadonlyArray2<'_, T>) -> PyResult<Vec<[T; N]>> {
    let view = array.as_array();
    check_lengths("columns", view.ncols(), N)?;
    Ok(view.rows().into_iter().map(|row| std::array::from_fn(|i| row[i])).collect())
}

/// Kinds of pairs from the numbers that stand for them.
pub fn kinds_of(codes: &PyReadonlyArray1<'_, u8>) -> PyResult<Vec<core::PairKind>> {
    let kind = |code: &u8| match code {
        0 => Ok(core::PairKind::Coplanar),
        1 => Ok(core::PairKind::Crossing),
        2 => Ok(core::PairKind::Touching),
        other => Err(damaged(format!("{other} is no kind of a pair"))),
    };
    codes.as_array().iter().map(kind).collect()
}
