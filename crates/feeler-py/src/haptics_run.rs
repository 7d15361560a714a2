//! `feeler._core.HapticsRun`: a session running with a device, in threads that enter the interpreter only for a device
//! written in Python.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use feeler_devices::machine::{lock_memory, raise_priority, raise_priority_below_servo};
use feeler_haptics::{Error, Guide, MappingOptions, Runner, RunnerOptions, Statistics, Stopped, ThreadKind, TraceTick};
use pyo3::prelude::*;

use crate::arguments::PoseArgument;
use crate::errors::raise;
use crate::haptics::{haptics_to_py, numbers_of, release_of, HapticsSession};
use crate::haptics_answers::{GrantedAnswer, RunEnd, StartAnswer, StatisticsAnswer, TickAnswer, TraceAnswer};
use crate::haptics_device::HapticsDevice;
use crate::pools::{generation, machine_clock, threads_of};
use crate::scene::Scene;
use crate::topology::find_topology;
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
    /// The ticks of an ended run that nobody has taken.
    rest: Mutex<Vec<TraceTick>>,
    /// Of the servo thread, and of the collision thread.
    priorities: [Granted; 2],
    memory: Option<Result<String, String>>,
    /// Of the process whose threads these are.
    born: u64,
}

fn locked<T>(of: &Mutex<T>) -> MutexGuard<'_, T> {
    of.lock().unwrap_or_else(PoisonError::into_inner)
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
        let options = RunnerOptions::default()
            .with_rate_hz(rate_hz)
            .with_collision_hz(collision_hz)
            .with_mapping(
                MappingOptions::default()
                    .with_scale(scale)
                    .with_world_from_device(world_from_device.0)
                    .with_is_absolute(is_absolute)
                    .with_clutch_button(clutch_button),
            )
            .with_on_thread_start(on_thread_start)
            .with_around_work(move |work| threads.install(work));
        let own = match device.get().take() {
            Ok(own) => own,
            Err(error) => {
                session.get().put_back(Some(taken));
                return Err(error);
            }
        };
        // Before the threads begin: the memory in use then is the memory that they need.
        let memory = is_realtime.then(lock_memory);
        match py.detach(|| Runner::run(taken, own, machine_clock(), &options)) {
            Ok(runner) => Ok(HapticsRun {
                runner: Mutex::new(Some(runner)),
                session,
                device,
                last: Mutex::new(None),
                rest: Mutex::new(Vec::new()),
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

    /// Ends it.
    fn stop(&self, py: Python<'_>) -> PyResult<RunEnd> {
        self.check_process()?;
        let stopped = py.detach(|| locked(&self.runner).take().map(Runner::stop));
        let Some(Stopped { session, device, statistics, trace, error, device_error, collision_error, .. }) = stopped
        else {
            return Ok(RunEnd::default());
        };
        self.session.get().put_back(session);
        self.device.get().put_back(device, true);
        (*locked(&self.last), *locked(&self.rest)) = (Some(statistics), trace);
        let said = |error: Option<Error>| error.map(|error| error.to_string());
        let device_error = device_error.map(|error| error.to_string());
        Ok(RunEnd { error: said(error), device_error, collision_error: said(collision_error) })
    }

    #[getter]
    fn is_running(&self) -> bool {
        self.born == generation() && locked(&self.runner).as_ref().is_some_and(Runner::is_running)
    }

    /// The run up to now; after its end, all of it.
    fn statistics(&self, py: Python<'_>) -> PyResult<StatisticsAnswer> {
        self.check_process()?;
        let last = *locked(&self.last);
        match last {
            Some(last) => StatisticsAnswer::new(py, &last),
            None => StatisticsAnswer::new(py, &self.with(py, |runner| runner.watch().statistics())?),
        }
    }

    /// The newest tick.
    fn view(&self, py: Python<'_>) -> PyResult<TickAnswer> {
        let view = self.with(py, |runner| *runner.watch().view())?;
        Ok(TickAnswer::new(py, &view))
    }

    /// Draws the tool to a pose, with a pull besides; None: nothing draws it.
    fn guide(&self, py: Python<'_>, place: Option<PoseArgument>, pull: [f64; 3]) -> PyResult<()> {
        let guide = place.map(|place| Guide { place: place.0, pull });
        self.with(py, |runner| runner.watch().guide(guide))
    }

    /// Every tick since the last call, 4 s at most; after the end of the run, those that are left.
    fn trace(&self, py: Python<'_>) -> PyResult<TraceAnswer> {
        self.check_process()?;
        let running = py.detach(|| locked(&self.runner).as_mut().map(|runner| runner.watch().trace()));
        let ticks = running.unwrap_or_else(|| std::mem::take(&mut *locked(&self.rest)));
        Ok(TraceAnswer::new(py, &ticks))
    }

    /// What was granted so far.
    fn granted(&self, py: Python<'_>) -> PyResult<GrantedAnswer> {
        let (coupling, limitations) =
            self.with(py, |runner| (numbers_of(runner.coupling()), runner.limitations_in_words()))?;
        let said = |granted: Option<Result<String, String>>| match granted {
            Some(Ok(what)) => (what, true),
            Some(Err(why)) => (why, false),
            None => (String::new(), false),
        };
        let [servo, collision] = &self.priorities;
        let (priority, has_priority) = said(locked(servo).clone());
        let (collision_priority, has_collision_priority) = said(locked(collision).clone());
        let (memory, is_locked) = said(self.memory.clone());
        Ok(GrantedAnswer {
            priority,
            has_priority,
            collision_priority,
            has_collision_priority,
            memory,
            is_locked,
            coupling,
            limitations,
        })
    }

    /// Begins anew at a pose: what it meets there.
    fn start(&self, py: Python<'_>, pose: PoseArgument) -> PyResult<StartAnswer> {
        let start = self.ask(py, |runner| runner.start(&pose.0))?;
        StartAnswer::new(py, start)
    }

    /// Puts another scene in the place of the present one: what the proxy meets there.
    fn set_scene(&self, py: Python<'_>, scene: PyRef<'_, Scene>) -> PyResult<StartAnswer> {
        self.check_process()?;
        let scene = scene.core();
        let tool = self.session.get().tool().clone();
        py.detach(|| find_topology(scene.mockup(), &tool, true))?;
        let start = self.ask(py, |runner| runner.set_scene(scene))?;
        StartAnswer::new(py, start)
    }

    fn grip(&self, py: Python<'_>, parts: Vec<u32>) -> PyResult<()> {
        self.ask(py, |runner| runner.grip(&parts))
    }

    fn release(&self, py: Python<'_>, put_back: bool) -> PyResult<()> {
        self.ask(py, |runner| runner.release(release_of(put_back)))
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
