//! On which side of each of many patches points lie, eight patches at once; and small sets as bits.

use crate::bounds::Point;
use crate::contacts::patches::{Patch, HOLLOW};
use crate::simd::{Checked, Kernel, Simd, Wide, WIDE_LANES};

/// Sets of the same few numbers, one after the other, 64 a word.
#[derive(Debug, Default)]
pub(crate) struct Sets {
    words: Vec<u64>,
    /// Words of one set.
    each: usize,
}

impl Sets {
    /// So many empty sets of numbers below `limit`.
    pub fn clear(&mut self, count: usize, limit: usize) {
        self.each = limit.div_ceil(64);
        self.words.clear();
        self.words.resize(count * self.each, 0);
    }

    pub fn get(&self, set: usize) -> &[u64] {
        &self.words[set * self.each..][..self.each]
    }

    pub fn get_mut(&mut self, set: usize) -> &mut [u64] {
        &mut self.words[set * self.each..][..self.each]
    }

    /// Adds the numbers of another set.
    pub fn join(&mut self, set: usize, other: &[u64]) {
        self.get_mut(set).iter_mut().zip(other).for_each(|(x, y)| *x |= y);
    }

    /// Whether what some of these sets have together meets what the same of others have together.
    pub fn is_meeting_union(&self, other: &Sets, sets: &[u32]) -> bool {
        (0..self.each).any(|word| {
            let all = |of: &Sets| sets.iter().fold(0, |all, i| all | of.words[*i as usize * of.each + word]);
            all(self) & all(other) != 0
        })
    }

    pub fn insert(&mut self, set: usize, x: usize) {
        self.words[set * self.each + x / 64] |= 1 << (x % 64);
    }
}

/// Whether a set has a number.
pub(crate) fn has(set: &[u64], x: usize) -> bool {
    set[x / 64] >> (x % 64) & 1 != 0
}

/// Whether two sets share a number.
pub(crate) fn is_meeting(a: &[u64], b: &[u64]) -> bool {
    a.iter().zip(b).any(|(x, y)| x & y != 0)
}

/// The same as [`HOLLOW`] of a flat patch: points strictly over its plane.
const OVER_A_PLANE: f64 = 1e-6;

/// Eight patches by axis.
#[derive(Debug)]
struct Eight {
    normal: [Wide; 3],
    at: [Wide; 3],
    middle: [Wide; 3],
    /// Square of the share of the distance from its middle that a point must be over a patch's plane to stand out over it.
    share: Wide,
}

/// Patches by which to judge points.
#[derive(Debug, Default)]
pub(crate) struct Sides {
    eights: Vec<Eight>,
}

impl Sides {
    pub fn set<'a>(&mut self, patches: impl Iterator<Item = &'a Patch>) {
        self.eights.clear();
        for (i, patch) in patches.enumerate() {
            let share = if patch.flat { OVER_A_PLANE } else { HOLLOW };
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

    /// Puts into the sets `over` and `under` of each point the patches over and under whose planes it clearly is. What lies
    /// beyond the last patch repeats the first of its eight.
    pub fn judge(&self, lanes: Checked, points: &[Point], over: &mut Sets, under: &mut Sets) {
        lanes.run(Judge { sides: self, points, over, under });
    }

    /// Moves the points that are over no patch's plane to the front, each with what belongs to it, and tells how many these are.
    /// Over a flat patch is what is strictly so, over others what is clearly so.
    pub fn keep_below(&self, lanes: Checked, points: &mut [Point], with: &mut [(u32, u32)]) -> usize {
        lanes.run(KeepBelow { sides: self, points, with })
    }
}

struct KeepBelow<'a> {
    sides: &'a Sides,
    points: &'a mut [Point],
    with: &'a mut [(u32, u32)],
}

impl Kernel for KeepBelow<'_> {
    type Output = usize;

    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> usize {
        let KeepBelow { sides: Sides { eights }, points, with } = self;
        let mut kept = 0;
        for i in 0..points.len() {
            let p = points[i];
            let x = [s.wide_splat(p[0]), s.wide_splat(p[1]), s.wide_splat(p[2])];
            let mut above = 0;
            for eight in eights {
                let (clear, up) = sides(s, &x, eight, s.wide_load(&eight.share));
                above |= clear & up;
            }
            // It is as good as random which are kept: no branch asks.
            (points[kept], with[kept]) = (p, with[i]);
            kept += usize::from(above == 0);
        }
        kept
    }
}

struct Judge<'a> {
    sides: &'a Sides,
    points: &'a [Point],
    over: &'a mut Sets,
    under: &'a mut Sets,
}

