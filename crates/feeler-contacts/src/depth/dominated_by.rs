//! Dominance: when a known plane makes the plane of another pair of bodies unnecessary.
//!
//! A plane dominates a pair of bodies of its region if
//!
//! 1. it faces as the pair's own plane would: their normals are within an angle; and
//! 2. it separates the pair as well: along its normal the pair is no deeper than the plane. Where the plane is an
//!    [overlap](super::directional_overlap), which separates nothing, the pair overlaps along it by no more.
//!
//! A pair is tested up to three times, each time with more known of it ([`OwnPlane`]), so that most pairs are never
//! searched.

use crate::constants::{DOMINATED_COSINE, SAME_DIRECTION, SAME_PLANE, SHALLOWER};
use crate::context::QueryContext;
use crate::depth::axis::{BodyPair, TriedAxis};
use crate::depth::axis_search::AxisSearch;
use crate::depth::face_axes::FaceDepth;
use crate::depth::least_depth::{Depth, DepthScratch};
use crate::depth::region_bodies::RegionBodies;
use crate::patch::body::Facets;
use feeler_core::geometry::vectors::dot;

/// A pair's own plane, as far as it is known.
#[derive(Debug, Clone, Copy)]
pub(super) enum OwnPlane<'a> {
    /// Nothing, but that a body of the pair is walled in by others of its surface and meets what they meet. Instead of the first
    /// condition, the plane must share a body with the pair. Overlaps do not dominate it: along a normal far from its own a pair may
    /// overlap by little and be deep.
    WalledIn([usize; 2]),
    /// Its depth along a face axis.
    Face(&'a FaceDepth),
    /// Its least depth, and the planes are no shallower: instead of the second condition.
    Least(&'a Depth),
}

impl OwnPlane<'_> {
    fn bodies(&self) -> [usize; 2] {
        match self {
            OwnPlane::WalledIn(bodies) => *bodies,
            OwnPlane::Face(face) => face.bodies,
            OwnPlane::Least(depth) => depth.bodies,
        }
    }

    /// The first condition.
    pub fn is_facing_as(&self, plane: &Depth) -> bool {
        let (axis, cosine) = match self {
            OwnPlane::WalledIn([t, m]) => return *t == plane.bodies[0] || *m == plane.bodies[1],
            OwnPlane::Face(face) => (face.axis, if face.is_exact { SAME_PLANE } else { DOMINATED_COSINE }),
            OwnPlane::Least(depth) => (Some(depth.axis), if depth.is_exact { SAME_PLANE } else { SAME_DIRECTION }),
        };
        axis.is_some_and(|axis| dot(&plane.normal(), &axis.direction) >= cosine)
    }
}

/// Whether one of some planes dominates a pair of bodies. Measures how much the planes' own bodies overlap, as far as it matters.
pub(super) fn is_dominated(
    bodies: &RegionBodies<'_>,
    own: OwnPlane<'_>,
    planes: &mut [Depth],
    scratch: &mut DepthScratch,
) -> bool {
    let (face_depth, overlaps_count) = match own {
        OwnPlane::Least(_) => return planes.iter().any(|plane| own.is_facing_as(plane)),
        OwnPlane::Face(face) => (face.depth(), true),
        OwnPlane::WalledIn(_) => (f64::NEG_INFINITY, false),
    };
    let pair = bodies.pair(own.bodies());
    // Of the overlaps the one that is most.
    let mut widest: Option<&Depth> = None;
    for plane in planes {
        let is_more = overlaps_count && widest.is_none_or(|widest| plane.gap() < widest.gap());
        if !own.is_facing_as(plane) || !(plane.may_be_filled() || is_more) {
            continue;
        }
        let Some(depth) = separated_depth(&pair, plane, face_depth, scratch) else { continue };
        let planes_own = bodies.pair(plane.bodies);
        if planes_own.is_filled(bodies.context, plane, scratch) {
            return true;
        }
        if !overlaps_count {
            continue;
        }
        planes_own.measure(bodies.context, plane, widest.map_or(0.0, |widest| -widest.gap()), scratch);
        if depth <= -plane.gap() {
            return true;
        }
        if widest.is_none_or(|widest| plane.gap() < widest.gap()) {
            widest = Some(plane);
        }
    }
    widest.is_some_and(|plane| overlaps_no_more(bodies.context, &pair, bodies.whole_mockup(), plane, scratch))
}

