//! On which side of the other surface the corners of cut triangles are.

use crate::contacts::adjacency::NONE;
use crate::contacts::zones::{Zones, MOCKUP, TOOL};
use crate::contacts::Ground;
use crate::simd::{Kernel, Simd, Wide};
use crate::vectors::{dot, sub};

/// The nearest cut tells on which side a corner is. Where two are equally near, at an edge of the other surface, the one whose
/// line the corner stands off most steeply, in the plane of the triangle: there the two lines are a bend of the curve, and the
/// corner is on the outer side of it. Where a surface turns away within a triangle's length the nearest cut may be wrong about a
/// far corner: outside the other solid's box it is outside.
pub(crate) fn classify(ground: &Ground<'_>, part: u32, zones: &mut Zones) {
    let mut stands = std::mem::take(&mut zones.stands);
    ground.lanes.run(Stands { zones, out: &mut stands });
    for w in [TOOL, MOCKUP] {
        let mut judged = std::mem::take(&mut zones.judged);
        ground.lanes.run(Nearest { zones, w, stands: &stands, out: &mut judged });
        let enclosure = ground.enclosure(1 - w, part);
        for (i, corners) in judged.iter().enumerate() {
            let Zones { faces, cuts, way, .. } = &mut *zones;
            let [of_tool, of_mockup] = faces;
            let (face, others) =
                if w == TOOL { (&mut of_tool[i], &*of_mockup) } else { (&mut of_mockup[i], &*of_tool) };
            face.nearest = corners.cuts;
            for k in 0..3 {
                let (is_clear, is_below) = (corners.clear >> k & 1, corners.below >> k & 1);
                face.side[k] = (is_clear as i8) * (1 - 2 * is_below as i8);
            }
            let mut inside = corners.clear & corners.below;
            while inside != 0 {
                let k = inside.trailing_zeros() as usize;
                inside &= inside - 1;
                let cut = &cuts[corners.cuts[k] as usize];
                let is_closed = others[cut.faces[1 - w] as usize].closed && (w == MOCKUP || way.is_none());
                if is_closed && !ground.is_enclosed(1 - w, &enclosure, &face.corners[k]) {
                    face.side[k] = 1;
                }
            }
        }
        zones.judged = judged;
    }
    zones.stands = stands;
}

/// How the corners of a cut's two faces stand to the line of the cut, the tool's first; the last two lanes say nothing.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Stand {
    /// Squares of their distances.
    square: Wide,
    /// How steeply they stand off it, each in the plane of its own face: that of the other may be met at any angle.
    steepness: Wide,
    /// How high they are over the plane of the other face.
    height: Wide,
}

/// What the nearest cuts say about the corners of a face, one bit a corner.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Judged {
    /// Their places among the cuts; [`NONE`] where there is none.
    cuts: [u32; 3],
    /// Off the plane of the other face, and under it.
    clear: u8,
    below: u8,
}

/// Finds how the corners stand to all cuts.
struct Stands<'a> {
    zones: &'a Zones,
    out: &'a mut Vec<Stand>,
}

