//! The walk over what a curve encloses.

use crate::context::Ground;
use crate::context::MOCKUP;
use crate::contour::contact_region::{Places, Zones};
use feeler_core::geometry::vectors::{dot, sub};
use feeler_core::mesh::topology::adjacency::{Adjacency, NONE};
use feeler_core::mesh::topology::disjoint_sets::DisjointSets;
use feeler_lanes::prefetch_at;

/// Most triangles that are walked over beyond the curve, of each surface and in one part. What lies further counts for depth
/// only by its nearer part; a result that stopped here is not called exact.
const MOST_WALKED: usize = 1 << 16;

/// Triangles found before whose neighbours' corners are asked for.
const AHEAD: usize = 4;

/// What was found on walks over one surface. Kept as working memory.
#[derive(Debug, Default)]
pub(crate) struct Walked {
    /// The uncut triangles of the surface beyond the other, each with a cut of its zone, whose plane it was held against.
    pub found: Vec<(u32, u32)>,
    /// Whether these are all.
    pub complete: bool,
    /// Walks that met, walks that came to another curve, and walks that leak, all by their cuts.
    met: Vec<(u32, u32)>,
    bridged: Vec<(u32, u32)>,
    leaks: Vec<u32>,
    /// On which side the walks came to the curve, by their cuts.
    votes: Vec<(u32, i8)>,
}

impl Walked {
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
    is_cut: bool,
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
pub(crate) fn walk(
    ground: &Ground<'_>,
    w: usize,
    part: u32,
    zones: &Zones,
    places: &mut Places,
    roots: &mut DisjointSets,
    out: &mut Walked,
) {
    out.clear();
    let Walked { found, complete, met, bridged, leaks, votes } = out;
    let adjacency: &Adjacency = ground.adjacency[w];
    let enclosure = ground.enclosure(1 - w, part);
    let first = zones.faces[w].len();
    let mut is_refused = false;
    let mut reach = |triangle: u32, from: Step, cut: u32, found: &mut Vec<(u32, u32)>| {
        if triangle == NONE || found.len() >= MOST_WALKED {
            return;
        }
        let known = places.get(w, triangle).map(|place| place as usize);
        if let Some(before) = known.and_then(|place| place.checked_sub(first)) {
            // Mostly the walk that it is of.
            let other = found[before].1;
            if other != cut {
                met.push((cut, other));
            }
            return;
        }
        if let Some(place) = known {
            let face = &zones.faces[w][place];
            // The ends of the edge over which it came.
            let edge = adjacency.neighbours[triangle as usize].map(|n| n == from.triangle);
            let mut shared = (0..3).filter(|k| face.nearest[*k] != NONE && (edge[*k] || edge[(k + 2) % 3]));
            if !from.is_cut {
                // Another curve: what was walked over lies between the two.
                bridged.extend(shared.clone().next().map(|k| (cut, face.nearest[k])));
                let c = &zones.cuts[cut as usize];
                if zones.side_of(1 - w, c.faces[1 - w]).1 {
                    let side: i8 = shared.map(|k| face.side[k]).sum();
                    votes.push((cut, side.signum()));
                }
            } else if from.is_inside && shared.clone().all(|k| face.side[k] < 0) {
                // Between the two is nothing but their edge.
                bridged.extend(shared.next().map(|k| (cut, face.nearest[k])));
            }
            return;
        }
        let c = &zones.cuts[cut as usize];
        let ((normal, closed), at) = (zones.side_of(1 - w, c.faces[1 - w]), &zones.points[c.points.0 as usize]);
        let t = ground.triangle(w, triangle);
        // An open surface ends somewhere, and round its border the walk would come to the free side.
        if !closed && t.iter().any(|p| dot(&sub(p, at), &normal) > 0.0) {
            return;
        }
        if (closed || w == MOCKUP) && !t.iter().all(|p| ground.is_enclosed(1 - w, &enclosure, p)) {
            if closed && !from.is_cut {
                leaks.push(cut);
            }
            is_refused = true;
            return;
        }
        adjacency.prefetch(triangle);
        places.number(w, triangle);
        found.push((triangle, cut));
    };
    for face in &zones.faces[w] {
        for k in 0..3 {
            let l = (k + 1) % 3;
            let (a, b) = (face.side[k], face.side[l]);
            if a + b < 0 {
                let cut = face.nearest[if a < 0 { k } else { l }];
                let from = Step { triangle: face.id, is_cut: true, is_inside: a < 0 && b < 0 };
                reach(adjacency.neighbours[face.id as usize][k], from, cut, found);
            }
        }
    }
    let faces = if w == MOCKUP { ground.mockup.mesh().faces() } else { ground.tool.mesh().faces() };
    let mut next = 0;
    while next < found.len() {
        let (triangle, cut) = found[next];
        next += 1;
        if let Some((later, _)) = found.get(next + AHEAD) {
            adjacency.neighbours[*later as usize].iter().for_each(|n| prefetch_at(faces, *n as usize));
        }
        for n in adjacency.neighbours[triangle as usize] {
            reach(n, Step { triangle, is_cut: false, is_inside: true }, cut, found);
        }
    }
    *complete = found.len() < MOST_WALKED && !is_refused;
    if !leaks.is_empty() || votes.iter().any(|v| v.1 > 0) {
        let mut walks = DisjointSets((0..zones.cuts.len() as u32).collect());
        met.iter().for_each(|(a, b)| walks.join(*a, *b));
        // A leak outweighs all votes.
        let mut outside = vec![0i64; zones.cuts.len()];
        votes.iter().for_each(|(cut, side)| outside[walks.of(*cut) as usize] += i64::from(*side));
        leaks.iter().for_each(|cut| outside[walks.of(*cut) as usize] = i64::MAX);
        let mut stays = |cut: u32| outside[walks.of(cut) as usize] <= 0;
        found.retain(|f| stays(f.1));
        met.retain(|m| stays(m.0));
        bridged.retain(|b| stays(b.0));
    }
    met.iter().chain(&*bridged).for_each(|(a, b)| roots.join(*a, *b));
}
