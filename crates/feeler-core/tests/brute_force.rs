//! Every store, voxel size, thread count and filter finds the pairs and kinds that testing all pairs finds.

mod common;

use std::sync::Arc;

use common::*;
use feeler_core::{
    collide_all_pairs, BatchOptions, Collision, Error, Filters, Level, Mockup, PairKind, Pose, Scene, SceneOptions,
    Storage, Tool,
};
use proptest::prelude::*;

type Pairs = Vec<([u32; 2], PairKind)>;

const FILTERS: [Filters; 4] = [
    Filters { repeats: true, boxes: true },
    Filters { repeats: true, boxes: false },
    Filters { repeats: false, boxes: true },
    Filters { repeats: false, boxes: false },
];

fn in_pool<R: Send>(threads: usize, work: impl FnOnce() -> R + Send) -> R {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(work)
}

fn together(c: &Collision) -> Pairs {
    c.pairs.iter().copied().zip(c.kinds.iter().copied()).collect()
}

fn build(mockup: &Arc<Mockup>, storage: Storage, voxel_size: Option<f64>) -> Result<Scene, Error> {
    let options = SceneOptions::default().with_voxel_size(voxel_size).with_storage(storage).with_memory_limit(1 << 30);
    Scene::build(Arc::clone(mockup), &options)
}

/// Compares every kind of query of the scene with the test of all pairs.
fn check_scene(what: &str, scene: &Scene, tool: &Tool, poses: &[Pose], expected: &[Pairs]) {
    scene.validate().unwrap_or_else(|why| panic!("{what}: {why}"));
    let mut reused = Collision::default();
    for (i, (pose, pairs)) in poses.iter().zip(expected).enumerate() {
        for filters in FILTERS {
            scene.collide_into(tool, pose, filters, &mut reused);
            assert_eq!(&together(&reused), pairs, "{what}, pose {i}, {filters:?}");
            assert_eq!(reused.stats.pairs, pairs.len() as u64, "{what}, pose {i}, {filters:?}");
        }
        assert_eq!(scene.is_colliding(tool, pose), !pairs.is_empty(), "{what}, pose {i}");
    }
    let batch = scene.collide_batch(tool, poses, &BatchOptions::default()).unwrap();
    assert_eq!(batch.offsets.len(), poses.len() + 1, "{what}");
    for (i, pairs) in expected.iter().enumerate() {
        let range = batch.offsets[i] as usize..batch.offsets[i + 1] as usize;
        let found: Pairs = batch.pairs[range.clone()].iter().copied().zip(batch.kinds[range].iter().copied()).collect();
        assert_eq!(&found, pairs, "{what}, pose {i} of the batch");
    }
}

/// All stores and thread counts, at voxel sizes from small to larger than the mock-up. Returns the number of pairs.
fn check(name: &str, mockup: &Arc<Mockup>, tool: &Tool, poses: &[Pose], thread_counts: &[usize]) -> usize {
    let expected: Vec<Pairs> = poses.iter().map(|pose| collide_all_pairs(mockup.mesh(), tool, pose)).collect();
    let longest = mockup.mesh().bounds().extent().iter().fold(0.0f64, |m, x| m.max(*x));
    let sizes =
        [None, Some(longest / 60.0), Some(longest / 11.3), Some(longest / 4.0), Some(longest), Some(longest * 100.0)];
    for (round, &threads) in thread_counts.iter().enumerate() {
        in_pool(threads, || {
            for storage in STORAGES {
                for size in sizes {
                    let what = format!("{name}, {storage:?}, voxel size {size:?}, {threads} threads");
                    let mut scene = build(mockup, storage, size).unwrap_or_else(|e| panic!("{what}: {e}"));
                    // The index may differ by the number of threads that build it, and the queries by their lanes.
                    for lanes in Level::available().into_iter().filter(|l| round == 0 || *l == Level::best()) {
                        scene.set_lanes(lanes);
                        check_scene(&format!("{what}, {}", lanes.name()), &scene, tool, poses, &expected);
                    }
                }
            }
        });
    }
    expected.iter().map(Vec::len).sum()
}

fn poses(seed: u64, count: usize, reach: f64, centre: f64) -> Vec<Pose> {
    let mut r = Random::new(seed);
    let mut poses: Vec<Pose> = (0..count).map(|_| r.pose(reach)).collect();
    if centre != 0.0 {
        // About a far place: keep the rotation of each, move it there.
        for pose in &mut poses {
            let [o, x, y, z] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|p| pose.apply(&p));
            let row = |a: usize| [x[a] - o[a], y[a] - o[a], z[a] - o[a], o[a] + centre];
            *pose = Pose::new(&[row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]]).unwrap();
        }
    }
    poses
}

