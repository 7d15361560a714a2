//! `feeler._core.HapticsSession`, the base of `feeler.haptics.Session`.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use feeler_core as core;
use feeler_haptics::{Coupling, Error, Mode, PutDown, Session, SessionOptions, Start, Step};
use numpy::ndarray::Array2;
use numpy::{IntoPyArray, PyArray1, PyArray2};
use pyo3::prelude::*;

use crate::arguments::{PoseArgument, ToolArgument};
use crate::errors::{raise, to_py};
use crate::pools::{find_topology, on_pool};
use crate::scene::Scene;
use crate::travel::stays;
use crate::world::kind_name;

/// One session; `feeler.haptics.Session` adds names and records.
#[pyclass(subclass, frozen, module = "feeler._core")]
pub struct HapticsSession {
    /// `None` while it runs, and after a run whose thread failed.
    session: Mutex<Option<Session>>,
    tool: Arc<core::Tool>,
}

/// The Python exception for an error of the haptics.
pub fn haptics_to_py(error: Error) -> PyErr {
    let class = match error {
        Error::Core(error) => return to_py(error),
        Error::Option { .. } => "OptionError",
        _ => "SessionError",
    };
    raise(class, error.to_string())
}

/// The eight numbers of a coupling, in the order of its fields.
fn coupling_of([k, d, rk, rd, force, torque, slew, rslew]: [f64; 8]) -> Coupling {
    Coupling {
        stiffness_n_per_m: k,
        damping_n_s_per_m: d,
        rotational_stiffness_nm_per_rad: rk,
        rotational_damping_nm_s_per_rad: rd,
        max_force_n: force,
        max_torque_nm: torque,
        slew_n_per_s: slew,
        slew_nm_per_s: rslew,
    }
}

/// The reverse.
pub fn numbers_of(coupling: &Coupling) -> [f64; 8] {
    [
        coupling.stiffness_n_per_m,
        coupling.damping_n_s_per_m,
        coupling.rotational_stiffness_nm_per_rad,
        coupling.rotational_damping_nm_s_per_rad,
        coupling.max_force_n,
        coupling.max_torque_nm,
        coupling.slew_n_per_s,
        coupling.slew_nm_per_s,
    ]
}

pub fn name_of(mode: Mode) -> &'static str {
    match mode {
        Mode::Free => "free",
        Mode::Contact => "contact",
        Mode::Bound => "bound",
        Mode::Doubt => "doubt",
    }
}

/// Pose, force, torque, age and mode.
type StepParts<'py> =
    (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<f64>>, f64, &'static str);

/// Numbers (point, normal, gap), parts, ids and whether each holds.
type PlaneParts<'py> =
    (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray1<u32>>, Bound<'py, PyArray1<u64>>, Bound<'py, PyArray1<bool>>);

fn parts_of<'py>(py: Python<'py>, step: &Step) -> StepParts<'py> {
    let matrix = step.proxy.matrix();
    let pose = Array2::from_shape_fn((4, 4), |(i, j)| matrix[i][j]).into_pyarray(py);
    let [force, torque] = [step.wrench.force, step.wrench.torque].map(|v| PyArray1::from_slice(py, &v));
    (pose, force, torque, step.age, name_of(step.mode))
}

/// The newest planes, nearest first.
fn planes_of<'py>(py: Python<'py>, session: &Session) -> PlaneParts<'py> {
    let planes = session.constraints().map_or(&[][..], |set| set.planes());
    let held: Vec<u64> = session.held().map(|plane| plane.id).collect();
    let number = |i: usize, j: usize| match j {
        0..3 => planes[i].point[j],
        3..6 => planes[i].normal[j - 3],
        _ => planes[i].gap,
    };
    (
        Array2::from_shape_fn((planes.len(), 7), |(i, j)| number(i, j)).into_pyarray(py),
        PyArray1::from_iter(py, planes.iter().map(|plane| plane.part)),
        PyArray1::from_iter(py, planes.iter().map(|plane| plane.id)),
        PyArray1::from_iter(py, planes.iter().map(|plane| held.contains(&plane.id))),
    )
}

impl HapticsSession {
    fn locked(&self) -> MutexGuard<'_, Option<Session>> {
        self.session.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The session, for a run.
    pub fn take(&self) -> PyResult<Session> {
        self.locked().take().ok_or_else(is_away)
    }

    /// The session after a run.
    pub fn put_back(&self, session: Option<Session>) {
        *self.locked() = session;
    }

    /// Without a part that it holds.
    pub fn tool(&self) -> &Arc<core::Tool> {
        &self.tool
    }

    fn with<R>(&self, work: impl FnOnce(&mut Session) -> R) -> PyResult<R> {
        self.locked().as_mut().map(work).ok_or_else(is_away)
    }

    /// Work that may need the threads of the process, as a grip on a large part does.
    fn change<R: Send>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&mut Session) -> feeler_haptics::Result<R> + Send,
    ) -> PyResult<R> {
        py.detach(|| on_pool(None, || self.locked().as_mut().map(work)))?.ok_or_else(is_away)?.map_err(haptics_to_py)
    }
}

