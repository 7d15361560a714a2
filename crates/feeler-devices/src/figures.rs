//! Data of the supported device types, one line each, with its source.
//!
//! Few makers publish damping, friction and mass. Unknown values are 0 here, and limit nothing. A maker's largest
//! stiffness is for a loop like a driver's here: the damping that stabilises it there, by Colgate's `b > K (T / 2 +
//! t)`, is the least that the device must have, and limits the stiffness of other loops. Data sheets without a date
//! were not at hand, and are quoted from memory.

use feeler_core::Point;
use feeler_haptics::device::{DeviceInfo, DeviceLimits, Freedoms};

use crate::clip::limit;
use crate::constants::{HANDOVER_ROUNDS, USUAL_HZ};

/// Figures of a type of device. 0: not published.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Figures {
    /// Maker and model.
    pub name: &'static str,
    /// Largest force, newtons.
    pub force_n: f64,
    /// Largest torque, newton metres, of models whose wrist has motors.
    pub torque_nm: f64,
    /// Largest stiffness, newtons a metre.
    pub stiffness_n_per_m: f64,
    /// The same in rotation, newton metres a radian.
    pub rotational_stiffness_nm_per_rad: f64,
    /// Coulomb friction, newtons.
    pub friction_n: f64,
    /// Half the edges of the workspace, axes of a device (x right, y away, z up), metres.
    pub workspace: Point,
    /// Smallest step of the measured position, metres.
    pub resolution_m: f64,
    /// Smallest step of the measured rotation, radians.
    pub rotational_resolution_rad: f64,
    /// Rate of poses and forces, hertz.
    pub rate_hz: f64,
    /// Where the figures are from.
    pub sources: &'static str,
}

const CHAI3D: &str = "force, torque, stiffness: CHAI3D 3.2.0 (2016), driver by CHAI3D and Force Dimension; \
    workspace, resolution, rate: Force Dimension's data sheets (undated)";
const SENSABLE: &str =
    "stiffness: CHAI3D 3.2.0 (2016); the rest: SensAble's specifications of the PHANTOM line (undated)";

/// What no line says otherwise.
const NOTHING: Figures = Figures {
    name: "",
    force_n: 0.0,
    torque_nm: 0.0,
    stiffness_n_per_m: 0.0,
    rotational_stiffness_nm_per_rad: 0.0,
    friction_n: 0.0,
    workspace: [0.0; 3],
    resolution_m: 0.0,
    rotational_resolution_rad: 0.0,
    rate_hz: 1000.0,
    sources: "",
};

const OMEGA: Figures = Figures {
    name: "Force Dimension omega.3, .6, .7",
    force_n: 12.0,
    stiffness_n_per_m: 5000.0,
    workspace: [0.080, 0.055, 0.080],
    resolution_m: 1e-5,
    rotational_resolution_rad: 1.6e-3,
    rate_hz: 4000.0,
    sources: CHAI3D,
    ..NOTHING
};
const DELTA: Figures = Figures {
    name: "Force Dimension delta.3, .6",
    force_n: 20.0,
    torque_nm: 0.2,
    stiffness_n_per_m: 5000.0,
    rotational_stiffness_nm_per_rad: 1.0,
    workspace: [0.200, 0.130, 0.200],
    resolution_m: 2e-5,
    rotational_resolution_rad: 7e-4,
    ..OMEGA
};
const SIGMA: Figures = Figures {
    name: "Force Dimension sigma.3, .7, .7+",
    force_n: 12.0,
    torque_nm: 0.2,
    stiffness_n_per_m: 4000.0,
    rotational_stiffness_nm_per_rad: 1.0,
    workspace: [0.095, 0.065, 0.095],
    resolution_m: 1.5e-6,
    rotational_resolution_rad: 2.3e-4,
    ..OMEGA
};
const LAMBDA: Figures = Figures {
    name: "Force Dimension lambda.3, .7",
    workspace: [0.120, 0.085, 0.120],
    sources: "workspace: Force Dimension's data sheets (undated); the rest: a sigma's",
    ..SIGMA
};
pub(crate) const FALCON: Figures = Figures {
    name: "Novint Falcon",
    force_n: 8.0,
    stiffness_n_per_m: 3000.0,
    workspace: [0.050; 3],
    resolution_m: 6.4e-5,
    rate_hz: 1000.0,
    sources: "force, stiffness: CHAI3D 3.2.0 (2016); workspace, resolution: Novint's specifications, in the wiki of H3D API (2021); \
        rate: Novint's description of itself (May 2008)",
    ..NOTHING
};
const OTHER_DHD: Figures = Figures {
    name: "another device of Force Dimension",
    force_n: 5.0,
    torque_nm: 0.1,
    stiffness_n_per_m: 3000.0,
    rotational_stiffness_nm_per_rad: 1.0,
    workspace: [0.050; 3],
    resolution_m: 2e-5,
    rotational_resolution_rad: 1e-3,
    rate_hz: 4000.0,
    sources: "estimates: not more than any of the above",
    ..NOTHING
};

