//! A piercing has planes on the side of the tool's centre of area or of the reference, however fine the meshes.

use feeler_core::geometry::vectors::dot;
use feeler_core::{Mockup, Point, Pose, Tool};
use feeler_shapes::*;

use super::{at, scene, tool, Held};
use crate::constants::MANY_DEEP;
use crate::PenetrationKind;

const CELLS: [(usize, usize); 4] = [(1, 1), (20, 1), (1, 12), (20, 12)];

/// The depth of the deepest plane, after checking that all deep planes are along `normal`.
fn deepest_along(scene: &Held, tool: &Tool, pose: &Pose, reference: Option<&Pose>, normal: Point, what: &str) -> f64 {
    for margin in [0.0, 0.002] {
        let contacts = scene.contacts(tool, pose, margin, reference).unwrap();
        let deep: Vec<_> = contacts.planes.iter().filter(|p| p.gap < 0.0).collect();
        assert!(!deep.is_empty(), "{what}: {contacts:?}");
        assert!(deep.iter().all(|p| dot(&p.normal, &normal) > 0.999), "{what}: {contacts:?}");
    }
    scene.contacts(tool, pose, 0.0, reference).unwrap().depth()
}

#[test]
fn a_rod_through_a_plate_belongs_to_the_side_of_its_centre() {
    for (n, cells) in CELLS {
        let plate = scene(box_mesh([0.0; 3], [0.1, 0.1, 0.001], n));
        let rod = tool(box_mesh([0.0; 3], [0.005, 0.005, 0.1], cells));
        for (z, up) in [(0.03, 1.0), (-0.03, -1.0), (0.0001, 1.0)] {
            let (pose, what) = (at(0.001, 0.002, z), format!("{n} {cells} {z}"));
            let expected = 0.05 - z * up + 0.0005;
            let depth = deepest_along(&plate, &rod, &pose, None, [0.0, 0.0, up], &what);
            assert!((depth - expected).abs() < 1e-9, "{what}: {depth}");
            // The translation is the plane's depth along its normal.
            let out = plate.penetration(&rod, &pose, 0.002, None).unwrap();
            assert_eq!(out.kind, PenetrationKind::Bound, "{what}: {out:?}");
            assert!((out.depth - expected).abs() < 1e-6, "{what}: {out:?}");
        }
        // A reference overrides the centre.
        let depth =
            deepest_along(&plate, &rod, &at(0.001, 0.002, 0.03), Some(&at(0.0, 0.0, -0.08)), [0.0, 0.0, -1.0], "below");
        assert!((depth - 0.0805).abs() < 1e-9, "{n} {cells}: {depth}");
        // With the centre in the plate either side will do.
        let planes = plate.contacts(&rod, &at(0.001, 0.002, 0.0), 0.0, None).unwrap().planes;
        assert_eq!(planes.len(), 1, "{n} {cells}: {planes:?}");
        assert!(planes[0].normal[2].abs() > 0.999 && (planes[0].gap + 0.0505).abs() < 1e-9, "{n} {cells}: {planes:?}");
    }
}

#[test]
fn a_rod_askew_through_a_plate_is_drawn_out_across_the_plate() {
    for (n, cells) in CELLS {
        let plate = scene(box_mesh([0.0; 3], [0.3, 0.1, 0.001], n));
        let rod = tool(box_mesh([0.0; 3], [0.005, 0.005, 0.1], cells));
        let (s, c) = 70f64.to_radians().sin_cos();
        let matrix = |z: f64| {
            let place = [0.001 + z * s / c, 0.002, z];
            let rows = [[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]];
            let row = |a: usize| [rows[a][0], rows[a][1], rows[a][2], place[a]];
            Pose::new(&[row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]]).unwrap()
        };
        for (z, up) in [(0.008, 1.0), (-0.008, -1.0)] {
            let what = format!("{n} {cells} {z}");
            let depth = deepest_along(&plate, &rod, &matrix(z), None, [0.0, 0.0, up], &what);
            assert!((depth - (0.05 * c + 0.0025 * s + 0.0005 - 0.008)).abs() < 1e-9, "{what}: {depth}");
        }
    }
}

