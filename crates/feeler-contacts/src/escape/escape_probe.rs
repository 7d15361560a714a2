//! A way out by trial, where contact planes show none: along many directions, ever farther, until the tool is free.

use feeler_core::geometry::vectors::{across, add, along, length, scaled, sub, unit};
use feeler_core::{Aabb, Gap, Point, Pose, Result, Scene, Tool};

use crate::escape::containment::contains_any;

/// The first length that is tried, as a share of the longest, and by what each length is longer than the one before.
const FIRST: f64 = 1.0 / 1024.0;
const STEP: f64 = 1.5;

/// Times that the span between a length that frees the tool and one that does not is halved.
const HALVINGS: usize = 8;

/// Share of the longest from which down no shorter way is sought: it is less than any part is made to. Where surfaces only touch,
/// there is always a shorter one.
const NOTHING: f64 = 1e-9;

/// By how much a way is turned (tangent) to find a shorter one, to which sides, how often at most, and the share by which it must be
/// shorter.
const TURNS: [f64; 4] = [0.5, 0.25, 0.12, 0.06];
const SIDES: [[f64; 2]; 6] = [[1.0, 0.0], [0.5, HIGH], [-0.5, HIGH], [-1.0, 0.0], [-0.5, -HIGH], [0.5, -HIGH]];
const HIGH: f64 = 0.866_025_403_784_438_6; // the sine of 60 degrees
const MOST_TURNS: usize = 8;
const SHORTER: f64 = 0.02;

/// The same for another of the directions given.
const CLEARLY: f64 = 0.002;

/// By how many times more parts the nearest of some is sought among, until it is found.
const MORE: usize = 8;

/// A translation no longer than `longest` after which the tool is free (checked exactly) and not inside a solid, along one of the
/// directions or near it: as short as was found. `None` where no length tried along any of them frees it.
pub(crate) fn escape_probe_axes(
    scene: &Scene,
    tool: &Tool,
    pose: &Pose,
    directions: &[Point],
    longest: f64,
) -> Option<Point> {
    let is_free = |d: &Point, length: f64| {
        pose.translated(&scaled(d, length)).is_ok_and(|moved| is_free_and_outside(scene, tool, &moved))
    };
    let nothing = NOTHING * longest;
    let shorten = |d: &Point, mut held: f64, mut free: f64| {
        for _ in 0..HALVINGS {
            if free <= nothing {
                break;
            }
            let middle = 0.5 * (held + free);
            *(if is_free(d, middle) { &mut free } else { &mut held }) = middle;
        }
        free
    };
    let (mut before, mut reach) = (0.0, FIRST * longest);
    let (mut length, mut direction) = loop {
        let mut shortest: Option<(f64, Point)> = None;
        for d in directions {
            // A way that is no shorter than the best is of no use: it is asked for no farther.
            let most = shortest.map_or(reach, |(length, _)| (1.0 - CLEARLY) * length);
            if most > nothing && is_free(d, most) {
                shortest = Some((shorten(d, before, most), *d));
            }
        }
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
            if length <= nothing {
                break;
            }
            let less = (1.0 - SHORTER) * length;
            let Some(turned) = around(&direction, turn).into_iter().flatten().find(|d| is_free(d, less)) else {
                break;
            };
            (length, direction) = (shorten(&turned, 0.5 * length, less), turned);
        }
    }
    Some(scaled(&direction, length))
}

/// Whether a tool meets nothing, and is not wholly inside a solid (or a solid inside it) either.
pub(crate) fn is_free_and_outside(scene: &Scene, tool: &Tool, pose: &Pose) -> bool {
    !scene.is_colliding(tool, pose) && !contains_any(scene, tool, pose)
}

/// A way out of solids that have containing_parts the tool, or that the tool has: along the shortest way between the surfaces, or as
/// [`escape_probe_axes`] finds.
pub(crate) fn escape_from_solids(scene: &Scene, tool: &Tool, pose: &Pose, parts: &[u32]) -> Result<Option<Point>> {
    let around = parts.iter().fold(Aabb::EMPTY, |b, part| b.union(&scene.mockup().part_bounds()[*part as usize]));
    let longest = length(&tool.mesh().bounds().extent()) + length(&around.extent());
    let mut directions = directions_of(pose);
    let nearest = nearest_of(scene, tool, pose, parts, longest)?;
    directions.extend(nearest.and_then(|gap| unit(&sub(&gap.on_mockup, &gap.on_tool))));
    Ok(escape_probe_axes(scene, tool, pose, &directions, longest))
}

/// Where some of the parts are the nearest, others perhaps before them.
fn nearest_of(scene: &Scene, tool: &Tool, pose: &Pose, parts: &[u32], within: f64) -> Result<Option<Gap>> {
    let mut count = 1;
    loop {
        let gaps = scene.distance(tool, pose, within, count)?;
        let (is_all, found) = (gaps.len() < count, gaps.into_iter().find(|gap| parts.contains(&gap.part)));
        if found.is_some() || is_all {
            return Ok(found);
        }
        count *= MORE;
    }
}

