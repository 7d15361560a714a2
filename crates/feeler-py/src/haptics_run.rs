//! `feeler._core.HapticsRun`: a session running with a device, in threads that enter the interpreter only for a device
//! written in Python.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use feeler_devices::machine::{lock_memory, raise_priority, raise_priority_below_servo};
use feeler_haptics::runner::{MappingOptions, RunnerOptions, Stopped, ThreadKind, TraceTick, View};
use feeler_haptics::statistics::Distribution;
use feeler_haptics::{Error, Runner, Statistics};
use numpy::ndarray::{Array1, Array2, Array3};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArray3};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::arguments::PoseArgument;
use crate::errors::raise;
use crate::haptics::{haptics_to_py, name_of, numbers_of, started, HapticsSession, Started};
use crate::haptics_device::{matrix_of, HapticsDevice};
use crate::pools::{find_topology, generation, machine_clock, threads_of};
use crate::scene::Scene;
use crate::travel::stays;

/// What a thread was granted, or why not.
type Granted = Arc<Mutex<Option<Result<String, String>>>>;

/// One run of a session with a device.
#[pyclass(frozen, module = "feeler._core")]
pub struct HapticsRun {
    runner: Mutex<Option<Runner>>,
    session: Py<HapticsSession>,
    device: Py<HapticsDevice>,
    last: Mutex<Option<Statistics>>,
    /// Of the servo thread, and of the collision thread.
    priorities: [Granted; 2],
    memory: Option<Result<String, String>>,
    /// Of the process whose threads these are.
    born: u64,
}

fn locked<T>(of: &Mutex<T>) -> MutexGuard<'_, T> {
    of.lock().unwrap_or_else(PoisonError::into_inner)
}

fn distribution<'py>(py: Python<'py>, of: &Distribution) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("count", of.count)?;
    let seconds = [("mean", of.mean), ("median", of.median), ("p90", of.p90), ("p99", of.p99), ("p999", of.p999)];
    for (name, value) in seconds.into_iter().chain([("max", of.max)]) {
        dict.set_item(name, value)?;
    }
    Ok(dict)
}

fn statistics<'py>(py: Python<'py>, of: &Statistics) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    for (name, value) in [
        ("servo_lateness", &of.servo_lateness),
        ("servo_tick", &of.servo_tick),
        ("age", &of.age),
        ("collision_tick", &of.collision_tick),
    ] {
        dict.set_item(name, distribution(py, value)?)?;
    }
    for (name, value) in [
        ("ticks", of.ticks),
        ("misses", of.misses),
        ("doubts", of.doubts),
        ("device_errors", of.device_errors),
        ("sets", of.sets),
        ("rounds", of.rounds),
        ("stopped", of.stopped),
        ("collision_errors", of.collision_errors),
    ] {
        dict.set_item(name, value)?;
    }
    dict.set_item("servo_hz", of.servo_hz)?;
    dict.set_item("collision_hz", of.collision_hz)?;
    Ok(dict)
}

/// Numbers (point, normal, gap), parts and ids of the planes that hold.
type Held<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray1<u32>>, Bound<'py, PyArray1<u64>>);

fn held<'py>(py: Python<'py>, view: &View) -> Held<'py> {
    let planes = view.held();
    let number = |i: usize, j: usize| match j {
        0..3 => planes[i].point[j],
        3..6 => planes[i].normal[j - 3],
        _ => planes[i].gap,
    };
    (
        Array2::from_shape_fn((planes.len(), 7), |(i, j)| number(i, j)).into_pyarray(py),
        PyArray1::from_iter(py, planes.iter().map(|plane| plane.part)),
        PyArray1::from_iter(py, planes.iter().map(|plane| plane.id)),
    )
}

/// Times, devices' poses, proxies, wrenches, modes, and whether the device told something.
type Trace<'py> = (
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray3<f64>>,
    Bound<'py, PyArray3<f64>>,
    Bound<'py, PyArray2<f64>>,
    Vec<&'static str>,
    Bound<'py, PyArray1<bool>>,
);

fn poses(ticks: &[TraceTick], of: impl Fn(&TraceTick) -> [[f64; 4]; 4]) -> Array3<f64> {
    let all: Vec<_> = ticks.iter().map(of).collect();
    Array3::from_shape_fn((all.len(), 4, 4), |(n, i, j)| all[n][i][j])
}

