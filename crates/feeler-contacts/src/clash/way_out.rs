//! The way out of a part: a translation of the smaller one of two parts, taken as a tool at its place, out of the
//! other.
//!
//! It is the shortest over all contact planes, if that frees the tool; else one beyond the other part along an axis or
//! a face normal, which always does. Both are upper bounds of the least translation.

use feeler_core::clash::location::{locate, Location, LocationScratch};
use feeler_core::clash::solids::Solids;
use feeler_core::geometry::vectors::{add, along, dot, length, normal, scaled, sub};
use feeler_core::{closest_triangle_triangle, Aabb, GoOn, Point, Pose, Result, Scene, Tool, Triangle};

use crate::constants::{
    ESCAPE_EXCESS, ESCAPE_ROUNDING, FACES_SAMPLED, LEAST_ESCAPE_LEAN, MOST_FACE_NORMALS, SAME_FACE_NORMAL,
};
use crate::contact_plane::{ContactPlane, Contacts};
use crate::escape::min_norm::{min_norm, relaxed};
use crate::point_depth::body::Body;
use crate::query::{ContactQuery, ContactScratch};
use feeler_core::scratch_pool::ScratchPool;

/// The way out of a tool and a part by their contact planes.
#[derive(Debug, Clone)]
pub struct WayOut {
    /// Moves the tool out of the part.
    pub translation: Point,
    /// On the surface of the tool, and of the part: where that plane is, else where they touch or are closest.
    pub points: [Point; 2],
    /// Colliding pairs of triangles.
    pub triangles: usize,
    /// The box around where they do; where they do not, around `points`.
    pub bounds: Aabb,
    /// The distance of surfaces that do not collide.
    pub gap: f64,
}

impl WayOut {
    /// The same seen from the other side: the opposite translation moves the other part.
    pub fn turned(self) -> WayOut {
        let [p, q] = self.points;
        WayOut { translation: scaled(&self.translation, -1.0), points: [q, p], ..self }
    }
}

/// The place of a collision of two parts.
#[derive(Debug, Clone)]
pub struct Met {
    /// How many pairs of triangles do.
    pub triangles: usize,
    /// The box around where they do.
    pub bounds: Aabb,
    /// On the tool, and on the part, of the first of them; where there is none, the closest points.
    pub points: Option<[Point; 2]>,
    /// The distance of surfaces that do not collide, metres.
    pub gap: f64,
}

impl Default for Met {
    fn default() -> Met {
        Met { triangles: 0, bounds: Aabb::EMPTY, points: None, gap: 0.0 }
    }
}

/// A part as a tool, where it is, and another.
pub struct Pair<'a> {
    /// The scene with all parts.
    pub scene: &'a Scene,
    /// The same with the other part alone.
    pub other_alone: &'a Scene,
    pub solids: &'a Solids<'a>,
    pub tool: &'a Tool,
    /// Of the tool, and the other.
    pub parts: [u32; 2],
    pub bodies: [&'a Body; 2],
}

