//! A session: proxy, servo and clock in one thread, deterministic. It does in sequence what a run does in parallel
//! threads.

use std::sync::Arc;

use feeler_contacts::Penetration;
use feeler_core::geometry::twist::{displaced, displacement, Twist, Wrench};
use feeler_core::geometry::vectors::scaled;
use feeler_core::tool::metric::Metric;
use feeler_core::{Point, Pose, Scene, Tool};
use feeler_world::{Body, PutDown, Release, Seat, SeatKind, World};

use crate::constants::{HELD_SHARE, LONGEST_TICK_S, MOST_CATCH_UPS, RATE_SHARE, SHORTEST_TICK_S};
use crate::constraint_set::{ConstraintSet, Plane};
use crate::coupling::Coupling;
use crate::device::{DeviceLimits, Freedoms};
use crate::error::{Error, Result};
use crate::proxy::{Advance, Proxy, ProxyOptions};
use crate::servo::{Mode, Servo, ServoInput, ServoOutput};

/// How a session is to be.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct SessionOptions {
    /// How the hand is held to the tool.
    pub coupling: Coupling,
    /// How the proxy is kept off.
    pub proxy: ProxyOptions,
    /// How often contacts are found, hertz; `None`: each step.
    pub collision_hz: Option<f64>,
    /// Which freedoms the device drives.
    pub driven: Freedoms,
    /// Whether the force on the facets of a curved surface is that on the surface which they stand for.
    pub shading: bool,
    /// The device's limits; `None`: those of the coupling.
    pub limits: Option<DeviceLimits>,
}

impl Default for SessionOptions {
    fn default() -> SessionOptions {
        SessionOptions {
            coupling: Coupling::default(),
            proxy: ProxyOptions::default(),
            collision_hz: None,
            driven: Freedoms { translation: true, rotation: true },
            shading: true,
            limits: None,
        }
    }
}

impl SessionOptions {
    feeler_core::setters! {
        with_coupling: coupling: Coupling,
        with_proxy: proxy: ProxyOptions,
        with_collision_hz: collision_hz: impl Into<Option<f64>>,
        with_driven: driven: Freedoms,
        with_shading: shading: bool,
        with_limits: limits: impl Into<Option<DeviceLimits>>,
    }
}

impl SessionOptions {
    /// What the device holds, or a device that just holds the coupling at ticks of `dt` seconds: its damping is what Colgate's bound asks.
    pub fn limits(&self, dt: f64) -> DeviceLimits {
        let Coupling { stiffness_n_per_m, damping_n_s_per_m, .. } = self.coupling;
        let Coupling { rotational_stiffness_nm_per_rad, rotational_damping_nm_s_per_rad, .. } = self.coupling;
        let asked = |stiffness: f64, damping: f64| (0.5 * stiffness * dt + damping) / HELD_SHARE;
        self.limits.unwrap_or(DeviceLimits {
            force_n: self.coupling.max_force_n,
            torque_nm: self.coupling.max_torque_nm,
            damping_n_s_per_m: asked(stiffness_n_per_m, damping_n_s_per_m),
            rotational_damping_nm_s_per_rad: asked(rotational_stiffness_nm_per_rad, rotational_damping_nm_s_per_rad),
            ..DeviceLimits::default()
        })
    }

    /// Errors where a number is out of its range.
    pub fn check(&self) -> Result<()> {
        self.coupling.check()?;
        self.proxy.check()?;
        self.limits(1.0).check()?;
        match self.collision_hz {
            Some(value) if !(value.is_finite() && value > 0.0) => {
                Err(Error::Option { what: "collision_hz", value, range: "positive (hertz)" })
            }
            _ => Ok(()),
        }
    }
}

/// How a session began.
#[derive(Debug, Clone, PartialEq)]
pub enum Start {
    /// The proxy is where the device is.
    Free,
    /// The tool meets something there, and is seated on it.
    Seated(Seating),
}

