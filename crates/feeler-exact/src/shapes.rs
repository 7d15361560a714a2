//! Solids as triangles, and poses that bring them together: made with exact or correctly rounded operations only, so
//! that every machine gets the same numbers.

use feeler_core::{Point, Pose, Triangle};

use crate::random::Random;

/// Sine and cosine of `turns` full turns (0 to 1), good to a few last bits, by the Taylor series of an eighth of a turn.
pub fn sin_cos(turns: f64) -> (f64, f64) {
    let eighths = (turns * 8.0 + 0.5).floor();
    let x = (turns - eighths / 8.0) * std::f64::consts::TAU;
    let series = |first: f64, from: f64| {
        let (mut sum, mut term, mut n) = (first, first, from);
        for _ in 0..10 {
            term *= -x * x / ((n + 1.0) * (n + 2.0));
            sum += term;
            n += 2.0;
        }
        sum
    };
    let (s, c) = (series(x, 1.0), series(1.0, 0.0));
    let h = std::f64::consts::FRAC_1_SQRT_2;
    match eighths as u32 % 8 {
        0 => (s, c),
        1 => (h * (c + s), h * (c - s)),
        2 => (c, -s),
        3 => (h * (c - s), -h * (c + s)),
        4 => (-s, -c),
        5 => (-h * (c + s), h * (s - c)),
        6 => (-c, s),
        _ => (h * (s - c), h * (s + c)),
    }
}

/// A point of a profile, metres.
pub type Flat = [f64; 2];

/// A regular polygon with `n` corners, the first on the x axis.
pub fn circle(n: usize, radius: f64) -> Vec<Flat> {
    let at = |i: usize| sin_cos(i as f64 / n as f64);
    (0..n).map(|i| [radius * at(i).1, radius * at(i).0]).collect()
}

/// The outline of a gear: each tooth four points, so that a half step turns teeth into gaps.
pub fn gear(teeth: usize, root: f64, tip: f64) -> Vec<Flat> {
    let n = 4 * teeth;
    (0..n)
        .map(|i| {
            let (s, c) = sin_cos(i as f64 / n as f64);
            let r = if i % 4 < 2 { tip } else { root };
            [r * c, r * s]
        })
        .collect()
}

/// A closed solid between two heights: around the z axis, with a hole when there is an inner outline. Both outlines have as
/// many points.
pub fn tube(outer: &[Flat], inner: Option<&[Flat]>, low: f64, high: f64) -> Vec<Triangle> {
    let n = outer.len();
    let at = |p: Flat, z: f64| -> Point { [p[0], p[1], z] };
    let mut triangles = Vec::new();
    let mut quad = |a: Point, b: Point, c: Point, d: Point| triangles.extend([[a, b, c], [a, c, d]]);
    for i in 0..n {
        let (p, q) = (outer[i], outer[(i + 1) % n]);
        quad(at(p, low), at(q, low), at(q, high), at(p, high));
        if let Some(inner) = inner {
            let (r, s) = (inner[i], inner[(i + 1) % n]);
            quad(at(s, low), at(r, low), at(r, high), at(s, high));
            quad(at(p, high), at(q, high), at(s, high), at(r, high));
            quad(at(q, low), at(p, low), at(r, low), at(s, low));
        }
    }
    if inner.is_none() {
        for i in 1..n - 1 {
            triangles.push([at(outer[0], high), at(outer[i], high), at(outer[i + 1], high)]);
            triangles.push([at(outer[0], low), at(outer[i + 1], low), at(outer[i], low)]);
        }
    }
    triangles
}

/// A box between two corners, 12 triangles.
pub fn cuboid(low: Point, high: Point) -> Vec<Triangle> {
    let square = [[low[0], low[1]], [high[0], low[1]], [high[0], high[1]], [low[0], high[1]]];
    tube(&square, None, low[2], high[2])
}

