//! Boxes in float32 and in bytes, and the nodes that hold 32 of them.

use crate::bounds::Aabb;
use crate::lanes::{LaneBoxes, LANES};

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

/// A box in the frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Box32 {
    /// Smallest coordinates.
    pub lower: [f32; 3],
    /// Largest coordinates.
    pub upper: [f32; 3],
}

/// A box in the bytes of one node: lower sides, and 255 minus upper sides.
pub type ByteBox = [[u8; 2]; 3];

/// 32 boxes as bytes relative to the node's own box.
#[derive(Debug, Clone)]
#[repr(C, align(64))]
pub struct Node {
    /// For each axis 32 lower sides, then 32 times 255 minus the upper side: "meets" is then "less or equal" throughout.
    sides: [[u8; 2 * FANOUT]; 3],
    bounds: Box32,
    /// Bytes per unit of length.
    per_unit: [f32; 3],
    /// Which children exist.
    pub valid: u32,
    /// In a block: which pieces belong to triangles with several.
    pub cut: u32,
}

impl Frame {
    /// A frame over the mock-up's box.
    pub fn new(bounds: &Aabb) -> Frame {
        let longest = bounds.extent().iter().fold(0.0f64, |m, x| m.max(*x));
        // The power of two at or above the longest side; scaling by it does not round.
        let exponent = if longest > 0.0 { longest.log2().ceil().clamp(-900.0, 900.0) } else { 0.0 };
        Frame { origin: bounds.lower, scale: (-exponent).exp2() }
    }

    /// A box in the frame.
    #[inline]
    pub fn to_box32(self, b: &Aabb) -> Box32 {
        let f = |x: f64, a: usize| ((x - self.origin[a]) * self.scale) as f32;
        Box32 { lower: std::array::from_fn(|a| f(b.lower[a], a)), upper: std::array::from_fn(|a| f(b.upper[a], a)) }
    }
}

impl Box32 {
    /// The box that contains nothing.
    pub const EMPTY: Box32 = Box32 { lower: [f32::INFINITY; 3], upper: [f32::NEG_INFINITY; 3] };

    /// The smallest box that contains both.
    #[inline]
    pub fn union(&self, other: &Box32) -> Box32 {
        Box32 {
            lower: std::array::from_fn(|a| self.lower[a].min(other.lower[a])),
            upper: std::array::from_fn(|a| self.upper[a].max(other.upper[a])),
        }
    }

    /// The box around all lanes.
    #[inline]
    pub fn around(lanes: &LaneBoxes) -> Box32 {
        let mut b = Box32::EMPTY;
        for a in 0..3 {
            for i in 0..lanes.count {
                // NaN lanes do not occur: a placement that is not finite makes infinite boxes.
                b.lower[a] = if lanes.lower[a][i] < b.lower[a] { lanes.lower[a][i] } else { b.lower[a] };
                b.upper[a] = if lanes.upper[a][i] > b.upper[a] { lanes.upper[a][i] } else { b.upper[a] };
            }
        }
        b
    }

    /// One of the lanes.
    #[inline]
    pub fn of_lane(lanes: &LaneBoxes, i: usize) -> Box32 {
        Box32 { lower: std::array::from_fn(|a| lanes.lower[a][i]), upper: std::array::from_fn(|a| lanes.upper[a][i]) }
    }
}

/// A byte that grows with `x`: 0 at `lower`, clamped at both ends. NaN (infinity in a node without extent) gives 0.
#[inline]
fn to_byte(x: f32, lower: f32, per_unit: f32) -> u8 {
    let t = (x - lower) * per_unit;
    let t = if t > 0.0 { t } else { 0.0 };
    let t = if t < 255.0 { t } else { 255.0 };
    // Adding 2^23 rounds to a whole number, which then stands in the lowest bits: a cast that every CPU does in lanes.
    (t + 8_388_608.0).to_bits() as u8
}

impl Node {
    /// A node over at most 32 children.
    pub fn new(children: &[Box32], cut: u32) -> Node {
        let bounds = children.iter().fold(Box32::EMPTY, |b, c| b.union(c));
        let per_unit = std::array::from_fn(|a| {
            let scale = 255.0 / (bounds.upper[a] - bounds.lower[a]);
            // A node without extent has one byte value for everything.
            if scale.is_finite() {
                scale
            } else {
                0.0
            }
        });
        let valid = u32::MAX >> (FANOUT - children.len());
        let mut node = Node { sides: [[0; 2 * FANOUT]; 3], bounds, per_unit, valid, cut };
        for (i, child) in children.iter().enumerate() {
            let bytes = node.to_bytes(child);
            for a in 0..3 {
                node.sides[a][i] = bytes[a][0];
                node.sides[a][FANOUT + i] = bytes[a][1];
            }
        }
        node
    }

    /// Bytes of a box relative to this node.
    #[inline]
    fn to_bytes(&self, b: &Box32) -> ByteBox {
        std::array::from_fn(|a| {
            let byte = |x: f32| to_byte(x, self.bounds.lower[a], self.per_unit[a]);
            [byte(b.lower[a]), 255 - byte(b.upper[a])]
        })
    }

    /// Which children's boxes meet a box.
    #[inline]
    pub fn overlapping(&self, b: &Box32) -> u32 {
        // What lies outside would be clamped onto the node's rim and seem to meet what is there.
        for a in 0..3 {
            if b.lower[a] > self.bounds.upper[a] || b.upper[a] < self.bounds.lower[a] {
                return 0;
            }
        }
        let q = self.to_bytes(b);
        let mut apart = [0u8; FANOUT];
        for a in 0..3 {
            // The child begins after the box ends, or ends before the box begins.
            let (before, after) = (255 - q[a][1], 255 - q[a][0]);
            for i in 0..FANOUT {
                apart[i] |= u8::from(self.sides[a][i] > before) | u8::from(self.sides[a][FANOUT + i] > after);
            }
        }
        !bits(&apart) & self.valid
    }