/// The contacts at the start of a session. The tool may slide along them and separate, but not move deeper.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Seating {
    /// Seats, as pairs of parts with their kind; part numbers are the mock-up's.
    pub seats: Vec<Seat>,
    /// The shortest translation found that frees the tool, where it is sunk in something: of the body that it is deepest in.
    pub way_out: Option<Penetration>,
}

/// The result of a step.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Step {
    /// `world_from_tool`, free by the exact test but for seats, and reached by a free motion.
    pub proxy: Pose,
    /// On the hand, world axes, the torque about where it holds the tool: [`Session::centre`].
    pub wrench: Wrench,
    /// Age of the constraints, seconds.
    pub age: f64,
    /// The state of the proxy.
    pub mode: Mode,
}

/// The servo's last tick.
#[derive(Debug, Clone, Copy)]
struct Ticked {
    at: f64,
    device: Pose,
    output: ServoOutput,
}

/// A device, a tool and a mock-up, stepped by who holds the clock. See the [crate](crate).
#[derive(Debug)]
pub struct Session {
    options: SessionOptions,
    world: World,
    /// Parts that lie elsewhere from the beginning.
    put_down: Vec<PutDown>,
    /// The metric of "nearest" by the tool's own inertia, and the one in use.
    inertia: Metric,
    metric: Metric,
    proxy: Option<Proxy>,
    servo: Option<Servo>,
    /// The tick that the servo's limits are of, seconds.
    dt: f64,
    ticked: Option<Ticked>,
    clock: f64,
    /// When contacts were found.
    found: Option<f64>,
    is_started: bool,
    last_device: Option<Pose>,
    advance: Advance,
}

impl Session {
    /// A session that is not started. Errors where an option is out of its range.
    pub fn new(scene: Arc<Scene>, tool: Arc<Tool>, options: SessionOptions) -> Result<Session> {
        Session::with_put_down(scene, tool, Vec::new(), options)
    }

    /// The same with parts of the mock-up that lie elsewhere, as if the session had put them down: each is felt where it lies, under its
    /// number, can be taken, and is not where it was.
    ///
    /// Errors beside those of options: no such part, one that is given twice, a scene that is not of one part.
    pub fn with_put_down(
        scene: Arc<Scene>,
        tool: Arc<Tool>,
        put_down: Vec<PutDown>,
        mut options: SessionOptions,
    ) -> Result<Session> {
        options.check()?;
        options.proxy = options.proxy.with_pull_of(&options.coupling);
        let inertia = Metric::new(&tool);
        let metric = inertia.with_lever(options.coupling.lever_m()).unwrap_or(inertia);
        Ok(Session {
            options,
            world: World::new(scene, tool, &put_down)?,
            put_down,
            inertia,
            metric,
            proxy: None,
            servo: None,
            dt: 0.0,
            ticked: None,
            clock: 0.0,
            found: None,
            is_started: false,
            last_device: None,
            advance: Advance::default(),
        })
    }

    /// Begins, or begins anew, at a pose of the device (`world_from_tool`).
    pub fn start(&mut self, device: &Pose) -> Result<Start> {
        (self.clock, self.found, self.last_device) = (0.0, None, Some(*device));
        self.forget_servo();
        self.world.move_to(device)?;
        self.proxy = Some(Proxy::new(self.world.around(), self.metric, self.options.proxy)?);
        self.is_started = true;
        let seats: Vec<Seat> = self.world.around().seats().collect();
        if seats.is_empty() {
            return Ok(Start::Free);
        }
        let is_sunk = seats.iter().any(|seat| seat.kind == SeatKind::Sunk);
        let way_out = if is_sunk { Some(self.way_out(device)?) } else { None };
        Ok(Start::Seated(Seating { seats, way_out }))
    }

    /// Of the body that the tool is deepest in.
    fn way_out(&self, pose: &Pose) -> Result<Penetration> {
        let (bodies, margin) = (&self.world.around().environment().bodies, self.options.proxy.margin);
        let way = |body: &Body| body.solver.penetration(self.world.tool(), pose, margin, None);
        let mut deepest = way(&bodies[0])?;
        for body in &bodies[1..] {
            let other = way(body)?;
            if other.depth > deepest.depth {
                deepest = other;
            }
        }
        Ok(deepest)
    }

