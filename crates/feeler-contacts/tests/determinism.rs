//! A golden hash of contact planes: the same scenes give the same planes, whatever the store, the voxel size, the instruction set, the
//! number of threads and the state of the working memory; and in debug and release and on every machine, since all compare with the
//! number in `testdata/golden.txt`.

use std::sync::Arc;

use feeler_contacts::{ContactPlane, ContactSolver, Contacts};
use feeler_core::{Level, Mockup, Pose, Scene, SceneOptions, Storage, Tool};
use feeler_shapes::cases::{cases, Case};
use feeler_shapes::golden::Hash;
use rayon::prelude::*;

const STORES: [Storage; 5] = [
    Storage::Blocks,
    Storage::Dense,
    Storage::Hashed { level: 0.0 },
    Storage::Hashed { level: 0.5 },
    Storage::Hashed { level: 0.95 },
];

/// A case as meshes, and its queries: poses with margins and references.
struct Asked {
    name: &'static str,
    mockup: Arc<Mockup>,
    tool: Tool,
    extent: f64,
    queries: Vec<(Pose, f64, Option<Pose>)>,
}

impl Asked {
    fn new(case: Case) -> Asked {
        let (vertices, faces) = case.mockup;
        let mockup = Arc::new(Mockup::new(vertices, faces, case.part_of_face, case.parts).unwrap());
        let tool = Tool::new(case.tool.0, case.tool.1).unwrap();
        let extent = mockup.mesh().bounds().extent().iter().fold(0.0f64, |m, x| m.max(*x));
        let off = [0.25, 0.75, 1.5].map(|share| share * extent);
        let queries = case.poses.iter().flat_map(|matrix| {
            let pose = Pose::new(matrix).unwrap();
            // A pose at which most of the tool is clear of the mock-up: it serves as the reference.
            let away = pose.translated(&off).unwrap();
            [(pose, 0.01, None), (pose, 0.0, Some(away)), (away, 0.05, None)]
        });
        let queries = queries.map(|(pose, margin, reference)| (pose, margin * extent, reference)).collect();
        Asked { name: case.name, mockup, tool, extent, queries }
    }

    fn scene(&self, storage: Storage, voxel_size: Option<f64>) -> Scene {
        let options = SceneOptions::default().with_voxel_size(voxel_size).with_storage(storage);
        Scene::build(Arc::clone(&self.mockup), &options).unwrap()
    }

    fn answer(&self, solver: &ContactSolver, (pose, margin, reference): &(Pose, f64, Option<Pose>)) -> Contacts {
        solver.contacts(&self.tool, pose, *margin, reference.as_ref()).unwrap()
    }

    /// One query after the other: each reuses the working memory of the last one.
    fn answers(&self, solver: &ContactSolver) -> Vec<Contacts> {
        self.queries.iter().map(|query| self.answer(solver, query)).collect()
    }

    /// Several queries at once: some use working memory of other queries than before.
    fn answers_on(&self, solver: &ContactSolver, threads: usize) -> Vec<Contacts> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let twice: Vec<_> = self.queries.iter().rev().chain(&self.queries).collect();
        let mut found: Vec<_> =
            pool.install(|| twice.into_par_iter().with_max_len(1).map(|query| self.answer(solver, query)).collect());
        let second = found.split_off(self.queries.len());
        found.reverse();
        assert!(found == second, "{}: {threads} threads", self.name);
        found
    }
}

fn add_plane(hash: &mut Hash, plane: &ContactPlane) {
    hash.add(plane.part);
    plane.point.iter().chain(&plane.normal).chain([&plane.gap]).for_each(|x| hash.add_real(*x));
    hash.add_long(plane.id);
    for triangles in [&plane.tool_triangles, &plane.mockup_triangles] {
        hash.add(triangles.len() as u32);
        triangles.iter().for_each(|t| hash.add(*t));
    }
}

#[test]
fn one_golden_hash_of_contacts() {
    let mut golden = Hash::NEW;
    // Deep planes and near ones; planes left out.
    let (mut counts, mut omitted) = ([0, 0], 0);
    for asked in cases().into_iter().map(Asked::new) {
        let mut agreed: Option<Vec<Contacts>> = None;
        let mut agree = |found: Vec<Contacts>, what: &dyn Fn() -> String| {
            let first = agreed.get_or_insert_with(|| found.clone());
            let same = first.iter().zip(&found).position(|(a, b)| a != b);
            assert!(same.is_none() && first.len() == found.len(), "{}: {}, query {same:?}", asked.name, what());
        };
        for storage in STORES {
            for size in [None, Some(asked.extent / 9.7)] {
                let mut scene = Arc::new(asked.scene(storage, size));
                for lanes in Level::available().into_iter().filter(|l| size.is_none() || *l == Level::best()) {
                    Arc::get_mut(&mut scene).unwrap().set_lanes(lanes);
                    let solver = ContactSolver::new(Arc::clone(&scene));
                    let what = |how: &str| format!("{storage:?}, voxel size {size:?}, {}, {how}", lanes.name());
                    agree(asked.answers(&solver), &|| what("cold"));
                    if lanes == Level::best() {
                        agree(asked.answers(&solver), &|| what("warm"));
                        agree(asked.answers_on(&solver, 3), &|| what("on threads"));
                    }
                }
            }
        }
        for contacts in agreed.unwrap() {
            golden.add(contacts.planes.len() as u32);
            golden.add(contacts.omitted as u32);
            golden.add(u32::from(contacts.is_meeting));
            contacts.planes.iter().for_each(|plane| add_plane(&mut golden, plane));
            contacts.planes.iter().for_each(|plane| counts[usize::from(plane.gap > 0.0)] += 1);
            omitted += contacts.omitted;
        }
    }
    assert!(counts.iter().all(|n| *n > 100) && omitted > 0, "{counts:?} planes, {omitted} omitted make no test");
    golden.assert_golden("contacts");
}
