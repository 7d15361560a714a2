//! The few operations on vectors that distances and motions need.

use crate::bounds::Point;

/// `a + b`.
#[inline(always)]
pub fn add(a: &Point, b: &Point) -> Point {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// `a - b`.
#[inline(always)]
pub fn sub(a: &Point, b: &Point) -> Point {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// `a` times a number.
#[inline(always)]
pub fn scaled(a: &Point, by: f64) -> Point {
    [a[0] * by, a[1] * by, a[2] * by]
}

/// The scalar product.
#[inline(always)]
pub fn dot(a: &Point, b: &Point) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The vector product.
#[inline(always)]
pub fn cross(a: &Point, b: &Point) -> Point {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// The length; numbers near the limits of float64 overflow or vanish.
#[inline(always)]
pub fn length(a: &Point) -> f64 {
    dot(a, a).sqrt()
}

/// The largest absolute entry.
#[inline(always)]
pub fn largest(a: &Point) -> f64 {
    a[0].abs().max(a[1].abs()).max(a[2].abs())
}

/// The vector of length 1 in its direction; `None` where it has none (zero, NaN, infinite).
#[inline]
pub fn unit(a: &Point) -> Option<Point> {
    let m = largest(a);
    if !(m > 0.0 && m.is_finite()) {
        return None;
    }
    // Squares of very large and very small numbers are not to be had.
    let b = [a[0] / m, a[1] / m, a[2] / m];
    Some(scaled(&b, 1.0 / length(&b)))
}
