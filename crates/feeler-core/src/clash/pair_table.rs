//! Intermediate results by pair of parts.

use crate::index::pair_set::pair_key;

/// A table of pairs of parts that grows, and empties in little time.
#[derive(Debug)]
pub(crate) struct PairTable<T> {
    slots: Vec<(u64, T)>,
    len: usize,
    empty: T,
}

/// No pair has this number: no part is in a pair with itself.
const FREE: u64 = u64::MAX;
const FIRST_SLOTS: usize = 1024;

impl<T: Copy> PairTable<T> {
    /// An empty table; `empty` marks free entries.
    pub fn new(empty: T) -> PairTable<T> {
        PairTable { slots: vec![(FREE, empty); FIRST_SLOTS], len: 0, empty }
    }

    /// The entry of a pair (the lesser part first), made by `make` if it is new.
    #[inline]
    pub fn of(&mut self, a: u32, b: u32, make: impl FnOnce() -> T) -> &mut T {
        if 2 * self.len >= self.slots.len() {
            self.grow();
        }
        let key = pair_key(a, b);
        let at = self.place(key);
        if self.slots[at].0 == FREE {
            self.slots[at] = (key, make());
            self.len += 1;
        }
        &mut self.slots[at].1
    }

    fn place(&self, key: u64) -> usize {
        let mask = self.slots.len() - 1;
        let mut at = (key.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 32) as usize & mask;
        while self.slots[at].0 != key && self.slots[at].0 != FREE {
            at = (at + 1) & mask;
        }
        at
    }

    #[cold]
    fn grow(&mut self) {
        let larger = vec![(FREE, self.empty); 2 * self.slots.len()];
        for slot in std::mem::replace(&mut self.slots, larger).into_iter().filter(|slot| slot.0 != FREE) {
            let at = self.place(slot.0);
            self.slots[at] = slot;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_keeps_what_it_was_told() {
        let mut table = PairTable::new(0);
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
