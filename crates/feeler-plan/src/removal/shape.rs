//! Directions from a part's own shape: its flat faces' normals, and the axes of its cylinders.

use std::collections::BTreeMap;

use feeler_core::geometry::vectors::{across, add, cross, dot, length, scaled, sub, unit};
use feeler_core::{weld_vertices, Point, Tool};

use super::directions::{faces_axes, Distinct};
use crate::constants::{FLAT_SHARE, MOST_CYLINDERS, MOST_CYLINDER_EDGES, MOST_FLATS, SAME_MOMENT};

/// Axes of a part, tool frame.
#[derive(Debug, Clone, Default)]
pub struct Shape {
    /// Units, each once, not its opposite.
    pub directions: Vec<Point>,
    /// Directions, and a point on each axis, metres.
    pub cylinders: Vec<(Point, Point)>,
}

impl Shape {
    /// Of a tool.
    pub fn new(tool: &Tool) -> Shape {
        let mut directions = Distinct::default();
        let (values, axes) = faces_axes(tool);
        let largest = values.iter().copied().fold(0.0, f64::max);
        // Where nothing tells them apart, as across a round part, they are any.
        let is_told = |i: usize| (0..3).all(|j| i == j || (values[i] - values[j]).abs() > SAME_MOMENT * largest);
        (0..3).filter(|i| is_told(*i)).for_each(|i| directions.push_unsigned(&axes[i]));
        flats(tool).iter().for_each(|axis| directions.push_unsigned(axis));
        if directions.0.len() < 3 {
            axes.iter().for_each(|axis| directions.push_unsigned(axis));
        }
        let edges = edges(tool);
        let mut cylinders = Vec::new();
        for along in &directions.0 {
            cylinders.extend(centres(tool, &edges, along).into_iter().map(|point| (*along, point)));
        }
        cylinders.truncate(MOST_CYLINDERS);
        Shape { directions: directions.0, cylinders }
    }
}

/// Normals of the largest flat faces, by area.
fn flats(tool: &Tool) -> Vec<Point> {
    let mesh = tool.mesh();
    let (mut areas, mut whole): (BTreeMap<[i64; 3], (f64, Point)>, f64) = (BTreeMap::new(), 0.0);
    for t in mesh.queried() {
        let [a, b, c] = mesh.triangle(t);
        let normal = cross(&sub(&b, &a), &sub(&c, &a));
        let Some(n) = unit(&normal) else { continue };
        let first = n.iter().copied().find(|x| x.abs() > 1e-6).unwrap_or(1.0);
        let n = scaled(&n, first.signum());
        let entry = areas.entry(n.map(|x| (x * 1e5).round() as i64)).or_insert((0.0, n));
        entry.0 += length(&normal);
        whole += length(&normal);
    }
    let mut all: Vec<(f64, Point)> = areas.into_values().filter(|(area, _)| *area > FLAT_SHARE * whole).collect();
    all.sort_by(|a, b| b.0.total_cmp(&a.0));
    all.into_iter().take(MOST_FLATS).map(|(_, n)| n).collect()
}

/// An edge between two triangles: its ends, and the sum of their unit normals.
struct Edge {
    ends: [Point; 2],
    out: Point,
}

/// Edges at which the surface turns by a few degrees up to a sixth of a turn, as between the facets of a cylinder.
fn edges(tool: &Tool) -> Vec<Edge> {
    let mesh = tool.mesh();
    let corners: Vec<Point> = mesh.queried().flat_map(|t| mesh.triangle(t)).collect();
    let (places, ids) = weld_vertices(&corners);
    let mut known: BTreeMap<[u32; 2], Point> = BTreeMap::new();
    let mut found = Vec::new();
    for face in ids.chunks_exact(3) {
        let [a, b, c] = [0, 1, 2].map(|k| places[face[k] as usize]);
        let Some(n) = unit(&cross(&sub(&b, &a), &sub(&c, &a))) else { continue };
        for k in 0..3 {
            let (i, j) = (face[k], face[(k + 1) % 3]);
            let Some(m) = known.insert([i.min(j), i.max(j)], n) else { continue };
            let cosine = dot(&n, &m);
            if cosine < 0.9995 && cosine > 0.45 {
                found.push(Edge { ends: [places[i as usize], places[j as usize]], out: add(&n, &m) });
            }
        }
    }
    found
}

