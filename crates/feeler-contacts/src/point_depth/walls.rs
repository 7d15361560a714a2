//! Thin walls that go through each other: no point of either is deeper than half its thickness, however far they cross.

use feeler_core::geometry::vectors::{add, along, cross, dot, length, precise_normal, scaled, sub, unit};
use feeler_core::{Aabb, Point, Triangle};

use super::body::{distance_to, Body};
use super::depth::{point_depth_from, PointDepth};
use super::shared_line::{shared, SharedLine, Span};
use crate::constants::{
    FLUSH_ROUNDINGS, NEEDLE_RAYS, NEEDLE_REACH, NEEDLE_STEP, OPPOSITE_FACES, SAME_FACE_NORMAL, SIDE_EXCESS, SIDE_STEP,
    WALL_MIDDLE,
};

/// Whether two bodies clash as thin walls, although no point of either is deeper than `contact` (metres) in the other: they cross, or
/// share more than `contact` of their thickness side by side.
pub fn are_walls_clashing([a, b]: [&Body; 2], contact: f64) -> bool {
    let deepest = [point_depth_from([a, b]), point_depth_from([b, a])];
    are_crossing([a, b], contact, &deepest)
        || is_side_by_side(a, b, contact, &deepest[0])
        || is_side_by_side(b, a, contact, &deepest[1])
}

/// Whether two bodies cross as thin walls: where their surfaces cross, both have a second face behind the first, and points of each lie
/// in the middle between these faces of the other. One of them may be a needle, whose faces need not be parallel. Thin walls are
/// thinner than twice `contact` (metres).
fn are_crossing([a, b]: [&Body; 2], contact: f64, deepest: &[PointDepth; 2]) -> bool {
    let least = FLUSH_ROUNDINGS * a.rounding().max(b.rounding());
    // How thick a wall may be for the points found to be in its middle.
    let thickness = [1, 0].map(|i: usize| 2.0 * (deepest[i].depth / WALL_MIDDLE).min(contact + least));
    if thickness.iter().any(|thickness| *thickness <= 4.0 * least) {
        return false;
    }
    let (few, many, thickness) =
        if a.len() <= b.len() { (a, b, thickness) } else { (b, a, [thickness[1], thickness[0]]) };
    let shift = sub(few.origin(), many.origin());
    (0..few.len() as u32).any(|i| {
        let t = few.triangle(i).map(|p| add(&p, &shift));
        let is_crossing_walls = |j: u32| {
            let normals = [few.outward(i)?, many.outward(j)?];
            let line = SharedLine::new([&t, many.triangle(j)], normals, least)?;
            let of_few = line.moved(&scaled(&shift, -1.0));
            let own = of_few.before_walls(few, i, thickness[0], least);
            let other = line.before_walls(many, j, thickness[1], least);
            if own.is_empty() && other.is_empty() {
                return None;
            }
            let crossing = line.where_through([few, many], &shift, least);
            let (own, other) = (shared(&own, &crossing), shared(&other, &crossing));
            let is_needle_at = |line: &SharedLine, body: &Body, i: u32, thickness: f64, spans: &[Span]| {
                // A power of two, which small errors of depths hardly change.
                let step = (NEEDLE_STEP * thickness).log2().floor().exp2();
                line.points(spans, step, body.origin()).any(|at| is_needle(body, i, &at, thickness))
            };
            let is_crossing = !shared(&own, &other).is_empty()
                || is_needle_at(&line, many, j, thickness[1], &own)
                || is_needle_at(&of_few, few, i, thickness[0], &other);
            is_crossing.then_some(())
        };
        many.find_overlapping(&Aabb::of_triangle(&t), is_crossing_walls).is_some()
    })
}

