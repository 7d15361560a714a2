//! A way out by trial, where contact planes show none: along many directions, ever farther, until the tool is free.

use crate::bounds::Point;
use crate::contacts::gaps::is_in_front;
use crate::contacts::Ground;
use crate::pose::Pose;
use crate::proximity::Gap;
use crate::scene::Scene;
use crate::tool::Tool;
use crate::vectors::{add, along, cross, scaled, unit};

/// The first length that is tried, as a share of the longest, and by what each length is longer than the one before.
const FIRST: f64 = 1.0 / 1024.0;
const STEP: f64 = 1.5;

/// Times that the span between a length that frees the tool and one that does not is halved.
const HALVINGS: usize = 8;

/// By how much a way is turned (tangent) to find a shorter one, to which sides, how often at most, and the share by which it must be
/// shorter.
const TURNS: [f64; 4] = [0.5, 0.25, 0.12, 0.06];
const SIDES: [[f64; 2]; 6] = [[1.0, 0.0], [0.5, HIGH], [-0.5, HIGH], [-1.0, 0.0], [-0.5, -HIGH], [0.5, -HIGH]];
const HIGH: f64 = 0.866_025_403_784_438_6; // the sine of 60 degrees
const MOST_TURNS: usize = 8;
const SHORTER: f64 = 0.02;

impl Scene {
    /// A translation no longer than `longest` after which the tool is free (checked exactly) and not inside a solid, along one of the
    /// directions or near it: as short as was found. `None` where no length tried along any of them frees it.
    pub(super) fn way_out(&self, tool: &Tool, pose: &Pose, directions: &[Point], longest: f64) -> Option<Point> {
        let is_free = |d: &Point, length: f64| {
            pose.translated(&scaled(d, length)).is_ok_and(|moved| self.is_free_and_outside(tool, &moved))
        };
        let shorten = |d: &Point, mut held: f64, mut free: f64| {
            for _ in 0..HALVINGS {
                let middle = 0.5 * (held + free);
                *(if is_free(d, middle) { &mut free } else { &mut held }) = middle;
            }
            free
        };
        let (mut before, mut reach) = (0.0, FIRST * longest);
        let (mut length, mut direction) = loop {
            let free = directions.iter().filter(|d| is_free(d, reach));
            let shortest = free.map(|d| (shorten(d, before, reach), *d)).min_by(|p, q| p.0.total_cmp(&q.0));
            if let Some(found) = shortest {
                break found;
            }
            if reach >= longest {
                return None;
            }
            (before, reach) = (reach, (STEP * reach).min(longest));
        };
        for turn in TURNS {
            for _ in 0..MOST_TURNS {
                let less = (1.0 - SHORTER) * length;
                let Some(turned) = around(&direction, turn).into_iter().flatten().find(|d| is_free(d, less)) else {
                    break;
                };
                (length, direction) = (shorten(&turned, 0.5 * length, less), turned);
            }
        }
        Some(scaled(&direction, length))
    }

    /// Whether a tool meets nothing, and is not wholly inside a solid (or a solid inside it) either, as far as the nearest triangles
    /// know.
    pub(super) fn is_free_and_outside(&self, tool: &Tool, pose: &Pose) -> bool {
        let is_outside =
            |gap: Option<Gap>| gap.is_none_or(|gap| is_in_front(&Ground::new(self, tool, pose, None), &gap));
        !self.is_colliding(tool, pose) && self.closest(tool, pose, f64::INFINITY).is_ok_and(is_outside)
    }
}

/// Directions around one, so far from it.
fn around(d: &Point, turn: f64) -> [Option<Point>; 6] {
    let axis = if d[0].abs() < 0.6 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] };
    let u = unit(&cross(d, &axis)).unwrap_or(axis);
    let v = cross(d, &u);
    SIDES.map(|[x, y]| unit(&along(d, turn, &add(&scaled(&u, x), &scaled(&v, y)))))
}

/// The directions to the corners, edges and faces of a cube, as the tool lies: many are drawn out along an axis of their own.
pub(super) fn directions_of(pose: &Pose) -> Vec<Point> {
    let sign = |i: usize| [0.0, 1.0, -1.0][i % 3];
    let of_tool = (1..27).filter_map(|i| unit(&[sign(i), sign(i / 3), sign(i / 9)]));
    of_tool.map(|d| pose.rotation().map(|row| row[0] * d[0] + row[1] * d[1] + row[2] * d[2])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contacts::penetration::PenetrationKind;
    use crate::contacts::shapes::{box_mesh, ridge};
    use crate::contacts::tests::{at, scene, tool, turned};
    use crate::vectors::{length, sub};

    #[test]
    fn a_block_wedged_in_a_slot_is_drawn_out_of_it() {
        let slot = [[-0.03, 0.0], [-0.01, 0.0], [-0.01, -0.02], [0.01, -0.02], [0.01, 0.0], [0.03, 0.0]];
        let held = scene(ridge(&slot, -0.04, 0.1, 3, 5));
        let block = tool(box_mesh([0.0; 3], [0.021, 0.02, 0.02], 2));
        for depth in [0.004, 0.015] {
            let pose = at(0.0, 0.0, 0.01 - depth);
            let out = held.penetration(&block, &pose, 0.001, None).unwrap();
            assert_eq!(out.kind, PenetrationKind::Bound, "{out:?}");
            assert!(!held.is_colliding(&block, &pose.translated(&out.translation).unwrap()));
            assert!((depth..1.05 * depth).contains(&out.depth) && out.translation[2] > 0.9 * out.depth, "{out:?}");
        }
    }

    #[test]
    fn what_is_deep_in_a_solid_is_no_way_out() {
        let plate = scene(box_mesh([0.0; 3], [0.4, 0.4, 0.2], 3));
        let block = tool(box_mesh([0.0; 3], [0.02, 0.02, 0.02], 1));
        let pose = at(0.0, 0.0, 0.1);
        let (up, down) = ([0.0, 0.0, 1.0], [0.0, 0.0, -1.0]);
        assert!(!plate.is_colliding(&block, &at(0.0, 0.0, 0.07)));
        assert_eq!(plate.way_out(&block, &pose, &[down], 0.03), None);
        let way = plate.way_out(&block, &pose, &[down, up], 0.03).unwrap();
        assert!(way[2] >= 0.01 && length(&way) < 0.0105, "{way:?}");
    }

    #[test]
    fn directions_go_around_and_turn_with_the_tool() {
        let pose = turned(0.7, [0.0; 3]);
        let tilted = directions_of(&pose);
        assert_eq!(tilted.len(), 26);
        for (d, straight) in tilted.iter().zip(directions_of(&Pose::IDENTITY)) {
            assert!((length(d) - 1.0).abs() < 1e-12 && length(&sub(d, &pose.apply(&straight))) < 1e-12);
            let beside = around(d, 0.25).into_iter().flatten();
            assert!(beside
                .map(|b| length(&cross(d, &b)))
                .all(|sine| (sine - 0.25 / (1.0f64 + 0.0625).sqrt()).abs() < 1e-12));
        }
    }
}