impl Kernel for Stands<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, s: S) {
        self.out.clear();
        let zero = s.wide_splat(0.0);
        let is_of_tool = s.wide_above(s.wide_splat(2.5), s.wide_load(&[0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]));
        for i in 0..self.zones.cuts.len() as u32 {
            let (tool, mockup) = (self.zones.face(TOOL, i), self.zones.face(MOCKUP, i));
            let (outward, _) = self.zones.side_of(MOCKUP, self.zones.cuts[i as usize].faces[MOCKUP]);
            let (p, q) = (&tool.corners, &mockup.corners);
            let corners = s.wide_points([&p[0], &p[1], &p[2], &q[0], &q[1], &q[2], &q[2], &q[2]]);
            let [a, b] = self.zones.ends(i);
            let line = sub(&b, &a);
            let lengths = dot(&line, &line);
            let line = [s.wide_splat(line[0]), s.wide_splat(line[1]), s.wide_splat(line[2])];
            let mut from = corners;
            for k in 0..3 {
                from[k] = corners[k] - s.wide_splat(a[k]);
            }
            let mut height = zero;
            for k in 0..3 {
                let n = s.choose(is_of_tool, s.wide_splat(outward[k]), s.wide_splat(tool.normal[k]));
                height = if k == 0 { from[k] * n } else { height + from[k] * n };
            }
            let mut off = from;
            let steep = if lengths > 0.0 {
                let along = from[0] * line[0] + from[1] * line[1] + from[2] * line[2];
                let share = s.wide_divide(along, s.wide_splat(lengths));
                let share = s.wide_min(s.wide_max(share, zero), s.wide_splat(1.0));
                for k in 0..3 {
                    off[k] = from[k] - share * line[k];
                }
                let across = [
                    from[1] * line[2] - from[2] * line[1],
                    from[2] * line[0] - from[0] * line[2],
                    from[0] * line[1] - from[1] * line[0],
                ];
                let across = across[0] * across[0] + across[1] * across[1] + across[2] * across[2];
                s.wide_divide(across, s.wide_splat(lengths))
            } else {
                height * height
            };
            let square = off[0] * off[0] + off[1] * off[1] + off[2] * off[2];
            let steepness = s.choose(s.wide_above(square, zero), s.wide_divide(steep, square), zero);
            let mut stand = Stand::default();
            s.wide_store(square, &mut stand.square);
            s.wide_store(steepness, &mut stand.steepness);
            s.wide_store(height, &mut stand.height);
            self.out.push(stand);
        }
    }
}

/// Finds, for each face of one surface and each of its corners, the cut that tells on which side that is, and what it says.
struct Nearest<'a> {
    zones: &'a Zones,
    w: usize,
    stands: &'a [Stand],
    out: &'a mut Vec<Judged>,
}

