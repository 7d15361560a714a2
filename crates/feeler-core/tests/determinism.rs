//! One golden hash: the same scenes give the same pairs and kinds whatever the number of threads, the instruction set, the store,
//! the voxel size, the state of the working memory, one pose or many at a time; and in debug and release and on every machine, since all
//! compare with the number in `testdata/golden.txt`.
//!
//! The scenes are made with whole numbers, rotations by 3-4-5 triangles and correctly rounded operations only: sine and
//! cosine differ between platforms.

mod common;

use std::sync::Arc;

use common::*;
use feeler_core::{Filters, Level, Mockup, PairKind, Point, Pose, Scene, SceneOptions, Storage, Tool, Triangle};

const GOLDEN: &str = include_str!("../../../testdata/golden.txt");

const STORES: [Storage; 5] = [
    Storage::Blocks,
    Storage::Dense,
    Storage::Hashed { level: 0.0 },
    Storage::Hashed { level: 0.5 },
    Storage::Hashed { level: 0.95 },
];

/// FNV-1a.
#[derive(Clone, Copy)]
struct Hash(u64);

impl Hash {
    const NEW: Hash = Hash(0xcbf2_9ce4_8422_2325);

    fn add(&mut self, word: u32) {
        for byte in word.to_le_bytes() {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3);
        }
    }
}

/// The pairs and kinds at all poses, in order.
fn hash<'a>(poses: impl Iterator<Item = (&'a [[u32; 2]], &'a [PairKind])>) -> u64 {
    let mut hash = Hash::NEW;
    for (pairs, kinds) in poses {
        hash.add(pairs.len() as u32);
        for ([tool, mockup], kind) in pairs.iter().zip(kinds) {
            [*tool, *mockup, *kind as u32].iter().for_each(|word| hash.add(*word));
        }
    }
    hash.0
}

struct Case {
    name: &'static str,
    mockup: Arc<Mockup>,
    tool: Tool,
    poses: Vec<Pose>,
}

impl Case {
    fn new(name: &'static str, mockup: Vec<Triangle>, tool: Vec<Triangle>, poses: Vec<Pose>) -> Case {
        Case { name, mockup: mockup_of(arrays_of(mockup)), tool: tool_of(arrays_of(tool)), poses }
    }
}

/// About the z, y or x axis by the angle of a 3-4-5 triangle, or a quarter turn, then moved.
fn turned(axis: usize, [c, s]: [f64; 2], t: Point) -> Pose {
    let (u, v) = ([1, 2, 0][axis], [2, 0, 1][axis]);
    let mut m = [[0.0; 4]; 4];
    (m[axis][axis], m[3][3]) = (1.0, 1.0);
    (m[u][u], m[u][v], m[v][u], m[v][v]) = (c, -s, s, c);
    for i in 0..3 {
        m[i][3] = t[i];
    }
    Pose::new(&m).unwrap()
}

const THREE_FOUR_FIVE: [f64; 2] = [0.8, 0.6];
const FIVE_TWELVE: [f64; 2] = [5.0 / 13.0, 12.0 / 13.0];
const QUARTER: [f64; 2] = [0.0, 1.0];

/// Points of a circle at rational places `((1 - t^2) / (1 + t^2), 2 t / (1 + t^2))`: `4 n` of them.
fn circle(n: u32, radius: f64) -> Vec<[f64; 2]> {
    let quarter: Vec<[f64; 2]> = (0..n)
        .map(|i| {
            let t = f64::from(i) / f64::from(n);
            [radius * (1.0 - t * t) / (1.0 + t * t), radius * (2.0 * t) / (1.0 + t * t)]
        })
        .collect();
    let turn = |k: usize, [x, y]: [f64; 2]| [[x, y], [-y, x], [-x, -y], [y, -x]][k];
    (0..4).flat_map(|k| quarter.iter().map(move |p| turn(k, *p))).collect()
}

