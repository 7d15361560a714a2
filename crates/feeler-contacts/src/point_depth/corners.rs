//! The corners of pieces: the closest point of the other body, and their side of its surface. Both are kept for neighbours.

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

/// A corner in the cache.
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
    /// A point and the closest point of the other body, from the cache or a query.
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

/// A point and the closest point of the other body. `near`: triangles to start from.
pub fn corner(at: Point, near: &[u32], body: &Body) -> Option<Corner> {
    let closest = body.closest_from(&at, near)?;
    Some(Corner { at, distance: closest.distance, nearest: closest.triangle, point: closest.point })
}

#[cfg(test)]
mod tests {
    use super::super::brute::{body, distance};
    use super::*;
    use feeler_shapes::ball;
    use feeler_shapes::random::Random;

    #[test]
    fn kept_corners_are_as_found_ones() {
        let mut r = Random::new(3);
        let body = body(ball(1.0, 8));
        let points: Vec<Point> = (0..1000).map(|_| r.point(-1.0, 1.0)).collect();
        let mut cache = CornerCache::default();
        let mut kept = 0;
        for n in 0..6000 {
            let p = points[if n % 2 == 0 { n / 6 } else { r.below(1000) as usize }];
            let side = if p[0] > 0.3 { Some(Side::Counts) } else { (p[0] < -0.3).then_some(Side::Aside) };
            let known = cache.known_side(&p);
            assert!(known.is_none() || known == side);
            kept += usize::from(known.is_some());
            let mut is_asked = false;
            let found = cache.side(p, || {
                is_asked = true;
                side
            });
            assert_eq!((found, cache.known_side(&p)), (side, side));
            assert!(!(is_asked && known.is_some()));
            assert_eq!(cache.side(p, || unreachable!()), side);
            let corner = cache.closest(p, &[], &body).unwrap();
            assert_eq!(corner.at, p);
            assert!((corner.distance - distance(&body, &p)).abs() < 1e-12);
        }
        assert!(kept > 1000, "{kept}");
    }
}
