//! Edge axes: the directions across an edge of each of two bodies, eight edges of the tool's at once.
//!
//! Separating axes of convex polyhedra are face normals and cross products of edges; of the latter only those count whose arcs on
//! the Gauss map cross (D. Gregorius: The separating axis test between convex polyhedra, GDC 2013). Deviating from that, axes
//! that lead out are kept too: bodies here are parts of surfaces, and an edge may be the border of one.

use crate::constants::AGAINST_NORMAL;
use crate::patch::body::{Body, Facet};
use crate::patch::support::{eight_heights, Eight};
use feeler_core::constants::PLAIN;
use feeler_core::geometry::bounds::Point;
use feeler_core::geometry::vectors::{cross, scaled, unit};
use feeler_lanes::{Checked, Kernel, Simd, WIDE_LANES};

/// Where the planes of two facets meet.
#[derive(Debug, Clone, Copy)]
struct Edge {
    /// Unit.
    along: Point,
    /// Perpendicular to the edge and to the normal of one facet, towards that of the other: an axis on the positive side of both is
    /// on the edge's arc of the Gauss map.
    sides: [Point; 2],
}

impl Edge {
    fn new(p: &Facet, q: &Facet) -> Option<Edge> {
        let along = unit(&cross(&p.normal, &q.normal))?;
        Some(Edge { along, sides: [cross(&along, &p.normal), cross(&q.normal, &along)] })
    }
}

/// The edges between each two facets of a body.
fn edges<'a>(body: &Body<'a>) -> impl Iterator<Item = Edge> + 'a {
    let facets = body.facets;
    let others = move |i: usize| facets[i + 1..].iter();
    facets.iter().enumerate().flat_map(move |(i, p)| others(i).filter_map(|q| Edge::new(p, q)))
}

/// Eight edges by axis.
#[derive(Debug, Default)]
struct EightEdges {
    along: Eight,
    sides: [Eight; 2],
    count: usize,
}

/// Finds edge axes. Kept as working memory.
#[derive(Debug, Default)]
pub(crate) struct EdgeAxes {
    /// The tool's body whose edges are kept, and the edges.
    of: Option<usize>,
    tool_edges: Vec<EightEdges>,
    mockup_edges: Vec<Edge>,
    axes: Vec<Point>,
}

impl EdgeAxes {
    /// For the bodies of another region.
    pub fn clear(&mut self) {
        self.of = None;
    }

    /// The axes across an edge of each that lead out by the mean normals, or lie on the arcs of both edges: then these edges hold
    /// along it, wherever most of the facets face.
    pub fn find(&mut self, lanes: Checked, tool: &Body<'_>, mockup: &Body<'_>, outward: &[Point; 2]) -> &[Point] {
        let EdgeAxes { of, tool_edges, mockup_edges, axes } = self;
        if *of != Some(tool.number) {
            *of = Some(tool.number);
            tool_edges.clear();
            for edge in edges(tool) {
                if tool_edges.last().is_none_or(|eight| eight.count == WIDE_LANES) {
                    tool_edges.push(EightEdges::default());
                }
                let Some(eight) = tool_edges.last_mut() else { continue };
                for a in 0..3 {
                    eight.along[a][eight.count] = edge.along[a];
                    (0..2).for_each(|i| eight.sides[i][a][eight.count] = edge.sides[i][a]);
                }
                eight.count += 1;
            }
        }
        mockup_edges.clear();
        mockup_edges.extend(edges(mockup));
        axes.clear();
        lanes.run(CrossEdges { tool_edges, mockup_edges, outward, out: axes });
        axes
    }
}

/// The unit cross products of each two edges, as far as they count.
struct CrossEdges<'a> {
    tool_edges: &'a [EightEdges],
    mockup_edges: &'a [Edge],
    outward: &'a [Point; 2],
    out: &'a mut Vec<Point>,
}

