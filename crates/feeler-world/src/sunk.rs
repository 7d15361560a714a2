//! Sunk parts: deeper in their neighbours than a fit, such as bolts in plates without holes.
//!
//! They leave through the volume that they filled. This is tested at poses along a motion, so their steps are short.

use std::sync::{Arc, Mutex};

use feeler_contacts::{ContactPlane, ContactSolver};
use feeler_core::geometry::twist::{times, transposed};
use feeler_core::geometry::vectors::{along, cross, dot, length, scaled, sub};
use feeler_core::{GoOn, Point, Pose, Scene, Tool, Triangle};

use crate::constants::{
    CORNER_SHARE, FACE_ANGLE_COS, FIT_DEPTH, LEADING_COS, MOST_BEARING_POINTS, MOST_FLUSH_POINTS, MOST_FLUSH_TRIED,
    MOST_PLACE_CORNERS, MOST_PLACE_SAMPLES, MOST_SAMPLE_RAYS, MOST_STEPS_A_LENGTH, SEAT_TOLERANCE, SLIVER_DEPTH,
    STEP_THICKNESS, THROUGH_COS, THROUGH_TRIALS, TOUCH,
};
use crate::environment::{id_in_body, Plane};
use crate::error::Result;
use crate::seats::{
    beyond, crossing_outside, crossings_in_place, find_around, flush_points, pockets, scene_of, surface_in, tool_of,
    Around, AtStart, Beyond, Erosion, Filled, Flush, FlushAt, Inside, SeatKind, Seated,
};
use crate::solid::around_point;
use crate::surroundings::Surroundings;

