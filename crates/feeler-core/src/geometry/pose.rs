//! Rigid poses and the one way a tool vertex is computed at a pose.
//!
//! A pose is a rotation matrix and a translation, used as given. The products of the matrix's rows and its determinant
//! decide whether it is rigid.

use crate::constants::{LARGEST_COORDINATE, POSE_TOLERANCE};
use crate::error::{Error, Result};
use crate::geometry::bounds::{Aabb, Point, Triangle};

/// A rigid motion `world_from_tool`, metres. The numbers are used as given: nothing is re-orthonormalised.
///
/// ```
/// use feeler_core::Pose;
///
/// // A quarter of a turn about z, then 0.2 m along x.
/// let pose = Pose::new(&[[0.0, -1.0, 0.0, 0.2], [1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]])?;
/// assert_eq!(pose.apply(&[0.1, 0.0, 0.0]), [0.2, 0.1, 0.0]);
/// # Ok::<(), feeler_core::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    rotation: [[f64; 3]; 3],
    translation: Point,
}

impl Pose {
    /// The tool where its own coordinates put it.
    pub const IDENTITY: Pose =
        Pose { rotation: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], translation: [0.0; 3] };

    /// Checks a row-major 4x4 matrix. Errors when an entry is not finite, the translation is beyond the coordinate limit,
    /// or the matrix deviates by more than 1e-6 from a rotation and a last row of 0, 0, 0, 1.
    pub fn new(m: &[[f64; 4]; 4]) -> Result<Pose> {
        // All at once: batches have many poses, and nearly all are good. A comparison with NaN is false.
        let r: [[f64; 3]; 3] = std::array::from_fn(|i| [m[i][0], m[i][1], m[i][2]]);
        let is_good = m.as_flattened().iter().fold(determinant(&r) >= 0.0, |good, value| good & is_within(*value));
        let is_good = (0..4).fold(is_good, |good, c| good & (of_last_row(m, c) <= POSE_TOLERANCE));
        if !ROWS.iter().fold(is_good, |good, [i, j]| good & (deviation(&r, *i, *j) <= POSE_TOLERANCE)) {
            return Err(fault(m, &r));
        }
        Ok(Pose { rotation: r, translation: [m[0][3], m[1][3], m[2][3]] })
    }

    /// A pose known to be rigid.
    pub(crate) fn unchecked(rotation: [[f64; 3]; 3], translation: Point) -> Pose {
        Pose { rotation, translation }
    }

    /// The pose after a further translation in the world, metres. Errors as [`new`](Self::new).
    pub fn translated(&self, by: &Point) -> Result<Pose> {
        let translation: Point = std::array::from_fn(|a| self.translation[a] + by[a]);
        match (0..3).find(|a| !translation[*a].is_finite() || translation[*a].abs() > LARGEST_COORDINATE) {
            Some(row) => Err(Error::PoseNotFinite { row, column: 3, value: translation[row] }),
            None => Ok(Pose { translation, ..*self }),
        }
    }

    /// A tool vertex in the world: `((r00*x + r01*y) + r02*z) + tx` and so on, each operation rounded once, no fused
    /// multiply-add. This is the definition the exactness contract refers to.
    #[inline]
    pub fn apply(&self, p: &Point) -> Point {
        let r = &self.rotation;
        let t = &self.translation;
        [
            ((r[0][0] * p[0] + r[0][1] * p[1]) + r[0][2] * p[2]) + t[0],
            ((r[1][0] * p[0] + r[1][1] * p[1]) + r[1][2] * p[2]) + t[1],
            ((r[2][0] * p[0] + r[2][1] * p[1]) + r[2][2] * p[2]) + t[2],
        ]
    }

    /// Three corners in the world.
    #[inline]
    pub fn apply_triangle(&self, t: &Triangle) -> Triangle {
        [self.apply(&t[0]), self.apply(&t[1]), self.apply(&t[2])]
    }

    /// A box in the world around a box of the tool, grown by `margin` (metres) on every side.
    pub(crate) fn apply_box(&self, b: &Aabb, margin: f64) -> Aabb {
        let centre: Point = std::array::from_fn(|a| 0.5 * b.lower[a] + 0.5 * b.upper[a]);
        let half: Point = std::array::from_fn(|a| (b.upper[a] - centre[a]).max(centre[a] - b.lower[a]));
        let c = self.apply(&centre);
        let reach: Point = std::array::from_fn(|i| {
            let r = &self.rotation[i];
            r[0].abs() * half[0] + r[1].abs() * half[1] + r[2].abs() * half[2] + margin
        });
        Aabb { lower: std::array::from_fn(|a| c[a] - reach[a]), upper: std::array::from_fn(|a| c[a] + reach[a]) }
    }

    /// The rotation, row by row.
    pub fn rotation(&self) -> &[[f64; 3]; 3] {
        &self.rotation
    }

    /// The translation, metres.
    pub fn translation(&self) -> &Point {
        &self.translation
    }

    /// The matrix `(4, 4)`, row by row.
    pub fn matrix(&self) -> [[f64; 4]; 4] {
        let row = |i: usize| {
            let [x, y, z] = self.rotation[i];
            [x, y, z, self.translation[i]]
        };
        [row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]]
    }

    /// The largest absolute entry of the translation, metres.
    #[doc(hidden)]
    pub fn largest_translation(&self) -> f64 {
        self.translation.iter().fold(0.0, |m, x| m.max(x.abs()))
    }
}

/// Pairs of rows of a rotation.
const ROWS: [[usize; 2]; 6] = [[0, 0], [1, 0], [1, 1], [2, 0], [2, 1], [2, 2]];

fn is_within(value: f64) -> bool {
    value.abs() <= LARGEST_COORDINATE
}

