//! Interners: keys numbered 0, 1, 2, ... in the order of their arrival. An open-addressed hash table with linear probing (Knuth: *The
//! Art of Computer Programming*, volume 3, 6.4), whose slots carry the round that they were filled in, so that clearing takes
//! constant time.

/// Least slots a key: at a load of a quarter nearly every first probe hits, and the branch on it is predicted.
const SLOTS_PER_KEY: usize = 4;

/// Numbers any keys.
#[derive(Debug, Default)]
pub(crate) struct Interner {
    slots: Vec<Slot>,
    len: u32,
    round: u32,
}

#[derive(Debug, Clone, Copy, Default)]
struct Slot {
    key: u64,
    round: u32,
    number: u32,
}

impl Interner {
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

/// Numbers keys below a limit: a slot each, without hashing.
#[derive(Debug, Default)]
pub(crate) struct BoundedInterner {
    /// For each key its number and the round in which it was given.
    slots: Vec<(u32, u32)>,
    len: u32,
    round: u32,
}

impl BoundedInterner {
    /// Forgets all keys; from now on they are below `limit`.
    pub fn clear(&mut self, limit: usize) {
        if self.slots.len() < limit || self.round == u32::MAX {
            self.slots = vec![(0, 0); limit.max(self.slots.len())];
            self.round = 0;
        }
        self.round += 1;
        self.len = 0;
    }

    /// How many keys have a number.
    pub fn len(&self) -> usize {
        self.len as usize
    }

    /// The number of a key, and whether it is new.
    #[inline]
    pub fn number(&mut self, key: u32) -> (u32, bool) {
        let slot = &mut self.slots[key as usize];
        if slot.0 == self.round {
            return (slot.1, false);
        }
        *slot = (self.round, self.len);
        self.len += 1;
        (slot.1, true)
    }

    /// The number of a key that has one.
    #[inline]
    pub fn get(&self, key: u32) -> Option<u32> {
        let (round, number) = self.slots[key as usize];
        (round == self.round).then_some(number)
    }
}

/// A pair as a key.
pub(crate) fn pair_key(pair: [u32; 2]) -> u64 {
    u64::from(pair[0]) << 32 | u64::from(pair[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounded_keys_count_up_and_start_again_on_clear() {
        let mut numbered = BoundedInterner::default();
        for limit in [10, 5, 100] {
            numbered.clear(limit);
            assert_eq!(numbered.get(4), None);
            assert_eq!(numbered.number(4), (0, true));
            assert_eq!(numbered.get(4), Some(0));
            assert_eq!(numbered.number(limit as u32 - 1), if limit == 5 { (0, false) } else { (1, true) });
            assert_eq!(numbered.number(4), (0, false));
        }
    }

    #[test]
    fn numbers_count_up_through_growth_and_start_again_on_clear() {
        let mut numbered = Interner::default();
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
}
