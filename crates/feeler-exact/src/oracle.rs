//! The truth: whether and how two triangles collide, in exact rational arithmetic, slow and obvious.
//!
//! Written from the geometry alone, without code of the core. A triangle is the set of points spanned by its corners,
//! and also the set of points on its plane and within its three sides. The intersection of two triangles is therefore
//! found by cutting one, as a polygon, with the plane and the sides of the other, one closed half-space after the other
//! (I. Sutherland and G. Hodgman, *Reentrant polygon clipping*, 1974). They collide if something remains.
//!
//! Every float64 is a whole number of some small power of two, so all coordinates of a pair become integers at once, however
//! large or small. A rational point is four integers: `(x, y, z)` over a positive `w`.

use feeler_core::{PairKind, Triangle};
use num_bigint::{BigInt, Sign};

pub(crate) type Vector = [BigInt; 3];

/// The point `(x/w, y/w, z/w)`.
#[derive(Debug, Clone)]
struct Rational {
    xyz: Vector,
    w: BigInt,
}

/// The points `x` with `outward . x <= offset`.
struct HalfSpace {
    outward: Vector,
    offset: BigInt,
}

/// How two closed triangles meet, `None` when they share no point. All coordinates must be finite.
///
/// The kinds are those of the exactness contract. One triangle may have lost its area (all corners on a line, or one
/// point): it then meets the other `coplanar` where it lies in its plane, and `touching` otherwise.
///
/// # Panics
/// When neither triangle has an area: a mock-up's triangles always have one.
pub fn kind_of_pair(p: &Triangle, q: &Triangle) -> Option<PairKind> {
    if !is_meeting_boxes(p, q) {
        return None;
    }
    let [p, q] = integers(p, q);
    let (normal_p, normal_q) = (normal(&p), normal(&q));
    if is_zero(&normal_q) {
        assert!(!is_zero(&normal_p), "neither triangle has an area");
        return kind_of_cut(&q, &normal_q, &p, &normal_p);
    }
    kind_of_cut(&p, &normal_p, &q, &normal_q)
}

/// Whether the corners do not all lie on one line.
pub fn has_area(t: &Triangle) -> bool {
    let [t, _] = integers(t, t);
    !is_zero(&normal(&t))
}

/// Whether the closed boxes around two triangles share a point. Comparisons only, so exact.
pub fn is_meeting_boxes(p: &Triangle, q: &Triangle) -> bool {
    let low = |t: &Triangle, axis: usize| t.iter().map(|c| c[axis]).fold(f64::INFINITY, f64::min);
    let high = |t: &Triangle, axis: usize| t.iter().map(|c| c[axis]).fold(f64::NEG_INFINITY, f64::max);
    (0..3).all(|axis| low(p, axis) <= high(q, axis) && low(q, axis) <= high(p, axis))
}

/// Cuts `p` with `q`, which has an area.
fn kind_of_cut(p: &[Vector; 3], normal_p: &Vector, q: &[Vector; 3], normal_q: &Vector) -> Option<PairKind> {
    let heights = |t: &[Vector; 3], normal: &Vector, corner: &Vector| {
        [0, 1, 2].map(|i| dot(normal, &difference(&t[i], corner)).sign())
    };
    let heights_p = heights(p, normal_q, &q[0]);
    if heights_p == [Sign::Plus; 3] || heights_p == [Sign::Minus; 3] {
        return None;
    }
    let shared = shared_points(p, q, normal_q);
    if shared.is_empty() {
        return None;
    }
    if heights_p == [Sign::NoSign; 3] {
        return Some(PairKind::Coplanar);
    }
    let is_on_both_sides = |h: [Sign; 3]| h.contains(&Sign::Plus) && h.contains(&Sign::Minus);
    let is_crossing = is_on_both_sides(heights_p)
        && !is_zero(normal_p)
        && is_on_both_sides(heights(q, normal_p, &p[0]))
        && shared.iter().any(|x| !is_same(x, &shared[0]));
    Some(if is_crossing { PairKind::Crossing } else { PairKind::Touching })
}

