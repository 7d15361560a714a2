//! Sides of vertices in degenerate cases, where edges touch edges: a segment has no length or is in line with the
//! corner, or two segments are equally near and equally steep.

use crate::constants::{EQUAL_SHARE, ON_PLANE_SHARE, PROBE_SHARE, SAME_FOOT_SHARE};
use crate::contour::contact_region::ContactRegions;
use crate::surface::Surface;
use feeler_core::geometry::bounds::{Point, Triangle};
use feeler_core::geometry::distance_triangle_triangle::closest_triangle_triangle;
use feeler_core::geometry::vectors::{along, cross, dot, length, sub};

/// The side of a corner, as a segment implies it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SideEvidence {
    pub segment: u32,
    /// The point of the segment nearest to the corner, and the square of the distance.
    foot: Point,
    square: f64,
    /// Square of the sine between the segment's line and the way from the foot to the corner; 0 where the corner is in line with it.
    steepness: f64,
    /// Height of the corner over the plane of the other face.
    pub height: f64,
}

impl SideEvidence {
    fn new(regions: &ContactRegions, surface: Surface, segment: u32, k: usize) -> SideEvidence {
        let ([a, b], corner) = (regions.ends(segment), regions.face(surface, segment).corners[k]);
        let (line, from) = (sub(&b, &a), sub(&corner, &a));
        let lengths = dot(&line, &line);
        let share = if lengths > 0.0 { (dot(&from, &line) / lengths).clamp(0.0, 1.0) } else { 0.0 };
        let off = along(&from, -share, &line);
        let square = dot(&off, &off);
        let steep = if lengths > ON_PLANE_SHARE * ON_PLANE_SHARE * square {
            let across = cross(&from, &line);
            dot(&across, &across) / lengths
        } else {
            0.0
        };
        let steepness = match square {
            // The corner is on the surface, whatever other segments tell.
            0.0 => 1.0,
            _ if steep > ON_PLANE_SHARE * ON_PLANE_SHARE * square => steep / square,
            _ => 0.0,
        };
        let (outward, _) = regions.outward(surface.other(), regions.segments[segment as usize].faces[surface.other()]);
        SideEvidence { segment, foot: along(&a, share, &line), square, steepness, height: dot(&from, &outward) }
    }

    /// Whether the corner is on the plane of the other face.
    pub fn is_on(&self) -> bool {
        self.square == 0.0 || self.height * self.height < ON_PLANE_SHARE * ON_PLANE_SHARE * self.square
    }

    /// Whether the corner is off the segment's line, on one side of it.
    fn has_side(&self) -> bool {
        self.steepness > 0.0
    }

    fn is_as_far_as(&self, other: &SideEvidence) -> bool {
        is_equal(self.square, other.square)
    }

    fn is_as_steep_as(&self, other: &SideEvidence) -> bool {
        is_equal(self.steepness, other.steepness)
    }

    /// Segments that have a side come first, then nearer ones, then steeper ones.
    fn is_better_than(&self, other: &SideEvidence) -> bool {
        if self.has_side() != other.has_side() {
            self.has_side()
        } else if !self.is_as_far_as(other) {
            self.square < other.square
        } else {
            !self.is_as_steep_as(other) && self.steepness > other.steepness
        }
    }

    /// Whether the two are equally near, steepness does not tell which is right, and they tell different sides.
    fn contradicts(&self, other: &SideEvidence) -> bool {
        self.is_as_far_as(other)
            && (self.has_side() != other.has_side() || self.is_as_steep_as(other))
            && self.height.partial_cmp(&0.0) != other.height.partial_cmp(&0.0)
    }
}

fn is_equal(x: f64, y: f64) -> bool {
    x >= y * (1.0 - EQUAL_SHARE) && x <= y * (1.0 + EQUAL_SHARE)
}

