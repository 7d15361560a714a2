//! Devices of 3D Systems (Touch, Touch X, Phantom), through the maker's OpenHaptics HD API, whose library is loaded when the device is
//! opened.
//!
//! The library's own scheduler calls the driver at its rate, in its own thread, which reads poses, sets forces, and
//! removes the force if the servo has not written for 50 ms. Rotation is sensed. Torques are not actuated: the few
//! models with torques take joint torques of their gimbal, not torques on the hand. The scheduler serves all devices of
//! the process, and ends with this one.

use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

use feeler_core::geometry::twist::{product, transposed, Matrix};
use feeler_core::Point;
use feeler_haptics::device::{Device, DeviceError, DeviceInfo, DeviceState};
use feeler_haptics::{Twist, Wrench};

use crate::clip::{told_pose, told_twist};
use crate::exchange::{exchange, DeviceEnd, Measured, ServoEnd};
use crate::figures::{of_3d_systems, Figures, Said};
use crate::numbers::check;
use crate::vendor_library::hd_calls::{HdDoubles, OpenHd, Scheduled};

/// Buttons of the API: the stylus has two, other handles up to four.
const BUTTONS: u32 = 4;

/// Metres of a millimetre.
const MM: f64 = 1e-3;

/// Which library, which device, and limits.
#[derive(Debug, Clone, PartialEq, Default)]
#[non_exhaustive]
pub struct OpenHapticsOptions {
    /// The library's file. `None`: where the system looks for `libHD`.
    pub library: Option<PathBuf>,
    /// Name of the device in the maker's set-up program. `None`: its default device.
    pub device: Option<String>,
    /// Largest force, newtons, where less than the device has is wanted.
    pub force_n: Option<f64>,
    /// Stiffness that the device renders stably at 1 kHz, newtons a metre. `None`: the published one.
    pub stiffness_n_per_m: Option<f64>,
}

impl OpenHapticsOptions {
    feeler_core::setters! {
        with_library: library: impl Into<Option<PathBuf>>,
        with_device: device: impl Into<Option<String>>,
        with_force_n: force_n: impl Into<Option<f64>>,
        with_stiffness_n_per_m: stiffness_n_per_m: impl Into<Option<f64>>,
    }
}

/// A device of 3D Systems. See the [module](self).
pub struct OpenHaptics {
    servo: ServoEnd,
    scheduled: Option<Scheduled>,
}

impl OpenHaptics {
    /// Loads the library, initialises the device, and waits for its first pose. Errors with advice if there is no
    /// library or no device.
    pub fn open(options: &OpenHapticsOptions) -> Result<OpenHaptics, DeviceError> {
        check([("force_n", options.force_n), ("stiffness_n_per_m", options.stiffness_n_per_m)])?;
        let open = Arc::new(OpenHd::open(options.library.as_deref(), options.device.as_deref())?);
        let (info, centre) = info(options, &open);
        let (servo, end) = exchange(info);
        // What a device does not tell of itself is an error to the library, and none here.
        let _ = open.newest_error();
        let mut talk = Talk { open: open.clone(), end: Some(end), centre, is_calibrated: false };
        let scheduled = Scheduled::start(open, Box::new(move || talk.round()));
        let mut device = OpenHaptics { servo, scheduled: Some(scheduled) };
        device.servo.wait_for_first()?;
        Ok(device)
    }
}

impl Device for OpenHaptics {
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
        let has_ended = self.servo.release();
        if let Some(scheduled) = self.scheduled.take() {
            scheduled.stop(has_ended);
        }
    }
}

impl Drop for OpenHaptics {
    fn drop(&mut self) {
        self.release();
    }
}

