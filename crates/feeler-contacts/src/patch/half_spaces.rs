//! Which points lie in the intersection of half-spaces: above none of the planes of some patches, eight patches at
//! once.

use crate::constants::{HOLLOW, HOLLOW_OF_PLANE};
use crate::patch::surface_patch::Patch;
use feeler_core::geometry::bounds::Point;
use feeler_lanes::{Checked, Kernel, Simd, Wide, WIDE_LANES};

/// Planes of eight patches as a structure of arrays.
#[derive(Debug)]
struct Eight {
    normal: [Wide; 3],
    at: [Wide; 3],
    middle: [Wide; 3],
    /// Square of the least sine, seen from the middle, of what stands out over the plane.
    share: Wide,
}

/// The half-spaces below the planes of some patches.
#[derive(Debug, Default)]
pub(crate) struct HalfSpaces {
    eights: Vec<Eight>,
}

impl HalfSpaces {
    pub fn set<'a>(&mut self, patches: impl Iterator<Item = &'a Patch>) {
        self.eights.clear();
        for (i, patch) in patches.enumerate() {
            let share = if patch.flat { HOLLOW_OF_PLANE } else { HOLLOW };
            if i % WIDE_LANES == 0 {
                let all = |x: &Point| x.map(|c| Wide([c; WIDE_LANES]));
                let (normal, at, middle) = (all(&patch.normal), all(&patch.at), all(&patch.middle));
                self.eights.push(Eight { normal, at, middle, share: Wide([share * share; WIDE_LANES]) });
            } else if let Some(eight) = self.eights.last_mut() {
                let lane = i % WIDE_LANES;
                for a in 0..3 {
                    eight.normal[a][lane] = patch.normal[a];
                    eight.at[a][lane] = patch.at[a];
                    eight.middle[a][lane] = patch.middle[a];
                }
                eight.share[lane] = share * share;
            }
        }
    }

    /// Moves the points that are above no plane to the front, each with its entry of `with`, and returns how many they
    /// are. Above means by more than [`HOLLOW_OF_PLANE`] of the distance from the middle of a flat patch, and by more
    /// than [`HOLLOW`] for others.
    pub fn keep_below(&self, lanes: Checked, points: &mut [Point], with: &mut [(u32, u32)]) -> usize {
        lanes.run(KeepBelow { half_spaces: self, points, with })
    }
}

struct KeepBelow<'a> {
    half_spaces: &'a HalfSpaces,
    points: &'a mut [Point],
    with: &'a mut [(u32, u32)],
}

impl Kernel for KeepBelow<'_> {
    type Output = usize;

    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> usize {
        let KeepBelow { half_spaces: HalfSpaces { eights }, points, with } = self;
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
fn stands_out<S: Simd>(s: S, x: &[S::F64; 3], eight: &Eight) -> u8 {
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
            let mut half_spaces = HalfSpaces::default();
            half_spaces.set(patches.iter());
            for level in Level::available() {
                let is_below = |x: &Point| !patches.iter().any(|p| stands_out(p, x));
                let numbered = |(k, x): (u32, &Point)| (*x, (k, k + 1));
                let expected: Vec<_> = (0..).zip(&points).filter(|x| is_below(x.1)).map(numbered).collect();
                assert!(expected.len() < 50 || count == 0);
                let (mut kept, mut with): (Vec<Point>, Vec<(u32, u32)>) = (0..).zip(&points).map(numbered).unzip();
                let left = half_spaces.keep_below(level.checked(), &mut kept, &mut with);
                let kept: Vec<_> = kept[..left].iter().copied().zip(with[..left].iter().copied()).collect();
                assert_eq!(kept, expected, "{level:?} {count}");
            }
        }
    }
}
