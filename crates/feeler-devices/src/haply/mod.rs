//! Haply's Inverse3, with the rotation of a VerseGrip if there is one, through the Inverse Service (3.5 or later) on
//! this machine.
//!
//! A thread owns the websocket. It answers each state of the service with the newest force, and sends none ahead of the
//! service's answers, which would act late. When no state comes, it asks again without a force (the service stops sending
//! states when commands stop). It sends zero at once if the servo has not written for 50 ms. It requests the preset `arm_front_centered`, which puts the origin into the middle of the
//! workspace: x right, y away, z up, as here.
//!
//! Three translations are actuated. Rotation is sensed only if a VerseGrip sent one while the device was opened; if it
//! falls silent later, the rotation stays.
//!
//! If the service closes the connection, or stops reading, the device is [`DeviceError::Lost`] for good: open it again.
//! An invalid state is [`DeviceError::Nonsense`] until the next valid one.

mod messages;
mod options;
mod pace;
mod service;

use std::time::Instant;

use feeler_haptics::device::{Device, DeviceError, DeviceInfo, DeviceState};
use feeler_haptics::Wrench;

pub use options::HaplyOptions;

use crate::exchange::ServoEnd;

/// An Inverse3. See the [module](self).
pub struct Haply {
    servo: ServoEnd,
}

impl Haply {
    /// Connects to the service and waits for the first pose, at most 3 s. Errors with advice if there is no service or
    /// no device.
    pub fn open(options: &HaplyOptions) -> Result<Haply, DeviceError> {
        let mut servo = service::start(options)?;
        servo.wait_for_first()?;
        Ok(Haply { servo })
    }
}

impl Device for Haply {
    fn info(&self) -> &DeviceInfo {
        self.servo.info()
    }

    fn read(&mut self, now: f64) -> Result<DeviceState, DeviceError> {
        self.servo.read(now, Instant::now())
    }

    fn write(&mut self, wrench: &Wrench, _now: f64) -> Result<(), DeviceError> {
        self.servo.write(wrench, Instant::now())
    }

    fn release(&mut self) {
        self.servo.release();
    }
}
