//! Points, each once.

use std::hint::select_unpredictable;

use feeler_core::geometry::bounds::Point;

/// Slots for each point: whether one is taken already is not to be foreseen, so few are to be.
const SPARSE: usize = 2;

/// Odd numbers without a pattern, one an axis.
const MIX: [u64; 3] = [0x9e37_79b9_7f4a_7c15, 0xbf58_476d_1ce4_e5b9, 0x94d0_49bb_1331_11eb];

/// Points numbered in the order of their arrival, each once, found by their coordinates. Working memory.
#[derive(Debug, Default)]
pub(crate) struct PointInterner {
    /// For each the number of its point, from 1; as many as are in use: of few points few, which the nearest cache holds.
    slots: Vec<u32>,
    list: Vec<Point>,
}

/// A set that points are put into. A value of its own, so that what each point needs stays in registers.
pub(crate) struct Numbering<'a> {
    slots: &'a mut [u32],
    list: &'a mut [Point],
    /// Bits that a number of 64 bits has more than the number of a slot.
    shift: u32,
    len: usize,
}

impl PointInterner {
    /// An empty set for so many points.
    pub fn begin(&mut self, most: usize) -> Numbering<'_> {
        self.slots.clear();
        self.slots.resize((SPARSE * most).next_power_of_two().max(2), 0);
        // What is left there of other points is never looked at.
        self.list.resize(self.list.len().max(most), [0.0; 3]);
        let shift = u64::BITS - self.slots.len().trailing_zeros();
        Numbering { slots: &mut self.slots, list: &mut self.list, shift, len: 0 }
    }
}

impl Numbering<'_> {
    /// Points so far.
    pub fn len(&self) -> usize {
        self.len
    }

    /// The number of a point.
    #[inline(always)]
    pub fn insert(&mut self, x: &Point) -> usize {
        self.list[self.len] = *x;
        let (key, mask) = (bits(x), self.slots.len() - 1);
        let mut at = self.first_slot(&key);
        loop {
            // Whether a point is new is as good as random: no branch asks. A new one is compared with itself.
            let taken = self.slots[at] as usize;
            let is_new = taken == 0;
            let number = select_unpredictable(is_new, self.len, taken.wrapping_sub(1));
            let there = bits(&self.list[number]);
            if (there[0] ^ key[0]) | (there[1] ^ key[1]) | (there[2] ^ key[2]) == 0 {
                self.slots[at] = number as u32 + 1;
                self.len += usize::from(is_new);
                return number;
            }
            at = (at + 1) & mask;
        }
    }

    /// Where a point is looked for first. The upper bits of a product depend on all bits of a coordinate, of which the lower ones
    /// are zero in round numbers.
    #[inline(always)]
    fn first_slot(&self, key: &[u64; 3]) -> usize {
        let [x, y, z] = [0, 1, 2].map(|a| key[a].wrapping_mul(MIX[a]));
        (x.wrapping_add(y).wrapping_add(z) >> self.shift) as usize
    }
}

/// The coordinates as they compare: adding 0 makes one zero of the two.
#[inline(always)]
fn bits(x: &Point) -> [u64; 3] {
    [(x[0] + 0.0).to_bits(), (x[1] + 0.0).to_bits(), (x[2] + 0.0).to_bits()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn round_coordinates_are_not_looked_for_in_a_few_slots() {
        let mut set = PointInterner::default();
        let set = set.begin(1000);
        let step = |i: usize, a: usize| if i % 3 == a { (i / 3) as f64 } else { 2.0 };
        for scale in [1.0, 0.0625, 25.4] {
            let lines = (0..1000).map(|i| [scale * step(i, 0), scale * step(i, 1), scale * step(i, 2)]);
            let first: std::collections::HashSet<_> = lines.map(|x| set.first_slot(&bits(&x))).collect();
            assert!(first.len() > 700, "{scale}: {}", first.len());
        }
    }

    #[test]
    fn each_point_has_one_number_whichever_zero_it_has() {
        let mut set = PointInterner::default();
        for count in [1, 5, 300, 20] {
            let mut set = set.begin(3 * count + 3);
            let point = |i: usize| [i as f64, -0.5 * (i % 3) as f64, 0.1];
            for _ in 0..3 {
                (0..count).for_each(|i| assert_eq!(set.insert(&point(i)), i));
            }
            assert_eq!(set.len(), count);
            (0..count).for_each(|i| assert_eq!(set.list[i], point(i)));
            let zeros = [[0.0, -0.0, 5.0], [-0.0, 0.0, 5.0], [f64::NAN; 3]];
            assert_eq!(zeros.map(|x| set.insert(&x)), [count, count, count + 1]);
        }
    }
}
