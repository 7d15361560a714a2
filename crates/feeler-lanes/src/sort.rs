//! Sorts lists of numbers and removes repetitions, in lanes: quicksort that packs chosen lanes (after B. Bramas, *A
//! novel hybrid quicksort algorithm vectorized using AVX-512 on Intel Skylake*, 2017), and small lists by counting
//! instead of a network.

use crate::simd::{Checked, Kernel, Simd, FEW, WIDE_LANES};

/// Puts numbers below `u64::MAX` in order, each once. Keeps its memory.
#[derive(Debug, Default)]
pub struct Sorter {
    /// The numbers to sort.
    pub keys: Vec<u64>,
    room: Vec<u64>,
    /// The first `count` are in order.
    sorted: Vec<u64>,
    count: usize,
}

impl Sorter {
    /// With capacity for that many keys.
    pub fn with_capacity(keys: usize) -> Sorter {
        Sorter { keys: Vec::with_capacity(keys), ..Sorter::default() }
    }

    /// Forgets all keys.
    pub fn clear(&mut self) {
        self.keys.clear();
        self.count = 0;
    }

    /// Puts the keys in order, each once; they themselves are in disorder then.
    pub fn sort(&mut self, lanes: Checked) {
        let Sorter { keys, room, sorted, count } = self;
        *count = lanes.run(SortUnique { keys, room, sorted });
    }

    /// The sorted numbers.
    #[inline(always)]
    pub fn sorted(&self) -> &[u64] {
        &self.sorted[..self.count]
    }
}

/// Puts numbers below `u64::MAX` in order into `sorted`, each once; returns how many there are. `keys` are in disorder then.
///
/// Quicksort without branches on what is compared: a register of numbers at a time goes to the one side or the other, and a few
/// are put where they belong by counting, for each, how many are smaller. Only for levels that can pack chosen lanes at once.
struct SortUnique<'a> {
    keys: &'a mut Vec<u64>,
    /// Working memory.
    room: &'a mut Vec<u64>,
    sorted: &'a mut Vec<u64>,
}

impl Kernel for SortUnique<'_> {
    type Output = usize;

    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> usize {
        let SortUnique { keys, room, sorted } = self;
        if !S::SORTS {
            keys.sort_unstable();
            keys.dedup();
            std::mem::swap(keys, sorted);
            return sorted.len();
        }
        if room.len() < keys.len() + WIDE_LANES {
            room.resize(2 * keys.len() + WIDE_LANES, 0);
        }
        if sorted.len() < keys.len() + FEW {
            sorted.resize(2 * keys.len() + FEW, 0);
        }
        // Where the ranges end that are still to be sorted, the first one last; few, unless pivots are bad.
        let mut ends = [0; 64];
        let (mut waiting, mut from, mut done) = (0, 0, 0);
        ends[0] = keys.len();
        loop {
            let to = ends[waiting];
            if to - from <= FEW {
                let few = sorted[done..].first_chunk_mut().expect("room for a few more than there are numbers");
                done += s.sort_few(&keys[from..to], few);
            } else {
                let range = &mut keys[from..to];
                let pivot = middle_of(range);
                let middle = from + s.partition(range, room, pivot);
                if middle < to && waiting + 1 < ends.len() {
                    waiting += 1;
                    ends[waiting] = middle;
                    continue;
                }
                // No pivot splits this one well.
                keys[from..to].sort_unstable();
                for i in from..to {
                    if done == 0 || sorted[done - 1] != keys[i] {
                        sorted[done] = keys[i];
                        done += 1;
                    }
                }
            }
            from = to;
            if waiting == 0 {
                break;
            }
            waiting -= 1;
        }
        done
    }
}

/// Of three numbers of a range, the one in the middle; of a large range, the middle one of three such.
fn middle_of(keys: &[u64]) -> u64 {
    let n = keys.len();
    if n < LARGE {
        return median(keys[n / 4], keys[n / 2], keys[n - 1 - n / 4]);
    }
    let three = |i: usize| median(keys[i], keys[i + n / 9], keys[i + 2 * (n / 9)]);
    median(three(0), three(n / 3), three(2 * (n / 3)))
}

