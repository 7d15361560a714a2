//! Merging of equal vertices, without loss: a hash table of their bits.

use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

use crate::constants::NONE;
use crate::geometry::bounds::Point;
use crate::mesh::defects::hash;

/// Merges vertices with equal coordinates (0.0 and -0.0 are equal; NaN equals NaN of the same bits). Returns the distinct
/// vertices in order of first appearance, and for each given vertex its index among them.
///
/// The caller makes sure that there are at most 2^32 - 1 vertices.
pub fn weld_vertices(vertices: &[Point]) -> (Vec<Point>, Vec<u32>) {
    let mut unique: Vec<Point> = Vec::new();
    // Key: the position's hash. Value: the last unique vertex with it; `chain` links to the one before.
    let mut last: HashMap<u64, u32, BuildHasherDefault<Identity>> =
        HashMap::with_capacity_and_hasher(vertices.len() / 4, BuildHasherDefault::default());
    let mut chain: Vec<u32> = Vec::new();
    let bits = |p: &Point| p.map(|x| (x + 0.0).to_bits());
    let index = vertices
        .iter()
        .map(|p| {
            let head = last.entry(hash(p)).or_insert(NONE);
            let mut at = *head;
            while at != NONE {
                if bits(&unique[at as usize]) == bits(p) {
                    return at;
                }
                at = chain[at as usize];
            }
            let new = unique.len() as u32;
            unique.push(p.map(|x| x + 0.0));
            chain.push(*head);
            *head = new;
            new
        })
        .collect();
    unique.shrink_to_fit();
    (unique, index)
}

/// The key is a hash already.
#[derive(Default)]
struct Identity(u64);

impl Hasher for Identity {
    fn write(&mut self, bytes: &[u8]) {
        for b in bytes {
            self.0 = self.0.rotate_left(8) ^ u64::from(*b);
        }
    }

    fn write_u64(&mut self, x: u64) {
        // The table takes its bits from both ends; spread the hash over them.
        self.0 = x.wrapping_mul(0x9e37_79b9_7f4a_7c15);
    }

    fn finish(&self) -> u64 {
        self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keeps_order_and_merges_signed_zeros() {
        let (unique, index) = weld_vertices(&[[1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [1.0, -0.0, 0.0], [0.0, 2.0, 0.0]]);
        assert_eq!(unique, [[1.0, 0.0, 0.0], [0.0, 2.0, 0.0]]);
        assert_eq!(index, [0, 1, 0, 1]);
    }

    #[test]
    fn nan_vertices_survive() {
        let (unique, index) = weld_vertices(&[[f64::NAN, 0.0, 0.0], [f64::NAN, 0.0, 0.0], [0.0; 3]]);
        assert_eq!((unique.len(), index), (2, vec![0, 0, 1]));
    }
}
