//! Rays out of a surface: how they cross triangles, by exact signs.

use crate::constants::{RAYS_WITH_CRACKS, RAY_EXCESS};
use crate::geometry::bounds::{Aabb, Point, Triangle};
use crate::geometry::predicates::orient3d;

/// Rays to the outside that are tried, each off the straight one by these shares of its length: odd ones, since a ray
/// that hits an edge is undecided, and edges lie along axes and diagonals.
pub const RAY_OFFSETS: [[f64; 2]; 6] =
    [[0.173, 0.091], [-0.059, 0.217], [-0.241, -0.127], [0.113, -0.281], [0.037, 0.053], [-0.331, 0.307]];

/// Number of rays to use; is_loose: the surface may have gaps, in seams and cracks.
pub fn ray_count(is_loose: bool) -> usize {
    if is_loose {
        RAYS_WITH_CRACKS
    } else {
        1
    }
}

/// The majority of the rays' results; 0 if there are none.
pub fn median(mut windings: Vec<i32>) -> i32 {
    windings.sort_unstable();
    windings.get(windings.len() / 2).copied().unwrap_or(0)
}

/// The signed crossing of the ray from `p` to `q` with a triangle, by exact signs: 1 if it leaves along the winding's
/// normal, -1 if it enters against it, 0 if it misses; `None` if it hits the triangle's border or lies in its plane.
/// Neither end may be on the triangle.
pub fn crossing(p: &Point, q: &Point, t: &Triangle) -> Option<i32> {
    let ray = Aabb::of_triangle(&[*p, *q, *q]);
    if !ray.is_overlapping(&Aabb::of_triangle(t)) {
        return Some(0);
    }
    let [a, b, c] = t;
    let (from, to) = (orient3d(a, b, c, p), orient3d(a, b, c, q));
    if from == 0 && to == 0 {
        return None;
    }
    if from * to >= 0 {
        return Some(0);
    }
    let around = [orient3d(p, q, a, b), orient3d(p, q, b, c), orient3d(p, q, c, a)];
    if around.contains(&1) && around.contains(&-1) {
        return Some(0);
    }
    (!around.contains(&0)).then_some(i32::from(from))
}

/// Where a ray from `p` ends: beyond the nearest side of a box around `p`, off the straight line there.
pub fn ray_end(p: &Point, hull: &Aabb, offset: &[f64; 2]) -> Point {
    let room = |side: usize| if side < 3 { hull.upper[side] - p[side] } else { p[side - 3] - hull.lower[side - 3] };
    let side = (0..6).min_by(|i, j| room(*i).total_cmp(&room(*j))).unwrap_or(0);
    let (axis, sense, length) = (side % 3, if side < 3 { 1.0 } else { -1.0 }, room(side) + RAY_EXCESS * hull.longest());
    let mut q = *p;
    q[axis] += sense * length;
    q[(axis + 1) % 3] += offset[0] * length;
    q[(axis + 2) % 3] += offset[1] * length;
    q
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ray_into_an_edge_is_undecided() {
        let t = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]];
        let turned = [t[0], t[2], t[1]];
        for (p, q, expected) in [
            ([0.5, 0.5, -1.0], [0.5, 0.5, 1.0], Some(1)),
            ([0.5, 0.5, 1.0], [0.5, 0.5, -1.0], Some(-1)),
            // Beside the triangle, short of it, from its plane, in its plane.
            ([1.5, 1.5, -1.0], [1.5, 1.5, 1.0], Some(0)),
            ([0.5, 0.5, -2.0], [0.5, 0.5, -1.0], Some(0)),
            ([1.5, 1.5, 0.0], [1.5, 1.5, 1.0], Some(0)),
            ([-1.0, 0.5, 0.0], [3.0, 0.5, 0.0], None),
            // Through an edge, a corner, and the line of an edge beyond its end.
            ([0.5, 0.0, -1.0], [0.5, 0.0, 1.0], None),
            ([1.0, 1.0, -1.0], [1.0, 1.0, 1.0], None),
            ([0.0, 0.0, -1.0], [0.0, 0.0, 1.0], None),
            ([1.5, 0.0, -1.0], [2.5, 0.0, 1.0], None),
            ([2.0, 0.0, -2.0], [3.0, 1.0, 2.0], Some(0)),
        ] {
            assert_eq!(crossing(&p, &q, &t), expected, "{p:?} {q:?}");
            assert_eq!(crossing(&p, &q, &turned), expected.map(|c| -c), "{p:?} {q:?}");
        }
    }
}
