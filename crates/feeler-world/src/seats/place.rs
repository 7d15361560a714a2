//! The volume of the tool at the start, treated as a hole in its neighbours.
//!
//! In many models bolts have no holes: bolt and plate overlap. The bolt may leave, but where it goes through the
//! plate's surface it must be within its initial volume, as in a hole. So each point of the crossing of the two
//! surfaces lies in the tool as it was at the start, or near it: the ridges of a thread leave through the place of its
//! grooves. The same holds for each sample of the tool's surface while it is inside the neighbour: where faces are
//! flush, surfaces need not cross.

use std::sync::Arc;

use feeler_core::geometry::twist::{times, transposed};
use feeler_core::geometry::vectors::{add, cross, dot, length, scaled, sub, unit};
use feeler_core::{closest_triangle_triangle, Aabb, Mockup, Point, Pose, Scene, Tool, Triangle};

use super::pockets::Filled;
use crate::constants::{LEAST_CROSSINGS, MOST_CROSSING_WORK, MOST_PLACE_ROWS, PLACE_SHARE, SEAT_TOLERANCE};

/// A sample of the tool's surface inside of a neighbour.
#[derive(Debug, Clone, Copy)]
pub struct Inside {
    /// World.
    pub at: Point,
    /// Of the tool and of the neighbour.
    pub triangles: [u32; 2],
}

/// The tool as it was at the start.
#[derive(Debug, Clone, Copy)]
pub struct AtStart<'a> {
    /// World from tool.
    pub start: &'a Pose,
    /// The tool there.
    pub tool: &'a Tool,
    /// Its pockets that are a part of its place.
    pub filled: &'a Filled,
    /// Where the tool has the place, and a neighbour moves through it.
    pub around: &'a [Around],
}

impl AtStart<'_> {
    /// How a pair of triangles of the tool and a mock-up belongs to a part that is around a neighbour.
    fn around(&self, mockup: &Mockup, [t, m]: [u32; 2]) -> Option<&Around> {
        let pair = || [self.tool.part_of_face(t), mockup.part_of_face(m)];
        (!self.around.is_empty()).then(pair).and_then(|pair| self.around.iter().find(|around| around.pair == pair))
    }

    /// The surface of the place of a part of the tool, world.
    fn surface(&self, part: u32) -> impl Iterator<Item = Triangle> + '_ {
        self.filled.surface(self.tool, part).map(|corners| self.start.apply_triangle(&corners))
    }
}

/// A part of the tool that is around a neighbour, such as a plate that is drawn through by a solid bolt. It has no hole in the model, and the
/// place that the neighbour fills in it is the hole. So all that holds for a sunk part holds for the neighbour, as it moves relative to the
/// part: a plate comes off along its bolt, and not sideways.
#[derive(Debug)]
pub struct Around {
    /// `[tool part, part]`.
    pub pair: [u32; 2],
    /// The neighbour alone, world.
    pub neighbour: Tool,
    /// The same, smaller by a play.
    pub smaller: Arc<Tool>,
    /// The diagonal of its box, metres.
    pub size: f64,
    /// The part of the tool alone at the start, world.
    pub host: Scene,
    /// Pockets of the neighbour count as they are.
    pub none: Filled,
}

impl Around {
    /// The place of the neighbour.
    pub fn place(&self) -> AtStart<'_> {
        AtStart { start: &Pose::IDENTITY, tool: &self.neighbour, filled: &self.none, around: &[] }
    }

    /// Where in the neighbour's place a point is that moved with the part.
    fn back(&self, at: &Point, start: &Pose, pose: &Pose) -> Point {
        start.apply(&times(&transposed(pose.rotation()), &sub(at, pose.translation())))
    }

    /// Whether such a point is outside of the neighbour's place.
    fn is_out(&self, back: &Point) -> bool {
        !is_in(self.place(), 0, back, room_around(&self.neighbour, 0))
    }
}

/// The part of the mock-up at a crossing, or around a sample, that is outside of the tool's place, world, as it was at the start.
pub fn crossing_outside(
    place: AtStart<'_>,
    mockup: &Mockup,
    (pairs, inside): (&[[u32; 2]], &[Inside]),
    pose: &Pose,
) -> Option<u32> {
    let tool = place.tool;
    let mesh = tool.mesh();
    let triangles = mesh.faces().len();
    // As many crossings as fit the work, spread over all.
    let most = (MOST_CROSSING_WORK / triangles.max(1)).max(LEAST_CROSSINGS);
    let stride = pairs.len().div_ceil(most).max(1);
    let is_out = |sample: &&Inside| {
        let own = tool.part_of_face(sample.triangles[0]);
        place.around(mockup, sample.triangles).is_none() && !is_in(place, own, &sample.at, room_around(tool, own))
    };
    if let Some(sample) = inside.iter().find(is_out) {
        return Some(mockup.part_of_face(sample.triangles[1]));
    }
    let mut pairs = pairs.iter().step_by(stride);
    let outside = |[t, m]: &&[u32; 2]| {
        let p = pose.apply_triangle(&mesh.triangle(*t));
        let crossings = crossings(&p, &mockup.mesh().triangle(*m));
        if let Some(around) = place.around(mockup, [*t, *m]) {
            return crossings.iter().any(|x| around.is_out(&around.back(x, place.start, pose)));
        }
        let own = tool.part_of_face(*t);
        let near = room_around(tool, own);
        crossings.iter().any(|x| !is_in(place, own, x, near))
    };
    pairs.find(outside).map(|[_, m]| mockup.part_of_face(*m))
}