/// How far a number of the last row is from that of 0, 0, 0, 1.
fn of_last_row(m: &[[f64; 4]; 4], column: usize) -> f64 {
    (m[3][column] - if column == 3 { 1.0 } else { 0.0 }).abs()
}

/// How far two rows are from right angles, or one from length 1.
fn deviation(r: &[[f64; 3]; 3], i: usize, j: usize) -> f64 {
    (dot(r, i, j) - if i == j { 1.0 } else { 0.0 }).abs()
}

fn dot(r: &[[f64; 3]; 3], i: usize, j: usize) -> f64 {
    r[i][0] * r[j][0] + r[i][1] * r[j][1] + r[i][2] * r[j][2]
}

/// A number for a message, to eight significant digits.
fn rounded(value: f64) -> f64 {
    format!("{value:.7e}").parse().unwrap_or(value)
}

fn determinant(r: &[[f64; 3]; 3]) -> f64 {
    r[0][0] * (r[1][1] * r[2][2] - r[1][2] * r[2][1]) - r[0][1] * (r[1][0] * r[2][2] - r[1][2] * r[2][0])
        + r[0][2] * (r[1][0] * r[2][1] - r[1][1] * r[2][0])
}

/// The error of a matrix that is not a pose.
#[cold]
fn fault(m: &[[f64; 4]; 4], r: &[[f64; 3]; 3]) -> Error {
    if let Some(i) = m.as_flattened().iter().position(|value| !is_within(*value)) {
        return Error::PoseNotFinite { row: i / 4, column: i % 4, value: m[i / 4][i % 4] };
    }
    let too_far = |d: f64| d > POSE_TOLERANCE;
    let most = (0..4).map(|c| of_last_row(m, c)).chain(ROWS.map(|[i, j]| deviation(r, i, j))).fold(0.0, f64::max);
    let off = |far: f64| format!("off by {:e}; allowed {POSE_TOLERANCE:e}", rounded(far));
    let mirrors = determinant(r) < 0.0;
    let fault = |why| Error::PoseNotRigid { why, deviation: if mirrors { most.max(2.0) } else { most } };
    if (0..4).any(|c| too_far(of_last_row(m, c))) {
        let is_transposed = (0..4).all(|row| !too_far((m[row][3] - if row == 3 { 1.0 } else { 0.0 }).abs()));
        let hint = if is_transposed { "; it looks transposed, with the translation in the last row" } else { "" };
        return fault(format!("the last row is {:?}, not [0, 0, 0, 1]{hint} (allowed {POSE_TOLERANCE:e})", m[3]));
    }
    let lengths = [0, 1, 2].map(|i| dot(r, i, i).sqrt());
    if let Some(i) = (0..3).find(|i| too_far(deviation(r, *i, *i))) {
        let is_scale = lengths.iter().all(|length| (length - lengths[0]).abs() <= POSE_TOLERANCE * lengths[0]);
        let length = rounded(lengths[i]);
        let square = format!("its square is {}", off(deviation(r, i, i)));
        return fault(match is_scale && lengths[0] > 0.0 {
            true => format!("all rows of the rotation have length {length}, not 1: the pose scales ({square})"),
            false => format!("row {i} of the rotation has length {length}, not 1 ({square})"),
        });
    }
    if let Some([i, j]) = ROWS.into_iter().find(|[i, j]| i != j && too_far(deviation(r, *i, *j))) {
        let degrees = rounded((dot(r, i, j) / (lengths[i] * lengths[j])).acos().to_degrees());
        let product = format!("their product is {}", off(deviation(r, i, j)));
        return fault(format!("rows {j} and {i} of the rotation are {degrees} degrees apart, not 90 ({product})"));
    }
    fault("it mirrors (determinant -1)".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn identity() -> [[f64; 4]; 4] {
        std::array::from_fn(|i| std::array::from_fn(|j| if i == j { 1.0 } else { 0.0 }))
    }

    #[test]
    fn rejects_what_is_not_rigid() {
        assert!(Pose::new(&identity()).is_ok());
        for (row, column, value) in [(0, 0, f64::NAN), (1, 3, f64::INFINITY), (2, 3, 1e101)] {
            let mut m = identity();
            m[row][column] = value;
            assert!(matches!(Pose::new(&m), Err(Error::PoseNotFinite { .. })), "{row} {column} {value}");
        }
        for (row, column, value) in [(0, 0, 1.001), (0, 1, 0.01), (0, 0, -1.0), (3, 0, 0.1), (3, 3, 2.0), (1, 1, 0.0)] {
            let mut m = identity();
            m[row][column] = value;
            assert!(matches!(Pose::new(&m), Err(Error::PoseNotRigid { .. })), "{row} {column} {value}");
        }
    }

    #[test]
    fn says_how_far_from_rigid_a_matrix_is() {
        let fault = |row: usize, column: usize, value| {
            let mut m = identity();
            m[row][column] = value;
            match Pose::new(&m) {
                Err(Error::PoseNotRigid { deviation, .. }) => deviation,
                other => panic!("{other:?}"),
            }
        };
        assert!((fault(0, 0, 1.001) - 0.002001).abs() < 1e-12);
        assert!((fault(0, 1, 0.01) - 0.01).abs() < 1e-12);
        assert_eq!(fault(0, 0, 3.0), 8.0);
        assert_eq!(fault(3, 0, 0.5), 0.5);
        assert_eq!(fault(0, 0, -1.0), 2.0);
    }

    #[test]
    fn accepts_within_tolerance_and_keeps_the_numbers() {
        let mut m = identity();
        m[0][0] = 1.0 + 4e-7;
        let pose = Pose::new(&m).unwrap();
        assert_eq!(pose.apply(&[1.0, 0.0, 0.0])[0], 1.0 + 4e-7);
    }
}
