//! Packing: the order of the triangles, runs of them welded in parallel, and pieces made of runs.

use rayon::prelude::*;

use super::packed::{Packed, PackedPiece, PartNumbers};
use super::runs::{runs, Run};
use super::weld::{pieces, WeldTable, WeldedRun};
use crate::constants::{LEAST_PIECE_VERTICES, MOST_PIECE_VERTICES, NONE};
use crate::error::{Error, Result};
use crate::geometry::bounds::{Aabb, Point};
use crate::mesh::mockup::Mockup;
use crate::mesh::triangle_mesh::Mesh;
use crate::tool::moving_tool::Tool;

/// For pictures.
impl Mockup {
    /// The queried triangles in pieces for drawing, of at most `vertex_limit` vertices (3 to 65,535) each.
    ///
    /// Parts come by the longest side of their box, large ones first; those that `small` names (by part) come last, in pieces of
    /// their own. The first of several pieces has a quarter of the vertices at most, unless a run of triangles takes more. A part larger than a piece spans several, each compact in space. Corners of one part that are the same in float32
    /// are one vertex, but where the part is cut. The same on any number of threads; in parallel on the current rayon pool.
    ///
    /// Errors: a limit out of range, and a `small` of another length than there are parts.
    ///
    /// ```
    /// # use feeler_core::*;
    /// let plate = vec![[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];
    /// let mockup = Mockup::new(plate, vec![[0, 1, 2], [0, 2, 3]], vec![], 1)?;
    /// let packed = mockup.pack(65_535, None)?;
    /// assert_eq!(packed.pieces.len(), 1);
    /// assert_eq!(packed.pieces[0].positions.len(), 4);
    /// assert_eq!(packed.pieces[0].indices, [[0, 1, 2], [0, 2, 3]]);
    /// # Ok::<(), Error>(())
    /// ```
    pub fn pack(&self, vertex_limit: usize, small: Option<&[bool]>) -> Result<Packed> {
        pack(self.mesh(), |t| self.part_of_face(t), self.part_bounds(), vertex_limit, small)
    }
}

/// For pictures.
impl Tool {
    /// [`Mockup::pack`] of a tool, in its own frame.
    pub fn pack(&self, vertex_limit: usize, small: Option<&[bool]>) -> Result<Packed> {
        let mut bounds = vec![Aabb::EMPTY; self.parts()];
        for t in self.mesh().queried() {
            self.mesh().triangle(t).iter().for_each(|p| bounds[self.part_of_face(t) as usize].grow(p));
        }
        pack(self.mesh(), |t| self.part_of_face(t), &bounds, vertex_limit, small)
    }
}

fn pack(
    mesh: &Mesh,
    part_of_face: impl Fn(u32) -> u32,
    part_bounds: &[Aabb],
    vertex_limit: usize,
    small: Option<&[bool]>,
) -> Result<Packed> {
    if !(LEAST_PIECE_VERTICES..=MOST_PIECE_VERTICES).contains(&vertex_limit) {
        return Err(Error::VertexLimit { value: vertex_limit });
    }
    if let Some(small) = small.filter(|small| small.len() != part_bounds.len()) {
        return Err(Error::Length { what: "small", got: small.len(), expected: part_bounds.len() });
    }
    let b = mesh.bounds();
    let middle: Point = std::array::from_fn(|a| 0.5 * b.lower[a] + 0.5 * b.upper[a]);
    // Without a vertex shared it still fits; as surfaces share them, seven or eight go into a piece.
    let longest = (vertex_limit / 4).max(1);
    let (order, runs) = runs(mesh, part_of_face, part_bounds, small, longest);
    let weld = |table: &mut WeldTable, run: &Run| table.weld(mesh, &order[run.first..run.first + run.count], &middle);
    let welded: Vec<WeldedRun> = runs.par_iter().map_init(WeldTable::default, weld).collect();
    let joined = |range: std::ops::Range<usize>| piece(&runs[range.clone()], &welded[range], part_bounds.len());
    let pieces = pieces(&runs, &welded, vertex_limit).into_par_iter().map(joined).collect();
    let mut places = vec![NONE; mesh.faces().len()];
    order.iter().enumerate().for_each(|(at, t)| places[*t as usize] = at as u32);
    Ok(Packed { pieces, order, places, middle })
}

/// The runs of one piece, one after the other.
fn piece(runs: &[Run], welded: &[WeldedRun], parts: usize) -> PackedPiece {
    let vertices = welded.iter().map(|run| run.positions.len()).sum();
    let triangles = welded.iter().map(|run| run.indices.len()).sum();
    let mut piece = PackedPiece {
        positions: Vec::with_capacity(vertices),
        parts: PartNumbers::with_capacity(parts, vertices),
        indices: Vec::with_capacity(triangles),
        is_small: runs[0].is_small,
        first: runs[0].first as u32,
        bounds: Aabb::EMPTY,
    };
    for (run, welded) in runs.iter().zip(welded) {
        let base = piece.positions.len() as u16;
        piece.indices.extend(welded.indices.iter().map(|corners| corners.map(|at| at + base)));
        piece.positions.extend_from_slice(&welded.positions);
        piece.parts.extend(run.part, welded.positions.len());
        piece.bounds = piece.bounds.union(&welded.bounds);
    }
    piece
}
