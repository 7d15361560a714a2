//! The vocabulary of kernels: lanes, and the operations that each level has on them.

use std::fmt::Debug;
use std::ops::{Add, BitOr, BitXor, Mul, Sub};

use bytemuck::{Pod, Zeroable};

/// Lanes of float32.
pub const LANES: usize = 16;
/// Lanes of float64.
pub const WIDE_LANES: usize = 8;

/// Eight float64 in one cache line: half of all unaligned reads in lanes span two, and take twice as long.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
#[repr(C, align(64))]
pub struct Wide(pub [f64; WIDE_LANES]);

impl std::ops::Deref for Wide {
    type Target = [f64; WIDE_LANES];

    #[inline(always)]
    fn deref(&self) -> &[f64; WIDE_LANES] {
        &self.0
    }
}

impl std::ops::DerefMut for Wide {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut [f64; WIDE_LANES] {
        &mut self.0
    }
}

/// Three float64 and ten float32 that are read together: one cache line.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
pub struct CacheLine {
    /// The float64.
    pub wide: [f64; 3],
    /// The float32.
    pub narrow: [f32; 10],
}

/// Lines in as many lanes as there are of float32: the float64 of the lower half of them and of the upper half, and the float32.
pub type LineLanes<A> = ([[<A as Arithmetic>::F64; 3]; 2], [<A as Arithmetic>::F32; 10]);

/// A piece of work in lanes. `run` must be `#[inline(always)]`, and so must everything it calls with lanes: only code
/// inlined into the entry of a level is compiled for that level.
pub trait Kernel {
    /// The result.
    type Output;
    /// Does the work.
    fn run<S: Simd>(self, s: S) -> Self::Output;
}

/// The boxes of 32 children in bytes.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub struct ByteBoxes {
    /// For each axis 32 times 255 minus the lower side, then 32 upper sides: the larger a byte, the more the box reaches.
    pub sides: [[u8; 64]; 3],
    /// Where byte 0 lies, and how many bytes a unit of length has. The fourth axis is not used.
    pub origin: [f32; 4],
    /// See `origin`.
    pub per_unit: [f32; 4],
}

impl ByteBoxes {
    /// A byte that grows with `x`, clamped at both ends. NaN (infinity where a unit has no bytes) gives 0.
    ///
    /// Each level rounds as this function does.
    #[inline(always)]
    pub fn to_byte(&self, x: f32, axis: usize) -> u8 {
        let t = (x - self.origin[axis]) * self.per_unit[axis];
        let t = if t > 0.0 { t } else { 0.0 };
        let t = if t < 255.0 { t } else { 255.0 };
        // Adding 2^23 rounds to a whole number, halves to even, which then stands in the lowest bits.
        (t + 8_388_608.0).to_bits() as u8
    }

    /// The same, unclamped but for -1 and 256, which stand for all that lies outside; and what NaN becomes.
    #[inline(always)]
    fn whole(&self, x: f32, axis: usize, of_nan: f32) -> i32 {
        let t = (x - self.origin[axis]) * self.per_unit[axis];
        let t = if t.is_nan() { of_nan } else { t };
        let t = if t > -1.0 { t } else { -1.0 };
        let t = if t < 256.0 { t } else { 256.0 };
        // Adding 1.5 times 2^23 rounds likewise, numbers below zero too.
        (t + 12_582_912.0).to_bits() as i32 - 0x4b40_0000
    }
}

/// Sixteen boxes in the bytes of a node, to be compared with its children one by one.
#[derive(Debug, Clone, PartialEq)]
#[repr(C, align(32))]
pub struct ByteLanes {
    /// For each axis and box, the least upper side of a child that overlaps it; then the least value of 255 minus its
    /// lower side.
    pub least: [[u8; 2 * LANES]; 3],
    /// Which boxes lie outside the bytes: clamped onto the rim, they seem to overlap the content there.
    pub outside: u16,
}

/// Numbers that [`Simd::sort_few`] sorts at most.
pub const FEW: usize = 4 * WIDE_LANES;

/// Moves the numbers at the places taken to the front, in their order; tells how many they are.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
pub(super) fn close_up(to: &mut [u64; FEW], taken: u32) -> usize {
    let count = taken.count_ones() as usize;
    // Mostly there is no gap.
    if taken != ((1u64 << count) - 1) as u32 {
        let mut rest = taken;
        for i in 0..count {
            to[i] = to[rest.trailing_zeros() as usize % FEW];
            rest &= rest - 1;
        }
    }
    count
}

