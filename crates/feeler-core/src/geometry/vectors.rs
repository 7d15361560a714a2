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

/// The same within a few roundings however much longer than wide the triangle is: its plane passes its corners by no more than these
/// do by the rounding of differences. The plane of [`normal`] passes them by as much more as the triangle is longer than wide.
pub fn precise_normal(t: &Triangle) -> Option<Point> {
    let (e, f) = (sub(&t[1], &t[0]), sub(&t[2], &t[0]));
    let across = [
        difference_of_products(e[1], f[2], e[2], f[1]),
        difference_of_products(e[2], f[0], e[0], f[2]),
        difference_of_products(e[0], f[1], e[1], f[0]),
    ];
    let square = dot(&across, &across);
    if PLAIN.contains(&square) && PLAIN.contains(&(dot(&e, &e) * dot(&f, &f))) {
        return Some(scaled(&across, 1.0 / square.sqrt()));
    }
    normal(t)
}

/// `a * b - c * d` with the rounding of both products.
#[inline]
fn difference_of_products(a: f64, b: f64, c: f64, d: f64) -> f64 {
    let ((p, p_off), (q, q_off)) = (product(a, b), product(c, d));
    (p - q) + (p_off - q_off)
}

/// A product and its rounding, exactly (Dekker 1971).
#[inline]
fn product(a: f64, b: f64) -> (f64, f64) {
    let halves = |x: f64| {
        let high = f64::from((1u32 << 27) + 1) * x;
        let high = high - (high - x);
        (high, x - high)
    };
    let ((a_high, a_low), (b_high, b_low)) = (halves(a), halves(b));
    let p = a * b;
    (p, a_low * b_low - (p - a_high * b_high - a_low * b_high - a_high * b_low))
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

#[cfg(test)]
mod tests {
    use super::*;
    use feeler_shapes::random::Random;

    #[test]
    fn the_precise_plane_of_a_needle_passes_its_corners() {
        let mut r = Random::new(1);
        let mut off = [0.0f64; 2];
        for n in 0..2000 {
            let (a, b) = (r.point(-1.0, 1.0), r.point(-1.0, 1.0));
            // The third corner is near the line of the others.
            let (share, width) = (r.real(0.0, 1.0), 10f64.powi(-(n % 12)));
            let c = std::array::from_fn(|i| a[i] + share * (b[i] - a[i]) + width * r.real(-1.0, 1.0));
            let t = [a, b, c];
            for (off, normal) in off.iter_mut().zip([precise_normal(&t).unwrap(), normal(&t).unwrap()]) {
                assert!((length(&normal) - 1.0).abs() < 1e-15);
                *off = [sub(&b, &a), sub(&c, &a)].iter().map(|e| dot(&normal, e).abs()).fold(*off, f64::max);
            }
            let lean = dot(&precise_normal(&t).unwrap(), &normal(&t).unwrap());
            assert!(lean > 0.99 || width < 1e-9, "{t:?} {lean}");
        }
        assert!(off[0] < 1e-15 && off[1] > 1e-7, "{off:?}");
    }

    #[test]
    fn precise_normals_are_normals_at_any_size() {
        for size in [1e-200, 1e-60, 1.0, 1e60, 1e200] {
            let t = [[0.0; 3], [size, 0.0, 0.0], [0.0, 2.0 * size, 0.0]];
            assert_eq!(precise_normal(&t), Some([0.0, 0.0, 1.0]), "{size}");
        }
        assert_eq!(precise_normal(&[[0.0; 3], [1.0; 3], [0.5; 3]]), None);
    }
}
