//! The two surfaces of a zone as a few patches: triangles of one plane, or of one turn of a curved surface, however many they
//! are.

use std::ops::Range;

use crate::bounds::{Aabb, Point};
use crate::contacts::adjacency::NONE;
use crate::contacts::heights::highest_and_lowest;
use crate::contacts::numbered::Numbered;
use crate::contacts::points::PointSet;
use crate::contacts::zones::Zones;
use crate::contacts::Ground;
use crate::simd::{Checked, WIDE_LANES};
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
pub(crate) const HOLLOW: f64 = 0.02;

/// Points of a patch that are all looked at.
const MOST_CORNERS: usize = 8;

/// Directions along which the outermost points of a patch stand for all of them: axes and diagonals of a cube, and one again.
const OUTERMOST: [Point; WIDE_LANES] = [
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [1.0, 1.0, 1.0],
    [-1.0, 1.0, 1.0],
    [1.0, -1.0, 1.0],
    [1.0, 1.0, -1.0],
    [1.0, 1.0, -1.0],
];

/// Neighbouring triangles of one direction, as far as they are beyond the other surface.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Patch {
    /// Unit, outward.
    pub normal: Point,
    /// A point of its plane.
    pub at: Point,
    /// The mean of its points.
    pub middle: Point,
    /// Diagonal of the box around them, metres: the patch's size, whatever its triangles'.
    pub size: f64,
    /// Whether all its triangles have one plane.
    pub flat: bool,
    /// Its points among all of [`Patches`], and the outermost.
    points: (u32, u32),
    corners: (u32, u32),
}

impl Patch {
    /// Whether a point is strictly over the plane of a flat patch, or stands out over one that is not.
    pub fn is_below(&self, x: &Point) -> bool {
        let (way, height) = (sub(x, &self.middle), dot(&sub(x, &self.at), &self.normal));
        let share = if self.flat { 1e-6 } else { HOLLOW };
        height > 0.0 && height * height > share * share * dot(&way, &way)
    }
}

impl Patch {
    /// Whether points of another patch may be over this one's plane.
    pub fn may_be_below(&self, other: &Patch) -> bool {
        dot(&sub(&other.middle, &self.at), &self.normal) + 1.001 * other.size > 0.0
    }
}

/// A triangle, or the part of it that is beyond the other surface.
#[derive(Debug)]
struct Piece {
    id: u32,
    patch: u32,
    /// Its points among all.
    points: (u32, u32),
    closed: bool,
}

/// The patches of one surface in a zone, largest first. Kept as working memory.
#[derive(Debug, Default)]
pub(crate) struct Patches {
    pub list: Vec<Patch>,
    /// Corners of what lies beyond the other surface, the curve's points included, each once, patch by patch.
    points: Vec<Point>,
    /// For each of them where its cuts are: those of the curve have several, others none.
    cuts_of: Vec<(u32, u32)>,
    /// Cuts, point by point.
    pub point_cuts: Vec<u32>,
    /// Points of the curve on one patch, by their places, with their cuts.
    curve: Vec<(u32, u32)>,
    corners: Vec<Point>,
    pieces: Vec<Piece>,
    /// Points piece by piece, with the cuts of those that are the curve's, or [`NONE`].
    piece_points: Vec<(Point, u32)>,
    split: Split,
    /// Pieces patch by patch.
    order: Vec<u32>,
    known: PointSet,
}

/// Working memory of [`Patches::split`].
#[derive(Debug, Default)]
struct Split {
    place_of: Numbered,
    open: Vec<bool>,
    taken: Vec<bool>,
    seen: Vec<bool>,
    stack: Vec<u32>,
}

impl Patches {
    /// The points of a patch, each once.
    pub fn points(&self, patch: &Patch) -> &[Point] {
        &self.points[patch.points.0 as usize..patch.points.1 as usize]
    }

    /// For each of them where its cuts are among [`point_cuts`](Self::point_cuts).
    pub fn cuts_of(&self, patch: &Patch) -> &[(u32, u32)] {
        &self.cuts_of[patch.points.0 as usize..patch.points.1 as usize]
    }

