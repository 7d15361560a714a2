//! NEON, which every 64-bit ARM CPU has: sixteen float32 are four registers, and so are eight float64.
//!
//! The order of lanes in a register is that of little-endian machines.

use std::arch::aarch64::*;
use std::ops::{Add, BitOr, BitXor, Mul, Sub};

use super::arithmetic::{Arithmetic, ByteBoxes, ByteLanes, CacheLine, Kernel, LineLanes, Simd, LANES, WIDE_LANES};
use super::registers::{operators, One};

/// Whether the CPU has the features of [`Neon`].
pub fn is_there() -> bool {
    std::arch::is_aarch64_feature_detected!("neon")
}

/// Runs a kernel with NEON.
///
/// # Safety
/// The CPU must have the features of [`is_there`].
#[target_feature(enable = "neon")]
pub unsafe fn run_neon<K: Kernel>(kernel: K) -> K::Output {
    kernel.run(Neon(OneRegister(())))
}

/// The token of NEON: only [`run_neon`] makes one.
#[derive(Debug, Clone, Copy)]
pub struct Neon(OneRegister);

/// The token for a quarter of the lanes: only [`run_neon`] makes one.
#[derive(Debug, Clone, Copy)]
pub struct OneRegister(());

/// Four registers as one value.
#[derive(Debug, Clone, Copy)]
pub struct Four<T>([T; 4]);

operators! {
    Add, add, float32x4_t: vaddq_f32;
    Sub, sub, float32x4_t: vsubq_f32;
    Mul, mul, float32x4_t: vmulq_f32;
    BitOr, bitor, uint32x4_t: vorrq_u32;
    BitXor, bitxor, uint32x4_t: veorq_u32;
    Add, add, float64x2_t: vaddq_f64;
    Sub, sub, float64x2_t: vsubq_f64;
    Mul, mul, float64x2_t: vmulq_f64;
}

macro_rules! operators_of_four {
    ($($trait:ident, $name:ident;)*) => {$(
        impl<T: $trait<Output = T> + Copy> $trait for Four<T> {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                let (a, b) = (self.0, other.0);
                Four([
                    $trait::$name(a[0], b[0]),
                    $trait::$name(a[1], b[1]),
                    $trait::$name(a[2], b[2]),
                    $trait::$name(a[3], b[3]),
                ])
            }
        }
    )*};
}

operators_of_four! {
    Add, add;
    Sub, sub;
    Mul, mul;
    BitOr, bitor;
    BitXor, bitxor;
}

// SAFETY of all blocks below: the token says that the CPU has the instructions; loads and stores go to arrays of the
// register's size and ask for no alignment.

/// For each choice of four lanes, the places of the bytes that bring those chosen to the front.
static PACKINGS: Packings = Packings({
    let mut packings = [[0; 16]; 16];
    let mut chosen = 0;
    while chosen < 16 {
        let (mut lane, mut at) = (0, 0);
        while lane < 4 {
            if chosen >> lane & 1 == 1 {
                let mut byte = 0;
                while byte < 4 {
                    packings[chosen][at] = 4 * lane + byte;
                    at += 1;
                    byte += 1;
                }
            }
            lane += 1;
        }
        chosen += 1;
    }
    packings
});

/// Each in one register, and in one cache line.
#[repr(C, align(16))]
struct Packings([[u8; 16]; 16]);

/// Sixteen bytes as a register.
#[inline(always)]
fn bytes(x: &[u8; 16]) -> uint8x16_t {
    // SAFETY: see above.
    unsafe { vld1q_u8(x.as_ptr()) }
}

/// The sixteen bytes of a list from a place on.
#[inline(always)]
fn bytes_from(x: &[u8], from: usize) -> uint8x16_t {
    bytes(x[from..].first_chunk().expect("sixteen bytes"))
}

