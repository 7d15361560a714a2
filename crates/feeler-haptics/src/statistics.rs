//! Statistics of a run: lateness and duration of ticks, duration of searches for contacts, age of constraints.
//!
//! Each thread counts into its own histograms, of fixed size, so that counting never allocates; a copy of them goes
//! through a triple buffer from time to time.

use hdrhistogram::Histogram;

use crate::constants::{HISTOGRAM_DIGITS, LONGEST_COUNTED_NS};

/// How a duration is spread.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
pub struct Distribution {
    /// Number of values.
    pub count: u64,
    /// Seconds, as all below; within one per cent.
    pub mean: f64,
    /// Half are not above it.
    pub median: f64,
    /// 90 % are not above it.
    pub p90: f64,
    /// 99 % are not above it.
    pub p99: f64,
    /// 99.9 % are not above it.
    pub p999: f64,
    /// The largest.
    pub max: f64,
}

/// A histogram of durations; values from a nanosecond to ten seconds, larger ones count as that.
#[derive(Debug, Clone)]
pub struct Durations {
    /// `None` where the library refuses its own constants.
    counts: Option<Histogram<u32>>,
}

impl Default for Durations {
    fn default() -> Durations {
        Durations { counts: Histogram::new_with_bounds(1, LONGEST_COUNTED_NS, HISTOGRAM_DIGITS).ok() }
    }
}

impl Durations {
    /// Counts a duration, seconds. NaN is ignored, values below zero count as zero. Allocates nothing.
    pub fn record(&mut self, seconds: f64) {
        if let (Some(counts), false) = (&mut self.counts, seconds.is_nan()) {
            counts.saturating_record((seconds.max(0.0) * 1e9).min(LONGEST_COUNTED_NS as f64) as u64);
        }
    }

    /// Becomes the same as another, without allocating.
    pub fn copy_from(&mut self, other: &Durations) {
        if let (Some(own), Some(counts)) = (&mut self.counts, &other.counts) {
            own.reset();
            // Both have the same bounds, so it has room.
            let _ = own.add(counts);
        }
    }

    /// The distribution so far.
    pub fn distribution(&self) -> Distribution {
        let Some(counts) = self.counts.as_ref().filter(|counts| !counts.is_empty()) else {
            return Distribution::default();
        };
        let at = |share: f64| counts.value_at_quantile(share) as f64 * 1e-9;
        Distribution {
            count: counts.len(),
            mean: counts.mean() * 1e-9,
            median: at(0.5),
            p90: at(0.9),
            p99: at(0.99),
            p999: at(0.999),
            max: counts.max() as f64 * 1e-9,
        }
    }
}

/// Counts of the servo thread.
#[derive(Debug, Clone, Default)]
pub struct ServoRecord {
    /// From when a tick was due to when it began.
    pub lateness: Durations,
    /// Of a tick, in the thread's CPU time if the clock reports it.
    pub tick: Durations,
    /// Of the constraints at each tick.
    pub age: Durations,
    /// Ticks done.
    pub ticks: u64,
    /// Ticks left out, since the one before was later than a period.
    pub misses: u64,
    /// Ticks without force because of a doubt.
    pub doubts: u64,
    /// Reads and writes that the device refused.
    pub device_errors: u64,
    /// Ticks that could not be kept in the trace, since nobody took it.
    pub trace_lost: u64,
    /// Seconds on the clock, of the first tick and the last.
    pub span: [f64; 2],
}

/// Counts of the collision thread.
#[derive(Debug, Clone, Default)]
pub struct CollisionRecord {
    /// Of a search for contacts and the motion to there.
    pub tick: Durations,
    /// Sets published.
    pub sets: u64,
    /// Motions tried.
    pub rounds: u64,
    /// Of these, stopped by the cast.
    pub stopped: u64,
    /// Searches that failed; the last set stays.
    pub errors: u64,
    /// Seconds on the clock, of the first search and the last.
    pub span: [f64; 2],
}

macro_rules! copies {
    ($record:ty: $($histogram:ident),*; $($number:ident),*) => {
        impl $record {
            /// Becomes the same as another, without allocating.
            pub fn copy_from(&mut self, other: &$record) {
                $(self.$histogram.copy_from(&other.$histogram);)*
                $(self.$number = other.$number;)*
            }
        }
    };
}

copies!(ServoRecord: lateness, tick, age; ticks, misses, doubts, device_errors, trace_lost, span);
copies!(CollisionRecord: tick; sets, rounds, stopped, errors, span);

/// A snapshot of a run.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
pub struct Statistics {
    /// From when a servo tick was due to when it began.
    pub servo_lateness: Distribution,
    /// Of a servo tick, in the thread's CPU time if the clock reports it.
    pub servo_tick: Distribution,
    /// Of the constraints, at the servo's ticks.
    pub age: Distribution,
    /// Of a search for contacts and the motion to there.
    pub collision_tick: Distribution,
    /// Servo ticks.
    pub ticks: u64,
    /// Servo ticks left out, since the one before was later than a period.
    pub misses: u64,
    /// Servo ticks without force because of a doubt.
    pub doubts: u64,
    /// Reads and writes that the device refused.
    pub device_errors: u64,
    /// Constraint sets published.
    pub sets: u64,
    /// Motions that the proxy tried.
    pub rounds: u64,
    /// Of these, stopped by the cast.
    pub stopped: u64,
    /// Searches for contacts that failed.
    pub collision_errors: u64,
    /// Ticks a second, over the whole run.
    pub servo_hz: f64,
    /// Searches a second, over the whole run. A thread without news rests, so it could be more: see `collision_tick`.
    pub collision_hz: f64,
}

impl Statistics {
    /// Of both threads.
    pub fn of(servo: &ServoRecord, collision: &CollisionRecord) -> Statistics {
        let rate = |count: u64, [from, to]: [f64; 2]| match to - from {
            span if span > 0.0 => count.saturating_sub(1) as f64 / span,
            _ => 0.0,
        };
        Statistics {
            servo_lateness: servo.lateness.distribution(),
            servo_tick: servo.tick.distribution(),
            age: servo.age.distribution(),
            collision_tick: collision.tick.distribution(),
            ticks: servo.ticks,
            misses: servo.misses,
            doubts: servo.doubts,
            device_errors: servo.device_errors,
            sets: collision.sets,
            rounds: collision.rounds,
            stopped: collision.stopped,
            collision_errors: collision.errors,
            servo_hz: rate(servo.ticks, servo.span),
            collision_hz: rate(collision.sets, collision.span),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn durations_are_told_within_a_per_cent() {
        let mut durations = Durations::default();
        for k in 1..=1000 {
            durations.record(f64::from(k) * 1e-6);
        }
        for odd in [f64::NAN, -1.0, f64::INFINITY] {
            durations.record(odd);
        }
        let found = durations.distribution();
        assert_eq!(found.count, 1002);
        assert!((found.median / 500e-6 - 1.0).abs() < 0.01, "{found:?}");
        assert!((found.p99 / 991e-6 - 1.0).abs() < 0.01, "{found:?}");
        assert!((found.max / 10.0 - 1.0).abs() < 0.01, "{found:?}");
        let mut copy = Durations::default();
        copy.record(5.0);
        copy.copy_from(&durations);
        assert_eq!(copy.distribution(), found);
    }

    #[test]
    fn nothing_counted_is_nothing() {
        assert_eq!(Durations::default().distribution(), Distribution::default());
        let none = Statistics::of(&ServoRecord::default(), &CollisionRecord::default());
        assert_eq!(none, Statistics::default());
    }
}
