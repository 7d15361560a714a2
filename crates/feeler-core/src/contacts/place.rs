//! Which triangles belong to one patch.

use crate::bounds::Point;
use crate::contacts::heights::Eight;
use crate::contacts::patches::{Patch, Piece};
use crate::simd::{Checked, Kernel, Simd, WIDE_LANES};
use crate::vectors::{dot, length, sub};

/// Triangles whose normals are within this angle of the first one's (cosine of 2.5 degrees) may share a patch: on a curved
/// surface of radius r that is off by r/1000.
const ONE_PATCH: f64 = 0.999_05;

/// Normals this close (1 - cosine) are of one plane.
const ONE_PLANE: f64 = 1e-9;

/// Most patches of a surface in one zone. Further triangles join the patch with the nearest normal.
const MOST_PATCHES: usize = 96;

/// Normals of patches in eights, by axis; what lies beyond the last is zero.
pub(crate) type Normals = Vec<Eight>;

/// Finds or founds the patch of each piece, one after the other. The normals are working memory.
pub(crate) fn place(lanes: Checked, pieces: &mut [Piece], patches: &mut Vec<Patch>, normals: &mut Normals) {
    lanes.run(Placing { pieces, patches, normals });
}

struct Placing<'a> {
    pieces: &'a mut [Piece],
    patches: &'a mut Vec<Patch>,
    normals: &'a mut Normals,
}

impl Kernel for Placing<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, s: S) {
        let Placing { pieces, patches, normals } = self;
        patches.clear();
        normals.clear();
        for piece in pieces {
            let n = piece.normal;
            let place = match first_fit(s, piece, patches, normals) {
                Some(i) => i,
                None if patches.len() >= MOST_PATCHES => nearest(&n, patches),
                None => {
                    let (i, lane) = (patches.len(), patches.len() % WIDE_LANES);
                    if lane == 0 {
                        normals.push(Eight::default());
                    }
                    for a in 0..3 {
                        normals[i / WIDE_LANES][a][lane] = n[a];
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

/// The first patch that a piece fits.
#[inline(always)]
fn first_fit<S: Simd>(s: S, piece: &Piece, patches: &[Patch], normals: &Normals) -> Option<usize> {
    let n = piece.normal;
    let n = [s.wide_splat(n[0]), s.wide_splat(n[1]), s.wide_splat(n[2])];
    let (one, most) = (s.wide_splat(1.0), s.wide_splat(1.0 - ONE_PATCH));
    for (i, of) in normals.iter().enumerate() {
        let along = s.wide_load(&of[0]) * n[0] + s.wide_load(&of[1]) * n[1] + s.wide_load(&of[2]) * n[2];
        let mut near = !s.bits(s.wide_above(one - along, most));
        while near != 0 {
            let k = WIDE_LANES * i + near.trailing_zeros() as usize;
            if k < patches.len() && is_passing(piece, &patches[k]) {
                return Some(k);
            }
            near &= near - 1;
        }
    }
    None
}

/// Whether the plane of one passes the other as near as a surface that turns so much would.
#[inline(always)]
fn is_passing(piece: &Piece, patch: &Patch) -> bool {
    let turn = 1.0 - dot(&patch.normal, &piece.normal);
    let way = sub(&piece.at, &patch.at);
    let far = length(&way);
    let off = dot(&way, &patch.normal).abs();
    let largest = piece.at[0].abs().max(piece.at[1].abs()).max(piece.at[2].abs());
    off <= 1e-6 * far + 1e-12 * largest + far * (2.0 * turn.max(0.0)).sqrt()
}

/// The patch with the nearest normal, the last of several.
#[inline(always)]
fn nearest(n: &Point, patches: &[Patch]) -> usize {
    let (mut best, mut at) = (f64::NEG_INFINITY, 0);
    for (i, patch) in patches.iter().enumerate() {
        let along = dot(&patch.normal, n);
        if along >= best {
            (best, at) = (along, i);
        }
    }
    at
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simd::Level;
    use crate::vectors::unit;

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
            let (mut found, mut normals) = (Vec::new(), Normals::new());
            for level in Level::available() {
                let mut placed = pieces();
                place(level.checked(), &mut placed, &mut found, &mut normals);
                let of = |pieces: &[Piece]| pieces.iter().map(|p| p.patch).collect::<Vec<_>>();
                assert_eq!(of(&placed), of(&expected), "{level:?} {count}");
                let what = |p: &Patch| (p.normal, p.at, p.flat);
                assert!(found.iter().map(what).eq(patches.iter().map(what)), "{level:?} {count}");
            }
        }
    }
}
