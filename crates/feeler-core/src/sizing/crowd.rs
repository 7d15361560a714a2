//! The local density of the mock-up: surface in a volume, as a histogram on a coarse grid.

use crate::geometry::bounds::{Aabb, Point, Triangle};
use crate::mesh::pieces::{edge_lengths, longest_edge, twice_area};

/// Cells of the grid, about.
const CELLS: f64 = 131_072.0;

/// Most points along an edge of a triangle larger than a cell.
const SPREAD: f64 = 6.0;

/// A triangle of the mock-up with its repeatedly used measures.
#[derive(Debug, Clone, Copy)]
pub struct Measured {
    pub corners: Triangle,
    pub bounds: Aabb,
    /// Square metres.
    pub area: f64,
    /// Length of its edges together, metres.
    pub outline: f64,
    /// Its longest edge, metres.
    pub longest: f64,
}

impl Measured {
    /// Of a triangle.
    pub fn of(corners: Triangle) -> Measured {
        let edges = edge_lengths(&corners);
        Measured {
            bounds: Aabb::of_triangle(&corners),
            area: 0.5 * twice_area(&corners),
            outline: edges.iter().sum(),
            longest: edges.into_iter().fold(0.0, f64::max),
            corners,
        }
    }
}

/// Means over cells of a sample of triangles.
#[derive(Debug)]
pub struct Crowd {
    origin: Point,
    /// Cells a metre.
    over: f64,
    cells: [usize; 3],
    /// Area and outline of the triangles, over the volume: 1 / m, 1 / m^2.
    density: Vec<[f32; 2]>,
}

impl Crowd {
    /// Each of the triangles stands for `weight` triangles inside the bounds.
    pub fn new(bounds: &Aabb, triangles: &[Measured], weight: f64) -> Crowd {
        let extent = bounds.extent();
        let longest = extent.iter().fold(0.0, |m: f64, x| m.max(*x));
        // Flat mock-ups have fewer cells. As shares of the longest side, since a volume may be too small for a number.
        let volume: f64 = extent.iter().map(|x| (x / longest).max(1.0 / 64.0)).product();
        let over = (CELLS / volume).cbrt() / longest;
        // Where a volume has no number, nothing is known: one cell, and nothing in it.
        let over = if (over * over * over).is_normal() { over } else { 0.0 };
        let cells = extent.map(|x| (x * over) as usize + 1);
        let mut crowd = Crowd { origin: bounds.lower, over, cells, density: vec![[0.0; 2]; cells.iter().product()] };
        for t in triangles {
            let n = steps(t.longest * over);
            let share = weight * over * over * over / (n * (n + 1) / 2) as f64;
            let (area, outline) = ((t.area * share) as f32, (t.outline * share) as f32);
            lattice(&t.corners, n, |at| {
                if let Some(cell) = crowd.cell(at) {
                    let [a, o] = &mut crowd.density[cell];
                    *a += area;
                    *o += outline;
                }
            });
        }
        crowd
    }

    fn cell(&self, p: &Point) -> Option<usize> {
        let mut cell = 0;
        for a in 0..3 {
            // Below the origin and NaN are 0 as integers; both are sorted out first.
            let x = (p[a] - self.origin[a]) * self.over;
            if !(x >= 0.0 && x < self.cells[a] as f64) {
                return None;
            }
            cell = cell * self.cells[a] + x as usize;
        }
        Some(cell)
    }

    /// The average number of triangles that one of this area and outline collides with there, in any orientation.
    ///
    /// The common points of two triangles are a segment; each of its ends is where an edge of one goes through the
    /// other. A segment of length `l` intersects surfaces of area `a` in a volume `a l / 2` times.
    pub fn met(&self, at: &Point, area: f64, outline: f64) -> f64 {
        self.cell(at).map_or(0.0, |cell| {
            let [areas, outlines] = self.density[cell].map(f64::from);
            0.25 * (outline * areas + area * outlines)
        })
    }

    /// Points of a triangle that stand for it.
    pub fn points_of(&self, t: &Triangle) -> Vec<Point> {
        let mut points = Vec::new();
        lattice(t, steps(longest_edge(t) * self.over), |p| points.push(*p));
        points
    }
}

/// Points along an edge of `cells` cells.
fn steps(cells: f64) -> usize {
    cells.ceil().clamp(1.0, SPREAD) as usize
}

/// Points of a triangle, evenly spread: `n (n + 1) / 2`.
fn lattice(t: &Triangle, n: usize, mut point: impl FnMut(&Point)) {
    for i in 0..n {
        for j in 0..n - i {
            let [u, v] = [i, j].map(|k| (k as f64 + 1.0 / 3.0) / n as f64);
            point(&std::array::from_fn(|a| t[0][a] * (1.0 - u - v) + t[1][a] * u + t[2][a] * v));
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::geometry::intersect_triangle_triangle::intersect_triangle_triangle;
    use crate::sizing::random::Random;

    /// Triangles of up to that size with a corner anywhere in a cube of a metre.
    pub fn scattered(n: usize, size: f64, seed: u64) -> Vec<Triangle> {
        let mut random = Random::new(seed);
        let mut one = || {
            let turn = random.rotation();
            let at: Point = std::array::from_fn(|_| random.unit());
            let corners = [[0.0; 3], [size, 0.0, 0.0], [0.3 * size, 0.4 * size, 0.0]];
            corners.map(|p| std::array::from_fn(|a| at[a] + (0..3).map(|i| turn[a][i] * p[i]).sum::<f64>()))
        };
        (0..n).map(|_| one()).collect()
    }

    #[test]
    fn as_many_meet_as_the_crowd_says() {
        // Larger than a cell, and smaller.
        for (n, size) in [(3000, 0.15), (30_000, 0.015)] {
            let statics = scattered(n, size, 1);
            let bounds = Aabb { lower: [-size; 3], upper: [1.0 + size; 3] };
            // A third of them stand for all.
            let third: Vec<Measured> = statics.iter().step_by(3).map(|t| Measured::of(*t)).collect();
            let crowd = Crowd::new(&bounds, &third, 3.0);
            let (mut met, mut expected) = (0, 0.0);
            for t in scattered(600, 0.1, 2) {
                let b = Aabb::of_triangle(&t);
                let near = statics.iter().filter(|s| Aabb::of_triangle(s).is_overlapping(&b));
                met += near.filter(|s| intersect_triangle_triangle(&t, s).is_some()).count();
                let (area, outline) = (0.5 * twice_area(&t), edge_lengths(&t).iter().sum());
                let points = crowd.points_of(&t);
                expected += points.iter().map(|p| crowd.met(p, area, outline)).sum::<f64>() / points.len() as f64;
            }
            assert!(met > 300 && (expected / met as f64 - 1.0).abs() < 0.15, "{size}: {met} {expected}");
            assert_eq!(crowd.met(&[5.0, 0.5, 0.5], 1.0, 1.0), 0.0);
            assert_eq!(crowd.met(&[f64::NAN; 3], 1.0, 1.0), 0.0);
        }
    }
}
