//! Which triangles belong to one patch.

use crate::bounds::Point;
use crate::contacts::heights::{eight_heights, Eight};
use crate::contacts::patches::{Patch, Piece};
use crate::simd::{Checked, Kernel, Simd, Wide, LANES, WIDE_LANES};
use crate::vectors::dot;

/// Triangles whose normals are within this angle of the first one's (cosine of 3 degrees) may share a patch: on a curved
/// surface of radius r that is off by r/700.
const ONE_PATCH: f64 = 0.998_63;

/// Normals this close (1 - cosine) are of one plane.
const ONE_PLANE: f64 = 1e-9;

/// Share of their distance by which the planes of one surface may miss each other by rounding.
const ROUNDING: f64 = 1e-6;

/// By which the cosine of the angle between two normals may be off in float32, and more.
const NARROW: f64 = 2e-6;

/// Most patches of a surface in one zone, a multiple of the lanes. Further triangles join the patch with the nearest normal.
const MOST_PATCHES: usize = 6 * LANES;
const _: () = assert!(MOST_PATCHES <= u128::BITS as usize);

/// The planes of sixteen patches, by axis; what lies beyond the last has a normal of zero.
#[derive(Debug, Default)]
pub(crate) struct Planes {
    /// The normals in float32, by which most patches fall away.
    narrow: [[f32; LANES]; 3],
    eights: [EightPlanes; LANES / WIDE_LANES],
}

#[derive(Debug, Default)]
struct EightPlanes {
    normal: Eight,
    at: Eight,
}

/// Finds or founds the patch of each piece, one after the other. The planes are working memory.
pub(crate) fn place(lanes: Checked, pieces: &mut [Piece], patches: &mut Vec<Patch>, planes: &mut Vec<Planes>) {
    lanes.run(Placing { pieces, patches, planes });
}

struct Placing<'a> {
    pieces: &'a mut [Piece],
    patches: &'a mut Vec<Patch>,
    planes: &'a mut Vec<Planes>,
}

impl Kernel for Placing<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, s: S) {
        let Placing { pieces, patches, planes } = self;
        patches.clear();
        planes.clear();
        for piece in pieces {
            let n = piece.normal;
            let place = match first_fit(s, piece, planes) {
                Some(i) => i,
                None if patches.len() >= MOST_PATCHES => nearest(s, &n, planes),
                None => {
                    let i = patches.len();
                    if i.is_multiple_of(LANES) {
                        planes.push(Planes::default());
                    }
                    let Planes { narrow, eights } = &mut planes[i / LANES];
                    let (eight, lane) = (&mut eights[i % LANES / WIDE_LANES], i % WIDE_LANES);
                    for a in 0..3 {
                        (eight.normal[a][lane], eight.at[a][lane]) = (n[a], piece.at[a]);
                        narrow[a][i % LANES] = n[a] as f32;
                    }
                    patches.push(Patch::new(n, piece.at));
                    i
                }
            };
            patches[place].flat &= 1.0 - dot(&patches[place].normal, &n) <= ONE_PLANE;
            piece.patch = place as u32;
        }
    }
}

/// The first patch that a piece fits: of nearly its normal, and one's plane passes the other as near as a surface that turns so
/// much would.
///
/// All normals are compared first, in float32 and without a branch: which of them are near is not to be foreseen.
#[inline(always)]
fn first_fit<S: Simd>(s: S, piece: &Piece, planes: &[Planes]) -> Option<usize> {
    let (n, at) = (&piece.normal, &piece.at);
    let narrow = [s.splat(n[0] as f32), s.splat(n[1] as f32), s.splat(n[2] as f32)];
    let least = s.splat((ONE_PATCH - NARROW) as f32);
    let mut near = 0u128;
    for (i, Planes { narrow: m, .. }) in planes.iter().enumerate() {
        let along = s.load(&m[0]) * narrow[0] + s.load(&m[1]) * narrow[1] + s.load(&m[2]) * narrow[2];
        near |= u128::from(!s.lanes(s.above(least, along))) << (LANES * i);
    }
    let n = [s.wide_splat(n[0]), s.wide_splat(n[1]), s.wide_splat(n[2])];
    let (zero, one, most) = (s.wide_splat(0.0), s.wide_splat(1.0), s.wide_splat(1.0 - ONE_PATCH));
    let rounding = s.wide_splat(1e-12 * at[0].abs().max(at[1].abs()).max(at[2].abs()));
    while near != 0 {
        let i = near.trailing_zeros() as usize / WIDE_LANES;
        let eight = &planes[WIDE_LANES * i / LANES].eights[i % (LANES / WIDE_LANES)];
        let turn = one - eight_heights(s, &eight.normal, &n);
        let mut way = n;
        for a in 0..3 {
            way[a] = s.wide_splat(at[a]) - s.wide_load(&eight.at[a]);
        }
        let square = way[0] * way[0] + way[1] * way[1] + way[2] * way[2];
        let off = s.wide_max(s.wide_abs(eight_heights(s, &eight.normal, &way)) - rounding, zero);
        let turned = s.wide_max(turn, zero) * s.wide_splat(2.0) + s.wide_splat(ROUNDING * ROUNDING);
        let fits = !s.bits(s.either(s.wide_above(turn, most), s.wide_above(off * off, square * turned)));
        if fits != 0 {
            return Some(WIDE_LANES * i + fits.trailing_zeros() as usize);
        }
        near &= !(u128::from(u8::MAX) << (WIDE_LANES * i));
    }
    None
}

