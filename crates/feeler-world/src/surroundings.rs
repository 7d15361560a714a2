//! A tool, the bodies around it, and its seats at the start.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use feeler_contacts::{ContactSolver, Manifold, Manifolds};
use feeler_core::geometry::vectors::{length, scaled, sub};
use feeler_core::{Aabb, Closest, GoOn, Point, Pose, Scene, Tool};

use crate::constants::{EXIT_MARGIN, STEPS_A_LENGTH};
use crate::environment::{id_in_body, Body, Environment, Pair};
use crate::error::Result;
use crate::seats::{find_seats, Allowed, Around, Filled, Flush, Makings, Seat, SeatKind, Seated};

/// A tool, the bodies around it, and its seats.
#[derive(Debug)]
pub struct Surroundings {
    pub(crate) environment: Environment,
    /// By body.
    pub(crate) makings: Vec<Makings>,
    pub(crate) tool: Arc<Tool>,
    pub(crate) start: Pose,
    pub(crate) overlap: f64,
    pub(crate) clearance: f64,
    refused: Vec<[u32; 2]>,
    /// Around all that is there.
    bounds: Aabb,
    /// The middle of the tool's box, tool frame.
    middle: Point,
    /// The diagonal of the tool's box, metres.
    pub(crate) size: f64,
    /// The longest step between two poses at which sunk parts and overlaps are measured, metres.
    pub(crate) stride: f64,
    /// The least depth of a sunk pair at the start, metres; infinite where there is none.
    pub(crate) least_sunk: f64,
    /// By body: directions in which parts that go through a neighbour may leave it, units.
    pub(crate) through: Vec<Vec<Point>>,
    /// By body: triangles of sunk parts, and a point of each (tool frame) that is inside the neighbour at the start.
    pub(crate) samples: Vec<Vec<(u32, Point)>>,
    /// By body: the pockets of the tool that the neighbours' solid fills at the start.
    pub(crate) filled: Vec<Filled>,
    /// By body: parts of the tool that are around a sunk neighbour.
    pub(crate) around: Vec<Vec<Around>>,
    /// By body: points of sunk parts that are flush with the neighbour at the start.
    pub(crate) flush: Vec<Vec<Flush>>,
    /// By body: its parts that are in the tool at the start, and the depth by points, metres.
    pub(crate) start_depths: OnceLock<Vec<Vec<(u32, f64)>>>,
    /// Each way of being seated once.
    pub(crate) known: Mutex<BTreeMap<Vec<bool>, Arc<Seated>>>,
}

impl Surroundings {
    /// The surroundings of a tool at its start, among bodies without it. Tool parts from `own_parts` on are grippers,
    /// and may touch nothing there.
    ///
    /// Errors: what grips meets something at the start; where `goes_on` says so, a request to stop.
    #[doc(hidden)]
    pub fn new(
        environment: Environment,
        tool: Arc<Tool>,
        own_parts: u32,
        start: &Pose,
        (allowed, clearance): (&Allowed, f64),
        goes_on: &(dyn Fn() -> bool + Sync),
    ) -> Result<Surroundings> {
        let mut around = Surroundings::without_seats(environment, tool);
        (around.start, around.overlap, around.clearance) = (*start, allowed.overlap, clearance);
        for (body, makings) in around.environment.bodies.iter().zip(&mut around.makings) {
            let scene = body.solver.scene();
            makings.always.clone_from(&allowed.parts);
            let asked = makings.seated(&[]).ordinary;
            let found =
                find_seats((&asked, asked.scene()), &around.tool, own_parts, start, (allowed, clearance), goes_on)?;
            if !found.seats.is_empty() {
                let mut neighbours: Vec<u32> = found.seats.iter().map(|seat| seat.part).collect();
                neighbours.sort_unstable();
                neighbours.dedup();
                makings.neighbours = Some(scene.only(&neighbours)?);
            }
            around.refused.extend(found.refused.iter().map(|[t, part]| [*t, body.part_in_mockup(*part)]));
            (makings.seats, makings.eroded, makings.regions) = (found.seats, found.eroded, found.regions);
        }
        around.know_sunk(own_parts, GoOn::new(goes_on))?;
        Ok(around)
    }

    /// Of a tool at a pose: all that it meets there is a seat.
    #[doc(hidden)]
    pub fn around(bodies: Vec<Body>, tool: Arc<Tool>, start: &Pose) -> Result<Surroundings> {
        let (parts, allowed) = (tool.parts() as u32, Allowed { start: true, ..Allowed::default() });
        Surroundings::new(Environment { bodies }, tool, parts, start, (&allowed, 0.0), &|| true)
    }

