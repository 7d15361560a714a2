//! The contact query: first collisions, region by region and body by body, then near surfaces.
//!
//! Triangles collide along an intersection contour, which together with the area inside it makes a contact region
//! ([`crate::contour`]). Each of its two surfaces becomes patches and convex bodies ([`crate::patch`]), and two bodies
//! have one least depth ([`crate::depth`]). Near surfaces without a collision get planes by distance
//! ([`crate::proximity`]). `docs/contacts.md` explains the numbers and their limits.

use feeler_core::distance::query::{near_candidates, DistanceScratch};
use feeler_core::distance::wanted::Candidate;
use feeler_core::geometry::vectors::{add, length, scaled, sub};
use feeler_core::index::sink::Divider;
use feeler_core::scratch_pool::ScratchPool;
use feeler_core::{Aabb, Collision, Error, Filters, GoOn, Pace, Pose, Result, Scene, Tool};
use feeler_lanes::Sorter;

use crate::constants::{
    FEW_DEEP, LEAST_MARGIN_OVER_NEAREST, MANY_DEEP, MANY_NEAR, MANY_PAIRS, MOST_MANIFOLDS, MOST_MARGIN_HALVINGS,
    MOST_PAIRS_KEPT,
};
use crate::contact_plane::{ContactPlane, Contacts};
use crate::containers::counting_sort::PartSort;
use crate::context::QueryContext;
use crate::contour::contact_region::ContactRegions;
use crate::contour::find::{find, RegionScratch};
use crate::copies::without_copies;
use crate::depth::face_axes::FaceDepth;
use crate::depth::least_depth::{Depth, DepthScratch};
use crate::depth::piercing::Piercing;
use crate::depth::region_bodies::RegionBodies;
use crate::depth::region_depths::{find_planes, AxisFilter};
use crate::footing::manifold::{manifold, Manifolds};
use crate::identity::set_ids;
use crate::patch::body::Bodies;
use crate::patch::convex_bodies::ConvexBodies;
use crate::patch::patches::Patches;
use crate::proximity::separating_planes::{divider, NearScratch, PlaneSearch};
use crate::surface::Surface;

/// Asks a scene for contacts, with working memory of its own.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ContactQuery<'a> {
    pub scene: &'a Scene,
    pub pool: &'a ScratchPool<ContactScratch>,
    pub go_on: GoOn<'a>,
}

/// Contact regions between two questions whether the query goes on.
const REGIONS_BETWEEN: u32 = 16;

/// The contacts of the tool with one part.
#[derive(Debug, Default)]
struct PartContacts<'a> {
    part: u32,
    /// The pairs of triangles that meet.
    pairs: &'a [[u32; 2]],
    /// Triangles of tool and mock-up that are wholly inside the other; sorted before use.
    inside: [Vec<u32>; 2],
    planes: Vec<ContactPlane>,
}

impl PartContacts<'_> {
    /// Adds the triangles inside in a region.
    fn add_inside(&mut self, regions: &ContactRegions, region: usize) {
        Surface::BOTH
            .iter()
            .for_each(|&surface| self.inside[surface].extend(regions.inside_of(region, surface).iter().map(|t| t[0])));
    }
}

