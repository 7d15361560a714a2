//! A patch of a surface, and the triangles it is made of.

use feeler_core::constants::NONE;
use feeler_core::Point;

/// Points of a patch that are all looked at.
pub(crate) const MOST_CORNERS: usize = 8;

/// Neighbouring triangles of one direction, as far as they are beyond the other surface.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Patch {
    /// Unit, outward.
    pub normal: Point,
    /// A point of its plane.
    pub at: Point,
    /// The mean of its points.
    pub middle: Point,
    /// Diagonal of the box around them, metres: the patch's size, whatever its triangles'.
    pub size: f64,
    /// Whether all its triangles have one plane.
    pub flat: bool,
    /// Its points among all of [`Patches`], and the outermost.
    pub points: (u32, u32),
    pub(super) corners: (u32, u32),
    /// Its pieces among [`Patches::order`].
    pub(super) fragments: (u32, u32),
}

impl Patch {
    /// Of a triangle that founds it; its points are not known yet.
    pub fn new(normal: Point, at: Point) -> Patch {
        Patch { normal, at, middle: at, size: 0.0, flat: true, points: (0, 0), corners: (0, 0), fragments: (0, 0) }
    }

    /// What it has of a list of all patches' points, or pieces as long as the points are not known.
    pub fn range<'a, T>(&self, all: &'a [T]) -> &'a [T] {
        &all[self.points.0 as usize..self.points.1 as usize]
    }
}

/// A triangle, or the part of it that is beyond the other surface.
#[derive(Debug)]
pub(crate) struct Fragment {
    pub id: u32,
    pub patch: u32,
    /// Its points among all.
    pub(super) points: (u32, u32),
    pub closed: bool,
    /// Unit, outward. Of a whole triangle in a plane of a closed surface it is that of the winding, and mostly nobody asks.
    pub(super) normal: Option<Point>,
}

impl Fragment {
    pub fn new(id: u32, normal: Option<Point>, points: (u32, u32), closed: bool) -> Fragment {
        Fragment { id, patch: NONE, points, closed, normal }
    }
}
