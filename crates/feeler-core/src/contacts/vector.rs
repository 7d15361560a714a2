//! Arithmetic on points and vectors.

use crate::bounds::{Point, Triangle};

pub(crate) fn add(a: &Point, b: &Point) -> Point {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

pub(crate) fn sub(a: &Point, b: &Point) -> Point {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(crate) fn scaled(a: &Point, s: f64) -> Point {
    [a[0] * s, a[1] * s, a[2] * s]
}

pub(crate) fn dot(a: &Point, b: &Point) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn cross(a: &Point, b: &Point) -> Point {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(crate) fn norm(a: &Point) -> f64 {
    dot(a, a).sqrt()
}

/// The unit vector, or `None` where there is no direction. Scaled first: squares of the smallest and largest numbers are lost.
pub(crate) fn unit(a: &Point) -> Option<Point> {
    let largest = a.iter().fold(0.0f64, |m, x| m.max(x.abs()));
    if !(largest > 0.0 && largest.is_finite()) {
        return None;
    }
    let b = a.map(|x| x / largest);
    Some(scaled(&b, 1.0 / norm(&b)))
}

/// `a + s * b`.
pub(crate) fn along(a: &Point, s: f64, b: &Point) -> Point {
    [a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]]
}

/// The unit normal by the winding.
pub(crate) fn normal(t: &Triangle) -> Option<Point> {
    let (e, f) = (sub(&t[1], &t[0]), sub(&t[2], &t[0]));
    let size = |v: &Point| v.iter().fold(0.0f64, |m, x| m.max(x.abs()));
    let (s, r) = (size(&e), size(&f));
    // Edges are brought to the same size, so that their product neither vanishes nor overflows.
    unit(&cross(&e.map(|x| x / s), &f.map(|x| x / r)))
}

/// Square of the distance from `p` to the segment `a` - `b`.
pub(crate) fn square_to_segment(p: &Point, a: &Point, b: &Point) -> f64 {
    let (ab, ap) = (sub(b, a), sub(p, a));
    let length = dot(&ab, &ab);
    let s = if length > 0.0 { (dot(&ap, &ab) / length).clamp(0.0, 1.0) } else { 0.0 };
    let d = along(&ap, -s, &ab);
    dot(&d, &d)
}
