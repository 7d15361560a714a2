//! The result of the collision side for the servo side: contact rows, the pose where they were taken, and the range in
//! which they hold.

use feeler_core::geometry::least_distance::{nearest, HalfSpace, Six, DIMENSIONS};
use feeler_core::geometry::twist::{displaced, displacement, product, times, transposed, Twist};
use feeler_core::geometry::vectors::{add, dot, length, scaled, sub};
use feeler_core::tool::metric::Metric;
use feeler_core::{Point, Pose, Tool};

pub use feeler_world::Plane;
use feeler_world::{Environment, Pair};

use crate::constants::{MOST_PLANES, MOST_ROWS, MOST_SHADED, SOLVER_ROUNDS, SOLVER_STILL_SHARE, STRAY_SHARE};
use crate::error::Result;
use crate::shading::{shading_of, Shade, Shading};

/// A point of the tool that is held off a plane.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Row {
    /// Unit, world, from the mock-up to the tool.
    pub normal: Point,
    /// From the tool's centre to the point, world, at the pose where the rows were taken; metres.
    pub arm: Point,
    /// How far the point is off the plane there, metres.
    pub gap: f64,
    /// Of its plane.
    pub id: u64,
    /// Whether it is to be off by the skin; a seat may stay as near as it is.
    pub has_skin: bool,
}

/// The contacts around the proxy at one moment. Of fixed size, so that it is handed over without allocating.
#[derive(Debug, Clone, Copy)]
pub struct ConstraintSet {
    /// The proxy's pose where they were taken: free by the exact test.
    pub taken_at: Pose,
    /// When, seconds on the caller's clock.
    pub time: f64,
    /// Counts the sets.
    pub number: u64,
    /// How far the rows are to be held off, metres.
    pub skin: f64,
    /// Everything without a row is at least this far away, metres.
    pub margin: f64,
    /// The metric of poses for this tool.
    pub metric: Metric,
    /// Beside contacts the device pulls no farther than this (metres, radians): where the coupling's force is full.
    pub pull: [f64; 2],
    rows: [Row; MOST_ROWS],
    row_count: usize,
    planes: [Plane; MOST_PLANES],
    plane_count: usize,
    /// The triangles that a plane is between, and the smooth surfaces that these stand for.
    pairs: [Option<Pair>; MOST_PLANES],
    shades: [Option<Shade>; MOST_PLANES],
    is_shaded: bool,
    /// How far the rows were taken along since they were found, metres.
    strayed: f64,
}

/// Working memory of [`ConstraintSet::nearest_pose`], with its last content.
#[derive(Debug, Clone)]
pub struct Solver {
    half_spaces: [HalfSpace; MOST_ROWS],
    held: [u64; DIMENSIONS],
    /// How hard, metres along the normal.
    pushes: [f64; DIMENSIONS],
    held_count: usize,
}

impl Default for Solver {
    fn default() -> Solver {
        let none = HalfSpace { normal: [0.0; DIMENSIONS], offset: 0.0 };
        Solver { half_spaces: [none; MOST_ROWS], held: [0; DIMENSIONS], pushes: [0.0; DIMENSIONS], held_count: 0 }
    }
}

impl Solver {
    /// The ids of the planes that held the proxy.
    pub fn held(&self) -> &[u64] {
        &self.held[..self.held_count]
    }
}

/// The nearest pose that a set allows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NearestPose {
    /// The pose.
    pub pose: Pose,
    /// Whether the rows allow any pose: false where they exclude each other at their skin.
    pub is_feasible: bool,
    /// Whether it was held back since the rows are good for no more.
    pub is_at_bound: bool,
}

impl ConstraintSet {
    /// Without rows: nothing is within the margin.
    pub fn new(taken_at: Pose, metric: Metric, skin: f64, margin: f64, pull: [f64; 2]) -> ConstraintSet {
        ConstraintSet {
            pull,
            taken_at,
            time: 0.0,
            number: 0,
            skin,
            margin,
            metric,
            rows: [Row::default(); MOST_ROWS],
            row_count: 0,
            planes: [Plane::default(); MOST_PLANES],
            plane_count: 0,
            pairs: [None; MOST_PLANES],
            shades: [None; MOST_PLANES],
            is_shaded: false,
            strayed: 0.0,
        }
    }

