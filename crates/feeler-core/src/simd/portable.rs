//! Arrays and loops: the plain twin of the other levels, and the one for CPUs without them.

use std::ops::{Add, Mul, Sub};

use super::{Arithmetic, ByteBoxes, Simd, LANES, WIDE_LANES};

/// The token of this level.
#[derive(Debug, Clone, Copy)]
pub struct Portable;

/// Lanes as an array.
#[derive(Debug, Clone, Copy)]
pub struct Array<T, const N: usize>([T; N]);

impl<T: Copy, const N: usize> Array<T, N> {
    #[inline(always)]
    fn map(self, f: impl Fn(T) -> T) -> Self {
        Array(std::array::from_fn(|i| f(self.0[i])))
    }

    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(T, T) -> T) -> Self {
        Array(std::array::from_fn(|i| f(self.0[i], other.0[i])))
    }
}

impl<T: Copy + Add<Output = T>, const N: usize> Add for Array<T, N> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.zip(other, |a, b| a + b)
    }
}

impl<T: Copy + Sub<Output = T>, const N: usize> Sub for Array<T, N> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.zip(other, |a, b| a - b)
    }
}

impl<T: Copy + Mul<Output = T>, const N: usize> Mul for Array<T, N> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.zip(other, |a, b| a * b)
    }
}

impl Arithmetic for Portable {
    const WIDE: usize = WIDE_LANES;
    type F32 = Array<f32, LANES>;
    type F64 = Array<f64, WIDE_LANES>;
    type M32 = u16;
    type M64 = [bool; WIDE_LANES];

    #[inline(always)]
    fn splat(self, x: f32) -> Self::F32 {
        Array([x; LANES])
    }
    #[inline(always)]
    fn mul_add(self, a: Self::F32, b: Self::F32, c: Self::F32) -> Self::F32 {
        a * b + c
    }
    #[inline(always)]
    fn min(self, a: Self::F32, b: Self::F32) -> Self::F32 {
        a.zip(b, |a, b| if a < b { a } else { b })
    }
    #[inline(always)]
    fn max(self, a: Self::F32, b: Self::F32) -> Self::F32 {
        a.zip(b, |a, b| if a > b { a } else { b })
    }
    #[inline(always)]
    fn abs(self, a: Self::F32) -> Self::F32 {
        a.map(f32::abs)
    }
    #[inline(always)]
    fn above(self, a: Self::F32, b: Self::F32) -> Self::M32 {
        let mut flags = [0u8; LANES];
        for i in 0..LANES {
            flags[i] = u8::from(a.0[i] > b.0[i]);
        }
        let [low, high] = [0, 8].map(|from| u16::from(gather(std::array::from_fn(|i| flags[from + i]))));
        low | high << 8
    }
    #[inline(always)]
    fn lanes(self, mask: Self::M32) -> u16 {
        mask
    }
    #[inline(always)]
    fn blend(self, mask: Self::M32, a: Self::F32, b: Self::F32) -> Self::F32 {
        let mut chosen = b;
        for i in 0..LANES {
            if mask >> i & 1 == 1 {
                chosen.0[i] = a.0[i];
            }
        }
        chosen
    }
    #[inline(always)]
    fn wide_splat(self, x: f64) -> Self::F64 {
        Array([x; WIDE_LANES])
    }
    #[inline(always)]
    fn wide_mul_add(self, a: Self::F64, b: Self::F64, c: Self::F64) -> Self::F64 {
        a * b + c
    }
    #[inline(always)]
    fn wide_mul_sub(self, a: Self::F64, b: Self::F64, c: Self::F64) -> Self::F64 {
        a * b - c
    }
    #[inline(always)]
    fn wide_abs(self, a: Self::F64) -> Self::F64 {
        a.map(f64::abs)
    }
    #[inline(always)]
    fn wide_min(self, a: Self::F64, b: Self::F64) -> Self::F64 {
        a.zip(b, |a, b| if a < b { a } else { b })
    }
    #[inline(always)]
    fn wide_divide(self, a: Self::F64, b: Self::F64) -> Self::F64 {
        a.zip(b, |a, b| a / b)
    }
    #[inline(always)]
    fn wide_max(self, a: Self::F64, b: Self::F64) -> Self::F64 {
        a.zip(b, |a, b| if a > b { a } else { b })
    }
    #[inline(always)]
    fn wide_above(self, a: Self::F64, b: Self::F64) -> Self::M64 {
        std::array::from_fn(|i| a.0[i] > b.0[i])
    }
    #[inline(always)]
    fn choose(self, mask: Self::M64, a: Self::F64, b: Self::F64) -> Self::F64 {
        Array(std::array::from_fn(|i| if mask[i] { a.0[i] } else { b.0[i] }))
    }
    #[inline(always)]
    fn differing(self, a: Self::M64, b: Self::M64) -> Self::M64 {
        std::array::from_fn(|i| a[i] ^ b[i])
    }
    #[inline(always)]
    fn both(self, a: Self::M64, b: Self::M64) -> Self::M64 {
        std::array::from_fn(|i| a[i] & b[i])
    }
    #[inline(always)]
    fn either(self, a: Self::M64, b: Self::M64) -> Self::M64 {
        std::array::from_fn(|i| a[i] | b[i])
    }
    #[inline(always)]
    fn bits(self, mask: Self::M64) -> u8 {
        gather(mask.map(u8::from))
    }
}