/// One bit for each of 32 bytes that are all ones or zeros.
#[inline(always)]
fn bits_of_bytes(low: uint8x16_t, high: uint8x16_t) -> u32 {
    const BIT_OF_BYTE: [u8; 16] = [1, 2, 4, 8, 16, 32, 64, 128, 1, 2, 4, 8, 16, 32, 64, 128];
    // SAFETY: see above. Sums of neighbours, three times: each eight bytes become one.
    unsafe {
        let bits = bytes(&BIT_OF_BYTE);
        let sums = vpaddq_u8(vandq_u8(low, bits), vandq_u8(high, bits));
        let sums = vpaddq_u8(sums, sums);
        vgetq_lane_u32::<0>(vreinterpretq_u32_u8(vpaddq_u8(sums, sums)))
    }
}

/// `a` where it is smaller, else `b`: the instruction for the smaller has other ideas of NaN and of zeros.
#[inline(always)]
fn smaller(a: float32x4_t, b: float32x4_t) -> float32x4_t {
    // SAFETY: see above.
    unsafe { vbslq_f32(vcltq_f32(a, b), a, b) }
}

/// `a` where it is larger, else `b`.
#[inline(always)]
fn larger(a: float32x4_t, b: float32x4_t) -> float32x4_t {
    // SAFETY: see above.
    unsafe { vbslq_f32(vcgtq_f32(a, b), a, b) }
}

/// Four sides of a box as whole numbers of bytes, clamped to 0 and 255; NaN gives 0.
#[inline(always)]
fn to_bytes(sides: &[f32; 4], boxes: &ByteBoxes) -> uint32x4_t {
    // SAFETY: see above. Of a number and NaN these instructions give the number; the conversion rounds halves to even.
    unsafe {
        let t = vsubq_f32(vld1q_f32(sides.as_ptr()), vld1q_f32(boxes.origin.as_ptr()));
        let t = vmulq_f32(t, vld1q_f32(boxes.per_unit.as_ptr()));
        vcvtnq_u32_f32(vminnmq_f32(vmaxnmq_f32(t, vdupq_n_f32(0.0)), vdupq_n_f32(255.0)))
    }
}

/// Four rows by column.
#[inline(always)]
fn transposed4(rows: [float32x4_t; 4]) -> [One<float32x4_t>; 4] {
    // SAFETY: see above.
    unsafe {
        let even = [vtrn1q_f32(rows[0], rows[1]), vtrn1q_f32(rows[2], rows[3])].map(|x| vreinterpretq_f64_f32(x));
        let odd = [vtrn2q_f32(rows[0], rows[1]), vtrn2q_f32(rows[2], rows[3])].map(|x| vreinterpretq_f64_f32(x));
        [
            One(vreinterpretq_f32_f64(vzip1q_f64(even[0], even[1]))),
            One(vreinterpretq_f32_f64(vzip1q_f64(odd[0], odd[1]))),
            One(vreinterpretq_f32_f64(vzip2q_f64(even[0], even[1]))),
            One(vreinterpretq_f32_f64(vzip2q_f64(odd[0], odd[1]))),
        ]
    }
}

/// Two points by axis.
#[inline(always)]
fn points(p: &[f64; 3], q: &[f64; 3]) -> [One<float64x2_t>; 3] {
    // SAFETY: see above; two numbers of each point are read at once, and the third on its own.
    unsafe {
        let (xy, xy_next) = (vld1q_f64(p.as_ptr()), vld1q_f64(q.as_ptr()));
        let z = vcombine_f64(vdup_n_f64(p[2]), vdup_n_f64(q[2]));
        [One(vzip1q_f64(xy, xy_next)), One(vzip2q_f64(xy, xy_next)), One(z)]
    }
}

impl Arithmetic for OneRegister {
    const WIDE: usize = WIDE_LANES / 4;
    type F32 = One<float32x4_t>;
    type F64 = One<float64x2_t>;
    type M32 = One<uint32x4_t>;
    type M64 = One<uint64x2_t>;

