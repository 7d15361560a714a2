//! Boxes and points in float32 lanes: sixteen side by side, or one padded to four axes.

use crate::simd::{Arithmetic, Simd, LANES};

/// One number a lane.
pub type Lane32 = [f32; LANES];

/// A box in a frame, padded to four axes; the fourth is zero.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C, align(16))]
pub struct Box4 {
    /// Smallest coordinates.
    pub lower: [f32; 4],
    /// Largest coordinates.
    pub upper: [f32; 4],
}

/// Axis-aligned boxes, by axis and lane.
#[derive(Debug, Clone)]
#[repr(C, align(64))]
pub struct LaneBoxes {
    /// Smallest coordinates.
    pub lower: [Lane32; 3],
    /// Largest coordinates.
    pub upper: [Lane32; 3],
}

/// Sixteen boxes one after the other.
#[derive(Debug, Clone)]
#[repr(C, align(64))]
pub struct SpreadBoxes {
    lower: [[f32; 4]; LANES],
    upper: [[f32; 4]; LANES],
}

impl SpreadBoxes {
    /// Boxes to be filled in.
    pub const ZERO: SpreadBoxes = SpreadBoxes { lower: [[0.0; 4]; LANES], upper: [[0.0; 4]; LANES] };

    /// One of them.
    #[inline(always)]
    pub fn lane(&self, i: usize) -> Box4 {
        Box4 { lower: self.lower[i], upper: self.upper[i] }
    }
}

impl Box4 {
    /// The box that contains nothing.
    pub const EMPTY: Box4 = Box4 {
        lower: [f32::INFINITY, f32::INFINITY, f32::INFINITY, 0.0],
        upper: [f32::NEG_INFINITY, f32::NEG_INFINITY, f32::NEG_INFINITY, 0.0],
    };

    /// The smallest box that contains both.
    #[inline]
    pub fn union(&self, other: &Box4) -> Box4 {
        Box4 {
            lower: std::array::from_fn(|a| self.lower[a].min(other.lower[a])),
            upper: std::array::from_fn(|a| self.upper[a].max(other.upper[a])),
        }
    }
}

impl LaneBoxes {
    /// Boxes to be filled in.
    pub const ZERO: LaneBoxes = LaneBoxes { lower: [[0.0; LANES]; 3], upper: [[0.0; LANES]; 3] };

    /// The boxes one after the other.
    #[inline(always)]
    pub fn spread<S: Simd>(&self, s: S, to: &mut SpreadBoxes) {
        s.transposed(&load3(s, &self.lower), &mut to.lower);
        s.transposed(&load3(s, &self.upper), &mut to.upper);
    }

    /// One of the lanes.
    #[inline]
    pub fn lane(&self, i: usize) -> Box4 {
        let mut b = Box4 { lower: [0.0; 4], upper: [0.0; 4] };
        for a in 0..3 {
            b.lower[a] = self.lower[a][i];
            b.upper[a] = self.upper[a][i];
        }
        b
    }

    /// Puts a box into a lane.
    #[inline(always)]
    pub fn set(&mut self, i: usize, b: &Box4) {
        for a in 0..3 {
            self.lower[a][i] = b.lower[a];
            self.upper[a][i] = b.upper[a];
        }
    }

    /// Which lanes share a point with a box.
    #[inline(always)]
    pub fn meeting<S: Simd>(&self, s: S, lower: &[f32; 3], upper: &[f32; 3]) -> u16 {
        let (own_lower, own_upper) = (load3(s, &self.lower), load3(s, &self.upper));
        !s.lanes(boxes_apart(s, [&own_lower, &own_upper], [&splat3(s, lower), &splat3(s, upper)]))
    }
}

// In kernels there are loops and functions instead of closures: a closure is a function of its own, compiled for the baseline
// CPU unless it is inlined.

/// Three arrays as lanes.
#[inline(always)]
pub fn load3<S: Simd>(s: S, x: &[Lane32; 3]) -> [S::F32; 3] {
    [s.load(&x[0]), s.load(&x[1]), s.load(&x[2])]
}

/// Few lanes of each, from lane `from` on.
#[inline(always)]
pub fn load_few3<S: Simd>(s: S, x: &[Lane32; 3], from: usize) -> [<S::Few as Arithmetic>::F32; 3] {
    [s.load_few(&x[0], from), s.load_few(&x[1], from), s.load_few(&x[2], from)]
}

/// Three numbers, each in all lanes.
#[inline(always)]
pub fn splat3<S: Simd>(s: S, x: &[f32; 3]) -> [S::F32; 3] {
    [s.splat(x[0]), s.splat(x[1]), s.splat(x[2])]
}

/// Whether on some axis one of two boxes, given by lower and upper sides, ends before the other begins.
#[inline(always)]
pub fn boxes_apart<S: Arithmetic>(s: S, a: [&[S::F32; 3]; 2], b: [&[S::F32; 3]; 2]) -> S::M32 {
    let mut apart = s.above(a[0][0], b[1][0]) | s.above(b[0][0], a[1][0]);
    for axis in 1..3 {
        apart = apart | s.above(a[0][axis], b[1][axis]) | s.above(b[0][axis], a[1][axis]);
    }
    apart
}

/// The interval of four corners along an axis.
#[inline(always)]
pub fn along<S: Arithmetic>(s: S, corners: &[[S::F32; 3]; 4], n: &[S::F32; 3]) -> (S::F32, S::F32) {
    let mut d = [n[0]; 4];
    for c in 0..4 {
        let at = &corners[c];
        d[c] = s.mul_add(n[0], at[0], s.mul_add(n[1], at[1], n[2] * at[2]));
    }
    (least4(s, &d), greatest4(s, &d))
}

/// The lesser of two numbers: `f32::min` allows for NaN, at a price.
#[inline(always)]
pub fn least(x: f32, y: f32) -> f32 {
    if x < y {
        x
    } else {
        y
    }
}

/// The greater of two numbers, like [`least`].
#[inline(always)]
pub fn greatest(x: f32, y: f32) -> f32 {
    if x > y {
        x
    } else {
        y
    }
}

/// The least of four, lane by lane.
#[inline(always)]
pub fn least4<S: Arithmetic>(s: S, x: &[S::F32; 4]) -> S::F32 {
    s.min(s.min(x[0], x[1]), s.min(x[2], x[3]))
}

/// The greatest of four, lane by lane.
#[inline(always)]
pub fn greatest4<S: Arithmetic>(s: S, x: &[S::F32; 4]) -> S::F32 {
    s.max(s.max(x[0], x[1]), s.max(x[2], x[3]))
}
