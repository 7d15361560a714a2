//! Numbers from a seed, the same on every run and machine: no call here depends on the platform's mathematics library.

use feeler_core::{Point, Triangle};
use feeler_lanes::SplitMix64;

/// Numbers from a seed, good enough to aim at trouble with.
#[derive(Debug, Clone)]
pub struct Random(SplitMix64);

impl Random {
    /// Streams of different seeds have nothing to do with each other.
    pub fn new(seed: u64) -> Random {
        let mut first = SplitMix64::new(seed.wrapping_mul(0x2545_f491_4f6c_dd1d) ^ 0x9e37_79b9_7f4a_7c15);
        Random(SplitMix64::new(first.bits()))
    }

    /// 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.0.bits()
    }

    /// In `0..n`.
    pub fn below(&mut self, n: usize) -> usize {
        (self.bits() % n as u64) as usize
    }

    /// A whole number from `low` to `high`, both included.
    pub fn whole(&mut self, low: i32, high: i32) -> i32 {
        low + self.below((high - low + 1) as usize) as i32
    }

    /// True once in `n` times.
    pub fn one_in(&mut self, n: usize) -> bool {
        self.below(n) == 0
    }

    /// In `[low, high)`, with all 53 bits random.
    pub fn real(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.0.unit()
    }

    /// One of `choices`.
    pub fn pick<T: Copy>(&mut self, choices: &[T]) -> T {
        choices[self.below(choices.len())]
    }

    /// Each coordinate in `[low, high)`.
    pub fn point(&mut self, low: f64, high: f64) -> Point {
        std::array::from_fn(|_| self.real(low, high))
    }

    /// Each coordinate a whole number from `low` to `high`.
    pub fn lattice_point(&mut self, low: i32, high: i32) -> Point {
        std::array::from_fn(|_| f64::from(self.whole(low, high)))
    }

    /// Corners on whole numbers from `low` to `high`; perhaps without area.
    pub fn lattice_triangle(&mut self, low: i32, high: i32) -> Triangle {
        std::array::from_fn(|_| self.lattice_point(low, high))
    }

    /// A quarter of a whole number from `low` to `high`.
    pub fn quarters(&mut self, low: i32, high: i32) -> f64 {
        f64::from(self.whole(low, high)) / 4.0
    }

    /// The corners in any of their six orders.
    pub fn shuffled(&mut self, t: Triangle) -> Triangle {
        ORDERS[self.below(6)].map(|i| t[i])
    }

    /// Moves a number by up to `steps` float64 neighbours, up or down.
    pub fn nudged(&mut self, x: f64, steps: i32) -> f64 {
        let n = self.whole(-steps, steps);
        (0..n.abs()).fold(x, |x, _| if n > 0 { x.next_up() } else { x.next_down() })
    }

    /// Moves each coordinate by up to `steps` neighbours.
    pub fn nudged_triangle(&mut self, t: Triangle, steps: i32) -> Triangle {
        t.map(|c| c.map(|x| self.nudged(x, steps)))
    }
}

/// The orders of three corners.
pub const ORDERS: [[usize; 3]; 6] = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]];