/// Of a `DHD_DEVICE_...` of `dhdc.h`.
pub(crate) fn of_force_dimension(kind: i32) -> Figures {
    match kind {
        33..=37 => OMEGA,
        63 | 64 => DELTA,
        104..=107 | 206 => SIGMA,
        108 | 109 | 203 => LAMBDA,
        60 => FALCON,
        _ => OTHER_DHD,
    }
}

const TOUCH: Figures = Figures {
    name: "3D Systems Touch, PHANTOM Omni",
    force_n: 3.3,
    stiffness_n_per_m: 400.0,
    friction_n: 0.26,
    workspace: [0.080, 0.035, 0.060],
    resolution_m: 5.5e-5,
    rotational_resolution_rad: 1e-3,
    sources: SENSABLE,
    ..NOTHING
};
const TOUCH_X: Figures = Figures {
    name: "3D Systems Touch X, PHANTOM Desktop",
    force_n: 7.9,
    stiffness_n_per_m: 1000.0,
    friction_n: 0.06,
    workspace: [0.080, 0.060, 0.060],
    resolution_m: 2.3e-5,
    ..TOUCH
};
const PREMIUM_15: Figures = Figures {
    name: "PHANTOM Premium 1.5",
    force_n: 8.5,
    stiffness_n_per_m: 800.0,
    friction_n: 0.04,
    workspace: [0.190, 0.095, 0.133],
    resolution_m: 3e-5,
    ..TOUCH
};
const PREMIUM_30: Figures = Figures {
    name: "PHANTOM Premium 3.0",
    force_n: 22.0,
    stiffness_n_per_m: 1000.0,
    friction_n: 0.2,
    workspace: [0.419, 0.203, 0.292],
    resolution_m: 2e-5,
    ..TOUCH
};

/// By what OpenHaptics calls the model. One that is not known is a Touch, the smallest of the line.
pub(crate) fn of_3d_systems(model: &str) -> Figures {
    let model = model.to_lowercase();
    let is = |words: &[&str]| words.iter().any(|word| model.contains(word));
    match () {
        () if is(&["premium 3"]) => PREMIUM_30,
        () if is(&["premium"]) => PREMIUM_15,
        () if is(&["touch x", "touchx", "desktop"]) => TOUCH_X,
        () => TOUCH,
    }
}

/// Force: half of the peak of 10 N, since the peak cannot be held.
pub(crate) const INVERSE3: Figures = Figures {
    name: "Haply Inverse3",
    force_n: 5.0,
    stiffness_n_per_m: 800.0,
    workspace: [0.10; 3],
    resolution_m: 1e-5,
    rotational_resolution_rad: 1.2e-4,
    sources: "force: half of the peak that Haply states; stiffness: the most that Haply's tutorial \"Basic Force-Feedback\" sets (Inverse SDK \
        3.3); workspace: the radius that Haply's tutorials keep to; resolution of position: an estimate; of rotation: 14 bits a part of \
        the VerseGrip's quaternion",
    ..NOTHING
};
pub(crate) const MINVERSE: Figures = Figures { name: "Haply Minverse", workspace: [0.04; 3], ..INVERSE3 };

/// All lines.
///
/// ```
/// let falcon = feeler_devices::FIGURES.iter().find(|line| line.name == "Novint Falcon").unwrap();
/// assert_eq!((falcon.force_n, falcon.friction_n), (8.0, 0.0));
/// ```
pub const FIGURES: [Figures; 12] =
    [OMEGA, DELTA, SIGMA, LAMBDA, OTHER_DHD, FALCON, TOUCH, TOUCH_X, PREMIUM_15, PREMIUM_30, INVERSE3, MINVERSE];

