//! What the tool may meet: the mock-up, and parts that were put down elsewhere, each a scene of its own; asked together.

use feeler_contacts::{ContactSolver, Manifold, Manifolds};
use feeler_core::{closest_triangle_triangle, Closest, Point, Pose, Tool};

use crate::error::Result;

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

/// The first meeting on a way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Impact {
    /// The share of the way that is free.
    pub fraction: f64,
    /// Who meets.
    pub pair: Pair,
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

impl Environment {
    /// The contact manifolds of a free pose, nearest first, and how far off all else is.
    pub fn manifolds(&self, tool: &Tool, pose: &Pose, margin: f64, out: &mut Manifolds) -> Result<()> {
        let mut all: Vec<Manifold> = Vec::new();
        let mut least = margin;
        for (number, body) in self.bodies.iter().enumerate() {
            body.solver.manifolds(tool, pose, margin, out)?;
            if self.bodies.len() == 1 {
                return Ok(());
            }
            least = least.min(out.margin);
            for manifold in &mut out.manifolds {
                manifold.part = body.part.unwrap_or(manifold.part);
                manifold.id ^= (number as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15);
            }
            all.append(&mut out.manifolds);
        }
        all.sort_by(|a, b| a.gap.total_cmp(&b.gap).then(a.id.cmp(&b.id)));
        out.manifolds = all;
        out.margin = least;
        Ok(())
    }

    /// The first impact on the way between two poses, as [`Scene::cast_beside`](feeler_core::Scene::cast_beside) some directions.
    pub fn first_impact(
        &self,
        tool: &Tool,
        (from, to): (&Pose, &Pose),
        tolerance: f64,
        beside: &[Point],
    ) -> Result<Option<Impact>> {
        let mut first: Option<Impact> = None;
        for (number, body) in (0..).zip(&self.bodies) {
            let Some(cast) = body.solver.scene().cast_beside(tool, from, to, tolerance, beside)? else { continue };
            if first.is_none_or(|first| cast.fraction < first.fraction) {
                let (tool_triangle, triangle) = (cast.tool_triangle, cast.mockup_triangle);
                first = Some(Impact { fraction: cast.fraction, pair: Pair { body: number, tool_triangle, triangle } });
            }
        }
        Ok(first)
    }

    /// The least distance, where that is less than `within`, metres.
    pub fn distance(&self, tool: &Tool, pose: &Pose, within: f64) -> Result<Option<f64>> {
        let mut least = None;
        for body in &self.bodies {
            let gap = body.solver.scene().closest(tool, pose, least.unwrap_or(within))?;
            least = gap.map(|gap| gap.distance).or(least);
        }
        Ok(least)
    }

    /// Whether any triangles meet, exactly.
    pub fn is_colliding(&self, tool: &Tool, pose: &Pose) -> bool {
        self.bodies.iter().any(|body| body.solver.scene().is_colliding(tool, pose))
    }

    /// The nearest points of a pair at a pose, the tool's first, world.
    pub fn closest(&self, tool: &Tool, pose: &Pose, pair: &Pair) -> Option<Closest> {
        let mesh = self.bodies.get(pair.body as usize)?.solver.scene().mockup().mesh();
        let placed = pose.apply_triangle(&tool.mesh().triangle(pair.tool_triangle));
        Some(closest_triangle_triangle(&placed, &mesh.triangle(pair.triangle)))
    }

    /// The part of the mock-up that a pair's triangle is of.
    pub fn part_of(&self, pair: &Pair) -> u32 {
        let body = &self.bodies[pair.body as usize];
        body.part.unwrap_or_else(|| body.solver.scene().mockup().part_of_face(pair.triangle))
    }
}
