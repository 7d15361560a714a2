//! The two sides of a run, driven by hand in simulated time: each stalls, and the documented reaction follows.

mod common;

use std::sync::{Arc, Mutex};

use common::*;
use feeler_core::geometry::twist::displacement;
use feeler_core::geometry::vectors::length;
use feeler_haptics::device::faulty::{Fault, Faulty};
use feeler_haptics::device::hand::HandPath;
use feeler_haptics::device::simulated::SimulatedOptions;
use feeler_haptics::device::{Device, DeviceError, DeviceInfo, DeviceState, Freedoms};
use feeler_haptics::{Guide, Mode, RunnerOptions, Session, SessionOptions, Sides, Twist, View, Wrench};
use feeler_shapes::random::Random;

const TICK: f64 = 1e-3;

/// A run of both sides in one thread, which asserts the guarantees of every tick.
struct Drive {
    sides: Sides,
    tick: u32,
    views: Vec<View>,
}

impl Drive {
    fn new(session: Session, device: impl Device + 'static) -> Drive {
        let sides = Sides::new(session, Box::new(device), &RunnerOptions::default());
        Drive { sides: sides.map_err(|refused| refused.error).unwrap(), tick: 0, views: Vec::new() }
    }

    fn now(&self) -> f64 {
        f64::from(self.tick) * TICK
    }

    /// Runs a number of ticks. At each, closures decide whether the servo side and the collision side run.
    fn run(&mut self, ticks: u32, servo: impl Fn(u32) -> bool, collision: impl Fn(u32) -> bool) -> &[View] {
        let first = self.views.len();
        for k in 0..ticks {
            let now = self.now();
            if collision(k) {
                self.sides.collision.tick(now);
                let session = self.sides.collision.session();
                if let Some(pose) = session.pose().filter(|_| session.constraints().is_some()) {
                    assert!(!session.is_colliding(pose), "tick {k}");
                }
            }
            if servo(k) {
                self.sides.servo.tick(now);
                let view = *self.sides.watch.view();
                self.check(&view);
                self.views.push(view);
            }
            self.tick += 1;
        }
        &self.views[first..]
    }

    fn check(&self, view: &View) {
        let (coupling, _) = self.sides.servo.coupling();
        let most = coupling.max_force_n * (1.0 + 1e-9);
        assert!(length(&view.wrench.force) <= most, "{view:?}");
        assert!(length(&view.wrench.torque) <= coupling.max_torque_nm * (1.0 + 1e-9), "{view:?}");
        if view.mode == Mode::Doubt {
            assert_eq!(view.wrench, Wrench::ZERO, "{view:?}");
        }
        let session = self.sides.collision.session();
        if let Some(set) = session.constraints() {
            let metric = set.metric;
            let ahead = displacement(&view.proxy, &view.ahead, &metric.centre).reach(metric.radius);
            assert!(ahead <= set.margin, "{ahead} beyond {}: {view:?}", set.margin);
        }
    }
}

fn always(_: u32) -> bool {
    true
}

fn never(_: u32) -> bool {
    false
}

fn largest(views: &[View]) -> f64 {
    views.iter().map(|view| length(&view.wrench.force)).fold(0.0, f64::max)
}

#[test]
fn at_full_rate_the_block_stays_above_and_the_hand_feels_it() {
    let mut drive = Drive::new(started(plate(), SessionOptions::default()), device(pushing()));
    let views = drive.run(3000, always, always);
    assert!(views.iter().all(|view| view.proxy.translation()[2] > 0.0));
    let contact = views.iter().filter(|view| view.mode == Mode::Contact).count();
    assert!(contact > 2000, "{contact}");
    assert!(views[2000..].iter().all(|view| view.held().iter().all(|plane| plane.normal[2] > 0.999)));
    // The hand presses with 400 N/m over some 15 mm.
    assert!(largest(views) > 1.5, "{}", largest(views));
}