/// Whether two walls share more than `contact` (metres) of their thickness, by the deepest point of the one: across the nearest faces of the
/// other, the wall, both are walls there. The surfaces of walls side by side need not cross, nor reach the other's middle.
fn is_side_by_side(own: &Body, wall: &Body, contact: f64, found: &PointDepth) -> bool {
    let Some([deepest, _]) = found.points else { return false };
    let least = own.rounding().max(wall.rounding());
    if found.depth <= FLUSH_ROUNDINGS * least {
        return false;
    }
    let thickest = 2.0 * (contact + least);
    let shares_thickness = |across: &Point| {
        let Some(inward) = inward_along(own, &sub(&deepest, own.origin()), across) else { return false };
        // As far into the one body as the deepest point is surely inside the other.
        let p = along(&deepest, SIDE_STEP * found.depth, &inward);
        let far = |sign: f64| {
            let end = along(&p, sign * thickest, across);
            [own, wall].map(|body| nearest_face([&sub(&p, body.origin()), &sub(&end, body.origin())], body))
        };
        let ways = [far(1.0), far(-1.0)];
        // Across an edge the way is short, too, but its ends do not look opposite ways.
        let are_walls = [0, 1].iter().all(|body: &usize| {
            let [(one, p), (other, q)] = ways.map(|way| way[*body]);
            one + other <= thickest && dot(&p, &q) <= OPPOSITE_FACES
        });
        let shared = ways.iter().map(|[of_own, of_wall]| of_own.0.min(of_wall.0)).sum::<f64>();
        let is_inside = |body: &Body| body.is_inside(&sub(&p, body.origin())) == Some(true);
        are_walls && shared > contact * SIDE_EXCESS && is_inside(own) && is_inside(wall)
    };
    // The rim of the wall may be as near as its faces.
    normals_near(wall, &sub(&deepest, wall.origin()), found.depth / WALL_MIDDLE).iter().any(shares_thickness)
}

/// The outward normals of the faces of a body within a distance of a point, each once.
fn normals_near(body: &Body, p: &Point, within: f64) -> Vec<Point> {
    let around = Aabb { lower: p.map(|x| x - within), upper: p.map(|x| x + within) };
    let mut found: Vec<Point> = Vec::new();
    body.find_overlapping(&around, |i| {
        let outward = body.outward(i).filter(|n| !found.iter().any(|m| dot(m, n) > SAME_FACE_NORMAL));
        found.extend(outward.filter(|_| distance_to(p, body.triangle(i)) <= within));
        None::<()>
    });
    found
}

/// The direction into a body from a point of its surface: level with a normal, but where the surface there runs across the normal itself.
fn inward_along(body: &Body, at: &Point, normal: &Point) -> Option<Point> {
    let within = 4.0 * body.rounding() + 1e-9 * body.bounds().longest();
    let faces = normals_near(body, at, within);
    let sum = faces.iter().fold([0.0; 3], |sum, n| sub(&sum, n));
    let level = along(&sum, -dot(&sum, normal), normal);
    unit(if length(&level) > 0.1 * length(&sum) { &level } else { &sum })
}

/// How far along a segment the first face of a body is that it goes through, and its outward normal; infinite if there is none.
fn nearest_face([p, q]: [&Point; 2], body: &Body) -> (f64, Point) {
    let mut nearest = (f64::INFINITY, [0.0; 3]);
    body.tree().find_on_segment([p, q], body.rounding(), |i| {
        if let Some(hit) = piercing([p, q], body.triangle(i), -body.rounding()) {
            let far = length(&sub(&hit, p));
            if far < nearest.0 {
                nearest = (far, body.outward(i).unwrap_or_default());
            }
        }
        None::<()>
    });
    nearest
}

/// Whether the body is a needle behind a point of a triangle: the triangle's face and two others enclose a section in which no point is
/// deeper than half this thickness. Tips and edges are not needles, since they become thicker farther in.
///
/// If weights that sum to 1 cancel the three normals, the weighted sum of a point's depths behind the faces is the same for all points. So
/// it is the depth of the point that is equally deep behind all three, which is the deepest.
fn is_needle(body: &Body, i: u32, at: &Point, thickness: f64) -> bool {
    let Some(outward) = body.outward(i) else { return false };
    let reach = NEEDLE_REACH * thickness;
    let Some((first, behind)) = face_along(body, at, &scaled(&outward, -reach)) else { return false };
    // A wall that is too thick; its faces span no plane.
    if dot(&outward, &first) <= OPPOSITE_FACES {
        return false;
    }
    let Some(axis) = unit(&cross(&outward, &first)) else { return false };
    let (aside, middle) = (cross(&axis, &outward), scaled(&add(at, &behind), 0.5));
    // Each face around as its normal, and how deep the point of the triangle is behind it.
    let around: Vec<(Point, f64)> = (0..NEEDLE_RAYS)
        .filter_map(|n| {
            let (sine, cosine) = (std::f64::consts::TAU * f64::from(n) / f64::from(NEEDLE_RAYS)).sin_cos();
            let (normal, hit) =
                face_along(body, &middle, &add(&scaled(&outward, reach * cosine), &scaled(&aside, reach * sine)))?;
            Some((normal, dot(&normal, &sub(&hit, at))))
        })
        .collect();
    around.iter().enumerate().any(|(n, (p, p_depth))| {
        around[..n].iter().any(|(q, q_depth)| {
            let weights = [[p, q], [q, &outward], [&outward, p]].map(|[m, n]| dot(&axis, &cross(m, n)));
            let sum: f64 = weights.iter().sum();
            if sum == 0.0 || weights.iter().any(|weight| weight / sum <= 0.0) {
                return false;
            }
            let [_, by_p, by_q] = weights.map(|weight| weight / sum);
            let left = by_p * dot(&axis, p) + by_q * dot(&axis, q);
            left * left <= 0.5 * (1.0 + OPPOSITE_FACES) && by_p * p_depth + by_q * q_depth <= 0.5 * thickness
        })
    })
}

