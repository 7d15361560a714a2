//! Crack stitching: joins borders of a surface that run along each other a little apart, as borders of a CAD model do whose faces
//! were triangulated one by one, and those left by triangles without area. A surface that is closed but for cracks is a solid.
//!
//! Border edges are matched as in the repair of CAD models (Barequet and Kumar: *Repairing CAD models*, 1997), here with a hash grid;
//! vertices stay where they are, and only adjacency is added.

use std::collections::HashMap;

use crate::constants::{CRACK_AREA, CRACK_SAMPLES, CRACK_WIDTH, MOST_EDGES_NEAR, WELD_SHARE};
use crate::geometry::bounds::{Aabb, Point};
use crate::geometry::vectors::{add, along, cross, dot, length, scaled, square_to_segment, sub};
use crate::mesh::topology::disjoint_sets::DisjointSets;
use crate::mesh::topology::edges::Edge;
use crate::mesh::triangle_mesh::Mesh;

/// The surface across a crack from a border edge.
#[derive(Debug, Clone, Copy)]
struct Across {
    /// The edge of another triangle that runs along it the other way: an index into the border.
    other: usize,
    /// The area between the two, with the part scaled to length 1.
    area: f64,
}

/// Joins border edges across cracks, each with the edge nearest to its middle, on surfaces without other openings. So a
/// long edge has one of several short ones as its neighbour, and is the neighbour of all of them. `border` is grouped
/// by part; open edges stay in it. Returns whether there are cracks.
pub fn close_cracks(
    mesh: &Mesh,
    closed: &[bool],
    neighbours: &mut [[u32; 3]],
    border: &mut Vec<Edge>,
    part_of_face: impl Fn(u32) -> u32,
    bounds: &[Aabb],
) -> bool {
    let part_of = |edge: &Edge| part_of_face(edge.triangle) as usize;
    let mut across: Vec<Option<Across>> = Vec::with_capacity(border.len());
    for same in border.chunk_by(|x, y| part_of(x) == part_of(y)) {
        push_across(mesh, same, &bounds[part_of(&same[0])], &mut across);
    }
    if across.iter().all(Option::is_none) {
        return false;
    }
    let mut surfaces = DisjointSets((0..neighbours.len() as u32).collect());
    for (t, of_triangle) in (0..).zip(&*neighbours) {
        of_triangle.iter().filter(|n| **n < t).for_each(|n| surfaces.join(t, *n));
    }
    for (edge, across) in border.iter().zip(&across) {
        across.iter().for_each(|a| surfaces.join(edge.triangle, border[a.other].triangle));
    }
    // For each surface with a border the area of its cracks, infinite where something else opens it, its own area, and the sum of its
    // triangles' area vectors, which is none of a closed surface.
    let mut areas: HashMap<u32, (f64, f64, Point)> = HashMap::new();
    for (edge, across) in border.iter().zip(&across) {
        areas.entry(surfaces.of(edge.triangle)).or_default().0 += across.map_or(f64::INFINITY, |a| a.area);
    }
    for t in mesh.queried() {
        if let Some((cracks, own, sum)) = areas.get_mut(&surfaces.of(t)) {
            let [a, b, c] = mesh.triangle(t).map(|p| in_cube(&p, &bounds[part_of_face(t) as usize]));
            let vector = scaled(&cross(&sub(&b, &a), &sub(&c, &a)), 0.5);
            *own += length(&vector);
            *sum = add(sum, &vector);
            if !closed[t as usize] {
                *cracks = f64::INFINITY;
            }
        }
    }
    let mut is_any = false;
    let mut left = Vec::new();
    for (edge, across) in border.iter().zip(&across) {
        let (cracks, own, sum) = areas[&surfaces.of(edge.triangle)];
        match across {
            Some(a) if cracks <= CRACK_AREA * own && length(&sum) <= cracks + WELD_SHARE * own => {
                neighbours[edge.triangle as usize][usize::from(edge.side)] = border[a.other].triangle;
                is_any = true;
            }
            _ => left.push(*edge),
        }
    }
    *border = left;
    is_any
}

/// A point of a part, moved and scaled to a cube of length 1: squares of lengths then neither overflow nor vanish.
fn in_cube(p: &Point, bounds: &Aabb) -> Point {
    sub(p, &bounds.lower).map(|x| x / bounds.longest())
}

