//! Finds parts that are around a neighbour, such as a plate that is drawn through by a solid bolt; see [`Around`].

use feeler_core::geometry::vectors::{length, sub};
use feeler_core::{Point, Pose, Ray, Scene, Tool, Triangle};

use super::beyond::{scene_of, tool_of};
use super::erosion::Erosion;
use super::place::Around;
use super::pockets::Filled;
use crate::error::Result;
use crate::solid::around_point;
use crate::surfaces::Groups;

/// A direction that edges and faces rarely have.
const ASKEW: Point = [0.361_803, 0.479_426, 0.799_539];

/// How a part of the tool at a pose is around a neighbour. `smaller`: that part alone, by the play; `neighbour`: a scene of it alone. `None`
/// where the neighbour does not go through the part or into it, or the part as well goes into the neighbour.
pub fn find_around(
    pair: [u32; 2],
    (start, tool, smaller): (&Pose, &Tool, &Tool),
    neighbour: &Scene,
) -> Result<Option<Around>> {
    let at_start = |tool: &Tool, t: u32| start.apply_triangle(&tool.mesh().triangle(t));
    let own: Vec<Triangle> = smaller.mesh().queried().map(|t| at_start(smaller, t)).collect();
    let [within, outside] = ends(&tool_of(&own)?, neighbour)?;
    if outside != 1 || within > 0 {
        return Ok(None);
    }
    let own = tool.mesh().queried().filter(|t| tool.part_of_face(*t) == pair[0]);
    let host = scene_of(&own.map(|t| at_start(tool, t)).collect::<Vec<_>>(), vec![], 1)?;
    let mockup = neighbour.mockup();
    let theirs = mockup.mesh().queried().filter(|t| mockup.part_of_face(*t) == pair[1]);
    let neighbour = tool_of(&theirs.map(|t| mockup.mesh().triangle(t)).collect::<Vec<_>>())?;
    let smaller = Erosion::new(&neighbour).part_with_play(0)?;
    let [within, outside] = ends(&smaller, &host)?;
    let is_around = outside >= 2 || outside == 1 && within > 0;
    let size = length(&neighbour.mesh().bounds().extent());
    Ok(is_around.then(|| Around { pair, neighbour, smaller, size, host, none: Filled::default() }))
}

/// How many pieces of a body, told by its vertices and edges, are within the solid of another, and how many are outside.
fn ends(body: &Tool, other: &Scene) -> Result<[usize; 2]> {
    let mesh = body.mesh();
    let mut crosses = vec![false; mesh.faces().len()];
    for [t, _] in other.collide(body, &Pose::IDENTITY).pairs {
        crosses[t as usize] = true;
    }
    let mut groups = Groups::new(mesh.vertices().len());
    for t in mesh.queried() {
        let (face, corners) = (mesh.faces()[t as usize], mesh.triangle(t));
        for k in 0..3 {
            let next = (k + 1) % 3;
            let direction = sub(&corners[next], &corners[k]);
            let edge = Ray { origin: corners[k], direction };
            if !crosses[t as usize] || other.ray(&edge, length(&direction), &[])?.is_none() {
                groups.join([face[k] as usize, face[next] as usize]);
            }
        }
    }
    let mut found = [0, 0];
    for (v, at) in mesh.vertices().iter().enumerate() {
        if groups.of(v) == v {
            let is_within = around_point(other, at, &ASKEW)?.is_some();
            found[usize::from(!is_within)] += 1;
        }
    }
    Ok(found)
}
