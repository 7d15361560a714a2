//! The velocity of a device that reports only its pose.
//!
//! F. Janabi-Sharifi, V. Hayward and C.-S. J. Chen, *Discrete-Time Adaptive Windowing for Velocity Estimation*, IEEE
//! Trans. Control Systems Technology 8(6), 2000, the end-fit form: the longest window whose chord is within the
//! resolution of every pose in it. Slow motions are averaged over many poses, fast ones use the last two, without a
//! filter's lag.

use feeler_core::geometry::twist::{quaternion, Twist};
use feeler_core::geometry::vectors::{along, dot, length, scaled, sub};
use feeler_core::{Point, Pose};

use crate::constants::VELOCITY_WINDOW;

/// Finds a twist from poses and their times. Translation and rotation have a window each.
#[derive(Debug, Clone, PartialEq)]
pub struct VelocityEstimate {
    resolution_m: f64,
    resolution_rad: f64,
    /// The newest is at `newest`, older ones before it, round and round.
    places: [Point; VELOCITY_WINDOW],
    /// Unit quaternions.
    turns: [[f64; 4]; VELOCITY_WINDOW],
    times: [f64; VELOCITY_WINDOW],
    newest: usize,
    count: usize,
    twist: Twist,
}

impl VelocityEstimate {
    /// `resolution_m`, `resolution_rad`: the steps of the device's reported pose, or its noise.
    pub fn new(resolution_m: f64, resolution_rad: f64) -> VelocityEstimate {
        VelocityEstimate {
            resolution_m,
            resolution_rad,
            places: [[0.0; 3]; VELOCITY_WINDOW],
            turns: [[1.0, 0.0, 0.0, 0.0]; VELOCITY_WINDOW],
            times: [0.0; VELOCITY_WINDOW],
            newest: 0,
            count: 0,
            twist: Twist::ZERO,
        }
    }

    /// The twist at the pose's origin, world axes, after a pose and the time it was measured at, seconds. A time that
    /// is not later than the last one brings nothing new.
    pub fn update(&mut self, pose: &Pose, time: f64) -> Twist {
        if !time.is_finite() || self.count > 0 && time <= self.times[self.newest] {
            return self.twist;
        }
        self.newest = (self.newest + 1) % VELOCITY_WINDOW;
        let (place, turn) = (*pose.translation(), quaternion(pose.rotation()));
        self.places[self.newest] = place;
        self.turns[self.newest] = turn;
        self.times[self.newest] = time;
        self.count = (self.count + 1).min(VELOCITY_WINDOW);

        // What has happened since, and how long ago that is, from one before the newest on.
        let before = |i: usize| (self.newest + VELOCITY_WINDOW - i) % VELOCITY_WINDOW;
        let moved = |i: usize| (sub(&place, &self.places[before(i)]), time - self.times[before(i)]);
        let turned = |i: usize| (turn_between(&self.turns[before(i)], &turn), time - self.times[before(i)]);
        self.twist = Twist {
            linear: end_fit(moved, self.count, self.resolution_m),
            angular: end_fit(turned, self.count, self.resolution_rad),
        };
        self.twist
    }

    /// Forgets all poses.
    pub fn reset(&mut self) {
        *self = VelocityEstimate::new(self.resolution_m, self.resolution_rad);
    }
}

/// The slope of the longest chord from now into the past that no value between strays from by more than `resolution`.
fn end_fit(since: impl Fn(usize) -> (Point, f64), count: usize, resolution: f64) -> Point {
    let mut seen = [([0.0; 3], 0.0); VELOCITY_WINDOW];
    let mut best = [0.0; 3];
    for i in 1..count {
        let (way, age) = since(i);
        let slope = scaled(&way, 1.0 / age);
        let strays = |(way, age): &(Point, f64)| {
            let off = along(&scaled(way, -1.0), *age, &slope);
            dot(&off, &off) > resolution * resolution
        };
        if seen[1..i].iter().any(strays) {
            break;
        }
        seen[i] = (way, age);
        best = slope;
    }
    best
}

/// The rotation vector from one unit quaternion to another, the shorter way round.
fn turn_between(from: &[f64; 4], to: &[f64; 4]) -> Point {
    let ([a, b, c, d], [w, x, y, z]) = (*from, *to);
    // to times the inverse of from.
    let cosine = w * a + x * b + y * c + z * d;
    let axis = [x * a - w * b - y * d + z * c, y * a - w * c - z * b + x * d, z * a - w * d - x * c + y * b];
    let sine = length(&axis);
    if sine == 0.0 {
        return [0.0; 3];
    }
    scaled(&axis, 2.0 * sine.atan2(cosine.abs()) * cosine.signum() / sine)
}

