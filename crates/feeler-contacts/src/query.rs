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
use crate::containers::counting_sort::ByPart;
use crate::context::{Ground, MOCKUP, TOOL};
use crate::contour::contact_region::Zones;
use crate::contour::find::{find, ZonesScratch};
use crate::depth::axis::Pair;
use crate::depth::face_axes::FirstDepth;
use crate::depth::least_depth::{Depth, Directions};
use crate::depth::piercing::RightThrough;
use crate::patch::body::{Bodies, Body};
use crate::patch::convex_bodies::Clusters;
use crate::patch::patches::Patches;
use crate::proximity::separating_planes::{divider, NearLists, NearPairs};

/// Asks a scene for contacts, with working memory of its own.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ContactQuery<'a> {
    pub scene: &'a Scene,
    pub pool: &'a ScratchPool<ContactScratch>,
}

/// The tool in one part.
#[derive(Debug, Default)]
struct Place<'a> {
    part: u32,
    /// What meets.
    pairs: &'a [[u32; 2]],
    /// Triangles of tool and mock-up that are wholly inside the other, sorted.
    inside: [Vec<u32>; 2],
    planes: Vec<ContactPlane>,
}

impl Place<'_> {
    /// Adds what is inside in a zone.
    fn add_inside(&mut self, zones: &Zones, zone: usize) {
        (0..2).for_each(|w| self.inside[w].extend(zones.inside_of(zone, w).iter().map(|t| t[0])));
    }
}

