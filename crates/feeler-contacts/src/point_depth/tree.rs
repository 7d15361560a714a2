//! A tree of boxes over triangles, four to a node, so that a point, a box or a segment is tested against four at once.

use feeler_core::geometry::vectors::add;
use feeler_core::{Aabb, Point, Triangle};

/// Boxes of a node.
const WIDTH: usize = 4;

/// Where a box holds one triangle and no node.
const TRIANGLE: u32 = 1 << 31;

/// Where a node has no more boxes.
const NOTHING: u32 = u32::MAX;

/// Share by which squares of distances in float32 are less than they are computed, so that they are bounds.
const BELOW: f32 = 1.0 - 1e-6;

/// More than nodes of any path from the root, times the boxes that wait at each: a median halves the triangles below.
const MOST_WAITING: usize = 128;

/// Four boxes, an axis after the other, and the content of each.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
struct Node {
    lower: [[f32; WIDTH]; 3],
    upper: [[f32; WIDTH]; 3],
    child: [u32; WIDTH],
}

impl Node {
    const EMPTY: Node =
        Node { lower: [[f32::INFINITY; 4]; 3], upper: [[f32::NEG_INFINITY; 4]; 3], child: [NOTHING; 4] };

    fn put(&mut self, lane: usize, bounds: &Aabb, child: u32) {
        for a in 0..3 {
            self.lower[a][lane] = below(bounds.lower[a]);
            self.upper[a][lane] = above(bounds.upper[a]);
        }
        self.child[lane] = child;
    }

    /// No more than the squares of the distances of a point from the boxes. The point is between two others of float32.
    #[inline(always)]
    fn square_distances(&self, [low, high]: &[[f32; 3]; 2]) -> [f32; WIDTH] {
        let mut sums = [0.0f32; WIDTH];
        for a in 0..3 {
            for (lane, sum) in sums.iter_mut().enumerate() {
                let d = (self.lower[a][lane] - high[a]).max(low[a] - self.upper[a][lane]).max(0.0);
                *sum += d * d;
            }
        }
        sums.map(|sum| sum * BELOW)
    }

    /// No less than the heights of the boxes along a normal.
    #[inline(always)]
    fn greatest_heights(&self, normal: &Point) -> [f64; WIDTH] {
        let mut sums = [0.0f64; WIDTH];
        for a in 0..3 {
            let ends = if normal[a] > 0.0 { &self.upper[a] } else { &self.lower[a] };
            for (end, sum) in ends.iter().zip(&mut sums) {
                *sum += normal[a] * f64::from(*end);
            }
        }
        sums
    }

    /// Which boxes overlap another.
    #[inline(always)]
    fn overlapping(&self, [low, high]: &[[f32; 3]; 2]) -> [bool; WIDTH] {
        let mut all = [true; WIDTH];
        for a in 0..3 {
            for (lane, is_overlapping) in all.iter_mut().enumerate() {
                *is_overlapping &= (self.lower[a][lane] <= high[a]) & (low[a] <= self.upper[a][lane]);
            }
        }
        all
    }

    /// Which boxes, grown by a margin, a segment from a point may pass, of which the inverse of its direction is given.
    #[inline(always)]
    fn on_segment(&self, p: &Point, inverse: &Point, margin: f64) -> [bool; WIDTH] {
        let (mut from, mut to) = ([0.0f64; WIDTH], [1.0f64; WIDTH]);
        for a in 0..3 {
            for lane in 0..WIDTH {
                let low = f64::from(self.lower[a][lane]) - margin;
                let high = f64::from(self.upper[a][lane]) + margin;
                let [s, t] = [(low - p[a]) * inverse[a], (high - p[a]) * inverse[a]];
                // Where it runs in the plane of a side that one is NaN, which max and min leave out; the other says where it is.
                let (enters, leaves) = if inverse[a] < 0.0 { (t, s) } else { (s, t) };
                from[lane] = from[lane].max(enters);
                to[lane] = to[lane].min(leaves);
            }
        }
        // Above the rounding of the quotients.
        std::array::from_fn(|lane| from[lane] <= to[lane] + 1e-12)
    }
}

/// The content of a box of the tree.
#[derive(Debug, Clone, Copy)]
pub enum Inside {
    /// More boxes: a node.
    Node(u32),
    /// A triangle.
    Triangle(u32),
}

/// See the module.
#[derive(Debug)]
pub struct Tree {
    nodes: Vec<Node>,
}

