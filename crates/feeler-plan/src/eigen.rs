//! Eigenvectors of symmetric matrices.

/// Sweeps of Jacobi's rotations, which converge quadratically: small matrices take six.
const SWEEPS: usize = 16;

/// The eigenvalues of a symmetric matrix, and the unit eigenvector of each as a row; by Jacobi's rotations.
pub fn eigenvectors<const N: usize>(matrix: &[[f64; N]; N]) -> ([f64; N], [[f64; N]; N]) {
    let mut m = *matrix;
    let mut axes: [[f64; N]; N] = std::array::from_fn(|i| std::array::from_fn(|j| f64::from(u8::from(i == j))));
    for _ in 0..SWEEPS {
        for p in 0..N {
            for q in p + 1..N {
                if m[p][q].abs() <= 1e-15 * (m[p][p].abs() + m[q][q].abs()) {
                    continue;
                }
                let theta = (m[q][q] - m[p][p]) / (2.0 * m[p][q]);
                let t = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
                let c = 1.0 / (t * t + 1.0).sqrt();
                let s = t * c;
                for row in &mut m {
                    (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
                }
                for k in 0..N {
                    (m[p][k], m[q][k]) = (c * m[p][k] - s * m[q][k], s * m[p][k] + c * m[q][k]);
                }
                for k in 0..N {
                    (axes[p][k], axes[q][k]) = (c * axes[p][k] - s * axes[q][k], s * axes[p][k] + c * axes[q][k]);
                }
            }
        }
    }
    (std::array::from_fn(|i| m[i][i]), axes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eigenvectors_of_a_known_matrix() {
        let m = [[2.0, 1.0, 0.0, 0.0], [1.0, 2.0, 0.0, 0.0], [0.0, 0.0, 5.0, 0.0], [0.0, 0.0, 0.0, -1.0]];
        let (values, axes) = eigenvectors(&m);
        let mut sorted = values;
        sorted.sort_by(f64::total_cmp);
        assert!(sorted.iter().zip([-1.0, 1.0, 3.0, 5.0]).all(|(a, b)| (a - b).abs() < 1e-12));
        for (value, axis) in values.iter().zip(&axes) {
            for i in 0..4 {
                let image: f64 = (0..4).map(|j| m[i][j] * axis[j]).sum();
                assert!((image - value * axis[i]).abs() < 1e-12);
            }
        }
    }
}
