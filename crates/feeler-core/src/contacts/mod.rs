//! Contact planes: what holds the tool off the mock-up, or how deep it is in, as a few planes that do not depend on how
//! finely the surfaces are cut into triangles.
//!
//! Where triangles meet, the curve along which they do and what it encloses make a zone ([`zones`]); each of its two surfaces
//! becomes patches and bulging bodies ([`patches`]); two bodies have one least depth ([`depth`]). What is near and does not meet
//! gives planes by distance ([`gaps`]). `docs/contacts.md` says what that means and where it ends.

mod adjacency;
mod arcs;
mod body;
mod classify;
mod clusters;
#[cfg(test)]
mod convex_tests;
mod counting;
mod cracks;
mod cut;
mod depth;
mod descent;
#[cfg(test)]
mod dirty_tests;
mod edge_pairs;
mod edges;
mod first;
mod gaps;
mod heights;
mod joins;
mod judge;
mod least_norm;
#[cfg(test)]
mod near_tests;
mod normals;
mod numbered;
mod onward;
mod outline;
mod overlap;
mod patches;
mod penetration;
mod points;
mod regions;
mod right_through;
#[cfg(test)]
mod right_through_tests;
mod sets;
#[cfg(test)]
mod shapes;
mod sides;
mod sift;
mod split;
mod swallowed;
#[cfg(test)]
mod tests;
mod touching;
mod tracker;
mod walk;
mod way_out;
mod zones;

pub(crate) use adjacency::Adjacency;
pub use penetration::{Penetration, PenetrationKind};
pub(crate) use swallowed::Links;
pub use tracker::ContactTracker;

use std::cmp::Ordering;

use crate::bounds::{Aabb, Point, Triangle};
use crate::contacts::adjacency::NONE;
use crate::contacts::body::{Bodies, Body};
use crate::contacts::clusters::Clusters;
use crate::contacts::counting::ByPart;
use crate::contacts::depth::{Depth, Directions, Pair};
use crate::contacts::first::{push_first_depths, FirstDepth};
use crate::contacts::gaps::{NearLists, NearPairs, SAME_DIRECTION};
use crate::contacts::patches::Patches;
use crate::contacts::right_through::RightThrough;
use crate::contacts::sets::{is_meeting, shared};
use crate::contacts::zones::{Face, Zones, ZonesScratch, MOCKUP, TOOL};
use crate::error::{Error, Result};
use crate::hits::Sorter;
use crate::mesh::Mockup;
use crate::narrow::Filters;
use crate::pose::Pose;
use crate::proximity::{Candidate, Divider};
use crate::scene::Scene;
use crate::simd::Checked;
use crate::tool::Tool;
use crate::vectors::{dot, scaled, sub};

/// Most planes of an answer.
pub const MOST_PLANES: usize = 32;

/// So many deep planes, one for each freedom of the tool, go well with all that is near. Beside more it matters less and less, and
/// looking for it takes as long as all else: it is sought ever nearer by.
pub const FEW_DEEP: usize = 6;

/// So many deep planes are an answer without anything that is only near.
pub const MANY_DEEP: usize = 12;

/// So many pairs that are near are enough: beyond, what is a little farther than the nearest is not worth its time. Two fine
/// surfaces one in the other are all near, each triangle to thousands.
const MANY_NEAR: usize = 1 << 20;

/// Times that the margin is halved to have fewer, and by how much it is more than the least distance at least.
const MOST_HALVINGS: usize = 10;
const BESIDE_THE_NEAREST: f64 = 1.05;

/// Pairs of a query from which on its working memory is not kept.
const MOST_HELD: usize = 1 << 16;

/// Cosine of the angle within which planes of two flat surfaces in one zone are one: half a degree.
const SAME_PLANE: f64 = 0.999_96;

/// Cosine of the angle between a plane and the best normal of two bodies up to which it holds these as well: 25 degrees.
const HELD_DIRECTION: f64 = 0.9063;

/// Share of a surface's length by which its corners may be off: a few steps of float32, in which many files have their numbers.
/// Corners as near as that may be one, and triangles as thin have normals that say nothing.
const NEARLY: f64 = 1.0 / (1 << 19) as f64;

