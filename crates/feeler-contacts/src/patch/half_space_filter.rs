//! A filter of points by half-spaces: finds the patches whose planes they are clearly above or below, sixteen patches
//! at once.

use crate::constants::HOLLOW;
use crate::containers::bit_set::BitSets;
use crate::patch::patch_lanes::PatchLanes;
use feeler_core::geometry::bounds::Point;
use feeler_lanes::{Checked, Kernel, Simd, LANES};

impl PatchLanes {
    /// Writes to the sets `above` and `below` of each point the patches above and below whose planes it clearly is:
    /// farther from the plane than [`HOLLOW`] times its distance from the patch's middle. Float32 suffices, since
    /// [`HOLLOW`] is far above its rounding.
    pub fn classify(&self, lanes: Checked, points: &[Point], above: &mut BitSets, below: &mut BitSets) {
        lanes.run(Classify { planes: self, points, above, below });
    }
}

struct Classify<'a> {
    planes: &'a PatchLanes,
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
            let p = self.planes.local(p);
            let p = [s.splat(p[0]), s.splat(p[1]), s.splat(p[2])];
            let (above, below) = (self.above.get_mut(k), self.below.get_mut(k));
            for (word, sixteens) in self.planes.sixteens.chunks(64 / LANES).enumerate() {
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
    use crate::patch::surface_patch::Patch;
    use feeler_core::geometry::vectors::{add, dot, scaled, sub, unit};
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
                let mut lanes = PatchLanes::default();
                lanes.set(&patches);
                let mut doubtful = 0;
                for level in Level::available() {
                    let (mut above, mut below) = (BitSets::default(), BitSets::default());
                    above.clear(points.len(), count);
                    below.clear(points.len(), count);
                    lanes.classify(level.checked(), &points, &mut above, &mut below);
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
