//! Whether and where a ray hits a closed triangle, exactly.
//!
//! By the signed volumes of the ray's direction and two corners each, seen from its origin (K. Segura and C. Feito,
//! *Algorithms to test ray-triangle intersection*, 2001): the line hits the triangle if no two differ in sign. Signs
//! come from float64 with an error bound, else from whole numbers.

use std::cmp::Ordering;

use num_bigint::{BigInt, Sign as BigSign};

use super::ratio::Ratio;
use super::ray::Ray;
use super::span::{Place, Span};
use crate::constants::{ORIENT3D_BOUND, SAFE_PERMANENT, TIME_SURE};
use crate::geometry::bounds::{Point, Triangle};
use crate::geometry::predicates::{big_sign, certain_sign, orient2d, orient3d, whole_numbers, Sign};
use crate::geometry::vectors::sub;

/// A ray's first point on a triangle, of those that a span keeps.
#[derive(Debug, Clone)]
pub struct Meeting {
    /// Where along the ray.
    pub place: Place,
    /// Whether the triangle's normal by its winding points along the ray (1), against it (-1), or across (0: the ray is in its plane).
    pub facing: Sign,
}

/// The first point of the triangle on the ray, within the span.
pub fn meet(ray: &Ray, triangle: &Triangle, span: &Span) -> Option<Meeting> {
    let corners = triangle.map(|p| sub(&p, &ray.origin));
    let volumes: [(f64, f64); 3] = std::array::from_fn(|i| volume(&ray.direction, &corners[i], &corners[(i + 1) % 3]));
    let sure = volumes.map(|(volume, size)| certain_sign(volume, ORIENT3D_BOUND * size, size));
    if sure.contains(&Some(1)) && sure.contains(&Some(-1)) {
        return None;
    }
    let signs: [Sign; 3] =
        std::array::from_fn(|i| sure[i].unwrap_or_else(|| side(ray, &triangle[i], &triangle[(i + 1) % 3])));
    let facing = match (signs.contains(&1), signs.contains(&-1)) {
        (true, true) => return None,
        (true, false) => 1,
        (false, true) => -1,
        // The direction is across all three normals of planes through the origin: all of it is in one plane.
        (false, false) => return meet_in_plane(ray, triangle, span),
    };
    let [a, b, c] = triangle;
    let mut place = match orient3d(a, b, c, &ray.origin) * facing {
        -1 => return None,
        0 => Place::exact(Ratio::zero()),
        _ => place(&corners, &volumes).unwrap_or_else(|| Place::exact(ratio(ray, triangle))),
    };
    span.has(&mut place, || ratio(ray, triangle)).then_some(Meeting { place, facing })
}

/// The place where a line intersects the plane of a triangle that it does not lie in.
pub fn ratio(ray: &Ray, triangle: &Triangle) -> Ratio {
    let [d, corners] = whole(ray, triangle);
    let [a, b, c] = [0, 3, 6].map(|i| &corners[i..i + 3]);
    let determinant = |u: &[BigInt], v: &[BigInt], w: &[BigInt]| {
        &u[0] * (&v[1] * &w[2] - &v[2] * &w[1])
            + &u[1] * (&v[2] * &w[0] - &v[0] * &w[2])
            + &u[2] * (&v[0] * &w[1] - &v[1] * &w[0])
    };
    Ratio::new(determinant(a, b, c), determinant(&d, a, b) + determinant(&d, b, c) + determinant(&d, c, a))
}

/// The same in float64; `None` where that is not right within [`TIME_SURE`].
fn place(corners: &Triangle, volumes: &[(f64, f64); 3]) -> Option<Place> {
    let (height, height_size) = volume(&corners[0], &corners[1], &corners[2]);
    let [rate, rate_size] = volumes.iter().fold([0.0, 0.0], |sum, (x, size)| [sum[0] + x, sum[1] + size]);
    // The sum of three rounds twice more.
    let error = 2.0 * ORIENT3D_BOUND * (height_size / height.abs() + rate_size / rate.abs());
    let is_sure = error <= TIME_SURE && height_size > SAFE_PERMANENT && rate_size > SAFE_PERMANENT;
    let t = height / rate;
    (is_sure && t.is_finite()).then_some(Place { t, ratio: None })
}

