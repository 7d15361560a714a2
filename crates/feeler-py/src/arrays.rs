//! NumPy arrays in and out.

use feeler_core::{PairKind, Pose};
use numpy::ndarray::{Array2, ArrayView1, ArrayView2, ArrayView3};
use numpy::npyffi::{_PyArray_GET_ITEM_DATA, NPY_ARRAY_WRITEABLE};
use numpy::{
    Element, IntoPyArray, PyArray, PyArray1, PyArray2, PyArray3, PyFixedUnicode, PyReadonlyArray2,
    PyUntypedArrayMethods,
};
use pyo3::exceptions::{PyIndexError, PyTypeError};
use pyo3::prelude::*;
use pyo3::types::{PyIterator, PyList, PySlice};
use pyo3::IntoPyObjectExt;

use crate::errors::{raise, shape_text};

/// Rows of three as a vector; an error of class `MeshError` for any other shape.
pub fn rows<T: Element + Copy>(what: &str, array: &PyReadonlyArray2<'_, T>) -> PyResult<Vec<[T; 3]>> {
    let view = array.as_array();
    if view.ncols() != 3 {
        return Err(raise("MeshError", format!("{what} has shape {}: (n, 3) is needed", shape_text(array.shape()))));
    }
    Ok(view.rows().into_iter().map(|r| [r[0], r[1], r[2]]).collect())
}

/// A read-only `(n, N)` array over memory that `owner` keeps alive and never changes.
///
/// # Safety
/// `data` must stay valid and unchanged as long as `owner` lives.
pub unsafe fn view_rows<'py, T: Element, const N: usize>(
    owner: &Bound<'py, PyAny>,
    data: &[[T; N]],
) -> Bound<'py, PyArray2<T>> {
    let flat = data.as_flattened();
    // SAFETY: the slice is contiguous and holds N * len elements.
    let view = unsafe { ArrayView2::from_shape_ptr((data.len(), N), flat.as_ptr()) };
    // SAFETY: the caller promises that `owner` keeps the data alive.
    let array = unsafe { PyArray2::borrow_from_array(&view, owner.clone()) };
    set_read_only(&array);
    array
}

/// The same for `(n, M, N)`.
///
/// # Safety
/// `data` must stay valid and unchanged as long as `owner` lives.
pub unsafe fn view_blocks<'py, T: Element, const N: usize, const M: usize>(
    owner: &Bound<'py, PyAny>,
    data: &[[[T; N]; M]],
) -> Bound<'py, PyArray3<T>> {
    let flat = data.as_flattened().as_flattened();
    // SAFETY: the slice is contiguous and holds N * M * len elements.
    let view = unsafe { ArrayView3::from_shape_ptr((data.len(), M, N), flat.as_ptr()) };
    // SAFETY: the caller promises that `owner` keeps the data alive.
    let array = unsafe { PyArray3::borrow_from_array(&view, owner.clone()) };
    set_read_only(&array);
    array
}

/// The same for one dimension.
///
/// # Safety
/// `data` must stay valid and unchanged as long as `owner` lives.
pub unsafe fn view<'py, T: Element>(owner: &Bound<'py, PyAny>, data: &[T]) -> Bound<'py, PyArray1<T>> {
    let view = ArrayView1::from(data);
    // SAFETY: the caller promises that `owner` keeps the data alive.
    let array = unsafe { PyArray1::borrow_from_array(&view, owner.clone()) };
    set_read_only(&array);
    array
}

/// The numbers that stand for kinds.
pub fn codes(kinds: &[PairKind]) -> &[u8] {
    // SAFETY: a kind is represented as its number, in one byte.
    unsafe { std::slice::from_raw_parts(kinds.as_ptr().cast(), kinds.len()) }
}

/// A word of `feeler.PairKind`.
pub type Word = PyFixedUnicode<8>;

/// The words for kinds, read-only.
pub fn words<'py>(py: Python<'py>, kinds: &[PairKind]) -> Bound<'py, PyArray1<Word>> {
    let letters = |word: &[u8; 8]| PyFixedUnicode(word.map(u32::from));
    let of = [letters(b"coplanar"), letters(b"crossing"), letters(b"touching")];
    let array = PyArray1::from_iter(py, kinds.iter().map(|kind| of[*kind as usize]));
    set_read_only(&array);
    array
}