/// How far a part of the tool may come outside of its place, metres.
pub fn room_around(tool: &Tool, part: u32) -> f64 {
    SEAT_TOLERANCE.max(PLACE_SHARE * size_of(tool, part))
}

/// A crossing of the tool's surface and that of a part.
#[derive(Debug, Clone, Copy)]
pub struct Crossing {
    /// World.
    pub at: Point,
    /// Of the tool's surface there, outwards, unit.
    pub outward: Point,
    /// How far the surface may move outwards until it is outside of the place, metres.
    pub room: f64,
    /// The pair of triangles.
    pub triangles: [u32; 2],
}

/// Some crossings, spread over all.
pub fn crossings_in_place(
    place: AtStart<'_>,
    mockup: &Mockup,
    (pairs, inside): (&[[u32; 2]], &[Inside]),
    pose: &Pose,
) -> Vec<Crossing> {
    let tool = place.tool;
    let mesh = tool.mesh();
    let most = (MOST_CROSSING_WORK / mesh.faces().len().max(1)).clamp(LEAST_CROSSINGS, MOST_PLACE_ROWS);
    let mut found = Vec::new();
    let crossing = |[t, m]: &[u32; 2]| {
        let p = pose.apply_triangle(&mesh.triangle(*t));
        Some(Inside { at: *crossings(&p, &mockup.mesh().triangle(*m)).first()?, triangles: [*t, *m] })
    };
    let crossed = pairs.iter().step_by(pairs.len().div_ceil(most).max(1)).filter_map(crossing);
    let samples = inside.iter().map(|sample| (*sample, true));
    for (Inside { at, triangles }, is_sample) in crossed.map(|crossing| (crossing, false)).chain(samples) {
        let [t, m] = triangles;
        let around = place.around(mockup, triangles);
        if is_sample && around.is_some() {
            continue;
        }
        let (p, side) = match around {
            None => (pose.apply_triangle(&mesh.triangle(t)), tool.adjacency().outward[t as usize]),
            // The neighbour moves outwards where the part moves inwards.
            Some(_) => (mockup.mesh().triangle(m), if mockup.adjacency().outward[m as usize] < 0 { 1 } else { -1 }),
        };
        let Some(normal) = unit(&cross(&sub(&p[1], &p[0]), &sub(&p[2], &p[0]))) else { continue };
        let outward = if side < 0 { scaled(&normal, -1.0) } else { normal };
        let (host, own, within) = match around {
            None => (place, tool.part_of_face(t), at),
            Some(around) => (around.place(), 0, around.back(&at, place.start, pose)),
        };
        let (distance, nearest) = nearest_to(host, own, &within);
        let is_out = !is_in(host, own, &within, 0.0);
        let depth = if is_out { -distance } else { distance };
        // A corner outside of the place leaves it away from the place, whatever way its faces look.
        let away = unit(&sub(&at, &nearest)).filter(|_| is_sample && is_out && distance > SEAT_TOLERANCE);
        let outward = away.unwrap_or(outward);
        found.push(Crossing { at, outward, room: room_around(host.tool, own) + depth, triangles });
    }
    found
}

/// From a point of the world to the surface of the place of a part of the tool, metres, and the nearest point there.
fn nearest_to(place: AtStart<'_>, part: u32, at: &Point) -> (f64, Point) {
    let closest = |corners: Triangle| closest_triangle_triangle(&[*at; 3], &corners);
    place
        .surface(part)
        .map(closest)
        .min_by(|a, b| a.distance.total_cmp(&b.distance))
        .map_or((f64::INFINITY, *at), |closest| (closest.distance, closest.on_q))
}

