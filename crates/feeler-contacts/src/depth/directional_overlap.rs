//! The directional overlap of two bodies: how far the tool must move along one axis until none of their triangles
//! overlap.
//!
//! For two convex bodies that is the depth along the axis of least depth. Bodies whose surfaces lie in each other's
//! hollows, such as the teeth of two racks or the threads of bolt and nut, extend over these hollows: a plane between
//! them is as deep as the teeth are high, while the overlap may be a hundredth of that.
//!
//! The triangles are projected across the axis. The height of the mock-up's surface over the tool's is linear over the
//! intersection of two projected triangles, so its maximum is at a corner: a corner of one within the other, or a
//! crossing of their edges.

use std::ops::Range;

use crate::constants::{
    EDGE_ON_SINE, MOST_OVERLAP_CLIPS, MOST_OVERLAP_PAIRS, ON_EDGE_SHARE, OVERLAP_GAIN, OVERLAP_NOISE,
};
use crate::context::QueryContext;
use crate::patch::body::Facets;
use crate::patch::support::{eight_heights, highest_of_eights, Eight};
use crate::surface::Surface;
use feeler_core::geometry::bounds::{Point, Triangle};
use feeler_core::geometry::vectors::{across, cross, dot, scaled, sub};
use feeler_lanes::{Checked, Kernel, Simd, Wide, WIDE_LANES};

/// The corners of eight triangles; the last triangle is repeated where there are fewer.
type Corners = [Eight; 3];

/// Eight triangles in the frame of an axis: two coordinates across it, and the height along it.
#[derive(Debug, Clone, Default)]
struct Projected {
    corners: Corners,
    /// Their boxes across the axis.
    lower: [Wide; 2],
    upper: [Wide; 2],
    /// The height of a triangle's plane: the coordinates across times the first two, plus the last.
    plane: Eight,
    /// For each edge a vector across. Its product with the vector from the edge's first corner to a point says how far within the
    /// edge the point is, as a share of the triangle's height over that edge.
    inward: [[Wide; 2]; 3],
    /// A bit for each triangle that counts.
    lanes: u8,
}

/// Measures the overlap of two bodies, or of one and all of the other surface. Kept as working memory.
#[derive(Debug, Default)]
pub(crate) struct DirectionalOverlap {
    /// The triangles of the bodies of tool and mock-up that were asked for, wound so that they face outward, and where those of
    /// each body are; the last entry is for the whole surface.
    corners: [Vec<Corners>; 2],
    ranges: [Vec<Option<Range<usize>>>; 2],
    /// Two directions across the axis, and the axis.
    frame: [Point; 3],
    /// The triangles that count, and how many eights; those beyond are spare memory.
    projected: [(Vec<Projected>, usize); 2],
    mockup_box: AcrossBox,
}

impl DirectionalOverlap {
    /// For another region, with its numbers of bodies of tool and mock-up.
    pub fn clear(&mut self, bodies: [usize; 2]) {
        self.corners.iter_mut().for_each(Vec::clear);
        for (ranges, count) in self.ranges.iter_mut().zip(bodies) {
            ranges.clear();
            ranges.resize(count + 1, None);
        }
    }

