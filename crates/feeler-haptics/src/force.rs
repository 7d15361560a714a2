//! From two poses to a wrench that is safe for a hand, once a tick: coupling, saturation, passivity, slew, watchdog.

use feeler_core::geometry::twist::{displacement, Twist, Wrench};
use feeler_core::geometry::vectors::{dot, length, scaled, sub, unit};
use feeler_core::{Point, Pose};

use crate::constants::{
    CONTROLLER_SHARE, JUMP_RATE, JUMP_SPEED, LONGEST_DELAY_TICKS, LONGEST_TICK_S, RATE_MEMORY_S, RATE_SHARE, RETURN_S,
    SHORTEST_TICK_S,
};
use crate::coupling::Coupling;
use crate::device::{DeviceLimits, Freedoms};
use crate::error::{Error, Result};
use crate::passivity::Passivity;
use crate::saturation::{added_within, saturated, slewed};
use crate::shading::Shading;
use crate::shading_budget::ShadingBudget;

/// The input of a tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ForceInput {
    /// Where the device has the hand, `world_from_hand`: the tool's frame with its origin where the hand holds the tool.
    pub device: Pose,
    /// How fast, at that origin, world axes.
    pub device_twist: Twist,
    /// Where the mock-up lets it be, `world_from_hand`.
    pub proxy: Pose,
    /// How fast that moves, at its own origin, world axes.
    pub proxy_twist: Twist,
    /// How the force of the spring of translation is turned.
    pub shading: Shading,
    /// Since the last tick, seconds.
    pub dt: f64,
    /// Something is wrong (a device that is silent, constraints that are too old, a clutch that is held): no force.
    pub in_doubt: bool,
}

/// The force pipeline, once a tick. Its wrench has world axes, the torque about the hand, where the device has it.
///
/// - [`Coupling::wrench`], without torque if the device has no torque actuators.
/// - Saturation: one factor scales force and torque, so that the wrench keeps its line of action, until both are within
///   the bounds. The bounds are the lesser ones of coupling and device, and grow from nothing in 0.2 s at the start and
///   after each release.
/// - `Passivity`: over the wrench really sent, with the device's delay. Its damping and the virtual damper together
///   stay below the device's own damping, and any excess over the bounds is dropped.
/// - Rate: if ticks, or the device's reports, are clearly slower than those that the coupling is limited for, or come
///   clearly later, its stiffness is reduced like Colgate's bound.
/// - Slew: limits the change of force, and of torque.
/// - Watchdog: zero at once if the input is in doubt, not finite, `dt` is not between 0.01 and 50 ms, or the device has
///   jumped (50 m/s, 1000 rad/s). The return goes through bounds and slew.
///
/// Without torque actuators, turning the tool about the handle changes the force at no cost, and a closed motion with
/// rotations can gain energy (F. Barbagli and K. Salisbury, *The Effect of Sensor/Actuator Asymmetries in Haptic
/// Interfaces*, HAPTICS 2003). The bounds hold there as everywhere; that no motion gains energy is guaranteed for
/// translations, and for devices that actuate everything they sense.
#[derive(Debug, Clone, PartialEq)]
pub struct ForceLoop {
    coupling: Coupling,
    driven: Freedoms,
    limits: DeviceLimits,
    passivity: Passivity,
    budget: ShadingBudget,
    delay_ticks: usize,
    /// The tick that the coupling is limited for, and the mean of the last ones, seconds.
    nominal_s: f64,
    period_s: f64,
    /// The mean time between the device's reports, and their age when they come, seconds; 0: not measured.
    reports_s: f64,
    late_s: f64,
    /// The last wrenches, the newest at `newest`, round and round.
    sent: [Wrench; LONGEST_DELAY_TICKS + 1],
    /// What shading would have added to these by its whole, and the share of that in them.
    shaded: [(Wrench, f64); LONGEST_DELAY_TICKS + 1],
    newest: usize,
    /// Share of the bounds.
    share: f64,
    last: Option<Last>,
}

/// The state kept of the last tick.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Last {
    device: Pose,
    stored: f64,
}

