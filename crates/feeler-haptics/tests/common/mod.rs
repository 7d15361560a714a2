//! Shared helpers of the tests of runs: a plate, a sheet, a box, and a hand on a device.
#![allow(dead_code, reason = "each test program uses some of it")]

use std::sync::Arc;

use feeler_core::geometry::twist::{pose_of, rotation_of};
use feeler_core::{Mockup, Point, Pose, Scene, SceneOptions, Tool};
use feeler_haptics::device::hand::{Hand, HandPath};
use feeler_haptics::device::simulated::{SimulatedDevice, SimulatedOptions};
use feeler_haptics::{Session, SessionOptions};
use feeler_shapes::{box_mesh, Arrays};

pub fn at(place: Point, turn: Point) -> Pose {
    pose_of(&rotation_of(&turn), &place).unwrap()
}

pub fn scene((vertices, faces): Arrays) -> Arc<Scene> {
    let mockup = Mockup::new(vertices, faces, vec![], 1).unwrap();
    Arc::new(Scene::build(Arc::new(mockup), &SceneOptions::default()).unwrap())
}

/// Its upper side is z = 0.
pub fn plate() -> Arc<Scene> {
    scene(box_mesh([0.0, 0.0, -0.01], [0.4, 0.4, 0.02], 4))
}

/// Of no thickness, at z = 0.
pub fn sheet() -> Arc<Scene> {
    let corner = |x: f64, y: f64| [x, y, 0.0];
    scene((
        vec![corner(-0.2, -0.2), corner(0.2, -0.2), corner(0.2, 0.2), corner(-0.2, 0.2)],
        vec![[0, 1, 2], [0, 2, 3]],
    ))
}

pub fn block() -> Arc<Tool> {
    let (vertices, faces) = box_mesh([0.0; 3], [0.03, 0.04, 0.05], 2);
    Arc::new(Tool::new(vertices, faces).unwrap())
}

/// Started with the block 5 mm above z = 0.
pub fn started(scene: Arc<Scene>, options: SessionOptions) -> Session {
    let mut session = Session::new(scene, block(), options).unwrap();
    session.start(&at([0.0, 0.0, 0.03], [0.0; 3])).unwrap();
    session
}

/// Down by 20 mm in 0.2 s, and then to and fro, with turns, always below the surface.
pub fn pushing() -> HandPath {
    let mut keys = vec![(0.0, at([0.0; 3], [0.0; 3])), (0.2, at([0.0, 0.0, -0.02], [0.0; 3]))];
    for k in 1..20 {
        let side = if k % 2 == 0 { 1.0 } else { -1.0 };
        let turn = [0.1 * side, 0.2, 0.3 * side];
        keys.push((0.2 + 0.15 * f64::from(k), at([0.03 * side, 0.01 * side, -0.02], turn)));
    }
    HandPath::new(keys).unwrap()
}

pub fn device(path: HandPath) -> SimulatedDevice {
    SimulatedDevice::new(SimulatedOptions::desktop_6dof(), Some(Hand::firm(path))).unwrap()
}
