//! The SpaceMouse against a daemon that is old, broken or silent; the real one is in `spacenavd.rs`.
#![cfg(unix)]

mod common;

use std::io::{Read, Write};
use std::os::unix::net::{UnixListener, UnixStream};

use common::{eventually, Folder};
use feeler_devices::spacemouse::{SpaceMouse, SpaceMouseOptions};
use feeler_haptics::device::{Device, DeviceError};

struct Daemon {
    folder: Folder,
    listener: UnixListener,
}

impl Daemon {
    fn new() -> Daemon {
        let folder = Folder::new("spnav");
        let listener = UnixListener::bind(folder.path.join("spnav.sock")).unwrap();
        Daemon { folder, listener }
    }

    fn options(&self) -> SpaceMouseOptions {
        SpaceMouseOptions::default().with_socket(self.folder.path.join("spnav.sock")).with_dead_zone(0.0)
    }

    fn accept(&self) -> UnixStream {
        self.listener.accept().unwrap().0
    }
}

fn event(numbers: [i32; 8]) -> Vec<u8> {
    numbers.iter().flat_map(|x| x.to_ne_bytes()).collect()
}

fn speed(mouse: &mut SpaceMouse) -> f64 {
    mouse.read(0.0).unwrap().twist.unwrap().linear[0]
}

#[test]
fn an_old_daemon_gets_its_sensitivity_back() {
    let daemon = Daemon::new();
    let mut mouse = SpaceMouse::open(&daemon.options()).unwrap();
    let mut stream = daemon.accept();
    let mut said = [0; 8];
    stream.read_exact(&mut said).unwrap();
    // A daemon of protocol 0 reads this as a sensitivity that is not a number; then the sensitivity 1.
    assert_eq!(
        (u32::from_ne_bytes(said[..4].try_into().unwrap()), said[4..].to_vec()),
        (0x7faa_5501, 1f32.to_ne_bytes().to_vec())
    );
    assert!(mouse.info().name.contains("protocol 0") && mouse.info().buttons == 32, "{:?}", mouse.info());
    stream.write_all(&event([0, 350, 0, 0, 0, 0, 0, 10])).unwrap();
    eventually("moving", || (speed(&mut mouse) == 0.1).then_some(()));
}

#[test]
fn a_motion_ends_after_a_long_silence_and_with_its_device() {
    let daemon = Daemon::new();
    let mut mouse = SpaceMouse::open(&daemon.options().with_silence_s(0.3)).unwrap();
    let mut stream = daemon.accept();
    for ending in [None, Some(event([3, 1, 0, 0, 0, 0, 0, 0])), Some(event([0; 8]))] {
        stream.write_all(&event([0, 350, 0, 0, 0, 0, 0, 10])).unwrap();
        eventually("moving", || (speed(&mut mouse) == 0.1).then_some(()));
        if let Some(ending) = ending {
            stream.write_all(&ending).unwrap();
        }
        eventually("rest", || (speed(&mut mouse) == 0.0).then_some(()));
    }
    // A motion without an end event lasts as long as silence is allowed.
    let mut mouse = SpaceMouse::open(&daemon.options().with_silence_s(f64::INFINITY)).unwrap();
    let mut stream = daemon.accept();
    stream.write_all(&event([0, 350, 0, 0, 0, 0, 0, 10])).unwrap();
    eventually("moving", || (speed(&mut mouse) == 0.1).then_some(()));
    stream.write_all(&event([3, 1, 0, 0, 0, 0, 0, 0])).unwrap();
    eventually("rest", || (speed(&mut mouse) == 0.0).then_some(()));
}

#[test]
fn buttons_that_do_not_fit_are_left_out() {
    let daemon = Daemon::new();
    let mut mouse = SpaceMouse::open(&daemon.options()).unwrap();
    let mut stream = daemon.accept();
    for number in [-1, 32, i32::MAX, i32::MIN, 31] {
        stream.write_all(&event([1, number, 0, 0, 0, 0, 0, 0])).unwrap();
    }
    eventually("the last button", || (mouse.read(0.0).unwrap().buttons == 1 << 31).then_some(()));
}

#[test]
fn nonsense_is_told_and_the_daemon_is_tried_again() {
    let daemon = Daemon::new();
    let mut mouse = SpaceMouse::open(&daemon.options()).unwrap();
    for nonsense in [event([-7; 8]), event([0, i32::MIN, 0, 0, 0, 0, 0, 0]), vec![0xff; 4096]] {
        let mut stream = daemon.accept();
        stream.write_all(&event([0, 350, 0, 0, 0, 0, 0, 10])).unwrap();
        eventually("moving", || mouse.read(0.0).ok().filter(|state| state.twist.unwrap().linear[0] == 0.1));
        stream.write_all(&nonsense).unwrap();
        let error = eventually("nonsense", || mouse.read(0.0).err());
        assert!(matches!(error, DeviceError::Nonsense { .. }), "{error}");
    }
    let _stream = daemon.accept();
    let state = eventually("the daemon again", || mouse.read(0.0).ok());
    assert_eq!(state.twist.unwrap().as_array(), [0.0; 6], "the cap is at rest until the daemon says otherwise");
}
