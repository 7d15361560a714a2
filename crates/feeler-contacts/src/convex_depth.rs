//! The depth of two convex bodies: the least translation that parts them.
//!
//! The expanding polytope of G. van den Bergen, *Proximity queries and penetration depth computation on 3D game objects* (2001): the
//! points of the Minkowski difference span a hull, whose nearest facet is pushed outwards until it lies on the border. A facet is no
//! farther than the border, and the border no farther than its support: both bounds are known. Deviation: the hull need not hold the
//! origin at first, since distances of facets are signed.

use feeler_core::geometry::vectors::{cross, dot, length, sub, unit};
use feeler_core::Point;

/// Bounds that agree to this share of the difference's size are one.
const AGREED: f64 = 1e-9;

/// Points of the hull at most.
const MOST_POINTS: usize = 400;

/// How far a point must be outside of a facet to see it, as a share of the size.
const VISIBLE: f64 = 1e-12;

/// A translation along which two bodies part, and whether none is shorter by more than [`AGREED`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ConvexDepth {
    /// Of length 1: the second body leaves the first along it.
    pub direction: Point,
    /// Metres; negative or zero where the bodies are apart or touch.
    pub depth: f64,
    /// Whether both bounds agree.
    pub is_least: bool,
}

/// The difference of two sets of points.
struct Difference<'a> {
    a: &'a [Point],
    b: &'a [Point],
}

impl Difference<'_> {
    /// Its farthest point along a direction.
    fn support(&self, along: &Point) -> Point {
        let farthest = |points: &[Point], sense: f64| {
            let mut best = (f64::NEG_INFINITY, [0.0; 3]);
            for p in points {
                let height = sense * dot(p, along);
                if height > best.0 {
                    best = (height, *p);
                }
            }
            best.1
        };
        sub(&farthest(self.a, 1.0), &farthest(self.b, -1.0))
    }
}

#[derive(Debug, Clone, Copy)]
struct Facet {
    corners: [usize; 3],
    /// Outwards, of length 1.
    normal: Point,
    /// Of its plane from the origin, along the normal.
    distance: f64,
}

struct Hull {
    points: Vec<Point>,
    facets: Vec<Facet>,
    visible: f64,
}

impl Hull {
    /// A tetrahedron of some of the points; `None` where they lie in a plane.
    fn new(points: &[Point], visible: f64) -> Option<Hull> {
        let far = |height: &dyn Fn(&Point) -> f64| {
            let best = points.iter().max_by(|p, q| height(p).total_cmp(&height(q)))?;
            (height(best) > visible).then_some(*best)
        };
        let a = *points.first()?;
        let b = far(&|p| length(&sub(p, &a)))?;
        let along = unit(&sub(&b, &a))?;
        let c = far(&|p| length(&cross(&along, &sub(p, &a))))?;
        let normal = unit(&cross(&along, &sub(&c, &a)))?;
        let d = far(&|p| dot(&normal, &sub(p, &a)).abs())?;
        let [a, b, c] = if dot(&normal, &sub(&d, &a)) > 0.0 { [a, c, b] } else { [a, b, c] };
        let mut hull = Hull { points: vec![a, b, c, d], facets: Vec::new(), visible };
        for corners in [[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]] {
            hull.facets.push(hull.facet(corners)?);
        }
        Some(hull)
    }

    fn facet(&self, corners: [usize; 3]) -> Option<Facet> {
        let [a, b, c] = corners.map(|i| self.points[i]);
        let normal = unit(&cross(&sub(&b, &a), &sub(&c, &a)))?;
        // Of three corners the one whose rounding counts least.
        let distance = [a, b, c].iter().map(|p| dot(&normal, p)).fold(f64::INFINITY, f64::min);
        Some(Facet { corners, normal, distance })
    }

