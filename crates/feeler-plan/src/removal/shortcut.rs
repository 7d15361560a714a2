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
use feeler_world::{Surroundings, WalkOptions};

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
    // A leap may need a turn where the way around does not.
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
    let way = pulled_up(around, leapt(around, way, has_time, tally)?, has_time, tally)?;
    // It leads elsewhere now, with more room.
    unturned(around, way, has_time, tally)
}

/// The way without turns that are not needed: from the first place on from which it can be had without any more. The middle of the tool's
/// box goes the same way. Of poses alone: a screw was found because it is needed.
fn unturned(around: &Surroundings, way: Vec<Leg>, has_time: HasTime<'_>, tally: &mut Tally) -> Result<Vec<Leg>> {
    let motions = Motion::of_legs(around.tool(), around.start(), &way)?;
    if way.iter().any(|leg| matches!(leg, Leg::Screw(_) | Leg::Chain(_))) {
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
            let leg = if beyond == at + 1 { way[at].clone() } else { Leg::To(*motions[beyond - 1].end()) };
            let motion = Motion::of_legs(around.tool(), &here, std::slice::from_ref(&leg))?.remove(0);
            let walk = around.walk_along(&seated, &motion, WalkOptions::search(&[], has_time), &mut |_| ())?;
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

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use feeler_contacts::ContactSolver;
    use feeler_core::geometry::twist::rotation_of;
    use feeler_core::{Mockup, Point, Scene, SceneOptions, Tool};
    use feeler_shapes::{box_mesh, joined};
    use feeler_world::{Allowed, Body, Environment};

    use super::*;

    /// A bar of 20 mm along x, among posts along z of 2 mm.
    fn bar(posts: &[[f64; 2]]) -> Surroundings {
        let (vertices, faces) = box_mesh([0.0; 3], [0.02, 0.002, 0.004], 1);
        let posts = posts.iter().map(|[x, y]| box_mesh([*x, *y, 0.0], [0.002, 0.002, 0.02], 1));
        let (around, of) = joined(posts);
        let mockup = Mockup::new(around, of, vec![], 1).unwrap();
        let scene = Scene::build(Arc::new(mockup), &SceneOptions::default()).unwrap();
        let bodies = vec![Body { solver: ContactSolver::new(Arc::new(scene)), part: None }];
        let (tool, what) = (Arc::new(Tool::new(vertices, faces).unwrap()), (&Allowed::default(), 0.0));
        Surroundings::new(Environment { bodies }, tool, 1, &Pose::IDENTITY, what, &|| true).unwrap()
    }

    /// Turned about z, and moved.
    fn to(angle: f64, [x, y]: [f64; 2]) -> Leg {
        let at: Point = [x, y, 0.0];
        Leg::To(pose_of(&rotation_of(&[0.0, 0.0, angle]), &at).unwrap())
    }

    fn turn_of(around: &Surroundings, way: &[Leg]) -> f64 {
        let motions = Motion::of_legs(around.tool(), around.start(), way).unwrap();
        assert!(is_free(around, way, 0, &|| true, &mut Tally::default()).unwrap());
        motions.iter().map(Motion::angle).sum()
    }

    fn short(around: &Surroundings, way: Vec<Leg>) -> Vec<Leg> {
        assert!(turn_of(around, &way) > 0.2, "the way as it was found is free, and turns");
        shortened(around, way, 0, &|| true, &mut Tally::default()).unwrap()
    }

    #[test]
    fn a_turn_that_only_a_shortcut_needs_is_left_out() {
        // Between two posts the straight way is free for a bar that turns along it; around them it need not turn.
        let around = bar(&[[0.0246, 0.0154], [0.0154, 0.0246]]);
        let leap = [to(1.2, [0.04, 0.04])];
        assert!(turn_of(&around, &leap) > 0.7, "the leap is free, and turns");
        let way = short(&around, vec![to(0.0, [0.04, 0.0]), to(1.2, [0.04, 0.04])]);
        assert_eq!(turn_of(&around, &way), 0.0);
    }

    #[test]
    fn a_turn_that_only_a_detour_needs_is_left_out() {
        // At the end of the first leg an end of the bar has a post beside it, unless it is turned.
        let around = bar(&[[0.029, 0.0005]]);
        let way = short(&around, vec![to(-0.3, [0.02, 0.0]), to(-0.3, [0.02, -0.06])]);
        assert_eq!((turn_of(&around, &way), way.len()), (0.0, 1));
    }
}
