//! Containment: the tool wholly inside a part, or a part inside the tool, without colliding triangles.
//!
//! A connected surface that does not cross another lies wholly on one side of it, so one corner decides: it is inside
//! if the winding number of the other surface around it is not zero. That number is counted by ray crossings with exact
//! signs (point in polyhedron) rather than as a sum of solid angles (A. Jacobson, L. Kavan, O. Sorkine-Hornung: Robust
//! inside-outside segmentation using generalized winding numbers, 2013), since closed surfaces need no more. Open
//! surfaces have no inside.

use std::collections::{BTreeMap, BTreeSet};

use feeler_core::clash::solids::ConnectedSurface;
use feeler_core::constants::NEEDLE_WIDTH;
use feeler_core::geometry::ray_crossings::{crossing, median, ray_count, ray_end, RAY_OFFSETS};
use feeler_core::mesh::topology::adjacency::Adjacency;
use feeler_core::tool::surface_links::SurfaceLinks;
use feeler_core::{Aabb, Collision, GoOn, Pace, PairKind, Point, Pose, Scene, Tool};

use super::tool_solid::ToolSolid;
use crate::context::QueryContext;
use crate::surface::Surface;

/// Bodies inside others; pairs of a tool part and a mock-up part, sorted, each once.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Containment {
    /// `[tool part, part]`: the mock-up's part holds one of the tool part's connected surfaces at least.
    pub containing: Vec<[u32; 2]>,
    /// `[tool part, part]`: the tool's part holds one of the mock-up part's connected surfaces at least.
    pub contained: Vec<[u32; 2]>,
    /// Parts that cannot be decided: open ones with a corner of the tool in their box, or with a corner in the box of
    /// an open tool.
    pub unknown: Vec<u32>,
}

/// See [`ContactSolver::containment`](crate::ContactSolver::containment). Where it is stopped, what was found until then.
pub(crate) fn containment(scene: &Scene, tool: &Tool, pose: &Pose, go_on: GoOn<'_>) -> Containment {
    let Ok(hit) = scene.stoppable(go_on).collide(tool, pose) else { return Containment::default() };
    let mut search = Search::new((scene, go_on), tool, pose, &hit, usize::MAX);
    search.run();
    search.look_for_unknown();
    let Search { mut found, .. } = search;
    for pairs in [&mut found.containing, &mut found.contained] {
        pairs.sort_unstable();
        pairs.dedup();
    }
    found
}

/// The parts that hold one of the tool's connected surfaces at least, or have a connected surface that the tool holds; sorted. The
/// tool meets nothing. Where it is stopped, those found until then.
pub(crate) fn parts_in_containment(scene: &Scene, tool: &Tool, pose: &Pose, go_on: GoOn<'_>) -> Vec<u32> {
    let mut search = Search::new((scene, go_on), tool, pose, &Collision::default(), usize::MAX);
    search.run();
    let Containment { containing, contained, .. } = search.found;
    let parts: BTreeSet<u32> = containing.into_iter().chain(contained).map(|[_, part]| part).collect();
    parts.into_iter().collect()
}

/// Whether there is any such part. Where it is stopped, whether one was found until then.
pub(crate) fn has_containment(scene: &Scene, tool: &Tool, pose: &Pose, go_on: GoOn<'_>) -> bool {
    let mut search = Search::new((scene, go_on), tool, pose, &Collision::default(), 1);
    search.run();
    search.is_enough()
}

/// For each end of a tool's links whether something in the scene may separate it from the one before.
fn is_apart(links: &SurfaceLinks, scene: &Scene, pose: &Pose) -> Vec<bool> {
    let mut is_apart = vec![true; links.ends.len()];
    // A needle from each surface to the next: where it meets nothing, both are on one side of everything.
    if let Some(needles) = &links.ways {
        needles.mesh().queried().for_each(|needle| is_apart[needle as usize + 1] = false);
        let met = scene.collide(needles, pose).pairs;
        met.iter().for_each(|[needle, _]| is_apart[*needle as usize + 1] = true);
    }
    is_apart
}

