//! The lowest places on a few arcs of directions, sought on all of them at once.

use crate::bounds::Point;
use crate::simd::WIDE_LANES;
use crate::vectors::{along, dot, scaled, unit};

/// Depths asked for on each arc: two to begin with, then one a step.
pub(crate) const ARC_STEPS: usize = 10;

/// Of the golden section.
const RATIO: f64 = 0.618_033_988_749_894_9;

/// An arc between two directions, and what is left of it.
#[derive(Debug, Clone, Copy, Default)]
struct Arc {
    ends: [Point; 2],
    from: f64,
    to: f64,
    /// Where it is known or asked for, and the depths there.
    at: [f64; 2],
    depth: [f64; 2],
    /// Which of the two is asked for.
    asked: usize,
}

impl Arc {
    fn direction(&self, s: f64) -> Option<Point> {
        unit(&along(&scaled(&self.ends[0], 1.0 - s), s, &self.ends[1]))
    }

    /// Keeps the half with the lesser depth.
    fn narrow(&mut self) {
        if self.depth[0] <= self.depth[1] {
            (self.to, self.at[1], self.depth[1]) = (self.at[1], self.at[0], self.depth[0]);
            self.at[0] = self.to - RATIO * (self.to - self.from);
            self.asked = 0;
        } else {
            (self.from, self.at[0], self.depth[0]) = (self.at[0], self.at[1], self.depth[1]);
            self.at[1] = self.from + RATIO * (self.to - self.from);
            self.asked = 1;
        }
    }
}

/// At most eight arcs.
#[derive(Debug, Default)]
pub(crate) struct Arcs {
    arcs: [Arc; WIDE_LANES],
    count: usize,
}

impl Arcs {
    /// Adds an arc between two directions.
    pub fn push(&mut self, ends: [Point; 2]) {
        self.arcs[self.count] = Arc { ends, to: 1.0, at: [1.0 - RATIO, RATIO], ..Arc::default() };
        self.count += 1;
    }

    /// Directions whose depths are wanted next, one an arc.
    pub fn next(&mut self, step: usize) -> [Point; WIDE_LANES] {
        let mut directions = [[0.0; 3]; WIDE_LANES];
        for (arc, d) in self.arcs[..self.count].iter_mut().zip(&mut directions) {
            match step {
                0 | 1 => arc.asked = step,
                _ => arc.narrow(),
            }
            *d = arc.direction(arc.at[arc.asked]).unwrap_or(arc.ends[0]);
        }
        directions
    }

    /// Takes the depths asked for.
    pub fn take(&mut self, depth: impl Fn(usize) -> f64) {
        for (i, arc) in self.arcs[..self.count].iter_mut().enumerate() {
            arc.depth[arc.asked] = depth(i);
        }
    }

    /// Drops arcs on which no direction is less deep than a limit, for a way (of each arc) is that long along both ends.
    pub fn drop_beyond(&mut self, limit: f64, way: impl Fn(usize) -> Point) {
        let mut kept = 0;
        for i in 0..self.count {
            let arc = self.arcs[i];
            let way = way(i);
            if !arc.ends.iter().all(|d| dot(&way, d) >= limit) {
                self.arcs[kept] = arc;
                kept += 1;
            }
        }
        self.count = kept;
    }

    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// The middles of what is left in the end.
    pub fn lowest(&mut self) -> impl Iterator<Item = Point> + '_ {
        self.arcs[..self.count].iter_mut().filter_map(|arc| {
            arc.narrow();
            arc.direction(0.5 * (arc.from + arc.to))
        })
    }
}
