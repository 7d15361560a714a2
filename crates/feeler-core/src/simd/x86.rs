//! What AVX2 and AVX-512 have in common.

use std::arch::x86_64::*;
use std::ops::{Add, BitOr, BitXor, Mul, Sub};

use super::{ByteBoxes, ByteLanes, LANES};

/// Children of a node.
const FANOUT: usize = 2 * LANES;

/// One register.
#[derive(Debug, Clone, Copy)]
pub struct One<T>(pub T);

macro_rules! operators {
    ($($trait:ident, $name:ident, $register:ty: $instruction:ident;)*) => {$(
        impl $trait for One<$register> {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                // SAFETY: such values are made with a token only.
                unsafe { One($instruction(self.0, other.0)) }
            }
        }
    )*};
}

operators! {
    Add, add, __m256: _mm256_add_ps;
    Sub, sub, __m256: _mm256_sub_ps;
    Mul, mul, __m256: _mm256_mul_ps;
    BitOr, bitor, __m256: _mm256_or_ps;
    BitXor, bitxor, __m256: _mm256_xor_ps;
    Add, add, __m256d: _mm256_add_pd;
    Sub, sub, __m256d: _mm256_sub_pd;
    Mul, mul, __m256d: _mm256_mul_pd;
    Add, add, __m512: _mm512_add_ps;
    Sub, sub, __m512: _mm512_sub_ps;
    Mul, mul, __m512: _mm512_mul_ps;
    Add, add, __m512d: _mm512_add_pd;
    Sub, sub, __m512d: _mm512_sub_pd;
    Mul, mul, __m512d: _mm512_mul_pd;
}

// SAFETY of all blocks below: the token says that the CPU has the instructions; loads and stores go to arrays of the
// register's size and ask for no alignment.

/// A register's four numbers.
#[inline(always)]
pub fn numbers(x: __m128) -> [f32; 4] {
    let mut to = [0.0; 4];
    // SAFETY: every x86-64 CPU has this, and the array has its size.
    unsafe { _mm_storeu_ps(to.as_mut_ptr(), x) };
    to
}

#[inline(always)]
pub fn is_apart(a: [&[f32; 4]; 2], b: [&[f32; 4]; 2]) -> bool {
    // SAFETY: see above; every x86-64 CPU has these.
    unsafe {
        let (a_lower, a_upper) = (_mm_loadu_ps(a[0].as_ptr()), _mm_loadu_ps(a[1].as_ptr()));
        let (b_lower, b_upper) = (_mm_loadu_ps(b[0].as_ptr()), _mm_loadu_ps(b[1].as_ptr()));
        let apart = _mm_or_ps(_mm_cmpgt_ps(a_lower, b_upper), _mm_cmpgt_ps(b_lower, a_upper));
        _mm_movemask_ps(apart) & 7 != 0
    }
}

/// For each axis, in the lowest byte of a 32-bit lane: the least that 255 minus the lower side of a child may be that meets the
/// box (first half), and the least that its upper side may be (second half).
#[inline(always)]
pub fn least_sides(boxes: &ByteBoxes, b: [&[f32; 4]; 2]) -> __m256i {
    // SAFETY: see above; both levels have AVX2.
    unsafe {
        let sides = _mm256_set_m128(_mm_loadu_ps(b[0].as_ptr()), _mm_loadu_ps(b[1].as_ptr()));
        let origin = _mm256_broadcast_ps(&_mm_loadu_ps(boxes.origin.as_ptr()));
        let per_unit = _mm256_broadcast_ps(&_mm_loadu_ps(boxes.per_unit.as_ptr()));
        let t = _mm256_mul_ps(_mm256_sub_ps(sides, origin), per_unit);
        // `max` gives its second argument where the first is NaN; the conversion rounds halves to even.
        let t = _mm256_min_ps(_mm256_max_ps(t, _mm256_setzero_ps()), _mm256_set1_ps(255.0));
        // 255 minus a byte is the byte with all bits turned.
        _mm256_xor_si256(_mm256_cvtps_epi32(t), _mm256_setr_epi32(255, 255, 255, 255, 0, 0, 0, 0))
    }
}