    /// One step of `dt` seconds with the device at a pose (`world_from_tool`), or `None` if it reported an invalid one:
    /// then the force is released, and the proxy stays.
    ///
    /// Errors: the session is not started, and `dt` out of range.
    pub fn step(&mut self, device: Option<&Pose>, dt: f64) -> Result<Step> {
        if !self.is_started {
            return Err(Error::NotStarted);
        }
        if !(dt.is_finite() && dt > 0.0 && dt <= 1.0) {
            return Err(Error::Option { what: "dt", value: dt, range: "above 0, and at most 1 (seconds)" });
        }
        self.clock += dt;
        let Some(device) = device.or(self.last_device.as_ref()).copied().filter(|_| device.is_some()) else {
            return Ok(self.step_in_doubt());
        };
        self.last_device = Some(device);
        let period = self.options.collision_hz.map_or(0.0, |hz| 1.0 / hz);
        if self.found.is_none_or(|found| self.clock - found + 0.5 * dt >= period) {
            self.find_contacts(&device)?;
            self.found = Some(self.clock);
        }
        // The force is that of the servo side's proxy. Where contacts are new it is the step's too, unless the way there is not free.
        let is_new = self.found == Some(self.clock);
        let mut ahead = if is_new { self.ahead(&device) } else { None };
        for _ in 0..MOST_CATCH_UPS {
            // A little is the same facet.
            let skin = self.options.proxy.skin;
            if let Some((pose, true)) = ahead.filter(|(pose, _)| self.reach_to(pose) > skin) {
                self.move_on(&pose)?;
                ahead = self.ahead(&device);
            }
        }
        let output = self.tick(&device, dt, ahead.is_some_and(|(_, is_free)| !is_free))?;
        if let Some((pose, true)) = ahead {
            self.move_on(&pose)?;
        }
        let pose = *self.proxy.as_ref().ok_or(Error::NotStarted)?.pose();
        Ok(Step { proxy: pose, wrench: output.wrench, age: output.age, mode: output.mode })
    }

    /// Where the servo side will have the proxy, if that is elsewhere, and whether the way there is free.
    fn ahead(&self, device: &Pose) -> Option<(Pose, bool)> {
        let proxy = self.proxy.as_ref()?;
        proxy.ahead(self.world.around(), device).ok()?
    }

    /// How far any point of the tool is from there, metres.
    fn reach_to(&self, pose: &Pose) -> f64 {
        self.proxy.as_ref().map_or(0.0, |proxy| proxy.reach_to(pose))
    }

    fn move_on(&mut self, pose: &Pose) -> Result<()> {
        let Some(proxy) = &mut self.proxy else { return Ok(()) };
        proxy.move_on(self.world.around(), pose)?;
        if self.options.shading {
            proxy.shade(self.world.around());
        }
        Ok(())
    }