/// How many planes are deep.
fn count_deep(parts: &[PartContacts<'_>]) -> usize {
    parts.iter().flat_map(|part| &part.planes).filter(|p| p.gap < 0.0).count()
}

/// Working memory of one query.
#[derive(Debug, Default)]
pub(crate) struct ContactScratch {
    collision: Collision,
    distance: DistanceScratch,
    by_part: PartSort,
    candidates: Vec<Candidate>,
    meeting: Vec<[u32; 2]>,
    near: NearScratch,
    regions: RegionScratch,
    bodies: BodyScratch,
    planes: Vec<ContactPlane>,
    sorter: Sorter,
}

/// Working memory of one region.
#[derive(Debug, Default)]
struct BodyScratch {
    patches: Patches,
    convex_bodies: ConvexBodies,
    bodies: [Bodies; 2],
    depth: DepthScratch,
    faces: Vec<FaceDepth>,
    found: Vec<Depth>,
    /// The faces that meet along the segments of two bodies.
    meeting: Vec<[u32; 2]>,
}

impl ContactQuery<'_> {
    /// See [`ContactSolver::contacts`](crate::ContactSolver::contacts).
    pub fn contacts(&self, tool: &Tool, pose: &Pose, margin: f64, reference: Option<&Pose>) -> Result<Contacts> {
        let share = |deep: usize| MANY_DEEP.saturating_sub(deep) as f64 / (MANY_DEEP - FEW_DEEP) as f64;
        let near_margin = |deep: usize| (deep < MANY_DEEP).then(|| margin * share(deep).min(1.0));
        self.contacts_within(near_margin, tool, pose, margin, reference)
    }

    /// The same, with the margin for near surfaces by the number of deep planes; `None`: without near surfaces.
    pub fn contacts_within(
        &self,
        near_margin: impl Fn(usize) -> Option<f64>,
        tool: &Tool,
        pose: &Pose,
        margin: f64,
        reference: Option<&Pose>,
    ) -> Result<Contacts> {
        self.contacts_showing(near_margin, tool, pose, margin, reference, &mut |_| {})
    }

    /// The same, with the colliding pairs of triangles.
    pub fn contacts_showing(
        &self,
        near_margin: impl Fn(usize) -> Option<f64>,
        tool: &Tool,
        pose: &Pose,
        margin: f64,
        reference: Option<&Pose>,
        show: &mut dyn FnMut(&[[u32; 2]]),
    ) -> Result<Contacts> {
        if !(margin.is_finite() && margin >= 0.0) {
            return Err(Error::Margin { value: margin });
        }
        let mut scratch = self.pool.take();
        let ContactScratch {
            collision,
            by_part,
            candidates,
            meeting,
            near: near_scratch,
            regions: region_scratch,
            bodies: body_scratch,
            distance,
            ..
        } = &mut *scratch;
        let (scene, mockup) = (self.scene, self.scene.mockup());
        scene.stoppable(self.go_on).collide_into(tool, pose, Filters::default(), collision)?;
        show(&collision.pairs);
        let context = QueryContext::new(scene, tool, pose, reference).asking(self.go_on);
        if collision.pairs.len() > MANY_PAIRS {
            if let Some(pairs) = without_copies(&context, &collision.pairs) {
                collision.pairs = pairs;
            }
        }
        let hits = &collision.pairs;
        // Parts and neighbours of the triangles lie far apart in memory: they are fetched all at once.
        for [_, triangle] in hits {
            mockup.prefetch_part(*triangle);
            mockup.adjacency().prefetch(*triangle);
        }
        let part_of = |pair: &[u32; 2]| mockup.part_of_face(pair[1]);
        let mut parts: Vec<PartContacts<'_>> = Vec::new();
        let mut piercings = Vec::new();
        let mut pace = Pace::new(self.go_on, REGIONS_BETWEEN);
        for (part, pairs) in by_part.sort(hits, part_of, meeting) {
            let mut contacts = PartContacts { part, pairs, ..PartContacts::default() };
            let regions = find(&context, pairs, None, region_scratch);
            for region in 0..regions.regions.len() {
                if pace.step() {
                    return Err(Error::Cancelled);
                }
                let before = contacts.planes.len();
                let filter = AxisFilter::LeadingOut;
                push_region(&context, regions, region, part, filter, body_scratch, &mut contacts.planes);
                contacts.add_inside(regions, region);
                if contacts.planes.len() == before {
                    piercings.extend(Piercing::new(&context, regions, region).map(|found| (parts.len(), found)));
                }
            }
            parts.push(contacts);
        }
        if count_deep(&parts) < MANY_DEEP {
            for (at, piercing) in piercings {
                self.go_on.check()?;
                push_piercing(&context, &piercing, region_scratch, body_scratch, &mut parts[at]);
            }
        }
        let mut contacts = Contacts { is_meeting: !parts.is_empty(), ..Contacts::default() };
        let mut most_pairs = hits.len();
        if let Some(margin) = near_margin(count_deep(&parts)) {
            parts.iter_mut().flat_map(|part| &mut part.inside).for_each(|ids| ids.sort_unstable());
            let planes = parts.iter().flat_map(|part| &part.planes);
            let dividers: Vec<Divider> = planes.map(|plane| divider(plane, margin)).collect();
            let (margin, near) = self.near_pairs(tool, pose, margin, &dividers, distance)?;
            let mut plane_search = PlaneSearch::new(&context, margin, near_scratch);
            for (part, same) in by_part.sort(&near, |c| c.part, candidates) {
                let mut apart = PartContacts::default();
                let found = parts.iter_mut().find(|met| met.part == part).unwrap_or(&mut apart);
                plane_search.push_planes(same, found.pairs, &found.inside, &mut found.planes)?;
                contacts.planes.append(&mut apart.planes);
            }
            most_pairs = most_pairs.max(near.len());
            distance.put_candidates(near);
        }
        parts.iter_mut().for_each(|part| contacts.planes.append(&mut part.planes));
        drop(parts);
        contacts.planes.sort_by(ContactPlane::order);
        set_ids(&context, &mut contacts.planes);
        contacts.finish(context.lanes, &mut scratch.sorter);
        if most_pairs > MOST_PAIRS_KEPT {
            *scratch = ContactScratch::default();
        }
        self.pool.put(scratch);
        Ok(contacts)
    }

    /// See [`ContactSolver::manifolds`](crate::ContactSolver::manifolds).
    pub fn manifolds(&self, tool: &Tool, pose: &Pose, margin: f64, out: &mut Manifolds) -> Result<()> {
        if !(margin.is_finite() && margin >= 0.0) {
            return Err(Error::Margin { value: margin });
        }
        let mut scratch = self.pool.take();
        let ContactScratch { by_part, candidates, near: near_scratch, distance, planes, .. } = &mut *scratch;
        let context = QueryContext::new(self.scene, tool, pose, None).asking(self.go_on);
        let (margin, near) = self.near_pairs(tool, pose, margin, &[], distance)?;
        let size = tool.mesh().bounds().longest();
        out.manifolds.clear();
        out.margin = margin;
        let mut plane_search = PlaneSearch::new(&context, margin, near_scratch);
        for (_, same) in by_part.sort(&near, |c| c.part, candidates) {
            planes.clear();
            plane_search.push_planes(same, &[], &[Vec::new(), Vec::new()], planes)?;
            set_ids(&context, planes);
            plane_search.each_separated(planes, |plane, separated| {
                out.manifolds.push(manifold(context.lanes, plane, separated, margin, size));
            });
        }
        distance.put_candidates(near);
        self.pool.put(scratch);
        out.manifolds.sort_by(|a, b| a.gap.total_cmp(&b.gap).then(a.id.cmp(&b.id)));
        if let Some(first_left_out) = out.manifolds.get(MOST_MANIFOLDS) {
            out.margin = out.margin.min(first_left_out.gap);
            out.manifolds.truncate(MOST_MANIFOLDS);
        }
        Ok(())
    }

    /// The pairs within a margin, and the margin: halved while they are too many, but never below the least distance.
    fn near_pairs(
        &self,
        tool: &Tool,
        pose: &Pose,
        margin: f64,
        dividers: &[Divider],
        scratch: &mut DistanceScratch,
    ) -> Result<(f64, Vec<Candidate>)> {
        let (scene, go_on) = (self.scene, self.go_on);
        let mut near = |within: f64, most: usize| {
            near_candidates(scene.index(), tool, pose, within, dividers, most, go_on, scratch)
        };
        if let Some(found) = near(margin, MANY_NEAR)? {
            return Ok((margin, found));
        }
        // No pair is farther apart than that: halving a longer margin would only find all of them again.
        let margin = margin.min(longest_distance(scene, tool, pose));
        let least = scene
            .stoppable(go_on)
            .distance(tool, pose, margin)?
            .map_or(0.0, |gap| LEAST_MARGIN_OVER_NEAREST * gap.distance)
            .min(margin);
        let mut within = margin;
        for _ in 0..MOST_MARGIN_HALVINGS {
            if within <= least {
                break;
            }
            within = (0.5 * within).max(least);
            if let Some(found) = near(within, MANY_NEAR)? {
                return Ok((within, found));
            }
        }
        // However many: where surfaces are flush, all of them are the nearest.
        Ok((within, near(within, usize::MAX)?.unwrap_or_default()))
    }
}

