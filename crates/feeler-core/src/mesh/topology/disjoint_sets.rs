//! Disjoint sets.

/// Disjoint sets of the numbers below a limit (union-find with path halving).
pub struct DisjointSets(pub Vec<u32>);

impl DisjointSets {
    pub fn of(&mut self, mut i: u32) -> u32 {
        while self.0[i as usize] != i {
            self.0[i as usize] = self.0[self.0[i as usize] as usize];
            i = self.0[i as usize];
        }
        i
    }

    /// Makes the next questions short.
    pub fn flatten(&mut self) {
        // DisjointSets come first.
        (0..self.0.len()).for_each(|i| self.0[i] = self.0[self.0[i] as usize]);
    }

    pub fn join(&mut self, i: u32, j: u32) {
        let (a, b) = (self.of(i), self.of(j));
        // The smaller number is the root, so that the order of joins does not show.
        self.0[a.max(b) as usize] = a.min(b);
    }
}
