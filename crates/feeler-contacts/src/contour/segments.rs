//! The intersection of two colliding triangles, in float64: that of their intervals on the common line of their planes
//! (Moller: *A fast triangle-triangle intersection test*, 1997), or for triangles in one plane the polygon of
//! Sutherland and Hodgman (*Reentrant polygon clipping*, 1974). Exact arithmetic has shown that the pair collides;
//! where rounding leaves the intervals apart, they touch in the middle.

use crate::constants::PARALLEL_SINE;
use crate::contour::contact_region::{Face, Segment};
use crate::surface::Surface;
use feeler_core::geometry::bounds::{Point, Triangle};
use feeler_core::geometry::vectors::{along, cross, dot, sub};
use feeler_lanes::{Arithmetic, Checked, Kernel, Simd, WIDE_LANES};

/// Finds the points of all segments, eight at once.
pub(crate) fn find_points(lanes: Checked, faces: &[Vec<Face>; 2], segments: &mut [Segment], points: &mut Vec<Point>) {
    for eight in segments.chunks_mut(WIDE_LANES) {
        let face = |surface: Surface, i: usize| &faces[surface][eight[i.min(eight.len() - 1)].faces[surface] as usize];
        let both = Surface::BOTH.map(|surface| std::array::from_fn(|i| face(surface, i)));
        let found = lanes.run(Intersect { faces: &both });
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

/// Intersects eight pairs of triangles.
struct Intersect<'a> {
    faces: &'a [[&'a Face; WIDE_LANES]; 2],
}

/// Intersections of eight pairs of triangles.
struct Intersections {
    /// The two ends, by axis and lane.
    ends: [[[f64; WIDE_LANES]; 3]; 2],
    /// Pairs in one plane, with a corner in the plane of the other, or apart by rounding: [`push_shared`] does them.
    doubt: u8,
}

impl Kernel for Intersect<'_> {
    type Output = Intersections;

    /// The same steps in the same order as [`push_shared`], so the same points.
    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> Intersections {
        let [tool, mockup] = self.faces;
        let (p, n) = points_of(s, tool);
        let (q, m) = points_of(s, mockup);
        let line = [n[1] * m[2] - n[2] * m[1], n[2] * m[0] - n[0] * m[2], n[0] * m[1] - n[1] * m[0]];
        let (a, b, is_first) = interval_lanes(s, &p, &q[0], &m, &line);
        let (c, d, is_second) = interval_lanes(s, &q, &p[0], &n, &line);
        let from = chosen(s, s.wide_above(c.0, a.0), &c, &a);
        let to = chosen(s, s.wide_above(b.0, d.0), &d, &b);
        let is_turned = s.wide_above(dot3::<S>(&line, &line), s.wide_splat(PARALLEL_SINE * PARALLEL_SINE));
        let fits = s.bits(s.both(s.both(is_first, is_second), is_turned)) & !s.bits(s.wide_above(from.0, to.0));
        let mut found = Intersections { ends: [[[0.0; WIDE_LANES]; 3]; 2], doubt: !fits };
        for k in 0..3 {
            s.wide_store(from.1[k], &mut found.ends[0][k]);
            s.wide_store(to.1[k], &mut found.ends[1][k]);
        }
        found
    }
}

/// A point on the common line of two planes, by lane: its coordinate along the line, and the point.
type Along<S> = (<S as Arithmetic>::F64, [<S as Arithmetic>::F64; 3]);

/// Corners and normals of eight faces, by axis.
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

/// As [`interval`], and the lanes in which no corner lies in the plane and an edge passes through it.
#[inline(always)]
fn interval_lanes<S: Simd>(
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
    let (mut is_clear, mut is_crossing) = (s.wide_above(s.wide_splat(1.0), zero), s.wide_above(zero, zero));
    for i in 0..3 {
        let j = (i + 1) % 3;
        is_clear = s.both(is_clear, s.either(below[i], s.wide_above(height[i], zero)));
        let is_here = s.differing(below[i], below[j]);
        is_crossing = s.either(is_crossing, is_here);
        // From the lower end, by coordinates: see `interval`.
        let mut swap = s.wide_above(t[i][2], t[j][2]);
        for k in [1, 0] {
            let (over, under) = (s.wide_above(t[i][k], t[j][k]), s.wide_above(t[j][k], t[i][k]));
            // Of equal coordinates the later ones decide.
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
    (first, last, s.both(is_clear, is_crossing))
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

/// Appends to `out` what `p` and `q`, which are known to meet, share: the two ends of a segment, which may coincide, or the corners of
/// a polygon where they lie in one plane. `n` and `m` are their unit normals. The plain twin of [`find_points`].
pub(crate) fn push_shared(p: &Triangle, n: &Point, q: &Triangle, m: &Point, out: &mut Vec<Point>) {
    let line = cross(n, m);
    let start = out.len();
    if dot(&line, &line) <= PARALLEL_SINE * PARALLEL_SINE {
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
    let (first, second) = (interval(p, &q[0], m, &line), interval(q, &p[0], n, &line));
    let from = if first[0].0 >= second[0].0 { first[0] } else { second[0] };
    let to = if first[1].0 <= second[1].0 { first[1] } else { second[1] };
    if from.0 <= to.0 {
        out.extend([from.1, to.1]);
    } else {
        // Apart by rounding only: they touch in a point.
        let middle: Point = std::array::from_fn(|a| 0.5 * from.1[a] + 0.5 * to.1[a]);
        out.extend([middle, middle]);
    }
}

/// The interval of `t` on its line of intersection with the plane through `other` with normal `m`: the first and the last point
/// along `direction`, each with its coordinate.
fn interval(t: &Triangle, other: &Point, m: &Point, direction: &Point) -> [(f64, Point); 2] {
    let height = t.map(|p| dot(&sub(&p, other), m));
    let mut found = [(f64::INFINITY, t[0]), (f64::NEG_INFINITY, t[0])];
    let extend = |found: &mut [(f64, Point); 2], p: Point| {
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
            extend(&mut found, t[i]);
        }
        if (height[i] < 0.0) != (height[j] < 0.0) && height[i] != height[j] {
            // From the lower end, by coordinates: the two triangles of an edge then have the same point to the last bit.
            let (i, j) = if t[i] < t[j] { (i, j) } else { (j, i) };
            let share = height[i] / (height[i] - height[j]);
            extend(&mut found, along(&t[i], share, &sub(&t[j], &t[i])));
        }
    }
    if found[0].0 > found[1].0 {
        // Apart by rounding only: the corner nearest to the plane.
        let nearest = (0..3).min_by(|a, b| height[*a].abs().total_cmp(&height[*b].abs())).unwrap_or(0);
        extend(&mut found, t[nearest]);
    }
    found
}

/// Appends the polygon that two triangles of one plane share: `p` clipped by the edges of `q`, whose normal by its winding is `m`
/// (Sutherland-Hodgman).
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
        // Small integers: many corners in planes, triangles in one plane and edges that cross.
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
