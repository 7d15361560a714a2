//! The servo side: device, mapping, the newest constraints, force. It has no thread or clock of its own, takes no lock,
//! and allocates nothing unless the device fails.

use feeler_core::geometry::twist::Wrench;
use feeler_core::geometry::vectors::{length, scaled, sub};
use feeler_core::{Point, Pose};
use rtrb::Producer;
use triple_buffer::{Input, Output};

use super::exchange::{Handed, Target, Told, View};
use super::reports::Reports;
use super::trace::TraceTick;
use crate::constants::{JUMP_SPEED, RETURN_S, SILENT_PERIODS, SILENT_S, STATISTICS_PERIOD_S, VIEW_PLANES};
use crate::constraint_set::Plane;
use crate::coupling::Coupling;
use crate::device::mapping::{Mapped, Mapping};
use crate::device::{Device, DeviceError, DeviceInfo, DeviceState};
use crate::error::{Error, Result};
use crate::force::is_tick;
use crate::guide::{beside, GuideForce};
use crate::saturation::slewed;
use crate::servo::{Mode, Servo, ServoInput, ServoOutput};
use crate::stability::Limitations;
use crate::statistics::ServoRecord;

/// Lets go of the force whatever happens: also where the thread that has it panics.
pub(super) struct Held(Option<Box<dyn Device>>);

impl Drop for Held {
    fn drop(&mut self) {
        if let Some(device) = &mut self.0 {
            device.release();
        }
    }
}

/// The ends of the buffers that the servo side has.
pub(super) struct ServoEnds {
    pub targets: Input<Target>,
    pub sets: Output<Handed>,
    pub views: Input<View>,
    pub records: Input<ServoRecord>,
    pub trace: Producer<TraceTick>,
    pub guides: Output<Told>,
}

/// The soft wall's force on the way to the hand: it grows from nothing after letting go and after a jump of the handle, and changes by
/// no more than the coupling's slew.
#[derive(Debug, Clone, Copy, Default)]
struct Border {
    force: Point,
    share: f64,
    /// Where the handle was.
    last: Option<Point>,
}

impl Border {
    /// `wanted`: as the mapping has it, with the handle at a place. Seconds since the last tick.
    fn step(&mut self, wanted: &Point, place: &Point, slew_n_per_s: f64, dt: f64) -> Point {
        if self.last.replace(*place).is_some_and(|last| length(&sub(place, &last)) > JUMP_SPEED * dt) {
            *self = Border { last: self.last, ..Border::default() };
            return self.force;
        }
        self.share = (self.share + dt / RETURN_S).min(1.0);
        self.force = slewed(&self.force, &scaled(wanted, self.share), slew_n_per_s * dt);
        self.force
    }
}

/// The settings of a servo side.
pub(super) struct Setting {
    pub mapping: Mapping,
    pub is_absolute: bool,
    /// As limited to the device.
    pub coupling: Coupling,
    pub limitations: Limitations,
    /// Where the hand holds the tool, tool frame.
    pub centre: Point,
    pub start_pose: Pose,
    pub rate_hz: f64,
}

/// The servo side of a run: a tick from the device to its force. Has no thread of its own.
pub struct ServoSide {
    device: Held,
    mapping: Mapping,
    /// Where the device is in the world is as given, and a start does not change it.
    is_absolute: bool,
    /// The tool's pose for the handle's next reported pose.
    index_at: Option<Pose>,
    border: Border,
    guide: GuideForce,
    /// Where the hand holds the tool, and guide and coupling act, tool frame.
    centre: Point,
    servo: Servo,
    limitations: Limitations,
    ends: ServoEnds,
    record: ServoRecord,
    recorded: f64,
    period: f64,
    silent_s: f64,
    reports: Reports,
    has_news: bool,
    /// Share of the soft wall's stiffness that the servo's rate leaves.
    wall_share: f64,
    start: u64,
    target: Target,
    last: Option<f64>,
    last_error: Option<DeviceError>,
}

impl ServoSide {
    /// Errors where the coupling is out of its ranges at the rate; the device comes back.
    pub(super) fn new(
        device: Box<dyn Device>,
        setting: Setting,
        ends: ServoEnds,
    ) -> std::result::Result<ServoSide, (Error, Box<dyn Device>)> {
        let Setting { mapping, is_absolute, coupling, limitations, centre, start_pose, rate_hz } = setting;
        let info = mapping.info_in_world();
        let servo = match Servo::new(coupling, info.driven, &info.limits, rate_hz, centre) {
            Ok(servo) => servo,
            Err(error) => return Err((error, device)),
        };
        let limits = &info.limits;
        let between = if limits.rate_hz > 0.0 { 1.0 / limits.rate_hz } else { 0.0 };
        let (period, silent_s) = (1.0 / rate_hz, SILENT_S.max(SILENT_PERIODS * between));
        let wall_share = (limits.hold_s(limits.own_rate_hz()) / limits.hold_s(rate_hz)).min(1.0);
        Ok(ServoSide {
            device: Held(Some(device)),
            mapping,
            is_absolute,
            index_at: (!is_absolute).then_some(start_pose),
            border: Border::default(),
            guide: GuideForce::default(),
            centre,
            servo,
            limitations,
            ends,
            record: ServoRecord::default(),
            recorded: f64::NEG_INFINITY,
            period,
            silent_s,
            reports: Reports::new(period.max(between), silent_s),
            has_news: false,
            wall_share,
            start: 0,
            target: Target { pose: start_pose, number: 0, start: 0 },
            last: None,
            last_error: None,
        })
    }

