//! Arithmetic on points and vectors.

use crate::constants::VANISHING;
use crate::geometry::bounds::{Point, Triangle};

use crate::constants::PLAIN;

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

/// `a + t * b`.
#[inline(always)]
pub fn along(a: &Point, t: f64, b: &Point) -> Point {
    [a[0] + t * b[0], a[1] + t * b[1], a[2] + t * b[2]]
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

/// The length, also of vectors whose square vanishes.
#[inline]
pub(crate) fn any_length(a: &Point) -> f64 {
    let squared = dot(a, a);
    if squared > VANISHING {
        return squared.sqrt();
    }
    let size = largest(a).max(f64::MIN_POSITIVE);
    size * length(&a.map(|x| x / size))
}

/// The largest absolute entry.
#[inline(always)]
pub(crate) fn largest(a: &Point) -> f64 {
    a[0].abs().max(a[1].abs()).max(a[2].abs())
}

/// The vector of length 1 in its direction; `None` where it has none (zero, NaN, infinite).
#[inline]
pub fn unit(a: &Point) -> Option<Point> {
    let square = dot(a, a);
    if PLAIN.contains(&square) {
        return Some(scaled(a, 1.0 / square.sqrt()));
    }
    let m = largest(a);
    if !(m > 0.0 && m.is_finite()) {
        return None;
    }
    // Squares of very large and very small numbers are not to be had.
    let b = [a[0] / m, a[1] / m, a[2] / m];
    Some(scaled(&b, 1.0 / length(&b)))
}

/// The unit normal of a triangle by its winding; `None` where it has no area.
#[inline]
pub fn normal(t: &Triangle) -> Option<Point> {
    let (e, f) = (sub(&t[1], &t[0]), sub(&t[2], &t[0]));
    let across = cross(&e, &f);
    let square = dot(&across, &across);
    if PLAIN.contains(&square) && PLAIN.contains(&(dot(&e, &e) * dot(&f, &f))) {
        return Some(scaled(&across, 1.0 / square.sqrt()));
    }
    let (s, r) = (largest(&e), largest(&f));
    // Edges are brought to the same size, so that their product neither vanishes nor overflows.
    unit(&cross(&e.map(|x| x / s), &f.map(|x| x / r)))
}

/// Two unit vectors across a unit vector and each other.
pub fn across(d: &Point) -> [Point; 2] {
    let axis = if d[0].abs() < 0.6 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
    let u = unit(&cross(d, &axis)).unwrap_or(axis);
    [u, cross(d, &u)]
}

/// Square of the distance from `p` to the segment `a` - `b`.
pub fn square_to_segment(p: &Point, a: &Point, b: &Point) -> f64 {
    let (ab, ap) = (sub(b, a), sub(p, a));
    let length = dot(&ab, &ab);
    let s = if length > 0.0 { (dot(&ap, &ab) / length).clamp(0.0, 1.0) } else { 0.0 };
    let d = along(&ap, -s, &ab);
    dot(&d, &d)
}
