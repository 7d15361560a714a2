//! The search along a ray in plain float64: for every store, and for rays from so far away that float32 cannot resolve
//! them.
//!
//! Boxes are intersected slab by slab (T. Kay and J. Kajiya, *Ray tracing complex scenes*, 1986), depth first, the
//! nearer child first.

use super::plain_search::{Cells, Item};
use super::selection::Selection;
use super::sink::RaySink;
use crate::constants::{RAY_ROUNDOFFS, UNIT_ROUNDOFF};
use crate::geometry::bounds::{Aabb, Point};
use crate::geometry::vectors::largest;
use crate::mesh::triangle_mesh::Mesh;
use feeler_lanes::Checked;

/// A ray to search along.
pub(crate) struct RayPath<'a> {
    /// Metres.
    pub origin: Point,
    /// Not zero.
    pub direction: Point,
    /// Start of the relevant range, rounded down; shares of the direction.
    pub from: f64,
    /// The selection. A hint: others may be offered all the same.
    pub selection: &'a Selection,
    /// The instruction set.
    pub lanes: Checked,
}

/// Working memory of a search.
#[derive(Debug, Default)]
pub struct RayScratch {
    /// Nodes to be looked into: where the ray enters them, level and place.
    pub(super) stack: Vec<(f32, u8, u32)>,
}

/// Hands `wanted` every triangle that the ray may meet within its limit.
pub(crate) fn search_ray<C: Cells, W: RaySink>(cells: &C, mesh: &Mesh, path: &RayPath<'_>, wanted: &mut W) {
    let slabs = Slabs::new(path, &mesh.bounds());
    let mut stack = vec![(path.from, Item::Cell(cells.root()))];
    while let Some((enters, item)) = stack.pop() {
        if enters > wanted.limit() {
            continue;
        }
        match item {
            Item::Triangle(triangle) => wanted.take(&[triangle]),
            Item::Cell(cell) => {
                let (first, limit) = (stack.len(), wanted.limit());
                cells.open(cell, path.selection, &mut |below, bounds| {
                    stack.extend(slabs.enter(&bounds, limit).map(|enters| (enters, below)));
                });
                stack[first..].sort_unstable_by(|p, q| q.0.total_cmp(&p.0));
            }
        }
    }
}

/// A ray, and by how much boxes grow for it.
struct Slabs<'a> {
    path: &'a RayPath<'a>,
    margin: f64,
}

impl Slabs<'_> {
    fn new<'a>(path: &'a RayPath<'a>, bounds: &Aabb) -> Slabs<'a> {
        // A box of the index reaches beyond the mock-up's own by little; quotients are monotone, and need no margin.
        let size = largest(&path.origin) + bounds.largest_coordinate() + bounds.longest();
        Slabs { path, margin: RAY_ROUNDOFFS * UNIT_ROUNDOFF * size }
    }

    /// Where the ray enters a box, within its searched part; `None` where it surely does not.
    fn enter(&self, b: &Aabb, limit: f64) -> Option<f64> {
        let RayPath { origin, direction, from, .. } = self.path;
        let (mut enters, mut leaves) = (*from, limit);
        for a in 0..3 {
            let sides = [b.lower[a] - self.margin - origin[a], b.upper[a] + self.margin - origin[a]];
            if direction[a] == 0.0 {
                if sides[0] > 0.0 || sides[1] < 0.0 {
                    return None;
                }
            } else {
                let [p, q] = sides.map(|side| side / direction[a]);
                enters = enters.max(p.min(q));
                leaves = leaves.min(p.max(q));
            }
        }
        (enters <= leaves).then_some(enters)
    }
}
