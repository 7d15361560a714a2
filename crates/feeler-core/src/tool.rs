//! A moving tool, prepared once for every scene it is used with.

use crate::bounds::{Aabb, Point};
use crate::constants::{TOOL_CUT_ALLOWANCE, TOOL_CUT_PIECES, TOOL_CUT_PIECES_EACH, TRANSFORM_ROUNDOFFS, UNIT_ROUNDOFF};
use crate::error::Result;
use crate::lanes::{BoxLanes, PieceLanes, ToolUnit, LANES};
use crate::mesh::Mesh;
use crate::morton;
use crate::pieces::{cut_margin, cut_triangle, default_piece_size, grown_box, Piece};
use crate::pose::Pose;

/// A moving tool in its own frame, metres: its triangles, and a shallow tree of boxes over their pieces.
#[derive(Debug)]
pub struct Tool {
    mesh: Mesh,
    unit: ToolUnit,
    clusters: Vec<Cluster>,
    /// `groups[0][g]` holds the boxes of clusters `16 g` to `16 g + 15`, `groups[1][g]` those of groups, ...; the last level
    /// has one entry.
    groups: Vec<Vec<BoxLanes>>,
    largest: f64,
}

/// Sixteen pieces that lie close together.
#[derive(Debug, Clone)]
pub struct Cluster {
    /// Their corners.
    pub(crate) corners: PieceLanes,
    /// The triangle each was cut from.
    pub triangles: [u32; LANES],
    /// One bit a piece: whether its triangle has others.
    pub cut: u16,
}

struct CutPiece {
    corners: Piece,
    triangle: u32,
    is_cut: bool,
}

impl Tool {
    /// Checks the arrays and builds the tree of boxes.
    pub fn new(vertices: Vec<Point>, faces: Vec<[u32; 3]>) -> Result<Tool> {
        let mesh = Mesh::new("tool", vertices, faces)?;
        let mut pieces = cut(&mesh);
        let frame = morton::Frame::new(&mesh.bounds());
        pieces.sort_by_cached_key(|p| frame.code_of_box(&grown_box(&p.corners, 0.0)));
        let unit = ToolUnit::new(&mesh.bounds());
        let clusters: Vec<Cluster> = pieces.chunks(LANES).map(|c| Cluster::new(c, &unit)).collect();
        let mut boxes: Vec<Aabb> = pieces
            .chunks(LANES)
            .map(|c| c.iter().fold(Aabb::EMPTY, |b, p| b.union(&grown_box(&p.corners, 0.0))))
            .collect();
        let mut groups = Vec::new();
        while boxes.len() > 1 {
            groups.push(boxes.chunks(LANES).map(|c| BoxLanes::new(c, &unit)).collect());
            boxes = boxes.chunks(LANES).map(|c| c.iter().fold(Aabb::EMPTY, |b, x| b.union(x))).collect();
        }
        let largest = mesh.bounds().largest_coordinate();
        Ok(Tool { mesh, unit, clusters, groups, largest })
    }

    /// The triangles, in the tool's frame.
    pub fn mesh(&self) -> &Mesh {
        &self.mesh
    }

    /// All pieces, 16 to a cluster; the last may be short.
    pub(crate) fn clusters(&self) -> &[Cluster] {
        &self.clusters
    }

    /// Levels of groups above the clusters: 0 where there is one cluster.
    pub(crate) fn height(&self) -> usize {
        self.groups.len()
    }

    /// For each entry of a level (1: groups of clusters) the boxes of its children.
    pub(crate) fn children(&self, level: usize) -> &[BoxLanes] {
        &self.groups[level - 1]
    }

    /// The unit of the float32 coordinates.
    pub(crate) fn unit(&self) -> &ToolUnit {
        &self.unit
    }

