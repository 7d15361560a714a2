//! Swept volumes: closed, around everything that the tool reaches, and nowhere farther than the error.

use std::collections::HashSet;
use std::f64::consts::{PI, TAU};

use feeler_core::geometry::vectors::{add, cross, dot, length, scaled, sub};
use feeler_core::{closest_triangle_triangle, Error, Motion, Point, Pose, Tool};
use feeler_plan::{swept, Swept, SweptOptions};
use feeler_shapes::random::Random;
use feeler_shapes::{ball, box_mesh, joined, sheet, Arrays};

fn tool((vertices, faces): Arrays) -> Tool {
    Tool::new(vertices, faces).unwrap()
}

fn at(x: f64, y: f64, z: f64) -> Pose {
    Pose::IDENTITY.translated(&[x, y, z]).unwrap()
}

/// Turned about the third axis.
fn turn(angle: f64, place: Point) -> Pose {
    let ([x, y, z], (sine, cosine)) = (place, angle.sin_cos());
    let rows = [[cosine, -sine, 0.0, x], [sine, cosine, 0.0, y], [0.0, 0.0, 1.0, z], [0.0, 0.0, 0.0, 1.0]];
    Pose::new(&rows).unwrap()
}

fn sweep(tool: &Tool, poses: &[Pose], error: f64) -> Swept {
    let found = swept(tool, poses, error, &SweptOptions::default()).unwrap();
    assert_closed(&found);
    found
}

/// Each edge belongs to two triangles, once each way, and each triangle has an area.
fn assert_closed(mesh: &Swept) {
    let mut edges = HashSet::new();
    for [a, b, c] in &mesh.faces {
        for edge in [(a, b), (b, c), (c, a)] {
            assert!(edges.insert(edge), "{edge:?} twice");
        }
        let [p, q, r] = [a, b, c].map(|v| mesh.vertices[*v as usize]);
        assert!(length(&cross(&sub(&q, &p), &sub(&r, &p))) > 0.0);
    }
    assert!(edges.iter().all(|(a, b)| edges.contains(&(b, a))));
}

fn volume(mesh: &Swept) -> f64 {
    let o = mesh.vertices[0];
    let corner = |v: u32| sub(&mesh.vertices[v as usize], &o);
    mesh.faces.iter().map(|f| dot(&corner(f[0]), &cross(&corner(f[1]), &corner(f[2]))) / 6.0).sum()
}

/// How often the mesh goes around a point, by the solid angles of its triangles (A. van Oosterom, J. Strackee 1983).
fn winding(mesh: &Swept, p: &Point) -> i64 {
    let angle = |face: &[u32; 3]| {
        let [a, b, c] = face.map(|v| sub(&mesh.vertices[v as usize], p));
        let [x, y, z] = [length(&a), length(&b), length(&c)];
        dot(&a, &cross(&b, &c)).atan2(x * y * z + dot(&a, &b) * z + dot(&b, &c) * x + dot(&c, &a) * y)
    };
    let turns = mesh.faces.iter().map(angle).sum::<f64>() / TAU;
    assert!((turns - turns.round()).abs() < 0.01, "{turns}: {p:?} is on the mesh");
    turns.round() as i64
}

/// A point of the tool at a time is inside.
fn assert_around(mesh: &Swept, tool: &Tool, poses: &[Pose], points: usize) {
    let mut random = Random::new(5);
    let triangles: Vec<u32> = tool.mesh().queried().collect();
    for i in 0..points {
        let [a, b, c] = tool.mesh().triangle(triangles[random.below(triangles.len() as u64) as usize]);
        // Corners and edges stick out, so many of the points are there.
        let (mut s, mut t) = (random.real(0.0, 1.0), random.real(0.0, 1.0));
        match i % 4 {
            0 => (s, t) = (0.0, 0.0),
            1 => t = 0.0,
            _ if s + t > 1.0 => (s, t) = (1.0 - s, 1.0 - t),
            _ => {}
        }
        let p = add(&a, &add(&scaled(&sub(&b, &a), s), &scaled(&sub(&c, &a), t)));
        let segment = random.below(poses.len().max(2) as u64 - 1) as usize;
        let motion = Motion::new(tool, &poses[segment], &poses[(segment + 1).min(poses.len() - 1)]);
        let time = if i % 5 == 0 { (i / 5 % 2) as f64 } else { random.real(0.0, 1.0) };
        let place = motion.at(time).apply(&p);
        assert_eq!(winding(mesh, &place), 1, "{place:?} at {time} of segment {segment}");
    }
}

