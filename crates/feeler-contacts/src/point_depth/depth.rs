//! The depth by points of two bodies, whether it exceeds a limit, and whether two surfaces are the same.

use feeler_core::{GoOn, Point};

use super::body::Body;
use super::farthest::{farthest, Asked, Counted, Direction, Farthest};

/// The kind of a depth. The numbers are those of `feeler.clashes.verdict.DEPTH_KINDS`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum DepthKind {
    /// Measured by points of both surfaces, within its error.
    Measured = 0,
    /// A part has no closed surface, and so no inside. If the other has one, only points of the open surface count; if not, the depth is
    /// how far the surfaces cross.
    Estimate = 1,
}

/// How deep two bodies are in each other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointDepth {
    /// No more than the depth, metres.
    pub depth: f64,
    /// How much more it can be, metres.
    pub error: f64,
    /// The deepest point of the one surface and the closest of the other, in the world, that of the first body first.
    pub points: Option<[Point; 2]>,
}

fn inside<'a>(surface: &'a Body, other: &'a Body) -> Direction<'a> {
    Direction { surface, other, counted: Counted::Inside }
}

fn depth_of<'a, const N: usize>(directions: [Direction<'a>; N], go_on: GoOn<'a>) -> PointDepth {
    let Farthest { lower, upper, direction, points } = farthest(directions, Asked::Value, go_on);
    let points = points.map(|[p, q]| if direction == 0 { [p, q] } else { [q, p] });
    PointDepth { depth: lower, error: upper - lower, points }
}

fn is_more<const N: usize>(directions: [Direction<'_>; N], than: f64) -> bool {
    farthest(directions, Asked::IsMore(than), GoOn::default()).upper.is_infinite()
}

/// The farthest that a point of one surface is inside the other body.
pub fn point_depth(pair: [&Body; 2]) -> PointDepth {
    point_depth_while(pair, GoOn::default())
}

/// The same. Where it is stopped, the depth is no more than the true one, and the error as large as is known by then.
pub fn point_depth_while<'a>([a, b]: [&'a Body; 2], go_on: GoOn<'a>) -> PointDepth {
    depth_of([inside(a, b), inside(b, a)], go_on)
}

/// The farthest that a point of the first surface is inside the second body.
pub fn point_depth_from([a, b]: [&Body; 2]) -> PointDepth {
    depth_of([inside(a, b)], GoOn::default())
}

/// Whether the depth is more than a limit, metres, but for rounding.
pub fn is_deeper([a, b]: [&Body; 2], than: f64) -> bool {
    is_more([inside(a, b), inside(b, a)], than)
}

/// Whether a point of the first surface is farther than a limit inside the second body, metres.
pub fn is_deeper_from([a, b]: [&Body; 2], than: f64) -> bool {
    is_more([inside(a, b)], than)
}

/// Whether each surface is nowhere farther than this from the other, metres.
pub fn is_same_surface([a, b]: [&Body; 2], within: f64) -> bool {
    let all = |surface, other| Direction { surface, other, counted: Counted::All };
    !is_more([all(a, b), all(b, a)], within)
}

/// Whether the second body holds the first: no point of the first surface is farther than this outside it, and no point of its own is
/// farther inside the first, metres.
pub fn is_holding([a, b]: [&Body; 2], within: f64) -> bool {
    b.is_closed() && !is_more([Direction { surface: a, other: b, counted: Counted::Outside }, inside(b, a)], within)
}

#[cfg(test)]
mod tests {
    use super::super::brute::{block, body, distance, hollow_box, inside_out, placed, point_of};
    use super::*;
    use feeler_core::geometry::vectors::{length, sub};
    use feeler_core::mesh::topology::adjacency::Adjacency;
    use feeler_shapes::random::Random;
    use feeler_shapes::{ball, box_mesh, box_sides, cylinder, joined, sheet, Arrays, Matrix};

    /// Where things are as they are, turned, far off, and both.
    fn places() -> Vec<Matrix> {
        let mut r = Random::new(3);
        let far = |mut m: Matrix| {
            (0..3).for_each(|a| m[a][3] += [2000.0, -700.0, 5000.0][a]);
            m
        };
        let still = std::array::from_fn(|i| std::array::from_fn(|j| if i == j { 1.0 } else { 0.0 }));
        let turned = r.motion(1.0);
        vec![still, turned, r.motion(3.0), far(still), far(turned)]
    }

