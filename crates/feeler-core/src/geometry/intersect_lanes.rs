//! Pairs of triangles side by side, as many as a register of float32 holds (16, eight or four): proven results only.
//!
//! The same test as [`intersect_triangle_triangle`](crate::geometry::intersect_triangle_triangle) (Möller 1997; Guigue and
//! Devillers 2003), in float32 with a forward error bound as in a floating-point filter (Shewchuk 1997). A sign counts
//! only if the number exceeds the possible rounding error; a pair with any uncertain sign, about one in a hundred, is
//! left to the test of single pairs. So the results here are exact.
//!
//! **Frame.** Pairs are tested as the tool sees them: g(x) = A (x - t), with the translation t of the pose and its
//! rotation R inverted, A. A map preserves collisions if it is invertible and does not mirror, so A may be inexact. In
//! that frame the data of the tool's triangles does not depend on the pose and is kept (`line_of`), one cache line
//! each; the mock-up's edges and one corner are transformed to it in float64. Everything is then rounded to float32.
//!
//! **Bounds.** With u = 2^-24, A, B, C, D, W the largest entries of the vectors below, each counted as at least `least`, P the
//! larger of C and D, Q of A and B. Let T be the tool's largest coordinate, S three times that and the translation's, and
//! `least` at least 2^-20 S. A corner p of the tool is off by A R p - p, at most 2^-48.4 S, since A R is off unity by 2^-46.8 in
//! each row at most, and by the rounding of its place in the world, which [`Pose::apply`] defines and which is at most 2^-51 S
//! an axis, turned: 2^-50.2 S. The float64 arithmetic of `between`, at most 18 roundings of T + W, adds 2^-50.4 S. Together that
//! is 0.08 u of what is counted, so with its rounding to float32 an entry of an edge or of `between` is off by at most 1.08 u.
//! A normal is off by u N, N being its largest entry and: of the mock-up 2^-22 A B, which covers float64 arithmetic on edges
//! that were turned; of the tool 2^-20 P P and P `least` / 8, which cover A R and places in the world. A cross product of two
//! edges or of one with `between`, at most 2 A B, is off by 4.2 u of A B: 2.2 u by its arguments and 2 u by products and
//! difference; less where these are rounded at once. A dot product adds the other's 1.08 u and 3 u of its own, to first order.
//! Products that underflow are off by far less: no product of three counted entries is below 2^-96. Each bound is taken from the
//! product times a power of two that is above all sums of the terms, and by way of products above all cross products: where any
//! of these could overflow, it is infinite, and nothing is certain.

use crate::constants::{LEAST_ENTRY, MOCKUP_NORMAL_ROUNDING, PLACE_ROUNDING, TOOL_NORMAL_ROUNDING, UNIT_ROUNDOFF_F32};
use crate::geometry::bounds::{Point, Triangle};
use crate::geometry::pose::Pose;
use feeler_lanes::{Arithmetic, CacheLine, Kernel, Level, LineLanes, Simd, LANES};

/// The proven results of pairs, one bit each; a pair in neither is undecided.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Verdict {
    /// They share no point.
    pub apart: u16,
    /// Colliding pairs, [`Crossing`](crate::PairKind::Crossing).
    pub crossing: u16,
}

/// Proves results of up to 16 pairs with an instruction set (the best one if the CPU lacks it). Bits beyond the given
/// pairs are zero.
pub fn prove(lanes: Level, pairs: &[(Triangle, Triangle)]) -> Verdict {
    prove_at(lanes, &Pose::IDENTITY, LEAST_ENTRY, pairs)
}

/// The same for triangles of a tool at a pose. No entry counts as less than `least`.
fn prove_at(lanes: Level, pose: &Pose, least: f32, pairs: &[(Triangle, Triangle)]) -> Verdict {
    let Some(last) = pairs.last() else {
        return Verdict::default();
    };
    let given = ((1u32 << pairs.len().min(LANES)) - 1) as u16;
    let of = |i: usize| pairs.get(i).unwrap_or(last);
    let (p, q) = ((0..LANES).map(|i| line_of(&of(i).0)).collect(), (0..LANES).flat_map(|i| of(i).1).collect());
    let Verdict { apart, crossing } = lanes.checked().run(Prove { seen: Seen::at(pose), least, p, q });
    Verdict { apart: apart & given, crossing: crossing & given }
}

struct Prove {
    seen: Seen,
    least: f32,
    p: Vec<CacheLine>,
    /// Three corners a triangle.
    q: Vec<Point>,
}

