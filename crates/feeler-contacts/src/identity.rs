//! The identity of contact planes: which plane of this pose corresponds to which of the last.
//!
//! A plane is between two surfaces, and a surface is a convex body of its mesh, computed once (see
//! [`convex_bodies`](feeler_core::mesh::topology)). Triangles, and the smooth regions that the tool slides over, do not
//! identify it.

use feeler_core::geometry::vectors::dot;
use feeler_core::Point;
use feeler_lanes::SplitMix64;

use crate::contact_plane::ContactPlane;
use crate::context::QueryContext;
use crate::surface::Surface;

/// Gives each plane its id. Several planes of the same two bodies are numbered along the axis of the tool's frame on which their
/// points are most spread, so that small motions do not change their order.
pub(crate) fn set_ids(context: &QueryContext<'_>, planes: &mut [ContactPlane]) {
    let key = |plane: &ContactPlane| {
        let [tool, mockup] = Surface::BOTH.map(|surface| context.adjacency[surface].body_of(plane.carriers[surface]));
        [plane.part, mockup, tool]
    };
    let keys: Vec<[u32; 3]> = planes.iter().map(key).collect();
    let mut order: Vec<usize> = (0..planes.len()).collect();
    order.sort_by_key(|i| keys[*i]);
    for same in order.chunk_by_mut(|i, j| keys[*i] == keys[*j]) {
        if same.len() > 1 {
            let mut placed: Vec<(Point, usize)> =
                same.iter().map(|i| (context.in_tool(&planes[*i].point), *i)).collect();
            let axis = widest(placed.iter().map(|(point, _)| point));
            let at = |(point, i): &(Point, usize)| (dot(point, &axis), dot(&planes[*i].normal, &[0.48, 0.6, 0.64]));
            placed.sort_by(|x, y| at(x).0.total_cmp(&at(y).0).then(at(x).1.total_cmp(&at(y).1)).then(x.1.cmp(&y.1)));
            same.iter_mut().zip(placed).for_each(|(place, (_, i))| *place = i);
        }
        for (number, i) in (0..).zip(same) {
            planes[*i].id = hash(keys[*i], number);
        }
    }
}

/// The axis along which points are most spread.
fn widest<'a>(points: impl Iterator<Item = &'a Point> + Clone) -> Point {
    let spread = |a: usize| {
        let along = || points.clone().map(|p| p[a]);
        along().fold(f64::NEG_INFINITY, f64::max) - along().fold(f64::INFINITY, f64::min)
    };
    let widest = (0..3).max_by(|a, b| spread(*a).total_cmp(&spread(*b))).unwrap_or(0);
    std::array::from_fn(|a| f64::from(u8::from(a == widest)))
}

/// Of one number after the other.
fn hash([part, mockup, tool]: [u32; 3], number: u32) -> u64 {
    let first = 0x9e37_79b9_7f4a_7c15;
    [part, mockup, tool, number].into_iter().fold(first, |h, x| SplitMix64::new(h ^ u64::from(x)).bits())
}

#[cfg(test)]
mod tests {
    use feeler_core::{Mockup, Tool};
    use feeler_shapes::{ball, box_mesh, joined, ridge, Arrays};

    use crate::tests::{at, scene, tool, turned, Held};

    #[test]
    fn a_plane_keeps_its_id_from_near_to_deep_and_over_triangles_and_regions() {
        for (plate_cells, cells) in [(1, 1), (9, 1), (30, 7)] {
            let plate = scene(box_mesh([0.0, 0.0, -0.01], [0.2, 0.2, 0.02], plate_cells));
            let (block, sphere) = (tool(box_mesh([0.0; 3], [0.03, 0.02, 0.02], cells)), tool(ball(0.01, 12 + cells)));
            for (held, height) in [(&block, 0.01), (&sphere, 0.01)] {
                let mut ids = Vec::new();
                for i in 0..40 {
                    // From a millimetre over the plate to half a millimetre in it, aside, and rolling a little.
                    let (x, z) = (-0.05 + 0.0025 * f64::from(i), height + 0.001 - 0.00004 * f64::from(i));
                    let pose =
                        turned(if std::ptr::eq(held, &sphere) { 0.1 * f64::from(i) } else { 0.0 }, [x, 0.3 * x, z]);
                    let contacts = plate.contacts(held, &pose, 0.002, None).unwrap();
                    ids.extend(contacts.planes.iter().map(|p| p.id));
                }
                assert!(ids.len() >= 40 && ids.iter().all(|id| *id == ids[0]), "{plate_cells} {cells}: {ids:?}");
            }
        }
    }

