//! The shortest way out.

use feeler_core::geometry::vectors::{add, dot, length, scaled, unit};
use feeler_core::{Point, Pose, Result, Tool};

use crate::constants::MOST_PLANES;
use crate::contact_plane::{ContactPlane, Contacts};
use crate::escape::containment::containing_parts;
use crate::escape::escape_probe::{directions_of, escape_from_solids, escape_probe_axes, is_free_and_outside};
use crate::escape::min_norm::{compromise, shortest};
use crate::query::ContactQuery;

/// Times that planes met on the way are added, and the way is sought anew.
const MOST_ROUNDS: usize = 8;

/// Share by which the way is lengthened, so that the tool ends off the surface and not on it.
const OFF: f64 = 1e-6;

/// How much a penetration may be trusted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PenetrationKind {
    /// The moved tool is free (checked exactly), and no shorter translation separates the two surfaces that meet: one place of
    /// contact, both sides of it flat-faced and bulging, every direction that could be least was tried.
    Exact,
    /// The moved tool is free (checked exactly), and not inside a solid; a shorter translation may exist.
    Bound,
    /// The moved tool still meets the mock-up: nothing that frees it was found.
    Estimate,
}

/// A translation that frees a tool.
#[derive(Debug, Clone, PartialEq)]
pub struct Penetration {
    /// Metres, world: add it to the pose's.
    pub translation: Point,
    /// Its length, metres.
    pub depth: f64,
    /// What it is.
    pub kind: PenetrationKind,
    /// The contact planes at the pose, with what is near unless what is deep fills them.
    pub contacts: Contacts,
}

/// A tool that meets something, and what is asked about it.
struct Stuck<'a> {
    tool: &'a Tool,
    pose: &'a Pose,
    margin: f64,
    reference: Option<&'a Pose>,
    /// Metres.
    longest: f64,
}

/// See [`ContactSolver::penetration`](crate::ContactSolver::penetration).
pub(crate) fn penetration(
    query: &ContactQuery<'_>,
    tool: &Tool,
    pose: &Pose,
    margin: f64,
    reference: Option<&Pose>,
) -> Result<Penetration> {
    let scene = query.scene;
    let beside = |deep: usize| (deep < MOST_PLANES).then_some(margin);
    let contacts = query.contacts_within(beside, tool, pose, margin, reference)?;
    if !contacts.is_meeting {
        let parts = containing_parts(scene, tool, pose);
        let (translation, kind) = if parts.is_empty() {
            ([0.0; 3], PenetrationKind::Exact)
        } else {
            let way = escape_from_solids(scene, tool, pose, &parts)?;
            way.map_or(([0.0; 3], PenetrationKind::Estimate), |way| (way, PenetrationKind::Bound))
        };
        return Ok(Penetration { depth: length(&translation), translation, kind, contacts });
    }
    // A way longer than the tool is no way out of where it is.
    let longest = length(&tool.mesh().bounds().extent());
    let stuck = Stuck { tool, pose, margin, reference, longest };
    let (mut translation, mut kind) = way_over(query, &stuck, &contacts, |p| !p.assumed)?;
    // The longest way that is still of use.
    let mut limit = if kind == PenetrationKind::Estimate { longest } else { length(&translation) };
    let mut directions: Vec<Point> = contacts.planes.iter().map(|p| p.normal).collect();
    directions.extend(unit(&translation));
    directions.extend(directions_of(pose));
    let is_sought = kind == PenetrationKind::Estimate;
    if contacts.planes.iter().any(|p| p.assumed) {
        // The tool may have come from the other side, too: the shorter of both.
        let (other, is) = way_over(query, &stuck, &contacts, |_| true)?;
        if is != PenetrationKind::Estimate && length(&other) < limit {
            (translation, kind, limit) = (other, PenetrationKind::Bound, length(&other));
        }
    }
    if is_sought {
        if let Some(way) = escape_probe_axes(scene, tool, pose, &directions, limit) {
            (translation, kind) = (way, PenetrationKind::Bound);
        }
    }
    Ok(Penetration { depth: length(&translation), translation, kind, contacts })
}

