//! How deep two open surfaces cross. They have no inside, so the depth is an estimate: a point where they cross is as
//! deep as the least of
//!
//! - how far each surface goes on away from the other, on the side where it does so less, and
//! - the distance from that point to the border of either: over it the surfaces come free.
//!
//! The depth is that of the deepest such point. It is the depth of a tongue that reaches through a sheet, and 0 if a sheet
//! ends on another.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use feeler_core::constants::NONE;
use feeler_core::geometry::vectors::{
    add, along, cross, dot, length, precise_normal, scaled, square_to_segment, sub, unit,
};
use feeler_core::{Aabb, Point, Triangle};

use super::body::{distance_to, Body, Closest};
use super::depth::PointDepth;
use crate::constants::{LEAST_CROSSING_SINE, MOST_CROSSING_POINTS, MOST_CROSSING_STEPS};

/// Shares of the depth by which it may be missed, and of the pieces of the crossing that are still split.
const SLACK: f64 = 1e-3;

/// Halvings with which a walk finds where it leaves the other surface's reach.
const HALVINGS: usize = 16;

/// How deep two bodies without closed surfaces cross; its error is not known (NaN).
pub fn crossing_depth([a, b]: [&Body; 2]) -> PointDepth {
    let (few, many) = if a.len() <= b.len() { (a, b) } else { (b, a) };
    let search = Search { bodies: [few, many], shift: sub(few.origin(), many.origin()) };
    let (depth, point) = search.deepest();
    PointDepth { depth, error: f64::NAN, points: point.map(|p| [add(&p, few.origin()); 2]) }
}

/// A segment that two triangles share, in the frame of the first body.
#[derive(Debug, Clone, Copy)]
struct Shared {
    triangles: [u32; 2],
    ends: [Point; 2],
    /// The depth of its points is no more than that, metres.
    upper: f64,
}

impl Shared {
    fn middle(&self) -> Point {
        scaled(&add(&self.ends[0], &self.ends[1]), 0.5)
    }

    fn half(&self) -> f64 {
        0.5 * length(&sub(&self.ends[1], &self.ends[0]))
    }
}

impl Ord for Shared {
    fn cmp(&self, other: &Shared) -> Ordering {
        self.upper.total_cmp(&other.upper)
    }
}

impl PartialOrd for Shared {
    fn partial_cmp(&self, other: &Shared) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Shared {
    fn eq(&self, other: &Shared) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Shared {}

struct Search<'a> {
    bodies: [&'a Body; 2],
    /// From the frame of the first to that of the second.
    shift: Point,
}

impl Search<'_> {
    fn least(&self) -> f64 {
        self.bodies[0].rounding().max(self.bodies[1].rounding())
    }

    /// The depth and the deepest point, in the frame of the first.
    fn deepest(&self) -> (f64, Option<Point>) {
        let (mut best, mut point) = (0.0, None);
        let mut waiting: BinaryHeap<Shared> = self.shared().into();
        for _ in 0..MOST_CROSSING_POINTS {
            let Some(next) = waiting.pop().filter(|next| next.upper > best * (1.0 + SLACK) + self.least()) else {
                break;
            };
            let middle = next.middle();
            let depth = self.depth_at(&middle, next.triangles);
            if depth > best {
                (best, point) = (depth, Some(middle));
            }
            if next.half() > SLACK * next.upper {
                for end in next.ends {
                    let half = Shared { ends: [end, middle], ..next };
                    waiting.push(Shared { upper: next.upper.min(self.most(&half)), ..half });
                }
            }
        }
        (best, point)
    }

    /// How deep points of a segment may be: as far as the border of either is, which changes by no more than they are apart.
    fn most(&self, shared: &Shared) -> f64 {
        self.to_border(&shared.middle()) + shared.half()
    }

    fn to_border(&self, p: &Point) -> f64 {
        let distances = [*p, add(p, &self.shift)];
        distances.iter().zip(self.bodies).map(|(p, body)| body.border().distance(p)).fold(f64::INFINITY, f64::min)
    }

    /// Where triangles of both cross, or one ends on the other.
    fn shared(&self) -> Vec<Shared> {
        let ([few, many], least) = (self.bodies, self.least());
        let mut found = Vec::new();
        for i in 0..few.len() as u32 {
            let own = few.triangle(i);
            let t = own.map(|p| add(&p, &self.shift));
            let mut around = Aabb::of_triangle(&t);
            for a in 0..3 {
                around.lower[a] -= least;
                around.upper[a] += least;
            }
            many.find_overlapping(&around, |j| {
                if let Some(ends) = shared_segment(&t, many.triangle(j), least) {
                    let ends = ends.map(|p| sub(&p, &self.shift));
                    let shared = Shared { triangles: [i, j], ends, upper: 0.0 };
                    found.push(Shared { upper: self.most(&shared), ..shared });
                }
                None::<()>
            });
        }
        found
    }

    /// How deep the surfaces cross at a point of both.
    fn depth_at(&self, p: &Point, [i, j]: [u32; 2]) -> f64 {
        let [few, many] = self.bodies;
        let (Some(m), Some(n)) = (precise_normal(few.triangle(i)), precise_normal(many.triangle(j))) else {
            return 0.0;
        };
        let Some(line) = unit(&cross(&m, &n)) else { return 0.0 };
        let most = self.to_border(p);
        let back = scaled(&self.shift, -1.0);
        let walks = [
            (Walk { surface: few, other: many, shift: self.shift, most }, *p, i, &m, &n),
            (Walk { surface: many, other: few, shift: back, most }, add(p, &self.shift), j, &n, &m),
        ];
        walks.into_iter().fold(most, |least, (walk, from, own, normal, across)| {
            if least <= self.least() {
                return 0.0;
            }
            let aside = cross(&line, normal);
            let ways = [1.0, -1.0].map(|sign| walk.far(&from, own, &scaled(&aside, sign), across));
            if ways[0].1 * ways[1].1 >= 0 {
                return 0.0;
            }
            least.min(ways[0].0).min(ways[1].0)
        })
    }
}

/// A straight walk over a surface, away from another one.
struct Walk<'a> {
    surface: &'a Body,
    other: &'a Body,
    /// From the frame of the surface to that of the other.
    shift: Point,
    /// Farther than this from the other it need not come, metres.
    most: f64,
}

