//! The relation of two parts: by exact signs if nothing crosses, else by the depth by points.

use std::sync::Arc;

use feeler_core::clash::asked::in_order;
use feeler_core::clash::holding::Held;
use feeler_core::clash::solids::Solids;
use feeler_core::clash::touch::Touching;
use feeler_core::geometry::intersect_triangle_triangle::intersect_triangle_triangle;
use feeler_core::geometry::vectors::sub;
use feeler_core::{Aabb, PairLimits};

use super::copies::are_copies;
use super::held_solids::{
    is_in, is_overfilled, is_solid_inside, may_share_solids, sheets_of, without_contained, HoldLimits,
};
use super::obvious::is_through;
use super::row::Verdict;
use crate::constants::SEAM_EXCESS;
use crate::point_depth::bodies::Bodies;
use crate::point_depth::body::Body;
use crate::point_depth::crossing::crossing_depth;
use crate::point_depth::depth::{is_deeper, is_deeper_from, is_holding, is_same_surface, PointDepth};
use crate::point_depth::walls::are_walls_clashing;

/// How two parts collide, by exact signs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Relation {
    /// They have the same triangles.
    Duplicate,
    Crossing,
    Touching(Touching),
    /// Nothing meets, and one holds the other.
    Held,
}

/// Two parts, their collision and their relation.
#[derive(Debug, Clone, Copy)]
pub struct Related {
    pub parts: [u32; 2],
    pub relation: Relation,
    /// `None`: both are open, and the depth of their crossing decides.
    pub verdict: Option<Verdict>,
}

/// Decides on pairs of parts.
#[derive(Debug, Clone, Copy)]
pub struct Judge<'a> {
    pub solids: &'a Solids<'a>,
    pub limits: &'a PairLimits,
    pub bodies: &'a Bodies,
}

