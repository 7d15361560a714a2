//! Devices held by a hand: one trait for all, whatever they sense and actuate.

#[doc(hidden)]
pub mod faulty;
pub mod hand;
pub(crate) mod mapping;
pub mod mouse;
mod random;
pub mod simulated;
pub mod steered;

use feeler_core::geometry::twist::{Twist, Wrench};
use feeler_core::Pose;

use crate::constants::{HELD_SHARE, USUAL_HZ, VIRTUAL_DAMPING_SHARE};
use crate::error::Error;

/// Which freedoms a device senses or drives.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Freedoms {
    /// The three of translation.
    pub translation: bool,
    /// The three of rotation.
    pub rotation: bool,
}

/// The limits of a device.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
pub struct DeviceLimits {
    /// Largest force, newtons; 0 where it drives none.
    pub force_n: f64,
    /// Largest torque, newton metres; 0 where it drives none.
    pub torque_nm: f64,
    /// Largest stiffness that its maker publishes, or that its user knows, newtons a metre; where the damping is not
    /// known, in a loop of 1 kHz without delay. 0: not known, and it bounds nothing.
    pub stiffness_n_per_m: f64,
    /// The same in rotation, newton metres a radian.
    pub rotational_stiffness_nm_per_rad: f64,
    /// Its own viscous damping, newton seconds a metre, which limits the stiffness that it can hold (Colgate). 0: not
    /// known, no limit.
    pub damping_n_s_per_m: f64,
    /// The same in rotation, newton metre seconds a radian.
    pub rotational_damping_nm_s_per_rad: f64,
    /// Coulomb friction, newtons: with the resolution it bounds the stiffness (Abbott and Okamura). 0: not known, and it
    /// bounds nothing.
    pub friction_n: f64,
    /// The same in rotation, newton metres.
    pub rotational_friction_nm: f64,
    /// Smallest step of the measured position, metres.
    pub resolution_m: f64,
    /// Smallest step of the measured rotation, radians.
    pub rotational_resolution_rad: f64,
    /// Rate of forces and poses, hertz. 0: not known, and it bounds nothing.
    pub rate_hz: f64,
    /// From a motion of the handle to the force that answers it, seconds, beyond the hold of one tick: the pose's way
    /// in and the force's way out, of the device and its connection. It takes stiffness away, as the period does.
    pub delay_s: f64,
}

impl DeviceLimits {
    feeler_core::setters! {
        with_force_n: force_n: f64,
        with_torque_nm: torque_nm: f64,
        with_stiffness_n_per_m: stiffness_n_per_m: f64,
        with_rotational_stiffness_nm_per_rad: rotational_stiffness_nm_per_rad: f64,
        with_damping_n_s_per_m: damping_n_s_per_m: f64,
        with_rotational_damping_nm_s_per_rad: rotational_damping_nm_s_per_rad: f64,
        with_friction_n: friction_n: f64,
        with_rotational_friction_nm: rotational_friction_nm: f64,
        with_resolution_m: resolution_m: f64,
        with_rotational_resolution_rad: rotational_resolution_rad: f64,
        with_rate_hz: rate_hz: f64,
        with_delay_s: delay_s: f64,
    }
}

impl DeviceLimits {
    /// Errors when a number is not finite, or negative.
    pub fn check(&self) -> Result<(), Error> {
        let numbers = [
            ("force_n", self.force_n),
            ("torque_nm", self.torque_nm),
            ("stiffness_n_per_m", self.stiffness_n_per_m),
            ("rotational_stiffness_nm_per_rad", self.rotational_stiffness_nm_per_rad),
            ("damping_n_s_per_m", self.damping_n_s_per_m),
            ("rotational_damping_nm_s_per_rad", self.rotational_damping_nm_s_per_rad),
            ("friction_n", self.friction_n),
            ("rotational_friction_nm", self.rotational_friction_nm),
            ("resolution_m", self.resolution_m),
            ("rotational_resolution_rad", self.rotational_resolution_rad),
            ("rate_hz", self.rate_hz),
            ("delay_s", self.delay_s),
        ];
        match numbers.into_iter().find(|(_, value)| !(value.is_finite() && *value >= 0.0)) {
            Some((what, value)) => Err(Error::Option { what, value, range: "finite, and not below 0" }),
            None => Ok(()),
        }
    }

    /// The same for a device known to hold a stiffness (newtons a metre) in a loop of a rate (hertz): with the damping
    /// that [`Coupling::limited`](crate::Coupling::limited) requires for it.
    pub fn with_stiffness(self, stiffness_n_per_m: f64, rate_hz: f64) -> DeviceLimits {
        let share = HELD_SHARE * (1.0 - VIRTUAL_DAMPING_SHARE);
        DeviceLimits { stiffness_n_per_m, damping_n_s_per_m: stiffness_n_per_m * self.hold_s(rate_hz) / share, ..self }
    }

    /// Its rate, or the usual one where that is not known, hertz.
    pub(crate) fn own_rate_hz(&self) -> f64 {
        if self.rate_hz > 0.0 {
            self.rate_hz
        } else {
            USUAL_HZ
        }
    }

    /// Share of a stiffness for the usual loop without delay that a loop of a rate (hertz) holds: in proportion to how old
    /// its forces are, at most 1.
    pub(crate) fn slowed(&self, rate_hz: f64) -> f64 {
        (0.5 / USUAL_HZ / self.hold_s(rate_hz)).min(1.0)
    }

