//! The edges of a mesh's triangles, and which of several triangles at an edge are neighbours.

use crate::constants::SAME_ANGLE;
use crate::geometry::bounds::{Aabb, Point};
use crate::geometry::vectors::{add, cross, dot, scaled, sub, unit};
use crate::mesh::triangle_mesh::Mesh;

/// A half-edge: an edge as one triangle has it. Its lower end, the one with the smaller number, is known from where it is listed.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Edge {
    /// The higher end: the number of its vertex.
    pub end: u32,
    pub triangle: u32,
    /// The corner of the triangle that the edge starts from.
    pub side: u8,
    /// Whether it runs from its lower end to its higher one.
    pub up: bool,
}

impl Edge {
    /// Its start and end by the triangle's winding, and the triangle's third corner.
    pub fn corners(&self, mesh: &Mesh) -> [Point; 3] {
        let (corners, side) = (mesh.triangle(self.triangle), usize::from(self.side));
        [corners[side], corners[(side + 1) % 3], corners[(side + 2) % 3]]
    }
}

/// The half-edges of all triangles, sorted by their ends.
pub struct Edges {
    /// Sorted by lower end, then higher end, then triangle.
    list: Vec<Edge>,
    /// For each vertex the end of its range in the list, of the half-edges whose lower end it is; the range before it ends where it begins.
    ends: Vec<usize>,
}

impl Edges {
    /// The half-edges of a mesh whose corners are numbered below `vertices` by `corners`.
    pub fn new(mesh: &Mesh, vertices: usize, corners: impl Fn(u32) -> [u32; 3]) -> Edges {
        let edges = |t: u32| {
            let [a, b, c] = corners(t);
            [(a, b), (b, c), (c, a)]
        };
        // Counting sort: counts, then beginnings, and once the edges are placed, ends.
        let mut ends = vec![0; vertices];
        for t in mesh.queried() {
            edges(t).iter().for_each(|(a, b)| ends[*a.min(b) as usize] += 1);
        }
        let mut sum = 0;
        ends.iter_mut().for_each(|end| sum += std::mem::replace(end, sum));
        let mut list = vec![Edge::default(); sum];
        for t in mesh.queried() {
            for (side, (a, b)) in (0..).zip(edges(t)) {
                let end = &mut ends[a.min(b) as usize];
                list[*end] = Edge { end: a.max(b), triangle: t, side, up: a < b };
                *end += 1;
            }
        }
        let mut from = 0;
        for end in &ends {
            list[from..*end].sort_unstable_by_key(|edge| (edge.end, edge.triangle));
            from = *end;
        }
        Edges { list, ends }
    }

    /// Lists of the half-edges with the same two ends, each sorted by triangle.
    pub fn iter(&self) -> impl Iterator<Item = &[Edge]> {
        let froms = std::iter::once(&0).chain(&self.ends);
        froms.zip(&self.ends).flat_map(|(from, to)| self.list[*from..*to].chunk_by(|e, f| e.end == f.end))
    }
}

/// Pairs the triangles around an edge, of which as many run up as down; pairs are indices into the list. Where solids only touch
/// along the edge, a triangle's neighbour is the one that bounds its own solid; where two sheets lie on each other, it is of its own
/// sheet.
///
/// Around the edge, a solid ends at a triangle that runs up, whose normal is a quarter turn further, and begins at one that runs
/// down. So pairs match like brackets. `inside_out`: the triangles look into their solids.
pub fn pair_around(mesh: &Mesh, same: &[Edge], inside_out: bool) -> Vec<[usize; 2]> {
    let Some(first) = same.first() else { return Vec::new() };
    let lowest_first = |edge: &Edge| {
        let [from, to, third] = edge.corners(mesh);
        if edge.up {
            [from, to, third]
        } else {
            [to, from, third]
        }
    };
    let [from, to, _] = lowest_first(first);
    let axis = unit(&sub(&to, &from)).unwrap_or_default();
    // Two directions perpendicular to the edge, the first also to the coordinate axis that it is least along.
    let least = (0..3).min_by(|i, j| axis[*i].abs().total_cmp(&axis[*j].abs())).unwrap_or(0);
    let x = unit(&cross(&axis, &std::array::from_fn(|a| f64::from(u8::from(a == least))))).unwrap_or_default();
    let y = cross(&axis, &x);
    let angle = |edge: &Edge| {
        let [from, _, third] = lowest_first(edge);
        let spoke = sub(&third, &from);
        dot(&spoke, &y).atan2(dot(&spoke, &x))
    };
    let around: Vec<(f64, bool)> = same.iter().map(|edge| (angle(edge), edge.up == inside_out)).collect();
    wedges(&around, SAME_ANGLE)
}

