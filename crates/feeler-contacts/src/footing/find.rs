//! The footing of a contact plane: up to four points of the tool that carry the contact, so that a control loop which
//! keeps them in front of the plane keeps the whole surface there.
//!
//! A rotation by up to [`FOOTING_TURN`] can bring to the plane only points that are lowest along some direction within
//! that angle of the normal. The support points of the convex bodies in contact, along a ring of such directions,
//! therefore span the footing of the tool and that of the mock-up; their intersection (Sutherland, Hodgman 1974, across
//! the normal) carries. If it has more than four corners, edges are removed one after the other: the one whose
//! neighbours, lengthened, add the least area. So the reduced footing always contains the full one.

use std::collections::HashSet;
use std::sync::Arc;

use feeler_core::constants::NONE;
use feeler_core::geometry::vectors::{across, add, along, dot, scaled, sub};
use feeler_core::mesh::topology::adjacency::Adjacency;
use feeler_core::{Mockup, Point, Pose, Scene, Tool, Triangle};

use super::polygon::{
    across_hull, clipped, cut_to, half_planes, height_in_triangle, leave_out_an_edge, lowest, merge, Foot,
};
use crate::constants::{
    FOOTING_FEW_ASKED, FOOTING_LOW, FOOTING_MOST_ASKED, FOOTING_OFF, FOOTING_TURN, FOOTING_WIDER, MOST_FOOTING,
};
use crate::contact_plane::ContactPlane;

/// Points that carry a contact.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Footing {
    points: [Point; MOST_FOOTING],
    count: usize,
}

impl Footing {
    /// One to four points, tool frame, metres, in order around the normal.
    pub fn points(&self) -> &[Point] {
        &self.points[..self.count]
    }
}

/// The footing of a plane that was found for a tool at a pose.
pub(crate) fn footing(scene: &Scene, tool: &Tool, pose: &Pose, plane: &ContactPlane) -> Footing {
    let frame = Frame::new(pose, plane);
    let feet = frame.feet(scene, tool, plane).unwrap_or_else(|| vec![Foot { at: [0.0; 2], height: plane.gap }]);
    let mut footing = Footing { points: [[0.0; 3]; MOST_FOOTING], count: feet.len() };
    for (point, foot) in footing.points.iter_mut().zip(&feet) {
        *point = frame.point(foot);
    }
    footing
}

/// The plane in the tool's frame.
struct Frame<'a> {
    pose: &'a Pose,
    at: Point,
    normal: Point,
    /// Two directions across the normal.
    across: [Point; 2],
}

