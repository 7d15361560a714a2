//! Two parts whose triangles touch or are coplanar, and none cross: whether one enters the other, contains it, or only
//! touches it.
//!
//! First by sides, as for a tool (`collide::touching`): whether one part continues into the other's material where
//! triangles touch. The same test with the material outside shows whether it continues out of it. Points decide what
//! the sides leave open (corners that touch corners, surfaces without contact): each connected piece of a surface
//! without a collision lies on one side of the other.

use std::collections::{BTreeMap, BTreeSet};

use super::location::{is_within, locate, Location, LocationScratch, Mark};
use super::meets::Touch;
use super::solids::{Solid, Solids};
use crate::collide::hits::Hit;
use crate::collide::touching::Surfaces;
use crate::constants::NONE;
use crate::geometry::bounds::{Aabb, Point};
use crate::index::mockup_index::Index;

/// The relation of two parts that collide and do not cross.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Touching {
    /// They are outside each other.
    Beside,
    /// Each has something inside the other, and something outside.
    Entering,
    /// The first of them, which is closed, holds all of the second.
    Holding,
    /// The other way round.
    Held,
}

/// See the module; `touches` are all of the two, each once.
pub fn judge(
    (index, solids): (&Index, &Solids<'_>),
    parts: [u32; 2],
    touches: &[Touch],
    scratch: &mut LocationScratch,
) -> Touching {
    let [p, q] = parts.map(|part| solids.of(part));
    let is_entering = |is_turned: [bool; 2]| {
        let hits =
            touches.iter().map(|touch| Hit::new(p.own(touch.triangles[0]), q.own(touch.triangles[1]), touch.kind));
        let surfaces = Surfaces {
            tool: &|t| p.triangle(t),
            mockup: &|t| q.triangle(t),
            adjacency: [p.adjacency(), q.adjacency()],
            is_turned,
        };
        surfaces.entering(hits).is_some()
    };
    // Of each, whether points of it lie inside the other, and outside.
    let mut lies = [[false; 2]; 2];
    for i in 0..2 {
        let (own, other) = (if i == 0 { p } else { q }, parts[1 - i]);
        if !solids.of(other).is_closed() {
            lies[i][1] = true;
            continue;
        }
        let met: BTreeSet<u32> = touches.iter().map(|touch| own.own(touch.triangles[i])).collect();
        let around_other = &solids.mockup().part_bounds()[other as usize];
        let (points, is_outside) = points_aside(&own, &met, around_other, &mut scratch.marks);
        lies[i][1] = is_outside;
        for point in points {
            match locate((index, solids), &point, &[other], scratch)[0] {
                Location::Inside => lies[i][0] = true,
                Location::Outside => lies[i][1] = true,
                Location::On => {}
            }
        }
    }
    let is_inside = is_entering([false; 2]) || lies[0][0] || lies[1][0];
    // What holds another has nothing inside it, and nothing of the other is outside: nor does it go there from where they meet.
    let holds = |i: usize| {
        let is_turned = if i == 0 { [true, false] } else { [false, true] };
        !lies[1 - i][1] && !lies[i][0] && !is_entering(is_turned)
    };
    match is_inside {
        false => Touching::Beside,
        true if holds(0) => Touching::Holding,
        true if holds(1) => Touching::Held,
        true => Touching::Entering,
    }
}

/// Points of a part of which some lie wherever it does, as far as it is in a box around the other: a corner of each connected piece of its
/// surface without the triangles that meet the other part, and the corners that only those have. And whether some of it is outside the
/// box; with a piece that goes on there all of the piece is outside the other part.
fn points_aside(
    solid: &Solid<'_>,
    met: &BTreeSet<u32>,
    around_other: &Aabb,
    marks: &mut Vec<Mark>,
) -> (Vec<Point>, bool) {
    let neighbours = &solid.adjacency().neighbours;
    let is_near = |t: u32| Aabb::of_triangle(&solid.triangle(t)).is_overlapping(around_other);
    marks.resize(neighbours.len().max(marks.len()), Mark::None);
    met.iter().for_each(|t| marks[*t as usize] = Mark::Met);
    let (mut points, mut is_outside) = (Vec::new(), false);
    let (mut seen, mut next) = (Vec::new(), Vec::new());
    for first in solid.triangles() {
        if marks[first as usize] != Mark::None {
            continue;
        }
        if !is_near(first) {
            is_outside = true;
            continue;
        }
        let mut goes_on = false;
        marks[first as usize] = Mark::Seen;
        seen.push(first);
        next.push(first);
        while let Some(t) = next.pop() {
            for beside in neighbours[t as usize] {
                if beside == NONE || marks[beside as usize] != Mark::None {
                    continue;
                }
                if is_near(beside) {
                    marks[beside as usize] = Mark::Seen;
                    seen.push(beside);
                    next.push(beside);
                } else {
                    goes_on = true;
                }
            }
        }
        if !goes_on {
            points.push(solid.triangle(first)[0]);
        }
    }
    // A corner of a piece that is queued already need not be queued again.
    let key = |corner: &Point| corner.map(|x| (x + 0.0).to_bits());
    let mut alone: BTreeMap<[u64; 3], Point> = BTreeMap::new();
    let mut around = Aabb::EMPTY;
    for corner in met.iter().flat_map(|t| solid.triangle(*t)) {
        around.grow(&corner);
        alone.insert(key(&corner), corner);
    }
    for t in seen {
        marks[t as usize] = Mark::None;
        for corner in solid.triangle(t).iter().filter(|corner| is_within(&around, corner)) {
            alone.remove(&key(corner));
        }
    }
    met.iter().for_each(|t| marks[*t as usize] = Mark::None);
    points.extend(alone.into_values());
    (points, is_outside)
}
