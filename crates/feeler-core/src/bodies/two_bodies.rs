//! Two bodies: which triangles meet, and which are closest. The smaller one goes to the larger one's index at a
//! relative pose, which is rounded; triangles that this may bring together are tested in the world, where both are
//! placed.

use std::sync::Arc;

use super::body::Body;
use super::closest::Nearest;
use super::relative::relative;
use super::shape::Shape;
use super::solid::is_inside;
use crate::collide::query::{meet, BothPlaced, CollideScratch};
use crate::constants::{RELATIVE_ROUNDOFFS, UNIT_ROUNDOFF};
use crate::error::{Error, Result};
use crate::geometry::distance_triangle_triangle::{closest_triangle_triangle, Closest};
use crate::geometry::intersect_triangle_triangle::{intersect_triangle_triangle, PairKind};
use crate::geometry::pose::Pose;
use crate::index::blocks::NearScratch;
use crate::index::plain_search::SearchScratch;
use crate::index::sink::NearTool;
use crate::progress::GoOn;
use crate::scene::Scene;
use crate::tool::moving_tool::Tool;

/// Working memory of a query of two bodies.
#[derive(Debug, Default)]
pub(super) struct TwoScratch {
    collide: CollideScratch,
    search: SearchScratch,
    near: NearScratch,
}

/// Triangles of two bodies, in the order in which the bodies were given.
#[derive(Debug, Clone, Copy)]
pub(super) struct Found {
    pub triangles: [u32; 2],
    /// `None` for triangles that do not meet.
    pub kind: Option<PairKind>,
    pub closest: Closest,
}

/// Two bodies, the one with fewer triangles as the tool.
struct Two<'a> {
    moving: &'a Body,
    standing: &'a Body,
    is_turned: bool,
}

impl<'a> Two<'a> {
    fn new(a: &'a Body, b: &'a Body) -> Two<'a> {
        let count = |body: &Body| body.shape().mesh().queried_count();
        let is_turned = count(a) > count(b);
        let [moving, standing] = if is_turned { [b, a] } else { [a, b] };
        Two { moving, standing, is_turned }
    }

    /// As the caller has them.
    fn found(&self, triangles: [u32; 2], kind: Option<PairKind>, closest: Closest) -> Found {
        let [t, m] = triangles;
        if self.is_turned {
            let closest = Closest { on_p: closest.on_q, on_q: closest.on_p, ..closest };
            return Found { triangles: [m, t], kind, closest };
        }
        Found { triangles, kind, closest }
    }

    /// The pose of the moving one in the frame of the other, and how far rounding may take triangles from where they
    /// are to each other.
    fn relative(&self) -> (Pose, f64) {
        let largest =
            |body: &Body| 3.1 * body.shape().mesh().bounds().largest_coordinate() + body.pose().largest_translation();
        let spread = RELATIVE_ROUNDOFFS * UNIT_ROUNDOFF * (largest(self.moving) + largest(self.standing));
        (relative(self.standing.pose(), self.moving.pose()), spread)
    }

    /// Both placed.
    fn with<R>(&self, query: impl FnOnce(&BothPlaced<'_>) -> Result<R>) -> Result<R> {
        let (relative, spread) = self.relative();
        query(&BothPlaced {
            index: self.standing.shape().scene()?.index(),
            corners: self.standing.corners(),
            tool: self.moving.shape().tool()?,
            pose: self.moving.pose(),
            relative: &relative,
            spread,
        })
    }
}

/// Two bodies as the queries of one tool in one scene see them, nearly: the pose is rounded.
#[doc(hidden)]
#[derive(Debug, Clone)]
pub struct ToolAndMockup {
    /// Of the body that stands.
    pub scene: Arc<Scene>,
    /// Of the other, with fewer triangles.
    pub tool: Arc<Tool>,
    /// `standing_from_tool`.
    pub pose: Pose,
    /// `world_from_standing`.
    pub frame: Pose,
    /// Whether the tool is the second body.
    pub is_turned: bool,
}

/// See [`Bodies::as_tool_and_mockup`](crate::Bodies::as_tool_and_mockup).
pub(super) fn tool_and_mockup(a: &Body, b: &Body) -> Result<ToolAndMockup> {
    let two = Two::new(a, b);
    Ok(ToolAndMockup {
        scene: Arc::clone(two.standing.shape().scene()?),
        tool: Arc::clone(two.moving.shape().tool()?),
        pose: two.relative().0,
        frame: *two.standing.pose(),
        is_turned: two.is_turned,
    })
}