    /// Which lanes' boxes meet the node's own.
    #[inline]
    pub fn overlapping_lanes(&self, boxes: &LaneBoxes) -> u16 {
        let mut apart = [0u8; FANOUT];
        for a in 0..3 {
            let (lower, upper) = (self.bounds.lower[a], self.bounds.upper[a]);
            for i in 0..LANES {
                apart[i] |= u8::from(boxes.lower[a][i] > upper) | u8::from(boxes.upper[a][i] < lower);
            }
        }
        (!bits(&apart) & ((1 << boxes.count) - 1)) as u16
    }

    /// The bytes of one child's box.
    #[inline]
    pub fn child(&self, i: usize) -> ByteBox {
        std::array::from_fn(|a| [self.sides[a][i], self.sides[a][FANOUT + i]])
    }
}

/// Boxes side by side in the bytes of one node.
pub struct LaneBytes {
    lower: [[u8; LANES]; 3],
    upper: [[u8; LANES]; 3],
    valid: u32,
}

impl LaneBytes {
    /// Bytes of each lane's box relative to a node.
    #[inline]
    pub fn new(node: &Node, boxes: &LaneBoxes) -> LaneBytes {
        let mut bytes = LaneBytes { lower: [[0; LANES]; 3], upper: [[0; LANES]; 3], valid: (1 << boxes.count) - 1 };
        for a in 0..3 {
            let (lower, per_unit) = (node.bounds.lower[a], node.per_unit[a]);
            for i in 0..LANES {
                bytes.lower[a][i] = to_byte(boxes.lower[a][i], lower, per_unit);
                bytes.upper[a][i] = to_byte(boxes.upper[a][i], lower, per_unit);
            }
        }
        bytes
    }

    /// Which lanes meet a child's box.
    #[inline]
    pub fn overlapping(&self, child: &ByteBox) -> u32 {
        let mut apart = [0u8; FANOUT];
        for a in 0..3 {
            let (lower, upper) = (child[a][0], 255 - child[a][1]);
            for i in 0..LANES {
                apart[i] |= u8::from(lower > self.upper[a][i]) | u8::from(self.lower[a][i] > upper);
            }
        }
        !bits(&apart) & self.valid
    }
}

/// One bit per byte that is 1 (bytes are 0 or 1).
#[inline]
fn bits(flags: &[u8; FANOUT]) -> u32 {
    let mut mask = 0;
    for (i, eight) in flags.chunks_exact(8).enumerate() {
        let word = u64::from_le_bytes([eight[0], eight[1], eight[2], eight[3], eight[4], eight[5], eight[6], eight[7]]);
        // The product moves the lowest bit of byte n to bit 56 + n; no two terms meet.
        mask |= ((word.wrapping_mul(0x0102_0408_1020_4080) >> 56) as u32) << (8 * i);
    }
    mask
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn box32() -> impl Strategy<Value = Box32> {
        // A lattice, so that sides coincide often.
        let side = || prop_oneof![(-8i32..9).prop_map(|i| i as f32 / 8.0), -1.5f32..1.5];
        [side(), side(), side(), side(), side(), side()].prop_map(|s| Box32 {
            lower: [s[0].min(s[1]), s[2].min(s[3]), s[4].min(s[5])],
            upper: [s[0].max(s[1]), s[2].max(s[3]), s[4].max(s[5])],
        })
    }

    fn is_meeting(p: &Box32, q: &Box32) -> bool {
        (0..3).all(|a| p.lower[a] <= q.upper[a] && q.lower[a] <= p.upper[a])
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(3_000))]
        #[test]
        fn a_meeting_child_is_never_missed(children in prop::collection::vec(box32(), 1..=32), query in box32()) {
            let node = Node::new(&children, 0);
            let found = node.overlapping(&query);
            let mut lanes = LaneBoxes::EMPTY;
            lanes.count = 1;
            for a in 0..3 {
                lanes.lower[a][0] = query.lower[a];
                lanes.upper[a][0] = query.upper[a];
            }
            let bytes = LaneBytes::new(&node, &lanes);
            prop_assert_eq!(node.overlapping_lanes(&lanes) == 1, is_meeting(&node.bounds, &query));
            for (i, child) in children.iter().enumerate() {
                if is_meeting(child, &query) {
                    prop_assert!(found >> i & 1 == 1 && bytes.overlapping(&node.child(i)) == 1);
                }
            }
            prop_assert!(found & !node.valid == 0);
            // Nothing a whole byte away is kept.
            for (i, child) in children.iter().enumerate() {
                let byte = |a: usize| 2.0 * (node.bounds.upper[a] - node.bounds.lower[a]) / 255.0;
                if (0..3).any(|a| child.lower[a] > query.upper[a] + byte(a) || query.lower[a] > child.upper[a] + byte(a)) {
                    prop_assert!(found >> i & 1 == 0);
                }
            }
        }
    }

    #[test]
    fn a_node_without_extent_and_an_endless_query() {
        let point = Box32 { lower: [0.25; 3], upper: [0.25; 3] };
        let node = Node::new(&[point], 0);
        assert_eq!(node.overlapping(&point), 1);
        assert_eq!(node.overlapping(&Box32 { lower: [f32::NEG_INFINITY; 3], upper: [f32::INFINITY; 3] }), 1);
        assert_eq!(node.overlapping(&Box32 { lower: [0.5; 3], upper: [0.5; 3] }), 0);
    }
}
