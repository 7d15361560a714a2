//! Force Dimension's `libdhd` (header `dhdc.h`, SDK 3): metres, newtons, seconds; x towards the hand's owner, y to the right, z up.
//! Results below 0 are errors, whose text `dhdErrorGetLastStr` has for the calling thread.

use std::ffi::{c_char, c_int, c_uchar, c_uint};
use std::path::Path;

use feeler_core::geometry::twist::Matrix;
use feeler_core::Point;
use feeler_haptics::device::DeviceError;
use feeler_haptics::Wrench;

use crate::constants::FORCE_DIMENSION;

use super::{functions, text, Wanted};

const LIBDHD: Wanted = Wanted {
    device: FORCE_DIMENSION,
    names: if cfg!(windows) {
        &["dhd64.dll", "drd64.dll", "dhd.dll"]
    } else if cfg!(target_os = "macos") {
        &["libdhd.dylib", "libdrd.dylib", "libdhd.3.dylib"]
    } else {
        &["libdhd.so", "libdrd.so", "libdhd.so.3", "libdrd.so.3"]
    },
    what_to_do:
        "install the Force Dimension SDK 3 where the system finds its library, or name the file in the option `library`",
};

functions! {
    Calls {
        dhdOpen() -> c_int;
        dhdClose(c_char) -> c_int;
        dhdErrorGetLastStr() -> *const c_char;
        dhdGetSystemName(c_char) -> *const c_char;
        dhdGetSystemType(c_char) -> c_int;
        dhdHasWrist(c_char) -> c_uchar;
        dhdHasActiveWrist(c_char) -> c_uchar;
        dhdEnableForce(c_uchar, c_char) -> c_int;
        dhdGetPosition(*mut f64, *mut f64, *mut f64, c_char) -> c_int;
        dhdGetOrientationFrame(*mut [f64; 3], c_char) -> c_int;
        dhdGetLinearVelocity(*mut f64, *mut f64, *mut f64, c_char) -> c_int;
        dhdGetAngularVelocityRad(*mut f64, *mut f64, *mut f64, c_char) -> c_int;
        dhdGetButtonMask(c_char) -> c_uint;
        dhdSetForceAndTorqueAndGripperForce(f64, f64, f64, f64, f64, f64, f64, c_char) -> c_int;
    }
}

type GetThree = unsafe extern "system" fn(*mut f64, *mut f64, *mut f64, c_char) -> c_int;

/// One device that is open. Closed when dropped.
pub(crate) struct OpenDhd {
    calls: Calls,
    id: c_char,
}

/// The type of the device.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct DhdModel {
    pub name: String,
    /// `DHD_DEVICE_...`.
    pub kind: i32,
    pub has_wrist: bool,
    pub has_active_wrist: bool,
}

impl OpenDhd {
    /// Loads the library and opens the first device that is free.
    pub fn open(library: Option<&Path>) -> Result<OpenDhd, DeviceError> {
        let calls = Calls::of(&LIBDHD.load(library)?)?;
        // SAFETY: takes nothing.
        let id = unsafe { (calls.dhdOpen)() };
        let open = OpenDhd { calls, id: id as c_char };
        if id < 0 {
            let why = format!(
                "no device opened: {}; connect it, switch it on, and end other programs that use it",
                open.error()
            );
            // Nothing is open, so nothing is to be closed.
            std::mem::forget(open);
            return Err(DeviceError::NotFound { device: LIBDHD.device.to_string(), why });
        }
        Ok(open)
    }

    pub fn model(&self) -> DhdModel {
        // SAFETY: the device is open; the name is the library's own.
        let (name, kind, has_wrist, has_active_wrist) = unsafe {
            (
                text((self.calls.dhdGetSystemName)(self.id)),
                (self.calls.dhdGetSystemType)(self.id),
                (self.calls.dhdHasWrist)(self.id),
                (self.calls.dhdHasActiveWrist)(self.id),
            )
        };
        DhdModel { name, kind, has_wrist: has_wrist != 0, has_active_wrist: has_active_wrist != 0 }
    }

    /// Switches the motors on, or lets them brake.
    pub fn enable_force(&self, is_on: bool) -> Result<(), String> {
        // SAFETY: the device is open.
        self.result(unsafe { (self.calls.dhdEnableForce)(is_on.into(), self.id) })
    }

    /// Of the handle, metres, the library's axes.
    pub fn position(&self) -> Result<Point, String> {
        self.three(self.calls.dhdGetPosition)
    }

    /// Of the handle, metres a second, the library's axes.
    pub fn linear_velocity(&self) -> Result<Point, String> {
        self.three(self.calls.dhdGetLinearVelocity)
    }

    /// Of the handle, radians a second, the library's axes.
    pub fn angular_velocity(&self) -> Result<Point, String> {
        self.three(self.calls.dhdGetAngularVelocityRad)
    }

    /// Of the handle, the library's axes, row by row.
    pub fn rotation(&self) -> Result<Matrix, String> {
        let mut rows = [[0.0; 3]; 3];
        // SAFETY: the device is open, and the library writes three rows of three numbers.
        self.result(unsafe { (self.calls.dhdGetOrientationFrame)(rows.as_mut_ptr(), self.id) })?;
        Ok(rows)
    }

    /// A bit each.
    pub fn buttons(&self) -> u32 {
        // SAFETY: the device is open.
        unsafe { (self.calls.dhdGetButtonMask)(self.id) }
    }

    /// A wrench on the hand, the library's axes; no force on a gripper.
    pub fn set_wrench(&self, wrench: &Wrench) -> Result<(), String> {
        let ([fx, fy, fz], [tx, ty, tz]) = (wrench.force, wrench.torque);
        // SAFETY: the device is open.
        self.result(unsafe { (self.calls.dhdSetForceAndTorqueAndGripperForce)(fx, fy, fz, tx, ty, tz, 0.0, self.id) })
    }

    fn three(&self, call: GetThree) -> Result<Point, String> {
        let [mut x, mut y, mut z] = [0.0; 3];
        // SAFETY: the device is open, and the library writes one number through each pointer.
        self.result(unsafe { call(&mut x, &mut y, &mut z, self.id) })?;
        Ok([x, y, z])
    }

    /// Results above 0 are remarks, such as that the motors are at their limit or that nothing is newer.
    fn result(&self, result: c_int) -> Result<(), String> {
        if result < 0 {
            Err(self.error())
        } else {
            Ok(())
        }
    }

    fn error(&self) -> String {
        // SAFETY: takes nothing; the text is the library's own.
        unsafe { text((self.calls.dhdErrorGetLastStr)()) }
    }
}

impl Drop for OpenDhd {
    fn drop(&mut self) {
        // SAFETY: the device is open, and nothing calls after this.
        unsafe { (self.calls.dhdClose)(self.id) };
    }
}
