//! Which cuts are of one zone, before the walk.

use crate::context::QueryContext;
use crate::contour::contact_region::ContactRegions;
use crate::surface::Surface;
use feeler_core::geometry::bounds::Point;
use feeler_core::geometry::vectors::{add, dot, scaled, sub};
use feeler_core::mesh::topology::adjacency::Adjacency;
use feeler_core::mesh::topology::disjoint_sets::DisjointSets;

/// Most cuts of a face that are compared each with each.
const FEW: usize = 16;

/// The curve goes on in the neighbour of either triangle.
pub(crate) fn connect_along_contour(context: &QueryContext<'_>, regions: &ContactRegions, sets: &mut DisjointSets) {
    let mut others: Vec<u32> = Vec::new();
    for surface in Surface::BOTH {
        for same in regions.by_face(surface).filter(|same| same.len() > 1) {
            // In rising order.
            others.clear();
            others.extend(same.iter().map(|i| regions.face(surface.other(), *i).id));
            let Adjacency { neighbours, has_cracks, .. } = context.adjacency[surface.other()];
            // Each two neighbours are met from both sides: once is enough, but across cracks.
            for (i, id) in others.iter().enumerate().skip(usize::from(!has_cracks)) {
                let (among, [a, b, c]) =
                    (&others[..if *has_cracks { others.len() } else { i }], neighbours[*id as usize]);
                if among.len() < FEW {
                    let is_beside = |n: u32| u32::from((n == a) | (n == b) | (n == c));
                    let mut beside = among.iter().rev().fold(0, |set, n| set << 1 | is_beside(*n));
                    while beside != 0 {
                        sets.join(same[i], same[beside.trailing_zeros() as usize]);
                        beside &= beside - 1;
                    }
                } else {
                    let beside = [a, b, c].into_iter().filter_map(|n| among.binary_search(&n).ok());
                    beside.for_each(|j| sets.join(same[i], same[j]));
                }
            }
        }
    }
}

/// Most cuts of a face that [`connect_across_faces`] compares with each other.
const MOST_COMPARED: usize = 256;

/// Two curves on one large triangle are of one zone where what lies between them is beyond the other surface: a finer mesh has
/// triangles there, and the walk would find them.
pub(crate) fn connect_across_faces(surface: Surface, regions: &ContactRegions, sets: &mut DisjointSets) {
    sets.flatten();
    for same in regions.by_face(surface) {
        let first = sets.of(same[0]);
        if same.iter().all(|c| sets.of(*c) == first) {
            continue;
        }
        let stride = same.len().div_ceil(MOST_COMPARED);
        let spots: Vec<(u32, Point, Point)> = same
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
        let mut regions_here: Vec<u32> = spots.iter().map(|spot| sets.of(spot.0)).collect();
        let of_spot = regions_here.clone();
        regions_here.sort_unstable();
        regions_here.dedup();
        let region_of: Vec<usize> =
            of_spot.iter().map(|root| regions_here.partition_point(|region| region < root)).collect();
        // The nearest cuts of each two zones, in rows by the first of them.
        let mut nearest: Vec<(f64, usize, usize)> =
            vec![(f64::INFINITY, 0, 0); regions_here.len() * regions_here.len()];
        for i in 0..spots.len() {
            for j in 0..i {
                let (a, b) = (region_of[i], region_of[j]);
                if a == b {
                    continue;
                }
                let way = sub(&spots[i].1, &spots[j].1);
                let square = dot(&way, &way);
                let nearest = &mut nearest[a.min(b) * regions_here.len() + a.max(b)];
                if square < nearest.0 {
                    *nearest = (square, i, j);
                }
            }
        }
        for (square, i, j) in nearest.into_iter().filter(|(square, ..)| *square < f64::INFINITY) {
            let way = sub(&spots[j].1, &spots[i].1);
            let behind = -0.1 * square.sqrt();
            if dot(&way, &spots[i].2) < behind || -dot(&way, &spots[j].2) < behind {
                sets.join(spots[i].0, spots[j].0);
            }
        }
    }
}
