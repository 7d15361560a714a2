//! The verdicts and depths of pairs of parts, compared with integer arithmetic on boxes.

use std::sync::Arc;

use feeler_contacts::{Clash, ClashOptions, ClashSearch, ContactSolver, DepthKind, Verdict};
use feeler_core::{closest_triangle_triangle, Mockup, PairLimitTables, PairLimits, Point, Scene, SceneOptions};
use feeler_shapes::random::Random;
use feeler_shapes::{box_mesh, cylinder, joined, sheet, Arrays};

fn mockup_of(parts: Vec<Arrays>) -> Arc<Mockup> {
    let count = parts.len();
    let part_of_face = parts.iter().zip(0..).flat_map(|(part, i)| vec![i; part.1.len()]).collect();
    let (vertices, faces) = joined(parts);
    Arc::new(Mockup::new(vertices, faces, part_of_face, count).unwrap())
}

fn clashes_of(parts: Vec<Arrays>, clearance: f64, contact: f64) -> Vec<Clash> {
    clashes_between(parts, clearance, contact, Vec::new())
}

/// Limits of all pairs except some.
fn clashes_between(parts: Vec<Arrays>, clearance: f64, contact: f64, excluded: Vec<[u32; 2]>) -> Vec<Clash> {
    let count = parts.len();
    let scene = Scene::build(mockup_of(parts), &SceneOptions::default()).unwrap();
    let mut tables = PairLimitTables::default();
    (tables.clearance, tables.contact, tables.excluded) = (vec![clearance], vec![contact], excluded);
    let limits = PairLimits::new(tables, count).unwrap();
    let solver = ContactSolver::new(Arc::new(scene));
    let mut search = ClashSearch::new(&solver, &limits, &ClashOptions::default()).unwrap();
    assert!(search.find_verdicts() && search.find_gaps());
    search.measure().unwrap()
}

/// A box by its corners, moved by `off`. Boxes that share a corner get exactly the same sum for it.
fn block(lower: Point, upper: Point, cells: usize, off: f64) -> Arrays {
    let (vertices, faces) = box_mesh([0.0; 3], [2.0; 3], cells);
    let place = |p: Point| {
        std::array::from_fn(|a| {
            let share = 0.5 * (p[a] + 1.0);
            off + if share == 1.0 { upper[a] } else { lower[a] + share * (upper[a] - lower[a]) }
        })
    };
    (vertices.into_iter().map(place).collect(), faces)
}

/// How deep two boxes are in each other by points: of each face of the one, as far as it is in the other, the farthest from the sides.
/// Along each axis that is the least room or, where the face goes on past the middle, half the box; the least of the three counts.
fn depth_by_points(p: [Point; 2], q: [Point; 2]) -> f64 {
    let from = |p: [Point; 2], q: [Point; 2]| {
        let mut deepest = 0.0f64;
        for (axis, side) in (0..3).flat_map(|axis| [(axis, 0), (axis, 1)]) {
            let least = (0..3).map(|a| {
                let (low, high) = if a == axis { (p[side][a], p[side][a]) } else { (p[0][a], p[1][a]) };
                let (low, high) = (low.max(q[0][a]), high.min(q[1][a]));
                let best = (0.5 * (q[0][a] + q[1][a])).clamp(low.min(high), high.max(low));
                if low > high {
                    -1.0
                } else {
                    (best - q[0][a]).min(q[1][a] - best)
                }
            });
            deepest = deepest.max(least.fold(f64::INFINITY, f64::min));
        }
        deepest
    };
    from(p, q).max(from(q, p))
}

/// The verdict on two boxes on a lattice, and the length of the shortest translation that frees them, from their sides alone.
fn expected(p: [[i64; 3]; 2], q: [[i64; 3]; 2]) -> Option<(Verdict, Option<i64>)> {
    let shared: [i64; 3] = std::array::from_fn(|a| p[1][a].min(q[1][a]) - p[0][a].max(q[0][a]));
    let least = *shared.iter().min()?;
    let way = (0..3).map(|a| (p[1][a] - q[0][a]).min(q[1][a] - p[0][a])).min();
    let is_in = |p: [[i64; 3]; 2], q: [[i64; 3]; 2]| (0..3).all(|a| q[0][a] <= p[0][a] && p[1][a] <= q[1][a]);
    match least {
        ..=-1 => None,
        0 => Some((Verdict::Contact, Some(0))),
        _ if p == q => Some((Verdict::Duplicate, way)),
        _ if is_in(p, q) || is_in(q, p) => Some((Verdict::Contained, way)),
        _ => Some((Verdict::Clash, way)),
    }
}

