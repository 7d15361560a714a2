//! `glam`: [`DAffine3`] and [`DMat4`], which have columns where a [`Pose`] has rows. Both ways the numbers stay as they are.

use glam::{DAffine3, DMat3, DMat4, DVec3};

use crate::error::{Error, Result};
use crate::geometry::pose::Pose;

impl From<Pose> for DMat4 {
    fn from(pose: Pose) -> DMat4 {
        DMat4::from_cols_array_2d(&pose.matrix()).transpose()
    }
}

impl From<Pose> for DAffine3 {
    fn from(pose: Pose) -> DAffine3 {
        DAffine3 {
            matrix3: DMat3::from_cols_array_2d(pose.rotation()).transpose(),
            translation: DVec3::from_array(*pose.translation()),
        }
    }
}

/// Judged as by [`Pose::new`].
impl TryFrom<DMat4> for Pose {
    type Error = Error;

    fn try_from(matrix: DMat4) -> Result<Pose> {
        Pose::new(&matrix.transpose().to_cols_array_2d())
    }
}

/// Judged as by [`Pose::new`].
impl TryFrom<DAffine3> for Pose {
    type Error = Error;

    fn try_from(affine: DAffine3) -> Result<Pose> {
        DMat4::from(affine).try_into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DQuat;

    const PLACE: [f64; 3] = [0.1, -2.0, 30.0];

    fn turned() -> DAffine3 {
        DAffine3::from_rotation_translation(
            DQuat::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 0.7),
            DVec3::from_array(PLACE),
        )
    }

    #[test]
    fn a_pose_moves_points_as_the_affine_transform_does() {
        let affine = turned();
        let pose = Pose::try_from(affine).unwrap();
        let p = [0.3, 0.2, -0.5];
        let off = DVec3::from_array(pose.apply(&p)) - affine.transform_point3(DVec3::from_array(p));
        assert!(off.length() < 1e-14, "{off}");
        assert_eq!(pose.translation(), &PLACE);
        // Both ways, to the last bit.
        assert_eq!(DAffine3::from(pose), affine);
        assert_eq!(DMat4::from(pose), DMat4::from(affine));
        assert_eq!(Pose::try_from(DMat4::from(affine)), Ok(pose));
    }

    #[test]
    fn what_is_not_rigid_is_refused_as_a_pose_is() {
        let stretched = DAffine3::from_scale(DVec3::new(1.0, 1.001, 1.0)) * turned();
        assert!(matches!(Pose::try_from(stretched), Err(Error::PoseNotRigid { .. })));
        let mirrored = DAffine3::from_scale(DVec3::new(1.0, 1.0, -1.0));
        assert!(matches!(Pose::try_from(mirrored), Err(Error::PoseNotRigid { .. })));
        let nowhere = DAffine3::from_translation(DVec3::new(0.0, f64::NAN, 0.0));
        assert!(matches!(Pose::try_from(nowhere), Err(Error::PoseNotFinite { row: 1, column: 3, .. })));
        let projective = DMat4::from_cols_array_2d(&[
            [1.0, 0.0, 0.0, 0.1],
            [0.0, 1.0, 0.0, 0.0],
            [0.0, 0.0, 1.0, 0.0],
            [0.0, 0.0, 0.0, 1.0],
        ]);
        assert!(matches!(Pose::try_from(projective), Err(Error::PoseNotRigid { .. })));
    }
}
