//! Queries and builds that are stopped: they ask again and again, end soon after a no, and give the same results without one.

mod common;

use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

use common::{ball, mockup_of, moved, tool_of, STORAGES};
use feeler_core::{BatchOptions, Error, GoOn, PathOptions, Pose, Result, Scene, SceneOptions, Storage};

/// Questions after the first no that a query may still ask, on all threads.
const ASKED_ON: usize = 64;

/// Runs a query that is never stopped, and then stops it at its first question, in the middle and at its last one. All must ask.
fn check<T: PartialEq + std::fmt::Debug>(
    what: &str,
    plain: &T,
    query: impl Fn(&(dyn Fn() -> bool + Sync)) -> Result<T>,
) {
    let asked = AtomicUsize::new(0);
    let always = || {
        asked.fetch_add(1, Relaxed);
        true
    };
    assert_eq!(&query(&always).unwrap(), plain, "{what}");
    let all = asked.into_inner();
    assert!(all > 1, "{what} asks {all} times");
    for stop in [1, all.div_ceil(2), all] {
        let asked = AtomicUsize::new(0);
        let until = || asked.fetch_add(1, Relaxed) + 1 < stop;
        assert_eq!(query(&until), Err(Error::Cancelled), "{what}, stopped at question {stop} of {all}");
        let asked = asked.into_inner();
        assert!(asked < stop + ASKED_ON, "{what}, stopped at question {stop}, asks {asked} times");
    }
}

#[test]
fn queries_of_one_pose_stop() {
    let (mockup, tool) = (mockup_of(ball(24, 0.5)), tool_of(ball(16, 0.45)));
    // A surface inside another, and one where another is.
    let (inside, same, same_tool) = (moved([0.01, 0.0, 0.0]), Pose::IDENTITY, tool_of(ball(24, 0.5)));
    for storage in STORAGES {
        let scene = Scene::build(mockup.clone(), &SceneOptions::default().with_storage(storage)).unwrap();
        let name = |what: &str| format!("{what}, {storage:?}");
        check(&name("collide"), &scene.collide(&same_tool, &same).pairs, |go_on| {
            Ok(scene.stoppable(GoOn::new(go_on)).collide(&same_tool, &same)?.pairs)
        });
        let within = 0.06;
        check(&name("near pairs"), &scene.near_pairs(&tool, &inside, within).unwrap(), |go_on| {
            scene.stoppable(GoOn::new(go_on)).near_pairs(&tool, &inside, within)
        });
        check(&name("clearance"), &scene.clearance(&tool, &inside, within).unwrap(), |go_on| {
            scene.stoppable(GoOn::new(go_on)).clearance(&tool, &inside, within)
        });
        check(&name("nearest"), &scene.nearest(&tool, &inside, 1, within).unwrap(), |go_on| {
            scene.stoppable(GoOn::new(go_on)).nearest(&tool, &inside, 1, within)
        });
        check(&name("distance"), &scene.distance(&tool, &inside, within).unwrap(), |go_on| {
            scene.stoppable(GoOn::new(go_on)).distance(&tool, &inside, within)
        });
    }
}

#[test]
fn queries_of_many_poses_stop() {
    let (mockup, tool) = (mockup_of(ball(30, 0.5)), tool_of(ball(20, 0.45)));
    let scene = Scene::build(mockup, &SceneOptions::default()).unwrap();
    let poses: Vec<Pose> = (0..200).map(|n| moved([0.2 + 1e-4 * f64::from(n), 0.0, 0.0])).collect();
    let options = BatchOptions::default();
    check("collide", &scene.collide_batch(&tool, &poses, &options).unwrap(), |go_on| {
        scene.collide_batch(&tool, &poses, &options.with_go_on(go_on))
    });
    check("distance", &scene.distance_batch(&tool, &poses, 1.0, &options).unwrap(), |go_on| {
        scene.distance_batch(&tool, &poses, 1.0, &options.with_go_on(go_on))
    });
    check("clearance", &scene.clearance_batch(&tool, &poses, 0.01, &options).unwrap(), |go_on| {
        scene.clearance_batch(&tool, &poses, 0.01, &options.with_go_on(go_on))
    });
    check("near pairs", &scene.near_pairs_batch(&tool, &poses, 0.01, &options).unwrap(), |go_on| {
        scene.near_pairs_batch(&tool, &poses, 0.01, &options.with_go_on(go_on))
    });
    let options = PathOptions::default();
    check("path", &scene.check_path(&tool, &poses, &options).unwrap(), |go_on| {
        scene.check_path(&tool, &poses, &options.with_go_on(go_on))
    });
}

#[test]
fn building_voxels_stops() {
    let mockup = mockup_of(ball(60, 0.5));
    for storage in [Storage::Dense, Storage::Hashed { level: 0.5 }] {
        let options = SceneOptions::default().with_storage(storage).with_voxel_size(0.01);
        let memory = |scene: Scene| scene.memory();
        check(&format!("{storage:?}"), &memory(Scene::build(mockup.clone(), &options).unwrap()), |go_on| {
            Ok(memory(Scene::build(mockup.clone(), &options.with_go_on(go_on))?))
        });
    }
}
