//! The shortest vector that satisfies a few linear inequalities in space.

use feeler_core::geometry::bounds::Point;
use feeler_core::geometry::vectors::{add, along, cross, dot, length, scaled};

/// The shortest `x` with `n . x >= b` for all `(n, b)`, the `n` unit; and the places of those that hold it, at most three.
/// `None` where none satisfies all.
///
/// The shortest vector is held by one, two or three of the planes, so all ones, twos and threes are tried: some five thousand
/// for 32 planes, and no iteration that could stall.
pub(crate) fn shortest(planes: &[(Point, f64)]) -> Option<(Point, Vec<usize>)> {
    let largest = planes.iter().fold(0.0f64, |m, p| m.max(p.1.abs()));
    let slack = 1e-9 * largest;
    let holds = |x: &Point| planes.iter().all(|(n, b)| dot(n, x) >= b - slack);
    if holds(&[0.0; 3]) {
        return Some(([0.0; 3], Vec::new()));
    }
    let mut best: Option<(Point, Vec<usize>)> = None;
    let mut offer = |x: Point, held: &[usize]| {
        let size = length(&x);
        let shorter = best.as_ref().is_none_or(|(y, _)| size < length(y) * (1.0 - 1e-12));
        if size.is_finite() && shorter && holds(&x) {
            best = Some((x, held.to_vec()));
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
            if det < 1e-9 {
                continue;
            }
            offer(along(&scaled(&p, (a - c * b) / det), (b - c * a) / det, &q), &[i, j]);
            for k in j + 1..n {
                let (r, e) = planes[k];
                let det = dot(&p, &cross(&q, &r));
                if det.abs() < 1e-6 {
                    continue;
                }
                let x = add(&scaled(&cross(&q, &r), a), &add(&scaled(&cross(&r, &p), b), &scaled(&cross(&p, &q), e)));
                offer(scaled(&x, 1.0 / det), &[i, j, k]);
            }
        }
    }
    best
}

/// A vector that violates the inequalities little, where no vector satisfies all: each in turn is moved onto, ever less.
pub(crate) fn compromise(planes: &[(Point, f64)]) -> Point {
    let mut x = [0.0; 3];
    for round in 0..64 {
        let relax = 1.0 / (1.0 + f64::from(round));
        for (n, b) in planes {
            let short = b - dot(n, &x);
            if short > 0.0 {
                x = along(&x, relax * short, n);
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
        assert_eq!(shortest(&[z]).unwrap(), ([0.0, 0.0, 1.5], vec![0]));
        let x = ([1.0, 0.0, 0.0], 1.0);
        assert_eq!(shortest(&[z, x]).unwrap().0, [1.0, 0.0, 1.5]);
        assert!(shortest(&[x, ([-1.0, 0.0, 0.0], 0.1)]).is_none());
        let y = compromise(&[x, ([-1.0, 0.0, 0.0], 0.1)]);
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
            let found = shortest(&planes);
            let least = found.as_ref().map_or(f64::INFINITY, |f| length(&f.0));
            for x in &trials {
                if planes.iter().all(|(n, b)| dot(n, x) >= *b) {
                    prop_assert!(length(x) >= least - 1e-6, "{x:?} beats {found:?}");
                }
            }
            if let Some((x, held)) = found {
                prop_assert!(planes.iter().all(|(n, b)| dot(n, &x) >= b - 1e-8));
                prop_assert!(held.len() <= 3);
            }
        }
    }
}
