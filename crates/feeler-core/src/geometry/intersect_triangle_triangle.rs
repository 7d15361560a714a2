//! Whether and how two triangles collide, decided by exact signs alone.
//!
//! Follows T. Möller, *A fast triangle-triangle intersection test* (1997), in the form of P. Guigue and O. Devillers,
//! *Fast and robust triangle-triangle overlap test using orientation predicates* (2003): instead of computing the two
//! intervals on the planes' common line, their order is read from two orientation signs. Deviation: the signs are
//! exact, triangles are closed, and the kind of collision is found as well.
//!
//! One of the two may be degenerate: a tool triangle's corners are rounded at each pose and can end up on one line. As
//! a closed set it is then a segment or a point. It has no plane to cross, so its collision with another triangle is
//! `coplanar` if it lies in that triangle's plane and `touching` otherwise. Of two bodies that both move, both triangles may be: two
//! segments or points that meet are `touching`.

use crate::geometry::bounds::{Point, Triangle};
use crate::geometry::predicates::{is_collinear, Sign, Signs};

/// How two triangles collide.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[repr(u8)]
pub enum PairKind {
    /// They lie in one plane.
    Coplanar = 0,
    /// Two planes, each triangle has vertices strictly on both sides of the other's, and they share more than a point.
    Crossing = 1,
    /// Every other way to meet: a vertex or edge on a face, edge on edge, a shared point.
    Touching = 2,
}

/// The kind of meeting of two closed triangles, `None` when they share no point. Exact. Corners must be finite, and at most 1e100
/// in size (a few times that at a pose).
///
/// ```
/// use feeler_core::{intersect_triangle_triangle, PairKind};
///
/// let floor = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]];
/// let edge_on_it = [[0.5, 0.5, 0.0], [0.6, 0.5, 0.0], [0.5, 0.5, 1.0]];
/// assert_eq!(intersect_triangle_triangle(&floor, &edge_on_it), Some(PairKind::Touching));
/// assert_eq!(intersect_triangle_triangle(&floor, &edge_on_it.map(|[x, y, z]| [x, y, z + 5e-324])), None);
/// ```
#[inline]
pub fn intersect_triangle_triangle(p: &Triangle, q: &Triangle) -> Option<PairKind> {
    intersect_with(&mut Signs::default(), p, q)
}

/// The same; counts in `signs` how often float64 arithmetic could not decide.
#[inline]
pub fn intersect_with(signs: &mut Signs, p: &Triangle, q: &Triangle) -> Option<PairKind> {
    // The side of each corner of q with respect to the plane of p, and the other way round.
    let side_q = q.map(|corner| signs.orient3d(&p[0], &p[1], &p[2], &corner));
    if is_one_sided(side_q) {
        return None;
    }
    let side_p = p.map(|corner| signs.orient3d(&q[0], &q[1], &q[2], &corner));
    if is_one_sided(side_p) {
        return None;
    }
    match (side_p == [0; 3], side_q == [0; 3]) {
        (true, true) => return meeting_coplanar(signs, p, q),
        // All corners of q on the plane of p, but not the other way round: p has no plane.
        (false, true) => return is_segment_meeting(signs, p, side_p, q).then_some(PairKind::Touching),
        (true, false) => return is_segment_meeting(signs, q, side_q, p).then_some(PairKind::Touching),
        (false, false) => {}
    }

    // Turn each triangle so that its first corner is alone on the positive side of the other's plane (the other two at
    // or below it), flipping the other triangle where the lone corner is on the negative side.
    let (p, flip_q) = turn(p, side_p);
    let (q, flip_p) = turn(q, side_q);
    let q = if flip_q { [q[0], q[2], q[1]] } else { q };
    let p = if flip_p { [p[0], p[2], p[1]] } else { p };

    // The common line enters and leaves p through its edges 0-1 and 0-2, and q likewise. Two signs compare the ends of
    // the two intervals crosswise; they overlap when neither ends before the other begins.
    let first = signs.orient3d(&p[0], &p[1], &q[0], &q[1]);
    if first > 0 {
        return None;
    }
    let second = signs.orient3d(&p[0], &p[2], &q[2], &q[0]);
    if second > 0 {
        return None;
    }
    let crossing = first < 0 && second < 0 && is_two_sided(side_p) && is_two_sided(side_q);
    Some(if crossing { PairKind::Crossing } else { PairKind::Touching })
}

