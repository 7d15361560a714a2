//! A hand on a simulated device: its target, and its compliance.

use feeler_core::geometry::twist::{displaced, displacement, Twist};
use feeler_core::Pose;

use crate::constants::LARGEST_STIFFNESS;
use crate::error::{Error, Result};

/// Where a hand wants the handle to be over time, `device_from_handle`: poses at times, between them a straight way and
/// an even turn, before the first and after the last at rest.
#[derive(Debug, Clone, PartialEq)]
pub struct HandPath {
    keys: Vec<(f64, Pose)>,
}

impl HandPath {
    /// At rest.
    pub fn constant(pose: Pose) -> HandPath {
        HandPath { keys: vec![(0.0, pose)] }
    }

    /// Of times (seconds since the device's first tick) and poses. Errors where there is none, or times are not finite
    /// and ascending.
    pub fn new(keys: Vec<(f64, Pose)>) -> Result<HandPath> {
        if keys.is_empty() {
            return Err(Error::Option { what: "number of poses of a hand's path", value: 0.0, range: "at least 1" });
        }
        let mut before = f64::NEG_INFINITY;
        for (time, _) in &keys {
            if !(time.is_finite() && *time > before) {
                return Err(Error::Option {
                    what: "time of a hand's path",
                    value: *time,
                    range: "finite, and later than the one before",
                });
            }
            before = *time;
        }
        Ok(HandPath { keys })
    }

    /// Pose and twist at a time, the twist at the handle's origin.
    pub fn at(&self, time: f64) -> (Pose, Twist) {
        let next = self.keys.partition_point(|(t, _)| *t <= time);
        let last = self.keys.len() - 1;
        if next == 0 || next > last {
            return (self.keys[next.min(last)].1, Twist::ZERO);
        }
        let ((t0, from), (t1, to)) = (&self.keys[next - 1], &self.keys[next]);
        let whole = displacement(from, to, &[0.0; 3]);
        let pose = displaced(from, &(whole * ((time - t0) / (t1 - t0))), &[0.0; 3]).unwrap_or(*from);
        (pose, whole * (1.0 / (t1 - t0)))
    }

    /// When the last pose is reached, seconds.
    pub fn end(&self) -> f64 {
        self.keys[self.keys.len() - 1].0
    }
}

/// A hand's stiffness, damping and mass about its path. The mass is on the handle, spring and damper are between it and
/// the path: pushed, it gives way and comes back.
#[derive(Debug, Clone, PartialEq)]
pub struct Hand {
    /// Where it wants to be.
    pub path: HandPath,
    /// Newtons a metre. Relaxed 50, firm 500.
    pub stiffness_n_per_m: f64,
    /// Newton seconds a metre.
    pub damping_n_s_per_m: f64,
    /// Kilograms that move with the handle.
    pub mass_kg: f64,
    /// Newton metres a radian.
    pub rotational_stiffness_nm_per_rad: f64,
    /// Newton metre seconds a radian.
    pub rotational_damping_nm_s_per_rad: f64,
    /// Kilogram square metres that turn with the handle.
    pub inertia_kg_m2: f64,
}

impl Hand {
    /// An adult's hand, holding firmly: 400 N/m, 4 N s/m, 150 g, 3 Nm/rad.
    pub fn firm(path: HandPath) -> Hand {
        Hand {
            path,
            stiffness_n_per_m: 400.0,
            damping_n_s_per_m: 4.0,
            mass_kg: 0.15,
            rotational_stiffness_nm_per_rad: 3.0,
            rotational_damping_nm_s_per_rad: 0.03,
            inertia_kg_m2: 2e-4,
        }
    }

    /// An adult's hand, holding loosely: 60 N/m, 1.5 N s/m, 80 g, 0.5 Nm/rad.
    pub fn loose(path: HandPath) -> Hand {
        Hand {
            stiffness_n_per_m: 60.0,
            damping_n_s_per_m: 1.5,
            mass_kg: 0.08,
            rotational_stiffness_nm_per_rad: 0.5,
            rotational_damping_nm_s_per_rad: 0.01,
            inertia_kg_m2: 1e-4,
            ..Hand::firm(path)
        }
    }

    /// Errors where a number is not finite, or negative.
    pub fn check(&self) -> Result<()> {
        let numbers = [
            ("stiffness of the hand", self.stiffness_n_per_m),
            ("damping of the hand", self.damping_n_s_per_m),
            ("mass of the hand", self.mass_kg),
            ("rotational stiffness of the hand", self.rotational_stiffness_nm_per_rad),
            ("rotational damping of the hand", self.rotational_damping_nm_s_per_rad),
            ("inertia of the hand", self.inertia_kg_m2),
        ];
        match numbers.into_iter().find(|(_, value)| !(0.0..=LARGEST_STIFFNESS).contains(value)) {
            Some((what, value)) => Err(Error::Option { what, value, range: "between 0 and 1e7" }),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use feeler_core::geometry::twist::{pose_of, rotation_of};

    #[test]
    fn a_path_is_even_between_its_poses_and_at_rest_outside() {
        let turn = rotation_of(&[0.0, 0.0, 1.0]);
        let there = pose_of(&turn, &[0.1, 0.0, 0.2]).unwrap();
        let path = HandPath::new(vec![(1.0, Pose::IDENTITY), (3.0, there)]).unwrap();
        assert_eq!(path.at(0.5), (Pose::IDENTITY, Twist::ZERO));
        assert_eq!(path.at(3.5), (there, Twist::ZERO));
        let (pose, twist) = path.at(1.5);
        let gone = displacement(&Pose::IDENTITY, &pose, &[0.0; 3]);
        for (found, expected) in gone.as_array().iter().zip([0.025, 0.0, 0.05, 0.0, 0.0, 0.25]) {
            assert!((found - expected).abs() < 1e-12, "{gone:?}");
        }
        for (found, expected) in twist.as_array().iter().zip([0.05, 0.0, 0.1, 0.0, 0.0, 0.5]) {
            assert!((found - expected).abs() < 1e-12, "{twist:?}");
        }
    }

    #[test]
    fn a_path_without_order_is_refused() {
        let key = |t: f64| (t, Pose::IDENTITY);
        assert!(HandPath::new(vec![]).is_err());
        for times in [[0.0, 0.0], [1.0, 0.5], [0.0, f64::NAN], [0.0, f64::INFINITY]] {
            assert!(HandPath::new(times.map(key).to_vec()).is_err(), "{times:?}");
        }
        assert!(HandPath::new([0.0, 0.5].map(key).to_vec()).is_ok());
        let mut hand = Hand::firm(HandPath::constant(Pose::IDENTITY));
        assert!(hand.check().is_ok());
        hand.mass_kg = f64::NAN;
        assert!(hand.check().is_err());
    }
}