impl Tree {
    /// Over triangles; and their order in the tree, in which they have to be put: its triangles are numbered so.
    pub fn new(triangles: &[Triangle]) -> (Tree, Vec<u32>) {
        let mut order: Vec<u32> = (0..triangles.len() as u32).collect();
        let centres: Vec<Point> = triangles.iter().map(|[p, q, r]| add(&add(p, q), r)).collect();
        let mut nodes = Vec::with_capacity(triangles.len() / 2 + 1);
        if !triangles.is_empty() {
            build(&mut nodes, (triangles, &centres), &mut order, 0);
        }
        (Tree { nodes }, order)
    }

    /// The contents of the boxes of a node, and the boxes; the root is 0.
    pub fn boxes(&self, node: u32) -> impl Iterator<Item = (Inside, Aabb)> + '_ {
        let node = self.nodes.get(node as usize).unwrap_or(&Node::EMPTY);
        node.child.iter().enumerate().filter(|(_, child)| **child != NOTHING).map(|(lane, child)| {
            let bounds = Aabb {
                lower: node.lower.map(|all| f64::from(all[lane])),
                upper: node.upper.map(|all| f64::from(all[lane])),
            };
            (inside(*child), bounds)
        })
    }

    /// Calls `measure` with the triangles that may be nearer to a point than the best; it returns the squared distance
    /// of each. Near boxes come first.
    #[inline(always)]
    pub fn for_each_near(&self, p: &Point, mut best: f64, mut measure: impl FnMut(u32) -> f64) {
        if self.nodes.is_empty() {
            return;
        }
        let p = [p.map(below), p.map(above)];
        let mut best32 = above(best);
        let mut waiting = [(0u32, 0.0f32); MOST_WAITING];
        let mut count = 1;
        while count > 0 {
            count -= 1;
            let (at, bound) = waiting[count];
            if bound > best32 {
                continue;
            }
            if at & TRIANGLE != 0 {
                let square = measure(at & !TRIANGLE);
                if square < best {
                    best = square;
                    best32 = above(best);
                }
                continue;
            }
            let node = &self.nodes[at as usize];
            let distances = node.square_distances(&p);
            let first = count;
            for (child, distance) in node.child.iter().zip(distances) {
                // Of no box it is infinite.
                if distance <= best32 && *child != NOTHING {
                    // The farthest first: they are taken from the end.
                    let mut place = count;
                    while place > first && waiting[place - 1].1 < distance {
                        waiting[place] = waiting[place - 1];
                        place -= 1;
                    }
                    waiting[place] = (*child, distance);
                    count += 1;
                }
            }
        }
    }

    /// At least the greatest height along a normal, from `height` of a triangle, and at most `slack` above it: of many
    /// triangles at nearly one height only some are evaluated.
    pub fn greatest(&self, normal: &Point, slack: f64, height: impl Fn(u32) -> f64) -> f64 {
        let (mut best, mut left_out) = (f64::NEG_INFINITY, f64::NEG_INFINITY);
        let mut waiting = [(0u32, f64::INFINITY); MOST_WAITING];
        let mut count = usize::from(!self.nodes.is_empty());
        while count > 0 {
            count -= 1;
            let (at, bound) = waiting[count];
            if bound <= best + slack {
                left_out = bound.max(left_out);
                continue;
            }
            if at & TRIANGLE != 0 {
                best = best.max(height(at & !TRIANGLE));
                continue;
            }
            let node = &self.nodes[at as usize];
            let bounds = node.greatest_heights(normal);
            let first = count;
            for (child, bound) in node.child.iter().zip(bounds) {
                if *child == NOTHING {
                    continue;
                }
                // The least first: they are taken from the end.
                let mut place = count;
                while place > first && waiting[place - 1].1 > bound {
                    waiting[place] = waiting[place - 1];
                    place -= 1;
                }
                waiting[place] = (*child, bound);
                count += 1;
            }
        }
        best.max(left_out)
    }

    /// Hands over the triangles whose boxes overlap a box, until one is taken.
    #[inline(always)]
    pub fn find_overlapping<T>(&self, bounds: &Aabb, take: impl FnMut(u32) -> Option<T>) -> Option<T> {
        let ends = [bounds.lower.map(below), bounds.upper.map(above)];
        self.find(|node| node.overlapping(&ends), take)
    }

    /// Hands over the triangles whose boxes, grown by a margin, a segment may pass, until one is taken.
    #[inline(always)]
    pub fn find_on_segment<T>(
        &self,
        [p, q]: [&Point; 2],
        margin: f64,
        take: impl FnMut(u32) -> Option<T>,
    ) -> Option<T> {
        let inverse: Point = std::array::from_fn(|a| 1.0 / (q[a] - p[a]));
        self.find(|node| node.on_segment(p, &inverse, margin), take)
    }

    #[inline(always)]
    fn find<T>(&self, is_asked: impl Fn(&Node) -> [bool; WIDTH], mut take: impl FnMut(u32) -> Option<T>) -> Option<T> {
        let mut waiting = [0u32; MOST_WAITING];
        let mut count = usize::from(!self.nodes.is_empty());
        while count > 0 {
            count -= 1;
            let at = waiting[count];
            if at & TRIANGLE != 0 {
                if let Some(taken) = take(at & !TRIANGLE) {
                    return Some(taken);
                }
                continue;
            }
            let node = &self.nodes[at as usize];
            let asked = is_asked(node);
            for lane in (0..WIDTH).rev() {
                if asked[lane] && node.child[lane] != NOTHING {
                    waiting[count] = node.child[lane];
                    count += 1;
                }
            }
        }
        None
    }
}

