//! The pieces of a block: quantised to ten bits a coordinate within the piece's box, and unpacked in lanes.

use bytemuck::{Pod, Zeroable};

use super::node::{Node, FANOUT};
use crate::constants::{HALF_STEP, UNPACK_ROUNDING};
use feeler_lanes::{
    along, boxes_apart, few_lanes, greatest, greatest4, least, least4, load3, part_lanes, Arithmetic, Box4, Lane32,
    Simd, LANES, TINY,
};

/// A block's pieces, but for their boxes. All that a query reads of a block after these lies side by side.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C, align(64))]
pub struct PackedPieces {
    /// Corners, by half of the block, corner and lane: ten bits per axis (x lowest), as steps between the sides of what the
    /// piece's box in bytes may stand for.
    pub corners: [[[u32; LANES]; 4]; 2],
    /// The triangle of each piece.
    pub triangles: [u32; FANOUT],
}

impl PackedPieces {
    /// To be filled in.
    pub const ZERO: PackedPieces = PackedPieces { corners: [[[0; LANES]; 4]; 2], triangles: [0; FANOUT] };
}

/// The largest error of a corner of any piece of a block, per axis: as [`HalfBlock::slack`] for a box as large as the
/// block's own, and a hundredth for the quantisation of bytes beyond that.
#[inline(always)]
pub fn most_slack(node: &Node, slack: f32) -> [f32; 3] {
    let Box4 { lower, upper } = node.bounds();
    let mut most = [0.0; 3];
    for a in 0..3 {
        let side = 1.01 * (upper[a] - lower[a]) + 4.0 * UNPACK_ROUNDING;
        most[a] = side * (HALF_STEP / CORNER_STEPS) + UNPACK_ROUNDING + slack;
    }
    most
}

/// Steps between the sides of a piece's box.
const CORNER_STEPS: f32 = 1023.0;

/// Sixteen pieces of a block, in the frame.
#[derive(Debug, Clone)]
#[repr(C, align(64))]
pub struct HalfBlock {
    /// Bounds of the sides of their boxes in bytes.
    pub lower: [Lane32; 3],
    /// See `lower`.
    pub upper: [Lane32; 3],
    /// Their corners, by corner and axis.
    pub corners: [[Lane32; 3]; 4],
    /// How far the corners may be off, per axis, with the slack of the tool's placement.
    pub slack: [Lane32; 3],
    /// An axis across each piece's plane, of any length.
    pub normals: [Lane32; 3],
    /// The piece's interval along that axis, grown by all slack.
    pub near: Lane32,
    /// See `near`.
    pub far: Lane32,
}

impl HalfBlock {
    /// To be filled in.
    pub const ZERO: HalfBlock = HalfBlock {
        lower: [[0.0; LANES]; 3],
        upper: [[0.0; LANES]; 3],
        corners: [[[0.0; LANES]; 3]; 4],
        slack: [[0.0; LANES]; 3],
        normals: [[0.0; LANES]; 3],
        near: [0.0; LANES],
        far: [0.0; LANES],
    };

    /// Unpacks the boxes of half a block.
    #[inline(always)]
    pub fn unpack_boxes<S: Simd>(&mut self, s: S, node: &Node, half: usize) {
        node.unpack(s, half, &mut self.lower, &mut self.upper);
    }

    /// The same for few lanes of the half, from `first` on.
    #[inline(always)]
    pub fn unpack_boxes_few<S: Simd>(&mut self, s: S, node: &Node, at: (usize, usize)) {
        node.unpack_few(s, at, &mut self.lower, &mut self.upper);
    }

    /// One of the boxes.
    #[inline(always)]
    pub fn boxes_lane(&self, lane: usize) -> Box4 {
        let mut b = Box4 { lower: [0.0; 4], upper: [0.0; 4] };
        for a in 0..3 {
            b.lower[a] = self.lower[a][lane];
            b.upper[a] = self.upper[a][lane];
        }
        b
    }

    /// Unpacks the corners, after the boxes. `slack`: the error of coordinates beside that of packing.
    #[inline(always)]
    pub fn unpack_corners<S: Simd>(&mut self, s: S, packed: &PackedPieces, half: usize, slack: f32) {
        for first in (0..LANES).step_by(few_lanes::<S>()) {
            self.unpack_corners_few(s, packed, (half, first), slack);
        }
    }