/// No two points of the mock-up and of the tool at a pose are farther apart, metres: by the spheres around their boxes.
fn longest_distance(scene: &Scene, tool: &Tool, pose: &Pose) -> f64 {
    let [of_mockup, of_tool] = [scene.mockup().mesh().bounds(), tool.mesh().bounds()];
    let middle = |b: &Aabb| scaled(&add(&b.lower, &b.upper), 0.5);
    let apart = length(&sub(&middle(&of_mockup), &pose.apply(&middle(&of_tool))));
    let diagonals = length(&of_mockup.extent()) + length(&of_tool.extent());
    // With ample room for rounding.
    1.001 * (apart + 0.5 * diagonals) + tool.margin_at(pose)
}

/// Adds the planes of a piercing: those along any axis, or where there are none the one across its own.
fn push_piercing(
    context: &QueryContext<'_>,
    piercing: &Piercing,
    region_scratch: &mut RegionScratch,
    body_scratch: &mut BodyScratch,
    out: &mut PartContacts<'_>,
) {
    let Piercing { pairs, axis } = piercing;
    let (regions, before) = (find(context, pairs, None, region_scratch), out.planes.len());
    for region in 0..regions.regions.len() {
        push_region(context, regions, region, out.part, AxisFilter::Any, body_scratch, &mut out.planes);
    }
    if out.planes.len() > before {
        return;
    }
    let regions = find(context, pairs, Some(*axis), region_scratch);
    out.planes.push(piercing.plane(context, regions, out.part));
    (0..regions.regions.len()).for_each(|region| out.add_inside(regions, region));
}