impl ForceLoop {
    /// `coupling`: as it is to be felt, already [`limited`](Coupling::limited) to the device. `driven`: by the
    /// device. `limits`: of the device, in the coupling's world. `rate_hz`: of the loop. Errors where the coupling or
    /// the limits are out of their ranges, or the rate is not that of ticks between 0.01 and 50 ms.
    pub fn new(coupling: Coupling, driven: Freedoms, limits: &DeviceLimits, rate_hz: f64) -> Result<ForceLoop> {
        let mut made = ForceLoop {
            coupling,
            driven,
            limits: *limits,
            passivity: Passivity::new(0.0, 0.0, 0.0),
            budget: ShadingBudget::new(),
            delay_ticks: 0,
            nominal_s: 0.0,
            period_s: 0.0,
            reports_s: 0.0,
            late_s: 0.0,
            sent: [Wrench::ZERO; LONGEST_DELAY_TICKS + 1],
            shaded: [(Wrench::ZERO, 0.0); LONGEST_DELAY_TICKS + 1],
            newest: 0,
            share: 1.0,
            last: None,
        };
        made.set_rate(limits, rate_hz)?;
        made.set_coupling(coupling)?;
        Ok(made)
    }

    /// Sets the rate from the next tick on, with the device's limits at it. The force and the energy account go on. Errors as
    /// those of [`new`](Self::new).
    pub fn set_rate(&mut self, limits: &DeviceLimits, rate_hz: f64) -> Result<()> {
        if !is_tick(1.0 / rate_hz) {
            return Err(Error::Option { what: "rate_hz", value: rate_hz, range: "between 20 and 100000 Hz" });
        }
        limits.check()?;
        self.limits = *limits;
        (self.nominal_s, self.period_s) = (1.0 / rate_hz, 1.0 / rate_hz);
        self.delay_ticks = ((limits.delay_s.max(0.0) * rate_hz).round() as usize).min(LONGEST_DELAY_TICKS);
        self.bound_damping();
        Ok(())
    }

    /// The mean time between the device's reports, and their mean age when they come, as measured, seconds.
    pub fn set_reports(&mut self, reports_s: f64, late_s: f64) {
        (self.reports_s, self.late_s) = (reports_s, late_s);
    }

    /// The mean of the last ticks, seconds.
    pub fn period_s(&self) -> f64 {
        self.period_s
    }

    /// Share of the coupling's stiffness in use: less than 1 where forces are clearly older than the coupling is limited
    /// for, by Colgate's bound, that is in proportion to their age.
    pub fn stiffness_share(&self) -> f64 {
        let nominal =
            if self.limits.rate_hz > 0.0 { self.nominal_s.max(1.0 / self.limits.rate_hz) } else { self.nominal_s };
        let delay = self.limits.delay_s.max(0.0);
        let slower = (self.period_s.max(self.reports_s) / nominal).max(1.0);
        let older = slower + (self.late_s - delay * slower).max(0.0) / (0.5 * nominal + delay);
        if older > RATE_SHARE {
            1.0 / older
        } else {
            1.0
        }
    }

    /// Another coupling from the next tick on. The force goes to its new value by the slew limit. Errors where it is
    /// out of its ranges.
    pub fn set_coupling(&mut self, coupling: Coupling) -> Result<()> {
        coupling.check()?;
        let mut to = coupling;
        let (translation, rotation) = (self.driven.translation, self.driven.rotation);
        to.max_force_n = if translation { to.max_force_n.min(self.limits.force_n) } else { 0.0 };
        to.max_torque_nm = if rotation { to.max_torque_nm.min(self.limits.torque_nm) } else { 0.0 };
        if !translation {
            (to.stiffness_n_per_m, to.damping_n_s_per_m) = (0.0, 0.0);
        }
        if !rotation {
            (to.rotational_stiffness_nm_per_rad, to.rotational_damping_nm_s_per_rad) = (0.0, 0.0);
        }
        self.coupling = to;
        self.passivity.reset();
        self.bound_damping();
        self.last = None;
        Ok(())
    }

