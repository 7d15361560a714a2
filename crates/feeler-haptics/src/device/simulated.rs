//! A simulated device: mass, friction, encoders, delays and a hand, in simulated time.
//!
//! Its physics advances in steps of 50 us up to the time passed to [`read`](Device::read) or [`write`](Device::write),
//! so that the same calls give the same motion, bit for bit. Handle and hand are one rigid mass and one rigid inertia,
//! the same in all directions and about all axes. Gravity is balanced.

use feeler_core::geometry::twist::{displaced, displacement, pose_of, rotation_of, rotation_vector, Twist, Wrench};
use feeler_core::geometry::vectors::{along, length, scaled};
use feeler_core::{Point, Pose};

use super::hand::Hand;
use super::random::Random;
use super::{Device, DeviceError, DeviceInfo, DeviceLimits, DeviceState, Freedoms};
use crate::constants::{COMMANDS_ON_THE_WAY, INNER_STEP_S, LONGEST_CATCH_UP_S, LONGEST_DELAY_S};
use crate::error::{Error, Result};

/// Mechanics and timing of a simulated device.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct SimulatedOptions {
    /// The reported properties. Its damping, friction, resolution, limits and degrees of freedom are simulated;
    /// `rate_hz` is only informative: it reports and accepts at any rate. Its `delay_s` is set to the sum of the two
    /// delays below.
    pub info: DeviceInfo,
    /// Effective mass of the handle, kilograms.
    pub mass_kg: f64,
    /// Effective inertia of the handle, kilogram square metres.
    pub inertia_kg_m2: f64,
    /// Age of a pose when it is reported, seconds.
    pub pose_delay_s: f64,
    /// How long a wrench takes until it acts, seconds.
    pub force_delay_s: f64,
    /// Each way takes up to this much longer, seconds, evenly spread and different each time.
    pub jitter_s: f64,
    /// Of the jitter.
    pub seed: u64,
}

impl SimulatedOptions {
    feeler_core::setters! {
        with_info: info: DeviceInfo,
        with_mass_kg: mass_kg: f64,
        with_inertia_kg_m2: inertia_kg_m2: f64,
        with_pose_delay_s: pose_delay_s: f64,
        with_force_delay_s: force_delay_s: f64,
        with_jitter_s: jitter_s: f64,
        with_seed: seed: u64,
    }
}

/// See the [module](self).
#[derive(Debug, Clone)]
pub struct SimulatedDevice {
    options: SimulatedOptions,
    hand: Option<Hand>,
    buttons: u32,
    random: Random,
    /// Of the first call, seconds on the caller's clock.
    start: Option<f64>,
    /// Inner steps since.
    steps: u64,
    pose: Pose,
    twist: Twist,
    /// Past poses, of step `i` at `i` modulo the length.
    past: Vec<Pose>,
    /// Wrenches written that do not act yet: when they will (seconds since the start), and the wrench. The oldest first.
    commands: Vec<(f64, Wrench)>,
    acting: Wrench,
    /// The step of the pose reported last.
    told: u64,
}

impl SimulatedDevice {
    /// At rest at the middle of its workspace, or where the hand's path begins. Errors where a number is out of its
    /// range.
    pub fn new(options: SimulatedOptions, hand: Option<Hand>) -> Result<SimulatedDevice> {
        let mut options = options;
        let positive = [("mass_kg", options.mass_kg), ("inertia_kg_m2", options.inertia_kg_m2)];
        for (what, value) in positive {
            if !(value > 0.0 && value.is_finite()) {
                return Err(Error::Option { what, value, range: "above 0" });
            }
        }
        options.info.limits.check()?;
        let ways = [options.pose_delay_s, options.force_delay_s, options.jitter_s];
        for (what, value) in ["pose_delay_s", "force_delay_s", "jitter_s"].into_iter().zip(ways) {
            if !(0.0..=0.5 * LONGEST_DELAY_S).contains(&value) {
                return Err(Error::Option { what, value, range: "between 0 and 0.025 s" });
            }
        }
        options.info.limits.delay_s = options.pose_delay_s + options.force_delay_s + options.jitter_s;
        if let Some(hand) = &hand {
            hand.check()?;
        }
        let pose = hand.as_ref().map_or(Pose::IDENTITY, |hand| hand.path.at(0.0).0);
        Ok(SimulatedDevice {
            random: Random::new(options.seed),
            options,
            hand,
            buttons: 0,
            start: None,
            steps: 0,
            pose,
            twist: Twist::ZERO,
            past: vec![pose; (LONGEST_DELAY_S / INNER_STEP_S) as usize + 2],
            commands: Vec::with_capacity(COMMANDS_ON_THE_WAY),
            acting: Wrench::ZERO,
            told: 0,
        })
    }

