//! Triangle pairs side by side, as many as a register of float32 holds (16, eight or four): what can be proven of them.
//!
//! The same test as [`intersect_triangle_triangle`](crate::intersect_triangle_triangle), from differences of corners that
//! float64 arithmetic took and that are rounded to float32. A sign counts where the number is beyond what rounding may have
//! done; a pair with any sign in doubt, about one in a hundred, is left to the test of one pair. So what is said here is exact.
//!
//! **Bounds.** With u = 2^-24, A, B, C, D, W the largest entries of the vectors below, each counted as at least `least`: an
//! entry of an edge or of `between` is off by at most 1.07 u of that (`least` is 16 times what `moved` may be off by, over u),
//! one of the normal by u N, N being its largest entry and 2^-26 A B, which covers the rounding of float64. A cross product of
//! two such vectors, at most 2 A B, is off by 4.14 u of that: 2.14 u by its arguments and 2 u by products and difference; less
//! where these are rounded at once. A dot product adds the other's 1.07 u and 3 u of its own, to first order. Products that
//! underflow are off by far less: no product of three counted entries is below 2^-96. Each bound is taken from the product times
//! a power of two that is above all sums of the terms, and by way of products above all cross products: where any of these could
//! overflow, it is infinite, and nothing is certain.

use crate::bounds::Triangle;
use crate::pose::Pose;
use crate::simd::{Arithmetic, Kernel, Level, Simd, LANES};
use crate::tool::Tool;

/// Half the distance from 1 to the next float32.
const UNIT_ROUNDOFF: f32 = f32::EPSILON / 2.0;

/// No entry counts as less, metres: 2^-32.
const LEAST: f32 = 1.0 / 4_294_967_296.0;

/// What [`least_of`] takes of the size of the numbers that [`moved`] adds up: 2^-21.
const MOVED_ROUNDOFF: f64 = 1.0 / 2_097_152.0;

/// What was proven of pairs, one bit each; in neither: in doubt.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Verdict {
    /// They share no point.
    pub apart: u16,
    /// They meet, [`Crossing`](crate::PairKind::Crossing).
    pub crossing: u16,
}

/// What can be proven of up to 16 pairs with an instruction set (the best, where the CPU lacks it). Bits beyond the pairs given
/// are zero.
pub fn prove(lanes: Level, pairs: &[(Triangle, Triangle)]) -> Verdict {
    let Some(last) = pairs.last() else {
        return Verdict::default();
    };
    let given = ((1u32 << pairs.len().min(LANES)) - 1) as u16;
    let (p, q) = (0..LANES).map(|i| pairs.get(i).unwrap_or(last)).copied().unzip();
    let Verdict { apart, crossing } = lanes.checked().run(Prove { p, q });
    Verdict { apart: apart & given, crossing: crossing & given }
}

struct Prove {
    p: Vec<Triangle>,
    q: Vec<Triangle>,
}

impl Kernel for Prove {
    type Output = Verdict;
    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> Verdict {
        let (part, half) = (s.part(), S::Part::WIDE);
        let mut places = [0; LANES];
        for i in 0..LANES {
            places[i] = i as u32;
        }
        let mut verdict = Verdict::default();
        for from in (0..LANES).step_by(2 * half) {
            let (low, high) = (&places[from..], &places[from + half..]);
            let low = Pairs::new(part, &s.triangles_part(&self.p, low), &s.triangles_part(&self.q, low));
            let high = Pairs::new(part, &s.triangles_part(&self.p, high), &s.triangles_part(&self.q, high));
            let of = intersect(part, &Pairs::narrowed(part, &low, &high), part.splat(LEAST));
            verdict.apart |= of.apart << from;
            verdict.crossing |= of.crossing << from;
        }
        verdict
    }
}

/// A point in lanes.
pub(crate) type Vector<F> = [F; 3];

/// Triangles in lanes moved by a pose; products and sums may be rounded at once, so not to the last bit as
/// [`Pose::apply`] does it: [`least_of`] covers that.
#[inline(always)]
pub(crate) fn moved<S: Arithmetic>(s: S, pose: &Pose, t: &[Vector<S::F64>; 3]) -> [Vector<S::F64>; 3] {
    let (rotation, translation) = (pose.rotation(), pose.translation());
    let mut out = *t;
    for a in 0..3 {
        let row = [s.wide_splat(rotation[a][0]), s.wide_splat(rotation[a][1]), s.wide_splat(rotation[a][2])];
        let o = s.wide_splat(translation[a]);
        for c in 0..3 {
            let [x, y, z] = t[c];
            out[c][a] = s.wide_mul_add(row[0], x, s.wide_mul_add(row[1], y, s.wide_mul_add(row[2], z, o)));
        }
    }
    out
}