/// The device's own figures, and the middle of its workspace in the library's frame, metres. Force, stiffness, workspace and
/// rate are the device's own where it reports them.
fn info(options: &OpenHapticsOptions, open: &OpenHd) -> (DeviceInfo, Point) {
    let name = open.name();
    let known = of_3d_systems(&name);
    let or = |told: f64, otherwise: f64| if told > 0.0 && told.is_finite() { told } else { otherwise };
    let corners = open.doubles(HdDoubles::Workspace);
    let half: Point = std::array::from_fn(|a| 0.5 * MM * (corners[a + 3] - corners[a]));
    let is_told = half.iter().all(|x| *x > 0.0 && x.is_finite());
    let centre: Point = std::array::from_fn(|a| if is_told { 0.5 * MM * (corners[a + 3] + corners[a]) } else { 0.0 });
    let figures = Figures {
        force_n: or(open.doubles(HdDoubles::MostForce)[0], known.force_n),
        stiffness_n_per_m: or(open.doubles(HdDoubles::Stiffness)[0] / MM, known.stiffness_n_per_m),
        rate_hz: or(open.rate_hz().into(), known.rate_hz),
        workspace: if is_told { device_from_library(&half).map(f64::abs) } else { known.workspace },
        ..known
    };
    let said = Said { force_n: options.force_n, stiffness_n_per_m: options.stiffness_n_per_m, ..Said::default() };
    let name = if name.is_empty() { "3D Systems device".to_string() } else { name };
    (figures.info(name, true, false, &said).with_buttons(BUTTONS), centre)
}

/// The library's axes (x right, y up, z towards the hand's owner) in those of a device here: row by row.
const DEVICE_FROM_LIBRARY_HD: Matrix = [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]];

fn device_from_library(v: &Point) -> Point {
    [v[0], -v[2], v[1]]
}

fn library_from_device(v: &Point) -> Point {
    [v[0], v[2], -v[1]]
}

struct Talk {
    open: Arc<OpenHd>,
    /// Dropped when the force is off for good.
    end: Option<DeviceEnd>,
    /// The middle of the workspace in the library's frame, metres.
    centre: Point,
    is_calibrated: bool,
}

impl Talk {
    /// One round of the scheduler. False: no other is wanted.
    fn round(&mut self) -> bool {
        let Some(end) = &mut self.end else { return false };
        let is_last = end.is_released();
        let force = end.wrench(Instant::now()).force;
        self.open.begin_frame();
        self.is_calibrated = self.is_calibrated || self.open.is_calibrated();
        let measured = if self.is_calibrated {
            measured(&self.open, end.name(), &self.centre)
        } else {
            Err(DeviceError::Nonsense {
                device: end.name().to_string(),
                what: "positions, for it is not calibrated: put the stylus into the inkwell, or run the maker's Touch Diagnostic".to_string(),
            })
        };
        self.open.set_force(&library_from_device(&force));
        self.open.end_frame();
        match self.open.newest_error() {
            Some(error) => end.tell(Err(end.lost(error))),
            None => end.tell(measured),
        }
        if is_last {
            self.end = None;
        }
        !is_last
    }
}

fn measured(open: &OpenHd, name: &str, centre: &Point) -> Result<Measured, DeviceError> {
    let m = open.doubles(HdDoubles::Transform);
    let rotation: Matrix = std::array::from_fn(|i| std::array::from_fn(|j| m[4 * j + i]));
    let position: Point = std::array::from_fn(|i| MM * m[12 + i] - centre[i]);
    let rotation = product(&product(&DEVICE_FROM_LIBRARY_HD, &rotation), &transposed(&DEVICE_FROM_LIBRARY_HD));
    let pose = told_pose(name, &rotation, &device_from_library(&position))?;
    let [x, y, z, ..] = open.doubles(HdDoubles::Velocity);
    let [u, v, w, ..] = open.doubles(HdDoubles::AngularVelocity);
    let linear = device_from_library(&[MM * x, MM * y, MM * z]);
    let twist = told_twist(name, Twist { linear, angular: device_from_library(&[u, v, w]) })?;
    Ok(Measured { pose, twist: Some(twist), buttons: open.buttons(), at: Instant::now() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use feeler_core::geometry::twist::times;

    #[test]
    fn axes_are_changed_by_one_rotation_and_back() {
        let v = [1.0, 2.0, 3.0];
        assert_eq!(device_from_library(&v), times(&DEVICE_FROM_LIBRARY_HD, &v));
        assert_eq!(library_from_device(&device_from_library(&v)), v);
        // Up is up, and towards the hand's owner is not away.
        assert_eq!(device_from_library(&[0.0, 1.0, 0.0]), [0.0, 0.0, 1.0]);
        assert_eq!(device_from_library(&[0.0, 0.0, 1.0]), [0.0, -1.0, 0.0]);
    }
}
