//! Moves a path farther away from its surroundings.

use std::sync::Arc;

use feeler_core::geometry::vectors::{add, unit};
use feeler_core::{Leg, Motion, Pose};
use feeler_world::{Seated, Surroundings};

use super::twists::footholds;
use super::verify::{is_free, HasTime};
use crate::blocked::Tally;
use crate::constants::{LONGER_FOR_CLEARANCE, MOST_PULLS, PULLED_SAMPLES, PULLS};
use crate::error::Result;

/// The path with the poses between its legs moved away from the nearest parts along the neighbouring legs, in smaller
/// and smaller steps, as long as its distance grows and its length grows by at most [`LONGER_FOR_CLEARANCE`]. Its
/// distance is measured at samples.
pub fn pulled_up(
    around: &Surroundings,
    mut way: Vec<Leg>,
    has_time: HasTime<'_>,
    tally: &mut Tally,
) -> Result<Vec<Leg>> {
    let longest = LONGER_FOR_CLEARANCE * length(around, &way)?;
    let mut tries = 0;
    for step in PULLS.map(|share| share * around.size()) {
        for at in 0..way.len() {
            // Each place is some dozens of queries.
            if !has_time() {
                return Ok(way);
            }
            let Leg::To(pose) = way[at] else { continue };
            if matches!(way.get(at + 1), Some(Leg::Screw(_) | Leg::Chain(_))) {
                continue; // It would begin elsewhere.
            }
            let Some((gap, nearest, seated)) = nearest(around, &way, at, 2.0 * step)? else { continue };
            let normals = footholds(around, &nearest, gap + 0.5 * step)?.normals;
            let Some(off) = unit(&normals.iter().fold([0.0; 3], |sum, normal| add(&sum, normal))) else { continue };
            let moved = around.moved(&pose, &off, step)?;
            let mut pulled = way.clone();
            pulled[at] = Leg::To(moved);
            if around.distance(&seated, &around.moved(&nearest, &off, 0.5 * step)?, gap)?.is_some() {
                continue;
            }
            if at + 1 == way.len() && !around.is_out(&moved) || length(around, &pulled)? > longest {
                continue;
            }
            tries += 1;
            if tries > MOST_PULLS {
                return Ok(way);
            }
            let is_farther = self::nearest(around, &pulled, at, 1.05 * gap)?.is_none();
            if is_farther && is_free(around, &pulled, at, has_time, tally)? {
                way = pulled;
            }
        }
    }
    Ok(way)
}

fn length(around: &Surroundings, way: &[Leg]) -> Result<f64> {
    Ok(Motion::of_legs(around.tool(), around.start(), way)?.iter().map(Motion::longest_way).sum())
}

/// The sample of the leg to a place, and of the one from there, at which it is nearest to its unseated neighbours: how near (metres; `None`
/// beyond `within`), and the parts still seated.
fn nearest(around: &Surroundings, way: &[Leg], at: usize, within: f64) -> Result<Option<(f64, Pose, Arc<Seated>)>> {
    let motions = Motion::of_legs(around.tool(), around.start(), &way[..(at + 2).min(way.len())])?;
    let start = around.seated_at_start();
    let mut least: Option<(f64, Pose, Arc<Seated>)> = None;
    for motion in &motions[at..] {
        for sample in 1..=PULLED_SAMPLES {
            let pose = motion.at(f64::from(sample) / f64::from(PULLED_SAMPLES));
            let seated = around.left_at(&start, &pose)?.unwrap_or_else(|| start.clone());
            let reach = least.as_ref().map_or(within, |(gap, ..)| *gap);
            if let Some(gap) = around.distance(&seated, &pose, reach)? {
                least = Some((gap, pose, seated));
            }
        }
    }
    Ok(least)
}
