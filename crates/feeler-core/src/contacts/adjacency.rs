//! Which triangles share an edge, and which surfaces are closed; made once for a mesh, when contacts are first asked for.

use crate::bounds::Point;
use crate::mesh::Mesh;
use crate::simd::prefetch_at;
use crate::vectors::{add, cross, dot, length, scaled, sub};
use crate::weld::weld_vertices;

/// No neighbour.
pub(crate) const NONE: u32 = u32::MAX;

/// Neighbours across edges, and the sense of each triangle's winding.
#[derive(Debug)]
pub(crate) struct Adjacency {
    /// `neighbours[t][k]` lies across the edge from corner `k` to corner `k + 1` of `t`, within the same part; [`NONE`] at a
    /// border and where more than two triangles share the edge.
    pub neighbours: Vec<[u32; 3]>,
    /// 1: the triangle belongs to a closed surface and its winding gives the outward normal; -1: the inward one; 0: the
    /// surface is open, and the winding says nothing.
    pub outward: Vec<i8>,
    /// The centre of the surface's area, metres, in the mesh's own frame.
    pub centre: Point,
}

impl Adjacency {
    /// Asks for what is known of a triangle.
    #[inline]
    pub fn prefetch(&self, triangle: u32) {
        prefetch_at(&self.neighbours, triangle as usize);
        prefetch_at(&self.outward, triangle as usize);
    }

    /// Edges are matched by their corners' positions, so a mesh whose triangles share no vertices is as good as any.
    pub fn new(mesh: &Mesh, part_of_face: impl Fn(u32) -> u32, parts: usize) -> Adjacency {
        let mut neighbours = vec![[NONE; 3]; mesh.faces().len()];
        // A triangle whose edge has no proper neighbour opens its whole surface.
        let mut closed = vec![true; mesh.faces().len()];
        let (unique, welded) = weld_vertices(mesh.vertices());
        let corners = |t: u32| mesh.faces()[t as usize].map(|v| welded[v as usize]);
        for same in Edges::new(mesh, unique.len(), corners).iter() {
            let part = |i: usize| part_of_face(same[i].triangle);
            for i in 0..same.len() {
                let mut others = (0..same.len()).filter(|j| *j != i && part(*j) == part(i));
                let (t, k) = (same[i].triangle as usize, usize::from(same[i].side));
                match (others.next(), others.next()) {
                    (Some(j), None) => {
                        neighbours[t][k] = same[j].triangle;
                        closed[t] &= same[i].up != same[j].up;
                    }
                    _ => closed[t] = false,
                }
            }
        }
        spread_openness(&neighbours, &mut closed);
        let mut volume = vec![0.0; parts];
        let (mut centre, mut area) = ([0.0; 3], 0.0);
        let middle = scaled(&add(&mesh.bounds().lower, &mesh.bounds().upper), 0.5);
        for t in mesh.queried() {
            let [a, b, c] = mesh.triangle(t).map(|p| sub(&p, &middle));
            let normal = cross(&sub(&b, &a), &sub(&c, &a));
            if closed[t as usize] {
                volume[part_of_face(t) as usize] += dot(&a, &normal);
            }
            let weight = length(&normal);
            area += weight;
            centre = add(&centre, &scaled(&add(&add(&a, &b), &c), weight / 3.0));
        }
        let outward = (0..mesh.faces().len() as u32)
            .map(|t| match closed[t as usize] && mesh.is_queried(t) {
                true if volume[part_of_face(t) as usize] < 0.0 => -1,
                true => 1,
                false => 0,
            })
            .collect();
        let shift = if area > 0.0 && area.is_finite() { scaled(&centre, 1.0 / area) } else { [0.0; 3] };
        Adjacency { neighbours, outward, centre: add(&middle, &shift) }
    }

    /// Bytes held.
    pub fn memory(&self) -> usize {
        self.neighbours.capacity() * size_of::<[u32; 3]>() + self.outward.capacity()
    }
}

/// An edge of a triangle, but for its lower end.
#[derive(Debug, Clone, Copy, Default)]
struct Edge {
    /// The end with the higher number.
    end: u32,
    triangle: u32,
    /// The edge is from this corner to the next.
    side: u8,
    /// Whether it goes from the end with the lower number to the other.
    up: bool,
}

/// The edges of all triangles, by their ends.
struct Edges {
    /// Those of each lower end together.
    list: Vec<Edge>,
    /// For each vertex where its own end, by those of the one before where they begin.
    ends: Vec<usize>,
}

