//! Where two triangles that meet do so: the segment, point or polygon that they share, in float64.

use crate::contour::contact_region::{Face, Segment};
use crate::surface::Surface;
use feeler_core::geometry::bounds::{Point, Triangle};
use feeler_core::geometry::vectors::{along, cross, dot, sub};
use feeler_lanes::{Arithmetic, Checked, Kernel, Simd, WIDE_LANES};

/// Planes within this angle (radians) count as one: the line they share says nothing any more.
const COPLANAR: f64 = 1e-9;

/// Finds the points of all cuts, eight cuts at once.
pub(crate) fn find_points(lanes: Checked, faces: &[Vec<Face>; 2], segments: &mut [Segment], points: &mut Vec<Point>) {
    for eight in segments.chunks_mut(WIDE_LANES) {
        let face = |surface: Surface, i: usize| &faces[surface][eight[i.min(eight.len() - 1)].faces[surface] as usize];
        let both = Surface::BOTH.map(|surface| std::array::from_fn(|i| face(surface, i)));
        let found = lanes.run(Crossing { faces: &both });
        for (i, segment) in eight.iter_mut().enumerate() {
            let from = points.len() as u32;
            if found.doubt >> i & 1 != 0 {
                let (p, q) = (both[Surface::Tool][i], both[Surface::Mockup][i]);
                push_shared(&p.corners, &p.normal, &q.corners, &q.normal, points);
            } else {
                points.extend(found.ends.each_ref().map(|end| end.map(|x| x[i])));
            }
            segment.points = (from, points.len() as u32);
        }
    }
}

/// Triangles that cross, eight pairs.
struct Crossing<'a> {
    faces: &'a [[&'a Face; WIDE_LANES]; 2],
}

/// The ends of what they share, by axis and lane.
struct Crossed {
    ends: [[[f64; WIDE_LANES]; 3]; 2],
    /// Pairs that lie in one plane or have a corner in the plane of the other: [`push_shared`] does them.
    doubt: u8,
}

impl Kernel for Crossing<'_> {
    type Output = Crossed;

    /// The same steps as in [`push_shared`], so the same points.
    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> Crossed {
        let [tool, mockup] = self.faces;
        let (p, n) = points_of(s, tool);
        let (q, m) = points_of(s, mockup);
        let line = [n[1] * m[2] - n[2] * m[1], n[2] * m[0] - n[0] * m[2], n[0] * m[1] - n[1] * m[0]];
        let (a, b, is_first) = crossings(s, &p, &q[0], &m, &line);
        let (c, d, is_second) = crossings(s, &q, &p[0], &n, &line);
        // The later of the two beginnings, the earlier of the two ends.
        let from = chosen(s, s.wide_above(c.0, a.0), &c, &a);
        let to = chosen(s, s.wide_above(b.0, d.0), &d, &b);
        let is_turned = s.wide_above(dot3::<S>(&line, &line), s.wide_splat(COPLANAR * COPLANAR));
        let fits = s.bits(s.both(s.both(is_first, is_second), is_turned)) & !s.bits(s.wide_above(from.0, to.0));
        let mut found = Crossed { ends: [[[0.0; WIDE_LANES]; 3]; 2], doubt: !fits };
        for k in 0..3 {
            s.wide_store(from.1[k], &mut found.ends[0][k]);
            s.wide_store(to.1[k], &mut found.ends[1][k]);
        }
        found
    }
}

/// By lane how far along the line that two planes share a point is, and the point.
type Along<S> = (<S as Arithmetic>::F64, [<S as Arithmetic>::F64; 3]);

/// Corners and normals by axis.
#[inline(always)]
fn points_of<S: Simd>(s: S, faces: &[&Face; WIDE_LANES]) -> ([[S::F64; 3]; 3], [S::F64; 3]) {
    let mut points = [[&faces[0].normal; WIDE_LANES]; 4];
    for (i, face) in faces.iter().enumerate() {
        points[0][i] = &face.corners[0];
        points[1][i] = &face.corners[1];
        points[2][i] = &face.corners[2];
        points[3][i] = &face.normal;
    }
    ([s.wide_points(points[0]), s.wide_points(points[1]), s.wide_points(points[2])], s.wide_points(points[3]))
}

