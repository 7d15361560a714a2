//! Nodes that hold 32 boxes in bytes: sides as steps of a 255th of the node's own box, rounded outwards.

use bytemuck::{Pod, Zeroable};

use crate::constants::{HALF_STEP, UNPACK_ROUNDING};
use crate::geometry::bounds::{Aabb, Point};
use feeler_lanes::{
    few_lanes, greatest, least, part_lanes, Arithmetic, Box4, ByteBoxes, Lane32, LaneBoxes, Simd, LANES,
};

/// Children of a node.
pub const FANOUT: usize = 32;

/// World to float32: the box of the mock-up scaled by a power of two to lengths of at most 1.
#[derive(Debug, Clone, Copy)]
pub struct Frame {
    /// Lower corner of the mock-up, metres.
    pub origin: [f64; 3],
    /// Frame units per metre.
    pub scale: f64,
}

/// The boxes of up to 32 children, lane by lane; those that are not there contain nothing.
#[derive(Debug, Clone)]
pub struct Children {
    /// Lower sides.
    pub lower: [[f32; FANOUT]; 3],
    /// Upper sides.
    pub upper: [[f32; FANOUT]; 3],
}

/// 32 boxes as bytes relative to the node's own box.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C, align(64))]
pub struct Node {
    boxes: ByteBoxes,
    /// The sides of the box around all children, padded; `boxes.origin` is its lower side.
    upper: [f32; 4],
    /// Which children exist.
    pub valid: u32,
    /// In a block: which pieces belong to triangles with several.
    pub cut: u32,
    /// Up to the next cache line; zero.
    rest: [u32; 2],
}

impl Frame {
    /// A frame over the mock-up's box.
    pub fn new(bounds: &Aabb) -> Frame {
        let longest = bounds.extent().iter().fold(0.0f64, |m, x| m.max(*x));
        // The power of two at or above the longest side; scaling by it does not round.
        let exponent = if longest > 0.0 { longest.log2().ceil().clamp(-900.0, 900.0) } else { 0.0 };
        Frame { origin: bounds.lower, scale: (-exponent).exp2() }
    }

    /// A point in the frame.
    #[inline]
    pub fn point(self, p: &Point) -> [f32; 3] {
        std::array::from_fn(|a| ((p[a] - self.origin[a]) * self.scale) as f32)
    }

    /// A box in the frame.
    #[inline]
    pub fn to_box4(self, b: &Aabb) -> Box4 {
        let ([lx, ly, lz], [ux, uy, uz]) = (self.point(&b.lower), self.point(&b.upper));
        Box4 { lower: [lx, ly, lz, 0.0], upper: [ux, uy, uz, 0.0] }
    }
}

impl Children {
    /// None yet.
    pub const NONE: Children =
        Children { lower: [[f32::INFINITY; FANOUT]; 3], upper: [[f32::NEG_INFINITY; FANOUT]; 3] };

    /// Leaves the first `count`.
    #[inline(always)]
    pub fn truncate(&mut self, count: usize) {
        for a in 0..3 {
            self.lower[a][count..].fill(f32::INFINITY);
            self.upper[a][count..].fill(f32::NEG_INFINITY);
        }
    }

    /// At most 32 boxes.
    pub fn of(boxes: impl Iterator<Item = Box4>) -> Children {
        let mut children = Children::NONE;
        for (i, b) in boxes.enumerate() {
            for a in 0..3 {
                children.lower[a][i] = b.lower[a];
                children.upper[a][i] = b.upper[a];
            }
        }
        children
    }
}

impl Node {
    /// A node over the first `count` children; there are no others.
    #[inline(always)]
    pub fn new(children: &Children, count: usize, cut: u32) -> Node {
        let (mut lower, mut upper) = ([0.0; 4], [0.0; 4]);
        let mut per_unit = [0.0; 4];
        for a in 0..3 {
            (lower[a], upper[a]) = (f32::INFINITY, f32::NEG_INFINITY);
            for i in 0..FANOUT {
                lower[a] = least(lower[a], children.lower[a][i]);
                upper[a] = greatest(upper[a], children.upper[a][i]);
            }
            let scale = 255.0 / (upper[a] - lower[a]);
            // A node without extent has one byte value for everything.
            per_unit[a] = if scale.is_finite() { scale } else { 0.0 };
        }
        let mut boxes = ByteBoxes { sides: [[0; 2 * FANOUT]; 3], origin: lower, per_unit };
        for a in 0..3 {
            for i in 0..FANOUT {
                boxes.sides[a][i] = 255 - boxes.to_byte(children.lower[a][i], a);
            }
            for i in 0..FANOUT {
                boxes.sides[a][FANOUT + i] = boxes.to_byte(children.upper[a][i], a);
            }
        }
        Node { boxes, upper, valid: u32::MAX >> (FANOUT - count), cut, rest: [0; 2] }
    }