    /// Starts anew at another pose.
    pub fn clear(&mut self, taken_at: &Pose, margin: f64) {
        self.taken_at = *taken_at;
        self.margin = margin;
        self.row_count = 0;
        self.plane_count = 0;
        self.is_shaded = false;
        self.strayed = 0.0;
    }

    /// Takes the rows along to a pose: planes stay, points move with the tool, and surfaces without a row are that much nearer. False, and
    /// no change, if any point of the tool is then farther than `most` (metres) from where the rows were found.
    pub(crate) fn take_along(&mut self, pose: &Pose, most: f64) -> bool {
        let centre = self.metric.centre;
        let reach = displacement(&self.taken_at, pose, &centre).reach(self.metric.radius);
        if self.strayed + reach > most.min(STRAY_SHARE * (self.margin + self.strayed)) {
            return false;
        }
        let turn = product(pose.rotation(), &transposed(self.taken_at.rotation()));
        let moved = sub(&pose.apply(&centre), &self.taken_at.apply(&centre));
        let mut rows = &mut self.rows[..self.row_count];
        for plane in &mut self.planes[..self.plane_count] {
            let (own, others) = rows.split_at_mut(rows.partition_point(|row| row.id == plane.id));
            rows = others;
            let mut least = reach;
            for row in own {
                let arm = times(&turn, &row.arm);
                let by = dot(&row.normal, &add(&moved, &sub(&arm, &row.arm)));
                (row.arm, row.gap) = (arm, row.gap + by);
                least = least.min(by);
            }
            plane.gap += least;
        }
        self.taken_at = *pose;
        self.margin -= reach;
        self.strayed += reach;
        self.number += 1;
        self.is_shaded = false;
        true
    }

    /// Whether rows were taken along since they were found.
    pub(crate) fn has_strayed(&self) -> bool {
        self.strayed > 0.0
    }

    /// Adds a plane with the points of the tool (world) that are held off the mock-up there, and how far off they are. Planes come nearest first; one that does not fit any more
    /// shortens the margin to its gap.
    pub fn push(&mut self, plane: Plane, points: impl ExactSizeIterator<Item = (Point, f64)>) {
        self.push_rows(plane, points, true);
    }

    /// The same for a plane that the tool may stay on: its points are held where they are, not a skin off.
    pub fn push_seat(&mut self, plane: Plane, points: impl ExactSizeIterator<Item = (Point, f64)>) {
        self.push_rows(plane, points, false);
    }

    fn push_rows(&mut self, plane: Plane, points: impl ExactSizeIterator<Item = (Point, f64)>, has_skin: bool) {
        if self.plane_count == MOST_PLANES || self.row_count + points.len() > MOST_ROWS {
            self.margin = self.margin.min(plane.gap);
            return;
        }
        self.planes[self.plane_count] = plane;
        (self.pairs[self.plane_count], self.shades[self.plane_count]) = (None, None);
        self.plane_count += 1;
        let centre = self.taken_at.apply(&self.metric.centre);
        for (point, gap) in points {
            self.rows[self.row_count] =
                Row { normal: plane.normal, arm: sub(&point, &centre), gap, id: plane.id, has_skin };
            self.row_count += 1;
        }
    }

    /// The rows.
    pub fn rows(&self) -> &[Row] {
        &self.rows[..self.row_count]
    }

    /// The planes, nearest first.
    pub fn planes(&self) -> &[Plane] {
        &self.planes[..self.plane_count]
    }

    /// The least gap of all rows, metres; the margin where there are none.
    pub fn least_gap(&self) -> f64 {
        self.rows().iter().filter(|row| row.has_skin).map(|row| row.gap).fold(self.margin, f64::min)
    }

    /// The least gap of all rows of seats, metres; the skin where there are none.
    pub fn least_seat_gap(&self) -> f64 {
        self.rows().iter().filter(|row| !row.has_skin).map(|row| row.gap).fold(self.skin, f64::min)
    }

