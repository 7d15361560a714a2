//! What is known of the corners of pieces: the closest point of the other body, and on which side of its surface they are.

use feeler_core::Point;

use super::body::Body;
use super::distances::Corner;

/// On which side of the other surface something is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// All of it counts.
    Counts,
    /// Nothing of it does.
    Aside,
    /// That is not known, or not the same for all of it.
    Open,
}

/// Corners of triangles that were found last: neighbours share them.
#[derive(Debug)]
pub struct CornerCache {
    kept: Vec<Kept>,
}

/// What is known of a point.
#[derive(Debug, Clone, Copy)]
struct Kept {
    at: Point,
    corner: Option<Corner>,
    /// On which side it is, `None` where that was not found yet; and of that, `None` where it is on the other surface.
    side: Option<Option<Side>>,
}

impl Default for CornerCache {
    fn default() -> CornerCache {
        CornerCache { kept: vec![Kept { at: [f64::NAN; 3], corner: None, side: None }; CORNERS_KEPT] }
    }
}

impl CornerCache {
    /// A point with what is closest to it, kept or found.
    pub fn closest(&mut self, at: Point, near: &[u32], body: &Body) -> Option<Corner> {
        let kept = self.of(at);
        if kept.corner.is_none() {
            kept.corner = corner(at, near, body);
        }
        kept.corner
    }

    /// On which side a point is, if that is kept and the point is not on the surface.
    pub fn known_side(&self, at: &Point) -> Option<Side> {
        let kept = &self.kept[place_of(at)];
        kept.side.flatten().filter(|_| kept.at == *at)
    }

    /// On which side a point is, kept or found.
    pub fn side(&mut self, at: Point, find: impl FnOnce() -> Option<Side>) -> Option<Side> {
        *self.of(at).side.get_or_insert_with(find)
    }

    fn of(&mut self, at: Point) -> &mut Kept {
        let place = &mut self.kept[place_of(&at)];
        if place.at != at {
            *place = Kept { at, corner: None, side: None };
        }
        place
    }
}

fn place_of(at: &Point) -> usize {
    let hash = at.iter().fold(0u64, |sum, x| (sum.rotate_left(23) ^ x.to_bits()).wrapping_mul(0x9e37_79b9_7f4a_7c15));
    (hash >> 40) as usize % CORNERS_KEPT
}

/// Places for them.
const CORNERS_KEPT: usize = 128;

/// A point with what is closest to it; triangles that are near are looked at first.
pub fn corner(at: Point, near: &[u32], body: &Body) -> Option<Corner> {
    let closest = body.closest_from(&at, near)?;
    Some(Corner { at, distance: closest.distance, nearest: closest.triangle, point: closest.point })
}
