//! The distance of two triangles, in exact rational arithmetic, slow and obvious.
//!
//! Two closed triangles that share no point are closest at an edge of each, or at a corner of one and a point inside the other.
//! All of these squared distances are quotients of whole numbers; the least is the answer.

use feeler_core::constants::{DISTANCE_ROUNDOFFS, MEETING_ROUNDOFFS, UNIT_ROUNDOFF};
use feeler_core::{closest_triangle_triangle, Point, Triangle};
use num_bigint::{BigInt, Sign};

use crate::oracle::{cross, difference, dot, has_area, integers, is_zero, kind_of_pair, normal, Vector};

/// A quotient that is not negative; the divisor is positive.
#[derive(Debug, Clone)]
struct Quotient(BigInt, BigInt);

impl Quotient {
    fn min(self, other: Quotient) -> Quotient {
        if &self.0 * &other.1 <= &other.0 * &self.1 {
            self
        } else {
            other
        }
    }
}

/// The distance of two triangles over the largest difference of their coordinates along an axis, rounded down to a multiple of
/// 2^-100, as float64. 0 if and only if they meet. All coordinates must be finite; 0 where all corners are one point.
pub fn relative_distance(p: &Triangle, q: &Triangle) -> f64 {
    let is_meeting =
        if has_area(q) { kind_of_pair(p, q).is_some() } else { has_area(p) && kind_of_pair(q, p).is_some() };
    if is_meeting {
        return 0.0;
    }
    let [a, b] = integers(p, q);
    relative(&squared_distance(&a, &b), &largest_difference(&a, &b))
}

/// The distance of a point from a triangle, over the largest difference as in [`relative_distance`].
fn relative_distance_of_point(point: &Point, p: &Triangle, q: &Triangle) -> f64 {
    // In one lattice with the triangles, so that the unit is the same.
    let [a, at] = integers(p, &[*point; 3]);
    let [c, d] = integers(p, q);
    // Units differ by a power of two: compare through the longest side of p, which both have.
    let squared = squared_distance(&a, &at);
    let (mine, theirs) = (largest_difference(&a, &a), largest_difference(&c, &c));
    if mine.sign() == Sign::NoSign {
        return 0.0;
    }
    let largest = largest_difference(&c, &d) * mine;
    relative(&Quotient(squared.0 * &theirs * &theirs, squared.1), &largest)
}

fn relative(squared: &Quotient, largest: &BigInt) -> f64 {
    if largest.sign() == Sign::NoSign {
        return 0.0;
    }
    let whole: BigInt = (&squared.0 << 200) / (&squared.1 * largest * largest);
    // At most a few units, so below 2^102: rounded once to float64.
    to_f64(&whole.sqrt()) * 2f64.powi(-100)
}

fn to_f64(x: &BigInt) -> f64 {
    let (_, digits) = x.to_u64_digits();
    digits.iter().rev().fold(0.0, |sum, digit| sum * 2f64.powi(64) + *digit as f64)
}

fn largest_difference(p: &[Vector; 3], q: &[Vector; 3]) -> BigInt {
    let mut largest = BigInt::ZERO;
    for a in p.iter().chain(q) {
        for b in p.iter().chain(q) {
            for x in difference(a, b) {
                largest = largest.max(x);
            }
        }
    }
    largest
}

fn squared_distance(p: &[Vector; 3], q: &[Vector; 3]) -> Quotient {
    let r = difference(&p[0], &q[0]);
    let mut least = Quotient(dot(&r, &r), BigInt::from(1));
    for (one, other) in [(p, q), (q, p)] {
        for corner in one {
            for i in 0..3 {
                least = least.min(to_segment(corner, &other[i], &other[(i + 1) % 3]));
            }
            if let Some(height) = to_inside(corner, other) {
                least = least.min(height);
            }
        }
    }
    for i in 0..3 {
        for j in 0..3 {
            if let Some(gap) = between_insides(&p[i], &p[(i + 1) % 3], &q[j], &q[(j + 1) % 3]) {
                least = least.min(gap);
            }
        }
    }
    least
}

fn to_segment(point: &Vector, from: &Vector, to: &Vector) -> Quotient {
    let (u, w) = (difference(to, from), difference(point, from));
    let (length, along) = (dot(&u, &u), dot(&u, &w));
    if length.sign() == Sign::NoSign {
        return Quotient(dot(&w, &w), BigInt::from(1));
    }
    let along = along.max(BigInt::ZERO).min(length.clone());
    let left: Vector = [0, 1, 2].map(|a| &w[a] * &length - &u[a] * &along);
    Quotient(dot(&left, &left), &length * &length)
}

/// From a point to a triangle, where its foot lies inside.
fn to_inside(point: &Vector, t: &[Vector; 3]) -> Option<Quotient> {
    let n = normal(t);
    if is_zero(&n) {
        return None;
    }
    let (u, v, w) = (difference(&t[1], &t[0]), difference(&t[2], &t[0]), difference(point, &t[0]));
    let nn = dot(&n, &n);
    let (s, r) = (dot(&cross(&w, &v), &n), dot(&cross(&u, &w), &n));
    let is_inside = s.sign() != Sign::Minus && r.sign() != Sign::Minus && &s + &r <= nn;
    let height = dot(&w, &n);
    is_inside.then(|| Quotient(&height * &height, nn))
}

