//! Morton order: neighbours in space become neighbours in memory.

use crate::bounds::{Aabb, Point};

/// Cells per axis: 2^21, so that three interleaved coordinates fit 63 bits.
const CELLS: f64 = (1u64 << 21) as f64;

/// A box mapped to Morton cells.
#[derive(Debug, Clone)]
pub struct Frame {
    origin: Point,
    per_metre: f64,
}

impl Frame {
    /// A frame over `bounds`, with cubic cells.
    pub fn new(bounds: &Aabb) -> Frame {
        let longest = bounds.extent().iter().fold(0.0f64, |m, x| m.max(*x));
        let per_metre = CELLS / longest;
        Frame { origin: bounds.lower, per_metre: if per_metre.is_finite() { per_metre } else { 0.0 } }
    }

    /// The Morton code of a box's centre.
    pub fn code_of_box(&self, b: &Aabb) -> u64 {
        let cell = |a: usize| {
            let x = (0.5 * (b.lower[a] + b.upper[a]) - self.origin[a]) * self.per_metre;
            x.clamp(0.0, CELLS - 1.0) as u64
        };
        interleave([cell(0), cell(1), cell(2)])
    }
}

/// Interleaves the lowest 21 bits of three numbers: bit `n` of `x` becomes bit `3 n + 2` and so on.
pub fn interleave([x, y, z]: [u64; 3]) -> u64 {
    spread(x) << 2 | spread(y) << 1 | spread(z)
}

/// Puts two zeros between the lowest 21 bits.
fn spread(x: u64) -> u64 {
    let mut x = x & 0x1f_ffff;
    for (shift, mask) in [
        (32, 0x001f_0000_0000_ffff),
        (16, 0x001f_0000_ff00_00ff),
        (8, 0x100f_00f0_0f00_f00f),
        (4, 0x10c3_0c30_c30c_30c3),
        (2, 0x1249_2492_4924_9249),
    ] {
        x = (x | x << shift) & mask;
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_are_interleaved() {
        for bit in 0..21 {
            assert_eq!(interleave([1 << bit, 0, 0]), 1 << (3 * bit + 2));
            assert_eq!(interleave([0, 1 << bit, 0]), 1 << (3 * bit + 1));
            assert_eq!(interleave([0, 0, 1 << bit]), 1 << (3 * bit));
        }
    }

    #[test]
    fn a_point_has_a_code_too() {
        let point = Aabb { lower: [7.0; 3], upper: [7.0; 3] };
        assert_eq!(Frame::new(&point).code_of_box(&point), 0);
    }
}
