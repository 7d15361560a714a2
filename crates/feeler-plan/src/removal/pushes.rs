//! Pushes as a person would try them, breadth first: along the contacts, the part's own axes and the bores, as far as
//! possible; turns about axes and along threads; and at each point that a push reached, whether a direction across it
//! is free.
//!
//! After Y. Tian, J. Xu and others, *Assemble them all: physics-based planning for generalizable assembly by disassembly* (2022), who find
//! such pushes by physics; here each is a cast. Poses that differ little are one.

use std::collections::BinaryHeap;
use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;

use feeler_core::geometry::twist::displacement;
use feeler_core::geometry::vectors::{dot, length, scaled, sub};
use feeler_core::{Motion, Point, Pose, Screw};

use super::directions::{turned, Distinct};
use super::shape::Shape;
use super::twists::{footholds, Axis, Footholds};
use super::verify::HasTime;
use crate::blocked::Tally;
use crate::constants::{
    DIRECTION_MARGIN, FAR, FIRST_PUSHES, FIRST_TREE_ROUNDS, LEAST_LEVEL, LEAST_OPENING, LEAST_PUSH, LEAST_SCAN,
    LEAST_TURN, LITTLE_TURN, LONG_PUSH, MOST_AXES, MOST_NODES, MOST_SAMPLES, MOST_THREADED, MOST_TOUCHED,
    MOST_TURNS_OF_A_THREAD, NEXT_LEVEL, PROBE, PROBED, SAME_PLACE, SAMPLE_ANGLE, SAMPLE_STEP, SLIDE_SKIN,
    WORK_OF_A_CAST, YOUNG,
};
use crate::error::Result;
use feeler_world::{Seated, Surroundings, WalkOptions};

/// A search by pushes.
pub struct Pushes<'a> {
    around: &'a Surroundings,
    has_time: HasTime<'a>,
    /// Of the caller, units, world, each with its opposite.
    first: Vec<Point>,
    shape: Shape,
    nodes: Vec<Node>,
    tasks: BinaryHeap<Task>,
    /// The number of tasks so far: the next one's number.
    count: u64,
    scan: Option<Scan>,
    /// Bound of a little motion, as a share of the largest: where nothing is left to try, it begins anew with less.
    level: f64,
    others: Vec<Point>,
    /// Done so far, in collisions.
    work: u64,
    /// The attempts.
    pub tally: Tally,
    /// The motions of a way out.
    pub way: Option<Vec<Motion>>,
}

/// A pose that can be reached.
#[derive(Debug, Clone)]
struct Node {
    pose: Pose,
    seated: Arc<Seated>,
    parent: usize,
    /// From the parent.
    motions: Vec<Motion>,
    depth: u32,
    /// Along which it is pushed from here, units, world.
    directions: Vec<Point>,
    /// Contact normals there: along these it probably leaves its neighbours.
    normals: Vec<Point>,
}

/// Something to try; the cheapest first, and of equal ones the oldest.
#[derive(Debug)]
struct Task {
    cost: u32,
    number: u64,
    node: usize,
    what: What,
}

#[derive(Debug)]
enum What {
    /// To look around.
    Look,
    Pull(Point),
    /// By this, radians.
    Turn(Axis, f64),
    /// Along a motion that is free.
    Scan(Box<Motion>),
}

impl PartialEq for Task {
    fn eq(&self, other: &Task) -> bool {
        (self.cost, self.number) == (other.cost, other.number)
    }
}

impl Eq for Task {}

impl Ord for Task {
    fn cmp(&self, other: &Task) -> std::cmp::Ordering {
        (other.cost, other.number).cmp(&(self.cost, self.number))
    }
}