/// Adds what a pair needs of its shapes and is not made yet: the tree of one that moves, or the index of one that
/// stands.
pub(super) fn needs<'a>(a: &'a Body, b: &'a Body, needed: &mut Vec<(&'a Arc<Shape>, bool)>) {
    let Two { moving, standing, .. } = Two::new(a, b);
    if !moving.shape().has_tool() {
        needed.push((moving.shape(), true));
    }
    if !standing.shape().has_scene() {
        needed.push((standing.shape(), false));
    }
}

/// Whether two bodies meet: their surfaces, or one is solid and the other in it.
pub(super) fn is_meeting(a: &Body, b: &Body, go_on: GoOn<'_>, scratch: &mut TwoScratch) -> Result<bool> {
    let collide = &mut scratch.collide;
    let meets = Two::new(a, b).with(|both| {
        meet(both, true, go_on, collide)?;
        Ok(collide.sorted().len() > 0)
    })?;
    Ok(meets || is_inside(a, b))
}

/// Every pair of triangles that meets, sorted by the triangles, with a point that both have. Where only one body's
/// inside meets the other, the closest pair. Errors: more of them than `most`.
pub(super) fn meeting(
    a: &Body,
    b: &Body,
    most: usize,
    go_on: GoOn<'_>,
    scratch: &mut TwoScratch,
) -> Result<Vec<Found>> {
    let two = Two::new(a, b);
    let collide = &mut scratch.collide;
    let mut found = two.with(|both| {
        meet(both, false, go_on, collide)?;
        let hits = collide.sorted();
        if hits.len() > most {
            return Err(too_many(hits.len(), most));
        }
        let placed = hits.map(|hit| {
            let [t, m] = hit.pair();
            let p = both.pose.apply_triangle(&both.tool.mesh().triangle(t));
            two.found([t, m], Some(hit.kind()), closest_triangle_triangle(&p, &both.corners.triangle(m)))
        });
        Ok(placed.collect::<Vec<_>>())
    })?;
    if two.is_turned {
        found.sort_unstable_by_key(|found| found.triangles);
    }
    if found.is_empty() && is_inside(a, b) {
        found.extend(closest(a, b, f64::INFINITY, go_on, scratch)?);
    }
    Ok(found)
}

/// The error of too many pairs of triangles.
pub(super) fn too_many(count: usize, most: usize) -> Error {
    Error::Memory {
        what: "the pairs of triangles that meet",
        needed: (count * size_of::<Found>()) as u64,
        allowed: (most * size_of::<Found>()) as u64,
        advice: "ask only which bodies meet, or allow more memory",
    }
}

/// The closest pair of triangles of two bodies' surfaces that are at most `within` (metres) apart; of several, the
/// first by the triangles.
pub(super) fn closest(
    a: &Body,
    b: &Body,
    within: f64,
    go_on: GoOn<'_>,
    scratch: &mut TwoScratch,
) -> Result<Option<Found>> {
    let two = Two::new(a, b);
    let TwoScratch { search, near, .. } = scratch;
    two.with(|both| {
        let (index, scene) = (both.index, two.standing.shape().scene()?);
        let selection = index.selection();
        let tool = NearTool {
            mockup: scene.mockup(),
            tool: both.tool,
            pose: both.relative,
            lanes: index.lanes(),
            selection,
            dividers: &[],
        };
        let mut nearest = Nearest::new(both, two.standing.pose(), two.is_turned, within, go_on);
        index.store().search(&tool, search, near, &mut nearest);
        let best = nearest.finish()?;
        Ok(best.map(|([t, m], closest)| {
            let kind = (closest.distance == 0.0).then(|| kind_of(both, t, m)).flatten();
            two.found([t, m], kind, closest)
        }))
    })
}

fn kind_of(both: &BothPlaced<'_>, t: u32, m: u32) -> Option<PairKind> {
    let p = both.pose.apply_triangle(&both.tool.mesh().triangle(t));
    intersect_triangle_triangle(&p, &both.corners.triangle(m))
}
