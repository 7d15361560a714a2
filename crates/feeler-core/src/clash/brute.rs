//! The plain twins of the searches: every pair of triangles of every pair of parts.

use std::collections::BTreeMap;

use super::asked::{in_order, PairLimits};
use super::meets::{MeetingParts, Meets};
use super::near::PartGap;
use crate::geometry::distance_triangle_triangle::closest_triangle_triangle;
use crate::geometry::intersect_triangle_triangle::{intersect_triangle_triangle, PairKind};
use crate::mesh::mockup::Mockup;

/// See [`meeting_parts`](super::meeting::meeting_parts).
pub fn meeting_of_all_pairs(mockup: &Mockup, limits: &PairLimits) -> Vec<MeetingParts> {
    let mesh = mockup.mesh();
    let mut met: BTreeMap<[u32; 2], Meets> = BTreeMap::new();
    for t in mesh.queried() {
        for u in mesh.queried().skip_while(|u| *u <= t) {
            let parts = in_order([t, u].map(|face| mockup.part_of_face(face)));
            if limits.clearance(parts[0], parts[1]).is_none() {
                continue;
            }
            let how = match intersect_triangle_triangle(&mesh.triangle(t), &mesh.triangle(u)) {
                Some(PairKind::Crossing) => Meets::Crossing,
                Some(_) => Meets::Touching,
                None => continue,
            };
            met.entry(parts).and_modify(|meets| *meets = how.max(*meets)).or_insert(how);
        }
    }
    met.into_iter().map(|(parts, meets)| MeetingParts { parts, meets }).collect()
}

/// See [`near_parts`](super::near::near_parts): without colliding pairs.
pub fn gaps_of_all_parts(mockup: &Mockup, limits: &PairLimits) -> Vec<PartGap> {
    let mesh = mockup.mesh();
    let mut nearest: BTreeMap<[u32; 2], PartGap> = BTreeMap::new();
    for t in mesh.queried() {
        for u in mesh.queried().skip_while(|u| *u <= t) {
            let [a, b] = [t, u].map(|face| mockup.part_of_face(face));
            let (parts, triangles) = if a < b { ([a, b], [t, u]) } else { ([b, a], [u, t]) };
            let Some(reach) = limits.reach(parts[0], parts[1]) else { continue };
            let [p, q] = triangles.map(|face| mesh.triangle(face));
            let closest = closest_triangle_triangle(&p, &q);
            let gap = PartGap { parts, triangles, distance: closest.distance, points: [closest.on_p, closest.on_q] };
            let is_nearer = nearest.get(&parts).is_none_or(|best| gap.order(best).is_lt());
            if closest.distance <= reach && is_nearer {
                nearest.insert(parts, gap);
            }
        }
    }
    nearest.into_values().filter(|gap| gap.distance > 0.0).collect()
}
