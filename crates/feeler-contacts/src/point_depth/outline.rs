//! A convex polygon in a triangle of one surface, and where the other surface cuts it.

use feeler_core::geometry::vectors::{add, cross, dot, length, precise_normal, scaled, sub, unit};
use feeler_core::{Aabb, Point, Triangle};

use super::body::Body;

/// A plane to cut at: `dot(normal, p) = offset`.
#[derive(Debug, Clone, Copy)]
pub struct Plane {
    /// Of length 1.
    normal: Point,
    offset: f64,
    /// A triangle of the other body that is near where it cuts, if any is known.
    near: Option<u32>,
}

impl Plane {
    /// Through a point.
    pub fn through(p: &Point, normal: &Point) -> Option<Plane> {
        let normal = unit(normal)?;
        Some(Plane { normal, offset: dot(&normal, p), near: None })
    }

    /// Of a unit normal.
    pub fn at(normal: Point, offset: f64) -> Plane {
        Plane { normal, offset, near: None }
    }

    /// The same, near a triangle of the other body.
    pub fn near(self, triangle: u32) -> Plane {
        Plane { near: Some(triangle), ..self }
    }

    /// A triangle of the other body that is near where it cuts.
    pub fn nearest(&self) -> Option<u32> {
        self.near
    }

    /// How far a point is on the positive side.
    pub fn height(&self, p: &Point) -> f64 {
        dot(&self.normal, p) - self.offset
    }
}

/// See the module.
#[derive(Debug, Clone)]
pub struct Outline {
    pub points: Vec<Point>,
    /// The normal of its triangle; zero where it has none.
    pub normal: Point,
    /// 1 where that leads out of its body, -1 where it leads in; 0 where the surface is open.
    pub sense: i8,
}

impl Outline {
    /// The triangle as far as it is in a box; `None` where nothing is left.
    pub fn clipped(t: &Triangle, sense: i8, bounds: Option<&Aabb>) -> Option<Outline> {
        let mut points: Vec<Point> = t.to_vec();
        if let Some(bounds) = bounds {
            for axis in 0..3 {
                for (sense, side) in [(1.0, bounds.lower[axis]), (-1.0, bounds.upper[axis])] {
                    if points.iter().any(|p| sense * (p[axis] - side) < 0.0) {
                        points = half_of(&points, |p| sense * (p[axis] - side));
                    }
                    if points.is_empty() {
                        return None;
                    }
                }
            }
        }
        Some(Outline { points, normal: precise_normal(t).unwrap_or_default(), sense })
    }

    /// The middle of its corners.
    pub fn middle(&self) -> Point {
        let sum = self.points.iter().fold([0.0; 3], |sum, p| add(&sum, p));
        scaled(&sum, 1.0 / self.points.len() as f64)
    }

    /// How far its corners are from a point, at most.
    pub fn radius(&self, from: &Point) -> f64 {
        self.points.iter().map(|p| length(&sub(p, from))).fold(0.0, f64::max)
    }

