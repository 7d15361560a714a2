//! Devices of Force Dimension (omega, delta, sigma, lambda) and Novint's Falcon, through the maker's library `libdhd`, which is loaded
//! when the device is opened.
//!
//! A thread talks to the library at 4 kHz, because its calls wait for the device. It removes the force if the servo has
//! not written for 50 ms. Devices with an active wrist get torques; a gripper gets no force. A failing call gives
//! [`DeviceError::Lost`] until calls succeed again.

use std::path::PathBuf;
use std::time::Instant;

use feeler_core::geometry::twist::{product, transposed, Matrix};
use feeler_core::Point;
use feeler_haptics::device::{Device, DeviceError, DeviceInfo, DeviceState};
use feeler_haptics::{Twist, Wrench};

use crate::clip::{told_pose, told_twist};
use crate::constants::{DHD_HZ, FORCE_DIMENSION};
use crate::exchange::{exchange, DeviceEnd, Measured, ServoEnd};
use crate::figures::{of_force_dimension, Said, FALCON};
use crate::machine::{raise_priority, MonotonicClock};
use crate::numbers::check;
use crate::vendor_library::dhd_calls::{DhdModel, OpenDhd};

/// Which library, and limits.
#[derive(Debug, Clone, PartialEq, Default)]
#[non_exhaustive]
pub struct DhdOptions {
    /// The library's file. `None`: where the system looks for `libdhd`.
    pub library: Option<PathBuf>,
    /// Largest force, newtons, where less than the device has is wanted.
    pub force_n: Option<f64>,
    /// Largest torque, newton metres, where less than the device has is wanted.
    pub torque_nm: Option<f64>,
    /// Stiffness that the device renders stably at 1 kHz, newtons a metre. `None`: the published one.
    pub stiffness_n_per_m: Option<f64>,
}

impl DhdOptions {
    feeler_core::setters! {
        with_library: library: impl Into<Option<PathBuf>>,
        with_force_n: force_n: impl Into<Option<f64>>,
        with_torque_nm: torque_nm: impl Into<Option<f64>>,
        with_stiffness_n_per_m: stiffness_n_per_m: impl Into<Option<f64>>,
    }
}

/// A device of Force Dimension. See the [module](self).
pub struct Dhd {
    servo: ServoEnd,
}

impl Dhd {
    /// Loads the library, opens the first free device, and waits for its first pose. Errors with advice if there is no
    /// library or no device.
    pub fn open(options: &DhdOptions) -> Result<Dhd, DeviceError> {
        check([
            ("force_n", options.force_n),
            ("torque_nm", options.torque_nm),
            ("stiffness_n_per_m", options.stiffness_n_per_m),
        ])?;
        let open = OpenDhd::open(options.library.as_deref())?;
        let model = open.model();
        let (mut servo, end) = exchange(info(options, &model));
        let mut talk = Talk { open, end, has_wrist: model.has_wrist };
        std::thread::Builder::new().name("feeler-dhd".to_string()).spawn(move || talk.run()).map_err(|error| {
            DeviceError::NotFound {
                device: FORCE_DIMENSION.to_string(),
                why: format!("no thread to talk to it with: {error}"),
            }
        })?;
        servo.wait_for_first()?;
        Ok(Dhd { servo })
    }
}

impl Device for Dhd {
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

fn info(options: &DhdOptions, model: &DhdModel) -> DeviceInfo {
    let figures = of_force_dimension(model.kind);
    let name = match model.name.as_str() {
        _ if figures == FALCON => FALCON.name.to_string(),
        "" => format!("{FORCE_DIMENSION} device of type {}", model.kind),
        name => format!("{FORCE_DIMENSION} {name}"),
    };
    let said =
        Said { force_n: options.force_n, torque_nm: options.torque_nm, stiffness_n_per_m: options.stiffness_n_per_m };
    figures.info(name, model.has_wrist, model.has_active_wrist, &said).with_buttons(u32::BITS)
}

/// The library's axes (x towards the hand's owner, y right, z up) in those of a device here: row by row.
const DEVICE_FROM_LIBRARY: Matrix = [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];

fn device_from_library(v: &Point) -> Point {
    [v[1], -v[0], v[2]]
}

fn library_from_device(v: &Point) -> Point {
    [-v[1], v[0], v[2]]
}

struct Talk {
    open: OpenDhd,
    end: DeviceEnd,
    has_wrist: bool,
}

impl Talk {
    fn run(&mut self) {
        // A thread without priority works too, with more jitter.
        let _ = raise_priority();
        // Where the motors cannot be switched on, the first force says why.
        let _ = self.open.enable_force(true);
        let clock = MonotonicClock::new();
        let mut next = clock.now();
        while !self.end.is_released() {
            let measured = self.measured();
            self.end.tell(measured);
            let wrench = self.end.wrench(Instant::now());
            if let Err(error) = self.set(&wrench) {
                self.end.tell(Err(self.end.lost(error)));
            }
            // What was missed is not caught up.
            next = (next + 1.0 / DHD_HZ).max(clock.now());
            clock.sleep_until(next);
        }
        // Each on its own: one that fails must not keep the others from being tried.
        let _ = self.set(&Wrench::ZERO);
        let _ = self.open.enable_force(false);
    }

    fn measured(&self) -> Result<Measured, DeviceError> {
        let lost = |error| self.end.lost(error);
        let name = self.end.name();
        let position = device_from_library(&self.open.position().map_err(lost)?);
        let rotation = if self.has_wrist {
            let rotation = self.open.rotation().map_err(lost)?;
            product(&product(&DEVICE_FROM_LIBRARY, &rotation), &transposed(&DEVICE_FROM_LIBRARY))
        } else {
            [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
        };
        let angular = if self.has_wrist { self.open.angular_velocity().map_err(lost)? } else { [0.0; 3] };
        let twist = Twist {
            linear: device_from_library(&self.open.linear_velocity().map_err(lost)?),
            angular: device_from_library(&angular),
        };
        Ok(Measured {
            pose: told_pose(name, &rotation, &position)?,
            twist: Some(told_twist(name, twist)?),
            buttons: self.open.buttons(),
            at: Instant::now(),
        })
    }

    fn set(&self, wrench: &Wrench) -> Result<(), String> {
        self.open.set_wrench(&Wrench {
            force: library_from_device(&wrench.force),
            torque: library_from_device(&wrench.torque),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use feeler_core::geometry::twist::times;

    #[test]
    fn axes_are_changed_by_one_rotation_and_back() {
        let v = [1.0, 2.0, 3.0];
        assert_eq!(device_from_library(&v), times(&DEVICE_FROM_LIBRARY, &v));
        assert_eq!(library_from_device(&device_from_library(&v)), v);
        // Towards the hand's owner is not away.
        assert_eq!(device_from_library(&[1.0, 0.0, 0.0]), [0.0, -1.0, 0.0]);
        assert_eq!(device_from_library(&[0.0, 1.0, 0.0]), [1.0, 0.0, 0.0]);
    }

    #[test]
    fn only_an_active_wrist_is_driven() {
        let model =
            |kind, has_wrist, has_active_wrist| DhdModel { name: String::new(), kind, has_wrist, has_active_wrist };
        let omega = info(&DhdOptions::default(), &model(34, true, false));
        assert!(omega.sensed.rotation && !omega.driven.rotation && omega.limits.torque_nm == 0.0);
        let sigma = info(&DhdOptions { force_n: Some(6.0), ..Default::default() }, &model(104, true, true));
        assert_eq!((sigma.limits.force_n, sigma.limits.torque_nm, sigma.driven.rotation), (6.0, 0.2, true));
    }
}
