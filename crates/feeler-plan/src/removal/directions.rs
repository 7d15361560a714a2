//! Directions in which a part may come straight out: from its contacts, its own shape and its neighbours' shapes.

use feeler_core::geometry::vectors::{add, cross, dot, length, scaled, sub, unit};
use feeler_core::{Point, Tool};

use crate::constants::{DIRECTION_MARGIN, MOST_DIRECTIONS, MOST_NORMALS, OPPOSING_SHARE, SAME_DIRECTION};
use crate::eigen::eigenvectors;
use crate::error::Result;
use feeler_world::Surroundings;

/// Candidates (units, world), the likely ones first.
///
/// In this order: the contact normals; the axes of the part's own faces, of its area, and of the world, both ways;
/// directions along two contact planes, such as the axis of a bore, both ways; between two contact normals.
pub fn directions(surroundings: &Surroundings) -> Result<(Vec<Point>, Vec<Wall>)> {
    let (tool, start) = (surroundings.tool(), surroundings.start());
    let margin = DIRECTION_MARGIN * surroundings.size();
    let contacts = surroundings.environment().bodies[0].solver.contacts(tool, start, margin, None)?;
    let walls = contacts.planes.iter().map(|plane| Wall { normal: plane.normal, gap: plane.gap.max(0.0) }).collect();
    let mut normals = Distinct::default();
    for plane in &contacts.planes {
        normals.push(&plane.normal);
    }
    normals.0.truncate(MOST_NORMALS);
    let normals = normals.0;
    let mut all = Distinct::default();
    normals.iter().for_each(|normal| all.push(normal));
    for axis in own_axes(tool) {
        all.push_both(&turned(start.rotation(), &axis));
    }
    (0..3).for_each(|a| all.push_both(&std::array::from_fn(|b| if a == b { 1.0 } else { 0.0 })));
    let pairs = || normals.iter().enumerate().flat_map(|(i, n)| normals[i + 1..].iter().map(move |m| (n, m)));
    pairs().for_each(|(n, m)| all.push_both(&cross(n, m)));
    pairs().for_each(|(n, m)| all.push(&add(n, m)));
    if let Some(sum) = normals.iter().copied().reduce(|sum, n| add(&sum, &n)) {
        all.push(&sum);
    }
    all.0.truncate(MOST_DIRECTIONS);
    Ok((all.0, walls))
}

/// A contact plane at the start.
#[derive(Debug, Clone, Copy)]
pub struct Wall {
    /// From the mock-up to the tool.
    normal: Point,
    /// 0 where they meet, metres.
    gap: f64,
}

impl Wall {
    /// Whether a way of this length goes through the plane. The surface may end before: such a way comes late, not never.
    pub fn opposes(&self, direction: &Point, length: f64) -> bool {
        length * dot(&self.normal, direction) < -self.gap - OPPOSING_SHARE * length
    }
}

/// Units, none twice.
#[derive(Debug, Default)]
pub struct Distinct(pub Vec<Point>);

impl Distinct {
    /// Of any length.
    pub fn push(&mut self, direction: &Point) {
        // Rounding along an axis of the world would lead off a plane that is along it.
        let Some(direction) = unit(direction).map(|d| d.map(|x| if x.abs() < 1e-9 { 0.0 } else { x })) else { return };
        if self.0.iter().all(|known| dot(known, &direction) < SAME_DIRECTION) {
            self.0.push(direction);
        }
    }

    /// Of any length, unless its opposite is there.
    pub fn push_unsigned(&mut self, direction: &Point) {
        if let Some(opposite) = unit(&scaled(direction, -1.0)) {
            if self.0.iter().all(|known| dot(known, &opposite) < SAME_DIRECTION) {
                self.push(direction);
            }
        }
    }

    /// Both ways, unless it is next to nothing.
    pub fn push_both(&mut self, direction: &Point) {
        if length(direction) > 1e-6 {
            self.push(direction);
            self.push(&scaled(direction, -1.0));
        }
    }
}

pub fn turned(rotation: &[[f64; 3]; 3], axis: &Point) -> Point {
    rotation.map(|row| dot(&row, axis))
}

/// The principal axes of the faces' normals, among which are those of cylinders, and of the area; tool frame.
fn own_axes(tool: &Tool) -> Vec<Point> {
    moments(tool).iter().flat_map(|moments| eigenvectors(moments).1).collect()
}

/// The principal axes of the faces' normals alone, with their moments.
pub fn faces_axes(tool: &Tool) -> ([f64; 3], [Point; 3]) {
    eigenvectors(&moments(tool)[0])
}

/// The second moments of the faces' normals, and of the area, tool frame.
fn moments(tool: &Tool) -> [[[f64; 3]; 3]; 2] {
    let mesh = tool.mesh();
    let (mut area, mut first) = (0.0, [0.0; 3]);
    for t in mesh.queried() {
        let [a, b, c] = mesh.triangle(t);
        let weight = length(&cross(&sub(&b, &a), &sub(&c, &a)));
        area += weight;
        first = add(&first, &scaled(&add(&add(&a, &b), &c), weight / 3.0));
    }
    let centre = scaled(&first, 1.0 / area.max(f64::MIN_POSITIVE));
    let (mut faces, mut places) = ([[0.0; 3]; 3], [[0.0; 3]; 3]);
    for t in mesh.queried() {
        let [a, b, c] = mesh.triangle(t);
        let across = cross(&sub(&b, &a), &sub(&c, &a));
        let weight = length(&across);
        let middle = sub(&scaled(&add(&add(&a, &b), &c), 1.0 / 3.0), &centre);
        for i in 0..3 {
            for j in 0..3 {
                faces[i][j] += across[i] * across[j] / weight.max(f64::MIN_POSITIVE);
                places[i][j] += weight * middle[i] * middle[j];
            }
        }
    }
    [faces, places]
}
