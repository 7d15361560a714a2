//! Planes do not depend on the triangulation: the same surfaces, cut coarsely and finely, flush and turned, give the same planes.

use feeler_core::geometry::vectors::*;
use feeler_core::{Error, Point, Pose, Tool};
use feeler_shapes::{ball, box_mesh, cylinder, lathe, ridge, sheet, Arrays};

use super::{at, moved, scene, tool, turned, Held};
use crate::{ContactTracker, Contacts, PenetrationKind};

fn close(a: f64, b: f64, tolerance: f64) -> bool {
    (a - b).abs() <= tolerance
}

#[test]
fn a_box_in_a_plate_is_as_deep_as_it_is() {
    for (plate_cells, box_cells) in [(1, 1), (1, 12), (7, 1), (30, 2), (13, 20)] {
        let plate = box_mesh([0.0, 0.0, -0.01], [0.1, 0.1, 0.02], plate_cells);
        for margin in [0.0, 0.002] {
            for frame in [Pose::IDENTITY, turned(0.7, [0.3, -0.2, 0.1])] {
                let scene = scene(moved(plate.clone(), &frame));
                let tool = tool(box_mesh([0.0; 3], [0.03, 0.02, 0.04], box_cells));
                let pose = turned_in(&frame, [0.003, 0.002, 0.02 - 0.0015]);
                let contacts = scene.contacts(&tool, &pose, margin, None).unwrap();
                let up = sub(&frame.apply(&[0.0, 0.0, 1.0]), &frame.apply(&[0.0; 3]));
                let what = format!("plate {plate_cells}, box {box_cells}, margin {margin}: {contacts:#?}");
                assert_eq!(contacts.planes.len(), 1, "{what}");
                let plane = &contacts.planes[0];
                assert!(close(plane.gap, -0.0015, 1e-12), "{what}");
                assert!(dot(&plane.normal, &up) > 1.0 - 1e-12, "{what}");
                let out = scene.penetration(&tool, &pose, margin, None).unwrap();
                assert!(close(out.depth, 0.0015, 1e-8), "{out:?}");
                assert_eq!(out.kind, PenetrationKind::Bound);
            }
        }
    }
}

/// The tool upright in a turned frame, shifted there.
fn turned_in(frame: &Pose, by: Point) -> Pose {
    let r = frame.rotation();
    let t = frame.apply(&by);
    Pose::new(&[
        [r[0][0], r[0][1], r[0][2], t[0]],
        [r[1][0], r[1][1], r[1][2], t[1]],
        [r[2][0], r[2][1], r[2][2], t[2]],
        [0.0, 0.0, 0.0, 1.0],
    ])
    .unwrap()
}

/// Planes found at a pose, as (normal, depth).
fn found(scene: &Held, tool: &Tool, pose: &Pose, margin: f64, reference: Option<&Pose>) -> Vec<(Point, f64)> {
    let contacts = scene.contacts(tool, pose, margin, reference).unwrap();
    contacts.planes.iter().map(|p| (p.normal, -p.gap)).collect()
}

/// Asserts that the deep planes are those expected and no others.
fn expect(found: &[(Point, f64)], expected: &[(Point, f64)], tolerance: f64, what: &str) {
    let deep: Vec<_> = found.iter().filter(|f| f.1 > -1e-9).collect();
    assert_eq!(deep.len(), expected.len(), "{what}: {found:?}");
    for (n, depth) in expected {
        let n = scaled(n, 1.0 / feeler_core::geometry::vectors::length(n));
        let near =
            |f: &&&(Point, f64)| dot(&f.0, &n) > 1.0 - tolerance && close(f.1, *depth, tolerance * depth.abs() + 1e-12);
        assert!(deep.iter().any(|f| near(&f)), "{what}: {found:?} has not {n:?} {depth}");
    }
}