/// How many planes are deep.
fn count_deep(places: &[Place<'_>]) -> usize {
    places.iter().flat_map(|place| &place.planes).filter(|p| p.gap < 0.0).count()
}

/// Working memory of one query.
#[derive(Debug, Default)]
pub(crate) struct ContactScratch {
    collision: Collision,
    distance: DistanceScratch,
    by_part: ByPart,
    candidates: Vec<Candidate>,
    meeting: Vec<[u32; 2]>,
    near: NearLists,
    zones: ZonesScratch,
    zone: ZoneScratch,
    sorter: Sorter,
}

/// Working memory of one zone: its surfaces, the tool's and the mock-up's.
#[derive(Debug, Default)]
struct ZoneScratch {
    patches: Patches,
    clusters: Clusters,
    bodies: [Bodies; 2],
    directions: Directions,
    /// First depths with their bodies, and depths.
    first: Vec<(FirstDepth, [usize; 2])>,
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
            zones: zones_scratch,
            zone: zone_scratch,
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
        let ground = Ground::new(scene, tool, pose, reference);
        let mut places: Vec<Place<'_>> = Vec::new();
        let mut right_through = Vec::new();
        for (part, pairs) in by_part.sort(hits, part_of, meeting) {
            let mut place = Place { part, pairs, ..Place::default() };
            let zones = find(&ground, pairs, None, zones_scratch);
            for zone in 0..zones.zones.len() {
                let before = place.planes.len();
                push_zone(&ground, zones, zone, part, Sought::LeadingOut, zone_scratch, &mut place.planes);
                place.add_inside(zones, zone);
                if place.planes.len() == before {
                    right_through.extend(RightThrough::new(&ground, zones, zone).map(|found| (places.len(), found)));
                }
            }
            places.push(place);
        }
        if count_deep(&places) < MANY_DEEP {
            for (place, right_through) in right_through {
                let (RightThrough { pairs, way }, place) = (&right_through, &mut places[place]);
                let (zones, before) = (find(&ground, pairs, None, zones_scratch), place.planes.len());
                for zone in 0..zones.zones.len() {
                    push_zone(&ground, zones, zone, place.part, Sought::Any, zone_scratch, &mut place.planes);
                }
                if place.planes.len() > before {
                    continue;
                }
                let zones = find(&ground, pairs, Some(*way), zones_scratch);
                place.planes.push(right_through.plane(&ground, zones, place.part));
                (0..zones.zones.len()).for_each(|zone| place.add_inside(zones, zone));
            }
        }
        let mut contacts = Contacts { is_meeting: !places.is_empty(), ..Contacts::default() };
        let mut held = hits.len();
        if let Some(margin) = beside(count_deep(&places)) {
            places.iter_mut().flat_map(|place| &mut place.inside).for_each(|ids| ids.sort_unstable());
            let planes = places.iter().flat_map(|place| &place.planes);
            let dividers: Vec<Divider> = planes.map(|plane| divider(plane, margin)).collect();
            let (margin, near) = self.near_by(tool, pose, margin, &dividers, distance)?;
            let mut gaps = NearPairs::new(&ground, margin, lists);
            for (part, same) in by_part.sort(&near, |c| c.part, candidates) {
                let mut apart = Place::default();
                let place = places.iter_mut().find(|place| place.part == part).unwrap_or(&mut apart);
                gaps.push_planes(same, place.pairs, &place.inside, &mut place.planes);
                contacts.planes.append(&mut apart.planes);
            }
            held = held.max(near.len());
            distance.put_candidates(near);
        }
        places.iter_mut().for_each(|place| contacts.planes.append(&mut place.planes));
        drop(places);
        contacts.finish(ground.lanes, &mut scratch.sorter);
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
enum Sought {
    /// From a normal that leads out; none where there is no such normal.
    LeadingOut,
    /// Any.
    Any,
}

/// The planes of one zone: one for each two bodies that cut each other, without those that a deeper one stands for.
fn push_zone(
    ground: &Ground<'_>,
    zones: &Zones,
    zone: usize,
    part: u32,
    sought: Sought,
    scratch: &mut ZoneScratch,
    out: &mut Vec<ContactPlane>,
) {
    let ZoneScratch { patches, clusters, bodies, directions, first, found, meeting } = scratch;
    let cuts = zones.cuts_of(zone, TOOL);
    for w in [TOOL, MOCKUP] {
        patches.set(ground, zones, zone, w);
        clusters.set(ground.lanes, patches);
        bodies[w].set(ground.lanes, patches, clusters, cuts.len(), |c| zones.place_of_cut[c as usize] as usize);
    }
    let bodies = TwoSides::new(ground, zones, bodies);
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
        bodies.pair(t, m).measure(ground, &mut depth, like.map_or(0.0, |d| -d.gap()), directions);
        found[next].0 = depth;
        if depth.gap() > before {
            let deeper = found[next + 1..].partition_point(|(d, _)| d.gap() <= depth.gap());
            found[next..=next + deeper].rotate_left(1);
            continue;
        }
        next += 1;
        meeting.clear();
        if bodies.share_cuts(t, m) {
            meeting.extend(bodies.cuts_of(t, m).map(|i| zones.cuts[cuts[i] as usize].faces));
        } else {
            meeting.extend(cuts.iter().map(|i| zones.cuts[*i as usize].faces));
        }
        let ids = |w: usize| meeting.iter().map(|faces| zones.faces[w][faces[w] as usize].id).collect();
        out.push(ContactPlane {
            point: depth.point,
            normal: depth.normal,
            gap: depth.gap(),
            part,
            tool_triangles: ids(TOOL),
            mockup_triangles: ids(MOCKUP),
            certain: depth.certain && zones.complete,
            assumed: false,
        });
    }
}

/// The bodies of tool and mock-up in one zone.
struct TwoSides<'a> {
    ground: &'a Ground<'a>,
    zones: &'a Zones,
    bodies: &'a [Bodies; 2],
    each: [Vec<Body<'a>>; 2],
}

impl<'a> TwoSides<'a> {
    fn new(ground: &'a Ground<'a>, zones: &'a Zones, bodies: &'a [Bodies; 2]) -> TwoSides<'a> {
        let each = bodies.each_ref().map(|of| (0..of.len()).map(|i| of.get(i)).collect());
        TwoSides { ground, zones, bodies, each }
    }

    fn pair(&self, t: usize, m: usize) -> Pair<'_> {
        let (tool, mockup) = (&self.each[TOOL][t], &self.each[MOCKUP][m]);
        Pair { lanes: self.ground.lanes, zones: self.zones, tool, mockup }
    }

    fn share_cuts(&self, t: usize, m: usize) -> bool {
        is_meeting(self.bodies[TOOL].cuts.get(t), self.bodies[MOCKUP].cuts.get(m))
    }

    /// The cuts that both have a part in, by their places in the zone.
    fn cuts_of(&self, t: usize, m: usize) -> impl Iterator<Item = usize> + 'a {
        shared(self.bodies[TOOL].cuts.get(t), self.bodies[MOCKUP].cuts.get(m))
    }

    /// A body that no curve touches is walled in by others of its surface: it meets what they meet.
    fn is_walled_in(&self, t: usize, m: usize) -> bool {
        !(self.bodies[TOOL].is_cut(t) && self.bodies[MOCKUP].is_cut(m))
    }

    /// Whether something is true of any plane found that is needed.
    fn any(
        &self,
        found: &mut [(Depth, [usize; 2])],
        directions: &mut Directions,
        is: impl Fn(&Depth, [usize; 2]) -> bool,
    ) -> bool {
        found.iter_mut().any(|(d, [t, m])| is(d, [*t, *m]) && self.pair(*t, *m).is_filled(self.ground, d, directions))
    }

    /// Whether a plane found for others, of about their direction, holds two bodies apart as well; or where that is only an overlap,
    /// whether they overlap along it by no more.
    fn is_held(
        &self,
        pair: Pair<'_>,
        depth: f64,
        is_like: impl Fn(&Point) -> bool,
        found: &mut [(Depth, [usize; 2])],
        directions: &mut Directions,
    ) -> bool {
        let mut most: Option<&Depth> = None;
        for (d, [t, m]) in found {
            let is_less = most.is_some_and(|most| d.is_less_than(most));
            if is_less || !is_like(&d.normal) {
                continue;
            }
            let Some(held) = pair.held_depth(d, depth, directions) else { continue };
            let own = self.pair(*t, *m);
            if own.is_filled(self.ground, d, directions) {
                return true;
            }
            own.measure(self.ground, d, most.map_or(0.0, |most| -most.gap()), directions);
            if held <= -d.gap() {
                return true;
            }
            if most.is_none_or(|most| d.gap() < most.gap()) {
                most = Some(d);
            }
        }
        most.is_some_and(|d| pair.overlaps_no_more(self.ground, self.bodies[MOCKUP].all(), d, directions))
    }

    /// The least depths of bodies that meet, deepest first, with the bodies' numbers. First of those that the curve cuts; where a
    /// plane of one of these holds apart what is walled in, that needs none of its own.
    fn find_depths(
        &self,
        sought: Sought,
        directions: &mut Directions,
        first: &mut Vec<(FirstDepth, [usize; 2])>,
        found: &mut Vec<(Depth, [usize; 2])>,
    ) {
        directions.clear([self.bodies[TOOL].len(), self.bodies[MOCKUP].len()]);
        found.clear();
        let mut mockups = Vec::with_capacity(self.bodies[MOCKUP].len());
        for is_cut in [true, false] {
            first.clear();
            for t in 0..self.bodies[TOOL].len() {
                mockups.clear();
                for m in 0..self.bodies[MOCKUP].len() {
                    let is_sought = if is_cut { self.share_cuts(t, m) } else { self.is_walled_in(t, m) };
                    if !is_sought {
                        continue;
                    }
                    let pair = self.pair(t, m);
                    let holds = |d: &Depth, [i, j]: [usize; 2]| i == t && pair.is_under(d) || j == m && pair.is_over(d);
                    if is_cut || !self.any(found, directions, holds) {
                        mockups.push(m);
                    }
                }
                directions.push_first_depths(mockups.iter().map(|m| self.pair(t, *m)), first);
            }
            // Deepest first: what a deeper plane of about its direction holds apart as well needs none of its own. Bodies along
            // none of whose normals a way leads out come last: there is mostly none, so they are tried only where nothing else
            // gives a plane.
            first.sort_by(|(p, _), (q, _)| q.depth().total_cmp(&p.depth()));
            for (first, [t, m]) in first.iter() {
                let (same, pair) = (if first.certain { SAME_PLANE } else { HELD_DIRECTION }, self.pair(*t, *m));
                let is_needless = match first.normal() {
                    Some(n) => self.is_held(pair, first.depth(), |d| dot(d, &n) >= same, found, directions),
                    None => sought == Sought::LeadingOut || !found.is_empty(),
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
