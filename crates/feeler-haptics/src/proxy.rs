//! The proxy (god-object): the tool as it would be if it could not enter the mock-up.
//!
//! After M. Ortega, S. Redon and S. Coquillart (*A six degree-of-freedom god-object method for haptic display of rigid
//! bodies with surface properties*, 2007): the pose nearest to the device's that no contact forbids, reached by a free
//! motion. Differences: contacts are planes that do not depend on the triangulation, taken at the proxy, with the
//! points that carry them; and each motion is cast, so that the proxy is never in collision by the exact test. An
//! impact that no plane forbade becomes a row of its own, and is checked again while it is near.

use std::sync::Arc;

use feeler_contacts::{Manifold, Manifolds};
use feeler_core::geometry::twist::{displaced, displacement};
use feeler_core::geometry::vectors::{length, sub, unit};
use feeler_core::tool::metric::Metric;
use feeler_core::{Motion, Point, Pose};
use feeler_world::{Pair, Seated, Surroundings, Walk, WalkOptions};

use crate::constants::{
    ARC_SKINS, BACK_OFF_HALVINGS, BACK_OFF_SHARE, BOUND_SHARE, CAST_SHARE, CLEARANCE_SHARE, FREE_MARGIN,
    LARGEST_CAST_TOLERANCE, LEAST_CAST_TOLERANCE, LEAST_MARGIN, LEAST_TRUST, LIFT_SHARE, MOST_BLOCKERS, MOST_LIFT,
    MOST_PATIENCE, REST_SHARE, SEAT_REST, SEAT_SLACK, SKINS_IN_MARGIN, SKIN_GROWTH, SKIN_HALVINGS, SKIN_LIFT,
    SQUEEZE_GAIN, SQUEEZE_SHARE, STILL_SHARE, STRIDES, STRIDE_DECAY, STUCK_SHARE, TRUST_GROWTH,
};
use crate::constraint_set::{ConstraintSet, NearestPose, Plane, Solver};
use crate::coupling::Coupling;
use crate::error::{Error, Result};

/// How the proxy is kept off.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct ProxyOptions {
    /// Surfaces nearer than this are contacts, metres.
    pub margin: f64,
    /// How far the proxy stays off, metres; less where the clearance is less than twice as much.
    pub skin: f64,
    /// Most motions a tick: more follow a fast hand around corners in one tick, and take longer.
    pub rounds: usize,
    /// Beside contacts the device pulls no farther than this, metres: where the coupling's force is full.
    pub pull_m: f64,
    /// The same in rotation, radians.
    pub pull_rad: f64,
}

impl Default for ProxyOptions {
    fn default() -> ProxyOptions {
        ProxyOptions { margin: 0.002, skin: 2e-5, rounds: 4, pull_m: 0.008, pull_rad: 0.15 }
    }
}

impl ProxyOptions {
    feeler_core::setters! {
        with_margin: margin: f64,
        with_skin: skin: f64,
        with_rounds: rounds: usize,
        with_pull_m: pull_m: f64,
        with_pull_rad: pull_rad: f64,
    }
}

impl ProxyOptions {
    /// With the pull of a coupling: as far as its springs stretch before they are at their bounds. A spring that pulls not at all, or is
    /// not bounded, leaves what there is.
    pub fn with_pull_of(mut self, coupling: &Coupling) -> ProxyOptions {
        let full = |most: f64, stiffness: f64, else_is: f64| {
            let stretch = most / stiffness;
            if stretch.is_finite() && stretch > 0.0 {
                stretch
            } else {
                else_is
            }
        };
        self.pull_m = full(coupling.max_force_n, coupling.stiffness_n_per_m, self.pull_m);
        self.pull_rad = full(coupling.max_torque_nm, coupling.rotational_stiffness_nm_per_rad, self.pull_rad);
        self
    }

    /// Errors: a margin or skin that is not positive and finite, a skin of half the margin or more, no rounds.
    pub fn check(&self) -> Result<()> {
        let option = |what, value: f64, is_good: bool, range| match value.is_finite() && is_good {
            true => Ok(()),
            false => Err(Error::Option { what, value, range }),
        };
        option("margin", self.margin, self.margin > 0.0, "positive (metres)")?;
        option("skin", self.skin, self.skin > 0.0, "positive (metres)")?;
        option("skin", self.skin, self.skin < 0.5 * self.margin, "less than half the margin")?;
        option("rounds", self.rounds as f64, self.rounds > 0, "at least 1")?;
        option("pull_m", self.pull_m, self.pull_m > 0.0, "positive (metres)")?;
        option("pull_rad", self.pull_rad, self.pull_rad > 0.0, "positive (radians)")
    }
}

