//! Verifies a path, leg by leg, with the same allowances, finer steps, and bounds on depths between them.

use std::f64::consts::{FRAC_PI_2, TAU};

use feeler_core::geometry::vectors::{cross, length, sub};
use feeler_core::{Leg, Motion, Pose};

use crate::blocked::Tally;
use crate::constants::{MOST_SAME_PIECES, PIECES, SAME_MOTION, SAME_PLACE_M};
use crate::error::Result;
use feeler_world::{Span, Surroundings, WalkOptions};

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
        let walk = around.walk_along(&seated, motion, WalkOptions::verify(has_time), &mut |span| spans.push(span))?;
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

/// Whether a way is free from a leg on; before that it is known to be.
pub fn is_free(
    around: &Surroundings,
    way: &[Leg],
    from: usize,
    has_time: HasTime<'_>,
    tally: &mut Tally,
) -> Result<bool> {
    let mut seated = around.seated_at_start();
    // Without seats nothing depends on the earlier motion.
    let first = if around.has_seats() { 0 } else { from };
    for motion in &Motion::of_legs(around.tool(), around.start(), way)?[first..] {
        let walk = around.walk_along(&seated, motion, WalkOptions::search(&[], has_time), &mut |_| ())?;
        tally.walked(around, &walk);
        if walk.stop.is_some() {
            return Ok(false);
        }
        seated = walk.seated;
    }
    Ok(true)
}

/// The same path as poses, with motions of [`Motion::new`] between them: screws are cut into the fewest pieces that are
/// verified as free; if they turn more than once around, into enough pieces that no point is off by more than
/// [`SAME_PLACE_M`], as each is a cast.
pub fn as_poses(
    around: &Surroundings,
    legs: &[Leg],
    has_time: HasTime<'_>,
    tally: &mut Tally,
) -> Result<Option<Vec<Pose>>> {
    let motions = Motion::of_legs(around.tool(), around.start(), legs)?;
    // Between two poses the middle of the tool's box goes straight, on a screw on an arc about the axis; the turns are the same.
    let off_the_axis = |motion: &Motion| match motion.leg() {
        Leg::To(_) => 0.0,
        Leg::Screw(screw) => {
            let middle = motion.at(0.0).apply(around.middle());
            length(&cross(&sub(&middle, screw.point()), screw.axis()))
        }
        // No search finds one: as far as its points go.
        Leg::Chain(_) => motion.longest_way(),
    };
    let farthest = motions.iter().map(off_the_axis).fold(0.0, f64::max);
    let same = (FRAC_PI_2 * (farthest / (8.0 * SAME_PLACE_M)).sqrt()).ceil().max(1.0) as usize;
    let turns: f64 = motions.iter().map(Motion::angle).sum();
    for pieces in PIECES {
        let is_same = farthest <= SAME_MOTION * around.size() || (turns > TAU && same <= MOST_SAME_PIECES);
        let pieces = if is_same { same } else { pieces };
        let poses: Vec<Pose> = motions.iter().flat_map(|motion| cut(motion, pieces)).collect();
        let is_free = |tally| verified(around, poses.iter().copied().map(Leg::To).collect(), has_time, tally);
        if is_same || is_free(tally)?.is_some() {
            return Ok(Some([&[*around.start()], &poses[..]].concat()));
        }
    }
    Ok(None)
}

/// The ends of the pieces of a motion: one, or for a screw `pieces` a quarter of a turn.
fn cut(motion: &Motion, pieces: usize) -> Vec<Pose> {
    let quarters = match motion.leg() {
        Leg::To(_) => 0.0,
        Leg::Screw(_) | Leg::Chain(_) => motion.angle() / FRAC_PI_2,
    };
    let cuts = ((quarters * pieces as f64).ceil() as usize).max(1);
    (1..=cuts).map(|i| motion.at(i as f64 / cuts as f64)).collect()
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use feeler_contacts::ContactSolver;
    use feeler_core::{Mockup, Scene, SceneOptions, Screw, Tool};
    use feeler_shapes::box_mesh;
    use feeler_world::{Allowed, Body, Environment};

    use super::*;

    #[test]
    fn screws_are_few_poses_unless_they_turn_more_than_once() {
        // A cube, and a post that it is off.
        let (vertices, faces) = box_mesh([0.0; 3], [0.02; 3], 1);
        let (post, of_post) = box_mesh([0.1, 0.1, 0.0], [0.01; 3], 1);
        let scene = Mockup::new(post, of_post, vec![], 1).unwrap();
        let scene = Scene::build(Arc::new(scene), &SceneOptions::default()).unwrap();
        let environment =
            Environment { bodies: vec![Body { solver: ContactSolver::new(Arc::new(scene)), part: None }] };
        let (tool, what) = (Arc::new(Tool::new(vertices, faces).unwrap()), (&Allowed::default(), 0.0));
        let around = Surroundings::new(environment, tool, 1, &Pose::IDENTITY, what, &|| true).unwrap();
        let poses = |off: f64, turns: f64, pitch: f64| {
            let screw = Screw::new(&[0.0, 0.0, 1.0], &[0.0, off, 0.0], turns * TAU, pitch).unwrap();
            let mut tally = Tally::default();
            let poses = as_poses(&around, &[Leg::Screw(screw)], &|| true, &mut tally).unwrap().unwrap();
            let whole = Motion::screw(around.tool(), around.start(), &screw).unwrap();
            let pieces = poses.len() - 1;
            // How far the middle of the cube is from the screw's.
            let off = (0..pieces).flat_map(|i| [0.25, 0.5].map(|t| (i, t))).map(|(i, t)| {
                let at = Motion::new(around.tool(), &poses[i], &poses[i + 1]).at(t);
                length(&sub(at.translation(), whole.at((i as f64 + t) / pieces as f64).translation()))
            });
            (pieces, off.fold(0.0, f64::max), tally.casts)
        };
        // A lever of 20 mm goes straight between the ends of its quarter of a turn.
        let (pieces, off, casts) = poses(0.02, 0.25, 0.0);
        assert!(pieces == 1 && off > 5e-3 && casts > 0, "{off}");
        // About its own axis poses are the same motion, and are not cast again.
        for turns in [0.25, 3.0] {
            let (pieces, off, casts) = poses(0.0, turns, 0.002);
            assert!(pieces as f64 == 4.0 * turns && off < 1e-12 && casts == 0, "{pieces} {off} {casts}");
        }
        // A thread that is a little off turns as exactly as it can be told, however free it would be with less.
        let (pieces, off, casts) = poses(1e-5, 3.0, 0.002);
        assert!(pieces > 12 && off <= SAME_PLACE_M && casts == 0, "{pieces} {off} {casts}");
    }
}