    /// The cuts of a patch, each for every point of it that it has.
    pub fn cuts(&self, patch: &Patch) -> &[u32] {
        let (first, last) = (self.cuts_of[patch.points.0 as usize], self.cuts_of[patch.points.1 as usize - 1]);
        &self.point_cuts[first.0 as usize..last.1 as usize]
    }

    /// The outermost points of a patch along a few directions, by their places among those of all patches.
    pub fn corners(&self, patch: &Patch) -> Range<usize> {
        patch.corners.0 as usize..patch.corners.1 as usize
    }

    /// Those of all patches.
    pub fn all_corners(&self) -> &[Point] {
        &self.corners
    }

    /// Makes the patches of a surface (`w`: the tool's or the mock-up's) in a zone.
    pub fn set(&mut self, ground: &Ground<'_>, zones: &Zones, zone: usize, w: usize) {
        self.list.clear();
        self.pieces.clear();
        self.piece_points.clear();
        self.push_cut_faces(zones, zone, w);
        self.push_inside(ground, zones, zone, w);
        self.split(ground, w);
        self.gather();
        self.finish(ground.lanes);
    }

    fn push_cut_faces(&mut self, zones: &Zones, zone: usize, w: usize) {
        let face_of = |c: &u32| zones.cuts[*c as usize].faces[w];
        for same in zones.zones[zone].cuts[w].chunk_by(|x, y| face_of(x) == face_of(y)) {
            let face = &zones.faces[w][face_of(&same[0]) as usize];
            let from = self.piece_points.len() as u32;
            for c in same {
                let shared = zones.cuts[*c as usize].points;
                let points = &zones.points[shared.0 as usize..shared.1 as usize];
                self.piece_points.extend(points.iter().map(|x| (*x, *c)));
            }
            for (k, side) in face.side.iter().enumerate() {
                if *side < 0 && face.is_corner_of(k, |c| zones.zone_of_cut[c as usize] == zone as u32) {
                    self.piece_points.push((face.corners[k], NONE));
                }
            }
            let patch = self.place(&face.normal, &face.corners[0]);
            let points = (from, self.piece_points.len() as u32);
            self.pieces.push(Piece { id: face.id, patch, points, closed: face.closed });
        }
    }

    fn push_inside(&mut self, ground: &Ground<'_>, zones: &Zones, zone: usize, w: usize) {
        for [t, cut] in &zones.zones[zone].inside[w] {
            let corners = ground.triangle(w, *t);
            let near = &zones.faces[w][zones.cuts[*cut as usize].faces[w] as usize];
            let Some(normal) = ground.outward(w, *t, &corners, near) else { continue };
            let patch = self.place(&normal, &corners[0]);
            let from = self.piece_points.len() as u32;
            self.piece_points.extend(corners.map(|x| (x, NONE)));
            self.pieces.push(Piece { id: *t, patch, points: (from, from + 3), closed: near.closed });
        }
    }

