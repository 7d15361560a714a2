//! The least deep directions on a few arcs, sought on all of them at once.
//!
//! Along each direction tried two places are extreme, and the way from one to the other bounds the depth everywhere. Between
//! two directions the depth is least at one of them, or nowhere less than where their two ways are as long as each other: there
//! it is tried next, until it is that deep.

use feeler_core::geometry::bounds::Point;
use feeler_core::geometry::vectors::{along, dot, scaled, sub, unit};
use feeler_lanes::WIDE_LANES;

/// Most pieces that are kept.
const MOST_SPANS: usize = 64;

/// Sine from which on.
pub(crate) const AGAINST: f64 = 0.01;

/// Part of an arc.
#[derive(Debug, Clone, Copy)]
struct ArcSpan {
    /// DepthScratch tried, and their ways.
    ends: [Point; 2],
    ways: [Point; 2],
    /// Between them, where to try next, and no depth is less.
    middle: Point,
    bound: f64,
}

/// Whether a direction clearly points the other way from another.
pub(crate) fn is_against(d: &Point, other: &Point) -> bool {
    dot(d, other) <= -AGAINST
}

/// Pieces of arcs that may hold what is less deep.
#[derive(Debug, Default)]
pub(crate) struct GaussArcs {
    spans: Vec<ArcSpan>,
    asked: Vec<ArcSpan>,
    /// No direction is sought that is against one of these.
    outward: [Point; 2],
}

impl GaussArcs {
    /// For arcs whose directions are to lead out: not against two others.
    pub fn clear(&mut self, outward: [Point; 2]) {
        self.spans.clear();
        self.outward = outward;
    }

    /// Whether anything between two directions may: it is against what both are.
    pub fn may_lead_out(&self, ends: &[Point; 2]) -> bool {
        !self.outward.iter().any(|out| ends.iter().all(|d| is_against(d, out)))
    }

    /// Adds an arc between two directions with their ways, each the longest along its own.
    pub fn push(&mut self, ends: [Point; 2], ways: [Point; 2]) {
        if !self.may_lead_out(&ends) {
            return;
        }
        let turn = sub(&ways[0], &ways[1]);
        let (first, last) = (dot(&turn, &ends[0]), -dot(&turn, &ends[1]));
        if first <= 0.0 || last <= 0.0 || self.spans.len() >= MOST_SPANS {
            // One way is the longest at both ends, and so it is between them: nothing there is less deep.
            return;
        }
        if let Some(middle) = unit(&along(&scaled(&ends[0], last), first, &ends[1])) {
            let bound = dot(&ways[0], &middle).max(dot(&ways[1], &middle));
            self.spans.push(ArcSpan { ends, ways, middle, bound });
        }
    }

    /// The next directions to be tried, those first where least depth is possible, the last several times; none where all
    /// depths are beyond a limit.
    pub fn lowest(&mut self, limit: f64) -> Option<[Point; WIDE_LANES]> {
        self.spans.retain(|p| p.bound < limit);
        if self.spans.len() > WIDE_LANES {
            self.spans.sort_by(|p, q| p.bound.total_cmp(&q.bound));
        }
        self.asked.clear();
        self.asked.extend(self.spans.drain(..self.spans.len().min(WIDE_LANES)));
        let last = self.asked.len().checked_sub(1)?;
        Some(std::array::from_fn(|i| self.asked[i.min(last)].middle))
    }

    /// How many of them are not repeated.
    pub fn asked(&self) -> usize {
        self.asked.len()
    }

    /// Takes the way found along one of them. Within the noise it is as deep as it was bound to be, and that piece is done.
    pub fn answer(&mut self, i: usize, way: Point, noise: f64) {
        let ArcSpan { ends, ways, middle, bound } = self.asked[i];
        if dot(&way, &middle) > bound * (1.0 + 1e-6) + noise {
            self.push([ends[0], middle], [ways[0], way]);
            self.push([middle, ends[1]], [way, ways[1]]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_may_not_lead_out_does_nowhere() {
        let wave = |i: usize| unit(&[(0.7 * i as f64).sin(), (1.9 * i as f64).cos(), (1.3 * i as f64).sin()]).unwrap();
        let mut counts = [0; 2];
        for i in 0..200 {
            let (ends, mut arcs) = ([wave(i), wave(3 * i + 7)], GaussArcs::default());
            arcs.clear([wave(5 * i + 1), wave(7 * i + 2)]);
            let may = arcs.may_lead_out(&ends);
            counts[usize::from(may)] += 1;
            let between = |s: f64| unit(&along(&scaled(&ends[0], 1.0 - s), s, &ends[1]));
            for d in (0..=100).filter_map(|k| between(0.01 * f64::from(k))) {
                assert!(may || arcs.outward.iter().any(|out| is_against(&d, out)), "{i} {d:?}");
            }
            arcs.push(ends, [scaled(&ends[0], 2.0), scaled(&ends[1], 2.0)]);
            assert!(may || arcs.lowest(f64::INFINITY).is_none());
        }
        assert!(counts.iter().all(|count| *count > 30), "{counts:?}");
    }

    #[test]
    fn nothing_on_an_arc_is_less_deep_than_what_is_found() {
        let wave = |i: usize| [(0.7 * i as f64).sin(), (1.9 * i as f64).cos(), (1.3 * i as f64).sin()];
        for round in 0..200 {
            // Ways to both sides, so that all depths are positive.
            let ways: Vec<Point> = (0..12).map(|i| wave(12 * round + i)).flat_map(|p| [p, scaled(&p, -1.0)]).collect();
            let longest = |d: &Point| *ways.iter().max_by(|p, q| dot(p, d).total_cmp(&dot(q, d))).unwrap();
            let ends = [0, 1].map(|i| unit(&wave(1000 + 3 * round + i)).unwrap());
            if dot(&ends[0], &ends[1]) < -0.5 {
                continue;
            }
            let mut least = ends.iter().map(|d| dot(&longest(d), d)).fold(f64::INFINITY, f64::min);
            let mut arcs = GaussArcs::default();
            arcs.push(ends, ends.map(|d| longest(&d)));
            let mut asked = 0;
            while let Some(directions) = arcs.lowest(least) {
                for (i, d) in directions.iter().enumerate().take(arcs.asked()) {
                    let way = longest(d);
                    least = least.min(dot(&way, d));
                    arcs.answer(i, way, 1e-12);
                    asked += 1;
                }
            }
            assert!(asked <= 24, "{asked}");
            for step in 0..=1000 {
                let s = f64::from(step) / 1000.0;
                let d = unit(&along(&scaled(&ends[0], 1.0 - s), s, &ends[1])).unwrap();
                assert!(least <= dot(&longest(&d), &d) + 1e-9, "{round} {step}");
            }
        }
    }
}