    /// The greatest overlap of facets of tool and mock-up along an axis, metres, with the mock-up's point there; the
    /// first that is `enough`. Negative infinity if none exceeds `least`. `None` if there are too many triangles to
    /// decide.
    pub fn greatest(
        &mut self,
        context: &QueryContext<'_>,
        facets: &[Facets<'_>; 2],
        axis: &Point,
        least: f64,
        enough: f64,
    ) -> Option<(f64, Point)> {
        let [u, v] = across(axis);
        self.frame = [u, v, *axis];
        let ranges = Surface::BOTH.map(|surface| self.corners_of(context, surface, &facets[surface]));
        self.project(context.lanes, ranges, least);
        self.greatest_projected(context.lanes, least, enough)
    }

    /// Turns triangles into the frame, as far as more than `least` may overlap.
    fn project(&mut self, lanes: Checked, ranges: [Range<usize>; 2], least: f64) {
        let DirectionalOverlap { corners, frame, projected: [(of_tool, tools), (of_mockup, mockups)], .. } = self;
        let [tool, mockup] = Surface::BOTH.map(|surface| &corners[surface][ranges[surface].clone()]);
        let low = -highest_of_eights(lanes, tool.as_flattened(), &scaled(&frame[2], -1.0));
        let high = highest_of_eights(lanes, mockup.as_flattened(), &frame[2]);
        let beyond = least - high;
        let tool_box;
        (tool_box, *tools) =
            lanes.run(Project { corners: tool, frame, sense: -1.0, beyond, within: &ANYWHERE, out: of_tool });
        let beyond = least + low;
        let mockup = Project { corners: mockup, frame, sense: 1.0, beyond, within: &tool_box, out: of_mockup };
        (self.mockup_box, *mockups) = lanes.run(mockup);
    }

    /// Where the triangles of some facets are; fetches them the first time.
    fn corners_of(&mut self, context: &QueryContext<'_>, surface: Surface, of: &Facets<'_>) -> Range<usize> {
        if let Some(range) = &self.ranges[surface][of.number] {
            return range.clone();
        }
        let from = self.corners[surface].len();
        let outward = of.triangles().map(|(id, outward)| {
            let [a, b, c] = context.triangle(surface, id);
            if dot(&cross(&sub(&b, &a), &sub(&c, &a)), outward) < 0.0 {
                [a, c, b]
            } else {
                [a, b, c]
            }
        });
        push_corners(outward, &mut self.corners[surface]);
        self.ranges[surface][of.number].insert(from..self.corners[surface].len()).clone()
    }

    fn greatest_projected(&self, lanes: Checked, least: f64, enough: f64) -> Option<(f64, Point)> {
        let [tool, mockup] = self.projected.each_ref().map(|(list, count)| &list[..*count]);
        if tool.len() * WIDE_LANES * mockup.len() * WIDE_LANES > MOST_OVERLAP_PAIRS {
            return None;
        }
        let (most, [x, y, h]) = lanes.run(Greatest { tool, mockup, mockup_box: &self.mockup_box, least, enough })?;
        let [u, v, d] = &self.frame;
        Some((most, std::array::from_fn(|a| x * u[a] + y * v[a] + h * d[a])))
    }
}

/// Adds triangles in eights, corner by corner.
fn push_corners(triangles: impl Iterator<Item = Triangle>, out: &mut Vec<Corners>) {
    let mut eight = Corners::default();
    let mut count = 0;
    for triangle in triangles {
        for (corners, p) in eight.iter_mut().zip(&triangle) {
            (0..3).for_each(|a| corners[a][count] = p[a]);
        }
        count += 1;
        if count == WIDE_LANES {
            out.push(eight);
            count = 0;
        }
    }
    if count > 0 {
        for x in eight.as_flattened_mut() {
            let last = x[count - 1];
            x[count..].fill(last);
        }
        out.push(eight);
    }
}

/// A box across the axis.
#[derive(Debug, Clone, Copy, Default)]
struct AcrossBox {
    lower: [f64; 2],
    upper: [f64; 2],
}

const ANYWHERE: AcrossBox = AcrossBox { lower: [f64::NEG_INFINITY; 2], upper: [f64::INFINITY; 2] };

/// The same box in all lanes.
struct WideBox<S: Simd> {
    lower: [S::F64; 2],
    upper: [S::F64; 2],
}

impl<S: Simd> WideBox<S> {
    #[inline(always)]
    fn splat(s: S, b: &AcrossBox) -> WideBox<S> {
        WideBox {
            lower: [s.wide_splat(b.lower[0]), s.wide_splat(b.lower[1])],
            upper: [s.wide_splat(b.upper[0]), s.wide_splat(b.upper[1])],
        }
    }

