//! `feeler._core.removal`: the way of a part out of a mock-up.

use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use feeler_core as core;
use feeler_plan::{Allowed, Error, Method, Removal, RemovalOptions, RemovalTask};
use numpy::ndarray::Array3;
use numpy::{IntoPyArray, PyArray1, PyArray3, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyList;

use crate::arguments::{PoseArgument, ToolArgument};
use crate::errors::{raise, to_py};
use crate::pools::Pool;
use crate::reporter::Reporter;
use crate::scene::Scene;
use crate::screw::Screw;
use crate::topology::find_topology;
use crate::travel::{rows_of, stays};

/// How long nothing is told of what goes on.
const TELL_EVERY: Duration = Duration::from_millis(100);

/// The Python exception for an error of a plan.
fn plan_to_py(error: Error) -> PyErr {
    let class = match error {
        Error::Core(error) => return to_py(error),
        Error::World(_) => "PoseError",
        _ => "OptionError",
    };
    raise(class, error.to_string())
}

fn poses(poses: &[core::Pose]) -> Array3<f64> {
    let matrices: Vec<_> = poses.iter().map(core::Pose::matrix).collect();
    Array3::from_shape_fn((poses.len(), 4, 4), |(n, i, j)| matrices[n][i][j])
}

/// The answer of `_core.removal`, from which `feeler.Removal` is made.
#[pyclass(frozen, get_all, module = "feeler._core")]
pub struct RemovalAnswer {
    /// How the way was found; "none" if none was.
    method: String,
    /// By leg: the screw, or None for a leg to a pose.
    leg_screws: Py<PyList>,
    /// `(legs, 4, 4)`: the motion of the parts at the end of each leg.
    leg_ends: Py<PyArray3<f64>>,
    /// `(legs,)`: the travel of the middle of the box, metres.
    leg_lengths: Py<PyArray1<f64>>,
    /// `(legs,)`: radians.
    leg_angles: Py<PyArray1<f64>>,
    /// `(n, 4, 4)`: the same way as poses.
    poses: Py<PyArray3<f64>>,
    /// Metres.
    path_length: f64,
    /// Radians.
    rotation: f64,
    /// Metres; NaN if time ran out before it was measured.
    clearance: f64,
    /// Number of casts.
    casts: u64,
    /// Whether time ran out before the search was complete.
    is_out_of_time: bool,
    /// Whether it ended after the rounds that it was given.
    is_out_of_rounds: bool,
    /// Whether Ctrl-C interrupted it.
    is_interrupted: bool,
    /// `(k,)`: parts that stopped an attempt.
    blockers: Py<PyArray1<u32>>,
    /// `(k,)`: attempts stopped by each.
    blocker_counts: Py<PyArray1<u64>>,
    /// `(k,)`: the travel of the best of these attempts, metres.
    blocker_reaches: Py<PyArray1<f64>>,
    /// `(k, 4, 4)`: where that attempt was stopped.
    blocker_poses: Py<PyArray3<f64>>,
    /// `(k,)`: parts proven to hold it in place; empty without a proof.
    holders: Py<PyArray1<u32>>,
    /// A proven bound on the motion of every point, metres; NaN without a proof.
    play: f64,
}

#[pymethods]
impl RemovalAnswer {
    fn __reduce__(&self) -> PyResult<()> {
        Err(stays("RemovalAnswer", "pickle the feeler.Removal"))
    }
}

impl RemovalAnswer {
    fn new(py: Python<'_>, task: &RemovalTask, found: &Removal, is_interrupted: bool) -> PyResult<RemovalAnswer> {
        let method = match found.method {
            None => "none".to_string(),
            Some(Method::Out) => "out".to_string(),
            Some(Method::Straight) => "straight".to_string(),
            Some(Method::Pushes) => "pushes".to_string(),
            Some(Method::Tree(number)) => format!("tree {number}"),
        };
        let motions = core::Motion::of_legs(&task.tool, &task.start, &found.legs).map_err(to_py)?;
        let screws = found.legs.iter().map(|leg| match leg {
            core::Leg::To(_) | core::Leg::Chain(_) => None,
            core::Leg::Screw(core) => Some(Screw { core: *core }),
        });
        let ends: Vec<core::Pose> = motions.iter().map(|motion| *motion.end()).collect();
        let lengths = motions.iter().map(|motion| motion.way_of_pivot(&task.tool));
        let stopped: Vec<core::Pose> = found.blockers.iter().map(|b| b.pose).collect();
        Ok(RemovalAnswer {
            method,
            leg_screws: PyList::new(py, screws.collect::<Vec<_>>())?.unbind(),
            leg_ends: poses(&ends).into_pyarray(py).unbind(),
            leg_lengths: PyArray1::from_iter(py, lengths).unbind(),
            leg_angles: PyArray1::from_iter(py, motions.iter().map(core::Motion::angle)).unbind(),
            poses: poses(&found.poses).into_pyarray(py).unbind(),
            path_length: found.path_length,
            rotation: found.rotation,
            clearance: found.clearance,
            casts: found.casts,
            is_out_of_time: found.is_out_of_time,
            is_out_of_rounds: found.is_out_of_rounds,
            is_interrupted,
            blockers: PyArray1::from_iter(py, found.blockers.iter().map(|b| b.part)).unbind(),
            blocker_counts: PyArray1::from_iter(py, found.blockers.iter().map(|b| b.count)).unbind(),
            blocker_reaches: PyArray1::from_iter(py, found.blockers.iter().map(|b| b.reach)).unbind(),
            blocker_poses: poses(&stopped).into_pyarray(py).unbind(),
            holders: PyArray1::from_iter(py, found.held.iter().flat_map(|held| held.parts.iter().copied())).unbind(),
            play: found.held.as_ref().map_or(f64::NAN, |held| held.play),
        })
    }
}

/// The time that there is, told as a share of it done, with what is being tried.
struct Clock<'a> {
    reporter: &'a Reporter,
    begin: Instant,
    limit: Duration,
    /// What is being tried, and when that was told last.
    stage: Mutex<(String, Instant)>,
}

