//! What is wholly inside a solid though no triangles meet: the tool in a part, or a part in the tool.
//!
//! A connected surface that meets no other lies on one side of it with all it has, so one corner tells. It is inside where a way
//! from there to the outside leaves the other surface more often than it enters, by exact signs. What is open has no inside.

use crate::bounds::{Aabb, Point, Triangle};
use crate::contacts::adjacency::Adjacency;
use crate::contacts::zones::{MOCKUP, TOOL};
use crate::contacts::Ground;
use crate::narrow::Filters;
use crate::pose::Pose;
use crate::predicates::orient3d;
use crate::scene::Scene;
use crate::tool::Tool;

/// Ways to the outside that are tried, each aside of the straight one by these shares of its length: odd ones, since a way that
/// runs into an edge tells nothing, and edges lie along axes and diagonals.
const ASIDE: [[f64; 2]; 6] =
    [[0.173, 0.091], [-0.059, 0.217], [-0.241, -0.127], [0.113, -0.281], [0.037, 0.053], [-0.331, 0.307]];

/// How much longer a way is than that to the border of the box around what is to be left, as a share of the box.
const BEYOND: f64 = 0.01;

/// How wide the triangle is that stands for a way where the index is asked, as a share of its length: by far more than rounding.
const WIDE: f64 = 0.01;

impl Scene {
    /// The parts that a tool which meets nothing is wholly inside of, by one of its connected surfaces at least, and those that have
    /// a connected surface wholly inside the tool; sorted.
    pub(super) fn swallowed(&self, tool: &Tool, pose: &Pose) -> Vec<u32> {
        let ground = Ground::new(self, tool, pose, None);
        let of_tool = tool.mesh().bounds();
        let around = box_at(pose, &of_tool, tool.margin_at(pose));
        let bounds = self.mockup().part_bounds();
        let beside: Vec<u32> =
            (0..).zip(bounds).filter(|(_, b)| b.is_overlapping(&around)).map(|(part, _)| part).collect();
        let mut found = Vec::new();
        let mut holding = Vec::new();
        for (_, t) in &ground.adjacency[TOOL].surfaces {
            let p = ground.tool_triangle(*t)[0];
            holding.clear();
            holding.extend(beside.iter().copied().filter(|part| is_in(&bounds[*part as usize], &p)));
            self.push_around(&p, &holding, &mut found);
        }
        for part in beside {
            let of_part = ground.adjacency[MOCKUP].surfaces_of(part);
            if of_part.iter().any(|(_, m)| is_in_tool(&ground, &ground.mockup_triangle(*m)[0])) {
                found.push(part);
            }
        }
        found.sort_unstable();
        found.dedup();
        found
    }

    /// Adds those of some parts, in whose boxes a point is, that it is inside of.
    fn push_around(&self, p: &Point, holding: &[u32], found: &mut Vec<u32>) {
        if holding.is_empty() {
            return;
        }
        let bounds = self.mockup().part_bounds();
        let hull = holding.iter().fold(Aabb::EMPTY, |hull, part| hull.union(&bounds[*part as usize]));
        let Adjacency { outward, has_cracks, .. } = self.adjacency();
        let windings = |aside: &[f64; 2]| {
            // What meets the triangle is what meets the way, one of its edges, and little more.
            let (q, wide) = (beyond(p, &hull, aside), beyond(p, &hull, &aside.map(|x| x + WIDE)));
            let needle = Tool::new(vec![*p, q, wide], vec![[0, 1, 2]]).ok()?;
            let mut windings = vec![0; holding.len()];
            for [_, m] in self.collide(&needle, &Pose::IDENTITY, Filters::default()).pairs {
                let side = i32::from(outward[m as usize]);
                if let (Ok(part), 1 | -1) = (holding.binary_search(&self.mockup().part_of_face(m)), side) {
                    windings[part] += side * crossing(p, &q, &self.mockup().mesh().triangle(m))?;
                }
            }
            Some(windings)
        };
        let told: Vec<Vec<i32>> = ASIDE.iter().filter_map(windings).take(ways(*has_cracks)).collect();
        let is_inside = |i: &usize| median(told.iter().map(|windings| windings[*i]).collect()) != 0;
        found.extend((0..holding.len()).filter(is_inside).map(|i| holding[i]));
    }
}