    /// The facets that a point sees, and the others. Only those in one piece with the one that it stands out of most: where rounding has
    /// dented the hull, it may see others by a hair.
    fn seen_from(&self, p: &Point) -> (Vec<Facet>, Vec<Facet>) {
        let height = |facet: &Facet| dot(&facet.normal, p) - facet.distance;
        let (mut open, mut kept): (Vec<Facet>, Vec<Facet>) =
            self.facets.iter().partition(|facet| height(facet) > self.visible);
        let Some(most) = (0..open.len()).max_by(|i, j| height(&open[*i]).total_cmp(&height(&open[*j]))) else {
            return (open, kept);
        };
        let mut seen = vec![open.swap_remove(most)];
        let mut next = 0;
        while next < seen.len() {
            let corners = seen[next].corners;
            let is_beside = |other: &Facet| other.corners.iter().filter(|c| corners.contains(c)).count() == 2;
            let (beside, rest): (Vec<Facet>, Vec<Facet>) = open.into_iter().partition(is_beside);
            seen.extend(beside);
            open = rest;
            next += 1;
        }
        kept.extend(open);
        (seen, kept)
    }

    /// Takes a point into the hull; false where it is not outside, or where rounding leaves no hull.
    fn add(&mut self, p: Point) -> bool {
        let edges = |facet: &Facet| [0, 1, 2].map(|i| (facet.corners[i], facet.corners[(i + 1) % 3]));
        let (seen, kept) = self.seen_from(&p);
        if seen.is_empty() {
            return false;
        }
        let all: Vec<(usize, usize)> = seen.iter().flat_map(edges).collect();
        let horizon: Vec<(usize, usize)> = all.iter().copied().filter(|(a, b)| !all.contains(&(*b, *a))).collect();
        let mut starts: Vec<usize> = horizon.iter().map(|(a, _)| *a).collect();
        starts.sort_unstable();
        starts.dedup();
        // One loop: each corner begins one edge of it.
        if starts.len() != horizon.len() || kept.is_empty() {
            return false;
        }
        self.points.push(p);
        let tip = self.points.len() - 1;
        let Some(new) = horizon.iter().map(|(a, b)| self.facet([*a, *b, tip])).collect::<Option<Vec<_>>>() else {
            self.points.pop();
            return false;
        };
        self.facets = kept;
        self.facets.extend(new);
        true
    }
}

/// Directions that the first hull is made of.
fn first_directions() -> impl Iterator<Item = Point> {
    let steps = [-1.0, 0.0, 1.0];
    let all = steps.into_iter().flat_map(move |x| steps.into_iter().flat_map(move |y| steps.map(|z| [x, y, z])));
    all.filter_map(|direction| unit(&direction))
}

