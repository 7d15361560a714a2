//! `collide` in every store against the plain twin over all pairs: same pairs, same kinds.
#![no_main]

use std::sync::Arc;

use arbitrary::{Arbitrary, Result, Unstructured};
use feeler_core::{collide_all_pairs, Filters, Level, Mockup, Point, Pose, Scene, SceneOptions, Storage, Tool};
use libfuzzer_sys::fuzz_target;

#[derive(Debug)]
struct Case {
    mockup: (Vec<Point>, Vec<[u32; 3]>),
    tool: (Vec<Point>, Vec<[u32; 3]>),
    pose: [[f64; 4]; 4],
    voxel_size: f64,
    hashing: f64,
}

impl<'a> Arbitrary<'a> for Case {
    fn arbitrary(u: &mut Unstructured<'a>) -> Result<Case> {
        let unit = *u.choose(&[1.0, 0.1, 1e-3, 1e-6, 1e6, 1e-160, 1e95])?;
        let offset = *u.choose(&[0.0, 0.0, 0.0, 1.0, 3e3, 1e6])?;
        let mesh = |u: &mut Unstructured<'a>, most: usize| -> Result<_> {
            let vertices: usize = u.int_in_range(3..=24)?;
            let points: Vec<Point> = (0..vertices).map(|_| point(u, unit, offset)).collect::<Result<_>>()?;
            let faces = u.int_in_range(1..=most)?;
            // One index past the end now and then.
            let last = vertices as u32;
            let faces = (0..faces)
                .map(|_| Ok([u.int_in_range(0..=last)?, u.int_in_range(0..=last)?, u.int_in_range(0..=last)?]))
                .collect::<Result<_>>()?;
            Ok((points, faces))
        };
        let (mockup, tool) = (mesh(u, 60)?, mesh(u, 30)?);
        // Exact quarter turns, a 3-4-5 turn, and an inexact one.
        let (c, s) = *u.choose(&[(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.6, 0.8), (0.955336489125606, 0.29552020666133955)])?;
        let t: Point = point(u, unit, 0.0)?;
        let [x, y, z] = if t.iter().all(|x| x.is_finite()) { t } else { [0.0; 3] };
        let pose = match u.int_in_range(0..=2)? {
            0 => [[c, -s, 0.0, x], [s, c, 0.0, y], [0.0, 0.0, 1.0, z], [0.0, 0.0, 0.0, 1.0]],
            1 => [[1.0, 0.0, 0.0, x], [0.0, c, -s, y], [0.0, s, c, z], [0.0, 0.0, 0.0, 1.0]],
            _ => [[c, 0.0, s, x], [0.0, 1.0, 0.0, y], [-s, 0.0, c, z], [0.0, 0.0, 0.0, 1.0]],
        };
        let voxel_size = unit * f64::from(u.int_in_range(1..=400u16)?) * 0.05;
        Ok(Case { mockup, tool, pose, voxel_size, hashing: *u.choose(&[0.0, 0.3, 0.9, 0.99])? })
    }
}

fn point(u: &mut Unstructured<'_>, unit: f64, offset: f64) -> Result<Point> {
    let mut p = [0.0; 3];
    for x in &mut p {
        *x = match u.int_in_range(0..=15u8)? {
            // A lattice makes flush faces; its neighbours nearly so.
            0..=11 => f64::from(u.int_in_range(-4..=4i8)?) * unit + offset,
            12 | 13 => f64::from_bits((f64::from(u.int_in_range(-4..=4i8)?) * unit + offset).to_bits().wrapping_add(1)),
            14 => f64::from(u.arbitrary::<f32>()?) * unit,
            _ => u.arbitrary::<f64>()?,
        };
    }
    Ok(p)
}

fuzz_target!(|case: Case| {
    let (Ok(mockup), Ok(tool), Ok(pose)) = (
        Mockup::new(case.mockup.0, case.mockup.1, Vec::new(), 1),
        Tool::new(case.tool.0, case.tool.1),
        Pose::new(&case.pose),
    ) else {
        return;
    };
    let mockup = Arc::new(mockup);
    let expected = collide_all_pairs(mockup.mesh(), &tool, &pose);
    for storage in [Storage::Blocks, Storage::Dense, Storage::Hashed { level: case.hashing }] {
        for voxel_size in [None, Some(case.voxel_size)] {
            let options = SceneOptions { voxel_size, storage, tool: Some(&tool), memory_limit: 64 << 20 };
            // Refusing a size is allowed; a wrong answer is not.
            let Ok(mut scene) = Scene::build(Arc::clone(&mockup), &options, &|_, _| true) else { continue };
            scene.validate().unwrap();
            let mut ways = vec![(Level::best(), Filters { repeats: false, boxes: false })];
            ways.extend(Level::available().into_iter().map(|lanes| (lanes, Filters::default())));
            for (lanes, filters) in ways {
                scene.set_lanes(lanes);
                let found = scene.collide(&tool, &pose, filters);
                let found: Vec<_> = found.pairs.into_iter().zip(found.kinds).collect();
                assert_eq!(found, expected, "{storage:?} at {voxel_size:?}, {}", lanes.name());
            }
            assert_eq!(scene.is_colliding(&tool, &pose), !expected.is_empty());
        }
    }
});
