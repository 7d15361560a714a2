//! From the best direction among the normals and edges of two bodies to less depth between them, where surfaces are curved.

use crate::depth::axis::{eight_of, middle, BodyPair, TriedAxis};
use crate::depth::axis_search::AxisSearch;
use crate::depth::gauss_arcs::GaussArcs;
use crate::patch::body::Body;
use feeler_core::geometry::bounds::Point;
use feeler_core::geometry::vectors::{along, dot, length, scaled, sub, unit};
use feeler_lanes::WIDE_LANES;

/// Most patches of a body, the largest, between whose normals directions are sought.
const MOST_TURNED: usize = 3;

/// Each two of those of one body, and of the other.
const EDGES: [[usize; 2]; 6] = [[0, 1], [0, 2], [1, 2], [3, 4], [3, 5], [4, 5]];

/// Most times that eight places on the arcs between them are tried.
const MOST_TURNS: usize = 6;

/// Most steps of the descent, the share by which each that leads nowhere shortens the next, and the length (radians, about) of the
/// last.
const MOST_STEPS: usize = 24;
const SHORTER: f64 = 0.6;
const SHORTEST_STEP: f64 = 0.01;

impl AxisSearch<'_> {
    /// The valleys between the normals of each two large patches of a body: where an edge holds, the least depth lies on the
    /// arc around it, in a valley too narrow for the descent when the edge is long. All arcs at once.
    pub fn turn_around_edges(&mut self, arcs: &mut GaussArcs) {
        let BodyPair { tool, mockup, .. } = self.pair;
        arcs.clear(self.pair.outward());
        let mut ends = [[0.0; 3]; WIDE_LANES];
        let normals = |body: &Body<'_>, sense: f64| {
            let of = body.facets.get(..MOST_TURNED).unwrap_or(body.facets);
            (of.len(), std::array::from_fn::<_, MOST_TURNED, _>(|i| scaled(&of[i.min(of.len() - 1)].normal, sense)))
        };
        let sides = [normals(mockup, 1.0), normals(tool, -1.0)];
        sides.iter().enumerate().for_each(|(k, (_, n))| ends[MOST_TURNED * k..][..MOST_TURNED].copy_from_slice(n));
        let is_arc = EDGES.map(|[i, j]| {
            let ends = [ends[i], ends[j]];
            // Opposite faces have no edge, and nearly equal ones no arc to speak of.
            let is_turn = (-0.5..0.95).contains(&dot(&ends[0], &ends[1]));
            j % MOST_TURNED < sides[i / MOST_TURNED].0 && is_turn && arcs.may_lead_out(&ends)
        });
        if is_arc.contains(&true) {
            let support = self.support(&ends);
            for ([i, j], _) in EDGES.into_iter().zip(is_arc).filter(|(_, is_arc)| *is_arc) {
                arcs.push([ends[i], ends[j]], [self.way(&support, i), self.way(&support, j)]);
            }
        }
        for _ in 0..MOST_TURNS {
            let Some(directions) = arcs.lowest(self.limit()) else { break };
            let support = self.support(&directions);
            for i in 0..arcs.asked() {
                let (high, low) = (support.0.height[i], support.1.height[i]);
                let tried = TriedAxis { direction: directions[i], high, low };
                if self.leads_out(&directions[i]) {
                    self.offer(&tried);
                }
                arcs.answer(i, self.way(&support, i), self.noise);
            }
        }
    }

    /// From the best direction down to the nearest valley: the gradient of the depth is the way between the two extreme places,
    /// across the direction. FaceNumbers, not points: along an edge or a face many are extreme, and their middle counts.
    pub fn descend(&mut self) {
        let mut list: Vec<Point> = Vec::with_capacity(WIDE_LANES);
        let (mut step, mut tries) = (1.0, 0);
        while let Some(found) = self.found.filter(|f| f.depth() > self.noise) {
            let d = found.direction;
            let (above, below) = self.extremes(&found, 0.02);
            let way = sub(&middle(&above), &middle(&below));
            let across = along(&way, -dot(&way, &d), &d);
            let size = length(&way).max(f64::MIN_POSITIVE);
            // Ever shorter steps, until one leads down.
            while self.found.is_some_and(|f| f.direction == d) {
                list.clear();
                let mut shorter = step;
                while list.len() < WIDE_LANES && tries + list.len() < MOST_STEPS && shorter >= SHORTEST_STEP {
                    let Some(next) = unit(&along(&d, -shorter / size, &across)) else { break };
                    list.push(next);
                    shorter *= SHORTER;
                }
                if list.is_empty() {
                    return;
                }
                for tried in &self.tried(&eight_of(&list))[..list.len()] {
                    tries += 1;
                    if self.leads_out(&tried.direction) && self.offer(tried) {
                        break;
                    }
                    step *= SHORTER;
                }
            }
        }
    }
}
