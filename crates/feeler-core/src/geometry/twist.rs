//! Twists, wrenches, and poses moved by them: the algebra of rigid motion at a tool's centre.

use std::ops::{Add, Mul, Neg, Sub};

use crate::constants::SMALL_ANGLE;
use crate::error::Result;
use crate::geometry::bounds::Point;
use crate::geometry::pose::Pose;
use crate::geometry::vectors::{add, cross, dot, length, scaled, sub};

/// A linear and an angular part, world axes: of a displacement (metres, radians as a rotation vector) or a velocity (per second), at
/// a reference point that the function it is passed to names.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Twist {
    /// Metres, or metres a second.
    pub linear: Point,
    /// Radians, or radians a second.
    pub angular: Point,
}

/// A force (newtons) and a torque (newton metres), world axes, at a reference point.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Wrench {
    /// Newtons.
    pub force: Point,
    /// Newton metres.
    pub torque: Point,
}

/// A rotation matrix, row by row.
pub type Matrix = [[f64; 3]; 3];

impl Twist {
    /// Of a linear and an angular part.
    pub const fn new(linear: Point, angular: Point) -> Twist {
        Twist { linear, angular }
    }

    /// At rest.
    pub const ZERO: Twist = Twist { linear: [0.0; 3], angular: [0.0; 3] };

    /// As six numbers, the linear ones first.
    pub fn as_array(&self) -> [f64; 6] {
        let ([x, y, z], [u, v, w]) = (self.linear, self.angular);
        [x, y, z, u, v, w]
    }

    /// Of six numbers, the linear ones first.
    pub fn from_array([x, y, z, u, v, w]: [f64; 6]) -> Twist {
        Twist { linear: [x, y, z], angular: [u, v, w] }
    }

    /// How far any point within `radius` of the reference point moves at most.
    pub fn reach(&self, radius: f64) -> f64 {
        length(&self.linear) + length(&self.angular) * radius
    }

    /// The same motion at another reference point, `arm` from this one.
    pub fn at(&self, arm: &Point) -> Twist {
        Twist { linear: add(&self.linear, &cross(&self.angular, arm)), angular: self.angular }
    }

    /// Whether all six are finite.
    pub fn is_finite(&self) -> bool {
        self.as_array().iter().all(|x| x.is_finite())
    }
}

impl Wrench {
    /// Of a force (newtons) and a torque (newton metres).
    pub const fn new(force: Point, torque: Point) -> Wrench {
        Wrench { force, torque }
    }

    /// No force.
    pub const ZERO: Wrench = Wrench { force: [0.0; 3], torque: [0.0; 3] };

    /// The same wrench at another reference point, `arm` from this one.
    pub fn at(&self, arm: &Point) -> Wrench {
        Wrench { force: self.force, torque: sub(&self.torque, &cross(arm, &self.force)) }
    }

    /// Power on a body that moves with a velocity at the same reference point, watts.
    pub fn power(&self, twist: &Twist) -> f64 {
        dot(&self.force, &twist.linear) + dot(&self.torque, &twist.angular)
    }

    /// Whether all six are finite.
    pub fn is_finite(&self) -> bool {
        self.force.iter().chain(&self.torque).all(|x| x.is_finite())
    }
}

macro_rules! six {
    ($what:ident, $first:ident, $second:ident) => {
        impl Add for $what {
            type Output = $what;
            fn add(self, other: $what) -> $what {
                $what { $first: add(&self.$first, &other.$first), $second: add(&self.$second, &other.$second) }
            }
        }
        impl Sub for $what {
            type Output = $what;
            fn sub(self, other: $what) -> $what {
                $what { $first: sub(&self.$first, &other.$first), $second: sub(&self.$second, &other.$second) }
            }
        }
        impl Mul<f64> for $what {
            type Output = $what;
            fn mul(self, by: f64) -> $what {
                $what { $first: scaled(&self.$first, by), $second: scaled(&self.$second, by) }
            }
        }
        impl Neg for $what {
            type Output = $what;
            fn neg(self) -> $what {
                self * -1.0
            }
        }
    };
}
six!(Twist, linear, angular);
six!(Wrench, force, torque);

