//! A session that runs in two threads. See [`Runner`].

mod collision_side;
mod exchange;
mod options;
mod reports;
mod servo_side;
mod trace;

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{channel, sync_channel, Receiver, Sender, SyncSender};
use std::sync::Arc;
use std::thread::{Builder, JoinHandle};

use feeler_core::{Pose, Scene};
use feeler_world::Release;
use rtrb::{Consumer, RingBuffer};
use triple_buffer::{triple_buffer, Input, Output};

use crate::clock::Clock;
use crate::constants::{COLLISION_REFRESH_S, COLLISION_REST_S, RATE_SHARE, TICKS_FOR_A_RATE, TRACE_TICKS};
use crate::constraint_set::ConstraintSet;
use crate::coupling::Coupling;
use crate::device::mapping::Mapping;
use crate::device::{Device, DeviceError, DeviceInfo};
use crate::error::{Error, Result};
use crate::guide::Guide;
use crate::session::{Session, Start};
use crate::stability::{in_words, Limitations};
use crate::statistics::{CollisionRecord, ServoRecord, Statistics};
use collision_side::{Answer, Command, Wish};
use servo_side::{ServoEnds, Setting};

pub use collision_side::CollisionSide;
pub use exchange::View;
use exchange::{Handed, Target, Told};
pub use options::{AroundWork, MappingOptions, OnThreadStart, RunnerOptions, ThreadKind};
pub use servo_side::ServoSide;
pub use trace::TraceTick;

/// A run that did not begin: why, and what it was to begin with.
#[non_exhaustive]
pub struct Refused {
    /// Why.
    pub error: Error,
    /// As it was.
    pub session: Option<Session>,
    /// As it was.
    pub device: Option<Box<dyn Device>>,
}

/// What a run leaves.
#[non_exhaustive]
pub struct Stopped {
    /// To be stepped or run again, the proxy where it was; `None` where the collision thread panicked.
    pub session: Option<Session>,
    /// Released; `None` where the servo thread panicked.
    pub device: Option<Box<dyn Device>>,
    /// Of the whole run.
    pub statistics: Statistics,
    /// The ticks that [`Watch::trace`] had not taken.
    pub trace: Vec<TraceTick>,
    /// Why it ended by itself, if it did.
    pub error: Option<Error>,
    /// Why the device failed the last time, if it did.
    pub device_error: Option<DeviceError>,
    /// Why the last search for contacts that failed did.
    pub collision_error: Option<Error>,
}

/// The view of a run for a third thread.
pub struct Watch {
    views: Output<View>,
    servo: Output<ServoRecord>,
    collision: Output<CollisionRecord>,
    trace: Consumer<TraceTick>,
    guides: Input<Told>,
}

impl Watch {
    /// Draws the tool to a place, by a soft force of at most 1.5 N, until the next call or for 0.1 s without one. `None` ends it.
    /// Contact and its force are unchanged.
    pub fn guide(&mut self, guide: Option<Guide>) {
        self.guides.write(Told { guide });
    }

    /// The newest tick.
    pub fn view(&mut self) -> &View {
        self.views.read()
    }

    /// As of a tenth of a second ago at most.
    pub fn statistics(&mut self) -> Statistics {
        Statistics::of(self.servo.read(), self.collision.read())
    }

    /// Every tick since the last call, up to four seconds at 1 kHz: older ones are kept, newer ones lost.
    pub fn trace(&mut self) -> Vec<TraceTick> {
        let mut ticks = Vec::with_capacity(self.trace.slots());
        while let Ok(tick) = self.trace.pop() {
            ticks.push(tick);
        }
        ticks
    }
}

/// Both sides of a session, connected, without threads: the caller drives them.
pub struct Sides {
    /// The work of the collision thread.
    pub collision: CollisionSide,
    /// The work of the servo thread.
    pub servo: ServoSide,
    /// The view for others.
    pub watch: Watch,
}

