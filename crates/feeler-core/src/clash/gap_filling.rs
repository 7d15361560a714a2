//! Fills the gaps of closed surfaces, in seams and cracks, by narrow triangles, so that nothing has a border any more: winding numbers
//! are then whole, and the same along each ray.
//!
//! Edges on both sides of a gap are partners. Corners of one side are inserted into their partners on the other, and the triangles
//! between an edge and its corners are fillings. The edges that are left then run along each other in both directions, except in small
//! loops where gaps end or meet; these are filled from one of their corners. A sum of edges without ends stays one through all of it, so
//! no gap is missed, however uneven it is.

use std::collections::{BTreeMap, HashMap};

use super::boxes::Boxes;
use crate::constants::{CRACK_SAMPLES, WELD_SHARE};
use crate::geometry::bounds::{Aabb, Point, Triangle};
use crate::geometry::predicates::is_collinear;
use crate::geometry::vectors::{along, dot, length, square_to_segment, sub};
use crate::mesh::weld::weld_vertices;

/// Share of the border's length up to which a corner beside the end of an edge is beside the beginning of the next one: above rounding.
const SAME_PLACE: f64 = 1e-12;

/// By how much the distance is increased within which the other side of a gap is sought.
const WIDER: f64 = 8.0;

/// An edge that its triangle is alone on one side of.
#[derive(Debug, Clone, Copy)]
struct Edge {
    ends: [u32; 2],
    triangle: u32,
}

/// The triangles that fill the gaps between some others, which are wound outwards, as the result is.
pub fn fillings(triangles: &[Triangle]) -> Vec<Triangle> {
    let corners: Vec<Point> = triangles.iter().flatten().copied().collect();
    let (points, welded) = weld_vertices(&corners);
    let border = border_of(&welded);
    if border.is_empty() {
        return Vec::new();
    }
    let mut found: Vec<[u32; 3]> = Vec::new();
    let mut left: BTreeMap<[u32; 2], i32> = BTreeMap::new();
    let mut leave = |from: u32, to: u32| {
        let (edge, by) = if from < to { ([from, to], 1) } else { ([to, from], -1) };
        *left.entry(edge).or_default() += by;
    };
    for (Edge { ends: [from, to], .. }, beside) in border.iter().zip(corners_beside(&points, &border)) {
        let mut last = *from;
        for v in beside {
            found.push([*to, last, v]);
            leave(last, v);
            last = v;
        }
        leave(last, *to);
    }
    fill_loops(&left, &mut found);
    let triangle = |corners: [u32; 3]| corners.map(|v| points[v as usize]);
    found.into_iter().map(triangle).filter(|[a, b, c]| !is_collinear(a, b, c)).collect()
}

/// The edges that triangles, given by the numbers of their corners, run along more often one way than the other, once for each time.
fn border_of(corners: &[u32]) -> Vec<Edge> {
    let mut edges: Vec<([u32; 2], bool, u32)> = Vec::with_capacity(corners.len());
    for (triangle, t) in (0..).zip(corners.chunks_exact(3)) {
        for k in 0..3 {
            let (from, to) = (t[k], t[(k + 1) % 3]);
            edges.push(([from.min(to), from.max(to)], from < to, triangle));
        }
    }
    edges.sort_unstable();
    let mut border = Vec::new();
    for same in edges.chunk_by(|x, y| x.0 == y.0) {
        let [low, high] = same[0].0;
        // Those that run from the higher to the lesser end come first.
        let (down, up) = same.split_at(same.partition_point(|(_, is_up, _)| !is_up));
        let (ends, more) =
            if down.len() > up.len() { ([high, low], &down[up.len()..]) } else { ([low, high], &up[down.len()..]) };
        if low != high {
            border.extend(more.iter().map(|(.., triangle)| Edge { ends, triangle: *triangle }));
        }
    }
    border
}

