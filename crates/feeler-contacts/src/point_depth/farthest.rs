//! The farthest that a point of one surface is from another surface, of those points that are inside the other body, outside it, or of
//! all: by branch and bound over the tree of the one surface and then over convex pieces of its triangles, the largest bound first.
//!
//! A piece is bounded by the distances of its corners to one triangle, since a distance to a convex set is largest at a corner: a long
//! facet beside another is bounded as it is, and needs no small pieces. A piece that the other surface parts is cut there; one that it
//! does not part is inside or outside as any point of it is.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use feeler_core::geometry::vectors::{add, length, sub};
use feeler_core::{Aabb, Point, Triangle};

use super::body::{Below, Body, Closest};
use super::distances::Corner;
use super::outline::{Outline, Plane};
use super::piece::{CornerCache, Piece};
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

/// What is asked of the distance.
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
    /// It is no more, metres; infinite where it was only asked whether it is more than something, and it is.
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

/// What is left of a direction.
enum What {
    /// A node of the tree, its middle, the distance from there, and whether all of it is known to count.
    Node {
        node: u32,
        middle: Point,
        distance: f64,
        is_settled: bool,
    },
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

/// On which side of the other surface something is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Side {
    /// All of it counts.
    Counts,
    /// Nothing of it does.
    Aside,
    /// That is not known, or not the same for all of it.
    Open,
}

impl Side {
    /// The side of something, of which a side may be known, with one more of its points.
    fn with(known: Option<Side>, counts: Option<bool>) -> Side {
        let side = counts.map_or(Side::Open, |counts| if counts { Side::Counts } else { Side::Aside });
        if known.is_none_or(|known| known == side) {
            side
        } else {
            Side::Open
        }
    }
}

/// A surface, the other body, and which points of the surface count.
#[derive(Debug, Clone, Copy)]
pub struct Direction<'a> {
    pub surface: &'a Body,
    pub other: &'a Body,
    pub counted: Counted,
}

/// What rounding may move points by, times this: nearer ones are on the surface.
const ON_SURFACE: f64 = 4.0;

struct Search<'a, const N: usize> {
    directions: [Direction<'a>; N],
    asked: Asked,
    /// What does not count as a length, metres.
    least: f64,
    lower: f64,
    /// The direction, and the points in its order.
    points: Option<(usize, [Point; 2])>,
    /// The largest bound of what was left out.
    left_out: f64,
    heap: BinaryHeap<Entry>,
    corners: [CornerCache; N],
}