    /// The parts on each side of a plane. A part that is nothing but a line is left out.
    pub fn cut(&self, plane: &Plane) -> impl Iterator<Item = Outline> + '_ {
        let plane = *plane;
        [1.0, -1.0].into_iter().filter_map(move |sense| {
            let points = half_of(&self.points, |p| sense * plane.height(p));
            (points.len() >= 3).then_some(Outline { points, ..*self })
        })
    }

    /// Whether its corners are on both sides of a plane, farther than `least`.
    fn is_split(&self, plane: &Plane, least: f64) -> bool {
        let (mut below, mut above) = (false, false);
        for p in &self.points {
            let height = plane.height(p);
            below |= height < -least;
            above |= height > least;
        }
        below && above
    }

    /// Where the other surface parts it: a plane across it along the line where a triangle of the other body goes through it, or, of one
    /// that lies in it, along a side. Lines no longer than `least`, and those within that of its border, do not count.
    pub fn parting(&self, body: &Body, least: f64) -> Option<Plane> {
        let mut around = self.points.iter().fold(Aabb::EMPTY, |mut around, p| {
            around.grow(p);
            around
        });
        for a in 0..3 {
            around.lower[a] -= least;
            around.upper[a] += least;
        }
        body.find_overlapping(&around, |i| {
            let [x, y, z, offset] = *body.plane(i);
            let on_side =
                |sense: f64| self.points.iter().all(|p| sense * (x * p[0] + y * p[1] + z * p[2] - offset) > least);
            // Mostly it is on one side of the triangle's plane.
            if on_side(1.0) || on_side(-1.0) {
                return None;
            }
            self.parting_by(body.triangle(i), least).map(|plane| plane.near(i))
        })
    }

    fn parting_by(&self, t: &Triangle, least: f64) -> Option<Plane> {
        let n = &self.normal;
        let origin = &self.points[0];
        let height = |p: &Point| dot(n, &sub(p, origin));
        let heights = [height(&t[0]), height(&t[1]), height(&t[2])];
        let is_on_one_side =
            |sense: f64| sense * heights[0] > least && sense * heights[1] > least && sense * heights[2] > least;
        if is_on_one_side(1.0) || is_on_one_side(-1.0) {
            return None;
        }
        let side = |h: f64| if h > least { 1 } else { i32::from(h >= -least) - 1 };
        let sides = [side(heights[0]), side(heights[1]), side(heights[2])];
        let on: Vec<usize> = (0..3).filter(|i| sides[*i] == 0).collect();
        if on.len() == 3 || self.is_in_plane(t, 2.0 * least) {
            return (0..3).find_map(|i| self.across(&t[i], &t[(i + 1) % 3], least));
        }
        match on.len() {
            2 => self.across(&t[on[0]], &t[on[1]], least),
            _ => {
                // Each with how far rounding may move it: along a side that is at a grazing angle by more.
                let mut ends: Vec<(Point, Point)> = on.iter().map(|i| (t[*i], [0.0; 3])).collect();
                for i in 0..3 {
                    let j = (i + 1) % 3;
                    if sides[i] * sides[j] < 0 {
                        let rise = heights[i] - heights[j];
                        let off = scaled(&sub(&t[j], &t[i]), least / rise);
                        ends.push((between(&t[i], &t[j], heights[i] / rise), off));
                    }
                }
                let [(p, p_off), (q, q_off), ..] = &ends[..] else { return None };
                let across = unit(&cross(n, &sub(q, p)))?;
                let margin = [p_off, q_off].iter().map(|off| dot(&across, off).abs()).fold(least, f64::max);
                self.across(p, q, 4.0 * margin)
            }
        }
    }

    /// Whether all of it is in the plane of a triangle: of a large one beside a small piece corners may be aside by more.
    fn is_in_plane(&self, t: &Triangle, least: f64) -> bool {
        precise_normal(t).is_some_and(|n| self.points.iter().all(|p| dot(&n, &sub(p, &t[0])).abs() <= least))
    }

    /// The plane across it along a segment in it, if parts on both sides of that are wider than `least`. If the segment is but a small part
    /// of the line through it, the plane across its length: what is cut along the line beyond the segment's ends is cut for nothing.
    fn across(&self, p: &Point, q: &Point, least: f64) -> Option<Plane> {
        let along = sub(q, p);
        let plane = Plane::through(p, &cross(&self.normal, &along))?;
        if !self.is_split(&plane, least) {
            return None;
        }
        let [from, to] = self.chord(p, &along);
        let covered = to.min(1.0) - from.max(0.0);
        // A short line counts where it is across a tip.
        if covered <= 0.0 || (covered < 0.5 * (to - from) && covered * length(&along) <= least) {
            return None;
        }
        if covered < LONG_SEGMENT * (to - from) {
            return self.lengthwise();
        }
        Some(plane)
    }

    /// Between which shares of a segment in its plane its line is in the polygon.
    fn chord(&self, from: &Point, along: &Point) -> [f64; 2] {
        let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
        let count = self.points.len();
        for i in 0..count {
            let (p, q) = (&self.points[i], &self.points[(i + 1) % count]);
            let inward = cross(&self.normal, &sub(q, p));
            let (start, slope) = (dot(&inward, &sub(from, p)), dot(&inward, along));
            if slope == 0.0 {
                if start < 0.0 {
                    return [0.0; 2];
                }
                continue;
            }
            let at = -start / slope;
            if slope > 0.0 {
                low = low.max(at);
            } else {
                high = high.min(at);
            }
        }
        [low, high.max(low)]
    }

    /// Across the longest line between two of its corners, in the middle of it.
    pub fn lengthwise(&self) -> Option<Plane> {
        let (mut most, mut ends) = (0.0, None);
        for (i, p) in self.points.iter().enumerate() {
            for q in &self.points[i + 1..] {
                let apart = sub(q, p);
                let square = dot(&apart, &apart);
                if square > most {
                    (most, ends) = (square, Some((*p, apart)));
                }
            }
        }
        let (p, apart) = ends?;
        let middle = std::array::from_fn(|a| p[a] + 0.5 * apart[a]);
        Plane::through(&middle, &apart)
    }
}