    /// Another hand, or none: the handle is let go.
    pub fn set_hand(&mut self, hand: Option<Hand>) -> Result<()> {
        if let Some(hand) = &hand {
            hand.check()?;
        }
        self.hand = hand;
        Ok(())
    }

    /// Which buttons are held from now on.
    pub fn set_buttons(&mut self, buttons: u32) {
        self.buttons = buttons;
    }

    /// Where the handle is in truth, neither rounded nor delayed, `device_from_handle`.
    pub fn true_pose(&self) -> &Pose {
        &self.pose
    }

    /// How fast the handle is in truth, at its origin.
    pub fn true_twist(&self) -> &Twist {
        &self.twist
    }

    /// The wrench that acts on the handle, as the device drives it.
    pub fn acting(&self) -> &Wrench {
        &self.acting
    }

    /// Since the first call, seconds.
    pub fn time(&self) -> f64 {
        self.steps as f64 * INNER_STEP_S
    }

    /// Lets time pass up to `now`.
    fn advance(&mut self, now: f64) {
        if !now.is_finite() {
            return;
        }
        let start = *self.start.get_or_insert(now);
        // A little more than whole, so that a tick of twenty steps is not nineteen by rounding.
        let mut until = ((now - start) / INNER_STEP_S + 1e-6).max(0.0) as u64;
        let most = (LONGEST_CATCH_UP_S / INNER_STEP_S) as u64;
        if until > self.steps + most {
            until = self.steps + most;
            self.start = Some(now - until as f64 * INNER_STEP_S);
        }
        while self.steps < until {
            self.step();
        }
    }

    fn step(&mut self) {
        let dt = INNER_STEP_S;
        let time = self.time();
        // What is due acts; of several the last.
        let due = self.commands.iter().take_while(|(at, _)| *at <= time + 1e-3 * dt).count();
        if let Some((_, wrench)) = self.commands.drain(..due).next_back() {
            self.acting = wrench;
        }
        let limits = &self.options.info.limits;
        let (mut mass, mut inertia) = (self.options.mass_kg, self.options.inertia_kg_m2);
        let mut push = self.acting;
        let (mut damping, mut turn_damping) = (limits.damping_n_s_per_m, limits.rotational_damping_nm_s_per_rad);
        if let Some(hand) = &self.hand {
            let (wanted, twist) = hand.path.at(time);
            let away = displacement(&self.pose, &wanted, &[0.0; 3]);
            push.force = along(&push.force, hand.stiffness_n_per_m, &away.linear);
            push.force = along(&push.force, hand.damping_n_s_per_m, &twist.linear);
            push.torque = along(&push.torque, hand.rotational_stiffness_nm_per_rad, &away.angular);
            push.torque = along(&push.torque, hand.rotational_damping_nm_s_per_rad, &twist.angular);
            damping += hand.damping_n_s_per_m;
            turn_damping += hand.rotational_damping_nm_s_per_rad;
            mass += hand.mass_kg;
            inertia += hand.inertia_kg_m2;
        }
        self.twist = Twist {
            linear: moved_on(&self.twist.linear, &push.force, mass, damping, limits.friction_n, dt),
            angular: moved_on(
                &self.twist.angular,
                &push.torque,
                inertia,
                turn_damping,
                limits.rotational_friction_nm,
                dt,
            ),
        };
        // A handle that has run away beyond all coordinates stays where it is.
        self.pose = displaced(&self.pose, &(self.twist * dt), &[0.0; 3]).unwrap_or(self.pose);
        self.steps += 1;
        let slot = self.slot(self.steps);
        self.past[slot] = self.pose;
    }

