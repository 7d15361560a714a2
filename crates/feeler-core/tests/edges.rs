//! The edges of the way to the triangle test: contacts of a single point, exactly on the borders of voxels, blocks and grid,
//! near and far from the origin. Each contact is known beforehand, and no store at any voxel size may lose it.

mod common;

use std::sync::Arc;

use common::*;
use feeler_core::{Mockup, PairKind, Point, Pose, Scene, SceneOptions, Storage, Tool, Triangle};

/// Voxel sizes that put borders at whole numbers of the unit, and one that does not.
const SIZES: [f64; 5] = [0.25, 0.5, 1.0, 0.3, 64.0];

fn soup(triangles: &[Triangle]) -> (Vec<Point>, Vec<[u32; 3]>) {
    let faces = (0..triangles.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    (triangles.iter().flatten().copied().collect(), faces)
}

/// The tool stays where its coordinates put it, relative to `origin`; `unit` scales everything. Sums and products of the
/// numbers used are exact.
fn check(name: &str, mockup: &[Triangle], tool: &[Triangle], expected: &[([u32; 2], PairKind)]) {
    for (unit, origin) in
        [(1.0, 0.0), (0.125, 4096.0), (2f64.powi(-20), 2f64.powi(20)), (2f64.powi(-1000), 0.0), (2f64.powi(300), 0.0)]
    {
        let place = |t: &Triangle| t.map(|p| p.map(|x| x * unit + origin));
        let (vertices, faces) = soup(&mockup.iter().map(place).collect::<Vec<_>>());
        let mockup = Arc::new(Mockup::new(vertices, faces, Vec::new(), 1).unwrap());
        let (vertices, faces) = soup(&tool.iter().map(place).collect::<Vec<_>>());
        let tool = Tool::new(vertices, faces).unwrap();
        for storage in STORAGES {
            for size in SIZES {
                let voxel_size = Some(size * unit);
                let options = SceneOptions::default()
                    .with_voxel_size(voxel_size)
                    .with_storage(storage)
                    .with_memory_limit(1 << 28);
                let scene = Scene::build(Arc::clone(&mockup), &options).unwrap();
                scene.validate().unwrap();
                let found = scene.collide(&tool, &Pose::IDENTITY);
                let found: Vec<_> = found.pairs.into_iter().zip(found.kinds).collect();
                assert_eq!(found, expected, "{name}: {storage:?}, voxels of {size}, unit {unit:e} at {origin}");
            }
        }
    }
}

/// Two triangles far apart, so that the grid's box is known: from 0 to 16 on every axis.
fn frame() -> Vec<Triangle> {
    vec![
        [[0.0, 0.0, 0.0], [0.5, 0.0, 0.0], [0.0, 0.5, 0.0]],
        [[16.0, 16.0, 16.0], [15.5, 16.0, 16.0], [16.0, 15.5, 16.0]],
    ]
}

fn with_frame(t: &[Triangle]) -> Vec<Triangle> {
    frame().into_iter().chain(t.iter().copied()).collect()
}

#[test]
fn a_vertex_on_a_voxel_border_touched_from_either_side() {
    // The vertex (4, 4, 4) is a corner of eight voxels; one triangle lies in an octant, its mirror image in the opposite one.
    for octant in 0..8 {
        let s: Point = std::array::from_fn(|a| if octant >> a & 1 == 1 { 1.0 } else { -1.0 });
        let from = |d: f64| -> Triangle {
            [
                [4.0; 3],
                [4.0 + d * s[0], 4.0 + d * s[1], 4.0 + 0.5 * d * s[2]],
                [4.0 + 0.5 * d * s[0], 4.0 + d * s[1], 4.0 + d * s[2]],
            ]
        };
        check("vertex on a border", &with_frame(&[from(1.5)]), &[from(-1.5)], &[([0, 2], PairKind::Coplanar)]);
    }
}

#[test]
fn triangles_in_a_voxel_face() {
    // Both in the plane x = 4, a border of every voxel size but one: an overlap, a shared edge and a shared corner.
    let wall: Triangle = [[4.0, 4.0, 4.0], [4.0, 8.0, 4.0], [4.0, 4.0, 8.0]];
    for (tool, kind) in [
        ([[4.0, 5.0, 5.0], [4.0, 9.0, 5.0], [4.0, 5.0, 9.0]], Some(PairKind::Coplanar)),
        ([[4.0, 4.0, 4.0], [4.0, 8.0, 4.0], [4.0, 4.0, 2.0]], Some(PairKind::Coplanar)),
        ([[4.0, 8.0, 4.0], [4.0, 9.0, 4.0], [4.0, 9.0, 5.0]], Some(PairKind::Coplanar)),
        ([[4.0, 6.0, 4.0], [2.0, 6.0, 4.0], [2.0, 6.0, 5.0]], Some(PairKind::Touching)),
        ([[4.0, 6.0, 4.0], [6.0, 6.0, 4.0], [6.0, 6.0, 5.0]], Some(PairKind::Touching)),
        ([[4.25, 5.0, 5.0], [4.25, 9.0, 5.0], [4.25, 5.0, 9.0]], None),
        ([[4.0, 7.0, 6.0], [4.0, 9.0, 6.0], [4.0, 9.0, 7.0]], None),
    ] {
        let expected: Vec<_> = kind.into_iter().map(|kind| ([0, 2], kind)).collect();
        check("triangle in a voxel face", &with_frame(&[wall]), &[tool], &expected);
    }
}

#[test]
fn a_tool_half_outside_the_grid() {
    // Long triangles that leave the mock-up's box on every side and meet one small triangle at the box's very corner or
    // face, or pass a quarter beside it.
    let corner: Triangle = [[16.0, 16.0, 16.0], [15.0, 16.0, 16.0], [16.0, 15.0, 16.0]];
    let mockup = vec![frame()[0], corner];
    let through: Triangle = [[16.0, 16.0, 0.0], [16.0, 16.0, 64.0], [64.0, 64.0, 64.0]];
    check("edge through the corner", &mockup, &[through], &[([0, 1], PairKind::Touching)]);
    let beside = through.map(|[x, y, z]| [x + 0.25, y + 0.25, z]);
    check("beside the corner", &mockup, &[beside], &[]);
    let across: Triangle = [[-64.0, 15.5, 16.0], [64.0, 15.5, 16.0], [64.0, 15.5, 96.0]];
    check("edge across the top", &mockup, &[across], &[([0, 1], PairKind::Touching)]);
    let low: Triangle = [[-64.0, 0.25, -64.0], [64.0, 0.25, 64.0], [64.0, 0.25, -64.0]];
    check("through the bottom", &mockup, &[low], &[([0, 0], PairKind::Crossing)]);
    // Around everything, touching nothing.
    let far: Triangle = [[-64.0, -64.0, -0.5], [64.0, -64.0, -0.5], [0.0, 96.0, -0.5]];
    check("below everything", &mockup, &[far], &[]);
}

#[test]
fn a_needle_through_many_voxels_and_pieces() {
    // Cut into many pieces; met once, at a point that no cut hits, by a triangle's corner from each side.
    let needle: Triangle = [[0.0, 0.0, 0.0], [16.0, 16.0, 16.0], [16.0, 16.0, 15.75]];
    let mockup = vec![needle];
    for at in [1.0, 5.0, 9.0, 15.0] {
        for side in [1.0, -1.0] {
            let tool: Triangle = [[at, at, at], [at + side, at - side, at], [at + side, at - side, at + 0.5]];
            check("corner on a needle", &mockup, &[tool], &[([0, 0], PairKind::Touching)]);
        }
        let beside: Triangle = [[at + 0.25, at - 0.25, at], [at + 1.0, at - 1.0, at], [at + 1.0, at - 1.0, at + 0.5]];
        check("corner beside a needle", &mockup, &[beside], &[]);
    }
}

#[test]
fn a_million_metres_out_with_features_of_a_micrometre() {
    // At 1e6 m neighbouring float64 numbers are 1.2e-10 m apart: a gap of one of them is a gap.
    let at = 1e6f64;
    let feature = 1e-6;
    let step = f64::from_bits(at.to_bits() + 1) - at;
    let base: Triangle = [[at, at, at], [at + feature, at, at], [at, at + feature, at]];
    let mockup = |t: Triangle| {
        let (vertices, faces) = soup(&[t]);
        Arc::new(Mockup::new(vertices, faces, Vec::new(), 1).unwrap())
    };
    for gap in [0.0, step] {
        let lifted = [[at, at, at + gap], [at + feature, at, at + feature], [at, at + feature, at + feature]];
        let (vertices, faces) = soup(&[lifted]);
        let tool = Tool::new(vertices, faces).unwrap();
        for storage in STORAGES {
            for voxel_size in [None, Some(1e-7), Some(1e-6), Some(1.0)] {
                let options = SceneOptions::default()
                    .with_voxel_size(voxel_size)
                    .with_storage(storage)
                    .with_memory_limit(1 << 28);
                let scene = Scene::build(mockup(base), &options).unwrap();
                assert_eq!(
                    scene.is_colliding(&tool, &Pose::IDENTITY),
                    gap == 0.0,
                    "{storage:?} {voxel_size:?} gap {gap}"
                );
            }
        }
    }
    // The same reached by a pose: the tool's own coordinates are small, and rounded once when it moves out.
    let (vertices, faces) = soup(&[[[0.0; 3], [feature, 0.0, feature], [0.0, feature, feature]]]);
    let tool = Tool::new(vertices, faces).unwrap();
    let pose = |z: f64| {
        Pose::new(&[[1.0, 0.0, 0.0, at], [0.0, 1.0, 0.0, at], [0.0, 0.0, 1.0, z], [0.0, 0.0, 0.0, 1.0]]).unwrap()
    };
    let scene = Scene::build(mockup(base), &SceneOptions::default().with_storage(Storage::Blocks));
    let scene = scene.unwrap();
    assert!(scene.is_colliding(&tool, &pose(at)));
    assert!(!scene.is_colliding(&tool, &pose(at + step)));
}

#[test]
fn a_mesh_of_1e_160_metres_does_not_fill_every_voxel() {
    // Found by fuzzing: products of such coordinates underflow, no axis seemed to separate, and every triangle was listed in
    // every voxel of its box, for seconds.
    let unit = 1e-160;
    let t: Triangle = [[0.0; 3], [-3.0 * unit, 2.0 * unit, -unit], [-4.0 * unit, -4.0 * unit, -4.0 * unit]];
    let (vertices, faces) = soup(&[t]);
    let mockup = Arc::new(Mockup::new(vertices, faces, Vec::new(), 1).unwrap());
    for storage in [Storage::Dense, Storage::Hashed { level: 0.0 }] {
        let options =
            SceneOptions::default().with_voxel_size(0.05 * unit).with_storage(storage).with_memory_limit(1 << 28);
        let scene = Scene::build(Arc::clone(&mockup), &options).unwrap();
        let memory = scene.memory();
        let bytes = |name: &str| memory.iter().find(|(n, _)| *n == name).unwrap().1;
        // 80 voxels a side: the triangle's surface, not the box's volume.
        assert!(bytes("lists") < bytes("voxels") / 20, "{storage:?}: {memory:?}");
    }
}
