//! Runs with real threads. Nothing here depends on the machine's speed: the assertions hold at every tick, whenever it
//! comes.

mod common;
#[path = "../examples/own_device.rs"]
mod own_device;

use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use common::*;
use feeler_core::geometry::vectors::length;
use feeler_core::{Mockup, Scene, SceneOptions};
use feeler_haptics::device::mouse::Mouse;
use feeler_haptics::device::steered::steered;
use feeler_haptics::device::{Device, DeviceError, DeviceInfo, DeviceState};
use feeler_haptics::{
    Clock, Error, MappingOptions, Mode, Release, Runner, RunnerOptions, SessionOptions, Start, Stopped, ThreadKind,
    View, Wrench,
};
use feeler_shapes::box_mesh;
use feeler_world::Error as World;

struct RealClock(Instant);

impl Clock for RealClock {
    fn now(&self) -> f64 {
        self.0.elapsed().as_secs_f64()
    }

    fn sleep_until(&self, time: f64) {
        let left = time - self.now();
        if left > 0.0 {
            std::thread::sleep(Duration::from_secs_f64(left));
        }
    }
}

fn clock() -> Arc<dyn Clock> {
    Arc::new(RealClock(Instant::now()))
}

fn run(device: impl Device + 'static, options: &RunnerOptions) -> Runner {
    let session = started(plate(), SessionOptions::default());
    Runner::run(session, Box::new(device), clock(), options).map_err(|refused| refused.error).unwrap()
}

/// Looks that [`until`] takes: half a minute on an idle machine. A guard against waiting for ever, no measurement.
const LOOKS: u32 = 100_000;

/// Waits until a view satisfies a condition, or the run has ended. Asserts the guarantees of every view.
fn until(runner: &mut Runner, is_wanted: impl Fn(&View) -> bool) -> View {
    let most = runner.coupling().max_force_n * (1.0 + 1e-9);
    for _ in 0..LOOKS {
        let view = *runner.watch().view();
        assert!(length(&view.wrench.force) <= most, "{view:?}");
        if view.number > 0 && is_wanted(&view) || !runner.is_running() {
            return view;
        }
        std::thread::sleep(Duration::from_micros(300));
    }
    panic!("what is waited for does not come: {:?}", runner.watch().view());
}

#[test]
fn a_run_pushes_on_a_plate_and_ends_when_it_is_told() {
    let kinds = Arc::new(Mutex::new(Vec::new()));
    let told = kinds.clone();
    let options = RunnerOptions::default().with_on_thread_start(move |kind| told.lock().unwrap().push(kind));
    let (world, tool) = (plate(), block());
    let mut runner = run(device(pushing()), &options);
    for _ in 0..50 {
        let pressed = until(&mut runner, |view| view.mode == Mode::Contact && length(&view.wrench.force) > 1.0);
        assert!(!world.is_colliding(&tool, &pressed.proxy));
        assert!(pressed.held().iter().all(|plane| plane.normal[2] > 0.9));
    }
    let trace = runner.watch().trace();
    assert!(trace.windows(2).all(|two| two[0].time < two[1].time));
    assert!(trace.iter().all(|tick| !world.is_colliding(&tool, &tick.proxy)));
    let Stopped { session, device, statistics, trace: rest, error, .. } = runner.stop();
    assert_eq!(error, None);
    assert!(device.is_some());
    // All ticks there were, but for those without room.
    assert!(trace.iter().chain(&rest).map(|tick| tick.time).is_sorted());
    assert!(statistics.ticks >= (trace.len() + rest.len()) as u64 && statistics.sets > 0);
    assert_eq!(statistics.servo_tick.count, statistics.ticks);
    assert_eq!(statistics.collision_tick.count, statistics.sets);
    let mut kinds = kinds.lock().unwrap().clone();
    kinds.sort_by_key(|kind| *kind == ThreadKind::Collision);
    assert_eq!(kinds, [ThreadKind::Servo, ThreadKind::Collision]);
    // It continues in steps from its last pose.
    let mut session = session.unwrap();
    let pose = *session.pose().unwrap();
    let step = session.step(Some(&pose), 1e-3).unwrap();
    assert!(step.age == 0.0 && step.mode != Mode::Doubt, "{step:?}");
}

