//! Eight triangle pairs at once: what float64 arithmetic can prove of them.
//!
//! The same test as [`intersect_triangle_triangle`](crate::intersect_triangle_triangle), with the same signs from bounds on
//! the rounding errors. A pair with any sign in doubt is left to the exact test, so what is said here is exact too.

use crate::bounds::{Point, Triangle};
use crate::constants::UNIT_ROUNDOFF;
use crate::pose::Pose;
use crate::predicates::{ORIENT3D_BOUND, SAFE_PERMANENT};
use crate::simd::{Kernel, Level, Simd, WIDE_LANES};

/// What was proven of eight pairs, one bit each; in neither: in doubt.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Verdict {
    /// They share no point.
    pub apart: u8,
    /// They meet, [`Crossing`](crate::PairKind::Crossing).
    pub crossing: u8,
}

/// What can be proven of up to eight pairs with an instruction set (the best, where the CPU lacks it). Bits beyond the pairs
/// given are zero.
pub fn prove(lanes: Level, pairs: &[(Triangle, Triangle)]) -> Verdict {
    let Some(last) = pairs.last() else {
        return Verdict { apart: 0, crossing: 0 };
    };
    let given = ((1u32 << pairs.len().min(WIDE_LANES)) - 1) as u8;
    let pairs: [&(Triangle, Triangle); WIDE_LANES] = std::array::from_fn(|i| pairs.get(i).unwrap_or(last));
    let Verdict { apart, crossing } = lanes.checked().run(Prove(&pairs));
    Verdict { apart: apart & given, crossing: crossing & given }
}

struct Prove<'a>(&'a [&'a (Triangle, Triangle); WIDE_LANES]);

impl Kernel for Prove<'_> {
    type Output = Verdict;
    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> Verdict {
        let (mut p, mut q) = ([[&[0.0; 3]; WIDE_LANES]; 3], [[&[0.0; 3]; WIDE_LANES]; 3]);
        for (i, pair) in self.0.iter().enumerate() {
            for c in 0..3 {
                p[c][i] = &pair.0[c];
                q[c][i] = &pair.1[c];
            }
        }
        intersect(s, &gathered(s, p), &gathered(s, q))
    }
}

/// A point in lanes.
pub(crate) type Vector<F> = [F; 3];

/// Eight triangles in lanes.
#[inline(always)]
pub(crate) fn gathered<S: Simd>(s: S, t: [[&Point; WIDE_LANES]; 3]) -> [Vector<S::F64>; 3] {
    [s.wide_points(t[0]), s.wide_points(t[1]), s.wide_points(t[2])]
}

/// Triangles in lanes moved by a pose, in the one order of operations that
/// [`Pose::apply`](crate::Pose::apply) defines.
#[inline(always)]
pub(crate) fn moved<S: Simd>(s: S, pose: &Pose, t: &[Vector<S::F64>; 3]) -> [Vector<S::F64>; 3] {
    let (rotation, translation) = (pose.rotation(), pose.translation());
    let mut out = *t;
    for a in 0..3 {
        let row = [s.wide_splat(rotation[a][0]), s.wide_splat(rotation[a][1]), s.wide_splat(rotation[a][2])];
        let o = s.wide_splat(translation[a]);
        for c in 0..3 {
            out[c][a] = ((row[0] * t[c][0] + row[1] * t[c][1]) + row[2] * t[c][2]) + o;
        }
    }
    out
}

/// What can be proven of eight pairs.
#[inline(always)]
pub(crate) fn intersect<S: Simd>(s: S, p: &[Vector<S::F64>; 3], q: &[Vector<S::F64>; 3]) -> Verdict {
    let of_p = Sides::new(s, q, p);
    if of_p.apart == u8::MAX {
        return Verdict { apart: of_p.apart, crossing: 0 };
    }
    let of_q = Sides::new(s, p, q);
    let apart = of_p.apart | of_q.apart;
    let certain = of_p.certain & of_q.certain & !apart;
    if certain == 0 {
        return Verdict { apart, crossing: 0 };
    }
    // As in the test of one pair: each triangle is turned so that its first corner is alone on its side of the other's
    // plane, and the other triangle is flipped where that side is the negative one.
    let (p, flip_q) = of_p.turned(s, p);
    let (q, flip_p) = of_q.turned(s, q);
    let (p, q) = (flipped(s, &p, flip_p), flipped(s, &q, flip_q));
    let (first_above, first_below) = orient3d(s, &p[0], &p[1], &q[0], &q[1]);
    let (second_above, second_below) = orient3d(s, &p[0], &p[2], &q[2], &q[0]);
    Verdict { apart: apart | certain & (first_above | second_above), crossing: certain & first_below & second_below }
}

