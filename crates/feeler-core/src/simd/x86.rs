//! AVX2 and AVX-512 for x86-64.

use std::arch::x86_64::*;
use std::ops::{Add, Mul, Sub};

use super::portable::append;
use super::{ByteBoxes, Kernel, Simd, FEW, LANES, WIDE_LANES};

/// Whether the CPU has what [`Avx2`] uses.
pub fn has_avx2() -> bool {
    is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") && is_x86_feature_detected!("bmi2")
}

/// Whether the CPU has what [`Avx512`] uses.
pub fn has_avx512() -> bool {
    has_avx2()
        && is_x86_feature_detected!("avx512f")
        && is_x86_feature_detected!("avx512bw")
        && is_x86_feature_detected!("avx512dq")
        && is_x86_feature_detected!("avx512vl")
}

/// Runs a kernel with AVX2.
///
/// # Safety
/// The CPU must have what [`has_avx2`] asks for; the other features came before AVX2.
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub unsafe fn run_avx2<K: Kernel>(kernel: K) -> K::Output {
    kernel.run(Avx2(()))
}

/// Runs a kernel with AVX-512.
///
/// # Safety
/// The CPU must have what [`has_avx512`] asks for; the other features came before AVX2.
#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub unsafe fn run_avx512<K: Kernel>(kernel: K) -> K::Output {
    kernel.run(Avx512(()))
}

/// The token of AVX2: only [`run_avx2`] makes one.
#[derive(Debug, Clone, Copy)]
pub struct Avx2(());

/// The token of AVX-512: only [`run_avx512`] makes one.
#[derive(Debug, Clone, Copy)]
pub struct Avx512(());

/// Two registers as one value.
#[derive(Debug, Clone, Copy)]
pub struct Two<T>(T, T);

/// One register.
#[derive(Debug, Clone, Copy)]
pub struct One<T>(T);

macro_rules! operators {
    ($trait:ident, $name:ident, $two_f32:ident, $two_f64:ident, $one_f32:ident, $one_f64:ident) => {
        operators!(two $trait, $name, __m256, $two_f32);
        operators!(two $trait, $name, __m256d, $two_f64);
        operators!(one $trait, $name, __m512, $one_f32);
        operators!(one $trait, $name, __m512d, $one_f64);
    };
    (two $trait:ident, $name:ident, $register:ident, $instruction:ident) => {
        impl $trait for Two<$register> {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                // SAFETY: such values are made with an `Avx2` token only.
                unsafe { Two($instruction(self.0, other.0), $instruction(self.1, other.1)) }
            }
        }
    };
    (one $trait:ident, $name:ident, $register:ident, $instruction:ident) => {
        impl $trait for One<$register> {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                // SAFETY: such values are made with an `Avx512` token only.
                unsafe { One($instruction(self.0, other.0)) }
            }
        }
    };
}

operators!(Add, add, _mm256_add_ps, _mm256_add_pd, _mm512_add_ps, _mm512_add_pd);
operators!(Sub, sub, _mm256_sub_ps, _mm256_sub_pd, _mm512_sub_ps, _mm512_sub_pd);
operators!(Mul, mul, _mm256_mul_ps, _mm256_mul_pd, _mm512_mul_ps, _mm512_mul_pd);

// SAFETY of all blocks below: the token says that the CPU has the instructions; loads and stores go to arrays of the
// register's size and ask for no alignment.

/// A register's four numbers.
#[inline(always)]
fn numbers(x: __m128) -> [f32; 4] {
    let mut to = [0.0; 4];
    // SAFETY: every x86-64 CPU has this, and the array has its size.
    unsafe { _mm_storeu_ps(to.as_mut_ptr(), x) };
    to
}

#[inline(always)]
fn is_apart(a: [&[f32; 4]; 2], b: [&[f32; 4]; 2]) -> bool {
    // SAFETY: see above; every x86-64 CPU has these.
    unsafe {
        let (a_lower, a_upper) = (_mm_loadu_ps(a[0].as_ptr()), _mm_loadu_ps(a[1].as_ptr()));
        let (b_lower, b_upper) = (_mm_loadu_ps(b[0].as_ptr()), _mm_loadu_ps(b[1].as_ptr()));
        let apart = _mm_or_ps(_mm_cmpgt_ps(a_lower, b_upper), _mm_cmpgt_ps(b_lower, a_upper));
        _mm_movemask_ps(apart) & 7 != 0
    }
}

