//! The mass: millions of pairs and thousands of scenes, each compared with the oracle.
//!
//! The work of a generator is cut into units; unit `i` depends on the seed and `i` alone, and units run in waves of a fixed
//! size, so the figures are the same for every number of threads.

use std::time::Instant;

use feeler_core::{PairKind, Pose, Triangle};
use rayon::prelude::*;

use crate::check::{fault_of_pair, Checked, STORES};
use crate::minimise::{line_of_pair, lines, minimise_pair, minimise_scene, Trouble};
use crate::pairs::{self, PairMaker};
use crate::random::Random;
use crate::scenes::{self, SceneMaker, Setup};
use crate::sieve::{stage_of_pair, Stage};
use crate::{corpus, oracle};

/// One kind of trouble.
#[derive(Clone, Copy)]
pub struct Generator {
    /// The name for `--only` and the table.
    pub name: &'static str,
    /// What it makes.
    pub about: &'static str,
    /// Its share of all pairs, in proportion to the others.
    pub share: u64,
    make: Make,
}

#[derive(Clone, Copy)]
enum Make {
    Pairs(PairMaker),
    Scenes(SceneMaker),
}

/// Every generator, in the order of the table.
#[rustfmt::skip]
pub const GENERATORS: [Generator; 15] = [
    Generator { name: "general", about: "general position, as at nominal poses", share: 8, make: Make::Pairs(pairs::general) },
    Generator { name: "lattice", about: "small whole numbers", share: 14, make: Make::Pairs(pairs::lattice) },
    Generator { name: "near-coplanar", about: "one plane, up to 3 ulps off", share: 10, make: Make::Pairs(pairs::near_coplanar) },
    Generator { name: "shared", about: "corners and edges in common", share: 10, make: Make::Pairs(pairs::shared) },
    Generator { name: "slivers", about: "aspects of 1e3 to 1e15", share: 8, make: Make::Pairs(pairs::slivers) },
    Generator { name: "edge-on-edge", about: "edges through one point, up to 2 ulps off", share: 8, make: Make::Pairs(pairs::edge_on_edge) },
    Generator { name: "far", about: "features of 1e-6 and less at 1e6", share: 8, make: Make::Pairs(pairs::far) },
    Generator { name: "powers", about: "times powers of two, denormal to huge", share: 6, make: Make::Pairs(pairs::powers) },
    Generator { name: "mixed-scales", about: "denormal, unit and huge in one pair", share: 1, make: Make::Pairs(pairs::mixed_scales) },
    Generator { name: "without-area", about: "first triangle a segment or a point", share: 6, make: Make::Pairs(pairs::without_area) },
    Generator { name: "pin-in-hole", about: "zero clearance, rotated poses", share: 6, make: Make::Scenes(scenes::pin_in_hole) },
    Generator { name: "gears", about: "in mesh, flanks and faces flush", share: 5, make: Make::Scenes(scenes::gears) },
    Generator { name: "boxes", about: "touching boxes, rotated", share: 5, make: Make::Scenes(scenes::boxes) },
    Generator { name: "sheets", about: "one plane meshed twice, rotated", share: 3, make: Make::Scenes(scenes::sheets) },
    Generator { name: "lattice-soup", about: "whole numbers at poses that round", share: 2, make: Make::Scenes(scenes::lattice_soup) },
];

/// The counts.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Tally {
    /// Pairs decided by the oracle and the core, those of scenes included.
    pub pairs: u64,
    /// Of these apart, coplanar, crossing, touching.
    pub by_answer: [u64; 4],
    /// Pairs that reach the triangle test: boxes meet, neither plainly beside the other's plane.
    pub reached: u64,
    /// Of these the ones that floats could not decide.
    pub exact: u64,
    /// Queries of whole scenes, each in three stores.
    pub scene_queries: u64,
    /// Stores not built because they would take too much memory for a test.
    pub skipped: u64,
    /// The core's wrong answers: a corpus line each, after a comment that says what is wrong. At most [`MISMATCHES_SHOWN`].
    pub mismatches: Vec<String>,
    /// How many there were.
    pub mismatch_count: u64,
}

/// Mismatches that are shrunk and shown for each generator.
pub const MISMATCHES_SHOWN: usize = 10;

/// A generator's result.
#[derive(Debug, Clone)]
pub struct Row {
    /// The generator's name.
    pub name: &'static str,
    /// What it makes.
    pub about: &'static str,
    /// The figures.
    pub tally: Tally,
    /// Seconds it took.
    pub seconds: f64,
}

impl Tally {
    fn judge(&mut self, p: &Triangle, q: &Triangle, truth: Option<PairKind>) {
        self.pairs += 1;
        self.by_answer[truth.map_or(0, |kind| kind as usize + 1)] += 1;
        let stage = stage_of_pair(p, q);
        self.reached += u64::from(stage != Stage::Before);
        self.exact += u64::from(stage == Stage::Exact);
        if let Some(fault) = fault_of_pair(p, q, truth) {
            self.report(|| {
                let is_failing = |p: &Triangle, q: &Triangle| fault_of_pair(p, q, oracle::kind_of_pair(p, q)).is_some();
                let [p, q] = minimise_pair(p, q, &is_failing);
                format!("# {fault}\n{}", line_of_pair("found", &p, &q))
            });
        }
    }

    fn report(&mut self, text: impl FnOnce() -> String) {
        self.mismatch_count += 1;
        if self.mismatches.len() < MISMATCHES_SHOWN {
            self.mismatches.push(text());
        }
    }

