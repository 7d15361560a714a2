//! The same surfaces, cut coarsely and finely, flush and turned, give the same planes.

use std::sync::Arc;

use super::shapes::*;
use super::*;
use crate::scene::SceneOptions;

fn scene(mesh: Arrays) -> Scene {
    let mockup = Mockup::new(mesh.0, mesh.1, Vec::new(), 1).unwrap();
    Scene::build(Arc::new(mockup), &SceneOptions::default(), &|_, _| true).unwrap()
}

fn tool(mesh: Arrays) -> Tool {
    Tool::new(mesh.0, mesh.1).unwrap()
}

fn at(x: f64, y: f64, z: f64) -> Pose {
    Pose::IDENTITY.translated(&[x, y, z]).unwrap()
}

/// A turn about the axis (1, 2, 3).
fn turned(angle: f64, place: Point) -> Pose {
    let k = scaled(&[1.0, 2.0, 3.0], 1.0 / 14f64.sqrt());
    let (s, c) = angle.sin_cos();
    let mut m = [[0.0; 4]; 4];
    m[3][3] = 1.0;
    for i in 0..3 {
        for j in 0..3 {
            let sign = match (3 + j - i) % 3 {
                0 => 0.0,
                1 => -1.0,
                _ => 1.0,
            };
            let across = if i == j { 0.0 } else { sign * k[3 - i - j] };
            m[i][j] = if i == j { c } else { 0.0 } + (1.0 - c) * k[i] * k[j] + s * across;
        }
        m[i][3] = place[i];
    }
    Pose::new(&m).unwrap()
}

fn moved(mesh: Arrays, pose: &Pose) -> Arrays {
    (mesh.0.iter().map(|p| pose.apply(p)).collect(), mesh.1)
}

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
                assert_eq!(out.kind, PenetrationKind::Exact);
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
