//! Thread pools that belong to one process.
//!
//! A forked process has one thread, the one that forked: an inherited pool has no threads, and work given to it would
//! wait for ever. This also holds for rayon's global pool, which nothing here uses. Each pool is made anew in a forked
//! process.

use std::sync::atomic::{AtomicPtr, AtomicU64, Ordering};
use std::sync::Arc;

use feeler_devices::machine::MonotonicClock;
use feeler_haptics::Clock;
use once_cell::race::OnceBox;
use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::errors::raise;

/// Forks between the process that loaded this module and the present one.
static GENERATION: AtomicU64 = AtomicU64::new(0);

/// Counts forks from now on; called once, when the module is loaded.
pub fn watch_forks() {
    #[cfg(unix)]
    {
        extern "C" fn count() {
            GENERATION.fetch_add(1, Ordering::Relaxed);
        }
        // SAFETY: the function may run in a forked process: it only counts. Without memory for it no fork is noticed, as before.
        unsafe { libc::pthread_atfork(None, None, Some(count)) };
    }
}

/// Of this process: another in each that was forked since.
pub fn generation() -> u64 {
    GENERATION.load(Ordering::Relaxed)
}

/// The clock of all runs: a device that is used in several sees one time, in a forked process too.
pub fn machine_clock() -> Arc<dyn Clock> {
    static CLOCK: OnceBox<Arc<MonotonicClock>> = OnceBox::new();
    CLOCK.get_or_init(|| Box::new(Arc::new(MonotonicClock::new()))).clone()
}

/// What the threads of one process share, made when first asked for, and anew in each forked process. What the process before
/// it had is left alone: to drop it, its threads would be waited for.
pub struct PerProcess<T>(AtomicPtr<(u64, T)>);

impl<T: Send + Sync> PerProcess<T> {
    pub const fn new() -> PerProcess<T> {
        PerProcess(AtomicPtr::new(std::ptr::null_mut()))
    }

    pub fn get<E>(&self, make: impl Fn() -> Result<T, E>) -> Result<&T, E> {
        loop {
            let at = self.0.load(Ordering::Acquire);
            // SAFETY: null, or a box that is only freed when `self` is dropped.
            if let Some((born, made)) = unsafe { at.as_ref() } {
                if *born == generation() {
                    return Ok(made);
                }
            }
            let new = Box::into_raw(Box::new((generation(), make()?)));
            if self.0.compare_exchange(at, new, Ordering::AcqRel, Ordering::Acquire).is_err() {
                // SAFETY: made a moment ago, and nobody else has seen it.
                drop(unsafe { Box::from_raw(new) });
            }
        }
    }
}

impl<T> Drop for PerProcess<T> {
    fn drop(&mut self) {
        let at = *self.0.get_mut();
        // SAFETY: null, or a box that nobody else frees.
        if unsafe { at.as_ref() }.is_some_and(|(born, _)| *born == generation()) {
            // SAFETY: likewise.
            drop(unsafe { Box::from_raw(at) });
        }
    }
}

/// Threads for the work of a scene.
pub struct Pool {
    threads: usize,
    made: PerProcess<ThreadPool>,
}

/// Those for all else, as many as there are CPUs (or `RAYON_NUM_THREADS` says).
static DEFAULT: Pool = Pool::new(0);

impl Pool {
    /// Of so many threads; 0: as many as there are CPUs.
    pub const fn new(threads: usize) -> Pool {
        Pool { threads, made: PerProcess::new() }
    }

    fn threads(&self) -> PyResult<&ThreadPool> {
        self.made.get(|| {
            let builder = ThreadPoolBuilder::new().num_threads(self.threads).thread_name(|i| format!("feeler-{i}"));
            builder.build().map_err(|error| {
                let count = if self.threads == 0 { "its".to_string() } else { self.threads.to_string() };
                raise("OptionError", format!("cannot start {count} threads: {error}"))
            })
        })
    }
}

/// The threads of a pool, or of the process.
pub fn threads_of(pool: Option<&Pool>) -> PyResult<&ThreadPool> {
    pool.unwrap_or(&DEFAULT).threads()
}

/// Runs work that does not take long on the threads of a pool, or of the process; without the interpreter's lock. The thread that
/// asks is never one of a pool: those do not enter the interpreter (`reporter.rs`).
pub fn on_pool<R: Send>(pool: Option<&Pool>, work: impl FnOnce() -> R + Send) -> PyResult<R> {
    Ok(threads_of(pool)?.install(work))
}
