//! Casts: never late, never through anything, early by at most the tolerance; all stores against all pairs.

mod common;

use std::sync::Arc;

use common::*;
use feeler_core::geometry::distance_triangle_triangle::closest_triangle_triangle;
use feeler_core::{
    cast_all_pairs, collide_all_pairs, Cast, CastOptions, Error, Mockup, Motion, PathOptions, Point, Pose, Scene,
    SceneOptions, Screw, Storage, Tool, Touching,
};

const TOLERANCE: f64 = 1e-6;

fn scene_of(mockup: &Arc<Mockup>, storage: Storage) -> Scene {
    let options = SceneOptions::default().with_storage(storage);
    Scene::build(mockup.clone(), &options).unwrap()
}

fn sheet(side: f64) -> Arrays {
    let s = 0.5 * side;
    (vec![[-s, -s, 0.0], [s, -s, 0.0], [s, s, 0.0], [-s, s, 0.0]], vec![[0, 1, 2], [0, 2, 3]])
}

/// A box.
fn bar([x, y, z]: Point) -> Arrays {
    let vertices =
        (0..8).map(|i| [x * f64::from(i & 1), y * f64::from(i >> 1 & 1), z * f64::from(i >> 2 & 1)]).collect();
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    (vertices, quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect())
}

fn turned(axis: usize, angle: f64, at: Point) -> Pose {
    let (s, c) = angle.sin_cos();
    let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
    let mut m = [[0.0; 4]; 4];
    (m[axis][axis], m[i][i], m[j][j], m[i][j], m[j][i], m[3][3]) = (1.0, c, c, -s, s, 1.0);
    (0..3).for_each(|a| m[a][3] = at[a]);
    Pose::new(&m).unwrap()
}

/// Every result must satisfy this: no collision before the impact, and the reported pair is near at the impact.
fn check(mockup: &Mockup, tool: &Tool, way: (&Pose, &Pose), found: Option<&Cast>, samples: usize, what: &str) {
    let motion = Motion::new(tool, way.0, way.1);
    let until = found.map_or(1.0, |cast| cast.fraction);
    for i in 0..=samples {
        let time = until * i as f64 / samples as f64;
        if found.is_none() || time < until {
            let pairs = collide_all_pairs(mockup.mesh(), tool, &motion.at(time));
            assert!(pairs.is_empty(), "{what}: {pairs:?} at {time}, before {until}");
        }
    }
    if let Some(cast) = found {
        assert_eq!(cast.pose, motion.at(cast.fraction), "{what}");
        assert!((0.0..=1.0).contains(&cast.fraction), "{what}");
        assert!(cast.distance <= TOLERANCE, "{what}: {} apart", cast.distance);
        let p = cast.pose.apply_triangle(&tool.mesh().triangle(cast.tool_triangle));
        let q = mockup.mesh().triangle(cast.mockup_triangle);
        assert_eq!(closest_triangle_triangle(&p, &q).distance, cast.distance, "{what}");
        let size = cast.normal.iter().map(|x| x * x).sum::<f64>().sqrt();
        assert!((size - 1.0).abs() < 1e-9, "{what}: {:?}", cast.normal);
    }
}

#[test]
fn a_cast_of_any_store_is_that_of_all_pairs() {
    let mut r = Random::new(7);
    let (mut free, mut hits) = (0, 0);
    for (name, arrays, size) in [
        ("soup", soup(1, 400, 0.05), 1.0),
        ("needles", needles(2, 80, 0.01), 1.0),
        ("lattice", lattice(3, 150, 12), 12.0),
        ("defects", with_defects(soup(5, 200, 0.05)), 1.0),
        ("far", placed(soup(4, 300, 0.05), 1.0, 3000.0), 1.0),
    ] {
        let offset = if name == "far" { 3000.0 } else { 0.0 };
        let mockup = mockup_of(arrays);
        let scenes = STORAGES.map(|storage| scene_of(&mockup, storage));
        let tool = tool_of(placed(soup(9, 12, 0.05), 0.15 * size, 0.3));
        for i in 0..40 {
            let (a, mut b) = (r.pose(0.0), r.pose(0.0));
            if i % 3 == 0 {
                b = a;
            }
            let mut place = |pose: &Pose, spread: f64| {
                let mut m = pose.matrix();
                let centre = pose.apply(&[0.3 + 0.075 * size; 3]);
                (0..3).for_each(|k| m[k][3] = offset + r.real(0.5 - spread, 0.5 + spread) * size - centre[k]);
                Pose::new(&m).unwrap()
            };
            let spread = [1.2, 0.7, 0.3][i % 3];
            let (a, b) = (place(&a, spread), place(&b, spread));
            let plain = cast_all_pairs(mockup.mesh(), &tool, &Motion::new(&tool, &a, &b), TOLERANCE).unwrap();
            check(&mockup, &tool, (&a, &b), plain.as_ref(), 60, &format!("{name} {i}"));
            let way = Motion::new(&tool, &a, &b).longest_way();
            for scene in &scenes {
                let what = format!("{name} {i} {:?}", scene.storage());
                let found = scene.cast(&tool, &a, &b, &CastOptions::default().with_tolerance(TOLERANCE)).unwrap();
                check(&mockup, &tool, (&a, &b), found.as_ref(), 10, &what);
                assert_eq!(found.is_some(), plain.is_some(), "{what}");
                if let (Some(found), Some(plain)) = (found, plain) {
                    let apart = (found.fraction - plain.fraction).abs();
                    assert!(apart * way < 1e-3, "{what}: {} and {}", found.fraction, plain.fraction);
                }
            }
            free += usize::from(plain.is_none());
            hits += usize::from(plain.is_some());
        }
    }
    assert!(free > 20 && hits > 60, "{free} free, {hits} hits");
}