/// See [`Simd::in_bytes`](super::Simd::in_bytes).
#[inline(always)]
pub fn in_bytes(boxes: &ByteBoxes, b: [&[[f32; LANES]; 3]; 2]) -> ByteLanes {
    let mut lanes = ByteLanes { least: [[0; 2 * LANES]; 3], outside: 0 };
    // SAFETY: see above; both levels have AVX2.
    unsafe {
        let beyond = _mm256_set1_ps(256.0);
        // The halves of 16 lanes, when packed, are in fours: 0, 2 and 1, 3.
        let in_order = _mm256_setr_epi32(0, 4, 1, 5, 2, 6, 3, 7);
        let not_upper = _mm256_setr_epi64x(0, 0, -1, -1);
        let (mut last, mut first) = (_mm256_set1_epi16(0), _mm256_set1_epi16(255));
        for a in 0..3 {
            let (origin, per_unit) = (_mm256_set1_ps(boxes.origin[a]), _mm256_set1_ps(boxes.per_unit[a]));
            let mut sixteen = [origin; 4];
            for i in 0..4 {
                let x = _mm256_loadu_ps(b[i / 2][a][8 * (i % 2)..].as_ptr());
                let t = _mm256_mul_ps(_mm256_sub_ps(x, origin), per_unit);
                // What is below the range of integers, and NaN, becomes the least of them: so a lower side stays NaN, and an
                // upper one becomes large. `min` gives its second argument where one is NaN.
                sixteen[i] = if i < 2 { _mm256_min_ps(beyond, t) } else { _mm256_min_ps(t, beyond) };
            }
            let [l, l_next, u, u_next] = sixteen.map(|t| _mm256_cvtps_epi32(t));
            let (lower, upper) = (_mm256_packs_epi32(l, l_next), _mm256_packs_epi32(u, u_next));
            (last, first) = (_mm256_max_epi16(last, lower), _mm256_min_epi16(first, upper));
            let bytes = _mm256_permutevar8x32_epi32(_mm256_packus_epi16(lower, upper), in_order);
            _mm256_storeu_si256(lanes.least[a].as_mut_ptr().cast(), _mm256_xor_si256(bytes, not_upper));
        }
        let after = _mm256_cmpgt_epi16(last, _mm256_set1_epi16(255));
        let outside = _mm256_or_si256(after, _mm256_cmpgt_epi16(_mm256_setzero_si256(), first));
        let bytes = _mm256_permutevar8x32_epi32(_mm256_packs_epi16(outside, outside), in_order);
        lanes.outside = _mm_movemask_epi8(_mm256_castsi256_si128(bytes)) as u16;
    }
    lanes
}

/// See [`Simd::lanes_meeting`](super::Simd::lanes_meeting).
#[inline(always)]
pub fn lanes_meeting(lanes: &ByteLanes, boxes: &ByteBoxes, i: usize) -> u16 {
    let i = i % FANOUT;
    // SAFETY: see above; both levels have AVX2.
    unsafe {
        // What is left after subtracting the side with saturation is not zero where it is below the least it must be.
        let mut below = [_mm_setzero_si128(); 3];
        for a in 0..3 {
            let (lower, upper) = (boxes.sides[a][i], boxes.sides[a][FANOUT + i]);
            let (of_upper, of_lower) = lanes.least[a].split_at(LANES);
            let before = _mm_subs_epu8(_mm_loadu_si128(of_upper.as_ptr().cast()), _mm_set1_epi8(upper as i8));
            let after = _mm_subs_epu8(_mm_loadu_si128(of_lower.as_ptr().cast()), _mm_set1_epi8(lower as i8));
            below[a] = _mm_or_si128(before, after);
        }
        let below = _mm_or_si128(_mm_or_si128(below[0], below[1]), below[2]);
        _mm_movemask_epi8(_mm_cmpeq_epi8(below, _mm_setzero_si128())) as u16
    }
}
