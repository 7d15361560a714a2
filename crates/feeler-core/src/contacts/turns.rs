//! Which of many directions are close to a given one, eight at once.

use crate::bounds::Point;
use crate::simd::{Checked, Kernel, Simd, WIDE_LANES};

/// Directions by axis and lane; unused lanes are zero.
#[derive(Debug, Default)]
pub(crate) struct Turns {
    eights: Vec<[[f64; WIDE_LANES]; 3]>,
    len: usize,
}

impl Turns {
    pub fn clear(&mut self) {
        self.eights.clear();
        self.len = 0;
    }

    /// Adds a direction.
    pub fn push(&mut self, d: &Point) {
        let lane = self.len % WIDE_LANES;
        if lane == 0 {
            self.eights.push([[0.0; WIDE_LANES]; 3]);
        }
        let last = self.eights.len() - 1;
        (0..3).for_each(|a| self.eights[last][a][lane] = d[a]);
        self.len += 1;
    }

    /// The first direction within [`CLOSE`] of `d` that fits.
    pub fn find(&self, lanes: Checked, d: &Point, mut fits: impl FnMut(usize) -> bool) -> Option<usize> {
        let mut from = 0;
        while let Some((i, mut close)) = lanes.run(Find { eights: &self.eights[from..], d }) {
            while close != 0 {
                let at = WIDE_LANES * (from + i) + close.trailing_zeros() as usize;
                if fits(at) {
                    return Some(at);
                }
                close &= close - 1;
            }
            from += i + 1;
        }
        None
    }
}

/// Cosine of the widest angle that is close: 2.6 degrees.
const CLOSE: f64 = 0.999;

struct Find<'a> {
    eights: &'a [[[f64; WIDE_LANES]; 3]],
    d: &'a Point,
}

impl Kernel for Find<'_> {
    /// The first eight that has some, and which.
    type Output = Option<(usize, u8)>;

    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> Option<(usize, u8)> {
        let d = [s.wide_splat(self.d[0]), s.wide_splat(self.d[1]), s.wide_splat(self.d[2])];
        let least = s.wide_splat(CLOSE);
        for (i, eight) in self.eights.iter().enumerate() {
            let cosine = s.wide_load(&eight[0]) * d[0] + s.wide_load(&eight[1]) * d[1] + s.wide_load(&eight[2]) * d[2];
            let close = s.bits(s.wide_above(cosine, least));
            if close != 0 {
                return Some((i, close));
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simd::Level;
    use crate::vectors::unit;

    #[test]
    fn the_first_that_is_close_and_fits_is_found() {
        let mut turns = Turns::default();
        turns.clear();
        let direction = |i: usize| unit(&[1.0, 0.1 * (i % 7) as f64, 0.0]).unwrap();
        (0..29).for_each(|i| turns.push(&direction(i)));
        for level in Level::available() {
            for i in 0..7 {
                let found = |fits: fn(usize) -> bool| turns.find(level.checked(), &direction(i), fits);
                assert_eq!(found(|_| true), Some(i));
                assert_eq!(found(|i| i > 20), Some((21..).find(|j| j % 7 == i).unwrap()).filter(|j| *j < 29));
            }
            assert_eq!(turns.find(level.checked(), &[0.0, 0.0, 1.0], |_| true), None);
        }
    }
}