#[test]
fn a_guide_is_felt_beside_contact_and_no_longer_than_it_is_told() {
    let mut drive = Drive::new(started(plate(), SessionOptions::default()), device(pushing()));
    drive.run(2500, always, always);
    let contact = drive.views[2499].wrench.force;
    assert!(contact[2] > 1.0, "{contact:?}");
    let [x, y, z] = *drive.views[2499].device.translation();
    let place = at([x - 0.02, y, z], [0.0; 3]);
    for _ in 0..400 {
        drive.sides.watch.guide(Some(Guide { place, pull: [0.0; 3] }));
        drive.run(1, always, always);
    }
    let guided = drive.views[2899].wrench.force;
    assert!((0.5..1.5).contains(&(contact[0] - guided[0])), "{guided:?} {contact:?}");
    assert!((guided[2] / contact[2] - 1.0).abs() < 0.2, "{guided:?} {contact:?}");
    // Told no more, it draws no more, and contact is as it was.
    let views = drive.run(300, always, always);
    assert!(views[..90].iter().all(|view| contact[0] - view.wrench.force[0] > 0.4));
    let last = views[299].wrench.force;
    assert!((last[0] - contact[0]).abs() < 0.2, "{last:?} {contact:?}");
    // In doubt there is nothing of it either: the collision side is silent for too long.
    for _ in 0..700 {
        drive.sides.watch.guide(Some(Guide { place, pull: [1.0, 0.0, 0.0] }));
        drive.run(1, always, never);
    }
    assert_eq!(drive.views.last().map(|view| (view.mode, view.wrench)), Some((Mode::Doubt, Wrench::ZERO)));
}

#[test]
fn contacts_at_10_hz_drag_and_let_nothing_pass_a_sheet_of_no_thickness() {
    for phase in [0, 33, 77] {
        let mut drive = Drive::new(started(sheet(), SessionOptions::default()), device(pushing()));
        let views = drive.run(5000, always, |k| (k + phase) % 100 == 0);
        assert!(views.iter().all(|view| view.proxy.translation()[2] > 0.0 && view.ahead.translation()[2] > 0.0));
        assert!(views.iter().any(|view| view.mode == Mode::Bound));
        assert!(largest(views) > 1.5);
        // The hand rests from 3.05 s on: no limit cycle.
        let heights = views[4000..].iter().map(|view| view.device.translation()[2]);
        let (low, high) = heights.fold((f64::MAX, f64::MIN), |(low, high), z| (low.min(z), high.max(z)));
        assert!(high - low < 2e-4, "{}", high - low);
    }
}

#[test]
fn contacts_that_stay_away_for_a_second_hold_the_proxy_and_then_let_the_force_go() {
    let mut drive = Drive::new(started(plate(), SessionOptions::default()), device(pushing()));
    drive.run(400, always, always);
    let views = drive.run(1000, always, never);
    let proxy = views[0].proxy;
    assert!(views.iter().all(|view| view.proxy == proxy));
    assert!(views[..480].iter().all(|view| view.mode != Mode::Doubt && view.wrench != Wrench::ZERO));
    assert!(views[510..].iter().all(|view| view.mode == Mode::Doubt && view.wrench == Wrench::ZERO));
    // It is back: the force grows from zero.
    let views = drive.run(600, always, always);
    assert!(length(&views[2].wrench.force) < 0.2, "{:?}", views[2].wrench);
    assert!(largest(views) > 1.5);
}

#[test]
fn contacts_that_are_200_ms_old_change_the_force_by_no_more_than_the_slew() {
    // Pressing, turning and sliding over the edge of the plate, while the collision side stalls for 200 ms out of each 250 ms.
    let mut keys = vec![(0.0, at([0.0; 3], [0.0; 3])), (0.2, at([0.0, 0.0, -0.02], [0.0; 3]))];
    for k in 1..12 {
        let side = if k % 2 == 0 { 0.17 } else { 0.215 };
        keys.push((0.2 + 0.3 * f64::from(k), at([side, 0.01, -0.02], [0.1, 0.1 * side, 0.3])));
    }
    let stalls = |k: u32| k % 250 >= 200;
    let mut drive = Drive::new(started(plate(), SessionOptions::default()), device(HandPath::new(keys).unwrap()));
    drive.run(300, always, always);
    let coupling = *drive.sides.servo.coupling().0;
    let views = drive.run(3000, always, stalls);
    assert!(views.iter().any(|view| view.age > 0.19) && largest(views) > 1.5);
    for both in views.windows(2) {
        let change = both[1].wrench - both[0].wrench;
        assert!(both[1].mode != Mode::Doubt, "{:?}", both[1]);
        assert!(length(&change.force) <= coupling.slew_n_per_s * TICK * (1.0 + 1e-9), "{both:?}");
        assert!(length(&change.torque) <= coupling.slew_nm_per_s * TICK * (1.0 + 1e-9), "{both:?}");
    }
}