    /// Checks a depth against the known one at many places, turns and triangulations, and checks its two points.
    fn assert_depth(p: impl Fn(usize) -> Arrays, q: impl Fn(usize) -> Arrays, expected: f64, what: &str) {
        for (m, cells) in places().iter().flat_map(|m| [(m, [1, 1]), (m, [2, 3]), (m, [6, 1])]) {
            let [a, b] = [placed(p(cells[0]), m), placed(q(cells[1]), m)].map(body);
            for pair in [[&a, &b], [&b, &a]] {
                let found = point_depth(pair);
                let slack = 1e-10;
                assert!(found.depth <= expected + slack, "{what}, {cells:?}: {found:?}, {expected}");
                assert!(found.depth + found.error >= expected - slack, "{what}, {cells:?}: {found:?}, {expected}");
                assert!(found.error <= (1e-3 * found.depth).max(1e-9) + slack, "{what}, {cells:?}: {found:?}");
                if found.depth > slack {
                    assert_attained(pair, &found, what);
                }
                if expected > slack {
                    assert!(is_deeper(pair, 0.999 * expected) && is_deeper(pair, 0.5 * expected), "{what}, {cells:?}");
                    assert!(is_deeper(pair, expected - 4.0 * slack) && is_deeper(pair, 0.0), "{what}, {cells:?}");
                }
                assert!(!is_deeper(pair, expected + slack), "{what}, {cells:?}");
                assert!(!is_deeper(pair, 1.001 * expected + slack), "{what}, {cells:?}");
            }
            let one = [point_depth_from([&a, &b]).depth, point_depth_from([&b, &a]).depth];
            let most = one[0].max(one[1]);
            assert!((most - point_depth([&a, &b]).depth).abs() <= 2e-3 * most + 1e-9, "{what}");
        }
    }

    /// The first point is on the first surface, the second on the second, one of them inside the other body, and both as far apart as said.
    fn assert_attained([a, b]: [&Body; 2], found: &PointDepth, what: &str) {
        let points = found.points.unwrap();
        let rounding = (2.0 * a.rounding().max(b.rounding())).max(1e-11);
        for (p, own) in points.iter().zip([a, b]) {
            assert!(distance(own, &sub(p, own.origin())) < rounding, "{what}: {found:?}");
        }
        assert!((length(&sub(&points[0], &points[1])) - found.depth).abs() < rounding, "{what}: {found:?}");
        let is_inside = |p: &Point, of: &Body| of.is_inside(&sub(p, of.origin())) == Some(true);
        let far = |p: &Point, of: &Body| (distance(of, &sub(p, of.origin())) - found.depth).abs() < rounding;
        let is_deepest = |p: &Point, of: &Body| is_inside(p, of) && far(p, of);
        assert!(is_deepest(&points[0], b) || is_deepest(&points[1], a), "{what}: {found:?}");
    }

    #[test]
    fn boxes_are_as_deep_as_their_sides_say() {
        let slab = |cells| block([-3.0, -3.0, -1.0], [3.0, 3.0, 0.0], cells);
        let sunk = |depth: f64| move |cells| block([-0.5, -0.4, -depth], [0.7, 0.6, 2.0 - depth], cells);
        for depth in [1e-6, 0.01, 0.3, 0.499] {
            assert_depth(slab, sunk(depth), depth, "a box sunk into a slab");
        }
        // Past the middle it is the middle, and through the slab too.
        assert_depth(slab, sunk(0.7), 0.5, "a box sunk past the middle");
        assert_depth(slab, sunk(1.5), 0.5, "a box through a slab");
        // A cube in a slab, nearer to one side: its top is farthest from the lower side, but nearer to the upper one.
        assert_depth(slab, |cells| block([0.0, 0.0, -0.5], [0.4, 0.4, -0.1], cells), 0.5, "a cube in a slab");
        // Corner in corner: the corner is as far from each of three sides.
        assert_depth(|c| block([0.0; 3], [1.0; 3], c), |c| block([0.75; 3], [2.0; 3], c), 0.25, "corner in corner");
        // Edges of both.
        assert_depth(
            |c| block([0.0; 3], [1.0, 1.0, 4.0], c),
            |c| block([0.8, 0.7, 1.0], [2.0, 2.0, 3.0], c),
            0.2,
            "edge in edge",
        );
    }

    #[test]
    fn walls_that_cross_are_as_deep_as_half_the_thicker_one() {
        let wall = |cells| block([-2.0, -2.0, -0.1], [2.0, 2.0, 0.1], cells);
        assert_depth(wall, |cells| block([-0.15, -3.0, -3.0], [0.15, 3.0, 3.0], cells), 0.15, "walls that cross");
        assert_depth(wall, |cells| block([-0.02, -1.0, -3.0], [0.02, 1.0, 3.0], cells), 0.1, "a thin wall through one");
    }

