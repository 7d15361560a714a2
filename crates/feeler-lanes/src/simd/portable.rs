//! Arrays and loops: the plain twin of the other levels, and the one for CPUs without them.

use std::ops::{Add, BitOr, BitXor, Mul, Sub};

use super::arithmetic::{gather, Arithmetic, ByteBoxes, CacheLine, LineLanes, Simd, LANES, WIDE_LANES};

/// Lanes of float32, and of float64.
#[derive(Debug, Clone, Copy)]
pub struct Arrays<const F: usize, const W: usize>;

/// All lanes.
type Portable = Arrays<LANES, WIDE_LANES>;
/// The token of this level.
pub const TOKEN: Portable = Arrays;
/// Of a part: as many lanes as most CPUs have in a register.
type Register = Arrays<4, 2>;

/// Lanes as an array.
#[derive(Debug, Clone, Copy)]
pub struct Array<T, const N: usize>([T; N]);

impl<T: Copy, const N: usize> Array<T, N> {
    #[inline(always)]
    fn map(self, f: impl Fn(T) -> T) -> Self {
        let mut out = self;
        for i in 0..N {
            out.0[i] = f(self.0[i]);
        }
        out
    }

    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(T, T) -> T) -> Self {
        let mut out = self;
        for i in 0..N {
            out.0[i] = f(self.0[i], other.0[i]);
        }
        out
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

impl<const N: usize> BitOr for Array<u32, N> {
    type Output = Self;
    #[inline(always)]
    fn bitor(self, other: Self) -> Self {
        self.zip(other, |a, b| a | b)
    }
}

impl<const N: usize> BitXor for Array<u32, N> {
    type Output = Self;
    #[inline(always)]
    fn bitxor(self, other: Self) -> Self {
        self.zip(other, |a, b| a ^ b)
    }
}

// Choices are all ones or zeros, as wide as the numbers chosen: so compilers find the CPU's own comparisons in lanes.
impl<const F: usize, const W: usize> Arithmetic for Arrays<F, W> {
    const WIDE: usize = W;
    type F32 = Array<f32, F>;
    type F64 = Array<f64, W>;
    type M32 = Array<u32, F>;
    type M64 = Array<u64, W>;

    #[inline(always)]
    fn splat(self, x: f32) -> Self::F32 {
        Array([x; F])
    }
    #[inline(always)]
    fn mul_add(self, a: Self::F32, b: Self::F32, c: Self::F32) -> Self::F32 {
        a * b + c
    }
    #[inline(always)]
    fn mul_sub(self, a: Self::F32, b: Self::F32, c: Self::F32) -> Self::F32 {
        a * b - c
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
        let mut mask = [0; F];
        for i in 0..F {
            mask[i] = u32::from(a.0[i] > b.0[i]).wrapping_neg();
        }
        Array(mask)
    }
    #[inline(always)]
    fn lanes(self, mask: Self::M32) -> u16 {
        let mut bits = 0;
        for (i, eight) in mask.0.chunks(8).enumerate() {
            let mut flags = [0u8; 8];
            for (flag, lane) in flags.iter_mut().zip(eight) {
                *flag = *lane as u8 & 1;
            }
            bits |= u16::from(gather(flags)) << (8 * i);
        }
        bits
    }
    #[inline(always)]
    fn blend(self, mask: Self::M32, a: Self::F32, b: Self::F32) -> Self::F32 {
        let mut chosen = b;
        for i in 0..F {
            chosen.0[i] = f32::from_bits(a.0[i].to_bits() & mask.0[i] | b.0[i].to_bits() & !mask.0[i]);
        }
        chosen
    }
    #[inline(always)]
    fn narrowed(self, low: Self::F64, high: Self::F64) -> Self::F32 {
        let mut narrow = [0.0; F];
        for i in 0..W {
            (narrow[i], narrow[W + i]) = (low.0[i] as f32, high.0[i] as f32);
        }
        Array(narrow)
    }
    #[inline(always)]
    fn wide_splat(self, x: f64) -> Self::F64 {
        Array([x; W])
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
        let mut mask = [0; W];
        for i in 0..W {
            mask[i] = u64::from(a.0[i] > b.0[i]).wrapping_neg();
        }
        Array(mask)
    }
    #[inline(always)]
    fn choose(self, mask: Self::M64, a: Self::F64, b: Self::F64) -> Self::F64 {
        let mut chosen = b;
        for i in 0..W {
            chosen.0[i] = f64::from_bits(a.0[i].to_bits() & mask.0[i] | b.0[i].to_bits() & !mask.0[i]);
        }
        chosen
    }
    #[inline(always)]
    fn differing(self, a: Self::M64, b: Self::M64) -> Self::M64 {
        a.zip(b, |a, b| a ^ b)
    }
    #[inline(always)]
    fn both(self, a: Self::M64, b: Self::M64) -> Self::M64 {
        a.zip(b, |a, b| a & b)
    }
    #[inline(always)]
    fn either(self, a: Self::M64, b: Self::M64) -> Self::M64 {
        a.zip(b, |a, b| a | b)
    }
    #[inline(always)]
    fn bits(self, mask: Self::M64) -> u8 {
        let mut flags = [0u8; WIDE_LANES];
        for i in 0..W {
            flags[i] = mask.0[i] as u8 & 1;
        }
        gather(flags)
    }
}

impl Simd for Portable {
    type Part = Register;
    type Few = Register;

    #[inline(always)]
    fn part(self) -> Register {
        Arrays
    }
    #[inline(always)]
    fn lines_part(self, list: &[CacheLine], at: &[u32]) -> LineLanes<Register> {
        let (mut wide, mut narrow) = ([[Array([0.0; 2]); 3]; 2], [Array([0.0; 4]); 10]);
        for i in 0..4 {
            let line = &list[at[i] as usize];
            for a in 0..3 {
                wide[i / 2][a].0[i % 2] = line.wide[a];
            }
            for k in 0..10 {
                narrow[k].0[i] = line.narrow[k];
            }
        }
        (wide, narrow)
    }
    #[inline(always)]
    fn faces_part(self, faces: &[[u32; 3]], points: &[[f64; 3]], at: &[u32]) -> [[Array<f64, 2>; 3]; 3] {
        let mut corners = [[Array([0.0; 2]); 3]; 3];
        for i in 0..2 {
            let face = &faces[at[i] as usize];
            for c in 0..3 {
                let point = &points[face[c] as usize];
                for a in 0..3 {
                    corners[c][a].0[i] = point[a];
                }
            }
        }
        corners
    }
    #[inline(always)]
    fn few(self) -> Register {
        Arrays
    }
    #[inline(always)]
    fn load_few(self, x: &[f32; LANES], from: usize) -> Array<f32, 4> {
        let from = from & 12;
        Array([x[from], x[from + 1], x[from + 2], x[from + 3]])
    }
    #[inline(always)]
    fn store_few(self, x: Array<f32, 4>, to: &mut [f32; LANES], from: usize) {
        let from = from & 12;
        to[from..from + 4].copy_from_slice(&x.0);
    }
    #[inline(always)]
    fn load_part(self, x: &[f32; LANES], from: usize) -> Array<f32, 4> {
        self.load_few(x, from)
    }
    #[inline(always)]
    fn store_part(self, x: Array<f32, 4>, to: &mut [f32; LANES], from: usize) {
        self.store_few(x, to, from);
    }
    #[inline(always)]
    fn widen_bytes(self, x: &[u8; LANES], from: usize) -> Array<f32, 4> {
        let from = from & 12;
        Array([x[from], x[from + 1], x[from + 2], x[from + 3]].map(f32::from))
    }
    #[inline(always)]
    fn widen_field(self, x: &[u32; LANES], from: usize, field: u32) -> Array<f32, 4> {
        let from = from & 12;
        // As signed numbers, which every CPU converts in lanes.
        Array([x[from], x[from + 1], x[from + 2], x[from + 3]].map(|x| (x >> (10 * field) & 1023) as i32 as f32))
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
            let (before, after) = (255 - boxes.to_byte(b[1][a], a), boxes.to_byte(b[0][a], a));
            for i in 0..32 {
                apart[i] |= u8::from(boxes.sides[a][i] < before) | u8::from(boxes.sides[a][32 + i] < after);
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
