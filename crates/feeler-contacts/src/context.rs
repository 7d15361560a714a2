//! The inputs of one query: the two surfaces with their adjacency, the pose and the reference.

use feeler_core::constants::NONE;
use feeler_core::geometry::vectors::{dot, scaled, sub};
use feeler_core::mesh::topology::adjacency::Adjacency;
use feeler_core::{Aabb, GoOn, Mockup, Point, Pose, Scene, Tool, Triangle};
use feeler_lanes::Checked;

use crate::constants::ENCLOSURE_SLACK;
use crate::surface::Surface;

/// The inputs of one query, and what follows from them at once.
pub(crate) struct QueryContext<'a> {
    pub mockup: &'a Mockup,
    pub tool: &'a Tool,
    /// `world_from_tool`.
    pub pose: &'a Pose,
    /// A pose at which the tool was free, the last before this one.
    pub reference: Option<&'a Pose>,
    /// Of the tool, and of the mock-up.
    pub adjacency: [&'a Adjacency; 2],
    /// The tool's centre of area, metres, world.
    pub centre: Point,
    pub lanes: Checked,
    /// Whether the query goes on.
    pub go_on: GoOn<'a>,
}

impl<'a> QueryContext<'a> {
    pub fn new(scene: &'a Scene, tool: &'a Tool, pose: &'a Pose, reference: Option<&'a Pose>) -> QueryContext<'a> {
        QueryContext {
            mockup: scene.mockup(),
            tool,
            pose,
            reference,
            adjacency: [tool.adjacency(), scene.mockup().adjacency()],
            centre: pose.apply(&tool.adjacency().centre),
            lanes: scene.index().lanes(),
            go_on: GoOn::default(),
        }
    }

    /// The same for a query that can be stopped.
    pub fn asking(self, go_on: GoOn<'a>) -> QueryContext<'a> {
        QueryContext { go_on, ..self }
    }
}

impl QueryContext<'_> {
    /// World, as all points below.
    pub fn tool_triangle(&self, t: u32) -> Triangle {
        self.pose.apply_triangle(&self.tool.mesh().triangle(t))
    }

    pub fn mockup_triangle(&self, m: u32) -> Triangle {
        self.mockup.mesh().triangle(m)
    }

    /// The first corner of a triangle.
    pub fn corner(&self, surface: Surface, id: u32) -> Point {
        if surface == Surface::Tool {
            self.pose.apply(&self.tool.mesh().corner(id))
        } else {
            self.mockup.mesh().corner(id)
        }
    }

    pub fn triangle(&self, surface: Surface, id: u32) -> Triangle {
        if surface == Surface::Tool {
            self.tool_triangle(id)
        } else {
            self.mockup_triangle(id)
        }
    }

    /// The factor, 1 or -1, that makes the normal by a triangle's winding the outward one where the surface is closed.
    pub fn sense(&self, surface: Surface, id: u32) -> f64 {
        if self.adjacency[surface].outward[id as usize] < 0 {
            -1.0
        } else {
            1.0
        }
    }

    /// The pairs of one triangle of a pair and a neighbour of the other.
    pub fn neighbour_pairs(&self, [t, m]: [u32; 2]) -> impl Iterator<Item = [u32; 2]> {
        let of_tool = self.adjacency[Surface::Tool].neighbours[t as usize].map(|n| [n, m]);
        let of_mockup = self.adjacency[Surface::Mockup].neighbours[m as usize].map(|n| [t, n]);
        of_tool.into_iter().chain(of_mockup).filter(|pair| !pair.contains(&NONE))
    }

    /// The box of the tool, in its own frame, or of a part of the mock-up, widened by rounding: a point outside it is outside the solid.
    pub fn enclosure(&self, surface: Surface, part: u32) -> Aabb {
        let (b, slack) = match surface {
            Surface::Tool => (self.tool.mesh().bounds(), self.tool.margin_at(self.pose)),
            _ => (self.mockup.part_bounds()[part as usize], 0.0),
        };
        let slack = slack + ENCLOSURE_SLACK * (0..3).map(|a| b.upper[a] - b.lower[a]).fold(0.0, f64::max);
        Aabb { lower: b.lower.map(|x| x - slack), upper: b.upper.map(|x| x + slack) }
    }

    /// Whether a point (world) is in such a box.
    pub fn is_enclosed(&self, surface: Surface, enclosure: &Aabb, p: &Point) -> bool {
        let q = if surface == Surface::Tool { self.in_tool(p) } else { *p };
        (0..3).all(|a| enclosure.lower[a] <= q[a] && q[a] <= enclosure.upper[a])
    }

    /// A point given in the world, in the tool's own frame.
    pub fn in_tool(&self, p: &Point) -> Point {
        let (r, t) = (self.pose.rotation(), self.pose.translation());
        let d = sub(p, t);
        std::array::from_fn(|a| r[0][a] * d[0] + r[1][a] * d[1] + r[2][a] * d[2])
    }

    /// The normal `n` of a triangle, turned outward where the surface is closed, else to the side of a near triangle's normal, the side that
    /// counts as outside there.
    pub fn turned_outward(&self, surface: Surface, id: u32, n: &Point, is_closed: bool, near: &Point) -> Point {
        let flip = match self.adjacency[surface].outward[id as usize] {
            side if is_closed && side != 0 => side < 0,
            _ => dot(n, near) < 0.0,
        };
        if flip {
            scaled(n, -1.0)
        } else {
            *n
        }
    }

    /// The displacement of a point of the tool from the pose back to the reference.
    pub fn way_back(&self, p: &Point) -> Option<Point> {
        let reference = self.reference?;
        Some(sub(&reference.apply(&self.in_tool(p)), p))
    }
}