#[test]
fn a_wire_across_a_finger_is_pushed_out_of_it() {
    for (n, cells) in CELLS {
        let wire = scene(cylinder(0.001, 0.2, 12, n));
        let finger = tool(box_mesh([0.0; 3], [0.02; 3], cells));
        for (z, up) in [(-0.004, -1.0), (0.004, 1.0)] {
            let what = format!("{n} {cells} {z}");
            let depth = deepest_along(&wire, &finger, &at(0.003, 0.0, z), None, [0.0, 0.0, up], &what);
            assert!((depth - (0.01 - 0.004 + 0.001)).abs() < 1e-5, "{what}: {depth}");
        }
    }
}

#[test]
fn a_bent_wire_across_a_finger_has_one_plane() {
    for cells in [1, 2, 12] {
        let bend = |p: &Point| {
            let (angle, r) = (p[0] / 0.05, 0.05 + p[2]);
            [r * angle.sin(), p[1], r * angle.cos() - 0.05]
        };
        let (vertices, faces) = cylinder(0.002, 0.1, 12, 240);
        let wire = scene((vertices.iter().map(bend).collect(), faces));
        let finger = tool(box_mesh([0.0; 3], [0.02; 3], cells));
        // At the sides of the finger the wire is lower than in the middle: the sagitta of its inner side over half the finger's width.
        let lower = 0.048 - (0.048f64.powi(2) - 0.01f64.powi(2)).sqrt();
        for (z, up, expected) in [(-0.005, -1.0, 0.007 + lower), (0.004, 1.0, 0.008)] {
            let what = format!("{cells} {z}");
            let depth = deepest_along(&wire, &finger, &at(0.0, 0.0, z), None, [0.0, 0.0, up], &what);
            assert!((depth - expected).abs() < 1e-5, "{what}: {depth} {expected}");
            assert_eq!(wire.contacts(&finger, &at(0.0, 0.0, z), 0.0, None).unwrap().planes.len(), 1, "{what}");
        }
    }
}

#[test]
fn a_rod_through_both_walls_of_a_casing_is_as_deep_as_in_the_farther_one() {
    for (n, cells) in CELLS {
        let walls = scene(joined([0.0, 0.02].map(|z| box_mesh([0.0, 0.0, z], [0.1, 0.1, 0.001], n))));
        let rod = tool(box_mesh([0.0; 3], [0.005, 0.005, 0.1], cells));
        for (z, up) in [(0.04, 1.0), (-0.02, -1.0)] {
            let what = format!("{n} {cells} {z}");
            let depth = deepest_along(&walls, &rod, &at(0.001, 0.002, z), None, [0.0, 0.0, up], &what);
            assert!((depth - 0.0305).abs() < 1e-9, "{what}: {depth}");
        }
    }
}

#[test]
fn beside_many_deep_planes_nothing_is_assumed() {
    // A comb whose teeth stand in as many feet, and at its end a rod through a sheet of another part.
    let teeth = |count: usize| (0..count).map(|i| box_mesh([0.01 * i as f64, 0.0, 0.0], [0.004, 0.004, 0.02], 1));
    for (count, is_assumed) in [(2, true), (2 * MANY_DEEP, false)] {
        let feet = joined((0..count).map(|i| box_mesh([0.01 * i as f64, 0.0, -0.015], [0.006, 0.006, 0.012], 1)));
        let sheet = box_mesh([-0.03, 0.0, 0.0], [0.02, 0.02, 0.001], 3);
        let faces = [feet.1.len(), sheet.1.len()];
        let mesh = joined([feet, sheet]);
        let parts = (0..2).flat_map(|part| vec![part as u32; faces[part]]).collect();
        let mockup = Mockup::new(mesh.0, mesh.1, parts, 2).unwrap();
        let scene = Held::of(mockup);
        let comb = tool(joined(teeth(count).chain([box_mesh([-0.03, 0.0, 0.01], [0.002, 0.002, 0.03], 2)])));
        let contacts = scene.contacts(&comb, &at(0.0, 0.0, 0.0005), 0.0, None).unwrap();
        assert_eq!(contacts.planes.iter().any(|p| p.part == 1), is_assumed, "{count}: {contacts:?}");
        assert!(contacts.planes.iter().any(|p| p.part == 0), "{count}: {contacts:?}");
    }
}
