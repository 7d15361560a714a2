//! Limits wrenches for a device, and checks the poses that a device reports.

use feeler_core::geometry::twist;
use feeler_core::geometry::twist::Matrix;
use feeler_core::geometry::vectors::{cross, dot};
use feeler_core::{Point, Pose};
use feeler_haptics::device::{DeviceError, DeviceInfo};
use feeler_haptics::{Twist, Wrench};

use crate::constants::{LARGEST_REACH_M, LARGEST_SPEED_M_PER_S, LARGEST_TURN_RAD_PER_S, ROTATION_TOLERANCE};

/// The wrench that the device is given: nothing where a number is not finite, no longer than its limits (the direction stays), and only
/// what it drives.
pub(crate) fn clipped(wrench: &Wrench, info: &DeviceInfo) -> Wrench {
    if !wrench.is_finite() {
        return Wrench::ZERO;
    }
    Wrench {
        force: shortened(&wrench.force, if info.driven.translation { info.limits.force_n } else { 0.0 }),
        torque: shortened(&wrench.torque, if info.driven.rotation { info.limits.torque_nm } else { 0.0 }),
    }
}

/// A vector no longer than `longest`. A limit that is no number allows nothing.
fn shortened(vector: &Point, longest: f64) -> Point {
    if longest.is_nan() || longest <= 0.0 {
        return [0.0; 3];
    }
    // By the largest part first: the square of a large force overflows.
    let largest = vector.iter().fold(0.0f64, |most, x| most.max(x.abs()));
    if largest == 0.0 {
        return [0.0; 3];
    }
    let length = largest * vector.iter().map(|x| (x / largest).powi(2)).sum::<f64>().sqrt();
    if length <= longest {
        return *vector;
    }
    vector.map(|x| x / largest * (longest / (length / largest)))
}

/// The smaller of a device's own limit and one that the user sets; a user's limit that is no number counts as none.
pub(crate) fn limit(own: f64, users: Option<f64>) -> f64 {
    users.filter(|x| *x >= 0.0).map_or(own, |x| x.min(own))
}

/// A pose from a device's reading, metres; its rotation is set right where it is off by rounding. Errors where it cannot be.
pub(crate) fn told_pose(device: &str, rotation: &Matrix, position: &Point) -> Result<Pose, DeviceError> {
    let nonsense = |what: String| DeviceError::Nonsense { device: device.to_string(), what };
    if !position.iter().all(|x| x.abs() <= LARGEST_REACH_M) {
        return Err(nonsense(format!("a position of {position:?} m")));
    }
    let square = twist::product(&twist::transposed(rotation), rotation);
    let off: f64 =
        (0..3).flat_map(|i| (0..3).map(move |j| (i, j))).map(|(i, j)| (square[i][j] - unit(i, j)).powi(2)).sum();
    let is_mirrored = dot(&column(rotation, 0), &cross(&column(rotation, 1), &column(rotation, 2))) < 0.0;
    if off.is_nan() || off > ROTATION_TOLERANCE || is_mirrored {
        return Err(nonsense(format!("a rotation of {rotation:?}")));
    }
    let rotation = twist::rotation_of_quaternion(&twist::quaternion(rotation));
    twist::pose_of(&rotation, position).map_err(|error| nonsense(error.to_string()))
}

/// A twist from a device's reading, metres and radians a second. Errors where it cannot be.
pub(crate) fn told_twist(device: &str, twist: Twist) -> Result<Twist, DeviceError> {
    let is_within = twist.linear.iter().all(|x| x.abs() <= LARGEST_SPEED_M_PER_S)
        && twist.angular.iter().all(|x| x.abs() <= LARGEST_TURN_RAD_PER_S);
    if is_within {
        return Ok(twist);
    }
    Err(DeviceError::Nonsense { device: device.to_string(), what: format!("a velocity of {:?}", twist.as_array()) })
}

