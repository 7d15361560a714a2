//! The closed forms against counting, and the search against looking everywhere.

use std::sync::Arc;

use super::cost_constants::CostConstants;
use super::piece_predictor::PiecePredictor;
use super::predictor::*;
use super::random::Random;
use super::sample::balance;
use super::work::{listed, work_of, Meeting, Shape, Visitor};
use crate::geometry::bounds::{Aabb, Point, Triangle};
use crate::index::blocks::Blocks;
use crate::index::grid::VoxelGrid;
use crate::index::store::Storage;
use crate::mesh::mockup::Mockup;
use crate::mesh::pieces::{cut_triangle, grown_box};
use crate::scene::{Scene, SceneOptions};
use crate::tool::moving_tool::Tool;

/// Wavy sheets here and there, `n` cells along each side, in a box of a metre.
fn sheets(n: u32, scale: f64) -> (Vec<Point>, Vec<[u32; 3]>) {
    let mut random = Random::new(11);
    let (mut vertices, mut faces) = (Vec::new(), Vec::new());
    for _ in 0..12 {
        let (turn, side) = (random.rotation(), 0.2 + 0.3 * random.unit());
        let at: Point = std::array::from_fn(|_| random.unit());
        let first = vertices.len() as u32;
        for i in 0..=n {
            for j in 0..=n {
                let (u, v) = (f64::from(i) / f64::from(n) - 0.5, f64::from(j) / f64::from(n) - 0.5);
                let p = [side * u, side * v, 0.03 * (7.0 * u).sin()];
                vertices.push(std::array::from_fn(|a| {
                    scale * (at[a] + turn[a][0] * p[0] + turn[a][1] * p[1] + turn[a][2] * p[2])
                }));
            }
        }
        for i in 0..n {
            for j in 0..n {
                let corner = first + i * (n + 1) + j;
                faces.push([corner, corner + 1, corner + n + 2]);
                faces.push([corner, corner + n + 2, corner + n + 1]);
            }
        }
    }
    (vertices, faces)
}

pub fn mockup(n: u32, scale: f64) -> Mockup {
    let (vertices, faces) = sheets(n, scale);
    Mockup::new(vertices, faces, Vec::new(), 1).unwrap()
}

pub fn tool(scale: f64) -> Tool {
    // A bar of long and short triangles.
    let (mut vertices, mut faces) = (Vec::new(), Vec::new());
    for i in 0..40u32 {
        let x = f64::from(i) * 0.005;
        let n = vertices.len() as u32;
        let long = if i % 8 == 0 { 0.2 } else { x + 0.006 };
        for p in [[x, 0.0, 0.0], [long, 0.004, 0.0], [x, 0.008, 0.003]] {
            vertices.push(p.map(|c| c * scale));
        }
        faces.push([n, n + 1, n + 2]);
    }
    Tool::new(vertices, faces).unwrap()
}

#[test]
fn a_triangle_is_listed_as_often_as_the_formula_says() {
    let mut random = Random::new(3);
    for _ in 0..20 {
        let t: Triangle = std::array::from_fn(|_| std::array::from_fn(|_| 1.0 + random.unit()));
        let d = 0.1 + 0.4 * random.unit();
        let mut sum = 0;
        for _ in 0..400 {
            let origin: Point = std::array::from_fn(|_| -d * random.unit());
            let grid = VoxelGrid::new(&Aabb { lower: origin, upper: [3.0; 3] }, d).unwrap();
            grid.for_each_voxel(&t, |_| sum += 1);
        }
        let (mean, expected) = (f64::from(sum) / 400.0, listed(&Shape::of(&t), 1.0 / d));
        assert!((mean / expected - 1.0).abs() < 0.03, "{mean} {expected}");
    }
}