impl Frame<'_> {
    fn new<'a>(pose: &'a Pose, plane: &ContactPlane) -> Frame<'a> {
        let normal = turned_back(pose, &plane.normal);
        Frame { pose, at: into_tool(pose, &plane.point), normal, across: across(&normal) }
    }

    /// A point of the tool's frame.
    fn foot(&self, p: &Point) -> Foot {
        let from = sub(p, &self.at);
        Foot { at: self.across.map(|d| dot(&from, &d)), height: dot(&from, &self.normal) }
    }

    fn point(&self, foot: &Foot) -> Point {
        let [u, v] = &self.across;
        along(&add(&along(&self.at, foot.at[0], u), &scaled(v, foot.at[1])), foot.height, &self.normal)
    }

    /// `None` where what carries the plane does not end at it: where the surfaces lie in each other's hollows.
    fn feet(&self, scene: &Scene, tool: &Tool, plane: &ContactPlane) -> Option<Vec<Foot>> {
        let size = tool.mesh().bounds().longest();
        let off = FOOTING_OFF * size + 1e-12 * scene.mockup().mesh().bounds().largest_coordinate();
        let (wider, lanes) = (FOOTING_WIDER * size, scene.index().lanes());
        let [lower, upper] = [self.of_tool(tool, plane), self.of_mockup(scene.mockup(), plane)];
        let levels = [plane.gap, 0.0];
        let whole = [&lower, &upper].map(|surface| surface.outline());
        let ends = |feet: &[Foot], level: f64| {
            let lowest = feet.iter().map(|foot| foot.height).fold(f64::INFINITY, f64::min);
            (lowest - level).abs() <= off
        };
        let mut sides = [Vec::new(), Vec::new()];
        for (i, surface) in [&lower, &upper].into_iter().enumerate() {
            // A body that ends at the plane is taken as a whole; of others the part over the other's outline.
            let is_whole = ends(&whole[i], levels[i]);
            let over = || surface.over(&half_planes(&across_hull(&whole[1 - i]), wider));
            sides[i] =
                if is_whole { lowest(lanes, &whole[i], FOOTING_TURN) } else { lowest(lanes, &over(), FOOTING_TURN) };
        }
        let mut feet = clipped(&sides[0], &sides[1], wider);
        if feet.is_empty() {
            let over = lower.over(&half_planes(&across_hull(&whole[1]), wider));
            sides[0] = lowest(lanes, &over, FOOTING_TURN);
            feet = clipped(&sides[0], &sides[1], wider);
        }
        if !ends(&feet, levels[0]) || !ends(&sides[1], levels[1]) {
            return None;
        }
        merge(&mut feet, 10.0 * wider);
        let common = feet.clone();
        while feet.len() > MOST_FOOTING && leave_out_an_edge(&mut feet) {}
        settle(&mut feet, &common, &sides[0]);
        let lowest = feet.iter().map(|foot| foot.height).fold(f64::INFINITY, f64::min);
        if feet.len() > MOST_FOOTING || common.len() > MOST_FOOTING && lowest < plane.gap - FOOTING_LOW * size {
            // Beyond what leans, lengthened edges lead below the plane.
            feet = rectangle(&common);
            settle(&mut feet, &common, &sides[0]);
        }
        Some(feet)
    }

    fn of_tool<'a>(&'a self, tool: &'a Tool, plane: &ContactPlane) -> Carrier<'a> {
        let adjacency = tool.adjacency();
        Carrier {
            adjacency,
            seeds: seeds(adjacency, plane.carriers[0], &plane.tool_triangles),
            outline: Box::new(|t| tool.body_outline(t)),
            corners: Box::new(|t| tool.mesh().triangle(t)),
            foot: Box::new(|p| self.foot(p)),
        }
    }

    /// The other way up: its highest points are lowest.
    fn of_mockup<'a>(&'a self, mockup: &'a Mockup, plane: &ContactPlane) -> Carrier<'a> {
        let adjacency = mockup.adjacency();
        let turned = |p: &Point| {
            let foot = self.foot(&into_tool(self.pose, p));
            Foot { height: -foot.height, ..foot }
        };
        Carrier {
            adjacency,
            seeds: seeds(adjacency, plane.carriers[1], &plane.mockup_triangles),
            outline: Box::new(|t| mockup.body_outline(t)),
            corners: Box::new(|t| mockup.mesh().triangle(t)),
            foot: Box::new(turned),
        }
    }
}

/// A triangle of each body behind a plane, the carrier's first.
fn seeds(adjacency: &Adjacency, carrier: u32, others: &[u32]) -> Vec<u32> {
    let mut seeds: Vec<u32> = Vec::new();
    for t in std::iter::once(carrier).chain(others.iter().copied()) {
        if !seeds.iter().any(|s| adjacency.body_of(*s) == adjacency.body_of(t)) {
            seeds.push(t);
        }
    }
    seeds
}

/// One of the two surfaces of a plane: the bodies that it has there.
struct Carrier<'a> {
    adjacency: &'a Adjacency,
    seeds: Vec<u32>,
    outline: Box<dyn Fn(u32) -> Arc<[Point]> + 'a>,
    corners: Box<dyn Fn(u32) -> Triangle + 'a>,
    foot: Box<dyn Fn(&Point) -> Foot + 'a>,
}