impl Kernel for Prove {
    type Output = Verdict;
    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> Verdict {
        let part = s.part();
        let (mut places, mut faces) = ([0; LANES], [[0; 3]; LANES]);
        for i in 0..LANES {
            let n = i as u32;
            (places[i], faces[i]) = (n, [3 * n, 3 * n + 1, 3 * n + 2]);
        }
        let mut verdict = Verdict::default();
        for from in (0..LANES).step_by(2 * S::Part::WIDE) {
            let pairs = Pairs::of(s, &self.seen, (&self.p, &places[from..]), (&faces, &self.q, &places[from..]));
            let of = intersect(part, &pairs, part.splat(self.least));
            verdict.apart |= of.apart << from;
            verdict.crossing |= of.crossing << from;
        }
        verdict
    }
}

/// A point in lanes.
pub(crate) type Vector<F> = [F; 3];

/// A triangle of a tool in its own frame: the first corner; its edges to the second and to the third, a vector across it as long
/// as their cross product, and the largest entry of the edges.
pub(crate) fn line_of(t: &Triangle) -> CacheLine {
    let [c, d] = [1, 2].map(|i| minus(&t[i], &t[0]));
    let m = [c[1] * d[2] - c[2] * d[1], c[2] * d[0] - c[0] * d[2], c[0] * d[1] - c[1] * d[0]];
    let size = c.iter().chain(&d).fold(0.0, |size: f64, x| size.max(x.abs()));
    let [[a, b, c], [d, e, f], [g, h, i]] = [c, d, m].map(|v| v.map(|x| x as f32));
    // The next float32 at or above, so that nothing is larger.
    let size = if f64::from(size as f32) < size { (size as f32).next_up() } else { size as f32 };
    CacheLine { wide: t[0], narrow: [a, b, c, d, e, f, g, h, i, size] }
}

/// From where a tool at a pose sees the world.
pub(crate) struct Seen {
    /// Its rotation inverted, and negative, row by row.
    against: [[f64; 3]; 3],
    /// Its translation.
    from: Point,
}

impl Seen {
    pub(crate) fn at(pose: &Pose) -> Seen {
        let r = pose.rotation();
        let minor = |i: usize, j: usize| {
            let ([i, k], [j, l]) = ([(i + 1) % 3, (i + 2) % 3], [(j + 1) % 3, (j + 2) % 3]);
            r[i][j] * r[k][l] - r[i][l] * r[k][j]
        };
        let of_first = [minor(0, 0), minor(0, 1), minor(0, 2)];
        let share = -(r[0][0] * of_first[0] + r[0][1] * of_first[1] + r[0][2] * of_first[2]).recip();
        let mut against = [[0.0; 3]; 3];
        for i in 0..3 {
            for j in 0..3 {
                against[i][j] = share * minor(j, i);
            }
        }
        Seen { against, from: *pose.translation() }
    }
}

/// What an entry must count as at least at a pose, for a tool with no larger coordinate.
pub(crate) fn least_of(pose: &Pose, largest: f64) -> f32 {
    let size = 3.1 * largest + pose.largest_translation();
    LEAST_ENTRY.max((PLACE_ROUNDING * size) as f32)
}

/// Pairs of triangles in lanes, by differences of their corners, as the tool sees them.
pub(crate) struct Pairs<F> {
    /// From the first corner of `q` to that of `p`.
    between: Vector<F>,
    /// From the first corner to the second and to the third.
    p: [Vector<F>; 2],
    /// As long as the cross product of these two, and their largest entry. Taken in float64, as are those of `q`: both have
    /// long and thin triangles.
    normal_p: Vector<F>,
    size_p: F,
    q: [Vector<F>; 2],
    normal_q: Vector<F>,
}

impl<F: Copy> Pairs<F> {
    /// As many pairs as a part has lanes of float32: lines of a tool (by their places) and triangles of a mock-up (by faces and
    /// vertices, and their places).
    #[inline(always)]
    pub(crate) fn of<S: Simd>(
        s: S,
        seen: &Seen,
        (lines, p): (&[CacheLine], &[u32]),
        (faces, vertices, q): (&[[u32; 3]], &[Point], &[u32]),
    ) -> Pairs<F>
    where
        S::Part: Arithmetic<F32 = F>,
    {
        let part = s.part();
        let ([first, next], narrow): LineLanes<S::Part> = s.lines_part(lines, p);
        let low = Turned::new(part, seen, &first, &s.faces_part(faces, vertices, q));
        let high = Turned::new(part, seen, &next, &s.faces_part(faces, vertices, &q[S::Part::WIDE..]));
        let [a, b, c, d, e, f, g, h, i, size_p] = narrow;
        Pairs {
            between: narrowed(part, &low.between, &high.between),
            p: [[a, b, c], [d, e, f]],
            normal_p: [g, h, i],
            size_p,
            q: [narrowed(part, &low.q[0], &high.q[0]), narrowed(part, &low.q[1], &high.q[1])],
            normal_q: narrowed(part, &low.normal_q, &high.normal_q),
        }
    }
}

