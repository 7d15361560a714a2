//! How the cap moves the pose, and the resulting properties of a SpaceMouse.

use std::path::PathBuf;

use feeler_haptics::device::{DeviceError, DeviceInfo, DeviceLimits, Freedoms};

use crate::constants::{FULL_DEFLECTION_COUNTS, SPACEMOUSE, SPACEMOUSE_HZ};
use crate::numbers::check;

/// How the cap moves the pose.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct SpaceMouseOptions {
    /// The daemon's socket. `None`: that of the environment variable `SPNAV_SOCKET`, else `/var/run/spnav.sock`.
    pub socket: Option<PathBuf>,
    /// Speed at full deflection, metres a second.
    pub speed_m_per_s: f64,
    /// Rate of turning at full deflection, radians a second.
    pub turn_rad_per_s: f64,
    /// Counts from the daemon at full deflection.
    pub full_deflection_counts: f64,
    /// Part of full deflection that counts as rest, from 0 to 0.99, beside the daemon's own dead zone. Motion beyond
    /// it begins at 0.
    pub dead_zone: f64,
    /// How far from its beginning the pose may go along each axis, metres.
    pub reach_m: f64,
    /// How long a motion holds without an event, seconds; infinite: until the daemon says otherwise.
    pub silence_s: f64,
}

impl Default for SpaceMouseOptions {
    fn default() -> SpaceMouseOptions {
        SpaceMouseOptions {
            socket: None,
            speed_m_per_s: 0.1,
            turn_rad_per_s: 1.0,
            full_deflection_counts: FULL_DEFLECTION_COUNTS,
            dead_zone: 0.05,
            reach_m: 1.0,
            silence_s: 5.0,
        }
    }
}

impl SpaceMouseOptions {
    feeler_core::setters! {
        with_socket: socket: impl Into<Option<PathBuf>>,
        with_speed_m_per_s: speed_m_per_s: f64,
        with_turn_rad_per_s: turn_rad_per_s: f64,
        with_full_deflection_counts: full_deflection_counts: f64,
        with_dead_zone: dead_zone: f64,
        with_reach_m: reach_m: f64,
        with_silence_s: silence_s: f64,
    }
}

impl SpaceMouseOptions {
    pub(super) fn check(&self) -> Result<(), DeviceError> {
        check([
            ("speed_m_per_s", Some(self.speed_m_per_s)),
            ("turn_rad_per_s", Some(self.turn_rad_per_s)),
            ("full_deflection_counts", Some(self.full_deflection_counts)),
            ("dead_zone", Some(self.dead_zone)),
            ("reach_m", Some(self.reach_m)),
            ("silence_s", Some(self.silence_s)),
        ])
    }

    pub(super) fn info(&self, protocol: u8, buttons: u32) -> DeviceInfo {
        let step = |speed: f64| speed / self.full_deflection_counts / SPACEMOUSE_HZ;
        DeviceInfo::new(format!("{SPACEMOUSE} (spacenavd, protocol {protocol})"))
            .with_sensed(Freedoms { translation: true, rotation: true })
            .with_driven(Freedoms::default())
            .with_workspace([self.reach_m; 3])
            .with_limits(
                DeviceLimits::default()
                    .with_resolution_m(step(self.speed_m_per_s))
                    .with_rotational_resolution_rad(step(self.turn_rad_per_s))
                    .with_rate_hz(SPACEMOUSE_HZ),
            )
            .with_buttons(buttons)
    }

    /// Where the daemon listens.
    #[cfg(unix)]
    pub(super) fn socket(&self) -> PathBuf {
        self.socket
            .clone()
            .or_else(|| std::env::var_os("SPNAV_SOCKET").filter(|path| !path.is_empty()).map(PathBuf::from))
            .unwrap_or_else(|| PathBuf::from(crate::constants::SPACENAVD_SOCKET))
    }
}

/// That there is none, with what to do.
pub(super) fn not_found(why: String) -> DeviceError {
    DeviceError::NotFound { device: SPACEMOUSE.to_string(), why }
}