impl Carrier<'_> {
    /// The points that span the body of the first.
    fn outline(&self) -> Vec<Foot> {
        (self.outline)(self.seeds[0]).iter().map(|p| (self.foot)(p)).collect()
    }

    /// The corners of what of the bodies' triangles is within some half-planes.
    fn over(&self, within: &[([f64; 2], f64)]) -> Vec<Foot> {
        let is_own = |t: u32| self.seeds.iter().any(|s| self.adjacency.body_of(*s) == self.adjacency.body_of(t));
        let (mut next, mut found) = (self.seeds.clone(), Vec::new());
        let mut seen: HashSet<u32> = next.iter().copied().collect();
        while let Some(t) = next.pop() {
            let feet = (self.corners)(t).map(|p| (self.foot)(&p));
            let inside = cut_to(&feet, within);
            // Where nothing of a triangle is within, its neighbours are tested all the same as long as few were.
            if !inside.is_empty() || seen.len() < FOOTING_FEW_ASKED {
                let beside = self.adjacency.neighbours[t as usize].into_iter().filter(|n| *n != NONE);
                next.extend(beside.filter(|n| is_own(*n) && seen.len() < FOOTING_MOST_ASKED && seen.insert(*n)));
            }
            found.extend(inside);
        }
        found
    }
}

/// The rectangle around the carrying points, along the direction in which they rise most: two of its corners are as low as the lowest.
fn rectangle(feet: &[Foot]) -> Vec<Foot> {
    let mean = |of: &dyn Fn(&Foot) -> f64| feet.iter().map(of).sum::<f64>() / feet.len() as f64;
    let (x, y, h) = (mean(&|f| f.at[0]), mean(&|f| f.at[1]), mean(&|f| f.height));
    // The plane of least squares.
    let from = |f: &Foot| (f.at[0] - x, f.at[1] - y, f.height - h);
    let sum = |of: &dyn Fn((f64, f64, f64)) -> f64| feet.iter().map(|f| of(from(f))).sum::<f64>();
    let (xx, xy, yy) = (sum(&|p| p.0 * p.0), sum(&|p| p.0 * p.1), sum(&|p| p.1 * p.1));
    let (xh, yh, det) = (sum(&|p| p.0 * p.2), sum(&|p| p.1 * p.2), xx * yy - xy * xy);
    let slope = if det > 0.0 { [(xh * yy - yh * xy) / det, (yh * xx - xh * xy) / det] } else { [0.0; 2] };
    let steepness = slope[0].hypot(slope[1]);
    let up = if steepness > 0.0 { slope.map(|s| s / steepness) } else { [1.0, 0.0] };
    let aside = [-up[1], up[0]];
    let spread = |d: [f64; 2]| {
        let along = || feet.iter().map(move |f| f.at[0] * d[0] + f.at[1] * d[1]);
        [along().fold(f64::INFINITY, f64::min), along().fold(f64::NEG_INFINITY, f64::max)]
    };
    let ([low, high], [left, right]) = (spread(up), spread(aside));
    let corner = |s: f64, t: f64| {
        let at = [s * up[0] + t * aside[0], s * up[1] + t * aside[1]];
        Foot { at, height: h + slope[0] * (at[0] - x) + slope[1] * (at[1] - y) }
    };
    vec![corner(low, left), corner(high, left), corner(high, right), corner(low, right)]
}

/// Lowers a footing until no carrying point is below it.
fn settle(feet: &mut [Foot], common: &[Foot], carried: &[Foot]) {
    let inside = |p: &Foot| half_planes(common, 0.0).iter().all(|(n, limit)| n[0] * p.at[0] + n[1] * p.at[1] <= *limit);
    let low = common.iter().chain(carried.iter().filter(|p| common.len() > 2 && inside(p)));
    let over = low.filter_map(|p| Some(height_at(feet, &p.at)? - p.height)).fold(0.0, f64::max);
    feet.iter_mut().for_each(|foot| foot.height -= over);
}