    /// Which of eight boxes are disjoint from it.
    #[inline(always)]
    fn is_disjoint(&self, s: S, lower: [S::F64; 2], upper: [S::F64; 2]) -> S::M64 {
        let before = s.either(s.wide_above(self.lower[0], upper[0]), s.wide_above(self.lower[1], upper[1]));
        let behind = s.either(s.wide_above(lower[0], self.upper[0]), s.wide_above(lower[1], self.upper[1]));
        s.either(before, behind)
    }

    #[inline(always)]
    fn disjoint(&self, s: S, eight: &Projected) -> u8 {
        let lower = [s.wide_load(&eight.lower[0]), s.wide_load(&eight.lower[1])];
        let upper = [s.wide_load(&eight.upper[0]), s.wide_load(&eight.upper[1])];
        s.bits(self.is_disjoint(s, lower, upper))
    }
}

/// Turns triangles into a frame: those that face along the axis or against it, reach beyond a height in that sense, and meet a
/// box. Gives the box around them, and how many eights there are.
struct Project<'a> {
    corners: &'a [Corners],
    frame: &'a [Point; 3],
    sense: f64,
    beyond: f64,
    within: &'a AcrossBox,
    out: &'a mut Vec<Projected>,
}

impl Kernel for Project<'_> {
    type Output = (AcrossBox, usize);

    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> (AcrossBox, usize) {
        let Project { corners, frame, sense, beyond, within, out } = self;
        let (zero, sense, beyond) = (s.wide_splat(0.0), s.wide_splat(sense), s.wide_splat(beyond));
        let mut axes = [[zero; 3]; 3];
        for k in 0..3 {
            for a in 0..3 {
                axes[k][a] = s.wide_splat(frame[k][a]);
            }
        }
        let (none_lower, none_upper) = (s.wide_splat(f64::INFINITY), s.wide_splat(f64::NEG_INFINITY));
        let within = WideBox::splat(s, within);
        let (mut least, mut most) = ([none_lower; 2], [none_upper; 2]);
        let mut count = 0;
        for eight in corners {
            let mut turned = [[zero; 3]; 3];
            for c in 0..3 {
                turned[c][2] = eight_heights(s, &eight[c], &axes[2]);
            }
            let farthest = s.wide_max(s.wide_max(sense * turned[0][2], sense * turned[1][2]), sense * turned[2][2]);
            let is_beyond = s.wide_above(farthest, beyond);
            if s.bits(is_beyond) == 0 {
                continue;
            }
            for c in 0..3 {
                for k in 0..2 {
                    turned[c][k] = eight_heights(s, &eight[c], &axes[k]);
                }
            }
            let [a, b, c] = turned;
            let e = [b[0] - a[0], b[1] - a[1], b[2] - a[2]];
            let f = [c[0] - a[0], c[1] - a[1], c[2] - a[2]];
            let n = [e[1] * f[2] - e[2] * f[1], e[2] * f[0] - e[0] * f[2], e[0] * f[1] - e[1] * f[0]];
            let square = n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
            let is_facing = s.both(
                s.wide_above(sense * n[2], zero),
                s.wide_above(n[2] * n[2], square * s.wide_splat(EDGE_ON_SINE * EDGE_ON_SINE)),
            );
            let is_wanted = s.both(is_facing, is_beyond);
            let (mut lower, mut upper) = ([zero; 2], [zero; 2]);
            for k in 0..2 {
                lower[k] = s.wide_min(s.wide_min(a[k], b[k]), c[k]);
                upper[k] = s.wide_max(s.wide_max(a[k], b[k]), c[k]);
            }
            let is_outside = within.is_disjoint(s, lower, upper);
            let lanes = s.bits(is_wanted) & !s.bits(is_outside);
            if lanes == 0 {
                continue;
            }
            if count == out.len() {
                out.push(Projected::default());
            }
            // Written in place: it is large.
            let eight = &mut out[count];
            count += 1;
            eight.lanes = lanes;
            let inverse = s.wide_divide(s.wide_splat(1.0), n[2]);
            let mut height = a[2];
            for k in 0..2 {
                let slope = zero - n[k] * inverse;
                height = height - slope * a[k];
                s.wide_store(slope, &mut eight.plane[k]);
                s.wide_store(lower[k], &mut eight.lower[k]);
                s.wide_store(upper[k], &mut eight.upper[k]);
                let lower = s.choose(is_outside, none_lower, s.choose(is_wanted, lower[k], none_lower));
                let upper = s.choose(is_outside, none_upper, s.choose(is_wanted, upper[k], none_upper));
                (least[k], most[k]) = (s.wide_min(least[k], lower), s.wide_max(most[k], upper));
            }
            s.wide_store(height, &mut eight.plane[2]);
            for c in 0..3 {
                let (p, q) = (&turned[c], &turned[(c + 1) % 3]);
                s.wide_store((p[1] - q[1]) * inverse, &mut eight.inward[c][0]);
                s.wide_store((q[0] - p[0]) * inverse, &mut eight.inward[c][1]);
                for k in 0..3 {
                    s.wide_store(p[k], &mut eight.corners[c][k]);
                }
            }
        }
        let mut around = ANYWHERE;
        for k in 0..2 {
            let [mut lower, mut upper] = [[0.0; WIDE_LANES]; 2];
            s.wide_store(least[k], &mut lower);
            s.wide_store(most[k], &mut upper);
            around.lower[k] = lower.iter().fold(f64::INFINITY, |m, x| m.min(*x));
            around.upper[k] = upper.iter().fold(f64::NEG_INFINITY, |m, x| m.max(*x));
        }
        (around, count)
    }
}

