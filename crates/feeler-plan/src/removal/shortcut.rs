//! Makes a path shorter, with fewer turns, and farther away from its surroundings.

use feeler_core::geometry::twist::{pose_of, times};
use feeler_core::geometry::vectors::sub;
use feeler_core::{Leg, Motion, Pose};

use super::clearance::pulled_up;
use super::verify::{is_free, HasTime};
use crate::blocked::Tally;
use crate::constants::{CUT_TRIES, LEAST_CUT, MOST_UNTURNED};
use crate::error::Result;
use crate::random::Random;
use feeler_world::{Care, Surroundings};

/// The path with shortcuts: from each leg's begin straight to the last possible end, then between random places on it.
/// The seats at a pose are found again while walking the path, since a shortcut may separate a pair elsewhere. The work
/// is bounded.
pub fn shortened(
    around: &Surroundings,
    legs: Vec<Leg>,
    seed: u64,
    has_time: HasTime<'_>,
    tally: &mut Tally,
) -> Result<Vec<Leg>> {
    let legs = unturned(around, legs, has_time, tally)?;
    let mut way = leapt(around, legs, has_time, tally)?;
    let mut random = Random::new(seed, u64::MAX);
    let mut tries = 0;
    while tries < CUT_TRIES && way.len() > 1 {
        tries += 1;
        let motions = Motion::of_legs(around.tool(), around.start(), &way)?;
        let whole: f64 = motions.iter().map(Motion::longest_way).sum();
        let (mut a, mut b) = (random.between(0.0, whole), random.between(0.0, whole));
        if a > b {
            (a, b) = (b, a);
        }
        let (Some((first, since)), Some((last, until))) = (place(&motions, a), place(&motions, b)) else { continue };
        let (from, to) = (motions[first].at(since), motions[last].at(until));
        let saved = (b - a) - Motion::new(around.tool(), &from, &to).longest_way();
        if first == last || saved < LEAST_CUT * around.size() {
            continue;
        }
        let mut cut: Vec<Leg> = way[..first].to_vec();
        cut.extend([motions[first].until(around.tool(), since)?.leg(), Leg::To(to)]);
        cut.push(motions[last].rest(around.tool(), until)?.leg());
        cut.extend_from_slice(&way[last + 1..]);
        if is_free(around, &cut, first, has_time, tally)? {
            way = cut;
        }
    }
    let way = unturned(around, leapt(around, way, has_time, tally)?, has_time, tally)?;
    let way = pulled_up(around, way, has_time, tally)?;
    // There is more room now.
    unturned(around, way, has_time, tally)
}

/// The way without turns that are not needed: from the first place on from which it can be had without any more. The middle of the tool's
/// box goes the same way. Of poses alone: a screw was found because it is needed.
fn unturned(around: &Surroundings, way: Vec<Leg>, has_time: HasTime<'_>, tally: &mut Tally) -> Result<Vec<Leg>> {
    let motions = Motion::of_legs(around.tool(), around.start(), &way)?;
    if way.iter().any(|leg| matches!(leg, Leg::Screw(_))) {
        return Ok(way);
    }
    for (from, motion) in motions.iter().enumerate().take(MOST_UNTURNED) {
        if motions[from..].iter().all(|motion| motion.angle() == 0.0) {
            break;
        }
        let rotation = *motion.at(0.0).rotation();
        let mut straight = way[..from].to_vec();
        for leg in &motions[from..] {
            let middle = leg.end().apply(around.middle());
            straight.push(Leg::To(pose_of(&rotation, &sub(&middle, &times(&rotation, around.middle())))?));
        }
        let is_out = matches!(straight.last(), Some(Leg::To(end)) if around.is_out(end));
        if is_out && is_free(around, &straight, from, has_time, tally)? {
            return Ok(straight);
        }
    }
    Ok(way)
}

/// The motion and the time on it at a length along a way.
fn place(motions: &[Motion], at: f64) -> Option<(usize, f64)> {
    let mut left = at;
    for (number, motion) in motions.iter().enumerate() {
        if left < motion.longest_way() {
            return Some((number, left / motion.longest_way()));
        }
        left -= motion.longest_way();
    }
    None
}

/// From each place where legs meet on to the last one that a free motion leads to, by halves: first the end is tried, then the place half
/// as far. A leg alone stays as it is.
fn leapt(around: &Surroundings, way: Vec<Leg>, has_time: HasTime<'_>, tally: &mut Tally) -> Result<Vec<Leg>> {
    let motions = Motion::of_legs(around.tool(), around.start(), &way)?;
    let mut seated = around.seated_at_start();
    let (mut at, mut leaps) = (0, Vec::new());
    let mut here: Pose = *around.start();
    while at < way.len() {
        let mut beyond = way.len();
        loop {
            let leg = if beyond == at + 1 { way[at] } else { Leg::To(*motions[beyond - 1].end()) };
            let motion = Motion::of_legs(around.tool(), &here, &[leg])?.remove(0);
            let walk = around.walk_along(&seated, &motion, Care::search(&[], has_time), &mut |_| ())?;
            tally.walked(around, &walk);
            if walk.stop.is_none() {
                (seated, here) = (walk.seated, *motion.end());
                leaps.push(leg);
                break;
            }
            if beyond == at + 1 {
                // What is seated differs from when the leg was found: the rest stays as it is.
                leaps.extend_from_slice(&way[at..]);
                return Ok(leaps);
            }
            beyond = at + ((beyond - at) / 2).max(1);
        }
        at = beyond;
    }
    Ok(leaps)
}
