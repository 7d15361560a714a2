//! Blocked axes: along them a surface continues beyond the contour, higher than its support within the region.
//!
//! A rod in a plate is not freed sideways by its own width, because there is more plate. The supports of a body cover
//! only the part inside the contour; if the highest point lies on the contour and the surface rises beyond it, the
//! support along that axis does not show how far the surface reaches, and the axis does not count. Blockers are kept
//! for each body, since one that blocks an axis mostly blocks others too.

use crate::constants::{BLOCKING_RISE, BLOCKING_SHARE, BLOCKING_SINE};
use crate::contour::contact_region::{ContactRegions, Face, Segment};
use crate::depth::axis::{BodyPair, TriedAxis};
use crate::patch::support::{eight_heights, places_above, Eight};
use crate::surface::Surface;
use feeler_core::geometry::bounds::Point;
use feeler_core::geometry::vectors::{dot, scaled};
use feeler_lanes::{Checked, Kernel, Simd, Wide, WIDE_LANES};

/// A point of the contour with a segment there, seen from one of the two surfaces.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Blocker {
    at: Point,
    /// Of the surface's own face, of the other's, and the cosine between them.
    normal: Point,
    other: Point,
    cosine: f64,
    face: u32,
}

impl Blocker {
    /// `None` where the other surface does not face along `d`: there this one ends at the contour.
    pub fn at_segment(
        regions: &ContactRegions,
        surface: Surface,
        segment: &Segment,
        at: Point,
        d: &Point,
    ) -> Option<Blocker> {
        let other = regions.faces[surface.other()][segment.faces[surface.other()] as usize].normal;
        if segment.flat || dot(&other, d) <= BLOCKING_SINE {
            return None;
        }
        let normal = regions.faces[surface][segment.faces[surface] as usize].normal;
        Some(Blocker { at, normal, other, cosine: dot(&other, &normal), face: segment.faces[surface] })
    }

    /// Whether the surface continues along `d` to higher than `top` on the outer side of the other. An edge across `d` does
    /// not rise.
    pub fn is_blocking(&self, faces: &[Face], d: &Point, top: f64) -> bool {
        let facing = dot(&self.other, d);
        // The other's normal less its part along the own normal: in the surface, away from the contour.
        let rising = facing - self.cosine * dot(&self.normal, d);
        facing > BLOCKING_SINE && rising > BLOCKING_SINE && reaches_above(&faces[self.face as usize], d, top)
    }
}

#[inline(always)]
fn reaches_above(face: &Face, d: &Point, top: f64) -> bool {
    let [a, b, c] = &face.corners;
    dot(a, d).max(dot(b, d)).max(dot(c, d)) > top
}

/// The last eight blockers of a body.
#[derive(Debug, Default)]
pub(crate) struct KnownBlockers {
    at: Eight,
    normal: Eight,
    other: Eight,
    cosine: Wide,
    faces: [u32; WIDE_LANES],
    count: usize,
}

impl KnownBlockers {
    pub fn clear(&mut self) {
        self.count = 0;
    }

    pub fn push(&mut self, blocker: &Blocker) {
        let i = self.count % WIDE_LANES;
        for a in 0..3 {
            (self.at[a][i], self.normal[a][i], self.other[a][i]) = (blocker.at[a], blocker.normal[a], blocker.other[a]);
        }
        (self.cosine[i], self.faces[i]) = (blocker.cosine, blocker.face);
        self.count += 1;
    }

    /// Whether one of them that is at least as high as `height` blocks `d`.
    pub fn is_blocking(&self, lanes: Checked, faces: &[Face], d: &Point, height: f64, top: f64) -> bool {
        self.count > 0 && lanes.run(AnyBlocking { known: self, faces, d, height, top })
    }
}

/// The blockers found in a region, by body. Working memory.
#[derive(Debug, Default)]
pub(crate) struct BlockedAxes {
    /// By body of tool and mock-up.
    pub known: [Vec<KnownBlockers>; 2],
    /// Indices of extreme points.
    pub extreme: Vec<u32>,
}

impl BlockedAxes {
    /// For another region, with its numbers of bodies of tool and mock-up.
    pub fn clear(&mut self, bodies: [usize; 2]) {
        for (known, count) in self.known.iter_mut().zip(bodies) {
            known.resize_with(count.max(known.len()), KnownBlockers::default);
            known[..count].iter_mut().for_each(KnownBlockers::clear);
        }
    }

