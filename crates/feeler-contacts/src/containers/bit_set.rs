//! Sets of small numbers as rows of a bit matrix.

/// Sets of numbers below one limit, one after the other, 64 numbers a word.
#[derive(Debug, Default)]
pub(crate) struct BitSets {
    words: Vec<u64>,
    /// Words of each set.
    each: usize,
}

impl BitSets {
    /// Makes `count` empty sets of numbers below `limit`.
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

    /// Whether the union of some of these sets meets the union of the same sets of another list.
    pub fn is_meeting_union(&self, other: &BitSets, sets: &[u32]) -> bool {
        (0..self.each).any(|word| {
            let all = |of: &BitSets| sets.iter().fold(0, |all, i| all | of.words[*i as usize * of.each + word]);
            all(self) & all(other) != 0
        })
    }

    /// Adds the intersection of some of these sets to another set.
    pub fn join_common(&self, sets: &[u32], to: &mut [u64]) {
        for (word, to) in to.iter_mut().enumerate() {
            *to |= sets.iter().fold(u64::MAX, |all, i| all & self.words[*i as usize * self.each + word]);
        }
    }

    /// Makes these the transpose of another list of `count` sets of numbers below `count`: set `x` has `i` where `i` had `x`.
    pub fn transpose(&mut self, other: &BitSets, count: usize) {
        self.clear(count, count);
        for (i, j) in (0..self.each).flat_map(|i| (0..self.each).map(move |j| (i, j))) {
            let mut square = [0; 64];
            for (row, set) in square.iter_mut().zip(64 * i..count) {
                *row = other.words[set * self.each + j];
            }
            transpose_square(&mut square);
            for (row, set) in square.iter().zip(64 * j..count) {
                self.words[set * self.each + i] = *row;
            }
        }
    }

    pub fn insert(&mut self, set: usize, x: usize) {
        self.words[set * self.each + x / 64] |= 1 << (x % 64);
    }
}

/// Whether a set has a number.
#[cfg(test)]
pub(crate) fn has(set: &[u64], x: usize) -> bool {
    set[x / 64] >> (x % 64) & 1 != 0
}

/// Whether two sets share a number.
pub(crate) fn is_meeting(a: &[u64], b: &[u64]) -> bool {
    a.iter().zip(b).any(|(x, y)| x & y != 0)
}

/// The numbers that two sets share.
pub(crate) fn shared<'a>(a: &'a [u64], b: &'a [u64]) -> impl Iterator<Item = usize> + 'a {
    a.iter().zip(b).enumerate().flat_map(|(word, (x, y))| {
        let mut left = x & y;
        std::iter::from_fn(move || {
            let next = (left != 0).then(|| 64 * word + left.trailing_zeros() as usize);
            left &= left.wrapping_sub(1);
            next
        })
    })
}

/// Transposes a square of bits by exchanging its off-diagonal halves, then quarters, down to single bits (Warren: *Hacker's Delight*,
/// 2002, section 7-3).
fn transpose_square(square: &mut [u64; 64]) {
    let (mut width, mut mask) = (32, u64::MAX >> 32);
    while width > 0 {
        for i in (0..64).filter(|i| i & width == 0) {
            let differing = (square[i] >> width ^ square[i + width]) & mask;
            square[i] ^= differing << width;
            square[i + width] ^= differing;
        }
        width /= 2;
        mask ^= mask << width;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unions_of_sets_meet() {
        let (mut sets, mut others) = (BitSets::default(), BitSets::default());
        sets.clear(3, 100);
        others.clear(3, 100);
        sets.insert(0, 90);
        others.insert(1, 90);
        others.insert(2, 3);
        assert!(sets.is_meeting_union(&others, &[0, 1]) && !sets.is_meeting_union(&others, &[0, 2, 2]));
    }

    #[test]
    fn the_intersection_of_some_sets_is_added() {
        let mut sets = BitSets::default();
        sets.clear(3, 100);
        [(0, 90), (1, 90), (1, 3), (2, 3), (0, 5), (1, 5), (2, 5)].iter().for_each(|(set, x)| sets.insert(*set, *x));
        for (some, expected) in [(&[0, 1][..], &[5, 7, 90][..]), (&[1, 2], &[3, 5, 7]), (&[2, 0, 1], &[5, 7])] {
            let mut found = [1 << 7, 0];
            sets.join_common(some, &mut found);
            assert!((0..128).filter(|x| has(&found, *x)).eq(expected.iter().copied()), "{some:?}");
        }
    }

    #[test]
    fn what_two_sets_share_comes_in_order() {
        let mut sets = BitSets::default();
        sets.clear(2, 150);
        (0..150).filter(|x| x % 3 == 0).for_each(|x| sets.insert(0, x));
        (0..150).filter(|x| x % 7 == 1).for_each(|x| sets.insert(1, x));
        let expected: Vec<usize> = (0..150).filter(|x| x % 3 == 0 && x % 7 == 1).collect();
        assert_eq!(shared(sets.get(0), sets.get(1)).collect::<Vec<_>>(), expected);
    }

    #[test]
    fn transposed_sets_have_what_had_them() {
        for count in [0, 1, 63, 64, 65, 130, 200] {
            let is_in = |i: usize, x: usize| (i * 7 + x * x * 3 + i * x) % 5 < 2;
            let (mut sets, mut transposed) = (BitSets::default(), BitSets::default());
            sets.clear(count, count);
            let all = || (0..count).flat_map(|i| (0..count).map(move |x| (i, x)));
            all().filter(|(i, x)| is_in(*i, *x)).for_each(|(i, x)| sets.insert(i, x));
            transposed.transpose(&sets, count);
            all().for_each(|(i, x)| assert_eq!(has(transposed.get(x), i), is_in(i, x), "{count} {i} {x}"));
        }
    }
}