#[test]
fn a_servo_side_that_stalls_begins_from_nothing() {
    let mut drive = Drive::new(started(plate(), SessionOptions::default()), device(pushing()));
    let before = drive.run(400, always, always).to_vec();
    assert!(length(&before[399].wrench.force) > 1.0);
    drive.run(300, never, always);
    let views = drive.run(600, always, always);
    assert_eq!(views[0].wrench, Wrench::ZERO);
    assert!(length(&views[5].wrench.force) < 0.5, "{:?}", views[5].wrench);
    assert!(largest(views) > 1.5);
}

#[test]
fn a_picture_that_never_looks_changes_nothing() {
    let run = |looks: bool| {
        let mut sides = Sides::new(
            started(plate(), SessionOptions::default()),
            Box::new(device(pushing())),
            &RunnerOptions::default(),
        )
        .map_err(|refused| refused.error)
        .unwrap();
        // Longer than the trace can hold.
        for k in 0..5000 {
            let now = f64::from(k) * TICK;
            sides.collision.tick(now);
            sides.servo.tick(now);
            if looks {
                sides.watch.view();
                sides.watch.trace();
            }
        }
        *sides.watch.view()
    };
    assert_eq!(run(true), run(false));
}

#[test]
fn in_doubt_there_is_no_force_and_afterwards_there_is_again() {
    let faults = [
        (Fault::NotANumber, 0),
        (Fault::Nonsense, 0),
        (Fault::Lost, 0),
        // Silent for 50 ms before it counts.
        (Fault::Silent, 52),
    ];
    for (fault, until) in faults {
        let faulty = Faulty::new(device(pushing()), fault, 0.4, 0.9).unwrap();
        let mut drive = Drive::new(started(plate(), SessionOptions::default()), faulty);
        let views = drive.run(1500, always, always);
        assert!(length(&views[399].wrench.force) > 1.0, "{fault:?}");
        for view in &views[400 + until..899] {
            assert_eq!((view.mode, view.wrench), (Mode::Doubt, Wrench::ZERO), "{fault:?}");
        }
        let views = &views[902..];
        assert!(views.iter().all(|view| view.mode != Mode::Doubt), "{fault:?}");
        assert!(length(&views[0].wrench.force) < 0.2 && largest(views) > 1.5, "{fault:?}: {}", largest(views));
    }
}

#[test]
fn a_jump_of_a_metre_has_no_force_at_first_and_passes_nothing() {
    let faulty = Faulty::new(device(pushing()), Fault::Jump([0.0, 0.0, -1.0]), 0.4, 0.9).unwrap();
    let mut drive = Drive::new(started(sheet(), SessionOptions::default()), faulty);
    let views = drive.run(1500, always, always);
    assert_eq!(views[400].wrench, Wrench::ZERO);
    assert!(length(&views[405].wrench.force) < 0.5);
    assert!(views.iter().all(|view| view.proxy.translation()[2] > 0.0));
}

#[test]
fn a_device_of_20_hz_is_bounded_and_passes_nothing() {
    let faulty = Faulty::new(device(pushing()), Fault::Slow(20.0), 0.0, f64::INFINITY).unwrap();
    let mut drive = Drive::new(started(sheet(), SessionOptions::default()), faulty);
    let views = drive.run(3000, always, always);
    assert!(views.iter().all(|view| view.proxy.translation()[2] > 0.0));
    assert!(largest(views) > 0.5);
}

#[test]
fn a_sunk_start_gives_way_upwards_alone() {
    let mut session = Session::new(plate(), block(), SessionOptions::default()).unwrap();
    session.start(&at([0.0, 0.0, 0.02], [0.0; 3])).unwrap();
    let up = HandPath::new(vec![
        (0.2, at([0.0; 3], [0.0; 3])),
        (0.4, at([0.0, 0.0, 0.02], [0.0; 3])),
        (0.6, at([0.0; 3], [0.0; 3])),
    ]);
    let mut drive = Drive::new(session, device(up.unwrap()));
    let views = drive.run(1500, always, always);
    assert!(views[..200].iter().all(|view| view.proxy.translation()[2] > 0.02 - 2e-5));
    assert!(views[1400..].iter().all(|view| view.mode == Mode::Contact && view.proxy.translation()[2] > 0.025));
    assert!(largest(views) > 0.5);
}

