//! One run of triangles with its vertices welded: each position once.

use super::runs::Run;
use crate::constants::{FIRST_PIECE_SHARE, NONE};
use crate::geometry::bounds::{Aabb, Point};
use crate::mesh::triangle_mesh::Mesh;

/// A run as it goes into a piece.
#[derive(Debug)]
pub struct WeldedRun {
    /// In order of their first use.
    pub positions: Vec<[f32; 3]>,
    /// Places among them.
    pub indices: Vec<[u16; 3]>,
    /// Around the corners as given.
    pub bounds: Aabb,
}

/// A hash table from positions to their places, to be used again.
#[derive(Debug, Default)]
pub struct WeldTable {
    slots: Vec<u32>,
}

impl WeldTable {
    /// The corners of a run's triangles relative to `middle`; corners that are equal in float32 are one.
    ///
    /// The caller makes sure that there are at most 65,536 corners.
    pub fn weld(&mut self, mesh: &Mesh, triangles: &[u32], middle: &Point) -> WeldedRun {
        let slots = (4 * triangles.len()).next_power_of_two();
        self.slots.clear();
        self.slots.resize(slots, NONE);
        let shift = 64 - slots.trailing_zeros();
        let mut positions: Vec<[f32; 3]> = Vec::with_capacity(triangles.len());
        let mut bounds = Aabb::EMPTY;
        let mut place = |corner: &Point| {
            bounds.grow(corner);
            let p = narrowed(corner, middle);
            let mut slot = (hash(&p) >> shift) as usize;
            loop {
                let at = self.slots[slot];
                if at == NONE {
                    self.slots[slot] = positions.len() as u32;
                    positions.push(p);
                    return (positions.len() - 1) as u16;
                }
                if positions[at as usize] == p {
                    return at as u16;
                }
                slot = (slot + 1) & (slots - 1);
            }
        };
        let indices = triangles.iter().map(|t| mesh.triangle(*t).each_ref().map(&mut place)).collect();
        positions.shrink_to_fit();
        WeldedRun { positions, indices, bounds }
    }
}

/// A corner in float32: at most the largest number there is, and without a negative zero.
fn narrowed(corner: &Point, middle: &Point) -> [f32; 3] {
    std::array::from_fn(|a| ((corner[a] - middle[a]) as f32).clamp(f32::MIN, f32::MAX) + 0.0)
}

fn hash(p: &[f32; 3]) -> u64 {
    let [x, y, z] = p.map(|x| u64::from(x.to_bits()));
    let mixed = (x << 32 | y).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    ((mixed ^ mixed >> 32) ^ z).wrapping_mul(0xff51_afd7_ed55_8ccd)
}

/// The runs that go into one piece: as many as its vertices allow, all of them small or none; the first of several is smaller.
pub fn pieces(runs: &[Run], welded: &[WeldedRun], vertex_limit: usize) -> Vec<std::ops::Range<usize>> {
    let mut pieces = Vec::new();
    let (mut first, mut vertices) = (0, 0);
    let all: usize = welded.iter().map(|run| run.positions.len()).sum();
    let first_limit = if all > vertex_limit { vertex_limit / FIRST_PIECE_SHARE } else { vertex_limit };
    for (at, run) in welded.iter().enumerate() {
        let is_full = vertices + run.positions.len() > if first == 0 { first_limit } else { vertex_limit };
        if at > first && (is_full || runs[at].is_small != runs[first].is_small) {
            pieces.push(first..at);
            (first, vertices) = (at, 0);
        }
        vertices += run.positions.len();
    }
    pieces.push(first..runs.len());
    pieces
}
