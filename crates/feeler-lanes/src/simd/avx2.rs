//! AVX2: sixteen float32 are two registers, and so are eight float64.

use std::arch::x86_64::*;
use std::ops::{Add, BitOr, BitXor, Mul, Sub};

use super::arithmetic::{
    close_up, Arithmetic, ByteBoxes, ByteLanes, CacheLine, Kernel, LineLanes, Simd, FEW, LANES, WIDE_LANES,
};
use super::registers::One;
use super::x86::{is_apart, least_sides, numbers};

/// Whether the CPU has the features of [`Avx2`].
pub fn is_there() -> bool {
    is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") && is_x86_feature_detected!("bmi2")
}

/// Runs a kernel with AVX2.
///
/// # Safety
/// The CPU must have the features of [`is_there`]; the other features came before AVX2.
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub unsafe fn run_avx2<K: Kernel>(kernel: K) -> K::Output {
    kernel.run(Avx2(OneRegister(())))
}

/// The token of AVX2: only [`run_avx2`] makes one.
#[derive(Debug, Clone, Copy)]
pub struct Avx2(OneRegister);

/// The token for half of the lanes: only [`run_avx2`] makes one.
#[derive(Debug, Clone, Copy)]
pub struct OneRegister(());

/// Two registers as one value.
#[derive(Debug, Clone, Copy)]
pub struct Two<T>(T, T);

macro_rules! operators_of_two {
    ($($trait:ident, $name:ident;)*) => {$(
        impl<T: $trait<Output = T>> $trait for Two<T> {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                Two($trait::$name(self.0, other.0), $trait::$name(self.1, other.1))
            }
        }
    )*};
}

operators_of_two! {
    Add, add;
    Sub, sub;
    Mul, mul;
    BitOr, bitor;
    BitXor, bitxor;
}

// SAFETY of all blocks below: the token says that the CPU has the instructions; loads and stores go to arrays of the
// register's size and ask for no alignment.

/// For each choice of eight lanes, one a byte, lowest first: the places of those chosen.
const PACKINGS: [u64; 256] = {
    let mut packings = [0; 256];
    let mut chosen = 0;
    while chosen < 256 {
        let (mut lane, mut count) = (0, 0);
        while lane < 8 {
            if chosen >> lane & 1 == 1 {
                packings[chosen] |= lane << (8 * count);
                count += 1;
            }
            lane += 1;
        }
        chosen += 1;
    }
    packings
};

/// For each choice of four lanes twice as wide: the places of those chosen, then of the others.
static ORDERS: Orders = Orders({
    let mut orders = [[0; 8]; 16];
    let mut chosen = 0;
    while chosen < 16 {
        let (mut lane, mut first, mut rest) = (0, 0, (chosen as u32).count_ones() as usize);
        while lane < 4 {
            let place = if chosen >> lane & 1 == 1 { &mut first } else { &mut rest };
            (orders[chosen][2 * *place], orders[chosen][2 * *place + 1]) = (2 * lane, 2 * lane + 1);
            *place += 1;
            lane += 1;
        }
        chosen += 1;
    }
    orders
});

/// Each in one register, and in one cache line.
#[repr(C, align(32))]
struct Orders([[u32; 8]; 16]);

/// The order of eight lanes that brings those chosen to the front.
#[inline(always)]
fn packing(chosen: usize) -> __m256i {
    // SAFETY: see above.
    unsafe { _mm256_cvtepu8_epi32(_mm_cvtsi64_si128(PACKINGS[chosen] as i64)) }
}

/// Four numbers, the chosen ones first.
#[inline(always)]
fn packed4(four: __m256i, chosen: usize) -> __m256i {
    // SAFETY: see above.
    unsafe { _mm256_permutevar8x32_epi32(four, _mm256_loadu_si256(ORDERS.0[chosen % 16].as_ptr().cast())) }
}