/// An array that was just made, read-only.
pub fn read_only<T, D>(array: Bound<'_, PyArray<T, D>>) -> Bound<'_, PyArray<T, D>> {
    set_read_only(&array);
    array
}

/// Values as an array that an answer hands out: read-only, since it is made anew at every access, and what is written
/// into it would be lost.
pub trait IntoReadOnly: IntoPyArray {
    /// The array.
    fn into_read_only<'py>(self, py: Python<'py>) -> Bound<'py, PyArray<Self::Item, Self::Dim>> {
        read_only(self.into_pyarray(py))
    }
}

impl<T: IntoPyArray> IntoReadOnly for T {}

/// Of an array that was just made. By way of Python it would take eight times as long as all else here.
fn set_read_only<T, D>(array: &Bound<'_, PyArray<T, D>>) {
    // SAFETY: the array is alive, and nobody else knows it yet.
    unsafe { (*_PyArray_GET_ITEM_DATA(array.as_array_ptr())).flags &= !NPY_ARRAY_WRITEABLE };
}

/// A pose as `(4, 4) float64`.
pub(crate) fn pose_array<'py>(py: Python<'py>, pose: &Pose) -> Bound<'py, PyArray2<f64>> {
    let entry = |i: usize, j: usize| match (i, j) {
        (3, 3) => 1.0,
        (3, _) => 0.0,
        (_, 3) => pose.translation()[i],
        _ => pose.rotation()[i][j],
    };
    Array2::from_shape_fn((4, 4), |(i, j)| entry(i, j)).into_pyarray(py)
}

/// What a sequence is indexed by.
pub enum Index<'py> {
    /// One item, counted from the end where negative.
    One(isize),
    /// Several, as a list.
    Several(Bound<'py, PySlice>),
}

impl<'a, 'py> FromPyObject<'a, 'py> for Index<'py> {
    type Error = PyErr;

    fn extract(object: Borrowed<'a, 'py, PyAny>) -> PyResult<Self> {
        if let Ok(slice) = object.cast::<PySlice>() {
            return Ok(Index::Several(slice.to_owned()));
        }
        let one = object.extract::<isize>();
        one.map(Index::One).map_err(|_| {
            let kind = object.get_type().name().map_or_else(|_| String::new(), |name| format!(", not by a {name}"));
            PyTypeError::new_err(format!("rows are chosen by a number or a slice{kind}"))
        })
    }
}

/// The item or the items of a sequence of `count`, each a `what`; `item` makes one of its place.
pub fn at<'py, T: IntoPyObject<'py>>(
    py: Python<'py>,
    index: &Index<'py>,
    (count, what): (usize, &str),
    item: impl Fn(usize) -> PyResult<T>,
) -> PyResult<Bound<'py, PyAny>> {
    match index {
        Index::One(index) => {
            let place = if *index < 0 { index.checked_add_unsigned(count) } else { Some(*index) };
            let place = place.and_then(|place| usize::try_from(place).ok()).filter(|place| *place < count);
            let place = place.ok_or_else(|| PyIndexError::new_err(format!("{what} {index} of {count}")))?;
            item(place)?.into_bound_py_any(py)
        }
        Index::Several(slice) => {
            let chosen = slice.indices(count as isize)?;
            let places = (0..chosen.slicelength as isize).map(|n| (chosen.start + n * chosen.step) as usize);
            let items = places.map(|place| item(place)?.into_bound_py_any(py)).collect::<PyResult<Vec<_>>>()?;
            Ok(PyList::new(py, items)?.into_any())
        }
    }
}

/// The items of a sequence by their numbers.
pub fn in_order<'py, T>(sequence: &Bound<'py, T>) -> PyResult<Bound<'py, PyIterator>> {
    // SAFETY: it is an object, and the interpreter is held. What comes back is new, or none with an error.
    let items = unsafe { Bound::from_owned_ptr_or_err(sequence.py(), pyo3::ffi::PySeqIter_New(sequence.as_ptr())) }?;
    Ok(items.cast_into()?)
}