impl Walk<'_> {
    /// How far from the other surface the walk comes, and on which side of it, as a normal of the other says where the walk begins. It
    /// ends at the border, where it meets the other again, and where no point in the middle of the other is closest any more.
    fn far(&self, from: &Point, triangle: u32, direction: &Point, normal: &Point) -> (f64, i32) {
        let least = self.surface.rounding().max(self.other.rounding());
        let (mut p, mut i, mut d) = (*from, triangle, *direction);
        let (mut far, mut side, mut last) = (0.0f64, None, u32::MAX);
        for _ in 0..MOST_CROSSING_STEPS {
            let Some((step, k)) = exit(self.surface.triangle(i), &p, &d) else { break };
            let end = along(&p, step, &d);
            if step > least {
                let lean = dot(normal, &d);
                if side.is_none() && lean.abs() > LEAST_CROSSING_SINE {
                    side = Some(lean.signum() as i32);
                }
                let Some(closest) = self.over(&end, last) else {
                    far = far.max(self.until_aside(&p, &end, last));
                    break;
                };
                last = closest.triangle;
                if closest.distance <= least && far > 2.0 * least {
                    break;
                }
                if side.is_none() && closest.distance > 2.0 * least {
                    side = Some(self.side_beyond(&p, &end, &d, normal));
                }
                far = far.max(closest.distance);
                if far >= self.most {
                    break;
                }
            }
            let next = self.surface.neighbours(i)[k];
            if next == NONE {
                break;
            }
            let Some(turned) = self.over_edge(i, k, next, &d) else { break };
            (p, i, d) = (end, next, turned);
        }
        (far, side.unwrap_or(0))
    }

    /// On which side a walk in the plane of the other surface leaves it, over an edge at which that turns away.
    fn side_beyond(&self, p: &Point, end: &Point, direction: &Point, normal: &Point) -> i32 {
        let least = 2.0 * self.surface.rounding().max(self.other.rounding());
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..2 * HALVINGS {
            let middle = 0.5 * (low + high);
            let is_on = self.distance(&along(p, middle, &sub(end, p))) <= least;
            *(if is_on { &mut low } else { &mut high }) = middle;
        }
        let at = add(&along(p, low, &sub(end, p)), &self.shift);
        let within = least + 4.0 * (high - low) * length(&sub(end, p));
        let around = Aabb { lower: at.map(|x| x - within), upper: at.map(|x| x + within) };
        let body = self.other;
        let side = body.find_overlapping(&around, |i| {
            let level = dot(&precise_normal(body.triangle(i))?, normal);
            if level.abs() < 1.0 - LEAST_CROSSING_SINE || distance_to(&at, body.triangle(i)) > within {
                return None;
            }
            (0..3).find_map(|k| {
                let next = body.neighbours(i)[k];
                let t = body.triangle(i);
                if next == NONE || square_to_segment(&at, &t[k], &t[(k + 1) % 3]).sqrt() > within {
                    return None;
                }
                let n = precise_normal(body.triangle(next))?;
                let sense = if is_wound_alike([t[k], t[(k + 1) % 3]], body.triangle(next)) { 1.0 } else { -1.0 };
                let lean = sense * level.signum() * dot(&n, direction);
                (lean.abs() > LEAST_CROSSING_SINE).then_some(lean.signum() as i32)
            })
        });
        side.unwrap_or(0)
    }

    fn distance(&self, p: &Point) -> f64 {
        self.other.closest(&add(p, &self.shift), f64::INFINITY).map_or(f64::INFINITY, |closest| closest.distance)
    }

    /// The closest point of the other surface, if it is not on the border.
    fn over(&self, p: &Point, near: u32) -> Option<Closest> {
        let first = if near == u32::MAX { &[][..] } else { &[near][..] };
        let closest = self.other.closest_from(&add(p, &self.shift), first)?;
        (!self.other.border().has(self.other, &closest)).then_some(closest)
    }

    /// How far the walk from `p` towards `end` comes until the border of the other is closest.
    fn until_aside(&self, p: &Point, end: &Point, near: u32) -> f64 {
        let (mut low, mut high, mut far) = (0.0, 1.0, 0.0);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            match self.over(&along(p, middle, &sub(end, p)), near) {
                Some(closest) => (low, far) = (middle, closest.distance),
                None => high = middle,
            }
        }
        far
    }

    /// A direction in a triangle, turned into the plane of its neighbour over an edge.
    fn over_edge(&self, i: u32, k: usize, next: u32, direction: &Point) -> Option<Point> {
        let t = self.surface.triangle(i);
        let edge = unit(&sub(&t[(k + 1) % 3], &t[k]))?;
        let aside = |corner: &Point| {
            let from = sub(corner, &t[k]);
            along(&from, -dot(&from, &edge), &edge)
        };
        let corners = self.surface.triangle(next).map(|corner| aside(&corner));
        let farthest = corners.iter().max_by(|p, q| length(p).total_cmp(&length(q)))?;
        let share = dot(direction, &edge);
        Some(along(&scaled(&edge, share), (1.0 - share * share).max(0.0).sqrt(), &unit(farthest)?))
    }
}

