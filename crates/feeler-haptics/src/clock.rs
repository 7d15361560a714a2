//! The clock of the threads: this crate reads none; the caller passes one in.

/// A clock that runs on, and that threads sleep by.
pub trait Clock: Send + Sync {
    /// Seconds since some moment; never less than before.
    fn now(&self) -> f64;

    /// Sleeps until an absolute time of this clock, seconds; not at all where that is past.
    fn sleep_until(&self, time: f64);

    /// Seconds that the calling thread has computed, for differences; `None` where nobody tells.
    fn thread_time(&self) -> Option<f64> {
        None
    }
}
