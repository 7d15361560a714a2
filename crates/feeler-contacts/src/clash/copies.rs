//! Whether two parts are copies of one surface, each rounded in a file.
//!
//! Rounding moves a corner of either part, so copies that are cut into other triangles are a little apart. Thin parts
//! that lie on each other are as near, but share no material.

use feeler_core::geometry::vectors::{add, along, sub};
use feeler_core::Point;

use crate::constants::{COPY_DEPTH, COPY_STEP};
use crate::point_depth::body::Body;
use crate::point_depth::depth::is_same_surface;

/// Whether each surface is nowhere farther than `within` (metres) from the other, and both are closed around a point
/// that is farther than that from them. Open surfaces have no such point, and need none.
pub fn are_copies([a, b]: [&Body; 2], within: f64) -> bool {
    let is_around = || match [a.is_closed(), b.is_closed()] {
        [true, _] => is_material_of_both([a, b], within),
        [false, true] => is_material_of_both([b, a], within),
        [false, false] => true,
    };
    is_same_surface([a, b], within) && is_around()
}

/// Whether a point below a triangle of a closed body is deep in it, and in the other body if that is closed.
fn is_material_of_both([body, other]: [&Body; 2], within: f64) -> bool {
    let is_in_other = |p: &Point| !other.is_closed() || is_in(other, &sub(&add(p, body.origin()), other.origin()));
    let is_deep = |p: &Point| body.closest(p, COPY_DEPTH * within).is_none() && is_in(body, p);
    let mut below = (0..body.len() as u32).filter_map(|i| below(body, i, COPY_STEP * within));
    below.any(|p| is_deep(&p) && is_in_other(&p))
}

/// The point at a depth below the middle of a triangle, relative to the body's origin; `None` of an open surface.
fn below(body: &Body, i: u32, depth: f64) -> Option<Point> {
    let [a, b, c] = body.triangle(i);
    let middle = std::array::from_fn(|k| (a[k] + b[k] + c[k]) / 3.0);
    Some(along(&middle, -depth, &body.outward(i)?))
}

fn is_in(body: &Body, p: &Point) -> bool {
    body.is_inside(p) == Some(true)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::point_depth::brute::{block, body, inside_out, placed};
    use feeler_shapes::random::Random;
    use feeler_shapes::{sheet, Arrays};

    const WITHIN: f64 = 1e-6;

    /// Each coordinate off by a quarter of the distance at most.
    fn rounded((vertices, faces): Arrays) -> Arrays {
        let unit = 0.5 * WITHIN;
        (vertices.into_iter().map(|p| p.map(|x| unit * (x / unit).round())).collect(), faces)
    }

    fn are_copies_both_ways(p: Arrays, q: Arrays) -> bool {
        let (a, b) = (body(p), body(q));
        let found = are_copies([&a, &b], WITHIN);
        assert_eq!(are_copies([&b, &a], WITHIN), found);
        found
    }

    #[test]
    fn rounded_copies_are_copies_however_they_are_cut_and_thin_bodies_on_each_other_are_not() {
        let mut r = Random::new(5);
        for _ in 0..20 {
            let m = r.motion(2.0);
            let at = |mesh: Arrays| rounded(placed(mesh, &m));
            let plate = |low: f64, thick: f64, cells| block([0.0, 0.0, low], [1.0, 0.7, low + thick], cells);
            for thick in [0.5, 1e-3, 5e-6] {
                assert!(are_copies_both_ways(at(plate(0.0, thick, 1)), at(plate(0.0, thick, 3))), "{thick}");
                assert!(are_copies_both_ways(at(plate(0.0, thick, 2)), at(inside_out(plate(0.0, thick, 1)))));
                assert!(!are_copies_both_ways(at(plate(0.0, thick, 1)), at(plate(2.5e-6, thick, 3))), "{thick}");
            }
            // Nearer than the distance all over, and one beside the other.
            let foil = |low: f64, cells| plate(low, 0.4 * WITHIN, cells);
            assert!(!are_copies([&body(foil(0.0, 1)), &body(foil(0.4 * WITHIN, 2))], WITHIN));
            let flat = |cells| sheet(cells, cells, |u, v| [u, v, 0.2 * WITHIN]);
            assert!(!are_copies([&body(foil(0.0, 1)), &body(flat(2))], WITHIN));
            assert!(are_copies_both_ways(at(flat(1)), at(flat(4))));
        }
    }

    #[test]
    fn a_closed_body_and_its_copy_with_a_small_hole_are_copies() {
        let (vertices, faces) = block([0.0; 3], [1.0; 3], 8);
        let (one, other) = (body((vertices.clone(), faces.clone())), body((vertices, faces[1..].to_vec())));
        assert!(one.is_closed() && !other.is_closed());
        for (within, is_copy) in [(0.15, true), (0.02, false)] {
            for pair in [[&one, &other], [&other, &one]] {
                assert_eq!(are_copies(pair, within), is_copy, "{within}");
            }
        }
    }
}
