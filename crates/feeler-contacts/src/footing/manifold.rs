//! The contact manifolds of a free pose: the planes of all near surfaces, each with the points of the tool that carry
//! it.
//!
//! A plane separates many pairs of triangles. Where the tool's triangles lie over the mock-up's, and the other way
//! round, some points can reach the plane by a rotation of up to [`MANIFOLD_TURN`]: the lowest along a ring of
//! directions. Where both polygons overlap the plane is carried, and keeping the corners there off it keeps the
//! surfaces apart. Unlike the footing of one plane (`find.rs`) this needs no whole bodies: everything was measured when
//! the planes were found.

use feeler_core::geometry::vectors::{across, add, along, dot, scaled, sub};
use feeler_core::{Point, Triangle};
use feeler_lanes::Checked;

use super::polygon::{across_hull, clipped, half_planes, height_over, leave_out_an_edge, lowest, merge, Cutter, Foot};
use crate::constants::{FOOTING_WIDER, MANIFOLD_TURN, MOST_MANIFOLD_POINTS};
use crate::contact_plane::ContactPlane;
use crate::proximity::separating_planes::Separated;

/// A plane between the mock-up and the tool at a free pose, and the points of the tool that it carries.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Manifold {
    /// On the mock-up's surface, metres, world.
    pub point: Point,
    /// Unit, from the mock-up to the tool.
    pub normal: Point,
    /// Distance of the tool from the plane along the normal, metres.
    pub gap: f64,
    /// The part of the mock-up.
    pub part: u32,
    /// The same for the same two surfaces from pose to pose, as [`ContactPlane::id`].
    pub id: u64,
    /// A triangle of the tool and one of the mock-up that the plane is between.
    pub triangles: [u32; 2],
    points: [ManifoldPoint; MOST_MANIFOLD_POINTS],
    count: usize,
}

/// A point of the tool that is carried.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
pub struct ManifoldPoint {
    /// World, metres.
    pub point: Point,
    /// How far it is off the mock-up's surface there, along the manifold's normal, metres.
    pub gap: f64,
}

impl Manifold {
    /// One to [`MOST_MANIFOLD_POINTS`] points: where they are held off the mock-up, so is the tool, for small turns (4 mrad), as far as
    /// the mock-up's surface reaches.
    pub fn points(&self) -> &[ManifoldPoint] {
        &self.points[..self.count]
    }
}

/// The manifolds at one pose.
#[derive(Debug, Clone, Default, PartialEq)]
#[non_exhaustive]
pub struct Manifolds {
    /// The nearest first.
    pub manifolds: Vec<Manifold>,
    /// How far off all else is, metres: the margin asked for, or less where that many pairs are within it that it was halved, or
    /// that many planes that the farthest were left out.
    pub margin: f64,
}

/// The manifold of a plane, given the surfaces that it separates; `size` is the tool's length, metres.
pub(crate) fn manifold(
    lanes: Checked,
    plane: &ContactPlane,
    separated: &Separated<'_>,
    margin: f64,
    size: f64,
) -> Manifold {
    let frame = across(&plane.normal);
    let foot = |p: &Point| {
        let from = sub(p, &plane.point);
        Foot { at: frame.map(|d| dot(&from, &d)), height: dot(&from, &plane.normal) }
    };
    let feet = feet(lanes, plane, separated, margin, size, foot);
    let mut manifold = Manifold {
        point: plane.point,
        normal: plane.normal,
        gap: plane.gap,
        part: plane.part,
        id: plane.id,
        triangles: plane.carriers,
        points: [ManifoldPoint::default(); MOST_MANIFOLD_POINTS],
        count: feet.len(),
    };
    for (at, (foot, gap)) in manifold.points.iter_mut().zip(&feet) {
        let [u, v] = &frame;
        let on_plane = add(&along(&plane.point, foot.at[0], u), &scaled(v, foot.at[1]));
        *at = ManifoldPoint { point: along(&on_plane, foot.height, &plane.normal), gap: *gap };
    }
    manifold
}

