//! The distance of eight pairs of triangles at once (after Ericson, as of one pair), and separating axes across two edges.
//!
//! The same steps as [`closest_within`] in the same order, so the same numbers; that works in units of the pair, a power of
//! two, which changes no rounding. Slivers, which take it more steps, and very large or small numbers are left to it.

use crate::constants::{GAP_ROUNDING, LANE_COORDINATES, LEAST_SQUARE, NARROW, OUTSIDE, SMALLEST, SQUARE_ROUNDING};
use crate::geometry::bounds::{Point, Triangle};
use crate::geometry::distance_triangle_triangle::{closest_within, Closest};
use crate::geometry::intersect_lanes::Vector;
use feeler_lanes::{Arithmetic, Checked, Kernel, Simd, WIDE_LANES};

/// The closest points of triangles that do **not collide**, as in [`closest_within`]: up to eight pairs; `None` in
/// unused lanes.
pub fn closest_apart<'a>(
    lanes: Checked,
    count: usize,
    pair: impl Fn(usize) -> (&'a Triangle, &'a Triangle),
    within: f64,
) -> [Option<Closest>; WIDE_LANES] {
    let mut found = [None; WIDE_LANES];
    if count == 0 {
        return found;
    }
    let pairs: [_; WIDE_LANES] = std::array::from_fn(|i| pair(i.min(count - 1)));
    let out = lanes.run(Apart { pairs: &pairs, within });
    for (i, (p, q)) in pairs.iter().enumerate().take(count) {
        if out.doubt >> i & 1 != 0 {
            found[i] = closest_within(p, q, within);
            continue;
        }
        let distance = out.squared[i].sqrt().max(SMALLEST);
        let at = |x: &[[f64; WIDE_LANES]; 3]| -> Point { std::array::from_fn(|a| x[a][i] + p[0][a]) };
        found[i] = (distance <= within).then(|| Closest { distance, on_p: at(&out.on_p), on_q: at(&out.on_q) });
    }
    found
}

/// Which of up to eight pairs a plane along an edge of each certainly separates by more than `within` (metres). It
/// finds most of the pairs that are apart and that neither boxes nor the planes of the two separate, with far fewer
/// operations than [`closest_apart`].
pub fn held_apart<'a>(
    lanes: Checked,
    count: usize,
    pair: impl Fn(usize) -> (&'a Triangle, &'a Triangle),
    within: f64,
) -> u8 {
    if count == 0 {
        return 0;
    }
    let pairs: [_; WIDE_LANES] = std::array::from_fn(|i| pair(i.min(count - 1)));
    lanes.run(HeldApart { pairs: &pairs, within }) & (u8::MAX >> (WIDE_LANES - count))
}

/// By lane; points are relative to the first corner of the first triangle.
struct Found {
    squared: [f64; WIDE_LANES],
    on_p: [[f64; WIDE_LANES]; 3],
    on_q: [[f64; WIDE_LANES]; 3],
    /// Pairs that are not done here.
    doubt: u8,
}

/// Three corners in lanes.
type Corners<S> = [Vector<<S as Arithmetic>::F64>; 3];

type EightPairs<'a> = [(&'a Triangle, &'a Triangle); WIDE_LANES];

/// The corners of both in lanes, from the first corner of the first triangle, and the largest coordinate.
#[inline(always)]
fn gathered<S: Simd>(s: S, pairs: &EightPairs<'_>) -> ([Corners<S>; 2], S::F64) {
    let (mut p, mut q) = ([[&[0.0; 3]; WIDE_LANES]; 3], [[&[0.0; 3]; WIDE_LANES]; 3]);
    for (i, pair) in pairs.iter().enumerate() {
        for c in 0..3 {
            p[c][i] = &pair.0[c];
            q[c][i] = &pair.1[c];
        }
    }
    let mut p = [s.wide_points(p[0]), s.wide_points(p[1]), s.wide_points(p[2])];
    let mut q = [s.wide_points(q[0]), s.wide_points(q[1]), s.wide_points(q[2])];
    let (origin, mut largest) = (p[0], s.wide_splat(0.0));
    for c in 0..3 {
        for a in 0..3 {
            p[c][a] = p[c][a] - origin[a];
            q[c][a] = q[c][a] - origin[a];
            largest = s.wide_max(largest, s.wide_max(s.wide_abs(p[c][a]), s.wide_abs(q[c][a])));
        }
    }
    ([p, q], largest)
}