    /// The same for few lanes of the half, from `first` on.
    #[inline(always)]
    pub fn unpack_corners_few<S: Simd>(
        &mut self,
        s: S,
        packed: &PackedPieces,
        (half, first): (usize, usize),
        slack: f32,
    ) {
        let part = s.part();
        let rounding = part.splat(UNPACK_ROUNDING + slack);
        for first in (first..first + few_lanes::<S>()).step_by(part_lanes::<S>()) {
            let mut at = [[rounding; 3]; 4];
            let mut off = [rounding; 3];
            for a in 0..3 {
                let lower = s.load_part(&self.lower[a], first);
                let step = (s.load_part(&self.upper[a], first) - lower) * part.splat(1.0 / CORNER_STEPS);
                for c in 0..4 {
                    at[c][a] = part.mul_add(s.widen_field(&packed.corners[half][c], first, a as u32), step, lower);
                    s.store_part(at[c][a], &mut self.corners[c][a], first);
                }
                off[a] = part.mul_add(step, part.splat(HALF_STEP), rounding);
                s.store_part(off[a], &mut self.slack[a], first);
            }
            // Across the diagonals.
            let u = [at[2][0] - at[0][0], at[2][1] - at[0][1], at[2][2] - at[0][2]];
            let v = [at[3][0] - at[1][0], at[3][1] - at[1][1], at[3][2] - at[1][2]];
            let n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
            let mut d = [rounding; 4];
            for c in 0..4 {
                d[c] = part.mul_add(n[0], at[c][0], part.mul_add(n[1], at[c][1], n[2] * at[c][2]));
            }
            let slack = part.mul_add(part.abs(n[2]), off[2], part.splat(TINY));
            let slack = part.mul_add(part.abs(n[0]), off[0], part.mul_add(part.abs(n[1]), off[1], slack));
            for a in 0..3 {
                s.store_part(n[a], &mut self.normals[a], first);
            }
            s.store_part(least4(part, &d) - slack, &mut self.near, first);
            s.store_part(greatest4(part, &d) + slack, &mut self.far, first);
        }
    }

    /// The interval of one piece along an axis in each lane, grown by all slack.
    ///
    /// An axis that keeps two intervals apart by more than their uncertainty is proof whatever the axis is, so its own
    /// rounding does not matter. A coordinate's error counts with the axis's entry in absolute value.
    #[inline(always)]
    pub fn along<S: Simd>(&self, s: S, piece: usize, n: &[S::F32; 3]) -> (S::F32, S::F32) {
        let (near, far) = self.corners_along(s, piece, n);
        let slack = s.mul_add(s.abs(n[2]), s.splat(self.slack[2][piece]), s.splat(TINY));
        let slack = s.mul_add(s.abs(n[1]), s.splat(self.slack[1][piece]), slack);
        let slack = s.mul_add(s.abs(n[0]), s.splat(self.slack[0][piece]), slack);
        (near - slack, far + slack)
    }

    /// The same as it comes, for who allows for the slack elsewhere: [`most_slack`].
    #[inline(always)]
    pub fn corners_along<S: Arithmetic>(&self, s: S, piece: usize, n: &[S::F32; 3]) -> (S::F32, S::F32) {
        let mut d = [n[0]; 4];
        for c in 0..4 {
            let at = [&self.corners[c][0], &self.corners[c][1], &self.corners[c][2]];
            let last = n[2] * s.splat(at[2][piece]);
            d[c] = s.mul_add(n[0], s.splat(at[0][piece]), s.mul_add(n[1], s.splat(at[1][piece]), last));
        }
        (least4(s, &d), greatest4(s, &d))
    }

    /// Which of another half's pieces the plane of either holds apart from one of this half's.
    #[inline(always)]
    pub fn held_apart<S: Simd>(&self, s: S, piece: usize, others: &HalfBlock) -> u16 {
        let (near, far) = others.interval(s, &self.normal(s, piece));
        let apart = s.above(near, s.splat(self.far[piece])) | s.above(s.splat(self.near[piece]), far);
        let n = load3(s, &others.normals);
        let (near, far) = self.along(s, piece, &n);
        s.lanes(apart | s.above(near, s.load(&others.far)) | s.above(s.load(&others.near), far))
    }

    /// The intervals of all pieces along an axis, grown by all slack.
    #[inline(always)]
    pub fn interval<S: Simd>(&self, s: S, n: &[S::F32; 3]) -> (S::F32, S::F32) {
        let corners = [
            load3(s, &self.corners[0]),
            load3(s, &self.corners[1]),
            load3(s, &self.corners[2]),
            load3(s, &self.corners[3]),
        ];
        let (near, far) = along(s, &corners, n);
        let slack = s.mul_add(s.abs(n[2]), s.load(&self.slack[2]), s.splat(TINY));
        let slack = s.mul_add(s.abs(n[1]), s.load(&self.slack[1]), slack);
        let slack = s.mul_add(s.abs(n[0]), s.load(&self.slack[0]), slack);
        (near - slack, far + slack)
    }

    /// The axis across a piece's plane, in all lanes.
    #[inline(always)]
    pub fn normal<S: Arithmetic>(&self, s: S, piece: usize) -> [S::F32; 3] {
        [s.splat(self.normals[0][piece]), s.splat(self.normals[1][piece]), s.splat(self.normals[2][piece])]
    }

