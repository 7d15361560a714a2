//! Unconnected triangles.

use crate::random::Random;
use crate::{Arrays, Point};

/// Unconnected triangles as arrays.
pub fn arrays_of(triangles: impl IntoIterator<Item = [Point; 3]>) -> Arrays {
    let vertices: Vec<Point> = triangles.into_iter().flatten().collect();
    let faces = (0..vertices.len() as u32 / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    (vertices, faces)
}

/// Random triangles of about `size` metres in the unit cube.
pub fn soup(seed: u64, count: usize, size: f64) -> Arrays {
    let mut r = Random::new(seed);
    arrays_of((0..count).map(|_| {
        let c = r.point(0.0, 1.0);
        std::array::from_fn(|_| {
            let d = r.point(-size, size);
            std::array::from_fn(|a| c[a] + d[a])
        })
    }))
}

/// Needles and caps: as long as the unit cube, `width` metres wide; every third one along an axis.
pub fn needles(seed: u64, count: usize, width: f64) -> Arrays {
    let mut r = Random::new(seed);
    arrays_of((0..count).map(|i| {
        let (a, mut b) = (r.point(0.0, 1.0), r.point(0.0, 1.0));
        if i % 3 == 0 {
            b = a;
            b[i % 2] += 0.7;
        }
        let (share, d) = (r.real(0.0, 1.0), r.point(-width, width));
        [a, b, std::array::from_fn(|k| a[k] + share * (b[k] - a[k]) + d[k])]
    }))
}

/// [Point; 3]s with corners on whole numbers 0 to `side`, some of them without area: they touch and lie flush everywhere.
pub fn lattice(seed: u64, count: usize, side: u64) -> Arrays {
    let mut r = Random::new(seed);
    arrays_of((0..count).map(|i| {
        let c: Point = std::array::from_fn(|_| r.below(side + 1) as f64);
        let mut t: [Point; 3] =
            std::array::from_fn(|_| std::array::from_fn(|a| (c[a] + r.below(3) as f64).min(side as f64)));
        if i % 2 == 0 {
            // In a plane of whole numbers, where most of CAD happens.
            t.iter_mut().for_each(|p| p[i % 3] = c[i % 3]);
        }
        t
    }))
}