/// Whether a triangle runs along an edge of its neighbour the other way, as in a surface wound in one sense.
fn is_wound_alike(edge: [Point; 2], t: &Triangle) -> bool {
    let ends = edge.map(|p| {
        let near = |i: &usize, j: &usize| length(&sub(&t[*i], &p)).total_cmp(&length(&sub(&t[*j], &p)));
        (0..3).min_by(near).unwrap_or(0)
    });
    (ends[1] + 1) % 3 == ends[0]
}

/// After how long a way in its plane a point leaves a triangle, and over which edge.
fn exit(t: &Triangle, p: &Point, direction: &Point) -> Option<(f64, usize)> {
    let n = precise_normal(t)?;
    (0..3)
        .filter_map(|k| {
            let inward = unit(&cross(&n, &sub(&t[(k + 1) % 3], &t[k])))?;
            let (height, rate) = (dot(&inward, &sub(p, &t[k])), dot(&inward, direction));
            (rate < -1e-12).then(|| (height.max(0.0) / -rate, k))
        })
        .min_by(|x, y| x.0.total_cmp(&y.0))
}

/// The segment that two triangles share, if they are not nearly in one plane and it is longer than rounding.
fn shared_segment(t: &Triangle, u: &Triangle, least: f64) -> Option<[Point; 2]> {
    let (m, n) = (precise_normal(t)?, precise_normal(u)?);
    let line = cross(&m, &n);
    let sine = length(&line);
    if sine < LEAST_CROSSING_SINE {
        return None;
    }
    let line = scaled(&line, 1.0 / sine);
    let aside = cross(&line, &m);
    let origin = along(&t[0], -dot(&n, &sub(&t[0], &u[0])) / dot(&n, &aside), &aside);
    let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
    for (t, n) in [(t, &m), (u, &n)] {
        for k in 0..3 {
            let inward = unit(&cross(n, &sub(&t[(k + 1) % 3], &t[k])))?;
            let (height, rate) = (dot(&inward, &sub(&origin, &t[k])) + least, dot(&inward, &line));
            if rate.abs() < 1e-12 {
                if height < 0.0 {
                    return None;
                }
            } else if rate > 0.0 {
                low = low.max(-height / rate);
            } else {
                high = high.min(-height / rate);
            }
        }
    }
    (high - low > 4.0 * least).then(|| [low, high].map(|at| along(&origin, at, &line)))
}

