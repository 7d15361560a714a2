//! The driver with an Inverse Service, and with one that fails. Run with two judges of the messages: the plain one of
//! this crate's tests, and the types of the maker's crate, in `tools/haply_judge`.

mod service;

use std::net::TcpListener;

use super::common::eventually;
use feeler_core::geometry::twist::rotation_vector;
use feeler_devices::haply::{Haply, HaplyOptions};
use feeler_haptics::device::{Device, DeviceError};
use feeler_haptics::Wrench;
use serde_json::json;
use service::{inverse3, with_grip, Mood, Service};

fn force(x: f64, y: f64, z: f64) -> Wrench {
    Wrench { force: [x, y, z], torque: [0.0; 3] }
}

/// Writes a force until the service has received it: the watchdog drops a force that is written once.
fn push(device: &mut Haply, service: &Service, wrench: &Wrench, expected: [f64; 3]) {
    eventually("the service has the force", || {
        device.write(wrench, 0.0).unwrap();
        (service.last_force() == Some(expected)).then_some(())
    });
}

fn near(a: &[f64; 3], b: [f64; 3]) -> bool {
    (0..3).all(|i| (a[i] - b[i]).abs() < 1e-6)
}

#[test]
fn poses_come_in_and_forces_go_out() {
    let service = Service::start(with_grip());
    let mut device = service.open();
    let (profile, preset) = {
        let shared = service.shared();
        (shared.profile.clone(), shared.preset.clone())
    };
    assert_eq!((profile.as_deref(), preset.as_deref()), (Some("feeler"), Some("arm_front_centered")));
    let info = device.info().clone();
    assert_eq!(info.name, "Haply Inverse3 04C3");
    assert!(info.driven.translation && !info.driven.rotation && info.sensed.rotation);
    // Not where the arm was before the preset was taken.
    let state = device.read(10.0).unwrap();
    assert!(near(state.pose.translation(), [0.01, 0.02, 0.03]), "{state:?}");
    assert!(near(&rotation_vector(state.pose.rotation()), [0.0, 0.0, 0.5]), "{state:?}");
    assert_eq!((state.buttons, state.twist), (0b101, None));
    assert!(state.time <= 10.0 && state.time > 9.0);

    service.move_to([-0.05, 0.0, 0.0]);
    eventually("the arm moves", || {
        near(device.read(11.0).unwrap().pose.translation(), [-0.05, 0.0, 0.0]).then_some(())
    });

    push(&mut device, &service, &force(1.0, -2.0, 0.5), [1.0, -2.0, 0.5]);
    // The servo stops writing, so the thread sets the force to zero.
    eventually("the watchdog", || (service.last_force() == Some([0.0; 3])).then_some(()));
    push(&mut device, &service, &force(1.0, -2.0, 0.5), [1.0, -2.0, 0.5]);
    device.release();
    eventually("the goodbye", || service.shared().has_said_goodbye.then_some(()));
    assert_eq!(service.last_force(), Some([0.0; 3]));
    assert!(matches!(device.read(12.0), Err(DeviceError::Lost { .. })));
    service.check();
}

#[test]
fn forces_are_clipped_and_none_where_a_number_is_not_finite() {
    let service = Service::start(inverse3());
    let mut device = Haply::open(&service.options().with_force_n(2.0)).unwrap();
    push(&mut device, &service, &force(0.0, 1e9, 0.0), [0.0, 2.0, 0.0]);
    push(&mut device, &service, &force(f64::NAN, 1.0, 1.0), [0.0; 3]);
    push(&mut device, &service, &force(0.0, -1.0, 0.0), [0.0, -1.0, 0.0]);
    push(&mut device, &service, &force(0.0, f64::INFINITY, 0.0), [0.0; 3]);
    let strongest = service.shared().forces.iter().flatten().fold(0.0f64, |most, x| most.max(x.abs()));
    assert_eq!(strongest, 2.0);
    service.check();

    let service = Service::start(inverse3());
    let device = Haply::open(&service.options().with_force_n(1e3)).unwrap();
    assert_eq!(device.info().limits.force_n, 10.0, "never more than the maker's peak");
}

