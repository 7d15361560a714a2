//! Planes for what is near and does not meet.
//!
//! The nearest pair of triangles gives a plane; every other pair that this plane holds apart as well is explained by it and
//! dropped; the nearest of the rest gives the next. Between two bulging surfaces one plane explains all, however many
//! triangles they have.

use crate::bounds::{Aabb, Point};
use crate::contacts::vector::{add, along, dot, norm, normal, scaled, square_to_segment, sub, unit};
use crate::contacts::zones::{IdMap, MOCKUP, TOOL};
use crate::contacts::{ContactPlane, Ground, MOST_PLANES};
use crate::proximity::Gap;

/// Share of the margin by which a pair may miss a plane and still count as explained.
const TOLERANCE: f64 = 0.01;

/// Cosine of the angle within which planes of a hollow surface are one: 12 degrees.
pub(crate) const SAME_DIRECTION: f64 = 0.978;

/// Sine of the same.
const SAME_TURN: f64 = 0.208;

/// A step down to a neighbouring pair counts from this slope on: along a hollow surface around the tool the distance changes
/// slowly, and each direction is to have its plane.
const SLOPE: f64 = 0.2;

/// Most pairs looked at around a corner.
const MOST_BESIDE: usize = 256;

/// A plane that a triangle's own differs from by less (1 - cosine) is that triangle's: normals then do not depend on rounding.
const SNAP: f64 = 1e-10;

/// Adds planes for the pairs `all[meeting..]` of one part (nearest first), beside the planes the part has from `from` on in
/// `out`; those before `meeting` meet. `is_behind` tells pairs of a tool triangle that is wholly inside.
pub(crate) fn push_planes(
    ground: &Ground<'_>,
    all: &[Gap],
    meeting: usize,
    is_behind: &dyn Fn(&Gap) -> bool,
    margin: f64,
    from: usize,
    out: &mut Vec<ContactPlane>,
) {
    let tolerance = TOLERANCE * margin;
    let is_open = |gap: &Gap, planes: &[ContactPlane]| !planes.iter().any(|p| is_explained(p, gap, tolerance));
    let mut near: Vec<u32> = (meeting..all.len()).map(|i| i as u32).collect();
    near.retain(|i| is_open(&all[*i as usize], &out[from..]));
    let mut slopes = Slopes { ground, all, places: IdMap::default() };
    let mut next = 0;
    while next < near.len() && out.len() - from < MOST_PLANES {
        let first = all[near[next] as usize];
        next += 1;
        if is_behind(&first) || !is_in_front(ground, &first) || out.len() > from && slopes.lead_down(&first) {
            continue;
        }
        let mut plane = plane_of(ground, &first);
        let mut place = Aabb::EMPTY;
        let beside = near[next - 1..].iter().map(|i| &all[*i as usize]);
        for gap in beside.take_while(|g| g.distance <= first.distance + 1e-6 * margin) {
            let way = sub(&gap.on_tool, &gap.on_mockup);
            if dot(&way, &plane.normal) >= gap.distance * (1.0 - 1e-9) {
                place.grow(&gap.on_mockup);
                plane.tool_triangles.push(gap.tool_triangle);
                plane.mockup_triangles.push(gap.mockup_triangle);
            }
        }
        if !place.is_empty() {
            let middle = scaled(&add(&place.lower, &place.upper), 0.5);
            plane.point = along(&middle, dot(&sub(&plane.point, &middle), &plane.normal), &plane.normal);
        }
        near.drain(..next);
        next = 0;
        near.retain(|i| is_open(&all[*i as usize], std::slice::from_ref(&plane)));
        out.push(plane);
    }
}

/// Slopes of the distance from one pair to the pairs beside it.
struct Slopes<'a> {
    ground: &'a Ground<'a>,
    all: &'a [Gap],
    /// Where each pair is among `all`; made when first needed.
    places: IdMap<(u32, u32)>,
}

