//! Force shading: on facets of a curved surface the force does not jump, real edges stay, closed motions give no energy, and the force
//! of a step is that of its proxy.

mod common;

use std::sync::Arc;

use common::{at, scene};
use feeler_core::geometry::twist::{pose_of, product, rotation_of};
use feeler_core::geometry::vectors::{dot, length, scaled, sub};
use feeler_core::{Point, Pose, Scene, Tool};
use feeler_haptics::{Coupling, Session, SessionOptions, Step};
use feeler_shapes::{ball, box_mesh, cylinder, sheet, Arrays};

const TICK: f64 = 1e-3;
const RADIUS: f64 = 0.05;
const TOOL_RADIUS: f64 = 0.01;

fn tool((vertices, faces): Arrays) -> Arc<Tool> {
    Arc::new(Tool::new(vertices, faces).unwrap())
}

fn rod(sides: usize) -> Arc<Scene> {
    scene(cylinder(RADIUS, 0.3, sides, 1))
}

/// The pose of a ball on the rod at a depth, at an angle from the rod's highest line.
fn over(angle: f64, depth: f64) -> Pose {
    let reach = RADIUS + TOOL_RADIUS - depth;
    at([0.0013, reach * angle.sin(), reach * angle.cos()], [0.0; 3])
}

/// Evenly spaced numbers from one to another, without the first.
fn steps(from: f64, to: f64, count: usize) -> impl Iterator<Item = f64> {
    (1..=count).map(move |k| from + (to - from) * k as f64 / count as f64)
}

fn felt(scene: &Arc<Scene>, tool: &Arc<Tool>, way: &[Pose], options: SessionOptions) -> Vec<Step> {
    let mut session = Session::new(scene.clone(), tool.clone(), options).unwrap();
    session.start(&way[0]).unwrap();
    way.iter().map(|pose| session.step(Some(pose), TICK).unwrap()).collect()
}

fn unshaded() -> SessionOptions {
    SessionOptions::default().with_shading(false)
}

/// The largest change of the force in a tick as a share of its mean, while the ball slides at a depth at 5 cm/s.
fn largest_jump(sides: usize, bands: usize, depth: f64, options: SessionOptions) -> f64 {
    let turn = 0.05 * TICK / (RADIUS + TOOL_RADIUS);
    let press = steps(-0.002, depth, 200).map(|depth| over(-0.3, depth));
    let way: Vec<Pose> = press.chain((0..700).map(|k| over(-0.3 + turn * f64::from(k), depth))).collect();
    let found = felt(&rod(sides), &tool(ball(TOOL_RADIUS, bands)), &way, options);
    let forces: Vec<Point> = found[300..].iter().map(|step| step.wrench.force).collect();
    let mean = forces.iter().map(length).sum::<f64>() / forces.len() as f64;
    forces.windows(2).map(|pair| length(&sub(&pair[1], &pair[0]))).fold(0.0, f64::max) / mean
}

#[test]
fn the_force_does_not_jump_from_facet_to_facet() {
    for (sides, bands, depth, bare) in
        [(48, 32, 0.001, 0.1), (48, 16, 0.001, 0.1), (96, 32, 0.003, 0.05), (24, 32, 0.004, 0.1)]
    {
        let shaded = largest_jump(sides, bands, depth, SessionOptions::default());
        let unshaded = largest_jump(sides, bands, depth, unshaded());
        let most = if sides == 24 { 0.05 } else { 0.02 };
        assert!(shaded <= most && unshaded > bare, "{sides} {bands}: {shaded} {unshaded}");
    }
    // Between two sets the servo side follows the surface.
    let slow = SessionOptions::default().with_collision_hz(100.0);
    let found = largest_jump(48, 32, 0.001, slow);
    assert!(found <= 0.02, "{found}");
}

/// A box over the edges and faces of another, and pressed onto a flat plate: nothing there is curved.
#[test]
fn real_edges_and_flat_faces_are_not_shaded() {
    let cube = scene(box_mesh([0.0; 3], [0.1; 3], 2));
    let block = tool(box_mesh([0.0; 3], [0.02, 0.03, 0.02], 1));
    // Down on the upper face, askew, along over its edge, and down beside it.
    let way: Vec<Pose> = steps(0.063, 0.057, 100)
        .map(|z| at([0.03, 0.0, z], [0.0, 0.2, 0.1]))
        .chain(steps(0.03, 0.058, 400).map(|x| at([x, 0.001, 0.057], [0.0, 0.2, 0.1])))
        .chain(steps(0.057, 0.02, 300).map(|z| at([0.058, 0.001, z], [0.0, 0.2, 0.1])))
        .collect();
    let wrenches = |options| felt(&cube, &block, &way, options).into_iter().map(|step| step.wrench);
    let (shaded, bare): (Vec<_>, Vec<_>) =
        (wrenches(SessionOptions::default()).collect(), wrenches(unshaded()).collect());
    assert!(shaded == bare);
    assert!(bare.iter().any(|w| w.force[0] > 1.0) && bare.iter().any(|w| w.force[2] > 1.0));
    // On the plate the ball's facets feel like the plate's plane; over its edge they feel like facets.
    let round = tool(ball(TOOL_RADIUS, 16));
    let way: Vec<Pose> = steps(0.062, 0.057, 100)
        .map(|z| at([0.045, 0.0, z], [0.0; 3]))
        .chain(steps(0.045, 0.0555, 300).map(|x| at([x, 0.001, 0.057], [0.0; 3])))
        .collect();
    for (shaded, bare) in
        felt(&cube, &round, &way, SessionOptions::default()).iter().zip(felt(&cube, &round, &way, unshaded()))
    {
        assert_eq!((shaded.wrench, shaded.proxy), (bare.wrench, bare.proxy));
    }
}

