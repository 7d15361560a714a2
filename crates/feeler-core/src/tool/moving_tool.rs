//! A moving tool, prepared once for all scenes.

use std::sync::Arc;

use super::surface_links::SurfaceLinks;
use crate::constants::{
    MAX_TOOL_TRIANGLES, MOCKUP_CUT_ALLOWANCE, TOOL_CUT_PIECES, TOOL_CUT_PIECES_EACH, TRANSFORM_ROUNDOFFS, UNIT_ROUNDOFF,
};
use crate::error::{Error, Result};
use crate::geometry::bounds::{Aabb, Piece, Point, Triangle};
use crate::geometry::intersect_lanes::line_of;
use crate::geometry::pose::Pose;
use crate::mesh::median::{self, Cells};
use crate::mesh::part_numbers::check_parts;
use crate::mesh::pieces::{cut_margin, cut_triangle, default_piece_size, grown_box, outline};
use crate::mesh::topology::adjacency::Adjacency;
use crate::mesh::topology::body_outlines::BodyOutlines;
use crate::mesh::triangle_mesh::Mesh;
use crate::tool::placement::{BoxLanes, PieceLanes, ToolUnit};
use feeler_lanes::{CacheLine, LANES};
use once_cell::race::OnceBox;

/// A moving tool in its own frame, metres: its triangles, and a shallow tree of boxes over their pieces. Made once, it serves any
/// number of scenes and poses.
#[derive(Debug)]
pub struct Tool {
    mesh: Mesh,
    /// The part of each triangle; empty where all belong to part 0.
    part_of_face: Vec<u32>,
    parts: usize,
    /// The corners of the queried triangles, in the order of the clusters: neighbours in space are neighbours in memory.
    placeable: Vec<Triangle>,
    /// The same for the triangle test, each in one cache line.
    lines: Vec<CacheLine>,
    /// The triangle of each of them.
    ids: Vec<u32>,
    unit: ToolUnit,
    clusters: Vec<Cluster>,
    /// `groups[0][g]` holds the boxes of clusters `16 g` to `16 g + 15`, `groups[1][g]` those of groups, ...; the last level
    /// has one entry.
    groups: Vec<Vec<BoxLanes>>,
    largest: f64,
    /// About which it turns, tool frame.
    pivot: Point,
    widths: Widths,
    /// Made at the first query for contacts; by every thread that needs it meanwhile, as of a mock-up.
    adjacency: OnceBox<Adjacency>,
    outlines: BodyOutlines,
    /// Made at the first query for penetration where the tool meets nothing.
    links: OnceBox<SurfaceLinks>,
}

/// Mean widths, over all directions, of the parts of a tool: the means of them, of their squares and of their cubes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Widths {
    /// Of the pieces; metres, square metres, cubic metres.
    pub pieces: [f64; 3],
    /// Of the boxes of the clusters.
    pub clusters: [f64; 3],
}

/// Lanes of the shortest registers, those of plain code.
pub(crate) const LEAST_LANES: usize = 4;

/// Sixteen pieces that lie close together.
#[derive(Debug, Clone)]
pub(crate) struct Cluster {
    /// Their corners.
    pub corners: PieceLanes,
    /// The slot of the triangle each was cut from.
    pub slots: [u32; LANES],
}

struct CutPiece {
    corners: Piece,
    triangle: u32,
}

impl Tool {
    /// Checks the arrays and builds the tree of boxes: vertices in metres, tool frame; faces as places among them.
    ///
    /// Errors: no triangle at all, none that can be queried, and more than 2^30 triangles or 2^32 - 1 vertices. Other defects are
    /// listed in [`Mesh::defects`].
    pub fn new(vertices: Vec<Point>, faces: Vec<[u32; 3]>) -> Result<Tool> {
        Tool::of_parts(vertices, faces, Vec::new(), 1)
    }