impl Edges {
    /// Of a mesh with so many vertices, by the three of each triangle.
    fn new(mesh: &Mesh, vertices: usize, corners: impl Fn(u32) -> [u32; 3]) -> Edges {
        let edges = |t: u32| {
            let [a, b, c] = corners(t);
            [(a, b), (b, c), (c, a)]
        };
        // From here on where the edges of each vertex begin; once they are put there, where they end.
        let mut ends = vec![0; vertices];
        for t in mesh.queried() {
            edges(t).iter().for_each(|(a, b)| ends[*a.min(b) as usize] += 1);
        }
        let mut sum = 0;
        ends.iter_mut().for_each(|end| sum += std::mem::replace(end, sum));
        let mut list = vec![Edge::default(); sum];
        for t in mesh.queried() {
            for (side, (a, b)) in (0..).zip(edges(t)) {
                let place = &mut ends[a.min(b) as usize];
                list[*place] = Edge { end: a.max(b), triangle: t, side, up: a < b };
                *place += 1;
            }
        }
        let mut from = 0;
        for end in &ends {
            list[from..*end].sort_unstable_by_key(|edge| (edge.end, edge.triangle));
            from = *end;
        }
        Edges { list, ends }
    }

    /// Those with the same two ends, by the numbers of their triangles.
    fn iter(&self) -> impl Iterator<Item = &[Edge]> {
        let froms = std::iter::once(&0).chain(&self.ends);
        froms.zip(&self.ends).flat_map(|(from, to)| self.list[*from..*to].chunk_by(|e, f| e.end == f.end))
    }
}

/// Marks every triangle that is connected to an open one.
fn spread_openness(neighbours: &[[u32; 3]], closed: &mut [bool]) {
    let mut open: Vec<u32> = (0..closed.len() as u32).filter(|t| !closed[*t as usize]).collect();
    while let Some(t) = open.pop() {
        for n in neighbours[t as usize] {
            if n != NONE && closed[n as usize] {
                closed[n as usize] = false;
                open.push(n);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contacts::shapes::box_mesh;
    use proptest::prelude::*;

    #[test]
    fn a_box_is_closed_whether_or_not_its_triangles_share_vertices() {
        let (vertices, faces) = box_mesh([0.0; 3], [1.0, 2.0, 3.0], 3);
        let soup: Vec<Point> = faces.iter().flatten().map(|v| vertices[*v as usize]).collect();
        let soup_faces = (0..faces.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
        for mesh in [Mesh::new("tool", vertices, faces).unwrap(), Mesh::new("tool", soup, soup_faces).unwrap()] {
            let adjacency = Adjacency::new(&mesh, |_| 0, 1);
            assert!(adjacency.outward.iter().all(|o| *o == 1));
            assert!(adjacency.neighbours.iter().flatten().all(|n| *n != NONE));
            assert!((0..3).all(|a| adjacency.centre[a].abs() < 1e-12));
        }
    }

    proptest! {
        #[test]
        fn neighbours_are_those_of_every_edge_with_every_other(
            faces in prop::collection::vec((prop::array::uniform3(0..9u32), 0..2u32), 1..60),
        ) {
            // Points 7 and 8 are where 0 and 1 are; some triangles have no area.
            let place = |v: u32| f64::from(v % 7);
            let vertices = (0..9).map(|v| [place(v), place(v) * place(v), place(v).powi(3)]).collect();
            let parts: Vec<u32> = faces.iter().map(|(_, part)| *part).collect();
            let given = faces.iter().map(|(face, _)| *face).collect();
            // None where no triangle has an area.
            let Ok(mesh) = Mesh::new("mockup", vertices, given) else { return Ok(()) };
            let adjacency = Adjacency::new(&mesh, |t| parts[t as usize], 2);
            let ends = |t: usize, k: usize| [mesh.faces()[t][k] % 7, mesh.faces()[t][(k + 1) % 3] % 7];
            let all = || (0..faces.len()).filter(|t| mesh.is_queried(*t as u32)).flat_map(|t| (0..3).map(move |k| (t, k)));
            for (t, k) in (0..faces.len()).flat_map(|t| (0..3).map(move |k| (t, k))) {
                let [a, b] = ends(t, k);
                let is_beside = |(u, l): &(usize, usize)| {
                    (*u, *l) != (t, k) && parts[*u] == parts[t] && ([a, b] == ends(*u, *l) || [b, a] == ends(*u, *l))
                };
                let others: Vec<_> = all().filter(is_beside).collect();
                let expected = if mesh.is_queried(t as u32) && others.len() == 1 { others[0].0 as u32 } else { NONE };
                prop_assert_eq!(adjacency.neighbours[t][k], expected, "{} {}", t, k);
            }
        }
    }

    #[test]
    fn inside_out_and_open_surfaces_are_told() {
        let (vertices, mut faces) = box_mesh([0.0; 3], [1.0; 3], 2);
        faces.iter_mut().for_each(|f| f.swap(0, 1));
        let inverted = Mesh::new("tool", vertices.clone(), faces.clone()).unwrap();
        assert!(Adjacency::new(&inverted, |_| 0, 1).outward.iter().all(|o| *o == -1));
        faces.pop();
        let open = Mesh::new("tool", vertices, faces).unwrap();
        assert!(Adjacency::new(&open, |_| 0, 1).outward.iter().all(|o| *o == 0));
    }
}