/// A device that notes its release, and panics at a tick.
struct Panics<D> {
    device: D,
    at: u32,
    is_released: Arc<AtomicBool>,
    last_written: Arc<AtomicU32>,
}

impl<D: Device> Device for Panics<D> {
    fn info(&self) -> &DeviceInfo {
        self.device.info()
    }

    fn read(&mut self, now: f64) -> Result<DeviceState, DeviceError> {
        let ticks = self.last_written.fetch_add(1, Ordering::SeqCst);
        assert!(ticks < self.at, "a fault made on purpose");
        self.device.read(now)
    }

    fn write(&mut self, wrench: &Wrench, now: f64) -> Result<(), DeviceError> {
        assert!(!self.is_released.load(Ordering::SeqCst), "written to after the release");
        self.device.write(wrench, now)
    }

    fn release(&mut self) {
        self.is_released.store(true, Ordering::SeqCst);
        self.device.release();
    }
}

fn panicking(at: u32) -> (impl Device, Arc<AtomicBool>) {
    let is_released = Arc::new(AtomicBool::new(false));
    let device =
        Panics { device: device(pushing()), at, is_released: is_released.clone(), last_written: Arc::default() };
    (device, is_released)
}

#[test]
fn a_servo_thread_that_panics_lets_go_and_ends_the_run_with_an_error() {
    let (device, is_released) = panicking(100);
    let mut runner = run(device, &RunnerOptions::default());
    until(&mut runner, |_| false);
    assert!(is_released.load(Ordering::SeqCst));
    let Stopped { session, device, error, .. } = runner.stop();
    assert_eq!(error, Some(Error::Panicked { thread: "servo" }));
    assert!(session.is_some() && device.is_none());
}

#[test]
fn a_collision_thread_that_panics_lets_go_and_ends_the_run_with_an_error() {
    let (device, is_released) = panicking(u32::MAX);
    let options = RunnerOptions::default().with_around_work(|_| panic!("a fault made on purpose"));
    let mut runner = run(device, &options);
    assert_eq!(runner.release(Release::Here), Err(Error::Ended));
    until(&mut runner, |_| false);
    let Stopped { session, device, error, .. } = runner.stop();
    assert!(is_released.load(Ordering::SeqCst));
    assert_eq!(error, Some(Error::Panicked { thread: "collision" }));
    assert!(session.is_none() && device.is_some());
}

/// A device whose driver fails at a tick and stays failed.
struct Breaks<D>(Panics<D>);

impl<D: Device> Device for Breaks<D> {
    fn info(&self) -> &DeviceInfo {
        self.0.info()
    }

    fn read(&mut self, now: f64) -> Result<DeviceState, DeviceError> {
        if self.0.last_written.load(Ordering::SeqCst) > 50 {
            return Err(DeviceError::Broken { device: "one of my own".into(), why: "a cable".into() });
        }
        self.0.read(now)
    }

    fn write(&mut self, wrench: &Wrench, now: f64) -> Result<(), DeviceError> {
        self.0.write(wrench, now)
    }

    fn release(&mut self) {
        self.0.release();
    }
}

#[test]
fn a_device_that_is_broken_lets_go_and_ends_the_run_with_an_error() {
    let is_released = Arc::new(AtomicBool::new(false));
    let last_written = Arc::default();
    let inner = Panics { device: device(pushing()), at: u32::MAX, is_released: is_released.clone(), last_written };
    let mut runner = run(Breaks(inner), &RunnerOptions::default());
    until(&mut runner, |_| false);
    assert!(is_released.load(Ordering::SeqCst));
    let Stopped { session, device, error, .. } = runner.stop();
    assert_eq!(error, Some(Error::Device { why: "one of my own failed: a cable".into() }));
    assert!(session.is_some() && device.is_some());
}

