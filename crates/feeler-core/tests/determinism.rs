//! Two golden hashes: the same scenes give the same pairs and kinds, and the same distances, whatever the number of threads, the
//! instruction set, the store, the voxel size, the state of the working memory, one pose or many at a time; and in debug and release
//! and on every machine, since all compare with the numbers in `testdata/golden.txt`. Casts are promised less: one scene gives one
//! answer on any number of threads.

mod common;

use std::sync::Arc;

use common::cases::{cases, Case};
use feeler_core::{
    BatchOptions, CastOptions, Filters, Gap, Level, PairKind, PathOptions, Pose, Scene, SceneOptions, Storage,
};
use feeler_shapes::golden::Hash;

const STORES: [Storage; 5] = [
    Storage::Blocks,
    Storage::Dense,
    Storage::Hashed { level: 0.0 },
    Storage::Hashed { level: 0.5 },
    Storage::Hashed { level: 0.95 },
];

/// The pairs and kinds at all poses, in order.
fn hash<'a>(poses: impl Iterator<Item = (&'a [[u32; 2]], &'a [PairKind])>) -> u64 {
    let mut hash = Hash::NEW;
    for (pairs, kinds) in poses {
        hash.add(pairs.len() as u32);
        for ([tool, mockup], kind) in pairs.iter().zip(kinds) {
            [*tool, *mockup, *kind as u32].iter().for_each(|word| hash.add(*word));
        }
    }
    hash.value()
}

/// The hash of one case when asked in every way at once; panics when two ways differ.
fn hash_of_case(case: &Case) -> u64 {
    let extent = case.extent();
    let mut agreed = None;
    let mut agree = |hash: u64, what: &dyn Fn() -> String| {
        assert_eq!(hash, *agreed.get_or_insert(hash), "{}: {}", case.name, what());
    };
    for threads in [1, 2, 3, 8] {
        rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(|| {
            for storage in STORES {
                for size in [None, Some(extent / 2.0), Some(extent / 9.7), Some(extent / 40.0)] {
                    let what = |how: &str| format!("{storage:?}, voxel size {size:?}, {threads} threads, {how}");
                    let options = SceneOptions::default().with_voxel_size(size).with_storage(storage);
                    let mut scene = Scene::build(Arc::clone(&case.mockup), &options).unwrap();
                    let mut ways = vec![
                        ("cold", Level::best(), Filters::default()),
                        ("warm", Level::best(), Filters::default()),
                        ("no filters", Level::best(), Filters { repeats: false, boxes: false }),
                    ];
                    // One pose runs on one thread. The number of threads matters for building and for batches.
                    let levels = if threads == 1 { Level::available() } else { Vec::new() };
                    ways.extend(levels.into_iter().map(|l| (l.name(), l, Filters::default())));
                    for (how, lanes, filters) in ways {
                        scene.set_lanes(lanes);
                        let found: Vec<_> =
                            case.poses.iter().map(|p| scene.collide_filtered(&case.tool, p, filters)).collect();
                        let single = hash(found.iter().map(|c| (&c.pairs[..], &c.kinds[..])));
                        agree(single, &|| what(how));
                    }
                    // The poses twice over, so that more than one thread has something to do.
                    let twice: Vec<Pose> = case.poses.iter().cycle().take(2 * case.poses.len()).copied().collect();
                    let batch = scene.collide_batch(&case.tool, &twice, &BatchOptions::default()).unwrap();
                    let ranges: Vec<_> = batch.offsets.windows(2).map(|w| w[0] as usize..w[1] as usize).collect();
                    for half in ranges.chunks(case.poses.len()) {
                        let hash = hash(half.iter().map(|r| (&batch.pairs[r.clone()], &batch.kinds[r.clone()])));
                        agree(hash, &|| what("in a batch"));
                    }
                }
            }
        });
    }
    agreed.unwrap()
}

#[test]
fn one_golden_hash_whatever_the_threads_stores_voxels_and_order() {
    let mut golden = Hash::NEW;
    let mut kinds = [0; 3];
    for case in cases() {
        let hash = hash_of_case(&case);
        golden.add_long(hash);
        // A hash over no pairs would never change.
        for pose in &case.poses {
            for (_, kind) in feeler_core::collide_all_pairs(case.mockup.mesh(), &case.tool, pose) {
                kinds[kind as usize] += 1;
            }
        }
    }
    assert!(kinds.iter().all(|n| *n > 300), "{kinds:?} coplanar, crossing, touching pairs make no test");
    golden.assert_golden("pairs");
}

/// The poses, and as many at which most of the tool is clear of the mock-up.
fn near_and_far(case: &Case) -> Vec<Pose> {
    let off = [0.25, 0.75, 1.5].map(|share| share * case.extent());
    case.poses.iter().flat_map(|pose| [*pose, pose.translated(&off).unwrap()]).collect()
}

/// Gaps as they are reported: of several pairs that meet any may be the closest, so `pairs` says whether all were asked for.
fn add_gaps(hash: &mut Hash, gaps: &[Gap], pairs: bool) {
    hash.add(gaps.len() as u32);
    for gap in gaps {
        hash.add_real(gap.distance);
        if pairs || gap.distance > 0.0 {
            [gap.tool_triangle, gap.mockup_triangle, gap.part].iter().for_each(|word| hash.add(*word));
            gap.on_tool.iter().chain(&gap.on_mockup).for_each(|x| hash.add_real(*x));
        }
    }
}

