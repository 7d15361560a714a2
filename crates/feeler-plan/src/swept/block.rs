//! One block: values at its nodes, which of them are inside the tool, and the surface between.

use feeler_contacts::ToolSolid;
use feeler_core::geometry::vectors::{add, cross, dot, scaled, sub};
use feeler_core::{Aabb, Point, Pose, Tool};

use super::cells::{node, place_of, surface, Piece, NODES, NODE_COUNT};
use super::hull::{Hull, Plane, Until};
use super::steps::Steps;
use crate::constants::{BLOCK, DISTANCE_TOLERANCE, HULL_SHARE, LEVEL, LONGEST_EDGE, SPACING};

/// The places of nodes, and the meaning of their values. Metres.
pub struct Grid {
    /// Its lowest node, from the steps' origin.
    pub corner: Point,
    pub spacing: f64,
    level: f64,
    /// Larger values are not distinguished: no cell on the surface has one.
    pub far: f64,
    /// Of distances.
    pub tolerance: f64,
}

impl Grid {
    /// Around a box, and how many cells along its longest side.
    pub fn around(bounds: &Aabb, error: f64) -> (Grid, f64) {
        let spacing = SPACING * error;
        let level = LEVEL * spacing;
        let tolerance = DISTANCE_TOLERANCE * error;
        let far = level + LONGEST_EDGE * spacing + HULL_SHARE * error + 4.0 * tolerance;
        // A cell of room around all that is nearer than `far`.
        let margin = far + spacing;
        let corner = std::array::from_fn(|a| bounds.lower[a] - margin);
        (Grid { corner, spacing, level, far, tolerance }, (bounds.longest() + 2.0 * margin) / spacing)
    }

    /// A node, from the steps' origin.
    pub fn place(&self, node: [u32; 3]) -> Point {
        let ([i, j, k], [x, y, z]) = (node, self.corner);
        let along = |from: f64, n: u32| from + f64::from(n) * self.spacing;
        [along(x, i), along(y, j), along(z, k)]
    }
}

/// The hulls on a grid.
pub struct Field<'a> {
    pub steps: &'a Steps,
    pub grid: &'a Grid,
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
    /// Hulls near the block and the amounts taken off distances to them, those first that are nearest its middle.
    hulls: Vec<(Hull, f64)>,
    order: Vec<(f64, u32)>,
    values: [f64; NODE_COUNT],
    is_inside: [bool; NODE_COUNT],
    is_wanted: [bool; NODE_COUNT],
    vertex_of: Vec<u32>,
    /// Nodes of one component.
    next: Vec<usize>,
}

impl Default for Scratch {
    fn default() -> Scratch {
        Scratch {
            hulls: Vec::new(),
            order: Vec::new(),
            values: [0.0; NODE_COUNT],
            is_inside: [false; NODE_COUNT],
            is_wanted: [false; NODE_COUNT],
            vertex_of: Vec::new(),
            next: Vec::new(),
        }
    }
}

