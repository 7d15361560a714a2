//! The search in plain float64: for every store, and for tools so far away that float32 cannot separate near from far.
//!
//! Branch and bound over two trees of boxes, depth first, the nearer child first (N. Roussopoulos, S. Kelley and F. Vincent,
//! *Nearest neighbor queries*, 1995; of pairs of boxes: E. Larsen, S. Gottschalk, M. Lin and D. Manocha, *Fast proximity queries
//! with swept sphere volumes*, 1999).

use super::interner::{pair_key, KeySet};
use super::selection::Selection;
use super::sink::{NearSink, NearTool};
use crate::geometry::bounds::Aabb;
use crate::geometry::distance_triangle_triangle::distance_bound;
use feeler_lanes::LANES;

/// A tree of boxes over the mock-up's triangles, as a store offers it.
pub trait Cells {
    /// A node.
    type Cell: Copy;

    /// The node around everything.
    fn root(&self) -> Self::Cell;

    /// Calls `visit` with each child of a node and a box (world, metres) around it. Every triangle that reaches into
    /// the node is below it, at least with the share that does; triangles that the selection leaves out may be missing.
    fn open(&self, cell: Self::Cell, selection: &Selection, visit: &mut dyn FnMut(Item<Self::Cell>, Aabb));
}

/// The content of a node.
#[derive(Debug, Clone, Copy)]
pub enum Item<C> {
    /// A node.
    Cell(C),
    /// A triangle of the mock-up.
    Triangle(u32),
}

/// A part of the tool.
#[derive(Debug, Clone, Copy)]
enum Member {
    /// An entry of a level of the tool's tree: 0 for clusters.
    Entry { level: usize, index: usize },
    /// A piece of the triangle in a slot.
    Piece(u32),
}

/// A pair of boxes to be looked into.
#[derive(Debug, Clone, Copy)]
struct Pair<C> {
    bound: f64,
    /// Between the middles: says which of two that overlap is more promising.
    middles: f64,
    member: (Member, Aabb),
    item: (Item<C>, Aabb),
}

/// Working memory of a search.
#[derive(Debug, Default)]
pub struct SearchScratch {
    seen: KeySet,
}

/// Hands `wanted` every pair of triangles that may be within its bound, nearest boxes first.
pub fn search<C: Cells, W: NearSink>(cells: &C, at: &NearTool<'_>, scratch: &mut SearchScratch, wanted: &mut W) {
    scratch.seen.clear();
    let NearTool { mockup, tool, pose, .. } = at;
    let margin = wanted.margin();
    let root = Member::Entry { level: tool.height(), index: 0 };
    let mut stack: Vec<Pair<C::Cell>> = Vec::new();
    push(
        &mut stack,
        (root, pose.apply_box(&tool.mesh().bounds(), margin)),
        (Item::Cell(cells.root()), mockup.mesh().bounds()),
        wanted.bound(),
    );
    while let Some(Pair { bound, member, item, .. }) = stack.pop() {
        if wanted.must_stop() {
            return;
        }
        if bound > wanted.bound() {
            continue;
        }
        let from = stack.len();
        match (member.0, item.0) {
            (Member::Piece(slot), Item::Triangle(triangle)) => {
                if wanted.is_collecting() {
                    if wanted.collect(slot, triangle, bound) {
                        return;
                    }
                    continue;
                }
                // A bound only falls, so a pair needs no second look.
                if scratch.seen.insert(pair_key(slot, triangle)) && wanted.take(slot, triangle) {
                    return;
                }
            }
            (Member::Entry { level, index }, other)
                if matches!(other, Item::Triangle(_)) || size(&member.1) >= size(&item.1) =>
            {
                for i in 0..LANES {
                    let child = LANES * index + i;
                    let (below, bounds) = if level > 0 {
                        let boxes = &tool.children(level)[index];
                        if boxes.used >> i & 1 == 0 {
                            break;
                        }
                        (Member::Entry { level: level - 1, index: child }, boxes.bounds(i, tool.unit()))
                    } else {
                        let cluster = &tool.clusters()[index];
                        if cluster.corners.used >> i & 1 == 0 {
                            break;
                        }
                        (Member::Piece(cluster.slots[i]), cluster.corners.bounds(i, tool.unit()))
                    };
                    push(&mut stack, (below, pose.apply_box(&bounds, margin)), item, wanted.bound());
                }
            }
            (_, Item::Cell(cell)) => {
                let limit = wanted.bound();
                cells.open(cell, at.selection, &mut |below, bounds| push(&mut stack, member, (below, bounds), limit));
            }
            (Member::Entry { .. }, Item::Triangle(_)) => unreachable!("an entry is opened for a triangle"),
        }
        // The nearest goes on top.
        stack[from..]
            .sort_unstable_by(|a, b| b.bound.total_cmp(&a.bound).then_with(|| b.middles.total_cmp(&a.middles)));
    }
}

fn push<C>(stack: &mut Vec<Pair<C>>, member: (Member, Aabb), item: (Item<C>, Aabb), limit: f64) {
    let bound = distance_bound(&member.1, &item.1);
    if bound <= limit {
        let middle = |b: &Aabb, a: usize| 0.5 * b.lower[a] + 0.5 * b.upper[a];
        let middles = (0..3).map(|a| (middle(&member.1, a) - middle(&item.1, a)).abs()).sum();
        stack.push(Pair { bound, middles, member, item });
    }
}

fn size(b: &Aabb) -> f64 {
    b.extent().iter().fold(0.0, |m, x| m.max(*x))
}
