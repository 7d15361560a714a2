//! How deep two parts are in each other: the smaller one as a tool, where it is, against the other alone.

use feeler_core::geometry::vectors::{along, length, scaled};
use feeler_core::{closest_triangle_triangle, Aabb, Point, Pose, Result, Tool, Triangle};

use crate::contact_plane::ContactPlane;
use crate::escape::penetration::{way_out, PenetrationKind};
use crate::query::ContactQuery;

/// What was measured of a tool and a part.
#[derive(Debug, Clone)]
pub struct Depth {
    /// Of the deepest contact, metres.
    pub depth: f64,
    /// What depth and translation are.
    pub kind: PenetrationKind,
    /// Moves the tool out of the part.
    pub translation: Point,
    /// On the tool, and on the part.
    pub points: [Point; 2],
    /// Pairs of triangles that meet.
    pub triangles: usize,
    /// The box around where they do.
    pub bounds: Aabb,
    /// How far surfaces are apart that do not meet.
    pub gap: f64,
}

/// Of a tool that meets the only part of a scene, or is in it, or the part in the tool.
pub fn measure(query: &ContactQuery<'_>, tool: &Tool) -> Result<Depth> {
    let (scene, pose) = (query.scene, &Pose::IDENTITY);
    let mockup = scene.mockup();
    let (mut triangles, mut bounds, mut first) = (0, Aabb::EMPTY, None);
    let mut show = |pairs: &[[u32; 2]]| {
        triangles = pairs.len();
        for pair in pairs {
            let both = [tool.mesh().triangle(pair[0]), mockup.mesh().triangle(pair[1])];
            bounds = bounds.union(&shared_box(&both));
            first.get_or_insert(both);
        }
    };
    let contacts = query.contacts_showing(|_| None, tool, pose, 0.0, None, &mut show)?;
    let deepest = contacts.planes.first().map(|plane| (points_of(plane), (-plane.gap).max(0.0)));
    let way = way_out(query, tool, pose, 0.0, None, contacts)?;
    let (points, gap, depth) = match (deepest, first) {
        (Some((points, depth)), _) if depth > 0.0 => (points, 0.0, depth),
        (_, Some([p, q])) => {
            let closest = closest_triangle_triangle(&p, &q);
            ([closest.on_p, closest.on_q], 0.0, way.depth)
        }
        (_, None) => match scene.closest(tool, pose, f64::INFINITY)? {
            Some(gap) => {
                let points = [gap.on_tool, gap.on_mockup];
                points.iter().for_each(|p| bounds.grow(p));
                (points, gap.distance, way.depth)
            }
            None => ([[0.0; 3]; 2], 0.0, way.depth),
        },
    };
    Ok(Depth { depth, kind: way.kind, translation: way.translation, points, triangles, bounds, gap })
}

/// Of the tool the one that is deepest, of the part where the plane runs.
fn points_of(plane: &ContactPlane) -> [Point; 2] {
    [along(&plane.point, plane.gap, &plane.normal), plane.point]
}

/// Where the boxes of two triangles overlap.
pub fn shared_box([p, q]: &[Triangle; 2]) -> Aabb {
    let (p, q) = (Aabb::of_triangle(p), Aabb::of_triangle(q));
    Aabb {
        lower: std::array::from_fn(|a| p.lower[a].max(q.lower[a])),
        upper: std::array::from_fn(|a| p.upper[a].min(q.upper[a])),
    }
}

impl Depth {
    /// Of what was not measured.
    pub const UNKNOWN: Depth = Depth {
        depth: f64::NAN,
        kind: PenetrationKind::Estimate,
        translation: [f64::NAN; 3],
        points: [[f64::NAN; 3]; 2],
        triangles: 0,
        bounds: Aabb { lower: [f64::NAN; 3], upper: [f64::NAN; 3] },
        gap: 0.0,
    };

    /// The same seen from the other side: what moves the one moves the other back.
    pub fn turned(self) -> Depth {
        let [p, q] = self.points;
        Depth { translation: scaled(&self.translation, -1.0), points: [q, p], ..self }
    }

    /// Whether the translation is as long as the contact is deep.
    pub fn length(&self) -> f64 {
        length(&self.translation)
    }
}
