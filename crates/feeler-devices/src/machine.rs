//! Real time on a real system: a clock with absolute sleeps, thread priority, locked memory, and CPU time of a thread.
//! If the system refuses one of them, the reason is reported, and nothing else happens.

use std::time::Instant;

#[cfg(not(target_os = "linux"))]
use std::time::Duration;

use crate::constants::{COLLISION_PRIORITY, LONGEST_SLEEP_S, REALTIME_PRIORITY};

/// Seconds since it was made, by the machine's monotonic clock.
///
/// ```
/// let clock = feeler_devices::machine::MonotonicClock::new();
/// let next = clock.now() + 1e-3;
/// clock.sleep_until(next);
/// assert!(clock.now() >= next);
/// ```
#[derive(Debug, Clone, Copy)]
pub struct MonotonicClock {
    start: Instant,
    /// The same moment on the clock that sleeps are measured on, nanoseconds.
    #[cfg(target_os = "linux")]
    start_ns: i128,
}

impl MonotonicClock {
    /// Begins at 0 now.
    pub fn new() -> MonotonicClock {
        MonotonicClock {
            start: Instant::now(),
            #[cfg(target_os = "linux")]
            start_ns: linux::monotonic_ns(),
        }
    }

    /// Seconds since it was made.
    #[cfg(target_os = "linux")]
    pub fn now(&self) -> f64 {
        (linux::monotonic_ns() - self.start_ns) as f64 * 1e-9
    }

    /// Seconds since it was made.
    #[cfg(not(target_os = "linux"))]
    pub fn now(&self) -> f64 {
        self.start.elapsed().as_secs_f64()
    }

    /// When it was made.
    pub fn start(&self) -> Instant {
        self.start
    }

    /// Sleeps until a time of this clock, seconds; not at all if that is past or not a number, and at most an hour.
    ///
    /// On Linux the time is absolute (`TIMER_ABSTIME`), so delays between the call and the sleep do not add up.
    /// Elsewhere the thread sleeps for the remaining time.
    pub fn sleep_until(&self, t: f64) {
        if t.is_nan() {
            return;
        }
        let t = t.min(self.now() + LONGEST_SLEEP_S);
        if t <= self.now() {
            return;
        }
        #[cfg(target_os = "linux")]
        // Rounded up: who wakes has not to sleep again.
        linux::sleep_until_ns(self.start_ns + (t * 1e9).ceil() as i128);
        #[cfg(not(target_os = "linux"))]
        loop {
            let left = t - self.now();
            if left <= 0.0 {
                break;
            }
            std::thread::sleep(Duration::from_secs_f64(left));
        }
    }
}

impl feeler_haptics::Clock for MonotonicClock {
    fn now(&self) -> f64 {
        MonotonicClock::now(self)
    }

    fn sleep_until(&self, time: f64) {
        MonotonicClock::sleep_until(self, time);
    }

    fn thread_time(&self) -> Option<f64> {
        Some(thread_time())
    }
}

impl Default for MonotonicClock {
    fn default() -> MonotonicClock {
        MonotonicClock::new()
    }
}

/// Gives the calling thread real-time priority: first in, first out on Unix, time-critical on Windows. Returns what was
/// granted, or why nothing was, with advice.
pub fn raise_priority() -> Result<String, String> {
    priority::raise(REALTIME_PRIORITY)
}

/// The same below that: for a thread that a servo waits for nothing of, as one that finds contacts.
pub fn raise_priority_below_servo() -> Result<String, String> {
    priority::raise(COLLISION_PRIORITY)
}

/// Keeps the memory of this process from being paged out. Returns what was locked, or why nothing was, with advice.
/// Call it when everything needed is allocated: if the system limits locked memory, only present memory is locked,
/// since a lock on future memory would make later allocations fail.
pub fn lock_memory() -> Result<String, String> {
    #[cfg(target_os = "linux")]
    return linux::lock_memory();
    #[cfg(not(target_os = "linux"))]
    Err("memory can be locked on Linux only; close other programs so that nothing is paged out".to_string())
}

/// CPU time of the calling thread, seconds, for differences. If the system does not report it (Windows), the time since
/// the first call.
pub fn thread_time() -> f64 {
    #[cfg(unix)]
    {
        let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
        time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
    }
    #[cfg(not(unix))]
    {
        static START: std::sync::OnceLock<Instant> = std::sync::OnceLock::new();
        START.get_or_init(Instant::now).elapsed().as_secs_f64()
    }
}

#[cfg(unix)]
mod priority {
    use thread_priority::{
        set_thread_priority_and_policy, thread_native_id, Error, RealtimeThreadSchedulePolicy, ThreadPriority,
        ThreadPriorityValue, ThreadSchedulePolicy,
    };

    pub fn raise(priority: u8) -> Result<String, String> {
        let value = ThreadPriorityValue::try_from(priority)
            .map_err(|why| format!("no real-time priority {priority}: {why}"))?;
        let policy = ThreadSchedulePolicy::Realtime(RealtimeThreadSchedulePolicy::Fifo);
        match set_thread_priority_and_policy(thread_native_id(), ThreadPriority::Crossplatform(value), policy) {
            Ok(()) => Ok(format!("real-time priority {priority} (first in, first out)")),
            Err(error) => Err(format!(
                "no real-time priority ({}): run with CAP_SYS_NICE, or allow it with `rtprio {priority}` in \
                 /etc/security/limits.conf",
                reason(&error)
            )),
        }
    }

