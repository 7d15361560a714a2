//! The border of an open surface: its edges that join no other triangle.

use std::collections::HashSet;

use feeler_core::constants::NONE;
use feeler_core::geometry::vectors::{add, length, scaled, square_to_segment, sub};
use feeler_core::{Aabb, Point, Triangle};

use super::body::{closest_on, distance_to, Body, Closest};
use super::tree::Tree;

/// A point nearer to an edge than this many roundings is on it.
const ON_EDGE: f64 = 8.0;

/// The border edges of a body.
#[derive(Debug)]
pub struct Border {
    /// As triangles without area.
    edges: Vec<Triangle>,
    tree: Tree,
    /// By triangle, whether its edge from corner `k` to corner `k + 1` is one of them.
    is_border: Vec<[bool; 3]>,
    corners: HashSet<[u64; 3]>,
    within: f64,
}

impl Border {
    /// Of a body whose triangles have these neighbours. An edge that lies on another triangle is none.
    pub fn new(body: &Body, neighbours: &[[u32; 3]]) -> Border {
        let within = ON_EDGE * body.rounding();
        let (mut edges, mut corners) = (Vec::new(), HashSet::new());
        let mut is_border = vec![[false; 3]; neighbours.len()];
        for (i, beside) in (0u32..).zip(neighbours) {
            let t = body.triangle(i);
            for k in 0..3 {
                let (p, q) = (t[k], t[(k + 1) % 3]);
                if beside[k] != NONE || is_on_another(body, i, &scaled(&add(&p, &q), 0.5), within) {
                    continue;
                }
                is_border[i as usize][k] = true;
                corners.extend([key(&p), key(&q)]);
                edges.push([p, q, q]);
            }
        }
        let (tree, order) = Tree::new(&edges);
        let edges = order.iter().map(|at| edges[*at as usize]).collect();
        Border { edges, tree, is_border, corners, within }
    }

    /// The distance of a point from the border, metres; infinite if there is none.
    pub fn distance(&self, p: &Point) -> f64 {
        let mut best = f64::INFINITY;
        self.tree.for_each_near(p, best, |i| {
            let square = closest_on(p, &self.edges[i as usize]).0;
            best = best.min(square);
            square
        });
        best.sqrt()
    }

    /// Whether a closest point of the body is on its border.
    pub fn has(&self, body: &Body, closest: &Closest) -> bool {
        let (t, p) = (body.triangle(closest.triangle), &closest.point);
        let square = self.within * self.within;
        (0..3).any(|k| {
            let is_corner = || length(&sub(p, &t[k])) <= self.within && self.corners.contains(&key(&t[k]));
            self.is_border[closest.triangle as usize][k] && square_to_segment(p, &t[k], &t[(k + 1) % 3]) <= square
                || is_corner()
        })
    }
}

fn key(p: &Point) -> [u64; 3] {
    // 0.0 and -0.0 are one.
    p.map(|x| (x + 0.0).to_bits())
}

/// Whether a point of a triangle is on another one, too.
fn is_on_another(body: &Body, own: u32, p: &Point, within: f64) -> bool {
    let around = Aabb { lower: p.map(|x| x - within), upper: p.map(|x| x + within) };
    let is_at = |j: u32| (j != own && distance_to(p, body.triangle(j)) <= within).then_some(());
    body.find_overlapping(&around, is_at).is_some()
}
