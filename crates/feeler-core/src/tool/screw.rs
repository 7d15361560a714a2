//! Screws: rotations about an axis with an advance along it.

use std::f64::consts::TAU;

use crate::constants::{LARGEST_COORDINATE, MOST_TURNS};
use crate::error::{Error, Result};
use crate::geometry::bounds::Point;
use crate::geometry::pose::Pose;
use crate::geometry::twist::{product, times, turn};
use crate::geometry::vectors::{dot, scaled, sub, unit};

/// A rotation about an axis in the world with an advance along it, as of a bolt or a door (J. Rossignac and J. Kim,
/// *Computing and visualizing pose-interpolating 3D motions*, 2001).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Screw {
    axis: Point,
    point: Point,
    angle: f64,
    pitch: f64,
}

impl Screw {
    /// About `axis` (of any length up to 1e100) through `point` (metres), by `angle` (radians, right-handed, negative the other way
    /// round); `pitch`: metres along the axis for a whole turn, 0 for a hinge, negative for a left-handed thread.
    ///
    /// Errors: an axis without a direction, numbers that are not finite or too large, more than a thousand turns.
    pub fn new(axis: &Point, point: &Point, angle: f64, pitch: f64) -> Result<Screw> {
        let fault = |what: &'static str, value: f64, must: &'static str| Error::Screw { what, value, must };
        let is_good = |x: &&f64| x.is_finite() && x.abs() <= LARGEST_COORDINATE;
        let finite = "finite and at most 1e100 in size";
        for (what, values) in
            [("axis of the screw", &axis[..]), ("point of the screw", &point[..]), ("pitch of the screw", &[pitch])]
        {
            if let Some(value) = values.iter().find(|x| !is_good(x)) {
                return Err(fault(what, *value, finite));
            }
        }
        if angle.is_nan() || angle.abs() > MOST_TURNS * TAU {
            return Err(fault("angle of the screw", angle, "radians, at most a thousand turns"));
        }
        // A unit stays as it is, to the last bit: screws that travel are the same there.
        let is_unit = (dot(axis, axis) - 1.0).abs() <= 4.0 * f64::EPSILON;
        let axis = if is_unit { Some(*axis) } else { unit(axis) };
        let axis = axis.ok_or_else(|| fault("axis of the screw", 0.0, "a direction that is not zero"))?;
        let screw = Screw { axis, point: *point, angle, pitch };
        if !is_good(&&screw.advance()) {
            return Err(fault("pitch of the screw", pitch, finite));
        }
        Ok(screw)
    }

    /// Unit, world.
    pub fn axis(&self) -> &Point {
        &self.axis
    }

    /// A point on the axis, metres, world.
    pub fn point(&self) -> &Point {
        &self.point
    }

    /// Radians.
    pub fn angle(&self) -> f64 {
        self.angle
    }

    /// Metres along the axis for a whole turn.
    pub fn pitch(&self) -> f64 {
        self.pitch
    }

    /// Metres along the axis for the whole angle.
    pub fn advance(&self) -> f64 {
        self.pitch * (self.angle / TAU)
    }

    /// A pose after a share of it, 0 to 1 as a rule.
    ///
    /// Errors: a share that is not finite, and a pose beyond the coordinate limit.
    pub fn at(&self, pose: &Pose, share: f64) -> Result<Pose> {
        let turned = turn(&self.axis, self.angle * share);
        let from = pose.translation();
        let foot = self.foot(from);
        let (arm, advance) = (times(&turned, &sub(from, &foot)), self.advance() * share);
        let place = std::array::from_fn(|a| foot[a] + arm[a] + advance * self.axis[a]);
        Pose::unchecked(product(&turned, pose.rotation()), place).translated(&[0.0; 3])
    }

    /// A share of it, from 0 to 1.
    pub fn share(&self, share: f64) -> Screw {
        Screw { angle: self.angle * share, ..*self }
    }

    /// The way back.
    pub fn reversed(&self) -> Screw {
        Screw { angle: -self.angle, ..*self }
    }

    /// The point of the axis that is nearest to another.
    pub(crate) fn foot(&self, of: &Point) -> Point {
        let height = dot(&sub(of, &self.point), &self.axis);
        std::array::from_fn(|a| self.point[a] + height * self.axis[a])
    }

    /// The advance as a vector.
    pub(crate) fn way(&self) -> Point {
        scaled(&self.axis, self.advance())
    }
}