/// The actions of one tick of the collision side.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Advance {
    /// Motions tried.
    pub rounds: usize,
    /// Of these, stopped by the cast.
    pub stopped: usize,
}

/// The tool's constrained twin. Its pose is free by the exact test, and was reached by a free motion from the start.
#[derive(Debug)]
pub struct Proxy {
    options: ProxyOptions,
    /// Pairs that stopped a cast, the newest last.
    blockers: Vec<Pair>,
    /// What it has not parted from yet.
    seated: Arc<Seated>,
    manifolds: Manifolds,
    seat_manifolds: Manifolds,
    /// Along which a motion is probably free.
    normals: Vec<Point>,
    set: ConstraintSet,
    solver: Solver,
    /// How far a motion may lead, metres: less after one that a known constraint stopped.
    trust: f64,
    skin: f64,
    /// The longest of its last motions, metres a tick.
    stride: f64,
    /// Ticks between two tries to squeeze through, and how many have passed.
    patience: u32,
    waited: u32,
}

impl Proxy {
    /// A proxy at the start of its surroundings; its contacts there are seats. Errors: options out of range.
    ///
    /// `metric`: of poses; usually the tool's.
    pub fn new(around: &Surroundings, metric: Metric, options: ProxyOptions) -> Result<Proxy> {
        options.check()?;
        let start = around.start();
        let set = ConstraintSet::new(*start, metric, options.skin, options.margin, [options.pull_m, options.pull_rad]);
        let mut proxy = Proxy {
            options,
            blockers: Vec::new(),
            seated: around.seated_at_start(),
            manifolds: Manifolds::default(),
            seat_manifolds: Manifolds::default(),
            normals: Vec::new(),
            set,
            solver: Solver::default(),
            trust: f64::INFINITY,
            skin: options.skin,
            stride: 0.0,
            patience: 0,
            waited: 0,
        };
        proxy.look_around(around, start)?;
        Ok(proxy)
    }

    /// Where it is.
    pub fn pose(&self) -> &Pose {
        &self.set.taken_at
    }

    /// The contacts where it is.
    pub fn constraints(&self) -> &ConstraintSet {
        &self.set
    }

    /// When its contacts were found, seconds on the caller's clock.
    pub fn set_time(&mut self, now: f64) {
        self.set.time = now;
    }

    /// Sets the metric, and how far the device pulls, from now on; the centre is the same.
    pub(crate) fn set_metric(&mut self, metric: Metric, options: ProxyOptions) {
        let radius = self.set.metric.radius;
        self.set.metric = metric;
        self.set.metric.radius = radius;
        self.set.pull = [options.pull_m, options.pull_rad];
        self.options = options;
    }

    /// The surroundings and the moving body have changed in place: a part was gripped or released. The metric stays, so
    /// that the proxy does not move because of it.
    pub fn set_world(&mut self, around: &Surroundings) -> Result<()> {
        let pose = self.set.taken_at;
        self.blockers.clear();
        self.seated = around.seated_at_start();
        self.set.metric = self.set.metric.with_radius_of(around.tool());
        let time = self.set.time;
        self.look_around(around, &pose)?;
        self.set.time = time;
        Ok(())
    }

    /// The seats that have not separated yet.
    pub fn seated(&self) -> &Arc<Seated> {
        &self.seated
    }

    /// Moves it towards the device's pose, and finds the contacts where it gets to.
    pub fn advance(&mut self, around: &Surroundings, target: &Pose) -> Result<Advance> {
        let start = self.set.taken_at;
        let mut done = Advance::default();
        let is_stuck = self.approach(around, target, f64::INFINITY, &mut done)?;
        // What still moves by a skin a tick, as a peg on its way down, has no way that its skin closes.
        let is_stuck = is_stuck && self.reach_to(&start) <= self.options.skin;
        if is_stuck && self.is_time_to_squeeze() {
            self.squeeze(around, target, &mut done)?;
        }
        if self.set.has_strayed() {
            self.look_around(around, &{ self.set.taken_at })?;
        }
        self.stride = self.reach_to(&start).max(STRIDE_DECAY * self.stride);
        Ok(done)
    }