/// The rotation by a rotation vector (Rodrigues).
pub fn rotation_of(vector: &Point) -> Matrix {
    let square = dot(vector, vector);
    let angle = square.sqrt();
    // sin(a) / a and (1 - cos(a)) / a^2.
    let (s, c) = if angle < SMALL_ANGLE {
        (1.0 - square / 6.0, 0.5 - square / 24.0)
    } else {
        (angle.sin() / angle, 2.0 * (0.5 * angle).sin().powi(2) / square)
    };
    let [x, y, z] = *vector;
    let d = 1.0 - c * square;
    [
        [d + c * x * x, c * x * y - s * z, c * x * z + s * y],
        [c * x * y + s * z, d + c * y * y, c * y * z - s * x],
        [c * x * z - s * y, c * y * z + s * x, d + c * z * z],
    ]
}

/// The rotation about a unit axis (Rodrigues).
pub(crate) fn turn(axis: &Point, angle: f64) -> Matrix {
    let (sine, half) = (angle.sin(), (0.5 * angle).sin());
    let versine = 2.0 * half * half;
    let [x, y, z] = *axis;
    [
        [1.0 - versine * (y * y + z * z), versine * x * y - sine * z, versine * x * z + sine * y],
        [versine * x * y + sine * z, 1.0 - versine * (x * x + z * z), versine * y * z - sine * x],
        [versine * x * z - sine * y, versine * y * z + sine * x, 1.0 - versine * (x * x + y * y)],
    ]
}

/// The rotation vector of a rotation, the shorter way round: by the logarithm of its unit quaternion.
pub fn rotation_vector(m: &Matrix) -> Point {
    let [w, x, y, z] = quaternion(m);
    let sine = length(&[x, y, z]);
    // Twice the half angle, over its sine; the quaternion has w >= 0.
    let by = if sine < SMALL_ANGLE { 2.0 / w * (1.0 - (sine / w).powi(2) / 3.0) } else { 2.0 * sine.atan2(w) / sine };
    [by * x, by * y, by * z]
}

/// The unit quaternion (w, x, y, z) of a rotation, w not negative (Shepperd 1978: the largest of the four is found first).
pub fn quaternion(m: &Matrix) -> [f64; 4] {
    let trace = m[0][0] + m[1][1] + m[2][2];
    let squares = [trace, m[0][0], m[1][1], m[2][2]];
    let largest = (0..4).fold(0, |best, i| if squares[i] > squares[best] { i } else { best });
    let mut q = match largest {
        0 => [1.0 + trace, m[2][1] - m[1][2], m[0][2] - m[2][0], m[1][0] - m[0][1]],
        1 => [m[2][1] - m[1][2], 1.0 + 2.0 * m[0][0] - trace, m[0][1] + m[1][0], m[0][2] + m[2][0]],
        2 => [m[0][2] - m[2][0], m[0][1] + m[1][0], 1.0 + 2.0 * m[1][1] - trace, m[1][2] + m[2][1]],
        _ => [m[1][0] - m[0][1], m[0][2] + m[2][0], m[1][2] + m[2][1], 1.0 + 2.0 * m[2][2] - trace],
    };
    let norm = q.iter().map(|x| x * x).sum::<f64>().sqrt();
    let by = if q[0] < 0.0 { -1.0 / norm } else { 1.0 / norm };
    q.iter_mut().for_each(|x| *x *= by);
    q
}