/// Triangles that meet, and how: by them no surface is inside another.
#[derive(Debug, Default)]
struct Meeting {
    /// Connected surface of the tool and part of the mock-up; whether they cross, or only touch.
    surfaces: BTreeMap<(u32, u32), bool>,
    tool_triangles: BTreeSet<u32>,
    /// By part: triangles of the mock-up, and whether they are crossed.
    mockup_triangles: BTreeMap<u32, BTreeMap<u32, bool>>,
}

impl Meeting {
    fn new(scene: &Scene, links: &SurfaceLinks, hit: &Collision) -> Meeting {
        let mut meeting = Meeting::default();
        for ([t, m], kind) in hit.pairs.iter().zip(&hit.kinds) {
            let (part, crosses) = (scene.mockup().part_of_face(*m), *kind == PairKind::Crossing);
            *meeting.surfaces.entry((links.surface_of[*t as usize], part)).or_default() |= crosses;
            *meeting.mockup_triangles.entry(part).or_default().entry(*m).or_default() |= crosses;
            meeting.tool_triangles.insert(*t);
        }
        meeting
    }

    /// Whether a surface of the tool meets anything.
    fn has(&self, surface: u32) -> bool {
        self.surfaces.range((surface, 0)..=(surface, u32::MAX)).next().is_some()
    }
}

/// One search.
struct Search<'a> {
    scene: &'a Scene,
    /// The same with no pairs ignored, where it ignores some.
    all: Option<Scene>,
    tool: &'a Tool,
    pose: &'a Pose,
    context: QueryContext<'a>,
    /// Parts whose boxes overlap the tool's.
    nearby: Vec<u32>,
    meeting: Meeting,
    /// Corners of the tool (world) that were tested, each for all of its connected surfaces that nothing separates.
    corners: Vec<Point>,
    enough: usize,
    found: Containment,
    pace: Pace<'a>,
}

/// Points tested between two questions whether the search goes on. A point takes some microseconds.
const POINTS_BETWEEN: u32 = 256;

