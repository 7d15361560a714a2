//! A filter of points by half-spaces: above and below the planes of which patches they clearly are, sixteen patches at
//! once.

use crate::constants::HOLLOW;
use crate::containers::bit_set::BitSets;
use crate::patch::surface_patch::Patch;
use feeler_core::geometry::bounds::Point;
use feeler_core::geometry::vectors::{dot, sub};
use feeler_lanes::{Checked, Kernel, Simd, LANES};

/// Sixteen float32 in one cache line.
#[derive(Debug, Clone, Copy, Default)]
#[repr(C, align(64))]
struct Lanes([f32; LANES]);

/// Planes of sixteen patches as a structure of arrays.
#[derive(Debug, Clone, Copy, Default)]
struct Sixteen {
    normal: [Lanes; 3],
    middle: [Lanes; 3],
    /// Height of the middle over the patch's plane.
    height: Lanes,
}

/// The planes of patches in float32, relative to a point among them and scaled to their size. Float32 suffices: a point
/// is clearly above a plane only from [`HOLLOW`] of its distance on, which is far above the rounding.
#[derive(Debug, Default)]
pub(crate) struct HalfSpaceFilter {
    sixteens: Vec<Sixteen>,
    origin: Point,
    scale: f64,
}

impl HalfSpaceFilter {
    pub fn set(&mut self, patches: &[Patch]) {
        self.sixteens.clear();
        self.origin = patches.first().map_or([0.0; 3], |patch| patch.middle);
        let farthest = |p: &Patch| sub(&p.middle, &self.origin).iter().fold(p.size, |m, x| m.max(x.abs()));
        let largest = patches.iter().map(farthest).fold(0.0, f64::max);
        self.scale = if largest.is_normal() { largest.recip() } else { 1.0 };
        self.sixteens.resize(patches.len().div_ceil(LANES), Sixteen::default());
        for (i, patch) in patches.iter().enumerate() {
            let middle = self.local(&patch.middle);
            let (sixteen, lane) = (&mut self.sixteens[i / LANES], i % LANES);
            for a in 0..3 {
                (sixteen.normal[a].0[lane], sixteen.middle[a].0[lane]) = (patch.normal[a] as f32, middle[a]);
            }
            sixteen.height.0[lane] = (dot(&sub(&patch.middle, &patch.at), &patch.normal) * self.scale) as f32;
        }
    }

    /// A point relative to the origin, scaled.
    fn local(&self, p: &Point) -> [f32; 3] {
        sub(p, &self.origin).map(|x| (x * self.scale) as f32)
    }

    /// Writes to the sets `above` and `below` of each point the patches above and below whose planes it clearly is:
    /// farther from the plane than [`HOLLOW`] times its distance from the patch's middle.
    pub fn classify(&self, lanes: Checked, points: &[Point], above: &mut BitSets, below: &mut BitSets) {
        lanes.run(Classify { filter: self, points, above, below });
    }
}

struct Classify<'a> {
    filter: &'a HalfSpaceFilter,
    points: &'a [Point],
    above: &'a mut BitSets,
    below: &'a mut BitSets,
}

impl Kernel for Classify<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, s: S) {
        let (share, zero) = (s.splat((HOLLOW * HOLLOW) as f32), s.splat(0.0));
        for (k, p) in self.points.iter().enumerate() {
            let p = self.filter.local(p);
            let p = [s.splat(p[0]), s.splat(p[1]), s.splat(p[2])];
            let (above, below) = (self.above.get_mut(k), self.below.get_mut(k));
            for (word, sixteens) in self.filter.sixteens.chunks(64 / LANES).enumerate() {
                let (mut is_above, mut is_below) = (0, 0);
                for (i, of) in sixteens.iter().enumerate() {
                    let mut from_middle = p;
                    for a in 0..3 {
                        from_middle[a] = p[a] - s.load(&of.middle[a].0);
                    }
                    let n = [s.load(&of.normal[0].0), s.load(&of.normal[1].0), s.load(&of.normal[2].0)];
                    let [x, y, z] = from_middle;
                    let height = x * n[0] + y * n[1] + z * n[2] + s.load(&of.height.0);
                    let square = x * x + y * y + z * z;
                    let clear = s.lanes(s.above(height * height, share * square));
                    let up = s.lanes(s.above(height, zero));
                    is_above |= u64::from(clear & up) << (LANES * i);
                    is_below |= u64::from(clear & !up) << (LANES * i);
                }
                (above[word], below[word]) = (is_above, is_below);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::containers::bit_set::has;
    use feeler_core::geometry::vectors::{add, scaled, unit};
    use feeler_lanes::Level;

    #[test]
    fn points_are_classified_as_one_by_one() {
        let wave = |i: usize| [(0.7 * i as f64).sin(), (1.9 * i as f64).cos(), (0.3 * i as f64).sin()];
        // Small and large, far from the origin.
        for (size, far) in [(1.0, [0.0; 3]), (1e-30, [0.0; 3]), (0.1, [3e3, -4e4, 1.0]), (1e30, [0.0; 3])] {
            let at = |p: Point| add(&scaled(&p, size), &far);
            let points: Vec<Point> = (0..50).map(|i| at(wave(i))).collect();
            for count in [0, 1, 15, 17, 150] {
                let patch = |i: usize| {
                    let mut patch =
                        Patch::new(unit(&wave(11 * i + 5)).unwrap(), at([0.9 + 0.01 * i as f64, 0.3, -0.2]));
                    (patch.middle, patch.size) = (at(wave(3 * i + 1)), size);
                    patch
                };
                let patches: Vec<Patch> = (0..count).map(patch).collect();
                let mut filter = HalfSpaceFilter::default();
                filter.set(&patches);
                let mut doubtful = 0;
                for level in Level::available() {
                    let (mut above, mut below) = (BitSets::default(), BitSets::default());
                    above.clear(points.len(), count);
                    below.clear(points.len(), count);
                    filter.classify(level.checked(), &points, &mut above, &mut below);
                    for (k, x) in points.iter().enumerate() {
                        for (i, p) in patches.iter().enumerate() {
                            let (from_middle, height) = (sub(x, &p.middle), dot(&sub(x, &p.at), &p.normal));
                            let square = HOLLOW * HOLLOW * dot(&from_middle, &from_middle);
                            if (height * height - square).abs() < 1e-4 * square {
                                doubtful += 1;
                                continue;
                            }
                            let clear = height * height > square;
                            let expected = (clear && height > 0.0, clear && height <= 0.0);
                            assert_eq!((has(above.get(k), i), has(below.get(k), i)), expected, "{level:?} {k} {i}");
                        }
                    }
                }
                assert!(doubtful <= 3, "{doubtful}");
            }
        }
    }
}