fn length(v: &Point) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// The depth is between its bounds, which are no farther apart than promised.
fn assert_depth(row: &Clash, depth: f64, rounding: f64, what: &str) {
    assert!(row.depth <= depth + rounding && depth <= row.depth + row.depth_error + rounding, "{depth}, {what}");
    assert!(row.depth_error <= (1e-3 * row.depth).max(1e-9) && row.kind == DepthKind::Measured, "{what}");
}

#[test]
fn boxes_on_a_lattice_are_to_each_other_what_integers_say() {
    let mut random = Random::new(7);
    let mut counts = [0; 5];
    for n in 0..600 {
        let off = if n % 2 == 0 { 0.0 } else { 3000.0 };
        let [p, q]: [[[i64; 3]; 2]; 2] = std::array::from_fn(|_| {
            let lower: [i64; 3] = std::array::from_fn(|_| random.below(4) as i64);
            [lower, std::array::from_fn(|a| lower[a] + 1 + random.below(4) as i64)]
        });
        let q = if n % 20 == 0 { p } else { q };
        let cells: [usize; 2] = [1 << random.below(3), 1 << random.below(3)];
        let real = |x: [i64; 3]| x.map(|x| x as f64);
        let parts = [p, q].iter().zip(cells).map(|(b, cells)| block(real(b[0]), real(b[1]), cells, off)).collect();
        let found = clashes_of(parts, 0.0, 0.0);
        let what = format!("{p:?} {q:?} {cells:?} at {off}: {found:?}");
        let Some((verdict, way)) = expected(p, q) else {
            assert!(found.is_empty(), "{what}");
            continue;
        };
        counts[verdict as usize] += 1;
        assert_eq!(found.len(), 1, "{what}");
        assert_eq!(found[0].verdict, verdict, "{what}");
        let depth = if verdict == Verdict::Duplicate { 0.0 } else { depth_by_points(p.map(real), q.map(real)) };
        assert_depth(&found[0], depth, 1e-11, &what);
        let (length, way) = (length(&found[0].translation), way.unwrap_or(0) as f64);
        assert!(length >= way && length < way + 1e-4, "{way}, {what}");
        assert_eq!((found[0].gap, found[0].is_open), (0.0, [false; 2]), "{what}");
    }
    assert!(counts.iter().zip([100, 100, 0, 10, 5]).all(|(count, least)| *count >= least), "{counts:?}");
}