impl Sides {
    /// Of a session that is started, and a device. Errors: not started, an option out of its range.
    pub fn new(mut session: Session, device: Box<dyn Device>, options: &RunnerOptions) -> Result<Sides, Box<Refused>> {
        let refused =
            |error, session, device| Box::new(Refused { error, session: Some(session), device: Some(device) });
        let Some(pose) = session.pose().copied() else { return Err(refused(Error::NotStarted, session, device)) };
        let MappingOptions { scale, world_from_device, is_absolute, clutch_button } = options.mapping;
        let centre = session.centre();
        // A device without force, such as a mouse, tells where the tool's frame is.
        let info = device.info();
        let is_tool = is_absolute && !(info.driven.translation || info.driven.rotation);
        let held = if is_tool { [0.0; 3] } else { centre };
        let mapping = options.check().and_then(|()| Mapping::new(info, scale, &world_from_device, clutch_button, held));
        let mapping = match mapping {
            Ok(mapping) => mapping,
            Err(error) => return Err(refused(error, session, device)),
        };
        let wanted = session.options().coupling;
        let (coupling, limitations) = wanted.limited(&mapping.info_in_world(), options.rate_hz);
        // What nearest means is for the springs that are felt.
        session.set_coupling(coupling);
        let proxy_options = session.options().proxy;
        let set = match session.constraints() {
            Some(set) => *set,
            None => {
                let pull = [proxy_options.pull_m, proxy_options.pull_rad];
                ConstraintSet::new(pose, session.metric(), proxy_options.skin, 0.0, pull)
            }
        };
        let (targets_in, targets_out) = triple_buffer(&Target { pose, number: 0, start: 0 });
        let has_proxy = session.constraints().is_some();
        let (sets_in, sets_out) = triple_buffer(&Handed { set, has_proxy, start: 0, start_pose: pose });
        let (views_in, views) = triple_buffer(&View::new(&pose));
        let (servo_in, servo_records) = triple_buffer(&ServoRecord::default());
        let (collision_in, collision_records) = triple_buffer(&CollisionRecord::default());
        let (guides, guides_out) = triple_buffer(&Told::default());
        let (trace_in, trace) = RingBuffer::new(TRACE_TICKS);
        let ends = ServoEnds {
            targets: targets_in,
            sets: sets_out,
            views: views_in,
            records: servo_in,
            trace: trace_in,
            guides: guides_out,
        };
        let rate_hz = options.rate_hz;
        let setting = Setting { mapping, is_absolute, coupling, limitations, centre, start_pose: pose, rate_hz };
        let servo = match ServoSide::new(device, setting, ends) {
            Ok(servo) => servo,
            Err((error, device)) => {
                session.set_coupling(wanted);
                return Err(refused(error, session, device));
            }
        };
        let collision = CollisionSide::new(session, wanted, pose, targets_out, sets_in, collision_in);
        let watch = Watch { views, servo: servo_records, collision: collision_records, trace, guides };
        Ok(Sides { collision, servo, watch })
    }
}

/// Ends both threads when it is dropped, however its own ends.
struct Ending(Arc<AtomicBool>);

impl Drop for Ending {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Release);
    }
}

/// A running session: a servo thread and a collision thread, which exchange their newest results and never wait for
/// each other.
///
/// - **Servo thread**: at absolute times it reads the device, moves the proxy by the newest constraints, and sends the
///   force. No lock, no allocation.
/// - **Collision thread**: moves the proxy to the newest target and finds its contacts. Changes of the scene (a start,
///   a grip) happen between two ticks; meanwhile the servo thread continues with its data.
/// - **Picture**: takes a [`View`] at any time; nobody waits for it.
///
/// If one thread stalls: the servo side holds the proxy at the bound of the last constraints, so the hand feels drag,
/// and releases the force when they are older than half a second. A stalled servo thread leaves the force to the
/// device's own watchdog, and restarts from zero. A device that fails, is silent or reports invalid values gets no
/// force, and is read again each tick. A panic in a thread, and a broken device, end the run; the force is released
/// first.
///
/// Dropping it stops the run.
pub struct Runner {
    is_over: Arc<AtomicBool>,
    commands: Sender<Command>,
    watch: Watch,
    servo: Option<JoinHandle<Option<ServoSide>>>,
    collision: Option<JoinHandle<Option<CollisionSide>>>,
    coupling: Coupling,
    limitations: Limitations,
    /// Of the device, in the tool's world, and the servo's rate.
    info: DeviceInfo,
    rate_hz: f64,
    scale: f64,
}