impl HapticsRun {
    /// Of this process's threads; errors in a forked one.
    fn check_process(&self) -> PyResult<()> {
        if self.born == generation() {
            return Ok(());
        }
        let what = "this session ran in the process that this one was forked from: start another here";
        Err(raise("SessionError", what.into()))
    }

    fn with<R: Send>(&self, py: Python<'_>, work: impl FnOnce(&mut Runner) -> R + Send) -> PyResult<R> {
        self.check_process()?;
        py.detach(|| locked(&self.runner).as_mut().map(work)).ok_or_else(|| haptics_to_py(Error::Ended))
    }

    fn ask<R: Send>(
        &self,
        py: Python<'_>,
        what: impl FnOnce(&mut Runner) -> feeler_haptics::Result<R> + Send,
    ) -> PyResult<R> {
        self.with(py, what)?.map_err(haptics_to_py)
    }
}

#[pymethods]
impl HapticsRun {
    /// Starts the threads. Session and device are theirs until `stop`.
    #[new]
    #[allow(clippy::too_many_arguments, reason = "the Python method beside it has names and defaults for all")]
    fn new(
        py: Python<'_>,
        session: Py<HapticsSession>,
        device: Py<HapticsDevice>,
        rate_hz: f64,
        scale: f64,
        world_from_device: PoseArgument,
        is_absolute: bool,
        clutch_button: Option<u32>,
        is_realtime: bool,
    ) -> PyResult<HapticsRun> {
        let threads = threads_of(None)?;
        let priorities = [Granted::default(), Granted::default()];
        let told = priorities.clone();
        let on_thread_start = move |kind| match kind {
            _ if !is_realtime => (),
            ThreadKind::Servo => *locked(&told[0]) = Some(raise_priority()),
            ThreadKind::Collision => *locked(&told[1]) = Some(raise_priority_below_servo()),
        };
        let taken = session.get().take()?;
        let collision_hz = taken.options().collision_hz;
        let options = RunnerOptions {
            rate_hz,
            collision_hz,
            mapping: MappingOptions { scale, world_from_device: world_from_device.0, is_absolute, clutch_button },
            on_thread_start: Arc::new(on_thread_start),
            around_work: Arc::new(move |work| threads.install(work)),
        };
        let own = match device.get().take() {
            Ok(own) => own,
            Err(error) => {
                session.get().put_back(Some(taken));
                return Err(error);
            }
        };
        // Before the threads begin: the memory in use then is the memory that they need.
        let memory = is_realtime.then(lock_memory);
        match py.detach(|| Runner::start(taken, own, machine_clock(), &options)) {
            Ok(runner) => Ok(HapticsRun {
                runner: Mutex::new(Some(runner)),
                session,
                device,
                last: Mutex::new(None),
                priorities,
                memory,
                born: generation(),
            }),
            Err(refused) => {
                session.get().put_back(refused.session);
                device.get().put_back(refused.device, false);
                Err(haptics_to_py(refused.error))
            }
        }
    }

    /// Ends it. Returns the errors of the threads, and why device and contacts failed the last time.
    fn stop(&self, py: Python<'_>) -> PyResult<(Option<String>, Option<String>, Option<String>)> {
        self.check_process()?;
        let stopped = py.detach(|| locked(&self.runner).take().map(Runner::stop));
        let Some(Stopped { session, device, statistics, error, device_error, collision_error }) = stopped else {
            return Ok((None, None, None));
        };
        self.session.get().put_back(session);
        self.device.get().put_back(device, true);
        *locked(&self.last) = Some(statistics);
        let said = |error: Option<Error>| error.map(|error| error.to_string());
        Ok((said(error), device_error.map(|error| error.to_string()), said(collision_error)))
    }

    #[getter]
    fn is_running(&self) -> bool {
        self.born == generation() && locked(&self.runner).as_ref().is_some_and(Runner::is_running)
    }

