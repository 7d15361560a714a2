//! Which pairs of parts, and which of their surfaces, are in contact at the tool's start.
//!
//! A pair in contact at the start is a seat until it separates. If it touches or overlaps a little, the tool's part is
//! [eroded](super::erosion) and cast exactly. If it overlaps more, it is sunk, like a bolt modelled through a solid
//! plate: it may not move against a contact plane that it has penetrated, nor go in where its surface is
//! [flush](super::flush) with the neighbour's, and its surface may cross the neighbour's only within the volume that it
//! filled at the start.
//!
//! The original part is cast exactly, except for the pairs of surfaces in contact at the start and the surfaces next to them across
//! convex edges: the facets of a pin cross the face around its hole when it leaves.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use feeler_contacts::ContactSolver;
use feeler_core::geometry::vectors::{cross, dot, length, scaled, sub};
use feeler_core::{Gap, GoOn, IgnoredPairs, Point, Pose, Scene, SurfaceNumbers, Tool};

use super::erosion::{Eroded, Erosion};
use crate::constants::TOUCH;
use crate::error::{Error, Result};
use crate::surfaces::Surfaces;

/// The allowed contacts.
#[derive(Debug, Clone, Default, PartialEq)]
#[non_exhaustive]
pub struct Allowed {
    /// Pairs in contact at the start, until they separate, no deeper than then.
    pub start: bool,
    /// Every pair may be this deep in each other, metres.
    pub overlap: f64,
    /// Parts of the mock-up that may be met all along.
    pub parts: Vec<u32>,
}

impl Allowed {
    feeler_core::setters! {
        with_start: start: bool,
        with_overlap: overlap: f64,
        with_parts: parts: Vec<u32>,
    }
}

/// How a pair is at the start.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum SeatKind {
    /// Apart, but nearer than the clearance.
    Near,
    /// It touches.
    Flush,
    /// One is a little in the other.
    Fit,
    /// One is in the other, as if there were no hole.
    Sunk,
}

impl SeatKind {
    /// Whether they collide.
    pub fn meets(self) -> bool {
        self != SeatKind::Near
    }
}

/// A part of the tool and one of a body that are together at the start.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Seat {
    /// Of the tool.
    pub tool_part: u32,
    /// Of the body.
    pub part: u32,
    /// How it is at the start.
    pub kind: SeatKind,
    /// Its depth, metres: by how much the tool's part must shrink to be free; for a sunk part the deepest contact
    /// plane.
    pub depth: f64,
}

/// The seats of one body at the start, sorted; and the contacts there that are not allowed.
#[derive(Debug, Default)]
pub struct Start {
    pub seats: Vec<Seat>,
    /// By seat: the part of the tool made smaller, where it is flush or fits.
    pub eroded: Vec<Option<Eroded>>,
    pub refused: Vec<[u32; 2]>,
    pub regions: Option<Regions>,
}

/// The pairs of surfaces of seats that may collide.
#[derive(Debug)]
pub struct Regions {
    tool: Surfaces,
    body: Surfaces,
    /// `[surface of the tool, surface of the body]`, and their parts.
    pairs: BTreeMap<[u32; 2], [u32; 2]>,
}

impl Regions {
    /// The numbers of surfaces, the tool's first.
    pub fn numbers(&self) -> [&Arc<SurfaceNumbers>; 2] {
        [&self.tool.numbers, &self.body.numbers]
    }

    /// The pairs of surfaces of some pairs of parts; both sorted.
    pub fn pairs<'a>(&'a self, of: &'a [[u32; 2]]) -> impl Iterator<Item = [u32; 2]> + 'a {
        self.pairs.iter().filter(|(_, parts)| of.binary_search(parts).is_ok()).map(|(pair, _)| *pair)
    }

