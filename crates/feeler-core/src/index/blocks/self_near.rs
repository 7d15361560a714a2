//! The last step of the tree against itself, for distances: a block's pieces against those of the blocks that are no
//! farther than the limit of their parts, by gaps between boxes and along the normals of both; each is a lower bound.

use super::block_parts::BlockParts;
use super::nearest::gaps;
use super::node::FANOUT;
use super::pieces::HalfBlock;
use super::self_descent::BlockSink;
use super::tree::Blocks;
use crate::constants::{
    BOUND_ROUNDING, LARGEST_BOUND, LEAF_ROUNDING, LEAST_AXIS_SQUARE, UNPACK_ROUNDING, VANISHING_SQUARE,
};
use crate::index::sink::SelfNearSink;
use feeler_lanes::{load3, Box4, Simd, LANES};

/// Hands pairs of pieces that may be near enough to who measures them.
pub struct NearBlocks<'a, W> {
    pub blocks: &'a Blocks,
    pub parts: &'a BlockParts,
    pub wanted: &'a mut W,
    pub scratch: &'a mut SelfNearScratch,
}

/// Working memory.
#[derive(Debug)]
pub struct SelfNearScratch {
    own: Box<[HalfBlock; 2]>,
    other: Box<[HalfBlock; 2]>,
}

impl Default for SelfNearScratch {
    fn default() -> SelfNearScratch {
        let halves = || Box::new([HalfBlock::ZERO; 2]);
        SelfNearScratch { own: halves(), other: halves() }
    }
}

impl Blocks {
    /// How far boxes of nodes may be apart, per axis, for pieces within a distance (metres): frame units, rounded up.
    pub fn reach_of(&self, metres: f64) -> f32 {
        let reach = metres * self.frame.scale;
        if reach < LARGEST_BOUND {
            (reach * (1.0 + BOUND_ROUNDING)) as f32 + 2.0 * UNPACK_ROUNDING
        } else {
            f32::INFINITY
        }
    }

    /// The square of a distance (metres) in frame units, rounded up, with which bounds are compared.
    pub fn limit_of(&self, metres: f64) -> f32 {
        let bound = metres * self.frame.scale;
        if bound < LARGEST_BOUND {
            (bound * bound * (1.0 + BOUND_ROUNDING) + VANISHING_SQUARE) as f32
        } else {
            f32::INFINITY
        }
    }
}

impl<W: SelfNearSink> BlockSink for NearBlocks<'_, W> {
    #[inline(always)]
    fn take<S: Simd>(&mut self, s: S, block: u32, others: &[u32]) {
        let NearBlocks { blocks, parts, wanted, scratch } = self;
        let SelfNearScratch { own, other: unpacked } = &mut **scratch;
        let (node, packed) = (&blocks.levels[0][block as usize], &blocks.pieces[block as usize]);
        let own_bounds = grown_by_rounding(&node.bounds());
        let own_parts = parts.of_block(block);
        let mut is_unpacked = false;
        for &other in others {
            let (other_node, other_packed) = (&blocks.levels[0][other as usize], &blocks.pieces[other as usize]);
            let other_bounds = grown_by_rounding(&other_node.bounds());
            let apart = gap_of(&own_bounds, &other_bounds);
            let mut is_other_unpacked = false;
            for of_own in own_parts {
                for of_other in parts.of_block(other) {
                    if of_other.part == of_own.part {
                        continue;
                    }
                    let limit = wanted.limit(of_own.part, of_other.part);
                    if apart > limit || limit < 0.0 {
                        continue;
                    }
                    if !is_unpacked {
                        is_unpacked = true;
                        for half in 0..2 {
                            own[half].unpack_boxes(s, node, half);
                            own[half].unpack_corners(s, packed, half, blocks.slack);
                        }
                    }
                    if !is_other_unpacked {
                        is_other_unpacked = true;
                        for half in 0..2 {
                            unpacked[half].unpack_boxes(s, other_node, half);
                            unpacked[half].unpack_corners(s, other_packed, half, blocks.slack);
                        }
                    }
                    let near = within(s, own, &other_bounds, limit) & of_own.pieces;
                    let mut rest = near;
                    while rest != 0 {
                        let piece = rest.trailing_zeros();
                        rest &= rest - 1;
                        let (half, lane) = (piece as usize / LANES, piece as usize % LANES);
                        let bounds = own[half].boxes_lane(lane);
                        let mut hit = of_other.pieces;
                        if other == block {
                            // Each two once.
                            hit &= !(u32::MAX >> (FANOUT as u32 - 1 - piece));
                        }
                        for other_half in 0..2 {
                            let mut lanes = (hit >> (LANES * other_half)) as u16;
                            if lanes == 0 {
                                continue;
                            }
                            let theirs = &unpacked[other_half];
                            let squared = gaps(s, &theirs.lower, &theirs.upper, &bounds);
                            lanes &= !s.lanes(s.above(squared, s.splat(limit)));
                            if lanes == 0 {
                                continue;
                            }
                            let mut bound = [0.0; LANES];
                            lanes &= planes_within(s, (&own[half], lane), theirs, squared, limit, &mut bound);
                            while lanes != 0 {
                                let i = lanes.trailing_zeros() as usize;
                                lanes &= lanes - 1;
                                let triangle = other_packed.triangles[LANES * other_half + i];
                                wanted.offer(bound[i], packed.triangles[piece as usize], triangle);
                            }
                        }
                    }
                }
            }
        }
        wanted.end_block();
    }
}

