//! Pegs into holes of real fits, by a hand that is off.

use std::sync::Arc;

use feeler_contacts::ContactSolver;
use feeler_core::{Mockup, Point, Pose, Scene, SceneOptions, Tool};
use feeler_haptics::environment::{Body, Environment};
use feeler_haptics::metric::Metric;
use feeler_haptics::proxy::{Proxy, ProxyOptions};
use feeler_haptics::screw::{pose_of, rotation_of, rotation_vector};
use feeler_shapes::Arrays;

fn environment((vertices, faces): Arrays) -> Environment {
    let mockup = Mockup::new(vertices, faces, vec![], 1).unwrap();
    let scene = Scene::build(Arc::new(mockup), &SceneOptions::default(), &|_, _| true).unwrap();
    Environment { bodies: vec![Body { solver: ContactSolver::new(Arc::new(scene)), part: None }] }
}

/// A surface of revolution about z: a closed ring of (radius, height), `n` facets; the polygon is circumscribed where `outer`.
fn revolved(profile: &[[f64; 2]], n: usize, scale: f64) -> Arrays {
    let m = profile.len();
    let mut vertices = Vec::new();
    for i in 0..n {
        let (s, c) = (std::f64::consts::TAU * i as f64 / n as f64).sin_cos();
        vertices.extend(profile.iter().map(|[r, z]| [scale * r * c, scale * r * s, *z]));
    }
    let at = |i: usize, j: usize| ((i % n) * m + j % m) as u32;
    let mut faces = Vec::new();
    for i in 0..n {
        for j in 0..m {
            faces.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
            faces.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }
    (vertices, faces)
}

fn at(place: Point, turn: Point) -> Pose {
    pose_of(&rotation_of(&turn), &place).unwrap()
}

#[test]
fn explore() {
    let n = 96;
    let clearance: f64 = std::env::var("CL").map_or(7e-6, |x| x.parse().unwrap());
    let (r, depth, chamfer) = (0.01, 0.04, 0.0015);
    let grow = 1.0 / (std::f64::consts::PI / n as f64).cos();
    // Hole through a plate from z = -depth to 0, chamfered.
    let hole = revolved(
        &[
            [0.03, -depth - 0.01],
            [0.03, 0.0],
            [r + chamfer, 0.0],
            [r, -chamfer],
            [r, -depth],
            [1e-4, -depth],
            [1e-4, -depth - 0.01],
        ],
        n,
        grow,
    );
    let p = r - 0.5 * clearance;
    let peg = revolved(&[[1e-4, 0.0], [p - chamfer, 0.0], [p, chamfer], [p, 0.06], [1e-4, 0.06]], n, 1.0);
    let hole = environment(hole);
    let peg = Tool::new(peg.0, peg.1).unwrap();
    let mut proxy =
        Proxy::new(&hole, &peg, Metric::new(&peg), &at([0.0, 0.0, 0.005], [0.0; 3]), ProxyOptions::default()).unwrap();
    let start = std::time::Instant::now();
    let mut rounds = 0;
    let mut stopped = 0;
    for k in 0..1200 {
        let z = 0.005 - 0.00006 * f64::from(k);
        let device = at([0.0007, 0.0007, z], [0.0123, -0.0123, 0.3]);
        let before = *proxy.pose();
        let done = proxy.advance(&hole, &peg, &device).unwrap();
        rounds += done.rounds;
        stopped += done.stopped;
        assert!(!hole.is_colliding(&peg, proxy.pose()), "{k}");
        if std::env::var("TIMES").is_ok() && k % 100 == 0 && k > 0 {
            let t = std::time::Instant::now();
            let mut m = feeler_contacts::Manifolds::default();
            for margin in [2e-3, 4e-4, 1e-4, 3e-5] {
                let t = std::time::Instant::now();
                hole.manifolds(&peg, proxy.pose(), margin, &mut m).unwrap();
                eprintln!(
                    "   manifolds {margin} {} us, {} pairs, {}",
                    t.elapsed().as_micros(),
                    hole.bodies[0].solver.scene().near_pairs(&peg, proxy.pose(), margin).unwrap().len(),
                    m.manifolds.len()
                );
            }
            let way = proxy.pose().translated(&[1e-7, 0.0, -6e-5]).unwrap();
            for tol in [1e-6, 1e-7, 1e-8, 1e-9] {
                let t = std::time::Instant::now();
                let hit = hole.first_impact(&peg, proxy.pose(), &way, tol).unwrap();
                eprintln!("   cast {tol} {} us {:?}", t.elapsed().as_micros(), hit.map(|h| h.fraction));
            }
            let _ = t;
        }
        let _ = before;
        if k % 25 == 0 {
            let t = proxy.pose().translation();
            let w = rotation_vector(proxy.pose().rotation());
            eprintln!(
                "{k} z {:.2} proxy [{:.2}, {:.2}, {:.3}] um/mm tilt {:.5} {:.5} spin {:.3} rows {} planes {} skin {:.3} um rounds {} stopped {} time {:.0} us",
                z * 1e3, t[0] * 1e6, t[1] * 1e6, t[2] * 1e3, w[0], w[1], w[2], proxy.constraints().rows().len(), proxy.constraints().planes().len(), proxy.constraints().skin * 1e6, rounds, stopped,
                start.elapsed().as_secs_f64() * 1e6 / f64::from(k + 1)
            );
        }
    }
}
