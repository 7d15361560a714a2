//! The two surfaces of a zone as a few patches: triangles of one plane, or of one turn of a curved surface, however many they
//! are; and patches that bulge the same way together.

use crate::bounds::{Aabb, Point};
use crate::contacts::vector::{add, dot, norm, scaled, sub};
use crate::contacts::zones::{Zone, Zones};
use crate::contacts::Ground;

/// Triangles whose normals are within this angle of the first one's (cosine of 2.5 degrees) may share a patch: on a curved
/// surface of radius r that is off by r/1000.
const ONE_PATCH: f64 = 0.999_05;

/// Normals this close (1 - cosine) are of one plane.
const ONE_PLANE: f64 = 1e-9;

/// Most patches of a surface in one zone. Further triangles join the patch with the nearest normal.
const MOST_PATCHES: usize = 96;

/// How far a patch may stand out over another's plane (share of the distance between them) and still count as not: below the
/// turn between neighbouring patches of a hollow surface, above the noise of rounded corners.
const HOLLOW: f64 = 0.02;

/// Neighbouring triangles of one direction, as far as they are beyond the other surface.
#[derive(Debug)]
pub(crate) struct Patch {
    /// Unit, outward.
    pub normal: Point,
    /// A point of its plane.
    at: Point,
    /// Corners of what lies beyond the other surface, the curve's points included.
    pub points: Vec<Point>,
    /// Their mean.
    middle: Point,
    /// Diagonal of the box around them, metres: the patch's size, whatever its triangles'.
    pub size: f64,
    /// Whether all its triangles have one plane.
    pub flat: bool,
    /// The cuts it has a part in.
    pub cuts: Vec<u32>,
}

/// Patches of which none stands out over the plane of another: together, part of a convex body.
#[derive(Debug, Default)]
pub(crate) struct Cluster {
    pub patches: Vec<usize>,
}

/// The patches of one surface (`w`: the tool's or the mock-up's) in a zone, largest first.
pub(crate) fn patches(ground: &Ground<'_>, zones: &Zones, zone: &Zone, w: usize) -> Vec<Patch> {
    let mut cuts: Vec<(u32, u32)> = zone.cuts.iter().map(|c| (zones.cuts[*c as usize].faces[w], *c)).collect();
    cuts.sort_unstable();
    let mut found: Vec<Patch> = Vec::new();
    for same in cuts.chunk_by(|x, y| x.0 == y.0) {
        let face = &zones.faces[w][same[0].0 as usize];
        let patch = place(&mut found, &face.normal, &face.corners[0], &face.corners);
        for (_, c) in same {
            let points = zones.cuts[*c as usize].points;
            patch.points.extend_from_slice(&zones.points[points.0 as usize..points.1 as usize]);
            patch.cuts.push(*c);
        }
        for (k, side) in face.side.iter().enumerate() {
            if *side < 0 && face.is_corner_of(k, |c| zone.cuts.binary_search(&c).is_ok()) {
                patch.points.push(face.corners[k]);
            }
        }
    }
    for [t, cut] in &zone.inside[w] {
        let corners = ground.triangle(w, *t);
        let near = &zones.faces[w][zones.cuts[*cut as usize].faces[w] as usize];
        let Some(normal) = ground.outward(w, *t, &corners, near) else { continue };
        place(&mut found, &normal, &corners[0], &corners).points.extend_from_slice(&corners);
    }
    for patch in &mut found {
        let mut bounds = Aabb::EMPTY;
        patch.points.iter().for_each(|p| bounds.grow(p));
        patch.size = norm(&bounds.extent());
        let sum = patch.points.iter().fold([0.0; 3], |s, p| add(&s, p));
        patch.middle = scaled(&sum, 1.0 / patch.points.len().max(1) as f64);
    }
    found.retain(|p| !p.points.is_empty());
    found.sort_by(|p, q| q.size.total_cmp(&p.size));
    found
}

/// The patch that a triangle belongs to.
fn place<'a>(found: &'a mut Vec<Patch>, normal: &Point, at: &Point, corners: &[Point; 3]) -> &'a mut Patch {
    let fits = |p: &Patch| {
        let turn = 1.0 - dot(&p.normal, normal);
        if turn > 1.0 - ONE_PATCH {
            return false;
        }
        // The plane of one must pass the other as near as a surface that turns so much would.
        let way = sub(at, &p.at);
        let far = norm(&way);
        let off = dot(&way, &p.normal).abs();
        let noise = 1e-6 * far + 1e-12 * at.iter().fold(0.0f64, |m, x| m.max(x.abs()));
        off <= noise + far * (2.0 * turn.max(0.0)).sqrt()
    };
    let found_at = found.iter().position(fits).or_else(|| {
        let nearest = |i: &usize, j: &usize| dot(&found[*i].normal, normal).total_cmp(&dot(&found[*j].normal, normal));
        (found.len() >= MOST_PATCHES).then(|| (0..found.len()).max_by(nearest)).flatten()
    });
    let i = found_at.unwrap_or_else(|| {
        found.push(Patch {
            normal: *normal,
            at: *at,
            points: Vec::new(),
            middle: corners[0],
            size: 0.0,
            flat: true,
            cuts: Vec::new(),
        });
        found.len() - 1
    });
    found[i].flat &= 1.0 - dot(&found[i].normal, normal) <= ONE_PLANE;
    &mut found[i]
}

/// Patches that bulge the same way together, the largest first.
pub(crate) fn clusters(patches: &[Patch]) -> Vec<Cluster> {
    let stands_out = |p: &Patch, q: &Patch| {
        let way = sub(&q.middle, &p.middle);
        dot(&way, &p.normal) > HOLLOW * norm(&way)
    };
    let mut found: Vec<Cluster> = Vec::new();
    for i in 0..patches.len() {
        let fits = |c: &Cluster| {
            c.patches.iter().all(|j| !stands_out(&patches[i], &patches[*j]) && !stands_out(&patches[*j], &patches[i]))
        };
        match found.iter().position(fits) {
            Some(c) => found[c].patches.push(i),
            None => found.push(Cluster { patches: vec![i] }),
        }
    }
    found
}