    /// Where the servo side has it for a pose of the device, and whether the way there is free; `None` where it is there already.
    pub fn ahead(&self, around: &Surroundings, target: &Pose) -> Result<Option<(Pose, bool)>> {
        let set = &self.set;
        let nearest = set.nearest_pose(target, BOUND_SHARE * set.margin, &mut self.solver.clone())?.pose;
        if self.reach_to(&nearest) <= STUCK_SHARE * set.skin {
            return Ok(None);
        }
        let normals: Vec<Point> = set.planes().iter().map(|plane| plane.normal).collect();
        let how = WalkOptions::default().with_directions(&normals).with_tolerance(self.cast_tolerance());
        let walk = around.walk(&self.seated, (&set.taken_at, &nearest), how)?;
        Ok(Some((nearest, walk.stop.is_none())))
    }

    /// Moves it along a free way, and finds its contacts.
    pub fn move_on(&mut self, around: &Surroundings, pose: &Pose) -> Result<()> {
        let time = self.set.time;
        if let Some(left) = around.left_at(&self.seated, pose)? {
            self.seated = left;
        }
        // So little leads hardly to another facet.
        self.arrive(around, pose, self.options.skin, None)?;
        self.set.time = time;
        Ok(())
    }

    /// Finds the smooth surfaces behind the contacts: see [`Shading`](crate::Shading).
    pub fn shade(&mut self, around: &Surroundings) {
        self.set.shade(around.environment(), around.tool());
    }

    /// Motions towards the target, each as far as it is free, until none leads on. Whether contacts hold it.
    fn approach(&mut self, around: &Surroundings, target: &Pose, stray: f64, done: &mut Advance) -> Result<bool> {
        let (mut distance, mut gained) = (self.distance_to(target), 0.0);
        for _ in 0..self.options.rounds {
            done.rounds += 1;
            let from = self.set.taken_at;
            let goal = self.next_pose(target)?;
            let reach = self.reach_to(&goal.pose);
            // A motion that would lead hardly nearer, beside the last, is left for the next tick: contacts cost more than it brings.
            let least = (STUCK_SHARE * self.set.skin).min(REST_SHARE * gained);
            let would_stick = gained > 0.0
                && self.set.least_gap() >= LIFT_SHARE * self.set.skin
                && distance - self.distance_between(&goal.pose, target) <= least;
            if would_stick || reach <= STILL_SHARE * self.set.skin {
                return Ok(!self.solver.held().is_empty());
            }
            self.normals.clear();
            self.normals.extend(self.set.planes().iter().map(|plane| plane.normal));
            let how = WalkOptions::default().with_directions(&self.normals).with_tolerance(self.cast_tolerance());
            let walk = around.walk(&self.seated, (&from, &goal.pose), how)?;
            self.seated = walk.seated.clone();
            if walk.stop.is_some() {
                done.stopped += 1;
                self.stop(around, &goal.pose, (reach, stray), &walk)?;
                continue;
            }
            self.trust = if goal.is_at_bound { self.trust * TRUST_GROWTH } else { f64::INFINITY };
            self.arrive(around, &goal.pose, stray, None)?;
            if !goal.is_at_bound && self.solver.held().is_empty() {
                return Ok(false);
            }
            let left = self.distance_to(target);
            if distance - left <= STUCK_SHARE * self.set.skin {
                return Ok(!self.solver.held().is_empty());
            }
            (distance, gained) = (left, distance - left);
        }
        Ok(false)
    }

    /// Goes as far as a motion of this reach is free, and remembers what ended it.
    fn stop(&mut self, around: &Surroundings, to: &Pose, (reach, stray): (f64, f64), walk: &Walk) -> Result<()> {
        let Some(stop) = walk.stop else { return Ok(()) };
        let blocker = stop.pair.filter(|pair| !self.blockers.contains(pair));
        if blocker.is_none() {
            // What its row allowed it forbids: the motion was too long for a row.
            self.trust = (reach.min(self.trust) / TRUST_GROWTH).max(LEAST_TRUST * self.set.skin);
        }
        let reached = match stop.pair {
            Some(pair) => {
                self.remember(pair);
                if stop.is_seat {
                    walk.pose
                } else {
                    self.back_off(around, to, walk.fraction, &pair)?
                }
            }
            None => walk.pose,
        };
        self.arrive(around, &reached, stray, blocker)
    }

