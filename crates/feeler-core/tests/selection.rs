//! A scene without some parts, or with pairs of parts ignored, answers as all pairs without these do; of every store.

mod common;

use std::collections::BTreeSet;
use std::sync::Arc;

use common::*;
use feeler_core::{
    cast_all_pairs, collide_all_pairs, gaps_of_all_pairs, BatchOptions, CastOptions, Error, Gap, IgnoredPairs, Level,
    Mockup, Motion, PairKind, PathOptions, Pose, Scene, SceneOptions, Storage, Tool,
};

const TOLERANCE: f64 = 1e-6;
const PARTS: usize = 9;
const TOOL_PARTS: usize = 3;

fn part_of(face: usize, parts: usize) -> u32 {
    (face * 7 / 5 % parts) as u32
}

fn with_parts((vertices, faces): Arrays) -> Arc<Mockup> {
    let part_of_face = (0..faces.len()).map(|face| part_of(face, PARTS)).collect();
    Arc::new(Mockup::new(vertices, faces, part_of_face, PARTS).unwrap())
}

fn tool_with_parts((vertices, faces): Arrays) -> Tool {
    let part_of_face = (0..faces.len()).map(|face| part_of(face, TOOL_PARTS)).collect();
    Tool::of_parts(vertices, faces, part_of_face, TOOL_PARTS).unwrap()
}

fn scene_of(mockup: &Arc<Mockup>, storage: Storage) -> Scene {
    let options = SceneOptions::default().with_storage(storage);
    Scene::build(mockup.clone(), &options).unwrap()
}

/// The colliding pairs at a pose, from the test of all pairs.
struct Judge {
    pose: Pose,
    pairs: Vec<([u32; 2], PairKind)>,
    gaps: Vec<Gap>,
}

impl Judge {
    fn at(mockup: &Mockup, tool: &Tool, pose: &Pose) -> Judge {
        let pairs = collide_all_pairs(mockup.mesh(), tool, pose);
        Judge { pose: *pose, pairs, gaps: gaps_of_all_pairs(mockup, tool, pose, f64::INFINITY) }
    }

    /// Compares every query of a scene with the pairs of tool part and mock-up part that are queried. Returns the number of colliding pairs.
    fn check(&self, what: &str, scene: &Scene, tool: &Tool, wants: &dyn Fn(u32, u32) -> bool) -> usize {
        let Judge { pose, pairs, gaps } = self;
        let is_wanted = |t: u32, m: u32| wants(tool.part_of_face(t), scene.mockup().part_of_face(m));
        let pairs: Vec<_> = pairs.iter().copied().filter(|([t, m], _)| is_wanted(*t, *m)).collect();
        let hit = scene.collide(tool, pose);
        let found: Vec<_> = hit.pairs.iter().copied().zip(hit.kinds.iter().copied()).collect();
        assert_eq!(found, pairs, "{what}");
        assert_eq!(scene.is_colliding(tool, pose), !pairs.is_empty(), "{what}");
        let batch = scene.collide_batch(tool, &[*pose, *pose], &BatchOptions::default()).unwrap();
        assert_eq!(batch.pairs, [&hit.pairs[..], &hit.pairs[..]].concat(), "{what}");
        let wanted = |gap: &&Gap| is_wanted(gap.tool_triangle, gap.mockup_triangle);
        let gaps: Vec<Gap> = gaps.iter().filter(wanted).copied().collect();
        let near: Vec<Gap> = gaps.iter().copied().filter(|gap| gap.distance <= 0.02).collect();
        assert_eq!(scene.near_pairs(tool, pose, 0.02).unwrap(), near, "{what}");
        // Voxels are a slow way to look far.
        let far = if scene.storage() == Storage::Blocks { f64::INFINITY } else { 0.05 };
        let mut seen = BTreeSet::new();
        let by_part = gaps.iter().filter(|gap| seen.insert(gap.part) && gap.distance <= far);
        let by_part: Vec<f64> = by_part.map(|gap| gap.distance).collect();
        let distances = |gaps: Vec<Gap>| gaps.iter().map(|gap| gap.distance).collect::<Vec<_>>();
        assert_eq!(distances(scene.clearance(tool, pose, far).unwrap()), by_part, "{what}");
        for k in [1, 2] {
            let found = scene.nearest(tool, pose, k, far).unwrap();
            assert_eq!(distances(found), by_part[..k.min(by_part.len())], "{what}");
        }
        pairs.len()
    }
}

