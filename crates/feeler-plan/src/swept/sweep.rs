//! The whole: steps, grid, search, surface.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::Mutex;

use feeler_core::{Error, Point, Pose, Progress, Result, Tool};
use rayon::prelude::*;

use super::block::{Field, Scratch, Solid};
use super::cells::Piece;
use super::constants::{
    BLOCK, BYTES_PER_TRIANGLE, DISTANCE_TOLERANCE, HULL_SHARE, INTERPOLATION, LEVEL, LONGEST_EDGE, MOST_CELLS, SHARES,
    SPACING, TRIANGLES_PER_CELL,
};
use super::join::joined;
use super::steps::Steps;
use super::tree::Cube;

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

/// A closed mesh that contains everything a tool sweeps on its way from pose to pose, [`feeler_core::Motion`] between them, and of
/// which nothing is farther than `error` (metres) from that.
///
/// What a closed surface of the tool has inside is swept, too; a hollow that nothing sweeps stays. The same on any number of threads:
/// of the current rayon pool. `memory`: most bytes that it may take.
///
/// # Errors
///
/// [`Error::EmptyPath`] for no pose, [`Error::SweptError`] for an error that is no positive length, [`Error::SweptTooFine`] for one that
/// is too small for the memory, the grid's numbers or float64, before the most of the work, and [`Error::Cancelled`] where `progress`
/// said so.
pub fn swept(tool: &Tool, poses: &[Pose], error: f64, memory: u64, progress: Progress<'_>) -> Result<Swept> {
    if !(error > 0.0 && error.is_finite()) {
        return Err(Error::SweptError { value: error });
    }
    if poses.is_empty() {
        return Err(Error::EmptyPath);
    }
    if !progress(0.0, "cutting the way into steps") {
        return Err(Error::Cancelled);
    }
    let tolerance = DISTANCE_TOLERANCE * error;
    let steps = Steps::new(tool, poses, error, tolerance, memory / 4)?;
    let spacing = SPACING * error;
    let level = LEVEL * spacing;
    let far = level + LONGEST_EDGE * spacing + (HULL_SHARE + 4.0 * DISTANCE_TOLERANCE) * error;
    // A cell of room around all that is nearer than `far`.
    let margin = far + spacing;
    let bounds = &steps.bounds;
    let corner: Point = std::array::from_fn(|a| bounds.lower[a] - margin);
    let cells = (bounds.longest() + 2.0 * margin) / spacing;
    if cells > f64::from(MOST_CELLS) {
        let needed = format!("{cells:.1e} cells along one axis where {MOST_CELLS} are allowed");
        return Err(Error::SweptTooFine { error, needed, least: error * 1.1 * cells / f64::from(MOST_CELLS) });
    }
    let side = (cells.ceil() as u32).max(BLOCK as u32).next_power_of_two();
    let solid = Solid::new(tool, steps.first());
    let field = Field { steps: &steps, corner, spacing, level, far, tolerance, solid };
    let near = (0..steps.count()).collect();
    let shares = shared_out(&field, Cube { at: [0; 3], side, near }, progress)?;
    check_memory(&shares, error, memory)?;
    let pieces = pieces(&field, shares, progress)?;
    let (mut vertices, faces) = joined(pieces)?;
    for p in &mut vertices {
        *p = std::array::from_fn(|a| steps.origin[a] + (corner[a] + p[a] * spacing));
    }
    Ok(Swept { vertices, faces })
}

/// The cubes of one size that the surface may be in, so many that each thread has its share; blocks where there are few.
fn shared_out(field: &Field<'_>, whole: Cube, progress: Progress<'_>) -> Result<Vec<Cube>> {
    let mut cubes = vec![whole];
    while cubes.len() < SHARES && cubes.iter().any(|cube| !cube.is_block()) {
        if !progress(0.0, "looking where the tool comes") {
            return Err(Error::Cancelled);
        }
        cubes = cubes.into_par_iter().flat_map_iter(|cube| cube.halves(field)).collect();
    }
    Ok(cubes)
}

/// A cube that the surface passes has about as many cells of it as its side has.
fn check_memory(cubes: &[Cube], error: f64, memory: u64) -> Result<()> {
    let cells: f64 = cubes.iter().map(|cube| f64::from(cube.side) * f64::from(cube.side)).sum();
    let needed = cells * TRIANGLES_PER_CELL * BYTES_PER_TRIANGLE;
    if needed <= memory as f64 {
        return Ok(());
    }
    let least = error * 1.1 * (needed / (memory as f64).max(1.0)).sqrt();
    let needed = format!(
        "about {:.1e} triangles, {needed:.1e} bytes of memory where {:.1e} are allowed",
        cells * TRIANGLES_PER_CELL,
        memory as f64
    );
    Err(Error::SweptTooFine { error, needed, least })
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
            if !progress(f64::min(*done, 1.0), "finding the surface") {
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

/// What a cube costs, about.
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