#[test]
fn a_drop_on_a_sheet_stops_at_the_sheet() {
    let mockup = mockup_of(sheet(1.0));
    let tool = tool_of(bar([0.1, 0.1, 0.1]));
    for storage in STORAGES {
        let scene = scene_of(&mockup, storage);
        for speed in [1.0, 1e3, 1e9] {
            let (a, b) = (moved([0.0, 0.0, 0.25]), moved([0.0, 0.0, 0.25 - speed]));
            let cast =
                scene.cast(&tool, &a, &b, &CastOptions::default().with_tolerance(TOLERANCE)).unwrap().expect("a hit");
            let height = cast.pose.translation()[2];
            let ulp = speed * 1e-12;
            assert!((-ulp..=TOLERANCE + ulp).contains(&height), "{height} at {speed}");
            assert!((cast.fraction * speed - 0.25).abs() <= TOLERANCE + ulp);
            assert!(cast.normal[2] > 0.999_999, "{:?}", cast.normal);
            assert!(cast.point[2].abs() < 1e-9);
            // Upwards is free, and so is sliding along at a small height.
            assert_eq!(
                scene
                    .cast(&tool, &a, &moved([0.0, 0.0, speed]), &CastOptions::default().with_tolerance(TOLERANCE))
                    .unwrap(),
                None
            );
            let (a, b) = (moved([-9.0, 0.0, 1e-7]), moved([9.0, 0.0, 1e-7]));
            assert_eq!(scene.cast(&tool, &a, &b, &CastOptions::default().with_tolerance(TOLERANCE)).unwrap(), None);
        }
    }
}

#[test]
fn beginning_in_contact_is_an_impact_at_once() {
    let mockup = mockup_of(ball(12, 0.5));
    let tool = tool_of(ball(10, 0.2));
    for storage in STORAGES {
        let scene = scene_of(&mockup, storage);
        let cast = scene
            .cast(
                &tool,
                &moved([0.4, 0.0, 0.0]),
                &moved([2.0, 0.0, 0.0]),
                &CastOptions::default().with_tolerance(TOLERANCE),
            )
            .unwrap()
            .unwrap();
        assert_eq!((cast.fraction, cast.distance), (0.0, 0.0));
        assert_eq!(cast.pose, moved([0.4, 0.0, 0.0]));
        // Inside, without touching the surface: free until it is reached.
        let cast = scene
            .cast(&tool, &moved([0.0; 3]), &moved([2.0, 0.0, 0.0]), &CastOptions::default().with_tolerance(TOLERANCE))
            .unwrap()
            .unwrap();
        assert!(cast.fraction > 0.14 && cast.fraction < 0.151, "{}", cast.fraction);
    }
}

#[test]
fn standing_still_is_a_collision_query() {
    let mockup = mockup_of(sheet(1.0));
    let scene = scene_of(&mockup, Storage::Blocks);
    let tool = tool_of(bar([0.1, 0.1, 0.1]));
    let still = |z: f64| {
        scene
            .cast(
                &tool,
                &moved([0.0, 0.0, z]),
                &moved([0.0, 0.0, z]),
                &CastOptions::default().with_tolerance(TOLERANCE),
            )
            .unwrap()
    };
    assert_eq!(still(1e-300), None);
    assert_eq!(still(0.0).map(|cast| cast.fraction), Some(0.0));
    assert_eq!(still(-0.05).map(|cast| cast.distance), Some(0.0));
    let check = scene.check_path(&tool, &[moved([0.0; 3])], &PathOptions::default().with_tolerance(TOLERANCE)).unwrap();
    assert_eq!((check.segments, check.hits.len()), (1, 1));
}