/// The shaft is the hole grown by 1.001, so each of its sides is 10 um deep, all around.
#[test]
fn a_shaft_pressed_into_a_hub_is_as_deep_as_the_press_all_around() {
    for n in [12, 32, 48, 64, 96, 128] {
        for turn in [0.0, 0.3] {
            let hub = lathe(&[[0.01, 0.0], [0.03, 0.0], [0.03, 0.03], [0.01, 0.03]], n, turn);
            let shaft = lathe(&[[0.0, -0.01], [0.01001, -0.01], [0.01001, 0.04], [0.0, 0.04]], n, turn);
            let contacts = scene(hub).contacts(&tool(shaft), &at(0.0, 0.0, 0.0), 0.0, None).unwrap();
            let deep: Vec<_> = contacts.planes.iter().filter(|plane| plane.gap < -1e-9).collect();
            let apothem = 1e-5 * (std::f64::consts::PI / n as f64).cos();
            for plane in &deep {
                let is_press = (apothem - 1e-9..1.001e-5 + 1e-9).contains(&-plane.gap);
                assert!(is_press, "{n} {turn}: {} {:?}", plane.gap, plane.normal);
                assert!(plane.normal[2].abs() < 1e-9, "{n} {turn}: {:?}", plane.normal);
            }
            // To all sides: the mean normal of the sides of a shaft is rounding, and no side leads in by it.
            for side in [[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0]] {
                assert!(deep.iter().any(|plane| dot(&plane.normal, &side) > 0.8), "{n} {turn}: {side:?}");
            }
        }
    }
}

#[test]
fn corners_ridges_and_brackets() {
    // A floor with a wall is concave: both have a plane. The wall leans by next to nothing, so that the line bounds a solid.
    let with_wall = [[-0.03, 0.05], [0.0, 0.05], [1e-9, 0.0], [0.1, 0.0]];
    let roof = [[-0.05, -0.05], [0.0, 0.0], [0.05, -0.05]];
    for (n, cells) in [(1, 1), (6, 1), (1, 7), (5, 8)] {
        for margin in [0.0, 0.002] {
            let what = format!("{n}, {cells}, {margin}");
            let floor_and_wall = scene(ridge(&with_wall, -0.05, 0.04, n, 3 * n));
            let cube = tool(box_mesh([0.01, 0.0, 0.01], [0.02; 3], cells));
            let planes = found(&floor_and_wall, &cube, &at(-0.001, 0.003, -0.0015), margin, None);
            expect(&planes, &[([0.0, 0.0, 1.0], 0.0015), ([1.0, 0.0, 0.0], 0.001)], 1e-5, &format!("corner {what}"));
            let out = floor_and_wall.penetration(&cube, &at(-0.001, 0.003, -0.0015), margin, None).unwrap();
            assert!(close(out.depth, 0.0015f64.hypot(0.001), 1e-7), "{out:?}");
            assert_eq!(out.kind, PenetrationKind::Bound);
            // A ridge under a flat tool: one plane, the tool's.
            let under = scene(ridge(&roof, -0.06, 0.04, n, 3 * n));
            let planes = found(&under, &cube, &at(-0.008, 0.0, -0.0015), margin, None);
            expect(&planes, &[([0.0, 0.0, 1.0], 0.0015)], 1e-9, &format!("ridge {what}"));
            // A box over the edge of another: sideways is less deep.
            let block = scene(box_mesh([0.0; 3], [0.1, 0.1, 0.02], n));
            let planes = found(&block, &cube, &at(0.0485, 0.003, 0.008), margin, None);
            expect(&planes, &[([1.0, 0.0, 0.0], 0.0015)], 1e-9, &format!("edge {what}"));
        }
    }
}

#[test]
fn a_bracket_holds_on_both_legs() {
    // A concave tool: an upside-down floor with a wall.
    let line = [[-0.01, -0.03], [0.0, -0.03], [1e-9, 0.0], [0.04, 0.0]];
    for (n, cells) in [(1, 1), (4, 1), (1, 6), (5, 7)] {
        for margin in [0.0, 0.002] {
            let bracket = tool(ridge(&line, 0.02, 0.02, cells, 2 * cells));
            let block = scene(box_mesh([0.05, 0.0, -0.05], [0.1; 3], n));
            let planes = found(&block, &bracket, &at(0.001, 0.0, -0.0015), margin, None);
            expect(
                &planes,
                &[([0.0, 0.0, 1.0], 0.0015), ([-1.0, 0.0, 0.0], 0.001)],
                1e-5,
                &format!("{n} {cells} {margin}"),
            );
        }
    }
}