/// High bits of plane ids: they keep the ids of flush points, of crossings and of contact planes apart.
const FLUSH_BIT: u32 = 61;
const CROSSING_BIT: u32 = 62;

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
    /// Finds at the start the data that sunk parts need on their way. Tool parts from `own_parts` on are the gripping tool.
    pub(crate) fn know_sunk(&mut self, own_parts: u32, go_on: GoOn<'_>) -> Result<()> {
        let sunk = self.seats().filter(|seat| seat.kind == SeatKind::Sunk);
        self.least_sunk = sunk.map(|seat| seat.depth).fold(f64::INFINITY, f64::min);
        if self.least_sunk.is_finite() || self.overlap > 0.0 {
            let thin = STEP_THICKNESS * thickness(&self.tool, own_parts);
            self.stride = self.stride.min(thin.max(self.size / MOST_STEPS_A_LENGTH));
        }
        if self.least_sunk.is_finite() {
            let seated = self.seated_at_start();
            let sunk = seated.bodies.iter().map(|asked| asked.sunk.as_ref().map(|sunk| sunk.scene().as_ref()));
            self.filled = self.find_filled(sunk)?;
            let tool = self.tool.clone();
            let mut erosion = Erosion::new(&tool);
            self.around = self.all_around(&mut erosion)?;
            let sunk = (0..).zip(seated.bodies.iter().map(|asked| asked.sunk.as_ref()));
            let flush: Vec<Vec<Flush>> = sunk
                .map(|(body, sunk)| sunk.map_or_else(|| Ok(Vec::new()), |sunk| self.find_flush(body, sunk.scene())))
                .collect::<Result<_>>()?;
            self.through = self.ways_through(&flush)?;
            self.flush = flush.iter().enumerate().map(|(body, flush)| self.keep_flush(body, flush)).collect();
            self.samples = self.samples_of_sunk()?;
            self.know_beyond(&mut erosion, go_on)?;
        }
        Ok(())
    }

    /// Finds what of their neighbours lies beyond the places of sunk parts.
    fn know_beyond(&mut self, erosion: &mut Erosion<'_>, go_on: GoOn<'_>) -> Result<()> {
        let mut all = Vec::with_capacity(self.makings.len());
        for (body, makings) in self.makings.iter().enumerate() {
            let mut of_body = Vec::with_capacity(makings.seats.len());
            for seat in &makings.seats {
                let regions = makings.regions.as_ref().filter(|_| seat.kind == SeatKind::Sunk);
                let Some(regions) = regions else {
                    of_body.push(None);
                    continue;
                };
                let (scene, place, part) = (makings.solver.scene(), self.place(body), seat.tool_part);
                let (mockup, pair) = (scene.mockup(), [part, seat.part]);
                let parts = mockup.part_bounds().len();
                if let Some(around) = self.around_of(body, pair) {
                    of_body.push(self.beyond_around(around, regions.met_of_tool(&self.tool, pair), parts, go_on)?);
                    continue;
                }
                let tool = erosion.part_with_play(part)?;
                let surface = surface_in(place, (part, &tool), &scene.of_one_part(seat.part), go_on)?;
                let met = regions.met(&[pair]).filter(|t| mockup.part_of_face(*t) == seat.part);
                let met = met.map(|t| mockup.mesh().triangle(t)).collect();
                let far = beyond(place, (part, surface.as_ref()), met, go_on)?;
                let scene = (!far.is_empty()).then(|| scene_of(&far, vec![seat.part; far.len()], parts)).transpose()?;
                of_body.push(scene.map(|scene| Beyond { tool, scene: Arc::new(scene) }));
            }
            all.push(of_body);
        }
        self.makings.iter_mut().zip(all).for_each(|(makings, beyond)| makings.beyond = beyond);
        // Answers that are remembered do not know these surfaces yet.
        self.known = Mutex::default();
        Ok(())
    }

    /// The same of a part that is around a neighbour: its own triangles that may meet that, beyond the neighbour's place, and the neighbour,
    /// smaller by a play. `parts`: how many the neighbour's mock-up has.
    fn beyond_around(&self, around: &Around, met: Vec<u32>, parts: usize, go_on: GoOn<'_>) -> Result<Option<Beyond>> {
        let smaller = &around.smaller;
        let surface = surface_in(around.place(), (0, smaller), &around.host, go_on)?;
        let met = met.into_iter().map(|t| self.start.apply_triangle(&self.tool.mesh().triangle(t))).collect();
        let far = beyond(around.place(), (0, surface.as_ref()), met, go_on)?;
        if far.is_empty() {
            return Ok(None);
        }
        let into_tool = |at: &Point| times(&transposed(self.start.rotation()), &sub(at, self.start.translation()));
        let far: Vec<Triangle> = far.iter().map(|corners| corners.each_ref().map(into_tool)).collect();
        let neighbour: Vec<Triangle> = smaller.mesh().queried().map(|t| smaller.mesh().triangle(t)).collect();
        let scene = scene_of(&neighbour, vec![around.pair[1]; neighbour.len()], parts)?;
        Ok(Some(Beyond { tool: Arc::new(tool_of(&far)?.with_pivot(*self.tool.pivot())), scene: Arc::new(scene) }))
    }

    /// The planes that hold sunk parts: the contact planes that they have penetrated, the surfaces that they are flush with, and the sides
    /// of the volume that they filled.
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
            let plane = |point: Point, normal: Point, gap: f64, [t, m]: [u32; 2], bit: u32| {
                let id = id_in_body(u64::from(t) << 32 ^ u64::from(m) ^ 1 << bit, number);
                Plane { point, normal, gap, part: body.part_in_mockup(mockup.part_of_face(m)), id }
            };
            for FlushAt { at, moved, flush } in self.flush_at(number, sunk.scene(), pose)? {
                let plane = plane(at, flush.normal, moved, flush.triangles, FLUSH_BIT);
                found.push(SunkPlane { plane, point: at, room: moved.max(0.0) });
            }
            let pairs = self.sunk_pairs(number, sunk.scene(), pose);
            let inside = self.samples_inside(number, sunk.scene(), pose)?;
            for crossing in crossings_in_place(self.place(number), mockup, (&pairs, &inside), pose) {
                let outward = scaled(&crossing.outward, -1.0);
                let plane = plane(crossing.at, outward, crossing.room, crossing.triangles, CROSSING_BIT);
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
            let pair = [plane.tool_part(&self.tool), plane.part];
            let depth = self.seat_of(body, pair).map_or(0.0, |seat| seat.depth);
            let is_way =
                || self.through.get(body).into_iter().flatten().any(|way| dot(way, &plane.normal) < -THROUGH_COS);
            let is_filled = plane.tool_triangles.iter().all(|t| self.is_filled(body, *t));
            !is_filled
                && -plane.gap > SEAT_TOLERANCE.max(SLIVER_DEPTH * depth)
                && !(-plane.gap > FIT_DEPTH * self.size_of_pair(body, pair) && is_way())
        });
        Ok(planes)
    }

    /// Whether a face of the tool that leads on a way has the solid of the neighbours of a scene before it at the start: that would have to
    /// give. A face that is flush with the surface where the way leaves has nothing before it.
    fn leads_inside(&self, body: usize, scene: &Scene, way: &Point) -> Result<bool> {
        let mesh = self.tool.mesh();
        for t in mesh.queried().step_by(mesh.faces().len().div_ceil(MOST_SAMPLE_RAYS).max(1)) {
            let corners = self.start.apply_triangle(&mesh.triangle(t));
            let normal = cross(&sub(&corners[1], &corners[0]), &sub(&corners[2], &corners[0]));
            let sign = if self.tool.adjacency().outward[t as usize] < 0 { -1.0 } else { 1.0 };
            if sign * dot(&normal, way) < LEADING_COS * length(&normal) || self.is_filled(body, t) {
                continue;
            }
            let before = around_point(scene, &along(&middle_of(&corners), SEAT_TOLERANCE, way), way)?;
            let own = self.tool.part_of_face(t);
            if before.is_some_and(|m| self.around_of(body, [own, scene.mockup().part_of_face(m)]).is_none()) {
                return Ok(true);
            }
        }
        let back = scaled(way, -1.0);
        for around in &self.around[body] {
            let (mesh, outward) = (around.neighbour.mesh(), &around.neighbour.adjacency().outward);
            for t in mesh.queried().step_by(mesh.faces().len().div_ceil(MOST_SAMPLE_RAYS).max(1)) {
                let corners = mesh.triangle(t);
                let normal = cross(&sub(&corners[1], &corners[0]), &sub(&corners[2], &corners[0]));
                let sign = if outward[t as usize] < 0 { -1.0 } else { 1.0 };
                let leads = sign * dot(&normal, &back) >= LEADING_COS * length(&normal);
                let before = along(&middle_of(&corners), SEAT_TOLERANCE, &back);
                if leads && around_point(&around.host, &before, &back)?.is_some() {
                    return Ok(true);
                }
            }
        }
        Ok(false)
    }

    /// Points of sunk parts that are inside their neighbours at the start, by body: middles and corners of triangles, each spread over
    /// the parts.
    fn samples_of_sunk(&self) -> Result<Vec<Vec<(u32, Point)>>> {
        let (seated, mesh) = (self.seated_at_start(), self.tool.mesh());
        let mut all = Vec::new();
        for (number, asked) in seated.bodies.iter().enumerate() {
            let mut found = Vec::new();
            if let Some(sunk) = &asked.sunk {
                let stride = mesh.faces().len().div_ceil(MOST_SAMPLE_RAYS).max(1);
                let bearing = mesh.queried().filter(|t| !self.is_filled(number, *t));
                let whole: Vec<(u32, Point)> =
                    bearing.step_by(stride).map(|t| (t, middle_of(&mesh.triangle(t)))).collect();
                let mockup = self.environment.bodies[number].solver.scene().mockup();
                let is_sunk = |sample: &Inside| {
                    let [t, m] = sample.triangles;
                    let seat = self.seat_of(number, [self.tool.part_of_face(t), mockup.part_of_face(m)]);
                    seat.is_some_and(|seat| seat.kind == SeatKind::Sunk)
                };
                let inside = |samples: Vec<(u32, Point)>| -> Result<Vec<(u32, Point)>> {
                    let mut kept = Vec::new();
                    for sample in samples {
                        let found = self.inside(&[sample], sunk.scene(), &self.start)?;
                        kept.extend(found.first().filter(|found| is_sunk(found)).map(|_| sample));
                    }
                    Ok(kept)
                };
                let middles = inside(whole)?;
                let stride = (3 * middles.len()).div_ceil(MOST_SAMPLE_RAYS).max(1);
                let near_corners: Vec<(u32, Point)> = middles
                    .iter()
                    .flat_map(|(t, middle)| {
                        mesh.triangle(*t).map(|corner| (*t, along(&corner, CORNER_SHARE, &sub(middle, &corner))))
                    })
                    .step_by(stride)
                    .collect();
                found.extend(spread(&inside(near_corners)?, |(_, point)| point, MOST_PLACE_CORNERS));
                found.extend(middles.iter().step_by(middles.len().div_ceil(MOST_PLACE_SAMPLES).max(1)));
            }
            all.push(found);
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

    /// By body, the directions in which parts that go through a neighbour leave their place against a contact plane.
    fn ways_through(&self, flush: &[Vec<Flush>]) -> Result<Vec<Vec<Point>>> {
        let (seated, mut all) = (self.seated_at_start(), vec![Vec::new(); self.makings.len()]);
        for (number, (asked, ways)) in seated.bodies.iter().zip(&mut all).enumerate() {
            let Some(sunk) = &asked.sunk else { continue };
            let planes = sunk.contacts(&self.tool, &self.start, 0.0, None)?.planes;
            let mut tried: Vec<Point> = Vec::new();
            let normals = planes.iter().map(|plane| plane.normal).chain(flush[number].iter().map(|flush| flush.normal));
            for way in normals.flat_map(|normal| [normal, scaled(&normal, -1.0)]) {
                if tried.iter().any(|other| dot(other, &way) >= FACE_ANGLE_COS) {
                    continue;
                }
                tried.push(way);
                let is_borne = flush[number].iter().any(|flush| flush.bears && dot(&way, &flush.normal) < -LEADING_COS);
                if is_borne || self.leads_inside(number, sunk.scene(), &way)? {
                    continue;
                }
                let is_in_place = |by: &f64| -> Result<bool> {
                    let pose = self.moved(&self.start, &way, by * self.size)?;
                    let (scene, mockup) = (sunk.scene(), sunk.scene().mockup());
                    let pairs = self.sunk_pairs(number, scene, &pose);
                    Ok(crossing_outside(self.place(number), mockup, (&pairs, &[]), &pose).is_none())
                };
                if THROUGH_TRIALS.iter().map(is_in_place).collect::<Result<Vec<bool>>>()?.iter().all(|is_in| *is_in) {
                    ways.push(way);
                }
            }
        }
        Ok(all)
    }

    /// See `around`.
    fn all_around(&self, erosion: &mut Erosion<'_>) -> Result<Vec<Vec<Around>>> {
        let mut all = Vec::with_capacity(self.makings.len());
        for makings in &self.makings {
            let mut of_body = Vec::new();
            for seat in makings.seats.iter().filter(|seat| seat.kind == SeatKind::Sunk) {
                let smaller = erosion.part_with_play(seat.tool_part)?;
                let own = (&self.start, self.tool.as_ref(), smaller.as_ref());
                let neighbour = makings.solver.scene().of_one_part(seat.part);
                of_body.extend(find_around([seat.tool_part, seat.part], own, &neighbour)?);
            }
            all.push(of_body);
        }
        Ok(all)
    }

    /// The part of the tool and the neighbour of a pair, where the part is around it.
    fn around_of(&self, body: usize, pair: [u32; 2]) -> Option<&Around> {
        self.around.get(body)?.iter().find(|around| around.pair == pair)
    }

    /// The size of the body that moves through the other's place, metres: tolerances of a sunk pair are shares of it.
    pub(crate) fn size_of_pair(&self, body: usize, pair: [u32; 2]) -> f64 {
        self.around_of(body, pair).map_or(self.size, |around| around.size)
    }

    /// See `filled`; `sunk`: the sunk neighbours, by body.
    fn find_filled<'a>(&self, sunk: impl Iterator<Item = Option<&'a Scene>>) -> Result<Vec<Filled>> {
        let pockets = pockets(&self.tool, self.size);
        let mut all = Vec::new();
        for scene in sunk {
            let mut filled = Filled::default();
            for pocket in &pockets {
                let Some(scene) = scene else { break };
                let outward = times(self.start.rotation(), &pocket.outward);
                let is_solid = |point: &Point| -> Result<bool> {
                    let before = along(&self.start.apply(point), SEAT_TOLERANCE, &outward);
                    Ok(around_point(scene, &before, &outward)?.is_some())
                };
                if !pocket.mouth.iter().map(is_solid).collect::<Result<Vec<bool>>>()?.contains(&true) {
                    filled.add(pocket);
                }
            }
            all.push(filled);
        }
        Ok(all)
    }

    /// What sunk parts fill of a body.
    pub(crate) fn place(&self, body: usize) -> AtStart<'_> {
        AtStart { start: &self.start, tool: &self.tool, filled: &self.filled[body], around: &self.around[body] }
    }

    fn is_filled(&self, body: usize, tool_triangle: u32) -> bool {
        self.filled.get(body).is_some_and(|filled| filled.contains(tool_triangle))
    }

    /// Points of a body's sunk parts that are flush with it at the start, spread over their surfaces. What fills a pocket bears nothing.
    fn find_flush(&self, body: usize, sunk: &Scene) -> Result<Vec<Flush>> {
        let near = sunk.near_pairs(&self.tool, &self.start, TOUCH)?;
        let pairs = near.iter().map(|gap| [gap.tool_triangle, gap.mockup_triangle]);
        let all: Vec<Flush> = pairs
            .flat_map(|pair| flush_points(&self.tool, &self.start, sunk.mockup(), pair))
            .filter(|flush| !(flush.bears && self.is_filled(body, flush.triangles[0])))
            .collect();
        let mut found = Vec::new();
        for flush in all.iter().step_by(all.len().div_ceil(MOST_FLUSH_TRIED).max(1)) {
            let beneath = along(&self.start.apply(&flush.point), -SEAT_TOLERANCE, &flush.normal);
            if around_point(sunk, &beneath, &flush.normal)?.is_some() {
                found.push(*flush);
            }
        }
        let (bearing, beside): (Vec<Flush>, Vec<Flush>) = found.into_iter().partition(|flush| flush.bears);
        let spread = |all: &[Flush], most| spread(all, |flush| &flush.point, most);
        Ok([spread(&beside, MOST_FLUSH_POINTS), spread(&bearing, MOST_BEARING_POINTS)].concat())
    }

    /// Those of a body that a way through a neighbour does not take in.
    fn keep_flush(&self, body: usize, flush: &[Flush]) -> Vec<Flush> {
        let ways = self.through.get(body).map_or(&[][..], Vec::as_slice);
        flush.iter().filter(|flush| ways.iter().all(|way| dot(way, &flush.normal) >= -LEADING_COS)).copied().collect()
    }

    /// Those of a body that have the neighbour beneath their place, at a pose.
    pub(crate) fn flush_at(&self, body: usize, sunk: &Scene, pose: &Pose) -> Result<Vec<FlushAt>> {
        let mut found = Vec::new();
        for flush in self.flush.get(body).into_iter().flatten() {
            let at = pose.apply(&flush.point);
            let moved = dot(&sub(&at, &self.start.apply(&flush.point)), &flush.normal);
            let beneath = along(&at, -(moved + SEAT_TOLERANCE), &flush.normal);
            if around_point(sunk, &beneath, &flush.normal)?.is_some() {
                found.push(FlushAt { at, moved, flush: *flush });
            }
        }
        Ok(found)
    }

    /// The triangles of sunk pairs that meet.
    pub(crate) fn sunk_pairs(&self, body: usize, scene: &feeler_core::Scene, pose: &Pose) -> Vec<[u32; 2]> {
        let (tool, mockup) = (&self.tool, scene.mockup());
        let mut hit = scene.collide(tool, pose).pairs;
        hit.retain(|[t, m]| {
            let pair = [tool.part_of_face(*t), mockup.part_of_face(*m)];
            !self.is_filled(body, *t) && self.seat_of(body, pair).is_some_and(|seat| seat.kind == SeatKind::Sunk)
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
}

fn middle_of(corners: &[Point; 3]) -> Point {
    std::array::from_fn(|a| (corners[0][a] + corners[1][a] + corners[2][a]) / 3.0)
}

/// Picks items whose points are spread out: each is the farthest from all that were picked before it.
fn spread<T: Copy>(all: &[T], point: impl Fn(&T) -> &Point, most: usize) -> Vec<T> {
    let square = |a: &T, b: &T| sub(point(a), point(b)).iter().map(|x| x * x).sum::<f64>();
    let Some(first) = all.first() else { return Vec::new() };
    let mut away: Vec<f64> = all.iter().map(|one| square(one, first)).collect();
    let mut chosen = Vec::new();
    while chosen.len() < most {
        let Some((next, farthest)) = away.iter().copied().enumerate().max_by(|a, b| a.1.total_cmp(&b.1)) else { break };
        if farthest == 0.0 {
            break;
        }
        chosen.push(all[next]);
        for (least, one) in away.iter_mut().zip(all) {
            *least = least.min(square(one, &all[next]));
        }
    }
    chosen
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