/// As [`ends`]: first and last along the line, and where one corner is clearly alone on its side of the plane.
#[inline(always)]
fn crossings<S: Simd>(
    s: S,
    t: &[[S::F64; 3]; 3],
    other: &[S::F64; 3],
    m: &[S::F64; 3],
    line: &[S::F64; 3],
) -> (Along<S>, Along<S>, S::M64) {
    let zero = s.wide_splat(0.0);
    let mut height = [zero; 3];
    for k in 0..3 {
        height[k] = dot3::<S>(&[t[k][0] - other[0], t[k][1] - other[1], t[k][2] - other[2]], m);
    }
    let below = [s.wide_above(zero, height[0]), s.wide_above(zero, height[1]), s.wide_above(zero, height[2])];
    let mut first = (s.wide_splat(f64::INFINITY), t[0]);
    let mut last = (s.wide_splat(f64::NEG_INFINITY), t[0]);
    let (mut is_clear, mut is_on_contour) = (s.wide_above(s.wide_splat(1.0), zero), s.wide_above(zero, zero));
    for i in 0..3 {
        let j = (i + 1) % 3;
        is_clear = s.both(is_clear, s.either(below[i], s.wide_above(height[i], zero)));
        let is_here = s.differing(below[i], below[j]);
        is_on_contour = s.either(is_on_contour, is_here);
        // The end that comes first by its coordinates.
        let mut swap = s.wide_above(t[i][2], t[j][2]);
        for k in [1, 0] {
            let (over, under) = (s.wide_above(t[i][k], t[j][k]), s.wide_above(t[j][k], t[i][k]));
            // Over, or as it was where neither is.
            swap = s.either(over, s.differing(swap, s.both(swap, under)));
        }
        let (a, b) = (
            chosen(s, swap, &(height[j], t[j]), &(height[i], t[i])),
            chosen(s, swap, &(height[i], t[i]), &(height[j], t[j])),
        );
        let share = s.wide_divide(a.0, a.0 - b.0);
        let mut at = a.1;
        for k in 0..3 {
            at[k] = a.1[k] + share * (b.1[k] - a.1[k]);
        }
        let at = (dot3::<S>(&at, line), at);
        first = chosen(s, s.both(is_here, s.wide_above(first.0, at.0)), &at, &first);
        last = chosen(s, s.both(is_here, s.wide_above(at.0, last.0)), &at, &last);
    }
    (first, last, s.both(is_clear, is_on_contour))
}

#[inline(always)]
fn chosen<S: Simd>(s: S, mask: S::M64, x: &Along<S>, y: &Along<S>) -> Along<S> {
    let point = [s.choose(mask, x.1[0], y.1[0]), s.choose(mask, x.1[1], y.1[1]), s.choose(mask, x.1[2], y.1[2])];
    (s.choose(mask, x.0, y.0), point)
}

#[inline(always)]
fn dot3<S: Simd>(a: &[S::F64; 3], b: &[S::F64; 3]) -> S::F64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Appends the ends of what `p` and `q` share to `out`: two points for a segment, which may coincide, or the corners of a
/// polygon for triangles in one plane. `n` and `m` are their unit normals. The pair is known to meet.
pub(crate) fn push_shared(p: &Triangle, n: &Point, q: &Triangle, m: &Point, out: &mut Vec<Point>) {
    let line = cross(n, m);
    let start = out.len();
    if dot(&line, &line) <= COPLANAR * COPLANAR {
        clip(p, q, m, out);
        if out.len() == start {
            let middle = |t: &Triangle| std::array::from_fn(|a| (t[0][a] + t[1][a] + t[2][a]) / 3.0);
            out.push(nearest_corner(p, &middle(q)));
        }
        if out.len() == start + 1 {
            out.push(out[start]);
        }
        return;
    }
    let (first, second) = (ends(p, &q[0], m, &line), ends(q, &p[0], n, &line));
    // The later of the two beginnings, the earlier of the two ends.
    let from = if first[0].0 >= second[0].0 { first[0] } else { second[0] };
    let to = if first[1].0 <= second[1].0 { first[1] } else { second[1] };
    if from.0 <= to.0 {
        out.extend([from.1, to.1]);
    } else {
        // Rounding: they touch in a point.
        let middle: Point = std::array::from_fn(|a| 0.5 * from.1[a] + 0.5 * to.1[a]);
        out.extend([middle, middle]);
    }
}

/// Where the border of `t` passes through the plane with normal `m` through `other`: first and last along `direction`.
fn ends(t: &Triangle, other: &Point, m: &Point, direction: &Point) -> [(f64, Point); 2] {
    let height = t.map(|p| dot(&sub(&p, other), m));
    let mut found = [(f64::INFINITY, t[0]), (f64::NEG_INFINITY, t[0])];
    let take = |found: &mut [(f64, Point); 2], p: Point| {
        let s = dot(&p, direction);
        if s < found[0].0 {
            found[0] = (s, p);
        }
        if s > found[1].0 {
            found[1] = (s, p);
        }
    };
    for i in 0..3 {
        let j = (i + 1) % 3;
        if height[i] == 0.0 {
            take(&mut found, t[i]);
        }
        if (height[i] < 0.0) != (height[j] < 0.0) && height[i] != height[j] {
            // From the same end whichever triangle the edge is seen from, so that both have the same point.
            let (i, j) = if t[i] < t[j] { (i, j) } else { (j, i) };
            let share = height[i] / (height[i] - height[j]);
            take(&mut found, along(&t[i], share, &sub(&t[j], &t[i])));
        }
    }
    if found[0].0 > found[1].0 {
        // Rounding took the plane off the triangle: the corner nearest to it.
        let nearest = (0..3).min_by(|a, b| height[*a].abs().total_cmp(&height[*b].abs())).unwrap_or(0);
        take(&mut found, t[nearest]);
    }
    found
}