#[test]
fn round_things() {
    let plate = |n| scene(box_mesh([0.0, 0.0, -0.01], [0.1, 0.1, 0.02], n));
    for (n, cells) in [(8, 1), (8, 20), (16, 1), (32, 9), (64, 2), (64, 30)] {
        for margin in [0.0, 0.002] {
            let what = format!("{n} {cells} {margin}");
            let ball_tool = tool(ball(0.02, n));
            let planes = found(&plate(cells), &ball_tool, &at(0.001, 0.002, 0.02 - 0.0015), margin, None);
            expect(&planes, &[([0.0, 0.0, 1.0], 0.0015)], 1e-9, &format!("ball {what}"));
            // Conversely: a plate on a ball.
            let plate_tool = tool(box_mesh([0.001, 0.002, 0.01], [0.1, 0.1, 0.02], cells));
            let planes = found(&scene(ball(0.02, n)), &plate_tool, &at(0.0, 0.0, 0.02 - 0.0015), margin, None);
            expect(&planes, &[([0.0, 0.0, 1.0], 0.0015)], 1e-9, &format!("plate {what}"));
            let rod = tool(cylinder(0.01, 0.06, 4 * n, cells));
            let planes = found(&plate(cells), &rod, &at(0.001, 0.002, 0.01 - 0.0015), margin, None);
            expect(&planes, &[([0.0, 0.0, 1.0], 0.0015)], 1e-9, &format!("rod {what}"));
            // Ball against ball, off the axes: as deep as the radii say, within what the facets cut off.
            let (a, b) = (scene(ball(0.02, n)), tool(ball(0.015, n)));
            let side = [2.0 / 3.0, 1.0 / 3.0, 2.0 / 3.0];
            let p = scaled(&side, 0.035 - 0.0015);
            let planes = found(&a, &b, &at(p[0], p[1], p[2]), margin, None);
            assert_eq!(planes.iter().filter(|p| p.1 > 0.0).count(), 1, "{what} {planes:?}");
            if n >= 32 {
                expect(&planes, &[(side, 0.0015)], if n >= 64 { 0.02 } else { 0.06 }, &format!("balls {what}"));
            }
        }
    }
}

#[test]
fn one_plane_stands_for_about_twelve_degrees() {
    let ball = tool(ball(0.02, 64));
    for angle in [10f64, 20.0] {
        let (sine, cosine) = angle.to_radians().sin_cos();
        let valley = [[-0.05, 0.0], [0.0, 0.0], [0.05, 0.05 * sine / cosine]];
        // The slope is the deeper side. The floor has a plane of its own where the angle between them is larger.
        let sides = [([-sine, 0.0, cosine], 0.02 - 0.019 * cosine), ([0.0, 0.0, 1.0], 0.001)];
        let expected = if angle < 12.0 { &sides[..1] } else { &sides };
        for (n, m) in [(1, 1), (4, 9), (11, 20)] {
            let valley = scene(ridge(&valley, -0.02, 0.04, n, m));
            let planes = found(&valley, &ball, &at(0.0, 0.001, 0.019), 0.0, None);
            expect(&planes, expected, 0.02, &format!("{angle}: {n} {m}"));
        }
    }
}

#[test]
fn a_plane_stands_for_sides_within_25_degrees_that_it_separates() {
    // A ball on a floor, and beside it a step down to a slope that stays below the floor.
    let ball_tool = tool(ball(0.02, 64));
    for angle in [20f64, 35.0] {
        let (sine, cosine) = angle.to_radians().sin_cos();
        let deepest = [0.019 * sine, 0.01 - 0.019 * cosine];
        let under = |x: f64| [x, deepest[1] + (x - deepest[0]) * sine / cosine];
        let edge = deepest[0] - 0.0035;
        let line = [[-0.05, 0.0], [edge, 0.0], under(edge + 1e-9), under(0.05)];
        let sides = [([0.0, 0.0, 1.0], 0.01), ([-sine, 0.0, cosine], 0.001)];
        let expected = if angle < 25.0 { &sides[..1] } else { &sides };
        for (n, m) in [(1, 1), (4, 9), (11, 20)] {
            let step = scene(ridge(&line, -0.02, 0.06, n, m));
            let planes = found(&step, &ball_tool, &at(0.0, 0.001, 0.01), 0.0, None);
            expect(&planes, expected, 0.02, &format!("{angle}: {n} {m}"));
        }
    }
}

