//! What of a neighbour's surface lies beyond the place of a sunk part: the part may not meet it there, and is cast against it.
//!
//! A sunk part may cross its neighbour's surface only within its place (the volume that it filled) and close to it. Samples of a motion would
//! miss a thin fin of the part that passes a thin sheet of the neighbour between two samples. So the surface is cut into pieces: those near
//! where the part is sunk are sampled, and the part is cast exactly against all others. What of the part is not sunk, such as a head over
//! the plate that its shank is in, is cast from the gap on that is there.

use std::collections::BTreeMap;
use std::sync::Arc;

use feeler_core::geometry::vectors::{along, cross, dot, length, scaled, sub, unit};
use feeler_core::{weld_vertices, GoOn, Mockup, Point, Pose, Scene, SceneOptions, Tool, Triangle};

use super::place::{is_in, room_around, AtStart};
use crate::constants::{BEYOND_GRAIN, MOST_BEYOND_PIECES, MOST_CUTS, SAME_PLANE};
use crate::error::Result;
use crate::solid::around_point;
use crate::surfaces::Groups;

/// What a sunk part may not meet.
#[derive(Debug)]
pub struct Beyond {
    /// The part of the tool alone, smaller by a play.
    pub tool: Arc<Tool>,
    /// The neighbour's surface beyond the place, by the parts of its body.
    pub scene: Arc<Scene>,
}

/// The surface of the place of a part of the tool where that is sunk in a neighbour (a scene of it alone), as a tool in the world. What only
/// lies on the neighbour, such as the underside of a head, is none of it: the part smaller by the play is asked. `None` where nothing is.
pub fn surface_in(
    place: AtStart<'_>,
    (part, smaller): (u32, &Tool),
    neighbour: &Scene,
    go_on: GoOn<'_>,
) -> Result<Option<Tool>> {
    let fine = BEYOND_GRAIN * room_around(place.tool, part);
    let mesh = smaller.mesh();
    let mut pieces: Vec<Triangle> = mesh.queried().map(|t| place.start.apply_triangle(&mesh.triangle(t))).collect();
    let (mut sunk, mut off, mut tried) = (Vec::new(), Vec::new(), 0);
    while !pieces.is_empty() {
        if !(go_on.function())() {
            return Err(feeler_core::Error::Cancelled.into());
        }
        tried += pieces.len();
        let mut crossed = vec![Vec::new(); pieces.len()];
        for [t, m] in neighbour.collide(&tool_of(&pieces)?, &Pose::IDENTITY).pairs {
            crossed[t as usize].push(m);
        }
        let mut cut = Vec::new();
        for (piece, crossed) in pieces.iter().zip(&crossed) {
            let long = longest(piece);
            if crossed.is_empty() {
                off.push(*piece);
                continue;
            }
            let planes = planes_of(neighbour.mockup(), crossed);
            let polygons = planes.map(|planes| planes.iter().fold(vec![piece.to_vec()], split));
            let before = sunk.len();
            for polygon in polygons.into_iter().flatten() {
                let triangles: Vec<Triangle> =
                    (2..polygon.len()).map(|k| [polygon[0], polygon[k - 1], polygon[k]]).collect();
                sunk.extend(is_solid_around(&triangles, neighbour)?.then_some(triangles).into_iter().flatten());
            }
            // Where it crosses many faces, or what bounds no solid.
            if sunk.len() == before {
                if long > fine && tried <= MOST_BEYOND_PIECES {
                    halve(piece, 0.5 * long, &mut cut);
                } else {
                    sunk.push(*piece);
                }
            }
        }
        pieces = cut;
    }
    sunk.extend(inside(&off, neighbour)?);
    sunk.extend(place.filled.caps_of(place.tool, part).map(|cap| place.start.apply_triangle(&cap)));
    if sunk.is_empty() {
        return Ok(None);
    }
    tool_of(&sunk).map(Some)
}

/// A point and a unit normal.
type Plane = (Point, Point);