    #[test]
    fn planes_of_other_surfaces_have_other_ids() {
        // Two plates side by side as two parts, a fork of two prongs over both.
        let plates = [-0.03, 0.03].map(|x| box_mesh([x, 0.0, -0.01], [0.05, 0.1, 0.02], 3));
        let (count, mesh) = (plates[0].1.len() as u32, joined(plates));
        let parts = (0..2 * count).map(|f| f / count).collect();
        let held = Held::of(Mockup::new(mesh.0, mesh.1, parts, 2).unwrap());
        let fork = tool(joined([-0.03, 0.03].map(|x| box_mesh([x, 0.0, 0.01], [0.01, 0.01, 0.02], 2))));
        let ids = |z: f64| {
            let mut ids: Vec<u64> =
                held.contacts(&fork, &at(0.0, 0.0, z), 0.002, None).unwrap().planes.iter().map(|p| p.id).collect();
            ids.sort_unstable();
            ids
        };
        let (near, deep) = (ids(0.001), ids(-0.0005));
        assert_eq!(near, deep);
        assert!(near.len() == 2 && near[0] != near[1], "{near:?}");
    }

    #[test]
    fn a_plane_keeps_its_id_when_others_come_and_go() {
        // Floor and wall of one part, a block on one of them or on both; and a fork of which one prong or both touch the floor.
        let floor = box_mesh([0.0, 0.0, -0.01], [0.1, 0.1, 0.02], 2);
        let corner = scene(joined([floor, box_mesh([-0.06, 0.0, 0.05], [0.02, 0.1, 0.08], 2)]));
        let block = tool(box_mesh([0.0; 3], [0.02; 3], 1));
        let fork = tool(joined([-0.02, 0.02].map(|x| box_mesh([x, 0.0, 0.01 - 0.0125 * x], [0.01, 0.01, 0.02], 1))));
        let ids = |tool: &Tool, x: f64, z: f64| {
            let planes = corner.contacts(tool, &at(x, 0.0, z), 0.0, None).unwrap().planes;
            planes.iter().map(|p| (p.normal.map(|x| x.round() as i32), p.point[0] > 0.0, p.id)).collect::<Vec<_>>()
        };
        let (on_floor, on_wall) = (ids(&block, 0.0, 0.0098), ids(&block, -0.0402, 0.02));
        let on_both = ids(&block, -0.0402, 0.0098);
        assert_eq!([on_floor.len(), on_wall.len(), on_both.len()], [1, 1, 2], "{on_both:?}");
        assert_ne!(on_floor[0].2, on_wall[0].2);
        for (normal, _, id) in on_both {
            assert_eq!(id, if normal == [0, 0, 1] { on_floor[0].2 } else { on_wall[0].2 });
        }
        let (one, both) = (ids(&fork, 0.0, 0.0001), ids(&fork, 0.0, -0.0006));
        assert_eq!([one.len(), both.len()], [1, 2], "{one:?} {both:?}");
        for (_, is_right, id) in both {
            assert_eq!(id == one[0].2, is_right == one[0].1);
        }
    }

