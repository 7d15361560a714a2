//! The contact query: what meets, region by region and body by body, then what is near.
//!
//! Where triangles meet, the contour along which they do and what it encloses make a contact region ([`crate::contour`]); each of
//! its two surfaces becomes patches and convex bodies ([`crate::patch`]); two bodies have one least depth ([`crate::depth`]). What
//! is near and does not meet gives planes by distance ([`crate::proximity`]). `docs/contacts.md` says what that means and where it
//! ends.

use feeler_core::collide::narrow::Filters;
use feeler_core::distance::query::{near_candidates, DistanceScratch};
use feeler_core::distance::wanted::Candidate;
use feeler_core::geometry::vectors::dot;
use feeler_core::index::sink::Divider;
use feeler_core::scratch_pool::ScratchPool;
use feeler_core::{Collision, Error, Point, Pose, Result, Scene, Tool};
use feeler_lanes::Sorter;

use crate::constants::{
    BESIDE_THE_NEAREST, FEW_DEEP, HELD_DIRECTION, MANY_DEEP, MANY_NEAR, MOST_HALVINGS, MOST_HELD, SAME_DIRECTION,
    SAME_PLANE,
};
use crate::contact_plane::{by_coordinates, ContactPlane, Contacts};
use crate::containers::bit_set::{is_meeting, shared};
use crate::containers::counting_sort::PartSort;
use crate::context::QueryContext;
use crate::contour::contact_region::ContactRegions;
use crate::contour::find::{find, RegionScratch};
use crate::depth::axis::BodyPair;
use crate::depth::face_axes::FaceDepth;
use crate::depth::least_depth::{Depth, DepthScratch};
use crate::depth::piercing::Piercing;
use crate::patch::body::{Bodies, Body};
use crate::patch::convex_bodies::ConvexBodies;
use crate::patch::patches::Patches;
use crate::proximity::separating_planes::{divider, NearScratch, PlaneSearch};
use crate::surface::Surface;

/// Asks a scene for contacts, with working memory of its own.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ContactQuery<'a> {
    pub scene: &'a Scene,
    pub pool: &'a ScratchPool<ContactScratch>,
}

/// The tool in one part.
#[derive(Debug, Default)]
struct PartContacts<'a> {
    part: u32,
    /// What meets.
    pairs: &'a [[u32; 2]],
    /// Triangles of tool and mock-up that are wholly inside the other, sorted.
    inside: [Vec<u32>; 2],
    planes: Vec<ContactPlane>,
}

impl PartContacts<'_> {
    /// Adds what is inside in a zone.
    fn add_inside(&mut self, regions: &ContactRegions, region: usize) {
        Surface::BOTH
            .iter()
            .for_each(|&surface| self.inside[surface].extend(regions.inside_of(region, surface).iter().map(|t| t[0])));
    }
}

