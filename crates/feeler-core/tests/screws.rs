//! Casts along screws: never late, exact about doors and threads, however far the axis is and however often it goes round.

mod common;

use std::f64::consts::{FRAC_PI_2, TAU};

use common::*;
use feeler_core::{
    cast_all_pairs, collide_all_pairs, CastOptions, Error, Leg, Mockup, Motion, PathOptions, Point, Pose, Scene,
    SceneOptions, Screw, Storage, Tool,
};

const TOLERANCE: f64 = 1e-6;
const Z: Point = [0.0, 0.0, 1.0];

fn scene_of(mockup: &std::sync::Arc<Mockup>, storage: Storage) -> Scene {
    let options = SceneOptions::default().with_storage(storage);
    Scene::build(mockup.clone(), &options).unwrap()
}

/// A box between two corners.
fn block(low: Point, high: Point) -> Arrays {
    let vertices = (0..8).map(|i| std::array::from_fn(|a| if i >> a & 1 == 0 { low[a] } else { high[a] })).collect();
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    (vertices, quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect())
}

fn cast(scene: &Scene, tool: &Tool, pose: &Pose, screw: &Screw, tolerance: f64) -> Option<feeler_core::Cast> {
    let motion = Motion::screw(tool, pose, screw).unwrap();
    scene.cast_along(tool, &motion, &CastOptions::default().with_tolerance(tolerance)).unwrap()
}

fn direction(r: &mut Random) -> Point {
    std::array::from_fn(|_| r.real(-1.0, 1.0))
}

#[test]
fn a_cast_of_any_store_is_that_of_all_pairs_and_never_late() {
    let mut r = Random::new(19);
    let (mut free, mut hits) = (0, 0);
    for (name, arrays, offset) in [
        ("soup", soup(1, 400, 0.08), 0.0),
        ("needles", needles(2, 60, 0.01), 0.0),
        ("far", placed(soup(4, 300, 0.08), 1.0, 3000.0), 3000.0),
    ] {
        let mockup = mockup_of(arrays);
        let scenes = STORAGES.map(|storage| scene_of(&mockup, storage));
        let tool = tool_of(placed(soup(9, 12, 0.05), 0.3, 0.3));
        for i in 0..40 {
            let turned = r.pose(0.0);
            let (mut m, centre) = (turned.matrix(), turned.apply(&[0.45; 3]));
            (0..3).for_each(|k| m[k][3] += offset + r.real(0.0, 1.0) - centre[k]);
            if i % 4 == 3 {
                // A pose that is only just rigid enough.
                m[0][1] += 4e-7;
                m[2][0] -= 3e-7;
            }
            let pose = Pose::new(&m).unwrap();
            // Through the tool, beside it, and far away.
            let spread = [0.1, 1.0, 50.0][i % 3];
            let point = std::array::from_fn(|_| offset + r.real(0.5 - spread, 0.5 + spread));
            let angle = r.real(-1.0, 1.0) * [7.0, 2.0, 0.02][i % 3];
            let screw = Screw::new(&direction(&mut r), &point, angle, r.real(-0.3, 0.3)).unwrap();
            let motion = Motion::screw(&tool, &pose, &screw).unwrap();
            let plain = cast_all_pairs(mockup.mesh(), &tool, &motion, TOLERANCE).unwrap();
            let until = plain.as_ref().map_or(1.0, |cast| cast.fraction);
            for k in 0..if until > 0.0 { 200 } else { 0 } {
                let time = until * f64::from(k) / 200.0;
                let met = collide_all_pairs(mockup.mesh(), &tool, &motion.at(time));
                assert!(met.is_empty(), "{name} {i}: {met:?} at {time}, before {until}");
            }
            for scene in &scenes {
                let what = format!("{name} {i} {:?}", scene.storage());
                let found =
                    scene.cast_along(&tool, &motion, &CastOptions::default().with_tolerance(TOLERANCE)).unwrap();
                assert_eq!(found.is_some(), plain.is_some(), "{what}");
                let (Some(found), Some(plain)) = (found, plain) else { continue };
                assert!(found.distance <= TOLERANCE && found.pose == motion.at(found.fraction), "{what}: {found:?}");
                let apart = (found.fraction - plain.fraction).abs() * motion.longest_way();
                assert!(apart < 1e-3, "{what}: {} and {}", found.fraction, plain.fraction);
            }
            free += usize::from(plain.is_none());
            hits += usize::from(plain.is_some());
        }
    }
    assert!(free > 15 && hits > 50, "{free} free, {hits} hits");
}

