//! The location of a point relative to parts: inside, outside or on the surface, by exact signs.

use crate::geometry::bounds::{Aabb, Point, Triangle};
use crate::geometry::intersect_triangle_triangle::intersect_triangle_triangle;
use crate::geometry::ray_crossings::{crossing, ray_end, RAY_OFFSETS};
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

/// Where a point lies to each of some parts (ascending). Gaps of surfaces are filled.
pub fn locate(
    (index, solids): (&Index, &Solids<'_>),
    p: &Point,
    parts: &[u32],
    scratch: &mut LocationScratch,
) -> Vec<Location> {
    let mockup = index.mockup();
    let mut found = vec![Location::Outside; parts.len()];
    let bounds = |part: u32| &mockup.part_bounds()[part as usize];
    // Whether a ray has still to tell of a part.
    let mut is_open: Vec<bool> = parts.iter().map(|part| is_within(bounds(*part), p)).collect();
    if !is_open.contains(&true) {
        return found;
    }
    let around = parts.iter().zip(&is_open).filter(|(_, is_open)| **is_open);
    let hull = around.fold(Aabb::EMPTY, |hull, (part, _)| hull.union(bounds(*part)));
    for offset in &RAY_OFFSETS {
        if !is_open.contains(&true) {
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
        let filled = |(part, is_open): (&u32, &bool)| {
            if *is_open {
                winding(p, &q, solids.fillings(*part))
            } else {
                None
            }
        };
        let mut windings: Vec<Option<i32>> = parts.iter().zip(&is_open).map(filled).collect();
        for &face in triangles.iter() {
            let Ok(at) = parts.binary_search(&mockup.part_of_face(face)) else { continue };
            if !is_open[at] {
                continue;
            }
            let triangle = mockup.mesh().triangle(face);
            if is_on(p, &triangle) {
                (found[at], is_open[at]) = (Location::On, false);
                continue;
            }
            match crossing(p, &q, &triangle) {
                Some(0) => {}
                Some(sign) => {
                    let solid = solids.of(parts[at]);
                    let sense = i32::from(solid.adjacency().outward[solid.own(face) as usize]);
                    windings[at] = windings[at].map(|sum| sum + sense * sign);
                }
                None => windings[at] = None,
            }
        }
        for ((found, is_open), winding) in found.iter_mut().zip(&mut is_open).zip(windings) {
            if let Some(winding) = winding.filter(|_| *is_open) {
                *is_open = false;
                *found = if winding == 0 { Location::Outside } else { Location::Inside };
            }
        }
    }
    found
}

/// How often a ray leaves triangles along their winding's normals, more than it enters them; `None` where it meets a border.
fn winding(p: &Point, q: &Point, triangles: &[Triangle]) -> Option<i32> {
    triangles.iter().map(|t| crossing(p, q, t)).sum()
}

/// Whether a point lies in a closed box.
pub fn is_within(bounds: &Aabb, p: &Point) -> bool {
    bounds.is_overlapping(&Aabb { lower: *p, upper: *p })
}

fn is_on(p: &Point, triangle: &Triangle) -> bool {
    is_within(&Aabb::of_triangle(triangle), p) && intersect_triangle_triangle(triangle, &[*p; 3]).is_some()
}
