//! Parts that are sunk in a neighbour: they never meet what of its surface lies beyond their place, however thin both are.

use std::sync::Arc;

use feeler_contacts::ContactSolver;
use feeler_core::geometry::twist::{pose_of, rotation_of, times};
use feeler_core::{Mockup, Motion, Point, Pose, Scene, SceneOptions, Screw, Tool};
use feeler_shapes::{box_mesh, joined, lathe, Arrays};
use feeler_world::{Body, SeatKind, Surroundings, WalkOptions};

/// How near a walk ends before it meets a sheet, metres.
const NEAR: f64 = 4.5e-6;

fn placed(frame: &Pose, (vertices, faces): Arrays) -> Arrays {
    (vertices.iter().map(|p| frame.apply(p)).collect(), faces)
}

/// The surroundings of a tool that is sunk in a mock-up of one part.
fn around(part: Arrays, tool: Arrays, frame: &Pose) -> Surroundings {
    let (vertices, faces) = placed(frame, part);
    let mockup = Mockup::new(vertices, faces, vec![], 1).unwrap();
    let scene = Scene::build(Arc::new(mockup), &SceneOptions::default()).unwrap();
    let body = Body { solver: ContactSolver::new(Arc::new(scene)), part: None };
    let tool = Arc::new(Tool::new(tool.0, tool.1).unwrap());
    let around = Surroundings::around(vec![body], tool, frame).unwrap();
    assert_eq!(around.seats().map(|seat| seat.kind).collect::<Vec<_>>(), [SeatKind::Sunk]);
    around
}

fn frames() -> [Pose; 3] {
    let frame = |turn: Point, place: Point| pose_of(&rotation_of(&turn), &place).unwrap();
    [Pose::IDENTITY, frame([0.3, -0.2, 0.9], [0.1, 0.2, 0.3]), frame([2.0, 0.7, -1.1], [30.0, -20.0, 10.0])]
}

/// A pin of radius 4 mm along z, 40 mm long, with a flange of so much radius, above a height.
fn pin(flange: f64, above: f64, thin: f64) -> Arrays {
    let profile = [
        [1e-4, -0.02],
        [0.004, -0.02],
        [0.004, above],
        [flange, above],
        [flange, above + thin],
        [0.004, above + thin],
        [0.004, 0.02],
        [1e-4, 0.02],
    ];
    lathe(&profile, 24, 0.1)
}

/// How far it gets along a way, metres; `None`: to its end.
fn far(around: &Surroundings, frame: &Pose, way: Point, verifies: bool) -> Option<f64> {
    let to = frame.translated(&times(frame.rotation(), &way)).unwrap();
    let options = if verifies { WalkOptions::verify(&|| true) } else { WalkOptions::default() };
    let walk = around.walk(&around.seated_at_start(), (frame, &to), options).unwrap();
    assert_eq!(walk.stop.is_none(), walk.fraction == 1.0);
    let stop = walk.stop?;
    assert!(stop.part == 0 && stop.is_seat && stop.pair.is_none());
    Some(walk.fraction * Motion::new(around.tool(), frame, &to).longest_way())
}

#[test]
fn a_thin_flange_of_a_sunk_pin_stops_at_the_thin_sheet_that_the_pin_goes_through() {
    let thin = [1e-5, 4e-5, 1e-4, 5e-4];
    let cases = thin.into_iter().flat_map(|sheet| thin.map(|flange| (sheet, flange)));
    for (number, (sheet, flange)) in cases.enumerate() {
        let frame = frames()[number % 3];
        let above = 0.0062 + 2.3e-4 * number as f64;
        // Of large triangles, which the pin goes through as well; or of smaller ones.
        let plate = box_mesh([0.0; 3], [0.08, 0.06, sheet], [1, 7][number % 2]);
        let around = around(plate, pin(0.009, above, flange), &frame);
        for verifies in [false, true] {
            let down = far(&around, &frame, [0.0, 0.0, -0.06], verifies).expect("it stops");
            let free = above - 0.5 * sheet;
            assert!(down < free && down > free - NEAR, "{sheet} {flange} {verifies}: {down} of {free}");
            assert_eq!(far(&around, &frame, [0.0, 0.0, 0.06], verifies), None);
        }
    }
}

#[test]
fn a_head_stops_at_the_plate_that_its_shank_is_sunk_in_whatever_the_gap() {
    let gaps = [0.0, 1e-6, 1e-5, 1e-4, 3e-4, 6e-4, 9e-4];
    for (number, gap) in gaps.into_iter().enumerate() {
        let frame = frames()[number % 3];
        // Through the plate, or only into it.
        for (plate, half) in [(0.012, 0.006), (0.08, 0.04)] {
            let middle = [0.0, 0.0, 0.006 - half];
            let around = around(box_mesh(middle, [0.08, 0.06, plate], 1), pin(0.009, 0.006 + gap, 5e-3), &frame);
            for verifies in [false, true] {
                let down = far(&around, &frame, [0.0, 0.0, -0.06], verifies).expect("it stops");
                // A tip in the solid does not go in at all.
                let least = if plate < 0.04 { gap - NEAR } else { -NEAR };
                assert!(down < gap + 1e-6 && down > least, "{plate} {verifies}: {down} of {gap}");
                assert_eq!(far(&around, &frame, [0.0, 0.0, 0.06], verifies), None);
            }
        }
    }
}

