//! The walk over what a curve encloses.

use crate::context::QueryContext;
use crate::contour::contact_region::{ContactRegions, FaceNumbers};
use crate::surface::{Side, Surface};
use feeler_core::constants::NONE;
use feeler_core::geometry::vectors::{dot, sub};
use feeler_core::mesh::topology::adjacency::Adjacency;
use feeler_core::mesh::topology::disjoint_sets::DisjointSets;
use feeler_lanes::prefetch_at;

/// Most triangles that are walked over beyond the curve, of each surface and in one part. What lies further counts for depth
/// only by its nearer part; a result that stopped here is not called exact.
const MOST_WALKED: usize = 1 << 16;

/// Triangles found before whose neighbours' corners are asked for.
const AHEAD: usize = 4;

/// What was found on walks over one surface. Kept as working memory.
#[derive(Debug, Default)]
pub(crate) struct Filled {
    /// The uncut triangles of the surface beyond the other, each with a cut of its zone, whose plane it was held against.
    pub found: Vec<(u32, u32)>,
    /// Whether these are all.
    pub complete: bool,
    /// Walks that met, walks that came to another curve, and walks that leak, all by their cuts.
    met: Vec<(u32, u32)>,
    bridged: Vec<(u32, u32)>,
    leaks: Vec<u32>,
    /// On which side the walks came to the curve, by their cuts.
    votes: Vec<(u32, i32)>,
}

impl Filled {
    fn clear(&mut self) {
        self.found.clear();
        self.met.clear();
        self.bridged.clear();
        self.leaks.clear();
        self.votes.clear();
    }
}

/// From where a walk comes to a triangle.
#[derive(Clone, Copy)]
struct Step {
    triangle: u32,
    is_on_contour: bool,
    /// Whether the edge between the two is, both its ends.
    is_inside: bool,
}

/// Finds the uncut triangles of one surface beyond the other over shared edges.
///
/// What lies inside a solid lies inside its box. A walk that comes out of there went through a gap in the curve, or started on
/// the wrong side of it: what it found is dropped, and it joins nothing. So is what a walk found that comes to the curve from
/// outside more often than from inside, by what the cuts say about the corners there: it is all on one side.
///
/// What was walked over has its places after those of the faces.
pub(crate) fn flood_fill(
    context: &QueryContext<'_>,
    surface: Surface,
    part: u32,
    regions: &ContactRegions,
    places: &mut FaceNumbers,
    sets: &mut DisjointSets,
    out: &mut Filled,
) {
    out.clear();
    let Filled { found, complete, met, bridged, leaks, votes } = out;
    let adjacency: &Adjacency = context.adjacency[surface];
    let enclosure = context.enclosure(surface.other(), part);
    let first = regions.faces[surface].len();
    let mut is_refused = false;
    let mut reach = |triangle: u32, from: Step, segment: u32, found: &mut Vec<(u32, u32)>| {
        if triangle == NONE || found.len() >= MOST_WALKED {
            return;
        }
        let known = places.get(surface, triangle).map(|place| place as usize);
        if let Some(before) = known.and_then(|place| place.checked_sub(first)) {
            // Mostly the walk that it is of.
            let other = found[before].1;
            if other != segment {
                met.push((segment, other));
            }
            return;
        }
        if let Some(place) = known {
            let face = &regions.faces[surface][place];
            // The ends of the edge over which it came.
            let edge = adjacency.neighbours[triangle as usize].map(|n| n == from.triangle);
            let mut shared = (0..3).filter(|k| face.nearest[*k] != NONE && (edge[*k] || edge[(k + 2) % 3]));
            if !from.is_on_contour {
                // Another curve: what was walked over lies between the two.
                bridged.extend(shared.clone().next().map(|k| (segment, face.nearest[k])));
                let c = &regions.segments[segment as usize];
                if regions.side_of(surface.other(), c.faces[surface.other()]).1 {
                    let side: i32 = shared.map(|k| face.side[k].sign()).sum();
                    votes.push((segment, side.signum()));
                }
            } else if from.is_inside && shared.clone().all(|k| face.side[k] == Side::Inside) {
                // Between the two is nothing but their edge.
                bridged.extend(shared.next().map(|k| (segment, face.nearest[k])));
            }
            return;
        }
        let c = &regions.segments[segment as usize];
        let ((normal, closed), at) =
            (regions.side_of(surface.other(), c.faces[surface.other()]), &regions.points[c.points.0 as usize]);
        let t = context.triangle(surface, triangle);
        // An open surface ends somewhere, and round its border the walk would come to the free side.
        if !closed && t.iter().any(|p| dot(&sub(p, at), &normal) > 0.0) {
            return;
        }
        if (closed || surface == Surface::Mockup)
            && !t.iter().all(|p| context.is_enclosed(surface.other(), &enclosure, p))
        {
            if closed && !from.is_on_contour {
                leaks.push(segment);
            }
            is_refused = true;
            return;
        }
        adjacency.prefetch(triangle);
        places.number(surface, triangle);
        found.push((triangle, segment));
    };
    for face in &regions.faces[surface] {
        for k in 0..3 {
            let l = (k + 1) % 3;
            let (a, b) = (face.side[k], face.side[l]);
            if a.sign() + b.sign() < 0 {
                let segment = face.nearest[if a == Side::Inside { k } else { l }];
                let from =
                    Step { triangle: face.id, is_on_contour: true, is_inside: a == Side::Inside && b == Side::Inside };
                reach(adjacency.neighbours[face.id as usize][k], from, segment, found);
            }
        }
    }
    let faces = if surface == Surface::Mockup { context.mockup.mesh().faces() } else { context.tool.mesh().faces() };
    let mut next = 0;
    while next < found.len() {
        let (triangle, segment) = found[next];
        next += 1;
        if let Some((later, _)) = found.get(next + AHEAD) {
            adjacency.neighbours[*later as usize].iter().for_each(|n| prefetch_at(faces, *n as usize));
        }
        for n in adjacency.neighbours[triangle as usize] {
            reach(n, Step { triangle, is_on_contour: false, is_inside: true }, segment, found);
        }
    }
    *complete = found.len() < MOST_WALKED && !is_refused;
    if !leaks.is_empty() || votes.iter().any(|v| v.1 > 0) {
        let mut fills = DisjointSets((0..regions.segments.len() as u32).collect());
        met.iter().for_each(|(a, b)| fills.join(*a, *b));
        // A leak outweighs all votes.
        let mut outside = vec![0i64; regions.segments.len()];
        votes.iter().for_each(|(segment, side)| outside[fills.of(*segment) as usize] += i64::from(*side));
        leaks.iter().for_each(|segment| outside[fills.of(*segment) as usize] = i64::MAX);
        let mut stays = |segment: u32| outside[fills.of(segment) as usize] <= 0;
        found.retain(|f| stays(f.1));
        met.retain(|m| stays(m.0));
        bridged.retain(|b| stays(b.0));
    }
    met.iter().chain(&*bridged).for_each(|(a, b)| sets.join(*a, *b));
}