/// Share of a line through a piece from which on a segment is long.
const LONG_SEGMENT: f64 = 0.3;

/// The part of a convex polygon where a height is not negative.
fn half_of(polygon: &[Point], height: impl Fn(&Point) -> f64) -> Vec<Point> {
    let mut half = Vec::with_capacity(polygon.len() + 1);
    for (i, p) in polygon.iter().enumerate() {
        let q = &polygon[(i + 1) % polygon.len()];
        let (h, k) = (height(p), height(q));
        if h >= 0.0 {
            half.push(*p);
        }
        if h * k < 0.0 {
            let s = h / (h - k);
            half.push(between(p, q, s));
        }
    }
    half
}

/// The sides of a polygon that a plane crosses: from which corner to which, and at which share of it.
pub fn crossings(heights: &[f64]) -> impl Iterator<Item = (usize, usize, f64)> + '_ {
    let count = heights.len();
    (0..count).filter_map(move |i| {
        let j = (i + 1) % count;
        let (h, k) = (heights[i], heights[j]);
        (h * k < 0.0).then(|| (i, j, h / (h - k)))
    })
}

pub fn between(p: &Point, q: &Point, share: f64) -> Point {
    std::array::from_fn(|a| p[a] + share * (q[a] - p[a]))
}

#[cfg(test)]
mod tests {
    use super::super::brute::{body, distance, point_of, triangle};
    use super::*;
    use feeler_shapes::random::Random;
    use feeler_shapes::soups::arrays_of;
    use feeler_shapes::{ball, box_mesh};

    fn area(points: &[Point]) -> f64 {
        let sum = (1..points.len().max(1) - 1)
            .fold([0.0; 3], |sum, i| add(&sum, &cross(&sub(&points[i], &points[0]), &sub(&points[i + 1], &points[0]))));
        0.5 * length(&sum)
    }

    /// How far a point in the plane of a convex polygon is inside it.
    fn inset(outline: &Outline, p: &Point) -> f64 {
        let count = outline.points.len();
        let room = |i: usize| {
            let (q, r) = (&outline.points[i], &outline.points[(i + 1) % count]);
            let side = sub(r, q);
            // Of a short one rounding decides the direction.
            let inward = unit(&cross(&outline.normal, &side)).filter(|_| length(&side) > 1e-9);
            inward.map_or(f64::INFINITY, |inward| dot(&inward, &sub(p, q)))
        };
        (0..count).map(room).fold(f64::INFINITY, f64::min)
    }

    fn unit_square() -> Outline {
        let points = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        Outline { points, normal: [0.0, 0.0, 1.0], sense: 1 }
    }

    #[test]
    fn what_is_clipped_is_what_is_in_both() {
        let mut r = Random::new(1);
        let mut counts = [0; 2];
        for _ in 0..2000 {
            let (t, mut bounds) = (triangle(&mut r, 0.6), Aabb::EMPTY);
            [r.point(0.0, 1.0), r.point(0.0, 1.0)].iter().for_each(|p| bounds.grow(p));
            let is_in = |p: &Point, margin: f64| {
                (0..3).all(|a| p[a] >= bounds.lower[a] + margin && p[a] <= bounds.upper[a] - margin)
            };
            let clipped = Outline::clipped(&t, -1, Some(&bounds));
            for _ in 0..20 {
                let p = point_of(&mut r, &t);
                let is_kept = clipped.as_ref().is_some_and(|outline| inset(outline, &p) > -1e-12);
                assert!(!is_in(&p, 1e-9) || is_kept, "{t:?} {bounds:?} {p:?}");
                assert!(is_in(&p, -1e-9) || !is_kept, "{t:?} {bounds:?} {p:?}");
                counts[usize::from(is_kept)] += 1;
            }
            if let Some(outline) = clipped {
                assert_eq!((outline.normal, outline.sense), (precise_normal(&t).unwrap(), -1));
                assert!(outline.points.iter().all(|p| is_in(p, -1e-12)));
            }
        }
        assert!(counts.iter().all(|n| *n > 800), "{counts:?}");
    }

