//! Cuts long triangles into pieces, for the index only, and chooses the piece size that limits their number.
//!
//! Early split clipping (M. Ernst and G. Greiner 2007), by halving quadrilaterals instead of clipping at planes. A long
//! triangle has a box that is nearly empty; the boxes of its pieces fit it closely. Queries still test the whole given
//! triangle, so pieces need only cover it.

use crate::constants::{CUT_ROUNDOFFS, LEAST_PIECE_ROUNDOFFS, MAX_CUT_DEPTH, UNIT_ROUNDOFF};
use crate::geometry::bounds::{Aabb, Piece, Point, Triangle};

/// Cuts the triangle into pieces with no side longer than `size` (metres) and hands each to `emit`.
///
/// A quadrilateral is halved across its longer pair of opposite sides, which gives two again; the triangle itself enters
/// as one whose third and fourth corner coincide, opposite its shortest side. So a needle as long as n sizes becomes about
/// n pieces in a row.
///
/// Corners of pieces are rounded, so a piece may lie off its exact place by [`cut_margin`]: boxes of pieces must grow by
/// that much to cover the triangle.
#[inline]
pub fn cut_triangle(t: &Triangle, size: f64, emit: &mut impl FnMut(&Piece)) {
    if is_short(t, size) {
        let [a, b, c] = *t;
        return emit(&[a, b, c, c]);
    }
    cut_long_triangle(t, size, emit);
}

/// Whether no edge is longer than `size`: the common case, for which nothing else needs to be known of the triangle.
#[inline]
fn is_short(t: &Triangle, size: f64) -> bool {
    let squared = |p: &Point, q: &Point| {
        let d = [p[0] - q[0], p[1] - q[1], p[2] - q[2]];
        d[0] * d[0] + d[1] * d[1] + d[2] * d[2]
    };
    let most = size * size;
    squared(&t[0], &t[1]) <= most && squared(&t[1], &t[2]) <= most && squared(&t[2], &t[0]) <= most
}

fn cut_long_triangle(t: &Triangle, size: f64, emit: &mut impl FnMut(&Piece)) {
    let size = size.max(least_piece_size(t));
    let (one, other) = first_cut(t, size);
    halve(&one, size, MAX_CUT_DEPTH, emit);
    if let Some(other) = other {
        halve(&other, size, MAX_CUT_DEPTH, emit);
    }
}

/// The start of cutting a triangle: one piece, or two.
pub fn first_cut(t: &Triangle, size: f64) -> (Piece, Option<Piece>) {
    let [shortest, middle, apex] = shortest_side_first(t);
    let (base, height) = base_and_height(t);
    if base <= size || height >= 0.5 * distance(&shortest, &middle) {
        return ([shortest, middle, apex, apex], None);
    }
    // Three long sides and little height: cut along the height first, so that each part has a short side.
    let [a, b, top] = longest_side_first(t);
    let along = |i: usize| (top[i] - a[i]) * ((b[i] - a[i]) / base);
    let share = ((along(0) + along(1) + along(2)) / base).clamp(0.0, 1.0);
    let foot: Point = std::array::from_fn(|i| a[i] + share * (b[i] - a[i]));
    ([foot, top, a, a], Some([foot, top, b, b]))
}

fn halve(q: &Piece, size: f64, depth: u32, emit: &mut impl FnMut(&Piece)) {
    match halves(q, size) {
        Some(halves) if depth > 0 => halves.iter().for_each(|half| halve(half, size, depth - 1, emit)),
        _ => emit(q),
    }
}

/// The halves of a piece with a side longer than `size`.
#[inline]
pub fn halves(q: &Piece, size: f64) -> Option<[Piece; 2]> {
    let [a, b, c, d] = q;
    let across = distance(a, b).max(distance(c, d));
    let along = distance(b, c).max(distance(d, a));
    if across.max(along) <= size {
        return None;
    }
    let middle = |p: &Point, q: &Point| -> Point { std::array::from_fn(|i| 0.5 * p[i] + 0.5 * q[i]) };
    Some(if along >= across {
        let (m, n) = (middle(b, c), middle(d, a));
        [[*a, *b, m, n], [n, m, *c, *d]]
    } else {
        let (m, n) = (middle(a, b), middle(c, d));
        [[*a, m, n, *d], [m, *b, *c, n]]
    })
}

/// How far (metres, per axis) a piece of a triangle with coordinates up to `largest` may lie off its exact place.
///
/// By induction over the cuts: if the ends of an edge are off by at most e, their computed midpoint is off by at most e
/// plus the rounding of one sum (halving is exact), which is at most one unit roundoff of `largest`. The foot of a height
/// may be off its edge by four of them, once. Every point of the triangle is a convex combination of exact corners of one
/// piece, hence within the same distance of the computed piece.
pub fn cut_margin(largest: f64) -> f64 {
    // The second term covers halving of denormals.
    CUT_ROUNDOFFS * UNIT_ROUNDOFF * largest + f64::MIN_POSITIVE
}

