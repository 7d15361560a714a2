//! Sides of vertices: inside, on or outside the other surface, for the corners of triangles that collide with it.
//!
//! The sign of a distance is that of the height over the nearest feature, which is ambiguous if that is an edge or a
//! vertex (Baerentzen and Aanaes: *Signed distance computation using the angle weighted pseudonormal*, 2005). Here the
//! features are the segments of the corner's own triangle, and no pseudonormals are needed: the line from a corner to
//! the nearest of its segments crosses no other, so the height over that segment's face gives the side.

use crate::constants::{EQUAL_SHARE, ON_PLANE_SHARE};
use crate::context::QueryContext;
use crate::contour::contact_region::ContactRegions;
use crate::contour::vertex_side_degenerate::resolve_side;
use crate::surface::{Side, Surface};
use feeler_core::constants::NONE;
use feeler_core::constants::WELD_SHARE;
use feeler_core::geometry::vectors::{dot, sub};
use feeler_lanes::{Kernel, Simd, Wide};

/// Finds the side of each corner by its nearest segment. Of two that are equally near, at an edge of the other surface, the one counts
/// whose line the corner stands off most steeply, in the plane of the triangle: the two lines are a bend of the contour, and the
/// corner is on its outer side. Where that is ambiguous [`resolve_side`] decides. Outside the other solid's box a corner is outside in
/// any case: where the contour has a gap, the nearest segment may be missing.
pub(crate) fn classify_vertices(
    context: &QueryContext<'_>,
    part: u32,
    regions: &mut ContactRegions,
    offsets: &mut Vec<LineOffsets>,
    nearest: &mut Vec<NearestSegments>,
) {
    context.lanes.run(MeasureOffsets { regions, out: offsets });
    for surface in Surface::BOTH {
        context.lanes.run(FindNearest { regions, surface, offsets, out: nearest });
        for (face, corners) in nearest.iter_mut().enumerate().filter(|(_, corners)| corners.doubt != 0) {
            for k in (0..3).filter(|k| corners.doubt >> k & 1 != 0) {
                if let Some(evidence) = resolve_side(regions, surface, face, k) {
                    let set = |bits: &mut u8, on: bool| *bits = *bits & !(1 << k) | u8::from(on) << k;
                    corners.segments[k] = evidence.segment;
                    set(&mut corners.off, !evidence.is_on());
                    set(&mut corners.below, evidence.height < 0.0);
                }
            }
        }
        let enclosure = context.enclosure(surface.other(), part);
        for (i, corners) in nearest.iter().enumerate() {
            let ContactRegions { faces, segments, assumed_axis, .. } = &mut *regions;
            let [of_tool, of_mockup] = faces;
            let (face, others) =
                if surface == Surface::Tool { (&mut of_tool[i], &*of_mockup) } else { (&mut of_mockup[i], &*of_tool) };
            face.nearest = corners.segments;
            for k in 0..3 {
                let (is_off, is_below) = (corners.off >> k & 1, corners.below >> k & 1);
                face.side[k] = match (is_off, is_below) {
                    (0, _) => Side::On,
                    (_, 0) => Side::Outside,
                    _ => Side::Inside,
                };
            }
            let mut inside = corners.off & corners.below;
            while inside != 0 {
                let k = inside.trailing_zeros() as usize;
                inside &= inside - 1;
                let segment = &segments[corners.segments[k] as usize];
                let is_closed = others[segment.faces[surface.other()] as usize].closed
                    && (surface == Surface::Mockup || assumed_axis.is_none());
                if is_closed && !context.is_enclosed(surface.other(), &enclosure, &face.corners[k]) {
                    face.side[k] = Side::Outside;
                }
            }
        }
    }
}

/// The corners of a segment's two faces relative to the segment, the tool's face first; the last two lanes are unused.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct LineOffsets {
    /// Squares of the distances from the segment, square metres.
    square: Wide,
    /// Squares of the sines between the segment's line and the way from its nearest point to the corner, which is in the plane of the
    /// corner's own face; 0 for a segment without length.
    steepness: Wide,
    /// Heights over the plane of the other face, metres.
    height: Wide,
}

/// The nearest segments of the three corners of a face, and the sides that they imply, one bit a corner.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct NearestSegments {
    /// [`NONE`] where there is none.
    segments: [u32; 3],
    /// Off the plane of the other face, and below it.
    off: u8,
    below: u8,
    /// Ambiguous: a segment tells nothing, or two are equal.
    doubt: u8,
}

