//! Parts of several pieces, solids with their hollows and open surfaces: which pieces the other part contains, and what
//! is left without them.

use std::sync::Arc;

use feeler_core::clash::solids::{Solid, Solids};
use feeler_core::constants::NONE;
use feeler_core::geometry::vectors::{add, along, cross, dot, length, scaled, sub};
use feeler_core::{Aabb, Point};

use crate::point_depth::body::{distance_to, Body};
use crate::point_depth::depth::{is_deeper, is_deeper_from, is_holding};

/// Some triangles of a part, and the box around them.
struct Piece {
    triangles: Vec<u32>,
    bounds: Aabb,
    /// Whether it is a closed surface around material, and no hollow or open surface.
    is_solid: bool,
    /// The triangles of each of its hollows.
    hollows: Vec<Vec<u32>>,
}

/// Whether one of two parts has several solids, and a solid of the one is in the same place as one of the other.
pub fn may_share_solids(solids: &Solids<'_>, parts: [u32; 2], rounding: f64) -> bool {
    let [p, q] = parts.map(|part| solids.of(part));
    let mut own: Vec<&Aabb> = p.shells().iter().map(|shell| &shell.bounds).collect();
    let others = q.shells();
    if own.is_empty() || others.is_empty() || own.len() + others.len() < 3 {
        return false;
    }
    own.sort_unstable_by(|a, b| a.lower[0].total_cmp(&b.lower[0]));
    others.iter().any(|shell| {
        let low = shell.bounds.lower[0];
        let from = own.partition_point(|other| other.lower[0] < low - rounding);
        let near = own[from..].iter().take_while(|other| other.lower[0] <= low + rounding);
        near.into_iter().any(|other| is_in(other, &shell.bounds, rounding) && is_in(&shell.bounds, other, rounding))
    })
}

/// What makes a piece contained, metres.
#[derive(Debug, Clone, Copy)]
pub struct HoldLimits {
    /// How far pieces of the other part may stick out of each, since its surface is uneven.
    pub within: [f64; 2],
    /// How deep solids are in each at least; a solid that is in both parts, how thick.
    pub least: [f64; 2],
    /// How deep open surfaces are at least.
    pub contact: f64,
}

/// Two parts without the pieces that the other one contains, and without what is far from the other; `None` for a part that keeps all of its
/// pieces. `bodies`: those of the parts. `has_sheets`: whether open surfaces may be contained, too.
pub fn without_contained(
    solids: &Solids<'_>,
    parts: [u32; 2],
    bodies: [&Body; 2],
    limits: &HoldLimits,
    has_sheets: bool,
) -> Option<[Option<Body>; 2]> {
    let of = |i: usize| solids.of(parts[i]);
    let box_of = |i: usize| &solids.mockup().part_bounds()[parts[i] as usize];
    let is_single = |i: usize| of(i).shells().len() + of(i).open_surfaces().take(2).count() < 2;
    let may_be_held = |i: usize| {
        let is_within = |bounds: &Aabb| is_in(bounds, box_of(1 - i), limits.within[1 - i]);
        let is_sheet_within = |own: u32| is_within(&Aabb::of_triangle(&of(i).triangle(own)));
        of(i).shells().iter().any(|shell| is_within(&shell.bounds))
            || has_sheets && of(i).open_surfaces().any(is_sheet_within)
    };
    if is_single(0) && is_single(1) {
        return None;
    }
    let left = [0, 1].map(|i| {
        if !may_be_held(i) {
            return None;
        }
        let (solid, other, within, least) = (of(i), bodies[1 - i], limits.within[1 - i], limits.least[1 - i]);
        let (mut left, mut is_whole) = (Vec::new(), true);
        for piece in pieces(&solid) {
            if !piece.bounds.is_overlapping(box_of(1 - i)) {
                continue;
            }
            let contains = || {
                let body = body_of(&solid, &piece.triangles);
                let is_deep_in_both =
                    |p: Point| body.closest(&sub(&p, body.origin()), least).is_none() && is_inside(other, &p);
                is_holding([&body, other], within)
                    && match piece.is_solid {
                        true => is_deeper([&body, other], least) || point_within(&body).is_some_and(is_deep_in_both),
                        false => is_deeper_from([&body, other], limits.contact),
                    }
            };
            if is_in(&piece.bounds, box_of(1 - i), within) && (piece.is_solid || has_sheets) && contains() {
                is_whole = false;
            } else {
                left.extend(piece.triangles);
            }
        }
        (!is_whole).then(|| body_of(&solid, &left))
    });
    left.iter().any(Option::is_some).then_some(left)
}