impl Kernel for Judge<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, s: S) {
        for (k, x) in self.points.iter().enumerate() {
            let x = [s.wide_splat(x[0]), s.wide_splat(x[1]), s.wide_splat(x[2])];
            let (over, under) = (self.over.get_mut(k), self.under.get_mut(k));
            for (word, eights) in self.sides.eights.chunks(8).enumerate() {
                let (mut above, mut below) = (0, 0);
                for (i, eight) in eights.iter().enumerate() {
                    let (clear, up) = sides(s, &x, eight, s.wide_splat(HOLLOW * HOLLOW));
                    above |= u64::from(clear & up) << (8 * i);
                    below |= u64::from(clear & !up) << (8 * i);
                }
                (over[word], under[word]) = (above, below);
            }
        }
    }
}

/// By lane whether a point is clearly to one side of a patch's plane, and whether it is over it. Clear is what is farther from it
/// than a share of the distance from the patch's middle, by the square of the share.
#[inline(always)]
fn sides<S: Simd>(s: S, x: &[S::F64; 3], eight: &Eight, share: S::F64) -> (u8, u8) {
    let mut parts = [(x[0], x[0]); 3];
    for a in 0..3 {
        let way = x[a] - s.wide_load(&eight.middle[a]);
        parts[a] = ((x[a] - s.wide_load(&eight.at[a])) * s.wide_load(&eight.normal[a]), way * way);
    }
    let height = parts[0].0 + parts[1].0 + parts[2].0;
    let square = parts[0].1 + parts[1].1 + parts[2].1;
    let clear = s.wide_above(height * height, share * square);
    (s.bits(clear), s.bits(s.wide_above(height, s.wide_splat(0.0))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simd::Level;
    use crate::vectors::{dot, sub, unit};

    #[test]
    fn points_are_judged_as_one_by_one() {
        let wave = |i: usize| [(0.7 * i as f64).sin(), (1.9 * i as f64).cos(), (0.3 * i as f64).sin()];
        let points: Vec<Point> = (0..50).map(wave).collect();
        for count in [0, 1, 7, 9, 70] {
            let patch = |i: usize| {
                let mut patch = Patch::new(unit(&wave(11 * i + 5)).unwrap(), [0.9 + 0.01 * i as f64, 0.3, -0.2]);
                (patch.middle, patch.flat) = (wave(3 * i + 1), i.is_multiple_of(3));
                patch
            };
            let patches: Vec<Patch> = (0..count).map(patch).collect();
            let side = |p: &Patch, x: &Point, share: f64| {
                let (way, height) = (sub(x, &p.middle), dot(&sub(x, &p.at), &p.normal));
                let clear = height * height > share * share * dot(&way, &way);
                (clear && height > 0.0, clear && height <= 0.0)
            };
            let mut sides = Sides::default();
            sides.set(patches.iter());
            for level in Level::available() {
                let (mut over, mut under) = (Sets::default(), Sets::default());
                over.clear(points.len(), count);
                under.clear(points.len(), count);
                sides.judge(level.checked(), &points, &mut over, &mut under);
                for (k, x) in points.iter().enumerate() {
                    for (i, p) in patches.iter().enumerate() {
                        assert_eq!(
                            (has(over.get(k), i), has(under.get(k), i)),
                            side(p, x, HOLLOW),
                            "{level:?} {k} {i}"
                        );
                    }
                }
                let share = |p: &Patch| if p.flat { OVER_A_PLANE } else { HOLLOW };
                let is_below = |x: &Point| !patches.iter().any(|p| side(p, x, share(p)).0);
                let numbered = |(k, x): (u32, &Point)| (*x, (k, k + 1));
                let expected: Vec<_> = (0..).zip(&points).filter(|x| is_below(x.1)).map(numbered).collect();
                assert!(expected.len() < 50 || count == 0);
                let (mut kept, mut with): (Vec<Point>, Vec<(u32, u32)>) = (0..).zip(&points).map(numbered).unzip();
                let left = sides.keep_below(level.checked(), &mut kept, &mut with);
                let kept: Vec<_> = kept[..left].iter().copied().zip(with[..left].iter().copied()).collect();
                assert_eq!(kept, expected, "{level:?} {count}");
            }
        }
    }

    #[test]
    fn what_some_sets_have_together_meets_what_others_have() {
        let (mut sets, mut others) = (Sets::default(), Sets::default());
        sets.clear(3, 100);
        others.clear(3, 100);
        sets.insert(0, 90);
        others.insert(1, 90);
        others.insert(2, 3);
        assert!(sets.is_meeting_union(&others, &[0, 1]) && !sets.is_meeting_union(&others, &[0, 2, 2]));
    }
}
