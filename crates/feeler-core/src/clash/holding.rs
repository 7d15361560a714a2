//! Parts that contain others without touching them: a connected surface that does not collide with a closed part lies
//! inside it or outside, and one of its corners decides. Through a gap of the part it may also be both.

use rayon::prelude::*;

use super::asked::{in_order, PairLimits};
use super::boxes::Boxes;
use super::location::{is_within, locate, Location, LocationScratch};
use super::solids::{connected_surfaces, Solids};
use crate::geometry::bounds::Aabb;
use crate::index::mockup_index::Index;
use crate::scratch_pool::ScratchPool;

/// One part, which is closed, holds another, or may do so.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Held {
    /// The one that is held.
    pub part: u32,
    /// The one that holds it.
    pub by: u32,
    /// Whether it may go through a gap in the surface of `by`, instead.
    pub is_through: bool,
}

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
                    let locations = locate((index, solids), &surface.corners[0], &around, scratch);
                    let inside = around.iter().zip(locations).filter(|(_, at)| *at == Location::Inside);
                    held.extend(inside.map(|(by, _)| Held { part, by: *by, is_through: false }));
                }
                let own = &mockup.part_bounds()[part as usize];
                let is_through =
                    |by: &u32| solids.fillings(*by).iter().any(|t| Aabb::of_triangle(t).is_overlapping(own));
                let through = around.into_iter().filter(is_through);
                held.extend(through.map(|by| Held { part, by, is_through: true }));
            });
            held
        })
        .collect();
    found.sort_unstable();
    found.dedup();
    found
}

/// Whether a box covers all of another.
fn is_covering(bounds: &Aabb, other: &Aabb) -> bool {
    is_within(bounds, &other.lower) && is_within(bounds, &other.upper)
}