/// Whether all of four places are of a list.
#[inline(always)]
fn is_within(places: __m128i, count: usize) -> bool {
    let Some(last) = count.checked_sub(1) else { return false };
    // SAFETY: see above.
    unsafe {
        let last = _mm_set1_epi32(last.min(u32::MAX as usize) as u32 as i32);
        _mm_movemask_epi8(_mm_cmpeq_epi32(_mm_max_epu32(places, last), last)) == 0xffff
    }
}

/// Four points by axis.
#[inline(always)]
fn points(x: [&[f64; 3]; 4]) -> [One<__m256d>; 3] {
    // SAFETY: see above; three numbers of each point are read.
    unsafe {
        let three = _mm256_setr_epi64x(-1, -1, -1, 0);
        let mut rows = [_mm256_setzero_pd(); 4];
        for i in 0..4 {
            rows[i] = _mm256_maskload_pd(x[i].as_ptr(), three);
        }
        let (xz, xz_next) = (_mm256_unpacklo_pd(rows[0], rows[1]), _mm256_unpacklo_pd(rows[2], rows[3]));
        let (y, y_next) = (_mm256_unpackhi_pd(rows[0], rows[1]), _mm256_unpackhi_pd(rows[2], rows[3]));
        [
            One(_mm256_permute2f128_pd::<0x20>(xz, xz_next)),
            One(_mm256_permute2f128_pd::<0x20>(y, y_next)),
            One(_mm256_permute2f128_pd::<0x31>(xz, xz_next)),
        ]
    }
}

/// One bit for each of four lanes that are all ones.
#[inline(always)]
fn chosen4(four: __m256i) -> usize {
    // SAFETY: see above.
    unsafe { _mm256_movemask_pd(_mm256_castsi256_pd(four)) as usize }
}

/// Signed numbers in the order of these unsigned ones: AVX2 compares no others.
#[inline(always)]
fn as_signed(four: __m256i) -> __m256i {
    // SAFETY: see above.
    unsafe { _mm256_xor_si256(four, _mm256_set1_epi64x(i64::MIN)) }
}

impl Arithmetic for OneRegister {
    const WIDE: usize = WIDE_LANES / 2;
    type F32 = One<__m256>;
    type F64 = One<__m256d>;
    type M32 = One<__m256>;
    type M64 = One<__m256d>;

