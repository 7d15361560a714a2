//! Which pairs have not parted yet, and the scenes that follow from it.

use std::sync::Arc;

use feeler_contacts::ContactSolver;
use feeler_core::{IgnoredPairs, Scene};

use super::seats::{Seat, SeatKind};

/// Pairs that are still together, and who is asked of what meanwhile.
#[derive(Debug)]
pub struct Seated {
    /// By seat: whether it has not parted.
    pub(super) holds: Vec<bool>,
    /// All pairs but those that touch or are in each other.
    pub(super) ordinary: Scene,
    /// All pairs but those that are seated in any way: these keep the clearance.
    pub(super) clear: Scene,
    /// Those that touch.
    pub(super) flush: Option<Scene>,
    /// Those that are in each other, and how many.
    pub(super) deep: Option<ContactSolver>,
    pub(super) deep_pairs: usize,
    /// Whether any of them has no hole.
    pub(super) has_sunk: bool,
    /// All that are seated.
    pub(super) all: Option<Scene>,
}

/// What the scenes are made of.
#[derive(Debug)]
pub struct Makings {
    pub solver: ContactSolver,
    pub tool_parts: u32,
    pub seats: Vec<Seat>,
    /// Parts that may be met all along.
    pub always: Vec<u32>,
    /// The neighbours alone; `None` without seats.
    pub neighbours: Option<Scene>,
}

impl Makings {
    pub fn seated(&self, holds: Vec<bool>) -> Seated {
        let scene = self.solver.scene();
        let parts = scene.mockup().part_bounds().len();
        let held = |is: &dyn Fn(SeatKind) -> bool| -> Vec<[u32; 2]> {
            let held = self.seats.iter().zip(&holds).filter(|(seat, holds)| **holds && is(seat.kind));
            held.map(|(seat, _)| [seat.tool_part, seat.part]).collect()
        };
        let always = || {
            let tools = 0..self.tool_parts;
            tools.flat_map(|t| self.always.iter().map(move |part| [t, *part]))
        };
        let without = |pairs: Vec<[u32; 2]>| {
            let ignored: Vec<[u32; 2]> = always().chain(pairs).collect();
            match ignored.is_empty() {
                true => scene.asking_all_pairs(),
                false => scene.ignoring(Arc::new(IgnoredPairs::new(self.tool_parts as usize, parts, ignored))),
            }
        };
        let alone = |pairs: Vec<[u32; 2]>| {
            let neighbours = self.neighbours.as_ref().filter(|_| !pairs.is_empty())?;
            // Sorted, as the seats are.
            let others = (0..self.tool_parts)
                .flat_map(|t| self.seats.iter().map(move |seat| [t, seat.part]))
                .filter(|pair| pairs.binary_search(pair).is_err());
            let ignored = IgnoredPairs::new(self.tool_parts as usize, parts, others);
            Some(neighbours.ignoring(Arc::new(ignored)))
        };
        let meets = |kind| kind != SeatKind::Near;
        Seated {
            ordinary: without(held(&meets)),
            clear: without(held(&|_| true)),
            flush: alone(held(&|kind| kind == SeatKind::Flush)),
            deep: alone(held(&SeatKind::is_deep)).map(|scene| self.solver.with_scene(Arc::new(scene))),
            deep_pairs: held(&SeatKind::is_deep).len(),
            has_sunk: !held(&|kind| kind == SeatKind::Sunk).is_empty(),
            all: alone(held(&|_| true)),
            holds,
        }
    }
}
