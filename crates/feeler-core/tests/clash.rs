//! A mock-up against itself, compared with its plain twins: every pair of triangles of every pair of parts.

mod common;

use std::sync::Arc;

use common::{ball, lattice, placed, soup, with_defects, Arrays, Random, STORAGES};
use feeler_core::clash::brute::{gaps_of_all_parts, meeting_of_all_pairs};
use feeler_core::clash::meeting::meeting_parts;
use feeler_core::clash::meets::{MeetingParts, Meets};
use feeler_core::clash::near::{near_parts, PartGap};
use feeler_core::clash::search::SelfIndex;
use feeler_core::{
    intersect_triangle_triangle, Level, Mockup, PairKind, PairLimitTables, PairLimits, Progress, Scene, SceneOptions,
};
use feeler_shapes::{box_mesh, joined};

/// A mock-up of parts.
fn assembly(parts: Vec<Arrays>) -> Arc<Mockup> {
    let count = parts.len();
    let part_of_face = parts.iter().zip(0..).flat_map(|(part, i)| vec![i; part.1.len()]).collect();
    let (vertices, faces) = joined(parts);
    Arc::new(Mockup::new(vertices, faces, part_of_face, count).unwrap())
}

/// The same triangles, distributed over this many parts.
fn strewn((vertices, faces): Arrays, parts: u32) -> Arc<Mockup> {
    let part_of_face = (0..faces.len() as u32).map(|i| (i * 7 + i / 5) % parts).collect();
    Arc::new(Mockup::new(vertices, faces, part_of_face, parts as usize).unwrap())
}

fn mockups() -> Vec<(&'static str, Arc<Mockup>)> {
    let mut random = Random::new(49);
    let boxes = |random: &mut Random, step: f64| {
        (0..30)
            .map(|_| {
                let corner: [f64; 3] = std::array::from_fn(|_| random.below(7) as f64);
                let size: [f64; 3] = std::array::from_fn(|_| 1.0 + random.below(3) as f64);
                let middle = std::array::from_fn(|a| step * (corner[a] + 0.5 * size[a]));
                box_mesh(middle, size.map(|x| step * x), 1 + random.below(3) as usize)
            })
            .collect::<Vec<_>>()
    };
    let balls = (0..20)
        .map(|i| {
            let place = random.point(-1.0, 1.0);
            let (vertices, faces) = ball(4 + i % 3, random.real(0.1, 0.5));
            (vertices.into_iter().map(|p| std::array::from_fn(|a| p[a] + place[a])).collect(), faces)
        })
        .collect();
    vec![
        ("boxes on a lattice", assembly(boxes(&mut random, 1.0))),
        (
            "boxes far off",
            assembly(boxes(&mut random, 0.1).into_iter().map(|part| placed(part, 1.0, 3000.0)).collect()),
        ),
        ("balls", assembly(balls)),
        ("a soup of few parts", strewn(soup(3, 400, 0.2), 3)),
        ("a soup of many parts", strewn(soup(4, 400, 0.2), 100)),
        ("a lattice", strewn(lattice(5, 200, 4), 9)),
        ("with defects", strewn(with_defects(soup(6, 300, 0.3)), 11)),
    ]
}

fn scene_of(mockup: &Arc<Mockup>, options: &SceneOptions<'_>) -> Scene {
    Scene::build(mockup.clone(), options).unwrap()
}

fn on_threads<R: Send>(threads: usize, work: impl FnOnce() -> R + Send) -> R {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(work)
}

/// The colliding pairs, and the same as `decided` pairs for the search of near parts.
fn search(scene: &Scene, limits: &PairLimits) -> (Vec<MeetingParts>, Vec<PartGap>) {
    let index = SelfIndex::new(scene.index()).unwrap();
    let meeting = meeting_parts(&index, limits, &[], Progress::default());
    let decided: Vec<[u32; 2]> = meeting.pairs.iter().map(|pair| pair.parts).collect();
    let near = near_parts(&index, limits, &decided, Progress::default());
    assert!(meeting.is_complete && near.is_complete);
    (meeting.pairs, near.all)
}

