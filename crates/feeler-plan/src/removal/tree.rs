//! A random tree of reachable poses of a part, grown until one of them is out.
//!
//! After rapidly exploring random trees (S. LaValle, 1998): a random distant pose is drawn, and the nearest node moves
//! towards it. Motions are cast, so they go as far as they are free, and a stopped one slides on: the rest of the
//! motion is projected onto the contacts. There is no goal but being out; straight paths out are tried from new nodes.

use std::sync::Arc;

use feeler_core::geometry::least_distance::{nearest, HalfSpace};
use feeler_core::geometry::twist::{displaced, displacement, pose_of, quaternion, rotation_of_quaternion, times};
use feeler_core::geometry::vectors::{dot, sub, unit};
use feeler_core::tool::metric::Metric;
use feeler_core::{closest_triangle_triangle, Motion, Point, Pose};

use crate::blocked::Tally;
use crate::constants::{
    BLOCKER_MARGIN, EXIT_EVERY, LONGEST_SLIDE, MOST_SLIDES, NODES_A_LIFE, SHORTEST_STEP, SLIDE_SKIN, STEP,
    STRAIGHT_SHARE, TURN_WEIGHT,
};
use crate::error::Result;
use crate::random::Random;
use crate::removal::verify::HasTime;
use feeler_world::{Seated, Surroundings, WalkOptions};

/// How long the lives of a search are that may take long by bad luck, in the unit of the first: 1, 1, 2, 1, 1, 2, 4, and so on. No other
/// sequence takes less but for a factor, whatever the luck is like (M. Luby, A. Sinclair and D. Zuckerman, 1993).
fn luby(life: u64) -> u64 {
    let whole = (life + 1).next_power_of_two();
    match whole == life + 1 {
        true => whole / 2,
        false => luby(life + 1 - whole / 2),
    }
}

/// One tree.
pub struct Tree<'a> {
    around: &'a Surroundings,
    metric: Metric,
    /// Half the weight of a turn in the square of a distance, square metres: see [`Tree::nearest`].
    turn: f64,
    directions: &'a [Point],
    has_time: HasTime<'a>,
    random: Random,
    nodes: Vec<Node>,
    /// How often it began anew, and once more.
    lives: u64,
    /// The attempts.
    pub tally: Tally,
    /// Where the legs of a way out end.
    pub way: Option<Vec<Pose>>,
}

/// A pose that can be reached.
#[derive(Debug, Clone)]
struct Node {
    pose: Pose,
    /// Of the metric's centre, world; and the rotation.
    place: Point,
    quaternion: [f64; 4],
    seated: Arc<Seated>,
    parent: usize,
}

