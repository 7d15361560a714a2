//! `feeler._core.Bodies`, bodies that move, each against each, and `Shape`, what they are made of.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use feeler_contacts as contacts;
use feeler_core as core;
use feeler_core::{GoOn, PairKind, Who};
use numpy::ndarray::Array2;
use numpy::{Element, IntoPyArray, PyArray1, PyArray2, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arguments::PoseArgument;
use crate::arrays::rows;
use crate::errors::to_py;
use crate::mockup::defects;
use crate::pools::Pool;
use crate::proximity::points;
use crate::reporter::Reporter;
use crate::signals::on_pool_or_left;
use crate::travel::stays;

/// Triangles of a mesh that is checked in less than a millisecond.
const SOON_CHECKED: usize = 10_000;

/// A mesh that bodies share.
#[pyclass(frozen, weakref, module = "feeler._core")]
pub struct Shape {
    core: Arc<core::Shape>,
}

#[pymethods]
impl Shape {
    /// Vertices `(n, 3)` in metres, faces `(m, 3)`. Solid, so that what lies in it meets it, if it is closed and
    /// convex.
    #[new]
    fn new(
        py: Python<'_>,
        vertices: PyReadonlyArray2<'_, f64>,
        faces: PyReadonlyArray2<'_, u32>,
        memory_limit: u64,
    ) -> PyResult<Shape> {
        let (vertices, faces) = (rows("vertices", &vertices)?, rows("faces", &faces)?);
        let faces_count = faces.len();
        let make = move || core::Shape::new(vertices, faces, memory_limit).map(core::Shape::solid_if_convex);
        // To hand a small one to another thread takes longer than to make it.
        let made = if faces_count < SOON_CHECKED { py.detach(make) } else { py.detach(|| on_pool_or_left(make))? };
        Ok(Shape { core: Arc::new(made.map_err(to_py)?) })
    }

    /// Whether it is of these arrays, to the last bit.
    fn is_of(&self, py: Python<'_>, vertices: PyReadonlyArray2<'_, f64>, faces: PyReadonlyArray2<'_, u32>) -> bool {
        let (vertices, faces) = (vertices.as_array(), faces.as_array());
        py.detach(|| {
            let mesh = self.core.mesh();
            let same = |a: &[f64; 3], b: numpy::ndarray::ArrayView1<'_, f64>| {
                b.len() == 3 && (0..3).all(|i| a[i].to_bits() == b[i].to_bits())
            };
            mesh.vertices().len() == vertices.nrows()
                && mesh.faces().len() == faces.nrows()
                && mesh.vertices().iter().zip(vertices.rows()).all(|(a, b)| same(a, b))
                && mesh.faces().iter().zip(faces.rows()).all(|(a, b)| b.len() == 3 && (0..3).all(|i| a[i] == b[i]))
        })
    }

    /// Whether what lies in it meets it.
    #[getter]
    fn is_solid(&self) -> bool {
        self.core.is_solid()
    }

    /// Kind of defect -> count and first ids.
    #[getter]
    fn defects<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        defects(py, self.core.mesh())
    }

    /// Triangles given, defective ones included.
    #[getter]
    fn triangle_count(&self) -> usize {
        self.core.mesh().faces().len()
    }

    fn __reduce__(&self) -> PyResult<()> {
        Err(stays("Shape", "make it anew from its arrays"))
    }
}

/// Bodies by number, each a shape at a pose.
#[pyclass(frozen, module = "feeler._core")]
pub struct Bodies {
    core: Mutex<core::Bodies>,
    pool: Option<Arc<Pool>>,
}

impl Bodies {
    fn set(&self) -> MutexGuard<'_, core::Bodies> {
        self.core.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Asks a copy, which nobody moves meanwhile, on the threads of the pool.
    fn ask<R: Send>(
        &self,
        py: Python<'_>,
        one: Option<u32>,
        others: Option<&Bodies>,
        query: impl FnOnce(&core::Bodies, Who<'_>, GoOn<'_>) -> core::Result<R> + Send,
    ) -> PyResult<R> {
        let reporter = Reporter::new(None);
        // One after the other: both may be the same set, or each other's.
        let bodies = self.set().clone();
        let others = others.map(|others| others.set().clone());
        let found = py.detach(|| {
            reporter.watch(self.pool.as_deref(), || {
                let who = match (one, &others) {
                    (Some(one), _) => Who::One(one),
                    (None, Some(others)) => Who::Others(others),
                    (None, None) => Who::Each,
                };
                let goes_on = || !reporter.has_raised();
                query(&bodies, who, GoOn::new(&goes_on))
            })
        });
        reporter.finish()?;
        found?.map_err(to_py)
    }
}

/// Bodies, triangles, numbers of kinds and points.
type ContactRows<'py> =
    (Bound<'py, PyArray2<u32>>, Bound<'py, PyArray2<u32>>, Bound<'py, PyArray1<u8>>, Bound<'py, PyArray2<f64>>);

/// Bodies, triangles, distance and points.
type GapRow<'py> = ([u32; 2], [u32; 2], f64, Bound<'py, PyArray2<f64>>);

#[pymethods]
impl Bodies {
    /// `threads`: how many answer a question; None: as many as there are CPUs. `memory_limit`: the most bytes of an
    /// answer.
    #[new]
    fn new(threads: Option<usize>, memory_limit: u64) -> Bodies {
        let pool = threads.map(|threads| Arc::new(Pool::new(threads)));
        Bodies { core: Mutex::new(core::Bodies::with_memory_limit(memory_limit)), pool }
    }

