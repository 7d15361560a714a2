//! How deep two bodies are in each other along the normals of both: where the search for their least depth begins.

use std::array::from_fn;
use std::ops::Range;

use crate::constants::SHALLOWER;
use crate::depth::axis::{is_leading_out, BodyPair, TriedAxis};
use crate::depth::axis_blocked::BlockedAxes;
use crate::depth::axis_search::AxisSearch;
use crate::patch::body::{Body, MOST_EDGES, MOST_NORMALS};
use crate::patch::support::highest;
use crate::surface::Surface;
use feeler_core::geometry::bounds::Point;
use feeler_core::geometry::vectors::scaled;
use feeler_lanes::WIDE_LANES;

/// What the normals of two bodies say about their depth.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FaceDepth {
    pub(super) found: Option<TriedAxis>,
    /// As [`Depth`](super::least_depth::Depth) has it.
    pub certain: bool,
}

impl FaceDepth {
    /// Metres, at least the least depth; less than any where none of the directions leads out.
    pub fn depth(&self) -> f64 {
        self.found.map_or(f64::NEG_INFINITY, |f| f.depth())
    }

    /// The direction, if there is one.
    pub fn normal(&self) -> Option<Point> {
        self.found.map(|f| f.direction)
    }
}

/// Against a normal of a tool body.
#[derive(Debug)]
struct OfTool {
    direction: Point,
    /// How low the body is along it.
    low: f64,
    /// Whether the tool's surface goes on along it, where that was asked: it does so whatever the mock-up's body is.
    goes_on: Option<bool>,
}

/// Working memory.
#[derive(Debug, Default)]
pub(crate) struct FaceAxes {
    /// Those of the mock-up's bodies that lead out, body by body, and where those of each end.
    of_mockup: Vec<TriedAxis>,
    ends: Vec<usize>,
    of_tool: Vec<OfTool>,
    /// Those of two bodies that lead out, the mock-up's first, then those of the tool, and which these are.
    tried: Vec<TriedAxis>,
    chosen: Vec<usize>,
    depths: Vec<f64>,
}