impl Field<'_> {
    /// The surface in the block at a node, with the steps that are near it.
    pub fn piece(&self, at: [u32; 3], near: &[u32], scratch: &mut Scratch) -> Piece {
        self.gather(at, near, scratch);
        let Some(()) = self.tell_sides(at, scratch) else { return Piece::default() };
        self.refine(at, scratch);
        if let Some(solid) = &self.solid {
            self.fill(at, solid, scratch);
        }
        surface(&scratch.values, self.grid.level, at, &mut scratch.vertex_of)
    }

    /// The hulls, in an order in which most nodes find one that they are in soon.
    fn gather(&self, at: [u32; 3], near: &[u32], scratch: &mut Scratch) {
        let [low, high] = [at, at.map(|x| x + BLOCK as u32)].map(|node| self.grid.place(node));
        let middle: Point = std::array::from_fn(|a| 0.5 * (low[a] + high[a]));
        let until = Until { enough: f64::INFINITY, little: 0.0, tolerance: self.grid.spacing };
        scratch.order.clear();
        scratch.order.extend(near.iter().map(|step| (self.steps.hull(*step).0.distance(&middle, &until).lower, *step)));
        scratch.order.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        scratch.hulls.clear();
        scratch.hulls.extend(scratch.order.iter().map(|(_, step)| self.steps.hull(*step)));
    }

    /// Which nodes are below the level, and the values of those that are not; `None` where all are on one side.
    fn tell_sides(&self, at: [u32; 3], scratch: &mut Scratch) -> Option<()> {
        let Scratch { hulls, values, is_inside, .. } = scratch;
        values.fill(self.grid.far);
        is_inside.fill(false);
        let mut outside = NODE_COUNT;
        for (hull, slack) in hulls {
            let little = self.grid.level + *slack;
            let mut plane = Plane::default();
            self.visit(at, hull, *slack, |n, p| {
                if is_inside[n] {
                    return;
                }
                let enough = values[n] + *slack;
                if self.is_clear(hull, &plane, p, enough) {
                    return;
                }
                let distance = hull.distance(p, &Until { enough, little, tolerance: self.grid.tolerance });
                plane = distance.plane;
                values[n] = values[n].min((distance.lower - *slack).max(0.0));
                if values[n] < self.grid.level {
                    is_inside[n] = true;
                    outside -= 1;
                }
            });
            if outside == 0 {
                return None;
            }
        }
        (outside < NODE_COUNT).then_some(())
    }

    /// The values of nodes inside that have one outside around them; of others inside it does not matter.
    fn refine(&self, at: [u32; 3], scratch: &mut Scratch) {
        let Scratch { hulls, values, is_inside, is_wanted, .. } = scratch;
        is_wanted.fill(false);
        for n in (0..NODE_COUNT).filter(|n| !is_inside[*n]) {
            let [i, j, k] = place_of(n);
            let around = |x: usize| x.saturating_sub(1)..=(x + 1).min(BLOCK);
            for i in around(i) {
                for j in around(j) {
                    for k in around(k) {
                        let m = node(i, j, k);
                        if is_inside[m] && !is_wanted[m] {
                            is_wanted[m] = true;
                            values[m] = self.grid.level;
                        }
                    }
                }
            }
        }
        for (hull, slack) in hulls {
            let mut plane = Plane::default();
            self.visit(at, hull, *slack, |n, p| {
                if !is_wanted[n] || values[n] == 0.0 {
                    return;
                }
                let enough = values[n] + *slack;
                if self.is_clear(hull, &plane, p, enough) {
                    return;
                }
                let until = Until { enough, little: 0.0, tolerance: self.grid.tolerance };
                let distance = hull.distance(p, &until);
                plane = distance.plane;
                values[n] = values[n].min((distance.lower - *slack).max(0.0));
            });
        }
    }

    /// Whether a point is so far from a hull that a bound of its distance would be at least `enough`, in any block:
    /// values must not depend on that, nor on the order of hulls. `plane`: of a point beside it.
    #[inline(always)]
    fn is_clear(&self, hull: &Hull, plane: &Plane, p: &Point, enough: f64) -> bool {
        // Bounds are less than distances by up to the tolerance; and a little more for rounding.
        let clear = enough + 1.125 * self.grid.tolerance;
        plane.least_distance(p) >= clear || hull.square_to_box(p) >= clear * clear
    }

    /// All nodes of a block that may be nearer to a hull than values reach.
    #[inline]
    fn visit(&self, at: [u32; 3], hull: &Hull, slack: f64, mut visit: impl FnMut(usize, &Point)) {
        // Of nodes beyond, the box itself is too far.
        let reach = self.grid.far + slack;
        let range = |a: usize| {
            let [low, high] = [hull.bounds.lower[a] - reach, hull.bounds.upper[a] + reach]
                .map(|x| (x - self.grid.corner[a]) / self.grid.spacing - f64::from(at[a]));
            // Casts saturate.
            (low.ceil().max(0.0) as usize, (high.floor() + 1.0).min(NODES as f64).max(0.0) as usize)
        };
        let [is, js, ks] = std::array::from_fn(range).map(|(low, high)| low..high);
        for i in is {
            for j in js.clone() {
                for k in ks.clone() {
                    visit(node(i, j, k), &self.grid.place([at[0] + i as u32, at[1] + j as u32, at[2] + k as u32]));
                }
            }
        }
    }

    /// Counts nodes outside as swept where they are inside the tool: of connected ones, one is tested.
    fn fill(&self, at: [u32; 3], solid: &Solid<'_>, scratch: &mut Scratch) {
        // Nodes inside the mesh need no test, nor do those seen.
        let Scratch { values, next, is_inside: is_seen, .. } = scratch;
        for first in 0..NODE_COUNT {
            if is_seen[first] {
                continue;
            }
            let place = self.grid.place(std::array::from_fn(|a| at[a] + place_of(first)[a] as u32));
            let is_inside = solid.holds(&add(&place, &self.steps.origin));
            is_seen[first] = true;
            next.push(first);
            while let Some(n) = next.pop() {
                if is_inside {
                    values[n] = 0.0;
                }
                for (along, stride) in place_of(n).into_iter().zip([NODES * NODES, NODES, 1]) {
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

impl<'a> Solid<'a> {
    /// `None` where the tool has no closed surface.
    pub fn new(tool: &'a Tool, pose: &Pose) -> Option<Solid<'a>> {
        if tool.adjacency().outward.iter().all(|side| *side == 0) {
            return None;
        }
        let [x, y, z] = pose.rotation();
        // The columns of the inverse.
        let columns = [cross(y, z), cross(z, x), cross(x, y)];
        let determinant = dot(x, &columns[0]);
        let columns = columns.map(|c| scaled(&c, 1.0 / determinant));
        let inverse = std::array::from_fn(|i| std::array::from_fn(|j| columns[j][i]));
        Some(Solid {
            solid: ToolSolid::new(tool),
            around: tool.mesh().bounds(),
            inverse,
            translation: *pose.translation(),
        })
    }

    /// Whether a point of the world is inside.
    fn holds(&self, p: &Point) -> bool {
        let off = sub(p, &self.translation);
        let own: Point = self.inverse.map(|row| dot(&row, &off));
        (0..3).all(|a| self.around.lower[a] <= own[a] && own[a] <= self.around.upper[a])
            && !self.solid.parts_around(&own).is_empty()
    }
}
