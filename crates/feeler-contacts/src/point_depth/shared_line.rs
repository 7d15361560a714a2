//! Finds the lines in which the surfaces of two bodies cross, and the spans of these lines in which both bodies are thin walls. Flat faces
//! give the same spans however they are cut into triangles.

use feeler_core::geometry::vectors::{add, along, cross, dot, length, scaled, sub, unit};
use feeler_core::{Aabb, Point, Triangle};

use super::body::Body;
use crate::constants::{MOST_NEEDLE_POINTS, OPPOSITE_FACES};

/// A part of a line, from and to a length along it, metres.
pub type Span = [f64; 2];

/// The segment that two triangles in different planes share.
pub struct SharedLine {
    from: Point,
    direction: Point,
    size: f64,
    /// Of each triangle the normal, and on which side of the other's plane it is: -1 or 1, or 0 where it is on both.
    sides: [(Point, f64); 2],
}

impl SharedLine {
    /// Of triangles with these normals. `None` where it is shorter than `least`, metres, or where the two only touch. Corners of one no
    /// farther from the plane of the other than that are in it.
    pub fn new([t, u]: [&Triangle; 2], normals: [Point; 2], least: f64) -> Option<SharedLine> {
        let direction = unit(&cross(&normals[0], &normals[1]))?;
        let ((p, p_side), (q, q_side)) =
            (cut(t, &normals[1], &u[0], &direction, least)?, cut(u, &normals[0], &t[0], &direction, least)?);
        let place = |x: &Point| dot(&sub(x, &p[0]), &direction);
        let (begin, end) = (place(&q[0]).max(0.0), place(&q[1]).min(place(&p[1])));
        (end - begin > least).then(|| SharedLine {
            from: along(&p[0], begin, &direction),
            direction,
            size: end - begin,
            sides: [(normals[0], p_side), (normals[1], q_side)],
        })
    }

    /// The same in another frame.
    pub fn moved(&self, by: &Point) -> SharedLine {
        SharedLine { from: add(&self.from, by), ..*self }
    }

    /// The spans where a face that looks the other way is behind a triangle of a body, no farther than a wall of this thickness would have
    /// it.
    pub fn before_walls(&self, body: &Body, i: u32, thickness: f64, least: f64) -> Vec<Span> {
        let Some(outward) = body.outward(i) else { return Vec::new() };
        let to = along(&self.from, self.size, &self.direction);
        let ends = [self.from, to].map(|p| along(&p, -thickness, &outward));
        let strip = Aabb::of_triangle(&[self.from, to, ends[0]]).union(&Aabb::of_triangle(&[self.from, to, ends[1]]));
        let across = cross(&self.direction, &outward);
        let mut found = Vec::new();
        body.find_overlapping(&strip, |j| {
            if j != i && body.outward(j).is_some_and(|n| dot(&n, &outward) <= OPPOSITE_FACES) {
                found.extend(self.behind(body.triangle(j), &across, &outward, thickness));
            }
            None::<()>
        });
        merged(found, least)
    }

    /// The span where a triangle is behind the segment, at most this deep below the face with this normal.
    fn behind(&self, t: &Triangle, across: &Point, outward: &Point, deepest: f64) -> Option<Span> {
        let (ends, _) = cut(t, across, &self.from, &self.direction, 0.0)?;
        let [(s, h), (t, k)] = ends.map(|p| {
            let from = sub(&p, &self.from);
            (dot(&from, &self.direction), -dot(&from, outward))
        });
        // The part of the cut at depths from 0 on.
        let (mut begin, mut end) = (0.0f64, 1.0f64);
        for (a, b) in [(h, k), (deepest - h, deepest - k)] {
            if a < 0.0 && b < 0.0 {
                return None;
            }
            if a < 0.0 {
                begin = begin.max(a / (a - b));
            }
            if b < 0.0 {
                end = end.min(a / (a - b));
            }
        }
        let span = [(s + begin * (t - s)).max(0.0), (s + end * (t - s)).min(self.size)];
        (span[0] < span[1]).then_some(span)
    }

    /// The spans where both surfaces go on beyond each other: where an edge lies in the other surface, another triangle has to.
    /// `shift`: from the frame of the first body to that of the second, which is the frame of the segment.
    pub fn where_through(&self, [first, second]: [&Body; 2], shift: &Point, least: f64) -> Vec<Span> {
        let [(m, first_side), (n, second_side)] = self.sides;
        let all = vec![[0.0, self.size]];
        let beyond_first = if first_side == 0.0 {
            all.clone()
        } else {
            self.moved(&scaled(shift, -1.0)).beyond(first, &n, -first_side, least)
        };
        let beyond_second = if second_side == 0.0 { all } else { self.beyond(second, &m, -second_side, least) };
        shared(&beyond_first, &beyond_second)
    }

