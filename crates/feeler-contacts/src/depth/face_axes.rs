//! Face axes: the depth of two bodies along the normals of both, where the search for their least depth begins.

use std::array::from_fn;
use std::ops::Range;

use crate::constants::{MOST_EDGES, MOST_NORMALS, SHALLOWER};
use crate::depth::axis::{is_leading_out, BodyPair, TriedAxis};
use crate::depth::axis_blocked::BlockedAxes;
use crate::depth::axis_search::AxisSearch;
use crate::patch::body::Body;
use crate::patch::support::highest;
use crate::surface::Surface;
use feeler_core::geometry::bounds::Point;
use feeler_core::geometry::vectors::scaled;
use feeler_lanes::WIDE_LANES;

/// The least depth of two bodies along a face axis: an upper bound of their least depth.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FaceDepth {
    /// The numbers of the bodies.
    pub bodies: [usize; 2],
    /// `None` where no face axis leads out.
    pub(super) axis: Option<TriedAxis>,
    /// As [`Depth`](super::least_depth::Depth) has it.
    pub is_exact: bool,
}

impl FaceDepth {
    /// Metres; less than any depth if there is no axis.
    pub fn depth(&self) -> f64 {
        self.axis.map_or(f64::NEG_INFINITY, |f| f.depth())
    }
}

/// The axis against a normal of a tool body.
#[derive(Debug)]
struct ToolAxis {
    direction: Point,
    /// Height of the body's lowest point along it.
    low: f64,
    /// Whether the tool's own surface blocks it, where that was asked: the mock-up's body has no part in that.
    is_blocked: Option<bool>,
}

impl ToolAxis {
    fn is_blocked(&mut self, search: &mut AxisSearch<'_>) -> bool {
        *self.is_blocked.get_or_insert_with(|| {
            // What counts as extreme depends a little on how deep a pair is: here on the body's size, the same for all pairs.
            let high = self.low + search.pair.tool.size;
            let tried = TriedAxis { direction: self.direction, high, low: self.low };
            search.is_blocked_by(&[Surface::Tool], &tried)
        })
    }
}

/// Finds face depths. Kept as working memory.
#[derive(Debug, Default)]
pub(crate) struct FaceAxes {
    /// Normals of the mock-up's bodies that lead out, body by body, and where those of each body end.
    mockup_axes: Vec<TriedAxis>,
    ends: Vec<usize>,
    tool_axes: Vec<ToolAxis>,
    /// The axes of one pair that lead out, the mock-up's first; and of those of the tool, which they are.
    tried: Vec<TriedAxis>,
    chosen: Vec<usize>,
    depths: Vec<f64>,
}