#[test]
fn pairs_are_met_as_often_as_the_formula_says() {
    // A box of the tool and a triangle near it; overlapping, and with gaps along one axis and more.
    let mut random = Random::new(8);
    let (d, mut sums) = (0.3, [[0.0; 4]; 2]);
    for _ in 0..300 {
        let t: Triangle = std::array::from_fn(|_| std::array::from_fn(|_| 1.0 + 0.6 * random.unit()));
        let lower: Point = std::array::from_fn(|_| 0.7 + 0.9 * random.unit());
        let tool_box = Aabb { lower, upper: lower.map(|x| x + 0.2 + 0.3 * random.unit()) };
        let b = Aabb::of_triangle(&t);
        let overlap: Point = std::array::from_fn(|a| tool_box.upper[a].min(b.upper[a]) - lower[a].max(b.lower[a]));
        let gap = overlap.iter().fold(0.0f64, |m, x| m.max(-x));
        if gap >= d {
            continue;
        }
        let work = work_of(&[], &[Meeting { overlap, shape: Shape::of(&t), weight: 1.0, gap }], d);
        let (mut shared, mut met) = (0, 0);
        for _ in 0..100 {
            let origin: Point = std::array::from_fn(|_| -d * random.unit());
            let grid = VoxelGrid::new(&Aabb { lower: origin, upper: [3.0; 3] }, d).unwrap();
            let mut here = 0;
            grid.for_each_voxel(&t, |v| {
                here += u32::from((0..3).all(|a| {
                    let low = origin[a] + f64::from(v[a]) * d;
                    low <= tool_box.upper[a] && low + d >= tool_box.lower[a]
                }));
            });
            shared += here;
            met += u32::from(here > 0);
        }
        let sum = &mut sums[usize::from(gap > 0.0)];
        for (total, x) in
            sum.iter_mut().zip([work.entries, f64::from(shared) / 100.0, work.pairs, f64::from(met) / 100.0])
        {
            *total += x;
        }
    }
    for ([entries, shared, pairs, met], most) in sums.into_iter().zip([1.1, 1.2]) {
        assert!((entries / shared - 1.0).abs() < 0.15, "{entries} {shared}");
        assert!(pairs / met > 0.9 && pairs / met < most, "{pairs} {met}");
    }
}

#[test]
fn a_place_counts_by_how_much_longer_it_takes() {
    let visitor = |weight| Visitor { extent: [0.1; 3], weight };
    let shape = Shape { extent: [0.01; 3], shadows: 1e-4 };
    let meeting = |weight| Meeting { overlap: [0.01; 3], shape, weight, gap: 0.0 };
    // The second is a hundred times the first, but for the fixed cost of a query.
    let mut found = [
        (vec![visitor(1e4)], vec![meeting(1e3), meeting(1e3)]),
        (vec![visitor(1e6)], vec![meeting(1e5), meeting(1e5)]),
    ];
    balance(&mut found, 0.02);
    let [a, b] = found.map(|(visitors, meetings)| work_of(&visitors, &meetings, 0.02));
    for (x, y) in [(a.voxels, b.voxels), (a.entries, b.entries), (a.tests, b.tests)] {
        assert!(x > 0.0 && (y / x - 1.0).abs() < 0.05, "{x} {y}");
    }
    // Together: their geometric mean, ten times the first.
    let voxels: f64 = 1e4 * visitor(1.0).extent.iter().map(|b| 1.0 + b / 0.02).product::<f64>();
    assert!(((a.voxels + b.voxels) / voxels - 10.0).abs() < 0.5, "{voxels} {a:?} {b:?}");
}

#[test]
fn memory_is_predicted() {
    let (mockup, tool) = (Arc::new(mockup(40, 1.0)), tool(1.0));
    let predictor = Predictor::new(mockup.mesh(), tool.mesh(), Storage::Dense).unwrap();
    for size in [0.01, 0.02, 0.05] {
        let options = SceneOptions { voxel_size: Some(size), storage: Storage::Dense, ..SceneOptions::default() };
        let scene = Scene::build(Arc::clone(&mockup), &options).unwrap();
        let bytes: usize =
            scene.memory().iter().filter(|(name, _)| ["voxels", "lists"].contains(name)).map(|m| m.1).sum();
        assert!((predictor.bytes(size) / bytes as f64 - 1.0).abs() < 0.05, "{size}: {bytes}");
    }
}

