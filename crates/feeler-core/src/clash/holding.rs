//! Parts that contain others without touching them: a connected surface that does not collide with a closed part lies
//! inside it or outside, and one of its corners decides, or several if the closed part has gaps. Through a gap it may
//! also be both.

use rayon::prelude::*;

use super::asked::{in_order, PairLimits};
use super::boxes::Boxes;
use super::location::{is_within, locate, Location, LocationScratch};
use super::solids::{connected_surfaces, ConnectedSurface, Solids};
use crate::geometry::bounds::Aabb;
use crate::index::mockup_index::Index;
use crate::scratch_pool::ScratchPool;

/// One part, which is closed, holds another.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Held {
    /// The one that is held.
    pub part: u32,
    /// The one that holds it.
    pub by: u32,
    /// Whether some of it may be outside, through a gap: points on the surface of `by` do not decide, then.
    pub is_through: bool,
}

/// Corners of a part that are looked at, if it may go through a gap of another.
const CORNERS_IN_GAPS: usize = 32;

/// Every pair of parts to check that does not collide (colliding ones are in `meeting`, sorted, the lesser part first)
/// and of which one contains a connected surface of the other; in order. In parallel on the current rayon pool.
pub fn held_parts(index: &Index, solids: &Solids<'_>, limits: &PairLimits, meeting: &[[u32; 2]]) -> Vec<Held> {
    let (mockup, selection) = (index.mockup(), index.selection());
    let there: Vec<u32> = (0..mockup.part_bounds().len() as u32)
        .filter(|part| selection.has_part(*part) && !mockup.part_bounds()[*part as usize].is_empty())
        .collect();
    let boxes = Boxes::new(there.iter().map(|part| mockup.part_bounds()[*part as usize]).collect());
    let pool: ScratchPool<LocationScratch> = ScratchPool::default();
    let mut found: Vec<Held> = there
        .par_iter()
        .flat_map_iter(|&part| {
            let around = boxes.around(&mockup.part_bounds()[part as usize]);
            let mut around: Vec<u32> = around.into_iter().map(|i| there[i as usize]).collect();
            around.retain(|by| {
                *by != part
                    && limits.clearance(part, *by).is_some()
                    && meeting.binary_search(&in_order([part, *by])).is_err()
            });
            if around.is_empty() {
                return Vec::new();
            }
            let mut held = Vec::new();
            pool.with(|scratch| {
                for surface in connected_surfaces(mockup.mesh(), solids.faces(part)) {
                    let may_hold = |by: &u32| is_covering(&mockup.part_bounds()[*by as usize], &surface.bounds);
                    let around: Vec<u32> = around.iter().copied().filter(may_hold).collect();
                    if around.is_empty() {
                        continue;
                    }
                    let inside = parts_around((index, solids), &surface, &around, scratch);
                    held.extend(inside.into_iter().map(|by| Held { part, by, is_through: false }));
                }
                around.retain(|by| {
                    !held.iter().any(|held| held.by == *by) && !solids.is_cycle(*by) && {
                        let solid = solids.of(*by);
                        solid.is_closed() && solid.is_loose()
                    }
                });
                let through = parts_with_gaps_around((index, solids), part, &around, scratch);
                held.extend(through.into_iter().map(|by| Held { part, by, is_through: true }));
            });
            held
        })
        .collect();
    found.sort_unstable();
    found.dedup();
    found
}

/// Those of some parts (ascending) that a connected surface is inside of. One corner decides, or most of several if the surface of a part
/// may have gaps: rays can go through these, and a corner near them may be on either side.
fn parts_around(
    (index, solids): (&Index, &Solids<'_>),
    surface: &ConnectedSurface,
    parts: &[u32],
    scratch: &mut LocationScratch,
) -> Vec<u32> {
    let is_inside = |location: &Location| *location == Location::Inside;
    let first = locate((index, solids), &surface.corners[0], parts, scratch);
    let (mut found, mut loose) = (Vec::new(), Vec::new());
    for (part, location) in parts.iter().zip(&first) {
        if !solids.is_cycle(*part) && solids.of(*part).is_loose() {
            loose.push(*part);
        } else if is_inside(location) {
            found.push(*part);
        }
    }
    if !loose.is_empty() {
        let mut votes = vec![0i32; loose.len()];
        for corner in &surface.corners {
            for (vote, location) in votes.iter_mut().zip(locate((index, solids), corner, &loose, scratch)) {
                *vote += match location {
                    Location::Inside => 1,
                    Location::Outside => -1,
                    Location::On => 0,
                };
            }
        }
        found.extend(loose.iter().zip(votes).filter(|(_, vote)| *vote > 0).map(|(part, _)| *part));
    }
    found
}

/// Those of some parts with gaps (ascending) that have some corners of a part inside.
fn parts_with_gaps_around(
    (index, solids): (&Index, &Solids<'_>),
    part: u32,
    parts: &[u32],
    scratch: &mut LocationScratch,
) -> Vec<u32> {
    let (faces, mesh) = (solids.faces(part), index.mockup().mesh());
    let mut left = parts.to_vec();
    let mut found = Vec::new();
    for face in faces.iter().step_by(faces.len().div_ceil(CORNERS_IN_GAPS).max(1)) {
        if left.is_empty() {
            break;
        }
        let locations = locate((index, solids), &mesh.triangle(*face)[0], &left, scratch);
        let inside = left.iter().zip(&locations).filter(|(_, at)| **at == Location::Inside).map(|(by, _)| *by);
        let inside: Vec<u32> = inside.collect();
        left.retain(|by| !inside.contains(by));
        found.extend(inside);
    }
    found
}

/// Whether a box covers all of another.
fn is_covering(bounds: &Aabb, other: &Aabb) -> bool {
    is_within(bounds, &other.lower) && is_within(bounds, &other.upper)
}
