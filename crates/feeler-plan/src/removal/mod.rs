//! How a part comes out of a mock-up.
//!
//! Straight paths first, along directions that the contacts and the shapes suggest; then pushes as a person would try
//! them, and random trees. Every returned path is verified; if none is found, the answer lists the blocking parts. Only
//! parts that are proven to be held by their neighbours are reported as having no path.

mod clearance;
mod directions;
mod held;
mod pushes;
mod shape;
mod shortcut;
mod straight;
mod tree;
mod twists;
mod verify;

use std::sync::Arc;

use rayon::prelude::*;

use feeler_contacts::ContactSolver;
use feeler_core::geometry::vectors::unit;
use feeler_core::{GoOn, Leg, Motion, Point, Pose, Progress, Tool};

use self::directions::directions;
use self::held::held;
pub use self::held::Held;
use self::pushes::Pushes;
use self::shortcut::shortened;
use self::straight::straight_way;
use self::tree::Tree;
use self::verify::{as_poses, verified, HasTime, Verified};
use crate::blocked::{Blocker, Tally};
use crate::constants::{PUSH_CASTS, ROUNDS_TO_HALF, ROUND_CASTS, SHARE_OF_SEARCH, SHARE_OF_STRAIGHT, TREES};
use crate::error::{Error, Result};
use feeler_world::{Allowed, Body, Environment, Surroundings};

/// The task.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct RemovalTask {
    /// The moving body: parts of the mock-up, and their gripper.
    pub tool: Arc<Tool>,
    /// How many of its parts are the mock-up's: those before the gripper's.
    pub own_parts: u32,
    /// Its pose where the parts are.
    pub start: Pose,
    /// The allowed contacts.
    pub allowed: Allowed,
    /// Directions to try first, world; of any length.
    pub directions: Vec<Point>,
    /// The distance that it keeps from everything but seats, metres.
    pub clearance: f64,
    /// Of the random samples.
    pub seed: u64,
    /// The most rounds of pushes and trees, of equal work each; `None` for no limit but time. With it an answer that was not ended by time
    /// is the same on every machine.
    pub rounds: Option<u32>,
}

impl RemovalTask {
    /// A tool at a pose, all of whose parts are the mock-up's. What meets at the start may; there is no clearance, and no direction is
    /// tried first.
    pub fn new(tool: Arc<Tool>, start: Pose) -> RemovalTask {
        let own_parts = tool.parts() as u32;
        let allowed = Allowed::default().with_start(true);
        RemovalTask { tool, own_parts, start, allowed, directions: Vec::new(), clearance: 0.0, seed: 0, rounds: None }
    }

    feeler_core::setters! {
        with_own_parts: own_parts: u32,
        with_start: start: Pose,
        with_allowed: allowed: Allowed,
        with_directions: directions: Vec<Point>,
        with_clearance: clearance: f64,
        with_seed: seed: u64,
        with_rounds: rounds: Option<u32>,
    }
}

/// How [`removal`] works.
#[derive(Debug, Clone, Copy, Default)]
#[non_exhaustive]
pub struct RemovalOptions<'a> {
    /// Receives the stages, and may stop the search with an error. The share done grows from 0 towards 1 with each round of the
    /// search, ever slower, since the search does not know how many rounds it needs.
    pub progress: Progress<'a>,
    /// Asked every few milliseconds whether there is time to go on. Where it ends, a way found so far is returned without shortcuts.
    pub has_time: GoOn<'a>,
}

impl<'a> RemovalOptions<'a> {
    /// Calls a function with a share and the stage. The search stops with [`feeler_core::Error::Cancelled`] where it returns false.
    #[must_use]
    pub fn with_progress(mut self, progress: &'a (dyn Fn(f64, &str) -> bool + Sync)) -> Self {
        self.progress = Progress::new(progress);
        self
    }

    /// Asks a function whether there is time to go on; this crate reads no clock. Without it the search goes on until it finds a way, or
    /// shows that there is none.
    #[must_use]
    pub fn with_has_time(mut self, has_time: &'a (dyn Fn() -> bool + Sync)) -> Self {
        self.has_time = GoOn::new(has_time);
        self
    }
}

/// How a way was found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// It was out already.
    Out,
    /// Straight.
    Straight,
    /// By pushes as a person tries them.
    Pushes,
    /// By a random tree, of this number.
    Tree(u64),
}

