//! The walk over what a curve encloses.

use crate::contacts::adjacency::{Adjacency, NONE};
use crate::contacts::joins::Roots;
use crate::contacts::numbered::Numbered;
use crate::contacts::zones::{Places, Zones, MOCKUP};
use crate::contacts::Ground;
use crate::simd::prefetch_at;
use crate::vectors::{dot, sub};

/// Most triangles that are walked over beyond the curve, of each surface and in one part. What lies further counts for depth
/// only by its nearer part; a result that stopped here is not called exact.
const MOST_WALKED: usize = 1 << 16;

/// Triangles found before whose neighbours' corners are asked for.
const AHEAD: usize = 4;

/// The uncut triangles of one surface beyond the other, each with a cut of its zone, found over shared edges; and whether they
/// are all.
///
/// What lies inside a solid lies inside its box. A walk that comes out of there went through a gap in the curve, or started on
/// the wrong side of it: what it found is dropped, and it joins nothing. So is what a walk found that comes to the curve from
/// outside more often than from inside, by what the cuts say about the corners there: it is all on one side.
pub(crate) fn walk(
    ground: &Ground<'_>,
    w: usize,
    part: u32,
    zones: &Zones,
    places: &Places,
    seen: &mut Numbered,
    roots: &mut Roots,
) -> (Vec<(u32, u32)>, bool) {
    let adjacency: &Adjacency = ground.adjacency[w];
    let enclosure = ground.enclosure(1 - w, part);
    // Each triangle with a cut of its zone, whose plane it is held against.
    let mut found: Vec<(u32, u32)> = Vec::new();
    seen.clear();
    // Walks that met, walks that came to another curve, and walks that leak, all by their cuts.
    let mut met: Vec<(u32, u32)> = Vec::new();
    let mut bridged: Vec<(u32, u32)> = Vec::new();
    let mut leaks: Vec<u32> = Vec::new();
    // On which side the walks came to the curve, by their cuts.
    let mut votes: Vec<(u32, i8)> = Vec::new();
    let mut is_refused = false;
    let mut reach = |triangle: u32, from: Option<u32>, cut: u32, found: &mut Vec<(u32, u32)>| {
        if triangle == NONE || found.len() >= MOST_WALKED {
            return;
        }
        if let Some(place) = places.get(w, triangle) {
            if let Some(from) = from {
                let face = &zones.faces[w][place as usize];
                let corners = ground.triangle(w, from);
                let shared = (0..3).filter(|k| face.nearest[*k] != NONE && corners.contains(&face.corners[*k]));
                // Another curve: what was walked over lies between the two.
                bridged.extend(shared.clone().next().map(|k| (cut, face.nearest[k])));
                let c = &zones.cuts[cut as usize];
                if zones.faces[1 - w][c.faces[1 - w] as usize].closed {
                    let side: i8 = shared.map(|k| face.side[k]).sum();
                    votes.push((cut, side.signum()));
                }
            }
            return;
        }
        if let Some(before) = seen.get(u64::from(triangle)) {
            met.push((cut, found[before as usize].1));
            return;
        }
        let c = &zones.cuts[cut as usize];
        let (plane, at) = (&zones.faces[1 - w][c.faces[1 - w] as usize], &zones.points[c.points.0 as usize]);
        let t = ground.triangle(w, triangle);
        // An open surface ends somewhere, and round its border the walk would come to the free side.
        if !plane.closed && t.iter().any(|p| dot(&sub(p, at), &plane.normal) > 0.0) {
            return;
        }
        if (plane.closed || w == MOCKUP) && !t.iter().all(|p| ground.is_enclosed(1 - w, &enclosure, p)) {
            if plane.closed && from.is_some() {
                leaks.push(cut);
            }
            is_refused = true;
            return;
        }
        adjacency.prefetch(triangle);
        seen.number(u64::from(triangle));
        found.push((triangle, cut));
    };
    for face in &zones.faces[w] {
        for k in 0..3 {
            let l = (k + 1) % 3;
            let (a, b) = (face.side[k], face.side[l]);
            if a + b < 0 {
                let cut = face.nearest[if a < 0 { k } else { l }];
                reach(adjacency.neighbours[face.id as usize][k], None, cut, &mut found);
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
            reach(n, Some(triangle), cut, &mut found);
        }
    }
    let is_complete = found.len() < MOST_WALKED && !is_refused;
    if !leaks.is_empty() || votes.iter().any(|v| v.1 > 0) {
        let mut walks = Roots((0..zones.cuts.len() as u32).collect());
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
    met.iter().chain(&bridged).for_each(|(a, b)| roots.join(*a, *b));
    (found, is_complete)
}