    /// The pose nearest to `target` that violates no row, found from the pose where the rows were taken, and no farther from it than
    /// `bound` (metres, of any point of the tool). Rows are planes and rigid points: their exact places at each round's pose make the
    /// program of the next. Allocates nothing.
    pub fn nearest_pose(&self, target: &Pose, bound: f64, solver: &mut Solver) -> Result<NearestPose> {
        let metric = &self.metric;
        let (mut pose, mut is_feasible) = (self.taken_at, true);
        for _ in 0..SOLVER_ROUNDS {
            let wish = self.pulled(&displacement(&pose, target, &metric.centre));
            let step = self.step(&pose, &metric.coordinates(&pose, &wish), self.skin, solver);
            is_feasible = step.1;
            let by = metric.displacement(&pose, &step.0);
            pose = displaced(&pose, &by, &metric.centre)?;
            if by.reach(metric.radius) <= SOLVER_STILL_SHARE * self.skin {
                break;
            }
        }
        let way = displacement(&self.taken_at, &pose, &metric.centre);
        let reach = way.reach(metric.radius);
        let is_at_bound = reach > bound;
        if is_at_bound {
            pose = displaced(&self.taken_at, &(way * (bound.max(0.0) / reach)), &metric.centre)?;
        }
        Ok(NearestPose { pose, is_feasible, is_at_bound })
    }

    /// A wish as the coupling pulls: a device that is far beyond a surface does not turn the tool by its distance alone.
    fn pulled(&self, wish: &Twist) -> Twist {
        if self.row_count == 0 {
            return *wish;
        }
        let [most, most_turn] = self.pull;
        let within = |v: &Point, most: f64| scaled(v, (most / length(v)).min(1.0));
        let zero = |v: &Point| length(v) == 0.0;
        Twist {
            linear: if zero(&wish.linear) { wish.linear } else { within(&wish.linear, most) },
            angular: if zero(&wish.angular) { wish.angular } else { within(&wish.angular, most_turn) },
        }
    }

    /// The length (in the metric, metres) of the shortest displacement that has all rows off by `skin`; `None` where there is none.
    pub(crate) fn lift(&self, skin: f64, solver: &mut Solver) -> Option<f64> {
        let held = (solver.held, solver.held_count);
        let (lift, is_feasible) = self.step(&self.taken_at, &[0.0; DIMENSIONS], skin, solver);
        (solver.held, solver.held_count) = held;
        is_feasible.then(|| lift.iter().map(|x| x * x).sum::<f64>().sqrt())
    }

    /// One program, linear at a pose.
    fn step(&self, pose: &Pose, wish: &Six, skin: f64, solver: &mut Solver) -> (Six, bool) {
        let metric = &self.metric;
        let turn = product(pose.rotation(), &transposed(self.taken_at.rotation()));
        let moved = sub(&pose.apply(&metric.centre), &self.taken_at.apply(&metric.centre));
        let rows = self.rows();
        for (row, half_space) in rows.iter().zip(&mut solver.half_spaces) {
            let arm = times(&turn, &row.arm);
            let gap = row.gap + dot(&row.normal, &add(&moved, &sub(&arm, &row.arm)));
            *half_space = metric.half_space(pose, &row.normal, &arm, if row.has_skin { skin - gap } else { -gap });
        }
        let (held, held_count) = (solver.held, solver.held_count);
        let was_held = |i: usize| held[..held_count].contains(&rows[i].id);
        let found = nearest(wish, &solver.half_spaces[..rows.len()], self.skin, was_held);
        solver.held_count = 0;
        for (i, multiplier) in found.active() {
            solver.held[solver.held_count] = rows[*i].id;
            let [x, y, z, ..] = solver.half_spaces[*i].normal;
            solver.pushes[solver.held_count] = multiplier * length(&[x, y, z]);
            solver.held_count += 1;
        }
        (found.point, found.is_feasible)
    }

    /// Says between which triangles the plane is that was added last, if it has that id.
    pub(crate) fn set_pair(&mut self, id: u64, pair: Pair) {
        if let Some(last) = self.plane_count.checked_sub(1).filter(|last| self.planes[*last].id == id) {
            self.pairs[last] = Some(pair);
        }
    }

    /// Finds the smooth surfaces behind the nearest planes, where that was not done yet.
    pub(crate) fn shade(&mut self, environment: &Environment, tool: &Tool) {
        if self.is_shaded {
            return;
        }
        self.is_shaded = true;
        let planes = &self.planes[..self.plane_count];
        let mut nearest: Vec<usize> = (0..planes.len()).collect();
        nearest.sort_by(|a, b| planes[*a].gap.total_cmp(&planes[*b].gap));
        for i in nearest.into_iter().take(MOST_SHADED) {
            self.shades[i] =
                self.pairs[i].and_then(|pair| Shade::of_pair(environment, tool, &self.taken_at, &pair, &planes[i]));
        }
    }

