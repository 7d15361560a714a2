//! The parts that stopped the tool: counted, with the pose of the best attempt.

use std::collections::BTreeMap;

use feeler_core::Pose;
use feeler_world::{Surroundings, Walk};

/// A part that stopped the tool.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Blocker {
    /// Of the mock-up.
    pub part: u32,
    /// Tries that it stopped.
    pub count: u64,
    /// How far from the start the tool's middle was in the best of them, metres.
    pub reach: f64,
    /// Where the tool was stopped then.
    pub pose: Pose,
}

/// The attempts, and the parts that stopped them.
#[derive(Debug, Clone, Default)]
pub struct Tally {
    /// Casts made.
    pub casts: u64,
    stops: BTreeMap<u32, Blocker>,
}

impl Tally {
    /// Notes that a part stopped the tool at a pose, `reach` from the start.
    pub fn note(&mut self, part: u32, reach: f64, pose: &Pose) {
        let blocker = self.stops.entry(part).or_insert(Blocker { part, count: 0, reach, pose: *pose });
        blocker.count += 1;
        if reach > blocker.reach {
            (blocker.reach, blocker.pose) = (reach, *pose);
        }
    }

    /// Counts a motion.
    pub fn walked(&mut self, around: &Surroundings, walk: &Walk) {
        self.casts += walk.casts;
        if let Some(stop) = walk.stop {
            self.note(stop.part, around.reach(&walk.pose), &walk.pose);
        }
    }

    /// Adds the counts of another.
    pub fn add(&mut self, other: &Tally) {
        self.casts += other.casts;
        for theirs in other.stops.values() {
            match self.stops.get_mut(&theirs.part) {
                None => drop(self.stops.insert(theirs.part, *theirs)),
                Some(own) => {
                    own.count += theirs.count;
                    if theirs.reach > own.reach {
                        (own.reach, own.pose) = (theirs.reach, theirs.pose);
                    }
                }
            }
        }
    }

    /// The worst first: by how often, then by number.
    pub fn blockers(&self) -> Vec<Blocker> {
        let mut all: Vec<Blocker> = self.stops.values().copied().collect();
        all.sort_by(|a, b| b.count.cmp(&a.count).then(a.part.cmp(&b.part)));
        all
    }
}
