//! Links between the connected surfaces of a tool.

use std::collections::BTreeMap;

use super::moving_tool::Tool;
use crate::constants::NEEDLE_WIDTH;
use crate::geometry::bounds::Point;
use crate::geometry::vectors::sub;
use crate::mesh::median::{self, Cells};
use crate::mesh::topology::adjacency::Adjacency;
use crate::mesh::topology::closed_shells::Surfaces;
use crate::mesh::triangle_mesh::Mesh;

/// A corner of each connected surface of a tool, and links from each to the next: if a link hits nothing, both of its
/// ends lie on one side of everything.
#[derive(Debug)]
pub struct SurfaceLinks {
    /// Triangles whose first corners these are; neighbours in space are neighbours here.
    pub ends: Vec<u32>,
    /// The first triangle of each connected surface.
    pub surfaces: Vec<u32>,
    /// Where each of these is among the ends: several whose first corners coincide have one.
    pub end_of: Vec<u32>,
    /// The connected surface of each triangle.
    pub surface_of: Vec<u32>,
    /// A triangle for each way, which is one of its edges; `None` where there are none.
    pub ways: Option<Box<Tool>>,
}

impl SurfaceLinks {
    /// Between the surfaces of a tool's mesh.
    pub(crate) fn new(mesh: &Mesh, adjacency: &Adjacency) -> SurfaceLinks {
        let first = |t: u32| mesh.triangle(t)[0];
        let Surfaces { first: surfaces, of: surface_of } = Surfaces::new(mesh, &adjacency.neighbours);
        let mut ends = surfaces.clone();
        let place = |t: &u32| first(*t).map(|x| (x + 0.0).to_bits());
        ends.sort_by_key(place);
        ends.dedup_by_key(|t| place(t));
        let cells = Cells::new(&mesh.bounds());
        let mut order: Vec<(u64, u32)> = ends.iter().map(|t| (cells.middle(&first(*t), &first(*t)), *t)).collect();
        median::order(&mut order, 2);
        ends = order.into_iter().map(|(_, t)| t).collect();
        let vertices: Vec<Point> = ends.windows(2).flat_map(|pair| needle(&first(pair[0]), &first(pair[1]))).collect();
        let faces = (0..vertices.len() as u32 / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let places: BTreeMap<[u64; 3], u32> = ends.iter().map(place).zip(0..).collect();
        let end_of = surfaces.iter().map(|t| places[&place(t)]).collect();
        SurfaceLinks { ends, surfaces, end_of, surface_of, ways: Tool::new(vertices, faces).ok().map(Box::new) }
    }
}

/// A triangle with an edge from `p` to `q`, and not much more.
fn needle(p: &Point, q: &Point) -> [Point; 3] {
    let way = sub(q, p);
    let across = (0..3).min_by(|a, b| way[*a].abs().total_cmp(&way[*b].abs())).unwrap_or(0);
    let mut aside = *q;
    aside[across] += NEEDLE_WIDTH * way.iter().map(|x| x.abs()).fold(0.0, f64::max);
    [*p, *q, aside]
}
