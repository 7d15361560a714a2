//! Near surfaces: the candidates, those dropped by separating planes, and when the margin shrinks.

use std::sync::Arc;

use feeler_core::distance::wanted::Candidate;
use feeler_core::geometry::vectors::dot;
use feeler_core::index::sink::Divider;
use feeler_core::{Level, Mockup, Point, SceneOptions, Storage, Tool};
use feeler_shapes::{box_mesh, sheet, Arrays};

use super::{at, scene, tool, turned, Held};
use crate::constants::{FEW_DEEP, MANY_DEEP, MANY_NEAR, MOST_PLANES};

#[test]
fn candidates_are_all_that_is_near_and_their_bounds_hold() {
    let near = scene(box_mesh([0.0; 3], [0.1, 0.1, 0.02], 6));
    let held = tool(box_mesh([0.0; 3], [0.03, 0.02, 0.02], 5));
    for (angle, z) in [(0.0, 0.0205), (0.3, 0.0215), (0.7, 0.018), (1.1, 0.023)] {
        let pose = turned(angle, [0.011, -0.007, z]);
        let candidates = near.near_candidates(&held, &pose, 0.002, &[], usize::MAX).unwrap();
        let near = near.near_pairs(&held, &pose, 0.002).unwrap();
        assert!(near.len() > 20, "{angle}: {} pairs make no test", near.len());
        for gap in near {
            let same =
                |c: &&Candidate| (c.tool_triangle, c.mockup_triangle) == (gap.tool_triangle, gap.mockup_triangle);
            let least = candidates.iter().filter(same).map(|c| c.bound).fold(f64::INFINITY, f64::min);
            assert!(least <= gap.distance, "{least} for {gap:?}");
        }
    }
}

#[test]
fn a_pair_that_many_voxels_offer_counts_once_against_the_memory_limit() {
    let (vertices, faces) = box_mesh([0.0; 3], [0.1, 0.1, 0.02], 1);
    let (parts, held) = (vec![0; faces.len()], tool(box_mesh([0.0; 3], [0.03, 0.02, 0.02], 1)));
    let mockup = Arc::new(Mockup::new(vertices, faces, parts, 1).unwrap());
    let storage = Storage::Hashed { level: 0.3 };
    let options = SceneOptions::default().with_voxel_size(0.001).with_storage(storage).with_memory_limit(1 << 20);
    let near = Held::with(mockup, &options, Level::best());
    let found = near.near_candidates(&held, &at(0.0, 0.0, 0.021), 0.05, &[], usize::MAX).unwrap();
    assert!(found.len() > 12, "{}", found.len());
}

#[test]
fn dividers_leave_out_only_what_they_separate() {
    let plate = scene(box_mesh([0.0; 3], [0.1, 0.1, 0.02], 11));
    let held = tool(box_mesh([0.0; 3], [0.03, 0.02, 0.02], 9));
    // One separates pairs in a strip across the plate, one none, and one is of another part.
    let divider = |part: u32, normal: Point, heights: [f64; 2]| Divider { part, normal, heights };
    let lean = [0.6, 0.0, 0.8];
    let dividers =
        [divider(0, lean, [0.012, 0.004]), divider(0, lean, [-1.0, 1.0]), divider(1, [0.0, 0.0, 1.0], [1.0, -1.0])];
    for (angle, z) in [(0.0, 0.0205), (0.3, 0.0215), (0.7, 0.018)] {
        let pose = turned(angle, [0.011, -0.007, z]);
        let pairs = |dividers: &[Divider]| {
            let found = plate.near_candidates(&held, &pose, 0.002, dividers, usize::MAX).unwrap();
            let mut pairs: Vec<[u32; 2]> = found.iter().map(|c| [c.tool_triangle, c.mockup_triangle]).collect();
            pairs.sort_unstable();
            pairs.dedup();
            pairs
        };
        let (all, some) = (pairs(&[]), pairs(&dividers));
        assert!(some.len() < all.len() && !some.is_empty(), "{angle}: {} of {}", some.len(), all.len());
        assert!(some.iter().all(|pair| all.binary_search(pair).is_ok()));
        for [t, m] in all.iter().filter(|pair| some.binary_search(pair).is_err()) {
            let p = pose.apply_triangle(&held.mesh().triangle(*t));
            let q = plate.mockup().mesh().triangle(*m);
            let holds = |d: &Divider| {
                q.iter().all(|x| dot(x, &d.normal) <= d.heights[0] + 1e-12)
                    && p.iter().all(|x| dot(x, &d.normal) >= d.heights[1] - 1e-12)
            };
            assert!(dividers[..2].iter().any(holds), "{angle}: {t} {m}");
        }
    }
}

