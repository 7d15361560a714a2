//! Escape by trial, if contact planes yield none: translations along many directions, ever longer, until the tool is
//! free.
//!
//! Only the end of each translation is tested, not the motion (that would be motion planning).

use feeler_core::geometry::vectors::{across, add, along, length, scaled, sub, unit};
use feeler_core::{Aabb, Gap, GoOn, Point, Pose, Result, Scene, Tool};

use crate::constants::{
    LEAST_PROBE_SHARE, MOST_PROBE_TURNS, NEAREST_PARTS_GROWTH, PROBE_FIRST_SHARE, PROBE_GROWTH, PROBE_HALVINGS,
    PROBE_OTHER_SHORTER, PROBE_TURNED_SHORTER, PROBE_TURNS,
};
use crate::containment::find::has_containment;

/// Offsets of the directions around one, across it: a hexagon.
const HEXAGON: [[f64; 2]; 6] =
    [[1.0, 0.0], [0.5, SINE_60], [-0.5, SINE_60], [-1.0, 0.0], [-0.5, -SINE_60], [0.5, -SINE_60]];
const SINE_60: f64 = 0.866_025_403_784_438_6;

/// A translation no longer than `longest` (metres) after which the tool is free (checked exactly) and not inside a solid, along one
/// of the axes or near it: the shortest found. `None` where no length tried along any of them frees it.
/// Where it is stopped, nothing counts as free from then on.
pub(crate) fn probe_axes(
    (scene, go_on): (&Scene, GoOn<'_>),
    tool: &Tool,
    pose: &Pose,
    axes: &[Point],
    longest: f64,
) -> Option<Point> {
    let is_free = |d: &Point, length: f64| {
        let moved = pose.translated(&scaled(d, length));
        go_on.goes_on() && moved.is_ok_and(|moved| is_free_and_outside((scene, go_on), tool, &moved))
    };
    let least = LEAST_PROBE_SHARE * longest;
    let bisect = |d: &Point, mut stuck: f64, mut free: f64| {
        for _ in 0..PROBE_HALVINGS {
            if free <= least {
                break;
            }
            let middle = 0.5 * (stuck + free);
            *(if is_free(d, middle) { &mut free } else { &mut stuck }) = middle;
        }
        free
    };
    let (mut before, mut reach) = (0.0, PROBE_FIRST_SHARE * longest);
    let (mut length, mut direction) = loop {
        let mut shortest: Option<(f64, Point)> = None;
        for d in axes {
            // Only lengths that would be clearly shorter than the best are tried.
            let most = shortest.map_or(reach, |(length, _)| (1.0 - PROBE_OTHER_SHORTER) * length);
            if most > least && is_free(d, most) {
                shortest = Some((bisect(d, before, most), *d));
            }
        }
        if let Some(found) = shortest {
            break found;
        }
        if reach >= longest {
            return None;
        }
        (before, reach) = (reach, (PROBE_GROWTH * reach).min(longest));
    };
    for turn in PROBE_TURNS {
        for _ in 0..MOST_PROBE_TURNS {
            if length <= least {
                break;
            }
            let less = (1.0 - PROBE_TURNED_SHORTER) * length;
            let Some(turned) = around(&direction, turn).into_iter().flatten().find(|d| is_free(d, less)) else {
                break;
            };
            (length, direction) = (bisect(&turned, 0.5 * length, less), turned);
        }
    }
    Some(scaled(&direction, length))
}

/// Whether a tool meets nothing and is not wholly inside a solid, nor a solid inside it.
pub(crate) fn is_free_and_outside((scene, go_on): (&Scene, GoOn<'_>), tool: &Tool, pose: &Pose) -> bool {
    !scene.is_colliding(tool, pose) && !has_containment(scene, tool, pose, go_on)
}

/// A translation out of the solids that contain the tool, or off those that it contains: along the line between the closest points
/// of the surfaces, or as [`probe_axes`] finds.
pub(crate) fn escape_containment(
    (scene, go_on): (&Scene, GoOn<'_>),
    tool: &Tool,
    pose: &Pose,
    parts: &[u32],
) -> Result<Option<Point>> {
    let around = parts.iter().fold(Aabb::EMPTY, |b, part| b.union(&scene.mockup().part_bounds()[*part as usize]));
    let longest = length(&tool.mesh().bounds().extent()) + length(&around.extent());
    let mut axes = cube_axes(pose);
    let nearest = nearest_of((scene, go_on), tool, pose, parts, longest)?;
    axes.extend(nearest.and_then(|gap| unit(&sub(&gap.on_mockup, &gap.on_tool))));
    Ok(probe_axes((scene, go_on), tool, pose, &axes, longest))
}

/// The least distance to one of the parts; others may be nearer.
fn nearest_of(
    (scene, go_on): (&Scene, GoOn<'_>),
    tool: &Tool,
    pose: &Pose,
    parts: &[u32],
    within: f64,
) -> Result<Option<Gap>> {
    let mut count = 1;
    loop {
        let gaps = scene.stoppable(go_on).nearest(tool, pose, count, within)?;
        let (is_all, found) = (gaps.len() < count, gaps.into_iter().find(|gap| parts.contains(&gap.part)));
        if found.is_some() || is_all {
            return Ok(found);
        }
        count *= NEAREST_PARTS_GROWTH;
    }
}

/// Six directions around one, turned from it by an angle of this tangent.
fn around(d: &Point, turn: f64) -> [Option<Point>; 6] {
    let [u, v] = across(d);
    HEXAGON.map(|[x, y]| unit(&along(d, turn, &add(&scaled(&u, x), &scaled(&v, y)))))
}

/// The directions to the corners, edges and faces of a cube in the tool's frame: many tools are drawn out along an axis of their
/// own.
pub(crate) fn cube_axes(pose: &Pose) -> Vec<Point> {
    let sign = |i: usize| [0.0, 1.0, -1.0][i % 3];
    let of_tool = (1..27).filter_map(|i| unit(&[sign(i), sign(i / 3), sign(i / 9)]));
    of_tool.map(|d| pose.rotation().map(|row| row[0] * d[0] + row[1] * d[1] + row[2] * d[2])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::escape::penetration::PenetrationKind;
    use crate::tests::{at, scene, tool, turned};
    use feeler_core::geometry::vectors::cross;
    use feeler_shapes::{box_mesh, ridge, sheet};

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
    fn a_pose_inside_a_solid_is_not_free() {
        let plate = scene(box_mesh([0.0; 3], [0.4, 0.4, 0.2], 3));
        let block = tool(box_mesh([0.0; 3], [0.02, 0.02, 0.02], 1));
        let pose = at(0.0, 0.0, 0.1);
        let (up, down) = ([0.0, 0.0, 1.0], [0.0, 0.0, -1.0]);
        assert!(!plate.is_colliding(&block, &at(0.0, 0.0, 0.07)));
        assert_eq!(probe_axes((&plate, GoOn::default()), &block, &pose, &[down], 0.03), None);
        let escape = probe_axes((&plate, GoOn::default()), &block, &pose, &[down, up], 0.03).unwrap();
        assert!(escape[2] >= 0.01 && length(&escape) < 0.0105, "{escape:?}");
    }

    #[test]
    fn what_only_touches_is_freed_by_next_to_nothing() {
        // Two wavy sheets that lie in each other: any translation off, however short, frees.
        let waves = sheet(12, 12, |s, t| [0.05 * s, 0.05 * t, 0.003 * (11.0 * s).sin() * (13.0 * t).sin()]);
        let (held, lying) = (scene(waves.clone()), tool(waves));
        assert!(held.is_colliding(&lying, &Pose::IDENTITY));
        let escape =
            probe_axes((&held, GoOn::default()), &lying, &Pose::IDENTITY, &cube_axes(&Pose::IDENTITY), 0.1).unwrap();
        assert!(!held.is_colliding(&lying, &Pose::IDENTITY.translated(&escape).unwrap()));
        let least = LEAST_PROBE_SHARE * 0.1;
        assert!((0.1 * least..=least).contains(&length(&escape)), "{escape:?}");
    }

    #[test]
    fn a_tool_beside_a_sharp_edge_is_outside() {
        // A wedge with an edge of 20 degrees along y, and a block before, above, below and in it.
        let wedge = [[-0.02, 0.0], [0.02, 0.02 * 2.0 * 20f64.to_radians().tan()]];
        let held = scene(ridge(&wedge, -1e-6, 0.05, 1, 2));
        let block = tool(box_mesh([0.0; 3], [0.002, 0.002, 0.002], 1));
        for (x, z, is_free) in [
            (-0.0211, 0.0, true),
            (-0.0211, 0.0005, true),
            (-0.0211, -0.0005, true),
            (0.0, 0.0095, true),
            (0.0, -0.0015, true),
            (0.012, 0.005, false),
            (0.016, 0.004, false),
        ] {
            assert!(!held.is_colliding(&block, &at(x, 0.0, z)), "{x} {z}");
            assert_eq!(is_free_and_outside((&held, GoOn::default()), &block, &at(x, 0.0, z)), is_free, "{x} {z}");
        }
        // Conversely: the mock-up within the tool.
        let (small, around) = (scene(box_mesh([0.0; 3], [0.01; 3], 1)), tool(box_mesh([0.0; 3], [0.05; 3], 2)));
        assert!(!is_free_and_outside((&small, GoOn::default()), &around, &at(0.001, 0.0, 0.002)));
        assert!(is_free_and_outside((&small, GoOn::default()), &around, &at(0.05, 0.001, 0.0)));
    }

    #[test]
    fn what_is_wholly_inside_a_solid_is_moved_out_of_it() {
        let plate = scene(box_mesh([0.0; 3], [0.4, 0.4, 0.2], 3));
        let block = tool(box_mesh([0.0; 3], [0.02, 0.02, 0.01], 1));
        for (x, z, depth) in [(0.003, 0.0901, 0.0149), (0.003, -0.06, 0.045), (0.18, 0.02, 0.03)] {
            let out = plate.penetration(&block, &at(x, 0.001, z), 0.0, None).unwrap();
            assert!(!out.contacts.is_meeting && out.contacts.planes.is_empty());
            assert_eq!(out.kind, PenetrationKind::Bound);
            assert!(out.depth >= depth && out.depth < 1.02 * depth, "{out:?}");
            let freed = at(x, 0.001, z).translated(&out.translation).unwrap();
            assert!(is_free_and_outside((&plate, GoOn::default()), &block, &freed));
        }
        // Conversely: the mock-up within the tool.
        let (small, around) = (scene(box_mesh([0.0; 3], [0.01; 3], 1)), tool(box_mesh([0.0; 3], [0.05; 3], 2)));
        let out = small.penetration(&around, &at(0.012, 0.0, 0.002), 0.0, None).unwrap();
        assert!(out.kind == PenetrationKind::Bound && out.translation[0] > 0.0, "{out:?}");
        assert!(out.depth >= 0.018 && out.depth < 1.02 * 0.018, "{out:?}");
        // Neither beside a solid nor in an open surface is there anything to escape from.
        let mut open = box_mesh([0.0; 3], [0.4, 0.4, 0.2], 3);
        open.1.pop();
        for (held, place) in [(&plate, at(0.003, 0.0, 0.1051)), (&scene(open), at(0.003, 0.0, 0.05))] {
            let out = held.penetration(&block, &place, 0.0, None).unwrap();
            assert!(out.kind == PenetrationKind::Exact && out.depth == 0.0, "{out:?}");
        }
    }

    #[test]
    fn axes_go_around_and_turn_with_the_tool() {
        let pose = turned(0.7, [0.0; 3]);
        let tilted = cube_axes(&pose);
        assert_eq!(tilted.len(), 26);
        for (d, straight) in tilted.iter().zip(cube_axes(&Pose::IDENTITY)) {
            assert!((length(d) - 1.0).abs() < 1e-12 && length(&sub(d, &pose.apply(&straight))) < 1e-12);
            let beside = around(d, 0.25).into_iter().flatten();
            assert!(beside
                .map(|b| length(&cross(d, &b)))
                .all(|sine| (sine - 0.25 / (1.0f64 + 0.0625).sqrt()).abs() < 1e-12));
        }
    }
}
