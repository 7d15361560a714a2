//! Sets of triangle pairs.

/// A pair in one number, in order.
pub fn pair_key(tool_triangle: u32, mockup_triangle: u32) -> u64 {
    u64::from(tool_triangle) << 32 | u64::from(mockup_triangle)
}

/// A set of triangle pairs that empties in constant time.
#[derive(Debug, Default)]
pub struct PairSet {
    slots: Vec<(u64, u32)>,
    query: u32,
    len: usize,
}

impl PairSet {
    /// Empties the set.
    pub fn clear(&mut self) {
        if self.slots.is_empty() {
            self.slots = vec![(0, 0); 1024];
        }
        if self.query == u32::MAX {
            self.slots.fill((0, 0));
            self.query = 0;
        }
        self.query += 1;
        self.len = 0;
    }

    /// Adds a pair; false when it was there.
    #[inline]
    pub fn insert(&mut self, key: u64) -> bool {
        if 2 * self.len >= self.slots.len() {
            self.grow();
        }
        let mask = self.slots.len() - 1;
        let mut at = (key.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 32) as usize & mask;
        while self.slots[at].1 == self.query {
            if self.slots[at].0 == key {
                return false;
            }
            at = (at + 1) & mask;
        }
        self.slots[at] = (key, self.query);
        self.len += 1;
        true
    }

    #[cold]
    fn grow(&mut self) {
        let old = std::mem::take(&mut self.slots);
        let query = std::mem::replace(&mut self.query, 1);
        self.slots = vec![(0, 0); 2 * old.len()];
        self.len = 0;
        for (key, _) in old.into_iter().filter(|slot| slot.1 == query) {
            self.insert(key);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pair_set_remembers_through_growth_and_forgets_on_clear() {
        let mut set = PairSet::default();
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