/// What a pair's triangle of the mock-up is to the tool, in float64.
struct Turned<F> {
    between: Vector<F>,
    q: [Vector<F>; 2],
    normal_q: Vector<F>,
}

impl<F: Copy> Turned<F> {
    #[inline(always)]
    fn new<S: Arithmetic<F64 = F>>(s: S, seen: &Seen, p: &Vector<F>, q: &[Vector<F>; 3]) -> Turned<F>
    where
        F: std::ops::Sub<Output = F> + std::ops::Mul<Output = F>,
    {
        let from = [s.wide_splat(seen.from[0]), s.wide_splat(seen.from[1]), s.wide_splat(seen.from[2])];
        // Each with its sign turned, as the rows have theirs.
        let (at, u, v) = (minus(&q[0], &from), minus(&q[0], &q[1]), minus(&q[0], &q[2]));
        let (mut between, mut a, mut b) = (*p, u, v);
        for i in 0..3 {
            let [x, y, z] = seen.against[i];
            let row = [s.wide_splat(x), s.wide_splat(y), s.wide_splat(z)];
            let last = s.wide_mul_add(row[2], at[2], p[i]);
            between[i] = s.wide_mul_add(row[0], at[0], s.wide_mul_add(row[1], at[1], last));
            a[i] = s.wide_mul_add(row[0], u[0], s.wide_mul_add(row[1], u[1], row[2] * u[2]));
            b[i] = s.wide_mul_add(row[0], v[0], s.wide_mul_add(row[1], v[1], row[2] * v[2]));
        }
        let normal_q = [
            s.wide_mul_sub(a[1], b[2], a[2] * b[1]),
            s.wide_mul_sub(a[2], b[0], a[0] * b[2]),
            s.wide_mul_sub(a[0], b[1], a[1] * b[0]),
        ];
        Turned { between, q: [a, b], normal_q }
    }
}