/// Where no product leaves the range.
#[inline(always)]
fn fits<S: Simd>(s: S, largest: S::F64) -> S::M64 {
    let (least, most) = (s.wide_splat(LANE_COORDINATES.start), s.wide_splat(LANE_COORDINATES.end));
    s.both(s.wide_above(largest, least), s.wide_above(most, largest))
}

struct HeldApart<'a> {
    pairs: &'a EightPairs<'a>,
    within: f64,
}

impl Kernel for HeldApart<'_> {
    type Output = u8;

    /// Whatever the direction is, intervals along it that are apart by more than their uncertainty are proof.
    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> u8 {
        let ([p, q], largest) = gathered(s, self.pairs);
        // Each operation rounded once, so that every level drops the same pairs.
        let within = largest * s.wide_splat(GAP_ROUNDING) + s.wide_splat(self.within);
        let limit = within * within * s.wide_splat(1.0 + SQUARE_ROUNDING);
        let (least, zero) = (s.wide_splat(LEAST_SQUARE), s.wide_splat(0.0));
        let mut found = 0;
        for i in 0..3 {
            let u = sub::<S>(&p[(i + 1) % 3], &p[i]);
            for j in 0..3 {
                let n = cross::<S>(&u, &sub::<S>(&q[(j + 1) % 3], &q[j]));
                let square = dot::<S>(&n, &n);
                let ((a, b), (c, d)) = (interval(s, &n, &p), interval(s, &n, &q));
                let gap = s.wide_max(c - b, a - d);
                let is_apart = s.both(s.wide_above(gap, zero), s.wide_above(gap * gap, limit * square));
                found |= s.bits(s.both(is_apart, s.wide_above(square, least)));
            }
        }
        found & s.bits(fits(s, largest))
    }
}

struct Apart<'a> {
    pairs: &'a EightPairs<'a>,
    within: f64,
}

impl Kernel for Apart<'_> {
    type Output = Found;

    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> Found {
        let ([p, q], largest) = gathered(s, self.pairs);
        let (p, q) = (Side::new(s, p), Side::new(s, q));
        let fits = fits(s, largest);
        let doubt = !s.bits(s.both(fits, s.both(p.is_wide(s), q.is_wide(s))));
        let far = s.wide_splat(f64::INFINITY);
        let mut best = Best { squared: far, on_p: p.corners[0], on_q: q.corners[0] };
        if doubt | beyond(s, &p, &q, self.within) != u8::MAX {
            corners_and_edges(s, &p, &q, &mut best);
            edges(s, &p, &q, &mut best);
            faces(s, &p, &q, &mut best);
        }
        let zero = [[0.0; WIDE_LANES]; 3];
        let mut found = Found { squared: [0.0; WIDE_LANES], on_p: zero, on_q: zero, doubt };
        s.wide_store(best.squared, &mut found.squared);
        for a in 0..3 {
            s.wide_store(best.on_p[a], &mut found.on_p[a]);
            s.wide_store(best.on_q[a], &mut found.on_q[a]);
        }
        found
    }
}

struct Best<F> {
    squared: F,
    on_p: Vector<F>,
    on_q: Vector<F>,
}

