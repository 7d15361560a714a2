//! Marching tetrahedra: the surface at a level, in the six tetrahedra of each cell of a block.

use feeler_core::Point;

use crate::constants::{BLOCK, EDGE_SHARE};

/// Nodes along a side of a block.
pub const NODES: usize = BLOCK + 1;
/// Nodes of a block, the last axis first.
pub const NODE_COUNT: usize = NODES * NODES * NODES;

/// Directions of edges: the axes they go along, as bits. 1 to 7.
const DIRECTIONS: usize = 8;

/// The tetrahedra of a cell: from its lowest corner along the axes in each order to its highest (corners as bits), and whether it is
/// wound the other way.
const TETRAHEDRA: [([usize; 4], bool); 6] = [
    ([0, 1, 3, 7], false),
    ([0, 2, 6, 7], false),
    ([0, 4, 5, 7], false),
    ([0, 1, 5, 7], true),
    ([0, 2, 3, 7], true),
    ([0, 4, 6, 7], true),
];

/// By which corners are inside, as bits: the edges that the surface crosses, each from inside to outside, in order around the
/// outward normal; three, or four.
const CROSSED: [&[[usize; 2]]; 16] = [
    &[],
    &[[0, 1], [0, 2], [0, 3]],
    &[[1, 0], [1, 3], [1, 2]],
    &[[0, 2], [0, 3], [1, 3], [1, 2]],
    &[[2, 3], [2, 0], [2, 1]],
    &[[0, 3], [0, 1], [2, 1], [2, 3]],
    &[[1, 0], [1, 3], [2, 3], [2, 0]],
    &[[0, 3], [1, 3], [2, 3]],
    &[[3, 2], [3, 1], [3, 0]],
    &[[0, 1], [0, 2], [3, 2], [3, 1]],
    &[[1, 2], [1, 0], [3, 0], [3, 2]],
    &[[3, 2], [1, 2], [0, 2]],
    &[[2, 0], [2, 1], [3, 1], [3, 0]],
    &[[2, 1], [3, 1], [0, 1]],
    &[[1, 0], [3, 0], [2, 0]],
    &[],
];

/// The surface in one block.
#[derive(Debug, Default)]
pub struct Piece {
    /// In spacings of the grid, from its origin.
    pub vertices: Vec<Point>,
    /// Wound with the normal outwards.
    pub faces: Vec<[u32; 3]>,
    /// Vertices that other blocks may have, too, and the numbers of their edges.
    pub shared: Vec<(u32, u64)>,
}

/// The number of a node in its block.
pub fn node(i: usize, j: usize, k: usize) -> usize {
    (i * NODES + j) * NODES + k
}

/// The place of a node in its block.
pub fn place_of(node: usize) -> [usize; 3] {
    [node / (NODES * NODES), node / NODES % NODES, node % NODES]
}

/// The surface where the values at the nodes of a block are the level. `at`: the block's lowest node. `vertex_of`: working memory.
pub fn surface(values: &[f64; NODE_COUNT], level: f64, at: [u32; 3], vertex_of: &mut Vec<u32>) -> Piece {
    let mut march = March { values, level, at, vertex_of, piece: Piece::default() };
    march.vertex_of.clear();
    march.vertex_of.resize(NODE_COUNT * DIRECTIONS, u32::MAX);
    for i in 0..BLOCK {
        for j in 0..BLOCK {
            for k in 0..BLOCK {
                march.cell([i, j, k]);
            }
        }
    }
    march.piece
}

struct March<'a> {
    values: &'a [f64; NODE_COUNT],
    level: f64,
    at: [u32; 3],
    /// By node and direction.
    vertex_of: &'a mut Vec<u32>,
    piece: Piece,
}

