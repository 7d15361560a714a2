//! Whether a point is inside a solid of a scene.

use feeler_core::geometry::vectors::{along, cross, dot, length, scaled, sub};
use feeler_core::{Point, Ray, Scene};

use crate::constants::SEAT_CAST;
use crate::error::Result;

/// The triangle of the solid that a point is inside of, where a ray from it leaves that. Sheets beside a solid of the same part bound nothing.
pub fn around_point(scene: &Scene, at: &Point, towards: &Point) -> Result<Option<u32>> {
    let (mockup, adjacency) = (scene.mockup(), scene.mockup().adjacency());
    let hit = |origin: Point, direction: &Point| scene.ray(&Ray { origin, direction: *direction }, f64::INFINITY, &[]);
    let is_sheet = |t: u32| {
        let part = mockup.part_of_face(t);
        adjacency.outward[t as usize] == 0 && adjacency.is_open(part) && !adjacency.shells_of(part).is_empty()
    };
    let leaves = |t: u32, direction: &Point| {
        let [a, b, c] = mockup.mesh().triangle(t);
        let sign = if adjacency.outward[t as usize] < 0 { -1.0 } else { 1.0 };
        sign * dot(&cross(&sub(&b, &a), &sub(&c, &a)), direction) > 0.0
    };
    // The other way first: a sheet on the surface of the solid hides it.
    for direction in [*towards, scaled(towards, -1.0)] {
        match hit(*at, &direction)? {
            Some(sheet) if is_sheet(sheet.triangle) => {}
            found => return Ok(found.map(|found| found.triangle).filter(|t| leaves(*t, &direction))),
        }
    }
    let mut origin = *at;
    while let Some(found) = hit(origin, towards)? {
        if !is_sheet(found.triangle) {
            return Ok(Some(found.triangle).filter(|t| leaves(*t, towards)));
        }
        origin = along(&found.point, SEAT_CAST / length(towards), towards);
    }
    Ok(None)
}
