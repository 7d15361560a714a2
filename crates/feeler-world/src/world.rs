//! The state of a manipulation: the mock-up, the tool, a gripped part, and parts put down elsewhere.
//!
//! A gripped part leaves the scene and joins the tool without a rebuild. Contacts of the tool when the world changes
//! are seats: see [`Surroundings`].

use std::sync::Arc;

use feeler_contacts::ContactSolver;
use feeler_core::geometry::twist::{times, transposed};
use feeler_core::geometry::vectors::sub;
use feeler_core::{Mockup, Point, Pose, Scene, SceneOptions, Tool};

use crate::environment::{Body, Environment, PutDown};
use crate::error::{Error, Result};
use crate::surroundings::Surroundings;

/// A gripped part.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct Grip {
    /// Its number in the mock-up.
    pub part: u32,
    /// Its number among the tool's parts.
    pub tool_part: u32,
}

/// Where gripped parts go when the tool releases them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Release {
    /// They stay where they are: parts of the scene again, in their new places.
    #[default]
    Here,
    /// Back to their places in the mock-up, wherever they are.
    PutBack,
}

/// A tool, the parts that it grips, and what stands around: the mock-up, and parts that were put down elsewhere.
#[derive(Debug)]
pub struct World {
    scene: Arc<Scene>,
    solver: ContactSolver,
    own_tool: Arc<Tool>,
    around: Surroundings,
    grips: Vec<Grip>,
    /// Parts that are not in their place: gripped, or put down.
    out: Vec<u32>,
}

impl World {
    /// A scene and a tool, nothing gripped, and parts that lie elsewhere; see [`Environment::new`]. Where the tool is,
    /// [`move_to`](Self::move_to) says.
    pub fn new(scene: Arc<Scene>, tool: Arc<Tool>, put_down: &[PutDown]) -> Result<World> {
        let environment = Environment::new(&scene, put_down)?;
        let (solver, out) = (ContactSolver::new(scene.clone()), environment.put_down().collect());
        let around = Surroundings::without_seats(environment, tool.clone());
        Ok(World { scene, solver, own_tool: tool, around, grips: Vec::new(), out })
    }

    /// The moving body: the tool, with its gripped parts.
    pub fn tool(&self) -> &Arc<Tool> {
        self.around.tool()
    }

    /// The tool without parts that it holds.
    pub fn own_tool(&self) -> &Arc<Tool> {
        &self.own_tool
    }

    /// Its surroundings and seats.
    pub fn around(&self) -> &Surroundings {
        &self.around
    }

    /// The parts that are held.
    pub fn gripped(&self) -> &[Grip] {
        &self.grips
    }

