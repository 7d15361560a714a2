//! Meshes and poses for the tests of the index: made from a seed, the same on every run and machine.

#![allow(dead_code, reason = "each test binary uses its own share of these helpers")]

pub mod cases;

use std::sync::Arc;

use feeler_core::{Mockup, Point, Pose, Storage, Tool, Triangle};

/// Vertices and faces.
pub type Arrays = (Vec<Point>, Vec<[u32; 3]>);

/// All stores, the hashed one at three levels.
pub const STORAGES: [Storage; 5] = [
    Storage::Blocks,
    Storage::Dense,
    Storage::Hashed { level: 0.0 },
    Storage::Hashed { level: 0.5 },
    Storage::Hashed { level: 0.99 },
];

/// SplitMix64: small, and the same everywhere.
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Random {
        Random(seed.wrapping_mul(0x2545_f491_4f6c_dd1d) ^ 0x9e37_79b9_7f4a_7c15)
    }

    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ z >> 31
    }

    /// In [low, high).
    pub fn real(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * ((self.bits() >> 11) as f64 / (1u64 << 53) as f64)
    }

    /// In 0..n.
    pub fn below(&mut self, n: u64) -> u64 {
        self.bits() % n
    }

    pub fn point(&mut self, low: f64, high: f64) -> Point {
        std::array::from_fn(|_| self.real(low, high))
    }

    /// A rotation about a random axis, and a translation within `reach` metres.
    pub fn pose(&mut self, reach: f64) -> Pose {
        let q: [f64; 4] = loop {
            let q: [f64; 4] = std::array::from_fn(|_| self.real(-1.0, 1.0));
            let length = q.iter().map(|x| x * x).sum::<f64>().sqrt();
            if (0.1..1.0).contains(&length) {
                break q.map(|x| x / length);
            }
        };
        let [w, x, y, z] = q;
        let t = self.point(-reach, reach);
        Pose::new(&[
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w), t[0]],
            [2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w), t[1]],
            [2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y), t[2]],
            [0.0, 0.0, 0.0, 1.0],
        ])
        .unwrap()
    }

    /// Axes permuted and turned by right angles, and a whole translation: nothing rounds.
    pub fn lattice_pose(&mut self, reach: i64) -> Pose {
        let whole = |r: &mut Random| r.below(2 * reach as u64 + 1) as f64 - reach as f64;
        let (a, b) = ([1.0, -1.0][self.below(2) as usize], [1.0, -1.0][self.below(2) as usize]);
        let c = a * b;
        let rows = match self.below(3) {
            0 => [[a, 0.0, 0.0], [0.0, b, 0.0], [0.0, 0.0, c]],
            1 => [[0.0, a, 0.0], [0.0, 0.0, b], [c, 0.0, 0.0]],
            _ => [[0.0, 0.0, a], [b, 0.0, 0.0], [0.0, c, 0.0]],
        };
        let mut m = [[0.0, 0.0, 0.0, 0.0], [0.0; 4], [0.0; 4], [0.0, 0.0, 0.0, 1.0]];
        for i in 0..3 {
            m[i] = [rows[i][0], rows[i][1], rows[i][2], whole(self)];
        }
        Pose::new(&m).unwrap()
    }
}

/// A pose that only moves.
pub fn moved([x, y, z]: Point) -> Pose {
    Pose::new(&[[1.0, 0.0, 0.0, x], [0.0, 1.0, 0.0, y], [0.0, 0.0, 1.0, z], [0.0, 0.0, 0.0, 1.0]]).unwrap()
}

/// Unconnected triangles as arrays.
pub fn arrays_of(triangles: impl IntoIterator<Item = Triangle>) -> Arrays {
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

/// Triangles with corners on whole numbers 0 to `side`, some of them without area: they touch and lie flush everywhere.
pub fn lattice(seed: u64, count: usize, side: u64) -> Arrays {
    let mut r = Random::new(seed);
    arrays_of((0..count).map(|i| {
        let c: Point = std::array::from_fn(|_| r.below(side + 1) as f64);
        let mut t: Triangle =
            std::array::from_fn(|_| std::array::from_fn(|a| (c[a] + r.below(3) as f64).min(side as f64)));
        if i % 2 == 0 {
            // In a plane of whole numbers, where most of CAD happens.
            t.iter_mut().for_each(|p| p[i % 3] = c[i % 3]);
        }
        t
    }))
}

/// A closed ball of about `2 rings^2` triangles, connected, centred on the origin.
pub fn ball(rings: u32, radius: f64) -> Arrays {
    let n = 2 * rings;
    let mut vertices = vec![[0.0, 0.0, radius], [0.0, 0.0, -radius]];
    for i in 1..rings {
        let (s, c) = (std::f64::consts::PI * f64::from(i) / f64::from(rings)).sin_cos();
        vertices.extend((0..n).map(|j| {
            let (t, u) = (std::f64::consts::TAU * f64::from(j) / f64::from(n)).sin_cos();
            [radius * s * u, radius * s * t, radius * c]
        }));
    }
    let at = |i: u32, j: u32| 2 + (i - 1) * n + j % n;
    let mut faces = Vec::new();
    for j in 0..n {
        faces.push([0, at(1, j), at(1, j + 1)]);
        faces.push([1, at(rings - 1, j + 1), at(rings - 1, j)]);
        for i in 1..rings - 1 {
            faces.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
            faces.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }
    (vertices, faces)
}

/// Every coordinate times `scale` plus `offset`.
pub fn placed((vertices, faces): Arrays, scale: f64, offset: f64) -> Arrays {
    (vertices.into_iter().map(|p| p.map(|x| x * scale + offset)).collect(), faces)
}

/// The same triangles with every kind of defect strewn among them.
pub fn with_defects((mut vertices, faces): Arrays) -> Arrays {
    let from = vertices.len() as u32;
    vertices.extend([
        [f64::NAN, 0.5, 0.5],
        [0.5, f64::INFINITY, 0.5],
        [1e101, 0.0, 0.0],
        [0.5; 3],
        [0.25; 3],
        [0.75; 3],
    ]);
    let bad = [
        [0, 1, from],
        [from + 1, 0, 1],
        [from + 2, 2, 1],
        [from + 3, from + 4, from + 5],
        [0, 0, 1],
        [0, 1, u32::MAX],
        [2, from + 6, 1],
    ];
    let mut mixed = Vec::new();
    for (i, face) in faces.iter().enumerate() {
        mixed.push(*face);
        if i % 5 == 0 {
            mixed.push(bad[i / 5 % bad.len()]);
        }
        if i % 17 == 0 {
            mixed.push([face[1], face[2], face[0]]); // a duplicate is queried like any other
        }
    }
    (vertices, mixed)
}

pub fn mockup_of((vertices, faces): Arrays) -> Arc<Mockup> {
    Arc::new(Mockup::new(vertices, faces, Vec::new(), 1).unwrap())
}

pub fn tool_of((vertices, faces): Arrays) -> Tool {
    Tool::new(vertices, faces).unwrap()
}