impl FaceAxes {
    /// The least depths along a normal of either body for pairs that have the tool's body in common, in their order, with the
    /// bodies' numbers.
    pub fn push_face_depths<'a>(
        &mut self,
        pairs: impl Iterator<Item = BodyPair<'a>> + Clone,
        blocked: &mut BlockedAxes,
        out: &mut Vec<(FaceDepth, [usize; 2])>,
    ) {
        self.set(pairs.clone());
        let mut from = 0;
        for (i, pair) in pairs.enumerate() {
            let mut best = AxisSearch::new(&pair, blocked, None);
            self.try_all(&pair, from..self.ends[i]);
            self.choose(self.ends[i] - from, &mut best);
            let is_flat = |body: &Body<'_>| body.facets.len() <= MOST_NORMALS && body.facets.iter().all(|p| p.flat);
            let certain = pair.edge_pairs() <= MOST_EDGES && is_flat(pair.tool) && is_flat(pair.mockup);
            out.push((FaceDepth { found: best.found, certain }, [pair.tool.number, pair.mockup.number]));
            from = self.ends[i];
        }
    }

    /// Of pairs that have the tool's body in common. How low that is along the mock-up's is found for all of them at once: of most
    /// of the mock-up's bodies one or two lead out, and the tool's has many points.
    fn set<'a>(&mut self, pairs: impl Iterator<Item = BodyPair<'a>> + Clone) {
        let FaceAxes { of_mockup, ends, of_tool, .. } = self;
        of_mockup.clear();
        ends.clear();
        of_tool.clear();
        let Some(BodyPair { lanes, tool, .. }) = pairs.clone().next() else { return };
        let against = |(n, height): &(Point, f64)| OfTool { direction: scaled(n, -1.0), low: -height, goes_on: None };
        of_tool.extend(tool.normals.iter().map(against));
        for pair in pairs {
            let (outward, mut count) = (pair.outward(), of_mockup.len());
            of_mockup.resize(count + pair.mockup.normals.len(), TriedAxis::default());
            for (direction, height) in pair.mockup.normals {
                of_mockup[count] = TriedAxis { direction: *direction, high: *height, low: 0.0 };
                // No branch: which lead out is not to be foreseen.
                count += usize::from(is_leading_out(direction, &outward));
            }
            of_mockup.truncate(count);
            ends.push(count);
        }
        for some in of_mockup.chunks_mut(WIDE_LANES) {
            let reach = highest(lanes, tool.points, &from_fn(|i| scaled(&some[i.min(some.len() - 1)].direction, -1.0)));
            some.iter_mut().zip(reach).for_each(|(tried, height)| tried.low = -height);
        }
    }

    /// How deep two bodies are along the normals that lead out, some of those of the mock-up's bodies and those of the tool's.
    fn try_all(&mut self, pair: &BodyPair<'_>, of_mockup: Range<usize>) {
        let FaceAxes { of_mockup: all, of_tool, tried, chosen, .. } = self;
        tried.clear();
        tried.extend_from_slice(&all[of_mockup]);
        let (from, outward) = (tried.len(), pair.outward());
        tried.resize(from + of_tool.len(), TriedAxis::default());
        chosen.resize(of_tool.len().max(chosen.len()), 0);
        let mut count = 0;
        for (i, OfTool { direction, low, goes_on }) in of_tool.iter().enumerate() {
            tried[from + count] = TriedAxis { direction: *direction, high: 0.0, low: *low };
            chosen[count] = i;
            count += usize::from(is_leading_out(direction, &outward) & (*goes_on != Some(true)));
        }
        tried.truncate(from + count);
        for some in tried[from..].chunks_mut(WIDE_LANES) {
            let reach = highest(pair.lanes, pair.mockup.points, &from_fn(|i| some[i.min(some.len() - 1)].direction));
            some.iter_mut().zip(reach).for_each(|(tried, height)| tried.high = height);
        }
    }

    /// Finds the least deep of the directions tried along which nothing goes on; of several as deep the first. So many of them are
    /// the mock-up's.
    fn choose(&mut self, of_mockup: usize, best: &mut AxisSearch<'_>) {
        let FaceAxes { of_tool, tried, chosen, depths, .. } = self;
        depths.clear();
        depths.extend(tried.iter().map(TriedAxis::depth));
        loop {
            let least = depths.iter().fold(f64::INFINITY, |least, d| if *d < least { *d } else { least });
            if least <= best.noise {
                tried.iter().for_each(|t| _ = best.offer(t));
                return;
            }
            if least == f64::INFINITY {
                return;
            }
            // The least first, so that few are asked whether a surface goes on along them.
            let ties = least + best.noise + SHALLOWER * least;
            for (i, (t, depth)) in tried.iter().zip(&mut *depths).enumerate().filter(|(_, (_, d))| **d <= ties) {
                let goes_on = match i.checked_sub(of_mockup) {
                    Some(i) => of_tool[chosen[i]].goes_on(best) || best.goes_on_of(&[Surface::Mockup], t),
                    None => best.goes_on(t),
                };
                if !goes_on {
                    best.found = Some(*t);
                    return;
                }
                *depth = f64::INFINITY;
            }
        }
    }
}