/// Where edges of one triangle go through the other.
fn crossings(p: &Triangle, q: &Triangle) -> Vec<Point> {
    let mut found = Vec::new();
    for (edges, face) in [(p, q), (q, p)] {
        let normal = cross(&sub(&face[1], &face[0]), &sub(&face[2], &face[0]));
        for i in 0..3 {
            let (a, b) = (&edges[i], &edges[(i + 1) % 3]);
            let (above, below) = (dot(&normal, &sub(a, &face[0])), dot(&normal, &sub(b, &face[0])));
            if above * below >= 0.0 {
                continue;
            }
            let at = add(a, &scaled(&sub(b, a), above / (above - below)));
            let is_inside = (0..3).all(|k| {
                let side = cross(&sub(&face[(k + 1) % 3], &face[k]), &sub(&at, &face[k]));
                dot(&side, &normal) >= 0.0
            });
            if is_inside {
                found.push(at);
            }
        }
    }
    found
}

/// The diagonal of the box of a part of the tool, metres.
fn size_of(tool: &Tool, part: u32) -> f64 {
    let mesh = tool.mesh();
    let own = mesh.queried().filter(|t| tool.part_of_face(*t) == part);
    let corners = own.flat_map(|t| mesh.triangle(t));
    let mut bounds = Aabb::EMPTY;
    corners.for_each(|corner| bounds.grow(&corner));
    length(&bounds.extent())
}

/// Whether a point of the world is in the place of a part of the tool, or so near: by its winding number, the sum of solid angles.
pub fn is_in(place: AtStart<'_>, part: u32, at: &Point, near: f64) -> bool {
    let mut angle = 0.0;
    for corners in place.surface(part) {
        if closest_triangle_triangle(&[*at; 3], &corners).distance <= near {
            return true;
        }
        let [a, b, c] = corners.each_ref().map(|p| sub(p, at));
        let [x, y, z] = [&a, &b, &c].map(length);
        let below = x * y * z + dot(&a, &b) * z + dot(&b, &c) * x + dot(&c, &a) * y;
        angle += 2.0 * dot(&a, &cross(&b, &c)).atan2(below);
    }
    angle.abs() > std::f64::consts::TAU
}

#[cfg(test)]
mod tests {
    use feeler_shapes::box_mesh;

    use super::*;

    #[test]
    fn a_point_is_in_a_box_or_not() {
        let (vertices, faces) = box_mesh([0.0; 3], [0.02; 3], 2);
        let tool = Tool::new(vertices, faces).unwrap();
        let there = Pose::IDENTITY.translated(&[1.0, 0.0, 0.0]).unwrap();
        let place = AtStart { start: &there, tool: &tool, filled: &Filled::default(), around: &[] };
        let is_in = |x: f64| is_in(place, 0, &[x, 0.003, -0.002], SEAT_TOLERANCE);
        assert!(is_in(1.0) && is_in(1.0099) && is_in(1.010005) && !is_in(1.0102) && !is_in(0.0));
    }

    #[test]
    fn what_leaves_its_place_by_a_little_is_in_it() {
        let (vertices, faces) = box_mesh([0.0; 3], [0.02; 3], 2);
        let tool = Tool::new(vertices.clone(), faces.clone()).unwrap();
        assert!((size_of(&tool, 0) - 0.02 * 3f64.sqrt()).abs() < 1e-12);
        // A plate across the box, through which the box goes sideways.
        let plate = vec![[-1.0, -1.0, 0.001], [1.0, -1.0, 0.001], [1.0, 1.0, 0.001], [-1.0, 1.0, 0.001]];
        let mockup = Mockup::new(plate, vec![[0, 1, 2], [0, 2, 3]], vec![], 1).unwrap();
        let pairs: Vec<[u32; 2]> = (0..faces.len() as u32).flat_map(|t| [[t, 0], [t, 1]]).collect();
        let at = |by: f64| {
            let pose = Pose::IDENTITY.translated(&[by * size_of(&tool, 0), 0.0, 0.0]).unwrap();
            let place = AtStart { start: &Pose::IDENTITY, tool: &tool, filled: &Filled::default(), around: &[] };
            crossing_outside(place, &mockup, (&pairs, &[]), &pose)
        };
        assert_eq!((at(0.0), at(0.9 * PLACE_SHARE), at(1.1 * PLACE_SHARE)), (None, None, Some(0)));
    }

    #[test]
    fn two_triangles_cross_at_two_points() {
        let p = [[0.0, 0.0, -1.0], [0.0, 0.0, 1.0], [0.0, 5.0, 0.5]];
        let q = [[-1.0, -1.0, 0.0], [2.0, -1.0, 0.0], [-0.5, 2.0, 0.0]];
        let mut found = crossings(&p, &q);
        found.sort_by(|a, b| a[1].total_cmp(&b[1]));
        assert_eq!(found.len(), 2);
        assert!(length(&found[0]) < 1e-12 && length(&sub(&found[1], &[0.0, 1.4, 0.0])) < 1e-12, "{found:?}");
    }
}
