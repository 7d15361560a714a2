//! The virtual coupling: a spring and a damper between the device's pose and the proxy.
//!
//! Colgate, Stanley and Brown, *Issues in the Haptic Display of Tool Use*, IROS 1995; in rotation the spring's torque
//! is along the rotation vector between the two (the logarithm of the quaternion), which is minus the gradient of `k
//! |v|^2 / 2`, so that no closed motion gains or loses energy by it.

use feeler_core::geometry::twist::{displacement, Twist, Wrench};
use feeler_core::geometry::vectors::{length, scaled, sub};
use feeler_core::{Point, Pose};

use crate::constants::{
    FULL_FORCE_AT_M, FULL_FORCE_IN_S, FULL_TORQUE_AT_RAD, LARGEST_DAMPING, LARGEST_SLEW, LARGEST_STIFFNESS,
    LARGEST_WRENCH, UNKNOWN_SHARE, VIRTUAL_DAMPING_SHARE,
};
use crate::device::DeviceInfo;
use crate::error::{Error, Result};

/// How the hand is held to the tool. The default suits a desktop device of 8 N at 1 kHz;
/// [`for_device`](Self::for_device) suits another, and [`limited`](Self::limited) limits any coupling to what a device
/// holds.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Coupling {
    /// Of the spring of translation, where the hand holds the tool ([`Session::centre`](crate::Session::centre)), newtons a metre.
    pub stiffness_n_per_m: f64,
    /// Of the damper beside it, newton seconds a metre.
    pub damping_n_s_per_m: f64,
    /// Of the spring of rotation, newton metres a radian.
    pub rotational_stiffness_nm_per_rad: f64,
    /// Of the damper beside it, newton metre seconds a radian.
    pub rotational_damping_nm_s_per_rad: f64,
    /// Largest force, newtons: the spring stretches on at this force.
    pub max_force_n: f64,
    /// Largest torque of the spring of rotation, newton metres.
    pub max_torque_nm: f64,
    /// Largest change of the force, newtons a second: of the length of the change, whatever its direction.
    pub slew_n_per_s: f64,
    /// Largest change of the torque, newton metres a second.
    pub slew_nm_per_s: f64,
}

impl Default for Coupling {
    fn default() -> Coupling {
        Coupling {
            stiffness_n_per_m: 1000.0,
            damping_n_s_per_m: 0.1,
            rotational_stiffness_nm_per_rad: 2.0,
            rotational_damping_nm_s_per_rad: 2e-4,
            max_force_n: 8.0,
            max_torque_nm: 0.3,
            slew_n_per_s: 2000.0,
            slew_nm_per_s: 75.0,
        }
    }
}

impl Coupling {
    feeler_core::setters! {
        with_stiffness_n_per_m: stiffness_n_per_m: f64,
        with_damping_n_s_per_m: damping_n_s_per_m: f64,
        with_rotational_stiffness_nm_per_rad: rotational_stiffness_nm_per_rad: f64,
        with_rotational_damping_nm_s_per_rad: rotational_damping_nm_s_per_rad: f64,
        with_max_force_n: max_force_n: f64,
        with_max_torque_nm: max_torque_nm: f64,
        with_slew_n_per_s: slew_n_per_s: f64,
        with_slew_nm_per_s: slew_nm_per_s: f64,
    }
}

impl Coupling {
    /// How far from the held point a turn is as stiff as a way, metres; not finite, or 0, where one of the two springs pulls not at all.
    pub fn lever_m(&self) -> f64 {
        (self.rotational_stiffness_nm_per_rad / self.stiffness_n_per_m).sqrt()
    }