    /// The servo side of a step: as many ticks as it is long for, the device moving evenly from the last to this pose; or none, and the
    /// last wrench stands, until steps that are shorter than any tick make one. `is_blocked`: the proxy can go no farther than it is.
    fn tick(&mut self, device: &Pose, dt: f64, is_blocked: bool) -> Result<ServoOutput> {
        let since = self.ticked.map_or(dt, |ticked| self.clock - ticked.at);
        let whole = if (since - dt).abs() <= 1e-9 * dt { dt } else { since };
        if let Some(ticked) = self.ticked.filter(|_| whole < SHORTEST_TICK_S) {
            return Ok(ticked.output);
        }
        let count = (whole / LONGEST_TICK_S - 1e-9).ceil().max(1.0);
        let part = (whole / count).clamp(SHORTEST_TICK_S, LONGEST_TICK_S);
        self.set_rate(part)?;
        let (Some(proxy), Some(servo)) = (&self.proxy, &mut self.servo) else { return Err(Error::NotStarted) };
        let from = self.ticked.map_or(*device, |ticked| ticked.device);
        let way = displacement(&from, device, &self.metric.centre);
        let mut tick = |device: Pose, now: f64| {
            servo.tick(proxy.constraints(), &ServoInput { device, device_twist: None, now, dt: part, in_doubt: false })
        };
        for i in 1..count as u32 {
            let share = f64::from(i) / count;
            let by = Twist { linear: scaled(&way.linear, share), angular: scaled(&way.angular, share) };
            tick(displaced(&from, &by, &self.metric.centre)?, self.clock - (1.0 - share) * whole);
        }
        let output = if is_blocked {
            let last = ServoInput { device: *device, device_twist: None, now: self.clock, dt: part, in_doubt: false };
            servo.tick_at(proxy.constraints(), &last)
        } else {
            tick(*device, self.clock)
        };
        self.ticked = Some(Ticked { at: self.clock, device: *device, output });
        Ok(output)
    }

    /// Makes the servo, or gives it other limits where ticks are clearly longer or shorter than those that its limits are of.
    fn set_rate(&mut self, dt: f64) -> Result<()> {
        let SessionOptions { coupling, driven, .. } = self.options;
        match &mut self.servo {
            Some(_) if (1.0 / RATE_SHARE..=RATE_SHARE).contains(&(dt / self.dt)) => return Ok(()),
            Some(servo) => servo.set_rate(&self.options.limits(dt), 1.0 / dt)?,
            none => *none = Some(Servo::new(coupling, driven, &self.options.limits(dt), 1.0 / dt, self.metric.centre)?),
        }
        self.dt = dt;
        Ok(())
    }

    fn forget_servo(&mut self) {
        (self.servo, self.dt, self.ticked) = (None, 0.0, None);
    }

    /// The collision side of a step alone: the proxy towards the device, and its contacts. Whether there is a proxy.
    pub(crate) fn track(&mut self, device: &Pose, now: f64) -> Result<bool> {
        (self.clock, self.last_device) = (now, Some(*device));
        self.find_contacts(device)?;
        Ok(self.proxy.is_some())
    }

    /// Another coupling from now on, as a device holds it: its springs say what nearest means.
    pub(crate) fn set_coupling(&mut self, coupling: Coupling) {
        self.options.coupling = coupling;
        self.options.proxy = self.options.proxy.with_pull_of(&coupling);
        self.metric = self.inertia.with_lever(coupling.lever_m()).unwrap_or(self.inertia);
        if let Some(proxy) = &mut self.proxy {
            proxy.set_metric(self.metric, self.options.proxy);
        }
        self.forget_servo();
    }

    /// To be stepped after others have [tracked](Self::track): contacts are found by the first step.
    pub(crate) fn resume(&mut self) {
        self.found = None;
        self.forget_servo();
    }

    /// Replaces the scene: held parts and parts put down belong to the old one and are gone, except those that lay
    /// elsewhere when the session was made, which lie there again. The proxy stays where it is; its contacts there are
    /// seats.
    ///
    /// Errors if a part that lies elsewhere does not exist in the new mock-up: the scene then stays the present one.
    pub fn set_scene(&mut self, scene: Arc<Scene>) -> Result<Start> {
        self.world = World::new(scene, self.world.own_tool().clone(), &self.put_down)?;
        let Some(pose) = self.pose().copied() else { return Ok(Start::Free) };
        let clock = self.clock;
        let start = self.start(&pose)?;
        self.clock = clock;
        if let Some(proxy) = &mut self.proxy {
            proxy.set_time(clock);
        }
        Ok(start)
    }

    /// Where the proxy is, `world_from_tool`; where there is none, the device's last pose. `None` before the start.
    pub fn pose(&self) -> Option<&Pose> {
        let proxy = self.proxy.as_ref().map(Proxy::pose);
        proxy.or(self.last_device.as_ref()).filter(|_| self.is_started)
    }

