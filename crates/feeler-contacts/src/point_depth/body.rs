//! The surface of a part under a tree of boxes, for points: which of its points is closest, and whether a point is inside it.

use feeler_core::geometry::ray_crossings::{crossing, median, ray_count, ray_end, RAY_OFFSETS};
use feeler_core::geometry::vectors::{add, along, cross, dot, normal, scaled, sub};
use feeler_core::mesh::topology::adjacency::Adjacency;
use feeler_core::{Aabb, Point, Triangle};

use crate::constants::{BODY_ROUNDING, SLIVER_HEIGHT, SLIVER_NORMAL, SURFACE_ROUNDOFFS};

/// Most triangles of a leaf.
const LEAF: usize = 4;

/// A box of the tree, relative to the body's origin.
#[derive(Debug, Clone, Copy)]
pub struct Node {
    lower: [f32; 3],
    upper: [f32; 3],
    /// The first of its triangles; of an inner one the first of its two children.
    first: u32,
    /// How many triangles; 0: an inner one.
    count: u32,
}

impl Node {
    fn around(bounds: &Aabb) -> Node {
        let down = |x: f64| if f64::from(x as f32) > x { (x as f32).next_down() } else { x as f32 };
        let up = |x: f64| if f64::from(x as f32) < x { (x as f32).next_up() } else { x as f32 };
        Node { lower: bounds.lower.map(down), upper: bounds.upper.map(up), first: 0, count: 0 }
    }

    /// The same in float64, metres.
    pub fn bounds(&self) -> Aabb {
        Aabb { lower: self.lower.map(f64::from), upper: self.upper.map(f64::from) }
    }

    #[inline(always)]
    fn square_distance(&self, p: &Point) -> f64 {
        let mut sum = 0.0;
        for a in 0..3 {
            let d = (f64::from(self.lower[a]) - p[a]).max(p[a] - f64::from(self.upper[a])).max(0.0);
            sum += d * d;
        }
        sum
    }

    #[inline(always)]
    fn is_overlapping(&self, bounds: &Aabb) -> bool {
        (0..3).all(|a| f64::from(self.lower[a]) <= bounds.upper[a] && bounds.lower[a] <= f64::from(self.upper[a]))
    }
}

/// A little more than 1: above the rounding of heights over planes. It is no bound of distances, only of what is looked at.
const ABOVE: f64 = 1.0 + 1e-6;

/// What is closest to a point.
#[derive(Debug, Clone, Copy)]
pub struct Closest {
    /// Metres.
    pub distance: f64,
    /// Its place in the body's triangles.
    pub triangle: u32,
    /// On it, relative to the body's origin.
    pub point: Point,
}

/// One part's surface. All is relative to its origin, so that parts far off are as exact as near ones.
#[derive(Debug)]
pub struct Body {
    origin: Point,
    bounds: Aabb,
    /// What rounding may move points of it by, metres.
    rounding: f64,
    triangles: Vec<Triangle>,
    /// The plane of each: its unit normal, and the height of the origin below it; of slivers all zero.
    planes: Vec<[f64; 4]>,
    /// For each of them, as [`Adjacency::outward`].
    senses: Vec<i8>,
    nodes: Vec<Node>,
    has_cracks: bool,
    is_closed: bool,
}

impl Body {
    /// Of triangles in the world, each with its number in an adjacency.
    pub fn new(given: impl Iterator<Item = (u32, Triangle)> + Clone, adjacency: &Adjacency) -> Body {
        let mut world = Aabb::EMPTY;
        given.clone().flat_map(|(_, t)| t).for_each(|p| world.grow(&p));
        let middle = |a: usize| 0.5 * world.lower[a] + 0.5 * world.upper[a];
        let origin: Point = if world.is_empty() { [0.0; 3] } else { std::array::from_fn(middle) };
        let (numbers, moved): (Vec<u32>, Vec<Triangle>) =
            given.map(|(number, t)| (number, t.map(|p| sub(&p, &origin)))).unzip();
        let mut order: Vec<u32> = (0..moved.len() as u32).collect();
        let mut nodes = Vec::new();
        if !moved.is_empty() {
            nodes.push(Node::around(&Aabb::EMPTY));
            let centres: Vec<Point> = moved.iter().map(|[p, q, r]| add(&add(p, q), r)).collect();
            build(&mut nodes, 0, (&moved, &centres), &mut order, 0);
        }
        let bounds = nodes.first().map_or(Aabb::EMPTY, Node::bounds);
        let senses: Vec<i8> = order.iter().map(|i| adjacency.outward[numbers[*i as usize] as usize]).collect();
        let triangles: Vec<Triangle> = order.iter().map(|i| moved[*i as usize]).collect();
        drop(moved);
        Body {
            origin,
            rounding: (BODY_ROUNDING * bounds.largest_coordinate()).max(SURFACE_ROUNDOFFS * last_place(&world)),
            bounds,
            planes: triangles.iter().map(plane_of).collect(),
            triangles,
            is_closed: senses.iter().any(|sense| *sense != 0),
            senses,
            nodes,
            has_cracks: adjacency.has_cracks,
        }
    }