    /// Where the next motion leads. It starts off the surface: where the tool is nearer than half the skin, or its eroded part than half the
    /// rest of a seat, it is lifted first. And it turns no more than keeps its points, which move on arcs, within a part of the skin (at
    /// seats, of their rest) of the straight ways between two poses that satisfy the rows.
    fn next_pose(&mut self, target: &Pose) -> Result<NearestPose> {
        let (from, metric) = (self.set.taken_at, self.set.metric);
        let seat_gap = self.set.least_seat_gap();
        if self.set.least_gap() < LIFT_SHARE * self.set.skin || seat_gap < -LIFT_SHARE * SEAT_REST {
            return self.set.nearest_pose(&from, self.trust, &mut self.solver);
        }
        let goal = self.set.nearest_pose(target, self.trust, &mut self.solver)?;
        let way = displacement(&from, &goal.pose, &metric.centre);
        let (turn, most) = (length(&way.angular), (ARC_SKINS * seat_gap.max(SEAT_REST) / metric.radius).sqrt());
        if self.set.rows().is_empty() || turn <= most {
            return Ok(goal);
        }
        Ok(NearestPose { pose: displaced(&from, &(way * (most / turn)), &metric.centre)?, ..goal })
    }

    /// How far any point of the tool moves from here to a pose, metres.
    pub(crate) fn reach_to(&self, pose: &Pose) -> f64 {
        displacement(&self.set.taken_at, pose, &self.set.metric.centre).reach(self.set.metric.radius)
    }

    /// Where contacts hold the tool from several sides, the skin may be what closes a way: a peg at the mouth of a hole that it fits. So
    /// it is tried with less, and that is kept where it leads on by clearly more than the skin gave way.
    fn squeeze(&mut self, around: &Surroundings, target: &Pose, done: &mut Advance) -> Result<()> {
        let before = (self.set, self.blockers.clone(), self.trust);
        let distance = self.distance_to(target);
        self.skin = (SQUEEZE_SHARE * self.options.skin).min(self.skin);
        self.set.skin = self.skin;
        self.approach(around, target, 0.0, done)?;
        let gain = distance - self.distance_to(target);
        if gain > SQUEEZE_GAIN * self.options.skin {
            self.patience = 0;
            return Ok(());
        }
        self.skin = before.0.skin;
        (self.set, self.blockers, self.trust) = before;
        self.patience = (2 * self.patience + 1).min(MOST_PATIENCE);
        self.waited = 0;
        Ok(())
    }

    /// After each squeeze that led nowhere it is tried half as often.
    fn is_time_to_squeeze(&mut self) -> bool {
        self.waited += 1;
        self.waited > self.patience && self.solver.held().len() > 1 && self.skin > SQUEEZE_SHARE * self.options.skin
    }

    /// In the metric, metres.
    fn distance_to(&self, target: &Pose) -> f64 {
        self.distance_between(&self.set.taken_at, target)
    }

    fn distance_between(&self, pose: &Pose, target: &Pose) -> f64 {
        let metric = &self.set.metric;
        let way = displacement(pose, target, &metric.centre);
        metric.coordinates(pose, &way).iter().map(|x| x * x).sum::<f64>().sqrt()
    }

    /// Below the existing gaps, so that near surfaces at the start of a motion do not stop it.
    fn cast_tolerance(&self) -> f64 {
        let least = self.set.least_gap().min(self.set.skin);
        (CAST_SHARE * least).clamp(LEAST_CAST_TOLERANCE, LARGEST_CAST_TOLERANCE)
    }

    fn remember(&mut self, pair: Pair) {
        self.blockers.retain(|known| *known != pair);
        if self.blockers.len() == MOST_BLOCKERS {
            self.blockers.remove(0);
        }
        self.blockers.push(pair);
    }