#[test]
fn crossing_ridges_are_separated_across_both() {
    // The least depth is along no face normal of either, nor along a mean normal: those lean.
    let roof = [[-0.03, -0.06], [0.0, 0.0], [0.05, -0.02]];
    let hung: Vec<[f64; 2]> = roof.iter().map(|[x, z]| [*x, -z]).collect();
    let across = [[0.0, -1.0, 0.0, 0.002], [1.0, 0.0, 0.0, -0.003], [0.0, 0.0, 1.0, -0.0015], [0.0, 0.0, 0.0, 1.0]];
    for (n, m) in [(1, 1), (5, 3), (8, 13)] {
        let (lower, upper) = (scene(ridge(&roof, -0.1, 0.1, n, m)), tool(ridge(&hung, 0.1, 0.1, m, n)));
        let planes = found(&lower, &upper, &Pose::new(&across).unwrap(), 0.0, None);
        expect(&planes, &[([0.0, 0.0, 1.0], 0.0015)], 1e-6, &format!("{n} {m}"));
    }
}

#[test]
fn crossing_blades_are_separated_across_both_edges() {
    // The edge of each is nearly parallel to one side of the other.
    let blade = |sense: f64| [[-0.01, sense * 0.0275], [0.0, 0.0], [0.01, sense * 0.0275]];
    let (pitch, roll) = (60f64.to_radians(), 55f64.to_radians());
    let along = [-pitch.cos(), 0.0, -pitch.sin()];
    let out = [-pitch.sin(), 0.0, pitch.cos()];
    let up = feeler_core::geometry::vectors::along(&scaled(&out, roll.cos()), roll.sin(), &[0.0, 1.0, 0.0]);
    let side = feeler_core::geometry::vectors::cross(&along, &up);
    let place = scaled(&out, -0.0015);
    let row = |a: usize| [side[a], along[a], up[a], place[a]];
    let pose = Pose::new(&[row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]]).unwrap();
    for (n, m) in [(1, 1), (5, 3), (8, 13)] {
        let lower = scene(ridge(&blade(-1.0), -0.05, 0.1, n, m));
        let upper = tool(ridge(&blade(1.0), 0.05, 0.1, m, n));
        expect(&found(&lower, &upper, &pose, 0.0, None), &[(out, 0.0015)], 1e-6, &format!("{n} {m}"));
    }
}

#[test]
fn a_tooth_in_its_slot() {
    let (sine, cosine) = 20f64.to_radians().sin_cos();
    let (foot, rim) = (0.002, 0.002 + 0.01 * sine / cosine);
    let slot = [[-0.02, 0.0], [-rim, 0.0], [-foot, -0.01], [foot, -0.01], [rim, 0.0], [0.02, 0.0]];
    // The tooth ends a millimetre above the bottom of the slot, and begins a millimetre above its rim.
    let tip = 0.002 + 0.001 * sine / cosine;
    let tooth =
        [[-rim - 0.001 * sine / cosine, 0.001], [-tip, -0.009], [tip, -0.009], [rim + 0.001 * sine / cosine, 0.001]];
    let (left, right) = ([cosine, 0.0, sine], [-cosine, 0.0, sine]);
    for (n, cells) in [(1, 1), (9, 1), (1, 9), (8, 9)] {
        for margin in [0.0, 0.002] {
            let (scene, tool) =
                (scene(ridge(&slot, -0.02, 0.03, n, 3 * n)), tool(ridge(&tooth, 0.02, 0.01, cells, cells)));
            let (down, aside) = (0.0006, 0.0001);
            let planes = found(&scene, &tool, &at(aside, 0.0, -down), margin, None);
            let expected = [(left, down * sine - aside * cosine), (right, down * sine + aside * cosine)];
            expect(&planes, &expected, 1e-6, &format!("{n} {cells} {margin}"));
        }
    }
}