#[test]
fn random_soups() {
    for (seed, size) in [(1, 0.03), (2, 0.3)] {
        let (mockup, tool) = (mockup_of(soup(seed, 220, size)), tool_of(placed(soup(seed + 10, 60, 0.1), 0.6, -0.3)));
        let found = check("soup", &mockup, &tool, &poses(seed + 20, 5, 0.3, 0.5), &[1, 2, 3]);
        assert!(found >= 8, "{found} pairs make no test");
    }
}

#[test]
fn many_small_triangles_under_large_ones() {
    // Many blocks under one cluster: these are scanned by the tool's pieces, not by their own.
    let (mockup, tool) = (mockup_of(soup(31, 12_000, 0.02)), tool_of(placed(soup(32, 50, 0.3), 0.8, -0.4)));
    let poses = poses(33, 6, 0.2, 0.5);
    let expected: Vec<Pairs> = poses.iter().map(|pose| collide_all_pairs(mockup.mesh(), &tool, pose)).collect();
    let mut scene = build(&mockup, Storage::Blocks, None).unwrap();
    for lanes in Level::available() {
        scene.set_lanes(lanes);
        check_scene(lanes.name(), &scene, &tool, &poses, &expected);
    }
    let found: usize = expected.iter().map(Vec::len).sum();
    assert!(found > 100, "{found} pairs make no test");
}

#[test]
fn long_thin_triangles() {
    for (seed, width) in [(3, 1e-2), (4, 1e-9)] {
        let (mockup, tool) =
            (mockup_of(needles(seed, 150, width)), tool_of(placed(needles(seed + 10, 60, 1e-2), 0.8, -0.4)));
        let found = check("needles", &mockup, &tool, &poses(seed + 20, 4, 0.3, 0.5), &[1, 2]);
        assert!(found > if width < 1e-3 { 0 } else { 10 }, "{found} pairs make no test");
    }
}

#[test]
fn flush_and_touching_lattice() {
    let (mockup, tool) = (mockup_of(lattice(5, 260, 6)), tool_of(lattice(6, 60, 4)));
    let mut r = Random::new(7);
    let poses: Vec<Pose> = (0..8).map(|_| r.lattice_pose(3)).collect();
    let found = check("lattice", &mockup, &tool, &poses, &[1, 2, 3]);
    assert!(found > 200, "{found} pairs make no test");
    let kinds: Vec<PairKind> =
        poses.iter().flat_map(|p| collide_all_pairs(mockup.mesh(), &tool, p)).map(|(_, kind)| kind).collect();
    for kind in [PairKind::Coplanar, PairKind::Crossing, PairKind::Touching] {
        assert!(kinds.contains(&kind), "{kind:?} does not occur");
    }
}

#[test]
fn a_tool_that_is_the_mock_up_itself() {
    // Every shared edge and vertex, at the identity and at a pose that rounds.
    let arrays = ball(7, 0.7);
    let (mockup, tool) = (mockup_of(arrays.clone()), tool_of(arrays));
    let mut at = poses(8, 2, 0.01, 0.0);
    at.push(Pose::IDENTITY);
    assert!(check("ball", &mockup, &tool, &at, &[1, 2]) > 2000);
}

#[test]
fn far_from_the_origin() {
    for centre in [1e6, -3e9] {
        let mockup = mockup_of(placed(soup(9, 200, 0.2), 1.0, centre));
        let tool = tool_of(placed(soup(10, 50, 0.2), 0.6, -0.3));
        let found = check("far", &mockup, &tool, &poses(11, 4, 0.3, centre + 0.5), &[1, 2]);
        assert!(found > 20, "{found} pairs make no test");
        // The tool's own coordinates far away, brought back by the pose: cancellation everywhere.
        let tool = tool_of(placed(soup(10, 50, 0.2), 0.6, centre));
        assert!(check("far tool", &mockup, &tool, &[moved([0.25; 3]), moved([0.5, 0.25, 0.0])], &[1, 2]) > 5);
    }
}