    #[inline(always)]
    fn splat(self, x: f32) -> Self::F32 {
        // SAFETY: see above.
        unsafe { One(_mm256_set1_ps(x)) }
    }
    #[inline(always)]
    fn mul_add(self, a: Self::F32, b: Self::F32, c: Self::F32) -> Self::F32 {
        // SAFETY: see above.
        unsafe { One(_mm256_fmadd_ps(a.0, b.0, c.0)) }
    }
    #[inline(always)]
    fn mul_sub(self, a: Self::F32, b: Self::F32, c: Self::F32) -> Self::F32 {
        // SAFETY: see above.
        unsafe { One(_mm256_fmsub_ps(a.0, b.0, c.0)) }
    }
    #[inline(always)]
    fn min(self, a: Self::F32, b: Self::F32) -> Self::F32 {
        // SAFETY: see above.
        unsafe { One(_mm256_min_ps(a.0, b.0)) }
    }
    #[inline(always)]
    fn max(self, a: Self::F32, b: Self::F32) -> Self::F32 {
        // SAFETY: see above.
        unsafe { One(_mm256_max_ps(a.0, b.0)) }
    }
    #[inline(always)]
    fn abs(self, a: Self::F32) -> Self::F32 {
        // SAFETY: see above.
        unsafe {
            let sign = _mm256_set1_ps(-0.0);
            One(_mm256_andnot_ps(sign, a.0))
        }
    }
    #[inline(always)]
    fn above(self, a: Self::F32, b: Self::F32) -> Self::M32 {
        // SAFETY: see above.
        unsafe { One(_mm256_cmp_ps::<_CMP_GT_OQ>(a.0, b.0)) }
    }
    #[inline(always)]
    fn lanes(self, mask: Self::M32) -> u16 {
        // SAFETY: see above.
        unsafe { _mm256_movemask_ps(mask.0) as u16 }
    }
    #[inline(always)]
    fn blend(self, mask: Self::M32, a: Self::F32, b: Self::F32) -> Self::F32 {
        // SAFETY: see above.
        unsafe { One(_mm256_blendv_ps(b.0, a.0, mask.0)) }
    }
    #[inline(always)]
    fn narrowed(self, low: Self::F64, high: Self::F64) -> Self::F32 {
        // SAFETY: see above.
        unsafe { One(_mm256_set_m128(_mm256_cvtpd_ps(high.0), _mm256_cvtpd_ps(low.0))) }
    }
    #[inline(always)]
    fn wide_splat(self, x: f64) -> Self::F64 {
        // SAFETY: see above.
        unsafe { One(_mm256_set1_pd(x)) }
    }
    #[inline(always)]
    fn wide_mul_add(self, a: Self::F64, b: Self::F64, c: Self::F64) -> Self::F64 {
        // SAFETY: see above.
        unsafe { One(_mm256_fmadd_pd(a.0, b.0, c.0)) }
    }
    #[inline(always)]
    fn wide_mul_sub(self, a: Self::F64, b: Self::F64, c: Self::F64) -> Self::F64 {
        // SAFETY: see above.
        unsafe { One(_mm256_fmsub_pd(a.0, b.0, c.0)) }
    }
    #[inline(always)]
    fn wide_abs(self, a: Self::F64) -> Self::F64 {
        // SAFETY: see above.
        unsafe {
            let sign = _mm256_set1_pd(-0.0);
            One(_mm256_andnot_pd(sign, a.0))
        }
    }
    #[inline(always)]
    fn wide_min(self, a: Self::F64, b: Self::F64) -> Self::F64 {
        // SAFETY: see above.
        unsafe { One(_mm256_min_pd(a.0, b.0)) }
    }
    #[inline(always)]
    fn wide_divide(self, a: Self::F64, b: Self::F64) -> Self::F64 {
        // SAFETY: see above.
        unsafe { One(_mm256_div_pd(a.0, b.0)) }
    }
    #[inline(always)]
    fn wide_max(self, a: Self::F64, b: Self::F64) -> Self::F64 {
        // SAFETY: see above.
        unsafe { One(_mm256_max_pd(a.0, b.0)) }
    }
    #[inline(always)]
    fn wide_above(self, a: Self::F64, b: Self::F64) -> Self::M64 {
        // SAFETY: see above.
        unsafe { One(_mm256_cmp_pd::<_CMP_GT_OQ>(a.0, b.0)) }
    }
    #[inline(always)]
    fn choose(self, mask: Self::M64, a: Self::F64, b: Self::F64) -> Self::F64 {
        // SAFETY: see above.
        unsafe { One(_mm256_blendv_pd(b.0, a.0, mask.0)) }
    }
    #[inline(always)]
    fn differing(self, a: Self::M64, b: Self::M64) -> Self::M64 {
        // SAFETY: see above.
        unsafe { One(_mm256_xor_pd(a.0, b.0)) }
    }
    #[inline(always)]
    fn both(self, a: Self::M64, b: Self::M64) -> Self::M64 {
        // SAFETY: see above.
        unsafe { One(_mm256_and_pd(a.0, b.0)) }
    }
    #[inline(always)]
    fn either(self, a: Self::M64, b: Self::M64) -> Self::M64 {
        // SAFETY: see above.
        unsafe { One(_mm256_or_pd(a.0, b.0)) }
    }
    #[inline(always)]
    fn bits(self, mask: Self::M64) -> u8 {
        // SAFETY: see above.
        unsafe { _mm256_movemask_pd(mask.0) as u8 }
    }
}

impl Arithmetic for Avx2 {
    const WIDE: usize = WIDE_LANES;
    type F32 = Two<One<__m256>>;
    type F64 = Two<One<__m256d>>;
    type M32 = Two<One<__m256>>;
    type M64 = Two<One<__m256d>>;