impl FaceAxes {
    /// Adds the face depths of pairs that share a tool body, in their order.
    pub fn push_face_depths<'a>(
        &mut self,
        pairs: impl Iterator<Item = BodyPair<'a>> + Clone,
        blocked: &mut BlockedAxes,
        out: &mut Vec<FaceDepth>,
    ) {
        self.gather(pairs.clone());
        let mut from = 0;
        for (i, pair) in pairs.enumerate() {
            let mut search = AxisSearch::new(&pair, blocked, None);
            self.measure(&pair, from..self.ends[i]);
            self.choose(self.ends[i] - from, &mut search);
            let is_flat = |body: &Body<'_>| body.facets.len() <= MOST_NORMALS && body.facets.iter().all(|p| p.flat);
            let is_exact = pair.edge_pairs() <= MOST_EDGES && is_flat(pair.tool) && is_flat(pair.mockup);
            out.push(FaceDepth { bodies: [pair.tool.number, pair.mockup.number], axis: search.best, is_exact });
            from = self.ends[i];
        }
    }

    /// The axes of pairs that share a tool body. The tool's support along those of the mock-up is found for all pairs at once:
    /// of most of the mock-up's bodies one or two normals lead out, and the tool's has many points.
    fn gather<'a>(&mut self, pairs: impl Iterator<Item = BodyPair<'a>> + Clone) {
        let FaceAxes { mockup_axes, ends, tool_axes, .. } = self;
        mockup_axes.clear();
        ends.clear();
        tool_axes.clear();
        let Some(BodyPair { lanes, tool, .. }) = pairs.clone().next() else { return };
        let against =
            |(n, height): &(Point, f64)| ToolAxis { direction: scaled(n, -1.0), low: -height, is_blocked: None };
        tool_axes.extend(tool.normals.iter().map(against));
        for pair in pairs {
            let (outward, mut count) = (pair.outward(), mockup_axes.len());
            mockup_axes.resize(count + pair.mockup.normals.len(), TriedAxis::default());
            for (direction, height) in pair.mockup.normals {
                mockup_axes[count] = TriedAxis { direction: *direction, high: *height, low: 0.0 };
                // No branch: it could not be predicted.
                count += usize::from(is_leading_out(direction, &outward));
            }
            mockup_axes.truncate(count);
            ends.push(count);
        }
        for some in mockup_axes.chunks_mut(WIDE_LANES) {
            let reach = highest(lanes, tool.points, &from_fn(|i| scaled(&some[i.min(some.len() - 1)].direction, -1.0)));
            some.iter_mut().zip(reach).for_each(|(tried, height)| tried.low = -height);
        }
    }

    /// The depths of one pair along the normals of both that lead out, a range of those of the mock-up's bodies.
    fn measure(&mut self, pair: &BodyPair<'_>, of_mockup: Range<usize>) {
        let FaceAxes { mockup_axes, tool_axes, tried, chosen, .. } = self;
        tried.clear();
        tried.extend_from_slice(&mockup_axes[of_mockup]);
        let (from, outward) = (tried.len(), pair.outward());
        tried.resize(from + tool_axes.len(), TriedAxis::default());
        chosen.resize(tool_axes.len().max(chosen.len()), 0);
        let mut count = 0;
        for (i, ToolAxis { direction, low, is_blocked }) in tool_axes.iter().enumerate() {
            tried[from + count] = TriedAxis { direction: *direction, high: 0.0, low: *low };
            chosen[count] = i;
            count += usize::from(is_leading_out(direction, &outward) & (*is_blocked != Some(true)));
        }
        tried.truncate(from + count);
        for some in tried[from..].chunks_mut(WIDE_LANES) {
            let reach = highest(pair.lanes, pair.mockup.points, &from_fn(|i| some[i.min(some.len() - 1)].direction));
            some.iter_mut().zip(reach).for_each(|(tried, height)| tried.high = height);
        }
    }

    /// Finds the axis of least depth that is not blocked, the first of several as deep. The first `of_mockup` axes are the
    /// mock-up's.
    fn choose(&mut self, of_mockup: usize, search: &mut AxisSearch<'_>) {
        let FaceAxes { tool_axes, tried, chosen, depths, .. } = self;
        depths.clear();
        depths.extend(tried.iter().map(TriedAxis::depth));
        loop {
            let least = depths.iter().fold(f64::INFINITY, |least, d| if *d < least { *d } else { least });
            if least <= search.noise {
                tried.iter().for_each(|t| _ = search.offer(t));
                return;
            }
            if least == f64::INFINITY {
                return;
            }
            // The least first, so that few are asked whether they are blocked.
            let ties = least + search.noise + SHALLOWER * least;
            for (i, (t, depth)) in tried.iter().zip(&mut *depths).enumerate().filter(|(_, (_, d))| **d <= ties) {
                let is_blocked = match i.checked_sub(of_mockup) {
                    Some(i) => tool_axes[chosen[i]].is_blocked(search) || search.is_blocked_by(&[Surface::Mockup], t),
                    None => search.is_blocked(t),
                };
                if !is_blocked {
                    search.best = Some(*t);
                    return;
                }
                *depth = f64::INFINITY;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contour::contact_region::{ContactRegions, Face, Segment};
    use crate::depth::axis_blocked::Blocker;
    use crate::patch::body::Facet;
    use feeler_core::geometry::vectors::{across, add, dot, unit};
    use feeler_lanes::Level;

    fn wave(i: usize) -> Point {
        [(0.7 * i as f64).sin(), (1.9 * i as f64).cos(), (0.3 * i as f64).sin()]
    }

    fn support(points: &[Point], d: &Point) -> f64 {
        points.iter().map(|p| dot(p, d)).fold(f64::NEG_INFINITY, f64::max)
    }

    /// Points, normals with the points' support along them, and the mean normal.
    struct Shape(Vec<Point>, Vec<(Point, f64)>, Point);

    impl Shape {
        /// Facing along a direction, more or less.
        fn new(from: usize, points: usize, normals: usize, along: &Point) -> Shape {
            let points: Vec<Point> = (from..from + points).map(wave).collect();
            let normals = (0..normals).map(|i| unit(&add(along, &scaled(&wave(5 * i + from), 1.2))).unwrap());
            let normals: Vec<(Point, f64)> = normals.map(|n| (n, support(&points, &n))).collect();
            let mean = unit(&normals.iter().fold([0.0; 3], |sum, (n, _)| add(&sum, n))).unwrap();
            Shape(points, normals, mean)
        }

        fn body<'a>(&'a self, number: usize, facets: &'a [Facet]) -> Body<'a> {
            let Shape(points, normals, mean) = self;
            Body { number, points, segments_of: &[(0, 0); 64], normals, mean: *mean, ..Body::of_facets(facets) }
        }
    }

    #[test]
    fn face_depths_are_those_a_plain_loop_finds() {
        let up = [0.0, 0.0, 1.0];
        let tool = Shape::new(300, 50, 11, &scaled(&up, -1.0));
        let mockups: Vec<Shape> = (0..9).map(|k| Shape::new(40 * k, 5 + 3 * k, 1 + k, &up)).collect();
        let facets = [Facet::looking(up); 30];
        let tool_body = tool.body(0, &facets);
        let bodies: Vec<Body<'_>> = mockups.iter().enumerate().map(|(k, m)| m.body(k, &facets)).collect();
        let mut best_of = [0; 2];
        // The tool blocks none of its own normals, or one of them.
        for end in [None].into_iter().chain(tool.1.iter().map(|(n, _)| Some(*n))) {
            let (mut regions, mut blocker, mut at) = (ContactRegions::default(), None, [0.0; 3]);
            if let Some(n) = &end {
                at = *tool.0.iter().max_by(|p, q| dot(p, n).total_cmp(&dot(q, n))).unwrap();
                let face = |normal| Face { normal, ..Face::new(0, [scaled(n, 9.0); 3], true) };
                regions.faces = [vec![face(across(n)[0])], vec![face(*n)]];
                let segment = Segment { faces: [0; 2], points: (0, 1), flat: false };
                blocker = Blocker::at_segment(&regions, Surface::Tool, &segment, at, n);
            }
            let is_blocked = |d: &Point| {
                let (against, low) = (scaled(d, -1.0), support(&tool.0, &scaled(d, -1.0)));
                let is_blocking = |b: &Blocker| b.is_blocking(&regions.faces[Surface::Tool], &against, low);
                dot(&at, &against) == low && blocker.as_ref().is_some_and(is_blocking)
            };
            assert!(end.is_none_or(|n| is_blocked(&scaled(&n, -1.0))));
            for lanes in Level::available().into_iter().map(Level::checked) {
                let (mut axes, mut blocked) = (FaceAxes::default(), BlockedAxes::default());
                blocked.clear([1, bodies.len()]);
                blocker.iter().for_each(|b| blocked.known[Surface::Tool][0].push(b));
                let pairs = bodies.iter().map(|mockup| BodyPair { lanes, regions: &regions, tool: &tool_body, mockup });
                let mut found = Vec::new();
                axes.push_face_depths(pairs.clone(), &mut blocked, &mut found);
                assert_eq!(found.len(), bodies.len());
                for (k, (pair, face)) in pairs.zip(&found).enumerate() {
                    let of_tool = tool.1.iter().map(|(n, _)| scaled(n, -1.0));
                    let of_mockup = pair.mockup.normals.iter().map(|(n, _)| *n);
                    let leading_out = |d: &Point| is_leading_out(d, &pair.outward()) && !is_blocked(d);
                    let directions = of_mockup.chain(of_tool).filter(leading_out);
                    let depth = |d: &Point| support(pair.mockup.points, d) + support(&tool.0, &scaled(d, -1.0));
                    let best = directions.min_by(|d, e| depth(d).total_cmp(&depth(e)));
                    assert_eq!(face.bodies, [0, k]);
                    assert_eq!(face.axis.map(|a| a.direction), best, "{lanes:?} {k}");
                    if let Some(best) = best {
                        assert!((face.depth() - depth(&best)).abs() < 1e-12, "{lanes:?} {k}");
                    }
                    let is_tools = best.is_some_and(|best| tool.1.iter().any(|(n, _)| scaled(n, -1.0) == best));
                    best_of[usize::from(is_tools)] += 1;
                }
            }
        }
        assert!(best_of.iter().all(|count| *count > 0), "{best_of:?}");
    }
}
