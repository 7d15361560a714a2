//! Meshes as in real files, with slivers, open seams and cracks: the same planes as for clean ones.

use std::f64::consts::{PI, TAU};

use feeler_core::geometry::vectors::{add, along, cross, normal, scaled, sub, unit};
use feeler_core::{Point, Pose};
use feeler_shapes::{ball, box_mesh, box_sides, joined, sheet, Arrays};

use super::{at, moved, scene, tool, turned, Held};

/// A flat mesh with a strip of slivers between the two triangles of each cell, of this width and off their plane by up to `off`.
fn with_slivers((mut vertices, faces): Arrays, width: f64, off: f64) -> Arrays {
    let mut out = Vec::new();
    for (i, two) in faces.chunks_exact(2).enumerate() {
        let ([a, b, c], d) = (two[0], two[1][2]);
        assert_eq!([two[1][0], two[1][1]], [a, c]);
        let [p, q, r] = [a, b, c].map(|v| vertices[v as usize]);
        let n = normal(&[p, q, r]).unwrap();
        let across = unit(&cross(&n, &sub(&r, &p))).unwrap();
        let middle = scaled(&add(&p, &r), 0.5);
        let mut push = |side: f64, wave: f64| {
            let at = along(&middle, 0.5 * side * width, &across);
            vertices.push(along(&at, off * wave.sin(), &n));
            vertices.len() as u32 - 1
        };
        let (e, f) = (push(-1.0, 7.3 * i as f64), push(1.0, 5.1 * i as f64 + 1.0));
        out.extend([[a, b, e], [b, c, e], [a, e, f], [e, c, f], [c, d, f], [d, a, f]]);
    }
    (vertices, out)
}

#[test]
fn slivers_do_not_show() {
    // Where they are narrower than they are off the plane, their normals point anywhere.
    for (width, off) in [(1e-5, 0.0), (1e-7, 1e-8), (1e-8, 1e-8), (1e-9, 1e-8)] {
        for cells in [1, 3, 8] {
            let block = |centre: Point, size: Point| with_slivers(box_mesh(centre, size, cells), width, off);
            let plate = scene(block([0.0, 0.0, -0.01], [0.2, 0.2, 0.02]));
            let block = tool(block([0.0; 3], [0.05, 0.04, 0.03]));
            for turn in [0.0, 0.2] {
                let pose = Pose::new(&[
                    [f64::cos(turn), -f64::sin(turn), 0.0, 0.003],
                    [f64::sin(turn), f64::cos(turn), 0.0, 0.002],
                    [0.0, 0.0, 1.0, 0.015 - 0.0015],
                    [0.0, 0.0, 0.0, 1.0],
                ]);
                let planes = plate.contacts(&block, &pose.unwrap(), 0.002, None).unwrap().planes;
                let what = format!("{width} {off} {cells} {turn}: {planes:?}");
                assert_eq!(planes.len(), 1, "{what}");
                assert!((planes[0].gap + 0.0015).abs() < 10.0 * off + 1e-9, "{what}");
                assert!(planes[0].normal[2] > 1.0 - 1e-6, "{what}");
            }
        }
    }
}

#[test]
fn seams_and_poles_that_are_nearly_closed_are_no_border() {
    // Rounded sines, which are not 0 after half a turn.
    let naive = |r: f64, n: usize| {
        sheet(2 * n, n, |s, t| {
            let (phi, theta) = (TAU * s, PI * t);
            [r * theta.sin() * phi.cos(), r * theta.sin() * phi.sin(), -r * theta.cos()]
        })
    };
    for n in [6, 24, 50] {
        let pairs = [naive(0.05, n), ball(0.05, n)].map(|mesh| (scene(mesh.clone()), tool(mesh)));
        for far in [0.03, 0.06, 0.09] {
            let pose = turned(0.3, scaled(&[0.48, 0.6, 0.64], far));
            let [found, clean] = [&pairs[0], &pairs[1]].map(|(s, t)| s.contacts(t, &pose, 0.0, None).unwrap().planes);
            assert_eq!((found.len(), clean.len()), (1, 1), "{n} {far}: {found:?}");
            assert!((found[0].gap - clean[0].gap).abs() < 0.01 * (0.1 - far), "{n} {far}: {found:?} {clean:?}");
        }
    }
}

#[test]
fn bodies_that_touch_along_an_edge_are_solid() {
    // A block alone, and with another that touches it along an upright edge. More than half of the tool is inside: it comes out on the
    // right side only if the block is known to be solid.
    let block = || box_mesh([0.0, 0.0, -0.02], [0.04, 0.04, 0.04], 4);
    let both = joined([block(), box_mesh([0.04, 0.04, -0.02], [0.04, 0.04, 0.04], 4)]);
    let pin = tool(box_mesh([0.0; 3], [0.004, 0.005, 0.02], 2));
    for cells in [block(), both] {
        let scene = scene(cells);
        for depth in [0.004, 0.012, 0.016] {
            let planes = scene.contacts(&pin, &at(0.003, -0.001, 0.01 - depth), 0.0, None).unwrap().planes;
            assert_eq!(planes.len(), 1, "{depth}: {planes:?}");
            assert!((planes[0].gap + depth).abs() < 1e-12 && planes[0].normal[2] > 0.999, "{depth}: {planes:?}");
        }
    }
}

/// A box of which no two sides are triangulated alike.
fn uneven_box(size: Point) -> [Arrays; 6] {
    box_sides([0.0; 3], size, |side| [[3, 4], [5, 7], [1, 11], [6, 13], [2, 9], [17, 8]][side])
}

#[test]
fn a_tool_at_a_crack_is_as_deep_as_without_it() {
    let (cracked, clean) = (joined(uneven_box([0.1, 0.07, 0.04])), box_mesh([0.0; 3], [0.1, 0.07, 0.04], 3));
    let cube = |n| tool(box_mesh([0.0; 3], [0.02; 3], n));
    for angle in [0.0, 0.7] {
        let frame = turned(angle, [0.3, -0.2, 0.1]);
        let place = |mesh: &Arrays| scene(moved(mesh.clone(), &frame));
        let (cracked, clean) = (place(&cracked), place(&clean));
        // In one side, across edges, and at a corner.
        for by in [
            [0.003, 0.002, 0.0285],
            [0.0487, 0.003, 0.028],
            [0.0585, 0.043, 0.01],
            [0.058, 0.0, 0.0],
            [0.055, 0.04, 0.025],
        ] {
            let pose = turned(angle, frame.apply(&by));
            for n in [1, 5] {
                let depths = |scene: &Held| {
                    let contacts = scene.contacts(&cube(n), &pose, 0.002, None).unwrap();
                    let penetration = scene.penetration(&cube(n), &pose, 0.002, None).unwrap();
                    [contacts.planes.iter().map(|p| -p.gap).fold(0.0, f64::max), penetration.depth]
                };
                let (found, expected) = (depths(&cracked), depths(&clean));
                assert!(expected[0] > 1e-3, "{by:?}");
                for (found, expected) in found.iter().zip(&expected) {
                    assert!((found - expected).abs() <= 1e-2 * expected, "{by:?} {n} {found} {expected}");
                }
            }
        }
    }
}
