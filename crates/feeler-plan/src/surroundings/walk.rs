//! How far the tool moves freely from a pose towards another.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use feeler_contacts::{ContactPlane, ContactSolver};
use feeler_core::geometry::vectors::{dot, length, scaled, sub};
use feeler_core::{Aabb, Cast, Motion, Point, Pose, Scene, Tool, Touching};

use super::place::crossing_outside;
use super::seated::{Makings, Seated};
use super::seats::{find_seats, Allowed, Seat, SeatKind};
use crate::blocked::Tally;
use crate::constants::{
    CLEARANCE_SHARE, CLEARANCE_SLACK, CLEARANCE_STEP, EXIT_MARGIN, SEAT_TOLERANCE, STEPS_A_LENGTH, TOUCH, VERIFY_FINER,
};
use crate::error::Result;

/// How closely seated pairs are measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Care<'a> {
    /// While ways are sought. Along these directions (units, world) the tool is probably off what is near: casts take less time.
    Search(&'a [Point]),
    /// Before a way is given.
    Verify,
}

/// A motion as far as it is free.
#[derive(Debug, Clone)]
pub struct Walk {
    /// Where it ends.
    pub pose: Pose,
    /// What is still seated there.
    pub seated: Arc<Seated>,
    /// The part that ends it; `None` where all of it is free.
    pub stop: Option<Stop>,
}

/// A share of a motion along which the same pairs are seated.
#[derive(Debug, Clone)]
pub struct Span {
    /// Not parted yet.
    pub seated: Arc<Seated>,
    /// Where it begins.
    pub from: Pose,
    /// Where it ends.
    pub to: Pose,
}

/// What ends a motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stop {
    /// Of the mock-up.
    pub part: u32,
    /// Of the tool and of the mock-up; `None` where a depth was measured.
    pub triangles: Option<[u32; 2]>,
}

/// A tool in a scene, with what it may touch there.
#[derive(Debug)]
pub struct Surroundings {
    makings: Makings,
    tool: Arc<Tool>,
    start: Pose,
    overlap: f64,
    clearance: f64,
    refused: Vec<[u32; 2]>,
    /// Around all that is there.
    bounds: Aabb,
    /// The middle of the tool's box, tool frame.
    middle: Point,
    /// The diagonal of the tool's box, metres.
    size: f64,
    /// Each way of being seated once.
    known: Mutex<BTreeMap<Vec<bool>, Arc<Seated>>>,
}

/// A share of a motion, and what ends it.
struct Part {
    fraction: f64,
    end: End,
}

/// Pairs that are in each other, at a pose.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Depth {
    /// All that were are.
    Held,
    /// Some have no plane any more.
    Parting,
    /// One is deeper than it may be.
    TooDeep(Stop),
}

enum End {
    Arrived,
    Stopped(Stop),
    Parted(Arc<Seated>),
}

impl Surroundings {
    /// Of a tool at its start, in the scene without it. Tool parts from `own_parts` on are what grips.
    ///
    /// Errors: what grips meets something at the start.
    pub fn new(
        solver: &ContactSolver,
        tool: Arc<Tool>,
        own_parts: u32,
        start: &Pose,
        allowed: &Allowed,
        clearance: f64,
    ) -> Result<Surroundings> {
        let scene = solver.scene();
        let mockup = scene.mockup();
        let parts =
            (0..).zip(mockup.part_bounds()).filter(|(part, bounds)| scene.has_part(*part) && !bounds.is_empty());
        let bounds = parts.fold(Aabb::EMPTY, |all, (_, bounds)| all.union(bounds));
        let mut makings = Makings {
            solver: solver.with_scene(scene.clone()),
            tool_parts: tool.parts() as u32,
            seats: Vec::new(),
            always: allowed.parts.clone(),
            neighbours: None,
        };
        let asked = makings.seated(Vec::new()).ordinary;
        let asked_solver = solver.with_scene(Arc::new(asked.clone()));
        let found = find_seats((&asked_solver, &asked), &tool, own_parts, start, allowed, clearance)?;
        if !found.seats.is_empty() {
            let mut neighbours: Vec<u32> = found.seats.iter().map(|seat| seat.part).collect();
            neighbours.sort_unstable();
            neighbours.dedup();
            makings.neighbours = Some(scene.only(&neighbours)?);
        }
        makings.seats = found.seats;
        let own = tool.mesh().bounds();
        Ok(Surroundings {
            makings,
            start: *start,
            overlap: allowed.overlap,
            clearance,
            refused: found.refused,
            bounds,
            middle: std::array::from_fn(|a| 0.5 * own.lower[a] + 0.5 * own.upper[a]),
            size: length(&own.extent()),
            tool,
            known: Mutex::default(),
        })
    }

