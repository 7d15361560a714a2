//! The guarantees of contact planes, each with a contact in which nothing else would provide it.

use std::f64::consts::PI;

use feeler_core::geometry::vectors::{across, along, dot, length, scaled, sub, unit};
use feeler_core::{Point, Pose};
use feeler_shapes::{ball, box_mesh, cylinder, joined, sheet, Arrays};

use super::{at, moved, scene, tool, turned, Held};
use crate::constants::MOST_PLANES;
use crate::ContactPlane;

/// One plane, so deep (metres) along a direction.
fn assert_one(planes: &[ContactPlane], normal: Point, depth: f64, tolerance: f64, what: &str) {
    assert_eq!(planes.len(), 1, "{what}: {planes:?}");
    assert!((planes[0].gap + depth).abs() < tolerance, "{what}: {depth} {planes:?}");
    assert!(length(&sub(&planes[0].normal, &normal)) < 1e-6, "{what}: {planes:?}");
}

/// A tetrahedron with its point at the origin, standing on it where `sense` is 1 and under it where that is -1; as wide as high.
fn spike(height: f64, sense: f64) -> Arrays {
    let corner = |k: usize| {
        let (s, c) = (2.0 * PI * k as f64 / 3.0 + 0.4).sin_cos();
        [0.5 * height * c, 0.5 * height * s, sense * height]
    };
    let faces = if sense > 0.0 {
        vec![[0, 2, 1], [0, 3, 2], [0, 1, 3], [1, 2, 3]]
    } else {
        vec![[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]]
    };
    (vec![[0.0; 3], corner(0), corner(1), corner(2)], faces)
}

#[test]
fn a_closed_plate_that_the_tool_went_through_goes_by_the_reference() {
    // The tool is under the plate but for its top, which is a little in it.
    for (n, cells) in [(1, 1), (20, 1), (1, 12), (20, 12)] {
        let plate = scene(box_mesh([0.0; 3], [0.1, 0.1, 0.001], n));
        let cube = tool(box_mesh([0.0; 3], [0.02; 3], cells));
        let pose = at(0.001, 0.002, -0.01 + 0.0004);
        let planes = |reference: Option<Pose>| plate.contacts(&cube, &pose, 0.0, reference.as_ref()).unwrap().planes;
        let what = format!("{n} {cells}");
        assert_one(&planes(None), [0.0, 0.0, -1.0], 0.0009, 1e-12, &what);
        assert_one(&planes(Some(at(0.0, 0.0, -0.05))), [0.0, 0.0, -1.0], 0.0009, 1e-12, &what);
        // From above: out over what it met, which is the lower face.
        assert_one(&planes(Some(at(0.0, 0.0, 0.05))), [0.0, 0.0, 1.0], 0.0191, 1e-12, &what);
    }
}

