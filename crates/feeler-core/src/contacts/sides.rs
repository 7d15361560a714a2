//! On which side of each of many patches points lie, eight patches at once; and small sets as bits.

use crate::bounds::Point;
use crate::contacts::patches::{Patch, HOLLOW};
use crate::simd::{Checked, Kernel, Simd, WIDE_LANES};

/// Sets of the same few numbers, one after the other, 64 a word.
#[derive(Debug, Default)]
pub(crate) struct Sets {
    words: Vec<u64>,
    /// Words of one set.
    each: usize,
}

impl Sets {
    /// So many empty sets of numbers below `limit`.
    pub fn clear(&mut self, count: usize, limit: usize) {
        self.each = limit.div_ceil(64);
        self.words.clear();
        self.words.resize(count * self.each, 0);
    }

    pub fn get(&self, set: usize) -> &[u64] {
        &self.words[set * self.each..][..self.each]
    }

    pub fn get_mut(&mut self, set: usize) -> &mut [u64] {
        &mut self.words[set * self.each..][..self.each]
    }

    /// Adds the numbers of another set.
    pub fn join(&mut self, set: usize, other: &[u64]) {
        self.get_mut(set).iter_mut().zip(other).for_each(|(x, y)| *x |= y);
    }

    pub fn insert(&mut self, set: usize, x: usize) {
        self.words[set * self.each + x / 64] |= 1 << (x % 64);
    }
}

/// Whether a set has a number.
pub(crate) fn has(set: &[u64], x: usize) -> bool {
    set[x / 64] >> (x % 64) & 1 != 0
}

/// Whether two sets share a number.
pub(crate) fn is_meeting(a: &[u64], b: &[u64]) -> bool {
    a.iter().zip(b).any(|(x, y)| x & y != 0)
}

/// Eight patches by axis.
#[derive(Debug)]
struct Eight {
    normal: [[f64; WIDE_LANES]; 3],
    at: [[f64; WIDE_LANES]; 3],
    middle: [[f64; WIDE_LANES]; 3],
}

/// Patches by which to judge points.
#[derive(Debug, Default)]
pub(crate) struct Sides {
    eights: Vec<Eight>,
}

impl Sides {
    pub fn set(&mut self, patches: &[Patch]) {
        let eight = |of: &[Patch]| {
            let lanes = |get: fn(&Patch) -> &Point| {
                std::array::from_fn(|a| std::array::from_fn(|i| get(of.get(i).unwrap_or(&of[0]))[a]))
            };
            Eight { normal: lanes(|p| &p.normal), at: lanes(|p| &p.at), middle: lanes(|p| &p.middle) }
        };
        self.eights.clear();
        self.eights.extend(patches.chunks(WIDE_LANES).map(eight));
    }

    /// Puts into the sets `over` and `under` of each point the patches over and under whose planes it clearly is. What lies
    /// beyond the last patch repeats the first of its eight.
    pub fn judge(&self, lanes: Checked, points: &[Point], over: &mut Sets, under: &mut Sets) {
        lanes.run(Judge { sides: self, points, over, under });
    }
}

struct Judge<'a> {
    sides: &'a Sides,
    points: &'a [Point],
    over: &'a mut Sets,
    under: &'a mut Sets,
}

impl Kernel for Judge<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, s: S) {
        let (zero, share) = (s.wide_splat(0.0), s.wide_splat(HOLLOW * HOLLOW));
        for (k, x) in self.points.iter().enumerate() {
            let x = [s.wide_splat(x[0]), s.wide_splat(x[1]), s.wide_splat(x[2])];
            let (over, under) = (self.over.get_mut(k), self.under.get_mut(k));
            for (i, eight) in self.sides.eights.iter().enumerate() {
                let (mut height, mut square) = (zero, zero);
                for a in 0..3 {
                    height = height + (x[a] - s.wide_load(&eight.at[a])) * s.wide_load(&eight.normal[a]);
                    let way = x[a] - s.wide_load(&eight.middle[a]);
                    square = square + way * way;
                }
                let clear = s.wide_above(height * height, share * square);
                let up = s.wide_above(height, zero);
                let (word, shift) = (i / 8, 8 * (i % 8));
                let (clear, up) = (s.bits(clear), s.bits(up));
                over[word] |= u64::from(clear & up) << shift;
                under[word] |= u64::from(clear & !up) << shift;
            }
        }
    }
}
