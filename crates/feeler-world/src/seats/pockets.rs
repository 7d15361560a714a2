//! Pockets of sunk parts, such as the socket of a countersunk screw in a plate without a hole.
//!
//! In such a model the plate's solid is also in the socket. The screw must come out although the floor of its socket passes through that
//! solid. So a pocket whose mouth is at the surface of the neighbour counts as filled: its walls and floor hold nothing, and its volume
//! belongs to the place that the part may leave through.

use std::collections::BTreeSet;

use feeler_core::constants::NONE;
use feeler_core::geometry::vectors::{add, along, cross, dot, scaled, sub, unit};
use feeler_core::mesh::topology::adjacency::Adjacency;
use feeler_core::{Mesh, Point, Tool, Triangle};

use crate::constants::{MOUTH_FLATNESS, SEAT_TOLERANCE};
use crate::surfaces::Surfaces;

/// A pocket of the tool; tool frame.
#[derive(Debug)]
pub struct Pocket {
    /// Of its walls and its floor.
    pub triangles: Vec<u32>,
    /// Triangles over its mouth.
    pub cap: Vec<Triangle>,
    /// Points in its mouth.
    pub mouth: Vec<Point>,
    /// Out of the mouth, unit.
    pub outward: Point,
}

/// The pockets of a tool that its neighbours' solid fills.
#[derive(Debug, Default)]
pub struct Filled {
    /// Of their walls and floors.
    triangles: BTreeSet<u32>,
    /// Over their mouths, each with a triangle of its pocket; tool frame.
    caps: Vec<(u32, Triangle)>,
}

impl Filled {
    /// Adds a pocket.
    pub fn add(&mut self, pocket: &Pocket) {
        self.triangles.extend(&pocket.triangles);
        let first = pocket.triangles.first();
        self.caps.extend(first.into_iter().flat_map(|first| pocket.cap.iter().map(|cap| (*first, *cap))));
    }

    /// Whether a triangle of the tool is of their walls and floors.
    pub fn contains(&self, tool_triangle: u32) -> bool {
        self.triangles.contains(&tool_triangle)
    }

    /// The surface of a part of the tool with its pockets filled; tool frame.
    pub fn surface<'a>(&'a self, tool: &'a Tool, part: u32) -> impl Iterator<Item = Triangle> + 'a {
        let is_own = move |t: u32| tool.part_of_face(t) == part;
        let own = tool.mesh().queried().filter(move |t| is_own(*t) && !self.contains(*t));
        own.map(|t| tool.mesh().triangle(t)).chain(self.caps_of(tool, part))
    }

    /// Triangles over the mouths of those of a part of the tool; tool frame.
    pub fn caps_of<'a>(&'a self, tool: &'a Tool, part: u32) -> impl Iterator<Item = Triangle> + 'a {
        self.caps.iter().filter(move |(t, _)| tool.part_of_face(*t) == part).map(|(_, cap)| *cap)
    }
}

/// The pockets of a tool: what lies behind a hole with a flat rim in one of its surfaces, and has no other way out.
pub fn pockets(tool: &Tool, size: f64) -> Vec<Pocket> {
    let (mesh, adjacency) = (tool.mesh(), tool.adjacency());
    let all: Vec<u32> = mesh.queried().collect();
    let surfaces = Surfaces::new(mesh, adjacency, &all, |t| tool.part_of_face(t));
    let mut around = vec![Vec::new(); surfaces.numbers.count()];
    for t in all {
        let Some(number) = surfaces.numbers.of(t) else { continue };
        let across = (0..3).map(|k| [t, k]).filter(|edge| {
            let other = across(adjacency, edge);
            other != NONE && surfaces.numbers.of(other) != Some(number)
        });
        around[number as usize].extend(across);
    }
    let flat = SEAT_TOLERANCE.max(MOUTH_FLATNESS * size);
    (0..).zip(&around).flat_map(|(number, edges)| behind(mesh, adjacency, &surfaces, number, edges, flat)).collect()
}

/// The triangle across the edge from corner `k` of one.
fn across(adjacency: &Adjacency, [t, k]: &[u32; 2]) -> u32 {
    adjacency.neighbours[*t as usize][*k as usize]
}

/// The pockets behind the rims of one surface; `edges` are those to other surfaces.
fn behind(
    mesh: &Mesh,
    adjacency: &Adjacency,
    surfaces: &Surfaces,
    number: u32,
    edges: &[[u32; 2]],
    flat: f64,
) -> Vec<Pocket> {
    let mut found = Vec::new();
    let loops = rims(mesh, edges);
    if loops.len() < 2 {
        return found;
    }
    for rim in loops {
        let Some((mouth, outward)) = mouth_of(mesh, adjacency, &rim, flat) else { continue };
        let of_rim: BTreeSet<[u32; 2]> = rim.iter().copied().collect();
        let mut seen: BTreeSet<u32> = rim.iter().map(|edge| across(adjacency, edge)).collect();
        let mut next: Vec<u32> = seen.iter().copied().collect();
        let mut is_closed = true;
        while let Some(t) = next.pop() {
            for other in adjacency.neighbours[t as usize] {
                if other == NONE {
                    is_closed = false;
                } else if surfaces.numbers.of(other) == Some(number) {
                    // Back over another rim: a hole through the part.
                    let back = (0..3).map(|k| [other, k]).filter(|edge| across(adjacency, edge) == t);
                    is_closed &= back.into_iter().all(|edge| of_rim.contains(&edge));
                } else if seen.insert(other) {
                    next.push(other);
                }
            }
            if !is_closed {
                break;
            }
        }
        let volume: f64 = seen.iter().map(|t| volume_from(&mouth[0], mesh, *t)).sum();
        let sign = adjacency.outward[rim[0][0] as usize];
        if is_closed && f64::from(sign) * volume < 0.0 {
            let cap = rim.iter().map(|edge| ends(mesh, edge)).map(|[a, b]| [b, a, mouth[0]]).collect();
            found.push(Pocket { triangles: seen.into_iter().collect(), cap, mouth, outward });
        }
    }
    found
}