/// The height of a footing of three or four points at a place, by the lower of its two ways of being cut into triangles.
fn height_at(feet: &[Foot], at: &[f64; 2]) -> Option<f64> {
    match feet {
        [a, b, c] => height_in_triangle([a, b, c], at),
        [a, b, c, d] => [[a, b, c], [a, c, d], [a, b, d], [b, c, d]]
            .into_iter()
            .filter_map(|three| height_in_triangle(three, at))
            .reduce(f64::min),
        _ => None,
    }
}

fn turned_back(pose: &Pose, d: &Point) -> Point {
    let r = pose.rotation();
    std::array::from_fn(|a| r[0][a] * d[0] + r[1][a] * d[1] + r[2][a] * d[2])
}

fn into_tool(pose: &Pose, p: &Point) -> Point {
    turned_back(pose, &sub(p, pose.translation()))
}

#[cfg(test)]
mod tests {
    use feeler_core::geometry::vectors::{cross, length, unit};
    use feeler_shapes::{ball, box_mesh, cylinder, Arrays};

    use super::*;
    use crate::contact_plane::by_coordinates;
    use crate::tests::{at, scene, tool, turned, Held};

    /// The footing of the one plane of a tool at a pose, sorted.
    fn footing_of(held: &Held, tool: &Tool, pose: &Pose) -> Vec<Point> {
        let contacts = held.contacts(tool, pose, 0.002, None).unwrap();
        assert_eq!(contacts.planes.len(), 1, "{contacts:?}");
        let mut points = held.solver().footing(tool, pose, &contacts.planes[0]).points().to_vec();
        points.sort_by(by_coordinates);
        points
    }

    fn is_near(found: &[Point], expected: &[Point], tolerance: f64) -> bool {
        found.len() == expected.len() && found.iter().zip(expected).all(|(p, q)| length(&sub(p, q)) < tolerance)
    }

    /// A turn about an axis of the world (radians, unit) and a point.
    fn turn(axis: &Point, angle: f64, about: &Point, p: &Point) -> Point {
        let (sin, cos) = angle.sin_cos();
        let way = sub(p, about);
        let turned = along(&scaled(&way, cos), sin, &cross(axis, &way));
        add(about, &along(&turned, (1.0 - cos) * dot(axis, &way), axis))
    }

    #[test]
    fn a_box_has_its_corners_or_those_over_the_plate() {
        for (plate_cells, cells) in [(1, 1), (9, 1), (1, 7), (23, 5)] {
            let plate = scene(box_mesh([0.0, 0.0, -0.01], [0.1, 0.1, 0.02], plate_cells));
            let block = tool(box_mesh([0.0; 3], [0.03, 0.02, 0.04], cells));
            for z in [0.0205, 0.0195] {
                let flat = footing_of(&plate, &block, &at(0.003, 0.002, z));
                let corners =
                    [[-0.015, -0.01], [-0.015, 0.01], [0.015, -0.01], [0.015, 0.01]].map(|[x, y]| [x, y, -0.02]);
                assert!(is_near(&flat, &corners, 1e-6), "{plate_cells} {cells} {z}: {flat:?}");
                // A third of it beyond the plate's side.
                let over = footing_of(&plate, &block, &at(0.045, 0.002, z));
                let corners =
                    [[-0.015, -0.01], [-0.015, 0.01], [0.005, -0.01], [0.005, 0.01]].map(|[x, y]| [x, y, -0.02]);
                assert!(is_near(&over, &corners, 1e-6), "{plate_cells} {cells} {z}: {over:?}");
            }
        }
    }

