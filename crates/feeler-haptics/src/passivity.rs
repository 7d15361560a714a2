//! The passivity observer and controller: damps away the energy that the coupling gives the hand beyond what it took.
//!
//! B. Hannaford and J.-H. Ryu, *Time-Domain Passivity Control of Haptic Interfaces*, IEEE Trans. Robotics and
//! Automation 18(1), 2002, with the energy of a held force over each sample (J.-H. Ryu, Y. S. Kim and B. Hannaford,
//! *Sampled- and Continuous-Time Passivity and Stability of Virtual Environments*, IEEE Trans. Robotics 20(4), 2004),
//! which is exact, and a reference (J.-H. Ryu, C. Preusche, B. Hannaford and G. Hirzinger, *Time Domain Passivity
//! Control with Reference Energy Following*, IEEE Trans. Control Systems Technology 13(5), 2005): the energy in the
//! coupling's springs is known and set aside, so that the energy of a deep spring does not hide that of a vibration.
//! The six degrees of freedom are one port of one energy, as in C. Preusche, G. Hirzinger, J.-H. Ryu and B. Hannaford,
//! *Time Domain Passivity Control for 6 Degrees of Freedom Haptic Displays*, IROS 2003: the damping is shared among
//! them like the device's own, and a resting one gets none.
//!
//! The policy: the balance counts energy taken from the hand for good (a *surplus*), or given without having been taken
//! (a *deficit*). A surplus decays, so that old losses do not pay for new gains. A deficit stays during contact, decays
//! quickly in the air, so that air does not feel thick, and never exceeds the energy of the springs at full force. The
//! damping is bounded, so that its force goes to zero with the velocity: no chatter at rest.

use feeler_core::geometry::twist::{Twist, Wrench};
use feeler_core::geometry::vectors::{dot, scaled};

use crate::constants::{DEFICIT_LEAK_S, SURPLUS_LEAK_S};

/// The books of one port, and the damper that balances them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Passivity {
    damping: f64,
    rotational_damping: f64,
    largest_deficit: f64,
    surplus: f64,
}

impl Passivity {
    /// `damping_n_s_per_m` and `rotational_damping_nm_s_per_rad`: the most that the controller may damp with; zero in a
    /// freedom that is not driven. `largest_deficit_j`: no deficit is booked beyond it, joules.
    pub fn new(damping_n_s_per_m: f64, rotational_damping_nm_s_per_rad: f64, largest_deficit_j: f64) -> Passivity {
        Passivity {
            damping: damping_n_s_per_m,
            rotational_damping: rotational_damping_nm_s_per_rad,
            largest_deficit: largest_deficit_j,
            surplus: 0.0,
        }
    }

    /// Other bounds, as of [`new`](Self::new), with the same energy balance.
    pub fn bound(&mut self, damping_n_s_per_m: f64, rotational_damping_nm_s_per_rad: f64, largest_deficit_j: f64) {
        let surplus = self.surplus.max(-largest_deficit_j);
        *self = Passivity {
            surplus,
            ..Passivity::new(damping_n_s_per_m, rotational_damping_nm_s_per_rad, largest_deficit_j)
        };
    }

    /// Books a tick of `dt` seconds that is over. `taken_j`: the hand's work against the wrench that was held in it,
    /// joules. `stored_j`: how much the springs hold more than before. `is_free`: nothing was touched.
    pub fn observe(&mut self, taken_j: f64, stored_j: f64, dt: f64, is_free: bool) {
        let surplus = self.surplus + (taken_j - stored_j);
        let kept = match surplus > 0.0 {
            true => leaked(dt, SURPLUS_LEAK_S),
            false if is_free => leaked(dt, DEFICIT_LEAK_S),
            false => 1.0,
        };
        self.surplus = (surplus * kept).max(-self.largest_deficit);
    }

