//! Support functions of point sets: the highest and the lowest point along directions, eight directions or eight points
//! at once.

use feeler_core::geometry::bounds::Point;
use feeler_lanes::{Checked, Kernel, Simd, Wide, WIDE_LANES};

/// For each of eight directions how far points reach, and the index of the point that does: the last of several.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Reach {
    /// As [`dot`](feeler_core::geometry::vectors::dot) has it.
    pub height: [f64; WIDE_LANES],
    pub at: [f64; WIDE_LANES],
}

/// The highest of the points `above` and the lowest of the points `below`, along each of eight directions.
pub(crate) fn highest_and_lowest(
    lanes: Checked,
    above: &[Point],
    below: &[Point],
    directions: &[Point; WIDE_LANES],
) -> (Reach, Reach) {
    lanes.run(HighestAndLowest { above, below, directions })
}

/// How far points reach along each of eight directions.
pub(crate) fn highest(lanes: Checked, points: &[Point], directions: &[Point; WIDE_LANES]) -> [f64; WIDE_LANES] {
    lanes.run(Highest { points, directions })
}

/// How far points reach along one direction.
pub(crate) fn highest_of_eights(lanes: Checked, points: &[Eight], d: &Point) -> f64 {
    let heights = lanes.run(HighestOfEights { points, d });
    heights.iter().fold(f64::NEG_INFINITY, |m, h| m.max(*h))
}

/// Eight points as a structure of arrays.
pub(crate) type Eight = [Wide; 3];

/// Appends points in eights; the last eight is filled up with the last point.
pub(crate) fn push_eights(points: &[Point], out: &mut Vec<Eight>) {
    let mut eight = Eight::default();
    let eights = points.chunks_exact(WIDE_LANES);
    let rest = eights.remainder();
    for points in eights {
        (0..WIDE_LANES).for_each(|i| (0..3).for_each(|a| eight[a][i] = points[i][a]));
        out.push(eight);
    }
    if let Some(last) = rest.last() {
        (0..3).for_each(|a| eight[a].fill(last[a]));
        rest.iter().enumerate().for_each(|(i, p)| (0..3).for_each(|a| eight[a][i] = p[a]));
        out.push(eight);
    }
}

/// Indices of the points that reach a height along a direction. Lanes that fill up the last eight count too, so an
/// index may be beyond the last point and then means that one. `room` is working memory.
pub(crate) fn places_above<'a>(
    lanes: Checked,
    points: &[Eight],
    d: &Point,
    height: f64,
    room: &'a mut Vec<u32>,
) -> &'a [u32] {
    let most = WIDE_LANES * points.len();
    if room.len() < most {
        room.resize(2 * most, 0);
    }
    let count = lanes.run(PlacesAbove { points, d, height, out: room });
    &room[..count]
}

struct PlacesAbove<'a> {
    points: &'a [Eight],
    d: &'a Point,
    height: f64,
    out: &'a mut [u32],
}

impl Kernel for PlacesAbove<'_> {
    type Output = usize;

    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> usize {
        let d = [s.wide_splat(self.d[0]), s.wide_splat(self.d[1]), s.wide_splat(self.d[2])];
        let least = s.wide_splat(self.height);
        // A bit for each of 64 points, then a loop over the bits that are set: they are few, and which cannot be
        // predicted.
        let (mut count, mut first) = (0, 0);
        for eights in self.points.chunks(WIDE_LANES) {
            let mut above = 0;
            for (i, p) in eights.iter().enumerate() {
                above |= u64::from(!s.bits(s.wide_above(least, eight_heights(s, p, &d)))) << (WIDE_LANES * i);
            }
            while above != 0 {
                self.out[count] = first + above.trailing_zeros();
                count += 1;
                above &= above - 1;
            }
            first += u64::BITS;
        }
        count
    }
}

struct Highest<'a> {
    points: &'a [Point],
    directions: &'a [Point; WIDE_LANES],
}

impl Kernel for Highest<'_> {
    type Output = [f64; WIDE_LANES];

    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> [f64; WIDE_LANES] {
        let d = s.wide_points(self.directions.each_ref());
        let mut chains = [s.wide_splat(f64::NEG_INFINITY); 4];
        let mut fours = self.points.chunks_exact(4);
        for four in &mut fours {
            (0..4).for_each(|i| chains[i] = s.wide_max(chains[i], height(s, &four[i], &d)));
        }
        fours.remainder().iter().for_each(|p| chains[0] = s.wide_max(chains[0], height(s, p, &d)));
        let mut found = [0.0; WIDE_LANES];
        s.wide_store(s.wide_max(s.wide_max(chains[0], chains[1]), s.wide_max(chains[2], chains[3])), &mut found);
        found
    }
}

struct HighestOfEights<'a> {
    points: &'a [Eight],
    d: &'a Point,
}

impl Kernel for HighestOfEights<'_> {
    type Output = [f64; WIDE_LANES];

    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> [f64; WIDE_LANES] {
        let d = [s.wide_splat(self.d[0]), s.wide_splat(self.d[1]), s.wide_splat(self.d[2])];
        let mut highest = s.wide_splat(f64::NEG_INFINITY);
        for p in self.points {
            highest = s.wide_max(highest, eight_heights(s, p, &d));
        }
        let mut found = [0.0; WIDE_LANES];
        s.wide_store(highest, &mut found);
        found
    }
}

