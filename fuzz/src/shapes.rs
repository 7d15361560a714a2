//! Small meshes and poses with degenerate structure, made from bytes.

use std::sync::Arc;

use arbitrary::{Result, Unstructured};
use feeler_core::{Mockup, Point, Pose, Tool};

/// Vertices and faces.
pub type Arrays = (Vec<Point>, Vec<[u32; 3]>);

/// Metres between points of the lattice that most coordinates lie on, and how far from the origin it is.
pub fn unit_and_offset(u: &mut Unstructured<'_>) -> Result<(f64, f64)> {
    let unit = *u.choose(&[1.0, 0.1, 1e-3, 1e-6, 1e6, 1e-160, 1e95])?;
    let offset = *u.choose(&[0.0, 0.0, 0.0, 1.0, 3e3, 1e6])?;
    Ok((unit, offset))
}

/// A mock-up whose faces are of the parts that `part` tells by their numbers, a tool and two poses; `None` where one is refused.
pub fn made(
    mockup: Arrays,
    part: impl Fn(usize) -> usize,
    parts: usize,
    tool: Arrays,
    poses: &[[[f64; 4]; 4]; 2],
) -> Option<(Arc<Mockup>, Tool, [Pose; 2])> {
    let part_of_face = (0..mockup.1.len()).map(|i| part(i) as u32).collect();
    let mockup = Mockup::new(mockup.0, mockup.1, part_of_face, parts).ok()?;
    let poses = [Pose::new(&poses[0]).ok()?, Pose::new(&poses[1]).ok()?];
    Some((Arc::new(mockup), Tool::new(tool.0, tool.1).ok()?, poses))
}

/// At most so many faces.
pub fn mesh(u: &mut Unstructured<'_>, most: usize, unit: f64, offset: f64) -> Result<Arrays> {
    let vertices: usize = u.int_in_range(3..=24)?;
    let points: Vec<Point> = (0..vertices).map(|_| point(u, unit, offset)).collect::<Result<_>>()?;
    let faces = u.int_in_range(1..=most)?;
    // One index past the end now and then.
    let last = vertices as u32;
    let faces = (0..faces)
        .map(|_| Ok([u.int_in_range(0..=last)?, u.int_in_range(0..=last)?, u.int_in_range(0..=last)?]))
        .collect::<Result<_>>()?;
    Ok((points, faces))
}

/// A matrix that turns about one axis, and moves.
pub fn matrix(u: &mut Unstructured<'_>, unit: f64) -> Result<[[f64; 4]; 4]> {
    // Exact quarter turns, a 3-4-5 turn, and an inexact one.
    let turns = [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.6, 0.8), (0.955336489125606, 0.29552020666133955)];
    let (c, s) = *u.choose(&turns)?;
    let t: Point = point(u, unit, 0.0)?;
    let [x, y, z] = if t.iter().all(|x| x.is_finite()) { t } else { [0.0; 3] };
    Ok(match u.int_in_range(0..=2)? {
        0 => [[c, -s, 0.0, x], [s, c, 0.0, y], [0.0, 0.0, 1.0, z], [0.0, 0.0, 0.0, 1.0]],
        1 => [[1.0, 0.0, 0.0, x], [0.0, c, -s, y], [0.0, s, c, z], [0.0, 0.0, 0.0, 1.0]],
        _ => [[c, 0.0, s, x], [0.0, 1.0, 0.0, y], [-s, 0.0, c, z], [0.0, 0.0, 0.0, 1.0]],
    })
}

fn point(u: &mut Unstructured<'_>, unit: f64, offset: f64) -> Result<Point> {
    let mut p = [0.0; 3];
    for x in &mut p {
        *x = match u.int_in_range(0..=15u8)? {
            // A lattice makes flush faces; its neighbours nearly so.
            0..=11 => f64::from(u.int_in_range(-4..=4i8)?) * unit + offset,
            12 | 13 => f64::from_bits((f64::from(u.int_in_range(-4..=4i8)?) * unit + offset).to_bits().wrapping_add(1)),
            14 => f64::from(u.arbitrary::<f32>()?) * unit,
            _ => u.arbitrary::<f64>()?,
        };
    }
    Ok(p)
}

/// Up to three closed solids: boxes, each side cut into a few cells, and pyramids; now and then with a triangle less, or the other
/// way round.
pub fn solids(u: &mut Unstructured<'_>, unit: f64, offset: f64) -> Result<Arrays> {
    let mut all: Arrays = (Vec::new(), Vec::new());
    for _ in 0..u.int_in_range(1..=3)? {
        let (lower, size) = (lattice(u, -4, 3)?, lattice(u, 1, 4)?);
        let place = |p: Point| -> Point { std::array::from_fn(|a| (lower[a] + size[a] * p[a]) * unit + offset) };
        let first = all.0.len() as u32;
        if u.ratio(1, 4)? {
            let apex = [0.25 * f64::from(u.int_in_range(-2..=6i8)?), 0.5, 1.0];
            let base = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
            all.0.extend(base.into_iter().chain([apex]).map(place));
            let faces = [[0, 2, 1], [0, 3, 2], [0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]];
            all.1.extend(faces.map(|f| f.map(|v| v + first)));
        } else {
            let cells = u.int_in_range(1..=2u32)?;
            for side in 0..6 {
                let (axis, is_upper) = (side / 2, side % 2 == 1);
                let from = all.0.len() as u32;
                for (i, j) in (0..=cells).flat_map(|i| (0..=cells).map(move |j| (i, j))) {
                    let mut p = [0.0; 3];
                    p[axis] = f64::from(u8::from(is_upper));
                    p[(axis + 1) % 3] = f64::from(i) / f64::from(cells);
                    p[(axis + 2) % 3] = f64::from(j) / f64::from(cells);
                    all.0.push(place(p));
                }
                for (i, j) in (0..cells).flat_map(|i| (0..cells).map(move |j| (i, j))) {
                    let [a, b] = [0, 1].map(|k| from + (i + k) * (cells + 1) + j);
                    for [p, q, r] in [[a, b, b + 1], [a, b + 1, a + 1]] {
                        all.1.push(if is_upper { [p, q, r] } else { [p, r, q] });
                    }
                }
            }
        }
    }
    if u.ratio(1, 4)? {
        let i = u.choose_index(all.1.len())?;
        if u.arbitrary()? {
            all.1.swap_remove(i);
        } else {
            all.1[i].swap(0, 1);
        }
    }
    Ok(all)
}

/// Whole numbers, now and then between them.
fn lattice(u: &mut Unstructured<'_>, from: i8, to: i8) -> Result<Point> {
    let mut p = [0.0; 3];
    for x in &mut p {
        *x = f64::from(u.int_in_range(from..=to)?) + if u.ratio(1, 4)? { 0.37 } else { 0.0 };
    }
    Ok(p)
}