#[test]
fn what_meets_and_what_is_near_is_that_of_all_pairs_of_triangles() {
    let mut counts = [0; 3];
    for (name, mockup) in mockups() {
        let size = mockup.mesh().bounds().longest();
        let limits = PairLimits::uniform(0.02 * size, 0.0).unwrap();
        let (meeting, near) = (meeting_of_all_pairs(&mockup, &limits), gaps_of_all_parts(&mockup, &limits));
        counts[0] += meeting.iter().filter(|pair| pair.meets == Meets::Crossing).count();
        counts[1] += meeting.iter().filter(|pair| pair.meets == Meets::Touching).count();
        counts[2] += near.len();
        for storage in STORAGES {
            let scene = scene_of(&mockup, &SceneOptions::default().with_storage(storage));
            assert_eq!(search(&scene, &limits), (meeting.clone(), near.clone()), "{name} {storage:?}");
        }
        // Pieces of triangles: some pairs come up many times.
        for voxel_size in [0.03 * size, 0.2 * size] {
            let mut scene = scene_of(&mockup, &SceneOptions::default().with_voxel_size(voxel_size));
            for level in Level::available() {
                scene.set_lanes(level);
                assert_eq!(search(&scene, &limits), (meeting.clone(), near.clone()), "{name} {}", level.name());
            }
            for threads in [1, 2, 5] {
                let found = on_threads(threads, || search(&scene, &limits));
                assert_eq!(found, (meeting.clone(), near.clone()), "{name}, {threads} threads");
            }
        }
    }
    assert!(counts.iter().all(|count| *count > 30), "{counts:?}");
}

#[test]
fn touches_are_all_pairs_of_triangles_of_parts_that_only_touch() {
    let (_, mockup) = mockups().swap_remove(0);
    let limits = PairLimits::uniform(0.0, 0.0).unwrap();
    let scene = scene_of(&mockup, &SceneOptions::default().with_voxel_size(0.4));
    let index = SelfIndex::new(scene.index()).unwrap();
    let meeting = meeting_parts(&index, &limits, &[], Progress::default());
    let mut expected = Vec::new();
    for pair in meeting.pairs.iter().filter(|pair| pair.meets == Meets::Touching) {
        let of_part =
            |part: u32| mockup.mesh().queried().filter(|t| mockup.part_of_face(*t) == part).collect::<Vec<_>>();
        for t in of_part(pair.parts[0]) {
            for u in of_part(pair.parts[1]) {
                let [p, q] = [t, u].map(|face| mockup.mesh().triangle(face));
                if let Some(kind) = intersect_triangle_triangle(&p, &q) {
                    assert_ne!(kind, PairKind::Crossing);
                    expected.push((pair.parts, [t, u], kind));
                }
            }
        }
    }
    let found: Vec<_> = meeting.touches.iter().map(|touch| (touch.parts, touch.triangles, touch.kind)).collect();
    assert!(expected.len() > 100);
    assert_eq!(found, expected);
}

