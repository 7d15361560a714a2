//! Distances, clearances and casts in every store against their plain twins, and these against what is promised of them.

use std::collections::BTreeSet;
use std::sync::Arc;

use arbitrary::{Arbitrary, Result, Unstructured};
use feeler_core::constants::{DISTANCE_ROUNDOFFS, UNIT_ROUNDOFF};
use feeler_core::{
    cast_all_pairs, closest_triangle_triangle, collide_all_pairs, gaps_of_all_pairs, BatchOptions, Cast, CastOptions,
    Error, Gap, Level, Mockup, Motion, Point, Pose, Scene, SceneOptions, Storage, Tool,
};
use feeler_exact::distance::check_pair;

use super::shapes::{made, matrix, mesh, unit_and_offset, Arrays};

#[derive(Debug)]
pub struct Case {
    unit: f64,
    mockup: Arrays,
    parts: usize,
    tool: Arrays,
    poses: [[[f64; 4]; 4]; 2],
    voxel_size: f64,
    hashing: f64,
    within: f64,
    tolerance: f64,
    /// Which pairs are held to rational arithmetic, beside the closest one.
    judged: [u16; 2],
}

impl<'a> Arbitrary<'a> for Case {
    fn arbitrary(u: &mut Unstructured<'a>) -> Result<Case> {
        let (unit, offset) = unit_and_offset(u)?;
        let of_tool = unit * u.choose(&[1.0, 1.0, 1.0, 1e-3, 1e3, 1e-9])?;
        let (mockup, tool) = (mesh(u, 32, unit, offset)?, mesh(u, 8, of_tool, offset)?);
        let poses = [pose(u, unit)?, pose(u, unit)?];
        let within = match u.int_in_range(0..=5)? {
            0 => 0.0,
            1 => f64::INFINITY,
            2 => u.arbitrary::<f64>()?,
            _ => unit * f64::from(u.int_in_range(1..=40u8)?) * 0.25,
        };
        Ok(Case {
            unit,
            mockup,
            parts: u.int_in_range(1..=5)?,
            tool,
            poses,
            voxel_size: unit * f64::from(u.int_in_range(1..=400u16)?) * 0.05,
            hashing: *u.choose(&[0.0, 0.3, 0.9, 0.99])?,
            within,
            tolerance: *u.choose(&[1e-6 * unit, 1e-6 * unit, 1e-3 * unit, 1e-15 * unit, 0.0, f64::NAN])?,
            judged: u.arbitrary()?,
        })
    }
}

/// Turned about two axes, near or far; now and then as rigid as a pose must be, and no more.
fn pose(u: &mut Unstructured<'_>, unit: f64) -> Result<[[f64; 4]; 4]> {
    let (mut a, b) = (matrix(u, unit)?, matrix(u, unit)?);
    if u.ratio(1, 3)? {
        a = std::array::from_fn(|i| std::array::from_fn(|j| (0..4).map(|k| a[i][k] * b[k][j]).sum()));
    }
    let far = *u.choose(&[1.0, 1.0, 1.0, 0.01, 10.0, 1e4, 1e12])?;
    a.iter_mut().take(3).for_each(|row| row[3] *= far);
    if u.ratio(1, 6)? {
        a[u.int_in_range(0..=2)?][u.int_in_range(0..=2)?] += *u.choose(&[4e-7, -4e-7])?;
    }
    Ok(a)
}