    #[test]
    fn concentric_boxes_are_as_deep_as_the_middle_of_the_inner_ones_side_is() {
        let inner = |cells| block([-1.0; 3], [1.0; 3], cells);
        assert_depth(inner, |cells| block([-3.0; 3], [3.0; 3], cells), 2.0, "a box in a box");
        // The nearest sides count, in the middle of the inner one's height.
        assert_depth(inner, |cells| block([-9.0, -4.0, -3.0], [9.0, 4.0, 3.0], cells), 3.0, "a box in a long box");
        // A plate beside a small hollow, and its farthest corner: nothing else is near.
        let farthest = (2.0 * 0.49f64 * 0.49 + 0.11 * 0.11).sqrt();
        let plate = |cells| block([-0.5, -0.5, 0.1], [0.5, 0.5, 0.12], cells);
        assert_depth(plate, |cells| hollow_box(10.0, 0.02, cells), farthest, "a plate beside a small hollow");
        // In a hollow there is no depth.
        assert_depth(inner, |cells| hollow_box(8.0, 4.0, cells), 0.0, "a box in a hollow");
        assert_depth(
            |c| block([-2.5; 3], [1.0; 3], c),
            |c| hollow_box(8.0, 4.0, c),
            0.75f64.sqrt(),
            "a box in the corner of a hollow one",
        );
    }

    #[test]
    fn what_touches_or_is_apart_is_not_deep() {
        let cube = |cells| block([0.0; 3], [1.0; 3], cells);
        assert_depth(cube, |cells| block([1.0, 0.0, 0.0], [2.0, 1.0, 1.0], cells), 0.0, "flush");
        assert_depth(cube, |cells| block([1.0, 0.3, -0.5], [2.0, 0.7, 3.0], cells), 0.0, "flush, aside");
        assert_depth(cube, |cells| block([1.0; 3], [2.0; 3], cells), 0.0, "corner on corner");
        assert_depth(cube, |cells| block([1.1, 0.0, 0.0], [2.0; 3], cells), 0.0, "apart");
        assert_depth(cube, cube, 0.0, "the same");
        assert_depth(cube, |cells| inside_out(block([0.0; 3], [1.0; 3], cells)), 0.0, "the same, wound the other way");
    }

    #[test]
    fn windings_do_not_matter_and_flush_sides_do_not_hide_depth() {
        let cube = |cells| inside_out(block([0.0; 3], [1.0; 3], cells));
        assert_depth(cube, |cells| block([0.75, 0.0, 0.0], [2.0, 1.0, 1.0], cells), 0.25, "flush on four sides");
        assert_depth(cube, |cells| block([0.9, 0.0, 0.25], [2.0, 1.0, 0.75], cells), 0.1, "flush on two sides");
        // The middle of the cube is the cut face of its half.
        assert_depth(cube, |cells| block([0.0; 3], [0.5, 1.0, 1.0], cells), 0.5, "a half of it");
    }

    #[test]
    fn a_turned_box_in_a_slab_is_as_deep_as_its_lowest_corner() {
        let mut r = Random::new(5);
        for n in 0..20 {
            let m = r.motion(0.0);
            let cube = placed(box_mesh([0.0; 3], [1.0, 0.8, 0.6], 1 + n % 3), &m);
            let low = cube.0.iter().map(|p| p[2]).fold(f64::INFINITY, f64::min);
            let depth = r.real(1e-3, 0.2);
            let lowered: Arrays = (cube.0.iter().map(|p| [p[0], p[1], p[2] - low - depth]).collect(), cube.1.clone());
            let slab = |cells| block([-9.0, -9.0, -9.0], [9.0, 9.0, 0.0], cells);
            assert_depth(slab, |_| lowered.clone(), depth, "a turned box in a slab");
        }
    }

    #[test]
    fn a_ball_in_a_ball_is_about_as_deep_as_their_radii_say() {
        let moved = |(vertices, faces): Arrays| -> Arrays {
            (vertices.iter().map(|p| [p[0] + 1.6, p[1], p[2]]).collect(), faces)
        };
        for n in [8, 24] {
            let [a, b] = [body(ball(1.0, n)), body(moved(ball(1.0, n)))];
            let found = point_depth([&a, &b]);
            assert!((found.depth - 0.4).abs() < 0.05 && found.error < 4.1e-4, "{found:?}");
            assert_attained([&a, &b], &found, "balls");
        }
    }