/// For each axis, in the lowest byte of a 32-bit lane: the largest lower side that a child may have to meet the box (first
/// half), and the largest 255 minus the upper side (second half).
#[inline(always)]
fn limits(boxes: &ByteBoxes, b: [&[f32; 4]; 2]) -> __m256i {
    // SAFETY: see above; both levels have AVX2.
    unsafe {
        let sides = _mm256_set_m128(_mm_loadu_ps(b[0].as_ptr()), _mm_loadu_ps(b[1].as_ptr()));
        let origin = _mm256_broadcast_ps(&_mm_loadu_ps(boxes.origin.as_ptr()));
        let per_unit = _mm256_broadcast_ps(&_mm_loadu_ps(boxes.per_unit.as_ptr()));
        let t = _mm256_mul_ps(_mm256_sub_ps(sides, origin), per_unit);
        // `max` gives its second argument where the first is NaN; the conversion rounds halves to even.
        let t = _mm256_min_ps(_mm256_max_ps(t, _mm256_setzero_ps()), _mm256_set1_ps(255.0));
        // 255 minus a byte is the byte with all bits turned.
        _mm256_xor_si256(_mm256_cvtps_epi32(t), _mm256_setr_epi32(0, 0, 0, 0, 255, 255, 255, 255))
    }
}

/// The first of eight lanes.
#[inline(always)]
fn first_lanes(count: usize) -> u8 {
    ((1u32 << count) - 1) as u8
}

impl Simd for Avx512 {
    type F32 = One<__m512>;
    type F64 = One<__m512d>;
    type M64 = u8;