/// The present triangles as a separate mock-up; `None` if there are none.
fn subset(mockup: &Mockup, has: impl Fn(u32) -> bool) -> Option<Mockup> {
    let mesh = mockup.mesh();
    let faces = (0..).zip(mesh.faces()).filter(|(m, _)| has(mockup.part_of_face(*m))).map(|(_, face)| *face).collect();
    Mockup::new(mesh.vertices().to_vec(), faces, Vec::new(), 1).ok()
}

/// A mock-up, a tool and poses at which they meet now and then.
fn cases() -> Vec<(&'static str, Arc<Mockup>, Tool, Vec<Pose>)> {
    let mut r = Random::new(41);
    [
        ("soup", soup(1, 400, 0.08), 1.0, 0.0),
        ("lattice", lattice(3, 150, 12), 12.0, 0.0),
        ("defects", with_defects(soup(5, 300, 0.08)), 1.0, 0.0),
        ("far", placed(soup(4, 300, 0.08), 1.0, 3000.0), 1.0, 3000.0),
        // Beyond where float32 tells near from far: the plain search.
        ("beyond", placed(soup(4, 40, 0.08), 1.0, 3e9), 1.0, 3e9),
    ]
    .into_iter()
    .map(|(name, arrays, size, offset)| {
        let tool = tool_with_parts(placed(soup(9, 24, 0.15), 0.3 * size, 0.0));
        let mut pose = || {
            let mut m = r.pose(0.0).matrix();
            (0..3).for_each(|a| m[a][3] = offset + r.real(0.1, 0.7) * size);
            Pose::new(&m).unwrap()
        };
        let poses = (0..4).map(|_| pose()).collect();
        (name, with_parts(arrays), tool, poses)
    })
    .collect()
}

#[test]
fn without_and_only_are_as_if_the_parts_had_never_been_there() {
    let (mut met, mut impacts) = (0, 0);
    for (name, mockup, tool, poses) in cases() {
        let judges: Vec<Judge> = poses.iter().map(|pose| Judge::at(&mockup, &tool, pose)).collect();
        for storage in STORAGES {
            let whole = scene_of(&mockup, storage);
            for out in [vec![], vec![4], vec![0, 3, 8], vec![0, 1, 2, 3, 5, 6, 7, 8], (0..PARTS as u32).collect()] {
                let has = |part: u32| !out.contains(&part);
                let stays: Vec<u32> = (0..PARTS as u32).filter(|part| has(*part)).collect();
                let scene = whole.without(&out).unwrap();
                let only = whole.only(&stays).unwrap();
                // Removed parts stay removed, and the original scene does not change.
                let nested = out.iter().fold(whole.clone(), |scene, part| scene.without(&[*part]).unwrap());
                let nested = nested.only(&[&stays[..], &out[..]].concat()).unwrap();
                assert!((0..PARTS as u32 + 1).all(|part| scene.has_part(part) == stays.contains(&part)));
                for (i, judge) in judges.iter().enumerate() {
                    let what = format!("{name}, {storage:?}, pose {i}, without {out:?}");
                    met += judge.check(&what, &scene, &tool, &|_, part| has(part));
                    judge.check(&format!("{what}, only"), &only, &tool, &|_, part| has(part));
                    judge.check(&format!("{what}, nested"), &nested, &tool, &|_, part| has(part));
                    judge.check(&format!("{what}, whole"), &whole, &tool, &|_, _| true);
                }
                impacts += check_casts(&format!("{name}, {storage:?}, {out:?}"), &scene, &tool, &poses, has);
            }
        }
    }
    assert!(met > 200 && impacts > 30, "{met} pairs and {impacts} impacts make no test");
}

/// Casts from pose to pose against all pairs of the present triangles.
fn check_casts(what: &str, scene: &Scene, tool: &Tool, poses: &[Pose], has: impl Fn(u32) -> bool) -> usize {
    let alone = subset(scene.mockup(), &has);
    let mut impacts = 0;
    let path = scene.check_path(tool, poses, &PathOptions::default().with_tolerance(TOLERANCE)).unwrap();
    for (i, way) in poses.windows(2).enumerate() {
        let motion = Motion::new(tool, &way[0], &way[1]);
        let plain = alone.as_ref().and_then(|alone| cast_all_pairs(alone.mesh(), tool, &motion, TOLERANCE).unwrap());
        let found = scene.cast(tool, &way[0], &way[1], &CastOptions::default().with_tolerance(TOLERANCE)).unwrap();
        assert_eq!(found.is_some(), plain.is_some(), "{what}, way {i}");
        assert_eq!(path.hits.iter().find(|(at, _)| *at == i).map(|(_, hit)| *hit), found, "{what}, way {i}");
        if let (Some(found), Some(plain)) = (found, plain) {
            let apart = (found.fraction - plain.fraction).abs() * motion.longest_way();
            assert!(apart < 1e-3 && has(scene.mockup().part_of_face(found.mockup_triangle)), "{what}, way {i}");
            impacts += 1;
        }
    }
    impacts
}

