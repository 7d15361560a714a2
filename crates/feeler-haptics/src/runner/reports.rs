//! How often a device reports, and how late: measured, whatever it says of itself.

use crate::constants::{RATE_MEMORY_S, RATE_RETURN_S, SILENCE_MEMORY_S};

/// The mean time between a device's states, and their mean age when they come, over the last moments.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Reports {
    /// Of the newest state: when it was measured, and when it came; seconds on the caller's clock.
    newest: Option<[f64; 2]>,
    mean_s: f64,
    late_s: f64,
    /// Longer gaps are silence, in which there is no force.
    silent_s: f64,
    /// When the last silence ended.
    spoke_again: f64,
}

impl Reports {
    /// `between_s`: the time between two states until some have come. `silent_s`: from when on the device counts as silent.
    pub fn new(between_s: f64, silent_s: f64) -> Reports {
        Reports { newest: None, mean_s: between_s, late_s: 0.0, silent_s, spoke_again: f64::NEG_INFINITY }
    }

    /// A state measured at a time, seen at another. True if it is new.
    pub fn saw(&mut self, measured: f64, now: f64) -> bool {
        let Some([time, came]) = self.newest else {
            self.newest = Some([measured, now]);
            return true;
        };
        if measured <= time {
            return false;
        }
        self.newest = Some([measured, now]);
        let since = (now - came).max(0.0);
        if since > self.silent_s && now - std::mem::replace(&mut self.spoke_again, now) > SILENCE_MEMORY_S {
            // One silence is no rate: the force comes back from nothing after it.
            return true;
        }
        // Slower at once, faster by and by: stiffness that goes up and down with each hiccup would be felt.
        let memory = if since > self.mean_s { RATE_MEMORY_S } else { RATE_RETURN_S };
        self.mean_s += (since.min(self.silent_s) - self.mean_s) * (since / memory).min(1.0);
        self.late_s += ((now - measured).max(0.0) - self.late_s) * (since / RATE_MEMORY_S).min(1.0);
        true
    }

    /// The mean time between two states, seconds.
    pub fn period_s(&self) -> f64 {
        self.mean_s
    }

    /// The mean age of states when they come, seconds.
    pub fn late_s(&self) -> f64 {
        self.late_s
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// After states at a rate, of an age, for a time; asked 1000 times a second.
    fn after(reports: &mut Reports, from: f64, seconds: f64, hz: f64, late: f64) -> f64 {
        let ticks = (seconds * 1e3) as u32;
        let mut due = from;
        for tick in 0..ticks {
            let now = from + f64::from(tick) * 1e-3;
            if now >= due - 1e-9 {
                assert!(reports.saw(now - late, now));
                due += 1.0 / hz;
            }
        }
        reports.period_s()
    }

    #[test]
    fn the_rate_and_the_age_are_those_of_the_states() {
        for (hz, late) in [(1000.0, 0.0), (100.0, 0.004), (50.0, 0.0), (25.0, 0.01)] {
            let mut reports = Reports::new(1e-3, 0.12);
            let found = after(&mut reports, 5.0, 1.0, hz, late);
            assert!((found * hz - 1.0).abs() < 0.05, "{hz}: {found}");
            assert!((reports.late_s() - late).abs() < 1e-3, "{hz}: {}", reports.late_s());
        }
    }

    #[test]
    fn one_late_state_and_one_silence_are_no_rate() {
        let mut reports = Reports::new(1e-3, 0.05);
        after(&mut reports, 0.0, 0.5, 1000.0, 0.0);
        assert!(reports.saw(0.503, 0.503) && reports.period_s() < 1.5e-3, "{reports:?}");
        // The same state again brings nothing.
        let newest = reports;
        assert!(!reports.saw(0.503, 0.6) && reports == newest);
        assert!(reports.saw(0.8, 0.8) && reports.period_s() < 1.5e-3, "{reports:?}");
        // One after the other are.
        assert!(reports.saw(0.9, 0.9) && reports.period_s() > 0.04, "{reports:?}");
        let back = after(&mut reports, 0.901, 1.5, 1000.0, 0.0);
        assert!(back < 1.1e-3, "{back}");
    }
}
