//! How far the tool moves freely from a pose towards another.

use std::sync::Arc;

use feeler_core::{Cast, CastOptions, GoOn, Motion, Point, Pose};

use crate::ask::least_distance;
use crate::constants::{
    BEYOND_REST, CLEARANCE_SLACK, FIRST_SAMPLE, FLUSH_PLAY, SEAT_CAST, SEAT_REST, SEAT_TOLERANCE, TOUCH, VERIFY_FINER,
};
use crate::environment::Pair;
use crate::error::Result;
use crate::seats::{crossing_outside, Seat, SeatKind, Seated, SeatedBody, SmallerPart};
use crate::surroundings::Surroundings;

/// Options of [`Surroundings::walk`].
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct WalkOptions<'a> {
    /// Directions (units, world) along which the tool is probably off its neighbours: casts take less time.
    pub directions: &'a [Point],
    /// Of casts of pairs that are not seated, metres.
    pub tolerance: f64,
    /// Whether a way is given after this: steps are shorter than those of a search, and depths by points are proven between them.
    #[doc(hidden)]
    pub verifies: bool,
    /// Asked every few milliseconds, and may stop the walk with an error.
    pub go_on: GoOn<'a>,
}

impl Default for WalkOptions<'_> {
    fn default() -> Self {
        WalkOptions { directions: &[], tolerance: TOUCH, verifies: false, go_on: GoOn::default() }
    }
}

impl<'a> WalkOptions<'a> {
    /// Before a way is given.
    #[doc(hidden)]
    pub fn verify(goes_on: &'a (dyn Fn() -> bool + Sync)) -> WalkOptions<'a> {
        WalkOptions { verifies: true, go_on: GoOn::new(goes_on), ..WalkOptions::default() }
    }

    /// While ways are sought.
    #[doc(hidden)]
    pub fn search(directions: &'a [Point], goes_on: &'a (dyn Fn() -> bool + Sync)) -> WalkOptions<'a> {
        WalkOptions { directions, go_on: GoOn::new(goes_on), ..WalkOptions::default() }
    }

    /// Sets directions along which the tool is probably off its neighbours.
    #[must_use]
    pub fn with_directions(mut self, directions: &'a [Point]) -> Self {
        self.directions = directions;
        self
    }

    /// Sets the tolerance of casts of pairs that are not seated, metres.
    #[must_use]
    pub fn with_tolerance(mut self, tolerance: f64) -> Self {
        self.tolerance = tolerance;
        self
    }

    /// Asks a function every few milliseconds. The walk stops with an error where it returns false.
    #[must_use]
    pub fn with_go_on(mut self, go_on: &'a (dyn Fn() -> bool + Sync)) -> Self {
        self.go_on = GoOn::new(go_on);
        self
    }
}

/// A motion as far as it is free.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Walk {
    /// Where it ends.
    pub pose: Pose,
    /// The share of the motion until there.
    pub fraction: f64,
    /// The remaining seats there.
    pub seated: Arc<Seated>,
    /// The end; `None` if all of it is free.
    pub stop: Option<Stop>,
    /// Casts made.
    pub casts: u64,
}

/// A share of a motion along which the same pairs are seated.
#[derive(Debug, Clone)]
pub struct Span {
    /// Not parted yet.
    pub seated: Arc<Seated>,
    /// The share.
    pub motion: Motion,
}

/// The end of a motion.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Stop {
    /// Of the mock-up.
    pub part: u32,
    /// The triangles in contact; `None` if a sunk part is the stop.
    pub pair: Option<Pair>,
    /// Whether it is a seat that may go no deeper.
    pub is_seat: bool,
}

/// A share of a motion, and what ends it.
struct Part {
    fraction: f64,
    end: End,
    /// From when on an overlap is used.
    meets: Option<f64>,
}

enum End {
    Arrived,
    Stopped(Stop),
    Parted(Arc<Seated>),
}

impl Surroundings {
    /// Moves from a pose towards another, as far as that is free.
    pub fn walk(&self, seated: &Arc<Seated>, between: (&Pose, &Pose), options: WalkOptions<'_>) -> Result<Walk> {
        self.walk_along(seated, &Motion::new(&self.tool, between.0, between.1), options, &mut |_| ())
    }