    #[test]
    fn planes_of_the_same_surfaces_are_told_apart_and_stay_so() {
        // A block over a slot: it is on the plate's upper side left and right of it.
        let slot =
            [[-0.03, 0.0], [-0.009, 0.0], [-0.009 + 1e-9, -0.005], [0.009 - 1e-9, -0.005], [0.009, 0.0], [0.03, 0.0]];
        let plate = scene(ridge(&slot, -0.02, 0.03, 2, 5));
        let block = tool(box_mesh([0.0, 0.0, 0.01], [0.03, 0.02, 0.02], 9));
        let mut before: Option<Vec<u64>> = None;
        for i in 0..20 {
            let pose = at(0.0002 * f64::from(i), 0.0001 * f64::from(i), -0.0003);
            let mut planes = plate.contacts(&block, &pose, 0.0, None).unwrap().planes;
            planes.sort_by(|p, q| p.point[0].total_cmp(&q.point[0]));
            let ids: Vec<u64> = planes.iter().map(|p| p.id).collect();
            let mut different = ids.clone();
            different.sort_unstable();
            different.dedup();
            assert!(ids.len() == 2 && different.len() == 2, "{i} {ids:?}");
            assert!(before.replace(ids.clone()).is_none_or(|before| before == ids), "{i}");
        }
    }

    /// A square plate around a square hole, `half` and `hole` from the middle to a side, between the heights -`thick` and 0.
    fn frame(half: f64, hole: f64, thick: f64) -> Arrays {
        let line = [-half, -hole, hole, half];
        let vertex = |i: usize, j: usize, top: usize| ((i * 4 + j) * 2 + top) as u32;
        let height = |top: usize| if top == 1 { 0.0 } else { -thick };
        let vertices = (0..32).map(|v| [line[v / 8], line[v / 2 % 4], height(v % 2)]).collect();
        let mut faces = Vec::new();
        let mut quad = |[a, b, c, d]: [u32; 4]| faces.extend([[a, b, c], [a, c, d]]);
        let is_there = |i: i32, j: i32| (0..3).contains(&i) && (0..3).contains(&j) && (i, j) != (1, 1);
        for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))).filter(|(i, j)| is_there(*i, *j)) {
            let [a, b, c, d] = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(x, y)| (i as usize + x, j as usize + y));
            quad([a, b, c, d].map(|(x, y)| vertex(x, y, 1)));
            quad([a, d, c, b].map(|(x, y)| vertex(x, y, 0)));
            for (p, q, beside) in [(a, b, (i, j - 1)), (b, c, (i + 1, j)), (c, d, (i, j + 1)), (d, a, (i - 1, j))] {
                if !is_there(beside.0, beside.1) {
                    quad([vertex(p.0, p.1, 0), vertex(q.0, q.1, 0), vertex(q.0, q.1, 1), vertex(p.0, p.1, 1)]);
                }
            }
        }
        (vertices, faces)
    }

    #[test]
    fn planes_of_the_same_two_bodies_are_numbered() {
        // A bar over a hole lies on the same upper side of the same plate left and right of it.
        let plate = scene(frame(0.03, 0.01, 0.01));
        let adjacency = plate.mockup().adjacency();
        assert!(adjacency.outward.iter().all(|o| *o == 1));
        let bar = tool(box_mesh([0.0, 0.0, 0.004], [0.04, 0.004, 0.008], 8));
        let mut before: Option<Vec<u64>> = None;
        for i in 0..20 {
            let pose = turned(0.002 * f64::from(i), [0.0002 * f64::from(i), 0.0001, -0.0003]);
            let mut planes = plate.contacts(&bar, &pose, 0.0, None).unwrap().planes;
            let bodies: Vec<u32> = planes.iter().map(|p| adjacency.body_of(p.carriers[1])).collect();
            assert!(bodies.len() == 2 && bodies[0] == bodies[1], "{i} {planes:?}");
            planes.sort_by(|p, q| p.point[0].total_cmp(&q.point[0]));
            let ids: Vec<u64> = planes.iter().map(|p| p.id).collect();
            assert!(ids[0] != ids[1] && before.replace(ids.clone()).is_none_or(|before| before == ids), "{i} {ids:?}");
        }
    }
}