/// The planes that some triangles are in, each once; `None` where there are more than [`MOST_CUTS`], or one bounds no solid.
fn planes_of(mockup: &Mockup, triangles: &[u32]) -> Option<Vec<Plane>> {
    let mut planes: Vec<Plane> = Vec::new();
    for t in triangles {
        let [a, b, c] = mockup.mesh().triangle(*t);
        let Some(normal) = unit(&cross(&sub(&b, &a), &sub(&c, &a))) else { continue };
        let is_in = |(at, of): &Plane| [a, b, c].iter().all(|p| dot(&sub(p, at), of).abs() <= SAME_PLANE);
        if mockup.adjacency().outward[*t as usize] == 0 || planes.len() > MOST_CUTS {
            return None;
        }
        if !planes.iter().any(is_in) {
            planes.push((a, normal));
        }
    }
    (planes.len() <= MOST_CUTS).then_some(planes)
}

/// Polygons cut at a plane.
fn split(polygons: Vec<Vec<Point>>, (at, normal): &Plane) -> Vec<Vec<Point>> {
    let mut found = Vec::new();
    for polygon in polygons {
        let heights: Vec<f64> = polygon.iter().map(|p| dot(&sub(p, at), normal)).collect();
        if heights.iter().all(|h| *h <= SAME_PLANE) || heights.iter().all(|h| *h >= -SAME_PLANE) {
            found.push(polygon);
            continue;
        }
        for side in [1.0, -1.0] {
            let mut half = Vec::with_capacity(polygon.len() + 1);
            for (i, p) in polygon.iter().enumerate() {
                let next = (i + 1) % polygon.len();
                if side * heights[i] >= 0.0 {
                    half.push(*p);
                }
                if heights[i] * heights[next] < 0.0 {
                    let share = heights[i] / (heights[i] - heights[next]);
                    half.push(along(p, share, &sub(&polygon[next], p)));
                }
            }
            found.push(half);
        }
    }
    found
}

/// Whether the largest of some triangles has its middle in the solid of a neighbour.
fn is_solid_around(triangles: &[Triangle], neighbour: &Scene) -> Result<bool> {
    let normals = triangles
        .iter()
        .map(|corners| (corners, cross(&sub(&corners[1], &corners[0]), &sub(&corners[2], &corners[0]))));
    let largest = normals.max_by(|a, b| length(&a.1).total_cmp(&length(&b.1)));
    let Some(([a, b, c], normal)) = largest.filter(|(_, normal)| length(normal) > 0.0) else { return Ok(false) };
    let middle = std::array::from_fn(|k| (a[k] + b[k] + c[k]) / 3.0);
    // Solids of a neighbour that are in each other hide one another from one side.
    let ways = [normal, scaled(&normal, -1.0)];
    Ok(ways
        .iter()
        .map(|way| around_point(neighbour, &middle, way))
        .collect::<Result<Vec<_>>>()?
        .iter()
        .any(Option::is_some))
}

/// Those of some pieces, none of which crosses the surface of a neighbour, that are in its solid: what hangs together is on one side of it.
fn inside(pieces: &[Triangle], neighbour: &Scene) -> Result<Vec<Triangle>> {
    let (_, faces, mut groups) = hanging_together(pieces);
    let mut of_group: BTreeMap<usize, Vec<Triangle>> = BTreeMap::new();
    for (piece, face) in pieces.iter().zip(&faces) {
        of_group.entry(groups.of(face[0] as usize)).or_default().push(*piece);
    }
    let mut found = Vec::new();
    for group in of_group.into_values() {
        found.extend(is_solid_around(&group, neighbour)?.then_some(group).into_iter().flatten());
    }
    Ok(found)
}