    /// The parts that lie elsewhere than in the mock-up.
    pub fn moved(&self) -> impl Iterator<Item = u32> + '_ {
        self.around.environment().put_down()
    }

    fn bodies(&self) -> &[Body] {
        &self.around.environment().bodies
    }

    /// Puts the tool at a pose, without a motion: its contacts there are seats.
    pub fn move_to(&mut self, pose: &Pose) -> Result<()> {
        self.around = Surroundings::around(self.bodies().to_vec(), self.tool().clone(), pose)?;
        Ok(())
    }

    /// Grips parts: from the mock-up, or from where they were put down. The tool is at a pose.
    ///
    /// Errors: something is held already, no part or one twice, or there is no such part to take; nothing has changed then.
    pub fn grip(&mut self, parts: &[u32], pose: &Pose) -> Result<()> {
        if let Some(grip) = self.grips.first() {
            return Err(Error::HoldsAlready { part: grip.part });
        }
        let (mut bodies, mut out, mut tool) = (self.bodies().to_vec(), self.out.clone(), self.own_tool.clone());
        let mut grips = Vec::with_capacity(parts.len());
        for part in parts {
            let (joined, tool_part) = match bodies.iter().position(|body| body.part == Some(*part)) {
                Some(at) => joined(&tool, bodies.remove(at).solver.scene().mockup(), None, pose)?,
                None if !self.scene.has_part(*part) || out.contains(part) => {
                    let parts = self.scene.mockup().part_bounds().len();
                    return Err(feeler_core::Error::NoSuchPart { part: *part, parts }.into());
                }
                None => {
                    out.push(*part);
                    joined(&tool, self.scene.mockup(), Some(*part), pose)?
                }
            };
            tool = Arc::new(joined);
            grips.push(Grip { part: *part, tool_part });
        }
        bodies[0] = self.mockup_without(&out)?;
        self.around = Surroundings::around(bodies, tool, pose)?;
        (self.grips, self.out) = (grips, out);
        Ok(())
    }

    /// Releases what is held.
    ///
    /// Errors: nothing is held; with [`Release::PutBack`] also where the tool is in a part's place, or the scene never had it.
    pub fn release(&mut self, to: Release, pose: &Pose) -> Result<()> {
        match to {
            Release::Here => self.put_down(pose),
            Release::PutBack => self.put_back(pose),
        }
    }

    fn put_down(&mut self, pose: &Pose) -> Result<()> {
        if self.grips.is_empty() {
            return Err(Error::HoldsNothing);
        }
        let (mut bodies, mesh) = (self.bodies().to_vec(), self.tool().mesh());
        for grip in &self.grips {
            let faces: Vec<[u32; 3]> = (0..mesh.faces().len() as u32)
                .filter(|f| self.tool().part_of_face(*f) == grip.tool_part)
                .map(|f| mesh.faces()[f as usize])
                .collect();
            let (vertices, faces) = gathered(&faces, |v| pose.apply(&mesh.vertices()[v as usize]));
            let mockup = Arc::new(Mockup::new(vertices, faces, vec![], 1)?);
            let scene = Scene::build(mockup, &SceneOptions::default())?;
            bodies.push(Body { solver: ContactSolver::new(Arc::new(scene)), part: Some(grip.part) });
        }
        self.around = Surroundings::around(bodies, self.own_tool.clone(), pose)?;
        self.grips.clear();
        Ok(())
    }

    fn put_back(&mut self, pose: &Pose) -> Result<()> {
        if self.grips.is_empty() {
            return Err(Error::HoldsNothing);
        }
        for Grip { part, .. } in self.grips.iter().copied() {
            if !self.scene.has_part(part) {
                return Err(Error::HasNoPlace { part });
            }
            // Also a tool that is wholly inside of the part, where no surfaces meet.
            let place = self.solver.with_scene(Arc::new(self.scene.only(&[part])?));
            if !place.is_free(&self.own_tool, pose) {
                return Err(Error::PlaceIsTaken { part });
            }
        }
        let is_out = |part: &u32| !self.grips.iter().any(|grip| grip.part == *part);
        let out: Vec<u32> = self.out.iter().copied().filter(is_out).collect();
        let mut bodies = self.bodies().to_vec();
        bodies[0] = self.mockup_without(&out)?;
        self.around = Surroundings::around(bodies, self.own_tool.clone(), pose)?;
        self.grips.clear();
        self.out = out;
        Ok(())
    }

    fn mockup_without(&self, parts: &[u32]) -> Result<Body> {
        Ok(Body { solver: self.solver.with_scene(Arc::new(self.scene.without(parts)?)), part: None })
    }
}

/// A tool with a part of a mock-up (`None`: all of it), and that part's number.
fn joined(tool: &Tool, mockup: &Mockup, part: Option<u32>, pose: &Pose) -> Result<(Tool, u32)> {
    let (mesh, own) = (mockup.mesh(), tool.mesh());
    let faces: Vec<[u32; 3]> = (0..mesh.faces().len() as u32)
        .filter(|f| part.is_none_or(|part| mockup.part_of_face(*f) == part))
        .map(|f| mesh.faces()[f as usize])
        .collect();
    let tool_from_world = transposed(pose.rotation());
    let into_tool = |p: &Point| times(&tool_from_world, &sub(p, pose.translation()));
    let (more, faces) = gathered(&faces, |v| into_tool(&mesh.vertices()[v as usize]));
    let first = own.vertices().len() as u32;
    let tool_part = tool.parts() as u32;
    let mut parts: Vec<u32> = (0..own.faces().len() as u32).map(|f| tool.part_of_face(f)).collect();
    parts.extend(std::iter::repeat_n(tool_part, faces.len()));
    let vertices = own.vertices().iter().copied().chain(more).collect();
    let faces = own.faces().iter().copied().chain(faces.into_iter().map(|f| f.map(|v| v + first))).collect();
    Ok((Tool::of_parts(vertices, faces, parts, tool_part as usize + 1)?, tool_part))
}

/// The vertices of some faces, each once, and the faces by their new numbers.
fn gathered(faces: &[[u32; 3]], place: impl Fn(u32) -> Point) -> (Vec<Point>, Vec<[u32; 3]>) {
    let mut used: Vec<u32> = faces.iter().flatten().copied().collect();
    used.sort_unstable();
    used.dedup();
    let number = |v: u32| used.binary_search(&v).unwrap_or(0) as u32;
    let renumbered = faces.iter().map(|face| face.map(number)).collect();
    (used.iter().map(|v| place(*v)).collect(), renumbered)
}
