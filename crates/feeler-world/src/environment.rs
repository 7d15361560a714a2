//! What the tool may meet: the mock-up, and parts that were put down elsewhere, each a scene of its own; asked together.

use feeler_contacts::ContactSolver;
use feeler_core::{closest_triangle_triangle, Closest, Point, Pose, Tool};

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
    pub bodies: Vec<Body>,
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
    /// Of the tool.
    pub tool_triangle: u32,
    /// Of the body's mock-up.
    pub triangle: u32,
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
}

impl Environment {
    /// The nearest points of a pair at a pose, the tool's first, world.
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