/// The piece size (metres) with which cutting adds about `allowance` times the number of triangles as extra pieces, never
/// more: the smallest on a ladder of half octaves down from the longest edge.
///
/// The rule knows no tool: it spends a fixed share of memory where the boxes are worst. At most 100,000 triangles, evenly
/// spread over the mesh, are looked at.
pub fn default_piece_size(triangles: usize, triangle: impl Fn(usize) -> Triangle, allowance: f64) -> f64 {
    let stride = triangles.div_ceil(100_000).max(1);
    let mut sampled: Vec<(f64, Triangle)> = (0..triangles)
        .step_by(stride)
        .map(|i| {
            let t = triangle(i);
            (longest_edge(&t), t)
        })
        .collect();
    let longest = sampled.iter().fold(0.0, |m: f64, (edge, _)| m.max(*edge));
    // Coordinates near the limits can make the squared edge overflow or vanish; no cutting is always right.
    if !(longest.is_finite() && longest > 0.0) {
        return f64::MAX;
    }
    let most = allowance * sampled.len() as f64;
    // Only those that are longer than a size become more than one piece: they come first.
    let (mut size, mut long) = (longest, 0);
    for _ in 0..2 * MAX_CUT_DEPTH {
        let next = size / std::f64::consts::SQRT_2;
        let mut at = long;
        while at < sampled.len() {
            if sampled[at].0 > next {
                sampled.swap(at, long);
                long += 1;
            }
            at += 1;
        }
        if sampled[..long].iter().map(|(_, t)| piece_bound(t, next) - 1.0).sum::<f64>() > most {
            break;
        }
        size = next;
    }
    size
}

/// A bound from above on the pieces of a triangle, cheap to compute: halvings of one pair of sides times halvings of the
/// other.
pub fn piece_bound(t: &Triangle, size: f64) -> f64 {
    let size = size.max(least_piece_size(t));
    let (base, height) = base_and_height(t);
    if base <= size {
        return 1.0;
    }
    let [a, b, _] = shortest_side_first(t);
    let shortest = distance(&a, &b);
    let halvings = |x: f64| (x / size).log2().max(0.0).ceil().exp2();
    if height >= 0.5 * shortest {
        halvings(base) * halvings(shortest)
    } else {
        2.0 * halvings(base) * halvings(height)
    }
}

/// A bound from below on the pieces of a triangle: one has sides up to `size`, so its area is at most the square of that, and
/// its length at most twice it.
pub fn least_pieces(t: &Triangle, size: f64) -> f64 {
    if is_short(t, size) {
        return 1.0;
    }
    let size = size.max(least_piece_size(t));
    (0.5 * twice_area(t) / size / size).max(0.5 * longest_edge(t) / size).max(1.0)
}

/// Below this size (metres) midpoints hardly move for rounding, and halving would not shorten the sides.
pub fn least_piece_size(t: &Triangle) -> f64 {
    LEAST_PIECE_ROUNDOFFS * UNIT_ROUNDOFF * t.iter().flatten().fold(0.0, |m: f64, x| m.max(x.abs()))
}

fn shortest_side_first(t: &Triangle) -> Triangle {
    let [ab, bc, ca] = edge_lengths(t);
    let [a, b, c] = *t;
    if ab <= bc && ab <= ca {
        [a, b, c]
    } else if bc <= ca {
        [b, c, a]
    } else {
        [c, a, b]
    }
}

fn longest_side_first(t: &Triangle) -> Triangle {
    let [ab, bc, ca] = edge_lengths(t);
    let [a, b, c] = *t;
    if ab >= bc && ab >= ca {
        [a, b, c]
    } else if bc >= ca {
        [b, c, a]
    } else {
        [c, a, b]
    }
}

fn base_and_height(t: &Triangle) -> (f64, f64) {
    let base = longest_edge(t);
    (base, twice_area(t) / base.max(f64::MIN_POSITIVE))
}

fn distance(p: &Point, q: &Point) -> f64 {
    ((p[0] - q[0]) * (p[0] - q[0]) + (p[1] - q[1]) * (p[1] - q[1]) + (p[2] - q[2]) * (p[2] - q[2])).sqrt()
}

/// Length of the longest edge, metres.
pub fn longest_edge(t: &Triangle) -> f64 {
    edge_lengths(t).into_iter().fold(0.0, f64::max)
}

/// Length of all sides of a piece, metres.
pub fn outline([a, b, c, d]: &Piece) -> f64 {
    distance(a, b) + distance(b, c) + distance(c, d) + distance(d, a)
}