    /// The same along any motion of the tool; each share of it is told to `span`.
    #[doc(hidden)]
    pub fn walk_along(
        &self,
        seated: &Arc<Seated>,
        whole: &Motion,
        options: WalkOptions<'_>,
        span: &mut dyn FnMut(Span),
    ) -> Result<Walk> {
        let to = whole.end();
        let (mut seated, mut done, mut casts) = (seated.clone(), 0.0, 0);
        loop {
            let motion = whole.rest(&self.tool, done)?;
            // Also of a motion that ends before it is cast: a search that is bounded by casts ends.
            casts += 1;
            let part = self.proven(&seated, &motion, options)?;
            span(Span { seated: seated.clone(), motion: motion.until(&self.tool, part.fraction)? });
            done = if part.fraction < 1.0 { done + (1.0 - done) * part.fraction } else { 1.0 };
            match part.end {
                End::Arrived => return Ok(Walk { pose: *to, fraction: 1.0, seated, stop: None, casts }),
                End::Parted(left) if part.fraction >= 1.0 => {
                    return Ok(Walk { pose: *to, fraction: 1.0, seated: left, stop: None, casts })
                }
                End::Parted(left) => seated = left,
                End::Stopped(stop) => {
                    let pose = motion.at(part.fraction);
                    let seated = self.left_at(&seated, &pose)?.unwrap_or(seated);
                    return Ok(Walk { pose, fraction: done, seated, stop: Some(stop), casts });
                }
            }
        }
    }

    /// The same until a seat parts; where it is verified, as far as the depths by points are proven.
    fn proven(&self, seated: &Arc<Seated>, motion: &Motion, options: WalkOptions<'_>) -> Result<Part> {
        let part = self.part(seated, motion, options)?;
        if options.verifies && !matches!(part.end, End::Stopped(_)) {
            if let Some((fraction, of)) = self.unproven(seated, motion, (part.meets, part.fraction), options.go_on)? {
                let end = End::Stopped(Stop { part: of, pair: None, is_seat: true });
                return Ok(Part { fraction, end, meets: part.meets });
            }
        }
        Ok(part)
    }

    /// The same by casts, and by looks at sunk parts and overlaps.
    fn part(&self, seated: &Arc<Seated>, motion: &Motion, options: WalkOptions<'_>) -> Result<Part> {
        let tool = &self.tool;
        let mut first: Option<(f64, Stop)> = None;
        let stopped = |fraction: f64, stop: Stop| Ok(Part { fraction, end: End::Stopped(stop), meets: None });
        for (number, asked) in seated.bodies.iter().enumerate() {
            for part in &asked.smaller {
                let cast = self.cast_of_smaller((number, part), motion, options)?;
                let end = cast.map(|(fraction, pair)| (fraction, self.stop_of_smaller(number, part.seat, pair)));
                first = earlier(first, end);
            }
        }
        if let Some((0.0, stop)) = first {
            return stopped(0.0, stop);
        }
        let finer = if options.verifies { VERIFY_FINER } else { 1.0 };
        let steps = (motion.longest_way() / self.stride * finer).ceil().max(1.0);
        let measures = self.overlap > 0.0 || seated.bodies.iter().any(|asked| asked.sunk.is_some());
        // What is in each other mostly goes deeper at once: that costs less than a cast.
        if measures {
            let end = first.map_or(1.0, |(end, _)| end);
            let soon = FIRST_SAMPLE * self.least_sunk.max(4.0 * SEAT_TOLERANCE) / motion.longest_way();
            for time in [soon, 1.0 / steps] {
                if let Some(stop) = self.too_deep(seated, &motion.at(end.min(time)), options.go_on)? {
                    return stopped(0.0, stop);
                }
            }
        }
        // From when on an unseated neighbour meets it, which an overlap allows.
        let mut meets: Option<f64> = None;
        for (number, asked) in seated.bodies.iter().enumerate() {
            let scene = asked.ordinary.scene();
            if self.overlap > 0.0 && scene.is_colliding(tool, &motion.at(0.0)) {
                // Followed in steps below.
                meets = Some(0.0);
                continue;
            }
            let Some(cast) = scene.cast_along(
                tool,
                motion,
                &CastOptions::default()
                    .with_tolerance(options.tolerance)
                    .with_directions(options.directions)
                    .with_go_on(options.go_on.function()),
            )?
            else {
                continue;
            };
            if self.overlap > 0.0 {
                meets = Some(meets.map_or(cast.fraction, |meets| meets.min(cast.fraction)));
            } else {
                first = earlier(first, Some(self.ended(&cast, number)));
            }
        }
        if let Some((0.0, stop)) = first {
            return stopped(0.0, stop);
        }
        let (mut end, mut stop) = first.map_or((1.0, None), |(end, stop)| (end, Some(stop)));
        if self.clearance > 0.0 {
            if let Some((fraction, near)) = self.leaves_clearance(seated, motion, end)? {
                (end, stop) = (fraction, Some(near));
            }
        }
        let has_seats = seated.bodies.iter().any(|asked| asked.all.is_some());
        if measures || has_seats && self.clearance > 0.0 {
            let mut last = 0.0;
            for step in 1.. {
                if !(options.go_on.function())() {
                    return Err(feeler_core::Error::Cancelled.into());
                }
                let time = (f64::from(step) / steps).min(end);
                let pose = motion.at(time);
                if let Some(stop) = if measures { self.too_deep(seated, &pose, options.go_on)? } else { None } {
                    return stopped(last, stop);
                }
                if time >= end {
                    break;
                }
                last = time;
                if meets.is_some_and(|meets| meets < time) && !self.is_colliding(seated, &pose) {
                    // Off the part that it met: from here on it is cast again.
                    return Ok(Part { fraction: time, end: End::Parted(seated.clone()), meets });
                }
                if let Some(left) = self.left_at(seated, &pose)? {
                    return Ok(Part { fraction: time, end: End::Parted(left), meets });
                }
            }
        }
        match stop {
            Some(stop) => stopped(end, stop),
            None => {
                let left = self.left_at(seated, motion.end())?;
                Ok(Part { fraction: 1.0, end: left.map_or(End::Arrived, End::Parted), meets })
            }
        }
    }

