//! The calibrated estimator: the voxel size that minimises the time this code will take on this machine.
//!
//! The paper's cost function knows means; this one knows the meshes. The tool is put at a few places at the mock-up's surface
//! ([`place`], [`sample`]), and for any voxel size `d` the work of a query follows from the sampled boxes in closed form, averaged over
//! all positions of the grid (integral geometry: a set `K` meets `volume(K + cube) / d^3` voxels on average):
//!
//! - a tool triangle whose box has sides `b` visits `product(1 + b_a / d)` voxels; the paper has `(l/d + 2)^3`;
//! - a mock-up triangle whose box has sides `e` and whose shadows have the areas `s` is listed in
//!   `1 + sum(e_a) / d + sum(s_a) / d^2` voxels;
//! - a tool triangle and a mock-up triangle whose boxes overlap by `o_a` (negative: a gap) share `product(max(0, 1 + o_a / d))`
//!   voxels of their boxes, of which the mock-up triangle is listed in the share that it is listed in of its own box.
//!
//! Two of them are met at most as often as their boxes share a voxel at all, `product(min(1, 1 + o_a / d))`.
//!
//! The work times what each step costs on the machine ([`CostConstants`]) is the time. Of the places it is the relative times that are
//! averaged ([`sample::balance`]): each counts by how much longer a query takes there than at a likely size.

mod crowd;
mod pieces;
mod place;
mod random;
mod sample;
#[cfg(test)]
mod tests;

use crate::cost::{mean_longest_edge, CostFunction, Estimator};
use crate::mesh::Mesh;
use crate::store::Storage;
pub use pieces::{PiecePredictor, PieceWork};
use sample::{Meeting, Sample, Shape, Statics, Visitor};

/// What the steps of a query cost on a machine, seconds each. The core has no clock: whoever has one measures them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CostConstants {
    /// A query, whatever it does.
    pub query: f64,
    /// A tool triangle placed.
    pub tool_triangle: f64,
    /// A voxel visited.
    pub voxel: f64,
    /// A list entry read.
    pub entry: f64,
    /// A pair of triangles met for the first time: remembered, and its boxes compared.
    pub pair: f64,
    /// A pair whose boxes meet: the triangle test.
    pub test: f64,
}

impl Default for CostConstants {
    /// Measured on one machine of 2024; their ratios, which decide the size, differ little on others.
    fn default() -> CostConstants {
        CostConstants {
            query: 1.2e-5,
            tool_triangle: 4.0e-8,
            voxel: 3.0e-9,
            entry: 4.0e-10,
            pair: 9.0e-9,
            test: 3.5e-8,
        }
    }
}

