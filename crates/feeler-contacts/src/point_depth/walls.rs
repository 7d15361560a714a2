//! Thin walls that go through each other: no point of either is deeper than half its thickness, however far they cross.

use feeler_core::geometry::vectors::{add, cross, dot, length, normal, scaled, sub};
use feeler_core::{Aabb, Point, Triangle};

use super::body::Body;
use super::depth::point_depth_from;
use crate::constants::{NEEDLE_FACES, NEEDLE_HEIGHT, OPPOSITE_FACES, WALL_MIDDLE};

/// Whether two bodies cross as thin walls: where their surfaces cross, both have a second face behind the first, and points of each lie
/// in the middle between these faces of the other. One of them may be a needle, whose faces need not be parallel.
pub fn are_walls_crossing([a, b]: [&Body; 2]) -> bool {
    let least = a.rounding().max(b.rounding());
    // How thick a wall may be for the points found to be in its middle.
    let thickness = [[b, a], [a, b]].map(|pair| 2.0 * point_depth_from(pair).depth / WALL_MIDDLE);
    if thickness.iter().any(|thickness| *thickness <= 4.0 * least) {
        return false;
    }
    let (few, many, thickness) =
        if a.len() <= b.len() { (a, b, thickness) } else { (b, a, [thickness[1], thickness[0]]) };
    let shift = sub(few.origin(), many.origin());
    (0..few.len() as u32).any(|i| {
        let t = few.triangle(i).map(|p| add(&p, &shift));
        let is_crossing_walls = |j: u32| {
            let at = crossing_point(&t, many.triangle(j), least)?;
            let is_thin = |by: [Thin; 2]| {
                is_thin(few, i, &sub(&at, &shift), thickness[0], by[0]) && is_thin(many, j, &at, thickness[1], by[1])
            };
            (is_thin([Thin::Needle, Thin::Wall]) || is_thin([Thin::Wall, Thin::Needle])).then_some(())
        };
        many.find_overlapping(&Aabb::of_triangle(&t), is_crossing_walls).is_some()
    })
}

/// What is thin.
#[derive(Debug, Clone, Copy)]
enum Thin {
    /// Between two faces that are about parallel.
    Wall,
    /// Of any section down to a triangle's, whose height is three times what its middle is from its sides; a wall is one, too.
    Needle,
}

/// Whether a face that looks the other way is behind a point of a triangle, no farther than a wall of this thickness would have it.
fn is_thin(body: &Body, i: u32, at: &Point, thickness: f64, by: Thin) -> bool {
    let Some(outward) = body.outward(i) else { return false };
    let (thickness, most) = match by {
        Thin::Wall => (thickness, OPPOSITE_FACES),
        Thin::Needle => (NEEDLE_HEIGHT / 2.0 * thickness, NEEDLE_FACES),
    };
    let end = add(at, &scaled(&outward, -thickness));
    let is_opposite = |j: u32| {
        let faces_away = j != i && body.outward(j).is_some_and(|n| dot(&n, &outward) <= most);
        (faces_away && piercing([at, &end], body.triangle(j), 0.0).is_some()).then_some(())
    };
    body.find_overlapping(&Aabb::of_triangle(&[*at, end, end]), is_opposite).is_some()
}

/// A point where an edge of one triangle goes through the other, not by rounding alone.
fn crossing_point(t: &Triangle, u: &Triangle, least: f64) -> Option<Point> {
    let edges = |t: &Triangle| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]];
    let through = |t: &Triangle, u: &Triangle| edges(t).iter().find_map(|[p, q]| piercing([p, q], u, least));
    let (p, q) = (through(t, u), through(u, t));
    match (p, q) {
        (Some(p), Some(q)) if length(&sub(&p, &q)) > least => Some(scaled(&add(&p, &q), 0.5)),
        (Some(p), None) | (None, Some(p)) => Some(p),
        _ => None,
    }
}

/// Where a segment goes through a triangle, no nearer to its border than `inset` (metres).
fn piercing([p, q]: [&Point; 2], t: &Triangle, inset: f64) -> Option<Point> {
    let n = normal(t)?;
    let (h, k) = (dot(&n, &sub(p, &t[0])), dot(&n, &sub(q, &t[0])));
    if h * k >= 0.0 {
        return None;
    }
    let s = h / (h - k);
    let at: Point = std::array::from_fn(|a| p[a] + s * (q[a] - p[a]));
    let is_in = (0..3).all(|i| {
        let side = sub(&t[(i + 1) % 3], &t[i]);
        dot(&cross(&n, &side), &sub(&at, &t[i])) >= inset * length(&side)
    });
    is_in.then_some(at)
}
