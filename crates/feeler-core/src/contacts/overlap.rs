//! How far the tool has to go along one direction until nothing of two bodies overlaps along it.
//!
//! Of two that bulge that is as far as until a plane holds them apart, where that is the least. But bodies of surfaces that lie in
//! each other's hollows, as the teeth of two racks or the threads of bolt and nut, reach over these hollows: a plane between them
//! is as far as the teeth are high, and what overlaps may be a hundredth of that.

use crate::bounds::{Point, Triangle};
use crate::contacts::depth::Pair;
use crate::contacts::heights::Eight;
use crate::contacts::zones::{MOCKUP, TOOL};
use crate::contacts::Ground;
use crate::simd::{Checked, Kernel, Simd, Wide, WIDE_LANES};
use crate::vectors::{across, along, dot, scaled, sub};

/// Sine of the angle between a triangle's plane and a direction up to which it is seen from its edge: others have that edge too.
const STEEP: f64 = 1e-3;

/// Most pairs of triangles that are looked at, and of those that are cut out of each other.
const MOST_PAIRS: usize = 1 << 22;
const MOST_CUT: usize = 1 << 14;

/// Shares of what overlaps and of what would be enough by which a place must overlap more to be looked at.
const MORE: f64 = 1e-3;
const NOISE: f64 = 1e-9;

/// Eight triangles seen along a direction: two coordinates across it, and the height.
#[derive(Debug, Clone, Default)]
struct Seen {
    corners: [Eight; 3],
    /// Across; the other way round where there is no triangle, or one seen from its edge.
    lower: [Wide; 2],
    upper: [Wide; 2],
    /// The height of a triangle's plane: the coordinates times the first two, and the last.
    plane: Eight,
}

impl Seen {
    fn corners_of(&self, lane: usize) -> Triangle {
        std::array::from_fn(|c| std::array::from_fn(|k| self.corners[c][k][lane]))
    }
}

/// The triangles of two bodies, seen along a direction. Kept as working memory.
#[derive(Debug, Default)]
pub(crate) struct Overlap {
    /// Two directions across, and the direction.
    frame: [Point; 3],
    triangles: Vec<Triangle>,
    seen: [Vec<Seen>; 2],
}

impl Overlap {
    /// Sees two bodies along a direction.
    pub fn set(&mut self, ground: &Ground<'_>, pair: &Pair<'_>, d: &Point) {
        let [u, v] = across(d);
        self.frame = [u, v, *d];
        let Overlap { frame, triangles, seen } = self;
        // The tool's where it is, without placing it.
        let (r, t) = (ground.pose.rotation(), ground.pose.translation());
        let own = frame.map(|x| std::array::from_fn(|a| r[0][a] * x[0] + r[1][a] * x[1] + r[2][a] * x[2]));
        let from = frame.map(|x| dot(t, &x));
        triangles.clear();
        triangles.extend(pair.tool.facing(&scaled(d, -1.0)).map(|id| ground.tool.mesh().triangle(id)));
        ground.lanes.run(Seeing { triangles, frame: &own, from: &from, out: &mut seen[TOOL] });
        triangles.clear();
        triangles.extend(pair.mockup.facing(d).map(|id| ground.mockup_triangle(id)));
        ground.lanes.run(Seeing { triangles, frame, from: &[0.0; 3], out: &mut seen[MOCKUP] });
    }

    /// The most that overlaps anywhere, negative infinity where no triangle is above another, with the mock-up's point there; as soon
    /// as it is `enough`, that. `None` where these are too many triangles to tell.
    pub fn most(&self, lanes: Checked, enough: f64) -> Option<(f64, Point)> {
        let [tool, mockup] = &self.seen;
        if tool.len() * WIDE_LANES * mockup.len() * WIDE_LANES > MOST_PAIRS {
            return None;
        }
        let (most, [x, y, h]) = lanes.run(Most { tool, mockup, enough })?;
        let [u, v, d] = &self.frame;
        Some((most, std::array::from_fn(|a| x * u[a] + y * v[a] + h * d[a])))
    }
}