/// The pieces of some triangles of a neighbour that lie beyond the place of a part of the tool: outside, and not near where it is sunk, whose
/// surface is given ([`surface_in`]).
pub fn beyond(
    place: AtStart<'_>,
    (part, surface): (u32, Option<&Tool>),
    triangles: Vec<Triangle>,
    go_on: GoOn<'_>,
) -> Result<Vec<Triangle>> {
    let room = room_around(place.tool, part);
    let (mut pieces, mut far, mut tried) = (triangles, Vec::new(), 0);
    while !pieces.is_empty() {
        tried += pieces.len();
        let alone = (0..pieces.len() as u32).collect();
        let scene = scene_of(&pieces, alone, pieces.len())?;
        let mut is_far = vec![true; pieces.len()];
        let mut cut = Vec::new();
        let near = |surface| scene.stoppable(go_on).clearance(surface, &Pose::IDENTITY, room);
        for gap in surface.map_or_else(|| Ok(Vec::new()), near)? {
            let piece = &pieces[gap.mockup_triangle as usize];
            is_far[gap.mockup_triangle as usize] = false;
            let long = longest(piece);
            if gap.distance + long > room && long > BEYOND_GRAIN * room && tried <= MOST_BEYOND_PIECES {
                halve(piece, 0.5 * long, &mut cut);
            }
        }
        far.extend(pieces.iter().zip(&is_far).filter(|(_, is_far)| **is_far).map(|(piece, _)| *piece));
        pieces = cut;
    }
    Ok(outside(place, part, &far))
}

/// Some triangles as a scene, with the part of each.
pub fn scene_of(pieces: &[Triangle], part_of_face: Vec<u32>, parts: usize) -> Result<Scene> {
    let (vertices, faces) = welded(pieces.as_flattened());
    let mockup = Mockup::new(vertices, faces, part_of_face, parts)?;
    Ok(Scene::build(Arc::new(mockup), &SceneOptions::default())?)
}

/// Some triangles as a tool.
pub fn tool_of(pieces: &[Triangle]) -> Result<Tool> {
    let (vertices, faces) = welded(pieces.as_flattened());
    Ok(Tool::new(vertices, faces)?)
}

fn welded(corners: &[Point]) -> (Vec<Point>, Vec<[u32; 3]>) {
    let (vertices, numbers) = weld_vertices(corners);
    (vertices, numbers.chunks(3).map(|face| [face[0], face[1], face[2]]).collect())
}

/// The corners and faces of some pieces, and the groups of corners that hang together.
fn hanging_together(pieces: &[Triangle]) -> (Vec<Point>, Vec<[u32; 3]>, Groups) {
    let (vertices, faces) = welded(pieces.as_flattened());
    let mut groups = Groups::new(vertices.len());
    for [a, b, c] in &faces {
        groups.join([*a as usize, *b as usize]);
        groups.join([*a as usize, *c as usize]);
    }
    (vertices, faces, groups)
}

/// Those of some pieces that are not within the place; none is near its surface, so what hangs together is on one side of it.
fn outside(place: AtStart<'_>, part: u32, pieces: &[Triangle]) -> Vec<Triangle> {
    let (vertices, faces, mut groups) = hanging_together(pieces);
    let mut is_within = vec![None; vertices.len()];
    let mut is_outside = |face: &[u32; 3]| {
        let group = groups.of(face[0] as usize);
        !*is_within[group].get_or_insert_with(|| is_in(place, part, &vertices[group], 0.0))
    };
    pieces.iter().zip(&faces).filter(|(_, face)| is_outside(face)).map(|(piece, _)| *piece).collect()
}

fn longest(piece: &Triangle) -> f64 {
    (0..3).map(|k| length(&sub(&piece[(k + 1) % 3], &piece[k]))).fold(0.0, f64::max)
}

/// Cuts a triangle at the middles of longest edges until none is longer than `most`. Triangles on both sides of an edge cut it at the same point.
fn halve(piece: &Triangle, most: f64, out: &mut Vec<Triangle>) {
    let long = |k: usize| length(&sub(&piece[(k + 1) % 3], &piece[k]));
    let k = (0..3).max_by(|i, j| long(*i).total_cmp(&long(*j))).unwrap_or(0);
    if long(k) <= most {
        out.push(*piece);
        return;
    }
    let [a, b, c] = [piece[k], piece[(k + 1) % 3], piece[(k + 2) % 3]];
    let middle: Point = std::array::from_fn(|axis| 0.5 * (a[axis] + b[axis]));
    halve(&[a, middle, c], most, out);
    halve(&[middle, b, c], most, out);
}
