//! The last step of the tree against itself, for collisions: a block's pieces against those of the blocks that it
//! reaches.

use super::block_parts::{BlockParts, PartPieces};
use super::node::FANOUT;
use super::pieces::HalfBlock;
use super::self_descent::BlockSink;
use super::tree::Blocks;
use crate::index::sink::SelfSink;
use feeler_lanes::{Simd, LANES};

/// Hands pairs of pieces that neither boxes nor planes hold apart to a narrow phase.
pub struct MeetingBlocks<'a, N> {
    pub blocks: &'a Blocks,
    pub parts: &'a BlockParts,
    pub narrow: &'a mut N,
    pub scratch: &'a mut MeetingScratch,
}

/// Working memory.
#[derive(Debug)]
pub struct MeetingScratch {
    own: Box<[HalfBlock; 2]>,
    other: Box<[HalfBlock; 2]>,
}

impl Default for MeetingScratch {
    fn default() -> MeetingScratch {
        let halves = || Box::new([HalfBlock::ZERO; 2]);
        MeetingScratch { own: halves(), other: halves() }
    }
}

impl<N: SelfSink> BlockSink for MeetingBlocks<'_, N> {
    #[inline(always)]
    fn take<S: Simd>(&mut self, s: S, block: u32, others: &[u32]) {
        let MeetingBlocks { blocks, parts, narrow, scratch } = self;
        let MeetingScratch { own, other: unpacked } = &mut **scratch;
        let (node, packed) = (&blocks.levels[0][block as usize], &blocks.pieces[block as usize]);
        let own_parts = parts.of_block(block);
        let (mut has_boxes, mut has_corners) = (false, 0u32);
        narrow.begin_block();
        for &other in others {
            // Of each part of the block, pieces of the other that are wanted.
            let mut asked = [0u32; FANOUT];
            let mut wanted = 0;
            for (asked, PartPieces { part, pieces }) in asked.iter_mut().zip(own_parts) {
                for of_other in parts.of_block(other) {
                    if of_other.part != *part && narrow.wants(*part, of_other.part) {
                        *asked |= of_other.pieces;
                    }
                }
                wanted |= if *asked != 0 { *pieces } else { 0 };
            }
            if wanted == 0 {
                continue;
            }
            let other_node = &blocks.levels[0][other as usize];
            let near = node.overlapping(s, &other_node.bounds()) & wanted;
            if near == 0 {
                continue;
            }
            if !has_boxes {
                has_boxes = true;
                own[0].unpack_boxes(s, node, 0);
                own[1].unpack_boxes(s, node, 1);
            }
            let mut pairs = [(0u32, 0u32); FANOUT];
            let (mut count, mut reached) = (0, 0);
            for (asked, PartPieces { pieces, .. }) in asked.iter().zip(own_parts) {
                if *asked == 0 {
                    continue;
                }
                let mut rest = near & pieces;
                while rest != 0 {
                    let piece = rest.trailing_zeros();
                    rest &= rest - 1;
                    let bounds = own[piece as usize / LANES].boxes_lane(piece as usize % LANES);
                    let mut hit = other_node.overlapping(s, &bounds) & asked;
                    if other == block {
                        // Each two once.
                        hit &= !(u32::MAX >> (FANOUT as u32 - 1 - piece));
                    }
                    pairs[count] = (piece, hit);
                    count += usize::from(hit != 0);
                    reached |= hit;
                }
            }
            if count == 0 {
                continue;
            }
            let other_packed = &blocks.pieces[other as usize];
            for half in 0..2 {
                if reached >> (LANES * half) & LOWER_HALF != 0 {
                    unpacked[half].unpack_boxes(s, other_node, half);
                    unpacked[half].unpack_corners(s, other_packed, half, blocks.slack);
                }
            }
            for &(piece, hit) in &pairs[..count] {
                let (half, lane) = (piece as usize / LANES, piece as usize % LANES);
                if has_corners >> half & 1 == 0 {
                    has_corners |= 1 << half;
                    own[half].unpack_corners(s, packed, half, blocks.slack);
                }
                let mut kept = 0;
                for other_half in 0..2 {
                    let lanes = (hit >> (LANES * other_half)) as u16;
                    if lanes != 0 {
                        let met = lanes & !own[half].held_apart(s, lane, &unpacked[other_half]);
                        kept |= u32::from(met) << (LANES * other_half);
                    }
                }
                if kept != 0 {
                    narrow.offer(s, piece, packed.triangles[piece as usize], kept, &other_packed.triangles);
                }
            }
        }
    }
}

/// Half of a block's pieces.
const LOWER_HALF: u32 = 0xffff;
