//! Which cuts are of one zone, before the walk.

use crate::context::Ground;
use crate::context::{MOCKUP, TOOL};
use crate::contour::contact_region::Zones;
use feeler_core::geometry::bounds::Point;
use feeler_core::geometry::vectors::{add, dot, scaled, sub};
use feeler_core::mesh::topology::adjacency::Adjacency;
use feeler_core::mesh::topology::disjoint_sets::DisjointSets;

/// Most cuts of a face that are compared each with each.
const FEW: usize = 16;

/// The curve goes on in the neighbour of either triangle.
pub(crate) fn join_along_the_curve(ground: &Ground<'_>, zones: &Zones, roots: &mut DisjointSets) {
    let mut others: Vec<u32> = Vec::new();
    for w in [TOOL, MOCKUP] {
        for same in zones.by_face(w).filter(|same| same.len() > 1) {
            // In rising order.
            others.clear();
            others.extend(same.iter().map(|i| zones.face(1 - w, *i).id));
            let Adjacency { neighbours, has_cracks, .. } = ground.adjacency[1 - w];
            // Each two neighbours are met from both sides: once is enough, but across cracks.
            for (i, id) in others.iter().enumerate().skip(usize::from(!has_cracks)) {
                let (among, [a, b, c]) =
                    (&others[..if *has_cracks { others.len() } else { i }], neighbours[*id as usize]);
                if among.len() < FEW {
                    let is_beside = |n: u32| u32::from((n == a) | (n == b) | (n == c));
                    let mut beside = among.iter().rev().fold(0, |set, n| set << 1 | is_beside(*n));
                    while beside != 0 {
                        roots.join(same[i], same[beside.trailing_zeros() as usize]);
                        beside &= beside - 1;
                    }
                } else {
                    let beside = [a, b, c].into_iter().filter_map(|n| among.binary_search(&n).ok());
                    beside.for_each(|j| roots.join(same[i], same[j]));
                }
            }
        }
    }
}

/// Most cuts of a face that [`join_across_faces`] compares with each other.
const MOST_COMPARED: usize = 256;

/// Two curves on one large triangle are of one zone where what lies between them is beyond the other surface: a finer mesh has
/// triangles there, and the walk would find them.
pub(crate) fn join_across_faces(w: usize, zones: &Zones, roots: &mut DisjointSets) {
    roots.flatten();
    for same in zones.by_face(w) {
        let first = roots.of(same[0]);
        if same.iter().all(|c| roots.of(*c) == first) {
            continue;
        }
        let stride = same.len().div_ceil(MOST_COMPARED);
        let spots: Vec<(u32, Point, Point)> = same
            .iter()
            .step_by(stride)
            .map(|i| {
                let cut = &zones.cuts[*i as usize];
                let (a, b) = (zones.points[cut.points.0 as usize], zones.points[cut.points.0 as usize + 1]);
                (*i, scaled(&add(&a, &b), 0.5), zones.faces[1 - w][cut.faces[1 - w] as usize].normal)
            })
            .collect();
        let mut zones_here: Vec<u32> = spots.iter().map(|spot| roots.of(spot.0)).collect();
        let of_spot = zones_here.clone();
        zones_here.sort_unstable();
        zones_here.dedup();
        let zone_of: Vec<usize> = of_spot.iter().map(|root| zones_here.partition_point(|zone| zone < root)).collect();
        // The nearest cuts of each two zones, in rows by the first of them.
        let mut nearest: Vec<(f64, usize, usize)> = vec![(f64::INFINITY, 0, 0); zones_here.len() * zones_here.len()];
        for i in 0..spots.len() {
            for j in 0..i {
                let (a, b) = (zone_of[i], zone_of[j]);
                if a == b {
                    continue;
                }
                let way = sub(&spots[i].1, &spots[j].1);
                let square = dot(&way, &way);
                let nearest = &mut nearest[a.min(b) * zones_here.len() + a.max(b)];
                if square < nearest.0 {
                    *nearest = (square, i, j);
                }
            }
        }
        for (square, i, j) in nearest.into_iter().filter(|(square, ..)| *square < f64::INFINITY) {
            let way = sub(&spots[j].1, &spots[i].1);
            let behind = -0.1 * square.sqrt();
            if dot(&way, &spots[i].2) < behind || -dot(&way, &spots[j].2) < behind {
                roots.join(spots[i].0, spots[j].0);
            }
        }
    }
}