    #[test]
    fn a_triangle_in_the_box_or_without_one_is_whole_and_one_that_is_beside_is_nothing() {
        let t = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let clipped = |lower, upper| Outline::clipped(&t, 1, Some(&Aabb { lower, upper }));
        assert_eq!(Outline::clipped(&t, 1, None).unwrap().points, t);
        assert_eq!(clipped([0.0; 3], [1.0; 3]).unwrap().points, t);
        assert!(clipped([0.0, 0.0, 0.1], [1.0; 3]).is_none() && clipped([-1.0; 3], [1.0, 1.0, -0.1]).is_none());
        // It touches the box in a corner, and along a side.
        assert_eq!(clipped([1.0, -1.0, -1.0], [2.0; 3]).unwrap().points, [[1.0, 0.0, 0.0]]);
        assert_eq!(clipped([-1.0; 3], [2.0, 0.0, 2.0]).unwrap().points, [t[0], t[1]]);
    }

    #[test]
    fn cuts_keep_the_area_and_lie_on_their_sides() {
        let mut r = Random::new(2);
        for n in 0..500 {
            let mut parts = vec![Outline::clipped(&triangle(&mut r, 0.5), 1, None).unwrap()];
            for _ in 0..6 {
                let outline = parts.swap_remove(r.below(parts.len() as u64) as usize);
                let plane = match n % 3 {
                    0 => Plane::through(&outline.points[0], &r.point(-1.0, 1.0)).unwrap(),
                    1 => {
                        let side = sub(&outline.points[1], &outline.points[0]);
                        Plane::through(&outline.points[0], &cross(&outline.normal, &side)).unwrap()
                    }
                    _ => Plane::through(&outline.middle(), &r.point(-1.0, 1.0)).unwrap(),
                };
                let (whole, cut): (f64, Vec<Outline>) = (area(&outline.points), outline.cut(&plane).collect());
                let sum: f64 = cut.iter().map(|part| area(&part.points)).sum();
                assert!((sum - whole).abs() <= 1e-12, "{outline:?} {plane:?}");
                for (sense, part) in [1.0, -1.0].iter().zip(&cut).filter(|_| cut.len() == 2) {
                    assert!(part.points.iter().all(|p| sense * plane.height(p) >= -1e-12));
                    assert!(part.points.len() >= 3 && part.points.len() <= outline.points.len() + 1);
                    assert_eq!((part.normal, part.sense), (outline.normal, outline.sense));
                    // It is wound as the whole.
                    let around = |p: &Point| inset(part, p);
                    assert!(around(&part.middle()) >= -1e-12);
                }
                assert!(n % 3 != 2 || cut.len() == 2);
                parts.extend(cut);
            }
        }
    }

    #[test]
    fn a_plane_along_a_side_leaves_one_part() {
        let square = unit_square();
        let below = Plane::at([0.0, 1.0, 0.0], 0.0);
        let parts: Vec<Vec<Point>> = square.cut(&below).map(|part| part.points).collect();
        assert_eq!(parts, std::slice::from_ref(&square.points));
        let diagonal = Plane::through(&[0.0; 3], &[1.0, -1.0, 0.0]).unwrap();
        assert_eq!(square.cut(&diagonal).map(|part| part.points.len()).collect::<Vec<_>>(), [3, 3]);
    }

    /// Where the only triangle of a body parts the unit square.
    fn parting(t: Triangle, least: f64) -> Option<Plane> {
        let body = body(arrays_of([t]));
        let mut square = unit_square();
        square.points.iter_mut().for_each(|p| *p = sub(p, body.origin()));
        let plane = square.parting(&body, least)?;
        assert_eq!(plane.nearest().unwrap_or(0), 0);
        Some(Plane { offset: plane.offset + dot(&plane.normal, body.origin()), ..plane })
    }