/// Finds where the mock-up's surface is highest above the tool's.
struct Greatest<'a> {
    tool: &'a [Projected],
    mockup: &'a [Projected],
    mockup_box: &'a AcrossBox,
    least: f64,
    enough: f64,
}

impl Kernel for Greatest<'_> {
    type Output = Option<(f64, Point)>;

    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> Option<(f64, Point)> {
        let (mut most, mut best, mut clips) = (f64::NEG_INFINITY, [0.0; 3], 0);
        let mut limit = s.wide_splat(self.least);
        let mockup_box = WideBox::splat(s, self.mockup_box);
        for eight in self.tool {
            let mut lanes = eight.lanes & !mockup_box.disjoint(s, eight);
            while lanes != 0 {
                let t = ToolTriangle::new(s, eight, lanes.trailing_zeros() as usize);
                lanes &= lanes - 1;
                for m in self.mockup {
                    let apart = t.bounds.disjoint(s, m) | !m.lanes;
                    if apart == u8::MAX {
                        continue;
                    }
                    let above = t.heights_under(s, m);
                    let left = s.bits(s.wide_above(above.most(s), limit)) & !apart;
                    if left == 0 {
                        continue;
                    }
                    clips += 1;
                    if clips > MOST_OVERLAP_CLIPS {
                        return None;
                    }
                    let within = t.edge_distances(s, m);
                    if left & !within.apart(s) == 0 {
                        continue;
                    }
                    let shared = t.greatest_shared(s, m, &above, &within);
                    let mut more = s.bits(s.wide_above(shared.height, limit)) & left;
                    if more == 0 {
                        continue;
                    }
                    let [mut height, mut x, mut y] = [[0.0; WIDE_LANES]; 3];
                    s.wide_store(shared.height, &mut height);
                    s.wide_store(shared.at[0], &mut x);
                    s.wide_store(shared.at[1], &mut y);
                    while more != 0 {
                        let i = more.trailing_zeros() as usize;
                        more &= more - 1;
                        if height[i] > most {
                            most = height[i];
                            best = [x[i], y[i], m.plane[0][i] * x[i] + m.plane[1][i] * y[i] + m.plane[2][i]];
                        }
                    }
                    if most >= self.enough {
                        return Some((most, best));
                    }
                    limit = s.wide_splat(most + OVERLAP_GAIN * most.abs() + OVERLAP_NOISE * self.enough);
                }
            }
        }
        Some((most, best))
    }
}