    /// Which of sixteen boxes, by their sides, overlap the box of one piece.
    #[inline(always)]
    pub fn boxes_meeting<S: Simd>(&self, s: S, lower: &[S::F32; 3], upper: &[S::F32; 3], piece: usize) -> u16 {
        let of_piece = [
            [s.splat(self.lower[0][piece]), s.splat(self.lower[1][piece]), s.splat(self.lower[2][piece])],
            [s.splat(self.upper[0][piece]), s.splat(self.upper[1][piece]), s.splat(self.upper[2][piece])],
        ];
        !s.lanes(boxes_apart(s, [lower, upper], [&of_piece[0], &of_piece[1]]))
    }

    /// The pieces' corners as steps between the sides of their boxes, by corner and lane.
    #[inline(always)]
    pub fn pack(&self, corners: &[[Lane32; 3]; 4]) -> [[u32; LANES]; 4] {
        let mut packed = [[0; LANES]; 4];
        for a in 0..3 {
            let mut per_unit = [0.0; LANES];
            for lane in 0..LANES {
                per_unit[lane] = CORNER_STEPS / (self.upper[a][lane] - self.lower[a][lane]);
            }
            for c in 0..4 {
                for lane in 0..LANES {
                    let step = (corners[c][a][lane] - self.lower[a][lane]) * per_unit[lane];
                    let step = least(greatest(step, 0.0), CORNER_STEPS);
                    // Adding 2^23 rounds to a whole number, which then stands in the lowest bits.
                    packed[c][lane] |= ((step + 8_388_608.0).to_bits() & CORNER_STEPS as u32) << (10 * a);
                }
            }
        }
        packed
    }
}

#[cfg(test)]
mod tests {
    use super::super::node::Children;
    use super::*;
    use feeler_lanes::{Kernel, Level};
    use proptest::prelude::*;

    /// Unpacks a block of whole triangles: boxes, then corners from `packed` or none.
    struct Unpack<'a>(&'a Node, Option<&'a PackedPieces>, f32);

    impl Kernel for Unpack<'_> {
        type Output = [HalfBlock; 2];

        #[inline(always)]
        fn run<S: Simd>(self, s: S) -> [HalfBlock; 2] {
            let Unpack(node, packed, slack) = self;
            let mut halves = [HalfBlock::ZERO; 2];
            for half in 0..2 {
                halves[half].unpack_boxes(s, node, half);
                if let Some(packed) = packed {
                    halves[half].unpack_corners(s, packed, half, slack);
                }
            }
            halves
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(500))]
        #[test]
        fn unpacked_corners_and_intervals_are_within_their_slack(
            pieces in prop::collection::vec(prop::array::uniform4(prop::array::uniform3(0.0f32..1.0)), 1..=32),
            size in prop_oneof![Just(1.0f32), Just(1e-2), Just(1e-5), Just(0.0)],
        ) {
            let pieces: Vec<_> = pieces.iter().map(|p| p.map(|c| c.map(|x| 0.4 + size * x * 0.5))).collect();
            let boxes: Vec<Box4> = pieces.iter().map(|p| {
                let mut b = Box4::EMPTY;
                for c in p {
                    b = b.union(&Box4 { lower: [c[0], c[1], c[2], 0.0], upper: [c[0], c[1], c[2], 0.0] });
                }
                b
            }).collect();
            let node = Node::new(&Children::of(boxes.iter().copied()), boxes.len(), 0);
            // Packed at one level, unpacked at another: they may round differently.
            for (by, level) in Level::available().into_iter().flat_map(|l| [(Level::Portable, l), (l, Level::Portable)]) {
                let halves = by.checked().run(Unpack(&node, None, 0.0));
                let mut packed = PackedPieces::ZERO;
                for half in 0..2 {
                    let mut corners = [[[0.0; LANES]; 3]; 4];
                    for (lane, piece) in pieces.iter().skip(LANES * half).take(LANES).enumerate() {
                        (0..12).for_each(|k| corners[k / 3][k % 3][lane] = piece[k / 3][k % 3]);
                    }
                    packed.corners[half] = halves[half].pack(&corners);
                }
                let halves = level.checked().run(Unpack(&node, Some(&packed), 0.0));
                for (i, piece) in pieces.iter().enumerate() {
                    let (half, lane) = (&halves[i / LANES], i % LANES);
                    for (c, corner) in piece.iter().enumerate() {
                        let mut along = 0.0;
                        for a in 0..3 {
                            let (x, slack) = (half.corners[c][a][lane], half.slack[a][lane]);
                            prop_assert!((x - corner[a]).abs() <= slack, "{x} for {}, slack {slack}", corner[a]);
                            prop_assert!(half.lower[a][lane] <= corner[a] && corner[a] <= half.upper[a][lane]);
                            prop_assert!(slack <= most_slack(&node, 0.0)[a], "{slack}");
                            along += f64::from(half.normals[a][lane]) * f64::from(corner[a]);
                        }
                        prop_assert!(f64::from(half.near[lane]) <= along && along <= f64::from(half.far[lane]));
                    }
                }
            }
        }
    }
}