/// A flat sheet `z = 0` of `n` by `m` cells over `[0, width] x [0, height]`, two triangles a cell.
pub fn sheet(n: usize, m: usize, width: f64, height: f64) -> Vec<Triangle> {
    let at = |i: usize, j: usize| -> Point { [width * i as f64 / n as f64, height * j as f64 / m as f64, 0.0] };
    let mut triangles = Vec::new();
    for i in 0..n {
        for j in 0..m {
            triangles.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
            triangles.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }
    triangles
}

/// A rotation and a translation, row-major, composed with rounding like anybody's code.
#[derive(Debug, Clone, Copy)]
pub struct Motion {
    /// Rows of the rotation.
    pub rotation: [Point; 3],
    /// Metres.
    pub translation: Point,
}

impl Motion {
    /// No motion.
    pub const NONE: Motion =
        Motion { rotation: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], translation: [0.0; 3] };

    /// Only a translation, metres.
    pub fn shift(translation: Point) -> Motion {
        Motion { translation, ..Motion::NONE }
    }

    /// About the z axis.
    pub fn about_z(turns: f64) -> Motion {
        let (s, c) = sin_cos(turns);
        Motion { rotation: [[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]], ..Motion::NONE }
    }

    /// Any rotation, and a translation within `reach` metres.
    pub fn random(r: &mut Random, reach: f64) -> Motion {
        let [w, x, y, z] = loop {
            let q: [f64; 4] = std::array::from_fn(|_| r.real(-1.0, 1.0));
            let length = q.iter().map(|x| x * x).sum::<f64>().sqrt();
            if (0.1..1.0).contains(&length) {
                break q.map(|x| x / length);
            }
        };
        Motion {
            rotation: [
                [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)],
                [2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)],
                [2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)],
            ],
            translation: r.point(-reach, reach),
        }
    }

    /// First `other`, then this one.
    pub fn after(&self, other: &Motion) -> Motion {
        let column = |j: usize| -> Point { [other.rotation[0][j], other.rotation[1][j], other.rotation[2][j]] };
        let dot = |a: &Point, b: &Point| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        Motion {
            rotation: [0, 1, 2].map(|i| [0, 1, 2].map(|j| dot(&self.rotation[i], &column(j)))),
            translation: [0, 1, 2].map(|i| dot(&self.rotation[i], &other.translation) + self.translation[i]),
        }
    }

    /// The way back, up to rounding.
    pub fn inverse(&self) -> Motion {
        let rotation = [0, 1, 2].map(|i| [0, 1, 2].map(|j| self.rotation[j][i]));
        let back = Motion { rotation, translation: [0.0; 3] };
        Motion { rotation, translation: back.after(&Motion::shift(self.translation)).translation.map(|x| -x) }
    }

    /// As a pose of the core.
    ///
    /// # Panics
    /// When it is not rigid, which no composition of these comes near.
    pub fn pose(&self) -> Pose {
        let row = |i: usize| {
            let [a, b, c] = self.rotation[i];
            [a, b, c, self.translation[i]]
        };
        Pose::new(&[row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]]).expect("a rotation and a finite translation")
    }

    /// The triangles where this brings them, as the core computes it.
    pub fn applied(&self, triangles: &[Triangle]) -> Vec<Triangle> {
        let pose = self.pose();
        triangles.iter().map(|t| pose.apply_triangle(t)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sine_and_cosine_are_good_all_around() {
        for i in 0..=1000 {
            let turns = f64::from(i) / 1000.0;
            let (s, c) = sin_cos(turns);
            let (t, d) = (turns * std::f64::consts::TAU).sin_cos();
            assert!((s - t).abs() < 1e-15 && (c - d).abs() < 1e-15, "{turns}: {s} {t} {c} {d}");
        }
    }

    #[test]
    fn a_motion_and_its_inverse_cancel() {
        let mut r = Random::new(1);
        for _ in 0..100 {
            let m = Motion::random(&mut r, 3.0);
            let p = m.after(&m.inverse()).pose().apply(&[1.0, 2.0, 3.0]);
            assert!((0..3).all(|a| (p[a] - [1.0, 2.0, 3.0][a]).abs() < 1e-14), "{p:?}");
        }
    }

    #[test]
    fn solids_are_closed() {
        for solid in [
            cuboid([0.0; 3], [1.0, 2.0, 3.0]),
            tube(&circle(8, 2.0), Some(&circle(8, 1.0)), 0.0, 1.0),
            tube(&gear(5, 1.0, 1.3), None, 0.0, 1.0),
        ] {
            let mut edges = std::collections::HashMap::new();
            for t in &solid {
                for i in 0..3 {
                    let key = |p: Point| p.map(|x| (x + 0.0).to_bits());
                    *edges.entry((key(t[i]), key(t[(i + 1) % 3]))).or_insert(0) += 1;
                }
            }
            assert!(edges.iter().all(|((a, b), n)| *n == 1 && edges.get(&(*b, *a)) == Some(&1)));
        }
    }
}