/// How deep a pair is along a plane's normal, if the plane separates it. Where the plane is shallower than the pair's face depth,
/// only if its normal is an axis of the pair too: it leads out and is not blocked.
fn separated_depth(pair: &BodyPair<'_>, plane: &Depth, face_depth: f64, scratch: &mut DepthScratch) -> Option<f64> {
    let TriedAxis { direction, high, low } = plane.axis;
    let [t, m] = plane.bodies;
    let high = if pair.mockup.number == m { high } else { pair.high(&direction) };
    let low = if pair.tool.number == t { low } else { pair.low(&direction) };
    let tried = TriedAxis { direction, high, low };
    let is_separated = tried.depth() <= plane.depth() * (1.0 + SHALLOWER)
        && (plane.depth() >= face_depth || {
            let mut search = AxisSearch::new(pair, &mut scratch.blocked, None);
            search.is_leading_out(&direction) && !search.is_blocked(&tried)
        });
    is_separated.then(|| tried.depth())
}

/// Whether a pair overlaps along a plane's normal by no more than the plane's own bodies do. From the second test of the
/// same tool body on, all of the mock-up in the region is tested first: mostly none of it overlaps by more.
fn overlaps_no_more(
    context: &QueryContext<'_>,
    pair: &BodyPair<'_>,
    whole_mockup: Facets<'_>,
    plane: &Depth,
    scratch: &mut DepthScratch,
) -> bool {
    let most = -plane.gap();
    let DepthScratch { overlap, asked, .. } = scratch;
    let [tool, mockup] = pair.facets();
    let mut is_more = |mockup| {
        let found = overlap.greatest(context, &[tool, mockup], &plane.normal(), most, most);
        found.is_none_or(|(more, _)| more > most)
    };
    let key = (tool.number, plane.normal(), most);
    match asked.iter_mut().find(|asked| asked.0 == key) {
        Some((_, no_more)) => *no_more.get_or_insert_with(|| !is_more(whole_mockup)) || !is_more(mockup),
        None => {
            asked.push((key, None));
            !is_more(mockup)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contour::contact_region::{ContactRegions, Face, Segment};
    use crate::depth::axis_blocked::Blocker;
    use crate::depth::least_depth::Overlap;
    use crate::patch::body::{Body, Facet};
    use crate::patch::support::push_eights;
    use crate::surface::Surface;
    use crate::tests::{at, scene, tool};
    use feeler_core::geometry::vectors::{across, along, scaled, sub, unit};
    use feeler_core::Point;
    use feeler_lanes::Level;
    use feeler_shapes::{box_mesh, joined};

    /// A plane of some bodies.
    fn plane(bodies: [usize; 2], direction: Point, high: f64, low: f64, overlap: Overlap) -> Depth {
        let axis = TriedAxis { direction, high, low };
        Depth { bodies, axis, overlap, point: [0.0; 3], is_exact: false }
    }

    #[test]
    fn what_is_known_of_a_pair_says_which_planes_face_as_its_own() {
        let turned = |degrees: f64| [degrees.to_radians().sin(), 0.0, degrees.to_radians().cos()];
        let other = |degrees: f64| plane([3, 4], turned(degrees), 1.0, 0.0, Overlap::Filled);
        let own = other(0.0);
        for (is_exact, face_degrees, least_degrees) in [(false, 25.0, 12.0), (true, 0.5, 0.5)] {
            let own = Depth { is_exact, ..own };
            let face = FaceDepth { bodies: [0, 0], axis: Some(own.axis), is_exact };
            for (own, degrees) in [(OwnPlane::Face(&face), face_degrees), (OwnPlane::Least(&own), least_degrees)] {
                assert!(own.is_facing_as(&other(0.98 * degrees)), "{own:?}");
                assert!(!own.is_facing_as(&other(1.04 * degrees)), "{own:?}");
            }
            assert!(!OwnPlane::Face(&FaceDepth { axis: None, ..face }).is_facing_as(&other(0.0)));
        }
        // Walled-in regions must share a body.
        for (bodies, is_facing) in [([3, 0], true), ([0, 4], true), ([4, 3], false)] {
            assert_eq!(OwnPlane::WalledIn(bodies).is_facing_as(&own), is_facing, "{bodies:?}");
        }
    }

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
            // Planes of other pairs, a little deeper and a little shallower than needed. Of a body that is theirs too the height is
            // taken from them.
            let of = |depth: f64| plane([7, 7], d, 2.0, 2.0 - depth, Overlap::Filled);
            let mut scratch = DepthScratch::default();
            scratch.clear([1; 2]);
            let mut separated =
                |pair: &BodyPair<'_>, plane: &Depth, face: f64| separated_depth(pair, plane, face, &mut scratch);
            let is_it = |found: Option<f64>| found.is_some_and(|found| (found - depth).abs() < 1e-12);
            assert!(is_it(separated(&pair, &of(depth + 1e-9), 0.0)), "{d:?}");
            assert!(separated(&pair, &of(depth - 1e-4), 0.0).is_none(), "{d:?}");
            let (high, low) = (pair.high(&d), pair.low(&d));
            for (by, is_separated) in [(1e-9, true), (-1e-4, false)] {
                let same_tool = plane([0, 7], d, high + by, low, Overlap::Filled);
                let same_mockup = plane([7, 0], d, high, low - by, Overlap::Filled);
                assert_eq!(is_it(separated(&pair, &same_tool, 0.0)), is_separated, "{d:?} {by}");
                assert_eq!(is_it(separated(&pair, &same_mockup, 0.0)), is_separated, "{d:?} {by}");
            }
            // Shallower than the pair's face depth: only where the plane's normal leads out.
            let inward = BodyPair { mockup: &Body { mean: scaled(&d, -1.0), ..*pair.mockup }, ..pair };
            let deeper = of(depth + 1e-9);
            assert!(is_it(separated(&inward, &deeper, depth)) && is_it(separated(&pair, &deeper, depth + 1e-4)));
            assert!(separated(&inward, &deeper, depth + 1e-4).is_none(), "{d:?}");
            // And only where the mock-up does not block it, by a face higher than all of its points.
            let side = across(&d)[0];
            let face = |normal, by: f64| Face { normal, ..Face::new(0, [along(&mean, by, &d); 3], true) };
            let mut regions = ContactRegions::default();
            regions.faces = [vec![face(d, 0.0)], vec![face(side, 9.0)]];
            let segment = Segment { faces: [0; 2], points: (0, 1), flat: false };
            let blocker = Blocker::at_segment(&regions, Surface::Mockup, &segment, along(&mean, high, &d), &d).unwrap();
            scratch.blocked.known[Surface::Mockup][0].push(&blocker);
            let pair = BodyPair { regions: &regions, ..pair };
            let mut separated = |face: f64| separated_depth(&pair, &deeper, face, &mut scratch).is_some();
            assert!(separated(depth) && !separated(depth + 1e-4), "{d:?}");
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
        // In an order in which the whole mock-up is tested before each of them was.
        for (most, asked) in [(0.0010001, [0, 2, 1, 2]), (0.0020001, [0, 2, 1, 0]), (0.0019999, [2, 1, 0, 1])] {
            let plane = plane([0, 0], up, 0.0, -0.01, Overlap::Measured(most));
            for i in asked {
                let mockup = Body { number: i, triangles: &of_mockup, ..Body::of_facets(&tops[i..i + 1]) };
                let pair = BodyPair { lanes, regions: &regions, tool: &tool, mockup: &mockup };
                let found = overlaps_no_more(&context, &pair, Facets::new(3, &tops, &of_mockup), &plane, &mut scratch);
                assert_eq!(found, [0.001, 0.002, 0.0002][i] < most, "{most} {i}");
            }
            let of_all = scratch.asked.iter().find(|asked| asked.0 .2 == most).unwrap().1;
            assert_eq!(of_all, Some(most > 0.002), "{most}");
        }
    }
}