    /// The triangles of a body that some pairs of parts may meet, ascending; the pairs sorted.
    pub fn met(&self, of: &[[u32; 2]]) -> impl Iterator<Item = u32> + '_ {
        let surfaces: BTreeSet<u32> = self.pairs(of).map(|[_, surface]| surface).collect();
        self.body.numbers.all().filter(move |(_, surface)| surfaces.contains(surface)).map(|(triangle, _)| triangle)
    }

    /// The triangles of a part of the tool that a neighbour may meet, ascending.
    pub fn met_of_tool(&self, tool: &Tool, pair: [u32; 2]) -> Vec<u32> {
        let surfaces: BTreeSet<u32> = self.pairs(&[pair]).map(|[surface, _]| surface).collect();
        let all = self.tool.numbers.all().filter(|(_, surface)| surfaces.contains(surface));
        all.map(|(triangle, _)| triangle).filter(|t| tool.part_of_face(*t) == pair[0]).collect()
    }

    fn new(scene: &Scene, tool: &Tool, seats: &[Seat], met: &[[u32; 2]]) -> Regions {
        let mockup = scene.mockup();
        let mut of_parts: Vec<u32> = seats.iter().map(|seat| seat.part).collect();
        of_parts.sort_unstable();
        of_parts.dedup();
        let is_theirs = |t: &u32| of_parts.binary_search(&mockup.part_of_face(*t)).is_ok();
        let ours: Vec<u32> = tool.mesh().queried().collect();
        let theirs: Vec<u32> = mockup.mesh().queried().filter(is_theirs).collect();
        let of_tool = Surfaces::new(tool.mesh(), tool.adjacency(), &ours, |t| tool.part_of_face(t));
        let of_body = Surfaces::new(mockup.mesh(), mockup.adjacency(), &theirs, |t| mockup.part_of_face(t));
        let mut all: BTreeMap<[u32; 2], [u32; 2]> = BTreeMap::new();
        for seat in seats {
            let parts = [seat.tool_part, seat.part];
            let is_own = |[t, m]: &&[u32; 2]| [tool.part_of_face(*t), mockup.part_of_face(*m)] == parts;
            let numbers = |[t, m]: &[u32; 2]| Some([of_tool.numbers.of(*t)?, of_body.numbers.of(*m)?]);
            let pairs: BTreeSet<[u32; 2]> = met.iter().filter(is_own).filter_map(numbers).collect();
            // Any surface of a sunk part may come to where it leaves.
            let own = ours.iter().copied().filter(|t| tool.part_of_face(*t) == seat.tool_part);
            let sunk = if seat.kind == SeatKind::Sunk { of_tool.of(&own.collect::<Vec<u32>>()) } else { Vec::new() };
            for [t, m] in pairs {
                for t in sunk.iter().chain(of_tool.beside(t)).chain([&t]) {
                    for m in of_body.beside(m).iter().chain([&m]) {
                        all.insert([*t, *m], parts);
                    }
                }
            }
        }
        Regions { tool: of_tool, body: of_body, pairs: all }
    }
}

/// Finds the seats of one body at `start`. `solver` and `scene` exclude the parts that are always allowed. Tool parts
/// from `own_parts` on are grippers.
///
/// Errors: a gripper in contact; a request to stop, by `goes_on`.
pub fn find_seats(
    (solver, scene): (&ContactSolver, &Scene),
    tool: &Tool,
    own_parts: u32,
    start: &Pose,
    (allowed, clearance): (&Allowed, f64),
    goes_on: &(dyn Fn() -> bool + Sync),
) -> Result<Start> {
    let asked = scene.stoppable(GoOn::new(goes_on));
    let touching = asked.near_pairs(tool, start, TOUCH)?;
    let met: Vec<[u32; 2]> = touching.iter().map(|gap| [gap.tool_triangle, gap.mockup_triangle]).collect();
    // Within a large clearance there are too many pairs of triangles: of one part, its neighbours are enough.
    let near = match clearance > TOUCH {
        true if tool.parts() == 1 => asked.clearance(tool, start, clearance)?,
        true => asked.near_pairs(tool, start, clearance)?,
        false => Vec::new(),
    };
    let mut nearest: BTreeMap<[u32; 2], f64> = BTreeMap::new();
    for gap in touching.iter().chain(&near) {
        let least = nearest.entry([gap.tool_part, gap.part]).or_insert(gap.distance);
        *least = least.min(gap.distance);
    }
    let size = length(&tool.mesh().bounds().extent());
    let (mut found, mut erosion) = (Start::default(), Erosion::new(tool));
    for (pair, distance) in nearest {
        if !goes_on() {
            return Err(feeler_core::Error::Cancelled.into());
        }
        let [tool_part, part] = pair;
        let meets = distance <= TOUCH;
        if meets && tool_part >= own_parts {
            return Err(Error::GripMeets { tool_part, part });
        }
        let mut smaller = None;
        let (mut kind, mut depth) = (SeatKind::Near, 0.0);
        if meets {
            let alone = solver.with_scene(Arc::new(scene.of_one_part(part)));
            smaller = erosion.free_part((&alone, part), tool_part, start, allowed.overlap, size)?;
            (kind, depth) = match &smaller {
                Some(eroded) if eroded.depth == 0.0 => (SeatKind::Flush, 0.0),
                Some(eroded) => (SeatKind::Fit, eroded.depth),
                None => (SeatKind::Sunk, depth_at(&alone, tool, tool_part, start)?),
            };
        }
        if !meets || allowed.start {
            found.seats.push(Seat { tool_part, part, kind, depth });
            found.eroded.push(smaller);
        } else if allowed.overlap == 0.0 || depth > allowed.overlap {
            found.refused.push(pair);
        }
    }
    let meeting: Vec<Seat> = found.seats.iter().filter(|seat| seat.kind.meets()).copied().collect();
    if !meeting.is_empty() {
        let mut regions = Regions::new(scene, tool, &meeting, &met);
        let inside = pressed_inside((scene, &regions), tool, start, &meeting, goes_on)?;
        if !inside.is_empty() {
            regions = Regions::new(scene, tool, &meeting, &[met, inside].concat());
        }
        found.regions = Some(regions);
    }
    Ok(found)
}

