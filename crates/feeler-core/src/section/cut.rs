//! Cutting: the sides of all vertices first, so that each triangle only looks up three of them.

use rayon::prelude::*;

use super::outline::SectionOutline;
use super::plane::Plane;
use crate::error::Result;
use crate::geometry::bounds::Point;
use crate::geometry::predicates::Sign;
use crate::index::selection::Selection;
use crate::mesh::mockup::Mockup;

/// Vertices, and triangles, that a task handles at a time.
const SECTION_TASK: usize = 1 << 14;

/// The segments of all triangles that are there and that a plane cuts, sorted by triangle; in parallel on the current rayon pool.
///
/// Errors: see [`Scene::section`](crate::Scene::section).
pub fn section(mockup: &Mockup, selection: &Selection, point: &Point, normal: &Point) -> Result<SectionOutline> {
    let plane = Plane::new(point, normal)?;
    let mesh = mockup.mesh();
    let sides = |chunk: &[Point]| chunk.iter().map(|p| plane.side(p)).collect::<Vec<Sign>>();
    let sides: Vec<Sign> = mesh.vertices().par_chunks(SECTION_TASK).flat_map_iter(sides).collect();
    let cut = |(chunk, faces): (usize, &[[u32; 3]])| {
        let mut outline = SectionOutline::default();
        for (i, face) in faces.iter().enumerate() {
            // Indices of a defective triangle may be out of range.
            let signs = face.map(|v| sides.get(v as usize).copied().unwrap_or_default());
            let [a, b, c] = signs.map(|sign| sign > 0);
            if a == b && b == c {
                continue;
            }
            let triangle = (chunk * SECTION_TASK + i) as u32;
            if !selection.has(triangle) || !mesh.is_queried(triangle) {
                continue;
            }
            if let Some(segment) = segment(&plane, &mesh.triangle(triangle), signs) {
                outline.segments.push(segment);
                outline.triangles.push(triangle);
                outline.parts.push(mockup.part_of_face(triangle));
            }
        }
        outline
    };
    let found: Vec<SectionOutline> = mesh.faces().par_chunks(SECTION_TASK).enumerate().map(cut).collect();
    let mut outline = SectionOutline::default();
    for each in found {
        outline.segments.extend(each.segments);
        outline.triangles.extend(each.triangles);
        outline.parts.extend(each.parts);
    }
    Ok(outline)
}

/// From the edge that leads behind the plane to the one that leads in front of it; `None` where both pass at one corner.
fn segment(plane: &Plane, corners: &[Point; 3], sides: [Sign; 3]) -> Option<[Point; 2]> {
    let mut ends = [[0.0; 3]; 2];
    for i in 0..3 {
        let j = (i + 1) % 3;
        match (sides[i] > 0, sides[j] > 0) {
            (true, false) => ends[0] = plane.crossing((&corners[j], sides[j]), &corners[i]),
            (false, true) => ends[1] = plane.crossing((&corners[i], sides[i]), &corners[j]),
            _ => {}
        }
    }
    (ends[0] != ends[1]).then_some(ends)
}