impl PartialOrd for Task {
    fn partial_cmp(&self, other: &Task) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

/// Looking for openings beside a motion.
#[derive(Debug)]
struct Scan {
    node: usize,
    motion: Motion,
    samples: usize,
    at: usize,
    directions: Vec<Point>,
    /// By direction and sample: how far it goes, as a share of [`PROBE`].
    free: Vec<Vec<f64>>,
}

/// Cost of a task beside the depth of its node.
const LOOK: u32 = 0;
const PULL: u32 = 1;
const OTHER_PULL: u32 = 2;
const TURN: u32 = 3;
const SCAN: u32 = 5;
/// And for each step of depth; more for a short one, which may be play, and for one along any direction.
const DEEPER: u32 = 4;
const LATER: u32 = 4;

impl<'a> Pushes<'a> {
    /// From the start. `first`: directions of the caller; `others`: along which it is pushed from there once (units, world).
    pub fn new(around: &'a Surroundings, first: &[Point], others: &[Point], has_time: HasTime<'a>) -> Pushes<'a> {
        let mut directions = Distinct::default();
        first.iter().for_each(|direction| directions.push_both(direction));
        let mut pushes = Pushes {
            around,
            has_time,
            first: directions.0,
            shape: Shape::new(around.tool()),
            nodes: Vec::new(),
            tasks: BinaryHeap::new(),
            count: 0,
            scan: None,
            level: 1.0,
            others: others.to_vec(),
            work: 0,
            tally: Tally::default(),
            way: None,
        };
        pushes.begin();
        pushes
    }

    fn begin(&mut self) {
        self.nodes.clear();
        self.push((*self.around.start(), self.around.seated_at_start()), 0, Vec::new());
        let known = self.start_directions();
        let others = self.others.clone();
        for direction in others.iter().filter(|other| known.iter().all(|own| dot(own, other) < 1.0 - 1e-9)) {
            self.add(0, OTHER_PULL, What::Pull(*direction));
        }
    }

    /// Directions along which it is pushed at the start anyway.
    fn start_directions(&self) -> Vec<Point> {
        let mut directions = Distinct(self.first.clone());
        let start = self.around.start().rotation();
        self.shape.directions.iter().for_each(|axis| directions.push_both(&turned(start, axis)));
        directions.0
    }

    /// Whether trees wait, after that many rounds: paths that a person would find are found soon.
    pub fn are_alone(&self, tree_rounds: u32) -> bool {
        let waits = if tree_rounds < FIRST_TREE_ROUNDS { FIRST_PUSHES } else { YOUNG };
        self.level == 1.0 && self.work < waits && !self.tasks.is_empty()
    }

    /// Continues for the work of that many casts, until a path is found, nothing is left to try, or time runs out.
    pub fn grow(&mut self, casts: u64) -> Result<()> {
        let until = self.work + WORK_OF_A_CAST * casts;
        while self.way.is_none() && self.work < until && (self.has_time)() {
            if let Some(scan) = self.scan.take() {
                self.go_on(scan)?;
                continue;
            }
            let Some(Task { node, what, .. }) = self.tasks.pop() else {
                if self.level < LEAST_LEVEL {
                    return Ok(());
                }
                self.level *= NEXT_LEVEL;
                self.begin();
                continue;
            };
            match what {
                What::Look => self.look(node)?,
                What::Pull(direction) => self.pull(node, &direction)?,
                What::Turn(axis, angle) => self.turn(node, &axis, angle)?,
                What::Scan(motion) => self.begin_scan(node, *motion),
            }
        }
        Ok(())
    }

    fn add(&mut self, node: usize, cost: u32, what: What) {
        self.count += 1;
        let cost = self.nodes[node].depth + cost;
        self.tasks.push(Task { cost, number: self.count, node, what });
    }

    /// Whether poses are one.
    fn is_same(&self, a: &Pose, b: &Pose) -> bool {
        let by = displacement(a, b, self.around.middle());
        by.reach(0.5 * self.around.size()) < self.level * SAME_PLACE * self.around.size()
    }

    /// Adds a node, unless its pose is known.
    fn push(&mut self, (pose, seated): (Pose, Arc<Seated>), parent: usize, motions: Vec<Motion>) {
        self.push_after((pose, seated), parent, motions, false);
    }