    /// The pairs that are deeper than they may be: sunk parts, and by how much all may overlap.
    fn too_deep(&self, seated: &Seated, pose: &Pose, go_on: GoOn<'_>) -> Result<Option<Stop>> {
        for (number, asked) in seated.bodies.iter().enumerate() {
            if let Some(part) = self.too_deep_in(number, asked, pose, go_on)? {
                let part = self.environment.bodies[number].part_in_mockup(part);
                return Ok(Some(Stop { part, pair: None, is_seat: true }));
            }
        }
        Ok(None)
    }

    /// The part of one body.
    fn too_deep_in(&self, body: usize, asked: &SeatedBody, pose: &Pose, go_on: GoOn<'_>) -> Result<Option<u32>> {
        let tool = &self.tool;
        if let Some(sunk) = &asked.sunk {
            for plane in self.planes_of_sunk(body, sunk, pose)? {
                if self.moved_at(&plane, pose).is_some_and(|(_, by)| by < -SEAT_TOLERANCE) {
                    return Ok(Some(plane.part));
                }
            }
            let flush = self.flush_at(body, sunk.scene(), pose)?;
            if let Some(deeper) = flush.iter().find(|one| one.moved < -FLUSH_PLAY) {
                return Ok(Some(sunk.scene().mockup().part_of_face(deeper.flush.triangles[1])));
            }
            if let Some(deepest) = self.excess_of_shallow(body, sunk, pose, go_on)?.filter(|deepest| deepest.by > 0.0) {
                return Ok(Some(deepest.part));
            }
            let pairs = self.sunk_pairs(body, sunk.scene(), pose);
            let inside = self.samples_inside(body, sunk.scene(), pose)?;
            let outside = crossing_outside(self.place(body), sunk.scene().mockup(), (&pairs, &inside), pose);
            if outside.is_some() {
                return Ok(outside);
            }
        }
        if self.overlap > 0.0 {
            if asked.ordinary.scene().is_colliding(tool, pose) {
                let contacts = asked.ordinary.contacts(tool, pose, 0.0, None)?;
                let deepest = contacts.planes.first().filter(|plane| -plane.gap > self.overlap + SEAT_TOLERANCE);
                if let Some(plane) = deepest {
                    return Ok(Some(plane.part));
                }
            }
            // A part thinner than a wall can lie inside it: no triangles cross there, and no contact plane shows it.
            let deepest = self.excess_of_overlap(body, &asked.ordinary, pose, go_on)?;
            return Ok(Some(deepest.part).filter(|_| deepest.by > 0.0));
        }
        Ok(None)
    }

