//! The queries on a scene, one pose at a time.

use super::{Candidate, Divider, Gap, Goal, SearchScratch, Wanted};
use crate::error::{Error, Result};
use crate::pose::Pose;
use crate::scene::Scene;
use crate::store::NearScratch;
use crate::tool::Tool;

/// Working memory of one query at a time.
#[derive(Debug, Default)]
pub struct ProximityScratch {
    /// What the last search found, sorted.
    pub gaps: Vec<Gap>,
    places: Vec<u32>,
    sorted: Vec<f64>,
    search: SearchScratch,
    near: NearScratch,
    /// Of [`Scene::near_candidates`], to be used again.
    candidates: Vec<Candidate>,
}

impl Scene {
    /// Every pair of triangles with a distance of at most `within` (metres), sorted by distance, then tool triangle, then
    /// mock-up triangle. Pairs that meet have distance 0.
    ///
    /// Errors: `within` negative or NaN, and more pairs than the memory limit of the scene allows.
    pub fn near_pairs(&self, tool: &Tool, pose: &Pose, within: f64) -> Result<Vec<Gap>> {
        check_distance("within", within)?;
        self.gaps(tool, pose, Goal::Pairs, within)
    }

    /// The closest pair of triangles of each part with a distance of at most `within` (metres), sorted as
    /// [`near_pairs`](Self::near_pairs).
    ///
    /// Of several pairs at the same distance, the one with the least ids; of several that meet, any. Errors: `within` negative
    /// or NaN.
    pub fn clearance(&self, tool: &Tool, pose: &Pose, within: f64) -> Result<Vec<Gap>> {
        check_distance("within", within)?;
        self.gaps(tool, pose, Goal::Parts, within)
    }

    /// The closest pair of triangles of each of the `k` closest parts, but none farther than `max` (metres); sorted as
    /// [`near_pairs`](Self::near_pairs). With `k` = 1 the first entry is the minimum distance; no entry: nothing within `max`.
    ///
    /// Of several pairs at the same distance, the one with the least ids; of several that meet, any, and of more than `k`
    /// parts that meet the tool, any `k`. Errors: `max` negative or NaN, and `k` zero.
    pub fn distance(&self, tool: &Tool, pose: &Pose, max: f64, k: usize) -> Result<Vec<Gap>> {
        check_distance("max", max)?;
        if k == 0 {
            return Err(Error::NoneAsked { what: "k" });
        }
        self.gaps(tool, pose, Goal::Nearest(k), max)
    }

    /// The closest pair of triangles, `None` when all are farther than `max` (metres): [`distance`](Self::distance) with `k` = 1,
    /// allocating nothing.
    pub fn closest(&self, tool: &Tool, pose: &Pose, max: f64) -> Result<Option<Gap>> {
        check_distance("max", max)?;
        let mut scratch = self.take_scratch();
        self.find_gaps(tool, pose, Goal::Nearest(1), max, &mut scratch.proximity);
        let found = scratch.proximity.gaps.first().copied();
        self.put_scratch(scratch);
        Ok(found)
    }

    /// Pairs that may be within a distance (metres, not checked), in no order but always the same; without most of those whose
    /// pieces `dividers` (sorted by part) hold apart. `None` where they are more than `most`.
    ///
    /// Errors: more of them than the memory limit of the scene allows.
    pub(crate) fn near_candidates(
        &self,
        tool: &Tool,
        pose: &Pose,
        within: f64,
        dividers: &[Divider],
        most: usize,
    ) -> Result<Option<Vec<Candidate>>> {
        let mut scratch = self.take_scratch();
        let ProximityScratch { gaps, places, sorted, search, near, candidates } = &mut scratch.proximity;
        let (allowed, lanes) = (self.most_gaps(), self.checked_lanes());
        let lists = (gaps, places, sorted);
        let limit = most.min(allowed);
        let mut wanted = Wanted::new(self.mockup(), tool, pose, lanes, Goal::Candidates, within, limit, lists);
        wanted.collect_into(std::mem::take(candidates));
        wanted.dividers = dividers;
        self.store().search(search, near, &mut wanted);
        let found = wanted.collect_into(Vec::new());
        self.put_scratch(scratch);
        if found.len() > allowed {
            return Err(self.too_many_gaps(found.len()));
        }
        Ok((found.len() <= most).then_some(found))
    }

    /// Gives the list back, for the next query to use its memory. A long list is not held for ever.
    pub(crate) fn put_candidates(&self, mut list: Vec<Candidate>) {
        if list.capacity() <= 1 << 16 {
            list.clear();
            let mut scratch = self.take_scratch();
            scratch.proximity.candidates = list;
            self.put_scratch(scratch);
        }
    }

    fn gaps(&self, tool: &Tool, pose: &Pose, goal: Goal, within: f64) -> Result<Vec<Gap>> {
        let mut scratch = self.take_scratch();
        let fits = self.find_gaps(tool, pose, goal, within, &mut scratch.proximity);
        let gaps = &mut scratch.proximity.gaps;
        // A long list is handed over, not held for ever.
        let found = if gaps.len() > 4096 { std::mem::take(gaps) } else { gaps.clone() };
        self.put_scratch(scratch);
        if fits {
            return Ok(found);
        }
        Err(self.too_many_gaps(found.len()))
    }

    /// One search: `scratch.gaps` afterwards holds what was found. False when there was more than memory allows.
    pub(super) fn find_gaps(
        &self,
        tool: &Tool,
        pose: &Pose,
        goal: Goal,
        within: f64,
        scratch: &mut ProximityScratch,
    ) -> bool {
        let ProximityScratch { gaps, places, sorted, search, near, .. } = scratch;
        let most = self.most_gaps();
        let mut wanted =
            Wanted::new(self.mockup(), tool, pose, self.checked_lanes(), goal, within, most, (gaps, places, sorted));
        self.store().search(search, near, &mut wanted);
        wanted.finish()
    }

    /// How many gaps a result may hold. Growing vectors hold up to three times their content.
    pub(super) fn most_gaps(&self) -> usize {
        usize::try_from(self.memory_limit() / (3 * size_of::<Gap>() as u64)).unwrap_or(usize::MAX)
    }

    pub(super) fn too_many_gaps(&self, count: usize) -> Error {
        Error::Memory {
            what: "the pairs within this distance",
            needed: 3 * (size_of::<Gap>() as u64) * count as u64,
            allowed: self.memory_limit(),
            advice: "ask for a smaller distance, pass fewer poses at a time, or allow more memory",
        }
    }
}

pub(super) fn check_distance(what: &'static str, value: f64) -> Result<()> {
    // Written so that NaN fails.
    if value >= 0.0 {
        return Ok(());
    }
    Err(Error::Distance { what, value })
}
