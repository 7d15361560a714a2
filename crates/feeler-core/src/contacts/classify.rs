//! On which side of the other surface the corners of cut triangles are.

use crate::bounds::Point;
use crate::contacts::zones::{Zones, MOCKUP, TOOL};
use crate::contacts::Ground;
use crate::simd::{Checked, Kernel, Simd, WIDE_LANES};

/// The nearest cut tells on which side a corner is. Where two are equally near, at an edge of the other surface, the one whose
/// line the corner stands off most steeply, in the plane of the triangle: there the two lines are a bend of the curve, and the
/// corner is on the outer side of it. Where a surface turns away within a triangle's length the nearest cut may be wrong about a
/// far corner: outside the other solid's box it is outside.
pub(crate) fn classify(ground: &Ground<'_>, part: u32, zones: &mut Zones) {
    let Zones { faces, cuts, points, .. } = zones;
    for (i, cut) in cuts.iter().enumerate().filter(|(_, c)| !c.flat) {
        let [p, q] = [TOOL, MOCKUP].map(|w| &faces[w][cut.faces[w] as usize]);
        let ends = [points[cut.points.0 as usize], points[cut.points.0 as usize + 1]];
        let seen = see(ground.lanes, [&p.corners, &q.corners], [&p.normal, &q.normal], &ends);
        for w in [TOOL, MOCKUP] {
            let face = &mut faces[w][cut.faces[w] as usize];
            for k in 0..3 {
                let (square, height) = (seen.square[3 * w + k], seen.height[3 * w + k]);
                if square > face.square[k] * (1.0 + 1e-9) {
                    continue;
                }
                let (steepness, is_on) = match square > 0.0 {
                    true => (seen.off[3 * w + k] / square, height * height < 1e-18 * square),
                    false => (0.0, true),
                };
                let tie = square >= face.square[k] * (1.0 - 1e-9);
                if if tie { steepness > face.steepness[k] } else { square < face.square[k] } {
                    face.square[k] = square;
                    face.steepness[k] = steepness;
                    face.nearest[k] = i as u32;
                    face.side[k] = if is_on {
                        0
                    } else if height < 0.0 {
                        -1
                    } else {
                        1
                    };
                }
            }
        }
    }
    for w in [TOOL, MOCKUP] {
        for i in 0..faces[w].len() {
            for k in 0..3 {
                let face = &faces[w][i];
                if face.side[k] < 0 {
                    let other = cuts[face.nearest[k] as usize].faces[1 - w];
                    if faces[1 - w][other as usize].closed && !ground.may_enclose(1 - w, part, &face.corners[k]) {
                        faces[w][i].side[k] = 1;
                    }
                }
            }
        }
    }
}

/// How the six corners of two triangles lie to the segment that they share.
struct Seen {
    /// Squares of their distances from it.
    square: [f64; WIDE_LANES],
    /// Their heights over the other triangle's plane.
    height: [f64; WIDE_LANES],
    /// Squares of their distances off its line: in their own triangle's plane, as that other plane may be met at any angle.
    off: [f64; WIDE_LANES],
}

fn see(lanes: Checked, corners: [&[Point; 3]; 2], normals: [&Point; 2], ends: &[Point; 2]) -> Seen {
    lanes.run(See { corners, normals, ends })
}

struct See<'a> {
    corners: [&'a [Point; 3]; 2],
    normals: [&'a Point; 2],
    ends: &'a [Point; 2],
}

impl Kernel for See<'_> {
    type Output = Seen;

    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> Seen {
        let ([[p, q, r], [x, y, z]], [n, m]) = (self.corners, self.normals);
        let (at, n) = (s.wide_points([p, q, r, x, y, z, z, z]), s.wide_points([m, m, m, n, n, n, n, n]));
        let [a, b] = self.ends;
        let line = [b[0] - a[0], b[1] - a[1], b[2] - a[2]];
        let lengths = s.wide_splat(line[0] * line[0] + line[1] * line[1] + line[2] * line[2]);
        let (zero, one) = (s.wide_splat(0.0), s.wide_splat(1.0));
        let line = [s.wide_splat(line[0]), s.wide_splat(line[1]), s.wide_splat(line[2])];
        let from = [at[0] - s.wide_splat(a[0]), at[1] - s.wide_splat(a[1]), at[2] - s.wide_splat(a[2])];
        let height = from[0] * n[0] + from[1] * n[1] + from[2] * n[2];
        let is_long = s.wide_above(lengths, zero);
        let along = from[0] * line[0] + from[1] * line[1] + from[2] * line[2];
        let share = s.choose(is_long, s.wide_divide(along, lengths), zero);
        let share = s.wide_min(s.wide_max(share, zero), one);
        let way = [from[0] - share * line[0], from[1] - share * line[1], from[2] - share * line[2]];
        let square = way[0] * way[0] + way[1] * way[1] + way[2] * way[2];
        let across = [
            from[1] * line[2] - from[2] * line[1],
            from[2] * line[0] - from[0] * line[2],
            from[0] * line[1] - from[1] * line[0],
        ];
        let off = across[0] * across[0] + across[1] * across[1] + across[2] * across[2];
        let off = s.choose(is_long, s.wide_divide(off, lengths), height * height);
        let mut seen = Seen { square: [0.0; WIDE_LANES], height: [0.0; WIDE_LANES], off: [0.0; WIDE_LANES] };
        s.wide_store(square, &mut seen.square);
        s.wide_store(height, &mut seen.height);
        s.wide_store(off, &mut seen.off);
        seen
    }
}
