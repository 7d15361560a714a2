//! An interner of points: each distinct point has one number. Open addressing with linear probing, as in [`feeler_core::index::interner`].

use std::hint::select_unpredictable;

use feeler_core::geometry::bounds::Point;

/// Least slots a point: at half load most probes hit the first time, and few points fit the nearest cache.
const SLOTS_PER_POINT: usize = 2;

/// Multipliers of the hash, odd and without a pattern, one an axis.
const HASH_MULTIPLIERS: [u64; 3] = [0x9e37_79b9_7f4a_7c15, 0xbf58_476d_1ce4_e5b9, 0x94d0_49bb_1331_11eb];

/// Working memory of a [`Numbering`].
#[derive(Debug, Default)]
pub(crate) struct PointInterner {
    /// Point numbers from 1, 0 where free. No more slots than the points of this round need, so that they stay in cache.
    slots: Vec<u32>,
    list: Vec<Point>,
}

/// Numbers points in the order of their arrival. A value of its own, so that its fields stay in registers.
pub(crate) struct Numbering<'a> {
    slots: &'a mut [u32],
    list: &'a mut [Point],
    /// 64 less the bits of a slot's index.
    shift: u32,
    len: usize,
}

impl PointInterner {
    /// Begins anew, for at most `most` points.
    pub fn begin(&mut self, most: usize) -> Numbering<'_> {
        self.slots.clear();
        self.slots.resize((SLOTS_PER_POINT * most).next_power_of_two().max(2), 0);
        // Points of earlier rounds stay in the list, and are never read.
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
            // Whether a point is new cannot be predicted, so no branch asks: a new point is compared with itself.
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

    /// The slot of the first probe, from the upper bits of the products: these depend on all bits of a coordinate, while its lower bits
    /// are zero in round numbers.
    #[inline(always)]
    fn first_slot(&self, key: &[u64; 3]) -> usize {
        let [x, y, z] = [0, 1, 2].map(|a| key[a].wrapping_mul(HASH_MULTIPLIERS[a]));
        (x.wrapping_add(y).wrapping_add(z) >> self.shift) as usize
    }
}

/// Bits that are equal where coordinates are: adding 0 makes -0 and 0 one zero.
#[inline(always)]
fn bits(x: &Point) -> [u64; 3] {
    [(x[0] + 0.0).to_bits(), (x[1] + 0.0).to_bits(), (x[2] + 0.0).to_bits()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_told_apart_by_every_coordinate() {
        // So many points on a line along each axis that many share a slot, every point twice.
        let mut interner = PointInterner::default();
        for axis in 0..3 {
            let point = |i: usize| std::array::from_fn(|a| if a == axis { (i as f64).sqrt() } else { 2.0 });
            let mut set = interner.begin(3001);
            for _ in 0..2 {
                (0..3000).for_each(|i| assert_eq!(set.insert(&point(i)), i, "{axis}"));
            }
            assert_eq!(set.len(), 3000, "{axis}");
        }
    }

    #[test]
    fn each_point_has_one_number_whichever_zero_it_has() {
        let mut interner = PointInterner::default();
        for count in [1, 5, 300, 20] {
            let mut set = interner.begin(3 * count + 3);
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
