//! The surface of a part under a tree of boxes, for queries of points: the closest point of the surface, and whether a
//! point is inside.

use std::collections::HashMap;
use std::sync::OnceLock;

use feeler_core::clash::gap_filling::fillings;
use feeler_core::constants::NONE;
use feeler_core::geometry::ray_crossings::{crossing, ray_end, RAY_OFFSETS};
use feeler_core::geometry::vectors::{add, along, cross, dot, precise_normal, scaled, sub};
use feeler_core::mesh::topology::adjacency::Adjacency;
use feeler_core::{Aabb, Point, Triangle};

use super::border::Border;
use super::tree::Tree;
use crate::constants::{BODY_ROUNDING, SLIVER_HEIGHT, SURFACE_ROUNDOFFS, WIDEST_SEAM};

/// A little more than 1: above the rounding of heights over planes. It bounds no distance, only the search.
const ABOVE: f64 = 1.0 + 1e-6;

/// Corners of a sample.
const SAMPLE: usize = 32;

/// The closest point of a body to a point.
#[derive(Debug, Clone, Copy)]
pub struct Closest {
    /// Metres.
    pub distance: f64,
    /// Its place in the body's triangles.
    pub triangle: u32,
    /// On it, relative to the body's origin.
    pub point: Point,
}

/// One part's surface, with the gaps of closed surfaces filled. All is relative to its origin, so that parts far off are as exact as near
/// ones.
#[derive(Debug)]
pub struct Body {
    origin: Point,
    bounds: Aabb,
    /// How far rounding may move points of it, metres.
    rounding: f64,
    triangles: Vec<Triangle>,
    /// The plane of each: its unit normal, and the height of the origin below it; all zero where it has no area.
    planes: Vec<[f64; 4]>,
    /// For each of them, as [`Adjacency::outward`].
    senses: Vec<i8>,
    tree: Tree,
    looseness: f64,
    is_closed: bool,
    /// As [`Adjacency::neighbours`], by the places of its triangles; empty if it is closed.
    neighbours: Vec<[u32; 3]>,
    border: OnceLock<Border>,
}

impl Body {
    /// Of triangles in the world, each with its number in an adjacency.
    pub fn new(given: impl Iterator<Item = (u32, Triangle)> + Clone, adjacency: &Adjacency) -> Body {
        let mut world = Aabb::EMPTY;
        given.clone().flat_map(|(_, t)| t).for_each(|p| world.grow(&p));
        let middle = |a: usize| 0.5 * world.lower[a] + 0.5 * world.upper[a];
        let origin: Point = if world.is_empty() { [0.0; 3] } else { std::array::from_fn(middle) };
        let (numbers, mut moved): (Vec<u32>, Vec<Triangle>) =
            given.map(|(number, t)| (number, t.map(|p| sub(&p, &origin)))).unzip();
        if adjacency.is_loose() {
            let outward = numbers.iter().zip(&moved).filter_map(|(number, t)| adjacency.wound_outward(*number, *t));
            let filled = fillings(&outward.collect::<Vec<_>>());
            moved.extend(filled);
        }
        let bounds = moved.iter().fold(Aabb::EMPTY, |around, t| around.union(&Aabb::of_triangle(t)));
        let (tree, order) = Tree::new(&moved);
        let sense = |i: &u32| numbers.get(*i as usize).map_or(1, |number| adjacency.outward[*number as usize]);
        let senses: Vec<i8> = order.iter().map(sense).collect();
        let triangles: Vec<Triangle> = order.iter().map(|i| moved[*i as usize]).collect();
        drop(moved);
        let is_closed = senses.iter().any(|sense| *sense != 0);
        let is_loose = adjacency.is_loose();
        let neighbours = if is_closed && !is_loose { Vec::new() } else { neighbours_of(&numbers, &order, adjacency) };
        let looseness = if is_loose { widest_seam(&triangles, &neighbours, bounds.longest()) } else { 0.0 };
        Body {
            origin,
            rounding: (BODY_ROUNDING * bounds.largest_coordinate()).max(SURFACE_ROUNDOFFS * last_place(&world)),
            bounds,
            planes: triangles.iter().map(plane_of).collect(),
            triangles,
            is_closed,
            neighbours: if is_closed { Vec::new() } else { neighbours },
            border: OnceLock::new(),
            senses,
            tree,
            looseness,
        }
    }

    /// The origin of its points, in the world.
    pub fn origin(&self) -> &Point {
        &self.origin
    }

    /// The box around it, relative to its origin.
    pub fn bounds(&self) -> &Aabb {
        &self.bounds
    }

    /// The largest rounding error of points computed near it, metres.
    pub fn rounding(&self) -> f64 {
        self.rounding
    }

