//! Crossings that are clearly deeper than a limit, found without trees: on both sides of a triangle of a closed part
//! there are points of the other part's surface whose nearest point on the closed part is on that triangle. One of them
//! is inside.

use feeler_core::clash::solids::Solids;
use feeler_core::geometry::vectors::{along, cross, dot, length, precise_normal, scaled, sub};
use feeler_core::{Point, Triangle};

use crate::point_depth::body::closest_on;

/// Most triangles of a part that are looked at one by one.
const MOST_TRIANGLES: usize = 1 << 14;

/// How often points nearer to the triangle are tried.
const TRIES: usize = 5;

/// Whether a triangle of a surface has points on both sides of one of the faces of a part, each farther from the part
/// than `least` (metres; `rounding`: the largest error of coordinates), with that face as the nearest of all.
pub fn is_through(solids: &Solids<'_>, surface: &Triangle, part: u32, face: u32, [least, rounding]: [f64; 2]) -> bool {
    let (mesh, faces) = (solids.mockup().mesh(), solids.faces(part));
    if faces.len() > MOST_TRIANGLES {
        return false;
    }
    let through = mesh.triangle(face);
    let Some((at, direction)) = middle_of_crossing(surface, &through) else { return false };
    let Some(n) = precise_normal(&through) else { return false };
    let lean = dot(&n, &direction).abs();
    // So far the surface and the face go on around the point.
    let room = room_within(surface, &at).min(room_within(&through, &at));
    (0..TRIES).any(|i| {
        let step = room * 0.5f64.powi(2 * i as i32 + 1);
        let height = step * lean;
        // Above the rounding of both.
        height > least + rounding
            && [step, -step].into_iter().all(|step| {
                let p = along(&at, step, &direction);
                let square = (height + rounding) * (height + rounding);
                faces.iter().all(|other| *other == face || !is_nearer(&p, &mesh.triangle(*other), square))
            })
    })
}

/// Whether a triangle is within a distance of a point, by its square.
fn is_nearer(p: &Point, t: &Triangle, square: f64) -> bool {
    let mut apart = 0.0;
    for a in 0..3 {
        let (low, high) = (t[0][a].min(t[1][a]).min(t[2][a]), t[0][a].max(t[1][a]).max(t[2][a]));
        let d = (low - p[a]).max(p[a] - high).max(0.0);
        apart += d * d;
    }
    apart <= square && closest_on(p, t).0 <= square
}

/// The middle of the segment that two triangles share, and the direction in the first one across it.
fn middle_of_crossing(t: &Triangle, u: &Triangle) -> Option<(Point, Point)> {
    let (m, n) = (precise_normal(t)?, precise_normal(u)?);
    let line = cross(&m, &n);
    let size = length(&line);
    // Of triangles at a grazing angle nothing is for all to see.
    if size < 1e-3 {
        return None;
    }
    let line = scaled(&line, 1.0 / size);
    let ends = |t: &Triangle, n: &Point, through: &Point| {
        let heights = [0, 1, 2].map(|i| dot(n, &sub(&t[i], through)));
        let mut ends = Vec::with_capacity(2);
        for i in 0..3 {
            let j = (i + 1) % 3;
            if heights[i] * heights[j] < 0.0 {
                ends.push(along(&t[i], heights[i] / (heights[i] - heights[j]), &sub(&t[j], &t[i])));
            }
        }
        (ends.len() == 2).then(|| [ends[0], ends[1]])
    };
    let (p, q) = (ends(t, &n, &u[0])?, ends(u, &m, &t[0])?);
    let places = |ends: &[Point; 2]| {
        let [s, t] = [0, 1].map(|i| dot(&line, &sub(&ends[i], &p[0])));
        (s.min(t), s.max(t))
    };
    let (s, t) = (places(&p), places(&q));
    let (low, high) = (s.0.max(t.0), s.1.min(t.1));
    (low < high).then(|| (along(&p[0], 0.5 * (low + high), &line), cross(&m, &line)))
}

/// How far a triangle goes on around a point in it.
fn room_within(t: &Triangle, p: &Point) -> f64 {
    (0..3)
        .map(|i| {
            let side = sub(&t[(i + 1) % 3], &t[i]);
            length(&cross(&side, &sub(p, &t[i]))) / length(&side)
        })
        .fold(f64::INFINITY, f64::min)
}