pub fn check(case: Case) {
    let part = |i: usize| i * 7 / 3 % case.parts;
    let Some((mockup, tool, [from, to])) = made(case.mockup, part, case.parts, case.tool, &case.poses) else { return };
    let Case { unit, within, tolerance, .. } = case;
    let ask = Ask { unit, mockup: &mockup, tool: &tool, poses: [from, to], within, tolerance };
    let gaps = [from, to].map(|pose| gaps_of_all_pairs(&mockup, &tool, &pose, f64::INFINITY));
    for (pose, gaps) in [from, to].iter().zip(&gaps) {
        ask.check_gaps(pose, gaps, &case.judged);
    }
    ask.check_cast(
        cast_all_pairs(mockup.mesh(), &tool, &Motion::new(&tool, &from, &to), case.tolerance),
        24,
        "all pairs",
    );
    for storage in [Storage::Blocks, Storage::Dense, Storage::Hashed { level: case.hashing }] {
        for voxel_size in [None, Some(case.voxel_size)] {
            // Refusing a size is allowed; a wrong answer is not. Many voxels take long where all pairs are asked for.
            let memory_limit = if storage == Storage::Blocks { 1 << 18 } else { 1 << 16 };
            let options = SceneOptions::default()
                .with_voxel_size(voxel_size)
                .with_storage(storage)
                .with_tool(&tool)
                .with_memory_limit(memory_limit);
            let Ok(mut scene) = Scene::build(Arc::clone(&mockup), &options) else { continue };
            for lanes in Level::available() {
                if storage != Storage::Blocks && lanes != Level::best() {
                    continue;
                }
                scene.set_lanes(lanes);
                let what = format!("{storage:?} at {voxel_size:?}, {}", lanes.name());
                for (pose, gaps) in [from, to].iter().zip(&gaps) {
                    ask.check_queries(&scene, pose, gaps, &what);
                }
                if storage == Storage::Blocks || voxel_size.is_none() {
                    ask.check_cast(
                        scene.cast(&tool, &from, &to, &CastOptions::default().with_tolerance(case.tolerance)),
                        6,
                        &what,
                    );
                }
            }
            ask.check_batches(&scene);
        }
    }
}

struct Ask<'a> {
    unit: f64,
    mockup: &'a Mockup,
    tool: &'a Tool,
    poses: [Pose; 2],
    within: f64,
    tolerance: f64,
}

