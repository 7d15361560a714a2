//! Sorts the pairs that meet into contact regions: segments, contours, what they enclose.

use feeler_core::constants::WELD_SHARE;
use feeler_core::geometry::triangle_normals::{eight_normals, is_thin};
use feeler_core::geometry::vectors::{dot, normal, scaled, sub};
use feeler_core::mesh::topology::adjacency::NONE;
use feeler_core::mesh::topology::disjoint_sets::DisjointSets;
use feeler_core::Point;
use feeler_lanes::WIDE_LANES;

use crate::containers::counting_sort::lay_out;
use crate::context::{Ground, MOCKUP, TOOL};
use crate::contour::connect::{join_across_faces, join_along_the_curve};
use crate::contour::contact_region::{Cut, Face, Zone, Zones};
use crate::contour::flood_fill::{walk, Walked};
use crate::contour::segments::find_points;
use crate::contour::vertex_side::{classify, Judged, Stand};

impl Zones {
    /// Finds the normals of the faces, and which cuts are flat.
    fn find_normals(&mut self, ground: &Ground<'_>) {
        for w in [TOOL, MOCKUP] {
            for faces in self.faces[w].chunks_mut(WIDE_LANES) {
                let (normals, mut thin) =
                    eight_normals(ground.lanes, faces.len(), self.thin[w], |i| faces[i].corners.each_ref());
                for (face, n) in faces.iter_mut().zip(normals) {
                    face.normal = n.map_or([0.0; 3], |n| scaled(&n, ground.sense(w, face.id)));
                }
                while thin != 0 {
                    let face = &mut faces[thin.trailing_zeros() as usize];
                    face.normal = normal_beside(ground, w, face.id, self.thin[w]).unwrap_or(face.normal);
                    thin &= thin - 1;
                }
            }
        }
        for cut in &mut self.cuts {
            let [p, q] = [TOOL, MOCKUP].map(|w| &self.faces[w][cut.faces[w] as usize].normal);
            cut.flat = dot(p, q).abs() > 1.0 - 1e-12;
        }
    }

    /// Puts what belongs to each zone together, in its order: the cuts, by their sets, and what was walked over.
    fn sort_by_zone(&mut self, roots: &mut DisjointSets, zone_of_root: &mut Vec<u32>, walked: &[Walked; 2]) {
        let Zones { zones, zone_cuts, zone_inside, zone_of_cut, place_of_cut, by_face, .. } = self;
        let count = roots.0.len();
        zone_of_root.clear();
        zone_of_root.resize(count, NONE);
        for i in 0..count as u32 {
            let zone = &mut zone_of_root[roots.of(i) as usize];
            if *zone == NONE {
                *zone = zones.len() as u32;
                zones.push(Zone::default());
            }
            let end = &mut zones[*zone as usize].cuts.1;
            zone_of_cut.push(*zone);
            place_of_cut.push(*end);
            *end += 1;
        }
        lay_out(zones.iter_mut().map(|zone| &mut zone.cuts));
        zone_cuts.iter_mut().for_each(|cuts| cuts.resize(count, 0));
        for (i, (zone, place)) in (0..).zip(zone_of_cut.iter().zip(place_of_cut.iter())) {
            zone_cuts[TOOL][(zones[*zone as usize].cuts.0 + place) as usize] = i;
        }
        for i in by_face[MOCKUP].iter() {
            let end = &mut zones[zone_of_cut[*i as usize] as usize].cuts.1;
            zone_cuts[MOCKUP][*end as usize] = *i;
            *end += 1;
        }
        for (w, Walked { found: walked, .. }) in walked.iter().enumerate() {
            let zone_of = |cut: u32| zone_of_cut[cut as usize] as usize;
            walked.iter().for_each(|(_, cut)| zones[zone_of(*cut)].inside[w].1 += 1);
            lay_out(zones.iter_mut().map(|zone| &mut zone.inside[w]));
            zone_inside[w].resize(walked.len(), [0; 2]);
            for (triangle, cut) in walked {
                let end = &mut zones[zone_of(*cut)].inside[w].1;
                zone_inside[w][*end as usize] = [*triangle, *cut];
                *end += 1;
            }
        }
    }
}

