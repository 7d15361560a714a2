//! Shared helpers of the tests.

use feeler_haptics::device::{DeviceInfo, DeviceLimits, Freedoms};

pub(crate) const INFINITE: f64 = f64::INFINITY;

/// A device that senses and drives everything.
pub(crate) fn device(force_n: f64, torque_nm: f64) -> DeviceInfo {
    let all = Freedoms { translation: true, rotation: true };
    DeviceInfo {
        name: "test".to_string(),
        sensed: all,
        driven: all,
        workspace: [0.1; 3],
        limits: DeviceLimits {
            force_n,
            torque_nm,
            damping_n_s_per_m: 0.5,
            resolution_m: 1e-5,
            rotational_resolution_rad: 1e-4,
            rate_hz: 1000.0,
            ..DeviceLimits::default()
        },
        buttons: 0,
    }
}
