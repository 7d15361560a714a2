//! The lowest places on a few arcs of directions, sought on all of them at once.

use crate::bounds::Point;
use crate::simd::WIDE_LANES;
use crate::vectors::{along, dot, scaled, unit};

/// Depths asked for on each arc: two to begin with, then one a step.
pub(crate) const ARC_STEPS: usize = 10;

/// Of the golden section.
const RATIO: f64 = 0.618_033_988_749_894_9;

/// Share of an arc that a trimmed end stays off for rounding.
const TRIMMED: f64 = 1e-7;

/// An arc between two directions, and what is left of it.
#[derive(Debug, Clone, Copy, Default)]
struct Arc {
    ends: [Point; 2],
    /// One less the cosine between them.
    turn: f64,
    from: f64,
    to: f64,
    /// Where it is known or asked for, and the depths there.
    at: [f64; 2],
    depth: [f64; 2],
    /// Outside of these no direction is less deep than a limit.
    low: f64,
    high: f64,
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

    /// Leaves out the directions along which a way is at least so long as a limit, which is positive: those of a cap around
    /// the way, from one end of what is left or from both.
    fn trim(&mut self, way: &Point, limit: f64) {
        let [a, b] = self.ends.map(|d| dot(way, &d));
        // A direction is a point of the chord, whose square is 1 - 2 s (1 - s) turn, over its length: the cap's border is where
        // x s^2 + 2 y s + z = 0.
        let (rise, square) = (b - a, limit * limit);
        let (x, y, z) = (rise * rise - 2.0 * square * self.turn, a * rise + square * self.turn, a * a - square);
        let is_within = |s: f64| a + rise * s > 0.0 && (x * s + 2.0 * y) * s + z >= 0.0;
        let (first, last) = (is_within(self.low), is_within(self.high));
        if first && last {
            self.low = self.high;
        } else if first || last {
            let root = (y * y - x * z).max(0.0).sqrt();
            // The one that does not cancel, and the other by their product.
            let far = -(y + root.copysign(y));
            for border in [far / x, z / far].into_iter().filter(|s| (self.low..=self.high).contains(s)) {
                if a + rise * border > 0.0 {
                    // Not beyond what rounding leaves certain.
                    match first {
                        true => self.low = self.low.max(border - TRIMMED),
                        false => self.high = self.high.min(border + TRIMMED),
                    }
                    break;
                }
            }
        }
    }

    /// Whether a direction is left that may be less deep.
    fn is_open(&self) -> bool {
        self.low.max(self.from) < self.high.min(self.to)
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
        let turn = 1.0 - dot(&ends[0], &ends[1]);
        self.arcs[self.count] = Arc { ends, turn, to: 1.0, high: 1.0, at: [1.0 - RATIO, RATIO], ..Arc::default() };
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

    /// Drops arcs on which no direction is less deep than a limit, for the ways taken so far, and now one of each arc, are that
    /// long along all of them.
    pub fn drop_beyond(&mut self, limit: f64, way: impl Fn(usize) -> Point) {
        let mut kept = 0;
        for i in 0..self.count {
            let mut arc = self.arcs[i];
            arc.trim(&way(i), limit);
            if arc.is_open() {
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