impl Runner {
    /// Runs a session, which must be started. Unless the mapping is absolute, the tool stays where it is, with the handle where it is.
    pub fn run(
        session: Session,
        device: Box<dyn Device>,
        clock: Arc<dyn Clock>,
        options: &RunnerOptions,
    ) -> Result<Runner, Box<Refused>> {
        let Sides { collision, servo, watch } = Sides::new(session, device, options)?;
        let (coupling, limitations) = servo.coupling();
        let (coupling, limitations, info) = (*coupling, *limitations, servo.info_in_world());
        let is_over = Arc::new(AtomicBool::new(false));
        let (commands, asked) = channel();
        // The threads are given their sides when both are there, so that nothing is lost where one cannot be had.
        let (servo_in, servo_out) = sync_channel::<ServoSide>(1);
        let (collision_in, collision_out) = sync_channel::<CollisionSide>(1);
        let (ready, has_begun) = sync_channel::<()>(2);
        let both = (|| {
            let (over, own, its_clock, begun) = (is_over.clone(), options.clone(), clock.clone(), ready.clone());
            let servo = thread("feeler-servo", move || {
                let _ending = Ending(over.clone());
                begin(&own, ThreadKind::Servo, begun);
                let side = servo_out.recv().ok()?;
                Some(run_servo(side, &over, &*its_clock, &own))
            })?;
            let (over, own) = (is_over.clone(), options.clone());
            let collision = thread("feeler-collision", move || {
                let _ending = Ending(over.clone());
                begin(&own, ThreadKind::Collision, ready);
                let side = collision_out.recv().ok()?;
                Some(run_collision(side, &over, &*clock, &own, &asked))
            })?;
            Ok((servo, collision))
        })();
        let (servo_thread, collision_thread) = match both {
            Ok(both) => both,
            Err(error) => {
                let session = Some(collision.into_session());
                return Err(Box::new(Refused { error, session, device: servo.into_device() }));
            }
        };
        // Until both threads are set up, or one has ended.
        for _ in 0..2 {
            let _ = has_begun.recv();
        }
        // The threads wait for these; where one has gone already, joining it says so.
        let _ = collision_in.send(collision);
        let _ = servo_in.send(servo);
        let (servo, collision) = (Some(servo_thread), Some(collision_thread));
        let (rate_hz, scale) = (options.rate_hz, options.mapping.scale);
        Ok(Runner { is_over, commands, watch, servo, collision, coupling, limitations, info, rate_hz, scale })
    }

    /// Whether both threads are at work. One that panicked ends both.
    pub fn is_running(&self) -> bool {
        !self.is_over.load(Ordering::Acquire)
    }

    /// The view of the run.
    pub fn watch(&mut self) -> &mut Watch {
        &mut self.watch
    }

    /// The coupling in use: the session's, limited to the device.
    pub fn coupling(&self) -> &Coupling {
        &self.coupling
    }

    /// What the device took away of it; [`limitations_in_words`](Self::limitations_in_words) has it as sentences.
    pub fn limitations(&self) -> &Limitations {
        &self.limitations
    }