#[test]
fn ignored_pairs_of_parts_are_not_asked() {
    let (mut met, mut fewer) = (0, 0);
    for (name, mockup, tool, poses) in cases() {
        let judges: Vec<Judge> = poses.iter().map(|pose| Judge::at(&mockup, &tool, pose)).collect();
        for storage in STORAGES {
            let whole = scene_of(&mockup, storage);
            for ignored in [vec![[0, 4], [2, 0], [1, 8]], (0..8).flat_map(|m| [[0, m], [1, m], [2, m]]).collect()] {
                let matrix = IgnoredPairs::new(TOOL_PARTS, PARTS, ignored.iter().copied());
                let scene = whole.ignoring(matrix.into());
                let both = scene.without(&[5]).unwrap();
                let wants = |t: u32, m: u32| !ignored.contains(&[t, m]);
                for (i, judge) in judges.iter().enumerate() {
                    let what = format!("{name}, {storage:?}, pose {i}, ignoring {}", ignored.len());
                    let count = judge.check(&what, &scene, &tool, &wants);
                    judge.check(&format!("{what}, without 5"), &both, &tool, &|t, m| m != 5 && wants(t, m));
                    let all = judge.pairs.len();
                    (met, fewer) = (met + count, fewer + all - count);
                }
                for way in poses.windows(2) {
                    if let Some(hit) =
                        scene.cast(&tool, &way[0], &way[1], &CastOptions::default().with_tolerance(TOLERANCE)).unwrap()
                    {
                        assert!(wants(tool.part_of_face(hit.tool_triangle), mockup.part_of_face(hit.mockup_triangle)));
                    }
                }
            }
        }
    }
    assert!(met > 100 && fewer > 100, "{met} pairs left and {fewer} ignored make no test");
}

#[test]
fn every_instruction_set_leaves_out_the_same() {
    for (name, mockup, tool, poses) in cases() {
        let judges: Vec<Judge> = poses.iter().map(|pose| Judge::at(&mockup, &tool, pose)).collect();
        let mut scene = scene_of(&mockup, Storage::Blocks).without(&[0, 3, 8]).unwrap();
        for lanes in Level::available() {
            scene.set_lanes(lanes);
            for (i, judge) in judges.iter().enumerate() {
                let what = format!("{name}, {}, pose {i}", lanes.name());
                judge.check(&what, &scene, &tool, &|_, part| ![0, 3, 8].contains(&part));
            }
        }
    }
}

#[test]
fn a_mockup_of_one_part_can_be_emptied() {
    let mockup = mockup_of(soup(1, 200, 0.2));
    let tool = tool_of(soup(2, 20, 0.2));
    for storage in STORAGES {
        let scene = scene_of(&mockup, storage);
        assert!(scene.is_colliding(&tool, &Pose::IDENTITY));
        let empty = scene.without(&[0]).unwrap();
        assert!(!empty.is_colliding(&tool, &Pose::IDENTITY));
        assert_eq!(empty.nearest(&tool, &Pose::IDENTITY, 1, f64::INFINITY).unwrap(), []);
        assert!(scene.only(&[0]).unwrap().is_colliding(&tool, &Pose::IDENTITY));
    }
}

#[test]
fn a_part_that_is_not_there_is_an_error() {
    let scene = scene_of(&with_parts(soup(1, 30, 0.1)), Storage::Blocks);
    for found in [scene.without(&[1, 9]), scene.only(&[9])] {
        assert_eq!(found.unwrap_err(), Error::NoSuchPart { part: 9, parts: PARTS });
    }
}

#[test]
fn a_selection_takes_a_bit_a_triangle_and_a_bit_a_block() {
    let mockup = with_parts(soup(1, 20_000, 0.01));
    let whole = scene_of(&mockup, Storage::Blocks);
    let bytes = |scene: &Scene| scene.memory().iter().find(|(name, _)| *name == "selection").map(|(_, bytes)| *bytes);
    assert_eq!(bytes(&whole), None);
    let blocks = whole.memory().iter().find(|(name, _)| *name == "blocks").unwrap().1 / 256;
    let found = bytes(&whole.without(&[3]).unwrap()).unwrap();
    assert!(found > 20_000 / 8 && found < 20_000 / 8 + blocks / 4 + 64, "{found} bytes, {blocks} blocks");
}
