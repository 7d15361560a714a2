//! A shape at a pose.

use std::sync::Arc;

use once_cell::race::OnceBox;

use super::shape::Shape;
use crate::constants::{TRANSFORM_ROUNDOFFS, UNIT_ROUNDOFF};
use crate::geometry::bounds::{Aabb, Point};
use crate::geometry::pose::Pose;
use crate::mesh::triangle_mesh::Corners;

/// A shape at a pose.
#[derive(Debug)]
pub(crate) struct Body {
    shape: Arc<Shape>,
    pose: Pose,
    bounds: Aabb,
    /// The vertices in the world; made when a pair of bodies first needs them.
    vertices: OnceBox<Vec<Point>>,
}

impl Body {
    pub fn new(shape: Arc<Shape>, pose: Pose) -> Body {
        let local = shape.mesh().bounds();
        let largest = 3.1 * local.largest_coordinate() + pose.largest_translation();
        let bounds = pose.apply_box(&local, TRANSFORM_ROUNDOFFS * UNIT_ROUNDOFF * largest);
        Body { shape, pose, bounds, vertices: OnceBox::new() }
    }

    pub fn shape(&self) -> &Arc<Shape> {
        &self.shape
    }

    /// `world_from_body`.
    pub fn pose(&self) -> &Pose {
        &self.pose
    }

    /// A box around it in the world.
    pub fn bounds(&self) -> &Aabb {
        &self.bounds
    }

    /// Its triangles in the world, as [`Pose::apply`] computes their corners.
    pub fn corners(&self) -> Corners<'_> {
        let own = self.shape.mesh().corners();
        if self.pose == Pose::IDENTITY {
            return own;
        }
        let placed = || Box::new(own.vertices.iter().map(|p| self.pose.apply(p)).collect());
        Corners { vertices: self.vertices.get_or_init(placed), ..own }
    }

    /// One of its vertices in the world.
    pub fn vertex(&self, id: u32) -> Point {
        self.pose.apply(&self.shape.mesh().vertices()[id as usize])
    }
}
