//! Meshes and poses for the tests of the index: made from a seed, the same on every run and machine.

#![allow(dead_code, unused_imports, reason = "each test binary uses its own share of these helpers")]

pub mod cases;

use std::sync::Arc;

use feeler_core::{Mockup, Point, Pose, Storage, Tool};
pub use feeler_shapes::random::Random;
pub use feeler_shapes::soups::{arrays_of, lattice, needles, soup};
pub use feeler_shapes::Arrays;

/// All stores, the hashed one at three levels.
pub const STORAGES: [Storage; 5] = [
    Storage::Blocks,
    Storage::Dense,
    Storage::Hashed { level: 0.0 },
    Storage::Hashed { level: 0.5 },
    Storage::Hashed { level: 0.99 },
];

/// Random motions as poses.
pub trait Poses {
    /// See [`Random::motion`].
    fn pose(&mut self, reach: f64) -> Pose;

    /// See [`Random::lattice_motion`].
    fn lattice_pose(&mut self, reach: i64) -> Pose;
}

impl Poses for Random {
    fn pose(&mut self, reach: f64) -> Pose {
        Pose::new(&self.motion(reach)).unwrap()
    }

    fn lattice_pose(&mut self, reach: i64) -> Pose {
        Pose::new(&self.lattice_motion(reach)).unwrap()
    }
}

/// A pose that only moves.
pub fn moved([x, y, z]: Point) -> Pose {
    Pose::new(&[[1.0, 0.0, 0.0, x], [0.0, 1.0, 0.0, y], [0.0, 0.0, 1.0, z], [0.0, 0.0, 0.0, 1.0]]).unwrap()
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
