//! The whole computation: steps, grid, search, surface.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::Mutex;

use feeler_core::geometry::vectors::{cross, length, sub};
use feeler_core::{Aabb, Error, Point, Pose, Progress, Result, Tool};
use rayon::prelude::*;

use super::block::{Field, Grid, Scratch, Solid};
use super::cells::Piece;
use super::join::joined;
use super::steps::Steps;
use super::tree::Cube;
use crate::constants::{
    BLOCK, BYTES_PER_TRIANGLE, COARSE, DISTANCE_TOLERANCE, HULL_SHARE, INTERPOLATION, LEVEL, MOST_CELLS, MOST_TRIALS,
    SHARES, SPACING, TRIANGLES_PER_CELL,
};

const _: () = assert!(LEVEL >= INTERPOLATION);
const _: () = assert!((LEVEL + INTERPOLATION) * SPACING + HULL_SHARE + 2.0 * DISTANCE_TOLERANCE <= 1.0);

/// A closed mesh: each edge belongs to two triangles, once each way.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Swept {
    /// Metres, world.
    pub vertices: Vec<Point>,
    /// Wound with the normal outwards.
    pub faces: Vec<[u32; 3]>,
}

/// How [`swept`] works.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct SweptOptions<'a> {
    /// Most bytes that it may take; by default there is no limit.
    pub memory_limit: u64,
    /// Reports the progress, and may stop it.
    pub progress: Progress<'a>,
}

impl Default for SweptOptions<'_> {
    fn default() -> Self {
        SweptOptions { memory_limit: u64::MAX, progress: Progress::default() }
    }
}

impl<'a> SweptOptions<'a> {
    /// Sets the most bytes that it may take.
    #[must_use]
    pub fn with_memory_limit(mut self, bytes: u64) -> Self {
        self.memory_limit = bytes;
        self
    }

    /// Calls a function with the share done (0 to 1) and the stage. It stops with [`Error::Cancelled`] where that returns false.
    #[must_use]
    pub fn with_progress(mut self, progress: &'a (dyn Fn(f64, &str) -> bool + Sync)) -> Self {
        self.progress = Progress::new(progress);
        self
    }
}

/// A closed mesh that contains everything a tool sweeps on its way from pose to pose, [`feeler_core::Motion`] between them, and of
/// which nothing is farther than `error` (metres) from that.
///
/// What a closed surface of the tool has inside is swept, too; a hollow that nothing sweeps stays. The same on any number of threads:
/// of the current rayon pool.
///
/// # Errors
///
/// [`Error::EmptyPath`] for no pose, [`Error::SweptError`] for an error that is no positive length, [`Error::SweptTooFine`] for one that
/// is too small for the memory, the grid's numbers or float64, before the most of the work, and [`Error::Cancelled`] where the progress
/// function stopped it.
pub fn swept(tool: &Tool, poses: &[Pose], error: f64, options: &SweptOptions<'_>) -> Result<Swept> {
    let SweptOptions { memory_limit: memory, progress } = *options;
    if !(error > 0.0 && error.is_finite()) {
        return Err(Error::SweptError { value: error });
    }
    if poses.is_empty() {
        return Err(Error::EmptyPath);
    }
    let plan = match Plan::new(tool, poses, error, memory, progress) {
        Err(Error::SweptTooFine { needed, least, .. }) => {
            let least = fitting(tool, poses, least, memory, progress)?;
            return Err(Error::SweptTooFine { error, needed, least });
        }
        plan => plan?,
    };
    let Plan { steps, grid, cubes } = plan;
    let solid = Solid::new(tool, steps.first());
    let field = Field { steps: &steps, grid: &grid, solid };
    let (mut vertices, faces) = joined(pieces(&field, cubes, progress)?)?;
    for p in &mut vertices {
        *p = std::array::from_fn(|a| steps.origin[a] + (grid.corner[a] + p[a] * grid.spacing));
    }
    Ok(Swept { vertices, faces })
}

/// Steps, and where the surface may be: by then the cost of an error is known.
struct Plan {
    steps: Steps,
    grid: Grid,
    cubes: Vec<Cube>,
}

impl Plan {
    fn new(tool: &Tool, poses: &[Pose], error: f64, memory: u64, progress: Progress<'_>) -> Result<Plan> {
        if !progress.tell(0.0, "cutting the way into steps") {
            return Err(Error::Cancelled);
        }
        let steps = checked_steps(tool, poses, error, memory, progress)?;
        let (grid, cells) = Grid::around(&steps.bounds, error);
        check_cells(cells, error)?;
        let cubes = shared_out(&steps, &grid, cells, progress)?;
        check_surface(surface_cells(&cubes), error, memory)?;
        Ok(Plan { steps, grid, cubes })
    }
}

/// Steps, after a look with a larger error at how large the surface is: that is soon told.
fn checked_steps(tool: &Tool, poses: &[Pose], error: f64, memory: u64, progress: Progress<'_>) -> Result<Steps> {
    check_at_once(tool, poses, error, memory)?;
    let steps = |error: f64| Steps::new(tool, poses, error, DISTANCE_TOLERANCE * error, memory / 4);
    let coarse = error.max(tool.mesh().bounds().longest() * COARSE);
    let few = steps(coarse)?;
    let (grid, cells) = Grid::around(&few.bounds, coarse);
    check_cells(cells, coarse)?;
    let cubes = shared_out(&few, &grid, cells, progress)?;
    check_surface(surface_cells(&cubes) * (coarse / error).powi(2), error, memory)?;
    steps(error)
}

