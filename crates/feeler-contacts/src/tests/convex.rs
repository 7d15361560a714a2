//! Random convex polyhedra: their penetration depth is known from the Minkowski difference.

use std::sync::Arc;

use feeler_core::geometry::vectors::{along, cross, dot, normal, scaled, sub, unit};
use feeler_core::{Level, Mockup, Point, Pose, SceneOptions, Tool};
use feeler_shapes::Arrays;

use super::Held;
use crate::PenetrationKind;

/// Numbers from -1 to 1: the upper bits of a linear congruential generator.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(0x1405_7b7e_f767_814f);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    fn direction(&mut self) -> Point {
        loop {
            let p = [self.next(), self.next(), self.next()];
            if dot(&p, &p) <= 1.0 {
                if let Some(d) = unit(&p) {
                    return d;
                }
            }
        }
    }
}

/// The convex hull of points in general position: every three that have all others on one side, wound outward.
fn hull(points: &[Point]) -> Arrays {
    let mut faces = Vec::new();
    for i in 0..points.len() {
        for j in i + 1..points.len() {
            for k in j + 1..points.len() {
                let n = normal(&[points[i], points[j], points[k]]).unwrap();
                let heights = (0..points.len()).filter(|x| ![i, j, k].contains(x));
                let heights: Vec<f64> = heights.map(|x| dot(&sub(&points[x], &points[i]), &n)).collect();
                let (i, j, k) = (i as u32, j as u32, k as u32);
                if heights.iter().all(|h| *h < 0.0) {
                    faces.push([i, j, k]);
                } else if heights.iter().all(|h| *h > 0.0) {
                    faces.push([i, k, j]);
                }
            }
        }
    }
    (points.to_vec(), faces)
}

/// A polyhedron around the origin, its corners within `radius`.
fn polyhedron(random: &mut Random, corners: usize, radius: f64) -> Arrays {
    let points: Vec<Point> =
        (0..corners).map(|_| scaled(&random.direction(), radius * (0.9 + 0.1 * random.next()))).collect();
    hull(&points)
}

/// The length of the least translation that separates two polyhedra: over the normals of both and the cross products of each two
/// edges.
fn least_translation(mockup: &Arrays, tool: &Arrays) -> f64 {
    let corners = |mesh: &Arrays, f: &[u32; 3]| f.map(|v| mesh.0[v as usize]);
    let edges = |mesh: &Arrays| -> Vec<Point> {
        mesh.1
            .iter()
            .flat_map(|f| corners(mesh, f).into_iter().zip([1, 2, 0]).map(|(p, next)| sub(&corners(mesh, f)[next], &p)))
            .collect()
    };
    let mut directions: Vec<Point> = mockup.1.iter().filter_map(|f| normal(&corners(mockup, f))).collect();
    directions.extend(tool.1.iter().filter_map(|f| normal(&corners(tool, f)).map(|n| scaled(&n, -1.0))));
    for e in edges(mockup) {
        directions.extend(edges(tool).iter().filter_map(|f| unit(&cross(&e, f))).flat_map(|d| [d, scaled(&d, -1.0)]));
    }
    let depth = |d: &Point| {
        let high = mockup.0.iter().map(|p| dot(p, d)).fold(f64::NEG_INFINITY, f64::max);
        high - tool.0.iter().map(|p| dot(p, d)).fold(f64::INFINITY, f64::min)
    };
    directions.iter().map(depth).fold(f64::INFINITY, f64::min)
}

#[test]
fn penetration_of_convex_polyhedra_is_the_least_translation() {
    let mut random = Random(11);
    let (mut least, mut cases) = (0, 0);
    for case in 0..150 {
        let mockup = polyhedron(&mut random, 6 + case % 5, 0.1);
        let tool = polyhedron(&mut random, 5 + case % 7, 0.05);
        // Moved in along a random direction until it is a little deep.
        let side = random.direction();
        let at = |s: f64| (tool.0.iter().map(|p| along(p, s, &side)).collect::<Vec<Point>>(), tool.1.clone());
        let (mut deep, mut free) = (0.0, 0.2);
        let wanted = 0.0002 * (1.0 + f64::from((case % 10) as u32));
        for _ in 0..60 {
            let middle = 0.5 * (deep + free);
            if least_translation(&mockup, &at(middle)) > wanted {
                deep = middle;
            } else {
                free = middle;
            }
        }
        let truth = least_translation(&mockup, &at(deep));
        if truth < 0.9 * wanted {
            // It passes beside the other.
            continue;
        }
        let pose = Pose::IDENTITY.translated(&scaled(&side, deep)).unwrap();
        let held = Mockup::new(mockup.0, mockup.1, Vec::new(), 1).unwrap();
        let held = Arc::new(held);
        let scene = |level: Level| Held::with(Arc::clone(&held), &SceneOptions::default(), level);
        let tool = Tool::new(tool.0, tool.1).unwrap();
        let out = scene(Level::best()).penetration(&tool, &pose, 0.001, None).unwrap();
        let what = format!("{case}: {truth} {out:?}");
        for level in Level::available() {
            assert_eq!(scene(level).contacts(&tool, &pose, 0.001, None).unwrap(), out.contacts, "{level:?} {what}");
        }
        // It frees the tool, so it is no shorter than the least.
        assert!(out.kind != PenetrationKind::Estimate, "{what}");
        assert!(out.depth >= truth * (1.0 - 1e-9), "{what}");
        // Mostly it is the least, but for what keeps the tool off the surface, and else close to it.
        assert!(out.depth <= truth * 1.01, "{what}");
        least += usize::from(out.depth <= truth * (1.0 + 2e-6));
        cases += 1;
    }
    assert!(cases > 130 && least * 10 > cases * 9, "{least} of {cases}");
}
