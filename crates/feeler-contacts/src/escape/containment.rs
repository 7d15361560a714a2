//! Containment: the tool wholly inside a part, or a part inside the tool, though no triangles meet.
//!
//! A connected surface that meets no other lies wholly on one side of it, so one corner decides: it is inside where the winding
//! number of the other surface around it is not zero. That is counted by ray crossings with exact signs (point in polyhedron)
//! rather than as a sum of solid angles (A. Jacobson, L. Kavan, O. Sorkine-Hornung: Robust inside-outside segmentation using
//! generalized winding numbers, 2013), since closed surfaces need no more. Open surfaces have no inside.

use feeler_core::constants::NEEDLE_WIDTH;
use feeler_core::geometry::predicates::orient3d;
use feeler_core::mesh::topology::adjacency::Adjacency;
use feeler_core::tool::surface_links::SurfaceLinks;
use feeler_core::{Aabb, Mesh, Point, Pose, Scene, Tool, Triangle};

use crate::constants::{RAYS_WITH_CRACKS, RAY_EXCESS};
use crate::context::QueryContext;
use crate::surface::Surface;

/// Rays to the outside that are tried, each off the straight one by these shares of its length: odd ones, since a ray that meets an
/// edge is undecided, and edges lie along axes and diagonals.
const RAY_OFFSETS: [[f64; 2]; 6] =
    [[0.173, 0.091], [-0.059, 0.217], [-0.241, -0.127], [0.113, -0.281], [0.037, 0.053], [-0.331, 0.307]];

/// Triangles of a tool under one box, in the order of its clusters.
const TRIANGLES_PER_BOX: usize = 16;

/// A triangle of each group of the tool's connected surfaces that nothing in the scene separates.
fn surfaces_apart<'a>(links: &'a SurfaceLinks, scene: &Scene, pose: &Pose) -> impl Iterator<Item = u32> + 'a {
    let mut is_apart = vec![true; links.ends.len()];
    // A needle from each surface to the next: where it meets nothing, both are on one side of everything.
    if let Some(needles) = &links.ways {
        needles.mesh().queried().for_each(|needle| is_apart[needle as usize + 1] = false);
        let met = scene.collide(needles, pose).pairs;
        met.iter().for_each(|[needle, _]| is_apart[*needle as usize + 1] = true);
    }
    links.ends.iter().zip(is_apart).filter(|(_, is_apart)| *is_apart).map(|(t, _)| *t)
}

/// The parts that contain one of the tool's connected surfaces at least, or have a connected surface that the tool contains;
/// sorted. The tool meets nothing.
pub(crate) fn parts_in_containment(scene: &Scene, tool: &Tool, pose: &Pose) -> Vec<u32> {
    let mut found = find_containment(scene, tool, pose, usize::MAX);
    found.sort_unstable();
    found.dedup();
    found
}

/// Whether there is any such part.
pub(crate) fn has_containment(scene: &Scene, tool: &Tool, pose: &Pose) -> bool {
    !find_containment(scene, tool, pose, 1).is_empty()
}

/// Such parts, some of them twice; no more once there are `enough`.
fn find_containment(scene: &Scene, tool: &Tool, pose: &Pose, enough: usize) -> Vec<u32> {
    let context = QueryContext::new(scene, tool, pose, None);
    let of_tool = tool.mesh().bounds();
    let around = box_at(pose, &of_tool, tool.margin_at(pose));
    let bounds = scene.mockup().part_bounds();
    let nearby: Vec<u32> = (0..).zip(bounds).filter(|(_, b)| b.is_overlapping(&around)).map(|(part, _)| part).collect();
    let mut found = Vec::new();
    if nearby.is_empty() {
        return found;
    }
    let mut candidates = Vec::new();
    for t in surfaces_apart(tool.links(), scene, pose) {
        let p = context.tool_triangle(t)[0];
        candidates.clear();
        candidates.extend(nearby.iter().copied().filter(|part| is_in(&bounds[*part as usize], &p)));
        push_containing(scene, &p, &candidates, &mut found);
        if found.len() >= enough {
            return found;
        }
    }
    let mut solid = None;
    for part in nearby {
        let of_part = context.adjacency[Surface::Mockup].surfaces_of(part).iter();
        let mut corners = of_part.map(|(_, m)| context.in_tool(&context.mockup_triangle(*m)[0]));
        if corners.any(|p| is_in(&of_tool, &p) && solid.get_or_insert_with(|| Solid::new(tool)).contains(&p)) {
            found.push(part);
            if found.len() >= enough {
                return found;
            }
        }
    }
    found
}