/// What can be proven of a pair in each lane. No entry counts as less than `least`.
#[inline(always)]
pub(crate) fn intersect<S: Arithmetic>(s: S, pairs: &Pairs<S::F32>, least: S::F32) -> Verdict {
    let Pairs { between: w, p: [c, d], normal_p: m, size_p, q: [a, b], normal_q: n } = pairs;
    let (size_a, size_b) = (largest(s, a, least), largest(s, b, least));
    let size_w = largest(s, w, least);
    let (size_p, size_q) = (s.max(*size_p, least), s.max(size_a, size_b));

    // Heights over the plane of q, 18.4 u N (W + P) off, and below that of p, as much with its own normal and Q.
    let (nw, nc, nd) = (dot(s, n, w), dot(s, n, c), dot(s, n, d));
    let size_n = s.mul_add(s.splat(MOCKUP_NORMAL_ROUNDING) * size_a, size_b, largest(s, n, least * least));
    let most = s.splat(4.0) * size_n * (size_w + size_p);
    let of_p = Sides::new(s, [nw, nw + nc, nw + nd], most * s.splat(5.0 * UNIT_ROUNDOFF_F32));
    let (mw, ma, mb) = (dot(s, m, w), dot(s, m, a), dot(s, m, b));
    let share = s.mul_add(s.splat(TOOL_NORMAL_ROUNDING), size_p, s.splat(0.125) * least);
    let size_m = s.mul_add(share, size_p, largest(s, m, least * least));
    let most = s.splat(4.0) * size_m * (size_w + size_q);
    let of_q = Sides::new(s, [mw, mw - ma, mw - mb], most * s.splat(5.0 * UNIT_ROUNDOFF_F32));
    let apart = of_p.known & !of_p.both | of_q.known & !of_q.both;
    let certain = of_p.known & of_q.known & of_p.both & of_q.both;
    if certain == 0 {
        return Verdict { apart, crossing: 0 };
    }

    // The planes' common line leaves each triangle through two edges. For an edge of p and one of q, directed as seen from the
    // corner that is alone, det(edge of p, edge of q, from a point of the latter to one of the former) says by its sign which
    // of the two the line passes first, by the same sign for all four. They are the nine of edges 0-1, 0-2 and 1-2, which follow
    // from four by what is known already: det(d - c, a, w + c) = det(d, a, w) - det(c, a, w) + det(c, d, a), and so on. The
    // longest sum, of all eight, is off by 297 u P Q (W + P or Q).
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
    let bound = most * s.splat(5.1 * UNIT_ROUNDOFF_F32);
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
        let known = s.lanes(s.above(s.min_abs(s.min_abs(x, y), z), bound));
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
    s.max_abs(s.max_abs(v[0], v[1]), s.max_abs(v[2], least))
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
    use crate::geometry::intersect_triangle_triangle::{intersect_triangle_triangle, PairKind};
    use crate::geometry::vectors::{add, along, cross, dot, unit};
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
            .prop_filter("area", |t| !crate::geometry::predicates::is_collinear(&t[0], &t[1], &t[2]))
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
            let has_area = |t: &Triangle| !crate::geometry::predicates::is_collinear(&t[0], &t[1], &t[2]);
            prop_assume!(has_area(&p) && has_area(&q));
            let kind = intersect_triangle_triangle(&p, &q);
            for level in Level::available() {
                let verdict = prove(level, &[(p, q)]);
                prop_assert!(verdict.apart == 0 || kind.is_none(), "{} {p:?} {q:?}", level.name());
                prop_assert!(verdict.crossing == 0 || kind == Some(PairKind::Crossing), "{} {p:?} {q:?}", level.name());
            }
        }
    }

    /// Turned at random, and as far from rigid as a pose may be.
    fn pose() -> impl Strategy<Value = Pose> {
        let far = prop_oneof![Just(0.0), Just(1.0), Just(1e3), Just(1e7), Just(1e8)];
        let off = prop_oneof![Just(0.0), Just(3e-7)];
        let numbers = || prop::array::uniform3(-1.0f64..1.0);
        (numbers(), numbers(), numbers(), prop::array::uniform3(numbers()), far, off).prop_filter_map(
            "three axes",
            |(x, y, t, by, far, off)| {
                let x = unit(&x)?;
                let y = unit(&along(&y, -dot(&x, &y), &x))?;
                let axes = [x, y, cross(&x, &y)];
                let row = |i: usize| [0, 1, 2].map(|j| axes[j][i] + off * by[i][j]);
                let [[a, b, c], [d, e, f], [g, h, i]] = [row(0), row(1), row(2)];
                let [x, y, z] = t.map(|t| far * t);
                Pose::new(&[[a, b, c, x], [d, e, f, y], [g, h, i, z], [0.0, 0.0, 0.0, 1.0]]).ok()
            },
        )
    }

    proptest! {
        #![proptest_config(ProptestConfig { max_global_rejects: 20_000, ..ProptestConfig::with_cases(20_000) })]
        #[test]
        fn agrees_with_the_exact_test_at_a_pose(
            pose in pose(),
            tool in prop::array::uniform16(triangle()),
            mockup in prop::array::uniform16(triangle()),
            scale in prop_oneof![Just(1.0), Just(1e-3), Just(1e-6), Just(1e3)],
            away in prop_oneof![Just(0.0), Just(1e3)],
            off in prop::array::uniform3(-1.0f64..1.0),
            by in prop_oneof![Just(0.0), Just(1e-8), Just(3e-6), Just(1e-5)],
        ) {
            // Near the tool's origin and far from it.
            let in_tool = |t: Triangle| t.map(|c| c.map(|x| (x + away) * scale));
            let tool = tool.map(in_tool);
            let largest = tool.as_flattened().as_flattened().iter().fold(0.0, |m: f64, x| m.max(x.abs()));
            let least = least_of(&pose, largest);
            // Corners of the mock-up where those of triangles beside the tool's are at the pose, or about so far off that it
            // matters.
            let off = off.map(|x| x * by * scale);
            let beside = |t: &Triangle| in_tool(*t).map(|c| add(&pose.apply(&c), &off));
            let placed = tool.map(|t| pose.apply_triangle(&t));
            let pairs: Vec<_> = tool.iter().copied().zip(mockup.iter().map(beside)).collect();
            let has_area = |t: &Triangle| !crate::geometry::predicates::is_collinear(&t[0], &t[1], &t[2]);
            prop_assume!(placed.iter().all(has_area) && pairs.iter().all(|(_, q)| has_area(q)));
            let kinds: Vec<_> = placed.iter().zip(&pairs).map(|(p, (_, q))| intersect_triangle_triangle(p, q)).collect();
            for level in Level::available() {
                let verdict = prove_at(level, &pose, least, &pairs);
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
