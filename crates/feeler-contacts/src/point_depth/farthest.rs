//! The largest distance of a point of one surface from another surface, among the points inside the other body, outside
//! it, or all: by branch and bound over the tree of the one surface and then over convex pieces of its triangles, the
//! largest bound first.
//!
//! A piece is bounded by the distances of its corners to one triangle, since a distance to a convex set is largest at a
//! corner: a long facet beside another is bounded as it is, and needs no small pieces. A piece that the other surface
//! cuts is split there; any other piece lies on one side, and any of its points decides which.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use feeler_core::geometry::vectors::{add, along, dot, length, scaled, sub, unit};
use feeler_core::{Aabb, GoOn, Point, Triangle};

use super::body::{distance_to, Body, Closest};
use super::corners::{CornerCache, Side};
use super::distances::Corner;
use super::off_surface::Hull;
use super::outline::{Outline, Plane};
use super::piece::Piece;
use super::tree::Inside;
use crate::constants::{DEPTH_ERROR, LEAST_DEPTH_ERROR, MOST_PIECES};

/// Which points of the surface count.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Counted {
    /// Those inside the other body.
    Inside,
    /// Those outside it.
    Outside,
    /// All.
    All,
}

/// The question about the distance.
#[derive(Debug, Clone, Copy)]
pub enum Asked {
    /// The distance itself, within the error of depths.
    Value,
    /// Whether it is more than this, metres.
    IsMore(f64),
}

/// Bounds of a distance, and where it is attained.
#[derive(Debug, Clone, Copy)]
pub struct Farthest {
    /// It is no less, metres.
    pub lower: f64,
    /// It is no more, metres; infinite if the question was only whether it exceeds a limit, and it does.
    pub upper: f64,
    /// In which direction that is.
    pub direction: usize,
    /// The point of the surface, and the closest of the other, in the world; none where it is 0.
    pub points: Option<[Point; 2]>,
}

struct Entry {
    upper: f64,
    direction: usize,
    what: What,
}

/// A region still to be searched along a direction.
enum What {
    /// A node of the tree. bounds: its box in the frame of the other body. closest: to the middle of the box. is_settled: all of it
    /// counts.
    Node { node: u32, bounds: Aabb, closest: Closest, is_settled: bool },
    /// A polygon of which it is not known whether it counts, and a triangle of the other body near it.
    Polygon(Box<Outline>, u32),
    /// One that counts.
    Piece(Box<Piece>),
}

impl Ord for Entry {
    fn cmp(&self, other: &Entry) -> Ordering {
        self.upper.total_cmp(&other.upper)
    }
}

impl PartialOrd for Entry {
    fn partial_cmp(&self, other: &Entry) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Entry {
    fn eq(&self, other: &Entry) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Entry {}

/// A surface, the other body, and which points of the surface count.
#[derive(Debug, Clone, Copy)]
pub struct Direction<'a> {
    pub surface: &'a Body,
    pub other: &'a Body,
    pub counted: Counted,
}

/// Points nearer than this many roundings are on the surface. Three roundings are less than the smallest `contact`.
const ON_SURFACE: f64 = 3.0;

/// A corner farther than this many roundings shows the side of its whole polygon, apart from strips due to rounding.
const OFF_SURFACE: f64 = 16.0;

struct Search<'a, const N: usize> {
    directions: [Direction<'a>; N],
    asked: Asked,
    go_on: GoOn<'a>,
    /// Lengths up to this count as 0, metres.
    least: f64,
    lower: f64,
    /// The direction, and the points in its order.
    points: Option<(usize, [Point; 2])>,
    /// The largest bound of the boxes left out.
    left_out: f64,
    heap: BinaryHeap<Entry>,
    corners: [CornerCache; N],
}

/// Steps between two questions whether to go on: less than a millisecond.
const STEPS_TO_QUESTION: usize = 128;

/// The farthest of some directions; see the module. Where it is stopped, the bounds are true, and wider.
pub fn farthest<'a, const N: usize>(directions: [Direction<'a>; N], asked: Asked, go_on: GoOn<'a>) -> Farthest {
    let rounding = directions.iter().fold(0.0f64, |most, d| most.max(d.surface.rounding()).max(d.other.rounding()));
    let mut search = Search {
        directions,
        asked,
        go_on,
        least: rounding,
        lower: 0.0,
        points: None,
        left_out: 0.0,
        heap: BinaryHeap::new(),
        corners: std::array::from_fn(|_| CornerCache::default()),
    };
    for (i, Direction { surface, other, counted }) in directions.iter().enumerate() {
        let is_nothing = surface.len() == 0 || other.len() == 0;
        if !(is_nothing || *counted == Counted::Inside && !other.is_closed()) {
            search.add_node(i, 0, surface.bounds(), None, *counted == Counted::All);
        }
    }
    search.run()
}