/// The work of one query, on average over the sampled places: see [`Predictor::work`].
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Work {
    /// Tool triangles placed.
    pub tool_triangles: f64,
    /// Voxels visited.
    pub voxels: f64,
    /// List entries read.
    pub entries: f64,
    /// Distinct pairs of triangles among them.
    pub pairs: f64,
    /// Pairs whose boxes meet.
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

/// Predicts the work of queries of a tool in a mock-up for any voxel size.
#[derive(Debug)]
pub struct Predictor {
    sample: Sample,
    tool_triangles: f64,
    /// Sides of the mock-up's box, metres.
    extent: [f64; 3],
    /// Share of the voxel array's memory saved by hashing.
    hashing: f64,
    /// Where the search for the best size begins, metres.
    start: f64,
}

/// The largest size looked at, over the start.
const REACH: f64 = 4.0;

/// The smallest.
const DEPTH: f64 = 1.0 / 32.0;

impl Predictor {
    /// Looks at samples of both meshes: a millisecond or two, ten for a mock-up of a million triangles.
    ///
    /// `storage` is `Dense` or `Hashed`; for `Blocks` the figures are those of `Dense`. `None` for meshes so near the limits
    /// of float64 that the paper's cost function has no optimum either.
    pub fn new(mesh: &Mesh, tool: &Mesh, storage: Storage) -> Option<Predictor> {
        let statics = Statics::new(mesh);
        let start = CostFunction::new(statics.means, mean_longest_edge(tool), Estimator::Area).optimal_size();
        if !(start.is_normal() && (start * start).is_normal()) {
            return None;
        }
        let hashing = if let Storage::Hashed { level } = storage { level } else { 0.0 };
        Some(Predictor {
            sample: Sample::new(&statics, &mesh.bounds(), tool, start, REACH * start),
            tool_triangles: tool.queried_count() as f64,
            extent: mesh.bounds().extent(),
            hashing,
            start,
        })
    }

    /// The work of a query with voxels of `d` metres, on average over the places, each weighted by how short a query is there.
    pub fn work(&self, d: f64) -> Work {
        let Sample { visitors, meetings, .. } = &self.sample;
        // By ascending gap.
        let near = &meetings[..meetings.partition_point(|m| m.gap < d)];
        let mut work = Work { tool_triangles: self.tool_triangles, ..work_of(visitors, near, d) };
        if self.hashing > 0.0 {
            // A slot holds the lists of 1 / (1 - hashing) voxels; the others' lie elsewhere and hold what voxels hold on average.
            let others = 1.0 / (1.0 - self.hashing) - 1.0;
            let strangers = work.voxels * others * self.list_entries(d) / self.voxels(d);
            work.entries += strangers;
            work.pairs += strangers;
        }
        work
    }

    /// Voxels of the whole grid.
    fn voxels(&self, d: f64) -> f64 {
        self.extent.iter().map(|x| (x / d).floor() + 1.0).product()
    }

    /// Entries of all lists.
    fn list_entries(&self, d: f64) -> f64 {
        let Sample { shapes, each_shape, .. } = &self.sample;
        each_shape * shapes.iter().map(|shape| listed(shape, 1.0 / d)).sum::<f64>()
    }

    /// Bytes that the store will take.
    pub fn bytes(&self, d: f64) -> f64 {
        4.0 * (self.voxels(d) * (1.0 - self.hashing) + self.list_entries(d))
    }

    /// The size (metres) with the least predicted time, among those whose store takes at most `limit` bytes (as far as it
    /// is looked: up to four times what the area estimator says).
    pub fn optimal_size(&self, constants: &CostConstants, limit: u64) -> f64 {
        // Steps of a third of an octave; then the lowest point of the parabola through the best and its neighbours.
        let ratio = 2f64.cbrt();
        let size = |step: i32| self.start * ratio.powi(step);
        let seconds = |step: i32| {
            let d = size(step);
            let fits = self.bytes(d) <= limit as f64;
            let time = self.work(d).seconds(constants);
            if fits && time.is_finite() {
                time
            } else {
                f64::INFINITY
            }
        };
        let most = (REACH.log2() * 3.0) as i32;
        let least = (DEPTH.log2() * 3.0) as i32;
        let (mut best, mut time) = (-1, seconds(-1));
        for way in [-1, 1] {
            let mut worse = 0;
            let mut step = best + way;
            while (least..=most).contains(&step) && worse < 2 {
                let here = seconds(step);
                // Too fine to fit: coarser may.
                worse = if here < time || time == f64::INFINITY { 0 } else { worse + 1 };
                if here < time {
                    (best, time) = (step, here);
                }
                step += way;
            }
        }
        if time == f64::INFINITY {
            // Nothing fits up to here. The store's own check says what is too much.
            return size(most);
        }
        let (before, after) = (seconds(best - 1), seconds(best + 1));
        let bend = before + after - 2.0 * time;
        if !(bend.is_finite() && bend > 0.0) || best == most {
            return size(best);
        }
        let shift = (0.5 * (before - after) / bend).clamp(-0.5, 0.5);
        let d = size(best) * ratio.powf(shift);
        if self.bytes(d) <= limit as f64 {
            d
        } else {
            size(best)
        }
    }
}

/// The work with voxels of `d` metres, but for placing the tool. The meetings are nearer than that.
fn work_of(visitors: &[Visitor], meetings: &[Meeting], d: f64) -> Work {
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
fn listed(shape: &Shape, over: f64) -> f64 {
    1.0 + shape.extent.iter().sum::<f64>() * over + shape.shadows * over * over
}

/// Voxels that its box meets.
fn boxed(shape: &Shape, over: f64) -> f64 {
    shape.extent.iter().map(|e| 1.0 + e * over).product()
}