/// Adds the planes of one region: one for each two bodies that meet, without those that another dominates.
fn push_region(
    context: &QueryContext<'_>,
    regions: &ContactRegions,
    region: usize,
    part: u32,
    filter: AxisFilter,
    scratch: &mut BodyScratch,
    out: &mut Vec<ContactPlane>,
) {
    let BodyScratch { patches, convex_bodies, bodies, depth: depth_scratch, faces, found, meeting } = scratch;
    let segments = regions.segments_of(region, Surface::Tool);
    for surface in Surface::BOTH {
        patches.set(context, regions, region, surface);
        convex_bodies.set(context.lanes, patches);
        bodies[surface].set(context.lanes, patches, convex_bodies, segments.len(), |c| {
            regions.index_in_region[c as usize] as usize
        });
    }
    let bodies = RegionBodies::new(context, regions, bodies);
    find_planes(&bodies, filter, depth_scratch, faces, found);
    for depth in found.iter() {
        meeting.clear();
        if bodies.share_segments(depth.bodies) {
            meeting.extend(bodies.segments_of(depth.bodies).map(|i| regions.segments[segments[i] as usize].faces));
        } else {
            meeting.extend(segments.iter().map(|i| regions.segments[*i as usize].faces));
        }
        let ids =
            |surface: Surface| meeting.iter().map(|faces| regions.faces[surface][faces[surface] as usize].id).collect();
        out.push(ContactPlane {
            point: depth.point,
            normal: depth.normal(),
            gap: depth.gap(),
            part,
            tool_triangles: ids(Surface::Tool),
            mockup_triangles: ids(Surface::Mockup),
            id: 0,
            carriers: bodies.carriers(depth).unwrap_or_else(|| meeting_ids(regions, &meeting[0])),
            assumed: false,
        });
    }
}

/// The triangles of two faces that meet.
fn meeting_ids(regions: &ContactRegions, faces: &[u32; 2]) -> [u32; 2] {
    Surface::BOTH.map(|surface| regions.faces[surface][faces[surface] as usize].id)
}