/// The outward normal of the first face that a ray from inside meets, and where, no farther than the ray is long.
fn face_along(body: &Body, from: &Point, ray: &Point) -> Option<(Point, Point)> {
    let (end, mut first) = (add(from, ray), None);
    let mut nearest = f64::INFINITY;
    body.tree().find_on_segment([from, &end], body.rounding(), |j| {
        if let (Some(n), Some(hit)) = (body.outward(j), piercing([from, &end], body.triangle(j), 0.0)) {
            let far = dot(&sub(&hit, from), ray);
            if dot(&n, ray) > 0.0 && far < nearest {
                (nearest, first) = (far, Some((n, hit)));
            }
        }
        None::<()>
    });
    first
}

/// Where a segment goes through a triangle, no nearer to its border than `inset` (metres).
fn piercing([p, q]: [&Point; 2], t: &Triangle, inset: f64) -> Option<Point> {
    let n = precise_normal(t)?;
    let (h, k) = (dot(&n, &sub(p, &t[0])), dot(&n, &sub(q, &t[0])));
    if h * k >= 0.0 {
        return None;
    }
    let s = h / (h - k);
    let at: Point = std::array::from_fn(|a| p[a] + s * (q[a] - p[a]));
    is_within(&at, t, &n, inset).then_some(at)
}

/// Whether a point of the plane of a triangle is in it, no nearer to its border than `inset` (metres).
fn is_within(at: &Point, t: &Triangle, n: &Point, inset: f64) -> bool {
    (0..3).all(|i| {
        let side = sub(&t[(i + 1) % 3], &t[i]);
        dot(&cross(n, &side), &sub(at, &t[i])) >= inset * length(&side)
    })
}

#[cfg(test)]
mod tests {
    use super::super::brute::{block, body, placed};
    use super::*;
    use feeler_shapes::{joined, ridge, turned, Arrays};

    /// Whether they cross, at a turn, either way round, and cut finely or not.
    fn are_crossing(p: impl Fn(usize) -> Arrays, q: impl Fn(usize) -> Arrays) -> bool {
        let m = turned(0.7, [3.0, -2.0, 0.5]);
        let mut said = Vec::new();
        for (cells, other) in [(1, 1), (3, 1), (2, 5)] {
            let [a, b] = [p(cells), q(other)].map(|mesh| body(placed(mesh, &m)));
            said.extend([are_walls_clashing([&a, &b], 1.0), are_walls_clashing([&b, &a], 1.0)]);
        }
        assert!(said.iter().all(|is_crossing| *is_crossing == said[0]), "{said:?}");
        said[0]
    }

    #[test]
    fn plates_that_go_through_each_other_cross() {
        let plate = |cells| block([-1.0, -1.0, -0.05], [1.0, 1.0, 0.05], cells);
        assert!(are_crossing(plate, |cells| block([-0.04, -0.6, -0.7], [0.06, 0.5, 0.8], cells)));
        // A rod through it, as thick as it and thinner; and one that ends in its middle.
        assert!(are_crossing(plate, |cells| block([0.1, 0.1, -1.0], [0.2, 0.2, 1.0], cells)));
        assert!(are_crossing(plate, |cells| block([0.1, 0.1, -1.0], [0.15, 0.16, 1.0], cells)));
    }

