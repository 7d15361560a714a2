//! Near pairs, clearances and distances of every store, voxel size and instruction set against all pairs.

mod common;

use std::collections::BTreeMap;
use std::sync::Arc;

use common::*;
use feeler_core::{gaps_of_all_pairs, Error, Gap, Level, Mockup, Pose, Scene, SceneOptions, Storage, Tool};

fn build(mockup: &Arc<Mockup>, storage: Storage, voxel_size: Option<f64>) -> Scene {
    let options = SceneOptions::default().with_voxel_size(voxel_size).with_storage(storage).with_memory_limit(1 << 30);
    Scene::build(Arc::clone(mockup), &options).unwrap()
}

fn with_parts((vertices, faces): Arrays, parts: usize) -> Arc<Mockup> {
    let part_of_face = (0..faces.len()).map(|i| (i * 7 / 3 % parts) as u32).collect();
    Arc::new(Mockup::new(vertices, faces, part_of_face, parts).unwrap())
}

/// The first gap of each part.
fn by_part(all: &[Gap]) -> Vec<Gap> {
    let mut seen = BTreeMap::new();
    all.iter().filter(|gap| seen.insert(gap.part, ()).is_none()).copied().collect()
}

/// Equal, except that any of several pairs at distance 0 may be the closest.
fn assert_same(what: &str, found: &[Gap], expected: &[Gap]) {
    let distances = |gaps: &[Gap]| gaps.iter().map(|gap| gap.distance).collect::<Vec<_>>();
    assert_eq!(distances(found), distances(expected), "{what}");
    for (f, e) in found.iter().zip(expected) {
        assert!(f == e || f.distance == 0.0, "{what}: {f:?} for {e:?}");
    }
}

fn check(name: &str, mockup: &Arc<Mockup>, tool: &Tool, poses: &[Pose], withins: &[f64]) -> usize {
    let expected: Vec<Vec<Gap>> =
        poses.iter().map(|pose| gaps_of_all_pairs(mockup, tool, pose, f64::INFINITY)).collect();
    let longest = mockup.mesh().bounds().extent().iter().fold(0.0f64, |m, x| m.max(*x));
    let mut count = 0;
    for storage in STORAGES {
        // At a high hashing level a list serves a hundred voxels, so fewer cases are tested.
        let fine = if storage == (Storage::Hashed { level: 0.99 }) { 7.3 } else { 17.3 };
        for size in [None, Some(longest / fine), Some(longest * 100.0)] {
            let mut scene = build(mockup, storage, size);
            scene.validate().unwrap();
            for lanes in Level::available() {
                if storage != Storage::Blocks && lanes != Level::best() {
                    continue;
                }
                scene.set_lanes(lanes);
                for (i, (pose, all)) in poses.iter().zip(&expected).enumerate() {
                    let what = format!("{name}, {storage:?}, {size:?}, {}, pose {i}", lanes.name());
                    for &within in withins {
                        let near: Vec<Gap> = all.iter().copied().filter(|gap| gap.distance <= within).collect();
                        count += near.len();
                        assert_eq!(scene.near_pairs(tool, pose, within).unwrap(), near, "{what}, within {within}");
                        assert_same(&what, &scene.clearance(tool, pose, within).unwrap(), &by_part(&near));
                        for k in [1, 3, usize::MAX] {
                            let found = scene.nearest(tool, pose, k, within).unwrap();
                            let closest: Vec<Gap> = by_part(&near).into_iter().take(k).collect();
                            assert_same(&format!("{what}, within {within}, k {k}"), &found, &closest);
                        }
                    }
                }
            }
        }
    }
    count
}

#[test]
fn random_soups_at_all_distances() {
    for (seed, size, reach) in [(1, 0.03, 0.4), (2, 0.3, 0.6), (3, 0.1, 3.0)] {
        let (mockup, tool) =
            (with_parts(soup(seed, 100, size), 9), tool_of(placed(soup(seed + 10, 30, 0.1), 0.4, -0.2)));
        let mut r = Random::new(seed);
        let poses: Vec<Pose> = (0..3).map(|_| r.pose(reach)).collect();
        let found = check("soup", &mockup, &tool, &poses, &[0.0, 0.05, f64::INFINITY]);
        assert!(found > 1000);
    }
}