    /// What is added to points that are relative to it to have them in the world.
    pub fn origin(&self) -> &Point {
        &self.origin
    }

    /// The box around it, relative to its origin.
    pub fn bounds(&self) -> &Aabb {
        &self.bounds
    }

    /// What rounding may move points by that are computed near it, metres.
    pub fn rounding(&self) -> f64 {
        self.rounding
    }

    /// Whether some of its surfaces are closed, so that it has an inside.
    pub fn is_closed(&self) -> bool {
        self.is_closed
    }

    /// How many triangles it has.
    pub fn len(&self) -> usize {
        self.triangles.len()
    }

    /// One of its triangles.
    pub fn triangle(&self, i: u32) -> &Triangle {
        &self.triangles[i as usize]
    }

    /// The outward unit normal of one of its triangles; `None` of an open surface.
    pub fn outward(&self, i: u32) -> Option<Point> {
        let sense = f64::from(self.senses[i as usize]);
        (sense != 0.0).then(|| normal(&self.triangles[i as usize])).flatten().map(|n| scaled(&n, sense))
    }

    /// A node of the tree; 0 is the root.
    pub fn node(&self, i: u32) -> &Node {
        &self.nodes[i as usize]
    }

    /// What is below a node: its children, or its triangles.
    pub fn below(&self, i: u32) -> Below {
        let Node { first, count, .. } = self.nodes[i as usize];
        if count == 0 {
            Below::Nodes([first, first + 1])
        } else {
            Below::Triangles(first..first + count)
        }
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
        let mut best_above = best * ABOVE;
        let mut found = None;
        if self.nodes.is_empty() || self.nodes[0].square_distance(p) > best {
            return None;
        }
        let mut stack = [(0u32, 0.0f64); 64];
        let mut depth = 1;
        while depth > 0 {
            depth -= 1;
            let (at, bound) = stack[depth];
            if bound > best {
                continue;
            }
            let node = &self.nodes[at as usize];
            if node.count == 0 {
                let [a, b] = [node.first, node.first + 1];
                let (da, db) = (self.nodes[a as usize].square_distance(p), self.nodes[b as usize].square_distance(p));
                let (near, far) = if da <= db { ((a, da), (b, db)) } else { ((b, db), (a, da)) };
                for child in [far, near] {
                    if child.1 <= best {
                        stack[depth] = child;
                        depth += 1;
                    }
                }
                continue;
            }
            for i in node.first..node.first + node.count {
                let [x, y, z, offset] = self.planes[i as usize];
                let height = x * p[0] + y * p[1] + z * p[2] - offset;
                if height * height > best_above {
                    continue;
                }
                let (square, point) = closest_on(p, &self.triangles[i as usize]);
                if square < best {
                    (best, best_above) = (square, square * ABOVE);
                    found = Some((i, point));
                }
            }
        }
        found.map(|(triangle, point)| Closest { distance: best.sqrt(), triangle, point })
    }

    /// Hands over the triangles whose boxes overlap a box, until one is taken.
    pub fn find_overlapping<T>(&self, bounds: &Aabb, mut take: impl FnMut(u32) -> Option<T>) -> Option<T> {
        let mut stack = [0u32; 64];
        let mut depth = usize::from(!self.nodes.is_empty());
        while depth > 0 {
            depth -= 1;
            let node = &self.nodes[stack[depth] as usize];
            if !node.is_overlapping(bounds) {
                continue;
            }
            if node.count == 0 {
                stack[depth] = node.first + 1;
                stack[depth + 1] = node.first;
                depth += 2;
                continue;
            }
            for i in node.first..node.first + node.count {
                if let Some(taken) = take(i) {
                    return Some(taken);
                }
            }
        }
        None
    }

    /// Whether a point that is not on the surface is inside a closed surface, as windings count; `None` where no ray decides.
    pub fn is_inside(&self, p: &Point) -> Option<bool> {
        let is_out = (0..3).any(|a| p[a] < self.bounds.lower[a] || p[a] > self.bounds.upper[a]);
        if is_out || !self.is_closed {
            return Some(false);
        }
        let mut decided = Vec::new();
        for offset in &RAY_OFFSETS {
            let q = ray_end(p, &self.bounds, offset);
            decided.extend(self.winding(p, &q));
            if decided.len() == ray_count(self.has_cracks) {
                break;
            }
        }
        (!decided.is_empty()).then(|| median(decided) != 0)
    }

    /// How often the surface winds around a point, counted along a ray; `None` where the ray meets an edge.
    fn winding(&self, p: &Point, q: &Point) -> Option<i32> {
        let direction = sub(q, p);
        let inverse = direction.map(|d| 1.0 / d);
        let mut sum = 0;
        let mut stack = [0u32; 64];
        let mut depth = 1;
        while depth > 0 {
            depth -= 1;
            let node = &self.nodes[stack[depth] as usize];
            if !is_on_segment(node, p, &inverse, self.rounding) {
                continue;
            }
            if node.count == 0 {
                stack[depth] = node.first + 1;
                stack[depth + 1] = node.first;
                depth += 2;
                continue;
            }
            for i in node.first as usize..(node.first + node.count) as usize {
                let sense = i32::from(self.senses[i]);
                if sense != 0 {
                    sum += sense * crossing(p, q, &self.triangles[i])?;
                }
            }
        }
        Some(sum)
    }
}

