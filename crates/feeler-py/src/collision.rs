//! Results of queries.

use std::collections::HashMap;
use std::sync::{Arc, OnceLock};

use feeler_core as core;
use numpy::ndarray::Array2;
use numpy::{PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyIterator, PyTuple};

use crate::arrays::{at, codes, in_order, view, view_rows, words, Index, IntoReadOnly, Word};
use crate::mockup::Mockup;
use crate::travel::{check_lengths, check_offsets, damaged, kinds_of, list, reduced, rows_of};
use crate::words::counted;

/// The colliding pairs of triangles at one pose; false when there are none.
///
/// `hit[i]` is pair `i`: the tool's triangle and the mock-up's.
#[pyclass(frozen, module = "feeler._core")]
pub struct Collision {
    core: core::Collision,
    parts: Parts,
    /// Triangles and parts of the tool and the mock-up, once they were asked for.
    columns: [OnceLock<Vec<u32>>; 4],
}

/// The parts that are met.
enum Parts {
    /// To be looked up in mock-up and tool.
    Of(Py<Mockup>, Arc<core::Tool>),
    /// Of tool and mock-up, as they were found where the result comes from: it travels without these.
    Found([Vec<u32>; 2]),
}

impl Collision {
    pub fn new(core: core::Collision, mockup: Py<Mockup>, tool: Arc<core::Tool>) -> Collision {
        Collision { core, parts: Parts::Of(mockup, tool), columns: Default::default() }
    }

    /// The counters of the query by name.
    fn counters<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        for (name, count) in self.core.stats.entries() {
            dict.set_item(name, count)?;
        }
        Ok(dict)
    }

    /// Of the tool (0) or the mock-up (1).
    fn part_ids(&self, column: usize) -> &[u32] {
        let (mockup, tool) = match &self.parts {
            Parts::Of(mockup, tool) => (&mockup.get().core, tool),
            Parts::Found(parts) => return &parts[column],
        };
        let part = |p: &[u32; 2]| if column == 0 { tool.part_of_face(p[0]) } else { mockup.part_of_face(p[1]) };
        self.columns[2 + column].get_or_init(|| self.distinct(part))
    }

    pub fn restore(state: &Bound<'_, PyTuple>) -> PyResult<Collision> {
        type State<'py> =
            (PyReadonlyArray2<'py, u32>, PyReadonlyArray1<'py, u8>, Ids<'py>, Ids<'py>, HashMap<String, u64>);
        type Ids<'py> = PyReadonlyArray1<'py, u32>;
        let (pairs, kinds, tool_parts, parts, counts): State<'_> = state.extract()?;
        let mut core = core::Collision::default();
        (core.pairs, core.kinds) = (rows_of(&pairs)?, kinds_of(&kinds)?);
        check_lengths("kinds", core.kinds.len(), core.pairs.len())?;
        let stats = &mut core.stats;
        for (name, count) in counts {
            *match name.as_str() {
                "voxels_visited" => &mut stats.voxels_visited,
                "clusters_placed" => &mut stats.clusters_placed,
                "pieces_scanned" => &mut stats.pieces_scanned,
                "entries_scanned" => &mut stats.entries_scanned,
                "box_survivors" => &mut stats.box_survivors,
                "repeats_skipped" => &mut stats.repeats_skipped,
                "triangle_tests" => &mut stats.triangle_tests,
                "exact_tests" => &mut stats.exact_tests,
                "pairs" => &mut stats.pairs,
                other => return Err(damaged(format!("no figure is called {other:?}"))),
            } = count;
        }
        let parts = Parts::Found([list(&tool_parts), list(&parts)]);
        Ok(Collision { core, parts, columns: Default::default() })
    }

    /// Of the tool (0) or the mock-up (1).
    fn triangles(&self, column: usize) -> &[u32] {
        self.columns[column].get_or_init(|| self.distinct(|p| p[column]))
    }

    /// What the pairs have, sorted, each once.
    fn distinct(&self, of: impl Fn(&[u32; 2]) -> u32) -> Vec<u32> {
        let mut ids: Vec<u32> = self.core.pairs.iter().map(of).collect();
        ids.sort_unstable();
        ids.dedup();
        ids
    }
}

