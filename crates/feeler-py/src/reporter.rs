//! Progress of long work on a pool, reported to Python by the calling thread.
//!
//! Threads of a pool never enter the interpreter: for each visit it makes them a thread state, under a lock that a fork
//! at that moment would leave locked in the child for good. Nor could they receive Ctrl-C, which goes to the main
//! thread.

use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;

use crate::pools::{threads_of, Pool};
use crate::signals::SIGNALS_EVERY;

/// Calls a Python progress function and looks for signals (Ctrl-C); keeps the exception that either raises, and stops the
/// work then.
pub struct Reporter {
    callback: Option<Py<PyAny>>,
    state: Mutex<State>,
    changed: Condvar,
    /// Whether `state.raised` is set: asked without the lock by many threads.
    has_raised: AtomicBool,
}

#[derive(Default)]
struct State {
    /// What the work told and Python has not heard.
    told: VecDeque<(f64, String)>,
    raised: Option<PyErr>,
    is_done: bool,
}

impl Reporter {
    pub fn new(callback: Option<Py<PyAny>>) -> Reporter {
        Reporter { callback, state: Mutex::default(), changed: Condvar::new(), has_raised: AtomicBool::new(false) }
    }

    /// Runs work on the threads of a pool, or of the process, and passes on meanwhile what it tells; without the interpreter's lock.
    pub fn watch<R: Send>(&self, pool: Option<&Pool>, work: impl FnOnce() -> R + Send) -> PyResult<R> {
        let pool = threads_of(pool)?;
        let mut result = None;
        pool.in_place_scope(|scope| {
            let result = &mut result;
            scope.spawn(move |_| {
                let _done = Done(self);
                *result = Some(work());
            });
            self.pass_on();
        });
        Ok(result.expect("the scope ends with its work, or panics with it"))
    }

    /// Called by the work, on any thread. Whether to go on.
    pub fn tell(&self, done: f64, stage: &str) -> bool {
        let mut state = self.state();
        if state.raised.is_some() {
            return false;
        }
        if self.callback.is_some() {
            state.told.push_back((done, stage.to_owned()));
            self.changed.notify_one();
        }
        true
    }

    /// Whether Python raised, so that the work should end.
    pub fn has_raised(&self) -> bool {
        self.has_raised.load(Relaxed)
    }

    pub fn finish(self) -> PyResult<()> {
        let state = self.state.into_inner().unwrap_or_else(PoisonError::into_inner);
        state.raised.map_or(Ok(()), Err)
    }

    /// The same of work that is worth having where Ctrl-C stopped it: whether that did.
    pub fn finish_interrupted(self) -> PyResult<bool> {
        match self.finish() {
            Err(error) if Python::attach(|py| error.is_instance_of::<PyKeyboardInterrupt>(py)) => Ok(true),
            finished => finished.map(|()| false),
        }
    }

    /// Until the work is done and all it told is heard, or Python raised.
    fn pass_on(&self) {
        loop {
            let mut state = self.state();
            if state.told.is_empty() && !state.is_done {
                let woken = self.changed.wait_timeout(state, SIGNALS_EVERY);
                state = woken.unwrap_or_else(PoisonError::into_inner).0;
            }
            let told = state.told.pop_front();
            if told.is_none() && state.is_done {
                return;
            }
            drop(state);
            let heard = Python::attach(|py| {
                py.check_signals()?;
                match (&self.callback, told) {
                    (Some(callback), Some((done, stage))) => callback.call1(py, (done, stage)).map(drop),
                    _ => Ok(()),
                }
            });
            if let Err(error) = heard {
                self.state().raised = Some(error);
                self.has_raised.store(true, Relaxed);
                return;
            }
        }
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Says that the work is done, also where it panics.
struct Done<'a>(&'a Reporter);

impl Drop for Done<'_> {
    fn drop(&mut self) {
        self.0.state().is_done = true;
        self.0.changed.notify_one();
    }
}