#[test]
fn half_a_turn_of_a_long_bar_meets_a_thin_post() {
    // The bar lies along x; the post stands on its way, at 80 degrees, where neither end of the turn is near it.
    let (s, c) = 80f64.to_radians().sin_cos();
    let post: Arrays = {
        let (x, y) = (0.8 * c, 0.8 * s);
        (vec![[x, y, -1.0], [x + 1e-5, y, 1.0], [x, y + 1e-5, 1.0]], vec![[0, 1, 2]])
    };
    let mockup = mockup_of(post);
    // Centred on its box: a motion turns about the middle of the box.
    let tool = tool_of(placed(bar([2.0, 0.01, 0.01]), 1.0, 0.0));
    for storage in STORAGES {
        let scene = scene_of(&mockup, storage);
        for turn in [std::f64::consts::PI, 3.0, 2.0] {
            let pose = |angle: f64| {
                let m = turned(2, angle, [0.0; 3]);
                let middle = m.apply(&[1.0, 0.005, 0.005]);
                turned(2, angle, [-middle[0], -middle[1], -middle[2]])
            };
            // Half a turn may go either way round: one end of the bar or the other hits the post.
            let (a, b) = (pose(0.0), pose(turn));
            let cast =
                scene.cast(&tool, &a, &b, &CastOptions::default().with_tolerance(TOLERANCE)).unwrap().expect("a hit");
            check(&mockup, &tool, (&a, &b), Some(&cast), 400, "half a turn");
            let met = cast.fraction * turn;
            assert!((1.2..1.5).contains(&met) || (1.6..2.0).contains(&met), "{met}");
        }
    }
}

#[test]
fn nothing_tunnels() {
    let runs = std::env::var("FEELER_CASTS").ok().and_then(|n| n.parse().ok()).unwrap_or(4_000);
    let sheet_and_wire = |r: &mut Random| {
        let a = r.point(-0.3, 0.3);
        let width = 10f64.powf(r.real(-9.0, -3.0));
        let wire = [a, [a[0] + r.real(-1.0, 1.0), a[1] + r.real(-1.0, 1.0), a[2] + 1.0], [a[0] + width, a[1], a[2]]];
        arrays_of([wire, std::array::from_fn(|_| r.point(-0.5, 0.5))])
    };
    let tool = tool_of(placed(bar([0.5, 0.04, 0.02]), 1.0, 0.0));
    let mut hits = 0;
    for seed in 0..runs {
        let mut r = Random::new(seed);
        let mockup = mockup_of(sheet_and_wire(&mut r));
        let scene = scene_of(&mockup, STORAGES[(seed % 5) as usize]);
        // From one side to the other, so that most motions pass right through while they spin.
        let (mut a, mut b) = (r.pose(2.0).matrix(), r.pose(2.0).matrix());
        let middle = r.point(-0.3, 0.3);
        let speed = [0.2, 1.0, 30.0][(seed % 3) as usize];
        for k in 0..3 {
            a[k][3] = middle[k] + speed * r.real(-1.0, 1.0);
            b[k][3] = middle[k] - (a[k][3] - middle[k]);
        }
        let (a, b) = (Pose::new(&a).unwrap(), Pose::new(&b).unwrap());
        let found = scene.cast(&tool, &a, &b, &CastOptions::default().with_tolerance(TOLERANCE)).unwrap();
        check(&mockup, &tool, (&a, &b), found.as_ref(), 40, &format!("seed {seed}"));
        hits += u64::from(found.is_some());
    }
    assert!(hits > runs / 4, "{hits} of {runs}");
}