#[test]
fn the_chosen_size_is_the_best_of_many() {
    let (mockup, tool) = (mockup(40, 1.0), tool(1.0));
    let constants = CostConstants::default();
    for storage in [Storage::Dense, Storage::Hashed { level: 0.9 }] {
        let predictor = Predictor::new(mockup.mesh(), tool.mesh(), storage).unwrap();
        let chosen = predictor.optimal_size(&constants, u64::MAX);
        let least = predictor.work(chosen).seconds(&constants);
        for i in -12..=12 {
            let size = chosen * 2f64.powf(f64::from(i) / 6.0);
            assert!(least <= 1.002 * predictor.work(size).seconds(&constants), "{chosen} {size}");
        }
    }
}

#[test]
fn hashing_makes_larger_voxels_of_strangers_and_dearer_queries() {
    let (mockup, tool) = (mockup(40, 1.0), tool(1.0));
    let at = |storage| Predictor::new(mockup.mesh(), tool.mesh(), storage).unwrap();
    let (dense, hashed) = (at(Storage::Dense), at(Storage::Hashed { level: 0.95 }));
    assert!(hashed.bytes(0.01) < dense.bytes(0.01));
    assert!(hashed.work(0.01).entries > dense.work(0.01).entries);
    assert_eq!(hashed.work(0.01).tests, dense.work(0.01).tests);
}

#[test]
fn a_memory_limit_is_kept() {
    let (mockup, tool) = (mockup(40, 1.0), tool(1.0));
    let predictor = Predictor::new(mockup.mesh(), tool.mesh(), Storage::Dense).unwrap();
    let constants = CostConstants::default();
    let free = predictor.bytes(predictor.optimal_size(&constants, u64::MAX));
    let limit = (0.4 * free) as u64;
    let size = predictor.optimal_size(&constants, limit);
    assert!(predictor.bytes(size) <= limit as f64, "{size}");
    // Nothing fits: still a size, and the store reports the error.
    assert!(predictor.optimal_size(&constants, 0).is_finite());
}

#[test]
fn it_scales_with_the_meshes_and_not_with_threads() {
    let constants = CostConstants::default();
    let at = |scale: f64| {
        let (mockup, tool) = (mockup(30, scale), tool(scale));
        Predictor::new(mockup.mesh(), tool.mesh(), Storage::Dense).unwrap().optimal_size(&constants, u64::MAX)
    };
    let one = at(1.0);
    assert!((at(1024.0) / one - 1024.0).abs() < 1e-3);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
    assert_eq!(pool.install(|| at(1.0)).to_bits(), one.to_bits());
}

