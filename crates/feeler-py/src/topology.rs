//! The topology of meshes, computed on first use: which triangles share an edge, which surfaces are closed.

use std::sync::{Arc, Condvar, Mutex, PoisonError};

use feeler_core::{Mockup, Tool};
use pyo3::prelude::*;

use crate::pools::PerProcess;
use crate::signals::{on_pool_or_left, SIGNALS_EVERY};

/// Finds the topology of both meshes, which contacts need, unless it is known; for `escape` also the paths between the tool's
/// surfaces. Called without the interpreter's lock. One thread has it found on the pool of the process, and the others wait; a forked
/// process does not wait for threads that it does not have. After Ctrl-C the work goes on, and the next call gets its result.
pub fn find_topology(mockup: &Arc<Mockup>, tool: &Arc<Tool>, escape: bool) -> PyResult<()> {
    static FINDER: PerProcess<Finder> = PerProcess::new();
    let is_found = || {
        let [adjacency, links] = tool.has_topology();
        mockup.has_adjacency() && adjacency && (links || !escape)
    };
    if is_found() {
        return Ok(());
    }
    let finder = FINDER.get(|| Ok::<_, PyErr>(Finder::default()))?;
    let turn = finder.turn()?;
    if is_found() {
        return Ok(());
    }
    let (mockup, tool) = (Arc::clone(mockup), Arc::clone(tool));
    on_pool_or_left(move || {
        let _turn = turn;
        mockup.adjacency();
        tool.adjacency();
        if escape {
            tool.links();
        }
    })
}

/// Lets one thread at a time find what several ask for.
#[derive(Default)]
struct Finder {
    is_busy: Mutex<bool>,
    changed: Condvar,
}

impl Finder {
    /// Waits until nobody else has the turn, or a signal handler raises.
    fn turn(&'static self) -> PyResult<Turn> {
        let mut is_busy = self.is_busy.lock().unwrap_or_else(PoisonError::into_inner);
        loop {
            if !std::mem::replace(&mut *is_busy, true) {
                return Ok(Turn(self));
            }
            let waited = self.changed.wait_timeout(is_busy, SIGNALS_EVERY);
            drop(waited.unwrap_or_else(PoisonError::into_inner));
            Python::attach(|py| py.check_signals())?;
            is_busy = self.is_busy.lock().unwrap_or_else(PoisonError::into_inner);
        }
    }
}

/// Gives the turn to the next thread when dropped.
struct Turn(&'static Finder);

impl Drop for Turn {
    fn drop(&mut self) {
        *self.0.is_busy.lock().unwrap_or_else(PoisonError::into_inner) = false;
        self.0.changed.notify_one();
    }
}