    /// The coupling in use, and how the device limited the wanted one.
    pub fn coupling(&self) -> (&Coupling, &Limitations) {
        (self.servo.coupling(), &self.limitations)
    }

    /// The device's figures, as felt in the tool's world.
    pub fn info_in_world(&self) -> DeviceInfo {
        self.mapping.info_in_world()
    }

    /// Why the device last failed.
    pub fn last_error(&self) -> Option<&DeviceError> {
        self.last_error.as_ref()
    }

    /// Whether the device failed and does not go on.
    pub fn is_broken(&self) -> bool {
        matches!(self.last_error, Some(DeviceError::Broken { .. }))
    }

    /// One tick.
    pub fn tick(&mut self, now: f64) {
        let dt = self.last.map_or(self.period, |last| now - last);
        if self.last.replace(now).is_none() {
            // What the session had found stands until the collision side has looked; its time is on another clock.
            self.ends.sets.output_buffer_mut().set.time = now;
        }
        self.ends.sets.update();
        self.follow_starts();
        let mapped = self.read(now);
        if let Some(mapped) = &mapped {
            let Target { number, .. } = self.target;
            self.target = Target { pose: mapped.world_from_tool, number: number + 1, start: self.start };
            *self.ends.targets.input_buffer_mut() = self.target;
            self.ends.targets.publish();
        }
        let is_clutched = mapped.is_some_and(|mapped| mapped.is_clutched);
        let mut output = self.answer(mapped.as_ref(), now, dt);
        self.guide(&mut output, now, dt);
        if let Some(twist) = mapped.and_then(|mapped| mapped.twist).filter(|_| self.is_rate_controlled()) {
            // Beyond the coordinate limit it stays as it is.
            let _ = self.mapping.keep_near(&output.proxy, &twist);
        }
        self.write(&output, now, dt);
        self.show(&output, mapped.as_ref(), is_clutched, now);
        self.count(&output, now);
    }

    /// A start puts the tool elsewhere: the handle where it is means that place from now on.
    fn follow_starts(&mut self) {
        let handed = self.ends.sets.output_buffer();
        if handed.start != self.start {
            self.start = handed.start;
            self.index_at = (!self.is_absolute).then_some(handed.start_pose);
            self.target.pose = handed.start_pose;
            self.servo.let_go();
            self.guide.let_go();
        }
    }

    /// The device's reading, in the world; `None` where it is not plausible.
    fn read(&mut self, now: f64) -> Option<Mapped> {
        let read = self.device.0.as_mut()?.read(now);
        let state = match read {
            Ok(state) => state,
            Err(error) => {
                self.fail(error);
                return None;
            }
        };
        if !self.is_credible(&state, now) {
            return None;
        }
        self.has_news |= self.reports.saw(state.time, now);
        let mapped: Result<Mapped> = match self.index_at.take() {
            Some(pose) => self.mapping.update(&state).and_then(|_| {
                self.mapping.set_tool(&pose);
                self.mapping.update(&state)
            }),
            None => self.mapping.update(&state),
        };
        mapped.ok()
    }

    /// Whether it is new enough, and all of it a number.
    fn is_credible(&self, state: &DeviceState, now: f64) -> bool {
        let is_new = now - state.time <= self.silent_s;
        is_new && state.twist.is_none_or(|twist| twist.is_finite())
    }

    fn answer(&mut self, mapped: Option<&Mapped>, now: f64, dt: f64) -> ServoOutput {
        let handed = self.ends.sets.output_buffer();
        let device = mapped.map_or(self.target.pose, |mapped| mapped.world_from_tool);
        if !handed.has_proxy {
            self.servo.let_go();
            return ServoOutput { wrench: Wrench::ZERO, proxy: device, age: 0.0, mode: Mode::Doubt };
        }
        // A clutch is no doubt, but it has no force either.
        let in_doubt = mapped.is_none_or(|mapped| mapped.is_clutched);
        let device_twist = mapped.and_then(|mapped| mapped.twist);
        let has_news = std::mem::take(&mut self.has_news);
        self.servo.set_reports(has_news, self.reports.period_s(), self.reports.late_s());
        let mut output = self.servo.tick(&handed.set, &ServoInput { device, device_twist, now, dt, in_doubt });
        if mapped.is_none() {
            // Velocities over a gap are none.
            self.servo.let_go();
            output.mode = Mode::Doubt;
        }
        output
    }

