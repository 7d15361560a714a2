//! Union-find with path halving (Tarjan and van Leeuwen: *Worst-case analysis of set union algorithms*, 1984).
//!
//! Deviation: a union is not by rank but makes the smaller number the root, so that roots do not depend on the order of unions.

/// Disjoint sets of the numbers below a limit: for each number a smaller one of its set, or itself at the root.
pub struct DisjointSets(pub Vec<u32>);

impl DisjointSets {
    /// The root of a number's set, the smallest number in it.
    pub fn of(&mut self, mut i: u32) -> u32 {
        while self.0[i as usize] != i {
            self.0[i as usize] = self.0[self.0[i as usize] as usize];
            i = self.0[i as usize];
        }
        i
    }

    /// Points every number to its root, so that the next finds take one step.
    pub fn flatten(&mut self) {
        // A parent is smaller, so it points to its root already.
        (0..self.0.len()).for_each(|i| self.0[i] = self.0[self.0[i] as usize]);
    }

    /// Joins the sets of two numbers.
    pub fn join(&mut self, i: u32, j: u32) {
        let (a, b) = (self.of(i), self.of(j));
        self.0[a.max(b) as usize] = a.min(b);
    }
}
