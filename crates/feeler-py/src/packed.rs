//! `feeler._core.Packed` and its pieces.

use std::sync::{Arc, OnceLock};

use feeler_core as core;
use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2, PyUntypedArray};
use pyo3::exceptions::PyIndexError;
use pyo3::prelude::*;
use pyo3::types::PyTuple;

use crate::arrays::{view, view_rows, IntoReadOnly};
use crate::errors::to_py;
use crate::pools::on_pool;
use crate::travel::{check_lengths, damaged, list, reduced, rows_of};
use crate::words::counted;

/// A mesh in pieces for drawing. Packed triangles are numbered piece by piece. Arrays are read-only.
#[pyclass(frozen, module = "feeler._core")]
pub struct Packed {
    pieces: Vec<Arc<core::PackedPiece>>,
    order: Vec<u32>,
    places: Vec<u32>,
    middle: core::Point,
    sharing: OnceLock<core::Sharing>,
}

/// One draw call: whole parts, or a section of a large one. Arrays are read-only.
#[pyclass(frozen, module = "feeler._core")]
pub struct PackedPiece {
    core: Arc<core::PackedPiece>,
}

impl Packed {
    /// What `pack` gives, on the threads of the process.
    pub fn new(py: Python<'_>, pack: impl FnOnce() -> core::Result<core::Packed> + Send) -> PyResult<Packed> {
        let core::Packed { pieces, order, places, middle, .. } = py.detach(|| on_pool(None, pack))?.map_err(to_py)?;
        let pieces = pieces.into_iter().map(Arc::new).collect();
        Ok(Packed { pieces, order, places, middle, sharing: OnceLock::new() })
    }

    pub fn restore(state: &Bound<'_, PyTuple>) -> PyResult<Packed> {
        type State<'py> =
            (Vec<Bound<'py, PackedPiece>>, PyReadonlyArray1<'py, u32>, PyReadonlyArray1<'py, u32>, [f64; 3]);
        let (pieces, order, places, middle): State<'_> = state.extract()?;
        let pieces: Vec<_> = pieces.iter().map(|piece| Arc::clone(&piece.get().core)).collect();
        let (order, places) = (list(&order), list(&places));
        let mut triangles = 0;
        for piece in &pieces {
            if piece.first as usize != triangles {
                return Err(damaged(format!("a piece begins at triangle {}, not {triangles}", piece.first)));
            }
            triangles += piece.indices.len();
        }
        check_lengths("packed triangles", order.len(), triangles)?;
        if order.iter().enumerate().any(|(at, t)| places.get(*t as usize) != Some(&(at as u32))) {
            return Err(damaged("its order and its places do not belong together"));
        }
        Ok(Packed { pieces, order, places, middle, sharing: OnceLock::new() })
    }
}

#[pymethods]
impl Packed {
    /// Large parts first, small ones last.
    #[getter]
    fn pieces(&self) -> Vec<PackedPiece> {
        self.pieces.iter().map(|piece| PackedPiece { core: Arc::clone(piece) }).collect()
    }

    /// `(m,)`: the mesh's triangle of each packed triangle.
    #[getter]
    fn order<'py>(slf: &Bound<'py, Self>) -> Bound<'py, PyArray1<u32>> {
        // SAFETY: the result is frozen and owns its order; the array keeps it alive.
        unsafe { view(slf.as_any(), &slf.get().order) }
    }

    /// `(triangles of the mesh,)`: the packed triangle of each; 2**32 - 1 for defects, which are not drawn.
    #[getter]
    fn places<'py>(slf: &Bound<'py, Self>) -> Bound<'py, PyArray1<u32>> {
        // SAFETY: as for the order.
        unsafe { view(slf.as_any(), &slf.get().places) }
    }

    /// `(3,)`: the origin of positions, in the mesh's frame, metres: the middle of its box.
    #[getter]
    fn middle<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.middle.to_vec().into_read_only(py)
    }

    /// A piece whose copies of other parts are sent as places: runs `(r, 4)`, places `(c, 12)`, and positions, parts and
    /// indices of the rest. None: it has no copies.
    fn _shared<'py>(&self, py: Python<'py>, number: usize) -> PyResult<Option<Bound<'py, PyTuple>>> {
        let Some(piece) = self.pieces.get(number) else { return Err(PyIndexError::new_err(number)) };
        let shared = py.detach(|| -> PyResult<_> {
            if self.sharing.get().is_none() {
                // Not in `get_or_init`: it would wait in the pool for a thread of the pool. Two callers may both find it.
                let _ = self.sharing.set(on_pool(None, || core::Sharing::find(&self.pieces))?);
            }
            Ok(self.sharing.get().and_then(|sharing| sharing.piece(number, piece)))
        })?;
        let Some(shared) = shared else { return Ok(None) };
        let parts = match shared.parts {
            core::PartNumbers::Short(parts) => parts.into_pyarray(py).into_any(),
            core::PartNumbers::Long(parts) => parts.into_pyarray(py).into_any(),
        };
        let (runs, places) = (
            PyArray1::from_slice(py, shared.runs.as_flattened()),
            PyArray1::from_slice(py, shared.places.as_flattened()),
        );
        let positions = PyArray1::from_slice(py, shared.positions.as_flattened());
        let indices = PyArray1::from_slice(py, shared.indices.as_flattened());
        Ok(Some((runs, places, positions, parts, indices).into_pyobject(py)?))
    }

    fn __repr__(&self) -> String {
        format!("Packed({} in {})", counted(self.order.len(), "triangle"), counted(self.pieces.len(), "piece"))
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        let pieces = PyTuple::new(slf.py(), slf.get().pieces())?;
        reduced(slf.py(), "Packed", (pieces, Self::order(slf), Self::places(slf), slf.get().middle))
    }
}