/// Corners of the convex set that two triangles share; none when they share nothing.
fn shared_points(p: &[Vector; 3], q: &[Vector; 3], normal_q: &Vector) -> Vec<Rational> {
    // The plane of q is what two closed half-spaces share; its sides stand upright on it and face outwards.
    let mut half_spaces = vec![
        HalfSpace::at(normal_q.clone(), &q[0]),
        HalfSpace::at([-&normal_q[0], -&normal_q[1], -&normal_q[2]], &q[0]),
    ];
    for (from, to) in [(0, 1), (1, 2), (2, 0)] {
        half_spaces.push(HalfSpace::at(cross(&difference(&q[to], &q[from]), normal_q), &q[from]));
    }
    let mut polygon: Vec<Rational> = p.iter().map(|c| Rational { xyz: c.clone(), w: BigInt::from(1) }).collect();
    for half_space in &half_spaces {
        polygon = half_space.cut(&polygon);
    }
    polygon
}

impl HalfSpace {
    /// Bounded by the plane through `corner` across `outward`.
    fn at(outward: Vector, corner: &Vector) -> HalfSpace {
        HalfSpace { offset: dot(&outward, corner), outward }
    }

    /// How far outside a point is, times a positive factor that includes its `w`.
    fn height(&self, x: &Rational) -> BigInt {
        dot(&self.outward, &x.xyz) - &self.offset * &x.w
    }

    /// The part inside of a convex polygon (also one that is only a segment or a point).
    fn cut(&self, polygon: &[Rational]) -> Vec<Rational> {
        let heights: Vec<BigInt> = polygon.iter().map(|x| self.height(x)).collect();
        let mut kept = Vec::with_capacity(polygon.len() + 1);
        for (i, x) in polygon.iter().enumerate() {
            let before = (i + polygon.len() - 1) % polygon.len();
            match (heights[before].sign(), heights[i].sign()) {
                (Sign::Plus, Sign::Minus) => {
                    kept.push(passage(x, &heights[i], &polygon[before], &heights[before]));
                }
                (Sign::Minus, Sign::Plus) => {
                    kept.push(passage(&polygon[before], &heights[before], x, &heights[i]));
                }
                _ => {}
            }
            if heights[i].sign() != Sign::Plus {
                kept.push(x.clone());
            }
        }
        kept
    }
}

/// Where the segment from `x`, inside (height below zero), to `y`, outside, passes the border: the height is linear, so the
/// weights are the other end's distance. Both weights are positive, and so is the new `w`.
fn passage(x: &Rational, height_x: &BigInt, y: &Rational, height_y: &BigInt) -> Rational {
    let mix = |a: &BigInt, b: &BigInt| a * height_y - b * height_x;
    Rational { xyz: [0, 1, 2].map(|axis| mix(&x.xyz[axis], &y.xyz[axis])), w: mix(&x.w, &y.w) }
}

fn is_same(x: &Rational, y: &Rational) -> bool {
    (0..3).all(|axis| &x.xyz[axis] * &y.w == &y.xyz[axis] * &x.w)
}

/// All coordinates, times one power of two that makes them whole, seen from the first corner of `p`. Neither a scale nor a
/// shift changes how two sets meet.
pub(crate) fn integers(p: &Triangle, q: &Triangle) -> [[Vector; 3]; 2] {
    let unit = p.iter().chain(q).flatten().map(|x| exponent_of_last_bit(*x)).min().unwrap_or(0).min(MANY);
    let whole = |x: f64| -> BigInt {
        if x == 0.0 {
            return BigInt::ZERO;
        }
        let (mantissa, exponent) = parts(x);
        let last = exponent_of_last_bit(x);
        BigInt::from(mantissa >> (last - exponent)) << (last - unit)
    };
    let origin = p[0].map(whole);
    [p, q].map(|t| t.map(|c| difference(&c.map(whole), &origin)))
}

/// Larger than the exponent of any float64.
const MANY: i32 = 2000;

/// `x == mantissa * 2^exponent`; the mantissa carries the sign.
fn parts(x: f64) -> (i64, i32) {
    assert!(x.is_finite(), "a coordinate is {x}");
    let bits = x.to_bits();
    let fraction = (bits & ((1 << 52) - 1)) as i64;
    let (size, exponent) = match (bits >> 52 & 0x7ff) as i32 {
        0 => (fraction, -1074),
        biased => (fraction | 1 << 52, biased - 1075),
    };
    (if x.is_sign_negative() { -size } else { size }, exponent)
}