/// A plane between the mock-up and the tool.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactPlane {
    /// On the mock-up's surface, metres, world.
    pub point: Point,
    /// Unit, from the mock-up to the tool.
    pub normal: Point,
    /// Distance of the tool from the plane along the normal, metres; negative: it is that deep behind. Where the two lie in each
    /// other's hollows: what overlaps along the normal.
    pub gap: f64,
    /// The part of the mock-up.
    pub part: u32,
    /// Triangles of the tool behind it, sorted.
    pub tool_triangles: Vec<u32>,
    /// Triangles of the mock-up behind it, sorted.
    pub mockup_triangles: Vec<u32>,
    /// Whether the surfaces there are flat-faced and every direction was tried.
    pub(crate) certain: bool,
    /// Whether the side of the surface that it is on had to be assumed: see [`RightThrough`].
    pub(crate) assumed: bool,
}

/// The contact planes at one pose.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Contacts {
    /// Deepest first, at most [`MOST_PLANES`].
    pub planes: Vec<ContactPlane>,
    /// Planes found beyond [`MOST_PLANES`], the least deep or farthest, that were left out. What is only near is not sought where
    /// [`MANY_DEEP`] are deep, nor all of it beside more than [`FEW_DEEP`].
    pub omitted: usize,
    /// Whether any triangles meet.
    pub is_meeting: bool,
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

/// What one query knows.
pub(crate) struct Ground<'a> {
    mockup: &'a Mockup,
    tool: &'a Tool,
    pose: &'a Pose,
    reference: Option<&'a Pose>,
    /// Of the tool, and of the mock-up.
    adjacency: [&'a Adjacency; 2],
    /// The tool's centre of area, world.
    centre: Point,
    lanes: Checked,
}

/// Working memory of one query.
#[derive(Debug, Default)]
pub(crate) struct ContactScratch {
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

impl<'a> Ground<'a> {
    fn new(scene: &'a Scene, tool: &'a Tool, pose: &'a Pose, reference: Option<&'a Pose>) -> Ground<'a> {
        Ground {
            mockup: scene.mockup(),
            tool,
            pose,
            reference,
            adjacency: [tool.adjacency(), scene.adjacency()],
            centre: pose.apply(&tool.adjacency().centre),
            lanes: scene.checked_lanes(),
        }
    }
}

impl Ground<'_> {
    fn tool_triangle(&self, t: u32) -> Triangle {
        self.pose.apply_triangle(&self.tool.mesh().triangle(t))
    }

    fn mockup_triangle(&self, m: u32) -> Triangle {
        self.mockup.mesh().triangle(m)
    }

    /// The first corner of a triangle.
    fn corner(&self, w: usize, id: u32) -> Point {
        if w == TOOL {
            self.pose.apply(&self.tool.mesh().corner(id))
        } else {
            self.mockup.mesh().corner(id)
        }
    }

    fn triangle(&self, w: usize, id: u32) -> Triangle {
        if w == TOOL {
            self.tool_triangle(id)
        } else {
            self.mockup_triangle(id)
        }
    }

    /// What the winding's normal of a triangle is to be multiplied by to look outward where its surface is closed.
    fn sense(&self, w: usize, id: u32) -> f64 {
        if self.adjacency[w].outward[id as usize] < 0 {
            -1.0
        } else {
            1.0
        }
    }

    /// The pairs one step over an edge of either triangle from a pair.
    fn beside(&self, [t, m]: [u32; 2]) -> impl Iterator<Item = [u32; 2]> {
        let beside_t = self.adjacency[TOOL].neighbours[t as usize].map(|n| [n, m]);
        let beside_m = self.adjacency[MOCKUP].neighbours[m as usize].map(|n| [t, n]);
        beside_t.into_iter().chain(beside_m).filter(|pair| !pair.contains(&NONE))
    }

    /// The box of the tool, in its own frame, or of a part of the mock-up, with what rounding may add: outside it is outside the
    /// solid.
    fn enclosure(&self, w: usize, part: u32) -> Aabb {
        let (b, slack) = match w {
            TOOL => (self.tool.mesh().bounds(), self.tool.margin_at(self.pose)),
            _ => (self.mockup.part_bounds()[part as usize], 0.0),
        };
        let slack = slack + 1e-9 * (0..3).map(|a| b.upper[a] - b.lower[a]).fold(0.0, f64::max);
        Aabb { lower: b.lower.map(|x| x - slack), upper: b.upper.map(|x| x + slack) }
    }

    /// Whether a point (world) is in such a box.
    fn is_enclosed(&self, w: usize, enclosure: &Aabb, p: &Point) -> bool {
        let q = if w == TOOL { self.in_tool(p) } else { *p };
        (0..3).all(|a| enclosure.lower[a] <= q[a] && q[a] <= enclosure.upper[a])
    }

    /// A point of the world in the tool's own frame.
    fn in_tool(&self, p: &Point) -> Point {
        let (r, t) = (self.pose.rotation(), self.pose.translation());
        let d = sub(p, t);
        std::array::from_fn(|a| r[0][a] * d[0] + r[1][a] * d[1] + r[2][a] * d[2])
    }

    /// The normal of a triangle beside `near`, turned to the side that counts as outside there.
    fn turned_outward(&self, w: usize, id: u32, n: &Point, near: &Face) -> Point {
        let flip = match self.adjacency[w].outward[id as usize] {
            side if near.closed && side != 0 => side < 0,
            _ => dot(n, &near.normal) < 0.0,
        };
        if flip {
            scaled(n, -1.0)
        } else {
            *n
        }
    }

    /// From a point of the tool at the pose to where it was at the reference.
    fn way_back(&self, p: &Point) -> Option<Point> {
        let reference = self.reference?;
        Some(sub(&reference.apply(&self.in_tool(p)), p))
    }
}

