//! Over and under the planes of which patches points clearly are, sixteen patches at once.

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

/// Sixteen patches by axis.
#[derive(Debug, Clone, Copy, Default)]
struct Sixteen {
    normal: [Lanes; 3],
    middle: [Lanes; 3],
    /// How high the middle is over the patch's plane.
    height: Lanes,
}

/// Patches by which to judge points, seen from a place among them and so large that float32 will do: what is clear is so by a
/// share of a patch's distance that is far above its rounding.
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
            let middle = self.seen(&patch.middle);
            let (sixteen, lane) = (&mut self.sixteens[i / LANES], i % LANES);
            for a in 0..3 {
                (sixteen.normal[a].0[lane], sixteen.middle[a].0[lane]) = (patch.normal[a] as f32, middle[a]);
            }
            sixteen.height.0[lane] = (dot(&sub(&patch.middle, &patch.at), &patch.normal) * self.scale) as f32;
        }
    }

    fn seen(&self, p: &Point) -> [f32; 3] {
        sub(p, &self.origin).map(|x| (x * self.scale) as f32)
    }

    /// Puts into the sets `over` and `under` of each point the patches over and under whose planes it clearly is: farther from
    /// it than a share of the distance from the patch's middle.
    pub fn judge(&self, lanes: Checked, points: &[Point], over: &mut BitSets, under: &mut BitSets) {
        lanes.run(Judging { judge: self, points, over, under });
    }
}

struct Judging<'a> {
    judge: &'a HalfSpaceFilter,
    points: &'a [Point],
    over: &'a mut BitSets,
    under: &'a mut BitSets,
}

impl Kernel for Judging<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, s: S) {
        let (share, zero) = (s.splat((HOLLOW * HOLLOW) as f32), s.splat(0.0));
        for (k, p) in self.points.iter().enumerate() {
            let p = self.judge.seen(p);
            let p = [s.splat(p[0]), s.splat(p[1]), s.splat(p[2])];
            let (over, under) = (self.over.get_mut(k), self.under.get_mut(k));
            for (word, sixteens) in self.judge.sixteens.chunks(64 / LANES).enumerate() {
                let (mut above, mut below) = (0, 0);
                for (i, of) in sixteens.iter().enumerate() {
                    let mut way = p;
                    for a in 0..3 {
                        way[a] = p[a] - s.load(&of.middle[a].0);
                    }
                    let n = [s.load(&of.normal[0].0), s.load(&of.normal[1].0), s.load(&of.normal[2].0)];
                    let height = way[0] * n[0] + way[1] * n[1] + way[2] * n[2] + s.load(&of.height.0);
                    let square = way[0] * way[0] + way[1] * way[1] + way[2] * way[2];
                    let clear = s.lanes(s.above(height * height, share * square));
                    let up = s.lanes(s.above(height, zero));
                    above |= u64::from(clear & up) << (LANES * i);
                    below |= u64::from(clear & !up) << (LANES * i);
                }
                (over[word], under[word]) = (above, below);
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
    fn points_are_judged_as_one_by_one() {
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
                let mut judge = HalfSpaceFilter::default();
                judge.set(&patches);
                let mut doubtful = 0;
                for level in Level::available() {
                    let (mut over, mut under) = (BitSets::default(), BitSets::default());
                    over.clear(points.len(), count);
                    under.clear(points.len(), count);
                    judge.judge(level.checked(), &points, &mut over, &mut under);
                    for (k, x) in points.iter().enumerate() {
                        for (i, p) in patches.iter().enumerate() {
                            let (way, height) = (sub(x, &p.middle), dot(&sub(x, &p.at), &p.normal));
                            let square = HOLLOW * HOLLOW * dot(&way, &way);
                            if (height * height - square).abs() < 1e-4 * square {
                                doubtful += 1;
                                continue;
                            }
                            let clear = height * height > square;
                            let expected = (clear && height > 0.0, clear && height <= 0.0);
                            assert_eq!((has(over.get(k), i), has(under.get(k), i)), expected, "{level:?} {k} {i}");
                        }
                    }
                }
                assert!(doubtful <= 3, "{doubtful}");
            }
        }
    }
}