/// The patch with the nearest normal, the last of several. All lanes have one.
#[inline(always)]
fn nearest<S: Simd>(s: S, n: &Point, planes: &[Planes]) -> usize {
    let n = [s.wide_splat(n[0]), s.wide_splat(n[1]), s.wide_splat(n[2])];
    let (mut best, mut at) = (s.wide_splat(f64::NEG_INFINITY), s.wide_splat(0.0));
    let (mut place, eights) = (s.wide_splat(0.0), s.wide_splat(WIDE_LANES as f64));
    for Planes { eights: two, .. } in planes {
        for eight in two {
            let along = eight_heights(s, &eight.normal, &n);
            at = s.choose(s.wide_above(best, along), at, place);
            best = s.wide_max(best, along);
            place = place + eights;
        }
    }
    let (mut nearest, mut places) = (Wide::default(), Wide::default());
    s.wide_store(best, &mut nearest);
    s.wide_store(at, &mut places);
    let mut most = f64::NEG_INFINITY;
    for along in *nearest {
        most = if along > most { along } else { most };
    }
    // No branch: which lane it is is not to be foreseen.
    let mut last = 0;
    for lane in 0..WIDE_LANES {
        let k = places[lane] as usize + lane;
        last = last.max(if nearest[lane] == most { k } else { 0 });
    }
    last
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simd::Level;
    use crate::vectors::{add, cross, scaled, sub, unit};

    fn is_passing(piece: &Piece, patch: &Patch) -> bool {
        let turn = (1.0 - dot(&patch.normal, &piece.normal)).max(0.0);
        let way = sub(&piece.at, &patch.at);
        let rounding = 1e-12 * piece.at.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        let off = (dot(&way, &patch.normal).abs() - rounding).max(0.0);
        off * off <= dot(&way, &way) * (2.0 * turn + ROUNDING * ROUNDING)
    }

    /// The same, patch by patch.
    fn plainly_placed(pieces: &mut [Piece]) -> Vec<Patch> {
        let mut patches: Vec<Patch> = Vec::new();
        for piece in pieces {
            let fits = |p: &Patch| 1.0 - dot(&p.normal, &piece.normal) <= 1.0 - ONE_PATCH && is_passing(piece, p);
            let along = |i: &usize| dot(&patches[*i].normal, &piece.normal);
            let i = match patches.iter().position(fits) {
                Some(i) => i,
                None if patches.len() >= MOST_PATCHES => {
                    (0..patches.len()).max_by(|i, j| along(i).total_cmp(&along(j))).unwrap()
                }
                None => {
                    patches.push(Patch::new(piece.normal, piece.at));
                    patches.len() - 1
                }
            };
            patches[i].flat &= 1.0 - dot(&patches[i].normal, &piece.normal) <= ONE_PLANE;
            piece.patch = i as u32;
        }
        patches
    }

    #[test]
    fn pieces_go_where_a_plain_loop_puts_them() {
        // On planes through a few places, some turned a little, and more directions than there may be patches.
        let wave = |i: usize| [(0.7 * i as f64).sin(), (1.9 * i as f64).cos(), (0.3 * i as f64).sin()];
        for (count, directions) in [(0, 1), (1, 1), (40, 5), (200, 23), (700, 400)] {
            let normal = |i: usize| {
                let (n, by) = (wave(7 * (i % directions)), 0.01 * (i % 3) as f64);
                unit(&[n[0] + by, n[1], n[2]]).unwrap()
            };
            let pieces = || -> Vec<Piece> {
                (0..count).map(|i| Piece::new(i as u32, normal(i), wave(i % 11), (0, 0), true)).collect()
            };
            let mut expected = pieces();
            let patches = plainly_placed(&mut expected);
            assert!(directions < 400 || patches.len() == MOST_PATCHES);
            let (mut found, mut planes) = (Vec::new(), Vec::new());
            for level in Level::available() {
                let mut placed = pieces();
                place(level.checked(), &mut placed, &mut found, &mut planes);
                let of = |pieces: &[Piece]| pieces.iter().map(|p| p.patch).collect::<Vec<_>>();
                assert_eq!(of(&placed), of(&expected), "{level:?} {count}");
                let what = |p: &Patch| (p.normal, p.at, p.flat);
                assert!(found.iter().map(what).eq(patches.iter().map(what)), "{level:?} {count}");
            }
        }
    }

    #[test]
    fn what_is_near_by_less_than_float32_tells_is_judged_in_float64() {
        // Around a first triangle others, turned by as much as is still near, a little less and a little more.
        let wave = |i: usize| [(0.7 * i as f64).sin(), (1.9 * i as f64).cos(), (0.3 * i as f64).sin()];
        let (mut within, mut beyond) = (0, 0);
        for first in (0..60).map(|i| unit(&wave(i)).unwrap()) {
            let across = unit(&cross(&first, &[0.3, -0.2, 0.9])).unwrap();
            let turned = |k: usize| {
                let angle = ONE_PATCH.acos() + 1e-8 * (k as f64 - 20.0);
                unit(&add(&scaled(&first, angle.cos()), &scaled(&across, angle.sin()))).unwrap()
            };
            for k in 0..40 {
                let pieces = || [first, turned(k)].map(|n| Piece::new(0, n, [0.0; 3], (0, 0), true));
                let mut expected = pieces();
                plainly_placed(&mut expected);
                *(if expected[1].patch == 0 { &mut within } else { &mut beyond }) += 1;
                for level in Level::available() {
                    let mut placed = pieces();
                    place(level.checked(), &mut placed, &mut Vec::new(), &mut Vec::new());
                    assert_eq!(placed[1].patch, expected[1].patch, "{level:?} {k}");
                }
            }
        }
        assert!(within > 1000 && beyond > 1000, "{within} {beyond}");
    }
}
