//! The result for two parts.

use feeler_core::{Aabb, Point};

use crate::point_depth::depth::DepthKind;

/// The relation of two parts. The numbers are those of `feeler.Verdict`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
pub enum Verdict {
    /// They meet, and their depth is more than contact allows; or both are thin walls that go
    /// through each other, or share more than contact allows of their thickness.
    Clash = 0,
    /// They meet and are no deeper than that, or the gap between them is no more.
    Contact = 1,
    /// They are nearer than their clearance.
    Clearance = 2,
    /// One of them, which is closed, holds the other; surfaces may lie on each other.
    Contained = 3,
    /// They have the same surface, however it is cut into triangles.
    Duplicate = 4,
}

/// Two parts that are too near each other.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Clash {
    /// `a` and `b`, the lesser first.
    pub parts: [u32; 2],
    /// The relation of the two.
    pub verdict: Verdict,
    /// How deep they are in each other, metres: the farthest that a point of one surface is inside the other part. This is a lower bound,
    /// NaN where the search was stopped before it was measured; 0 where they only touch or are apart.
    pub depth: f64,
    /// How much more the depth can be, metres: no more than a thousandth of it, or a nanometre; NaN of two open surfaces.
    pub depth_error: f64,
    /// The kind of the depth.
    pub kind: DepthKind,
    /// Moves `a` out of `b`, metres, world: the shortest translation known, an upper bound; `b` moves the other way.
    /// Zero where they are in contact or apart.
    pub translation: Point,
    /// The distance of their surfaces, metres; 0 if they collide.
    pub gap: f64,
    /// On `a` and on `b`, metres: where they are closest, touch, or are deepest in each other.
    pub points: [Point; 2],
    /// The number of colliding pairs of triangles.
    pub triangles: u32,
    /// The box around the collision; without one, around `points`.
    pub bounds: Aabb,
    /// Whether `a` and `b` have no inside: none of their surfaces is closed.
    pub is_open: [bool; 2],
}

impl Clash {
    /// Of two parts with nothing between them to tell.
    pub(super) fn of(parts: [u32; 2], verdict: Verdict, is_open: [bool; 2]) -> Clash {
        Clash {
            parts,
            verdict,
            depth: 0.0,
            depth_error: 0.0,
            kind: if is_open == [false; 2] { DepthKind::Measured } else { DepthKind::Estimate },
            translation: [0.0; 3],
            gap: 0.0,
            points: [[0.0; 3]; 2],
            triangles: 0,
            bounds: Aabb::EMPTY,
            is_open,
        }
    }

    /// Of two parts that were not measured before the search was stopped.
    pub(super) fn unmeasured(parts: [u32; 2], verdict: Option<Verdict>, is_open: [bool; 2]) -> Clash {
        const UNKNOWN: Point = [f64::NAN; 3];
        Clash {
            depth: f64::NAN,
            depth_error: f64::NAN,
            kind: DepthKind::Estimate,
            translation: UNKNOWN,
            points: [UNKNOWN; 2],
            bounds: Aabb { lower: UNKNOWN, upper: UNKNOWN },
            ..Clash::of(parts, verdict.unwrap_or(Verdict::Clash), is_open)
        }
    }
}