    /// Of a tool that is nowhere yet.
    #[doc(hidden)]
    pub fn without_seats(environment: Environment, tool: Arc<Tool>) -> Surroundings {
        let own = tool.mesh().bounds();
        let mut bounds = Aabb::EMPTY;
        for scene in environment.bodies.iter().map(|body| body.solver.scene()) {
            let parts = (0..).zip(scene.mockup().part_bounds());
            let there = parts.filter(|(part, bounds)| scene.has_part(*part) && !bounds.is_empty());
            bounds = there.fold(bounds, |all, (_, bounds)| all.union(bounds));
        }
        Surroundings {
            makings: environment.bodies.iter().map(|body| unseated(&body.solver, &tool)).collect(),
            environment,
            start: Pose::IDENTITY,
            overlap: 0.0,
            clearance: 0.0,
            refused: Vec::new(),
            bounds,
            middle: std::array::from_fn(|a| 0.5 * own.lower[a] + 0.5 * own.upper[a]),
            size: length(&own.extent()),
            stride: length(&own.extent()) / STEPS_A_LENGTH,
            least_sunk: f64::INFINITY,
            through: Vec::new(),
            samples: Vec::new(),
            filled: Vec::new(),
            around: Vec::new(),
            flush: Vec::new(),
            start_depths: OnceLock::new(),
            tool,
            known: Mutex::default(),
        }
    }

    /// The moving tool.
    pub fn tool(&self) -> &Arc<Tool> {
        &self.tool
    }

    /// Its surroundings.
    pub fn environment(&self) -> &Environment {
        &self.environment
    }

    /// Where it starts.
    pub fn start(&self) -> &Pose {
        &self.start
    }

    /// The diagonal of its box, metres.
    #[doc(hidden)]
    pub fn size(&self) -> f64 {
        self.size
    }

    /// The distance that it keeps from everything but seats, metres.
    pub fn clearance(&self) -> f64 {
        self.clearance
    }

    /// The middle of its box, tool frame, metres.
    #[doc(hidden)]
    pub fn middle(&self) -> &Point {
        &self.middle
    }

    /// Around all that is there, world.
    #[doc(hidden)]
    pub fn bounds(&self) -> &Aabb {
        &self.bounds
    }

    /// Pairs `[tool part, part]` that meet at the start though nothing allows it.
    #[doc(hidden)]
    pub fn refused(&self) -> &[[u32; 2]] {
        &self.refused
    }

