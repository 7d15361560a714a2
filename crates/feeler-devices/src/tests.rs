//! Shared helpers of the tests.

use feeler_haptics::device::{DeviceInfo, DeviceLimits, Freedoms};

pub(crate) const INFINITE: f64 = f64::INFINITY;

/// A device that senses and drives everything.
pub(crate) fn device(force_n: f64, torque_nm: f64) -> DeviceInfo {
    let all = Freedoms { translation: true, rotation: true };
    DeviceInfo::new("test")
        .with_sensed(all)
        .with_driven(all)
        .with_workspace([0.1; 3])
        .with_limits(
            DeviceLimits::default()
                .with_force_n(force_n)
                .with_torque_nm(torque_nm)
                .with_damping_n_s_per_m(0.5)
                .with_resolution_m(1e-5)
                .with_rotational_resolution_rad(1e-4)
                .with_rate_hz(1000.0),
        )
        .with_buttons(0)
}
