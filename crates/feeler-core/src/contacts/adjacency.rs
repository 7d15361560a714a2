//! Which triangles share an edge, and which surfaces are closed; made once for a mesh, when contacts are first asked for.

use rayon::prelude::*;

use crate::bounds::Point;
use crate::mesh::Mesh;
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
    /// Edges are matched by their corners' positions, so a mesh whose triangles share no vertices is as good as any.
    pub fn new(mesh: &Mesh, part_of_face: impl Fn(u32) -> u32 + Sync, parts: usize) -> Adjacency {
        let (_, welded) = weld_vertices(mesh.vertices());
        let corner = |half: u64, offset: u64| {
            welded[mesh.faces()[(half >> 2) as usize][(((half & 3) + offset) % 3) as usize] as usize]
        };
        let mut halves: Vec<(u64, u64)> = mesh
            .par_queried()
            .flat_map_iter(|t| (0..3).map(move |k| u64::from(t) << 2 | k))
            .map(|half| {
                let (a, b) = (corner(half, 0), corner(half, 1));
                (u64::from(a.min(b)) << 32 | u64::from(a.max(b)), half)
            })
            .collect();
        halves.par_sort_unstable();
        let mut neighbours = vec![[NONE; 3]; mesh.faces().len()];
        // A triangle whose edge has no proper neighbour opens its whole surface.
        let mut closed = vec![true; mesh.faces().len()];
        for same in halves.chunk_by(|x, y| x.0 == y.0) {
            let part = |i: usize| part_of_face((same[i].1 >> 2) as u32);
            for i in 0..same.len() {
                let mut others = (0..same.len()).filter(|j| *j != i && part(*j) == part(i));
                let (t, k) = ((same[i].1 >> 2) as usize, (same[i].1 & 3) as usize);
                match (others.next(), others.next()) {
                    (Some(j), None) => {
                        neighbours[t][k] = (same[j].1 >> 2) as u32;
                        closed[t] &= corner(same[i].1, 0) != corner(same[j].1, 0);
                    }
                    _ => closed[t] = false,
                }
            }
        }
        drop(halves);
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
