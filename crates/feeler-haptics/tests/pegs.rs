//! Pegs into holes of real fits, by a hand that is off by 1 mm and 1 degree: in to the bottom, and never in collision.

use std::f64::consts::TAU;
use std::sync::Arc;

use feeler_contacts::ContactSolver;
use feeler_core::geometry::twist::{pose_of, rotation_of};
use feeler_core::tool::metric::Metric;
use feeler_core::{Mockup, Point, Pose, Scene, SceneOptions, Tool};
use feeler_haptics::internals::Proxy;
use feeler_haptics::{Coupling, ProxyOptions};
use feeler_shapes::{lathe, Arrays};
use feeler_world::{Body, Surroundings};

/// Radius of all fits, metres; depth of the holes, and the chamfers of pegs and holes.
const RADIUS: f64 = 0.01;
const DEPTH: f64 = 0.04;
const CHAMFER: f64 = 0.0015;

fn body((vertices, faces): Arrays) -> Body {
    let mockup = Mockup::new(vertices, faces, vec![], 1).unwrap();
    let scene = Scene::build(Arc::new(mockup), &SceneOptions::default()).unwrap();
    Body { solver: ContactSolver::new(Arc::new(scene)), part: None }
}

/// A closed ring of (radius, height) about z: `n` sides, half a side turned, all corners `scale` times as far out.
fn turned(profile: &[[f64; 2]], n: usize, scale: f64) -> Arrays {
    let scaled: Vec<[f64; 2]> = profile.iter().map(|[r, z]| [scale * r, *z]).collect();
    lathe(&scaled, n, 0.5)
}

/// Hole and peg with `play` between them (metres, of the diameter). With `n` sides of both; a hole of many is around its circle and a
/// peg within it, so that the play is there however they are turned, four have it between their sides.
fn fit(n: usize, play: f64) -> (Body, Tool) {
    let [around, within] = if n == 4 { [2f64.sqrt(); 2] } else { [1.0 / (TAU / 2.0 / n as f64).cos(), 1.0] };
    let (r, p) = (RADIUS, RADIUS - 0.5 * play);
    let hole = [
        [0.03, -DEPTH - 0.01],
        [0.03, 0.0],
        [r + CHAMFER, 0.0],
        [r, -CHAMFER],
        [r, -DEPTH],
        [1e-4, -DEPTH],
        [1e-4, -DEPTH - 0.01],
    ];
    let peg = [[1e-4, 0.0], [p - CHAMFER, 0.0], [p, CHAMFER], [p, 0.06], [1e-4, 0.06]];
    let (vertices, faces) = turned(&peg, n, within);
    (body(turned(&hole, n, around)), Tool::new(vertices, faces).unwrap())
}

fn at(place: Point, turn: Point) -> Pose {
    pose_of(&rotation_of(&turn), &place).unwrap()
}

/// The height above the bottom that a peg reaches when the hand pushes it down by at most 4 mm of the coupling's spring.
fn height_reached(n: usize, play: f64, seed: u32) -> f64 {
    let (hole, peg) = fit(n, play);
    let (s, c) = (2.4 * f64::from(seed)).sin_cos();
    let (u, v) = (1.7 * f64::from(seed) + 0.3).sin_cos();
    let off = |z: f64| at([0.001 * s, 0.001 * c, z], [0.01745 * u, 0.01745 * v, 0.0]);
    let start = at([0.0, 0.0, 0.005], [0.0; 3]);
    let metric = Metric::new(&peg).with_lever(Coupling::default().lever_m()).unwrap();
    let around = Surroundings::around(vec![hole], Arc::new(peg), &start).unwrap();
    assert!(!around.has_seats());
    let mut proxy = Proxy::new(&around, metric, ProxyOptions::default()).unwrap();
    for k in 0..250 {
        let reached = proxy.pose().translation()[2];
        proxy.advance(&around, &off((0.005 - 0.0003 * f64::from(k)).max(reached - 0.004))).unwrap();
        assert!(!around.is_colliding(proxy.seated(), proxy.pose()), "{n} {play} {seed}: {k}");
    }
    proxy.pose().translation()[2] + DEPTH
}