impl Kernel for Nearest<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, s: S) {
        self.out.clear();
        let (zero, on) = (s.wide_splat(0.0), s.wide_splat(1e-18));
        let (less, more) = (s.wide_splat(1.0 - 1e-9), s.wide_splat(1.0 + 1e-9));
        for same in self.zones.by_face(self.w) {
            let mut square = s.wide_splat(f64::INFINITY);
            let (mut steepness, mut height) = (zero, zero);
            let mut place = s.wide_splat(f64::from(NONE));
            for c in same {
                if self.zones.cuts[*c as usize].flat {
                    continue;
                }
                let stand = &self.stands[*c as usize];
                let (of_this, steep) = (s.wide_load(&stand.square), s.wide_load(&stand.steepness));
                // The nearer one; of two as near the steeper.
                let differs = s.either(s.wide_above(square * less, of_this), s.wide_above(of_this, square * more));
                let (is_nearer, is_steeper) = (s.wide_above(square, of_this), s.wide_above(steep, steepness));
                let as_near = s.differing(is_steeper, s.both(is_steeper, differs));
                let is_better = s.either(s.both(is_nearer, differs), as_near);
                square = s.choose(is_better, of_this, square);
                steepness = s.choose(is_better, steep, steepness);
                height = s.choose(is_better, s.wide_load(&stand.height), height);
                place = s.choose(is_better, s.wide_splat(f64::from(*c)), place);
            }
            // Where the square is 0 the height is.
            let is_on = s.bits(s.wide_above(on * square, height * height));
            let clear = s.bits(s.wide_above(square, zero)) & !is_on;
            let below = s.bits(s.wide_above(zero, height));
            let mut places = Wide::default();
            s.wide_store(place, &mut places);
            let mut cuts = [NONE; 3];
            for k in 0..3 {
                cuts[k] = places[3 * self.w + k] as u32;
            }
            // Without a cut the square is infinite and the height 0.
            self.out.push(Judged { cuts, clear: clear >> (3 * self.w) & 7, below: below >> (3 * self.w) & 7 });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bounds::Point;
    use crate::contacts::shapes::{box_mesh, ridge};
    use crate::contacts::tests::{at, scene, tool};
    use crate::contacts::zones::{find, ZonesScratch};
    use crate::narrow::Filters;
    use crate::simd::Level;
    use crate::vectors::{along, cross};

    /// Square of the distance of a corner from its cut, and how steeply it stands off the cut's line.
    fn stand(zones: &Zones, w: usize, cut: u32, k: usize) -> (f64, f64) {
        let ([a, b], corner) = (zones.ends(cut), zones.face(w, cut).corners[k]);
        let (line, from): (Point, Point) = (sub(&b, &a), sub(&corner, &a));
        let lengths = dot(&line, &line);
        let (off, steep) = if lengths > 0.0 {
            let share = (dot(&from, &line) / lengths).clamp(0.0, 1.0);
            let across = cross(&from, &line);
            (along(&from, -share, &line), dot(&across, &across) / lengths)
        } else {
            (from, dot(&from, &zones.face(1 - w, cut).normal).powi(2))
        };
        let square = dot(&off, &off);
        (square, if square > 0.0 { steep / square } else { 0.0 })
    }

    /// The nearest cut, one after the other, and whether the corner is off the plane of its other face and under it.
    fn plainly_nearest(zones: &Zones, w: usize, same: &[u32], k: usize) -> (u32, bool, bool) {
        let (mut best, mut steepest, mut place) = (f64::INFINITY, 0.0, NONE);
        for c in same.iter().filter(|c| !zones.cuts[**c as usize].flat) {
            let (square, steep) = stand(zones, w, *c, k);
            let is_level = place != NONE && square >= best * (1.0 - 1e-9) && square <= best * (1.0 + 1e-9);
            if if is_level { steep > steepest } else { square < best } {
                (best, steepest, place) = (square, steep, *c);
            }
        }
        if place == NONE {
            return (NONE, false, false);
        }
        let corner = zones.face(w, place).corners[k];
        let height = dot(&sub(&corner, &zones.ends(place)[0]), &zones.face(1 - w, place).normal);
        (place, !(best == 0.0 || height * height < 1e-18 * best), height < 0.0)
    }

    #[test]
    fn the_nearest_cuts_are_those_a_loop_finds() {
        let line = [[-0.03, 0.0], [-0.02, 0.0], [0.0, 0.02], [0.02, 0.0], [0.03, 0.0]];
        let (block, frame) =
            (scene(box_mesh([0.0, 0.0, 0.015], [0.01, 0.012, 0.014], 4)), tool(ridge(&line, 0.04, 0.02, 3, 5)));
        let mut counts = [0; 2];
        for pose in [at(0.0, 0.0, 0.0), at(0.0037, 0.0021, -0.0013), at(0.01, 0.0, 0.002)] {
            let pairs = block.collide(&frame, &pose, Filters::default()).pairs;
            let ground = Ground::new(&block, &frame, &pose, None);
            let mut scratch = ZonesScratch::default();
            let zones = find(&ground, &pairs, None, &mut scratch);
            for level in Level::available() {
                let (mut stands, mut nearest) = (Vec::new(), Vec::new());
                level.checked().run(Stands { zones, out: &mut stands });
                for w in [TOOL, MOCKUP] {
                    level.checked().run(Nearest { zones, w, stands: &stands, out: &mut nearest });
                    assert_eq!(nearest.len(), zones.faces[w].len());
                    for (same, found) in zones.by_face(w).zip(&nearest) {
                        for k in 0..3 {
                            let bit = |bits: u8| bits >> k & 1 != 0;
                            let corner = (found.cuts[k], bit(found.clear), bit(found.below));
                            assert_eq!(corner, plainly_nearest(zones, w, same, k), "{level:?} {w}");
                        }
                        counts[usize::from(same.len() > 1)] += 1;
                    }
                }
            }
        }
        assert!(counts.iter().all(|count| *count > 20), "{counts:?}");
    }
}