/// A user's figures of a device.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Said {
    pub force_n: Option<f64>,
    pub torque_nm: Option<f64>,
    pub stiffness_n_per_m: Option<f64>,
}

impl Figures {
    /// What a device of this type is, as far as a user's word goes. `drives_rotation`: this one does.
    pub(crate) fn info(&self, name: String, senses_rotation: bool, drives_rotation: bool, said: &Said) -> DeviceInfo {
        let turning = if drives_rotation { 1.0 } else { 0.0 };
        let mut limits = DeviceLimits::default()
            .with_force_n(limit(self.force_n, said.force_n))
            .with_torque_nm(turning * limit(self.torque_nm, said.torque_nm))
            .with_stiffness_n_per_m(self.stiffness_n_per_m)
            .with_rotational_stiffness_nm_per_rad(turning * self.rotational_stiffness_nm_per_rad)
            .with_friction_n(self.friction_n)
            .with_resolution_m(self.resolution_m)
            .with_rotational_resolution_rad(self.rotational_resolution_rad)
            .with_rate_hz(self.rate_hz)
            .with_delay_s(HANDOVER_ROUNDS / self.rate_hz);
        let hold = limits.hold_s(limits.rate_hz);
        limits.damping_n_s_per_m = limits.stiffness_n_per_m * hold;
        limits.rotational_damping_nm_s_per_rad = limits.rotational_stiffness_nm_per_rad * hold;
        if let Some(stiffness) = said.stiffness_n_per_m.filter(|stiffness| *stiffness > 0.0 && stiffness.is_finite()) {
            limits = limits.with_stiffness(stiffness, USUAL_HZ);
        }
        DeviceInfo::new(name)
            .with_sensed(Freedoms { translation: true, rotation: senses_rotation })
            .with_driven(Freedoms { translation: true, rotation: drives_rotation })
            .with_workspace(self.workspace)
            .with_limits(limits)
            .with_buttons(0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use feeler_haptics::Coupling;

    #[test]
    fn what_is_published_bounds_every_loop() {
        for figures in FIGURES {
            let info = figures.info(figures.name.to_string(), true, figures.torque_nm > 0.0, &Said::default());
            assert!(info.limits.check().is_ok() && !figures.sources.is_empty());
            let asked = Coupling::for_device(&info).with_stiffness_n_per_m(1e5);
            let at = |rate_hz| asked.limited(&info, rate_hz).0.stiffness_n_per_m;
            // Less than the published value, by the reserve, at its own rate; and never more.
            assert!(
                (at(info.limits.rate_hz) / (0.64 * figures.stiffness_n_per_m) - 1.0).abs() < 1e-9,
                "{}",
                figures.name
            );
            assert!(at(500.0) < at(1000.0) && at(1e5) <= figures.stiffness_n_per_m, "{}", figures.name);
        }
    }

    #[test]
    fn what_its_user_says_counts() {
        let said = Said { force_n: Some(2.0), torque_nm: None, stiffness_n_per_m: Some(2000.0) };
        let info = INVERSE3.info("one".to_string(), false, false, &said);
        let asked = Coupling::for_device(&info).with_stiffness_n_per_m(1e5).with_damping_n_s_per_m(1e5);
        let found = asked.limited(&info, 1000.0).0;
        assert!((found.stiffness_n_per_m - 2000.0).abs() < 1e-6 && found.max_force_n == 2.0, "{found:?}");
        for nonsense in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let said = Said { stiffness_n_per_m: Some(nonsense), ..Said::default() };
            assert_eq!(INVERSE3.info("one".to_string(), false, false, &said).limits.stiffness_n_per_m, 800.0);
        }
    }

    #[test]
    fn models_are_known_by_their_names() {
        for (said, name) in [
            ("Touch", TOUCH.name),
            ("PHANToM Omni", TOUCH.name),
            ("Touch X", TOUCH_X.name),
            ("PHANToM Desktop", TOUCH_X.name),
            ("PHANToM Premium 1.5 6DOF", PREMIUM_15.name),
            ("PHANToM Premium 3.0", PREMIUM_30.name),
            ("", TOUCH.name),
        ] {
            assert_eq!(of_3d_systems(said).name, name);
        }
    }
}