/// A door of 0.9 m on a hinge at the origin, and a post with an edge at a known angle.
#[test]
fn a_door_stops_at_the_angle_of_the_post() {
    let door = tool_of(block([0.02, 0.0, 0.0], [0.9, 0.04, 2.0]));
    for far in [0.0, 40.0] {
        for angle in [0.3f64, 1.1, 1.5] {
            // The upper face of the door, at y = 0.04, meets the post's lowest corner: at radius 0.6 and this angle.
            let (radius, lift) = (0.6f64, (0.04f64 / 0.6).asin());
            let (s, c) = (angle + lift).sin_cos();
            let edge = [far + radius * c, far + radius * s];
            let post = vec![[edge[0], edge[1], -1.0], [edge[0], edge[1], 3.0], [edge[0] - s, edge[1] + c, 1.0]];
            let mockup = mockup_of((post, vec![[0, 1, 2]]));
            let hinge = Screw::new(&Z, &[far, far, 0.0], 2.0, 0.0).unwrap();
            let pose = moved([far, far, 0.0]);
            for storage in STORAGES {
                let found = cast(&scene_of(&mockup, storage), &door, &pose, &hinge, 1e-11).expect("the post");
                let swung = found.fraction * 2.0;
                assert!(swung <= angle + 1e-9 && swung > angle - 1e-9, "{swung} of {angle}, {storage:?}, {far} m away");
            }
        }
    }
}

#[test]
fn a_bolt_goes_down_by_its_pitch_at_any_number_of_turns() {
    let bolt = tool_of(block([-0.005, -0.005, 0.0], [0.005, 0.005, 0.04]));
    let floor = mockup_of(block([-0.05, -0.05, -0.02], [0.05, 0.05, 0.0]));
    let scene = scene_of(&floor, Storage::Blocks);
    for (turns, pitch) in [(0.25, 0.0015), (3.0, 0.0015), (40.0, 0.0015), (900.0, 1e-4), (-40.0, -0.0015)] {
        let way = 0.8 * f64::abs(turns) * f64::abs(pitch);
        let screw = Screw::new(&[0.0, 0.0, -2.0], &[0.0; 3], turns * TAU, pitch).unwrap();
        assert!((screw.advance() - turns * pitch).abs() < 1e-15);
        let found = cast(&scene, &bolt, &moved([0.0, 0.0, way]), &screw, 1e-9).expect("the floor");
        let down = found.fraction * screw.advance();
        assert!(down <= way + 1e-12 && down > way - 2e-9, "{down} of {way}");
        // The way back is free.
        assert!(cast(&scene, &bolt, &moved([0.0, 0.0, 1e-6]), &screw.reversed(), 1e-9).is_none());
    }
}

#[test]
fn a_whole_turn_is_not_no_turn() {
    let bar = tool_of(block([-0.1, -0.01, 0.0], [0.5, 0.01, 0.02]));
    let post = mockup_of(block([-0.42, -0.02, -1.0], [-0.38, 0.02, 1.0]));
    let scene = scene_of(&post, Storage::Blocks);
    for (turns, fraction) in [(1.0, 0.5), (-1.0, 0.5), (5.0, 0.1), (-3.0, 1.0 / 6.0)] {
        let screw = Screw::new(&Z, &[0.0; 3], turns * TAU, 0.0).unwrap();
        let found = cast(&scene, &bar, &Pose::IDENTITY, &screw, TOLERANCE).expect("the post");
        assert!(found.fraction < fraction && found.fraction > 0.8 * fraction, "{} of {turns}", found.fraction);
        assert!(cast(&scene, &bar, &moved([0.0, 0.0, 2.0]), &screw, TOLERANCE).is_none());
    }
}

