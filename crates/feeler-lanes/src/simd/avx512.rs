//! AVX-512: sixteen float32 are one register, and so are eight float64.

use std::arch::x86_64::*;

use super::arithmetic::{close_up, Arithmetic, ByteBoxes, CacheLine, Kernel, LineLanes, Simd, FEW, LANES, WIDE_LANES};
use super::avx2;
use super::registers::One;
use super::x86::{is_apart, least_sides, numbers};

/// Whether the CPU has the features of [`Avx512`].
pub fn is_there() -> bool {
    avx2::is_there()
        && is_x86_feature_detected!("avx512f")
        && is_x86_feature_detected!("avx512bw")
        && is_x86_feature_detected!("avx512dq")
        && is_x86_feature_detected!("avx512vl")
}

/// Runs a kernel with AVX-512.
///
/// # Safety
/// The CPU must have the features of [`is_there`]; the other features came before AVX2.
#[target_feature(enable = "avx512f,avx512bw,avx512dq,avx512vl,avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub unsafe fn run_avx512<K: Kernel>(kernel: K) -> K::Output {
    kernel.run(Avx512(()))
}

/// The token of AVX-512: only [`run_avx512`] makes one.
#[derive(Debug, Clone, Copy)]
pub struct Avx512(());

// SAFETY of all blocks below: the token says that the CPU has the instructions; loads and stores go to arrays of the
// register's size and ask for no alignment.

/// Whether all of eight places are of a list.
#[inline(always)]
fn is_within(places: __m256i, count: usize) -> bool {
    let Some(last) = count.checked_sub(1) else { return false };
    // SAFETY: see above.
    unsafe { _mm256_cmple_epu32_mask(places, _mm256_set1_epi32(last.min(u32::MAX as usize) as u32 as i32)) == 0xff }
}

/// Row `i` of the argument is column `i` of the result.
#[inline(always)]
fn transposed8(rows: &[__m512d; WIDE_LANES]) -> [__m512d; WIDE_LANES] {
    let mut columns = *rows;
    // SAFETY: see above.
    unsafe {
        for odd in 0..2 {
            let mut two = [rows[0]; 4];
            for i in 0..4 {
                let (p, q) = (rows[2 * i], rows[2 * i + 1]);
                two[i] = if odd == 0 { _mm512_unpacklo_pd(p, q) } else { _mm512_unpackhi_pd(p, q) };
            }
            // Of parts of 128 bits first those of columns 0 and 4, then those of 2 and 6.
            let (p, q) = (_mm512_shuffle_f64x2::<0x88>(two[0], two[1]), _mm512_shuffle_f64x2::<0x88>(two[2], two[3]));
            columns[odd] = _mm512_shuffle_f64x2::<0x88>(p, q);
            columns[4 + odd] = _mm512_shuffle_f64x2::<0xdd>(p, q);
            let (p, q) = (_mm512_shuffle_f64x2::<0xdd>(two[0], two[1]), _mm512_shuffle_f64x2::<0xdd>(two[2], two[3]));
            columns[2 + odd] = _mm512_shuffle_f64x2::<0x88>(p, q);
            columns[6 + odd] = _mm512_shuffle_f64x2::<0xdd>(p, q);
        }
    }
    columns
}

/// Puts numbers, at most `N` times eight, where they belong: the place of each is how many are smaller. Equal ones have one
/// place, and leave some as they were. Returns which places are taken.
#[inline(always)]
fn put_in_place<const N: usize>(keys: &[u64], to: &mut [u64; FEW]) -> u32 {
    // SAFETY: see above. Of each eight numbers only existing ones are read; a missing one counts as more than any number.
    unsafe {
        let none = _mm512_set1_epi64(-1);
        let mut eights = [none; N];
        for (i, eight) in eights.iter_mut().enumerate() {
            let there = first_lanes(keys.len().saturating_sub(WIDE_LANES * i).min(WIDE_LANES));
            *eight = _mm512_mask_loadu_epi64(none, there, keys.as_ptr().wrapping_add(WIDE_LANES * i).cast());
        }
        let mut taken = 0;
        for key in keys {
            let all = _mm512_set1_epi64(*key as i64);
            let mut smaller = 0;
            for i in 0..N {
                smaller |= u32::from(_mm512_cmplt_epu64_mask(eights[i], all)) << (WIDE_LANES * i);
            }
            let place = smaller.count_ones() as usize % FEW;
            to[place] = *key;
            taken |= 1 << place;
        }
        taken
    }
}

/// The first of eight lanes.
#[inline(always)]
fn first_lanes(count: usize) -> u8 {
    ((1u32 << count) - 1) as u8
}

