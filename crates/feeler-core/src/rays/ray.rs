//! The input and the answer of a ray query.

use crate::constants::LARGEST_COORDINATE;
use crate::error::{Error, Result};
use crate::geometry::bounds::Point;

/// A ray, world: the points `origin + t * direction` with `t` of 0 or more.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ray {
    /// Where it begins, metres.
    pub origin: Point,
    /// Where it goes; of any length.
    pub direction: Point,
}

/// A half space: the points with `normal . x >= offset`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HalfSpace {
    /// Any length but zero.
    pub normal: Point,
    /// Metres, times the length of the normal.
    pub offset: f64,
}

/// The first hit of a ray on the mock-up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RayHit {
    /// From the ray's origin, metres.
    pub distance: f64,
    /// World, metres.
    pub point: Point,
    /// The triangle's unit normal, turned against the ray; as the triangle is wound where the ray lies in its plane.
    pub normal: Point,
    /// The triangle met.
    pub triangle: u32,
    /// Its part.
    pub part: u32,
}

impl Ray {
    /// A ray from a point, metres, in a direction of any length.
    pub fn new(origin: Point, direction: Point) -> Ray {
        Ray { origin, direction }
    }

    /// Errors: numbers that are not finite or beyond 1e100 in size, and a direction with no entry of 1e-100 or more.
    pub(super) fn check(&self, ray: usize) -> Result<()> {
        let is_plain = |p: &Point| p.iter().all(|x| x.abs() <= LARGEST_COORDINATE);
        if !is_plain(&self.origin) {
            let must = "every entry must be finite and at most 1e100 in size";
            return Err(Error::Ray { what: "origins", ray, value: self.origin, must });
        }
        if !is_plain(&self.direction) || self.direction.iter().all(|x| x.abs() < 1.0 / LARGEST_COORDINATE) {
            let must = "every entry must be finite and at most 1e100 in size, and the largest at least 1e-100";
            return Err(Error::Ray { what: "directions", ray, value: self.direction, must });
        }
        Ok(())
    }
}

impl HalfSpace {
    /// The points with `normal . x >= offset`.
    pub fn new(normal: Point, offset: f64) -> HalfSpace {
        HalfSpace { normal, offset }
    }

    /// Errors: a normal of zero, and numbers that are not finite or beyond 1e100 in size.
    pub(super) fn check(&self, section: usize) -> Result<()> {
        let HalfSpace { normal: [x, y, z], offset } = *self;
        let is_plain = [x, y, z, offset].iter().all(|x| x.abs() <= LARGEST_COORDINATE);
        if is_plain && [x, y, z] != [0.0; 3] {
            return Ok(());
        }
        Err(Error::Section { section, value: [x, y, z, offset] })
    }
}
