//! Numbers, points and motions from a seed, the same on every run and machine.

use feeler_lanes::SplitMix64;

use crate::{Matrix, Point};

/// Numbers from a seed.
#[derive(Debug, Clone)]
pub struct Random(SplitMix64);

impl Random {
    /// The same numbers for the same seed.
    pub fn new(seed: u64) -> Random {
        Random(SplitMix64::new(seed.wrapping_mul(0x2545_f491_4f6c_dd1d) ^ 0x9e37_79b9_7f4a_7c15))
    }

    /// 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.0.bits()
    }

    /// In [low, high).
    pub fn real(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.0.unit()
    }

    /// In 0..n.
    pub fn below(&mut self, n: u64) -> u64 {
        self.bits() % n
    }

    /// Each coordinate in [low, high).
    pub fn point(&mut self, low: f64, high: f64) -> Point {
        std::array::from_fn(|_| self.real(low, high))
    }

    /// A rotation about a random axis, and a translation within `reach` metres.
    pub fn motion(&mut self, reach: f64) -> Matrix {
        let q: [f64; 4] = loop {
            let q: [f64; 4] = std::array::from_fn(|_| self.real(-1.0, 1.0));
            let length = q.iter().map(|x| x * x).sum::<f64>().sqrt();
            if (0.1..1.0).contains(&length) {
                break q.map(|x| x / length);
            }
        };
        let [w, x, y, z] = q;
        let t = self.point(-reach, reach);
        [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w), t[0]],
            [2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w), t[1]],
            [2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y), t[2]],
            [0.0, 0.0, 0.0, 1.0],
        ]
    }

    /// Axes permuted and turned by right angles, and a whole translation: nothing rounds.
    pub fn lattice_motion(&mut self, reach: i64) -> Matrix {
        let whole = |r: &mut Random| r.below(2 * reach as u64 + 1) as f64 - reach as f64;
        let (a, b) = ([1.0, -1.0][self.below(2) as usize], [1.0, -1.0][self.below(2) as usize]);
        let c = a * b;
        let rows = match self.below(3) {
            0 => [[a, 0.0, 0.0], [0.0, b, 0.0], [0.0, 0.0, c]],
            1 => [[0.0, a, 0.0], [0.0, 0.0, b], [c, 0.0, 0.0]],
            _ => [[0.0, 0.0, a], [b, 0.0, 0.0], [0.0, c, 0.0]],
        };
        let mut m = [[0.0, 0.0, 0.0, 0.0], [0.0; 4], [0.0; 4], [0.0, 0.0, 0.0, 1.0]];
        for i in 0..3 {
            m[i] = [rows[i][0], rows[i][1], rows[i][2], whole(self)];
        }
        m
    }
}
