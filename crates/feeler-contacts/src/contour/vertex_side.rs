//! On which side of the other surface the corners of cut triangles are.

use crate::context::QueryContext;
use crate::contour::contact_region::ContactRegions;
use crate::contour::vertex_side_degenerate::{judge, LEVEL, ON};
use crate::surface::{Side, Surface};
use feeler_core::constants::NONE;
use feeler_core::constants::WELD_SHARE;
use feeler_core::geometry::vectors::{dot, sub};
use feeler_lanes::{Kernel, Simd, Wide};

/// The nearest cut tells on which side a corner is: the way to it crosses no other. Where two are equally near, at an edge of the
/// other surface, the one whose line the corner stands off most steeply, in the plane of the triangle: there the two lines are a
/// bend of the curve, and the corner is on the outer side of it. Where that tells nothing, [`judge`] does. Outside the other
/// solid's box a corner is outside: where the curve has a gap, its nearest cut may be missing.
pub(crate) fn classify_vertices(
    context: &QueryContext<'_>,
    part: u32,
    regions: &mut ContactRegions,
    stands: &mut Vec<LineOffsets>,
    judged: &mut Vec<NearestSegments>,
) {
    context.lanes.run(MeasureOffsets { regions, out: stands });
    for surface in Surface::BOTH {
        context.lanes.run(Nearest { regions, surface, stands, out: judged });
        for (face, corners) in judged.iter_mut().enumerate().filter(|(_, corners)| corners.doubt != 0) {
            for k in (0..3).filter(|k| corners.doubt >> k & 1 != 0) {
                if let Some(verdict) = judge(regions, surface, face, k) {
                    let set = |bits: &mut u8, on: bool| *bits = *bits & !(1 << k) | u8::from(on) << k;
                    corners.segments[k] = verdict.segment;
                    set(&mut corners.clear, !verdict.is_on());
                    set(&mut corners.below, verdict.height < 0.0);
                }
            }
        }
        let enclosure = context.enclosure(surface.other(), part);
        for (i, corners) in judged.iter().enumerate() {
            let ContactRegions { faces, segments, way, .. } = &mut *regions;
            let [of_tool, of_mockup] = faces;
            let (face, others) =
                if surface == Surface::Tool { (&mut of_tool[i], &*of_mockup) } else { (&mut of_mockup[i], &*of_tool) };
            face.nearest = corners.segments;
            for k in 0..3 {
                let (is_clear, is_below) = (corners.clear >> k & 1, corners.below >> k & 1);
                face.side[k] = match (is_clear, is_below) {
                    (0, _) => Side::On,
                    (_, 0) => Side::Outside,
                    _ => Side::Inside,
                };
            }
            let mut inside = corners.clear & corners.below;
            while inside != 0 {
                let k = inside.trailing_zeros() as usize;
                inside &= inside - 1;
                let segment = &segments[corners.segments[k] as usize];
                let is_closed = others[segment.faces[surface.other()] as usize].closed
                    && (surface == Surface::Mockup || way.is_none());
                if is_closed && !context.is_enclosed(surface.other(), &enclosure, &face.corners[k]) {
                    face.side[k] = Side::Outside;
                }
            }
        }
    }
}

/// How the corners of a cut's two faces stand to the line of the cut, the tool's first; the last two lanes say nothing.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct LineOffsets {
    /// Squares of their distances.
    square: Wide,
    /// How steeply they stand off it, each in the plane of its own face: that of the other may be met at any angle. 0 off points.
    steepness: Wide,
    /// How high they are over the plane of the other face.
    height: Wide,
}

/// What the nearest cuts say about the corners of a face, one bit a corner.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct NearestSegments {
    /// Their places among the cuts; [`NONE`] where there is none.
    segments: [u32; 3],
    /// Off the plane of the other face, and under it.
    clear: u8,
    below: u8,
    /// Where a cut tells nothing, or two as much.
    doubt: u8,
}

/// Finds how the corners stand to all cuts.
struct MeasureOffsets<'a> {
    regions: &'a ContactRegions,
    out: &'a mut Vec<LineOffsets>,
}

impl Kernel for MeasureOffsets<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, s: S) {
        self.out.clear();
        let zero = s.wide_splat(0.0);
        let is_of_tool = s.wide_above(s.wide_splat(2.5), s.wide_load(&[0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]));
        let least = ON / WELD_SHARE * self.regions.thin[Surface::Tool].max(self.regions.thin[Surface::Mockup]);
        for i in 0..self.regions.segments.len() as u32 {
            let (tool, mockup) = (self.regions.face(Surface::Tool, i), self.regions.face(Surface::Mockup, i));
            let (outward, _) =
                self.regions.side_of(Surface::Mockup, self.regions.segments[i as usize].faces[Surface::Mockup]);
            let (p, q) = (&tool.corners, &mockup.corners);
            let corners = s.wide_points([&p[0], &p[1], &p[2], &q[0], &q[1], &q[2], &q[2], &q[2]]);
            let [a, b] = self.regions.ends(i);
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
            let steep = if lengths > least * least {
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
                zero
            };
            let square = off[0] * off[0] + off[1] * off[1] + off[2] * off[2];
            let steepness = s.choose(s.wide_above(square, zero), s.wide_divide(steep, square), zero);
            let mut stand = LineOffsets::default();
            s.wide_store(square, &mut stand.square);
            s.wide_store(steepness, &mut stand.steepness);
            s.wide_store(height, &mut stand.height);
            self.out.push(stand);
        }
    }
}

