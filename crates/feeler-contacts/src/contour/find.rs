//! Sorts the pairs that meet into contact regions: segments, contours, what they enclose.

use feeler_core::constants::NONE;
use feeler_core::constants::WELD_SHARE;
use feeler_core::geometry::triangle_normals::{eight_normals, is_thin};
use feeler_core::geometry::vectors::{dot, normal, scaled, sub};
use feeler_core::mesh::topology::disjoint_sets::DisjointSets;
use feeler_core::Point;
use feeler_lanes::WIDE_LANES;

use crate::containers::counting_sort::lay_out;
use crate::context::QueryContext;
use crate::contour::connect::{connect_across_faces, connect_along_contour};
use crate::contour::contact_region::{ContactRegion, ContactRegions, Face, Segment};
use crate::contour::flood_fill::{flood_fill, Filled};
use crate::contour::segments::find_points;
use crate::contour::vertex_side::{classify_vertices, LineOffsets, NearestSegments};
use crate::surface::Surface;

impl ContactRegions {
    /// Finds the normals of the faces, and which cuts are flat.
    fn find_normals(&mut self, context: &QueryContext<'_>) {
        for surface in Surface::BOTH {
            for faces in self.faces[surface].chunks_mut(WIDE_LANES) {
                let (normals, mut thin) =
                    eight_normals(context.lanes, faces.len(), self.thin[surface], |i| faces[i].corners.each_ref());
                for (face, n) in faces.iter_mut().zip(normals) {
                    face.normal = n.map_or([0.0; 3], |n| scaled(&n, context.sense(surface, face.id)));
                }
                while thin != 0 {
                    let face = &mut faces[thin.trailing_zeros() as usize];
                    face.normal = normal_beside(context, surface, face.id, self.thin[surface]).unwrap_or(face.normal);
                    thin &= thin - 1;
                }
            }
        }
        for segment in &mut self.segments {
            let [p, q] = Surface::BOTH.map(|surface| &self.faces[surface][segment.faces[surface] as usize].normal);
            segment.flat = dot(p, q).abs() > 1.0 - 1e-12;
        }
    }

    /// Puts what belongs to each zone together, in its order: the cuts, by their sets, and what was walked over.
    fn sort_by_region(&mut self, sets: &mut DisjointSets, region_of_root: &mut Vec<u32>, filled: &[Filled; 2]) {
        let ContactRegions {
            regions,
            region_segments,
            region_inside,
            region_of_segment,
            place_of_segment,
            by_face,
            ..
        } = self;
        let count = sets.0.len();
        region_of_root.clear();
        region_of_root.resize(count, NONE);
        for i in 0..count as u32 {
            let region = &mut region_of_root[sets.of(i) as usize];
            if *region == NONE {
                *region = regions.len() as u32;
                regions.push(ContactRegion::default());
            }
            let end = &mut regions[*region as usize].segments.1;
            region_of_segment.push(*region);
            place_of_segment.push(*end);
            *end += 1;
        }
        lay_out(regions.iter_mut().map(|region| &mut region.segments));
        region_segments.iter_mut().for_each(|segments| segments.resize(count, 0));
        for (i, (region, place)) in (0..).zip(region_of_segment.iter().zip(place_of_segment.iter())) {
            region_segments[Surface::Tool][(regions[*region as usize].segments.0 + place) as usize] = i;
        }
        for i in by_face[Surface::Mockup].iter() {
            let end = &mut regions[region_of_segment[*i as usize] as usize].segments.1;
            region_segments[Surface::Mockup][*end as usize] = *i;
            *end += 1;
        }
        for (surface, Filled { found: filled, .. }) in filled.iter().enumerate() {
            let region_of = |segment: u32| region_of_segment[segment as usize] as usize;
            filled.iter().for_each(|(_, segment)| regions[region_of(*segment)].inside[surface].1 += 1);
            lay_out(regions.iter_mut().map(|region| &mut region.inside[surface]));
            region_inside[surface].resize(filled.len(), [0; 2]);
            for (triangle, segment) in filled {
                let end = &mut regions[region_of(*segment)].inside[surface].1;
                region_inside[surface][*end as usize] = [*triangle, *segment];
                *end += 1;
            }
        }
    }
}

/// Working memory of [`find`].
#[derive(Debug, Default)]
pub(crate) struct RegionScratch {
    filled: [Filled; 2],
    region_of_root: Vec<u32>,
    stands: Vec<LineOffsets>,
    judged: Vec<NearestSegments>,
    regions: ContactRegions,
}