/// `u . (v x w)`, and the same sum with absolute values.
#[inline(always)]
fn volume(u: &Point, v: &Point, w: &Point) -> (f64, f64) {
    let (mut volume, mut size) = (0.0, 0.0);
    for a in 0..3 {
        let (b, c) = ((a + 1) % 3, (a + 2) % 3);
        let (left, right) = (v[b] * w[c], v[c] * w[b]);
        volume += u[a] * (left - right);
        size += u[a].abs() * (left.abs() + right.abs());
    }
    (volume, size)
}

/// The sign of a volume, exactly: of the ray's direction and two points seen from its origin.
#[cold]
fn side(ray: &Ray, p: &Point, q: &Point) -> Sign {
    let (d, o) = (&ray.direction, &ray.origin);
    for a in 0..3 {
        let (b, c) = ((a + 1) % 3, (a + 2) % 3);
        if d[b] == 0.0 && d[c] == 0.0 {
            let turn = orient2d([p[b], p[c]], [q[b], q[c]], [o[b], o[c]]);
            return if d[a] < 0.0 { -turn } else { turn };
        }
    }
    let w = whole_numbers([d[0], d[1], d[2], o[0], o[1], o[2], p[0], p[1], p[2], q[0], q[1], q[2]]);
    let [p, q]: [[BigInt; 3]; 2] = [6, 9].map(|at| std::array::from_fn(|a| &w[at + a] - &w[3 + a]));
    let minor = |b: usize, c: usize| &p[b] * &q[c] - &p[c] * &q[b];
    big_sign(&(&w[0] * minor(1, 2) + &w[1] * minor(2, 0) + &w[2] * minor(0, 1)))
}

/// A ray's direction, and a triangle's corners from its origin one after the other, as whole numbers of one unit.
fn whole(ray: &Ray, triangle: &Triangle) -> [Vec<BigInt>; 2] {
    let (d, o, [a, b, c]) = (&ray.direction, &ray.origin, triangle);
    let w = whole_numbers([d[0], d[1], d[2], o[0], o[1], o[2], a[0], a[1], a[2], b[0], b[1], b[2], c[0], c[1], c[2]]);
    let corners = (0..9).map(|i| &w[6 + i] - &w[3 + i % 3]).collect();
    [w[..3].to_vec(), corners]
}

/// [`meet`] of a ray in the triangle's plane: the line and the triangle share a point or a segment.
#[cold]
fn meet_in_plane(ray: &Ray, triangle: &Triangle, span: &Span) -> Option<Meeting> {
    let [d, corners] = whole(ray, triangle);
    let at = |corner: usize, a: usize| &corners[3 * corner + a];
    // Along an axis that is not in the plane nothing is lost.
    let has_area = |a: usize| {
        let (b, c) = ((a + 1) % 3, (a + 2) % 3);
        let edge = |corner: usize, axis: usize| at(corner, axis) - at(0, axis);
        (edge(1, b) * edge(2, c)).cmp(&(edge(1, c) * edge(2, b))) != Ordering::Equal
    };
    let a = (0..3).find(|a| has_area(*a))?;
    let (b, c) = ((a + 1) % 3, (a + 2) % 3);
    // Where corners are from the line, to its left or right, and along it.
    let along = if d[b].sign() == BigSign::NoSign { c } else { b };
    let beside: [BigInt; 3] = std::array::from_fn(|corner| &d[b] * at(corner, c) - &d[c] * at(corner, b));
    let mut common: Vec<Ratio> = Vec::new();
    for i in 0..3 {
        let j = (i + 1) % 3;
        if beside[i].sign() == BigSign::NoSign {
            common.push(Ratio::new(at(i, along).clone(), d[along].clone()));
        } else if beside[i].sign() == -beside[j].sign() {
            let across = &beside[i] - &beside[j];
            let reached = at(i, along) * &across + (at(j, along) - at(i, along)) * &beside[i];
            common.push(Ratio::new(reached, &d[along] * across));
        }
    }
    let first = common.iter().min_by(|p, q| p.compare(q))?;
    let last = common.iter().max_by(|p, q| p.compare(q))?;
    let from = span.from.ratio.clone().unwrap_or_else(Ratio::zero);
    let start = if first.compare(&from) == Ordering::Less { &from } else { first };
    let is_past = |end: &Ratio| start.compare(end) == Ordering::Greater;
    if is_past(last) || span.to.as_ref().and_then(|to| to.ratio.as_ref()).is_some_and(is_past) {
        return None;
    }
    Some(Meeting { place: Place::exact(start.clone()), facing: 0 })
}
