//! Pairs of closed polyhedra with integer corners: flush and not, turned, skewed, hollow, concave, with shared corners
//! and edges, and cut into triangles of any fineness.

use crate::blocks::{Block, Solid, Spot, Surface};
use crate::random::Random;
use crate::spots::LARGEST;

/// Units of the coordinates of the shapes: they can be cut in halves as often, and moved by as little.
const FINE: i64 = 4;

/// A kind of pair.
#[derive(Clone, Copy)]
pub struct Family {
    /// The name for `--only` and the table.
    pub name: &'static str,
    /// What it makes.
    pub about: &'static str,
    make: fn(&mut Random) -> [Surface; 2],
}

/// Every family, in the order of the table.
#[rustfmt::skip]
pub const KINDS: [Family; 9] = [
    Family { name: "lattice", about: "unions of blocks on one lattice: flush faces, shared edges and corners", make: lattice },
    Family { name: "shapes", about: "an L, a U, a frame or a hollow box, and another", make: |r| { let pair = [shape(r), shape(r)]; brought(r, pair) } },
    Family { name: "turned", about: "the same, one of them turned", make: turned },
    Family { name: "aslant", about: "the first two, all of it turned", make: aslant },
    Family { name: "skewed", about: "the first two, each or all of it skewed", make: skewed },
    Family { name: "gems", about: "octahedra cut once, with corners as far out as they like", make: |r| { let pair = [gem(r), gem(r)]; brought(r, pair) } },
    Family { name: "corners", about: "tetrahedra, many of their corners shared", make: corners },
    Family { name: "within", about: "a small solid in a large one, or in its cavity", make: within },
    Family { name: "same", about: "a solid and its copy, cut differently, or moved a little", make: same },
];

impl crate::tally::Family for Family {
    fn name(&self) -> &'static str {
        self.name
    }
}

impl Family {
    /// One of them, the same for the same numbers.
    pub fn make(&self, r: &mut Random) -> [Surface; 2] {
        loop {
            let pair = (self.make)(r).map(|surface| finished(surface, r));
            if pair.iter().flat_map(|surface| &surface.0).flatten().all(|x| x.abs() <= LARGEST / 2) {
                return pair;
            }
        }
    }
}

fn blocks(r: &mut Random, most: usize) -> Surface {
    let block = |r: &mut Random| {
        let low: Spot = [0; 3].map(|_| FINE * i64::from(r.whole(0, 3)));
        Block::new(low, low.map(|x| x + FINE * i64::from(r.whole(1, 3))))
    };
    let solid = Solid((0..1 + r.below(most)).map(|_| block(r)).collect());
    cut(&solid, r)
}

/// As coarse as may be, or finer.
fn cut(solid: &Solid, r: &mut Random) -> Surface {
    let wanted = r.pick(&[1, 1, 1, 40, 120]);
    solid.surface(wanted, r)
}

fn lattice(r: &mut Random) -> [Surface; 2] {
    let [p, q] = [blocks(r, 4), blocks(r, 3)];
    let by = if r.one_in(3) { [0; 3].map(|_| i64::from(r.whole(-2, 2))) } else { [0; 3] };
    [p, moved(q, &by)]
}

/// An L, a U, a frame, a box with a cavity, a plate or a box.
fn shape(r: &mut Random) -> Surface {
    let mut ends = [0; 3].map(|_| {
        let mut at = 0;
        [0; 4].map(|_| {
            let end = at;
            at += FINE * i64::from(r.whole(1, 3));
            end
        })
    });
    if r.one_in(4) {
        // Thin.
        ends[r.below(3)] = [0, 1, 2, 3];
    }
    let block = |x: [usize; 2], y: [usize; 2], z: [usize; 2]| {
        let of = |a: usize, i: [usize; 2]| i.map(|i| ends[a][i]);
        let [x, y, z] = [of(0, x), of(1, y), of(2, z)];
        Block::new([x[0], y[0], z[0]], [x[1], y[1], z[1]])
    };
    let (l, all) = ([block([0, 3], [0, 1], [0, 3]), block([0, 1], [0, 3], [0, 3])], [0, 3]);
    let solid = match r.below(6) {
        0 => vec![block(all, all, all)],
        1 => l.to_vec(),
        2 => vec![l[0], l[1], block([2, 3], all, all)],
        3 => vec![l[0], l[1], block([2, 3], all, all), block(all, [2, 3], all)],
        4 => vec![l[0], l[1], block([0, 3], all, [0, 1])],
        _ => {
            let around = [l[0], l[1], block([2, 3], all, all), block(all, [2, 3], all)];
            around.into_iter().chain([block(all, all, [0, 1]), block(all, all, [2, 3])]).collect()
        }
    };
    cut(&Solid(solid), r)
}