/// Takes two points where they are chosen and nearer than the best so far.
#[inline(always)]
fn offer<S: Simd>(s: S, best: &mut Best<S::F64>, on_p: &Vector<S::F64>, on_q: &Vector<S::F64>, chosen: Option<S::M64>) {
    let d = sub::<S>(on_q, on_p);
    let squared = dot::<S>(&d, &d);
    let mut nearer = s.wide_above(best.squared, squared);
    if let Some(chosen) = chosen {
        nearer = s.both(nearer, chosen);
    }
    best.squared = s.choose(nearer, squared, best.squared);
    for a in 0..3 {
        best.on_p[a] = s.choose(nearer, on_p[a], best.on_p[a]);
        best.on_q[a] = s.choose(nearer, on_q[a], best.on_q[a]);
    }
}

/// Eight triangles.
struct Side<S: Simd> {
    corners: [Vector<S::F64>; 3],
    edges: [Vector<S::F64>; 3],
    inverse: [S::F64; 3],
    normal: Vector<S::F64>,
    /// The normal's square.
    square: S::F64,
}

impl<S: Simd> Side<S> {
    #[inline(always)]
    fn new(s: S, corners: [Vector<S::F64>; 3]) -> Side<S> {
        let edges = [
            sub::<S>(&corners[1], &corners[0]),
            sub::<S>(&corners[2], &corners[1]),
            sub::<S>(&corners[0], &corners[2]),
        ];
        let one = s.wide_splat(1.0);
        let inverse = [
            s.wide_divide(one, dot::<S>(&edges[0], &edges[0])),
            s.wide_divide(one, dot::<S>(&edges[1], &edges[1])),
            s.wide_divide(one, dot::<S>(&edges[2], &edges[2])),
        ];
        let normal = cross::<S>(&edges[0], &edges[1]);
        Side { corners, edges, inverse, normal, square: dot::<S>(&normal, &normal) }
    }

    /// Where they are not slivers, nor less. NaN, of edges without length, is not, and neither are specks.
    #[inline(always)]
    fn is_wide(&self, s: S) -> S::M64 {
        let wide = s.wide_above(self.square * self.inverse[0] * self.inverse[2], s.wide_splat(NARROW));
        s.both(wide, s.wide_above(self.square, s.wide_splat(LEAST_SQUARE)))
    }

    #[inline(always)]
    fn on_edge(&self, s: S, i: usize, point: &Vector<S::F64>) -> Vector<S::F64> {
        let t = dot::<S>(&sub::<S>(point, &self.corners[i]), &self.edges[i]) * self.inverse[i];
        along::<S>(&self.corners[i], clamped(s, t), &self.edges[i])
    }
}

#[inline(always)]
fn clamped<S: Simd>(s: S, t: S::F64) -> S::F64 {
    s.wide_min(s.wide_max(t, s.wide_splat(0.0)), s.wide_splat(1.0))
}