    #[test]
    fn a_triangle_that_goes_through_parts_along_its_line() {
        for (x, tilt) in [(0.3, 0.0), (0.5, 0.4), (0.8, -2.0)] {
            // Upright or leaning, through x at the square's height; from all its corners' orders.
            let t = [[x - tilt, -1.0, -1.0], [x - tilt, 3.0, -1.0], [x + tilt, 0.5, 1.0]];
            for turn in 0..3 {
                let plane = parting([t[turn], t[(turn + 1) % 3], t[(turn + 2) % 3]], 1e-12).unwrap();
                assert!(plane.height(&[x, 0.0, 0.0]).abs() < 1e-12 && plane.height(&[x, 1.0, 0.0]).abs() < 1e-12);
                assert!((plane.height(&[x + 0.1, 0.0, 0.0]).abs() - 0.1).abs() < 1e-12);
            }
            // With a side on the square, with a corner on it, and above it.
            let up = |low: f64| t.map(|p| [p[0], p[1], p[2] + 1.0 + low]);
            let along_side = parting(up(0.0), 1e-12).map(|plane| plane.height(&[x - tilt, 0.5, 0.0]).abs() < 1e-12);
            assert_eq!(along_side, (x - tilt < 1.0).then_some(true));
            assert!(parting(t.map(|p| [p[0], p[1], p[2] - 1.0]), 1e-12).is_none());
            assert!(parting(up(1e-6), 1e-9).is_none());
            assert_eq!(parting(up(-1e-6), 1e-9).is_some(), x - tilt < 1.0);
        }
    }

    #[test]
    fn what_only_meets_the_border_parts_nothing() {
        let upright = |x: f64| [[x, -1.0, -1.0], [x, 3.0, -1.0], [x, 0.5, 1.0]];
        for (x, is_parted) in
            [(0.0, false), (1e-13, false), (1e-6, true), (1.0 - 1e-6, true), (1.0, false), (1.1, false)]
        {
            assert_eq!(parting(upright(x), 1e-12).is_some(), is_parted, "{x}");
        }
        // Rounding moves lines: by the more, the less the triangle leans.
        assert!(parting(upright(3e-12), 1e-12).is_none() && parting(upright(3e-11), 1e-12).is_some());
        let leaning = |x: f64, lean: f64| [[x - 1.0, -1.0, -lean], [x - 1.0, 3.0, -lean], [x + 1.0, 0.5, lean]];
        assert!(parting(leaning(1e-6, 1e-6), 1e-12).is_none() && parting(leaning(1e-5, 1e-6), 1e-12).is_some());
        // Its line reaches the square only beyond its ends.
        assert!(parting([[0.5, 1.5, -1.0], [0.5, 3.0, -1.0], [0.5, 2.0, 1.0]], 1e-12).is_none());
    }