#[cfg(test)]
mod tests {
    use super::*;
    use feeler_core::geometry::twist::{pose_of, rotation_of};

    const STEP: f64 = 1e-5;
    const TURN: f64 = 1e-4;

    fn told(x: f64, angle: f64) -> Pose {
        let rounded = |value: f64, step: f64| (value / step).round() * step;
        pose_of(&rotation_of(&[0.0, rounded(angle, TURN), 0.0]), &[rounded(x, STEP), 0.0, 0.0]).unwrap()
    }

    /// The largest errors of an even motion after the window is full.
    fn errors(speed: f64, rate: f64, tick: f64) -> (f64, f64) {
        let mut estimate = VelocityEstimate::new(STEP, TURN);
        let mut worst = (0.0f64, 0.0f64);
        for k in 0..300 {
            let time = k as f64 * tick;
            let found = estimate.update(&told(speed * time, rate * time), time);
            if k > VELOCITY_WINDOW {
                worst.0 = worst.0.max(length(&sub(&found.linear, &[speed, 0.0, 0.0])));
                worst.1 = worst.1.max(length(&sub(&found.angular, &[0.0, rate, 0.0])));
            }
        }
        worst
    }

    #[test]
    fn even_motions_are_told_over_the_whole_window() {
        // Two rounded ends, over 15 ticks: a difference of two poses would be off by up to 0.01 m/s and 0.1 rad/s.
        for (speed, rate) in [(0.0037, 0.041), (0.0821, 1.13), (0.73, 7.7)] {
            let (linear, angular) = errors(speed, rate, 1e-3);
            assert!(linear <= 1.01 * STEP / 0.015, "{speed}: {linear}");
            assert!(angular <= 1.01 * TURN / 0.015, "{rate}: {angular}");
        }
    }

    #[test]
    fn a_start_is_told_at_once() {
        let mut estimate = VelocityEstimate::new(STEP, TURN);
        for k in 0..100 {
            estimate.update(&told(0.0, 0.0), k as f64 * 1e-3);
        }
        // A chord over a rest and two ticks of motion would be far from the pose in between.
        estimate.update(&told(1e-3, 0.01), 0.1);
        let found = estimate.update(&told(2e-3, 0.02), 0.101);
        assert!((found.linear[0] - 1.0).abs() < 0.011 && (found.angular[1] - 10.0).abs() < 0.11, "{found:?}");
    }

    #[test]
    fn turns_between_quaternions_are_those_between_rotations() {
        use feeler_core::geometry::twist::{product, rotation_vector, transposed};
        for (a, b) in [([0.3, -0.2, 0.9], [1.0, 0.4, -0.8]), ([3.0, 0.0, 0.1], [-3.0, 0.1, 0.0]), ([0.1; 3], [0.1; 3])]
        {
            let (from, to) = (rotation_of(&a), rotation_of(&b));
            let found = turn_between(&quaternion(&from), &quaternion(&to));
            let expected = rotation_vector(&product(&to, &transposed(&from)));
            assert!(length(&sub(&found, &expected)) < 1e-12, "{found:?} {expected:?}");
        }
    }

    #[test]
    fn flicker_of_one_step_at_rest_is_next_to_nothing() {
        let mut estimate = VelocityEstimate::new(STEP, TURN);
        for k in 0..200 {
            let found = estimate.update(&told(STEP * (k % 2) as f64, 0.0), k as f64 * 1e-3);
            assert!(k < 30 || length(&found.linear) <= 1.01 * STEP / 0.015, "{found:?}");
        }
    }

    #[test]
    fn uneven_times_and_old_ones_do_no_harm() {
        let mut estimate = VelocityEstimate::new(STEP, TURN);
        let mut found = Twist::ZERO;
        for k in 0..100 {
            let time = k as f64 * 1e-3 + if k % 3 == 0 { 4e-4 } else { 0.0 };
            found = estimate.update(&told(0.5 * time, 0.0), time);
        }
        assert!((found.linear[0] - 0.5).abs() < 0.01, "{found:?}");
        for time in [0.05, f64::NAN, f64::INFINITY] {
            assert_eq!(estimate.update(&told(9.0, 2.0), time), found);
        }
        estimate.reset();
        assert_eq!(estimate.update(&told(9.0, 2.0), 0.05), Twist::ZERO);
    }
}