    /// Whether some of its surfaces are closed, so that it has an inside.
    pub fn is_closed(&self) -> bool {
        self.is_closed
    }

    /// How wide the gaps in its seams are at most, metres; 0 without any.
    pub fn looseness(&self) -> f64 {
        self.looseness
    }

    /// How many triangles it has.
    pub fn len(&self) -> usize {
        self.triangles.len()
    }

    /// One of its triangles.
    pub fn triangle(&self, i: u32) -> &Triangle {
        &self.triangles[i as usize]
    }

    /// The plane of one of its triangles: the unit normal, and the height of the origin below it; all zero where it has no area.
    pub fn plane(&self, i: u32) -> &[f64; 4] {
        &self.planes[i as usize]
    }

    /// Whether the winding of one of its triangles leads outwards, as [`Adjacency::outward`].
    pub fn sense(&self, i: u32) -> i8 {
        self.senses[i as usize]
    }

    /// The outward unit normal of one of its triangles; `None` of an open surface.
    pub fn outward(&self, i: u32) -> Option<Point> {
        let sense = f64::from(self.senses[i as usize]);
        let [x, y, z, _] = self.planes[i as usize];
        (sense != 0.0 && [x, y, z] != [0.0; 3]).then(|| scaled(&[x, y, z], sense))
    }

    /// The tree over its triangles.
    pub fn tree(&self) -> &Tree {
        &self.tree
    }

    /// Its closest point; some triangles that are near are looked at first.
    pub fn closest_from(&self, p: &Point, first: &[u32]) -> Option<Closest> {
        let mut seed: Option<Closest> = None;
        for (n, i) in first.iter().enumerate() {
            if first[..n].contains(i) {
                continue;
            }
            let (square, point) = closest_on(p, &self.triangles[*i as usize]);
            if seed.is_none_or(|seed| square < seed.distance * seed.distance) {
                seed = Some(Closest { distance: square.sqrt(), triangle: *i, point });
            }
        }
        let within = seed.map_or(f64::INFINITY, |seed| seed.distance);
        self.closest(p, within).or(seed)
    }

    /// Its closest point, where one is nearer than `within`.
    pub fn closest(&self, p: &Point, within: f64) -> Option<Closest> {
        let mut best = within * within;
        let mut found = None;
        self.tree.for_each_near(p, best, |i| {
            let [x, y, z, offset] = self.planes[i as usize];
            let height = x * p[0] + y * p[1] + z * p[2] - offset;
            let height = (height.abs() - self.rounding).max(0.0);
            if height * height > best * ABOVE {
                return f64::INFINITY;
            }
            let (square, point) = closest_on(p, &self.triangles[i as usize]);
            if square < best {
                best = square;
                found = Some((i, point));
            }
            square
        });
        found.map(|(triangle, point)| Closest { distance: best.sqrt(), triangle, point })
    }

    /// Some corners that are spread over it, in the world.
    pub fn sample(&self) -> Vec<Point> {
        let step = self.len().div_ceil(SAMPLE).max(1);
        self.triangles.iter().step_by(step).map(|t| add(&t[0], &self.origin)).collect()
    }

    /// The triangles beside one of its triangles, over the edges from corner `k` to `k + 1`; `NONE` at a border, and of a closed body.
    pub fn neighbours(&self, i: u32) -> [u32; 3] {
        self.neighbours.get(i as usize).copied().unwrap_or([NONE; 3])
    }

    /// The border of a body without closed surfaces.
    pub fn border(&self) -> &Border {
        self.border.get_or_init(|| Border::new(self, &self.neighbours))
    }

    /// Between which heights along a normal all of it is, in the world: beyond it by no more than a millionth of its size.
    pub fn heights(&self, normal: &Point) -> [f64; 2] {
        let height = |i: u32, sense: f64| {
            let [a, b, c] = self.triangle(i).map(|p| sense * dot(normal, &p));
            a.max(b).max(c)
        };
        let slack = 1e-6 * self.bounds.longest();
        let [low, high] =
            [-1.0, 1.0].map(|sense| self.tree.greatest(&scaled(normal, sense), slack, |i| height(i, sense)));
        let origin = dot(normal, &self.origin);
        [origin - low, origin + high]
    }

    /// Hands over the triangles whose boxes overlap a box, until one is taken.
    pub fn find_overlapping<T>(&self, bounds: &Aabb, take: impl FnMut(u32) -> Option<T>) -> Option<T> {
        self.tree.find_overlapping(bounds, take)
    }