/// Adds those parts that contain a point, of some whose boxes do.
fn push_containing(scene: &Scene, p: &Point, candidates: &[u32], found: &mut Vec<u32>) {
    if candidates.is_empty() {
        return;
    }
    let bounds = scene.mockup().part_bounds();
    let hull = candidates.iter().fold(Aabb::EMPTY, |hull, part| hull.union(&bounds[*part as usize]));
    let Adjacency { outward, has_cracks, .. } = scene.mockup().adjacency();
    let windings = |offset: &[f64; 2]| {
        // A needle triangle, one edge of it the ray: what meets it is what meets the ray, and little more.
        let (q, wide) = (ray_end(p, &hull, offset), ray_end(p, &hull, &offset.map(|x| x + NEEDLE_WIDTH)));
        let needle = Tool::new(vec![*p, q, wide], vec![[0, 1, 2]]).ok()?;
        let mut windings = vec![0; candidates.len()];
        for [_, m] in scene.collide(&needle, &Pose::IDENTITY).pairs {
            let side = i32::from(outward[m as usize]);
            if let (Ok(part), 1 | -1) = (candidates.binary_search(&scene.mockup().part_of_face(m)), side) {
                windings[part] += side * crossing(p, &q, &scene.mockup().mesh().triangle(m))?;
            }
        }
        Some(windings)
    };
    let decided: Vec<Vec<i32>> = RAY_OFFSETS.iter().filter_map(windings).take(ray_count(*has_cracks)).collect();
    let is_inside = |i: &usize| median(decided.iter().map(|windings| windings[*i]).collect()) != 0;
    found.extend((0..candidates.len()).filter(is_inside).map(|i| candidates[i]));
}

/// Rays that are asked.
fn ray_count(has_cracks: bool) -> usize {
    if has_cracks {
        RAYS_WITH_CRACKS
    } else {
        1
    }
}

/// What most rays say; 0 where there is none.
fn median(mut windings: Vec<i32>) -> i32 {
    windings.sort_unstable();
    windings.get(windings.len() / 2).copied().unwrap_or(0)
}

/// The closed surfaces of a tool, in its own frame, with a box around every few triangles.
struct Solid<'a> {
    mesh: &'a Mesh,
    adjacency: &'a Adjacency,
    boxes: Vec<(Aabb, Vec<u32>)>,
}

impl Solid<'_> {
    fn new(tool: &Tool) -> Solid<'_> {
        let (mesh, adjacency) = (tool.mesh(), tool.adjacency());
        let closed = |ids: &[u32]| ids.iter().copied().filter(|t| adjacency.outward[*t as usize] != 0).collect();
        let around = |ids: &Vec<u32>| {
            let corners = ids.iter().flat_map(|t| mesh.triangle(*t));
            corners.fold(Aabb::EMPTY, |mut around, p| {
                around.grow(&p);
                around
            })
        };
        let boxes = tool.ids().chunks(TRIANGLES_PER_BOX).map(closed).map(|ids| (around(&ids), ids)).collect();
        Solid { mesh, adjacency, boxes }
    }

    /// Whether a point is inside, but for the rounding of its turn into the tool's frame.
    fn contains(&self, p: &Point) -> bool {
        let Adjacency { outward, has_cracks, .. } = self.adjacency;
        let winding = |offset: &[f64; 2]| {
            let q = ray_end(p, &self.mesh.bounds(), offset);
            let ray = Aabb::of_triangle(&[*p, q, q]);
            let met = self.boxes.iter().filter(|(around, _)| around.is_overlapping(&ray)).flat_map(|(_, ids)| ids);
            met.map(|t| Some(i32::from(outward[*t as usize]) * crossing(p, &q, &self.mesh.triangle(*t))?))
                .sum::<Option<i32>>()
        };
        median(RAY_OFFSETS.iter().filter_map(winding).take(ray_count(*has_cracks)).collect()) != 0
    }
}