/// Lane-wise operations: on sixteen float32 and eight float64, or the [part](Simd::Part) of them in one register.
/// Comparisons with NaN are false.
pub trait Arithmetic: Copy {
    /// Lanes of float64.
    const WIDE: usize;
    /// Lanes of float32.
    type F32: Copy + Add<Output = Self::F32> + Sub<Output = Self::F32> + Mul<Output = Self::F32>;
    /// Half as many lanes of float64.
    type F64: Copy + Add<Output = Self::F64> + Sub<Output = Self::F64> + Mul<Output = Self::F64>;
    /// A choice per float32 lane; `|` chooses the lanes of either, `^` those of exactly one.
    type M32: Copy + BitOr<Output = Self::M32> + BitXor<Output = Self::M32>;
    /// A choice per float64 lane.
    type M64: Copy;

    /// One number in all lanes.
    fn splat(self, x: f32) -> Self::F32;
    /// `a * b + c`, rounded once where the CPU can, twice elsewhere: only for what has a margin.
    fn mul_add(self, a: Self::F32, b: Self::F32, c: Self::F32) -> Self::F32;
    /// `a * b - c`, rounded likewise.
    fn mul_sub(self, a: Self::F32, b: Self::F32, c: Self::F32) -> Self::F32;
    /// `a` if it is smaller, else `b`: of two zeros `b`, and `b` if one of them is NaN.
    fn min(self, a: Self::F32, b: Self::F32) -> Self::F32;
    /// `a` if it is larger, else `b`.
    fn max(self, a: Self::F32, b: Self::F32) -> Self::F32;
    /// Absolute value.
    fn abs(self, a: Self::F32) -> Self::F32;
    /// The smaller of the absolute values; of no use with NaN.
    #[inline(always)]
    fn min_abs(self, a: Self::F32, b: Self::F32) -> Self::F32 {
        self.min(self.abs(a), self.abs(b))
    }
    /// The larger of the absolute values; of no use with NaN.
    #[inline(always)]
    fn max_abs(self, a: Self::F32, b: Self::F32) -> Self::F32 {
        self.max(self.abs(a), self.abs(b))
    }
    /// `a > b`.
    fn above(self, a: Self::F32, b: Self::F32) -> Self::M32;
    /// One bit a lane. Where choices are full lanes this takes several instructions: best once, of all that `|` joins.
    fn lanes(self, mask: Self::M32) -> u16;
    /// `a` where chosen, else `b`.
    fn blend(self, mask: Self::M32, a: Self::F32, b: Self::F32) -> Self::F32;
    /// The float32 nearest to each number: of the lower lanes, and of the upper ones.
    fn narrowed(self, low: Self::F64, high: Self::F64) -> Self::F32;
    /// One number in all lanes.
    fn wide_splat(self, x: f64) -> Self::F64;
    /// `a * b + c`, rounded once where the CPU can, twice elsewhere: only for what has a margin.
    fn wide_mul_add(self, a: Self::F64, b: Self::F64, c: Self::F64) -> Self::F64;
    /// `a * b - c`, rounded likewise.
    fn wide_mul_sub(self, a: Self::F64, b: Self::F64, c: Self::F64) -> Self::F64;
    /// Absolute value.
    fn wide_abs(self, a: Self::F64) -> Self::F64;
    /// `a` if it is smaller, else `b`: of two zeros `b`, and `b` if one of them is NaN.
    fn wide_min(self, a: Self::F64, b: Self::F64) -> Self::F64;
    /// `a / b`.
    fn wide_divide(self, a: Self::F64, b: Self::F64) -> Self::F64;
    /// `a` if it is larger, else `b`.
    fn wide_max(self, a: Self::F64, b: Self::F64) -> Self::F64;
    /// `a > b`.
    fn wide_above(self, a: Self::F64, b: Self::F64) -> Self::M64;
    /// `a` where chosen, else `b`.
    fn choose(self, mask: Self::M64, a: Self::F64, b: Self::F64) -> Self::F64;
    /// The one or the other, not both.
    fn differing(self, a: Self::M64, b: Self::M64) -> Self::M64;
    /// Both.
    fn both(self, a: Self::M64, b: Self::M64) -> Self::M64;
    /// Either or both.
    fn either(self, a: Self::M64, b: Self::M64) -> Self::M64;
    /// One bit a lane.
    fn bits(self, mask: Self::M64) -> u8;
}