#[test]
fn open_sheets_go_by_the_reference() {
    for (n, cells) in [(1, 1), (15, 1), (1, 9), (16, 8)] {
        // An inconsistent winding, which says nothing about sides.
        let mut mesh = sheet(n, n, |s, t| [0.1 * (s - 0.5), 0.1 * (t - 0.5), 0.0]);
        mesh.1.iter_mut().enumerate().filter(|(i, _)| i % 3 == 0).for_each(|(_, f)| f.swap(0, 1));
        let scene = scene(mesh);
        let cube = tool(box_mesh([0.0; 3], [0.02; 3], cells));
        for margin in [0.0, 0.002] {
            for (sense, depth) in [(1.0, 0.0015), (-1.0, 0.0185)] {
                let reference = at(0.001, 0.002, sense * 0.05);
                let planes = found(&scene, &cube, &at(0.001, 0.002, 0.01 - 0.0015), margin, Some(&reference));
                expect(&planes, &[([0.0, 0.0, sense], depth)], 1e-9, &format!("{n} {cells} {margin} {sense}"));
            }
            // Over the border of the sheet.
            let planes = found(&scene, &cube, &at(0.045, 0.002, 0.01 - 0.0015), margin, Some(&at(0.05, 0.0, 0.05)));
            expect(&planes, &[([0.0, 0.0, 1.0], 0.0015)], 1e-9, &format!("border {n} {cells} {margin}"));
        }
        let mut tracker = ContactTracker::new();
        for step in 0..40 {
            let z = 0.02 - 0.0005 * f64::from(step);
            let contacts = tracker.contacts(scene.solver(), &cube, &at(0.0, 0.0, z), 0.002).unwrap();
            assert!(contacts.planes.iter().all(|p| p.normal[2] > 0.999), "{step}: {contacts:?}");
            assert!(close(contacts.depth(), (0.01 - z).max(0.0), 1e-12), "{step}: {contacts:?}");
        }
        assert!(tracker.last_free().is_some_and(|p| p.translation()[2] > 0.01));
    }
}

#[test]
fn gaps_between_flat_and_round_things() {
    for (n, cells) in [(1, 1), (12, 3), (30, 20)] {
        let plate = scene(box_mesh([0.0, 0.0, -0.01], [0.1, 0.1, 0.02], n));
        let cube = tool(box_mesh([0.0; 3], [0.02; 3], cells));
        for (gap, count) in [(0.001, 1), (0.0019, 1), (0.0021, 0)] {
            let contacts = plate.contacts(&cube, &at(0.001, 0.002, 0.01 + gap), 0.002, None).unwrap();
            assert_eq!(contacts.planes.len(), count, "{n} {cells} {gap}: {contacts:?}");
            if let Some(plane) = contacts.planes.first() {
                assert!(close(plane.gap, gap, 1e-12) && plane.normal[2] > 1.0 - 1e-12, "{plane:?}");
                assert!(!contacts.is_meeting && close(plane.point[2], 0.0, 1e-12), "{plane:?}");
            }
        }
        // Flush: it touches, and the gap is 0.
        let contacts = plate.contacts(&cube, &at(0.001, 0.002, 0.01), 0.002, None).unwrap();
        assert_eq!(contacts.planes.len(), 1, "{n} {cells}: {contacts:?}");
        assert!(contacts.is_meeting && contacts.planes[0].gap == 0.0, "{contacts:?}");
        assert!(contacts.planes[0].normal[2] > 1.0 - 1e-12, "{contacts:?}");
        let round = tool(ball(0.02, 8 * cells));
        let contacts = plate.contacts(&round, &at(0.001, 0.002, 0.021), 0.002, None).unwrap();
        assert_eq!(contacts.planes.len(), 1, "{n} {cells}: {contacts:?}");
        assert!(close(contacts.planes[0].gap, 0.001, 1e-12), "{contacts:?}");
    }
}