/// The velocity of a cap by time: metres per second, seconds.
type Speed = fn(f64) -> f64;

/// A cap that springs back: its deflection is a velocity down the z axis, by the time.
struct Cap {
    info: DeviceInfo,
    speed: Speed,
    z: f64,
    last: f64,
}

impl Device for Cap {
    fn info(&self) -> &DeviceInfo {
        &self.info
    }

    fn read(&mut self, now: f64) -> Result<DeviceState, DeviceError> {
        let speed = (self.speed)(now);
        self.z += speed * (now - self.last);
        self.last = now;
        let twist = Some(Twist { linear: [0.0, 0.0, speed], angular: [0.0; 3] });
        Ok(DeviceState::new(at([0.0, 0.0, self.z], [0.0; 3]), now).with_twist(twist).with_buttons(0))
    }

    fn write(&mut self, _: &Wrench, _: f64) -> Result<(), DeviceError> {
        Ok(())
    }

    fn release(&mut self) {}

    fn is_rate_controlled(&self) -> bool {
        true
    }
}

#[test]
fn a_rate_device_that_was_pushed_into_a_wall_comes_back_at_once() {
    let nothing = Freedoms::default();
    let info = SimulatedOptions::desktop_6dof().info.with_driven(nothing).with_workspace([0.0; 3]);
    // A slow and a fast push of 5 s, then back at the same speed, and at a tenth of it.
    let caps: [(f64, Speed); 3] = [
        (0.2, |t| if t < 5.0 { -0.2 } else { 0.2 }),
        (0.01, |t| if t < 5.0 { -0.01 } else { 0.01 }),
        (0.1, |t| if t < 5.0 { -0.1 } else { 0.01 }),
    ];
    for (speed, cap) in caps {
        let device = Cap { info: info.clone(), speed: cap, z: 0.0, last: 0.0 };
        let mut drive = Drive::new(started(plate(), SessionOptions::default()), device);
        let way = (0.003 / speed * 1000.0) as u32;
        let free = drive.run(way, always, always).last().unwrap().proxy.translation()[2];
        assert!((free - 0.027).abs() < 0.003 * speed, "{speed}: {free}");
        let pressed = drive.run(5000 - way, always, always).last().unwrap().proxy.translation()[2];
        let back = drive.run(20, always, always).last().unwrap().proxy.translation()[2];
        assert!((pressed - 0.025).abs() < 1e-4 && back > pressed + 1e-5, "{speed}: {pressed} {back}");
    }
}

/// A handle thrown to the border of its workspace and held there. sent: the force along z of each tick, newtons.
struct Thrown {
    info: DeviceInfo,
    sent: Arc<Mutex<Vec<f64>>>,
}

impl Device for Thrown {
    fn info(&self) -> &DeviceInfo {
        &self.info
    }

    fn read(&mut self, now: f64) -> Result<DeviceState, DeviceError> {
        let z = (10.0 * (now - 0.3)).clamp(0.0, 0.98 * self.info.workspace[2]);
        Ok(DeviceState::new(at([0.0, 0.0, z], [0.0; 3]), now).with_buttons(0))
    }

    fn write(&mut self, wrench: &Wrench, _: f64) -> Result<(), DeviceError> {
        self.sent.lock().unwrap().push(wrench.force[2]);
        Ok(())
    }

    fn release(&mut self) {}
}