    #[test]
    fn a_triangle_in_the_plane_parts_along_a_side() {
        // The unit square and a triangle flush with it: the line x + y = 1.
        let t = [[-1.0, -1.0, 0.0], [2.0, -1.0, 0.0], [-1.0, 2.0, 0.0]];
        for i in 0..3 {
            let plane = parting([t[i], t[(i + 1) % 3], t[(i + 2) % 3]], 1e-12).unwrap();
            assert!(plane.height(&[1.0, 0.0, 0.0]).abs() < 1e-12 && plane.height(&[0.0, 1.0, 0.0]).abs() < 1e-12);
        }
        // Of a large one that leans by rounding all corners are off the plane, and the square is not.
        let plane = parting([[0.5, -1e3, -1e-9], [0.5, 1e3, 1e-9], [-1e3, 0.0, 0.0]], 1e-12).unwrap();
        assert!(plane.height(&[0.5, 0.0, 0.0]).abs() < 1e-12 && plane.height(&[0.5, 1.0, 0.0]).abs() < 1e-12);
        assert!(parting([[-9.0, -9.0, 0.0], [9.0, -9.0, 0.0], [0.0, 20.0, 0.0]], 1e-12).is_none());
        assert!(parting([[2.0, 0.0, 0.0], [3.0, 0.0, 0.0], [2.0, 1.0, 0.0]], 1e-12).is_none());
        assert!(parting([[1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [1.0, 1.0, 0.0]], 1e-12).is_none());
    }

    #[test]
    fn a_short_segment_parts_across_the_length() {
        // From the middle a tenth on; half of it covered; the square's diagonal is its longest line.
        let at = |length: f64| [[0.5, 0.4, 0.0], [0.5, 0.4 + length, 0.0], [0.5, 0.45, 1.0]];
        let (short, long) = (parting(at(0.1), 1e-12).unwrap(), parting(at(0.5), 1e-12).unwrap());
        assert!((short.normal[0].abs() - 0.5f64.sqrt()).abs() < 1e-12 && short.height(&[0.5, 0.5, 0.0]).abs() < 1e-12);
        assert!((long.normal[0].abs() - 1.0).abs() < 1e-12 && long.height(&[0.5, 0.0, 0.0]).abs() < 1e-12);
    }

    #[test]
    fn what_nothing_parts_is_on_one_side() {
        let mut r = Random::new(3);
        for n in 0..60 {
            let mesh = if n % 2 == 0 { box_mesh([0.0; 3], [1.0, 0.8, 0.6], 1 + n % 3) } else { ball(0.6, 3 + n % 4) };
            let body = body(super::super::brute::placed(mesh, &r.motion(1.0)));
            let t = triangle(&mut r, 1.0).map(|p| p.map(|x| x - 0.5));
            let mut open = vec![Outline::clipped(&t, 1, None).unwrap()];
            let (mut parts, mut sum) = (0, 0.0);
            while let Some(outline) = open.pop() {
                if let Some(plane) = outline.parting(&body, 1e-12) {
                    let before = open.len();
                    open.extend(outline.cut(&plane));
                    assert_eq!(open.len(), before + 2, "{n}: {outline:?} {plane:?}");
                    continue;
                }
                (parts, sum) = (parts + 1, sum + area(&outline.points));
                assert!(parts < 2000, "{n}");
                let off: Vec<Point> = (0..20).map(|_| point_of(&mut r, &outline.points)).collect();
                let mut sides = off.iter().filter(|p| distance(&body, p) > 1e-9).map(|p| body.is_inside(p));
                if let Some(first) = sides.next() {
                    assert!(sides.all(|side| side == first), "{n}: {outline:?}");
                }
            }
            assert!((sum - area(&t)).abs() < 1e-9);
        }
    }

    #[test]
    fn the_chord_is_where_a_line_is_in_the_polygon() {
        let square = unit_square();
        assert_eq!(square.chord(&[0.5, -1.0, 0.0], &[0.0, 2.0, 0.0]), [0.5, 1.0]);
        assert_eq!(square.chord(&[2.0, 0.25, 0.0], &[-4.0, 0.0, 0.0]), [0.25, 0.5]);
        assert_eq!(square.chord(&[0.0, 0.0, 0.0], &[1.0, 1.0, 0.0]), [0.0, 1.0]);
        // Beside it: along a side, and aslant.
        assert_eq!(square.chord(&[0.0, 1.5, 0.0], &[1.0, 0.0, 0.0]), [0.0, 0.0]);
        let [from, to] = square.chord(&[1.5, 0.0, 0.0], &[1.0, 1.0, 0.0]);
        assert_eq!(from, to);
    }

    #[test]
    fn lengthwise_is_across_the_middle_of_the_longest_line() {
        let points = vec![[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [5.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
        let plane = Outline { points, ..unit_square() }.lengthwise().unwrap();
        let along = 26f64.sqrt();
        assert!((plane.height(&[5.0, 1.0, 0.0]).abs() - 0.5 * along).abs() < 1e-12);
        assert!((plane.height(&[0.0, 0.0, 0.0]).abs() - 0.5 * along).abs() < 1e-12);
        assert!(Outline { points: vec![[1.0; 3]; 3], ..unit_square() }.lengthwise().is_none());
        assert_eq!(unit_square().radius(&[0.0; 3]), 2f64.sqrt());
    }
}