    #[test]
    fn an_edge_has_two_and_a_corner_one() {
        let plate = scene(box_mesh([0.0, 0.0, -0.01], [0.2, 0.2, 0.02], 5));
        for cells in [1, 6] {
            let block = tool(box_mesh([0.0; 3], [0.03, 0.02, 0.04], cells));
            let lean = |angle: f64, z: f64| {
                let (s, c) = angle.sin_cos();
                let rows = [[c, 0.0, s, 0.0], [0.0, 1.0, 0.0, 0.0], [-s, 0.0, c, z], [0.0, 0.0, 0.0, 1.0]];
                Pose::new(&rows).unwrap()
            };
            // On one edge along y, leaning by 30 degrees; a half of a millimetre over the plate and in it.
            let (s, c) = 0.5f64.sin_cos();
            let low = 0.015 * s + 0.02 * c;
            for gap in [0.0005, -0.0005] {
                let edge = footing_of(&plate, &block, &lean(0.5, low + gap));
                assert!(
                    is_near(&edge, &[[0.015, -0.01, -0.02], [0.015, 0.01, -0.02]], 1e-6),
                    "{cells} {gap}: {edge:?}"
                );
                // On its lowest corner.
                let pose = turned(0.7, [0.0; 3]);
                let corners = |p: &Pose| {
                    [0, 1]
                        .map(|i| [-0.015, 0.015][i])
                        .into_iter()
                        .flat_map(|x| [-0.01, 0.01].map(|y| [x, y]))
                        .flat_map(|[x, y]| [-0.02, 0.02].map(|z| [x, y, z]))
                        .map(|q| (p.apply(&q)[2], q))
                        .min_by(|a, b| a.0.total_cmp(&b.0))
                        .unwrap()
                };
                let (low, lowest) = corners(&pose);
                let corner = footing_of(&plate, &block, &turned(0.7, [0.0, 0.0, gap - low]));
                assert!(is_near(&corner, &[lowest], 1e-6), "{cells} {gap}: {corner:?}");
            }
        }
    }

    #[test]
    fn what_carries_may_be_smaller_than_what_is_carried() {
        // A large plate lies on a post, and one edge across another.
        let post = scene(box_mesh([0.01, 0.0, -0.02], [0.006, 0.004, 0.04], 3));
        let sheet = tool(box_mesh([0.0; 3], [0.1, 0.1, 0.01], 4));
        let found = footing_of(&post, &sheet, &at(0.0, 0.0, 0.0055));
        let corners = [[0.007, -0.002], [0.007, 0.002], [0.013, -0.002], [0.013, 0.002]].map(|[x, y]| [x, y, -0.005]);
        assert!(is_near(&found, &corners, 1e-6), "{found:?}");
    }

