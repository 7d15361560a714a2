//! Which Inverse3 to open, and its settings.

use crate::constants::INVERSE_SERVICE;

/// Which device, and how.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct HaplyOptions {
    /// Host and port of the Inverse Service.
    pub address: String,
    /// The id of the Inverse3; `None`: the first that the service names.
    pub device_id: Option<String>,
    /// The id of the VerseGrip; `None`: the first one with a rotation.
    pub grip_id: Option<String>,
    /// The preset to request from the service; `None`: it keeps its user's setting, and so its own origin.
    pub preset: Option<String>,
    /// Largest force, newtons; `None`: 5 N, half of the peak that the maker states. More than 10 N is never sent.
    pub force_n: Option<f64>,
    /// Stiffness that the device renders stably at 1 kHz, newtons a metre. `None`: the published one.
    pub stiffness_n_per_m: Option<f64>,
}

impl Default for HaplyOptions {
    fn default() -> HaplyOptions {
        HaplyOptions {
            address: INVERSE_SERVICE.to_string(),
            device_id: None,
            grip_id: None,
            preset: Some("arm_front_centered".to_string()),
            force_n: None,
            stiffness_n_per_m: None,
        }
    }
}

impl HaplyOptions {
    feeler_core::setters! {
        with_address: address: impl Into<String>,
        with_device_id: device_id: impl Into<Option<String>>,
        with_grip_id: grip_id: impl Into<Option<String>>,
        with_preset: preset: impl Into<Option<String>>,
        with_force_n: force_n: impl Into<Option<f64>>,
        with_stiffness_n_per_m: stiffness_n_per_m: impl Into<Option<f64>>,
    }
}
