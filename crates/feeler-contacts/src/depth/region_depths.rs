//! The least depths of all pairs of bodies in one contact region.

use crate::constants::{DOMINATED_COSINE, SAME_PLANE};
use crate::contact_plane::by_coordinates;
use crate::containers::bit_set::{is_meeting, shared};
use crate::context::QueryContext;
use crate::contour::contact_region::ContactRegions;
use crate::depth::axis::BodyPair;
use crate::depth::face_axes::FaceDepth;
use crate::depth::least_depth::{Depth, DepthScratch};
use crate::patch::body::{Bodies, Body};
use crate::surface::Surface;
use feeler_core::geometry::vectors::dot;
use feeler_core::Point;

/// Which axes are searched for a pair of bodies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum AxisFilter {
    /// Those near a face axis that leads out; none where there is no such face axis.
    LeadingOut,
    /// Any.
    Any,
}

/// The bodies of tool and mock-up in one region.
pub(crate) struct RegionBodies<'a> {
    context: &'a QueryContext<'a>,
    regions: &'a ContactRegions,
    bodies: &'a [Bodies; 2],
    each: [Vec<Body<'a>>; 2],
}

impl<'a> RegionBodies<'a> {
    pub fn new(
        context: &'a QueryContext<'a>,
        regions: &'a ContactRegions,
        bodies: &'a [Bodies; 2],
    ) -> RegionBodies<'a> {
        let each = bodies.each_ref().map(|of| (0..of.len()).map(|i| of.get(i)).collect());
        RegionBodies { context, regions, bodies, each }
    }

    pub fn pair(&self, t: usize, m: usize) -> BodyPair<'_> {
        let (tool, mockup) = (&self.each[Surface::Tool][t], &self.each[Surface::Mockup][m]);
        BodyPair { lanes: self.context.lanes, regions: self.regions, tool, mockup }
    }

    pub fn share_segments(&self, t: usize, m: usize) -> bool {
        is_meeting(self.bodies[Surface::Tool].segments.get(t), self.bodies[Surface::Mockup].segments.get(m))
    }

    /// The segments that both are on, by their places in the region.
    pub fn segments_of(&self, t: usize, m: usize) -> impl Iterator<Item = usize> + 'a {
        shared(self.bodies[Surface::Tool].segments.get(t), self.bodies[Surface::Mockup].segments.get(m))
    }

    /// Whether one of the two is off the contour, walled in by others of its surface: it meets what they meet.
    fn is_walled_in(&self, t: usize, m: usize) -> bool {
        !(self.bodies[Surface::Tool].is_on_contour(t) && self.bodies[Surface::Mockup].is_on_contour(m))
    }

    /// Whether a condition holds for any plane found whose bodies overlap by as much as it is deep.
    fn any(
        &self,
        found: &mut [(Depth, [usize; 2])],
        scratch: &mut DepthScratch,
        is: impl Fn(&Depth, [usize; 2]) -> bool,
    ) -> bool {
        found.iter_mut().any(|(d, [t, m])| is(d, [*t, *m]) && self.pair(*t, *m).is_filled(self.context, d, scratch))
    }

    /// Whether a plane found for other bodies, of about their normal, separates two bodies as well; or where that plane is only an
    /// overlap, whether they overlap along it by no more.
    fn is_held(
        &self,
        pair: BodyPair<'_>,
        depth: f64,
        is_like: impl Fn(&Point) -> bool,
        found: &mut [(Depth, [usize; 2])],
        scratch: &mut DepthScratch,
    ) -> bool {
        let mut most: Option<&Depth> = None;
        for (d, [t, m]) in found {
            let is_less = most.is_some_and(|most| d.is_less_than(most));
            if is_less || !is_like(&d.normal) {
                continue;
            }
            let Some(held) = pair.held_depth(d, depth, scratch) else { continue };
            let own = self.pair(*t, *m);
            if own.is_filled(self.context, d, scratch) {
                return true;
            }
            own.measure(self.context, d, most.map_or(0.0, |most| -most.gap()), scratch);
            if held <= -d.gap() {
                return true;
            }
            if most.is_none_or(|most| d.gap() < most.gap()) {
                most = Some(d);
            }
        }
        most.is_some_and(|d| pair.overlaps_no_more(self.context, self.bodies[Surface::Mockup].all(), d, scratch))
    }

    /// Finds the least depths of bodies that meet, deepest first, with the bodies' numbers. First of pairs that share segments of
    /// the contour; what is walled in needs no plane of its own where one of these separates it.
    pub fn find_depths(
        &self,
        filter: AxisFilter,
        scratch: &mut DepthScratch,
        faces: &mut Vec<(FaceDepth, [usize; 2])>,
        found: &mut Vec<(Depth, [usize; 2])>,
    ) {
        scratch.clear([self.bodies[Surface::Tool].len(), self.bodies[Surface::Mockup].len()]);
        found.clear();
        let mut mockups = Vec::with_capacity(self.bodies[Surface::Mockup].len());
        for is_on_contour in [true, false] {
            faces.clear();
            for t in 0..self.bodies[Surface::Tool].len() {
                mockups.clear();
                for m in 0..self.bodies[Surface::Mockup].len() {
                    let is_asked = if is_on_contour { self.share_segments(t, m) } else { self.is_walled_in(t, m) };
                    if !is_asked {
                        continue;
                    }
                    let pair = self.pair(t, m);
                    let holds = |d: &Depth, [i, j]: [usize; 2]| i == t && pair.is_under(d) || j == m && pair.is_over(d);
                    if is_on_contour || !self.any(found, scratch, holds) {
                        mockups.push(m);
                    }
                }
                scratch.push_face_depths(mockups.iter().map(|m| self.pair(t, *m)), faces);
            }
            // Deepest first, since a deeper plane may stand for a shallower one. Pairs without a face axis that leads out come last
            // and are searched only where nothing else gives a plane: mostly no axis leads out of them.
            faces.sort_by(|(p, _), (q, _)| q.depth().total_cmp(&p.depth()));
            for (face, [t, m]) in faces.iter() {
                let (same, pair) = (if face.is_exact { SAME_PLANE } else { DOMINATED_COSINE }, self.pair(*t, *m));
                let is_needless = match face.normal() {
                    Some(n) => self.is_held(pair, face.depth(), |d| dot(d, &n) >= same, found, scratch),
                    None => filter == AxisFilter::LeadingOut || !found.is_empty(),
                };
                if !is_needless {
                    found.extend(pair.least_depth(face, scratch).map(|d| (d, [*t, *m])));
                }
            }
        }
        found.sort_by(|(p, _), (q, _)| {
            (p.gap().total_cmp(&q.gap()))
                .then_with(|| by_coordinates(&p.normal, &q.normal))
                .then_with(|| by_coordinates(&p.point, &q.point))
        });
    }
}
