//! The way in steps: hulls of a triangle's places at the ends of a step.

use feeler_core::{Aabb, Error, Motion, Point, Pose, Result, Tool};

use super::constants::{HULL_SHARE, MOST_HALVINGS};
use super::hull::Corners;

/// A triangle at the ends of a step.
#[derive(Debug, Clone, Copy)]
pub struct Step {
    triangle: u32,
    /// Numbers of the poses at both ends.
    poses: [u32; 2],
    /// What is taken off distances, metres.
    pub slack: f32,
}

/// All steps of all triangles.
pub struct Steps<'a> {
    tool: &'a Tool,
    poses: Vec<Pose>,
    /// See [`Step`].
    pub steps: Vec<Step>,
    /// What coordinates are relative to, metres: corners of hulls, and all that is compared with them.
    pub origin: Point,
}

impl<'a> Steps<'a> {
    /// Of a way that has a pose at least. `tolerance`: of distances, in metres.
    pub fn new(tool: &'a Tool, way: &[Pose], error: f64, tolerance: f64, memory: u64) -> Result<Steps<'a>> {
        let most = (memory as f64 / size_of::<Step>() as f64).min(f64::from(u32::MAX));
        let mut steps = Steps { tool, poses: Vec::new(), steps: Vec::new(), origin: [0.0; 3] };
        // A pose that is the one before adds nothing.
        let mut way = way.to_vec();
        way.dedup();
        if way.len() == 1 {
            way.push(way[0]);
        }
        let mut count = 0.0;
        for ends in way.windows(2) {
            let motion = Motion::new(tool, &ends[0], &ends[1]);
            let halvings = halvings_of(tool, &motion, error, tolerance)?;
            count += halvings.iter().map(|(_, halvings, _)| f64::from(1 << halvings)).sum::<f64>();
            if count > most {
                let bytes = size_of::<Step>() as f64;
                let needed = format!("{:.2e} bytes for its steps where {:.2e} are allowed", count * bytes, most * bytes);
                return Err(Error::SweptTooFine { error, needed, least: error * 2.0 * count / most });
            }
            steps.add(&motion, &halvings);
        }
        let mut bounds = Aabb::EMPTY;
        steps.steps.iter().for_each(|step| steps.corners(step).iter().for_each(|p| bounds.grow(p)));
        steps.origin = bounds.lower;
        Ok(steps)
    }

    fn add(&mut self, motion: &Motion, halvings: &[(u32, u32, f64)]) {
        let finest = halvings.iter().map(|(_, halvings, _)| *halvings).max().unwrap_or(0);
        let first = self.poses.len() as u32;
        let parts = 1u32 << finest;
        self.poses.extend((0..=parts).map(|i| motion.at(f64::from(i) / f64::from(parts))));
        for (triangle, halvings, slack) in halvings {
            let stride = 1 << (finest - halvings);
            for i in 0..1 << halvings {
                let from = first + i * stride;
                // Rounded up.
                let slack = (*slack as f32).next_up();
                self.steps.push(Step { triangle: *triangle, poses: [from, from + stride], slack });
            }
        }
    }

    /// The corners of a step's hull, from the origin.
    pub fn corners(&self, step: &Step) -> Corners {
        let triangle = self.tool.mesh().triangle(step.triangle);
        let mut corners = [[0.0; 3]; 6];
        for (pose, corners) in step.poses.iter().zip(corners.chunks_exact_mut(3)) {
            let placed = self.poses[*pose as usize].apply_triangle(&triangle);
            for (corner, p) in corners.iter_mut().zip(&placed) {
                *corner = std::array::from_fn(|a| p[a] - self.origin[a]);
            }
        }
        corners
    }

    /// The box around everything, from the origin.
    pub fn bounds(&self) -> Aabb {
        let mut bounds = Aabb::EMPTY;
        self.steps.iter().for_each(|step| self.corners(step).iter().for_each(|p| bounds.grow(p)));
        bounds
    }

    /// The first pose.
    pub fn first(&self) -> &Pose {
        &self.poses[0]
    }
}

/// The box around a hull.
pub fn box_around(corners: &Corners) -> Aabb {
    let mut bounds = Aabb::EMPTY;
    corners.iter().for_each(|p| bounds.grow(p));
    bounds
}

/// For each triangle how often the time is halved until hulls are within [`HULL_SHARE`] of the error, and what is taken off
/// distances: what places may be outside of the hull, and the tolerance of distances.
fn halvings_of(tool: &Tool, motion: &Motion, error: f64, tolerance: f64) -> Result<Vec<(u32, u32, f64)>> {
    let mesh = tool.mesh();
    let one = |t: u32| {
        let triangle = mesh.triangle(t);
        for halvings in 0..=MOST_HALVINGS {
            let chord = motion.chord(&triangle, 0.5f64.powi(halvings as i32));
            if chord.short + chord.wide <= HULL_SHARE * error {
                return Ok((t, halvings, chord.short + tolerance));
            }
        }
        let still = motion.chord(&triangle, 0.0).short;
        let needed = format!("coordinates, and poses as rigid, within {:.1e} m, where they are within {still:.1e} m", HULL_SHARE * error / 4.0);
        Err(Error::SweptTooFine { error, needed, least: (4.0 * still / HULL_SHARE).max(2.0 * error) })
    };
    mesh.queried().map(one).collect()
}