    /// The last pose on a free way, which ends at a fraction, at which the pair that ends it is as far apart as half the skin; where it
    /// is nearer from the start, the start.
    fn back_off(&self, around: &Surroundings, to: &Pose, free: f64, pair: &Pair) -> Result<Pose> {
        let (from, tool) = (self.set.taken_at, around.tool());
        let motion = Motion::new(tool, &from, to);
        let least = BACK_OFF_SHARE * self.set.skin;
        let mut back = least / motion.longest_way();
        for _ in 0..BACK_OFF_HALVINGS {
            let time = free - back;
            if time <= 0.0 {
                break;
            }
            let pose = motion.at(time);
            let is_off = around.closest(&pose, pair).is_some_and(|c| c.distance >= least);
            if is_off && !around.is_colliding(&self.seated, &pose) {
                return Ok(pose);
            }
            back *= 2.0;
        }
        Ok(from)
    }

    /// Makes a pose the proxy's that is free but for seats: the rows are taken along, at most so far (metres), and what stopped it is added;
    /// farther than they are good for, contacts are found.
    fn arrive(&mut self, around: &Surroundings, pose: &Pose, most: f64, blocker: Option<Pair>) -> Result<()> {
        if !self.seated.is_free() || !self.set.take_along(pose, most) {
            return self.look_around(around, pose);
        }
        if let Some(pair) = blocker {
            self.push_blocker(around, pose, &pair);
        }
        Ok(())
    }

    /// Finds the contacts at a pose that is free but for seats, and makes it the proxy's.
    fn look_around(&mut self, around: &Surroundings, pose: &Pose) -> Result<()> {
        let margin = STRIDES * self.stride + SKINS_IN_MARGIN * self.skin;
        let margin = margin.max(LEAST_MARGIN * self.options.skin).min(self.options.margin);
        around.manifolds(&self.seated, pose, margin, &mut self.manifolds)?;
        let number = self.set.number + 1;
        self.set.clear(pose, self.manifolds.margin);
        if self.manifolds.manifolds.is_empty() {
            // Nothing is near: the servo side may go on as far as there really is nothing.
            let clearance = around.distance(&self.seated, pose, FREE_MARGIN)?.unwrap_or(FREE_MARGIN);
            self.set.margin = self.set.margin.max(clearance);
        }
        self.set.number = number;
        if !self.seated.is_free() {
            around.seat_manifolds(&self.seated, pose, margin, &mut self.seat_manifolds)?;
            self.set.margin = self.set.margin.min(self.seat_manifolds.margin);
            for manifold in &self.seat_manifolds.manifolds {
                let points = manifold.points().iter().map(|p| (p.point, p.gap - SEAT_REST));
                self.set.push_seat(plane_of(manifold), points);
            }
            for sunk in around.sunk_planes(&self.seated, pose)? {
                self.set.push_seat(sunk.plane, std::iter::once((sunk.point, sunk.room + SEAT_SLACK)));
            }
        }
        for manifold in &self.manifolds.manifolds {
            let plane = plane_of(manifold);
            self.set.push(plane, manifold.points().iter().map(|p| (p.point, p.gap)));
            let [tool_triangle, triangle] = manifold.triangles;
            let bodies = &around.environment().bodies;
            let body = bodies.iter().position(|body| body.part == Some(manifold.part)).unwrap_or(0) as u32;
            self.set.set_pair(plane.id, Pair { body, tool_triangle, triangle, seat: None });
        }
        self.push_blockers(around, pose);
        self.skin = self.fit_skin();
        self.set.skin = self.skin;
        Ok(())
    }

    /// Adds the rows of what stopped a cast and is still near, where no plane stands for it.
    fn push_blockers(&mut self, around: &Surroundings, pose: &Pose) {
        let mut blockers = std::mem::take(&mut self.blockers);
        blockers.retain(|pair| self.push_blocker(around, pose, pair));
        self.blockers = blockers;
    }

    /// The row of one pair; whether it is still near.
    fn push_blocker(&mut self, around: &Surroundings, pose: &Pose, pair: &Pair) -> bool {
        let margin = self.manifolds.margin;
        let closest = around.closest(pose, pair);
        let Some(closest) = closest.filter(|closest| closest.distance <= margin) else { return false };
        let Some(normal) = unit(&sub(&closest.on_p, &closest.on_q)) else { return true };
        let id = u64::from(pair.tool_triangle) << 32 ^ u64::from(pair.triangle) ^ 1 << 63;
        let part = around.environment().part_of(pair);
        let plane = Plane { point: closest.on_q, normal, gap: closest.distance, part, id };
        if pair.seat.is_some() {
            self.set.push_seat(plane, std::iter::once((closest.on_p, closest.distance - SEAT_REST)));
        } else {
            self.set.push(plane, std::iter::once((closest.on_p, closest.distance)));
            self.set.set_pair(id, *pair);
        }
        true
    }