    /// The same bodies in a set of its own.
    fn copy(&self) -> Bodies {
        Bodies { core: Mutex::new(self.set().clone()), pool: self.pool.clone() }
    }

    /// The number of a new body; numbers of removed ones are used again.
    fn add(&self, shape: PyRef<'_, Shape>, world_from_body: PoseArgument) -> u32 {
        self.set().add(Arc::clone(&shape.core), world_from_body.0)
    }

    /// Removes a body.
    fn remove(&self, body: u32) -> PyResult<()> {
        self.set().remove(body).map_err(to_py)
    }

    /// Moves a body.
    fn set_pose(&self, body: u32, world_from_body: PoseArgument) -> PyResult<()> {
        self.set().set_pose(body, world_from_body.0).map_err(to_py)
    }

    /// Whether any bodies meet: each with each, one with each other, or each with those of another set.
    #[pyo3(signature = (*, one = None, others = None))]
    fn is_meeting(&self, py: Python<'_>, one: Option<u32>, others: Option<PyRef<'_, Bodies>>) -> PyResult<bool> {
        self.ask(py, one, others.as_deref(), |bodies, who, go_on| bodies.is_meeting_while(who, go_on))
    }

    /// `(k, 2)`: the pairs of bodies that meet, sorted.
    #[pyo3(signature = (*, one = None, others = None))]
    fn meeting<'py>(
        &self,
        py: Python<'py>,
        one: Option<u32>,
        others: Option<PyRef<'_, Bodies>>,
    ) -> PyResult<Bound<'py, PyArray2<u32>>> {
        let found = self.ask(py, one, others.as_deref(), |bodies, who, go_on| bodies.meeting_while(who, go_on))?;
        Ok(pairs(py, found.into_iter()))
    }

    /// Every pair of triangles that meets: bodies `(k, 2)`, triangles `(k, 2)`, the numbers of the kinds `(k,)`,
    /// points `(k, 3)`.
    ///
    /// The kind is 255 where one body is in the other.
    #[pyo3(signature = (*, one = None, others = None))]
    fn contacts<'py>(
        &self,
        py: Python<'py>,
        one: Option<u32>,
        others: Option<PyRef<'_, Bodies>>,
    ) -> PyResult<ContactRows<'py>> {
        let found = self.ask(py, one, others.as_deref(), |bodies, who, go_on| bodies.contacts_while(who, go_on))?;
        let number = |kind: Option<PairKind>| kind.map_or(u8::MAX, |kind| kind as u8);
        Ok((
            pairs(py, found.iter().map(|contact| contact.bodies)),
            pairs(py, found.iter().map(|contact| contact.triangles)),
            found.iter().map(|contact| number(contact.kind)).collect::<Vec<_>>().into_pyarray(py),
            points(py, found.iter().map(|contact| contact.point)),
        ))
    }

    /// The closest bodies, triangles, distance (metres) and points `(2, 3)`; None if no surfaces are within
    /// `within`.
    #[pyo3(signature = (within, *, one = None, others = None))]
    fn closest<'py>(
        &self,
        py: Python<'py>,
        within: f64,
        one: Option<u32>,
        others: Option<PyRef<'_, Bodies>>,
    ) -> PyResult<Option<GapRow<'py>>> {
        let ask = |bodies: &core::Bodies, who: Who<'_>, go_on: GoOn<'_>| bodies.closest_while(who, within, go_on);
        let found = self.ask(py, one, others.as_deref(), ask)?;
        Ok(found.map(|gap| (gap.bodies, gap.triangles, gap.distance, points(py, gap.points.into_iter()))))
    }

    /// The two bodies that meet, one of them solid, and are deepest in each other, and how deep, metres; None if
    /// there are none.
    #[pyo3(signature = (*, one = None, others = None))]
    fn deepest(
        &self,
        py: Python<'_>,
        one: Option<u32>,
        others: Option<PyRef<'_, Bodies>>,
    ) -> PyResult<Option<([u32; 2], f64)>> {
        let found = self.ask(py, one, others.as_deref(), contacts::deepest)?;
        Ok(found.map(|(pair, depth)| (pair, depth.depth)))
    }

    /// The shortest translation found that parts the second of two bodies from the first: `(3,)`, metres, world.
    #[pyo3(signature = (first, second, *, others = None))]
    fn depth<'py>(
        &self,
        py: Python<'py>,
        first: u32,
        second: u32,
        others: Option<PyRef<'_, Bodies>>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let found = self.ask(py, None, others.as_deref(), |bodies, who, go_on| {
            contacts::body_depth(bodies, who, [first, second], go_on)
        })?;
        Ok(found.translation.to_vec().into_pyarray(py))
    }

    fn __reduce__(&self) -> PyResult<()> {
        Err(stays("Bodies", "add them to a new set"))
    }
}

fn pairs<T: Element>(py: Python<'_>, rows: impl ExactSizeIterator<Item = [T; 2]>) -> Bound<'_, PyArray2<T>> {
    let count = rows.len();
    let flat: Vec<T> = rows.flatten().collect();
    Array2::from_shape_vec((count, 2), flat).expect("two numbers a row").into_pyarray(py)
}