    /// The same of several parts that move as one. `part_of_face` gives each triangle's part, 0 to `parts - 1`; empty means that all
    /// belong to part 0.
    ///
    /// Errors: as [`new`](Self::new), no part, and a `part_of_face` of another length or with a part that is not there.
    pub fn of_parts(vertices: Vec<Point>, faces: Vec<[u32; 3]>, part_of_face: Vec<u32>, parts: usize) -> Result<Tool> {
        Tool::cut_by(vertices, faces, part_of_face, parts, TOOL_CUT_PIECES_EACH)
    }

    /// The same of one part whose triangles are cut as those of a mock-up: made sooner, for few queries against few triangles.
    pub(crate) fn of_body(vertices: Vec<Point>, faces: Vec<[u32; 3]>) -> Result<Tool> {
        Tool::cut_by(vertices, faces, Vec::new(), 1, MOCKUP_CUT_ALLOWANCE)
    }

    /// `each`: the most pieces that a triangle is cut into more than one, on average.
    fn cut_by(
        vertices: Vec<Point>,
        faces: Vec<[u32; 3]>,
        part_of_face: Vec<u32>,
        parts: usize,
        each: f64,
    ) -> Result<Tool> {
        check_parts(&part_of_face, faces.len(), parts)?;
        if faces.len() > MAX_TOOL_TRIANGLES {
            let count = faces.len() as u64;
            return Err(Error::TooMany { what: "tool triangles", count, limit: MAX_TOOL_TRIANGLES as u64 });
        }
        let mesh = Mesh::new("tool", vertices, faces)?;
        let pieces = cut(&mesh, each);
        let cells = Cells::new(&mesh.bounds());
        let middle = |p: &CutPiece| {
            let b = grown_box(&p.corners, 0.0);
            cells.middle(&b.lower, &b.upper)
        };
        let mut order: Vec<(u64, u32)> = pieces.iter().zip(0..).map(|(p, i)| (middle(p), i)).collect();
        median::order(&mut order, LANES);
        // And within a cluster: where registers are short, some of its lanes often have nothing to do together.
        order.chunks_mut(LANES).for_each(|cluster| median::order(cluster, LEAST_LANES));
        let pieces: Vec<&CutPiece> = order.iter().map(|(_, i)| &pieces[*i as usize]).collect();
        let unit = ToolUnit::new(&mesh.bounds());
        // Slots in the order in which clusters first name a triangle.
        let mut ids = Vec::new();
        let mut slots = vec![u32::MAX; mesh.faces().len()];
        for piece in &pieces {
            let slot = &mut slots[piece.triangle as usize];
            if *slot == u32::MAX {
                *slot = ids.len() as u32;
                ids.push(piece.triangle);
            }
        }
        let clusters: Vec<Cluster> = pieces.chunks(LANES).map(|c| Cluster::new(c, &slots, &unit)).collect();
        let mut boxes: Vec<Aabb> = pieces
            .chunks(LANES)
            .map(|c| c.iter().fold(Aabb::EMPTY, |b, p| b.union(&grown_box(&p.corners, 0.0))))
            .collect();
        // The mean width of a flat convex thing is a quarter of its outline, that of a box half the sum of its sides.
        let widths = Widths {
            pieces: mean_powers(pieces.iter().map(|p| 0.25 * outline(&p.corners))),
            clusters: mean_powers(boxes.iter().map(|b| 0.5 * b.extent().iter().sum::<f64>())),
        };
        let mut groups = Vec::new();
        while boxes.len() > 1 || groups.is_empty() {
            groups.push(boxes.chunks(LANES).map(|c| BoxLanes::new(c, &unit)).collect());
            boxes = boxes.chunks(LANES).map(|c| c.iter().fold(Aabb::EMPTY, |b, x| b.union(x))).collect();
        }
        let largest = mesh.bounds().largest_coordinate();
        let pivot = std::array::from_fn(|a| 0.5 * mesh.bounds().lower[a] + 0.5 * mesh.bounds().upper[a]);
        let placeable: Vec<Triangle> = ids.iter().map(|id| mesh.triangle(*id)).collect();
        Ok(Tool {
            part_of_face,
            parts,
            lines: placeable.iter().map(line_of).collect(),
            placeable,
            mesh,
            ids,
            unit,
            clusters,
            groups,
            largest,
            pivot,
            widths,
            adjacency: OnceBox::new(),
            outlines: BodyOutlines::default(),
            links: OnceBox::new(),
        })
    }