    /// What moves.
    pub fn tool(&self) -> &Arc<Tool> {
        &self.tool
    }

    /// Its contacts with all that is there.
    pub fn solver(&self) -> &ContactSolver {
        &self.makings.solver
    }

    /// Where it starts.
    pub fn start(&self) -> &Pose {
        &self.start
    }

    /// The diagonal of its box, metres.
    pub fn size(&self) -> f64 {
        self.size
    }

    /// How far it stays off what is not seated, metres.
    pub fn clearance(&self) -> f64 {
        self.clearance
    }

    /// The middle of its box, tool frame, metres.
    pub fn middle(&self) -> &Point {
        &self.middle
    }

    /// Around all that is there, world.
    pub fn bounds(&self) -> &Aabb {
        &self.bounds
    }

    /// Pairs `[tool part, part]` that meet at the start though nothing allows it.
    pub fn refused(&self) -> &[[u32; 2]] {
        &self.refused
    }

    /// Whether any pair is together at the start.
    pub fn has_seats(&self) -> bool {
        !self.makings.seats.is_empty()
    }

    /// Whether casts decide it all: then verifying a motion is casting it once more.
    pub fn casts_decide(&self) -> bool {
        let is_cast = |seat: &Seat| matches!(seat.kind, SeatKind::Near | SeatKind::Flush);
        self.overlap == 0.0 && self.makings.seats.iter().all(is_cast)
    }

    /// All seats as at the start.
    pub fn seated_at_start(&self) -> Arc<Seated> {
        self.seated(vec![true; self.makings.seats.len()])
    }

    fn seated(&self, holds: Vec<bool>) -> Arc<Seated> {
        let mut known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(seated) = known.get(&holds) {
            return seated.clone();
        }
        let seated = Arc::new(self.makings.seated(holds.clone()));
        known.insert(holds, seated.clone());
        seated
    }

    /// How far its middle is from where it starts, metres.
    pub fn reach(&self, pose: &Pose) -> f64 {
        length(&sub(&pose.apply(&self.middle), &self.start.apply(&self.middle)))
    }

    /// How far it has to move along a direction (unit) until its box is off the box of all that is there, metres; 0 where it is.
    pub fn way_out(&self, pose: &Pose, direction: &Point) -> f64 {
        let own = self.box_at(pose);
        let beyond = EXIT_MARGIN * self.size + self.clearance;
        let along = |a: usize| {
            let gap = match direction[a] {
                d if d > 0.0 => self.bounds.upper[a] - own.lower[a] + beyond,
                d if d < 0.0 => own.upper[a] - self.bounds.lower[a] + beyond,
                _ => return if self.is_beside(&own, a, beyond) { 0.0 } else { f64::INFINITY },
            };
            (gap / direction[a].abs()).max(0.0)
        };
        (0..3).map(along).fold(f64::INFINITY, f64::min)
    }

    /// Whether its box is off the box of all that is there.
    pub fn is_out(&self, pose: &Pose) -> bool {
        let own = self.box_at(pose);
        let beyond = 0.5 * EXIT_MARGIN * self.size + self.clearance;
        self.bounds.is_empty() || (0..3).any(|a| self.is_beside(&own, a, beyond))
    }

    fn is_beside(&self, own: &Aabb, a: usize, beyond: f64) -> bool {
        own.lower[a] > self.bounds.upper[a] + beyond || own.upper[a] < self.bounds.lower[a] - beyond
    }

    fn box_at(&self, pose: &Pose) -> Aabb {
        let own = self.tool.mesh().bounds();
        let mut around = Aabb::EMPTY;
        for corner in 0..8 {
            let side = |a: usize| if corner >> a & 1 == 0 { own.lower[a] } else { own.upper[a] };
            around.grow(&pose.apply(&[side(0), side(1), side(2)]));
        }
        around
    }