impl OfTool {
    fn goes_on(&mut self, best: &mut AxisSearch<'_>) -> bool {
        *self.goes_on.get_or_insert_with(|| {
            // What counts as its lowest place depends a little on how deep a pair is: here on the body's size, the same for all.
            let high = self.low + best.pair.tool.size;
            best.goes_on_of(&[Surface::Tool], &TriedAxis { direction: self.direction, high, low: self.low })
        })
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

    fn reach(points: &[Point], d: &Point) -> f64 {
        points.iter().map(|p| dot(p, d)).fold(f64::NEG_INFINITY, f64::max)
    }

    /// Points, normals with how far the points reach along them, and the mean of these.
    struct Parts(Vec<Point>, Vec<(Point, f64)>, Point);

    impl Parts {
        /// That face along a direction, more or less.
        fn new(from: usize, points: usize, normals: usize, along: &Point) -> Parts {
            let points: Vec<Point> = (from..from + points).map(wave).collect();
            let normals = (0..normals).map(|i| unit(&add(along, &scaled(&wave(5 * i + from), 1.2))).unwrap());
            let normals: Vec<(Point, f64)> = normals.map(|n| (n, reach(&points, &n))).collect();
            let mean = unit(&normals.iter().fold([0.0; 3], |sum, (n, _)| add(&sum, n))).unwrap();
            Parts(points, normals, mean)
        }

        fn body<'a>(&'a self, number: usize, facets: &'a [Facet]) -> Body<'a> {
            let Parts(points, normals, mean) = self;
            Body { number, points, segments_of: &[(0, 0); 64], normals, mean: *mean, ..Body::of_facets(facets) }
        }
    }

    #[test]
    fn first_depths_are_those_a_loop_finds() {
        let up = [0.0, 0.0, 1.0];
        let tool = Parts::new(300, 50, 11, &scaled(&up, -1.0));
        let mockups: Vec<Parts> = (0..9).map(|k| Parts::new(40 * k, 5 + 3 * k, 1 + k, &up)).collect();
        let facets = [Facet::looking(up); 30];
        let tool_body = tool.body(0, &facets);
        let bodies: Vec<Body<'_>> = mockups.iter().enumerate().map(|(k, m)| m.body(k, &facets)).collect();
        let mut best_of = [0; 2];
        // The tool goes on along none of its normals, or along one of them.
        for end in [None].into_iter().chain(tool.1.iter().map(|(n, _)| Some(*n))) {
            let (mut regions, mut onward, mut at) = (ContactRegions::default(), None, [0.0; 3]);
            if let Some(n) = &end {
                at = *tool.0.iter().max_by(|p, q| dot(p, n).total_cmp(&dot(q, n))).unwrap();
                let face = |normal| Face { normal, ..Face::new(0, [scaled(n, 9.0); 3], true) };
                regions.faces = [vec![face(across(n)[0])], vec![face(*n)]];
                let segment = Segment { faces: [0; 2], points: (0, 1), flat: false };
                onward = Blocker::advancing(&regions, Surface::Tool, &segment, at, n);
            }
            let goes_on = |d: &Point| {
                let (against, low) = (scaled(d, -1.0), reach(&tool.0, &scaled(d, -1.0)));
                let is_on = |o: &Blocker| o.goes_on(&regions.faces[Surface::Tool], &against, low);
                dot(&at, &against) == low && onward.as_ref().is_some_and(is_on)
            };
            assert!(end.is_none_or(|n| goes_on(&scaled(&n, -1.0))));
            for lanes in Level::available().into_iter().map(Level::checked) {
                let (mut normals, mut blocked) = (FaceAxes::default(), BlockedAxes::default());
                blocked.clear([1, bodies.len()]);
                onward.iter().for_each(|onward| blocked.known[Surface::Tool][0].push(onward));
                let pairs = bodies.iter().map(|mockup| BodyPair { lanes, regions: &regions, tool: &tool_body, mockup });
                let mut found = Vec::new();
                normals.push_face_depths(pairs.clone(), &mut blocked, &mut found);
                assert_eq!(found.len(), bodies.len());
                for (k, (pair, (first, numbers))) in pairs.zip(&found).enumerate() {
                    let of_tool = tool.1.iter().map(|(n, _)| scaled(n, -1.0));
                    let of_mockup = pair.mockup.normals.iter().map(|(n, _)| *n);
                    let leading_out = |d: &Point| is_leading_out(d, &pair.outward()) && !goes_on(d);
                    let directions = of_mockup.chain(of_tool).filter(leading_out);
                    let depth = |d: &Point| reach(pair.mockup.points, d) + reach(&tool.0, &scaled(d, -1.0));
                    let best = directions.min_by(|d, e| depth(d).total_cmp(&depth(e)));
                    assert_eq!(*numbers, [0, k]);
                    assert_eq!(first.normal(), best, "{lanes:?} {k}");
                    if let Some(best) = best {
                        assert!((first.depth() - depth(&best)).abs() < 1e-12, "{lanes:?} {k}");
                    }
                    let is_tools = best.is_some_and(|best| tool.1.iter().any(|(n, _)| scaled(n, -1.0) == best));
                    best_of[usize::from(is_tools)] += 1;
                }
            }
        }
        assert!(best_of.iter().all(|count| *count > 0), "{best_of:?}");
    }
}