/// A solid between two heights around the z axis; with a hole when the inner outline is not empty.
fn tube(outer: &[[f64; 2]], inner: &[[f64; 2]], low: f64, high: f64) -> Vec<Triangle> {
    let n = outer.len();
    let at = |p: [f64; 2], z: f64| -> Point { [p[0], p[1], z] };
    let mut triangles = Vec::new();
    for i in 0..n {
        let j = (i + 1) % n;
        let mut quad = |a: Point, b: Point, c: Point, d: Point| triangles.extend([[a, b, c], [a, c, d]]);
        quad(at(outer[i], low), at(outer[j], low), at(outer[j], high), at(outer[i], high));
        if inner.is_empty() {
            triangles.push([at([0.0; 2], high), at(outer[i], high), at(outer[j], high)]);
            triangles.push([at([0.0; 2], low), at(outer[j], low), at(outer[i], low)]);
        } else {
            quad(at(inner[j], low), at(inner[i], low), at(inner[i], high), at(inner[j], high));
            quad(at(outer[i], high), at(outer[j], high), at(inner[j], high), at(inner[i], high));
            quad(at(outer[j], low), at(outer[i], low), at(inner[i], low), at(inner[j], low));
        }
    }
    triangles
}

fn gear(n: u32) -> Vec<Triangle> {
    let (tip, root) = (circle(n, 1.25), circle(n, 1.0));
    let outline: Vec<[f64; 2]> = (0..tip.len()).map(|i| if i % 4 < 2 { tip[i] } else { root[i] }).collect();
    tube(&outline, &circle(n, 0.5), 0.0, 0.5)
}

fn cuboid(low: Point, size: f64) -> Vec<Triangle> {
    let [x, y, z] = low;
    tube(&[[x, y], [x + size, y], [x + size, y + size], [x, y + size]], &[], z, z + size)
}

fn cases() -> Vec<Case> {
    // A crooked place in the world: 3-4-5 about two axes, then moved by numbers with all their bits.
    let world = turned(0, FIVE_TWELVE, [0.1, 0.7, 1.3]);
    let placed = |triangles: &[Triangle], pose: &Pose| -> Vec<Triangle> {
        triangles.iter().map(|t| pose.apply_triangle(t)).collect()
    };
    let (hole, pin) = (tube(&circle(8, 2.0), &circle(8, 1.0), 0.0, 1.0), tube(&circle(8, 1.0), &[], 0.0, 1.0));
    let pile: Vec<Triangle> =
        (0..27u8).flat_map(|i| cuboid([i % 3, i / 3 % 3, i / 9].map(|x| f64::from(x) * 0.3), 0.3)).collect();
    let soup_of = |seed: u64, count: usize, size: f64| -> Vec<Triangle> {
        let (vertices, faces) = soup(seed, count, size);
        faces.iter().map(|f| f.map(|i| vertices[i as usize])).collect()
    };
    let lattice_of = |seed: u64, count: usize, side: u64| -> Vec<Triangle> {
        let (vertices, faces) = lattice(seed, count, side);
        faces.iter().map(|f| f.map(|i| vertices[i as usize])).collect()
    };
    let needles_of = |seed: u64, count: usize| -> Vec<Triangle> {
        let (vertices, faces) = needles(seed, count, 1e-3);
        faces.iter().map(|f| f.map(|i| vertices[i as usize])).collect()
    };
    let mut r = Random::new(11);
    vec![
        Case::new(
            "pin in a hole",
            placed(&hole, &world),
            pin,
            vec![
                world,
                turned(0, FIVE_TWELVE, [0.1, 0.7, 1.3f64.next_up()]),
                turned(0, THREE_FOUR_FIVE, [0.1, 0.7, 1.3]),
                turned(0, FIVE_TWELVE, [0.1, 0.2, 1.0]),
                turned(2, QUARTER, [0.1, 0.7, 1.3]),
            ],
        ),
        Case::new(
            "gears in mesh",
            gear(6),
            gear(6),
            vec![
                moved([2.25, 0.0, 0.0]),
                turned(2, QUARTER, [2.25, 0.0, 0.0]),
                turned(2, THREE_FOUR_FIVE, [0.0, 2.25, 0.5]),
                turned(2, FIVE_TWELVE, [0.0, 2.25, 0.0]),
                Pose::IDENTITY,
            ],
        ),
        Case::new(
            "boxes",
            pile,
            cuboid([0.0; 3], 0.3),
            vec![
                moved([0.3, 0.3, 0.9]),
                moved([0.3 + 0.3, 0.3, 0.3]),
                moved([0.15, 0.45, 0.3]),
                turned(1, QUARTER, [0.6, 0.0, 0.3]),
                turned(2, THREE_FOUR_FIVE, [0.3, 0.3, 0.3]),
            ],
        ),
        Case::new(
            "soup",
            soup_of(1, 400, 0.08),
            soup_of(2, 80, 0.08),
            (0..8).map(|i| turned(i % 3, [THREE_FOUR_FIVE, FIVE_TWELVE][i % 2], r.point(-0.3, 0.3))).collect(),
        ),
        Case::new("lattice", lattice_of(5, 300, 6), lattice_of(6, 60, 4), (0..6).map(|_| r.lattice_pose(2)).collect()),
        Case::new(
            "needles",
            needles_of(7, 120),
            needles_of(8, 40),
            (0..4).map(|i| turned(i % 3, THREE_FOUR_FIVE, r.point(-0.1, 0.4))).collect(),
        ),
    ]
}