    /// The box around all children.
    pub fn bounds(&self) -> Box4 {
        Box4 { lower: self.boxes.origin, upper: self.upper }
    }

    /// Which children's boxes overlap a box.
    #[inline(always)]
    pub fn overlapping<S: Simd>(&self, s: S, b: &Box4) -> u32 {
        // Boxes outside would be clamped onto the node's rim and seem to meet the boxes there.
        if s.is_apart([&self.boxes.origin, &self.upper], [&b.lower, &b.upper]) {
            return 0;
        }
        self.overlapping_inside(s, b)
    }

    /// The same for a box that overlaps the node's own.
    #[inline(always)]
    pub fn overlapping_inside<S: Simd>(&self, s: S, b: &Box4) -> u32 {
        s.children_meeting(&self.boxes, [&b.lower, &b.upper]) & self.valid
    }

    /// Which lanes' boxes overlap the node's own.
    #[inline(always)]
    pub fn overlapping_lanes<S: Simd>(&self, s: S, boxes: &LaneBoxes) -> u16 {
        let [[lx, ly, lz, _], [ux, uy, uz, _]] = [self.boxes.origin, self.upper];
        boxes.meeting(s, &[lx, ly, lz], &[ux, uy, uz])
    }

    /// Unpacks half of the children's boxes: bounds of the sides that their bytes represent.
    #[inline(always)]
    pub fn unpack<S: Simd>(&self, s: S, half: usize, lower: &mut [Lane32; 3], upper: &mut [Lane32; 3]) {
        for first in (0..LANES).step_by(few_lanes::<S>()) {
            self.unpack_few(s, (half, first), lower, upper);
        }
    }

    /// The same for few lanes of the half, from `first` on.
    #[inline(always)]
    pub fn unpack_few<S: Simd>(
        &self,
        s: S,
        (half, first): (usize, usize),
        lower: &mut [Lane32; 3],
        upper: &mut [Lane32; 3],
    ) {
        let part = s.part();
        for a in 0..3 {
            let origin = self.boxes.origin[a];
            let unit = part.splat((self.upper[a] - origin) * (1.0 / 255.0));
            let (from, to) = (part.splat(origin - UNPACK_ROUNDING), part.splat(origin + UNPACK_ROUNDING));
            for at in (first..first + few_lanes::<S>()).step_by(part_lanes::<S>()) {
                let low = s.widen_bytes(sixteen(&self.boxes.sides[a], LANES * half), at);
                let high = s.widen_bytes(sixteen(&self.boxes.sides[a], FANOUT + LANES * half), at);
                s.store_part(part.mul_add(part.splat(255.0 - HALF_STEP) - low, unit, from), &mut lower[a], at);
                s.store_part(part.mul_add(high + part.splat(HALF_STEP), unit, to), &mut upper[a], at);
            }
        }
    }

    /// The boxes, for unpacking.
    #[inline(always)]
    pub fn byte_boxes(&self) -> (&ByteBoxes, &[f32; 4]) {
        (&self.boxes, &self.upper)
    }
}

/// Sixteen of a node's bytes.
#[inline(always)]
fn sixteen(bytes: &[u8; 2 * FANOUT], from: usize) -> &[u8; LANES] {
    bytes[from..].first_chunk().expect("a multiple of 16 below 64")
}

#[cfg(test)]
mod tests {
    use super::*;
    use feeler_lanes::{Kernel, Level};
    use proptest::prelude::*;

    fn box4() -> impl Strategy<Value = Box4> {
        // A lattice, so that sides coincide often.
        let side = || prop_oneof![(-8i32..9).prop_map(|i| i as f32 / 8.0), -1.5f32..1.5];
        [side(), side(), side(), side(), side(), side()].prop_map(|s| Box4 {
            lower: [s[0].min(s[1]), s[2].min(s[3]), s[4].min(s[5]), 0.0],
            upper: [s[0].max(s[1]), s[2].max(s[3]), s[4].max(s[5]), 0.0],
        })
    }

    fn node_over(children: &[Box4]) -> Node {
        Node::new(&Children::of(children.iter().copied()), children.len(), 0)
    }

    fn is_meeting(p: &Box4, q: &Box4) -> bool {
        (0..3).all(|a| p.lower[a] <= q.upper[a] && q.lower[a] <= p.upper[a])
    }

    /// Which children meet a box, and whether the node's own box does as seen from lane 5 of 16.
    struct Test<'a>(&'a Node, &'a Box4);

    impl Kernel for Test<'_> {
        type Output = (u32, bool);