impl Scene {
    /// The contact planes of a tool at a pose: at most [`MOST_PLANES`], deepest first, for what meets and for what is nearer
    /// than `margin` (metres).
    ///
    /// `reference` is a pose where the tool was free, the last one before this: it tells on which side of open surfaces the
    /// tool belongs. Without it the side of the tool's centre of area counts. Closed surfaces have an inside and need it only
    /// where the tool went right through.
    ///
    /// Beside more than [`FEW_DEEP`] deep planes the margin shrinks in proportion, to nothing at [`MANY_DEEP`]; and it is halved
    /// while more than a million pairs of triangles are within it.
    ///
    /// Errors: a margin that is negative, NaN or infinite, and more near pairs than the memory limit of the scene allows.
    pub fn contacts(&self, tool: &Tool, pose: &Pose, margin: f64, reference: Option<&Pose>) -> Result<Contacts> {
        let share = |deep: usize| MANY_DEEP.saturating_sub(deep) as f64 / (MANY_DEEP - FEW_DEEP) as f64;
        let beside = |deep: usize| (deep < MANY_DEEP).then(|| margin * share(deep).min(1.0));
        self.contacts_beside(beside, tool, pose, margin, reference)
    }

    /// The same, with what is near by a margin that depends on how many planes are deep, or without.
    pub(crate) fn contacts_beside(
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
        let hits = self.collide(tool, pose, Filters::default()).pairs;
        // What is to be known of the triangles lies far apart: all of it is asked for at once.
        for [_, triangle] in &hits {
            self.mockup().prefetch_part(*triangle);
            self.adjacency().prefetch(*triangle);
        }
        let mut scratch = self.take_scratch();
        let ContactScratch {
            by_part, candidates, meeting, near: lists, zones: zones_scratch, zone: zone_scratch, ..
        } = &mut scratch.contacts;
        let part_of = |pair: &[u32; 2]| self.mockup().part_of_face(pair[1]);
        let ground = Ground::new(self, tool, pose, reference);
        let mut places: Vec<Place<'_>> = Vec::new();
        let mut right_through = Vec::new();
        for (part, pairs) in by_part.sort(&hits, part_of, meeting) {
            let mut place = Place { part, pairs, ..Place::default() };
            let zones = zones::find(&ground, pairs, None, zones_scratch);
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
                let (zones, before) = (zones::find(&ground, pairs, None, zones_scratch), place.planes.len());
                for zone in 0..zones.zones.len() {
                    push_zone(&ground, zones, zone, place.part, Sought::Any, zone_scratch, &mut place.planes);
                }
                if place.planes.len() > before {
                    continue;
                }
                let zones = zones::find(&ground, pairs, Some(*way), zones_scratch);
                place.planes.push(right_through.plane(&ground, zones, place.part));
                (0..zones.zones.len()).for_each(|zone| place.add_inside(zones, zone));
            }
        }
        let mut contacts = Contacts { is_meeting: !places.is_empty(), ..Contacts::default() };
        let mut held = hits.len();
        if let Some(margin) = beside(count_deep(&places)) {
            places.iter_mut().flat_map(|place| &mut place.inside).for_each(|ids| ids.sort_unstable());
            let planes = places.iter().flat_map(|place| &place.planes);
            let dividers: Vec<Divider> = planes.map(|plane| gaps::divider(plane, margin)).collect();
            let (margin, near) = self.near_by(tool, pose, margin, &dividers)?;
            let mut gaps = NearPairs::new(&ground, margin, lists);
            for (part, same) in by_part.sort(&near, |c| c.part, candidates) {
                let mut apart = Place::default();
                let place = places.iter_mut().find(|place| place.part == part).unwrap_or(&mut apart);
                gaps.push_planes(same, place.pairs, &place.inside, &mut place.planes);
                contacts.planes.append(&mut apart.planes);
            }
            held = held.max(near.len());
            self.put_candidates(near);
        }
        places.iter_mut().for_each(|place| contacts.planes.append(&mut place.planes));
        drop(places);
        contacts.finish(ground.lanes, &mut scratch.contacts.sorter);
        if held > MOST_HELD {
            scratch.contacts = ContactScratch::default();
        }
        self.put_scratch(scratch);
        Ok(contacts)
    }

    /// The pairs within a margin; where these are too many, within a half of it, a quarter and so on, but never without the
    /// nearest. And that margin.
    fn near_by(&self, tool: &Tool, pose: &Pose, margin: f64, dividers: &[Divider]) -> Result<(f64, Vec<Candidate>)> {
        if let Some(near) = self.near_candidates(tool, pose, margin, dividers, MANY_NEAR)? {
            return Ok((margin, near));
        }
        let least = self.closest(tool, pose, margin)?.map_or(0.0, |gap| BESIDE_THE_NEAREST * gap.distance).min(margin);
        let mut within = margin;
        for _ in 0..MOST_HALVINGS {
            if within <= least {
                break;
            }
            within = (0.5 * within).max(least);
            if let Some(near) = self.near_candidates(tool, pose, within, dividers, MANY_NEAR)? {
                return Ok((within, near));
            }
        }
        // As many as there must be where surfaces are flush.
        Ok((within, self.near_candidates(tool, pose, within, dividers, usize::MAX)?.unwrap_or_default()))
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
                push_first_depths(mockups.iter().map(|m| self.pair(t, *m)), directions, first);
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

fn by_coordinates(p: &Point, q: &Point) -> Ordering {
    (0..3).map(|a| p[a].total_cmp(&q[a])).find(|o| o.is_ne()).unwrap_or(Ordering::Equal)
}

impl ContactPlane {
    fn order(&self, other: &ContactPlane) -> Ordering {
        (self.gap.total_cmp(&other.gap))
            .then(self.part.cmp(&other.part))
            .then_with(|| by_coordinates(&self.normal, &other.normal))
            .then_with(|| by_coordinates(&self.point, &other.point))
    }
}

impl Contacts {
    fn finish(&mut self, lanes: Checked, sorter: &mut Sorter) {
        self.planes.sort_by(ContactPlane::order);
        self.omitted = self.planes.len().saturating_sub(MOST_PLANES);
        self.planes.truncate(MOST_PLANES);
        for plane in &mut self.planes {
            for ids in [&mut plane.tool_triangles, &mut plane.mockup_triangles] {
                sorter.clear();
                // Those of one triangle mostly come one after the other.
                sorter.keys.extend(ids.chunk_by(|a, b| a == b).map(|same| u64::from(same[0])));
                sorter.sort(lanes);
                ids.clear();
                ids.extend(sorter.sorted().iter().map(|id| *id as u32));
            }
        }
    }

    /// The largest penetration, metres; 0 where nothing is deep.
    pub fn depth(&self) -> f64 {
        self.planes.first().map_or(0.0, |p| (-p.gap).max(0.0))
    }
}