impl Ask<'_> {
    fn largest_coordinate(&self) -> f64 {
        let translation = self.poses.iter().map(Pose::largest_translation).fold(0.0, f64::max);
        self.mockup.mesh().bounds().largest_coordinate() + self.tool.mesh().bounds().largest_coordinate() + translation
    }

    /// The plain twin: 0 exactly where a pair meets, witness points that are so far apart, and a few pairs exactly.
    fn check_gaps(&self, pose: &Pose, gaps: &[Gap], judged: &[u16]) {
        let (mesh, tool) = (self.mockup.mesh(), self.tool.mesh());
        assert_eq!(gaps.len(), mesh.queried_count() * tool.queried_count());
        let meeting: BTreeSet<[u32; 2]> =
            collide_all_pairs(mesh, self.tool, pose).into_iter().map(|(ids, _)| ids).collect();
        for gap in gaps {
            let ids = [gap.tool_triangle, gap.mockup_triangle];
            assert!(gap.distance >= 0.0 && gap.distance.is_finite(), "{gap:?}");
            assert_eq!(gap.distance == 0.0, meeting.contains(&ids), "{gap:?}");
            assert_eq!(gap.part, self.mockup.part_of_face(gap.mockup_triangle), "{gap:?}");
            let between: Point = std::array::from_fn(|a| gap.on_mockup[a] - gap.on_tool[a]);
            let size = between.iter().fold(0.0f64, |m, x| m.max(x.abs()));
            let length = between.iter().map(|x| x / size).map(|x| x * x).sum::<f64>().sqrt() * size;
            let length = if size == 0.0 { 0.0 } else { length };
            let allowed = 4.0 * DISTANCE_ROUNDOFFS * UNIT_ROUNDOFF * self.largest_coordinate() + 3e-323;
            assert!((length - gap.distance).abs() <= allowed, "{gap:?}: its points are {length} apart");
        }
        let some = judged.iter().map(|i| usize::from(*i) % gaps.len());
        for gap in std::iter::once(0).chain(some).map(|i| &gaps[i]) {
            let p = pose.apply_triangle(&tool.triangle(gap.tool_triangle));
            let q = mesh.triangle(gap.mockup_triangle);
            if let Err(why) = check_pair(&p, &q) {
                panic!("{gap:?}: {why}\n{p:?}\n{q:?}");
            }
        }
    }

    /// The answers of a scene are the twin's, to the last bit.
    fn check_queries(&self, scene: &Scene, pose: &Pose, gaps: &[Gap], what: &str) {
        let (tool, mut within) = (self.tool, self.within);
        if within.is_nan() || within < 0.0 {
            for found in [scene.near_pairs(tool, pose, within), scene.nearest(tool, pose, 1, within)] {
                assert!(matches!(found, Err(Error::Distance { .. })), "{what}: {found:?}");
            }
            within = f64::INFINITY;
        }
        let near: Vec<Gap> = gaps.iter().copied().filter(|gap| gap.distance <= within).collect();
        assert_eq!(scene.near_pairs(tool, pose, within).unwrap(), near, "{what}, within {within}");
        let mut seen = BTreeSet::new();
        let nearest: Vec<Gap> = near.iter().copied().filter(|gap| seen.insert(gap.part)).collect();
        assert_same(&scene.clearance(tool, pose, within).unwrap(), &nearest, what);
        for k in [1, 2, usize::MAX] {
            let found = scene.nearest(tool, pose, k, within).unwrap();
            assert_same(&found, &nearest[..k.min(nearest.len())], what);
        }
        let closest = scene.distance(tool, pose, f64::INFINITY).unwrap().unwrap();
        assert_same(&[closest], &gaps[..1], what);
        assert_eq!(scene.is_colliding(tool, pose), closest.distance == 0.0, "{what}: {closest:?}");
    }

    /// At many poses at once as at one.
    fn check_batches(&self, scene: &Scene) {
        let (tool, poses, within) = (self.tool, &self.poses, f64::INFINITY);
        let single = poses.map(|pose| scene.distance(tool, &pose, within).unwrap());
        assert_eq!(scene.distance_batch(tool, poses, within, &BatchOptions::default()).unwrap(), single);
        let rows = poses.map(|pose| scene.clearance(tool, &pose, within).unwrap());
        assert_eq!(scene.clearance_batch(tool, poses, within, &BatchOptions::default()).unwrap().gaps, rows.concat());
    }

    /// Nothing meets before the impact, and then the pair is as near as promised.
    fn check_cast(&self, found: feeler_core::Result<Option<Cast>>, samples: u32, what: &str) {
        if self.tolerance.is_nan() || self.tolerance <= 0.0 {
            assert!(matches!(found, Err(Error::Tolerance { .. })), "{what}: {found:?}");
            return;
        }
        let (mesh, tool, [from, to]) = (self.mockup.mesh(), self.tool, &self.poses);
        let found = found.unwrap();
        let motion = Motion::new(tool, from, to);
        let until = found.map_or(1.0, |cast| cast.fraction);
        assert!((0.0..=1.0).contains(&until), "{what}: {found:?}");
        let evenly = (0..=samples).map(|i| until * f64::from(i) / f64::from(samples));
        for time in evenly.chain((1..=samples).map(|i| until * (1.0 - 0.5f64.powi(2 * i as i32)))) {
            if found.is_none() || time < until {
                let pairs = collide_all_pairs(mesh, tool, &motion.at(time));
                assert!(pairs.is_empty(), "{what}: {pairs:?} at {time}, before {found:?}");
            }
        }
        let Some(cast) = found else { return };
        assert_eq!(cast.pose, motion.at(cast.fraction), "{what}");
        let p = cast.pose.apply_triangle(&tool.mesh().triangle(cast.tool_triangle));
        let closest = closest_triangle_triangle(&p, &mesh.triangle(cast.mockup_triangle));
        assert_eq!((closest.distance, closest.on_q), (cast.distance, cast.point), "{what}");
        // What rounding may do on the way comes on top. Beside huge numbers steps are short, and there may be too many; products of
        // the tiniest vanish, and with them the normals.
        let largest = self.largest_coordinate();
        let allowed = self.tolerance + 1e-12 * largest;
        let is_judged = largest <= 1e6 * self.unit && self.unit > 1e-100;
        assert!(cast.distance <= allowed || !is_judged, "{what}: {allowed} allowed: {cast:?}");
        let size = cast.normal.iter().map(|x| x * x).sum::<f64>().sqrt();
        assert!((size - 1.0).abs() < 1e-9, "{what}: {:?}", cast.normal);
    }
}

/// Equal, except for which of several pairs that meet was taken.
fn assert_same(found: &[Gap], expected: &[Gap], what: &str) {
    let distances = |gaps: &[Gap]| gaps.iter().map(|gap| gap.distance).collect::<Vec<_>>();
    assert_eq!(distances(found), distances(expected), "{what}");
    for (f, e) in found.iter().zip(expected) {
        assert!(f == e || f.distance == 0.0, "{what}: {f:?} for {e:?}");
    }
}