impl March<'_> {
    fn cell(&mut self, cell: [usize; 3]) {
        let corners: [usize; 8] =
            std::array::from_fn(|c| node(cell[0] + (c & 1), cell[1] + (c >> 1 & 1), cell[2] + (c >> 2)));
        let inside = corners.map(|n| self.values[n] < self.level);
        if inside == [true; 8] || inside == [false; 8] {
            return;
        }
        for (tetrahedron, is_turned) in &TETRAHEDRA {
            let case = (0..4).map(|c| usize::from(inside[tetrahedron[c]]) << c).sum::<usize>();
            let edges = CROSSED[case];
            if edges.is_empty() {
                continue;
            }
            let mut ring = [0; 4];
            for (vertex, ends) in ring.iter_mut().zip(edges) {
                *vertex = self.vertex(cell, ends.map(|c| tetrahedron[c]));
            }
            let mut add =
                |a: u32, b: u32, c: u32| self.piece.faces.push(if *is_turned { [a, c, b] } else { [a, b, c] });
            add(ring[0], ring[1], ring[2]);
            if edges.len() == 4 {
                add(ring[0], ring[2], ring[3]);
            }
        }
    }

    /// The vertex on the edge between two corners of a cell: computed the same everywhere.
    fn vertex(&mut self, cell: [usize; 3], [a, b]: [usize; 2]) -> u32 {
        let (low, direction) = (a & b, a ^ b);
        let from: [usize; 3] = std::array::from_fn(|x| cell[x] + (low >> x & 1));
        let step: [usize; 3] = std::array::from_fn(|x| direction >> x & 1);
        let from_node = node(from[0], from[1], from[2]);
        let slot = from_node * DIRECTIONS + direction;
        if self.vertex_of[slot] != u32::MAX {
            return self.vertex_of[slot];
        }
        let to_node = node(from[0] + step[0], from[1] + step[1], from[2] + step[2]);
        let (low_value, high_value) = (self.values[from_node], self.values[to_node]);
        let share = ((self.level - low_value) / (high_value - low_value)).clamp(EDGE_SHARE, 1.0 - EDGE_SHARE);
        let global: [u32; 3] = std::array::from_fn(|x| self.at[x] + from[x] as u32);
        let number = self.piece.vertices.len() as u32;
        self.piece.vertices.push(std::array::from_fn(|x| f64::from(global[x]) + share * step[x] as f64));
        self.vertex_of[slot] = number;
        if (0..3).any(|x| step[x] == 0 && (from[x] == 0 || from[x] == BLOCK)) {
            self.piece.shared.push((number, edge_number(global, direction)));
        }
        number
    }
}

/// Of the edge from a node of the grid along a direction.
fn edge_number(node: [u32; 3], direction: usize) -> u64 {
    node.iter().fold(0, |number, x| number << 20 | u64::from(*x)) << 3 | direction as u64
}

#[cfg(test)]
mod tests {
    use super::*;
    use feeler_core::geometry::vectors::{cross, dot, sub};

    fn corner(c: usize) -> Point {
        std::array::from_fn(|x| (c >> x & 1) as f64)
    }

    #[test]
    fn tetrahedra_fill_the_cell_and_say_how_they_are_wound() {
        for (t, is_turned) in TETRAHEDRA {
            let [a, b, c, d] = t.map(corner);
            let volume = dot(&sub(&d, &a), &cross(&sub(&b, &a), &sub(&c, &a)));
            assert_eq!(volume, if is_turned { -1.0 } else { 1.0 }, "{t:?}");
            // Each is along the axes in another order, so that they differ.
            assert!(t.windows(2).all(|w| w[0] & w[1] == w[0] && (w[0] ^ w[1]).count_ones() == 1));
        }
    }

    #[test]
    fn crossed_edges_lead_out_around_the_outward_normal() {
        let corners = [0, 1, 2, 4].map(corner);
        for (case, edges) in CROSSED.iter().enumerate() {
            let is_inside = |c: usize| case >> c & 1 == 1;
            let count = (0..4).filter(|c| is_inside(*c)).count();
            assert_eq!(edges.len(), [0, 3, 4, 3, 0][count]);
            let middles: Vec<Point> = edges
                .iter()
                .map(|[a, b]| {
                    assert!(is_inside(*a) && !is_inside(*b));
                    std::array::from_fn(|x| 0.5 * (corners[*a][x] + corners[*b][x]))
                })
                .collect();
            for i in 2..middles.len() {
                let normal = cross(&sub(&middles[i - 1], &middles[0]), &sub(&middles[i], &middles[0]));
                for c in 0..4 {
                    let height = dot(&sub(&corners[c], &middles[0]), &normal);
                    assert!(if is_inside(c) { height < 0.0 } else { height > 0.0 }, "case {case} corner {c}");
                }
            }
        }
    }
}