/// The second brought to the first: some corner of it to some corner, or near to it.
fn brought(r: &mut Random, [p, q]: [Surface; 2]) -> [Surface; 2] {
    let (at, of) = (p.0[r.below(p.0.len())], q.0[r.below(q.0.len())]);
    let size = p.0.iter().flatten().map(|x| x.abs()).max().unwrap_or(1).min(1 << 20) as i32;
    let reach = r.pick(&[0, 1, size / 4, size / 2]);
    let by = [0, 1, 2].map(|a| at[a] - of[a] + i64::from(r.whole(-reach, reach)));
    [p, moved(q, &by)]
}

fn moved((corners, faces): Surface, by: &Spot) -> Surface {
    (corners.into_iter().map(|p| [0, 1, 2].map(|a| p[a] + by[a])).collect(), faces)
}

fn mapped((corners, mut faces): Surface, m: &[Spot; 3]) -> Surface {
    if determinant(m) < 0 {
        faces.iter_mut().for_each(|f| f.swap(1, 2));
    }
    (corners.into_iter().map(|p| m.map(|row| (0..3).map(|a| row[a] * p[a]).sum())).collect(), faces)
}

fn determinant([a, b, c]: &[Spot; 3]) -> i64 {
    a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) + a[2] * (b[0] * c[1] - b[1] * c[0])
}

/// A turn times a whole number, and that number: by a quaternion of whole numbers.
fn turn(r: &mut Random) -> ([Spot; 3], i64) {
    let [w, x, y, z] = loop {
        let q = [0; 4].map(|_| i64::from(r.whole(-2, 2)));
        if q.iter().filter(|x| **x != 0).count() > 1 {
            break q;
        }
    };
    let (ww, xx, yy, zz) = (w * w, x * x, y * y, z * z);
    let rows = [
        [ww + xx - yy - zz, 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), ww - xx + yy - zz, 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), ww - xx - yy + zz],
    ];
    (rows, ww + xx + yy + zz)
}

fn times(n: i64) -> [Spot; 3] {
    [[n, 0, 0], [0, n, 0], [0, 0, n]]
}

fn turned(r: &mut Random) -> [Surface; 2] {
    let ((m, size), p, q) = (turn(r), shape(r), shape(r));
    let pair = [mapped(p, &times(size)), mapped(q, &m)];
    brought(r, pair)
}

fn on_axes(r: &mut Random) -> [Surface; 2] {
    if r.one_in(2) {
        lattice(r)
    } else {
        let pair = [shape(r), shape(r)];
        brought(r, pair)
    }
}

fn aslant(r: &mut Random) -> [Surface; 2] {
    let (m, _) = turn(r);
    on_axes(r).map(|surface| mapped(surface, &m))
}

fn skew(r: &mut Random) -> [Spot; 3] {
    loop {
        let m = [[0; 3]; 3].map(|row: [i64; 3]| row.map(|_| i64::from(r.whole(-3, 3))));
        if determinant(&m) != 0 {
            return m;
        }
    }
}

fn skewed(r: &mut Random) -> [Surface; 2] {
    let (m, pair) = (skew(r), on_axes(r));
    if r.one_in(2) {
        return pair.map(|surface| mapped(surface, &m));
    }
    let [p, q] = pair;
    let pair = [mapped(p, &m), mapped(q, &skew(r))];
    brought(r, pair)
}

/// Of eight faces in four triangles each; seen from the middle every corner is where it was.
fn gem(r: &mut Random) -> Surface {
    let ends = [[1, 0, 0], [0, 1, 0], [0, 0, 1]];
    let (mut corners, mut faces): Surface = Default::default();
    let mut number = |p: Spot, r: &mut Random, all: &mut Vec<(Spot, u32)>| {
        if let Some((_, known)) = all.iter().find(|(known, _)| *known == p) {
            return *known;
        }
        let out = FINE / 2 * i64::from(r.whole(1, 5));
        corners.push(p.map(|x| x * out));
        all.push((p, corners.len() as u32 - 1));
        corners.len() as u32 - 1
    };
    let mut known = Vec::new();
    for octant in 0..8 {
        let sign = [0, 1, 2].map(|a| if octant >> a & 1 == 1 { -1 } else { 1 });
        let end = ends.map(|e: Spot| [0, 1, 2].map(|a| 2 * e[a] * sign[a]));
        let middle = |i: usize, j: usize| [0, 1, 2].map(|a| (end[i][a] + end[j][a]) / 2);
        let six = [end[0], end[1], end[2], middle(0, 1), middle(1, 2), middle(2, 0)];
        let [a, b, c, ab, bc, ca] = six.map(|p| number(p, r, &mut known));
        let mut four = [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]];
        if sign[0] * sign[1] * sign[2] < 0 {
            four.iter_mut().for_each(|f| f.swap(1, 2));
        }
        faces.extend(four);
    }
    (corners, faces)
}