/// The largest power of two of which `x` is a whole multiple.
fn exponent_of_last_bit(x: f64) -> i32 {
    let (mantissa, exponent) = parts(x);
    if mantissa == 0 {
        MANY
    } else {
        exponent + mantissa.trailing_zeros() as i32
    }
}

pub(crate) fn normal(t: &[Vector; 3]) -> Vector {
    cross(&difference(&t[1], &t[0]), &difference(&t[2], &t[0]))
}

pub(crate) fn difference(a: &Vector, b: &Vector) -> Vector {
    [&a[0] - &b[0], &a[1] - &b[1], &a[2] - &b[2]]
}

pub(crate) fn cross(a: &Vector, b: &Vector) -> Vector {
    [&a[1] * &b[2] - &a[2] * &b[1], &a[2] * &b[0] - &a[0] * &b[2], &a[0] * &b[1] - &a[1] * &b[0]]
}

pub(crate) fn dot(a: &Vector, b: &Vector) -> BigInt {
    &a[0] * &b[0] + &a[1] * &b[1] + &a[2] * &b[2]
}

pub(crate) fn is_zero(v: &Vector) -> bool {
    v.iter().all(|x| x.sign() == Sign::NoSign)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_taken_apart_exactly() {
        for x in [0.0, -0.0, 1.0, -3.0, 0.1, 5e-324, -5e-324, 2.5e-310, 1e100, f64::MAX, f64::MIN_POSITIVE] {
            let (mantissa, exponent) = parts(x);
            let half = exponent / 2;
            assert_eq!(mantissa as f64 * 2f64.powi(half) * 2f64.powi(exponent - half), x);
        }
        assert_eq!(exponent_of_last_bit(12.0), 2);
        assert_eq!(exponent_of_last_bit(5e-324), -1074);
    }

    #[test]
    fn area_is_exact() {
        assert!(!has_area(&[[0.0; 3], [1.0; 3], [3.0; 3]]));
        assert!(!has_area(&[[0.0; 3]; 3]));
        assert!(has_area(&[[0.0; 3], [0.1; 3], [0.3, 0.3, 0.3f64.next_up()]]));
        assert!(has_area(&[[0.0; 3], [5e-324, 0.0, 0.0], [0.0, 1e100, 0.0]]));
    }

    #[test]
    fn kinds_of_plain_cases() {
        let base: Triangle = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];
        let kind = |p: Triangle| {
            assert_eq!(kind_of_pair(&p, &base), kind_of_pair(&base, &p));
            kind_of_pair(&p, &base)
        };
        assert_eq!(kind([[1.0, 1.0, -1.0], [1.0, 1.0, 1.0], [2.0, 1.0, 1.0]]), Some(PairKind::Crossing));
        assert_eq!(kind([[1.0, 1.0, 0.0], [1.0, 1.0, 1.0], [2.0, 1.0, 1.0]]), Some(PairKind::Touching));
        assert_eq!(kind([[0.0, 0.0, 0.0], [-1.0, 0.0, 1.0], [-1.0, 0.0, -1.0]]), Some(PairKind::Touching));
        assert_eq!(kind([[1.0, 1.0, 0.0], [9.0, 1.0, 0.0], [1.0, 9.0, 0.0]]), Some(PairKind::Coplanar));
        assert_eq!(kind([[1.0, 1.0, 0.0]; 3]), Some(PairKind::Coplanar));
        assert_eq!(kind([[1.0, 1.0, -1.0], [1.0, 1.0, 0.5], [1.0, 1.0, 1.0]]), Some(PairKind::Touching));
        assert_eq!(kind([[3.0, 3.0, 0.0], [4.0, 2.0, 0.0], [2.0, 4.0, 0.0]]), None);
        assert_eq!(kind([[0.0, 0.0, 5e-324], [4.0, 0.0, 5e-324], [0.0, 4.0, 5e-324]]), None);
    }
}
