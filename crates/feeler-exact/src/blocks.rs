//! Solids made of axis-aligned blocks with integer corners: their surfaces cut into triangles, and the exact distance
//! that one must move to leave another.

use std::collections::HashMap;

use crate::random::Random;

/// A place, or a way, in whole units.
pub type Spot = [i64; 3];

/// A block, longer than nothing along each axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Block {
    /// Lowest corner.
    pub low: Spot,
    /// Highest corner.
    pub high: Spot,
}

impl Block {
    /// Between two corners.
    pub fn new(low: Spot, high: Spot) -> Block {
        debug_assert!((0..3).all(|a| low[a] < high[a]), "{low:?} {high:?}");
        Block { low, high }
    }

    /// Where it is after a way.
    pub fn moved(&self, by: &Spot) -> Block {
        let there = |p: &Spot| [0, 1, 2].map(|a| p[a] + by[a]);
        Block { low: there(&self.low), high: there(&self.high) }
    }

    /// Whether a way leads strictly into it.
    fn has(&self, p: &Spot) -> bool {
        (0..3).all(|a| self.low[a] < p[a] && p[a] < self.high[a])
    }

    /// Square of its distance from the origin.
    fn square_from_origin(&self) -> i128 {
        square(&[0, 1, 2].map(|a| self.low[a].max(-self.high[a]).max(0)))
    }
}

/// The union of some blocks.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Solid(pub Vec<Block>);

/// Corners and triangles, wound so that their normals look outward.
pub type Surface = (Vec<Spot>, Vec<[u32; 3]>);

impl Solid {
    /// The border of the union, every edge shared by two triangles, cut until there are at least `wanted` triangles, or no
    /// longer pieces than units; each rectangle along either of its diagonals.
    pub fn surface(&self, wanted: usize, r: &mut Random) -> Surface {
        let lines: [Vec<i64>; 3] = [0, 1, 2].map(|a| {
            let mut all: Vec<i64> = self.0.iter().flat_map(|b| [b.low[a], b.high[a]]).collect();
            all.sort_unstable();
            all.dedup();
            all
        });
        let longest = lines.iter().map(|l| l[l.len() - 1] - l[0]).max().unwrap_or(1);
        let mut piece = longest;
        loop {
            let surface = self.cut(&lines, piece, r);
            if surface.1.len() >= wanted || piece == 1 {
                return surface;
            }
            piece = (piece * 3 / 4).max(1);
        }
    }

    fn cut(&self, lines: &[Vec<i64>; 3], piece: i64, r: &mut Random) -> Surface {
        let is_solid = |cell: [usize; 3]| {
            let low = [0, 1, 2].map(|a| lines[a][cell[a]]);
            let high = [0, 1, 2].map(|a| lines[a][cell[a] + 1]);
            self.0.iter().any(|b| (0..3).all(|a| b.low[a] <= low[a] && high[a] <= b.high[a]))
        };
        // Between each two lines of an axis where it is cut.
        let cuts = lines.each_ref().map(|line| {
            let between = |w: &[i64]| {
                let count = ((w[1] - w[0] + piece - 1) / piece).max(1);
                (0..=count).map(|i| w[0] + (w[1] - w[0]) * i / count).collect::<Vec<_>>()
            };
            line.windows(2).map(between).collect::<Vec<_>>()
        });
        let (mut vertices, mut faces, mut numbers) = (Vec::new(), Vec::new(), HashMap::new());
        let mut number = |p: Spot| {
            *numbers.entry(p).or_insert_with(|| {
                vertices.push(p);
                vertices.len() as u32 - 1
            })
        };
        for a in 0..3 {
            let (b, c) = ((a + 1) % 3, (a + 2) % 3);
            let cells = |axis: usize| 0..lines[axis].len() - 1;
            for (i, j, k) in
                (0..lines[a].len()).flat_map(|i| cells(b).flat_map(move |j| cells(c).map(move |k| (i, j, k))))
            {
                let at = |i: usize| {
                    let mut cell = [0; 3];
                    (cell[a], cell[b], cell[c]) = (i, j, k);
                    cell
                };
                let below = i > 0 && is_solid(at(i - 1));
                let above = i + 1 < lines[a].len() && is_solid(at(i));
                if below == above {
                    continue;
                }
                for (u, v) in cuts[b][j].windows(2).flat_map(|u| cuts[c][k].windows(2).map(move |v| (u, v))) {
                    let mut corner = |s: usize, t: usize| {
                        let mut p = [0; 3];
                        (p[a], p[b], p[c]) = (lines[a][i], u[s], v[t]);
                        number(p)
                    };
                    let mut four = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
                    if above {
                        four.reverse();
                    }
                    let [p, q, s, t] = if r.one_in(2) { four } else { [four[1], four[2], four[3], four[0]] };
                    faces.extend([[p, q, s], [p, s, t]]);
                }
            }
        }
        (vertices, faces)
    }
}

/// Ways of one solid that let it overlap others, as open blocks: the Minkowski difference of each two blocks.
#[derive(Debug, Clone)]
pub struct Obstacles(Vec<Block>);