impl PackedPiece {
    pub fn restore(state: &Bound<'_, PyTuple>) -> PyResult<PackedPiece> {
        type State<'py> = (
            PyReadonlyArray2<'py, f32>,
            Bound<'py, PyUntypedArray>,
            PyReadonlyArray2<'py, u16>,
            bool,
            u32,
            PyReadonlyArray2<'py, f64>,
        );
        let (positions, parts, indices, is_small, first, bounds): State<'_> = state.extract()?;
        let parts = match parts.extract::<PyReadonlyArray1<'_, u16>>() {
            Ok(parts) => core::PartNumbers::Short(list(&parts)),
            Err(_) => core::PartNumbers::Long(list(&parts.extract::<PyReadonlyArray1<'_, u32>>()?)),
        };
        let (positions, indices) = (rows_of(&positions)?, rows_of::<u16, 3>(&indices)?);
        check_lengths("part numbers", parts.len(), positions.len())?;
        if indices.as_flattened().iter().any(|at| usize::from(*at) >= positions.len()) {
            return Err(damaged("an index is past its last vertex"));
        }
        let [lower, upper] = rows_of(&bounds)?[..] else { return Err(damaged("its bounds are not two corners")) };
        let bounds = core::Aabb { lower, upper };
        let core = core::PackedPiece { positions, parts, indices, is_small, first, bounds };
        Ok(PackedPiece { core: Arc::new(core) })
    }
}

#[pymethods]
impl PackedPiece {
    /// `(v, 3)`: metres, from `Packed.middle`; distinct within a part, except where the part is cut.
    #[getter]
    fn positions<'py>(slf: &Bound<'py, Self>) -> Bound<'py, PyArray2<f32>> {
        // SAFETY: the piece is frozen and holds its positions; the array keeps it alive.
        unsafe { view_rows(slf.as_any(), &slf.get().core.positions) }
    }

    /// `(v,)`: the part of each vertex; uint32 where the mesh has more than 65,535 parts, else uint16.
    #[getter]
    fn parts<'py>(slf: &Bound<'py, Self>) -> Bound<'py, PyAny> {
        match &slf.get().core.parts {
            // SAFETY: as for the positions.
            core::PartNumbers::Short(parts) => unsafe { view(slf.as_any(), parts) }.into_any(),
            // SAFETY: likewise.
            core::PartNumbers::Long(parts) => unsafe { view(slf.as_any(), parts) }.into_any(),
        }
    }

    /// `(t, 3)`: triangles, as indices into `positions`, wound as given.
    #[getter]
    fn indices<'py>(slf: &Bound<'py, Self>) -> Bound<'py, PyArray2<u16>> {
        // SAFETY: as for the positions.
        unsafe { view_rows(slf.as_any(), &slf.get().core.indices) }
    }

    /// Whether it has parts that were named small.
    #[getter]
    fn is_small(&self) -> bool {
        self.core.is_small
    }

    /// The number of its first triangle among the packed ones.
    #[getter]
    fn first(&self) -> u32 {
        self.core.first
    }

    /// `(2, 3)`: lower and upper corner of the box around its triangles as given, in the mesh's frame, metres.
    #[getter]
    fn bounds<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        let b = [self.core.bounds.lower, self.core.bounds.upper];
        Array2::from_shape_fn((2, 3), |(i, a)| b[i][a]).into_read_only(py)
    }

    fn __repr__(&self) -> String {
        format!("PackedPiece({}, {} vertices)", counted(self.core.indices.len(), "triangle"), self.core.positions.len())
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        let core = &slf.get().core;
        let (positions, parts, indices) = (Self::positions(slf), Self::parts(slf), Self::indices(slf));
        let state = (positions, parts, indices, core.is_small, core.first, slf.get().bounds(slf.py()));
        reduced(slf.py(), "PackedPiece", state)
    }
}