/// The last two corners exchanged where chosen.
#[inline(always)]
fn flipped<S: Simd>(s: S, t: &[Vector<S::F64>; 3], flip: S::M64) -> [Vector<S::F64>; 3] {
    let mut out = *t;
    for a in 0..3 {
        out[1][a] = s.choose(flip, t[2][a], t[1][a]);
        out[2][a] = s.choose(flip, t[1][a], t[2][a]);
    }
    out
}

#[inline(always)]
fn all<S: Simd>(s: S, m: &[S::M64; 3]) -> u8 {
    s.bits(s.both(s.both(m[0], m[1]), m[2]))
}

/// On which sides of a plane the corners of a triangle lie.
struct Sides<M> {
    /// Orientation is certainly positive (and, where `certain`, negative if not).
    positive: [M; 3],
    /// All corners are certainly on one side.
    apart: u8,
    /// All three sides are certain.
    certain: u8,
}

impl<M: Copy> Sides<M> {
    /// Of the corners of `t` with respect to the planes of `of`.
    ///
    /// With A, B, C the largest entries of the two edges a, b and of a corner minus the plane's first: each difference has one
    /// rounding, so an entry of the normal, at most 2 A B, is off by at most 2 A B (2 + 1 + 1) u, and the dot product, at most
    /// 6 A B C, by 6 A B C (4 + 1 + 1 + 2) u to first order. 64 leaves a quarter for higher orders and this bound's own
    /// rounding. Products that underflow are off by far less than the second term.
    #[inline(always)]
    fn new<S: Simd<M64 = M>>(s: S, of: &[Vector<S::F64>; 3], t: &[Vector<S::F64>; 3]) -> Sides<M> {
        let (a, b) = (minus(&of[1], &of[0]), minus(&of[2], &of[0]));
        let n = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
        let v = [minus(&t[0], &of[0]), minus(&t[1], &of[0]), minus(&t[2], &of[0])];
        let reach = s.wide_max(s.wide_max(largest(s, &v[0]), largest(s, &v[1])), largest(s, &v[2]));
        let size = s.wide_splat(64.0 * UNIT_ROUNDOFF) * largest(s, &a) * largest(s, &b);
        let bound = size * reach + s.wide_splat(1e-200);
        let minus_bound = s.wide_splat(0.0) - bound;
        let none = s.wide_above(minus_bound, bound);
        let (mut positive, mut negative, mut known) = ([none; 3], [none; 3], [none; 3]);
        for c in 0..3 {
            let d = n[0] * v[c][0] + n[1] * v[c][1] + n[2] * v[c][2];
            // orient3d is positive below the plane of a counter-clockwise triangle.
            positive[c] = s.wide_above(minus_bound, d);
            negative[c] = s.wide_above(d, bound);
            known[c] = s.either(positive[c], negative[c]);
        }
        Sides { positive, apart: all(s, &positive) | all(s, &negative), certain: all(s, &known) }
    }

    /// The corners of `t` rotated so that the one alone on its side comes first; and where that is the negative side.
    #[inline(always)]
    fn turned<S: Simd<M64 = M>>(&self, s: S, t: &[Vector<S::F64>; 3]) -> ([Vector<S::F64>; 3], M) {
        let [x, y, z] = self.positive;
        // Two of the three agree. Corner 1 is alone where it differs from both others, and corner 2 likewise.
        let second = s.both(s.differing(x, y), s.differing(y, z));
        let third = s.both(s.differing(x, z), s.differing(y, z));
        let mut turned = *t;
        for c in 0..3 {
            for a in 0..3 {
                let [first, one, two] = [t[c][a], t[(c + 1) % 3][a], t[(c + 2) % 3][a]];
                turned[c][a] = s.choose(second, one, s.choose(third, two, first));
            }
        }
        // The lone corner is on the negative side where most are on the positive one.
        let most = s.either(s.both(x, y), s.both(z, s.either(x, y)));
        (turned, most)
    }
}