/// The corners of what carries, where the lowest of the tool is over the highest of the mock-up; with the gap between the two.
fn feet(
    lanes: Checked,
    plane: &ContactPlane,
    separated: &Separated<'_>,
    margin: f64,
    size: f64,
    foot: impl Fn(&Point) -> Foot,
) -> Vec<(Foot, f64)> {
    let wider = FOOTING_WIDER * size;
    let flipped = |p: &Point| {
        let foot = foot(p);
        Foot { height: -foot.height, ..foot }
    };
    let (mut lower, mut upper) = (Polygons::default(), Polygons::default());
    separated.of_tool().for_each(|t| lower.push_low_part(t, plane.gap + margin, &foot));
    separated.of_mockup().for_each(|t| upper.push_low_part(t, margin, flipped));
    let mut cutter = Cutter::default();
    let mut over = |own: &Polygons, other: &Polygons| {
        let around = half_planes(&across_hull(&other.feet), wider);
        let mut left = Vec::with_capacity(own.feet.len());
        own.each().for_each(|polygon| cutter.cut_to(polygon, &around, &mut left));
        lowest(lanes, &left, MANIFOLD_TURN)
    };
    let highest = over(&upper, &lower);
    let mut feet = clipped(&over(&lower, &upper), &highest, wider);
    if feet.is_empty() {
        return vec![(Foot { at: [0.0; 2], height: plane.gap }, plane.gap)];
    }
    // Between two of its lowest points a round surface is lower than their line.
    let above = feet.iter().map(|foot| foot.height).fold(f64::INFINITY, f64::min) - plane.gap;
    feet.iter_mut().for_each(|foot| foot.height -= above.max(0.0));
    merge(&mut feet, 10.0 * wider);
    while feet.len() > MOST_MANIFOLD_POINTS && leave_out_an_edge(&mut feet) {}
    feet.truncate(MOST_MANIFOLD_POINTS);
    // Beyond what leans, lengthened edges lead below the plane.
    feet.iter_mut().for_each(|foot| foot.height = foot.height.max(plane.gap));
    // Where the mock-up leans away from the plane there is more room.
    feet.into_iter().map(|foot| (foot, foot.height + height_over(&highest, &foot.at).max(0.0))).collect()
}

/// Convex polygons, one after the other.
#[derive(Debug, Default)]
struct Polygons {
    feet: Vec<Foot>,
    ends: Vec<usize>,
}

impl Polygons {
    fn each(&self) -> impl Iterator<Item = &[Foot]> {
        let starts = std::iter::once(&0).chain(&self.ends);
        starts.zip(&self.ends).map(|(from, to)| &self.feet[*from..*to])
    }

    /// Adds what of a triangle is no higher than a height.
    fn push_low_part(&mut self, triangle: &Triangle, most: f64, foot: impl Fn(&Point) -> Foot) {
        let feet = triangle.each_ref().map(foot);
        if feet.iter().all(|foot| foot.height <= most) {
            self.feet.extend(feet);
        } else {
            for (i, p) in feet.iter().enumerate() {
                let q = &feet[(i + 1) % 3];
                if p.height <= most {
                    self.feet.push(*p);
                }
                if (p.height < most) != (q.height < most) && p.height != most && q.height != most {
                    self.feet.push(p.towards(q, (most - p.height) / (q.height - p.height)));
                }
            }
        }
        self.ends.push(self.feet.len());
    }
}

#[cfg(test)]
mod tests {
    use feeler_core::geometry::vectors::length;
    use feeler_core::{Pose, Tool};
    use feeler_shapes::{ball, box_mesh, cylinder, joined};

    use super::*;
    use crate::contact_plane::by_coordinates;
    use crate::tests::{at, scene, tool, Held};

    fn manifolds(held: &Held, tool: &Tool, pose: &Pose, margin: f64) -> Vec<Manifold> {
        let mut found = Manifolds::default();
        held.solver().manifolds(tool, pose, margin, &mut found).unwrap();
        assert_eq!(found.margin, margin);
        found.manifolds
    }

    fn assert_points(found: &Manifold, expected: &[Point], tolerance: f64) {
        assert!(found.points().iter().all(|p| (p.gap - found.gap).abs() < 1e-9), "{found:?}");
        let mut points: Vec<Point> = found.points().iter().map(|p| p.point).collect();
        points.sort_by(by_coordinates);
        let is_near =
            points.len() == expected.len() && points.iter().zip(expected).all(|(p, q)| length(&sub(p, q)) < tolerance);
        assert!(is_near, "{points:?}, not {expected:?}");
    }

    #[test]
    fn a_box_stands_on_its_corners_however_it_is_cut() {
        for (plate_cells, cells) in [(1, 1), (9, 1), (1, 7), (23, 5)] {
            let plate = scene(box_mesh([0.0, 0.0, -0.01], [0.1, 0.1, 0.02], plate_cells));
            let block = tool(box_mesh([0.0; 3], [0.03, 0.02, 0.04], cells));
            let [flat] = manifolds(&plate, &block, &at(0.003, 0.002, 0.0201), 0.002)[..] else { panic!() };
            let corners = [[-0.012, -0.008], [-0.012, 0.012], [0.018, -0.008], [0.018, 0.012]];
            assert_points(&flat, &corners.map(|[x, y]| [x, y, 1e-4]), 1e-6);
            assert!((flat.gap - 1e-4).abs() < 1e-12 && flat.normal == [0.0, 0.0, 1.0]);
            // A third of it beyond the plate's side, which carries no farther than it reaches.
            let over = manifolds(&plate, &block, &at(0.045, 0.002, 0.0201), 0.002);
            let corners = [[0.03, -0.008], [0.03, 0.012], [0.05, -0.008], [0.05, 0.012]];
            assert_points(&over[0], &corners.map(|[x, y]| [x, y, 1e-4]), 1e-6);
        }
    }