#[test]
fn bad_tolerances_and_paths() {
    let mockup = mockup_of(sheet(1.0));
    let scene = scene_of(&mockup, Storage::Blocks);
    let tool = tool_of(bar([0.1, 0.1, 0.1]));
    let (a, b) = (moved([0.0, 0.0, 1.0]), moved([0.0, 0.0, -1.0]));
    for tolerance in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(
            matches!(
                scene.cast(&tool, &a, &b, &CastOptions::default().with_tolerance(tolerance)),
                Err(Error::Tolerance { .. })
            ),
            "{tolerance}"
        );
        assert!(scene.check_path(&tool, &[a, b], &PathOptions::default().with_tolerance(tolerance)).is_err());
    }
    for tolerance in [5e-324, 1e-30, 1.0, 1e300] {
        let cast =
            scene.cast(&tool, &a, &b, &CastOptions::default().with_tolerance(tolerance)).unwrap().expect("a hit");
        assert!(cast.fraction <= 0.5 && cast.pose.translation()[2] >= 0.0, "{tolerance}: {}", cast.fraction);
    }
    assert_eq!(scene.check_path(&tool, &[], &PathOptions::default().with_tolerance(1e-6)), Err(Error::EmptyPath));
    assert_eq!(
        scene.check_path(&tool, &[a, b], &PathOptions::default().with_tolerance(1e-6).with_progress(&|_, _| false)),
        Err(Error::Cancelled)
    );
}

#[test]
fn a_path_is_its_segments() {
    let mockup = mockup_of(ball(12, 0.5));
    let scene = scene_of(&mockup, Storage::Blocks);
    let tool = tool_of(ball(6, 0.1));
    let mut r = Random::new(3);
    let poses: Vec<Pose> = (0..5000).map(|_| r.pose(0.9)).collect();
    let check = scene.check_path(&tool, &poses, &PathOptions::default().with_tolerance(TOLERANCE)).unwrap();
    let mut hits = check.hits.iter().peekable();
    for i in 0..poses.len() - 1 {
        let alone =
            scene.cast(&tool, &poses[i], &poses[i + 1], &CastOptions::default().with_tolerance(TOLERANCE)).unwrap();
        let found = hits.next_if(|(segment, _)| *segment == i).map(|(_, cast)| *cast);
        assert_eq!(alone, found, "segment {i}");
    }
    assert!(hits.next().is_none() && check.segments == 4999);
    assert!((500..4500).contains(&check.hits.len()), "{} hits", check.hits.len());
}

#[test]
fn the_way_begins_and_ends_at_the_poses_given_and_stays_rigid() {
    let mut r = Random::new(11);
    let tool = tool_of(bar([0.3, 0.2, 0.1]));
    for i in 0..2000 {
        let [a, b] = [0, 1].map(|k| {
            let mut m = r.pose(3.0).matrix();
            if i % 2 == 1 {
                // A pose that is only just rigid enough.
                m.iter_mut().take(3).for_each(|row| (0..3).for_each(|c| row[c] += r.real(-1.6e-7, 1.6e-7)));
            }
            if i % 5 == 0 && k == 1 {
                m = turned(i % 3, std::f64::consts::PI, r.point(-1.0, 1.0)).matrix();
            }
            Pose::new(&m).unwrap()
        });
        let motion = Motion::new(&tool, &a, &b);
        assert_eq!((motion.at(0.0), motion.at(1.0)), (a, b));
        let step = |x: &Pose, y: &Pose, p: &Point| {
            let (x, y) = (x.apply(p), y.apply(p));
            (0..3).map(|k| (x[k] - y[k]) * (x[k] - y[k])).sum::<f64>().sqrt()
        };
        let mut last = a;
        for k in 1..=64 {
            let pose = motion.at(f64::from(k) / 64.0);
            assert!(Pose::new(&pose.matrix()).is_ok(), "{i} {k}");
            let way = step(&pose, &last, &[0.3, 0.2, 0.1]);
            assert!(way <= motion.longest_way() / 64.0 * (1.0 + 1e-4) + 1e-5, "{i} {k}: {way}");
            last = pose;
        }
        // The ends are limits, but for rounding.
        for (time, end) in [(1e-13, a), (1.0 - 1e-13, b)] {
            assert!(step(&motion.at(time), &end, &[0.3, 0.2, 0.1]) < 1e-11, "{i}");
        }
    }
}

#[test]
fn huge_and_tiny_coordinates_are_never_late() {
    for (scale, offset) in
        [(1e-9, 0.0), (1e6, 0.0), (1.0, 1e6), (1e-3, -1e9), (1e50, 0.0), (1e-120, 0.0), (1e-170, 0.0), (1e90, 0.0)]
    {
        let mockup = mockup_of(placed(sheet(1.0), scale, offset));
        let tool = tool_of(placed(bar([0.1, 0.1, 0.1]), scale, 0.0));
        for storage in STORAGES {
            let scene = scene_of(&mockup, storage);
            let place = |z: f64| {
                let m = turned(2, z, [offset, offset, offset + z * scale]);
                Pose::new(&m.matrix()).unwrap()
            };
            let (a, b) = (place(0.4), place(-0.5));
            if let Some(cast) = scene.cast(&tool, &a, &b, &CastOptions::default().with_tolerance(scale * 1e-6)).unwrap()
            {
                assert!(cast.fraction <= 0.445, "{scale} {offset}: {}", cast.fraction);
            } else {
                panic!("through the sheet at {scale} {offset}");
            }
        }
    }
}

