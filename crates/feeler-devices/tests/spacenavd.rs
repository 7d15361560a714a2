//! The SpaceMouse against the real daemon: Debian's spacenavd, fed by a pseudo-terminal that speaks the protocol of the serial Magellan
//! SpaceMouse. The daemon runs in a folder of its own, with a configuration of its own: no file of the machine is touched.
#![cfg(target_os = "linux")]

mod common;

use std::fs::File;
use std::io::{Read, Write};
use std::os::fd::OwnedFd;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use common::{eventually, Folder};
use feeler_devices::spacemouse::{SpaceMouse, SpaceMouseOptions};
use feeler_haptics::device::{Device, DeviceError};
use rustix::pty::{grantpt, openpt, ptsname, unlockpt, OpenptFlags};
use rustix::termios::{tcgetattr, tcsetattr, OptionalActions};

/// A Magellan SpaceMouse on a serial line.
struct Magellan {
    line: File,
    /// The daemon's end of the line, kept open so that the line lives when the daemon does not.
    _far_end: OwnedFd,
    path: PathBuf,
}

impl Magellan {
    fn new() -> Magellan {
        let line = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).unwrap();
        grantpt(&line).unwrap();
        unlockpt(&line).unwrap();
        let path = PathBuf::from(ptsname(&line, vec![]).unwrap().into_string().unwrap());
        let far_end: OwnedFd = File::options().read(true).write(true).open(&path).unwrap().into();
        let mut settings = tcgetattr(&far_end).unwrap();
        settings.make_raw();
        tcsetattr(&far_end, OptionalActions::Now, &settings).unwrap();
        let line = File::from(line);
        let mut ears = line.try_clone().unwrap();
        let mut mouth = line.try_clone().unwrap();
        std::thread::spawn(move || {
            let mut bytes = [0; 256];
            while let Ok(read) = ears.read(&mut bytes) {
                // The daemon asks for the version; everything else it says needs no answer.
                if bytes[..read].windows(2).any(|pair| pair == b"vQ") {
                    mouth.write_all(b"v  MAGELLAN  Version 6.60\r").unwrap();
                }
            }
        });
        Magellan { line, _far_end: far_end, path }
    }

    /// Six displacements, counts: four nibbles each, 0x8000 is rest.
    fn displace(&mut self, counts: [i32; 6]) {
        let nibbles = counts.iter().flat_map(|count| {
            let value = count + 0x8000;
            [12, 8, 4, 0].map(|shift| 0x40 | ((value >> shift) & 15) as u8)
        });
        let packet: Vec<u8> = [b'd'].into_iter().chain(nibbles).chain([b'\r']).collect();
        self.line.write_all(&packet).unwrap();
    }

    fn press(&mut self, buttons: u8) {
        self.line.write_all(&[b'k', 0x40 | (buttons & 15), 0x40 | (buttons >> 4), 0x40, b'\r']).unwrap();
    }
}

/// A daemon, stopped when dropped.
struct Daemon {
    process: Child,
    socket: PathBuf,
}

impl Daemon {
    /// Debian's daemon names its socket relative to the folder where it is started.
    fn start(folder: &Path, serial: &Path) -> Daemon {
        std::fs::create_dir_all(folder.join("run")).unwrap();
        let configuration = folder.join("spnavrc");
        std::fs::write(&configuration, format!("serial = {}\n", serial.display())).unwrap();
        let process = Command::new("spacenavd")
            .args(["-d", "-v", "-c"])
            .arg(&configuration)
            .current_dir(folder)
            .env_remove("DISPLAY")
            .stdout(File::create(folder.join("log")).unwrap())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let daemon = Daemon { process, socket: folder.join("run/spnav.sock") };
        eventually("the daemon's socket", || daemon.socket.exists().then_some(()));
        daemon
    }
}

impl Drop for Daemon {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
        let _ = std::fs::remove_file(&self.socket);
    }
}

