//! How deep two bulging surfaces are in each other, and along which direction least.
//!
//! Along a unit direction d the depth is the highest of the mock-up's points less the lowest of the tool's: the way the tool
//! has to go along d until a plane across d holds the two apart. The least of it over all d is at a normal of one of the two,
//! or at a direction across an edge of each, as for any two polytopes; for curved surfaces a short [`descent`](super::descent)
//! follows.

use feeler_core::Point;

use crate::constants::SHALLOWER;
use crate::context::QueryContext;
use crate::depth::axis::{BodyPair, TriedAxis};
use crate::depth::axis_blocked::BlockedAxes;
use crate::depth::axis_search::AxisSearch;
use crate::depth::directional_overlap::DirectionalOverlap;
use crate::depth::edge_axes::EdgeAxes;
use crate::depth::face_axes::{FaceAxes, FaceDepth};
use crate::depth::gauss_arcs::GaussArcs;
use crate::patch::body::{Facets, MOST_EDGES};

/// Share of a depth that is all of it.
const ALL: f64 = 0.9;

/// Share of that by which overlaps are looked for first.
const MUCH: f64 = 0.75;

/// The least depth of a tool body in a mock-up body.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Depth {
    /// Unit, from the mock-up to the tool.
    pub normal: Point,
    /// Metres, until a plane across the normal holds the two apart.
    depth: f64,
    overlap: Overlapping,
    /// How high the mock-up's body is along the normal.
    high: f64,
    /// On the mock-up's side of the overlap, above the tool's lowest place.
    pub point: Point,
    /// Whether no direction can be shallower: both surfaces flat, and all candidates tried.
    pub certain: bool,
}

/// How much two bodies overlap along the direction for which they are so deep. Where that is clearly less, one reaches over a hollow
/// that the other fills, and no plane has to hold them apart.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Overlapping {
    NotAsked,
    All,
    /// By so many metres at most.
    AtMost(f64),
    Measured(f64),
}

impl Depth {
    /// Of its plane: negative, or nothing. As long as the overlap is not [measured](BodyPair::measure), as much as it may be.
    pub fn gap(&self) -> f64 {
        let most = match self.overlap {
            Overlapping::NotAsked | Overlapping::All => self.depth,
            Overlapping::AtMost(overlap) | Overlapping::Measured(overlap) => overlap,
        };
        -most.max(0.0)
    }

    /// Whether its gap is no bound only.
    pub fn is_known(&self) -> bool {
        matches!(self.overlap, Overlapping::All | Overlapping::Measured(_))
    }

    /// Whether it is an overlap, and no more than another.
    pub fn is_less_than(&self, other: &Depth) -> bool {
        !self.may_hold() && self.gap() >= other.gap()
    }

    /// Whether its plane may be needed to hold the two apart.
    fn may_hold(&self) -> bool {
        matches!(self.overlap, Overlapping::NotAsked | Overlapping::All)
    }
}

/// Working memory.
#[derive(Debug, Default)]
pub(crate) struct DepthScratch {
    edge_pairs: EdgeAxes,
    normals: FaceAxes,
    arcs: GaussArcs,
    overlap: DirectionalOverlap,
    /// Bodies of the tool with directions of planes and overlaps along them, for which it was asked whether others overlap by more; and
    /// whether nothing of the mock-up does.
    held: Vec<((usize, Point, f64), Option<bool>)>,
    blocked: BlockedAxes,
}

impl DepthScratch {
    /// See [`FaceAxes::push_face_depths`].
    pub fn push_face_depths<'a>(
        &mut self,
        pairs: impl Iterator<Item = BodyPair<'a>> + Clone,
        out: &mut Vec<(FaceDepth, [usize; 2])>,
    ) {
        self.normals.push_face_depths(pairs, &mut self.blocked, out);
    }

    /// For the bodies of another zone, so many of the tool and of the mock-up.
    pub fn clear(&mut self, bodies: [usize; 2]) {
        self.overlap.clear(bodies);
        self.held.clear();
        self.edge_pairs.clear();
        self.blocked.clear(bodies);
    }
}