    #[inline(always)]
    fn splat(self, x: f32) -> Self::F32 {
        // SAFETY: see above.
        unsafe { One(_mm512_set1_ps(x)) }
    }
    #[inline(always)]
    fn load(self, x: &[f32; LANES]) -> Self::F32 {
        // SAFETY: see above.
        unsafe { One(_mm512_loadu_ps(x.as_ptr())) }
    }
    #[inline(always)]
    fn store(self, x: Self::F32, to: &mut [f32; LANES]) {
        // SAFETY: see above.
        unsafe { _mm512_storeu_ps(to.as_mut_ptr(), x.0) }
    }
    #[inline(always)]
    fn widen_bytes(self, x: &[u8; LANES]) -> Self::F32 {
        // SAFETY: see above.
        unsafe { One(_mm512_cvtepi32_ps(_mm512_cvtepu8_epi32(_mm_loadu_si128(x.as_ptr().cast())))) }
    }
    #[inline(always)]
    fn widen_field(self, x: &[u32; LANES], field: u32) -> Self::F32 {
        // SAFETY: see above.
        unsafe {
            let bits = _mm512_srlv_epi32(_mm512_loadu_si512(x.as_ptr().cast()), _mm512_set1_epi32(10 * field as i32));
            One(_mm512_cvtepi32_ps(_mm512_and_si512(bits, _mm512_set1_epi32(1023))))
        }
    }
    #[inline(always)]
    fn mul_add(self, a: Self::F32, b: Self::F32, c: Self::F32) -> Self::F32 {
        // SAFETY: see above.
        unsafe { One(_mm512_fmadd_ps(a.0, b.0, c.0)) }
    }
    #[inline(always)]
    fn min(self, a: Self::F32, b: Self::F32) -> Self::F32 {
        // SAFETY: see above.
        unsafe { One(_mm512_min_ps(a.0, b.0)) }
    }
    #[inline(always)]
    fn max(self, a: Self::F32, b: Self::F32) -> Self::F32 {
        // SAFETY: see above.
        unsafe { One(_mm512_max_ps(a.0, b.0)) }
    }
    #[inline(always)]
    fn abs(self, a: Self::F32) -> Self::F32 {
        // SAFETY: see above.
        unsafe { One(_mm512_abs_ps(a.0)) }
    }
    #[inline(always)]
    fn above(self, a: Self::F32, b: Self::F32) -> u16 {
        // SAFETY: see above.
        unsafe { _mm512_cmp_ps_mask::<_CMP_GT_OQ>(a.0, b.0) }
    }
    #[inline(always)]
    fn blend(self, mask: u16, a: Self::F32, b: Self::F32) -> Self::F32 {
        // SAFETY: see above.
        unsafe { One(_mm512_mask_blend_ps(mask, b.0, a.0)) }
    }
    #[inline(always)]
    fn smallest3(self, x: &[Self::F32; 3]) -> [f32; 4] {
        // SAFETY: see above.
        unsafe {
            let (x, y, z, o) = (x[0].0, x[1].0, x[2].0, _mm512_setzero_ps());
            let xy = _mm512_min_ps(_mm512_unpacklo_ps(x, y), _mm512_unpackhi_ps(x, y));
            let zo = _mm512_min_ps(_mm512_unpacklo_ps(z, o), _mm512_unpackhi_ps(z, o));
            let m = _mm512_min_ps(_mm512_shuffle_ps::<0x44>(xy, zo), _mm512_shuffle_ps::<0xee>(xy, zo));
            let m = _mm256_min_ps(_mm512_castps512_ps256(m), _mm512_extractf32x8_ps::<1>(m));
            numbers(_mm_min_ps(_mm256_castps256_ps128(m), _mm256_extractf128_ps::<1>(m)))
        }
    }
    #[inline(always)]
    fn largest3(self, x: &[Self::F32; 3]) -> [f32; 4] {
        // SAFETY: see above.
        unsafe {
            let (x, y, z, o) = (x[0].0, x[1].0, x[2].0, _mm512_setzero_ps());
            let xy = _mm512_max_ps(_mm512_unpacklo_ps(x, y), _mm512_unpackhi_ps(x, y));
            let zo = _mm512_max_ps(_mm512_unpacklo_ps(z, o), _mm512_unpackhi_ps(z, o));
            let m = _mm512_max_ps(_mm512_shuffle_ps::<0x44>(xy, zo), _mm512_shuffle_ps::<0xee>(xy, zo));
            let m = _mm256_max_ps(_mm512_castps512_ps256(m), _mm512_extractf32x8_ps::<1>(m));
            numbers(_mm_max_ps(_mm256_castps256_ps128(m), _mm256_extractf128_ps::<1>(m)))
        }
    }
    #[inline(always)]
    fn transposed(self, x: &[Self::F32; 3], to: &mut [[f32; 4]; LANES]) {
        // SAFETY: see above; lane `4 i + k` of the four transposed registers is part `i` of register `k`.
        unsafe {
            let (x, y, z, o) = (x[0].0, x[1].0, x[2].0, _mm512_setzero_ps());
            let (xy, xy_high) = (_mm512_unpacklo_ps(x, y), _mm512_unpackhi_ps(x, y));
            let (zo, zo_high) = (_mm512_unpacklo_ps(z, o), _mm512_unpackhi_ps(z, o));
            let of = [
                _mm512_shuffle_ps::<0x44>(xy, zo),
                _mm512_shuffle_ps::<0xee>(xy, zo),
                _mm512_shuffle_ps::<0x44>(xy_high, zo_high),
                _mm512_shuffle_ps::<0xee>(xy_high, zo_high),
            ];
            for k in 0..4 {
                to[k] = numbers(_mm512_castps512_ps128(of[k]));
                to[4 + k] = numbers(_mm512_extractf32x4_ps::<1>(of[k]));
                to[8 + k] = numbers(_mm512_extractf32x4_ps::<2>(of[k]));
                to[12 + k] = numbers(_mm512_extractf32x4_ps::<3>(of[k]));
            }
        }
    }
    #[inline(always)]
    fn is_apart(self, a: [&[f32; 4]; 2], b: [&[f32; 4]; 2]) -> bool {
        is_apart(a, b)
    }
    #[inline(always)]
    fn children_meeting(self, boxes: &ByteBoxes, b: [&[f32; 4]; 2]) -> u32 {
        // SAFETY: see above; 64 bytes of each axis are loaded, which is all there are.
        unsafe {
            let both = _mm512_castsi256_si512(limits(boxes, b));
            let both = _mm512_shuffle_i64x2::<0x50>(both, both);
            let mut above = 0;
            for a in 0..3 {
                let limit = _mm512_shuffle_epi8(both, _mm512_set1_epi8(4 * a as i8));
                above |= _mm512_cmpgt_epu8_mask(_mm512_loadu_si512(boxes.sides[a].as_ptr().cast()), limit);
            }
            !(above as u32 | (above >> 32) as u32)
        }
    }

    #[inline(always)]
    fn append(self, chosen: u16, from: &[u32; LANES], to: &mut [u32], at: usize) -> usize {
        let to = &mut to[at..at + LANES];
        // SAFETY: see above; `to` has 16 numbers.
        unsafe {
            let packed = _mm512_maskz_compress_epi32(chosen, _mm512_loadu_si512(from.as_ptr().cast()));
            _mm512_storeu_si512(to.as_mut_ptr().cast(), packed);
        }
        at + chosen.count_ones() as usize
    }

    #[inline(always)]
    fn append_wide(self, chosen: u8, from: &[u64; WIDE_LANES], to: &mut [u64], at: usize) -> usize {
        let to = &mut to[at..at + WIDE_LANES];
        // SAFETY: see above; `to` has eight numbers.
        unsafe {
            let packed = _mm512_maskz_compress_epi64(chosen, _mm512_loadu_si512(from.as_ptr().cast()));
            _mm512_storeu_si512(to.as_mut_ptr().cast(), packed);
        }
        at + chosen.count_ones() as usize
    }