/// Working memory of [`find`].
#[derive(Debug, Default)]
pub(crate) struct ZonesScratch {
    walked: [Walked; 2],
    zone_of_root: Vec<u32>,
    stands: Vec<Stand>,
    judged: Vec<Judged>,
    zones: Zones,
}

/// Sorts the pairs of one part (sorted by tool triangle, then mock-up triangle) into zones, the tool on the side that the surfaces
/// say or a `way` does.
pub(crate) fn find<'a>(
    ground: &Ground<'_>,
    pairs: &[[u32; 2]],
    way: Option<Point>,
    scratch: &'a mut ZonesScratch,
) -> &'a Zones {
    let ZonesScratch { walked, zone_of_root, stands, judged, zones } = scratch;
    zones.clear();
    let mut places = std::mem::take(&mut zones.places);
    places.clear(ground);
    zones.way = way;
    let part = pairs.first().map_or(0, |p| ground.mockup.part_of_face(p[1]));
    for pair in pairs {
        let faces = [TOOL, MOCKUP].map(|w| {
            let (place, is_new) = places.number(w, pair[w]);
            if is_new {
                let closed = ground.adjacency[w].outward[pair[w] as usize] != 0;
                zones.faces[w].push(Face::new(pair[w], ground.triangle(w, pair[w]), closed));
            }
            place
        });
        zones.cuts.push(Cut { faces, points: (0, 0), flat: false });
    }
    zones.thin =
        [ground.tool.mesh().bounds(), ground.mockup.part_bounds()[part as usize]].map(|b| WELD_SHARE * b.longest());
    zones.find_normals(ground);
    find_points(ground.lanes, &zones.faces, &mut zones.cuts, &mut zones.points);
    let mut roots = DisjointSets((0..zones.cuts.len() as u32).collect());
    zones.sort_by_face();
    join_along_the_curve(ground, zones, &mut roots);
    orient(ground, zones);
    classify(ground, part, zones, stands, judged);
    for w in [TOOL, MOCKUP] {
        join_across_faces(w, zones, &mut roots);
    }
    for w in [TOOL, MOCKUP] {
        walk(ground, w, part, zones, &mut places, &mut roots, &mut walked[w]);
    }
    zones.places = places;
    zones.complete = walked.iter().all(|walked| walked.complete);
    zones.sort_by_zone(&mut roots, zone_of_root, walked);
    zones
}

/// Most triangles among which [`normal_beside`] looks for one that is not thin.
const MOST_BESIDE: usize = 16;

/// The normal of the nearest triangle over long edges that is not thin: what a thin one is a part of.
fn normal_beside(ground: &Ground<'_>, w: usize, id: u32, thin: f64) -> Option<Point> {
    let mut seen = vec![id];
    let mut next = 0;
    while next < seen.len() {
        let t = ground.triangle(w, seen[next]);
        let edge = |k: usize| sub(&t[(k + 1) % 3], &t[k]);
        let mut sides =
            [0, 1, 2].map(|k| (dot(&edge(k), &edge(k)), ground.adjacency[w].neighbours[seen[next] as usize][k]));
        sides.sort_by(|p, q| q.0.total_cmp(&p.0));
        for (_, n) in sides.into_iter().filter(|(_, n)| *n != NONE) {
            let beside = ground.triangle(w, n);
            if !is_thin(&beside, thin) {
                return normal(&beside).map(|normal| scaled(&normal, ground.sense(w, n)));
            }
            if !seen.contains(&n) && seen.len() < MOST_BESIDE {
                seen.push(n);
            }
        }
        next += 1;
    }
    None
}

