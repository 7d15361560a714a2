//! Queries of all bodies at once: parts and triangles in the answers have their mock-up indices, wherever they lie.

use std::sync::Arc;

use feeler_contacts::{ContactPlane, Contacts, Footing, Penetration, PenetrationKind, MOST_PLANES};
use feeler_core::geometry::vectors::length;
use feeler_core::{Cast, CastOptions, Collision, Gap, GoOn, IgnoredPairs, Motion, Pose, Scene, Tool};

use crate::constants::{CLEARANCE_SHARE, CLEARANCE_STEP, TOUCH};
use crate::environment::{id_in_body, Body, Environment};
use crate::error::Result;

impl Environment {
    fn scenes(&self) -> impl Iterator<Item = (&Body, &Arc<Scene>)> {
        self.bodies.iter().map(|body| (body, body.solver.scene()))
    }

    /// Every colliding pair of triangles at a pose, as of [`Scene::collide`].
    pub fn collide(&self, tool: &Tool, pose: &Pose) -> Collision {
        let mut all = Collision::default();
        for (body, scene) in self.scenes() {
            let mut found = scene.collide(tool, pose);
            if body.part.is_some() && !found.pairs.is_empty() {
                let numbers = self.numbers_of(body);
                found.pairs.iter_mut().for_each(|[_, triangle]| *triangle = numbers.of(*triangle));
            }
            if all.pairs.is_empty() {
                all = found;
            } else if !found.pairs.is_empty() {
                let pairs = all.pairs.into_iter().chain(found.pairs);
                let mut rows: Vec<_> = pairs.zip(all.kinds.into_iter().chain(found.kinds)).collect();
                rows.sort_unstable_by_key(|(pair, _)| *pair);
                (all.pairs, all.kinds) = rows.into_iter().unzip();
            }
        }
        all
    }

    /// Whether anything collides at a pose.
    pub fn is_colliding(&self, tool: &Tool, pose: &Pose) -> bool {
        self.scenes().any(|(_, scene)| scene.is_colliding(tool, pose))
    }

    /// The first impact on the way between two poses, and its part; see [`Scene::cast`].
    pub fn cast(&self, tool: &Tool, (from, to): (&Pose, &Pose), tolerance: f64) -> Result<Option<(Cast, u32)>> {
        let mut first: Option<(Cast, u32)> = None;
        for (body, scene) in self.scenes() {
            let Some(hit) = scene.cast(tool, from, to, &CastOptions::default().with_tolerance(tolerance))? else {
                continue;
            };
            if first.as_ref().is_none_or(|(first, _)| hit.fraction < first.fraction) {
                let part = body.part_in_mockup(scene.mockup().part_of_face(hit.mockup_triangle));
                first = Some((hit, part));
            }
        }
        Ok(first)
    }

    /// The least distance at a pose, if it is at most `within` (metres).
    pub fn distance(&self, tool: &Tool, pose: &Pose, mut within: f64) -> Result<Option<Gap>> {
        let mut best: Option<Gap> = None;
        for (body, scene) in self.scenes() {
            let Some(gap) = scene.distance(tool, pose, within)? else { continue };
            if best.is_none_or(|best| gap.distance < best.distance) {
                best = Some(self.renumbered(body, gap));
                within = gap.distance;
            }
        }
        Ok(best)
    }

    /// The parts within some metres at a pose, nearest first; see [`Scene::clearance`].
    pub fn clearance(&self, tool: &Tool, pose: &Pose, within: f64) -> Result<Vec<Gap>> {
        let mut rows = Vec::new();
        for (body, scene) in self.scenes() {
            rows.extend(scene.clearance(tool, pose, within)?.into_iter().map(|gap| self.renumbered(body, gap)));
        }
        rows.sort_by(|a, b| a.distance.total_cmp(&b.distance));
        Ok(rows)
    }