    /// Sums the figures; keeps the first mismatches.
    pub fn add(&mut self, other: Tally) {
        self.pairs += other.pairs;
        for (a, b) in self.by_answer.iter_mut().zip(other.by_answer) {
            *a += b;
        }
        self.reached += other.reached;
        self.exact += other.exact;
        self.scene_queries += other.scene_queries;
        self.skipped += other.skipped;
        self.mismatch_count += other.mismatch_count;
        self.mismatches.extend(other.mismatches);
        self.mismatches.truncate(MISMATCHES_SHOWN);
    }

    fn scene(&mut self, setup: &Setup, r: &mut Random) {
        let Some(checked) = Checked::new(setup, |p, q, truth| self.judge(p, q, truth)) else { return };
        self.scene_queries += setup.poses.len() as u64;
        for storage in STORES {
            let size = if r.one_in(2) { None } else { Some(checked.extent() / r.real(0.5, 12.0)) };
            let size = size.filter(|x| *x > 0.0);
            let fault = match checked.fault(storage, size) {
                Ok(None) => continue,
                Ok(Some(fault)) => fault,
                Err(_) => {
                    self.skipped += 1;
                    continue;
                }
            };
            self.report(|| {
                let (pose, what) = fault;
                let is_failing = |x: &Trouble| {
                    let setup = Setup { mockup: x.mockup.clone(), tool: x.tool.clone(), poses: vec![x.pose] };
                    let checked = Checked::new(&setup, |_, _, _| {});
                    checked.is_some_and(|c| matches!(c.fault(storage, size), Ok(Some(_))))
                };
                let trouble = Trouble { mockup: setup.mockup.clone(), tool: setup.tool.clone(), pose };
                // A fault of a batch alone goes away with its other poses.
                let least = if is_failing(&trouble) { minimise_scene(&trouble, &is_failing) } else { trouble };
                format!("# {what}\n{}", lines("found", &least))
            });
        }
    }
}

/// Pairs in one unit of a pair generator.
const UNIT: u64 = 500;
/// About as many pairs in one unit of a scene generator.
const SCENE: u64 = 1000;
/// Units between two looks at the count.
const WAVE: u64 = 64;
/// Of each unit this many first and second triangles also make a scene, all against all.
const SOUP: usize = 16;

fn run_unit(generator: &Generator, seed: u64, index: u64, wanted: u64) -> Tally {
    let name = generator.name.bytes().fold(0u64, |h, b| h.wrapping_mul(31).wrapping_add(u64::from(b)));
    let mut r = Random::new(Random::new(seed ^ name).bits().wrapping_add(index));
    let mut tally = Tally::default();
    match generator.make {
        Make::Scenes(make) => tally.scene(&make(&mut r), &mut r),
        Make::Pairs(make) => {
            let mut setup = Setup { mockup: Vec::new(), tool: Vec::new(), poses: vec![Pose::IDENTITY] };
            for _ in 0..wanted.min(UNIT) {
                let [p, q] = make(&mut r);
                tally.judge(&p, &q, oracle::kind_of_pair(&p, &q));
                if setup.tool.len() < SOUP {
                    setup.tool.push(p);
                    setup.mockup.push(q);
                }
            }
            tally.scene(&setup, &mut r);
        }
    }
    tally
}

/// Runs the generators named (all when none is) until together they have judged `pairs` pairs, each its share. `progress` is
/// told the generator's name and how much of its share is done.
///
/// Errors when a name is not known.
pub fn run(pairs: u64, seed: u64, only: &[String], progress: &dyn Fn(&str, f64)) -> Result<Vec<Row>, String> {
    if let Some(unknown) = only.iter().find(|name| GENERATORS.iter().all(|g| g.name != **name)) {
        let names: Vec<&str> = GENERATORS.iter().map(|g| g.name).collect();
        return Err(format!("no generator is called {unknown:?}; there are {}", names.join(", ")));
    }
    let chosen: Vec<&Generator> =
        GENERATORS.iter().filter(|g| only.is_empty() || only.iter().any(|name| name == g.name)).collect();
    let shares: u64 = chosen.iter().map(|g| g.share).sum();
    let mut rows = Vec::new();
    for generator in chosen {
        let start = Instant::now();
        let quota = (pairs * generator.share).div_ceil(shares);
        let mut tally = Tally::default();
        let mut index = 0;
        while tally.pairs < quota {
            let left = quota - tally.pairs;
            // A pair generator's scene judges more than its pairs; a few units too many do no harm.
            let units = match generator.make {
                Make::Pairs(_) => left.div_ceil(UNIT),
                Make::Scenes(_) => left.div_ceil(SCENE),
            };
            let units = units.min(WAVE);
            let wave: Vec<Tally> =
                (index..index + units).into_par_iter().map(|i| run_unit(generator, seed, i, left)).collect();
            wave.into_iter().for_each(|t| tally.add(t));
            index += units;
            progress(generator.name, (tally.pairs as f64 / quota as f64).min(1.0));
        }
        let seconds = start.elapsed().as_secs_f64();
        rows.push(Row { name: generator.name, about: generator.about, tally, seconds });
    }
    Ok(rows)
}

/// All rows in one.
pub fn total(rows: &[Row]) -> Row {
    let mut tally = Tally::default();
    rows.iter().for_each(|row| tally.add(row.tally.clone()));
    Row { name: "all", about: "", tally, seconds: rows.iter().map(|row| row.seconds).sum() }
}

/// The words for [`Tally::by_answer`].
pub fn answers() -> [&'static str; 4] {
    [None, Some(PairKind::Coplanar), Some(PairKind::Crossing), Some(PairKind::Touching)].map(corpus::word)
}