    const SORTS: bool = true;
    #[inline(always)]
    fn partition(self, keys: &mut [u64], room: &mut [u64], pivot: u64) -> usize {
        let n = keys.len();
        assert!(room.len() >= n + WIDE_LANES);
        let (mut low, mut at) = (0, 0);
        // SAFETY: see above. Eight numbers are read at `at`, where they are, before eight are written at `low`, which is at
        // most `at`, and at `at - low` of `room`; of the last ones, fewer than eight, only as many are read and written there.
        unsafe {
            let (keys, room) = (keys.as_mut_ptr(), room.as_mut_ptr());
            let pivot = _mm512_set1_epi64(pivot as i64);
            while at + WIDE_LANES <= n {
                let eight = _mm512_loadu_si512(keys.add(at).cast());
                let below = _mm512_cmple_epu64_mask(eight, pivot);
                _mm512_storeu_si512(keys.add(low).cast(), _mm512_maskz_compress_epi64(below, eight));
                _mm512_storeu_si512(room.add(at - low).cast(), _mm512_maskz_compress_epi64(!below, eight));
                at += WIDE_LANES;
                low += below.count_ones() as usize;
            }
            let rest = first_lanes(n - at);
            let last = _mm512_maskz_loadu_epi64(rest, keys.add(at).cast());
            let below = _mm512_cmple_epu64_mask(last, pivot) & rest;
            let count = below.count_ones() as usize;
            let (lows, highs) =
                (_mm512_maskz_compress_epi64(below, last), _mm512_maskz_compress_epi64(rest & !below, last));
            _mm512_mask_storeu_epi64(keys.add(low).cast(), first_lanes(count), lows);
            _mm512_storeu_si512(room.add(at - low).cast(), highs);
            low += count;
        }
        keys[low..].copy_from_slice(&room[..n - low]);
        low
    }
    #[inline(always)]
    fn sort_few(self, keys: &[u64], to: &mut [u64; FEW + WIDE_LANES]) -> usize {
        assert!(keys.len() <= FEW);
        let mut places = [u64::MAX; FEW];
        let mut count = 0;
        // SAFETY: see above. Of each eight numbers as many are read as there are; what is not stands for more than any number.
        // Writing at `count` takes eight places, and `count` is at most `FEW`.
        unsafe {
            let none = _mm512_set1_epi64(-1);
            let mut eights = [none; FEW / WIDE_LANES];
            for (i, eight) in eights.iter_mut().enumerate() {
                let there = first_lanes(keys.len().saturating_sub(WIDE_LANES * i).min(WIDE_LANES));
                *eight = _mm512_mask_loadu_epi64(none, there, keys.as_ptr().wrapping_add(WIDE_LANES * i).cast());
            }
            for key in keys {
                // The place of a number is how many are smaller. Equal ones have one place, and leave some as they were.
                let all = _mm512_set1_epi64(*key as i64);
                let [a, b, c, d] = eights.map(|eight| u32::from(_mm512_cmplt_epu64_mask(eight, all)));
                places[(a | b << 8 | c << 16 | d << 24).count_ones() as usize % FEW] = *key;
            }
            for eight in places.chunks_exact(WIDE_LANES) {
                let eight = _mm512_loadu_si512(eight.as_ptr().cast());
                let taken = _mm512_cmpneq_epu64_mask(eight, none);
                _mm512_storeu_si512(to.as_mut_ptr().add(count).cast(), _mm512_maskz_compress_epi64(taken, eight));
                count += taken.count_ones() as usize;
            }
        }
        count
    }