    /// The pose moved along a direction. Errors: beyond the coordinate limit.
    pub fn moved(&self, pose: &Pose, direction: &Point, by: f64) -> Result<Pose> {
        Ok(pose.translated(&scaled(direction, by))?)
    }

    /// Moves from a pose towards another, as far as that is free; what stops it is noted.
    pub fn walk(
        &self,
        seated: &Arc<Seated>,
        (from, to): (&Pose, &Pose),
        care: Care<'_>,
        tally: &mut Tally,
    ) -> Result<Walk> {
        self.walk_in_spans(seated, (from, to), care, tally, &mut |_| ())
    }

    /// The same, and each share of the motion is told to `span`.
    pub fn walk_in_spans(
        &self,
        seated: &Arc<Seated>,
        (from, to): (&Pose, &Pose),
        care: Care<'_>,
        tally: &mut Tally,
        span: &mut dyn FnMut(Span),
    ) -> Result<Walk> {
        let whole = Motion::new(&self.tool, from, to);
        let (mut seated, mut done) = (seated.clone(), 0.0);
        loop {
            let here = whole.at(done);
            let part = self.part(&seated, (&here, to), care, tally)?;
            let motion = Motion::new(&self.tool, &here, to);
            span(Span { seated: seated.clone(), from: here, to: motion.at(part.fraction) });
            done = if part.fraction < 1.0 { done + (1.0 - done) * part.fraction } else { 1.0 };
            match part.end {
                End::Arrived => return Ok(Walk { pose: *to, seated, stop: None }),
                End::Parted(left) if part.fraction >= 1.0 => return Ok(Walk { pose: *to, seated: left, stop: None }),
                End::Parted(left) => seated = left,
                End::Stopped(stop) => {
                    let pose = motion.at(part.fraction);
                    let seated = self.left_at(&seated, &pose)?.unwrap_or(seated);
                    tally.note(stop.part, self.reach(&pose), &pose);
                    return Ok(Walk { pose, seated, stop: Some(stop) });
                }
            }
        }
    }

    /// The same until a seat parts.
    fn part(
        &self,
        seated: &Arc<Seated>,
        (from, to): (&Pose, &Pose),
        care: Care<'_>,
        tally: &mut Tally,
    ) -> Result<Part> {
        // Also of a motion that ends before it is cast: a search that is bounded by casts ends.
        tally.casts += 1;
        let tool = &self.tool;
        let motion = Motion::new(tool, from, to);
        let mut first: Option<(f64, Stop)> = None;
        let stopped = |fraction: f64, stop: Stop| Ok(Part { fraction, end: End::Stopped(stop) });
        if let Some(flush) = &seated.flush {
            first = flush.cast_touching(tool, from, to, TOUCH, Touching::Within)?.map(|cast| ended(&cast, flush));
            if let Some((0.0, stop)) = first {
                return stopped(0.0, stop);
            }
        }
        let a_step = self.size / STEPS_A_LENGTH / if care == Care::Verify { VERIFY_FINER } else { 1.0 };
        let steps = (motion.longest_way() / a_step).ceil().max(1.0);
        let measures = seated.deep.is_some() || self.overlap > 0.0;
        // What is in each other mostly goes deeper at once: that costs less than a cast.
        if measures {
            let end = first.map_or(1.0, |(end, _)| end);
            if let Depth::TooDeep(stop) = self.depth(seated, &motion.at(end.min(1.0 / steps)))? {
                return stopped(0.0, stop);
            }
        }
        let scene = &seated.ordinary;
        let cast = match care {
            // Followed in steps below, where it meets something.
            _ if self.overlap > 0.0 && scene.is_colliding(tool, from) => None,
            Care::Search(beside) => scene.cast_beside(tool, from, to, TOUCH, beside)?,
            Care::Verify => scene.cast(tool, from, to, TOUCH)?,
        };
        let ordinary = cast.map(|cast| ended(&cast, scene));
        // From when on what is not seated meets it, which an overlap allows.
        let mut meets = None;
        if self.overlap > 0.0 {
            meets = ordinary.map(|(time, _)| time).or(scene.is_colliding(tool, from).then_some(0.0));
        } else {
            first = [first, ordinary].into_iter().flatten().min_by(|a, b| a.0.total_cmp(&b.0));
        }
        if let Some((0.0, stop)) = first {
            return stopped(0.0, stop);
        }
        let (mut end, mut stop) = first.map_or((1.0, None), |(end, stop)| (end, Some(stop)));
        if self.clearance > 0.0 {
            if let Some((fraction, near)) = self.leaves_clearance(seated, &motion, end)? {
                (end, stop) = (fraction, Some(near));
            }
        }
        let has_seats = seated.all.is_some();
        if seated.deep.is_some() || meets.is_some() || has_seats && self.clearance > 0.0 {
            let mut last = 0.0;
            for step in 1.. {
                let time = (f64::from(step) / steps).min(end);
                let pose = motion.at(time);
                let depth = if measures { self.depth(seated, &pose)? } else { Depth::Parting };
                if let Depth::TooDeep(stop) = depth {
                    return stopped(last, stop);
                }
                if time >= end {
                    break;
                }
                last = time;
                if meets.is_some_and(|meets| meets < time) && !scene.is_colliding(tool, &pose) {
                    // Off what it met: from here on it is cast again.
                    return Ok(Part { fraction: time, end: End::Parted(seated.clone()) });
                }
                if depth == Depth::Held {
                    continue;
                }
                if let Some(left) = self.left_at(seated, &pose)? {
                    return Ok(Part { fraction: time, end: End::Parted(left) });
                }
            }
        }
        match stop {
            Some(stop) => stopped(end, stop),
            None => {
                let left = self.left_at(seated, to)?;
                Ok(Part { fraction: 1.0, end: left.map_or(End::Arrived, End::Parted) })
            }
        }
    }