    /// The same; `is_odd`: neither the part nor its contacts suggest the motion's direction.
    fn push_after(&mut self, (pose, seated): (Pose, Arc<Seated>), parent: usize, motions: Vec<Motion>, is_odd: bool) {
        if self.nodes.len() >= MOST_NODES || self.nodes.iter().any(|node| self.is_same(&node.pose, &pose)) {
            return;
        }
        let moved: f64 = motions.iter().map(Motion::longest_way).sum();
        let later = if moved > LONG_PUSH * self.around.size() && !is_odd { 0 } else { LATER };
        let depth = if self.nodes.is_empty() { 0 } else { self.nodes[parent].depth + DEEPER + later };
        self.nodes.push(Node { pose, seated, parent, motions, depth, directions: Vec::new(), normals: Vec::new() });
        self.add(self.nodes.len() - 1, LOOK, What::Look);
    }

    /// Finds the pushes to try at a node.
    fn look(&mut self, at: usize) -> Result<()> {
        let around = self.around;
        let pose = self.nodes[at].pose;
        if around.is_out(&pose) {
            self.way = Some(self.way_to(at));
            return Ok(());
        }
        let Footholds { normals, axes } = footholds(around, &pose, DIRECTION_MARGIN * around.size())?;
        let mut directions = Distinct(self.first.clone());
        // As it is turned here, and as it was at the start: its neighbours are mostly along these.
        let turn = length(&displacement(around.start(), &pose, around.middle()).angular);
        let here = if turn > LITTLE_TURN { &pose } else { around.start() };
        for at in [here, around.start()] {
            self.shape.directions.iter().for_each(|axis| directions.push_both(&turned(at.rotation(), axis)));
        }
        axes.iter().for_each(|axis| directions.push_both(&axis.along));
        normals.iter().take(MOST_TOUCHED).for_each(|normal| directions.push_both(normal));
        let mut distinct = directions.0;
        distinct.truncate(2 * MOST_AXES);
        self.nodes[at].directions.clone_from(&distinct);
        self.nodes[at].normals = normals;
        for direction in &distinct {
            self.add(at, PULL, What::Pull(*direction));
        }
        let middle = pose.apply(around.middle());
        let cylinders =
            self.shape.cylinders.iter().map(|(along, point)| (turned(pose.rotation(), along), pose.apply(point)));
        let own = self.shape.directions.iter().map(|along| (turned(pose.rotation(), along), middle));
        let plain: Vec<Axis> = cylinders.chain(own).map(|(along, point)| Axis { along, point, pitch: 0.0 }).collect();
        let mut all: Vec<Axis> = axes;
        for axis in plain {
            let is_known = |known: &Axis| {
                let arm = sub(&known.point, &axis.point);
                let across = sub(&arm, &scaled(&axis.along, dot(&arm, &axis.along)));
                known.pitch == 0.0
                    && dot(&known.along, &axis.along).abs() > 1.0 - 1e-9
                    && length(&across) < 1e-6 * around.size()
            };
            if !all.iter().any(is_known) {
                all.push(axis);
            }
        }
        for axis in all {
            for sense in [1.0, -1.0] {
                let most =
                    if axis.pitch == 0.0 { std::f64::consts::PI } else { self.out_of_thread(&pose, &axis, sense) };
                self.add(at, TURN, What::Turn(axis, sense * most));
            }
        }
        Ok(())
    }

    /// How far to turn until a thread has brought it out, radians.
    fn out_of_thread(&self, pose: &Pose, axis: &Axis, sense: f64) -> f64 {
        let along = scaled(&axis.along, sense * axis.pitch.signum());
        let way = self.around.way_out(pose, &along);
        let turns = (way / axis.pitch.abs()).min(MOST_TURNS_OF_A_THREAD);
        turns * std::f64::consts::TAU
    }