    #[inline(always)]
    fn splat(self, x: f32) -> Self::F32 {
        Two(self.part().splat(x), self.part().splat(x))
    }
    #[inline(always)]
    fn mul_add(self, a: Self::F32, b: Self::F32, c: Self::F32) -> Self::F32 {
        Two(self.part().mul_add(a.0, b.0, c.0), self.part().mul_add(a.1, b.1, c.1))
    }
    #[inline(always)]
    fn mul_sub(self, a: Self::F32, b: Self::F32, c: Self::F32) -> Self::F32 {
        Two(self.part().mul_sub(a.0, b.0, c.0), self.part().mul_sub(a.1, b.1, c.1))
    }
    #[inline(always)]
    fn min(self, a: Self::F32, b: Self::F32) -> Self::F32 {
        Two(self.part().min(a.0, b.0), self.part().min(a.1, b.1))
    }
    #[inline(always)]
    fn max(self, a: Self::F32, b: Self::F32) -> Self::F32 {
        Two(self.part().max(a.0, b.0), self.part().max(a.1, b.1))
    }
    #[inline(always)]
    fn abs(self, a: Self::F32) -> Self::F32 {
        Two(self.part().abs(a.0), self.part().abs(a.1))
    }
    #[inline(always)]
    fn above(self, a: Self::F32, b: Self::F32) -> Self::M32 {
        Two(self.part().above(a.0, b.0), self.part().above(a.1, b.1))
    }
    #[inline(always)]
    fn lanes(self, mask: Self::M32) -> u16 {
        // Shifted by an instruction that the compiler does not look into: else it packs all lanes first, which takes twice as
        // many instructions.
        // SAFETY: see above.
        let high = unsafe { _pdep_u32(self.part().lanes(mask.1).into(), 0x8000_ff00) };
        self.part().lanes(mask.0) | high as u16
    }
    #[inline(always)]
    fn blend(self, mask: Self::M32, a: Self::F32, b: Self::F32) -> Self::F32 {
        Two(self.part().blend(mask.0, a.0, b.0), self.part().blend(mask.1, a.1, b.1))
    }
    #[inline(always)]
    fn narrowed(self, low: Self::F64, high: Self::F64) -> Self::F32 {
        Two(self.part().narrowed(low.0, low.1), self.part().narrowed(high.0, high.1))
    }
    #[inline(always)]
    fn wide_splat(self, x: f64) -> Self::F64 {
        Two(self.part().wide_splat(x), self.part().wide_splat(x))
    }
    #[inline(always)]
    fn wide_mul_add(self, a: Self::F64, b: Self::F64, c: Self::F64) -> Self::F64 {
        Two(self.part().wide_mul_add(a.0, b.0, c.0), self.part().wide_mul_add(a.1, b.1, c.1))
    }
    #[inline(always)]
    fn wide_mul_sub(self, a: Self::F64, b: Self::F64, c: Self::F64) -> Self::F64 {
        Two(self.part().wide_mul_sub(a.0, b.0, c.0), self.part().wide_mul_sub(a.1, b.1, c.1))
    }
    #[inline(always)]
    fn wide_abs(self, a: Self::F64) -> Self::F64 {
        Two(self.part().wide_abs(a.0), self.part().wide_abs(a.1))
    }
    #[inline(always)]
    fn wide_min(self, a: Self::F64, b: Self::F64) -> Self::F64 {
        Two(self.part().wide_min(a.0, b.0), self.part().wide_min(a.1, b.1))
    }
    #[inline(always)]
    fn wide_divide(self, a: Self::F64, b: Self::F64) -> Self::F64 {
        Two(self.part().wide_divide(a.0, b.0), self.part().wide_divide(a.1, b.1))
    }
    #[inline(always)]
    fn wide_max(self, a: Self::F64, b: Self::F64) -> Self::F64 {
        Two(self.part().wide_max(a.0, b.0), self.part().wide_max(a.1, b.1))
    }
    #[inline(always)]
    fn wide_above(self, a: Self::F64, b: Self::F64) -> Self::M64 {
        Two(self.part().wide_above(a.0, b.0), self.part().wide_above(a.1, b.1))
    }
    #[inline(always)]
    fn choose(self, mask: Self::M64, a: Self::F64, b: Self::F64) -> Self::F64 {
        Two(self.part().choose(mask.0, a.0, b.0), self.part().choose(mask.1, a.1, b.1))
    }
    #[inline(always)]
    fn differing(self, a: Self::M64, b: Self::M64) -> Self::M64 {
        Two(self.part().differing(a.0, b.0), self.part().differing(a.1, b.1))
    }
    #[inline(always)]
    fn both(self, a: Self::M64, b: Self::M64) -> Self::M64 {
        Two(self.part().both(a.0, b.0), self.part().both(a.1, b.1))
    }
    #[inline(always)]
    fn either(self, a: Self::M64, b: Self::M64) -> Self::M64 {
        Two(self.part().either(a.0, b.0), self.part().either(a.1, b.1))
    }
    #[inline(always)]
    fn bits(self, mask: Self::M64) -> u8 {
        self.part().bits(mask.0) | self.part().bits(mask.1) << 4
    }
}