/// The part of `p` within `q`, both in one plane with normal `m` by the winding of `q`.
fn clip(p: &Triangle, q: &Triangle, m: &Point, out: &mut Vec<Point>) {
    let mut polygon = [[0.0; 3]; 9];
    polygon[..3].copy_from_slice(p);
    let mut count = 3;
    for k in 0..3 {
        let inward = cross(m, &sub(&q[(k + 1) % 3], &q[k]));
        let before = polygon;
        let n = std::mem::take(&mut count);
        for i in 0..n {
            let (a, b) = (before[i], before[(i + 1) % n]);
            let (x, y) = (dot(&sub(&a, &q[k]), &inward), dot(&sub(&b, &q[k]), &inward));
            if x >= 0.0 && count < polygon.len() {
                polygon[count] = a;
                count += 1;
            }
            if (x < 0.0) != (y < 0.0) && x != 0.0 && y != 0.0 && count < polygon.len() {
                polygon[count] = along(&a, x / (x - y), &sub(&b, &a));
                count += 1;
            }
        }
    }
    out.extend_from_slice(&polygon[..count]);
}

fn nearest_corner(t: &Triangle, to: &Point) -> Point {
    let square = |p: &Point| dot(&sub(p, to), &sub(p, to));
    *t.iter().min_by(|a, b| square(a).total_cmp(&square(b))).unwrap_or(&t[0])
}

#[cfg(test)]
mod tests {
    use super::*;
    use feeler_core::geometry::vectors::{length, normal};
    use feeler_lanes::Level;

    fn shared(p: &Triangle, q: &Triangle) -> Vec<Point> {
        let mut out = Vec::new();
        push_shared(p, &normal(p).unwrap(), q, &normal(q).unwrap(), &mut out);
        out
    }

    #[test]
    fn crossing_triangles_share_a_segment_and_flat_ones_a_polygon() {
        let p = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];
        let q = [[1.0, 1.0, -1.0], [1.0, 1.0, 1.0], [1.0, -3.0, 0.0]];
        let ends = shared(&p, &q);
        assert_eq!(ends.len(), 2);
        assert!((length(&sub(&ends[0], &ends[1])) - 1.0).abs() < 1e-12, "{ends:?}");
        let flat = [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 3.0, 0.0]];
        assert!(shared(&p, &flat).len() >= 3);
        let corner = [[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [-1.0, -1.0, 1.0]];
        assert!(shared(&p, &corner).iter().all(|x| length(x) < 1e-12));
    }

    #[test]
    fn eight_at_once_share_the_points_that_each_pair_does() {
        // Small whole numbers: many corners in planes, triangles in one plane and edges across each other.
        let mut state = 1u64;
        let mut coordinate = |odd: f64| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as f64 % 7.0 - 3.0 + odd * ((state >> 20) % 1000) as f64
        };
        for (count, odd) in [(1, 1e-3), (7, 0.0), (8, 1e-3), (500, 0.0), (500, 1e-3)] {
            let mut faces = [Vec::new(), Vec::new()];
            while faces[Surface::Mockup].len() < count {
                let mut triangle = || -> Triangle { std::array::from_fn(|_| std::array::from_fn(|_| coordinate(odd))) };
                let both = [triangle(), triangle()];
                if let [Some(n), Some(m)] = both.map(|t| normal(&t)) {
                    for (surface, normal) in [n, m].into_iter().enumerate() {
                        faces[surface].push(Face { normal, ..Face::new(0, both[surface], true) });
                    }
                }
            }
            let segment = |i: usize| Segment { faces: [i as u32, i as u32], points: (0, 0), flat: false };
            for level in Level::available() {
                let (mut segments, mut points): (Vec<Segment>, _) = ((0..count).map(segment).collect(), Vec::new());
                find_points(level.checked(), &faces, &mut segments, &mut points);
                for (i, segment) in segments.iter().enumerate() {
                    let found = &points[segment.points.0 as usize..segment.points.1 as usize];
                    assert_eq!(
                        found,
                        shared(&faces[Surface::Tool][i].corners, &faces[Surface::Mockup][i].corners),
                        "{level:?} {i}"
                    );
                }
            }
        }
    }
}
