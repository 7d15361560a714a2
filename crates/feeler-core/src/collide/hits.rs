//! The pairs found by a query, and their order.

use crate::geometry::intersect_triangle_triangle::PairKind;
use crate::index::interner::pair_key;
use feeler_lanes::{Checked, Kernel, Simd, Sorter};

/// A found pair and its kind in one number, in the order of results.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Hit(u64);

impl Hit {
    pub fn new(tool_triangle: u32, mockup_triangle: u32, kind: PairKind) -> Hit {
        Hit(pair_key(tool_triangle, mockup_triangle) << 2 | kind as u64)
    }

    /// `[tool triangle, mock-up triangle]`.
    pub fn pair(self) -> [u32; 2] {
        [(self.0 >> 34) as u32, (self.0 >> 2) as u32]
    }

    /// The kind of collision.
    pub fn kind(self) -> PairKind {
        match self.0 & 3 {
            0 => PairKind::Coplanar,
            1 => PairKind::Crossing,
            _ => PairKind::Touching,
        }
    }
}

/// The results of a query so far, with repetitions; at the end sorted, each once.
#[derive(Debug)]
pub struct Hits(Sorter);

impl Default for Hits {
    fn default() -> Hits {
        Hits(Sorter::with_capacity(1024))
    }
}

impl Hits {
    pub fn clear(&mut self) {
        self.0.clear();
    }

    #[inline]
    pub fn push(&mut self, hit: Hit) {
        self.0.keys.push(hit.0);
    }

    /// Adds pairs.
    #[inline]
    pub fn extend(&mut self, hits: impl ExactSizeIterator<Item = Hit>) {
        self.0.keys.extend(hits.map(|hit| hit.0));
    }

    /// Whether there are none so far.
    pub fn is_empty(&self) -> bool {
        self.0.keys.is_empty()
    }

    /// Puts all in order, each once; no more are added then.
    pub fn sort(&mut self, lanes: Checked) {
        self.0.sort(lanes);
    }

    /// All, once they are in order.
    pub fn sorted(&self) -> impl ExactSizeIterator<Item = Hit> + '_ {
        self.0.sorted().iter().map(|key| Hit(*key))
    }

    /// Appends all, once they are in order.
    pub fn unpack(&self, lanes: Checked, pairs: &mut Vec<[u32; 2]>, kinds: &mut Vec<PairKind>) {
        lanes.run(Unpack { keys: self.0.sorted(), pairs, kinds });
    }
}

/// Appends pairs and how they meet.
struct Unpack<'a> {
    keys: &'a [u64],
    pairs: &'a mut Vec<[u32; 2]>,
    kinds: &'a mut Vec<PairKind>,
}

impl Kernel for Unpack<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, _: S) {
        self.pairs.extend(self.keys.iter().map(|key| Hit(*key).pair()));
        self.kinds.extend(self.keys.iter().map(|key| Hit(*key).kind()));
    }
}
