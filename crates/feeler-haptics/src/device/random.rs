//! Numbers from a seed, the same on every run and machine.

use feeler_lanes::SplitMix64;

/// Numbers from a seed.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Random(SplitMix64);

impl Random {
    pub(super) fn new(seed: u64) -> Random {
        Random(SplitMix64::new(seed))
    }

    /// In [0, 1).
    pub(super) fn unit(&mut self) -> f64 {
        self.0.unit()
    }
}
