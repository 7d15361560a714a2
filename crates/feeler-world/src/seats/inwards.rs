//! The way of a corner that moves inwards with all faces at it.

use feeler_core::geometry::vectors::{add, cross, dot, scaled};
use feeler_core::Point;

use crate::constants::MITRE_ADDED;

/// The shortest vector with given components along normals, or as nearly as can be.
pub fn inwards(faces: &[(Point, f64)]) -> Point {
    // Regularized least squares: flat corners would make the system singular. A second step on the residual removes the bias.
    let rows: [Point; 3] = std::array::from_fn(|i| {
        std::array::from_fn(|j| {
            faces.iter().map(|(n, _)| n[i] * n[j]).sum::<f64>() + if i == j { MITRE_ADDED } else { 0.0 }
        })
    });
    let determinant = dot(&rows[0], &cross(&rows[1], &rows[2]));
    let step = |from: &Point| -> Point {
        let left = |(n, by): &(Point, f64)| scaled(n, by - dot(n, from));
        let sum = faces.iter().map(left).fold([0.0; 3], |sum, n| add(&sum, &n));
        let with = |at: usize| {
            let column = |k: usize| rows.map(|row| row[k]);
            let columns: [Point; 3] = std::array::from_fn(|k| if k == at { sum } else { column(k) });
            dot(&columns[0], &cross(&columns[1], &columns[2])) / determinant
        };
        add(from, &std::array::from_fn(with))
    };
    let moved = step(&step(&[0.0; 3]));
    if moved.iter().all(|x| x.is_finite()) {
        moved
    } else {
        [0.0; 3]
    }
}