    #[inline(always)]
    fn splat(self, x: f32) -> Self::F32 {
        // SAFETY: see above.
        unsafe { One(vdupq_n_f32(x)) }
    }
    #[inline(always)]
    fn mul_add(self, a: Self::F32, b: Self::F32, c: Self::F32) -> Self::F32 {
        // SAFETY: see above.
        unsafe { One(vfmaq_f32(c.0, a.0, b.0)) }
    }
    #[inline(always)]
    fn mul_sub(self, a: Self::F32, b: Self::F32, c: Self::F32) -> Self::F32 {
        // SAFETY: see above.
        unsafe { One(vfmaq_f32(vnegq_f32(c.0), a.0, b.0)) }
    }
    #[inline(always)]
    fn min(self, a: Self::F32, b: Self::F32) -> Self::F32 {
        One(smaller(a.0, b.0))
    }
    #[inline(always)]
    fn max(self, a: Self::F32, b: Self::F32) -> Self::F32 {
        One(larger(a.0, b.0))
    }
    #[inline(always)]
    fn abs(self, a: Self::F32) -> Self::F32 {
        // SAFETY: see above.
        unsafe { One(vabsq_f32(a.0)) }
    }
    #[inline(always)]
    fn min_abs(self, a: Self::F32, b: Self::F32) -> Self::F32 {
        // SAFETY: see above. Of use without NaN only, and no zero has a sign: one instruction will do.
        unsafe { One(vminq_f32(vabsq_f32(a.0), vabsq_f32(b.0))) }
    }
    #[inline(always)]
    fn max_abs(self, a: Self::F32, b: Self::F32) -> Self::F32 {
        // SAFETY: see above.
        unsafe { One(vmaxq_f32(vabsq_f32(a.0), vabsq_f32(b.0))) }
    }
    #[inline(always)]
    fn above(self, a: Self::F32, b: Self::F32) -> Self::M32 {
        // SAFETY: see above.
        unsafe { One(vcgtq_f32(a.0, b.0)) }
    }
    #[inline(always)]
    fn lanes(self, mask: Self::M32) -> u16 {
        const BIT_OF_FOUR: [u32; 4] = [1, 2, 4, 8];
        // SAFETY: see above.
        unsafe { vaddvq_u32(vandq_u32(mask.0, vld1q_u32(BIT_OF_FOUR.as_ptr()))) as u16 }
    }
    #[inline(always)]
    fn blend(self, mask: Self::M32, a: Self::F32, b: Self::F32) -> Self::F32 {
        // SAFETY: see above.
        unsafe { One(vbslq_f32(mask.0, a.0, b.0)) }
    }
    #[inline(always)]
    fn narrowed(self, low: Self::F64, high: Self::F64) -> Self::F32 {
        // SAFETY: see above.
        unsafe { One(vcvt_high_f32_f64(vcvt_f32_f64(low.0), high.0)) }
    }
    #[inline(always)]
    fn wide_splat(self, x: f64) -> Self::F64 {
        // SAFETY: see above.
        unsafe { One(vdupq_n_f64(x)) }
    }
    #[inline(always)]
    fn wide_mul_add(self, a: Self::F64, b: Self::F64, c: Self::F64) -> Self::F64 {
        // SAFETY: see above.
        unsafe { One(vfmaq_f64(c.0, a.0, b.0)) }
    }
    #[inline(always)]
    fn wide_mul_sub(self, a: Self::F64, b: Self::F64, c: Self::F64) -> Self::F64 {
        // SAFETY: see above.
        unsafe { One(vfmaq_f64(vnegq_f64(c.0), a.0, b.0)) }
    }
    #[inline(always)]
    fn wide_abs(self, a: Self::F64) -> Self::F64 {
        // SAFETY: see above.
        unsafe { One(vabsq_f64(a.0)) }
    }
    #[inline(always)]
    fn wide_min(self, a: Self::F64, b: Self::F64) -> Self::F64 {
        // SAFETY: see above; see `smaller` for why it is two instructions.
        unsafe { One(vbslq_f64(vcltq_f64(a.0, b.0), a.0, b.0)) }
    }
    #[inline(always)]
    fn wide_divide(self, a: Self::F64, b: Self::F64) -> Self::F64 {
        // SAFETY: see above.
        unsafe { One(vdivq_f64(a.0, b.0)) }
    }
    #[inline(always)]
    fn wide_max(self, a: Self::F64, b: Self::F64) -> Self::F64 {
        // SAFETY: see above.
        unsafe { One(vbslq_f64(vcgtq_f64(a.0, b.0), a.0, b.0)) }
    }
    #[inline(always)]
    fn wide_above(self, a: Self::F64, b: Self::F64) -> Self::M64 {
        // SAFETY: see above.
        unsafe { One(vcgtq_f64(a.0, b.0)) }
    }
    #[inline(always)]
    fn choose(self, mask: Self::M64, a: Self::F64, b: Self::F64) -> Self::F64 {
        // SAFETY: see above.
        unsafe { One(vbslq_f64(mask.0, a.0, b.0)) }
    }
    #[inline(always)]
    fn differing(self, a: Self::M64, b: Self::M64) -> Self::M64 {
        // SAFETY: see above.
        unsafe { One(veorq_u64(a.0, b.0)) }
    }
    #[inline(always)]
    fn both(self, a: Self::M64, b: Self::M64) -> Self::M64 {
        // SAFETY: see above.
        unsafe { One(vandq_u64(a.0, b.0)) }
    }
    #[inline(always)]
    fn either(self, a: Self::M64, b: Self::M64) -> Self::M64 {
        // SAFETY: see above.
        unsafe { One(vorrq_u64(a.0, b.0)) }
    }
    #[inline(always)]
    fn bits(self, mask: Self::M64) -> u8 {
        const BIT_OF_TWO: [u64; 2] = [1, 2];
        // SAFETY: see above.
        unsafe { vaddvq_u64(vandq_u64(mask.0, vld1q_u64(BIT_OF_TWO.as_ptr()))) as u8 }
    }
}

