//! Axis-aligned bounding boxes, by least and greatest corner (C. Ericson, *Real-Time Collision Detection*, 2005, section 4.2).

use bytemuck::{Pod, Zeroable};

/// A point or vector, metres.
pub type Point = [f64; 3];

/// Three corners, metres; the winding has no effect on collisions.
pub type Triangle = [Point; 3];

/// A convex quadrilateral in the triangle's plane, metres; where two corners coincide, a triangle.
pub(crate) type Piece = [Point; 4];

/// A closed axis-aligned box. Empty when `lower > upper` on any axis.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Aabb {
    /// Smallest coordinates.
    pub lower: Point,
    /// Largest coordinates.
    pub upper: Point,
}

impl Aabb {
    /// The box that contains nothing, and that growing starts from.
    pub const EMPTY: Aabb = Aabb { lower: [f64::INFINITY; 3], upper: [f64::NEG_INFINITY; 3] };

    /// The tightest box around a triangle: minima and maxima only, so no rounding.
    #[inline]
    pub fn of_triangle(t: &Triangle) -> Aabb {
        // Comparisons instead of min/max: the same for finite numbers, and one instruction each.
        let low = |a: f64, b: f64| if a < b { a } else { b };
        let high = |a: f64, b: f64| if a > b { a } else { b };
        let [p, q, r] = t;
        Aabb {
            lower: [low(low(p[0], q[0]), r[0]), low(low(p[1], q[1]), r[1]), low(low(p[2], q[2]), r[2])],
            upper: [high(high(p[0], q[0]), r[0]), high(high(p[1], q[1]), r[1]), high(high(p[2], q[2]), r[2])],
        }
    }

    /// Extends the box to contain a point.
    #[inline]
    pub fn grow(&mut self, p: &Point) {
        for a in 0..3 {
            if p[a] < self.lower[a] {
                self.lower[a] = p[a];
            }
            if p[a] > self.upper[a] {
                self.upper[a] = p[a];
            }
        }
    }

    /// The smallest box that contains both.
    #[inline]
    pub fn union(&self, other: &Aabb) -> Aabb {
        Aabb {
            lower: std::array::from_fn(|a| self.lower[a].min(other.lower[a])),
            upper: std::array::from_fn(|a| self.upper[a].max(other.upper[a])),
        }
    }

    /// True when the closed boxes share a point.
    #[inline]
    pub fn is_overlapping(&self, other: &Aabb) -> bool {
        (0..3).all(|a| self.lower[a] <= other.upper[a] && other.lower[a] <= self.upper[a])
    }

    /// True when the closed box contains the point.
    #[inline]
    pub(crate) fn contains(&self, p: &Point) -> bool {
        (0..3).all(|a| self.lower[a] <= p[a] && p[a] <= self.upper[a])
    }

    /// True when the box contains nothing.
    pub fn is_empty(&self) -> bool {
        (0..3).any(|a| self.lower[a] > self.upper[a])
    }

    /// Side lengths, metres; zero for an empty box.
    pub fn extent(&self) -> Point {
        std::array::from_fn(|a| (self.upper[a] - self.lower[a]).max(0.0))
    }

    /// The longest of them.
    pub fn longest(&self) -> f64 {
        self.extent().into_iter().fold(0.0, f64::max)
    }

    /// The largest absolute coordinate; zero for an empty box.
    pub fn largest_coordinate(&self) -> f64 {
        if self.is_empty() {
            return 0.0;
        }
        (0..3).map(|a| self.lower[a].abs().max(self.upper[a].abs())).fold(0.0, f64::max)
    }
}