#[test]
fn a_spinning_tool_meets_a_speck() {
    // The pivot is 1 m from the speck, which lies at the origin, where float64 can hold it. The blade starts above and behind it, on its
    // way up, and comes round: only its acceleration shows that it will meet.
    let (sine, cosine) = 89f64.to_radians().sin_cos();
    for (scale, speck) in [(1.0, 1e-9), (1.0, 1e-60), (1.0, 1e-100), (1.0, 1e-160), (1e-150, 1e-7), (1e-170, 1e-7)] {
        let blade = |side: f64| {
            [[-1.0, 0.9], [1.0, 0.9], [0.0, 1.2]]
                .map(|[x, r]| [x, side * r * cosine, side * r * sine].map(|x| x * scale))
        };
        let tool = tool_of(arrays_of([blade(1.0), blade(-1.0)]));
        let speck = speck * scale;
        let mockup = mockup_of(arrays_of([[[-speck, -speck, 0.0], [speck, -speck, 0.0], [0.0, speck, 0.0]]]));
        let at = [0.0, 0.75f64.sqrt() * scale, 0.5 * scale];
        let (a, b) = (turned(0, 0.0, at), turned(0, 3.0, at));
        let met = 121f64.to_radians() / 3.0;
        let plain = cast_all_pairs(mockup.mesh(), &tool, &Motion::new(&tool, &a, &b), TOLERANCE * scale).unwrap();
        let found = STORAGES.map(|storage| {
            scene_of(&mockup, storage)
                .cast(&tool, &a, &b, &CastOptions::default().with_tolerance(TOLERANCE * scale))
                .unwrap()
        });
        for cast in found.into_iter().chain([plain]) {
            let cast = cast.unwrap_or_else(|| panic!("through a speck of {speck:e} m"));
            assert!(cast.fraction < met + 1e-6, "{speck:e}: {}", cast.fraction);
            assert!(cast.fraction > met - 1e-5, "{speck:e}: {}", cast.fraction);
        }
    }
}

#[test]
fn a_long_blade_that_passes_is_not_stopped() {
    // A blade 1 m wide and 4.5e9 m long, whose own plane holds it off a small triangle by too little to go on with.
    let tool = tool_of(arrays_of([[[0.9, 1.0, 0.9], [1.0, 1.3, 1.3], [0.0, -4550284083.2, 1.2]]]));
    let mockup = mockup_of(arrays_of([[[0.8, 0.6, 0.6], [1.3, 0.8, 1.1], [1.1, 0.015237215161323548, 0.6]]]));
    let pose = |rows: [[f64; 4]; 3]| Pose::new(&[rows[0], rows[1], rows[2], [0.0, 0.0, 0.0, 1.0]]).unwrap();
    let a = pose([[1.0, -4e-7, 0.0, 1000.0], [0.0, 0.6, -0.8, -4000.0], [0.0, 0.8, 0.6, 1000.0]]);
    let b = pose([[1.0, 0.0, 0.0, 0.5], [0.0, 0.0, 1.0, -0.2], [0.0, -1.0, 0.0, -0.4]]);
    let plain = cast_all_pairs(mockup.mesh(), &tool, &Motion::new(&tool, &a, &b), TOLERANCE).unwrap();
    let found = STORAGES.map(|storage| {
        scene_of(&mockup, storage).cast(&tool, &a, &b, &CastOptions::default().with_tolerance(TOLERANCE)).unwrap()
    });
    // It passes by. The gap is smaller than the error bounds for its length, but too large to report an impact.
    assert_eq!((plain, found), (None, [None; 5]));
    check(&mockup, &tool, (&a, &b), None, 20_000, "a long blade");
}

