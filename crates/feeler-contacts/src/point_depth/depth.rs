//! The depth by points of two bodies, whether it is more than a limit, and whether two surfaces are the same.

use feeler_core::Point;

use super::body::Body;
use super::farthest::{farthest, Asked, Counted, Direction, Farthest};

/// What a depth is. The numbers are those of `feeler.clashes.verdict.DEPTH_KINDS`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum DepthKind {
    /// Measured by points of both surfaces, within its error.
    Measured = 0,
    /// A part has no closed surface, and so no inside. If the other has one, only points of the open surface count; if not, the depth is
    /// the gap of the deepest contact plane.
    Estimate = 1,
}

/// How deep two bodies are in each other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointDepth {
    /// No more than the depth, metres.
    pub depth: f64,
    /// How much more it can be, metres.
    pub error: f64,
    /// The deepest point of the one surface and the closest of the other, in the world, that of the first body first.
    pub points: Option<[Point; 2]>,
}

fn inside<'a>(surface: &'a Body, other: &'a Body) -> Direction<'a> {
    Direction { surface, other, counted: Counted::Inside }
}

fn depth_of<const N: usize>(directions: [Direction<'_>; N]) -> PointDepth {
    let Farthest { lower, upper, direction, points } = farthest(directions, Asked::Value);
    let points = points.map(|[p, q]| if direction == 0 { [p, q] } else { [q, p] });
    PointDepth { depth: lower, error: upper - lower, points }
}

fn is_more<const N: usize>(directions: [Direction<'_>; N], than: f64) -> bool {
    farthest(directions, Asked::IsMore(than)).upper.is_infinite()
}

/// The farthest that a point of one surface is inside the other body.
pub fn point_depth([a, b]: [&Body; 2]) -> PointDepth {
    depth_of([inside(a, b), inside(b, a)])
}

/// The farthest that a point of the first surface is inside the second body.
pub fn point_depth_from([a, b]: [&Body; 2]) -> PointDepth {
    depth_of([inside(a, b)])
}

/// Whether the depth is more than a limit, metres, but for rounding.
pub fn is_deeper([a, b]: [&Body; 2], than: f64) -> bool {
    is_more([inside(a, b), inside(b, a)], than)
}

/// Whether each surface is nowhere farther than this from the other, metres.
pub fn is_same_surface([a, b]: [&Body; 2], within: f64) -> bool {
    let all = |surface, other| Direction { surface, other, counted: Counted::All };
    !is_more([all(a, b), all(b, a)], within)
}

/// Whether the second body holds the first: no point of the first surface is farther than this outside it, and no point of its own is
/// farther inside the first, metres.
pub fn is_holding([a, b]: [&Body; 2], within: f64) -> bool {
    b.is_closed() && !is_more([Direction { surface: a, other: b, counted: Counted::Outside }, inside(b, a)], within)
}