fn inside(child: u32) -> Inside {
    if child & TRIANGLE == 0 {
        Inside::Node(child)
    } else {
        Inside::Triangle(child & !TRIANGLE)
    }
}

fn below(x: f64) -> f32 {
    let near = x as f32;
    if f64::from(near) > x {
        near.next_down()
    } else {
        near
    }
}

fn above(x: f64) -> f32 {
    let near = x as f32;
    if f64::from(near) < x {
        near.next_up()
    } else {
        near
    }
}

/// Sorts triangles into a node and all below it, of which `first` come before; its number and its box.
fn build(
    nodes: &mut Vec<Node>,
    (triangles, centres): (&[Triangle], &[Point]),
    order: &mut [u32],
    first: usize,
) -> (u32, Aabb) {
    let at = nodes.len();
    nodes.push(Node::EMPTY);
    let mut bounds = Aabb::EMPTY;
    let mut rest = order;
    let mut before = first;
    let count = rest.len();
    if count > WIDTH {
        // By halves twice.
        split(centres, rest, count / 2);
        let (left, right) = rest.split_at_mut(count / 2);
        split(centres, left, left.len() / 2);
        split(centres, right, right.len() / 2);
    }
    let quarter = |n: usize| if count > WIDTH { n / 2 } else { 0 };
    let (half, other) = (count / 2, count - count / 2);
    let sizes = if count > WIDTH {
        [quarter(half), half - quarter(half), quarter(other), other - quarter(other)]
    } else {
        std::array::from_fn(|lane| usize::from(lane < count))
    };
    for (lane, size) in sizes.into_iter().enumerate() {
        let (own, others) = rest.split_at_mut(size);
        rest = others;
        let (child, around) = match own {
            [] => continue,
            [one] => (TRIANGLE | before as u32, Aabb::of_triangle(&triangles[*one as usize])),
            _ => build(nodes, (triangles, centres), own, before),
        };
        nodes[at].put(lane, &around, child);
        bounds = bounds.union(&around);
        before += size;
    }
    (at as u32, bounds)
}

/// Sorts those of the lower centres, along the longest extent of the centres, before the others.
fn split(centres: &[Point], order: &mut [u32], at: usize) {
    if at == 0 {
        return;
    }
    let mut middles = Aabb::EMPTY;
    order.iter().for_each(|i| middles.grow(&centres[*i as usize]));
    let extent = middles.extent();
    let axis = (0..3).max_by(|a, b| extent[*a].total_cmp(&extent[*b])).unwrap_or(0);
    order.select_nth_unstable_by(at, |p, q| {
        centres[*p as usize][axis].total_cmp(&centres[*q as usize][axis]).then(p.cmp(q))
    });
}

#[cfg(test)]
mod tests {
    use super::super::brute::{is_meeting, triangle};
    use super::*;
    use crate::point_depth::body::closest_on;
    use feeler_core::geometry::vectors::dot;
    use feeler_shapes::random::Random;

    /// Few and many, in general places, on a lattice, all the same, and far off, where float32 is coarse.
    fn sets(r: &mut Random) -> Vec<Vec<Triangle>> {
        let mut sets = Vec::new();
        for count in [0, 1, 2, 3, 4, 5, 6, 7, 8, 15, 16, 17, 63, 65, 400] {
            let general: Vec<Triangle> = (0..count).map(|_| triangle(r, 0.1)).collect();
            let far = |t: &Triangle| t.map(|p| [p[0] + 7e6, p[1] - 3e7, p[2] + 1.0]);
            sets.push(general.iter().map(far).collect());
            sets.push(general.iter().map(|t| t.map(|p| p.map(|x| (8.0 * x).round() / 8.0))).collect());
            sets.push(vec![triangle(r, 0.3); count]);
            sets.push(general);
        }
        sets
    }