    /// Where footings are held off the plane, no point of what carries goes below it by more than a hundredth of how far the turn
    /// moves it.
    #[test]
    fn held_footings_hold_the_tool() {
        let prism = |n: usize| {
            let (vertices, faces) = cylinder(0.01, 0.03, n, 2);
            (vertices.into_iter().map(|[x, y, z]| [y, z, x]).collect::<Vec<Point>>(), faces)
        };
        let shapes: Vec<(&str, Arrays)> = vec![
            ("box", box_mesh([0.0; 3], [0.03, 0.02, 0.01], 3)),
            ("flat box", box_mesh([0.0; 3], [0.04, 0.03, 0.001], 2)),
            ("hexagon", prism(6)),
            ("pin", prism(48)),
            ("ball", ball(0.01, 24)),
            ("lying pin", cylinder(0.008, 0.04, 40, 3)),
        ];
        let plate = scene(box_mesh([0.0, 0.0, -0.01], [0.1, 0.1, 0.02], 6));
        let wave = |i: usize| [(0.7 * i as f64).sin(), (1.9 * i as f64).cos(), (1.3 * i as f64).sin()];
        let mut counts = [0; 5];
        for (name, mesh) in shapes {
            let tool = tool(mesh);
            for i in 0..60 {
                // Leaning by up to two degrees, some partly beyond the plate, near it or a little in it.
                let lean = unit(&wave(i)).map(|d| scaled(&d, 0.035 * (0.37 * i as f64).sin())).unwrap();
                let axis = unit(&[lean[0], lean[1], 20.0 * lean[2]]).unwrap_or([0.0, 0.0, 1.0]);
                let angle = length(&lean);
                let columns =
                    [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|e| turn(&axis, angle, &[0.0; 3], &e));
                let row = |a: usize, x: f64| [columns[0][a], columns[1][a], columns[2][a], x];
                let [x, y, gap] = [0.045 * wave(3 * i)[0], 0.02 * wave(5 * i)[1], 0.0006 * wave(7 * i)[2]];
                let flat = Pose::new(&[row(0, x), row(1, y), row(2, 0.0), [0.0, 0.0, 0.0, 1.0]]).unwrap();
                let corners = || tool.mesh().vertices().iter();
                let low = corners().map(|p| flat.apply(p)[2]).fold(f64::INFINITY, f64::min);
                let pose = flat.translated(&[0.0, 0.0, gap - low]).unwrap();
                let contacts = plate.contacts(&tool, &pose, 0.002, None).unwrap();
                for plane in contacts.planes.iter().filter(|p| p.normal[2] > 0.999) {
                    let footing = plate.solver().footing(&tool, &pose, plane);
                    let held: Vec<Point> = footing.points().iter().map(|p| pose.apply(p)).collect();
                    counts[held.len()] += 1;
                    let height = |p: &Point| dot(&sub(p, &plane.point), &plane.normal);
                    // Points all over the tool that the plate is under.
                    let over: Vec<Point> = tool
                        .mesh()
                        .queried()
                        .flat_map(|t| {
                            let [a, b, c] = pose.apply_triangle(&tool.mesh().triangle(t));
                            (0..=6).flat_map(move |i| {
                                (0..=6 - i).map(move |j| {
                                    let (s, t) = (f64::from(i) / 6.0, f64::from(j) / 6.0);
                                    std::array::from_fn(|k| a[k] + s * (b[k] - a[k]) + t * (c[k] - a[k]))
                                })
                            })
                        })
                        .filter(|p: &Point| p[0].abs() <= 0.05 && p[1].abs() <= 0.05)
                        .collect();
                    let lowest = over.iter().map(height).fold(f64::INFINITY, f64::min);
                    let own = held.iter().map(height).fold(f64::INFINITY, f64::min);
                    assert!((own - plane.gap).abs() < 1e-4 * 0.04, "{name} {i}: {own} {lowest} {plane:?}");
                    let middle = scaled(&held.iter().fold([0.0; 3], |s, p| add(&s, p)), 1.0 / held.len() as f64);
                    for k in 0..24 {
                        let axis = unit(&wave(100 * i + k)).unwrap();
                        let angle = FOOTING_TURN * [1.0, 0.3, 0.7][k % 3];
                        let moved = |p: &Point| turn(&axis, angle, &middle, p);
                        let floor = held.iter().map(|p| height(&moved(p))).fold(f64::INFINITY, f64::min);
                        // As far up as it takes to have the footing where it was.
                        let up = (plane.gap - floor).max(0.0);
                        let (low, by) = over
                            .iter()
                            .map(|p| (height(&moved(p)) + up, length(&sub(&moved(p), p))))
                            .min_by(|p, q| p.0.total_cmp(&q.0))
                            .unwrap();
                        let reach = held.iter().map(|p| length(&sub(&moved(p), p))).fold(by, f64::max);
                        assert!(
                            low >= plane.gap - 0.01 * reach - 1e-9,
                            "{name} {i} {k}: {} below, of {reach}; {held:?}",
                            plane.gap - low
                        );
                    }
                }
            }
        }
        assert!(counts[4] > 100 && counts[2] + counts[3] > 5, "{counts:?}");
    }
}
