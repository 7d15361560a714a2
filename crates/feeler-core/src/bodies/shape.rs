//! What bodies are made of: a mesh in its own frame, with what queries need, shared by all bodies of this shape.

use std::sync::Arc;

use once_cell::race::OnceBox;

use super::convexity::is_convex;
use crate::constants::MAX_TOOL_TRIANGLES;
use crate::error::{Error, Result};
use crate::geometry::bounds::Point;
use crate::mesh::mockup::Mockup;
use crate::mesh::topology::disjoint_sets::DisjointSets;
use crate::mesh::triangle_mesh::Mesh;
use crate::scene::{Scene, SceneOptions};
use crate::tool::moving_tool::Tool;

/// A mesh of which [`Bodies`](crate::Bodies) are made, in its own frame, metres. Any number of bodies share it. In a
/// pair of bodies the smaller mesh needs a tree of boxes and the larger one an index; both are made when a query first
/// needs them.
#[derive(Debug)]
pub struct Shape {
    mockup: Arc<Mockup>,
    is_solid: bool,
    memory_limit: u64,
    scene: OnceBox<Arc<Scene>>,
    tool: OnceBox<Arc<Tool>>,
    surfaces: OnceBox<Vec<u32>>,
}

impl Shape {
    /// Checks the arrays: vertices in metres, faces as places among them. `memory_limit`: the most bytes that its index
    /// may take.
    ///
    /// Errors: no triangle at all, none that can be queried, and more than 2^30 triangles or 2^32 - 1 vertices. Other
    /// defects are listed in [`Mesh::defects`].
    pub fn new(vertices: Vec<Point>, faces: Vec<[u32; 3]>, memory_limit: u64) -> Result<Shape> {
        if faces.len() > MAX_TOOL_TRIANGLES {
            let count = faces.len() as u64;
            return Err(Error::TooMany { what: "triangles of a body", count, limit: MAX_TOOL_TRIANGLES as u64 });
        }
        let mockup = Arc::new(Mockup::new(vertices, faces, Vec::new(), 1)?);
        let (scene, tool, surfaces) = (OnceBox::new(), OnceBox::new(), OnceBox::new());
        Ok(Shape { mockup, is_solid: false, memory_limit, scene, tool, surfaces })
    }

    /// The same with its inside, if it is one closed convex surface: what lies in it meets it.
    #[must_use]
    pub fn solid_if_convex(self) -> Shape {
        Shape { is_solid: is_convex(self.mesh()), ..self }
    }

    /// Whether what lies in it meets it.
    pub fn is_solid(&self) -> bool {
        self.is_solid
    }

    /// The triangles.
    pub fn mesh(&self) -> &Mesh {
        self.mockup.mesh()
    }

    /// The scene for pairs in which a body of this shape is the larger one. Errors: more memory than allowed.
    pub fn scene(&self) -> Result<&Arc<Scene>> {
        self.scene.get_or_try_init(|| {
            let options = SceneOptions::default().with_memory_limit(self.memory_limit);
            Ok(Box::new(Arc::new(Scene::build(Arc::clone(&self.mockup), &options)?)))
        })
    }

    /// The tree of boxes for pairs in which a body of this shape is the smaller one. Errors: a mesh that no tool can be made of.
    pub fn tool(&self) -> Result<&Arc<Tool>> {
        self.tool.get_or_try_init(|| {
            let mesh = self.mesh();
            Ok(Box::new(Arc::new(Tool::of_body(mesh.vertices().to_vec(), mesh.faces().to_vec())?)))
        })
    }

    pub(super) fn has_scene(&self) -> bool {
        self.scene.get().is_some()
    }

    pub(super) fn has_tool(&self) -> bool {
        self.tool.get().is_some()
    }

    /// A vertex of each surface that hangs together by common vertices.
    pub(super) fn surfaces(&self) -> &[u32] {
        self.surfaces.get_or_init(|| {
            let mesh = self.mesh();
            let mut sets = DisjointSets((0..mesh.vertices().len() as u32).collect());
            let faces = || mesh.queried().map(|id| mesh.faces()[id as usize]);
            faces().for_each(|[a, b, c]| {
                sets.join(a, b);
                sets.join(a, c);
            });
            let mut firsts: Vec<u32> = faces().map(|[a, ..]| sets.of(a)).collect();
            firsts.sort_unstable();
            firsts.dedup();
            Box::new(firsts)
        })
    }
}