/// Nothing is farther than the error from the tool at its nearest time.
fn assert_tight(mesh: &Swept, tool: &Tool, poses: &[Pose], error: f64, points: usize) {
    let triangles: Vec<_> = tool.mesh().queried().map(|t| tool.mesh().triangle(t)).collect();
    for i in 0..points {
        let face = mesh.faces[i * mesh.faces.len() / points].map(|v| mesh.vertices[v as usize]);
        // Alternately a corner and the middle.
        let p = if i % 2 == 0 { face[0] } else { scaled(&add(&add(&face[0], &face[1]), &face[2]), 1.0 / 3.0) };
        let mut least = f64::INFINITY;
        for segment in 0..poses.len().max(2) - 1 {
            let motion = Motion::new(tool, &poses[segment], &poses[(segment + 1).min(poses.len() - 1)]);
            // The distance changes by no more than the way: to the nearest sample in between it is half of that.
            let samples = (motion.longest_way() / (0.05 * error)).ceil().clamp(1.0, 4000.0);
            for sample in 0..=samples as usize {
                let pose = motion.at(sample as f64 / samples);
                for triangle in &triangles {
                    let closest = closest_triangle_triangle(&pose.apply_triangle(triangle), &[p; 3]);
                    least = least.min(closest.distance);
                }
                if least <= error {
                    break;
                }
            }
        }
        assert!(least <= 1.025 * error, "{p:?} is {least} from the tool");
    }
}

fn assert_swept(tool: &Tool, poses: &[Pose], error: f64) -> Swept {
    let mesh = sweep(tool, poses, error);
    assert_around(&mesh, tool, poses, 150);
    assert_tight(&mesh, tool, poses, error, 150);
    mesh
}

#[test]
fn a_box_that_moves_straight_is_a_longer_box() {
    let cube = tool(box_mesh([0.0; 3], [0.1; 3], 1));
    let error = 0.01;
    let mesh = assert_swept(&cube, &[at(0.0, 0.0, 0.0), at(0.2, 0.0, 0.0)], error);
    let around = |by: f64| (0.3 + by) * (0.1 + by) * (0.1 + by);
    assert!(volume(&mesh) > around(0.0) && volume(&mesh) < around(2.0 * error));
    // Slantwise, and with a pose on the way: the same but for rounding.
    let ends = [at(0.0, 0.0, 0.0), at(0.1, 0.06, 0.03)];
    let mesh = assert_swept(&cube, &ends, error);
    let stop = assert_swept(&cube, &[ends[0], at(0.05, 0.03, 0.015), ends[1]], error);
    assert!((volume(&mesh) - volume(&stop)).abs() < 1e-4 * volume(&mesh));
}

#[test]
fn a_full_turn_leaves_a_ring_with_its_hole() {
    // A bar beside the axis, as a tool with an axle: its box's middle is on the axis.
    let bars =
        joined([box_mesh([0.1, 0.0, 0.0], [0.1, 0.02, 0.02], 1), box_mesh([-0.1, 0.0, 0.0], [0.1, 0.02, 0.02], 1)]);
    let poses: Vec<Pose> = (0..=4).map(|i| turn(0.25 * PI * f64::from(i), [0.0; 3])).collect();
    let (bars, error) = (tool(bars), 0.01);
    let mesh = assert_swept(&bars, &poses, error);
    let (inner, outer) = (0.05, (0.15f64.powi(2) + 0.01f64.powi(2)).sqrt());
    let ring = |by: f64| PI * ((outer + by).powi(2) - (inner - by).powi(2)) * (0.02 + 2.0 * by);
    assert!(
        volume(&mesh) > ring(0.0) && volume(&mesh) < ring(error),
        "{} {} {}",
        volume(&mesh),
        ring(0.0),
        ring(error)
    );
    assert_eq!(winding(&mesh, &[0.0; 3]), 0);
    assert_eq!(winding(&mesh, &[0.0, -0.1, 0.0]), 1);
}

