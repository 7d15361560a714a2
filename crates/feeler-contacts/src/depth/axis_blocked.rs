//! Where surfaces go on beyond the curve, kept for each body: where one did along a direction, it mostly does along others.

use crate::contour::contact_region::{ContactRegions, Face, Segment};
use crate::depth::axis::{BodyPair, TriedAxis};
use crate::patch::support::{eight_heights, places_above, Eight};
use crate::surface::Surface;
use feeler_core::geometry::bounds::Point;
use feeler_core::geometry::vectors::{dot, scaled};
use feeler_lanes::{Checked, Kernel, Simd, Wide, WIDE_LANES};

/// Sine from which on a surface goes on along a direction.
const GOES_ON: f64 = 0.05;

/// A point of the curve and a cut there, as one of the two surfaces is seen.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Blocker {
    at: Point,
    /// Of its face, of the other's, and the cosine between them.
    normal: Point,
    other: Point,
    cosine: f64,
    face: u32,
}

impl Blocker {
    /// At a cut where the other advances along `d`; nothing goes on elsewhere.
    pub fn advancing(
        regions: &ContactRegions,
        surface: Surface,
        segment: &Segment,
        at: Point,
        d: &Point,
    ) -> Option<Blocker> {
        let other = regions.faces[surface.other()][segment.faces[surface.other()] as usize].normal;
        if segment.flat || dot(&other, d) <= GOES_ON {
            return None;
        }
        let normal = regions.faces[surface][segment.faces[surface] as usize].normal;
        Some(Blocker { at, normal, other, cosine: dot(&other, &normal), face: segment.faces[surface] })
    }

    /// Whether, in the sense in which the other advances over it, the surface goes on along `d` to higher than `top`. An edge
    /// that lies across `d` goes on no higher.
    pub fn goes_on(&self, faces: &[Face], d: &Point, top: f64) -> bool {
        let advances = dot(&self.other, d);
        let leaves = advances - self.cosine * dot(&self.normal, d);
        advances > GOES_ON && leaves > GOES_ON && rises(&faces[self.face as usize], d, top)
    }
}

#[inline(always)]
fn rises(face: &Face, d: &Point, top: f64) -> bool {
    let [a, b, c] = &face.corners;
    dot(a, d).max(dot(b, d)).max(dot(c, d)) > top
}

/// The last eight of a body.
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

    pub fn push(&mut self, onward: &Blocker) {
        let i = self.count % WIDE_LANES;
        for a in 0..3 {
            (self.at[a][i], self.normal[a][i], self.other[a][i]) = (onward.at[a], onward.normal[a], onward.other[a]);
        }
        (self.cosine[i], self.faces[i]) = (onward.cosine, onward.face);
        self.count += 1;
    }

    /// Whether the surface goes on at one of them that is as high as `height`.
    pub fn goes_on(&self, lanes: Checked, faces: &[Face], d: &Point, height: f64, top: f64) -> bool {
        self.count > 0 && lanes.run(GoesOn { known: self, faces, d, height, top })
    }
}

/// Where surfaces went on along axes tried, by body. Working memory.
#[derive(Debug, Default)]
pub(crate) struct BlockedAxes {
    /// By body of tool and mock-up: there the surface mostly goes on along other axes too.
    pub known: [Vec<KnownBlockers>; 2],
    /// FaceNumbers of extreme points.
    pub places: Vec<u32>,
}

impl BlockedAxes {
    /// For the bodies of another zone, so many of the tool and of the mock-up.
    pub fn clear(&mut self, bodies: [usize; 2]) {
        for (known, count) in self.known.iter_mut().zip(bodies) {
            known.resize_with(count.max(known.len()), KnownBlockers::default);
            known[..count].iter_mut().for_each(KnownBlockers::clear);
        }
    }