    /// How far (metres, per axis) a float64 place of a piece's corner, or of a box around pieces, may be from where the
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

impl Cluster {
    fn new(pieces: &[CutPiece], unit: &ToolUnit) -> Cluster {
        let mut cluster = Cluster {
            corners: PieceLanes::new(pieces.iter().map(|p| &p.corners), unit),
            triangles: [0; LANES],
            cut: 0,
        };
        for (i, p) in pieces.iter().enumerate() {
            cluster.triangles[i] = p.triangle;
            cluster.cut |= u16::from(p.is_cut) << i;
        }
        cluster
    }
}

/// All pieces. Long triangles of a coarse tool are worth many pieces each; a fine tool has short ones already, and pays for
/// each piece at every pose.
fn cut(mesh: &Mesh) -> Vec<CutPiece> {
    let ids: Vec<u32> = mesh.queried().collect();
    let n = ids.len() as f64;
    let allowance = TOOL_CUT_ALLOWANCE + f64::min(TOOL_CUT_PIECES / n, TOOL_CUT_PIECES_EACH);
    let size = default_piece_size(ids.len(), |i| mesh.triangle(ids[i]), allowance);
    let mut pieces = Vec::new();
    for id in ids {
        let from = pieces.len();
        cut_triangle(&mesh.triangle(id), size, &mut |corners| {
            pieces.push(CutPiece { corners: *corners, triangle: id, is_cut: false });
        });
        let is_cut = pieces.len() - from > 1;
        pieces[from..].iter_mut().for_each(|p| p.is_cut = is_cut);
    }
    pieces
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bounds::Triangle;
    use crate::lanes::{LaneBoxes, Placement};

    fn tool() -> Tool {
        // A long triangle, cut many times, among short ones.
        let mut vertices = vec![[0.0, 0.0, 0.0], [0.7, 0.1, 0.0], [0.7, 0.13, 0.01]];
        let mut faces = vec![[0, 1, 2]];
        for i in 0..400 {
            let x = f64::from(i) * 0.001;
            let n = vertices.len() as u32;
            vertices.extend([[x, 0.0, 0.0], [x + 0.003, 0.0, 0.0], [x, 0.003, 0.001]]);
            faces.push([n, n + 1, n + 2]);
        }
        Tool::new(vertices, faces).unwrap()
    }

    fn holds(boxes: &LaneBoxes, lane: usize, p: &Point) -> bool {
        (0..3).all(|a| f64::from(boxes.lower[a][lane]) <= p[a] && p[a] <= f64::from(boxes.upper[a][lane]))
    }

    #[test]
    fn pieces_and_boxes_at_a_pose_cover_the_triangle_at_that_pose() {
        let tool = tool();
        let pieces_of_long = || {
            let all = tool.clusters().iter().enumerate();
            all.flat_map(|(c, cluster)| (0..LANES).map(move |i| (c, i, cluster)))
                .filter(|(_, i, c)| c.triangles[*i] == 0 && c.cut >> i & 1 == 1)
        };
        assert!(pieces_of_long().count() > 4 && tool.height() == 2);
        let (s, c) = 0.3f64.sin_cos();
        for (x, y, z) in [(0.0, 0.0, 0.0), (12.0, -9.0, 3.3), (12345.678, -9.1e5, 3.3)] {
            let pose = Pose::new(&[[c, -s, 0.0, x], [s, c, 0.0, y], [0.0, 0.0, 1.0, z], [0.0, 0.0, 0.0, 1.0]]).unwrap();
            let margin = tool.margin_at(&pose);
            // A frame as a mock-up around the tool would have it.
            let (origin, scale) = ([x - 1.0, y - 2.0, z - 0.5], 0.25);
            let placement = Placement::new(tool.unit(), &pose, margin, &origin, scale);
            let placed: Vec<LaneBoxes> = tool.clusters().iter().map(|c| placement.place_pieces(&c.corners)).collect();
            let groups: Vec<LaneBoxes> = tool.children(1).iter().map(|g| placement.place_boxes(g)).collect();
            let moved: Triangle = pose.apply_triangle(&tool.mesh().triangle(0));
            for i in 0..=20 {
                for j in 0..=20 - i {
                    let (u, v) = (f64::from(i) / 20.0, f64::from(j) / 20.0);
                    let p: Point = std::array::from_fn(|a| {
                        let p = moved[0][a] * (1.0 - u - v) + moved[1][a] * u + moved[2][a] * v;
                        (p - origin[a]) * scale
                    });
                    let mut found = pieces_of_long().filter(|(c, i, _)| holds(&placed[*c], *i, &p)).peekable();
                    assert!(found.peek().is_some(), "{u} {v} at {x}");
                    for (cluster, _, _) in found {
                        assert!(holds(&groups[cluster / LANES], cluster % LANES, &p), "{u} {v} at {x}");
                    }
                    assert!(pose.apply_box(&tool.mesh().bounds(), margin).is_overlapping(&Aabb {
                        lower: std::array::from_fn(|a| p[a] / scale + origin[a] - 1e-9),
                        upper: std::array::from_fn(|a| p[a] / scale + origin[a] + 1e-9),
                    }));
                }
            }
        }
    }
}
