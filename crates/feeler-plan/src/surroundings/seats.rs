//! Pairs that may meet: those that do where the part is, and those that are named.
//!
//! Parts of an assembly touch, and in models of one many are in each other. A pair that meets at the start may meet until it parts, and
//! never deeper than then. A pair that only touches is followed by casts that may slide; of one that is in each other the depth is a
//! measure, that of contact planes, and is taken at steps.

use std::collections::BTreeMap;
use std::sync::Arc;

use feeler_contacts::ContactSolver;
use feeler_core::{IgnoredPairs, Pose, Scene, Tool};

use crate::constants::TOUCH;
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
    /// One is in the other.
    Deep,
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
    let mut depths: BTreeMap<[u32; 2], f64> = BTreeMap::new();
    if nearest.values().any(|distance| *distance <= TOUCH) {
        depths = depths_of(solver, tool, start)?;
    }
    let mut found = Start::default();
    for (pair, distance) in nearest {
        let [tool_part, part] = pair;
        let meets = distance <= TOUCH;
        if meets && tool_part >= own_parts {
            return Err(Error::StartsInCollision { tool_part, part });
        }
        let mut depth = depths.get(&pair).copied().unwrap_or(0.0);
        let mut kind = if meets { SeatKind::Flush } else { SeatKind::Near };
        if meets {
            // Planes of one pair may stand for those of others: a pair of several is measured alone, too.
            let alone = || alone(scene, tool, pair);
            if depth > TOUCH || alone().is_entering(tool, start) {
                kind = SeatKind::Deep;
                if tool.parts() > 1 || depth <= TOUCH {
                    let solver = solver.with_scene(Arc::new(alone()));
                    depth = depths_of(&solver, tool, start)?.get(&pair).copied().unwrap_or(0.0).max(depth);
                }
            }
        }
        if !meets || allowed.start {
            found.seats.push(Seat { tool_part, part, kind, depth: depth.max(allowed.overlap) });
        } else if allowed.overlap == 0.0 || depth > allowed.overlap {
            found.refused.push(pair);
        }
    }
    Ok(found)
}

/// The deepest contact gap of each pair, metres.
fn depths_of(solver: &ContactSolver, tool: &Tool, pose: &Pose) -> Result<BTreeMap<[u32; 2], f64>> {
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
