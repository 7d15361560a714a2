//! What sessions and runs answer, as classes; `feeler.haptics` makes its own of them.

use feeler_core::Pose;
use feeler_haptics::{Distribution, Mode, Session, Start, Statistics, Step, TraceTick, View};
use numpy::ndarray::{Array2, Array3};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArray3};
use pyo3::prelude::*;

use crate::arrays::pose_array;
use crate::travel::stays;
use crate::world::SeatAnswer;

/// The start of a session.
#[pyclass(frozen, get_all, module = "feeler._core")]
pub struct StartAnswer {
    /// The contacts at the start.
    seats: Vec<Py<SeatAnswer>>,
    /// `(3,)`: a translation that frees the tool, metres, world; None unless it is sunk.
    way_out: Option<Py<PyArray1<f64>>>,
}

impl StartAnswer {
    pub fn new(py: Python<'_>, start: Start) -> PyResult<StartAnswer> {
        let Start::Seated(seating) = start else { return Ok(StartAnswer { seats: Vec::new(), way_out: None }) };
        let seats = seating.seats.iter().map(|seat| Py::new(py, SeatAnswer::new(seat))).collect::<PyResult<_>>()?;
        Ok(StartAnswer { seats, way_out: seating.way_out.map(|out| vector(py, &out.translation)) })
    }
}

/// One step of a session, with its contact planes, nearest first.
#[pyclass(frozen, get_all, module = "feeler._core")]
pub struct StepAnswer {
    /// `(4, 4)`: the proxy.
    world_from_proxy: Py<PyArray2<f64>>,
    /// `(3,)`: on the hand, newtons, world axes.
    force: Py<PyArray1<f64>>,
    /// `(3,)`: on the hand, newton metres, world axes, at the origin of the tool's frame.
    torque: Py<PyArray1<f64>>,
    /// Age of the contact planes, seconds.
    age: f64,
    /// `free`, `contact`, `bound` or `doubt`.
    mode: &'static str,
    /// `(k, 3)`: on the mock-up, metres, world; nearest first.
    points: Py<PyArray2<f64>>,
    /// `(k, 3)`: unit, from the mock-up to the tool.
    normals: Py<PyArray2<f64>>,
    /// `(k,)`: distances from the proxy, metres.
    gaps: Py<PyArray1<f64>>,
    /// `(k,)`: indices into `mockup.parts`.
    parts: Py<PyArray1<u32>>,
    /// `(k,)`: identify the pair of surfaces.
    ids: Py<PyArray1<u64>>,
    /// `(k,)`: whether the plane holds the proxy.
    is_holding: Py<PyArray1<bool>>,
}

impl StepAnswer {
    /// The step that the session has just made, with its newest planes, nearest first.
    pub fn new(py: Python<'_>, step: &Step, session: &Session) -> StepAnswer {
        let planes = session.planes();
        let held: Vec<u64> = session.held().map(|plane| plane.id).collect();
        StepAnswer {
            world_from_proxy: pose_array(py, &step.proxy).unbind(),
            force: vector(py, &step.wrench.force),
            torque: vector(py, &step.wrench.torque),
            age: step.age,
            mode: mode_name(step.mode),
            points: rows(py, planes.len(), |i| planes[i].point),
            normals: rows(py, planes.len(), |i| planes[i].normal),
            gaps: PyArray1::from_iter(py, planes.iter().map(|plane| plane.gap)).unbind(),
            parts: PyArray1::from_iter(py, planes.iter().map(|plane| plane.part)).unbind(),
            ids: PyArray1::from_iter(py, planes.iter().map(|plane| plane.id)).unbind(),
            is_holding: PyArray1::from_iter(py, planes.iter().map(|plane| held.contains(&plane.id))).unbind(),
        }
    }
}

/// How a run ended: errors as texts.
#[pyclass(frozen, get_all, module = "feeler._core")]
#[derive(Default)]
pub struct RunEnd {
    /// The error of a thread, if one failed.
    pub error: Option<String>,
    /// The last failure of the device.
    pub device_error: Option<String>,
    /// The last failure of the search for contacts.
    pub collision_error: Option<String>,
}

