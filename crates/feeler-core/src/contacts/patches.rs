//! The two surfaces of a zone as a few patches: triangles of one plane, or of one turn of a curved surface, however many they
//! are; and patches that bulge the same way together.

use crate::bounds::{Aabb, Point};
use crate::contacts::adjacency::NONE;
use crate::contacts::zones::{IdMap, Zone, Zones};
use crate::contacts::Ground;
use crate::vectors::{add, dot, length, scaled, sub};

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

/// Directions along which the outermost points of a patch stand for all of them: axes and diagonals of a cube.
const OUTERMOST: [Point; 7] = [
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [1.0, 1.0, 1.0],
    [-1.0, 1.0, 1.0],
    [1.0, -1.0, 1.0],
    [1.0, 1.0, -1.0],
];

/// Neighbouring triangles of one direction, as far as they are beyond the other surface.
#[derive(Debug)]
pub(crate) struct Patch {
    /// Unit, outward.
    pub normal: Point,
    /// A point of its plane.
    at: Point,
    /// Corners of what lies beyond the other surface, the curve's points included.
    pub points: Vec<Point>,
    /// For each point of the curve its cut; [`NONE`] for a corner.
    pub sources: Vec<u32>,
    /// The outermost of them along a few directions.
    corners: Vec<Point>,
    /// Their mean.
    middle: Point,
    /// Diagonal of the box around them, metres: the patch's size, whatever its triangles'.
    pub size: f64,
    /// Whether all its triangles have one plane.
    pub flat: bool,
    /// The cuts it has a part in.
    pub cuts: Vec<u32>,
}

impl Patch {
    /// Whether a point stands out over the patch's plane.
    pub fn is_under(&self, x: &Point) -> bool {
        self.side_of(x) > 0.0
    }

    /// Whether a point is strictly over the plane of a flat patch, or stands out over one that is not.
    pub fn is_below(&self, x: &Point) -> bool {
        let way = sub(x, &self.middle);
        dot(&sub(x, &self.at), &self.normal) > if self.flat { 1e-6 } else { HOLLOW } * length(&way)
    }

    /// 1 over the plane, -1 below, 0 about on it.
    fn side_of(&self, x: &Point) -> f64 {
        let way = sub(x, &self.middle);
        // The plane of its first triangle: on a bulging surface all others are behind it, as behind no plane through a mean.
        let height = dot(&sub(x, &self.at), &self.normal);
        if height * height <= HOLLOW * HOLLOW * dot(&way, &way) {
            0.0
        } else {
            height.signum()
        }
    }

    /// Sets what follows from the points.
    fn finish(&mut self) {
        let mut bounds = Aabb::EMPTY;
        self.points.iter().for_each(|p| bounds.grow(p));
        self.size = length(&bounds.extent());
        let sum = self.points.iter().fold([0.0; 3], |s, p| add(&s, p));
        self.middle = scaled(&sum, 1.0 / self.points.len().max(1) as f64);
        for d in &OUTERMOST {
            let mut ends = [(f64::INFINITY, 0), (f64::NEG_INFINITY, 0)];
            for (i, p) in self.points.iter().enumerate() {
                let height = dot(p, d);
                if height <= ends[0].0 {
                    ends[0] = (height, i);
                }
                if height >= ends[1].0 {
                    ends[1] = (height, i);
                }
            }
            for (_, i) in ends {
                // Most patches have few corners, each outermost along several.
                if !self.corners.contains(&self.points[i]) {
                    self.corners.push(self.points[i]);
                }
            }
        }
    }
}

/// Patches of which none stands out over the plane of another: together, part of a convex body.
#[derive(Debug, Default)]
pub(crate) struct Cluster {
    pub patches: Vec<usize>,
    /// Patches of which a part belongs to it.
    pub lent: Vec<usize>,
}

/// A triangle, or the part of it that is beyond the other surface.
struct Piece {
    id: u32,
    patch: usize,
    /// Its points among all, and its cuts among the zone's sorted ones.
    points: (usize, usize),
    cuts: (usize, usize),
    closed: bool,
}

/// The patches of one surface (`w`: the tool's or the mock-up's) in a zone, largest first.
pub(crate) fn patches(ground: &Ground<'_>, zones: &Zones, zone: &Zone, w: usize) -> Vec<Patch> {
    let mut cuts: Vec<(u32, u32)> = zone.cuts.iter().map(|c| (zones.cuts[*c as usize].faces[w], *c)).collect();
    cuts.sort_unstable();
    let mut found: Vec<Patch> = Vec::new();
    let (mut points, mut sources): (Vec<Point>, Vec<u32>) = Default::default();
    let mut pieces: Vec<Piece> = Vec::new();
    let mut at = 0;
    for same in cuts.chunk_by(|x, y| x.0 == y.0) {
        let face = &zones.faces[w][same[0].0 as usize];
        let from = points.len();
        for (_, c) in same {
            let shared = zones.cuts[*c as usize].points;
            points.extend_from_slice(&zones.points[shared.0 as usize..shared.1 as usize]);
            sources.resize(points.len(), *c);
        }
        for (k, side) in face.side.iter().enumerate() {
            if *side < 0 && face.is_corner_of(k, |c| zone.cuts.binary_search(&c).is_ok()) {
                points.push(face.corners[k]);
                sources.push(NONE);
            }
        }
        let patch = place(&mut found, &face.normal, &face.corners[0]);
        let (id, closed) = (face.id, face.closed);
        pieces.push(Piece { id, patch, points: (from, points.len()), cuts: (at, at + same.len()), closed });
        at += same.len();
    }
    for [t, cut] in &zone.inside[w] {
        let corners = ground.triangle(w, *t);
        let near = &zones.faces[w][zones.cuts[*cut as usize].faces[w] as usize];
        let Some(normal) = ground.outward(w, *t, &corners, near) else { continue };
        let patch = place(&mut found, &normal, &corners[0]);
        let from = points.len();
        points.extend_from_slice(&corners);
        sources.extend([NONE; 3]);
        pieces.push(Piece { id: *t, patch, points: (from, from + 3), cuts: (0, 0), closed: near.closed });
    }
    split(ground, w, &mut found, &mut pieces);
    for piece in &pieces {
        let patch = &mut found[piece.patch];
        patch.points.extend_from_slice(&points[piece.points.0..piece.points.1]);
        patch.sources.extend_from_slice(&sources[piece.points.0..piece.points.1]);
        patch.cuts.extend(cuts[piece.cuts.0..piece.cuts.1].iter().map(|c| c.1));
    }
    found.retain(|p| !p.points.is_empty());
    found.iter_mut().for_each(Patch::finish);
    found.sort_by(|p, q| q.size.total_cmp(&p.size));
    found
}

