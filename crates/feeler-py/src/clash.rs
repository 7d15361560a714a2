//! `feeler._core.clash`: a mock-up against itself.

use std::sync::Arc;
use std::time::Instant;

use feeler_contacts as contacts;
use feeler_core as core;
use numpy::ndarray::{Array2, Array3};
use numpy::{Element, PyArray1, PyArray2, PyArray3, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arrays::IntoReadOnly;
use crate::errors::{raise, to_py};
use crate::pools::Pool;
use crate::proximity::points;
use crate::reporter::Reporter;
use crate::scene::Scene;
use crate::travel::{list, rows_of, stays};
use crate::words::counted;

/// Pairs of parts that are closer than required, as columns of one length, sorted by `a`, then `b`.
#[pyclass(frozen, module = "feeler._core")]
pub struct ClashRows {
    rows: Vec<contacts::Clash>,
    counts: contacts::ClashCounts,
    seconds: [f64; 3],
    is_partial: bool,
}

impl ClashRows {
    fn column<'py, T: Element>(&self, py: Python<'py>, of: impl Fn(&contacts::Clash) -> T) -> Bound<'py, PyArray1<T>> {
        self.rows.iter().map(of).collect::<Vec<T>>().into_read_only(py)
    }

    fn points<'py>(&self, py: Python<'py>, of: impl Fn(&contacts::Clash) -> core::Point) -> Bound<'py, PyArray2<f64>> {
        points(py, self.rows.iter().map(of))
    }
}

#[pymethods]
impl ClashRows {
    /// `(n,)`: the part with the smaller index.
    #[getter]
    fn a<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        self.column(py, |row| row.parts[0])
    }

    /// `(n,)`: the other part.
    #[getter]
    fn b<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        self.column(py, |row| row.parts[1])
    }

    /// `(n,)`: a `feeler.Verdict` for each pair.
    #[getter]
    fn verdict<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u8>> {
        self.column(py, |row| row.verdict as u8)
    }

    /// `(n,)`: how far the deepest point of one surface lies inside the other part, metres: a lower bound. 0 where
    /// they only touch or are apart; NaN where it was not measured.
    #[getter]
    fn depth<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.column(py, |row| row.depth)
    }

    /// `(n,)`: how much larger the depth can be, metres; NaN for two open parts, and where it was not measured.
    #[getter]
    fn depth_error<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.column(py, |row| row.depth_error)
    }

    /// `(n,)`: 0: measured within its error; 1: an estimate, because a part is open.
    #[getter]
    fn depth_kind<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u8>> {
        self.column(py, |row| row.kind as u8)
    }

    /// `(n, 3)`: moves `a` out of `b`, metres, world: the shortest one known (`b` moves the opposite way). Zero
    /// where they only touch or are apart.
    #[getter]
    fn translation<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        self.points(py, |row| row.translation)
    }

    /// `(n,)`: the distance between their surfaces, metres; 0 where they collide.
    #[getter]
    fn gap<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.column(py, |row| row.gap)
    }

    /// `(n, 3)`: on `a`, metres: the closest, touching or deepest point.
    #[getter]
    fn point_a<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        self.points(py, |row| row.points[0])
    }

    /// `(n, 3)`: the same on `b`.
    #[getter]
    fn point_b<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        self.points(py, |row| row.points[1])
    }

    /// `(n,)`: the number of colliding pairs of triangles.
    #[getter]
    fn triangles<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<u32>> {
        self.column(py, |row| row.triangles)
    }

    /// `(n, 2, 3)`: lower and upper corner of the box around the collision, metres; else around the points.
    #[getter(r#box)]
    fn bounds<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray3<f64>> {
        let side = |row: &contacts::Clash, i: usize| if i == 0 { row.bounds.lower } else { row.bounds.upper };
        Array3::from_shape_fn((self.rows.len(), 2, 3), |(n, i, axis)| side(&self.rows[n], i)[axis]).into_read_only(py)
    }

    /// `(n, 2)`: whether `a`, and `b`, has no closed surface and so no inside.
    #[getter]
    fn is_open<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<bool>> {
        Array2::from_shape_fn((self.rows.len(), 2), |(n, i)| self.rows[n].is_open[i]).into_read_only(py)
    }

    /// Number of pairs by first verdict: `crossing`, `touching`, `contained`, `duplicates`, `near`.
    #[getter]
    fn counts<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        let counts = &self.counts;
        for (name, count) in [
            ("crossing", counts.crossing),
            ("touching", counts.touching),
            ("contained", counts.held),
            ("duplicates", counts.duplicates),
            ("near", counts.near),
        ] {
            dict.set_item(name, count)?;
        }
        Ok(dict)
    }

    /// Seconds by stage: `verdicts`, `clearance`, `depths`.
    #[getter]
    fn seconds<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let dict = PyDict::new(py);
        for (name, seconds) in ["verdicts", "clearance", "depths"].iter().zip(self.seconds) {
            dict.set_item(name, seconds)?;
        }
        Ok(dict)
    }

    /// Whether it was interrupted.
    #[getter]
    fn is_partial(&self) -> bool {
        self.is_partial
    }

    fn __len__(&self) -> usize {
        self.rows.len()
    }

    fn __reduce__(&self) -> PyResult<()> {
        Err(stays("ClashRows", "take its columns, which are arrays"))
    }

    fn __repr__(&self) -> String {
        format!(
            "ClashRows({} of parts{})",
            counted(self.rows.len(), "pair"),
            if self.is_partial { ", partial" } else { "" }
        )
    }
}

