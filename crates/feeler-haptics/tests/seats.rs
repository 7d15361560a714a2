//! Fitted parts: seated parts slide and separate, move no deeper, and collide with everything else exactly. The same by
//! guarded moves and by a session with force.

use std::sync::Arc;

use feeler_contacts::ContactSolver;
use feeler_core::geometry::twist::{pose_of, rotation_of};
use feeler_core::{Mockup, Point, Pose, Scene, SceneOptions, Tool};
use feeler_haptics::{Mode, SeatKind, Session, SessionOptions, Start};
use feeler_shapes::{box_mesh, joined, lathe, Arrays};
use feeler_world::{Body, Surroundings, WalkOptions};

/// Places: at the origin, and 3 km off, where coordinates are rounded to half a picometre.
const PLACES: [Point; 2] = [[0.0; 3], [3000.0, -2000.0, 1000.0]];

fn moved((vertices, faces): Arrays, by: Point) -> Arrays {
    (vertices.iter().map(|p| std::array::from_fn(|a| p[a] + by[a])).collect(), faces)
}

/// A closed outline in x and z, counterclockwise, drawn along y.
fn extruded(outline: &[[f64; 2]], width: f64, triangles: &[[u32; 3]]) -> Arrays {
    let n = outline.len() as u32;
    let vertices = [-0.5, 0.5].iter().flat_map(|y| outline.iter().map(move |[x, z]| [*x, y * width, *z])).collect();
    let mut faces: Vec<[u32; 3]> = triangles.to_vec();
    faces.extend(triangles.iter().map(|[a, b, c]| [a + n, c + n, b + n]));
    for k in 0..n {
        let next = (k + 1) % n;
        faces.extend([[k, k + n, next], [next, k + n, next + n]]);
    }
    (vertices, faces)
}

fn scene((vertices, faces): Arrays) -> Arc<Scene> {
    let mockup = Mockup::new(vertices, faces, vec![], 1).unwrap();
    Arc::new(Scene::build(Arc::new(mockup), &SceneOptions::default()).unwrap())
}

fn at(place: Point) -> Pose {
    pose_of(&rotation_of(&[0.0; 3]), &place).unwrap()
}

fn plus(a: Point, b: Point) -> Point {
    std::array::from_fn(|i| a[i] + b[i])
}

/// The mock-up, the moving tool and its start pose.
struct Fit {
    scene: Arc<Scene>,
    tool: Arc<Tool>,
    start: Point,
}

impl Fit {
    fn new(around: Arrays, tool: Arrays, start: Point, place: Point) -> Fit {
        let tool = Arc::new(Tool::new(tool.0, tool.1).unwrap());
        Fit { scene: scene(moved(around, place)), tool, start: plus(start, place) }
    }

    /// How far a guarded move gets, metres.
    fn walked(&self, by: Point) -> Point {
        let body = Body { solver: ContactSolver::new(self.scene.clone()), part: None };
        let around = Surroundings::around(vec![body], self.tool.clone(), &at(self.start)).unwrap();
        let to = at(plus(self.start, by));
        let walk =
            around.walk(&around.seated_at_start(), (&at(self.start), &to), WalkOptions::search(&[], &|| true)).unwrap();
        std::array::from_fn(|a| walk.pose.translation()[a] - self.start[a])
    }

    /// The kinds of the seats when a session begins.
    fn kinds(&self) -> Vec<SeatKind> {
        let mut session = Session::new(self.scene.clone(), self.tool.clone(), SessionOptions::default()).unwrap();
        match session.start(&at(self.start)).unwrap() {
            Start::Free => Vec::new(),
            Start::Seated(seating) => seating.seats.iter().map(|seat| seat.kind).collect(),
        }
    }

    /// Where a hand gets the tool that goes there in 0.4 s, and presses `press` beyond all the way; and the force in the first step and in
    /// the last.
    fn led(&self, by: Point, press: Point) -> (Point, [Point; 2]) {
        let mut session = Session::new(self.scene.clone(), self.tool.clone(), SessionOptions::default()).unwrap();
        session.start(&at(self.start)).unwrap();
        let (mut forces, mut place) = (Vec::new(), [0.0; 3]);
        for k in 0..600 {
            let share = f64::from(k.min(400)) / 400.0;
            let device = plus(plus(self.start, press), by.map(|x| x * share));
            let step = session.step(Some(&at(device)), 0.001).unwrap();
            assert_ne!(step.mode, Mode::Doubt);
            assert!(!session.is_colliding(&step.proxy), "{k}");
            forces.push(step.wrench.force);
            place = std::array::from_fn(|a| step.proxy.translation()[a] - self.start[a]);
        }
        (place, [forces[0], forces[forces.len() - 1]])
    }
}