    /// Errors when a number is not finite, negative, or so large that its unit must be wrong; slews may not be zero.
    pub fn check(&self) -> Result<()> {
        let ranges = [
            ("stiffness_n_per_m", self.stiffness_n_per_m, LARGEST_STIFFNESS, "between 0 and 1e7 N/m"),
            ("damping_n_s_per_m", self.damping_n_s_per_m, LARGEST_DAMPING, "between 0 and 1e5 N s/m"),
            (
                "rotational_stiffness_nm_per_rad",
                self.rotational_stiffness_nm_per_rad,
                LARGEST_STIFFNESS,
                "between 0 and 1e7 Nm/rad",
            ),
            (
                "rotational_damping_nm_s_per_rad",
                self.rotational_damping_nm_s_per_rad,
                LARGEST_DAMPING,
                "between 0 and 1e5 Nm s/rad",
            ),
            ("max_force_n", self.max_force_n, LARGEST_WRENCH, "between 0 and 1e4 N"),
            ("max_torque_nm", self.max_torque_nm, LARGEST_WRENCH, "between 0 and 1e4 Nm"),
            ("slew_n_per_s", self.slew_n_per_s, LARGEST_SLEW, "above 0 and at most 1e8 N/s"),
            ("slew_nm_per_s", self.slew_nm_per_s, LARGEST_SLEW, "above 0 and at most 1e8 Nm/s"),
        ];
        for (what, value, most, range) in ranges {
            let is_slew = what.starts_with("slew");
            if !(0.0..=most).contains(&value) || is_slew && value == 0.0 {
                return Err(Error::Option { what, value, range });
            }
        }
        Ok(())
    }

    /// The stiffest useful coupling that a device can hold at its own rate (1 kHz if that is not known): full force at 2 mm or 0.05 rad, less if [`limited`](Self::limited) requires it. A fifth of
    /// that if neither damping nor largest stiffness is known.
    pub fn for_device(info: &DeviceInfo) -> Coupling {
        let limits = &info.limits;
        let share = |damping: f64, stiffness: f64| if damping == 0.0 && stiffness == 0.0 { UNKNOWN_SHARE } else { 1.0 };
        let linear = share(limits.damping_n_s_per_m, limits.stiffness_n_per_m);
        let angular = share(limits.rotational_damping_nm_s_per_rad, limits.rotational_stiffness_nm_per_rad);
        let slew = |most: f64| (most / FULL_FORCE_IN_S).clamp(f64::MIN_POSITIVE, LARGEST_SLEW);
        let wanted = Coupling {
            stiffness_n_per_m: linear * limits.force_n / FULL_FORCE_AT_M,
            damping_n_s_per_m: VIRTUAL_DAMPING_SHARE * limits.damping_n_s_per_m,
            rotational_stiffness_nm_per_rad: angular * limits.torque_nm / FULL_TORQUE_AT_RAD,
            rotational_damping_nm_s_per_rad: VIRTUAL_DAMPING_SHARE * limits.rotational_damping_nm_s_per_rad,
            max_force_n: limits.force_n,
            max_torque_nm: limits.torque_nm,
            slew_n_per_s: slew(limits.force_n),
            slew_nm_per_s: slew(limits.torque_nm),
        };
        wanted.limited(info, limits.own_rate_hz()).0
    }

    /// The wrench on the hand, world axes, the torque about the hand.
    ///
    /// `device`, `proxy`: both `world_from_hand`, the tool's frame with its origin where the hand holds the tool, and there the
    /// springs act. `device_twist`, `proxy_twist`: each at that origin, world axes. The spring of translation pulls at most with
    /// `max_force_n` and that of rotation with `max_torque_nm`; the dampers add to that: forces for a device go through
    /// the force loop. At half a turn between the two the torque changes its sign.
    pub fn wrench(&self, device: &Pose, device_twist: &Twist, proxy: &Pose, proxy_twist: &Twist) -> Wrench {
        let stretch = displacement(device, proxy, &[0.0; 3]);
        let rate = *proxy_twist - *device_twist;
        let spring = Wrench {
            force: pull(self.stiffness_n_per_m, self.max_force_n, &stretch.linear),
            torque: pull(self.rotational_stiffness_nm_per_rad, self.max_torque_nm, &stretch.angular),
        };
        let damper = Wrench {
            force: scaled(&rate.linear, self.damping_n_s_per_m),
            torque: scaled(&rate.angular, self.rotational_damping_nm_s_per_rad),
        };
        spring + damper
    }

