//! The least depth of two bodies: along which axis the tool has to move least until a plane across it separates them.
//!
//! Along a unit direction d the depth is the mock-up's support less the tool's lowest height. The least of it over all d is the
//! penetration depth of convex polyhedra (S. Cameron: Enhancing GJK, ICRA 1997), found at a face normal of one of the two or
//! across an edge of each: separating axes on the Gauss map (D. Gregorius: The separating axis test between convex polyhedra, GDC
//! 2013). For curved surfaces, which have too many edges for that, a short [`descent`](super::descent) follows. Deviating from
//! both, axes that lead in or are [blocked](super::axis_blocked) do not count, and where the triangles overlap by clearly less
//! than the depth, that [overlap](super::directional_overlap) is the depth.

use feeler_core::Point;

use crate::constants::{FILLED_SHARE, FIRST_OVERLAP_SHARE, SHALLOWER};
use crate::context::QueryContext;
use crate::depth::axis::{BodyPair, TriedAxis};
use crate::depth::axis_blocked::BlockedAxes;
use crate::depth::axis_search::AxisSearch;
use crate::depth::directional_overlap::DirectionalOverlap;
use crate::depth::edge_axes::EdgeAxes;
use crate::depth::face_axes::{FaceAxes, FaceDepth};
use crate::depth::gauss_arcs::GaussArcs;
use crate::patch::body::{Facets, MOST_EDGES};

/// The least depth of a tool body in a mock-up body.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Depth {
    /// Unit, from the mock-up to the tool.
    pub normal: Point,
    /// Metres, until a plane across the normal separates the two.
    depth: f64,
    overlap: Overlap,
    /// Height of the mock-up body's highest point along the normal.
    high: f64,
    /// On the mock-up's side of the overlap, above the tool's lowest point.
    pub point: Point,
    /// Whether no axis can be shallower: both surfaces are flat-faced, and all candidates were tried.
    pub is_exact: bool,
}

/// How much two bodies overlap along the normal of their depth. Where that is clearly less than the depth, one reaches over a
/// hollow that the other fills, and no plane has to separate them.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Overlap {
    NotAsked,
    /// By the depth, or nearly.
    Filled,
    /// By so many metres at most.
    AtMost(f64),
    Measured(f64),
}

impl Depth {
    /// The gap of its plane: negative or zero. A lower bound until the overlap is [measured](BodyPair::measure).
    pub fn gap(&self) -> f64 {
        let most = match self.overlap {
            Overlap::NotAsked | Overlap::Filled => self.depth,
            Overlap::AtMost(overlap) | Overlap::Measured(overlap) => overlap,
        };
        -most.max(0.0)
    }

    /// Whether its gap is more than a bound.
    pub fn is_known(&self) -> bool {
        matches!(self.overlap, Overlap::Filled | Overlap::Measured(_))
    }

    /// Whether it is an overlap, and no more than another.
    pub fn is_less_than(&self, other: &Depth) -> bool {
        !self.may_be_filled() && self.gap() >= other.gap()
    }

    /// Whether the overlap may be as much as the depth.
    fn may_be_filled(&self) -> bool {
        matches!(self.overlap, Overlap::NotAsked | Overlap::Filled)
    }
}

/// Working memory.
#[derive(Debug, Default)]
pub(crate) struct DepthScratch {
    edge_axes: EdgeAxes,
    face_axes: FaceAxes,
    arcs: GaussArcs,
    overlap: DirectionalOverlap,
    /// Overlaps of the tool's bodies that others were compared with, and whether nothing of the mock-up overlaps more, where that
    /// was asked.
    asked: Vec<(OverlapKey, Option<bool>)>,
    blocked: BlockedAxes,
}

/// A tool body, a direction, and an overlap along it.
type OverlapKey = (usize, Point, f64);

impl DepthScratch {
    /// See [`FaceAxes::push_face_depths`].
    pub fn push_face_depths<'a>(
        &mut self,
        pairs: impl Iterator<Item = BodyPair<'a>> + Clone,
        out: &mut Vec<(FaceDepth, [usize; 2])>,
    ) {
        self.face_axes.push_face_depths(pairs, &mut self.blocked, out);
    }

    /// For another region with so many bodies of tool and mock-up.
    pub fn clear(&mut self, bodies: [usize; 2]) {
        self.overlap.clear(bodies);
        self.asked.clear();
        self.edge_axes.clear();
        self.blocked.clear(bodies);
    }
}