/// Turns triangles into a frame.
struct Seeing<'a> {
    triangles: &'a [Triangle],
    frame: &'a [Point; 3],
    from: &'a Point,
    out: &'a mut Vec<Seen>,
}

impl Kernel for Seeing<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, s: S) {
        let Seeing { triangles, frame, from, out } = self;
        let zero = s.wide_splat(0.0);
        let (none_above, none_below) = (s.wide_splat(f64::INFINITY), s.wide_splat(f64::NEG_INFINITY));
        out.clear();
        for some in triangles.chunks(WIDE_LANES) {
            let mut eight = Seen::default();
            let mut seen = [[zero; 3]; 3];
            for c in 0..3 {
                let mut corners = [&some[0][c]; WIDE_LANES];
                for i in 0..some.len() {
                    corners[i] = &some[i][c];
                }
                let p = s.wide_points(corners);
                for k in 0..3 {
                    let [x, y, z] = &frame[k];
                    let h = p[0] * s.wide_splat(*x) + p[1] * s.wide_splat(*y) + p[2] * s.wide_splat(*z);
                    seen[c][k] = h + s.wide_splat(from[k]);
                    s.wide_store(seen[c][k], &mut eight.corners[c][k]);
                }
            }
            let [a, b, c] = seen;
            let e = [b[0] - a[0], b[1] - a[1], b[2] - a[2]];
            let f = [c[0] - a[0], c[1] - a[1], c[2] - a[2]];
            let n = [e[1] * f[2] - e[2] * f[1], e[2] * f[0] - e[0] * f[2], e[0] * f[1] - e[1] * f[0]];
            let square = n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
            let is_seen = s.wide_above(n[2] * n[2], square * s.wide_splat(STEEP * STEEP));
            let mut height = a[2];
            for k in 0..2 {
                let slope = s.wide_divide(zero - n[k], n[2]);
                height = height - slope * a[k];
                s.wide_store(slope, &mut eight.plane[k]);
                let lower = s.wide_min(s.wide_min(a[k], b[k]), c[k]);
                let upper = s.wide_max(s.wide_max(a[k], b[k]), c[k]);
                s.wide_store(s.choose(is_seen, lower, none_above), &mut eight.lower[k]);
                s.wide_store(s.choose(is_seen, upper, none_below), &mut eight.upper[k]);
            }
            s.wide_store(height, &mut eight.plane[2]);
            for k in 0..2 {
                eight.lower[k][some.len()..].fill(f64::INFINITY);
                eight.upper[k][some.len()..].fill(f64::NEG_INFINITY);
            }
            out.push(eight);
        }
    }
}

/// Finds where triangles of the mock-up are above triangles of the tool the most.
struct Most<'a> {
    tool: &'a [Seen],
    mockup: &'a [Seen],
    enough: f64,
}