    /// The same turning about another point (tool frame, metres) on its [motions](crate::Motion), as one with which it moves.
    pub fn with_pivot(self, pivot: Point) -> Tool {
        Tool { pivot, ..self }
    }

    /// The point about which it turns on its motions: the middle of its box, or as [given](Self::with_pivot).
    pub fn pivot(&self) -> &Point {
        &self.pivot
    }

    /// The triangles, in the tool's frame.
    pub fn mesh(&self) -> &Mesh {
        &self.mesh
    }

    /// Number of its parts.
    pub fn parts(&self) -> usize {
        self.parts
    }

    /// The part a triangle belongs to.
    #[inline]
    pub fn part_of_face(&self, face: u32) -> u32 {
        self.part_of_face.get(face as usize).copied().unwrap_or(0)
    }

    /// Which triangles share edges, within each part.
    #[doc(hidden)]
    pub fn adjacency(&self) -> &Adjacency {
        self.adjacency.get_or_init(|| {
            if self.parts == 1 {
                return Box::new(Adjacency::of_one_part(&self.mesh));
            }
            let mut bounds = vec![Aabb::EMPTY; self.parts];
            for face in self.mesh.queried() {
                self.mesh.triangle(face).iter().for_each(|p| bounds[self.part_of_face(face) as usize].grow(p));
            }
            Box::new(Adjacency::new(&self.mesh, |face| self.part_of_face(face), &bounds))
        })
    }

    /// Takes over how its triangles share edges, unless that is known already.
    pub(crate) fn take_adjacency(&self, adjacency: Adjacency) {
        // Another thread may have found it meanwhile: the same.
        let _ = self.adjacency.set(Box::new(adjacency));
    }

    /// The points that span the convex body of a triangle, in the tool's frame; found when first asked for.
    #[doc(hidden)]
    pub fn body_outline(&self, triangle: u32) -> Arc<[Point]> {
        self.outlines.of(&self.mesh, self.adjacency(), triangle)
    }

    /// Ways between its connected surfaces.
    #[doc(hidden)]
    pub fn links(&self) -> &SurfaceLinks {
        self.links.get_or_init(|| Box::new(SurfaceLinks::new(&self.mesh, self.adjacency())))
    }

    /// Whether [`adjacency`](Self::adjacency) and [`links`](Self::links) are found.
    #[doc(hidden)]
    pub fn has_topology(&self) -> [bool; 2] {
        [self.adjacency.get().is_some(), self.links.get().is_some()]
    }

    /// The corners of the queried triangles. Their places here are their slots.
    pub(crate) fn placeable(&self) -> &[Triangle] {
        &self.placeable
    }

    /// The same for the triangle test.
    pub(crate) fn lines(&self) -> &[CacheLine] {
        &self.lines
    }

    /// The triangle of each slot.
    #[doc(hidden)]
    pub fn ids(&self) -> &[u32] {
        &self.ids
    }

    /// All pieces, 16 to a cluster; the last may be short.
    pub(crate) fn clusters(&self) -> &[Cluster] {
        &self.clusters
    }

    /// Levels of groups above the clusters, at least one.
    pub(crate) fn height(&self) -> usize {
        self.groups.len()
    }

    /// For each entry of a level (1: groups of clusters) the boxes of its children.
    pub(crate) fn children(&self, level: usize) -> &[BoxLanes] {
        &self.groups[level - 1]
    }