#[test]
fn long_thin_triangles() {
    for (seed, width) in [(3, 1e-2), (4, 1e-9)] {
        let (mockup, tool) =
            (with_parts(needles(seed, 90, width), 4), tool_of(placed(needles(seed + 10, 40, 1e-2), 0.8, -0.4)));
        let mut r = Random::new(seed);
        let poses: Vec<Pose> = (0..3).map(|_| r.pose(0.5)).collect();
        let found = check("needles", &mockup, &tool, &poses, &[0.0, 0.01, 0.1]);
        assert!(found > 30, "{found} pairs make no test");
    }
}

#[test]
fn a_lattice_has_ties_everywhere() {
    let (mockup, tool) = (with_parts(lattice(5, 150, 6), 5), tool_of(lattice(6, 40, 4)));
    let mut r = Random::new(7);
    let mut poses: Vec<Pose> = (0..3).map(|_| r.lattice_pose(3)).collect();
    poses.extend((0..3).map(|_| r.lattice_pose(12)));
    assert!(check("lattice", &mockup, &tool, &poses, &[0.0, 1.0, 2.0]) > 1000);
}

#[test]
fn far_tools_tiny_scenes_and_defects() {
    let mut r = Random::new(8);
    for (scale, offset) in [(1e-9, 0.0), (1.0, 1e7), (1e6, 0.0), (1e-3, -4.0)] {
        let mockup = mockup_of(with_defects(placed(soup(9, 60, 0.2), scale, offset)));
        let tool = tool_of(placed(soup(10, 20, 0.2), scale, 0.0));
        let at = |distance: f64, r: &mut Random| {
            let d = r.point(-1.0, 1.0);
            moved(std::array::from_fn(|a| offset + scale * distance * d[a]))
        };
        let poses: Vec<Pose> = [0.5, 3.0, 1e3, 1e9, 1e30].into_iter().map(|d| at(d, &mut r)).collect();
        let what = format!("times {scale:e} plus {offset:e}");
        assert!(check(&what, &mockup, &tool, &poses, &[scale * 0.1, f64::INFINITY]) > 1000, "{what}");
    }
}

#[test]
fn a_speck_is_as_near_as_anything() {
    // Seen from a corner on the x axis, where float64 can tell its corners apart, though not the square of its normal from 0.
    let tool = tool_of(arrays_of([[[1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [1.0, 1.0, 0.0]]]));
    for size in [1e-30, 1e-45, 1e-60, 1e-90, 1e-150] {
        let speck = [[0.0, size, 0.0], [0.0, 0.0, size], [0.0, -size, size]];
        let mockup = mockup_of(arrays_of([speck, [[-1.0, 0.0, 0.0], [-1.0, 1.0, 0.0], [-1.0, 0.0, 1.0]]]));
        let found = check(&format!("{size:e}"), &mockup, &tool, &[Pose::IDENTITY], &[1.0, 1.5, 2.0]);
        assert!(found >= 3, "{size:e}");
    }
}

#[test]
fn bad_arguments_are_errors() {
    let (mockup, tool) = (mockup_of(soup(1, 50, 0.2)), tool_of(soup(2, 10, 0.2)));
    for storage in STORAGES {
        let scene = build(&mockup, storage, None);
        for bad in [-1.0, -0.0001, f64::NAN, f64::NEG_INFINITY] {
            for error in [
                scene.near_pairs(&tool, &Pose::IDENTITY, bad).unwrap_err(),
                scene.clearance(&tool, &Pose::IDENTITY, bad).unwrap_err(),
                scene.nearest(&tool, &Pose::IDENTITY, 1, bad).unwrap_err(),
            ] {
                assert!(matches!(error, Error::Distance { .. }), "{error}");
            }
        }
        assert!(matches!(scene.nearest(&tool, &Pose::IDENTITY, 0, 1.0), Err(Error::NoneAsked { .. })));
    }
    let options = SceneOptions::default().with_memory_limit(1 << 16);
    let scene = Scene::build(mockup, &options).unwrap();
    assert!(matches!(scene.near_pairs(&tool, &Pose::IDENTITY, f64::INFINITY), Err(Error::Memory { .. })));
}