impl Kernel for Most<'_> {
    type Output = Option<(f64, Point)>;

    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> Option<(f64, Point)> {
        let (mut most, mut best, mut cut) = (f64::NEG_INFINITY, [0.0; 3], 0);
        let mut limit = s.wide_splat(most);
        for eight in self.tool {
            for lane in 0..WIDE_LANES {
                if eight.lower[0][lane] > eight.upper[0][lane] {
                    continue;
                }
                let corners = eight.corners_of(lane);
                let mut t = [[s.wide_splat(0.0); 3]; 3];
                let mut plane = t[0];
                for k in 0..3 {
                    plane[k] = s.wide_splat(eight.plane[k][lane]);
                    for c in 0..3 {
                        t[c][k] = s.wide_splat(corners[c][k]);
                    }
                }
                for (j, m) in self.mockup.iter().enumerate() {
                    let mut apart = 0;
                    for k in 0..2 {
                        let (low, high) = (s.wide_splat(eight.lower[k][lane]), s.wide_splat(eight.upper[k][lane]));
                        let beyond = s.wide_above(s.wide_load(&m.lower[k]), high);
                        apart |= s.bits(s.either(beyond, s.wide_above(low, s.wide_load(&m.upper[k]))));
                    }
                    if apart == u8::MAX {
                        continue;
                    }
                    // What is between two planes is linear, so nowhere more than at a corner of either triangle.
                    let n = [s.wide_load(&m.plane[0]), s.wide_load(&m.plane[1]), s.wide_load(&m.plane[2])];
                    let mut at_tool = s.wide_splat(f64::NEG_INFINITY);
                    let mut at_mockup = at_tool;
                    for c in 0..3 {
                        at_tool = s.wide_max(at_tool, n[0] * t[c][0] + n[1] * t[c][1] + n[2] - t[c][2]);
                        let [x, y, h] = &m.corners[c];
                        let under = plane[0] * s.wide_load(x) + plane[1] * s.wide_load(y) + plane[2];
                        at_mockup = s.wide_max(at_mockup, s.wide_load(h) - under);
                    }
                    let mut left = s.bits(s.wide_above(s.wide_min(at_tool, at_mockup), limit)) & !apart;
                    while left != 0 {
                        let other = left.trailing_zeros() as usize;
                        left &= left - 1;
                        cut += 1;
                        if cut > MOST_CUT {
                            return None;
                        }
                        let m = &self.mockup[j];
                        let plane = [m.plane[0][other], m.plane[1][other], m.plane[2][other]];
                        let Some(found) = overlap(&corners, &m.corners_of(other), &plane) else { continue };
                        if found.0 > most {
                            (most, best) = found;
                            if most >= self.enough {
                                return Some(found);
                            }
                            limit = s.wide_splat(most + MORE * most.abs() + NOISE * self.enough);
                        }
                    }
                }
            }
        }
        Some((most, best))
    }
}

/// Most corners of what two triangles share.
const MOST_CORNERS: usize = 7;