impl<'a> Search<'a> {
    fn new(
        (scene, go_on): (&'a Scene, GoOn<'a>),
        tool: &'a Tool,
        pose: &'a Pose,
        hit: &Collision,
        enough: usize,
    ) -> Search<'a> {
        let around = tool_box(tool, pose);
        let tool_parts = 0..tool.parts() as u32;
        let is_asked = |part: u32| tool_parts.clone().any(|t| scene.index().selection().wants_parts(t, part));
        let overlapping = (0..).zip(scene.mockup().part_bounds()).filter(|(_, b)| b.is_overlapping(&around));
        let nearby: Vec<u32> = overlapping.map(|(part, _)| part).filter(|part| is_asked(*part)).collect();
        let meeting = if hit.pairs.is_empty() { Meeting::default() } else { Meeting::new(scene, tool.links(), hit) };
        let context = QueryContext::new(scene, tool, pose, None);
        let all = scene.index().selection().ignores_any().then(|| scene.asking_all_pairs());
        let (corners, found) = (Vec::new(), Containment::default());
        let pace = Pace::new(go_on, POINTS_BETWEEN);
        Search { scene, all, tool, pose, context, nearby, meeting, corners, enough, found, pace }
    }

    fn run(&mut self) {
        if !self.nearby.is_empty() {
            self.look_for_containing();
            self.look_for_contained();
        }
    }

    fn is_enough(&self) -> bool {
        self.found.containing.len() + self.found.contained.len() >= self.enough
    }

    /// The scene with no pairs ignored: rays and needles are of no part.
    fn all(&self) -> &Scene {
        self.all.as_ref().unwrap_or(self.scene)
    }

    /// Whether a pair of a tool's and a mock-up's part is wanted.
    fn wants(&self, tool_part: u32, part: u32) -> bool {
        self.scene.index().selection().wants_parts(tool_part, part)
    }

    /// Asks for a corner of each group of the tool's connected surfaces that nothing separates.
    fn look_for_containing(&mut self) {
        let links = self.tool.links();
        let is_apart = is_apart(links, self.all(), self.pose);
        let mut group = 0;
        let groups: Vec<usize> = is_apart
            .iter()
            .map(|apart| {
                group += usize::from(*apart);
                group
            })
            .collect();
        // Those that meet something are tested themselves, at a corner that does not.
        let mut members: Vec<(usize, u32)> = Vec::new();
        let mut alone: BTreeSet<u32> = BTreeSet::new();
        for (surface, end) in (0..).zip(&links.end_of) {
            if self.meeting.has(surface) {
                alone.insert(surface);
            } else {
                members.push((groups[*end as usize], surface));
            }
        }
        members.sort_unstable();
        let mut asked: Vec<(u32, Vec<u32>)> = members
            .chunk_by(|a, b| a.0 == b.0)
            .map(|same| (links.surfaces[same[0].1 as usize], same.iter().map(|(_, surface)| *surface).collect()))
            .collect();
        if !alone.is_empty() {
            for t in self.tool.mesh().queried() {
                let surface = links.surface_of[t as usize];
                if !self.meeting.tool_triangles.contains(&t) && alone.remove(&surface) {
                    asked.push((t, vec![surface]));
                }
            }
        }
        let more = self.corners_by_surface(&asked);
        for (t, surfaces) in asked {
            let p = self.context.tool_triangle(t)[0];
            self.corners.push(p);
            let holding = match more.get(&surfaces[0]) {
                Some(surface) => self.parts_around_most(&surface.corners),
                None => self.parts_around(&p),
            };
            for surface in surfaces {
                let tool_part = self.tool.part_of_face(links.surfaces[surface as usize]);
                let crosses = |part: &u32| self.meeting.surfaces.get(&(surface, *part)) == Some(&true);
                let holding = holding.iter().filter(|part| !crosses(part) && self.wants(tool_part, **part));
                let pairs: Vec<[u32; 2]> = holding.map(|part| [tool_part, *part]).collect();
                self.found.containing.extend(pairs);
            }
            if self.pace.step() || self.is_enough() {
                return;
            }
        }
    }

    /// Some corners of the first surface of each group, of triangles that meet nothing, if the mock-up's surfaces may have gaps: near
    /// these one corner decides nothing.
    fn corners_by_surface(&self, asked: &[(u32, Vec<u32>)]) -> BTreeMap<u32, ConnectedSurface> {
        let Adjacency { has_cracks, has_loose_seams, .. } = self.context.adjacency[Surface::Mockup];
        let mut found = BTreeMap::new();
        if *has_cracks || *has_loose_seams {
            found.extend(asked.iter().map(|(_, surfaces)| (surfaces[0], ConnectedSurface::default())));
            for t in self.tool.mesh().queried().filter(|t| !self.meeting.tool_triangles.contains(t)) {
                if let Some(surface) = found.get_mut(&self.tool.links().surface_of[t as usize]) {
                    self.context.tool_triangle(t).iter().for_each(|corner| surface.add(corner));
                }
            }
        }
        found
    }

    /// Those parts that hold most of some points.
    fn parts_around_most(&self, points: &[Point]) -> Vec<u32> {
        let mut votes: BTreeMap<u32, usize> = BTreeMap::new();
        points.iter().flat_map(|p| self.parts_around(p)).for_each(|part| *votes.entry(part).or_default() += 1);
        votes.into_iter().filter(|(_, votes)| 2 * votes > points.len()).map(|(part, _)| part).collect()
    }

    /// Those parts that hold a point.
    fn parts_around(&self, p: &Point) -> Vec<u32> {
        let adjacency = self.context.adjacency[Surface::Mockup];
        let bounds = self.scene.mockup().part_bounds();
        let in_a_shell = |part: &u32| {
            is_in(&bounds[*part as usize], p) && adjacency.shells_of(*part).iter().any(|shell| is_in(&shell.bounds, p))
        };
        let candidates: Vec<u32> = self.nearby.iter().copied().filter(in_a_shell).collect();
        if candidates.is_empty() {
            return candidates;
        }
        let mockup = self.scene.mockup();
        let hull = candidates.iter().fold(Aabb::EMPTY, |hull, part| hull.union(&mockup.part_bounds()[*part as usize]));
        let Adjacency { outward, has_cracks, has_loose_seams, .. } = adjacency;
        let windings = |offset: &[f64; 2]| {
            // A needle triangle, one edge of it the ray: it meets the triangles that the ray meets, and few more.
            let (q, wide) = (ray_end(p, &hull, offset), ray_end(p, &hull, &offset.map(|x| x + NEEDLE_WIDTH)));
            let needle = Tool::new(vec![*p, q, wide], vec![[0, 1, 2]]).ok()?;
            let mut windings = vec![0; candidates.len()];
            for [_, m] in self.all().collide(&needle, &Pose::IDENTITY).pairs {
                let side = i32::from(outward[m as usize]);
                if let (Ok(part), 1 | -1) = (candidates.binary_search(&mockup.part_of_face(m)), side) {
                    windings[part] += side * crossing(p, &q, &mockup.mesh().triangle(m))?;
                }
            }
            Some(windings)
        };
        let rays = ray_count(*has_cracks || *has_loose_seams);
        let decided: Vec<Vec<i32>> = RAY_OFFSETS.iter().filter_map(windings).take(rays).collect();
        let is_inside = |i: &usize| median(decided.iter().map(|windings| windings[*i]).collect()) != 0;
        (0..candidates.len()).filter(is_inside).map(|i| candidates[i]).collect()
    }

    /// Asks for a corner of each connected surface of the parts nearby.
    fn look_for_contained(&mut self) {
        let (around, of_tool) = (tool_box(self.tool, self.pose), self.tool.mesh().bounds());
        let mut solid = None;
        for part in self.nearby.clone() {
            let met = self.meeting.mockup_triangles.get(&part);
            let adjacency = self.context.adjacency[Surface::Mockup];
            // What sticks out of the tool's box is not inside.
            let shells = adjacency.shells_of(part).iter();
            let shells = shells.filter(|s| is_in(&around, &s.bounds.lower) && is_in(&around, &s.bounds.upper));
            let open = adjacency.open_surfaces_of(part).iter().map(|[_, m]| *m);
            for m in shells.map(|shell| shell.first).chain(open) {
                let asked = met.map_or(Some(m), |met| self.unmet_triangle(m, met));
                let Some(p) = asked.map(|m| self.context.corner(Surface::Mockup, m)) else { continue };
                if !is_in(&around, &p) {
                    continue;
                }
                let p = self.context.in_tool(&p);
                if !is_in(&of_tool, &p) {
                    continue;
                }
                let holding = solid.get_or_insert_with(|| ToolSolid::new(self.tool)).parts_around(&p);
                let pairs: Vec<[u32; 2]> =
                    holding.into_iter().filter(|t| self.wants(*t, part)).map(|t| [t, part]).collect();
                self.found.contained.extend(pairs);
                if self.pace.step() || self.is_enough() {
                    return;
                }
            }
        }
    }

    /// A triangle of a connected surface of the mock-up that meets nothing; `None` where the surface crosses the tool, or all of it
    /// meets it.
    fn unmet_triangle(&self, first: u32, met: &BTreeMap<u32, bool>) -> Option<u32> {
        let neighbours = &self.context.adjacency[Surface::Mockup].neighbours;
        let (mut seen, mut next, mut unmet) = (BTreeSet::from([first]), vec![first], None);
        while let Some(m) = next.pop() {
            match met.get(&m) {
                Some(true) => return None,
                Some(false) => {}
                None => unmet = unmet.or(Some(m)),
            }
            // Triangles without a neighbour across an edge have a number there that no triangle has.
            next.extend(
                neighbours[m as usize].iter().filter(|n| (**n as usize) < neighbours.len() && seen.insert(**n)),
            );
        }
        unmet
    }

    fn look_for_unknown(&mut self) {
        let [of_tool, adjacency] = self.context.adjacency;
        let around = tool_box(self.tool, self.pose);
        let is_tool_open = self.tool.links().surfaces.iter().any(|t| of_tool.outward[*t as usize] == 0);
        for &part in &self.nearby {
            let open = adjacency.open_surfaces_of(part);
            let bounds = self.scene.mockup().part_bounds()[part as usize];
            let may_hold = !open.is_empty() && self.corners.iter().any(|p| is_in(&bounds, p));
            let corner = |m: u32| self.context.corner(Surface::Mockup, m);
            let mut first =
                open.iter().map(|[_, m]| *m).chain(adjacency.shells_of(part).iter().map(|shell| shell.first));
            if may_hold || is_tool_open && first.any(|m| is_in(&around, &corner(m))) {
                self.found.unknown.push(part);
            }
        }
    }
}

