//! Parts pressed into pockets: they come out, and stop where they stopped before.

use std::sync::Arc;

use feeler_contacts::ContactSolver;
use feeler_core::geometry::twist::{pose_of, rotation_of, times};
use feeler_core::{Mockup, Point, Pose, Scene, SceneOptions, Tool};
use feeler_shapes::{box_mesh, joined, Arrays};
use feeler_world::{Body, SeatKind, Surroundings, WalkOptions};

/// Half sides of the block, metres; it is in the pocket from 5 mm beneath the plate's face.
const HALF: [f64; 2] = [0.004, 0.015];
const FLOOR: f64 = -0.005;

/// A plate with a pocket that is smaller than the block on all sides.
fn pocket(by: f64) -> Arrays {
    let ring = |x: f64, y: f64, z: f64| [[-x, -y, z], [x, -y, z], [x, y, z], [-x, y, z]];
    let (x, y) = (HALF[0] - by, HALF[1] - by);
    let rings = [ring(0.03, 0.03, -0.02), ring(0.03, 0.03, 0.0), ring(x, y, 0.0), ring(x, y, FLOOR + by)];
    let mut faces = vec![[0, 2, 1], [0, 3, 2], [12, 13, 14], [12, 14, 15]];
    for below in [0, 4, 8] {
        for i in 0..4 {
            let j = (i + 1) % 4;
            faces.extend([[below + i, below + j, below + 4 + j], [below + i, below + 4 + j, below + 4 + i]]);
        }
    }
    (rings.concat(), faces)
}

/// The share of a way of 30 mm that the block is free for, along a direction.
fn share(fixed: Arrays, proud: f64, frame: &Pose, way: Point) -> f64 {
    let place = |(vertices, faces): Arrays| (vertices.iter().map(|p| frame.apply(p)).collect::<Vec<Point>>(), faces);
    let (vertices, faces) = place(fixed);
    let mockup = Mockup::new(vertices, faces, vec![], 1).unwrap();
    let scene = Scene::build(Arc::new(mockup), &SceneOptions::default()).unwrap();
    let height = proud - FLOOR;
    let block = box_mesh([0.0, 0.0, FLOOR + 0.5 * height], [2.0 * HALF[0], 2.0 * HALF[1], height], 1);
    let tool = Arc::new(Tool::new(block.0, block.1).unwrap());
    let body = Body { solver: ContactSolver::new(Arc::new(scene)), part: None };
    let around = Surroundings::around(vec![body], tool, frame).unwrap();
    assert_eq!(around.seats().map(|seat| seat.kind).collect::<Vec<_>>(), [SeatKind::Fit]);
    let to = frame.translated(&times(frame.rotation(), &way.map(|x| 0.03 * x))).unwrap();
    around.walk(&around.seated_at_start(), (frame, &to), WalkOptions::default()).unwrap().fraction
}

#[test]
fn a_block_pressed_into_a_blind_pocket_comes_out_and_stops_at_a_lip_and_at_its_floor() {
    let frame = |turn: Point, place: Point| pose_of(&rotation_of(&turn), &place).unwrap();
    let frames = [Pose::IDENTITY, frame([0.3, -0.2, 0.9], [0.1, 0.2, 0.3]), frame([2.0, 0.7, -1.1], [3.0, -2.0, 1.0])];
    for by in [2e-6, 5e-6, 1e-5, 2e-5, 5e-5] {
        for (number, frame) in frames.iter().enumerate() {
            for proud in [0.0, 0.004] {
                let case = format!("{by} {number} {proud}");
                assert_eq!(share(pocket(by), proud, frame, [0.0, 0.0, 1.0]), 1.0, "{case}");
                // No deeper into floor and walls than it was, by the play of a fit.
                for way in [[0.0, 0.0, -1.0], [1.0, 0.0, 0.0], [0.0, -1.0, 0.0]] {
                    let deeper = 0.03 * share(pocket(by), proud, frame, way);
                    assert!(deeper <= 1e-5 + 0.07 * by, "{case} {way:?}: {deeper}");
                }
                // A lip over a corner of it, of the same part, at 3 um and at 2 mm above it.
                for above in [3e-6, 0.002] {
                    let lip = box_mesh([0.006, 0.0, proud + above + 0.001], [0.005, 0.02, 0.002], 1);
                    let risen = 0.03 * share(joined([pocket(by), lip]), proud, frame, [0.0, 0.0, 1.0]);
                    assert!(risen <= above && risen > above - 3e-6, "{case} {above}: {risen}");
                }
            }
        }
    }
}