impl Pair<'_> {
    /// The way out of two colliding parts, or of one inside the other (`is_within`).
    pub fn way_out(
        &self,
        is_within: bool,
        pool: &ScratchPool<ContactScratch>,
        scratch: &mut LocationScratch,
    ) -> Result<WayOut> {
        let query = ContactQuery { scene: self.other_alone, pool, go_on: GoOn::default() };
        let mut met = Met::default();
        let mut show = |pairs: &[[u32; 2]]| met = self.met(pairs.iter().copied());
        let contacts = query.contacts_showing(|_| None, self.tool, &Pose::IDENTITY, 0.0, None, &mut show)?;
        // What lies in the other is not out of it where a plane says so.
        let over_planes = if is_within { None } else { self.over_planes(&contacts, scratch)? };
        let translation = match over_planes {
            Some(way) => shorter(way, self.beyond(self.is_far(&way), &contacts)),
            None => self.beyond(true, &contacts),
        };
        let deepest = contacts.planes.first().filter(|plane| plane.gap < 0.0);
        let (points, gap, mut bounds) = (deepest.map(|plane| self.points_of(plane)).or(met.points), 0.0, met.bounds);
        let (points, gap) = match points {
            Some(points) => (points, gap),
            None => {
                let closest = self.other_alone.distance(self.tool, &Pose::IDENTITY, f64::INFINITY)?;
                let points = closest.map_or([[0.0; 3]; 2], |gap| [gap.on_tool, gap.on_mockup]);
                points.iter().for_each(|p| bounds.grow(p));
                (points, closest.map_or(0.0, |gap| gap.distance))
            }
        };
        Ok(WayOut { translation, points, triangles: met.triangles, bounds, gap })
    }

    /// The points of both surfaces that are closest to where the tool is deepest, and to where the plane runs. The tool's surface may be
    /// beside the former: it is only as deep as that somewhere behind the plane.
    fn points_of(&self, plane: &ContactPlane) -> [Point; 2] {
        let [tool, part] = self.bodies;
        [on_surface(tool, &along(&plane.point, plane.gap, &plane.normal)), on_surface(part, &plane.point)]
    }

    /// The place of the collision, or where they are closest.
    pub fn meeting(&self) -> Result<Met> {
        let mut met = self.met(self.other_alone.collide(self.tool, &Pose::IDENTITY).pairs.into_iter());
        if met.triangles == 0 {
            if let Some(gap) = self.other_alone.distance(self.tool, &Pose::IDENTITY, f64::INFINITY)? {
                let points = [gap.on_tool, gap.on_mockup];
                points.iter().for_each(|p| met.bounds.grow(p));
                (met.points, met.gap) = (Some(points), gap.distance);
            }
        }
        Ok(met)
    }

    fn met(&self, pairs: impl Iterator<Item = [u32; 2]>) -> Met {
        let mesh = self.scene.mockup().mesh();
        let mut met = Met::default();
        for [t, m] in pairs {
            let both = [self.tool.mesh().triangle(t), mesh.triangle(m)];
            met.triangles += 1;
            met.bounds = met.bounds.union(&shared_box(&both));
            met.points.get_or_insert_with(|| touching_points(&both));
        }
        met
    }

    /// The shortest translation over the planes, where it frees the tool.
    fn over_planes(&self, contacts: &Contacts, scratch: &mut LocationScratch) -> Result<Option<Point>> {
        let counting: Vec<&ContactPlane> = contacts.planes.iter().filter(|plane| !plane.assumed).collect();
        if counting.is_empty() {
            return Ok(None);
        }
        let planes: Vec<(Point, f64)> = counting.iter().map(|plane| (plane.normal, -plane.gap)).collect();
        let (escape, active) = min_norm(&planes).unwrap_or_else(|| (relaxed(&planes), Vec::new()));
        let size = length(&escape);
        let outward = if size > 0.0 { scaled(&escape, 1.0 / size) } else { planes[0].0 };
        // Off the planes, and by as much the more as they are left at a grazing angle.
        let lean = active.iter().map(|i| dot(&outward, &planes[*i].0)).fold(1.0, f64::min).max(LEAST_ESCAPE_LEAN);
        let translation = add(&escape, &scaled(&outward, self.excess(size) / lean));
        if !self.is_freed(&translation, scratch)? {
            return Ok(None);
        }
        Ok(Some(translation))
    }

    /// By how much a translation is longer than it need be.
    fn excess(&self, length: f64) -> f64 {
        ESCAPE_EXCESS * length
            + ESCAPE_ROUNDING * self.scene.mockup().mesh().bounds().largest_coordinate()
            + self.tool.margin_at(&Pose::IDENTITY)
    }

    fn is_meeting(&self, translation: &Point) -> Result<bool> {
        Ok(self.other_alone.is_colliding(self.tool, &Pose::IDENTITY.translated(translation)?))
    }

    /// Whether the moved tool meets nothing, and neither is inside the other.
    fn is_freed(&self, translation: &Point, scratch: &mut LocationScratch) -> Result<bool> {
        if self.is_meeting(translation)? {
            return Ok(false);
        }
        for (i, by) in [(0, 1.0), (1, -1.0)] {
            for corner in self.solids.of(self.parts[i]).corners_of_surfaces() {
                let moved = along(&corner, by, translation);
                let at = locate((self.scene.index(), self.solids), &moved, &[self.parts[1 - i]], scratch);
                if at[0] == Location::Inside {
                    return Ok(false);
                }
            }
        }
        Ok(true)
    }

    /// Whether a translation is so long that there may well be a shorter one aside of all planes.
    fn is_far(&self, way: &Point) -> bool {
        let least = self.tool.mesh().bounds().extent().into_iter().fold(f64::INFINITY, f64::min);
        length(way) > 0.5 * least
    }

    /// The shortest translation along some normals after which a plane across it has all of the tool on one side and all of the other
    /// part on the other: along the axes, or with `all` also along the normals of contacts and of the faces of both.
    fn beyond(&self, all: bool, contacts: &Contacts) -> Point {
        let other = self.scene.mockup().part_bounds()[self.parts[1] as usize];
        let own = self.tool.mesh().bounds();
        let mut least = (f64::INFINITY, [0.0, 0.0, 1.0]);
        for a in 0..3 {
            for (length, sign) in [(other.upper[a] - own.lower[a], 1.0), (own.upper[a] - other.lower[a], -1.0)] {
                if length < least.0 {
                    least = (length, std::array::from_fn(|b| if a == b { sign } else { 0.0 }));
                }
            }
        }
        if all {
            let mesh = self.scene.mockup().mesh();
            let faces = self.solids.faces(self.parts[1]);
            let own = self.tool.mesh();
            let of_tool = (0..own.faces().len() as u32).step_by(1 + own.faces().len() / FACES_SAMPLED);
            let mut normals: Vec<Point> = contacts.planes.iter().map(|plane| plane.normal).collect();
            add_face_normals(
                faces.iter().step_by(1 + faces.len() / FACES_SAMPLED).map(|f| mesh.triangle(*f)),
                &mut normals,
            );
            add_face_normals(of_tool.map(|t| own.triangle(t)), &mut normals);
            let samples = self.bodies.map(Body::sample);
            for n in normals {
                // Mostly some points of both show that neither way would be shorter than the best.
                let [[lowest, highest], [low, high]] = [heights(&samples[0], &n), heights(&samples[1], &n)];
                if high - lowest >= least.0 && highest - low >= least.0 {
                    continue;
                }
                let [[lowest, highest], [low, high]] = self.bodies.map(|body| body.heights(&n));
                for (length, sign) in [(high - lowest, 1.0), (highest - low, -1.0)] {
                    if length < least.0 {
                        least = (length, scaled(&n, sign));
                    }
                }
            }
        }
        let (length, normal) = least;
        scaled(&normal, length + self.excess(length))
    }
}