    #[test]
    fn a_search_that_is_stopped_leaves_true_bounds() {
        use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};
        // About as deep everywhere: no piece can be left out soon.
        let [a, b] = [body(ball(1.0, 10)), body(ball(0.998, 11))];
        let whole = point_depth([&a, &b]);
        let stopped_at = |question: usize| {
            let asked = AtomicUsize::new(0);
            let goes_on = || asked.fetch_add(1, Relaxed) < question;
            (point_depth_while([&a, &b], GoOn::new(&goes_on)), asked.into_inner())
        };
        let (same, questions) = stopped_at(usize::MAX);
        assert!(same == whole && questions > 4, "{questions}");
        for question in 0..questions.min(5) {
            let (stopped, asked) = stopped_at(question);
            assert_eq!(asked, question + 1, "it is not asked again");
            assert!(stopped.depth <= whole.depth + whole.error, "{stopped:?} {whole:?}");
            assert!(stopped.depth + stopped.error >= whole.depth && stopped.error > whole.error, "{stopped:?}");
        }
    }

    #[test]
    fn wires_of_one_radius_are_as_deep_as_their_facets_say() {
        for (length, radius, n) in [(1.0, 1e-5, 16), (1.0, 1e-7, 16), (1.0, 1e-3, 64), (1e4, 0.5, 360), (1e4, 2.0, 60)]
        {
            // Middles of facets are below corners of the other, which is turned by half a facet.
            let half = std::f64::consts::PI / n as f64;
            let expected = radius * half.cos() * (1.0 - half.cos());
            let (s, c) = half.sin_cos();
            let wire = cylinder(radius, length, n, 1);
            let turned = (wire.0.iter().map(|[x, y, z]| [*x, c * y - s * z, s * y + c * z]).collect(), wire.1.clone());
            for m in places() {
                let [a, b] = [&wire, &turned].map(|mesh| body(placed(mesh.clone(), &m)));
                let found = point_depth([&a, &b]);
                // Rounding of the corners far off.
                let slack = a.rounding().max(b.rounding());
                assert!(found.depth <= expected + slack, "{length} {radius}: {found:?} {expected}");
                assert!(found.depth + found.error >= expected - slack, "{length} {radius}: {found:?} {expected}");
                assert!(found.error <= (1e-3 * found.depth).max(1e-9) + 1e-12, "{length} {radius}: {found:?}");
                assert_attained([&a, &b], &found, "wires");
            }
        }
    }

    #[test]
    fn no_point_inside_is_deeper_than_the_bound() {
        let mut r = Random::new(6);
        let (mut deep, mut reached) = (0, 0);
        for n in 0..120 {
            let shape = |r: &mut Random| match r.below(4) {
                0 => ball(0.6, 4 + r.below(4) as usize),
                1 => hollow_box(1.2, 0.7, 1 + r.below(3) as usize),
                2 => joined([block([0.0; 3], [1.0, 0.3, 0.3], 1), block([-0.5, 0.0, 0.0], [-0.2, 1.0, 0.3], 2)]),
                _ => box_mesh([0.0; 3], r.point(0.3, 1.2), 1 + r.below(3) as usize),
            };
            let [a, b] = [shape(&mut r), shape(&mut r)].map(|mesh| body(placed(mesh, &r.motion(0.4))));
            let found = point_depth([&a, &b]);
            let mut deepest = 0.0f64;
            for [own, other] in [[&a, &b], [&b, &a]] {
                for i in 0..own.len() as u32 {
                    for _ in 0..(600 / own.len()).max(2) {
                        let world =
                            feeler_core::geometry::vectors::add(&point_of(&mut r, own.triangle(i)), own.origin());
                        let p = sub(&world, other.origin());
                        if other.is_inside(&p) == Some(true) {
                            deepest = deepest.max(distance(other, &p));
                        }
                    }
                }
            }
            assert!(deepest <= found.depth + found.error + 1e-12, "{n}: {deepest} {found:?}");
            assert!(found.error <= (1e-3 * found.depth).max(1e-9) + 1e-12, "{n}: {found:?}");
            if found.depth > 0.0 {
                deep += 1;
                assert_attained([&a, &b], &found, "random shapes");
                reached += usize::from(deepest >= 0.8 * found.depth);
            }
        }
        assert!(deep > 80 && 4 * reached > 3 * deep, "{deep} {reached}");
    }

    #[test]
    fn open_surfaces_have_no_inside_but_are_inside_others() {
        let plate = body(sheet(2, 2, |u, v| [4.0 * u - 2.0, 4.0 * v - 2.0, 0.25]));
        let (cube, other) = (body(block([-1.0; 3], [1.0; 3], 2)), body(sheet(1, 1, |u, v| [u, 0.5, v - 0.5])));
        let found = point_depth([&plate, &cube]);
        assert!((found.depth - 0.75).abs() < 1e-3, "{found:?}");
        assert_attained([&plate, &cube], &found, "a sheet through a cube");
        assert_eq!(point_depth_from([&cube, &plate]), PointDepth { depth: 0.0, error: 0.0, points: None });
        assert_eq!(point_depth([&plate, &other]), PointDepth { depth: 0.0, error: 0.0, points: None });
        assert!(
            !is_holding([&cube, &plate], 2.0) && is_deeper([&plate, &cube], 0.74) && !is_deeper([&plate, &cube], 0.76)
        );
    }

    #[test]
    fn nothing_is_not_deep_in_anything() {
        let (nothing, cube) =
            (Body::new([].into_iter(), &Adjacency::of_neighbours(Vec::new())), body(block([-1.0; 3], [1.0; 3], 1)));
        for pair in [[&nothing, &cube], [&cube, &nothing], [&nothing, &nothing]] {
            assert_eq!(point_depth(pair), PointDepth { depth: 0.0, error: 0.0, points: None });
            assert!(!is_deeper(pair, 0.0));
        }
    }

    #[test]
    fn surfaces_are_the_same_however_they_are_cut() {
        let sides =
            |n: usize| joined(box_sides([0.0; 3], [1.0, 2.0, 3.0], |side| [1 + (side + n) % 3, 1 + side * n % 4]));
        for m in places() {
            let one = body(placed(box_mesh([0.0; 3], [1.0, 2.0, 3.0], 1), &m));
            for n in 0..4 {
                let other = body(placed(inside_out(sides(n)), &m));
                assert!(is_same_surface([&one, &other], 1e-9) && is_same_surface([&other, &one], 1e-9));
            }
            // One corner is moved by a thousandth; a hollow is added; a side is missing.
            let (mut vertices, faces) = box_mesh([0.0; 3], [1.0, 2.0, 3.0], 2);
            let corner = vertices[0];
            vertices.iter_mut().filter(|p| **p == corner).for_each(|p| p[0] += 1e-3);
            let moved = body(placed((vertices, faces), &m));
            let hollow = joined([box_mesh([0.0; 3], [1.0, 2.0, 3.0], 1), inside_out(box_mesh([0.0; 3], [0.2; 3], 1))]);
            let hollow = body(placed(hollow, &m));
            let five = box_sides([0.0; 3], [1.0, 2.0, 3.0], |_| [1; 2]).into_iter().skip(1);
            let five = body(placed(joined(five), &m));
            for (other, off) in [(&moved, 1e-3), (&hollow, 0.5), (&five, 1.0)] {
                for pair in [[&one, other], [other, &one]] {
                    assert!(!is_same_surface(pair, 0.9 * off) && is_same_surface(pair, 1.1 * off), "{off}");
                }
            }
        }
    }

    #[test]
    fn a_body_holds_what_is_in_its_material() {
        for m in places() {
            let of = |mesh: Arrays| body(placed(mesh, &m));
            let holder = of(block([0.0; 3], [1.0; 3], 2));
            for (low, high, within, is_held) in [
                // Inside; flush with three sides; all of it; out by a hundredth.
                ([0.2; 3], [0.5; 3], 1e-9, true),
                ([0.0; 3], [0.5; 3], 1e-9, true),
                ([0.0; 3], [1.0; 3], 1e-9, true),
                ([0.2, 0.2, -0.01], [0.5; 3], 0.0099, false),
                ([0.2, 0.2, -0.01], [0.5; 3], 0.0101, true),
                ([0.2; 3], [0.5, 0.5, 1.5], 0.1, false),
                ([2.0; 3], [3.0; 3], 0.1, false),
            ] {
                for cells in [1, 3] {
                    let held = of(block(low, high, cells));
                    assert_eq!(is_holding([&held, &holder], within), is_held, "{low:?} {high:?} {within}");
                }
            }
            let small = of(block([0.2; 3], [0.5; 3], 1));
            assert!(!is_holding([&holder, &small], 1e-9));
            // In the hollow it is not held, and what has the hollow within holds not.
            let hollow = of(hollow_box(4.0, 2.0, 1));
            assert!(!is_holding([&of(block([-0.5; 3], [0.5; 3], 1)), &hollow], 0.1));
            assert!(is_holding([&of(block([1.2; 3], [1.8; 3], 1)), &hollow], 1e-9));
            assert!(!is_holding([&of(block([-1.5; 3], [1.5; 3], 1)), &hollow], 0.4));
            assert!(is_holding([&hollow, &of(block([-2.0; 3], [2.0; 3], 2))], 1e-9));
        }
    }
}