impl Kernel for CrossEdges<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, s: S) {
        let CrossEdges { tool_edges, mockup_edges, outward, out } = self;
        let (zero, against) = (s.wide_splat(0.0), s.wide_splat(-AGAINST_NORMAL));
        let (least, limit) = (s.wide_splat(PLAIN.start), s.wide_splat(PLAIN.end));
        let outward = [splat(s, &outward[0]), splat(s, &outward[1])];
        for e in mockup_edges {
            let (p, sides) = (splat(s, &e.along), [splat(s, &e.sides[0]), splat(s, &e.sides[1])]);
            for f in tool_edges {
                let q = [s.wide_load(&f.along[0]), s.wide_load(&f.along[1]), s.wide_load(&f.along[2])];
                let n = [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]];
                let square = n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
                // Parallel edges have no cross product, and neither have lanes beyond the last edge.
                let is_plain = s.bits(s.both(s.wide_above(square, least), s.wide_above(limit, square)));
                let mut scale = [0.0; WIDE_LANES];
                s.wide_store(square, &mut scale);
                for x in &mut scale {
                    *x = 1.0 / x.sqrt();
                }
                let scale = s.wide_load(&scale);
                let d = [n[0] * scale, n[1] * scale, n[2] * scale];
                // Along the direction, and against it.
                let (mut is_in, mut is_on_arcs) = ([0; 2], [u8::MAX; 2]);
                for out in &outward {
                    let along = d[0] * out[0] + d[1] * out[1] + d[2] * out[2];
                    is_in[0] |= !s.bits(s.wide_above(along, against));
                    is_in[1] |= !s.bits(s.wide_above(zero - against, along));
                }
                for k in 0..2 {
                    let of_mockup = d[0] * sides[k][0] + d[1] * sides[k][1] + d[2] * sides[k][2];
                    let of_tool = eight_heights(s, &f.sides[k], &d);
                    is_on_arcs[0] &= !s.bits(s.either(s.wide_above(zero, of_mockup), s.wide_above(of_tool, zero)));
                    is_on_arcs[1] &= !s.bits(s.either(s.wide_above(of_mockup, zero), s.wide_above(zero, of_tool)));
                }
                let chosen = [!is_in[0] | is_on_arcs[0], !is_in[1] | is_on_arcs[1]];
                let mut left = is_plain & (chosen[0] | chosen[1]);
                let mut stored = [[0.0; WIDE_LANES]; 3];
                (0..3).for_each(|a| s.wide_store(d[a], &mut stored[a]));
                while left != 0 {
                    let i = left.trailing_zeros();
                    left &= left - 1;
                    let d = [stored[0][i as usize], stored[1][i as usize], stored[2][i as usize]];
                    if chosen[0] >> i & 1 != 0 {
                        out.push(d);
                    }
                    if chosen[1] >> i & 1 != 0 {
                        out.push(scaled(&d, -1.0));
                    }
                }
            }
        }
    }
}

#[inline(always)]
fn splat<S: Simd>(s: S, p: &Point) -> [S::F64; 3] {
    [s.wide_splat(p[0]), s.wide_splat(p[1]), s.wide_splat(p[2])]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::depth::axis::is_leading_out;
    use feeler_core::geometry::vectors::dot;
    use feeler_lanes::Level;

    #[test]
    fn edge_axes_are_those_a_plain_loop_finds() {
        let wave = |i: usize| [(0.7 * i as f64).sin(), (1.9 * i as f64).cos(), (1.3 * i as f64).sin()];
        let is_on_arc = |e: &Edge, d: &Point| e.sides.iter().all(|side| dot(d, side) >= 0.0);
        let mut counts = [0; 3];
        for round in 0..40 {
            // Every fifth facet faces where the one before does, and some edges are parallel.
            let facet = |i: usize| Facet::looking(unit(&wave(31 * round + i - i % 5 / 4)).unwrap());
            let facets = [3 + round % 5, 1 + round % 4].map(|count| (0..count).map(facet).collect::<Vec<_>>());
            let [tool, mockup] = facets.each_ref().map(|facets| Body::of_facets(facets));
            let outward = [wave(91 + round), wave(57 + round)];
            let mut expected = Vec::new();
            for e in edges(&mockup) {
                for f in edges(&tool) {
                    let Some(d) = unit(&cross(&e.along, &f.along)) else { continue };
                    for d in [d, scaled(&d, -1.0)] {
                        let on_arcs = is_on_arc(&e, &d) && is_on_arc(&f, &scaled(&d, -1.0));
                        counts[if on_arcs { 0 } else { 1 + usize::from(is_leading_out(&d, &outward)) }] += 1;
                        if is_leading_out(&d, &outward) || on_arcs {
                            expected.push(d);
                        }
                    }
                }
            }
            for level in Level::available() {
                let mut axes = EdgeAxes::default();
                for _ in 0..2 {
                    let found = axes.find(level.checked(), &tool, &mockup, &outward);
                    assert_eq!(found, expected, "{level:?} {round}");
                }
            }
        }
        assert!(counts.iter().all(|count| *count > 30), "{counts:?}");
    }
}
