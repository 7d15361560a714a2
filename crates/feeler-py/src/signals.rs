//! Ctrl-C during a call that takes long: the calling thread looks for signals while the interpreter's lock is released.
//!
//! Only long loops ask whether to go on, so a short call never looks. Work on a pool's threads with progress is in `reporter.rs`.

use std::any::Any;
use std::panic::{catch_unwind, resume_unwind, AssertUnwindSafe};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::{Duration, Instant};

use feeler_core::GoOn;
use pyo3::prelude::*;

use crate::pools::threads_of;

/// The longest time without a look for signals.
pub const SIGNALS_EVERY: Duration = Duration::from_millis(50);

/// Runs a query on the calling thread, without the interpreter's lock. Raises what a signal handler raises, as
/// `KeyboardInterrupt`; the query is stopped then.
pub fn stoppable<R: Send>(py: Python<'_>, query: impl FnOnce(GoOn<'_>) -> PyResult<R> + Send) -> PyResult<R> {
    let looks = Looks::default();
    let found = py.detach(|| {
        let goes_on = || looks.go_on();
        query(GoOn::new(&goes_on))
    });
    match looks.0.into_inner().unwrap_or_else(PoisonError::into_inner).raised {
        Some(raised) => Err(raised),
        None => found,
    }
}

#[derive(Default)]
struct Looks(Mutex<Look>);

#[derive(Default)]
struct Look {
    /// Set by the first question.
    next: Option<Instant>,
    raised: Option<PyErr>,
}

impl Looks {
    fn go_on(&self) -> bool {
        let mut look = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if look.raised.is_some() {
            return false;
        }
        let now = Instant::now();
        if now < *look.next.get_or_insert(now + SIGNALS_EVERY) {
            return true;
        }
        look.raised = Python::attach(|py| py.check_signals()).err();
        look.next = Some(Instant::now() + SIGNALS_EVERY);
        look.raised.is_none()
    }
}

/// Runs work that cannot be stopped on the threads of the process; called without the interpreter's lock. Raises what a signal
/// handler raises. The work is then left to itself: it goes on to its end, and nobody gets what it returns.
pub fn on_pool_or_left<R: Send + 'static>(work: impl FnOnce() -> R + Send + 'static) -> PyResult<R> {
    type Done<R> = Mutex<Option<Result<R, Box<dyn Any + Send>>>>;
    let shared: Arc<(Done<R>, Condvar)> = Arc::default();
    let of_work = Arc::clone(&shared);
    threads_of(None)?.spawn(move || {
        let done = catch_unwind(AssertUnwindSafe(work));
        *of_work.0.lock().unwrap_or_else(PoisonError::into_inner) = Some(done);
        of_work.1.notify_one();
    });
    loop {
        let done = shared.0.lock().unwrap_or_else(PoisonError::into_inner);
        let waited = shared.1.wait_timeout_while(done, SIGNALS_EVERY, |done| done.is_none());
        match waited.unwrap_or_else(PoisonError::into_inner).0.take() {
            Some(Ok(result)) => return Ok(result),
            Some(Err(panic)) => resume_unwind(panic),
            None => Python::attach(|py| py.check_signals())?,
        }
    }
}
