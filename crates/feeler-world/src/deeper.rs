//! Depth by points, where a cast does not tell it: how deep a pair is in each other, whatever the planes of its contacts.

use feeler_contacts::ContactSolver;
use feeler_core::{GoOn, Pose};

use crate::constants::{EROSION_SHARE, FIT_DEPTH, FLUSH_PLAY, SEAT_TOLERANCE, TOUCH};
use crate::error::Result;
use crate::seats::SeatKind;
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

    /// A part that counts as sunk because no smaller part is free of it, and is only as deep as a fit: it may go no deeper.
    pub(crate) fn deeper_than_at_start(
        &self,
        body: usize,
        sunk: &ContactSolver,
        pose: &Pose,
        go_on: GoOn<'_>,
    ) -> Result<Option<u32>> {
        let is_sunk = |seat: &&crate::seats::Seat| seat.kind == SeatKind::Sunk;
        let mut shallow = Vec::new();
        for seat in self.makings[body].seats.iter().filter(is_sunk) {
            let most = self.most_depth(body, seat.part, go_on)?;
            if most <= FIT_DEPTH * self.size {
                shallow.push((seat.part, most));
            }
        }
        if shallow.is_empty() {
            return Ok(None);
        }
        let found = sunk.stoppable(go_on).depths(&self.tool, pose)?;
        let is_deeper = |part: u32, depth: f64| shallow.iter().any(|(own, most)| *own == part && depth > *most);
        Ok(found.iter().find(|one| is_deeper(one.part, one.depth)).map(|one| one.part))
    }

    /// A part that is deeper in the tool than the overlap, and than it was at the start, if it was in it.
    pub(crate) fn deeper_than_the_overlap(
        &self,
        body: usize,
        solver: &ContactSolver,
        pose: &Pose,
        go_on: GoOn<'_>,
    ) -> Result<Option<u32>> {
        for found in solver.stoppable(go_on).depths(&self.tool, pose)? {
            if found.depth > self.overlap + SEAT_TOLERANCE && found.depth > self.most_depth(body, found.part, go_on)? {
                return Ok(Some(found.part));
            }
        }
        Ok(None)
    }
}
