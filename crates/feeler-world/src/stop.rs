//! Guarded moves: from a pose towards another, as far as contact allows.

use std::sync::Arc;

use feeler_core::geometry::vectors::{dot, length, scaled, sub};
use feeler_core::{Cast, Motion, Point, Pose, Tool};

use crate::constants::{IMPACT_MARGIN, STUCK, TOUCH};
use crate::environment::Environment;
use crate::error::Result;
use crate::seats::{Seat, Seated};
use crate::surroundings::Surroundings;
use crate::walk::{Stop, Walk, WalkOptions};

/// A tool that contact stops: it goes as far as its motion is free, for any number and speed of moves.
///
/// Surfaces in contact at the start are seats: it may slide along them and separate. A start without contact has no
/// seats.
#[derive(Debug)]
pub struct GuardedMove {
    environment: Environment,
    tool: Arc<Tool>,
    start: Pose,
    /// Until all have parted.
    seats: Option<(Surroundings, Arc<Seated>)>,
    /// Of the pose where the tool was last so near to something that rounding decides which way is free.
    stuck: Option<Surroundings>,
}

/// Where a guarded move came.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Moved {
    /// World from tool.
    pub pose: Pose,
    /// The impact that stopped it; `None` if it arrived.
    pub impact: Option<Impact>,
}

/// The impact that stops a tool.
#[derive(Debug, Clone, PartialEq)]
pub struct Impact {
    /// The share of the way that is free.
    pub fraction: f64,
    /// On the mock-up, world, metres.
    pub point: Point,
    /// Unit, from mock-up to tool.
    pub normal: Point,
    /// Of the mock-up.
    pub part: u32,
}

impl Impact {
    /// Of a cast that hit a part of the mock-up.
    pub fn new(hit: &Cast, part: u32) -> Impact {
        Impact { fraction: hit.fraction, point: hit.point, normal: hit.normal, part }
    }
}

impl GuardedMove {
    /// A tool at a pose.
    pub fn new(environment: Environment, tool: Arc<Tool>, pose: &Pose) -> Result<GuardedMove> {
        let mut begun = GuardedMove { environment, tool, start: *pose, seats: None, stuck: None };
        // A sunk part may be flush with its neighbour all around: no surfaces cross, and it is inside.
        let is_inside = || -> Result<bool> {
            let near = begun.environment.distance(&begun.tool, pose, TOUCH)?;
            Ok(near.is_some() && begun.environment.is_containing(&begun.tool, pose))
        };
        if begun.environment.is_colliding(&begun.tool, pose) || is_inside()? {
            let around = begun.around(pose)?;
            let seated = around.seated_at_start();
            begun.seats = Some((around, seated));
        }
        Ok(begun)
    }

    /// The seats that have not parted.
    pub fn seats(&self) -> Vec<Seat> {
        self.seats.as_ref().map_or_else(Vec::new, |(around, seated)| seated.of(around.seats()))
    }

    /// From a pose towards another. `tolerance`: of the casts; `off`: how far before an impact the tool stops, along its way, so that it is
    /// free there; metres.
    pub fn go(&mut self, from: &Pose, to: &Pose, tolerance: f64, off: f64) -> Result<Moved> {
        let Some((around, seated)) = &self.seats else { return self.go_free(from, to, tolerance, off) };
        let walk = around.stop_short(seated, (from, to), tolerance, off)?;
        let moved = self.ended(&walk, to)?;
        if walk.seated.is_free() {
            self.seats = None;
        } else if let Some((_, seated)) = &mut self.seats {
            *seated = walk.seated;
        }
        Ok(moved)
    }

    /// Along a motion, as far as contact allows; it stays where it is, with its seats. Also the free share.
    ///
    /// The motion may begin elsewhere than where this was made: what is seated is still as deep as there at most, and
    /// what has parted at the beginning is no seat. `tolerance`: of the casts, metres.
    pub fn along(&mut self, motion: &Motion, tolerance: f64) -> Result<(Moved, f64)> {
        let walk = match &self.seats {
            Some((around, seated)) => walk_of(around, seated, motion, tolerance),
            None => {
                let around = match self.stuck.take() {
                    Some(around) if *around.start() == self.start => around,
                    _ => self.around(&self.start)?,
                };
                let walk = walk_of(&around, &around.seated_at_start(), motion, tolerance);
                self.stuck = Some(around);
                walk
            }
        }?;
        let fraction = walk.fraction;
        Ok((self.ended(&walk, motion.end())?, fraction))
    }

    fn around(&self, pose: &Pose) -> Result<Surroundings> {
        Surroundings::around(self.environment.bodies.clone(), self.tool.clone(), pose)
    }