#[test]
fn thin_triangles_have_the_normal_of_what_they_lie_in() {
    // The top of a block in long strips, some next to each other so thin that they have no normals of their own; each of them
    // ends at the walls, over its short edge. A corner of the tool is pressed into them, and has no face of their direction.
    let (wide, thin) = (0.008, 2e-8);
    let mut lines = vec![-0.1];
    while lines[lines.len() - 1] < 0.1 {
        let last = lines[lines.len() - 1];
        lines.extend([last + wide, last + wide + thin, last + wide + 2.0 * thin, last + wide + 3.0 * thin]);
    }
    let count = lines.len() - 1;
    let y = |t: f64| lines[(t * count as f64).round() as usize];
    let wave = |t: f64| 1e-8 * (9.7 * t * count as f64).sin();
    // Off its plane at the strips, and not at its borders.
    let top = |s: f64, t: f64| [0.1 * (2.0 * s - 1.0), y(t), if t == 0.0 || t == 1.0 { 0.0 } else { wave(t) }];
    let low = |s: f64, t: f64| [0.1 * (2.0 * s - 1.0), y(t), -0.03];
    let wall = |s: f64| move |t: f64, h: f64| if h == 0.0 { low(s, t) } else { top(s, t) };
    let end = |t: f64| move |s: f64, h: f64| if h == 0.0 { low(s, t) } else { top(s, t) };
    // The innermost come first: a patch has the normal of its first triangle.
    let mut strips = sheet(1, count, top);
    let mut order: Vec<usize> = (0..strips.1.len()).collect();
    order.sort_by_key(|i| [3, 1, 0, 1][i / 2 % 4]);
    strips.1 = order.iter().map(|i| strips.1[*i]).collect();
    let block = scene(joined([
        strips,
        sheet(count, 1, |t, s| low(s, t)),
        sheet(count, 1, wall(1.0)),
        sheet(1, count, |h, t| wall(0.0)(t, h)),
        sheet(1, 1, end(0.0)),
        sheet(1, 1, |h, s| end(1.0)(s, h)),
    ]));
    // So does a contact with the tool's first, which is to be one that meets them.
    let mut spike = spike(0.02, 1.0);
    spike.1.rotate_left(1);
    let spike = tool(spike);
    for i in 0..60 {
        let strip = lines[4 * (i % 10) + 2] + thin;
        let pose = at(0.0011 * (i as f64 - 30.0), strip + 1e-8 * (i as f64 - 30.0), -0.001);
        let planes = block.contacts(&spike, &pose, 0.0, None).unwrap().planes;
        assert_eq!(planes.len(), 1, "{i}: {planes:?}");
        // The strips between lean by a hair.
        assert!((planes[0].gap + 0.001).abs() < 1e-7 && planes[0].normal[2] > 1.0 - 1e-10, "{i}: {planes:?}");
    }
}

#[test]
fn contacts_on_one_face_are_one_only_where_what_is_between_is_beyond() {
    // Two pegs under a bar, each as deep in one plate as it is long.
    let peg = |x: f64, depth: f64| box_mesh([x, 0.0, 0.5 * (0.01 - depth)], [0.006, 0.005, 0.01 + depth], 3);
    for n in [1, 11] {
        let plate = scene(box_mesh([0.0, 0.0, -0.01], [0.1, 0.1, 0.02], n));
        let bar = tool(joined([peg(-0.007, 0.001), peg(0.007, 0.0015)]));
        // Where it has two triangles, both are on one of them.
        let planes = plate.contacts(&bar, &at(0.001, 0.025, 0.0), 0.0, None).unwrap().planes;
        let depths: Vec<f64> = planes.iter().map(|p| -p.gap).collect();
        assert_eq!(depths.len(), 2, "{n}: {planes:?}");
        assert!((depths[0] - 0.0015).abs() < 1e-12 && (depths[1] - 0.001).abs() < 1e-12, "{n}: {planes:?}");
    }
}

#[test]
fn behind_the_border_of_an_open_sheet_the_tool_is_not_inside() {
    // An open sheet ends under the tool, and a wall of the same part is near to the tool's other side.
    let floor = sheet(5, 5, |s, t| [0.05 * s - 0.05, 0.1 * (t - 0.5), 0.0]);
    let wall = sheet(5, 5, |s, t| [0.013, 0.1 * (s - 0.5), 0.004 + 0.05 * t]);
    let part = scene(joined([floor, wall]));
    for cells in [4, 16] {
        let cube = tool(box_mesh([0.0; 3], [0.02; 3], cells));
        let planes = part.contacts(&cube, &at(0.002, 0.001, 0.01 - 0.0015), 0.002, None).unwrap().planes;
        assert_eq!(planes.len(), 2, "{cells}: {planes:?}");
        assert!((planes[0].gap + 0.0015).abs() < 1e-12 && planes[0].normal[2] > 0.999, "{cells}: {planes:?}");
        assert!((planes[1].gap - 0.001).abs() < 1e-12 && planes[1].normal[0] < -0.999, "{cells}: {planes:?}");
    }
}