    /// Moves from a node as far as that is free. Returns the motion until there (`None` if it is no more than play), the parts still seated,
    /// and whether all of it was free.
    fn walk(
        &mut self,
        node: usize,
        seated: &Arc<Seated>,
        motion: &Motion,
    ) -> Result<(Option<Motion>, Arc<Seated>, bool)> {
        let around = self.around;
        // Most are blocked within the play, which a collision tells sooner than a cast.
        let soon = (self.level * LEAST_PUSH * around.size() / motion.longest_way()).min(1.0);
        self.work += 1;
        let there = motion.at(soon);
        if around.is_colliding(seated, &there) {
            let here = motion.at(0.0);
            for part in around.colliding_parts(seated, &there) {
                self.tally.note(part, around.reach(&here), &here);
            }
            return Ok((None, seated.clone(), false));
        }
        let how = WalkOptions::search(&self.nodes[node].normals, self.has_time);
        let walk = around.walk_along(seated, motion, how, &mut |_| ())?;
        self.tally.walked(self.around, &walk);
        self.work += WORK_OF_A_CAST * walk.casts;
        // A little before what stopped it: along that the next push slides.
        let skin = if walk.stop.is_some() { SLIDE_SKIN * around.size() } else { 0.0 };
        let moved = motion.longest_way() * walk.fraction - skin;
        let far = moved > self.level * LEAST_PUSH * around.size();
        let kept = if far { Some(motion.until(around.tool(), moved / motion.longest_way())?) } else { None };
        Ok((kept, walk.seated, walk.stop.is_none()))
    }

    fn pull(&mut self, at: usize, direction: &Point) -> Result<()> {
        let Node { pose, seated, .. } = self.nodes[at].clone();
        let Some(motion) = self.to_the_outside(&pose, direction)? else { return Ok(()) };
        let (kept, left, is_free) = self.walk(at, &seated, &motion)?;
        let Some(kept) = kept else { return Ok(()) };
        let end = (*kept.end(), left);
        if is_free {
            let mut way = self.way_to(at);
            way.push(kept);
            self.way = Some(way);
            return Ok(());
        }
        let is_odd = !self.nodes[at].directions.contains(direction);
        if !is_odd {
            self.add_scan(at, SCAN, &kept);
        }
        self.push_after(end, at, vec![kept], is_odd);
        Ok(())
    }

    /// Looks for openings beside a motion, unless it is a short one.
    fn add_scan(&mut self, at: usize, cost: u32, motion: &Motion) {
        if motion.longest_way() > LEAST_SCAN * self.around.size() {
            self.add(at, cost, What::Scan(Box::new(motion.clone())));
        }
    }

    /// Straight to the outside, or a long way; `None` where that is nowhere.
    fn to_the_outside(&self, pose: &Pose, direction: &Point) -> Result<Option<Motion>> {
        let around = self.around;
        let way = around.way_out(pose, direction);
        if !way.is_finite() {
            return Ok(None);
        }
        let end = around.moved(pose, direction, way)?;
        Ok(Some(Motion::new(around.tool(), pose, &end)))
    }

    fn turn(&mut self, at: usize, axis: &Axis, angle: f64) -> Result<()> {
        if axis.pitch != 0.0 {
            return self.thread(at, axis, angle);
        }
        let Node { pose, seated, .. } = self.nodes[at].clone();
        let turned = |by: f64| Screw::new(&axis.along, &axis.point, by, 0.0);
        // Squared again is where a person stops, though nothing does.
        let quarter = angle.signum() * FRAC_PI_2;
        let first = if angle.abs() > FRAC_PI_2 { quarter } else { angle };
        let tool = self.around.tool().clone();
        let (kept, left, is_free) = self.walk(at, &seated, &Motion::screw(&tool, &pose, &turned(first)?)?)?;
        let Some(kept) = kept.filter(|kept| kept.angle() > self.level * LEAST_TURN) else { return Ok(()) };
        self.add_scan(at, SCAN - 1, &kept);
        let end = *kept.end();
        self.push((end, left.clone()), at, vec![kept.clone()]);
        if !is_free || first == angle {
            return Ok(());
        }
        let (rest, left, _) = self.walk(at, &left, &Motion::screw(&tool, &end, &turned(angle - first)?)?)?;
        let Some(rest) = rest.filter(|rest| rest.angle() > self.level * LEAST_TURN) else { return Ok(()) };
        let whole = Motion::screw(&tool, &pose, &turned(first + angle.signum() * rest.angle())?)?;
        self.add_scan(at, SCAN - 1, &whole);
        self.push((*rest.end(), left), at, vec![whole]);
        Ok(())
    }

