//! Pieces of the surface as one mesh.

use std::collections::HashMap;

use feeler_core::{Error, Point, Result};

use super::cells::Piece;

/// Vertices, in spacings from the grid's origin, and faces, in the order of the pieces.
pub fn joined(pieces: Vec<Piece>) -> Result<(Vec<Point>, Vec<[u32; 3]>)> {
    let count = |of: fn(&Piece) -> usize| pieces.iter().map(of).sum::<usize>();
    let (vertex_count, face_count) = (count(|p| p.vertices.len()), count(|p| p.faces.len()));
    let limit = u64::from(u32::MAX);
    if vertex_count.max(face_count) as u64 > limit {
        return Err(Error::TooMany { what: "triangles of a swept volume", count: face_count as u64, limit });
    }
    let mut vertices: Vec<Point> = Vec::with_capacity(vertex_count);
    let mut faces = Vec::with_capacity(face_count);
    // The caller knows the key: the order in which a map keeps its entries does not show.
    let mut vertex_of_edge: HashMap<u64, u32> = HashMap::new();
    let mut number = Vec::new();
    for piece in pieces {
        number.clear();
        number.resize(piece.vertices.len(), u32::MAX);
        for (vertex, edge) in piece.shared {
            let at = &mut vertices;
            number[vertex as usize] = *vertex_of_edge.entry(edge).or_insert_with(|| {
                at.push(piece.vertices[vertex as usize]);
                (at.len() - 1) as u32
            });
        }
        for (vertex, own) in piece.vertices.iter().zip(&mut number) {
            if *own == u32::MAX {
                *own = vertices.len() as u32;
                vertices.push(*vertex);
            }
        }
        faces.extend(piece.faces.iter().map(|face| face.map(|v| number[v as usize])));
    }
    Ok((vertices, faces))
}
