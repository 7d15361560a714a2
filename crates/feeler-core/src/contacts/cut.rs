//! Where two triangles that meet do so: the segment, point or polygon that they share, in float64.

use crate::bounds::{Point, Triangle};
use crate::vectors::{along, cross, dot, sub};

/// Planes within this angle (radians) count as one: the line they share says nothing any more.
const COPLANAR: f64 = 1e-9;

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
    let [[a, b], [c, d]] = [ends(p, &q[0], m, &line), ends(q, &p[0], n, &line)];
    // Choices are by place: which way they go cannot be foreseen, and a wrong guess of the processor costs more than the rest.
    let all = [a, b, c, d];
    let sorted = |i: usize| [i + usize::from(all[i + 1].0 < all[i].0), i + usize::from(all[i + 1].0 >= all[i].0)];
    let ([a, b], [c, d]) = (sorted(0), sorted(2));
    // The later of the two beginnings, the earlier of the two ends.
    let from = &all[[a, c][usize::from(all[c].0 > all[a].0)]];
    let to = &all[[b, d][usize::from(all[d].0 < all[b].0)]];
    if from.0 <= to.0 {
        out.extend([from.1, to.1]);
    } else {
        // Rounding: they touch in a point.
        let middle: Point = std::array::from_fn(|a| 0.5 * from.1[a] + 0.5 * to.1[a]);
        out.extend([middle, middle]);
    }
}

/// Where the border of `t` passes through the plane with normal `m` through `other`, at two places; and how far along
/// `direction` they are.
fn ends(t: &Triangle, other: &Point, m: &Point, direction: &Point) -> [(f64, Point); 2] {
    let height = t.map(|p| dot(&sub(&p, other), m));
    let below = height.map(|h| h < 0.0);
    let through = |edge: [usize; 2]| {
        // From the same end whichever triangle the edge is seen from, so that both have the same point.
        let [p, q] = edge.map(|k| &t[k]);
        let is_first = (p[0] < q[0]) | (p[0] == q[0]) & ((p[1] < q[1]) | (p[1] == q[1]) & (p[2] < q[2]));
        let [i, j] = [edge[usize::from(!is_first)], edge[usize::from(is_first)]];
        let p = along(&t[i], height[i] / (height[i] - height[j]), &sub(&t[j], &t[i]));
        (dot(&p, direction), p)
    };
    if height.iter().all(|h| *h != 0.0) && (below[0] != below[1] || below[0] != below[2]) {
        // One corner is alone on its side.
        let alone = usize::from(below[0] == below[2]) + 2 * usize::from(below[0] == below[1]);
        return [through([alone, (alone + 1) % 3]), through([alone, (alone + 2) % 3])];
    }
    let mut found = [(f64::INFINITY, t[0]), (f64::NEG_INFINITY, t[0])];
    let take = |found: &mut [(f64, Point); 2], (s, p): (f64, Point)| {
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
            take(&mut found, (dot(&t[i], direction), t[i]));
        }
        if below[i] != below[j] && height[i] != height[j] {
            take(&mut found, through([i, j]));
        }
    }
    if found[0].0 > found[1].0 {
        // Rounding took the plane off the triangle: the corner nearest to it.
        let nearest = (0..3).min_by(|a, b| height[*a].abs().total_cmp(&height[*b].abs())).unwrap_or(0);
        take(&mut found, (dot(&t[nearest], direction), t[nearest]));
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
    use crate::vectors::{length, normal};

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
}
