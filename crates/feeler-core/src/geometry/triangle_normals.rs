//! The unit normals of eight triangles at once, each by the cross product of two edges.

use crate::constants::PLAIN;
use crate::geometry::bounds::{Point, Triangle};
use crate::geometry::vectors::{cross, dot, normal, sub};
use feeler_lanes::{Checked, Kernel, Simd, WIDE_LANES};

/// The unit normals of up to eight triangles, as [`normal`] has them, `None` in unused lanes; and which of the
/// triangles are thinner than a length, one bit each.
pub fn eight_normals<'a>(
    lanes: Checked,
    count: usize,
    thin: f64,
    corners: impl Fn(usize) -> [&'a Point; 3],
) -> ([Option<Point>; WIDE_LANES], u8) {
    let mut found = [None; WIDE_LANES];
    if count == 0 {
        return (found, 0);
    }
    let triangles: [_; WIDE_LANES] = std::array::from_fn(|i| corners(i.min(count - 1)));
    let out = lanes.run(Normals { triangles: &triangles, thin });
    for (i, found) in found.iter_mut().enumerate().take(count) {
        let is_plain = out.plain >> i & 1 != 0;
        *found =
            if is_plain { Some(std::array::from_fn(|a| out.normal[a][i])) } else { normal(&triangles[i].map(|x| *x)) };
    }
    (found, out.thin & u8::MAX >> (WIDE_LANES - count))
}

/// Whether a triangle's height over its longest edge is less than a length.
pub fn is_thin(t: &Triangle, thin: f64) -> bool {
    let (e, f) = (sub(&t[1], &t[0]), sub(&t[2], &t[0]));
    let (g, n) = (sub(&f, &e), cross(&e, &f));
    let longest = dot(&e, &e).max(dot(&f, &f)).max(dot(&g, &g));
    dot(&n, &n) < thin * thin * longest
}

struct Normals<'a> {
    triangles: &'a [[&'a Point; 3]; WIDE_LANES],
    thin: f64,
}

struct Found {
    /// By axis and lane.
    normal: [[f64; WIDE_LANES]; 3],
    /// Where squares are far from the limits of float64.
    plain: u8,
    /// Whose height over the longest edge is less.
    thin: u8,
}

impl Kernel for Normals<'_> {
    type Output = Found;

    /// The same steps in the same order as [`normal`], so the same numbers.
    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> Found {
        let mut corners = [[&[0.0; 3]; WIDE_LANES]; 3];
        for (i, t) in self.triangles.iter().enumerate() {
            for c in 0..3 {
                corners[c][i] = t[c];
            }
        }
        let [a, b, c] = [s.wide_points(corners[0]), s.wide_points(corners[1]), s.wide_points(corners[2])];
        let e = [b[0] - a[0], b[1] - a[1], b[2] - a[2]];
        let f = [c[0] - a[0], c[1] - a[1], c[2] - a[2]];
        let n = [e[1] * f[2] - e[2] * f[1], e[2] * f[0] - e[0] * f[2], e[0] * f[1] - e[1] * f[0]];
        let square = n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
        let g = [f[0] - e[0], f[1] - e[1], f[2] - e[2]];
        let e_square = e[0] * e[0] + e[1] * e[1] + e[2] * e[2];
        let f_square = f[0] * f[0] + f[1] * f[1] + f[2] * f[2];
        let product = e_square * f_square;
        let longest = s.wide_max(s.wide_max(e_square, f_square), g[0] * g[0] + g[1] * g[1] + g[2] * g[2]);
        let thin = s.wide_above(s.wide_splat(self.thin * self.thin) * longest, square);
        let (least, limit) = (s.wide_splat(PLAIN.start), s.wide_splat(PLAIN.end));
        // NaN is neither above nor below.
        let (above, below) = (
            s.both(s.wide_above(square, least), s.wide_above(product, least)),
            s.both(s.wide_above(limit, square), s.wide_above(limit, product)),
        );
        let mut scale = [0.0; WIDE_LANES];
        s.wide_store(square, &mut scale);
        for x in &mut scale {
            *x = 1.0 / x.sqrt();
        }
        let scale = s.wide_load(&scale);
        let mut normal = [[0.0; WIDE_LANES]; 3];
        for a in 0..3 {
            s.wide_store(n[a] * scale, &mut normal[a]);
        }
        Found { normal, plain: s.bits(s.both(above, below)), thin: s.bits(thin) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use feeler_lanes::Level;
    use proptest::prelude::*;

    fn triangle() -> impl Strategy<Value = Triangle> {
        let coordinate = prop_oneof![-4.0f64..4.0, (-4i32..5).prop_map(f64::from), Just(1e-80), Just(-1e90)];
        prop::array::uniform3(prop::array::uniform3(coordinate))
    }

    proptest! {
        #[test]
        fn every_level_gives_what_one_at_a_time_gives(
            triangles in prop::collection::vec(triangle(), 0..9),
            thin in prop_oneof![Just(0.0), 1e-3..3.0f64],
        ) {
            for level in Level::available() {
                let (found, are_thin) = eight_normals(level.checked(), triangles.len(), thin, |i| triangles[i].each_ref());
                for (i, found) in found.iter().enumerate() {
                    prop_assert_eq!(*found, triangles.get(i).and_then(normal), "{:?} {}", level, i);
                    let expected = triangles.get(i).is_some_and(|t| is_thin(t, thin));
                    prop_assert_eq!(are_thin >> i & 1 != 0, expected, "{:?} {}", level, i);
                }
            }
        }
    }
}
