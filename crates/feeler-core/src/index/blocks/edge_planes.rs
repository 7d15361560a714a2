//! The outlines of a tool's pieces, projected along the coordinate axis that is nearest to their normal. A box beyond a
//! side of an outline is apart from the piece; separating planes miss many such boxes where the mock-up's pieces are
//! the smaller ones.
//!
//! These are separating axes across an edge and a coordinate axis, as for a triangle and a box (Akenine-Möller 2001).
//! As with planes, any axis that separates two intervals by more than their uncertainty is a proof.

use crate::tool::placement::PlacedPieces;
use feeler_lanes::{greatest4, load3, Arithmetic, Lane32, Simd, LANES, TINY};

use super::pieces::HalfBlock;

/// The planes and outlines of sixteen pieces: a box beside the plane, or beyond a side of the outline, is apart from a
/// piece.
#[derive(Debug)]
#[repr(C, align(64))]
pub struct Outlines {
    /// The intervals of the pieces across their planes, with all slack.
    pub near: Lane32,
    /// See `near`.
    pub far: Lane32,
    /// For each of three sides: an axis across it in the plane of the outline; minus the absolute values of that; and twice how
    /// far the piece reaches along the axis, with all slack.
    sides: [[Lane32; 5]; 3],
    /// Along which axis each outline is seen: the first, or the second, and else the third.
    along: [u16; 2],
}

/// The boxes of half a block: the sums and the differences of their sides.
#[derive(Debug)]
#[repr(C, align(64))]
pub struct Middles {
    sums: [Lane32; 3],
    differences: [Lane32; 3],
}

impl Middles {
    /// To be filled in.
    pub const ZERO: Middles = Middles { sums: [[0.0; LANES]; 3], differences: [[0.0; LANES]; 3] };

    /// From few boxes, from lane `first` on.
    #[inline(always)]
    pub fn make_few<S: Simd>(&mut self, s: S, boxes: &HalfBlock, first: usize) {
        for a in 0..3 {
            let (lower, upper) = (s.load_few(&boxes.lower[a], first), s.load_few(&boxes.upper[a], first));
            s.store_few(lower + upper, &mut self.sums[a], first);
            s.store_few(upper - lower, &mut self.differences[a], first);
        }
    }
}

/// The corners that each side of an outline joins. A piece of a triangle that was not cut has three sides; one of four
/// corners has another, which holds little apart.
const SIDES: [[usize; 2]; 3] = [[0, 1], [1, 2], [3, 0]];

impl Outlines {
    /// To be filled in.
    pub const ZERO: Outlines =
        Outlines { near: [0.0; LANES], far: [0.0; LANES], sides: [[[0.0; LANES]; 5]; 3], along: [0; 2] };

    /// For pieces with known normals. `slack`: the largest error of coordinates, per axis, for planes and for boxes.
    #[inline(always)]
    pub fn make<S: Simd>(&mut self, s: S, pieces: &PlacedPieces, of_corners: &[f32; 3], of_boxes: f32) {
        let n = load3(s, &pieces.normals);
        let size = [s.abs(n[0]), s.abs(n[1]), s.abs(n[2])];
        let slack = s.mul_add(size[2], s.splat(of_corners[2]), s.splat(TINY));
        let slack = s.mul_add(size[0], s.splat(of_corners[0]), s.mul_add(size[1], s.splat(of_corners[1]), slack));
        s.store(s.load(&pieces.near) - slack, &mut self.near);
        s.store(s.load(&pieces.far) + slack, &mut self.far);
        let not_first = s.above(size[1], size[0]) | s.above(size[2], size[0]);
        let third = s.above(size[2], size[1]);
        self.along = [!s.lanes(not_first), s.lanes(not_first) & !s.lanes(third)];
        let up = s.blend(not_first, s.blend(third, n[2], n[1]), n[0]);
        let corners = pieces.corners(s);
        let (mut u, mut v) = ([up; 4], [up; 4]);
        for c in 0..4 {
            let [x, y, z] = corners[c];
            u[c] = s.blend(not_first, s.blend(third, x, z), y);
            v[c] = s.blend(not_first, s.blend(third, y, x), z);
        }
        for (side, [from, to]) in self.sides.iter_mut().zip(SIDES) {
            let (across_u, across_v) = (up * (v[to] - v[from]), up * (u[from] - u[to]));
            let mut reach = [up; 4];
            for c in 0..4 {
                reach[c] = s.mul_add(across_u, u[c], across_v * v[c]);
            }
            let (size_u, size_v) = (s.abs(across_u), s.abs(across_v));
            let slack = s.mul_add(size_u + size_v, s.splat(of_boxes), s.splat(TINY));
            let reach = greatest4(s, &reach) + slack;
            s.store(across_u, &mut side[0]);
            s.store(across_v, &mut side[1]);
            s.store(s.splat(0.0) - size_u, &mut side[2]);
            s.store(s.splat(0.0) - size_v, &mut side[3]);
            s.store(reach + reach, &mut side[4]);
        }
    }

