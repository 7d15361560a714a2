//! `collide` in every store against the plain twin over all pairs: same pairs, same kinds.

use std::sync::Arc;

use arbitrary::{Arbitrary, Result, Unstructured};
use feeler_core::{collide_all_pairs, Filters, Level, Mockup, Pose, Scene, SceneOptions, Storage, Tool};

use super::shapes::{matrix, mesh, unit_and_offset, Arrays};

#[derive(Debug)]
pub struct Case {
    mockup: Arrays,
    tool: Arrays,
    pose: [[f64; 4]; 4],
    voxel_size: f64,
    hashing: f64,
}

impl<'a> Arbitrary<'a> for Case {
    fn arbitrary(u: &mut Unstructured<'a>) -> Result<Case> {
        let (unit, offset) = unit_and_offset(u)?;
        let (mockup, tool) = (mesh(u, 60, unit, offset)?, mesh(u, 30, unit, offset)?);
        let pose = matrix(u, unit)?;
        let voxel_size = unit * f64::from(u.int_in_range(1..=400u16)?) * 0.05;
        Ok(Case { mockup, tool, pose, voxel_size, hashing: *u.choose(&[0.0, 0.3, 0.9, 0.99])? })
    }
}

pub fn check(case: Case) {
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
            let options = SceneOptions::default()
                .with_voxel_size(voxel_size)
                .with_storage(storage)
                .with_tool(&tool)
                .with_memory_limit(64 << 20);
            // Refusing a size is allowed; a wrong answer is not.
            let Ok(mut scene) = Scene::build(Arc::clone(&mockup), &options) else { continue };
            scene.validate().unwrap();
            let mut ways = vec![(Level::best(), Filters { repeats: false, boxes: false })];
            ways.extend(Level::available().into_iter().map(|lanes| (lanes, Filters::default())));
            for (lanes, filters) in ways {
                scene.set_lanes(lanes);
                let found = scene.collide_filtered(&tool, &pose, filters);
                let found: Vec<_> = found.pairs.into_iter().zip(found.kinds).collect();
                assert_eq!(found, expected, "{storage:?} at {voxel_size:?}, {}", lanes.name());
            }
            assert_eq!(scene.is_colliding(&tool, &pose), !expected.is_empty());
        }
    }
}