    /// The remaining seats at a pose; `None`: all of them.
    pub fn left_at(&self, seated: &Seated, pose: &Pose) -> Result<Option<Arc<Seated>>> {
        let within = TOUCH.max(self.clearance);
        let mut holds = seated.holds.clone();
        let mut rest = &mut holds[..];
        for (asked, makings) in seated.bodies.iter().zip(&self.makings) {
            let (own, others) = rest.split_at_mut(makings.seats.len());
            rest = others;
            let Some(all) = &asked.all else { continue };
            // The nearest of a part may be another part of the tool: then all pairs are needed.
            let near = match self.tool.parts() {
                1 => all.clearance(&self.tool, pose, within)?,
                _ => all.near_pairs(&self.tool, pose, within)?,
            };
            let mut pairs: Vec<[u32; 2]> = near.iter().map(|gap| [gap.tool_part, gap.part]).collect();
            pairs.sort_unstable();
            pairs.dedup();
            let is_near = |seat: &Seat| pairs.binary_search(&[seat.tool_part, seat.part]).is_ok();
            let mut left: Vec<(&mut bool, &Seat)> =
                own.iter_mut().zip(&makings.seats).filter(|(holds, seat)| **holds && !is_near(seat)).collect();
            // A sunk part that lies wholly in its neighbour is near no surface of it.
            let sunk = asked.sunk.as_ref().filter(|_| left.iter().any(|(_, seat)| seat.kind == SeatKind::Sunk));
            let inside = sunk.map(|sunk| sunk.containment(&self.tool, pose)).unwrap_or_default();
            let is_inside = |seat: &Seat| {
                let pair = [seat.tool_part, seat.part];
                seat.kind == SeatKind::Sunk && (inside.containing.contains(&pair) || inside.contained.contains(&pair))
            };
            left.iter_mut().for_each(|(holds, seat)| **holds = is_inside(seat));
        }
        Ok((holds != seated.holds).then(|| self.seated(holds)))
    }

    /// The least distance along a span between parts that do not meet where they are seated, or `least` if that is less, metres; see [`least_distance`].
    /// `goes_on` as in [`Care`].
    #[doc(hidden)]
    pub fn least_distance(&self, span: &Span, least: f64, goes_on: &(dyn Fn() -> bool + Sync)) -> Result<f64> {
        let of_body =
            |least, asked: &SeatedBody| least_distance(&asked.apart, &self.tool, &span.motion, least, goes_on);
        span.seated.bodies.iter().try_fold(least, of_body)
    }

    /// Where on a motion, before `end`, an unseated neighbour comes nearer than the clearance; the last time at which it was not.
    ///
    /// From a time at which the least distance is known nothing comes nearer than the clearance before the tool has moved by the rest:
    /// conservative advancement.
    fn leaves_clearance(&self, seated: &Seated, motion: &Motion, mut end: f64) -> Result<Option<(f64, Stop)>> {
        let long = motion.longest_way();
        let slack = CLEARANCE_SLACK * self.clearance;
        let mut first = None;
        for (number, asked) in seated.bodies.iter().enumerate() {
            let (mut time, mut last) = (0.0f64, 0.0);
            loop {
                let pose = motion.at(time.min(end));
                let reach = self.clearance + long * (end - time.min(end));
                let Some(gap) = asked.clear.distance(&self.tool, &pose, reach)? else { break };
                if gap.distance < self.clearance - slack {
                    let stop = self.stop(number, [gap.tool_triangle, gap.mockup_triangle]);
                    (first, end) = (Some((last, stop)), last);
                    break;
                }
                if time >= end {
                    break;
                }
                last = time;
                time += (gap.distance - self.clearance).max(slack) / long.max(f64::MIN_POSITIVE);
            }
        }
        Ok(first)
    }