/// A floor with a wall on it at x = 35 mm, as two blocks of one part or as one body; both reach from -0.1 to 0.1 m.
fn brackets() -> [Arrays; 2] {
    let blocks =
        joined([box_mesh([0.0, 0.0, -0.01], [0.2, 0.2, 0.02], 1), box_mesh([0.045, 0.0, 0.03], [0.02, 0.2, 0.06], 1)]);
    let outline = [[-0.1, -0.02], [0.1, -0.02], [0.1, 0.06], [0.035, 0.06], [0.035, 0.0], [-0.1, 0.0]];
    let body = extruded(&outline, 0.2, &[[0, 1, 4], [0, 4, 5], [1, 2, 3], [1, 3, 4]]);
    [blocks, body]
}

#[test]
fn a_block_on_a_bracket_stops_at_the_wall() {
    let block = || box_mesh([0.0; 3], [0.03; 3], 1);
    for (place, gap) in PLACES.iter().flat_map(|p| [0.0, 1e-15, 1e-12, 1e-6, -1e-12, -1e-6, -1e-5].map(|gap| (*p, gap)))
    {
        for (number, bracket) in brackets().into_iter().enumerate() {
            let fit = Fit::new(bracket, block(), [0.01, 0.0, 0.015 + gap], place);
            let what = format!("{gap} at {place:?}, bracket {number}");
            let deep = fit.kinds().contains(&SeatKind::Sunk);
            assert!(!deep && !fit.kinds().is_empty(), "{what}: {:?}", fit.kinds());
            let walked = fit.walked([0.03, 0.0, 0.0]);
            assert!(walked[0] > 0.01 - 3e-6 && walked[0] <= 0.01 + 1e-12, "{what}: {walked:?}");
            // It does not move down.
            let down = fit.walked([0.0, 0.0, -0.01]);
            assert!(down[2] > -1.2e-5, "{what}: {down:?}");
            // Pressed down, to the wall and against it.
            let (led, forces) = fit.led([0.03, 0.0, 0.0], [0.0, 0.0, -0.002]);
            assert!(led[0] > 0.01 - 5e-5 && led[0] <= 0.01, "{what}: {led:?}");
            assert!(led[2] > -1.2e-5 && led[2] < 3e-5, "{what}: {led:?}");
            assert!(forces[0][2] > 0.1 && forces[1][0] < -3.0, "{what}: {forces:?}");
            // Lifted, it is free, and from then on it stops at the surface.
            let (up, forces) = fit.led([0.0, 0.0, 0.01], [0.0; 3]);
            assert!(
                (up[2] - 0.01).abs() < 1e-6 && forces[1].iter().all(|x| x.abs() < 1e-6),
                "{what}: {up:?} {forces:?}"
            );
        }
    }
}

#[test]
fn a_shaft_with_a_collar_stops_at_its_collar() {
    // Line to line, cut at angles of their own: the shaft is in the bore by its facets. The collar is 5 mm above the plate.
    for (n, m) in [(64, 64), (48, 96), (200, 64)] {
        let plate = lathe(&[[0.04, -0.03], [0.04, 0.0], [0.01, 0.0], [0.01, -0.03]], n, 0.0);
        let shaft =
            lathe(&[[1e-3, -0.05], [0.01, -0.05], [0.01, 0.005], [0.015, 0.005], [0.015, 0.02], [1e-3, 0.02]], m, 0.37);
        for place in PLACES {
            let fit = Fit::new(plate.clone(), shaft.clone(), [0.0; 3], place);
            assert_eq!(fit.kinds(), [SeatKind::Fit], "{n} {m}");
            let walked = fit.walked([0.0, 0.0, -0.02]);
            assert!(walked[2] < -0.005 + 3e-6 && walked[2] >= -0.005 - 1e-12, "{n} {m}: {walked:?}");
            let (led, forces) = fit.led([0.0, 0.0, -0.02], [0.0; 3]);
            assert!(led[2] < -0.005 + 5e-5 && led[2] >= -0.005, "{n} {m}: {led:?}");
            assert!(forces[1][2] > 3.0, "{n} {m}: {forces:?}");
            let out = fit.walked([0.0, 0.0, 0.1]);
            assert!((out[2] - 0.1).abs() < 1e-9, "{n} {m}: {out:?}");
            let aside = fit.walked([0.01, 0.0, 0.0]);
            assert!(aside[0] < 5e-5, "{n} {m}: {aside:?}");
        }
    }
}

