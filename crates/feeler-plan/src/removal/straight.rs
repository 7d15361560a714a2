//! Straight removal paths.

use feeler_core::{Leg, Point};

use super::directions::Wall;
use super::verify::{verified, HasTime, Verified};
use crate::blocked::Tally;
use crate::error::Result;
use feeler_world::{Surroundings, WalkOptions};

/// The first straight way out that is free, verified: along one of the caller's directions, or else along one of those
/// that contacts and shapes suggest and no contact plane opposes; the shorter first. What a plane opposes is left to the pushes: each is
/// a cast, which along surfaces takes long, and mostly it ends at once.
pub fn straight_way(
    surroundings: &Surroundings,
    (first, others, walls): (&[Point], &[Point], &[Wall]),
    has_time: HasTime<'_>,
    tally: &mut Tally,
) -> Result<Option<Verified>> {
    let (start, seated) = (*surroundings.start(), surroundings.seated_at_start());
    let mut try_all = |directions: &[Point], opposed_too: bool| -> Result<Option<Verified>> {
        let mut ways: Vec<(f64, &Point)> =
            directions.iter().map(|direction| (surroundings.way_out(&start, direction), direction)).collect();
        ways.retain(|(length, _)| length.is_finite());
        let opposed = |(length, direction): &(f64, &Point)| walls.iter().any(|wall| wall.opposes(direction, *length));
        ways.retain(|way| opposed_too || !opposed(way));
        ways.sort_by(|a, b| opposed(a).cmp(&opposed(b)).then(a.0.total_cmp(&b.0)));
        for (length, direction) in ways {
            if !has_time() {
                return Ok(None);
            }
            let end = surroundings.moved(&start, direction, length)?;
            // Where casts decide, one is enough.
            let mut is_free = || -> Result<bool> {
                let walk = surroundings.walk(&seated, (&start, &end), WalkOptions::search(&[], has_time))?;
                tally.walked(surroundings, &walk);
                Ok(walk.stop.is_none())
            };
            if surroundings.casts_decide() || is_free()? {
                if let Some(way) = verified(surroundings, vec![Leg::To(end)], has_time, tally)? {
                    return Ok(Some(way));
                }
            }
        }
        Ok(None)
    };
    if let Some(way) = try_all(first, true)? {
        return Ok(Some(way));
    }
    try_all(others, false)
}