/// Ways that are asked: one tells, but may go through a crack.
fn ways(has_cracks: bool) -> usize {
    if has_cracks {
        3
    } else {
        1
    }
}

/// What most ways tell; 0 where there is none.
fn median(mut windings: Vec<i32>) -> i32 {
    windings.sort_unstable();
    windings.get(windings.len() / 2).copied().unwrap_or(0)
}

/// Whether a point (world) is inside a tool, in the tool's own frame: but for the rounding on the way there.
fn is_in_tool(ground: &Ground<'_>, p: &Point) -> bool {
    let (mesh, p) = (ground.tool.mesh(), ground.in_tool(p));
    let Adjacency { outward, has_cracks, .. } = ground.adjacency[TOOL];
    let winding = |aside: &[f64; 2]| {
        let q = beyond(&p, &mesh.bounds(), aside);
        let closed = mesh.queried().filter(|t| outward[*t as usize] != 0);
        closed.map(|t| Some(i32::from(outward[t as usize]) * crossing(&p, &q, &mesh.triangle(t))?)).sum::<Option<i32>>()
    };
    is_in(&mesh.bounds(), &p) && median(ASIDE.iter().filter_map(winding).take(ways(*has_cracks)).collect()) != 0
}

/// How often the way from `p` to `q` leaves a triangle's side that its winding's normal does not point to: 1, 0, or -1 where it
/// comes the other way; `None` where it meets the triangle's border or lies in its plane. Neither end may be on the triangle.
fn crossing(p: &Point, q: &Point, t: &Triangle) -> Option<i32> {
    let way = Aabb::of_triangle(&[*p, *q, *q]);
    if !way.is_overlapping(&Aabb::of_triangle(t)) {
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

/// A point beyond the nearest side of a box around `p`, aside of the straight way there.
fn beyond(p: &Point, hull: &Aabb, aside: &[f64; 2]) -> Point {
    let room = |side: usize| if side < 3 { hull.upper[side] - p[side] } else { p[side - 3] - hull.lower[side - 3] };
    let side = (0..6).min_by(|i, j| room(*i).total_cmp(&room(*j))).unwrap_or(0);
    let (axis, sense, length) = (side % 3, if side < 3 { 1.0 } else { -1.0 }, room(side) + BEYOND * hull.longest());
    let mut q = *p;
    q[axis] += sense * length;
    q[(axis + 1) % 3] += aside[0] * length;
    q[(axis + 2) % 3] += aside[1] * length;
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
    use std::sync::Arc;

    use proptest::prelude::*;

    use super::*;
    use crate::contacts::shapes::{ball, box_mesh, joined, Arrays};
    use crate::contacts::tests::{at, scene, tool, turned};
    use crate::mesh::Mockup;
    use crate::scene::SceneOptions;
    use crate::vectors::{cross, dot, length, sub};

    /// How often a closed surface goes around a point, by solid angles (A. van Oosterom, J. Strackee: The solid angle of a plane
    /// triangle, 1983).
    fn winding(triangles: &[Triangle], p: &Point) -> i64 {
        let angle = |t: &Triangle| {
            let [a, b, c] = t.map(|x| sub(&x, p));
            let (u, v, w) = (length(&a), length(&b), length(&c));
            2.0 * dot(&a, &cross(&b, &c)).atan2(u * v * w + dot(&a, &b) * w + dot(&b, &c) * u + dot(&c, &a) * v)
        };
        (triangles.iter().map(angle).sum::<f64>() / (4.0 * PI)).round() as i64
    }

    fn scene_of(parts: Vec<Arrays>) -> Scene {
        let part_of_face = (0..).zip(&parts).flat_map(|(part, (_, faces))| vec![part; faces.len()]).collect();
        let count = parts.len();
        let (vertices, faces) = joined(parts);
        let mockup = Mockup::new(vertices, faces, part_of_face, count).unwrap();
        Scene::build(Arc::new(mockup), &SceneOptions::default(), &|_, _| true).unwrap()
    }

    fn inverted((vertices, faces): Arrays) -> Arrays {
        (vertices, faces.into_iter().map(|[a, b, c]| [a, c, b]).collect())
    }

    proptest! {
        #[test]
        fn what_is_swallowed_is_what_surfaces_go_around(
            solids in prop::collection::vec((prop::array::uniform3(-3..4i32), 1..14i32, 0..3usize, 0..4usize), 1..6),
            of_tool in prop::collection::vec((prop::array::uniform3(-2..3i32), 1..9i32), 1..3),
            (angle, shift) in (prop_oneof![Just(0.0), 0.0..3.0], prop::array::uniform3(-5..6i32)),
        ) {
            // On a lattice, and the tool off it: edges lie in line with corners of others, and surfaces do not meet. A part may be
            // turned inside out, have a hollow, lack a triangle, or come with another solid.
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
            // Each once: what is twice in one place is open.
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
            prop_assert_eq!(scene.swallowed(&tool, &pose), expected);
        }
    }

    #[test]
    fn a_way_into_an_edge_tells_nothing() {
        let t = [[0.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]];
        let turned = [t[0], t[2], t[1]];
        for (p, q, expected) in [
            ([0.5, 0.5, -1.0], [0.5, 0.5, 1.0], Some(1)),
            ([0.5, 0.5, 1.0], [0.5, 0.5, -1.0], Some(-1)),
            // Beside it, short of it, from its plane, in its plane.
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
    fn a_way_that_tells_nothing_is_not_the_last() {
        // A fan around the spot that the first way goes through, and one around that of the second.
        let (p, hull) = ([0.0; 3], Aabb { lower: [-1.0; 3], upper: [1.0; 3] });
        let mut fans = box_mesh([0.0; 3], [2.0; 3], 1);
        for aside in &ASIDE[..2] {
            let q = beyond(&p, &hull, aside);
            let (axis, top) = (0, 0.5 * q[0]);
            let spot = scaled_to(&q, axis, top);
            let corner = |k: usize| [top, spot[1] + [-0.1, 0.1, 0.0][k], spot[2] + [-0.1, -0.1, 0.1][k]];
            let from = fans.0.len() as u32;
            fans.0.extend([spot, corner(0), corner(1), corner(2)]);
            fans.1.extend([[0, 1, 2], [0, 2, 3], [0, 3, 1]].map(|f: [u32; 3]| f.map(|v| v + from)));
            let fan: Vec<Triangle> = fans.1[fans.1.len() - 3..].iter().map(|f| f.map(|v| fans.0[v as usize])).collect();
            assert!(fan.iter().any(|t| crossing(&p, &q, t).is_none()), "{aside:?}");
        }
        // Fans are open: their part goes around nothing, the box does.
        let inner = tool(box_mesh([0.0; 3], [1e-3; 3], 1));
        let place = sub(&p, &inner.mesh().triangle(0)[0]);
        let pose = at(place[0], place[1], place[2]);
        assert_eq!(scene(fans).swallowed(&inner, &pose), [0]);
    }

    /// The point of the way from the origin to `q` at a coordinate.
    fn scaled_to(q: &Point, axis: usize, at: f64) -> Point {
        q.map(|x| x * (at / q[axis]))
    }

    #[test]
    fn what_is_nearer_does_not_matter() {
        // A block in a plate, beside a bar that goes through a bore of the plate's box and is nearer than any side of the plate.
        let plate = box_mesh([0.0; 3], [0.4, 0.4, 0.2], 3);
        let bar = box_mesh([0.0012, 0.0, 0.0], [0.001, 0.002, 0.3], 1);
        let held = scene_of(vec![bar, plate]);
        let block = tool(box_mesh([0.0; 3], [0.001; 3], 1));
        assert_eq!(held.closest(&block, &Pose::IDENTITY, 1.0).unwrap().unwrap().part, 0);
        assert_eq!(held.swallowed(&block, &Pose::IDENTITY), [1]);
        // A ball of many triangles around it, far from the origin.
        let around =
            |x: f64| joined([ball(1.0, 40)].map(|(v, f)| (v.into_iter().map(|p| [p[0] + x, p[1], p[2]]).collect(), f)));
        for x in [0.0, 1e6, 1e9] {
            let held = scene(around(x));
            assert_eq!(held.swallowed(&block, &at(x, 0.3, 0.2)), [0], "{x}");
            assert!(held.swallowed(&block, &at(x + 0.8, 0.7, 0.0)).is_empty(), "{x}");
        }
    }
}
