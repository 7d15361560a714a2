//! Makes contact regions from the pairs of triangles that collide: segments, contours by union-find, sides of vertices,
//! and a flood fill of the area that the contours enclose.

use feeler_core::constants::NONE;
use feeler_core::constants::WELD_SHARE;
use feeler_core::geometry::triangle_normals::{eight_normals, is_thin};
use feeler_core::geometry::vectors::{dot, normal, scaled, sub};
use feeler_core::mesh::topology::disjoint_sets::DisjointSets;
use feeler_core::Point;
use feeler_lanes::WIDE_LANES;

use crate::constants::{CAME_THROUGH_SHARE, COPLANAR_COSINE, MOST_THIN_NEIGHBOURS, SIDEWAYS_MOTION_SHARE};
use crate::containers::counting_sort::lay_out;
use crate::context::QueryContext;
use crate::contour::connect::{connect_across_faces, connect_along_contour};
use crate::contour::contact_region::{ContactRegion, ContactRegions, Face, Segment};
use crate::contour::flood_fill::{flood_fill, Filled};
use crate::contour::segments::find_points;
use crate::contour::vertex_side::{classify_vertices, LineOffsets, NearestSegments};
use crate::surface::Surface;

impl ContactRegions {
    /// Finds the normals of the faces, and which segments are flat.
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
                    face.normal =
                        normal_of_neighbour(context, surface, face.id, self.thin[surface]).unwrap_or(face.normal);
                    thin &= thin - 1;
                }
            }
        }
        for segment in &mut self.segments {
            let [p, q] = Surface::BOTH.map(|surface| &self.faces[surface][segment.faces[surface] as usize].normal);
            segment.flat = dot(p, q).abs() > 1.0 - COPLANAR_COSINE;
        }
    }

    /// Sorts segments, by their sets, and enclosed triangles by region; those of one region stay in their order.
    fn sort_by_region(&mut self, sets: &mut DisjointSets, region_of_root: &mut Vec<u32>, filled: &[Filled; 2]) {
        let ContactRegions {
            regions, region_segments, region_inside, region_of_segment, index_in_region, by_face, ..
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
            index_in_region.push(*end);
            *end += 1;
        }
        lay_out(regions.iter_mut().map(|region| &mut region.segments));
        region_segments.iter_mut().for_each(|segments| segments.resize(count, 0));
        for (i, (region, index)) in (0..).zip(region_of_segment.iter().zip(index_in_region.iter())) {
            region_segments[Surface::Tool][(regions[*region as usize].segments.0 + index) as usize] = i;
        }
        for i in by_face[Surface::Mockup].iter() {
            let end = &mut regions[region_of_segment[*i as usize] as usize].segments.1;
            region_segments[Surface::Mockup][*end as usize] = *i;
            *end += 1;
        }
        for (surface, Filled { triangles, .. }) in filled.iter().enumerate() {
            let region_of = |segment: u32| region_of_segment[segment as usize] as usize;
            triangles.iter().for_each(|(_, segment)| regions[region_of(*segment)].inside[surface].1 += 1);
            lay_out(regions.iter_mut().map(|region| &mut region.inside[surface]));
            region_inside[surface].resize(triangles.len(), [0; 2]);
            for (triangle, segment) in triangles {
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
    offsets: Vec<LineOffsets>,
    nearest: Vec<NearestSegments>,
    regions: ContactRegions,
}

/// The contact regions of one part's pairs (sorted by tool triangle, then mock-up triangle). The surfaces tell the side that the
/// tool is on, or `assumed_axis` does: see [`ContactRegions::assumed_axis`].
pub(crate) fn find<'a>(
    context: &QueryContext<'_>,
    pairs: &[[u32; 2]],
    assumed_axis: Option<Point>,
    scratch: &'a mut RegionScratch,
) -> &'a ContactRegions {
    let RegionScratch { filled, region_of_root, offsets, nearest, regions } = scratch;
    regions.clear();
    let mut face_numbers = std::mem::take(&mut regions.face_numbers);
    face_numbers.clear(context);
    regions.assumed_axis = assumed_axis;
    let part = pairs.first().map_or(0, |p| context.mockup.part_of_face(p[1]));
    regions.segments.reserve(pairs.len());
    regions.points.reserve(2 * pairs.len());
    for pair in pairs {
        let faces = Surface::BOTH.map(|surface| {
            let (number, is_new) = face_numbers.number(surface, pair[surface]);
            if is_new {
                let closed = context.adjacency[surface].outward[pair[surface] as usize] != 0;
                regions.faces[surface].push(Face::new(pair[surface], context.triangle(surface, pair[surface]), closed));
            }
            number
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
    classify_vertices(context, part, regions, offsets, nearest);
    for surface in Surface::BOTH {
        connect_across_faces(surface, regions, &mut sets);
    }
    for surface in Surface::BOTH {
        flood_fill(context, surface, part, regions, &mut face_numbers, &mut sets, &mut filled[surface]);
    }
    regions.face_numbers = face_numbers;
    regions.sort_by_region(&mut sets, region_of_root, filled);
    regions
}

/// The normal of the first neighbour that is not thin, breadth-first over long edges first: a thin triangle lies in the surface of
/// that, while its own normal is noise.
fn normal_of_neighbour(context: &QueryContext<'_>, surface: Surface, id: u32, thin: f64) -> Option<Point> {
    let mut seen = vec![id];
    let mut next = 0;
    while next < seen.len() {
        let t = context.triangle(surface, seen[next]);
        let edge = |k: usize| sub(&t[(k + 1) % 3], &t[k]);
        let mut sides =
            [0, 1, 2].map(|k| (dot(&edge(k), &edge(k)), context.adjacency[surface].neighbours[seen[next] as usize][k]));
        sides.sort_by(|p, q| q.0.total_cmp(&p.0));
        for (_, n) in sides.into_iter().filter(|(_, n)| *n != NONE) {
            let neighbour = context.triangle(surface, n);
            if !is_thin(&neighbour, thin) {
                return normal(&neighbour).map(|normal| scaled(&normal, context.sense(surface, n)));
            }
            if !seen.contains(&n) && seen.len() < MOST_THIN_NEIGHBOURS {
                seen.push(n);
            }
        }
        next += 1;
    }
    None
}

/// Turns the normals of open surfaces to the side that counts as outside, and those of closed ones thin enough for the tool to have
/// come through since the reference.
fn orient(context: &QueryContext<'_>, regions: &mut ContactRegions) {
    // For each face, summed over its segments: the displacement back to the reference along the normal, and its length.
    let mut back: [Vec<(f64, f64)>; 2] = Default::default();
    if context.reference.is_some() {
        back = Surface::BOTH.map(|surface| vec![(0.0, 0.0); regions.faces[surface].len()]);
        for segment in &regions.segments {
            let Some(displacement) = context.way_back(&regions.points[segment.points.0 as usize]) else { continue };
            for surface in Surface::BOTH {
                let (sum, length) = &mut back[surface][segment.faces[surface] as usize];
                // Relative to the tool the mock-up moves the other way.
                let sense = if surface == Surface::Mockup { 1.0 } else { -1.0 };
                *sum += sense * dot(&displacement, &regions.faces[surface][segment.faces[surface] as usize].normal);
                *length += dot(&displacement, &displacement).sqrt();
            }
        }
    }
    for surface in Surface::BOTH {
        for (i, face) in regions.faces[surface].iter_mut().enumerate() {
            let (sum, length) = back[surface].get(i).copied().unwrap_or_default();
            let flip = if face.closed {
                // The tool was free at the reference, yet comes from inside the solid: it went in on the other side.
                surface == Surface::Mockup && sum < -CAME_THROUGH_SHARE * length
            } else if sum.abs() > SIDEWAYS_MOTION_SHARE * length {
                sum < 0.0
            } else {
                // The mock-up's surface faces the tool's centre of area, and the tool's faces away from it.
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
    fn a_fill_on_the_wrong_side_of_the_contour_is_dropped() {
        // A block between the legs of a frame, a little into one of them: all of it is in the frame's box, so no fill leaks.
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
            let mut numbers = FaceNumbers::default();
            numbers.clear(&context);
            regions.faces[Surface::Mockup].iter().for_each(|face| _ = numbers.number(Surface::Mockup, face.id));
            let mut filled = Filled::default();
            flood_fill(&context, Surface::Mockup, 0, regions, &mut numbers, &mut sets, &mut filled);
            let mut ids: Vec<u32> = filled.triangles.iter().map(|f| f.0).collect();
            ids.sort_unstable();
            ids
        };
        let right = found(regions);
        assert!(!right.is_empty() && right.len() < 100, "{}", right.len());
        for i in 0..regions.faces[Surface::Mockup].len() {
            // Wrong sides, as vertices at a grazed edge may have.
            let before = std::mem::replace(&mut regions.faces[Surface::Mockup][i].side, [Side::Inside; 3]);
            assert_eq!(found(regions), right, "{i}");
            regions.faces[Surface::Mockup][i].side = before;
        }
    }
}