/// Heights of eight points along a direction.
#[inline(always)]
pub(crate) fn eight_heights<S: Simd>(s: S, p: &Eight, d: &[S::F64; 3]) -> S::F64 {
    s.wide_load(&p[0]) * d[0] + s.wide_load(&p[1]) * d[1] + s.wide_load(&p[2]) * d[2]
}

struct HighestAndLowest<'a> {
    above: &'a [Point],
    below: &'a [Point],
    directions: &'a [Point; WIDE_LANES],
}

impl Kernel for HighestAndLowest<'_> {
    type Output = (Reach, Reach);

    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> (Reach, Reach) {
        let along = s.wide_points(self.directions.each_ref());
        let zero = s.wide_splat(0.0);
        let against = [zero - along[0], zero - along[1], zero - along[2]];
        let high = reach(s, self.above, &along);
        let mut low = reach(s, self.below, &against);
        low.height.iter_mut().for_each(|h| *h = -*h);
        (high, low)
    }
}

/// The highest point so far in each lane.
struct HighestByLane<S: Simd> {
    height: S::F64,
    at: S::F64,
}

impl<S: Simd> HighestByLane<S> {
    #[inline(always)]
    fn new(s: S) -> HighestByLane<S> {
        HighestByLane { height: s.wide_splat(f64::NEG_INFINITY), at: s.wide_splat(0.0) }
    }

    /// The chain of maxima does not wait for the indices, which are selected beside it.
    #[inline(always)]
    fn offer(&mut self, s: S, p: &Point, d: &[S::F64; 3], index: S::F64) {
        let h = height(s, p, d);
        self.at = s.choose(s.wide_above(self.height, h), self.at, index);
        self.height = s.wide_max(self.height, h);
    }
}

#[inline(always)]
fn height<S: Simd>(s: S, p: &Point, d: &[S::F64; 3]) -> S::F64 {
    s.wide_splat(p[0]) * d[0] + s.wide_splat(p[1]) * d[1] + s.wide_splat(p[2]) * d[2]
}

/// Even and odd points in two chains of comparisons, so that one does not wait for the other.
#[inline(always)]
fn reach<S: Simd>(s: S, points: &[Point], d: &[S::F64; 3]) -> Reach {
    let (mut even, mut odd) = (HighestByLane::new(s), HighestByLane::new(s));
    let (mut index, one, two) = (s.wide_splat(0.0), s.wide_splat(1.0), s.wide_splat(2.0));
    let mut pairs = points.chunks_exact(2);
    for pair in &mut pairs {
        even.offer(s, &pair[0], d, index);
        odd.offer(s, &pair[1], d, index + one);
        index = index + two;
    }
    if let [last] = pairs.remainder() {
        even.offer(s, last, d, index);
    }
    let (is_even, is_odd) = (s.wide_above(even.height, odd.height), s.wide_above(odd.height, even.height));
    let later = s.choose(is_even, even.at, s.choose(is_odd, odd.at, s.wide_max(even.at, odd.at)));
    let mut found = Reach { height: [0.0; WIDE_LANES], at: [0.0; WIDE_LANES] };
    s.wide_store(s.wide_max(even.height, odd.height), &mut found.height);
    s.wide_store(later, &mut found.at);
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use feeler_core::geometry::vectors::dot;
    use feeler_lanes::Level;

    #[test]
    fn the_points_above_are_those_a_loop_finds() {
        let points: Vec<Point> = (0..29).map(|i| [f64::from(i % 7), f64::from(i % 3), f64::from(i)]).collect();
        let mut eights = Vec::new();
        push_eights(&points, &mut eights);
        for level in Level::available() {
            for (d, height) in [([1.0, 0.0, 0.0], 5.0), ([0.3, -0.2, 0.1], 2.0), ([0.0, 0.0, 1.0], 28.0)] {
                let mut found = places_above(level.checked(), &eights, &d, height, &mut Vec::new()).to_vec();
                found.iter_mut().for_each(|i| *i = (*i).min(28));
                found.dedup();
                let expected: Vec<u32> = (0..29).filter(|i| dot(&points[*i as usize], &d) >= height).collect();
                assert_eq!(found, expected, "{level:?}");
            }
        }
    }

    #[test]
    fn every_level_finds_what_a_loop_finds() {
        let wave = |i: usize| [(0.7 * i as f64).sin(), (1.9 * i as f64).cos(), (0.3 * i as f64).sin() - 0.2];
        let directions: [Point; WIDE_LANES] = std::array::from_fn(|i| wave(91 + 7 * i));
        for level in Level::available() {
            for count in [1, 2, 3, 8, 31, 100] {
                // Some points occur twice.
                let wave = |i: usize| wave(i % 40);
                let (above, below): (Vec<Point>, Vec<Point>) = (0..count).map(|i| (wave(i), wave(3 * i + 1))).unzip();
                let (high, low) = highest_and_lowest(level.checked(), &above, &below, &directions);
                for (i, d) in directions.iter().enumerate() {
                    let most = above.iter().map(|p| dot(p, d)).fold(f64::NEG_INFINITY, f64::max);
                    let least = below.iter().map(|p| dot(p, d)).fold(f64::INFINITY, f64::min);
                    assert_eq!((high.height[i], low.height[i]), (most, least), "{level:?} {count} {i}");
                    assert_eq!(above.iter().rposition(|p| dot(p, d) == most), Some(high.at[i] as usize));
                    assert_eq!(below.iter().rposition(|p| dot(p, d) == least), Some(low.at[i] as usize));
                }
            }
        }
    }
}