    /// The force of the spring of translation alone; arguments as of [`wrench`](Self::wrench).
    pub(crate) fn spring_force(&self, device: &Pose, proxy: &Pose) -> Point {
        pull(self.stiffness_n_per_m, self.max_force_n, &sub(proxy.translation(), device.translation()))
    }

    /// The energy in the two springs, joules; arguments as of [`wrench`](Self::wrench).
    pub fn energy_j(&self, device: &Pose, proxy: &Pose) -> f64 {
        let stretch = displacement(device, proxy, &[0.0; 3]);
        stored(self.stiffness_n_per_m, self.max_force_n, length(&stretch.linear))
            + stored(self.rotational_stiffness_nm_per_rad, self.max_torque_nm, length(&stretch.angular))
    }
}

/// A spring's pull along its stretch, at most `most`.
fn pull(stiffness: f64, most: f64, stretch: &Point) -> Point {
    let by = stiffness * length(stretch);
    scaled(stretch, if by > most { stiffness * (most / by) } else { stiffness })
}

/// The energy of such a spring: a parabola, and a straight line from where it pulls with `most`.
fn stored(stiffness: f64, most: f64, stretch: f64) -> f64 {
    let whole = stiffness * stretch;
    if whole > most {
        most * (stretch - 0.5 * most / stiffness)
    } else {
        0.5 * whole * stretch
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use feeler_core::geometry::twist::{displaced, pose_of, rotation_of};
    use feeler_core::geometry::vectors::dot;
    use proptest::prelude::*;

    fn vector(most: f64) -> impl Strategy<Value = Point> {
        prop::array::uniform3(-most..most)
    }

    fn springs(max_force_n: f64, max_torque_nm: f64) -> Coupling {
        Coupling {
            stiffness_n_per_m: 700.0,
            damping_n_s_per_m: 0.0,
            rotational_stiffness_nm_per_rad: 3.0,
            rotational_damping_nm_s_per_rad: 0.0,
            max_force_n,
            max_torque_nm,
            ..Coupling::default()
        }
    }

    fn near(a: &Wrench, b: &Wrench) -> bool {
        let off = *a - *b;
        length(&off.force) < 1e-12 && length(&off.torque) < 1e-12
    }

    #[test]
    fn the_hand_is_drawn_to_the_proxy() {
        let coupling = springs(100.0, 100.0);
        for place in [[0.0; 3], [5.0, 3.0, 0.0]] {
            let device = Pose::IDENTITY.translated(&place).unwrap();
            let at_rest = |proxy: &Pose| coupling.wrench(&device, &Twist::ZERO, proxy, &Twist::ZERO);
            let found = at_rest(&device.translated(&[0.0, 0.0, 0.001]).unwrap());
            assert!(near(&found, &Wrench { force: [0.0, 0.0, 0.7], torque: [0.0; 3] }), "{found:?}");
            let found = at_rest(&pose_of(&rotation_of(&[0.0, 0.0, 0.1]), &place).unwrap());
            assert!(near(&found, &Wrench { force: [0.0; 3], torque: [0.0, 0.0, 0.3] }), "{found:?}");
        }
    }

    #[test]
    fn a_spring_pulls_with_its_largest_force_at_the_most() {
        let coupling = springs(2.0, 0.5);
        let far = pose_of(&rotation_of(&[0.0, 0.6, 0.8]), &[0.0, 3.0, 4.0]).unwrap();
        let found = coupling.wrench(&Pose::IDENTITY, &Twist::ZERO, &far, &Twist::ZERO);
        assert!(near(&found, &Wrench { force: [0.0, 1.2, 1.6], torque: [0.0, 0.3, 0.4] }), "{found:?}");
    }

    proptest! {
        /// Virtual work: the power on the hand and on the proxy is the loss of the springs, also where they pull with all
        /// they may.
        #[test]
        fn power_is_minus_the_rate_of_the_energy(
            turns in (vector(0.7), vector(0.7)), places in (vector(0.01), vector(0.01)),
            motion in (vector(1.0), vector(1.0)), most in (0.5..20.0f64, 0.1..5.0f64),
        ) {
            let coupling = springs(most.0, most.1);
            let device = pose_of(&rotation_of(&turns.0), &places.0).unwrap();
            let proxy = pose_of(&rotation_of(&turns.1), &places.1).unwrap();
            let twist = Twist { linear: motion.0, angular: motion.1 };
            let h = 1e-6;
            let later = |pose: &Pose, by: f64| displaced(pose, &(twist * by), &[0.0; 3]).unwrap();
            let energy = |by: f64| coupling.energy_j(&later(&device, by), &proxy);
            let rate = (energy(h) - energy(-h)) / (2.0 * h);
            let power = coupling.wrench(&device, &Twist::ZERO, &proxy, &Twist::ZERO).power(&twist);
            prop_assert!((rate + power).abs() < 1e-4 * (1.0 + power.abs()), "{rate} {power}");
            // The proxy is drawn with the opposite wrench, at its own origin.
            let energy = |by: f64| coupling.energy_j(&device, &later(&proxy, by));
            let rate = (energy(h) - energy(-h)) / (2.0 * h);
            let power = coupling.wrench(&proxy, &Twist::ZERO, &device, &Twist::ZERO).power(&twist);
            prop_assert!((rate + power).abs() < 1e-4 * (1.0 + power.abs()), "{rate} {power}");
        }

        /// The dampers take power from any motion of the two against each other, and none from one motion of both.
        #[test]
        fn dampers_take_power(turn in vector(1.5), motion in (vector(1.0), vector(1.0))) {
            let coupling =
                Coupling { damping_n_s_per_m: 2.0, rotational_damping_nm_s_per_rad: 0.1, ..springs(10.0, 10.0) };
            let pose = pose_of(&rotation_of(&turn), &[0.3, 0.2, 0.1]).unwrap();
            let twist = Twist { linear: motion.0, angular: motion.1 };
            let together = coupling.wrench(&pose, &twist, &pose, &twist);
            prop_assert!(near(&together, &Wrench::ZERO), "{together:?}");
            let lost = 2.0 * dot(&twist.linear, &twist.linear) + 0.1 * dot(&twist.angular, &twist.angular);
            let power = coupling.wrench(&pose, &twist, &pose, &Twist::ZERO).power(&twist);
            prop_assert!((power + lost).abs() < 1e-12 * (1.0 + lost), "{power} {lost}");
        }
    }

    #[test]
    fn what_cannot_be_meant_is_refused() {
        assert_eq!(Coupling::default().check(), Ok(()));
        let change: [fn(&mut Coupling, f64); 8] = [
            |c, x| c.stiffness_n_per_m = x,
            |c, x| c.damping_n_s_per_m = x,
            |c, x| c.rotational_stiffness_nm_per_rad = x,
            |c, x| c.rotational_damping_nm_s_per_rad = x,
            |c, x| c.max_force_n = x,
            |c, x| c.max_torque_nm = x,
            |c, x| c.slew_n_per_s = x,
            |c, x| c.slew_nm_per_s = x,
        ];
        for (field, change) in change.into_iter().enumerate() {
            for value in [f64::NAN, f64::INFINITY, -1.0, 1e9] {
                let mut coupling = Coupling::default();
                change(&mut coupling, value);
                assert!(coupling.check().is_err(), "field {field}: {value}");
            }
            let mut coupling = Coupling::default();
            change(&mut coupling, 0.0);
            assert_eq!(coupling.check().is_err(), field >= 6, "field {field}");
        }
    }
}
