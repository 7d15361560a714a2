//! Connected components of segments: the contours of one contact region, by union-find, before the flood fill joins more.

use crate::constants::{CONTOUR_LEAN, MOST_SEGMENTS_COMPARED};
use crate::context::QueryContext;
use crate::contour::contact_region::ContactRegions;
use crate::surface::Surface;
use feeler_core::geometry::bounds::Point;
use feeler_core::geometry::vectors::{add, dot, scaled, sub};
use feeler_core::mesh::topology::adjacency::Adjacency;
use feeler_core::mesh::topology::disjoint_sets::DisjointSets;

/// Segments of a face from which on a binary search for a neighbour beats comparing all; at most 32, one bit each.
const FEW_SEGMENTS_OF_FACE: usize = 16;

/// Joins segments of one face whose triangles on the other surface are neighbours: there the contour crosses their common edge.
pub(crate) fn connect_along_contour(context: &QueryContext<'_>, regions: &ContactRegions, sets: &mut DisjointSets) {
    let mut others: Vec<u32> = Vec::new();
    for surface in Surface::BOTH {
        for same in regions.by_face(surface).filter(|same| same.len() > 1) {
            // Ascending, as the pairs were.
            others.clear();
            others.extend(same.iter().map(|i| regions.face(surface.other(), *i).id));
            let Adjacency { neighbours, has_cracks, .. } = context.adjacency[surface.other()];
            // Neighbours name each other, so half of the comparisons suffice; across cracks they need not.
            for (i, id) in others.iter().enumerate().skip(usize::from(!has_cracks)) {
                let (among, [a, b, c]) =
                    (&others[..if *has_cracks { others.len() } else { i }], neighbours[*id as usize]);
                if among.len() < FEW_SEGMENTS_OF_FACE {
                    let is_neighbour = |n: u32| u32::from((n == a) | (n == b) | (n == c));
                    let mut found = among.iter().rev().fold(0, |bits, n| bits << 1 | is_neighbour(*n));
                    while found != 0 {
                        sets.join(same[i], same[found.trailing_zeros() as usize]);
                        found &= found - 1;
                    }
                } else {
                    let found = [a, b, c].into_iter().filter_map(|n| among.binary_search(&n).ok());
                    found.for_each(|j| sets.join(same[i], same[j]));
                }
            }
        }
    }
}

/// Joins two contours on one large triangle where the surface between them is inside the other surface: a finer mesh has triangles
/// there, which the flood fill would find. Their nearest segments decide: the line from one to the other must lead behind the
/// other surface's face at one of them.
pub(crate) fn connect_across_faces(surface: Surface, regions: &ContactRegions, sets: &mut DisjointSets) {
    sets.flatten();
    for same in regions.by_face(surface) {
        let first = sets.of(same[0]);
        if same.iter().all(|c| sets.of(*c) == first) {
            continue;
        }
        let stride = same.len().div_ceil(MOST_SEGMENTS_COMPARED);
        // Segments, their middles, and the normals of the other surface.
        let sample: Vec<(u32, Point, Point)> = same
            .iter()
            .step_by(stride)
            .map(|i| {
                let segment = &regions.segments[*i as usize];
                let (a, b) = (regions.points[segment.points.0 as usize], regions.points[segment.points.0 as usize + 1]);
                (
                    *i,
                    scaled(&add(&a, &b), 0.5),
                    regions.faces[surface.other()][segment.faces[surface.other()] as usize].normal,
                )
            })
            .collect();
        let roots: Vec<u32> = sample.iter().map(|segment| sets.of(segment.0)).collect();
        let mut contours = roots.clone();
        contours.sort_unstable();
        contours.dedup();
        let contour_of: Vec<usize> =
            roots.iter().map(|root| contours.partition_point(|contour| contour < root)).collect();
        // The nearest segments of each two contours: a matrix, of which the upper half is filled.
        let mut nearest: Vec<(f64, usize, usize)> = vec![(f64::INFINITY, 0, 0); contours.len() * contours.len()];
        for i in 0..sample.len() {
            for j in 0..i {
                let (a, b) = (contour_of[i], contour_of[j]);
                if a == b {
                    continue;
                }
                let offset = sub(&sample[i].1, &sample[j].1);
                let square = dot(&offset, &offset);
                let nearest = &mut nearest[a.min(b) * contours.len() + a.max(b)];
                if square < nearest.0 {
                    *nearest = (square, i, j);
                }
            }
        }
        for (square, i, j) in nearest.into_iter().filter(|(square, ..)| *square < f64::INFINITY) {
            let offset = sub(&sample[j].1, &sample[i].1);
            let behind = -CONTOUR_LEAN * square.sqrt();
            if dot(&offset, &sample[i].2) < behind || -dot(&offset, &sample[j].2) < behind {
                sets.join(sample[i].0, sample[j].0);
            }
        }
    }
}
