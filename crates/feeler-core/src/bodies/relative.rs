//! The pose of a body in the frame of another.

use crate::geometry::bounds::Point;
use crate::geometry::pose::Pose;

/// `frame_from_body`, of `world_from_frame` and `world_from_body`. The rotation is inverted, not transposed: poses are
/// rigid within a tolerance only.
pub(super) fn relative(frame: &Pose, body: &Pose) -> Pose {
    let (inverse, r) = (inverse(frame.rotation()), body.rotation());
    let between: Point = std::array::from_fn(|a| body.translation()[a] - frame.translation()[a]);
    let row = |i: usize, of: &dyn Fn(usize) -> f64| (0..3).map(|k| inverse[i][k] * of(k)).sum::<f64>();
    let rotation = std::array::from_fn(|i| std::array::from_fn(|j| row(i, &|k| r[k][j])));
    Pose::unchecked(rotation, std::array::from_fn(|i| row(i, &|k| between[k])))
}

/// The inverse of a matrix that is nearly a rotation.
pub(super) fn inverse(m: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
    let minor = |i: usize, j: usize| {
        let [r, s] = [(i + 1) % 3, (i + 2) % 3];
        let [c, d] = [(j + 1) % 3, (j + 2) % 3];
        m[r][c] * m[s][d] - m[r][d] * m[s][c]
    };
    let determinant = m[0][0] * minor(0, 0) + m[0][1] * minor(0, 1) + m[0][2] * minor(0, 2);
    std::array::from_fn(|i| std::array::from_fn(|j| minor(j, i) / determinant))
}