/// Sorts the pairs of one part (sorted by tool triangle, then mock-up triangle) into zones, the tool on the side that the surfaces
/// say or a `way` does.
pub(crate) fn find<'a>(
    context: &QueryContext<'_>,
    pairs: &[[u32; 2]],
    way: Option<Point>,
    scratch: &'a mut RegionScratch,
) -> &'a ContactRegions {
    let RegionScratch { filled, region_of_root, stands, judged, regions } = scratch;
    regions.clear();
    let mut places = std::mem::take(&mut regions.places);
    places.clear(context);
    regions.way = way;
    let part = pairs.first().map_or(0, |p| context.mockup.part_of_face(p[1]));
    for pair in pairs {
        let faces = Surface::BOTH.map(|surface| {
            let (place, is_new) = places.number(surface, pair[surface]);
            if is_new {
                let closed = context.adjacency[surface].outward[pair[surface] as usize] != 0;
                regions.faces[surface].push(Face::new(pair[surface], context.triangle(surface, pair[surface]), closed));
            }
            place
        });
        regions.segments.push(Segment { faces, points: (0, 0), flat: false });
    }
    regions.thin =
        [context.tool.mesh().bounds(), context.mockup.part_bounds()[part as usize]].map(|b| WELD_SHARE * b.longest());
    regions.find_normals(context);
    find_points(context.lanes, &regions.faces, &mut regions.segments, &mut regions.points);
    let mut sets = DisjointSets((0..regions.segments.len() as u32).collect());
    regions.sort_by_face();
    connect_along_contour(context, regions, &mut sets);
    orient(context, regions);
    classify_vertices(context, part, regions, stands, judged);
    for surface in Surface::BOTH {
        connect_across_faces(surface, regions, &mut sets);
    }
    for surface in Surface::BOTH {
        flood_fill(context, surface, part, regions, &mut places, &mut sets, &mut filled[surface]);
    }
    regions.places = places;
    regions.complete = filled.iter().all(|filled| filled.complete);
    regions.sort_by_region(&mut sets, region_of_root, filled);
    regions
}

/// Most triangles among which [`normal_beside`] looks for one that is not thin.
const MOST_BESIDE: usize = 16;

/// The normal of the nearest triangle over long edges that is not thin: what a thin one is a part of.
fn normal_beside(context: &QueryContext<'_>, surface: Surface, id: u32, thin: f64) -> Option<Point> {
    let mut seen = vec![id];
    let mut next = 0;
    while next < seen.len() {
        let t = context.triangle(surface, seen[next]);
        let edge = |k: usize| sub(&t[(k + 1) % 3], &t[k]);
        let mut sides =
            [0, 1, 2].map(|k| (dot(&edge(k), &edge(k)), context.adjacency[surface].neighbours[seen[next] as usize][k]));
        sides.sort_by(|p, q| q.0.total_cmp(&p.0));
        for (_, n) in sides.into_iter().filter(|(_, n)| *n != NONE) {
            let beside = context.triangle(surface, n);
            if !is_thin(&beside, thin) {
                return normal(&beside).map(|normal| scaled(&normal, context.sense(surface, n)));
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
fn orient(context: &QueryContext<'_>, regions: &mut ContactRegions) {
    // How far each face's part of the curve has come from where the tool was free, along its normal.
    let mut back: [Vec<(f64, f64)>; 2] = Default::default();
    if context.reference.is_some() {
        back = Surface::BOTH.map(|surface| vec![(0.0, 0.0); regions.faces[surface].len()]);
        for segment in &regions.segments {
            let middle = regions.points[segment.points.0 as usize];
            let Some(way) = context.way_back(&middle) else { continue };
            for surface in Surface::BOTH {
                let (sum, length) = &mut back[surface][segment.faces[surface] as usize];
                // Seen from the tool it is the mock-up that came.
                let sense = if surface == Surface::Mockup { 1.0 } else { -1.0 };
                *sum += sense * dot(&way, &regions.faces[surface][segment.faces[surface] as usize].normal);
                *length += dot(&way, &way).sqrt();
            }
        }
    }
    for surface in Surface::BOTH {
        for (i, face) in regions.faces[surface].iter_mut().enumerate() {
            let (sum, length) = back[surface].get(i).copied().unwrap_or_default();
            let flip = if face.closed {
                // It came out of the solid, and yet was free before: it went in on the other side.
                surface == Surface::Mockup && sum < -0.5 * length
            } else if sum.abs() > 1e-3 * length {
                sum < 0.0
            } else {
                // The mock-up's surface faces the tool's bulk, and the tool's faces away from it.
                let towards = sub(&context.centre, &face.corners[0]);
                (dot(&towards, &face.normal) < 0.0) == (surface == Surface::Mockup)
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
    use crate::contour::contact_region::FaceNumbers;
    use crate::surface::Side;
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
        let context = QueryContext::new(&block, &frame, &pose, None);
        let mut scratch = RegionScratch::default();
        find(&context, &pairs, None, &mut scratch);
        let regions = &mut scratch.regions;
        let found = |regions: &ContactRegions| {
            let mut sets = DisjointSets((0..regions.segments.len() as u32).collect());
            let mut places = FaceNumbers::default();
            places.clear(&context);
            regions.faces[Surface::Mockup].iter().for_each(|face| _ = places.number(Surface::Mockup, face.id));
            let mut filled = Filled::default();
            flood_fill(&context, Surface::Mockup, 0, regions, &mut places, &mut sets, &mut filled);
            let mut ids: Vec<u32> = filled.found.iter().map(|f| f.0).collect();
            ids.sort_unstable();
            ids
        };
        let right = found(regions);
        assert!(!right.is_empty() && right.len() < 100, "{}", right.len());
        for i in 0..regions.faces[Surface::Mockup].len() {
            // NearestSegments wrongly, as corners at an edge that is grazed may be.
            let before = std::mem::replace(&mut regions.faces[Surface::Mockup][i].side, [Side::Inside; 3]);
            assert_eq!(found(regions), right, "{i}");
            regions.faces[Surface::Mockup][i].side = before;
        }
    }
}
