//! The least-norm point of a polyhedron: the shortest vector under a few linear inequalities in space.

use feeler_core::geometry::bounds::Point;
use feeler_core::geometry::vectors::{add, along, cross, dot, length, scaled};

use crate::constants::{
    LEAST_PAIR_DETERMINANT, LEAST_TRIPLE_DETERMINANT, MIN_NORM_SHORTER, MIN_NORM_SLACK, RELAXATION_ROUNDS,
};

/// The shortest `x` with `n . x >= b` for all `(n, b)`, the `n` unit; and the indices of the active planes, at most three.
/// `None` where no vector satisfies all.
///
/// The least-norm point lies on one, two or three of the planes, so all ones, twos and threes are tried: some five thousand
/// for 32 planes, and no iteration that could stall.
pub(crate) fn min_norm(planes: &[(Point, f64)]) -> Option<(Point, Vec<usize>)> {
    let largest = planes.iter().fold(0.0f64, |m, p| m.max(p.1.abs()));
    let slack = MIN_NORM_SLACK * largest;
    let is_feasible = |x: &Point| planes.iter().all(|(n, b)| dot(n, x) >= b - slack);
    if is_feasible(&[0.0; 3]) {
        return Some(([0.0; 3], Vec::new()));
    }
    let mut best: Option<(Point, Vec<usize>)> = None;
    let mut offer = |x: Point, active: &[usize]| {
        let size = length(&x);
        let shorter = best.as_ref().is_none_or(|(y, _)| size < length(y) * (1.0 - MIN_NORM_SHORTER));
        if size.is_finite() && shorter && is_feasible(&x) {
            best = Some((x, active.to_vec()));
        }
    };
    let n = planes.len();
    for i in 0..n {
        let (p, a) = planes[i];
        offer(scaled(&p, a), &[i]);
        for j in i + 1..n {
            let (q, b) = planes[j];
            // x = s p + t q with p.x = a and q.x = b.
            let c = dot(&p, &q);
            let det = 1.0 - c * c;
            if det < LEAST_PAIR_DETERMINANT {
                continue;
            }
            offer(along(&scaled(&p, (a - c * b) / det), (b - c * a) / det, &q), &[i, j]);
            for k in j + 1..n {
                let (r, e) = planes[k];
                let det = dot(&p, &cross(&q, &r));
                if det.abs() < LEAST_TRIPLE_DETERMINANT {
                    continue;
                }
                let x = add(&scaled(&cross(&q, &r), a), &add(&scaled(&cross(&r, &p), b), &scaled(&cross(&p, &q), e)));
                offer(scaled(&x, 1.0 / det), &[i, j, k]);
            }
        }
    }
    best
}

/// A vector that violates inequalities little, where none satisfies all: projected onto each violated plane in turn (S. Agmon: The
/// relaxation method for linear inequalities, 1954), by a share that shrinks from round to round, since the system is infeasible.
pub(crate) fn relaxed(planes: &[(Point, f64)]) -> Point {
    let mut x = [0.0; 3];
    for round in 0..RELAXATION_ROUNDS {
        let share = 1.0 / (1.0 + f64::from(round));
        for (n, b) in planes {
            let short = b - dot(n, &x);
            if short > 0.0 {
                x = along(&x, share * short, n);
            }
        }
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn corners_and_wedges() {
        let z = ([0.0, 0.0, 1.0], 1.5);
        assert_eq!(min_norm(&[z]).unwrap(), ([0.0, 0.0, 1.5], vec![0]));
        let x = ([1.0, 0.0, 0.0], 1.0);
        assert_eq!(min_norm(&[z, x]).unwrap().0, [1.0, 0.0, 1.5]);
        assert!(min_norm(&[x, ([-1.0, 0.0, 0.0], 0.1)]).is_none());
        let y = relaxed(&[x, ([-1.0, 0.0, 0.0], 0.1)]);
        assert!((0.0..=1.0).contains(&y[0]));
    }

    proptest! {
        #[test]
        fn no_sampled_vector_is_shorter(
            normals in prop::collection::vec((prop::array::uniform3(-1.0f64..1.0), -0.5f64..1.0), 1..7),
            trials in prop::collection::vec(prop::array::uniform3(-2.0f64..2.0), 200),
        ) {
            let planes: Vec<(Point, f64)> = normals
                .iter()
                .filter(|(n, _)| length(n) > 0.1)
                .map(|(n, b)| (scaled(n, 1.0 / length(n)), *b))
                .collect();
            let found = min_norm(&planes);
            let least = found.as_ref().map_or(f64::INFINITY, |f| length(&f.0));
            for x in &trials {
                if planes.iter().all(|(n, b)| dot(n, x) >= *b) {
                    prop_assert!(length(x) >= least - 1e-6, "{x:?} beats {found:?}");
                }
            }
            if let Some((x, active)) = found {
                prop_assert!(planes.iter().all(|(n, b)| dot(n, &x) >= b - 1e-8));
                prop_assert!(active.len() <= 3);
            }
        }
    }
}
