//! Space, halved down to blocks, with the steps near each.

use feeler_core::geometry::vectors::{length, sub};
use feeler_core::Point;

use super::block::Field;
use super::hull::Until;
use crate::constants::BLOCK;

/// A cube of the grid.
pub struct Cube {
    /// Its lowest node.
    pub at: [u32; 3],
    /// Cells along a side: those of a block, doubled some times.
    pub side: u32,
    /// Steps whose hulls may be near it.
    pub near: Vec<u32>,
}

impl Cube {
    pub fn is_block(&self) -> bool {
        self.side == BLOCK as u32
    }

    /// Its eight halves in which the surface may be.
    pub fn halves(&self, field: &Field<'_>) -> Vec<Cube> {
        let side = self.side / 2;
        let half = |c: u32| {
            let at = std::array::from_fn(|a| self.at[a] + side * (c >> a & 1));
            Some(Cube { at, side, near: near(field, at, side, &self.near)? })
        };
        (0..8).filter_map(half).filter(|cube| !cube.near.is_empty()).collect()
    }
}

/// Those steps whose hulls are near a cube, of some; `None` where it lies in one of them.
fn near(field: &Field<'_>, at: [u32; 3], side: u32, steps: &[u32]) -> Option<Vec<u32>> {
    let [low, high] = [at, at.map(|x| x + side)].map(|node| field.grid.place(node));
    let middle: Point = std::array::from_fn(|a| 0.5 * (low[a] + high[a]));
    let radius = 0.5 * length(&sub(&high, &low));
    let mut near = Vec::new();
    for &number in steps {
        let (hull, slack) = field.steps.hull(number);
        let reach = radius + field.grid.far + slack + field.grid.tolerance;
        if hull.square_to_box(&middle) >= reach * reach {
            continue;
        }
        let until = Until { enough: reach, little: slack, tolerance: field.grid.tolerance };
        let distance = hull.distance(&middle, &until);
        if distance.lower >= reach {
            continue;
        }
        let corner = |c: usize| std::array::from_fn(|a| if c >> a & 1 == 0 { low[a] } else { high[a] });
        // All values in the cube are 0 then: distances are at most those of its corners.
        if distance.upper <= slack && (0..8).all(|c| hull.is_within(&corner(c), slack)) {
            return None;
        }
        near.push(number);
    }
    Some(near)
}