#[test]
fn without_a_grip_rotation_is_not_sensed() {
    let service = Service::start(inverse3());
    let mut device = service.open();
    assert!(!device.info().sensed.rotation && device.info().buttons == 0);
    let twist = device.read(0.0).unwrap().twist.unwrap();
    assert!(near(&twist.linear, [0.1, 0.2, 0.3]) && twist.angular == [0.0; 3], "{twist:?}");
    // A grip that connects later changes nothing: the sensed freedoms were stated when the device was opened.
    service.shared().data = with_grip();
    service.move_to([0.04, 0.0, 0.0]);
    let state = eventually("the newer state", || {
        device.read(1.0).ok().filter(|state| near(state.pose.translation(), [0.04, 0.0, 0.0]))
    });
    assert!(near(&rotation_vector(state.pose.rotation()), [0.0; 3]), "{state:?}");
}

#[test]
fn a_grip_that_falls_silent_keeps_its_rotation() {
    let service = Service::start(with_grip());
    let mut device = service.open();
    service.shared().data["wireless_verse_grip"] = json!([]);
    service.move_to([0.04, 0.0, 0.0]);
    let state = eventually("the newer state", || {
        device.read(1.0).ok().filter(|state| near(state.pose.translation(), [0.04, 0.0, 0.0]))
    });
    assert!(near(&rotation_vector(state.pose.rotation()), [0.0, 0.0, 0.5]), "{state:?}");
}

#[test]
fn a_service_that_does_not_confirm_the_preset_is_believed_in_the_end() {
    let service = Service::start(inverse3());
    service.shared().tells_preset = false;
    let mut device = service.open();
    assert!(device.read(0.0).is_ok());
    service.check();
}

#[test]
fn a_service_that_stops_telling_is_lost_and_comes_back() {
    let service = Service::start(inverse3());
    let mut device = service.open();
    push(&mut device, &service, &force(1.0, 0.0, 0.0), [1.0, 0.0, 0.0]);
    service.shared().mood = Mood::Silent;
    let error = eventually("the loss", || device.read(0.0).err());
    assert!(matches!(error, DeviceError::Lost { .. }), "{error}");
    // Forces are still sent, so that the service learns when the force ends.
    eventually("no force", || (service.last_force() == Some([0.0; 3])).then_some(()));
    service.shared().mood = Mood::Good;
    eventually("a pose again", || device.read(0.0).ok());
    service.check();
}

/// Forces that are sent ahead wait at the service, and act when they are old.
#[test]
fn no_force_is_sent_ahead_of_a_slow_services_answers() {
    let service = Service::start(inverse3());
    let mut device = service.open();
    service.shared().mood = Mood::Slow;
    eventually("40 slow answers", || {
        device.write(&force(1.0, 0.0, 0.0), 0.0).unwrap();
        (service.shared().slow >= 40).then_some(())
    });
    // On a busy machine a thread may be late; one that sends ahead has dozens for each answer.
    assert!(service.shared().early < 20, "{} forces waited", service.shared().early);
    assert_eq!(service.last_force(), Some([1.0, 0.0, 0.0]));
    service.check();
}

