//! The work of a query in closed form.

use super::cost_constants::CostConstants;
use crate::geometry::bounds::{Aabb, Point, Triangle};

/// The work of one query, on average over the sampled places: see [`Predictor::work`](crate::Predictor::work).
#[derive(Debug, Clone, Copy, Default, PartialEq)]
#[non_exhaustive]
pub struct Work {
    /// Tool triangles placed.
    pub tool_triangles: f64,
    /// Voxels visited.
    pub voxels: f64,
    /// List entries read.
    pub entries: f64,
    /// Distinct pairs of triangles among them.
    pub pairs: f64,
    /// Pairs with overlapping boxes.
    pub tests: f64,
}

impl Work {
    /// Its time, seconds.
    pub fn seconds(&self, constants: &CostConstants) -> f64 {
        constants.query
            + constants.tool_triangle * self.tool_triangles
            + constants.voxel * self.voxels
            + constants.entry * self.entries
            + constants.pair * self.pairs
            + constants.test * self.tests
    }
}

/// The box of a tool triangle at a place, cut to the mock-up's box.
#[derive(Debug, Clone, Copy)]
pub struct Visitor {
    pub extent: Point,
    /// How many tool triangles of a pose it stands for.
    pub weight: f64,
}

/// A tool triangle at a place and a mock-up triangle near it.
#[derive(Debug, Clone, Copy)]
pub struct Meeting {
    /// By how much the two boxes overlap along each axis, metres; negative: the gap between them.
    pub overlap: Point,
    pub shape: Shape,
    /// How many pairs of a pose it stands for.
    pub weight: f64,
    /// The largest gap, metres; 0 if the boxes overlap.
    pub gap: f64,
}

/// The measures that decide how many voxels a triangle overlaps.
#[derive(Debug, Clone, Copy)]
pub struct Shape {
    /// Sides of its box, metres.
    pub extent: Point,
    /// Sum of the areas of its three shadows along the axes, square metres.
    pub shadows: f64,
}

impl Shape {
    /// Of a triangle.
    pub fn of(t: &Triangle) -> Shape {
        let shadow = |u: usize, v: usize| {
            0.5 * ((t[1][u] - t[0][u]) * (t[2][v] - t[0][v]) - (t[1][v] - t[0][v]) * (t[2][u] - t[0][u])).abs()
        };
        Shape { extent: Aabb::of_triangle(t).extent(), shadows: shadow(0, 1) + shadow(1, 2) + shadow(2, 0) }
    }
}

/// The work with voxels of `d` metres, but for placing the tool. The meetings are nearer than that.
pub fn work_of(visitors: &[Visitor], meetings: &[Meeting], d: f64) -> Work {
    let over = 1.0 / d;
    let mut work = Work::default();
    for v in visitors {
        work.voxels += v.weight * v.extent.iter().map(|b| 1.0 + b * over).product::<f64>();
    }
    for m in meetings {
        let along = m.overlap.map(|o| (1.0 + o * over).max(0.0));
        let shared = along.iter().product::<f64>() * (listed(&m.shape, over) / boxed(&m.shape, over));
        // They can be met only where the boxes share a voxel at all.
        let met = m.weight * shared.min(along.iter().map(|x| x.min(1.0)).product());
        work.entries += m.weight * shared;
        work.pairs += met;
        work.tests += if m.gap == 0.0 { met } else { 0.0 };
    }
    work
}

/// Voxels that list a triangle: see the module.
pub fn listed(shape: &Shape, over: f64) -> f64 {
    1.0 + shape.extent.iter().sum::<f64>() * over + shape.shadows * over * over
}

/// Voxels that its box overlaps.
pub fn boxed(shape: &Shape, over: f64) -> f64 {
    shape.extent.iter().map(|e| 1.0 + e * over).product()
}