/// A triangle of the tool, in all lanes.
struct ToolTriangle<S: Simd> {
    corners: [[S::F64; 3]; 3],
    bounds: WideBox<S>,
    plane: [S::F64; 3],
    inward: [[S::F64; 2]; 3],
}

/// How much higher than a triangle of the tool eight of the mock-up are, by their planes: at the corners of the one, and of the
/// others.
struct Above<S: Simd> {
    at_tool: [S::F64; 3],
    at_mockup: [S::F64; 3],
}

impl<S: Simd> Above<S> {
    /// A bound: the height between two planes is linear, so over either triangle it is greatest at a corner.
    #[inline(always)]
    fn most(&self, s: S) -> S::F64 {
        let [a, b, c] = self.at_tool;
        let [d, e, f] = self.at_mockup;
        s.wide_min(s.wide_max(s.wide_max(a, b), c), s.wide_max(s.wide_max(d, e), f))
    }
}

/// How far within each edge of eight of the mock-up each corner of a triangle of the tool is, and conversely: by corner, then
/// edge.
struct EdgeDistances<S: Simd> {
    tool_in: [[S::F64; 3]; 3],
    mockup_in: [[S::F64; 3]; 3],
}

impl<S: Simd> EdgeDistances<S> {
    /// Those apart across the axis: all corners of one are beyond an edge of the other.
    #[inline(always)]
    fn apart(&self, s: S) -> u8 {
        let mut innermost = s.wide_splat(f64::INFINITY);
        for [a, b, c] in [&self.tool_in, &self.mockup_in] {
            for e in 0..3 {
                innermost = s.wide_min(innermost, s.wide_max(s.wide_max(a[e], b[e]), c[e]));
            }
        }
        s.bits(s.wide_above(s.wide_splat(-ON_EDGE_SHARE), innermost))
    }
}

/// Where each of eight of the mock-up is highest above the tool's triangle.
struct Shared<S: Simd> {
    height: S::F64,
    at: [S::F64; 2],
}

impl<S: Simd> Shared<S> {
    #[inline(always)]
    fn offer(&mut self, s: S, is_shared: S::M64, height: S::F64, at: [S::F64; 2]) {
        let is_more = s.both(is_shared, s.wide_above(height, self.height));
        self.height = s.choose(is_more, height, self.height);
        for k in 0..2 {
            self.at[k] = s.choose(is_more, at[k], self.at[k]);
        }
    }
}

impl<S: Simd> ToolTriangle<S> {
    #[inline(always)]
    fn new(s: S, eight: &Projected, lane: usize) -> ToolTriangle<S> {
        let zero = s.wide_splat(0.0);
        let bounds = AcrossBox {
            lower: [eight.lower[0][lane], eight.lower[1][lane]],
            upper: [eight.upper[0][lane], eight.upper[1][lane]],
        };
        let bounds = WideBox::splat(s, &bounds);
        let mut one = ToolTriangle { corners: [[zero; 3]; 3], bounds, plane: [zero; 3], inward: [[zero; 2]; 3] };
        for k in 0..3 {
            one.plane[k] = s.wide_splat(eight.plane[k][lane]);
            for c in 0..3 {
                one.corners[c][k] = s.wide_splat(eight.corners[c][k][lane]);
            }
        }
        for k in 0..2 {
            for c in 0..3 {
                one.inward[c][k] = s.wide_splat(eight.inward[c][k][lane]);
            }
        }
        one
    }