#[test]
fn defects_mixed_in() {
    for (mesh, tool, name) in [
        (soup(12, 150, 0.2), soup(13, 40, 0.2), "soup"),
        (placed(lattice(14, 150, 6), 0.125, 0.0), placed(lattice(15, 40, 3), 0.125, 0.0), "lattice"),
    ] {
        let (mockup, tool) = (mockup_of(with_defects(mesh)), tool_of(with_defects(tool)));
        assert!(mockup.mesh().queried_count() < mockup.mesh().faces().len());
        let mut at = poses(16, 3, 0.4, 0.0);
        at.push(Pose::IDENTITY);
        let found = check(&format!("{name} with defects"), &mockup, &tool, &at, &[1, 2]);
        assert!(found > 20, "{found} pairs make no test");
    }
}

#[test]
fn all_scales_from_denormal_to_huge() {
    let mut refused = Vec::new();
    for scale in [1e-320, 1e-310, 1e-200, 1e-120, 1e-60, 1e-9, 1e9, 1e40, 1e80, 9.9e98] {
        let (mesh, tool) = (placed(lattice(17, 60, 5), scale, 0.0), placed(lattice(18, 25, 3), scale, 0.0));
        let (mockup, tool) = (mockup_of(mesh), tool_of(tool));
        let poses = [Pose::IDENTITY, moved([scale, 0.0, -scale]), moved([scale * 10.0, 0.0, 0.0])];
        let expected: Vec<Pairs> = poses.iter().map(|pose| collide_all_pairs(mockup.mesh(), &tool, pose)).collect();
        assert!(expected[0].len() > 10, "{scale:e}: {}", expected[0].len());
        for storage in STORAGES {
            // The default voxel size must work too.
            let what = format!("lattice of {scale:e} m, {storage:?}");
            match build(&mockup, storage, None) {
                Ok(scene) => check_scene(&what, &scene, &tool, &poses, &expected),
                Err(error) => refused.push(format!("{what}: {error}")),
            }
        }
    }
    assert!(refused.is_empty(), "{}", refused.join("\n"));
}

#[test]
fn wildly_mixed_sizes_in_one_mesh() {
    // Bolts on a hull: six orders of magnitude between the triangles of one mock-up.
    let mut triangles: Vec<_> = Vec::new();
    for (i, size) in [1e-6, 1e-3, 1.0, 30.0].into_iter().enumerate() {
        let (v, f) = placed(soup(20 + i as u64, 50, 0.3), size, 0.5);
        triangles.extend(f.iter().map(|t| t.map(|c| v[c as usize])));
    }
    let (mockup, tool) = (mockup_of(arrays_of(triangles)), tool_of(placed(soup(30, 40, 0.4), 1.0, 0.0)));
    let mut at = poses(31, 3, 0.5, 0.0);
    at.push(moved([0.1; 3]));
    assert!(check("mixed sizes", &mockup, &tool, &at, &[1, 2]) > 20);
}

#[test]
fn tools_outside_find_nothing_in_any_direction() {
    let (mockup, tool) = (mockup_of(soup(40, 100, 0.2)), tool_of(soup(41, 30, 0.2)));
    let mut at = Vec::new();
    for distance in [3.0, 1e6, 1e30, 1e99, 1e100] {
        for axis in 0..3 {
            for sign in [1.0, -1.0] {
                at.push(moved(std::array::from_fn(|a| if a == axis { sign * distance } else { 0.0 })));
            }
        }
    }
    assert_eq!(check("outside", &mockup, &tool, &at, &[1]), 0);
}

#[test]
fn single_triangles_and_flat_meshes() {
    let one = arrays_of([[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]]);
    let flat: Vec<_> = (0..30)
        .map(|i| {
            let x = f64::from(i) * 0.25;
            [[x, 0.0, 0.0], [x + 0.25, 0.0, 0.0], [x, 0.5, 0.0]]
        })
        .collect();
    let crossing = arrays_of([[[0.2, 0.2, -1.0], [0.2, 0.2, 1.0], [3.0, 0.3, 0.0]]]);
    for (name, mesh) in [("one", one.clone()), ("flat", arrays_of(flat))] {
        for (other, tool) in [("one", one.clone()), ("crossing", crossing.clone())] {
            let at = [
                Pose::IDENTITY,
                moved([0.25, 0.0, 0.0]),
                moved([0.0, 0.0, f64::MIN_POSITIVE]),
                moved([-1.0, 0.0, 0.0]),
            ];
            let found =
                check(&format!("{name} against {other}"), &mockup_of(mesh.clone()), &tool_of(tool), &at, &[1, 2]);
            assert!(found > 0);
        }
    }
}

