//! Every driver and every type of device pressed into a plate, against the stand-ins: the device receives the force of
//! the granted spring, or the largest granted one.

mod common;
#[path = "common/stubs.rs"]
mod stubs;

/// The stand-in of the Inverse Service, whose messages other tests judge.
mod haply_scenarios {
    #[allow(dead_code, reason = "other tests use the rest")]
    #[path = "../haply_scenarios/service.rs"]
    pub mod service;
}

mod judge {
    use serde_json::Value;

    pub fn fault_of_command(_message: &Value) -> Option<String> {
        None
    }

    pub fn fault_of_state(_state: &Value) -> Option<String> {
        None
    }
}

use std::sync::Arc;

use common::eventually;
use feeler_core::{Mockup, Point, Pose, Scene, SceneOptions, Tool};
use feeler_devices::dhd::{Dhd, DhdOptions};
use feeler_devices::haply::Haply;
use feeler_devices::machine::MonotonicClock;
use feeler_devices::openhaptics::{OpenHaptics, OpenHapticsOptions};
use feeler_haptics::device::{Device, DeviceError};
use feeler_haptics::{Coupling, MappingOptions, Runner, RunnerOptions, Session, SessionOptions};
use feeler_shapes::{box_mesh, Arrays};
use haply_scenarios::service::{inverse3, with_grip, Service};
use serde_json::json;
use stubs::Stub;

/// How deep the handle is pressed beyond the contact, and the tool's height above the plate before, in the world, metres.
const DEPTH: f64 = 0.012;
const GAP: f64 = 0.001;
/// How the handle is turned about the device's x while it presses, radians: less than tips the block over.
const TURN: f64 = 0.05;

fn scene((vertices, faces): Arrays) -> Arc<Scene> {
    let mockup = Mockup::new(vertices, faces, vec![], 1).unwrap();
    Arc::new(Scene::build(Arc::new(mockup), &SceneOptions::default()).unwrap())
}

/// A block, its centre at its origin, started above a plate whose upper side is z = 0.
fn session(coupling: Coupling) -> Session {
    let (vertices, faces) = box_mesh([0.0; 3], [0.06, 0.08, 0.05], 2);
    let block = Arc::new(Tool::new(vertices, faces).unwrap());
    let plate = scene(box_mesh([0.0, 0.0, -0.01], [0.4, 0.4, 0.02], 4));
    let mut session = Session::new(plate, block, SessionOptions::default().with_coupling(coupling)).unwrap();
    session.start(&Pose::IDENTITY.translated(&[0.0, 0.0, 0.025 + GAP]).unwrap()).unwrap();
    session
}

fn is_near(found: f64, expected: f64) -> bool {
    (found - expected).abs() <= 0.02 * expected.abs() + 1e-9
}

/// A stand-in: where its handle is (device axes, metres), how it is turned about x, and the wrench that it was given (device axes).
struct StandIn<'a> {
    put: &'a dyn Fn(f64, f64),
    given: &'a dyn Fn() -> (Point, Point),
}

/// Presses a device's handle, and waits until the stand-in has received the granted force and torque. Where a busy machine keeps a
/// stand-in from sending poses, the device is lost, as it should be: it is opened again.
fn press(what: &str, open: impl Fn() -> Box<dyn Device>, coupling: Coupling, scale: f64, stand_in: &StandIn) {
    let lost = (0..4).map_while(|_| press_once(what, &open, coupling, scale, stand_in).err()).collect::<Vec<_>>();
    assert!(lost.len() < 4, "{what}: {lost:?}");
}

/// An error if the device was lost.
fn press_once(
    what: &str,
    open: impl Fn() -> Box<dyn Device>,
    coupling: Coupling,
    scale: f64,
    stand_in: &StandIn,
) -> Result<(), DeviceError> {
    (stand_in.put)(0.0, 0.0);
    let device = open();
    let info = device.info().clone();
    let options = RunnerOptions::default().with_mapping(MappingOptions::default().with_scale(scale));
    let clock = Arc::new(MonotonicClock::new());
    let mut runner = Runner::run(session(coupling), device, clock, &options).map_err(|refused| refused.error).unwrap();
    let granted = *runner.coupling();
    assert!(granted.stiffness_n_per_m > 80.0 && granted.max_force_n > 0.4, "{what}: {granted:?}");
    eventually("the first ticks", || (runner.watch().view().number > 20).then_some(()));
    assert_eq!((stand_in.given)(), ([0.0; 3], [0.0; 3]), "{what}: a force in the air");

    // With less force than its spring has, the block would tip over with the handle.
    let tips = granted.max_force_n < granted.stiffness_n_per_m * DEPTH && granted.max_force_n < 1.0;
    let turn = if info.driven.rotation && !tips { TURN } else { 0.0 };
    (stand_in.put)(-(DEPTH + GAP) / scale, turn);
    let force = (granted.stiffness_n_per_m * DEPTH).min(granted.max_force_n);
    // The torque on the hand is divided by the scale, as arms are in the hand's world.
    let torque = -(granted.rotational_stiffness_nm_per_rad * turn).min(granted.max_torque_nm) / scale;
    let started = std::time::Instant::now();
    let last = loop {
        let last = (stand_in.given)();
        let (f, t) = last;
        let is_felt = is_near(f[2], force) && f[0].abs() + f[1].abs() < 0.01 * force && is_near(t[0], torque);
        if is_felt || !runner.is_running() {
            break last;
        }
        let view = runner.watch().view();
        assert!(
            started.elapsed().as_secs() < 30,
            "{what}: {last:?} instead of {force} N and {torque} Nm, {view:?}, {granted:?}"
        );
        std::thread::sleep(std::time::Duration::from_millis(2));
    };
    if turn > 0.0 {
        assert!(torque < -1e-3, "{what}: {torque}");
    }
    assert!(last.0[2] <= info.limits.force_n * (1.0 + 1e-9), "{what}");
    let stopped = runner.stop();
    if let Some(lost @ DeviceError::Lost { .. }) = stopped.device_error {
        return Err(lost);
    }
    assert_eq!((stopped.device_error, stopped.error), (None, None), "{what}");
    Ok(())
}

