//! Exact quotients of whole numbers: positions along a ray.

use std::cmp::Ordering;

use num_bigint::{BigInt, Sign as BigSign};

/// `numerator / denominator`; the denominator is positive.
#[derive(Debug, Clone)]
pub struct Ratio {
    numerator: BigInt,
    denominator: BigInt,
}

impl Ratio {
    /// Of any denominator but zero.
    pub fn new(numerator: BigInt, denominator: BigInt) -> Ratio {
        if denominator.sign() == BigSign::Minus {
            return Ratio { numerator: -numerator, denominator: -denominator };
        }
        Ratio { numerator, denominator }
    }

    pub fn zero() -> Ratio {
        Ratio { numerator: BigInt::ZERO, denominator: BigInt::from(1) }
    }

    pub fn compare(&self, other: &Ratio) -> Ordering {
        (&self.numerator * &other.denominator).cmp(&(&other.numerator * &self.denominator))
    }

    pub fn is_negative(&self) -> bool {
        self.numerator.sign() == BigSign::Minus
    }

    /// Right within two roundings.
    pub fn to_f64(&self) -> f64 {
        // A quotient of 64 or 65 bits.
        let shift = 64 + self.denominator.bits() as i64 - self.numerator.bits() as i64;
        let quotient = if shift >= 0 {
            (&self.numerator << shift) / &self.denominator
        } else {
            &self.numerator / (&self.denominator << -shift)
        };
        let (sign, digits) = quotient.to_u64_digits();
        let size = digits.iter().rev().fold(0u128, |sum, digit| sum << 64 | u128::from(*digit)) as f64;
        let half = (-shift / 2) as i32;
        let scaled = size * 2f64.powi(half) * 2f64.powi((-shift) as i32 - half);
        if sign == BigSign::Minus {
            -scaled
        } else {
            scaled
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quotients_are_ordered_and_rounded() {
        let ratio = |n: i64, d: i64| Ratio::new(BigInt::from(n), BigInt::from(d));
        assert_eq!(ratio(1, -3).compare(&ratio(-2, 6)), Ordering::Equal);
        assert_eq!(ratio(1, 3).compare(&ratio(1_000_000_000_000, 3_000_000_000_001)), Ordering::Greater);
        for (n, d) in [(1i64, 3i64), (-7, 9), (0, 5), (i64::MAX, 1), (1, i64::MAX), (3, 4)] {
            let exact = n as f64 / d as f64;
            assert!((ratio(n, d).to_f64() - exact).abs() <= 2.0 * f64::EPSILON * exact.abs(), "{n}/{d}");
        }
        let huge = Ratio::new(BigInt::from(3) << 1800u32, BigInt::from(1) << 1000u32);
        assert_eq!(huge.to_f64(), 3.0 * 2f64.powi(800));
        assert!(ratio(1, -3).is_negative() && !Ratio::zero().is_negative());
    }
}