impl Obstacles {
    /// Of some solids, for another one, all as much larger on each side.
    pub fn new<'a>(solids: impl IntoIterator<Item = &'a Solid>, mover: &Solid, larger: i64) -> Obstacles {
        let difference = |a: &Block, b: &Block| Block {
            low: [0, 1, 2].map(|k| a.low[k] - b.high[k] - larger),
            high: [0, 1, 2].map(|k| a.high[k] - b.low[k] + larger),
        };
        let blocks = solids.into_iter().flat_map(|solid| &solid.0);
        Obstacles(blocks.flat_map(|a| mover.0.iter().map(move |b| difference(a, b))).collect())
    }

    /// Whether the interiors are apart after a way.
    pub fn is_free(&self, way: &Spot) -> bool {
        !self.0.iter().any(|b| b.has(way))
    }

    /// Square of the distance between the solids; 0 where they meet.
    pub fn square_distance(&self) -> i128 {
        self.0.iter().map(Block::square_from_origin).min().unwrap_or(i128::MAX)
    }

    /// The shortest way after which the interiors are apart. The free ways are a union of closed cells between the borders of the
    /// obstacles, and in each the shortest has, along each axis, the coordinate of a border or 0.
    pub fn shortest_way(&self) -> Spot {
        let lines = [0, 1, 2].map(|a| {
            let mut all: Vec<i64> = self.0.iter().flat_map(|b| [b.low[a], b.high[a]]).chain([0]).collect();
            all.sort_unstable_by_key(|x| (x.abs(), *x));
            all.dedup();
            all
        });
        let mut best: Option<(i128, Spot)> = None;
        let mut offer = |way: Spot| {
            let is_shorter = best.is_none_or(|(least, _)| square(&way) < least);
            if is_shorter && self.is_free(&way) {
                best = Some((square(&way), way));
            }
            best.map_or(i128::MAX, |(least, _)| least)
        };
        // Straight ways first, so that few of all the others are looked at.
        for (a, line) in lines.iter().enumerate() {
            for x in line {
                let mut way = [0; 3];
                way[a] = *x;
                offer(way);
            }
        }
        for x in &lines[0] {
            for y in &lines[1] {
                if square(&[*x, *y, 0]) >= offer([*x, *y, 0]) {
                    break;
                }
                for z in &lines[2] {
                    if square(&[*x, *y, *z]) >= offer([*x, *y, *z]) {
                        break;
                    }
                }
            }
        }
        best.map_or([0; 3], |(_, way)| way)
    }
}

/// Of a way's length.
pub fn square(way: &Spot) -> i128 {
    way.iter().map(|x| i128::from(*x) * i128::from(*x)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn solid(r: &mut Random, count: usize, reach: i32) -> Solid {
        let block = |r: &mut Random| {
            let low: Spot = std::array::from_fn(|_| i64::from(r.whole(-reach, reach)));
            Block::new(low, low.map(|x| x + i64::from(r.whole(1, 3))))
        };
        Solid((0..count).map(|_| block(r)).collect())
    }

    #[test]
    fn surfaces_are_closed_and_hold_the_volume() {
        let mut r = Random::new(3);
        for round in 0..60 {
            let solid = solid(&mut r, 1 + round % 6, 3);
            let cells = (-4..8).flat_map(|x| (-4..8).flat_map(move |y| (-4..8).map(move |z| [x, y, z])));
            let inside = |p: &Spot| solid.0.iter().any(|b| (0..3).all(|a| b.low[a] <= p[a] && p[a] < b.high[a]));
            let volume = cells.filter(inside).count() as i64;
            let (vertices, faces) = solid.surface(12 * round, &mut r);
            let mut edges: HashMap<[u32; 2], i32> = HashMap::new();
            let mut sixths = 0;
            for f in &faces {
                let [p, q, s] = f.map(|v| vertices[v as usize]);
                sixths += p[0] * (q[1] * s[2] - q[2] * s[1])
                    + p[1] * (q[2] * s[0] - q[0] * s[2])
                    + p[2] * (q[0] * s[1] - q[1] * s[0]);
                (0..3).for_each(|k| *edges.entry([f[k], f[(k + 1) % 3]]).or_default() += 1);
            }
            assert_eq!(sixths, 6 * volume, "{solid:?}");
            assert!(edges.iter().all(|([a, b], n)| edges.get(&[*b, *a]) == Some(n)), "{solid:?}");
            let finest = solid.surface(usize::MAX, &mut r).1.len();
            assert!(faces.len() >= finest.min(12 * round), "{solid:?}");
        }
    }

    #[test]
    fn no_way_is_shorter_than_the_shortest() {
        let mut r = Random::new(4);
        let mut counts = [0; 2];
        for round in 0..300 {
            let (fixed, mover) = (solid(&mut r, 1 + round % 5, 3), solid(&mut r, 1 + round % 3, 1));
            let obstacles = Obstacles::new([&fixed], &mover, 0);
            let way = obstacles.shortest_way();
            assert!(obstacles.is_free(&way));
            // Nothing that is shorter, by all whole ways; halves do not help.
            let all = (-9..10).flat_map(|x| (-9..10).flat_map(move |y| (-9..10).map(move |z| [x, y, z])));
            for other in all.filter(|other| square(other) < square(&way)) {
                assert!(!obstacles.is_free(&other), "{fixed:?} {mover:?} {way:?} {other:?}");
            }
            counts[usize::from(way != [0; 3])] += 1;
            assert!(way == [0; 3] || obstacles.square_distance() == 0);
        }
        assert!(counts.iter().all(|n| *n > 50), "{counts:?}");
    }
}