    #[inline(always)]
    fn heights_under(&self, s: S, m: &Projected) -> Above<S> {
        let n = [s.wide_load(&m.plane[0]), s.wide_load(&m.plane[1]), s.wide_load(&m.plane[2])];
        let zero = s.wide_splat(0.0);
        let mut above = Above { at_tool: [zero; 3], at_mockup: [zero; 3] };
        for c in 0..3 {
            let [x, y, h] = self.corners[c];
            above.at_tool[c] = n[0] * x + n[1] * y + n[2] - h;
            let [x, y, h] = &m.corners[c];
            let under = self.plane[0] * s.wide_load(x) + self.plane[1] * s.wide_load(y) + self.plane[2];
            above.at_mockup[c] = s.wide_load(h) - under;
        }
        above
    }

    #[inline(always)]
    fn edge_distances(&self, s: S, m: &Projected) -> EdgeDistances<S> {
        let zero = s.wide_splat(0.0);
        let mut within = EdgeDistances { tool_in: [[zero; 3]; 3], mockup_in: [[zero; 3]; 3] };
        for e in 0..3 {
            let from = [s.wide_load(&m.corners[e][0]), s.wide_load(&m.corners[e][1])];
            let inward = [s.wide_load(&m.inward[e][0]), s.wide_load(&m.inward[e][1])];
            for c in 0..3 {
                let (x, y) = (self.corners[c][0], self.corners[c][1]);
                within.tool_in[c][e] = inward[0] * (x - from[0]) + inward[1] * (y - from[1]);
                let (own, inward) = (&self.corners[c], &self.inward[c]);
                within.mockup_in[e][c] = inward[0] * (from[0] - own[0]) + inward[1] * (from[1] - own[1]);
            }
        }
        within
    }

    /// The corners of what two triangles share: corners of one within the other, and crossings of their edges.
    #[inline(always)]
    fn greatest_shared(&self, s: S, m: &Projected, above: &Above<S>, within: &EdgeDistances<S>) -> Shared<S> {
        let (zero, on_edge) = (s.wide_splat(0.0), s.wide_splat(-ON_EDGE_SHARE));
        let mut shared = Shared { height: s.wide_splat(f64::NEG_INFINITY), at: [zero; 2] };
        let EdgeDistances { tool_in, mockup_in } = within;
        for c in 0..3 {
            let within = s.wide_min(s.wide_min(tool_in[c][0], tool_in[c][1]), tool_in[c][2]);
            let at = [self.corners[c][0], self.corners[c][1]];
            shared.offer(s, s.wide_above(within, on_edge), above.at_tool[c], at);
            let within = s.wide_min(s.wide_min(mockup_in[c][0], mockup_in[c][1]), mockup_in[c][2]);
            let at = [s.wide_load(&m.corners[c][0]), s.wide_load(&m.corners[c][1])];
            shared.offer(s, s.wide_above(within, on_edge), above.at_mockup[c], at);
        }
        for c in 0..3 {
            let next = (c + 1) % 3;
            let (p, q) = (&self.corners[c], &self.corners[next]);
            for e in 0..3 {
                let [from, to] = [tool_in[c][e], tool_in[next][e]];
                let crosses = s.both(
                    s.wide_above(zero, from * to),
                    s.wide_above(zero, mockup_in[e][c] * mockup_in[(e + 1) % 3][c]),
                );
                let share = s.wide_divide(from, from - to);
                let height = above.at_tool[c] + share * (above.at_tool[next] - above.at_tool[c]);
                shared.offer(s, crosses, height, [p[0] + share * (q[0] - p[0]), p[1] + share * (q[1] - p[1])]);
            }
        }
        shared
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::{at, scene, tool};
    use feeler_core::geometry::pose::Pose;
    use feeler_core::geometry::vectors::{along, normal, unit};
    use feeler_lanes::Level;
    use feeler_shapes::ridge;

    /// How high a triangle of the mock-up is above one of the tool at most, over what they share: clipped edge by edge.
    fn overlap(t: &Triangle, m: &Triangle) -> Option<f64> {
        let turned = |a: &Point, b: &Point, p: &Point| (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]);
        let height = |m: &Triangle, p: &Point| {
            let n = normal(m).unwrap();
            (dot(&n, &m[0]) - n[0] * p[0] - n[1] * p[1]) / n[2]
        };
        let sense = turned(&m[0], &m[1], &m[2]).signum();
        let mut piece = t.to_vec();
        for k in 0..3 {
            let inside = |p: &Point| sense * turned(&m[k], &m[(k + 1) % 3], p);
            let sides = (0..piece.len()).map(|i| (piece[i], piece[(i + 1) % piece.len()])).collect::<Vec<_>>();
            piece.clear();
            for (p, q) in sides {
                let (at, then) = (inside(&p), inside(&q));
                if at >= 0.0 {
                    piece.push(p);
                }
                if at * then < 0.0 {
                    piece.push(along(&p, at / (at - then), &sub(&q, &p)));
                }
            }
        }
        piece.iter().map(|p| height(m, p) - p[2]).reduce(f64::max)
    }