fn tetrahedron(mut corners: [Spot; 4]) -> Option<Surface> {
    let side = |i: usize| [0, 1, 2].map(|a| corners[i][a] - corners[0][a]);
    let volume = determinant(&[side(1), side(2), side(3)]);
    if volume < 0 {
        corners.swap(1, 2);
    }
    (volume != 0).then(|| (corners.to_vec(), vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]))
}

fn corners(r: &mut Random) -> [Surface; 2] {
    let reach = r.pick(&[2, 3, 8]);
    let spot = |r: &mut Random| [0; 3].map(|_| FINE * i64::from(r.whole(-reach, reach)));
    loop {
        let p = [0; 4].map(|_| spot(r));
        let mut q = [0; 4].map(|_| spot(r));
        let shared = r.below(4);
        q[..shared].copy_from_slice(&p[..shared]);
        if let (Some(p), Some(q)) = (tetrahedron(p), tetrahedron(q)) {
            return [p, q];
        }
    }
}

fn within(r: &mut Random) -> [Surface; 2] {
    let small = if r.one_in(2) { gem(r) } else { shape(r) };
    let (m, size) = turn(r);
    let large = mapped(shape(r), &times(FINE * r.pick(&[1, size])));
    let small = if r.one_in(2) { mapped(small, &m) } else { small };
    brought(r, [large, small])
}

fn same(r: &mut Random) -> [Surface; 2] {
    let surface = match r.below(3) {
        0 => gem(r),
        1 => shape(r),
        _ => blocks(r, 3),
    };
    let m = if r.one_in(2) { turn(r).0 } else { times(1) };
    let by = if r.one_in(2) { [0; 3] } else { [0; 3].map(|_| i64::from(r.whole(-1, 1))) };
    [surface.clone(), moved(surface, &by)].map(|surface| mapped(surface, &m))
}

/// Larger, so that it can be cut, and perhaps cut, and seldom wound the other way.
fn finished(surface: Surface, r: &mut Random) -> Surface {
    let mut surface = mapped(surface, &times(FINE));
    for _ in 0..2 {
        surface = match r.below(5) {
            0 if surface.1.len() <= 60 => in_four(surface),
            1 => cracked(surface, r),
            _ => surface,
        };
    }
    if r.one_in(6) {
        surface.1.iter_mut().for_each(|f| f.swap(1, 2));
    }
    surface
}

/// Every triangle in four.
fn in_four((mut corners, faces): Surface) -> Surface {
    let mut middles = std::collections::HashMap::new();
    let mut middle = |p: u32, q: u32| {
        *middles.entry((p.min(q), p.max(q))).or_insert_with(|| {
            let [p, q] = [p, q].map(|v| corners[v as usize]);
            corners.push([0, 1, 2].map(|a| (p[a] + q[a]) / 2));
            corners.len() as u32 - 1
        })
    };
    let mut four = Vec::with_capacity(4 * faces.len());
    for [a, b, c] in faces {
        let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
        four.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
    }
    (corners, four)
}

/// Some triangles in two, and not their neighbours.
fn cracked((mut corners, faces): Surface, r: &mut Random) -> Surface {
    let mut cut = Vec::with_capacity(2 * faces.len());
    for f in faces {
        if !r.one_in(4) {
            cut.push(f);
            continue;
        }
        let k = r.below(3);
        let [a, b, c] = [f[k], f[(k + 1) % 3], f[(k + 2) % 3]];
        let [p, q] = [a, b].map(|v| corners[v as usize]);
        corners.push([0, 1, 2].map(|a| (p[a] + q[a]) / 2));
        let m = corners.len() as u32 - 1;
        cut.extend([[a, m, c], [m, b, c]]);
    }
    (corners, cut)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sixths((corners, faces): &Surface) -> i64 {
        faces.iter().map(|f| determinant(&f.map(|v| corners[v as usize]))).sum()
    }

    #[test]
    fn all_are_closed_and_keep_their_volume_when_they_are_cut() {
        for (n, family) in KINDS.iter().enumerate() {
            let mut r = Random::new(n as u64);
            for _ in 0..100 {
                for surface in (family.make)(&mut r) {
                    let volume = sixths(&surface);
                    assert!(volume > 0, "{}", family.name);
                    for cut in [
                        in_four(mapped(surface.clone(), &times(2))),
                        cracked(mapped(surface.clone(), &times(2)), &mut r),
                    ] {
                        assert_eq!(sixths(&cut), 8 * volume, "{}", family.name);
                        // The sum of all areas, each with its direction, is nothing.
                        let area = |a: usize| -> i64 {
                            let (b, c) = ((a + 1) % 3, (a + 2) % 3);
                            let of = |f: &[u32; 3]| {
                                let [p, q, s] = f.map(|v| cut.0[v as usize]);
                                (q[b] - p[b]) * (s[c] - p[c]) - (q[c] - p[c]) * (s[b] - p[b])
                            };
                            cut.1.iter().map(of).sum()
                        };
                        assert_eq!([area(0), area(1), area(2)], [0; 3], "{}", family.name);
                    }
                }
            }
        }
    }
}