/// Sides of nodes are rounded to float32.
fn grown_by_rounding(b: &Box4) -> Box4 {
    super::self_descent::grown(b, UNPACK_ROUNDING)
}

/// The square of the gap between two boxes.
fn gap_of(p: &Box4, q: &Box4) -> f32 {
    (0..3).map(|a| (p.lower[a] - q.upper[a]).max(q.lower[a] - p.upper[a]).max(0.0)).map(|gap| gap * gap).sum::<f32>()
        * (1.0 - LEAF_ROUNDING as f32)
}

/// Which pieces' boxes are within a limit (a square) of a box.
#[inline(always)]
fn within<S: Simd>(s: S, halves: &[HalfBlock; 2], b: &Box4, limit: f32) -> u32 {
    let mut found = 0;
    for half in 0..2 {
        let squared = gaps(s, &halves[half].lower, &halves[half].upper, b);
        found |= u32::from(!s.lanes(s.above(squared, s.splat(limit)))) << (LANES * half);
    }
    found
}

/// Which of the other pieces the planes of neither side hold farther apart from a piece than the limit (a square); the bounds go
/// into `bound`, squares, rounded down.
///
/// Whatever the axis is, intervals along it that are apart by more than their uncertainty are proof. Lengths near what float32
/// can square prove nothing.
#[inline(always)]
fn planes_within<S: Simd>(
    s: S,
    (own, piece): (&HalfBlock, usize),
    theirs: &HalfBlock,
    squared: S::F32,
    limit: f32,
    bound: &mut [f32; LANES],
) -> u16 {
    let zero = s.splat(0.0);
    let limit = s.splat(limit * (1.0 + LEAF_ROUNDING as f32));
    let m = own.normal(s, piece);
    let (near, far) = theirs.interval(s, &m);
    let first = s.max(s.max(near - s.splat(own.far[piece]), s.splat(own.near[piece]) - far), zero);
    let n = load3(s, &theirs.normals);
    let (near, far) = own.along(s, piece, &n);
    let second = s.max(s.max(near - s.load(&theirs.far), s.load(&theirs.near) - far), zero);
    let mut beyond = 0;
    let mut gaps = [[0.0; LANES]; 2];
    let mut lengths = [[1.0; LANES]; 2];
    for (i, (gap, axis)) in [(first, m), (second, n)].into_iter().enumerate() {
        let length = s.mul_add(axis[0], axis[0], s.mul_add(axis[1], axis[1], axis[2] * axis[2]));
        let gap = gap * gap;
        s.store(gap, &mut gaps[i]);
        s.store(length, &mut lengths[i]);
        beyond |= s.lanes(s.above(gap, limit * length)) & s.lanes(s.above(length, s.splat(LEAST_AXIS_SQUARE)));
    }
    s.store(squared, bound);
    for lane in 0..LANES {
        for i in 0..2 {
            if lengths[i][lane] > LEAST_AXIS_SQUARE {
                bound[lane] = bound[lane].max(gaps[i][lane] / lengths[i][lane]);
            }
        }
        bound[lane] *= 1.0 - LEAF_ROUNDING as f32;
    }
    !beyond
}