/// The least depth of two bulging bodies, the upper one shifted, along any direction about `way`: sought on a grid, ever finer.
fn least_depth(lower: &[Point], upper: &[Point], shift: &Point, way: &Point) -> f64 {
    let (mut best, mut reach) = (*way, 0.2);
    let high = |points: &[Point], d: &Point| points.iter().map(|p| dot(p, d)).fold(f64::NEG_INFINITY, f64::max);
    // Nothing but what is about there is the highest.
    let near = |points: &[Point], d: Point| -> Vec<Point> {
        let least = 0.9 * high(points, &d);
        points.iter().filter(|p| dot(p, &d) > least).copied().collect()
    };
    let (lower, upper) = (near(lower, *way), near(upper, scaled(way, -1.0)));
    let depth = |d: &Point| high(&lower, d) + high(&upper, &scaled(d, -1.0)) - dot(shift, d);
    while reach > 1e-5 {
        let [u, v] = across(&best);
        let turned = (-12..=12).flat_map(|i| (-12..=12).map(move |j| [i, j].map(|k| reach * f64::from(k) / 12.0)));
        let all = turned.filter_map(|[x, y]| unit(&along(&along(&best, x, &u), y, &v)));
        best = all.min_by(|d, e| depth(d).total_cmp(&depth(e))).unwrap();
        reach *= 0.3;
    }
    depth(&best)
}

#[test]
fn round_surfaces_have_the_least_depth_though_no_facet_looks_along_it() {
    // Nor do any two edges: it is sought between them.
    let (lower, upper) = (ball(0.02, 24), ball(0.015, 24));
    let (held, round) = (scene(lower.clone()), tool(upper.clone()));
    for i in 0..60 {
        let wave = i as f64;
        let way = unit(&[(1.7 * wave).sin(), (2.3 * wave).cos(), (0.9 * wave + 1.0).sin()]).unwrap();
        for depth in [0.001, 0.004] {
            let p = scaled(&way, 0.035 - depth);
            let contacts = held.contacts(&round, &at(p[0], p[1], p[2]), 0.0, None).unwrap();
            let ratio = contacts.depth() / least_depth(&lower.0, &upper.0, &p, &way);
            assert!((0.999..1.01).contains(&ratio), "{i} {depth}: {ratio} {contacts:?}");
        }
    }
}

#[test]
fn of_two_faces_that_hold_as_well_the_mock_ups_counts() {
    // A block turned by so little that the depth along its own normal differs by rounding alone.
    for cells in [1, 6] {
        let plate = scene(box_mesh([0.0, 0.0, -0.01], [0.1, 0.1, 0.02], cells));
        let cube = tool(box_mesh([0.0; 3], [0.02; 3], cells));
        for i in 0..40 {
            let [a, b] = [1e-9 * (i as f64).sin(), 1e-9 * (1.7 * i as f64).cos()];
            let z = 0.01 - 0.0015;
            let rows = [[1.0, 0.0, a, 0.001], [0.0, 1.0, b, 0.002], [-a, -b, 1.0, z], [0.0, 0.0, 0.0, 1.0]];
            let planes = plate.contacts(&cube, &Pose::new(&rows).unwrap(), 0.0, None).unwrap().planes;
            assert_eq!(planes.len(), 1, "{i}: {planes:?}");
            assert_eq!(planes[0].normal, [0.0, 0.0, 1.0], "{i}: {planes:?}");
        }
    }
}

#[test]
fn what_is_walled_in_by_others_counts() {
    // A mushroom, whose cap is inside a tool that cuts its stem alone: the stem ends nowhere, and the cap has no part in the curve.
    let squares = [(0.004, -0.03), (0.004, 0.004), (0.008, 0.004), (0.008, 0.009)];
    let corner = |k: usize| [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]][k];
    let vertices =
        squares.iter().flat_map(|(half, z)| (0..4).map(move |k| [half * corner(k)[0], half * corner(k)[1], *z]));
    let band = |i: u32| {
        (0..4).flat_map(move |k| {
            let [a, b, c, d] = [4 * i + k, 4 * i + (k + 1) % 4, 4 * i + 4 + (k + 1) % 4, 4 * i + 4 + k];
            [[a, b, c], [a, c, d]]
        })
    };
    let ends = [[0, 2, 1], [0, 3, 2], [12, 13, 14], [12, 14, 15]];
    let mushroom = scene((vertices.collect(), (0..3).flat_map(band).chain(ends).collect()));
    assert!(mushroom.mockup().adjacency().outward.iter().all(|side| *side == 1));
    for cells in [1, 5] {
        let cube = tool(box_mesh([0.0, 0.0, 0.02], [0.05, 0.06, 0.04], cells));
        let contacts = mushroom.contacts(&cube, &at(0.001, 0.002, -0.001), 0.0, None).unwrap();
        assert_one(&contacts.planes, [0.0, 0.0, 1.0], 0.01, 1e-12, &format!("{cells}"));
    }
}