/// The least translation of the second of two convex bodies, given by their vertices, that parts it from the first. `rounding`: by how
/// much the vertices may be off the border of a convex body, metres.
pub fn convex_depth(a: &[Point], b: &[Point], rounding: f64) -> ConvexDepth {
    let difference = Difference { a, b };
    let mut best = ConvexDepth { direction: [0.0, 0.0, 1.0], depth: f64::INFINITY, is_least: false };
    let mut look = |direction: Point| {
        let point = difference.support(&direction);
        let depth = dot(&direction, &point);
        if depth < best.depth {
            best = ConvexDepth { direction, depth, is_least: false };
        }
        (point, depth, best)
    };
    let first: Vec<Point> = first_directions().map(|direction| look(direction).0).collect();
    let size = first.iter().flat_map(|p| first.iter().map(move |q| length(&sub(p, q)))).fold(0.0, f64::max);
    let visible = (VISIBLE * size).max(4.0 * rounding);
    let Some(mut hull) = Hull::new(&first, visible) else { return look([0.0, 0.0, 1.0]).2 };
    for p in first {
        hull.add(p);
    }
    loop {
        let nearest = hull.facets.iter().min_by(|f, g| f.distance.total_cmp(&g.distance)).copied();
        let Some(nearest) = nearest else { return look([0.0, 0.0, 1.0]).2 };
        let (point, depth, found) = look(nearest.normal);
        if depth - nearest.distance <= (AGREED * size).max(2.0 * visible) {
            return ConvexDepth { is_least: true, ..found };
        }
        if hull.points.len() >= MOST_POINTS || !hull.add(point) {
            return found;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use feeler_core::geometry::vectors::add;
    use feeler_lanes::SplitMix64;

    fn corners(size: Point, place: Point) -> Vec<Point> {
        let corner = |i: usize| std::array::from_fn(|a| place[a] + size[a] * if i >> a & 1 == 0 { -0.5 } else { 0.5 });
        (0..8).map(corner).collect()
    }

    #[test]
    fn plates_that_cross_at_a_rim_part_by_the_short_way() {
        for (place, expected) in [([0.0, 1.45, 0.0], 0.06), ([0.0, 0.0, 1.4], 0.11), ([0.0; 3], 1.51)] {
            let (a, b) = (corners([3.0, 3.0, 0.02], [0.0; 3]), corners([3.0, 0.02, 3.0], place));
            let found = convex_depth(&a, &b, 0.0);
            assert!(found.is_least && (found.depth - expected).abs() < 1e-8, "{found:?}, not {expected}");
        }
    }

    #[test]
    fn what_rounding_dents_has_the_depth_of_the_smooth() {
        // A box with the corners of its squares, and a wedge flush with it: many points in a plane, each off it by a rounding.
        let squares: Vec<Point> = (0..32)
            .map(|i| [i % 2, i / 2 % 4, i / 8].map(f64::from))
            .filter(|[_, y, z]| [0.0, 3.0].contains(y) || [0.0, 3.0].contains(z))
            .collect();
        let wedge = [[0., 0., 0.], [2., 0., 0.], [0., 1., 0.], [0., 0., 1.], [2., 0., 1.], [0., 1., 1.]];
        let mut random = SplitMix64::new(5);
        for _ in 0..2000 {
            let at: Point = std::array::from_fn(|_| (random.unit() * 7.0).floor() / 2.0 - 1.5);
            let moved: Vec<Point> = wedge.iter().map(|p| add(p, &at)).collect();
            let mut vector = || std::array::from_fn(|_| random.unit() - 0.5);
            let x = unit(&vector()).unwrap();
            let z = unit(&cross(&x, &vector())).unwrap();
            let frame = [x, cross(&z, &x), z];
            let rounding = 2f64.powi(-33);
            let turned = |points: &[Point]| -> Vec<Point> {
                points
                    .iter()
                    .map(|p| frame.map(|axis| ((dot(&axis, p) + 1e6) / rounding).round() * rounding - 1e6))
                    .collect()
            };
            let (a, b) = (turned(&squares), turned(&moved));
            let (smooth, found) = (convex_depth(&squares, &moved, 0.0), convex_depth(&a, &b, rounding));
            let is_apart = smooth.depth < -1e-8 && found.depth < -1e-8;
            assert!(
                found.is_least && (is_apart || (found.depth - smooth.depth).abs() < 1e-8),
                "{found:?}, not {smooth:?}"
            );
        }
    }

    #[test]
    fn no_direction_is_shorter() {
        let mut random = SplitMix64::new(7);
        for _ in 0..300 {
            let mut points = |n: usize, size: f64| -> Vec<Point> {
                (0..n).map(|_| std::array::from_fn(|_| size * (random.unit() - 0.5))).collect()
            };
            let (a, b) = (points(12, 1.0), points(30, 0.6));
            let found = convex_depth(&a, &b, 0.0);
            assert!(found.is_least, "{found:?}");
            let difference = Difference { a: &a, b: &b };
            let reach = |direction: &Point| dot(direction, &difference.support(direction));
            assert!((reach(&found.direction) - found.depth).abs() < 1e-12);
            for _ in 0..2000 {
                if let Some(direction) = unit(&std::array::from_fn(|_| random.unit() - 0.5)) {
                    assert!(reach(&direction) > found.depth - 1e-8, "{direction:?} parts sooner than {found:?}");
                }
            }
        }
    }
}