    /// The spans where a triangle of a body has an edge on the segment, and is on this side of the plane through it.
    fn beyond(&self, body: &Body, normal: &Point, side: f64, least: f64) -> Vec<Span> {
        let to = along(&self.from, self.size, &self.direction);
        let around = Aabb::of_triangle(&[self.from, to, to]);
        let around = Aabb { lower: around.lower.map(|x| x - least), upper: around.upper.map(|x| x + least) };
        let mut found = Vec::new();
        body.find_overlapping(&around, |i| {
            if let Some((ends, own_side)) = cut(body.triangle(i), normal, &self.from, &self.direction, least) {
                let [s, t] = ends.map(|p| dot(&sub(&p, &self.from), &self.direction));
                let is_on = |p: &Point, s: f64| length(&sub(p, &along(&self.from, s, &self.direction))) <= 4.0 * least;
                let span = [s.max(0.0), t.min(self.size)];
                if own_side == side && span[0] < span[1] && is_on(&ends[0], s) && is_on(&ends[1], t) {
                    found.push(span);
                }
            }
            None::<()>
        });
        merged(found, least)
    }

    /// The points of spans at every step along the whole line, wherever the triangles end; in long spans at every second, fourth and so on.
    /// `origin`: of the frame, in the world.
    pub fn points<'a>(&'a self, spans: &'a [Span], step: f64, origin: &Point) -> impl Iterator<Item = Point> + 'a {
        let before = dot(&add(&self.from, origin), &self.direction);
        spans.iter().flat_map(move |[begin, end]| {
            let least = (end - begin) / MOST_NEEDLE_POINTS;
            let step = step * (least / step).log2().ceil().max(0.0).exp2();
            let (first, last) = (((before + begin) / step).ceil(), ((before + end) / step).floor());
            let count = (last - first + 1.0).max(0.0) as usize;
            (0..count).map(move |n| along(&self.from, (first + n as f64) * step - before, &self.direction))
        })
    }
}

/// Where a triangle cuts a plane through a point, along a direction in it, and on which side of it the triangle is; 0 on both. `None` where
/// it is in the plane, or shares no more than a corner with it. Corners at most `least` from the plane are in it, metres.
fn cut(t: &Triangle, normal: &Point, on: &Point, direction: &Point, least: f64) -> Option<([Point; 2], f64)> {
    let heights = t.map(|p| dot(normal, &sub(&p, on))).map(|h| if h.abs() <= least { 0.0 } else { h });
    let [is_below, is_above] = [-1.0, 1.0].map(|side| heights.iter().any(|h| side * h > 0.0));
    let side = f64::from(i8::from(is_above) - i8::from(is_below));
    let in_plane = heights.iter().filter(|h| **h == 0.0).count();
    if side != 0.0 && in_plane < 2 || in_plane == 3 {
        return None;
    }
    let through = (0..3).filter_map(|i| {
        let (h, k) = (heights[i], heights[(i + 1) % 3]);
        (h * k <= 0.0 && h != k).then(|| along(&t[i], h / (h - k), &sub(&t[(i + 1) % 3], &t[i])))
    });
    let mut through: Vec<Point> = through.collect();
    through.sort_by(|p, q| dot(p, direction).total_cmp(&dot(q, direction)));
    Some(([*through.first()?, *through.last()?], side))
}

/// Spans in order, those joined that are no farther apart than `least`, metres.
fn merged(mut spans: Vec<Span>, least: f64) -> Vec<Span> {
    spans.sort_by(|p, q| p[0].total_cmp(&q[0]));
    let mut found: Vec<Span> = Vec::with_capacity(spans.len());
    for span in spans {
        match found.last_mut() {
            Some(last) if span[0] <= last[1] + least => last[1] = last[1].max(span[1]),
            _ => found.push(span),
        }
    }
    found
}

