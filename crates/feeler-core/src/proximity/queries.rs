//! The queries on a scene.

use super::{Gap, Goal, SearchScratch, Wanted};
use crate::error::{Error, Result};
use crate::pose::Pose;
use crate::scene::Scene;
use crate::tool::Tool;

/// Working memory of one query at a time.
#[derive(Debug, Default)]
pub struct ProximityScratch {
    gaps: Vec<Gap>,
    places: Vec<u32>,
    sorted: Vec<f64>,
    pub(crate) search: SearchScratch,
}

impl Scene {
    /// Every pair of triangles with a distance of at most `within` (metres), sorted by distance, then tool triangle, then
    /// mock-up triangle. Pairs that meet have distance 0.
    ///
    /// Errors: `within` negative or NaN, and more pairs than the memory limit of the scene allows.
    pub fn near_pairs(&self, tool: &Tool, pose: &Pose, within: f64) -> Result<Vec<Gap>> {
        self.gaps(tool, pose, Goal::Pairs, ("within", within))
    }

    /// The closest pair of triangles of each part with a distance of at most `within` (metres), sorted as
    /// [`near_pairs`](Self::near_pairs).
    ///
    /// Of several pairs at the same distance, the one with the least ids; of several that meet, any. Errors: `within` negative
    /// or NaN.
    pub fn clearance(&self, tool: &Tool, pose: &Pose, within: f64) -> Result<Vec<Gap>> {
        self.gaps(tool, pose, Goal::Parts, ("within", within))
    }

    /// The closest pair of triangles of each of the `k` closest parts, but none farther than `max` (metres); sorted as
    /// [`near_pairs`](Self::near_pairs). With `k` = 1 the first entry is the minimum distance; no entry: nothing within `max`.
    ///
    /// Of several pairs at the same distance, the one with the least ids; of several that meet, any, and of more than `k`
    /// parts that meet the tool, any `k`. Errors: `max` negative or NaN, and `k` zero.
    pub fn distance(&self, tool: &Tool, pose: &Pose, max: f64, k: usize) -> Result<Vec<Gap>> {
        if k == 0 {
            return Err(Error::NoneAsked { what: "k" });
        }
        self.gaps(tool, pose, Goal::Nearest(k), ("max", max))
    }

    fn gaps(&self, tool: &Tool, pose: &Pose, goal: Goal, (what, within): (&'static str, f64)) -> Result<Vec<Gap>> {
        if within.is_nan() || within < 0.0 {
            return Err(Error::Distance { what, value: within });
        }
        let mut scratch = self.take_scratch();
        let proximity = &mut scratch.proximity;
        let most = usize::try_from(self.memory_limit() / (3 * size_of::<Gap>() as u64)).unwrap_or(usize::MAX);
        let ProximityScratch { gaps, places, sorted, search } = proximity;
        let mut wanted =
            Wanted::new(self.mockup(), tool, pose, self.checked_lanes(), goal, within, most, (gaps, places, sorted));
        self.store().search(search, &mut wanted);
        let fits = wanted.finish();
        let found = gaps.clone();
        if found.len() > 4096 {
            // Not to be held for ever.
            *gaps = Vec::new();
        }
        self.put_scratch(scratch);
        if fits {
            return Ok(found);
        }
        Err(Error::Memory {
            what: "the pairs within this distance",
            needed: 3 * (size_of::<Gap>() * found.len()) as u64,
            allowed: self.memory_limit(),
            advice: "ask for a smaller distance, or allow more memory",
        })
    }
}