/// How much two triangles overlap along the heights, at most, and the point there of the second, whose plane is given.
#[inline(always)]
fn overlap(t: &Triangle, m: &Triangle, plane: &Point) -> Option<(f64, Point)> {
    let area = (m[1][0] - m[0][0]) * (m[2][1] - m[0][1]) - (m[1][1] - m[0][1]) * (m[2][0] - m[0][0]);
    // What the first has within the second, corner by corner.
    let (mut piece, mut kept) = ([[0.0; 3]; MOST_CORNERS], [[0.0; 3]; MOST_CORNERS]);
    piece[..3].copy_from_slice(t);
    let mut count = 3;
    for k in 0..3 {
        let (a, b) = (&m[k], &m[(k + 1) % 3]);
        let (x, y) = (area.signum() * (b[0] - a[0]), area.signum() * (b[1] - a[1]));
        let mut before = piece[count - 1];
        let mut at_before = x * (before[1] - a[1]) - y * (before[0] - a[0]);
        let mut left = 0;
        for p in &piece[..count] {
            let at = x * (p[1] - a[1]) - y * (p[0] - a[0]);
            if (at_before > 0.0 && at < 0.0 || at_before < 0.0 && at > 0.0) && left < MOST_CORNERS {
                kept[left] = along(&before, at_before / (at_before - at), &sub(p, &before));
                left += 1;
            }
            if at >= 0.0 && left < MOST_CORNERS {
                kept[left] = *p;
                left += 1;
            }
            (before, at_before) = (*p, at);
        }
        if left == 0 {
            return None;
        }
        (piece, kept, count) = (kept, piece, left);
    }
    let mut best = (f64::NEG_INFINITY, [0.0; 3]);
    for p in &piece[..count] {
        let height = plane[0] * p[0] + plane[1] * p[1] + plane[2];
        if height - p[2] > best.0 {
            best = (height - p[2], [p[0], p[1], height]);
        }
    }
    (best.0 > f64::NEG_INFINITY).then_some(best)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contacts::shapes::ridge;
    use crate::contacts::tests::{at, scene, tool};
    use crate::simd::Level;
    use crate::vectors::{normal, unit};

    #[test]
    fn every_level_finds_what_all_pairs_say() {
        let wave = |i: usize| [(0.7 * i as f64).sin(), (1.9 * i as f64).cos(), 0.3 * (1.3 * i as f64).sin()];
        let triangle = |i: usize| {
            let middle = wave(7 * i + 3);
            [0, 1, 2].map(|k| along(&middle, 0.3, &wave(3 * i + k)))
        };
        let d = unit(&[0.2, -0.3, 0.9]).unwrap();
        let [u, v] = across(&d);
        let frame = [u, v, d];
        let mut none = 0;
        for round in 0..60 {
            let (tools, mockups) = (1 + round % 23, 1 + 2 * round % 31);
            let tools: Vec<Triangle> = (0..tools).map(|i| triangle(100 * round + i)).collect();
            // Every third once more, and one seen from its edge.
            let mut mockups: Vec<Triangle> = (0..mockups).map(|i| triangle(9000 + 100 * round + i - i % 3)).collect();
            mockups.push([[0.0; 3], d, u]);
            let seen = |t: &Triangle| t.map(|p| frame.map(|x| dot(&p, &x)));
            let mut expected = f64::NEG_INFINITY;
            for t in &tools {
                for m in &mockups[..mockups.len() - 1] {
                    let m = seen(m);
                    let n = normal(&m).unwrap();
                    let plane = [-n[0] / n[2], -n[1] / n[2], dot(&n, &m[0]) / n[2]];
                    expected = overlap(&seen(t), &m, &plane).map_or(expected, |found| expected.max(found.0));
                }
            }
            none += usize::from(expected == f64::NEG_INFINITY);
            let mut all = Vec::new();
            for level in Level::available() {
                let lanes = level.checked();
                let mut overlap = Overlap { frame, ..Overlap::default() };
                for (triangles, out) in [&tools, &mockups].into_iter().zip(&mut overlap.seen) {
                    lanes.run(Seeing { triangles, frame: &frame, from: &[0.0; 3], out });
                }
                let found = overlap.most(lanes, 10.0);
                let most = found.unwrap().0;
                let is_right = most == expected || (most - expected).abs() <= 2.0 * MORE * expected.abs() + 1e-12;
                assert!(is_right, "{level:?} {round}: {most} {expected}");
                let first = overlap.most(lanes, 0.5 * expected);
                assert!(expected <= 0.0 || first.unwrap().0 >= 0.5 * expected, "{level:?} {round}");
                all.push(found);
            }
            assert!(all.iter().all(|found| *found == all[0]), "{round}");
        }
        assert!((1..40).contains(&none), "{none}");
    }

    #[test]
    fn surfaces_that_lie_in_each_other_are_as_deep_as_they_overlap() {
        // Blocks with a side of waves, cut ever finer, that fit; the upper one pressed in a little.
        for n in [10, 40, 160] {
            let line: Vec<[f64; 2]> = (0..=n)
                .map(|i| -0.05 + 0.1 * f64::from(i) / f64::from(n))
                .map(|x| [x, 0.003 * (200.0 * x).sin()])
                .collect();
            let (lower, upper) = (scene(ridge(&line, -0.02, 0.03, 1, 4)), tool(ridge(&line, 0.02, 0.02, 1, 3)));
            for depth in [0.0, 1e-4, 5e-4] {
                let pose = at(0.0, 0.0, -depth);
                let contacts = lower.contacts(&upper, &pose, 0.002, None).unwrap();
                let deep = contacts.planes.iter().filter(|p| p.gap <= 0.0);
                assert!(deep.clone().count() > 1, "{n} {depth}");
                // Along a normal that leans as far as the waves are steep it is twice as far as straight down.
                assert!(deep.clone().all(|p| p.gap >= -2.0 * depth - 1e-6), "{n} {depth}: {:?}", contacts.depth());
                assert!(deep.clone().any(|p| p.gap <= -0.5 * depth), "{n} {depth}: {:?}", contacts.depth());
                let out = lower.penetration(&upper, &pose, 0.002, None).unwrap();
                assert!(out.depth <= 1.5 * depth + 1e-6, "{n} {depth}: {}", out.depth);
            }
        }
    }
}