impl Simd for Portable {
    type Part = Portable;

    #[inline(always)]
    fn part(self) -> Portable {
        self
    }
    #[inline(always)]
    fn wide_points_part(self, x: [&[f64; 3]; WIDE_LANES]) -> [Self::F64; 3] {
        self.wide_points(x)
    }
    #[inline(always)]
    fn load(self, x: &[f32; LANES]) -> Self::F32 {
        Array(*x)
    }
    #[inline(always)]
    fn store(self, x: Self::F32, to: &mut [f32; LANES]) {
        *to = x.0;
    }
    #[inline(always)]
    fn widen_bytes(self, x: &[u8; LANES]) -> Self::F32 {
        Array(x.map(f32::from))
    }
    #[inline(always)]
    fn widen_field(self, x: &[u32; LANES], field: u32) -> Self::F32 {
        // As signed numbers, which every CPU converts in lanes.
        Array(x.map(|x| (x >> (10 * field) & 1023) as i32 as f32))
    }
    #[inline(always)]
    fn smallest3(self, x: &[Self::F32; 3]) -> [f32; 4] {
        let mut least = [f32::INFINITY, f32::INFINITY, f32::INFINITY, 0.0];
        for a in 0..3 {
            for i in 0..LANES {
                least[a] = if x[a].0[i] < least[a] { x[a].0[i] } else { least[a] };
            }
        }
        least
    }
    #[inline(always)]
    fn largest3(self, x: &[Self::F32; 3]) -> [f32; 4] {
        let mut greatest = [f32::NEG_INFINITY, f32::NEG_INFINITY, f32::NEG_INFINITY, 0.0];
        for a in 0..3 {
            for i in 0..LANES {
                greatest[a] = if x[a].0[i] > greatest[a] { x[a].0[i] } else { greatest[a] };
            }
        }
        greatest
    }
    #[inline(always)]
    fn transposed(self, x: &[Self::F32; 3], to: &mut [[f32; 4]; LANES]) {
        for i in 0..LANES {
            to[i] = [x[0].0[i], x[1].0[i], x[2].0[i], 0.0];
        }
    }
    #[inline(always)]
    fn is_apart(self, a: [&[f32; 4]; 2], b: [&[f32; 4]; 2]) -> bool {
        let mut apart = false;
        for i in 0..3 {
            apart |= (a[0][i] > b[1][i]) | (b[0][i] > a[1][i]);
        }
        apart
    }
    #[inline(always)]
    fn children_meeting(self, boxes: &ByteBoxes, b: [&[f32; 4]; 2]) -> u32 {
        let mut apart = [0u8; 32];
        for a in 0..3 {
            // The child begins after the box ends, or ends before the box begins.
            let (before, after) = (boxes.to_byte(b[1][a], a), 255 - boxes.to_byte(b[0][a], a));
            for i in 0..32 {
                apart[i] |= u8::from(boxes.sides[a][i] > before) | u8::from(boxes.sides[a][32 + i] > after);
            }
        }
        let eight = |from: usize| u32::from(gather(std::array::from_fn(|i| apart[from + i]))) << from;
        !(eight(0) | eight(8) | eight(16) | eight(24))
    }
    #[inline(always)]
    fn append(self, chosen: u16, from: &[u32; LANES], to: &mut [u32], at: usize) -> usize {
        let to = &mut to[at..at + LANES];
        let (mut rest, mut count) = (chosen, 0);
        while rest != 0 {
            to[count] = from[rest.trailing_zeros() as usize & (LANES - 1)];
            rest &= rest - 1;
            count += 1;
        }
        at + count
    }
    #[inline(always)]
    fn wide_load(self, x: &[f64; WIDE_LANES]) -> Self::F64 {
        Array(*x)
    }
    #[inline(always)]
    fn wide_store(self, x: Self::F64, to: &mut [f64; WIDE_LANES]) {
        *to = x.0;
    }
    #[inline(always)]
    fn wide_points(self, x: [&[f64; 3]; WIDE_LANES]) -> [Self::F64; 3] {
        let mut points = [Array([0.0; WIDE_LANES]); 3];
        for i in 0..WIDE_LANES {
            for a in 0..3 {
                points[a].0[i] = x[i][a];
            }
        }
        points
    }
}

/// One bit per byte (0 or 1).
#[inline(always)]
fn gather(flags: [u8; 8]) -> u8 {
    // The product moves the lowest bit of byte n to bit 56 + n; no two terms meet.
    (u64::from_le_bytes(flags).wrapping_mul(0x0102_0408_1020_4080) >> 56) as u8
}
