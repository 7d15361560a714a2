//! `nalgebra`: [`Isometry3`], whose rotation is a quaternion, and [`Matrix4`], which has the numbers of a [`Pose`] as they are.

use nalgebra::{Isometry3, Matrix3, Matrix4, Rotation3, Translation3, UnitQuaternion};

use crate::error::{Error, Result};
use crate::geometry::pose::Pose;

/// The quaternion has length 1, even if the rotation of the pose deviates from a rigid one by up to 1e-6, the tolerance of poses.
impl From<Pose> for Isometry3<f64> {
    fn from(pose: Pose) -> Isometry3<f64> {
        let rows = pose.rotation();
        let rotation = Rotation3::from_matrix_unchecked(Matrix3::from_fn(|i, j| rows[i][j]));
        let turn = UnitQuaternion::from_rotation_matrix(&rotation);
        let [x, y, z] = *pose.translation();
        Isometry3::from_parts(Translation3::new(x, y, z), UnitQuaternion::new_normalize(turn.into_inner()))
    }
}

impl From<Pose> for Matrix4<f64> {
    fn from(pose: Pose) -> Matrix4<f64> {
        let rows = pose.matrix();
        Matrix4::from_fn(|i, j| rows[i][j])
    }
}

/// Judged as by [`Pose::new`]: a translation may be beyond the coordinate limit, and a quaternion of another length than 1.
impl TryFrom<Isometry3<f64>> for Pose {
    type Error = Error;

    fn try_from(isometry: Isometry3<f64>) -> Result<Pose> {
        isometry.to_homogeneous().try_into()
    }
}

/// Judged as by [`Pose::new`].
impl TryFrom<Matrix4<f64>> for Pose {
    type Error = Error;

    fn try_from(matrix: Matrix4<f64>) -> Result<Pose> {
        Pose::new(&std::array::from_fn(|i| std::array::from_fn(|j| matrix[(i, j)])))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Point3, Quaternion, Vector3};

    fn turned() -> Isometry3<f64> {
        Isometry3::new(Vector3::new(0.1, -2.0, 30.0), Vector3::new(0.3, -0.5, 0.9))
    }

    #[test]
    fn a_pose_moves_points_as_the_isometry_does() {
        let isometry = turned();
        let pose = Pose::try_from(isometry).unwrap();
        let p = [0.3, 0.2, -0.5];
        let off = Point3::from(pose.apply(&p)) - isometry * Point3::from(p);
        assert!(off.norm() < 1e-14, "{off}");
        let back = Isometry3::from(pose);
        assert_eq!(back.translation, isometry.translation);
        assert!(back.rotation.angle_to(&isometry.rotation) < 1e-14);
        assert_eq!(Pose::try_from(Matrix4::from(pose)), Ok(pose));
    }

    #[test]
    fn an_isometry_of_a_rounded_pose_is_one() {
        let mut matrix = Matrix4::from(Pose::try_from(turned()).unwrap());
        matrix[(0, 0)] += 3e-7;
        let isometry = Isometry3::from(Pose::try_from(matrix).unwrap());
        assert!((isometry.rotation.norm() - 1.0).abs() < 1e-15);
        assert!(isometry.rotation.angle_to(&turned().rotation) < 1e-6);
    }

    #[test]
    fn what_is_not_rigid_is_refused_as_a_pose_is() {
        let long = UnitQuaternion::new_unchecked(Quaternion::new(1.001, 0.0, 0.0, 0.0));
        let stretched = Isometry3::from_parts(Translation3::identity(), long);
        assert!(matches!(Pose::try_from(stretched), Err(Error::PoseNotRigid { .. })));
        let far = Isometry3::translation(0.0, 1e101, 0.0);
        assert!(matches!(Pose::try_from(far), Err(Error::PoseNotFinite { row: 1, column: 3, .. })));
        let mirrored = Matrix4::new_nonuniform_scaling(&Vector3::new(1.0, 1.0, -1.0));
        assert!(matches!(Pose::try_from(mirrored), Err(Error::PoseNotRigid { .. })));
    }
}
