//! A tree of boxes over triangles, four to a node, so that a point, a box or a segment is asked of four at once.

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

/// More than nodes of any path from the root, times the boxes that wait at each: a median halves what is below.
const MOST_WAITING: usize = 128;

/// Four boxes, an axis after the other, and what is in each.
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
                // Where the direction has no extent along an axis these may be NaN, which min and max leave out.
                from[lane] = from[lane].max(s.min(t));
                to[lane] = to[lane].min(s.max(t));
            }
        }
        // Above the rounding of the quotients.
        std::array::from_fn(|lane| from[lane] <= to[lane] + 1e-12)
    }
}

/// What is in a box of the tree.
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

    /// What is in the boxes of a node, and the boxes; the root is 0.
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

    /// Hands over the triangles that may be nearer to a point than the best, whose square distance `measure` tells for each: the near boxes
    /// first.
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

    /// No less than the greatest height along a normal, of which `height` tells that of a triangle, and by no more than `slack` above it:
    /// of many triangles at nearly one height only some are looked at.
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