#[test]
fn odd_meshes_have_sizes_or_none() {
    let constants = CostConstants::default();
    let one = |t: Triangle| (t.to_vec(), vec![[0, 1, 2]]);
    let triangles = [
        [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        [[0.0; 3], [1e-160, 0.0, 0.0], [0.0, 1e-160, 0.0]],
        [[0.0; 3], [1e90, 0.0, 0.0], [0.0, 1e90, 1e-90]],
        [[0.0; 3], [1e9, 0.0, 0.0], [0.0, 1e-9, 0.0]],
    ];
    for a in triangles {
        for b in triangles {
            let ((v, f), (w, g)) = (one(a), one(b));
            let (Ok(mockup), Ok(tool)) = (Mockup::new(v, f, Vec::new(), 1), Tool::new(w, g)) else { continue };
            if let Some(predictor) = Predictor::new(mockup.mesh(), tool.mesh(), Storage::Dense) {
                let size = predictor.optimal_size(&constants, u64::MAX);
                assert!(size.is_finite() && size > 0.0, "{a:?} {b:?}: {size}");
            }
            if let Some(predictor) = PiecePredictor::new(mockup.mesh(), &tool) {
                let size = predictor.optimal_size(u64::MAX);
                assert!(size.is_finite() && size > 0.0, "{a:?} {b:?}: {size}");
            }
        }
    }
}

/// Sheets with long diagonal panels across them.
fn panelled(n: u32, scale: f64) -> Mockup {
    let (mut vertices, mut faces) = sheets(n, scale);
    let mut random = Random::new(5);
    for _ in 0..40 {
        let first = vertices.len() as u32;
        vertices.extend((0..3).map(|_| -> Point { std::array::from_fn(|_| scale * random.unit()) }));
        faces.push([first, first + 1, first + 2]);
    }
    Mockup::new(vertices, faces, Vec::new(), 1).unwrap()
}

#[test]
fn boxes_of_pieces_are_counted_from_a_sample() {
    let (mockup, tool) = (panelled(40, 1.0), tool(1.0));
    let mesh = mockup.mesh();
    let predictor = PiecePredictor::new(mesh, &tool).unwrap();
    let w = tool.widths().pieces;
    for size in [1.0, 0.1, 0.02] {
        let (mut pairs, mut pieces) = (0.0, 0.0);
        for id in mesh.queried() {
            cut_triangle(&mesh.triangle(id), size, &mut |p| {
                let [x, y, z] = grown_box(p, 0.0).extent();
                pairs += x * y * z + w[0] * (x * y + y * z + z * x) + w[1] * (x + y + z) + w[2];
                pieces += 1.0;
            });
        }
        let work = predictor.work(size);
        assert!((work.pairs / pairs - 1.0).abs() < 0.15, "{size}: {} {pairs}", work.pairs);
        assert!((work.pieces / pieces - 1.0).abs() < 0.15, "{size}: {} {pieces}", work.pieces);
    }
}

#[test]
fn a_box_is_met_as_often_as_the_tools_widths_say() {
    // A triangle turned at random has on average the box sides that a quarter of its outline is.
    let (mut random, tool) = (Random::new(9), tool(1.0));
    let mesh = tool.mesh();
    let (mut sum, mut count) = (0.0, 0.0);
    for id in mesh.queried() {
        for _ in 0..200 {
            let turn = random.rotation();
            let turned = mesh.triangle(id).map(|p| turn.map(|row| row[0] * p[0] + row[1] * p[1] + row[2] * p[2]));
            sum += Aabb::of_triangle(&turned).extent().iter().sum::<f64>() / 3.0;
            count += 1.0;
        }
    }
    let outline: f64 =
        mesh.queried().map(|id| crate::mesh::pieces::edge_lengths(&mesh.triangle(id)).iter().sum::<f64>()).sum();
    let expected = 0.25 * outline / mesh.queried_count() as f64;
    assert!((sum / count / expected - 1.0).abs() < 0.02, "{} {expected}", sum / count);
    assert!(tool.widths().pieces[0] <= expected && tool.widths().clusters[0] >= tool.widths().pieces[0]);
}

#[test]
fn the_piece_size_follows_the_tool_the_mock_up_and_the_memory() {
    let at = |scale: f64| PiecePredictor::new(panelled(40, scale).mesh(), &tool(scale)).unwrap();
    let predictor = at(1.0);
    let chosen = predictor.optimal_size(u64::MAX);
    let least = predictor.work(chosen).cost();
    // Nothing on the way down is better, and the panels are cut.
    assert!(chosen < 0.3);
    for step in 0..12 {
        let size = 0.5 * 2f64.sqrt().powi(step) * chosen;
        let work = predictor.work(size);
        assert!(work.cost() >= 0.98 * least || work.pieces > 3.0 * predictor.work(9.0).pieces, "{chosen} {size}");
    }
    assert!((at(1024.0).optimal_size(u64::MAX) / chosen - 1024.0).abs() < 1e-3);
    // A finer tool wants smaller pieces, a coarse one larger ones.
    let for_tool = |scale| PiecePredictor::new(panelled(40, 1.0).mesh(), &tool(scale)).unwrap();
    assert!(for_tool(0.25).optimal_size(u64::MAX) < chosen && chosen < for_tool(16.0).optimal_size(u64::MAX));
    // Memory, and the bound of three pieces a triangle.
    let tight = predictor.optimal_size((0.95 * predictor.work(chosen).pieces * Blocks::BUILD_BYTES_PER_PIECE) as u64);
    assert!(tight > chosen);
    let least = for_tool(1e-3);
    assert!(least.work(least.optimal_size(u64::MAX)).pieces <= 3.0 * least.work(9.0).pieces);
}