/// The shortest way over those of the contact planes that count, and over those that count at the poses it leads to.
fn way_over(
    query: &ContactQuery<'_>,
    stuck: &Stuck<'_>,
    contacts: &Contacts,
    counts: impl Fn(&ContactPlane) -> bool,
) -> Result<(Point, PenetrationKind)> {
    let Stuck { tool, pose, margin, reference, longest } = *stuck;
    let scene = query.scene;
    let counting = || contacts.planes.iter().filter(|p| counts(p));
    let mut planes: Vec<(Point, f64)> = counting().map(|p| (p.normal, -p.gap)).collect();
    let mut certain: Vec<bool> = counting().map(|p| p.certain).collect();
    // Off the surface by the rounding of a placed corner at least.
    let coordinates = scene.mockup().mesh().bounds().largest_coordinate();
    let least = 1e-14 * (coordinates + pose.largest_translation()) + tool.margin_at(pose);
    let leave = |planes: &[(Point, f64)]| {
        shortest(planes).filter(|(way, _)| length(way) <= longest).map(|(way, held)| {
            // Every plane that holds the way is left by `off`.
            let length = length(&way);
            let off = OFF * length + least;
            let outward = if length > 0.0 { scaled(&way, 1.0 / length) } else { first_normal(contacts) };
            let lean = held.iter().map(|i| dot(&outward, &planes[*i].0)).fold(1.0, f64::min).max(0.01);
            (add(&way, &scaled(&outward, off / lean)), way, held)
        })
    };
    let mut kind = PenetrationKind::Estimate;
    let mut translation = [0.0; 3];
    for round in 0..MOST_ROUNDS {
        let Some((moved_by, way, held)) = leave(&planes) else {
            translation = compromise(&planes);
            break;
        };
        translation = moved_by;
        let moved = pose.translated(&translation)?;
        if !scene.is_colliding(tool, &moved) {
            let single = round == 0 && held.len() == 1 && certain[held[0]];
            // Where nothing is deep, a touch is all there is.
            let tight = round == 0 && held.is_empty()
                || single && scene.is_colliding(tool, &pose.translated(&scaled(&way, 0.999))?);
            kind = if tight { PenetrationKind::Exact } else { PenetrationKind::Bound };
            break;
        }
        let there = query.contacts(tool, &moved, margin, reference)?;
        let before = planes.len();
        for plane in there.planes.iter().filter(|p| p.gap <= 0.0 && counts(p)) {
            planes.push((plane.normal, dot(&plane.normal, &translation) - plane.gap));
            certain.push(false);
        }
        if planes.len() == before {
            break;
        }
        keep_the_tightest(&mut planes, &mut certain);
    }
    if kind != PenetrationKind::Exact {
        // What one plane asks for may be left undone by what the others do: of two that nearly face each other, say, the
        // way out of both is endless. Each is left out in turn, as long as that is shorter and still free.
        let mut shorter = (kind == PenetrationKind::Bound).then_some(translation);
        for _ in 0..MOST_ROUNDS {
            let candidates = leave(&planes).map_or_else(|| (0..planes.len()).collect(), |(_, _, held)| held);
            let mut left_out = None;
            for i in candidates {
                let rest: Vec<(Point, f64)> =
                    planes.iter().enumerate().filter(|(j, _)| *j != i).map(|(_, p)| *p).collect();
                let Some((way, _, _)) = leave(&rest) else { continue };
                let enough = shorter.map_or(f64::INFINITY, |known| length(&known) * (1.0 - 1e-3));
                if length(&way) < enough && !scene.is_colliding(tool, &pose.translated(&way)?) {
                    (shorter, left_out) = (Some(way), Some(rest));
                }
            }
            match left_out {
                Some(rest) => planes = rest,
                None => break,
            }
        }
        if let Some(way) = shorter {
            (translation, kind) = (way, PenetrationKind::Bound);
        }
    }
    // What lies right inside a solid meets nothing, and is not free.
    if kind != PenetrationKind::Estimate && !is_free_and_outside(scene, tool, &pose.translated(&translation)?) {
        kind = PenetrationKind::Estimate;
    }
    Ok((translation, kind))
}

fn first_normal(contacts: &Contacts) -> Point {
    contacts.planes.first().map_or([0.0, 0.0, 1.0], |p: &ContactPlane| p.normal)
}

/// Of planes with one direction the one that asks most; and of all no more than the search for the shortest way can take.
fn keep_the_tightest(planes: &mut Vec<(Point, f64)>, certain: &mut Vec<bool>) {
    let mut order: Vec<usize> = (0..planes.len()).collect();
    order.sort_by(|i, j| planes[*j].1.total_cmp(&planes[*i].1).then(i.cmp(j)));
    let mut kept: Vec<usize> = Vec::new();
    for i in order {
        if kept.len() < 48 && !kept.iter().any(|k| dot(&planes[*k].0, &planes[i].0) > 1.0 - 1e-9) {
            kept.push(i);
        }
    }
    *certain = kept.iter().map(|i| certain[*i]).collect();
    *planes = kept.iter().map(|i| planes[*i]).collect();
}