/// The operations of one level.
pub trait Simd: Arithmetic {
    /// As many lanes as one register holds, for work that keeps many values at hand.
    type Part: Arithmetic;
    /// The token of a part.
    fn part(self) -> Self::Part;
    /// The lines at these places, the first as many as a part has lanes of float32. Panics where a place is none of the list.
    fn lines_part(self, list: &[CacheLine], at: &[u32]) -> LineLanes<Self::Part>;
    /// The corners by axis of the triangles at these places, given by the numbers of their corners; half as many. Panics likewise,
    /// and where a number is none of the points.
    fn faces_part(
        self,
        faces: &[[u32; 3]],
        points: &[[f64; 3]],
        at: &[u32],
    ) -> [[<Self::Part as Arithmetic>::F64; 3]; 3];

    /// As many lanes as are left out together where none of them has anything to do, for work on one piece after the other; all,
    /// where leaving out fewer brings nothing.
    type Few: Arithmetic;
    /// The token of few lanes.
    fn few(self) -> Self::Few;
    /// Few lanes of `x`, the first of them at `from`, a multiple of how many they are.
    fn load_few(self, x: &[f32; LANES], from: usize) -> <Self::Few as Arithmetic>::F32;
    /// The same the other way.
    fn store_few(self, x: <Self::Few as Arithmetic>::F32, to: &mut [f32; LANES], from: usize);
    /// A part of the lanes of `x`, the first of them at `from`, a multiple of how many they are.
    fn load_part(self, x: &[f32; LANES], from: usize) -> <Self::Part as Arithmetic>::F32;
    /// The same the other way.
    fn store_part(self, x: <Self::Part as Arithmetic>::F32, to: &mut [f32; LANES], from: usize);
    /// As many bytes as a part has lanes, as numbers, from `x[from]` on.
    fn widen_bytes(self, x: &[u8; LANES], from: usize) -> <Self::Part as Arithmetic>::F32;
    /// Ten bits of as many numbers, from bit `10 * field` up, as numbers; from `x[from]` on.
    fn widen_field(self, x: &[u32; LANES], from: usize, field: u32) -> <Self::Part as Arithmetic>::F32;