    fn slot(&self, step: u64) -> usize {
        (step % self.past.len() as u64) as usize
    }

    fn jitter(&mut self) -> f64 {
        self.options.jitter_s * self.random.unit()
    }

    /// As the encoders have it.
    fn rounded(&self, pose: &Pose) -> Pose {
        let (limits, sensed) = (&self.options.info.limits, self.options.info.sensed);
        let place = match sensed.translation {
            true => pose.translation().map(|x| to_grid(x, limits.resolution_m)),
            false => [0.0; 3],
        };
        let turn = match sensed.rotation {
            true => rotation_vector(pose.rotation()).map(|x| to_grid(x, limits.rotational_resolution_rad)),
            false => [0.0; 3],
        };
        pose_of(&rotation_of(&turn), &place).unwrap_or(*pose)
    }
}

/// A velocity after a step: damped implicitly, so that no damping is too much for the step, then slowed by Coulomb
/// friction, which at most stops it.
fn moved_on(velocity: &Point, push: &Point, mass: f64, damping: f64, friction: f64, dt: f64) -> Point {
    let pushed = scaled(&along(velocity, dt / mass, push), 1.0 / (1.0 + dt * damping / mass));
    let speed = length(&pushed);
    let lost = dt * friction / mass;
    if speed <= lost {
        [0.0; 3]
    } else {
        scaled(&pushed, 1.0 - lost / speed)
    }
}

fn to_grid(value: f64, step: f64) -> f64 {
    if step > 0.0 {
        (value / step).round() * step
    } else {
        value
    }
}

fn within(vector: &Point, most: f64, is_driven: bool) -> Point {
    let size = length(vector);
    match is_driven {
        false => [0.0; 3],
        true if size > most => scaled(vector, most / size),
        true => *vector,
    }
}

impl Device for SimulatedDevice {
    fn info(&self) -> &DeviceInfo {
        &self.options.info
    }

    fn read(&mut self, now: f64) -> Result<DeviceState, DeviceError> {
        self.advance(now);
        let age = self.options.pose_delay_s + self.jitter();
        let back = (age / INNER_STEP_S).round() as u64;
        // Never older than the pose reported before.
        self.told = self.steps.saturating_sub(back).max(self.told);
        let start = self.start.unwrap_or(0.0);
        Ok(DeviceState {
            pose: self.rounded(&self.past[self.slot(self.told)]),
            twist: None,
            buttons: self.buttons,
            time: start + self.told as f64 * INNER_STEP_S,
        })
    }

    /// A wrench that is not finite is taken as a release. Force and torque are cut to the device's bounds, the direction kept.
    fn write(&mut self, wrench: &Wrench, now: f64) -> Result<(), DeviceError> {
        if !wrench.is_finite() {
            self.release();
            let what = format!("a wrench that is not finite: {wrench:?}");
            return Err(DeviceError::Nonsense { device: self.options.info.name.clone(), what });
        }
        self.advance(now);
        let (limits, driven) = (&self.options.info.limits, self.options.info.driven);
        let wrench = Wrench {
            force: within(&wrench.force, limits.force_n, driven.translation),
            torque: within(&wrench.torque, limits.torque_nm, driven.rotation),
        };
        let mut at = self.time() + self.options.force_delay_s + self.jitter();
        // Commands do not overtake each other; where too many are on the way, the newest two become one.
        if let Some((last, _)) = self.commands.last() {
            at = at.max(*last);
        }
        if self.commands.len() == COMMANDS_ON_THE_WAY {
            self.commands.pop();
        }
        self.commands.push((at, wrench));
        Ok(())
    }

    /// Acts at once, whatever is on the way.
    fn release(&mut self) {
        self.commands.clear();
        self.acting = Wrench::ZERO;
    }
}