    /// The controller's damping beside the coupling's own damper, and the springs' largest energy.
    fn bound_damping(&mut self) {
        let (to, driven) = (&self.coupling, &self.driven);
        let held = |is: bool, own: f64, damper: f64| if is { (CONTROLLER_SHARE * own - damper).max(0.0) } else { 0.0 };
        let full = |most: f64, stiffness: f64| if stiffness > 0.0 { 0.5 * most * most / stiffness } else { 0.0 };
        self.passivity.bound(
            held(driven.translation, self.limits.damping_n_s_per_m, to.damping_n_s_per_m),
            held(driven.rotation, self.limits.rotational_damping_nm_s_per_rad, to.rotational_damping_nm_s_per_rad),
            full(to.max_force_n, to.stiffness_n_per_m) + full(to.max_torque_nm, to.rotational_stiffness_nm_per_rad),
        );
    }

    /// The coupling in use: bounds as the device's, nothing in freedoms that it does not drive.
    pub fn coupling(&self) -> &Coupling {
        &self.coupling
    }

    /// The last wrench.
    pub fn wrench(&self) -> Wrench {
        self.sent[self.newest]
    }

    /// What the observer has in its books, joules; negative: given to the hand without having been taken.
    pub fn surplus_j(&self) -> f64 {
        self.passivity.surplus_j()
    }

    /// The wrench on the hand for the coming tick. Never above the bounds; [`Wrench::ZERO`] if anything is in doubt.
    pub fn step(&mut self, input: &ForceInput) -> Wrench {
        match self.answer(input) {
            Some((wrench, shaded)) => {
                self.send(wrench, shaded);
                wrench
            }
            None => {
                self.let_go(Some(input.device));
                Wrench::ZERO
            }
        }
    }

    /// Zero at once, as a tick of doubt would do.
    pub fn release(&mut self) {
        self.let_go(None);
    }

    fn let_go(&mut self, device: Option<Pose>) {
        self.passivity.reset();
        self.budget.let_go();
        self.share = 0.0;
        // Where the device is from now on: a jump is in doubt for one tick.
        self.last = device.map(|device| Last { device, stored: 0.0 });
        self.send(Wrench::ZERO, (Wrench::ZERO, 0.0));
    }

    fn send(&mut self, wrench: Wrench, shaded: (Wrench, f64)) {
        self.newest = (self.newest + 1) % self.sent.len();
        (self.sent[self.newest], self.shaded[self.newest]) = (wrench, shaded);
    }