/// What a start met: for each pair of parts that of the tool, that of the mock-up, how they meet and how deep (metres); and the
/// translation out, where the tool is sunk.
pub type Started = (Vec<(u32, u32, &'static str, f64)>, Option<core::Point>);

/// What a start met.
pub fn started(start: Start) -> Started {
    let Start::Seated(seating) = start else { return (Vec::new(), None) };
    let seats = seating.seats.iter().map(|seat| (seat.tool_part, seat.part, kind_name(seat.kind), seat.depth));
    (seats.collect(), seating.way_out.map(|out| out.translation))
}

fn is_away() -> PyErr {
    raise("SessionError", "the session runs, or its run failed: stop it first, or make another".into())
}

#[pymethods]
impl HapticsSession {
    /// `put_down`: parts of the scene's mock-up that lie elsewhere, each with a scene of that part alone.
    #[new]
    #[allow(clippy::too_many_arguments, reason = "the Python class beside it has names and defaults for all")]
    fn new(
        py: Python<'_>,
        scene: PyRef<'_, Scene>,
        tool: ToolArgument<'_, '_>,
        coupling: [f64; 8],
        margin: f64,
        skin: f64,
        shading: bool,
        collision_hz: Option<f64>,
        put_down: Vec<(u32, PyRef<'_, Scene>)>,
    ) -> PyResult<HapticsSession> {
        let mut options =
            SessionOptions { coupling: coupling_of(coupling), shading, collision_hz, ..Default::default() };
        (options.proxy.margin, options.proxy.skin) = (margin, skin);
        let (scene, tool) = (scene.core(), Arc::clone(tool.core()));
        let put_down: Vec<PutDown> =
            put_down.iter().map(|(part, scene)| PutDown { part: *part, scene: scene.core() }).collect();
        py.detach(|| {
            let mut scenes = std::iter::once(&scene).chain(put_down.iter().map(|part| &part.scene));
            scenes.try_for_each(|scene| find_topology(scene.mockup(), &tool, true))
        })?;
        let session = Session::with_put_down(scene, tool.clone(), put_down, options).map_err(haptics_to_py)?;
        Ok(HapticsSession { session: Mutex::new(Some(session)), tool })
    }

    /// Begins at a pose: its seats, as tool part, part, kind and depth (metres); and the way out if sunk.
    #[pyo3(name = "_begin")]
    fn begin(&self, py: Python<'_>, pose: PoseArgument) -> PyResult<Started> {
        self.change(py, |session| session.start(&pose.0)).map(started)
    }

    /// One step: the proxy's pose `(4, 4)`, force and torque `(3,)`, age of the constraints (seconds), and mode.
    #[pyo3(signature = (pose, dt))]
    #[pyo3(name = "_advance")]
    fn advance<'py>(&self, py: Python<'py>, pose: Option<PoseArgument>, dt: f64) -> PyResult<StepParts<'py>> {
        let step = py.detach(|| self.locked().as_mut().map(|session| session.step(pose.as_ref().map(|p| &p.0), dt)));
        let step = step.ok_or_else(is_away)?.map_err(haptics_to_py)?;
        Ok(parts_of(py, &step))
    }

    /// The newest planes, nearest first: `(k, 7)` point, normal and gap; parts, ids, and whether each is active.
    #[pyo3(name = "_planes")]
    fn planes<'py>(&self, py: Python<'py>) -> PyResult<PlaneParts<'py>> {
        self.with(|session| planes_of(py, session))
    }

    /// Changes the scene: the seats of the proxy there, as `_begin`.
    #[pyo3(name = "_swap")]
    fn swap(&self, py: Python<'_>, scene: PyRef<'_, Scene>) -> PyResult<Started> {
        let scene = scene.core();
        py.detach(|| find_topology(scene.mockup(), &self.tool, true))?;
        let start = self.change(py, |session| session.set_scene(scene))?;
        Ok(started(start))
    }

    #[pyo3(name = "_take")]
    fn grip(&self, py: Python<'_>, parts: Vec<u32>) -> PyResult<()> {
        self.change(py, |session| session.take(&parts))
    }

    #[pyo3(name = "_put_down")]
    fn put_down(&self, py: Python<'_>) -> PyResult<()> {
        self.change(py, Session::put_down)
    }

    #[pyo3(name = "_put_back")]
    fn put_part_back(&self, py: Python<'_>) -> PyResult<()> {
        self.change(py, Session::put_back)
    }

    /// The parts that are held.
    #[getter(_held_parts)]
    fn held_parts(&self) -> PyResult<Vec<u32>> {
        self.with(|session| session.world().grips().iter().map(|grip| grip.part).collect())
    }

    /// Parts that were put down elsewhere, sorted.
    #[getter(_moved_parts)]
    fn moved_parts<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<u32>>> {
        let mut parts: Vec<u32> = self.with(|session| session.world().moved().collect())?;
        parts.sort_unstable();
        Ok(PyArray1::from_vec(py, parts))
    }

    /// Motions tried in the last search for contacts, and those stopped by the cast.
    #[getter(_last_rounds)]
    fn last_rounds(&self) -> PyResult<(usize, usize)> {
        let advance = self.with(|session| session.last_advance())?;
        Ok((advance.rounds, advance.stopped))
    }

    fn __reduce__(&self) -> PyResult<()> {
        Err(stays("Session", "make it anew; feeler.haptics.replay runs a record of it again"))
    }
}