/// For each edge of a border the corners across the gap, in the order along it.
fn corners_beside(points: &[Point], border: &[Edge]) -> Vec<Vec<u32>> {
    let ends = |edge: u32| border[edge as usize].ends.map(|v| points[v as usize]);
    let box_of = |edge: u32| {
        ends(edge).iter().fold(Aabb::EMPTY, |mut around, p| {
            around.grow(p);
            around
        })
    };
    let bounds: Vec<Aabb> = (0..border.len() as u32).map(box_of).collect();
    let longest = bounds.iter().fold(Aabb::EMPTY, |all, own| all.union(own)).longest();
    let boxes = Boxes::new(bounds);
    let partner = |edge: u32, share: f64| {
        let [from, to] = ends(edge);
        let way = sub(&to, &from);
        let p = along(&from, share, &way);
        let nearest = |within: f64| {
            let around = Aabb { lower: p.map(|x| x - within), upper: p.map(|x| x + within) };
            let is_against = |other: &u32| {
                let [a, b] = ends(*other);
                border[*other as usize].triangle != border[edge as usize].triangle && dot(&way, &sub(&b, &a)) < 0.0
            };
            let square = |other: u32| {
                let [a, b] = ends(other);
                square_to_segment(&p, &a, &b)
            };
            let against = boxes.around(&around).into_iter().filter(is_against).map(|other| (square(other), other));
            against.filter(|(square, _)| *square <= within * within).min_by(|x, y| x.0.total_cmp(&y.0))
        };
        let wider = |within: &f64| (*within < longest).then(|| WIDER * within);
        std::iter::successors(Some(WELD_SHARE * longest), wider).find_map(nearest).map(|(_, other)| other)
    };
    let mut beside: Vec<Vec<(f64, u32)>> = vec![Vec::new(); border.len()];
    // At the end of an edge a corner is beside the beginning of the next one.
    let mut insert = |edge: u32, corners: [u32; 2]| {
        let [from, to] = ends(edge);
        let way = sub(&to, &from);
        for v in corners.into_iter().filter(|v| !border[edge as usize].ends.contains(v)) {
            let share = dot(&sub(&points[v as usize], &from), &way) / dot(&way, &way);
            let same = SAME_PLACE * longest / length(&way);
            if (-same..1.0 - same).contains(&share) {
                beside[edge as usize].push((share, v));
            }
        }
    };
    for edge in 0..border.len() as u32 {
        for other in CRACK_SAMPLES.into_iter().filter_map(|share| partner(edge, share)) {
            insert(edge, border[other as usize].ends);
            insert(other, border[edge as usize].ends);
        }
    }
    let in_order = |mut corners: Vec<(f64, u32)>| {
        corners.sort_unstable_by(|x, y| x.0.total_cmp(&y.0).then(x.1.cmp(&y.1)));
        corners.dedup();
        corners.into_iter().map(|(_, v)| v).collect()
    };
    beside.into_iter().map(in_order).collect()
}

