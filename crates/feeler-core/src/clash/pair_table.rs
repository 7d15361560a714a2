//! Intermediate results by pair of parts.

use crate::index::interner::{pair_key, KeySet};

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
}
