//! The drivers of makers' libraries against stubs that are compiled here, with the makers' documented calls.

mod common;
#[path = "common/stubs.rs"]
mod stubs;

use std::path::PathBuf;

use common::eventually;
use feeler_core::geometry::twist::rotation_vector;
use feeler_devices::dhd::{Dhd, DhdOptions};
use feeler_devices::openhaptics::{OpenHaptics, OpenHapticsOptions};
use feeler_haptics::device::{Device, DeviceError};
use feeler_haptics::Wrench;
use stubs::{compiled, Stub};

/// A stub of an omega.6: type 34, a wrist without motors.
fn omega() -> Stub {
    let stub = Stub::new("stub_dhd");
    stub.set(12, 34.0);
    stub.set(13, 1.0);
    stub
}

/// A stub of a Touch, in the middle of its workspace, unturned.
fn touch() -> Stub {
    let stub = Stub::new("stub_hd");
    for diagonal in [0, 5, 10, 15] {
        stub.set(diagonal, 1.0);
    }
    stub.set(13, 20.0);
    stub
}

const PUSH: Wrench = Wrench { force: [1.0, 2.0, 3.0], torque: [0.1, 0.2, 0.3] };

/// Writes a force until the stub has received it: the watchdog drops a force that is written once.
fn push(device: &mut dyn Device, wrench: &Wrench, what: &str, mut has_it: impl FnMut() -> bool) {
    eventually(what, || {
        device.write(wrench, 0.0).unwrap();
        has_it().then_some(())
    });
}

#[test]
fn dhd_tells_poses_and_gives_forces_in_device_axes() {
    let stub = omega();
    for (cell, value) in [0.01, 0.02, 0.03, 0.1, 0.2, 0.3, 1.0, 2.0, 3.0, 5.0].into_iter().enumerate() {
        stub.set(cell as u32, value);
    }
    stub.set(14, 0.5);
    let mut device = stub.open_dhd().unwrap();
    assert_eq!(device.info().name, "Force Dimension omega.stub");
    assert!(device.info().sensed.rotation && !device.info().driven.rotation);
    let state = device.read(10.0).unwrap();
    // The library's x is towards the hand's owner, its y to the right.
    assert_eq!(*state.pose.translation(), [0.02, -0.01, 0.03]);
    let twist = state.twist.unwrap();
    assert_eq!((twist.linear, twist.angular), ([0.2, -0.1, 0.3], [2.0, -1.0, 3.0]));
    let turned = rotation_vector(state.pose.rotation());
    assert!(turned[0].abs() < 1e-12 && turned[1].abs() < 1e-12 && (turned[2] - 0.5).abs() < 1e-12, "{turned:?}");
    assert_eq!(state.buttons, 5);
    assert!(state.time <= 10.0 && state.time > 9.5);

    assert_eq!(stub.get(27), 1.0, "the motors are on");
    push(&mut device, &PUSH, "the force in the library's axes", || {
        stub.many(20) == [-2.0, 1.0, 3.0, 0.0, 0.0, 0.0, 0.0]
    });
    // The servo stops writing, so the thread sets the force to zero.
    eventually("the watchdog", || (stub.many(20) == [0.0; 6]).then_some(()));
    device.release();
    assert_eq!((stub.get(27), stub.get(28)), (0.0, 0.0), "the motors are off and the device is closed");
}

#[test]
fn dhd_drives_an_active_wrist() {
    let stub = Stub::new("stub_dhd");
    stub.set(12, 104.0);
    stub.set(13, 2.0);
    let mut device = stub.open_dhd().unwrap();
    assert!(device.info().driven.rotation);
    let device_torque = device.info().limits.torque_nm;
    let wrench = Wrench { torque: PUSH.torque.map(|x| 0.5 * x), ..PUSH };
    push(&mut device, &wrench, "the torque", || stub.many(20) == [-2.0, 1.0, 3.0, -0.1, 0.05, 0.15]);
    // Together no more than the device's limit.
    let strong = Wrench { torque: [0.0, 0.0, 1e6], ..PUSH };
    push(&mut device, &strong, "the largest torque", || stub.get(25) == device_torque);
}

#[test]
fn dhd_clips_forces_and_gives_none_where_a_number_is_not_finite() {
    let stub = omega();
    let mut device = stub.open_dhd().unwrap();
    let limit = device.info().limits.force_n;
    let strong = Wrench { force: [0.0, 0.0, -1e6], torque: [0.0; 3] };
    push(&mut device, &strong, "the largest force", || stub.get(22) == -limit);
    let broken = Wrench { force: [f64::NAN, 1.0, 1.0], torque: [0.0; 3] };
    push(&mut device, &broken, "no force", || stub.many(20) == [0.0; 3]);
    assert!(stub.get(30) <= limit);
}

