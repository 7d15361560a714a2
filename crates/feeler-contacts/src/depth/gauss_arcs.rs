//! The axis of least depth on a few arcs of the Gauss map, searched on all of them at once.
//!
//! An arc runs between the normals of two facets of one body: the axes that an edge of it may hold (D. Gregorius: The separating
//! axis test between convex polyhedra, GDC 2013, tests the one where it crosses an arc of the other body; here surfaces are
//! curved and the other side has any number of points). The depth is the support function of the Minkowski difference, convex
//! over vectors, and a support point bounds it from below everywhere. Between two axes whose support points are known it is least
//! at one of them, or nowhere less than where the two bounds are equal: that axis is tried next, until the bound is
//! reached.

use feeler_core::geometry::bounds::Point;
use feeler_core::geometry::vectors::{along, dot, scaled, sub, unit};
use feeler_lanes::WIDE_LANES;

use crate::constants::{ARC_BOUND_SHARE, MOST_ARC_SPANS};
use crate::depth::axis::is_against;

/// Part of an arc.
#[derive(Debug, Clone, Copy)]
struct ArcSpan {
    /// The axes tried at its ends, and the support points of the Minkowski difference there.
    ends: [Point; 2],
    supports: [Point; 2],
    /// The axis to try next, and the bound there: no depth on the span is less.
    middle: Point,
    bound: f64,
}

/// Spans that may hold an axis of less depth.
#[derive(Debug, Default)]
pub(crate) struct GaussArcs {
    spans: Vec<ArcSpan>,
    asked: Vec<ArcSpan>,
    /// Mean normals: an axis against one of them leads in.
    outward: [Point; 2],
}

impl GaussArcs {
    /// For another pair of bodies.
    pub fn clear(&mut self, outward: [Point; 2]) {
        self.spans.clear();
        self.outward = outward;
    }

    /// Whether an axis between two may lead out: none does where both are against the same mean normal.
    pub fn may_lead_out(&self, ends: &[Point; 2]) -> bool {
        !self.outward.iter().any(|out| ends.iter().all(|d| is_against(d, out)))
    }

    /// Adds the arc between two axes with their support points.
    pub fn push(&mut self, ends: [Point; 2], supports: [Point; 2]) {
        if !self.may_lead_out(&ends) {
            return;
        }
        let turn = sub(&supports[0], &supports[1]);
        let (first, last) = (dot(&turn, &ends[0]), -dot(&turn, &ends[1]));
        if first <= 0.0 || last <= 0.0 || self.spans.len() >= MOST_ARC_SPANS {
            // One point supports both ends, and so all between them: the depth is least at an end.
            return;
        }
        if let Some(middle) = unit(&along(&scaled(&ends[0], last), first, &ends[1])) {
            let bound = dot(&supports[0], &middle).max(dot(&supports[1], &middle));
            self.spans.push(ArcSpan { ends, supports, middle, bound });
        }
    }

    /// The next axes to try, those of least bound first, the last of them repeated; `None` where all bounds are beyond a limit.
    pub fn next_axes(&mut self, limit: f64) -> Option<[Point; WIDE_LANES]> {
        self.spans.retain(|p| p.bound < limit);
        if self.spans.len() > WIDE_LANES {
            self.spans.sort_by(|p, q| p.bound.total_cmp(&q.bound));
        }
        self.asked.clear();
        self.asked.extend(self.spans.drain(..self.spans.len().min(WIDE_LANES)));
        let last = self.asked.len().checked_sub(1)?;
        Some(std::array::from_fn(|i| self.asked[i.min(last)].middle))
    }

    /// How many of these are not repeated.
    pub fn asked_count(&self) -> usize {
        self.asked.len()
    }

    /// Takes the support point along the `i`-th of them and halves its span, unless the depth meets the bound but for noise.
    pub fn split(&mut self, i: usize, support: Point, noise: f64) {
        let ArcSpan { ends, supports, middle, bound } = self.asked[i];
        if dot(&support, &middle) > bound * (1.0 + ARC_BOUND_SHARE) + noise {
            self.push([ends[0], middle], [supports[0], support]);
            self.push([middle, ends[1]], [support, supports[1]]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_axis_of_an_arc_that_may_not_lead_out_does() {
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
            assert!(may || arcs.next_axes(f64::INFINITY).is_none());
        }
        assert!(counts.iter().all(|count| *count > 30), "{counts:?}");
    }

    #[test]
    fn no_sampled_axis_of_an_arc_is_less_deep_than_the_one_found() {
        let wave = |i: usize| [(0.7 * i as f64).sin(), (1.9 * i as f64).cos(), (1.3 * i as f64).sin()];
        for round in 0..200 {
            // A difference symmetric about the origin, so that all depths are positive.
            let points: Vec<Point> =
                (0..12).map(|i| wave(12 * round + i)).flat_map(|p| [p, scaled(&p, -1.0)]).collect();
            let support_along = |d: &Point| *points.iter().max_by(|p, q| dot(p, d).total_cmp(&dot(q, d))).unwrap();
            let ends = [0, 1].map(|i| unit(&wave(1000 + 3 * round + i)).unwrap());
            if dot(&ends[0], &ends[1]) < -0.5 {
                continue;
            }
            let mut least = ends.iter().map(|d| dot(&support_along(d), d)).fold(f64::INFINITY, f64::min);
            let mut arcs = GaussArcs::default();
            arcs.push(ends, ends.map(|d| support_along(&d)));
            let mut asked = 0;
            while let Some(directions) = arcs.next_axes(least) {
                for (i, d) in directions.iter().enumerate().take(arcs.asked_count()) {
                    let support = support_along(d);
                    least = least.min(dot(&support, d));
                    arcs.split(i, support, 1e-12);
                    asked += 1;
                }
            }
            assert!(asked <= 24, "{asked}");
            for step in 0..=1000 {
                let s = f64::from(step) / 1000.0;
                let d = unit(&along(&scaled(&ends[0], 1.0 - s), s, &ends[1])).unwrap();
                assert!(least <= dot(&support_along(&d), &d) + 1e-9, "{round} {step}");
            }
        }
    }
}