    /// The patch that a triangle belongs to.
    fn place(&mut self, normal: &Point, at: &Point) -> u32 {
        let found = &mut self.list;
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
            let nearest =
                |i: &usize, j: &usize| dot(&found[*i].normal, normal).total_cmp(&dot(&found[*j].normal, normal));
            (found.len() >= MOST_PATCHES).then(|| (0..found.len()).max_by(nearest)).flatten()
        });
        let i = found_at.unwrap_or_else(|| {
            found.push(Patch {
                normal: *normal,
                at: *at,
                middle: *at,
                size: 0.0,
                flat: true,
                points: (0, 0),
                corners: (0, 0),
            });
            found.len() - 1
        });
        found[i].flat &= 1.0 - dot(&found[i].normal, normal) <= ONE_PLANE;
        i as u32
    }

    /// Gives each connected piece of a patch a patch of its own: two faces left and right of a slot have one plane, and yet
    /// each belongs to its own side. Only where the surface is closed and so its edges are known.
    fn split(&mut self, ground: &Ground<'_>, w: usize) {
        let Patches { list, pieces, .. } = self;
        let Split { place_of, open, taken, seen, stack } = &mut self.split;
        if list.len() == pieces.len() {
            return;
        }
        place_of.clear();
        // A piece is found by its number.
        pieces.iter().for_each(|piece| _ = place_of.number(u64::from(piece.id)));
        for (flags, count) in [(&mut *open, list.len()), (&mut *taken, list.len()), (&mut *seen, pieces.len())] {
            flags.clear();
            flags.resize(count, false);
        }
        pieces.iter().for_each(|p| open[p.patch as usize] |= !p.closed);
        for i in 0..pieces.len() {
            let patch = pieces[i].patch;
            if seen[i] || open[patch as usize] {
                continue;
            }
            // The first connected piece keeps the patch.
            let target = if std::mem::replace(&mut taken[patch as usize], true) {
                list.push(list[patch as usize]);
                list.len() as u32 - 1
            } else {
                patch
            };
            seen[i] = true;
            stack.push(i as u32);
            while let Some(j) = stack.pop() {
                for n in ground.adjacency[w].neighbours[pieces[j as usize].id as usize] {
                    let Some(k) = place_of.get(u64::from(n)) else { continue };
                    if !seen[k as usize] && pieces[k as usize].patch == patch {
                        seen[k as usize] = true;
                        stack.push(k);
                    }
                }
                pieces[j as usize].patch = target;
            }
        }
    }

    /// Puts the points of each patch together, in the order of its pieces.
    fn gather(&mut self) {
        let Patches { list, points, cuts_of, point_cuts, curve, pieces, piece_points, order, known, .. } = self;
        order.clear();
        order.extend(0..pieces.len() as u32);
        order.sort_by_key(|i| pieces[*i as usize].patch);
        points.clear();
        cuts_of.clear();
        point_cuts.clear();
        for same in order.chunk_by(|i, j| pieces[*i as usize].patch == pieces[*j as usize].patch) {
            let from = points.len();
            known.clear();
            curve.clear();
            for piece in same.iter().map(|i| &pieces[*i as usize]) {
                for (x, cut) in &piece_points[piece.points.0 as usize..piece.points.1 as usize] {
                    let (place, is_new) = known.insert(x, &points[from..]);
                    if is_new {
                        points.push(*x);
                        cuts_of.push((0, 0));
                    }
                    if *cut != NONE {
                        cuts_of[from + place as usize].1 += 1;
                        curve.push((place, *cut));
                    }
                }
            }
            // The cuts of each point together: from here on each is filled from where it begins.
            let mut begin = point_cuts.len() as u32;
            for of in &mut cuts_of[from..] {
                let count = of.1;
                *of = (begin, begin);
                begin += count;
            }
            point_cuts.resize(begin as usize, 0);
            for (place, cut) in curve.iter() {
                let end = &mut cuts_of[from + *place as usize].1;
                point_cuts[*end as usize] = *cut;
                *end += 1;
            }
            list[pieces[same[0] as usize].patch as usize].points = (from as u32, points.len() as u32);
        }
        list.retain(|p| p.points.0 < p.points.1);
    }

    /// Sets what follows from the points.
    fn finish(&mut self, lanes: Checked) {
        let Patches { list, points, corners, .. } = self;
        corners.clear();
        for patch in list.iter_mut() {
            let points = &points[patch.points.0 as usize..patch.points.1 as usize];
            let mut bounds = Aabb::EMPTY;
            points.iter().for_each(|p| bounds.grow(p));
            patch.size = length(&bounds.extent());
            let sum = points.iter().fold([0.0; 3], |s, p| add(&s, p));
            patch.middle = scaled(&sum, 1.0 / points.len() as f64);
            patch.corners.0 = corners.len() as u32;
            if points.len() <= MOST_CORNERS {
                corners.extend_from_slice(points);
                patch.corners.1 = corners.len() as u32;
                continue;
            }
            let (high, low) = highest_and_lowest(lanes, points, points, &OUTERMOST);
            // Most patches have few corners, each outermost along several.
            let (mut chosen, mut count) = ([0; 2 * WIDE_LANES], 0);
            for i in low.at.into_iter().chain(high.at).map(|i| i as u32) {
                if !chosen[..count].contains(&i) {
                    chosen[count] = i;
                    count += 1;
                }
            }
            corners.extend(chosen[..count].iter().map(|i| points[*i as usize]));
            patch.corners.1 = corners.len() as u32;
        }
        list.sort_by(|p, q| q.size.total_cmp(&p.size));
    }
}