#[test]
fn dhd_says_what_cannot_be_and_what_is_lost_and_goes_on() {
    let stub = omega();
    let mut device = stub.open_dhd().unwrap();
    type Case = (u32, f64, fn(&DeviceError) -> bool);
    let cases: [Case; 5] = [
        (0, f64::NAN, |error| matches!(error, DeviceError::Nonsense { .. })),
        (1, 1e9, |error| matches!(error, DeviceError::Nonsense { .. })),
        (4, f64::INFINITY, |error| matches!(error, DeviceError::Nonsense { .. })),
        (14, f64::NAN, |error| matches!(error, DeviceError::Nonsense { .. })),
        (11, 1.0, |error| matches!(error, DeviceError::Lost { why, .. } if why.contains("communication error"))),
    ];
    for (cell, value, is_expected) in cases {
        stub.set(cell, value);
        let error = eventually("an error", || device.read(0.0).err());
        assert!(is_expected(&error), "{error}");
        stub.set(cell, 0.0);
        eventually("a pose again", || device.read(0.0).ok());
    }
}

#[test]
fn dhd_lets_go_when_it_is_dropped() {
    let stub = omega();
    let mut device = stub.open_dhd().unwrap();
    push(&mut device, &PUSH, "a force", || stub.get(22) == 3.0);
    drop(device);
    assert_eq!(stub.many(20), [0.0; 3]);
    assert_eq!((stub.get(27), stub.get(28)), (0.0, 0.0));
}

#[test]
fn dhd_says_what_is_missing() {
    let nowhere = DhdOptions::default().with_library(PathBuf::from("/nowhere/libdhd.so"));
    let error = Dhd::open(&nowhere).err().unwrap();
    assert!(
        matches!(&error, DeviceError::NotFound { why, .. } if why.contains("/nowhere/libdhd.so") && why.contains("SDK")),
        "{error}"
    );

    let too_old = DhdOptions::default().with_library(compiled("stub_dhd", true));
    let error = Dhd::open(&too_old).err().unwrap();
    let words = ["dhdSetForceAndTorqueAndGripperForce", "stub_dhd_too_old"];
    assert!(
        matches!(&error, DeviceError::NotFound { why, .. } if words.iter().all(|word| why.contains(word))),
        "{error}"
    );

    let stub = omega();
    stub.set(10, 1.0);
    let error = stub.open_dhd().err().unwrap();
    assert!(matches!(&error, DeviceError::NotFound { why, .. } if why.contains("no device found")), "{error}");
    assert_eq!(stub.get(28), 0.0, "what was not opened is not closed");
}

#[test]
fn openhaptics_tells_poses_and_gives_forces_in_device_axes() {
    let stub = touch();
    // A quarter of a turn about the library's y, which is up: column by column, x goes to -z.
    for (cell, value) in
        [0.0, 0.0, -1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 10.0, 40.0, 30.0, 1.0].into_iter().enumerate()
    {
        stub.set(cell as u32, value);
    }
    for (cell, value) in [(16, 100.0), (17, 200.0), (18, 300.0), (19, 1.0), (20, 2.0), (21, 3.0), (22, 2.0)] {
        stub.set(cell, value);
    }
    let mut device = stub.open_hd().unwrap();
    let info = device.info().clone();
    assert_eq!(info.name, "3D Systems Stub Touch");
    assert_eq!((info.limits.force_n, info.limits.rate_hz, info.workspace), (3.3, 1000.0, [0.08, 0.035, 0.08]));
    assert!(info.sensed.rotation && !info.driven.rotation);
    let state = device.read(10.0).unwrap();
    // The middle of the workspace is at y = 20 mm; the library's z is towards the hand's owner.
    let expected = [0.01, -0.03, 0.02];
    assert!((0..3).all(|i| (state.pose.translation()[i] - expected[i]).abs() < 1e-12), "{state:?}");
    let turned = rotation_vector(state.pose.rotation());
    assert!(
        turned[0].abs() < 1e-12 && turned[1].abs() < 1e-12 && (turned[2] - std::f64::consts::FRAC_PI_2).abs() < 1e-12,
        "{turned:?}"
    );
    let twist = state.twist.unwrap();
    let linear = [0.1, -0.3, 0.2];
    assert!((0..3).all(|i| (twist.linear[i] - linear[i]).abs() < 1e-12), "{twist:?}");
    assert_eq!((twist.angular, state.buttons), ([1.0, -3.0, 2.0], 2));

    let push_wrench = Wrench { force: [0.5, 1.0, 2.0], torque: [1.0; 3] };
    push(&mut device, &push_wrench, "the force in the library's axes", || stub.many(40) == [0.5, 2.0, -1.0]);
    eventually("the watchdog", || (stub.many(40) == [0.0; 3]).then_some(()));
    push(&mut device, &push_wrench, "the force again", || stub.get(41) == 2.0);
    device.release();
    assert_eq!(stub.many(40), [0.0; 3]);
    drop(device);
    assert_eq!(
        (stub.get(43), stub.get(44), stub.get(47)),
        (0.0, 0.0, 0.0),
        "output off, device disabled, scheduler stopped"
    );
    assert_eq!(stub.get(48), 0.0, "nothing was set outside a frame");
}

