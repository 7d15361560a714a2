//! Casts with free touching: bodies slide, are pulled out of seats and lifted off; they end where one enters another.

mod common;

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use common::*;
use feeler_core::{
    CastOptions, Mockup, Motion, PathOptions, Point, Pose, Scene, SceneOptions, Storage, Tool, Touching,
};
use feeler_shapes::{box_mesh, joined};

const TOLERANCE: f64 = 1e-6;

fn scene_of((vertices, faces): Arrays, storage: Storage) -> Scene {
    let mockup = Arc::new(Mockup::new(vertices, faces, Vec::new(), 1).unwrap());
    Scene::build(mockup, &SceneOptions::default().with_storage(storage)).unwrap()
}

fn block(lower: Point, upper: Point, cells: usize) -> Arrays {
    let middle = std::array::from_fn(|a| 0.5 * (lower[a] + upper[a]));
    box_mesh(middle, std::array::from_fn(|a| upper[a] - lower[a]), cells)
}

/// A square hole of 16 mm through a plate of 31 mm, as four walls; its top is at z = 0. All numbers are exact in float64.
fn hole(cells: usize) -> Arrays {
    let walls =
        [([-3, -3, -2], [-1, 3, 0]), ([1, -3, -2], [3, 3, 0]), ([-1, -3, -2], [1, -1, 0]), ([-1, 1, -2], [1, 3, 0])];
    joined(walls.map(|(lower, upper)| block(lower.map(in_128ths), upper.map(in_128ths), cells)))
}

fn in_128ths(x: i32) -> f64 {
    f64::from(x) / 128.0
}

fn turned(angle: f64, at: Point) -> Pose {
    let (s, c) = angle.sin_cos();
    Pose::new(&[[c, -s, 0.0, at[0]], [s, c, 0.0, at[1]], [0.0, 0.0, 1.0, at[2]], [0.0, 0.0, 0.0, 1.0]]).unwrap()
}

/// The fraction at which a motion ends, or `None`.
fn end(scene: &Scene, tool: &Tool, way: [Pose; 2]) -> Option<f64> {
    let found = scene
        .cast(tool, &way[0], &way[1], &CastOptions::default().with_tolerance(TOLERANCE).with_touching(Touching::Free))
        .unwrap();
    let path = scene
        .check_path(tool, &way, &PathOptions::default().with_tolerance(TOLERANCE).with_touching(Touching::Free))
        .unwrap();
    assert_eq!(path.hits.first().map(|(_, hit)| *hit), found);
    found.map(|hit| hit.fraction)
}

#[test]
fn a_seated_pin_is_drawn_out_and_put_back_and_not_turned() {
    for storage in [Storage::Blocks, Storage::Dense] {
        for cells in 1..4 {
            let scene = scene_of(hole(1 << (3 - cells)), storage);
            let pin = block([-1, -1, -2].map(in_128ths), [1, 1, 2].map(in_128ths), 1 << (cells - 1));
            let pin = tool_of(pin);
            let (seated, out) = (moved([0.0; 3]), moved([0.0, 0.0, 0.05]));
            assert!(scene
                .cast(&pin, &seated, &out, &CastOptions::default().with_tolerance(TOLERANCE))
                .unwrap()
                .is_some_and(|hit| hit.fraction == 0.0));
            assert_eq!(end(&scene, &pin, [seated, out]), None);
            assert_eq!(end(&scene, &pin, [out, seated]), None);
            // Turned in its seat it jams at once, where its edges are in the walls by the tolerance.
            let jammed = end(&scene, &pin, [seated, turned(0.1, [0.0; 3])]).unwrap();
            assert!((0.0..0.01).contains(&jammed), "{jammed}");
            // Beside the hole it stops at the plate.
            let beside = [moved([0.001, 0.0, 0.05]), moved([0.001, 0.0, 0.0])];
            let stopped = end(&scene, &pin, beside).unwrap();
            assert!((stopped - (1.0 - in_128ths(2) / 0.05)).abs() < 1e-4, "{stopped}");
            // Pushed sideways, it stops at once.
            let aside = end(&scene, &pin, [seated, moved([0.01, 0.0, 0.0])]).unwrap();
            assert!((0.0..=1.1e-4).contains(&aside), "{aside}");
        }
    }
}

