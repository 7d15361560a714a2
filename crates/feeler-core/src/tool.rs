//! A moving tool, prepared once for every scene it is used with.

use crate::bounds::{Aabb, Point};
use crate::constants::{TOOL_CUT_ALLOWANCE, TOOL_CUT_PIECES, TRANSFORM_ROUNDOFFS, UNIT_ROUNDOFF};
use crate::error::Result;
use crate::mesh::Mesh;
use crate::morton;
use crate::pieces::{cut_margin, cut_triangle, default_piece_size, grown_box, Piece};
use crate::pose::Pose;

/// Pieces in a cluster, clusters in a group, and so on.
pub const TOOL_FANOUT: usize = 16;

/// A moving tool in its own frame, metres: its triangles, and a shallow tree of boxes over their pieces.
#[derive(Debug)]
pub struct Tool {
    mesh: Mesh,
    pieces: Vec<ToolPiece>,
    /// `levels[0]` are clusters of pieces, `levels[1]` groups of clusters, ...; the last level has one entry. Children of
    /// entry `i` are entries `16 i` to `16 i + 15` of the level below.
    levels: Vec<Vec<Aabb>>,
    largest: f64,
}

/// A piece of a tool triangle, in the tool's frame.
#[derive(Debug, Clone)]
pub struct ToolPiece {
    /// Its corners.
    pub corners: Piece,
    /// The triangle it was cut from.
    pub triangle: u32,
    /// Whether the triangle has other pieces.
    pub is_cut: bool,
}

impl Tool {
    /// Checks the arrays and builds the tree of boxes.
    pub fn new(vertices: Vec<Point>, faces: Vec<[u32; 3]>) -> Result<Tool> {
        let mesh = Mesh::new("tool", vertices, faces)?;
        let ids: Vec<u32> = mesh.queried().collect();
        let allowance = TOOL_CUT_ALLOWANCE + TOOL_CUT_PIECES / ids.len() as f64;
        let size = default_piece_size(ids.len(), |i| mesh.triangle(ids[i]), allowance);
        let mut pieces = Vec::new();
        for &id in &ids {
            let from = pieces.len();
            cut_triangle(&mesh.triangle(id), size, &mut |corners| {
                pieces.push(ToolPiece { corners: *corners, triangle: id, is_cut: false });
            });
            let is_cut = pieces.len() - from > 1;
            pieces[from..].iter_mut().for_each(|p| p.is_cut = is_cut);
        }
        let frame = morton::Frame::new(&mesh.bounds());
        pieces.sort_by_cached_key(|p| frame.code_of_box(&grown_box(&p.corners, 0.0)));
        let mut levels = vec![pieces
            .chunks(TOOL_FANOUT)
            .map(|c| c.iter().fold(Aabb::EMPTY, |b, p| b.union(&grown_box(&p.corners, 0.0))))
            .collect::<Vec<Aabb>>()];
        while levels[levels.len() - 1].len() > 1 {
            let below = &levels[levels.len() - 1];
            levels.push(below.chunks(TOOL_FANOUT).map(|c| c.iter().fold(Aabb::EMPTY, |b, x| b.union(x))).collect());
        }
        let largest = mesh.bounds().largest_coordinate();
        Ok(Tool { mesh, pieces, levels, largest })
    }

    /// The triangles, in the tool's frame.
    pub fn mesh(&self) -> &Mesh {
        &self.mesh
    }

    /// All pieces, in cluster order.
    pub fn pieces(&self) -> &[ToolPiece] {
        &self.pieces
    }

    /// Boxes of clusters (level 0), groups of clusters (1), ...
    pub fn levels(&self) -> &[Vec<Aabb>] {
        &self.levels
    }

    /// How far (metres, per axis) the computed place of a piece's corner, or of a box around pieces, may be from where the
    /// triangle at the pose really is.
    ///
    /// A triangle at a pose is spanned by its three computed corners. Each differs from the exact affine image by at most
    /// four roundings of numbers no larger than 3 `largest` (1 + 1e-6) + translation, and so does each computed corner of a
    /// piece, which itself is off by [`cut_margin`] before the motion (three axes add up). A box's centre and reach take at
    /// most 16 roundings more.
    pub fn margin_at(&self, pose: &Pose) -> f64 {
        let largest = 3.1 * self.largest + pose.largest_translation();
        TRANSFORM_ROUNDOFFS * UNIT_ROUNDOFF * largest + 4.0 * cut_margin(self.largest)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bounds::Triangle;

    #[test]
    fn pieces_at_a_pose_cover_the_triangle_at_that_pose() {
        // A long triangle, cut many times, far from the origin; any point of the moved triangle is in some piece's box.
        let mut vertices = vec![[0.0, 0.0, 0.0], [0.7, 0.1, 0.0], [0.7, 0.13, 0.01]];
        let mut faces = vec![[0, 1, 2]];
        for i in 0..40 {
            let x = f64::from(i) * 0.01;
            let n = vertices.len() as u32;
            vertices.extend([[x, 0.0, 0.0], [x + 0.003, 0.0, 0.0], [x, 0.003, 0.001]]);
            faces.push([n, n + 1, n + 2]);
        }
        let tool = Tool::new(vertices, faces).unwrap();
        assert!(tool.pieces().iter().filter(|p| p.triangle == 0).count() > 4);
        assert!(tool.pieces().iter().all(|p| p.is_cut == (p.triangle == 0)));
        let (s, c) = 0.3f64.sin_cos();
        let pose =
            Pose::new(&[[c, -s, 0.0, 12345.678], [s, c, 0.0, -9.1e5], [0.0, 0.0, 1.0, 3.3], [0.0, 0.0, 0.0, 1.0]])
                .unwrap();
        let margin = tool.margin_at(&pose);
        let moved: Triangle = pose.apply_triangle(&tool.mesh().triangle(0));
        for i in 0..=20 {
            for j in 0..=20 - i {
                let (u, v) = (f64::from(i) / 20.0, f64::from(j) / 20.0);
                let p: Point = std::array::from_fn(|a| moved[0][a] * (1.0 - u - v) + moved[1][a] * u + moved[2][a] * v);
                let point = Aabb { lower: p, upper: p };
                let boxes = tool
                    .pieces()
                    .iter()
                    .filter(|p| p.triangle == 0)
                    .map(|piece| grown_box(&piece.corners.map(|c| pose.apply(&c)), margin));
                assert!(boxes.into_iter().any(|b| b.is_overlapping(&point)), "{u} {v}");
                assert!(pose.apply_box(&tool.levels()[tool.levels().len() - 1][0], margin).is_overlapping(&point));
            }
        }
    }
}
