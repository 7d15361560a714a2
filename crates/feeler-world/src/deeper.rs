//! Depth by points, where a cast does not tell it: how deep a pair is in each other, whatever the planes of its contacts.

use feeler_contacts::ContactSolver;
use feeler_core::{GoOn, Motion, Pose};

use crate::constants::{EROSION_SHARE, FIT_DEPTH, FLUSH_PLAY, SEAT_TOLERANCE, TOUCH};
use crate::error::Result;
use crate::seats::{SeatKind, Seated};
use crate::surroundings::Surroundings;

impl Surroundings {
    /// The parts of a body that are in the tool at the start, and how deep, metres.
    fn depths_at_start(&self, body: usize, go_on: GoOn<'_>) -> Result<&[(u32, f64)]> {
        if self.start_depths.get().is_none() {
            let mut all = Vec::with_capacity(self.makings.len());
            for makings in &self.makings {
                all.push(match &makings.neighbours {
                    Some(neighbours) => {
                        let solver = makings.solver.with_scene(std::sync::Arc::new(neighbours.clone()));
                        let found = solver.stoppable(go_on).depths(&self.tool, &self.start)?;
                        found.iter().map(|one| (one.part, one.depth)).collect()
                    }
                    None => Vec::new(),
                });
            }
            // Another thread may have been faster, with the same.
            let _ = self.start_depths.set(all);
        }
        Ok(self.start_depths.get().and_then(|all| all.get(body)).map_or(&[], Vec::as_slice))
    }

    /// How deep a part of a body may be, metres: its depth at the start, and the play of a touching part or the error of a fit.
    fn most_depth(&self, body: usize, part: u32, go_on: GoOn<'_>) -> Result<f64> {
        let known = self.depths_at_start(body, go_on)?.iter().find(|(own, _)| *own == part);
        let depth = known.map_or(0.0, |(_, depth)| *depth);
        Ok(if depth <= TOUCH { depth + FLUSH_PLAY } else { EROSION_SHARE * depth + SEAT_TOLERANCE })
    }

    /// The parts of a body that count as sunk because no smaller part is free of them, and are only as deep as a fit: how deep they may be.
    fn shallow(&self, body: usize, go_on: GoOn<'_>) -> Result<Vec<(u32, f64)>> {
        let mut shallow = Vec::new();
        for seat in self.makings[body].seats.iter().filter(|seat| seat.kind == SeatKind::Sunk) {
            let most = self.most_depth(body, seat.part, go_on)?;
            if most <= FIT_DEPTH * self.size_of_pair(body, [seat.tool_part, seat.part]) {
                shallow.push((seat.part, most));
            }
        }
        Ok(shallow)
    }

    /// Of these the deepest: they may go no deeper. `None` without any.
    pub(crate) fn excess_of_shallow(
        &self,
        body: usize,
        sunk: &ContactSolver,
        pose: &Pose,
        go_on: GoOn<'_>,
    ) -> Result<Option<Excess>> {
        let shallow = self.shallow(body, go_on)?;
        let least = shallow.iter().map(|(part, most)| Excess { part: *part, by: -most }).reduce(Excess::more);
        let Some(least) = least else { return Ok(None) };
        let found = sunk.stoppable(go_on).depths(&self.tool, pose)?;
        let bounded = found.iter().filter_map(|one| {
            let (part, most) = *shallow.iter().find(|(part, _)| *part == one.part)?;
            Some(Excess { part, by: one.depth - most })
        });
        Ok(Some(bounded.fold(least, Excess::more)))
    }

    /// The part that is deepest in the tool: none may be deeper than the overlap, and than it was at the start, if it was in it.
    pub(crate) fn excess_of_overlap(
        &self,
        body: usize,
        solver: &ContactSolver,
        pose: &Pose,
        go_on: GoOn<'_>,
    ) -> Result<Excess> {
        let overlap = self.overlap + SEAT_TOLERANCE;
        let mut deepest = Excess { part: 0, by: -overlap };
        for found in solver.stoppable(go_on).depths(&self.tool, pose)? {
            let most = if found.depth > overlap { self.most_depth(body, found.part, go_on)? } else { 0.0 };
            deepest = deepest.more(Excess { part: found.part, by: found.depth - most.max(overlap) });
        }
        Ok(deepest)
    }

    /// The first time between two of a motion after which it is not proven that no pair gets deeper than it may by more than
    /// [`SEAT_TOLERANCE`], and the part of the mock-up that is too deep there. `meets`: from when on an overlap is used.
    ///
    /// Conservative advancement: a depth changes by no more than the points move. It is at most half a step deeper than the mean of the
    /// depths at both ends of the step.
    pub(crate) fn unproven(
        &self,
        seated: &Seated,
        motion: &Motion,
        (meets, mut end): (Option<f64>, f64),
        go_on: GoOn<'_>,
    ) -> Result<Option<(f64, u32)>> {
        let mut first = None;
        for (number, asked) in seated.bodies.iter().enumerate() {
            let of_shallow = |pose: &Pose| match &asked.sunk {
                Some(sunk) => self.excess_of_shallow(number, sunk, pose, go_on),
                None => Ok(None),
            };
            let of_overlap = |pose: &Pose| self.excess_of_overlap(number, &asked.ordinary, pose, go_on).map(Some);
            let overlaps = match meets {
                _ if self.overlap == 0.0 => None,
                // Inside of a part it meets no surface.
                _ if of_overlap(&motion.at(0.0))?.is_some_and(|one| one.by > -self.overlap - SEAT_TOLERANCE) => {
                    Some(0.0)
                }
                meets => meets,
            };
            let kinds: [(&Measure<'_>, Option<f64>); 2] = [(&of_shallow, Some(0.0)), (&of_overlap, overlaps)];
            for (excess, from) in kinds {
                let Some(from) = from else { continue };
                if let Some((time, part)) = too_deep_between(motion, (from, end), excess)? {
                    (first, end) = (Some((time, self.environment.bodies[number].part_in_mockup(part))), time);
                }
            }
        }
        Ok(first)
    }
}

/// How deep parts are at a pose; `None` where nothing bounds it.
type Measure<'a> = dyn Fn(&Pose) -> Result<Option<Excess>> + 'a;

/// A part of a body, and its depth by points less the depth that is allowed, metres: negative where it may go deeper.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Excess {
    pub part: u32,
    pub by: f64,
}

impl Excess {
    fn more(self, other: Excess) -> Excess {
        if other.by > self.by {
            other
        } else {
            self
        }
    }
}

/// See [`Surroundings::unproven`].
fn too_deep_between(motion: &Motion, (from, to): (f64, f64), excess: &Measure<'_>) -> Result<Option<(f64, u32)>> {
    let (long, mut time) = (motion.longest_way(), from);
    let Some(mut at) = excess(&motion.at(from.min(to)))? else { return Ok(None) };
    while time < to {
        // No deeper than it may be at the end of it: then at most so much in between.
        let step = 2.0 * SEAT_TOLERANCE - at.by.min(0.0);
        let next = if long * (to - time) <= step { to } else { time + step / long };
        let Some(found) = excess(&motion.at(next))? else { break };
        if found.by > 0.0 {
            return Ok(Some((time, found.part)));
        }
        (time, at) = (next, found);
    }
    Ok(None)
}