impl BodyPair<'_> {
    /// How deep two that are so deep along the best of their normals are along a plane's, if it holds them apart as well: where it
    /// is less deep than that, only if nothing goes on along it either.
    pub fn held_depth(&self, plane: &Depth, depth: f64, directions: &mut DepthScratch) -> Option<f64> {
        let direction = plane.normal;
        let tried = TriedAxis { direction, high: self.high(&direction), low: self.low(&direction) };
        let is_held = tried.depth() <= plane.depth * (1.0 + SHALLOWER)
            && (plane.depth >= depth || {
                let mut best = AxisSearch::new(self, &mut directions.blocked, None);
                best.leads_out(&direction) && !best.goes_on(&tried)
            });
        is_held.then(|| tried.depth())
    }

    /// Whether a plane found for the same tool body holds the mock-up's apart from it as well.
    pub fn is_under(&self, plane: &Depth) -> bool {
        plane.may_hold() && self.high(&plane.normal) <= plane.high + SHALLOWER * plane.depth
    }

    /// Whether a plane found for the same mock-up body holds the tool's apart from it as well.
    pub fn is_over(&self, plane: &Depth) -> bool {
        plane.may_hold() && self.low(&plane.normal) >= plane.high - plane.depth * (1.0 + SHALLOWER)
    }

    /// The least depth, from the first. `None` where no direction leads out.
    pub fn least_depth(&self, first: &FaceDepth, directions: &mut DepthScratch) -> Option<Depth> {
        let DepthScratch { edge_pairs, arcs, blocked, .. } = directions;
        let mut best = AxisSearch::new(self, blocked, first.found);
        if (1..=MOST_EDGES).contains(&self.edge_pairs()) {
            best.try_all(edge_pairs.directions(self.lanes, self.tool, self.mockup, &self.outward()));
        }
        if !first.certain {
            best.turn_around_edges(arcs);
            best.descend();
        }
        let found = best.found?;
        let (point, certain) = (best.place(&found), first.certain);
        let (normal, depth) = (found.direction, found.depth());
        Some(Depth { normal, depth, overlap: Overlapping::NotAsked, high: found.high, point, certain })
    }

    /// Whether the two overlap as much as they are deep along a direction. Looks once.
    pub fn is_filled(&self, context: &QueryContext<'_>, depth: &mut Depth, directions: &mut DepthScratch) -> bool {
        if depth.overlap == Overlapping::NotAsked {
            let enough = ALL * depth.depth;
            depth.overlap = Overlapping::All;
            if depth.depth > 0.0 {
                // Mostly it is much of that, and few triangles overlap by as much: what there is is measured at once.
                self.find_overlap(context, depth, MUCH * enough, enough, directions);
            }
        }
        depth.overlap == Overlapping::All
    }

    /// Makes a depth what the two overlap, where that is less. Where it is no more than `least` (metres), that is all that is said.
    pub fn measure(&self, context: &QueryContext<'_>, depth: &mut Depth, least: f64, directions: &mut DepthScratch) {
        self.is_filled(context, depth, directions);
        match depth.overlap {
            Overlapping::AtMost(most) if most > least => {}
            _ => return,
        }
        let enough = ALL * depth.depth;
        // Where they only touch there is a point too.
        let more = if least > 0.0 { least } else { -SHALLOWER * enough };
        self.find_overlap(context, depth, more, enough, directions);
    }

    /// Looks for an overlap of more than `least`, which may be nothing or a little less: then no more means none.
    fn find_overlap(
        &self,
        context: &QueryContext<'_>,
        depth: &mut Depth,
        least: f64,
        enough: f64,
        directions: &mut DepthScratch,
    ) {
        let found = directions.overlap.most(context, &self.sides(), &depth.normal, least, enough);
        let Some((most, at)) = found.filter(|(most, _)| *most < enough) else { return };
        depth.certain = false;
        if most > least {
            (depth.overlap, depth.point) = (Overlapping::Measured(most), at);
        } else {
            depth.overlap = if least > 0.0 { Overlapping::AtMost(least) } else { Overlapping::Measured(0.0) };
        }
    }

    /// Whether the two overlap along a direction by no more than others do for which it was found. Where that is asked once more for
    /// the tool's body, it is asked for all that the mock-up has there: mostly none of it overlaps by more.
    pub fn overlaps_no_more(
        &self,
        context: &QueryContext<'_>,
        all: Facets<'_>,
        plane: &Depth,
        directions: &mut DepthScratch,
    ) -> bool {
        let most = -plane.gap();
        let DepthScratch { overlap, held, .. } = directions;
        let [tool, mockup] = self.sides();
        let mut is_more = |mockup| {
            let found = overlap.most(context, &[tool, mockup], &plane.normal, most, most);
            found.is_none_or(|(more, _)| more > most)
        };
        let key = (tool.number, plane.normal, most);
        match held.iter_mut().find(|held| held.0 == key) {
            Some((_, no_more)) => *no_more.get_or_insert_with(|| !is_more(all)) || !is_more(mockup),
            None => {
                held.push((key, None));
                !is_more(mockup)
            }
        }
    }

    fn sides(&self) -> [Facets<'_>; 2] {
        [self.tool.whole(), self.mockup.whole()]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contour::contact_region::ContactRegions;
    use crate::contour::contact_region::{Face, Segment};
    use crate::depth::axis_blocked::Blocker;
    use crate::patch::body::Body;
    use crate::patch::body::Facet;
    use crate::patch::support::push_eights;
    use crate::surface::Surface;
    use crate::tests::{at, scene, tool};
    use feeler_core::geometry::vectors::{across, along, dot, scaled, sub, unit};
    use feeler_lanes::Level;
    use feeler_shapes::{box_mesh, joined};

    #[test]
    fn a_plane_holds_apart_what_it_is_deep_enough_for() {
        let wave = |i: usize| [(0.7 * i as f64).sin(), (1.9 * i as f64).cos(), (0.3 * i as f64).sin()];
        let (high, low): (Vec<Point>, Vec<Point>) = (0..30).map(|i| (wave(i), wave(41 + i))).unzip();
        let mean = [0.0; 3];
        let [low_eights, high_eights] = [&low, &high].map(|points| {
            let mut eights = Vec::new();
            push_eights(points, &mut eights);
            eights
        });
        let body =
            |points, point_eights| Body { points, point_eights, segments_of: &[(0, 0); 30], ..Body::of_facets(&[]) };
        let regions = ContactRegions::default();
        let lanes = Level::best().checked();
        let pair =
            BodyPair { lanes, regions: &regions, tool: &body(&low, &low_eights), mockup: &body(&high, &high_eights) };
        for d in (0..20).filter_map(|i| unit(&wave(100 + i))) {
            let depth = high.iter().flat_map(|p| low.iter().map(|q| dot(&sub(p, q), &d)).collect::<Vec<_>>());
            let depth = depth.fold(f64::NEG_INFINITY, f64::max);
            // Planes as others may have them, a little deeper and a little less deep than would do.
            let plane = |depth: f64, high: f64| Depth {
                normal: d,
                depth,
                overlap: Overlapping::All,
                high,
                point: mean,
                certain: false,
            };
            let of = |depth: f64| plane(depth, 0.0);
            // The last two less deep than along the best of their normals: only where the plane's direction leads out.
            let mut directions = DepthScratch::default();
            directions.clear([1; 2]);
            let mut held =
                |pair: &BodyPair<'_>, plane: f64, first: f64| pair.held_depth(&of(plane), first, &mut directions);
            let inward = BodyPair { mockup: &Body { mean: scaled(&d, -1.0), ..*pair.mockup }, ..pair };
            let is_it = |found: Option<f64>| found.is_some_and(|found| (found - depth).abs() < 1e-12);
            assert!(is_it(held(&pair, depth + 1e-9, 0.0)) && held(&pair, depth - 1e-4, 0.0).is_none(), "{d:?}");
            assert!(is_it(held(&inward, depth + 1e-9, depth)) && is_it(held(&pair, depth + 1e-9, depth + 1e-4)));
            assert!(held(&inward, depth + 1e-9, depth + 1e-4).is_none(), "{d:?}");
            // And only where the mock-up does not go on along it, higher than all of its points.
            let side = across(&d)[0];
            let face = |normal, by: f64| Face { normal, ..Face::new(0, [along(&mean, by, &d); 3], true) };
            let mut regions = ContactRegions::default();
            regions.faces = [vec![face(d, 0.0)], vec![face(side, 9.0)]];
            let segment = Segment { faces: [0; 2], points: (0, 1), flat: false };
            let onward =
                Blocker::advancing(&regions, Surface::Mockup, &segment, along(&mean, pair.high(&d), &d), &d).unwrap();
            directions.blocked.known[Surface::Mockup][0].push(&onward);
            let pair = BodyPair { regions: &regions, ..pair };
            let mut held = |first: f64| pair.held_depth(&of(depth + 1e-9), first, &mut directions).is_some();
            assert!(held(depth) && !held(depth + 1e-4), "{d:?}");
            let (high, low) = (pair.high(&d), pair.low(&d));
            assert!((high - low - depth).abs() < 1e-12);
            let less = Depth { overlap: Overlapping::AtMost(0.5), ..plane(1.0, high + 1e-9) };
            assert!(!pair.is_under(&less), "{d:?}");
            assert!(pair.is_under(&plane(1.0, high + 1e-9)) && !pair.is_under(&plane(1.0, high - 1e-4)), "{d:?}");
            assert!(
                pair.is_over(&plane(1.0, low + 1.0 - 1e-9)) && !pair.is_over(&plane(1.0, low + 1.0 + 1e-4)),
                "{d:?}"
            );
        }
    }

    #[test]
    fn what_overlaps_by_more_than_others_is_told_from_what_does_not() {
        // Blocks of three heights under a plate, and of each its upper side.
        let block = |i: usize, high: f64| box_mesh([0.02 * i as f64, 0.0, high - 0.01], [0.01, 0.01, 0.02], 1);
        let blocks = scene(joined([block(0, 0.001), block(1, 0.002), block(2, 0.0002)]));
        let plate = tool(box_mesh([0.02, 0.0, 0.01], [0.1, 0.1, 0.02], 1));
        let pose = at(0.0, 0.0, 0.0);
        let context = QueryContext::new(&blocks, &plate, &pose, None);
        let up = [0.0, 0.0, 1.0];
        let tops = [0, 1, 2].map(|i| Facet::over(up, 2 * i..2 * i + 2));
        let of_mockup = [8, 9, 20, 21, 32, 33];
        let of_tool = [Facet::over([0.0, 0.0, -1.0], 0..2)];
        let tool = Body { triangles: &[10, 11], ..Body::of_facets(&of_tool) };
        let regions = ContactRegions::default();
        let lanes = context.lanes;
        let mut directions = DepthScratch::default();
        directions.clear([1, 3]);
        // Asked in an order in which what is said of all comes before it is known of each.
        for (most, asked) in [(0.0010001, [0, 2, 1, 2]), (0.0020001, [0, 2, 1, 0]), (0.0019999, [2, 1, 0, 1])] {
            let overlap = Overlapping::Measured(most);
            let plane = Depth { normal: up, depth: 0.01, overlap, high: 0.0, point: up, certain: false };
            for i in asked {
                let mockup = Body { number: i, triangles: &of_mockup, ..Body::of_facets(&tops[i..i + 1]) };
                let pair = BodyPair { lanes, regions: &regions, tool: &tool, mockup: &mockup };
                let found = pair.overlaps_no_more(&context, Facets::new(3, &tops, &of_mockup), &plane, &mut directions);
                assert_eq!(found, [0.001, 0.002, 0.0002][i] < most, "{most} {i}");
            }
            let of_all = directions.held.iter().find(|held| held.0 .2 == most).unwrap().1;
            assert_eq!(of_all, Some(most > 0.002), "{most}");
        }
    }
}