/// Adds the normals of some faces, those in nearly one direction once, up to a number.
fn add_face_normals(triangles: impl Iterator<Item = Triangle>, normals: &mut Vec<Point>) {
    let most = normals.len() + MOST_FACE_NORMALS;
    for n in triangles.filter_map(|triangle| normal(&triangle)) {
        if normals.len() == most {
            return;
        }
        if !normals.iter().any(|other| dot(other, &n).abs() > SAME_FACE_NORMAL) {
            normals.push(n);
        }
    }
}

/// The lowest and the highest point along a normal.
fn heights(points: &[Point], n: &Point) -> [f64; 2] {
    points
        .iter()
        .map(|p| dot(n, p))
        .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], h| [low.min(h), high.max(h)])
}

fn shorter(one: Point, other: Point) -> Point {
    if length(&other) < length(&one) {
        other
    } else {
        one
    }
}

/// The point of a surface that is closest to a point.
fn on_surface(body: &Body, p: &Point) -> Point {
    body.closest(&sub(p, body.origin()), f64::INFINITY).map_or(*p, |closest| add(&closest.point, body.origin()))
}

/// The closest points of two colliding triangles.
pub fn touching_points([p, q]: &[Triangle; 2]) -> [Point; 2] {
    let closest = closest_triangle_triangle(p, q);
    [closest.on_p, closest.on_q]
}

/// Where the boxes of two triangles overlap.
pub fn shared_box([p, q]: &[Triangle; 2]) -> Aabb {
    let (p, q) = (Aabb::of_triangle(p), Aabb::of_triangle(q));
    Aabb {
        lower: std::array::from_fn(|a| p.lower[a].max(q.lower[a])),
        upper: std::array::from_fn(|a| p.upper[a].min(q.upper[a])),
    }
}
