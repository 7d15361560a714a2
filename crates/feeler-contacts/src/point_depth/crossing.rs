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

/// Share of the depth by which it may be missed, and of the distance to the border in which pieces of the crossing are not split.
const SLACK: f64 = 1e-3;

/// Pieces of the crossing shorter than this share of their distance to the border are split where the depth is largest.
const SHORT: f64 = 0.02;

/// By how many times the way the depth rises at most along such a piece; only jumps rise more.
const MOST_RISE: f64 = 4.0;

/// Halvings with which a walk finds where it leaves the other surface's reach.
const HALVINGS: usize = 16;

/// Most points of a straight way at which the border of the other surface is looked for.
const MOST_CLEAR_STEPS: usize = 256;

/// The least way between two of them, in distances from it.
const LEAST_CLEAR_STEP: f64 = 0.02;

/// Most points of a straight way at which the distance of the other surface is measured.
const MOST_WAY_POINTS: usize = 64;

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
    /// No point of it is farther from the nearer border, metres.
    to_border: f64,
    /// Nor deeper than this, as far as is known, metres.
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
            if next.half() <= SLACK * next.to_border {
                continue;
            }
            // Where pieces are short, those beside deep points come first.
            let is_short = next.half() <= SHORT * next.to_border;
            let likely = if is_short { depth + MOST_RISE * next.half() } else { f64::INFINITY };
            for end in next.ends {
                let half = Shared { ends: [end, middle], ..next };
                let to_border = next.to_border.min(self.most(&half));
                waiting.push(Shared { to_border, upper: to_border.min(next.upper).min(likely), ..half });
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
                    let shared = Shared { triangles: [i, j], ends, to_border: 0.0, upper: 0.0 };
                    let most = self.most(&shared);
                    found.push(Shared { to_border: most, upper: most, ..shared });
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
        let least = self.least();
        let (mut p, mut i, mut d) = (*from, triangle, *direction);
        let (mut far, mut side) = (0.0f64, None);
        let Some(mut begin) = self.closest(&p, u32::MAX) else { return (0.0, 0) };
        // Near the crossing the other's border is not closest.
        let mut clear = 0.5 * self.most;
        for _ in 0..MOST_CROSSING_STEPS {
            let Some((step, k)) = exit(self.surface.triangle(i), &p, &d) else { break };
            let end = along(&p, step, &d);
            if step > least {
                let lean = dot(normal, &d);
                if side.is_none() && lean.abs() > LEAST_CROSSING_SINE {
                    side = Some(lean.signum() as i32);
                }
                let Some(closest) = self.closest(&end, begin.triangle) else { break };
                // Nothing is met on the way if that is shorter than both ends are far.
                let is_near = begin.distance + closest.distance <= step + 4.0 * least;
                let met = if is_near { self.meets_again([&p, &end], &d, far) } else { None };
                let aside = self.aside(&p, &d, met.unwrap_or(step), begin.triangle, &mut clear);
                if let Some(until) = aside.or(met) {
                    let last = along(&p, until, &d);
                    if let Some(closest) = self.closest(&last, begin.triangle) {
                        far = self.farthest([(p, begin), (last, closest)], far);
                    }
                    break;
                }
                if closest.distance <= least && far > 2.0 * least {
                    break;
                }
                if side.is_none() && closest.distance > 2.0 * least {
                    side = Some(self.side_beyond(&p, &end, &d, normal));
                }
                far = self.farthest([(p, begin), (end, closest)], far);
                if far >= self.most {
                    break;
                }
                begin = closest;
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

    fn least(&self) -> f64 {
        self.surface.rounding().max(self.other.rounding())
    }

    /// After how long a straight way goes through the other surface again; `far`: how far from it the walk came before. Where the other
    /// turns away at an edge from a walk that lies on it, they do not part.
    fn meets_again(&self, [p, end]: [&Point; 2], direction: &Point, far: f64) -> Option<f64> {
        let least = self.least();
        let [from, to] = [p, end].map(|p| add(p, &self.shift));
        let mut met = Vec::new();
        self.other.tree().find_on_segment([&from, &to], least, |i| {
            let t = self.other.triangle(i);
            let heights = [&from, &to].map(|q| Some(dot(&precise_normal(t)?, &sub(q, &t[0]))));
            if let [Some(low), Some(high)] = heights {
                let at = low / (low - high);
                let is_through = low.abs() > 2.0 * least && low * high < 0.0;
                if is_through && distance_to(&along(&from, at, &sub(&to, &from)), t) <= 2.0 * least {
                    met.push(at * length(&sub(&to, &from)));
                }
            }
            None::<()>
        });
        met.sort_unstable_by(f64::total_cmp);
        let mut before = 0.0;
        met.into_iter().find(|at| {
            let middle = along(p, 0.5 * (before + at), direction);
            before = *at;
            far > 2.0 * least || self.distance(&middle) > 2.0 * least
        })
    }

    /// After how long a straight way of some length the border of the other is closest. For the length `clear` it is known not to be:
    /// the distances to the border and to the surface differ by more than twice that, and each changes by no more than the way.
    fn aside(&self, p: &Point, direction: &Point, way: f64, near: u32, clear: &mut f64) -> Option<f64> {
        let (body, least) = (self.other, self.least());
        let (mut before, mut at) = (0.0, *clear);
        let over = |at: f64| {
            let closest = self.closest(&along(p, at, direction), near)?;
            (!body.border().has(body, &closest)).then_some(closest)
        };
        for _ in 0..MOST_CLEAR_STEPS {
            if at >= way {
                break;
            }
            let Some(closest) = over(at) else {
                let mut ends = [before, at];
                for _ in 0..HALVINGS {
                    let middle = 0.5 * (ends[0] + ends[1]);
                    ends[usize::from(over(middle).is_none())] = middle;
                }
                return Some(ends[0]);
            };
            if closest.distance >= self.most {
                break;
            }
            let q = add(&along(p, at, direction), &self.shift);
            let room = body.border().distance(&q) - closest.distance;
            before = at;
            at += (0.5 * room).max(LEAST_CLEAR_STEP * closest.distance).max(least);
        }
        *clear = (at - way).max(0.0);
        None
    }

    /// How far from the other a straight way comes, if that is farther than `far`; its ends are given with their closest points.
    fn farthest(&self, ends: [(Point, Closest); 2], far: f64) -> f64 {
        let mut best = ends.iter().fold(far, |far, end| far.max(end.1.distance));
        let mut waiting = vec![ends];
        for _ in 0..MOST_WAY_POINTS {
            let Some([a, b]) = waiting.pop() else { break };
            let enough = (best * (1.0 + SLACK)).max(best + self.least());
            // The distance to one triangle is largest at an end.
            let to_triangle = |from: &Closest, p: &Point| {
                from.distance.max(distance_to(&add(p, &self.shift), self.other.triangle(from.triangle)))
            };
            let by_length = 0.5 * (a.1.distance + b.1.distance + length(&sub(&b.0, &a.0)));
            if best >= self.most
                || by_length <= enough
                || to_triangle(&a.1, &b.0) <= enough
                || to_triangle(&b.1, &a.0) <= enough
            {
                continue;
            }
            let middle = scaled(&add(&a.0, &b.0), 0.5);
            let Some(closest) = self.closest(&middle, a.1.triangle) else { continue };
            best = best.max(closest.distance);
            waiting.extend([[a, (middle, closest)], [(middle, closest), b]]);
        }
        best
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

    /// The closest point of the other surface.
    fn closest(&self, p: &Point, near: u32) -> Option<Closest> {
        let first = if near == u32::MAX { &[][..] } else { &[near][..] };
        self.other.closest_from(&add(p, &self.shift), first)
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
    use feeler_shapes::{ball, joined, sheet, Arrays};

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

    /// A tub without a lid: its floor `depth` below, and its walls up to a height of 1.
    fn tub(depth: f64, cells: usize) -> Arrays {
        let wall = |x: f64, y: f64, u: Point| plate([x, y, -depth], u, [0.0, 0.0, 1.0], cells);
        let (along_x, along_y) = ([0.8, 0.0, 0.0], [0.0, 0.8, 0.0]);
        joined([
            plate([-0.4, -0.4, -depth], along_x, along_y, cells),
            wall(-0.4, -0.4, along_x),
            wall(-0.4, 0.4, along_x),
            wall(-0.4, -0.4, along_y),
            wall(0.4, -0.4, along_y),
        ])
    }

    #[test]
    fn what_comes_back_is_as_deep_as_it_is_on_its_shorter_side() {
        let wide = |cells| plate([-2.0, -2.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0], cells);
        for depth in [1e-6, 0.01, 0.1, 0.3] {
            assert_depth(wide, |cells| tub(depth, cells), depth, "a tub");
            let channel = |cells| {
                let wall = |x: f64| plate([x, -0.5, -depth], [0.0, 1.0, 0.0], [0.0, 0.0, 2.0], cells);
                let bottom = plate([-0.4, -0.5, -depth], [0.8, 0.0, 0.0], [0.0, 1.0, 0.0], cells);
                joined([bottom, wall(-0.4), wall(0.4)])
            };
            assert_depth(wide, channel, depth, "a channel");
            // The sheet inside the fold is at its deepest 1 / sqrt(2) as far from it.
            let fold = |cells| {
                let leaf = |x: f64| plate([0.0, -0.5, -depth], [0.0, 1.0, 0.0], [x, 0.0, 1.0], cells);
                joined([leaf(1.0), leaf(-1.0)])
            };
            assert_depth(wide, fold, depth * 0.5f64.sqrt(), "a fold");
        }
    }

    #[test]
    fn the_cap_of_a_dome_is_as_deep_as_it_is_high() {
        let wide = |cells| body(plate([-2.0, -2.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0], cells));
        for (depth, n) in [(0.005, 24), (0.05, 16)] {
            let (vertices, faces) = ball(0.5, n);
            let is_low = |f: &[u32; 3]| f.iter().map(|v| vertices[*v as usize][2]).sum::<f64>() < 0.3;
            let faces = faces.into_iter().filter(is_low).collect();
            let low = vertices.iter().map(|p| p[2]).fold(f64::INFINITY, f64::min);
            let sunk = vertices.iter().map(|p| [p[0], p[1], p[2] - low - depth]).collect();
            let dome = body((sunk, faces));
            for cells in [1, 2, 5] {
                let found = crossing_depth([&dome, &wide(cells)]);
                assert!((0.5 * depth..1.01 * depth).contains(&found.depth), "{depth} {cells}: {found:?}");
            }
        }
    }

    #[test]
    fn depths_do_not_depend_on_how_surfaces_are_cut() {
        let mut r = Random::new(3);
        for n in 0..8 {
            let sheet = |cells| match n % 2 {
                0 => plate([-1.0, -1.0, 0.0], [3.0, 0.0, 0.0], [0.0, 3.0, 0.0], cells),
                _ => tub(0.0, cells),
            };
            let m = r.motion(0.3);
            let depth = |cells| crossing_depth([&body(sheet(cells)), &body(placed(tub(0.0, cells), &m))]).depth;
            let expected = depth(1);
            assert!(expected > 0.01, "{n}");
            for cells in [2, 3, 6] {
                assert!((depth(cells) - expected).abs() <= 2e-3 * expected, "{n} {cells}: {} {expected}", depth(cells));
            }
        }
    }
}
