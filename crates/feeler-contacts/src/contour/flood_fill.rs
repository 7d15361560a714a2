//! Breadth-first flood fill, over shared edges, of the triangles that contours enclose.

use crate::constants::MOST_FILLED;
use crate::context::QueryContext;
use crate::contour::contact_region::{ContactRegions, FaceNumbers, Segment};
use crate::surface::{Side, Surface};
use feeler_core::constants::NONE;
use feeler_core::geometry::vectors::{dot, sub};
use feeler_core::mesh::topology::adjacency::Adjacency;
use feeler_core::mesh::topology::disjoint_sets::DisjointSets;
use feeler_lanes::prefetch_at;

/// How many triangles ahead in the queue the corners of the neighbours are prefetched.
const FILL_PREFETCH: usize = 4;

/// The findings of fills of one surface, and their working memory. A fill is known by the segment that it started from.
#[derive(Debug, Default)]
pub(crate) struct Filled {
    /// The enclosed triangles, each with the segment of its fill.
    pub triangles: Vec<(u32, u32)>,
    /// Fills that met each other.
    met: Vec<(u32, u32)>,
    /// Fills that came to a contour, and the segment there.
    bridged: Vec<(u32, u32)>,
    /// Fills that came out of the other solid's box.
    leaks: Vec<u32>,
    /// Fills that came to a contour, and the sign of the side that they came from.
    votes: Vec<(u32, i32)>,
}

impl Filled {
    fn clear(&mut self) {
        self.triangles.clear();
        self.met.clear();
        self.bridged.clear();
        self.leaks.clear();
        self.votes.clear();
    }
}

/// From where a fill comes to a triangle.
#[derive(Clone, Copy)]
struct Step {
    triangle: u32,
    is_on_contour: bool,
    /// Whether both ends of the edge between the two are inside.
    is_inside: bool,
}

/// Finds the triangles of one surface that the contours enclose and that meet nothing themselves, and joins the segments of fills
/// that meet or come to another contour.
///
/// A fill leaks through a gap in the contour, or starts on the wrong side of it. Two tests find that: what is inside a solid is
/// inside its box, so a fill that comes out of the box leaks; and a fill is all on one side, so one that comes to contours from
/// outside more often than from inside, by the sides of the vertices there, is outside. Such fills are dropped and join nothing.
///
/// Enclosed triangles are numbered after the faces.
pub(crate) fn flood_fill(
    context: &QueryContext<'_>,
    surface: Surface,
    part: u32,
    regions: &ContactRegions,
    face_numbers: &mut FaceNumbers,
    sets: &mut DisjointSets,
    out: &mut Filled,
) {
    out.clear();
    let Filled { triangles, met, bridged, leaks, votes } = out;
    let adjacency: &Adjacency = context.adjacency[surface];
    let enclosure = context.enclosure(surface.other(), part);
    let first = regions.faces[surface].len();
    let mut reach = |triangle: u32, from: Step, segment: u32, triangles: &mut Vec<(u32, u32)>| {
        if triangle == NONE || triangles.len() >= MOST_FILLED {
            return;
        }
        let number = face_numbers.get(surface, triangle).map(|number| number as usize);
        if let Some(before) = number.and_then(|number| number.checked_sub(first)) {
            // Mostly of the same fill.
            let other = triangles[before].1;
            if other != segment {
                met.push((segment, other));
            }
            return;
        }
        if let Some(number) = number {
            let face = &regions.faces[surface][number];
            // The ends of the edge over which the fill came.
            let edge = adjacency.neighbours[triangle as usize].map(|n| n == from.triangle);
            let mut shared = (0..3).filter(|k| face.nearest[*k] != NONE && (edge[*k] || edge[(k + 2) % 3]));
            if !from.is_on_contour {
                // The fill lies between two contours, or two parts of one.
                bridged.extend(shared.clone().next().map(|k| (segment, face.nearest[k])));
                let other_face = regions.segments[segment as usize].faces[surface.other()];
                if regions.outward(surface.other(), other_face).1 {
                    let side: i32 = shared.map(|k| face.side[k].sign()).sum();
                    votes.push((segment, side.signum()));
                }
            } else if from.is_inside && shared.clone().all(|k| face.side[k] == Side::Inside) {
                // Two faces with an inside edge between them, and no triangle.
                bridged.extend(shared.next().map(|k| (segment, face.nearest[k])));
            }
            return;
        }
        let Segment { faces, points, .. } = &regions.segments[segment as usize];
        let (normal, closed) = regions.outward(surface.other(), faces[surface.other()]);
        let at = &regions.points[points.0 as usize];
        let t = context.triangle(surface, triangle);
        // An open surface has no inside: its plane at the segment keeps the fill from going around its border to the free side.
        if !closed && t.iter().any(|p| dot(&sub(p, at), &normal) > 0.0) {
            return;
        }
        if (closed || surface == Surface::Mockup)
            && !t.iter().all(|p| context.is_enclosed(surface.other(), &enclosure, p))
        {
            if closed && !from.is_on_contour {
                leaks.push(segment);
            }
            return;
        }
        adjacency.prefetch(triangle);
        face_numbers.number(surface, triangle);
        triangles.push((triangle, segment));
    };
    for face in &regions.faces[surface] {
        for k in 0..3 {
            let l = (k + 1) % 3;
            let (a, b) = (face.side[k], face.side[l]);
            if a.sign() + b.sign() < 0 {
                let segment = face.nearest[if a == Side::Inside { k } else { l }];
                let from =
                    Step { triangle: face.id, is_on_contour: true, is_inside: a == Side::Inside && b == Side::Inside };
                reach(adjacency.neighbours[face.id as usize][k], from, segment, triangles);
            }
        }
    }
    let corners = if surface == Surface::Mockup { context.mockup.mesh().faces() } else { context.tool.mesh().faces() };
    let mut next = 0;
    while next < triangles.len() {
        let (triangle, segment) = triangles[next];
        next += 1;
        if let Some((later, _)) = triangles.get(next + FILL_PREFETCH) {
            adjacency.neighbours[*later as usize].iter().for_each(|n| prefetch_at(corners, *n as usize));
        }
        for n in adjacency.neighbours[triangle as usize] {
            reach(n, Step { triangle, is_on_contour: false, is_inside: true }, segment, triangles);
        }
    }
    if !leaks.is_empty() || votes.iter().any(|v| v.1 > 0) {
        let mut fills = DisjointSets((0..regions.segments.len() as u32).collect());
        met.iter().for_each(|(a, b)| fills.join(*a, *b));
        // A leak outweighs all votes.
        let mut outside = vec![0i64; regions.segments.len()];
        votes.iter().for_each(|(segment, side)| outside[fills.of(*segment) as usize] += i64::from(*side));
        leaks.iter().for_each(|segment| outside[fills.of(*segment) as usize] = i64::MAX);
        let mut stays = |segment: u32| outside[fills.of(segment) as usize] <= 0;
        triangles.retain(|t| stays(t.1));
        met.retain(|m| stays(m.0));
        bridged.retain(|b| stays(b.0));
    }
    met.iter().chain(&*bridged).for_each(|(a, b)| sets.join(*a, *b));
}