impl Arithmetic for Avx512 {
    const WIDE: usize = WIDE_LANES;
    type F32 = One<__m512>;
    type F64 = One<__m512d>;
    type M32 = u16;
    type M64 = u8;

    #[inline(always)]
    fn splat(self, x: f32) -> Self::F32 {
        // SAFETY: see above.
        unsafe { One(_mm512_set1_ps(x)) }
    }
    #[inline(always)]
    fn mul_add(self, a: Self::F32, b: Self::F32, c: Self::F32) -> Self::F32 {
        // SAFETY: see above.
        unsafe { One(_mm512_fmadd_ps(a.0, b.0, c.0)) }
    }
    #[inline(always)]
    fn mul_sub(self, a: Self::F32, b: Self::F32, c: Self::F32) -> Self::F32 {
        // SAFETY: see above.
        unsafe { One(_mm512_fmsub_ps(a.0, b.0, c.0)) }
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
    fn min_abs(self, a: Self::F32, b: Self::F32) -> Self::F32 {
        // SAFETY: see above. By their absolute values the smaller, without its sign.
        unsafe { One(_mm512_range_ps::<0b10_10>(a.0, b.0)) }
    }
    #[inline(always)]
    fn max_abs(self, a: Self::F32, b: Self::F32) -> Self::F32 {
        // SAFETY: see above. By their absolute values the larger, without its sign.
        unsafe { One(_mm512_range_ps::<0b10_11>(a.0, b.0)) }
    }
    #[inline(always)]
    fn above(self, a: Self::F32, b: Self::F32) -> Self::M32 {
        // SAFETY: see above.
        unsafe { _mm512_cmp_ps_mask::<_CMP_GT_OQ>(a.0, b.0) }
    }
    #[inline(always)]
    fn lanes(self, mask: Self::M32) -> u16 {
        mask
    }
    #[inline(always)]
    fn blend(self, mask: Self::M32, a: Self::F32, b: Self::F32) -> Self::F32 {
        // SAFETY: see above.
        unsafe { One(_mm512_mask_blend_ps(mask, b.0, a.0)) }
    }
    #[inline(always)]
    fn narrowed(self, low: Self::F64, high: Self::F64) -> Self::F32 {
        // SAFETY: see above.
        unsafe {
            let low = _mm512_castps256_ps512(_mm512_cvtpd_ps(low.0));
            One(_mm512_insertf32x8::<1>(low, _mm512_cvtpd_ps(high.0)))
        }
    }
    #[inline(always)]
    fn wide_splat(self, x: f64) -> Self::F64 {
        // SAFETY: see above.
        unsafe { One(_mm512_set1_pd(x)) }
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

impl Simd for Avx512 {
    type Part = Avx512;
    type Few = Avx512;

    #[inline(always)]
    fn part(self) -> Avx512 {
        self
    }
    #[inline(always)]
    fn lines_part(self, list: &[CacheLine], at: &[u32]) -> LineLanes<Avx512> {
        let at = &at[..LANES];
        // SAFETY: see above; sixteen places are read, and all are found to be of the list. A line is eight numbers of 64 bits.
        unsafe {
            let (low, high) = (_mm256_loadu_si256(at.as_ptr().cast()), _mm256_loadu_si256(at[8..].as_ptr().cast()));
            assert!(is_within(_mm256_max_epu32(low, high), list.len()));
            let mut rows = [[_mm512_setzero_pd(); WIDE_LANES]; 2];
            for i in 0..LANES {
                let line = list.get_unchecked(at[i] as usize);
                rows[i / WIDE_LANES][i % WIDE_LANES] = _mm512_load_pd(std::ptr::from_ref(line).cast());
            }
            let [low, high] = [transposed8(&rows[0]), transposed8(&rows[1])];
            // Two numbers of 32 bits in each of the last five.
            let even = _mm512_setr_epi32(0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30);
            let odd = _mm512_setr_epi32(1, 3, 5, 7, 9, 11, 13, 15, 17, 19, 21, 23, 25, 27, 29, 31);
            let mut narrow = [One(_mm512_setzero_ps()); 10];
            for k in 0..5 {
                let (low, high) = (_mm512_castpd_ps(low[3 + k]), _mm512_castpd_ps(high[3 + k]));
                narrow[2 * k] = One(_mm512_permutex2var_ps(low, even, high));
                narrow[2 * k + 1] = One(_mm512_permutex2var_ps(low, odd, high));
            }
            let wide = |of: &[__m512d; WIDE_LANES]| [One(of[0]), One(of[1]), One(of[2])];
            ([wide(&low), wide(&high)], narrow)
        }
    }
    #[inline(always)]
    fn faces_part(self, faces: &[[u32; 3]], list: &[[f64; 3]], at: &[u32]) -> [[Self::F64; 3]; 3] {
        let at = &at[..WIDE_LANES];
        // SAFETY: see above; eight places are read, and all are found to be of the faces; three numbers of each of these are
        // read, and all are found to be of the points.
        unsafe {
            assert!(is_within(_mm256_loadu_si256(at.as_ptr().cast()), faces.len()));
            let mut numbers = [&[0; 3]; WIDE_LANES];
            let mut last = _mm_setzero_si128();
            for i in 0..WIDE_LANES {
                numbers[i] = faces.get_unchecked(at[i] as usize);
                last = _mm_max_epu32(last, _mm_maskz_loadu_epi32(7, numbers[i].as_ptr().cast()));
            }
            assert!(is_within(_mm256_zextsi128_si256(last), list.len()));
            let mut corners = [[One(_mm512_setzero_pd()); 3]; 3];
            for c in 0..3 {
                let mut points = [&[0.0; 3]; WIDE_LANES];
                for i in 0..WIDE_LANES {
                    points[i] = list.get_unchecked(numbers[i][c] as usize);
                }
                corners[c] = self.wide_points(points);
            }
            corners
        }
    }
    #[inline(always)]
    fn few(self) -> Avx512 {
        self
    }
    #[inline(always)]
    fn load_few(self, x: &[f32; LANES], _: usize) -> Self::F32 {
        self.load(x)
    }
    #[inline(always)]
    fn store_few(self, x: Self::F32, to: &mut [f32; LANES], _: usize) {
        self.store(x, to);
    }
    #[inline(always)]
    fn load_part(self, x: &[f32; LANES], _: usize) -> Self::F32 {
        self.load(x)
    }
    #[inline(always)]
    fn store_part(self, x: Self::F32, to: &mut [f32; LANES], _: usize) {
        self.store(x, to);
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
    fn widen_bytes(self, x: &[u8; LANES], _: usize) -> Self::F32 {
        // SAFETY: see above.
        unsafe { One(_mm512_cvtepi32_ps(_mm512_cvtepu8_epi32(_mm_loadu_si128(x.as_ptr().cast())))) }
    }
    #[inline(always)]
    fn widen_field(self, x: &[u32; LANES], _: usize, field: u32) -> Self::F32 {
        // SAFETY: see above.
        unsafe {
            let bits = _mm512_srlv_epi32(_mm512_loadu_si512(x.as_ptr().cast()), _mm512_set1_epi32(10 * field as i32));
            One(_mm512_cvtepi32_ps(_mm512_and_si512(bits, _mm512_set1_epi32(1023))))
        }
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
            let both = _mm512_castsi256_si512(least_sides(boxes, b));
            let both = _mm512_shuffle_i64x2::<0x50>(both, both);
            // One chain, in which each comparison looks at what the one before left: none is there to join them.
            let mut reached = u64::MAX;
            for a in 0..3 {
                let least = _mm512_shuffle_epi8(both, _mm512_set1_epi8(4 * a as i8));
                let sides = _mm512_loadu_si512(boxes.sides[a].as_ptr().cast());
                reached = _mm512_mask_cmpge_epu8_mask(reached, sides, least);
            }
            reached as u32 & (reached >> 32) as u32
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
    fn sort_few(self, keys: &[u64], to: &mut [u64; FEW]) -> usize {
        assert!(keys.len() <= FEW);
        let taken = match keys.len().div_ceil(WIDE_LANES) {
            0 | 1 => put_in_place::<1>(keys, to),
            2 => put_in_place::<2>(keys, to),
            3 => put_in_place::<3>(keys, to),
            _ => put_in_place::<4>(keys, to),
        };
        close_up(to, taken)
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
            for (row, (i, j)) in rows.iter_mut().zip([(0, 2), (1, 3), (4, 6), (5, 7)]) {
                let low = _mm512_castpd256_pd512(_mm256_maskz_loadu_pd(7, x[i].as_ptr()));
                *row = _mm512_insertf64x4::<1>(low, _mm256_maskz_loadu_pd(7, x[j].as_ptr()));
            }
            let (xz, xz_next) = (_mm512_unpacklo_pd(rows[0], rows[1]), _mm512_unpacklo_pd(rows[2], rows[3]));
            let (y, y_next) = (_mm512_unpackhi_pd(rows[0], rows[1]), _mm512_unpackhi_pd(rows[2], rows[3]));
            [
                One(_mm512_shuffle_f64x2::<0x88>(xz, xz_next)),
                One(_mm512_shuffle_f64x2::<0x88>(y, y_next)),
                One(_mm512_shuffle_f64x2::<0xdd>(xz, xz_next)),
            ]
        }
    }
}
