//! An interner of keys below a limit: numbered 0, 1, 2, ... in the order of their arrival, in a slot each. The slots carry the round
//! that they were filled in, so that clearing takes constant time.

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
}