/// For each part whether it is wound inside out as a whole: its signed volume is negative.
pub fn inside_out(mesh: &Mesh, part_of_face: &dyn Fn(u32) -> u32, bounds: &[Aabb]) -> Vec<bool> {
    let middle = |bounds: &Aabb| scaled(&add(&bounds.lower, &bounds.upper), 0.5);
    let middles: Vec<Point> = bounds.iter().map(middle).collect();
    let mut volumes = vec![0.0; bounds.len()];
    for t in mesh.queried() {
        let part = part_of_face(t) as usize;
        let [a, b, c] = mesh.triangle(t).map(|p| sub(&p, &middles[part]));
        volumes[part] += dot(&a, &cross(&b, &c));
    }
    volumes.into_iter().map(|volume| volume < 0.0).collect()
}

/// Pairs the faces around an edge that bound a wedge of one solid, where it begins and where it ends; pairs are indices into the list,
/// which has the angle of each face (radians, within half a turn either way) and whether a solid begins at it. Angles that differ by no
/// more than `same` are one.
pub fn wedges(around: &[(f64, bool)], same: f64) -> Vec<[usize; 2]> {
    let mut order: Vec<usize> = (0..around.len()).collect();
    order.sort_by(|i, j| around[*i].0.total_cmp(&around[*j].0));
    // From the widest gap on, nothing that is at one angle is apart.
    let further = |i: usize, j: usize| (around[j].0 - around[i].0).rem_euclid(std::f64::consts::TAU);
    let before = |k: usize| further(order[(k + order.len() - 1) % order.len()], order[k]);
    let widest = (1..order.len()).fold(0, |widest, k| if before(k) > before(widest) { k } else { widest });
    order.rotate_left(widest);
    // At one angle solids end before others begin.
    for at_one in order.chunk_by_mut(|i, j| further(*i, *j) <= same) {
        at_one.sort_unstable_by_key(|i| (around[*i].1, *i));
    }
    // Start after the lowest depth: from there on no solid ends that has not begun.
    let (mut depth, mut least, mut start) = (0i64, 0, 0);
    for (k, i) in order.iter().enumerate() {
        depth += if around[*i].1 { 1 } else { -1 };
        if depth < least {
            (least, start) = (depth, k + 1);
        }
    }
    order.rotate_left(start);
    let (mut open, mut pairs) = (Vec::new(), Vec::new());
    for i in order {
        if around[i].1 {
            open.push(i);
        } else if let Some(j) = open.pop() {
            pairs.push([j, i]);
        }
    }
    pairs
}

/// The number of a corner: the same for corners that are one.
pub type Corner = u32;

/// Takes those half-edges out of a list with the same ends whose triangles coincide, with opposite windings. Each comes with the third
/// corner of its triangle.
pub fn take_doubles(same: &mut Vec<(Edge, Corner)>) -> Vec<(Edge, Corner)> {
    same.sort_by_key(|(edge, third)| (*third, edge.up, edge.triangle));
    let (mut doubles, mut rest) = (Vec::new(), Vec::new());
    for of in same.chunk_by(|x, y| x.1 == y.1) {
        let (down, up) = of.split_at(of.partition_point(|(edge, _)| !edge.up));
        let count = down.len().min(up.len());
        doubles.extend(down[..count].iter().chain(&up[..count]));
        rest.extend(down[count..].iter().chain(&up[count..]));
    }
    *same = rest;
    doubles
}

