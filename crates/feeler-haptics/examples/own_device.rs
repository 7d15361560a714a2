//! Your own device, pressed into a plate in simulated time: a handle on a rail that reports its height and takes a
//! force.
//!
//! `cargo run -p feeler-haptics --example own_device`

use std::error::Error;
use std::sync::{Arc, Mutex};

use feeler_core::{Mockup, Pose, Scene, SceneOptions, Tool};
use feeler_haptics::device::{Device, DeviceError, DeviceInfo, DeviceLimits, DeviceState, Freedoms};
use feeler_haptics::{Coupling, RunnerOptions, Session, SessionOptions, Sides, Wrench};

/// Here a program moves the handle, and looks at the force; yours asks a motor controller.
#[derive(Default)]
struct Hardware {
    height_m: f64,
    force_n: f64,
}

struct Rail {
    info: DeviceInfo,
    hardware: Arc<Mutex<Hardware>>,
}

impl Device for Rail {
    fn info(&self) -> &DeviceInfo {
        &self.info
    }

    fn read(&mut self, now: f64) -> Result<DeviceState, DeviceError> {
        let lost = |_| DeviceError::Lost { device: self.info.name.clone(), why: "its lock is poisoned".into() };
        let height = self.hardware.lock().map_err(lost)?.height_m;
        let beyond =
            |_| DeviceError::Nonsense { device: self.info.name.clone(), what: format!("a height of {height} m") };
        let pose = Pose::IDENTITY.translated(&[0.0, 0.0, height]).map_err(beyond)?;
        Ok(DeviceState::new(pose, now).with_buttons(0))
    }

    fn write(&mut self, wrench: &Wrench, _now: f64) -> Result<(), DeviceError> {
        if let Ok(mut hardware) = self.hardware.lock() {
            hardware.force_n = wrench.force[2];
        }
        Ok(())
    }

    fn release(&mut self) {
        let _ = self.write(&Wrench::ZERO, 0.0);
    }
}

/// A box without a lid would do; this one has all its sides.
fn cuboid(low: [f64; 3], high: [f64; 3]) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let corner = |i: usize| std::array::from_fn(|a| if i >> a & 1 == 1 { high[a] } else { low[a] });
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let faces = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    ((0..8).map(corner).collect(), faces)
}

fn pressed() -> Result<f64, Box<dyn Error>> {
    let (vertices, faces) = cuboid([-0.2, -0.2, -0.02], [0.2, 0.2, 0.0]);
    let plate = Arc::new(Mockup::new(vertices, faces, vec![], 1)?);
    let scene = Arc::new(Scene::build(plate, &SceneOptions::default())?);
    let (vertices, faces) = cuboid([-0.03; 3], [0.03; 3]);
    let tool = Arc::new(Tool::new(vertices, faces)?);

    // What is not known stays 0, and bounds nothing.
    let limits = DeviceLimits::default().with_force_n(10.0).with_stiffness_n_per_m(500.0).with_rate_hz(1000.0);
    let up = Freedoms { translation: true, rotation: false };
    let info = DeviceInfo::new("rail").with_sensed(up).with_driven(up).with_workspace([0.1; 3]).with_limits(limits);
    let hardware = Arc::new(Mutex::new(Hardware::default()));
    let coupling = Coupling::for_device(&info);
    let mut session = Session::new(scene, tool, SessionOptions::default().with_coupling(coupling))?;
    session.start(&Pose::IDENTITY.translated(&[0.0, 0.0, 0.031])?)?;

    // `Runner::run` does the same in two threads, in real time.
    let rail = Rail { info, hardware: hardware.clone() };
    let mut sides = Sides::new(session, Box::new(rail), &RunnerOptions::default()).map_err(|refused| refused.error)?;
    for tick in 0..1000 {
        // Down to 12 mm below the contact, in half a second.
        hardware.lock().map_err(|_| "the lock is poisoned")?.height_m = (-26e-6 * f64::from(tick)).max(-0.013);
        let now = 1e-3 * f64::from(tick);
        sides.collision.tick(now);
        sides.servo.tick(now);
    }
    let force = hardware.lock().map_err(|_| "the lock is poisoned")?.force_n;
    Ok(force)
}

/// Presses it, and prints the forces.
pub fn main() {
    let force = pressed().expect("the rail is pressed into the plate");
    println!("12 mm into the plate at 500 N/m: {force:.2} N");
    assert!((force - 6.0).abs() < 0.12, "{force}");
}