/// Turns the normals of open surfaces to the side that counts as outside, and those of thin closed ones that the tool went
/// right through since the reference.
fn orient(ground: &Ground<'_>, zones: &mut Zones) {
    // How far each face's part of the curve has come from where the tool was free, along its normal.
    let mut back: [Vec<(f64, f64)>; 2] = Default::default();
    if ground.reference.is_some() {
        back = [TOOL, MOCKUP].map(|w| vec![(0.0, 0.0); zones.faces[w].len()]);
        for cut in &zones.cuts {
            let middle = zones.points[cut.points.0 as usize];
            let Some(way) = ground.way_back(&middle) else { continue };
            for w in [TOOL, MOCKUP] {
                let (sum, length) = &mut back[w][cut.faces[w] as usize];
                // Seen from the tool it is the mock-up that came.
                let sense = if w == MOCKUP { 1.0 } else { -1.0 };
                *sum += sense * dot(&way, &zones.faces[w][cut.faces[w] as usize].normal);
                *length += dot(&way, &way).sqrt();
            }
        }
    }
    for w in [TOOL, MOCKUP] {
        for (i, face) in zones.faces[w].iter_mut().enumerate() {
            let (sum, length) = back[w].get(i).copied().unwrap_or_default();
            let flip = if face.closed {
                // It came out of the solid, and yet was free before: it went in on the other side.
                w == MOCKUP && sum < -0.5 * length
            } else if sum.abs() > 1e-3 * length {
                sum < 0.0
            } else {
                // The mock-up's surface faces the tool's bulk, and the tool's faces away from it.
                let towards = sub(&ground.centre, &face.corners[0]);
                (dot(&towards, &face.normal) < 0.0) == (w == MOCKUP)
            };
            if flip {
                face.normal = scaled(&face.normal, -1.0);
                face.closed = false;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contour::contact_region::Places;
    use crate::tests::{at, scene, tool};
    use feeler_shapes::{box_mesh, ridge};

    #[test]
    fn a_walk_on_the_wrong_side_of_the_curve_is_dropped() {
        // A block between the legs of a frame and a little in one of them: all of it is in the frame's box.
        let line = [[-0.03, 0.0], [-0.02, 0.0], [-0.02 + 1e-9, 0.03], [0.02 - 1e-9, 0.03], [0.02, 0.0], [0.03, 0.0]];
        let block = scene(box_mesh([0.0, 0.0, 0.015], [0.01, 0.012, 0.014], 6));
        let frame = tool(ridge(&line, 0.04, 0.02, 3, 5));
        let pose = at(0.0155, 0.0, 0.0);
        let pairs = block.collide(&frame, &pose).pairs;
        let ground = Ground::new(&block, &frame, &pose, None);
        let mut scratch = ZonesScratch::default();
        find(&ground, &pairs, None, &mut scratch);
        let zones = &mut scratch.zones;
        let found = |zones: &Zones| {
            let mut roots = DisjointSets((0..zones.cuts.len() as u32).collect());
            let mut places = Places::default();
            places.clear(&ground);
            zones.faces[MOCKUP].iter().for_each(|face| _ = places.number(MOCKUP, face.id));
            let mut walked = Walked::default();
            walk(&ground, MOCKUP, 0, zones, &mut places, &mut roots, &mut walked);
            let mut ids: Vec<u32> = walked.found.iter().map(|f| f.0).collect();
            ids.sort_unstable();
            ids
        };
        let right = found(zones);
        assert!(!right.is_empty() && right.len() < 100, "{}", right.len());
        for i in 0..zones.faces[MOCKUP].len() {
            // Judged wrongly, as corners at an edge that is grazed may be.
            let before = std::mem::replace(&mut zones.faces[MOCKUP][i].side, [-1; 3]);
            assert_eq!(found(zones), right, "{i}");
            zones.faces[MOCKUP][i].side = before;
        }
    }
}