    /// What a pair `[tool part, part]` is at the start, and how deep it may be.
    fn kind_of(&self, pair: [u32; 2]) -> Option<(SeatKind, f64)> {
        let seat = self.makings.seats.iter().find(|seat| [seat.tool_part, seat.part] == pair)?;
        Some((seat.kind, seat.depth))
    }

    /// Whether the tool has moved, since the start, against the normal of a plane that it is behind.
    fn goes_in(&self, plane: &ContactPlane, pose: &Pose) -> bool {
        let mesh = self.tool.mesh();
        let moved = |p: &Point| dot(&sub(&pose.apply(p), &self.start.apply(p)), &plane.normal);
        // The corner that is deepest behind it.
        let corners = plane.tool_triangles.iter().flat_map(|t| mesh.triangle(*t));
        let height = |p: &Point| dot(&pose.apply(p), &plane.normal);
        let deepest = corners.min_by(|a, b| height(a).total_cmp(&height(b)));
        deepest.is_some_and(|p| moved(&p) < -SEAT_TOLERANCE)
    }

    /// How deep the pairs are that are in each other.
    fn depth(&self, seated: &Seated, pose: &Pose) -> Result<Depth> {
        let tool = &self.tool;
        let mut held = 0;
        if let Some(deep) = &seated.deep {
            let mut pairs: Vec<[u32; 2]> = Vec::new();
            for plane in deep.contacts(tool, pose, 0.0, None)?.planes {
                let pair = [plane.tool_part(tool), plane.part];
                let is_too_deep = match self.kind_of(pair) {
                    Some((SeatKind::Sunk, _)) => -plane.gap > SEAT_TOLERANCE && self.goes_in(&plane, pose),
                    seat => -plane.gap > SEAT_TOLERANCE + seat.map_or(0.0, |(_, depth)| depth),
                };
                if is_too_deep {
                    return Ok(Depth::TooDeep(Stop { part: plane.part, triangles: None }));
                }
                pairs.push(pair);
            }
            if seated.has_sunk {
                let mockup = deep.scene().mockup();
                let mut hit = deep.scene().collide(tool, pose).pairs;
                let kind = |[t, m]: &[u32; 2]| self.kind_of([tool.part_of_face(*t), mockup.part_of_face(*m)]);
                hit.retain(|pair| kind(pair).is_some_and(|(kind, _)| kind == SeatKind::Sunk));
                if let Some(part) = crossing_outside(tool, &self.start, mockup, &hit, pose) {
                    return Ok(Depth::TooDeep(Stop { part, triangles: None }));
                }
            }
            pairs.sort_unstable();
            pairs.dedup();
            held = pairs.len();
        }
        if self.overlap > 0.0 && seated.ordinary.is_colliding(tool, pose) {
            let solver = self.makings.solver.with_scene(Arc::new(seated.ordinary.clone()));
            let contacts = solver.contacts(tool, pose, 0.0, None)?;
            if let Some(plane) = contacts.planes.first().filter(|plane| -plane.gap > self.overlap + SEAT_TOLERANCE) {
                return Ok(Depth::TooDeep(Stop { part: plane.part, triangles: None }));
            }
        }
        Ok(if held > 0 && held == seated.deep_pairs { Depth::Held } else { Depth::Parting })
    }