/// A table of classes, row by row.
fn table(what: &str, array: &PyReadonlyArray2<'_, f64>) -> PyResult<Vec<f64>> {
    let view = array.as_array();
    if view.nrows() != view.ncols() {
        let shape = view.shape();
        return Err(raise("OptionError", format!("{what} has shape {shape:?}: (classes, classes) is needed")));
    }
    Ok(view.iter().copied().collect())
}

/// Every pair of present parts that are closer than required.
///
/// - `clearance`, `contact`: `(classes, classes)`, metres, symmetric. The required distance between parts of two
///   classes (negative: such pairs are skipped), and the depth or distance up to which they count as in contact.
/// - `class_of_part`: `(parts,)`; default: class 0 for all.
/// - `contact_of_part`: `(parts,)`, metres: added to the contact of each pair of the part.
/// - `copies_within`: metres: how far apart rounding in a file may put two copies of one surface.
/// - `exclude`: `(k, 2)`: pairs of parts to skip.
/// - `threads`: default: those of the scene.
///
/// Ctrl-C ends it early: the result has the rows found so far (all of them, if only depths were missing), and
/// `is_partial` is true. Depths not measured by then are NaN. Raises `OptionError` for tables of the wrong shape and
/// invalid lengths, `MeshError` for arrays of the wrong length.
#[pyfunction]
#[pyo3(signature = (scene, clearance, contact, *, class_of_part = None, contact_of_part = None, copies_within = 0.0,
                    exclude = None, threads = None, progress = None))]
#[allow(clippy::too_many_arguments, reason = "the Python signature")]
pub fn clash(
    py: Python<'_>,
    scene: &Scene,
    clearance: PyReadonlyArray2<'_, f64>,
    contact: PyReadonlyArray2<'_, f64>,
    class_of_part: Option<PyReadonlyArray1<'_, u32>>,
    contact_of_part: Option<PyReadonlyArray1<'_, f64>>,
    copies_within: f64,
    exclude: Option<PyReadonlyArray2<'_, u32>>,
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
) -> PyResult<ClashRows> {
    let tables = core::PairLimitTables::default()
        .with_class_of_part(class_of_part.map_or_else(Vec::new, |classes| list(&classes)))
        .with_clearance(table("clearance", &clearance)?)
        .with_contact(table("contact", &contact)?)
        .with_contact_of_part(contact_of_part.map_or_else(Vec::new, |contacts| list(&contacts)))
        .with_copies_within(copies_within)
        .with_excluded(exclude.map_or_else(|| Ok(Vec::new()), |pairs| rows_of::<u32, 2>(&pairs))?);
    let solver = Arc::clone(scene.solver());
    let limits = core::PairLimits::new(tables, solver.scene().mockup().part_bounds().len()).map_err(to_py)?;
    let own = threads.map(|threads| Arc::new(Pool::new(threads)));
    let pool = own.as_deref().or(scene.pool().map(Arc::as_ref));
    let reporter = Reporter::new(progress);
    let found = py.detach(|| {
        reporter.watch(pool, || {
            let tell = |done: f64, stage: &str| reporter.tell(done, stage);
            let options = contacts::ClashOptions::default().with_progress(&tell);
            let mut seconds = [0.0; 3];
            let start = Instant::now();
            let mut search = contacts::ClashSearch::new(&solver, &limits, &options)?;
            search.find_verdicts();
            seconds[0] = start.elapsed().as_secs_f64();
            if search.is_complete() {
                search.find_gaps();
                seconds[1] = start.elapsed().as_secs_f64() - seconds[0];
            }
            let rows = search.measure()?;
            seconds[2] = start.elapsed().as_secs_f64() - seconds[0] - seconds[1];
            Ok(ClashRows { rows, counts: search.counts(), seconds, is_partial: !search.is_complete() })
        })
    });
    let is_interrupted = reporter.finish_interrupted()?;
    let mut rows = found?.map_err(to_py)?;
    // Ctrl-C may be heard when the last row is done: the user sees the interrupt all the same.
    rows.is_partial |= is_interrupted;
    Ok(rows)
}
