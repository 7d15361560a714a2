//! Size, middle and outermost points of patches, and how large the coordinates of points are.

use crate::bounds::Point;
use crate::contacts::heights::Eight;
use crate::simd::{Checked, Kernel, Simd, WIDE_LANES};
use crate::vectors::{length, scaled, sub};

/// Directions along which the outermost points of a patch stand for all of them: axes and diagonals of a cube, and one again.
const OUTERMOST: [Point; WIDE_LANES] = [
    [1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [1.0, 1.0, 1.0],
    [-1.0, 1.0, 1.0],
    [1.0, -1.0, 1.0],
    [1.0, 1.0, -1.0],
    [1.0, 1.0, -1.0],
];

/// What is asked of the points of a patch.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Outline {
    /// Their mean.
    pub middle: Point,
    /// Diagonal of the box around them.
    pub size: f64,
    /// The places of the lowest and the highest along each of a few directions.
    pub outermost: [[f64; WIDE_LANES]; 2],
}

/// The outline of some of the points, by where they begin and end.
pub(crate) fn outline(lanes: Checked, points: &[Point], of: (u32, u32)) -> Outline {
    lanes.run(Outlined { points: &points[of.0 as usize..of.1 as usize] })
}

struct Outlined<'a> {
    points: &'a [Point],
}

impl Kernel for Outlined<'_> {
    type Output = Outline;

    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> Outline {
        let d = s.wide_points(OUTERMOST.each_ref());
        let (zero, one) = (s.wide_splat(0.0), s.wide_splat(1.0));
        let (mut low, mut high) = (s.wide_splat(f64::INFINITY), s.wide_splat(f64::NEG_INFINITY));
        let (mut low_at, mut high_at, mut sum, mut place) = (zero, zero, zero, zero);
        for p in self.points {
            // Along the axes these are the coordinates.
            let h = s.wide_splat(p[0]) * d[0] + s.wide_splat(p[1]) * d[1] + s.wide_splat(p[2]) * d[2];
            low_at = s.choose(s.wide_above(h, low), low_at, place);
            high_at = s.choose(s.wide_above(high, h), high_at, place);
            (low, high) = (s.wide_min(low, h), s.wide_max(high, h));
            sum = sum + h;
            place = place + one;
        }
        let mut stored = [[0.0; WIDE_LANES]; 3];
        for (x, to) in [low, high, sum].into_iter().zip(&mut stored) {
            s.wide_store(x, to);
        }
        let [low, high, sum] = stored.map(|x| [x[0], x[1], x[2]]);
        let mut outermost = [[0.0; WIDE_LANES]; 2];
        s.wide_store(low_at, &mut outermost[0]);
        s.wide_store(high_at, &mut outermost[1]);
        Outline { middle: scaled(&sum, 1.0 / self.points.len() as f64), size: length(&sub(&high, &low)), outermost }
    }
}

/// The largest coordinate of points, whatever its sign; 0 where there is none.
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
    use crate::bounds::Aabb;
    use crate::contacts::heights::push_eights;
    use crate::simd::Level;
    use crate::vectors::{add, dot};

    #[test]
    fn outlines_are_those_a_loop_finds() {
        // Some points twice.
        let wave = |i: usize| [(0.7 * i as f64).sin() - 0.4, (1.9 * i as f64).cos(), (0.3 * i as f64).sin() - 3.0];
        let points: Vec<Point> = (0..60).map(|i| wave(i % 17)).collect();
        for level in Level::available() {
            for (from, to) in [(0, 1), (3, 5), (7, 40), (0, 60)] {
                let found = outline(level.checked(), &points, (from, to));
                let points = &points[from as usize..to as usize];
                let mut bounds = Aabb::EMPTY;
                points.iter().for_each(|p| bounds.grow(p));
                let sum = points.iter().fold([0.0; 3], |s, p| add(&s, p));
                assert_eq!(found.size, length(&bounds.extent()));
                assert_eq!(found.middle, scaled(&sum, 1.0 / points.len() as f64));
                for (i, d) in OUTERMOST.iter().enumerate() {
                    let [low, high] = found.outermost.map(|of| dot(&points[of[i] as usize], d));
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
