//! What is told of two parts.

use feeler_core::{Aabb, Point};

use crate::escape::penetration::PenetrationKind;

/// What two parts are to each other. The numbers are those of `feeler.Verdict`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
pub enum Verdict {
    /// They meet, and one is deeper in the other than contact allows.
    Clash = 0,
    /// They meet otherwise, or the gap between them is no more than contact allows.
    Contact = 1,
    /// They are nearer than their clearance.
    Clearance = 2,
    /// One of them, which is closed, holds the other; surfaces may lie on each other.
    Contained = 3,
    /// They have the same triangles.
    Duplicate = 4,
}

/// Two parts that are too near each other.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Clash {
    /// `a` and `b`, the lesser first.
    pub parts: [u32; 2],
    /// What they are to each other.
    pub verdict: Verdict,
    /// How deep they are in each other, metres: the deepest of their contacts; of one that holds the other, the length of
    /// `translation`. 0 where they only touch or are apart.
    pub depth: f64,
    /// How much `depth` and `translation` may be trusted.
    pub kind: PenetrationKind,
    /// Moves `a` out of `b`, metres, world: the shortest way known; `b` moves the other way. Zero where they only touch or are apart.
    pub translation: Point,
    /// How far their surfaces are apart, metres; 0 where they meet.
    pub gap: f64,
    /// On `a` and on `b`, metres: where they are closest, touch, or are deepest in each other.
    pub points: [Point; 2],
    /// How many pairs of triangles meet.
    pub triangles: u32,
    /// The box around where they meet; where they do not, around `points`.
    pub bounds: Aabb,
    /// Whether `a` and `b` have no inside: none of their surfaces is closed.
    pub is_open: [bool; 2],
}
