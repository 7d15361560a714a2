//! The blocks as a tree of float64 boxes, for the plain search.

use super::node::{Node, FANOUT};
use super::tree::Blocks;
use crate::constants::SIDE_ROUNDING;
use crate::geometry::bounds::Aabb;
use crate::index::plain_search::{Cells, Item};
use crate::index::selection::{there as selected, Selection};

impl Cells for Blocks {
    /// Level and node.
    type Cell = (usize, u32);

    fn root(&self) -> (usize, u32) {
        (self.levels.len() - 1, 0)
    }

    fn open(
        &self,
        (level, index): (usize, u32),
        selection: &Selection,
        visit: &mut dyn FnMut(Item<(usize, u32)>, Aabb),
    ) {
        let node = &self.levels[level][index as usize];
        let there = selected(selection.children(level), index, u32::MAX);
        for i in 0..FANOUT as u32 {
            if node.valid >> i & 1 == 0 {
                break;
            }
            let child = FANOUT as u32 * index + i;
            if there >> i & 1 == 0 || level == 0 && !selection.has(self.triangle(child as usize)) {
                continue;
            }
            if level > 0 {
                let b = self.levels[level - 1][child as usize].bounds();
                visit(Item::Cell((level - 1, child)), self.in_metres(|a| (b.lower[a].into(), b.upper[a].into())));
            } else {
                visit(Item::Triangle(self.triangle(child as usize)), self.piece_bounds(node, i as usize));
            }
        }
    }
}

impl Blocks {
    /// The largest box that a piece's box in bytes may stand for: half a byte more on each side, and a little.
    fn piece_bounds(&self, node: &Node, piece: usize) -> Aabb {
        let (boxes, upper) = node.byte_boxes();
        self.in_metres(|a| {
            let origin = f64::from(boxes.origin[a]);
            let unit = (f64::from(upper[a]) - origin) / 255.0;
            let low = 254.49 - f64::from(boxes.sides[a][piece]);
            let high = f64::from(boxes.sides[a][FANOUT + piece]) + 0.51;
            (origin + low * unit - SIDE_ROUNDING, origin + high * unit + SIDE_ROUNDING)
        })
    }

    fn in_metres(&self, sides: impl Fn(usize) -> (f64, f64)) -> Aabb {
        let mut b = Aabb::EMPTY;
        for a in 0..3 {
            let (lower, upper) = sides(a);
            b.lower[a] = (lower - SIDE_ROUNDING) / self.frame.scale + self.frame.origin[a];
            b.upper[a] = (upper + SIDE_ROUNDING) / self.frame.scale + self.frame.origin[a];
        }
        b
    }
}