/// How many planes are deep.
fn count_deep(places: &[PartContacts<'_>]) -> usize {
    places.iter().flat_map(|place| &place.planes).filter(|p| p.gap < 0.0).count()
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
    region: BodyScratch,
    sorter: Sorter,
}

/// Working memory of one zone: its surfaces, the tool's and the mock-up's.
#[derive(Debug, Default)]
struct BodyScratch {
    patches: Patches,
    convex_bodies: ConvexBodies,
    bodies: [Bodies; 2],
    directions: DepthScratch,
    /// First depths with their bodies, and depths.
    first: Vec<(FaceDepth, [usize; 2])>,
    found: Vec<(Depth, [usize; 2])>,
    /// The faces of the cuts of two bodies.
    meeting: Vec<[u32; 2]>,
}

impl ContactQuery<'_> {
    /// See [`ContactSolver::contacts`](crate::ContactSolver::contacts).
    pub fn contacts(&self, tool: &Tool, pose: &Pose, margin: f64, reference: Option<&Pose>) -> Result<Contacts> {
        let share = |deep: usize| MANY_DEEP.saturating_sub(deep) as f64 / (MANY_DEEP - FEW_DEEP) as f64;
        let beside = |deep: usize| (deep < MANY_DEEP).then(|| margin * share(deep).min(1.0));
        self.contacts_beside(beside, tool, pose, margin, reference)
    }

    /// The same, with what is near by a margin that depends on how many planes are deep, or without.
    pub fn contacts_beside(
        &self,
        beside: impl Fn(usize) -> Option<f64>,
        tool: &Tool,
        pose: &Pose,
        margin: f64,
        reference: Option<&Pose>,
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
            near: lists,
            regions: region_scratch,
            region: body_scratch,
            distance,
            ..
        } = &mut *scratch;
        let (scene, mockup) = (self.scene, self.scene.mockup());
        scene.collide_into(tool, pose, Filters::default(), collision);
        let hits = &collision.pairs;
        // What is to be known of the triangles lies far apart: all of it is asked for at once.
        for [_, triangle] in hits {
            mockup.prefetch_part(*triangle);
            mockup.adjacency().prefetch(*triangle);
        }
        let part_of = |pair: &[u32; 2]| mockup.part_of_face(pair[1]);
        let context = QueryContext::new(scene, tool, pose, reference);
        let mut places: Vec<PartContacts<'_>> = Vec::new();
        let mut right_through = Vec::new();
        for (part, pairs) in by_part.sort(hits, part_of, meeting) {
            let mut place = PartContacts { part, pairs, ..PartContacts::default() };
            let regions = find(&context, pairs, None, region_scratch);
            for region in 0..regions.regions.len() {
                let before = place.planes.len();
                push_region(&context, regions, region, part, AxisFilter::LeadingOut, body_scratch, &mut place.planes);
                place.add_inside(regions, region);
                if place.planes.len() == before {
                    right_through.extend(Piercing::new(&context, regions, region).map(|found| (places.len(), found)));
                }
            }
            places.push(place);
        }
        if count_deep(&places) < MANY_DEEP {
            for (place, right_through) in right_through {
                let (Piercing { pairs, way }, place) = (&right_through, &mut places[place]);
                let (regions, before) = (find(&context, pairs, None, region_scratch), place.planes.len());
                for region in 0..regions.regions.len() {
                    push_region(
                        &context,
                        regions,
                        region,
                        place.part,
                        AxisFilter::Any,
                        body_scratch,
                        &mut place.planes,
                    );
                }
                if place.planes.len() > before {
                    continue;
                }
                let regions = find(&context, pairs, Some(*way), region_scratch);
                place.planes.push(right_through.plane(&context, regions, place.part));
                (0..regions.regions.len()).for_each(|region| place.add_inside(regions, region));
            }
        }
        let mut contacts = Contacts { is_meeting: !places.is_empty(), ..Contacts::default() };
        let mut held = hits.len();
        if let Some(margin) = beside(count_deep(&places)) {
            places.iter_mut().flat_map(|place| &mut place.inside).for_each(|ids| ids.sort_unstable());
            let planes = places.iter().flat_map(|place| &place.planes);
            let dividers: Vec<Divider> = planes.map(|plane| divider(plane, margin)).collect();
            let (margin, near) = self.near_by(tool, pose, margin, &dividers, distance)?;
            let mut gaps = PlaneSearch::new(&context, margin, lists);
            for (part, same) in by_part.sort(&near, |c| c.part, candidates) {
                let mut apart = PartContacts::default();
                let place = places.iter_mut().find(|place| place.part == part).unwrap_or(&mut apart);
                gaps.push_planes(same, place.pairs, &place.inside, &mut place.planes);
                contacts.planes.append(&mut apart.planes);
            }
            held = held.max(near.len());
            distance.put_candidates(near);
        }
        places.iter_mut().for_each(|place| contacts.planes.append(&mut place.planes));
        drop(places);
        contacts.finish(context.lanes, &mut scratch.sorter);
        if held > MOST_HELD {
            *scratch = ContactScratch::default();
        }
        self.pool.put(scratch);
        Ok(contacts)
    }

    /// The pairs within a margin; where these are too many, within a half of it, a quarter and so on, but never without the
    /// nearest. And that margin.
    fn near_by(
        &self,
        tool: &Tool,
        pose: &Pose,
        margin: f64,
        dividers: &[Divider],
        scratch: &mut DistanceScratch,
    ) -> Result<(f64, Vec<Candidate>)> {
        let mut near =
            |within: f64, most: usize| near_candidates(self.scene.index(), tool, pose, within, dividers, most, scratch);
        if let Some(found) = near(margin, MANY_NEAR)? {
            return Ok((margin, found));
        }
        let least =
            self.scene.closest(tool, pose, margin)?.map_or(0.0, |gap| BESIDE_THE_NEAREST * gap.distance).min(margin);
        let mut within = margin;
        for _ in 0..MOST_HALVINGS {
            if within <= least {
                break;
            }
            within = (0.5 * within).max(least);
            if let Some(found) = near(within, MANY_NEAR)? {
                return Ok((within, found));
            }
        }
        // As many as there must be where surfaces are flush.
        Ok((within, near(within, usize::MAX)?.unwrap_or_default()))
    }
}