/// Twice the area, square metres.
pub fn twice_area(t: &Triangle) -> f64 {
    let u: Point = std::array::from_fn(|i| t[1][i] - t[0][i]);
    let v: Point = std::array::from_fn(|i| t[2][i] - t[0][i]);
    let n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    // Squares of the largest normals would overflow.
    let m = n.iter().fold(f64::MIN_POSITIVE, |m, x| m.max(x.abs()));
    m * ((n[0] / m) * (n[0] / m) + (n[1] / m) * (n[1] / m) + (n[2] / m) * (n[2] / m)).sqrt()
}

/// Lengths of the three edges, metres.
pub fn edge_lengths(t: &Triangle) -> [f64; 3] {
    [distance(&t[0], &t[1]), distance(&t[1], &t[2]), distance(&t[2], &t[0])]
}

/// The box of a few points, grown by `margin` on every side.
#[inline]
pub fn grown_box(points: &[Point], margin: f64) -> Aabb {
    let mut b = Aabb::EMPTY;
    for p in points {
        b.grow(p);
    }
    Aabb { lower: b.lower.map(|x| x - margin), upper: b.upper.map(|x| x + margin) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn pieces(t: &Triangle, size: f64) -> Vec<Piece> {
        let mut out = Vec::new();
        cut_triangle(t, size, &mut |p| out.push(*p));
        out
    }

    fn area(q: &Piece) -> f64 {
        0.5 * (twice_area(&[q[0], q[1], q[2]]) + twice_area(&[q[0], q[2], q[3]]))
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2_000))]
        #[test]
        fn pieces_are_short_few_and_cover(
            t in prop::array::uniform3(prop::array::uniform3(-1.0f64..1.0)),
            flatness in prop_oneof![Just(1.0), Just(0.01), Just(1e-9)],
            u in 0.0f64..1.0,
            v in 0.0f64..1.0,
        ) {
            let t = t.map(|[x, y, z]| [x, y, z * flatness]);
            let t = [t[0], t[1], if flatness < 1.0 { std::array::from_fn(|i| t[1][i] + flatness * (t[2][i] - t[0][i])) } else { t[2] }];
            let cut = pieces(&t, 0.3);
            for p in &cut {
                prop_assert!((0..4).all(|i| distance(&p[i], &p[(i + 1) % 4]) <= 0.3 + 1e-12));
            }
            prop_assert!(cut.len() as f64 <= piece_bound(&t, 0.3));
            prop_assert!((cut.iter().map(area).sum::<f64>() - 0.5 * twice_area(&t)).abs() < 1e-9);
            // Any point of the triangle lies in the grown box of some piece.
            let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
            let p: Point = std::array::from_fn(|i| t[0][i] * (1.0 - u - v) + t[1][i] * u + t[2][i] * v);
            let point = Aabb { lower: p, upper: p };
            let covered = cut.iter().any(|c| grown_box(c, cut_margin(2.0)).is_overlapping(&point));
            prop_assert!(covered);
        }
    }

    #[test]
    fn a_needle_of_a_kilometre_becomes_a_row() {
        let needle = [[0.0; 3], [1000.0, 0.0, 0.0], [1000.0, 1e-9, 0.0]];
        assert_eq!(pieces(&needle, 1.0).len(), 1024);
        assert_eq!(pieces(&needle, f64::MAX).len(), 1);
        let cap = [[0.0; 3], [1000.0, 0.0, 0.0], [500.0, 1e-6, 0.0]];
        assert_eq!(pieces(&cap, 1.0).len(), 1024);
    }

    #[test]
    fn features_of_a_few_ulps_are_not_cut_to_dust() {
        let e = 1024.0 * f64::EPSILON;
        let t = [[2.0, 2.0, 0.0], [5.0, 3.0, 0.0], [3.0, 5.0, 0.0]].map(|p| p.map(|x| 1024.0 + x * e));
        assert_eq!(pieces(&t, 0.3 * e).len(), 1);
        assert!(
            pieces(&t.map(|p| p.map(|x| 1024.0 + (x - 1024.0) * 4096.0)), e).len() as f64
                <= piece_bound(&t, e).max(65536.0)
        );
    }

    #[test]
    fn default_size_spends_at_most_its_allowance() {
        // 999 small triangles and a long one.
        let mesh = |i: usize| {
            let l = if i == 0 { 3.0 } else { 0.01 };
            [[0.0; 3], [l, 0.0, 0.0], [0.0, 0.01, 0.0]]
        };
        for allowance in [0.0, 0.1, 1.0] {
            let size = default_piece_size(1000, mesh, allowance);
            let total: usize = (0..1000).map(|i| pieces(&mesh(i), size).len()).sum();
            assert!(total as f64 <= 1000.0 * (1.0 + allowance), "{allowance}: {size} m gives {total}");
        }
    }
}