    /// Whether one of the surfaces goes on beyond the curve just where, along `d`, it would have to end: a rod in a plate is not
    /// freed sideways by its own width, for there is more plate. Asked of the surfaces in `sides`.
    pub fn goes_on_of(&mut self, pair: &BodyPair<'_>, noise: f64, sides: &[Surface], tried: &TriedAxis) -> bool {
        let TriedAxis { direction: d, high, low } = tried;
        let BodyPair { lanes, regions, tool, mockup } = pair;
        let numbers = [tool.number, mockup.number];
        let tolerance = noise + 1e-6 * (high - low).abs();
        let ends = [(scaled(d, -1.0), -low - tolerance), (*d, high - tolerance)];
        for surface in sides.iter().copied() {
            let ((d, height), known) = (&ends[surface], &self.known[surface][numbers[surface]]);
            if known.goes_on(*lanes, &regions.faces[surface], d, *height, *height + 3.0 * tolerance) {
                return true;
            }
        }
        for surface in sides.iter().copied() {
            let ((d, height), body) = (&ends[surface], [tool, mockup][surface]);
            let BlockedAxes { places, known } = &mut *self;
            let last = body.points.len().saturating_sub(1);
            for i in places_above(*lanes, body.point_eights, d, *height, places).iter().map(|i| last.min(*i as usize)) {
                for source in &body.point_segments[body.segments_of[i].0 as usize..body.segments_of[i].1 as usize] {
                    let segment = &regions.segments[*source as usize];
                    let Some(onward) = Blocker::advancing(regions, surface, segment, body.points[i], d) else {
                        continue;
                    };
                    if onward.goes_on(&regions.faces[surface], d, *height + 3.0 * tolerance) {
                        known[surface][numbers[surface]].push(&onward);
                        return true;
                    }
                }
            }
        }
        false
    }
}

struct GoesOn<'a> {
    known: &'a KnownBlockers,
    faces: &'a [Face],
    d: &'a Point,
    height: f64,
    top: f64,
}

impl Kernel for GoesOn<'_> {
    type Output = bool;

    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> bool {
        let KnownBlockers { at, normal, other, cosine, faces, count } = self.known;
        let d = [s.wide_splat(self.d[0]), s.wide_splat(self.d[1]), s.wide_splat(self.d[2])];
        let advances = eight_heights(s, other, &d);
        let leaves = advances - s.wide_load(cosine) * eight_heights(s, normal, &d);
        let least = s.wide_splat(GOES_ON);
        let is_below = s.wide_above(s.wide_splat(self.height), eight_heights(s, at, &d));
        let on = s.both(s.wide_above(advances, least), s.wide_above(leaves, least));
        let mut on = s.bits(on) & !s.bits(is_below) & u8::MAX >> (WIDE_LANES - count.min(&WIDE_LANES));
        while on != 0 {
            if rises(&self.faces[faces[on.trailing_zeros() as usize] as usize], self.d, self.top) {
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
    fn the_last_eight_say_what_each_says() {
        let wave = |i: usize| [(0.7 * i as f64).sin(), (1.9 * i as f64).cos(), (1.3 * i as f64).sin()];
        let face = |i: usize| {
            let corners = [wave(i), wave(i + 1), wave(i + 2)];
            Face { normal: normal(&corners).unwrap(), ..Face::new(0, corners, true) }
        };
        let faces: Vec<Face> = (0..7).map(face).collect();
        let onward = |i: usize| {
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
                    let is_on = |o: Blocker| dot(&o.at, &d) >= height && o.goes_on(&faces, &d, top);
                    let expected = of.map(onward).any(is_on);
                    assert_eq!(known.goes_on(level.checked(), &faces, &d, height, top), expected, "{level:?} {i}");
                    counts[usize::from(expected)] += 1;
                }
                known.push(&onward(i));
            }
            assert!(counts.iter().all(|count| *count > 50), "{counts:?}");
            known.clear();
            assert!(!known.goes_on(level.checked(), &faces, &wave(0), -9.0, -9.0));
        }
    }
}
