//! The calibrated estimator: the voxel size that minimises the time this code will take on this machine.
//!
//! The paper's cost function knows means; this one knows the meshes. The tool is put at a few places at the mock-up's surface
//! ([`place`](super::place), [`sample`](super::sample)), and for any voxel size `d` the work of a query follows from the sampled
//! boxes in closed form, averaged over all positions of the grid (integral geometry: a set `K` meets `volume(K + cube) / d^3`
//! voxels on average):
//!
//! - a tool triangle whose box has sides `b` visits `product(1 + b_a / d)` voxels; the paper has `(l/d + 2)^3`;
//! - a mock-up triangle whose box has sides `e` and whose shadows have the areas `s` is listed in
//!   `1 + sum(e_a) / d + sum(s_a) / d^2` voxels;
//! - a tool triangle and a mock-up triangle whose boxes overlap by `o_a` (negative: a gap) share `product(max(0, 1 + o_a / d))`
//!   voxels of their boxes, of which the mock-up triangle is listed in the share that it is listed in of its own box.
//!
//! Two of them are paired at most as often as their boxes share a voxel at all, `product(min(1, 1 + o_a / d))`.
//!
//! The work times the cost of each step on the machine ([`CostConstants`]) is the time. The relative times of the
//! places are averaged ([`balance`](super::sample::balance)): each counts by how much longer a query takes there than
//! at a likely size.

use super::cost_constants::CostConstants;
use super::sample::Sample;
use super::statics::Statics;
use super::work::{listed, work_of, Work};
use crate::index::store::Storage;
use crate::mesh::triangle_mesh::Mesh;
use crate::sizing::cost::{mean_longest_edge, CostFunction, Estimator};

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
            // Nothing fits up to here. The store's own check reports the error.
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
