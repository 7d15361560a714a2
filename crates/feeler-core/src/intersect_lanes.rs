//! Triangle pairs side by side, as many as a register holds (eight, four or two): what float64 arithmetic can prove of them.
//!
//! The same test as [`intersect_triangle_triangle`](crate::intersect_triangle_triangle), with the same signs from bounds on
//! the rounding errors. A pair with any sign in doubt is left to the exact test, so what is said here is exact too.

use crate::bounds::{Point, Triangle};
use crate::constants::UNIT_ROUNDOFF;
use crate::pose::Pose;
use crate::simd::{Arithmetic, Kernel, Level, Simd, WIDE_LANES};

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
        let wide = S::Part::WIDE;
        let mut verdict = Verdict::default();
        for (i, pairs) in self.0.chunks_exact(wide).enumerate() {
            let (mut p, mut q) = ([[&[0.0; 3]; WIDE_LANES]; 3], [[&[0.0; 3]; WIDE_LANES]; 3]);
            for (lane, pair) in pairs.iter().enumerate() {
                for c in 0..3 {
                    p[c][lane] = &pair.0[c];
                    q[c][lane] = &pair.1[c];
                }
            }
            verdict.set(wide * i, intersect(s.part(), &gathered_part(s, p), &gathered_part(s, q)));
        }
        verdict
    }
}

impl Verdict {
    /// Adds what was proven of the pairs from one on.
    #[inline(always)]
    pub(crate) fn set(&mut self, from: usize, of: Verdict) {
        self.apart |= of.apart << from;
        self.crossing |= of.crossing << from;
    }
}

/// A point in lanes.
pub(crate) type Vector<F> = [F; 3];

/// Eight triangles in lanes.
#[inline(always)]
pub(crate) fn gathered<S: Simd>(s: S, t: [[&Point; WIDE_LANES]; 3]) -> [Vector<S::F64>; 3] {
    [s.wide_points(t[0]), s.wide_points(t[1]), s.wide_points(t[2])]
}

/// As many triangles in lanes as a part has, the first of eight.
#[inline(always)]
pub(crate) fn gathered_part<S: Simd>(s: S, t: [[&Point; WIDE_LANES]; 3]) -> [Vector<<S::Part as Arithmetic>::F64>; 3] {
    [s.wide_points_part(t[0]), s.wide_points_part(t[1]), s.wide_points_part(t[2])]
}