    #[test]
    fn walls_cross_also_where_edges_of_triangles_lie_in_both() {
        // Cut into cells, each has edges in the faces of the other.
        let plate = |cells| block([-1.0, -1.0, -0.125], [1.0, 1.0, 0.125], cells);
        let across = |cells| block([-0.125, -1.0, -1.0], [0.125, 1.0, 1.0], cells);
        let foot = |cells| block([-0.125, -1.0, 0.125], [0.125, 1.0, 1.0], cells);
        for (cells, other) in [(1, 1), (1, 16), (16, 1), (8, 16), (16, 16)] {
            let [a, b, c] = [plate(cells), across(other), foot(other)].map(body);
            assert!(are_walls_clashing([&a, &b], 1.0) && are_walls_clashing([&b, &a], 1.0), "{cells} {other}");
            assert!(!are_walls_clashing([&a, &c], 1.0) && !are_walls_clashing([&c, &a], 1.0), "{cells} {other}");
        }
    }

    #[test]
    fn plates_that_end_flush_and_share_their_middle_cross() {
        // The diagonals of their faces cross in both, and their ends lie on each other.
        let plate = |cells| block([-1.0, -1.0, -0.05], [1.0, 1.0, 0.05], cells);
        assert!(are_crossing(plate, |cells| block([-1.0, -0.05, -1.0], [1.0, 0.05, 1.0], cells)));
        let one = body(plate(1));
        for turn in [0.0f64, 0.3, 0.5] {
            let m = [[1.0, 0.0, 0.0], [0.0, turn.cos(), -turn.sin()], [0.0, turn.sin(), turn.cos()]];
            let (vertices, faces) = block([-1.0, -0.05, -1.0], [1.0, 0.05, 1.0], 1);
            let across = vertices.iter().map(|p| m.map(|row| dot(&row, p))).collect();
            assert!(are_walls_clashing([&one, &body((across, faces))], 1.0), "{turn}");
        }
        // One stands on the other.
        assert!(!are_crossing(plate, |cells| block([-1.0, -0.05, 0.05], [1.0, 0.05, 1.0], cells)));
    }

    #[test]
    fn what_is_pressed_into_a_face_crosses_no_wall() {
        let plate = |cells| block([-1.0, -1.0, -0.05], [1.0, 1.0, 0.05], cells);
        // Less than to the middle, by a plate on edge, and by a block.
        assert!(!are_crossing(plate, |cells| block([-0.05, -0.5, 0.02], [0.05, 0.5, 1.0], cells)));
        assert!(!are_crossing(plate, |cells| block([-0.5, -0.5, 0.03], [0.5, 0.5, 1.0], cells)));
        // Side by side, and apart.
        assert!(!are_crossing(plate, |cells| block([0.97, -0.5, -0.05], [3.0, 0.5, 0.05], cells)));
        assert!(!are_crossing(plate, |cells| block([0.0, 0.0, 0.1], [1.0, 1.0, 0.2], cells)));
        // Two thick blocks by a corner.
        assert!(!are_crossing(|cells| block([0.0; 3], [2.0; 3], cells), |cells| block([1.5; 3], [4.0; 3], cells)));
    }

    #[test]
    fn both_have_to_be_walls() {
        // A plate deep in a block, and across a ridge, whose faces lean towards each other.
        let plate = |cells| block([-0.05, -0.5, 0.5], [0.05, 0.5, 3.0], cells);
        assert!(!are_crossing(|cells| block([-1.0; 3], [1.0; 3], cells), plate));
        let roof = |cells| ridge(&[[-1.0, 0.0], [0.0, 1.732], [1.0, 0.0]], -1.0, 1.0, cells, cells);
        assert!(!are_crossing(roof, |cells| block([-2.0, -2.0, 1.0], [2.0, 2.0, 1.05], cells)));
    }

    #[test]
    fn a_block_is_no_wall_across_its_edge() {
        // A bar along the edge, turned by 30 degrees; it is a wall of 0.1, and the block is none.
        let (sine, cosine) = 30f64.to_radians().sin_cos();
        let bar = |x: f64, y: f64| {
            let (vertices, faces) = block([0.0, 0.0, -2.0], [0.1, 0.1, 2.0], 1);
            let placed =
                vertices.iter().map(|p| [x + cosine * p[0] - sine * p[1], y + sine * p[0] + cosine * p[1], p[2]]);
            (placed.collect(), faces)
        };
        let whole = body(block([-4.0; 3], [0.0, 0.0, 4.0], 1));
        let over = body(bar(-0.04, -0.09));
        let depth = [[&whole, &over], [&over, &whole]].map(|pair| point_depth_from(pair).depth);
        let depth = depth[0].max(depth[1]);
        assert!(depth > 0.03 && depth < 0.1, "{depth}");
        for contact in [1.02, 1.1, 1.2, 1.5, 2.0].map(|share| share * depth) {
            assert!(!are_walls_clashing([&whole, &over], contact) && !are_walls_clashing([&over, &whole], contact));
        }
    }