/// Which directions are sought for two bodies.
#[derive(Debug, Clone, Copy, PartialEq)]
enum AxisFilter {
    /// From a normal that leads out; none where there is no such normal.
    LeadingOut,
    /// Any.
    Any,
}

/// The planes of one zone: one for each two bodies that cut each other, without those that a deeper one stands for.
fn push_region(
    context: &QueryContext<'_>,
    regions: &ContactRegions,
    region: usize,
    part: u32,
    sought: AxisFilter,
    scratch: &mut BodyScratch,
    out: &mut Vec<ContactPlane>,
) {
    let BodyScratch { patches, convex_bodies, bodies, directions, first, found, meeting } = scratch;
    let segments = regions.segments_of(region, Surface::Tool);
    for surface in Surface::BOTH {
        patches.set(context, regions, region, surface);
        convex_bodies.set(context.lanes, patches);
        bodies[surface].set(context.lanes, patches, convex_bodies, segments.len(), |c| {
            regions.index_in_region[c as usize] as usize
        });
    }
    let bodies = RegionBodies::new(context, regions, bodies);
    bodies.find_depths(sought, directions, first, found);
    let from = out.len();
    let mut next = 0;
    while let Some((depth, [t, m])) = found.get(next) {
        let (mut depth, [t, m]) = (*depth, [*t, *m]);
        let same = if depth.certain { SAME_PLANE } else { SAME_DIRECTION };
        let is_like = |normal: &Point| dot(normal, &depth.normal) >= same;
        if out[from..].iter().any(|p| is_like(&p.normal)) {
            next += 1;
            continue;
        }
        // What is no deeper than one of its direction that is known comes after that.
        let before = depth.gap();
        let others = found[next + 1..].iter().map(|(d, _)| d);
        let like = others.filter(|d| d.gap() > before && d.is_known()).find(|d| is_like(&d.normal));
        bodies.pair(t, m).measure(context, &mut depth, like.map_or(0.0, |d| -d.gap()), directions);
        found[next].0 = depth;
        if depth.gap() > before {
            let deeper = found[next + 1..].partition_point(|(d, _)| d.gap() <= depth.gap());
            found[next..=next + deeper].rotate_left(1);
            continue;
        }
        next += 1;
        meeting.clear();
        if bodies.share_segments(t, m) {
            meeting.extend(bodies.segments_of(t, m).map(|i| regions.segments[segments[i] as usize].faces));
        } else {
            meeting.extend(segments.iter().map(|i| regions.segments[*i as usize].faces));
        }
        let ids =
            |surface: Surface| meeting.iter().map(|faces| regions.faces[surface][faces[surface] as usize].id).collect();
        out.push(ContactPlane {
            point: depth.point,
            normal: depth.normal,
            gap: depth.gap(),
            part,
            tool_triangles: ids(Surface::Tool),
            mockup_triangles: ids(Surface::Mockup),
            certain: depth.certain && regions.complete,
            assumed: false,
        });
    }
}

/// The bodies of tool and mock-up in one zone.
struct RegionBodies<'a> {
    context: &'a QueryContext<'a>,
    regions: &'a ContactRegions,
    bodies: &'a [Bodies; 2],
    each: [Vec<Body<'a>>; 2],
}