    /// The pairs of parts that are together at the start, those of one body after the other; parts by their numbers in the mock-up.
    pub fn seats(&self) -> impl Iterator<Item = Seat> + '_ {
        let bodies = self.environment.bodies.iter().zip(&self.makings);
        bodies.flat_map(|(body, makings)| {
            makings.seats.iter().map(|seat| Seat { part: body.part_in_mockup(seat.part), ..*seat })
        })
    }

    /// Whether any pair is together at the start.
    pub fn has_seats(&self) -> bool {
        self.makings.iter().any(|makings| !makings.seats.is_empty())
    }

    /// Whether casts decide it all: then verifying a motion is casting it once more.
    #[doc(hidden)]
    pub fn casts_decide(&self) -> bool {
        self.overlap == 0.0 && self.seats().all(|seat| seat.kind != SeatKind::Sunk)
    }

    /// The nearest points of a pair at a pose, the tool's first, world.
    #[doc(hidden)]
    pub fn closest(&self, pose: &Pose, pair: &Pair) -> Option<Closest> {
        let eroded =
            pair.seat.and_then(|seat| self.makings.get(pair.body as usize)?.eroded.get(seat as usize)?.as_ref());
        let tool = if pair.seat.is_some() { &eroded?.tool } else { &self.tool };
        self.environment.closest(tool, pose, pair)
    }

    /// All seats as at the start.
    pub fn seated_at_start(&self) -> Arc<Seated> {
        self.seated(vec![true; self.makings.iter().map(|makings| makings.seats.len()).sum()])
    }

    pub(crate) fn seated(&self, holds: Vec<bool>) -> Arc<Seated> {
        let mut known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(seated) = known.get(&holds) {
            return seated.clone();
        }
        let mut rest = &holds[..];
        let mut bodies = Vec::with_capacity(self.makings.len());
        for makings in &self.makings {
            let (own, others) = rest.split_at(makings.seats.len());
            bodies.push(makings.seated(own));
            rest = others;
        }
        let seated = Arc::new(Seated { holds: holds.clone(), bodies });
        known.insert(holds, seated.clone());
        seated
    }

    /// The contact manifolds at a pose of the tool with all that is not seated, nearest first, and how far off all else is.
    #[doc(hidden)]
    pub fn manifolds(&self, seated: &Seated, pose: &Pose, margin: f64, out: &mut Manifolds) -> Result<()> {
        let asked = seated.bodies.iter().map(|asked| (&asked.ordinary, &self.tool));
        self.manifolds_of(asked.enumerate(), pose, margin, out)
    }

    /// The contact manifolds of the eroded parts with their neighbours: their gaps are how far a seat may still go.
    #[doc(hidden)]
    pub fn seat_manifolds(&self, seated: &Seated, pose: &Pose, margin: f64, out: &mut Manifolds) -> Result<()> {
        let parts = seated.bodies.iter().enumerate();
        let asked = parts.flat_map(|(body, asked)| asked.smaller.iter().map(move |part| (body, part)));
        self.manifolds_of(asked.map(|(body, part)| (body, (&part.solver, &part.tool))), pose, margin, out)
    }

    fn manifolds_of<'a>(
        &self,
        asked: impl Iterator<Item = (usize, (&'a ContactSolver, &'a Arc<Tool>))>,
        pose: &Pose,
        margin: f64,
        out: &mut Manifolds,
    ) -> Result<()> {
        let mut all: Vec<Manifold> = Vec::new();
        let mut least = margin;
        for (number, (body, (solver, tool))) in asked.enumerate() {
            solver.manifolds(tool, pose, margin, out)?;
            least = least.min(out.margin);
            for manifold in &mut out.manifolds {
                manifold.part = self.environment.bodies[body].part_in_mockup(manifold.part);
                manifold.id = id_in_body(manifold.id, number);
            }
            all.append(&mut out.manifolds);
        }
        all.sort_by(|a, b| a.gap.total_cmp(&b.gap).then(a.id.cmp(&b.id)));
        out.manifolds = all;
        out.margin = least;
        Ok(())
    }

    /// The least distance of surfaces that are not seated, and of the eroded parts, metres; `None` beyond `within`.
    pub fn distance(&self, seated: &Seated, pose: &Pose, within: f64) -> Result<Option<f64>> {
        let mut least = None;
        for asked in &seated.bodies {
            let smaller = asked.smaller.iter().map(|part| (&part.solver, &part.tool));
            for (solver, tool) in [(&asked.ordinary, &self.tool)].into_iter().chain(smaller) {
                let gap = solver.scene().distance(tool, pose, least.unwrap_or(within))?;
                least = gap.map(|gap| gap.distance).or(least);
            }
        }
        Ok(least)
    }

    /// What may not collide: by body, the scene that is asked and what moves in it; all that is not seated, and the eroded parts.
    #[doc(hidden)]
    pub fn asked<'a>(&'a self, seated: &'a Seated) -> impl Iterator<Item = (usize, &'a Scene, &'a Tool)> {
        seated.bodies.iter().enumerate().flat_map(|(body, asked)| {
            let smaller = asked.smaller.iter().map(|part| (&part.solver, &part.tool));
            let all = [(&asked.ordinary, &self.tool)].into_iter().chain(smaller);
            all.map(move |(solver, tool)| (body, solver.scene().as_ref(), tool.as_ref()))
        })
    }

    /// Whether any surface that is not seated, or any eroded part, is in collision, exactly. Sunk parts are not looked at.
    pub fn is_colliding(&self, seated: &Seated, pose: &Pose) -> bool {
        seated.bodies.iter().any(|asked| {
            asked.ordinary.scene().is_colliding(&self.tool, pose)
                || asked.smaller.iter().any(|part| part.solver.scene().is_colliding(&part.tool, pose))
        })
    }

    /// The parts of which [`is_colliding`](Self::is_colliding) is true, by their numbers in the mock-up; each once.
    pub fn colliding_parts(&self, seated: &Seated, pose: &Pose) -> Vec<u32> {
        let mut parts = Vec::new();
        for (body, asked) in self.environment.bodies.iter().zip(&seated.bodies) {
            let smaller = asked.smaller.iter().map(|part| (&part.solver, &part.tool));
            for (solver, tool) in [(&asked.ordinary, &self.tool)].into_iter().chain(smaller) {
                let scene = solver.scene();
                let met = scene.collide(tool, pose).pairs;
                parts.extend(met.iter().map(|[_, face]| body.part_in_mockup(scene.mockup().part_of_face(*face))));
            }
        }
        parts.sort_unstable();
        parts.dedup();
        parts
    }

    /// A pair `[tool part, part]` of a body at the start.
    pub(crate) fn seat_of(&self, body: usize, pair: [u32; 2]) -> Option<&Seat> {
        self.makings[body].seats.iter().find(|seat| [seat.tool_part, seat.part] == pair)
    }

    /// How far its middle is from where it starts, metres.
    #[doc(hidden)]
    pub fn reach(&self, pose: &Pose) -> f64 {
        length(&sub(&pose.apply(&self.middle), &self.start.apply(&self.middle)))
    }

    /// How far it has to move along a direction (unit) until its box is off the box of all that is there, metres; 0 where it is.
    #[doc(hidden)]
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
    #[doc(hidden)]
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
    #[doc(hidden)]
    pub fn moved(&self, pose: &Pose, direction: &Point, by: f64) -> Result<Pose> {
        Ok(pose.translated(&scaled(direction, by))?)
    }
}

/// A body of which nothing is known yet.
fn unseated(solver: &ContactSolver, tool: &Tool) -> Makings {
    Makings {
        solver: solver.with_scene(solver.scene().clone()),
        tool_parts: tool.parts() as u32,
        seats: Vec::new(),
        eroded: Vec::new(),
        beyond: Vec::new(),
        regions: None,
        always: Vec::new(),
        neighbours: None,
    }
}