    /// What nearest means for the tool.
    #[doc(hidden)]
    pub fn metric(&self) -> Metric {
        self.metric
    }

    /// Where the hand holds the tool, tool frame: the tool's centre of area. There the coupling's springs act, and torque is about it,
    /// so that a tool feels the same wherever its frame's origin is.
    pub fn centre(&self) -> Point {
        self.metric.centre
    }

    fn step_in_doubt(&mut self) -> Step {
        if let Some(servo) = &mut self.servo {
            servo.let_go();
        }
        self.ticked = None;
        let age = self.proxy.as_ref().map_or(0.0, |proxy| self.clock - proxy.constraints().time);
        let proxy = self.proxy.as_ref().map(|proxy| *proxy.pose()).or(self.last_device).unwrap_or(Pose::IDENTITY);
        Step { proxy, wrench: Wrench::ZERO, age, mode: Mode::Doubt }
    }

    fn find_contacts(&mut self, device: &Pose) -> Result<()> {
        let Some(proxy) = &mut self.proxy else { return Ok(()) };
        self.advance = proxy.advance(self.world.around(), device)?;
        if self.options.shading {
            proxy.shade(self.world.around());
        }
        proxy.set_time(self.clock);
        Ok(())
    }

    /// Hands the changed world to the proxy.
    fn hand_over(&mut self) -> Result<()> {
        let Some(proxy) = &mut self.proxy else { return Ok(()) };
        proxy.set_world(self.world.around())
    }

    /// Takes parts of the mock-up, or such as were put down: from now on they move with the tool. The spring stays where it was, so the
    /// force does not jump.
    ///
    /// Errors: not started, something is held already, no such part.
    pub fn grip(&mut self, parts: &[u32]) -> Result<()> {
        let pose = *self.proxy.as_ref().ok_or(Error::NotStarted)?.pose();
        self.world.grip(parts, &pose)?;
        self.hand_over()
    }

    /// Releases what is held. Errors: not started, nothing is held, and with [`Release::PutBack`] where the tool is in a part's place.
    pub fn release(&mut self, to: Release) -> Result<()> {
        let pose = *self.proxy.as_ref().ok_or(Error::NotStarted)?.pose();
        self.world.release(to, &pose)?;
        self.hand_over()
    }

    /// The parts that are held.
    pub fn gripped(&self) -> impl Iterator<Item = u32> + '_ {
        self.world.gripped().iter().map(|grip| grip.part)
    }

    /// Whether the tool, at a pose, collides with anything but its seats, exactly.
    pub fn is_colliding(&self, pose: &Pose) -> bool {
        let around = self.world.around();
        match &self.proxy {
            Some(proxy) => around.is_colliding(proxy.seated(), pose),
            None => around.is_colliding(&around.seated_at_start(), pose),
        }
    }

    /// The parts on which the tool is still seated.
    pub fn seats(&self) -> Vec<Seat> {
        let seats = self.world.around().seats();
        self.proxy.as_ref().map_or(Vec::new(), |proxy| proxy.seated().of(seats))
    }

    /// The held parts and the surroundings.
    pub fn world(&self) -> &World {
        &self.world
    }

    /// The contact planes at the proxy, nearest first.
    pub fn planes(&self) -> &[Plane] {
        self.constraints().map_or(&[], ConstraintSet::planes)
    }

    /// The newest constraints; `None` before there is a proxy.
    #[doc(hidden)]
    pub fn constraints(&self) -> Option<&ConstraintSet> {
        self.proxy.as_ref().map(Proxy::constraints)
    }

    /// The planes that hold the proxy.
    pub fn held(&self) -> impl Iterator<Item = &Plane> {
        let held = self.servo.as_ref().map_or(&[][..], Servo::held);
        self.planes().iter().filter(|plane| held.contains(&plane.id))
    }

    /// What the last search for contacts took.
    #[doc(hidden)]
    pub fn last_advance(&self) -> Advance {
        self.advance
    }

    /// The options.
    pub fn options(&self) -> &SessionOptions {
        &self.options
    }
}