/// The triangles of fits that are in each other and cross nothing, such as the floor of a pocket whose walls press, too: face to face, each
/// behind the other, by the depth of the fit at most. Pairs of surfaces that are known are left out.
fn pressed_inside(
    (scene, known): (&Scene, &Regions),
    tool: &Tool,
    start: &Pose,
    seats: &[Seat],
    goes_on: &(dyn Fn() -> bool + Sync),
) -> Result<Vec<[u32; 2]>> {
    let fits: BTreeMap<[u32; 2], f64> = seats
        .iter()
        .filter(|seat| seat.kind == SeatKind::Fit)
        .map(|seat| ([seat.tool_part, seat.part], seat.depth))
        .collect();
    let within = fits.values().copied().fold(0.0, f64::max);
    if within == 0.0 {
        return Ok(Vec::new());
    }
    let mut parts: Vec<u32> = fits.keys().map(|[_, part]| *part).collect();
    parts.sort_unstable();
    parts.dedup();
    let pairs: Vec<[u32; 2]> = fits.keys().copied().collect();
    let ignored = IgnoredPairs::new(tool.parts(), scene.mockup().part_bounds().len(), std::iter::empty())
        .with_surfaces(known.numbers(), known.pairs(&pairs));
    let asked = scene.only(&parts)?.ignoring(Arc::new(ignored));
    let near = asked.stoppable(GoOn::new(goes_on)).near_pairs(tool, start, within)?;
    let outward = |[a, b, c]: [Point; 3], side: i8| scaled(&cross(&sub(&b, &a), &sub(&c, &a)), f64::from(side));
    let is_inside = |gap: &Gap| {
        let [t, m] = [gap.tool_triangle, gap.mockup_triangle];
        let own = outward(start.apply_triangle(&tool.mesh().triangle(t)), tool.adjacency().outward[t as usize]);
        let mockup = scene.mockup();
        let other = outward(mockup.mesh().triangle(m), mockup.adjacency().outward[m as usize]);
        let way = sub(&gap.on_mockup, &gap.on_tool);
        let is_of_fit = fits.get(&[gap.tool_part, gap.part]).is_some_and(|depth| gap.distance <= *depth);
        is_of_fit && dot(&own, &other) < 0.0 && dot(&own, &way) < 0.0 && dot(&other, &way) > 0.0
    };
    Ok(near.iter().filter(|gap| is_inside(gap)).map(|gap| [gap.tool_triangle, gap.mockup_triangle]).collect())
}

/// How deep a part of the tool is in the one that a solver asks of, metres: the deepest contact plane.
fn depth_at(solver: &ContactSolver, tool: &Tool, part: u32, pose: &Pose) -> Result<f64> {
    let planes = solver.contacts(tool, pose, 0.0, None)?.planes;
    Ok(planes.iter().filter(|plane| plane.tool_part(tool) == part).map(|plane| -plane.gap).fold(0.0, f64::max))
}