    /// A tree, and the triangles in its order.
    fn tree_of(given: &[Triangle]) -> (Tree, Vec<Triangle>) {
        let (tree, order) = Tree::new(given);
        let mut sorted = order.clone();
        sorted.sort_unstable();
        assert!(sorted.into_iter().eq(0..given.len() as u32));
        (tree, order.iter().map(|i| given[*i as usize]).collect())
    }

    fn around(triangles: &[Triangle]) -> Aabb {
        triangles.iter().fold(Aabb::EMPTY, |around, t| around.union(&Aabb::of_triangle(t)))
    }

    /// A point in the box, or around it.
    fn point_in(r: &mut Random, bounds: &Aabb, beyond: f64) -> Point {
        std::array::from_fn(|a| {
            let share = r.real(-beyond, 1.0 + beyond);
            let (low, high) = if bounds.is_empty() { (0.0, 1.0) } else { (bounds.lower[a], bounds.upper[a]) };
            low + share * (high - low)
        })
    }

    fn is_within(inner: &Aabb, outer: &Aabb) -> bool {
        (0..3).all(|a| outer.lower[a] <= inner.lower[a] && inner.upper[a] <= outer.upper[a])
    }

    /// All triangles below a node, each of whose boxes is in the box around it.
    fn collect(tree: &Tree, node: u32, outer: Option<&Aabb>, triangles: &[Triangle], found: &mut Vec<u32>) {
        for (inside, bounds) in tree.boxes(node) {
            assert!(outer.is_none_or(|outer| is_within(&bounds, outer)));
            match inside {
                Inside::Node(node) => collect(tree, node, Some(&bounds), triangles, found),
                Inside::Triangle(i) => {
                    assert!(is_within(&Aabb::of_triangle(&triangles[i as usize]), &bounds));
                    found.push(i);
                }
            }
        }
    }

    #[test]
    fn every_triangle_is_in_one_box_and_each_box_in_that_of_its_node() {
        for set in sets(&mut Random::new(1)) {
            let (tree, triangles) = tree_of(&set);
            let mut found = Vec::new();
            collect(&tree, 0, None, &triangles, &mut found);
            found.sort_unstable();
            assert!(found.into_iter().eq(0..triangles.len() as u32));
        }
    }

    #[test]
    fn the_nearest_is_that_of_all_and_few_are_measured() {
        let mut r = Random::new(2);
        for set in sets(&mut r) {
            let (tree, triangles) = tree_of(&set);
            let (bounds, mut measured) = (around(&triangles), 0);
            for n in 0..40 {
                let p = match n % 4 {
                    0 if !triangles.is_empty() => triangles[n % triangles.len()][n % 3],
                    _ => point_in(&mut r, &bounds, 0.5),
                };
                let square = |i: u32| closest_on(&p, &triangles[i as usize]).0;
                let expected = (0..triangles.len() as u32).map(square).fold(f64::INFINITY, f64::min);
                for within in [f64::INFINITY, expected * 1.5 + 1e-9, expected] {
                    let mut best = within;
                    tree.for_each_near(&p, within, |i| {
                        measured += 1;
                        best = best.min(square(i));
                        square(i)
                    });
                    assert_eq!(best, expected.min(within), "{n} of {}", triangles.len());
                }
            }
            // Near boxes first, and cut by nearness: the set in general places is the last of four.
            if triangles.len() == 400 && bounds.longest() < 3.0 && triangles[0] != triangles[1] {
                assert!(measured < 16_000, "{measured}");
            }
        }
    }

