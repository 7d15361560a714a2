//! Points and closed surfaces with integer corners, in whole numbers of 128 bits: whether a point is inside, and its
//! distance from the surface. Only the last quotient of a distance is rounded.

use crate::blocks::{Spot, Surface};

/// Parts of a unit in which points are given.
pub const PARTS: i128 = 1 << 32;

/// No corner has a coordinate beyond this, in units; with it no number here has more than 124 bits.
pub const LARGEST: i64 = 1 << 13;

/// A point, in [`PARTS`] of a unit.
pub type Fine = [i128; 3];

/// Where a point is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// The surface winds around it.
    Inside,
    /// On a triangle.
    On,
    /// Neither.
    Outside,
}

/// A closed surface, by its triangles.
#[derive(Debug, Clone)]
pub struct Triangles(Vec<[Fine; 3]>);

impl Triangles {
    /// Of a surface.
    ///
    /// # Panics
    /// Where a coordinate is beyond [`LARGEST`].
    pub fn new((corners, faces): &Surface) -> Triangles {
        let whole = |p: Spot| {
            assert!(p.iter().all(|x| x.abs() <= LARGEST), "{p:?}");
            p.map(i128::from)
        };
        Triangles(faces.iter().map(|f| f.map(|v| whole(corners[v as usize]))).collect())
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// A point of one of them, by shares of its corners that make up [`PARTS`].
    pub fn point(&self, i: usize, shares: &[i128; 3]) -> Fine {
        debug_assert_eq!(shares.iter().sum::<i128>(), PARTS);
        let [p, q, r] = &self.0[i];
        [0, 1, 2].map(|a| p[a] * shares[0] + q[a] * shares[1] + r[a] * shares[2])
    }

    /// Where a point is: how often the surface winds around it is counted along a ray that meets no edge.
    pub fn place(&self, p: &Fine) -> Place {
        let is_beyond = |a: usize| {
            let all = || self.0.iter().flatten().map(|corner| corner[a] * PARTS);
            all().all(|x| x < p[a]) || all().all(|x| x > p[a])
        };
        if (0..3).any(is_beyond) {
            return Place::Outside;
        }
        // Any directions do; a ray that meets an edge is given up.
        (1..)
            .map(|n: i128| [7 * n * n + 3, 5 * n + 911, 13 * n * n + n - 401])
            .find_map(|d| self.along(p, &d))
            .unwrap_or(Place::On)
    }

    fn along(&self, p: &Fine, d: &Fine) -> Option<Place> {
        let mut winding = 0;
        for t in &self.0 {
            let [a, b, c] = t.map(|corner| from(p, &corner));
            let around = [(a, b), (b, c), (c, a)].map(|(u, v)| dot(&cross(&u, &v), d).signum());
            let n = normal(t);
            let (height, slope) = (dot(&n, &a), dot(&n, d));
            if height == 0 && is_over(t, p) {
                return Some(Place::On);
            }
            if around.contains(&1) && around.contains(&-1) {
                continue;
            }
            if slope == 0 || around.contains(&0) {
                return None;
            }
            if height.signum() == slope.signum() {
                winding += slope.signum();
            }
        }
        Some(if winding == 0 { Place::Outside } else { Place::Inside })
    }

    /// How far a point is from the nearest triangle, in units, but for the rounding of one quotient and one root.
    pub fn distance(&self, p: &Fine) -> f64 {
        self.0.iter().map(|t| square_distance(t, p)).fold(f64::INFINITY, f64::min).sqrt() / PARTS as f64
    }
}

/// In parts of a unit.
fn square_distance(t: &[Fine; 3], p: &Fine) -> f64 {
    if is_over(t, p) {
        let n = normal(t);
        let height = dot(&n, &from(p, &t[0])) as f64;
        return height * height / dot(&n, &n) as f64;
    }
    let to_side = |i: usize| {
        let (u, w) = (difference(&t[(i + 1) % 3], &t[i]), from(p, &t[i]).map(|x| -x));
        let (size, along) = (dot(&u, &u), dot(&u, &w));
        if along <= 0 {
            dot(&w, &w) as f64
        } else if along >= size * PARTS {
            let w = from(p, &t[(i + 1) % 3]);
            dot(&w, &w) as f64
        } else {
            (dot(&w, &w) * size - along * along) as f64 / size as f64
        }
    };
    to_side(0).min(to_side(1)).min(to_side(2))
}

/// Whether the foot of a point in the plane of a triangle is in it, or on its border.
fn is_over(t: &[Fine; 3], p: &Fine) -> bool {
    let n = normal(t);
    (0..3).all(|i| {
        let (u, w) = (difference(&t[(i + 1) % 3], &t[i]), from(p, &t[i]).map(|x| -x));
        dot(&cross(&u, &w), &n) >= 0
    })
}

/// From a point to a corner, in parts.
fn from(p: &Fine, corner: &Fine) -> Fine {
    [0, 1, 2].map(|a| corner[a] * PARTS - p[a])
}

fn normal(t: &[Fine; 3]) -> Fine {
    cross(&difference(&t[1], &t[0]), &difference(&t[2], &t[0]))
}

fn difference(a: &Fine, b: &Fine) -> Fine {
    [0, 1, 2].map(|k| a[k] - b[k])
}

fn cross(a: &Fine, b: &Fine) -> Fine {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn dot(a: &Fine, b: &Fine) -> i128 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::blocks::{Block, Solid};
    use crate::distance::relative_distance;
    use crate::random::Random;

    #[test]
    fn points_are_where_the_blocks_say() {
        let mut r = Random::new(5);
        let mut counts = [0; 3];
        for _ in 0..60 {
            let block = |r: &mut Random| {
                let low: Spot = [0; 3].map(|_| i64::from(r.whole(-4, 3)));
                Block::new(low, low.map(|x| x + i64::from(r.whole(1, 3))))
            };
            let solid = Solid((0..1 + r.below(4)).map(|_| block(&mut r)).collect());
            let surface = Triangles::new(&solid.surface(1, &mut r));
            for _ in 0..60 {
                // Halves, so that many are in faces, edges and corners.
                let low = solid.0[r.below(solid.0.len())].low;
                let p = low.map(|x| 2 * i128::from(x) + i128::from(r.whole(-1, 6)));
                // Around the point all eight directions tell where it is.
                let has = |n: usize| {
                    let x = [0, 1, 2].map(|a| 4 * p[a] + if n >> a & 1 == 1 { 1 } else { -1 });
                    solid
                        .0
                        .iter()
                        .any(|b| (0..3).all(|a| 8 * i128::from(b.low[a]) < x[a] && x[a] < 8 * i128::from(b.high[a])))
                };
                let count = (0..8).filter(|n| has(*n)).count();
                let expected =
                    [Place::Outside, Place::On, Place::Inside][usize::from(count > 0) + usize::from(count == 8)];
                let at = p.map(|x| x * PARTS / 2);
                assert_eq!(surface.place(&at), expected, "{solid:?} {p:?}");
                assert_eq!(surface.distance(&at) == 0.0, expected == Place::On, "{solid:?} {p:?}");
                counts[expected as usize] += 1;
            }
        }
        assert!(counts.iter().all(|n| *n > 200), "{counts:?}");
    }

    #[test]
    fn distances_are_those_of_rational_arithmetic() {
        let mut r = Random::new(6);
        for _ in 0..3000 {
            let reach = r.pick(&[3, 50, LARGEST as i32]);
            let t = r.lattice_triangle(-reach, reach);
            if !crate::oracle::has_area(&t) {
                continue;
            }
            let corners = t.map(|p| p.map(|x| x as i64)).to_vec();
            let surface = Triangles::new(&(corners, vec![[0, 1, 2]]));
            let p = r.lattice_point(-2 * reach, 2 * reach).map(|x| x / 2.0);
            let fine = p.map(|x| (x * PARTS as f64) as i128);
            let extent = (0..3).fold(0.0f64, |most, a| {
                let all = t.iter().map(|c| c[a]).chain([p[a]]);
                let ends = all.fold([f64::MAX, f64::MIN], |[low, high], x| [low.min(x), high.max(x)]);
                most.max(ends[1] - ends[0])
            });
            let expected = relative_distance(&[p; 3], &t) * extent;
            assert!((surface.distance(&fine) - expected).abs() <= 1e-14 * extent, "{t:?} {p:?}");
        }
    }
}