    /// Whether a point that is not on the surface is inside a closed surface, as windings count; `None` where no ray decides.
    pub fn is_inside(&self, p: &Point) -> Option<bool> {
        let is_out = (0..3).any(|a| p[a] < self.bounds.lower[a] || p[a] > self.bounds.upper[a]);
        if is_out || !self.is_closed {
            return Some(false);
        }
        let winding = |offset| self.winding(p, &ray_end(p, &self.bounds, offset));
        RAY_OFFSETS.iter().find_map(winding).map(|winding| winding != 0)
    }

    /// How often the surface winds around a point, counted along a ray; `None` where the ray meets an edge.
    fn winding(&self, p: &Point, q: &Point) -> Option<i32> {
        let mut sum = 0;
        let is_open = self.tree.find_on_segment([p, q], self.rounding, |i| {
            let sense = i32::from(self.senses[i as usize]);
            if sense != 0 {
                match crossing(p, q, &self.triangles[i as usize]) {
                    Some(crossed) => sum += sense * crossed,
                    None => return Some(()),
                }
            }
            None
        });
        is_open.is_none().then_some(sum)
    }
}

/// The unit in the last place of the largest coordinate of a box.
fn last_place(bounds: &Aabb) -> f64 {
    let largest = bounds.largest_coordinate();
    largest.next_up() - largest
}

/// The neighbours of triangles by their places in an order, from their numbers in an adjacency; fillings have none.
fn neighbours_of(numbers: &[u32], order: &[u32], adjacency: &Adjacency) -> Vec<[u32; 3]> {
    let number = |i: &u32| numbers.get(*i as usize);
    let places: HashMap<u32, u32> = order.iter().zip(0..).filter_map(|(i, place)| Some((*number(i)?, place))).collect();
    let place = |number: u32| places.get(&number).copied().unwrap_or(NONE);
    let beside = |i| number(i).map_or([NONE; 3], |number| adjacency.neighbours[*number as usize].map(place));
    order.iter().map(beside).collect()
}

/// How far corners are at most from the triangles beside their edges, as far as these are within the looseness of a seam.
fn widest_seam(triangles: &[Triangle], neighbours: &[[u32; 3]], longest: f64) -> f64 {
    let mut widest = 0.0f64;
    for (t, beside) in triangles.iter().zip(neighbours) {
        for k in (0..3).filter(|k| beside[*k] != NONE) {
            let other = &triangles[beside[k] as usize];
            let gap = [t[k], t[(k + 1) % 3]].iter().map(|p| distance_to(p, other)).fold(0.0, f64::max);
            if gap <= WIDEST_SEAM * longest {
                widest = widest.max(gap);
            }
        }
    }
    widest
}

fn plane_of(t: &Triangle) -> [f64; 4] {
    precise_normal(t).map_or([0.0; 4], |n| [n[0], n[1], n[2], dot(&n, &t[0])])
}

/// The square of the distance to a triangle, and its closest point. Of a sliver, whose normal rounding decides, the border counts.
#[inline]
pub fn closest_on(p: &Point, [a, b, c]: &Triangle) -> (f64, Point) {
    let (ab, bc, ca) = (sub(b, a), sub(c, b), sub(a, c));
    let (ap, bp, cp) = (sub(p, a), sub(p, b), sub(p, c));
    let n = cross(&ab, &bc);
    let square = dot(&n, &n);
    let longest = dot(&ab, &ab).max(dot(&bc, &bc)).max(dot(&ca, &ca));
    let sides = [(a, &ab, &ap), (b, &bc, &bp), (c, &ca, &cp)];
    // The square of the distance to a side, and its closest point.
    let on_side = |(from, side, to): (&Point, &Point, &Point)| {
        let size = dot(side, side);
        let s = if size > 0.0 { (dot(to, side) / size).clamp(0.0, 1.0) } else { 0.0 };
        let apart = along(to, -s, side);
        (dot(&apart, &apart), along(from, s, side))
    };
    let nearer = |best: (f64, Point), other: (f64, Point)| if other.0 < best.0 { other } else { best };
    let is_beyond = |(_, side, to): &(&Point, &Point, &Point)| dot(&cross(&n, side), to) <= 0.0 || square <= 0.0;
    let none = (f64::INFINITY, *a);
    let best = sides.into_iter().filter(is_beyond).map(on_side).fold(none, nearer);
    if best.0 < f64::INFINITY {
        return best;
    }
    if square > SLIVER_HEIGHT * SLIVER_HEIGHT * longest * longest {
        // From the foot on the longest side, which is near however long the triangle is: over a narrow one its normal leans by rounding.
        let longer =
            |x: &&(&Point, &Point, &Point), y: &&(&Point, &Point, &Point)| dot(x.1, x.1).total_cmp(&dot(y.1, y.1));
        let foot = sides.iter().max_by(longer).map_or(*a, |side| on_side(*side).1);
        let height = dot(&n, &sub(p, &foot));
        return (height * height / square, along(p, -height / square, &n));
    }
    // A sliver below or above.
    sides.into_iter().map(on_side).fold(none, nearer)
}