#[test]
fn own_devices_are_thirty_lines() {
    own_device::main();
}

#[test]
fn stopping_and_dropping_release_the_device() {
    for drops in [false, true] {
        let (device, is_released) = panicking(u32::MAX);
        let mut runner = run(device, &RunnerOptions::default());
        until(&mut runner, |view| view.number > 20);
        if drops {
            drop(runner);
        } else {
            runner.stop();
        }
        assert!(is_released.load(Ordering::SeqCst));
    }
}

#[test]
fn a_mouse_is_steered_and_a_start_puts_the_tool_elsewhere() {
    let (mouse, mut steering) = steered(Mouse::new(at([0.0; 3], [0.0; 3])), at([0.0; 3], [0.0; 3]));
    let mut runner = run(mouse, &RunnerOptions::default());
    steering.set_target(at([0.0, 0.0, -0.02], [0.0; 3]));
    until(&mut runner, |view| view.mode == Mode::Contact && view.device.translation()[2] < 0.015);
    // The handle stays 20 mm below where it began, the tool is 0.1 m above the plate.
    assert_eq!(runner.start(&at([0.0, 0.0, 0.1], [0.0; 3])), Ok(Start::Free));
    let view = until(&mut runner, |view| view.mode == Mode::Free && view.proxy.translation()[2] > 0.09);
    assert!((view.device.translation()[2] - 0.1).abs() < 0.01, "{view:?}");
    steering.set_target(at([0.0, 0.0, -0.2], [0.0; 3]));
    until(&mut runner, |view| view.mode == Mode::Contact);
    // Its lower face is inside of the plate: through it, the tool could leave to either side.
    assert!(matches!(runner.start(&at([0.0, 0.0, 0.01], [0.0; 3])), Ok(Start::Seated(_))));
    // The servo takes the start over in its next tick, which a busy machine may keep waiting.
    until(&mut runner, |view| (view.proxy.translation()[2] - 0.01).abs() < 0.002);
    // Wherever the handle was by then, it goes further down.
    steering.set_target(at([0.0, 0.0, -0.4], [0.0; 3]));
    let sunk = until(&mut runner, |view| view.device.translation()[2] < -0.05);
    assert!((sunk.proxy.translation()[2] - 0.01).abs() < 0.002 && sunk.mode != Mode::Free, "{sunk:?}");
}

#[test]
fn an_absolute_mapping_has_the_tool_where_the_handle_is() {
    let place = at([0.01, 0.02, 0.05], [0.0; 3]);
    let (mouse, _steering) = steered(Mouse::new(place), place);
    let mapping = MappingOptions::default().with_is_absolute(true);
    let mut runner = run(mouse, &RunnerOptions::default().with_mapping(mapping));
    until(&mut runner, |view| view.proxy == place);
    assert!(runner.is_running());
}

#[test]
fn parts_are_taken_and_scenes_swapped_while_it_runs() {
    // A plate, and a small box beside where the block is.
    let (mut vertices, mut faces) = box_mesh([0.0, 0.0, -0.01], [0.4, 0.4, 0.02], 1);
    let (more, its) = box_mesh([0.1, 0.0, 0.03], [0.02; 3], 1);
    let mut parts = vec![0; faces.len()];
    parts.extend(std::iter::repeat_n(1, its.len()));
    faces.extend(its.iter().map(|face| face.map(|v| v + vertices.len() as u32)));
    vertices.extend(more);
    let mockup = Arc::new(Mockup::new(vertices, faces, parts, 2).unwrap());
    let scene = Arc::new(Scene::build(mockup, &SceneOptions::default()).unwrap());
    let session = started(scene, SessionOptions::default());
    let runner = Runner::run(session, Box::new(device(pushing())), clock(), &RunnerOptions::default());
    let mut runner = runner.map_err(|refused| refused.error).unwrap();
    until(&mut runner, |view| view.mode == Mode::Contact);
    assert_eq!(runner.grip(&[1]), Ok(()));
    assert_eq!(runner.grip(&[0]), Err(Error::World(World::HoldsAlready { part: 1 })));
    assert_eq!(runner.release(Release::Here), Ok(()));
    assert_eq!(runner.release(Release::Here), Err(Error::World(World::HoldsNothing)));
    assert!(matches!(runner.grip(&[7]), Err(Error::Core(_))));
    assert_eq!(runner.set_scene(sheet()), Ok(Start::Free));
    until(&mut runner, |view| view.mode == Mode::Contact);
    let session = runner.stop().session.unwrap();
    assert_eq!(session.world().around().environment().bodies.len(), 1);
}

