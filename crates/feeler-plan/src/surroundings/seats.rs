//! Pairs that may meet: those that do where the part is, and those that are named.
//!
//! Parts of an assembly touch, and in models of one many are in each other. A pair that meets at the start may meet until it parts. One
//! that touches is followed by casts that may slide. Of one that is in each other the depth is a measure, that of contact planes, and is
//! taken at steps: a fit may be as deep as at the start. What is deeper has no hole in the model: bolts in plates. The least depth is then
//! the way through, or the way back, and says nothing; so the part may not move against a plane that it is behind, and the surfaces
//! cross nowhere but in the place that the part has at the start.

use std::collections::BTreeMap;
use std::sync::Arc;

use feeler_contacts::ContactSolver;
use feeler_core::geometry::vectors::{length, scaled};
use feeler_core::{IgnoredPairs, Pose, Scene, Tool};

use crate::constants::{BESIDE, BESIDE_SHARE, FIT_DEPTH, MOST_BESIDE, TOUCH};
use crate::error::{Error, Result};

/// What may meet.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Allowed {
    /// Pairs that meet at the start may, until they part, no deeper than then.
    pub start: bool,
    /// Every pair may be this deep in each other, metres.
    pub overlap: f64,
    /// Parts of the mock-up that may be met all along.
    pub parts: Vec<u32>,
}

/// How a pair is at the start.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SeatKind {
    /// Apart, but nearer than the clearance.
    Near,
    /// It touches.
    Flush,
    /// One is a little in the other.
    Fit,
    /// One is in the other, as if there were no hole.
    Sunk,
}

impl SeatKind {
    /// Whether one is in the other.
    pub fn is_deep(self) -> bool {
        matches!(self, SeatKind::Fit | SeatKind::Sunk)
    }
}

/// A part of the tool and one of the mock-up that are together at the start.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Seat {
    /// Of the tool.
    pub tool_part: u32,
    /// Of the mock-up.
    pub part: u32,
    /// How it is at the start.
    pub kind: SeatKind,
    /// How deep it may be, metres.
    pub depth: f64,
}

/// The pairs that are together at the start, sorted; and those that meet there though nothing allows it.
#[derive(Debug, Clone, Default)]
pub struct Start {
    pub seats: Vec<Seat>,
    pub refused: Vec<[u32; 2]>,
}

/// Finds them. `scene` asks of nothing that is allowed all along; tool parts from `own_parts` on are what grips, and have no seats.
pub fn find_seats(
    (solver, scene): (&ContactSolver, &Scene),
    tool: &Tool,
    own_parts: u32,
    start: &Pose,
    allowed: &Allowed,
    clearance: f64,
) -> Result<Start> {
    let mut nearest: BTreeMap<[u32; 2], f64> = BTreeMap::new();
    for gap in scene.near_pairs(tool, start, TOUCH.max(clearance))? {
        let least = nearest.entry([gap.tool_part, gap.part]).or_insert(gap.distance);
        *least = least.min(gap.distance);
    }
    if nearest.is_empty() {
        return Ok(Start::default());
    }
    let meets = nearest.values().any(|distance| *distance <= TOUCH);
    let mut depths = if meets { depths_at(solver, tool, start)? } else { BTreeMap::new() };
    if tool.parts() > 1 {
        // Planes of one pair may stand for those of others: each is measured alone, too.
        for pair in nearest.iter().filter(|(_, distance)| **distance <= TOUCH).map(|(pair, _)| *pair) {
            let alone = alone(scene, tool, pair);
            if alone.is_entering(tool, start) {
                let own = depths_at(&solver.with_scene(Arc::new(alone)), tool, start)?;
                let depth = own.get(&pair).copied().unwrap_or(0.0);
                depths.entry(pair).and_modify(|known| *known = known.max(depth)).or_insert(depth);
            }
        }
    }
    let size = length(&tool.mesh().bounds().extent());
    // Where edges lie in faces, contacts may miss that one is in the other: a little beside they do not.
    let is_flush = |pair: &[u32; 2]| nearest[pair] <= TOUCH && depths.get(pair).is_none_or(|depth| *depth <= TOUCH);
    if nearest.keys().any(is_flush) {
        let mut beside: BTreeMap<[u32; 2], f64> = BTreeMap::new();
        for sign in [1.0, -1.0] {
            let by = scaled(&BESIDE, sign * BESIDE_SHARE * size);
            for (pair, depth) in depths_at(solver, tool, &start.translated(&by)?)? {
                let least = beside.entry(pair).or_insert(f64::INFINITY);
                *least = least.min(depth);
            }
        }
        for (pair, depth) in beside {
            if nearest.contains_key(&pair) && depth > MOST_BESIDE * BESIDE_SHARE * size {
                let known = depths.entry(pair).or_insert(depth);
                *known = known.max(depth);
            }
        }
    }
    let mut found = Start::default();
    for (pair, distance) in nearest {
        let [tool_part, part] = pair;
        let meets = distance <= TOUCH;
        let depth = depths.get(&pair).copied().unwrap_or(0.0);
        let kind = match depth {
            _ if !meets => SeatKind::Near,
            depth if depth <= TOUCH => SeatKind::Flush,
            depth if depth <= FIT_DEPTH * size => SeatKind::Fit,
            _ => SeatKind::Sunk,
        };
        if meets && tool_part >= own_parts {
            return Err(Error::StartsInCollision { tool_part, part });
        }
        if !meets || allowed.start {
            found.seats.push(Seat { tool_part, part, kind, depth: depth.max(allowed.overlap) });
        } else if allowed.overlap == 0.0 || depth > allowed.overlap {
            found.refused.push(pair);
        }
    }
    Ok(found)
}

/// How deep each pair is at a pose, metres.
fn depths_at(solver: &ContactSolver, tool: &Tool, pose: &Pose) -> Result<BTreeMap<[u32; 2], f64>> {
    let mut depths: BTreeMap<[u32; 2], f64> = BTreeMap::new();
    for plane in solver.contacts(tool, pose, 0.0, None)?.planes {
        let depth = depths.entry([plane.tool_part(tool), plane.part]).or_insert(0.0);
        *depth = depth.max(-plane.gap);
    }
    Ok(depths)
}

/// The scene of one pair.
fn alone(scene: &Scene, tool: &Tool, [tool_part, part]: [u32; 2]) -> Scene {
    let others = (0..tool.parts() as u32).filter(|other| *other != tool_part).map(|other| [other, part]);
    let parts = scene.mockup().part_bounds().len();
    scene.of_one_part(part).ignoring(Arc::new(IgnoredPairs::new(tool.parts(), parts, others)))
}