/// Between two lines, where they are closest within both segments.
fn between_insides(a: &Vector, a1: &Vector, b: &Vector, b1: &Vector) -> Option<Quotient> {
    let (u, v, r) = (difference(a1, a), difference(b1, b), difference(b, a));
    let (uu, uv, vv) = (dot(&u, &u), dot(&u, &v), dot(&v, &v));
    let determinant = &uu * &vv - &uv * &uv;
    if determinant.sign() == Sign::NoSign {
        return None;
    }
    let (ur, vr) = (dot(&u, &r), dot(&v, &r));
    let (s, t) = (&ur * &vv - &uv * &vr, &uv * &ur - &uu * &vr);
    let is_within = |x: &BigInt| x.sign() != Sign::Minus && x <= &determinant;
    if !is_within(&s) || !is_within(&t) {
        return None;
    }
    let left: Vector = [0, 1, 2].map(|i| &u[i] * &s - &v[i] * &t - &r[i] * &determinant);
    Some(Quotient(dot(&left, &left), &determinant * &determinant))
}

/// The error of the core's distance of a pair, over the largest difference of coordinates: of the distance, and of the two
/// witness points from their triangles. An error: a 0 for a pair that does not meet, or no 0 for one that does.
pub fn errors_of_pair(p: &Triangle, q: &Triangle) -> Result<[f64; 3], String> {
    let closest = closest_triangle_triangle(p, q);
    let expected = relative_distance(p, q);
    let mut largest = 0.0f64;
    for a in 0..3 {
        let all = || p.iter().chain(q).map(move |c| c[a]);
        largest = largest.max(all().fold(f64::MIN, f64::max) - all().fold(f64::MAX, f64::min));
    }
    if largest == 0.0 {
        return if closest.distance == 0.0 { Ok([0.0; 3]) } else { Err(format!("{closest:?} of one point")) };
    }
    // A distance below 2^-100 of the largest difference is not told from 0 here.
    if closest.distance == 0.0 && expected > 0.0 || closest.distance > 1e-13 * largest && expected == 0.0 {
        return Err(format!("{} where {expected:e} of {largest:e} is right", closest.distance));
    }
    Ok([
        (closest.distance / largest - expected).abs(),
        relative_distance_of_point(&closest.on_p, p, q),
        relative_distance_of_point(&closest.on_q, q, p),
    ])
}

/// Checks a pair against the guarantees of distances, either way round: the value, the witness points, and how far these are apart. The
/// second triangle has an area. Returns the largest error over the largest difference of coordinates, or the error.
pub fn check_pair(p: &Triangle, q: &Triangle) -> Result<f64, String> {
    const BOUND: f64 = DISTANCE_ROUNDOFFS * UNIT_ROUNDOFF;
    let errors = errors_of_pair(p, q)?;
    let numbers = || p.iter().chain(q).flatten();
    let largest = numbers().fold(0.0f64, |m, x| m.max(x.abs()));
    let extent = (0..3)
        .map(|a| {
            let all = || p.iter().chain(q).map(move |c| c[a]);
            all().fold(f64::MIN, f64::max) - all().fold(f64::MAX, f64::min)
        })
        .fold(5e-324, f64::max);
    // Witness points are rounded to float64 where they are, and results to multiples of the smallest number.
    let step = 1.5e-323 / extent;
    let rounding = 4.0 * UNIT_ROUNDOFF * largest / extent + step;
    if errors[0] > BOUND + step {
        return Err(format!("distance off by {:e}", errors[0]));
    }
    let one = closest_triangle_triangle(p, q);
    let bound = if one.distance == 0.0 { MEETING_ROUNDOFFS * UNIT_ROUNDOFF } else { BOUND };
    if errors[1].max(errors[2]) > bound + rounding {
        return Err(format!("points off by {errors:?}"));
    }
    let two = closest_triangle_triangle(q, p);
    if (one.distance - two.distance).abs() > 2.0 * BOUND * extent + 1.5e-323 {
        return Err(format!("{one:?}, the other way round {two:?}"));
    }
    let between: Point = std::array::from_fn(|a| one.on_q[a] - one.on_p[a]);
    let size = between.iter().fold(0.0f64, |m, x| m.max(x.abs()));
    if size > 1e-140 && size < 1e140 {
        let length = between.iter().map(|x| x * x).sum::<f64>().sqrt();
        if (length - one.distance).abs() > 2.0 * BOUND * extent + 8.0 * UNIT_ROUNDOFF * largest {
            return Err(format!("points of {one:?} are {length} apart"));
        }
    }
    Ok((errors[0] - step).max(errors[1] - rounding).max(errors[2] - rounding))
}