/// The couplings of a device: its default, one that asks for more than it can do, and one with less force than the spring has.
fn couplings(device: &dyn Device) -> [(&'static str, Coupling); 3] {
    let own = Coupling::for_device(device.info());
    let stiff = own.with_stiffness_n_per_m(2000.0).with_max_force_n(50.0);
    let weak = own.with_max_force_n(0.5).with_slew_n_per_s(200.0);
    [("its own", own), ("stiff", stiff), ("weak", weak)]
}

/// All couplings, and its own with motions scaled, each with a device that was just opened.
fn press_all(what: &str, open: impl Fn() -> Box<dyn Device>, stand_in: &StandIn) {
    let known = couplings(&*open());
    for (which, coupling) in known {
        press(&format!("{what}, {which}"), &open, coupling, 1.0, stand_in);
    }
    press(&format!("{what}, scaled"), &open, known[0].1, 2.0, stand_in);
}

#[test]
fn every_device_of_force_dimension_gives_what_is_granted() {
    // Type, wrist (2: with motors).
    let types = [
        (33, 0),  // omega.3
        (34, 1),  // omega.6
        (36, 1),  // omega.7
        (60, 0),  // Novint Falcon
        (63, 0),  // delta.3
        (64, 2),  // delta.6
        (104, 2), // sigma.7
        (106, 0), // sigma.3
        (206, 2), // sigma.7+
        (108, 2), // lambda.7
        (203, 0), // lambda.3
        (999, 2), // unknown
    ];
    for (kind, wrist) in types {
        let stub = Stub::new("stub_dhd");
        stub.set(12, f64::from(kind));
        stub.set(13, f64::from(wrist));
        let open = || -> Box<dyn Device> {
            Box::new(Dhd::open(&DhdOptions::default().with_library(stub.path.clone())).unwrap())
        };
        let put = |z: f64, turn: f64| {
            stub.set(15, turn);
            stub.set(2, z);
        };
        // The library's x is towards the hand's owner, its y to the right.
        let axes = |v: [f64; 3]| [v[1], -v[0] + 0.0, v[2]];
        let given = || (axes(stub.many(20)), axes(stub.many(23)));
        press_all(&format!("type {kind}"), open, &StandIn { put: &put, given: &given });
    }
}

#[test]
fn every_device_of_3d_systems_gives_what_is_granted() {
    for (model, is_mute) in [(0, false), (1, false), (2, false), (3, false), (4, false), (0, true)] {
        let stub = Stub::new("stub_hd");
        for diagonal in [0, 5, 10, 15] {
            stub.set(diagonal, 1.0);
        }
        stub.set(26, f64::from(u8::from(is_mute)));
        stub.set(27, f64::from(model));
        let middle = if is_mute { 0.0 } else { 20.0 };
        let open = || -> Box<dyn Device> {
            let options = OpenHapticsOptions::default().with_library(stub.path.clone());
            Box::new(OpenHaptics::open(&options).unwrap())
        };
        let put = |z: f64, _: f64| stub.set(13, middle + 1e3 * z);
        // The library's y is up, its z towards the hand's owner.
        let given = || {
            let [x, y, z] = stub.many(40);
            ([x, -z + 0.0, y], [0.0; 3])
        };
        press_all(&format!("model {model}, mute: {is_mute}"), open, &StandIn { put: &put, given: &given });
    }
}

#[test]
fn every_device_of_haply_gives_what_is_granted() {
    let mut minverse = inverse3();
    minverse["inverse3"][0]["config"]["device_info"]["device_type"] = json!("minverse");
    for (what, mut data, force_n, stiffness_n_per_m) in [
        ("Inverse3", inverse3(), None, None),
        ("Inverse3 with a VerseGrip", with_grip(), None, None),
        ("Minverse", minverse, None, None),
        ("Inverse3 at its peak, as stiff as its user says", inverse3(), Some(10.0), Some(750.0)),
    ] {
        data["inverse3"][0]["state"]["cursor_velocity"] = json!({"x": 0.0, "y": 0.0, "z": 0.0});
        let service = Service::start(data);
        let open = || -> Box<dyn Device> {
            Box::new(
                Haply::open(&service.options().with_force_n(force_n).with_stiffness_n_per_m(stiffness_n_per_m))
                    .unwrap(),
            )
        };
        let put = |z: f64, _: f64| service.move_to([0.0, 0.0, z]);
        let given = || (service.last_force().unwrap_or([0.0; 3]), [0.0; 3]);
        press_all(what, open, &StandIn { put: &put, given: &given });
    }
}