/// Triangles in lanes moved by a pose, in the one order of operations that
/// [`Pose::apply`](crate::Pose::apply) defines.
#[inline(always)]
pub(crate) fn moved<S: Arithmetic>(s: S, pose: &Pose, t: &[Vector<S::F64>; 3]) -> [Vector<S::F64>; 3] {
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

/// What can be proven of a pair in each lane.
#[inline(always)]
pub(crate) fn intersect<S: Arithmetic>(s: S, p: &[Vector<S::F64>; 3], q: &[Vector<S::F64>; 3]) -> Verdict {
    let of_p = Sides::new(s, q, p);
    if of_p.apart.count_ones() as usize == S::WIDE {
        return Verdict { apart: of_p.apart, crossing: 0 };
    }
    let of_q = Sides::new(s, p, q);
    let apart = of_p.apart | of_q.apart;
    let certain = of_p.certain & of_q.certain & !apart;
    if certain == 0 {
        return Verdict { apart, crossing: 0 };
    }
    // As in the test of one pair: each triangle is turned so that its first corner is alone on its side of the other's
    // plane, and the other triangle is flipped (its last two corners exchanged) where that side is the negative one. With w
    // from the first corner of q to that of p, and u, v the edges from there, orient3d(p0, p1, q0, q1) is -w.(pu x qu), and
    // orient3d(p0, p2, q2, q0) is w.(pv x qv). Flipping one of the two exchanges edges of q (of p is as good, but for the
    // sign); flipping p changes both signs.
    let (p, flip_q) = of_p.turned(s, p);
    let (q, flip_p) = of_q.turned(s, q);
    let w = minus(&p[0], &q[0]);
    let (pu, pv) = (minus(&p[1], &p[0]), minus(&p[2], &p[0]));
    let (qu, qv) = exchanged(s, s.differing(flip_p, flip_q), &minus(&q[1], &q[0]), &minus(&q[2], &q[0]));
    let (first, second) = (dot(s, &cross(s, &pu, &qu), &w), dot(s, &cross(s, &pv, &qv), &w));
    // The bound of `Sides::new`. No entry of an edge is larger than the two largest from one corner together, and none of w
    // than the largest from p to one corner of q and an edge of q.
    let bound = error_bound(s, of_q.edges, of_p.edges, of_p.reach + of_p.edges);
    let (first_above, first_below) = signs(s, first, bound);
    let (second_above, second_below) = signs(s, second, bound);
    let flip = s.bits(flip_p);
    let separate = !flip & (first_below | second_above) | flip & (first_above | second_below);
    let linked = !flip & first_above & second_below | flip & first_below & second_above;
    Verdict { apart: apart | certain & separate, crossing: certain & linked }
}

/// What a product of three vectors, each a difference of two points, may be off by, with the largest entry of each.
///
/// With A, B, C these entries: each difference has one rounding, so an entry of the cross product, at most 2 A B, is off by at
/// most 2 A B (2 + 1 + 1) u, and the dot product, at most 6 A B C, by 6 A B C (4 + 1 + 1 + 2) u to first order; less where
/// products and sums are rounded at once. 64 leaves a quarter for higher orders and this bound's own rounding. Products that
/// underflow are off by far less than the second term.
#[inline(always)]
fn error_bound<S: Arithmetic>(s: S, a: S::F64, b: S::F64, c: S::F64) -> S::F64 {
    s.wide_mul_add(s.wide_splat(64.0 * UNIT_ROUNDOFF) * a * b, c, s.wide_splat(1e-200))
}

/// Which lanes are certainly above zero, and certainly below.
#[inline(always)]
fn signs<S: Arithmetic>(s: S, x: S::F64, bound: S::F64) -> (u8, u8) {
    (s.bits(s.wide_above(x, bound)), s.bits(s.wide_above(s.wide_splat(0.0) - bound, x)))
}

/// The two exchanged where chosen.
#[inline(always)]
fn exchanged<S: Arithmetic>(
    s: S,
    which: S::M64,
    u: &Vector<S::F64>,
    v: &Vector<S::F64>,
) -> (Vector<S::F64>, Vector<S::F64>) {
    let (mut a, mut b) = (*u, *v);
    for i in 0..3 {
        a[i] = s.choose(which, v[i], u[i]);
        b[i] = s.choose(which, u[i], v[i]);
    }
    (a, b)
}

#[inline(always)]
fn cross<S: Arithmetic>(s: S, u: &Vector<S::F64>, v: &Vector<S::F64>) -> Vector<S::F64> {
    [
        s.wide_mul_sub(u[1], v[2], u[2] * v[1]),
        s.wide_mul_sub(u[2], v[0], u[0] * v[2]),
        s.wide_mul_sub(u[0], v[1], u[1] * v[0]),
    ]
}

#[inline(always)]
fn dot<S: Arithmetic>(s: S, u: &Vector<S::F64>, v: &Vector<S::F64>) -> S::F64 {
    s.wide_mul_add(u[0], v[0], s.wide_mul_add(u[1], v[1], u[2] * v[2]))
}

/// On which sides of a plane the corners of a triangle lie.
struct Sides<S: Arithmetic> {
    /// Orientation is positive, where `certain`.
    positive: [S::M64; 3],
    /// All corners are certainly on one side.
    apart: u8,
    /// All three sides are certain.
    certain: u8,
    /// No entry of an edge of the triangle in the plane is larger.
    edges: S::F64,
    /// No entry of a vector from that triangle's first corner to a corner of the other is larger.
    reach: S::F64,
}

impl<S: Arithmetic> Sides<S> {
    /// Of the corners of `t` with respect to the planes of `of`.
    #[inline(always)]
    fn new(s: S, of: &[Vector<S::F64>; 3], t: &[Vector<S::F64>; 3]) -> Sides<S> {
        let (a, b) = (minus(&of[1], &of[0]), minus(&of[2], &of[0]));
        let n = cross(s, &a, &b);
        let v = [minus(&t[0], &of[0]), minus(&t[1], &of[0]), minus(&t[2], &of[0])];
        let reach = s.wide_max(s.wide_max(largest(s, &v[0]), largest(s, &v[1])), largest(s, &v[2]));
        let (largest_a, largest_b) = (largest(s, &a), largest(s, &b));
        let bound = error_bound(s, largest_a, largest_b, reach);
        let zero = s.wide_splat(0.0);
        let none = s.wide_above(zero, zero);
        let (mut positive, mut known) = ([none; 3], [none; 3]);
        for c in 0..3 {
            let d = dot(s, &n, &v[c]);
            // orient3d is positive below the plane of a counter-clockwise triangle.
            positive[c] = s.wide_above(zero, d);
            known[c] = s.wide_above(s.wide_abs(d), bound);
        }
        let certain = s.bits(s.both(s.both(known[0], known[1]), known[2]));
        let all = s.bits(s.both(s.both(positive[0], positive[1]), positive[2]));
        let any = s.bits(s.either(s.either(positive[0], positive[1]), positive[2]));
        Sides { positive, apart: certain & (all | !any), certain, edges: largest_a + largest_b, reach }
    }

    /// The corners of `t` rotated so that the one alone on its side comes first; and where that is the negative side.
    #[inline(always)]
    fn turned(&self, s: S, t: &[Vector<S::F64>; 3]) -> ([Vector<S::F64>; 3], S::M64) {
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

#[inline(always)]
fn minus<F: Copy + std::ops::Sub<Output = F>>(p: &Vector<F>, q: &Vector<F>) -> Vector<F> {
    [p[0] - q[0], p[1] - q[1], p[2] - q[2]]
}

#[inline(always)]
fn largest<S: Arithmetic>(s: S, v: &Vector<S::F64>) -> S::F64 {
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
            let kinds: Vec<_> = pairs.iter().map(|(a, b)| intersect_triangle_triangle(a, b)).collect();
            for level in Level::available() {
                let verdict = prove(level, &pairs);
                for (i, kind) in kinds.iter().enumerate() {
                    let name = level.name();
                    prop_assert!(verdict.apart >> i & 1 == 0 || kind.is_none(), "{}", name);
                    prop_assert!(verdict.crossing >> i & 1 == 0 || *kind == Some(PairKind::Crossing), "{}", name);
                }
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
        for level in Level::available() {
            let (mut apart, mut crossing) = (0, 0);
            for _ in 0..500 {
                let pairs: [(Triangle, Triangle); 8] = std::array::from_fn(|_| (triangle(), triangle()));
                let verdict = prove(level, &pairs);
                apart += verdict.apart.count_ones();
                crossing += verdict.crossing.count_ones();
            }
            assert!(apart + crossing == 4000 && crossing > 200, "{}: {apart} {crossing}", level.name());
        }
    }
}