/// Takes those half-edges out of such a list whose triangles coincide with an earlier one, with the same winding.
pub fn take_copies(same: &mut Vec<(Edge, Corner)>) -> Vec<(Edge, Corner)> {
    let key = |(edge, third): &(Edge, Corner)| (*third, edge.up);
    same.sort_by_key(|each| (key(each), each.0.triangle));
    let copies = same.windows(2).filter(|two| key(&two[0]) == key(&two[1])).map(|two| two[1]).collect();
    same.dedup_by_key(|each| key(each));
    copies
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Triangles around the z axis, at angles in degrees, and whether they run up it.
    fn around(fan: &[(f64, bool)]) -> (Mesh, Vec<Edge>) {
        let mut vertices = vec![[0.0; 3], [0.0, 0.0, 1.0]];
        vertices.extend(fan.iter().map(|(a, _)| [a.to_radians().cos(), a.to_radians().sin(), 0.3]));
        let faces = (2..).zip(fan).map(|(third, (_, up))| if *up { [0, 1, third] } else { [1, 0, third] }).collect();
        let edges = (0..).zip(fan).map(|(triangle, (_, up))| Edge { end: 1, triangle, side: 0, up: *up }).collect();
        (Mesh::new("tool", vertices, faces).unwrap(), edges)
    }

    fn pairs(fan: &[(f64, bool)]) -> Vec<[usize; 2]> {
        let (mesh, edges) = around(fan);
        let mut pairs = pair_around(&mesh, &edges, false);
        pairs.iter_mut().for_each(|pair| pair.sort_unstable());
        pairs.sort_unstable();
        pairs
    }

    #[test]
    fn solids_that_touch_along_an_edge_are_paired_each_with_itself() {
        // From 10 to 80 degrees and from 100 to 200, also across the angle where turns wrap around.
        for turn in [0.0, 57.0, 123.4, 190.0, 260.0] {
            let at = |a: f64| (a + turn) % 360.0;
            assert_eq!(
                pairs(&[(at(10.0), false), (at(80.0), true), (at(100.0), false), (at(200.0), true)]),
                [[0, 1], [2, 3]]
            );
            assert_eq!(
                pairs(&[(at(100.0), false), (at(10.0), false), (at(200.0), true), (at(80.0), true)]),
                [[0, 2], [1, 3]]
            );
            // Flush with each other along a plane, where one ends and the other begins.
            assert_eq!(
                pairs(&[(at(10.0), false), (at(80.0), true), (at(80.0), false), (at(200.0), true)]),
                [[0, 1], [2, 3]]
            );
        }
        assert!(pair_around(&around(&[(0.0, true)]).0, &[], false).is_empty());
        // Inside out.
        let (mesh, edges) = around(&[(10.0, true), (80.0, false), (100.0, true), (200.0, false)]);
        let mut found = pair_around(&mesh, &edges, true);
        found.iter_mut().for_each(|pair| pair.sort_unstable());
        found.sort_unstable();
        assert_eq!(found, [[0, 1], [2, 3]]);
    }

    #[test]
    fn sheets_that_lie_on_each_other_are_paired_each_with_itself() {
        // The sheet at 0 and at 180 degrees, its upper side and its lower one.
        for (a, b) in [(0.0, 180.0), (-180.0, 0.0), (90.0, -90.0)] {
            let found = pairs(&[(a, false), (a, true), (b, true), (b, false)]);
            assert_eq!(found, [[0, 2], [1, 3]], "{a} {b}");
        }
    }

    #[test]
    fn doubles_are_taken_out_two_by_two_and_copies_one_by_one() {
        let (mesh, edges) = around(
            &[10.0, 80.0, 80.0, 80.0, 200.0, 300.0, 200.0]
                .map(|a| (a, a == 300.0))
                .into_iter()
                .enumerate()
                .map(|(i, (a, up))| (a, up || i == 1 || i == 3))
                .collect::<Vec<_>>(),
        );
        let number = |edge: Edge| {
            let third = edge.corners(&mesh)[2];
            (edge, mesh.vertices().iter().position(|p| *p == third).unwrap() as Corner)
        };
        let mut same: Vec<(Edge, Corner)> = edges.into_iter().map(number).collect();
        let triangles = |some: &[(Edge, Corner)]| some.iter().map(|(edge, _)| edge.triangle).collect::<Vec<u32>>();
        assert_eq!(triangles(&take_doubles(&mut same)), [2, 1]);
        assert_eq!(triangles(&same), [0, 3, 4, 6, 5]);
        assert_eq!(triangles(&take_copies(&mut same)), [6]);
        assert_eq!(triangles(&same), [0, 3, 4, 5]);
    }
}
