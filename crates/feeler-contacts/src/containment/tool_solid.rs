//! The closed surfaces of a tool: tests whether they contain points of the mock-up.

use feeler_core::geometry::ray_crossings::{crossing, median, ray_count, ray_end, RAY_OFFSETS};
use feeler_core::mesh::topology::adjacency::Adjacency;
use feeler_core::{Aabb, Mesh, Point, Tool};

/// Triangles of a tool under one box, in the order of its clusters.
const TRIANGLES_PER_BOX: usize = 16;

/// The closed surfaces of a tool, in its own frame, with a box around every few triangles.
pub struct ToolSolid<'a> {
    tool: &'a Tool,
    mesh: &'a Mesh,
    adjacency: &'a Adjacency,
    boxes: Vec<(Aabb, Vec<u32>)>,
}

impl ToolSolid<'_> {
    /// Of a tool.
    pub fn new(tool: &Tool) -> ToolSolid<'_> {
        let (mesh, adjacency) = (tool.mesh(), tool.adjacency());
        let closed = |ids: &[u32]| ids.iter().copied().filter(|t| adjacency.outward[*t as usize] != 0).collect();
        let around = |ids: &Vec<u32>| {
            let corners = ids.iter().flat_map(|t| mesh.triangle(*t));
            corners.fold(Aabb::EMPTY, |mut around, p| {
                around.grow(&p);
                around
            })
        };
        let boxes = tool.ids().chunks(TRIANGLES_PER_BOX).map(closed).map(|ids| (around(&ids), ids)).collect();
        ToolSolid { tool, mesh, adjacency, boxes }
    }

    /// The tool's parts that a point is inside, but for the rounding of its turn into the tool's frame; ascending.
    pub fn parts_around(&self, p: &Point) -> Vec<u32> {
        let Adjacency { outward, has_cracks, has_loose_seams, .. } = self.adjacency;
        let windings = |offset: &[f64; 2]| {
            let q = ray_end(p, &self.mesh.bounds(), offset);
            let ray = Aabb::of_triangle(&[*p, q, q]);
            let mut windings = vec![0; self.tool.parts()];
            let met = self.boxes.iter().filter(|(around, _)| around.is_overlapping(&ray)).flat_map(|(_, ids)| ids);
            for t in met {
                windings[self.tool.part_of_face(*t) as usize] +=
                    i32::from(outward[*t as usize]) * crossing(p, &q, &self.mesh.triangle(*t))?;
            }
            Some(windings)
        };
        let rays = ray_count(*has_cracks || *has_loose_seams);
        let decided: Vec<Vec<i32>> = RAY_OFFSETS.iter().filter_map(windings).take(rays).collect();
        let is_around = |part: &u32| median(decided.iter().map(|windings| windings[*part as usize]).collect()) != 0;
        (0..self.tool.parts() as u32).filter(is_around).collect()
    }
}
