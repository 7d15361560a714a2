//! Obstacles that stop the proxy although no plane forbids the motion: the proxy ends clear of them and does not hit them again.

use std::sync::Arc;

use feeler_contacts::ContactSolver;
use feeler_core::geometry::twist::{pose_of, rotation_of};
use feeler_core::tool::metric::Metric;
use feeler_core::{Mockup, Point, Pose, Scene, SceneOptions, Tool};
use feeler_haptics::internals::Proxy;
use feeler_haptics::{Coupling, ProxyOptions};
use feeler_shapes::{box_mesh, joined, Arrays};
use feeler_world::{Body, Surroundings};

fn around((vertices, faces): Arrays, tool: Arrays, start: &Pose) -> Surroundings {
    let mockup = Mockup::new(vertices, faces, vec![], 1).unwrap();
    let scene = Scene::build(Arc::new(mockup), &SceneOptions::default()).unwrap();
    let bodies = vec![Body { solver: ContactSolver::new(Arc::new(scene)), part: None }];
    Surroundings::around(bodies, Arc::new(Tool::new(tool.0, tool.1).unwrap()), start).unwrap()
}

fn at(place: Point, turn: Point) -> Pose {
    pose_of(&rotation_of(&turn), &place).unwrap()
}

fn proxy(around: &Surroundings, options: ProxyOptions) -> Proxy {
    let metric = Metric::new(around.tool()).with_lever(Coupling::default().lever_m()).unwrap();
    Proxy::new(around, metric, options).unwrap()
}

#[test]
fn a_wire_that_stopped_a_motion_is_kept_off_by_a_row() {
    // A tumbling box pressed into a grid of wires: no plane stands for an edge of the box across a wire. Of some 350 motions 16 are stopped
    // by a cast; without rows of these pairs it would be 378 of 624, and 87 with rows that the next look around forgets.
    let places = || (-12..=12).map(|i| 0.008 * f64::from(i) + 0.001);
    let along_x = places().map(|y| box_mesh([0.0, y, 0.0], [1.0, 2e-5, 2e-5], 1));
    let along_y = places().map(|x| box_mesh([x, 0.0, 0.0], [2e-5, 1.0, 2e-5], 1));
    let device = |k: u32| {
        let t = 0.001 * f64::from(k);
        at([0.1 * t, 0.0, 0.06 - 0.5 * t], [20.0 * t, 3.0 * t, 5.0 * t])
    };
    let around = around(joined(along_x.chain(along_y)), box_mesh([0.0; 3], [0.04, 0.03, 0.012], 1), &device(0));
    let mut proxy = proxy(&around, ProxyOptions::default());
    let (mut rounds, mut stopped) = (0, 0);
    for k in 0..250 {
        let done = proxy.advance(&around, &device(k)).unwrap();
        (rounds, stopped) = (rounds + done.rounds, stopped + done.stopped);
        assert!(!around.is_colliding(proxy.seated(), proxy.pose()), "{k}");
    }
    assert!(rounds > 250 && stopped > 0 && stopped < 40, "{stopped} of {rounds}");
}

#[test]
fn a_motion_that_is_stopped_ends_half_a_skin_off() {
    let block = || box_mesh([0.0; 3], [0.02; 3], 1);
    for turn in [[0.0; 3], [0.4, 0.2, 0.0]] {
        let start = at([0.0, 0.0, 0.05], turn);
        let around = around(box_mesh([0.0, 0.0, -0.01], [0.2, 0.2, 0.02], 1), block(), &start);
        let options = ProxyOptions::default().with_rounds(1);
        let mut proxy = proxy(&around, options);
        let done = proxy.advance(&around, &at([0.0, 0.0, -0.05], turn)).unwrap();
        assert_eq!((done.rounds, done.stopped), (1, 1));
        let gap = around.distance(proxy.seated(), proxy.pose(), 1.0).unwrap().unwrap();
        assert!(gap >= 0.5 * options.skin && gap < options.skin, "{gap}");
    }
}
