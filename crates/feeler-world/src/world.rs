//! What is held and what stands around it: the mock-up, the tool, a part that is gripped, and parts that were put down elsewhere.
//!
//! A gripped part leaves the scene and joins the tool without a rebuild. Where it was seated (it met its neighbours, as parts in an
//! assembly do) it would be in collision from the first moment on: with those neighbours it is not asked until it is off them by a
//! skin, and until then planes taken at the seat keep it from going deeper.

use std::sync::Arc;

use feeler_contacts::ContactSolver;
use feeler_core::geometry::screw::{times, transposed};
use feeler_core::geometry::vectors::{dot, sub};
use feeler_core::{IgnoredPairs, Mockup, Point, Pose, Scene, SceneOptions, Tool};

use crate::environment::{Body, Environment, Plane};
use crate::error::{Error, Result};

/// A plane of a seat: the neighbour's surface, and points of the tool that are on it.
#[derive(Debug, Clone, PartialEq)]
pub struct Seat {
    /// World, as it was at the grip.
    pub plane: Plane,
    /// Place of the neighbour's scene in [`Environment::bodies`].
    pub body: usize,
    /// The neighbour, by its number in that scene.
    pub neighbour: u32,
    /// Points of the tool (its frame), and how far they were off the plane at the grip, metres.
    pub points: Vec<(Point, f64)>,
}

/// A gripped part.
#[derive(Debug, Clone, PartialEq)]
pub struct Grip {
    /// Its number in the mock-up.
    pub part: u32,
    /// Its number among the tool's parts.
    pub tool_part: u32,
    /// What it was seated on, as long as it is.
    pub seats: Vec<Seat>,
    /// Neighbours that are not asked: body and part in its scene.
    ignored: Vec<(usize, u32)>,
}

/// A part of the mock-up that lies elsewhere.
#[derive(Debug, Clone)]
pub struct PutDown {
    /// Its number in the mock-up.
    pub part: u32,
    /// Of this part alone, where it lies.
    pub scene: Arc<Scene>,
}

/// A tool, the part that it grips, and what stands around: the mock-up, and parts that were put down elsewhere.
#[derive(Debug)]
pub struct World {
    scene: Arc<Scene>,
    solver: ContactSolver,
    own_tool: Arc<Tool>,
    tool: Arc<Tool>,
    environment: Environment,
    grip: Option<Grip>,
    /// Parts that are not in their place: gripped, or put down.
    out: Vec<u32>,
}

impl World {
    /// A scene and a tool, nothing gripped, and parts that lie elsewhere: these leave their place in the scene, if they are there.
    ///
    /// Errors: no such part, one that is given twice, a scene that is not of one part.
    pub fn new(scene: Arc<Scene>, tool: Arc<Tool>, put_down: &[PutDown]) -> Result<World> {
        let (solver, parts) = (ContactSolver::new(scene.clone()), scene.mockup().part_bounds().len());
        let mut bodies = vec![Body { solver: solver.with_scene(scene.clone()), part: None }];
        let mut out = Vec::with_capacity(put_down.len());
        for PutDown { part, scene: alone } in put_down {
            let in_all = alone.mockup().part_bounds().len();
            if *part as usize >= parts {
                return Err(feeler_core::Error::NoSuchPart { part: *part, parts }.into());
            }
            if in_all != 1 || !alone.has_part(0) || out.contains(part) {
                return Err(Error::PutDown { part: *part, parts: in_all });
            }
            out.push(*part);
            bodies.push(Body { solver: ContactSolver::new(alone.clone()), part: Some(*part) });
        }
        if out.iter().any(|part| scene.has_part(*part)) {
            bodies[0].solver = solver.with_scene(Arc::new(scene.without(&out)?));
        }
        let environment = Environment { bodies };
        Ok(World { scene, solver, own_tool: tool.clone(), tool, environment, grip: None, out })
    }

    /// What moves: the tool, with the part that it holds.
    pub fn tool(&self) -> &Arc<Tool> {
        &self.tool
    }

    /// The tool without a part that it holds.
    pub fn own_tool(&self) -> &Arc<Tool> {
        &self.own_tool
    }

