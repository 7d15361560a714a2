//! The two surfaces of a contact, and the sides of a surface.

use std::ops::{Index, IndexMut};

/// One of the two surfaces. Indexes arrays that have an entry for each.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Surface {
    /// The tool's.
    Tool,
    /// The mock-up's.
    Mockup,
}

impl Surface {
    /// Both, in the order of such arrays.
    pub const BOTH: [Surface; 2] = [Surface::Tool, Surface::Mockup];

    /// The other one.
    #[inline(always)]
    pub fn other(self) -> Surface {
        match self {
            Surface::Tool => Surface::Mockup,
            Surface::Mockup => Surface::Tool,
        }
    }
}

/// The side of a surface that a point is on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) enum Side {
    /// Behind it.
    Inside = -1,
    /// On it, or not known.
    #[default]
    On = 0,
    /// In front of it.
    Outside = 1,
}

impl Side {
    /// -1, 0 or 1.
    #[inline(always)]
    pub fn sign(self) -> i32 {
        self as i32
    }
}

impl<T> Index<Surface> for [T; 2] {
    type Output = T;

    #[inline(always)]
    fn index(&self, surface: Surface) -> &T {
        &self[surface as usize]
    }
}

impl<T> IndexMut<Surface> for [T; 2] {
    #[inline(always)]
    fn index_mut(&mut self, surface: Surface) -> &mut T {
        &mut self[surface as usize]
    }
}
