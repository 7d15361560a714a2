//! Random numbers that are the same on every machine and any number of threads.

use feeler_lanes::SplitMix64;

/// Numbers from a seed, in streams that have nothing to do with each other.
#[derive(Debug, Clone)]
pub struct Random(SplitMix64);

impl Random {
    /// The stream of a number, among those of a seed.
    pub fn new(seed: u64, stream: u64) -> Random {
        let mixed = SplitMix64::new(seed).bits();
        Random(SplitMix64::new(mixed ^ stream.wrapping_mul(0xd134_2543_de82_ef95)))
    }

    /// From 0 to 1, without 1.
    pub fn share(&mut self) -> f64 {
        self.0.unit()
    }

    /// From one to the other.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.share()
    }

    /// Below a number that is not 0.
    pub fn below(&mut self, count: usize) -> usize {
        ((self.share() * count as f64) as usize).min(count - 1)
    }

    /// A rotation as a quaternion (w, x, y, z), each alike (K. Shoemake, 1992).
    pub fn quaternion(&mut self) -> [f64; 4] {
        let (u, v, w) =
            (self.share(), self.between(0.0, std::f64::consts::TAU), self.between(0.0, std::f64::consts::TAU));
        let (a, b) = ((1.0 - u).sqrt(), u.sqrt());
        [a * v.sin(), a * v.cos(), b * w.sin(), b * w.cos()]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn streams_differ_and_repeat() {
        let first = |seed, stream| Random::new(seed, stream).0.bits();
        assert_eq!(first(3, 1), first(3, 1));
        let mut all: Vec<u64> = (0..40).flat_map(|seed| (0..8).map(move |stream| first(seed, stream))).collect();
        all.sort_unstable();
        all.dedup();
        assert_eq!(all.len(), 320);
    }

    #[test]
    fn numbers_are_spread() {
        let mut random = Random::new(0, 0);
        let n = 4000;
        let mut sums = [0.0; 3];
        for _ in 0..n {
            let share = random.share();
            assert!((0.0..1.0).contains(&share));
            let q = random.quaternion();
            assert!((q.iter().map(|x| x * x).sum::<f64>() - 1.0).abs() < 1e-12);
            assert!(random.below(3) < 3);
            sums[0] += share - 0.5;
            sums[1] += q[3];
            sums[2] += q[0];
        }
        assert!(sums.iter().all(|sum| sum.abs() < 0.03 * f64::from(n)), "{sums:?}");
    }
}