/// A roof of two flat faces has a real edge, however flat; a flat face beside a fillet stays flat.
#[test]
fn a_flat_roof_is_not_round() {
    let corner = |x: f64, y: f64| [x, y, -0.1 * x.abs()];
    // Cut into strips across the ridge, so that the ridge has several sides in a row.
    let roof = scene(sheet(2, 7, |s, t| corner(0.2 * s - 0.1, 0.2 * t - 0.1)));
    let spike = tool(cylinder(0.004, 0.02, 24, 1));
    let way: Vec<Pose> = steps(0.006, 0.0, 100)
        .map(|z| at([-0.05, 0.003, z - 0.005], [0.0; 3]))
        .chain(steps(-0.05, 0.05, 500).map(|x| at([x, 0.003, -0.005], [0.0; 3])))
        .collect();
    let forces = |options| felt(&roof, &spike, &way, options).into_iter().map(|step| step.wrench.force);
    let (shaded, bare): (Vec<_>, Vec<_>) = (forces(SessionOptions::default()).collect(), forces(unshaded()).collect());
    assert!(shaded == bare, "{:?}", shaded.iter().zip(&bare).position(|(a, b)| a != b));
}

/// A flat top between two fillets is flat: no share of a fillet's normals, not even in its middle.
#[test]
fn a_flat_face_between_fillets_keeps_its_force() {
    const FACETS: usize = 6;
    let (half, height, radius) = (0.03, 0.04, 0.01);
    let arc = |k: usize| (k as f64 / FACETS as f64 * std::f64::consts::FRAC_PI_2).sin_cos();
    let right = (0..=FACETS).map(arc).map(|(sine, cosine)| {
        let (x, z) = (half - radius + radius * sine, height - radius + radius * cosine);
        [x, z]
    });
    let right: Vec<[f64; 2]> = right.chain([[half, 0.0]]).collect();
    let line: Vec<[f64; 2]> = right.iter().rev().map(|[x, z]| [-x, *z]).chain(right.iter().copied()).collect();
    let columns = line.len() - 1;
    let block = scene(sheet(columns, 1, |s, t| {
        let [x, z] = line[(s * columns as f64).round() as usize];
        [x, 0.2 * t - 0.1, z]
    }));
    let cube = tool(box_mesh([0.0; 3], [0.001; 3], 1));
    for x in [0.0, 0.01, 0.019] {
        let way: Vec<Pose> = steps(0.0435, 0.0395, 300).map(|z| at([x, 0.001, z], [0.0; 3])).collect();
        let forces = |options| felt(&block, &cube, &way, options).into_iter().map(|step| step.wrench.force);
        let (shaded, bare): (Vec<_>, Vec<_>) =
            (forces(SessionOptions::default()).collect(), forces(unshaded()).collect());
        assert!(shaded == bare && (bare[299][2] - 1.02).abs() < 0.01, "{x}: {:?} {:?}", shaded[299], bare[299]);
    }
}

/// The energy that the hand gains in each lap of a closed motion, as a share of the energy that it puts in.
fn gains(scene: &Arc<Scene>, tool: &Arc<Tool>, way: &[Pose], coupling: Coupling) -> Vec<f64> {
    const LAPS: usize = 4;
    let laps: Vec<Pose> = way.iter().copied().cycle().take(LAPS * way.len() + 1).collect();
    let found = felt(scene, tool, &laps, SessionOptions::default().with_coupling(coupling));
    // No pose turns on the way.
    let work = |k: usize| dot(&found[k].wrench.force, &sub(laps[k + 1].translation(), laps[k].translation()));
    let lap = |lap: usize| {
        let works: Vec<f64> = (lap * way.len()..(lap + 1) * way.len()).map(work).collect();
        works.iter().sum::<f64>() / -works.iter().map(|work| work.min(0.0)).sum::<f64>()
    };
    (0..LAPS).map(lap).collect()
}

/// What a closed motion may gain is little, and once: not in each lap.
fn assert_no_energy(gains: &[f64], what: &str) {
    let sum: f64 = gains.iter().sum();
    assert!(
        sum <= 0.015 && gains[gains.len() - 1] <= 0.004 && gains.iter().all(|gain| *gain > -0.05),
        "{what}: {gains:?}"
    );
}