/// Operations on four registers as those on each of them.
macro_rules! by_register {
    ($($name:ident($($value:ident: $type:ident),+) -> $result:ident;)*) => {$(
        #[inline(always)]
        fn $name(self, $($value: Self::$type),+) -> Self::$result {
            Four([
                self.0.$name($($value.0[0]),+),
                self.0.$name($($value.0[1]),+),
                self.0.$name($($value.0[2]),+),
                self.0.$name($($value.0[3]),+),
            ])
        }
    )*};
}

impl Arithmetic for Neon {
    const WIDE: usize = WIDE_LANES;
    type F32 = Four<One<float32x4_t>>;
    type F64 = Four<One<float64x2_t>>;
    type M32 = Four<One<uint32x4_t>>;
    type M64 = Four<One<uint64x2_t>>;

    by_register! {
        mul_add(a: F32, b: F32, c: F32) -> F32;
        mul_sub(a: F32, b: F32, c: F32) -> F32;
        min(a: F32, b: F32) -> F32;
        max(a: F32, b: F32) -> F32;
        abs(a: F32) -> F32;
        min_abs(a: F32, b: F32) -> F32;
        max_abs(a: F32, b: F32) -> F32;
        above(a: F32, b: F32) -> M32;
        blend(mask: M32, a: F32, b: F32) -> F32;
        wide_mul_add(a: F64, b: F64, c: F64) -> F64;
        wide_mul_sub(a: F64, b: F64, c: F64) -> F64;
        wide_abs(a: F64) -> F64;
        wide_min(a: F64, b: F64) -> F64;
        wide_divide(a: F64, b: F64) -> F64;
        wide_max(a: F64, b: F64) -> F64;
        wide_above(a: F64, b: F64) -> M64;
        choose(mask: M64, a: F64, b: F64) -> F64;
        differing(a: M64, b: M64) -> M64;
        both(a: M64, b: M64) -> M64;
        either(a: M64, b: M64) -> M64;
    }

