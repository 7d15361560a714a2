//! How stiff a coupling may be, for a device to hold it without humming.
//!
//! - J. E. Colgate and J. M. Brown, *Factors Affecting the Z-Width of a Haptic Display*, ICRA 1994 (and Colgate and
//!   Schenkel, J. Robotic Systems 14(1), 1997): a sampled wall of stiffness K and damping B is passive if and only if
//!   `b > K T / 2 + |B|`, with b the device's own damping and T the period. A delay t adds to the hold:
//!   `b > K (T / 2 + t) + |B|` (J. J. Gil, E. Sánchez, T. Hulin, C. Preusche and G. Hirzinger, *Stability Boundary for Haptic
//!   Rendering: Influence of Damping and Delay*, J. Computing and Information Science in Engineering 9(1), 2009, have
//!   it as the bound of stability for small damping).
//! - J. J. Abbott and A. M. Okamura, *Effects of Position Quantization and Sampling Rate on Virtual-Wall Passivity*,
//!   IEEE Trans. Robotics 21(5), 2005: with a resolution Δ, Coulomb friction f must also take what the steps make:
//!   `K <= 2 f / Δ`.
//!
//! Both hold in translation and in rotation. Where the tool's centre is an arm r from the handle, the spring of
//! translation turns the handle too: in the plane of arm and force the condition is `C w wᵀ <= diag(b, a)`, with
//! `w = (1, r)`, `C = K (T / 2 + t) + B` and a what is set apart of the rotational damping, and that is
//! `C <= 1 / (1 / b + r² / a)`: the damping that is felt at the centre.

use std::fmt;

use crate::constants::{ARM_ROOM, ARM_SHARE, HELD_SHARE, VIRTUAL_DAMPING_SHARE};
use crate::coupling::Coupling;
use crate::device::DeviceInfo;

/// What a number of a coupling was limited by.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Bound {
    /// The device's own damping, its rate and its delay: Colgate and Brown.
    Damping,
    /// Its friction and resolution: Abbott and Okamura.
    Friction,
    /// The largest force or torque it has.
    Force,
    /// It does not drive this freedom.
    NotDriven,
}

/// A number of a coupling that a device does not hold.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limitation {
    /// What was asked for, in the number's own unit.
    pub wanted: f64,
    /// What is left.
    pub allowed: f64,
    /// Why.
    pub by: Bound,
}

/// What [`Coupling::limited`] took away; `None` where nothing.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Limitations {
    /// Of `stiffness_n_per_m`.
    pub stiffness: Option<Limitation>,
    /// Of `damping_n_s_per_m`.
    pub damping: Option<Limitation>,
    /// Of `rotational_stiffness_nm_per_rad`.
    pub rotational_stiffness: Option<Limitation>,
    /// Of `rotational_damping_nm_s_per_rad`.
    pub rotational_damping: Option<Limitation>,
    /// Of `max_force_n`.
    pub force: Option<Limitation>,
    /// Of `max_torque_nm`.
    pub torque: Option<Limitation>,
}

impl Limitations {
    /// Whether the coupling was held as it was.
    pub fn is_empty(&self) -> bool {
        *self == Limitations::default()
    }
}

impl fmt::Display for Limitations {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let all = [
            ("stiffness", self.stiffness, "N/m"),
            ("damping", self.damping, "N s/m"),
            ("rotational stiffness", self.rotational_stiffness, "Nm/rad"),
            ("rotational damping", self.rotational_damping, "Nm s/rad"),
            ("force", self.force, "N"),
            ("torque", self.torque, "Nm"),
        ];
        let mut separator = "";
        for (what, found, unit) in all {
            let Some(Limitation { wanted, allowed, by }) = found else { continue };
            let why = match by {
                Bound::Damping => "by the device's damping and rate (Colgate and Brown)",
                Bound::Friction => "by the device's friction and resolution (Abbott and Okamura)",
                Bound::Force => "by what the device has",
                Bound::NotDriven => "because the device does not drive it",
            };
            write!(f, "{separator}{what} {allowed:.4} {unit} instead of {wanted:.4}, {why}")?;
            separator = "; ";
        }
        if separator.is_empty() {
            f.write_str("nothing was limited")?;
        }
        Ok(())
    }
}

/// The least of some bounds, and which it is.
#[derive(Clone, Copy)]
struct Least(f64, Bound);

