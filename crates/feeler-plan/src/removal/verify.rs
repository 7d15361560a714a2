//! Whether a way is free, leg by leg, with the same allowances and finer steps.

use feeler_core::geometry::vectors::{cross, length, sub};
use feeler_core::{Leg, Motion, Pose};

use crate::blocked::Tally;
use crate::constants::{PIECES, SAME_MOTION};
use crate::error::Result;
use feeler_world::{Care, Span, Surroundings};

/// Whether there is time to go on; asked every few milliseconds.
pub type HasTime<'a> = &'a (dyn Fn() -> bool + Sync);

/// A way out that is free.
#[derive(Debug)]
pub struct Verified {
    /// From the start until it is out.
    pub legs: Vec<Leg>,
    /// Its motions in shares along which the same pairs are seated.
    pub spans: Vec<Span>,
}

/// The way, if all of it is free and it ends out.
pub fn verified(
    around: &Surroundings,
    legs: Vec<Leg>,
    has_time: HasTime<'_>,
    tally: &mut Tally,
) -> Result<Option<Verified>> {
    let motions = Motion::of_legs(around.tool(), around.start(), &legs)?;
    let mut seated = around.seated_at_start();
    let mut spans = Vec::new();
    for motion in &motions {
        let walk = around.walk_along(&seated, motion, Care::verify(has_time), &mut |span| spans.push(span))?;
        tally.walked(around, &walk);
        if walk.stop.is_some() {
            return Ok(None);
        }
        seated = walk.seated;
    }
    let last = motions.last().map_or(around.start(), Motion::end);
    if !around.is_out(last) {
        return Ok(None);
    }
    if spans.is_empty() {
        spans.push(Span { seated, motion: Motion::new(around.tool(), last, last) });
    }
    Ok(Some(Verified { legs, spans }))
}

/// The same way as poses, from one to the next as [`Motion::new`] moves: screws are cut into pieces, few first, until that is free, too.
/// Where the middle of the tool's box is on the axis of each screw, it is the same motion.
pub fn as_poses(
    around: &Surroundings,
    legs: &[Leg],
    has_time: HasTime<'_>,
    tally: &mut Tally,
) -> Result<Option<Vec<Pose>>> {
    let motions = Motion::of_legs(around.tool(), around.start(), legs)?;
    let is_same = |motion: &Motion| match motion.leg() {
        Leg::To(_) => true,
        Leg::Screw(screw) => {
            let middle = motion.at(0.0).apply(around.middle());
            length(&cross(&sub(&middle, screw.point()), screw.axis())) <= SAME_MOTION * around.size()
        }
    };
    let are_same = motions.iter().all(is_same);
    for pieces in PIECES {
        let poses: Vec<Pose> = motions.iter().flat_map(|motion| cut(motion, pieces)).collect();
        let is_free = |tally| verified(around, poses.iter().copied().map(Leg::To).collect(), has_time, tally);
        if are_same || is_free(tally)?.is_some() {
            return Ok(Some([&[*around.start()], &poses[..]].concat()));
        }
    }
    Ok(None)
}

/// The ends of the pieces of a motion: one, or of a screw so many for a quarter of a turn.
fn cut(motion: &Motion, pieces: usize) -> Vec<Pose> {
    let quarters = match motion.leg() {
        Leg::To(_) => 0.0,
        Leg::Screw(_) => motion.angle() / std::f64::consts::FRAC_PI_2,
    };
    let cuts = ((quarters * pieces as f64).ceil() as usize).max(1);
    (1..=cuts).map(|i| motion.at(i as f64 / cuts as f64)).collect()
}