/// All distances of a scene, one pose at a time.
fn hash_of_gaps(scene: &Scene, case: &Case, poses: &[Pose]) -> u64 {
    let mut hash = Hash::NEW;
    for pose in poses {
        let near = scene.near_pairs(&case.tool, pose, 0.02 * case.extent()).unwrap();
        add_gaps(&mut hash, &near, true);
        add_gaps(&mut hash, &scene.clearance(&case.tool, pose, 0.2 * case.extent()).unwrap(), false);
        for k in [1, 3] {
            add_gaps(&mut hash, &scene.nearest(&case.tool, pose, k, f64::INFINITY).unwrap(), false);
        }
    }
    hash.value()
}

/// The same, at all poses at once.
fn hash_of_gap_batches(scene: &Scene, case: &Case, poses: &[Pose]) -> u64 {
    let mut hash = Hash::NEW;
    let batch = |within: f64, pairs: bool| {
        let (within, options) = (within * case.extent(), BatchOptions::default());
        let found = if pairs {
            scene.near_pairs_batch(&case.tool, poses, within, &options)
        } else {
            scene.clearance_batch(&case.tool, poses, within, &options)
        };
        found.unwrap()
    };
    let (near, by_part) = (batch(0.02, true), batch(0.2, false));
    let closest = scene.distance_batch(&case.tool, poses, f64::INFINITY, &BatchOptions::default()).unwrap();
    let range = |offsets: &[u64], i: usize| offsets[i] as usize..offsets[i + 1] as usize;
    for (i, pose) in poses.iter().enumerate() {
        add_gaps(&mut hash, &near.gaps[range(&near.offsets, i)], true);
        add_gaps(&mut hash, &by_part.gaps[range(&by_part.offsets, i)], false);
        add_gaps(&mut hash, closest[i].as_slice(), false);
        add_gaps(&mut hash, &scene.nearest(&case.tool, pose, 3, f64::INFINITY).unwrap(), false);
    }
    hash.value()
}

#[test]
fn one_golden_hash_of_distances() {
    let mut golden = Hash::NEW;
    // Pairs that meet, and pairs that do not.
    let mut counts = [0, 0];
    for case in cases() {
        let (poses, extent) = (near_and_far(&case), case.extent());
        let mut agreed = None;
        let mut agree = |hash: u64, what: &dyn Fn() -> String| {
            assert_eq!(hash, *agreed.get_or_insert(hash), "{}: {}", case.name, what());
        };
        for threads in [1, 3] {
            rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(|| {
                for storage in STORES {
                    for size in [None, Some(extent / 9.7)] {
                        let what = |how: &str| format!("{storage:?}, voxel size {size:?}, {threads} threads, {how}");
                        let options = SceneOptions::default().with_voxel_size(size).with_storage(storage);
                        let mut scene = Scene::build(Arc::clone(&case.mockup), &options).unwrap();
                        for lanes in Level::available() {
                            // Other stores have only one distance search.
                            if storage == Storage::Blocks || lanes == Level::best() {
                                scene.set_lanes(lanes);
                                agree(hash_of_gaps(&scene, &case, &poses), &|| what(lanes.name()));
                            }
                        }
                        agree(hash_of_gap_batches(&scene, &case, &poses), &|| what("in a batch"));
                    }
                }
            });
        }
        golden.add_long(agreed.unwrap());
        for pose in &poses {
            for gap in feeler_core::gaps_of_all_pairs(&case.mockup, &case.tool, pose, 0.02 * extent) {
                counts[usize::from(gap.distance > 0.0)] += 1;
            }
        }
    }
    assert!(counts.iter().all(|n| *n > 1000), "{counts:?} pairs that meet and that are near make no test");
    golden.assert_golden("gaps");
}

#[test]
fn casts_of_one_scene_on_any_number_of_threads() {
    let mut hits = 0;
    for case in cases() {
        let (poses, extent) = (near_and_far(&case), case.extent());
        for storage in STORES {
            for size in [None, Some(extent / 9.7)] {
                let answer = |threads: usize| {
                    rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(|| {
                        let options = SceneOptions::default().with_voxel_size(size).with_storage(storage);
                        let scene = Scene::build(Arc::clone(&case.mockup), &options).unwrap();
                        let path = scene
                            .check_path(&case.tool, &poses, &PathOptions::default().with_tolerance(1e-6 * extent))
                            .unwrap();
                        // One at a time, with memory that has been used.
                        let single = poses.windows(2).enumerate().filter_map(|(i, way)| {
                            Some((
                                i,
                                scene
                                    .cast(
                                        &case.tool,
                                        &way[0],
                                        &way[1],
                                        &CastOptions::default().with_tolerance(1e-6 * extent),
                                    )
                                    .unwrap()?,
                            ))
                        });
                        assert_eq!(path.segments, poses.len() - 1);
                        assert_eq!(path.hits, single.collect::<Vec<_>>(), "{}, {storage:?}, {size:?}", case.name);
                        path
                    })
                };
                let one = answer(1);
                hits += one.hits.len();
                for threads in [2, 3, 8] {
                    assert!(answer(threads) == one, "{}, {storage:?}, {size:?}, {threads} threads", case.name);
                }
            }
        }
    }
    assert!(hits > 300, "{hits} hits make no test");
}