#[test]
fn tool_triangles_that_lose_their_area_to_rounding_at_the_pose() {
    // Far from its own origin a small or thin triangle rounds to a segment or a point. These are closed sets too: sharing a
    // point is a collision. In the plane of the mock-up's triangle the kind is coplanar, else touching.
    let mockup = mockup_of(arrays_of([[[0.0; 3], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]]]));
    let at = moved([1.0, 1.0, 0.0]);
    let e = 1e-20;
    for (name, triangle, expected) in [
        ("point on the face", [[0.0; 3], [e, 0.0, 0.0], [0.0, e, 0.0]], Some(PairKind::Coplanar)),
        ("point off the face", [[0.0, 0.0, 0.5], [e, 0.0, 0.5], [0.0, e, 0.5]], None),
        ("point beside, in the plane", [[3.0, 0.0, 0.0], [3.0, e, 0.0], [3.0, 0.0, e]], None),
        ("segment in the face", [[0.0; 3], [1.0, 0.0, 0.0], [0.5, e, 0.0]], Some(PairKind::Coplanar)),
        ("segment across the face", [[-9.0, 0.0, 0.0], [9.0, 0.0, 0.0], [0.0, e, 0.0]], Some(PairKind::Coplanar)),
        (
            "segment along an edge",
            [[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.5, 0.5 + 1e-16, 0.0]],
            Some(PairKind::Coplanar),
        ),
        ("segment that pierces", [[0.0, 0.0, -1.0], [0.0, 0.0, 1.0], [e, 0.0, 0.0]], Some(PairKind::Touching)),
        (
            "segment that pierces, middle first",
            [[e, 0.0, 0.25], [0.0, 0.0, -1.0], [0.0, 0.0, 1.0]],
            Some(PairKind::Touching),
        ),
        ("segment that ends on the face", [[0.0; 3], [0.0, 0.0, 1.0], [e, 0.0, 0.5]], Some(PairKind::Touching)),
        ("segment that pierces beside", [[3.0, 0.0, -1.0], [3.0, 0.0, 1.0], [3.0, e, 0.0]], None),
        ("segment above", [[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.5, e, 1.0]], None),
    ] {
        let tool = Tool::new(triangle.to_vec(), vec![[0, 1, 2]]).unwrap();
        let tool_at_pose = at.apply_triangle(&tool.mesh().triangle(0));
        assert!(
            feeler_core::geometry::predicates::is_collinear(&tool_at_pose[0], &tool_at_pose[1], &tool_at_pose[2]),
            "{name}"
        );
        let pairs: Pairs = expected.map(|kind| ([0, 0], kind)).into_iter().collect();
        for storage in STORAGES {
            for size in [None, Some(0.5)] {
                let scene = build(&mockup, storage, size).unwrap();
                check_scene(&format!("{name}, {storage:?}"), &scene, &tool, &[at], std::slice::from_ref(&pairs));
            }
        }
    }
}

#[test]
fn large_batches_run_in_waves_and_keep_their_order() {
    let (mockup, tool) = (mockup_of(soup(50, 60, 0.2)), tool_of(placed(soup(51, 12, 0.2), 0.5, 0.0)));
    let scene = build(&mockup, Storage::Blocks, None).unwrap();
    let at = poses(52, 9001, 0.8, 0.0);
    let single: Vec<Pairs> = at.iter().map(|p| together(&scene.collide(&tool, p))).collect();
    for threads in [1, 3] {
        let batch = in_pool(threads, || scene.collide_batch(&tool, &at, &BatchOptions::default())).unwrap();
        let pairs: Vec<[u32; 2]> = single.iter().flatten().map(|(pair, _)| *pair).collect();
        assert!(batch.pairs == pairs && pairs.len() > 1000, "{threads} threads");
        assert!((0..at.len()).all(|i| batch.offsets[i + 1] - batch.offsets[i] == single[i].len() as u64));
    }
    let empty = scene.collide_batch(&tool, &[], &BatchOptions::default()).unwrap();
    assert_eq!((empty.offsets, empty.pairs.len()), (vec![0], 0));
}