    #[inline(always)]
    fn splat(self, x: f32) -> Self::F32 {
        Four([self.0.splat(x); 4])
    }
    #[inline(always)]
    fn lanes(self, mask: Self::M32) -> u16 {
        let [a, b, c, d] = mask.0.map(|one| one.0);
        // SAFETY: see above. Of each lane the lowest byte, in order.
        unsafe {
            let low = vuzp1q_u16(vreinterpretq_u16_u32(a), vreinterpretq_u16_u32(b));
            let high = vuzp1q_u16(vreinterpretq_u16_u32(c), vreinterpretq_u16_u32(d));
            let all = vuzp1q_u8(vreinterpretq_u8_u16(low), vreinterpretq_u8_u16(high));
            bits_of_bytes(all, all) as u16
        }
    }
    #[inline(always)]
    fn narrowed(self, low: Self::F64, high: Self::F64) -> Self::F32 {
        let (low, high) = (low.0, high.0);
        Four([
            self.0.narrowed(low[0], low[1]),
            self.0.narrowed(low[2], low[3]),
            self.0.narrowed(high[0], high[1]),
            self.0.narrowed(high[2], high[3]),
        ])
    }
    #[inline(always)]
    fn wide_splat(self, x: f64) -> Self::F64 {
        Four([self.0.wide_splat(x); 4])
    }
    #[inline(always)]
    fn bits(self, mask: Self::M64) -> u8 {
        const BIT_OF_EIGHT: [u16; 8] = [1, 2, 4, 8, 16, 32, 64, 128];
        let [a, b, c, d] = mask.0.map(|one| one.0);
        // SAFETY: see above. Of each lane the lowest 16 bits, in order.
        unsafe {
            let low = vuzp1q_u32(vreinterpretq_u32_u64(a), vreinterpretq_u32_u64(b));
            let high = vuzp1q_u32(vreinterpretq_u32_u64(c), vreinterpretq_u32_u64(d));
            let all = vuzp1q_u16(vreinterpretq_u16_u32(low), vreinterpretq_u16_u32(high));
            vaddvq_u16(vandq_u16(all, vld1q_u16(BIT_OF_EIGHT.as_ptr()))) as u8
        }
    }
}

// `partition` and `sort_few` use the standard library. A NEON register holds only two 64-bit numbers, so lanes would not be
// faster, and the library's sorts do not branch on the numbers either.
impl Simd for Neon {
    type Part = OneRegister;
    type Few = OneRegister;

