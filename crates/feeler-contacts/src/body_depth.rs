//! How deep two bodies of a set are in each other.

use std::sync::Arc;

use feeler_core::geometry::vectors::{add, dot, length, scaled, sub};
use feeler_core::{Aabb, Bodies, GoOn, Point, Pose, Result, Scene, Shape, Tool, ToolAndMockup, Who};

use crate::convex_depth::convex_depth;
use crate::escape::escape_probe::{cube_axes, is_free_and_outside, probe_axes};
use crate::escape::min_norm::min_norm;
use crate::escape::penetration::{keep_tightest, PenetrationKind};
use crate::solver::ContactSolver;

/// By how much farther than the border convex bodies are moved: that they touch no more, a share of the depth and of coordinates.
const BEYOND: [f64; 2] = [1e-6, 64.0 * f64::EPSILON];

/// Rounds in which bodies are moved off what they are flush with.
const ROUNDS: usize = 8;
/// Which surfaces count there: those nearer than `NEAR`. And how far bodies are moved off them at most. Both in units of the distance
/// that parts two bodies for sure.
const NEAR: f64 = 4.0;
const FARTHER: f64 = 1e4;

/// The shortest translation found that parts two bodies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BodyDepth {
    /// Metres, world: it parts the second body from the first.
    pub translation: Point,
    /// Its length, metres; the bodies are at most so deep in each other.
    pub depth: f64,
    /// Whether none is shorter: of two solid bodies, to a billionth of their size and a millionth of the depth.
    pub is_least: bool,
}

/// The depth of two bodies that meet: of two solid ones the least, of others the shorter one of [`ContactSolver::penetration`] and of
/// the way along an axis of the world that parts their boxes; 0 for bodies that are apart. Errors: no such body, and the request to
/// stop.
pub fn body_depth(bodies: &Bodies, who: Who<'_>, pair: [u32; 2], go_on: GoOn<'_>) -> Result<BodyDepth> {
    let [a, b] = pair;
    if a > b && !matches!(who, Who::Others(_)) {
        // In one order, because the depth found depends on it.
        let found = body_depth(bodies, who, [b, a], go_on)?;
        return Ok(BodyDepth { translation: scaled(&found.translation, -1.0), ..found });
    }
    let [first, second] = bodies.pair(who, pair)?;
    if first.0.is_solid() && second.0.is_solid() {
        return Ok(of_solids(first, second));
    }
    let ToolAndMockup { scene, tool, pose, frame, is_turned } = bodies.as_tool_and_mockup(who, pair)?;
    let (along, apart) = along_an_axis(first, second);
    let two = Two { scene: &scene, tool: &tool, pose: &pose, apart, go_on };
    if two.are_apart(&[0.0; 3], apart)? {
        return Ok(BodyDepth { translation: [0.0; 3], depth: 0.0, is_least: true });
    }
    match two.way_apart(along.depth)? {
        Some(way) if length(&way) < along.depth => {
            let sense = if is_turned { 1.0 } else { -1.0 };
            let translation = std::array::from_fn(|i| sense * dot(&frame.rotation()[i], &way));
            Ok(BodyDepth { translation, depth: length(&way), is_least: false })
        }
        _ => Ok(along),
    }
}

/// Two bodies as tool and mock-up.
struct Two<'a> {
    scene: &'a Arc<Scene>,
    tool: &'a Tool,
    pose: &'a Pose,
    /// How far they have to be from each other to be parted for sure, metres: the rounding of the world's coordinates.
    apart: f64,
    go_on: GoOn<'a>,
}

impl Two<'_> {
    /// A translation of the tool that parts it, no longer than `most`, metres.
    fn way_apart(&self, most: f64) -> Result<Option<Point>> {
        let solver = ContactSolver::new(Arc::clone(self.scene));
        let found = solver.stoppable(self.go_on).penetration(self.tool, self.pose, 0.0, None)?;
        if found.kind != PenetrationKind::Estimate {
            if let Some(way) = self.parted_from(&solver, found.translation)? {
                return Ok(Some(way));
            }
        }
        let mut axes: Vec<Point> = found.contacts.planes.iter().map(|p| p.normal).collect();
        axes.extend(cube_axes(self.pose));
        match probe_axes((self.scene, self.go_on), self.tool, self.pose, &axes, most) {
            Some(start) => self.parted_from(&solver, start),
            None => Ok(None),
        }
    }

    /// A translation near `start` after which the two are apart for sure. After `start` they may still touch by rounding, on faces that
    /// are flush: the translation found leaves these, too. `None` if there is none.
    fn parted_from(&self, solver: &ContactSolver, start: Point) -> Result<Option<Point>> {
        for is_flipped in [false, true] {
            let mut planes: Vec<(Point, f64)> = Vec::new();
            let mut more = [0.0; 3];
            for _ in 0..ROUNDS {
                let way = add(&start, &more);
                if self.are_apart(&way, 0.5 * self.apart)? {
                    return Ok(Some(way));
                }
                let there = self.pose.translated(&way)?;
                let contacts = solver.stoppable(self.go_on).contacts(self.tool, &there, NEAR * self.apart, None)?;
                for plane in &contacts.planes {
                    // Of an open surface the other side may be the right one.
                    let normal = scaled(&plane.normal, if is_flipped && plane.assumed { -1.0 } else { 1.0 });
                    planes.push((normal, dot(&normal, &more) + self.apart - plane.gap.min(self.apart)));
                }
                keep_tightest(&mut planes);
                match min_norm(&planes) {
                    Some((found, _)) if length(&found) <= FARTHER * self.apart && found != more => more = found,
                    _ => break,
                }
            }
            // Edges that lie on each other have planes that nothing satisfies, beside the one of the faces.
            for (normal, _) in &planes {
                let way = add(&start, &scaled(normal, 2.0 * self.apart));
                if self.are_apart(&way, 0.5 * self.apart)? {
                    return Ok(Some(way));
                }
            }
        }
        Ok(None)
    }

    /// Whether the moved tool meets nothing and is farther than `by` from all, metres.
    fn are_apart(&self, way: &Point, by: f64) -> Result<bool> {
        let moved = self.pose.translated(way)?;
        Ok(is_free_and_outside((self.scene, self.go_on), self.tool, &moved)
            && self.scene.stoppable(self.go_on).nearest(self.tool, &moved, 1, by)?.is_empty())
    }
}

