//! A device without actuators: another program sets its target, at any rate, and it follows smoothly.
//!
//! Each degree of freedom is a critically damped second-order system, solved exactly between two targets: however rare
//! the targets and uneven the reads, pose and twist are continuous, and never overshoot a resting target.

use feeler_core::constants::SMALL_ANGLE;
use feeler_core::geometry::twist::{pose_of, product, rotation_of, rotation_vector, transposed, Twist, Wrench};
use feeler_core::geometry::vectors::{add, along, cross, dot, scaled, sub};
use feeler_core::{Point, Pose};

use super::{Device, DeviceError, DeviceInfo, DeviceLimits, DeviceState, Freedoms};
use crate::constants::{MOUSE_FREQUENCIES, MOUSE_FREQUENCY};
use crate::error::{Error, Result};

/// See the [module](self). If targets come from another thread, set them before a read.
#[derive(Debug, Clone, PartialEq)]
pub struct Mouse {
    info: DeviceInfo,
    frequency: f64,
    target: Pose,
    /// A newer target, and from when it is one.
    next: Option<(Pose, f64)>,
    pose: Pose,
    twist: Twist,
    /// Of pose and twist.
    time: Option<f64>,
    buttons: u32,
}

impl Mouse {
    /// At rest at a pose, smoothing as suits targets at 60 Hz.
    pub fn new(pose: Pose) -> Mouse {
        let every = Freedoms { translation: true, rotation: true };
        Mouse {
            info: DeviceInfo {
                name: "mouse".into(),
                sensed: every,
                driven: Freedoms::default(),
                workspace: [f64::INFINITY; 3],
                limits: DeviceLimits::default(),
                buttons: 32,
            },
            frequency: MOUSE_FREQUENCY,
            target: pose,
            next: None,
            pose,
            twist: Twist::ZERO,
            time: None,
            buttons: 0,
        }
    }

    /// Another natural frequency of the smoothing, radians a second: the pose is `2 / frequency` seconds behind an even
    /// motion. Errors outside 1 to 1000.
    pub fn with_frequency(mut self, frequency: f64) -> Result<Mouse> {
        let [least, most] = MOUSE_FREQUENCIES;
        if !(least..=most).contains(&frequency) {
            let range = "between 1 and 1000 radians a second";
            return Err(Error::Option { what: "frequency of the mouse", value: frequency, range });
        }
        self.frequency = frequency;
        Ok(self)
    }

    /// Where to go, from `time` (seconds on the clock of the reads) on. A time that is past counts as the last read's,
    /// one that is not finite is left out; of several targets between two reads the last one stands.
    pub fn set_target(&mut self, pose: Pose, time: f64) {
        if time.is_finite() {
            self.next = Some((pose, time));
        }
    }

    /// There at once and at rest, without a way between.
    pub fn jump(&mut self, pose: Pose) {
        (self.target, self.pose, self.twist, self.next) = (pose, pose, Twist::ZERO, None);
    }

    /// Which buttons are held from now on.
    pub fn set_buttons(&mut self, buttons: u32) {
        self.buttons = buttons;
    }

    fn advance(&mut self, until: f64) {
        let time = *self.time.get_or_insert(until);
        let dt = until - time;
        if dt <= 0.0 {
            return;
        }
        self.time = Some(until);
        let from = sub(self.pose.translation(), self.target.translation());
        let (place, velocity) = settled(&from, &self.twist.linear, self.frequency, dt);
        // In rotation the same, on the rotation vector from the target; its rate and the angular velocity are reported
        // apart.
        let from = rotation_vector(&product(self.pose.rotation(), &transposed(self.target.rotation())));
        let rate = rate_of_vector(&from, &self.twist.angular);
        let (turn, rate) = settled(&from, &rate, self.frequency, dt);
        let rotation = product(&rotation_of(&turn), self.target.rotation());
        // A target is within the coordinate limit, and the pose is between it and another: where rounding says no, it
        // is reached.
        match pose_of(&rotation, &add(self.target.translation(), &place)) {
            Ok(pose) => {
                self.pose = pose;
                self.twist = Twist { linear: velocity, angular: velocity_of_vector(&turn, &rate) };
            }
            Err(_) => (self.pose, self.twist) = (self.target, Twist::ZERO),
        }
    }
}

/// Offset and its rate after a time, of a critically damped system that goes to zero: `x(t) = (x + (v + w x) t) exp(-w
/// t)`.
fn settled(offset: &Point, rate: &Point, frequency: f64, dt: f64) -> (Point, Point) {
    let decay = (-frequency * dt).exp();
    let slope = along(rate, frequency, offset);
    (scaled(&along(offset, dt, &slope), decay), scaled(&along(rate, -frequency * dt, &slope), decay))
}

/// The angular velocity of a rotation whose rotation vector changes at a rate (the left Jacobian of the exponential).
fn velocity_of_vector(vector: &Point, rate: &Point) -> Point {
    let square = dot(vector, vector);
    let angle = square.sqrt();
    // (1 - cos a) / a^2 and (a - sin a) / a^3.
    let (c, s) = if angle < SMALL_ANGLE {
        (0.5 - square / 24.0, 1.0 / 6.0 - square / 120.0)
    } else {
        (2.0 * (0.5 * angle).sin().powi(2) / square, (angle - angle.sin()) / (square * angle))
    };
    let once = cross(vector, rate);
    add(rate, &add(&scaled(&once, c), &scaled(&cross(vector, &once), s)))
}

/// Its inverse.
fn rate_of_vector(vector: &Point, velocity: &Point) -> Point {
    let square = dot(vector, vector);
    let angle = square.sqrt();
    // (1 - a / 2 cot(a / 2)) / a^2; the angle is at most half a turn.
    let s = if angle < SMALL_ANGLE {
        1.0 / 12.0 + square / 720.0
    } else {
        (1.0 - 0.5 * angle / (0.5 * angle).tan()) / square
    };
    let once = cross(vector, velocity);
    add(velocity, &add(&scaled(&once, -0.5), &scaled(&cross(vector, &once), s)))
}

impl Device for Mouse {
    fn info(&self) -> &DeviceInfo {
        &self.info
    }

    fn read(&mut self, now: f64) -> Result<DeviceState, DeviceError> {
        if !now.is_finite() {
            return Err(DeviceError::Nonsense { device: self.info.name.clone(), what: format!("a time of {now}") });
        }
        if let Some((target, from)) = self.next.filter(|(_, from)| *from <= now) {
            self.advance(from);
            self.target = target;
            self.next = None;
        }
        self.advance(now);
        let time = self.time.unwrap_or(now);
        Ok(DeviceState { pose: self.pose, twist: Some(self.twist), buttons: self.buttons, time })
    }

    /// Nothing: it drives no freedom.
    fn write(&mut self, _wrench: &Wrench, _now: f64) -> Result<(), DeviceError> {
        Ok(())
    }

    fn release(&mut self) {}
}