impl<'a> Tree<'a> {
    /// Of the start alone. `directions`: along which straight ways out are tried.
    pub fn new(
        around: &'a Surroundings,
        directions: &'a [Point],
        (seed, number): (u64, u64),
        has_time: HasTime<'a>,
    ) -> Tree<'a> {
        let metric = Metric::new(around.tool());
        let lever = TURN_WEIGHT * metric.radius;
        let mut tree = Tree {
            around,
            turn: lever * lever,
            metric,
            directions,
            has_time,
            random: Random::new(seed, number),
            nodes: Vec::new(),
            lives: 1,
            tally: Tally::default(),
            way: None,
        };
        tree.push(*around.start(), around.seated_at_start(), 0);
        tree
    }

    /// Grows by that many casts, until a path is found or time runs out.
    pub fn grow(&mut self, casts: u64) -> Result<()> {
        let until = self.tally.casts + casts;
        while self.way.is_none() && self.tally.casts < until && (self.has_time)() {
            if self.nodes.len() as u64 > NODES_A_LIFE * luby(self.lives) {
                self.nodes.truncate(1);
                self.lives += 1;
            }
            self.extend()?;
        }
        Ok(())
    }

    fn push(&mut self, pose: Pose, seated: Arc<Seated>, parent: usize) -> usize {
        let place = pose.apply(&self.metric.centre);
        self.nodes.push(Node { pose, place, quaternion: quaternion(pose.rotation()), seated, parent });
        self.nodes.len() - 1
    }

    /// One sample: the nearest node towards it, sliding where it is stopped.
    fn extend(&mut self) -> Result<()> {
        let (place, mut q) = self.sample();
        let mut at = self.nearest(&place, &q);
        let turns = self.random.share() >= STRAIGHT_SHARE;
        if !turns {
            // Ducts are passed without a turn, and along walls, in long motions.
            q = self.nodes[at].quaternion;
        }
        let rotation = rotation_of_quaternion(&q);
        let target = pose_of(&rotation, &sub(&place, &times(&rotation, &self.metric.centre)))?;
        let mut target = if turns { self.no_farther_than(&self.nodes[at].pose, &target) } else { target };
        let mut blockers: Vec<[u32; 2]> = Vec::new();
        let mut normals: Vec<Point> = Vec::new();
        for _ in 0..=MOST_SLIDES {
            let from = self.nodes[at].pose;
            let seated = self.nodes[at].seated.clone();
            let walk = self.around.walk(&seated, (&from, &target), WalkOptions::search(&normals, self.has_time))?;
            self.tally.walked(self.around, &walk);
            let moved = Motion::new(self.around.tool(), &from, &walk.pose).longest_way();
            if moved > SHORTEST_STEP * self.around.size() {
                at = self.push(walk.pose, walk.seated, at);
                if self.leads_out(at)? {
                    return Ok(());
                }
            } else if walk.stop.is_none() {
                return Ok(());
            }
            let pair = walk.stop.and_then(|stop| stop.pair).filter(|pair| pair.seat.is_none());
            let Some(triangles) = pair.map(|pair| [pair.tool_triangle, pair.triangle]) else { return Ok(()) };
            if !blockers.contains(&triangles) {
                blockers.push(triangles);
            } else if moved <= SHORTEST_STEP * self.around.size() {
                return Ok(());
            }
            let Some(next) = self.slid((&self.nodes[at].pose, &target), turns, &mut blockers, &mut normals)? else {
                return Ok(());
            };
            target = next;
        }
        Ok(())
    }

    /// A pose far away.
    fn sample(&mut self) -> (Point, [f64; 4]) {
        let bounds = *self.around.bounds();
        let size = self.around.size();
        let place = std::array::from_fn(|a| self.random.between(bounds.lower[a] - size, bounds.upper[a] + size));
        (place, self.random.quaternion())
    }

    /// The node nearest to a place and a rotation: by the square of the way of the centre, and of the turn's chord at the lever.
    fn nearest(&self, place: &Point, q: &[f64; 4]) -> usize {
        let distance = |node: &Node| {
            let way = sub(&node.place, place);
            let cosine: f64 = node.quaternion.iter().zip(q).map(|(a, b)| a * b).sum();
            // The chord of half the angle, as between quaternions, is half that of the angle for small ones.
            dot(&way, &way) + 8.0 * self.turn * (1.0 - cosine.abs())
        };
        let (mut best, mut least) = (0, f64::INFINITY);
        for (i, node) in self.nodes.iter().enumerate() {
            let distance = distance(node);
            if distance < least {
                (best, least) = (i, distance);
            }
        }
        best
    }

    fn no_farther_than(&self, from: &Pose, target: &Pose) -> Pose {
        let motion = Motion::new(self.around.tool(), from, target);
        motion.at((STEP * self.around.size() / motion.longest_way()).min(1.0))
    }

    /// Where a motion goes on from a pose where pairs of triangles are in its way: the pose nearest to the target that keeps these off,
    /// turned by them or not.
    /// `normals` become those of the contacts.
    fn slid(
        &self,
        (from, target): (&Pose, &Pose),
        turns: bool,
        blockers: &mut Vec<[u32; 2]>,
        normals: &mut Vec<Point>,
    ) -> Result<Option<Pose>> {
        let (tool, size) = (self.around.tool(), self.around.size());
        let mesh = self.around.environment().bodies[0].solver.scene().mockup().mesh();
        let centre = from.apply(&self.metric.centre);
        let (skin, clearance) = (SLIDE_SKIN * size, self.around.clearance());
        let mut rows: Vec<HalfSpace> = Vec::new();
        normals.clear();
        blockers.retain(|[t, m]| {
            let closest =
                closest_triangle_triangle(&from.apply_triangle(&tool.mesh().triangle(*t)), &mesh.triangle(*m));
            if closest.distance > BLOCKER_MARGIN * size + clearance {
                return false;
            }
            if let Some(normal) = unit(&sub(&closest.on_p, &closest.on_q)) {
                normals.push(normal);
                // Without an arm a contact turns nothing.
                let arm = if turns { sub(&closest.on_p, &centre) } else { [0.0; 3] };
                rows.push(self.metric.half_space(from, &normal, &arm, skin + clearance - closest.distance));
            }
            true
        });
        let by = displacement(from, target, &self.metric.centre);
        let wished = self.metric.coordinates(from, &by);
        let found = nearest(&wished, &rows, skin, |_| false);
        let by = self.metric.displacement(from, &found.point);
        let reach = by.reach(self.metric.radius);
        if !found.is_feasible || reach < SHORTEST_STEP * size {
            return Ok(None);
        }
        let longest = if turns { LONGEST_SLIDE * size } else { f64::INFINITY };
        let by = by * (longest / reach).min(1.0);
        Ok(Some(displaced(from, &by, &self.metric.centre)?))
    }

    /// Whether a node is out, or a straight way from it is; then that is the way.
    fn leads_out(&mut self, at: usize) -> Result<bool> {
        let around = self.around;
        let Node { pose, seated, parent, .. } = self.nodes[at].clone();
        if around.is_out(&pose) {
            self.way = Some(self.way_to(at));
            return Ok(true);
        }
        if !(self.nodes.len() as u64).is_multiple_of(EXIT_EVERY) {
            return Ok(false);
        }
        let last = unit(&sub(&self.nodes[at].place, &self.nodes[parent].place));
        let drawn = match self.directions.len() {
            0 => None,
            count => Some(self.directions[self.random.below(count)]),
        };
        for direction in [last, drawn].into_iter().flatten() {
            let way = around.way_out(&pose, &direction);
            if !way.is_finite() {
                continue;
            }
            let end = around.moved(&pose, &direction, way)?;
            let walk = around.walk(&seated, (&pose, &end), WalkOptions::search(&[], self.has_time))?;
            self.tally.walked(around, &walk);
            if walk.stop.is_none() {
                let mut way = self.way_to(at);
                way.push(end);
                self.way = Some(way);
                return Ok(true);
            }
        }
        Ok(false)
    }

    fn way_to(&self, mut at: usize) -> Vec<Pose> {
        let mut way = Vec::new();
        while at != 0 {
            way.push(self.nodes[at].pose);
            at = self.nodes[at].parent;
        }
        way.reverse();
        way
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lives_are_those_of_luby() {
        assert_eq!((1..16).map(luby).collect::<Vec<_>>(), [1, 1, 2, 1, 1, 2, 4, 1, 1, 2, 1, 1, 2, 4, 8]);
    }
}