    /// How old a force is on average when it acts, seconds: half a period of the slower of loop (`rate_hz`) and device,
    /// and the delay. Infinite where the loop's rate is not above zero; a device's rate of zero is not known, and not
    /// asked.
    pub fn hold_s(&self, rate_hz: f64) -> f64 {
        if rate_hz > 0.0 {
            let rate = if self.rate_hz > 0.0 { rate_hz.min(self.rate_hz) } else { rate_hz };
            0.5 / rate + self.delay_s.max(0.0)
        } else {
            f64::INFINITY
        }
    }
}

/// The description of a device.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct DeviceInfo {
    /// Maker and model, or the device's own name for itself.
    pub name: String,
    /// Told by it.
    pub sensed: Freedoms,
    /// Driven by it: a device of three driven freedoms gets force without torque.
    pub driven: Freedoms,
    /// Half the edges of the box that its handle can reach, around its origin, device axes, metres.
    pub workspace: [f64; 3],
    /// Its limits.
    pub limits: DeviceLimits,
    /// Number of buttons.
    pub buttons: u32,
}

impl DeviceInfo {
    /// A device of a name that senses and drives nothing, until it is said what.
    pub fn new(name: impl Into<String>) -> DeviceInfo {
        DeviceInfo {
            name: name.into(),
            sensed: Freedoms::default(),
            driven: Freedoms::default(),
            workspace: [0.0; 3],
            limits: DeviceLimits::default(),
            buttons: 0,
        }
    }

    feeler_core::setters! {
        with_sensed: sensed: Freedoms,
        with_driven: driven: Freedoms,
        with_workspace: workspace: [f64; 3],
        with_limits: limits: DeviceLimits,
        with_buttons: buttons: u32,
    }
}

/// What a device tells, in its own frame: origin in the middle of its workspace, right-handed, x to the right, y away
/// from the hand's owner, z up.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct DeviceState {
    /// Of the handle; the rotation is the identity where none is sensed.
    pub pose: Pose,
    /// Velocity of the handle's origin, if the device reports it; else it is computed from the poses.
    pub twist: Option<Twist>,
    /// A bit each, the first is the lowest.
    pub buttons: u32,
    /// When it was measured, seconds on the caller's clock; older than the time of asking where nothing new has come.
    pub time: f64,
}

impl DeviceState {
    /// A handle at a pose, measured at a time (seconds on the caller's clock); no button is pressed.
    pub fn new(pose: Pose, time: f64) -> DeviceState {
        DeviceState { pose, twist: None, buttons: 0, time }
    }

    feeler_core::setters! {
        with_twist: twist: impl Into<Option<Twist>>,
        with_buttons: buttons: u32,
    }
}

/// Why a device does not answer.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum DeviceError {
    /// There is no such device, service or library, with what to do.
    #[error("{device}: {why}")]
    NotFound {
        /// Which.
        device: String,
        /// The attempts, and the remedy.
        why: String,
    },
    /// An option of its driver is out of its range.
    #[error("{name} is {value}: give {range}")]
    Option {
        /// Which.
        name: &'static str,
        /// Its value.
        value: f64,
        /// Its range, in words.
        range: &'static str,
    },
    /// The connection is lost.
    #[error("{device} does not answer any more: {why}")]
    Lost {
        /// Which.
        device: String,
        /// The system's message.
        why: String,
    },
    /// Its driver failed and does not go on: a run with it ends.
    #[error("{device} failed: {why}")]
    Broken {
        /// Which.
        device: String,
        /// The reason.
        why: String,
    },
    /// It told something that cannot be.
    #[error("{device} reported an invalid value: {what}")]
    Nonsense {
        /// Which.
        device: String,
        /// What.
        what: String,
    },
}

/// A haptic device, or any other thing that a hand moves. Implement it for your own: `examples/own_device.rs`.
///
/// Neither [`read`](Self::read) nor [`write`](Self::write) may wait: a servo loop of 1 kHz and more calls them. A
/// driver that has to wait for a socket does so in a thread of its own, and keeps the newest data.
pub trait Device: Send {
    /// Its properties.
    fn info(&self) -> &DeviceInfo;

    /// The newest state. `now`: seconds on the caller's clock. Errors if the device is lost, or reported an invalid value;
    /// the caller then removes the force.
    fn read(&mut self, now: f64) -> Result<DeviceState, DeviceError>;

    /// Sets the wrench on the hand from now on, at the handle's origin, device axes. Components without an actuator are
    /// ignored.
    fn write(&mut self, wrench: &Wrench, now: f64) -> Result<(), DeviceError>;

    /// Releases the force, whatever else fails. Called when a session ends; also by dropping the device.
    fn release(&mut self);

    /// Whether the hand sets a velocity and the pose is its sum. The tool then stays near the proxy, so that it comes back at once.
    fn is_rate_controlled(&self) -> bool {
        false
    }
}

impl<D: Device + ?Sized> Device for Box<D> {
    fn info(&self) -> &DeviceInfo {
        (**self).info()
    }

    fn read(&mut self, now: f64) -> Result<DeviceState, DeviceError> {
        (**self).read(now)
    }

    fn write(&mut self, wrench: &Wrench, now: f64) -> Result<(), DeviceError> {
        (**self).write(wrench, now)
    }

    fn release(&mut self) {
        (**self).release();
    }

    fn is_rate_controlled(&self) -> bool {
        (**self).is_rate_controlled()
    }
}