/// The newest tick of a run.
#[pyclass(frozen, get_all, module = "feeler._core")]
pub struct TickAnswer {
    /// Number of the servo tick; 0: none yet.
    number: u64,
    /// Seconds on the machine's clock.
    time: f64,
    /// `(4, 4)`: the proxy.
    world_from_proxy: Py<PyArray2<f64>>,
    /// `(4, 4)`: the pose of the device.
    world_from_device: Py<PyArray2<f64>>,
    /// `(3,)`: on the hand, newtons, world axes.
    force: Py<PyArray1<f64>>,
    /// `(3,)`: on the hand, newton metres, world axes, at the origin of the tool's frame.
    torque: Py<PyArray1<f64>>,
    /// Age of the contact planes, seconds.
    age: f64,
    /// `free`, `contact`, `bound` or `doubt`.
    mode: &'static str,
    /// Pressed buttons, a bit each.
    buttons: u32,
    /// Whether the clutch is pressed.
    is_clutched: bool,
    /// `(k, 3)`: on the mock-up, metres, world; nearest first.
    points: Py<PyArray2<f64>>,
    /// `(k, 3)`: unit, from the mock-up to the tool.
    normals: Py<PyArray2<f64>>,
    /// `(k,)`: distances from the proxy, metres.
    gaps: Py<PyArray1<f64>>,
    /// `(k,)`: indices into `mockup.parts`.
    parts: Py<PyArray1<u32>>,
}

impl TickAnswer {
    pub fn new(py: Python<'_>, view: &View) -> TickAnswer {
        let planes = view.held();
        TickAnswer {
            number: view.number,
            time: view.time,
            world_from_proxy: pose_array(py, &view.proxy).unbind(),
            world_from_device: pose_array(py, &view.device).unbind(),
            force: vector(py, &view.wrench.force),
            torque: vector(py, &view.wrench.torque),
            age: view.age,
            mode: mode_name(view.mode),
            buttons: view.buttons,
            is_clutched: view.is_clutched,
            points: rows(py, planes.len(), |i| planes[i].point),
            normals: rows(py, planes.len(), |i| planes[i].normal),
            gaps: PyArray1::from_iter(py, planes.iter().map(|plane| plane.gap)).unbind(),
            parts: PyArray1::from_iter(py, planes.iter().map(|plane| plane.part)).unbind(),
        }
    }
}

/// All ticks of a period.
#[pyclass(frozen, get_all, module = "feeler._core")]
pub struct TraceAnswer {
    /// `(n,)`: seconds on the machine's clock.
    times: Py<PyArray1<f64>>,
    /// `(n, 4, 4)`.
    world_from_device: Py<PyArray3<f64>>,
    /// `(n, 4, 4)`.
    world_from_proxy: Py<PyArray3<f64>>,
    /// `(n, 6)`: force and torque on the hand.
    wrenches: Py<PyArray2<f64>>,
    /// As in `TickAnswer`, for each tick.
    modes: Vec<&'static str>,
    /// `(n,)`: whether the device reported a valid pose.
    has_device: Py<PyArray1<bool>>,
}

impl TraceAnswer {
    pub fn new(py: Python<'_>, ticks: &[TraceTick]) -> TraceAnswer {
        let wrench = |n: usize, j: usize| match j {
            0..3 => ticks[n].wrench.force[j],
            _ => ticks[n].wrench.torque[j - 3],
        };
        TraceAnswer {
            times: PyArray1::from_iter(py, ticks.iter().map(|tick| tick.time)).unbind(),
            world_from_device: poses(py, ticks, |tick| &tick.device),
            world_from_proxy: poses(py, ticks, |tick| &tick.proxy),
            wrenches: Array2::from_shape_fn((ticks.len(), 6), |(n, j)| wrench(n, j)).into_pyarray(py).unbind(),
            modes: ticks.iter().map(|tick| mode_name(tick.mode)).collect(),
            has_device: PyArray1::from_iter(py, ticks.iter().map(|tick| tick.has_device)).unbind(),
        }
    }
}

/// The distribution of durations, seconds.
#[pyclass(frozen, get_all, module = "feeler._core")]
pub struct DistributionAnswer {
    /// Number of durations.
    count: u64,
    /// Mean.
    mean: f64,
    /// Median.
    median: f64,
    /// 90th percentile.
    p90: f64,
    /// 99th percentile.
    p99: f64,
    /// 99.9th percentile.
    p999: f64,
    /// Longest.
    max: f64,
}

impl DistributionAnswer {
    fn new(py: Python<'_>, of: &Distribution) -> PyResult<Py<DistributionAnswer>> {
        let Distribution { count, mean, median, p90, p99, p999, max, .. } = *of;
        Py::new(py, DistributionAnswer { count, mean, median, p90, p99, p999, max })
    }
}