impl Judge<'_> {
    /// The bodies of two parts.
    pub fn bodies_of(&self, parts: [u32; 2]) -> [Arc<Body>; 2] {
        parts.map(|part| {
            self.bodies.of(part, || {
                let solid = self.solids.of(part);
                Body::new(solid.triangles().map(|own| (own, solid.triangle(own))), solid.adjacency())
            })
        })
    }

    /// The relation of two parts; `crossing`: two of their triangles that cross, if any do. Parts that go through a gap cross, too.
    pub fn judge(&self, parts: [u32; 2], relation: Relation, crossing: Option<[u32; 2]>) -> Related {
        let may_be = matches!(relation, Relation::Touching(_) | Relation::Held);
        let relation = if may_be && self.is_through_a_gap(parts) { Relation::Crossing } else { relation };
        Related { parts, relation, verdict: self.verdict(parts, relation, crossing) }
    }

    /// A part that another holds without meeting it. Where it may go through a gap, it has to be deeper than gaps make doubtful.
    pub fn held(&self, held: &Held) -> Option<Related> {
        let parts = in_order([held.part, held.by]);
        if !held.is_through {
            return Some(self.judge(parts, Relation::Held, None));
        }
        let is_deep = || {
            let [a, b] = self.bodies_of(parts);
            let loose = a.looseness().max(b.looseness());
            is_deeper([&a, &b], self.limits.contact(parts[0], parts[1]).max(SEAM_EXCESS * SEAM_EXCESS * loose))
        };
        (self.is_through_a_gap(parts) && is_deep()).then(|| self.judge(parts, Relation::Crossing, None))
    }

    /// Whether one of two parts meets what fills a gap of the other.
    fn is_through_a_gap(&self, parts: [u32; 2]) -> bool {
        [parts, [parts[1], parts[0]]].into_iter().any(|[part, other]| {
            let bounds = &self.solids.mockup().part_bounds()[other as usize];
            let near = self.solids.fillings(part).iter().filter(|t| Aabb::of_triangle(t).is_overlapping(bounds));
            let mut near = near.peekable();
            near.peek().is_some() && {
                let [body, _] = self.bodies_of([other, part]);
                near.any(|filling| {
                    let t = filling.map(|p| sub(&p, body.origin()));
                    let meets = |i| intersect_triangle_triangle(body.triangle(i), &t).map(drop);
                    body.find_overlapping(&Aabb::of_triangle(&t), meets).is_some()
                })
            }
        })
    }

    fn verdict(&self, parts: [u32; 2], relation: Relation, crossing: Option<[u32; 2]>) -> Option<Verdict> {
        if relation == Relation::Duplicate || self.is_same(parts) {
            return Some(Verdict::Duplicate);
        }
        if crossing.is_some_and(|triangles| self.is_obvious(parts, triangles)) {
            return Some(Verdict::Clash);
        }
        match relation {
            Relation::Held | Relation::Touching(Touching::Holding | Touching::Held) => Some(self.of_held(parts)),
            Relation::Touching(Touching::Beside) if self.has_inside(parts) => Some(self.of_touching(parts)),
            _ => self.of_crossing(parts),
        }
    }

    /// Parts that are outside each other, but for solids that are in both.
    fn of_touching(&self, parts: [u32; 2]) -> Verdict {
        let may_share = may_share_solids(self.solids, parts, self.filed(parts));
        may_share.then(|| self.of_pieces(parts, false)).flatten().unwrap_or(Verdict::Contact)
    }

    /// The gravest verdict of the pieces of two parts, where the other part contains some. `has_sheets`: whether these may be open surfaces.
    fn of_pieces(&self, parts: [u32; 2], has_sheets: bool) -> Option<Verdict> {
        let bodies = self.bodies_of(parts);
        let whole = [&*bodies[0], &*bodies[1]];
        let limits = self.hold_limits(parts, whole);
        let left = without_contained(self.solids, parts, whole, &limits, has_sheets)?;
        let left = [0, 1].map(|i| left[i].as_ref().unwrap_or(whole[i]));
        Some(if self.is_clashing(parts, left) { Verdict::Clash } else { Verdict::Contained })
    }

    /// Whether two bodies are deeper in each other than contact allows, or clash as thin walls.
    fn is_clashing(&self, parts: [u32; 2], bodies: [&Body; 2]) -> bool {
        let (rounding, contact) = (self.limits.rounding(parts[0], parts[1]), self.limits.contact(parts[0], parts[1]));
        is_deeper(bodies, contact) || contact > rounding && are_walls_clashing(bodies, contact)
    }

    /// From where on one of two parts holds the other, or a piece of it. Loose seams make a surface as uneven as they are wide.
    fn hold_limits(&self, parts: [u32; 2], bodies: [&Body; 2]) -> HoldLimits {
        let (rounding, filed) = (self.limits.rounding(parts[0], parts[1]), self.filed(parts));
        let within = bodies.map(|body| filed.max(SEAM_EXCESS * body.looseness()));
        let least = within.map(|within| match within {
            _ if within > filed => SEAM_EXCESS * within,
            _ if filed > rounding => filed,
            _ => rounding,
        });
        HoldLimits { within, least, contact: self.limits.contact(parts[0], parts[1]) }
    }

    /// How deep the open surfaces of two parts cross that both have some; `None` where no part has closed ones besides.
    pub fn crossing_of_sheets(&self, parts: [u32; 2]) -> Option<PointDepth> {
        if !self.has_inside(parts) || !parts.iter().all(|part| self.has_sheets(*part)) {
            return None;
        }
        let [a, b] = self.bodies_of(parts);
        let [a, b] = [(a, parts[0]), (b, parts[1])].map(|(body, part)| match body.is_closed() {
            true => Arc::new(sheets_of(self.solids, part)),
            false => body,
        });
        Some(crossing_depth([&a, &b]))
    }

    fn has_sheets(&self, part: u32) -> bool {
        self.solids.of(part).open_surfaces().next().is_some()
    }

    /// How uneven rounding makes a surface, metres: in a file as much as copies may differ.
    fn filed(&self, parts: [u32; 2]) -> f64 {
        self.limits.rounding(parts[0], parts[1]).max(self.limits.copies_within(parts[0], parts[1]))
    }

    /// Whether one of two parts has an inside.
    fn has_inside(&self, parts: [u32; 2]) -> bool {
        parts.iter().any(|part| self.solids.of(*part).is_closed())
    }

    /// The verdict of parts of which one lies in the other by exact signs, or some of its pieces do. Open surfaces that are nowhere deeper
    /// than `contact` are in contact. A part that overfills a hollow of the other is not contained: it clashes.
    fn of_held(&self, parts: [u32; 2]) -> Verdict {
        let (within, contact) =
            (self.limits.copies_within(parts[0], parts[1]), self.limits.contact(parts[0], parts[1]));
        let are_closed = parts.map(|part| self.solids.of(part).is_closed());
        if are_closed == [true; 2] && is_overfilled(self.solids, parts, within, || self.bodies_of(parts)) {
            return self.of_overlap(parts);
        }
        let has_sheets = parts.map(|part| self.has_sheets(part));
        if are_closed == [true; 2] && has_sheets == [false; 2] {
            return Verdict::Contained;
        }
        let [a, b] = self.bodies_of(parts);
        let is_sheet_deep = |i: usize, other: &Body| {
            has_sheets[i] && is_deeper_from([&sheets_of(self.solids, parts[i]), other], contact)
        };
        let is_contained = match are_closed {
            [true, true] => {
                is_solid_inside(self.solids, parts, [&a, &b]) || is_sheet_deep(0, &b) || is_sheet_deep(1, &a)
            }
            _ => is_deeper([&a, &b], contact),
        };
        if is_contained {
            Verdict::Contained
        } else {
            Verdict::Contact
        }
    }

    /// Whether both surfaces are the same but for rounding, here or in a file.
    pub fn is_same(&self, parts: [u32; 2]) -> bool {
        let (rounding, within) =
            (self.limits.rounding(parts[0], parts[1]), self.limits.copies_within(parts[0], parts[1]));
        let [p, q] = self.boxes_of(parts);
        let is_near = |p: &f64, q: &f64| (p - q).abs() <= within;
        let is_candidate = p.lower.iter().zip(&q.lower).chain(p.upper.iter().zip(&q.upper)).all(|(p, q)| is_near(p, q));
        is_candidate && {
            let [a, b] = self.bodies_of(parts);
            within > rounding && are_copies([&a, &b], within) || is_same_surface([&a, &b], rounding)
        }
    }

    /// Whether two parts clash for all to see, where two of their triangles cross: the smaller one is closed, and points of the other on
    /// both sides of its surface are deeper than contact allows. None of both is inside the other, then.
    fn is_obvious(&self, parts: [u32; 2], triangles: [u32; 2]) -> bool {
        let [p, q] = self.boxes_of(parts);
        let rounding = self.limits.rounding(parts[0], parts[1]);
        // The surface whose points are on both sides, and the part: what may be inside the other must be the former.
        let is_first_smaller = self.solids.faces(parts[0]).len() <= self.solids.faces(parts[1]).len();
        let orders: &[[usize; 2]] = match (is_in(&p, &q, rounding), is_in(&q, &p, rounding)) {
            (true, _) => &[[0, 1]],
            (_, true) => &[[1, 0]],
            _ if is_first_smaller => &[[1, 0], [0, 1]],
            _ => &[[0, 1], [1, 0]],
        };
        let contact = self.limits.contact(parts[0], parts[1]);
        orders.iter().any(|[surface, part]| {
            let through = self.solids.mockup().mesh().triangle(triangles[*surface]);
            self.solids.is_cycle(parts[*part])
                && is_through(self.solids, &through, parts[*part], triangles[*part], [contact, rounding])
        })
    }

    fn of_crossing(&self, parts: [u32; 2]) -> Option<Verdict> {
        let (rounding, contact) = (self.limits.rounding(parts[0], parts[1]), self.limits.contact(parts[0], parts[1]));
        let [a, b] = self.bodies_of(parts);
        if !a.is_closed() && !b.is_closed() {
            return None;
        }
        if self.crossing_of_sheets(parts).is_some_and(|crossing| crossing.depth > contact) {
            return Some(Verdict::Clash);
        }
        let is_deep = is_deeper([&a, &b], contact);
        if is_deep && self.is_held(parts, [&a, &b]) {
            return Some(Verdict::Contained);
        }
        // No deeper than contact allows are solids in both parts, and thin ones that only rounding keeps from being contained.
        if is_deep || contact > rounding || may_share_solids(self.solids, parts, self.filed(parts)) {
            if let Some(verdict) = self.of_pieces(parts, is_deep) {
                return Some(verdict);
            }
        }
        let are_closed = a.is_closed() && b.is_closed();
        if !is_deep && are_closed && contact > rounding && self.is_held(parts, [&a, &b]) {
            return Some(Verdict::Contained);
        }
        let is_clashing = is_deep || contact > rounding && are_walls_clashing([&a, &b], contact);
        Some(if is_clashing { Verdict::Clash } else { Verdict::Contact })
    }

    /// Whether one of two parts holds all of the other.
    fn is_held(&self, parts: [u32; 2], [a, b]: [&Body; 2]) -> bool {
        let [p, q] = self.boxes_of(parts);
        let HoldLimits { within, least, .. } = self.hold_limits(parts, [a, b]);
        let is_in_other = |[p, q]: [&Aabb; 2], pair: [&Body; 2], holder: usize| {
            is_in(p, q, within[holder]) && is_holding(pair, within[holder]) && is_deeper(pair, least[holder])
        };
        is_in_other([&p, &q], [a, b], 1) || is_in_other([&q, &p], [b, a], 0)
    }

    /// Closed parts that share material, and of which none contains the other.
    fn of_overlap(&self, parts: [u32; 2]) -> Verdict {
        let [a, b] = self.bodies_of(parts);
        if self.is_clashing(parts, [&a, &b]) {
            Verdict::Clash
        } else {
            Verdict::Contact
        }
    }

    fn boxes_of(&self, parts: [u32; 2]) -> [Aabb; 2] {
        parts.map(|part| self.solids.mockup().part_bounds()[part as usize])
    }
}
