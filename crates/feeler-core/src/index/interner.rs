//! Interners: keys numbered 0, 1, 2, ... in the order of their arrival; and sets of keys, which need no numbers.

/// A pair in one key, in order.
#[inline]
pub fn pair_key(a: u32, b: u32) -> u64 {
    u64::from(a) << 32 | u64::from(b)
}

/// Numbers keys. An open-addressed hash table with linear probing (Knuth: *The Art of Computer Programming*, volume 3, 6.4), whose
/// slots carry the round that they were filled in, so that clearing takes constant time.
///
/// `SLOTS_PER_KEY`: at a load of a quarter nearly every first probe hits, and the branch on it is predicted; at a half the table takes
/// half the memory.
#[derive(Debug, Default)]
pub struct Interner<const SLOTS_PER_KEY: usize = 4> {
    slots: Vec<Slot>,
    len: u32,
    round: u32,
}

/// A set of keys, which are often many.
pub type KeySet = Interner<2>;

#[derive(Debug, Clone, Copy, Default)]
struct Slot {
    key: u64,
    round: u32,
    number: u32,
}

impl<const SLOTS_PER_KEY: usize> Interner<SLOTS_PER_KEY> {
    /// Forgets all keys.
    pub fn clear(&mut self) {
        if self.slots.is_empty() || self.round == u32::MAX {
            self.slots = vec![Slot::default(); self.slots.len().max(64)];
            self.round = 0;
        }
        self.round += 1;
        self.len = 0;
    }

    /// How many keys have a number.
    #[allow(clippy::len_without_is_empty, reason = "nobody asks whether one is empty")]
    pub fn len(&self) -> usize {
        self.len as usize
    }

    /// The number of a key, and whether it is new.
    #[inline]
    pub fn number(&mut self, key: u64) -> (u32, bool) {
        if SLOTS_PER_KEY * self.len as usize >= self.slots.len() {
            self.grow();
        }
        let at = self.find(key);
        let slot = &mut self.slots[at];
        if slot.round == self.round {
            return (slot.number, false);
        }
        *slot = Slot { key, round: self.round, number: self.len };
        self.len += 1;
        (self.len - 1, true)
    }

    /// Adds a key; false when it was there.
    #[inline]
    pub fn insert(&mut self, key: u64) -> bool {
        self.number(key).1
    }

    /// The number of a key that has one.
    #[inline]
    pub fn get(&self, key: u64) -> Option<u32> {
        if self.slots.is_empty() {
            return None;
        }
        let slot = &self.slots[self.find(key)];
        (slot.round == self.round).then_some(slot.number)
    }

    /// The slot of a key, or the free one for it.
    #[inline]
    fn find(&self, key: u64) -> usize {
        let mask = self.slots.len() - 1;
        let mut at = (key.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 32) as usize & mask;
        while self.slots[at].round == self.round && self.slots[at].key != key {
            at = (at + 1) & mask;
        }
        at
    }

    #[cold]
    fn grow(&mut self) {
        let more = vec![Slot::default(); (2 * self.slots.len()).max(64)];
        let old = std::mem::replace(&mut self.slots, more);
        self.round = self.round.max(1);
        for slot in old.into_iter().filter(|slot| slot.round == self.round) {
            let at = self.find(slot.key);
            self.slots[at] = slot;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_count_up_through_growth_and_start_again_on_clear() {
        let mut numbered = <Interner>::default();
        assert_eq!(numbered.get(5), None);
        assert_eq!(numbered.number(5), (0, true));
        for round in 0..3u64 {
            numbered.clear();
            for i in 0..1000 {
                assert_eq!(numbered.number(i * 0x1_0000_0007 + round), (i as u32, true));
            }
            for i in 0..1000 {
                assert_eq!(numbered.number(i * 0x1_0000_0007 + round), (i as u32, false));
                assert_eq!(numbered.get(i * 0x1_0000_0007 + round), Some(i as u32));
            }
            assert_eq!(numbered.get(3), None);
        }
    }

    #[test]
    fn a_set_remembers_through_growth_and_forgets_on_clear() {
        let mut set = KeySet::default();
        for round in 0..3 {
            set.clear();
            for key in 0..5000u64 {
                assert!(set.insert(key * 77 + round), "{key}");
            }
            for key in 0..5000u64 {
                assert!(!set.insert(key * 77 + round), "{key}");
            }
        }
    }
}