/// A name, two boxes, their verdict, and the gap.
type Case = (&'static str, [Point; 2], [Point; 2], Option<Verdict>, f64);

/// The cases that most tools get wrong.
const CASES: [Case; 15] = {
    const CUBE: [Point; 2] = [[0.0; 3], [2.0; 3]];
    [
        ("apart by 0.5", CUBE, [[2.5, 0.0, 0.0], [4.0, 2.0, 2.0]], None, 0.0),
        ("a gap of 1e-3", CUBE, [[2.001, 0.0, 0.0], [4.0, 2.0, 2.0]], Some(Verdict::Clearance), 1e-3),
        ("a gap of 1e-6", CUBE, [[2.000_001, 0.0, 0.0], [4.0, 2.0, 2.0]], Some(Verdict::Clearance), 1e-6),
        ("an overlap of 1e-6", CUBE, [[1.999_999, 0.5, 0.5], [4.0, 1.5, 1.5]], Some(Verdict::Clash), 0.0),
        ("flush, equal", CUBE, [[2.0, 0.0, 0.0], [4.0, 2.0, 2.0]], Some(Verdict::Contact), 0.0),
        ("flush, unequal", CUBE, [[2.0, 0.5, 0.3], [4.0, 1.5, 1.2]], Some(Verdict::Contact), 0.0),
        ("an edge", CUBE, [[2.0, 2.0, 0.0], [4.0, 4.0, 2.0]], Some(Verdict::Contact), 0.0),
        ("a vertex", CUBE, [[2.0; 3], [4.0; 3]], Some(Verdict::Contact), 0.0),
        ("walls in line", [[0.0; 3], [4.0, 0.2, 3.0]], [[3.95, 0.0, 0.0], [8.0, 0.2, 3.0]], Some(Verdict::Clash), 0.0),
        ("1.5 deep", CUBE, [[0.5, 0.3, 0.3], [2.5, 1.7, 1.7]], Some(Verdict::Clash), 0.0),
        ("1.5 deep, flush", CUBE, [[0.5, 0.0, 0.0], [2.5, 2.0, 2.0]], Some(Verdict::Clash), 0.0),
        ("contained", CUBE, [[0.5, 0.6, 0.7], [1.0, 1.1, 1.2]], Some(Verdict::Contained), 0.5),
        ("contained, flush", CUBE, [[0.5, 0.6, 0.0], [1.0, 1.1, 1.2]], Some(Verdict::Contained), 0.0),
        ("a bar right through", CUBE, [[-1.0, 0.9, 0.9], [3.0, 1.1, 1.1]], Some(Verdict::Clash), 0.0),
        ("a corner in", CUBE, [[1.9, 1.8, 1.7], [3.0; 3]], Some(Verdict::Clash), 0.0),
    ]
};

#[test]
fn cases_of_which_tools_are_mostly_wrong() {
    for (name, p, q, verdict, gap) in CASES {
        for off in [0.0, 3000.0] {
            // 12, 48, 300 and 3,072 triangles a box.
            for cells in [[1, 1], [2, 2], [5, 5], [16, 16], [1, 16], [5, 2]] {
                for [i, j] in [[0, 1], [1, 0]] {
                    let both = [block(p[0], p[1], cells[0], off), block(q[0], q[1], cells[1], off)];
                    let found = clashes_of(vec![both[i].clone(), both[j].clone()], 0.002, 0.0);
                    let what = format!("{name}, {cells:?} cells at {off}: {found:?}");
                    assert_eq!(found.first().map(|row| row.verdict), verdict, "{what}");
                    for row in found {
                        let depth =
                            if gap > 0.0 && verdict != Some(Verdict::Contained) { 0.0 } else { depth_by_points(p, q) };
                        assert_depth(&row, depth, 1e-11, &what);
                        assert!((row.gap - gap).abs() < 1e-11, "{what}");
                    }
                }
            }
        }
    }
}

/// A ring around z with this many sides, of height 2.
fn ring(inner: f64, outer: f64, sides: u32, off: f64) -> Arrays {
    let around = |radius: f64, z: f64| {
        (0..sides).map(move |i| {
            let (s, c) = (std::f64::consts::TAU * f64::from(i) / f64::from(sides)).sin_cos();
            [off + radius * c, off + radius * s, off + z]
        })
    };
    let vertices =
        [(inner, 0.0), (inner, 2.0), (outer, 2.0), (outer, 0.0)].map(|(r, z)| around(r, z).collect::<Vec<_>>());
    let at = |circle: u32, i: u32| circle % 4 * sides + i % sides;
    let quad = |[a, b, c, d]: [u32; 4]| [[a, b, c], [a, c, d]];
    let sides_of = |circle| {
        (0..sides).flat_map(move |i| quad([at(circle, i), at(circle, i + 1), at(circle + 1, i + 1), at(circle + 1, i)]))
    };
    (vertices.concat(), (0..4).flat_map(sides_of).collect())
}

/// A pin with the same sides, from `low` to `high`.
fn pin(radius: f64, sides: u32, [low, high]: [f64; 2], off: f64) -> Arrays {
    let (mut vertices, mut faces) = (Vec::new(), Vec::new());
    for z in [low, high] {
        vertices.extend((0..sides).map(|i| {
            let (s, c) = (std::f64::consts::TAU * f64::from(i) / f64::from(sides)).sin_cos();
            [off + radius * c, off + radius * s, off + z]
        }));
    }
    vertices.extend([[off, off, off + low], [off, off, off + high]]);
    for i in 0..sides {
        let j = (i + 1) % sides;
        faces.extend([
            [i, j, sides + j],
            [i, sides + j, sides + i],
            [2 * sides, j, i],
            [2 * sides + 1, sides + i, sides + j],
        ]);
    }
    (vertices, faces)
}

#[test]
fn a_pin_in_its_hole_is_in_contact_and_not_deep() {
    for off in [0.0, 3000.0] {
        for ends in [[-1.0, 3.0], [0.0, 2.0], [0.5, 1.5]] {
            let found = clashes_of(vec![pin(0.5, 64, ends, off), ring(0.5, 1.5, 64, off)], 0.0, 0.0);
            assert_eq!(found.len(), 1);
            let row = &found[0];
            assert_eq!((row.verdict, row.depth, row.translation), (Verdict::Contact, 0.0, [0.0; 3]), "{ends:?} {off}");
            assert!(row.triangles >= 64 && row.kind == DepthKind::Measured, "{row:?}");
        }
        // The pin is slightly too thick.
        let found = clashes_of(vec![pin(0.501, 64, [-1.0, 3.0], off), ring(0.5, 1.5, 64, off)], 0.0, 0.0);
        assert_eq!(found[0].verdict, Verdict::Clash);
        assert!(found[0].depth > 0.9e-3, "{found:?}");
    }
}

#[test]
fn what_is_no_deeper_than_contact_allows_is_contact() {
    let both = || vec![block([0.0; 3], [1.0; 3], 2, 0.0), block([0.999, 0.2, 0.2], [2.0, 0.9, 0.9], 1, 0.0)];
    for (contact, verdict) in [(0.0, Verdict::Clash), (0.0009, Verdict::Clash), (0.0011, Verdict::Contact)] {
        let row = &clashes_of(both(), 0.0, contact)[0];
        assert_eq!(row.verdict, verdict);
        assert!((row.depth - 0.001).abs() < 1e-9 && row.gap == 0.0, "{row:?}");
    }
}

#[test]
fn a_gap_that_contact_allows_is_contact() {
    let both = || vec![block([0.0; 3], [1.0; 3], 2, 0.0), block([1.001, 0.0, 0.0], [2.0, 1.0, 1.0], 1, 0.0)];
    assert!(clashes_of(both(), 0.0, 0.0).is_empty());
    assert_eq!(clashes_of(both(), 0.002, 0.0)[0].verdict, Verdict::Clearance);
    for clearance in [0.0, 0.01] {
        let row = &clashes_of(both(), clearance, 0.002)[0];
        assert_eq!((row.verdict, row.depth), (Verdict::Contact, 0.0));
        assert!((row.gap - 0.001).abs() < 1e-12, "{row:?}");
    }
}

#[test]
fn open_surfaces_are_told_and_hold_nothing() {
    let cube = block([0.0; 3], [2.0; 3], 3, 0.0);
    let square =
        |half: f64, z: f64| sheet(4, 4, move |s, t| [1.0 + half * (2.0 * s - 1.0), 1.0 + half * (2.0 * t - 1.0), z]);
    // A bar through the box, one inside it, and one on its face.
    for (sheet, verdict) in [
        (square(1.5, 0.9), Verdict::Clash),
        (square(0.5, 0.9), Verdict::Contained),
        (square(0.5, 2.0), Verdict::Contact),
    ] {
        let row = &clashes_of(vec![sheet, cube.clone()], 0.0, 0.0)[0];
        assert_eq!((row.verdict, row.is_open), (verdict, [true, false]), "{row:?}");
    }
    // A box without one face, with a small one in it, and on its floor.
    let mut open = cube;
    open.1.truncate(open.1.len() - 2);
    assert!(clashes_of(vec![open.clone(), block([0.5; 3], [1.0; 3], 1, 0.0)], 0.0, 0.0).is_empty());
    let on_floor = block([0.5, 0.5, 0.0], [1.0; 3], 1, 0.0);
    assert_ne!(clashes_of(vec![open, on_floor], 0.0, 0.0)[0].verdict, Verdict::Contained);
}

#[test]
fn points_of_open_parts_are_on_their_surfaces() {
    let mut r = Random::new(7);
    let mut clashes = 0;
    for n in 0..60 {
        // Either of them has fewer triangles, and serves as the tool.
        let cells = if n % 2 == 0 { [4, 7] } else { [7, 4] };
        let parts = cells.map(|cells| {
            let (bend, m) = (r.real(-2.0, 2.0), r.motion(0.3));
            let place = |p: Point| std::array::from_fn(|a| m[a][3] + (0..3).map(|b| m[a][b] * p[b]).sum::<f64>());
            sheet(cells, cells, |s, t| place([s - 0.5, t - 0.5, bend * (s - 0.5) * (t - 0.3)]))
        });
        for row in clashes_of(parts.to_vec(), 0.0, 0.0) {
            assert_eq!((row.is_open, row.kind), ([true, true], DepthKind::Estimate));
            for (p, (vertices, faces)) in row.points.iter().zip(&parts) {
                let to_face = |face: &[u32; 3]| {
                    closest_triangle_triangle(&[*p; 3], &face.map(|corner| vertices[corner as usize])).distance
                };
                let off = faces.iter().map(to_face).fold(f64::INFINITY, f64::min);
                assert!(off < 1e-12, "{off} {row:?}");
            }
            clashes += usize::from(row.verdict == Verdict::Clash);
        }
    }
    assert!(clashes > 20, "{clashes}");
}

#[test]
fn parts_are_the_same_whatever_the_order_and_all_their_pairs_are_told() {
    let (vertices, mut faces) = cylinder(0.3, 1.0, 12, 2);
    faces.reverse();
    let parts =
        vec![(vertices, faces), cylinder(0.3, 1.0, 12, 2), box_mesh([5.0; 3], [1.0; 3], 1), cylinder(0.3, 1.0, 12, 2)];
    let found = clashes_of(parts, 0.0, 0.0);
    assert_eq!(found.iter().map(|row| row.parts).collect::<Vec<_>>(), [[0, 1], [0, 3], [1, 3]]);
    assert!(found
        .iter()
        .all(|row| row.verdict == Verdict::Duplicate && row.depth == found[0].depth && row.triangles > 100));
}

#[test]
fn of_parts_that_are_the_same_only_pairs_that_are_asked_are_told() {
    let parts: Vec<Arrays> = [0.0; 4].map(|_| cylinder(0.3, 1.0, 12, 2)).into();
    for excluded in [vec![[0, 1]], vec![[3, 1], [2, 0]], vec![[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]]] {
        let found = clashes_between(parts.clone(), 0.0, 0.0, excluded.clone());
        let all = (0..4).flat_map(|a| (a + 1..4).map(move |b| [a, b]));
        let asked: Vec<[u32; 2]> =
            all.filter(|[a, b]| !excluded.contains(&[*a, *b]) && !excluded.contains(&[*b, *a])).collect();
        assert_eq!(found.iter().map(|row| row.parts).collect::<Vec<_>>(), asked);
        assert!(found.iter().all(|row| row.verdict == Verdict::Duplicate && row.triangles == found[0].triangles));
    }
}

#[test]
fn a_hollow_part_holds_what_is_in_its_material_and_not_what_is_in_its_hollow() {
    let (vertices, faces) = block([1.0; 3], [3.0; 3], 2, 0.0);
    let hollow =
        joined([block([0.0; 3], [4.0; 3], 2, 0.0), (vertices, faces.into_iter().map(|[a, b, c]| [a, c, b]).collect())]);
    let inside = block([0.2; 3], [0.7; 3], 1, 0.0);
    let in_hollow = block([1.5; 3], [2.0; 3], 1, 0.0);
    let found = clashes_of(vec![hollow, inside, in_hollow], 0.0, 0.0);
    assert_eq!(found.iter().map(|row| (row.parts, row.verdict)).collect::<Vec<_>>(), [([0, 1], Verdict::Contained)]);
}

#[test]
fn what_touches_is_judged_by_all_of_it() {
    let cube = block([0.0; 3], [2.0; 3], 2, 0.0);
    let flush = block([0.5, 0.6, 0.0], [1.0, 1.1, 1.2], 1, 0.0);
    let verdict = |p: &Arrays, q: Arrays| clashes_of(vec![p.clone(), q], 0.0, 0.0)[0].verdict;
    // A part beside the cube that has a second surface inside it: the cube holds a solid of it, and nothing crosses.
    let beside = block([2.0, 0.0, 0.0], [3.0, 1.0, 1.0], 1, 0.0);
    assert_eq!(verdict(&cube, beside.clone()), Verdict::Contact);
    assert_eq!(verdict(&cube, joined([beside.clone(), block([0.5; 3], [1.0; 3], 1, 0.0)])), Verdict::Contained);
    assert_eq!(verdict(&cube, joined([beside, block([1.5, 0.5, 0.5], [2.5, 1.5, 1.5], 1, 0.0)])), Verdict::Clash);
    // A part inside the cube that has a second surface outside it.
    assert_eq!(verdict(&cube, flush.clone()), Verdict::Contained);
    assert_eq!(verdict(&cube, joined([flush, block([5.0; 3], [6.0; 3], 1, 0.0)])), Verdict::Contained);
    // A bar from one cheek to the next, with corners where it leaves the one and enters the other and none between.
    let cheeks =
        joined([block([-2.0, 0.0, 0.0], [1.0, 3.0, 3.0], 1, 0.0), block([3.0, 0.0, 0.0], [6.0, 3.0, 3.0], 1, 0.0)]);
    assert_eq!(verdict(&cheeks, block([-1.0, 1.0, 1.0], [5.0, 2.0, 2.0], 3, 0.0)), Verdict::Clash);
}

/// Boxes by their corners, as one part.
type Boxes = Vec<[Point; 2]>;

#[test]
fn a_way_out_leads_out_of_all_of_the_other_part() {
    // A wall is 2 mm deep in a cube, and pushes it aside by as much: into a step that is 1 mm off, or a bar, over a pebble that is then
    // inside of it, or with a pebble of its own into a block.
    let (cube, wall) = ([[0.0; 3], [0.02; 3]], [[-0.02, -0.01, 0.005], [0.002, 0.03, 0.05]]);
    let cases: [(&str, Boxes, Boxes); 4] = [
        ("a step", vec![cube], vec![wall, [[0.021, -0.01, -0.02], [0.05, 0.03, 0.0005]]]),
        // No corner of either is in the other.
        ("a bar", vec![cube], vec![wall, [[0.021, -0.05, 0.008], [0.0215, 0.05, 0.012]]]),
        ("a pebble", vec![cube], vec![wall, [[0.0205, 0.01, 0.01], [0.0215, 0.011, 0.011]]]),
        (
            "its own pebble",
            vec![cube, [[0.03, 0.01, 0.01], [0.031, 0.011, 0.011]]],
            vec![wall, [[0.0312, 0.0, 0.0], [0.04, 0.02, 0.02]]],
        ),
    ];
    for (name, first, second) in cases {
        for (one, other, cells) in [(&first, &second, [1, 2]), (&second, &first, [2, 1])] {
            let part = |boxes: &Boxes, cells| joined(boxes.iter().map(|[p, q]| block(*p, *q, cells, 0.0)));
            let found = clashes_of(vec![part(one, cells[0]), part(other, cells[1])], 0.0, 0.0);
            assert_eq!((found.len(), found[0].verdict), (1, Verdict::Clash), "{name}");
            let by = found[0].translation;
            let apart =
                |p: &[Point; 2], q: &[Point; 2]| (0..3).any(|a| p[0][a] + by[a] > q[1][a] || q[0][a] > p[1][a] + by[a]);
            assert!(one.iter().all(|p| other.iter().all(|q| apart(p, q))), "{name}: {by:?}");
        }
    }
}
