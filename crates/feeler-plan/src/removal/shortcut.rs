//! A way made shorter: legs that lead nowhere are left out.

use std::sync::Arc;

use feeler_core::{Motion, Pose};

use crate::blocked::Tally;
use crate::constants::{CUT_TRIES, LEAST_CUT};
use crate::error::Result;
use crate::random::Random;
use feeler_world::{Care, Seated, Surroundings};

/// The way with shortcuts: from each pose straight to the last that can be had, then between random places on it. What is seated at a
/// pose is found again as the way is walked, since a shortcut may part a pair elsewhere. The work is bounded, and no time is asked for.
pub fn shortened(around: &Surroundings, poses: Vec<Pose>, seed: u64, tally: &mut Tally) -> Result<Vec<Pose>> {
    let mut way = leapt(around, poses, tally)?;
    let mut random = Random::new(seed, u64::MAX);
    let mut tries = 0;
    while tries < CUT_TRIES && way.len() > 2 {
        tries += 1;
        let lengths: Vec<f64> =
            way.windows(2).map(|pair| Motion::new(around.tool(), &pair[0], &pair[1]).longest_way()).collect();
        let whole: f64 = lengths.iter().sum();
        let (mut a, mut b) = (random.between(0.0, whole), random.between(0.0, whole));
        if a > b {
            (a, b) = (b, a);
        }
        let Some((first, from)) = place(around, &way, &lengths, a) else { continue };
        let Some((last, to)) = place(around, &way, &lengths, b) else { continue };
        let saved = (b - a) - Motion::new(around.tool(), &from, &to).longest_way();
        if first == last || saved < LEAST_CUT * around.size() {
            continue;
        }
        let mut cut: Vec<Pose> = way[..=first].to_vec();
        cut.extend([from, to]);
        cut.extend_from_slice(&way[last + 1..]);
        if is_free(around, &cut, first, tally)? {
            way = cut;
        }
    }
    leapt(around, way, tally)
}

/// The leg and the pose at a length along a way.
fn place(around: &Surroundings, way: &[Pose], lengths: &[f64], at: f64) -> Option<(usize, Pose)> {
    let mut left = at;
    for (leg, length) in lengths.iter().enumerate() {
        if left < *length {
            return Some((leg, Motion::new(around.tool(), &way[leg], &way[leg + 1]).at(left / length)));
        }
        left -= length;
    }
    None
}

/// Whether a way is free from a leg on; before that it is known to be.
fn is_free(around: &Surroundings, way: &[Pose], from: usize, tally: &mut Tally) -> Result<bool> {
    let mut seated = around.seated_at_start();
    // Without seats nothing depends on what was before.
    let first = if around.has_seats() { 0 } else { from };
    for pair in way[first..].windows(2) {
        let walk = around.walk(&seated, (&pair[0], &pair[1]), Care::search(&[]))?;
        tally.walked(around, &walk);
        if walk.stop.is_some() {
            return Ok(false);
        }
        seated = walk.seated;
    }
    Ok(true)
}

/// From each pose on to the last one that a free motion leads to, by halves: first the end is tried, then what is half as far.
fn leapt(around: &Surroundings, way: Vec<Pose>, tally: &mut Tally) -> Result<Vec<Pose>> {
    let mut seated: Arc<Seated> = around.seated_at_start();
    let (mut at, mut leaps) = (0, vec![way[0]]);
    while at + 1 < way.len() {
        let mut to = way.len() - 1;
        loop {
            let walk = around.walk(&seated, (&way[at], &way[to]), Care::search(&[]))?;
            tally.walked(around, &walk);
            if walk.stop.is_none() {
                seated = walk.seated;
                break;
            }
            if to == at + 1 {
                // What is seated differs from when the leg was found: the rest stays as it is.
                leaps.extend_from_slice(&way[to..]);
                return Ok(leaps);
            }
            to = at + ((to - at) / 2).max(1);
        }
        at = to;
        leaps.push(way[at]);
    }
    Ok(leaps)
}