    /// The contact planes at a pose, deepest first, and the points that carry each; see [`contacts`](feeler_contacts::ContactSolver::contacts).
    pub fn contacts(
        &self,
        tool: &Tool,
        pose: &Pose,
        margin: f64,
        reference: Option<&Pose>,
    ) -> Result<(Contacts, Vec<Footing>)> {
        let (mut planes, mut all) = (Vec::new(), Contacts::default());
        for (number, body) in self.bodies.iter().enumerate() {
            let found = body.solver.contacts(tool, pose, margin, reference)?;
            all.omitted += found.omitted;
            all.is_meeting |= found.is_meeting;
            planes.extend(found.planes.into_iter().map(|plane| (number, plane)));
        }
        planes.sort_by(|(_, a), (_, b)| a.gap.total_cmp(&b.gap));
        all.omitted += planes.len().saturating_sub(MOST_PLANES);
        planes.truncate(MOST_PLANES);
        let footings = self.footings(tool, pose, &planes);
        all.planes = planes.into_iter().map(|(number, plane)| self.renumbered_plane(number, plane)).collect();
        Ok((all, footings))
    }

    fn footings(&self, tool: &Tool, pose: &Pose, planes: &[(usize, ContactPlane)]) -> Vec<Footing> {
        planes.iter().map(|(number, plane)| self.bodies[*number].solver.footing(tool, pose, plane)).collect()
    }

    fn renumbered_plane(&self, number: usize, mut plane: ContactPlane) -> ContactPlane {
        let body = &self.bodies[number];
        if body.part.is_some() {
            let numbers = self.numbers_of(body);
            plane.mockup_triangles.iter_mut().for_each(|triangle| *triangle = numbers.of(*triangle));
        }
        (plane.part, plane.id) = (body.part_in_mockup(plane.part), id_in_body(plane.id, number));
        plane
    }

    /// A translation that frees the tool, and the points that carry each of its contact planes; `None` if it is in
    /// nothing. Of several bodies the longest, an estimate if the tool then collides with another. See
    /// [`penetration`](feeler_contacts::ContactSolver::penetration).
    pub fn penetration(&self, tool: &Tool, pose: &Pose, margin: f64) -> Result<Option<(Penetration, Vec<Footing>)>> {
        let mut deepest: Option<(usize, Penetration)> = None;
        for (number, body) in self.bodies.iter().enumerate() {
            let found = body.solver.penetration(tool, pose, margin, None)?;
            if found.depth > deepest.as_ref().map_or(0.0, |(_, deepest)| deepest.depth) {
                deepest = Some((number, found));
            }
        }
        let Some((number, mut found)) = deepest else { return Ok(None) };
        if self.bodies.len() > 1 && self.is_colliding(tool, &pose.translated(&found.translation)?) {
            found.kind = PenetrationKind::Estimate;
        }
        let planes: Vec<_> = found.contacts.planes.drain(..).map(|plane| (number, plane)).collect();
        let footings = self.footings(tool, pose, &planes);
        found.contacts.planes =
            planes.into_iter().map(|(number, plane)| self.renumbered_plane(number, plane)).collect();
        Ok(Some((found, footings)))
    }

    /// Whether the tool is inside of a body, or one inside of it.
    pub fn is_containing(&self, tool: &Tool, pose: &Pose) -> bool {
        self.bodies.iter().any(|body| {
            let found = body.solver.containment(tool, pose);
            !found.containing.is_empty() || !found.contained.is_empty()
        })
    }

    /// The pairs `[tool part, part]` that are together at a pose, and so are seats; sorted.
    pub fn seated_parts(&self, tool: &Tool, pose: &Pose) -> Result<Vec<[u32; 2]>> {
        let mut pairs = Vec::new();
        for (body, scene) in self.scenes() {
            let near = scene.near_pairs(tool, pose, TOUCH)?;
            pairs.extend(near.iter().map(|gap| [gap.tool_part, body.part_in_mockup(gap.part)]));
        }
        pairs.sort_unstable();
        pairs.dedup();
        Ok(pairs)
    }