    /// The same, a sentence for each number: the reduced value, the requested one, and the reason; also if the servo or
    /// the device is clearly slower than the coupling is limited for, which reduces the stiffness in use. Numbers are in
    /// the tool's world, like the coupling's.
    pub fn limitations_in_words(&mut self) -> Vec<String> {
        let mut said = self.limitations.in_words(&self.info, self.rate_hz, self.scale);
        let view = *self.watch.view();
        if view.number >= TICKS_FOR_A_RATE && view.stiffness_share < 1.0 {
            let why = slow_in_words(&view, &self.info, self.rate_hz);
            let Coupling { stiffness_n_per_m, rotational_stiffness_nm_per_rad, .. } = self.coupling;
            let springs = [
                ("stiffness", stiffness_n_per_m, "N/m"),
                ("rotational stiffness", rotational_stiffness_nm_per_rad, "Nm/rad"),
            ];
            for (what, wanted, unit) in springs.into_iter().filter(|(_, wanted, _)| *wanted > 0.0) {
                let [allowed, wanted] = [view.stiffness_share * wanted, wanted].map(in_words);
                said.push(format!("{what} {allowed} {unit} instead of {wanted}: {why}"));
            }
        }
        said
    }

    fn ask(&self, wish: Wish) -> Result<Answer> {
        let (reply, answer) = sync_channel(1);
        self.commands.send(Command { wish, reply }).map_err(|_| Error::Ended)?;
        answer.recv().map_err(|_| Error::Ended)?
    }

    /// Begins anew at a pose, as [`Session::start`]: the handle where it is means that pose from now on, unless the mapping is absolute.
    pub fn start(&self, pose: &Pose) -> Result<Start> {
        self.ask_for_start(Wish::Start(*pose))
    }

    /// As [`Session::set_scene`].
    pub fn set_scene(&self, scene: Arc<Scene>) -> Result<Start> {
        self.ask_for_start(Wish::Scene(scene))
    }

    fn ask_for_start(&self, wish: Wish) -> Result<Start> {
        match self.ask(wish)? {
            Answer::Started(start) => Ok(start),
            Answer::Done => Ok(Start::Free),
        }
    }

    /// As [`Session::grip`].
    pub fn grip(&self, parts: &[u32]) -> Result<()> {
        self.ask(Wish::Grip(parts.to_vec())).map(|_| ())
    }

    /// As [`Session::release`].
    pub fn release(&self, to: Release) -> Result<()> {
        self.ask(Wish::Release(to)).map(|_| ())
    }

    /// Lets go of the force, then ends the threads.
    pub fn stop(mut self) -> Stopped {
        self.end()
    }

    fn end(&mut self) -> Stopped {
        self.is_over.store(true, Ordering::Release);
        let mut error = None;
        let mut ended = |thread: &'static str| {
            error = Some(Error::Panicked { thread });
        };
        // The servo thread lets go as soon as it wakes; the collision thread may have a search to finish.
        let servo = match self.servo.take().map(JoinHandle::join) {
            Some(Ok(side)) => side,
            Some(Err(_)) => {
                ended("servo");
                None
            }
            None => None,
        };
        let mut broken = None;
        let (device_error, device) = match servo {
            Some(side) => {
                broken = side.last_error().filter(|_| side.is_broken()).map(ToString::to_string);
                (side.last_error().cloned(), side.into_device())
            }
            None => (None, None),
        };
        let collision = match self.collision.take().map(JoinHandle::join) {
            Some(Ok(side)) => side,
            Some(Err(_)) => {
                ended("collision");
                None
            }
            None => None,
        };
        let (collision_error, session) = match collision {
            Some(side) => (side.last_error().cloned(), Some(side.into_session())),
            None => (None, None),
        };
        let error = error.or(broken.map(|why| Error::Device { why }));
        let (statistics, trace) = (self.watch.statistics(), self.watch.trace());
        Stopped { session, device, statistics, trace, error, device_error, collision_error }
    }
}

impl Drop for Runner {
    fn drop(&mut self) {
        if self.servo.is_some() || self.collision.is_some() {
            self.end();
        }
    }
}