/// Whether there is a daemon to test with. In CI there must be one.
fn has_daemon() -> bool {
    let paths = std::env::var_os("PATH").unwrap_or_default();
    let has =
        std::env::split_paths(&paths).chain(["/usr/sbin".into()]).any(|folder| folder.join("spacenavd").is_file());
    let what_to_do = "spacenavd is not installed (Debian: apt-get install spacenavd)";
    assert!(has || std::env::var_os("CI").is_none(), "{what_to_do}");
    if !has {
        eprintln!("not tested: {what_to_do}");
    }
    has
}

#[test]
fn a_cap_moves_the_pose_through_the_real_daemon() {
    if !has_daemon() {
        return;
    }
    let folder = Folder::new("spacenavd");
    let mut magellan = Magellan::new();
    let daemon = Daemon::start(&folder.path, &magellan.path);
    let options = SpaceMouseOptions::default().with_socket(daemon.socket.clone()).with_dead_zone(0.0);
    // The daemon listens before it has asked the cap how many buttons it has.
    let mut mouse =
        eventually("a cap of 9 buttons", || SpaceMouse::open(&options).ok().filter(|mouse| mouse.info().buttons == 9));
    assert!(mouse.info().name.contains("protocol 1"), "{:?}", mouse.info());
    assert!(!mouse.info().driven.translation && !mouse.info().driven.rotation);

    // The Magellan's axes: x right, y up, z towards the hand's owner. Full deflection, 0.1 m/s and 1 rad/s.
    let velocities = [
        [0.1, 0.0, 0.0, 0.0, 0.0, 0.0],
        [0.0, 0.0, 0.1, 0.0, 0.0, 0.0],
        [0.0, -0.1, 0.0, 0.0, 0.0, 0.0],
        [0.0, 0.0, 0.0, 1.0, 0.0, 0.0],
        [0.0, 0.0, 0.0, 0.0, 0.0, 1.0],
        [0.0, 0.0, 0.0, 0.0, -1.0, 0.0],
    ];
    for (axis, velocity) in velocities.iter().enumerate() {
        magellan.displace(std::array::from_fn(|i| if i == axis { 350 } else { 0 }));
        eventually(&format!("axis {axis} moves"), || {
            (mouse.read(0.0).unwrap().twist.unwrap().as_array() == *velocity).then_some(())
        });
    }

    // Half deflection for two seconds of the caller's time: 0.1 m to the right. The cap is still, so the daemon is silent.
    magellan.displace([175, 0, 0, 0, 0, 0]);
    eventually("half deflection", || (mouse.read(0.0).unwrap().twist.unwrap().linear[0] == 0.05).then_some(()));
    for i in 0..=2000 {
        mouse.read(f64::from(i) * 1e-3).unwrap();
    }
    let there = mouse.read(2.0).unwrap().pose.translation()[0];
    assert!((there - 0.1).abs() < 1e-9, "{there}");

    magellan.displace([0; 6]);
    eventually("rest", || (mouse.read(2.0).unwrap().twist.unwrap().as_array() == [0.0; 6]).then_some(()));
    magellan.press(0b101);
    eventually("two buttons", || (mouse.read(2.0).unwrap().buttons == 0b101).then_some(()));
    magellan.press(0b100);
    eventually("one button", || (mouse.read(2.0).unwrap().buttons == 0b100).then_some(()));

    // The daemon stops while the cap is held: the device is lost, and the motion stops. It restarts: the pose is unchanged.
    magellan.displace([350, 0, 0, 0, 0, 0]);
    eventually("moving", || (mouse.read(2.0).unwrap().twist.unwrap().linear[0] > 0.0).then_some(()));
    drop(daemon);
    let error = eventually("the loss", || mouse.read(2.0).err());
    assert!(matches!(error, DeviceError::Lost { .. }), "{error}");
    magellan.displace([0; 6]);
    let _daemon = Daemon::start(&folder.path, &magellan.path);
    let back = eventually("the daemon again", || mouse.read(3.0).ok());
    assert!((back.pose.translation()[0] - there).abs() < 1e-9, "{back:?}");
    assert_eq!((back.twist.unwrap().as_array(), back.buttons), ([0.0; 6], 0));

    mouse.release();
    assert!(matches!(mouse.read(3.0), Err(DeviceError::Lost { .. })));
}