/// The signed crossing of the ray from `p` to `q` with a triangle, by exact signs: 1 where it leaves along the winding's normal, -1
/// where it enters against it, 0 where it misses; `None` where it meets the triangle's border or lies in its plane. Neither end may
/// be on the triangle.
fn crossing(p: &Point, q: &Point, t: &Triangle) -> Option<i32> {
    let ray = Aabb::of_triangle(&[*p, *q, *q]);
    if !ray.is_overlapping(&Aabb::of_triangle(t)) {
        return Some(0);
    }
    let [a, b, c] = t;
    let (from, to) = (orient3d(a, b, c, p), orient3d(a, b, c, q));
    if from == 0 && to == 0 {
        return None;
    }
    if from * to >= 0 {
        return Some(0);
    }
    let around = [orient3d(p, q, a, b), orient3d(p, q, b, c), orient3d(p, q, c, a)];
    if around.contains(&1) && around.contains(&-1) {
        return Some(0);
    }
    (!around.contains(&0)).then_some(i32::from(from))
}

/// Where a ray from `p` ends: beyond the nearest side of a box around `p`, off the straight line there.
fn ray_end(p: &Point, hull: &Aabb, offset: &[f64; 2]) -> Point {
    let room = |side: usize| if side < 3 { hull.upper[side] - p[side] } else { p[side - 3] - hull.lower[side - 3] };
    let side = (0..6).min_by(|i, j| room(*i).total_cmp(&room(*j))).unwrap_or(0);
    let (axis, sense, length) = (side % 3, if side < 3 { 1.0 } else { -1.0 }, room(side) + RAY_EXCESS * hull.longest());
    let mut q = *p;
    q[axis] += sense * length;
    q[(axis + 1) % 3] += offset[0] * length;
    q[(axis + 2) % 3] += offset[1] * length;
    q
}

/// Whether a point is in a closed box.
fn is_in(bounds: &Aabb, p: &Point) -> bool {
    bounds.is_overlapping(&Aabb { lower: *p, upper: *p })
}