/// Of cubes: one that the surface passes has about as many cells of it as its side.
fn surface_cells(cubes: &[Cube]) -> f64 {
    cubes.iter().map(|cube| f64::from(cube.side).powi(2)).sum()
}

/// An error that fits, found by trial from one that may.
fn fitting(tool: &Tool, poses: &[Pose], from: f64, memory: u64, progress: Progress<'_>) -> Result<f64> {
    let mut error = from;
    for _ in 0..MOST_TRIALS {
        match checked_steps(tool, poses, error, memory, progress) {
            Err(Error::SweptTooFine { least, .. }) => error = least,
            other => return other.map(|_| error),
        }
    }
    Ok(error)
}

/// Checks the memory that is known without steps: the box around the tool at the poses, and twice the largest triangle.
fn check_at_once(tool: &Tool, poses: &[Pose], error: f64, memory: u64) -> Result<()> {
    let mesh = tool.mesh();
    let mut bounds = Aabb::EMPTY;
    for pose in poses {
        bounds.grow(&pose.apply(&mesh.corner(mesh.queried().next().unwrap_or(0))));
    }
    let largest = mesh.queried().fold(0.0, |most: f64, t| {
        let [a, b, c] = mesh.triangle(t);
        most.max(length(&cross(&sub(&b, &a), &sub(&c, &a))))
    });
    let (grid, cells) = Grid::around(&bounds, error);
    check_cells(cells, error)?;
    check_surface(largest / (grid.spacing * grid.spacing), error, memory)
}

fn check_cells(cells: f64, error: f64) -> Result<()> {
    if cells <= f64::from(MOST_CELLS) {
        return Ok(());
    }
    let needed = format!("{cells:.1e} cells along one axis where {MOST_CELLS} are allowed");
    Err(Error::SweptTooFine { error, needed, least: error * 1.1 * (cells / f64::from(MOST_CELLS)) })
}

/// `cells`: those that the surface passes, about.
fn check_surface(cells: f64, error: f64, memory: u64) -> Result<()> {
    let triangles = cells * TRIANGLES_PER_CELL;
    let bytes = triangles * BYTES_PER_TRIANGLE;
    let allowed = (memory as f64).min(f64::from(u32::MAX) * BYTES_PER_TRIANGLE);
    if bytes <= allowed {
        return Ok(());
    }
    let needed =
        format!("about {triangles:.1e} triangles, {bytes:.1e} bytes of memory where {allowed:.1e} are allowed");
    Err(Error::SweptTooFine { error, needed, least: error * 1.1 * (bytes / allowed.max(1.0)).sqrt() })
}

/// The cubes of one size that the surface may be in, so many that each thread has its share; blocks where there are few.
fn shared_out(steps: &Steps, grid: &Grid, cells: f64, progress: Progress<'_>) -> Result<Vec<Cube>> {
    let field = Field { steps, grid, solid: None };
    let side = (cells.ceil() as u32).max(BLOCK as u32).next_power_of_two();
    let mut cubes = vec![Cube { at: [0; 3], side, near: (0..steps.count()).collect() }];
    while cubes.len() < SHARES && cubes.iter().any(|cube| !cube.is_block()) {
        if !progress.tell(0.0, "looking where the tool comes") {
            return Err(Error::Cancelled);
        }
        cubes = cubes.into_par_iter().flat_map_iter(|cube| cube.halves(&field)).collect();
    }
    Ok(cubes)
}

/// The surface in all cubes, in their order.
fn pieces(field: &Field<'_>, cubes: Vec<Cube>, progress: Progress<'_>) -> Result<Vec<Piece>> {
    let whole: f64 = cubes.iter().map(weight).sum();
    let done = Mutex::new(0.0);
    let is_stopped = AtomicBool::new(false);
    let pieces: Vec<Vec<Piece>> = cubes
        .into_par_iter()
        .map_init(Scratch::default, |scratch, cube| {
            if is_stopped.load(Ordering::Relaxed) {
                return Vec::new();
            }
            let share = weight(&cube) / whole;
            let mut found = Vec::new();
            search(field, cube, scratch, &is_stopped, &mut found);
            let mut done = done.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
            *done += share;
            if !progress.tell(f64::min(*done, 1.0), "finding the surface") {
                is_stopped.store(true, Ordering::Relaxed);
            }
            found
        })
        .collect();
    if is_stopped.into_inner() {
        return Err(Error::Cancelled);
    }
    Ok(pieces.into_iter().flatten().collect())
}

/// Approximate cost of a cube.
fn weight(cube: &Cube) -> f64 {
    1.0 + cube.near.len() as f64
}

fn search(field: &Field<'_>, cube: Cube, scratch: &mut Scratch, is_stopped: &AtomicBool, found: &mut Vec<Piece>) {
    if is_stopped.load(Ordering::Relaxed) {
        return;
    }
    if cube.is_block() {
        let piece = field.piece(cube.at, &cube.near, scratch);
        if !piece.faces.is_empty() {
            found.push(piece);
        }
        return;
    }
    for half in cube.halves(field) {
        search(field, half, scratch, is_stopped, found);
    }
}