#[test]
fn openhaptics_clips_forces_and_gives_none_where_a_number_is_not_finite() {
    let stub = touch();
    let mut device = stub.open_hd().unwrap();
    let strong = Wrench { force: [0.0, 0.0, 1e200], torque: [0.0; 3] };
    push(&mut device, &strong, "the largest force", || stub.get(41) == 3.3);
    let broken = Wrench { force: [1.0; 3], torque: [f64::INFINITY; 3] };
    push(&mut device, &broken, "no force", || stub.many(40) == [0.0; 3]);
    assert!(stub.get(46) <= 3.3);
}

#[test]
fn openhaptics_says_what_cannot_be_and_what_is_lost_and_goes_on() {
    let stub = touch();
    let mut device = stub.open_hd().unwrap();
    type Case = (u32, f64, f64, fn(&DeviceError) -> bool);
    let cases: [Case; 4] = [
        (12, f64::NAN, 0.0, |error| matches!(error, DeviceError::Nonsense { .. })),
        (0, -1.0, 1.0, |error| matches!(error, DeviceError::Nonsense { .. })),
        (17, 1e12, 0.0, |error| matches!(error, DeviceError::Nonsense { .. })),
        (
            24,
            768.0,
            0.0,
            |error| matches!(error, DeviceError::Lost { why, .. } if why.contains("Device fault") && why.contains("0x0300")),
        ),
    ];
    for (cell, bad, good, is_expected) in cases {
        stub.set(cell, bad);
        let error = eventually("an error", || device.read(0.0).err());
        assert!(is_expected(&error), "{error}");
        stub.set(cell, good);
        eventually("a pose again", || device.read(0.0).ok());
    }
}

#[test]
fn openhaptics_lets_go_when_it_is_dropped() {
    let stub = touch();
    let mut device = stub.open_hd().unwrap();
    push(&mut device, &Wrench { force: [0.0, 0.0, 1.0], torque: [0.0; 3] }, "a force", || stub.get(41) == 1.0);
    drop(device);
    assert_eq!(stub.many(40), [0.0; 3]);
    assert_eq!((stub.get(43), stub.get(44), stub.get(47)), (0.0, 0.0, 0.0));
}

#[test]
fn openhaptics_calibrates_or_says_who_has_to() {
    let stub = touch();
    stub.set(25, 1.0);
    let mut device = eventually("a calibrated device", || stub.open_hd().ok());
    assert!(device.read(0.0).is_ok() && stub.get(25) == 0.0);
    drop(device);

    let stub = touch();
    stub.set(25, 2.0);
    let error = stub.open_hd().err().unwrap();
    assert!(matches!(&error, DeviceError::Nonsense { what, .. } if what.contains("inkwell")), "{error}");
    assert_eq!((stub.get(44), stub.get(47)), (0.0, 0.0), "nothing is left open");
}

#[test]
fn openhaptics_that_tells_nothing_of_itself_gets_the_smallest_limits() {
    let stub = touch();
    stub.set(26, 1.0);
    let device = stub.open_hd().unwrap();
    assert_eq!(device.info().name, "3D Systems device");
    assert_eq!((device.info().limits.force_n, device.info().workspace), (3.3, [0.08, 0.035, 0.06]));
}

#[test]
fn openhaptics_says_what_is_missing() {
    let nowhere = OpenHapticsOptions::default().with_library(PathBuf::from("/nowhere/libHD.so"));
    let error = OpenHaptics::open(&nowhere).err().unwrap();
    assert!(
        matches!(&error, DeviceError::NotFound { why, .. } if why.contains("/nowhere/libHD.so") && why.contains("install")),
        "{error}"
    );

    let too_old = OpenHapticsOptions::default().with_library(compiled("stub_hd", true));
    let error = OpenHaptics::open(&too_old).err().unwrap();
    assert!(matches!(&error, DeviceError::NotFound { why, .. } if why.contains("hdStopScheduler")), "{error}");

    let stub = touch();
    stub.set(23, 1.0);
    let error = stub.open_hd().err().unwrap();
    assert!(matches!(&error, DeviceError::NotFound { why, .. } if why.contains("Communication error")), "{error}");
    assert_eq!(stub.get(44), 0.0, "what was not initialised is not disabled");

    let named = OpenHapticsOptions::default().with_library(stub.path.clone()).with_device("a\0b".to_string());
    assert!(matches!(OpenHaptics::open(&named), Err(DeviceError::NotFound { .. })));
}