/// The box of a tool at a pose, and of what rounding may add.
fn box_at(pose: &Pose, of_tool: &Aabb, slack: f64) -> Aabb {
    let mut around = Aabb::EMPTY;
    for corner in 0..8 {
        let p = std::array::from_fn(|a| if corner >> a & 1 == 0 { of_tool.lower[a] } else { of_tool.upper[a] });
        around.grow(&pose.apply(&p));
    }
    Aabb { lower: around.lower.map(|x| x - slack), upper: around.upper.map(|x| x + slack) }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;
    use std::f64::consts::PI;

    use proptest::prelude::*;

    use super::*;
    use crate::tests::{at, scene, tool, turned, Held};
    use feeler_core::geometry::vectors::{cross, dot, length, sub};
    use feeler_core::mesh::mockup::Mockup;
    use feeler_shapes::{ball, box_mesh, joined, Arrays};

    /// The winding number of a closed surface around a point, by solid angles (A. van Oosterom, J. Strackee: The solid angle of a
    /// plane triangle, 1983).
    fn winding(triangles: &[Triangle], p: &Point) -> i64 {
        let angle = |t: &Triangle| {
            let [a, b, c] = t.map(|x| sub(&x, p));
            let (u, v, w) = (length(&a), length(&b), length(&c));
            2.0 * dot(&a, &cross(&b, &c)).atan2(u * v * w + dot(&a, &b) * w + dot(&b, &c) * u + dot(&c, &a) * v)
        };
        (triangles.iter().map(angle).sum::<f64>() / (4.0 * PI)).round() as i64
    }

    fn scene_of(parts: Vec<Arrays>) -> Held {
        let part_of_face = (0..).zip(&parts).flat_map(|(part, (_, faces))| vec![part; faces.len()]).collect();
        let count = parts.len();
        let (vertices, faces) = joined(parts);
        let mockup = Mockup::new(vertices, faces, part_of_face, count).unwrap();
        Held::of(mockup)
    }

    fn inverted((vertices, faces): Arrays) -> Arrays {
        (vertices, faces.into_iter().map(|[a, b, c]| [a, c, b]).collect())
    }

    proptest! {
        #[test]
        fn containment_is_what_winding_numbers_say(
            solids in prop::collection::vec((prop::array::uniform3(-3..4i32), 1..14i32, 0..3usize, 0..4usize), 1..6),
            of_tool in prop::collection::vec((prop::array::uniform3(-2..3i32), 1..9i32), 1..5),
            (angle, shift) in (prop_oneof![Just(0.0), 0.0..3.0], prop::array::uniform3(-5..6i32)),
        ) {
            // Parts on a lattice, and the tool off it: edges line up with corners of others, and surfaces do not meet. A part may
            // be turned inside out, have a hollow, or lack a triangle.
            let solid = |(at, size, cells, what): &(Point, f64, usize, usize)| {
                let hollow = || inverted(box_mesh(*at, [0.5 * size; 3], 1));
                let whole = box_mesh(*at, [*size; 3], cells + 1);
                match what {
                    0 => whole,
                    1 => joined([whole, hollow()]),
                    2 => inverted(whole),
                    _ => (whole.0, whole.1[1..].to_vec()),
                }
            };
            let parts = solids.iter().map(|(at, size, cells, what)| (at.map(f64::from), f64::from(*size), *cells, *what));
            let parts: Vec<_> = parts.collect();
            let scene = scene_of(parts.iter().map(solid).collect());
            // Each once: a solid twice in one place is open.
            let of_tool: BTreeSet<_> = of_tool.into_iter().collect();
            let boxes = of_tool.iter().map(|(at, size)| box_mesh(at.map(f64::from), [0.3 * f64::from(*size); 3], 1));
            let tool = tool(joined(boxes));
            let pose = turned(angle, shift.map(|x| 0.5 * f64::from(x)));
            if scene.is_colliding(&tool, &pose) {
                return Ok(());
            }
            let mesh = scene.mockup().mesh();
            let own = |part: u32| {
                let is_own = |m: &u32| scene.mockup().part_of_face(*m) == part;
                mesh.queried().filter(is_own).map(|m| mesh.triangle(m)).collect::<Vec<_>>()
            };
            let placed: Vec<Triangle> =
                tool.mesh().queried().map(|t| pose.apply_triangle(&tool.mesh().triangle(t))).collect();
            let expected: Vec<u32> = (0u32..)
                .zip(&parts)
                .filter(|(part, (.., what))| {
                    let own = own(*part);
                    *what < 3 && placed.iter().any(|t| winding(&own, &t[0]) != 0)
                        || own.iter().any(|t| winding(&placed, &t[0]) != 0)
                })
                .map(|(part, _)| part)
                .collect();
            prop_assert_eq!(parts_in_containment(&scene, &tool, &pose), expected);
        }
    }

    #[test]
    fn a_ray_into_an_edge_is_undecided() {
        let t = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]];
        let turned = [t[0], t[2], t[1]];
        for (p, q, expected) in [
            ([0.5, 0.5, -1.0], [0.5, 0.5, 1.0], Some(1)),
            ([0.5, 0.5, 1.0], [0.5, 0.5, -1.0], Some(-1)),
            // Beside the triangle, short of it, from its plane, in its plane.
            ([1.5, 1.5, -1.0], [1.5, 1.5, 1.0], Some(0)),
            ([0.5, 0.5, -2.0], [0.5, 0.5, -1.0], Some(0)),
            ([1.5, 1.5, 0.0], [1.5, 1.5, 1.0], Some(0)),
            ([-1.0, 0.5, 0.0], [3.0, 0.5, 0.0], None),
            // Through an edge, a corner, and the line of an edge beyond its end.
            ([0.5, 0.0, -1.0], [0.5, 0.0, 1.0], None),
            ([1.0, 1.0, -1.0], [1.0, 1.0, 1.0], None),
            ([0.0, 0.0, -1.0], [0.0, 0.0, 1.0], None),
            ([1.5, 0.0, -1.0], [2.5, 0.0, 1.0], None),
            ([2.0, 0.0, -2.0], [3.0, 1.0, 2.0], Some(0)),
        ] {
            assert_eq!(crossing(&p, &q, &t), expected, "{p:?} {q:?}");
            assert_eq!(crossing(&p, &q, &turned), expected.map(|c| -c), "{p:?} {q:?}");
        }
    }

    #[test]
    fn an_undecided_ray_is_followed_by_another() {
        // A fan of triangles around the point that the first ray goes through, and one around that of the second.
        let (p, hull) = ([0.0; 3], Aabb { lower: [-1.0; 3], upper: [1.0; 3] });
        let mut fans = box_mesh([0.0; 3], [2.0; 3], 1);
        for offset in &RAY_OFFSETS[..2] {
            let q = ray_end(&p, &hull, offset);
            let (axis, top) = (0, 0.5 * q[0]);
            let spot = scaled_to(&q, axis, top);
            let corner = |k: usize| [top, spot[1] + [-0.1, 0.1, 0.0][k], spot[2] + [-0.1, -0.1, 0.1][k]];
            let from = fans.0.len() as u32;
            fans.0.extend([spot, corner(0), corner(1), corner(2)]);
            fans.1.extend([[0, 1, 2], [0, 2, 3], [0, 3, 1]].map(|f: [u32; 3]| f.map(|v| v + from)));
            let fan: Vec<Triangle> = fans.1[fans.1.len() - 3..].iter().map(|f| f.map(|v| fans.0[v as usize])).collect();
            assert!(fan.iter().any(|t| crossing(&p, &q, t).is_none()), "{offset:?}");
        }
        // Fans are open and contain nothing; the box does.
        let inner = tool(box_mesh([0.0; 3], [1e-3; 3], 1));
        let place = sub(&p, &inner.mesh().triangle(0)[0]);
        let pose = at(place[0], place[1], place[2]);
        assert_eq!(parts_in_containment(&scene(fans), &inner, &pose), [0]);
    }

    /// The point of the ray from the origin to `q` at a coordinate.
    fn scaled_to(q: &Point, axis: usize, at: f64) -> Point {
        q.map(|x| x * (at / q[axis]))
    }

    #[test]
    fn loose_triangles_that_nothing_separates_are_asked_once() {
        // Two solids, and a row of loose triangles beside the first: one of them in a solid, or none.
        let held = scene_of(vec![box_mesh([0.0; 3], [0.4, 0.4, 0.2], 3), box_mesh([0.9, 0.0, 0.0], [0.1; 3], 1)]);
        let loose = |xs: &[f64]| {
            let corners = |x: &f64| [[*x, 0.013, 0.007], [x + 1e-3, 0.013, 0.007], [*x, 0.014, 0.008]];
            (
                xs.iter().flat_map(corners).collect(),
                (0..xs.len() as u32).map(|i| [0, 1, 2].map(|k| 3 * i + k)).collect(),
            )
        };
        let outside: Vec<f64> = (0..200).map(|i| 0.21 + 0.003 * f64::from(i)).collect();
        let of = |xs: Vec<f64>| tool(loose(&xs));
        let apart = |tool: &Tool| surfaces_apart(tool.links(), &held, &Pose::IDENTITY).count();
        let all_out = of(outside.clone());
        assert_eq!((parts_in_containment(&held, &all_out, &Pose::IDENTITY), apart(&all_out)), (vec![], 1));
        for (at, expected) in [(0.1, vec![0]), (-0.3, vec![]), (0.92, vec![1])] {
            let one_in = of([outside.clone(), vec![at]].concat());
            assert_eq!(parts_in_containment(&held, &one_in, &Pose::IDENTITY), expected, "{at}");
            assert_eq!(has_containment(&held, &one_in, &Pose::IDENTITY), !expected.is_empty(), "{at}");
            // In any order: what a side of a solid separates from the others is asked for itself.
            assert!((2..6).contains(&apart(&one_in)), "{at} {}", apart(&one_in));
        }
        let same = of(vec![0.1; 50]);
        assert_eq!((parts_in_containment(&held, &same, &Pose::IDENTITY), apart(&same)), (vec![0], 1));
    }

    #[test]
    fn a_nearer_part_does_not_matter() {
        // A block in a plate, beside a bar through the plate that is nearer than any side of the plate.
        let plate = box_mesh([0.0; 3], [0.4, 0.4, 0.2], 3);
        let bar = box_mesh([0.0012, 0.0, 0.0], [0.001, 0.002, 0.3], 1);
        let held = scene_of(vec![bar, plate]);
        let block = tool(box_mesh([0.0; 3], [0.001; 3], 1));
        assert_eq!(held.closest(&block, &Pose::IDENTITY, 1.0).unwrap().unwrap().part, 0);
        assert_eq!(parts_in_containment(&held, &block, &Pose::IDENTITY), [1]);
        // A ball of many triangles around it, far from the origin.
        let around =
            |x: f64| joined([ball(1.0, 40)].map(|(v, f)| (v.into_iter().map(|p| [p[0] + x, p[1], p[2]]).collect(), f)));
        for x in [0.0, 1e6, 1e9] {
            let held = scene(around(x));
            assert_eq!(parts_in_containment(&held, &block, &at(x, 0.3, 0.2)), [0], "{x}");
            assert!(parts_in_containment(&held, &block, &at(x + 0.8, 0.7, 0.0)).is_empty(), "{x}");
        }
    }
}