/// See [`Body::below`].
pub enum Below {
    /// An inner node.
    Nodes([u32; 2]),
    /// A leaf.
    Triangles(std::ops::Range<u32>),
}

/// The unit in the last place of the largest coordinate of a box.
fn last_place(bounds: &Aabb) -> f64 {
    let largest = bounds.largest_coordinate();
    largest.next_up() - largest
}

/// Whether the segment with this inverse of its direction may pass a box.
fn is_on_segment(node: &Node, p: &Point, inverse: &Point, margin: f64) -> bool {
    let (mut from, mut to) = (0.0f64, 1.0f64);
    for a in 0..3 {
        let (low, high) = (f64::from(node.lower[a]) - margin, f64::from(node.upper[a]) + margin);
        let [s, t] = [(low - p[a]) * inverse[a], (high - p[a]) * inverse[a]];
        // Where the direction has no extent along an axis, these are infinite or NaN, which min and max leave out.
        if s.is_nan() || t.is_nan() {
            continue;
        }
        from = from.max(s.min(t));
        to = to.min(s.max(t));
    }
    // Above the rounding of the quotients.
    from <= to + 1e-12
}

/// Sorts triangles into a node and all below it.
fn build(
    nodes: &mut Vec<Node>,
    at: usize,
    (triangles, centres): (&[Triangle], &[Point]),
    order: &mut [u32],
    first: usize,
) {
    let mut bounds = Aabb::EMPTY;
    let mut middles = Aabb::EMPTY;
    for i in order.iter() {
        bounds = bounds.union(&Aabb::of_triangle(&triangles[*i as usize]));
        middles.grow(&centres[*i as usize]);
    }
    nodes[at] = Node::around(&bounds);
    if order.len() <= LEAF {
        (nodes[at].first, nodes[at].count) = (first as u32, order.len() as u32);
        return;
    }
    let extent = middles.extent();
    let axis = (0..3).max_by(|a, b| extent[*a].total_cmp(&extent[*b])).unwrap_or(0);
    let half = order.len() / 2;
    order.select_nth_unstable_by(half, |p, q| {
        centres[*p as usize][axis].total_cmp(&centres[*q as usize][axis]).then(p.cmp(q))
    });
    let children = nodes.len();
    nodes[at].first = children as u32;
    nodes.extend([Node::around(&Aabb::EMPTY); 2]);
    let (left, right) = order.split_at_mut(half);
    build(nodes, children, (triangles, centres), left, first);
    build(nodes, children + 1, (triangles, centres), right, first + half);
}

fn plane_of(t: &Triangle) -> [f64; 4] {
    let (ab, ac) = (sub(&t[1], &t[0]), sub(&t[2], &t[0]));
    let (bc, n) = (sub(&t[2], &t[1]), cross(&ab, &ac));
    let square = dot(&n, &n);
    let longest = dot(&ab, &ab).max(dot(&bc, &bc)).max(dot(&ac, &ac));
    // Of slivers normals are rounding, and so may be heights.
    if square <= SLIVER_NORMAL * SLIVER_NORMAL * longest * longest {
        return [0.0; 4];
    }
    let n = scaled(&n, 1.0 / square.sqrt());
    [n[0], n[1], n[2], dot(&n, &t[0])]
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
    let mut is_over = square > SLIVER_HEIGHT * SLIVER_HEIGHT * longest * longest;
    let mut best = (f64::INFINITY, *a);
    for (from, side, to) in sides {
        if dot(&cross(&n, side), to) > 0.0 && square > 0.0 {
            continue;
        }
        is_over = false;
        let size = dot(side, side);
        let s = if size > 0.0 { (dot(to, side) / size).clamp(0.0, 1.0) } else { 0.0 };
        let apart = along(to, -s, side);
        let distance = dot(&apart, &apart);
        if distance < best.0 {
            best = (distance, along(from, s, side));
        }
    }
    if is_over {
        let height = dot(&n, &ap);
        return (height * height / square, along(p, -height / square, &n));
    }
    if best.0 == f64::INFINITY {
        // A sliver below or above: the nearest of all sides.
        for (from, side, to) in sides {
            let size = dot(side, side);
            let s = if size > 0.0 { (dot(to, side) / size).clamp(0.0, 1.0) } else { 0.0 };
            let apart = along(to, -s, side);
            let distance = dot(&apart, &apart);
            if distance < best.0 {
                best = (distance, along(from, s, side));
            }
        }
    }
    best
}

/// The distance to a triangle, metres.
pub fn distance_to(p: &Point, t: &Triangle) -> f64 {
    closest_on(p, t).0.sqrt()
}