    #[inline(always)]
    fn wide_splat(self, x: f64) -> Self::F64 {
        // SAFETY: see above.
        unsafe { One(_mm512_set1_pd(x)) }
    }
    #[inline(always)]
    fn wide_load(self, x: &[f64; WIDE_LANES]) -> Self::F64 {
        // SAFETY: see above; eight numbers are read.
        unsafe { One(_mm512_loadu_pd(x.as_ptr())) }
    }
    #[inline(always)]
    fn wide_store(self, x: Self::F64, to: &mut [f64; WIDE_LANES]) {
        // SAFETY: see above; eight numbers are written.
        unsafe { _mm512_storeu_pd(to.as_mut_ptr(), x.0) }
    }
    #[inline(always)]
    fn wide_points(self, x: [&[f64; 3]; WIDE_LANES]) -> [Self::F64; 3] {
        // SAFETY: see above; three numbers of each point are read.
        unsafe {
            let mut rows = [_mm512_setzero_pd(); 4];
            for i in 0..4 {
                let low = _mm512_castpd256_pd512(_mm256_maskz_loadu_pd(7, x[i].as_ptr()));
                rows[i] = _mm512_insertf64x4::<1>(low, _mm256_maskz_loadu_pd(7, x[4 + i].as_ptr()));
            }
            let (xz, xz_next) = (_mm512_unpacklo_pd(rows[0], rows[1]), _mm512_unpacklo_pd(rows[2], rows[3]));
            let (y, y_next) = (_mm512_unpackhi_pd(rows[0], rows[1]), _mm512_unpackhi_pd(rows[2], rows[3]));
            let first = _mm512_setr_epi64(0, 1, 8, 9, 4, 5, 12, 13);
            let second = _mm512_setr_epi64(2, 3, 10, 11, 6, 7, 14, 15);
            [
                One(_mm512_permutex2var_pd(xz, first, xz_next)),
                One(_mm512_permutex2var_pd(y, first, y_next)),
                One(_mm512_permutex2var_pd(xz, second, xz_next)),
            ]
        }
    }
    #[inline(always)]
    fn wide_mul_add(self, a: Self::F64, b: Self::F64, c: Self::F64) -> Self::F64 {
        // SAFETY: see above.
        unsafe { One(_mm512_fmadd_pd(a.0, b.0, c.0)) }
    }
    #[inline(always)]
    fn wide_mul_sub(self, a: Self::F64, b: Self::F64, c: Self::F64) -> Self::F64 {
        // SAFETY: see above.
        unsafe { One(_mm512_fmsub_pd(a.0, b.0, c.0)) }
    }
    #[inline(always)]
    fn wide_abs(self, a: Self::F64) -> Self::F64 {
        // SAFETY: see above.
        unsafe { One(_mm512_abs_pd(a.0)) }
    }
    #[inline(always)]
    fn wide_min(self, a: Self::F64, b: Self::F64) -> Self::F64 {
        // SAFETY: see above.
        unsafe { One(_mm512_min_pd(a.0, b.0)) }
    }
    #[inline(always)]
    fn wide_divide(self, a: Self::F64, b: Self::F64) -> Self::F64 {
        // SAFETY: see above.
        unsafe { One(_mm512_div_pd(a.0, b.0)) }
    }
    #[inline(always)]
    fn wide_max(self, a: Self::F64, b: Self::F64) -> Self::F64 {
        // SAFETY: see above.
        unsafe { One(_mm512_max_pd(a.0, b.0)) }
    }
    #[inline(always)]
    fn wide_above(self, a: Self::F64, b: Self::F64) -> Self::M64 {
        // SAFETY: see above.
        unsafe { _mm512_cmp_pd_mask::<_CMP_GT_OQ>(a.0, b.0) }
    }
    #[inline(always)]
    fn choose(self, mask: Self::M64, a: Self::F64, b: Self::F64) -> Self::F64 {
        // SAFETY: see above.
        unsafe { One(_mm512_mask_blend_pd(mask, b.0, a.0)) }
    }
    #[inline(always)]
    fn differing(self, a: Self::M64, b: Self::M64) -> Self::M64 {
        a ^ b
    }
    #[inline(always)]
    fn both(self, a: Self::M64, b: Self::M64) -> Self::M64 {
        a & b
    }
    #[inline(always)]
    fn either(self, a: Self::M64, b: Self::M64) -> Self::M64 {
        a | b
    }
    #[inline(always)]
    fn bits(self, mask: Self::M64) -> u8 {
        mask
    }
}

impl Simd for Avx2 {
    type F32 = Two<__m256>;
    type F64 = Two<__m256d>;
    type M64 = Two<__m256d>;