    /// When a smaller part first meets its neighbour, and which triangle of it. It ends where the next motion may begin.
    fn cast_of_smaller(
        &self,
        (body, part): (usize, &SmallerPart),
        motion: &Motion,
        options: WalkOptions<'_>,
    ) -> Result<Option<(f64, [u32; 2])>> {
        let own = motion.of_tool(&part.tool)?;
        let cast = part.solver.scene().cast_along(
            &part.tool,
            &own,
            &CastOptions::default()
                .with_tolerance(SEAT_CAST)
                .with_directions(options.directions)
                .with_go_on(options.go_on.function()),
        )?;
        // The next one begins clearly off what ended this; and a sunk part, that is larger, meets nothing beyond its place.
        let rest = if self.is_sunk(body, part.seat) { BEYOND_REST } else { SEAT_REST };
        let before = |fraction: f64| (fraction - rest / motion.longest_way()).max(0.0);
        Ok(cast.map(|cast| (before(cast.fraction), [cast.tool_triangle, cast.mockup_triangle])))
    }

    /// The end of a cast of a smaller part, whose triangles are not the tool's. What a sunk part meets is a piece of a triangle: no pair
    /// names it.
    fn stop_of_smaller(&self, body: usize, seat: u32, [tool_triangle, triangle]: [u32; 2]) -> Stop {
        let part = self.environment.bodies[body].part_in_mockup(self.makings[body].seats[seat as usize].part);
        let pair = Pair { body: body as u32, tool_triangle, triangle, seat: Some(seat) };
        Stop { part, pair: Some(pair).filter(|_| !self.is_sunk(body, seat)), is_seat: true }
    }

    fn is_sunk(&self, body: usize, seat: u32) -> bool {
        self.makings[body].seats[seat as usize].kind == SeatKind::Sunk
    }

    /// When a cast ends, and at whom.
    fn ended(&self, cast: &Cast, body: usize) -> (f64, Stop) {
        (cast.fraction, self.stop(body, [cast.tool_triangle, cast.mockup_triangle]))
    }

    fn stop(&self, body: usize, [tool_triangle, triangle]: [u32; 2]) -> Stop {
        let pair = Pair { body: body as u32, tool_triangle, triangle, seat: None };
        Stop { part: self.environment.part_of(&pair), pair: Some(pair), is_seat: false }
    }
}

fn earlier(first: Option<(f64, Stop)>, other: Option<(f64, Stop)>) -> Option<(f64, Stop)> {
    [first, other].into_iter().flatten().min_by(|a, b| a.0.total_cmp(&b.0))
}

#[cfg(test)]
mod tests {
    use feeler_contacts::ContactSolver;
    use feeler_core::{Mockup, Scene, SceneOptions, Tool};
    use feeler_shapes::{box_mesh, joined};

    use super::*;
    use crate::environment::{Body, Environment};
    use crate::seats::Allowed;

    #[test]
    fn a_way_is_verified_at_poses_between_those_of_the_search() {
        // A block with a thin fin, which a thin post is in the way of: between two poses of the search, or of the steps half as long of a
        // verification, it goes through the post, deeper than an overlap allows.
        let (thin, overlap) = (2e-4, 5e-5);
        let block = box_mesh([0.0; 3], [0.02; 3], 1);
        let fin = box_mesh([0.0, 0.0125, 0.0], [thin, 0.006, 0.02], 1);
        let (vertices, faces) = joined([block, fin]);
        let tool = Arc::new(Tool::new(vertices, faces).unwrap());
        let start = Pose::IDENTITY;
        let surroundings = |post: f64| {
            let (vertices, faces) = box_mesh([post, 0.0145, 0.0], [thin, 0.008, 0.05], 1);
            let mockup = Mockup::new(vertices, faces, vec![], 1).unwrap();
            let scene = Scene::build(Arc::new(mockup), &SceneOptions::default()).unwrap();
            let bodies = vec![Body { solver: ContactSolver::new(Arc::new(scene)), part: None }];
            let allowed = Allowed { overlap, ..Allowed::default() };
            Surroundings::new(Environment { bodies }, tool.clone(), 1, &start, (&allowed, 0.0), &|| true).unwrap()
        };
        let step = surroundings(0.05).stride;
        assert!(step > 4.0 * thin);
        for (post, is_seen) in [(20.25, false), (20.5, false), (20.0, true)] {
            let around = surroundings(post * step);
            let to = start.translated(&[39.99 * step, 0.0, 0.0]).unwrap();
            let walk = |care| around.walk(&around.seated_at_start(), (&start, &to), care).unwrap();
            assert_eq!(walk(WalkOptions::default()).stop.is_some(), is_seen, "{post}");
            assert!(walk(WalkOptions::verify(&|| true)).stop.is_some(), "{post}");
        }
    }
}
