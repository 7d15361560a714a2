//! The way in steps: hulls of a triangle's places at the ends of a step.

use feeler_core::geometry::vectors::{dot, sub};
use feeler_core::{Aabb, Error, Motion, Point, Pose, Result, Tool, Triangle};

use super::hull::{Corners, Hull};
use crate::constants::{BYTES_PER_STEP, HULL_SHARE, LEAST_WIDTH, MOST_HALVINGS, MOST_STEPS};

/// A triangle at the ends of a step.
#[derive(Debug, Clone, Copy)]
struct Step {
    /// Its number among the triangles below.
    triangle: u32,
    /// Numbers of the poses at both ends.
    poses: [u32; 2],
    /// The amount taken off distances, metres.
    slack: f32,
}

/// All steps of all triangles.
pub struct Steps {
    /// Those of the tool, and halves of these where they are wide.
    triangles: Vec<Triangle>,
    poses: Vec<Pose>,
    steps: Vec<Step>,
    /// The origin of coordinates, metres: of corners of hulls, and of all values compared with them.
    pub origin: Point,
    /// The box around everything, from the origin.
    pub bounds: Aabb,
}

impl Steps {
    /// Of a way that has a pose at least. `tolerance`: of distances, in metres; `memory`: most bytes.
    pub fn new(tool: &Tool, way: &[Pose], error: f64, tolerance: f64, memory: u64) -> Result<Steps> {
        let mesh = tool.mesh();
        let triangles: Vec<Triangle> = mesh.queried().map(|t| mesh.triangle(t)).collect();
        let own = 0..triangles.len() as u32;
        let mut steps =
            Steps { triangles, poses: Vec::new(), steps: Vec::new(), origin: [0.0; 3], bounds: Aabb::EMPTY };
        // A pose that is the one before adds nothing.
        let mut way = way.to_vec();
        way.dedup();
        if way.len() == 1 {
            way.push(way[0]);
        }
        let limits = Limits { error, tolerance, most_bytes: memory as f64, segments: way.len() - 1 };
        for (segment, ends) in way.windows(2).enumerate() {
            let motion = Motion::new(tool, &ends[0], &ends[1]);
            let mut cuts = Vec::new();
            for t in own.clone() {
                steps.cut(&motion, t, &limits, &mut cuts)?;
            }
            let added: f64 = cuts.iter().map(|cut| f64::from(1u32 << cut.halvings)).sum();
            let share = (segment + 1) as f64 / limits.segments as f64;
            steps.check_memory(added, share, &limits)?;
            steps.add(&motion, &cuts);
        }
        let mut bounds = Aabb::EMPTY;
        for step in &steps.steps {
            steps.corners(step).iter().for_each(|p| bounds.grow(p));
        }
        steps.origin = bounds.lower;
        steps.bounds = Aabb { lower: [0.0; 3], upper: sub(&bounds.upper, &bounds.lower) };
        Ok(steps)
    }

    /// How a triangle is cut and how often its time is halved, until hulls are within [`HULL_SHARE`] of the error. Where a triangle is
    /// so wide that it, and not the arcs, would ask for short steps, two halves of it do with longer ones.
    fn cut(&mut self, motion: &Motion, triangle: u32, limits: &Limits, cuts: &mut Vec<Cut>) -> Result<()> {
        let mut open = vec![triangle];
        while let Some(number) = open.pop() {
            let triangle = self.triangles[number as usize];
            let mut halvings = 0;
            loop {
                let chord = motion.chord(&triangle, 0.5f64.powi(halvings as i32));
                if chord.short + chord.wide <= HULL_SHARE * limits.error {
                    cuts.push(Cut { triangle: number, halvings, slack: chord.short + limits.tolerance });
                    break;
                }
                if 2.0 * chord.short <= 0.5 * HULL_SHARE * limits.error {
                    if let Some(halves) = halves_of(&triangle, limits.error) {
                        open.extend([self.triangles.len() as u32, self.triangles.len() as u32 + 1]);
                        self.triangles.extend(halves);
                        self.check_memory(0.0, 1.0, limits)?;
                        break;
                    }
                }
                halvings += 1;
                if halvings > MOST_HALVINGS {
                    return Err(too_exact(motion.chord(&triangle, 0.0).short, limits.error));
                }
            }
        }
        Ok(())
    }

