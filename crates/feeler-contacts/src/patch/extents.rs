//! Extents of patches: size, middle and extreme points; and the largest coordinate of points.

use crate::constants::MOST_CORNERS;
use crate::patch::support::Eight;
use crate::patch::surface_patch::Patch;
use feeler_core::geometry::bounds::Point;
use feeler_core::geometry::vectors::{length, scaled, sub};
use feeler_lanes::{Checked, Kernel, Simd, WIDE_LANES};

/// Directions along which the extreme points of a patch represent all its points: the axes and diagonals of a cube, the
/// last one twice to fill the lanes.
const DIRECTIONS: [Point; WIDE_LANES] = [
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [1.0, 1.0, 1.0],
    [-1.0, 1.0, 1.0],
    [1.0, -1.0, 1.0],
    [1.0, 1.0, -1.0],
    [1.0, 1.0, -1.0],
];

/// Extents of the points of a patch.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Extents {
    /// Their mean.
    pub middle: Point,
    /// Diagonal of their bounding box, metres.
    pub size: f64,
    /// Indices of the lowest and of the highest point along each of [`DIRECTIONS`]; zeros for at most [`MOST_CORNERS`]
    /// points.
    pub extreme: [[f64; WIDE_LANES]; 2],
}

/// Writes the extents of each patch to `out`; `points` are the points of all patches.
pub(crate) fn measure_extents(lanes: Checked, points: &[Point], patches: &[Patch], out: &mut Vec<Extents>) {
    lanes.run(MeasureExtents { points, patches, out });
}

struct MeasureExtents<'a> {
    points: &'a [Point],
    patches: &'a [Patch],
    out: &'a mut Vec<Extents>,
}

impl Kernel for MeasureExtents<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, s: S) {
        let d = s.wide_points(DIRECTIONS.each_ref());
        self.out.clear();
        for patch in self.patches {
            let points = patch.of_points(self.points);
            let mut extreme = [[0.0; WIDE_LANES]; 2];
            let [low, high, sum] = if points.len() > MOST_CORNERS {
                bounds_and_extremes(s, &d, points, &mut extreme)
            } else {
                bounds(points)
            };
            let middle = scaled(&sum, 1.0 / points.len() as f64);
            self.out.push(Extents { middle, size: length(&sub(&high, &low)), extreme });
        }
    }
}

/// Minimum, maximum and sum of points, coordinate by coordinate.
#[inline(always)]
fn bounds(points: &[Point]) -> [Point; 3] {
    let (mut low, mut high, mut sum) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3], [0.0; 3]);
    for p in points {
        for a in 0..3 {
            low[a] = if p[a] < low[a] { p[a] } else { low[a] };
            high[a] = if p[a] > high[a] { p[a] } else { high[a] };
            sum[a] += p[a];
        }
    }
    [low, high, sum]
}

/// The same, and the indices of the lowest and the highest point along eight directions, of which the first three are
/// the axes.
#[inline(always)]
fn bounds_and_extremes<S: Simd>(
    s: S,
    d: &[S::F64; 3],
    points: &[Point],
    extreme: &mut [[f64; WIDE_LANES]; 2],
) -> [Point; 3] {
    let (zero, one) = (s.wide_splat(0.0), s.wide_splat(1.0));
    let (mut low, mut high) = (s.wide_splat(f64::INFINITY), s.wide_splat(f64::NEG_INFINITY));
    let (mut low_at, mut high_at, mut sum, mut index) = (zero, zero, zero, zero);
    for p in points {
        // In the first three lanes, the axes, the height is the coordinate.
        let h = s.wide_splat(p[0]) * d[0] + s.wide_splat(p[1]) * d[1] + s.wide_splat(p[2]) * d[2];
        low_at = s.choose(s.wide_above(h, low), low_at, index);
        high_at = s.choose(s.wide_above(high, h), high_at, index);
        (low, high) = (s.wide_min(low, h), s.wide_max(high, h));
        sum = sum + h;
        index = index + one;
    }
    s.wide_store(low_at, &mut extreme[0]);
    s.wide_store(high_at, &mut extreme[1]);
    let mut stored = [[0.0; WIDE_LANES]; 3];
    for (x, to) in [low, high, sum].into_iter().zip(&mut stored) {
        s.wide_store(x, to);
    }
    stored.map(|x| [x[0], x[1], x[2]])
}

/// The largest absolute coordinate of points; 0 without points.
pub(crate) fn largest(lanes: Checked, points: &[Eight]) -> f64 {
    lanes.run(Largest { points })
}

struct Largest<'a> {
    points: &'a [Eight],
}

impl Kernel for Largest<'_> {
    type Output = f64;

    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> f64 {
        let mut most = [s.wide_splat(0.0); 3];
        for eight in self.points {
            for a in 0..3 {
                most[a] = s.wide_max(most[a], s.wide_abs(s.wide_load(&eight[a])));
            }
        }
        let mut found = [0.0; WIDE_LANES];
        s.wide_store(s.wide_max(s.wide_max(most[0], most[1]), most[2]), &mut found);
        let mut all = 0.0;
        for x in found {
            all = if x > all { x } else { all };
        }
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::patch::support::push_eights;
    use feeler_core::geometry::bounds::Aabb;
    use feeler_core::geometry::vectors::{add, dot};
    use feeler_lanes::Level;

    #[test]
    fn extents_are_those_a_loop_finds() {
        // Some points occur twice.
        let wave = |i: usize| [(0.7 * i as f64).sin() - 0.4, (1.9 * i as f64).cos(), (0.3 * i as f64).sin() - 3.0];
        let points: Vec<Point> = (0..60).map(|i| wave(i % 17)).collect();
        for level in Level::available() {
            let ranges = [(0, 1), (3, 5), (7, 40), (20, 28), (30, 39), (0, 60)];
            let mut patches = ranges.map(|_| Patch::new([0.0; 3], [0.0; 3]));
            patches.iter_mut().zip(ranges).for_each(|(patch, points)| patch.points = points);
            let mut found = Vec::new();
            measure_extents(level.checked(), &points, &patches, &mut found);
            for ((from, to), found) in ranges.into_iter().zip(&found) {
                let points = &points[from as usize..to as usize];
                let mut bounds = Aabb::EMPTY;
                points.iter().for_each(|p| bounds.grow(p));
                let sum = points.iter().fold([0.0; 3], |s, p| add(&s, p));
                assert_eq!(found.size, length(&bounds.extent()));
                assert_eq!(found.middle, scaled(&sum, 1.0 / points.len() as f64));
                for (i, d) in DIRECTIONS.iter().enumerate().filter(|_| points.len() > MOST_CORNERS) {
                    let [low, high] = found.extreme.map(|of| dot(&points[of[i] as usize], d));
                    assert!(points.iter().all(|p| low <= dot(p, d) && dot(p, d) <= high), "{level:?} {d:?}");
                }
                let mut eights = Vec::new();
                push_eights(points, &mut eights);
                let most = points.iter().flatten().fold(0.0, |m: f64, x| m.max(x.abs()));
                assert_eq!(largest(level.checked(), &eights), most);
            }
            assert_eq!(largest(level.checked(), &[]), 0.0);
        }
    }
}
