//! The surroundings of the tool: the mock-up, and parts put down elsewhere, each a scene of its own; queried together.

use std::sync::Arc;

use feeler_contacts::ContactSolver;
use feeler_core::{closest_triangle_triangle, Closest, Point, Pose, Scene, Tool};

use crate::error::{Error, Result};

/// One scene of several.
#[derive(Debug)]
pub struct Body {
    /// Its contacts.
    pub solver: ContactSolver,
    /// The part of the mock-up that it is, where it is one that was put down; else parts keep their numbers.
    pub part: Option<u32>,
}

/// All scenes.
#[derive(Debug, Default)]
pub struct Environment {
    /// The mock-up first.
    #[doc(hidden)]
    pub bodies: Vec<Body>,
}

/// A part of the mock-up that lies elsewhere.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct PutDown {
    /// Its number in the mock-up.
    pub part: u32,
    /// Of this part alone, where it lies, its triangles in the mock-up's order.
    pub scene: Arc<Scene>,
}

impl PutDown {
    /// A part, and the scene of it alone, where it lies.
    pub fn new(part: u32, scene: Arc<Scene>) -> PutDown {
        PutDown { part, scene }
    }
}

/// A plane of the contacts.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Plane {
    /// On the mock-up, world, metres.
    pub point: Point,
    /// Unit, from the mock-up to the tool.
    pub normal: Point,
    /// Distance of the tool at the pose where it was taken, metres.
    pub gap: f64,
    /// The part of the mock-up.
    pub part: u32,
    /// The same for the same two surfaces from pose to pose.
    pub id: u64,
}

/// A triangle of the tool and one of a body.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Pair {
    /// Place in [`Environment::bodies`].
    pub body: u32,
    /// Of the tool; of a seat, of its eroded part.
    pub tool_triangle: u32,
    /// Of the body's mock-up.
    pub triangle: u32,
    /// Of which seat of the body, where it is one.
    pub seat: Option<u32>,
}

impl Clone for Body {
    fn clone(&self) -> Body {
        Body { solver: self.solver.with_scene(self.solver.scene().clone()), part: self.part }
    }
}

impl Body {
    /// The number in the mock-up of a part of its scene.
    pub fn part_in_mockup(&self, part: u32) -> u32 {
        self.part.unwrap_or(part)
    }

    /// The number in its scene of a part of the mock-up; `None` where it is not this body's.
    pub fn own_part(&self, part: u32) -> Option<u32> {
        match self.part {
            Some(own) => (own == part).then_some(0),
            None => self.solver.scene().has_part(part).then_some(part),
        }
    }
}

impl Environment {
    /// A mock-up, and parts of it that lie elsewhere: these leave their place in the scene, if they are there.
    ///
    /// Errors: no such part, one that is given twice, a scene that is not of one part.
    pub fn new(scene: &Arc<Scene>, put_down: &[PutDown]) -> Result<Environment> {
        let (solver, parts) = (ContactSolver::new(scene.clone()), scene.mockup().part_bounds().len());
        let mut environment = Environment { bodies: vec![Body { solver, part: None }] };
        for PutDown { part, scene: alone } in put_down {
            let in_all = alone.mockup().part_bounds().len();
            if *part as usize >= parts {
                return Err(feeler_core::Error::NoSuchPart { part: *part, parts }.into());
            }
            if in_all != 1 || !alone.has_part(0) || environment.put_down().any(|known| known == *part) {
                return Err(Error::PutDown { part: *part, parts: in_all });
            }
            environment.bodies.push(Body { solver: ContactSolver::new(alone.clone()), part: Some(*part) });
        }
        let out: Vec<u32> = environment.put_down().collect();
        if out.iter().any(|part| scene.has_part(*part)) {
            let first = &mut environment.bodies[0].solver;
            *first = first.with_scene(Arc::new(scene.without(&out)?));
        }
        Ok(environment)
    }

    /// The parts that lie elsewhere than in the mock-up.
    pub fn put_down(&self) -> impl Iterator<Item = u32> + '_ {
        self.bodies.iter().filter_map(|body| body.part)
    }

    /// The nearest points of a pair of a tool (of a seat: of its eroded part) at a pose, the tool's first, world.
    pub fn closest(&self, tool: &Tool, pose: &Pose, pair: &Pair) -> Option<Closest> {
        let mesh = self.bodies.get(pair.body as usize)?.solver.scene().mockup().mesh();
        let placed = pose.apply_triangle(&tool.mesh().triangle(pair.tool_triangle));
        Some(closest_triangle_triangle(&placed, &mesh.triangle(pair.triangle)))
    }

    /// The part of the mock-up that a pair's triangle is of.
    pub fn part_of(&self, pair: &Pair) -> u32 {
        let body = &self.bodies[pair.body as usize];
        body.part_in_mockup(body.solver.scene().mockup().part_of_face(pair.triangle))
    }
}

/// Bodies number their surfaces each for itself.
pub fn id_in_body(id: u64, body: usize) -> u64 {
    id ^ (body as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15)
}