/// The shortest way along an axis of the world that parts the box of the second body from that of the first; and how much farther
/// than the border that is for the rounding of coordinates, metres.
fn along_an_axis(first: (&Arc<Shape>, &Pose), second: (&Arc<Shape>, &Pose)) -> (BodyDepth, f64) {
    let boxed = |body| {
        let mut around = Aabb::EMPTY;
        placed(body).iter().for_each(|p| around.grow(p));
        around
    };
    let (a, b) = (boxed(first), boxed(second));
    let beyond = BEYOND[1] * a.largest_coordinate().max(b.largest_coordinate());
    let mut best = BodyDepth { translation: [0.0; 3], depth: f64::INFINITY, is_least: false };
    for (axis, sense, by) in
        (0..3).flat_map(|i| [(i, 1.0, a.upper[i] - b.lower[i]), (i, -1.0, b.upper[i] - a.lower[i])])
    {
        let depth = by.max(0.0) * (1.0 + BEYOND[0]) + beyond;
        if depth < best.depth {
            best.depth = depth;
            best.translation = std::array::from_fn(|i| if i == axis { sense * depth } else { 0.0 });
        }
    }
    (best, beyond)
}

/// The corners of the queried triangles of a body, in the world.
fn placed((shape, pose): (&Arc<Shape>, &Pose)) -> Vec<Point> {
    let mesh = shape.mesh();
    let mut used: Vec<u32> = mesh.queried().flat_map(|triangle| mesh.faces()[triangle as usize]).collect();
    used.sort_unstable();
    used.dedup();
    used.iter().map(|v| pose.apply(&mesh.vertices()[*v as usize])).collect()
}

/// The two bodies that meet, one of them solid, and are deepest in each other; of several the first. Errors as [`body_depth`].
pub fn deepest(bodies: &Bodies, who: Who<'_>, go_on: GoOn<'_>) -> Result<Option<([u32; 2], BodyDepth)>> {
    let mut pairs = Vec::new();
    for pair in bodies.meeting_while(who, go_on)? {
        let [first, second] = bodies.pair(who, pair)?;
        if first.0.is_solid() || second.0.is_solid() {
            pairs.push((bodies.parted_by(who, pair)?, pair));
        }
    }
    // Those that may be deepest first: most others need no look then.
    pairs.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let mut best: Option<([u32; 2], BodyDepth)> = None;
    for (most, pair) in pairs {
        if best.is_some_and(|(_, depth)| most <= depth.depth) {
            break;
        }
        go_on.check()?;
        let depth = body_depth(bodies, who, pair, go_on)?;
        let is_deeper = |(old, of_old): &([u32; 2], BodyDepth)| {
            depth.depth > of_old.depth || (depth.depth == of_old.depth && pair < *old)
        };
        if best.as_ref().is_none_or(is_deeper) {
            best = Some((pair, depth));
        }
    }
    Ok(best)
}

fn of_solids(first: (&Arc<Shape>, &Pose), second: (&Arc<Shape>, &Pose)) -> BodyDepth {
    let (mut a, mut b) = (placed(first), placed(second));
    let mut around = Aabb::EMPTY;
    a.iter().chain(&b).for_each(|p| around.grow(p));
    // From a corner of one: far from the origin less is lost.
    let origin = a[0];
    a.iter_mut().chain(&mut b).for_each(|p| *p = sub(p, &origin));
    let found = convex_depth(&a, &b, f64::EPSILON * around.largest_coordinate());
    let beyond = BEYOND[1] * around.largest_coordinate();
    // Bodies nearer to each other than the rounding of coordinates may meet.
    if found.depth < -beyond {
        return BodyDepth { translation: [0.0; 3], depth: 0.0, is_least: true };
    }
    let by = found.depth.max(0.0) * (1.0 + BEYOND[0]) + beyond;
    let translation = found.direction.map(|x| x * by);
    BodyDepth { translation, depth: length(&translation), is_least: found.is_least }
}
