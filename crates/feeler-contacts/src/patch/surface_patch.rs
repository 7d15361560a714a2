//! A patch of a surface, and the fragments of triangles that it is made of.

use feeler_core::constants::NONE;
use feeler_core::Point;

/// Neighbouring triangles with nearly one normal, as far as they lie beyond the other surface.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Patch {
    /// Unit, outward: that of the fragment which founded the patch.
    pub normal: Point,
    /// A point of the patch's plane.
    pub at: Point,
    /// Mean of its points.
    pub middle: Point,
    /// Diagonal of the bounding box of its points, metres: the size of the patch, whatever the size of its triangles.
    pub size: f64,
    /// Whether all its triangles lie in one plane.
    pub flat: bool,
    /// Range of its points in the lists of [`Patches`](super::patches::Patches), point by point.
    pub(super) points: (u32, u32),
    /// Range of its corners, which stand for all its points in half-space tests.
    pub(super) corners: (u32, u32),
    /// Range of its fragments in `Patches::order`.
    pub(super) fragments: (u32, u32),
}

impl Patch {
    /// Of the fragment that founds it; extents and ranges are not known yet.
    pub fn new(normal: Point, at: Point) -> Patch {
        Patch { normal, at, middle: at, size: 0.0, flat: true, points: (0, 0), corners: (0, 0), fragments: (0, 0) }
    }

    /// Its part of a list that has one entry per point of all patches.
    pub fn of_points<'a, T>(&self, all: &'a [T]) -> &'a [T] {
        part(all, self.points)
    }

    /// Its part of a list that has one entry per fragment, patch by patch.
    pub fn of_fragments<'a, T>(&self, all: &'a [T]) -> &'a [T] {
        part(all, self.fragments)
    }
}

/// A range of a list.
pub(super) fn part<T>(all: &[T], (from, to): (u32, u32)) -> &[T] {
    &all[from as usize..to as usize]
}

/// A triangle, or the part of it that lies beyond the other surface.
#[derive(Debug)]
pub(crate) struct Fragment {
    /// Number of the triangle in its mesh.
    pub id: u32,
    pub patch: u32,
    /// Range of its points in `Patches::fragment_points`.
    pub(super) points: (u32, u32),
    /// Whether its surface is closed.
    pub closed: bool,
    /// Unit, outward. `None` for whole triangles in the plane of a closed surface: there the winding gives it, and few
    /// are needed.
    pub(super) normal: Option<Point>,
}

impl Fragment {
    pub fn new(id: u32, normal: Option<Point>, points: (u32, u32), closed: bool) -> Fragment {
        Fragment { id, patch: NONE, points, closed, normal }
    }
}