/// Measures the corners relative to all segments.
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
        let least =
            ON_PLANE_SHARE / WELD_SHARE * self.regions.thin[Surface::Tool].max(self.regions.thin[Surface::Mockup]);
        for i in 0..self.regions.segments.len() as u32 {
            let (tool, mockup) = (self.regions.face(Surface::Tool, i), self.regions.face(Surface::Mockup, i));
            let (outward, _) =
                self.regions.outward(Surface::Mockup, self.regions.segments[i as usize].faces[Surface::Mockup]);
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
            let mut offsets = LineOffsets::default();
            s.wide_store(square, &mut offsets.square);
            s.wide_store(steepness, &mut offsets.steepness);
            s.wide_store(height, &mut offsets.height);
            self.out.push(offsets);
        }
    }
}

/// Finds, for each face of one surface, the segments that decide the sides of its corners, and these sides.
struct FindNearest<'a> {
    regions: &'a ContactRegions,
    surface: Surface,
    offsets: &'a [LineOffsets],
    out: &'a mut Vec<NearestSegments>,
}

impl Kernel for FindNearest<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, s: S) {
        self.out.clear();
        let (zero, on) = (s.wide_splat(0.0), s.wide_splat(ON_PLANE_SHARE * ON_PLANE_SHARE));
        let (less, more) = (s.wide_splat(1.0 - EQUAL_SHARE), s.wide_splat(1.0 + EQUAL_SHARE));
        for same in self.regions.by_face(self.surface) {
            let mut square = s.wide_splat(f64::INFINITY);
            let (mut steepness, mut height) = (zero, zero);
            let mut nearest = s.wide_splat(f64::from(NONE));
            let (mut least, mut is_unique) = (s.wide_splat(f64::INFINITY), s.wide_above(s.wide_splat(1.0), zero));
            for segment in same {
                if self.regions.segments[*segment as usize].flat {
                    continue;
                }
                let offsets = &self.offsets[*segment as usize];
                let (of_this, steep) = (s.wide_load(&offsets.square), s.wide_load(&offsets.steepness));
                // The nearer one; of two equally near the steeper.
                let differs = s.either(s.wide_above(square * less, of_this), s.wide_above(of_this, square * more));
                let (is_nearer, is_steeper) = (s.wide_above(square, of_this), s.wide_above(steep, steepness * more));
                let differs_in_slope = s.either(is_steeper, s.wide_above(steepness * less, steep));
                is_unique = s.both(is_unique, s.either(differs, differs_in_slope));
                least = s.wide_min(least, steep);
                let as_near = s.differing(is_steeper, s.both(is_steeper, differs));
                let is_better = s.either(s.both(is_nearer, differs), as_near);
                square = s.choose(is_better, of_this, square);
                steepness = s.choose(is_better, steep, steepness);
                height = s.choose(is_better, s.wide_load(&offsets.height), height);
                nearest = s.choose(is_better, s.wide_splat(f64::from(*segment)), nearest);
            }
            // A corner at distance 0 is on the plane, though `is_on` is false of 0 and 0.
            let is_on = s.bits(s.wide_above(on * square, height * height));
            let off = s.bits(s.wide_above(square, zero)) & !is_on;
            let below = s.bits(s.wide_above(zero, height));
            let mut of_lane = Wide::default();
            s.wide_store(nearest, &mut of_lane);
            let mut segments = [NONE; 3];
            for k in 0..3 {
                segments[k] = of_lane[3 * self.surface as usize + k] as u32;
            }
            let of_face = |bits: u8| bits >> (3 * self.surface as usize) & 7;
            let doubt = !s.bits(s.both(is_unique, s.wide_above(least, on)));
            // Without a segment the square is infinite and the height 0, so the corner is on the plane.
            self.out.push(NearestSegments {
                segments,
                off: of_face(off),
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
    use crate::contour::vertex_side_degenerate::best_evidence;
    use crate::tests::{at, scene, tool};
    use feeler_lanes::Level;
    use feeler_shapes::{box_mesh, ridge};

    #[test]
    fn the_nearest_segments_are_those_a_loop_finds() {
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
                let (mut offsets, mut nearest) = (Vec::new(), Vec::new());
                level.checked().run(MeasureOffsets { regions, out: &mut offsets });
                for surface in Surface::BOTH {
                    level.checked().run(FindNearest { regions, surface, offsets: &offsets, out: &mut nearest });
                    assert_eq!(nearest.len(), regions.faces[surface].len());
                    for (same, found) in regions.by_face(surface).zip(&nearest) {
                        for k in 0..3 {
                            let bit = |bits: u8| bits >> k & 1 != 0;
                            let corner = (found.segments[k], bit(found.off), bit(found.below));
                            if bit(found.doubt) {
                                counts[2] += 1;
                                continue;
                            }
                            let plain = best_evidence(regions, surface, same, k).map_or(
                                (NONE, false, false),
                                |(best, is_contradicted)| {
                                    assert!(!is_contradicted);
                                    (best.segment, !best.is_on(), best.height < 0.0)
                                },
                            );
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