#[test]
fn many_threads_share_one_scene() {
    let mockup = mockup_of(soup(60, 300, 0.2));
    let tools: Vec<Tool> =
        (0..4).map(|i| tool_of(placed(soup(61 + i, 10 + 30 * i as usize, 0.2), 0.6, -0.3))).collect();
    let at = poses(65, 20, 0.8, 0.3);
    for storage in STORAGES {
        let scene = build(&mockup, storage, None).unwrap();
        let run = |tool: &Tool| -> Vec<Pairs> { at.iter().map(|p| together(&scene.collide(tool, p))).collect() };
        let serial: Vec<_> = tools.iter().map(run).collect();
        std::thread::scope(|scope| {
            for (tool, expected) in tools.iter().zip(&serial).cycle().take(8) {
                scope.spawn(move || assert_eq!(&run(tool), expected));
            }
        });
    }
}

fn lattice_mesh(side: i32, count: std::ops::Range<usize>) -> impl Strategy<Value = Arrays> {
    let corner = prop::array::uniform3((0..=side).prop_map(f64::from));
    prop::collection::vec(prop::array::uniform3(corner), count)
        .prop_map(arrays_of)
        .prop_filter("something to query", |(v, f)| Mockup::new(v.clone(), f.clone(), Vec::new(), 1).is_ok())
}

/// Whole clusters of the tool lie beside the planes of the triangles whose boxes they meet, and are left out by these.
#[test]
fn a_fine_tool_among_large_triangles() {
    let (mockup, tool) = (mockup_of(soup(71, 60, 1.5)), tool_of(ball(40, 0.15)));
    let mut r = Random::new(72);
    let poses: Vec<Pose> = (0..25).map(|_| r.pose(0.9)).collect();
    let expected: Vec<Pairs> = poses.iter().map(|pose| collide_all_pairs(mockup.mesh(), &tool, pose)).collect();
    let (mut with, mut without, mut found) = (0, 0, 0);
    for level in Level::available() {
        let mut scene = build(&mockup, Storage::Blocks, None).unwrap();
        scene.set_lanes(level);
        check_scene(level.name(), &scene, &tool, &poses, &expected);
        for pose in &poses {
            let placed = |filters| scene.collide_filtered(&tool, pose, filters).stats.clusters_placed;
            with += placed(Filters::default());
            without += placed(Filters { boxes: false, ..Filters::default() });
            found += scene.collide(&tool, pose).pairs.len();
        }
    }
    assert!(found > 1000 && 10 * with < 9 * without, "{found} pairs, {with} and {without} clusters placed");
}

proptest! {
    // The seed is fixed, so that every run tests the same cases; PROPTEST_CASES asks for more of them.
    #![proptest_config(ProptestConfig {
        cases: std::env::var("PROPTEST_CASES").ok().and_then(|n| n.parse().ok()).unwrap_or(150),
        rng_seed: proptest::test_runner::RngSeed::Fixed(2004),
        failure_persistence: None,
        ..ProptestConfig::default()
    })]
    #[test]
    fn any_lattice_mesh(
        mesh in lattice_mesh(5, 1..40),
        tool in lattice_mesh(3, 1..20),
        seed in 0u64..1_000_000,
        scale in prop_oneof![Just(1.0), Just(0.1), Just(1.0 / 3.0), Just(1e-7), Just(12345.0)],
        jitter in prop_oneof![Just(0.0), Just(f64::EPSILON)],
        size in 0.01f64..20.0,
    ) {
        let mut r = Random::new(seed);
        let mut shaken = |(v, f): Arrays| -> Arrays {
            (v.into_iter().map(|p| p.map(|x| x * scale * (1.0 + jitter * r.real(-2.0, 2.0)))).collect(), f)
        };
        let (mesh, tool) = (shaken(mesh), shaken(tool));
        let (Ok(mockup), Ok(tool)) = (Mockup::new(mesh.0, mesh.1, Vec::new(), 1), Tool::new(tool.0, tool.1)) else {
            return Ok(());
        };
        let mockup = Arc::new(mockup);
        let at = [moved([r.below(4) as f64 * scale, 0.0, -scale]), r.pose(3.0 * scale), Pose::IDENTITY];
        let expected: Vec<Pairs> = at.iter().map(|p| collide_all_pairs(mockup.mesh(), &tool, p)).collect();
        for storage in STORAGES {
            for size in [None, Some(size * scale)] {
                let scene = build(&mockup, storage, size).unwrap();
                check_scene(&format!("{storage:?} {size:?}"), &scene, &tool, &at, &expected);
            }
        }
    }
}