#[pymethods]
impl Collision {
    /// `(k, 2)`: tool triangle and mock-up triangle; unique, sorted by row, read-only.
    #[getter]
    fn pairs<'py>(slf: &Bound<'py, Self>) -> Bound<'py, PyArray2<u32>> {
        // SAFETY: the result is frozen and owns its pairs; the array keeps it alive.
        unsafe { view_rows(slf.as_any(), &slf.get().core.pairs) }
    }

    /// `(k,)`: the word of a `feeler.PairKind` for each pair, `numpy.str_`; read-only, made anew at each call.
    #[getter]
    fn kinds<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<Word>> {
        words(py, &self.core.kinds)
    }

    /// `(k,)`: the `PairKind.code` of each pair, one byte each; read-only.
    #[getter]
    fn kind_codes<'py>(slf: &Bound<'py, Self>) -> Bound<'py, PyArray1<u8>> {
        // SAFETY: as for the pairs.
        unsafe { view(slf.as_any(), codes(&slf.get().core.kinds)) }
    }

    /// Colliding triangles of the tool; unique, sorted, read-only.
    #[getter]
    fn tool_triangles<'py>(slf: &Bound<'py, Self>) -> Bound<'py, PyArray1<u32>> {
        // SAFETY: as for the pairs; a column is written once, before the first view of it.
        unsafe { view(slf.as_any(), slf.get().triangles(0)) }
    }

    /// Colliding triangles of the mock-up; unique, sorted, read-only.
    #[getter]
    fn mockup_triangles<'py>(slf: &Bound<'py, Self>) -> Bound<'py, PyArray1<u32>> {
        // SAFETY: as for the tool's.
        unsafe { view(slf.as_any(), slf.get().triangles(1)) }
    }

    /// Indices into `mockup.parts` of the colliding parts; unique, sorted, read-only.
    #[getter]
    fn parts<'py>(slf: &Bound<'py, Self>) -> Bound<'py, PyArray1<u32>> {
        // SAFETY: as for the tool's triangles.
        unsafe { view(slf.as_any(), slf.get().part_ids(1)) }
    }

    /// Indices into `tool.parts` of the colliding parts; unique, sorted, read-only.
    #[getter]
    fn tool_parts<'py>(slf: &Bound<'py, Self>) -> Bound<'py, PyArray1<u32>> {
        // SAFETY: as for the tool's triangles.
        unsafe { view(slf.as_any(), slf.get().part_ids(0)) }
    }

    /// Counters of the query, stage by stage.
    #[getter]
    fn stats<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        py.import("feeler.figures")?.getattr("CollisionStats")?.call((), Some(&self.counters(py)?))
    }

    fn __len__(&self) -> usize {
        self.core.pairs.len()
    }

    fn __bool__(&self) -> bool {
        !self.core.pairs.is_empty()
    }

    fn __iter__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyIterator>> {
        in_order(slf)
    }

    fn __getitem__<'py>(&self, py: Python<'py>, index: Index<'py>) -> PyResult<Bound<'py, PyAny>> {
        at(py, &index, (self.core.pairs.len(), "pair"), |i| Ok((self.core.pairs[i][0], self.core.pairs[i][1])))
    }

    fn __repr__(&self) -> String {
        format!("Collision({})", counted(self.core.pairs.len(), "pair"))
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        let (py, this) = (slf.py(), slf.get());
        let parts = (Self::tool_parts(slf), Self::parts(slf));
        reduced(py, "Collision", (Self::pairs(slf), Self::kind_codes(slf), parts.0, parts.1, this.counters(py)?))
    }
}

/// The pairs of many poses; `batch[i]` are those of pose `i`, `(k, 2)`.
#[pyclass(frozen, module = "feeler._core")]
pub struct Batch {
    core: core::Batch,
}

impl Batch {
    pub fn new(core: core::Batch) -> Batch {
        Batch { core }
    }

    pub fn restore(state: &Bound<'_, PyTuple>) -> PyResult<Batch> {
        type State<'py> = (PyReadonlyArray1<'py, u64>, PyReadonlyArray2<'py, u32>, PyReadonlyArray1<'py, u8>);
        let (offsets, pairs, kinds): State<'_> = state.extract()?;
        let mut core = core::Batch::default();
        (core.offsets, core.pairs, core.kinds) = (list(&offsets), rows_of(&pairs)?, kinds_of(&kinds)?);
        check_lengths("kinds", core.kinds.len(), core.pairs.len())?;
        check_offsets(&core.offsets, core.pairs.len())?;
        Ok(Batch { core })
    }
}

#[pymethods]
impl Batch {
    /// `(n + 1,)`: pose `i` has the pairs `offsets[i]:offsets[i + 1]`; read-only.
    #[getter]
    fn offsets<'py>(slf: &Bound<'py, Self>) -> Bound<'py, PyArray1<u64>> {
        // SAFETY: the result is frozen and owns its offsets; the array keeps it alive.
        unsafe { view(slf.as_any(), &slf.get().core.offsets) }
    }

    /// `(K, 2)`: tool triangle and mock-up triangle, sorted within each pose; read-only.
    #[getter]
    fn pairs<'py>(slf: &Bound<'py, Self>) -> Bound<'py, PyArray2<u32>> {
        // SAFETY: as for the offsets.
        unsafe { view_rows(slf.as_any(), &slf.get().core.pairs) }
    }

    /// `(K,)`: the word of a `feeler.PairKind` for each pair, `numpy.str_`; read-only, made anew at each call.
    #[getter]
    fn kinds<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<Word>> {
        words(py, &self.core.kinds)
    }

    /// `(K,)`: the `PairKind.code` of each pair, one byte each; read-only.
    #[getter]
    fn kind_codes<'py>(slf: &Bound<'py, Self>) -> Bound<'py, PyArray1<u8>> {
        // SAFETY: as for the offsets.
        unsafe { view(slf.as_any(), codes(&slf.get().core.kinds)) }
    }

    fn __len__(&self) -> usize {
        self.core.offsets.len() - 1
    }

    /// The pairs of one pose, `(k, 2)`.
    fn __iter__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyIterator>> {
        in_order(slf)
    }

    fn __getitem__<'py>(&self, py: Python<'py>, index: Index<'py>) -> PyResult<Bound<'py, PyAny>> {
        at(py, &index, (self.__len__(), "pose"), |i| {
            let rows = &self.core.pairs[self.core.offsets[i] as usize..self.core.offsets[i + 1] as usize];
            Ok(Array2::from_shape_fn((rows.len(), 2), |(r, c)| rows[r][c]).into_read_only(py))
        })
    }

    fn __repr__(&self) -> String {
        format!("Batch({}, {})", counted(self.__len__(), "pose"), counted(self.core.pairs.len(), "pair"))
    }

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        reduced(slf.py(), "Batch", (Self::offsets(slf), Self::pairs(slf), Self::kind_codes(slf)))
    }
}