/// Blocks in a row, each in the one below by its own depth, and at the end one of another part, a millimetre off.
fn row(deep: usize) -> (Held, Tool) {
    let blocks = |z: &dyn Fn(usize) -> f64| {
        let mut all: Arrays = Default::default();
        for i in 0..=deep {
            let (vertices, faces) = box_mesh([0.02 * i as f64, 0.0, z(i)], [0.01; 3], 2);
            let from = all.0.len() as u32;
            all.0.extend(vertices);
            all.1.extend(faces.iter().map(|f| f.map(|v| v + from)));
        }
        all
    };
    let depth = |i: usize| if i < deep { 0.001 + 0.00001 * i as f64 } else { -0.001 };
    let (lower, upper) = (blocks(&|_| 0.0), blocks(&|i| 0.01 - depth(i)));
    let each = lower.1.len() / (deep + 1);
    let part_of_face = (0..lower.1.len()).map(|f| u32::from(f >= deep * each)).collect();
    let mockup = Mockup::new(lower.0, lower.1, part_of_face, 2).unwrap();
    let scene = Held::of(mockup);
    (scene, tool(upper))
}

#[test]
fn beside_many_deep_planes_nothing_near_is_searched() {
    // The near block is at half of the margin.
    for (deep, near, omitted) in [
        (MOST_PLANES + 8, 0, 8),
        (MOST_PLANES - 1, 0, 0),
        (MANY_DEEP, 0, 0),
        (MANY_DEEP - 1, 0, 0),
        (10, 0, 0),
        (8, 1, 0),
        (FEW_DEEP, 1, 0),
        (1, 1, 0),
    ] {
        let (lower, upper) = row(deep);
        let contacts = lower.contacts(&upper, &at(0.0, 0.0, 0.0), 0.002, None).unwrap();
        assert_eq!((contacts.planes.len(), contacts.omitted), (deep + near - omitted, omitted), "{deep}");
        for (i, plane) in contacts.planes.iter().take(deep).enumerate() {
            let expected = 0.001 + 0.00001 * (deep - 1 - i) as f64;
            assert!((plane.gap + expected).abs() < 1e-12, "{i}: {plane:?}");
        }
        if near > 0 {
            assert!((contacts.planes[deep].gap - 0.001).abs() < 1e-12, "{contacts:?}");
        }
    }
}

#[test]
fn the_margin_shrinks_beside_more_than_few_deep_planes() {
    for (deep, share) in [(1, 1.0), (FEW_DEEP, 1.0), (7, 5.0 / 6.0), (9, 0.5), (MANY_DEEP - 1, 1.0 / 6.0)] {
        let (lower, upper) = row(deep);
        // The near block is a millimetre off.
        for (margin, planes) in [(0.00101 / share, deep + 1), (0.00099 / share, deep)] {
            let contacts = lower.contacts(&upper, &at(0.0, 0.0, 0.0), margin, None).unwrap();
            assert_eq!(contacts.planes.len(), planes, "{deep} {margin}");
        }
    }
}

#[test]
fn near_planes_do_not_depend_on_the_order_in_which_pairs_are_measured() {
    // Stores list pairs in different orders. Integer coordinates make many pairs equally near.
    let mut state = 6_978_726_143_068_042_601u64;
    let mut whole = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as f64 % 9.0 - 4.0
    };
    let (mut vertices, mut faces) = box_mesh([-0.63, 0.5, -2.0], [2.0, 1.5, 1.0], 1);
    let (more, of_more) = box_mesh([3.0, -2.0, 5.0], [2.0, 2.0, 2.0], 2);
    faces.extend(of_more.iter().map(|f| f.map(|v| v + vertices.len() as u32)));
    vertices.extend(more);
    let held = tool((vertices, faces));
    let mut planes = 0;
    for round in 0..100 {
        let corners: Vec<Point> = (0..36).map(|_| [whole(), whole(), whole()]).collect();
        let triangles: Vec<[u32; 3]> = (0..12).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let mockup = Arc::new(Mockup::new(corners, triangles, vec![0; 12], 1).unwrap());
        let pose = at(whole(), whole(), whole());
        let found = [Storage::Blocks, Storage::Hashed { level: 0.3 }].map(|storage| {
            let options = SceneOptions::default().with_storage(storage).with_tool(&held);
            let near = Held::with(Arc::clone(&mockup), &options, Level::best());
            near.contacts(&held, &pose, 1.25, None).unwrap()
        });
        assert_eq!(found[0], found[1], "{round}");
        planes += found[0].planes.len();
    }
    assert!(planes > 100, "{planes}");
}

#[test]
fn of_too_many_near_pairs_the_nearest_count() {
    // Two fine plates: every pair of triangles is within the margin.
    let plate = |z: f64| sheet(110, 110, move |s, t| [0.011 * (s - 0.5), 0.011 * (t - 0.5), z]);
    let (below, above) = (scene(plate(0.0)), tool(plate(0.0)));
    let pose = at(0.0, 0.0, 0.0003);
    let near = |within: f64| below.near_candidates(&above, &pose, within, &[], MANY_NEAR).map(|near| near.len());
    // Halving may step from too many to none.
    assert_eq!((near(0.03), near(0.03 / 64.0), near(0.03 / 128.0)), (None, None, Some(0)));
    let planes = below.contacts(&above, &pose, 0.03, None).unwrap().planes;
    assert_eq!(planes.len(), 1, "{planes:?}");
    assert!((planes[0].gap - 0.0003).abs() < 1e-12 && planes[0].normal[2] > 1.0 - 1e-12, "{planes:?}");
}
