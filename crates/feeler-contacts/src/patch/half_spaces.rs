//! Finds the points in the intersection of half-spaces: above none of the planes of some patches, eight patches at
//! once.

use crate::patch::patch_lanes::{EightPlanes, PatchLanes};
use feeler_core::geometry::bounds::Point;
use feeler_lanes::{Checked, Kernel, Simd};

impl PatchLanes {
    /// Moves the points that are above the plane of no patch of a body to the front, each with its entry of `with`, and
    /// returns how many they are. Above means by more than [`HOLLOW_OF_PLANE`](crate::constants::HOLLOW_OF_PLANE) of
    /// the distance from the middle of a flat patch, and by more than [`HOLLOW`](crate::constants::HOLLOW) for others.
    pub fn keep_below(&self, lanes: Checked, body: usize, points: &mut [Point], with: &mut [(u32, u32)]) -> usize {
        lanes.run(KeepBelow { eights: self.eights_of(body), points, with })
    }
}

struct KeepBelow<'a> {
    eights: &'a [EightPlanes],
    points: &'a mut [Point],
    with: &'a mut [(u32, u32)],
}

impl Kernel for KeepBelow<'_> {
    type Output = usize;

    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> usize {
        let KeepBelow { eights, points, with } = self;
        let mut kept = 0;
        for i in 0..points.len() {
            let p = points[i];
            let x = [s.wide_splat(p[0]), s.wide_splat(p[1]), s.wide_splat(p[2])];
            let mut above = 0;
            for eight in eights {
                above |= stands_out(s, &x, eight);
            }
            // Without a branch: which points are kept cannot be predicted.
            (points[kept], with[kept]) = (p, with[i]);
            kept += usize::from(above == 0);
        }
        kept
    }
}

/// A bit for each lane: whether a point stands out over the patch's plane.
#[inline(always)]
fn stands_out<S: Simd>(s: S, x: &[S::F64; 3], eight: &EightPlanes) -> u8 {
    let mut parts = [(x[0], x[0]); 3];
    for a in 0..3 {
        let from_middle = x[a] - s.wide_load(&eight.middle[a]);
        parts[a] = ((x[a] - s.wide_load(&eight.at[a])) * s.wide_load(&eight.normal[a]), from_middle * from_middle);
    }
    let height = parts[0].0 + parts[1].0 + parts[2].0;
    let square = parts[0].1 + parts[1].1 + parts[2].1;
    let clear = s.wide_above(height * height, s.wide_load(&eight.share) * square);
    s.bits(s.both(clear, s.wide_above(height, s.wide_splat(0.0))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::constants::{HOLLOW, HOLLOW_OF_PLANE};
    use crate::patch::surface_patch::Patch;
    use feeler_core::geometry::vectors::{dot, sub, unit};
    use feeler_lanes::Level;

    #[test]
    fn points_are_kept_as_one_by_one() {
        let wave = |i: usize| [(0.7 * i as f64).sin(), (1.9 * i as f64).cos(), (0.3 * i as f64).sin()];
        let points: Vec<Point> = (0..50).map(wave).collect();
        for count in [0, 1, 7, 9, 70] {
            let patch = |i: usize| {
                let mut patch = Patch::new(unit(&wave(11 * i + 5)).unwrap(), [0.9 + 0.01 * i as f64, 0.3, -0.2]);
                (patch.middle, patch.flat) = (wave(3 * i + 1), i.is_multiple_of(3));
                patch
            };
            let patches: Vec<Patch> = (0..count).map(patch).collect();
            let stands_out = |p: &Patch, x: &Point| {
                let share = if p.flat { HOLLOW_OF_PLANE } else { HOLLOW };
                let (from_middle, height) = (sub(x, &p.middle), dot(&sub(x, &p.at), &p.normal));
                height > 0.0 && height * height > share * share * dot(&from_middle, &from_middle)
            };
            let mut lanes = PatchLanes::default();
            lanes.set(&patches);
            // A body of all patches, and one of a few.
            for (body, is_asked) in [|_: &usize| true, |i: &usize| (i * i) % 11 == 3].into_iter().enumerate() {
                lanes.push_body((0..count).filter(is_asked).map(|i| &patches[i]));
                let is_below = |x: &Point| !(0..count).filter(is_asked).any(|i| stands_out(&patches[i], x));
                let numbered = |(k, x): (u32, &Point)| (*x, (k, k + 1));
                let expected: Vec<_> = (0..).zip(&points).filter(|x| is_below(x.1)).map(numbered).collect();
                assert!(expected.len() < 50 || (0..count).filter(is_asked).count() == 0);
                for level in Level::available() {
                    let (mut kept, mut with): (Vec<Point>, Vec<(u32, u32)>) = (0..).zip(&points).map(numbered).unzip();
                    let left = lanes.keep_below(level.checked(), body, &mut kept, &mut with);
                    let kept: Vec<_> = kept[..left].iter().copied().zip(with[..left].iter().copied()).collect();
                    assert_eq!(kept, expected, "{level:?} {count}");
                }
            }
        }
    }
}