/// Fills what edges enclose, each given by its ends, the lesser first, and how often it is there; negative: the other way round.
fn fill_loops(edges: &BTreeMap<[u32; 2], i32>, found: &mut Vec<[u32; 3]>) {
    let mut next: HashMap<u32, Vec<u32>> = HashMap::new();
    let mut starts = Vec::new();
    for ([low, high], sum) in edges.iter().filter(|(_, sum)| **sum != 0) {
        let (from, to) = if *sum > 0 { (*low, *high) } else { (*high, *low) };
        starts.push(from);
        next.entry(from).or_default().extend((0..sum.abs()).map(|_| to));
    }
    for start in starts {
        // As many edges lead to each corner as away from it, so the way ends where it began.
        let mut way: Vec<u32> = Vec::new();
        let mut place: HashMap<u32, usize> = HashMap::new();
        let mut at = start;
        loop {
            if let Some(from) = place.get(&at) {
                let round = way.split_off(*from);
                found.extend(round.windows(2).skip(1).map(|pair| [pair[1], pair[0], round[0]]));
                for v in &round {
                    place.remove(v);
                }
            }
            let Some(to) = next.get_mut(&at).and_then(Vec::pop) else { break };
            place.insert(at, way.len());
            way.push(at);
            at = to;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::pose::Pose;
    use feeler_shapes::random::Random;
    use feeler_shapes::{box_mesh, box_sides, cylinder, joined, sheet, Arrays};
    use std::f64::consts::TAU;

    fn triangles((vertices, faces): &Arrays) -> Vec<Triangle> {
        faces.iter().map(|face| face.map(|v| vertices[v as usize])).collect()
    }

    fn moved(mesh: &Arrays, at: impl Fn(&Point) -> Point) -> Arrays {
        (mesh.0.iter().map(at).collect(), mesh.1.clone())
    }

    /// The border of some triangles, by their corners.
    fn border(triangles: &[Triangle]) -> Vec<[Point; 2]> {
        let (points, welded) = weld_vertices(&triangles.iter().flatten().copied().collect::<Vec<_>>());
        border_of(&welded).into_iter().map(|edge| edge.ends.map(|v| points[v as usize])).collect()
    }

    /// A box whose sides are moved outwards, each cut otherwise or all alike.
    fn apart(by: f64, is_even: bool) -> Arrays {
        let cuts = |side| if is_even { [3, 2] } else { [[3, 4], [5, 7], [1, 11], [6, 13], [2, 9], [17, 8]][side] };
        let sides = box_sides([0.0; 3], [1.0, 0.7, 0.4], cuts);
        joined(sides.into_iter().enumerate().map(|(i, side)| {
            let out = if i % 2 == 0 { by } else { -by };
            moved(&side, |p| std::array::from_fn(|a| p[a] + if a == i / 2 { out } else { 0.0 }))
        }))
    }

    /// A can whose wall has other corners around than its lids, which are smaller.
    fn can(around: usize, lids: usize, smaller: f64) -> Arrays {
        let (vertices, faces) = cylinder(0.5 - smaller, 1.0, lids, 1);
        let caps = faces.into_iter().filter(|f| f.iter().any(|v| vertices[*v as usize][1..] == [0.0; 2])).collect();
        let wall = sheet(around, 1, |s, t| {
            let phi = TAU * if s == 1.0 { 0.0 } else { s };
            [t - 0.5, 0.5 * phi.sin(), -0.5 * phi.cos()]
        });
        joined([(vertices, caps), wall])
    }

    #[test]
    fn fillings_close_what_has_gaps_and_stay_in_these() {
        let mut r = Random::new(7);
        for (what, mesh, width) in [
            ("box", apart(4e-4, false), 4e-4),
            ("box", apart(1e-6, false), 1e-6),
            ("box cut alike", apart(1e-5, true), 1e-5),
            ("can", can(150, 61, 0.0), 7e-4),
            ("can cut alike", can(90, 90, 1e-4), 1e-4),
        ] {
            for n in 0..20 {
                let turn = Pose::new(&if n > 0 { r.motion(1.0) } else { Pose::IDENTITY.matrix() }).unwrap();
                let mut all = triangles(&moved(&mesh, |p| turn.apply(p)));
                let open = border(&all);
                let filled = fillings(&all);
                assert!(!filled.is_empty());
                for t in &filled {
                    // Each point of a filling is near edges of the border.
                    for shares in [[1.0, 0.0, 0.0], [0.5, 0.5, 0.0], [0.0, 0.5, 0.5], [0.5, 0.0, 0.5], [0.3, 0.3, 0.4]]
                    {
                        let p: Point = std::array::from_fn(|a| (0..3).map(|k| shares[k] * t[k][a]).sum());
                        let off = open.iter().map(|[a, b]| square_to_segment(&p, a, b)).fold(f64::INFINITY, f64::min);
                        assert!(off.sqrt() <= 2.0 * width, "{what} {n}: {t:?}");
                    }
                }
                all.extend(filled);
                assert!(border(&all).iter().all(|[a, b]| length(&sub(a, b)) <= 1e-9), "{what} {n}");
            }
        }
    }

    #[test]
    fn a_surface_without_gaps_needs_no_fillings() {
        assert!(fillings(&triangles(&box_mesh([0.0; 3], [1.0; 3], 3))).is_empty());
        assert!(fillings(&[]).is_empty());
    }

    #[test]
    fn corners_on_the_edges_of_the_other_side_leave_nothing_to_fill() {
        // Sides cut otherwise along edges that coincide, where no triangle between them has an area.
        let mesh = joined(box_sides([0.0; 3], [1.0, 1.0, 1.0], |side| [1 << (side % 3), 1 << (side / 2)]));
        assert!(!border(&triangles(&mesh)).is_empty() && fillings(&triangles(&mesh)).is_empty());
    }
}