    #[test]
    fn triangles_in_a_box_are_those_that_all_boxes_say() {
        let mut r = Random::new(3);
        for set in sets(&mut r) {
            let (tree, triangles) = tree_of(&set);
            let bounds = around(&triangles);
            // On the lattice, so that boxes touch; those of the tree are then exact.
            let is_lattice = triangles.iter().flatten().flatten().all(|x| (8.0 * x).fract() == 0.0 && x.abs() < 99.0);
            for _ in 0..30 {
                let (p, q) = (point_in(&mut r, &bounds, 0.2), point_in(&mut r, &bounds, 0.2));
                let mut asked = Aabb::EMPTY;
                [p, q].iter().for_each(|p| asked.grow(&p.map(|x| (8.0 * x).round() / 8.0)));
                let mut found = Vec::new();
                let none = tree.find_overlapping(&asked, |i| {
                    found.push(i);
                    None::<()>
                });
                found.sort_unstable();
                let is_in = |i: &u32| is_meeting(&Aabb::of_triangle(&triangles[*i as usize]), &asked);
                let expected: Vec<u32> = (0..triangles.len() as u32).filter(is_in).collect();
                assert!(none.is_none() && expected.iter().all(|i| found.binary_search(i).is_ok()));
                assert!(!is_lattice || found == expected, "{found:?} {expected:?}");
                let mut count = 0;
                let taken = tree.find_overlapping(&asked, |i| {
                    count += 1;
                    Some(i)
                });
                assert_eq!((taken.is_some(), count), (!found.is_empty(), usize::from(!found.is_empty())));
            }
        }
    }

    /// Whether a segment meets a box: it is clipped, one side after the other.
    fn is_passing(p: &Point, q: &Point, bounds: &Aabb, margin: f64) -> bool {
        let (mut from, mut to) = (0.0f64, 1.0f64);
        for a in 0..3 {
            let (low, high, d) = (bounds.lower[a] - margin, bounds.upper[a] + margin, q[a] - p[a]);
            if d == 0.0 {
                if p[a] < low || p[a] > high {
                    return false;
                }
                continue;
            }
            let (s, t) = ((low - p[a]) / d, (high - p[a]) / d);
            (from, to) = (from.max(s.min(t)), to.min(s.max(t)));
        }
        from <= to
    }

    #[test]
    fn triangles_on_a_segment_are_those_that_all_boxes_say() {
        let mut r = Random::new(4);
        for set in sets(&mut r) {
            let (tree, triangles) = tree_of(&set);
            let bounds = around(&triangles);
            for n in 0..60 {
                let (mut p, mut q) = (point_in(&mut r, &bounds, 0.3), point_in(&mut r, &bounds, 0.3));
                if n % 2 == 0 {
                    // Along an axis, or a plane, and on sides of boxes.
                    [p, q] = [p, q].map(|p| p.map(|x| (8.0 * x).round() / 8.0));
                    (0..3).filter(|a| *a != n % 3 && n % 4 == 0 || *a == n % 3 && n % 4 != 0).for_each(|a| q[a] = p[a]);
                }
                let margin = [0.0, 1e-3, 0.125][n % 3];
                let mut found = Vec::new();
                tree.find_on_segment([&p, &q], margin, |i| {
                    found.push(i);
                    None::<()>
                });
                for (i, t) in (0..).zip(&triangles) {
                    let around = Aabb::of_triangle(t);
                    let rounding = 1e-9 + 1e-6 * around.largest_coordinate();
                    let (is_on, is_near) =
                        (is_passing(&p, &q, &around, margin), is_passing(&p, &q, &around, margin + rounding));
                    let is_found = found.contains(&i);
                    assert!(is_near || !is_found, "{p:?} {q:?} {margin} {t:?}");
                    assert!(!is_on || is_found, "{p:?} {q:?} {margin} {t:?}");
                }
            }
        }
    }

    #[test]
    fn the_greatest_height_is_that_of_all_and_slack_spares_looks() {
        let mut r = Random::new(5);
        for set in sets(&mut r) {
            let (tree, triangles) = tree_of(&set);
            for n in 0..30 {
                let mut normal = r.point(-1.0, 1.0);
                (0..3).filter(|a| n % 3 == 0 && *a != n / 3 % 3).for_each(|a| normal[a] = 0.0);
                let height =
                    |i: u32| triangles[i as usize].map(|p| dot(&normal, &p)).into_iter().fold(f64::MIN, f64::max);
                let expected = (0..triangles.len() as u32).map(height).fold(f64::NEG_INFINITY, f64::max);
                let rounding = 1e-15 * around(&triangles).largest_coordinate().clamp(1.0, 1e9);
                for slack in [0.0, 0.01, 10.0] {
                    let looks = std::cell::Cell::new(0);
                    let found = tree.greatest(&normal, slack, |i| {
                        looks.set(looks.get() + 1);
                        height(i)
                    });
                    assert!(found >= expected && found <= expected + slack + rounding, "{found} {expected} {slack}");
                    assert!(slack > 0.0 || found == expected || found - expected <= rounding);
                    assert!(slack < 10.0 || looks.get() <= 1, "{} looks", looks.get());
                }
            }
        }
    }
}
