//! Bodies for the tests here, and point queries over every triangle.

use feeler_core::{Aabb, Mockup, Point, Triangle};
use feeler_shapes::random::Random;
use feeler_shapes::{box_mesh, joined, Arrays, Matrix};

use super::body::{distance_to, Body};

/// A mesh as one part.
pub fn body((vertices, faces): Arrays) -> Body {
    let mockup = Mockup::new(vertices, faces, Vec::new(), 1).unwrap();
    let mesh = mockup.mesh();
    let faces: Vec<u32> = mesh.queried().collect();
    Body::new(faces.iter().map(|face| (*face, mesh.triangle(*face))), mockup.adjacency())
}

/// A box between two corners, each side cut into `cells` by `cells`.
pub fn block(lower: Point, upper: Point, cells: usize) -> Arrays {
    let middle = |a: usize| 0.5 * (lower[a] + upper[a]);
    box_mesh(std::array::from_fn(middle), std::array::from_fn(|a| upper[a] - lower[a]), cells)
}

/// With the other winding.
pub fn inside_out((vertices, faces): Arrays) -> Arrays {
    (vertices, faces.into_iter().map(|[a, b, c]| [a, c, b]).collect())
}

/// A box with a box taken out of its inside.
pub fn hollow_box(size: f64, hollow: f64, cells: usize) -> Arrays {
    joined([box_mesh([0.0; 3], [size; 3], cells), inside_out(box_mesh([0.0; 3], [hollow; 3], cells))])
}

/// Where a motion brings it.
pub fn placed((vertices, faces): Arrays, m: &Matrix) -> Arrays {
    let at = |p: &Point| std::array::from_fn(|a| m[a][0] * p[0] + m[a][1] * p[1] + m[a][2] * p[2] + m[a][3]);
    (vertices.iter().map(at).collect(), faces)
}

/// A random triangle of about a size, somewhere in the unit cube.
pub fn triangle(r: &mut Random, size: f64) -> Triangle {
    let c = r.point(0.0, 1.0);
    std::array::from_fn(|_| {
        let d = r.point(-size, size);
        std::array::from_fn(|a| c[a] + d[a])
    })
}

/// A random point of a convex polygon.
pub fn point_of(r: &mut Random, polygon: &[Point]) -> Point {
    let mut shares: Vec<f64> = polygon.iter().map(|_| r.real(0.0, 1.0)).collect();
    if r.below(3) == 0 {
        // On its border.
        let i = r.below(shares.len() as u64) as usize;
        let j = (i + 1) % shares.len();
        (0..shares.len()).filter(|k| *k != i && *k != j).for_each(|k| shares[k] = 0.0);
    }
    let sum: f64 = shares.iter().sum();
    std::array::from_fn(|a| polygon.iter().zip(&shares).map(|(p, share)| p[a] * share / sum).sum())
}

/// The least distance to all triangles of a body; the point is relative to its origin.
pub fn distance(body: &Body, p: &Point) -> f64 {
    (0..body.len() as u32).map(|i| distance_to(p, body.triangle(i))).fold(f64::INFINITY, f64::min)
}

/// Whether two boxes share a point.
pub fn is_meeting(p: &Aabb, q: &Aabb) -> bool {
    (0..3).all(|a| p.lower[a] <= q.upper[a] && q.lower[a] <= p.upper[a])
}