    /// A cone of some faces, its tip at the origin, up along z; with the half angle of its faces, degrees.
    fn tip(faces: u32, half: f64) -> Arrays {
        let out = half.to_radians().tan() / (std::f64::consts::PI / f64::from(faces)).cos();
        let corner = |i: u32| {
            let (sine, cosine) = (std::f64::consts::TAU * f64::from(i) / f64::from(faces)).sin_cos();
            [out * cosine, out * sine, 1.0]
        };
        let vertices = [[0.0; 3], [0.0, 0.0, 1.0]].into_iter().chain((0..faces).map(corner)).collect();
        let sides = (0..faces).map(|i| [2 + i, 2 + (i + 1) % faces]);
        (vertices, sides.flat_map(|[p, q]| [[0, q, p], [1, p, q]]).collect())
    }

    /// A bar along y of a triangle (x, z) as its section.
    fn triangular(section: [[f64; 2]; 3]) -> Arrays {
        let vertices = [-0.5, 0.5].iter().flat_map(|y| section.map(|[x, z]| [x, *y, z])).collect();
        let sides = (0..3).map(|i| [i, (i + 1) % 3, i + 3, (i + 1) % 3 + 3]);
        let sides = sides.flat_map(|[p, q, r, s]| [[p, q, r], [q, s, r]]);
        (vertices, [[0, 2, 1], [3, 4, 5]].into_iter().chain(sides).collect())
    }

    #[test]
    fn blunt_tips_and_edges_through_a_foil_are_neither_walls_nor_needles() {
        // The tip is below the foil; in a block it is less than half as deep as that is thick.
        let slab = |below: f64| move |cells: usize| block([-1.0, -1.0, -below], [1.0, 1.0, 0.0], cells);
        let lowered = |(vertices, faces): Arrays, by: f64| -> Arrays {
            (vertices.into_iter().map(|p| [p[0], p[1], p[2] - by]).collect(), faces)
        };
        for (half, is_sharp) in [(4.0, true), (8.0, true), (15.0, false), (20.0, false), (35.0, false)] {
            for faces in [3, 4, 5, 6, 9, 16] {
                let is_crossing = are_crossing(slab(0.01), |_| lowered(tip(faces, half), 0.03));
                assert_eq!(is_crossing, is_sharp, "{faces} faces, {half} degrees");
                assert!(!are_crossing(slab(1.0), |_| lowered(tip(faces, half), 0.03)));
            }
            let out = f64::tan(half.to_radians());
            let edge = |_| lowered(triangular([[0.0, 0.0], [out, 1.0], [-out, 1.0]]), 0.03);
            assert_eq!(are_crossing(slab(0.01), edge), is_sharp, "an edge, {half} degrees");
            assert!(!are_crossing(slab(1.0), edge));
        }
    }

    #[test]
    fn needles_are_as_thin_as_their_middle_is_from_their_sides() {
        // The largest corner is acute, right and obtuse; none is below 26 degrees.
        for section in [[0.1, 0.3, 0.4], [0.0, 0.2, 0.3], [0.25, 0.14, 0.5]] {
            let [x, z, long] = section;
            let needle = |_| triangular([[0.0, 0.0], [long, 0.0], [x, z]]);
            let foil = |cells| block([-1.0, -0.02, -1.0], [1.0, 0.02, 1.0], cells);
            assert!(are_crossing(foil, needle), "{section:?}");
            let [a, b] = [foil(1), needle(1)].map(body);
            // As much as contact allows, and more.
            let half = point_depth_from([&a, &b]).depth;
            assert!(are_walls_clashing([&a, &b], 1.01 * half), "{section:?}");
            assert!(!are_walls_clashing([&a, &b], 0.97 * half), "{section:?}");
        }
    }

    #[test]
    fn walls_are_thinner_than_twice_the_contact() {
        let [a, b] = [block([-1.0, -1.0, -0.05], [1.0, 1.0, 0.05], 1), block([-0.04, -0.6, -0.7], [0.04, 0.5, 0.8], 1)]
            .map(body);
        assert!(are_walls_clashing([&a, &b], 0.0501) && !are_walls_clashing([&a, &b], 0.0499));
    }

