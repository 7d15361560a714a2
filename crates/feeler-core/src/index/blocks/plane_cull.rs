//! Clusters of a fine tool beside large pieces of the mock-up: a cluster that lies wholly to one side of the plane of
//! each overlapping piece need not be placed.

use super::node::Node;
use super::pieces::{HalfBlock, PackedPieces};
use crate::tool::placement::{BoxLanes, Placement};
use feeler_lanes::{load3, Kernel, Simd, LANES};

/// Clusters of a group that overlap pieces of a block by their boxes.
pub struct Beside<'a> {
    pub node: &'a Node,
    pub packed: &'a PackedPieces,
    pub placement: &'a Placement,
    /// The boxes of the group's clusters, and the pieces that each overlaps.
    pub boxes: &'a BoxLanes,
    pub hits: &'a [u32; LANES],
    /// How far coordinates may be off.
    pub slack: f32,
    /// Working memory.
    pub half: &'a mut HalfBlock,
}

impl Kernel for Beside<'_> {
    type Output = u16;

    /// Which clusters are not beside the planes of all pieces that they meet.
    ///
    /// As everywhere, an axis that keeps two intervals apart by more than their uncertainty is proof.
    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> u16 {
        let Beside { node, packed, placement, boxes, hits, slack, half: pieces } = self;
        let mut left = 0;
        for half in 0..2 {
            let mut clusters = 0u16;
            for (c, hit) in hits.iter().enumerate() {
                clusters |= u16::from((hit >> (LANES * half)) as u16 != 0) << c;
            }
            clusters &= !left;
            if clusters == 0 {
                continue;
            }
            pieces.unpack_boxes(s, node, half);
            pieces.unpack_corners(s, packed, half, slack);
            let along = placement.along(s, &load3(s, &pieces.normals));
            let (near, far) = (s.load(&pieces.near), s.load(&pieces.far));
            while clusters != 0 {
                let c = clusters.trailing_zeros() as usize;
                clusters &= clusters - 1;
                let (lower, upper) = along.interval(s, boxes, c);
                let apart = s.lanes(s.above(lower, far) | s.above(near, upper));
                left |= u16::from((hits[c] >> (LANES * half)) as u16 & !apart != 0) << c;
            }
        }
        left
    }
}