#[test]
fn nonsense_is_told_until_there_is_a_good_state_again() {
    let service = Service::start(with_grip());
    let mut device = service.open();
    let position = |x: &str| {
        format!(r#"{{"inverse3":[{{"device_id":"04C3","state":{{"cursor_position":{{"x":{x},"y":0,"z":0}}}}}}]}}"#)
    };
    let turned = |w: &str| {
        let grip = format!(r#"{{"device_id":"1102","state":{{"orientation":{{"w":{w},"x":0,"y":0,"z":0}}}}}}"#);
        position("0").replace(r#"{"inverse3""#, &format!(r#"{{"wireless_verse_grip":[{grip}],"inverse3""#))
    };
    let says = [
        position("NaN"),
        position("null"),
        position("1e999"),
        position("1e30"),
        position("-11"),
        position("\"0\""),
        turned("0"),
        turned("2"),
        turned("1e38"),
        position("0").replace("\"z\":0", "\"w\":0"),
        position("0").replace("\"state\"", "\"status\":{\"calibrated\":false},\"state\""),
        "garbage".to_string(),
        "[".repeat(100_000),
        r#"{"inverse3":7}"#.to_string(),
        String::new(),
    ];
    let moods = says.into_iter().map(Mood::Says).chain([Mood::Bytes]);
    for mood in moods {
        let what = if let Mood::Says(text) = &mood { text.chars().take(200).collect() } else { "bytes".to_string() };
        service.shared().mood = mood;
        let error = eventually(&what, || device.read(0.0).err());
        assert!(matches!(error, DeviceError::Nonsense { .. }), "{what}: {error}");
        service.shared().mood = Mood::Good;
        eventually(&format!("a pose again after {what}"), || device.read(0.0).ok());
    }
    service.check();
}

#[test]
fn a_state_without_the_device_is_no_news() {
    let service = Service::start(inverse3());
    let mut device = service.open();
    service.shared().mood = Mood::Says("{}".to_string());
    // The last pose becomes too old.
    let error = eventually("the loss", || device.read(0.0).err());
    assert!(matches!(error, DeviceError::Lost { .. }), "{error}");
}

#[test]
fn a_huge_message_is_not_read() {
    let service = Service::start(inverse3());
    let mut device = service.open();
    service.shared().mood = Mood::Says(" ".repeat(2 << 20));
    let error = eventually("an error", || device.read(0.0).err());
    assert!(!matches!(error, DeviceError::NotFound { .. }), "{error}");
    // The start of the next message cannot be found after this one: the device must be opened again.
    service.shared().mood = Mood::Good;
    device.release();
    eventually("a new connection", || Haply::open(&service.options()).ok());
}

#[test]
fn a_service_that_closes_is_lost_for_good() {
    let service = Service::start(inverse3());
    let mut device = service.open();
    service.shared().mood = Mood::Closes;
    let error = eventually("the loss", || device.read(0.0).err().filter(|error| error.to_string().contains("closed")));
    assert!(matches!(error, DeviceError::Lost { .. }), "{error}");
}

#[test]
fn dropping_the_device_lets_go_of_the_force() {
    let service = Service::start(inverse3());
    let mut device = service.open();
    push(&mut device, &service, &force(0.0, 0.0, 1.0), [0.0, 0.0, 1.0]);
    drop(device);
    eventually("the goodbye", || service.shared().has_said_goodbye.then_some(()));
    assert_eq!(service.last_force(), Some([0.0; 3]));
}

#[test]
fn what_is_not_there_is_said_with_what_to_do() {
    let nobody = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().to_string();
    let options = |address: &str| HaplyOptions::default().with_address(address.to_string());
    for address in [nobody.as_str(), "localhost", "", "no-such-host.invalid:1"] {
        let error = Haply::open(&options(address)).err().unwrap();
        assert!(
            matches!(&error, DeviceError::NotFound { why, .. } if why.contains("Inverse Service")),
            "{address}: {error}"
        );
    }

    // Another program listens there: one that sends something else, and one that sends nothing.
    for says in [&b"HTTP/1.1 404 Not Found\r\nContent-Length: 0\r\n\r\n"[..], b""] {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = listener.local_addr().unwrap().to_string();
        std::thread::spawn(move || {
            let (mut stream, _) = listener.accept().unwrap();
            std::io::Write::write_all(&mut stream, says).unwrap();
            // Held open until the client is gone.
            let _ = std::io::Read::read_to_end(&mut stream, &mut vec![]);
        });
        let error = Haply::open(&options(&address)).err().unwrap();
        assert!(matches!(error, DeviceError::NotFound { .. }), "{error}");
    }

    let service = Service::start(json!({}));
    let error = Haply::open(&service.options()).err().unwrap();
    assert!(matches!(&error, DeviceError::NotFound { why, .. } if why.contains("no Inverse3")), "{error}");
    let service = Service::start(inverse3());
    let error = Haply::open(&service.options().with_device_id("FFFF".to_string())).err().unwrap();
    assert!(
        matches!(&error, DeviceError::NotFound { why, .. } if why.contains("FFFF") && why.contains("04C3")),
        "{error}"
    );
}