impl SimulatedOptions {
    /// A desktop device that senses six freedoms and drives three: 12 N, 0.2 kg, 10 um; 1000 Hz.
    pub fn desktop_3dof() -> SimulatedOptions {
        SimulatedOptions {
            info: DeviceInfo {
                name: "simulated desktop device, 3 driven freedoms".into(),
                sensed: Freedoms { translation: true, rotation: true },
                driven: Freedoms { translation: true, rotation: false },
                workspace: [0.08, 0.06, 0.06],
                limits: DeviceLimits {
                    force_n: 12.0,
                    damping_n_s_per_m: 1.5,
                    rotational_damping_nm_s_per_rad: 1e-3,
                    friction_n: 0.1,
                    rotational_friction_nm: 1e-3,
                    resolution_m: 1e-5,
                    rotational_resolution_rad: 5e-4,
                    rate_hz: 1000.0,
                    ..DeviceLimits::default()
                },
                buttons: 2,
            },
            mass_kg: 0.2,
            inertia_kg_m2: 1e-4,
            pose_delay_s: 0.0,
            force_delay_s: 0.0,
            jitter_s: 0.0,
            seed: 0,
        }
    }

    /// The same, and it drives rotation too: 0.4 Nm, 0.2 mrad.
    pub fn desktop_6dof() -> SimulatedOptions {
        let mut options = SimulatedOptions::desktop_3dof();
        options.info.name = "simulated desktop device, 6 driven freedoms".into();
        options.info.driven.rotation = true;
        let limits = &mut options.info.limits;
        limits.torque_nm = 0.4;
        limits.rotational_damping_nm_s_per_rad = 3e-3;
        limits.rotational_friction_nm = 2e-3;
        limits.rotational_resolution_rad = 2e-4;
        options.inertia_kg_m2 = 3e-4;
        options
    }

    /// A large device for maintainability, of the size of LHIfAM (J. Savall, D. Borro, J. J. Gil and L. Matey,
    /// *Description of a Haptic System for Virtual Maintainability in Aeronautics*, IROS 2002): a workspace of 1.6 x
    /// 0.6 x 0.8 m. Mass, friction and bounds are round figures of ours for a device of that size.
    pub fn large_6dof() -> SimulatedOptions {
        SimulatedOptions {
            info: DeviceInfo {
                name: "simulated large device, 6 driven freedoms".into(),
                sensed: Freedoms { translation: true, rotation: true },
                driven: Freedoms { translation: true, rotation: true },
                workspace: [0.8, 0.3, 0.4],
                limits: DeviceLimits {
                    force_n: 60.0,
                    torque_nm: 3.0,
                    damping_n_s_per_m: 8.0,
                    rotational_damping_nm_s_per_rad: 0.04,
                    friction_n: 1.5,
                    rotational_friction_nm: 0.03,
                    resolution_m: 4e-5,
                    rotational_resolution_rad: 3e-4,
                    rate_hz: 1000.0,
                    ..DeviceLimits::default()
                },
                buttons: 2,
            },
            mass_kg: 3.0,
            inertia_kg_m2: 0.01,
            ..SimulatedOptions::desktop_3dof()
        }
    }
}

impl SimulatedDevice {
    /// [`SimulatedOptions::desktop_3dof`] in a hand.
    pub fn desktop_3dof(hand: Option<Hand>) -> Result<SimulatedDevice> {
        SimulatedDevice::new(SimulatedOptions::desktop_3dof(), hand)
    }

    /// [`SimulatedOptions::desktop_6dof`] in a hand.
    pub fn desktop_6dof(hand: Option<Hand>) -> Result<SimulatedDevice> {
        SimulatedDevice::new(SimulatedOptions::desktop_6dof(), hand)
    }

    /// [`SimulatedOptions::large_6dof`] in a hand.
    pub fn large_6dof(hand: Option<Hand>) -> Result<SimulatedDevice> {
        SimulatedDevice::new(SimulatedOptions::large_6dof(), hand)
    }
}
