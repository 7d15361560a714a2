//! Small meshes and poses with degenerate structure, made from bytes.

use arbitrary::{Result, Unstructured};
use feeler_core::Point;

/// Vertices and faces.
pub type Arrays = (Vec<Point>, Vec<[u32; 3]>);

/// Metres between points of the lattice that most coordinates lie on, and how far from the origin it is.
pub fn unit_and_offset(u: &mut Unstructured<'_>) -> Result<(f64, f64)> {
    let unit = *u.choose(&[1.0, 0.1, 1e-3, 1e-6, 1e6, 1e-160, 1e95])?;
    let offset = *u.choose(&[0.0, 0.0, 0.0, 1.0, 3e3, 1e6])?;
    Ok((unit, offset))
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