/// Timings and counts of a run; `feeler.haptics.Statistics` explains them.
#[pyclass(frozen, get_all, module = "feeler._core")]
pub struct StatisticsAnswer {
    /// Delay of servo ticks.
    servo_lateness: Py<DistributionAnswer>,
    /// CPU time of a servo tick.
    servo_tick: Py<DistributionAnswer>,
    /// Age of the contact planes at the servo's ticks.
    age: Py<DistributionAnswer>,
    /// CPU time of a search for contacts.
    collision_tick: Py<DistributionAnswer>,
    /// Servo ticks.
    ticks: u64,
    /// Skipped servo ticks.
    misses: u64,
    /// Servo ticks in doubt.
    doubts: u64,
    /// Failed reads and writes of the device.
    device_errors: u64,
    /// Sets of contact planes.
    sets: u64,
    /// Motions of the proxy that were tried.
    rounds: u64,
    /// Those stopped by the cast.
    stopped: u64,
    /// Failed searches for contacts.
    collision_errors: u64,
    /// Ticks per second.
    servo_hz: f64,
    /// Searches per second.
    collision_hz: f64,
}

impl StatisticsAnswer {
    pub fn new(py: Python<'_>, of: &Statistics) -> PyResult<StatisticsAnswer> {
        Ok(StatisticsAnswer {
            servo_lateness: DistributionAnswer::new(py, &of.servo_lateness)?,
            servo_tick: DistributionAnswer::new(py, &of.servo_tick)?,
            age: DistributionAnswer::new(py, &of.age)?,
            collision_tick: DistributionAnswer::new(py, &of.collision_tick)?,
            ticks: of.ticks,
            misses: of.misses,
            doubts: of.doubts,
            device_errors: of.device_errors,
            sets: of.sets,
            rounds: of.rounds,
            stopped: of.stopped,
            collision_errors: of.collision_errors,
            servo_hz: of.servo_hz,
            collision_hz: of.collision_hz,
        })
    }
}

/// What the system and the device granted to a run; `feeler.haptics.Granted` explains it.
#[pyclass(frozen, get_all, module = "feeler._core")]
pub struct GrantedAnswer {
    /// Priority of the servo thread, or why it has none.
    pub priority: String,
    /// Whether it has one.
    pub has_priority: bool,
    /// Priority of the collision thread, or why it has none.
    pub collision_priority: String,
    /// Whether it has one.
    pub has_collision_priority: bool,
    /// The locked memory, or why none is locked.
    pub memory: String,
    /// Whether memory is locked.
    pub is_locked: bool,
    /// The eight numbers of the coupling in use.
    pub coupling: [f64; 8],
    /// Reductions of the session's coupling, a sentence each.
    pub limitations: Vec<String>,
}

macro_rules! stay {
    ($($class:ident)*) => {$(
        #[pymethods]
        impl $class {
            fn __reduce__(&self) -> PyResult<()> {
                Err(stays(stringify!($class), "pickle what feeler.haptics makes of it"))
            }
        }
    )*};
}

stay!(StartAnswer StepAnswer RunEnd TickAnswer TraceAnswer DistributionAnswer StatisticsAnswer GrantedAnswer);

fn mode_name(mode: Mode) -> &'static str {
    match mode {
        Mode::Free => "free",
        Mode::Contact => "contact",
        Mode::Bound => "bound",
        Mode::Doubt => "doubt",
    }
}

fn vector(py: Python<'_>, vector: &[f64; 3]) -> Py<PyArray1<f64>> {
    PyArray1::from_slice(py, vector).unbind()
}

fn rows(py: Python<'_>, count: usize, of: impl Fn(usize) -> [f64; 3]) -> Py<PyArray2<f64>> {
    Array2::from_shape_fn((count, 3), |(i, j)| of(i)[j]).into_pyarray(py).unbind()
}

fn poses(py: Python<'_>, ticks: &[TraceTick], of: impl Fn(&TraceTick) -> &Pose) -> Py<PyArray3<f64>> {
    let all: Vec<_> = ticks.iter().map(|tick| of(tick).matrix()).collect();
    Array3::from_shape_fn((all.len(), 4, 4), |(n, i, j)| all[n][i][j]).into_pyarray(py).unbind()
}
