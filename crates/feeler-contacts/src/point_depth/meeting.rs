//! A point where the surfaces of two bodies cross, and whether a body is a thin wall or a needle there, whose middle the other's surface
//! goes through.

use feeler_core::geometry::vectors::{add, along, cross, dot, length, precise_normal, scaled, sub, unit};
use feeler_core::{Point, Triangle};

use super::body::Body;
use crate::constants::{
    LEAST_LEVEL, MIDDLE_REACH, MIDDLE_SLACK, MIDDLE_STEPS, NEEDLE_RAYS, NEEDLE_REACH, OPPOSITE_FACES,
    SECTION_SHRINKING, SECTION_STEPS, WALL_MIDDLE, WALL_REACH,
};

/// A point on the surfaces of two bodies.
#[derive(Debug, Clone, Copy)]
pub struct Meeting<'a> {
    pub bodies: [&'a Body; 2],
    /// The point in the frame of each.
    pub at: [Point; 2],
    /// The outward normal of each surface there.
    pub outward: [Point; 2],
}

impl Meeting<'_> {
    /// Whether a body is a wall here, at most this thick (metres): a face that looks the other way is behind its own, and the other's
    /// surface goes through the middle between the two. If this point is near a side of the wall, or the other's surface slants, that is
    /// aside of it.
    pub fn is_wall(&self, body: usize, thickness: f64) -> bool {
        let (outward, across) = (&self.outward[body], &self.outward[1 - body]);
        let reach = WALL_REACH * thickness;
        let behind = self.face_along(body, &[0.0; 3], &scaled(outward, -reach));
        let Some((opposite, hit)) = behind.filter(|(n, _)| dot(n, outward) <= OPPOSITE_FACES) else { return false };
        // Into the wall along the other's surface, to where both faces are as far.
        let Some(way) = unit(&along(&scaled(outward, -1.0), dot(outward, across), across)) else { return false };
        let far = dot(&opposite, &hit) / dot(&way, &sub(&opposite, outward));
        if !(far > 0.0 && far <= MIDDLE_REACH * thickness) {
            return false;
        }
        let mut p = scaled(&way, far);
        for _ in 0..MIDDLE_STEPS {
            let Some(q) = self.on_other(body, &p, reach).filter(|q| length(q) <= MIDDLE_REACH * thickness) else {
                return false;
            };
            let faces = [1.0, -1.0].map(|sense| self.face_along(body, &q, &scaled(outward, sense * reach)));
            let [Some((m, m_hit)), Some((n, n_hit))] = faces else { return false };
            let apart = dot(outward, &sub(&m, &n));
            if dot(&m, &n) > OPPOSITE_FACES || apart <= 0.0 {
                return false;
            }
            let [before, after] = [(&m, &m_hit), (&n, &n_hit)].map(|(n, hit)| dot(n, &sub(hit, &q)));
            let aside = (before - after) / apart;
            let (middle, half) = (along(&q, aside, outward), before - aside * dot(&m, outward));
            if half > 0.5 * thickness {
                return false;
            }
            if self.is_inside(body, &q, WALL_MIDDLE * half) {
                return true;
            }
            // Away from what else is near the middle.
            let Some(nearest) = self.bodies[body].closest(&add(&self.at[body], &middle), half) else {
                p = middle;
                continue;
            };
            let Some(off) = unit(&sub(&add(&self.at[body], &middle), &nearest.point)) else { return false };
            let level = along(&off, -dot(&off, outward), outward);
            let square = dot(&level, &level);
            p = if square > LEAST_LEVEL { along(&middle, (half - nearest.distance) / square, &level) } else { middle };
        }
        false
    }

    /// Whether a body is a needle here, at most this thick (metres): its face and two others enclose a section that becomes nowhere
    /// thicker, and the other's surface goes through the middle of it. Tips and edges are not needles, since they become thicker farther in.
    pub fn is_needle(&self, body: usize, thickness: f64) -> bool {
        let (outward, across) = (&self.outward[body], &self.outward[1 - body]);
        let reach = NEEDLE_REACH * thickness;
        let Some((first, behind)) = self.face_along(body, &[0.0; 3], &scaled(outward, -reach)) else { return false };
        // Opposite faces span no plane; the other's surface goes through both.
        let is_opposite = dot(outward, &first) <= OPPOSITE_FACES;
        let level = along(across, -dot(across, outward), outward);
        let Some(axis) = unit(&if is_opposite { level } else { cross(outward, &first) }) else { return false };
        let from = scaled(&behind, 0.5);
        let Some(axis) = self.axis_of_needle(body, &axis, &from, thickness) else { return false };
        // Whatever the planes of these faces say: beyond them the body may go on.
        let Some((middle, half)) = self.middle_of_section(body, &axis, &from, 0.5 * thickness) else { return false };
        let middle = along(&middle, -dot(across, &middle) / dot(across, &axis), &axis);
        let reached = self.on_other(body, &middle, MIDDLE_SLACK * half);
        reached.is_some_and(|q| self.is_inside(body, &q, WALL_MIDDLE * half))
    }

    /// The axis, equally inclined to the three, of faces that enclose a section so that no point is deeper behind all of them than half this
    /// thickness: the face here and two around a point in the section across a first axis. Of several such, the faces that taper the least.
    ///
    /// If weights that sum to 1 cancel the three normals, the weighted sum of a point's depths behind the faces is the same for all points.
    /// So it is the depth of the point that is equally deep behind all three, which is the deepest.
    fn axis_of_needle(&self, body: usize, axis: &Point, from: &Point, thickness: f64) -> Option<Point> {
        let outward = &self.outward[body];
        let (aside, reach) = (cross(axis, outward), NEEDLE_REACH * thickness);
        // Each face around as its normal, and how deep this point is behind it.
        let around: Vec<(Point, f64)> = (0..NEEDLE_RAYS)
            .filter_map(|n| {
                let (sine, cosine) = (std::f64::consts::TAU * f64::from(n) / f64::from(NEEDLE_RAYS)).sin_cos();
                let ray = add(&scaled(outward, reach * cosine), &scaled(&aside, reach * sine));
                let (normal, hit) = self.face_along(body, from, &ray)?;
                Some((normal, dot(&normal, &hit)))
            })
            .collect();
        let mut least = (0.5 * (1.0 + OPPOSITE_FACES), None);
        for (n, (p, p_depth)) in around.iter().enumerate() {
            for (q, q_depth) in &around[..n] {
                let Some(axis) = unit(&cross(&sub(p, outward), &sub(q, outward))) else { continue };
                let weights = [[p, q], [q, outward], [outward, p]].map(|[m, n]| dot(&axis, &cross(m, n)));
                let sum: f64 = weights.iter().sum();
                if sum == 0.0 || weights.iter().any(|weight| weight / sum <= 0.0) {
                    continue;
                }
                let [_, by_p, by_q] = weights.map(|weight| weight / sum);
                let taper = dot(&axis, outward);
                if taper * taper <= least.0 && by_p * p_depth + by_q * q_depth <= 0.5 * thickness {
                    least = (taper * taper, Some(axis));
                }
            }
        }
        least.1
    }

    /// The deepest point of the section across an axis through a point inside, found by ever smaller steps away from the surface, and its
    /// depth; `None` where that is more than `most`, metres.
    fn middle_of_section(&self, body: usize, axis: &Point, from: &Point, most: f64) -> Option<(Point, f64)> {
        let (mut p, mut deepest) = (*from, (*from, 0.0));
        let mut step = 0.5 * most;
        for _ in 0..SECTION_STEPS {
            let at = add(&self.at[body], &p);
            let nearest = self.bodies[body].closest(&at, most)?;
            let is_inside = self.bodies[body].is_inside(&at)?;
            if is_inside && nearest.distance > deepest.1 {
                deepest = (p, nearest.distance);
            }
            let off = if is_inside { sub(&at, &nearest.point) } else { sub(&nearest.point, &at) };
            let Some(way) = unit(&along(&off, -dot(&off, axis), axis)) else { break };
            p = along(&p, step, &way);
            step *= SECTION_SHRINKING;
        }
        Some(deepest)
    }

    /// The point of the other's surface that is closest to a point, if it is nearer than `within`, metres.
    fn on_other(&self, body: usize, p: &Point, within: f64) -> Option<Point> {
        let at = &self.at[1 - body];
        self.bodies[1 - body].closest(&add(at, p), within).map(|closest| sub(&closest.point, at))
    }

    /// Whether a point is inside a body, at least this far from its surface, metres.
    fn is_inside(&self, body: usize, p: &Point, least: f64) -> bool {
        let (body, p) = (self.bodies[body], add(&self.at[body], p));
        body.closest(&p, least).is_none() && body.is_inside(&p) == Some(true)
    }

    /// The outward normal of the first face that a ray meets from inside a body, and where, no farther than the ray is long. Points are
    /// relative to this one.
    fn face_along(&self, body: usize, from: &Point, ray: &Point) -> Option<(Point, Point)> {
        let (body, at) = (self.bodies[body], &self.at[body]);
        let (from, mut first) = (add(at, from), None);
        let end = add(&from, ray);
        let mut nearest = f64::INFINITY;
        body.tree().find_on_segment([&from, &end], body.rounding(), |i| {
            if let (Some(n), Some(hit)) = (body.outward(i), piercing([&from, &end], body.triangle(i), -body.rounding()))
            {
                let far = length(&sub(&hit, &from));
                if dot(&n, ray) > 0.0 && far < nearest {
                    (nearest, first) = (far, Some((n, sub(&hit, at))));
                }
            }
            None::<()>
        });
        first
    }
}

/// Where a segment goes through a triangle, no nearer to its border than `inset` (metres).
pub fn piercing([p, q]: [&Point; 2], t: &Triangle, inset: f64) -> Option<Point> {
    let n = precise_normal(t)?;
    let (h, k) = (dot(&n, &sub(p, &t[0])), dot(&n, &sub(q, &t[0])));
    if h * k >= 0.0 {
        return None;
    }
    let s = h / (h - k);
    let at: Point = std::array::from_fn(|a| p[a] + s * (q[a] - p[a]));
    is_within(&at, t, &n, inset).then_some(at)
}

/// Whether a point of the plane of a triangle is in it, no nearer to its border than `inset` (metres).
fn is_within(at: &Point, t: &Triangle, n: &Point, inset: f64) -> bool {
    (0..3).all(|i| {
        let side = sub(&t[(i + 1) % 3], &t[i]);
        dot(&cross(n, &side), &sub(at, &t[i])) >= inset * length(&side)
    })
}