/// The hash of one case when asked in every way at once; panics when two ways differ.
fn hash_of_case(case: &Case) -> u64 {
    let extent = case.mockup.mesh().bounds().extent().iter().fold(0.0f64, |m, x| m.max(*x));
    let mut agreed = None;
    let mut agree = |hash: u64, what: &dyn Fn() -> String| {
        assert_eq!(hash, *agreed.get_or_insert(hash), "{}: {}", case.name, what());
    };
    for threads in [1, 2, 3, 8] {
        rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(|| {
            for storage in STORES {
                for size in [None, Some(extent / 2.0), Some(extent / 9.7), Some(extent / 40.0)] {
                    let what = |how: &str| format!("{storage:?}, voxel size {size:?}, {threads} threads, {how}");
                    let options = SceneOptions { voxel_size: size, storage, ..SceneOptions::default() };
                    let mut scene = Scene::build(Arc::clone(&case.mockup), &options, &|_, _| true).unwrap();
                    let mut ways = vec![
                        ("cold", Level::best(), Filters::default()),
                        ("warm", Level::best(), Filters::default()),
                        ("no filters", Level::best(), Filters { repeats: false, boxes: false }),
                    ];
                    ways.extend(Level::available().into_iter().map(|l| (l.name(), l, Filters::default())));
                    for (how, lanes, filters) in ways {
                        scene.set_lanes(lanes);
                        let found: Vec<_> = case.poses.iter().map(|p| scene.collide(&case.tool, p, filters)).collect();
                        let single = hash(found.iter().map(|c| (&c.pairs[..], &c.kinds[..])));
                        agree(single, &|| what(how));
                    }
                    // The poses twice over, so that more than one thread has something to do.
                    let twice: Vec<Pose> = case.poses.iter().cycle().take(2 * case.poses.len()).copied().collect();
                    let batch = scene.collide_batch(&case.tool, &twice, &|_, _| true).unwrap();
                    let ranges: Vec<_> = batch.offsets.windows(2).map(|w| w[0] as usize..w[1] as usize).collect();
                    for half in ranges.chunks(case.poses.len()) {
                        let hash = hash(half.iter().map(|r| (&batch.pairs[r.clone()], &batch.kinds[r.clone()])));
                        agree(hash, &|| what("in a batch"));
                    }
                }
            }
        });
    }
    agreed.unwrap()
}

#[test]
fn one_golden_hash_whatever_the_threads_stores_voxels_and_order() {
    let mut golden = Hash::NEW;
    let mut kinds = [0; 3];
    for case in cases() {
        let hash = hash_of_case(&case);
        golden.add(hash as u32);
        golden.add((hash >> 32) as u32);
        // A hash over nothing would be golden for ever.
        for pose in &case.poses {
            for (_, kind) in feeler_core::collide_all_pairs(case.mockup.mesh(), &case.tool, pose) {
                kinds[kind as usize] += 1;
            }
        }
    }
    assert!(kinds.iter().all(|n| *n > 300), "{kinds:?} coplanar, crossing, touching pairs make no test");
    let written = GOLDEN.lines().find(|line| !line.starts_with('#')).unwrap_or_default().trim();
    assert_eq!(format!("{:016x}", golden.0), written, "not the number in testdata/golden.txt");
}