impl<'a> RegionBodies<'a> {
    fn new(context: &'a QueryContext<'a>, regions: &'a ContactRegions, bodies: &'a [Bodies; 2]) -> RegionBodies<'a> {
        let each = bodies.each_ref().map(|of| (0..of.len()).map(|i| of.get(i)).collect());
        RegionBodies { context, regions, bodies, each }
    }

    fn pair(&self, t: usize, m: usize) -> BodyPair<'_> {
        let (tool, mockup) = (&self.each[Surface::Tool][t], &self.each[Surface::Mockup][m]);
        BodyPair { lanes: self.context.lanes, regions: self.regions, tool, mockup }
    }

    fn share_segments(&self, t: usize, m: usize) -> bool {
        is_meeting(self.bodies[Surface::Tool].segments.get(t), self.bodies[Surface::Mockup].segments.get(m))
    }

    /// The cuts that both have a part in, by their places in the zone.
    fn segments_of(&self, t: usize, m: usize) -> impl Iterator<Item = usize> + 'a {
        shared(self.bodies[Surface::Tool].segments.get(t), self.bodies[Surface::Mockup].segments.get(m))
    }

    /// A body that no curve touches is walled in by others of its surface: it meets what they meet.
    fn is_walled_in(&self, t: usize, m: usize) -> bool {
        !(self.bodies[Surface::Tool].is_on_contour(t) && self.bodies[Surface::Mockup].is_on_contour(m))
    }

    /// Whether something is true of any plane found that is needed.
    fn any(
        &self,
        found: &mut [(Depth, [usize; 2])],
        directions: &mut DepthScratch,
        is: impl Fn(&Depth, [usize; 2]) -> bool,
    ) -> bool {
        found.iter_mut().any(|(d, [t, m])| is(d, [*t, *m]) && self.pair(*t, *m).is_filled(self.context, d, directions))
    }

    /// Whether a plane found for others, of about their direction, holds two bodies apart as well; or where that is only an overlap,
    /// whether they overlap along it by no more.
    fn is_held(
        &self,
        pair: BodyPair<'_>,
        depth: f64,
        is_like: impl Fn(&Point) -> bool,
        found: &mut [(Depth, [usize; 2])],
        directions: &mut DepthScratch,
    ) -> bool {
        let mut most: Option<&Depth> = None;
        for (d, [t, m]) in found {
            let is_less = most.is_some_and(|most| d.is_less_than(most));
            if is_less || !is_like(&d.normal) {
                continue;
            }
            let Some(held) = pair.held_depth(d, depth, directions) else { continue };
            let own = self.pair(*t, *m);
            if own.is_filled(self.context, d, directions) {
                return true;
            }
            own.measure(self.context, d, most.map_or(0.0, |most| -most.gap()), directions);
            if held <= -d.gap() {
                return true;
            }
            if most.is_none_or(|most| d.gap() < most.gap()) {
                most = Some(d);
            }
        }
        most.is_some_and(|d| pair.overlaps_no_more(self.context, self.bodies[Surface::Mockup].all(), d, directions))
    }

    /// The least depths of bodies that meet, deepest first, with the bodies' numbers. First of those that the curve cuts; where a
    /// plane of one of these holds apart what is walled in, that needs none of its own.
    fn find_depths(
        &self,
        sought: AxisFilter,
        directions: &mut DepthScratch,
        first: &mut Vec<(FaceDepth, [usize; 2])>,
        found: &mut Vec<(Depth, [usize; 2])>,
    ) {
        directions.clear([self.bodies[Surface::Tool].len(), self.bodies[Surface::Mockup].len()]);
        found.clear();
        let mut mockups = Vec::with_capacity(self.bodies[Surface::Mockup].len());
        for is_on_contour in [true, false] {
            first.clear();
            for t in 0..self.bodies[Surface::Tool].len() {
                mockups.clear();
                for m in 0..self.bodies[Surface::Mockup].len() {
                    let is_sought = if is_on_contour { self.share_segments(t, m) } else { self.is_walled_in(t, m) };
                    if !is_sought {
                        continue;
                    }
                    let pair = self.pair(t, m);
                    let holds = |d: &Depth, [i, j]: [usize; 2]| i == t && pair.is_under(d) || j == m && pair.is_over(d);
                    if is_on_contour || !self.any(found, directions, holds) {
                        mockups.push(m);
                    }
                }
                directions.push_face_depths(mockups.iter().map(|m| self.pair(t, *m)), first);
            }
            // Deepest first: what a deeper plane of about its direction holds apart as well needs none of its own. Bodies along
            // none of whose normals a way leads out come last: there is mostly none, so they are tried only where nothing else
            // gives a plane.
            first.sort_by(|(p, _), (q, _)| q.depth().total_cmp(&p.depth()));
            for (first, [t, m]) in first.iter() {
                let (same, pair) = (if first.certain { SAME_PLANE } else { HELD_DIRECTION }, self.pair(*t, *m));
                let is_needless = match first.normal() {
                    Some(n) => self.is_held(pair, first.depth(), |d| dot(d, &n) >= same, found, directions),
                    None => sought == AxisFilter::LeadingOut || !found.is_empty(),
                };
                if !is_needless {
                    found.extend(pair.least_depth(first, directions).map(|d| (d, [*t, *m])));
                }
            }
        }
        found.sort_by(|(p, _), (q, _)| {
            (p.gap().total_cmp(&q.gap()))
                .then_with(|| by_coordinates(&p.normal, &q.normal))
                .then_with(|| by_coordinates(&p.point, &q.point))
        });
    }
}