    #[test]
    fn a_large_plate_lies_on_a_small_post_and_on_nothing_beside_it() {
        let post = scene(box_mesh([0.01, 0.0, -0.02], [0.006, 0.004, 0.04], 3));
        let sheet = tool(box_mesh([0.0; 3], [0.1, 0.1, 0.01], 4));
        let [found] = manifolds(&post, &sheet, &at(0.0, 0.0, 0.0051), 0.002)[..] else { panic!() };
        let corners = [[0.007, -0.002], [0.007, 0.002], [0.013, -0.002], [0.013, 0.002]];
        assert_points(&found, &corners.map(|[x, y]| [x, y, 1e-4]), 1e-6);
        // The other way up a ball carries no more than its lowest points: the plate may roll on it.
        let (round, plate) = (scene(ball(0.02, 24)), tool(box_mesh([0.0; 3], [0.1, 0.1, 0.01], 4)));
        let [found] = manifolds(&round, &plate, &at(0.0, 0.0, 0.0251), 0.002)[..] else { panic!() };
        assert!(found.points().iter().all(|p| p.point[0].hypot(p.point[1]) < 0.003), "{found:?}");
    }

    #[test]
    fn a_peg_in_a_hole_is_held_along_it() {
        // Four walls around a square peg, a tenth of a millimetre off; the hole is 30 mm deep, the peg longer.
        let walls = [[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]].map(|[x, y]: [f64; 2]| {
            let size = [if x == 0.0 { 0.0202 } else { 0.01 }, if y == 0.0 { 0.0202 } else { 0.01 }, 0.03];
            box_mesh([0.0151 * x, 0.0151 * y, 0.0], size, 2)
        });
        let hole = scene(joined(walls));
        let peg = tool(box_mesh([0.0; 3], [0.02, 0.02, 0.06], 3));
        let found = manifolds(&hole, &peg, &at(0.0, 0.0, 0.02), 0.001);
        assert_eq!(found.len(), 4);
        for wall in &found {
            assert!((wall.gap - 1e-4).abs() < 1e-12);
            let heights = wall.points().iter().map(|p| p.point[2]);
            let [low, high] = [heights.clone().fold(1.0, f64::min), heights.fold(-1.0, f64::max)];
            // From the peg's end to the hole's.
            assert!((low + 0.01).abs() < 1e-6 && (high - 0.015).abs() < 1e-6 && wall.points().len() == 4, "{wall:?}");
        }
    }

    #[test]
    fn a_round_end_is_covered_by_its_points() {
        let plate = scene(box_mesh([0.0, 0.0, -0.01], [0.1, 0.1, 0.02], 5));
        let (vertices, faces) = cylinder(0.01, 0.03, 64, 2);
        let pin = tool((vertices.into_iter().map(|[x, y, z]| [y, z, x]).collect(), faces));
        let low = pin.mesh().bounds().lower[2];
        let [found] = manifolds(&plate, &pin, &at(0.0, 0.0, 2e-5 - low), 0.002)[..] else { panic!() };
        assert_eq!(found.points().len(), MOST_MANIFOLD_POINTS);
        for k in 0..64 {
            let (s, c) = (0.1 * f64::from(k)).sin_cos();
            let reach = found.points().iter().map(|p| c * p.point[0] + s * p.point[1]).fold(0.0, f64::max);
            // Not within the end, and not far beyond it.
            assert!((0.0099..0.0111).contains(&reach), "{k} {reach}");
        }
    }

    #[test]
    fn room_behind_a_leaning_wall_is_counted() {
        // A square peg that leans in its hole by less than a manifold's turn: its sides are off the walls by what it leans, deep down.
        let walls = [[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]].map(|[x, y]: [f64; 2]| {
            let size = [if x == 0.0 { 0.0206 } else { 0.01 }, if y == 0.0 { 0.0206 } else { 0.01 }, 0.03];
            box_mesh([0.01515 * x, 0.01515 * y, 0.0], size, 2)
        });
        let (hole, peg) = (scene(joined(walls)), tool(box_mesh([0.0; 3], [0.02, 0.02, 0.06], 3)));
        let (a, mut leaning) = (0.0039f64, 0);
        let (s, c) = a.sin_cos();
        // About an axis across the hole's corners, so that both pairs of walls are leant against.
        let (h, k) = (0.5f64.sqrt() * s, 0.5 * (1.0 - c));
        let rows = [[1.0 - k, k, h, 0.0], [k, 1.0 - k, -h, 0.0], [-h, h, c, 0.025], [0.0, 0.0, 0.0, 1.0]];
        let pose = Pose::new(&rows).unwrap().translated(&[-0.02 * h, 0.02 * h, 0.0]).unwrap();
        assert!(!hole.is_colliding(&peg, &pose));
        for found in manifolds(&hole, &peg, &pose, 0.001) {
            for p in found.points() {
                // Off the wall's own plane, which the peg's sides lean from.
                let axis = usize::from(found.normal[1].abs() > 0.5);
                let off = 0.01015 - p.point[axis].abs();
                assert!((p.gap - off).abs() < 3e-6, "{off} {p:?} {found:?}");
                leaning += usize::from(p.gap > found.gap + 2e-5);
            }
        }
        assert!(leaning >= 8, "{leaning}");
    }
}
