//! The planes of one contact region: the least depths of all pairs of bodies, without those that another plane dominates.

use crate::contact_plane::by_coordinates;
use crate::depth::dominated_by::{is_dominated, OwnPlane};
use crate::depth::face_axes::FaceDepth;
use crate::depth::least_depth::{Depth, DepthScratch};
use crate::depth::region_bodies::RegionBodies;

/// Which axes are searched for a pair of bodies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum AxisFilter {
    /// Those near a face axis that leads out; none where there is no such face axis.
    LeadingOut,
    /// Any.
    Any,
}

/// Finds the planes of a region, deepest first. `faces` is working memory.
pub(crate) fn find_planes(
    bodies: &RegionBodies<'_>,
    filter: AxisFilter,
    scratch: &mut DepthScratch,
    faces: &mut Vec<FaceDepth>,
    found: &mut Vec<Depth>,
) {
    find_depths(bodies, filter, scratch, faces, found);
    found.sort_by(|p, q| {
        (p.gap().total_cmp(&q.gap()))
            .then_with(|| by_coordinates(&p.normal(), &q.normal()))
            .then_with(|| by_coordinates(&p.point, &q.point))
    });
    keep_dominant(bodies, scratch, found);
}

/// Finds the least depths of pairs that nothing found before dominates. First those of pairs that share segments of the contour,
/// since mostly one of these dominates the walled-in bodies.
fn find_depths(
    bodies: &RegionBodies<'_>,
    filter: AxisFilter,
    scratch: &mut DepthScratch,
    faces: &mut Vec<FaceDepth>,
    found: &mut Vec<Depth>,
) {
    let [tools, mockups] = bodies.counts();
    scratch.clear([tools, mockups]);
    found.clear();
    let mut asked = Vec::with_capacity(mockups);
    for is_on_contour in [true, false] {
        faces.clear();
        for t in 0..tools {
            asked.clear();
            for pair in (0..mockups).map(|m| [t, m]) {
                let is_asked = if is_on_contour {
                    bodies.share_segments(pair)
                } else {
                    bodies.is_walled_in(pair) && !is_dominated(bodies, OwnPlane::WalledIn(pair), found, scratch)
                };
                if is_asked {
                    asked.push(pair);
                }
            }
            scratch.push_face_depths(asked.iter().map(|pair| bodies.pair(*pair)), faces);
        }
        // Deepest first, since a deeper plane may dominate a shallower one. Pairs without a face axis that leads out come last and
        // are searched only where nothing else gives a plane: mostly no axis leads out of them.
        faces.sort_by(|p, q| q.depth().total_cmp(&p.depth()));
        for face in faces.iter() {
            let is_needless = if face.axis.is_some() {
                is_dominated(bodies, OwnPlane::Face(face), found, scratch)
            } else {
                filter == AxisFilter::LeadingOut || !found.is_empty()
            };
            if !is_needless {
                found.extend(bodies.pair(face.bodies).least_depth(face, scratch));
            }
        }
    }
}

/// Drops dominated planes of a list that is sorted by gap, and measures the overlaps of the others, which may put them further
/// back.
fn keep_dominant(bodies: &RegionBodies<'_>, scratch: &mut DepthScratch, found: &mut Vec<Depth>) {
    let (mut kept, mut next) = (0, 0);
    while let Some(mut depth) = found.get(next).copied() {
        if is_dominated(bodies, OwnPlane::Least(&depth), &mut found[..kept], scratch) {
            next += 1;
            continue;
        }
        // If it is no deeper than a known plane that then dominates it, how deep does not matter.
        let bound = depth.gap();
        let dominating = |d: &&Depth| d.gap() > bound && d.is_known() && OwnPlane::Least(&depth).is_facing_as(d);
        let least = found[next + 1..].iter().find(dominating).map_or(0.0, |d| -d.gap());
        bodies.pair(depth.bodies).measure(bodies.context, &mut depth, least, scratch);
        found[next] = depth;
        if depth.gap() > bound {
            let deeper = found[next + 1..].partition_point(|d| d.gap() <= depth.gap());
            found[next..=next + deeper].rotate_left(1);
        } else {
            found[kept] = depth;
            (kept, next) = (kept + 1, next + 1);
        }
    }
    found.truncate(kept);
}