#[inline]
fn is_one_sided(side: [Sign; 3]) -> bool {
    side == [1; 3] || side == [-1; 3]
}

fn is_two_sided(side: [Sign; 3]) -> bool {
    side.contains(&1) && side.contains(&-1)
}

/// Rotates the corners so that the one alone on its side comes first. True when that side is the negative one, so that
/// the other triangle must be flipped.
///
/// With corner 0 alone on the positive side both others are at or below the plane; where corner 0 lies in the plane both
/// others are strictly below. So the edges 0-1 and 0-2 both pass through the plane, which the interval signs rely on.
fn turn(t: &Triangle, side: [Sign; 3]) -> (Triangle, bool) {
    let [a, b, c] = *t;
    let lone = |i: usize| match i {
        0 => [a, b, c],
        1 => [b, c, a],
        _ => [c, a, b],
    };
    for i in 0..3 {
        let (s, r) = (side[i], [side[(i + 1) % 3], side[(i + 2) % 3]]);
        // Strictly on one side, the others not on it.
        if s != 0 && r.iter().all(|x| *x != s) {
            // Where one other corner lies in the plane and one is opposite, two corners qualify; either will do.
            return (lone(i), s < 0);
        }
    }
    for i in 0..3 {
        // In the plane, the others strictly on one common side: the flip makes them negative.
        let r = [side[(i + 1) % 3], side[(i + 2) % 3]];
        if side[i] == 0 && r[0] == r[1] {
            return (lone(i), r[0] > 0);
        }
    }
    unreachable!("sides {side:?} are one-sided or all zero")
}

/// Two triangles of which each lies in the plane of the other, if it has one.
#[cold]
fn meeting_coplanar(signs: &mut Signs, p: &Triangle, q: &Triangle) -> Option<PairKind> {
    if is_collinear(&p[0], &p[1], &p[2]) && is_collinear(&q[0], &q[1], &q[2]) {
        return are_segments_meeting(signs, ends(p), ends(q)).then_some(PairKind::Touching);
    }
    is_overlapping_coplanar(signs, p, q).then_some(PairKind::Coplanar)
}

/// The ends of three points on one line: along a line the order of coordinates is that of the points.
fn ends(t: &Triangle) -> [Point; 2] {
    let order = |a: &&Point, b: &&Point| a.partial_cmp(b).unwrap_or(std::cmp::Ordering::Equal);
    [t.iter().min_by(order), t.iter().max_by(order)].map(|end| *end.unwrap_or(&t[0]))
}

/// Two closed segments, perhaps points. In one plane they meet if they do along each axis: one that the plane does not contain shows
/// it as it is; on one line the boxes do.
fn are_segments_meeting(signs: &mut Signs, [a, b]: [Point; 2], [c, d]: [Point; 2]) -> bool {
    let overlaps = |i: usize| a[i].min(b[i]) <= c[i].max(d[i]) && c[i].min(d[i]) <= a[i].max(b[i]);
    if !(0..3).all(overlaps) || signs.orient3d(&a, &b, &c, &d) != 0 {
        return false;
    }
    [(0, 1), (1, 2), (2, 0)].iter().all(|(u, v)| {
        let [a, b, c, d] = [a, b, c, d].map(|p| [p[*u], p[*v]]);
        signs.orient2d(a, b, c) * signs.orient2d(a, b, d) <= 0 && signs.orient2d(c, d, a) * signs.orient2d(c, d, b) <= 0
    })
}