    /// From a pose at which nothing meets.
    fn go_free(&mut self, from: &Pose, to: &Pose, tolerance: f64, off: f64) -> Result<Moved> {
        let Some((hit, part)) = self.environment.cast(&self.tool, (from, to), tolerance)? else {
            return Ok(Moved { pose: *to, impact: None });
        };
        let way = Motion::new(&self.tool, from, to).longest_way();
        if hit.fraction * way < STUCK && way > STUCK {
            // Moved as if seated; accepted only if the exact test finds the end free.
            let around = match self.stuck.take() {
                Some(around) if around.start() == from => around,
                _ => self.around(from)?,
            };
            let walk = around.stop_short(&around.seated_at_start(), (from, to), tolerance, off)?;
            self.stuck = Some(around);
            if !self.environment.is_colliding(&self.tool, &walk.pose) {
                return self.ended(&walk, to);
            }
        }
        let pose = self.before(&hit, (from, to), tolerance, off)?;
        Ok(Moved { pose, impact: Some(Impact::new(&hit, part)) })
    }

    /// The pose `off` before an impact, up to which the way is free by another cast; or the one it came from.
    fn before(&self, hit: &Cast, (from, to): (&Pose, &Pose), tolerance: f64, off: f64) -> Result<Pose> {
        let motion = Motion::new(&self.tool, from, to);
        let mut back = if motion.longest_way() > 0.0 { off / motion.longest_way() } else { 1.0 };
        while back < hit.fraction {
            let before = motion.at(hit.fraction - back);
            if self.environment.cast(&self.tool, (from, &before), tolerance)?.is_none() {
                return Ok(before);
            }
            back *= 2.0;
        }
        Ok(*from)
    }

    fn ended(&self, walk: &Walk, to: &Pose) -> Result<Moved> {
        let impact = walk.stop.map(|stop| self.impact(walk, &stop, to)).transpose()?;
        Ok(Moved { pose: walk.pose, impact })
    }

    /// At the contact plane of the part that the way leads through; where there is none, at the nearest point.
    fn impact(&self, walk: &Walk, stop: &Stop, to: &Pose) -> Result<Impact> {
        let ahead = sub(to.translation(), walk.pose.translation());
        let (contacts, _) = self.environment.contacts(&self.tool, &walk.pose, IMPACT_MARGIN, None)?;
        let own = contacts.planes.iter().filter(|plane| plane.part == stop.part);
        let against = own.min_by(|a, b| dot(&a.normal, &ahead).total_cmp(&dot(&b.normal, &ahead)));
        let (point, normal) = match against {
            Some(plane) => (plane.point, plane.normal),
            None => {
                let near = self.environment.distance(&self.tool, &walk.pose, f64::INFINITY)?;
                let long = length(&ahead);
                let back = if long > 0.0 { scaled(&ahead, -1.0 / long) } else { [0.0, 0.0, 1.0] };
                (near.map_or(*walk.pose.translation(), |near| near.on_mockup), back)
            }
        };
        Ok(Impact { fraction: walk.fraction, point, normal, part: stop.part })
    }
}

impl Surroundings {
    /// A [walk](Self::walk) that ends `off` metres before the impact, or at its start if that is nearer, so that the next walk starts free.
    /// A walk that a seat stops ends at that seat. `tolerance`: of the casts, metres.
    fn stop_short(&self, seated: &Arc<Seated>, (from, to): (&Pose, &Pose), tolerance: f64, off: f64) -> Result<Walk> {
        let how = WalkOptions::default().with_tolerance(tolerance);
        let walk = self.walk(seated, (from, to), how)?;
        let Some(stop) = walk.stop.filter(|stop| !stop.is_seat) else { return Ok(walk) };
        let motion = Motion::new(&self.tool, from, to);
        let mut back = off / motion.longest_way();
        while back < walk.fraction {
            let fraction = walk.fraction - back;
            let before = self.walk(seated, (from, &motion.at(fraction)), how)?;
            if before.stop.is_none() {
                return Ok(Walk { fraction, stop: Some(stop), ..before });
            }
            back *= 2.0;
        }
        Ok(Walk { pose: *from, fraction: 0.0, seated: seated.clone(), stop: Some(stop), casts: walk.casts })
    }
}

/// Along a motion, with the seats that have not parted where it begins.
fn walk_of(around: &Surroundings, seated: &Arc<Seated>, motion: &Motion, tolerance: f64) -> Result<Walk> {
    let left = around.left_at(seated, &motion.at(0.0))?;
    let how = WalkOptions::default().with_tolerance(tolerance);
    around.walk_along(left.as_ref().unwrap_or(seated), motion, how, &mut |_| ())
}