#[test]
fn a_block_slides_over_a_table_and_off_its_edge() {
    let table = block([-1.0, -1.0, -0.1], [1.0, 1.0, 0.0], 7);
    let scene = scene_of(table, Storage::Blocks);
    for cells in 1..4 {
        let tool = tool_of(block([-0.1, -0.1, 0.0], [0.1, 0.1, 0.2], cells));
        let at = |x: f64, y: f64, z: f64| moved([x, y, z]);
        assert_eq!(end(&scene, &tool, [at(0.0, 0.0, 0.0), at(0.37, -0.21, 0.0)]), None);
        assert_eq!(end(&scene, &tool, [at(0.0, 0.0, 0.0), at(3.0, 0.0, 0.0)]), None);
        assert_eq!(end(&scene, &tool, [at(0.0, 0.0, 0.0), at(0.0, 0.0, 1.0)]), None);
        assert_eq!(end(&scene, &tool, [at(0.0, 0.0, 0.0), turned(2.0, [0.5, 0.2, 0.0])]), None);
        // Down along the side of the table, flush with it.
        assert_eq!(end(&scene, &tool, [at(1.1, 0.0, 0.5), at(1.1, 0.0, -1.0)]), None);
        // Into the table: from the start pose, from above, and from a pose flush beside it.
        let into = |way: [Pose; 2]| end(&scene, &tool, way).unwrap();
        assert!(into([at(0.0, 0.0, 0.0), at(0.0, 0.0, -0.3)]) <= 2e-5);
        assert!((into([at(0.0, 0.0, 0.1), at(0.0, 0.0, -0.3)]) - 0.25).abs() < 1e-4);
        assert!((into([at(1.3, 0.0, -0.15), at(0.7, 0.0, -0.15)]) - 1.0 / 3.0).abs() < 1e-4);
        // As wide as the table: its sides go on along the table's, and only the faces between them are in the way.
        let wide = tool_of(block([-1.0, -1.0, 0.0], [1.0, 1.0, 0.5], cells));
        assert!(end(&scene, &wide, [at(0.0, 0.0, 0.0), at(0.0, 0.0, -0.25)]).unwrap() <= 2e-5);
        assert_eq!(end(&scene, &wide, [at(0.0, 0.0, 0.0), at(0.0, 0.0, 0.25)]), None);
        // As high as the table: face on face along the whole motion.
        let flush = tool_of(block([-0.1, -0.1, -0.1], [0.1, 0.1, 0.0], cells));
        let stopped = end(&scene, &flush, [at(1.5, 0.0, 0.0), at(-9.0, 0.0, 0.0)]).unwrap();
        assert!((stopped - 0.4 / 10.5).abs() < 1e-4, "{stopped}");
        // In the table, its top in the table's: nothing crosses, and it is inside.
        assert_eq!(into([at(0.0, 0.0, -0.2), at(0.0, 0.0, 1.0)]), 0.0);
    }
}

#[test]
fn what_lies_deeper_by_rounding_is_lifted_off() {
    let scene = scene_of(block([-1.0, -1.0, -0.1], [1.0, 1.0, 0.0], 7), Storage::Blocks);
    let tool = tool_of(block([-0.1, -0.1, 0.0], [0.1, 0.1, 0.2], 2));
    let at = |x: f64, z: f64| moved([x, 0.0, z]);
    let within = |way: [Pose; 2]| {
        let found = scene
            .cast(
                &tool,
                &way[0],
                &way[1],
                &CastOptions::default().with_tolerance(TOLERANCE).with_touching(Touching::Within),
            )
            .unwrap();
        found.map(|hit| hit.fraction)
    };
    // A tenth of the tolerance in the table: exactly, it is in it at once.
    let sunk = -0.1 * TOLERANCE;
    assert_eq!(end(&scene, &tool, [at(0.0, sunk), at(0.5, sunk)]), Some(0.0));
    // It can be lifted off, and it slides. The slide may end at the next triangle, because the tool is that deep below its edge.
    assert!(within([at(0.0, sunk), at(0.5, sunk)]).is_none_or(|slid| slid > 0.1));
    assert_eq!(within([at(0.0, sunk), at(0.0, 0.5)]), None);
    assert_eq!(within([at(0.0, sunk), at(0.0, sunk)]), None);
    // It goes no deeper than the tolerance, and a tool that comes from afar stops.
    assert!(within([at(0.0, sunk), at(0.0, -0.1)]).unwrap() <= 2e-5);
    assert!((within([at(0.0, 0.1), at(0.0, -0.3)]).unwrap() - 0.25).abs() < 1e-4);
}

#[test]
fn flat_faces_and_sheets_stop_each_other() {
    let sheet = feeler_shapes::sheet(3, 3, |s, t| [4.0 * s - 2.0, 4.0 * t - 2.0, 0.0]);
    let scene = scene_of(sheet.clone(), Storage::Blocks);
    let plate = tool_of(sheet);
    let small = tool_of(feeler_shapes::sheet(2, 2, |s, t| [s, t, 0.0]));
    for tool in [&plate, &small] {
        let stopped = end(&scene, tool, [moved([0.0, 0.0, 1.0]), moved([0.0, 0.0, -9.0])]).unwrap();
        assert!((stopped - 0.1).abs() < 1e-6, "{stopped}");
        // Flush, slid aside, and lifted off on either side.
        let flush = moved([0.1, 0.2, 0.0]);
        assert_eq!(end(&scene, tool, [flush, moved([0.7, -0.3, 0.0])]), None);
        assert_eq!(end(&scene, tool, [flush, moved([0.1, 0.2, 1.0])]), None);
        assert_eq!(end(&scene, tool, [flush, moved([0.1, 0.2, -1.0])]), None);
    }
}