    /// How wide its pieces and clusters are.
    pub(crate) fn widths(&self) -> &Widths {
        &self.widths
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
    /// piece, which itself is off by `cut_margin` before the motion (three axes add up). A box's centre and reach take at
    /// most 16 roundings more.
    #[doc(hidden)]
    pub fn margin_at(&self, pose: &Pose) -> f64 {
        let largest = 3.1 * self.largest + pose.largest_translation();
        TRANSFORM_ROUNDOFFS * UNIT_ROUNDOFF * largest + 4.0 * cut_margin(self.largest)
    }
}

impl Cluster {
    fn new(pieces: &[&CutPiece], slots: &[u32], unit: &ToolUnit) -> Cluster {
        let mut cluster = Cluster {
            corners: PieceLanes::new(&pieces.iter().map(|p| p.corners).collect::<Vec<_>>(), unit),
            slots: [0; LANES],
        };
        for (i, p) in pieces.iter().enumerate() {
            cluster.slots[i] = slots[p.triangle as usize];
        }
        cluster
    }
}

fn mean_powers(widths: impl ExactSizeIterator<Item = f64>) -> [f64; 3] {
    let n = widths.len() as f64;
    widths.fold([0.0; 3], |[a, b, c], w| [a + w / n, b + w * w / n, c + w * w * w / n])
}

/// All pieces. Long triangles of a coarse tool are worth many pieces each; a fine tool has short ones already, and pays for
/// each piece at every pose.
fn cut(mesh: &Mesh, each: f64) -> Vec<CutPiece> {
    let ids: Vec<u32> = mesh.queried().collect();
    let n = ids.len() as f64;
    let allowance = f64::min(TOOL_CUT_PIECES / n, each);
    let size = default_piece_size(ids.len(), |i| mesh.triangle(ids[i]), allowance);
    let mut pieces = Vec::new();
    for id in ids {
        cut_triangle(&mesh.triangle(id), size, &mut |corners| {
            pieces.push(CutPiece { corners: *corners, triangle: id });
        });
    }
    pieces
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::bounds::Triangle;
    use crate::tool::placement::{PlaceBoxes, PlacedPieces, Placement};
    use feeler_lanes::{load3, Kernel, Lane32, LaneBoxes, Level, Simd};

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

    /// The boxes of all pieces, and of all clusters by group.
    struct Place<'a>(&'a Tool, &'a Placement);

    impl Kernel for Place<'_> {
        type Output = (Vec<LaneBoxes>, Vec<LaneBoxes>);

        #[inline(always)]
        fn run<S: Simd>(self, s: S) -> Self::Output {
            let Place(tool, placement) = self;
            let mut pieces = Vec::new();
            for cluster in tool.clusters() {
                let mut placed = PlacedPieces::ZERO;
                placement.place_pieces(s, &cluster.corners, &mut placed);
                pieces.push(placed.boxes);
            }
            let mut groups = Vec::new();
            for group in tool.children(1) {
                let mut placed = LaneBoxes::ZERO;
                placement.place_boxes(s, group, &mut placed);
                groups.push(placed);
            }
            (pieces, groups)
        }
    }