/// Numbers that are worth looking at nine of.
const LARGE: usize = 128;

fn median(a: u64, b: u64, c: u64) -> u64 {
    a.max(b).min(a.min(b).max(c))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Level;
    use proptest::prelude::*;

    fn sorted(level: Level, keys: &[u64]) -> Vec<u64> {
        let mut sorter = Sorter { keys: keys.to_vec(), ..Sorter::default() };
        sorter.sort(level.checked());
        sorter.sorted().to_vec()
    }

    fn keys() -> impl Strategy<Value = Vec<u64>> {
        let number = prop_oneof![0..20u64, 0..1000u64, 0..u64::MAX, (u64::MAX - 20)..u64::MAX];
        prop_oneof![
            prop::collection::vec(number.clone(), 0..100),
            prop::collection::vec(number, 0..3000),
            // In order, or nearly.
            (0..3000u64, 1..50u64).prop_map(|(n, step)| (0..n).map(|i| i / step).collect()),
            (0..3000u64, 1..50u64).prop_map(|(n, step)| (0..n).map(|i| (n - i) * step).collect()),
        ]
    }

    proptest! {
        #[test]
        fn sorts_and_leaves_each_once(keys in keys()) {
            let mut expected = keys.clone();
            expected.sort_unstable();
            expected.dedup();
            for level in Level::available() {
                prop_assert_eq!(&sorted(level, &keys), &expected, "{}", level.name());
            }
        }
    }

    /// A level's result on numbers: those not above a pivot, and the rest, each put in order; and the first few in order.
    struct Steps<'a>(&'a [u64], u64);

    impl Kernel for Steps<'_> {
        type Output = (Vec<u64>, Vec<u64>, Vec<u64>);

        fn run<S: Simd>(self, s: S) -> Self::Output {
            let (mut keys, mut few) = (self.0.to_vec(), [0; FEW]);
            let count = s.sort_few(&self.0[..self.0.len().min(FEW)], &mut few);
            let low = s.partition(&mut keys, &mut vec![0; self.0.len() + WIDE_LANES], self.1);
            let mut high = keys.split_off(low);
            keys.sort_unstable();
            high.sort_unstable();
            (keys, high, few[..count].to_vec())
        }
    }

    proptest! {
        #[test]
        fn each_step_is_the_same_at_every_level(
            keys in prop::collection::vec(prop_oneof![0..9u64, 0..u64::MAX], 0..70),
            pivot in prop_oneof![0..9u64, 0..u64::MAX],
        ) {
            let mut ordered = keys.clone();
            ordered.sort_unstable();
            let (low, high) = ordered.iter().partition(|key| **key <= pivot);
            let mut few = keys[..keys.len().min(FEW)].to_vec();
            few.sort_unstable();
            few.dedup();
            let expected = (low, high, few);
            for level in Level::available() {
                prop_assert_eq!(&level.checked().run(Steps(&keys, pivot)), &expected, "{}", level.name());
            }
        }
    }

    #[test]
    fn bad_pivots_are_survived() {
        // Every partition splits off a few of the least only, where it leaves the rest in order: at the places where pivots are
        // looked for stand small ones.
        for n in [33, 100, 1000, 5000] {
            let mut keys: Vec<u64> = (0..n).map(|i| 1_000_000 + i).collect();
            let mut next = 0;
            let mut to = keys.len();
            while to > FEW {
                let ninth = to / 9;
                let nine = (0..3).flat_map(|k| (0..3).map(move |i| k * (to / 3) + i * ninth));
                let three = [to / 4, to / 2, to - 1 - to / 4].into_iter();
                let places: Vec<usize> = if to < LARGE { three.collect() } else { nine.collect() };
                for i in &places {
                    keys[*i] = next;
                    next += 1;
                }
                to -= places.len();
            }
            let mut expected = keys.clone();
            expected.sort_unstable();
            expected.dedup();
            for level in Level::available() {
                assert_eq!(sorted(level, &keys), expected, "{n} {}", level.name());
            }
        }
    }
}
