//! Intermediate results by pair of parts.

use crate::index::interner::{pair_key, KeySet};

/// Pairs beyond which a table is forgotten between shares: about what the second cache of a core holds.
const MOST_PAIRS_HELD: usize = if cfg!(test) { 16 } else { 1 << 14 };

/// A table of pairs of parts.
#[derive(Debug)]
pub(crate) struct PairTable<T> {
    numbers: KeySet,
    values: Vec<T>,
}

impl<T> PairTable<T> {
    /// An empty table.
    pub fn new() -> PairTable<T> {
        PairTable { numbers: KeySet::default(), values: Vec::new() }
    }

    /// Called before each share of a search; forgets a table that has grown large. A pair recurs within a share and in the next ones,
    /// hardly ever later, so a table of all pairs so far costs cache misses and memory. A mock-up of few parts has no large table, so
    /// its shares learn from each other to the end.
    pub fn begin_share(&mut self) {
        if self.values.len() > MOST_PAIRS_HELD {
            self.numbers.clear();
            self.values.clear();
        }
    }

    /// The entry of a pair (the lesser part first), made by `make` if it is new.
    #[inline]
    pub fn of(&mut self, a: u32, b: u32, make: impl FnOnce() -> T) -> &mut T {
        let (number, is_new) = self.numbers.number(pair_key(a, b));
        if is_new {
            self.values.push(make());
        }
        &mut self.values[number as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_keeps_what_it_was_told() {
        let mut table = PairTable::new();
        for a in 0..100 {
            for b in a + 1..100 {
                assert_eq!(*table.of(a, b, || a * b), a * b);
            }
        }
        for a in 0..100 {
            for b in a + 1..100 {
                assert_eq!(*table.of(a, b, || unreachable!()), a * b);
            }
        }
    }

    #[test]
    fn a_large_table_is_forgotten_between_shares() {
        let mut table = PairTable::new();
        table.of(0, 1, || 1);
        table.begin_share();
        assert_eq!(*table.of(0, 1, || unreachable!()), 1);
        (1..=MOST_PAIRS_HELD as u32 + 1).for_each(|b| *table.of(0, b, || 0) = b);
        table.begin_share();
        assert_eq!([*table.of(0, 2, || 7), *table.of(0, 3, || 8)], [7, 8]);
    }
}