    /// The intervals of all clusters along sixteen axes: lower and upper ends, cluster by cluster.
    struct Intervals<'a>(&'a Tool, &'a Placement, &'a [Lane32; 3]);

    impl Kernel for Intervals<'_> {
        type Output = Vec<[Lane32; 2]>;

        #[inline(always)]
        fn run<S: Simd>(self, s: S) -> Self::Output {
            let Intervals(tool, placement, axes) = self;
            let along = placement.along(s, &load3(s, axes));
            let mut found = vec![[[0.0; LANES]; 2]; tool.clusters().len()];
            for (c, ends) in found.iter_mut().enumerate() {
                let (lower, upper) = along.interval(s, &tool.children(1)[c / LANES], c % LANES);
                s.store(lower, &mut ends[0]);
                s.store(upper, &mut ends[1]);
            }
            found
        }
    }

    #[test]
    fn intervals_of_clusters_along_axes_cover_their_triangles() {
        let tool = tool();
        let long = tool.ids().iter().position(|id| *id == 0).unwrap() as u32;
        let (s, c) = 0.3f64.sin_cos();
        // Of any length, along no axis of either frame and along some.
        let axis = |i: usize| [(1.7 * i as f32).sin(), (2.9 * i as f32).cos() * 1e-3, if i < 8 { 0.0 } else { 40.0 }];
        let axes: [Lane32; 3] = std::array::from_fn(|a| std::array::from_fn(|i| axis(i)[a]));
        for (x, y, z) in [(0.0, 0.0, 0.0), (12.0, -9.0, 3.3), (12345.678, -9.1e5, 3.3)] {
            let pose = Pose::new(&[[c, -s, 0.0, x], [s, c, 0.0, y], [0.0, 0.0, 1.0, z], [0.0, 0.0, 0.0, 1.0]]).unwrap();
            let (origin, scale) = ([x - 1.0, y - 2.0, z - 0.5], 0.25);
            let placement = Placement::new(tool.unit(), &pose, tool.margin_at(&pose), &origin, scale);
            for level in Level::available() {
                let found = level.checked().run(Intervals(&tool, &placement, &axes));
                let mut apart = 0;
                for (cluster, ends) in tool.clusters().iter().zip(&found) {
                    let used = (0..LANES).filter(|i| cluster.corners.used >> i & 1 == 1);
                    for slot in used.map(|i| cluster.slots[i]).filter(|slot| *slot != long) {
                        for p in pose.apply_triangle(&tool.placeable()[slot as usize]) {
                            for i in 0..LANES {
                                let at = |a: usize| (p[a] - origin[a]) * scale * f64::from(axis(i)[a]);
                                let height = at(0) + at(1) + at(2);
                                let [lower, upper] = ends.map(|end| f64::from(end[i]));
                                assert!(lower <= height && height <= upper, "{lower} {height} {upper}, {i} at {x}");
                            }
                        }
                    }
                    apart +=
                        (0..LANES).filter(|i| found[0][1][*i] < ends[0][*i] || ends[1][*i] < found[0][0][*i]).count();
                }
                assert!(apart > 10, "{apart} intervals apart from the first cluster's");
            }
        }
    }

    #[test]
    fn pieces_and_boxes_at_a_pose_cover_the_triangle_at_that_pose() {
        let tool = tool();
        let slot = tool.ids().iter().position(|id| *id == 0).unwrap() as u32;
        let pieces_of_long: Vec<(usize, usize)> = (0..tool.clusters().len())
            .flat_map(|c| (0..LANES).map(move |i| (c, i)))
            .filter(|(c, i)| {
                let cluster = &tool.clusters()[*c];
                cluster.slots[*i] == slot && cluster.corners.used >> i & 1 == 1
            })
            .collect();
        assert!(pieces_of_long.len() > 4 && tool.height() == 2);
        let (s, c) = 0.3f64.sin_cos();
        for (x, y, z) in [(0.0, 0.0, 0.0), (12.0, -9.0, 3.3), (12345.678, -9.1e5, 3.3)] {
            let pose = Pose::new(&[[c, -s, 0.0, x], [s, c, 0.0, y], [0.0, 0.0, 1.0, z], [0.0, 0.0, 0.0, 1.0]]).unwrap();
            let margin = tool.margin_at(&pose);
            // A frame as a mock-up around the tool would have it.
            let (origin, scale) = ([x - 1.0, y - 2.0, z - 0.5], 0.25);
            let placement = Placement::new(tool.unit(), &pose, margin, &origin, scale);
            for level in Level::available() {
                let (placed, groups) = level.checked().run(Place(&tool, &placement));
                let moved: Triangle = pose.apply_triangle(&tool.mesh().triangle(0));
                for i in 0..=20 {
                    for j in 0..=20 - i {
                        let (u, v) = (f64::from(i) / 20.0, f64::from(j) / 20.0);
                        let p: Point = std::array::from_fn(|a| {
                            let p = moved[0][a] * (1.0 - u - v) + moved[1][a] * u + moved[2][a] * v;
                            (p - origin[a]) * scale
                        });
                        let mut found = pieces_of_long.iter().filter(|(c, i)| holds(&placed[*c], *i, &p)).peekable();
                        assert!(found.peek().is_some(), "{u} {v} at {x}");
                        for (cluster, _) in found {
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
}