#[test]
fn directions_that_hold_apart_tell_in_the_time_alone() {
    // A fine wavy floor, a bar that slides over it, dips into it, turns and flies off: with the floor's normals, odd ones, and none.
    let n = 24;
    let height = |i: usize, j: usize| 0.01 * (0.9 * i as f64).sin() * (0.7 * j as f64).cos();
    let vertices =
        (0..=n).flat_map(|i| (0..=n).map(move |j| [0.05 * i as f64, 0.05 * j as f64, height(i, j)])).collect();
    let at = |i: usize, j: usize| (i * (n + 1) + j) as u32;
    let faces = (0..n)
        .flat_map(|i| (0..n).map(move |j| (i, j)))
        .flat_map(|(i, j)| [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]])
        .collect();
    let mockup = Arc::new(Mockup::new(vertices, faces, vec![], 1).unwrap());
    let scene = scene_of(&mockup, Storage::Blocks);
    let (vertices, faces) = bar([0.3, 0.1, 0.05]);
    let tool = Tool::new(vertices, faces).unwrap();
    let slope = |x: f64, y: f64| [x, y, (1.0 - x * x - y * y).sqrt()];
    let normals: Vec<Point> = (0..9).map(|i| slope(0.1 * f64::from(i % 3 - 1), 0.1 * f64::from(i / 3 - 1))).collect();
    let odd = [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.6, 0.0, 0.8], [0.0; 3]];
    let (mut hits, mut free) = (0, 0);
    for i in 0..400 {
        let wave = |k: f64| (k * f64::from(i) + k).sin();
        let low = 0.011 + 0.01 * wave(2.1);
        let from =
            turned((i % 3) as usize, 0.05 * wave(0.3), [0.4 + 0.2 * wave(1.3), 0.4 + 0.2 * wave(0.7), low + 0.02]);
        let to = turned((i % 3) as usize, 0.3 * wave(1.9), [0.4 + 0.3 * wave(0.9), 0.4 + 0.3 * wave(1.1), low]);
        let expected = scene.cast(&tool, &from, &to, &CastOptions::default().with_tolerance(TOLERANCE)).unwrap();
        for directions in [&normals[..], &odd[..], &[]] {
            let found = scene
                .cast_along(
                    &tool,
                    &Motion::new(&tool, &from, &to),
                    &CastOptions::default().with_tolerance(TOLERANCE).with_directions(directions),
                )
                .unwrap();
            assert_eq!(found.is_some(), expected.is_some(), "{i}");
            if let (Some(found), Some(expected)) = (found, expected) {
                assert!((found.fraction - expected.fraction).abs() < 1e-5, "{i} {found:?} {expected:?}");
                check(&mockup, &tool, (&from, &to), Some(&found), 10, "beside");
            }
        }
        *(if expected.is_some() { &mut hits } else { &mut free }) += 1;
    }
    assert!(hits > 50 && free > 50, "{hits} {free}");
}

/// A peg of many facets in a bore of many others follows thousands of pairs, and then asks for shadows.
#[test]
fn a_peg_stops_at_the_bottom_of_a_tight_bore() {
    let (vertices, faces) = feeler_shapes::cylinder(0.0101, 0.1, 100, 16);
    let mockup = Arc::new(Mockup::new(vertices, faces, vec![], 1).unwrap());
    let (vertices, faces) = feeler_shapes::cylinder(0.01, 0.03, 96, 8);
    let tool = Tool::new(vertices, faces).unwrap();
    let scene = scene_of(&mockup, Storage::Blocks);
    let axis = [1.0, 0.0, 0.0];
    let far = Pose::IDENTITY.translated(&[0.1, 0.0, 0.0]).unwrap();
    let screw = Screw::new(&axis, &[0.0; 3], 20.0, 0.1 * std::f64::consts::TAU / 20.0).unwrap();
    for motion in [Motion::new(&tool, &Pose::IDENTITY, &far), Motion::screw(&tool, &Pose::IDENTITY, &screw).unwrap()] {
        // 35 mm to the end of the bore, of 100.
        let hit = scene.cast_along(&tool, &motion, &CastOptions::default().with_tolerance(TOLERANCE)).unwrap().unwrap();
        assert!(hit.fraction <= 0.35 && hit.fraction > 0.35 - 20.0 * TOLERANCE, "{}", hit.fraction);
    }
    let turn = Screw::new(&axis, &[0.0; 3], 50.0, 0.0).unwrap();
    let motion = Motion::screw(&tool, &Pose::IDENTITY, &turn).unwrap();
    for touching in [Touching::Ends, Touching::Free] {
        assert!(scene
            .cast_along(&tool, &motion, &CastOptions::default().with_tolerance(TOLERANCE).with_touching(touching))
            .unwrap()
            .is_none());
    }
}