/// Whether a solid of one of two parts, of which no triangles cross, is inside the other. `bodies`: those of the parts.
pub fn is_solid_inside(solids: &Solids<'_>, parts: [u32; 2], bodies: [&Body; 2]) -> bool {
    (0..2).any(|i| {
        let (solid, box_of_other) = (solids.of(parts[i]), &solids.mockup().part_bounds()[parts[1 - i] as usize]);
        let is_near = |piece: &&Piece| piece.is_solid && piece.bounds.is_overlapping(box_of_other);
        pieces(&solid).iter().filter(is_near).any(|piece| {
            let body = body_of(&solid, &piece.triangles);
            let corner = || add(&body.triangle(0)[0], body.origin());
            is_inside(bodies[1 - i], &point_within(&body).unwrap_or_else(corner))
        })
    })
}

/// The open surfaces of a part.
pub fn sheets_of(solids: &Solids<'_>, part: u32) -> Body {
    let solid = solids.of(part);
    let is_open = |own: &u32| solid.adjacency().outward[*own as usize] == 0;
    body_of(&solid, &solid.triangles().filter(is_open).collect::<Vec<_>>())
}

/// Whether a solid of one of two closed parts, of which no triangles cross, is filled by the other beyond a hollow: the wall of the hollow
/// is inside the other, and its outer surface is not, by more than `within`, metres. `bodies`: makes those of the parts.
pub fn is_overfilled(
    solids: &Solids<'_>,
    parts: [u32; 2],
    within: f64,
    bodies: impl FnOnce() -> [Arc<Body>; 2],
) -> bool {
    let box_of = |i: usize| &solids.mockup().part_bounds()[parts[i] as usize];
    let may_be = |i: usize| {
        let solid = solids.of(parts[i]);
        let shells = solid.shells();
        shells.len() > 1 && shells.iter().any(|shell| is_in(&shell.bounds, box_of(1 - i), 0.0))
    };
    let asked: Vec<usize> = (0..2).filter(|i| may_be(*i)).collect();
    if asked.is_empty() {
        return false;
    }
    let bodies = bodies();
    asked.into_iter().any(|i| {
        let (solid, other) = (solids.of(parts[i]), &*bodies[1 - i]);
        pieces(&solid).iter().any(|piece| {
            let is_filled = |hollow: &Vec<u32>| is_deeper_from([&body_of(&solid, hollow), other], within);
            piece.is_solid
                && piece.hollows.iter().any(is_filled)
                && !is_holding([&body_of(&solid, &piece.triangles), other], within)
        })
    })
}

/// A part by its solids, each with its hollows, and what else it has.
fn pieces(solid: &Solid<'_>) -> Vec<Piece> {
    let mut left: Vec<bool> = vec![false; solid.adjacency().neighbours.len()];
    solid.triangles().for_each(|own| left[own as usize] = true);
    let (mut found, mut hollows) = (Vec::new(), Vec::new());
    for shell in solid.shells() {
        let triangles = connected(solid, shell.first, &mut left);
        let is_solid = six_volumes(solid, &triangles) > 0.0;
        let piece = Piece { triangles, bounds: shell.bounds, is_solid, hollows: Vec::new() };
        (if is_solid { &mut found } else { &mut hollows }).push(piece);
    }
    for hollow in hollows {
        let corner = hollow.triangles.first().map(|own| solid.triangle(*own)[0]);
        let around = |piece: &&mut Piece| {
            is_in(&hollow.bounds, &piece.bounds, 0.0)
                && corner.is_some_and(|p| is_inside(&body_of(solid, &piece.triangles), &p))
        };
        // The innermost one.
        let size = |piece: &&mut Piece| piece.bounds.longest();
        let holder = found.iter_mut().filter(|piece| piece.is_solid).filter(around);
        match holder.min_by(|a, b| size(a).total_cmp(&size(b))) {
            Some(holder) => {
                holder.triangles.extend(&hollow.triangles);
                holder.hollows.push(hollow.triangles);
            }
            None => found.push(hollow),
        }
    }
    let mut add_open = |triangles: Vec<u32>| {
        let bounds = triangles.iter().map(|own| Aabb::of_triangle(&solid.triangle(*own)));
        let bounds = bounds.fold(Aabb::EMPTY, |all, own| all.union(&own));
        found.push(Piece { triangles, bounds, is_solid: false, hollows: Vec::new() });
    };
    for first in solid.open_surfaces() {
        add_open(connected(solid, first, &mut left));
    }
    let rest: Vec<u32> = solid.triangles().filter(|own| left[*own as usize]).collect();
    if !rest.is_empty() {
        add_open(rest);
    }
    found
}