/// A triangle without area (corners on one line, not all in the plane of `t`) against one with: whether the line's passage
/// through the plane lies in `t`. The sides are not all strictly on one side, so the passage belongs to the segment.
#[cold]
fn is_segment_meeting(signs: &mut Signs, segment: &Triangle, side: [Sign; 3], t: &Triangle) -> bool {
    // Any two corners on different sides (one may lie in the plane) span the passage.
    let a = side.iter().position(|s| *s != 0).unwrap_or(0);
    let b = side.iter().position(|s| *s != side[a]).unwrap_or(0);
    let around = [0, 1, 2].map(|i| signs.orient3d(&segment[a], &segment[b], &t[i], &t[(i + 1) % 3]));
    !(around.contains(&1) && around.contains(&-1))
}

/// Two closed triangles in one plane, one of them perhaps without area: they are apart exactly when all corners of one lie
/// strictly outside an edge of the other.
#[cold]
fn is_overlapping_coplanar(signs: &mut Signs, p: &Triangle, q: &Triangle) -> bool {
    let (p, q) = if is_collinear(&p[0], &p[1], &p[2]) { (q, p) } else { (p, q) };
    // Dropping one axis maps the plane one to one where the projection of p keeps an area. Coordinates are taken as they
    // are, so nothing is rounded.
    for (u, v) in [(0, 1), (1, 2), (2, 0)] {
        let flat = |t: &Triangle| t.map(|c| [c[u], c[v]]);
        let (mut p, mut q) = (flat(p), flat(q));
        match signs.orient2d(p[0], p[1], p[2]) {
            0 => continue,
            s if s < 0 => p.swap(1, 2),
            _ => {}
        }
        let turn = signs.orient2d(q[0], q[1], q[2]);
        if turn < 0 {
            q.swap(1, 2);
        }
        let mut is_outside_an_edge = |s: &[[f64; 2]; 3], t: &[[f64; 2]; 3], outside: Sign| {
            (0..3).any(|i| t.iter().all(|c| signs.orient2d(s[i], s[(i + 1) % 3], *c) == outside))
        };
        // A segment has two outsides.
        return ![(&p, &q, -1), (&q, &p, -1), (&q, &p, if turn == 0 { 1 } else { -1 })]
            .iter()
            .any(|(s, t, outside)| is_outside_an_edge(s, t, *outside));
    }
    // Neither has an area: `meeting_coplanar` asks segments then.
    false
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whether two segments of whole numbers meet, by fractions.
    fn meets_by_fractions([a, b]: [[i64; 3]; 2], [c, d]: [[i64; 3]; 2]) -> bool {
        let minus = |p: [i64; 3], q: [i64; 3]| [p[0] - q[0], p[1] - q[1], p[2] - q[2]];
        let cross = |p: [i64; 3], q: [i64; 3]| {
            [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]]
        };
        let dot = |p: [i64; 3], q: [i64; 3]| p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
        let (u, v, w) = (minus(b, a), minus(d, c), minus(c, a));
        let n = cross(u, v);
        let size = dot(n, n);
        if size > 0 {
            let is_share = |share: i64| (0..=size).contains(&share);
            return dot(w, n) == 0 && is_share(dot(cross(w, v), n)) && is_share(dot(cross(w, u), n));
        }
        // On one line or parallel; where both are points, equal.
        let along = if u == [0; 3] { v } else { u };
        if cross(w, along) != [0; 3] || (along == [0; 3] && w != [0; 3]) {
            return false;
        }
        let range = |p: [i64; 3], q: [i64; 3]| {
            let (s, t) = (dot(p, along), dot(q, along));
            (s.min(t), s.max(t))
        };
        let (own, other) = (range(a, b), range(c, d));
        own.0 <= other.1 && other.0 <= own.1
    }

    #[test]
    fn two_segments_meet_as_fractions_say() {
        let point = |n: u64| [n % 3, n / 3 % 3, n / 9].map(|x| x as i64);
        let mut random = feeler_lanes::SplitMix64::new(3);
        let (mut meeting, mut apart) = (0, 0);
        for _ in 0..20_000 {
            let mut ends = || [random.bits() % 27, random.bits() % 27].map(point);
            let (s, t) = (ends(), ends());
            let flat = |[a, b]: [[i64; 3]; 2], turn: bool| -> Triangle {
                let [a, b] = [a, b].map(|p| p.map(|x| x as f64));
                let middle = std::array::from_fn(|i| 0.5 * (a[i] + b[i]));
                if turn {
                    [b, a, middle]
                } else {
                    [middle, a, b]
                }
            };
            let found = intersect_triangle_triangle(
                &flat(s, random.bits().is_multiple_of(2)),
                &flat(t, random.bits().is_multiple_of(2)),
            );
            let expected = meets_by_fractions(s, t);
            assert_eq!(found, expected.then_some(PairKind::Touching), "{s:?} {t:?}");
            meeting += u32::from(expected);
            apart += u32::from(!expected);
        }
        assert!(meeting > 1000 && apart > 5000, "{meeting} {apart}");
    }

    use crate::geometry::bounds::Point;
    use crate::geometry::predicates::{orient2d, orient3d};
    use proptest::prelude::*;

    /// The plain twin: triangles meet when an edge of one meets the other, or when one lies in the other.
    fn is_meeting_plain(p: &Triangle, q: &Triangle) -> bool {
        let edges = |t: &Triangle| [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]];
        edges(p).iter().any(|e| is_meeting_segment(e, q)) || edges(q).iter().any(|e| is_meeting_segment(e, p))
    }

    fn is_meeting_segment(e: &[Point; 2], t: &Triangle) -> bool {
        let side = e.map(|x| orient3d(&t[0], &t[1], &t[2], &x));
        if side == [0, 0] {
            // In the plane: clip the projected segment by the projected triangle's edges.
            return [(0, 1), (1, 2), (2, 0)].iter().any(|&(u, v)| {
                let mut f = t.map(|c| [c[u], c[v]]);
                let s = orient2d(f[0], f[1], f[2]);
                if s == 0 {
                    return false;
                }
                if s < 0 {
                    f.swap(1, 2);
                }
                let e = e.map(|x| [x[u], x[v]]);
                let inside = |x: [f64; 2]| (0..3).all(|i| orient2d(f[i], f[(i + 1) % 3], x) >= 0);
                let crosses = |i: usize| {
                    let (a, b) = (f[i], f[(i + 1) % 3]);
                    orient2d(a, b, e[0]) * orient2d(a, b, e[1]) < 0
                        && orient2d(e[0], e[1], a) * orient2d(e[0], e[1], b) <= 0
                };
                inside(e[0]) || inside(e[1]) || (0..3).any(crosses)
            });
        }
        if side[0] * side[1] > 0 {
            return false;
        }
        let around: Vec<Sign> = (0..3).map(|i| orient3d(&e[0], &e[1], &t[i], &t[(i + 1) % 3])).collect();
        around.iter().all(|s| *s >= 0) || around.iter().all(|s| *s <= 0)
    }

    fn lattice_triangle() -> impl Strategy<Value = Triangle> {
        prop::array::uniform3(prop::array::uniform3((-2i32..3).prop_map(f64::from)))
            .prop_filter("area", |t| !crate::geometry::predicates::is_collinear(&t[0], &t[1], &t[2]))
    }

    fn orders(t: &Triangle) -> Vec<Triangle> {
        let [a, b, c] = *t;
        vec![[a, b, c], [b, c, a], [c, a, b], [a, c, b], [c, b, a], [b, a, c]]
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(100_000))]
        #[test]
        fn agrees_with_the_plain_twin_on_a_lattice(p in lattice_triangle(), q in lattice_triangle()) {
            let meeting = is_meeting_plain(&p, &q);
            prop_assert_eq!(intersect_triangle_triangle(&p, &q).is_some(), meeting);
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(5_000))]
        #[test]
        fn kind_is_the_same_in_all_72_orderings(p in lattice_triangle(), q in lattice_triangle()) {
            let expected = intersect_triangle_triangle(&p, &q);
            for p in orders(&p) {
                for q in orders(&q) {
                    prop_assert_eq!(intersect_triangle_triangle(&p, &q), expected);
                    prop_assert_eq!(intersect_triangle_triangle(&q, &p), expected);
                }
            }
        }
    }

    #[test]
    fn kinds_of_named_cases() {
        let base: Triangle = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];
        let kind = |q: Triangle| intersect_triangle_triangle(&base, &q);
        // Crossing: pierces the face; and face cut right across.
        assert_eq!(kind([[1.0, 1.0, -1.0], [1.0, 1.0, 1.0], [2.0, 1.0, 1.0]]), Some(PairKind::Crossing));
        // Touching: vertex on face, edge on face, shared edge, shared vertex, one point on a common line.
        assert_eq!(kind([[1.0, 1.0, 0.0], [1.0, 1.0, 1.0], [2.0, 1.0, 1.0]]), Some(PairKind::Touching));
        assert_eq!(kind([[1.0, 1.0, 0.0], [2.0, 1.0, 0.0], [2.0, 1.0, 1.0]]), Some(PairKind::Touching));
        assert_eq!(kind([[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 0.0, 1.0]]), Some(PairKind::Touching));
        assert_eq!(kind([[0.0, 0.0, 0.0], [-1.0, 0.0, 1.0], [-1.0, 0.0, -1.0]]), Some(PairKind::Touching));
        assert_eq!(kind([[4.0, 0.0, -1.0], [4.0, 0.0, 1.0], [9.0, 0.0, 0.0]]), Some(PairKind::Touching));
        // Coplanar: overlap, containment, shared edge, shared vertex.
        assert_eq!(kind([[1.0, 1.0, 0.0], [9.0, 1.0, 0.0], [1.0, 9.0, 0.0]]), Some(PairKind::Coplanar));
        assert_eq!(kind([[1.0, 1.0, 0.0], [1.5, 1.0, 0.0], [1.0, 1.5, 0.0]]), Some(PairKind::Coplanar));
        assert_eq!(kind([[4.0, 0.0, 0.0], [0.0, 4.0, 0.0], [4.0, 4.0, 0.0]]), Some(PairKind::Coplanar));
        assert_eq!(kind([[4.0, 0.0, 0.0], [5.0, 0.0, 0.0], [5.0, 1.0, 0.0]]), Some(PairKind::Coplanar));
        // Without area: piercing, ending on the face, beside it; in the plane: across, inside, a point, beside, in line.
        assert_eq!(kind([[1.0, 1.0, -1.0], [1.0, 1.0, 0.5], [1.0, 1.0, 1.0]]), Some(PairKind::Touching));
        assert_eq!(kind([[1.0, 1.0, 0.0], [1.0, 1.0, 1.0], [1.0, 1.0, 2.0]]), Some(PairKind::Touching));
        assert_eq!(kind([[5.0, 1.0, -1.0], [5.0, 1.0, 0.5], [5.0, 1.0, 1.0]]), None);
        assert_eq!(kind([[-1.0, 1.0, 0.0], [5.0, 1.0, 0.0], [6.0, 1.0, 0.0]]), Some(PairKind::Coplanar));
        assert_eq!(kind([[1.0, 1.0, 0.0], [1.5, 1.0, 0.0], [2.0, 1.0, 0.0]]), Some(PairKind::Coplanar));
        assert_eq!(kind([[1.0, 1.0, 0.0]; 3]), Some(PairKind::Coplanar));
        assert_eq!(kind([[3.0, 3.0, 0.0], [4.0, 2.0, 0.0], [2.0, 4.0, 0.0]]), None);
        assert_eq!(kind([[5.0, 0.0, 0.0], [6.0, 0.0, 0.0], [7.0, 0.0, 0.0]]), None);
        assert_eq!(kind([[3.0, 3.0, 0.0]; 3]), None);
        // Apart: parallel, coplanar beside, crossing planes but intervals apart.
        assert_eq!(kind([[0.0, 0.0, 1.0], [4.0, 0.0, 1.0], [0.0, 4.0, 1.0]]), None);
        assert_eq!(kind([[5.0, 0.0, 0.0], [6.0, 0.0, 0.0], [5.0, 1.0, 0.0]]), None);
        assert_eq!(kind([[5.0, 0.0, -1.0], [5.0, 0.0, 1.0], [6.0, 1.0, 0.0]]), None);
    }
}