#[cfg(test)]
mod tests {
    use super::super::brute::{body, placed};
    use super::*;
    use feeler_shapes::random::Random;
    use feeler_shapes::{joined, sheet, Arrays};

    /// A parallelogram at a corner, cut into cells.
    fn plate(at: Point, u: Point, v: Point, cells: usize) -> Arrays {
        sheet(cells, cells, |s, t| std::array::from_fn(|a| at[a] + s * u[a] + t * v[a]))
    }

    /// Checks a depth at some turns, either way round, cut finely and not.
    fn assert_depth(p: impl Fn(usize) -> Arrays, q: impl Fn(usize) -> Arrays, expected: f64, what: &str) {
        let mut r = Random::new(9);
        let mut still = r.motion(0.0);
        (0..12).for_each(|n| still[n / 4][n % 4] = if n % 4 == n / 4 { 1.0 } else { 0.0 });
        for m in [still, r.motion(1.0), r.motion(100.0)] {
            for cells in [[1, 1], [2, 1], [3, 4]] {
                let [a, b] = [placed(p(cells[0]), &m), placed(q(cells[1]), &m)].map(body);
                for pair in [[&a, &b], [&b, &a]] {
                    let found = crossing_depth(pair);
                    assert!((found.depth - expected).abs() <= 2e-3 * expected + 1e-11, "{what}, {cells:?}: {found:?}");
                    assert!(found.error.is_nan() && found.points.is_some() == (found.depth > 0.0));
                }
            }
        }
    }

    fn floor(cells: usize) -> Arrays {
        plate([-1.0, -1.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0], cells)
    }

    #[test]
    fn sheets_are_as_deep_as_they_reach_through() {
        for depth in [1e-6, 1e-3, 0.2] {
            let tongue = |cells| plate([0.1, -0.5, -depth], [0.0, 1.0, 0.0], [0.0, 0.0, 2.0], cells);
            assert_depth(floor, tongue, depth, "a tongue");
            let wide = |cells| plate([0.1, -3.0, -depth], [0.0, 6.0, 0.0], [0.0, 0.0, 2.0], cells);
            assert_depth(floor, wide, depth, "a wide tongue");
        }
        let through = |cells| plate([0.0, -0.5, -1.0], [0.0, 1.0, 0.0], [0.0, 0.0, 2.0], cells);
        assert_depth(floor, through, 0.5, "a sheet right through");
        let leaning = |cells| plate([-0.5, -0.5, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 2.0], cells);
        assert_depth(floor, leaning, 0.5, "a leaning sheet right through");
        // Cards that are pushed into each other by an edge.
        let card = |cells| plate([0.1, 0.75, -0.5], [0.0, 2.0, 0.0], [0.0, 0.0, 1.0], cells);
        assert_depth(floor, card, 0.125, "cards");
    }

    #[test]
    fn sheets_that_end_on_each_other_do_not_cross() {
        let web = |cells| plate([0.1, -0.5, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], cells);
        assert_depth(floor, web, 0.0, "a web");
        let flange = |far: f64| move |cells| plate([0.1, -0.5, 0.0], [far, 0.0, 0.0], [0.0, 1.0, 0.0], cells);
        assert_depth(floor, |cells| joined([web(cells), flange(0.4)(cells)]), 0.0, "an angle");
        assert_depth(floor, flange(0.4), 0.0, "a sheet on it");
        assert_depth(floor, flange(4.0), 0.0, "a sheet over its border");
        // Where the floor turns down, the angle on it goes on outside; where it turns up, through it.
        for (turn, expected) in [(-1.0, 0.0), (1.0, 0.5)] {
            let bent =
                |cells| joined([floor(cells), plate([1.0, -1.0, 0.0], [0.0, 0.0, turn], [0.0, 2.0, 0.0], cells)]);
            assert_depth(bent, |cells| joined([web(cells), flange(4.0)(cells)]), expected, "an angle over an edge");
        }
    }
}
