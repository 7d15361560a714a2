//! On which side of the other surface the corners of cut triangles are.

use crate::contacts::adjacency::NONE;
use crate::contacts::zones::{Zones, MOCKUP, TOOL};
use crate::contacts::Ground;
use crate::simd::{Kernel, Simd, Wide};
use crate::vectors::{cross, dot, sub};

/// The nearest cut tells on which side a corner is. Where two are equally near, at an edge of the other surface, the one whose
/// line the corner stands off most steeply, in the plane of the triangle: there the two lines are a bend of the curve, and the
/// corner is on the outer side of it. Where a surface turns away within a triangle's length the nearest cut may be wrong about a
/// far corner: outside the other solid's box it is outside.
pub(crate) fn classify(ground: &Ground<'_>, part: u32, zones: &mut Zones) {
    let mut squares = std::mem::take(&mut zones.squares);
    ground.lanes.run(Squares { zones, out: &mut squares });
    for w in [TOOL, MOCKUP] {
        // By corner: the square of the distance of the nearest cut, and which one that is.
        let mut nearest = std::mem::take(&mut zones.nearest);
        nearest.clear();
        nearest.extend(zones.by_face(w).map(|same| {
            let mut best = [(f64::INFINITY, NONE); 3];
            for c in same.iter().filter(|c| !zones.cuts[**c as usize].flat) {
                for (k, best) in best.iter_mut().enumerate() {
                    let square = squares[*c as usize][3 * w + k];
                    let is_level = best.1 != NONE && square >= best.0 * (1.0 - 1e-9) && square <= best.0 * (1.0 + 1e-9);
                    *best = match is_level {
                        true if steepness(zones, w, k, (square, *c)) > steepness(zones, w, k, *best) => (square, *c),
                        true => *best,
                        // By place: which one it is cannot be foreseen.
                        false => [*best, (square, *c)][usize::from(square < best.0)],
                    };
                }
            }
            best
        }));
        let enclosure = ground.enclosure(1 - w, part);
        for (i, best) in nearest.iter().enumerate() {
            for (k, (square, cut)) in best.iter().enumerate().filter(|(_, best)| best.1 != NONE) {
                let (corner, other) = (&zones.faces[w][i].corners[k], zones.face(1 - w, *cut));
                let height = dot(&sub(corner, &zones.ends(*cut)[0]), &other.normal);
                let is_on = *square == 0.0 || height * height < 1e-18 * square;
                let is_outside = || other.closed && !ground.is_enclosed(1 - w, &enclosure, corner);
                let side = match height < 0.0 {
                    _ if is_on => 0,
                    true if !is_outside() => -1,
                    _ => 1,
                };
                let face = &mut zones.faces[w][i];
                (face.nearest[k], face.side[k]) = (*cut, side);
            }
        }
        zones.nearest = nearest;
    }
    zones.squares = squares;
}

/// How steeply corner `k` of a face stands off the line of its cut, whose distance has this square, in the face's own plane:
/// that other plane may be met at any angle.
fn steepness(zones: &Zones, w: usize, k: usize, (square, cut): (f64, u32)) -> f64 {
    if square == 0.0 {
        return 0.0;
    }
    let [a, b] = zones.ends(cut);
    let (line, from) = (sub(&b, &a), sub(&zones.face(w, cut).corners[k], &a));
    let lengths = dot(&line, &line);
    if lengths > 0.0 {
        let off = cross(&from, &line);
        return dot(&off, &off) / lengths / square;
    }
    let height = dot(&from, &zones.face(1 - w, cut).normal);
    height * height / square
}

/// The squares of the distances of each cut from the corners of its two faces, the tool's first.
struct Squares<'a> {
    zones: &'a Zones,
    out: &'a mut Vec<Wide>,
}

impl Kernel for Squares<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, s: S) {
        self.out.clear();
        for i in 0..self.zones.cuts.len() as u32 {
            let (p, q) = (&self.zones.face(TOOL, i).corners, &self.zones.face(MOCKUP, i).corners);
            let corners = s.wide_points([&p[0], &p[1], &p[2], &q[0], &q[1], &q[2], &q[2], &q[2]]);
            let [a, b] = self.zones.ends(i);
            let line = sub(&b, &a);
            let lengths = dot(&line, &line);
            let line = [s.wide_splat(line[0]), s.wide_splat(line[1]), s.wide_splat(line[2])];
            let mut off = corners;
            for k in 0..3 {
                off[k] = corners[k] - s.wide_splat(a[k]);
            }
            if lengths > 0.0 {
                let along = off[0] * line[0] + off[1] * line[1] + off[2] * line[2];
                let share = s.wide_divide(along, s.wide_splat(lengths));
                let share = s.wide_min(s.wide_max(share, s.wide_splat(0.0)), s.wide_splat(1.0));
                for k in 0..3 {
                    off[k] = off[k] - share * line[k];
                }
            }
            let mut squares = Wide::default();
            s.wide_store(off[0] * off[0] + off[1] * off[1] + off[2] * off[2], &mut squares);
            self.out.push(squares);
        }
    }
}