#[test]
fn a_spike_through_a_plate_is_as_deep_as_its_point_is() {
    // The point is a corner of triangles that are all cut.
    for n in [1, 9] {
        let plate = scene(box_mesh([0.0; 3], [0.1, 0.1, 0.001], n));
        let spike = tool(spike(0.06, 1.0));
        let planes = plate.contacts(&spike, &at(0.001, 0.002, -0.01), 0.0, None).unwrap().planes;
        assert_one(&planes, [0.0, 0.0, 1.0], 0.0105, 1e-9, &format!("{n}"));
    }
}

#[test]
fn right_in_the_middle_of_a_plate_there_is_a_plane_too() {
    for cells in [1, 4] {
        let plate = scene(box_mesh([0.0; 3], [0.1, 0.1, 0.001], 2));
        let rod = tool(box_mesh([0.0; 3], [0.005, 0.005, 0.1], cells));
        let planes = plate.contacts(&rod, &Pose::IDENTITY, 0.0, None).unwrap().planes;
        assert_eq!(planes.len(), 1, "{planes:?}");
        assert!((planes[0].gap + 0.0505).abs() < 1e-9 && planes[0].normal[2].abs() > 0.999, "{planes:?}");
    }
}

/// Planes of what is near a tool.
fn near(scene: &Held, mesh: Arrays, pose: &Pose, margin: f64) -> Vec<ContactPlane> {
    let contacts = scene.contacts(&tool(mesh), pose, margin, None).unwrap();
    assert!(!contacts.is_meeting);
    contacts.planes
}

#[test]
fn inside_a_solid_no_surface_holds_the_tool_off() {
    for (n, cells) in [(1, 1), (7, 3)] {
        // From every side.
        let block = scene(box_mesh([0.0; 3], [0.1; 3], n));
        let planes = near(&block, box_mesh([0.0; 3], [0.098, 0.0979, 0.0981], cells), &Pose::IDENTITY, 0.002);
        assert!(planes.is_empty(), "{planes:?}");
        let around = scene(box_mesh([0.0; 3], [0.098, 0.0979, 0.0981], n));
        let planes = near(&around, box_mesh([0.0; 3], [0.1; 3], cells), &Pose::IDENTITY, 0.002);
        assert!(planes.is_empty(), "{planes:?}");
    }
    // Under a dent, and higher than it at its ends: neither triangle is behind the other's plane, but their nearest points are.
    let tip = [0.001, 0.002, -0.01];
    let corners = [[-0.006, -0.005, 0.0], [0.007, -0.004, 0.0], [0.002, 0.008, 0.0]];
    let rim = [[-0.1, -0.1, 0.0], [0.1, -0.1, 0.0], [0.1, 0.1, 0.0], [-0.1, 0.1, 0.0]];
    let mut vertices = vec![tip];
    vertices.extend(corners);
    vertices.extend(rim);
    vertices.extend(rim.map(|p| [p[0], p[1], -0.05]));
    let mut faces = vec![[0, 1, 2], [0, 2, 3], [0, 3, 1]];
    // The top around the dent, the bottom, and the walls.
    faces.extend([[4, 5, 1], [5, 2, 1], [5, 6, 2], [6, 3, 2], [6, 7, 3], [7, 1, 3], [7, 4, 1]]);
    faces.extend([[8, 10, 9], [8, 11, 10]]);
    faces.extend((0..4).flat_map(|k| {
        let l = (k + 1) % 4;
        [[4 + k, 8 + k, 8 + l], [4 + k, 8 + l, 4 + l]]
    }));
    let dented = scene((vertices, faces));
    assert!(dented.mockup().adjacency().outward.iter().all(|side| *side != 0));
    let (s, c) = 0.1f64.sin_cos();
    let place = [0.001 - s * 0.0005, 0.002, -0.011 - 0.0005];
    let rows = [[c, 0.0, s, place[0]], [0.0, 1.0, 0.0, place[1]], [-s, 0.0, c, place[2]], [0.0, 0.0, 0.0, 1.0]];
    let planes = near(&dented, box_mesh([0.0; 3], [0.1, 0.09, 0.001], 1), &Pose::new(&rows).unwrap(), 0.0015);
    assert!(planes.is_empty(), "{planes:?}");
}

