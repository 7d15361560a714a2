//! One tick of the servo side: the pose nearest to the device's within the newest constraints, and the force of the
//! coupling to it.
//!
//! Between two sets the proxy moves by the rows of the newest one, and no farther than its bound: everything without a
//! row is at least the margin away, so a tool of which no point moves farther cannot get there. At the bound the proxy
//! is held, and the coupling drags. Allocates nothing, and takes no lock.

use feeler_core::geometry::twist::{times, Twist, Wrench};
use feeler_core::{Point, Pose};

use crate::constants::{BOUND_SHARE, OLDEST_SET_S, PROXY_RESOLUTION_M, PROXY_RESOLUTION_RAD, STUCK_SHARE};
use crate::constraint_set::{ConstraintSet, Solver};
use crate::coupling::Coupling;
use crate::device::{DeviceLimits, Freedoms};
use crate::error::Result;
use crate::force::{ForceInput, ForceLoop};
use crate::shading::Shading;
use crate::velocity::VelocityEstimate;

/// The input of a tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ServoInput {
    /// Where the device wants the tool, `world_from_tool`.
    pub device: Pose,
    /// Velocity where the hand holds the tool, if reported; else it is computed from the poses.
    pub device_twist: Option<Twist>,
    /// Seconds on the caller's clock.
    pub now: f64,
    /// Since the last tick, seconds.
    pub dt: f64,
    /// Something is wrong: no force.
    pub in_doubt: bool,
}

/// The constraints on the proxy.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Mode {
    /// Nothing: it is where the device is.
    #[default]
    Free,
    /// Contacts.
    Contact,
    /// The constraints are not good for more: it moves on with the next set.
    Bound,
    /// The force is let go: the device's reading is not plausible, or the constraints are too old.
    Doubt,
}

/// The result of a tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ServoOutput {
    /// On the hand, world axes, the torque about where it holds the tool.
    pub wrench: Wrench,
    /// Where the servo side has the proxy: near the collision side's, and not checked by it yet.
    pub proxy: Pose,
    /// Age of the constraints, seconds.
    pub age: f64,
    /// The state of the proxy.
    pub mode: Mode,
}

/// The servo side.
#[derive(Debug, Clone)]
pub struct Servo {
    force: ForceLoop,
    solver: Solver,
    /// Where the hand holds the tool, tool frame.
    centre: Point,
    device_velocity: VelocityEstimate,
    proxy_velocity: VelocityEstimate,
    /// Velocities are found between the device's reports: between two of them it only seems to rest.
    has_news: bool,
    /// The newest found, of device and proxy.
    found: [Twist; 2],
}

impl Servo {
    /// `coupling`, `driven`, `limits`, `rate_hz`: as of [`ForceLoop::new`]. `centre`: where the hand holds the tool,
    /// tool frame.
    pub fn new(
        coupling: Coupling,
        driven: Freedoms,
        limits: &DeviceLimits,
        rate_hz: f64,
        centre: Point,
    ) -> Result<Servo> {
        Ok(Servo {
            force: ForceLoop::new(coupling, driven, limits, rate_hz)?,
            solver: Solver::default(),
            centre,
            device_velocity: VelocityEstimate::new(limits.resolution_m, limits.rotational_resolution_rad),
            proxy_velocity: VelocityEstimate::new(PROXY_RESOLUTION_M, PROXY_RESOLUTION_RAD),
            has_news: true,
            found: [Twist::ZERO; 2],
        })
    }

    /// For the next tick: whether the device has reported since the last one, the mean time between its reports, and
    /// their mean age when they come, seconds. Not called: it reports at every tick.
    pub fn set_reports(&mut self, has_news: bool, reports_s: f64, late_s: f64) {
        self.has_news = has_news;
        self.force.set_reports(reports_s, late_s);
    }

    /// The mean of the last ticks, seconds.
    pub fn period_s(&self) -> f64 {
        self.force.period_s()
    }

    /// Share of the coupling's stiffness in use, as of [`ForceLoop::stiffness_share`].
    pub fn stiffness_share(&self) -> f64 {
        self.force.stiffness_share()
    }

    /// The coupling in use.
    pub fn coupling(&self) -> &Coupling {
        self.force.coupling()
    }

    /// Another rate from the next tick on, with the device's limits at it, as of [`ForceLoop::set_rate`].
    pub fn set_rate(&mut self, limits: &DeviceLimits, rate_hz: f64) -> Result<()> {
        self.force.set_rate(limits, rate_hz)
    }

    /// The ids of the planes that hold the proxy.
    pub fn held(&self) -> &[u64] {
        self.solver.held()
    }

    /// One tick.
    pub fn tick(&mut self, set: &ConstraintSet, input: &ServoInput) -> ServoOutput {
        self.tick_within(set, input, f64::INFINITY)
    }

    /// A tick with the proxy where the set was taken.
    pub(crate) fn tick_at(&mut self, set: &ConstraintSet, input: &ServoInput) -> ServoOutput {
        self.tick_within(set, input, STUCK_SHARE * set.skin)
    }

    fn tick_within(&mut self, set: &ConstraintSet, input: &ServoInput, most: f64) -> ServoOutput {
        let age = (input.now - set.time).max(0.0);
        let bound = (BOUND_SHARE * set.margin).min(most);
        let nearest = set.nearest_pose(&input.device, bound, &mut self.solver).ok();
        let in_doubt = input.in_doubt || age > OLDEST_SET_S || nearest.is_none();
        let proxy = nearest.map_or(set.taken_at, |nearest| nearest.pose);
        let mode = match nearest {
            _ if in_doubt => Mode::Doubt,
            Some(nearest) if nearest.is_at_bound && most.is_infinite() => Mode::Bound,
            _ if !self.solver.held().is_empty() => Mode::Contact,
            Some(nearest) if nearest.is_at_bound => Mode::Bound,
            _ => Mode::Free,
        };
        // In the air it is where the device is, and moves as that: nothing is felt, not even rounding.
        let proxy = if mode == Mode::Free { input.device } else { proxy };
        let Ok([device_hand, proxy_hand]) = self.hands(&input.device, &proxy) else {
            self.let_go();
            return ServoOutput { wrench: Wrench::ZERO, proxy, age, mode: Mode::Doubt };
        };
        if self.has_news {
            self.found = [
                self.device_velocity.update(&device_hand, input.now),
                self.proxy_velocity.update(&proxy_hand, input.now),
            ];
        }
        let [device_twist, found] = self.found;
        let device_twist = input.device_twist.unwrap_or(device_twist);
        let proxy_twist = if mode == Mode::Free { device_twist } else { found };
        let shading = match mode {
            Mode::Contact | Mode::Bound => set.shading(&proxy, &self.solver),
            _ => Shading::NONE,
        };
        let wrench = self.force.step(&ForceInput {
            device: device_hand,
            device_twist,
            proxy: proxy_hand,
            proxy_twist,
            shading,
            dt: input.dt,
            in_doubt,
        });
        ServoOutput { wrench, proxy, age, mode }
    }

    /// `world_from_hand` of two poses of the tool. Errors where that is beyond the coordinate limit.
    fn hands(&self, device: &Pose, proxy: &Pose) -> Result<[Pose; 2]> {
        let hand = |tool: &Pose| tool.translated(&times(tool.rotation(), &self.centre));
        Ok([hand(device)?, hand(proxy)?])
    }

    /// A tick without anything to go by: the force is let go.
    pub fn let_go(&mut self) {
        self.force.release();
        self.device_velocity.reset();
        self.proxy_velocity.reset();
        self.found = [Twist::ZERO; 2];
    }
}