    #[test]
    fn every_level_finds_the_greatest_overlap_of_all_pairs() {
        let wave = |i: usize| [(0.7 * i as f64).sin(), (1.9 * i as f64).cos(), 0.3 * (1.3 * i as f64).sin()];
        let d = unit(&[0.2, -0.3, 0.9]).unwrap();
        let [u, v] = across(&d);
        let frame = [u, v, d];
        // Wound so that they face along the direction, or against it.
        let triangle = |i: usize, sense: f64| {
            let middle = wave(7 * i + 3);
            let [a, b, c] = [0, 1, 2].map(|k| along(&middle, 0.3, &wave(3 * i + k)));
            let faces = sense * dot(&normal(&[a, b, c]).unwrap(), &d);
            if faces > 0.0 {
                [a, b, c]
            } else {
                [a, c, b]
            }
        };
        let mut counts = [0; 3];
        for round in 0..60 {
            let (tools, mockups) = (1 + round % 23, 1 + 2 * round % 31);
            let tools: Vec<Triangle> = (0..tools).map(|i| triangle(100 * round + i, -1.0)).collect();
            // Every third repeated, one seen edge-on, and one that faces the other way.
            let mut mockups: Vec<Triangle> =
                (0..mockups).map(|i| triangle(9000 + 100 * round + i - i % 3, 1.0)).collect();
            let in_frame = |t: &Triangle| t.map(|p| frame.map(|x| dot(&p, &x)));
            let pairs = tools.iter().flat_map(|t| mockups.iter().map(move |m| (t, m)));
            let expected =
                pairs.filter_map(|(t, m)| overlap(&in_frame(t), &in_frame(m))).fold(f64::NEG_INFINITY, f64::max);
            mockups.extend([[[0.0; 3], d, u], triangle(9000 + round, -1.0)]);
            counts[if expected > 0.0 { 2 } else { usize::from(expected.is_finite()) }] += 1;
            let mut all = Vec::new();
            for level in Level::available() {
                let lanes = level.checked();
                let found = |least: f64, enough: f64| {
                    let mut overlap = DirectionalOverlap { frame, ..DirectionalOverlap::default() };
                    for (surface, triangles) in [&tools, &mockups].into_iter().enumerate() {
                        push_corners(triangles.iter().copied(), &mut overlap.corners[surface]);
                    }
                    overlap.project(lanes, [0..overlap.corners[0].len(), 0..overlap.corners[1].len()], least);
                    overlap.greatest_projected(lanes, least, enough).unwrap()
                };
                let most = found(f64::NEG_INFINITY, 10.0);
                let is_near = |most: f64| {
                    most == expected || (most - expected).abs() <= 2.0 * OVERLAP_GAIN * expected.abs() + 1e-7
                };
                assert!(is_near(most.0), "{level:?} {round}: {most:?} {expected}");
                let first = found(f64::NEG_INFINITY, 0.5 * expected).0;
                assert!(expected <= 0.0 || first >= 0.5 * expected, "{level:?} {round}");
                // Where only more than a least is searched: that, or nothing.
                let more = [-0.1, 0.1].map(|by| found(expected + by, 10.0));
                assert!(
                    expected.is_infinite() || is_near(more[0].0) && more[1].0 < expected,
                    "{level:?} {round} {more:?}"
                );
                all.push((most, first, more));
            }
            assert!(all.iter().all(|found| *found == all[0]), "{round}");
        }
        assert!(counts.iter().all(|count| *count > 1), "{counts:?}");
    }