#[test]
fn only_pairs_that_are_asked_are_found() {
    let (_, mockup) = mockups().swap_remove(2);
    let parts = mockup.part_bounds().len();
    let scene = scene_of(&mockup, &SceneOptions::default());
    let plain = PairLimits::uniform(0.05, 0.0).unwrap();
    let (all, all_near) = search(&scene, &plain);
    // Classes 0 and 1 alternate. Pairs of 1 and 1 are not checked; pairs of 0 and 1 have a shorter clearance.
    let excluded = vec![[all[0].parts[1], all[0].parts[0]], all_near[0].parts];
    let tables = PairLimitTables::default()
        .with_class_of_part((0..parts as u32).map(|part| part % 2).collect())
        .with_clearance(vec![0.05, 0.02, 0.02, -1.0])
        .with_contact(vec![0.0; 4])
        .with_excluded(excluded.clone());
    let limits = PairLimits::new(tables, parts).unwrap();
    let of_pair = |[a, b]: [u32; 2]| [0.05, 0.02, -1.0][(a % 2 + b % 2) as usize];
    let is_out = |[a, b]: [u32; 2]| excluded.contains(&[a, b]) || excluded.contains(&[b, a]);
    let meeting: Vec<_> = all.iter().filter(|m| of_pair(m.parts) >= 0.0 && !is_out(m.parts)).copied().collect();
    let near: Vec<_> =
        all_near.iter().filter(|g| g.distance <= of_pair(g.parts) && !is_out(g.parts)).copied().collect();
    assert!(meeting.len() + 2 < all.len() && near.len() + 2 < all_near.len() && !near.is_empty());
    assert_eq!(search(&scene, &limits), (meeting.clone(), near.clone()));
    assert_eq!((meeting_of_all_pairs(&mockup, &limits), gaps_of_all_parts(&mockup, &limits)), (meeting, near));
    // Removed parts.
    let without = scene.without(&[all[0].parts[0]]).unwrap();
    let stays = |parts: &[u32; 2]| !parts.contains(&all[0].parts[0]);
    let expected: Vec<_> = all.iter().filter(|m| stays(&m.parts)).copied().collect();
    assert_eq!(search(&without, &plain).0, expected);
    // The contact distance that each part adds exceeds the clearance.
    let tables = PairLimitTables::default()
        .with_clearance(vec![0.0])
        .with_contact(vec![0.01])
        .with_contact_of_part(vec![0.02; parts]);
    let limits = PairLimits::new(tables, parts).unwrap();
    assert_eq!(search(&scene, &limits).1, gaps_of_all_parts(&mockup, &PairLimits::uniform(0.05, 0.0).unwrap()));
}

#[test]
fn a_search_that_is_stopped_tells_so() {
    let (_, mockup) = mockups().swap_remove(0);
    let scene = scene_of(&mockup, &SceneOptions::default());
    let index = SelfIndex::new(scene.index()).unwrap();
    let limits = PairLimits::uniform(0.1, 0.0).unwrap();
    assert!(!meeting_parts(&index, &limits, &[], Progress::new(&|_, _| false)).is_complete);
    assert!(!near_parts(&index, &limits, &[], Progress::new(&|_, _| false)).is_complete);
}

#[test]
fn tables_that_make_no_sense_are_refused() {
    let tables = || PairLimitTables::default().with_clearance(vec![0.1; 4]).with_contact(vec![0.0; 4]);
    assert!(PairLimits::new(tables(), 3).is_ok());
    let cases: Vec<(&str, PairLimitTables)> = vec![
        ("contact has 1 entries where 4", tables().with_contact(vec![0.0])),
        ("class_of_part has 2 entries where 3", tables().with_class_of_part(vec![0, 1])),
        ("clearance has 4 entries where 9", tables().with_class_of_part(vec![0, 1, 2])),
        ("contact is -0.1", tables().with_contact(vec![0.0, 0.0, 0.0, -0.1])),
        ("clearance is NaN", tables().with_clearance(vec![0.0, 0.0, 0.0, f64::NAN])),
        ("contact_of_part is inf", tables().with_contact_of_part(vec![f64::INFINITY; 3])),
        ("copies_within is NaN", tables().with_copies_within(f64::NAN)),
        ("copies_within is -0.1", tables().with_copies_within(-0.1)),
        ("clearance[1, 0] is 0.2", tables().with_clearance(vec![0.1, 0.1, 0.2, 0.1])),
        ("there is no part 3", tables().with_excluded(vec![[0, 3]])),
    ];
    for (what, tables) in cases {
        let message = PairLimits::new(tables, 3).unwrap_err().to_string();
        assert!(message.contains(what), "{message}");
    }
}