    /// What is still seated at a pose; `None`: all that was.
    fn left_at(&self, seated: &Seated, pose: &Pose) -> Result<Option<Arc<Seated>>> {
        let Some(all) = &seated.all else { return Ok(None) };
        let within = TOUCH.max(self.clearance);
        // The nearest of a part may be another part of the tool: then all pairs are needed.
        let near = match self.tool.parts() {
            1 => all.clearance(&self.tool, pose, within)?,
            _ => all.near_pairs(&self.tool, pose, within)?,
        };
        let mut pairs: Vec<[u32; 2]> = near.iter().map(|gap| [gap.tool_part, gap.part]).collect();
        pairs.sort_unstable();
        pairs.dedup();
        let is_near = |seat: &Seat| pairs.binary_search(&[seat.tool_part, seat.part]).is_ok();
        let holds: Vec<bool> =
            self.makings.seats.iter().zip(&seated.holds).map(|(seat, holds)| *holds && is_near(seat)).collect();
        Ok((holds != seated.holds).then(|| self.seated(holds)))
    }

    /// The least distance of what is not seated along a span, if it is less than `least`, metres; refined to a share of the tool's length.
    pub fn least_distance(&self, span: &Span, mut least: f64) -> Result<f64> {
        let motion = Motion::new(&self.tool, &span.from, &span.to);
        let long = motion.longest_way();
        let mut time = 0.0;
        while let Some(gap) = span.seated.clear.closest(&self.tool, &motion.at(time), least + long * (1.0 - time))? {
            let beyond = gap.distance - least;
            least = least.min(gap.distance);
            if time >= 1.0 {
                break;
            }
            // Nothing comes as near as the least before the tool has moved by what is beyond it.
            time = (time
                + beyond.max(CLEARANCE_STEP * self.size).max(CLEARANCE_SHARE * least) / long.max(f64::MIN_POSITIVE))
            .min(1.0);
        }
        Ok(least)
    }

    /// Where on a motion, before `end`, what is not seated comes nearer than the clearance; the last time at which it was not.
    ///
    /// From a time at which the least distance is known nothing comes nearer than the clearance before the tool has moved by the rest:
    /// conservative advancement.
    fn leaves_clearance(&self, seated: &Seated, motion: &Motion, end: f64) -> Result<Option<(f64, Stop)>> {
        let long = motion.longest_way();
        let slack = CLEARANCE_SLACK * self.clearance;
        let (mut time, mut last) = (0.0f64, 0.0);
        loop {
            let pose = motion.at(time.min(end));
            let reach = self.clearance + long * (end - time.min(end));
            let Some(gap) = seated.clear.closest(&self.tool, &pose, reach)? else { return Ok(None) };
            if gap.distance < self.clearance - slack {
                let triangles = Some([gap.tool_triangle, gap.mockup_triangle]);
                return Ok(Some((last, Stop { part: gap.part, triangles })));
            }
            if time >= end {
                return Ok(None);
            }
            last = time;
            time += (gap.distance - self.clearance).max(slack) / long.max(f64::MIN_POSITIVE);
        }
    }
}

/// When a cast ends, and at whom.
fn ended(cast: &Cast, scene: &Scene) -> (f64, Stop) {
    let part = scene.mockup().part_of_face(cast.mockup_triangle);
    (cast.fraction, Stop { part, triangles: Some([cast.tool_triangle, cast.mockup_triangle]) })
}