/// Gives each connected piece of a patch a patch of its own: two faces left and right of a slot have one plane, and yet each
/// belongs to its own side. Only where the surface is closed and so its edges are known.
fn split(ground: &Ground<'_>, w: usize, found: &mut Vec<Patch>, pieces: &mut [Piece]) {
    if found.len() == pieces.len() {
        return;
    }
    let mut open = vec![false; found.len()];
    pieces.iter().for_each(|p| open[p.patch] |= !p.closed);
    let mut place_of: IdMap<u32> = IdMap::default();
    for (i, piece) in pieces.iter().enumerate() {
        place_of.insert(piece.id, i as u32);
    }
    let mut seen = vec![false; pieces.len()];
    let mut taken = vec![false; found.len()];
    let mut stack = Vec::new();
    for i in 0..pieces.len() {
        let patch = pieces[i].patch;
        if seen[i] || open[patch] {
            continue;
        }
        // The first connected piece keeps the patch.
        let target = if taken[patch] {
            found.push(Patch {
                points: Vec::new(),
                sources: Vec::new(),
                corners: Vec::new(),
                cuts: Vec::new(),
                ..found[patch]
            });
            found.len() - 1
        } else {
            patch
        };
        taken[patch] = true;
        seen[i] = true;
        stack.push(i);
        while let Some(j) = stack.pop() {
            for n in ground.adjacency[w].neighbours[pieces[j].id as usize] {
                let Some(k) = place_of.get(&n).map(|k| *k as usize) else { continue };
                if !seen[k] && pieces[k].patch == patch {
                    seen[k] = true;
                    stack.push(k);
                }
            }
            pieces[j].patch = target;
        }
    }
}

/// The patch that a triangle belongs to.
fn place(found: &mut Vec<Patch>, normal: &Point, at: &Point) -> usize {
    let fits = |p: &Patch| {
        let turn = 1.0 - dot(&p.normal, normal);
        if turn > 1.0 - ONE_PATCH {
            return false;
        }
        // The plane of one must pass the other as near as a surface that turns so much would.
        let way = sub(at, &p.at);
        let far = length(&way);
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
            sources: Vec::new(),
            corners: Vec::new(),
            middle: *at,
            size: 0.0,
            flat: true,
            cuts: Vec::new(),
        });
        found.len() - 1
    });
    found[i].flat &= 1.0 - dot(&found[i].normal, normal) <= ONE_PLANE;
    i
}

/// Patches that bulge the same way together, the largest first.
///
/// A patch that reaches from behind another's plane to before it, as the end of an L does with both its legs, makes no body of
/// its own if it can help: it lends its nearer part to each.
pub(crate) fn clusters(patches: &[Patch]) -> Vec<Cluster> {
    let straddles = |i: usize| {
        patches.iter().any(|p| {
            let (mut above, mut below) = (false, false);
            patches[i].corners.iter().any(|x| {
                let side = p.side_of(x);
                above |= side > 0.0;
                below |= side < 0.0;
                above && below
            })
        })
    };
    let (last, first): (Vec<usize>, Vec<usize>) = (0..patches.len()).partition(|i| straddles(*i));
    let mut found: Vec<Cluster> = Vec::new();
    let apart = |i: usize, j: usize| patches[i].is_under(&patches[j].middle) || patches[j].is_under(&patches[i].middle);
    for i in first {
        match found.iter().position(|c| c.patches.iter().all(|j| !apart(i, *j))) {
            Some(c) => found[c].patches.push(i),
            None => found.push(Cluster { patches: vec![i], ..Cluster::default() }),
        }
    }
    let bodies = found.len();
    for i in last {
        let mut lent = false;
        for c in &mut found[..bodies] {
            let within = |x: &Point| c.patches.iter().all(|j| !patches[*j].is_under(x));
            if patches[i].corners.iter().any(within)
                && c.patches.iter().all(|j| !patches[i].is_under(&patches[*j].middle))
            {
                lent = true;
                c.lent.push(i);
            }
        }
        if !lent {
            match found[bodies..].iter().position(|c| c.patches.iter().all(|j| !apart(i, *j))) {
                Some(c) => found[bodies + c].patches.push(i),
                None => found.push(Cluster { patches: vec![i], ..Cluster::default() }),
            }
        }
    }
    found
}