/// ISO 286 at 20 mm: H11 is 0 to 130 um, c11 -110 to -240; H7 0 to 21, g6 -7 to -20. The least play, and the mean.
#[test]
fn pegs_go_in_to_the_bottom() {
    for n in [40, 4] {
        for play in [110e-6, 240e-6, 7e-6, 24e-6] {
            for seed in 0..2 {
                let left = height_reached(n, play, seed);
                // Down to the skin, leaning as far as the play allows.
                let most = 2.5e-5 + 1.5 * RADIUS * play / DEPTH;
                assert!(left > 0.0 && left < most, "{n} sides, {play} m of play, seed {seed}: {left} m left");
            }
        }
    }
}

#[test]
fn a_peg_that_is_too_thick_stays_out() {
    for n in [40, 4] {
        let left = height_reached(n, -200e-6, 1);
        assert!(left > DEPTH - 2.0 * CHAMFER - 1e-4, "{n}: {left}");
    }
}

#[test]
fn a_peg_of_fine_sides_goes_down_its_hole() {
    let left = height_reached(96, 24e-6, 0);
    assert!(left > 0.0 && left < 2.5e-5 + 1.5 * RADIUS * 24e-6 / DEPTH, "{left}");
}

/// Flanks and flats of a quarter of the pitch each, wound up four times: an open surface, 32 sides a turn.
fn thread(radius: f64, pitch: f64) -> Arrays {
    const SIDES: u32 = 32;
    let mut vertices = Vec::new();
    for quarter in 0..=16u32 {
        let r = radius + if quarter % 4 < 2 { 0.0 } else { 0.0008 };
        for i in 0..=SIDES {
            let turn = f64::from(i) / f64::from(SIDES);
            let (s, c) = (TAU * turn).sin_cos();
            vertices.push([r * c, r * s, pitch * (0.25 * f64::from(quarter) + turn)]);
        }
    }
    let corner = |quarter: u32, i: u32| quarter * (SIDES + 1) + i;
    let cells = (0..16).flat_map(|quarter| (0..SIDES).map(move |i| (quarter, i)));
    let both = cells.flat_map(|(q, i)| {
        let [a, b, c, d] = [corner(q, i), corner(q, i + 1), corner(q + 1, i + 1), corner(q + 1, i)];
        [[a, b, c], [a, c, d]]
    });
    (vertices, both.collect())
}

/// M10, 60 um of play: turned up against the lower flank by a hand that pulls it down.
#[test]
fn a_bolt_turns_in_its_nut() {
    let pitch = 0.0015;
    let nut = body(thread(0.00426, pitch));
    let (vertices, faces) = thread(0.0042, pitch);
    let bolt = Tool::new(vertices, faces).unwrap();
    let on_helix = |angle: f64, off: f64| at([0.0, 0.0, pitch * (2.0 + angle / TAU) + off], [0.0, 0.0, angle]);
    let metric = Metric::new(&bolt);
    let around = Surroundings::around(vec![nut], Arc::new(bolt), &on_helix(0.0, 0.0)).unwrap();
    let mut proxy = Proxy::new(&around, metric, ProxyOptions::default()).unwrap();
    for k in 0..100 {
        let angle = 0.01 * f64::from(k);
        proxy.advance(&around, &on_helix(angle, -1e-5 * f64::from(k.min(20)))).unwrap();
        assert!(!around.is_colliding(proxy.seated(), proxy.pose()), "{k}");
        let off = proxy.pose().translation()[2] - on_helix(angle, 0.0).translation()[2];
        assert!(off.abs() < 1.5e-4, "{k}: {off}");
    }
    let turned = proxy.pose().rotation()[1][0].asin();
    assert!((turned - 0.99).abs() < 0.05, "{turned}");
}