    /// Whether one of the surfaces asked blocks an axis.
    pub fn is_blocked_by(&mut self, surfaces: &[Surface], pair: &BodyPair<'_>, noise: f64, tried: &TriedAxis) -> bool {
        let TriedAxis { direction: d, high, low } = tried;
        let BodyPair { lanes, regions, tool, mockup } = pair;
        let numbers = [tool.number, mockup.number];
        let tolerance = noise + BLOCKING_SHARE * (high - low).abs();
        let ends = [(scaled(d, -1.0), -low - tolerance), (*d, high - tolerance)];
        for surface in surfaces.iter().copied() {
            let ((d, height), known) = (&ends[surface], &self.known[surface][numbers[surface]]);
            if known.is_blocking(*lanes, &regions.faces[surface], d, *height, *height + BLOCKING_RISE * tolerance) {
                return true;
            }
        }
        for surface in surfaces.iter().copied() {
            let ((d, height), body) = (&ends[surface], [tool, mockup][surface]);
            let BlockedAxes { extreme, known } = &mut *self;
            let last = body.points.len().saturating_sub(1);
            for i in places_above(*lanes, body.point_eights, d, *height, extreme).iter().map(|i| last.min(*i as usize))
            {
                for source in &body.point_segments[body.segments_of[i].0 as usize..body.segments_of[i].1 as usize] {
                    let segment = &regions.segments[*source as usize];
                    let Some(blocker) = Blocker::at_segment(regions, surface, segment, body.points[i], d) else {
                        continue;
                    };
                    if blocker.is_blocking(&regions.faces[surface], d, *height + BLOCKING_RISE * tolerance) {
                        known[surface][numbers[surface]].push(&blocker);
                        return true;
                    }
                }
            }
        }
        false
    }
}

/// [`Blocker::is_blocking`] for the eight known at once.
struct AnyBlocking<'a> {
    known: &'a KnownBlockers,
    faces: &'a [Face],
    d: &'a Point,
    height: f64,
    top: f64,
}

impl Kernel for AnyBlocking<'_> {
    type Output = bool;

    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> bool {
        let KnownBlockers { at, normal, other, cosine, faces, count } = self.known;
        let d = [s.wide_splat(self.d[0]), s.wide_splat(self.d[1]), s.wide_splat(self.d[2])];
        let facing = eight_heights(s, other, &d);
        let rising = facing - s.wide_load(cosine) * eight_heights(s, normal, &d);
        let least = s.wide_splat(BLOCKING_SINE);
        let is_below = s.wide_above(s.wide_splat(self.height), eight_heights(s, at, &d));
        let on = s.both(s.wide_above(facing, least), s.wide_above(rising, least));
        let mut on = s.bits(on) & !s.bits(is_below) & u8::MAX >> (WIDE_LANES - count.min(&WIDE_LANES));
        while on != 0 {
            if reaches_above(&self.faces[faces[on.trailing_zeros() as usize] as usize], self.d, self.top) {
                return true;
            }
            on &= on - 1;
        }
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use feeler_core::geometry::vectors::{normal, unit};
    use feeler_lanes::Level;

    #[test]
    fn known_blockers_block_what_one_of_the_last_eight_blocks() {
        let wave = |i: usize| [(0.7 * i as f64).sin(), (1.9 * i as f64).cos(), (1.3 * i as f64).sin()];
        let face = |i: usize| {
            let corners = [wave(i), wave(i + 1), wave(i + 2)];
            Face { normal: normal(&corners).unwrap(), ..Face::new(0, corners, true) }
        };
        let faces: Vec<Face> = (0..7).map(face).collect();
        let blocker = |i: usize| {
            let (normal, other) = (unit(&wave(3 * i + 50)).unwrap(), unit(&wave(5 * i + 90)).unwrap());
            Blocker { at: wave(i + 20), normal, other, cosine: dot(&other, &normal), face: i as u32 % 7 }
        };
        for level in Level::available() {
            let mut known = KnownBlockers::default();
            let mut counts = [0; 2];
            for i in 0..21 {
                for d in (0..20).map(|k| unit(&wave(k + 7)).unwrap()) {
                    let (height, top) = (0.5, 0.7);
                    let of = i.max(WIDE_LANES) - WIDE_LANES..i;
                    let is_blocking = |b: Blocker| dot(&b.at, &d) >= height && b.is_blocking(&faces, &d, top);
                    let expected = of.map(blocker).any(is_blocking);
                    assert_eq!(known.is_blocking(level.checked(), &faces, &d, height, top), expected, "{level:?} {i}");
                    counts[usize::from(expected)] += 1;
                }
                known.push(&blocker(i));
            }
            assert!(counts.iter().all(|count| *count > 50), "{counts:?}");
            known.clear();
            assert!(!known.is_blocking(level.checked(), &faces, &wave(0), -9.0, -9.0));
        }
    }
}