    /// Along a thread. Its pitch is known only about: it is measured over a turn, after which facets are where they were, between the middles
    /// of the play. Where a screw ends at a flank all the same it goes on from the middle.
    fn thread(&mut self, at: usize, axis: &Axis, angle: f64) -> Result<()> {
        let Node { pose, seated, .. } = self.nodes[at].clone();
        let tool = self.around.tool().clone();
        let screw = |left: f64, pitch: f64| Screw::new(&axis.along, &axis.point, left, pitch);
        let begin = self.middle_of_play(&seated, &pose, axis)?;
        let turn = angle.signum() * angle.abs().min(std::f64::consts::TAU);
        let (kept, parted, _) = self.walk(at, &seated, &Motion::screw(&tool, &begin, &screw(turn, axis.pitch)?)?)?;
        let Some(kept) = kept.filter(|kept| kept.angle() > self.level * LEAST_TURN) else { return Ok(()) };
        let middle = self.middle_of_play(&parted, kept.end(), axis)?;
        let off = dot(&sub(middle.translation(), kept.end().translation()), &axis.along);
        let pitch = axis.pitch + off * std::f64::consts::TAU / (angle.signum() * kept.angle());
        let mut motions = Vec::new();
        if begin != pose {
            motions.push(Motion::new(&tool, &pose, &begin));
        }
        let (mut pose, mut seated, mut left) = (begin, seated, angle);
        for _ in 0..MOST_THREADED {
            let motion = Motion::screw(&tool, &pose, &screw(left, pitch)?)?;
            let (kept, parted, is_free) = self.walk(at, &seated, &motion)?;
            let Some(kept) = kept.filter(|kept| is_free || kept.angle() > self.level * LEAST_TURN) else { break };
            (pose, seated, left) = (*kept.end(), parted, left - left.signum() * kept.angle());
            motions.push(kept);
            if is_free {
                break;
            }
            let middle = self.middle_of_play(&seated, &pose, axis)?;
            motions.push(Motion::new(&tool, &pose, &middle));
            pose = middle;
        }
        if motions.iter().any(|motion| motion.angle() > 0.0) {
            self.push((pose, seated), at, motions);
        }
        Ok(())
    }

    /// The middle of a pose's free play along an axis, at most a quarter of the pitch to each side.
    fn middle_of_play(&mut self, seated: &Arc<Seated>, pose: &Pose, axis: &Axis) -> Result<Pose> {
        let far = 0.25 * axis.pitch.abs();
        let mut play = [0.0; 2];
        for (sense, play) in [1.0, -1.0].into_iter().zip(&mut play) {
            let end = self.around.moved(pose, &axis.along, sense * far)?;
            let walk = self.around.walk(seated, (pose, &end), WalkOptions::search(&[], self.has_time))?;
            self.tally.walked(self.around, &walk);
            self.work += WORK_OF_A_CAST * walk.casts;
            *play = walk.fraction * far;
        }
        let by = 0.5 * (play[0] - play[1]);
        let is_there = by.abs() < SLIDE_SKIN * self.around.size();
        Ok(if is_there { *pose } else { self.around.moved(pose, &axis.along, by)? })
    }

    fn begin_scan(&mut self, node: usize, motion: Motion) {
        let size = self.around.size();
        let step = (SAMPLE_STEP * size / motion.longest_way()).min(match motion.angle() {
            0.0 => f64::INFINITY,
            angle => SAMPLE_ANGLE / angle,
        });
        let samples = ((1.0 / step).ceil() as usize).clamp(1, MOST_SAMPLES);
        let along = motion.direction();
        let across = |direction: &&Point| along.is_none_or(|along| dot(&along, direction).abs() < 0.9);
        let directions: Vec<Point> = self.nodes[node].directions.iter().filter(across).copied().collect();
        let free = vec![Vec::with_capacity(samples); directions.len()];
        self.scan = Some(Scan { node, motion, samples, at: 0, directions, free });
    }

