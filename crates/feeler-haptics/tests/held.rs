//! The hand holds a tool at its centre: where the origin of the tool's frame is does not matter.

mod common;

use std::sync::{Arc, Mutex};

use common::*;
use feeler_core::geometry::twist::{displaced, displacement, Twist};
use feeler_core::geometry::vectors::{add, length, sub};
use feeler_core::{Point, Pose, Tool};
use feeler_haptics::device::mouse::Mouse;
use feeler_haptics::device::simulated::SimulatedOptions;
use feeler_haptics::device::{Device, DeviceError, DeviceInfo, DeviceState};
use feeler_haptics::{Coupling, MappingOptions, Mode, RunnerOptions, Session, SessionOptions, Sides, Start, Wrench};
use feeler_shapes::box_mesh;

const TICK: f64 = 1e-3;
/// How deep the block is pressed into its plate, and how far it is above before, metres.
const DEPTH: f64 = 0.005;
const GAP: f64 = 0.001;
/// How far a block is from the origin of its frame, metres: the first has it in its middle.
const PLACES: [Point; 6] =
    [[0.0; 3], [0.1, 0.0, 0.0], [0.3, -0.2, 0.1], [0.0, 3.0, 0.0], [1.0, 2.0, -2.0], [3000.0, 0.0, 0.0]];

/// A block drawn above a plate, both so far from the origin, in their own place; started there.
fn session(place: &Point, coupling: Coupling) -> Session {
    let (vertices, faces) = box_mesh(*place, [0.06, 0.08, 0.02], 1);
    let block = Arc::new(Tool::new(vertices, faces).unwrap());
    let plate = scene(box_mesh(sub(place, &[0.0, 0.0, 0.02 + GAP]), [0.4, 0.4, 0.02], 1));
    let mut session = Session::new(plate, block, SessionOptions::default().with_coupling(coupling)).unwrap();
    assert_eq!(session.start(&Pose::IDENTITY).unwrap(), Start::Free);
    assert!(length(&sub(&session.centre(), place)) < 1e-11);
    session
}

fn assert_near(found: &Wrench, expected: &Wrench, what: &Point) {
    let off = *found - *expected;
    assert!(length(&off.force) <= 1e-6 * length(&expected.force) + 1e-9, "{what:?}: {found:?}, {expected:?}");
    assert!(length(&off.torque) <= 1e-6 * length(&expected.torque) + 1e-9, "{what:?}: {found:?}, {expected:?}");
}

/// The wrench of a hand that goes down, turning about where it holds the tool, and then rests.
fn pressed(session: &mut Session, turn: Point) -> Wrench {
    let centre = session.centre();
    let mut step = None;
    for tick in 0..500 {
        let share = f64::from(tick.min(300)) / 300.0;
        let by = Twist { linear: [0.0, 0.0, -(DEPTH + GAP)], angular: turn } * share;
        let device = displaced(&Pose::IDENTITY, &by, &centre).unwrap();
        step = Some(session.step(Some(&device), TICK).unwrap());
    }
    let step = step.unwrap();
    assert_eq!(step.mode, Mode::Contact);
    step.wrench
}

#[test]
fn steps_feel_the_same_wherever_the_frame_is() {
    let coupling = Coupling::default();
    for turn in [[0.0; 3], [0.03, 0.0, 0.0]] {
        let expected = pressed(&mut session(&PLACES[0], coupling), turn);
        let due = coupling.stiffness_n_per_m * DEPTH;
        assert!((expected.force[2] / due - 1.0).abs() < 0.01, "{expected:?}");
        assert!((expected.torque[0] + coupling.rotational_stiffness_nm_per_rad * turn[0]).abs() < 1e-3, "{expected:?}");
        for place in &PLACES[1..] {
            assert_near(&pressed(&mut session(place, coupling), turn), &expected, place);
        }
    }
}

#[test]
fn turns_about_where_the_hand_holds_make_no_force() {
    for place in &PLACES {
        let mut session = session(place, Coupling::default());
        let centre = session.centre();
        let still = pressed(&mut session, [0.0; 3]);
        let down = Pose::IDENTITY.translated(&[0.0, 0.0, -(DEPTH + GAP)]).unwrap();
        // Along the plate the block turns too; against it only a torque is felt.
        for (turn, torque) in [([0.0, 0.0, 0.5], 0.0), ([0.02, 0.0, 0.0], -0.04)] {
            let mut found = Wrench::ZERO;
            for tick in 0..400 {
                let share = f64::from(tick.min(200)) / 200.0;
                let by = Twist { linear: [0.0; 3], angular: turn } * share;
                let device = displaced(&down, &by, &centre).unwrap();
                found = session.step(Some(&device), TICK).unwrap().wrench;
            }
            assert_near(&Wrench { torque: [0.0; 3], ..found }, &Wrench { torque: [0.0; 3], ..still }, place);
            assert!((found.torque[0] - torque).abs() < 1e-4, "{place:?}: {found:?}");
        }
    }
}