/// What two lists of spans share, each of spans apart and in order.
pub fn shared(p: &[Span], q: &[Span]) -> Vec<Span> {
    let (mut i, mut j) = (0, 0);
    let mut found = Vec::new();
    while i < p.len() && j < q.len() {
        let both = [p[i][0].max(q[j][0]), p[i][1].min(q[j][1])];
        if both[0] < both[1] {
            found.push(both);
        }
        if p[i][1] < q[j][1] {
            i += 1;
        } else {
            j += 1;
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::super::brute::{block, body};
    use super::*;
    use feeler_core::geometry::vectors::precise_normal;
    use feeler_shapes::random::Random;

    fn line_of(t: &Triangle, u: &Triangle, least: f64) -> Option<SharedLine> {
        SharedLine::new([t, u], [precise_normal(t)?, precise_normal(u)?], least)
    }

    #[test]
    fn triangles_share_a_segment_or_nothing() {
        let t = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]];
        let mut r = Random::new(1);
        for (u, expected) in [
            // An edge of each through the other; two edges of one; a corner or an edge in it; an edge just off it; beside; in its plane.
            ([[0.5, 0.5, -1.0], [0.5, 0.5, 1.0], [0.5, 9.0, 0.0]], Some(([0.5, 1.0, 0.0], 1.0, [0.0, 0.0]))),
            ([[0.5, 0.5, -1.0], [0.5, 0.5, 1.0], [0.5, 0.7, 1.0]], Some(([0.5, 0.55, 0.0], 0.1, [0.0, 0.0]))),
            ([[0.5, 0.5, 0.0], [0.5, 0.5, 1.0], [0.5, 0.7, 1.0]], None),
            ([[0.5, 0.5, 0.0], [0.9, 0.5, 0.0], [0.5, 0.5, 1.0]], Some(([0.7, 0.5, 0.0], 0.4, [0.0, 1.0]))),
            ([[0.5, 0.0, 0.0], [0.9, 0.0, 0.0], [0.5, 0.0, -1.0]], Some(([0.7, 0.0, 0.0], 0.4, [1.0, -1.0]))),
            ([[0.5, 0.5, 1e-8], [0.9, 0.5, 1e-8], [0.5, 0.5, 1.0]], None),
            ([[5.0, 0.5, -1.0], [5.0, 0.5, 1.0], [5.0, 9.0, 0.0]], None),
            ([[0.1, 0.1, 0.0], [0.9, 0.5, 0.0], [0.5, 0.5, 0.0]], None),
        ] {
            let m = r.motion(1.0);
            let place = |p: &Point| -> Point { std::array::from_fn(|a| dot(&[m[a][0], m[a][1], m[a][2]], p)) };
            let found = line_of(&t.map(|p| place(&p)), &u.map(|p| place(&p)), 1e-9);
            assert_eq!(found.is_some(), expected.is_some(), "{u:?}");
            if let (Some(found), Some((middle, size, sides))) = (found, expected) {
                let own = along(&found.from, 0.5 * found.size, &found.direction);
                assert!(length(&sub(&own, &place(&middle))) < 1e-9 && (found.size - size).abs() < 1e-9, "{u:?}");
                assert_eq!(found.sides.map(|(_, side)| side.abs()), sides.map(f64::abs), "{u:?}");
            }
        }
    }

    #[test]
    fn walls_are_where_a_face_is_behind_that_is_near_enough() {
        // A plate that is thinner from x = 0 on, cut by a plane across it.
        let plate = |cells| {
            feeler_shapes::joined([
                block([-1.0, -1.0, -0.2], [0.0, 1.0, 0.0], cells),
                block([0.0, -1.0, -0.1], [1.0, 1.0, 0.0], cells),
            ])
        };
        for cells in [1, 2, 5] {
            let body = body(plate(cells));
            let across = [[-0.8, 0.13, -1.0], [0.9, 0.13, -1.0], [0.05, 0.13, 9.0]].map(|p| sub(&p, body.origin()));
            for (thickness, expected) in [(0.05, 0.0), (0.15, 0.815), (0.25, 1.53)] {
                let mut sum = 0.0;
                for i in 0..body.len() as u32 {
                    if body.outward(i).is_some_and(|n| n[2] > 0.9) {
                        let Some(line) = line_of(body.triangle(i), &across, 1e-12) else { continue };
                        let found = line.before_walls(&body, i, thickness, 1e-12);
                        sum += found.iter().map(|[begin, end]| end - begin).sum::<f64>();
                    }
                }
                assert!((sum - expected).abs() < 1e-6, "{cells} {thickness}: {sum}");
            }
        }
    }

    #[test]
    fn spans_are_joined_and_shared() {
        let found = merged(vec![[3.0, 4.0], [0.0, 1.0], [1.0, 2.0], [0.5, 0.7]], 1e-9);
        assert_eq!(found, [[0.0, 2.0], [3.0, 4.0]]);
        assert_eq!(shared(&found, &[[1.5, 3.5], [3.6, 9.0]]), [[1.5, 2.0], [3.0, 3.5], [3.6, 4.0]]);
        assert!(shared(&found, &[[2.0, 3.0]]).is_empty() && shared(&found, &[]).is_empty());
    }

    #[test]
    fn points_of_a_line_do_not_depend_on_where_its_triangles_end() {
        let line = |from: f64, size: f64| SharedLine {
            from: [from, 0.0, 0.0],
            direction: [1.0, 0.0, 0.0],
            size,
            sides: [([0.0, 1.0, 0.0], 0.0), ([0.0, 0.0, 1.0], 0.0)],
        };
        let points = |from: f64, spans: &[Span]| -> Vec<f64> {
            line(from, 9.0).points(spans, 0.5, &[10.25, 0.0, 0.0]).map(|p| p[0]).collect()
        };
        assert_eq!(points(0.0, &[[0.0, 1.5]]), [0.25, 0.75, 1.25]);
        assert_eq!([points(0.0, &[[0.0, 0.625]]), points(0.625, &[[0.0, 0.875]])].concat(), [0.25, 0.75, 1.25]);
        assert!(points(0.0, &[[0.375, 0.5]]).is_empty());
        let long = points(0.0, &[[0.0, 2000.0]]);
        assert!(long.len() == 1000 && long[..2] == [1.75, 3.75], "{:?}", &long[..2]);
    }
}