    fn reason(error: &Error) -> String {
        match error {
            Error::OS(code) => std::io::Error::from_raw_os_error(*code).to_string(),
            other => format!("{other:?}"),
        }
    }
}

#[cfg(windows)]
mod priority {
    use thread_priority::{set_current_thread_priority, ThreadPriority, ThreadPriorityValue};

    use crate::constants::REALTIME_PRIORITY;

    /// Of the numbers that the crate has for this system: above the normal, below the highest.
    const ABOVE_NORMAL: u8 = 70;

    pub fn raise(priority: u8) -> Result<String, String> {
        let (priority, name) = match ThreadPriorityValue::try_from(ABOVE_NORMAL) {
            Ok(value) if priority < REALTIME_PRIORITY => (ThreadPriority::Crossplatform(value), "raised"),
            _ => (ThreadPriority::Max, "time-critical"),
        };
        match set_current_thread_priority(priority) {
            Ok(()) => Ok(format!("{name} priority")),
            Err(error) => Err(format!("no {name} priority ({error:?}): run as an administrator")),
        }
    }
}

#[cfg(not(any(unix, windows)))]
mod priority {
    pub fn raise(_priority: u8) -> Result<String, String> {
        Err("this system has no real-time priorities".to_string())
    }
}

#[cfg(target_os = "linux")]
mod linux {
    use rustix::io::Errno;
    use rustix::mm::{mlockall, MlockAllFlags};
    use rustix::process::{getrlimit, Resource};
    use rustix::thread::clock_nanosleep_absolute;
    use rustix::time::{clock_gettime, ClockId, Timespec};

    const SECOND_NS: i128 = 1_000_000_000;

    pub fn monotonic_ns() -> i128 {
        let time = clock_gettime(ClockId::Monotonic);
        i128::from(time.tv_sec) * SECOND_NS + i128::from(time.tv_nsec)
    }

    pub fn sleep_until_ns(ns: i128) {
        let until = Timespec { tv_sec: (ns / SECOND_NS) as _, tv_nsec: (ns % SECOND_NS) as _ };
        // A signal wakes the thread early; any other error leaves nothing to wait for.
        while clock_nanosleep_absolute(ClockId::Monotonic, &until) == Err(Errno::INTR) {}
    }

    pub fn lock_memory() -> Result<String, String> {
        let limit = getrlimit(Resource::Memlock).current;
        let (flags, what) = match limit {
            None => (
                MlockAllFlags::CURRENT | MlockAllFlags::FUTURE,
                "all memory is locked, and what comes later".to_string(),
            ),
            Some(bytes) => (
                MlockAllFlags::CURRENT,
                format!("what is in memory now is locked; what comes later is not (limit {} kB)", bytes / 1024),
            ),
        };
        mlockall(flags).map(|()| what).map_err(|error| {
            format!(
                "memory is not locked ({}): run with CAP_IPC_LOCK, or allow it with `memlock unlimited` in \
                 /etc/security/limits.conf",
                std::io::Error::from(error)
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_clock_runs_on_and_sleeps_never_end_early() {
        let clock = MonotonicClock::new();
        let mut next = clock.now();
        for _ in 0..20 {
            next += 1e-3;
            clock.sleep_until(next);
            assert!(clock.now() >= next, "{} < {next}", clock.now());
        }
    }

    #[test]
    fn a_time_that_is_past_or_no_number_is_not_slept_for() {
        let clock = MonotonicClock::new();
        // Would the thread sleep, it would sleep for an hour.
        for t in [-1.0, 0.0, f64::NAN, f64::NEG_INFINITY] {
            clock.sleep_until(t);
        }
    }

    #[test]
    fn thread_time_grows_by_computing_and_not_by_sleeping() {
        let before = thread_time();
        let mut x = 1.0f64;
        while thread_time() < before + 1e-3 {
            x = std::hint::black_box(x * 1.000_001);
        }
        let computed = thread_time();
        std::thread::sleep(std::time::Duration::from_millis(200));
        // Sleeping costs next to nothing; a clock on the wall would say 0.2 s.
        assert!(cfg!(not(unix)) || thread_time() - computed < 0.1);
    }

    #[test]
    fn priority_is_granted_or_the_reason_is_said() {
        for raise in [raise_priority, raise_priority_below_servo] {
            match std::thread::spawn(raise).join().unwrap() {
                Ok(what) => assert!(what.contains("priority"), "{what}"),
                Err(why) => assert!(why.contains("priority") && why.len() > 40, "{why}"),
            }
        }
    }

    #[test]
    fn memory_is_locked_or_the_reason_is_said() {
        match lock_memory() {
            Ok(what) => assert!(what.contains("locked"), "{what}"),
            Err(why) => assert!(why.contains("locked") && why.len() > 40, "{why}"),
        }
    }
}
