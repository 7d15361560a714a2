//! Judges sets of bodies in which each body has its own pose: parts that fit, flush faces, lattices.
//!
//! A scene of [`scenes`] gives the bodies: its mock-up, and its tool once for each pose. One more motion then moves all of them, so
//! that numbers which were equal are rounded differently. [`Pose::apply`] computes the corners, and the oracle decides each pair of
//! triangles.

use std::collections::BTreeMap;
use std::sync::Arc;

use feeler_core::{Bodies, PairKind, Pose, Shape, Triangle, Who};
use rayon::prelude::*;

use crate::casts::KEPT;
use crate::check::arrays_of;
use crate::oracle::{has_area, kind_of_pair};
use crate::random::Random;
use crate::scenes::{self, SceneMaker};
use crate::shapes::Motion;

const MAKERS: [SceneMaker; 5] =
    [scenes::pin_in_hole, scenes::gears, scenes::boxes, scenes::sheets, scenes::lattice_soup];

/// Triangles of a body of which all are judged; of larger ones some.
const MOST: usize = 120;

/// The results of many sets.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Tally {
    /// Sets of bodies.
    pub sets: u64,
    /// Pairs of bodies.
    pub bodies: u64,
    /// Pairs of triangles that were judged.
    pub pairs: u64,
    /// Of these, the ones that meet.
    pub meeting: u64,
    /// Pairs without an area where they are, both: not judged.
    pub not_judged: u64,
    /// Pairs about which the core was wrong.
    pub wrong: u64,
    /// Some of the errors, in words.
    pub faults: Vec<String>,
}

impl Tally {
    fn and(mut self, other: Tally) -> Tally {
        self.sets += other.sets;
        self.bodies += other.bodies;
        self.pairs += other.pairs;
        self.meeting += other.meeting;
        self.not_judged += other.not_judged;
        self.wrong += other.wrong;
        self.faults.extend(other.faults);
        self.faults.truncate(KEPT);
        self
    }
}

/// Judges a number of sets, in parallel.
pub fn run(sets: u64, seed: u64) -> Tally {
    let each = (0..sets).into_par_iter().map(|n| judge(seed.wrapping_mul(0x9e37_79b9).wrapping_add(n)));
    // In order, whatever the threads.
    each.collect::<Vec<_>>().into_iter().fold(Tally::default(), Tally::and)
}

struct Placed {
    shape: Arc<Shape>,
    pose: Pose,
}

fn judge(seed: u64) -> Tally {
    let r = &mut Random::new(seed);
    let setup = MAKERS[r.below(MAKERS.len())](r);
    let moved = match r.below(4) {
        0 => Motion::NONE,
        1 => Motion::shift(r.lattice_point(-64, 64)),
        2 => Motion::random(r, 1.0),
        _ => Motion::random(r, 3000.0),
    };
    let shape = |mut triangles: Vec<Triangle>| {
        triangles.retain(has_area);
        triangles.truncate(MOST);
        let (vertices, faces) = arrays_of(&triangles);
        Shape::new(vertices, faces, u64::MAX).ok().map(Arc::new)
    };
    let mut tally = Tally { sets: 1, ..Tally::default() };
    let (Some(mockup), Some(tool)) = (shape(setup.mockup), shape(setup.tool)) else { return tally };
    let after = |pose: &Pose| -> Option<Pose> {
        let [w, p] = [moved.pose(), *pose];
        let row = |i: usize, of: &dyn Fn(usize) -> f64| (0..3).map(|k| w.rotation()[i][k] * of(k)).sum::<f64>();
        let mut m = [[0.0; 4]; 4];
        for (i, to) in m.iter_mut().take(3).enumerate() {
            for (j, entry) in to.iter_mut().take(3).enumerate() {
                *entry = row(i, &|k| p.rotation()[k][j]);
            }
            to[3] = row(i, &|k| p.translation()[k]) + w.translation()[i];
        }
        m[3][3] = 1.0;
        Pose::new(&m).ok()
    };
    let mut placed = vec![Placed { shape: mockup, pose: moved.pose() }];
    let poses = setup.poses.iter().filter_map(after);
    placed.extend(poses.map(|pose| Placed { shape: Arc::clone(&tool), pose }));
    let mut bodies = Bodies::default();
    placed.iter().for_each(|body| _ = bodies.add(Arc::clone(&body.shape), body.pose));
    let found = bodies.contacts(Who::Each).expect("there is no limit of memory");
    let of = |contact: &feeler_core::BodyContact| ((contact.bodies, contact.triangles), contact.kind);
    let found: BTreeMap<([u32; 2], [u32; 2]), Option<PairKind>> = found.iter().map(of).collect();
    for a in 0..placed.len() {
        for b in a + 1..placed.len() {
            tally.bodies += 1;
            judge_pair([a as u32, b as u32], [&placed[a], &placed[b]], &found, seed, &mut tally);
        }
    }
    tally
}

fn judge_pair(
    bodies: [u32; 2],
    placed: [&Placed; 2],
    found: &BTreeMap<([u32; 2], [u32; 2]), Option<PairKind>>,
    seed: u64,
    tally: &mut Tally,
) {
    let [first, second] = placed.map(|body| {
        let mesh = body.shape.mesh();
        mesh.queried().map(|id| (id, body.pose.apply_triangle(&mesh.triangle(id)))).collect::<Vec<_>>()
    });
    for (s, p) in &first {
        for (t, q) in &second {
            if !has_area(p) && !has_area(q) {
                tally.not_judged += 1;
                continue;
            }
            let (truth, said) = (kind_of_pair(p, q), found.get(&(bodies, [*s, *t])).copied().flatten());
            tally.pairs += 1;
            tally.meeting += u64::from(truth.is_some());
            if truth != said {
                tally.wrong += 1;
                if tally.faults.len() < KEPT {
                    let words =
                        format!("seed {seed}, bodies {bodies:?}, triangles {s} and {t}: {said:?}, in truth {truth:?}");
                    tally.faults.push(words);
                }
            }
        }
    }
}
