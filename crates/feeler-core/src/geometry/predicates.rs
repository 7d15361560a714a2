//! Exact signs of orientation determinants.
//!
//! Three stages, each only if the previous one cannot decide: float64 with an error bound, adaptive expansions
//! (J. R. Shewchuk, *Adaptive precision floating-point arithmetic and fast robust geometric predicates*, 1997; the
//! `robust` crate), and big integers where expansions could under- or overflow.
//!
//! All coordinates must be finite and at most `LARGEST_COORDINATE` in size.

use num_bigint::{BigInt, Sign as BigSign};

use crate::constants::{ORIENT2D_BOUND, ORIENT3D_BOUND, SAFE_LARGEST, SAFE_PERMANENT, SAFE_SMALLEST};
use crate::geometry::bounds::Point;

/// A sign: -1, 0 or 1.
pub(crate) type Sign = i8;

/// Orientation signs, with a count of those that float64 arithmetic could not decide.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Signs {
    /// Signs that took exact arithmetic.
    pub exact: u64,
}

impl Signs {
    /// See [`orient3d`].
    #[inline]
    pub(crate) fn orient3d(&mut self, a: &Point, b: &Point, c: &Point, d: &Point) -> Sign {
        orient3d_filter(a, b, c, d).unwrap_or_else(|| {
            self.exact += 1;
            orient3d_exact(a, b, c, d)
        })
    }