    /// The wrench that takes the deficit's `share` and `expected_j` (joules, not negative: what the coming tick will
    /// give) from a motion in `dt` seconds, or as much of them as the bound allows: against the twist, zero where there
    /// is nothing to take or no motion. Twist and wrench at one point.
    pub fn damping(&self, twist: &Twist, share: f64, expected_j: f64, dt: f64) -> Wrench {
        let (linear, angular) = (self.damping, self.rotational_damping);
        let most = (linear * dot(&twist.linear, &twist.linear) + angular * dot(&twist.angular, &twist.angular)) * dt;
        let wanted = expected_j - share * self.surplus;
        if wanted <= 0.0 || most <= 0.0 {
            return Wrench::ZERO;
        }
        let by = (wanted / most).min(1.0);
        Wrench { force: scaled(&twist.linear, -by * linear), torque: scaled(&twist.angular, -by * angular) }
    }

    /// Energy taken from the hand for good, joules; negative: given to it.
    pub fn surplus_j(&self) -> f64 {
        self.surplus
    }

    /// New books.
    pub fn reset(&mut self) {
        self.surplus = 0.0;
    }
}

/// The share left after a time, at a time constant.
fn leaked(dt: f64, constant: f64) -> f64 {
    constant / (constant + dt)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const TICK: f64 = 1e-3;

    fn twist(v: f64, w: f64) -> Twist {
        Twist { linear: [0.6 * v, 0.0, 0.8 * v], angular: [0.0, w, 0.0] }
    }

    #[test]
    fn a_deficit_is_paid_and_a_surplus_is_not() {
        let mut books = Passivity::new(2.0, 0.1, 1.0);
        assert_eq!(books.damping(&twist(0.1, 1.0), 1.0, 0.0, TICK), Wrench::ZERO);
        books.observe(-3e-5, 0.0, TICK, false);
        assert_eq!(books.surplus_j(), -3e-5);
        // At most 2 * 0.1^2 + 0.1 * 1^2 = 0.12 W, so a quarter of it.
        let motion = twist(0.1, 1.0);
        let paid = books.damping(&motion, 1.0, 0.0, TICK);
        assert!((paid.power(&motion) * TICK + 3e-5).abs() < 1e-15, "{paid:?}");
        assert!((paid.torque[1] + 0.25 * 0.1).abs() < 1e-12);
        assert!((books.damping(&motion, 0.5, 1e-5, TICK).power(&motion) * TICK + 2.5e-5).abs() < 1e-15);
        books.observe(4e-5, 0.0, TICK, false);
        assert!(books.surplus_j() > 0.0);
        assert_eq!(books.damping(&motion, 1.0, 0.0, TICK), Wrench::ZERO);
        // The energy in the spring is not lost, and the energy that it gives back is not gained.
        books.reset();
        books.observe(1.0, 1.0, TICK, false);
        books.observe(-1.0, -1.0, TICK, false);
        assert_eq!(books.surplus_j(), 0.0);
    }

    #[test]
    fn a_surplus_leaks_and_a_deficit_is_forgiven_in_the_air() {
        let after = |start: f64, is_free: bool| {
            let mut books = Passivity::new(1.0, 0.0, 1.0);
            books.observe(start, 0.0, TICK, false);
            (0..500).for_each(|_| books.observe(0.0, 0.0, TICK, is_free));
            books.surplus_j()
        };
        assert!((0.0..0.01).contains(&after(1.0, false)));
        assert_eq!(after(-0.5, false), -0.5);
        assert!((-1e-4..0.0).contains(&after(-0.5, true)));
        assert_eq!(after(-100.0, false), -1.0);
    }

    proptest! {
        /// Never more than the damping it has, never against the motion's wrong side, and nothing at rest.
        #[test]
        fn damping_is_bounded(deficit in 0.0..10.0f64, v in -5.0..5.0f64, w in -50.0..50.0f64, zoom in -12..1i32) {
            let mut books = Passivity::new(2.0, 0.1, 10.0);
            books.observe(-deficit, 0.0, TICK, false);
            let zoom = 10f64.powi(zoom);
            let found = books.damping(&twist(v * zoom, w * zoom), 1.0, 0.0, TICK);
            prop_assert!(found.is_finite());
            prop_assert!(dot(&found.force, &found.force).sqrt() <= 2.0 * v.abs() * zoom * (1.0 + 1e-12));
            prop_assert!(found.torque[1].abs() <= 0.1 * w.abs() * zoom * (1.0 + 1e-12));
            prop_assert!(found.power(&twist(v, w)) <= 0.0);
        }
    }
}
