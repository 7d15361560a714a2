//! The least depth of two bodies: the axis along which the tool has to move least until a plane across it separates
//! them.
//!
//! Along a unit direction d the depth is the mock-up's support less the tool's lowest height. The least of it over all d is the
//! penetration depth of convex polyhedra (S. Cameron: Enhancing GJK, ICRA 1997), found at a face normal of one of the two or
//! across an edge of each: separating axes on the Gauss map (D. Gregorius: The separating axis test between convex polyhedra, GDC
//! 2013). For curved surfaces, which have too many edges for that, a short [`descent`](super::descent) follows.
//! Deviating from both, axes that lead in or are [blocked](super::axis_blocked) do not count, and if the triangles
//! overlap by clearly less than the depth, that [overlap](super::directional_overlap) is the depth.

use feeler_core::Point;

use crate::constants::{FILLED_SHARE, FIRST_OVERLAP_SHARE, MOST_EDGES, SHALLOWER};
use crate::context::QueryContext;
use crate::depth::axis::{BodyPair, TriedAxis};
use crate::depth::axis_blocked::BlockedAxes;
use crate::depth::axis_search::AxisSearch;
use crate::depth::directional_overlap::DirectionalOverlap;
use crate::depth::edge_axes::EdgeAxes;
use crate::depth::face_axes::{FaceAxes, FaceDepth};
use crate::depth::gauss_arcs::GaussArcs;
use crate::patch::body::Facets;

/// The least depth of a tool body in a mock-up body.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Depth {
    /// The numbers of the bodies.
    pub bodies: [usize; 2],
    /// Along its direction, the normal, the two are shallowest.
    pub(super) axis: TriedAxis,
    pub(super) overlap: Overlap,
    /// On the mock-up's side of the overlap, above the tool's lowest point.
    pub point: Point,
    /// Whether no axis can be shallower: both surfaces are flat-faced, and all candidates were tried.
    pub is_exact: bool,
}

/// How much two bodies overlap along the normal of their depth. Where that is clearly less than the depth, one reaches over a
/// hollow that the other fills, and no plane has to separate them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Overlap {
    NotAsked,
    /// By the depth, or nearly.
    Filled,
    /// At most this, metres.
    AtMost(f64),
    /// This, metres.
    Measured(f64),
}

impl Depth {
    /// Unit, from the mock-up to the tool.
    pub fn normal(&self) -> Point {
        self.axis.direction
    }

    /// How far the tool has to move along the normal until a plane across it separates the two, metres.
    pub(super) fn depth(&self) -> f64 {
        self.axis.depth()
    }

    /// The gap of its plane: negative or zero. A lower bound until the overlap is [measured](BodyPair::measure).
    pub fn gap(&self) -> f64 {
        let most = match self.overlap {
            Overlap::NotAsked | Overlap::Filled => self.depth(),
            Overlap::AtMost(overlap) | Overlap::Measured(overlap) => overlap,
        };
        -most.max(0.0)
    }

    /// Whether its gap is more than a bound.
    pub fn is_known(&self) -> bool {
        matches!(self.overlap, Overlap::Filled | Overlap::Measured(_))
    }

    /// Whether the overlap may be as much as the depth.
    pub(super) fn may_be_filled(&self) -> bool {
        matches!(self.overlap, Overlap::NotAsked | Overlap::Filled)
    }
}

/// Working memory.
#[derive(Debug, Default)]
pub(crate) struct DepthScratch {
    edge_axes: EdgeAxes,
    face_axes: FaceAxes,
    arcs: GaussArcs,
    pub(super) overlap: DirectionalOverlap,
    /// Overlaps of the tool's bodies that others were compared with, and whether nothing of the mock-up overlaps more, where that
    /// was asked.
    pub(super) asked: Vec<(OverlapKey, Option<bool>)>,
    pub(super) blocked: BlockedAxes,
}

/// A tool body, a direction, and an overlap along it.
pub(super) type OverlapKey = (usize, Point, f64);

impl DepthScratch {
    /// See [`FaceAxes::push_face_depths`].
    pub fn push_face_depths<'a>(
        &mut self,
        pairs: impl Iterator<Item = BodyPair<'a>> + Clone,
        out: &mut Vec<FaceDepth>,
    ) {
        self.face_axes.push_face_depths(pairs, &mut self.blocked, out);
    }

    /// For another region, with its numbers of bodies of tool and mock-up.
    pub fn clear(&mut self, bodies: [usize; 2]) {
        self.overlap.clear(bodies);
        self.asked.clear();
        self.edge_axes.clear();
        self.blocked.clear(bodies);
    }
}

impl BodyPair<'_> {
    /// The least depth, starting from the face depth. `None` where no axis leads out.
    pub fn least_depth(&self, face: &FaceDepth, scratch: &mut DepthScratch) -> Option<Depth> {
        let DepthScratch { edge_axes, arcs, blocked, .. } = scratch;
        let mut search = AxisSearch::new(self, blocked, face.axis);
        if (1..=MOST_EDGES).contains(&self.edge_pairs()) {
            search.offer_all(edge_axes.find(self.lanes, self.tool, self.mockup, &self.outward()));
        }
        if !face.is_exact {
            search.search_arcs(arcs);
            search.descend();
        }
        let axis = search.best?;
        let point = search.contact_point(&axis);
        Some(Depth { bodies: face.bodies, axis, overlap: Overlap::NotAsked, point, is_exact: face.is_exact })
    }

    /// Whether the two overlap along the normal by as much as they are deep. Measures at most once.
    pub fn is_filled(&self, context: &QueryContext<'_>, depth: &mut Depth, scratch: &mut DepthScratch) -> bool {
        if depth.overlap == Overlap::NotAsked {
            let enough = FILLED_SHARE * depth.depth();
            depth.overlap = Overlap::Filled;
            if depth.depth() > 0.0 {
                // From a share of it on: mostly the overlap is more, and few triangles overlap by as much.
                self.find_overlap(context, depth, FIRST_OVERLAP_SHARE * enough, enough, scratch);
            }
        }
        depth.overlap == Overlap::Filled
    }

    /// Replaces a depth by the overlap if that is less; if it is at most `least` (metres), by that bound.
    pub fn measure(&self, context: &QueryContext<'_>, depth: &mut Depth, least: f64, scratch: &mut DepthScratch) {
        self.is_filled(context, depth, scratch);
        match depth.overlap {
            Overlap::AtMost(most) if most > least => {}
            _ => return,
        }
        let enough = FILLED_SHARE * depth.depth();
        // A little below nothing, so that there is a point where they only touch too.
        let more = if least > 0.0 { least } else { -SHALLOWER * enough };
        self.find_overlap(context, depth, more, enough, scratch);
    }

    /// Looks for an overlap of more than `least`, and takes it if it is less than `enough`. Where `least` is not above zero, none
    /// found is no overlap.
    fn find_overlap(
        &self,
        context: &QueryContext<'_>,
        depth: &mut Depth,
        least: f64,
        enough: f64,
        scratch: &mut DepthScratch,
    ) {
        let found = scratch.overlap.greatest(context, &self.facets(), &depth.normal(), least, enough);
        let Some((most, at)) = found.filter(|(most, _)| *most < enough) else { return };
        depth.is_exact = false;
        if most > least {
            (depth.overlap, depth.point) = (Overlap::Measured(most), at);
        } else {
            depth.overlap = if least > 0.0 { Overlap::AtMost(least) } else { Overlap::Measured(0.0) };
        }
    }

    pub fn facets(&self) -> [Facets<'_>; 2] {
        [self.tool.whole(), self.mockup.whole()]
    }
}