    #[test]
    fn surfaces_that_lie_in_each_other_are_as_deep_as_they_overlap() {
        // Blocks with a wavy side, cut ever finer, that fit; the upper one pressed in a little.
        for n in [10, 40, 160] {
            let line: Vec<[f64; 2]> = (0..=n)
                .map(|i| -0.05 + 0.1 * f64::from(i) / f64::from(n))
                .map(|x| [x, 0.003 * (200.0 * x).sin()])
                .collect();
            let height = |p: &Point| {
                let [[x, z], [next, higher]] = *line.windows(2).rfind(|surface| surface[0][0] <= p[0]).unwrap() else {
                    unreachable!()
                };
                z + (p[0] - x) / (next - x) * (higher - z)
            };
            let (lower, upper) = (scene(ridge(&line, -0.02, 0.03, 1, 4)), tool(ridge(&line, 0.02, 0.02, 1, 3)));
            for depth in [0.0, 1e-4, 5e-4] {
                let pose = at(0.0, 0.0, -depth);
                let contacts = lower.contacts(&upper, &pose, 0.002, None).unwrap();
                let deep = contacts.planes.iter().filter(|p| p.gap <= 0.0);
                assert!(deep.clone().count() > 1, "{n} {depth}");
                // Along a normal that leans as much as the waves are steep, twice as far as straight down.
                assert!(deep.clone().all(|p| p.gap >= -2.0 * depth - 1e-6), "{n} {depth}: {:?}", contacts.depth());
                assert!(deep.clone().any(|p| p.gap <= -0.5 * depth), "{n} {depth}: {:?}", contacts.depth());
                // The point is on the lower block's surface. The depth is an overlap's, not a plane's, but in the coarsest.
                for p in deep.clone().filter(|p| p.gap < -0.5 * depth) {
                    assert!((height(&p.point) - p.point[2]).abs() < 1e-6, "{n} {depth}: {p:?}");
                }
                let out = lower.penetration(&upper, &pose, 0.002, None).unwrap();
                assert!(out.depth <= 1.5 * depth + 1e-6, "{n} {depth}: {}", out.depth);
            }
        }
    }

    #[test]
    fn the_deepest_of_several_overlaps_comes_first() {
        // The same waves, the upper ones turned a little: pressed in more from one end to the other.
        for (n, turn) in [(24, 0.002), (50, 0.002), (80, -0.003), (100, 0.003), (100, 0.004)] {
            let line: Vec<[f64; 2]> = (0..=n)
                .map(|i| -0.05 + 0.1 * f64::from(i) / f64::from(n))
                .map(|x| [x, 0.002 * (300.0 * x).sin()])
                .collect();
            let (lower, upper) = (scene(ridge(&line, -0.02, 0.03, 1, 4)), tool(ridge(&line, 0.02, 0.02, 1, 3)));
            let (sin, cos) = f64::sin_cos(turn);
            let pose =
                Pose::new(&[[cos, 0.0, sin, 0.0], [0.0, 1.0, 0.0, 0.0], [-sin, 0.0, cos, -1e-5], [0.0, 0.0, 0.0, 1.0]])
                    .unwrap();
            let contacts = lower.contacts(&upper, &pose, 0.002, None).unwrap();
            // At the end, but for the lean of the normal there.
            let deepest = 0.05 * f64::abs(turn) + 1e-5;
            let gaps: Vec<f64> = contacts.planes.iter().map(|p| p.gap).collect();
            assert!((0.955..1.01).contains(&(contacts.depth() / deepest)), "{n} {turn}: {gaps:?}");
        }
    }
}
