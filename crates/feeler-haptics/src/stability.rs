//! The largest stiffness of a coupling that a device can hold without oscillation.
//!
//! - J. E. Colgate and J. M. Brown, *Factors Affecting the Z-Width of a Haptic Display*, ICRA 1994 (and Colgate and
//!   Schenkel, J. Robotic Systems 14(1), 1997): a sampled wall of stiffness K and damping B is passive if and only if
//!   `b > K T / 2 + |B|`, with b the device's own damping and T the period. A delay t adds to the hold time:
//!   `b > K (T / 2 + t) + |B|` (J. J. Gil, E. Sánchez, T. Hulin, C. Preusche and G. Hirzinger, *Stability Boundary
//!   for Haptic Rendering: Influence of Damping and Delay*, J. Computing and Information Science in Engineering 9(1),
//!   2009, have it as the bound of stability for small damping).
//! - J. J. Abbott and A. M. Okamura, *Effects of Position Quantization and Sampling Rate on Virtual-Wall Passivity*,
//!   IEEE Trans. Robotics 21(5), 2005: with a resolution Δ, Coulomb friction f must also absorb the energy of the
//!   steps: `K <= 2 f / Δ`.
//!
//! Both hold in translation and in rotation, each for itself: the springs act at the handle.
//!
//! The bounds do not contain the device's mass: both hold for any.

use crate::constants::{HELD_SHARE, USUAL_HZ, VIRTUAL_DAMPING_SHARE};
use crate::coupling::Coupling;
use crate::device::DeviceInfo;

/// The reason why a number of a coupling was limited.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Bound {
    /// The device's own damping, its rate and its delay: Colgate and Brown.
    Damping,
    /// Its friction and resolution: Abbott and Okamura.
    Friction,
    /// The largest that it has, by what its maker publishes or its user knows.
    Maximum,
    /// A loop slower than the usual one, of a device whose damping is not known.
    Rate,
    /// It does not drive this freedom.
    NotDriven,
}

/// A number of a coupling that a device does not hold.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Limitation {
    /// What was asked for, in the number's own unit.
    pub wanted: f64,
    /// The reduced value.
    pub allowed: f64,
    /// Why.
    pub by: Bound,
}

/// Reductions by [`Coupling::limited`]; `None` if there are none.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Limitations {
    /// Of `stiffness_n_per_m`.
    pub(crate) stiffness: Option<Limitation>,
    /// Of `damping_n_s_per_m`.
    pub(crate) damping: Option<Limitation>,
    /// Of `rotational_stiffness_nm_per_rad`.
    pub(crate) rotational_stiffness: Option<Limitation>,
    /// Of `rotational_damping_nm_s_per_rad`.
    pub(crate) rotational_damping: Option<Limitation>,
    /// Of `max_force_n`.
    pub(crate) force: Option<Limitation>,
    /// Of `max_torque_nm`.
    pub(crate) torque: Option<Limitation>,
}

impl Limitations {
    /// Whether the coupling was held as it was.
    pub fn is_empty(&self) -> bool {
        *self == Limitations::default()
    }