/// The box of a tool at a pose.
fn tool_box(tool: &Tool, pose: &Pose) -> Aabb {
    box_at(pose, &tool.mesh().bounds(), tool.margin_at(pose))
}

/// Whether a point is in a closed box.
fn is_in(bounds: &Aabb, p: &Point) -> bool {
    bounds.is_overlapping(&Aabb { lower: *p, upper: *p })
}

/// The box of a tool at a pose, and of what rounding may add.
fn box_at(pose: &Pose, of_tool: &Aabb, slack: f64) -> Aabb {
    let mut around = Aabb::EMPTY;
    for corner in 0..8 {
        let p = std::array::from_fn(|a| if corner >> a & 1 == 0 { of_tool.lower[a] } else { of_tool.upper[a] });
        around.grow(&pose.apply(&p));
    }
    Aabb { lower: around.lower.map(|x| x - slack), upper: around.upper.map(|x| x + slack) }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;
    use std::sync::Arc;

    use proptest::prelude::*;

    use super::*;
    use crate::tests::{at, scene, tool, turned, Held};
    use feeler_core::geometry::vectors::{cross, dot, length, sub};
    use feeler_core::{IgnoredPairs, Mockup, Triangle};
    use feeler_shapes::{ball, box_mesh, joined, Arrays};

    /// The winding number of a closed surface around a point, by solid angles (A. van Oosterom, J. Strackee: The solid angle of a
    /// plane triangle, 1983).
    fn winding(triangles: &[Triangle], p: &Point) -> i64 {
        let angle = |t: &Triangle| {
            let [a, b, c] = t.map(|x| sub(&x, p));
            let (u, v, w) = (length(&a), length(&b), length(&c));
            2.0 * dot(&a, &cross(&b, &c)).atan2(u * v * w + dot(&a, &b) * w + dot(&b, &c) * u + dot(&c, &a) * v)
        };
        (triangles.iter().map(angle).sum::<f64>() / (4.0 * PI)).round() as i64
    }

    fn scene_of(parts: Vec<Arrays>) -> Held {
        let part_of_face = (0..).zip(&parts).flat_map(|(part, (_, faces))| vec![part; faces.len()]).collect();
        let count = parts.len();
        let (vertices, faces) = joined(parts);
        let mockup = Mockup::new(vertices, faces, part_of_face, count).unwrap();
        Held::of(mockup)
    }

    fn inverted((vertices, faces): Arrays) -> Arrays {
        (vertices, faces.into_iter().map(|[a, b, c]| [a, c, b]).collect())
    }

    proptest! {
        #[test]
        fn containment_is_what_winding_numbers_say(
            solids in prop::collection::vec((prop::array::uniform3(-3..4i32), 1..14i32, 0..3usize, 0..4usize), 1..6),
            of_tool in prop::collection::vec((prop::array::uniform3(-2..3i32), 1..9i32), 1..5),
            (angle, shift) in (prop_oneof![Just(0.0), 0.0..3.0], prop::array::uniform3(-5..6i32)),
        ) {
            // Parts on a lattice, and the tool off it: edges line up with corners of others, and surfaces do not meet. A part may
            // be turned inside out, have a hollow, or lack a triangle.
            let solid = |(at, size, cells, what): &(Point, f64, usize, usize)| {
                let hollow = || inverted(box_mesh(*at, [0.5 * size; 3], 1));
                let whole = box_mesh(*at, [*size; 3], cells + 1);
                match what {
                    0 => whole,
                    1 => joined([whole, hollow()]),
                    2 => inverted(whole),
                    _ => (whole.0, whole.1[1..].to_vec()),
                }
            };
            let parts = solids.iter().map(|(at, size, cells, what)| (at.map(f64::from), f64::from(*size), *cells, *what));
            let parts: Vec<_> = parts.collect();
            let scene = scene_of(parts.iter().map(solid).collect());
            // Each once: a solid twice in one place is open.
            let of_tool: BTreeSet<_> = of_tool.into_iter().collect();
            let boxes = of_tool.iter().map(|(at, size)| box_mesh(at.map(f64::from), [0.3 * f64::from(*size); 3], 1));
            let tool = tool(joined(boxes));
            let pose = turned(angle, shift.map(|x| 0.5 * f64::from(x)));
            if scene.is_colliding(&tool, &pose) {
                return Ok(());
            }
            let mesh = scene.mockup().mesh();
            let own = |part: u32| {
                let is_own = |m: &u32| scene.mockup().part_of_face(*m) == part;
                mesh.queried().filter(is_own).map(|m| mesh.triangle(m)).collect::<Vec<_>>()
            };
            let placed: Vec<Triangle> =
                tool.mesh().queried().map(|t| pose.apply_triangle(&tool.mesh().triangle(t))).collect();
            let expected: Vec<u32> = (0u32..)
                .zip(&parts)
                .filter(|(part, (.., what))| {
                    let own = own(*part);
                    *what < 3 && placed.iter().any(|t| winding(&own, &t[0]) != 0)
                        || own.iter().any(|t| winding(&placed, &t[0]) != 0)
                })
                .map(|(part, _)| part)
                .collect();
            prop_assert_eq!(parts_in_containment(&scene, &tool, &pose, GoOn::default()), expected);
        }
    }

    #[test]
    fn an_undecided_ray_is_followed_by_another() {
        // A fan of triangles around the point that the first ray goes through, and one around that of the second.
        let (p, hull) = ([0.0; 3], Aabb { lower: [-1.0; 3], upper: [1.0; 3] });
        let mut fans = box_mesh([0.0; 3], [2.0; 3], 1);
        for offset in &RAY_OFFSETS[..2] {
            let q = ray_end(&p, &hull, offset);
            let (axis, top) = (0, 0.5 * q[0]);
            let spot = scaled_to(&q, axis, top);
            let corner = |k: usize| [top, spot[1] + [-0.1, 0.1, 0.0][k], spot[2] + [-0.1, -0.1, 0.1][k]];
            let from = fans.0.len() as u32;
            fans.0.extend([spot, corner(0), corner(1), corner(2)]);
            fans.1.extend([[0, 1, 2], [0, 2, 3], [0, 3, 1]].map(|f: [u32; 3]| f.map(|v| v + from)));
            let fan: Vec<Triangle> = fans.1[fans.1.len() - 3..].iter().map(|f| f.map(|v| fans.0[v as usize])).collect();
            assert!(fan.iter().any(|t| crossing(&p, &q, t).is_none()), "{offset:?}");
        }
        // Fans are open and contain nothing; the box does.
        let inner = tool(box_mesh([0.0; 3], [1e-3; 3], 1));
        let place = sub(&p, &inner.mesh().triangle(0)[0]);
        let pose = at(place[0], place[1], place[2]);
        assert_eq!(parts_in_containment(&scene(fans), &inner, &pose, GoOn::default()), [0]);
    }

    /// The point of the ray from the origin to `q` at a coordinate.
    fn scaled_to(q: &Point, axis: usize, at: f64) -> Point {
        q.map(|x| x * (at / q[axis]))
    }

    #[test]
    fn loose_triangles_that_nothing_separates_are_asked_once() {
        // Two solids, and a row of loose triangles beside the first: one of them in a solid, or none.
        let held = scene_of(vec![box_mesh([0.0; 3], [0.4, 0.4, 0.2], 3), box_mesh([0.9, 0.0, 0.0], [0.1; 3], 1)]);
        let loose = |xs: &[f64]| {
            let corners = |x: &f64| [[*x, 0.013, 0.007], [x + 1e-3, 0.013, 0.007], [*x, 0.014, 0.008]];
            (
                xs.iter().flat_map(corners).collect(),
                (0..xs.len() as u32).map(|i| [0, 1, 2].map(|k| 3 * i + k)).collect(),
            )
        };
        let outside: Vec<f64> = (0..200).map(|i| 0.21 + 0.003 * f64::from(i)).collect();
        let of = |xs: Vec<f64>| tool(loose(&xs));
        let apart = |tool: &Tool| is_apart(tool.links(), &held, &Pose::IDENTITY).iter().filter(|apart| **apart).count();
        let all_out = of(outside.clone());
        assert_eq!(
            (parts_in_containment(&held, &all_out, &Pose::IDENTITY, GoOn::default()), apart(&all_out)),
            (vec![], 1)
        );
        for (at, expected) in [(0.1, vec![0]), (-0.3, vec![]), (0.92, vec![1])] {
            let one_in = of([outside.clone(), vec![at]].concat());
            assert_eq!(parts_in_containment(&held, &one_in, &Pose::IDENTITY, GoOn::default()), expected, "{at}");
            assert_eq!(has_containment(&held, &one_in, &Pose::IDENTITY, GoOn::default()), !expected.is_empty(), "{at}");
            // In any order: surfaces that a side of a solid separates from the others are tested themselves.
            assert!((2..6).contains(&apart(&one_in)), "{at} {}", apart(&one_in));
        }
        let same = of(vec![0.1; 50]);
        assert_eq!((parts_in_containment(&held, &same, &Pose::IDENTITY, GoOn::default()), apart(&same)), (vec![0], 1));
    }

    #[test]
    fn a_nearer_part_does_not_matter() {
        // A block in a plate, beside a bar through the plate that is nearer than any side of the plate.
        let plate = box_mesh([0.0; 3], [0.4, 0.4, 0.2], 3);
        let bar = box_mesh([0.0012, 0.0, 0.0], [0.001, 0.002, 0.3], 1);
        let held = scene_of(vec![bar, plate]);
        let block = tool(box_mesh([0.0; 3], [0.001; 3], 1));
        assert_eq!(held.distance(&block, &Pose::IDENTITY, 1.0).unwrap().unwrap().part, 0);
        assert_eq!(parts_in_containment(&held, &block, &Pose::IDENTITY, GoOn::default()), [1]);
        // A ball of many triangles around it, far from the origin.
        let around =
            |x: f64| joined([ball(1.0, 40)].map(|(v, f)| (v.into_iter().map(|p| [p[0] + x, p[1], p[2]]).collect(), f)));
        for x in [0.0, 1e6, 1e9] {
            let held = scene(around(x));
            assert_eq!(parts_in_containment(&held, &block, &at(x, 0.3, 0.2), GoOn::default()), [0], "{x}");
            assert!(parts_in_containment(&held, &block, &at(x + 0.8, 0.7, 0.0), GoOn::default()).is_empty(), "{x}");
        }
    }

    fn tool_of(parts: Vec<Arrays>) -> Tool {
        let part_of_face = (0..).zip(&parts).flat_map(|(part, (_, faces))| vec![part; faces.len()]).collect();
        let count = parts.len();
        let (vertices, faces) = joined(parts);
        Tool::of_parts(vertices, faces, part_of_face, count).unwrap()
    }

    fn cube(x: f64, size: f64) -> Arrays {
        box_mesh([x, 0.0, 0.0], [size; 3], 2)
    }

    #[test]
    fn shells_and_parts_are_told_one_by_one() {
        // A block with a hollow, a mirrored block in the same part, an open block, and one that the tool will hold.
        let mirrored = joined([cube(0.0, 4.0), inverted(cube(0.0, 2.0)), inverted(cube(10.0, 4.0))]);
        let open = (cube(20.0, 4.0).0, cube(20.0, 4.0).1[1..].to_vec());
        let held = scene_of(vec![mirrored, open, cube(30.0, 1.0)]);
        let at = |xs: [f64; 3]| tool_of(vec![cube(xs[0], 0.1), cube(xs[1], 0.1), cube(xs[2], 3.0)]);
        let ask = |xs: [f64; 3]| held.solver().containment(&at(xs), &Pose::IDENTITY);
        let told = ask([1.5, 10.0, 30.0]);
        assert_eq!((told.containing, told.contained, told.unknown), (vec![[0, 0], [1, 0]], vec![[2, 2]], vec![]));
        // In the hollow nothing is inside; of the open block nobody knows.
        let told = ask([0.3, 20.3, 40.0]);
        assert_eq!((told.containing, told.contained, told.unknown), (vec![], vec![], vec![1]));
        assert!(held.solver().is_free(&at([0.3, 20.3, 40.0]), &Pose::IDENTITY));
        assert!(!held.solver().is_free(&at([0.3, 10.3, 40.0]), &Pose::IDENTITY));
        // What is ignored, or out, is not told.
        let without = held.without(&[2]).unwrap().ignoring(Arc::new(IgnoredPairs::new(3, 3, [[0, 0]])));
        let told = containment(&without, &at([1.5, 10.0, 30.0]), &Pose::IDENTITY, GoOn::default());
        assert_eq!((told.containing, told.contained), (vec![[1, 0]], vec![]));
    }

    #[test]
    fn what_crosses_is_not_inside_and_what_touches_may_be() {
        let held = scene_of(vec![cube(0.0, 4.0), cube(0.0, 9.0), cube(20.0, 1.0)]);
        let ask = |parts: Vec<Arrays>| held.solver().containment(&tool_of(parts), &Pose::IDENTITY);
        // Through a side of the inner block, inside the outer one. A second part is free of both.
        let told = ask(vec![cube(2.0, 1.0), cube(3.2, 0.1)]);
        assert_eq!((told.containing, told.contained), (vec![[0, 1], [1, 1]], vec![]));
        // Flush with a side, from within: nothing crosses.
        let told = ask(vec![cube(1.5, 1.0)]);
        assert_eq!(told.containing, [[0, 0], [0, 1]]);
        // Flush from without.
        assert_eq!(ask(vec![cube(2.5, 1.0)]).containing, [[0, 1]]);
        // The same the other way round: a part held by the tool, crossed by it, flush within it.
        for (x, size, contained) in [(20.0, 3.0, true), (21.0, 1.5, false), (20.5, 2.0, true), (21.0, 1.0, false)] {
            let told = ask(vec![cube(x, size)]);
            assert_eq!(
                (told.containing, told.contained.as_slice()),
                (vec![], &[[0, 2]][..usize::from(contained)]),
                "{x}"
            );
        }
    }

    #[test]
    fn surfaces_with_one_first_corner_are_all_told() {
        let held = scene_of(vec![cube(0.0, 4.0)]);
        let twice = tool_of(vec![cube(0.0, 0.5), cube(0.0, 0.5)]);
        assert_eq!(held.solver().containment(&twice, &Pose::IDENTITY).containing, [[0, 0], [1, 0]]);
    }
}
