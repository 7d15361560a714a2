//! A packed mesh, and its pieces.

use crate::geometry::bounds::{Aabb, Point};

/// A mesh in pieces for drawing: see [`Mockup::pack`](crate::Mockup::pack).
///
/// Triangles are numbered anew, piece by piece: packed triangle `i` is triangle `order[i]` of the mesh.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Packed {
    /// In order of the sizes of parts, large ones first; those of small parts last.
    pub pieces: Vec<PackedPiece>,
    /// The mesh's triangle of each packed one.
    pub order: Vec<u32>,
    /// The packed triangle of each of the mesh; `u32::MAX` for defects, which are not drawn.
    pub places: Vec<u32>,
    /// The origin of positions, metres: the middle of the mesh's box.
    pub middle: Point,
}

/// One draw call: whole small parts, or a section of a large one.
#[derive(Debug, Clone, PartialEq)]
pub struct PackedPiece {
    /// Metres, from the middle of the mesh. Of one part no two are the same, but where the part is cut.
    pub positions: Vec<[f32; 3]>,
    /// The part of each vertex.
    pub parts: PartNumbers,
    /// Triangles, as places among the positions.
    pub indices: Vec<[u16; 3]>,
    /// Whether it has the parts that were called small.
    pub is_small: bool,
    /// The number of its first triangle among the packed ones.
    pub first: u32,
    /// The box around its triangles as given, metres, in the mesh's frame.
    pub bounds: Aabb,
}

/// Part numbers of two bytes, or of four where a mesh has more than 65,535 parts.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum PartNumbers {
    /// Two bytes each.
    Short(Vec<u16>),
    /// Four bytes each.
    Long(Vec<u32>),
}

impl PartNumbers {
    /// Empty, with room for `vertices`, of a mesh with `parts` parts.
    pub(super) fn with_capacity(parts: usize, vertices: usize) -> PartNumbers {
        if parts > usize::from(u16::MAX) {
            PartNumbers::Long(Vec::with_capacity(vertices))
        } else {
            PartNumbers::Short(Vec::with_capacity(vertices))
        }
    }

    /// Adds a part's vertices.
    pub(super) fn extend(&mut self, part: u32, vertices: usize) {
        match self {
            PartNumbers::Short(parts) => parts.resize(parts.len() + vertices, part as u16),
            PartNumbers::Long(parts) => parts.resize(parts.len() + vertices, part),
        }
    }

    /// The part of a vertex.
    pub fn get(&self, vertex: usize) -> u32 {
        match self {
            PartNumbers::Short(parts) => parts[vertex].into(),
            PartNumbers::Long(parts) => parts[vertex],
        }
    }

    /// How many vertices have one.
    pub fn len(&self) -> usize {
        match self {
            PartNumbers::Short(parts) => parts.len(),
            PartNumbers::Long(parts) => parts.len(),
        }
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}