#[test]
fn loose_triangles_end_a_way_where_they_cross() {
    let mut r = Random::new(5);
    let (mut ends, mut late) = (0, 0.0f64);
    for storage in STORAGES {
        let scene = scene_of(soup(1, 400, 0.05), storage);
        let tool = tool_of(placed(soup(9, 12, 0.05), 0.15, 0.3));
        for i in 0..60 {
            let place = |r: &mut Random| {
                let mut m = r.pose(0.0).matrix();
                (0..3).for_each(|k| m[k][3] = r.real(0.0, 0.7));
                Pose::new(&m).unwrap()
            };
            let way = [place(&mut r), place(&mut r)];
            if scene.is_colliding(&tool, &way[0]) {
                continue;
            }
            let first = scene
                .cast(&tool, &way[0], &way[1], &CastOptions::default().with_tolerance(TOLERANCE))
                .unwrap()
                .map(|hit| hit.fraction);
            let free = end(&scene, &tool, way);
            // Passing by within the tolerance does not end the motion.
            let (Some(first), Some(free)) = (first, free) else {
                assert!(free.is_none(), "{i} {free:?}");
                continue;
            };
            let motion = Motion::new(&tool, &way[0], &way[1]);
            assert!(free >= first, "{i}: {free} {first}");
            late = late.max((free - first) * motion.longest_way());
            ends += 1;
        }
    }
    assert!(ends > 50 && late < 0.02, "{ends} ends, {late} late");
}

/// Loops of `sides` corners at radius and height, one after the other, closed by fans.
fn lathe(sides: u32, rows: &[[f64; 2]]) -> Arrays {
    let corner = |[r, z]: [f64; 2], k: u32| {
        let (s, c) = (TAU * f64::from(k) / f64::from(sides)).sin_cos();
        [r * c, r * s, z]
    };
    let mut vertices: Vec<Point> = rows.iter().flat_map(|row| (0..sides).map(|k| corner(*row, k))).collect();
    let last = rows.len() as u32 - 1;
    let ends = [0, last].map(|row| [0.0, 0.0, rows[row as usize][1]]);
    vertices.extend(ends);
    let middle = (last + 1) * sides;
    let mut faces = Vec::new();
    for k in 0..sides {
        let at = |row: u32, k: u32| row * sides + k % sides;
        for row in 0..last {
            let [a, b, c, d] = [at(row, k), at(row, k + 1), at(row + 1, k + 1), at(row + 1, k)];
            faces.extend([[a, b, c], [a, c, d]]);
        }
        faces.extend([[at(0, k + 1), at(0, k), middle], [at(last, k), at(last, k + 1), middle + 1]]);
    }
    (vertices, faces)
}

#[test]
fn a_shaft_goes_down_a_bore_to_its_bottom_and_across_it_to_its_wall() {
    // The bore's faces and the shaft's corners are at their radii from the axis: 1 % of play.
    let (sides, radius, bore, depth) = (48, 0.01, 0.0101, 0.05);
    let narrow = (PI / f64::from(sides)).cos();
    let block = lathe(sides, &[[bore / narrow, -depth], [bore / narrow, 0.0], [0.02, 0.0], [0.02, -0.06]]);
    let shaft = tool_of(lathe(sides, &[[radius, 0.0], [radius, 0.07]]));
    let side = PI / f64::from(sides);
    let off = |x: f64, z: f64| [x * side.cos(), x * side.sin(), z];
    // Where two flat sides meet.
    let play = bore - radius * narrow;
    for storage in [Storage::Blocks, Storage::Dense] {
        let scene = scene_of(block.clone(), storage);
        for touching in [Touching::Ends, Touching::Free, Touching::Within] {
            let cast = |from: Pose, to: Pose| {
                scene
                    .cast(&shaft, &from, &to, &CastOptions::default().with_tolerance(TOLERANCE).with_touching(touching))
                    .unwrap()
                    .map(|hit| hit.fraction)
            };
            // Early by the tolerance at most where contact ends it, else late by no more.
            let assert_ends = |found: Option<f64>, at: f64, way: f64| {
                let late = (found.unwrap() - at) * way;
                let range = if touching == Touching::Ends { -TOLERANCE..=1e-12 } else { -1e-12..=TOLERANCE * 1.001 };
                assert!(range.contains(&late), "{late} {touching:?} {storage:?}");
            };
            for x in [0.0, -0.5 * play, 0.99 * play] {
                let [top, low] = [-0.001, -0.0499].map(|z| moved(off(x, z)));
                assert_eq!(cast(top, low), None, "{x}");
                assert_eq!(cast(low, top), None, "{x}");
                assert_ends(cast(top, moved(off(x, -0.06))), 0.049 / 0.059, 0.059);
            }
            // It turns as it goes down: still within the play.
            assert_eq!(cast(moved([0.0, 0.0, -0.001]), turned(1.0, [0.0, 0.0, -0.0499])), None);
            assert_ends(cast(moved([0.0, 0.0, -0.001]), turned(1.0, [0.0, 0.0, -0.06])), 0.049 / 0.059, 0.059);
            let across = cast(moved([0.0, 0.0, -0.03]), moved(off(3.0 * play, -0.03)));
            assert_ends(across, 1.0 / 3.0, 3.0 * play);
        }
    }
}