    /// Adds the force of a guide, as far as that of contact leaves room for it. In doubt there is none.
    fn guide(&mut self, output: &mut ServoOutput, now: f64, dt: f64) {
        if self.ends.guides.update() {
            self.guide.tell(self.ends.guides.output_buffer().guide, now);
        }
        let in_doubt = output.mode == Mode::Doubt || self.is_rate_controlled();
        let force = self.guide.step(&self.target.pose, &self.centre, now, dt, in_doubt);
        output.wrench = beside(&output.wrench, &force, self.servo.coupling());
    }

    fn is_rate_controlled(&self) -> bool {
        self.device.0.as_ref().is_some_and(|device| device.is_rate_controlled())
    }

    /// In doubt nothing is sent but zero, not even a soft wall.
    fn write(&mut self, output: &ServoOutput, now: f64, dt: f64) {
        let wrench = if output.mode == Mode::Doubt || !is_tick(dt) {
            self.border = Border::default();
            Wrench::ZERO
        } else {
            let slew = self.servo.coupling().slew_n_per_s;
            let wall = scaled(&self.mapping.wall(), self.wall_share * self.servo.stiffness_share());
            let wall = self.border.step(&wall, self.mapping.handle().translation(), slew, dt);
            self.mapping.wrench_with_wall(&output.wrench, &wall)
        };
        if let Some(Err(error)) = self.device.0.as_mut().map(|device| device.write(&wrench, now)) {
            self.fail(error);
            self.servo.let_go();
        }
    }

    fn fail(&mut self, error: DeviceError) {
        self.record.device_errors += 1;
        if !self.is_broken() {
            self.last_error = Some(error);
        }
    }

    /// Writes the view in place, and a tick of the trace if there is room.
    fn show(&mut self, output: &ServoOutput, mapped: Option<&Mapped>, is_clutched: bool, now: f64) {
        let handed = self.ends.sets.output_buffer();
        let device = self.target.pose;
        let proxy = if handed.has_proxy { handed.set.taken_at } else { device };
        let view = self.ends.views.input_buffer_mut();
        view.number = self.record.ticks + 1;
        (view.time, view.proxy, view.ahead, view.device) = (now, proxy, output.proxy, device);
        (view.wrench, view.age, view.mode) = (output.wrench, output.age, output.mode);
        (view.buttons, view.is_clutched) = (mapped.map_or(0, |mapped| mapped.held), is_clutched);
        view.stiffness_share = self.servo.stiffness_share();
        (view.periods_s, view.late_s) = ([self.servo.period_s(), self.reports.period_s()], self.reports.late_s());
        // A slot of the buffer has the planes of an earlier tick.
        (view.held, view.held_count) = ([Plane::default(); VIEW_PLANES], 0);
        if handed.has_proxy {
            let held = self.servo.held();
            for plane in handed.set.planes().iter().filter(|plane| held.contains(&plane.id)).take(VIEW_PLANES) {
                view.held[view.held_count] = *plane;
                view.held_count += 1;
            }
        }
        self.ends.views.publish();
        let (wrench, mode) = (output.wrench, output.mode);
        let tick = TraceTick { time: now, device, proxy, wrench, mode, has_device: mapped.is_some() };
        if self.ends.trace.push(tick).is_err() {
            self.record.trace_lost += 1;
        }
    }

    fn count(&mut self, output: &ServoOutput, now: f64) {
        let record = &mut self.record;
        let first = if record.ticks == 0 { now } else { record.span[0] };
        record.span = [first, now];
        record.ticks += 1;
        record.doubts += u64::from(output.mode == Mode::Doubt);
        record.age.record(output.age);
    }

    /// Counts how late the last tick began, how long it took (seconds), and how many were left out.
    pub fn took(&mut self, lateness: f64, seconds: f64, misses: u64, now: f64) {
        let record = &mut self.record;
        record.lateness.record(lateness);
        record.tick.record(seconds);
        record.misses += misses;
        if now - self.recorded >= STATISTICS_PERIOD_S {
            self.recorded = now;
            self.publish_record();
        }
    }

    fn publish_record(&mut self) {
        self.ends.records.input_buffer_mut().copy_from(&self.record);
        self.ends.records.publish();
    }

    /// Lets go of the force, for good.
    pub fn release(&mut self) {
        if let Some(device) = &mut self.device.0 {
            device.release();
        }
        self.publish_record();
    }

    /// Lets go of the force, and gives the device back.
    pub(super) fn into_device(mut self) -> Option<Box<dyn Device>> {
        self.release();
        self.device.0.take()
    }
}