#[test]
fn a_pin_in_a_blind_hole_reaches_the_bottom_and_comes_out() {
    // 3 mm above the bottom.
    let hole =
        lathe(&[[0.04, -0.05], [0.04, 0.0], [0.006, 0.0], [0.006, -0.04], [1e-4, -0.04], [1e-4, -0.05]], 72, 0.0);
    let pin = lathe(&[[1e-4, -0.037], [0.006, -0.037], [0.006, 0.02], [1e-4, 0.02]], 64, 0.21);
    let fit = Fit::new(hole, pin, [0.0; 3], PLACES[0]);
    assert_eq!(fit.kinds(), [SeatKind::Fit]);
    let walked = fit.walked([0.0, 0.0, -0.02]);
    assert!(walked[2] < -0.003 + 3e-6 && walked[2] >= -0.003 - 1e-12, "{walked:?}");
    let (led, _) = fit.led([0.0, 0.0, -0.02], [0.0; 3]);
    assert!(led[2] < -0.003 + 5e-5 && led[2] >= -0.003, "{led:?}");
    let (out, forces) = fit.led([0.0, 0.0, 0.06], [0.0; 3]);
    assert!((out[2] - 0.06).abs() < 1e-5 && forces[1].iter().all(|x| x.abs() < 1e-3), "{out:?} {forces:?}");
}

#[test]
fn a_drawer_slides_in_its_case() {
    // Flush below, above and on both sides; its front is 20 mm inside, its back 30 mm off the wall.
    let case = joined([
        box_mesh([0.0, 0.0, -0.01], [0.2, 0.14, 0.02], 1),
        box_mesh([0.0, 0.0, 0.06], [0.2, 0.14, 0.02], 1),
        box_mesh([0.0, 0.06, 0.025], [0.2, 0.02, 0.05], 1),
        box_mesh([0.0, -0.06, 0.025], [0.2, 0.02, 0.05], 1),
        box_mesh([0.11, 0.0, 0.025], [0.02, 0.14, 0.09], 1),
    ]);
    let drawer = box_mesh([0.0; 3], [0.15, 0.1, 0.05], 2);
    let fit = Fit::new(case, drawer, [-0.005, 0.0, 0.025], PLACES[0]);
    assert_eq!(fit.kinds(), [SeatKind::Flush]);
    let walked = fit.walked([0.06, 0.0, 0.0]);
    assert!(walked[0] > 0.03 - 3e-6 && walked[0] <= 0.03 + 1e-12, "{walked:?}");
    let out = fit.walked([-0.3, 0.0, 0.0]);
    assert!(out[0] == -0.3, "{out:?}");
    let (led, forces) = fit.led([0.06, 0.0, 0.0], [0.0; 3]);
    assert!(led[0] > 0.03 - 5e-5 && led[0] <= 0.03 && forces[1][0] < -3.0, "{led:?} {forces:?}");
    let (out, _) = fit.led([-0.3, 0.0, 0.0], [0.0, 0.0, -0.001]);
    assert!(out[0] < -0.29, "{out:?}");
}

#[test]
fn a_bolt_without_a_hole_leaves_through_the_place_that_it_filled() {
    let plate = box_mesh([0.0, 0.0, -0.015], [0.2, 0.2, 0.03], 1);
    let bolt = lathe(&[[1e-4, -0.02], [0.004, -0.02], [0.004, 0.03], [1e-4, 0.03]], 32, 0.0);
    let fit = Fit::new(plate, bolt, [0.0; 3], PLACES[0]);
    assert_eq!(fit.kinds(), [SeatKind::Sunk]);
    // Its length is 51 mm, the play of its place 2 % of that.
    let play = 0.02 * 0.0513 + 1e-5;
    for by in [[0.05, 0.0, 0.0], [0.0, -0.05, 0.0], [0.03, 0.03, 0.01]] {
        let aside = fit.walked(by);
        assert!(aside[0].hypot(aside[1]) <= play, "{aside:?}");
    }
    let out = fit.walked([0.0, 0.0, 0.1]);
    assert!(out == [0.0, 0.0, 0.1], "{out:?}");
}
