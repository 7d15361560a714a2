//! The optimal voxel size of the paper: D. Borro, A. García-Alonso and L. Matey, *Approximation of Optimal Voxel Size for
//! Collision Detection in Maintainability Simulations within Massive Virtual Environments*, Computer Graphics Forum 23(1),
//! 2004, equations 3 to 11.

use rayon::prelude::*;

use super::cost_constants::CostConstants;
use crate::constants::{NO_COLLISION_PROBABILITY, TEST_TO_VISIT_RATIO};
use crate::mesh::pieces::{edge_lengths, longest_edge, twice_area};
use crate::mesh::triangle_mesh::Mesh;

/// How the static triangles per voxel are estimated: the paper's three ways (equations 8 to 10), and a prediction.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Estimator {
    /// From the mean area `As` of a static triangle: `fs = sqrt(3) d^2 / (2 As)`.
    Area,
    /// From the voxel's diagonal and the mean edge `Es` of a static triangle: `fs = sqrt(3) d / Es`.
    Diagonal,
    /// From the voxel's sides: `fs = (dx + dy + dz) / (3 Es) = d / Es`.
    Side,
    /// Not the paper's: predicted from samples of both meshes and what each step costs, by a [`Predictor`](crate::Predictor).
    Calibrated(CostConstants),
}

/// The mean figures of a static mesh that the cost function knows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct StaticMeans {
    /// Mean triangle area, square metres.
    pub area: f64,
    /// Mean edge length, metres.
    pub edge: f64,
}

/// The cost function `z(d)` for one pair of mock-up and tool.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct CostFunction {
    /// Mean over the tool's triangles of each one's longest edge, metres (the paper's `l`).
    pub tool_edge: f64,
    /// `fs(d) = density * d^power`: static triangles per voxel.
    density: f64,
    power: i32,
}

/// Mean area and mean edge of the queried triangles.
pub(crate) fn static_means(mesh: &Mesh) -> StaticMeans {
    // Sums of fixed runs of triangles, added up in order: the same for any number of threads.
    const MEANS_RUN: u32 = 4096;
    let count = mesh.faces().len() as u32;
    let sums: Vec<(f64, f64)> = (0..count.div_ceil(MEANS_RUN))
        .into_par_iter()
        .map(|run| {
            let ids =
                (run * MEANS_RUN..count.min((run + 1).saturating_mul(MEANS_RUN))).filter(|id| mesh.is_queried(*id));
            ids.fold((0.0, 0.0), |(area, edge), id| {
                let t = mesh.triangle(id);
                (area + 0.5 * twice_area(&t), edge + edge_lengths(&t).iter().sum::<f64>() / 3.0)
            })
        })
        .collect();
    let (area, edge) = sums.into_iter().fold((0.0, 0.0), |s, x| (s.0 + x.0, s.1 + x.1));
    let n = mesh.queried_count() as f64;
    StaticMeans { area: area / n, edge: edge / n }
}

/// Mean over the queried triangles of each one's longest edge, metres.
pub(crate) fn mean_longest_edge(mesh: &Mesh) -> f64 {
    mesh.queried().map(|id| longest_edge(&mesh.triangle(id))).sum::<f64>() / mesh.queried_count() as f64
}

impl CostFunction {
    /// The cost function for a mock-up with the given means and a tool with the given mean longest edge.
    pub(crate) fn new(statics: StaticMeans, tool_edge: f64, estimator: Estimator) -> CostFunction {
        let (density, power) = match estimator {
            Estimator::Area | Estimator::Calibrated(_) => (3f64.sqrt() / (2.0 * statics.area), 2),
            Estimator::Diagonal => (3f64.sqrt() / statics.edge, 1),
            Estimator::Side => (1.0 / statics.edge, 1),
        };
        CostFunction { tool_edge, density, power }
    }

    /// The voxel size (metres) where `dz/dd = 0`.
    ///
    /// With `fs = f d^p`, `A = pnc` and `B = (1 - pnc) rt f` the condition is `B p d^p (l + 2 d) = 3 l (A + B d^p)`. Its left
    /// side minus its right is negative at 0 and grows without bound, with one sign change; found by bisection.
    pub(crate) fn optimal_size(&self) -> f64 {
        let (a, b) = (NO_COLLISION_PROBABILITY, (1.0 - NO_COLLISION_PROBABILITY) * TEST_TO_VISIT_RATIO * self.density);
        let (l, p) = (self.tool_edge, self.power);
        let slope = |d: f64| {
            let bd = b * d.powi(p);
            bd * f64::from(p) * (l + 2.0 * d) - 3.0 * l * (a + bd)
        };
        let (mut low, mut high) = (l, l);
        // A mesh at the edge of float64 can make the condition NaN; the loops below end all the same.
        for _ in 0..2000 {
            if slope(low) > 0.0 {
                low *= 0.5;
            } else if slope(high) < 0.0 {
                high *= 2.0;
            } else {
                break;
            }
        }
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            if slope(middle) < 0.0 {
                low = middle;
            } else {
                high = middle;
            }
        }
        0.5 * (low + high)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    impl CostFunction {
        /// `z(d) = pnc vo + (1 - pnc) vo fs rt` with `vo = (l/d + 2)^3`, in units of a voxel visit.
        fn cost(&self, d: f64) -> f64 {
            let (pnc, vo) = (NO_COLLISION_PROBABILITY, (self.tool_edge / d + 2.0).powi(3));
            pnc * vo + (1.0 - pnc) * vo * self.density * d.powi(self.power) * TEST_TO_VISIT_RATIO
        }
    }

    #[test]
    fn the_optimum_is_the_minimum_of_the_cost() {
        let statics = StaticMeans { area: 4e-5, edge: 0.012 };
        for estimator in [Estimator::Area, Estimator::Diagonal, Estimator::Side] {
            for tool_edge in [1e-4, 0.01, 0.3] {
                let z = CostFunction::new(statics, tool_edge, estimator);
                let d = z.optimal_size();
                for factor in [0.5, 0.9, 0.99, 1.01, 1.1, 2.0] {
                    assert!(z.cost(d) <= z.cost(d * factor), "{estimator:?} {tool_edge} {factor}");
                }
            }
        }
    }

    #[test]
    fn the_area_estimator_solves_its_cubic() {
        // p = 2 gives 4 B d^3 - l B d^2 - 3 l A = 0.
        let (area, l) = (1e-4, 0.02);
        let d = CostFunction::new(StaticMeans { area, edge: 0.01 }, l, Estimator::Area).optimal_size();
        let b = 0.01 * 100.0 * 3f64.sqrt() / (2.0 * area);
        let residual = 4.0 * b * d.powi(3) - l * b * d * d - 3.0 * l * 0.99;
        assert!(residual.abs() < 1e-9 * 3.0 * l, "{residual}");
    }

    #[test]
    fn scales_with_the_mesh() {
        let at = |s: f64| {
            CostFunction::new(StaticMeans { area: 1e-4 * s * s, edge: 0.01 * s }, 0.02 * s, Estimator::Area)
                .optimal_size()
        };
        assert!((at(1000.0) / at(1.0) - 1000.0).abs() < 1e-6);
    }
}