#[inline(always)]
fn sub<S: Simd>(a: &Vector<S::F64>, b: &Vector<S::F64>) -> Vector<S::F64> {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
fn dot<S: Simd>(a: &Vector<S::F64>, b: &Vector<S::F64>) -> S::F64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
fn cross<S: Simd>(a: &Vector<S::F64>, b: &Vector<S::F64>) -> Vector<S::F64> {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[inline(always)]
fn along<S: Simd>(a: &Vector<S::F64>, t: S::F64, b: &Vector<S::F64>) -> Vector<S::F64> {
    [a[0] + t * b[0], a[1] + t * b[1], a[2] + t * b[2]]
}

/// The least and greatest height of corners along a normal.
#[inline(always)]
fn interval<S: Simd>(s: S, n: &Vector<S::F64>, t: &Corners<S>) -> (S::F64, S::F64) {
    let h = [dot::<S>(n, &t[0]), dot::<S>(n, &t[1]), dot::<S>(n, &t[2])];
    (s.wide_min(s.wide_min(h[0], h[1]), h[2]), s.wide_max(s.wide_max(h[0], h[1]), h[2]))
}

/// Which pairs the plane of either triangle holds clearly farther apart than a limit.
#[inline(always)]
fn beyond<S: Simd>(s: S, p: &Side<S>, q: &Side<S>, within: f64) -> u8 {
    let mut found = 0;
    for side in [p, q] {
        let ((a, b), (c, d)) = (interval(s, &side.normal, &p.corners), interval(s, &side.normal, &q.corners));
        let gap = s.wide_max(c - b, a - d);
        let limit = s.wide_splat(within * within * (1.0 + SQUARE_ROUNDING)) * side.square;
        found |= s.bits(s.both(s.wide_above(gap, s.wide_splat(0.0)), s.wide_above(gap * gap, limit)));
    }
    found
}

#[inline(always)]
fn corners_and_edges<S: Simd>(s: S, p: &Side<S>, q: &Side<S>, best: &mut Best<S::F64>) {
    for i in 0..3 {
        for j in 0..3 {
            offer(s, best, &p.corners[j], &q.on_edge(s, i, &p.corners[j]), None);
            offer(s, best, &p.on_edge(s, i, &q.corners[j]), &q.corners[j], None);
        }
    }
}

#[inline(always)]
fn edges<S: Simd>(s: S, p: &Side<S>, q: &Side<S>, best: &mut Best<S::F64>) {
    let (below, over) = (s.wide_splat(-OUTSIDE), s.wide_splat(1.0 + OUTSIDE));
    let (zero, least, narrow) = (s.wide_splat(0.0), s.wide_splat(LEAST_SQUARE), s.wide_splat(NARROW));
    for i in 0..3 {
        for j in 0..3 {
            let (a, u) = (&p.corners[i], &p.edges[i]);
            let (b, v) = (&q.corners[j], &q.edges[j]);
            let n = cross::<S>(u, v);
            let nn = dot::<S>(&n, &n);
            let inverse = s.wide_divide(s.wide_splat(1.0), nn);
            let rn = cross::<S>(&sub::<S>(b, a), &n);
            let x = (zero - dot::<S>(&rn, v)) * inverse;
            let y = (zero - dot::<S>(&rn, u)) * inverse;
            // Written so that NaN is inside; it is left out by `least`.
            let outside = s.either(
                s.either(s.wide_above(below, x), s.wide_above(x, over)),
                s.either(s.wide_above(below, y), s.wide_above(y, over)),
            );
            let is_narrow = s.wide_above(narrow, nn * p.inverse[i] * q.inverse[j]);
            let is_left_out = s.differing(outside, s.both(outside, is_narrow));
            let some = s.wide_above(nn, least);
            let chosen = s.differing(some, s.both(some, is_left_out));
            if s.bits(chosen) == 0 {
                continue;
            }
            let on_p = along::<S>(a, clamped(s, x), u);
            let on_q = q.on_edge(s, j, &on_p);
            offer(s, best, &p.on_edge(s, i, &on_q), &on_q, Some(chosen));
        }
    }
}

#[inline(always)]
fn faces<S: Simd>(s: S, p: &Side<S>, q: &Side<S>, best: &mut Best<S::F64>) {
    for corner in &p.corners {
        if let Some((foot, chosen)) = on_face(s, q, corner) {
            offer(s, best, corner, &foot, Some(chosen));
        }
    }
    for corner in &q.corners {
        if let Some((foot, chosen)) = on_face(s, p, corner) {
            offer(s, best, &foot, corner, Some(chosen));
        }
    }
}

/// The foot of a point on the faces, and where it lies inside; `None` where it is in none.
#[inline(always)]
fn on_face<S: Simd>(s: S, side: &Side<S>, point: &Vector<S::F64>) -> Option<(Vector<S::F64>, S::M64)> {
    let (zero, one) = (s.wide_splat(0.0), s.wide_splat(1.0));
    let inverse = s.wide_divide(one, side.square);
    let (a, u) = (&side.corners[0], &side.edges[0]);
    let v = &[zero - side.edges[2][0], zero - side.edges[2][1], zero - side.edges[2][2]];
    let (x, y) = weights::<S>(&sub::<S>(point, a), u, v, &side.normal, inverse);
    let (below, over) = (s.wide_splat(-OUTSIDE), s.wide_splat(1.0 + OUTSIDE));
    let outside = s.either(s.either(s.wide_above(below, x), s.wide_above(below, y)), s.wide_above(x + y, over));
    if s.bits(outside) == u8::MAX {
        return None;
    }
    let foot = along::<S>(&along::<S>(a, x, u), y, v);
    let (dx, dy) = weights::<S>(&sub::<S>(point, &foot), u, v, &side.normal, inverse);
    let (x, y) = (x + dx, y + dy);
    let beside = s.either(s.either(s.wide_above(zero, x), s.wide_above(zero, y)), s.wide_above(x + y, one));
    let every = s.wide_above(one, zero);
    let chosen = s.differing(every, s.either(outside, beside));
    Some((along::<S>(&along::<S>(a, x, u), y, v), chosen))
}

/// The weights of `u` and `v`, whose product is `n`, in the rest to a point.
#[inline(always)]
fn weights<S: Simd>(
    left: &Vector<S::F64>,
    u: &Vector<S::F64>,
    v: &Vector<S::F64>,
    n: &Vector<S::F64>,
    inverse: S::F64,
) -> (S::F64, S::F64) {
    (dot::<S>(&cross::<S>(left, v), n) * inverse, dot::<S>(&cross::<S>(u, left), n) * inverse)
}

#[cfg(test)]
mod tests {
    use super::*;
    use feeler_lanes::Level;
    use proptest::prelude::*;

    /// Coordinates of many sizes, and often the same, so that edges are parallel and faces in one plane.
    fn coordinate() -> impl Strategy<Value = f64> {
        prop_oneof![(-4i32..5).prop_map(f64::from), -4.0f64..4.0, (-4.0f64..4.0).prop_map(|x| x * 1e-7), Just(1e9)]
    }

    fn triangle() -> impl Strategy<Value = Triangle> {
        prop::array::uniform3(prop::array::uniform3(coordinate()))
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(512))]
        #[test]
        fn every_level_gives_what_one_pair_at_a_time_gives(
            pairs in prop::collection::vec((triangle(), triangle()), 1..9),
            within in prop_oneof![Just(f64::INFINITY), 0.0f64..4.0],
        ) {
            let pairs: Vec<_> = pairs
                .into_iter()
                .filter(|(p, q)| closest_within(p, q, f64::INFINITY).is_some_and(|c| c.distance > 0.0))
                .collect();
            for level in Level::available() {
                let found = closest_apart(level.checked(), pairs.len(), |i| (&pairs[i].0, &pairs[i].1), within);
                let held = held_apart(level.checked(), pairs.len(), |i| (&pairs[i].0, &pairs[i].1), within);
                for (i, (p, q)) in pairs.iter().enumerate() {
                    prop_assert_eq!(found[i], closest_within(p, q, within), "{:?} {}", level, i);
                    prop_assert!(held >> i & 1 == 0 || found[i].is_none(), "{:?} {}", level, i);
                }
            }
        }
    }

    #[test]
    fn crossing_sticks_are_held_apart_by_their_edges() {
        // Neither boxes nor the planes of the two hold them apart.
        let p = [[-1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [0.0, 0.0, -1.0]];
        for gap in [1e-5, 0.3] {
            let q = [[-1.0, 1.0, gap], [1.0, -1.0, gap], [0.0, 0.1, 1.0 + gap]];
            let found = closest_within(&p, &q, f64::INFINITY).unwrap();
            assert!((found.distance - gap).abs() < 1e-12);
            for level in Level::available() {
                let held =
                    |within: f64| held_apart(level.checked(), 3, |i| if i == 1 { (&p, &p) } else { (&p, &q) }, within);
                assert_eq!([0.9, 1.0, 1.1].map(|share| held(share * gap)), [0b101, 0, 0], "{level:?} {gap}");
            }
        }
    }
}