/// A handle whose pose the test sets, and which keeps the wrenches that it is sent.
struct Told {
    info: DeviceInfo,
    turn: f64,
    given: Arc<Mutex<Wrench>>,
}

impl Device for Told {
    fn info(&self) -> &DeviceInfo {
        &self.info
    }

    fn read(&mut self, now: f64) -> Result<DeviceState, DeviceError> {
        let share = (now / 0.3).min(1.0);
        Ok(DeviceState::new(at([0.0, 0.0, -share * (DEPTH + GAP)], [share * self.turn, 0.0, 0.0]), now))
    }

    fn write(&mut self, wrench: &Wrench, _: f64) -> Result<(), DeviceError> {
        *self.given.lock().unwrap() = *wrench;
        Ok(())
    }

    fn release(&mut self) {}
}

#[test]
fn a_device_is_granted_and_given_the_same_wherever_the_frame_is() {
    for options in [SimulatedOptions::desktop_3dof(), SimulatedOptions::desktop_6dof(), SimulatedOptions::large_6dof()]
    {
        let turn = if options.info.driven.rotation { 0.01 } else { 0.0 };
        let run = |place: &Point| {
            let given = Arc::new(Mutex::new(Wrench::ZERO));
            let handle = Told { info: options.info.clone(), turn, given: given.clone() };
            let session = session(place, Coupling::for_device(&options.info));
            let made = Sides::new(session, Box::new(handle), &RunnerOptions::default());
            let mut sides = made.map_err(|refused| refused.error).unwrap();
            for tick in 0..500 {
                let now = f64::from(tick) * TICK;
                sides.collision.tick(now);
                sides.servo.tick(now);
            }
            let (coupling, limitations) = sides.servo.coupling();
            let (shown, given) = (sides.watch.view().wrench, *given.lock().unwrap());
            (*coupling, *limitations, shown, given)
        };
        let (coupling, limitations, shown, given) = run(&PLACES[0]);
        assert!(limitations.is_empty(), "{limitations:?}");
        let due = (coupling.stiffness_n_per_m * DEPTH).min(coupling.max_force_n);
        assert!((given.force[2] / due - 1.0).abs() < 0.01, "{given:?}, {due}");
        for place in &PLACES[1..] {
            let (its, limits, view, sent) = run(place);
            assert_eq!((its, limits), (coupling, limitations), "{place:?}");
            assert_near(&view, &shown, place);
            assert_near(&sent, &given, place);
        }
    }
}

#[test]
fn a_handle_turns_the_tool_about_its_centre() {
    let place = &PLACES[2];
    for is_absolute in [false, true] {
        let info = SimulatedOptions::desktop_6dof().info;
        let handle = Told { info, turn: 0.3, given: Arc::new(Mutex::new(Wrench::ZERO)) };
        let mapping = MappingOptions::default().with_is_absolute(is_absolute);
        let options = RunnerOptions::default().with_mapping(mapping);
        let made = Sides::new(session(place, Coupling::default()), Box::new(handle), &options);
        let mut sides = made.map_err(|refused| refused.error).unwrap();
        (0..400).for_each(|tick| sides.servo.tick(f64::from(tick) * TICK));
        let device = sides.watch.view().device;
        let off = sub(&device.apply(place), &add(place, &[0.0, 0.0, -(DEPTH + GAP)]));
        assert!(length(&off) < 1e-12 && (device.rotation()[2][1] - 0.3_f64.sin()).abs() < 1e-12, "{device:?}");
    }
}

/// A mouse renders no force: its poses are those of the tool's frame, not of the tool's centre.
#[test]
fn a_mouse_has_the_tool_at_its_pose() {
    let wanted = at([0.0, 0.0, 0.5], [0.3, 0.0, 0.2]);
    let options = RunnerOptions::default().with_mapping(MappingOptions::default().with_is_absolute(true));
    let made = Sides::new(session(&PLACES[2], Coupling::default()), Box::new(Mouse::new(wanted)), &options);
    let mut sides = made.map_err(|refused| refused.error).unwrap();
    (0..10).for_each(|tick| sides.servo.tick(f64::from(tick) * TICK));
    assert!(displacement(&sides.watch.view().device, &wanted, &[0.0; 3]).reach(1.0) < 1e-12);
}
