//! A tool, the bodies around it, and its seats at the start.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use feeler_contacts::{ContactPlane, ContactSolver, Manifold, Manifolds};
use feeler_core::geometry::vectors::{cross, dot, length, scaled, sub};
use feeler_core::{Aabb, Closest, Point, Pose, Ray, Scene, Tool};

use crate::constants::{
    EXIT_MARGIN, FIT_DEPTH, LEADING_COS, MOST_PLACE_SAMPLES, MOST_SAMPLE_RAYS, MOST_STEPS_A_LENGTH, SEAT_TOLERANCE,
    SLIVER_DEPTH, STEPS_A_LENGTH, STEP_THICKNESS, THROUGH_COS, THROUGH_TRIALS,
};
use crate::environment::{id_in_body, Body, Environment, Pair, Plane};
use crate::error::Result;
use crate::seats::{
    crossing_outside, crossings_in_place, find_seats, Allowed, Inside, Makings, Seat, SeatKind, Seated,
};

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
    /// How far it may move between two samples of what is measured at poses, metres.
    pub(crate) stride: f64,
    /// The least depth of a sunk pair at the start, metres; infinite where there is none.
    pub(crate) least_sunk: f64,
    /// Directions in which parts that go through a neighbour may leave it, units.
    through: Vec<Point>,
    /// By body: triangles of sunk parts, and a point of each (tool frame) that is inside the neighbour at the start.
    samples: Vec<Vec<(u32, Point)>>,
    /// Each way of being seated once.
    known: Mutex<BTreeMap<Vec<bool>, Arc<Seated>>>,
}

/// A plane that a sunk part is held by, at a pose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SunkPlane {
    /// World.
    pub plane: Plane,
    /// A point of the tool, world.
    pub point: Point,
    /// How far it may go against the plane's normal, metres; not below 0, so that no plane pushes the tool.
    pub room: f64,
}

impl Surroundings {
    /// Of a tool at its start, among bodies without it. Tool parts from `own_parts` on are what grips, and may meet nothing there.
    ///
    /// Errors: what grips meets something at the start.
    pub fn new(
        environment: Environment,
        tool: Arc<Tool>,
        own_parts: u32,
        start: &Pose,
        allowed: &Allowed,
        clearance: f64,
    ) -> Result<Surroundings> {
        let mut around = Surroundings::without_seats(environment, tool);
        (around.start, around.overlap, around.clearance) = (*start, allowed.overlap, clearance);
        for (body, makings) in around.environment.bodies.iter().zip(&mut around.makings) {
            let scene = body.solver.scene();
            makings.always.clone_from(&allowed.parts);
            let asked = makings.seated(&[]).ordinary;
            let found = find_seats((&asked, asked.scene()), &around.tool, own_parts, start, allowed, clearance)?;
            if !found.seats.is_empty() {
                let mut neighbours: Vec<u32> = found.seats.iter().map(|seat| seat.part).collect();
                neighbours.sort_unstable();
                neighbours.dedup();
                makings.neighbours = Some(scene.only(&neighbours)?);
            }
            around.refused.extend(found.refused.iter().map(|[t, part]| [*t, body.part_in_mockup(*part)]));
            (makings.seats, makings.eroded, makings.regions) = (found.seats, found.eroded, found.regions);
        }
        let sunk = around.seats().filter(|seat| seat.kind == SeatKind::Sunk);
        around.least_sunk = sunk.map(|seat| seat.depth).fold(f64::INFINITY, f64::min);
        if around.least_sunk.is_finite() || around.overlap > 0.0 {
            let thin = STEP_THICKNESS * thickness(&around.tool, own_parts);
            around.stride = around.stride.min(thin.max(around.size / MOST_STEPS_A_LENGTH));
        }
        if around.least_sunk.is_finite() {
            around.through = around.ways_through()?;
            around.samples = around.samples_of_sunk()?;
        }
        Ok(around)
    }

    /// Of a tool at a pose: all that it meets there is a seat.
    pub fn around(bodies: Vec<Body>, tool: Arc<Tool>, start: &Pose) -> Result<Surroundings> {
        let (parts, allowed) = (tool.parts() as u32, Allowed { start: true, ..Allowed::default() });
        Surroundings::new(Environment { bodies }, tool, parts, start, &allowed, 0.0)
    }

