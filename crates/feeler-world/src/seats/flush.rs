//! Surfaces of sunk parts that are flush with their neighbour's: beside each other, such as the head of a countersunk bolt in a plate, or
//! face to face, such as the head of a bolt that bears on a plate whose hole is too small.
//!
//! Flush surfaces do not cross, or only by rounding, so no contact plane shows when they go in. Each gets points of its own: they go no
//! deeper than they were where the neighbour is solid beneath them.

use feeler_core::geometry::twist::{times, transposed};
use feeler_core::geometry::vectors::{add, along, cross, dot, normal, scaled, sub};
use feeler_core::{Mockup, Point, Pose, Tool, Triangle};

use crate::constants::{CORNER_SHARE, FACE_ANGLE_COS};

/// A point of a sunk part's surface that is flush with its neighbour's at the start.
#[derive(Debug, Clone, Copy)]
pub struct Flush {
    /// Tool frame.
    pub point: Point,
    /// Of the neighbour's surface, outwards, unit, world.
    pub normal: Point,
    /// Whether the two surfaces are face to face.
    pub bears: bool,
    /// Of the tool and of the neighbour.
    pub triangles: [u32; 2],
}

/// Such a point at a pose.
#[derive(Debug, Clone, Copy)]
pub struct FlushAt {
    /// World.
    pub at: Point,
    /// How far it has moved outwards since the start, metres; below 0 where it went in.
    pub moved: f64,
    /// As at the start.
    pub flush: Flush,
}

/// The neighbour's normal, of parallel triangles, and whether they are face to face.
fn common_normal(own: (&Triangle, i8), other: (&Triangle, i8)) -> Option<(Point, bool)> {
    let [own, other] = [own, other].map(|(triangle, sign)| {
        let normal = normal(triangle)?;
        Some(if sign < 0 { scaled(&normal, -1.0) } else { normal })
    });
    let other = other?;
    let cosine = dot(&own?, &other);
    (cosine.abs() >= FACE_ANGLE_COS).then_some((other, cosine < 0.0))
}

/// Points where two triangles that are near each other at the start are flush; none where only their edges touch.
pub fn flush_points(tool: &Tool, start: &Pose, mockup: &Mockup, triangles: [u32; 2]) -> Vec<Flush> {
    let [t, m] = triangles;
    let own = start.apply_triangle(&tool.mesh().triangle(t));
    let other = mockup.mesh().triangle(m);
    let signs = (tool.adjacency().outward[t as usize], mockup.adjacency().outward[m as usize]);
    let Some((normal, bears)) = common_normal((&own, signs.0), (&other, signs.1)) else { return Vec::new() };
    let into_tool = |at: Point| times(&transposed(start.rotation()), &sub(&at, start.translation()));
    let points = common(&own, &other, &normal).into_iter().map(into_tool);
    points.map(|point| Flush { point, normal, bears, triangles }).collect()
}

/// The corners of the overlap of two triangles in one plane, each moved a little inwards. Empty where they only touch.
fn common(own: &Triangle, other: &Triangle, normal: &Point) -> Vec<Point> {
    let mut polygon = own.to_vec();
    let [a, b, c] = other;
    let turn = dot(&cross(&sub(b, a), &sub(c, a)), normal).signum();
    for (a, b) in [(a, b), (b, c), (c, a)] {
        let inwards = scaled(&cross(normal, &sub(b, a)), turn);
        let heights: Vec<f64> = polygon.iter().map(|p| dot(&sub(p, a), &inwards)).collect();
        let mut cut = Vec::with_capacity(polygon.len() + 1);
        for (i, p) in polygon.iter().enumerate() {
            let next = (i + 1) % polygon.len();
            if heights[i] > 0.0 {
                cut.push(*p);
            }
            if (heights[i] > 0.0) != (heights[next] > 0.0) {
                cut.push(along(p, heights[i] / (heights[i] - heights[next]), &sub(&polygon[next], p)));
            }
        }
        polygon = cut;
    }
    let middle = scaled(&polygon.iter().fold([0.0; 3], |sum, p| add(&sum, p)), 1.0 / polygon.len().max(1) as f64);
    polygon.iter().map(|p| along(p, CORNER_SHARE, &sub(&middle, p))).collect()
}