/// Appends for each border edge of a part, whose box is given, what lies across the crack.
fn push_across(mesh: &Mesh, edges: &[Edge], bounds: &Aabb, out: &mut Vec<Option<Across>>) {
    let ends = |edge: &Edge| {
        let [from, to, _] = edge.corners(mesh);
        [from, to].map(|p| in_cube(&p, bounds))
    };
    let ends: Vec<[Point; 2]> = edges.iter().map(ends).collect();
    let lengths: Vec<f64> = ends.iter().map(|[from, to]| length(&sub(to, from))).collect();
    // A cell is no shorter than a step, and than twice the width: so a step, widened, is in at most three cells along each axis.
    let cell = (lengths.iter().sum::<f64>() / lengths.len() as f64).max(2.0 * CRACK_WIDTH);
    let number = |p: &Point| p.map(|x| (x / cell).floor() as i64);
    // Each edge is listed in all cells within the width of it, step by step along it.
    let mut cells: HashMap<[i64; 3], Vec<u32>> = HashMap::new();
    for (i, ([a, b], length)) in (0..).zip(ends.iter().zip(&lengths)) {
        let steps = (length / cell).ceil().max(1.0);
        for step in 0..steps as usize {
            let mut around = Aabb::EMPTY;
            [step, step + 1].map(|k| between(a, b, k as f64 / steps)).iter().for_each(|p| around.grow(p));
            let low = number(&around.lower.map(|x| x - CRACK_WIDTH));
            let high = number(&around.upper.map(|x| x + CRACK_WIDTH));
            for x in low[0]..=high[0] {
                for y in low[1]..=high[1] {
                    for z in low[2]..=high[2] {
                        let list = cells.entry([x, y, z]).or_default();
                        if list.last() != Some(&i) {
                            list.push(i);
                        }
                    }
                }
            }
        }
    }
    // The distance and index of the edge nearest to a point of an edge.
    let nearest = |i: usize, share: f64| {
        let ([a, b], id) = (&ends[i], edges[i].triangle);
        let p = between(a, b, share);
        let near = cells.get(&number(&p)).filter(|near| near.len() <= MOST_EDGES_NEAR)?;
        let is_against = |j: &&u32| {
            let [from, to] = &ends[**j as usize];
            edges[**j as usize].triangle != id && dot(&sub(b, a), &sub(to, from)) < 0.0
        };
        let square = |j: &u32| square_to_segment(&p, &ends[*j as usize][0], &ends[*j as usize][1]);
        let nearest = near.iter().filter(is_against).map(|j| (square(j), *j)).min_by(|p, q| p.0.total_cmp(&q.0))?;
        (nearest.0 <= CRACK_WIDTH * CRACK_WIDTH).then_some((nearest.0.sqrt(), nearest.1 as usize))
    };
    let first = out.len();
    out.extend((0..edges.len()).map(|i| {
        let [middle, before, after] = CRACK_SAMPLES.map(|share| nearest(i, share));
        let (middle, before, after) = (middle?, before?, after?);
        let area = lengths[i] * (middle.0 + before.0 + after.0) / CRACK_SAMPLES.len() as f64;
        Some(Across { other: first + middle.1, area })
    }));
}