/// A clock that wakes three milliseconds late at the least.
struct LateClock(RealClock);

impl Clock for LateClock {
    fn now(&self) -> f64 {
        self.0.now()
    }

    fn sleep_until(&self, time: f64) {
        self.0.sleep_until(time.max(self.now()) + 3e-3);
    }
}

#[test]
fn a_servo_that_is_slower_than_it_was_to_be_is_said() {
    // On a busy system a servo may not run long enough to tell: another is tried.
    let options = RunnerOptions::default();
    let mut last = Vec::new();
    for _ in 0..8 {
        let session = started(plate(), SessionOptions::default());
        let clock = Arc::new(LateClock(RealClock(Instant::now())));
        let runner = Runner::run(session, Box::new(device(pushing())), clock, &options);
        let mut runner = runner.map_err(|refused| refused.error).unwrap();
        for _ in 0..LOOKS / 8 {
            last = runner.limitations_in_words();
            if last.iter().any(|said| said.contains("Hz instead of 1,000")) {
                return;
            }
            std::thread::sleep(Duration::from_micros(300));
        }
    }
    panic!("{last:?}");
}

#[test]
fn what_cannot_run_comes_back() {
    let unstarted = feeler_haptics::Session::new(plate(), block(), SessionOptions::default()).unwrap();
    let refused = Runner::run(unstarted, Box::new(device(pushing())), clock(), &RunnerOptions::default());
    assert!(matches!(refused.err().unwrap().error, Error::NotStarted));
    let bad = [
        RunnerOptions::default().with_rate_hz(0.0),
        RunnerOptions::default().with_rate_hz(f64::NAN),
        RunnerOptions::default().with_collision_hz(-1.0),
        RunnerOptions::default().with_mapping(MappingOptions::default().with_scale(0.0)),
        RunnerOptions::default().with_mapping(MappingOptions::default().with_clutch_button(9)),
    ];
    for options in bad {
        let session = started(plate(), SessionOptions::default());
        let refused = Runner::run(session, Box::new(device(pushing())), clock(), &options).err().unwrap();
        assert!(matches!(refused.error, Error::Option { .. }), "{options:?}: {}", refused.error);
        assert!(refused.session.is_some() && refused.device.is_some());
    }
}

#[test]
fn what_a_device_does_not_hold_is_taken_away_for_the_run_alone() {
    let mut options = SessionOptions::default();
    options.coupling.stiffness_n_per_m = 1e5;
    let session = started(plate(), options);
    let before = *session.options();
    let runner = Runner::run(session, Box::new(device(pushing())), clock(), &RunnerOptions::default());
    let mut runner = runner.map_err(|refused| refused.error).unwrap();
    assert!(!runner.limitations().is_empty());
    let said = runner.limitations_in_words();
    assert!(
        said[0].starts_with("stiffness 2,") && said[0].contains("instead of 100,000: what the damping of"),
        "{said:?}"
    );
    assert!(runner.coupling().stiffness_n_per_m < 3000.0);
    assert_eq!(*runner.stop().session.unwrap().options(), before);
}