#[test]
fn a_tool_that_turns_as_it_goes() {
    let slab = tool(box_mesh([0.02, 0.01, 0.0], [0.16, 0.05, 0.01], 2));
    let poses = [at(0.0, 0.0, 0.0), turn(2.0, [0.1, 0.05, 0.1]), turn(2.5, [0.0, 0.2, 0.1])];
    assert_swept(&slab, &poses, 0.012);
}

#[test]
fn what_is_inside_is_swept_and_a_hollow_stays() {
    let ((vertices, faces), (inner, hollow)) = (ball(0.1, 12), ball(0.06, 12));
    let solid = tool((vertices.clone(), faces.clone()));
    let turned: Vec<[u32; 3]> = hollow.iter().map(|[a, b, c]| [*a, *c, *b]).collect();
    let shell = tool(joined([(vertices, faces), (inner, turned)]));
    // The error is smaller than the hollow.
    let way = [at(0.0, 0.0, 0.0), at(0.03, 0.0, 0.0)];
    let (full, around) = (assert_swept(&solid, &way, 0.012), assert_swept(&shell, &way, 0.012));
    let middle = [0.015, 0.0, 0.0];
    assert_eq!((winding(&full, &middle), winding(&around, &middle)), (1, 0));
    assert!(volume(&around) < volume(&full) - 1e-4);
    // With a larger error the hollow is filled.
    let far = sweep(&shell, &[way[0], at(0.2, 0.0, 0.0)], 0.012);
    assert_eq!(winding(&far, &[0.1, 0.0, 0.0]), 1);
    // A closed surface that is wound the wrong way is a solid all the same.
    let (vertices, faces) = ball(0.1, 12);
    let inverted = tool((vertices, faces.into_iter().map(|[a, b, c]| [a, c, b]).collect()));
    let inverted = sweep(&inverted, &way, 0.012);
    assert!((volume(&inverted) / volume(&full) - 1.0).abs() < 1e-3);
}

#[test]
fn the_inside_of_a_tool_that_moves_little_is_filled() {
    // The middle is only ever inside the tool: no surface comes near it.
    let cube = tool(box_mesh([0.0; 3], [0.2; 3], 1));
    let mesh = sweep(&cube, &[turn(0.3, [0.0; 3]), turn(0.4, [0.01, 0.0, 0.0])], 0.01);
    assert_eq!(winding(&mesh, &[0.0; 3]), 1);
    assert!(volume(&mesh) > 0.008);
}

#[test]
fn an_open_sheet_has_no_inside() {
    let curved = tool(sheet(6, 6, |s, t| [0.1 * (3.0 * s).cos(), 0.1 * (3.0 * s).sin(), 0.2 * t]));
    let mesh = assert_swept(&curved, &[at(0.0, 0.0, 0.0), at(0.0, 0.01, 0.01)], 0.01);
    assert_eq!(winding(&mesh, &[0.0, 0.03, 0.1]), 0);
    assert!(volume(&mesh) < 0.3 * 0.2 * 0.03);
    // A triangle alone, that turns in its own plane: hulls of two places would fill what it does not come to.
    let needle = tool((vec![[-0.1, 0.0, 0.0], [0.1, -0.01, 0.0], [0.1, 0.01, 0.0]], vec![[0, 1, 2]]));
    assert_swept(&needle, &[turn(0.0, [0.0; 3]), turn(1.0, [0.0; 3])], 0.01);
}

#[test]
fn one_pose_is_the_tool_grown() {
    let cube = tool(box_mesh([0.0; 3], [0.1, 0.06, 0.04], 1));
    let pose = turn(0.5, [0.3, 0.2, 0.1]);
    let mesh = assert_swept(&cube, &[pose], 0.01);
    assert!(sweep(&cube, &[pose, pose, pose], 0.01) == mesh);
    let grown = |by: f64| (0.1 + by) * (0.06 + by) * (0.04 + by);
    assert!(volume(&mesh) > grown(0.0) && volume(&mesh) < grown(0.02));
}