    /// Which of few boxes, from lane `from` on, lie beyond a side of one of the outlines.
    #[inline(always)]
    pub fn beyond<S: Simd>(&self, s: S, lane: usize, (boxes, from): (&Middles, usize)) -> <S::Few as Arithmetic>::M32 {
        let few = s.few();
        let (first, second) = (usize::from(self.along[0] >> lane & 1), usize::from(self.along[1] >> lane & 1));
        let (u, v) = (first + 2 * second, 1 + first - second);
        let (sum_u, sum_v) = (s.load_few(&boxes.sums[u], from), s.load_few(&boxes.sums[v], from));
        let difference_u = s.load_few(&boxes.differences[u], from);
        let difference_v = s.load_few(&boxes.differences[v], from);
        let none = few.splat(0.0);
        let mut beyond = few.above(none, none);
        for side in &self.sides {
            // Twice the least of a box along the axis. Its few roundings of 2^-24 are within the slack's 2^-20.
            let least = few.mul_add(sum_u, few.splat(side[0][lane]), sum_v * few.splat(side[1][lane]));
            let least = few.mul_add(difference_u, few.splat(side[2][lane]), least);
            let least = few.mul_add(difference_v, few.splat(side[3][lane]), least);
            beyond = beyond | few.above(least, few.splat(side[4][lane]));
        }
        beyond
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use feeler_lanes::{few_lanes, Kernel, Level};
    use proptest::prelude::*;

    /// Which of sixteen boxes lie beyond the outline of the first of sixteen pieces.
    struct Beyond<'a>(&'a PlacedPieces, &'a HalfBlock);

    impl Kernel for Beyond<'_> {
        type Output = u16;

        #[inline(always)]
        fn run<S: Simd>(self, s: S) -> u16 {
            let mut placed = self.0.clone();
            placed.need_normals(s);
            let (mut outlines, mut middles) = (Outlines::ZERO, Middles::ZERO);
            outlines.make(s, &placed, &[1e-6; 3], 1e-6);
            let mut beyond = 0;
            for first in (0..LANES).step_by(few_lanes::<S>()) {
                middles.make_few(s, self.1, first);
                beyond |= s.few().lanes(outlines.beyond(s, 0, (&middles, first))) << first;
            }
            beyond
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(3_000))]
        #[test]
        fn a_box_around_a_point_of_a_piece_is_never_beyond(
            corners in prop::array::uniform3(prop::array::uniform3(-1.0f32..1.0)),
            is_cut in any::<bool>(),
            weights in prop::collection::vec((0.0f32..1.0, 0.0f32..1.0), LANES),
            half in prop_oneof![Just(0.0f32), 0.0f32..0.1],
        ) {
            let [a, b, c] = corners;
            // A triangle, or it without the tip beyond the middle of its second and third side.
            let towards = |p: [f32; 3], q: [f32; 3], w: f32| -> [f32; 3] { std::array::from_fn(|i| p[i] + w * (q[i] - p[i])) };
            let corners = if is_cut { [a, b, towards(b, c, 0.5), towards(a, c, 0.5)] } else { [a, b, c, c] };
            let mut placed = PlacedPieces::ZERO;
            for (k, corner) in corners.iter().enumerate() {
                (0..3).for_each(|i| placed.corners[k][i] = [corner[i]; LANES]);
            }
            let mut boxes = HalfBlock::ZERO;
            for (lane, (v, w)) in weights.iter().enumerate() {
                let point = towards(towards(corners[0], corners[1], *v), towards(corners[3], corners[2], *v), *w);
                for i in 0..3 {
                    boxes.lower[i][lane] = point[i] - half;
                    boxes.upper[i][lane] = point[i] + half;
                }
            }
            for level in Level::available() {
                prop_assert_eq!(level.checked().run(Beyond(&placed, &boxes)), 0, "{}", level.name());
            }
        }
    }

    #[test]
    fn boxes_beyond_each_side_are_found() {
        let corners = [[0.0, 0.0, 0.0], [0.5, 0.0, 0.0], [0.0, 0.5, 0.0], [0.0, 0.5, 0.0]];
        let points = [[0.2, -0.1, 0.0], [0.4, 0.4, 0.0], [-0.1, 0.2, 0.0], [0.1, 0.1, 0.0]];
        for turn in 0..3 {
            let turned = |p: [f32; 3], i: usize| p[(i + turn) % 3];
            let (mut placed, mut boxes) = (PlacedPieces::ZERO, HalfBlock::ZERO);
            for i in 0..3 {
                (0..4).for_each(|k| placed.corners[k][i] = [turned(corners[k], i); LANES]);
                for lane in 0..LANES {
                    boxes.lower[i][lane] = turned(points[lane % 4], i) - 0.05;
                    boxes.upper[i][lane] = turned(points[lane % 4], i) + 0.05;
                }
            }
            for level in Level::available() {
                assert_eq!(level.checked().run(Beyond(&placed, &boxes)), 0x7777, "{}, {turn}", level.name());
            }
        }
    }
}