/// The distance to a triangle, metres.
pub fn distance_to(p: &Point, t: &Triangle) -> f64 {
    closest_on(p, t).0.sqrt()
}

#[cfg(test)]
mod tests {
    use super::super::brute::{block, body, hollow_box, inside_out, point_of, triangle};
    use super::*;
    use feeler_shapes::random::Random;
    use feeler_shapes::{ball, joined};

    #[test]
    fn the_closest_point_is_on_the_triangle_and_none_is_closer() {
        let mut r = Random::new(1);
        for n in 0..500 {
            let mut t = triangle(&mut r, 0.5);
            if n % 5 == 0 {
                // A sliver, and one that is a segment.
                t[2] =
                    std::array::from_fn(|a| 0.5 * (t[0][a] + t[1][a]) + if n % 2 == 0 { 1e-13 * t[2][a] } else { 0.0 });
            }
            let p = r.point(-0.5, 1.5);
            let (square, point) = closest_on(&p, &t);
            assert!((length_of(&sub(&p, &point)) - square.sqrt()).abs() < 1e-12);
            assert!(closest_on(&point, &t).0 < 1e-20);
            for _ in 0..60 {
                assert!(length_of(&sub(&p, &point_of(&mut r, &t))) >= square.sqrt() - 1e-10, "{t:?} {p:?}");
            }
            assert!(t.iter().all(|corner| closest_on(corner, &t).0 < 1e-24));
        }
    }

    fn length_of(a: &Point) -> f64 {
        dot(a, a).sqrt()
    }

    #[test]
    fn the_closest_of_all_is_found_from_anywhere() {
        let mut r = Random::new(2);
        let body = body(ball(1.0, 6));
        for _ in 0..300 {
            let p = r.point(-1.5, 1.5);
            let expected = super::super::brute::distance(&body, &p);
            let first: Vec<u32> = (0..r.below(4)).map(|_| r.below(body.len() as u64) as u32).collect();
            for closest in
                [body.closest_from(&p, &first), body.closest(&p, f64::INFINITY), body.closest(&p, expected + 1e-9)]
            {
                let closest = closest.unwrap();
                assert!((closest.distance - expected).abs() < 1e-15);
                assert!((distance_to(&p, body.triangle(closest.triangle)) - expected).abs() < 1e-15);
                assert!((length_of(&sub(&p, &closest.point)) - expected).abs() < 1e-12);
            }
            assert!(body.closest(&p, expected * (1.0 - 1e-12)).is_none());
        }
    }

    #[test]
    fn points_are_inside_where_there_is_material() {
        let mut r = Random::new(3);
        let meshes = [
            hollow_box(4.0, 2.0, 2),
            inside_out(hollow_box(4.0, 2.0, 4)),
            joined([hollow_box(4.0, 2.0, 1), block([-0.5; 3], [0.5; 3], 2)]),
        ];
        for (n, mesh) in meshes.into_iter().enumerate() {
            let body = body(mesh);
            for _ in 0..500 {
                let p = r.point(-3.0, 3.0);
                let size = p.iter().fold(0.0f64, |most, x| most.max(x.abs()));
                let expected = (1.0..2.0).contains(&size) || n == 2 && size < 0.5;
                assert_eq!(body.is_inside(&p), Some(expected), "{n} {p:?}");
            }
        }
    }

    #[test]
    fn what_overlaps_a_solid_that_is_inside_out_is_in_both() {
        let body = body(joined([block([0.0; 3], [1.0; 3], 1), inside_out(block([0.0, 0.9, 0.0], [1.0, 1.9, 1.0], 2))]));
        let is_inside = |y: f64| body.is_inside(&sub(&[0.45, y, 0.37], body.origin()));
        assert_eq!([0.5, 0.95, 1.5].map(is_inside), [Some(true); 3]);
        assert_eq!([-0.1, 2.0].map(is_inside), [Some(false); 2]);
    }

    #[test]
    fn heights_hold_the_body_in_the_world() {
        let body = body(block([5.0, 6.0, 7.0], [6.0, 8.0, 10.0], 3));
        for (normal, expected) in
            [([1.0, 0.0, 0.0], [5.0, 6.0]), ([0.0, 0.0, -1.0], [-10.0, -7.0]), ([0.6, 0.8, 0.0], [7.8, 10.0])]
        {
            let [low, high] = body.heights(&normal);
            assert!((low - expected[0]).abs() < 1e-5 && (high - expected[1]).abs() < 1e-5, "{low} {high}");
            assert!(low <= expected[0] + 1e-12 && high >= expected[1] - 1e-12);
        }
    }
}