    /// `share`: of the way, with the steps that are added.
    fn check_memory(&self, added: f64, share: f64, limits: &Limits) -> Result<()> {
        let (steps, triangles) = (self.steps.len() as f64 + added, self.triangles.len() as f64);
        let bytes = (steps * BYTES_PER_STEP + triangles * size_of::<Triangle>() as f64) / share;
        let most = limits.most_bytes.min(MOST_STEPS * BYTES_PER_STEP);
        if bytes <= most {
            return Ok(());
        }
        let needed = format!("{bytes:.1e} bytes or more for its steps where {most:.1e} are allowed");
        Err(Error::SweptTooFine { error: limits.error, needed, least: limits.error * 3.0 })
    }

    fn add(&mut self, motion: &Motion, cuts: &[Cut]) {
        let finest = cuts.iter().map(|cut| cut.halvings).max().unwrap_or(0);
        let first = self.poses.len() as u32;
        let parts = 1u32 << finest;
        self.poses.extend((0..=parts).map(|i| motion.at(f64::from(i) / f64::from(parts))));
        for cut in cuts {
            let stride = 1 << (finest - cut.halvings);
            for i in 0..1 << cut.halvings {
                let from = first + i * stride;
                // Rounded up.
                let slack = (cut.slack as f32).next_up();
                self.steps.push(Step { triangle: cut.triangle, poses: [from, from + stride], slack });
            }
        }
    }

    /// How many there are.
    pub fn count(&self) -> u32 {
        self.steps.len() as u32
    }

    /// The corners of a step's hull, from the origin.
    fn corners(&self, step: &Step) -> Corners {
        let triangle = &self.triangles[step.triangle as usize];
        let mut corners = [[0.0; 3]; 6];
        for (i, corner) in corners.iter_mut().enumerate() {
            *corner = sub(&self.poses[step.poses[i / 3] as usize].apply(&triangle[i % 3]), &self.origin);
        }
        corners
    }

    /// A step's hull, from the origin, and the correction subtracted from distances to it.
    pub fn hull(&self, number: u32) -> (Hull, f64) {
        let step = &self.steps[number as usize];
        (Hull::new(&self.corners(step)), f64::from(step.slack))
    }

    /// The first pose.
    pub fn first(&self) -> &Pose {
        &self.poses[0]
    }
}

/// What steps may be.
struct Limits {
    error: f64,
    tolerance: f64,
    most_bytes: f64,
    segments: usize,
}

/// A triangle, how often the time is halved for it, and what is taken off distances to its hulls: what its places may be outside of
/// them, and the tolerance of distances. Metres.
struct Cut {
    triangle: u32,
    halvings: u32,
    slack: f64,
}

/// A triangle cut across its longest side; `None` of one that is small enough. The new corner is off the side by rounding, as a
/// corner at a pose is.
fn halves_of(triangle: &Triangle, error: f64) -> Option<[Triangle; 2]> {
    let square = |i: usize| {
        let side = sub(&triangle[(i + 1) % 3], &triangle[i]);
        dot(&side, &side)
    };
    let longest = (1..3).fold(0, |best, i| if square(i) > square(best) { i } else { best });
    if square(longest) <= (LEAST_WIDTH * error).powi(2) {
        return None;
    }
    let [a, b, c] = std::array::from_fn(|i| triangle[(longest + i) % 3]);
    let middle: Point = std::array::from_fn(|x| 0.5 * a[x] + 0.5 * b[x]);
    Some([[a, middle, c], [middle, b, c]])
}

/// Of poses and coordinates that are not exact enough: only to `within` metres.
fn too_exact(within: f64, error: f64) -> Error {
    let needed = format!(
        "coordinates that are exact, and poses that are rigid, within {:.1e} m, where these are within {within:.1e} m",
        0.25 * HULL_SHARE * error
    );
    Error::SweptTooFine { error, needed, least: (4.0 * within / HULL_SHARE).max(2.0 * error) }
}