/// An arc with an axis a kilometre away is nearly a line; it may bend through a slit where its chord would not.
#[test]
fn arcs_are_arcs_far_from_the_axis() {
    let ball = tool_of(block([-1e-4; 3], [1e-4; 3]));
    let (radius, angle) = (1000.0, 2e-3);
    // The arc's middle is half a millimetre above the chord.
    let sag = radius * (1.0 - f64::cos(0.5 * angle));
    assert!(sag > 4e-4);
    let under = mockup_of(block([-0.01, -0.01, -0.01], [0.01, sag - 2e-4, 0.01]));
    let scene = scene_of(&under, Storage::Blocks);
    let at = |turn: f64| moved([radius * turn.sin(), radius * turn.cos() - radius * f64::cos(0.5 * angle), 0.0]);
    let (from, to) = (at(-0.5 * angle), at(0.5 * angle));
    assert!(scene.cast(&ball, &from, &to, &CastOptions::default().with_tolerance(TOLERANCE)).unwrap().is_some());
    let centre = [0.0, -radius * f64::cos(0.5 * angle), 0.0];
    let screw = Screw::new(&Z, &centre, -angle, 0.0).unwrap();
    assert!(cast(&scene, &ball, &from, &screw, TOLERANCE).is_none());
    let end = *Motion::screw(&ball, &from, &screw).unwrap().end();
    assert!((0..3).all(|a| (end.translation()[a] - to.translation()[a]).abs() < 1e-12 * radius));
}

#[test]
fn legs_begin_where_the_last_one_ended() {
    let bolt = tool_of(block([-0.005, -0.005, 0.0], [0.005, 0.005, 0.04]));
    let wall = mockup_of(block([1.0, -1.0, -1.0], [1.1, 1.0, 1.0]));
    let scene = scene_of(&wall, Storage::Blocks);
    let turn = |angle: f64, pitch: f64| Leg::Screw(Screw::new(&Z, &[0.0; 3], angle, pitch).unwrap());
    let legs = [
        turn(10.0 * TAU, 0.001),
        Leg::To(moved([0.5, 0.0, 0.01])),
        turn(FRAC_PI_2, 0.0),
        Leg::To(moved([2.0, 0.0, 0.0])),
    ];
    let motions = Motion::of_legs(&bolt, &Pose::IDENTITY, &legs).unwrap();
    for pair in motions.windows(2) {
        assert_eq!(*pair[0].end(), pair[1].at(0.0));
    }
    assert!((motions[0].end().translation()[2] - 0.01).abs() < 1e-15);
    assert!((motions[2].end().translation()[1] - 0.5).abs() < 1e-12);
    let how = PathOptions::default().with_tolerance(TOLERANCE);
    let check = scene.check_legs(&bolt, &Pose::IDENTITY, &legs, &how).unwrap();
    assert_eq!((check.segments, check.hits.len(), check.hits[0].0), (4, 1, 3));
    let still = scene.check_legs(&bolt, &moved([1.0, 0.0, 0.0]), &[], &how).unwrap();
    assert_eq!((still.segments, still.hits.len()), (1, 1));
}

#[test]
fn screws_without_sense_are_refused() {
    let what = |axis: Point, point: Point, angle: f64, pitch: f64| match Screw::new(&axis, &point, angle, pitch) {
        Err(Error::Screw { what, .. }) => what,
        other => panic!("{other:?}"),
    };
    assert_eq!(what([0.0; 3], [0.0; 3], 1.0, 0.0), "axis of the screw");
    assert_eq!(what([f64::NAN, 0.0, 1.0], [0.0; 3], 1.0, 0.0), "axis of the screw");
    assert_eq!(what(Z, [f64::INFINITY, 0.0, 0.0], 1.0, 0.0), "point of the screw");
    assert_eq!(what(Z, [0.0; 3], f64::NAN, 0.0), "angle of the screw");
    assert_eq!(what(Z, [0.0; 3], 7000.0, 0.0), "angle of the screw");
    assert_eq!(what(Z, [0.0; 3], 1.0, 1e200), "pitch of the screw");
    let tool = tool_of(block([-0.005; 3], [0.005; 3]));
    let out = Screw::new(&Z, &[0.0; 3], 900.0 * TAU, 1e97).unwrap();
    assert!(matches!(Motion::screw(&tool, &moved([0.0, 0.0, 5e99]), &out), Err(Error::PoseNotFinite { .. })));
    assert!(Screw::new(&[0.0, 3e-200, 0.0], &[0.0; 3], 1.0, 0.0).is_ok_and(|s| s.axis()[1] == 1.0));
}
