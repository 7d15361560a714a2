//! Casts along chains of joints: never late, and exact about arms, threads and sliders.

mod common;

use std::f64::consts::{PI, TAU};

use common::*;
use feeler_core::{
    cast_all_pairs, collide_all_pairs, CastOptions, Chain, Joint, Mockup, Motion, Point, Pose, Scene, SceneOptions,
    Screw, Storage, Tool,
};

const Z: Point = [0.0, 0.0, 1.0];

fn scene_of(mockup: &std::sync::Arc<Mockup>) -> Scene {
    Scene::build(mockup.clone(), &SceneOptions::default().with_storage(Storage::Blocks)).unwrap()
}

/// A box between two corners.
fn block(low: Point, high: Point) -> Arrays {
    let vertices = (0..8).map(|i| std::array::from_fn(|a| if i >> a & 1 == 0 { low[a] } else { high[a] })).collect();
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    (vertices, quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect())
}

fn hinge(axis: Point, point: Point, angle: f64) -> Joint {
    Joint::Screw(Screw::new(&axis, &point, angle, 0.0).unwrap())
}

fn point(r: &mut Random, most: f64) -> Point {
    std::array::from_fn(|_| r.real(-most, most))
}

fn random_chain(r: &mut Random, most: f64) -> Chain {
    let joints: Vec<Joint> = (0..1 + (r.real(0.0, 6.0) as usize))
        .map(|_| {
            if r.real(0.0, 1.0) < 0.25 {
                return Joint::Slide(point(r, 0.5));
            }
            let (axis, at, angle) = (point(r, 1.0), point(r, 1.0), r.real(-most, most));
            Joint::Screw(Screw::new(&axis, &at, angle, r.real(-0.1, 0.1)).unwrap())
        })
        .collect();
    Chain::new(joints).unwrap()
}

fn off(a: &Pose, b: &Pose) -> f64 {
    let (a, b) = (a.matrix(), b.matrix());
    a.as_flattened().iter().zip(b.as_flattened()).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max)
}

fn cast(scene: &Scene, tool: &Tool, motion: &Motion, tolerance: f64) -> Option<feeler_core::Cast> {
    scene.cast_along(tool, motion, &CastOptions::default().with_tolerance(tolerance)).unwrap()
}

#[test]
fn casts_along_random_chains_are_never_late() {
    let mut r = Random::new(63);
    let (mut free, mut hits) = (0, 0);
    let mockup = mockup_of(soup(1, 60, 0.2));
    let scene = scene_of(&mockup);
    let tool = tool_of(placed(soup(9, 8, 0.1), 0.3, 0.3));
    for i in 0..150 {
        let chain = random_chain(&mut r, [0.4, 2.0, 9.0][i % 3]);
        let pose = moved([r.real(-1.0, 1.0), r.real(-1.0, 1.0), r.real(-1.0, 1.0)]);
        let motion = Motion::chain(&tool, &pose, &chain).unwrap();
        let found = cast(&scene, &tool, &motion, 1e-6);
        let until = found.as_ref().map_or(1.0, |cast| cast.fraction);
        for k in 0..if until > 0.0 { 300 } else { 0 } {
            let time = until * f64::from(k) / 300.0;
            let met = collide_all_pairs(mockup.mesh(), &tool, &motion.at(time));
            assert!(met.is_empty(), "{i}: {met:?} at {time}, before {until}");
        }
        let plain = cast_all_pairs(mockup.mesh(), &tool, &motion, 1e-6).unwrap();
        assert_eq!(found.is_some(), plain.is_some(), "{i}");
        if let (Some(found), Some(plain)) = (found, plain) {
            assert!(found.distance <= 1e-6 && off(&found.pose, &chain.at(&pose, found.fraction).unwrap()) < 1e-12);
            assert!((found.fraction - plain.fraction).abs() * motion.longest_way() < 1e-3, "{found:?} {plain:?}");
        }
        free += usize::from(found.is_none());
        hits += usize::from(found.is_some());
    }
    assert!(free > 20 && hits > 40, "{free} free, {hits} hits");
}

