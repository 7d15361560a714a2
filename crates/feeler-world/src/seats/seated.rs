//! The seats that have not separated yet, and the queries of each body that follow from them.

use std::sync::Arc;

use feeler_contacts::ContactSolver;
use feeler_core::{IgnoredPairs, Scene, Tool};

use super::beyond::Beyond;
use super::erosion::Eroded;
use super::find::{Regions, Seat, SeatKind};

/// The seats that have not parted yet, with the queries that follow.
#[derive(Debug)]
pub struct Seated {
    /// By seat, those of one body after the other: whether it has not parted.
    pub(crate) holds: Vec<bool>,
    /// By body.
    pub(crate) bodies: Vec<SeatedBody>,
}

impl Seated {
    /// Of the seats of its surroundings, in order, those that have not parted.
    pub fn of(&self, seats: impl Iterator<Item = Seat>) -> Vec<Seat> {
        seats.zip(&self.holds).filter(|(_, holds)| **holds).map(|(seat, _)| seat).collect()
    }

    /// Whether all have parted, or there were none.
    pub fn is_free(&self) -> bool {
        !self.holds.contains(&true)
    }
}

/// The queries of one body.
#[derive(Debug)]
pub struct SeatedBody {
    /// All but the surfaces that may collide.
    pub ordinary: ContactSolver,
    /// All pairs but those that are seated in any way: these keep the clearance.
    pub clear: Scene,
    /// All pairs except colliding seats: the least distance is over these.
    pub apart: Scene,
    /// Parts that touch or fit, with their neighbours; and parts that are sunk, with what lies beyond their place.
    pub smaller: Vec<SmallerPart>,
    /// Pairs that are sunk.
    pub sunk: Option<ContactSolver>,
    /// All pairs that are seated.
    pub all: Option<Scene>,
}

/// A part of the tool, smaller by its depth in a neighbour; a sunk part, by a play.
#[derive(Debug)]
pub struct SmallerPart {
    /// Which of the body's seats.
    pub seat: u32,
    /// Of it alone.
    pub tool: Arc<Tool>,
    /// Of the neighbour alone; for a sunk part, of its surface beyond the place.
    pub solver: ContactSolver,
}

/// The data of one body.
#[derive(Debug)]
pub struct Makings {
    pub solver: ContactSolver,
    pub tool_parts: u32,
    pub seats: Vec<Seat>,
    /// By seat.
    pub eroded: Vec<Option<Eroded>>,
    /// By seat: what a sunk part may not meet.
    pub beyond: Vec<Option<Beyond>>,
    pub regions: Option<Regions>,
    /// Parts that may be met all along.
    pub always: Vec<u32>,
    /// The neighbours alone; `None` without seats.
    pub neighbours: Option<Scene>,
}

impl Makings {
    pub fn seated(&self, holds: &[bool]) -> SeatedBody {
        let scene = self.solver.scene();
        let solver = |scene: Scene| self.solver.with_scene(Arc::new(scene));
        let meeting = self.held(holds, SeatKind::meets);
        let held = (0..).zip(&self.seats).zip(holds).filter(|(_, holds)| **holds);
        let smaller = held.filter_map(|((number, seat), _)| {
            let at = number as usize;
            if let Some(beyond) = self.beyond.get(at).and_then(Option::as_ref) {
                let solver = self.solver.with_scene(beyond.scene.clone());
                return Some(SmallerPart { seat: number, tool: beyond.tool.clone(), solver });
            }
            let tool = self.eroded[at].as_ref()?.tool.clone();
            Some(SmallerPart { seat: number, tool, solver: solver(scene.of_one_part(seat.part)) })
        });
        SeatedBody {
            smaller: smaller.collect(),
            ordinary: solver(self.without(&[], &meeting)),
            clear: self.without(&self.held(holds, |_| true), &[]),
            apart: self.without(&meeting, &[]),
            sunk: self.alone(&self.held(holds, |kind| kind == SeatKind::Sunk)).map(solver),
            all: self.alone(&self.held(holds, |_| true)),
        }
    }

    /// The pairs that hold, of some kinds; sorted, as the seats are.
    fn held(&self, holds: &[bool], is: impl Fn(SeatKind) -> bool) -> Vec<[u32; 2]> {
        let held = self.seats.iter().zip(holds).filter(|(seat, holds)| **holds && is(seat.kind));
        held.map(|(seat, _)| [seat.tool_part, seat.part]).collect()
    }

    /// All but some pairs of parts, and of others the surfaces that may meet; these sorted.
    fn without(&self, pairs: &[[u32; 2]], seated: &[[u32; 2]]) -> Scene {
        let scene = self.solver.scene();
        let regions = self.regions.as_ref().filter(|_| !seated.is_empty());
        if pairs.is_empty() && self.always.is_empty() && regions.is_none() {
            return scene.asking_all_pairs();
        }
        let always = (0..self.tool_parts).flat_map(|t| self.always.iter().map(move |part| [t, *part]));
        let ignored = always.chain(pairs.iter().copied());
        let mut all = IgnoredPairs::new(self.tool_parts as usize, scene.mockup().part_bounds().len(), ignored);
        if let Some(regions) = regions {
            all = all.with_surfaces(regions.numbers(), regions.pairs(seated));
        }
        scene.ignoring(Arc::new(all))
    }

    /// Some pairs alone, sorted.
    fn alone(&self, pairs: &[[u32; 2]]) -> Option<Scene> {
        let neighbours = self.neighbours.as_ref().filter(|_| !pairs.is_empty())?;
        let others = (0..self.tool_parts)
            .flat_map(|t| self.seats.iter().map(move |seat| [t, seat.part]))
            .filter(|pair| pairs.binary_search(pair).is_err());
        let parts = neighbours.mockup().part_bounds().len();
        Some(neighbours.ignoring(Arc::new(IgnoredPairs::new(self.tool_parts as usize, parts, others))))
    }
}