    /// How the force of the planes that a solver found to hold the tool is turned at a pose.
    pub(crate) fn shading(&self, pose: &Pose, solver: &Solver) -> Shading {
        let way = displacement(&self.taken_at, pose, &self.metric.centre);
        let turn = product(pose.rotation(), &transposed(self.taken_at.rotation()));
        let centre = self.taken_at.apply(&self.metric.centre);
        shading_of(solver.held().iter().zip(&solver.pushes).filter_map(|(id, push)| {
            let i = self.planes().iter().position(|plane| plane.id == *id)?;
            let plane = &self.planes[i];
            let (smooth, heights) = self.shades[i].map_or((plane.normal, [0.0; 2]), |shade| {
                let arm = sub(&plane.point, &centre);
                let linear = add(&way.linear, &sub(&times(&turn, &arm), &arm));
                shade.at(plane, &Twist { linear, ..way })
            });
            Some((*push, plane.normal, smooth, heights))
        }))
    }

    /// By how much a pose violates a row at most, metres: below zero where all are off by more than the skin.
    pub fn violation(&self, pose: &Pose) -> f64 {
        let centre = &self.metric.centre;
        let way = displacement(&self.taken_at, pose, centre);
        let turn = product(pose.rotation(), &transposed(self.taken_at.rotation()));
        let off = |row: &Row| {
            let arm = times(&turn, &row.arm);
            (if row.has_skin { self.skin } else { 0.0 })
                - row.gap
                - dot(&row.normal, &add(&way.linear, &sub(&arm, &row.arm)))
        };
        self.rows().iter().map(off).fold(f64::NEG_INFINITY, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use feeler_core::geometry::twist::{pose_of, rotation_of};
    use feeler_shapes::box_mesh;

    use super::*;

    fn at(height: f64, lean: f64) -> Pose {
        pose_of(&rotation_of(&[lean, 0.0, 0.0]), &[0.001, 0.0, height]).unwrap()
    }

    /// A box of 20 mm over a plate at height 0: its lower corners.
    fn over_a_plate(metric: Metric, pose: &Pose) -> ConstraintSet {
        let mut set = ConstraintSet::new(*pose, metric, 2e-5, 5e-4, [0.01, 0.1]);
        let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
        let points = corners.map(|[x, y]| pose.apply(&[0.01 * x, 0.01 * y, -0.01]));
        let gap = points.iter().map(|p| p[2]).fold(f64::INFINITY, f64::min);
        let plane = Plane { point: [0.0; 3], normal: [0.0, 0.0, 1.0], gap, part: 0, id: 7 };
        set.push(plane, points.iter().map(|p| (*p, p[2])));
        set
    }

    #[test]
    fn rows_that_are_taken_along_are_those_found_there() {
        let (vertices, faces) = box_mesh([0.0; 3], [0.02; 3], 1);
        let metric = Metric::new(&Tool::new(vertices, faces).unwrap());
        let (from, to) = (at(0.0101, 0.0), at(0.01006, 0.003));
        let (mut taken, found) = (over_a_plate(metric, &from), over_a_plate(metric, &to));
        assert!(taken.take_along(&to, 1.5e-4) && taken.has_strayed() && !found.has_strayed());
        for (row, other) in taken.rows().iter().zip(found.rows()) {
            assert!((row.gap - other.gap).abs() < 1e-12 && length(&sub(&row.arm, &other.arm)) < 1e-12);
        }
        // Of the corner that is lowest now, which is another.
        assert!(taken.planes()[0].gap <= found.planes()[0].gap + 1e-12);
        assert_eq!(taken.taken_at, to);
        let reach = displacement(&from, &to, &metric.centre).reach(metric.radius);
        assert!((taken.margin - (5e-4 - reach)).abs() < 1e-12, "{}", taken.margin);
        // In all no farther than asked, nor than the rows are good for.
        let before = taken;
        assert!(!taken.take_along(&from, 1.5e-4) && !taken.take_along(&at(0.0104, 0.0), 1.0));
        assert_eq!((taken.taken_at, taken.margin), (before.taken_at, before.margin));
        taken.clear(&from, 5e-4);
        assert!(!taken.has_strayed());
    }
}
