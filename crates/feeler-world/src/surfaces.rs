//! The surfaces of a part as a designer would count them: a flat face, a bore, a fillet.
//!
//! Facets in one plane are one face, even if a groove separates them. Faces of similar size that meet at a small angle form one curved
//! surface. The facets of a fillet are much smaller than the floor and wall beside it, so the fillet is a surface of its own.

use std::collections::HashMap;
use std::sync::Arc;

use feeler_core::constants::NONE;
use feeler_core::geometry::vectors::{cross, dot, length, sub, unit};
use feeler_core::mesh::topology::adjacency::Adjacency;
use feeler_core::{Mesh, Point, SurfaceNumbers};

use crate::constants::{CURVED_ANGLE_COS, FLAT_ANGLE, MOST_AREA_RATIO, PLANE_NORMAL, PLANE_OFFSET};

/// The surfaces of some triangles of a mesh.
#[derive(Debug, Clone)]
pub struct Surfaces {
    /// The surface of each triangle.
    pub numbers: Arc<SurfaceNumbers>,
    /// For each surface those that it meets at a convex edge, sorted.
    beside: Vec<Vec<u32>>,
}

impl Surfaces {
    /// Of triangles, ascending, each of a part: no surface is of two.
    pub fn new(mesh: &Mesh, adjacency: &Adjacency, triangles: &[u32], part_of_face: impl Fn(u32) -> u32) -> Surfaces {
        let facets = Facets::new(mesh, adjacency, triangles);
        let mut flat = Groups::new(triangles.len());
        facets.edges().filter(|edge| edge.is_flat()).for_each(|edge| flat.join(edge.between));
        let mut area = vec![0.0; triangles.len()];
        for (at, normal) in facets.normals.iter().enumerate() {
            area[flat.of(at)] += 0.5 * length(normal);
        }
        let mut groups = flat.clone();
        for edge in facets.edges().filter(|edge| edge.cosine >= CURVED_ANGLE_COS) {
            let [a, b] = edge.between.map(|at| area[flat.of(at)]);
            if a.max(b) < MOST_AREA_RATIO * a.min(b) {
                groups.join(edge.between);
            }
        }
        facets.join_planes(&mut flat, &mut groups, part_of_face);
        let mut number_of = vec![NONE; triangles.len()];
        let mut count = 0;
        let numbers: Vec<(u32, u32)> = (0..triangles.len())
            .map(|at| {
                let number = &mut number_of[groups.of(at)];
                if *number == NONE {
                    *number = count;
                    count += 1;
                }
                (triangles[at], *number)
            })
            .collect();
        let mut beside = vec![Vec::new(); count as usize];
        for edge in facets.edges().filter(|edge| edge.is_convex) {
            let [a, b] = edge.between.map(|at| numbers[at].1);
            if a != b {
                beside[a as usize].push(b);
                beside[b as usize].push(a);
            }
        }
        for of_one in &mut beside {
            of_one.sort_unstable();
            of_one.dedup();
        }
        Surfaces { numbers: Arc::new(SurfaceNumbers::new(mesh.faces().len(), numbers)), beside }
    }

    /// The neighbouring surfaces across convex edges. A body that slides along one comes over that edge.
    pub fn beside(&self, surface: u32) -> &[u32] {
        self.beside.get(surface as usize).map_or(&[], Vec::as_slice)
    }

    /// Those of some triangles, each once, sorted.
    pub fn of(&self, triangles: &[u32]) -> Vec<u32> {
        let mut found: Vec<u32> = triangles.iter().filter_map(|t| self.numbers.of(*t)).collect();
        found.sort_unstable();
        found.dedup();
        found
    }
}

/// The triangles, and how each meets its neighbours.
struct Facets<'a> {
    mesh: &'a Mesh,
    adjacency: &'a Adjacency,
    triangles: &'a [u32],
    /// Outwards where that is known; twice the area.
    normals: Vec<Point>,
}

/// Where two triangles meet.
struct Edge {
    /// Places among the triangles.
    between: [usize; 2],
    /// Between the normals.
    cosine: f64,
    is_convex: bool,
    /// Whether one of them is so thin that its normal is noise, and this is its longest edge.
    is_of_thin: bool,
}