#[test]
fn it_stops_there_on_a_screw_too() {
    let (above, sheet) = (0.0073, 1e-4);
    for frame in frames() {
        let around = around(box_mesh([0.0; 3], [0.08, 0.06, sheet], 1), pin(0.009, above, 1e-4), &frame);
        let axis = times(frame.rotation(), &[0.0, 0.0, 1.0]);
        let walk = |pitch: f64| {
            let screw = Screw::new(&axis, frame.translation(), std::f64::consts::TAU, pitch).unwrap();
            let motion = Motion::screw(around.tool(), &frame, &screw).unwrap();
            around.walk_along(&around.seated_at_start(), &motion, WalkOptions::default(), &mut |_| ()).unwrap()
        };
        let down = walk(-0.06).fraction * 0.06;
        let free = above - 0.5 * sheet;
        assert!(down < free && down > free - NEAR, "{down}");
        assert!(walk(0.06).stop.is_none());
    }
}

#[test]
fn what_is_near_the_place_or_in_it_does_not_count() {
    // Flanges that stand out by less than 2 % of the size go through; and so does a pin through a thick plate, whose surface is cut to
    // pieces that lie deep in the pin.
    for frame in frames() {
        let size = (0.008f64 * 0.008 + 0.008 * 0.008 + 0.04 * 0.04).sqrt();
        for (share, is_free) in [(0.5 * 0.02, true), (2.0 * 0.02, false)] {
            let around =
                around(box_mesh([0.0; 3], [0.08, 0.06, 1e-4], 5), pin(0.004 + share * size, 0.007, 1e-4), &frame);
            assert_eq!(far(&around, &frame, [0.0, 0.0, -0.06], true).is_none(), is_free, "{share}");
        }
        let around = around(box_mesh([0.0; 3], [0.08, 0.06, 0.012], 9), pin(0.004, 0.007, 1e-4), &frame);
        for z in [0.06, -0.06] {
            assert_eq!(far(&around, &frame, [0.0, 0.0, z], true), None);
        }
    }
}

#[test]
fn a_flush_floor_beyond_the_place_does_not_hold_a_part_that_is_sunk_at_one_end() {
    // A bar on a floor, 3 mm of it in a narrow boss on that floor.
    let (floor, boss) =
        (box_mesh([0.0, 0.0, -0.01], [0.4, 0.1, 0.02], 3), box_mesh([-0.02, 0.0, 0.0], [0.046, 0.01, 0.03], 1));
    let bar = box_mesh([0.02, 0.0, 0.005], [0.04, 0.02, 0.01], 1);
    let around = around(joined([floor, boss]), bar, &Pose::IDENTITY);
    // Beyond the 2 % to 3 % of its size, where it is cast; exactly flush faces count as crossing in the end.
    let along = far(&around, &Pose::IDENTITY, [0.1, 0.0, 0.0], false);
    assert!(along.is_none_or(|along| along > 0.02), "{along:?}");
}

/// A pin of radius 4 mm along z between two heights, with a head of 9 mm above a height where there is one.
fn bolt(low: f64, high: f64, head: Option<f64>) -> Arrays {
    let mut profile = vec![[1e-4, low], [0.004, low]];
    profile.extend(head.into_iter().flat_map(|under| [[0.004, under], [0.009, under]]));
    profile.extend([[if head.is_some() { 0.009 } else { 0.004 }, high], [1e-4, high]]);
    lathe(&profile, 24, 0.1)
}

#[test]
fn a_plate_comes_off_a_solid_bolt_along_it_and_not_sideways() {
    // The plate moves: from 6 mm below to 6 mm above the middle, or thin as a sheet, and small or large.
    for (number, (half, wide)) in [(0.006, 0.04), (0.0004, 0.08), (0.003, 0.4)].into_iter().enumerate() {
        let frame = frames()[number];
        let plate = || box_mesh([0.003, 0.001, 0.0], [wide, 0.8 * wide, 2.0 * half], 1);
        let held = |bolt: Arrays, ways: &[Point]| {
            let around = around(bolt, plate(), &frame);
            for way in ways {
                for verifies in [false, true] {
                    let by = far(&around, &frame, *way, verifies).expect("it stops");
                    assert!(by < 1.5e-3, "{number} {way:?}: {by}");
                }
            }
            around
        };
        let (aside, high) = ([[wide, 0.0, 0.0], [-wide, 0.0, 0.0], [0.0, wide, 0.0]], half + 0.008);
        let (up, down) = ([0.0, 0.0, 0.05], [0.0, 0.0, -0.05]);
        let through = held(bolt(-high, high, None), &aside);
        assert_eq!([up, down].map(|way| far(&through, &frame, way, true)), [None, None]);
        for gap in [0.0, 1e-5, 5e-4] {
            let headed = held(bolt(-high, high, Some(half + gap)), &aside);
            assert_eq!(far(&headed, &frame, down, true), None);
            let free = far(&headed, &frame, up, true).expect("it stops");
            assert!(free < gap + 1e-6 && free > gap - NEAR, "{number} {gap}: {free}");
        }
        // In a bore without a hole: off its end alone.
        let blind = held(bolt(-high, 0.3 * half, None), &aside[..1]);
        assert!(far(&blind, &frame, up, true).is_none() && far(&blind, &frame, down, true).is_some());
    }
}
