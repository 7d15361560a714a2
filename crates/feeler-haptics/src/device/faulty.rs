//! A device with a temporary fault, to test the reaction of the force.

use feeler_core::geometry::twist::{Twist, Wrench};
use feeler_core::Pose;

use super::{Device, DeviceError, DeviceInfo, DeviceState};
use crate::error::{Error, Result};

/// The kind of fault.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Fault {
    /// Its velocity is not a number.
    NotANumber,
    /// It reports that its reading cannot be right.
    Nonsense,
    /// It does not answer.
    Lost,
    /// It goes on telling the same state, from when it stopped.
    Silent,
    /// It is somewhere else by so much (device axes, metres).
    Jump([f64; 3]),
    /// It tells a new state only so often, hertz.
    Slow(f64),
}

/// Another device, and a fault from one time to another.
#[derive(Debug)]
pub struct Faulty<D> {
    device: D,
    fault: Fault,
    /// Seconds since the first read.
    from: f64,
    until: f64,
    start: Option<f64>,
    kept: Option<DeviceState>,
}

impl<D: Device> Faulty<D> {
    /// `from`, `until`: seconds since the first read. Errors where a number of the fault is out of its range.
    pub fn new(device: D, fault: Fault, from: f64, until: f64) -> Result<Faulty<D>> {
        match fault {
            Fault::Slow(value) if !(value.is_finite() && value > 0.0) => {
                Err(Error::Option { what: "rate of a slow device", value, range: "positive (hertz)" })
            }
            Fault::Jump(by) if !by.iter().all(|x| x.abs() <= 1e3) => {
                Err(Error::Option { what: "jump of a device", value: by[0], range: "at most 1 km" })
            }
            _ => Ok(Faulty { device, fault, from, until, start: None, kept: None }),
        }
    }

    fn error(&self, what: &str) -> DeviceError {
        DeviceError::Nonsense { device: self.device.info().name.clone(), what: what.into() }
    }
}

impl<D: Device> Device for Faulty<D> {
    fn info(&self) -> &DeviceInfo {
        self.device.info()
    }

    fn read(&mut self, now: f64) -> Result<DeviceState, DeviceError> {
        let state = self.device.read(now)?;
        let since = now - *self.start.get_or_insert(now);
        if !(self.from..self.until).contains(&since) {
            self.kept = None;
            return Ok(state);
        }
        match self.fault {
            Fault::NotANumber => {
                let twist = Some(Twist { linear: [f64::NAN; 3], angular: [0.0; 3] });
                Ok(DeviceState { twist, ..state })
            }
            Fault::Nonsense => Err(self.error("a pose that is none")),
            Fault::Lost => {
                let device = self.device.info().name.clone();
                Err(DeviceError::Lost { device, why: "it is pulled out".into() })
            }
            Fault::Silent => Ok(*self.kept.get_or_insert(state)),
            Fault::Jump(by) => {
                let pose: Pose =
                    state.pose.translated(&by).map_err(|_| self.error("a place beyond all coordinates"))?;
                Ok(DeviceState { pose, ..state })
            }
            Fault::Slow(hz) => {
                let kept = self.kept.get_or_insert(state);
                if state.time - kept.time >= 1.0 / hz {
                    *kept = state;
                }
                Ok(*kept)
            }
        }
    }

    fn write(&mut self, wrench: &Wrench, now: f64) -> Result<(), DeviceError> {
        self.device.write(wrench, now)
    }

    fn release(&mut self) {
        self.device.release();
    }
}
