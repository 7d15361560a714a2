//! The proof that a part cannot come out: its neighbours leave it only some play.
//!
//! A point of the part over a triangle of a neighbour cannot get behind it without a collision, as long as it stays
//! over it. To first order that is a half space of the part's small motions (displacement and rotation: six numbers);
//! the intersection of all of them is the play. If it is bounded, and smaller than the motions for which all of this
//! holds, nothing leads out of it. A linear program gives the bound in each direction, and its multipliers (Farkas,
//! 1902) name the neighbours that hold the part.
//!
//! The proof has no tolerance: second-order and rounding errors are added. Its failure proves nothing: a part with much
//! play, or held by edges alone, may be held all the same.

use std::collections::BTreeSet;

use feeler_core::geometry::vectors::{add, cross, dot, length, scaled, sub, unit};
use feeler_core::{Point, Triangle};
use feeler_world::Surroundings;

use super::verify::HasTime;
use crate::constants::{HELD_WITHIN, LEAST_HELD_WITHIN, MOST_HELD_PAIRS, MOST_WIDENED};
use crate::error::Result;
use crate::linear_program::least_cost;

/// The parts that hold a part.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Held {
    /// The parts that hold it, by number.
    pub parts: Vec<u32>,
    /// No point of it can move farther than this, metres.
    pub play: f64,
}

/// Shows that it is held; `None` where that could not be shown, or there was no time for it.
pub fn held(around: &Surroundings, has_time: HasTime<'_>) -> Result<Option<Held>> {
    let (start, seated) = (around.start(), around.seated_at_start());
    for share in HELD_WITHIN {
        let within = (share * around.size()).max(LEAST_HELD_WITHIN);
        let mut pairs = Vec::new();
        for (body, scene, tool) in around.asked(&seated) {
            if !has_time() {
                return Ok(None);
            }
            let near = scene.near_pairs(tool, start, within)?;
            if pairs.len() + near.len() > MOST_HELD_PAIRS {
                return Ok(None);
            }
            let part = |part| around.environment().bodies[body].part_in_mockup(part);
            pairs.extend(near.iter().filter(|gap| gap.distance > 0.0).map(|gap| Facing {
                moving: tool.mesh().triangle(gap.tool_triangle).map(|corner| start.apply(&corner)),
                fixed: scene.mockup().mesh().triangle(gap.mockup_triangle),
                part: part(gap.part),
            }));
        }
        let small = SmallMotions { pairs, centre: start.apply(around.middle()), reach: 0.5 * around.size() };
        if let Some(held) = small.held(has_time) {
            return Ok(Some(held));
        }
    }
    Ok(None)
}

/// A triangle of the tool and one of a neighbour, world.
struct Facing {
    moving: Triangle,
    fixed: Triangle,
    part: u32,
}

/// A half space of small motions: those with `row . motion >= -gap`.
struct Wall {
    row: [f64; 6],
    gap: f64,
    part: u32,
}

/// Small motions of a part: how far its middle moves along the axes, and its turns about them, as the distance that the farthest corner moves, all in
/// metres.
struct SmallMotions {
    pairs: Vec<Facing>,
    /// Of the part's box, world.
    centre: Point,
    /// From the middle to the farthest corner, metres.
    reach: f64,
}

/// How far any point moves at most by a motion of which these are the most of its six numbers.
fn farthest(most: &[f64; 6]) -> f64 {
    length(&[most[0], most[1], most[2]]) + length(&[most[3], most[4], most[5]])
}

impl SmallMotions {
    /// Bounds to first order are widened until they are true with second order, and with points that stay over their triangles.
    fn held(&self, has_time: HasTime<'_>) -> Option<Held> {
        let mut most = self.bounds(&[0.0; 6], has_time)?.0;
        for _ in 0..MOST_WIDENED {
            most = most.map(|bound| 1.15 * bound + self.rounding());
            let (bounds, parts) = self.bounds(&most, has_time)?;
            if bounds.iter().zip(&most).all(|(bound, most)| *bound < 0.999 * most) {
                return Some(Held { parts: parts.into_iter().collect(), play: farthest(&bounds) });
            }
            most = std::array::from_fn(|i| bounds[i].max(most[i]));
        }
        None
    }

    /// Error bound of a height.
    fn rounding(&self) -> f64 {
        1e-12 * (self.reach + length(&self.centre))
    }

    /// What the pairs leave of motions of which none of the six numbers is more than `most`, and the parts that leave no more. `None`: it is
    /// not bounded, or there is no time.
    ///
    /// By a linear program for each of the six numbers, both ways: the upper bound is the dual's least cost.
    fn bounds(&self, most: &[f64; 6], has_time: HasTime<'_>) -> Option<([f64; 6], BTreeSet<u32>)> {
        let walls = self.walls(most);
        let rows: Vec<[f64; 6]> = walls.iter().map(|wall| wall.row).collect();
        let gaps: Vec<f64> = walls.iter().map(|wall| wall.gap).collect();
        let (mut parts, mut bounds) = (BTreeSet::new(), [0.0_f64; 6]);
        for axis in 0..6 {
            for sense in [1.0, -1.0] {
                let right: [f64; 6] = std::array::from_fn(|i| if i == axis { -sense } else { 0.0 });
                if !has_time() {
                    return None;
                }
                let multipliers = least_cost(&rows, &gaps, &right)?;
                let sum = |of: &dyn Fn(usize) -> f64| multipliers.iter().map(|(wall, x)| of(*wall) * x).sum::<f64>();
                let off: f64 = (0..6).map(|i| (sum(&|wall| rows[wall][i]) - right[i]).abs() * most[i]).sum();
                let bound = sum(&|wall| gaps[wall]) + off;
                if !bound.is_finite() {
                    return None;
                }
                bounds[axis] = bounds[axis].max(bound);
                parts.extend(multipliers.iter().map(|(wall, _)| walls[*wall].part));
            }
        }
        Some((bounds, parts))
    }