    /// Of a tool that is nowhere yet.
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
            tool,
            known: Mutex::default(),
        }
    }

    /// What moves.
    pub fn tool(&self) -> &Arc<Tool> {
        &self.tool
    }

    /// What it may meet.
    pub fn environment(&self) -> &Environment {
        &self.environment
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
    pub fn casts_decide(&self) -> bool {
        self.overlap == 0.0 && self.seats().all(|seat| seat.kind != SeatKind::Sunk)
    }

    /// The nearest points of a pair at a pose, the tool's first, world.
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
    pub fn manifolds(&self, seated: &Seated, pose: &Pose, margin: f64, out: &mut Manifolds) -> Result<()> {
        let asked = seated.bodies.iter().map(|asked| (&asked.ordinary, &self.tool));
        self.manifolds_of(asked.enumerate(), pose, margin, out)
    }

    /// The contact manifolds of the eroded parts with their neighbours: their gaps are how far a seat may still go.
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
                let gap = solver.scene().closest(tool, pose, least.unwrap_or(within))?;
                least = gap.map(|gap| gap.distance).or(least);
            }
        }
        Ok(least)
    }

    /// Whether any surface that is not seated, or any eroded part, is in collision, exactly. Sunk parts are not looked at.
    pub fn is_colliding(&self, seated: &Seated, pose: &Pose) -> bool {
        seated.bodies.iter().any(|asked| {
            asked.ordinary.scene().is_colliding(&self.tool, pose)
                || asked.smaller.iter().any(|part| part.solver.scene().is_colliding(&part.tool, pose))
        })
    }

    /// The planes that hold sunk parts: the contact planes that they have penetrated, and the sides of the volume that they filled.
    pub fn sunk_planes(&self, seated: &Seated, pose: &Pose) -> Result<Vec<SunkPlane>> {
        let mut found = Vec::new();
        for (number, (body, asked)) in self.environment.bodies.iter().zip(&seated.bodies).enumerate() {
            let Some(sunk) = &asked.sunk else { continue };
            for plane in self.planes_of_sunk(number, sunk, pose)? {
                let Some((point, moved)) = self.moved_at(&plane, pose) else { continue };
                let part = body.part_in_mockup(plane.part);
                let ContactPlane { point: on_plane, normal, gap, id, .. } = plane;
                let plane = Plane { point: on_plane, normal, gap, part, id: id_in_body(id, number) };
                found.push(SunkPlane { plane, point: pose.apply(&point), room: moved.max(0.0) });
            }
            let mockup = sunk.scene().mockup();
            let pairs = self.sunk_pairs(number, sunk.scene(), pose);
            let inside = self.samples_inside(number, sunk.scene(), pose)?;
            for crossing in crossings_in_place(&self.tool, &self.start, mockup, (&pairs, &inside), pose) {
                let [t, m] = crossing.triangles;
                let plane = Plane {
                    point: crossing.at,
                    normal: scaled(&crossing.outward, -1.0),
                    gap: crossing.room,
                    part: body.part_in_mockup(mockup.part_of_face(m)),
                    id: id_in_body(u64::from(t) << 32 ^ u64::from(m) ^ 1 << 62, number),
                };
                found.push(SunkPlane { plane, point: crossing.at, room: crossing.room.max(0.0) });
            }
        }
        Ok(found)
    }

    /// The contact planes that sunk parts of a body are behind. What goes through a neighbour may leave its place to either side, and a
    /// contact plane knows one: those do not count, nor those of slivers of a part that has almost left its place: they have any direction.
    pub(crate) fn planes_of_sunk(&self, body: usize, sunk: &ContactSolver, pose: &Pose) -> Result<Vec<ContactPlane>> {
        let mut planes = sunk.contacts(&self.tool, pose, 0.0, None)?.planes;
        planes.retain(|plane| {
            let depth = self.seat_of(body, [plane.tool_part(&self.tool), plane.part]).map_or(0.0, |seat| seat.depth);
            let is_way = || self.through.iter().any(|way| dot(way, &plane.normal) < -THROUGH_COS);
            -plane.gap > SEAT_TOLERANCE.max(SLIVER_DEPTH * depth) && !(-plane.gap > FIT_DEPTH * self.size && is_way())
        });
        Ok(planes)
    }

    /// Whether a face of the tool that leads on a way is inside the neighbours of a scene at the start: their solid would have to give.
    fn leads_inside(&self, scene: &Scene, way: &Point) -> Result<bool> {
        let mesh = self.tool.mesh();
        for t in mesh.queried().step_by(mesh.faces().len().div_ceil(MOST_SAMPLE_RAYS).max(1)) {
            let corners = self.start.apply_triangle(&mesh.triangle(t));
            let normal = cross(&sub(&corners[1], &corners[0]), &sub(&corners[2], &corners[0]));
            let sign = if self.tool.adjacency().outward[t as usize] < 0 { -1.0 } else { 1.0 };
            if sign * dot(&normal, way) < LEADING_COS * length(&normal) {
                continue;
            }
            if around_point(scene, &middle_of(&corners), way)?.is_some() {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Points of sunk parts that are inside their neighbours at the start, by body.
    fn samples_of_sunk(&self) -> Result<Vec<Vec<(u32, Point)>>> {
        let (seated, mesh) = (self.seated_at_start(), self.tool.mesh());
        let mut all = Vec::new();
        for (number, asked) in seated.bodies.iter().enumerate() {
            let mut found = Vec::new();
            if let Some(sunk) = &asked.sunk {
                let stride = mesh.faces().len().div_ceil(MOST_SAMPLE_RAYS).max(1);
                let whole: Vec<(u32, Point)> =
                    mesh.queried().step_by(stride).map(|t| (t, middle_of(&mesh.triangle(t)))).collect();
                found = self.inside(&whole, sunk.scene(), &self.start)?;
                found.retain(|sample| {
                    let part =
                        self.environment.bodies[number].solver.scene().mockup().part_of_face(sample.triangles[1]);
                    let seat = self.seat_of(number, [self.tool.part_of_face(sample.triangles[0]), part]);
                    seat.is_some_and(|seat| seat.kind == SeatKind::Sunk)
                });
            }
            let stride = found.len().div_ceil(MOST_PLACE_SAMPLES).max(1);
            let few = found.iter().step_by(stride).map(|sample| sample.triangles[0]);
            all.push(few.map(|t| (t, middle_of(&mesh.triangle(t)))).collect());
        }
        Ok(all)
    }

    /// Those of them that are inside a neighbour at a pose.
    pub(crate) fn samples_inside(&self, body: usize, scene: &Scene, pose: &Pose) -> Result<Vec<Inside>> {
        self.samples.get(body).map_or_else(|| Ok(Vec::new()), |samples| self.inside(samples, scene, pose))
    }

    fn inside(&self, samples: &[(u32, Point)], scene: &Scene, pose: &Pose) -> Result<Vec<Inside>> {
        let mut found = Vec::new();
        for (t, point) in samples {
            let at = pose.apply(point);
            let [a, b, c] = pose.apply_triangle(&self.tool.mesh().triangle(*t));
            let outward = cross(&sub(&b, &a), &sub(&c, &a));
            if let Some(m) = around_point(scene, &at, &outward)? {
                found.push(Inside { at, triangles: [*t, m] });
            }
        }
        Ok(found)
    }

    /// The ways on which parts that go through a neighbour leave their place against a contact plane.
    fn ways_through(&self) -> Result<Vec<Point>> {
        let (seated, mut ways) = (self.seated_at_start(), Vec::new());
        for (number, asked) in seated.bodies.iter().enumerate() {
            let Some(sunk) = &asked.sunk else { continue };
            let planes = sunk.contacts(&self.tool, &self.start, 0.0, None)?.planes;
            for way in planes.iter().flat_map(|plane| [plane.normal, scaled(&plane.normal, -1.0)]) {
                if self.leads_inside(sunk.scene(), &way)? {
                    continue;
                }
                let is_in_place = |by: &f64| -> Result<bool> {
                    let pose = self.moved(&self.start, &way, by * self.size)?;
                    let (scene, mockup) = (sunk.scene(), sunk.scene().mockup());
                    let pairs = self.sunk_pairs(number, scene, &pose);
                    Ok(crossing_outside(&self.tool, &self.start, mockup, (&pairs, &[]), &pose).is_none())
                };
                if THROUGH_TRIALS.iter().map(is_in_place).collect::<Result<Vec<bool>>>()?.iter().all(|is_in| *is_in) {
                    ways.push(way);
                }
            }
        }
        Ok(ways)
    }

    /// A pair `[tool part, part]` of a body at the start.
    fn seat_of(&self, body: usize, pair: [u32; 2]) -> Option<&Seat> {
        self.makings[body].seats.iter().find(|seat| [seat.tool_part, seat.part] == pair)
    }

    /// The triangles of sunk pairs that meet.
    pub(crate) fn sunk_pairs(&self, body: usize, scene: &feeler_core::Scene, pose: &Pose) -> Vec<[u32; 2]> {
        let (tool, mockup) = (&self.tool, scene.mockup());
        let mut hit = scene.collide(tool, pose).pairs;
        hit.retain(|[t, m]| {
            let pair = [tool.part_of_face(*t), mockup.part_of_face(*m)];
            self.seat_of(body, pair).is_some_and(|seat| seat.kind == SeatKind::Sunk)
        });
        hit
    }

    /// The corner (tool frame) that is deepest behind a plane, and how far it has moved along the normal since the start, metres.
    pub(crate) fn moved_at(&self, plane: &ContactPlane, pose: &Pose) -> Option<(Point, f64)> {
        let mesh = self.tool.mesh();
        let corners = plane.tool_triangles.iter().flat_map(|t| mesh.triangle(*t));
        let height = |p: &Point| dot(&pose.apply(p), &plane.normal);
        let deepest = corners.min_by(|a, b| height(a).total_cmp(&height(b)))?;
        let moved = dot(&sub(&pose.apply(&deepest), &self.start.apply(&deepest)), &plane.normal);
        Some((deepest, moved))
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
}

fn middle_of(corners: &[Point; 3]) -> Point {
    std::array::from_fn(|a| (corners[0][a] + corners[1][a] + corners[2][a]) / 3.0)
}

/// The triangle of the solid that a point is inside of, where a ray from it leaves that.
fn around_point(scene: &Scene, at: &Point, towards: &Point) -> Result<Option<u32>> {
    let Some(hit) = scene.ray(&Ray { origin: *at, direction: *towards }, f64::INFINITY, &[])? else { return Ok(None) };
    let [a, b, c] = scene.mockup().mesh().triangle(hit.triangle);
    let outward = cross(&sub(&b, &a), &sub(&c, &a));
    let sign = if scene.mockup().adjacency().outward[hit.triangle as usize] < 0 { -1.0 } else { 1.0 };
    Ok((sign * dot(&outward, towards) > 0.0).then_some(hit.triangle))
}

/// Of the first parts of a tool, the least mean thickness, metres: twice the volume by the area. 0 of open sheets.
fn thickness(tool: &Tool, parts: u32) -> f64 {
    let mesh = tool.mesh();
    let origin = mesh.bounds().lower;
    let mut sums = vec![(0.0, 0.0); parts as usize];
    for t in mesh.queried() {
        let Some((volume, area)) = sums.get_mut(tool.part_of_face(t) as usize) else { continue };
        let [a, b, c] = mesh.triangle(t).map(|p| sub(&p, &origin));
        let normal = cross(&sub(&b, &a), &sub(&c, &a));
        *volume += dot(&a, &normal) / 6.0;
        *area += 0.5 * length(&normal);
    }
    let of_part = |(volume, area): &(f64, f64)| if *area > 0.0 { 2.0 * volume.abs() / area } else { f64::INFINITY };
    sums.iter().map(of_part).fold(f64::INFINITY, f64::min)
}

/// A body of which nothing is known yet.
fn unseated(solver: &ContactSolver, tool: &Tool) -> Makings {
    Makings {
        solver: solver.with_scene(solver.scene().clone()),
        tool_parts: tool.parts() as u32,
        seats: Vec::new(),
        eroded: Vec::new(),
        regions: None,
        always: Vec::new(),
        neighbours: None,
    }
}