/// The tool slides over a finely cut flat face: the same normal and depth at every step.
#[test]
fn normals_do_not_flicker_on_a_flat_face() {
    let plate = scene(box_mesh([0.0, 0.0, -0.01], [0.1, 0.1, 0.02], 37));
    for (mesh, foot) in [(box_mesh([0.0; 3], [0.02; 3], 5), 0.01), (ball(0.012, 14), 0.012)] {
        let tool = tool(mesh);
        for gap in [-0.0015, 0.0, 0.001] {
            for step in 0..60 {
                let shift = 0.0007 * f64::from(step);
                let contacts = plate.contacts(&tool, &at(-0.02 + shift, 0.3 * shift, foot + gap), 0.002, None).unwrap();
                assert_eq!(contacts.planes.len(), 1, "{gap} {step}: {contacts:?}");
                let plane = &contacts.planes[0];
                assert!(plane.normal[2] > 1.0 - 1e-9, "{gap} {step}: {plane:?}");
                assert!(close(plane.gap, gap, 1e-9), "{gap} {step}: {plane:?}");
            }
        }
    }
}

/// A ball rolls around the edge of a block: the normal turns with it, in small steps.
#[test]
fn normals_turn_continuously_around_an_edge() {
    for n in [1, 9] {
        let block = scene(box_mesh([0.05, 0.0, -0.05], [0.1; 3], n));
        let round = tool(ball(0.01, 40));
        let two_facets = 9f64.to_radians().cos();
        for gap in [-0.0005, 0.001] {
            let mut before: Option<Point> = None;
            let steps = 90;
            for step in 0..=steps {
                // From above the top face (x > 0, z = 0) to beside the face x = 0.
                let angle = (step as f64 / steps as f64 * 130.0 - 20.0).to_radians();
                let r = 0.01 + gap;
                let over = |c: f64| if c < 0.0 { -c * 0.02 } else { 0.0 };
                let (s, c) = angle.clamp(0.0, 0.5 * std::f64::consts::PI).sin_cos();
                let down = (angle - 0.5 * std::f64::consts::PI).max(0.0);
                let pose = at(-r * s + over(angle), 0.0003, r * c - 0.02 * down);
                let contacts = block.contacts(&round, &pose, 0.002, None).unwrap();
                assert_eq!(contacts.planes.len(), 1, "{n} {gap} {step}: {contacts:?}");
                let plane = &contacts.planes[0];
                let expected = [-s, 0.0, c];
                assert!(dot(&plane.normal, &expected) > two_facets, "{n} {gap} {step}: {plane:?} {expected:?}");
                assert!(close(plane.gap, gap, 0.0001), "{n} {gap} {step}: {plane:?}");
                if let Some(before) = before {
                    assert!(dot(&plane.normal, &before) > two_facets, "{n} {gap} {step}: {plane:?} {before:?}");
                }
                before = Some(plane.normal);
            }
        }
    }
}

#[test]
fn right_through_a_thin_plate() {
    for (n, cells) in [(1, 1), (20, 1), (1, 12), (20, 12)] {
        let plate = scene(box_mesh([0.0; 3], [0.1, 0.1, 0.001], n));
        let rod = tool(box_mesh([0.0; 3], [0.005, 0.005, 0.1], cells));
        let planes = found(&plate, &rod, &at(0.001, 0.002, 0.03), 0.002, Some(&at(0.001, 0.002, 0.06)));
        assert!(planes.iter().all(|p| p.0[2] > 0.999), "{n} {cells}: {planes:?}");
        assert!(close(planes[0].1, 0.0205, 1e-9), "{n} {cells}: {planes:?}");
        let out = plate.penetration(&rod, &at(0.001, 0.002, 0.03), 0.002, Some(&at(0.001, 0.002, 0.06))).unwrap();
        assert!(close(out.depth, 0.0205, 1e-6), "{n} {cells}: {out:?}");
    }
}

