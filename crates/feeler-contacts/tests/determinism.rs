//! One scene gives the same contact planes on any number of threads.

#[path = "../../feeler-core/tests/common/mod.rs"]
mod common;

use std::sync::Arc;

use common::cases::{cases, Case};
use feeler_contacts::ContactSolver;
use feeler_core::{Pose, Scene, SceneOptions, Storage};

const STORES: [Storage; 5] = [
    Storage::Blocks,
    Storage::Dense,
    Storage::Hashed { level: 0.0 },
    Storage::Hashed { level: 0.5 },
    Storage::Hashed { level: 0.95 },
];

fn near_and_far(case: &Case) -> Vec<Pose> {
    let off = [0.25, 0.75, 1.5].map(|share| share * case.extent());
    case.poses.iter().flat_map(|pose| [*pose, pose.translated(&off).unwrap()]).collect()
}

#[test]
fn contacts_of_one_scene_on_any_number_of_threads() {
    let mut count = 0;
    for case in cases() {
        let (poses, extent) = (near_and_far(&case), case.extent());
        for storage in STORES {
            for size in [None, Some(extent / 9.7)] {
                let answer = |threads: usize| {
                    rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(|| {
                        let options = SceneOptions { voxel_size: size, storage, ..SceneOptions::default() };
                        let scene = Scene::build(Arc::clone(&case.mockup), &options, &|_, _| true).unwrap();
                        let solver = ContactSolver::new(Arc::new(scene));
                        let planes = |pose: &Pose| solver.contacts(&case.tool, pose, 0.01 * extent, None).unwrap();
                        poses.iter().map(planes).collect::<Vec<_>>()
                    })
                };
                let one = answer(1);
                count += one.iter().map(|contacts| contacts.planes.len()).sum::<usize>();
                for threads in [2, 3, 8] {
                    assert!(answer(threads) == one, "{}, {storage:?}, {size:?}, {threads} threads", case.name);
                }
            }
        }
    }
    assert!(count > 300, "{count} planes make no test");
}