    /// Lane `i` is `x[i]`.
    fn load(self, x: &[f32; LANES]) -> Self::F32;
    /// The lanes.
    fn store(self, x: Self::F32, to: &mut [f32; LANES]);
    /// The least of all lanes of each of three values; the fourth is zero. Of no use with NaN; a zero may have either sign.
    fn smallest3(self, x: &[Self::F32; 3]) -> [f32; 4];
    /// The greatest of all lanes of each of three values; the fourth is zero. See [`Simd::smallest3`].
    fn largest3(self, x: &[Self::F32; 3]) -> [f32; 4];
    /// Lane by lane, three values and zero.
    fn transposed(self, x: &[Self::F32; 3], to: &mut [[f32; 4]; LANES]);
    /// Whether on some axis one of two boxes, given by lower and upper sides, ends before the other begins.
    fn is_apart(self, a: [&[f32; 4]; 2], b: [&[f32; 4]; 2]) -> bool;
    /// One bit for each of 32 children whose box meets the box `b` (lower and upper sides): see [`ByteBoxes`].
    fn children_meeting(self, boxes: &ByteBoxes, b: [&[f32; 4]; 2]) -> u32;
    /// Whether sixteen boxes are compared with one child in bytes: not where float32 takes no more instructions. The next two
    /// are the same at each level.
    const IN_BYTES: bool = false;
    /// Boxes, given by lower and upper sides, in a node's bytes.
    #[inline(always)]
    fn in_bytes(self, boxes: &ByteBoxes, b: [&[[f32; LANES]; 3]; 2]) -> ByteLanes {
        let mut lanes = ByteLanes { least: [[0; 2 * LANES]; 3], outside: 0 };
        let mut outside = [0u8; LANES];
        for a in 0..3 {
            for i in 0..LANES {
                let lower = boxes.whole(b[0][a][i], a, -1.0);
                let upper = boxes.whole(b[1][a][i], a, 256.0);
                lanes.least[a][i] = lower.clamp(0, 255) as u8;
                lanes.least[a][LANES + i] = 255 - upper.clamp(0, 255) as u8;
                outside[i] |= u8::from(lower > 255) | u8::from(upper < 0);
            }
        }
        lanes.outside = gather16(&outside);
        lanes
    }
    /// Which of sixteen boxes meet child `i`, if not outside.
    #[inline(always)]
    fn lanes_meeting(self, lanes: &ByteLanes, boxes: &ByteBoxes, i: usize) -> u16 {
        let mut below = [0u8; LANES];
        for a in 0..3 {
            let (lower, upper) = (boxes.sides[a][i % 32], boxes.sides[a][32 + i % 32]);
            for lane in 0..LANES {
                below[lane] |= u8::from(upper < lanes.least[a][lane]) | u8::from(lower < lanes.least[a][LANES + lane]);
            }
        }
        !gather16(&below)
    }
    /// Writes the chosen numbers one after the other to `to[at..]`, and anything to what follows, up to 16 in all; returns the
    /// place after the last one chosen. `to` must have 16 places from `at`.
    fn append(self, chosen: u16, from: &[u32; LANES], to: &mut [u32], at: usize) -> usize;
    /// The same for eight numbers twice as wide.
    #[inline(always)]
    fn append_wide(self, chosen: u8, from: &[u64; WIDE_LANES], to: &mut [u64], at: usize) -> usize {
        let to = &mut to[at..at + WIDE_LANES];
        let mut count = 0;
        for lane in 0..WIDE_LANES {
            to[count] = from[lane];
            count += usize::from(chosen >> lane & 1 == 1);
        }
        at + count
    }
    /// Whether the next two are done without branches.
    const SORTS: bool = false;
    /// Moves the numbers that are not above a pivot, which is below `u64::MAX`, to the front; returns how many they are. `room` is
    /// overwritten: it needs as many places as `keys`, and [`WIDE_LANES`] more.
    #[inline(always)]
    fn partition(self, keys: &mut [u64], room: &mut [u64], pivot: u64) -> usize {
        let (mut low, mut high) = (0, 0);
        for i in 0..keys.len() {
            let key = keys[i];
            (keys[low], room[high]) = (key, key);
            low += usize::from(key <= pivot);
            high += usize::from(key > pivot);
        }
        keys[low..].copy_from_slice(&room[..high]);
        low
    }
    /// Up to [`FEW`] numbers below `u64::MAX` in order, each once; returns how many these are. What follows them is of no use.
    #[inline(always)]
    fn sort_few(self, keys: &[u64], to: &mut [u64; FEW]) -> usize {
        let to = &mut to[..keys.len()];
        to.copy_from_slice(keys);
        to.sort_unstable();
        let mut count = 0;
        for i in 0..to.len() {
            if i == 0 || to[i] != to[count - 1] {
                to[count] = to[i];
                count += 1;
            }
        }
        count
    }
    /// Lane `i` is `x[i]`.
    fn wide_load(self, x: &[f64; WIDE_LANES]) -> Self::F64;
    /// The lanes.
    fn wide_store(self, x: Self::F64, to: &mut [f64; WIDE_LANES]);
    /// Eight points by axis: lane `i` of each is of `x[i]`.
    fn wide_points(self, x: [&[f64; 3]; WIDE_LANES]) -> [Self::F64; 3];
}

/// How many lanes a part has: those of [`Simd::Part`].
#[inline(always)]
pub const fn part_lanes<S: Simd>() -> usize {
    2 * <S::Part as Arithmetic>::WIDE
}

/// How many lanes are few: those of [`Simd::Few`].
#[inline(always)]
pub const fn few_lanes<S: Simd>() -> usize {
    2 * <S::Few as Arithmetic>::WIDE
}

/// One bit per byte (0 or 1), of sixteen.
#[inline(always)]
pub(super) fn gather16(flags: &[u8; LANES]) -> u16 {
    let eight = |from: usize| gather(std::array::from_fn(|i| flags[from + i]));
    u16::from_le_bytes([eight(0), eight(8)])
}

/// One bit per byte (0 or 1).
#[inline(always)]
pub(super) fn gather(flags: [u8; 8]) -> u8 {
    // The product moves the lowest bit of byte n to bit 56 + n; no two terms meet.
    (u64::from_le_bytes(flags).wrapping_mul(0x0102_0408_1020_4080) >> 56) as u8
}