impl Edge {
    fn is_flat(&self) -> bool {
        self.is_of_thin || self.cosine >= 1.0 - 0.5 * FLAT_ANGLE * FLAT_ANGLE
    }
}

impl<'a> Facets<'a> {
    fn new(mesh: &'a Mesh, adjacency: &'a Adjacency, triangles: &'a [u32]) -> Facets<'a> {
        let normal = |t: &u32| {
            let [a, b, c] = mesh.triangle(*t);
            let sign = if adjacency.outward[*t as usize] < 0 { -1.0 } else { 1.0 };
            cross(&sub(&b, &a), &sub(&c, &a)).map(|x| sign * x)
        };
        Facets { mesh, adjacency, triangles, normals: triangles.iter().map(normal).collect() }
    }

    /// Joins the flat faces that are in one plane, but for facets of curved surfaces.
    fn join_planes(&self, flat: &mut Groups, groups: &mut Groups, part_of_face: impl Fn(u32) -> u32) {
        let mut faces_in = vec![0; self.triangles.len()];
        let faces: Vec<usize> = (0..self.triangles.len()).filter(|at| flat.of(*at) == *at).collect();
        faces.iter().for_each(|at| faces_in[groups.of(*at)] += 1);
        let mut first_in: HashMap<(u32, [i64; 4]), usize> = HashMap::new();
        for at in faces {
            let Some(normal) = unit(&self.normals[at]).filter(|_| faces_in[groups.of(at)] == 1) else { continue };
            let offset = dot(&normal, &self.mesh.triangle(self.triangles[at])[0]);
            let [x, y, z] = normal.map(|x| (x / PLANE_NORMAL).round() as i64);
            let plane = [x, y, z, (offset / PLANE_OFFSET).round() as i64];
            let first = *first_in.entry((part_of_face(self.triangles[at]), plane)).or_insert(at);
            groups.join([first, at]);
        }
    }

    /// Each edge once or twice.
    fn edges(&self) -> impl Iterator<Item = Edge> + '_ {
        (0..self.triangles.len()).flat_map(move |at| (0..3).filter_map(move |k| self.edge(at, k)))
    }

    fn edge(&self, at: usize, k: usize) -> Option<Edge> {
        let t = self.triangles[at];
        let other = self.adjacency.neighbours[t as usize][k];
        let next = (other != NONE).then(|| self.triangles.binary_search(&other).ok()).flatten()?;
        let corners = self.mesh.triangle(t);
        let long = |k: usize| length(&sub(&corners[(k + 1) % 3], &corners[k]));
        let is_thin = self.adjacency.smooth_regions[t as usize].is_thin();
        let (n, m) = (&self.normals[at], &self.normals[next]);
        // The corner of the other that is farthest off this plane is not on the edge.
        let off = self.mesh.triangle(other).map(|p| dot(n, &sub(&p, &corners[k])));
        let far = off.into_iter().max_by(|a, b| a.abs().total_cmp(&b.abs())).unwrap_or(0.0);
        Some(Edge {
            between: [at, next],
            cosine: dot(n, m) / (length(n) * length(m)).max(f64::MIN_POSITIVE),
            is_convex: far < 0.0,
            is_of_thin: is_thin && (0..3).all(|other| long(other) <= long(k)),
        })
    }
}

/// A union-find.
#[derive(Clone)]
pub(crate) struct Groups(Vec<usize>);

impl Groups {
    pub fn new(count: usize) -> Groups {
        Groups((0..count).collect())
    }

    /// The number of a group: its least member.
    pub fn of(&mut self, mut at: usize) -> usize {
        while self.0[at] != at {
            self.0[at] = self.0[self.0[at]];
            at = self.0[at];
        }
        at
    }

    pub fn join(&mut self, [a, b]: [usize; 2]) {
        let (a, b) = (self.of(a), self.of(b));
        self.0[a.max(b)] = a.min(b);
    }
}

#[cfg(test)]
mod tests {
    use feeler_core::Tool;

    use super::*;

