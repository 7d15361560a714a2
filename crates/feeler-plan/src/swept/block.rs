//! One block: values at its nodes, what of them is inside the tool, and the surface between.

use feeler_core::{Aabb, Point, Pose};
use feeler_contacts::ToolSolid;

use super::cells::{node, surface, Piece, NODES, NODE_COUNT};
use super::constants::BLOCK;
use super::hull::distance_point_hull;
use super::steps::{box_around, Steps};

/// Lengths in metres.
pub struct Field<'a> {
    pub steps: &'a Steps<'a>,
    /// The grid's origin, from the steps' origin.
    pub corner: Point,
    pub spacing: f64,
    pub level: f64,
    /// Values beyond are not told apart: no cell that the surface passes has one.
    pub far: f64,
    pub tolerance: f64,
    /// Where the tool has closed surfaces.
    pub solid: Option<Solid<'a>>,
}

/// The tool's closed surfaces at one pose.
pub struct Solid<'a> {
    solid: ToolSolid<'a>,
    around: Aabb,
    /// To the tool's frame: the inverse of a matrix that is a rotation within rounding only.
    inverse: [Point; 3],
    translation: Point,
}

/// Working memory.
pub struct Scratch {
    values: [f64; NODE_COUNT],
    vertex_of: Vec<u32>,
    /// Nodes of one component.
    next: Vec<usize>,
    is_seen: [bool; NODE_COUNT],
}

impl Default for Scratch {
    fn default() -> Scratch {
        Scratch { values: [0.0; NODE_COUNT], vertex_of: Vec::new(), next: Vec::new(), is_seen: [false; NODE_COUNT] }
    }
}

impl Field<'_> {
    /// A node of the grid, from the steps' origin.
    pub fn place(&self, node: [u32; 3]) -> Point {
        std::array::from_fn(|a| self.corner[a] + f64::from(node[a]) * self.spacing)
    }

    /// The surface in the block at a node, with the steps that are near it.
    pub fn piece(&self, at: [u32; 3], near: &[u32], scratch: &mut Scratch) -> Piece {
        scratch.values.fill(self.far);
        for step in near {
            self.apply(at, *step, &mut scratch.values);
        }
        let inside = scratch.values.iter().filter(|value| **value < self.level).count();
        if inside == 0 || inside == NODE_COUNT {
            return Piece::default();
        }
        if let Some(solid) = &self.solid {
            self.fill(at, solid, scratch);
        }
        surface(&scratch.values, self.level, at, &mut scratch.vertex_of)
    }

    /// Lowers the values at the nodes near a hull to the distance to it.
    fn apply(&self, at: [u32; 3], step: u32, values: &mut [f64; NODE_COUNT]) {
        let step = &self.steps.steps[step as usize];
        let (corners, slack) = (self.steps.corners(step), f64::from(step.slack));
        let bounds = box_around(&corners);
        // Of nodes beyond, the box itself is too far.
        let reach = self.far + slack;
        let range = |a: usize| {
            let [low, high] = [bounds.lower[a] - reach, bounds.upper[a] + reach]
                .map(|x| (x - self.corner[a]) / self.spacing - f64::from(at[a]));
            (low.ceil().max(0.0) as usize, high.floor().min(BLOCK as f64))
        };
        let ranges: [_; 3] = std::array::from_fn(range);
        if ranges.iter().any(|(low, high)| *high < *low as f64) {
            return;
        }
        let ranges = ranges.map(|(low, high)| low..=high as usize);
        for i in ranges[0].clone() {
            for j in ranges[1].clone() {
                for k in ranges[2].clone() {
                    let value = &mut values[node(i, j, k)];
                    if *value == 0.0 {
                        continue;
                    }
                    let p = self.place([at[0] + i as u32, at[1] + j as u32, at[2] + k as u32]);
                    let enough = *value + slack;
                    if square_to_box(&p, &bounds) >= enough * enough {
                        continue;
                    }
                    let distance = distance_point_hull(&p, &corners, enough, self.tolerance);
                    *value = value.min((distance - slack).max(0.0));
                }
            }
        }
    }

    /// Counts nodes outside as swept where they are inside the tool: of those that hang together, one is asked.
    fn fill(&self, at: [u32; 3], solid: &Solid<'_>, scratch: &mut Scratch) {
        let Scratch { values, next, is_seen, .. } = scratch;
        for (seen, value) in is_seen.iter_mut().zip(values.iter()) {
            *seen = *value < self.level;
        }
        for i in 0..NODES {
            for j in 0..NODES {
                for k in 0..NODES {
                    if is_seen[node(i, j, k)] {
                        continue;
                    }
                    let place = self.place([at[0] + i as u32, at[1] + j as u32, at[2] + k as u32]);
                    let origin = &self.steps.origin;
                    let is_inside = solid.holds(&std::array::from_fn(|a| place[a] + origin[a]));
                    is_seen[node(i, j, k)] = true;
                    next.push(node(i, j, k));
                    while let Some(n) = next.pop() {
                        if is_inside {
                            values[n] = 0.0;
                        }
                        let place = [n / (NODES * NODES), n / NODES % NODES, n % NODES];
                        for (along, stride) in place.into_iter().zip([NODES * NODES, NODES, 1]) {
                            let around = [(along > 0).then(|| n - stride), (along < BLOCK).then(|| n + stride)];
                            for m in around.into_iter().flatten() {
                                if !is_seen[m] {
                                    is_seen[m] = true;
                                    next.push(m);
                                }
                            }
                        }
                    }
                }
            }
        }
    }
}

impl<'a> Solid<'a> {
    /// `None` where the tool has no closed surface.
    pub fn new(tool: &'a feeler_core::Tool, pose: &Pose) -> Option<Solid<'a>> {
        use feeler_core::geometry::vectors::{cross, dot, scaled};
        if tool.adjacency().outward.iter().all(|side| *side == 0) {
            return None;
        }
        let [x, y, z] = pose.rotation();
        // The columns of the inverse.
        let columns = [cross(y, z), cross(z, x), cross(x, y)];
        let determinant = dot(x, &columns[0]);
        let columns = columns.map(|c| scaled(&c, 1.0 / determinant));
        let inverse = std::array::from_fn(|i| std::array::from_fn(|j| columns[j][i]));
        Some(Solid { solid: ToolSolid::new(tool), around: tool.mesh().bounds(), inverse, translation: *pose.translation() })
    }

    /// Whether a point of the world is inside.
    fn holds(&self, p: &Point) -> bool {
        let off: Point = std::array::from_fn(|a| p[a] - self.translation[a]);
        let own: Point = std::array::from_fn(|i| (0..3).map(|j| self.inverse[i][j] * off[j]).sum());
        (0..3).all(|a| self.around.lower[a] <= own[a] && own[a] <= self.around.upper[a])
            && !self.solid.parts_around(&own).is_empty()
    }
}

/// The squared distance of a point to a box.
pub fn square_to_box(p: &Point, b: &Aabb) -> f64 {
    (0..3).map(|a| (b.lower[a] - p[a]).max(p[a] - b.upper[a]).max(0.0).powi(2)).sum()
}