/// Edges that hang together, by their ends.
fn rims(mesh: &Mesh, edges: &[[u32; 2]]) -> Vec<Vec<[u32; 2]>> {
    let key = |p: &Point| p.map(|x| (x + 0.0).to_bits());
    let mut from = std::collections::BTreeMap::<[u64; 3], Vec<usize>>::new();
    for (at, edge) in edges.iter().enumerate() {
        from.entry(key(&ends(mesh, edge)[0])).or_default().push(at);
    }
    let mut is_used = vec![false; edges.len()];
    let mut found = Vec::new();
    for first in 0..edges.len() {
        let (mut rim, mut next) = (Vec::new(), vec![first]);
        while let Some(at) = next.pop() {
            if !std::mem::replace(&mut is_used[at], true) {
                rim.push(edges[at]);
                next.extend(from.get(&key(&ends(mesh, &edges[at])[1])).into_iter().flatten());
            }
        }
        if !rim.is_empty() {
            found.push(rim);
        }
    }
    found
}

fn ends(mesh: &Mesh, [t, k]: &[u32; 2]) -> [Point; 2] {
    let corners = mesh.triangle(*t);
    [corners[*k as usize], corners[(*k as usize + 1) % 3]]
}

/// Points in the mouth that a rim surrounds, the middle first, and the direction out of it; `None` if the rim is not flat.
fn mouth_of(mesh: &Mesh, adjacency: &Adjacency, rim: &[[u32; 2]], flat: f64) -> Option<(Vec<Point>, Point)> {
    let sum = rim.iter().fold([0.0; 3], |sum, edge| add(&sum, &ends(mesh, edge)[0]));
    let centre = scaled(&sum, 1.0 / rim.len() as f64);
    let turn = rim.iter().fold([0.0; 3], |sum, edge| {
        let [a, b] = ends(mesh, edge);
        add(&sum, &cross(&sub(&a, &centre), &sub(&b, &centre)))
    });
    // The surface has the rim on its left, so around the hole the rim turns the other way.
    let outward = scaled(&unit(&turn)?, -f64::from(adjacency.outward[rim[0][0] as usize]));
    let is_flat = rim.iter().all(|edge| dot(&outward, &sub(&ends(mesh, edge)[0], &centre)).abs() <= flat);
    let within = rim.iter().map(|edge| {
        let corner = ends(mesh, edge)[0];
        along(&centre, 0.5, &sub(&corner, &centre))
    });
    (is_flat && outward != [0.0; 3]).then(|| (std::iter::once(centre).chain(within).collect(), outward))
}

/// Six times the signed volume between a point and a triangle.
fn volume_from(origin: &Point, mesh: &Mesh, t: u32) -> f64 {
    let [a, b, c] = mesh.triangle(t).map(|p| sub(&p, origin));
    dot(&a, &cross(&b, &c))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square block with a square hole from above, `depth` deep; through it where that is its height, 1 m.
    fn block_with_hole(depth: f64) -> Tool {
        let square = |r: f64, z: f64| [[-r, -r, z], [r, -r, z], [r, r, z], [-r, r, z]];
        let rings = [square(1.0, 0.0), square(1.0, 1.0), square(0.4, 1.0), square(0.4, 1.0 - depth)];
        let is_through = depth >= 1.0;
        let vertices: Vec<Point> = rings.concat();
        let mut faces = Vec::new();
        let bands: &[[u32; 2]] = if is_through { &[[0, 1], [1, 2], [2, 3], [3, 0]] } else { &[[0, 1], [1, 2], [2, 3]] };
        for [low, high] in bands {
            for k in 0..4 {
                let [a, b] = [4 * low + k, 4 * low + (k + 1) % 4];
                let [c, d] = [4 * high + (k + 1) % 4, 4 * high + k];
                faces.extend([[a, b, c], [a, c, d]]);
            }
        }
        if !is_through {
            faces.extend([[0, 2, 1], [0, 3, 2], [12, 13, 14], [12, 14, 15]]);
        }
        Tool::new(vertices, faces).unwrap()
    }

    #[test]
    fn a_pocket_has_walls_and_a_floor_and_a_hole_through_is_none() {
        let block = block_with_hole(0.5);
        let found = pockets(&block, 2.0);
        let [pocket] = &found[..] else { panic!("{found:?}") };
        // Three bands of eight, then the bottom and the floor.
        assert_eq!(pocket.triangles, [16, 17, 18, 19, 20, 21, 22, 23, 26, 27]);
        assert_eq!(pocket.outward, [0.0, 0.0, 1.0]);
        assert!(pocket.mouth.iter().all(|[x, y, z]| x.abs().max(y.abs()) < 0.4 && *z == 1.0), "{pocket:?}");
        assert!(pockets(&block_with_hole(1.0), 2.0).is_empty());
    }

    #[test]
    fn a_boss_is_no_pocket_whatever_way_faces_look() {
        let block = block_with_hole(-0.5);
        assert!(pockets(&block, 2.0).is_empty());
        let faces = |tool: &Tool| tool.mesh().faces().iter().map(|[a, b, c]| [*a, *c, *b]).collect();
        for (block, count) in [(block, 0), (block_with_hole(0.5), 1)] {
            let turned = Tool::new(block.mesh().vertices().to_vec(), faces(&block)).unwrap();
            assert_eq!(pockets(&turned, 2.0).len(), count);
        }
    }
}