impl Clock<'_> {
    fn new(reporter: &Reporter, limit: Duration) -> Clock<'_> {
        let begin = Instant::now();
        Clock { reporter, begin, limit, stage: Mutex::new((String::new(), begin)) }
    }

    fn share(&self) -> f64 {
        (self.begin.elapsed().as_secs_f64() / self.limit.as_secs_f64()).min(1.0)
    }

    /// Something else is tried from now on. Whether to go on: also where Python raised, for what was found until then is wanted.
    fn begins(&self, stage: &str) -> bool {
        if let Ok(mut told) = self.stage.lock() {
            if told.0 != stage {
                *told = (stage.to_owned(), Instant::now());
                self.reporter.tell(self.share(), stage);
            }
        }
        true
    }

    /// Whether there is time, and Python raised nothing.
    fn has_time(&self) -> bool {
        if let Ok(mut told) = self.stage.try_lock() {
            if told.1.elapsed() > TELL_EVERY {
                told.1 = Instant::now();
                self.reporter.tell(self.share(), &told.0);
            }
        }
        self.begin.elapsed() < self.limit && !self.reporter.has_raised()
    }
}

/// A way of a tool out of a scene, and its blockers; the tool's first `own_parts` parts are parts of the mock-up.
#[pyfunction]
#[pyo3(signature = (scene, tool, start, *, own_parts, allow_start, allow_overlap, allow_parts, directions, clearance, seconds, seed,
                    rounds = None, threads = None, progress = None))]
#[allow(clippy::too_many_arguments, reason = "the Python signature")]
pub fn removal(
    py: Python<'_>,
    scene: &Scene,
    tool: ToolArgument<'_, '_>,
    start: PoseArgument,
    own_parts: u32,
    allow_start: bool,
    allow_overlap: f64,
    allow_parts: Vec<u32>,
    directions: PyReadonlyArray2<'_, f64>,
    clearance: f64,
    seconds: f64,
    seed: u64,
    rounds: Option<u32>,
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
) -> PyResult<RemovalAnswer> {
    let allowed = Allowed::default().with_start(allow_start).with_overlap(allow_overlap).with_parts(allow_parts);
    let task = RemovalTask::new(Arc::clone(tool.core()), start.0)
        .with_own_parts(own_parts)
        .with_allowed(allowed)
        .with_directions(rows_of(&directions)?)
        .with_clearance(clearance)
        .with_seed(seed)
        .with_rounds(rounds);
    let solver = Arc::clone(scene.solver());
    let own = threads.map(|threads| Arc::new(Pool::new(threads)));
    let pool = own.as_deref().or(scene.pool().map(Arc::as_ref));
    let reporter = Reporter::new(progress);
    let clock = Clock::new(&reporter, Duration::try_from_secs_f64(seconds).unwrap_or(Duration::MAX));
    let found = py.detach(|| {
        find_topology(solver.scene().mockup(), &task.tool, false)?;
        let (progress, has_time) = (|_: f64, stage: &str| clock.begins(stage), || clock.has_time());
        let options = RemovalOptions::default().with_progress(&progress).with_has_time(&has_time);
        reporter.watch(pool, || feeler_plan::removal(&solver, &task, &options))
    });
    let is_interrupted = reporter.finish_interrupted()?;
    RemovalAnswer::new(py, &task, &found?.map_err(plan_to_py)?, is_interrupted)
}