/// Finds, for each face of one surface and each of its corners, the cut that tells on which side that is, and what it says.
struct Nearest<'a> {
    regions: &'a ContactRegions,
    surface: Surface,
    stands: &'a [LineOffsets],
    out: &'a mut Vec<NearestSegments>,
}

impl Kernel for Nearest<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, s: S) {
        self.out.clear();
        let (zero, on) = (s.wide_splat(0.0), s.wide_splat(ON * ON));
        let (less, more) = (s.wide_splat(1.0 - LEVEL), s.wide_splat(1.0 + LEVEL));
        for same in self.regions.by_face(self.surface) {
            let mut square = s.wide_splat(f64::INFINITY);
            let (mut steepness, mut height) = (zero, zero);
            let mut place = s.wide_splat(f64::from(NONE));
            let (mut least, mut is_told) = (s.wide_splat(f64::INFINITY), s.wide_above(s.wide_splat(1.0), zero));
            for c in same {
                if self.regions.segments[*c as usize].flat {
                    continue;
                }
                let stand = &self.stands[*c as usize];
                let (of_this, steep) = (s.wide_load(&stand.square), s.wide_load(&stand.steepness));
                // The nearer one; of two as near the steeper.
                let differs = s.either(s.wide_above(square * less, of_this), s.wide_above(of_this, square * more));
                let (is_nearer, is_steeper) = (s.wide_above(square, of_this), s.wide_above(steep, steepness * more));
                let turns = s.either(is_steeper, s.wide_above(steepness * less, steep));
                is_told = s.both(is_told, s.either(differs, turns));
                least = s.wide_min(least, steep);
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
            let mut segments = [NONE; 3];
            for k in 0..3 {
                segments[k] = places[3 * self.surface as usize + k] as u32;
            }
            let of_face = |bits: u8| bits >> (3 * self.surface as usize) & 7;
            let doubt = !s.bits(s.both(is_told, s.wide_above(least, on)));
            // Without a cut the square is infinite and the height 0.
            self.out.push(NearestSegments {
                segments,
                clear: of_face(clear),
                below: of_face(below),
                doubt: of_face(doubt),
            });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contour::find::{find, RegionScratch};
    use crate::contour::vertex_side_degenerate::best_of;
    use crate::tests::{at, scene, tool};
    use feeler_lanes::Level;
    use feeler_shapes::{box_mesh, ridge};

    #[test]
    fn the_nearest_cuts_are_those_a_loop_finds() {
        let line = [[-0.03, 0.0], [-0.02, 0.0], [0.0, 0.02], [0.02, 0.0], [0.03, 0.0]];
        let (block, frame) =
            (scene(box_mesh([0.0, 0.0, 0.015], [0.01, 0.012, 0.014], 4)), tool(ridge(&line, 0.04, 0.02, 3, 5)));
        let mut counts = [0; 3];
        for pose in [at(0.0, 0.0, 0.0), at(0.0037, 0.0021, -0.0013), at(0.01, 0.0, 0.002)] {
            let pairs = block.collide(&frame, &pose).pairs;
            let context = QueryContext::new(&block, &frame, &pose, None);
            let mut scratch = RegionScratch::default();
            let regions = find(&context, &pairs, None, &mut scratch);
            for level in Level::available() {
                let (mut stands, mut nearest) = (Vec::new(), Vec::new());
                level.checked().run(MeasureOffsets { regions, out: &mut stands });
                for surface in Surface::BOTH {
                    level.checked().run(Nearest { regions, surface, stands: &stands, out: &mut nearest });
                    assert_eq!(nearest.len(), regions.faces[surface].len());
                    for (same, found) in regions.by_face(surface).zip(&nearest) {
                        for k in 0..3 {
                            let bit = |bits: u8| bits >> k & 1 != 0;
                            let corner = (found.segments[k], bit(found.clear), bit(found.below));
                            if bit(found.doubt) {
                                counts[2] += 1;
                                continue;
                            }
                            let plain =
                                best_of(regions, surface, same, k).map_or((NONE, false, false), |(best, is_torn)| {
                                    assert!(!is_torn);
                                    (best.segment, !best.is_on(), best.height < 0.0)
                                });
                            assert_eq!(corner, plain, "{level:?} {surface:?}");
                            counts[usize::from(same.len() > 1)] += 1;
                        }
                    }
                }
            }
        }
        assert!(counts.iter().all(|count| *count > 20), "{counts:?}");
    }
}