    #[test]
    fn walls_side_by_side_clash_if_they_share_more_than_contact_of_their_thickness() {
        let sheet = |low: [f64; 2], high: [f64; 2], shift: f64, thick: f64| {
            move |cells| block([low[0], low[1], shift], [high[0], high[1], shift + thick], cells)
        };
        // `contact` is 1 in `are_crossing`. Edges in line, and not.
        for (low, high) in [([40.0, 0.0], [120.0, 100.0]), ([40.0, 20.0], [120.0, 150.0]), ([2.0, 0.0], [102.0, 100.0])]
        {
            for (shift, thick, is_clash) in [(0.0, 1.9, true), (0.0, 0.9, false), (0.5, 1.8, true), (0.9, 1.8, false)] {
                let is_crossing = are_crossing(sheet([0.0; 2], [100.0; 2], 0.0, thick), sheet(low, high, shift, thick));
                assert_eq!(is_crossing, is_clash, "{low:?} {high:?} {shift} {thick}");
            }
        }
        // All edges in line: no point of either surface is in the middle of the other.
        for (shift, thick, is_clash) in [(0.1, 1.9, true), (0.7, 1.8, true), (0.9, 1.8, false), (0.1, 0.9, false)] {
            let [low, high] = [0.0, shift].map(|shift| sheet([0.0; 2], [100.0; 2], shift, thick));
            assert_eq!(are_crossing(low, high), is_clash, "{shift} {thick}");
        }
        // The smaller one beside the edges of the larger one: no point of this one's surface is in the middle of the other.
        for (shift, thick, is_clash) in [(0.1, 1.9, true), (0.5, 1.8, true), (0.75, 1.8, true), (0.9, 1.8, false)] {
            let [large, small] = [sheet([0.0; 2], [100.0; 2], 0.0, thick), sheet([20.0; 2], [70.0; 2], shift, thick)];
            assert_eq!(are_crossing(large, small), is_clash, "{shift} {thick}");
        }
        // A thin wall and a thick one.
        let [thin, thick] = [sheet([0.0; 2], [100.0; 2], 0.0, 1.9), sheet([20.0; 2], [70.0; 2], 0.5, 2.1)];
        assert!(!are_crossing(thin, thick));
        // Less than a contact deep from the edge.
        let less = sheet([99.2, 0.0], [200.0, 100.0], 0.0, 1.9);
        assert!(!are_crossing(sheet([0.0; 2], [100.0; 2], 0.0, 1.9), less));
    }

    #[test]
    fn a_thick_end_on_a_thin_wall_is_measured_where_they_cross() {
        // A plate that goes through a thin one, and far away each has a thick block, of which no point is inside the other.
        let with_block = |plate: Arrays, at: [f64; 3]| joined([plate, block(at, at.map(|x| x + 0.5), 1)]);
        let p = |cells| with_block(block([-1.0, -1.0, -0.05], [1.0, 1.0, 0.05], cells), [2.0; 3]);
        let q = |cells| with_block(block([-0.05, -0.6, -0.7], [0.05, 0.5, 0.8], cells), [-4.0; 3]);
        assert!(are_crossing(p, q));
    }

    #[test]
    fn segments_go_through_triangles_as_far_as_the_inset_lets_them() {
        let t = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let at = |x: f64, y: f64, inset: f64| piercing([&[x, y, -1.0], &[x, y, 3.0]], &t, inset);
        assert_eq!(at(0.25, 0.25, 0.0), Some([0.25, 0.25, 0.0]));
        for (x, y) in [(-0.1, 0.5), (0.5, -0.1), (0.6, 0.6)] {
            assert!(at(x, y, 0.0).is_none());
        }
        assert!(at(0.1, 0.4, 0.09).is_some() && at(0.1, 0.4, 0.11).is_none());
        assert!(piercing([&[0.2, 0.2, 0.0], &[0.2, 0.2, 1.0]], &t, 0.0).is_none());
        assert!(piercing([&[0.2, 0.2, 2.0], &[0.2, 0.2, 1.0]], &t, 0.0).is_none());
        assert!(piercing([&[0.2, 0.2, 1.0], &[0.2, 0.2, -1.0]], &t, 0.0).is_some());
    }
}
