//! How a part comes out of a mock-up.
//!
//! Straight ways first, along directions that the contacts and the shapes suggest. What is given was verified; where nothing is found
//! it says what was in the way, and never that there is none.

mod directions;
mod straight;

use std::sync::Arc;

use feeler_contacts::ContactSolver;
use feeler_core::geometry::screw::displacement;
use feeler_core::geometry::vectors::{length, unit};
use feeler_core::{Point, Pose, Progress, Tool};

use crate::blocked::{Blocker, Tally};
use crate::error::{Error, Result};
use crate::surroundings::{Allowed, Care, Span, Surroundings};

/// What is to come out.
#[derive(Debug, Clone)]
pub struct RemovalTask {
    /// What moves: parts of the mock-up, and what grips them.
    pub tool: Arc<Tool>,
    /// How many of its parts are the mock-up's: those before what grips.
    pub own_parts: u32,
    /// Its pose where the parts are.
    pub start: Pose,
    /// What may meet.
    pub allowed: Allowed,
    /// Directions to try first, world; of any length.
    pub directions: Vec<Point>,
    /// How far it stays off what is not seated, metres.
    pub clearance: f64,
    /// Of the random samples.
    pub seed: u64,
}

/// How a way was found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// It was out already.
    Out,
    /// Straight.
    Straight,
}

/// A way out, or what was in the way.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Removal {
    /// How the way was found; `None` where none was.
    pub method: Option<Method>,
    /// The way, from the start until the tool is out; the start alone where none was found. Between two poses it moves as
    /// [`Motion`](feeler_core::Motion) does.
    pub poses: Vec<Pose>,
    /// How far the middle of the tool's box moves, metres.
    pub path_length: f64,
    /// How far the tool turns in all, radians.
    pub rotation: f64,
    /// The least distance along the way of what is not seated, metres; infinite where nothing is there.
    pub clearance: f64,
    /// What stopped it, the worst first.
    pub blockers: Vec<Blocker>,
    /// Casts made.
    pub casts: u64,
    /// Whether time was up before all was tried.
    pub is_out_of_time: bool,
}

/// Takes a tool out of the scene that a solver is of, in parallel on the current rayon pool.
///
/// `progress` stops it; `has_time` says whether to try more: a way that is found does not depend on it. Errors: numbers that cannot be,
/// a tool that grips and meets something at the start, a request to stop.
pub fn removal(
    solver: &ContactSolver,
    task: &RemovalTask,
    progress: Progress<'_>,
    has_time: &(dyn Fn() -> bool + Sync),
) -> Result<Removal> {
    check(task)?;
    let report = |done: f64, stage: &str| match progress(done, stage) {
        true => Ok(()),
        false => Err(Error::Core(feeler_core::Error::Cancelled)),
    };
    report(0.0, "straight ways")?;
    let RemovalTask { tool, own_parts, start, allowed, clearance, .. } = task;
    let surroundings = Surroundings::new(solver, tool.clone(), *own_parts, start, allowed, *clearance)?;
    let mut tally = Tally::default();
    if surroundings.is_out(start) {
        return told(&surroundings, Some(Method::Out), vec![*start], &tally, false);
    }
    for [_, part] in surroundings.refused() {
        tally.note(*part, 0.0, start);
    }
    if !surroundings.refused().is_empty() {
        return told(&surroundings, None, vec![*start], &tally, false);
    }
    let first: Vec<Point> = task.directions.iter().filter_map(unit).collect();
    let goes_on = || {
        report(0.0, "straight ways")?;
        Ok(has_time())
    };
    if let Some(way) = straight::straight_way(&surroundings, &first, &mut tally, &goes_on)? {
        return told(&surroundings, Some(Method::Straight), way, &tally, false);
    }
    told(&surroundings, None, vec![*start], &tally, !has_time())
}

fn check(task: &RemovalTask) -> Result<()> {
    let length = |what, value: f64| match value.is_finite() && value >= 0.0 {
        true => Ok(()),
        false => Err(Error::Option { what, value, must: "it must be a finite distance of 0 metres or more" }),
    };
    length("clearance", task.clearance)?;
    length("allow", task.allowed.overlap)?;
    let numbers = task.directions.iter().find(|d| unit(d).is_none() || d.iter().any(|x| !x.is_finite()));
    match numbers {
        Some(d) => Err(Error::Option {
            what: "directions",
            value: d.iter().sum(),
            must: "each must be three finite numbers, not all zero",
        }),
        None => Ok(()),
    }
}

/// What there is to say of a way.
fn told(
    surroundings: &Surroundings,
    method: Option<Method>,
    poses: Vec<Pose>,
    tally: &Tally,
    is_out_of_time: bool,
) -> Result<Removal> {
    let (mut path_length, mut rotation) = (0.0, 0.0);
    for pair in poses.windows(2) {
        let by = displacement(&pair[0], &pair[1], surroundings.middle());
        path_length += length(&by.linear);
        rotation += length(&by.angular);
    }
    let clearance = if method.is_some() { least_distance(surroundings, &poses)? } else { 0.0 };
    let blockers = tally.blockers();
    Ok(Removal { method, poses, path_length, rotation, clearance, blockers, casts: tally.casts, is_out_of_time })
}

/// Along a way, of what is not seated.
fn least_distance(surroundings: &Surroundings, poses: &[Pose]) -> Result<f64> {
    let mut seated = surroundings.seated_at_start();
    let (mut spans, mut tally) = (Vec::new(), Tally::default());
    for pair in poses.windows(2) {
        let ends = (&pair[0], &pair[1]);
        let note = &mut |span| spans.push(span);
        seated = surroundings.walk_in_spans(&seated, ends, Care::Verify, &mut tally, note)?.seated;
    }
    if let [only] = poses {
        spans.push(Span { seated, from: *only, to: *only });
    }
    spans.iter().try_fold(f64::INFINITY, |least, span| surroundings.least_distance(span, least))
}
