//! From the cap's displacement to a velocity, and from velocities to a pose.

use feeler_core::geometry::twist;
use feeler_core::geometry::twist::Matrix;
use feeler_core::{Point, Pose};
use feeler_haptics::device::DeviceError;
use feeler_haptics::Twist;

use super::options::SpaceMouseOptions;
use crate::clip::told_pose;
use crate::constants::{LONGEST_STEP_S, SPACEMOUSE};

/// The pose that the cap has moved so far.
#[derive(Debug, Clone)]
pub(super) struct Rate {
    options: SpaceMouseOptions,
    position: Point,
    rotation: Matrix,
    /// The time of the last step, the caller's clock.
    last: Option<f64>,
}

impl Rate {
    pub fn new(options: &SpaceMouseOptions) -> Rate {
        Rate { options: options.clone(), position: [0.0; 3], rotation: twist::rotation_of(&[0.0; 3]), last: None }
    }

    /// Moves the pose by the time since the last step with the present displacement of the cap (counts, the daemon's
    /// axes). A time that is not a number, or earlier than the last, moves nothing; a break longer than
    /// [`LONGEST_STEP_S`] counts as that long.
    pub fn step(&mut self, counts: &[i32; 6], now: f64) -> Result<(Pose, Twist), DeviceError> {
        let mut twist = self.twist(counts);
        let dt = self.last.map_or(0.0, |last| now - last);
        let dt = if dt > 0.0 && dt.is_finite() { dt.min(LONGEST_STEP_S) } else { 0.0 };
        self.pause(now);
        let reach = self.options.reach_m;
        for axis in 0..3 {
            let to = self.position[axis] + twist.linear[axis] * dt;
            self.position[axis] = to.clamp(-reach, reach);
            if to.abs() >= reach && twist.linear[axis] * to > 0.0 {
                twist.linear[axis] = 0.0;
            }
        }
        let turned = twist::product(&twist::rotation_of(&twist.angular.map(|w| w * dt)), &self.rotation);
        // Rounding must not pile up over hours.
        self.rotation = twist::rotation_of_quaternion(&twist::quaternion(&turned));
        Ok((told_pose(SPACEMOUSE, &self.rotation, &self.position.map(|x| x.clamp(-reach, reach)))?, twist))
    }

    /// The time goes on and the pose stays.
    pub fn pause(&mut self, now: f64) {
        if now.is_finite() {
            self.last = Some(self.last.map_or(now, |last| last.max(now)));
        }
    }

    /// The velocity that a displacement of the cap means, device frame.
    fn twist(&self, counts: &[i32; 6]) -> Twist {
        let part = counts.map(|count| self.part(count));
        let [right, up, away, about_right, about_up, about_away] = part;
        Twist {
            linear: [right, away, up].map(|x| x * self.options.speed_m_per_s),
            angular: [about_right, about_away, about_up].map(|x| x * self.options.turn_rad_per_s),
        }
    }