impl BodyPair<'_> {
    /// How deep a pair of such a face depth is along a plane's normal, if the plane separates it as well. Where the plane is
    /// shallower than the face depth, only if its normal is an axis of the pair: it leads out and is not blocked.
    pub fn held_depth(&self, plane: &Depth, face_depth: f64, scratch: &mut DepthScratch) -> Option<f64> {
        let direction = plane.normal;
        let tried = TriedAxis { direction, high: self.high(&direction), low: self.low(&direction) };
        let is_held = tried.depth() <= plane.depth * (1.0 + SHALLOWER)
            && (plane.depth >= face_depth || {
                let mut search = AxisSearch::new(self, &mut scratch.blocked, None);
                search.is_leading_out(&direction) && !search.is_blocked(&tried)
            });
        is_held.then(|| tried.depth())
    }

    /// Whether a plane found for the same tool body separates the mock-up's from it as well.
    pub fn is_under(&self, plane: &Depth) -> bool {
        plane.may_be_filled() && self.high(&plane.normal) <= plane.high + SHALLOWER * plane.depth
    }

    /// Whether a plane found for the same mock-up body separates the tool's from it as well.
    pub fn is_over(&self, plane: &Depth) -> bool {
        plane.may_be_filled() && self.low(&plane.normal) >= plane.high - plane.depth * (1.0 + SHALLOWER)
    }

    /// The least depth, starting from the face depth. `None` where no axis leads out.
    pub fn least_depth(&self, face: &FaceDepth, scratch: &mut DepthScratch) -> Option<Depth> {
        let DepthScratch { edge_axes, arcs, blocked, .. } = scratch;
        let mut search = AxisSearch::new(self, blocked, face.axis);
        if (1..=MOST_EDGES).contains(&self.edge_pairs()) {
            search.offer_all(edge_axes.find(self.lanes, self.tool, self.mockup, &self.outward()));
        }
        if !face.is_exact {
            search.search_arcs(arcs);
            search.descend();
        }
        let best = search.best?;
        let (point, is_exact) = (search.contact_point(&best), face.is_exact);
        let (normal, depth) = (best.direction, best.depth());
        Some(Depth { normal, depth, overlap: Overlap::NotAsked, high: best.high, point, is_exact })
    }

    /// Whether the two overlap along the normal by as much as they are deep. Measures at most once.
    pub fn is_filled(&self, context: &QueryContext<'_>, depth: &mut Depth, scratch: &mut DepthScratch) -> bool {
        if depth.overlap == Overlap::NotAsked {
            let enough = FILLED_SHARE * depth.depth;
            depth.overlap = Overlap::Filled;
            if depth.depth > 0.0 {
                // From a share of it on: mostly the overlap is more, and few triangles overlap by as much.
                self.find_overlap(context, depth, FIRST_OVERLAP_SHARE * enough, enough, scratch);
            }
        }
        depth.overlap == Overlap::Filled
    }

    /// Replaces a depth by the overlap where that is less; where it is no more than `least` (metres), by that bound.
    pub fn measure(&self, context: &QueryContext<'_>, depth: &mut Depth, least: f64, scratch: &mut DepthScratch) {
        self.is_filled(context, depth, scratch);
        match depth.overlap {
            Overlap::AtMost(most) if most > least => {}
            _ => return,
        }
        let enough = FILLED_SHARE * depth.depth;
        // A little below nothing, so that there is a point where they only touch too.
        let more = if least > 0.0 { least } else { -SHALLOWER * enough };
        self.find_overlap(context, depth, more, enough, scratch);
    }

    /// Looks for an overlap of more than `least`, and takes it if it is less than `enough`. Where `least` is not above zero, none
    /// found is no overlap.
    fn find_overlap(
        &self,
        context: &QueryContext<'_>,
        depth: &mut Depth,
        least: f64,
        enough: f64,
        scratch: &mut DepthScratch,
    ) {
        let found = scratch.overlap.greatest(context, &self.facets(), &depth.normal, least, enough);
        let Some((most, at)) = found.filter(|(most, _)| *most < enough) else { return };
        depth.is_exact = false;
        if most > least {
            (depth.overlap, depth.point) = (Overlap::Measured(most), at);
        } else {
            depth.overlap = if least > 0.0 { Overlap::AtMost(least) } else { Overlap::Measured(0.0) };
        }
    }

    /// Whether the two overlap along a plane's normal by no more than the plane's own bodies do. Where that is asked once more for
    /// the same tool body, it is asked for all that the mock-up has in the region first: mostly none of it overlaps by more.
    pub fn overlaps_no_more(
        &self,
        context: &QueryContext<'_>,
        whole_mockup: Facets<'_>,
        plane: &Depth,
        scratch: &mut DepthScratch,
    ) -> bool {
        let most = -plane.gap();
        let DepthScratch { overlap, asked, .. } = scratch;
        let [tool, mockup] = self.facets();
        let mut is_more = |mockup| {
            let found = overlap.greatest(context, &[tool, mockup], &plane.normal, most, most);
            found.is_none_or(|(more, _)| more > most)
        };
        let key = (tool.number, plane.normal, most);
        match asked.iter_mut().find(|asked| asked.0 == key) {
            Some((_, no_more)) => *no_more.get_or_insert_with(|| !is_more(whole_mockup)) || !is_more(mockup),
            None => {
                asked.push((key, None));
                !is_more(mockup)
            }
        }
    }

    fn facets(&self) -> [Facets<'_>; 2] {
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
    fn a_plane_separates_what_it_is_deep_enough_for() {
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
            // Planes of other pairs, a little deeper and a little shallower than needed.
            let plane = |depth: f64, high: f64| Depth {
                normal: d,
                depth,
                overlap: Overlap::Filled,
                high,
                point: mean,
                is_exact: false,
            };
            let of = |depth: f64| plane(depth, 0.0);
            // Shallower than the pair's face depth: only where the plane's normal leads out.
            let mut scratch = DepthScratch::default();
            scratch.clear([1; 2]);
            let mut held = |pair: &BodyPair<'_>, plane: f64, face: f64| pair.held_depth(&of(plane), face, &mut scratch);
            let inward = BodyPair { mockup: &Body { mean: scaled(&d, -1.0), ..*pair.mockup }, ..pair };
            let is_it = |found: Option<f64>| found.is_some_and(|found| (found - depth).abs() < 1e-12);
            assert!(is_it(held(&pair, depth + 1e-9, 0.0)) && held(&pair, depth - 1e-4, 0.0).is_none(), "{d:?}");
            assert!(is_it(held(&inward, depth + 1e-9, depth)) && is_it(held(&pair, depth + 1e-9, depth + 1e-4)));
            assert!(held(&inward, depth + 1e-9, depth + 1e-4).is_none(), "{d:?}");
            // And only where the mock-up does not block it, by a face higher than all of its points.
            let side = across(&d)[0];
            let face = |normal, by: f64| Face { normal, ..Face::new(0, [along(&mean, by, &d); 3], true) };
            let mut regions = ContactRegions::default();
            regions.faces = [vec![face(d, 0.0)], vec![face(side, 9.0)]];
            let segment = Segment { faces: [0; 2], points: (0, 1), flat: false };
            let blocker =
                Blocker::at_segment(&regions, Surface::Mockup, &segment, along(&mean, pair.high(&d), &d), &d).unwrap();
            scratch.blocked.known[Surface::Mockup][0].push(&blocker);
            let pair = BodyPair { regions: &regions, ..pair };
            let mut held = |face: f64| pair.held_depth(&of(depth + 1e-9), face, &mut scratch).is_some();
            assert!(held(depth) && !held(depth + 1e-4), "{d:?}");
            let (high, low) = (pair.high(&d), pair.low(&d));
            assert!((high - low - depth).abs() < 1e-12);
            let less = Depth { overlap: Overlap::AtMost(0.5), ..plane(1.0, high + 1e-9) };
            assert!(!pair.is_under(&less), "{d:?}");
            assert!(pair.is_under(&plane(1.0, high + 1e-9)) && !pair.is_under(&plane(1.0, high - 1e-4)), "{d:?}");
            assert!(
                pair.is_over(&plane(1.0, low + 1.0 - 1e-9)) && !pair.is_over(&plane(1.0, low + 1.0 + 1e-4)),
                "{d:?}"
            );
        }
    }

    #[test]
    fn what_overlaps_more_than_a_plane_is_told_from_what_does_not() {
        // Blocks of three heights under a plate, and the upper side of each.
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
        let mut scratch = DepthScratch::default();
        scratch.clear([1, 3]);
        // In an order in which the whole mock-up is asked before each of them was.
        for (most, asked) in [(0.0010001, [0, 2, 1, 2]), (0.0020001, [0, 2, 1, 0]), (0.0019999, [2, 1, 0, 1])] {
            let overlap = Overlap::Measured(most);
            let plane = Depth { normal: up, depth: 0.01, overlap, high: 0.0, point: up, is_exact: false };
            for i in asked {
                let mockup = Body { number: i, triangles: &of_mockup, ..Body::of_facets(&tops[i..i + 1]) };
                let pair = BodyPair { lanes, regions: &regions, tool: &tool, mockup: &mockup };
                let found = pair.overlaps_no_more(&context, Facets::new(3, &tops, &of_mockup), &plane, &mut scratch);
                assert_eq!(found, [0.001, 0.002, 0.0002][i] < most, "{most} {i}");
            }
            let of_all = scratch.asked.iter().find(|asked| asked.0 .2 == most).unwrap().1;
            assert_eq!(of_all, Some(most > 0.002), "{most}");
        }
    }
}