/// What an entry must count as at least where the first triangle is [`moved`].
///
/// With S three times the tool's largest coordinate and the translation's: a moved coordinate is off by at most 2^-51 S, here
/// and by definition (products by 2^-53 S together, sums by three times that), so the one is off the other by 2^-50 S, and an
/// edge of two such corners by 2^-49 S, which is 2^-24 / 16 of this.
pub(crate) fn least_of(pose: &Pose, tool: &Tool) -> f32 {
    let size = 3.1 * tool.mesh().bounds().largest_coordinate() + pose.largest_translation();
    LEAST.max((MOVED_ROUNDOFF * size) as f32)
}

/// Pairs of triangles in lanes, by differences of their corners.
pub(crate) struct Pairs<F> {
    /// From the first corner of `q` to that of `p`.
    between: Vector<F>,
    /// From the first corner to the second and to the third.
    p: [Vector<F>; 2],
    q: [Vector<F>; 2],
    /// Of `q`, as long as the cross product of these two: taken in float64, as mock-ups have long and thin triangles.
    normal_q: Vector<F>,
}

impl<F: Copy> Pairs<F> {
    #[inline(always)]
    pub fn new<S: Arithmetic<F64 = F>>(s: S, p: &[Vector<F>; 3], q: &[Vector<F>; 3]) -> Pairs<F>
    where
        F: std::ops::Sub<Output = F> + std::ops::Mul<Output = F>,
    {
        let (a, b) = (minus(&q[1], &q[0]), minus(&q[2], &q[0]));
        let normal_q = [
            s.wide_mul_sub(a[1], b[2], a[2] * b[1]),
            s.wide_mul_sub(a[2], b[0], a[0] * b[2]),
            s.wide_mul_sub(a[0], b[1], a[1] * b[0]),
        ];
        Pairs { between: minus(&p[0], &q[0]), p: [minus(&p[1], &p[0]), minus(&p[2], &p[0])], q: [a, b], normal_q }
    }

    /// As many pairs as two parts of float64 have, rounded to float32.
    #[inline(always)]
    pub fn narrowed<S: Arithmetic<F32 = F>>(s: S, low: &Pairs<S::F64>, high: &Pairs<S::F64>) -> Pairs<F> {
        Pairs {
            between: narrowed(s, &low.between, &high.between),
            p: [narrowed(s, &low.p[0], &high.p[0]), narrowed(s, &low.p[1], &high.p[1])],
            q: [narrowed(s, &low.q[0], &high.q[0]), narrowed(s, &low.q[1], &high.q[1])],
            normal_q: narrowed(s, &low.normal_q, &high.normal_q),
        }
    }
}