#[test]
fn far_from_the_origin_it_is_the_same() {
    let bar = tool(box_mesh([0.0; 3], [0.1, 0.03, 0.02], 1));
    let far = |pose: &Pose| pose.translated(&[1e4, -1e4, 5e3]).unwrap();
    let near = [turn(0.0, [0.0; 3]), turn(0.7, [0.1, 0.02, 0.0])];
    let poses = [far(&near[0]), far(&near[1])];
    let mesh = assert_swept(&bar, &poses, 0.01);
    let here = sweep(&bar, &near, 0.01);
    assert!((volume(&mesh) / volume(&here) - 1.0).abs() < 1e-3, "{} {}", volume(&mesh), volume(&here));
    // Tools that are modelled far away.
    let off = tool(box_mesh([1e4, 0.0, 0.0], [0.1, 0.03, 0.02], 1));
    assert_swept(&off, &[at(-1e4, 0.0, 0.0), turn(0.4, [-1e4 * f64::cos(0.4), -1e4 * f64::sin(0.4), 0.0])], 0.01);
}

#[test]
fn soups_and_slivers() {
    let mut random = Random::new(11);
    for case in 0..6 {
        let corner = |random: &mut Random| random.point(-0.05, 0.05);
        let mut vertices: Vec<Point> = (0..12).map(|_| corner(&mut random)).collect();
        if case % 2 == 1 {
            // Needles.
            (0..4).for_each(|i| vertices[3 * i + 2] = add(&vertices[3 * i + 1], &[1e-6, 0.0, 1e-7]));
        }
        let soup = tool((vertices, (0..4).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect()));
        let poses: Vec<Pose> = (0..2).map(|_| Pose::new(&random.motion(0.05)).unwrap()).collect();
        assert_swept(&soup, &poses, 0.012);
    }
}

#[test]
fn threads_do_not_matter() {
    let slab = tool(box_mesh([0.0; 3], [0.16, 0.05, 0.01], 2));
    let poses = [at(0.0, 0.0, 0.0), turn(1.0, [0.1, 0.05, 0.1])];
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| sweep(&slab, &poses, 0.012))
    };
    let one = with(1);
    assert!(with(2) == one);
    assert!(with(5) == one);
}

#[test]
fn bad_input_is_refused_before_the_work() {
    let cube = tool(box_mesh([0.0; 3], [0.1; 3], 1));
    let way = [at(0.0, 0.0, 0.0), turn(1.0, [0.3, 0.0, 0.0])];
    let refused = |poses: &[Pose], error: f64, memory: u64| {
        swept(&cube, poses, error, &SweptOptions::default().with_memory_limit(memory)).unwrap_err()
    };
    assert_eq!(refused(&[], 0.001, u64::MAX), Error::EmptyPath);
    for error in [0.0, -1.0, f64::INFINITY] {
        assert_eq!(refused(&way, error, u64::MAX), Error::SweptError { value: error });
    }
    assert!(matches!(refused(&way, f64::NAN, u64::MAX), Error::SweptError { .. }));
    // Too many triangles; too many cells; below rounding.
    for (error, memory) in [(1e-5, 1 << 26), (1e-7, 1 << 26), (1e-15, 1 << 26), (f64::MIN_POSITIVE, 1 << 26), (1e-3, 0)]
    {
        let Error::SweptTooFine { error: given, least, .. } = refused(&way, error, memory) else { panic!("{error}") };
        assert!(given == error && least > error, "{error} {least}");
    }
    // The suggested error does fit.
    let Error::SweptTooFine { least, .. } = refused(&way, 1e-4, 20 << 20) else { panic!() };
    assert!(least < 0.1);
    swept(&cube, &way, least, &SweptOptions::default().with_memory_limit(20 << 20)).unwrap();
}

#[test]
fn progress_rises_and_can_stop_it() {
    let cube = tool(box_mesh([0.0; 3], [0.1; 3], 1));
    let way = [at(0.0, 0.0, 0.0), at(0.3, 0.0, 0.0)];
    let told = std::sync::Mutex::new(Vec::new());
    let tell = |done: f64, _: &str| {
        told.lock().unwrap().push(done);
        true
    };
    swept(&cube, &way, 0.01, &SweptOptions::default().with_progress(&tell)).unwrap();
    let told = told.into_inner().unwrap();
    assert!(told.len() > 10 && told.is_sorted() && told[told.len() - 1] > 0.99);
    for stop in [0.0, 0.3] {
        let stopped = swept(&cube, &way, 0.01, &SweptOptions::default().with_progress(&|done, _| done < stop));
        assert!(matches!(stopped, Err(Error::Cancelled)));
    }
}