impl Least {
    fn and(self, value: f64, by: Bound) -> Least {
        if value < self.0 || value.is_nan() {
            // A bound that is not a number holds nothing.
            Least(value.max(0.0), by)
        } else {
            self
        }
    }

    fn apply(self, number: &mut f64) -> Option<Limitation> {
        let Least(allowed, by) = self;
        let wanted = *number;
        if wanted <= allowed {
            return None;
        }
        *number = allowed;
        Some(Limitation { wanted, allowed, by })
    }
}

impl Coupling {
    /// What a device holds of this coupling at a rate (hertz; the device's own where that is lower), with the tool's
    /// centre at the handle; and what was taken away. See [`limited_at`](Self::limited_at).
    pub fn limited(&self, info: &DeviceInfo, rate_hz: f64) -> (Coupling, Limitations) {
        self.limited_at(info, rate_hz, 0.0)
    }

    /// What a device holds of this coupling at a rate, with the tool's centre `arm_m` (metres) from the handle's
    /// origin.
    ///
    /// Spring and damper together stay within 0.8 of Colgate's bound, the damper within a fifth of that; stiffness also
    /// within Abbott and Okamura's bound, force and torque within the device's. A resolution of zero is none; a friction
    /// of zero is not known, as of most devices, and bounds nothing. Damping is never added. A rate that is not above zero
    /// holds nothing.
    pub fn limited_at(&self, info: &DeviceInfo, rate_hz: f64, arm_m: f64) -> (Coupling, Limitations) {
        let limits = &info.limits;
        let hold = limits.hold_s(rate_hz);
        // An arm that the device cannot tell from none, as rounding leaves it, is none.
        let arm = if info.driven.rotation && arm_m.abs() > limits.resolution_m { arm_m.abs() } else { 0.0 };
        let mut to = *self;
        let mut found = Limitations::default();

        let inside = HELD_SHARE * limits.damping_n_s_per_m;
        let turning = HELD_SHARE * limits.rotational_damping_nm_s_per_rad;
        // What the arm's spring would use up of the rotation at full stiffness, and what is set apart for it.
        let lever = if info.driven.translation { arm * arm * inside } else { 0.0 };
        // Of the rotation's friction too, as much as holds what the translation's does.
        let rubbing = if limits.rotational_friction_nm > 0.0 {
            arm * limits.friction_n / limits.rotational_friction_nm
        } else {
            0.0
        };
        let share = if lever > 0.0 { (ARM_ROOM * lever / turning).max(rubbing).min(ARM_SHARE) } else { 0.0 };

        let left = (1.0 - share) * turning;
        let driven = |is: bool| if is { Least(f64::INFINITY, Bound::Damping) } else { Least(0.0, Bound::NotDriven) };
        let rotation = driven(info.driven.rotation);
        found.torque = rotation.and(limits.torque_nm, Bound::Force).apply(&mut to.max_torque_nm);
        found.rotational_damping =
            rotation.and(VIRTUAL_DAMPING_SHARE * left, Bound::Damping).apply(&mut to.rotational_damping_nm_s_per_rad);
        let friction = quantised((1.0 - share) * limits.rotational_friction_nm, limits.rotational_resolution_rad);
        found.rotational_stiffness = rotation
            .and((left - to.rotational_damping_nm_s_per_rad).max(0.0) / hold, Bound::Damping)
            .and(friction, Bound::Friction)
            .apply(&mut to.rotational_stiffness_nm_per_rad);

        // The damping felt at the centre.
        let felt = if lever > 0.0 { 1.0 / (1.0 / inside + arm * arm / (share * turning)) } else { inside };
        let translation = driven(info.driven.translation);
        found.force = translation.and(limits.force_n, Bound::Force).apply(&mut to.max_force_n);
        found.damping = translation.and(VIRTUAL_DAMPING_SHARE * felt, Bound::Damping).apply(&mut to.damping_n_s_per_m);
        let step = limits.resolution_m + arm * limits.rotational_resolution_rad;
        found.stiffness = translation
            .and((felt - to.damping_n_s_per_m).max(0.0) / hold, Bound::Damping)
            .and(quantised(limits.friction_n, step), Bound::Friction)
            .and(
                if arm > 0.0 { quantised(share * limits.rotational_friction_nm / arm, step) } else { f64::INFINITY },
                Bound::Friction,
            )
            .apply(&mut to.stiffness_n_per_m);
        (to, found)
    }
}

