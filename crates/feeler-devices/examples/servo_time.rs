//! The CPU time of a servo tick: `cargo run --release --example servo_time [TICKS]`.
//!
//! A hand-sized tool among planes on all sides, each carried by four or eight points, and a device that moves all the
//! time and presses against some of them: the most that a set holds, and harder than any real scene.

use feeler_core::geometry::twist::{pose_of, rotation_of};
use feeler_core::tool::metric::Metric;
use feeler_core::{Pose, Tool};
use feeler_devices::machine::thread_time;
use feeler_haptics::internals::ConstraintSet;
use feeler_haptics::internals::{Servo, ServoInput};
use feeler_haptics::{Coupling, Plane, SessionOptions};
use feeler_shapes::box_mesh;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let ticks: usize = std::env::args().nth(1).map_or(Ok(100_000), |n| n.parse())?;
    println!("ticks {ticks}");
    println!("planes rows   median   p99      p99.9    worst (us)   held");
    for (planes, points) in [(4, 4), (16, 4), (32, 4), (32, 8)] {
        let (mut took, held) = run(planes, points, ticks)?;
        took.sort_by(f64::total_cmp);
        let at = |share: f64| 1e6 * took[((took.len() - 1) as f64 * share) as usize];
        let [median, p99, p999, worst] = [at(0.5), at(0.99), at(0.999), at(1.0)];
        let rows = planes * points;
        println!("{planes:6} {rows:4} {median:8.1} {p99:8.1} {p999:8.1} {worst:8.1}        {held:.1}");
    }
    Ok(())
}

/// Time of each tick, seconds, and how many planes held on average.
fn run(planes: usize, points: usize, ticks: usize) -> Result<(Vec<f64>, f64), Box<dyn std::error::Error>> {
    let (vertices, faces) = box_mesh([0.0; 3], [0.06, 0.05, 0.12], 2);
    let tool = Tool::new(vertices, faces)?;
    let metric = Metric::new(&tool);
    let mut set = set_of(planes, points, metric);
    let options = SessionOptions::default();
    let mut servo = Servo::new(Coupling::default(), options.driven, &options.limits(1e-3), 1000.0, metric.centre)?;
    let (mut took, mut held) = (Vec::with_capacity(ticks), 0);
    for tick in 0..ticks {
        let t = tick as f64 * 1e-3;
        let place = [0.002 * (7.0 * t).sin(), 0.002 * (5.3 * t).cos(), -0.001 + 0.002 * (3.1 * t).sin()];
        let turn = [0.02 * (2.3 * t).sin(), 0.02 * (3.7 * t).cos(), 0.02 * (4.9 * t).sin()];
        let device = pose_of(&rotation_of(&turn), &place)?;
        set.time = t;
        let input = ServoInput { device, device_twist: None, now: t, dt: 1e-3, in_doubt: false };
        let before = thread_time();
        std::hint::black_box(servo.tick(std::hint::black_box(&set), &input));
        took.push(thread_time() - before);
        held += servo.held().len();
    }
    Ok((took, held as f64 / ticks as f64))
}

/// Planes evenly around the tool, their points on its sides.
fn set_of(planes: usize, points: usize, metric: Metric) -> ConstraintSet {
    let mut set = ConstraintSet::new(Pose::IDENTITY, metric, 2e-5, 0.002, [0.008, 0.15]);
    let golden = std::f64::consts::PI * (3.0 - 5.0f64.sqrt());
    for k in 0..planes {
        let z = 1.0 - 2.0 * (k as f64 + 0.5) / planes as f64;
        let (sin, cos) = (golden * k as f64).sin_cos();
        let r = (1.0 - z * z).sqrt();
        let normal = [r * cos, r * sin, z];
        let gap = 1e-4 + 1e-5 * k as f64;
        // Opposite to the normal, in a ring about it.
        let ring = (0..points).map(|i| {
            let (s, c) = (std::f64::consts::TAU * i as f64 / points as f64).sin_cos();
            let across = [-sin, cos, 0.0];
            let along = [-z * cos, -z * sin, r];
            let point = std::array::from_fn(|a| -0.04 * normal[a] + 0.015 * (c * across[a] + s * along[a]));
            (point, gap)
        });
        let plane = Plane { point: normal.map(|x| -0.04 * x), normal, gap, part: 0, id: k as u64 + 1 };
        set.push(plane, ring);
    }
    set
}