/// The triangles that hang together with one over edges, among those that are left, which they then are not any more.
fn connected(solid: &Solid<'_>, first: u32, left: &mut [bool]) -> Vec<u32> {
    let (mut found, mut next) = (Vec::new(), vec![first]);
    while let Some(own) = next.pop() {
        if std::mem::take(&mut left[own as usize]) {
            found.push(own);
            next.extend(solid.adjacency().neighbours[own as usize].iter().filter(|beside| **beside != NONE));
        }
    }
    found
}

/// Six times the volume that a closed surface takes up; negative of a hollow.
fn six_volumes(solid: &Solid<'_>, triangles: &[u32]) -> f64 {
    let Some(origin) = triangles.first().map(|own| solid.triangle(*own)[0]) else { return 0.0 };
    let of = |own: &u32| {
        let [a, b, c] = solid.triangle(*own).map(|p| sub(&p, &origin));
        f64::from(solid.adjacency().outward[*own as usize]) * dot(&a, &cross(&b, &c))
    };
    triangles.iter().map(of).sum()
}

fn body_of(solid: &Solid<'_>, triangles: &[u32]) -> Body {
    Body::new(triangles.iter().map(|own| (*own, solid.triangle(*own))), solid.adjacency())
}

/// A point in the material of a solid, in the world: halfway through it from its largest triangle.
fn point_within(body: &Body) -> Option<Point> {
    let area = |i: &u32| {
        let [a, b, c] = body.triangle(*i);
        length(&cross(&sub(b, a), &sub(c, a)))
    };
    let largest = (0..body.len() as u32).max_by(|i, j| area(i).total_cmp(&area(j)))?;
    let inward = scaled(&body.outward(largest)?, -1.0);
    let [a, b, c] = body.triangle(largest);
    let middle: Point = std::array::from_fn(|k| (a[k] + b[k] + c[k]) / 3.0);
    let end = along(&middle, 2.0 * body.bounds().longest(), &inward);
    let mut until = f64::INFINITY;
    body.tree().find_on_segment([&middle, &end], body.rounding(), |i| {
        let [x, y, z, offset] = *body.plane(i);
        let (height, rate) = (dot(&[x, y, z], &middle) - offset, dot(&[x, y, z], &inward));
        let way = -height / rate;
        let is_beyond = i != largest && way > 4.0 * body.rounding() && way < until;
        if is_beyond && distance_to(&along(&middle, way, &inward), body.triangle(i)) <= 4.0 * body.rounding() {
            until = way;
        }
        None::<()>
    });
    let p = add(&along(&middle, 0.5 * until, &inward), body.origin());
    (until < f64::INFINITY && is_inside(body, &p)).then_some(p)
}

fn is_inside(body: &Body, p: &Point) -> bool {
    body.is_inside(&sub(p, body.origin())) == Some(true)
}

/// Whether a box is in another but for rounding.
pub fn is_in(p: &Aabb, q: &Aabb, rounding: f64) -> bool {
    (0..3).all(|a| p.lower[a] >= q.lower[a] - rounding && p.upper[a] <= q.upper[a] + rounding)
}