    /// The same bodies without some pairs `[tool part, part]`.
    pub fn ignoring(&self, tool: &Tool, pairs: &[[u32; 2]]) -> Environment {
        let bodies = self.bodies.iter().map(|body| {
            let scene = body.solver.scene();
            let own = pairs.iter().filter_map(|[ours, part]| Some([*ours, body.own_part(*part)?]));
            let ignored = IgnoredPairs::new(tool.parts(), scene.mockup().part_bounds().len(), own);
            Body { solver: body.solver.with_scene(Arc::new(scene.ignoring(Arc::new(ignored)))), part: body.part }
        });
        Environment { bodies: bodies.collect() }
    }

    /// The least distance along a way through poses, if it is less than `least` (metres); see [`least_distance`].
    pub fn least_distance(&self, tool: &Tool, way: &[Pose], mut least: f64) -> Result<f64> {
        let single = way.first().filter(|_| way.len() == 1).map(|pose| [*pose, *pose]);
        for leg in way.windows(2).chain(single.iter().map(|leg| &leg[..])) {
            for (_, scene) in self.scenes() {
                least = least_distance(scene, tool, &Motion::new(tool, &leg[0], &leg[1]), least, &|| true)?;
            }
        }
        Ok(least)
    }

    fn renumbered(&self, body: &Body, gap: Gap) -> Gap {
        if body.part.is_none() {
            return gap;
        }
        let mockup_triangle = self.numbers_of(body).of(gap.mockup_triangle);
        Gap { part: body.part_in_mockup(gap.part), mockup_triangle, ..gap }
    }

    /// The numbers in the mock-up of the triangles of a part that was put down: its own are in the same order.
    fn numbers_of(&self, body: &Body) -> Numbers {
        let (mockup, part) = (self.bodies[0].solver.scene().mockup(), body.part.unwrap_or_default());
        let of = |triangle: &u32| mockup.part_of_face(*triangle);
        let (faces, count) =
            (mockup.mesh().faces().len() as u32, body.solver.scene().mockup().mesh().faces().len() as u32);
        let mut first = 0..faces;
        while !first.is_empty() {
            let middle = first.start + (first.end - first.start) / 2;
            first = if of(&middle) < part { middle + 1..first.end } else { first.start..middle };
        }
        let own = first.start..(first.start + count).min(faces);
        if own.len() == count as usize && own.clone().all(|triangle| of(&triangle) == part) {
            return Numbers::From(own.start);
        }
        Numbers::List((0..faces).filter(|triangle| of(triangle) == part).collect())
    }
}

/// The numbers in the mock-up of the triangles of one part.
enum Numbers {
    From(u32),
    List(Vec<u32>),
}

impl Numbers {
    fn of(&self, own: u32) -> u32 {
        match self {
            Numbers::From(first) => first + own,
            Numbers::List(numbers) => numbers[own as usize],
        }
    }
}

/// The least distance of a scene from a tool that moves, if it is less than `least`, metres; refined to a share of the tool's length.
///
/// Conservative advancement: while the tool moves by less than the current distance minus the least so far, the least cannot change.
pub fn least_distance(
    scene: &Scene,
    tool: &Tool,
    motion: &Motion,
    mut least: f64,
    goes_on: &(dyn Fn() -> bool + Sync),
) -> Result<f64> {
    let (long, size) = (motion.longest_way(), length(&tool.mesh().bounds().extent()));
    let mut time = 0.0;
    let scene = scene.stoppable(GoOn::new(goes_on));
    while let Some(gap) = scene.distance(tool, &motion.at(time), least + long * (1.0 - time))? {
        GoOn::new(goes_on).check()?;
        let beyond = gap.distance - least;
        least = least.min(gap.distance);
        if time >= 1.0 || least == 0.0 {
            break;
        }
        let step = beyond.max(CLEARANCE_STEP * size).max(CLEARANCE_SHARE * least) / long.max(f64::MIN_POSITIVE);
        time = (time + step).min(1.0);
    }
    Ok(least)
}