/// Speed and acceleration, by differences of places, are within the bounds; chords and windows hold what moves.
#[test]
fn a_motion_is_its_chain_and_stays_in_its_bounds() {
    let mut r = Random::new(5);
    let tool = tool_of(placed(soup(9, 8, 0.1), 0.3, 0.3));
    for i in 0..200 {
        let chain = random_chain(&mut r, [0.4, 2.0, 9.0][i % 3]);
        let pose = moved(point(&mut r, 1.0));
        let motion = Motion::chain(&tool, &pose, &chain).unwrap();
        let corner = tool.mesh().triangle(0)[0];
        let (rest, back) = (chain.rest(0.3).unwrap(), chain.reversed().unwrap());
        let at = motion.at(0.3);
        for k in 0..=20 {
            let time = f64::from(k) / 20.0;
            assert!(off(&motion.at(time), &chain.at(&pose, time).unwrap()) < 1e-12);
            let later = rest.at(&at, time).unwrap();
            assert!(off(&later, &motion.at(0.3 + 0.7 * time)) < 1e-12, "{i}");
            assert!(off(&back.at(motion.end(), time).unwrap(), &motion.at(1.0 - time)) < 1e-12);
            let (a, b) = (motion.at(time).apply(&corner), motion.at(time + 1e-3 * (1.0 - time)).apply(&corner));
            let moved = a.iter().zip(&b).map(|(x, y)| (x - y).powi(2)).sum::<f64>().sqrt();
            assert!(moved <= 1e-3 * (1.0 - time) * motion.longest_way() + 1e-12, "{i}");
        }
    }
}

#[test]
fn chains_that_are_one_joint_are_that_joint() {
    let tool = tool_of(block([0.0; 3], [1.0; 3]));
    let screw = |angle| Joint::Screw(Screw::new(&Z, &[0.5, 0.0, 0.0], angle, 0.0).unwrap());
    let of = |joints: Vec<Joint>| Motion::chain(&tool, &Pose::IDENTITY, &Chain::new(joints).unwrap()).unwrap().leg();
    assert!(matches!(of(vec![screw(1.0), screw(0.5)]), feeler_core::Leg::Screw(s) if s.angle() == 1.5));
    assert!(matches!(of(vec![screw(1.0), Joint::Slide([0.0, 0.0, 0.2])]), feeler_core::Leg::Screw(_)));
    assert!(matches!(of(vec![Joint::Slide([1.0; 3]), Joint::Slide([0.0, 0.0, 0.2])]), feeler_core::Leg::To(_)));
    assert!(matches!(of(vec![screw(1.0), screw(-1.0)]), feeler_core::Leg::To(pose) if pose == Pose::IDENTITY));
    assert!(matches!(of(vec![]), feeler_core::Leg::To(_)));
    let arm = Chain::new([screw(1.0), hinge(Z, [2.0, 0.0, 0.0], 1.0)]).unwrap();
    assert!(arm.relative_to(&arm).joints().is_empty());
}

/// Two links in a plane: the tip of the outer one comes down to a floor.
#[test]
fn an_arm_of_two_links_meets_a_floor_at_the_angle_of_the_closed_form() {
    let (first, second) = (0.6, 0.4);
    let tip = tool_of((vec![[1.0, 0.0, -0.1], [1.0, 0.0, 0.1], [1.0, 0.3, 0.0]], vec![[0, 1, 2]]));
    let (alpha, beta) = (-0.9, 1.7);
    let chain = Chain::new([hinge(Z, [0.0; 3], alpha), hinge(Z, [first, 0.0, 0.0], beta)]).unwrap();
    let height = |t: f64| first * (alpha * t).sin() + second * ((alpha + beta) * t).sin();
    let least = -0.05f64;
    // First time the tip is at -0.05: by bisection on the closed form, which falls at first.
    let (mut low, mut high) = (0.0, (0..1000).map(|i| f64::from(i) / 1000.0).find(|t| height(*t) < least).unwrap());
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if height(middle) < least {
            high = middle;
        } else {
            low = middle;
        }
    }
    let floor = scene_of(&mockup_of(block([-3.0, -1.0, -1.0], [3.0, least, 1.0])));
    let motion = Motion::chain(&tip, &Pose::IDENTITY, &chain).unwrap();
    let found = cast(&floor, &tip, &motion, 1e-10).expect("the floor");
    let late = found.fraction - low;
    assert!(late <= 1e-12 && late * beta > -1e-7, "{} and {low}", found.fraction);
}

