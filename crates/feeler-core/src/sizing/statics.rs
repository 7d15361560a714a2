//! A sample of the mock-up's triangles.

use rayon::prelude::*;

use super::cost::StaticMeans;
use super::crowd::Measured;
use super::spread::spread;
use crate::geometry::bounds::Aabb;
use crate::mesh::triangle_mesh::Mesh;

/// Of so many mock-up triangles one is looked at: of fewer, a cell of the crowd would hold one of them or none, and the tool
/// would find gaps that are not there.
const STATICS_STRIDE: usize = 16;

/// Least and most that are looked at.
const STATICS: [usize; 2] = [12_500, 200_000];

/// Of these, in a run that is passed over at once.
pub const STATICS_RUN: usize = 32;

/// A part of the mock-up's triangles.
#[derive(Debug)]
pub struct Statics {
    pub triangles: Vec<Measured>,
    /// Boxes around runs of them: neighbours in a file are mostly neighbours in space.
    pub runs: Vec<Aabb>,
    /// How many each stands for.
    pub each: f64,
    /// Their means, which stand for the mock-up's.
    pub means: StaticMeans,
}

impl Statics {
    /// Evenly spread over the mesh.
    pub fn new(mesh: &Mesh) -> Statics {
        let ids = spread(mesh, (mesh.queried_count() / STATICS_STRIDE).clamp(STATICS[0], STATICS[1]));
        let mut triangles = Vec::new();
        ids.par_iter().map(|id| Measured::of(mesh.triangle(*id))).collect_into_vec(&mut triangles);
        let n = triangles.len() as f64;
        let mean = |f: fn(&Measured) -> f64| triangles.iter().map(f).sum::<f64>() / n;
        let around = |run: &[Measured]| run.iter().fold(Aabb::EMPTY, |all, t| all.union(&t.bounds));
        Statics {
            each: mesh.queried_count() as f64 / n,
            means: StaticMeans { area: mean(|t| t.area), edge: mean(|t| t.outline / 3.0) },
            runs: triangles.chunks(STATICS_RUN).map(around).collect(),
            triangles,
        }
    }
}
