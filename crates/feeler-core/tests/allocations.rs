//! Allocations: none by warm queries, those of an index as `memory()` reports them, and no more than the limit while
//! building.

mod common;

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::sync::atomic::{AtomicUsize, Ordering::SeqCst};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use common::*;
use feeler_core::{
    BatchOptions, Collision, Error, Filters, IgnoredPairs, Mockup, Pose, Scene, SceneOptions, Storage, Tool,
};

struct Counting;

static RESIDENT: AtomicUsize = AtomicUsize::new(0);
static PEAK: AtomicUsize = AtomicUsize::new(0);

thread_local! {
    static ALLOCATIONS: Cell<usize> = const { Cell::new(0) };
}

fn grown(bytes: usize) {
    let now = RESIDENT.fetch_add(bytes, SeqCst) + bytes;
    PEAK.fetch_max(now, SeqCst);
    // The thread-local value is gone while a thread ends.
    let _ = ALLOCATIONS.try_with(|n| n.set(n.get() + 1));
}

// SAFETY: everything is passed on to the system's allocator; the counting itself allocates nothing.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        grown(layout.size());
        // SAFETY: as the caller promises.
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        grown(layout.size());
        // SAFETY: as the caller promises.
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn dealloc(&self, at: *mut u8, layout: Layout) {
        RESIDENT.fetch_sub(layout.size(), SeqCst);
        // SAFETY: as the caller promises.
        unsafe { System.dealloc(at, layout) }
    }

    unsafe fn realloc(&self, at: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        if size > layout.size() {
            grown(size - layout.size());
        } else {
            RESIDENT.fetch_sub(layout.size() - size, SeqCst);
        }
        // SAFETY: as the caller promises.
        unsafe { System.realloc(at, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// One test at a time: the figures are the process's.
fn alone() -> MutexGuard<'static, ()> {
    static ONE: Mutex<()> = Mutex::new(());
    let guard = ONE.lock().unwrap_or_else(PoisonError::into_inner);
    // The threads of the pool and their memory are not part of an index.
    rayon::broadcast(|_| ());
    guard
}

/// Bytes more (at the most, afterwards) while `work` runs, and its result.
fn growth<R>(work: impl FnOnce() -> R) -> (usize, isize, R) {
    let before = RESIDENT.load(SeqCst);
    PEAK.store(before, SeqCst);
    let result = work();
    (PEAK.load(SeqCst) - before, RESIDENT.load(SeqCst) as isize - before as isize, result)
}

fn build(mockup: &Arc<Mockup>, storage: Storage, voxel_size: Option<f64>, memory_limit: u64) -> Result<Scene, Error> {
    let options =
        SceneOptions::default().with_voxel_size(voxel_size).with_storage(storage).with_memory_limit(memory_limit);
    Scene::build(Arc::clone(mockup), &options)
}

/// About 100 thousand triangles: a ball of small ones, and long needles that get cut.
fn large() -> Arrays {
    let (mut vertices, mut faces) = placed(ball(220, 0.5), 1.0, 0.5);
    let (more, needles) = needles(1, 3000, 0.01);
    faces.extend(needles.iter().map(|f| f.map(|i| i + vertices.len() as u32)));
    vertices.extend(more);
    vertices.shrink_to_fit();
    faces.shrink_to_fit();
    (vertices, faces)
}

#[test]
fn warm_queries_allocate_nothing() {
    let _alone = alone();
    let mockup = mockup_of(large());
    let tools: Vec<Tool> = [(60, 0.1), (5, 0.3), (400, 0.02)]
        .into_iter()
        .map(|(count, size)| tool_of(placed(soup(count as u64, count, size), 0.5, -0.25)))
        .collect();
    let mut r = Random::new(2);
    let poses: Vec<Pose> = (0..12).map(|_| r.pose(0.6)).collect();
    for storage in STORAGES {
        let scene = build(&mockup, storage, None, u64::MAX).unwrap();
        let mut out = Collision::default();
        let mut pairs = 0;
        let mut round = |counts: &mut Vec<usize>| {
            for pose in &poses {
                for tool in &tools {
                    let before = ALLOCATIONS.get();
                    scene.collide_into(tool, pose, Filters::default(), &mut out);
                    counts.push(ALLOCATIONS.get() - before);
                    pairs += out.pairs.len();
                    let before = ALLOCATIONS.get();
                    scene.is_colliding(tool, pose);
                    counts.push(ALLOCATIONS.get() - before);
                }
            }
        };
        let (mut cold, mut warm) = (Vec::with_capacity(1000), Vec::with_capacity(1000));
        round(&mut cold);
        round(&mut warm);
        assert!(cold.iter().sum::<usize>() > 0, "the counter counts");
        assert_eq!(warm.iter().sum::<usize>(), 0, "{storage:?}: {warm:?}");
        assert!(pairs > 500, "{pairs} pairs make no test");
    }
}

#[test]
fn memory_says_what_the_allocator_says() {
    let _alone = alone();
    for parts in [0u32, 100] {
        for storage in STORAGES {
            for voxel_size in [None, Some(0.02)] {
                let (_, resident, scene) = growth(|| {
                    let (vertices, faces) = large();
                    let part_of_face = (0..if parts > 0 { faces.len() as u32 } else { 0 }).map(|i| i % parts).collect();
                    let mockup = Mockup::new(vertices, faces, part_of_face, parts.max(1) as usize).unwrap();
                    build(&Arc::new(mockup), storage, voxel_size, u64::MAX).unwrap()
                });
                let said: usize = scene.memory().iter().map(|(_, bytes)| bytes).sum();
                let error = said as f64 / resident as f64 - 1.0;
                assert!(
                    error.abs() < 0.05,
                    "{storage:?}, {voxel_size:?}, {parts} parts: memory() says {said}, the allocator {resident} ({:.1} % off): {:?}",
                    100.0 * error,
                    scene.memory()
                );
            }
        }
    }
}

#[test]
fn what_needs_too_much_is_refused_before_it_is_allocated() {
    let _alone = alone();
    let mockup = mockup_of(large());
    let triangles = mockup.mesh().faces().len();
    for storage in STORAGES {
        for (voxel_size, limit) in
            [(1e-3, 8 << 20), (1e-5, 8 << 20), (1e-6, 1 << 30), (1e-6, 0), (0.05, 1000), (5.0, 0)]
        {
            let what = format!("{storage:?}, voxels of {voxel_size} m, {limit} bytes");
            let (peak, left, result) = growth(|| build(&mockup, storage, Some(voxel_size), limit));
            let Err(Error::Memory { needed, allowed, .. }) = result else {
                panic!("{what}: not refused ({:?})", result.map(|scene| scene.memory()));
            };
            assert_eq!(allowed, limit, "{what}");
            assert!(needed > limit, "{what}: {needed} bytes");
            // Ids of the triangles may be listed, but nothing the size of an index.
            assert!(peak < 64 * 1024 + 8 * triangles, "{what}: {peak} bytes at the most before the refusal");
            assert!(left < 16 * 1024, "{what}: {left} bytes left behind");
            if let (Storage::Dense, 1e-6) = (storage, voxel_size) {
                // More than a cubic metre in voxels of a micrometre: 4e18 bytes or more for the array alone.
                assert!((4e18..2e19).contains(&(needed as f64)), "{what}: {needed} bytes");
            }
        }
    }
}

#[test]
fn the_figure_of_a_refusal_is_near_what_it_takes() {
    let _alone = alone();
    let mockup = mockup_of(large());
    for (storage, voxel_size) in
        [(Storage::Dense, 0.004), (Storage::Hashed { level: 0.9 }, 0.004), (Storage::Blocks, 0.01)]
    {
        let (peak, _, scene) = growth(|| build(&mockup, storage, Some(voxel_size), u64::MAX).unwrap());
        drop(scene);
        let mut refused = 0;
        for share in [0.1, 0.5, 0.9] {
            let limit = (share * peak as f64) as u64;
            if let Err(error) = build(&mockup, storage, Some(voxel_size), limit) {
                let Error::Memory { needed, .. } = error else { panic!("{error}") };
                refused += 1;
                let ratio = needed as f64 / peak as f64;
                assert!((0.05..1.5).contains(&ratio), "{storage:?}: said {needed} bytes, took {peak}");
            }
        }
        assert!(refused > 0, "{storage:?}");
        assert!(build(&mockup, storage, Some(voxel_size), peak as u64 + peak as u64 / 2).is_ok(), "{storage:?}");
    }
}

#[test]
fn building_stays_within_the_limit() {
    let _alone = alone();
    let mockup = mockup_of(large());
    let mut counts = [0; 2];
    for storage in STORAGES {
        for voxel_size in [None, Some(0.02), Some(2.0)] {
            let (free, _, scene) = growth(|| build(&mockup, storage, voxel_size, u64::MAX).unwrap());
            drop(scene);
            for percent in [40, 70, 90, 100] {
                let limit = free as u64 * percent / 100;
                let (peak, _, result) = growth(|| build(&mockup, storage, voxel_size, limit));
                let what = format!("{storage:?}, {voxel_size:?}, limit {limit}");
                counts[usize::from(result.is_ok())] += 1;
                match result {
                    // A few per cent for task lists and allocator rounding.
                    Ok(_) => assert!(peak as f64 <= 1.05 * limit as f64 + 65536.0, "{what}: {peak} bytes at the most"),
                    Err(Error::Memory { needed, .. }) => assert!(needed > limit, "{what}: refused for {needed}"),
                    Err(error) => panic!("{what}: {error}"),
                }
            }
        }
    }
    assert!(counts.iter().all(|n| *n > 5), "{counts:?} refused and built");
}

#[test]
fn a_batch_stays_within_the_limit() {
    let _alone = alone();
    let mockup = mockup_of(soup(3, 2000, 0.1));
    let tool = tool_of(placed(soup(4, 200, 0.1), 0.5, 0.25));
    let poses = vec![Pose::IDENTITY; 10_000];
    let scene = build(&mockup, Storage::Blocks, None, u64::MAX).unwrap();
    let pairs = scene.collide(&tool, &Pose::IDENTITY).pairs.len();
    assert!(pairs > 100, "{pairs} pairs make no test");
    // Each thread has working memory of its own, which stays: on a machine of many cores more than is allowed for below.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
    for limit in [0, 1 << 20, 16 << 20] {
        let scene = build(&mockup, Storage::Blocks, None, limit.max(1 << 19)).unwrap();
        let limit = limit.max(1 << 19);
        let (peak, left, result) =
            growth(|| pool.install(|| scene.collide_batch(&tool, &poses, &BatchOptions::default())));
        let Err(Error::Memory { needed, allowed, .. }) = result else { panic!("{pairs} pairs each fit {limit} bytes") };
        assert!(allowed == limit && needed > limit);
        assert!(peak as u64 <= limit + (1 << 20), "limit {limit}: {peak} bytes at the most");
        assert!(left < 1 << 19, "{left} bytes left behind");
    }
    // The memory that the error asks for is enough, also if poses with many pairs come before or after many without any.
    let away =
        Pose::new(&[[1.0, 0.0, 0.0, 9.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]]).unwrap();
    for (before, meeting, after) in [(0, 10_000, 0), (0, 2_000, 30_000), (30_000, 2_000, 0)] {
        let poses = [vec![away; before], vec![Pose::IDENTITY; meeting], vec![away; after]].concat();
        let needed = 24 * poses.len() as u64 + 26 * (pairs * meeting) as u64;
        let scene = build(&mockup, Storage::Blocks, None, needed).unwrap();
        let (peak, _, batch) = growth(|| pool.install(|| scene.collide_batch(&tool, &poses, &BatchOptions::default())));
        assert_eq!(batch.unwrap().pairs.len(), pairs * meeting);
        let share = peak as f64 / needed as f64;
        assert!((0.5..1.0).contains(&share), "{before}, {meeting}, {after}: {share} of the limit");
    }
}

#[test]
fn a_batch_allocates_for_some_poses_together_and_for_none_alone() {
    let _alone = alone();
    let mockup = mockup_of(soup(3, 2000, 0.1));
    let tool = tool_of(placed(soup(4, 200, 0.1), 0.5, 0.25));
    let scene = build(&mockup, Storage::Blocks, None, u64::MAX).unwrap();
    let mut r = Random::new(5);
    let poses: Vec<Pose> = (0..4000).map(|_| r.pose(0.4)).collect();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let allocations = |count: usize| {
        pool.install(|| {
            let before = ALLOCATIONS.get();
            let batch = scene.collide_batch(&tool, &poses[..count], &BatchOptions::default()).unwrap();
            assert!(batch.pairs.len() > 10 * count, "{} pairs make no test", batch.pairs.len());
            ALLOCATIONS.get() - before
        })
    };
    allocations(1000);
    let (few, many) = (allocations(1000), allocations(4000));
    assert!(many - few < 3000 / 4, "{few} allocations for 1000 poses, {many} for 4000");
}

#[test]
fn building_takes_at_most_twice_what_stays() {
    let _alone = alone();
    let (peak, _, scene) = growth(|| build(&mockup_of(large()), Storage::Blocks, None, u64::MAX).unwrap());
    let stays: usize = scene.memory().iter().map(|(_, bytes)| bytes).sum();
    assert!(peak <= 2 * stays, "{peak} bytes at the most for {stays}");
}

#[test]
fn ignored_pairs_that_are_near_are_not_remembered() {
    let _alone = alone();
    // Two soups in one place: nearly a million pairs are near, and none of them ends the search for the closest one that counts.
    let (vertices, faces) = soup(3, 1500, 0.4);
    let parts: Vec<u32> = (0..faces.len() as u32).map(|i| i % 2).collect();
    let mockup = Arc::new(Mockup::new(vertices.clone(), faces.clone(), parts.clone(), 2).unwrap());
    let tool = Tool::of_parts(vertices, faces, parts, 2).unwrap();
    let scene = build(&mockup, Storage::Blocks, None, u64::MAX).unwrap();
    for (ignored, counts) in [(vec![[0, 0], [0, 1], [1, 0], [1, 1]], false), (vec![[0, 0], [0, 1], [1, 0]], true)] {
        let scene = scene.ignoring(Arc::new(IgnoredPairs::new(2, 2, ignored)));
        let away = Pose::IDENTITY.translated(&[0.0, 0.0, if counts { 3.0 } else { 0.0 }]).unwrap();
        let (peak, _, gap) = growth(|| scene.distance(&tool, &away, f64::INFINITY).unwrap());
        assert_eq!(gap.is_some(), counts);
        assert!(peak < 1 << 20, "{peak} bytes");
    }
}