#[test]
fn a_hollow_surface_has_few_planes_and_only_where_it_stays_near() {
    // Within a bore: as wide all around, and much wider, where the gap soon grows faster than one in five.
    let bore = |r: f64| {
        let (mut vertices, mut faces) = cylinder(r, 0.06, 180, 3);
        faces.iter_mut().for_each(|f| f.swap(1, 2));
        let outer = cylinder(2.0 * r, 0.06, 36, 3);
        // Rings at both ends are left out: an open solid, wound as it is.
        let walls = |(v, f): Arrays, n: usize| (v, f[..2 * n * 3].to_vec());
        faces = faces[..2 * 180 * 3].to_vec();
        vertices.shrink_to_fit();
        joined([(vertices, faces), walls(outer, 36)])
    };
    let pin = cylinder(0.01, 0.02, 180, 1);
    for (radius, gap, spread, counts) in [(0.0105, 0.0003, 180.0, 15..=MOST_PLANES), (0.016, 0.0002, 45.0, 2..=8)] {
        let planes = near(&scene(bore(radius)), pin.clone(), &at(0.0, 0.0, -(radius - 0.01 - gap)), 0.0025);
        assert!(counts.contains(&planes.len()), "{radius}: {} {planes:?}", planes.len());
        assert!((planes[0].gap - gap).abs() < 2e-6, "{radius}: {planes:?}");
        let least = f64::cos(f64::to_radians(spread)) - 1e-9;
        assert!(planes.iter().all(|p| p.normal[2] >= least), "{radius}: {planes:?}");
    }
}

#[test]
fn normals_of_what_is_near_do_not_depend_on_rounding() {
    // So near that the way between the nearest points is mostly rounding: then it is the faces' normal.
    for (far, gap) in [(0.1, 1e-9), (1.0, 1e-8), (100.0, 1e-7), (100.0, 1e-10)] {
        for angle in [0.3, 0.7, 1.9] {
            let frame = turned(angle, [far, -0.6 * far, 0.3 * far]);
            let plate = scene(moved(box_mesh([0.0, 0.0, -0.01], [0.1, 0.1, 0.02], 3), &frame));
            let place = frame.apply(&[0.003, 0.002, 0.01 + gap]);
            let contacts = plate.contacts(&tool(box_mesh([0.0; 3], [0.02; 3], 2)), &turned(angle, place), 1e-6, None);
            let planes = contacts.unwrap().planes;
            let up = frame.rotation().map(|row| row[2]);
            assert_eq!(planes.len(), 1, "{far} {gap} {angle}: {planes:?}");
            // What the corners' own rounding makes of the plate's faces, and no more.
            let off = length(&sub(&planes[0].normal, &up));
            assert!(off < 1e-14 + 20.0 * f64::EPSILON * far / 0.03, "{far} {gap} {angle}: {off} {planes:?}");
        }
    }
}

#[test]
fn the_plane_of_two_faces_is_in_the_middle_of_what_faces_each_other() {
    for (n, cells) in [(1, 1), (4, 3), (9, 16)] {
        let plate = scene(box_mesh([0.0, 0.0, -0.01], [0.1, 0.1, 0.02], n));
        for p in [[0.001, 0.002], [-0.013, 0.021]] {
            let cube = box_mesh([0.0; 3], [0.02, 0.016, 0.02], cells);
            let planes = near(&plate, cube, &at(p[0], p[1], 0.0105), 0.002);
            assert_eq!(planes.len(), 1, "{planes:?}");
            let off = length(&sub(&planes[0].point, &[p[0], p[1], 0.0]));
            assert!(off < 1e-9, "{n} {cells}: {off} {planes:?}");
        }
    }
}