/// The rotation of a quaternion (w, x, y, z), which is normalised.
pub fn rotation_of_quaternion(q: &[f64; 4]) -> Matrix {
    let norm = q.iter().map(|x| x * x).sum::<f64>().sqrt();
    let [w, x, y, z] = q.map(|part| part / norm);
    [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
        [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
    ]
}

/// The product of two matrices.
pub fn product(a: &Matrix, b: &Matrix) -> Matrix {
    std::array::from_fn(|i| std::array::from_fn(|j| a[i][0] * b[0][j] + a[i][1] * b[1][j] + a[i][2] * b[2][j]))
}

/// The transposed matrix.
pub fn transposed(m: &Matrix) -> Matrix {
    std::array::from_fn(|i| std::array::from_fn(|j| m[j][i]))
}

/// A matrix times a vector.
pub fn times(m: &Matrix, p: &Point) -> Point {
    [dot(&m[0], p), dot(&m[1], p), dot(&m[2], p)]
}

/// A pose of a rotation and a translation. Errors where they are not those of a rigid motion.
pub fn pose_of(rotation: &Matrix, translation: &Point) -> Result<Pose> {
    let row = |i: usize| {
        let [x, y, z] = rotation[i];
        [x, y, z, translation[i]]
    };
    Pose::new(&[row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]])
}

/// The displacement that takes one pose to another, at a point of the tool (`centre`, tool frame): that point's way in the world, and
/// the rotation vector between the two, the shorter way round.
pub fn displacement(from: &Pose, to: &Pose, centre: &Point) -> Twist {
    Twist {
        linear: sub(&to.apply(centre), &from.apply(centre)),
        angular: rotation_vector(&product(to.rotation(), &transposed(from.rotation()))),
    }
}

/// The pose after a displacement at a point of the tool (`centre`, tool frame). The rotation is normalised, so that rounding does not
/// add up over many steps. Errors where the result is beyond the coordinate limit.
pub fn displaced(pose: &Pose, by: &Twist, centre: &Point) -> Result<Pose> {
    let turned = product(&rotation_of(&by.angular), pose.rotation());
    let rotation = rotation_of_quaternion(&quaternion(&turned));
    let place = add(&pose.apply(centre), &by.linear);
    pose_of(&rotation, &sub(&place, &times(&rotation, centre)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn vector(most: f64) -> impl Strategy<Value = Point> {
        prop::array::uniform3(-most..most)
    }

    proptest! {
        #[test]
        fn a_displacement_leads_from_one_pose_to_the_other(a in vector(1.5), b in vector(1.5), p in vector(10.0), q in vector(10.0), centre in vector(2.0)) {
            let from = pose_of(&rotation_of(&a), &p).unwrap();
            let to = pose_of(&rotation_of(&b), &q).unwrap();
            let by = displacement(&from, &to, &centre);
            let there = displaced(&from, &by, &centre).unwrap();
            for (row, other) in there.matrix().iter().zip(to.matrix()) {
                for (x, y) in row.iter().zip(other) {
                    prop_assert!((x - y).abs() < 1e-12, "{there:?} {to:?}");
                }
            }
        }

        #[test]
        fn rotation_vectors_and_quaternions_are_inverse_to_rotations(v in vector(1.8), scale in 1e-9..1.0f64) {
            let v = scaled(&v, scale);
            let m = rotation_of(&v);
            let back = rotation_vector(&m);
            prop_assert!(length(&sub(&back, &v)) < 1e-12, "{v:?} {back:?}");
            let same = rotation_of_quaternion(&quaternion(&m));
            prop_assert!(same.as_flattened().iter().zip(m.as_flattened()).all(|(x, y)| (x - y).abs() < 1e-14));
        }

        #[test]
        fn power_does_not_depend_on_the_reference_point(f in vector(9.0), t in vector(9.0), v in vector(3.0), w in vector(3.0), arm in vector(2.0)) {
            let (wrench, twist) = (Wrench { force: f, torque: t }, Twist { linear: v, angular: w });
            prop_assert!((wrench.power(&twist) - wrench.at(&arm).power(&twist.at(&arm))).abs() < 1e-11);
        }
    }

    #[test]
    fn half_a_turn_has_an_axis() {
        for axis in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.6, 0.0, 0.8]] {
            let found = rotation_vector(&rotation_of(&scaled(&axis, std::f64::consts::PI)));
            assert!((length(&found) - std::f64::consts::PI).abs() < 1e-7, "{found:?}");
            assert!((dot(&found, &axis).abs() - std::f64::consts::PI).abs() < 1e-7);
        }
    }
}