/// A path out, or the blocking parts.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Removal {
    /// How the way was found; `None` where none was.
    pub method: Option<Method>,
    /// The way, from the start until the tool is out; none where none was found.
    pub legs: Vec<Leg>,
    /// The same as poses, from one to the next as [`Motion::new`] moves, and as free; the start alone where none was found.
    pub poses: Vec<Pose>,
    /// How far the middle of the tool's box moves, metres.
    pub path_length: f64,
    /// How far the tool turns in all, radians.
    pub rotation: f64,
    /// The least distance along the path to everything but seats, metres; infinite without other parts, NaN if time ran
    /// out before it was measured.
    pub clearance: f64,
    /// The blocking parts, most frequent first.
    pub blockers: Vec<Blocker>,
    /// The parts that hold it, if this proves that no path exists.
    pub held: Option<Held>,
    /// Casts made.
    pub casts: u64,
    /// Whether time was up before all was tried.
    pub is_out_of_time: bool,
    /// Whether it ended after the [`RemovalTask::rounds`] that it was given.
    pub is_out_of_rounds: bool,
}

impl Removal {
    /// Where there was no time to try anything.
    fn untried(start: &Pose) -> Removal {
        Removal {
            method: None,
            legs: Vec::new(),
            poses: vec![*start],
            path_length: 0.0,
            rotation: 0.0,
            clearance: f64::INFINITY,
            blockers: Vec::new(),
            held: None,
            casts: 0,
            is_out_of_time: true,
            is_out_of_rounds: false,
        }
    }
}

/// Takes a tool out of the scene of a solver, in parallel on the current rayon pool.
///
/// Errors: numbers that cannot be, a tool that grips and meets something at the start, a request to stop.
pub fn removal(solver: &ContactSolver, task: &RemovalTask, options: &RemovalOptions<'_>) -> Result<Removal> {
    check(task)?;
    let has_time = options.has_time.function();
    let report = |done: f64, stage: &str| match options.progress.tell(done, stage) {
        true => Ok(()),
        false => Err(Error::Core(feeler_core::Error::Cancelled)),
    };
    report(0.0, "straight ways")?;
    let RemovalTask { tool, own_parts, start, allowed, clearance, .. } = task;
    let mockup = Body { solver: solver.with_scene(solver.scene().clone()), part: None };
    let environment = Environment { bodies: vec![mockup] };
    let what = (allowed, *clearance);
    let found = Surroundings::new(environment, tool.clone(), *own_parts, start, what, has_time).map_err(Error::from);
    let Some(surroundings) = within(found, has_time)? else { return Ok(Removal::untried(start)) };
    let mut tally = Tally::default();
    if let Some(way) = verified(&surroundings, Vec::new(), has_time, &mut tally)? {
        return told(&surroundings, Ok((Method::Out, (way, vec![*start]))), &tally, has_time);
    }
    for [_, part] in surroundings.refused() {
        tally.note(*part, 0.0, start);
    }
    if !surroundings.refused().is_empty() {
        return told(&surroundings, Err(false), &tally, has_time);
    }
    let first: Vec<Point> = task.directions.iter().filter_map(unit).collect();
    let (others, walls) = directions(&surroundings)?;
    let straight = within(straight_way(&surroundings, (&first, &others, &walls), has_time, &mut tally), has_time)?;
    if let Some(way) = straight.flatten() {
        let ends = as_poses(&surroundings, &way.legs, has_time, &mut tally)?.unwrap_or_default();
        return told(&surroundings, Ok((Method::Straight, (way, ends))), &tally, has_time);
    }
    if allowed.overlap == 0.0 {
        report(SHARE_OF_STRAIGHT, "what holds it")?;
        if let Some(held) = held(&surroundings, has_time)? {
            return Ok(Removal { held: Some(held), ..told(&surroundings, Err(false), &tally, has_time)? });
        }
    }
    let mut pushes = Pushes::new(&surroundings, &first, &others, has_time);
    let directions: Vec<Point> = first.into_iter().chain(others).collect();
    let mut trees: Vec<Tree> =
        (0..TREES).map(|tree| Tree::new(&surroundings, &directions, (task.seed, tree), has_time)).collect();
    let (mut rounds, mut tree_rounds, mut is_out_of_rounds) = (0, 0, false);
    let mut search = || loop {
        let are_alone = pushes.are_alone(tree_rounds);
        report(share_after(rounds), if are_alone { "pushes" } else { "pushes and random trees" })?;
        if !has_time() {
            return Ok(None);
        }
        if task.rounds == Some(rounds) {
            is_out_of_rounds = true;
            return Ok(None);
        }
        rounds += 1;
        if are_alone {
            pushes.grow(PUSH_CASTS)?;
        } else {
            tree_rounds += 1;
            let (by_pushes, by_trees) = rayon::join(
                || pushes.grow(PUSH_CASTS),
                || trees.par_iter_mut().try_for_each(|tree| tree.grow(ROUND_CASTS)),
            );
            by_pushes.and(by_trees)?;
        }
        if let Some(found) = pushed_way(&surroundings, task.seed, &mut pushes, has_time)? {
            return Ok(Some(found));
        }
        if let Some(found) = first_way(&surroundings, task.seed, &mut trees, has_time)? {
            return Ok(Some(found));
        }
    };
    let found = within(search(), has_time)?.flatten();
    tally.add(&pushes.tally);
    trees.iter().for_each(|tree| tally.add(&tree.tally));
    let ended = told(&surroundings, found.ok_or(!is_out_of_rounds), &tally, has_time)?;
    Ok(Removal { is_out_of_rounds, ..ended })
}

