//! Points, each once.

use std::hint::select_unpredictable;

use crate::bounds::Point;

/// Slots for each point: whether one is taken already is not to be foreseen, so few are to be.
const SPARSE: usize = 4;

/// The places of points in a list, found by their coordinates.
#[derive(Debug, Default)]
pub(crate) struct PointSet {
    /// For each the place of its point, from 1; as many as are in use: of few points few, which the nearest cache holds.
    slots: Vec<u32>,
    len: usize,
}

impl PointSet {
    /// Forgets all points and makes room for so many.
    pub fn clear(&mut self, most: usize) {
        self.slots.clear();
        self.slots.resize((SPARSE * most).next_power_of_two(), 0);
        self.len = 0;
    }

    /// Points so far.
    pub fn len(&self) -> usize {
        self.len
    }

    /// The place of a point in `list`, where it is put after the others if it is new.
    pub fn insert(&mut self, x: &Point, list: &mut [Point]) -> usize {
        list[self.len] = *x;
        let (key, mask) = (bits(x), self.slots.len() - 1);
        let hash = key.iter().fold(0u64, |h, c| (h.rotate_left(21) ^ c).wrapping_mul(0x9e37_79b9_7f4a_7c15));
        let mut at = (hash >> 32) as usize & mask;
        loop {
            // Whether a point is new is as good as random: no branch asks. A new one is compared with itself.
            let taken = self.slots[at] as usize;
            let is_new = taken == 0;
            let place = select_unpredictable(is_new, self.len, taken.wrapping_sub(1));
            let there = bits(&list[place]);
            if (there[0] ^ key[0]) | (there[1] ^ key[1]) | (there[2] ^ key[2]) == 0 {
                self.slots[at] = place as u32 + 1;
                self.len += usize::from(is_new);
                return place;
            }
            at = (at + 1) & mask;
        }
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
    fn each_point_has_one_place_whichever_zero_it_has() {
        let mut set = PointSet::default();
        for count in [1, 5, 300] {
            set.clear(3 * count + 3);
            let mut list = vec![[7.0; 3]; 3 * count + 3];
            let point = |i: usize| [i as f64, -0.5 * (i % 3) as f64, 0.1];
            for _ in 0..3 {
                (0..count).for_each(|i| assert_eq!(set.insert(&point(i), &mut list), i));
            }
            assert_eq!(set.len(), count);
            (0..count).for_each(|i| assert_eq!(list[i], point(i)));
            let zeros = [[0.0, -0.0, 5.0], [-0.0, 0.0, 5.0], [f64::NAN; 3]];
            assert_eq!(zeros.map(|x| set.insert(&x, &mut list)), [count, count, count + 1]);
        }
    }
}