    /// A ring of facets around z, with a floor below it and a plate around its upper rim: a blind hole; `inner` radius, metres.
    fn hole(sides: u32, inner: f64) -> Tool {
        let at = |k: u32, r: f64, z: f64| {
            let angle = std::f64::consts::TAU * f64::from(k % sides) / f64::from(sides);
            [r * angle.cos(), r * angle.sin(), z]
        };
        let mut vertices = vec![[0.0, 0.0, 0.0]];
        for k in 0..sides {
            vertices.extend([at(k, inner, 0.0), at(k, inner, 0.05), at(k, 0.1, 0.05)]);
        }
        let place = |k: u32, i: u32| 1 + 3 * (k % sides) + i;
        let mut faces = Vec::new();
        for k in 0..sides {
            let [a, b] = [k, k + 1];
            faces.push([0, place(a, 0), place(b, 0)]);
            faces.extend([[place(a, 0), place(a, 1), place(b, 1)], [place(a, 0), place(b, 1), place(b, 0)]]);
            faces.extend([[place(a, 1), place(a, 2), place(b, 2)], [place(a, 1), place(b, 2), place(b, 1)]]);
        }
        Tool::new(vertices, faces).unwrap()
    }

    #[test]
    fn a_blind_hole_has_a_floor_a_bore_and_a_plate_around_it() {
        for sides in [12, 64, 1024] {
            let hole = hole(sides, 0.02);
            let all: Vec<u32> = (0..5 * sides).collect();
            let surfaces = Surfaces::new(hole.mesh(), hole.adjacency(), &all, |_| 0);
            let [floor, bore, plate] = [0, 1, 3].map(|t| surfaces.numbers.of(t).unwrap());
            assert_eq!(surfaces.numbers.count(), 3, "{sides}");
            let numbers = [floor, bore, bore, plate, plate];
            assert!(all.iter().all(|t| surfaces.numbers.of(*t) == Some(numbers[*t as usize % 5])), "{sides}");
            // Over the rim, and not into the corner of the floor.
            assert_eq!((surfaces.beside(bore), surfaces.beside(floor)), (&[plate][..], &[][..]), "{sides}");
        }
    }

    #[test]
    fn a_fillet_joins_neither_floor_nor_wall() {
        let (steps, radius) = (9, 0.002);
        let mut outline = vec![[0.1, 0.0]];
        outline.extend((0..=steps).map(|k| {
            let angle = std::f64::consts::FRAC_PI_2 * f64::from(k) / f64::from(steps);
            [radius * (1.0 - angle.sin()), radius * (1.0 - angle.cos())]
        }));
        outline.push([0.0, 0.1]);
        let vertices: Vec<Point> = outline.iter().flat_map(|[x, z]| [[*x, 0.0, *z], [*x, 0.05, *z]]).collect();
        let faces = (0..outline.len() as u32 - 1).flat_map(|k| {
            let k = 2 * k;
            [[k, k + 3, k + 1], [k, k + 2, k + 3]]
        });
        let fillet = Tool::new(vertices, faces.collect()).unwrap();
        let all: Vec<u32> = (0..fillet.mesh().faces().len() as u32).collect();
        let surfaces = Surfaces::new(fillet.mesh(), fillet.adjacency(), &all, |_| 0);
        assert_eq!(surfaces.numbers.count(), 3);
        assert_eq!(surfaces.of(&all[2..all.len() - 2]).len(), 1);
    }

    #[test]
    fn faces_in_one_plane_are_one_face_of_their_part_alone() {
        // Two blocks side by side, and both again as parts of their own.
        let blocks = [0.0, 0.05].map(|x| feeler_shapes::box_mesh([x, 0.0, 0.0], [0.02; 3], 2));
        let (vertices, faces) = feeler_shapes::joined(blocks);
        let half = faces.len() / 2;
        let one = Tool::new(vertices, faces).unwrap();
        let all: Vec<u32> = (0..2 * half as u32).collect();
        let count = |part_of_face: fn(u32) -> u32| {
            Surfaces::new(one.mesh(), one.adjacency(), &all, part_of_face).numbers.count()
        };
        assert_eq!((count(|_| 0), count(|t| u32::from(t >= 48))), (8, 12));
        assert_eq!(half, 48);
    }
}