/// What can be proven of a pair in each lane. No entry counts as less than `least`.
#[inline(always)]
pub(crate) fn intersect<S: Arithmetic>(s: S, pairs: &Pairs<S::F32>, least: S::F32) -> Verdict {
    let Pairs { between: w, p: [c, d], q: [a, b], normal_q: n } = pairs;
    let (size_a, size_b) = (largest(s, a, least), largest(s, b, least));
    let (size_c, size_d) = (largest(s, c, least), largest(s, d, least));
    let size_w = largest(s, w, least);
    let (size_p, size_q) = (s.max(size_c, size_d), s.max(size_a, size_b));

    // Heights over the plane of q, 18.3 u N (W + C) off, and below that of p, 55.4 u C D (W + A).
    let (nw, nc, nd) = (dot(s, n, w), dot(s, n, c), dot(s, n, d));
    let size_n = s.mul_add(s.splat(1.0 / 67_108_864.0) * size_a, size_b, largest(s, n, least * least));
    let most = s.splat(4.0) * size_n * (size_w + size_p);
    let of_p = Sides::new(s, [nw, nw + nc, nw + nd], most * s.splat(5.0 * UNIT_ROUNDOFF));
    let m = cross(s, c, d);
    let (mw, ma, mb) = (dot(s, &m, w), dot(s, &m, a), dot(s, &m, b));
    let most = s.splat(8.0) * size_c * size_d * (size_w + size_q);
    let of_q = Sides::new(s, [mw, mw - ma, mw - mb], most * s.splat(7.75 * UNIT_ROUNDOFF));
    let apart = of_p.known & !of_p.both | of_q.known & !of_q.both;
    let certain = of_p.known & of_q.known & of_p.both & of_q.both;
    if certain == 0 {
        return Verdict { apart, crossing: 0 };
    }

    // The planes' common line leaves each triangle through two edges. For an edge of p and one of q, directed as seen from the
    // corner that is alone, det(edge of p, edge of q, from a point of the latter to one of the former) says by its sign which
    // of the two the line passes first, by the same sign for all four. They are the nine of edges 0-1, 0-2 and 1-2, which follow
    // from four by what is known already: det(d - c, a, w + c) = det(d, a, w) - det(c, a, w) + det(c, d, a), and so on. The
    // longest sum, of all eight, is off by 293 u P Q (W + P or Q).
    let (wc, wd) = (cross(s, w, c), cross(s, w, d));
    let (ca, cb, da, db) = (dot(s, &wc, a), dot(s, &wc, b), dot(s, &wd, a), dot(s, &wd, b));
    let (ea, eb) = (da - ca + ma, db - cb + mb);
    let (cf, df) = (cb - ca + nc, db - da + nd);
    let ef = df - cf + (mb - ma);
    let (first_a, second_a) = of_p.cut(s, ca, da, ea);
    let (first_b, second_b) = of_p.cut(s, cb, db, eb);
    let (first_f, second_f) = of_p.cut(s, cf, df, ef);
    let ((x, y), (z, t)) = (of_q.cut(s, first_a, first_b, first_f), of_q.cut(s, second_a, second_b, second_f));
    let (highest, lowest) = (s.max(s.max(x, y), s.max(z, t)), s.min(s.min(x, y), s.min(z, t)));
    // The product in this order, so that it is infinite too where an entry of w x c is.
    let most = s.splat(64.0) * size_p * (size_w + s.max(size_p, size_q)) * size_q;
    let bound = most * s.splat(5.1 * UNIT_ROUNDOFF);
    let below = s.splat(0.0) - bound;
    // All ends of one before all of the other; or one before and one after.
    let separate = s.lanes(s.above(lowest, bound) | s.above(below, highest));
    let linked = s.lanes(s.above(highest, bound)) & s.lanes(s.above(below, lowest));
    Verdict { apart: apart | certain & separate, crossing: certain & linked }
}

/// On which sides of a plane the corners of a triangle lie.
struct Sides<S: Arithmetic> {
    /// The second corner lies on another side than the first.
    second: S::M32,
    /// The third does.
    third: S::M32,
    /// Corners lie on both sides, where `known`.
    both: u16,
    /// The sides of all corners are certain.
    known: u16,
}

impl<S: Arithmetic> Sides<S> {
    #[inline(always)]
    fn new(s: S, heights: [S::F32; 3], bound: S::F32) -> Sides<S> {
        let [x, y, z] = heights;
        let zero = s.splat(0.0);
        let known = s.lanes(s.above(s.min(s.min(s.abs(x), s.abs(y)), s.abs(z)), bound));
        let (x, y, z) = (s.above(x, zero), s.above(y, zero), s.above(z, zero));
        let (second, third) = (x ^ y, x ^ z);
        Sides { second, third, both: s.lanes(second | third), known }
    }

    /// Of what belongs to edges 0-1, 0-2 and 1-2 that of the two that pass through the plane, as if both led away from the
    /// corner that is alone, or both towards it.
    #[inline(always)]
    fn cut(&self, s: S, of_01: S::F32, of_02: S::F32, of_12: S::F32) -> (S::F32, S::F32) {
        (s.blend(self.second, of_01, of_12), s.blend(self.third, of_02, s.splat(0.0) - of_12))
    }
}

#[inline(always)]
fn cross<S: Arithmetic>(s: S, u: &Vector<S::F32>, v: &Vector<S::F32>) -> Vector<S::F32> {
    [s.mul_sub(u[1], v[2], u[2] * v[1]), s.mul_sub(u[2], v[0], u[0] * v[2]), s.mul_sub(u[0], v[1], u[1] * v[0])]
}

#[inline(always)]
fn dot<S: Arithmetic>(s: S, u: &Vector<S::F32>, v: &Vector<S::F32>) -> S::F32 {
    s.mul_add(u[0], v[0], s.mul_add(u[1], v[1], u[2] * v[2]))
}

/// The largest entry, at least `least`.
#[inline(always)]
fn largest<S: Arithmetic>(s: S, v: &Vector<S::F32>, least: S::F32) -> S::F32 {
    s.max(s.max(s.abs(v[0]), s.abs(v[1])), s.max(s.abs(v[2]), least))
}

#[inline(always)]
fn narrowed<S: Arithmetic>(s: S, low: &Vector<S::F64>, high: &Vector<S::F64>) -> Vector<S::F32> {
    [s.narrowed(low[0], high[0]), s.narrowed(low[1], high[1]), s.narrowed(low[2], high[2])]
}

