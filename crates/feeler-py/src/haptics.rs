//! `feeler._core.HapticsSession`, the base of `feeler.haptics.Session`.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use feeler_core as core;
use feeler_haptics::{Coupling, Error, PutDown, Release, Session, SessionOptions};
use numpy::{PyArray1, PyReadonlyArray2};
use pyo3::prelude::*;

use crate::arguments::{pose_of, PoseArgument, ToolArgument};
use crate::errors::{raise, to_py};
use crate::haptics_answers::{StartAnswer, StepAnswer};
use crate::pools::on_pool;
use crate::scene::Scene;
use crate::topology::find_topology;
use crate::travel::stays;

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
    Coupling::default()
        .with_stiffness_n_per_m(k)
        .with_damping_n_s_per_m(d)
        .with_rotational_stiffness_nm_per_rad(rk)
        .with_rotational_damping_nm_s_per_rad(rd)
        .with_max_force_n(force)
        .with_max_torque_nm(torque)
        .with_slew_n_per_s(slew)
        .with_slew_nm_per_s(rslew)
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

/// Where `release(put_back)` has the parts go.
pub fn release_of(put_back: bool) -> Release {
    if put_back {
        Release::PutBack
    } else {
        Release::Here
    }
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
        let mut options = SessionOptions::default()
            .with_coupling(coupling_of(coupling))
            .with_shading(shading)
            .with_collision_hz(collision_hz);
        (options.proxy.margin, options.proxy.skin) = (margin, skin);
        let (scene, tool) = (scene.core(), Arc::clone(tool.core()));
        let put_down: Vec<PutDown> = put_down.iter().map(|(part, scene)| PutDown::new(*part, scene.core())).collect();
        py.detach(|| {
            let mut scenes = std::iter::once(&scene).chain(put_down.iter().map(|part| &part.scene));
            scenes.try_for_each(|scene| find_topology(scene.mockup(), &tool, true))
        })?;
        let session = Session::with_put_down(scene, tool.clone(), put_down, options).map_err(haptics_to_py)?;
        Ok(HapticsSession { session: Mutex::new(Some(session)), tool })
    }

    /// Begins at a pose.
    #[pyo3(name = "_begin")]
    fn begin(&self, py: Python<'_>, pose: PoseArgument) -> PyResult<StartAnswer> {
        let start = self.change(py, |session| session.start(&pose.0))?;
        StartAnswer::new(py, start)
    }

    /// One step of `dt` seconds; a pose `(4, 4)` that is not rigid is in doubt.
    #[pyo3(signature = (pose, dt))]
    #[pyo3(name = "_advance")]
    fn advance(&self, py: Python<'_>, pose: PyReadonlyArray2<'_, f64>, dt: f64) -> PyResult<StepAnswer> {
        let pose = pose_of(&pose.as_array()).ok();
        let step = py.detach(|| self.locked().as_mut().map(|session| session.step(pose.as_ref(), dt)));
        let step = step.ok_or_else(is_away)?.map_err(haptics_to_py)?;
        self.with(|session| StepAnswer::new(py, &step, session))
    }

    /// Changes the scene: the seats of the proxy there.
    #[pyo3(name = "_swap")]
    fn swap(&self, py: Python<'_>, scene: PyRef<'_, Scene>) -> PyResult<StartAnswer> {
        let scene = scene.core();
        py.detach(|| find_topology(scene.mockup(), &self.tool, true))?;
        let start = self.change(py, |session| session.set_scene(scene))?;
        StartAnswer::new(py, start)
    }

    #[pyo3(name = "_grip")]
    fn grip(&self, py: Python<'_>, parts: Vec<u32>) -> PyResult<()> {
        self.change(py, |session| session.grip(&parts))
    }

    #[pyo3(name = "_release")]
    fn release(&self, py: Python<'_>, put_back: bool) -> PyResult<()> {
        self.change(py, |session| session.release(release_of(put_back)))
    }

    /// The parts that are held.
    #[getter(_gripped)]
    fn gripped(&self) -> PyResult<Vec<u32>> {
        self.with(|session| session.gripped().collect())
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