fn between(a: &Point, b: &Point, share: f64) -> Point {
    along(&scaled(a, 1.0 - share), share, b)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;
    use crate::constants::NONE;
    use crate::geometry::pose::Pose;
    use crate::mesh::topology::adjacency::Adjacency;
    use feeler_shapes::{box_mesh, box_sides, cylinder, joined, sheet, turned, Arrays};

    fn adjacency((vertices, faces): &Arrays) -> Adjacency {
        Adjacency::of_one_part(&Mesh::new("tool", vertices.clone(), faces.clone()).unwrap())
    }

    fn is_closed(arrays: &Arrays) -> bool {
        adjacency(arrays).outward.iter().all(|o| *o == 1)
    }

    fn is_open(arrays: &Arrays) -> bool {
        let Adjacency { outward, has_cracks, .. } = adjacency(arrays);
        !has_cracks && outward.iter().all(|o| *o == 0)
    }

    fn moved(mesh: &Arrays, at: impl Fn(&Point) -> Point) -> Arrays {
        (mesh.0.iter().map(at).collect(), mesh.1.clone())
    }

    /// A box of which no two sides are triangulated alike.
    fn uneven_box(size: Point) -> [Arrays; 6] {
        box_sides([0.0; 3], size, |side| [[3, 4], [5, 7], [1, 11], [6, 13], [2, 9], [17, 8]][side])
    }

    /// A can whose wall has more corners around than its lids: those are off its circle, at most by `1 - cos(pi / around)` of the
    /// radius.
    fn can(around: usize, lids: usize) -> Arrays {
        let (vertices, faces) = cylinder(0.5, 1.0, lids, 1);
        let caps = faces.into_iter().filter(|f| f.iter().any(|v| vertices[*v as usize][1..] == [0.0; 2])).collect();
        let wall = sheet(around, 1, |s, t| {
            let phi = TAU * if s == 1.0 { 0.0 } else { s };
            [t - 0.5, 0.5 * phi.sin(), -0.5 * phi.cos()]
        });
        joined([(vertices, caps), wall])
    }

    #[test]
    fn what_is_closed_but_for_cracks_is_a_solid() {
        let apart = |by: f64| {
            let sides = uneven_box([1.0, 0.7, 0.4]);
            joined(sides.into_iter().enumerate().map(|(i, side)| {
                let out = if i % 2 == 0 { by } else { -by };
                moved(&side, |p| std::array::from_fn(|a| p[a] + if a == i / 2 { out } else { 0.0 }))
            }))
        };
        for (what, closed, open) in [("box", apart(4e-4), apart(1.2e-3)), ("can", can(150, 61), can(150, 31))] {
            let Adjacency { neighbours, has_cracks, .. } = adjacency(&closed);
            assert!(has_cracks && neighbours.iter().flatten().all(|n| *n != NONE), "{what}");
            let inverted = (closed.0.clone(), closed.1.iter().map(|[a, b, c]| [*b, *a, *c]).collect());
            assert!(adjacency(&inverted).outward.iter().all(|o| *o == -1), "{what}");
            for (scale, shift) in [(1.0, 0.0), (1e-90, 0.0), (1e90, 0.0), (1e-3, 1e6), (1e3, -7.0)] {
                for turn in [Pose::IDENTITY, Pose::new(&turned(0.7, [0.0; 3])).unwrap()] {
                    let place = |mesh: &Arrays| moved(mesh, |p| turn.apply(p).map(|x| scale * x + shift));
                    assert!(is_closed(&place(&closed)), "{what} {scale} {shift}");
                    assert!(is_open(&place(&open)), "{what} {scale} {shift}");
                }
            }
        }
    }

    #[test]
    fn few_triangles_may_all_have_borders() {
        // Hardly two sides are cut alike, and most edges are borders.
        let sides =
            || box_sides([0.0; 3], [1.0, 0.7, 0.4], |side| [[1, 1], [2, 1], [1, 3], [2, 3], [1, 2], [3, 2]][side]);
        assert!(is_closed(&joined(sides())));
        // A wall across it belongs to no solid: both ends of its edges would run along the sides.
        let wall = sheet(7, 5, |s, t| [0.0, 0.7 * (s - 0.5), 0.4 * (t - 0.5)]);
        let halves = [-0.25, 0.25].map(|x| {
            let of = box_sides([x, 0.0, 0.0], [0.5, 0.7, 0.4], |side| {
                [2 + side % 3, 2 + side / 2].map(|n| if x > 0.0 { 3 * n + 2 } else { n })
            });
            let is_between = |p: &Point| p[0] == 0.0;
            joined(of.into_iter().filter(|side| !side.0.iter().all(is_between)))
        });
        assert!(is_closed(&joined(halves.clone())));
        assert!(!is_closed(&joined(halves.into_iter().chain([wall]))));
    }

    #[test]
    fn triangles_without_area_open_nothing() {
        // A triangle without area between the two halves of an edge and the whole edge of a neighbour.
        let (mut vertices, mut faces) = box_mesh([0.0; 3], [1.0; 3], 1);
        let [a, b, c] = faces[0];
        let d = vertices.len() as u32;
        vertices.push(std::array::from_fn(|k| 0.5 * (vertices[a as usize][k] + vertices[b as usize][k])));
        faces.splice(0..1, [[a, d, c], [d, b, c], [a, b, d]]);
        let Adjacency { outward, has_cracks, .. } = adjacency(&(vertices, faces));
        assert!(has_cracks);
        assert_eq!(outward.iter().map(|o| i32::from(*o)).sum::<i32>(), 13);
        assert_eq!(outward[2], 0, "no area");
    }

    #[test]
    fn what_is_open_stays_so() {
        let sides = || uneven_box([1.0, 0.7, 0.4]);
        let open = |what: &str, arrays: Arrays| assert!(is_open(&arrays), "{what}");
        for side in 0..6 {
            let mut without: Vec<Arrays> = sides().into();
            without.remove(side);
            open(&format!("without side {side}"), joined(without));
            let mut hole: Vec<Arrays> = sides().into();
            hole[side].1.pop();
            open(&format!("side {side} with a hole"), joined(hole));
            let mut turned: Vec<Arrays> = sides().into();
            turned[side].1.iter_mut().for_each(|f| f.swap(0, 1));
            open(&format!("side {side} inside out"), joined(turned));
        }
        let strip = |wide: f64| sheet(40, 1, |s, t| [s, wide * t, 0.0]);
        let (vertices, faces) = strip(0.1);
        let both = (vertices, faces.iter().flat_map(|[a, b, c]| [[*a, *b, *c], [*b, *a, *c]]).collect());
        let fin = joined([box_mesh([0.0; 3], [1.0; 3], 2), sheet(2, 2, |s, t| [0.5 + s, t - 0.5, 0.0])]);
        for (what, arrays) in [("strip", strip(0.1)), ("ribbon", strip(5e-4)), ("both sides", both)] {
            open(what, arrays);
        }
        // A ring of wire, flat: its borders run along each other, and not the same way.
        open(
            "hoop",
            sheet(60, 1, |s, t| {
                let (phi, r) = (TAU * if s == 1.0 { 0.0 } else { s }, 0.5 - 4e-4 * t);
                [r * phi.cos(), r * phi.sin(), 0.0]
            }),
        );
        assert!(adjacency(&fin).outward.contains(&0), "a box with a fin");
        // One solid with cracks, and an open surface beside it.
        let solid = joined(sides());
        let count = solid.1.len();
        let outward = adjacency(&joined([solid, moved(&strip(0.1), |p| [p[0], p[1], 3.0])])).outward;
        assert!(outward[..count].iter().all(|o| *o == 1) && outward[count..].iter().all(|o| *o == 0));
    }
}