#[test]
fn the_border_of_the_workspace_comes_and_returns_gently() {
    let sent = Arc::new(Mutex::new(Vec::new()));
    let info = SimulatedOptions::desktop_6dof().info;
    let device = Faulty::new(Thrown { info: info.clone(), sent: sent.clone() }, Fault::Silent, 0.8, 0.9).unwrap();
    let mut drive = Drive::new(started(plate(), SessionOptions::default()), device);
    drive.run(1500, always, always);
    let slew = drive.sides.servo.coupling().0.slew_n_per_s;
    let sent = sent.lock().unwrap();
    let held = sent[1499];
    assert!(held < -0.05 * info.limits.force_n, "{held}");
    for (k, both) in sent.windows(2).enumerate() {
        let change = both[1] - both[0];
        assert!(change >= -slew * TICK - 1e-9 && (change <= 1e-9 || both[1] == 0.0), "{k}: {both:?}");
    }
    // After the silence the force grows from zero within 0.2 s.
    let first = sent.iter().skip(870).position(|force| *force < 0.0).unwrap() + 870;
    assert!(sent[855..first].iter().all(|force| *force == 0.0) && sent[first + 20] > 0.2 * held, "{first}");
}

#[test]
fn a_handle_that_jumps_out_of_the_workspace_is_not_thrown_back() {
    let sent = Arc::new(Mutex::new(Vec::new()));
    let mut info = SimulatedOptions::desktop_6dof().info;
    // It rests where it is.
    info.workspace[2] = 0.0;
    let rests = Thrown { info: info.clone(), sent: sent.clone() };
    info.workspace = [0.06; 3];
    let device = Faulty::new(Walled { rests, info: info.clone() }, Fault::Jump([0.0, 0.0, 0.5]), 0.4, 0.9).unwrap();
    let mut drive = Drive::new(started(plate(), SessionOptions::default()), device);
    drive.run(1500, always, always);
    let sent = sent.lock().unwrap();
    assert_eq!((sent[399], sent[400]), (0.0, 0.0));
    assert!(sent[500] < -0.1 * info.limits.force_n, "it is pushed in the end: {}", sent[500]);
    for (k, force) in sent.iter().enumerate().skip(400).take(200) {
        assert!(-force <= 0.5 * info.limits.force_n * (k - 399) as f64 * TICK / 0.2 + 1e-9, "{k}: {force}");
    }
    assert!(sent[900..].iter().all(|force| *force == 0.0));
}

/// A device with other limits.
struct Walled {
    rests: Thrown,
    info: DeviceInfo,
}

impl Device for Walled {
    fn info(&self) -> &DeviceInfo {
        &self.info
    }

    fn read(&mut self, now: f64) -> Result<DeviceState, DeviceError> {
        self.rests.read(now)
    }

    fn write(&mut self, wrench: &Wrench, now: f64) -> Result<(), DeviceError> {
        self.rests.write(wrench, now)
    }

    fn release(&mut self) {}
}

#[test]
fn a_servo_side_that_falls_to_50_hz_does_not_shake_the_hand() {
    let down = HandPath::new(vec![(0.0, at([0.0; 3], [0.0; 3])), (0.3, at([0.0, 0.0, -0.015], [0.0; 3]))]).unwrap();
    for slowest in [0.015, 0.025, 0.04] {
        let mut r = Random::new(1);
        let session = started(plate(), SessionOptions::default());
        let sides = Sides::new(session, Box::new(device(down.clone())), &RunnerOptions::default());
        let Sides { mut collision, mut servo, mut watch } = sides.map_err(|refused| refused.error).unwrap();
        let (mut now, mut felt) = (0.0, Vec::new());
        while now < 4.0 {
            // From a second on a slow and uneven computer, and later a fast one again.
            now += if (1.0..3.0).contains(&now) { r.real(0.012, slowest) } else { TICK };
            collision.tick(now);
            servo.tick(now);
            felt.push((now, watch.view().wrench.force[2]));
        }
        let between = |from: f64, to: f64| {
            let forces = felt.iter().filter(|(t, _)| (from..to).contains(t)).map(|(_, force)| *force);
            forces.fold([f64::INFINITY, 0.0f64], |[low, high], force| [low.min(force), high.max(force)])
        };
        let [low, high] = between(1.3, 3.0);
        let [before, after] = [between(0.9, 1.0)[0], between(3.9, 4.0)[0]];
        assert!(low > 0.1 && high - low < 0.3, "{slowest}: from {low} to {high}");
        assert!(high < before && (after / before - 1.0).abs() < 0.05, "{slowest}: {before} {high} {after}");
    }
}