impl<const N: usize> Search<'_, N> {
    fn run(&mut self) -> Farthest {
        let mut upper = 0.0f64;
        let mut steps = 0;
        while let Some(Entry { upper: bound, direction, what }) = self.heap.pop() {
            steps += 1;
            let is_stopped = steps % STEPS_TO_QUESTION == 0 && !self.go_on.goes_on();
            if self.is_decided() || bound <= self.enough() || steps > MOST_PIECES || is_stopped {
                upper = bound;
                break;
            }
            match what {
                What::Node { node, bounds, closest, is_settled } => {
                    self.open(direction, node, &bounds, &closest, bound, is_settled);
                }
                What::Polygon(outline, near) => self.settle(direction, &outline, near, bound),
                What::Piece(piece) => self.refine(direction, *piece),
            }
        }
        if self.is_decided() {
            upper = f64::INFINITY;
        }
        // Points of pieces and distances are computed: by that much the truth may be aside.
        let upper = upper.max(self.left_out).max(self.lower);
        Farthest {
            lower: (self.lower - self.least).max(0.0),
            upper: if upper > 0.0 { upper + self.least } else { 0.0 },
            direction: self.points.map_or(0, |(direction, _)| direction),
            points: self.points.map(|(_, points)| points),
        }
    }

    /// Pieces with a smaller bound are left out. Points on the surface are among them: rounding decides whether they count.
    fn enough(&self) -> f64 {
        let enough = match self.asked {
            // With the rounding that is added to both bounds in the end.
            Asked::Value => self.lower + (DEPTH_ERROR * self.lower).max(LEAST_DEPTH_ERROR) - 2.0 * self.least,
            Asked::IsMore(than) => than + self.least,
        };
        enough.max(ON_SURFACE * self.least)
    }

    fn is_decided(&self) -> bool {
        matches!(self.asked, Asked::IsMore(than) if self.lower > than + self.least)
    }

    /// Adds a node of the tree and its box, in the frame of its body; a triangle may be near it.
    fn add_node(&mut self, i: usize, node: u32, bounds: &Aabb, near: Option<u32>, is_settled: bool) {
        let Direction { other, counted, .. } = self.directions[i];
        let shift = self.shift(i);
        let bounds = Aabb { lower: add(&bounds.lower, &shift), upper: add(&bounds.upper, &shift) };
        if counted == Counted::Inside && !other.bounds().is_overlapping(&bounds) {
            return;
        }
        let Some(closest) = other.closest_from(&middle_of(&bounds), near.as_slice()) else { return };
        let upper = closest.distance + self.radius_of(&bounds);
        if upper <= self.enough() {
            self.left_out = self.left_out.max(upper);
            return;
        }
        let what = What::Node { node, bounds, closest, is_settled };
        self.heap.push(Entry { upper, direction: i, what });
    }

    /// How far no point of a box is from its middle.
    fn radius_of(&self, bounds: &Aabb) -> f64 {
        0.5 * length(&bounds.extent()) + self.least
    }

    /// From the frame of a direction's surface to that of the other body.
    fn shift(&self, i: usize) -> Point {
        sub(self.directions[i].surface.origin(), self.directions[i].other.origin())
    }

    /// Whether a hull, if moved along a unit normal as far as is of no interest, is wholly on the side that does not count: no point of
    /// it that counts is farther from the other surface than that, however many triangles that has there. Not tried where the hull
    /// would not even get beyond a plane through a point of the other surface.
    fn is_near(&mut self, i: usize, hull: &Hull<'_>, n: &Point, on: &Point) -> bool {
        let Direction { other, counted, .. } = self.directions[i];
        let heights = hull.points.iter().map(|p| dot(n, &sub(on, p)));
        let farthest = heights.fold(0.0, f64::max) + 4.0 * self.least;
        let enough = self.enough();
        if counted == Counted::All || farthest > enough {
            return false;
        }
        // No farther than is known, where that may do, so that the bound is as good.
        let by = if farthest < self.lower && 2.0 * self.lower - farthest > enough { self.lower } else { enough };
        let moved: Vec<Point> = hull.points.iter().map(|p| along(p, by, n)).collect();
        let is_off = Hull { points: &moved, ..*hull }.is_off(other, 2.0 * self.least)
            && self.counts(i, &moved[0]) == Some(false);
        if is_off {
            self.left_out = self.left_out.max(by);
        }
        is_off
    }

    /// Looks into a node of which no point that counts is farther than `upper`.
    fn open(&mut self, i: usize, node: u32, bounds: &Aabb, closest: &Closest, upper: f64, mut is_settled: bool) {
        let Direction { surface, other, counted } = self.directions[i];
        let (middle, ends) = (middle_of(bounds), [bounds.lower, bounds.upper]);
        let corners: [Point; 8] = std::array::from_fn(|n| std::array::from_fn(|a| ends[n >> a & 1][a]));
        let n = unit(&sub(&closest.point, &middle));
        if n.is_some_and(|n| self.is_near(i, &Hull { points: &corners, normal: [0.0; 3] }, &n, &closest.point)) {
            return;
        }
        let is_free = |bounds: &Aabb| other.find_overlapping(bounds, |_| Some(())).is_none();
        if !is_settled && (closest.distance > self.radius_of(bounds) || is_free(bounds)) {
            match self.counts(i, &middle) {
                Some(false) => return,
                Some(true) => is_settled = true,
                None => {}
            }
        }
        let (shift, clip) = (self.shift(i), (counted == Counted::Inside).then_some(other.bounds()));
        for (inside, bounds) in surface.tree().boxes(node) {
            match inside {
                Inside::Node(node) => self.add_node(i, node, &bounds, Some(closest.triangle), is_settled),
                Inside::Triangle(triangle) => {
                    let t: Triangle = surface.triangle(triangle).map(|p| add(&p, &shift));
                    if let Some(outline) = Outline::clipped(&t, surface.sense(triangle), clip) {
                        if is_settled {
                            self.add_piece(i, &outline);
                        } else {
                            self.settle(i, &outline, closest.triangle, upper);
                        }
                    }
                }
            }
        }
    }

    /// Settles a polygon of which no point is known to be farther than `upper`: it is cut where the other surface parts it, until the
    /// parts count or do not.
    fn settle(&mut self, i: usize, outline: &Outline, near: u32, mut upper: f64) {
        let other = self.directions[i].other;
        upper = upper.min(farthest_from(other.triangle(near), outline));
        if upper <= self.enough() {
            self.left_out = self.left_out.max(upper);
            return;
        }
        let Some(plane) = outline.parting(other, self.least) else {
            match self.side_of(i, outline) {
                Side::Aside => {}
                Side::Counts => self.add_piece(i, outline),
                Side::Open => self.leave_strip(i, outline, near, upper),
            }
            return;
        };
        let near = plane.nearest().unwrap_or(near);
        upper = upper.min(farthest_from(other.triangle(near), outline));
        if upper <= self.enough() {
            self.left_out = self.left_out.max(upper);
        } else if !self.is_near_by(i, outline, near) {
            self.divide(i, outline, &plane, near, upper);
        }
    }

    /// Whether a polygon is near, as seen by moving it into its own body, or along the normal of a triangle of the other that parts it.
    fn is_near_by(&mut self, i: usize, outline: &Outline, near: u32) -> bool {
        let Direction { other, counted, .. } = self.directions[i];
        let hull = Hull { points: &outline.points, normal: outline.normal };
        // The other way for points outside.
        let sense = if counted == Counted::Outside { -1.0 } else { 1.0 };
        let inward = scaled(&outline.normal, -sense * f64::from(outline.sense));
        let by = self.enough();
        let moved: Vec<Point> = outline.points.iter().map(|p| along(p, by, &inward)).collect();
        let is_off =
            outline.sense != 0 && (Hull { points: &moved, ..hull }).is_off_triangle(other, near, 2.0 * self.least);
        if is_off && self.is_near(i, &hull, &inward, &outline.points[0]) {
            return true;
        }
        other.outward(near).is_some_and(|n| self.is_near(i, &hull, &scaled(&n, sense), &other.triangle(near)[0]))
    }

    /// Cuts a polygon that is on both sides although nothing parts it. Only rounding does that, and only in a strip.
    fn leave_strip(&mut self, i: usize, outline: &Outline, near: u32, upper: f64) {
        let piece = Piece::new(outline, self.directions[i].other, &mut self.corners[i]);
        let upper = piece.map_or(upper, |piece| piece.upper.min(upper));
        let is_point = outline.radius(&outline.points[0]) <= self.least;
        match outline.lengthwise().filter(|_| !is_point && upper > self.enough()) {
            Some(plane) => self.divide(i, outline, &plane, near, upper),
            None => self.left_out = self.left_out.max(upper),
        }
    }

    fn divide(&mut self, i: usize, outline: &Outline, plane: &Plane, near: u32, upper: f64) {
        for part in outline.cut(plane) {
            self.heap.push(Entry { upper, direction: i, what: What::Polygon(Box::new(part), near) });
        }
    }

    /// On which side a polygon is that nothing parts: as a corner says that is well off the other surface; if none is, as all that are
    /// not on it say, or else its middle.
    fn side_of(&mut self, i: usize, outline: &Outline) -> Side {
        let Direction { other, counted, .. } = self.directions[i];
        if let Some(known) = outline.points.iter().find_map(|p| self.corners[i].known_side(p)) {
            return known;
        }
        let least = self.least;
        let side = |p: &Point, off: f64| side_off(other, counted, p, off * least);
        let of_corner = |p: &Point| self.corners[i].side(*p, || side(p, OFF_SURFACE));
        if let Some(clear) = outline.points.iter().find_map(of_corner) {
            return clear;
        }
        let mut sides = outline.points.iter().filter_map(|p| side(p, ON_SURFACE));
        match sides.next() {
            Some(first) if sides.all(|other| other == first) => first,
            Some(_) => Side::Open,
            None => side(&outline.middle(), ON_SURFACE).unwrap_or(Side::Open),
        }
    }

    /// Whether a point is on the side that counts; `None` where that is open.
    fn counts(&self, i: usize, p: &Point) -> Option<bool> {
        counts(self.directions[i].other, self.directions[i].counted, p)
    }

    /// Adds a polygon that counts.
    fn add_piece(&mut self, i: usize, outline: &Outline) {
        if let Some(piece) = Piece::new(outline, self.directions[i].other, &mut self.corners[i]) {
            self.push_piece(i, piece);
        }
    }

    fn push_piece(&mut self, i: usize, piece: Piece) {
        let farthest = *piece.farthest();
        if farthest.distance > self.lower {
            // No bound is taken from a point that is not seen to count.
            match self.counts(i, &farthest.at) {
                Some(true) => self.take(i, &farthest),
                _ if farthest.distance > ON_SURFACE * self.least => {
                    return self.leave_strip(i, &piece.outline(), farthest.nearest, piece.upper);
                }
                _ => {}
            }
        }
        if piece.upper <= self.enough() {
            self.left_out = self.left_out.max(piece.upper);
            return;
        }
        self.heap.push(Entry { upper: piece.upper, direction: i, what: What::Piece(Box::new(piece)) });
    }

    /// Takes a point that counts.
    fn take(&mut self, i: usize, corner: &Corner) {
        if corner.distance > self.lower {
            self.lower = corner.distance;
            let origin = self.directions[i].other.origin();
            self.points = Some((i, [corner.at, corner.point].map(|p| add(&p, origin))));
        }
    }

    fn refine(&mut self, i: usize, mut piece: Piece) {
        let other = self.directions[i].other;
        let (outline, farthest) = (piece.outline(), piece.farthest());
        let (n, hull) =
            (unit(&sub(&farthest.point, &farthest.at)), Hull { points: &outline.points, normal: piece.normal });
        if n.is_some_and(|n| self.is_near(i, &hull, &n, &farthest.point)) {
            return;
        }
        if piece.mix(other) {
            return self.push_piece(i, piece);
        }
        match piece.halving(other, self.enough()) {
            Some(plane) => piece.cut(&plane, other).into_iter().for_each(|part| self.push_piece(i, part)),
            // It is too small to be cut.
            None => self.left_out = self.left_out.max(piece.upper),
        }
    }
}

/// The largest distance of a polygon from a triangle. It is at a corner, since the distance to a convex set is convex.
fn farthest_from(triangle: &Triangle, outline: &Outline) -> f64 {
    outline.points.iter().map(|p| distance_to(p, triangle)).fold(0.0, f64::max)
}

/// On which side a point is; `None` where it is within a distance of the other surface.
fn side_off(other: &Body, counted: Counted, p: &Point, within: f64) -> Option<Side> {
    let is_on = other.closest(p, within).is_some();
    (!is_on).then(|| match counts(other, counted, p) {
        Some(true) => Side::Counts,
        Some(false) => Side::Aside,
        None => Side::Open,
    })
}

/// Whether a point is among those that count; `None` where that is open.
fn counts(other: &Body, counted: Counted, p: &Point) -> Option<bool> {
    match counted {
        Counted::All => Some(true),
        Counted::Inside => other.is_inside(p),
        Counted::Outside => other.is_inside(p).map(|is_inside| !is_inside),
    }
}

fn middle_of(bounds: &Aabb) -> Point {
    std::array::from_fn(|a| 0.5 * bounds.lower[a] + 0.5 * bounds.upper[a])
}