/// Where the orientation is certainly positive, and certainly negative.
#[inline(always)]
fn orient3d<S: Simd>(s: S, a: &Vector<S::F64>, b: &Vector<S::F64>, c: &Vector<S::F64>, d: &Vector<S::F64>) -> (u8, u8) {
    let (a, b, c) = (minus(a, d), minus(b, d), minus(c, d));
    let (bc, cb) = (b[0] * c[1], c[0] * b[1]);
    let (ca, ac) = (c[0] * a[1], a[0] * c[1]);
    let (ab, ba) = (a[0] * b[1], b[0] * a[1]);
    let det = a[2] * (bc - cb) + b[2] * (ca - ac) + c[2] * (ab - ba);
    let permanent = (s.wide_abs(bc) + s.wide_abs(cb)) * s.wide_abs(a[2])
        + (s.wide_abs(ca) + s.wide_abs(ac)) * s.wide_abs(b[2])
        + (s.wide_abs(ab) + s.wide_abs(ba)) * s.wide_abs(c[2]);
    let bound = s.wide_splat(ORIENT3D_BOUND) * permanent;
    let safe = s.wide_above(permanent, s.wide_splat(SAFE_PERMANENT));
    let above = s.both(safe, s.wide_above(det, bound));
    let below = s.both(safe, s.wide_above(s.wide_splat(0.0) - bound, det));
    (s.bits(above), s.bits(below))
}

#[inline(always)]
fn minus<F: Copy + std::ops::Sub<Output = F>>(p: &Vector<F>, q: &Vector<F>) -> Vector<F> {
    [p[0] - q[0], p[1] - q[1], p[2] - q[2]]
}

#[inline(always)]
fn largest<S: Simd>(s: S, v: &Vector<S::F64>) -> S::F64 {
    s.wide_max(s.wide_max(s.wide_abs(v[0]), s.wide_abs(v[1])), s.wide_abs(v[2]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::intersect_triangle_triangle::{intersect_triangle_triangle, PairKind};
    use proptest::prelude::*;

    fn triangle() -> impl Strategy<Value = Triangle> {
        let lattice = prop::array::uniform3(prop::array::uniform3((-2i32..3).prop_map(f64::from)));
        let free = prop::array::uniform3(prop::array::uniform3(-1.0f64..1.0));
        prop_oneof![lattice, free].prop_filter("area", |t| !crate::predicates::is_collinear(&t[0], &t[1], &t[2]))
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(20_000))]
        #[test]
        fn agrees_with_the_exact_test_at_every_level(
            pairs in prop::array::uniform8((triangle(), triangle())),
            scale in prop_oneof![Just(1.0), Just(1e-60), Just(1e60), Just(1e-120)],
        ) {
            let pairs = pairs.map(|(a, b)| (a.map(|c| c.map(|x| x * scale)), b.map(|c| c.map(|x| x * scale))));
            let plain = prove(Level::Portable, &pairs);
            prop_assert_eq!(plain.apart & plain.crossing, 0);
            for (i, (a, b)) in pairs.iter().enumerate() {
                let kind = intersect_triangle_triangle(a, b);
                prop_assert!(plain.apart >> i & 1 == 0 || kind.is_none());
                prop_assert!(plain.crossing >> i & 1 == 0 || kind == Some(PairKind::Crossing));
            }
            for level in Level::available() {
                prop_assert_eq!(prove(level, &pairs), plain, "{}", level.name());
            }
        }
    }

    #[test]
    fn decides_what_is_clear() {
        // Random triangles of a unit cube: hardly any pair is in doubt.
        let mut state = 1u64;
        let mut random = move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1u64 << 53) as f64
        };
        let mut triangle = || -> Triangle { std::array::from_fn(|_| std::array::from_fn(|_| random())) };
        let (mut apart, mut crossing) = (0, 0);
        for _ in 0..500 {
            let pairs: [(Triangle, Triangle); 8] = std::array::from_fn(|_| (triangle(), triangle()));
            let verdict = prove(Level::best(), &pairs);
            apart += verdict.apart.count_ones();
            crossing += verdict.crossing.count_ones();
        }
        assert!(apart + crossing == 4000 && crossing > 200, "{apart} {crossing}");
    }
}
