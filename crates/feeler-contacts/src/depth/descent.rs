//! Improves the best axis among the normals and edges of two bodies where surfaces are curved.
//!
//! The depth along an axis is the support function of the Minkowski difference. The descent searches arcs of the Gauss
//! map, then follows the gradient over the unit sphere. It finds a local minimum, an upper bound of the penetration
//! depth. Expanding polytopes (G. van den Bergen: Proximity queries and penetration depth computation on 3D game
//! objects, GDC 2001) find the global one for two convex sets, but cannot exclude axes that are blocked or lead in.

use crate::constants::{
    ARC_COSINES, DESCENT_EXTREME_SHARE, DESCENT_STEP_RATIO, MOST_ARC_ROUNDS, MOST_DESCENT_STEPS, SHORTEST_DESCENT_STEP,
};
use crate::depth::axis::{centre, eight_of, BodyPair, TriedAxis};
use crate::depth::axis_search::AxisSearch;
use crate::depth::gauss_arcs::GaussArcs;
use crate::patch::body::Body;
use feeler_core::geometry::bounds::Point;
use feeler_core::geometry::vectors::{along, dot, length, scaled, sub, unit};
use feeler_lanes::WIDE_LANES;

/// Facets of a body, the largest, between whose normals arcs are searched: those of both fit the lanes.
const MOST_ARC_FACETS: usize = 3;

/// Each two facets of one body, and of the other.
const FACET_PAIRS: [[usize; 2]; 6] = [[0, 1], [0, 2], [1, 2], [3, 4], [3, 5], [4, 5]];

impl AxisSearch<'_> {
    /// The arcs between the normals of each two large facets of a body, all at once. Where an edge holds, the least depth lies on
    /// the arc around it, in a valley too narrow for the descent when the edge is long.
    pub fn search_arcs(&mut self, arcs: &mut GaussArcs) {
        let BodyPair { tool, mockup, .. } = self.pair;
        arcs.clear(self.pair.outward());
        let mut ends = [[0.0; 3]; WIDE_LANES];
        let normals = |body: &Body<'_>, sense: f64| {
            let of = body.facets.get(..MOST_ARC_FACETS).unwrap_or(body.facets);
            (of.len(), std::array::from_fn::<_, MOST_ARC_FACETS, _>(|i| scaled(&of[i.min(of.len() - 1)].normal, sense)))
        };
        let both = [normals(mockup, 1.0), normals(tool, -1.0)];
        both.iter()
            .enumerate()
            .for_each(|(k, (_, n))| ends[MOST_ARC_FACETS * k..][..MOST_ARC_FACETS].copy_from_slice(n));
        let is_arc = FACET_PAIRS.map(|[i, j]| {
            let ends = [ends[i], ends[j]];
            let is_turn = ARC_COSINES.contains(&dot(&ends[0], &ends[1]));
            j % MOST_ARC_FACETS < both[i / MOST_ARC_FACETS].0 && is_turn && arcs.may_lead_out(&ends)
        });
        if is_arc.contains(&true) {
            let supports = self.supports(&ends);
            for ([i, j], _) in FACET_PAIRS.into_iter().zip(is_arc).filter(|(_, is_arc)| *is_arc) {
                arcs.push([ends[i], ends[j]], [self.difference(&supports, i), self.difference(&supports, j)]);
            }
        }
        for _ in 0..MOST_ARC_ROUNDS {
            let Some(directions) = arcs.next_axes(self.limit()) else { break };
            let supports = self.supports(&directions);
            for i in 0..arcs.asked_count() {
                let (high, low) = (supports.0.height[i], supports.1.height[i]);
                let tried = TriedAxis { direction: directions[i], high, low };
                if self.is_leading_out(&directions[i]) {
                    self.offer(&tried);
                }
                arcs.split(i, self.difference(&supports, i), self.noise);
            }
        }
    }

    /// Gradient descent from the best axis. The gradient of the depth is the support point of the Minkowski difference, less its
    /// part along the axis. Boxes around the extreme points, not one point of them: along an edge or a face many are extreme, and
    /// the centre of them counts.
    pub fn descend(&mut self) {
        let mut list: Vec<Point> = Vec::with_capacity(WIDE_LANES);
        let (mut step, mut tries) = (1.0, 0);
        while let Some(best) = self.best.filter(|f| f.depth() > self.noise) {
            let d = best.direction;
            let (above, below) = self.extreme_boxes(&best, DESCENT_EXTREME_SHARE);
            let difference = sub(&centre(&above), &centre(&below));
            let gradient = along(&difference, -dot(&difference, &d), &d);
            let size = length(&difference).max(f64::MIN_POSITIVE);
            // Ever shorter steps, until one leads down.
            while self.best.is_some_and(|f| f.direction == d) {
                list.clear();
                let mut shorter = step;
                while list.len() < WIDE_LANES
                    && tries + list.len() < MOST_DESCENT_STEPS
                    && shorter >= SHORTEST_DESCENT_STEP
                {
                    let Some(next) = unit(&along(&d, -shorter / size, &gradient)) else { break };
                    list.push(next);
                    shorter *= DESCENT_STEP_RATIO;
                }
                if list.is_empty() {
                    return;
                }
                for tried in &self.measure(&eight_of(&list))[..list.len()] {
                    tries += 1;
                    if self.is_leading_out(&tried.direction) && self.offer(tried) {
                        break;
                    }
                    step *= DESCENT_STEP_RATIO;
                }
            }
        }
    }
}