    /// Part of full deflection, from -1 to 1, beyond the dead zone.
    fn part(&self, count: i32) -> f64 {
        let deflection = (f64::from(count) / self.options.full_deflection_counts).clamp(-1.0, 1.0);
        let beyond = (deflection.abs() - self.options.dead_zone).max(0.0) / (1.0 - self.options.dead_zone);
        beyond.copysign(deflection)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const AXES: [usize; 6] = [0, 1, 2, 3, 4, 5];

    fn rate(change: impl Fn(&mut SpaceMouseOptions)) -> Rate {
        let mut options = SpaceMouseOptions { dead_zone: 0.0, ..Default::default() };
        change(&mut options);
        Rate::new(&options)
    }

    fn at(axis: usize, count: i32) -> [i32; 6] {
        std::array::from_fn(|i| if i == axis { count } else { 0 })
    }

    #[test]
    fn each_axis_of_the_daemon_moves_its_axis_of_the_device() {
        // Full deflection for half a second: 0.05 m, 0.5 rad.
        let moves = [[0.05, 0.0, 0.0], [0.0, 0.0, 0.05], [0.0, 0.05, 0.0]];
        let turns = [[0.5, 0.0, 0.0], [0.0, 0.0, 0.5], [0.0, 0.5, 0.0]];
        for axis in AXES {
            let mut rate = rate(|_| ());
            let mut state = rate.step(&at(axis, 350), 10.0).unwrap();
            assert_eq!(state.0, Pose::IDENTITY, "the first read has no time behind it");
            for i in 1..=500 {
                state = rate.step(&at(axis, 350), 10.0 + 1e-3 * f64::from(i)).unwrap();
            }
            let (pose, twist) = state;
            let turned = twist::rotation_vector(pose.rotation());
            let (way, turn) = if axis < 3 { (moves[axis], [0.0; 3]) } else { ([0.0; 3], turns[axis - 3]) };
            for i in 0..3 {
                assert!((pose.translation()[i] - way[i]).abs() < 1e-9, "axis {axis}: {pose:?}");
                assert!((turned[i] - turn[i]).abs() < 1e-9, "axis {axis}: {turned:?}");
                assert!((twist.linear[i] - 2.0 * way[i]).abs() < 1e-12, "axis {axis}: {twist:?}");
                assert!((twist.angular[i] - 2.0 * turn[i]).abs() < 1e-12, "axis {axis}: {twist:?}");
            }
        }
    }

    #[test]
    fn the_dead_zone_is_rest_and_begins_at_nothing() {
        let mut rate = rate(|o| o.dead_zone = 0.2);
        let mut speed = |count| rate.step(&at(0, count), 0.0).unwrap().1.linear[0];
        assert_eq!([speed(0), speed(70), speed(-70)], [0.0; 3]);
        assert!(speed(71) > 0.0 && speed(71) < 5e-4);
        assert!((speed(350) - 0.1).abs() < 1e-12 && (speed(-350) + 0.1).abs() < 1e-12);
        assert!((speed(210) - 0.05).abs() < 1e-12);
        assert_eq!(speed(300_000), speed(350), "no faster than at full deflection");
    }

    #[test]
    fn the_pose_stops_at_its_reach_and_comes_back() {
        let mut rate = rate(|o| o.reach_m = 0.01);
        for i in 0..=100 {
            rate.step(&at(0, 350), 0.05 * f64::from(i)).unwrap();
        }
        let (pose, twist) = rate.step(&at(0, 350), 5.05).unwrap();
        assert_eq!((pose.translation()[0], twist.linear[0]), (0.01, 0.0));
        let (pose, twist) = rate.step(&at(0, -350), 5.1).unwrap();
        assert!(pose.translation()[0] < 0.01 && twist.linear[0] == -0.1);
    }

    #[test]
    fn times_that_cannot_be_move_nothing() {
        let mut rate = rate(|_| ());
        rate.step(&at(0, 350), 1.0).unwrap();
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 0.5, 1.0] {
            assert_eq!(rate.step(&at(0, 350), bad).unwrap().0, Pose::IDENTITY, "{bad}");
        }
        let (pose, _) = rate.step(&at(0, 350), 1000.0).unwrap();
        assert!((pose.translation()[0] - 0.1 * LONGEST_STEP_S).abs() < 1e-12, "a break is no leap: {pose:?}");
    }

    #[test]
    fn a_pause_is_no_motion() {
        let mut rate = rate(|_| ());
        rate.step(&at(0, 350), 0.0).unwrap();
        rate.pause(0.09);
        let (pose, _) = rate.step(&at(0, 350), 0.1).unwrap();
        assert!((pose.translation()[0] - 0.001).abs() < 1e-12, "{pose:?}");
    }

    #[test]
    fn a_rotation_stays_one_for_hours() {
        let mut rate = rate(|_| ());
        let counts = [0, 0, 0, 350, -200, 77];
        let mut pose = Pose::IDENTITY;
        for i in 0..1_000_000 {
            pose = rate.step(&counts, 1e-2 * f64::from(i)).unwrap().0;
        }
        let r = pose.rotation();
        let square = twist::product(&twist::transposed(r), r);
        assert!((0..3).all(|i| (square[i][i] - 1.0).abs() < 1e-14), "{square:?}");
    }
}
