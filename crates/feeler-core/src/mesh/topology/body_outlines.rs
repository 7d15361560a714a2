//! The points that span a convex body, computed on demand and cached.

use std::collections::HashMap;
use std::sync::{Arc, RwLock};

use super::adjacency::Adjacency;
use crate::constants::NONE;
use crate::geometry::bounds::Point;
use crate::geometry::vectors::{across, add, cross, dot, sub, unit};
use crate::mesh::triangle_mesh::Mesh;

/// The outlines of a mesh's bodies, as far as somebody asked. Nobody waits for the lock: in a forked process it may be held by a
/// thread that is not there.
#[derive(Debug, Default)]
pub struct BodyOutlines(RwLock<HashMap<u32, Arc<[Point]>>>);

impl BodyOutlines {
    /// The points of a triangle's body that may be outermost along any direction, in the mesh's frame: of each smooth region the
    /// corners of the convex hull in its plane. Empty for a triangle that is not queried.
    pub fn of(&self, mesh: &Mesh, adjacency: &Adjacency, triangle: u32) -> Arc<[Point]> {
        let body = adjacency.body_of(triangle);
        if body == NONE {
            return Arc::new([]);
        }
        if let Some(points) = self.0.try_read().ok().and_then(|known| known.get(&body).cloned()) {
            return points;
        }
        // Found without the lock: a second thread may find the same meanwhile.
        let points: Arc<[Point]> = outline(mesh, adjacency, triangle).into();
        match self.0.try_write() {
            Ok(mut known) => Arc::clone(known.entry(body).or_insert(points)),
            Err(_) => points,
        }
    }
}

fn outline(mesh: &Mesh, adjacency: &Adjacency, seed: u32) -> Vec<Point> {
    let body = adjacency.body_of(seed);
    let (mut found, mut next, mut seen) = (vec![seed], 0, std::collections::HashSet::from([seed]));
    while next < found.len() {
        for n in adjacency.neighbours[found[next] as usize] {
            if n != NONE && adjacency.body_of(n) == body && seen.insert(n) {
                found.push(n);
            }
        }
        next += 1;
    }
    let region = |t: &u32| adjacency.smooth_regions[*t as usize].number();
    found.sort_unstable_by_key(|t| (region(t), *t));
    let mut points: Vec<Point> = Vec::new();
    let mut corners: Vec<Point> = Vec::new();
    for same in found.chunk_by(|a, b| region(a) == region(b)) {
        let mut normal = [0.0; 3];
        corners.clear();
        for t in same {
            let [a, b, c] = mesh.triangle(*t);
            let n = cross(&sub(&b, &a), &sub(&c, &a));
            normal = if dot(&n, &normal) < 0.0 { sub(&normal, &n) } else { add(&normal, &n) };
            corners.extend([a, b, c]);
        }
        let Some(normal) = unit(&normal) else { continue };
        let [u, v] = across(&normal);
        let at = corners[0];
        let seen = |p: &Point| [dot(&sub(p, &at), &u), dot(&sub(p, &at), &v)];
        points.extend(hull(&corners.iter().map(seen).collect::<Vec<_>>()).into_iter().map(|i| corners[i]));
    }
    let bits = |p: &Point| p.map(|x| (x + 0.0).to_bits());
    points.sort_unstable_by_key(bits);
    points.dedup_by_key(|p| bits(p));
    points
}

/// The corners of the convex hull of points in a plane, counter-clockwise, by their places: none in line with its neighbours (A.
/// Andrew: *Another efficient algorithm for convex hulls in two dimensions*, 1979). A point for points in one place, two for a line.
pub fn hull(points: &[[f64; 2]]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.sort_unstable_by(|i, j| {
        let (p, q) = (points[*i], points[*j]);
        p[0].total_cmp(&q[0]).then(p[1].total_cmp(&q[1])).then(i.cmp(j))
    });
    order.dedup_by(|i, j| points[*i] == points[*j]);
    if order.len() < 3 {
        return order;
    }
    let turn = |o: usize, a: usize, b: usize| {
        let [o, a, b] = [o, a, b].map(|i| points[i]);
        (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0])
    };
    let mut chain: Vec<usize> = Vec::with_capacity(order.len() + 1);
    let upper: Vec<usize> = order.iter().rev().copied().collect();
    for half in [&order, &upper] {
        let from = chain.len();
        for i in half {
            while chain.len() >= from + 2 && turn(chain[chain.len() - 2], chain[chain.len() - 1], *i) <= 0.0 {
                chain.pop();
            }
            chain.push(*i);
        }
        // The last of one half is the first of the other.
        chain.pop();
    }
    chain
}

#[cfg(test)]
mod tests {
    use super::*;
    use feeler_shapes::{ball, box_mesh, Arrays};

    fn outline_of((vertices, faces): Arrays) -> Arc<[Point]> {
        let mesh = Mesh::new("tool", vertices, faces).unwrap();
        let (adjacency, outlines) = (Adjacency::of_one_part(&mesh), BodyOutlines::default());
        let found = outlines.of(&mesh, &adjacency, 0);
        assert!(Arc::ptr_eq(&found, &outlines.of(&mesh, &adjacency, 1)), "found once");
        found
    }

    #[test]
    fn a_box_has_its_corners_however_finely_it_is_cut() {
        for cells in [1, 2, 7] {
            let found = outline_of(box_mesh([0.5; 3], [1.0, 2.0, 3.0], cells));
            assert_eq!(found.len(), 8, "{cells}: {found:?}");
            assert!(found.iter().all(|p| (0..3).all(|a| ((p[a] - 0.5).abs() - [0.5, 1.0, 1.5][a]).abs() < 1e-12)));
        }
    }

    #[test]
    fn nothing_of_a_ball_reaches_beyond_its_outline() {
        let mesh = ball(0.02, 31);
        let (vertices, found) = (mesh.0.clone(), outline_of(mesh));
        assert!(found.len() < vertices.len());
        for i in 0..200 {
            let d = [(0.7 * i as f64).sin(), (1.9 * i as f64).cos(), (0.3 * i as f64).sin()];
            let reach = |of: &[Point]| of.iter().map(|p| dot(p, &d)).fold(f64::NEG_INFINITY, f64::max);
            assert!(reach(&vertices) - reach(&found) < 1e-3 * 0.02, "{i}");
        }
    }

    #[test]
    fn hulls_are_corners_and_lines_and_points() {
        let square = [[0.0, 0.0], [1.0, 0.0], [0.5, 0.5], [1.0, 1.0], [0.5, 0.0], [0.0, 1.0], [0.0, 0.0]];
        assert_eq!(hull(&square), [0, 1, 3, 5]);
        assert_eq!(hull(&[[0.0, 0.0], [2.0, 2.0], [1.0, 1.0]]), [0, 1]);
        assert_eq!(hull(&[[3.0, 1.0]; 4]).len(), 1);
        assert!(hull(&[]).is_empty());
    }
}