/// The best evidence of a face's segments for its corner `k`, and whether another contradicts it. `None` where all are flat.
pub(crate) fn best_evidence(
    regions: &ContactRegions,
    surface: Surface,
    segments: &[u32],
    k: usize,
) -> Option<(SideEvidence, bool)> {
    let mut found = None;
    for segment in segments.iter().filter(|segment| !regions.segments[**segment as usize].flat) {
        let this = SideEvidence::new(regions, surface, *segment, k);
        found = match found {
            None => Some((this, false)),
            Some((best, contradicted)) if this.is_better_than(&best) => {
                Some((this, this.contradicts(&best) || contradicted && this.is_as_far_as(&best)))
            }
            Some((best, contradicted)) => Some((best, contradicted || this.contradicts(&best))),
        };
    }
    found
}

/// The evidence that decides the side of a face's corner `k`. Where two segments contradict each other the other surface has an edge
/// or a vertex at their common foot, and the corner is on the side on which the way from the foot to it starts: that of the triangle
/// nearest to a probe on this way, close to the foot. `None` where all segments are flat.
pub(crate) fn resolve_side(regions: &ContactRegions, surface: Surface, face: usize, k: usize) -> Option<SideEvidence> {
    let segments = regions.of_face(surface, face);
    let (first, contradicted) = best_evidence(regions, surface, segments, k)?;
    // A corner on a segment is on the surface, and has no way to it.
    if !contradicted || first.square == 0.0 {
        return Some(first);
    }
    let (foot, far) = (first.foot, first.square.sqrt());
    let here: Vec<(SideEvidence, Triangle)> = segments
        .iter()
        .filter(|segment| !regions.segments[**segment as usize].flat)
        .map(|segment| {
            (SideEvidence::new(regions, surface, *segment, k), regions.face(surface.other(), *segment).corners)
        })
        .filter(|(evidence, _)| length(&sub(&evidence.foot, &foot)) <= SAME_FOOT_SHARE * far)
        .collect();
    // Close enough to the foot for the triangles that meet there to be the nearest.
    let edge = |t: &Triangle, k: usize| length(&sub(&t[(k + 1) % 3], &t[k]));
    let reach = here.iter().map(|(_, t)| edge(t, 0).min(edge(t, 1)).min(edge(t, 2))).fold(far, f64::min);
    let way = sub(&regions.faces[surface][face].corners[k], &foot);
    let probe = along(&foot, PROBE_SHARE * reach / far, &way);
    let noise = SAME_FOOT_SHARE * PROBE_SHARE * reach;
    let mut best = (f64::INFINITY, first);
    for (evidence, t) in here {
        let distance = closest_triangle_triangle(&[probe; 3], &t).distance;
        // Of several equally near the one over whose plane the way rises or falls most.
        let is_as_near = distance < best.0 + noise;
        if distance < best.0 - noise || is_as_near && evidence.height.abs() > best.1.height.abs() {
            best = (distance, evidence);
        }
    }
    Some(best.1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::context::QueryContext;
    use crate::contour::find::{find, RegionScratch};
    use crate::surface::Side;
    use crate::surface::Surface;
    use crate::tests::{scene, tool};
    use feeler_core::geometry::pose::Pose;
    use feeler_shapes::{box_mesh, ridge};

    /// Cubes on a lattice, straight and turned by 45 degrees, in a body with steps up, down and slanted on the same lattice, all
    /// turned by `all`. Of the corners off the other surface that have a segment: how many there are, how many are on no side, and how
    /// many on the wrong one.
    fn corners_by_side(all: &[Point; 3]) -> [usize; 3] {
        let line =
            [[-4.0, 0.0], [-2.0, 0.0], [-1.5, 1.0], [0.0, 1.0], [1.0, 2.0], [2.0, 1.0], [3.0, 1.0], [4.0, 0.0f64]];
        let height_at = |x: f64| {
            let k = line.windows(2).position(|ends| x <= ends[1][0]).unwrap_or(line.len() - 2);
            let [[a, p], [b, q]] = [line[k], line[k + 1]];
            p + (q - p) * (x - a) / (b - a)
        };
        let in_ridge = |p: &Point, off: f64| {
            let is_in_reach = p[0].abs() < 4.0 + off && p[1].abs() < 3.0 + off && p[2] > -2.0 - off;
            is_in_reach && p[2] < height_at(p[0]) + 4.0 * off
        };
        let in_cube = |p: &Point, off: f64| p.iter().all(|x| x.abs() < 0.5 + off);
        let turned = |rows: &[Point; 3], p: &Point| -> Point { std::array::from_fn(|a| dot(&rows[a], p)) };
        let back = |rows: &[Point; 3], p: &Point| -> Point {
            std::array::from_fn(|a| rows[0][a] * p[0] + rows[1][a] * p[1] + rows[2][a] * p[2])
        };
        let c = 0.5f64.sqrt();
        let turns = [
            [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            [[c, 0.0, c], [0.0, 1.0, 0.0], [-c, 0.0, c]],
            [[c, -c, 0.0], [c, c, 0.0], [0.0, 0.0, 1.0]],
        ];
        let mut counts = [0; 3];
        let mut scratch = RegionScratch::default();
        for (n, m) in [(1, 1), (1, 4), (2, 8)] {
            let mut mesh = ridge(&line, -2.0, 3.0, n, m);
            mesh.0.iter_mut().for_each(|p| *p = turned(all, p));
            let block = scene(mesh);
            for (cells, step) in (1..4).flat_map(|cells| (0..600).map(move |step| (cells, step))) {
                let cube = tool(box_mesh([0.0; 3], [1.0; 3], cells));
                let (turn, place) = (&turns[step % 3], step / 3);
                let spot = [place % 10, place / 10 % 4 + 5, place / 40 + 4].map(|x| 0.5 * (x as f64 - 5.0));
                let (columns, at) = ([0, 1, 2].map(|k| turned(all, &turn.map(|row| row[k]))), turned(all, &spot));
                let row = |a: usize| [columns[0][a], columns[1][a], columns[2][a], at[a]];
                let pose = Pose::new(&[row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]]).unwrap();
                let pairs = block.collide(&cube, &pose).pairs;
                if pairs.is_empty() {
                    continue;
                }
                let regions = find(&QueryContext::new(&block, &cube, &pose, None), &pairs, None, &mut scratch);
                for surface in Surface::BOTH {
                    for (face, segments) in regions.faces[surface].iter().zip(regions.by_face(surface)) {
                        if segments.iter().all(|segment| regions.segments[*segment as usize].flat) {
                            continue;
                        }
                        for (corner, side) in face.corners.iter().zip(face.side) {
                            let p = back(all, corner);
                            let is_in = |off: f64| match surface {
                                Surface::Tool => in_ridge(&p, off),
                                _ => in_cube(&back(turn, &sub(&p, &spot)), off),
                            };
                            if is_in(-1e-6) == is_in(1e-6) {
                                let truth = if is_in(1e-6) { Side::Inside } else { Side::Outside };
                                counts[0] += 1;
                                counts[1] += usize::from(side == Side::On);
                                counts[2] += usize::from(side.sign() == -truth.sign());
                            }
                        }
                    }
                }
            }
        }
        counts
    }

    #[test]
    fn corners_are_on_their_side_where_edges_meet_edges() {
        let straight = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let [all, unknown, wrong] = corners_by_side(&straight);
        assert!(all > 100_000 && unknown == 0 && wrong == 0, "{unknown} and {wrong} of {all}");
        // Turned, rounding parts some of what touched and lets other meet: the rest of a segment may be in line with the corner.
        let turned = [[0.48, 0.64, -0.6], [-0.8, 0.6, 0.0], [0.36, 0.48, 0.8]];
        let [all, unknown, wrong] = corners_by_side(&turned);
        assert!(all > 100_000 && 50 * unknown < all && 2000 * wrong < all, "{unknown} and {wrong} of {all}");
    }
}
