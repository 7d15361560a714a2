//! Whether a solid body holds a point of another.

use feeler_lanes::SplitMix64;

use super::body::Body;
use crate::geometry::bounds::Point;
use crate::geometry::predicates::is_collinear;
use crate::geometry::ray_crossings::{crossing, ray_end, RAY_OFFSETS};

/// Rays that are tried beyond the usual ones: each hits an edge with hardly any chance.
const MORE_RAYS: usize = 58;

/// Whether one of two bodies, whose surfaces do not meet, is solid and holds a whole surface of the other.
pub(super) fn is_inside(a: &Body, b: &Body) -> bool {
    holds_any(a, b) || holds_any(b, a)
}

fn holds_any(solid: &Body, other: &Body) -> bool {
    let is_near = |p: &Point| solid.bounds().contains(p);
    solid.shape().is_solid()
        && other.shape().surfaces().iter().map(|v| other.vertex(*v)).any(|p| is_near(&p) && is_around(solid, &p))
}

/// Whether a closed surface winds around a point that is not on it, by exact signs along a ray that hits no edge.
fn is_around(solid: &Body, p: &Point) -> bool {
    let (mesh, corners) = (solid.shape().mesh(), solid.corners());
    let winding = |offset: &[f64; 2]| {
        let end = ray_end(p, solid.bounds(), offset);
        let mut winding = 0;
        for id in mesh.queried() {
            let t = corners.triangle(id);
            match crossing(p, &end, &t) {
                Some(by) => winding += by,
                // Without an area where it is placed: the ray passes it.
                None if is_collinear(&t[0], &t[1], &t[2]) => {}
                None => return None,
            }
        }
        Some(winding)
    };
    let mut random = SplitMix64::new(1);
    let more = (0..MORE_RAYS).map(|_| [random.unit() - 0.5, random.unit() - 0.5]);
    RAY_OFFSETS.into_iter().chain(more).find_map(|offset| winding(&offset)).is_some_and(|winding| winding != 0)
}