    /// What the run took up to now, by name; after its end, all of it.
    fn statistics<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        self.check_process()?;
        let last = *locked(&self.last);
        match last {
            Some(last) => statistics(py, &last),
            None => statistics(py, &self.with(py, |runner| runner.watch().statistics())?),
        }
    }

    /// The newest tick, by name.
    fn view<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let view = self.with(py, |runner| *runner.watch().view())?;
        let dict = PyDict::new(py);
        dict.set_item("number", view.number)?;
        dict.set_item("time", view.time)?;
        dict.set_item("world_from_proxy", matrix_of(py, &view.proxy))?;
        dict.set_item("world_from_device", matrix_of(py, &view.device))?;
        dict.set_item("force", PyArray1::from_slice(py, &view.wrench.force))?;
        dict.set_item("torque", PyArray1::from_slice(py, &view.wrench.torque))?;
        dict.set_item("age", view.age)?;
        dict.set_item("mode", name_of(view.mode))?;
        dict.set_item("buttons", view.buttons)?;
        dict.set_item("is_clutched", view.is_clutched)?;
        dict.set_item("held", held(py, &view))?;
        Ok(dict)
    }

    /// Every tick since the last call, the newest 4 s at most.
    fn trace<'py>(&self, py: Python<'py>) -> PyResult<Trace<'py>> {
        let ticks = self.with(py, |runner| runner.watch().trace())?;
        let wrench = |n: usize, j: usize| match j {
            0..3 => ticks[n].wrench.force[j],
            _ => ticks[n].wrench.torque[j - 3],
        };
        Ok((
            Array1::from_iter(ticks.iter().map(|tick| tick.time)).into_pyarray(py),
            poses(&ticks, |tick| tick.device.matrix()).into_pyarray(py),
            poses(&ticks, |tick| tick.proxy.matrix()).into_pyarray(py),
            Array2::from_shape_fn((ticks.len(), 6), |(n, j)| wrench(n, j)).into_pyarray(py),
            ticks.iter().map(|tick| name_of(tick.mode)).collect(),
            PyArray1::from_iter(py, ticks.iter().map(|tick| tick.has_device)),
        ))
    }

    /// The numbers of the coupling in use, and what the device took away of the session's, a sentence each.
    fn coupling(&self, py: Python<'_>) -> PyResult<([f64; 8], Vec<String>)> {
        self.with(py, |runner| (numbers_of(runner.coupling()), runner.limitations_in_words()))
    }

    /// What priorities (of the servo and the collision thread) and memory were granted: whether, and in words; None where it was not
    /// asked for, or is not known yet.
    fn granted(&self) -> [Option<(bool, String)>; 3] {
        let said = |granted: Result<String, String>| match granted {
            Ok(what) => (true, what),
            Err(why) => (false, why),
        };
        let [servo, collision] = &self.priorities;
        [locked(servo).clone(), locked(collision).clone(), self.memory.clone()].map(|granted| granted.map(said))
    }

    /// Begins anew at a pose: what it meets there.
    fn begin(&self, py: Python<'_>, pose: PoseArgument) -> PyResult<Started> {
        self.ask(py, |runner| runner.begin(&pose.0)).map(started)
    }

    /// Puts another scene in the place of the present one: what the proxy meets there.
    fn set_scene(&self, py: Python<'_>, scene: PyRef<'_, Scene>) -> PyResult<Started> {
        self.check_process()?;
        let scene = scene.core();
        let tool = self.session.get().tool().clone();
        py.detach(|| find_topology(scene.mockup(), &tool, true))?;
        self.ask(py, |runner| runner.set_scene(scene)).map(started)
    }

    fn take(&self, py: Python<'_>, parts: Vec<u32>) -> PyResult<()> {
        self.ask(py, |runner| runner.take(&parts))
    }

    fn put_down(&self, py: Python<'_>) -> PyResult<()> {
        self.ask(py, |runner| runner.put_down())
    }

    fn put_back(&self, py: Python<'_>) -> PyResult<()> {
        self.ask(py, |runner| runner.put_back())
    }

    fn __reduce__(&self) -> PyResult<()> {
        Err(stays("HapticsRun", "its threads are of this process"))
    }
}

impl Drop for HapticsRun {
    fn drop(&mut self) {
        let Some(runner) = self.runner.get_mut().unwrap_or_else(PoisonError::into_inner).take() else { return };
        if self.born != generation() {
            // The threads are of another process, which lets go of the force itself: to end them here, they would be waited for.
            std::mem::forget(runner);
        } else {
            // Its servo thread may be in the interpreter, for a device that is an object of Python, and so ends while this one lets
            // others in.
            Python::attach(|py| py.detach(|| drop(runner)));
        }
    }
}