/// Where the bisectors of the facets along a direction meet: points on the axes of cylinders, those with the most edges first.
fn centres(tool: &Tool, edges: &[Edge], along: &Point) -> Vec<Point> {
    let size = length(&tool.mesh().bounds().extent());
    let [u, v] = across(along);
    let flat = |p: &Point| [dot(p, &u), dot(p, &v)];
    let lines: Vec<([f64; 2], [f64; 2])> = edges
        .iter()
        .filter_map(|edge| {
            let run = sub(&edge.ends[1], &edge.ends[0]);
            let is_along = dot(&run, along).abs() > (1.0 - 1e-6) * length(&run) && length(&run) > 1e-6 * size;
            (is_along && dot(&edge.out, along).abs() < 1e-3).then(|| (flat(&edge.ends[0]), flat(&edge.out)))
        })
        .collect();
    let step = lines.len().div_ceil(MOST_CYLINDER_EDGES).max(1);
    let lines: Vec<_> = lines.into_iter().step_by(step).collect();
    let mut votes: BTreeMap<[i64; 2], (u32, [f64; 2])> = BTreeMap::new();
    for (i, (p, d)) in lines.iter().enumerate() {
        for (q, e) in &lines[i + 1..] {
            let turn = d[0] * e[1] - d[1] * e[0];
            if turn.abs() < 0.2 {
                continue;
            }
            let gap = [q[0] - p[0], q[1] - p[1]];
            let share = (gap[0] * e[1] - gap[1] * e[0]) / turn;
            let centre = [p[0] + share * d[0], p[1] + share * d[1]];
            let radius = |at: &[f64; 2]| (at[0] - centre[0]).hypot(at[1] - centre[1]);
            if (radius(p) - radius(q)).abs() > 1e-3 * radius(p) || radius(p) > size {
                continue;
            }
            let place = centre.map(|x| (x / (1e-4 * size)).round() as i64);
            let vote = votes.entry(place).or_insert((0, [0.0; 2]));
            vote.0 += 1;
            (0..2).for_each(|a| vote.1[a] += centre[a]);
        }
    }
    let mut all: Vec<(u32, [f64; 2])> = votes.into_values().filter(|(count, _)| *count >= 6).collect();
    all.sort_by(|a, b| b.0.cmp(&a.0).then(a.1[0].total_cmp(&b.1[0])).then(a.1[1].total_cmp(&b.1[1])));
    let middle = scaled(&add(&tool.mesh().bounds().lower, &tool.mesh().bounds().upper), 0.5);
    let height = dot(&middle, along);
    all.into_iter()
        .take(3)
        .map(|(count, sum)| {
            let [x, y] = sum.map(|s| s / f64::from(count));
            std::array::from_fn(|a| x * u[a] + y * v[a] + height * along[a])
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use feeler_shapes::cylinder;

    use super::*;

    #[test]
    fn the_axis_of_a_cylinder_that_is_not_its_middle_is_found() {
        // A shaft with a bit that sticks out.
        let (mut vertices, mut faces) = cylinder(0.01, 0.04, 24, 3);
        let base = vertices.len() as u32;
        let (bit, triangles) = feeler_shapes::box_mesh([0.0, 0.02, 0.0], [0.01, 0.03, 0.004], 1);
        vertices.extend(bit);
        faces.extend(triangles.iter().map(|t| t.map(|i| i + base)));
        let tool = Tool::new(vertices.iter().map(|p| [p[0] + 0.3, p[1] - 0.2, p[2]]).collect(), faces).unwrap();
        let shape = Shape::new(&tool);
        let (along, point) = shape.cylinders[0];
        assert!(along[0].abs() > 1.0 - 1e-9, "{along:?}");
        assert!((point[1] + 0.2).abs() < 1e-5 && point[2].abs() < 1e-5, "{point:?}");
    }
}