    #[inline(always)]
    fn splat(self, x: f32) -> Self::F32 {
        // SAFETY: see above.
        unsafe { Two(_mm256_set1_ps(x), _mm256_set1_ps(x)) }
    }
    #[inline(always)]
    fn load(self, x: &[f32; LANES]) -> Self::F32 {
        // SAFETY: see above.
        unsafe { Two(_mm256_loadu_ps(x.as_ptr()), _mm256_loadu_ps(x[8..].as_ptr())) }
    }
    #[inline(always)]
    fn store(self, x: Self::F32, to: &mut [f32; LANES]) {
        // SAFETY: see above.
        unsafe {
            _mm256_storeu_ps(to.as_mut_ptr(), x.0);
            _mm256_storeu_ps(to[8..].as_mut_ptr(), x.1);
        }
    }
    #[inline(always)]
    fn widen_bytes(self, x: &[u8; LANES]) -> Self::F32 {
        // SAFETY: see above.
        unsafe {
            let bytes = _mm_loadu_si128(x.as_ptr().cast());
            let eight = |b: __m128i| _mm256_cvtepi32_ps(_mm256_cvtepu8_epi32(b));
            Two(eight(bytes), eight(_mm_srli_si128::<8>(bytes)))
        }
    }
    #[inline(always)]
    fn widen_field(self, x: &[u32; LANES], field: u32) -> Self::F32 {
        // SAFETY: see above.
        unsafe {
            let (shift, mask) = (_mm256_set1_epi32(10 * field as i32), _mm256_set1_epi32(1023));
            let low = _mm256_srlv_epi32(_mm256_loadu_si256(x.as_ptr().cast()), shift);
            let high = _mm256_srlv_epi32(_mm256_loadu_si256(x[8..].as_ptr().cast()), shift);
            Two(_mm256_cvtepi32_ps(_mm256_and_si256(low, mask)), _mm256_cvtepi32_ps(_mm256_and_si256(high, mask)))
        }
    }
    #[inline(always)]
    fn mul_add(self, a: Self::F32, b: Self::F32, c: Self::F32) -> Self::F32 {
        // SAFETY: see above.
        unsafe { Two(_mm256_fmadd_ps(a.0, b.0, c.0), _mm256_fmadd_ps(a.1, b.1, c.1)) }
    }
    #[inline(always)]
    fn min(self, a: Self::F32, b: Self::F32) -> Self::F32 {
        // SAFETY: see above.
        unsafe { Two(_mm256_min_ps(a.0, b.0), _mm256_min_ps(a.1, b.1)) }
    }
    #[inline(always)]
    fn max(self, a: Self::F32, b: Self::F32) -> Self::F32 {
        // SAFETY: see above.
        unsafe { Two(_mm256_max_ps(a.0, b.0), _mm256_max_ps(a.1, b.1)) }
    }
    #[inline(always)]
    fn abs(self, a: Self::F32) -> Self::F32 {
        // SAFETY: see above.
        unsafe {
            let sign = _mm256_set1_ps(-0.0);
            Two(_mm256_andnot_ps(sign, a.0), _mm256_andnot_ps(sign, a.1))
        }
    }
    #[inline(always)]
    fn above(self, a: Self::F32, b: Self::F32) -> u16 {
        // SAFETY: see above.
        unsafe {
            let low = _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_GT_OQ>(a.0, b.0));
            let high = _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_GT_OQ>(a.1, b.1));
            (low | high << 8) as u16
        }
    }
    #[inline(always)]
    fn blend(self, mask: u16, a: Self::F32, b: Self::F32) -> Self::F32 {
        // SAFETY: see above.
        unsafe {
            let bits = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
            let (low, high) = (_mm256_set1_epi32(mask.into()), _mm256_set1_epi32((mask >> 8).into()));
            let low = _mm256_castsi256_ps(_mm256_cmpeq_epi32(_mm256_and_si256(low, bits), bits));
            let high = _mm256_castsi256_ps(_mm256_cmpeq_epi32(_mm256_and_si256(high, bits), bits));
            Two(_mm256_blendv_ps(b.0, a.0, low), _mm256_blendv_ps(b.1, a.1, high))
        }
    }
    #[inline(always)]
    fn smallest3(self, x: &[Self::F32; 3]) -> [f32; 4] {
        // SAFETY: see above.
        unsafe {
            let least = [_mm256_min_ps(x[0].0, x[0].1), _mm256_min_ps(x[1].0, x[1].1), _mm256_min_ps(x[2].0, x[2].1)];
            let (x, y, z, o) = (least[0], least[1], least[2], _mm256_setzero_ps());
            let xy = _mm256_min_ps(_mm256_unpacklo_ps(x, y), _mm256_unpackhi_ps(x, y));
            let zo = _mm256_min_ps(_mm256_unpacklo_ps(z, o), _mm256_unpackhi_ps(z, o));
            let m = _mm256_min_ps(_mm256_shuffle_ps::<0x44>(xy, zo), _mm256_shuffle_ps::<0xee>(xy, zo));
            numbers(_mm_min_ps(_mm256_castps256_ps128(m), _mm256_extractf128_ps::<1>(m)))
        }
    }
    #[inline(always)]
    fn largest3(self, x: &[Self::F32; 3]) -> [f32; 4] {
        // SAFETY: see above.
        unsafe {
            let most = [_mm256_max_ps(x[0].0, x[0].1), _mm256_max_ps(x[1].0, x[1].1), _mm256_max_ps(x[2].0, x[2].1)];
            let (x, y, z, o) = (most[0], most[1], most[2], _mm256_setzero_ps());
            let xy = _mm256_max_ps(_mm256_unpacklo_ps(x, y), _mm256_unpackhi_ps(x, y));
            let zo = _mm256_max_ps(_mm256_unpacklo_ps(z, o), _mm256_unpackhi_ps(z, o));
            let m = _mm256_max_ps(_mm256_shuffle_ps::<0x44>(xy, zo), _mm256_shuffle_ps::<0xee>(xy, zo));
            numbers(_mm_max_ps(_mm256_castps256_ps128(m), _mm256_extractf128_ps::<1>(m)))
        }
    }
    #[inline(always)]
    fn transposed(self, x: &[Self::F32; 3], to: &mut [[f32; 4]; LANES]) {
        // SAFETY: see above; within a half, lane `4 i + k` of the four transposed registers is part `i` of register `k`.
        unsafe {
            let o = _mm256_setzero_ps();
            let halves = [[x[0].0, x[1].0, x[2].0], [x[0].1, x[1].1, x[2].1]];
            for (half, [x, y, z]) in halves.into_iter().enumerate() {
                let (xy, xy_high) = (_mm256_unpacklo_ps(x, y), _mm256_unpackhi_ps(x, y));
                let (zo, zo_high) = (_mm256_unpacklo_ps(z, o), _mm256_unpackhi_ps(z, o));
                let of = [
                    _mm256_shuffle_ps::<0x44>(xy, zo),
                    _mm256_shuffle_ps::<0xee>(xy, zo),
                    _mm256_shuffle_ps::<0x44>(xy_high, zo_high),
                    _mm256_shuffle_ps::<0xee>(xy_high, zo_high),
                ];
                for k in 0..4 {
                    to[8 * half + k] = numbers(_mm256_castps256_ps128(of[k]));
                    to[8 * half + 4 + k] = numbers(_mm256_extractf128_ps::<1>(of[k]));
                }
            }
        }
    }
    #[inline(always)]
    fn is_apart(self, a: [&[f32; 4]; 2], b: [&[f32; 4]; 2]) -> bool {
        is_apart(a, b)
    }
    #[inline(always)]
    fn children_meeting(self, boxes: &ByteBoxes, b: [&[f32; 4]; 2]) -> u32 {
        // SAFETY: see above.
        unsafe {
            let limits = limits(boxes, b);
            let halves = [_mm256_permute4x64_epi64::<0x44>(limits), _mm256_permute4x64_epi64::<0xee>(limits)];
            // What is left after subtracting the limit with saturation is not zero where the byte is above it.
            let mut above = _mm256_setzero_si256();
            for a in 0..3 {
                for half in 0..2 {
                    let limit = _mm256_shuffle_epi8(halves[half], _mm256_set1_epi8(4 * a as i8));
                    let side = _mm256_loadu_si256(boxes.sides[a].as_ptr().add(32 * half).cast());
                    above = _mm256_or_si256(above, _mm256_subs_epu8(side, limit));
                }
            }
            _mm256_movemask_epi8(_mm256_cmpeq_epi8(above, _mm256_setzero_si256())) as u32
        }
    }

    #[inline(always)]
    fn append(self, chosen: u16, from: &[u32; LANES], to: &mut [u32], at: usize) -> usize {
        append(chosen, from, to, at)
    }

    #[inline(always)]
    fn wide_splat(self, x: f64) -> Self::F64 {
        // SAFETY: see above.
        unsafe { Two(_mm256_set1_pd(x), _mm256_set1_pd(x)) }
    }
    #[inline(always)]
    fn wide_load(self, x: &[f64; WIDE_LANES]) -> Self::F64 {
        let (low, high) = x.split_at(WIDE_LANES / 2);
        // SAFETY: see above; four numbers are read from each half.
        unsafe { Two(_mm256_loadu_pd(low.as_ptr()), _mm256_loadu_pd(high.as_ptr())) }
    }
    #[inline(always)]
    fn wide_store(self, x: Self::F64, to: &mut [f64; WIDE_LANES]) {
        let (low, high) = to.split_at_mut(WIDE_LANES / 2);
        // SAFETY: see above; four numbers are written to each half.
        unsafe {
            _mm256_storeu_pd(low.as_mut_ptr(), x.0);
            _mm256_storeu_pd(high.as_mut_ptr(), x.1);
        }
    }
    #[inline(always)]
    fn wide_points(self, x: [&[f64; 3]; WIDE_LANES]) -> [Self::F64; 3] {
        // SAFETY: see above; three numbers of each point are read.
        unsafe {
            let three = _mm256_setr_epi64x(-1, -1, -1, 0);
            let mut halves = [[_mm256_setzero_pd(); 3]; 2];
            for half in 0..2 {
                let mut rows = [_mm256_setzero_pd(); 4];
                for i in 0..4 {
                    rows[i] = _mm256_maskload_pd(x[4 * half + i].as_ptr(), three);
                }
                let (xz, xz_next) = (_mm256_unpacklo_pd(rows[0], rows[1]), _mm256_unpacklo_pd(rows[2], rows[3]));
                let (y, y_next) = (_mm256_unpackhi_pd(rows[0], rows[1]), _mm256_unpackhi_pd(rows[2], rows[3]));
                halves[half] = [
                    _mm256_permute2f128_pd::<0x20>(xz, xz_next),
                    _mm256_permute2f128_pd::<0x20>(y, y_next),
                    _mm256_permute2f128_pd::<0x31>(xz, xz_next),
                ];
            }
            [Two(halves[0][0], halves[1][0]), Two(halves[0][1], halves[1][1]), Two(halves[0][2], halves[1][2])]
        }
    }
    #[inline(always)]
    fn wide_mul_add(self, a: Self::F64, b: Self::F64, c: Self::F64) -> Self::F64 {
        // SAFETY: see above.
        unsafe { Two(_mm256_fmadd_pd(a.0, b.0, c.0), _mm256_fmadd_pd(a.1, b.1, c.1)) }
    }
    #[inline(always)]
    fn wide_mul_sub(self, a: Self::F64, b: Self::F64, c: Self::F64) -> Self::F64 {
        // SAFETY: see above.
        unsafe { Two(_mm256_fmsub_pd(a.0, b.0, c.0), _mm256_fmsub_pd(a.1, b.1, c.1)) }
    }
    #[inline(always)]
    fn wide_abs(self, a: Self::F64) -> Self::F64 {
        // SAFETY: see above.
        unsafe {
            let sign = _mm256_set1_pd(-0.0);
            Two(_mm256_andnot_pd(sign, a.0), _mm256_andnot_pd(sign, a.1))
        }
    }
    #[inline(always)]
    fn wide_min(self, a: Self::F64, b: Self::F64) -> Self::F64 {
        // SAFETY: see above.
        unsafe { Two(_mm256_min_pd(a.0, b.0), _mm256_min_pd(a.1, b.1)) }
    }
    #[inline(always)]
    fn wide_divide(self, a: Self::F64, b: Self::F64) -> Self::F64 {
        // SAFETY: see above.
        unsafe { Two(_mm256_div_pd(a.0, b.0), _mm256_div_pd(a.1, b.1)) }
    }
    #[inline(always)]
    fn wide_max(self, a: Self::F64, b: Self::F64) -> Self::F64 {
        // SAFETY: see above.
        unsafe { Two(_mm256_max_pd(a.0, b.0), _mm256_max_pd(a.1, b.1)) }
    }
    #[inline(always)]
    fn wide_above(self, a: Self::F64, b: Self::F64) -> Self::M64 {
        // SAFETY: see above.
        unsafe { Two(_mm256_cmp_pd::<_CMP_GT_OQ>(a.0, b.0), _mm256_cmp_pd::<_CMP_GT_OQ>(a.1, b.1)) }
    }
    #[inline(always)]
    fn choose(self, mask: Self::M64, a: Self::F64, b: Self::F64) -> Self::F64 {
        // SAFETY: see above.
        unsafe { Two(_mm256_blendv_pd(b.0, a.0, mask.0), _mm256_blendv_pd(b.1, a.1, mask.1)) }
    }
    #[inline(always)]
    fn differing(self, a: Self::M64, b: Self::M64) -> Self::M64 {
        // SAFETY: see above.
        unsafe { Two(_mm256_xor_pd(a.0, b.0), _mm256_xor_pd(a.1, b.1)) }
    }
    #[inline(always)]
    fn both(self, a: Self::M64, b: Self::M64) -> Self::M64 {
        // SAFETY: see above.
        unsafe { Two(_mm256_and_pd(a.0, b.0), _mm256_and_pd(a.1, b.1)) }
    }
    #[inline(always)]
    fn either(self, a: Self::M64, b: Self::M64) -> Self::M64 {
        // SAFETY: see above.
        unsafe { Two(_mm256_or_pd(a.0, b.0), _mm256_or_pd(a.1, b.1)) }
    }
    #[inline(always)]
    fn bits(self, mask: Self::M64) -> u8 {
        // SAFETY: see above.
        unsafe { (_mm256_movemask_pd(mask.0) | _mm256_movemask_pd(mask.1) << 4) as u8 }
    }
}