/// The share done before a round of pushes and trees: half of what is left for them after [`ROUNDS_TO_HALF`].
fn share_after(rounds: u32) -> f64 {
    1.0 - (1.0 - SHARE_OF_SEARCH) / (1.0 + f64::from(rounds) / ROUNDS_TO_HALF)
}

/// The result of work that stops when its time is up; `None` if it stopped.
fn within<T>(done: Result<T>, has_time: HasTime<'_>) -> Result<Option<T>> {
    match done {
        Err(Error::Core(feeler_core::Error::Cancelled)) if !has_time() => Ok(None),
        done => done.map(Some),
    }
}

/// The way by pushes. One that is not free by finer steps is forgotten, and others are tried.
fn pushed_way(
    surroundings: &Surroundings,
    seed: u64,
    pushes: &mut Pushes<'_>,
    has_time: HasTime<'_>,
) -> Result<Option<Found>> {
    let Some(motions) = pushes.way.take() else { return Ok(None) };
    let legs: Vec<Leg> = motions.iter().map(Motion::leg).collect();
    let (way, casts) = short_way(surroundings, legs, seed, has_time)?;
    pushes.tally.casts += casts;
    let is_straight = |way: &Verified| way.legs.len() == 1 && motions.iter().all(|motion| motion.direction().is_some());
    Ok(way.map(|way| (if is_straight(&way.0) { Method::Straight } else { Method::Pushes }, way)))
}

/// The way of the tree with the least number that has one. One that is not free by finer steps is forgotten, and its tree grows on.
fn first_way(
    surroundings: &Surroundings,
    seed: u64,
    trees: &mut [Tree<'_>],
    has_time: HasTime<'_>,
) -> Result<Option<Found>> {
    for (number, tree) in (0..).zip(trees) {
        let Some(poses) = tree.way.take() else { continue };
        let (way, casts) = short_way(surroundings, poses.into_iter().map(Leg::To).collect(), seed, has_time)?;
        tree.tally.casts += casts;
        if let Some(way) = way {
            return Ok(Some((Method::Tree(number), way)));
        }
    }
    Ok(None)
}

/// A way, verified, and as poses.
type Way = (Verified, Vec<Pose>);
type Found = (Method, Way);

/// A way with shortcuts, or as it is where there is no time for them; and the casts made. `None` where it is not free by finer steps.
/// Blocked shortcuts say nothing about parts in the way out.
fn short_way(
    surroundings: &Surroundings,
    legs: Vec<Leg>,
    seed: u64,
    has_time: HasTime<'_>,
) -> Result<(Option<Way>, u64)> {
    let mut tally = Tally::default();
    let mut told = |legs: Vec<Leg>| -> Result<Option<Way>> {
        let Some(way) = verified(surroundings, legs, has_time, &mut tally)? else { return Ok(None) };
        let poses = as_poses(surroundings, &way.legs, has_time, &mut tally)?;
        Ok(poses.map(|poses| (way, poses)))
    };
    let as_found = told(legs.clone())?;
    if legs.len() < 2 {
        return Ok((as_found, tally.casts));
    }
    let mut own = Tally::default();
    let short = within(shortened(surroundings, legs, seed, has_time, &mut own).and_then(&mut told), has_time)?;
    Ok((short.flatten().or(as_found), tally.casts + own.casts))
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

/// The figures of a way; or, without one, whether time was up.
fn told(
    surroundings: &Surroundings,
    found: std::result::Result<Found, bool>,
    tally: &Tally,
    has_time: HasTime<'_>,
) -> Result<Removal> {
    let is_out_of_time = matches!(found, Err(true));
    let (method, legs, poses, clearance) = match found {
        Err(_) => (None, Vec::new(), vec![*surroundings.start()], f64::INFINITY),
        Ok((method, (Verified { legs, spans }, poses))) => {
            let least = |least, span| surroundings.least_distance(span, least, has_time);
            let clearance = within(spans.iter().try_fold(f64::INFINITY, least).map_err(Error::from), has_time)?;
            (Some(method), legs, poses, clearance.unwrap_or(f64::NAN))
        }
    };
    let (mut path_length, mut rotation) = (0.0, 0.0);
    for motion in Motion::of_legs(surroundings.tool(), surroundings.start(), &legs)? {
        path_length += motion.way_of_pivot(surroundings.tool());
        rotation += motion.angle();
    }
    let blockers = tally.blockers();
    Ok(Removal {
        method,
        legs,
        poses,
        path_length,
        rotation,
        clearance,
        blockers,
        held: None,
        casts: tally.casts,
        is_out_of_time,
        is_out_of_rounds: false,
    })
}