/// The farthest of some directions; see the module.
pub fn farthest<const N: usize>(directions: [Direction<'_>; N], asked: Asked) -> Farthest {
    let rounding = directions.iter().fold(0.0f64, |most, d| most.max(d.surface.rounding()).max(d.other.rounding()));
    let mut search = Search {
        directions,
        asked,
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
            search.add_node(i, 0, f64::INFINITY, *counted == Counted::All);
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
            if self.is_decided() || bound <= self.enough() || steps > MOST_PIECES {
                upper = bound;
                break;
            }
            match what {
                What::Node { node, middle, distance, is_settled } => {
                    self.open(direction, node, &middle, distance, is_settled);
                }
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

    /// Up to which bound nothing is of interest any more.
    fn enough(&self) -> f64 {
        match self.asked {
            Asked::Value => self.lower + (DEPTH_ERROR * self.lower).max(LEAST_DEPTH_ERROR),
            Asked::IsMore(than) => than + self.least,
        }
    }

    fn is_decided(&self) -> bool {
        matches!(self.asked, Asked::IsMore(than) if self.lower > than + self.least)
    }

    fn add_node(&mut self, i: usize, node: u32, within: f64, is_settled: bool) {
        let Direction { surface, other, counted } = self.directions[i];
        let (bounds, shift) = (surface.node(node).bounds(), self.shift(i));
        let (lower, upper) = (add(&bounds.lower, &shift), add(&bounds.upper, &shift));
        if counted == Counted::Inside && !other.bounds().is_overlapping(&Aabb { lower, upper }) {
            return;
        }
        let middle: Point = std::array::from_fn(|a| 0.5 * lower[a] + 0.5 * upper[a]);
        let radius = 0.5 * length(&sub(&upper, &lower)) + self.least;
        let within = (within + radius) * (1.0 + 1e-9);
        let closest = other.closest(&middle, within).or_else(|| other.closest(&middle, f64::INFINITY));
        let Some(Closest { distance, .. }) = closest else { return };
        let upper = distance + radius;
        if upper <= self.enough() {
            self.left_out = self.left_out.max(upper);
            return;
        }
        let what = What::Node { node, middle, distance, is_settled };
        self.heap.push(Entry { upper, direction: i, what });
    }

    /// From the frame of a direction's surface to that of the other body.
    fn shift(&self, i: usize) -> Point {
        sub(self.directions[i].surface.origin(), self.directions[i].other.origin())
    }

    fn open(&mut self, i: usize, node: u32, middle: &Point, distance: f64, mut is_settled: bool) {
        let Direction { surface, other, counted } = self.directions[i];
        let radius = 0.5 * length(&surface.node(node).bounds().extent()) + self.least;
        if !is_settled && distance > radius {
            match self.counts(i, middle) {
                Some(false) => return,
                Some(true) => is_settled = true,
                None => {}
            }
        }
        match surface.below(node) {
            Below::Nodes(children) => {
                children.iter().for_each(|child| self.add_node(i, *child, distance + radius, is_settled));
            }
            Below::Triangles(triangles) => {
                let (shift, clip) = (self.shift(i), (counted == Counted::Inside).then_some(other.bounds()));
                for triangle in triangles {
                    let t: Triangle = surface.triangle(triangle).map(|p| add(&p, &shift));
                    if let Some(outline) = Outline::clipped(&t, clip) {
                        self.add_outline(i, &outline, is_settled);
                    }
                }
            }
        }
    }

    /// Adds a polygon: one that the other surface does not part is settled by its corners.
    fn add_outline(&mut self, i: usize, outline: &Outline, mut is_settled: bool) {
        let other = self.directions[i].other;
        let mut parting = None;
        if !is_settled {
            parting = outline.parting(other, self.least);
            if parting.is_none() {
                match self.side_of_outline(i, outline) {
                    Side::Aside => return,
                    side => is_settled = side == Side::Counts,
                }
            }
        }
        if let Some(mut piece) = Piece::new(outline, other, &mut self.corners[i]) {
            (piece.is_settled, piece.parting) = (is_settled, parting);
            self.add_piece(i, piece);
        }
    }

    /// On which side the corners of a polygon are that are not on the other surface.
    fn side_of_outline(&mut self, i: usize, outline: &Outline) -> Side {
        let other = self.directions[i].other;
        let mut side = None;
        for p in &outline.points {
            let Some(kept) = self.corners[i].of(*p, &[], other) else { return Side::Open };
            if kept.corner.distance <= ON_SURFACE * self.least {
                continue;
            }
            let counts = kept.counts.or_else(|| self.counts(i, p));
            if let Some(kept) = self.corners[i].of(*p, &[], other) {
                kept.counts = counts;
            }
            side = Some(Side::with(side, counts));
        }
        side.unwrap_or(Side::Open)
    }

    /// The same of a piece.
    fn side_of_piece(&self, i: usize, piece: &Piece) -> Side {
        let is_off = |corner: &&Corner| corner.distance > ON_SURFACE * self.least;
        let with = |side, corner: &Corner| Some(Side::with(side, self.counts(i, &corner.at)));
        if let Some(side) = piece.corners.iter().filter(is_off).fold(None, with) {
            return side;
        }
        // Where all corners are on the other surface, its middle tells.
        let middle = piece.middle(self.directions[i].other);
        middle.iter().filter(is_off).fold(None, with).unwrap_or(Side::Open)
    }

    /// Whether a point is on the side that counts; `None` where that is open.
    fn counts(&self, i: usize, p: &Point) -> Option<bool> {
        let Direction { other, counted, .. } = self.directions[i];
        match counted {
            Counted::All => Some(true),
            Counted::Inside => other.is_inside(p),
            Counted::Outside => other.is_inside(p).map(|is_inside| !is_inside),
        }
    }

    fn add_piece(&mut self, i: usize, mut piece: Piece) {
        if piece.is_settled {
            let farthest = *piece.farthest();
            if farthest.distance > self.lower {
                // No bound is taken from a point that is not seen to count.
                match self.counts(i, &farthest.at) {
                    Some(true) => self.take(i, &farthest),
                    _ if farthest.distance > ON_SURFACE * self.least => piece.is_settled = false,
                    _ => {}
                }
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
        if !piece.is_settled {
            if let Some(plane) = piece.parting.or_else(|| piece.outline().parting(other, self.least)) {
                return self.divide(i, &piece, &plane);
            }
            match self.side_of_piece(i, &piece) {
                Side::Aside => return,
                Side::Counts => {
                    piece.is_settled = true;
                    return self.add_piece(i, piece);
                }
                Side::Open => {}
            }
            // What is on both sides though nothing parts it is so by rounding, and in no more than a strip.
            let is_point = length(&piece.bounds().extent()) <= self.least;
            return match piece.outline().lengthwise().filter(|_| !is_point) {
                Some(plane) => self.divide(i, &piece, &plane),
                None => self.left_out = self.left_out.max(piece.upper),
            };
        }
        if piece.mix(other) {
            return self.add_piece(i, piece);
        }
        match piece.halving(other, self.enough()) {
            Some(plane) => self.divide(i, &piece, &plane),
            // It is too small to be cut.
            None => self.left_out = self.left_out.max(piece.upper),
        }
    }

    fn divide(&mut self, i: usize, piece: &Piece, plane: &Plane) {
        piece.cut(plane, self.directions[i].other).into_iter().for_each(|part| self.add_piece(i, part));
    }
}