/// The stiffness that a friction holds at a resolution; infinite where either is not known.
fn quantised(friction: f64, resolution: f64) -> f64 {
    if resolution > 0.0 && friction != 0.0 {
        2.0 * friction / resolution
    } else {
        f64::INFINITY
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::device::simulated::SimulatedOptions;
    use proptest::prelude::*;

    /// 6 driven freedoms, b = 1.5, f = 0.1, 10 um; in rotation 3e-3, 2e-3, 0.2 mrad; 12 N, 0.4 Nm, 1 kHz.
    fn info() -> DeviceInfo {
        SimulatedOptions::desktop_6dof().info
    }

    fn wanted() -> Coupling {
        Coupling {
            stiffness_n_per_m: 1e6,
            damping_n_s_per_m: 0.1,
            rotational_stiffness_nm_per_rad: 1e3,
            rotational_damping_nm_s_per_rad: 1e-4,
            max_force_n: 100.0,
            max_torque_nm: 0.1,
            ..Coupling::default()
        }
    }

    fn is_near(a: f64, b: f64) -> bool {
        (a - b).abs() <= 1e-9 * b
    }

    #[test]
    fn a_short_arm_takes_little() {
        let at_once = wanted().limited(&info(), 1000.0).0.stiffness_n_per_m;
        for arm in [1e-19, 1e-6, 1.1e-5, 1e-4, 1e-3] {
            let stiffness = wanted().limited_at(&info(), 1000.0, arm).0.stiffness_n_per_m;
            assert!(stiffness > 0.85 * at_once, "{arm}: {stiffness} of {at_once}");
        }
    }

    #[test]
    fn damping_and_rate_bound_stiffness() {
        let (to, taken) = wanted().limited(&info(), 1000.0);
        assert!(is_near(to.stiffness_n_per_m, (0.8 * 1.5 - 0.1) / 0.5e-3), "{to:?}");
        assert!(is_near(to.rotational_stiffness_nm_per_rad, (0.8 * 3e-3 - 1e-4) / 0.5e-3), "{to:?}");
        assert_eq!(taken.stiffness.map(|l| (l.wanted, l.by)), Some((1e6, Bound::Damping)));
        assert_eq!(taken.rotational_stiffness.map(|l| l.by), Some(Bound::Damping));
        assert_eq!(taken.force, Some(Limitation { wanted: 100.0, allowed: 12.0, by: Bound::Force }));
        assert_eq!((taken.torque, taken.damping, taken.rotational_damping), (None, None, None));
        assert!(taken.to_string().contains("Colgate"), "{taken}");
        // Twice the period is half the stiffness, whose ever it is; a millisecond's delay is two half periods more.
        let slow = wanted().limited(&info(), 500.0).0;
        assert!(is_near(slow.stiffness_n_per_m, 0.5 * to.stiffness_n_per_m));
        let mut other = info();
        other.limits.rate_hz = 500.0;
        assert_eq!(wanted().limited(&other, 1000.0).0, slow);
        other = info();
        other.limits.delay_s = 1e-3;
        assert!(is_near(wanted().limited(&other, 1000.0).0.stiffness_n_per_m, to.stiffness_n_per_m / 3.0));
    }

    #[test]
    fn friction_and_resolution_bound_stiffness() {
        let mut info = info();
        info.limits.friction_n = 1e-3;
        info.limits.rotational_friction_nm = 1e-4;
        let (to, taken) = wanted().limited(&info, 1000.0);
        assert!(is_near(to.stiffness_n_per_m, 200.0) && is_near(to.rotational_stiffness_nm_per_rad, 1.0), "{to:?}");
        assert_eq!(taken.stiffness.map(|l| l.by), Some(Bound::Friction));
        assert_eq!(taken.rotational_stiffness.map(|l| l.by), Some(Bound::Friction));
        assert!(taken.to_string().contains("Abbott"), "{taken}");
        info.limits.resolution_m = 0.0;
        assert_eq!(wanted().limited(&info, 1000.0).1.stiffness.map(|l| l.by), Some(Bound::Damping));
    }

    #[test]
    fn a_friction_that_is_not_known_bounds_nothing() {
        let mut info = info();
        let known = wanted().limited(&info, 1000.0);
        assert_eq!(known.1.stiffness.map(|l| l.by), Some(Bound::Damping));
        (info.limits.friction_n, info.limits.rotational_friction_nm) = (0.0, 0.0);
        assert_eq!(wanted().limited(&info, 1000.0), known);
        // On an arm the rotation holds what its damping does.
        let (to, taken) = wanted().limited_at(&info, 1000.0, 0.05);
        assert!(to.stiffness_n_per_m > 0.0 && to.rotational_stiffness_nm_per_rad > 0.0, "{to:?}");
        assert_eq!(taken.stiffness.map(|l| l.by), Some(Bound::Damping));
    }

    #[test]
    fn what_is_not_driven_or_has_no_rate_is_nothing() {
        let info = SimulatedOptions::desktop_3dof().info;
        let (to, taken) = wanted().limited(&info, 1000.0);
        assert_eq!(
            (to.rotational_stiffness_nm_per_rad, to.rotational_damping_nm_s_per_rad, to.max_torque_nm),
            (0.0, 0.0, 0.0)
        );
        assert_eq!(taken.rotational_stiffness.map(|l| l.by), Some(Bound::NotDriven));
        assert!(to.stiffness_n_per_m > 0.0);
        // An arm turns nothing that is driven.
        assert_eq!(wanted().limited_at(&info, 1000.0, 0.3), (to, taken));
        let mut unknown = info.clone();
        unknown.limits.friction_n = f64::NAN;
        assert_eq!(wanted().limited(&unknown, 1000.0).0.stiffness_n_per_m, 0.0);
        for rate in [0.0, -1.0, f64::NAN] {
            let to = wanted().limited(&info, rate).0;
            assert_eq!(to.stiffness_n_per_m, 0.0, "{rate}");
        }
    }

    #[test]
    fn damping_is_cut_before_stiffness() {
        let much = Coupling { damping_n_s_per_m: 5.0, rotational_damping_nm_s_per_rad: 1.0, ..wanted() };
        let (to, taken) = much.limited(&info(), 1000.0);
        assert!(is_near(to.damping_n_s_per_m, 0.2 * 0.8 * 1.5), "{to:?}");
        assert!(to.stiffness_n_per_m > 1000.0 && to.rotational_stiffness_nm_per_rad > 1.0, "{to:?}");
        assert_eq!(taken.damping.map(|l| l.by), Some(Bound::Damping));
        assert_eq!(taken.rotational_damping.map(|l| l.by), Some(Bound::Damping));
    }

    #[test]
    fn presets_are_held() {
        for options in
            [SimulatedOptions::desktop_3dof(), SimulatedOptions::desktop_6dof(), SimulatedOptions::large_6dof()]
        {
            let coupling = Coupling::for_device(&options.info);
            assert_eq!(coupling.check(), Ok(()));
            let (same, taken) = coupling.limited(&options.info, options.info.limits.rate_hz);
            assert_eq!(same, coupling);
            assert!(taken.is_empty() && taken.to_string() == "nothing was limited", "{taken}");
            assert!(coupling.stiffness_n_per_m > 1000.0, "{coupling:?}");
        }
    }

    proptest! {
        /// Whatever way the handle goes, its damping takes more than spring and damper, held for a tick, can give.
        #[test]
        fn the_damping_of_the_handle_covers_the_arm(
            arm in 0.0..2.0f64, v in -1.0..1.0f64, w in -10.0..10.0f64,
            b in 0.1..10.0f64, b_turn in 1e-4..1.0f64, delay in 0.0..5e-3f64,
        ) {
            let mut info = info();
            info.limits.damping_n_s_per_m = b;
            info.limits.rotational_damping_nm_s_per_rad = b_turn;
            info.limits.delay_s = delay;
            let (to, _) = wanted().limited_at(&info, 1000.0, arm);
            let hold = 0.5e-3 + delay;
            let at_centre = v + arm * w;
            let given = (to.stiffness_n_per_m * hold + to.damping_n_s_per_m) * at_centre * at_centre
                + (to.rotational_stiffness_nm_per_rad * hold + to.rotational_damping_nm_s_per_rad) * w * w;
            prop_assert!(given <= 0.8 * (b * v * v + b_turn * w * w) * (1.0 + 1e-9), "{to:?}");
            prop_assert!(to.stiffness_n_per_m > 0.0 && to.rotational_stiffness_nm_per_rad > 0.0);
        }
    }
}
