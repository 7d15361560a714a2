//! A SpaceMouse, through the daemon spacenavd: a cap that springs back, and so a rate device. Its displacement is a
//! velocity, which moves the pose from one read to the next. It has no actuators.
//!
//! **Axes.** The daemon reports x to the right, y up and z away from the user, and rotations about them with the same
//! change of handedness; here x is to the right, y away and z up.
//!
//! **Silence.** spacenavd sends an event when a value of the cap changes, including its return to rest; it repeats
//! nothing unless its `repeat-interval` is set. A cap that is held still, at its stop for example, sends nothing, so
//! silence alone does not mean rest. A serial device that is unplugged while it is held sends nothing either. Therefore
//! a motion holds for `silence_s` (5 s) after its last event, and then counts as rest until the next event. If the
//! daemon reports the device as removed, or is gone itself, this counts as rest at once.
//!
//! **A missing daemon** is [`DeviceError::Lost`]; the reader tries to reconnect twice a second, and then the device
//! continues from the pose where it was.

mod options;
mod protocol;
mod rate;
#[cfg(unix)]
mod reader;

use feeler_haptics::device::{Device, DeviceError, DeviceInfo, DeviceState};
use feeler_haptics::Wrench;

pub use options::SpaceMouseOptions;

#[cfg(not(unix))]
use options::not_found;

/// A SpaceMouse. See the [module](self).
pub struct SpaceMouse {
    info: DeviceInfo,
    rate: rate::Rate,
    #[cfg(unix)]
    reader: reader::Reader,
    is_released: bool,
}

impl SpaceMouse {
    /// Connects to the daemon. Errors with advice if there is none.
    #[cfg(unix)]
    pub fn open(options: &SpaceMouseOptions) -> Result<SpaceMouse, DeviceError> {
        options.check()?;
        let reader = reader::Reader::start(options.socket(), options.silence_s)?;
        let (protocol, buttons) = reader.daemon();
        let info = options.info(protocol, buttons);
        Ok(SpaceMouse { info, rate: rate::Rate::new(options), reader, is_released: false })
    }

    /// Connects to the daemon. There is none on this system.
    #[cfg(not(unix))]
    pub fn open(options: &SpaceMouseOptions) -> Result<SpaceMouse, DeviceError> {
        options.check()?;
        Err(not_found("spacenavd, which this driver talks to, is for Unix only".to_string()))
    }

    #[cfg(unix)]
    fn newest(&mut self) -> Result<reader::Cap, DeviceError> {
        self.reader.newest(std::time::Instant::now())
    }

    #[cfg(not(unix))]
    fn newest(&mut self) -> Result<protocol::Cap, DeviceError> {
        Err(not_found("spacenavd is for Unix only".to_string()))
    }
}

impl Device for SpaceMouse {
    fn info(&self) -> &DeviceInfo {
        &self.info
    }

    fn read(&mut self, now: f64) -> Result<DeviceState, DeviceError> {
        if self.is_released {
            return Err(DeviceError::Lost { device: self.info.name.clone(), why: "it is released".to_string() });
        }
        match self.newest() {
            Ok(cap) => {
                let (pose, twist) = self.rate.step(&cap.counts, now)?;
                Ok(DeviceState::new(pose, now).with_twist(twist).with_buttons(cap.buttons))
            }
            Err(error) => {
                self.rate.pause(now);
                Err(error)
            }
        }
    }

    /// Accepted, and nothing happens: it has no motors.
    fn write(&mut self, _wrench: &Wrench, _now: f64) -> Result<(), DeviceError> {
        Ok(())
    }

    fn release(&mut self) {
        self.is_released = true;
        #[cfg(unix)]
        self.reader.stop();
    }

    fn is_rate_controlled(&self) -> bool {
        true
    }
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use super::*;

    #[test]
    fn a_daemon_that_is_not_there_is_said_with_what_to_do() {
        let options = SpaceMouseOptions { socket: Some(PathBuf::from("/nowhere/spnav.sock")), ..Default::default() };
        let error = SpaceMouse::open(&options).err().unwrap();
        assert!(matches!(error, DeviceError::NotFound { .. }), "{error}");
        let words: &[&str] = if cfg!(unix) { &["/nowhere/spnav.sock", "install"] } else { &["Unix"] };
        assert!(words.iter().all(|word| error.to_string().contains(word)), "{error}");
    }
}