    #[inline(always)]
    fn part(self) -> OneRegister {
        self.0
    }
    #[inline(always)]
    fn lines_part(self, list: &[CacheLine], at: &[u32]) -> LineLanes<OneRegister> {
        let at: &[u32; 4] = at.first_chunk().expect("as many places as lanes");
        let lines = at.map(|i| &list[i as usize]);
        let low = points(&lines[0].wide, &lines[1].wide);
        let high = points(&lines[2].wide, &lines[3].wide);
        // SAFETY: see above; of ten numbers four are read, then four, then two.
        unsafe {
            let narrow = lines.map(|line| line.narrow.as_ptr());
            let [a, b, c, d] = transposed4(narrow.map(|x| vld1q_f32(x)));
            let [e, f, g, h] = transposed4(narrow.map(|x| vld1q_f32(x.add(4))));
            let [i, j, ..] = transposed4(narrow.map(|x| vcombine_f32(vld1_f32(x.add(8)), vdup_n_f32(0.0))));
            ([low, high], [a, b, c, d, e, f, g, h, i, j])
        }
    }
    #[inline(always)]
    fn faces_part(self, faces: &[[u32; 3]], list: &[[f64; 3]], at: &[u32]) -> [[One<float64x2_t>; 3]; 3] {
        let at: &[u32; 2] = at.first_chunk().expect("as many places as lanes");
        let [p, q] = at.map(|i| &faces[i as usize]);
        let corner = |c: usize| points(&list[p[c] as usize], &list[q[c] as usize]);
        [corner(0), corner(1), corner(2)]
    }
    #[inline(always)]
    fn few(self) -> OneRegister {
        self.0
    }
    #[inline(always)]
    fn load_few(self, x: &[f32; LANES], from: usize) -> One<float32x4_t> {
        // SAFETY: see above; four numbers are there from 12 on.
        unsafe { One(vld1q_f32(x[from & 12..].as_ptr())) }
    }
    #[inline(always)]
    fn store_few(self, x: One<float32x4_t>, to: &mut [f32; LANES], from: usize) {
        // SAFETY: see above; four places are there from 12 on.
        unsafe { vst1q_f32(to[from & 12..].as_mut_ptr(), x.0) }
    }
    #[inline(always)]
    fn load_part(self, x: &[f32; LANES], from: usize) -> One<float32x4_t> {
        self.load_few(x, from)
    }
    #[inline(always)]
    fn store_part(self, x: One<float32x4_t>, to: &mut [f32; LANES], from: usize) {
        self.store_few(x, to, from);
    }
    #[inline(always)]
    fn widen_bytes(self, x: &[u8; LANES], from: usize) -> One<float32x4_t> {
        let from = from & 12;
        let four = u32::from_le_bytes([x[from], x[from + 1], x[from + 2], x[from + 3]]);
        // SAFETY: see above.
        unsafe { One(vcvtq_f32_u32(vmovl_u16(vget_low_u16(vmovl_u8(vcreate_u8(four.into())))))) }
    }
    #[inline(always)]
    fn widen_field(self, x: &[u32; LANES], from: usize, field: u32) -> One<float32x4_t> {
        // SAFETY: see above; four numbers are there from 12 on. To the left by less than nothing is to the right.
        unsafe {
            let bits = vshlq_u32(vld1q_u32(x[from & 12..].as_ptr()), vdupq_n_s32(-10 * field as i32));
            One(vcvtq_f32_u32(vandq_u32(bits, vdupq_n_u32(1023))))
        }
    }
    #[inline(always)]
    fn load(self, x: &[f32; LANES]) -> Self::F32 {
        Four([self.load_few(x, 0), self.load_few(x, 4), self.load_few(x, 8), self.load_few(x, 12)])
    }
    #[inline(always)]
    fn store(self, x: Self::F32, to: &mut [f32; LANES]) {
        for i in 0..4 {
            self.store_few(x.0[i], to, 4 * i);
        }
    }
    #[inline(always)]
    fn smallest3(self, x: &[Self::F32; 3]) -> [f32; 4] {
        let mut least = [0.0; 4];
        for a in 0..3 {
            let [p, q, r, s] = x[a].0.map(|one| one.0);
            // SAFETY: see above. Of a number and NaN these instructions give the number.
            least[a] = unsafe { vminnmvq_f32(vminnmq_f32(vminnmq_f32(p, q), vminnmq_f32(r, s))) };
        }
        least
    }
    #[inline(always)]
    fn largest3(self, x: &[Self::F32; 3]) -> [f32; 4] {
        let mut greatest = [0.0; 4];
        for a in 0..3 {
            let [p, q, r, s] = x[a].0.map(|one| one.0);
            // SAFETY: see above.
            greatest[a] = unsafe { vmaxnmvq_f32(vmaxnmq_f32(vmaxnmq_f32(p, q), vmaxnmq_f32(r, s))) };
        }
        greatest
    }
    #[inline(always)]
    fn transposed(self, x: &[Self::F32; 3], to: &mut [[f32; 4]; LANES]) {
        let to = to.as_flattened_mut();
        for i in 0..4 {
            // SAFETY: see above; sixteen numbers are written, from 48 of 64 on at most.
            unsafe {
                let rows = float32x4x4_t(x[0].0[i].0, x[1].0[i].0, x[2].0[i].0, vdupq_n_f32(0.0));
                vst4q_f32(to[16 * i..].as_mut_ptr(), rows);
            }
        }
    }
    #[inline(always)]
    fn is_apart(self, a: [&[f32; 4]; 2], b: [&[f32; 4]; 2]) -> bool {
        const AXES: [u32; 4] = [u32::MAX, u32::MAX, u32::MAX, 0];
        // SAFETY: see above.
        unsafe {
            let [[a_lower, a_upper], [b_lower, b_upper]] = [a, b].map(|sides| sides.map(|x| vld1q_f32(x.as_ptr())));
            let apart = vorrq_u32(vcgtq_f32(a_lower, b_upper), vcgtq_f32(b_lower, a_upper));
            vmaxvq_u32(vandq_u32(apart, vld1q_u32(AXES.as_ptr()))) != 0
        }
    }
    #[inline(always)]
    fn children_meeting(self, boxes: &ByteBoxes, b: [&[f32; 4]; 2]) -> u32 {
        // SAFETY: see above.
        unsafe {
            // 255 minus a byte is the byte with all bits turned.
            let before = vmvnq_u8(vreinterpretq_u8_u32(to_bytes(b[1], boxes)));
            let after = vreinterpretq_u8_u32(to_bytes(b[0], boxes));
            let before = [vdupq_laneq_u8::<0>(before), vdupq_laneq_u8::<4>(before), vdupq_laneq_u8::<8>(before)];
            let after = [vdupq_laneq_u8::<0>(after), vdupq_laneq_u8::<4>(after), vdupq_laneq_u8::<8>(after)];
            let mut met = [vdupq_n_u8(255); 2];
            for a in 0..3 {
                for half in 0..2 {
                    let lower = vcgeq_u8(bytes_from(&boxes.sides[a], 16 * half), before[a]);
                    let upper = vcgeq_u8(bytes_from(&boxes.sides[a], 32 + 16 * half), after[a]);
                    met[half] = vandq_u8(met[half], vandq_u8(lower, upper));
                }
            }
            bits_of_bytes(met[0], met[1])
        }
    }
    const IN_BYTES: bool = true;
    #[inline(always)]
    fn in_bytes(self, boxes: &ByteBoxes, b: [&[[f32; LANES]; 3]; 2]) -> ByteLanes {
        let mut lanes = ByteLanes { least: [[0; 2 * LANES]; 3], outside: 0 };
        // SAFETY: see above.
        unsafe {
            let (before, beyond) = (vdupq_n_f32(-1.0), vdupq_n_f32(256.0));
            let mut outside = [vdupq_n_u16(0); 2];
            for a in 0..3 {
                let (origin, per_unit) = (vdupq_n_f32(boxes.origin[a]), vdupq_n_f32(boxes.per_unit[a]));
                let mut sides = [[vdupq_n_s16(0); 2]; 2];
                for side in 0..2 {
                    let mut four = [vdup_n_s16(0); 4];
                    for i in 0..4 {
                        let t = vmulq_f32(vsubq_f32(self.load_few(&b[side][a], 4 * i).0, origin), per_unit);
                        // Of a number and NaN these instructions give the number: the first one decides what NaN becomes.
                        let t = if side == 0 {
                            vminnmq_f32(vmaxnmq_f32(t, before), beyond)
                        } else {
                            vmaxnmq_f32(vminnmq_f32(t, beyond), before)
                        };
                        // Halves are rounded to even.
                        four[i] = vmovn_s32(vcvtnq_s32_f32(t));
                    }
                    sides[side] = [vcombine_s16(four[0], four[1]), vcombine_s16(four[2], four[3])];
                }
                let [lower, upper] = sides;
                for half in 0..2 {
                    let above = vcgtq_s16(lower[half], vdupq_n_s16(255));
                    let below = vcltq_s16(upper[half], vdupq_n_s16(0));
                    outside[half] = vorrq_u16(outside[half], vorrq_u16(above, below));
                }
                let lower = vcombine_u8(vqmovun_s16(lower[0]), vqmovun_s16(lower[1]));
                let upper = vcombine_u8(vqmovun_s16(upper[0]), vqmovun_s16(upper[1]));
                let (of_upper, of_lower) = lanes.least[a].split_at_mut(LANES);
                vst1q_u8(of_upper.as_mut_ptr(), lower);
                vst1q_u8(of_lower.as_mut_ptr(), vmvnq_u8(upper));
            }
            let all = vcombine_u8(vmovn_u16(outside[0]), vmovn_u16(outside[1]));
            lanes.outside = bits_of_bytes(all, all) as u16;
        }
        lanes
    }
    #[inline(always)]
    fn lanes_meeting(self, lanes: &ByteLanes, boxes: &ByteBoxes, i: usize) -> u16 {
        let i = i % (2 * LANES);
        // SAFETY: see above.
        unsafe {
            let mut met = vdupq_n_u8(255);
            for a in 0..3 {
                let (lower, upper) = (boxes.sides[a][i], boxes.sides[a][2 * LANES + i]);
                let reaches = vcleq_u8(bytes_from(&lanes.least[a], 0), vdupq_n_u8(upper));
                let begins = vcleq_u8(bytes_from(&lanes.least[a], LANES), vdupq_n_u8(lower));
                met = vandq_u8(met, vandq_u8(reaches, begins));
            }
            bits_of_bytes(met, met) as u16
        }
    }
    #[inline(always)]
    fn append(self, chosen: u16, from: &[u32; LANES], to: &mut [u32], at: usize) -> usize {
        let to: &mut [u32; LANES] = to[at..].first_chunk_mut().expect("sixteen places");
        let mut count = 0;
        for i in 0..4 {
            let four = usize::from(chosen >> (4 * i) & 15);
            // SAFETY: see above; `count` is at most four times `i`, so that four places are there.
            unsafe {
                let numbers = vreinterpretq_u8_u32(vld1q_u32(from[4 * i..].as_ptr()));
                let packed = vqtbl1q_u8(numbers, bytes(&PACKINGS.0[four]));
                vst1q_u32(to[count..].as_mut_ptr(), vreinterpretq_u32_u8(packed));
            }
            count += four.count_ones() as usize;
        }
        at + count
    }
    #[inline(always)]
    fn append_wide(self, chosen: u8, from: &[u64; WIDE_LANES], to: &mut [u64], at: usize) -> usize {
        // Of two numbers the second comes first where it alone is chosen.
        const ORDERS: [[u8; 16]; 2] = [
            [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15],
            [8, 9, 10, 11, 12, 13, 14, 15, 8, 9, 10, 11, 12, 13, 14, 15],
        ];
        let to: &mut [u64; WIDE_LANES] = to[at..].first_chunk_mut().expect("eight places");
        let mut count = 0;
        for i in 0..4 {
            let two = chosen >> (2 * i) & 3;
            // SAFETY: see above; `count` is at most twice `i`, so that two places are there.
            unsafe {
                let numbers = vreinterpretq_u8_u64(vld1q_u64(from[2 * i..].as_ptr()));
                let packed = vqtbl1q_u8(numbers, bytes(&ORDERS[usize::from(two == 2)]));
                vst1q_u64(to[count..].as_mut_ptr(), vreinterpretq_u64_u8(packed));
            }
            count += two.count_ones() as usize;
        }
        at + count
    }
    #[inline(always)]
    fn wide_load(self, x: &[f64; WIDE_LANES]) -> Self::F64 {
        // SAFETY: see above; two numbers are there from 6 on.
        let two = |i: usize| unsafe { One(vld1q_f64(x[i..].as_ptr())) };
        Four([two(0), two(2), two(4), two(6)])
    }
    #[inline(always)]
    fn wide_store(self, x: Self::F64, to: &mut [f64; WIDE_LANES]) {
        for i in 0..4 {
            // SAFETY: see above; two places are there from 6 on.
            unsafe { vst1q_f64(to[2 * i..].as_mut_ptr(), x.0[i].0) }
        }
    }
    #[inline(always)]
    fn wide_points(self, x: [&[f64; 3]; WIDE_LANES]) -> [Self::F64; 3] {
        let two = [points(x[0], x[1]), points(x[2], x[3]), points(x[4], x[5]), points(x[6], x[7])];
        let axis = |a: usize| Four([two[0][a], two[1][a], two[2][a], two[3][a]]);
        [axis(0), axis(1), axis(2)]
    }
}