impl Simd for Avx2 {
    type Part = OneRegister;
    type Few = Avx2;

    #[inline(always)]
    fn part(self) -> OneRegister {
        self.0
    }
    #[inline(always)]
    fn lines_part(self, list: &[CacheLine], at: &[u32]) -> LineLanes<Self::Part> {
        let at = &at[..WIDE_LANES];
        // SAFETY: see above; eight places are read, and all are found to be of the list. A line is eight numbers of 64 bits.
        unsafe {
            let (low, high) = (_mm_loadu_si128(at.as_ptr().cast()), _mm_loadu_si128(at[4..].as_ptr().cast()));
            assert!(is_within(_mm_max_epu32(low, high), list.len()));
            let mut columns = [[_mm256_setzero_pd(); WIDE_LANES]; 2];
            for half in 0..2 {
                for from in [0, 4] {
                    let mut rows = [_mm256_setzero_pd(); 4];
                    for i in 0..4 {
                        let line = std::ptr::from_ref(list.get_unchecked(at[4 * half + i] as usize));
                        rows[i] = _mm256_load_pd(line.cast::<f64>().add(from));
                    }
                    let (even, even_next) =
                        (_mm256_unpacklo_pd(rows[0], rows[1]), _mm256_unpacklo_pd(rows[2], rows[3]));
                    let (odd, odd_next) = (_mm256_unpackhi_pd(rows[0], rows[1]), _mm256_unpackhi_pd(rows[2], rows[3]));
                    columns[half][from] = _mm256_permute2f128_pd::<0x20>(even, even_next);
                    columns[half][from + 1] = _mm256_permute2f128_pd::<0x20>(odd, odd_next);
                    columns[half][from + 2] = _mm256_permute2f128_pd::<0x31>(even, even_next);
                    columns[half][from + 3] = _mm256_permute2f128_pd::<0x31>(odd, odd_next);
                }
            }
            let [low, high] = columns;
            // Two numbers of 32 bits in each of the last five; those of both halves come out by turns of two.
            let mut narrow = [One(_mm256_setzero_ps()); 10];
            for k in 0..5 {
                let (low, high) = (_mm256_castpd_ps(low[3 + k]), _mm256_castpd_ps(high[3 + k]));
                let two = [_mm256_shuffle_ps::<0x88>(low, high), _mm256_shuffle_ps::<0xdd>(low, high)];
                for i in 0..2 {
                    let in_order = _mm256_permute4x64_pd::<0b11_01_10_00>(_mm256_castps_pd(two[i]));
                    narrow[2 * k + i] = One(_mm256_castpd_ps(in_order));
                }
            }
            ([[One(low[0]), One(low[1]), One(low[2])], [One(high[0]), One(high[1]), One(high[2])]], narrow)
        }
    }
    #[inline(always)]
    fn faces_part(self, faces: &[[u32; 3]], list: &[[f64; 3]], at: &[u32]) -> [[One<__m256d>; 3]; 3] {
        let at = &at[..4];
        // SAFETY: see above; four places are read, and all are found to be of the faces; three numbers of each of these are
        // read, and all are found to be of the points.
        unsafe {
            assert!(is_within(_mm_loadu_si128(at.as_ptr().cast()), faces.len()));
            let faces = [0, 1, 2, 3].map(|i| faces.get_unchecked(at[i] as usize));
            let three = _mm_setr_epi32(-1, -1, -1, 0);
            let corners = faces.map(|face| _mm_maskload_epi32(face.as_ptr().cast(), three));
            let last = _mm_max_epu32(_mm_max_epu32(corners[0], corners[1]), _mm_max_epu32(corners[2], corners[3]));
            assert!(is_within(last, list.len()));
            let point = |i: usize, c: usize| list.get_unchecked(faces[i][c] as usize);
            let mut corners = [[One(_mm256_setzero_pd()); 3]; 3];
            for c in 0..3 {
                corners[c] = points([point(0, c), point(1, c), point(2, c), point(3, c)]);
            }
            corners
        }
    }
    #[inline(always)]
    fn few(self) -> Avx2 {
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
    fn load(self, x: &[f32; LANES]) -> Self::F32 {
        // SAFETY: see above.
        unsafe { Two(One(_mm256_loadu_ps(x.as_ptr())), One(_mm256_loadu_ps(x[8..].as_ptr()))) }
    }
    #[inline(always)]
    fn store(self, x: Self::F32, to: &mut [f32; LANES]) {
        // SAFETY: see above.
        unsafe {
            _mm256_storeu_ps(to.as_mut_ptr(), x.0 .0);
            _mm256_storeu_ps(to[8..].as_mut_ptr(), x.1 .0);
        }
    }
    #[inline(always)]
    fn load_part(self, x: &[f32; LANES], from: usize) -> One<__m256> {
        // SAFETY: see above.
        unsafe { One(_mm256_loadu_ps(x[from & 8..].as_ptr())) }
    }
    #[inline(always)]
    fn store_part(self, x: One<__m256>, to: &mut [f32; LANES], from: usize) {
        // SAFETY: see above.
        unsafe { _mm256_storeu_ps(to[from & 8..].as_mut_ptr(), x.0) }
    }
    #[inline(always)]
    fn widen_bytes(self, x: &[u8; LANES], from: usize) -> One<__m256> {
        // SAFETY: see above; eight bytes are read.
        unsafe { One(_mm256_cvtepi32_ps(_mm256_cvtepu8_epi32(_mm_loadl_epi64(x[from & 8..].as_ptr().cast())))) }
    }
    #[inline(always)]
    fn widen_field(self, x: &[u32; LANES], from: usize, field: u32) -> One<__m256> {
        // SAFETY: see above.
        unsafe {
            let bits = _mm256_loadu_si256(x[from & 8..].as_ptr().cast());
            let bits = _mm256_srlv_epi32(bits, _mm256_set1_epi32(10 * field as i32));
            One(_mm256_cvtepi32_ps(_mm256_and_si256(bits, _mm256_set1_epi32(1023))))
        }
    }
    #[inline(always)]
    fn smallest3(self, x: &[Self::F32; 3]) -> [f32; 4] {
        // SAFETY: see above.
        unsafe {
            let [x, y, z] = x.map(|Two(low, high)| _mm256_min_ps(low.0, high.0));
            let o = _mm256_setzero_ps();
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
            let [x, y, z] = x.map(|Two(low, high)| _mm256_max_ps(low.0, high.0));
            let o = _mm256_setzero_ps();
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
            let halves = [x.map(|two| two.0 .0), x.map(|two| two.1 .0)];
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
            let least = least_sides(boxes, b);
            let halves = [_mm256_permute4x64_epi64::<0x44>(least), _mm256_permute4x64_epi64::<0xee>(least)];
            // What is left after subtracting the side with saturation is not zero where it is below the least it must be.
            let mut below = _mm256_setzero_si256();
            for a in 0..3 {
                for half in 0..2 {
                    let least = _mm256_shuffle_epi8(halves[half], _mm256_set1_epi8(4 * a as i8));
                    let side = _mm256_loadu_si256(boxes.sides[a].as_ptr().add(32 * half).cast());
                    below = _mm256_or_si256(below, _mm256_subs_epu8(least, side));
                }
            }
            _mm256_movemask_epi8(_mm256_cmpeq_epi8(below, _mm256_setzero_si256())) as u32
        }
    }
    const IN_BYTES: bool = true;
    #[inline(always)]
    fn in_bytes(self, boxes: &ByteBoxes, b: [&[[f32; LANES]; 3]; 2]) -> ByteLanes {
        let mut lanes = ByteLanes { least: [[0; 2 * LANES]; 3], outside: 0 };
        // SAFETY: see above.
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
    #[inline(always)]
    fn lanes_meeting(self, lanes: &ByteLanes, boxes: &ByteBoxes, i: usize) -> u16 {
        let i = i % (2 * LANES);
        // SAFETY: see above.
        unsafe {
            // What is left after subtracting the side with saturation is not zero where it is below the least it must be.
            let mut below = [_mm_setzero_si128(); 3];
            for a in 0..3 {
                let (lower, upper) = (boxes.sides[a][i], boxes.sides[a][2 * LANES + i]);
                let (of_upper, of_lower) = lanes.least[a].split_at(LANES);
                let before = _mm_subs_epu8(_mm_loadu_si128(of_upper.as_ptr().cast()), _mm_set1_epi8(upper as i8));
                let after = _mm_subs_epu8(_mm_loadu_si128(of_lower.as_ptr().cast()), _mm_set1_epi8(lower as i8));
                below[a] = _mm_or_si128(before, after);
            }
            let below = _mm_or_si128(_mm_or_si128(below[0], below[1]), below[2]);
            _mm_movemask_epi8(_mm_cmpeq_epi8(below, _mm_setzero_si128())) as u16
        }
    }
    #[inline(always)]
    fn append(self, chosen: u16, from: &[u32; LANES], to: &mut [u32], at: usize) -> usize {
        let to = &mut to[at..at + LANES];
        let (low, high) = (chosen & 255, chosen >> 8);
        let count = low.count_ones() as usize;
        // SAFETY: see above; `to` has 16 numbers, and `count` is at most eight.
        unsafe {
            let first = _mm256_permutevar8x32_epi32(_mm256_loadu_si256(from.as_ptr().cast()), packing(low.into()));
            let second =
                _mm256_permutevar8x32_epi32(_mm256_loadu_si256(from[8..].as_ptr().cast()), packing(high.into()));
            _mm256_storeu_si256(to.as_mut_ptr().cast(), first);
            _mm256_storeu_si256(to.as_mut_ptr().add(count).cast(), second);
        }
        at + chosen.count_ones() as usize
    }
    #[inline(always)]
    fn append_wide(self, chosen: u8, from: &[u64; WIDE_LANES], to: &mut [u64], at: usize) -> usize {
        let to = &mut to[at..at + WIDE_LANES];
        let (low, high) = (chosen & 15, chosen >> 4);
        let count = low.count_ones() as usize;
        // SAFETY: see above; `to` has eight numbers, and `count` is at most four.
        unsafe {
            let first = packed4(_mm256_loadu_si256(from.as_ptr().cast()), low.into());
            let second = packed4(_mm256_loadu_si256(from[4..].as_ptr().cast()), high.into());
            _mm256_storeu_si256(to.as_mut_ptr().cast(), first);
            _mm256_storeu_si256(to.as_mut_ptr().add(count).cast(), second);
        }
        at + chosen.count_ones() as usize
    }
    const SORTS: bool = true;
    #[inline(always)]
    fn partition(self, keys: &mut [u64], room: &mut [u64], pivot: u64) -> usize {
        let n = keys.len();
        let room = &mut room[..n + WIDE_LANES];
        // Those above go to the end of the room, the first ones last.
        let (mut low, mut high, mut at) = (0, n + WIDE_LANES, 0);
        // SAFETY: see above. Four numbers are read at `at`, where they are, before four are written at `low`, which is at most
        // `at`, and at `high - 4`, which is `n + 4` less what went there, at most `at`.
        unsafe {
            let (keys, room) = (keys.as_mut_ptr(), room.as_mut_ptr());
            let limit = as_signed(_mm256_set1_epi64x(pivot.wrapping_add(1) as i64));
            while at + 4 <= n {
                let four = _mm256_loadu_si256(keys.add(at).cast());
                let below = chosen4(_mm256_cmpgt_epi64(limit, as_signed(four)));
                let parted = packed4(four, below);
                _mm256_storeu_si256(keys.add(low).cast(), parted);
                _mm256_storeu_si256(room.add(high - 4).cast(), parted);
                let count = below.count_ones() as usize;
                at += 4;
                low += count;
                high = high + count - 4;
            }
        }
        for at in at..n {
            let key = keys[at];
            room[high - 1] = key;
            keys[low] = key;
            low += usize::from(key <= pivot);
            high -= usize::from(key > pivot);
        }
        keys[low..].copy_from_slice(&room[high..]);
        low
    }
    #[inline(always)]
    fn sort_few(self, keys: &[u64], to: &mut [u64; FEW]) -> usize {
        let n = keys.len();
        // Signed, in the same order.
        let mut all = [i64::MAX; FEW];
        for (signed, key) in all[..n].iter_mut().zip(keys) {
            *signed = (*key ^ 1 << 63) as i64;
        }
        // SAFETY: see above.
        let places = unsafe {
            let mut smaller = [0u64; FEW];
            // Sixteen at a time, or they would not stay in registers.
            for from in (0..n).step_by(16) {
                let mut own = [_mm256_setzero_si256(); 4];
                for i in 0..4 {
                    own[i] = _mm256_loadu_si256(all[from + 4 * i..].as_ptr().cast());
                }
                let mut counts = [_mm256_setzero_si256(); 4];
                for key in &all[..n] {
                    let key = _mm256_set1_epi64x(*key);
                    for i in 0..4 {
                        counts[i] = _mm256_sub_epi64(counts[i], _mm256_cmpgt_epi64(own[i], key));
                    }
                }
                for i in 0..4 {
                    _mm256_storeu_si256(smaller[from + 4 * i..].as_mut_ptr().cast(), counts[i]);
                }
            }
            smaller
        };
        // The place of a number is how many are smaller. Equal ones have one place, and leave some as they were.
        let mut taken = 0;
        for (key, place) in keys.iter().zip(&places) {
            let place = *place as usize % FEW;
            to[place] = *key;
            taken |= 1 << place;
        }
        close_up(to, taken)
    }
    #[inline(always)]
    fn wide_load(self, x: &[f64; WIDE_LANES]) -> Self::F64 {
        let (low, high) = x.split_at(WIDE_LANES / 2);
        // SAFETY: see above; four numbers are read from each half.
        unsafe { Two(One(_mm256_loadu_pd(low.as_ptr())), One(_mm256_loadu_pd(high.as_ptr()))) }
    }
    #[inline(always)]
    fn wide_store(self, x: Self::F64, to: &mut [f64; WIDE_LANES]) {
        let (low, high) = to.split_at_mut(WIDE_LANES / 2);
        // SAFETY: see above; four numbers are written to each half.
        unsafe {
            _mm256_storeu_pd(low.as_mut_ptr(), x.0 .0);
            _mm256_storeu_pd(high.as_mut_ptr(), x.1 .0);
        }
    }
    #[inline(always)]
    fn wide_points(self, x: [&[f64; 3]; WIDE_LANES]) -> [Self::F64; 3] {
        let (low, high) = (points([x[0], x[1], x[2], x[3]]), points([x[4], x[5], x[6], x[7]]));
        [Two(low[0], high[0]), Two(low[1], high[1]), Two(low[2], high[2])]
    }
}