/// Why a view has less stiffness than the coupling: the servo or the device is slow, or late, with both figures.
fn slow_in_words(view: &View, info: &DeviceInfo, rate_hz: f64) -> String {
    let [servo_s, reports_s] = view.periods_s;
    let nominal_hz = if info.limits.rate_hz > 0.0 { rate_hz.min(info.limits.rate_hz) } else { rate_hz };
    let name = &info.name;
    let late = view.late_s - info.limits.delay_s;
    if late > servo_s.max(reports_s) {
        let [late, known] = [1e3 * view.late_s, 1e3 * info.limits.delay_s].map(in_words);
        return format!("the poses of the {name} are {late} ms old when they come instead of {known}");
    }
    if reports_s > RATE_SHARE * servo_s {
        let [reports, nominal] = [1.0 / reports_s, nominal_hz].map(in_words);
        return format!("the {name} reports {reports} poses a second instead of {nominal}");
    }
    let [servo, nominal] = [1.0 / servo_s, rate_hz].map(in_words);
    format!("the servo runs at {servo} Hz instead of {nominal}")
}

fn thread<T: Send + 'static>(name: &str, work: impl FnOnce() -> T + Send + 'static) -> Result<JoinHandle<T>> {
    Builder::new().name(name.into()).spawn(work).map_err(|error| Error::Thread { why: error.to_string() })
}

/// Of a thread, before its first tick.
fn begin(options: &RunnerOptions, kind: ThreadKind, begun: SyncSender<()>) {
    (options.on_thread_start)(kind);
    // Who waits for it is there.
    let _ = begun.send(());
}

/// How long something took: in the thread's own time where the clock tells it.
fn timed(clock: &dyn Clock, work: impl FnOnce()) -> f64 {
    let time = || clock.thread_time().unwrap_or_else(|| clock.now());
    let before = time();
    work();
    time() - before
}

fn run_servo(mut side: ServoSide, is_over: &AtomicBool, clock: &dyn Clock, options: &RunnerOptions) -> ServoSide {
    let period = 1.0 / options.rate_hz;
    let mut due = clock.now();
    loop {
        if is_over.load(Ordering::Acquire) {
            side.release();
            return side;
        }
        let now = clock.now();
        let late = (now - due).max(0.0);
        let took = timed(clock, || side.tick(now));
        if side.is_broken() {
            side.release();
            return side;
        }
        let misses = (late / period).floor();
        side.took(late, took, misses as u64, now);
        due += (misses + 1.0) * period;
        clock.sleep_until(due);
    }
}

fn run_collision(
    mut side: CollisionSide,
    is_over: &AtomicBool,
    clock: &dyn Clock,
    options: &RunnerOptions,
    commands: &Receiver<Command>,
) -> CollisionSide {
    let (mut last, mut due) = (f64::NEG_INFINITY, clock.now());
    while !is_over.load(Ordering::Acquire) {
        while let Ok(Command { wish, reply }) = commands.try_recv() {
            let (mut wish, mut answer) = (Some(wish), Err(Error::Ended));
            (options.around_work)(&mut || {
                if let Some(wish) = wish.take() {
                    answer = side.apply(wish);
                }
            });
            // Who asked may have gone.
            let _ = reply.send(answer);
        }
        let now = clock.now();
        if now < due {
            // In short naps, so that a slow rate keeps nobody waiting who asks for something or ends the run.
            clock.sleep_until(due.min(now + COLLISION_REFRESH_S));
            continue;
        }
        if options.collision_hz.is_none() && !side.has_news() && now - last < COLLISION_REFRESH_S {
            clock.sleep_until(now + COLLISION_REST_S);
            continue;
        }
        let took = timed(clock, || side.tick(now));
        side.took(took, now);
        last = now;
        if let Some(hz) = options.collision_hz {
            due = (due + 1.0 / hz).max(clock.now());
        }
    }
    side
}