    /// What it may meet.
    pub fn environment(&self) -> &Environment {
        &self.environment
    }

    /// The part that is held.
    pub fn grip(&self) -> Option<&Grip> {
        self.grip.as_ref()
    }

    /// Parts that lie elsewhere than in the mock-up.
    pub fn moved(&self) -> impl Iterator<Item = u32> + '_ {
        self.environment.bodies.iter().filter_map(|body| body.part)
    }

    /// Takes a part: out of the mock-up, or from where it was put down. The tool is at a pose.
    ///
    /// Errors: something is held already, or there is no such part to take.
    pub fn take(&mut self, part: u32, pose: &Pose) -> Result<()> {
        if let Some(grip) = &self.grip {
            return Err(Error::HoldsAlready { part: grip.part });
        }
        let put_down = self.environment.bodies.iter().position(|body| body.part == Some(part));
        let (tool, tool_part) = match put_down {
            Some(at) => self.joined(self.environment.bodies[at].solver.scene().mockup(), None, pose)?,
            None if !self.scene.has_part(part) => {
                return Err(
                    feeler_core::Error::NoSuchPart { part, parts: self.scene.mockup().part_bounds().len() }.into()
                )
            }
            None => self.joined(self.scene.mockup(), Some(part), pose)?,
        };
        match put_down {
            Some(at) => drop(self.environment.bodies.remove(at)),
            None => self.out.push(part),
        }
        self.tool = Arc::new(tool);
        self.grip = Some(Grip { part, tool_part, seats: Vec::new(), ignored: Vec::new() });
        self.set_mockup(self.scene.without(&self.out)?);
        self.seat(pose)
    }

    /// Puts the part down where it is: a part of the scene again, in its new place.
    pub fn put_down(&mut self, pose: &Pose) -> Result<()> {
        let Some(grip) = self.grip.take() else { return Err(Error::HoldsNothing) };
        let mesh = self.tool.mesh();
        let faces: Vec<[u32; 3]> = (0..mesh.faces().len() as u32)
            .filter(|f| self.tool.part_of_face(*f) == grip.tool_part)
            .map(|f| mesh.faces()[f as usize])
            .collect();
        let (vertices, faces) = gathered(&faces, |v| pose.apply(&mesh.vertices()[v as usize]));
        let scene =
            Scene::build(Arc::new(Mockup::new(vertices, faces, vec![], 1)?), &SceneOptions::default(), &|_, _| true)?;
        let solver = ContactSolver::new(Arc::new(scene));
        self.environment.bodies.push(Body { solver, part: Some(grip.part) });
        self.let_go()
    }

    /// Puts the part back where it was in the mock-up, wherever it is. Errors where the tool is in its place, or the scene never had it.
    pub fn put_back(&mut self, pose: &Pose) -> Result<()> {
        let Some(grip) = &self.grip else { return Err(Error::HoldsNothing) };
        let part = grip.part;
        if !self.scene.has_part(part) {
            return Err(Error::HasNoPlace { part });
        }
        if self.scene.only(&[part])?.is_colliding(&self.own_tool, pose) {
            return Err(Error::PlaceIsTaken { part });
        }
        self.grip = None;
        self.out.retain(|out| *out != part);
        self.let_go()
    }

    fn let_go(&mut self) -> Result<()> {
        self.tool = self.own_tool.clone();
        self.set_mockup(self.scene.without(&self.out)?);
        Ok(())
    }

    fn set_mockup(&mut self, scene: Scene) {
        self.environment.bodies[0].solver = self.solver.with_scene(Arc::new(scene));
    }

    /// The own tool with a part of a mock-up (`None`: all of it), and that part's number.
    fn joined(&self, mockup: &Mockup, part: Option<u32>, pose: &Pose) -> Result<(Tool, u32)> {
        let (mesh, own) = (mockup.mesh(), self.own_tool.mesh());
        let faces: Vec<[u32; 3]> = (0..mesh.faces().len() as u32)
            .filter(|f| part.is_none_or(|part| mockup.part_of_face(*f) == part))
            .map(|f| mesh.faces()[f as usize])
            .collect();
        let tool_from_world = transposed(pose.rotation());
        let into_tool = |p: &Point| times(&tool_from_world, &sub(p, pose.translation()));
        let (more, faces) = gathered(&faces, |v| into_tool(&mesh.vertices()[v as usize]));
        let first = own.vertices().len() as u32;
        let tool_part = self.own_tool.parts() as u32;
        let mut parts: Vec<u32> = (0..own.faces().len() as u32).map(|f| self.own_tool.part_of_face(f)).collect();
        parts.extend(std::iter::repeat_n(tool_part, faces.len()));
        let vertices = own.vertices().iter().copied().chain(more).collect();
        let faces = own.faces().iter().copied().chain(faces.into_iter().map(|f| f.map(|v| v + first))).collect();
        Ok((Tool::of_parts(vertices, faces, parts, tool_part as usize + 1)?, tool_part))
    }

    /// Finds what the gripped part is seated on.
    fn seat(&mut self, pose: &Pose) -> Result<()> {
        let World { environment, tool, grip, .. } = self;
        let Some(grip) = grip else { return Ok(()) };
        for (number, body) in environment.bodies.iter_mut().enumerate() {
            let scene = body.solver.scene().clone();
            let mockup = scene.mockup();
            let hit = scene.collide(tool, pose);
            let met = hit.pairs.iter().filter(|pair| tool.part_of_face(pair[0]) == grip.tool_part);
            let mut neighbours: Vec<u32> = met.map(|pair| mockup.part_of_face(pair[1])).collect();
            neighbours.sort_unstable();
            neighbours.dedup();
            if neighbours.is_empty() {
                continue;
            }
            for plane in body.solver.contacts(tool, pose, 0.0, None)?.planes {
                if plane.tool_part(tool) != grip.tool_part || !neighbours.contains(&plane.part) {
                    continue;
                }
                let off = |p: &Point| dot(&sub(&pose.apply(p), &plane.point), &plane.normal);
                let footing = body.solver.footing(tool, pose, &plane);
                let points = footing.points().iter().map(|p| (*p, off(p))).collect();
                let part = body.part.unwrap_or(plane.part);
                let shown = Plane { point: plane.point, normal: plane.normal, gap: plane.gap, part, id: plane.id };
                grip.seats.push(Seat { plane: shown, body: number, neighbour: plane.part, points });
            }
            grip.ignored.extend(neighbours.into_iter().map(|part| (number, part)));
        }
        self.ignore();
        Ok(())
    }

    /// Asks again of neighbours that the gripped part is off by a skin. Whether any was.
    pub fn unseat(&mut self, pose: &Pose, skin: f64) -> Result<bool> {
        let World { environment, tool, grip, .. } = self;
        let Some(grip) = grip.as_mut().filter(|grip| !grip.ignored.is_empty()) else { return Ok(false) };
        let before = grip.ignored.len();
        let mut still = Vec::with_capacity(before);
        for (body, part) in grip.ignored.drain(..) {
            let scene = environment.bodies[body].solver.scene().asking_all_pairs().only(&[part])?;
            let is_near = |gap: &feeler_core::Gap| gap.tool_part == grip.tool_part;
            // The nearest of a part may be another part of the tool, which is free of it.
            let near = scene.near_pairs(tool, pose, skin)?;
            if near.iter().any(is_near) {
                still.push((body, part));
            }
        }
        grip.ignored = still;
        grip.seats.retain(|seat| grip.ignored.contains(&(seat.body, seat.neighbour)));
        let has_changed = grip.ignored.len() < before;
        if has_changed {
            self.ignore();
        }
        Ok(has_changed)
    }

    fn ignore(&mut self) {
        let Some(grip) = &self.grip else { return };
        for (number, body) in self.environment.bodies.iter_mut().enumerate() {
            let scene = body.solver.scene();
            let parts = scene.mockup().part_bounds().len();
            let pairs = grip.ignored.iter().filter(|(of, _)| *of == number).map(|(_, part)| [grip.tool_part, *part]);
            let ignored = IgnoredPairs::new(self.tool.parts(), parts, pairs);
            let scene = Arc::new(scene.asking_all_pairs().ignoring(Arc::new(ignored)));
            body.solver = body.solver.with_scene(scene);
        }
    }
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