    /// The wrench, what shading adds by its whole, and the share of that in it.
    fn answer(&mut self, input: &ForceInput) -> Option<(Wrench, (Wrench, f64))> {
        let is_sane = !input.in_doubt
            && is_tick(input.dt)
            && input.device_twist.is_finite()
            && input.proxy_twist.is_finite()
            && input.shading.turn.iter().all(|x| x.is_finite())
            && (input.shading.height_m + input.shading.bulge_m).is_finite();
        if !is_sane {
            return None;
        }
        let moved = match &self.last {
            Some(last) => displacement(&last.device, &input.device, &[0.0; 3]),
            None => Twist::ZERO,
        };
        let is_jump = |way: &Point, speed: f64| length(way) > speed * input.dt;
        if is_jump(&moved.linear, JUMP_SPEED) || is_jump(&moved.angular, JUMP_RATE) {
            return None;
        }
        self.share = (self.share + input.dt / RETURN_S).min(1.0);
        self.period_s += (input.dt - self.period_s) * (input.dt / RATE_MEMORY_S).min(1.0);
        let held = self.stiffness_share();
        let coupling = Coupling {
            stiffness_n_per_m: held * self.coupling.stiffness_n_per_m,
            rotational_stiffness_nm_per_rad: held * self.coupling.rotational_stiffness_nm_per_rad,
            max_force_n: self.share * self.coupling.max_force_n,
            max_torque_nm: self.share * self.coupling.max_torque_nm,
            ..self.coupling
        };
        let (device, proxy) = (&input.device, &input.proxy);
        let spring = coupling.spring_force(device, proxy);
        let is_full = length(&spring) >= coupling.max_force_n;
        let stiffness = coupling.stiffness_n_per_m;
        let turned = input.shading.turned(&spring, if is_full { 0.0 } else { stiffness }, stiffness);
        let way = [length(&moved.linear), length(&moved.angular)];
        let turned = self.budget.follow(&spring, turned, way, input.dt);
        let mut shaded = Wrench { force: sub(&turned, &spring), torque: [0.0; 3] };
        let mut proxy_twist = input.proxy_twist;
        if let Some(along) = unit(&turned).filter(|_| turned != spring) {
            // From facet to facet the proxy jumps: across the normal it counts as moving with the device.
            let rate = sub(&proxy_twist.linear, &input.device_twist.linear);
            let across = sub(&rate, &scaled(&along, dot(&rate, &along)));
            proxy_twist.linear = sub(&proxy_twist.linear, &across);
        }
        let mut pulled = coupling.wrench(device, &input.device_twist, proxy, &proxy_twist);
        if !self.driven.translation {
            (pulled.force, shaded.force) = ([0.0; 3], [0.0; 3]);
        }
        if !self.driven.rotation {
            (pulled.torque, shaded.torque) = ([0.0; 3], [0.0; 3]);
        }
        let within = |wrench: &Wrench| saturated(wrench, coupling.max_force_n, coupling.max_torque_nm);
        let (pulled, whole) = (within(&pulled), within(&(pulled + shaded)));
        let shaded = whole - pulled;

        let stored = coupling.energy_j(device, proxy);
        if let Some(last) = &self.last {
            // What acted while the device moved: the delay is on the way in and on the way out, and shows as their sum.
            let at = (self.newest + self.sent.len() - self.delay_ticks) % self.sent.len();
            let (acted, (by_shading, share)) = (self.sent[at], self.shaded[at]);
            let is_free = stored == 0.0 && last.stored == 0.0;
            let whole_j = -by_shading.power(&moved);
            let most_j = length(&spring) * input.shading.bulge_m.max(0.0);
            let taken = -acted.power(&moved) - share * whole_j;
            let works = [whole_j, share * whole_j, taken - (stored - last.stored)];
            self.budget.book(works, most_j, is_free);
            self.passivity.observe(taken, stored - last.stored, input.dt, is_free);
        }
        let share = self.budget.share(input.dt);
        let pulled = pulled + shaded * share;
        // What is paid now is in the books when the delay is over; until then each tick pays its part.
        let part = 1.0 / (1 + self.delay_ticks) as f64;
        let expected = self.expected_j(&coupling, &ForceInput { proxy_twist, ..*input }, stored);
        let damped = self.passivity.damping(&input.device_twist, part, expected, input.dt);
        let wanted = added_within(&pulled, &damped, coupling.max_force_n, coupling.max_torque_nm);

        let before = self.wrench();
        let wrench = Wrench {
            force: slewed(&before.force, &wanted.force, coupling.slew_n_per_s * input.dt),
            torque: slewed(&before.torque, &wanted.torque, coupling.slew_nm_per_s * input.dt),
        };
        if !(wrench.is_finite() && stored.is_finite()) {
            return None;
        }
        self.last = Some(Last { device: input.device, stored });
        Some((wrench, (shaded, share)))
    }
}

impl ForceLoop {
    /// What the springs will give for nothing in the tick that this one's wrench acts in, joules: it is then old by the
    /// delay and half a tick, while the stretch goes on as it does. A spring that pulls with all it may gives less.
    fn expected_j(&self, coupling: &Coupling, input: &ForceInput, stored: f64) -> f64 {
        if stored == 0.0 {
            return 0.0;
        }
        let rate = input.proxy_twist - input.device_twist;
        let stiffening = coupling.stiffness_n_per_m * dot(&rate.linear, &rate.linear)
            + coupling.rotational_stiffness_nm_per_rad * dot(&rate.angular, &rate.angular);
        stiffening * (0.5 + self.delay_ticks as f64) * input.dt * input.dt
    }
}