        #[inline(always)]
        fn run<S: Simd>(self, s: S) -> (u32, bool) {
            let mut lanes = LaneBoxes::ZERO;
            lanes.set(5, self.1);
            (self.0.overlapping(s, self.1), self.0.overlapping_lanes(s, &lanes) >> 5 & 1 == 1)
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(3_000))]
        #[test]
        fn a_meeting_child_is_never_missed(children in prop::collection::vec(box4(), 1..=32), query in box4()) {
            let node = node_over(&children);
            let (found, own) = Level::Portable.checked().run(Test(&node, &query));
            for level in Level::available() {
                prop_assert_eq!(level.checked().run(Test(&node, &query)), (found, own), "{}", level.name());
            }
            prop_assert_eq!(own, is_meeting(&node.bounds(), &query));
            for (i, child) in children.iter().enumerate() {
                prop_assert!(!is_meeting(child, &query) || found >> i & 1 == 1);
            }
            prop_assert!(found & !node.valid == 0);
            // Nothing a whole byte away is kept.
            for (i, child) in children.iter().enumerate() {
                let byte = |a: usize| 2.0 * (node.bounds().upper[a] - node.bounds().lower[a]) / 255.0;
                if (0..3).any(|a| child.lower[a] > query.upper[a] + byte(a) || query.lower[a] > child.upper[a] + byte(a)) {
                    prop_assert!(found >> i & 1 == 0);
                }
            }
        }
    }

    /// Which of sixteen boxes meet each child, in bytes.
    struct TestLanes<'a>(&'a Node, &'a [Box4]);

    impl Kernel for TestLanes<'_> {
        type Output = [u16; FANOUT];

        #[inline(always)]
        fn run<S: Simd>(self, s: S) -> [u16; FANOUT] {
            let mut boxes = LaneBoxes::ZERO;
            for i in 0..LANES {
                boxes.set(i, &self.1[i]);
            }
            let children = self.0.byte_boxes().0;
            let lanes = s.in_bytes(children, [&boxes.lower, &boxes.upper]);
            let mut met = [0; FANOUT];
            for i in 0..FANOUT {
                met[i] = s.lanes_meeting(&lanes, children, i) & !lanes.outside;
            }
            met
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2_000))]
        #[test]
        fn no_lane_that_meets_a_child_is_missed(
            children in prop::collection::vec(box4(), 1..=32),
            queries in prop::collection::vec(box4(), LANES),
            far in prop_oneof![Just(0.0f32), Just(3.0), Just(1e30), Just(f32::INFINITY)],
            size in prop_oneof![Just(1.0f32), Just(1e-3), Just(1e-20), Just(0.0)],
        ) {
            let children: Vec<Box4> = children
                .iter()
                .map(|b| Box4 { lower: b.lower.map(|x| x * size), upper: b.upper.map(|x| x * size) })
                .collect();
            let node = node_over(&children);
            // One beyond each side of the node, one around all.
            let mut queries = queries;
            for a in 0..3 {
                queries[2 * a].lower[a] += far;
                queries[2 * a].upper[a] += far;
                queries[2 * a + 1].lower[a] -= far;
                queries[2 * a + 1].upper[a] -= far;
            }
            queries[6] = Box4 { lower: [-far, -far, -far, 0.0], upper: [far, far, far, 0.0] };
            let found = Level::Portable.checked().run(TestLanes(&node, &queries));
            for level in Level::available() {
                prop_assert_eq!(level.checked().run(TestLanes(&node, &queries)), found, "{}", level.name());
            }
            let byte = |a: usize| 2.0 * (node.bounds().upper[a] - node.bounds().lower[a]) / 255.0;
            for (lane, query) in queries.iter().enumerate() {
                for (i, child) in children.iter().enumerate() {
                    prop_assert!(!is_meeting(child, query) || found[i] >> lane & 1 == 1);
                    // Nothing a whole byte away is kept, where the node has an extent.
                    if (0..3).any(|a| {
                        let gap = (child.lower[a] - query.upper[a]).max(query.lower[a] - child.upper[a]);
                        byte(a) > 1e-30 && gap > byte(a)
                    }) {
                        prop_assert!(found[i] >> lane & 1 == 0);
                    }
                }
            }
        }
    }

    #[test]
    fn a_node_without_extent_and_an_endless_query() {
        let cube = |from: f32, to: f32| Box4 { lower: [from, from, from, 0.0], upper: [to, to, to, 0.0] };
        let node = node_over(&[cube(0.25, 0.25)]);
        for level in Level::available() {
            let found = |b: Box4| level.checked().run(Test(&node, &b));
            assert_eq!(found(cube(0.25, 0.25)), (1, true));
            assert_eq!(found(cube(f32::NEG_INFINITY, f32::INFINITY)), (1, true));
            assert_eq!(found(cube(0.5, 0.5)), (0, false));
        }
    }
}