/// Down by 10 mm in 0.2 s, where it stays.
fn pressing() -> HandPath {
    HandPath::new(vec![(0.0, at([0.0; 3], [0.0; 3])), (0.2, at([0.0, 0.0, -0.01], [0.0; 3]))]).unwrap()
}

/// The least and the largest force upwards, newtons.
fn range(views: &[View]) -> [f64; 2] {
    views.iter().fold([f64::MAX, f64::MIN], |[low, high], view| {
        let force = view.wrench.force[2];
        [low.min(force), high.max(force)]
    })
}

/// A device that reports seldom, or whose servo does, holds a spring in proportion, and the hand is not shaken.
#[test]
fn stiffness_follows_the_measured_rate() {
    for (hz, ticks) in [(1e4, 1.0), (210.0, 5.0), (51.0, 20.0), (25.5, 40.0)] {
        let slow = Faulty::new(device(pressing()), Fault::Slow(hz), 0.0, 3.0).unwrap();
        let mut drive = Drive::new(started(plate(), SessionOptions::default()), slow);
        drive.run(2000, always, always);
        let [low, high] = range(drive.run(900, always, always));
        let share = drive.views.last().unwrap().stiffness_share;
        assert!((share * ticks - 1.0).abs() < 0.1, "{hz}: {share}");
        assert!(low > 0.0 && high - low < 0.05 * high + 0.01, "{hz}: {low} to {high} N");
        // Fast again, it is as stiff as ever.
        let [low, _] = range(&drive.run(1500, always, always)[1000..]);
        assert!(low > 1.0 && drive.views.last().unwrap().stiffness_share == 1.0, "{hz}: {low}");
    }
    // The servo at 50 Hz, asked for 1000.
    let mut drive = Drive::new(started(plate(), SessionOptions::default()), device(pressing()));
    drive.run(2000, |k| k % 20 == 0, always);
    let [low, high] = range(drive.run(1000, |k| k % 20 == 0, always));
    let share = drive.views.last().unwrap().stiffness_share;
    assert!(
        (share * 20.0 - 1.0).abs() < 0.1 && low > 0.0 && high - low < 0.05 * high + 0.01,
        "{share}: {low} to {high}"
    );
}

/// It falls to 50 Hz while the hand presses: the force sinks, and never turns over.
#[test]
fn a_device_that_falls_to_50_hz_does_not_shake_the_hand() {
    let slow = Faulty::new(device(pressing()), Fault::Slow(51.0), 1.0, 4.0).unwrap();
    let mut drive = Drive::new(started(plate(), SessionOptions::default()), slow);
    let [_, before] = range(&drive.run(1000, always, always)[800..]);
    let [low, high] = range(drive.run(2900, always, always));
    assert!(low > 0.0 && high < 1.05 * before, "{low} to {high} N, {before} N before");
    let share = drive.views[1200].stiffness_share;
    assert!(share < 0.1, "{share} after 0.2 s");
    let [low, high] = range(&drive.views[3000..]);
    assert!(high - low < 0.05 * high, "{low} to {high} N");
}

/// A device whose states come later than it says: the same by their age.
#[test]
fn stiffness_follows_the_measured_delay() {
    struct Late<D>(D, Vec<DeviceState>, DeviceInfo);
    impl<D: Device> Device for Late<D> {
        fn info(&self) -> &DeviceInfo {
            &self.2
        }
        fn read(&mut self, now: f64) -> Result<DeviceState, DeviceError> {
            self.1.push(self.0.read(now)?);
            Ok(self.1[self.1.len().saturating_sub(21)])
        }
        fn write(&mut self, wrench: &Wrench, now: f64) -> Result<(), DeviceError> {
            self.0.write(wrench, now)
        }
        fn release(&mut self) {
            self.0.release();
        }
    }
    let known = device(pressing());
    let info = known.info().clone();
    let mut drive = Drive::new(started(plate(), SessionOptions::default()), Late(known, Vec::new(), info));
    drive.run(2000, always, always);
    let [low, high] = range(drive.run(900, always, always));
    let share = drive.views.last().unwrap().stiffness_share;
    // Half a tick, and 20 ms.
    assert!(
        (share * 41.0 - 1.0).abs() < 0.1 && low > 0.0 && high - low < 0.05 * high + 0.01,
        "{share}: {low} to {high}"
    );
}