/// A hinge whose frame slides and a worm: a screw with a pitch on a table that lifts.
#[test]
fn a_worm_on_a_lift_comes_down_by_both() {
    let worm = tool_of(block([-0.01, -0.01, 0.0], [0.01, 0.01, 0.1]));
    let floor = scene_of(&mockup_of(block([-9.0, -9.0, -1.0], [9.0, 9.0, 0.0])));
    let screw = Screw::new(&Z, &[0.0; 3], -40.0 * TAU, 0.002).unwrap();
    let chain = Chain::new([Joint::Slide([0.3, 0.0, -0.02]), Joint::Screw(screw)]).unwrap();
    let motion = Motion::chain(&worm, &moved([0.0, 0.0, 0.07]), &chain).unwrap();
    let found = cast(&floor, &worm, &motion, 1e-9).expect("the floor");
    let down = found.fraction * 0.1;
    assert!(down <= 0.07 + 1e-12 && down > 0.07 - 1e-7, "{down}");
}

/// A wheel that rolls: its spoke's tip follows a cycloid, whose height is known.
#[test]
fn a_rolling_wheel_meets_a_step_where_the_cycloid_does() {
    let radius = 0.5;
    let spoke = tool_of((vec![[0.0, 0.5, -0.1], [0.0, 0.5, 0.1], [0.0, 0.9, 0.0]], vec![[0, 1, 2]]));
    let chain = Chain::new([Joint::Slide([-radius * PI, 0.0, 0.0]), hinge(Z, [0.0, radius, 0.0], PI)]).unwrap();
    // The tip is at the top of the wheel after half a turn; at height y from the ground at angle phi: r (1 + cos).
    let spoke_tip = |t: f64| radius + 0.4 * (PI * t).cos();
    let least = 0.3;
    let floor = scene_of(&mockup_of(block([-9.0, -1.0, -1.0], [9.0, least, 1.0])));
    let motion = Motion::chain(&spoke, &Pose::IDENTITY, &chain).unwrap();
    let found = cast(&floor, &spoke, &motion, 1e-10).expect("the floor");
    let expected = ((least - radius) / 0.4f64).acos() / PI;
    assert!((spoke_tip(expected) - least).abs() < 1e-12);
    assert!(found.fraction <= expected + 1e-12 && (expected - found.fraction) * PI < 1e-7, "{}", found.fraction);
}

/// Link against link: a forearm against its own upper arm, as seen from the upper arm.
#[test]
fn a_link_meets_its_neighbour_at_the_angle_between_them() {
    let upper = scene_of(&mockup_of(block([0.0, -0.05, -0.05], [0.5, 0.05, 0.05])));
    let fore = tool_of(block([0.6, -0.02, -0.02], [1.0, 0.02, 0.02]));
    let root = hinge([0.0, 1.0, 1.0], [0.0; 3], 2.0);
    let of_fore = Chain::new([root, hinge(Z, [0.55, 0.0, 0.0], 3.1)]).unwrap();
    let of_upper = Chain::new([root]).unwrap();
    let alone = Chain::new([hinge(Z, [0.55, 0.0, 0.0], 3.1)]).unwrap();
    assert_eq!(of_fore.relative_to(&of_upper), alone);
    // And with an axis that is not the same number by number, so that nothing drops out.
    let other = Chain::new([hinge([0.0, 1.0, 1.0 + 1e-15], [0.0; 3], 2.0)]).unwrap();
    for chain in [of_fore.relative_to(&of_upper), of_fore.relative_to(&other)] {
        let motion = Motion::chain(&fore, &Pose::IDENTITY, &chain).unwrap();
        let found = cast(&upper, &fore, &motion, 1e-10).expect("the upper arm");
        let plain = Motion::chain(&fore, &Pose::IDENTITY, &alone).unwrap();
        let expected = cast(&upper, &fore, &plain, 1e-12).expect("the upper arm");
        assert!((found.fraction - expected.fraction).abs() * 3.1 < 1e-7, "{found:?} {expected:?}");
    }
}
