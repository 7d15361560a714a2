//! Planes for what is near and does not meet.
//!
//! The nearest pair of triangles gives a plane; every other pair that this plane holds apart as well is explained by it and
//! dropped; the nearest of the rest gives the next. Between two bulging surfaces one plane explains all, however many
//! triangles they have.

use crate::bounds::{Aabb, Point};
use crate::contacts::vector::{add, along, dot, norm, normal, scaled, sub, unit};
use crate::contacts::{ContactPlane, Ground};
use crate::proximity::Gap;

/// Share of the margin by which a pair may miss a plane and still count as explained.
const TOLERANCE: f64 = 0.01;

/// Cosine of the angle within which planes of a hollow surface are one: 12 degrees.
pub(crate) const SAME_DIRECTION: f64 = 0.978;

/// Sine of the same.
const SAME_TURN: f64 = 0.208;

/// A plane that a triangle's own differs from by less (1 - cosine) is that triangle's: normals then do not depend on rounding.
const SNAP: f64 = 1e-10;

/// Adds planes for `near`, the pairs of one part that do not meet, beside the planes the part has from `from` on in `out`.
pub(crate) fn push_planes(
    ground: &Ground<'_>,
    near: &mut Vec<Gap>,
    margin: f64,
    from: usize,
    limit: usize,
    out: &mut Vec<ContactPlane>,
) {
    let tolerance = TOLERANCE * margin;
    near.retain(|gap| is_in_front(ground, gap));
    for plane in &out[from..] {
        near.retain(|gap| !is_explained(plane, gap, tolerance));
    }
    while let Some(first) = near.iter().min_by(|a, b| a.order(b)).copied() {
        if out.len() - from >= limit {
            return;
        }
        let mut plane = plane_of(ground, &first);
        let mut place = Aabb::EMPTY;
        for gap in near.iter() {
            let as_near = gap.distance <= first.distance + 1e-6 * margin;
            let way = sub(&gap.on_tool, &gap.on_mockup);
            if as_near && dot(&way, &plane.normal) >= gap.distance * (1.0 - 1e-9) {
                place.grow(&gap.on_mockup);
                plane.tool_triangles.push(gap.tool_triangle);
                plane.mockup_triangles.push(gap.mockup_triangle);
            }
        }
        let middle = scaled(&add(&place.lower, &place.upper), 0.5);
        plane.point = along(&middle, dot(&sub(&plane.point, &middle), &plane.normal), &plane.normal);
        near.retain(|gap| !is_explained(&plane, gap, tolerance));
        // Rounding must not keep the pair that made the plane.
        near.retain(|gap| (gap.tool_triangle, gap.mockup_triangle) != (first.tool_triangle, first.mockup_triangle));
        out.push(plane);
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
