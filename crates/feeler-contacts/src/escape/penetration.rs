//! Penetration: the shortest translation that frees the tool.
//!
//! The contact planes are linear inequalities on the translation, and its least-norm point is the candidate. The moved
//! tool is tested exactly; if it still collides, the planes of the new pose are added and the least-norm point is
//! computed again (cutting planes). The result is an upper bound: for convex polyhedra that cross with few faces it is
//! mostly the least one; for others a shorter one may exist.

use feeler_core::geometry::vectors::{add, dot, length, scaled, unit};
use feeler_core::{Point, Pose, Result, Tool};

use crate::constants::{
    ESCAPE_EXCESS, ESCAPE_ROUNDING, LEAST_ESCAPE_LEAN, LEFT_OUT_SHORTER, MOST_ESCAPE_PLANES, MOST_ESCAPE_ROUNDS,
    MOST_PLANES, PARALLEL_ESCAPE_PLANES,
};
use crate::contact_plane::{ContactPlane, Contacts};
use crate::containment::find::parts_in_containment;
use crate::escape::escape_probe::{cube_axes, escape_containment, is_free_and_outside, probe_axes};
use crate::escape::min_norm::{min_norm, relaxed};
use crate::query::ContactQuery;

/// How much a penetration may be trusted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PenetrationKind {
    /// Nothing is to be left: the tool meets nothing, or only touches.
    Exact,
    /// The moved tool is free (checked exactly), and not inside a solid; a shorter translation may exist.
    Bound,
    /// The moved tool still meets the mock-up: no translation that frees it was found.
    Estimate,
}

/// A translation that frees a tool.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Penetration {
    /// Metres, world: add it to the pose's.
    pub translation: Point,
    /// Its length, metres.
    pub depth: f64,
    /// Its kind.
    pub kind: PenetrationKind,
    /// The contact planes at the pose, with those of near surfaces unless deep ones fill the answer.
    pub contacts: Contacts,
}

/// A tool that meets something, and the query about it.
struct Stuck<'a> {
    tool: &'a Tool,
    pose: &'a Pose,
    margin: f64,
    reference: Option<&'a Pose>,
    /// No translation longer than this counts, metres.
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
    let near_margin = |deep: usize| (deep < MOST_PLANES).then_some(margin);
    let contacts = query.contacts_within(near_margin, tool, pose, margin, reference)?;
    if !contacts.is_meeting {
        let parts = parts_in_containment(scene, tool, pose, query.go_on);
        let (translation, kind) = if parts.is_empty() {
            ([0.0; 3], PenetrationKind::Exact)
        } else {
            let escape = escape_containment((scene, query.go_on), tool, pose, &parts)?;
            escape.map_or(([0.0; 3], PenetrationKind::Estimate), |escape| (escape, PenetrationKind::Bound))
        };
        return Ok(Penetration { depth: length(&translation), translation, kind, contacts });
    }
    // A translation longer than the tool would be an escape from more than it meets here.
    let longest = length(&tool.mesh().bounds().extent());
    let stuck = Stuck { tool, pose, margin, reference, longest };
    let (mut translation, mut kind) = escape_over_planes(query, &stuck, &contacts, |p| !p.assumed)?;
    // Only a shorter translation is of use.
    let mut limit = if kind == PenetrationKind::Estimate { longest } else { length(&translation) };
    let mut axes: Vec<Point> = contacts.planes.iter().map(|p| p.normal).collect();
    axes.extend(unit(&translation));
    axes.extend(cube_axes(pose));
    let is_probed = kind == PenetrationKind::Estimate;
    if contacts.planes.iter().any(|p| p.assumed) {
        // The assumed side may be the wrong one: the shorter of the escapes with and without such planes.
        let (other, other_kind) = escape_over_planes(query, &stuck, &contacts, |_| true)?;
        if other_kind != PenetrationKind::Estimate && length(&other) < limit {
            (translation, kind, limit) = (other, PenetrationKind::Bound, length(&other));
        }
    }
    if is_probed {
        if let Some(escape) = probe_axes((scene, query.go_on), tool, pose, &axes, limit) {
            (translation, kind) = (escape, PenetrationKind::Bound);
        }
    }
    Ok(Penetration { depth: length(&translation), translation, kind, contacts })
}