    /// The next sample of a scan, or the scan's result.
    fn go_on(&mut self, mut scan: Scan) -> Result<()> {
        if scan.at == scan.samples {
            return self.openings(&scan);
        }
        scan.at += 1;
        let time = scan.at as f64 / scan.samples as f64;
        let (pose, seated) = self.sample(&scan, time)?;
        for (direction, free) in scan.directions.iter().zip(&mut scan.free) {
            free.push(self.probe(&seated, &pose, direction)?);
        }
        self.scan = Some(scan);
        Ok(())
    }

    /// How far it goes from a pose, as a share of [`PROBE`], by collisions at a few places: a wall between two of them is not seen. What
    /// looks free is cast later.
    fn probe(&mut self, seated: &Seated, pose: &Pose, direction: &Point) -> Result<f64> {
        let mut free = 0.0;
        for share in PROBED {
            let there = self.around.moved(pose, direction, share * PROBE * self.around.size())?;
            self.work += 1;
            if self.around.is_colliding(seated, &there) {
                break;
            }
            free = share;
        }
        Ok(free)
    }

    fn sample(&self, scan: &Scan, time: f64) -> Result<(Pose, Arc<Seated>)> {
        let pose = scan.motion.at(time);
        let seated = self.nodes[scan.node].seated.clone();
        let left = if self.around.has_seats() { self.around.left_at(&seated, &pose)? } else { None };
        Ok((pose, left.unwrap_or(seated)))
    }

    /// Where a direction was freer than beside: there it is tried on.
    fn openings(&mut self, scan: &Scan) -> Result<()> {
        for (direction, free) in scan.directions.iter().zip(&scan.free) {
            let mut sorted = free.clone();
            sorted.sort_by(f64::total_cmp);
            // What is nearly everywhere is play.
            let least = sorted[sorted.len() / 4];
            let mut k = 0;
            while k < free.len() {
                let is_open = |k: &usize| free[*k] > least + LEAST_OPENING && (least < 1.0 || free[*k] >= FAR);
                if !is_open(&k) {
                    k += 1;
                    continue;
                }
                let run = (k..free.len()).take_while(is_open).count();
                // In the middle of the farthest.
                let most = free[k..k + run].iter().copied().fold(0.0, f64::max);
                let best: Vec<usize> = (k..k + run).filter(|i| free[*i] >= most).collect();
                let is_everywhere = run == free.len() && best.len() == run;
                k += run;
                if is_everywhere {
                    continue; // No place is better than the ends.
                }
                let at = best[best.len() / 2];
                self.go_in(scan, (at + 1) as f64 / scan.samples as f64, direction)?;
                if self.way.is_some() {
                    return Ok(());
                }
            }
        }
        Ok(())
    }

    /// Goes along a scan's motion until a time, and from there on in a direction.
    fn go_in(&mut self, scan: &Scan, time: f64, direction: &Point) -> Result<()> {
        let (pose, seated) = self.sample(scan, time)?;
        let before = scan.motion.until(self.around.tool(), time)?;
        let Some(motion) = self.to_the_outside(&pose, direction)? else { return Ok(()) };
        let (kept, left, is_free) = self.walk(scan.node, &seated, &motion)?;
        let Some(kept) = kept else { return Ok(()) };
        if is_free {
            let mut way = self.way_to(scan.node);
            way.extend([before, kept]);
            self.way = Some(way);
            return Ok(());
        }
        // A node where it left the motion, from which the opening can be scanned, and one at its end.
        let (node, known, end) = (scan.node, self.nodes.len(), (*kept.end(), left));
        self.push((pose, seated), node, vec![before.clone()]);
        if self.nodes.len() > known {
            self.nodes[known].directions = self.nodes[node].directions.clone();
            self.add_scan(known, SCAN, &kept);
            self.push(end, known, vec![kept]);
        } else {
            self.push(end, node, vec![before, kept]);
        }
        Ok(())
    }

    fn way_to(&self, mut at: usize) -> Vec<Motion> {
        let mut way = Vec::new();
        while at != 0 {
            way.extend(self.nodes[at].motions.iter().rev().cloned());
            at = self.nodes[at].parent;
        }
        way.reverse();
        way
    }
}