    /// What the triangles do to each other.
    fn walls(&self, most: &[f64; 6]) -> Vec<Wall> {
        let far = farthest(most);
        // Of a turn: half the square of its angle, and its product with a displacement where points are seen from the part. These are at
        // most 3/4 of this.
        let second_order = far * far / self.reach;
        let mut walls = Vec::new();
        for Facing { moving, fixed, part } in &self.pairs {
            for (points, plane, sense) in [(moving, fixed, 1.0), (fixed, moving, -1.0)] {
                let [a, b, c] = plane;
                let Some(normal) = unit(&cross(&sub(b, a), &sub(c, a))) else { continue };
                for point in over(points, plane, &normal, 1.1 * far) {
                    let height = dot(&normal, &sub(&point, a));
                    if height.abs() <= self.rounding() {
                        continue; // On which side it is is not known.
                    }
                    let normal = scaled(&normal, sense * height.signum());
                    let turn = scaled(&cross(&sub(&point, &self.centre), &normal), 1.0 / self.reach);
                    let row = [normal[0], normal[1], normal[2], turn[0], turn[1], turn[2]];
                    walls.push(Wall { row, gap: height.abs() + second_order + self.rounding(), part: *part });
                }
            }
        }
        walls
    }
}

/// Corners of what of a triangle is over another (along the normal of that one's plane), `inside` of its edges (metres).
fn over(points: &Triangle, plane: &Triangle, normal: &Point, inside: f64) -> Vec<Point> {
    let mut polygon = points.to_vec();
    for i in 0..3 {
        let (from, to) = (plane[i], plane[(i + 1) % 3]);
        let Some(inwards) = unit(&cross(normal, &sub(&to, &from))) else { return Vec::new() };
        let beyond = |point: &Point| dot(&inwards, &sub(point, &from)) - inside;
        let mut kept = Vec::with_capacity(polygon.len() + 1);
        for (k, point) in polygon.iter().enumerate() {
            let next = &polygon[(k + 1) % polygon.len()];
            let (here, there) = (beyond(point), beyond(next));
            if here >= 0.0 {
                kept.push(*point);
            }
            if (here >= 0.0) != (there >= 0.0) {
                let cut = add(point, &scaled(&sub(next, point), here / (here - there)));
                kept.push(cut);
            }
        }
        polygon = kept;
        if polygon.is_empty() {
            break;
        }
    }
    polygon
}

#[cfg(test)]
mod tests {
    use super::*;
    use feeler_shapes::box_mesh;

    fn triangles(lower: Point, upper: Point) -> Vec<Triangle> {
        let middle = std::array::from_fn(|a| 0.5 * (lower[a] + upper[a]));
        let (vertices, faces) = box_mesh(middle, std::array::from_fn(|a| upper[a] - lower[a]), 1);
        faces.iter().map(|face| face.map(|corner| vertices[corner as usize])).collect()
    }

    /// A plate turns farther within its play than to first order: as it turns its long side gets shorter.
    #[test]
    fn bounds_have_room_for_what_is_of_second_order() {
        let (half, play) = ([0.02, 0.012, 0.005], 4e-4);
        let plate = triangles(half.map(|x| -x), half);
        let mut pairs = Vec::new();
        for side in 0..6 {
            let (axis, outside) = (side / 2, side & 1);
            let mut ends = [half.map(|x| -x - 0.02), half.map(|x| x + 0.02)];
            ends[1 - outside][axis] = if outside == 1 { half[axis] + play } else { -half[axis] - play };
            for fixed in triangles(ends[0], ends[1]) {
                pairs.extend(plate.iter().map(|moving| Facing { moving: *moving, fixed, part: side as u32 }));
            }
        }
        let small = SmallMotions { pairs, centre: [0.0; 3], reach: length(&half) };
        // In the plane of its two longer sides, by halving: 20 sin(t) + 12 cos(t) = 12 + play.
        let (mut free, mut met) = (0.0_f64, 0.2_f64);
        for _ in 0..60 {
            let turn = 0.5 * (free + met);
            if half[0] * turn.sin() + half[1] * turn.cos() <= half[1] + play {
                free = turn;
            } else {
                met = turn;
            }
        }
        assert!(free > 1.005 * play / half[0] && free < 0.02 + 2e-3);
        let most = small.bounds(&[0.0; 6], &|| true).unwrap().0.map(|bound| 1.15 * bound);
        let (bounds, parts) = small.bounds(&most, &|| true).unwrap();
        assert!(bounds[5] >= free * small.reach, "{} is less than {}", bounds[5], free * small.reach);
        assert_eq!(parts.len(), 6);
    }
}
