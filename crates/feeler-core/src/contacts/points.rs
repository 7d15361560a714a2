//! Points, each once.

use crate::bounds::Point;

/// The places of points in a list, found by their coordinates; empties in constant time.
#[derive(Debug, Default)]
pub(crate) struct PointSet {
    slots: Vec<(u32, u32)>,
    len: usize,
    round: u32,
}

impl PointSet {
    /// Forgets all points.
    pub fn clear(&mut self) {
        if self.slots.is_empty() || self.round == u32::MAX {
            self.slots = vec![(0, 0); self.slots.len().max(256)];
            self.round = 0;
        }
        self.round += 1;
        self.len = 0;
    }

    /// The place of a point among the `known`, which are numbered as they were added, and whether it is new: then it is the next.
    pub fn insert(&mut self, x: &Point, known: &[Point]) -> (u32, bool) {
        if 2 * self.len >= self.slots.len() {
            self.slots = vec![(0, 0); 2 * self.slots.len()];
            for (y, i) in known.iter().zip(0..) {
                let at = self.find(y, known);
                self.slots[at] = (self.round, i);
            }
        }
        let at = self.find(x, known);
        if self.slots[at].0 == self.round {
            return (self.slots[at].1, false);
        }
        self.slots[at] = (self.round, self.len as u32);
        self.len += 1;
        (self.slots[at].1, true)
    }

    /// The slot of a point, or the free one where it belongs.
    fn find(&self, x: &Point, known: &[Point]) -> usize {
        let mask = self.slots.len() - 1;
        // Adding 0 makes one zero of the two.
        let hash =
            x.iter().fold(0u64, |h, c| (h.rotate_left(21) ^ (c + 0.0).to_bits()).wrapping_mul(0x9e37_79b9_7f4a_7c15));
        let mut at = (hash >> 32) as usize & mask;
        while self.slots[at].0 == self.round && known[self.slots[at].1 as usize] != *x {
            at = (at + 1) & mask;
        }
        at
    }
}