impl Slopes<'_> {
    /// Whether a step to a neighbouring triangle, on either side, leads clearly down: then the pair is on the slope of another
    /// place, which has its plane or will.
    fn lead_down(&mut self, gap: &Gap) -> bool {
        if self.places.is_empty() {
            let key = |g: &Gap| (g.tool_triangle, g.mockup_triangle);
            self.places = self.all.iter().zip(0..).map(|(g, i)| (key(g), i)).collect();
        }
        let start = (gap.tool_triangle, gap.mockup_triangle);
        let mut seen = vec![start];
        let mut next = 0;
        while next < seen.len() && seen.len() <= MOST_BESIDE {
            let (t, m) = seen[next];
            next += 1;
            let beside_t = self.ground.adjacency[TOOL].neighbours[t as usize].map(|n| (n, m));
            let beside_m = self.ground.adjacency[MOCKUP].neighbours[m as usize].map(|n| (t, n));
            for key in beside_t.into_iter().chain(beside_m) {
                let Some(i) = self.places.get(&key).filter(|_| !seen.contains(&key)) else { continue };
                let other = &self.all[*i as usize];
                let step = norm(&sub(&other.on_tool, &gap.on_tool)).max(norm(&sub(&other.on_mockup, &gap.on_mockup)));
                if gap.distance - other.distance > SLOPE * step + 1e-9 * gap.distance {
                    return true;
                }
                let noise = (1e-9 * gap.distance).powi(2);
                let passes = |w: usize, id: u32, p: &Point| {
                    let t = self.ground.triangle(w, id);
                    (0..3).any(|k| square_to_segment(p, &t[k], &t[(k + 1) % 3]) <= noise)
                };
                if (key.0 == t || passes(TOOL, key.0, &gap.on_tool))
                    && (key.1 == m || passes(MOCKUP, key.1, &gap.on_mockup))
                {
                    // It has the same corner or edge: look around that.
                    seen.push(key);
                }
            }
        }
        false
    }
}

/// Whether the tool's point is on the outer side of the mock-up's triangle, as far as that is known.
fn is_in_front(ground: &Ground<'_>, gap: &Gap) -> bool {
    let corners = ground.mockup_triangle(gap.mockup_triangle);
    let outward = f64::from(ground.adjacency[1].outward[gap.mockup_triangle as usize]);
    let way = sub(&gap.on_tool, &gap.on_mockup);
    normal(&corners).is_none_or(|n| outward * dot(&n, &way) >= -1e-3 * gap.distance)
}

/// Whether the plane holds the pair apart by no less than it claims.
fn is_explained(plane: &ContactPlane, gap: &Gap, tolerance: f64) -> bool {
    let from = sub(&gap.on_mockup, &plane.point);
    let height = dot(&from, &plane.normal);
    let above = dot(&sub(&gap.on_tool, &plane.point), &plane.normal);
    if height <= tolerance && above >= plane.gap - tolerance {
        return true;
    }
    let way = sub(&gap.on_tool, &gap.on_mockup);
    dot(&way, &plane.normal) >= SAME_DIRECTION * gap.distance
        && gap.distance >= plane.gap
        && height.abs() <= SAME_TURN * norm(&from) + tolerance
}

fn plane_of(ground: &Ground<'_>, gap: &Gap) -> ContactPlane {
    let way = sub(&gap.on_tool, &gap.on_mockup);
    let own = |t| normal(&t).map(|n| if dot(&n, &way) < 0.0 { scaled(&n, -1.0) } else { n });
    let of_mockup: Option<Point> = own(ground.mockup_triangle(gap.mockup_triangle));
    let of_tool: Option<Point> = own(ground.tool_triangle(gap.tool_triangle));
    let direct = unit(&way).or(of_mockup).unwrap_or([0.0, 0.0, 1.0]);
    // The direction between points that are almost one says little; the planes then say it all.
    let noise = 1e-9 + 1e-13 * gap.on_mockup.iter().fold(0.0f64, |m, x| m.max(x.abs())) / gap.distance;
    let snapped = [of_mockup, of_tool].into_iter().flatten().find(|n| 1.0 - dot(n, &direct) <= SNAP.max(noise * noise));
    ContactPlane {
        point: gap.on_mockup,
        normal: snapped.unwrap_or(direct),
        gap: gap.distance,
        part: gap.part,
        tool_triangles: Vec::new(),
        mockup_triangles: Vec::new(),
        certain: true,
    }
}