/// A box's edge lies askew on the ridges of a rod and slides along itself: a force that was turned to the ridges' normals gave up to
/// 150 % a lap.
#[test]
fn an_edge_over_ridges_gives_no_energy() {
    let stick = tool(box_mesh([0.0; 3], [0.02, 0.06, 0.02], 1));
    let edge = 0.01 * std::f64::consts::SQRT_2;
    let coupling = Coupling::default().with_stiffness_n_per_m(300.0);
    for (sides, tilt) in [(20, 0.14), (32, 0.07), (48, 0.035), (96, 0.03)] {
        for towards in [1.0, -1.0] {
            let (turn, lean) = (rotation_of(&[0.0, std::f64::consts::FRAC_PI_4, 0.0]), rotation_of(&[-tilt, 0.0, 0.0]));
            let place = |along: f64, depth: f64| {
                let off = RADIUS + edge - depth;
                let (sine, cosine) = f64::sin_cos(tilt);
                let centre = [0.0013, off * sine + along * cosine, off * cosine - along * sine];
                pose_of(&product(&lean, &turn), &centre).unwrap()
            };
            let half = 0.006 * towards;
            let way: Vec<Pose> = steps(-0.002, 0.0015, 175)
                .map(|depth| place(half, depth))
                .chain(steps(half, -half, 600).map(|along| place(along, 0.0015)))
                .chain(steps(0.0015, -0.002, 175).map(|depth| place(-half, depth)))
                .chain(steps(-half, half, 100).map(|along| place(along, -0.002)))
                .collect();
            let found = gains(&rod(sides), &stick, &way, coupling);
            assert_no_energy(&found, &format!("{sides} {tilt} {towards}"));
        }
    }
}

/// Pressed deep on the way to the rim of a facet and not on the way back, either way round: a force that was only turned would give 4 %.
#[test]
fn closed_motions_over_facets_give_no_energy() {
    for sides in [48, 96] {
        let facet = std::f64::consts::TAU / sides as f64;
        for (bands, from, to) in [(32, 0.5, 1.0), (16, 0.5, 0.0), (32, 0.0, 0.5), (32, 0.25, 2.75)] {
            let (from, to) = (from * facet, to * facet);
            let way: Vec<Pose> = steps(-0.002, 0.0005, 100)
                .chain(steps(0.0005, 0.004, 200))
                .map(|depth| over(from, depth))
                .chain(steps(from, to, 200).map(|angle| over(angle, 0.004)))
                .chain(steps(0.004, 0.0005, 200).map(|depth| over(to, depth)))
                .chain(steps(to, from, 200).map(|angle| over(angle, 0.0005)))
                .chain(steps(0.0005, -0.002, 100).map(|depth| over(from, depth)))
                .collect();
            let found = gains(&rod(sides), &tool(ball(TOOL_RADIUS, bands)), &way, Coupling::default());
            assert_no_energy(&found, &format!("{sides} {bands} {from} {to}"));
        }
    }
}

/// Without dampers the force is the stiffness times the way from the device to the proxy, at every step.
#[test]
fn the_force_is_that_of_the_proxy_of_the_step() {
    let coupling = Coupling::default()
        .with_damping_n_s_per_m(0.0)
        .with_rotational_damping_nm_s_per_rad(0.0)
        .with_slew_n_per_s(1e8)
        .with_slew_nm_per_s(1e8)
        .with_max_force_n(100.0);
    let options = unshaded().with_coupling(coupling);
    let check = |scene: &Arc<Scene>, tool: &Arc<Tool>, way: &[Pose]| {
        let mut session = Session::new(scene.clone(), tool.clone(), options).unwrap();
        session.start(&way[0]).unwrap();
        let centre = session.centre();
        for (k, pose) in way.iter().enumerate() {
            let step = session.step(Some(pose), TICK).unwrap();
            let stretch = sub(&step.proxy.apply(&centre), &pose.apply(&centre));
            // The bound grows from zero within 0.2 s.
            let off = length(&sub(&scaled(&step.wrench.force, 1e-3), &stretch));
            assert!(k < 250 || off < 3e-6, "{k}: {off} {:?}", step.mode);
            assert!(!session.is_colliding(&step.proxy), "{k}");
        }
    };
    let turn = 0.05 * TICK / (RADIUS + TOOL_RADIUS);
    let press = steps(-0.002, 0.003, 250).map(|depth| over(-0.3, depth));
    let way: Vec<Pose> = press.chain((0..700).map(|k| over(-0.3 + turn * f64::from(k), 0.003))).collect();
    check(&rod(48), &tool(ball(TOOL_RADIUS, 16)), &way);
    // A box that rocks on a plate of twelve triangles.
    let plate = scene(box_mesh([0.0, 0.0, -0.01], [0.2, 0.2, 0.02], 1));
    let way: Vec<Pose> = steps(0.021, 0.015, 250)
        .map(|z| at([0.003, 0.001, z], [0.0; 3]))
        .chain((0..1000).map(|k| {
            let t = TICK * f64::from(k);
            at([0.003, 0.001, 0.015], [0.1 * (6.0 * t).sin(), 0.15 * (4.1 * t).sin(), 0.05 * t])
        }))
        .collect();
    check(&plate, &tool(box_mesh([0.0; 3], [0.03, 0.02, 0.04], 1)), &way);
}
