//! The location of a point relative to parts: inside, outside or on the surface, by exact signs.

use crate::geometry::bounds::{Aabb, Point, Triangle};
use crate::geometry::intersect_triangle_triangle::intersect_triangle_triangle;
use crate::geometry::ray_crossings::{crossing, median, ray_count, ray_end, RAY_OFFSETS};
use crate::geometry::vectors::sub;
use crate::index::mockup_index::Index;
use crate::index::ray_search::{RayPath, RayScratch};
use crate::index::sink::RaySink;

use super::solids::Solids;

/// Where a point lies to a part.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Location {
    /// Inside a closed surface of it.
    Inside,
    /// Outside all of these; of a part that has none, everywhere.
    Outside,
    /// On one of its triangles.
    On,
}

/// Working memory.
#[derive(Debug, Default)]
pub struct LocationScratch {
    ray: RayScratch,
    triangles: Vec<u32>,
    /// By triangle, of a flood; none between two.
    pub(super) marks: Vec<Mark>,
}

/// State of a triangle in a flood over a surface.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) enum Mark {
    #[default]
    None,
    /// It meets the other part.
    Met,
    /// The flood came to it.
    Seen,
}

/// A ray that ends, in shares of its length; a little more, for the rounding of the direction.
const WHOLE_RAY: f64 = 1.0 + 1e-9;

struct Along<'a>(&'a mut Vec<u32>);

impl RaySink for Along<'_> {
    fn limit(&self) -> f64 {
        WHOLE_RAY
    }

    fn take(&mut self, triangles: &[u32]) {
        self.0.extend_from_slice(triangles);
    }
}

/// Where a point lies to each of some parts (ascending). Of a surface that may have gaps, in seams and cracks, most of three rays decide.
pub fn locate(
    (index, solids): (&Index, &Solids<'_>),
    p: &Point,
    parts: &[u32],
    scratch: &mut LocationScratch,
) -> Vec<Location> {
    let mockup = index.mockup();
    let mut found = vec![Location::Outside; parts.len()];
    let is_in = |part: &u32| is_within(&mockup.part_bounds()[*part as usize], p);
    if !parts.iter().any(is_in) {
        return found;
    }
    let hull = parts
        .iter()
        .filter(|part| is_in(part))
        .fold(Aabb::EMPTY, |hull, part| hull.union(&mockup.part_bounds()[*part as usize]));
    // By part the windings that rays counted.
    let mut windings: Vec<Vec<i32>> = vec![Vec::new(); parts.len()];
    let mut needed: Vec<usize> = parts.iter().map(|part| if is_in(part) { 1 } else { 0 }).collect();
    for offset in &RAY_OFFSETS {
        if windings.iter().zip(&needed).all(|(counted, needed)| counted.len() >= *needed) {
            break;
        }
        let q = ray_end(p, &hull, offset);
        let triangles = &mut scratch.triangles;
        triangles.clear();
        let (direction, lanes) = (sub(&q, p), index.lanes());
        for (store, selection) in index.stores() {
            let path = RayPath { origin: *p, direction, from: 0.0, selection, lanes };
            store.search_ray(mockup.mesh(), &path, &mut scratch.ray, &mut Along(triangles));
        }
        triangles.sort_unstable();
        triangles.dedup();
        let mut sums: Vec<Option<i32>> = vec![Some(0); parts.len()];
        for &face in triangles.iter() {
            let Ok(at) = parts.binary_search(&mockup.part_of_face(face)) else { continue };
            if needed[at] == 0 {
                continue;
            }
            let triangle = mockup.mesh().triangle(face);
            if is_on(p, &triangle) {
                (found[at], needed[at]) = (Location::On, 0);
                continue;
            }
            match crossing(p, &q, &triangle) {
                Some(0) => {}
                Some(sign) => {
                    let solid = solids.of(parts[at]);
                    needed[at] = ray_count(solid.is_loose());
                    let sense = i32::from(solid.adjacency().outward[solid.own(face) as usize]);
                    sums[at] = sums[at].map(|sum| sum + sense * sign);
                }
                None => sums[at] = None,
            }
        }
        for ((counted, sum), needed) in windings.iter_mut().zip(sums).zip(&needed) {
            if counted.len() < *needed {
                counted.extend(sum);
            }
        }
    }
    for ((found, counted), needed) in found.iter_mut().zip(windings).zip(needed) {
        if needed > 0 && median(counted) != 0 {
            *found = Location::Inside;
        }
    }
    found
}

/// Whether a point lies in a closed box.
pub fn is_within(bounds: &Aabb, p: &Point) -> bool {
    bounds.is_overlapping(&Aabb { lower: *p, upper: *p })
}

fn is_on(p: &Point, triangle: &Triangle) -> bool {
    is_within(&Aabb::of_triangle(triangle), p) && intersect_triangle_triangle(triangle, &[*p; 3]).is_some()
}