    /// A sentence for each reduced number: the reduced value, the requested one, and the reason. `info`: of the device,
    /// as the coupling was limited to it; `rate_hz`: of the loop; `scale`: from the device's motions to the tool's, if
    /// `info` is of the tool's world.
    ///
    /// ```
    /// use feeler_haptics::{device::simulated::SimulatedOptions, Coupling};
    /// let info = SimulatedOptions::desktop_3dof().info;
    /// let asked = Coupling::for_device(&info).with_max_torque_nm(0.0).with_max_force_n(20.0);
    /// let said = asked.limited(&info, 1000.0).1.in_words(&info, 1000.0, 1.0);
    /// assert_eq!(said, ["force 12 N instead of 20: the most that the simulated desktop device, 3 driven freedoms has"]);
    /// ```
    pub fn in_words(&self, info: &DeviceInfo, rate_hz: f64, scale: f64) -> Vec<String> {
        // From a number in the tool's world to the same at the hand.
        let all = [
            ("stiffness", self.stiffness, "N/m", false, scale),
            ("damping", self.damping, "N s/m", false, scale),
            ("rotational stiffness", self.rotational_stiffness, "Nm/rad", true, 1.0 / scale),
            ("rotational damping", self.rotational_damping, "Nm s/rad", true, 1.0 / scale),
            ("force", self.force, "N", false, 1.0),
            ("torque", self.torque, "Nm", true, 1.0 / scale),
        ];
        all.into_iter()
            .filter_map(|(what, found, unit, turns, at_hand)| {
                let Limitation { wanted, allowed, by } = found?;
                let mut why = by.in_words(info, rate_hz, turns);
                if at_hand != 1.0 && by != Bound::NotDriven {
                    let felt = in_words(at_hand * allowed);
                    why = format!(
                        "{why}, that is {felt} {unit} at the handle with motions scaled by {}",
                        in_words(scale)
                    );
                }
                let [wanted, allowed] = [wanted, allowed].map(in_words);
                Some(format!("{what} {allowed} {unit} instead of {wanted}: {why}"))
            })
            .collect()
    }
}

impl Bound {
    /// Why, with the device's own figures. `turns`: of a number of rotation.
    fn in_words(self, info: &DeviceInfo, rate_hz: f64, turns: bool) -> String {
        let (name, limits) = (&info.name, &info.limits);
        let either = |linear: f64, angular: f64| in_words(if turns { angular } else { linear });
        let rate = if limits.rate_hz > 0.0 { rate_hz.min(limits.rate_hz) } else { rate_hz };
        let late = if limits.delay_s > 0.0 {
            format!(" and {} ms of delay", in_words(1e3 * limits.delay_s))
        } else {
            String::new()
        };
        match self {
            Bound::Damping => {
                let damping = either(limits.damping_n_s_per_m, limits.rotational_damping_nm_s_per_rad);
                let unit = if turns { "Nm s/rad" } else { "N s/m" };
                format!("what the damping of the {name}, {damping} {unit}, holds at {} Hz{late}", in_words(rate))
            }
            Bound::Friction => {
                let friction = either(limits.friction_n, limits.rotational_friction_nm);
                let step = either(1e6 * limits.resolution_m, 1e3 * limits.rotational_resolution_rad);
                let [unit, of] = if turns { ["Nm", "mrad"] } else { ["N", "um"] };
                format!("what the friction of the {name}, {friction} {unit}, holds at steps of {step} {of}")
            }
            Bound::Maximum => format!("the most that the {name} has"),
            Bound::Rate => {
                let known = either(limits.stiffness_n_per_m, limits.rotational_stiffness_nm_per_rad);
                let unit = if turns { "Nm/rad" } else { "N/m" };
                let of =
                    if known == "0" { "a stiffness".to_string() } else { format!("the {known} {unit} of the {name}") };
                let [usual, rate] = [USUAL_HZ, rate].map(in_words);
                format!("{of} at {usual} Hz falls in proportion, and the loop runs at {rate} Hz{late}")
            }
            Bound::NotDriven if turns => format!("the {name} drives no rotation"),
            Bound::NotDriven => format!("the {name} drives no translation"),
        }
    }
}