fn unit(i: usize, j: usize) -> f64 {
    if i == j {
        1.0
    } else {
        0.0
    }
}

fn column(m: &Matrix, j: usize) -> Point {
    [m[0][j], m[1][j], m[2][j]]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::{device, INFINITE};

    #[test]
    fn force_is_clipped_and_keeps_its_direction() {
        let wrench = Wrench { force: [30.0, 0.0, 40.0], torque: [0.0, 2.0, 0.0] };
        let given = clipped(&wrench, &device(5.0, 0.1));
        assert_eq!(given, Wrench { force: [3.0, 0.0, 4.0], torque: [0.0, 0.1, 0.0] });
        assert_eq!(clipped(&wrench, &device(50.0, 2.0)), wrench);
    }

    #[test]
    fn a_force_beyond_all_measure_is_clipped_as_well() {
        let given = clipped(&Wrench { force: [1e300, 0.0, 1e300], torque: [0.0; 3] }, &device(5.0, 0.0));
        assert!((given.force[0] - 5.0 / 2f64.sqrt()).abs() < 1e-12 && given.force[0] == given.force[2], "{given:?}");
    }

    #[test]
    fn what_is_not_finite_becomes_nothing() {
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            for part in 0..6 {
                let mut numbers = [1.0, 1.0, 1.0, 0.01, 0.01, 0.01];
                numbers[part] = bad;
                let [x, y, z, u, v, w] = numbers;
                assert_eq!(clipped(&Wrench { force: [x, y, z], torque: [u, v, w] }, &device(5.0, 0.1)), Wrench::ZERO);
            }
        }
    }

    #[test]
    fn a_limit_that_is_no_number_allows_nothing() {
        let wrench = Wrench { force: [1.0, 0.0, 0.0], torque: [0.0; 3] };
        assert_eq!(clipped(&wrench, &device(f64::NAN, 0.0)), Wrench::ZERO);
        assert_eq!(clipped(&wrench, &device(-1.0, 0.0)), Wrench::ZERO);
    }

    #[test]
    fn what_is_not_driven_is_left_out() {
        let mut info = device(5.0, 0.1);
        info.driven.rotation = false;
        assert_eq!(clipped(&Wrench { force: [1.0; 3], torque: [0.01; 3] }, &info).torque, [0.0; 3]);
    }

    #[test]
    fn a_user_only_lowers_a_limit() {
        assert_eq!(
            [limit(5.0, None), limit(5.0, Some(2.0)), limit(5.0, Some(9.0)), limit(5.0, Some(f64::NAN))],
            [5.0, 2.0, 5.0, 5.0]
        );
    }

    #[test]
    fn rotations_are_set_right_and_mirrors_refused() {
        let nearly = [[1.0 + 1e-5, 1e-5, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        assert!(told_pose("d", &nearly, &[0.0; 3]).is_ok());
        let mirror = [[-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let zero = [[0.0; 3]; 3];
        let nan = [[f64::NAN; 3]; 3];
        for bad in [mirror, zero, nan] {
            assert!(matches!(told_pose("d", &bad, &[0.0; 3]), Err(DeviceError::Nonsense { .. })), "{bad:?}");
        }
    }

    #[test]
    fn positions_and_velocities_that_cannot_be_are_refused() {
        let one = twist::rotation_of(&[0.0; 3]);
        for bad in [f64::NAN, f64::INFINITY, 11.0, -11.0] {
            assert!(told_pose("d", &one, &[0.0, bad, 0.0]).is_err());
        }
        assert!(told_twist("d", Twist { linear: [INFINITE, 0.0, 0.0], angular: [0.0; 3] }).is_err());
        assert!(told_twist("d", Twist { linear: [0.0; 3], angular: [0.0, f64::NAN, 0.0] }).is_err());
        assert!(told_twist("d", Twist { linear: [3.0, 0.0, 0.0], angular: [20.0, 0.0, 0.0] }).is_ok());
    }
}