/// DepthScratch around one, so far from it.
fn around(d: &Point, turn: f64) -> [Option<Point>; 6] {
    let [u, v] = across(d);
    SIDES.map(|[x, y]| unit(&along(d, turn, &add(&scaled(&u, x), &scaled(&v, y)))))
}

/// The directions to the corners, edges and faces of a cube, as the tool lies: many are drawn out along an axis of their own.
pub(crate) fn directions_of(pose: &Pose) -> Vec<Point> {
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
    fn what_is_deep_in_a_solid_is_no_way_out() {
        let plate = scene(box_mesh([0.0; 3], [0.4, 0.4, 0.2], 3));
        let block = tool(box_mesh([0.0; 3], [0.02, 0.02, 0.02], 1));
        let pose = at(0.0, 0.0, 0.1);
        let (up, down) = ([0.0, 0.0, 1.0], [0.0, 0.0, -1.0]);
        assert!(!plate.is_colliding(&block, &at(0.0, 0.0, 0.07)));
        assert_eq!(escape_probe_axes(&plate, &block, &pose, &[down], 0.03), None);
        let way = escape_probe_axes(&plate, &block, &pose, &[down, up], 0.03).unwrap();
        assert!(way[2] >= 0.01 && length(&way) < 0.0105, "{way:?}");
    }

    #[test]
    fn what_only_touches_is_left_by_next_to_nothing() {
        // Two sheets of waves that lie in each other: any way off, however short, is one.
        let waves = sheet(12, 12, |s, t| [0.05 * s, 0.05 * t, 0.003 * (11.0 * s).sin() * (13.0 * t).sin()]);
        let (held, lying) = (scene(waves.clone()), tool(waves));
        assert!(held.is_colliding(&lying, &Pose::IDENTITY));
        let way = escape_probe_axes(&held, &lying, &Pose::IDENTITY, &directions_of(&Pose::IDENTITY), 0.1).unwrap();
        assert!(!held.is_colliding(&lying, &Pose::IDENTITY.translated(&way).unwrap()));
        let nothing = NOTHING * 0.1;
        assert!((0.1 * nothing..=nothing).contains(&length(&way)), "{way:?}");
    }

    #[test]
    fn a_tool_beside_a_sharp_edge_is_outside() {
        // A wedge with an edge of 20 degrees along y, and a block just before it, above, below and in it.
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
            assert_eq!(is_free_and_outside(&held, &block, &at(x, 0.0, z)), is_free, "{x} {z}");
        }
        // And the other way round: the mock-up within the tool.
        let (small, around) = (scene(box_mesh([0.0; 3], [0.01; 3], 1)), tool(box_mesh([0.0; 3], [0.05; 3], 2)));
        assert!(!is_free_and_outside(&small, &around, &at(0.001, 0.0, 0.002)));
        assert!(is_free_and_outside(&small, &around, &at(0.05, 0.001, 0.0)));
    }

    #[test]
    fn what_is_wholly_inside_a_solid_is_drawn_out_of_it() {
        let plate = scene(box_mesh([0.0; 3], [0.4, 0.4, 0.2], 3));
        let block = tool(box_mesh([0.0; 3], [0.02, 0.02, 0.01], 1));
        for (x, z, depth) in [(0.003, 0.0901, 0.0149), (0.003, -0.06, 0.045), (0.18, 0.02, 0.03)] {
            let out = plate.penetration(&block, &at(x, 0.001, z), 0.0, None).unwrap();
            assert!(!out.contacts.is_meeting && out.contacts.planes.is_empty());
            assert_eq!(out.kind, PenetrationKind::Bound);
            assert!(out.depth >= depth && out.depth < 1.02 * depth, "{out:?}");
            let freed = at(x, 0.001, z).translated(&out.translation).unwrap();
            assert!(is_free_and_outside(&plate, &block, &freed));
        }
        // And the other way round: the mock-up within the tool.
        let (small, around) = (scene(box_mesh([0.0; 3], [0.01; 3], 1)), tool(box_mesh([0.0; 3], [0.05; 3], 2)));
        let out = small.penetration(&around, &at(0.012, 0.0, 0.002), 0.0, None).unwrap();
        assert!(out.kind == PenetrationKind::Bound && out.translation[0] > 0.0, "{out:?}");
        assert!(out.depth >= 0.018 && out.depth < 1.02 * 0.018, "{out:?}");
        // Beside a solid there is nothing to be left, nor in what is open somewhere.
        let mut open = box_mesh([0.0; 3], [0.4, 0.4, 0.2], 3);
        open.1.pop();
        for (held, place) in [(&plate, at(0.003, 0.0, 0.1051)), (&scene(open), at(0.003, 0.0, 0.05))] {
            let out = held.penetration(&block, &place, 0.0, None).unwrap();
            assert!(out.kind == PenetrationKind::Exact && out.depth == 0.0, "{out:?}");
        }
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