#[test]
fn a_post_inside_the_tool() {
    // The post and the plate below it are one surface; the tool comes down over the post.
    let line = [[-0.05, 0.0], [-0.003, 0.0], [-0.003 + 1e-9, 0.004], [0.003 - 1e-9, 0.004], [0.003, 0.0], [0.05, 0.0]];
    for (n, cells) in [(1, 1), (5, 1), (1, 9), (5, 9)] {
        let post = scene(ridge(&line, -0.02, 0.03, n, 3 * n));
        let cube = tool(box_mesh([0.0; 3], [0.02; 3], cells));
        for margin in [0.0, 0.002] {
            let planes = found(&post, &cube, &at(0.001, 0.002, 0.01 + 0.0025), margin, None);
            expect(&planes, &[([0.0, 0.0, 1.0], 0.0015)], 1e-6, &format!("{n} {cells} {margin}"));
        }
    }
}

#[test]
fn bad_margins_are_errors_and_nothing_near_is_nothing() {
    let plate = scene(box_mesh([0.0; 3], [0.1, 0.1, 0.02], 2));
    let cube = tool(box_mesh([0.0; 3], [0.02; 3], 2));
    for margin in [-1e-9, f64::NAN, f64::INFINITY] {
        assert!(matches!(plate.contacts(&cube, &at(0.0, 0.0, 1.0), margin, None), Err(Error::Margin { .. })));
        assert!(plate.penetration(&cube, &at(0.0, 0.0, 1.0), margin, None).is_err());
    }
    assert_eq!(plate.contacts(&cube, &at(0.0, 0.0, 1.0), 0.002, None).unwrap(), Contacts::default());
    let out = plate.penetration(&cube, &at(0.0, 0.0, 1.0), 0.002, None).unwrap();
    assert_eq!((out.depth, out.kind), (0.0, PenetrationKind::Exact));
}

#[test]
fn no_plane_is_deeper_than_the_tool_or_the_part_is_large() {
    // Grazing edges, where rounding makes it hard to tell on which side a corner is.
    let plate = scene(box_mesh([0.0; 3], [0.1, 0.1, 0.02], 7));
    let small = tool(box_mesh([0.0; 3], [0.01, 0.01, 0.01], 3));
    let mut deep = 0;
    for i in 0..200 {
        let angle = 0.031 * f64::from(i);
        let pose =
            turned(angle, [0.05 + 0.005 * angle.sin(), 0.05 + 0.005 * angle.cos(), 0.01 + 0.006 * (3.0 * angle).sin()]);
        for plane in plate.contacts(&small, &pose, 0.002, None).unwrap().planes {
            assert!(plane.gap > -0.02, "{i}: {plane:?}");
            deep += usize::from(plane.gap < 0.0);
        }
    }
    assert!(deep > 100, "{deep} planes make no test");
}

#[test]
fn the_winding_of_a_closed_surface_does_not_matter() {
    let inverted = |mut mesh: Arrays| {
        mesh.1.iter_mut().for_each(|f| f.swap(1, 2));
        mesh
    };
    let (round, flat) = (ball(0.02, 24), box_mesh([0.0, 0.0, -0.02], [0.1, 0.1, 0.04], 9));
    for (mockup, tool_mesh, z) in [(&round, &flat, 0.012), (&flat, &round, 0.012)] {
        // Deep enough that most triangles inside meet nothing.
        let plain =
            scene(mockup.clone()).contacts(&tool(tool_mesh.clone()), &at(0.001, 0.002, z), 0.002, None).unwrap();
        assert!(plain.depth() > 0.005 && plain.planes[0].mockup_triangles.len() > 10, "{:?}", plain.planes);
        let other = scene(inverted(mockup.clone()));
        let tool = tool(inverted(tool_mesh.clone()));
        let other = other.contacts(&tool, &at(0.001, 0.002, z), 0.002, None).unwrap();
        assert_eq!(other.planes.len(), plain.planes.len());
        for (p, q) in plain.planes.iter().zip(&other.planes) {
            assert!(close(p.gap, q.gap, 1e-12) && dot(&p.normal, &q.normal) > 1.0 - 1e-12, "{p:?} {q:?}");
        }
    }
}