#[inline(always)]
fn minus<F: Copy + std::ops::Sub<Output = F>>(p: &Vector<F>, q: &Vector<F>) -> Vector<F> {
    [p[0] - q[0], p[1] - q[1], p[2] - q[2]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bounds::Point;
    use crate::intersect_triangle_triangle::{intersect_triangle_triangle, PairKind};
    use proptest::prelude::*;

    /// On a lattice, free, long and thin; or on a lattice and off it by about what float32 can tell.
    fn triangle() -> impl Strategy<Value = Triangle> {
        let lattice = || prop::array::uniform3(prop::array::uniform3((-2i32..3).prop_map(f64::from)));
        let free = || prop::array::uniform3(prop::array::uniform3(-1.0f64..1.0));
        let moved = |(t, by, size): (Triangle, Triangle, f64)| -> Triangle {
            std::array::from_fn(|c| std::array::from_fn(|a| t[c][a] + size * by[c][a]))
        };
        let thin = |(t, by): (Triangle, Triangle)| [t[0], t[1].map(|x| 300.0 * x), t[0].map(|x| x + 0.01 * by[0][0])];
        let sizes = prop_oneof![Just(1e-7), Just(1e-6), Just(1e-5), Just(1e-3)];
        prop_oneof![lattice(), free(), (lattice(), free(), sizes).prop_map(moved), (free(), free()).prop_map(thin),]
            .prop_filter("area", |t| !crate::predicates::is_collinear(&t[0], &t[1], &t[2]))
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(20_000))]
        #[test]
        fn agrees_with_the_exact_test_at_every_level(
            pairs in prop::array::uniform16((triangle(), triangle())),
            scale in prop_oneof![3 => Just(1.0), 1 => Just(1e-9), 1 => Just(1e-13), 1 => Just(1e12), 1 => Just(1e13), 1 => Just(1e60)],
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

    proptest! {
        #![proptest_config(ProptestConfig { max_global_rejects: 20_000, ..ProptestConfig::with_cases(20_000) })]
        #[test]
        fn agrees_where_products_overflow(
            corners in prop::array::uniform6(prop::array::uniform3((-1.0f64..1.0, -12i32..24))),
        ) {
            let [a, b, c, d, e, f] = corners.map(|p| p.map(|(x, exponent)| x * 10f64.powi(exponent)));
            // Corners beside each other, however far out: thin ones too.
            let near = |p: Point, q: Point| -> Point { std::array::from_fn(|i| p[i] + q[i]) };
            let (p, q) = ([a, near(a, b), near(a, c)], [d, near(d, e), near(d, f)]);
            let has_area = |t: &Triangle| !crate::predicates::is_collinear(&t[0], &t[1], &t[2]);
            prop_assume!(has_area(&p) && has_area(&q));
            let kind = intersect_triangle_triangle(&p, &q);
            for level in Level::available() {
                let verdict = prove(level, &[(p, q)]);
                prop_assert!(verdict.apart == 0 || kind.is_none(), "{} {p:?} {q:?}", level.name());
                prop_assert!(verdict.crossing == 0 || kind == Some(PairKind::Crossing), "{} {p:?} {q:?}", level.name());
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
                let pairs: [(Triangle, Triangle); LANES] = std::array::from_fn(|_| (triangle(), triangle()));
                let verdict = prove(level, &pairs);
                apart += verdict.apart.count_ones();
                crossing += verdict.crossing.count_ones();
            }
            assert!(apart + crossing > 7_990 && crossing > 400, "{}: {apart} {crossing}", level.name());
        }
    }

    #[test]
    fn decides_long_thin_triangles() {
        // A metre long, a millimetre wide, in any direction, seen from the tip; and small ones near their far end. Four of
        // five at least, though float32 has seven digits: the normal is taken in float64.
        let mut state = 1u64;
        let mut random = move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
        };
        for level in Level::available() {
            let mut decided = 0;
            for _ in 0..500 {
                let pairs: [(Triangle, Triangle); LANES] = std::array::from_fn(|_| {
                    let (tip, end): (Point, Point) =
                        (std::array::from_fn(|_| random()), std::array::from_fn(|_| random()));
                    let long = [tip, end, end.map(|x| x + 2e-3 * random())];
                    let small = std::array::from_fn(|_| end.map(|x| x + 4e-3 * random()));
                    (small, long)
                });
                let verdict = prove(level, &pairs);
                decided += (verdict.apart | verdict.crossing).count_ones();
            }
            assert!(decided > 6_400, "{}: {decided}", level.name());
        }
    }
}
