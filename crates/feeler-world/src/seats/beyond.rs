//! What of a neighbour's surface lies beyond the place of a sunk part: the part may not meet it there, and is cast against it.
//!
//! A sunk part may cross its neighbour's surface only within its place (the volume that it filled) and close to it. Samples of a motion would
//! miss a thin fin of the part that passes a thin sheet of the neighbour between two samples. So the surface is cut into pieces: those near
//! the place are sampled, and the part is cast exactly against all others.

use std::sync::Arc;

use feeler_core::geometry::vectors::{length, sub};
use feeler_core::{weld_vertices, GoOn, Mockup, Point, Scene, SceneOptions, Tool, Triangle};

use super::place::{is_in, room_around, AtStart};
use crate::constants::{BEYOND_GRAIN, MOST_BEYOND_PIECES};
use crate::error::Result;
use crate::surfaces::Groups;

/// What a sunk part may not meet.
#[derive(Debug)]
pub struct Beyond {
    /// The part of the tool alone, smaller by a play.
    pub tool: Arc<Tool>,
    /// The neighbour's surface beyond the place, by the parts of its body.
    pub scene: Arc<Scene>,
}

/// The surface of the place of a part of the tool, as a tool.
pub fn surface_of_place(place: AtStart<'_>, part: u32) -> Result<Tool> {
    let corners: Vec<Point> = place.filled.surface(place.tool, part).flatten().collect();
    let (vertices, faces) = welded(&corners);
    Ok(Tool::new(vertices, faces)?)
}

/// The pieces of some triangles of a neighbour (a part of a mock-up of `parts`) that lie beyond the place of a part of the tool, whose
/// surface is given. `None` where there are none.
pub fn beyond(
    place: AtStart<'_>,
    (part, surface): (u32, &Tool),
    triangles: Vec<Triangle>,
    (neighbour, parts): (u32, usize),
    go_on: GoOn<'_>,
) -> Result<Option<Scene>> {
    let room = room_around(place.tool, part);
    let (mut pieces, mut far, mut tried) = (triangles, Vec::new(), 0);
    while !pieces.is_empty() {
        tried += pieces.len();
        let alone = (0..pieces.len() as u32).collect();
        let scene = scene_of(&pieces, alone, pieces.len())?;
        let mut is_far = vec![true; pieces.len()];
        let mut cut = Vec::new();
        for gap in scene.stoppable(go_on).clearance(surface, place.start, room)? {
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
    let outside = outside(place, part, &far);
    if outside.is_empty() {
        return Ok(None);
    }
    let of_one = vec![neighbour; outside.len()];
    scene_of(&outside, of_one, parts).map(Some)
}

fn scene_of(pieces: &[Triangle], part_of_face: Vec<u32>, parts: usize) -> Result<Scene> {
    let (vertices, faces) = welded(pieces.as_flattened());
    let mockup = Mockup::new(vertices, faces, part_of_face, parts)?;
    Ok(Scene::build(Arc::new(mockup), &SceneOptions::default())?)
}

fn welded(corners: &[Point]) -> (Vec<Point>, Vec<[u32; 3]>) {
    let (vertices, numbers) = weld_vertices(corners);
    (vertices, numbers.chunks(3).map(|face| [face[0], face[1], face[2]]).collect())
}

/// Those of some pieces that are not within the place; none is near its surface, so what hangs together is on one side of it.
fn outside(place: AtStart<'_>, part: u32, pieces: &[Triangle]) -> Vec<Triangle> {
    let (vertices, faces) = welded(pieces.as_flattened());
    let mut groups = Groups::new(vertices.len());
    for [a, b, c] in &faces {
        groups.join([*a as usize, *b as usize]);
        groups.join([*a as usize, *c as usize]);
    }
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