/// A number with three digits, thousands apart.
pub(crate) fn in_words(value: f64) -> String {
    let size = value.abs();
    if (1000.0..1e9).contains(&size) {
        let whole = value.round() as i64;
        let (millions, rest) = (whole / 1_000_000, (whole % 1_000_000).abs());
        return match millions {
            0 => format!("{},{:03}", whole / 1000, rest % 1000),
            _ => format!("{millions},{:03},{:03}", rest / 1000, rest % 1000),
        };
    }
    let digits = if size > 0.0 && size < 100.0 { (2 - size.log10().floor() as i32).clamp(0, 9) as usize } else { 0 };
    let said = format!("{value:.digits$}");
    if said.contains('.') {
        said.trim_end_matches('0').trim_end_matches('.').to_string()
    } else {
        said
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
    /// This coupling as limited to a device at a rate (hertz; the device's own if that is lower), and the reductions.
    ///
    /// Spring and damper together stay within 0.8 of Colgate's bound, the damper within a fifth of that; stiffness also
    /// within Abbott and Okamura's bound and the largest that is known of the device, force and torque within the device's.
    /// A resolution of zero is none; a damping, a friction or a largest stiffness of zero is not known, and bounds nothing.
    /// Damping is never added. A rate that is not above zero holds nothing. Where the damping is not known, the largest
    /// stiffness, or the wanted one, is for a loop of 1 kHz without delay, and falls in proportion in slower ones.
    pub fn limited(&self, info: &DeviceInfo, rate_hz: f64) -> (Coupling, Limitations) {
        let limits = &info.limits;
        let hold = limits.hold_s(rate_hz);
        let mut to = *self;
        let mut found = Limitations::default();

        let inside = HELD_SHARE * known(limits.damping_n_s_per_m);
        let turning = HELD_SHARE * known(limits.rotational_damping_nm_s_per_rad);
        // Of a stiffness for the usual loop, known or asked, where no damping tells what other loops hold.
        let slowed = limits.slowed(rate_hz);
        let usual = |damping: f64, most: f64, asked: f64| match damping.is_finite() {
            true => f64::INFINITY,
            false => slowed * if most > 0.0 { most } else { asked },
        };
        let driven = |is: bool| if is { Least(f64::INFINITY, Bound::Damping) } else { Least(0.0, Bound::NotDriven) };
        let rotation = driven(info.driven.rotation);
        found.torque = rotation.and(limits.torque_nm, Bound::Maximum).apply(&mut to.max_torque_nm);
        found.rotational_damping = rotation
            .and(VIRTUAL_DAMPING_SHARE * turning, Bound::Damping)
            .apply(&mut to.rotational_damping_nm_s_per_rad);
        found.rotational_stiffness = rotation
            .and(known(limits.rotational_stiffness_nm_per_rad), Bound::Maximum)
            .and((turning - to.rotational_damping_nm_s_per_rad).max(0.0) / hold, Bound::Damping)
            .and(quantised(limits.rotational_friction_nm, limits.rotational_resolution_rad), Bound::Friction)
            .and(
                usual(turning, limits.rotational_stiffness_nm_per_rad, to.rotational_stiffness_nm_per_rad),
                Bound::Rate,
            )
            .apply(&mut to.rotational_stiffness_nm_per_rad);

        let translation = driven(info.driven.translation);
        found.force = translation.and(limits.force_n, Bound::Maximum).apply(&mut to.max_force_n);
        found.damping =
            translation.and(VIRTUAL_DAMPING_SHARE * inside, Bound::Damping).apply(&mut to.damping_n_s_per_m);
        found.stiffness = translation
            .and(known(limits.stiffness_n_per_m), Bound::Maximum)
            .and((inside - to.damping_n_s_per_m).max(0.0) / hold, Bound::Damping)
            .and(quantised(limits.friction_n, limits.resolution_m), Bound::Friction)
            .and(usual(inside, limits.stiffness_n_per_m, to.stiffness_n_per_m), Bound::Rate)
            .apply(&mut to.stiffness_n_per_m);
        (to, found)
    }
}

/// A bound that may not be known, and then bounds nothing.
fn known(most: f64) -> f64 {
    if most == 0.0 {
        f64::INFINITY
    } else {
        most
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
    use crate::device::{DeviceLimits, Freedoms};
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
    fn damping_and_rate_bound_stiffness() {
        let (to, taken) = wanted().limited(&info(), 1000.0);
        assert!(is_near(to.stiffness_n_per_m, (0.8 * 1.5 - 0.1) / 0.5e-3), "{to:?}");
        assert!(is_near(to.rotational_stiffness_nm_per_rad, (0.8 * 3e-3 - 1e-4) / 0.5e-3), "{to:?}");
        assert_eq!(taken.stiffness.map(|l| (l.wanted, l.by)), Some((1e6, Bound::Damping)));
        assert_eq!(taken.rotational_stiffness.map(|l| l.by), Some(Bound::Damping));
        assert_eq!(taken.force, Some(Limitation { wanted: 100.0, allowed: 12.0, by: Bound::Maximum }));
        assert_eq!((taken.torque, taken.damping, taken.rotational_damping), (None, None, None));
        assert_eq!(
            taken.in_words(&info(), 1000.0, 1.0)[0],
            "stiffness 2,200 N/m instead of 1,000,000: what the damping of the simulated desktop device, 6 driven freedoms, 1.5 N s/m, \
             holds at 1,000 Hz"
        );
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
        assert_eq!(
            taken.in_words(&info, 1000.0, 1.0)[0],
            "stiffness 200 N/m instead of 1,000,000: what the friction of the simulated desktop device, 6 driven freedoms, 0.001 N, \
             holds at steps of 10 um"
        );
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
    }

    #[test]
    fn a_device_of_which_nothing_is_known_holds_what_is_asked() {
        let DeviceLimits { force_n, torque_nm, rate_hz, .. } = info().limits;
        let limits = DeviceLimits { force_n, torque_nm, rate_hz, ..DeviceLimits::default() };
        let unknown = DeviceInfo { limits, ..info() };
        let asked = Coupling { max_force_n: 10.0, ..wanted() };
        assert_eq!(asked.limited(&unknown, 1000.0), (asked, Limitations::default()));
        assert_eq!(asked.limited(&unknown, 0.0).0.stiffness_n_per_m, 0.0);
        // Of its own it is soft.
        let own = Coupling::for_device(&unknown);
        assert!(
            is_near(own.stiffness_n_per_m, 12.0 / 0.01) && is_near(own.rotational_stiffness_nm_per_rad, 0.4 / 0.25)
        );
        // One of both known says nothing about the other.
        let mut half = info();
        half.limits.rotational_damping_nm_s_per_rad = 0.0;
        let (to, _) = wanted().limited(&half, 1000.0);
        assert!(is_near(to.stiffness_n_per_m, 2200.0), "{to:?}");
    }

    #[test]
    fn what_a_maker_publishes_bounds_stiffness() {
        let mut info = info();
        (info.limits.stiffness_n_per_m, info.limits.rotational_stiffness_nm_per_rad) = (1200.0, 0.5);
        let (to, taken) = wanted().limited(&info, 1000.0);
        assert_eq!((to.stiffness_n_per_m, to.rotational_stiffness_nm_per_rad), (1200.0, 0.5));
        assert_eq!([taken.stiffness, taken.rotational_stiffness].map(|l| l.map(|l| l.by)), [Some(Bound::Maximum); 2]);
        let said = taken.in_words(&info, 1000.0, 1.0);
        let most = "the most that the simulated desktop device, 6 driven freedoms has";
        assert_eq!(said[0], format!("stiffness 1,200 N/m instead of 1,000,000: {most}"));
        assert_eq!(said[1], format!("rotational stiffness 0.5 Nm/rad instead of 1,000: {most}"));
    }

    /// At the usual rate, or as the loop and its delay are slower.
    #[test]
    fn a_published_stiffness_is_for_the_usual_loop_where_no_damping_is_known() {
        let limits = DeviceLimits::default().with_force_n(10.0).with_stiffness_n_per_m(500.0);
        let mine = DeviceInfo::new("mine").with_driven(Freedoms { translation: true, rotation: false });
        let held = |limits: DeviceLimits, rate_hz: f64| {
            let info = mine.clone().with_limits(limits);
            let (to, taken) = wanted().limited(&info, rate_hz);
            (to.stiffness_n_per_m, taken.in_words(&info, rate_hz, 1.0)[0].clone())
        };
        for (changed, rate_hz, expected) in [
            (limits, 1000.0, 500.0),
            (limits, 4000.0, 500.0),
            (limits, 50.0, 25.0),
            (limits.with_rate_hz(100.0), 1000.0, 50.0),
            (limits.with_rate_hz(1e-3), 1000.0, 5e-4),
            (limits.with_delay_s(1e-3), 1000.0, 500.0 / 3.0),
            (limits.with_stiffness_n_per_m(0.0), 50.0, 1e6 / 20.0),
        ] {
            let (found, said) = held(changed, rate_hz);
            assert!(is_near(found, expected), "{changed:?} at {rate_hz}: {said}");
        }
        let why = "the 500 N/m of the mine at 1,000 Hz falls in proportion, and the loop runs at 50 Hz";
        assert_eq!(held(limits, 50.0).1, format!("stiffness 25 N/m instead of 1,000,000: {why}"));
        // Nor does a rate that nobody gave.
        for limits in [limits, limits.with_stiffness_n_per_m(0.0), limits.with_damping_n_s_per_m(1.0)] {
            let [own, usual] =
                [0.0, 1000.0].map(|hz| Coupling::for_device(&mine.clone().with_limits(limits.with_rate_hz(hz))));
            assert_eq!(own, usual);
            assert!(own.stiffness_n_per_m >= 500.0, "{own:?}");
        }
    }

    #[test]
    fn a_scale_is_said() {
        let limits = DeviceLimits::default().with_force_n(10.0).with_stiffness_n_per_m(100.0);
        let info =
            DeviceInfo::new("mine").with_driven(Freedoms { translation: true, rotation: false }).with_limits(limits);
        let asked = wanted().with_stiffness_n_per_m(500.0);
        let said = asked.limited(&info, 1000.0).1.in_words(&info, 1000.0, 5.0);
        let why = "the most that the mine has, that is 500 N/m at the handle with motions scaled by 5";
        assert_eq!(said[0], format!("stiffness 100 N/m instead of 500: {why}"));
    }

    #[test]
    fn numbers_have_three_digits_and_thousands_are_apart() {
        let cases = [
            (0.0, "0"),
            (533.333, "533"),
            (1066.7, "1,067"),
            (12_345_678.0, "12,345,678"),
            (2.5, "2.5"),
            (0.000_2, "0.0002"),
            (99.96, "100"),
            (7.125, "7.12"),
        ];
        for (value, said) in cases {
            assert_eq!(in_words(value), said);
        }
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
            assert!(taken.is_empty() && taken.in_words(&options.info, 1000.0, 1.0).is_empty(), "{taken:?}");
            assert!(coupling.stiffness_n_per_m > 1000.0, "{coupling:?}");
        }
    }

    proptest! {
        /// Whatever way the handle goes, its damping takes more than spring and damper, held for a tick, can give.
        #[test]
        fn the_damping_of_the_handle_covers_the_coupling(
            v in -1.0..1.0f64, w in -10.0..10.0f64,
            b in 0.1..10.0f64, b_turn in 1e-4..1.0f64, delay in 0.0..5e-3f64,
        ) {
            let mut info = info();
            info.limits.damping_n_s_per_m = b;
            info.limits.rotational_damping_nm_s_per_rad = b_turn;
            info.limits.delay_s = delay;
            let (to, _) = wanted().limited(&info, 1000.0);
            let hold = 0.5e-3 + delay;
            let given = (to.stiffness_n_per_m * hold + to.damping_n_s_per_m) * v * v
                + (to.rotational_stiffness_nm_per_rad * hold + to.rotational_damping_nm_s_per_rad) * w * w;
            prop_assert!(given <= 0.8 * (b * v * v + b_turn * w * w) * (1.0 + 1e-9), "{to:?}");
            prop_assert!(to.stiffness_n_per_m > 0.0 && to.rotational_stiffness_nm_per_rad > 0.0);
        }
    }
}