/// The shortest translation over those contact planes that count, and over those that count at the poses it leads to.
fn escape_over_planes(
    query: &ContactQuery<'_>,
    stuck: &Stuck<'_>,
    contacts: &Contacts,
    counts: impl Fn(&ContactPlane) -> bool,
) -> Result<(Point, PenetrationKind)> {
    let Stuck { tool, pose, margin, reference, longest } = *stuck;
    let scene = query.scene;
    let counting = || contacts.planes.iter().filter(|p| counts(p));
    let mut planes: Vec<(Point, f64)> = counting().map(|p| (p.normal, -p.gap)).collect();
    // The tool ends off the surface by the rounding of a placed corner at least.
    let coordinates = scene.mockup().mesh().bounds().largest_coordinate();
    let least = ESCAPE_ROUNDING * (coordinates + pose.largest_translation()) + tool.margin_at(pose);
    let leave = |planes: &[(Point, f64)]| {
        min_norm(planes).filter(|(escape, _)| length(escape) <= longest).map(|(escape, active)| {
            // Every active plane is left by `off`.
            let length = length(&escape);
            let off = ESCAPE_EXCESS * length + least;
            let outward = if length > 0.0 { scaled(&escape, 1.0 / length) } else { first_normal(contacts) };
            let lean = active.iter().map(|i| dot(&outward, &planes[*i].0)).fold(1.0, f64::min).max(LEAST_ESCAPE_LEAN);
            (add(&escape, &scaled(&outward, off / lean)), active)
        })
    };
    let mut kind = PenetrationKind::Estimate;
    let mut translation = [0.0; 3];
    for round in 0..MOST_ESCAPE_ROUNDS {
        let Some((moved_by, active)) = leave(&planes) else {
            translation = relaxed(&planes);
            break;
        };
        translation = moved_by;
        let moved = pose.translated(&translation)?;
        if !scene.is_colliding(tool, &moved) {
            // Without an active plane the two only touch.
            let is_touching = round == 0 && active.is_empty();
            kind = if is_touching { PenetrationKind::Exact } else { PenetrationKind::Bound };
            break;
        }
        let there = query.contacts(tool, &moved, margin, reference)?;
        let before = planes.len();
        for plane in there.planes.iter().filter(|p| p.gap <= 0.0 && counts(p)) {
            planes.push((plane.normal, dot(&plane.normal, &translation) - plane.gap));
        }
        if planes.len() == before {
            break;
        }
        keep_tightest(&mut planes);
    }
    if kind != PenetrationKind::Exact {
        // One plane may be needless once the others are satisfied, and of two that nearly face each other the escape from both is
        // endless. So each active plane is left out in turn, as long as that is shorter and still free.
        let mut shorter = (kind == PenetrationKind::Bound).then_some(translation);
        for _ in 0..MOST_ESCAPE_ROUNDS {
            let candidates = leave(&planes).map_or_else(|| (0..planes.len()).collect(), |(_, active)| active);
            let mut left_out = None;
            for i in candidates {
                query.go_on.check()?;
                let rest: Vec<(Point, f64)> =
                    planes.iter().enumerate().filter(|(j, _)| *j != i).map(|(_, p)| *p).collect();
                let Some((escape, _)) = leave(&rest) else { continue };
                let enough = shorter.map_or(f64::INFINITY, |known| length(&known) * (1.0 - LEFT_OUT_SHORTER));
                if length(&escape) < enough && !scene.is_colliding(tool, &pose.translated(&escape)?) {
                    (shorter, left_out) = (Some(escape), Some(rest));
                }
            }
            match left_out {
                Some(rest) => planes = rest,
                None => break,
            }
        }
        if let Some(escape) = shorter {
            (translation, kind) = (escape, PenetrationKind::Bound);
        }
    }
    // A tool wholly inside a solid meets nothing, and is not free.
    if kind != PenetrationKind::Estimate {
        let moved = pose.translated(&translation)?;
        if !is_free_and_outside((scene, query.go_on), tool, &moved) {
            kind = PenetrationKind::Estimate;
        }
    }
    Ok((translation, kind))
}

fn first_normal(contacts: &Contacts) -> Point {
    contacts.planes.first().map_or([0.0, 0.0, 1.0], |p: &ContactPlane| p.normal)
}

/// Keeps of parallel planes the tightest, and of all no more than [`min_norm`] can take.
pub(crate) fn keep_tightest(planes: &mut Vec<(Point, f64)>) {
    let mut order: Vec<usize> = (0..planes.len()).collect();
    order.sort_by(|i, j| planes[*j].1.total_cmp(&planes[*i].1).then(i.cmp(j)));
    let mut kept: Vec<usize> = Vec::new();
    for i in order {
        if kept.len() < MOST_ESCAPE_PLANES
            && !kept.iter().any(|k| dot(&planes[*k].0, &planes[i].0) > 1.0 - PARALLEL_ESCAPE_PLANES)
        {
            kept.push(i);
        }
    }
    *planes = kept.iter().map(|i| planes[*i]).collect();
}