/// But for the rounding of a rate and of differences of times.
pub(crate) fn is_tick(dt: f64) -> bool {
    ((1.0 - 1e-9) * SHORTEST_TICK_S..=(1.0 + 1e-9) * LONGEST_TICK_S).contains(&dt)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::device::simulated::SimulatedOptions;
    use feeler_core::geometry::twist::{pose_of, rotation_of};
    use proptest::prelude::*;

    const TICK: f64 = 1e-3;

    fn device_loop(options: &SimulatedOptions) -> ForceLoop {
        let info = &options.info;
        ForceLoop::new(Coupling::for_device(info), info.driven, &info.limits, 1.0 / TICK).unwrap()
    }

    /// The device 2 mm below the proxy.
    fn pressed() -> ForceInput {
        ForceInput {
            device: Pose::IDENTITY.translated(&[0.0, 0.0, -0.002]).unwrap(),
            device_twist: Twist::ZERO,
            proxy: Pose::IDENTITY,
            proxy_twist: Twist::ZERO,
            shading: Shading::NONE,
            dt: TICK,
            in_doubt: false,
        }
    }

    fn pressed_on(force: &mut ForceLoop, ticks: usize) -> Wrench {
        (0..ticks).map(|_| force.step(&pressed())).last().unwrap()
    }

    #[test]
    fn a_pressed_spring_is_felt() {
        let mut force = device_loop(&SimulatedOptions::desktop_6dof());
        let found = pressed_on(&mut force, 400);
        let expected = 0.002 * force.coupling().stiffness_n_per_m;
        assert!((found.force[2] - expected).abs() < 1e-12 && found.force[0] == 0.0, "{found:?} {expected}");
    }

    /// Which of the nearby triangles touch is not certain, and each means another smooth surface.
    #[test]
    fn a_shading_that_flips_does_not_buzz() {
        let mut force = device_loop(&SimulatedOptions::desktop_6dof());
        let flipped = |by: f64| {
            let shading = Shading { turn: [0.15 * by, 0.0, 0.0], height_m: 5e-5 * by, bulge_m: 1e-4 };
            ForceInput { shading, ..pressed() }
        };
        for _ in 0..400 {
            force.step(&flipped(1.0));
        }
        assert!(force.wrench().force[1].abs() > 0.1 * force.wrench().force[2], "{:?}", force.wrench());
        for tick in 0..100 {
            let before = force.wrench().force;
            let found = force.step(&flipped(if tick % 2 == 0 { -1.0 } else { 1.0 })).force;
            assert!(length(&sub(&found, &before)) < 0.02 * length(&before), "tick {tick}: {before:?} {found:?}");
        }
    }

    #[test]
    fn zero_whenever_in_doubt_and_back_by_the_slew() {
        let doubts: [fn(&mut ForceInput); 11] = [
            |i| i.in_doubt = true,
            |i| i.dt = f64::NAN,
            |i| i.dt = 0.0,
            |i| i.dt = -TICK,
            |i| i.dt = 0.1,
            |i| i.dt = 1e-9,
            |i| i.device_twist.linear[1] = f64::NAN,
            |i| i.proxy_twist.angular[0] = f64::INFINITY,
            |i| i.device = i.device.translated(&[1.0, 0.0, 0.0]).unwrap(),
            |i| i.device = pose_of(&rotation_of(&[0.0, 2.0, 0.0]), i.device.translation()).unwrap(),
            |i| i.proxy = i.proxy.translated(&[0.0, 0.0, 1e90]).unwrap(),
        ];
        let last = doubts.len() - 1;
        for (case, spoil) in doubts.into_iter().enumerate() {
            let mut force = device_loop(&SimulatedOptions::desktop_6dof());
            let before = pressed_on(&mut force, 400);
            assert!(before.force[2] > 1.0);
            let mut input = pressed();
            spoil(&mut input);
            let found = force.step(&input);
            if case == last {
                // Far away is no doubt as long as it can be told; it is only a force at its bound.
                assert!(found.is_finite() && length(&found.force) <= 12.0 * (1.0 + 1e-12), "{found:?}");
                continue;
            }
            assert_eq!(found, Wrench::ZERO, "case {case}");
            // A device that has jumped away may jump back: one more tick of doubt.
            let mut previous = found;
            for tick in 0..400 {
                let found = force.step(&pressed());
                let change = length(&sub(&found.force, &previous.force));
                assert!(change <= force.coupling().slew_n_per_s * TICK * (1.0 + 1e-12), "case {case}, tick {tick}");
                assert!(
                    length(&found.force) <= 12.0 * (tick + 1) as f64 * TICK / RETURN_S * (1.0 + 1e-9),
                    "case {case}"
                );
                previous = found;
            }
            assert!((previous.force[2] - before.force[2]).abs() < 1e-9, "case {case}: {previous:?}");
        }
    }

    #[test]
    fn release_is_zero_at_once() {
        let mut force = device_loop(&SimulatedOptions::desktop_3dof());
        pressed_on(&mut force, 400);
        force.release();
        assert_eq!((force.wrench(), force.surplus_j()), (Wrench::ZERO, 0.0));
        assert!(length(&force.step(&pressed()).force) < 0.1);
    }

    #[test]
    fn what_cannot_be_a_loop_is_refused() {
        let info = SimulatedOptions::desktop_3dof().info;
        let coupling = Coupling::for_device(&info);
        for rate in [0.0, -1000.0, 10.0, 1e6, f64::NAN] {
            assert!(ForceLoop::new(coupling, info.driven, &info.limits, rate).is_err(), "{rate}");
        }
        let unknown = DeviceLimits { force_n: f64::NAN, ..info.limits };
        assert!(ForceLoop::new(coupling, info.driven, &unknown, 1000.0).is_err());
        let wrong = Coupling { stiffness_n_per_m: f64::NAN, ..coupling };
        assert!(ForceLoop::new(wrong, info.driven, &info.limits, 1000.0).is_err());
        assert!(device_loop(&SimulatedOptions::desktop_3dof()).set_coupling(wrong).is_err());
    }

    #[test]
    fn another_coupling_comes_by_the_slew() {
        let mut force = device_loop(&SimulatedOptions::desktop_3dof());
        let before = pressed_on(&mut force, 400);
        let softer = Coupling { stiffness_n_per_m: 100.0, slew_n_per_s: 500.0, ..*force.coupling() };
        force.set_coupling(softer).unwrap();
        let next = force.step(&pressed());
        assert!((before.force[2] - next.force[2] - 0.5).abs() < 1e-9, "{before:?} {next:?}");
        assert!((pressed_on(&mut force, 50).force[2] - 0.2).abs() < 1e-9);
    }

    fn vector(most: f64) -> impl Strategy<Value = Point> {
        prop::array::uniform3(-most..most)
    }

    fn input() -> impl Strategy<Value = ForceInput> {
        let poses = (vector(0.02), vector(1.0), vector(0.02), vector(1.0));
        let twists = (vector(1.0), vector(10.0), vector(1.0), vector(10.0));
        (poses, twists, 1e-4..5e-3f64, 0..20u32).prop_map(|(p, t, dt, odd)| ForceInput {
            device: pose_of(&rotation_of(&p.1), &p.0).unwrap(),
            device_twist: Twist { linear: t.0, angular: t.1 },
            proxy: pose_of(&rotation_of(&p.3), &p.2).unwrap(),
            proxy_twist: Twist { linear: t.2, angular: t.3 },
            shading: Shading { turn: scaled(&t.1, 0.03), height_m: 5e-5, bulge_m: 1e-4 },
            dt: if odd == 1 { f64::NAN } else { dt },
            in_doubt: odd == 0,
        })
    }

    proptest! {
        /// Whatever comes in, in whatever order.
        #[test]
        fn never_above_the_bound_and_never_faster_than_the_slew(
            inputs in prop::collection::vec(input(), 1..300), is_6dof in any::<bool>(), delay in 0.0..5e-3f64,
        ) {
            let mut options = if is_6dof { SimulatedOptions::desktop_6dof() } else { SimulatedOptions::desktop_3dof() };
            options.info.limits.delay_s = delay;
            let limits = options.info.limits;
            let mut force = device_loop(&options);
            let coupling = *force.coupling();
            let mut before = Wrench::ZERO;
            for input in inputs {
                let found = force.step(&input);
                prop_assert!(found.is_finite());
                prop_assert!(length(&found.force) <= limits.force_n * (1.0 + 1e-12));
                prop_assert!(length(&found.torque) <= limits.torque_nm * (1.0 + 1e-12));
                if input.in_doubt || input.dt.is_nan() {
                    prop_assert_eq!(found, Wrench::ZERO);
                } else if found != Wrench::ZERO {
                    let change = found - before;
                    prop_assert!(length(&change.force) <= coupling.slew_n_per_s * input.dt * (1.0 + 1e-9));
                    prop_assert!(length(&change.torque) <= coupling.slew_nm_per_s * input.dt * (1.0 + 1e-9) + 1e-15);
                }
                if !is_6dof {
                    prop_assert_eq!(found.torque, [0.0; 3]);
                }
                before = found;
            }
        }
    }
}