    /// The skin for the current rows: the last one, or half the clearance where that is less; and wider again where that does not push
    /// the tool away. The clearance is what all rows can be off at once. In a wedge it is the less the deeper the tool is, so a skin
    /// that rows allow at all is not less than that of a squeeze: it keeps the tool from the wedge's end.
    fn fit_skin(&mut self) -> f64 {
        let Proxy { set, solver, options, skin, .. } = self;
        if set.rows().is_empty() {
            return options.skin;
        }
        let mut lift = |skin: f64| set.lift(skin, solver).unwrap_or(f64::INFINITY);
        let (wider, most) = ((SKIN_GROWTH * *skin).min(options.skin), MOST_LIFT * options.skin);
        if lift(wider / CLEARANCE_SHARE) <= most && (wider == *skin || lift(wider) <= SKIN_LIFT * wider) {
            return wider;
        }
        if lift(*skin / CLEARANCE_SHARE) <= most {
            return *skin;
        }
        let least = SQUEEZE_SHARE * options.skin;
        if *skin >= least && lift(least / CLEARANCE_SHARE).is_finite() {
            return least;
        }
        // Bisection of the logarithm; the clearance at the pose fits.
        let (mut low, mut high) = (set.least_gap().max(LEAST_CAST_TOLERANCE), *skin / CLEARANCE_SHARE);
        for _ in 0..SKIN_HALVINGS {
            let middle = (low * high).sqrt();
            if lift(middle).is_finite() {
                low = middle;
            } else {
                high = middle;
            }
        }
        (CLEARANCE_SHARE * low).min(*skin)
    }
}

fn plane_of(manifold: &Manifold) -> Plane {
    let Manifold { point, normal, gap, part, id, .. } = *manifold;
    Plane { point, normal, gap, part, id }
}

#[cfg(test)]
mod tests {
    use feeler_contacts::ContactSolver;
    use feeler_core::{Mockup, Scene, SceneOptions, Tool};
    use feeler_shapes::{box_mesh, Arrays};

    use super::*;
    use feeler_core::geometry::twist::{pose_of, rotation_of, rotation_vector};
    use feeler_world::Body;

    fn around((vertices, faces): Arrays, tool: Tool, start: &Pose) -> Surroundings {
        let mockup = Mockup::new(vertices, faces, vec![], 1).unwrap();
        let scene = Scene::build(Arc::new(mockup), &SceneOptions::default()).unwrap();
        let bodies = vec![Body { solver: ContactSolver::new(Arc::new(scene)), part: None }];
        Surroundings::around(bodies, Arc::new(tool), start).unwrap()
    }

    fn tool((vertices, faces): Arrays) -> Tool {
        Tool::new(vertices, faces).unwrap()
    }

    fn at(place: Point, turn: Point) -> Pose {
        pose_of(&rotation_of(&turn), &place).unwrap()
    }

    #[test]
    fn a_box_pressed_on_a_plate_lies_flat_a_skin_off_at_any_tessellation() {
        for (plate_cells, cells) in [(1, 1), (8, 8), (1, 8), (30, 1)] {
            let block = tool(box_mesh([0.0; 3], [0.03, 0.04, 0.05], cells));
            let metric = Metric::new(&block);
            let plate = box_mesh([0.0, 0.0, -0.01], [0.2, 0.15, 0.02], plate_cells);
            let around = around(plate, block, &at([0.0, 0.0, 0.04], [0.0; 3]));
            let mut proxy = Proxy::new(&around, metric, ProxyOptions::default()).unwrap();
            for k in 0..200 {
                let k = f64::from(k);
                let device = at([0.0002 * k, 0.0, 0.04 - 0.0001 * k], [0.1, 0.05, 0.0]);
                proxy.advance(&around, &device).unwrap();
                assert!(!around.is_colliding(proxy.seated(), proxy.pose()), "{k}");
            }
            let place = proxy.pose().translation();
            assert!((place[2] - 0.02502).abs() < 1e-7, "{place:?}");
            assert!((place[0] - 0.0398).abs() < 1e-5, "{place:?}");
            assert!(length(&rotation_vector(proxy.pose().rotation())) < 1e-4);
        }
    }
}
