//! Code shared by AVX2 and AVX-512.

use std::arch::x86_64::*;
use std::ops::{Add, BitOr, BitXor, Mul, Sub};

use super::arithmetic::ByteBoxes;
use super::registers::{operators, One};

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

/// For each axis, in the lowest byte of a 32-bit lane: the least value of 255 minus the lower side of a child that
/// overlaps the box (first half), and the least value of its upper side (second half).
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