    /// See [`orient2d`].
    #[inline]
    pub(crate) fn orient2d(&mut self, a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> Sign {
        orient2d_filter(a, b, c).unwrap_or_else(|| {
            self.exact += 1;
            orient2d_exact(a, b, c)
        })
    }
}

/// Which side of the plane through `a`, `b`, `c` the point `d` lies on: the sign of `det[a-d; b-d; c-d]`.
///
/// Positive when `a`, `b`, `c` turn clockwise seen from `d`.
#[inline]
pub fn orient3d(a: &Point, b: &Point, c: &Point, d: &Point) -> Sign {
    Signs::default().orient3d(a, b, c, d)
}

/// The sign where float64 arithmetic can prove it, else `None`.
#[inline]
pub(crate) fn orient3d_filter(a: &Point, b: &Point, c: &Point, d: &Point) -> Option<Sign> {
    let [adx, ady, adz] = [a[0] - d[0], a[1] - d[1], a[2] - d[2]];
    let [bdx, bdy, bdz] = [b[0] - d[0], b[1] - d[1], b[2] - d[2]];
    let [cdx, cdy, cdz] = [c[0] - d[0], c[1] - d[1], c[2] - d[2]];
    let (bdxcdy, cdxbdy) = (bdx * cdy, cdx * bdy);
    let (cdxady, adxcdy) = (cdx * ady, adx * cdy);
    let (adxbdy, bdxady) = (adx * bdy, bdx * ady);
    let det = adz * (bdxcdy - cdxbdy) + bdz * (cdxady - adxcdy) + cdz * (adxbdy - bdxady);
    let permanent = (bdxcdy.abs() + cdxbdy.abs()) * adz.abs()
        + (cdxady.abs() + adxcdy.abs()) * bdz.abs()
        + (adxbdy.abs() + bdxady.abs()) * cdz.abs();
    certain_sign(det, ORIENT3D_BOUND * permanent, permanent)
}

/// Which side of the directed line `a -> b` the point `c` lies on, in the plane: positive on the left.
#[inline]
pub(crate) fn orient2d(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> Sign {
    Signs::default().orient2d(a, b, c)
}

/// The sign where float64 arithmetic can prove it, else `None`.
#[inline]
pub(crate) fn orient2d_filter(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> Option<Sign> {
    let left = (a[0] - c[0]) * (b[1] - c[1]);
    let right = (a[1] - c[1]) * (b[0] - c[0]);
    let permanent = left.abs() + right.abs();
    certain_sign(left - right, ORIENT2D_BOUND * permanent, permanent)
}

/// True when the three corners lie on one line: the triangle has exactly zero area.
pub fn is_collinear(a: &Point, b: &Point, c: &Point) -> bool {
    [(0, 1), (1, 2), (2, 0)].iter().all(|&(u, v)| orient2d([a[u], a[v]], [b[u], b[v]], [c[u], c[v]]) == 0)
}

/// The sign of a number that may be off by `bound`, where it is certain.
#[inline]
pub(crate) fn certain_sign(det: f64, bound: f64, permanent: f64) -> Option<Sign> {
    if permanent > SAFE_PERMANENT {
        if det > bound {
            return Some(1);
        }
        if det < -bound {
            return Some(-1);
        }
    }
    None
}

#[cold]
fn orient3d_exact(a: &Point, b: &Point, c: &Point, d: &Point) -> Sign {
    // Surfaces that coincide, or lie flush in a plane across an axis, mostly ask for these: a row or a column of zeros.
    let is_flat = |k: usize| a[k] == d[k] && b[k] == d[k] && c[k] == d[k];
    if d == a || d == b || d == c || is_flat(0) || is_flat(1) || is_flat(2) {
        return 0;
    }
    if [a, b, c, d].iter().all(|p| is_safe(*p)) {
        let p = |p: &Point| robust::Coord3D { x: p[0], y: p[1], z: p[2] };
        return sign_of(robust::orient3d(p(a), p(b), p(c), p(d)));
    }
    orient3d_big(a, b, c, d)
}

#[cold]
fn orient2d_exact(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> Sign {
    if [a, b, c].iter().all(|p| is_safe(p)) {
        let p = |p: [f64; 2]| robust::Coord { x: p[0], y: p[1] };
        return sign_of(robust::orient2d(p(a), p(b), p(c)));
    }
    let [a, b, c] = [a, b, c].map(|p| p.map(big));
    big_sign(&((&a[0] - &c[0]) * (&b[1] - &c[1]) - (&a[1] - &c[1]) * (&b[0] - &c[0])))
}

/// `orient3d` in big integers: always right, and slow.
fn orient3d_big(a: &Point, b: &Point, c: &Point, d: &Point) -> Sign {
    let d = d.map(big);
    let [a, b, c] = [a, b, c].map(|p| {
        let p = p.map(big);
        [&p[0] - &d[0], &p[1] - &d[1], &p[2] - &d[2]]
    });
    let minor = |u: &[BigInt; 3], v: &[BigInt; 3]| &u[0] * &v[1] - &v[0] * &u[1];
    big_sign(&(&a[2] * minor(&b, &c) + &b[2] * minor(&c, &a) + &c[2] * minor(&a, &b)))
}

/// Numbers as whole ones, in units of a power of two that they have in common: no larger than need be.
pub(crate) fn whole_numbers<const N: usize>(numbers: [f64; N]) -> [BigInt; N] {
    let parts = numbers.map(|x| {
        let bits = x.to_bits();
        let exponent = (bits >> 52 & 0x7ff) as u32;
        let fraction = (bits & ((1 << 52) - 1)) as i64;
        let (mantissa, shift) = if exponent == 0 { (fraction, 0) } else { (fraction | 1 << 52, exponent - 1) };
        let zeros = if mantissa == 0 { 0 } else { mantissa.trailing_zeros() };
        (if x.is_sign_negative() { -(mantissa >> zeros) } else { mantissa >> zeros }, shift + zeros)
    });
    let unit = parts.iter().filter(|(mantissa, _)| *mantissa != 0).map(|(_, shift)| *shift).min().unwrap_or(0);
    parts.map(|(mantissa, shift)| BigInt::from(mantissa) << shift.saturating_sub(unit))
}

/// The number in units of 2^-1074, the smallest float64: an integer for every finite float64.
fn big(x: f64) -> BigInt {
    let bits = x.to_bits();
    let exponent = (bits >> 52 & 0x7ff) as u32;
    let fraction = bits & ((1 << 52) - 1);
    let (mantissa, shift) = if exponent == 0 { (fraction, 0) } else { (fraction | 1 << 52, exponent - 1) };
    let magnitude = BigInt::from(mantissa) << shift;
    if x.is_sign_negative() {
        -magnitude
    } else {
        magnitude
    }
}

pub(crate) fn big_sign(x: &BigInt) -> Sign {
    match x.sign() {
        BigSign::Minus => -1,
        BigSign::NoSign => 0,
        BigSign::Plus => 1,
    }
}

fn is_safe(coordinates: &[f64]) -> bool {
    coordinates.iter().all(|x| *x == 0.0 || (SAFE_SMALLEST..SAFE_LARGEST).contains(&x.abs()))
}

fn sign_of(x: f64) -> Sign {
    if x > 0.0 {
        1
    } else if x < 0.0 {
        -1
    } else {
        0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Coordinates that make trouble: small integers, their neighbours, and all scales from denormal to huge.
    fn coordinate() -> impl Strategy<Value = f64> {
        prop_oneof![
            (-3i32..4).prop_map(f64::from),
            (-3i32..4).prop_map(|i| f64::from(i) * 0.1),
            (-3i32..4).prop_map(|i| f64::from_bits((f64::from(i) + 0.5).to_bits() + 1)),
            (-3i32..4).prop_map(|i| f64::from(i) * 1e90),
            (-3i32..4).prop_map(|i| f64::from(i) * 5e-324),
            (-3i32..4).prop_map(|i| f64::from(i) * 1e-120),
        ]
    }

    fn point() -> impl Strategy<Value = Point> {
        [coordinate(), coordinate(), coordinate()]
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(20_000))]
        #[test]
        fn orient3d_agrees_with_big_integers(a in point(), b in point(), c in point(), d in point()) {
            prop_assert_eq!(orient3d(&a, &b, &c, &d), orient3d_big(&a, &b, &c, &d));
        }

        #[test]
        fn orient2d_agrees_with_orient3d(a in point(), b in point(), c in point()) {
            let lift = |p: Point| [p[0], p[1], 0.0];
            let apex = [0.0, 0.0, 1.0];
            let flat = orient2d([a[0], a[1]], [b[0], b[1]], [c[0], c[1]]);
            prop_assert_eq!(flat, -orient3d_big(&lift(a), &lift(b), &lift(c), &apex));
        }
    }

    #[test]
    fn whole_numbers_have_one_unit() {
        assert_eq!(whole_numbers([0.75, -2.0, 0.0, -0.0]), [3, -8, 0, 0].map(BigInt::from));
        assert_eq!(whole_numbers([0.0]), [BigInt::ZERO]);
        let numbers = [5e-324, 1e100, -3e-120, f64::MIN_POSITIVE, 0.1];
        let (small, same) = (whole_numbers(numbers), numbers.map(big));
        assert_eq!(small, same, "the smallest is the unit");
    }

    #[test]
    fn signs_follow_the_documented_orientation() {
        let [a, b, c] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        assert_eq!(orient3d(&a, &b, &c, &[0.0, 0.0, -1.0]), 1);
        assert_eq!(orient3d(&a, &b, &c, &[0.0, 0.0, 1.0]), -1);
        assert_eq!(orient2d([0.0, 0.0], [1.0, 0.0], [0.0, 1.0]), 1);
    }

    #[test]
    fn collinear_only_when_exactly_so() {
        assert!(is_collinear(&[0.0; 3], &[1.0; 3], &[3.0; 3]));
        assert!(!is_collinear(&[0.0; 3], &[0.1; 3], &[0.3, 0.3, f64::from_bits(0.3f64.to_bits() + 1)]));
        assert!(!is_collinear(&[0.0, 0.0, 0.0], &[5e-324, 0.0, 0.0], &[0.0, 5e-324, 0.0]));
    }
}
